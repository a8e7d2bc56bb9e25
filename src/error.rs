//! Errors that can end a command, and its exit status.

use std::path::PathBuf;

use miette::Diagnostic;
use nailnoise_dynamics::CycleError;
use nailnoise_dynamics::network::RunError;
use nailnoise_pipeline::{PipelineError, StageError};
use thiserror::Error;

use crate::design::DesignError;

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
    #[error("the cycle of this assembly cannot be computed")]
    Network(#[source] Box<RunError>),
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
    /// No draw of a study has levels.
    #[error("the levels of none of {draws} draws can be computed; first reason: {reason}")]
    NoLevels {
        /// Number of draws that count.
        draws: usize,
        /// Why the levels of the first draw cannot be computed.
        reason: String,
    },
    /// Levels of a draw that another process should have computed.
    #[error("its levels are not kept")]
    LevelsNotKept,
    /// No candidate of a study is a design whose shot counts.
    #[error(
        "none of {candidates} candidates gives a shot that counts: {}",
        outcomes_and_reasons(outcomes, refused)
    )]
    #[diagnostic(help("{}", if require.is_empty() {
        "narrow the ranges: their values are incompatible".to_owned()
    } else {
        format!("remove `require = \"{require}\"` from [study], or narrow the ranges")
    }))]
    NothingDrawn {
        /// Number of candidates drawn.
        candidates: u64,
        /// Number of candidates by outcome.
        outcomes: String,
        /// Number of candidates that are not valid designs, by reason.
        refused: String,
        /// Outcomes that count.
        require: String,
    },
    /// The Python package cannot be called.
    #[error("{python} cannot import nailnoise and {needed}: {reason}")]
    #[diagnostic(help(
        "install it in the repository, pip install './python[{}]', or name an interpreter that has it in \
         NAILNOISE_PYTHON",
        if *needed == "optuna" { "optimise" } else { "cluster" }
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
        "signal 9 is often a lack of memory; what was computed is cached, and the same command goes on from there"
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
    /// A ranking of input groups over drawn structures.
    #[error(
        "`--groups` and `--structures` exclude each other: every partner of a draw would need a structure of its own"
    )]
    #[diagnostic(help(
        "rank the groups on the structures of the design, without --structures; `{study} --structures` states beside \
         it what structures add"
    ))]
    GroupsOfStructures {
        /// The command without either option.
        study: String,
    },
    /// A cluster did not complete its work.
    #[error("the cluster of the scheduler {scheduler} did not compute all of it")]
    #[diagnostic(help(
        "see its message above; finished work is kept, and the same command resumes, with or without --scheduler"
    ))]
    OnCluster {
        /// Address of the scheduler.
        scheduler: String,
        /// Exit status of the client.
        status: u8,
    },
    /// Draws that tasks should have computed are missing.
    #[error("the levels of {missing} of {draws} draws are not in {}", store.display())]
    #[diagnostic(help(
        "run the tasks that are missing, with the same design, draws and seed; without --collect, this command \
         computes what is missing"
    ))]
    NotCollected {
        /// Number of draws that are not stored.
        missing: usize,
        /// Total number of draws.
        draws: usize,
        /// The store that should contain them.
        store: PathBuf,
    },
    /// A finished result contains no ranges to draw from.
    #[error("{} is a finished result, from which nothing can be drawn", path.display())]
    #[diagnostic(help("give the design file itself, or leave --draws out"))]
    NothingToDraw {
        /// The result.
        path: PathBuf,
    },
    /// The variable of a sweep is not a possible value of a design.
    #[error("the sweep cannot vary this: {error}")]
    #[diagnostic(help("give a key of the design and its values, as in supply.pressure=80psig..110psig:7"))]
    NoAxis {
        /// The fault.
        error: crate::design::AssignmentError,
    },
    /// A sweep with too many points.
    #[error("the grid of the sweep has more than {most} points")]
    #[diagnostic(help("give fewer values, or sweep the keys one after the other"))]
    SweptTooMuch {
        /// Maximum number of points of a grid.
        most: usize,
    },
    /// A key that a sweep would vary twice.
    #[error("the sweep varies `{key}` twice")]
    #[diagnostic(help("give all its values at once, as in {key}=3,5,12"))]
    VariedTwice {
        /// The key.
        key: String,
    },
    /// A sweep without a variable.
    #[error("the sweep has no key to vary")]
    #[diagnostic(help("give a key of the design and its values, as in supply.pressure=80psig..110psig:7"))]
    NothingToVary,
    /// The values of a draw conflict.
    #[error("the values drawn are no design: {reason}")]
    NoDesign {
        /// The conflicting keys, or the fault of one of them.
        reason: String,
    },
    /// Penetration laws could not be compared.
    #[error(transparent)]
    #[diagnostic(transparent)]
    Penetration(#[from] crate::penetration::PenetrationError),
    /// A single design has nothing to be compared with.
    #[error("{} alone has nothing to be compared with", path.display())]
    #[diagnostic(help(
        "name a second design or result, or give measurements: --measured measurement.json, or --measured n80cb for \
         the published ones"
    ))]
    NothingToCompare {
        /// The design.
        path: std::path::PathBuf,
    },
    /// A design with a support that the wrapping test does not use.
    #[error("{design}: a wrapping test has its workpiece on the worktable or in the sandbox, not on \"{support}\"")]
    #[diagnostic(help("set support.kind = \"worktable\" or \"sandbox\""))]
    NoTestSetup {
        /// Name of the design.
        design: String,
        /// Its support.
        support: &'static str,
    },
    /// Measured levels over a range other than that of a design.
    #[error("{} has levels over {:.0} to {:.0} Hz, the design {design} over {:.0} to {:.0} \
        Hz", path.display(), measured[0], measured[1],
        predicted[0], predicted[1])]
    #[diagnostic(help("add --set \"analysis.range_low={} Hz\" --set \"analysis.range_high={} \
        Hz\"", measured[0], measured[1]))]
    MeasuredRange {
        /// The file of measurements.
        path: PathBuf,
        /// Its range \[Hz\].
        measured: [f64; 2],
        /// Name of the design.
        design: String,
        /// Its range \[Hz\].
        predicted: [f64; 2],
    },
    /// A measurement cannot be used.
    #[error(transparent)]
    #[diagnostic(transparent)]
    Measurement(#[from] nailnoise_measurement::MeasurementError),
    /// A design cannot be calibrated.
    #[error(transparent)]
    #[diagnostic(transparent)]
    Calibration(Box<crate::calibration::CalibrationError>),
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
    /// A part of the user's mesh without a material in the design.
    #[error("the mesh has the part \"{part}\", for which the design has no material")]
    #[diagnostic(help("name its volumes {known}"))]
    UnknownPart {
        /// Name of the part.
        part: String,
        /// The permitted names.
        known: String,
    },
    /// A spring is not on its body.
    #[error("the spring \"{spring}\" is {:.1} mm outside its body", distance * 1e3)]
    #[diagnostic(help("move its x, y and z onto the body"))]
    SpringOutside {
        /// Its name.
        spring: String,
        /// Its distance from the body \[m\].
        distance: f64,
    },
    /// The meshed tool is heavier than the tool.
    #[error("the meshed tool body weighs {meshed:.3} kg, more than `tool.mass` = {tool:.3} kg")]
    #[diagnostic(help("thin its walls, or raise `tool.mass`"))]
    TooHeavy {
        /// Mass of the mesh \[kg\].
        meshed: f64,
        /// Mass of the cycle's tool \[kg\].
        tool: f64,
    },
    /// The meshed tool does not have the mass of the cycle's tool.
    #[error("the tool body weighs {found:.3} kg, the tool of the cycle `tool.mass` = {tool:.3} kg")]
    #[diagnostic(help(
        "set `body.lumped = true` for what the mesh lacks of the mass, or set `tool.mass = \"{found:.3} kg\"`"
    ))]
    OtherMass {
        /// Mass of the meshed tool with its lumped masses \[kg\].
        found: f64,
        /// Mass of the cycle's tool \[kg\].
        tool: f64,
    },
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
    /// The user's mesh of the tool does not have a surface for a lumped mass.
    #[error(
        "{mass:.3} kg of the tool's mass belong on the surface \"{group}\"; the mesh has no such surface; it has: \
         {known}"
    )]
    #[diagnostic(help(
        "name that surface (gmsh: Physical Surface(\"{group}\") = ...), give its place in the design ([surfaces.NAME] \
         with \
         surface = \"{group}\"), set its share in `body.lumped_nose` and `body.lumped_magazine`, or set \
         `body.lumped = false` and `tool.mass` to that of the mesh"
    ))]
    NoSeat {
        /// Name of the surface.
        group: &'static str,
        /// Mass that it would carry \[kg\].
        mass: f64,
        /// Existing names.
        known: String,
    },
    /// The mesh of the tool body has no named surface where a force of the shot acts.
    #[error("the mesh of the tool body has no surface \"{group}\" for {what}; it has: {known}")]
    #[diagnostic(help(
        "name that surface (gmsh: Physical Surface(\"{group}\") = ...), give its place in the design ([surfaces.NAME] \
         with \
         surface = \"{group}\"), or set `body.model = \"rigid\"`; the axis of the cylinder is x = y = 0, its bore \
         `piston.bore`, z is up from the tip of the nose"
    ))]
    NoLoadSurface {
        /// Name of the surface.
        group: &'static str,
        /// The load that acts there.
        what: &'static str,
        /// Existing names.
        known: String,
    },
    /// A surface of the tool body is not where the design applies a force.
    #[error("no part of the surface \"{group}\" of the tool body is where {what} act")]
    #[diagnostic(help(
        "put the axis of the cylinder on x = y = 0, or correct `head_valve.inner_diameter` and \
         `head_valve.outer_diameter`: \
         the valve strikes the cap between them"
    ))]
    NoneOfSurface {
        /// Name of the surface.
        group: &'static str,
        /// The load that acts there.
        what: &'static str,
    },
    /// A place of the design is not on any face of its body.
    #[error("no face with that outward direction lies at the position of the surface \"{entry}\"")]
    #[diagnostic(help("move its x, y and z onto the face; along_x, along_y and along_z point out of the body there"))]
    SurfaceOutside {
        /// Its name in the design.
        entry: String,
        /// Distance to the nearest face with the given orientation \[m\]; `None` if there is none.
        distance: Option<f64>,
    },
    /// A cap that cannot be separated from the rest of the body.
    #[error("{} of {} panels of the tool's outline are its cap", panels[0], panels[1])]
    NoCapSurface {
        /// Name of the surface in the file of a body; none for the parametric one.
        surface: Option<&'static str>,
        /// Number of panels on the cap and on the complete outline.
        panels: [usize; 2],
    },
    /// A surface within the tool that is open to the outside.
    #[error("the tool's surface `{surface}`, the wall of an enclosed volume of air, lies in the open air")]
    #[diagnostic(help("close the gap in the wall around that volume"))]
    OpenCavity {
        /// Name of the surface.
        surface: String,
    },
    /// Pieces of a body without a connection.
    #[error(
        "the {body} falls into {pieces} pieces that nothing joins or holds; the smallest has {:.2} cm3 around ({:.1}, \
         {:.1}, \
         {:.1}) mm", volume * 1e6, centre[0] * 1e3, centre[1] * 1e3, centre[2] * 1e3
    )]
    #[diagnostic(help(
        "let the pieces share nodes (gmsh: BooleanFragments or Coherence), name their contact surfaces NAME_slave and \
         NAME_master to tie them, or remove the loose piece"
    ))]
    LoosePiece {
        /// The body.
        body: &'static str,
        /// Number of pieces.
        pieces: usize,
        /// Volume of the smallest piece \[m3\].
        volume: f64,
        /// Its centroid \[m\].
        centre: [f64; 3],
    },
    /// Pieces of a body cannot be tied according to its surfaces.
    #[error("the pieces of the {body} cannot be joined: {cause}")]
    #[diagnostic(help(
        "the surfaces NAME_slave and NAME_master must lie on each other within a tenth of the longest element side; \
         mesh \
         curved ones more finely"
    ))]
    NotTied {
        /// The body.
        body: &'static str,
        /// The cause.
        cause: nailnoise_fem::FemError,
    },
    /// A file that is read in a wrong unit.
    #[error("{} shows {what} that is {found}; expected are {expected}", path.display())]
    #[diagnostic(help("{remedy}"))]
    Extent {
        /// The file.
        path: PathBuf,
        /// The part that it represents.
        what: &'static str,
        /// Its length, with the unit.
        found: String,
        /// The permitted length.
        expected: String,
        /// The unit to give.
        remedy: String,
    },
    /// A sensor that is not on its body.
    #[error("the sensor \"{sensor}\" is {:.4} mm outside the {body}", 1e3 * distance)]
    SensorOffBody {
        /// Its name.
        sensor: String,
        /// Its body.
        body: &'static str,
        /// Its distance from the body \[m\].
        distance: f64,
    },
    /// The sides of a mesh of block or table differ from those that radiate.
    #[error(
        "block and table radiate as boxes of the design's dimensions; the sides of `workpiece.mesh` or \
         `support.worktable.mesh` are others"
    )]
    #[diagnostic(help(
        "give the mesh's dimensions (workpiece.length, width, thickness; support.worktable.length, width, height, \
         top_thickness, leg_width), or set acoustics.method = \"erp\"; on a floor, clamped or on springs a block \
         radiates from the faces of its own mesh"
    ))]
    NotBoxes {
        /// Place of the difference.
        #[source]
        cause: nailnoise_acoustics::AcousticsError,
    },
    /// A microphone or the operator's ear is too close to a body for the pressure there to be computed.
    #[error("a microphone or the operator's ear is too close to a body")]
    #[diagnostic(help(
        "move the ear (`acoustics.ear_along`, `acoustics.ear_across`, `acoustics.ear_height`); the other microphones \
         follow the \
         nail's place and the tool's height"
    ))]
    MicrophoneNearSurface {
        /// The place and its distance.
        #[source]
        cause: nailnoise_acoustics::ReceiverError,
    },
    /// Modes that the cache had lost differ after being computed again.
    #[error("the modes of the {body} are not those to which the cache keeps motions and radiation")]
    #[diagnostic(help(
        "they come from another machine or were damaged: empty it with `nailnoise cache clear` and run again"
    ))]
    OtherModes {
        /// The body.
        body: &'static str,
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
    #[error("`{}` is no design, so that it has no key to set", path.display())]
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
    /// A geometry without a design has no frequency.
    #[error("a geometry alone does not tell how fine its mesh must be")]
    #[diagnostic(help(
        "give the largest element side, as --size \"10 mm\", or name the file in a design (`body.mesh`)"
    ))]
    NoSize,
    /// A unit given for a file that states its own.
    #[error(
        "{} states the unit of its lengths, and {given_in} gives {given} for one unit", path.display()
    )]
    #[diagnostic(help(
        "leave {given_in} out: STEP and IGES files, and meshes written by this program, are read in the unit that \
         they state; a file \
         that states a wrong one must be exported again"
    ))]
    StatedUnit {
        /// The file.
        path: PathBuf,
        /// The unit given.
        given: String,
        /// The option or key that gives it.
        given_in: &'static str,
    },
    /// A solid was requested of a file that is not a solid geometry.
    #[error("{} is no solid geometry, so that --solid has nothing to choose from", path.display())]
    #[diagnostic(help(
        "give a solid geometry (.step, .stp, .brep, .igs) in the place of a design or a mesh; `mesh FILE --solid \
         NUMBER --write PART.msh` \
         makes a mesh that a design can name"
    ))]
    NoSolids {
        /// The file.
        path: PathBuf,
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
    #[diagnostic(help("choose another name for the design; its base is written beside it"))]
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
    /// A file is not a result of a run.
    #[error("{} is no result that can be compared: {reason}", path.display())]
    #[diagnostic(help("give the `result.json` of this version's `nailnoise run`, or the design, which is then run"))]
    NotAResult {
        /// The file.
        path: PathBuf,
        /// The fault of the file.
        reason: String,
    },
    /// The numbers of a finished result are impossible or inconsistent.
    #[error("{} is no result that can be compared: `{at}` is {found}, expected is {expected}", path.display())]
    #[diagnostic(help(
        "the file was changed or damaged: compute it anew with `nailnoise run`, or give the design, which is then run"
    ))]
    Inconsistent {
        /// The file.
        path: PathBuf,
        /// Path of the number in it.
        at: String,
        /// Actual content.
        found: String,
        /// Expected content.
        expected: String,
    },
    /// A name that is not in a list.
    #[error("there is no \"{name}\" among the {list} that nailnoise knows")]
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

impl From<RunError> for Error {
    fn from(error: RunError) -> Self {
        Self::Network(Box::new(error))
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

/// Text about the candidates when none counts: outcomes of shots, and reasons why others are not valid designs.
fn outcomes_and_reasons(outcomes: &str, refused: &str) -> String {
    let refused = (!refused.is_empty()).then(|| format!("no designs: {refused}"));
    let parts = (!outcomes.is_empty())
        .then(|| outcomes.to_owned())
        .into_iter()
        .chain(refused);
    parts.collect::<Vec<_>>().join("; ")
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
        matches!(self, Self::NoLoadSurface { group, .. } if *group == surface)
    }

    /// The error in one line, with causes and remedy.
    pub(crate) fn in_words(&self) -> String {
        let help = Diagnostic::help(self).map_or_else(String::new, |help| format!("; {help}"));
        let causes = std::iter::successors(std::error::Error::source(self), |cause| cause.source());
        let causes: String = causes.map(|cause| format!(": {cause}")).collect();
        format!("{self}{causes}{help}")
    }

    /// Exit status of the command: 2 for incorrect use or input, 3 for a numerical failure.
    pub fn exit_status(&self) -> u8 {
        match self {
            Self::Acoustics(cause) if cause.is_of_the_design() => 2,
            Self::Unusable { problems, .. } => problems.iter().map(Self::exit_status).min().unwrap_or(2),
            Self::Fem(_) | Self::Transient(_) | Self::Acoustics(_) | Self::Json(_) | Self::NoLevels { .. } => 3,
            Self::PythonEnded { .. } => 3,
            Self::Network(error) => match **error {
                RunError::Integration { .. }
                | RunError::Collapse { .. }
                | RunError::Chatter { .. }
                | RunError::Switching { .. } => 3,
                _ => 2,
            },
            Self::Cycle(CycleError::Integration { .. } | CycleError::Collapse { .. } | CycleError::Chatter { .. }) => 3,
            _ => 2,
        }
    }
}
