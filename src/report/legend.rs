//! Legends of charts, and texts with subscripts.

use maud::{Markup, PreEscaped, html};

use super::table::typeset;
use crate::figures::{Panel, Shape, subscripts};

/// A text with the signs of a page, and with the subscripts of `L_{WA}`, `L_WA,1s` or `N_max` set low.
pub(super) fn marked(text: &str) -> Markup {
    let set = symbols(&typeset(text));
    let escaped = html! { (set) }.into_string();
    PreEscaped(subscripts(&escaped, "<sub>", "</sub>"))
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

/// Entries for the series that have a name.
pub(super) fn legend(panel: &Panel) -> Markup {
    let named = panel.series.iter().enumerate().filter(|(_, own)| !own.name.is_empty());
    html! {
        div.legend { @for (place, series) in named {
            button type="button" class={ "key c" (series.colour) " " (sample(&series.shape)) } data-series=(place)
                aria-pressed="true" {
                (marked(&series.name))
            }
        } }
    }
}

fn sample(shape: &Shape) -> &'static str {
    match shape {
        Shape::Line | Shape::Steps | Shape::Errors(_) => "line",
        Shape::Broad => "broad",
        Shape::Dashed => "dashed",
        Shape::Points => "dots",
        Shape::Bars(_) | Shape::Spans(_) | Shape::Swings(_) => "area",
        Shape::Band(_) | Shape::Whiskers(_) => "pale",
    }
}

#[cfg(test)]
mod tests {
    use super::*;

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
            assert_eq!(marked(plain).into_string(), set);
        }
    }
}
