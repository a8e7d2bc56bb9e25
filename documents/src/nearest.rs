//! The known word that is most like an unknown one.

/// Edits that still count as a slip of the finger, for a word of this length.
fn tolerance(word: &str) -> usize {
    (word.chars().count() / 4).clamp(1, 3)
}

/// The word most like `name`, if any is near: at most one edit (Damerau, Levenshtein) for four characters, and at most
/// three.
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
