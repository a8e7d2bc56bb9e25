//! `nailnoise schema`: the design file's schema, for editors.

use std::process::ExitCode;

use super::print_json;
use crate::design::json_schema;
use crate::error::Error;

pub(super) fn execute() -> Result<ExitCode, Error> {
    print_json(&json_schema())?;
    Ok(ExitCode::SUCCESS)
}
