//! The `nailnoise` command. Everything it does stands in the library; see `nailnoise::commands`.
#![forbid(unsafe_code)]

use std::process::ExitCode;

fn main() -> ExitCode {
    nailnoise::commands::main()
}
