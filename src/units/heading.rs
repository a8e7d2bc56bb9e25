//! Units in headings: the last word, which may be in brackets.

use super::Conversion;

/// The last word of a heading without brackets.
pub(crate) fn unit_of(heading: &str) -> &str {
    let last = heading.rsplit(' ').next().unwrap_or_default();
    last.trim_start_matches(['[', '(']).trim_end_matches([']', ')'])
}

/// A heading with the unit of the conversion in place of its last word.
pub(crate) fn renamed(heading: &str, conversion: Conversion) -> String {
    let unit = unit_of(heading);
    let place = heading.rfind(unit).unwrap_or(heading.len());
    let behind = &heading[place + unit.len()..];
    format!("{}{}{behind}", &heading[..place], conversion.unit)
}
