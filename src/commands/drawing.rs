//! `nailnoise check DESIGN --drawing`: draws the tool with the dimensions of its design as an SVG file.

use std::path::{Path, PathBuf};

use serde::Serialize;

use super::{Status, folder_of, print, print_json};
use crate::atomic_write;
use crate::design::Design;
use crate::drawing::Drawing;
use crate::error::Error;

/// A path that ends in .svg, so that a design cannot be overwritten by mistake.
pub(super) fn svg_path(text: &str) -> Result<PathBuf, String> {
    let path = PathBuf::from(text);
    match path.extension() {
        Some(end) if end.eq_ignore_ascii_case("svg") => Ok(path),
        _ => Err("a drawing is an SVG file: its name must end in .svg".to_owned()),
    }
}

/// Layout of `check DESIGN --drawing --json`.
#[derive(Serialize)]
struct DrawingResult<'a> {
    schema: &'static str,
    design: &'a str,
    written: &'a Path,
    /// Keys shown in the drawing, and the keys of each misfit with its parts.
    keys: Vec<&'a str>,
    misfits: Vec<MisfitResult<'a>>,
}

#[derive(Serialize)]
struct MisfitResult<'a> {
    keys: &'a [&'static str],
    text: &'a str,
}

/// Draws a design to a file, `out/NAME/drawing.svg` by default.
pub(super) fn execute(design: &Design, file: Option<&Path>, json: bool) -> Result<Status, Error> {
    let path = match file {
        Some(path) => path.to_owned(),
        None => folder_of(Path::new("out"), design.name(), design.path())?.join("drawing.svg"),
    };
    let drawing = Drawing::new(design);
    atomic_write::write(&path, drawing.svg().as_bytes())?;
    let shown = drawing.shown();
    if json {
        print_json(&DrawingResult {
            schema: "nailnoise-drawing/1",
            design: design.name(),
            written: &path,
            keys: shown.iter().map(|label| label.key.as_str()).collect(),
            misfits: drawing
                .misfits
                .iter()
                .map(|misfit| MisfitResult {
                    keys: &misfit.keys,
                    text: &misfit.text,
                })
                .collect(),
        })?;
        return Ok(Status::SUCCESS);
    }
    let mut text = format!(
        "{}: {} keys drawn, written to {}\n",
        design.name(),
        shown.len(),
        path.display()
    );
    if !drawing.misfits.is_empty() {
        text.push_str("\n  lengths and volumes that do not fit together as drawn (a run does not need them to):\n");
        for misfit in &drawing.misfits {
            text.push_str(&format!("  - {}: {}\n", misfit.keys.join(", "), misfit.text));
        }
    }
    print(&text)?;
    Ok(Status::SUCCESS)
}
