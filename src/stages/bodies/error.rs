//! Faults of a body and its surfaces.

use std::path::PathBuf;

use miette::Diagnostic;
use thiserror::Error;

/// Reason why a body of the model cannot be used.
#[derive(Debug, Error, Diagnostic)]
#[non_exhaustive]
pub enum BodyError {
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
    /// Modes that the cache had lost differ after being computed again.
    #[error("the modes of the {body} are not those to which the cache keeps motions and radiation")]
    #[diagnostic(help(
        "they come from another machine or were damaged: empty it with `nailnoise cache clear` and run again"
    ))]
    OtherModes {
        /// The body.
        body: &'static str,
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
}
