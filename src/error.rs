//! What can end a command, and the exit status it ends with.

use std::path::PathBuf;

use miette::Diagnostic;
use nailnoise_dynamics::CycleError;
use thiserror::Error;

use crate::design::DesignError;

/// Why a command could not do what it was asked.
#[derive(Debug, Error, Diagnostic)]
#[non_exhaustive]
pub enum Error {
    /// The design file is wrong.
    #[error(transparent)]
    #[diagnostic(transparent)]
    Design(#[from] DesignError),
    /// The cycle could not be computed.
    #[error("the nailing cycle of this design cannot be computed")]
    Cycle(#[from] CycleError),
    /// A figure of the shot that does not exist.
    #[error("there is no output \"{name}\"")]
    #[diagnostic(help("choose from the groups speed, penetration, events, forces, masses, all, or from {known}"))]
    NoSuchOutput {
        /// The name given.
        name: String,
        /// All names.
        known: String,
    },
    /// A parameter for whose sensitivity there is nothing to go by.
    #[error("`{key}` is no quantity with a range that takes part in the nailing cycle")]
    #[diagnostic(help("{}", match nearest {
        Some(near) => format!("is it `{near}`?"),
        None => "give it a range in the design, or leave --parameters out for all that have one".to_owned(),
    }))]
    NoSuchParameter {
        /// The key given.
        key: String,
        /// The parameter most like it, if one is near.
        nearest: Option<String>,
    },
    /// Penetration laws could not be compared.
    #[error(transparent)]
    #[diagnostic(transparent)]
    Penetration(#[from] crate::penetration::PenetrationError),
    /// A mesh could not be built.
    #[error("the mesh of a body cannot be built")]
    Mesh(#[from] nailnoise_meshes::MeshError),
    /// The modes or the response could not be computed.
    #[error("the structural model cannot be solved")]
    Fem(#[from] nailnoise_fem::FemError),
    /// The sand's constants are outside the range of the foundation's formulas.
    #[error("the sand under the workpiece cannot be modelled")]
    #[diagnostic(help("correct the keys of support.sand"))]
    Sand(#[from] nailnoise_fem::supports::SandError),
    /// The response of the workpiece could not be computed.
    #[error("the response of workpiece and support cannot be computed")]
    Transient(#[from] nailnoise_fem::transient::TransientError),
    /// Radiation or exhaust could not be computed.
    #[error("the sound power of a source cannot be computed")]
    Acoustics(#[from] nailnoise_acoustics::AcousticsError),
    /// The chosen support has no body of this name.
    #[error("the design \"{design}\" has no {body}: its support is a {support}")]
    #[diagnostic(help("choose --body workpiece, or set support.kind = \"worktable\""))]
    NoSuchBody {
        /// Name of the design.
        design: String,
        /// The body asked for.
        body: &'static str,
        /// What its workpiece stands on.
        support: &'static str,
    },
    /// A file could not be written.
    #[error("cannot write {}: {source}", path.display())]
    #[diagnostic(help("choose a folder that can be written with --out DIR"))]
    Write {
        /// The file or folder.
        path: PathBuf,
        /// What the system said.
        source: std::io::Error,
    },
    /// A finished result could not be read.
    #[error("cannot read {}: {source}", path.display())]
    #[diagnostic(help("give a design file, or the folder that `nailnoise run` left: out/NAME"))]
    Unreadable {
        /// The file.
        path: PathBuf,
        /// What the system said.
        source: std::io::Error,
    },
    /// A file is no result of a run.
    #[error("{} is no result that can be compared: {reason}", path.display())]
    #[diagnostic(help("give the `result.json` of this version's `nailnoise run`, or the design, which is then run"))]
    NotAResult {
        /// The file.
        path: PathBuf,
        /// What is wrong with it.
        reason: String,
    },
    /// The thread pool could not be started.
    #[error("the thread pool cannot be started")]
    #[diagnostic(help("choose a smaller --threads N"))]
    Threads(#[source] rayon::ThreadPoolBuildError),
    /// A result could not be written as JSON.
    #[error("the result cannot be written as JSON")]
    Json(#[source] serde_json::Error),
}

impl Error {
    /// Exit status of the command: 2 for wrong use or input, 3 for a numerical failure.
    pub fn exit_status(&self) -> u8 {
        match self {
            Self::Acoustics(cause) if cause.is_of_the_design() => 2,
            Self::Fem(_) | Self::Transient(_) | Self::Acoustics(_) | Self::Json(_) => 3,
            Self::Cycle(CycleError::Integration { .. } | CycleError::Collapse { .. } | CycleError::Chatter { .. }) => 3,
            _ => 2,
        }
    }
}
