//! `nailnoise schema`: the layouts of the design file, for editors, and of results, for programs that read them.

use clap::{Args, ValueEnum};
use schemars::schema_for;

use super::{Status, print_json};
use crate::design::json_schema;
use crate::error::Error;
use crate::measurement::result::MeasurementResult;
use crate::result::RunResult;
use crate::study::StudyResult;

#[derive(Args)]
#[command(after_help = examples!(
    "nailnoise schema > nailnoise.schema.json" => "for an editor that completes and checks design files",
    "nailnoise schema --of result" => "the layout of result.json",
))]
pub(super) struct Arguments {
    /// The file to describe
    #[arg(long, value_enum, default_value_t = Layout::Design)]
    of: Layout,
}

#[derive(Clone, Copy, ValueEnum)]
enum Layout {
    /// The design file, for editors
    Design,
    /// `result.json` and the output of `run --json`, for programs that read them
    Result,
    /// `study.json` and the output of `study --json`
    Study,
    /// `measurement.json` and the output of `measure --json`
    Measurement,
}

pub(super) fn execute(arguments: &Arguments) -> Result<Status, Error> {
    match arguments.of {
        Layout::Design => print_json(&json_schema())?,
        Layout::Result => print_json(&RunResult::json_schema())?,
        Layout::Study => print_json(&StudyResult::json_schema())?,
        Layout::Measurement => print_json(&schema_for!(MeasurementResult))?,
    }
    Ok(Status::SUCCESS)
}
