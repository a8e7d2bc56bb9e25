//! Errors that can end a command, and its exit status.

use std::path::PathBuf;

use miette::{Diagnostic, LabeledSpan, SourceCode};
use nailnoise_dynamics::CycleError;
use nailnoise_dynamics::network::{PlacedError, RunError};
use nailnoise_pipeline::{PipelineError, StageError};
use thiserror::Error;

use crate::comparison::ComparisonError;
use crate::design::DesignError;
use crate::stages::bodies::BodyError;
use crate::stages::radiation::SurfaceError;
use crate::study::StudyError;

/// Reason why a command failed.
#[derive(Debug, Error, Diagnostic)]
#[non_exhaustive]
pub enum Error {
    /// An input of a stage could not be computed.
    #[error(transparent)]
    #[diagnostic(transparent)]
    Pipeline(#[from] PipelineError),
    /// The page of a watched design cannot be served.
    #[error("the page cannot be served on this machine: {source}")]
    #[diagnostic(help("permit connections to 127.0.0.1, or use `nailnoise run`"))]
    Serve {
        /// Message of the operating system.
        source: std::io::Error,
    },
    /// The design file is wrong.
    #[error(transparent)]
    #[diagnostic(transparent)]
    Design(#[from] DesignError),
    /// The cycle could not be computed.
    #[error("the nailing cycle of this design cannot be computed")]
    Cycle(#[from] CycleError),
    /// The cycle of an assembly could not be computed.
    #[error(transparent)]
    #[diagnostic(transparent)]
    Network(Box<NetworkError>),
    /// An option that applies only to a design, given with an assembly.
    #[error("{option} is an option for a design without `[cycle]`")]
    #[diagnostic(help("leave it out: an assembly is computed as its file describes it"))]
    OfDesign {
        /// The option.
        option: &'static str,
    },
    /// An output of the shot that does not exist.
    #[error("there is no output \"{name}\"")]
    #[diagnostic(help("choose from the groups speed, penetration, events, forces, masses, all, or from {known}"))]
    NoSuchOutput {
        /// The name given.
        name: String,
        /// All names.
        known: String,
    },
    /// A parameter with no basis for a sensitivity.
    #[error("`{key}` is not a quantity of the nailing cycle with a range")]
    #[diagnostic(help("{}", match nearest {
        Some(near) => format!("is it `{near}`?"),
        None => "give it a range in the design, or leave --parameters out for all that have one".to_owned(),
    }))]
    NoSuchParameter {
        /// The key given.
        key: String,
        /// The most similar parameter, if one is close.
        nearest: Option<String>,
    },
    /// A study or a sweep cannot be computed.
    #[error(transparent)]
    #[diagnostic(transparent)]
    Study(#[from] StudyError),
    /// An optimisation cannot begin.
    #[error(transparent)]
    #[diagnostic(transparent)]
    Optimisation(#[from] crate::optimisation::OptimisationError),
    /// The Python package cannot be called.
    #[error("{python} cannot import nailnoise and {needed}: {reason}")]
    #[diagnostic(help(
        "install it in the repository, pip install './python[cluster]', or name an interpreter that has it in \
         NAILNOISE_PYTHON"
    ))]
    NoPython {
        /// The interpreter.
        python: String,
        /// Requirement in addition to the package.
        needed: &'static str,
        /// Message of the program.
        reason: String,
    },
    /// The Python process was ended from outside.
    #[error("the Python process was ended by signal {signal}")]
    #[diagnostic(help(
        "signal 9 often means that memory ran out; computed results are cached, and the same command resumes from there"
    ))]
    PythonEnded {
        /// Number of the signal; 0 if unknown.
        signal: u8,
    },
    /// A study to be shipped with the program belongs to a design that is not.
    #[error("`--provide` writes studies of shipped designs, and `{design}` is none")]
    #[diagnostic(help(
        "give a file of the folder `designs` of the repository; the study of any other design is in its `study.json`"
    ))]
    NotShipped {
        /// Its name.
        design: String,
    },
    /// A cluster did not complete its work.
    #[error("the cluster of the scheduler {scheduler} did not compute all of it")]
    #[diagnostic(help(
        "see its message above; finished work is cached, and the same command resumes, with or without --scheduler"
    ))]
    OnCluster {
        /// Address of the scheduler.
        scheduler: String,
        /// Exit status of the client.
        status: u8,
    },
    /// Results cannot be compared.
    #[error(transparent)]
    #[diagnostic(transparent)]
    Comparison(#[from] ComparisonError),
    /// Penetration laws could not be compared.
    #[error(transparent)]
    #[diagnostic(transparent)]
    Penetration(#[from] crate::penetration::PenetrationError),
    /// A design with a support that the wrapping test does not use.
    #[error("{design}: a wrapping test has its workpiece on the worktable or in the sandbox, not on \"{support}\"")]
    #[diagnostic(help("set support.kind = \"worktable\" or \"sandbox\""))]
    NoTestSetup {
        /// Name of the design.
        design: String,
        /// Its support.
        support: &'static str,
    },
    /// A measurement cannot be used.
    #[error(transparent)]
    #[diagnostic(transparent)]
    Measurement(#[from] nailnoise_measurement::MeasurementError),
    /// A design cannot be calibrated.
    #[error(transparent)]
    #[diagnostic(transparent)]
    Calibration(Box<crate::calibration::CalibrationError>),
    /// An HDF5 file could not be composed.
    #[error("hdf5-pure cannot compose the file: {0}")]
    Hdf5(#[source] hdf5_pure::Error),
    /// A document of a word processor could not be composed.
    #[error("docx-rs cannot compose the document: {0}")]
    Document(#[source] docx_rs::DocxError),
    /// A penetration law cannot be evaluated.
    #[error(transparent)]
    #[diagnostic(help("{}", _0.remedy()))]
    Curve(#[from] nailnoise_penetration::CurveError),
    /// A mesh could not be built.
    #[error("the mesh of a body cannot be built")]
    Mesh(#[from] nailnoise_meshes::MeshError),
    /// The modes or the response could not be computed.
    #[error("the structural model cannot be solved")]
    Fem(#[from] nailnoise_fem::FemError),
    /// The sand's constants are outside the range of the foundation's formulas.
    #[error("the sand under the workpiece cannot be modelled")]
    #[diagnostic(help("correct the keys of support.sand"))]
    Sand(#[from] nailnoise_fem::vibration::supports::SandError),
    /// The response of the workpiece could not be computed.
    #[error("the response of workpiece and support cannot be computed")]
    Transient(#[from] nailnoise_fem::vibration::TransientError),
    /// Radiation or exhaust could not be computed.
    #[error("the sound power of a source cannot be computed")]
    Acoustics(#[from] nailnoise_acoustics::AcousticsError),
    /// The rows of a table do not have as many fields as its header.
    #[error("a table cannot be written")]
    Table(#[from] csv::Error),
    /// The chosen support does not include this body.
    #[error("the design \"{design}\" has no {body}: its support is a {support}")]
    #[diagnostic(help("choose --body workpiece, or set support.kind = \"worktable\""))]
    NoSuchBody {
        /// Name of the design.
        design: String,
        /// The requested body.
        body: &'static str,
        /// Support of its workpiece.
        support: &'static str,
    },
    /// A body cannot be used.
    #[error(transparent)]
    #[diagnostic(transparent)]
    Body(#[from] BodyError),
    /// The radiation of a surface cannot be computed.
    #[error(transparent)]
    #[diagnostic(transparent)]
    Surface(#[from] SurfaceError),
    /// Several faults, each of which prevents a run from using a body.
    #[error("the {body} cannot be used: {} problems", problems.len())]
    #[diagnostic(help("`nailnoise check DESIGN --body {body}` shows the mesh with its surfaces"))]
    Unusable {
        /// The body.
        body: &'static str,
        /// The problems.
        #[related]
        problems: Vec<Self>,
    },
    /// The mode does not exist.
    #[error("mode {mode} cannot be shown: the body has {modes} modes")]
    #[diagnostic(help("choose a number from the table of modes, or raise the body's top frequency in [analysis]"))]
    NoMode {
        /// Its number, starting at 1.
        mode: usize,
        /// Number of modes.
        modes: usize,
    },
    /// A design has several bodies, so one must be named.
    #[error("a design has several bodies")]
    #[diagnostic(help("choose one: --body workpiece, --body worktable or --body tool"))]
    NoBody,
    /// Keys can be set only for designs.
    #[error("`{}` is not a design and has no keys to set", path.display())]
    #[diagnostic(help("leave --set out, or name a design file (.toml)"))]
    NothingToSet {
        /// The file given.
        path: PathBuf,
    },
    /// A drawing needs the dimensions of a design.
    #[error("`{}` is not a design: it has no keys to draw", path.display())]
    #[diagnostic(help("leave --drawing out, or name a design file (.toml)"))]
    DrawingOfMesh {
        /// The file given.
        path: PathBuf,
    },
    /// Surfaces are recorded for a design.
    #[error("`{}` is not a design: its surfaces cannot be recorded", path.display())]
    #[diagnostic(help("name the file in a design (`body.mesh`, `workpiece.mesh`), and give the design with --body"))]
    RecordOfMesh {
        /// The file given.
        path: PathBuf,
    },
    /// Surfaces are recorded for a body from a file.
    #[error("a run of the design \"{design}\" solves no {body} from a file: a record of its surfaces has no effect")]
    #[diagnostic(help("leave --record-surfaces out, or name a file in `{key}`"))]
    RecordOfBuiltIn {
        /// Name of the design.
        design: String,
        /// The body.
        body: &'static str,
        /// The key that names its file.
        key: &'static str,
    },
    /// A universal file cannot be used.
    #[error("the measured modes cannot be used")]
    Uff(#[from] nailnoise_meshes::uff::UffError),
    /// A universal file of measured modes contains no coordinates.
    #[error("{} has no coordinates: its modes (dataset 55) cannot be matched with a body by position", path.display())]
    #[diagnostic(help(
        "add the nodes (dataset 15 or 2411) from the file with the geometry; if the points have the numbers of a file \
         that `modes --uff` \
         wrote for this mesh, give --by-number"
    ))]
    NoCoordinates {
        /// The universal file.
        path: PathBuf,
    },
    /// No measured point lies on the body.
    #[error("none of the measured points of {} lies on the body", path.display())]
    #[diagnostic(help("give coordinates in m in the axes of the body, or a larger --mac-reach"))]
    NoPoint {
        /// The universal file.
        path: PathBuf,
    },
    /// The name of a design cannot be the name of a folder.
    #[error(
        "the design file {} has the name \"{name}\", which cannot be the name of a folder for its \
         results", path.display()
    )]
    #[diagnostic(help(
        "rename the file, for example to my-tool.toml; `run`, `cycle` and `modes` also take a folder with --out DIR"
    ))]
    NoFolderName {
        /// The design file.
        path: PathBuf,
        /// Its name without extension.
        name: String,
    },
    /// Standard output could not be written.
    #[error("cannot write to standard output: {source}")]
    #[diagnostic(help("free space where the output goes, or send it elsewhere; files that were written are whole"))]
    Output {
        /// Message of the operating system.
        source: std::io::Error,
    },
    /// A file could not be written.
    #[error("cannot write {}: {source}", path.display())]
    #[diagnostic(help(
        "choose another folder with --out DIR, or free space or permit writing there; no file was replaced"
    ))]
    Write {
        /// The file or folder.
        path: PathBuf,
        /// Message of the operating system.
        source: std::io::Error,
    },
    /// A file could not be written, and some files that had been moved for it could not be put back.
    #[error(
        "cannot write {}: {source}; {} of the older files could not be put back: they are in {}", path.display(),
        files.len(), folder.display()
    )]
    #[diagnostic(help("move them back by hand: {}", files.join(", ")))]
    NotRestored {
        /// The file or folder.
        path: PathBuf,
        /// Message of the operating system.
        source: std::io::Error,
        /// Folder with the older files.
        folder: PathBuf,
        /// Their paths in it.
        files: Vec<String>,
    },
    /// A file to be written already exists.
    #[error("{} is there already, and nothing has been written", path.display())]
    #[diagnostic(help("choose another name, or move it away"))]
    Exists {
        /// The file.
        path: PathBuf,
    },
    /// A design would overwrite its base.
    #[error("{} is the name of a base of this design", path.display())]
    #[diagnostic(help("choose another name for the design; its base is written to the same folder"))]
    NameOfBase {
        /// The file.
        path: PathBuf,
    },
    /// The folder for the installation is unknown.
    #[error("no folder for {what} is known: neither {variable} nor HOME is set")]
    #[diagnostic(help("name a folder with --out DIR"))]
    NoUserFolder {
        /// The item to install.
        what: &'static str,
        /// The variable that would name the folder.
        variable: &'static str,
    },
    /// Completions are requested without the name of a shell.
    #[error("which shell you use is not known")]
    #[diagnostic(help("name it: nailnoise completions bash --install"))]
    NoShell,
    /// The command does not exist.
    #[error("there is no command `{name}`")]
    #[diagnostic(help("`nailnoise --help` lists the commands"))]
    NoSuchCommand {
        /// The name given.
        name: String,
    },
    /// The folder of the cache is missing, or its limit is not valid.
    #[error(transparent)]
    #[diagnostic(transparent)]
    NoCache(#[from] crate::store::StoreError),
    /// The cache's folder could not be read or changed.
    #[error("the cache in {} cannot be used: {source}", path.display())]
    #[diagnostic(help("set NAILNOISE_CACHE to another folder"))]
    Store {
        /// The folder.
        path: PathBuf,
        /// Message of the operating system.
        source: std::io::Error,
    },
    /// A finished result could not be read.
    #[error("cannot read {}: {source}", path.display())]
    #[diagnostic(help("give a design file, or the folder that `nailnoise run` left: out/NAME"))]
    Unreadable {
        /// The file.
        path: PathBuf,
        /// Message of the operating system.
        source: std::io::Error,
    },
    /// A name that is not in a list.
    #[error("there is no \"{name}\" among the {list} of nailnoise")]
    #[diagnostic(help("{}`nailnoise list {list}` prints all names",
        nearest.as_ref().map_or_else(String::new, |near| format!("is it \"{near}\"? "))))]
    UnknownName {
        /// The list.
        list: &'static str,
        /// The name given.
        name: String,
        /// The most similar name, if one is close.
        nearest: Option<String>,
    },
    /// A name given for a list that is always printed in full.
    #[error("{list} are listed as a whole")]
    #[diagnostic(help("leave the name out: `nailnoise list designs`; `nailnoise list woods NAME` prints one wood"))]
    ListName {
        /// The list.
        list: &'static str,
    },
    /// Scaling to another tool is impossible.
    #[error(transparent)]
    #[diagnostic(help("{}", .0.remedy()))]
    Scaling(#[from] crate::scaling::ScalingError),
    /// The thread pool could not be started.
    #[error("the thread pool cannot be started")]
    #[diagnostic(help(
        "the system permits no more threads or no more address space: choose a smaller --threads N, or raise the limit \
         (ulimit -u, ulimit -v)"
    ))]
    Threads(#[source] rayon::ThreadPoolBuildError),
    /// More threads than the command can start.
    #[error("RAYON_NUM_THREADS is \"{found}\"; expected a number from 1 to 1024")]
    #[diagnostic(help("choose another number, or give --threads N"))]
    NumberOfThreads {
        /// Content of the variable.
        found: String,
    },
    /// A result could not be written as JSON.
    #[error("the result cannot be written as JSON")]
    Json(#[source] serde_json::Error),
}

/// Wraps the errors of single modules of the acoustics crate as [`Error::Acoustics`], for `?`.
macro_rules! from_modules_of_acoustics {
    ($($cause:ty),+ $(,)?) => {$(
        impl From<$cause> for Error {
            fn from(cause: $cause) -> Self {
                Self::Acoustics(cause.into())
            }
        }
    )+};
}

from_modules_of_acoustics!(
    nailnoise_acoustics::InputError,
    nailnoise_acoustics::ReceiverError,
    nailnoise_acoustics::bem::BemError,
    nailnoise_acoustics::jets::ExhaustError,
    nailnoise_acoustics::radiation::fluid_loading::FluidLoadingError,
    nailnoise_acoustics::signals::fourier::FourierError,
    nailnoise_acoustics::signals::LevelsError,
    nailnoise_acoustics::radiation::RadiationError,
);

impl From<PlacedError> for Error {
    fn from(placed: PlacedError) -> Self {
        Self::Network(Box::new(NetworkError { placed }))
    }
}

impl From<RunError> for Error {
    fn from(error: RunError) -> Self {
        PlacedError::from(error).into()
    }
}

/// The error of a run of an assembly, shown at the block at fault.
#[derive(Debug, Error)]
#[error("the cycle of this assembly cannot be computed")]
pub struct NetworkError {
    /// The error, with the place of its block.
    #[source]
    pub placed: PlacedError,
}

impl Diagnostic for NetworkError {
    fn source_code(&self) -> Option<&dyn SourceCode> {
        let block = self.placed.block.as_ref()?;
        Some(block.at.source_code())
    }

    fn labels(&self) -> Option<Box<dyn Iterator<Item = LabeledSpan> + '_>> {
        let block = self.placed.block.as_ref()?;
        Some(Box::new(std::iter::once(block.at.label("here"))))
    }
}

impl From<crate::calibration::CalibrationError> for Error {
    fn from(error: crate::calibration::CalibrationError) -> Self {
        Self::Calibration(Box::new(error))
    }
}

impl StageError for Error {
    fn is_cause(&self) -> bool {
        !matches!(self, Self::Pipeline(cause) if !cause.is_cause())
    }
}

impl Error {
    /// Fails if a body has problems; a single problem is returned as the error itself.
    ///
    /// # Errors
    /// The single problem, or [`Self::Unusable`].
    pub(crate) fn of_body(body: &'static str, mut problems: Vec<Self>) -> Result<(), Self> {
        match problems.len() {
            0 => Ok(()),
            1 => Err(problems.remove(0)),
            _ => Err(Self::Unusable { body, problems }),
        }
    }

    /// The individual problems within an error.
    pub(crate) fn parts(self) -> Vec<Self> {
        match self {
            Self::Unusable { problems, .. } => problems.into_iter().flat_map(Self::parts).collect(),
            other => vec![other],
        }
    }

    /// Whether the error is that a surface for a force is missing.
    pub(crate) fn lacks(&self, surface: &str) -> bool {
        matches!(self, Self::Body(BodyError::NoLoadSurface { group, .. }) if *group == surface)
    }

    /// The error in one line, with causes and remedy.
    pub(crate) fn in_words(&self) -> String {
        let help = Diagnostic::help(self).map_or_else(String::new, |help| format!("; {help}"));
        let causes = std::iter::successors(std::error::Error::source(self), |cause| cause.source());
        let causes: String = causes.map(|cause| format!(": {cause}")).collect();
        format!("{self}{causes}{help}")
    }

    /// The same, after file and line of the key at fault in a design.
    pub(crate) fn in_words_with_place(&self) -> String {
        let place = match self {
            Self::Design(error) => error.place(),
            _ => None,
        };
        place.map_or_else(String::new, |place| format!("{place}: ")) + &self.in_words()
    }

    /// Exit status of the command: 2 for incorrect use or input, 3 for a numerical failure.
    pub fn exit_status(&self) -> u8 {
        match self {
            Self::Acoustics(cause) if cause.is_of_the_design() => 2,
            Self::Unusable { problems, .. } => problems.iter().map(Self::exit_status).min().unwrap_or(2),
            Self::Fem(_) | Self::Transient(_) | Self::Acoustics(_) | Self::Json(_) => 3,
            Self::Study(StudyError::NoLevels { .. }) => 3,
            Self::PythonEnded { .. } => 3,
            Self::Network(error) => match error.placed.error {
                RunError::Integration { .. } | RunError::Chatter { .. } => 3,
                _ => 2,
            },
            Self::Cycle(CycleError::Integration { .. } | CycleError::Chatter { .. }) => 3,
            _ => 2,
        }
    }
}
