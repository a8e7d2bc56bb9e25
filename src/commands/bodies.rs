//! Common parts of `mesh`, `check` and `modes`: the choice of a body, and input that may be a design or a mesh.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use clap::{Args, ValueEnum};
use nailnoise_fem::ModalCost;
use nailnoise_meshes::msh::Imported;
use nailnoise_meshes::{MeshError, gmsh};

use nailnoise_quantities::dimension::LENGTH;
use nailnoise_quantities::measure;

use super::{Changes, Memory, Threads};
use crate::chain;
use crate::cost::{self, MemoryLimit};
use crate::design::inputs::assembly::AssembledTool;
use crate::design::inputs::{bodies as inputs, located};
use crate::design::{Design, Values};
use crate::error::Error;
use crate::stages::bodies::BodyError;
use crate::stages::bodies::{BodyKind, FileUnit, MeshFile, Meshed, states_unit};

/// Cost of the modes of a body below a frequency \[Hz\].
pub(super) fn modal_cost(meshed: &Meshed, below_hz: f64) -> Result<ModalCost, MeshError> {
    let mesh = &meshed.imported.mesh;
    ModalCost::estimate(mesh, &meshed.materials, &mesh.quality()?, below_hz)
}

/// A body by its name on the command line.
#[derive(Clone, Copy, ValueEnum)]
pub(super) enum BodyName {
    /// The wood block, free
    Workpiece,
    /// The worktable, clamped at the floor
    Worktable,
    /// The tool's body, free
    Tool,
}

impl From<BodyName> for BodyKind {
    fn from(name: BodyName) -> Self {
        match name {
            BodyName::Workpiece => Self::Workpiece,
            BodyName::Worktable => Self::Worktable,
            BodyName::Tool => Self::Tool,
        }
    }
}

/// A length with or without a unit.
pub(super) fn length(text: &str) -> Result<f64, String> {
    let value = measure(text, LENGTH)?;
    if value > 0.0 {
        Ok(value)
    } else {
        Err("must be above zero".to_owned())
    }
}

/// The option that gives the unit of a file.
const UNIT: &str = "--unit";

/// A user's file that replaces a body of the design.
#[derive(Args)]
pub(super) struct Own {
    /// Mesh (.msh) or geometry (.step) that replaces the body, as if the design named it
    #[arg(long, value_name = "FILE")]
    mesh: Option<PathBuf>,
    /// Length of one unit in a file that does not state it, as .msh and .brep [default: from the design, else 1 mm]
    #[arg(long, value_name = "LENGTH", value_parser = length)]
    unit: Option<f64>,
}

impl Own {
    /// Enters the file in the design.
    ///
    /// # Errors
    /// [`BodyError::StatedUnit`] if a unit is given for a file that states its own.
    pub(super) fn replace(&self, design: &mut Design, kind: BodyKind) -> Result<(), Error> {
        let values: &mut Values = design;
        let (mesh, unit) = match kind {
            BodyKind::Workpiece => (&mut values.workpiece.mesh, &mut values.workpiece.mesh_unit),
            BodyKind::Worktable => {
                let table = &mut values.support.worktable;
                (&mut table.mesh, &mut table.mesh_unit)
            }
            BodyKind::Tool => (&mut values.body.mesh, &mut values.body.mesh_unit),
        };
        if let Some(path) = &self.mesh {
            *mesh = path.to_string_lossy().into_owned();
        }
        if let (Some(given), true) = (self.unit, states_unit(Path::new(mesh))) {
            return Err(BodyError::StatedUnit {
                path: PathBuf::from(&*mesh),
                given: format!("{} mm", 1e3 * given),
                given_in: UNIT,
            }
            .into());
        }
        *unit = match &self.mesh {
            // The design's unit belongs to the file named in the design.
            Some(path) if states_unit(path) => FileUnit::USUAL,
            _ => self.unit.unwrap_or(*unit),
        };
        Ok(())
    }
}

/// A design and the choice of a body, or a mesh or geometry of any origin.
#[derive(Args)]
pub(super) struct Input {
    /// Design file (.toml), mesh (.msh, .msh.gz) or geometry (.step, .stp, .brep, .igs)
    #[arg(value_name = "DESIGN|FILE")]
    path: PathBuf,
    /// Body of the design
    #[arg(long, value_enum)]
    body: Option<BodyName>,
    #[command(flatten)]
    own: Own,
    /// Largest element side for a geometry that gmsh meshes
    #[arg(long, value_name = "LENGTH", value_parser = length)]
    size: Option<f64>,
    /// Number of the only solid that is meshed, in a geometry of several; without it, `mesh` lists them and meshes all
    #[arg(long, value_name = "NUMBER", value_parser = clap::value_parser!(u16).range(1..))]
    solid: Option<u16>,
    /// Let gmsh mesh the tool body even if a mesh of its dimensions is shipped
    #[arg(long)]
    remesh: bool,
    #[command(flatten)]
    memory: Memory,
    #[command(flatten)]
    changes: Changes,
    #[command(flatten)]
    threads: Threads,
}

/// A mesh, with the design's body that it represents, if any.
pub(super) struct Loaded {
    /// Name used in headings and files.
    pub(super) name: String,
    /// The mesh.
    pub(super) imported: Imported,
    /// The body, and the frequency below which modes are computed \[Hz\].
    pub(super) body: Option<(Arc<Meshed>, f64)>,
    /// Why the body cannot be used in a run.
    pub(super) problems: Vec<Error>,
    /// The design, and which of its bodies it is; `None` for a mesh alone.
    pub(super) design: Option<(Design, BodyKind)>,
}

impl Input {
    /// Reads or builds the mesh; if `for_run`, also checks whether a run can use the body.
    pub(super) fn load(&self, for_run: bool) -> Result<Loaded, Error> {
        if !self.is_design() {
            if !self.changes.set.is_empty() {
                return Err(Error::NothingToSet {
                    path: self.path.clone(),
                });
            }
            nailnoise_meshes::allow_memory(self.memory.limit().gigabytes);
            let unit = FileUnit::of_option(self.own.unit, UNIT);
            let file = MeshFile::new(&self.path, unit, self.size, None)?.with_solid(self.solid.map(usize::from))?;
            let mut imported = file.import()?;
            if let Some(given_in) = unit.given_in.filter(|_| imported.states_metres && unit.metres != 1.0) {
                return Err(BodyError::StatedUnit {
                    path: self.path.clone(),
                    given: format!("{} mm", 1e3 * unit.metres),
                    given_in,
                }
                .into());
            }
            // `check` lists the faults of a damaged mesh; other commands reject it.
            if !for_run {
                imported.validate()?;
            }
            if file.needs_gmsh() {
                gmsh::name_by_height(&mut imported.mesh);
            }
            let name = self
                .path
                .file_stem()
                .map_or_else(String::new, |stem| stem.to_string_lossy().into_owned());
            return Ok(Loaded {
                name,
                imported,
                body: None,
                problems: Vec::new(),
                design: None,
            });
        }
        let mut design = self.changes.load(&self.path)?;
        let kind = BodyKind::from(self.body.ok_or(Error::NoBody)?);
        self.own.replace(&mut design, kind)?;
        if self.solid.is_some() {
            return Err(BodyError::NoSolids {
                path: self.path.clone(),
            }
            .into());
        }
        if let Some(size) = self.size {
            set_size(&mut design, kind, size);
        }
        cost::refuse(&design, &[cost::of_body(&design, kind)?], self.memory.limit())?;
        let mut problems = Vec::new();
        let meshed = if for_run {
            let checked = chain::check_bodies(&design, &[kind]).into_iter().next();
            let checked = checked.unwrap_or(Err(Error::NoBody))?;
            problems = checked.problems;
            checked.meshed
        } else {
            let geometry = inputs::geometry(&design, kind, self.remesh)?;
            Arc::new(geometry.mesh().map_err(|error| located(&design, error))?)
        };
        Ok(Loaded {
            name: format!("{}: {}", design.name(), kind.name()),
            imported: meshed.imported.clone(),
            body: Some((meshed, inputs::below_hz(&design, kind))),
            problems,
            design: Some((design, kind)),
        })
    }

    /// The design, if no body is chosen.
    pub(super) fn whole_design(&self) -> Result<Option<Design>, Error> {
        (self.is_design() && self.body.is_none())
            .then(|| self.changes.load_without_ranges(&self.path))
            .transpose()
    }

    /// The assembly of a file with a table `[cycle]`, if no body is chosen.
    pub(super) fn assembled(&self) -> Result<Option<AssembledTool>, Error> {
        if !self.is_design() || self.body.is_some() {
            return Ok(None);
        }
        AssembledTool::load(&self.path, &self.changes.set)
    }

    /// Sets the size of the thread pool of the process.
    pub(super) fn start_threads(&self) -> Result<(), Error> {
        self.threads.start()
    }

    /// Memory limit of the command.
    pub(super) fn memory(&self) -> MemoryLimit {
        self.memory.limit()
    }

    /// Whether the file given is a design.
    pub(super) fn is_design(&self) -> bool {
        self.path.extension().is_some_and(|end| end == "toml")
    }

    /// The file given.
    pub(super) fn path(&self) -> &Path {
        &self.path
    }
}

fn set_size(design: &mut Design, kind: BodyKind, size: f64) {
    let analysis = &mut design.analysis;
    match kind {
        BodyKind::Workpiece => analysis.workpiece_element = size,
        BodyKind::Worktable => analysis.worktable_element = size,
        BodyKind::Tool => analysis.body_element = size,
    }
}
