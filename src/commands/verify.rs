//! `nailnoise verify`: computes public benchmarks on this machine.

use std::time::Instant;

use clap::Args;
use serde::Serialize;

use super::{Status, table::texts};
use super::{Threads, message, print, print_json, progress};
use crate::error::Error;
use crate::verification::{Row, Section, Shown, Verdict, summary, verify};

/// Version of the layout of `verify --json`.
const SCHEMA: &str = "nailnoise-verify/1";

#[derive(Args)]
#[command(after_help = examples!(
    "nailnoise verify" => "computed values and closed forms, standards and public measurements",
    "nailnoise verify --all" => "every row of every case",
    "nailnoise verify --json" => "all rows for a script",
))]
pub(super) struct Arguments {
    /// Print every row, not only the worst of each long case
    #[arg(long)]
    all: bool,
    /// Print exactly one JSON value instead of tables
    #[arg(long)]
    json: bool,
    #[command(flatten)]
    threads: Threads,
}

/// Layout of `verify --json`.
#[derive(Serialize)]
struct VerifyResult<'a> {
    schema: &'static str,
    /// Wall time \[s\].
    seconds: f64,
    rows: usize,
    documented: usize,
    failed: usize,
    sections: Vec<JudgedSection<'a>>,
}

#[derive(Serialize)]
struct JudgedSection<'a> {
    field: &'static str,
    rows: Vec<Judged<'a>>,
}

#[derive(Serialize)]
struct Judged<'a> {
    #[serde(flatten)]
    row: &'a Row,
    /// Fraction of the tolerance used.
    used: f64,
    verdict: Verdict,
}

impl<'a> JudgedSection<'a> {
    fn new(section: &'a Section) -> Self {
        let judged = |row: &'a Row| Judged {
            row,
            used: row.share(),
            verdict: row.verdict(),
        };
        Self {
            field: section.field,
            rows: section.rows.iter().map(judged).collect(),
        }
    }
}

pub(super) fn execute(arguments: &Arguments) -> Result<Status, Error> {
    arguments.threads.start()?;
    let progress = progress();
    progress.stage("benchmarks");
    let start = Instant::now();
    let sections = verify()?;
    let seconds = start.elapsed().as_secs_f64();
    progress.end();
    let rows = || sections.iter().flat_map(|section| &section.rows);
    let [documented, failed] = [Verdict::Documented, Verdict::Fails].map(|verdict| count(&sections, verdict));
    if arguments.json {
        print_json(&VerifyResult {
            schema: SCHEMA,
            seconds,
            rows: rows().count(),
            documented,
            failed,
            sections: sections.iter().map(JudgedSection::new).collect(),
        })?;
    } else {
        for section in &sections {
            print(&text(section, arguments.all))?;
        }
        print(&format!(
            "  {} rows in {seconds:.0} s: {failed} fail, {documented} disagree as docs/limits.md states\n",
            rows().count()
        ))?;
    }
    for row in rows().filter(|row| row.verdict() == Verdict::Fails) {
        message(&format!(
            "failed: {}, {}: {} instead of {}, {}",
            row.case.name,
            row.quantity,
            row.number(row.computed),
            row.number(row.reference),
            row.tolerance()
        ));
    }
    Ok(status(&sections))
}

/// Number of rows with a verdict.
fn count(sections: &[Section], verdict: Verdict) -> usize {
    let rows = sections.iter().flat_map(|section| &section.rows);
    rows.filter(|row| row.verdict() == verdict).count()
}

/// Exit status: 3 if a row fails.
fn status(sections: &[Section]) -> Status {
    match count(sections, Verdict::Fails) {
        0 => Status::SUCCESS,
        _ => Status::from(3),
    }
}

/// Formats a section: for each case its name and source, followed by its rows.
fn text(section: &Section, all: bool) -> String {
    let shown = if all {
        section.rows.iter().map(|row| Shown { row, of: 1 }).collect()
    } else {
        summary(&section.rows)
    };
    let mut text = String::new();
    for case in shown.chunk_by(|a, b| a.row.case == b.row.case) {
        let of = &case[0].row.case;
        text.push_str(&format!("{}: {}\n  {}\n\n", section.field, of.name, of.source));
        let cells = |shown: &Shown<'_>| {
            let row = shown.row;
            let quantity = match shown.of {
                1 => row.quantity.clone(),
                of => format!("{} (worst of {of})", row.quantity),
            };
            let (reference, computed) = (row.number(row.reference), row.number(row.computed));
            vec![quantity, reference, computed, row.tolerance(), row.used()]
        };
        let rows: Vec<Vec<String>> = case.iter().map(cells).collect();
        text.push_str(&texts(
            &["quantity", "reference", "computed", "tolerance", "used"],
            &rows,
        ));
        text.push('\n');
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::verification::Case;

    #[test]
    fn a_row_outside_its_limits_ends_with_status_3_and_a_documented_one_with_success() {
        let case = Case {
            name: "case",
            source: "source",
        };
        let of = |row: Row| {
            let agrees = case.row("x", 1.0, 1.0).within(0.1);
            let rows = vec![agrees, row];
            status(&[Section { field: "sound", rows }])
        };
        let outside = case.row("y", 1.0, 2.0).within(0.1);
        assert_eq!(of(outside.clone().documented([0.5, 1.5])), Status::SUCCESS);
        assert_eq!(of(outside), Status::from(3));
        assert_eq!(of(case.row("y", 1.0, f64::NAN).within(0.1)), Status::from(3));
    }
}
