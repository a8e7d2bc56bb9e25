//! Quantities in texts: numbers, or several with one unit, followed by the unit.

use std::borrow::Cow;
use std::ops::Range;

use nailnoise_quantities::rounded;

use super::factors::{Conversion, to_us};

/// Most numbers that share one unit.
const MOST: usize = 8;

/// Largest ratio of the sizes of numbers that have the same decimals without having them in the metric unit.
const SPREAD: f64 = 100.0;

/// Fewest significant digits of a converted number.
const DIGITS: i32 = 3;

/// Texts between numbers that share a unit.
const BETWEEN: [&str; 12] = [
    " .. ",
    " to ",
    " x ",
    " \u{d7} ",
    " and ",
    " or ",
    ", ",
    " \u{2013} ",
    "..",
    "\u{2013}",
    " / ",
    " by ",
];

/// Units of two words, also with raised digits.
const TWO_WORDS: [&str; 6] = ["N s/mm", "N s/m", "N m", "W/(m2 K)", "W/(m\u{b2} K)", "J/(kg K)"];

/// A text with its quantities in units of the United States, on a page with raised digits.
pub(super) fn converted(text: &str, on_page: bool) -> Cow<'_, str> {
    let mut shown = String::new();
    let (mut at, mut copied, mut code) = (0, 0, false);
    while let Some(letter) = text[at..].chars().next() {
        code ^= letter == '`';
        match (!code && begins(text, at)).then(|| Quantities::at(text, at)).flatten() {
            Some(found) => {
                shown.push_str(&text[copied..at]);
                at = found.end;
                copied = at;
                found.write(text, on_page, &mut shown);
            }
            None => at += letter.len_utf8(),
        }
    }
    if copied == 0 {
        return Cow::Borrowed(text);
    }
    shown.push_str(&text[copied..]);
    Cow::Owned(shown)
}

/// The numbers of a cell whose unit is in its heading, with this number of decimals if given; `None` if the cell
/// contains anything else.
pub(crate) fn numbers(text: &str, conversion: Conversion, decimals: Option<usize>) -> Option<String> {
    let numbers = list(text)?;
    let mut shown = text[..numbers.first()?.start].to_owned();
    write_numbers(text, &numbers, conversion, decimals, &mut shown);
    Some(shown)
}

/// Writes the numbers of a text converted, and the text from the first to the last of them as it is.
fn write_numbers(
    text: &str,
    numbers: &[Range<usize>],
    conversion: Conversion,
    decimals: Option<usize>,
    shown: &mut String,
) {
    let mut copied = numbers.first().map_or(0, |first| first.start);
    for own in numbers {
        shown.push_str(&text[copied..own.start]);
        let exact = exact(text, own.start);
        shown.push_str(&number(&text[own.clone()], conversion, exact, decimals));
        copied = own.end;
    }
}

/// The number of decimals of the numbers of cells that share a unit; see [`common_decimals`].
pub(crate) fn decimals_of_cells<'a>(cells: impl Iterator<Item = &'a str>, conversion: Conversion) -> Option<usize> {
    let texts = cells.flat_map(|cell| list(cell).unwrap_or_default().into_iter().map(move |own| &cell[own]));
    common_decimals(texts.collect(), conversion)
}

/// The number of decimals at which numbers with one unit are shown alike: that of the largest, or more, so that the
/// smallest has its digits. `None` if there is no such number: exponents, or sizes that differ too much and do not have
/// the same decimals in the metric unit.
fn common_decimals(mut texts: Vec<&str>, conversion: Conversion) -> Option<usize> {
    if texts.iter().any(|text| text.contains(['e', 'E'])) {
        return None;
    }
    texts.sort_by(|a, b| size(a).unwrap_or(0.0).total_cmp(&size(b).unwrap_or(0.0)));
    let largest = texts.last()?;
    let converted = |text: &str| Some(conversion.of(size(text)?));
    let own = decimals(largest, converted(largest)?, conversion)?;
    let alike = texts.iter().all(|text| fraction(text) == fraction(largest));
    let smallest = texts.iter().find(|text| size(text).is_some_and(|size| size > 0.0))?;
    let needed = (DIGITS - 1 - converted(smallest)?.abs().log10().floor() as i32).max(0) as usize;
    match conversion.offset {
        0.0 if !alike && size(largest)? > SPREAD * size(smallest)? => None,
        0.0 if !alike => Some(own.max(needed)),
        _ => Some(own),
    }
}

/// The largest magnitude of the numbers of a cell that contains only numbers.
pub(crate) fn largest(text: &str) -> Option<f64> {
    let numbers = list(text)?;
    numbers.into_iter().filter_map(|own| size(&text[own])).reduce(f64::max)
}

/// The places of the numbers of a text that has nothing else.
fn list(text: &str) -> Option<Vec<Range<usize>>> {
    let mut numbers = Vec::new();
    let mut at = text.len() - text.trim_start_matches(['\u{b1}', '+']).len();
    loop {
        let own = number_at(text, at)?;
        let rest = &text[own.end..];
        at = own.end;
        numbers.push(own);
        if rest.is_empty() {
            return Some(numbers);
        }
        at += between(rest)?;
    }
}

/// Numbers that share a unit.
struct Quantities {
    numbers: Vec<Range<usize>>,
    conversion: Conversion,
    end: usize,
}

impl Quantities {
    /// The quantities that begin at this place.
    fn at(text: &str, mut at: usize) -> Option<Self> {
        // "dB re 1 m/s": a reference value.
        let before = text[..at].strip_suffix("re ");
        if before.is_some_and(|before| !before.ends_with(char::is_alphabetic)) {
            return None;
        }
        let mut numbers = Vec::new();
        while numbers.len() < MOST {
            let own = number_at(text, at)?;
            let rest = &text[own.end..];
            at = own.end;
            numbers.push(own);
            let largest = numbers
                .iter()
                .filter_map(|own| size(&text[own.clone()]))
                .reduce(f64::max)?;
            if let Some((unit, length)) = unit_at(rest)
                && let Some(conversion) = to_us(&plain(unit), largest)
            {
                return Some(Self {
                    conversion,
                    end: at + length,
                    numbers,
                });
            }
            at += between(rest)?;
        }
        None
    }

    fn write(&self, text: &str, on_page: bool, shown: &mut String) {
        let decimals = common_decimals(
            self.numbers.iter().map(|own| &text[own.clone()]).collect(),
            self.conversion,
        );
        write_numbers(text, &self.numbers, self.conversion, decimals, shown);
        shown.push(' ');
        match on_page {
            true => shown.push_str(&self.conversion.unit.replace('2', "\u{b2}").replace('3', "\u{b3}")),
            false => shown.push_str(self.conversion.unit),
        }
    }
}

/// Whether a number can begin here: not within a word, a name, a larger number or quotation marks.
fn begins(text: &str, at: usize) -> bool {
    let mut before = text[..at].chars().rev();
    let digit = |at: usize| text[at..].starts_with(|letter: char| letter.is_ascii_digit());
    let signed = text[at..].starts_with(['-', '+', '\u{2212}']);
    let apart = match before.next() {
        None | Some('(' | '[' | '\u{b1}' | '<' | '>' | '\u{2264}' | '\u{2265}' | '~' | '|') => true,
        Some(letter) if letter.is_whitespace() => true,
        // The tolerance "+-2 mm".
        Some('-') => before.next() == Some('+') && digit(at),
        _ => false,
    };
    apart && (signed || digit(at))
}

/// A number with its sign: digits, a fraction, an exponent.
fn number_at(text: &str, at: usize) -> Option<Range<usize>> {
    let bytes = text.as_bytes();
    let digits = |from: usize| from + bytes[from..].iter().take_while(|byte| byte.is_ascii_digit()).count();
    let sign = text[at..]
        .chars()
        .next()
        .filter(|letter| matches!(letter, '-' | '+' | '\u{2212}'));
    let start = at + sign.map_or(0, char::len_utf8);
    let mut end = digits(start);
    if end == start {
        return None;
    }
    if bytes.get(end) == Some(&b'.') && digits(end + 1) > end + 1 {
        end = digits(end + 1);
    }
    if matches!(bytes.get(end), Some(b'e' | b'E')) {
        let signed = end + 1 + usize::from(matches!(bytes.get(end + 1), Some(b'-' | b'+')));
        if signed <= bytes.len() && digits(signed) > signed {
            end = digits(signed);
        }
    }
    Some(at..end)
}

/// The unit after a number, and the length of the space and the unit.
fn unit_at(rest: &str) -> Option<(&str, usize)> {
    let rest = rest.strip_prefix([' ', '\u{a0}'])?;
    let ends = |unit: &str| {
        rest.strip_prefix(unit).is_some_and(|behind| {
            !behind.starts_with(|letter: char| letter.is_alphanumeric() || matches!(letter, '_' | '(' | '^' | '/'))
        })
    };
    if let Some(unit) = TWO_WORDS.iter().find(|unit| ends(unit)) {
        return Some((unit, unit.len() + 1));
    }
    let end = rest.find(|letter: char| !(letter.is_alphanumeric() || matches!(letter, '/' | '\u{b2}' | '\u{b3}')));
    let unit = &rest[..end.unwrap_or(rest.len())];
    let behind = &rest[unit.len()..];
    let product = behind.starts_with(['_', '(', '^', '\u{b7}']) || behind.starts_with(" s/");
    // Sound pressures are in pascals everywhere.
    (!unit.is_empty() && unit != "Pa" && !product).then_some((unit, unit.len() + 1))
}

/// The length of a text between two numbers, with the name of the second: ", y = ".
fn between(rest: &str) -> Option<usize> {
    let joint = BETWEEN.iter().find(|joint| rest.starts_with(**joint))?;
    let name = rest[joint.len()..].split_once(" = ").map_or("", |(name, _)| name);
    let named = name.len() == 1 && name.starts_with(|letter: char| letter.is_ascii_lowercase());
    Some(joint.len() + if named { 4 } else { 0 })
}

/// A unit without raised digits and the sign for micro.
fn plain(unit: &str) -> String {
    let unit = unit.replace('\u{b2}', "2").replace('\u{b3}', "3");
    unit.replace(['\u{b5}', '\u{3bc}'], "u").replace("\u{b0}C", "degC")
}

/// Whether the number here is a value; a tolerance has no offset.
fn exact(text: &str, at: usize) -> bool {
    !(text[..at].ends_with("+-") || text[..at].ends_with('\u{b1}'))
}

fn size(number: &str) -> Option<f64> {
    let number: f64 = number.replace('\u{2212}', "-").parse().ok()?;
    Some(number.abs())
}

/// Number of decimals of a number as it is written.
fn fraction(text: &str) -> usize {
    text.split_once('.').map_or(0, |(_, fraction)| fraction.len())
}

/// Number of decimals of a converted number: the resolution of the original, and at least three digits; `None` for zero
/// without an offset, which is written as it was.
fn decimals(text: &str, own: f64, conversion: Conversion) -> Option<usize> {
    let decimals = fraction(text);
    let step = 2.0 * 10f64.powi(-(decimals as i32)) * conversion.factor;
    let resolved = (-step.log10() - 1e-9).ceil().max(0.0) as i32;
    let digits = match conversion.offset {
        0.0 if own != 0.0 => DIGITS - 1 - own.abs().log10().floor() as i32,
        0.0 => return None,
        _ => 0,
    };
    // A value in pascals resolves more than it states.
    let stated = text
        .trim_start_matches(['-', '\u{2212}', '+', '0', '.'])
        .replace('.', "");
    let stated = if decimals > 0 {
        stated.len()
    } else {
        stated.trim_end_matches('0').len()
    };
    let most = digits + 1 + (stated as i32 - DIGITS).max(0);
    let resolved = if conversion.offset == 0.0 {
        resolved.min(most)
    } else {
        resolved
    };
    Some(resolved.max(digits).max(0) as usize)
}

/// A converted number with these decimals, or else with the resolution of the original and at least three digits.
fn number(text: &str, conversion: Conversion, exact: bool, given: Option<usize>) -> String {
    let typeset = text.starts_with('\u{2212}');
    let plain = text.replace('\u{2212}', "-");
    let Ok(value) = plain.parse::<f64>() else {
        return text.to_owned();
    };
    let own = if exact {
        conversion.of(value)
    } else {
        conversion.factor * value
    };
    // A zero without decimals is exact.
    if value == 0.0 && conversion.offset == 0.0 && !plain.contains('.') {
        return text.to_owned();
    }
    let shown = if plain.contains(['e', 'E']) {
        rounded(own, DIGITS as usize + 1, 1e5)
    } else {
        match given.or_else(|| decimals(&plain, own, conversion)) {
            Some(decimals) => format!("{own:.decimals$}"),
            None => return text.to_owned(),
        }
    };
    let shown = if plain.starts_with('+') && own > 0.0 {
        format!("+{shown}")
    } else {
        shown
    };
    if typeset { shown.replace('-', "\u{2212}") } else { shown }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn quantities_are_converted_with_the_digits_that_they_resolve() {
        for (si, us) in [
            (
                "head 4.0 mm deep, 8.0 J left at flush",
                "head 0.157 in deep, 5.90 ft-lbf left at flush",
            ),
            ("ends where 5.0 mm are allowed", "ends where 0.197 in are allowed"),
            ("1.97 L of air a shot", "0.0696 ft3 of air a shot"),
            ("763 kPa absolute", "110.7 psi absolute"),
            ("10.226 kN", "2298.9 lbf"),
            ("2.260 g", "0.07972 oz"),
            ("1.2 kg, 23.45 m/s", "2.65 lb, 76.94 ft/s"),
            ("20 degC", "68 degF"),
            ("293.15 K", "68.00 degF"),
            ("5.1e5 N/mm", "2.912e6 lbf/in"),
            ("450 kg/m3", "28.1 lb/ft3"),
            ("0.0 mm", "0.0 in"),
            ("-4.02 mm", "-0.1583 in"),
            ("\u{2212}4.02 mm", "\u{2212}0.1583 in"),
            ("+1.0 mm", "+0.0394 in"),
            ("+-2 mm", "+-0.0787 in"),
            ("20 degC +-2 degC", "68 degF +-4 degF"),
            ("12 N s/m", "0.0685 lbf s/in"),
            ("1.10E8 N/mm", "6.281e8 lbf/in"),
            ("12 cm3", "0.732 in3"),
            ("20 .. 200 W/(m2 K)", "3.5 .. 35.2 Btu/(h ft2 degF)"),
            ("287.1 J/(kg K)", "53.36 ft-lbf/(lb degR)"),
            ("7 bar (101.5 psig)", "102 psi (101.5 psig)"),
        ] {
            assert_eq!(converted(si, false), us, "{si}");
        }
    }

    #[test]
    fn numbers_that_share_a_unit_are_converted_together() {
        for (si, us) in [
            ("300 x 38 x 38 mm", "11.81 x 1.50 x 1.50 in"),
            ("5.64 .. 8.74 mm", "0.2220 .. 0.3441 in"),
            ("x = 0.30, y = 0.20, z = 1.50 m", "x = 0.98, y = 0.66, z = 4.92 ft"),
            ("0.30 and 0.40 m", "11.8 and 15.7 in"),
            ("70 to 120 mm", "2.76 to 4.72 in"),
            ("121 .. 121.5 mm", "4.764 .. 4.783 in"),
            ("0 .. 40 mm2", "0 .. 0.0620 in2"),
        ] {
            assert_eq!(converted(si, false), us, "{si}");
        }
    }

    #[test]
    fn names_input_levels_and_other_units_stay() {
        for text in [
            "L_WA,1s 102 dB re 1 pW s, 500 Hz, 12.4 ms",
            "run `nailnoise run a.toml --set nail.length=60 mm`",
            "nail.length = \"60 mm\"",
            "velocity, dB re 5e-8 m/s",
            "n80cb-2 mm, t12 m, 3x4 mm2x",
            "20 uPa, 2 Pa, 1 pW, 4 Pa s/m2, 3 N s/m3",
            "0.5 K of scatter, 12 draws, 5 L_WA",
        ] {
            assert_eq!(converted(text, false), text);
        }
    }

    #[test]
    fn units_of_a_page_have_raised_digits() {
        assert_eq!(
            converted("40 mm\u{b2}, 1.97 L", true),
            "0.0620 in\u{b2}, 0.0696 ft\u{b3}"
        );
    }

    #[test]
    fn a_text_is_converted_once() {
        let si = "head 4.0 mm deep, 8.0 J, 1.97 L, 763 kPa, 20 degC, 300 x 38 x 38 mm, 450 kg/m3, 2 m/s, 5 m";
        let us = converted(si, false).into_owned();
        assert_eq!(converted(&us, false), us);
    }
}
