//! `nailnoise cache`: results stored between runs.

use std::path::Path;
use std::time::SystemTime;

use clap::{Args, Subcommand};
use serde::Serialize;

use super::{Status, table::table};
use super::{message, print, print_json};
use crate::error::Error;
use crate::store::{Listed, Store};

#[derive(Args)]
#[command(after_help = examples!(
    "nailnoise cache" => "lists the cached results",
    "nailnoise cache verify" => "reads them all and removes damaged ones",
    "NAILNOISE_CACHE_LIMIT=10 nailnoise run my-tool.toml" => "lets them take 10 GiB",
))]
pub(super) struct Arguments {
    #[command(subcommand)]
    action: Option<Action>,
    /// Print exactly one JSON value instead of tables
    #[arg(long, global = true)]
    json: bool,
}

#[derive(Subcommand, Clone, Copy)]
enum Action {
    /// List the entries, last used first (default)
    List,
    /// Read every entry and remove damaged ones; status 1 if there are any
    Verify,
    /// Remove all entries
    Clear,
}

#[derive(Serialize)]
struct Row {
    stage: String,
    file: String,
    bytes: u64,
    /// Since it was last used.
    age_s: f64,
}

impl From<Listed> for Row {
    fn from(entry: Listed) -> Self {
        let age = SystemTime::now().duration_since(entry.used).unwrap_or_default();
        Self {
            stage: entry.stage,
            file: entry
                .path
                .file_name()
                .unwrap_or_default()
                .to_string_lossy()
                .into_owned(),
            bytes: entry.bytes,
            age_s: age.as_secs_f64(),
        }
    }
}

pub(super) fn execute(arguments: &Arguments) -> Result<Status, Error> {
    let cache = Store::of_user()?;
    let folder = cache.folder().unwrap_or_else(|| "".as_ref()).to_owned();
    let failed = |source| Error::Store {
        path: folder.clone(),
        source,
    };
    match arguments.action.unwrap_or(Action::List) {
        Action::List => {
            let rows: Vec<Row> = cache.entries().map_err(failed)?.into_iter().map(Row::from).collect();
            let bytes: u64 = rows.iter().map(|row| row.bytes).sum();
            if arguments.json {
                print_json(&serde_json::json!({
                    "folder": folder, "bytes": bytes, "limit_bytes": cache.limit(), "entries": rows,
                }))?;
            } else {
                print(&listing(&rows))?;
                print(&format!(
                    "\n  {} MiB of {} MiB in {}\n",
                    mebibytes(bytes),
                    mebibytes(cache.limit()),
                    folder.display()
                ))?;
            }
        }
        Action::Verify => {
            let damaged = cache.verify().map_err(failed)?;
            let mut removed = 0;
            for (path, damage) in &damaged {
                if cache.is_own(path) {
                    cache.remove(path).map_err(failed)?;
                    message(&format!("removed: {} {damage}", path.display()));
                    removed += 1;
                } else {
                    left(path);
                }
            }
            let sound = cache.entries().map_err(failed)?.len() + removed - damaged.len();
            if arguments.json {
                print_json(&serde_json::json!({"folder": folder, "sound": sound, "removed": removed}))?;
            } else {
                print(&format!("  {sound} entries are intact, {removed} removed\n"))?;
            }
            return Ok(Status::from(u8::from(!damaged.is_empty())));
        }
        Action::Clear => {
            for (path, damage) in cache.obstacles().map_err(failed)? {
                message(&format!("removed: {} {damage}", path.display()));
            }
            let (count, others) = cache.clear().map_err(failed)?;
            others.iter().for_each(|path| left(path));
            if arguments.json {
                print_json(&serde_json::json!({"folder": folder, "removed": count}))?;
            } else {
                print(&format!("  {count} entries removed from {}\n", folder.display()))?;
            }
        }
    }
    Ok(Status::SUCCESS)
}

/// Reports a file that was not removed.
fn left(path: &Path) {
    message(&format!(
        "left: {} has the name of an entry, but nailnoise did not write it",
        path.display()
    ));
}

fn listing(rows: &[Row]) -> String {
    let rows: Vec<Vec<String>> = rows
        .iter()
        .map(|row| {
            vec![
                row.stage.clone(),
                mebibytes(row.bytes),
                age(row.age_s),
                row.file.clone(),
            ]
        })
        .collect();
    table(&["stage", "MiB", "last used", "file"], &rows)
}

fn mebibytes(bytes: u64) -> String {
    format!("{:.1}", bytes as f64 / f64::from(1u32 << 20))
}

/// `3 min ago`.
fn age(seconds: f64) -> String {
    let (value, unit) = match seconds {
        s if s < 60.0 => (s, "s"),
        s if s < 3600.0 => (s / 60.0, "min"),
        s if s < 86_400.0 => (s / 3600.0, "h"),
        s => (s / 86_400.0, "d"),
    };
    format!("{value:.0} {unit} ago")
}
