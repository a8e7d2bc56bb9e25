//! Describes TOML values for messages.

use toml::de::DeValue;

/// The value as written in the file.
pub fn found_value(value: &DeValue<'_>) -> String {
    match value {
        DeValue::String(text) => format!("\"{text}\""),
        DeValue::Integer(integer) => integer.to_string(),
        DeValue::Float(float) => float.as_str().to_owned(),
        DeValue::Boolean(on) => on.to_string(),
        other => format!("{} {}", article(other.type_str()), other.type_str()),
    }
}

/// The type of the value, with the value itself if it is short.
pub fn found(value: &DeValue<'_>) -> String {
    match value {
        DeValue::String(_) => format!("the text {}", found_value(value)),
        DeValue::Integer(_) | DeValue::Float(_) => format!("the number {}", found_value(value)),
        _ => found_value(value),
    }
}

fn article(noun: &str) -> &'static str {
    if noun.starts_with(['a', 'e', 'i', 'o', 'u']) {
        "an"
    } else {
        "a"
    }
}
