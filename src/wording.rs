//! Text for numbers, changes of levels, uncertainty bands and the ranking; the same in tables and pages.

use std::borrow::Cow;

pub(crate) use nailnoise_pipeline::store::hexadecimal;
pub(crate) use nailnoise_quantities::rounded;

/// A text that is safe to show in a terminal: control characters, which could move its cursor or set its title, and
/// characters that reverse the writing direction are escaped. With `colours`, the colour sequences `ESC [ ... m` are
/// left unchanged.
///
/// Names and contents of files are chosen by others and may contain any characters.
pub(crate) fn visible(text: &str, colours: bool) -> Cow<'_, str> {
    let hidden = |letter: char| {
        letter.is_control() && !matches!(letter, '\n' | '\t')
            || matches!(letter, '\u{200e}' | '\u{200f}' | '\u{202a}'..='\u{202e}' | '\u{2066}'..='\u{2069}')
    };
    if !text.contains(hidden) {
        return Cow::Borrowed(text);
    }
    let mut shown = String::with_capacity(text.len());
    let mut rest = text;
    while let Some(place) = rest.find(hidden) {
        shown.push_str(&rest[..place]);
        rest = &rest[place..];
        let colour = colours.then(|| colour(rest)).flatten();
        if let Some(length) = colour {
            shown.push_str(&rest[..length]);
            rest = &rest[length..];
        } else if let Some(letter) = rest.chars().next() {
            shown.extend(letter.escape_default());
            rest = &rest[letter.len_utf8()..];
        }
    }
    shown.push_str(rest);
    Cow::Owned(shown)
}

/// Length of a colour sequence at the beginning of a text.
fn colour(text: &str) -> Option<usize> {
    let parameters = text.strip_prefix("\u{1b}[")?;
    let end = parameters.find(|letter: char| !(letter.is_ascii_digit() || letter == ';'))?;
    parameters[end..].starts_with('m').then_some(2 + end + 1)
}

/// A number rounded to some decimals, without a sign if it rounds to zero.
pub(crate) fn fixed(value: f64, decimals: usize) -> String {
    let text = format!("{value:.decimals$}");
    match text.strip_prefix('-') {
        Some(zero) if zero.chars().all(|letter| matches!(letter, '0' | '.')) => zero.to_owned(),
        _ => text,
    }
}

/// A number rounded to some decimals, without trailing zeros.
pub(crate) fn trimmed(value: f64, decimals: usize) -> String {
    let text = fixed(value, decimals);
    text.trim_end_matches('0').trim_end_matches('.').to_owned()
}

/// A change of a level with one decimal and its sign: `-0.4`, `+1.2`; `0.0` if it rounds to zero.
pub(crate) fn change(db: f64) -> String {
    let rounded = (10.0 * db).round() / 10.0;
    if rounded == 0.0 {
        "0.0".to_owned()
    } else {
        format!("{rounded:+.1}")
    }
}

/// Unit of a figure of the shot, from its name in [`nailnoise_dynamics::Summary`]; empty for counts and fractions.
pub(crate) fn unit_of_figure(figure: &str) -> &'static str {
    match figure {
        "penetration" | "head_depth" => "m",
        "full_penetration" => "s",
        "mean_drive_speed" => "m/s",
        _ if figure.starts_with("speed_") => "m/s",
        _ if figure.ends_with("_force") => "N",
        _ if figure.ends_with("_mass") => "kg",
        _ if figure.ends_with("_depth") => "m",
        _ if figure.ends_with("_energy") => "J",
        _ => "",
    }
}

/// A figure of the shot, from its name and its value in SI units, in the customary unit: mm, ms, kN, g, %.
pub(crate) fn figure(name: &str, value: f64) -> String {
    let (scale, unit, digits) = match unit_of_figure(name) {
        "m" => (1e3, " mm", 2),
        "s" => (1e3, " ms", 3),
        "N" => (1e-3, " kN", 3),
        "kg" => (1e3, " g", 3),
        "m/s" => (1.0, " m/s", 2),
        "J" => (1.0, " J", 1),
        _ if name.ends_with("_fraction") => (1e2, " %", 1),
        _ => (1.0, "", 0),
    };
    format!("{:.digits$}{unit}", scale * value)
}

/// Whether structures (block, table, tool body) were drawn, from their number.
pub(crate) fn drawn_structures(count: usize) -> String {
    match count {
        0 => "structures held".to_owned(),
        1 => "1 structure drawn".to_owned(),
        count => format!("{count} structures drawn"),
    }
}

/// A readable unit for a quantity in this SI unit, and the conversion factor: mm, ms, kN, g.
pub(crate) fn readable(unit: &str) -> (&str, f64) {
    match unit {
        "m" => ("mm", 1e3),
        "s" => ("ms", 1e3),
        "N" => ("kN", 1e-3),
        "kg" => ("g", 1e3),
        unit => (unit, 1.0),
    }
}

/// A readable unit for a quantity of this SI unit and size, and the conversion factor.
pub(crate) fn readable_at(unit: &str, size: f64) -> (&str, f64) {
    let from = |limit: f64| size.abs() >= limit;
    match unit {
        "Pa" if from(1e9) => ("GPa", 1e-9),
        "Pa" if from(1e6) => ("MPa", 1e-6),
        "Pa" if from(1e3) => ("kPa", 1e-3),
        "N" if from(1e3) => ("kN", 1e-3),
        "N/m" if from(1e6) => ("kN/mm", 1e-6),
        "N/m" if from(1e3) => ("N/mm", 1e-3),
        "kg" if from(1.0) => ("kg", 1.0),
        "m" if from(1.0) => ("m", 1.0),
        "m" if size != 0.0 && !from(1e-4) => ("um", 1e6),
        "s" if from(1.0) => ("s", 1.0),
        "m2" if from(1e-2) => ("m2", 1.0),
        "m2" => ("mm2", 1e6),
        "m3" => ("cm3", 1e6),
        "rad" => ("deg", 180.0 / std::f64::consts::PI),
        "N" => ("N", 1.0),
        unit => readable(unit),
    }
}

/// Values of one quantity in the unit of the largest, with four digits at most, and that unit.
pub(crate) fn in_one_unit<const N: usize>(unit: &str, values: [f64; N]) -> ([String; N], &str) {
    let largest = values.iter().fold(0.0, |largest: f64, value| largest.max(value.abs()));
    let (unit, factor) = readable_at(unit, largest);
    (values.map(|value| rounded(factor * value, 4, 1e5)), unit)
}

/// The band around a predicted level: `-4.0 .. +4.0`. Bounds other than zero are rounded to at least a tenth; `open`
/// means no bound.
pub(crate) fn band([minus, plus]: [Option<f64>; 2]) -> String {
    let side = |sign: char, bound: Option<f64>| match bound {
        None => "open".to_owned(),
        Some(0.0) => "0.0".to_owned(),
        Some(bound) => format!("{sign}{:.1}", bound.abs().max(0.1)),
    };
    format!("{} .. {}", side('-', minus), side('+', plus))
}

/// A source in a ranking: its name, its level \[dB\] and the band around it \[dB\].
pub(crate) type Placed<'a> = (&'a str, Option<f64>, [Option<f64>; 2]);

/// The adjacent sources in a ranking, loudest first, whose order is uncertain because their bands overlap.
pub(crate) fn order(ranking: &[Placed<'_>]) -> String {
    let overlaps = |pair: &&[Placed<'_>]| {
        let [(_, Some(above), [minus, _]), (_, Some(below), [_, plus])] = pair else {
            return false;
        };
        let lowest = minus.map_or(f64::NEG_INFINITY, |minus| above - minus);
        plus.is_none_or(|plus| below + plus > lowest)
    };
    let open: Vec<String> = ranking
        .windows(2)
        .filter(overlaps)
        .map(|pair| format!("{} and {}", pair[0].0, pair[1].0))
        .collect();
    if open.is_empty() {
        "certain, because no bands of neighbours overlap".to_owned()
    } else {
        format!("not certain between {}, because their bands overlap", open.join("; "))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn control_characters_are_shown_and_colours_stay_colours() {
        let file = "a\u{1b}]0;title\u{7}\u{1b}[2J\r\u{9b}31mb\u{202e}.wav\tc\n";
        let expected = "a\\u{1b}]0;title\\u{7}\\u{1b}[2J\\r\\u{9b}31mb\\u{202e}.wav\tc\n";
        assert_eq!(visible(file, false), expected);
        assert_eq!(visible(file, true), expected);
        let coloured = "\u{1b}[31;1merror\u{1b}[0m m/s\u{b2}";
        assert_eq!(visible(coloured, true), coloured);
        assert_eq!(visible(coloured, false), "\\u{1b}[31;1merror\\u{1b}[0m m/s\u{b2}");
    }

    #[test]
    fn a_change_that_rounds_to_zero_has_no_sign() {
        let expected = [
            (-0.04, "0.0"),
            (0.04, "0.0"),
            (0.0, "0.0"),
            (-0.06, "-0.1"),
            (1.25, "+1.3"),
        ];
        for (db, text) in expected {
            assert_eq!(change(db), text);
        }
    }

    #[test]
    fn a_figure_of_the_shot_has_the_unit_that_people_use() {
        let expected = [
            ("peak_cap_force", 10_226.3, "10.226 kN"),
            ("head_depth", -0.00402, "-4.02 mm"),
            ("exhaust_mass", 0.00226, "2.260 g"),
            ("full_penetration", 0.02117, "21.170 ms"),
            ("exhaust_choked_fraction", 0.607, "60.7 %"),
            ("cap_contacts", 8.0, "8"),
        ];
        for (name, value, text) in expected {
            assert_eq!(figure(name, value), text);
        }
    }

    #[test]
    fn a_bound_is_not_rounded_to_zero_and_a_missing_bound_is_open() {
        assert_eq!(band([Some(4.0), Some(0.04)]), "-4.0 .. +0.1");
        assert_eq!(band([None, Some(0.0)]), "open .. 0.0");
        assert_eq!(band([None, None]), "open .. open");
    }

    #[test]
    fn the_order_is_not_certain_where_bands_overlap() {
        let table = ("workpiece", Some(100.2), [Some(0.1), Some(0.1)]);
        let exhaust = |plus: Option<f64>| ("exhaust", Some(96.6), [Some(4.0), plus]);
        let body = ("body", Some(90.0), [None, Some(2.4)]);
        assert!(order(&[table, exhaust(Some(3.4)), body]).starts_with("certain"));
        assert!(order(&[table, exhaust(Some(3.6)), body]).starts_with("not certain between workpiece and exhaust,"));
        assert!(order(&[table, exhaust(None), body]).starts_with("not certain between workpiece and exhaust,"));
        assert!(order(&[body, ("silent", None, [None, None])]).starts_with("certain"));
    }
}
