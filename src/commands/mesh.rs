//! `nailnoise mesh`: builds, reads, converts and analyses meshes of bodies.

use std::path::{Path, PathBuf};

use clap::{Args, ValueEnum};
use nailnoise_meshes::msh::{self, Format};
use nailnoise_meshes::{MeshError, vtu};
use serde::Serialize;

use super::{Status, bodies::Input};
use super::{print, print_json};
use crate::atomic_write;
use crate::error::Error;

#[derive(Args)]
#[command(after_help = examples!(
    "nailnoise mesh my-tool.toml --body tool --write tool.vtu" => "the mesh of a body, for ParaView",
    "nailnoise mesh housing.step --size \"6 mm\" --write housing.msh" => "a geometry of your own, meshed by gmsh",
    "nailnoise mesh assembly.step --size \"6 mm\" --solid 3 --write part.msh" => "the third of its solids",
))]
pub(super) struct Arguments {
    #[command(flatten)]
    input: Input,
    /// File to write: .vtu, .msh or .msh.gz; may be repeated
    #[arg(long, value_name = "FILE")]
    write: Vec<PathBuf>,
    /// Format of .msh files
    #[arg(long, value_enum, default_value = "binary41")]
    format: FormatName,
    /// Print exactly one JSON value instead of text
    #[arg(long)]
    json: bool,
}

#[derive(Clone, Copy, ValueEnum)]
enum FormatName {
    /// Version 2.2, text
    Text22,
    /// Version 2.2, binary
    Binary22,
    /// Version 4.1, text
    Text41,
    /// Version 4.1, binary
    Binary41,
}

impl From<FormatName> for Format {
    fn from(name: FormatName) -> Self {
        match name {
            FormatName::Text22 => Self::Text22,
            FormatName::Binary22 => Self::Binary22,
            FormatName::Text41 => Self::Text41,
            FormatName::Binary41 => Self::Binary41,
        }
    }
}

/// Layout of `mesh --json`.
#[derive(Serialize)]
struct MeshResult {
    schema: &'static str,
    source: String,
    nodes: usize,
    elements: usize,
    /// Elements of each kind.
    kinds: Vec<(String, usize)>,
    /// Parts with their volumes \[m3\].
    parts: Vec<(String, f64)>,
    /// Face groups with their numbers of faces.
    groups: Vec<(String, usize)>,
    longest_edge: f64,
    /// Notes for the user on how the mesh was made.
    notes: Vec<String>,
    written: Vec<PathBuf>,
}

pub(super) fn execute(arguments: &Arguments) -> Result<Status, Error> {
    arguments.input.start_threads()?;
    let loaded = arguments.input.load(false)?;
    let mesh = &loaded.imported.mesh;
    for path in &arguments.write {
        write(path, &loaded.imported, arguments.format.into())?;
    }
    let mut kinds: Vec<(String, usize)> = Vec::new();
    for kind in &mesh.kinds {
        let name = format!("{kind:?}").to_lowercase();
        match kinds.iter_mut().find(|(own, _)| *own == name) {
            Some((_, count)) => *count += 1,
            None => kinds.push((name, 1)),
        }
    }
    let result = MeshResult {
        schema: "nailnoise-mesh/1",
        source: arguments.input.path().display().to_string(),
        nodes: mesh.nodes.len(),
        elements: mesh.element_count(),
        kinds,
        parts: mesh.part_names.iter().cloned().zip(mesh.part_volumes()?).collect(),
        groups: mesh
            .groups
            .iter()
            .map(|group| (group.name.clone(), group.faces.len()))
            .collect(),
        longest_edge: mesh.longest_edges().into_iter().fold(0.0, f64::max),
        notes: loaded.imported.notes.clone(),
        written: arguments.write.clone(),
    };
    if arguments.json {
        print_json(&result)?;
    } else {
        print(&text(&loaded.name, &result))?;
    }
    Ok(Status::SUCCESS)
}

fn write(path: &Path, imported: &msh::Imported, format: Format) -> Result<(), Error> {
    let name = path.to_string_lossy().to_lowercase();
    let msh = || msh::to_bytes(&imported.mesh, format, &imported.comment);
    let bytes = if name.ends_with(".vtu") {
        vtu::Grid::of_mesh(&imported.mesh).to_bytes(&[], &[])?
    } else if name.ends_with(".msh") {
        msh()
    } else if name.ends_with(".msh.gz") {
        msh::compressed(&msh())
    } else {
        return Err(Error::Mesh(MeshError::UnknownOutput { path: path.to_owned() }));
    };
    atomic_write::write(path, &bytes)
}

fn text(name: &str, result: &MeshResult) -> String {
    let kinds: Vec<String> = result
        .kinds
        .iter()
        .map(|(kind, count)| format!("{count} {kind}"))
        .collect();
    let mut text = format!("{name}\n\n  {} nodes, {}\n", result.nodes, kinds.join(", "));
    text.push_str(&format!("  longest element side {:.1} mm\n", result.longest_edge * 1e3));
    for (part, volume) in &result.parts {
        text.push_str(&format!("  part {part}: {:.1} cm3\n", volume * 1e6));
    }
    for (group, faces) in &result.groups {
        text.push_str(&format!("  faces {group}: {faces}\n"));
    }
    for note in &result.notes {
        text.push_str(&format!("  note: {note}\n"));
    }
    for path in &result.written {
        text.push_str(&format!("  written to {}\n", path.display()));
    }
    text
}
