//! `result.json` and `report.html`: the complete result, for programs and for people.

use super::{Output, RunView};
use crate::error::Error;

/// The last file to be written: a folder that contains it is complete.
pub const LAST: &str = "result.json";

/// The result as JSON, which `run --json` prints.
pub(super) const RESULT: Output = Output::of_study(LAST, json);

/// The report.
pub(super) const REPORT: Output = Output::of_study("report.html", |of| Ok((of.report)().into_bytes()));

fn json(of: &RunView<'_>) -> Result<Vec<u8>, Error> {
    let mut json = serde_json::to_vec_pretty(&of.run.result).map_err(Error::Json)?;
    json.push(b'\n');
    Ok(json)
}
