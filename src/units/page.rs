//! The texts of a page.

use super::text;

/// Elements whose content is no text for people, or is input for the program.
const AS_WRITTEN: [&str; 3] = ["script", "style", "code"];

/// A page with the quantities of its texts in units of the United States; tags and [`AS_WRITTEN`] stay.
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
        let (copied, behind) = tag.split_at(end.unwrap_or(tag.len()));
        shown.push_str(copied);
        rest = behind;
    }
    shown.push_str(&text::converted(rest, true));
    shown
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
        let page =
            "<p title=\"4 mm\">4.0 mm <code>60 mm</code> 8.0 J</p><script>let a = 1 < 2, b = \"4 mm\";</script>2 m";
        let us = "<p title=\"4 mm\">0.157 in <code>60 mm</code> 5.90 ft-lbf</p>\
                  <script>let a = 1 < 2, b = \"4 mm\";</script>6.56 ft";
        assert_eq!(converted(page), us);
    }
}
