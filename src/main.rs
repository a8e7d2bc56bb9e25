//! The `nailnoise` command. Everything it does stands in the library; see `nailnoise::commands`.
#![forbid(unsafe_code)]

use std::process::ExitCode;

use mimalloc::MiMalloc;

/// A shot touches gigabytes of short-lived memory, which the system's allocator returns and asks for again page by page.
#[global_allocator]
static MEMORY: MiMalloc = MiMalloc;

fn main() -> ExitCode {
    nailnoise::commands::main()
}
