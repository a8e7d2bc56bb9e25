//! The public benchmarks of `nailnoise verify`, the tables of the docs that they make, and the command.

use std::fs;
use std::path::Path;

use nailnoise::verification::{Row, Section, Shown, Verdict, markdown, summary, verify};

use crate::common::{ROOT, json, messages, nailnoise};

/// The comments that enclose the generated table.
const MARKS: [&str; 2] = ["<!-- made by tests/commands/verify.rs -->\n", "<!-- end -->\n"];

/// The text of a file with the part between [`MARKS`] replaced.
fn with_table(text: &str, table: &str) -> String {
    let (before, rest) = text.split_once(MARKS[0]).unwrap();
    let (_, after) = rest.split_once(MARKS[1]).unwrap();
    format!("{before}{}\n{table}\n{}{after}", MARKS[0], MARKS[1])
}

/// The page shows this table, or is written with it where NAILNOISE_UPDATE_DOCS is set.
fn assert_shown(page: &str, table: &str) {
    let path = Path::new(ROOT).join("docs").join(page);
    let committed = fs::read_to_string(&path).unwrap();
    let text = with_table(&committed, table);
    if std::env::var_os("NAILNOISE_UPDATE_DOCS").is_some() {
        fs::write(&path, &text).unwrap();
    }
    assert!(
        fs::read_to_string(&path).unwrap() == text,
        "docs/{page} is old: run this test with NAILNOISE_UPDATE_DOCS=1"
    );
}

fn rows(sections: &[Section]) -> impl Iterator<Item = &Row> {
    sections.iter().flat_map(|section| &section.rows)
}

#[test]
fn every_benchmark_agrees_or_is_stated_and_the_tables_in_docs_are_generated() {
    let sections = verify().unwrap();
    for row in rows(&sections) {
        assert_ne!(row.verdict(), Verdict::Fails, "{row:?}");
    }
    // A statement of a disagreement that is no more would hide the next one.
    let stated = rows(&sections).filter(|row| row.documented.is_some());
    let disagrees = |row: &Row| row.verdict() == Verdict::Documented;
    for case in stated.collect::<Vec<_>>().chunk_by(|a, b| a.case == b.case) {
        assert!(case.iter().any(|row| disagrees(row)), "{}", case[0].case.name);
    }
    let (levels, others): (Vec<&Section>, Vec<&Section>) =
        sections.iter().partition(|section| section.field == "levels");
    let shown: Vec<Shown<'_>> = others.iter().flat_map(|section| summary(&section.rows)).collect();
    assert_shown("verification.md", &markdown(&shown));
    let all: Vec<Shown<'_>> = levels
        .iter()
        .flat_map(|section| &section.rows)
        .map(|row| Shown { row, of: 1 })
        .collect();
    assert_shown("conformance-acoustics.md", &markdown(&all));
}

#[test]
fn the_command_prints_every_row_with_its_verdict_and_ends_with_success() {
    let value = json(&nailnoise(&["verify", "--json"]));
    assert_eq!(value["schema"], "nailnoise-verify/1");
    assert_eq!(value["failed"], 0);
    let sections = value["sections"].as_array().unwrap();
    let rows: usize = sections
        .iter()
        .map(|section| section["rows"].as_array().unwrap().len())
        .sum();
    assert_eq!(value["rows"], rows);
    assert!(rows > 250, "{rows}");
    let row = &sections[0]["rows"][0];
    assert_eq!(row["verdict"], "agrees");
    assert!(row["source"].is_string() && row["used"].is_f64());

    let output = nailnoise(&["verify"]);
    let text = String::from_utf8(output.stdout.clone()).unwrap();
    assert_eq!(output.status.code(), Some(0), "{}", messages(&output));
    assert!(text.contains("NAFEMS FV12") && text.contains("worst of"), "{text}");
}
