//! Units in headings: the last word, or the text in brackets at the end.

use super::Conversion;

/// The unit at the end of a heading: the text in square brackets, or else the last word without brackets.
pub(crate) fn unit_of(heading: &str) -> &str {
    let in_brackets = heading.strip_suffix(']').and_then(|text| text.rsplit_once('['));
    if let Some((_, unit)) = in_brackets {
        return unit;
    }
    let last = heading.rsplit(' ').next().unwrap_or_default();
    last.trim_start_matches('(').trim_end_matches(')')
}

/// A heading with the unit of the conversion in place of its own.
pub(crate) fn renamed(heading: &str, conversion: Conversion) -> String {
    let unit = unit_of(heading);
    let place = heading.rfind(unit).unwrap_or(heading.len());
    let behind = &heading[place + unit.len()..];
    format!("{}{}{behind}", &heading[..place], conversion.unit)
}
