//! `nailnoise init`: a design to begin with.

use std::path::{Path, PathBuf};
use std::process::ExitCode;

use clap::Args;

use super::print;
use crate::error::Error;
use crate::shipped;
use crate::staging;

/// The design on which others are based, with all its comments and sources.
const BASE: &str = "n80cb.toml";

/// A design based on it.
const OWN: &str = include_str!("init.toml");

#[derive(Args)]
#[command(after_help = examples!(
    "nailnoise init my-tool.toml" => "a design over the N80CB, with the keys that differ most often",
    "nailnoise init --from n80cb" => "the N80CB itself, every key with its source and range",
    "nailnoise init --from muffler quieter.toml" => "another design of the program, with its bases, under a name of your own",
))]
pub(super) struct Arguments {
    /// The design file to write [default: my-tool.toml, or the name of the design given by --from]
    #[arg(value_name = "DESIGN")]
    design: Option<PathBuf>,
    /// Write this design, which comes with the program, and its bases beside it
    #[arg(long, value_name = "NAME", conflicts_with = "full", value_parser = shipped_design)]
    from: Option<(&'static str, &'static str)>,
    /// Write every key of the base design, instead of a few keys on top of a separate base file
    #[arg(long)]
    full: bool,
}

/// A design that comes with the program, with its text.
fn shipped_design(name: &str) -> Result<(&'static str, &'static str), String> {
    shipped::design(name).ok_or_else(|| {
        let names: Vec<&str> = shipped::names().collect();
        format!(
            "no design of this name comes with the program; there are {}",
            names.join(", ")
        )
    })
}

pub(super) fn execute(arguments: &Arguments) -> Result<ExitCode, Error> {
    let (path, files) = plan(arguments);
    if path.exists() {
        return Err(Error::Exists { path });
    }
    if files.iter().skip(1).any(|(base, ..)| *base == path) {
        return Err(Error::NameOfBase { path });
    }
    let mut text = String::new();
    // The design last: it is of no use without its bases.
    for (path, content, what) in files.iter().rev() {
        // What stands there may have been changed by its owner.
        let kept = path.exists();
        if !kept {
            staging::write(path, content.as_bytes())?;
        }
        let present = if kept { " (already present)" } else { "" };
        text.insert_str(0, &format!("{}: {what}{present}\n", path.display()));
    }
    text.push_str(&format!(
        "\n  nailnoise check {0}   lists estimates and the cost of a run\n  nailnoise run {0}     ranks its sources\n",
        path.display()
    ));
    print(&text)?;
    Ok(ExitCode::SUCCESS)
}

/// A file to write, its content, and what it is.
type Planned = (PathBuf, String, String);

/// The design and the files to write, the design first.
fn plan(arguments: &Arguments) -> (PathBuf, Vec<Planned>) {
    let path = |default: &str| arguments.design.clone().unwrap_or_else(|| PathBuf::from(default));
    let base_of = |path: &Path| path.with_file_name(BASE);
    if let Some((name, text)) = arguments.from {
        let path = path(shipped::file_name(name));
        let files = with_bases(&path, name, text);
        return (path, files);
    }
    let path = path("my-tool.toml");
    let base = shipped::design(BASE).map_or("", |(_, text)| text);
    let base_path = base_of(&path);
    let files = if arguments.full || base_path == path {
        let what = "the N80CB with every key, its source and range";
        vec![(path.clone(), base.to_owned(), what.to_owned())]
    } else {
        let what = "your design; remove the # from the lines that differ";
        vec![
            (path.clone(), OWN.to_owned(), what.to_owned()),
            (base_path, base.to_owned(), "its base".to_owned()),
        ]
    };
    (path, files)
}

/// A design of the program and its bases, all in one folder.
fn with_bases(path: &Path, name: &str, text: &str) -> Vec<Planned> {
    let mut files = vec![(
        path.to_owned(),
        in_one_folder(text),
        format!("the design {name} of the program"),
    )];
    let mut next = base(text);
    while let Some((name, text)) = next.and_then(|(_, file)| shipped::design(file)) {
        let what = if files.len() == 1 {
            "its base"
        } else {
            "the base of that"
        };
        let path = path.with_file_name(shipped::file_name(name));
        files.push((path, in_one_folder(text), what.to_owned()));
        next = base(text);
    }
    files
}

/// The name of a design's base as it is written, and the name of its file.
fn base(text: &str) -> Option<(&str, &str)> {
    let line = text.lines().find_map(|line| line.strip_prefix("base = \""))?;
    let (name, _) = line.split_once('"')?;
    Some((name, shipped::file_name(name)))
}

/// The text with its base in the same folder.
fn in_one_folder(text: &str) -> String {
    match base(text) {
        Some((name, file)) => text.replacen(&format!("base = \"{name}\""), &format!("base = \"{file}\""), 1),
        None => text.to_owned(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::design::Design;

    /// Every design of the program, written alone into a folder, has the values that it has in the repository.
    #[test]
    fn every_design_of_the_program_is_written_with_its_bases() -> Result<(), Error> {
        let folder = std::env::temp_dir().join(format!("nailnoise-init-{}", std::process::id()));
        for (name, text) in shipped::DESIGNS {
            let _ = std::fs::remove_dir_all(&folder);
            let path = folder.join("own.toml");
            for (path, content, _) in with_bases(&path, name, text) {
                staging::write(&path, content.as_bytes())?;
            }
            let designs = Path::new(env!("CARGO_MANIFEST_DIR")).join("designs");
            let (own, original) = (Design::load(&path)?, Design::load(designs.join(name))?);
            assert_eq!(own.digest(), original.digest(), "{name}");
            assert_eq!(own.entries().len(), original.entries().len(), "{name}");
        }
        let _ = std::fs::remove_dir_all(folder);
        Ok(())
    }
}
