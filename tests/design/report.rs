//! `[report]`: texts in the head of the report, which do not affect any result.

use nailnoise::Design;
use nailnoise::design::DesignError;

fn over(text: &str) -> Result<Design, DesignError> {
    Design::parse(&format!("base = \"n80cb.toml\"\n{text}\n"), "designs/over.toml")
}

#[test]
fn the_head_of_the_report_changes_no_digest() {
    let plain = over("").unwrap();
    let named = over("[report]\ntitle = \"A nailer\"\nrevision = \"B\"").unwrap();
    assert_eq!(named.digest(), plain.digest());
    assert_eq!(named.entries().len(), plain.entries().len());
    assert_eq!(
        [named.report().title.as_str(), &named.report().revision],
        ["A nailer", "B"]
    );
    assert!(named.report().client.is_empty() && plain.report().title.is_empty());
}

#[test]
fn the_nearest_file_says_what_stands_in_the_head() {
    let changes = ["report.title=Another", "report.author=A. Engineer"].map(|text| text.parse().unwrap());
    let design = Design::load_with("designs/n80cb.toml", &changes).unwrap();
    assert_eq!(
        [design.report().title.as_str(), &design.report().author],
        ["Another", "A. Engineer"]
    );
}

#[test]
fn what_is_no_text_or_no_key_is_refused_with_its_place() {
    for (text, words) in [
        ("report = 3", "[report]"),
        ("[report]\ntitle = 3", "text in quotes"),
        ("[report]\ntitel = \"x\"", "report.titel"),
    ] {
        let error = over(text).unwrap_err();
        let said = format!("{:?}", miette::Report::new(error));
        assert!(said.contains(words) && said.contains("over.toml"), "{said}");
    }
    let long = over(&format!("[report]\nnote = \"{}\"", "x".repeat(2001)));
    assert!(long.unwrap_err().to_string().contains("report.note"));
}
