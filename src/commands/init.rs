//! `nailnoise init`: a design to begin with.

use std::path::{Path, PathBuf};
use std::process::ExitCode;

use clap::Args;

use super::print;
use crate::error::Error;
use crate::staging;

/// The base design, with all its comments and sources.
const BASE: &str = include_str!("../../designs/n80cb.toml");
const BASE_NAME: &str = "n80cb.toml";

/// A design based on it.
const OWN: &str = include_str!("init.toml");

#[derive(Args)]
pub(super) struct Arguments {
    /// The design file to write
    #[arg(value_name = "DESIGN", default_value = "my-tool.toml")]
    design: PathBuf,
    /// Write every key of the base design, instead of a few keys on top of a separate base file
    #[arg(long)]
    full: bool,
}

pub(super) fn execute(arguments: &Arguments) -> Result<ExitCode, Error> {
    let path = &arguments.design;
    if path.exists() {
        return Err(Error::Exists { path: path.clone() });
    }
    let base = path.with_file_name(BASE_NAME);
    if arguments.full || base == *path {
        put(path, BASE)?;
        print(&format!(
            "{}: the N80CB with every key, its source and range\n",
            path.display()
        ))?;
    } else {
        // What stands there may have been changed by its owner.
        let kept = base.exists();
        if !kept {
            put(&base, BASE)?;
        }
        put(path, OWN)?;
        print(&format!(
            "{}: your design; remove the # from the lines that differ\n{}: its base{}\n",
            path.display(),
            base.display(),
            if kept { " (already present)" } else { "" }
        ))?;
    }
    print(&format!(
        "\n  nailnoise check {0}   lists estimates and the cost of a run\n  nailnoise run {0}     ranks its sources\n",
        path.display()
    ))?;
    Ok(ExitCode::SUCCESS)
}

fn put(path: &Path, text: &str) -> Result<(), Error> {
    staging::write(path, text.as_bytes())
}
