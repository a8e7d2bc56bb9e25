//! `nailnoise migrate`: updates the keys of a design file of an earlier version.

use std::path::PathBuf;

use clap::Args;
use serde::Serialize;

use super::{Status, print, print_json};
use crate::atomic_write;
use crate::design::{Migration, RenamedKey, ReplacedKey};
use crate::error::Error;

/// Version of the layout of `migrate --json`.
const SCHEMA: &str = "nailnoise-migrate/1";

#[derive(Args)]
#[command(after_help = examples!(
    "nailnoise migrate my-tool.toml" => "the keys of earlier versions in this file and their successors",
    "nailnoise migrate my-tool.toml --write" => "rename them in the file; comments and order stay",
))]
pub(super) struct Arguments {
    /// Design file (TOML); each of its bases is migrated by itself
    design: PathBuf,
    /// Write the file with the keys of today
    #[arg(long)]
    write: bool,
    /// Print exactly one JSON value instead of text
    #[arg(long)]
    json: bool,
}

/// Layout of `migrate --json`.
#[derive(Serialize)]
struct Report<'a> {
    schema: &'static str,
    renamed: &'a [RenamedKey],
    by_hand: &'a [ReplacedKey],
    written: bool,
}

/// The exit status is 1 if the file has keys of earlier versions.
pub(super) fn execute(arguments: &Arguments) -> Result<Status, Error> {
    let migration = Migration::of(&arguments.design)?;
    let written = arguments.write && !migration.renamed.is_empty();
    if written {
        atomic_write::write(&arguments.design, migration.text.as_bytes())?;
    }
    let report = Report {
        schema: SCHEMA,
        renamed: &migration.renamed,
        by_hand: &migration.by_hand,
        written,
    };
    if arguments.json {
        print_json(&report)?;
    } else {
        print(&in_words(arguments, &report))?;
    }
    let is_current = report.by_hand.is_empty() && (written || report.renamed.is_empty());
    Ok(Status::from(u8::from(!is_current)))
}

fn in_words(arguments: &Arguments, report: &Report<'_>) -> String {
    let path = arguments.design.display();
    let renamed = report.renamed.iter();
    let mut text: String = renamed
        .map(|own| format!("{path}:{}: {} -> {}\n", own.line, own.old, own.new))
        .collect();
    for own in report.by_hand {
        text.push_str(&format!(
            "{path}:{}: replace `{}` by hand: give {}\n",
            own.line, own.old, own.successors
        ));
    }
    if report.written {
        text.push_str(&format!("{path} is written with the keys of today\n"));
    } else if !report.renamed.is_empty() {
        text.push_str("--write renames these keys in the file\n");
    } else if report.by_hand.is_empty() {
        text.push_str(&format!("{path} has no key of an earlier version\n"));
    }
    text
}
