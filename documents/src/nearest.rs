//! Finds the known word closest to an unknown one.

/// Number of edits that still count as a typing error in a word of this length.
fn tolerance(word: &str) -> usize {
    (word.chars().count() / 4).clamp(1, 3)
}

/// The word closest to `name` by Damerau-Levenshtein distance. Words of four characters may differ by one edit, longer
/// ones by up to three.
pub fn nearest<'a>(words: impl Iterator<Item = &'a str>, name: &str) -> Option<&'a str> {
    let name = name.to_lowercase();
    words
        .map(|word| (strsim::damerau_levenshtein(word, &name), word))
        .min_by_key(|(edits, _)| *edits)
        .filter(|(edits, _)| *edits <= tolerance(&name))
        .map(|(_, word)| word)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_slip_finds_its_word_and_another_word_does_not() {
        let words = || ["pressure", "volume"].into_iter();
        assert_eq!(nearest(words(), "Presure"), Some("pressure"));
        assert_eq!(nearest(words(), "voulme"), Some("volume"));
        assert_eq!(nearest(words(), "density"), None);
    }
}
