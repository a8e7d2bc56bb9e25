//! The `nailnoise` command. All its code is in the library; see `nailnoise::commands`.
#![forbid(unsafe_code)]

use std::process::ExitCode;

use mimalloc::MiMalloc;

/// A shot uses gigabytes of short-lived memory, which the system's allocator would return and request again page by
/// page.
#[global_allocator]
static MEMORY: MiMalloc = MiMalloc;

fn main() -> ExitCode {
    nailnoise::commands::main().into()
}
