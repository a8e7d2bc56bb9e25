//! Typography of pages: signs, subscripts and code in texts that the terminal shows plain.

use maud::{Markup, PreEscaped, html};

use crate::figures::subscripts;

/// Characters in the terminal, and their typeset form on a page.
const TYPESET: [(&str, &str); 21] = [
    ("+-", "\u{b1}"),
    ("<= ", "\u{2264} "),
    (">= ", "\u{2265} "),
    ("dB2", "dB\u{b2}"),
    ("Q2", "Q\u{b2}"),
    (" m2", " m\u{b2}"),
    ("mm2", "mm\u{b2}"),
    ("cm3", "cm\u{b3}"),
    ("/m3", "/m\u{b3}"),
    ("/m2", "/m\u{b2}"),
    ("(m2", "(m\u{b2}"),
    ("/ft3", "/ft\u{b3}"),
    (" ft3", " ft\u{b3}"),
    ("[ft3", "[ft\u{b3}"),
    ("[m3", "[m\u{b3}"),
    ("[m2", "[m\u{b2}"),
    ("[in2", "[in\u{b2}"),
    ("m/s2", "m/s\u{b2}"),
    ("m\u{b2}/s2", "m\u{b2}/s\u{b2}"),
    (" um", " \u{b5}m"),
    (" -> ", " \u{2192} "),
];

/// A text with the signs of a page, and with the subscripts of `L_{WA}`, `L_WA,1s` or `N_max` set low.
pub(super) fn with_subscripts(text: &str) -> Markup {
    let set = symbols(&typeset(text));
    let escaped = html! { (set) }.into_string();
    PreEscaped(subscripts(&escaped, "<sub>", "</sub>"))
}

/// How a part of a text is set.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Setting {
    /// In the line.
    Plain,
    /// As a subscript.
    Low,
    /// As code: words between backticks.
    Code,
}

/// The parts of a text with the signs of a page.
pub(super) fn parts(text: &str) -> Vec<(String, Setting)> {
    let mut parts = Vec::new();
    for (place, part) in text.split('`').enumerate() {
        match place % 2 {
            1 => parts.push((part.to_owned(), Setting::Code)),
            _ => parts.extend(with_low(part)),
        }
    }
    parts.retain(|(part, _)| !part.is_empty());
    parts
}

/// The parts of a text without code.
fn with_low(text: &str) -> Vec<(String, Setting)> {
    const ENDS: [&str; 2] = ["\u{2}", "\u{3}"];
    let [before, after] = ENDS;
    let marked = subscripts(&symbols(&typeset(text)), before, after);
    let mut parts = Vec::new();
    for part in marked.split(before) {
        let (low, plain) = part.split_once(after).unwrap_or(("", part));
        parts.push((low.to_owned(), Setting::Low));
        parts.push((plain.to_owned(), Setting::Plain));
    }
    parts
}

/// A text whose symbols of one letter and `_` have their subscript in braces: `L_{WA,1s}` for `L_WA,1s`. Names of keys
/// and files, which have more letters before the sign or a full stop, stay as they are.
fn symbols(text: &str) -> String {
    let letters: Vec<char> = text.chars().collect();
    let part_of_word = |letter: char| letter.is_alphanumeric() || matches!(letter, '_' | '.' | '}');
    let mut set = String::with_capacity(text.len());
    let mut at = 0;
    while at < letters.len() {
        let alone = letters[at].is_ascii_alphabetic() && (at == 0 || !part_of_word(letters[at - 1]));
        let end = (at + 2..letters.len()).find(|&end| {
            let comma = letters[end] == ',' && letters.get(end + 1).is_some_and(|next| next.is_alphanumeric());
            !(letters[end].is_alphanumeric() || comma)
        });
        let end = end.unwrap_or(letters.len());
        if alone && letters.get(at + 1) == Some(&'_') && end > at + 2 {
            let below: String = letters[at + 2..end].iter().collect();
            set.push_str(&format!("{}_{{{below}}}", letters[at]));
            at = end;
        } else {
            set.push(letters[at]);
            at += 1;
        }
    }
    set
}

/// A sentence with a capital first letter. A key, a symbol or the name before a colon keeps its letters.
pub(crate) fn capitalised(text: &str) -> String {
    let first = text.split(' ').next().unwrap_or_default();
    if first.ends_with(':') || first.trim_end_matches(['.', ',']).contains(['.', '_', '=']) {
        return text.to_owned();
    }
    let mut letters = text.chars();
    letters
        .next()
        .map_or_else(String::new, |first| first.to_uppercase().chain(letters).collect())
}

/// A line of plain text in which words between backticks become code.
pub(crate) fn with_code(line: &str) -> Markup {
    let parts = line.split('`').enumerate();
    html! { @for (place, part) in parts { @if place % 2 == 1 { code { (part) } } @else { (with_subscripts(part)) } } }
}

/// A terminal text with typeset signs: an en dash for a missing value, minus signs before digits.
pub(super) fn typeset(text: &str) -> String {
    if text == "-" {
        return "\u{2013}".to_owned();
    }
    let text = TYPESET
        .iter()
        .fold(text.to_owned(), |text, (plain, set)| text.replace(plain, set));
    let mut set = String::with_capacity(text.len());
    let mut letters = text.chars().peekable();
    let mut before = ' ';
    while let Some(letter) = letters.next() {
        let number = letters.peek().is_some_and(char::is_ascii_digit);
        let sign = letter == '-' && number && matches!(before, ' ' | '(' | '/');
        set.push(if sign { '\u{2212}' } else { letter });
        before = letter;
    }
    set
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn signs_are_set_and_names_stay() {
        for (plain, set) in [
            ("-", "\u{2013}"),
            ("-0.4 .. +1.2", "\u{2212}0.4 .. +1.2"),
            ("+-0.3", "\u{b1}0.3"),
            ("<= 92.00", "\u{2264} 92.00"),
            ("-1.0 / -2.0", "\u{2212}1.0 / \u{2212}2.0"),
            ("n80cb-2", "n80cb-2"),
            ("variance 2.0 dB2", "variance 2.0 dB\u{b2}"),
            ("air a shot [ft3], 9.81 m/s2", "air a shot [ft\u{b3}], 9.81 m/s\u{b2}"),
            ("26.8 lb/ft3, 200 W/(m2 K)", "26.8 lb/ft\u{b3}, 200 W/(m\u{b2} K)"),
            ("20000 Pa s/m2", "20000 Pa s/m\u{b2}"),
            ("300 cm3 -> 500 cm3", "300 cm\u{b3} \u{2192} 500 cm\u{b3}"),
        ] {
            assert_eq!(typeset(plain), set);
        }
    }

    #[test]
    fn the_parts_of_a_text_are_plain_low_or_code() {
        let found = parts("L_WA,1s >= 102 dB, L_pC,peak: `study.n_max` is 0");
        let found: Vec<(&str, Setting)> = found.iter().map(|(part, setting)| (part.as_str(), *setting)).collect();
        let expected = [
            ("L", Setting::Plain),
            ("WA,1s", Setting::Low),
            (" \u{2265} 102 dB, L", Setting::Plain),
            ("pC,peak", Setting::Low),
            (": ", Setting::Plain),
            ("study.n_max", Setting::Code),
            (" is 0", Setting::Plain),
        ];
        assert_eq!(found, expected);
    }

    #[test]
    fn symbols_have_subscripts_and_keys_have_none() {
        for (plain, set) in [
            (
                "L_WA,1s 102 dB, L_pC,peak",
                "L<sub>WA,1s</sub> 102 dB, L<sub>pC,peak</sub>",
            ),
            ("L_{WA,1s} +-0.3", "L<sub>WA,1s</sub> \u{b1}0.3"),
            ("N_max < 3", "N<sub>max</sub> &lt; 3"),
            ("wood.elastic.e_r, hose_area, a_", "wood.elastic.e_r, hose_area, a_"),
        ] {
            assert_eq!(with_subscripts(plain).into_string(), set);
        }
    }
}
