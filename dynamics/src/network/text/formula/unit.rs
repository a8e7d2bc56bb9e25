//! The unit that follows a number in a formula.

use nailnoise_quantities::Dimension;

/// Length in bytes of the unit at the start of `text`, including leading blanks; 0 if there is none.
///
/// A symbol followed by `.`, `(` or `_` is a name, not a unit. A quotient continues only with a unit, in brackets or
/// not.
pub(super) fn length(text: &str) -> usize {
    let mut end = 0;
    let mut accepted = 0;
    let mut first = true;
    loop {
        let blank = blanks(&text[end..]);
        let divided = !first && text[end + blank..].starts_with('/');
        let start = end + blank + usize::from(divided);
        let start = start + blanks(&text[start..]);
        let part = match text[start..].strip_prefix('(') {
            Some(inner) if divided => bracket(inner),
            _ => symbol(&text[start..]),
        };
        if part == 0 || Dimension::of_unit(text[..start + part].trim()).is_err() {
            return accepted;
        }
        end = start + part;
        accepted = end;
        first = false;
    }
}

fn blanks(text: &str) -> usize {
    text.len() - text.trim_start().len()
}

/// Length of a symbol with its exponent; 0 for a name.
fn symbol(text: &str) -> usize {
    let letters = text
        .find(|c: char| !(c.is_alphabetic() || matches!(c, '%' | '°' | 'µ')))
        .unwrap_or(text.len());
    let mut end = letters;
    let rest = &text[end..];
    let sign = rest
        .strip_prefix("^-")
        .or_else(|| rest.strip_prefix('^'))
        .map_or(0, |after| rest.len() - after.len());
    let digits = text[end + sign..].bytes().take_while(u8::is_ascii_digit).count();
    if digits > 0 {
        end += sign + digits;
    } else if text[end..].starts_with(['²', '³']) {
        end += '²'.len_utf8();
    }
    let is_name = text[end..].starts_with(|c: char| c.is_alphanumeric() || matches!(c, '_' | '.' | '('));
    if letters == 0 || is_name { 0 } else { end }
}

/// Length of units in brackets with both brackets, `inner` after the first; 0 for another term.
fn bracket(inner: &str) -> usize {
    inner
        .find(')')
        .filter(|end| Dimension::of_unit(&inner[..*end]).is_ok() && !inner[..*end].trim().is_empty())
        .map_or(0, |end| end + 2)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn units_end_where_the_formula_goes_on() {
        for (text, unit) in [
            (" um", " um"),
            (" m/s and x", " m/s"),
            (" N s/m*2", " N s/m"),
            (" W/(m2 K)/2", " W/(m2 K)"),
            (" mm/piston.stroke", " mm"),
            (" mm/(a + b)", " mm"),
            (" mm^2 + 1", " mm^2"),
            (" min(1, 2)", ""),
            (" s_x", ""),
            ("", ""),
            (" kg m2/s2", " kg m2/s2"),
        ] {
            assert_eq!(&text[..length(text)], unit, "{text}");
        }
    }
}
