//! The texts of a page.

use super::text;

/// Attributes with texts for people.
const TEXTS: [&str; 3] = ["aria-label", "title", "alt"];

/// Elements with content for the browser or for the program.
const AS_WRITTEN: [&str; 3] = ["script", "style", "code"];

/// A page with the quantities of its texts and [`TEXTS`] in units of the United States; everything else is unchanged.
pub(super) fn converted(page: &str) -> String {
    let mut shown = String::with_capacity(page.len());
    let mut rest = page;
    while let Some(place) = rest.find('<') {
        let (text, tag) = rest.split_at(place);
        shown.push_str(&text::converted(text, true));
        let element = AS_WRITTEN.iter().find(|name| is_element(tag, name));
        let end = match element {
            Some(name) => tag.find(&format!("</{name}")),
            None => tag.find('>').map(|end| end + 1),
        };
        let (own, behind) = tag.split_at(end.unwrap_or(tag.len()));
        match element {
            Some(_) => shown.push_str(own),
            None => attributes(own, &mut shown),
        }
        rest = behind;
    }
    shown.push_str(&text::converted(rest, true));
    shown
}

/// Adds a tag with its [`TEXTS`] converted.
fn attributes(tag: &str, shown: &mut String) {
    let mut rest = tag;
    while let Some((before, value)) = rest.split_once("=\"") {
        let (value, behind) = value.split_once('"').unwrap_or((value, ""));
        let name = before.rsplit(' ').next().unwrap_or_default();
        shown.push_str(before);
        shown.push_str("=\"");
        match TEXTS.contains(&name) {
            true => shown.push_str(&text::converted(value, true)),
            false => shown.push_str(value),
        }
        shown.push('"');
        rest = behind;
    }
    shown.push_str(rest);
}

/// Whether a tag opens an element of this name.
fn is_element(tag: &str, name: &str) -> bool {
    let behind = tag[1..].strip_prefix(name);
    behind.is_some_and(|behind| behind.starts_with(['>', ' ']))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn texts_are_converted_and_all_else_stays() {
        let page = "<p title=\"4 mm\" data-x=\"4 mm\">4.0 mm <code>60 mm</code> 8.0 J</p>\
                    <script>let a = 1 < 2, b = \"4 mm\";</script>2 m";
        let us = "<p title=\"0.157 in\" data-x=\"4 mm\">0.157 in <code>60 mm</code> 5.90 ft-lbf</p>\
                  <script>let a = 1 < 2, b = \"4 mm\";</script>6.56 ft";
        assert_eq!(converted(page), us);
    }
}
