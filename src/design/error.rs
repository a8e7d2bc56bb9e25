//! Errors in a design, with their place and remedy.

use std::error::Error;
use std::fmt::{self, Display};
use std::io;
use std::path::{Path, PathBuf};

use miette::{Diagnostic, LabeledSpan, Severity, SourceCode};
use nailnoise_documents::{DocumentError, Place};
use nailnoise_dynamics::network::{AssemblyError, Unused};
use nailnoise_quantities::dimension::LENGTH;
use nailnoise_quantities::{Dimension, UnitError};

use super::conflict::Conflict;
use super::derived::Solution;
use super::recorded_surfaces::RecordedSurfaceProblem;
use super::sensors::SensorProblem;
use super::show::show;
use super::springs::Sprung;
use super::surfaces::SurfaceProblem;

/// Why a design cannot be used. As a [`Diagnostic`] it shows the place and the remedy.
#[derive(Debug)]
pub struct DesignError {
    /// The fault.
    pub problem: Problem,
    /// The key concerned, or the `base` key that names a file; none if the error concerns an entire file or no file
    /// gives the key.
    pub at: Option<Box<Place>>,
}

/// The fault of a design.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum Problem {
    /// The file does not exist.
    #[error("there is no design file `{}`", path.display())]
    NotFound {
        /// The requested file.
        path: PathBuf,
        /// A design file nearby with a similar name.
        nearest: Option<PathBuf>,
    },
    /// The file exists but cannot be read.
    #[error("the design file `{}` cannot be read: {source}", path.display())]
    Unreadable {
        /// The file.
        path: PathBuf,
        /// Error of the operating system.
        source: io::Error,
    },
    /// The file contains bytes that are not UTF-8 text.
    #[error("the design file `{}` is not text: line {line} holds bytes that are not UTF-8", path.display())]
    NotText {
        /// The file.
        path: PathBuf,
        /// Line of the first such byte, from 1.
        line: usize,
    },
    /// The text is not valid TOML.
    #[error("this is not TOML: {message}")]
    Syntax {
        /// Fault that the reader found.
        message: String,
    },
    /// A file inherits from itself, directly or indirectly.
    #[error("inheritance loop: {}", chain.join(" -> "))]
    InheritanceLoop {
        /// The files of the loop; the first one is repeated at the end.
        chain: Vec<String>,
    },
    /// A key does not exist.
    #[error("unknown key `{key}`")]
    UnknownKey {
        /// Its full name.
        key: String,
        /// The most similar key, if any.
        nearest: Option<String>,
        /// The permitted keys at this place.
        known: Vec<String>,
    },
    /// A key belongs to an earlier version.
    #[error("`{key}` is no longer a key")]
    Replaced {
        /// Its full name.
        key: String,
        /// The keys that replace it, in words.
        successors: &'static str,
    },
    /// A group does not exist.
    #[error("unknown group `[{group}]`")]
    UnknownGroup {
        /// Its full name.
        group: String,
        /// The most similar group, if any.
        nearest: Option<String>,
        /// The permitted groups at this place.
        known: Vec<String>,
    },
    /// The assembly has an error.
    #[error(transparent)]
    Assembly(Box<AssemblyError>),
    /// The design has its own assembly, but the command only supports tools described by keys.
    #[error("`[cycle]` describes the tool as the assembly \"{name}\"; this command computes only the tool of the keys")]
    DesignAssembly {
        /// Name of the assembly.
        name: String,
    },
    /// An assembly without the workpiece, support and air that its sound needs.
    #[error("the assembly \"{name}\" describes a tool, but no workpiece, support and microphones for its sound")]
    OnlyAssembly {
        /// Name of the assembly.
        name: String,
    },
    /// A key whose value an assembly does not follow.
    #[error("`{key}` = \"{value}\" has no effect on the assembly \"{name}\"")]
    NotOfAssembly {
        /// Full name of the key.
        key: String,
        /// Its value.
        value: String,
        /// Name of the assembly.
        name: String,
        /// What to do instead.
        remedy: &'static str,
    },
    /// The name of a list member is not suitable for results and files.
    #[error("\"{name}\" cannot be a name")]
    BadName {
        /// The name.
        name: String,
    },
    /// A value has the wrong type.
    #[error("`{key}` is {found}, it must be given {expected}")]
    WrongKind {
        /// Full name of the key.
        key: String,
        /// The text at that place.
        found: String,
        /// Description of the allowed values.
        expected: String,
    },
    /// A text does not begin with a number.
    #[error("`{key}`: \"{found}\" is not a number with a unit")]
    BadNumber {
        /// Full name of the key.
        key: String,
        /// The text at that place.
        found: String,
        /// The expected dimension.
        expected: Dimension,
    },
    /// A unit is unknown or ambiguous.
    #[error("`{key}`: {problem}")]
    BadUnit {
        /// Full name of the key.
        key: String,
        /// A description of the error in the unit.
        problem: UnitError,
        /// The expected dimension.
        expected: Dimension,
    },
    /// A unit has the wrong dimension, or a required unit is missing.
    #[error("`{key}` is {expected}, found {}", found_unit(unit, found))]
    WrongUnit {
        /// Full name of the key.
        key: String,
        /// The unit found; empty if there is none.
        unit: String,
        /// Its dimension.
        found: Dimension,
        /// The dimension of the key.
        expected: Dimension,
    },
    /// A gauge pressure is given where only an absolute one makes sense.
    #[error("`{key}` cannot be given as gauge pressure, found the unit `{unit}`")]
    Gauge {
        /// Full name of the key.
        key: String,
        /// The unit found.
        unit: String,
    },
    /// A value is infinite or not a number.
    #[error("`{key}` is {found}, which is not a finite number")]
    NotFinite {
        /// Full name of the key.
        key: String,
        /// The text at that place.
        found: String,
    },
    /// A value is outside the physical limits.
    #[error("`{key}` is {found}, it must be {allowed}")]
    OutsideLimits {
        /// Full name of the key.
        key: String,
        /// The text at that place.
        found: String,
        /// The limit in words.
        allowed: String,
    },
    /// The ends of a range are reversed.
    #[error("the range of `{key}` runs from {low} down to {high}")]
    BadRange {
        /// Full name of the key.
        key: String,
        /// Lower end as shown.
        low: String,
        /// Upper end as shown.
        high: String,
    },
    /// A range does not include the value.
    #[error("the range of `{key}` is {low} .. {high} and leaves out its value, {value}")]
    RangeWithoutValue {
        /// Full name of the key.
        key: String,
        /// The value as shown.
        value: String,
        /// Lower end as shown.
        low: String,
        /// Upper end as shown.
        high: String,
    },
    /// The provenance is unknown.
    #[error("`{key}` has the provenance \"{found}\"")]
    BadProvenance {
        /// Full name of the key.
        key: String,
        /// The text at that place.
        found: String,
    },
    /// A distribution is not possible for the quantity.
    #[error("`{key}` cannot be distributed as \"{distribution}\": {because}")]
    BadDistribution {
        /// Full name of the key.
        key: String,
        /// The distribution in question.
        distribution: &'static str,
        /// Why not.
        because: &'static str,
    },
    /// A file named by a key cannot be found.
    #[error("`{key}` names {}, which cannot be read: {reason}", path.display())]
    NoFile {
        /// Full name of the key.
        key: String,
        /// The file.
        path: PathBuf,
        /// Error of the operating system.
        reason: String,
    },
    /// A name is not in the catalogue.
    #[error("`{key}` is \"{found}\", which is not a known name")]
    UnknownName {
        /// Full name of the key.
        key: String,
        /// The name found.
        found: String,
        /// The most similar name, if any.
        nearest: Option<String>,
        /// The list that shows all names.
        list: &'static str,
    },
    /// Keys are missing in the file and its bases.
    #[error("`{key}` is missing{}", others(*count))]
    Missing {
        /// Full name of the first one.
        key: String,
        /// A possible value.
        example: String,
        /// Number of missing keys.
        count: usize,
        /// Whether it belongs to a member of a list, such as a sensor, which no base completes.
        is_member: bool,
    },
    /// A derived quantity is inconsistent with its primary quantities.
    #[error("`{key}` is given as {given}, but it is computed: {}", computed(value, primaries))]
    Derived {
        /// Full name of the derived quantity.
        key: &'static str,
        /// The value given, in SI units.
        given: String,
        /// The value computed, in SI units.
        value: String,
        /// The primary quantities and their values.
        primaries: Vec<(&'static str, String)>,
    },
    /// Values conflict.
    #[error("{conflict}")]
    Conflict {
        /// The conflict with its numbers.
        conflict: Conflict,
        /// The other keys and their places.
        others: Vec<(&'static str, String)>,
    },
    /// A sensor cannot make the requested measurement.
    #[error("the sensor `{name}` {problem}")]
    Sensor {
        /// Its name.
        name: String,
        /// The fault of the sensor.
        problem: SensorProblem,
    },
    /// A transducer is in a volume that the cycle does not have.
    #[error("`{key}` is `{chamber}`, but the cycle has no volume of this name")]
    NoVolume {
        /// The key.
        key: String,
        /// Its value.
        chamber: String,
        /// The volume with the most similar name.
        nearest: Option<String>,
        /// All volumes, and the words of places in walls.
        known: Vec<String>,
    },
    /// A stage exceeds the memory limit.
    #[error("the {stage} would need {needs}; {allowed}")]
    TooCostly {
        /// Name of the stage.
        stage: &'static str,
        /// Its requirements, in words.
        needs: String,
        /// The limit, in words.
        allowed: String,
        /// The keys that affect it most, and the direction for each.
        keys: &'static [(&'static str, &'static str)],
    },
    /// The place of a surface is invalid.
    #[error("the surface `{name}` {problem}")]
    Surface {
        /// Its name.
        name: String,
        /// The fault of the surface.
        problem: SurfaceProblem,
    },
    /// The mesh of a body does not agree with a recorded surface.
    #[error("`recorded_surfaces.{name}` {problem}")]
    RecordedSurface {
        /// Name of the record.
        name: String,
        /// The fault.
        problem: RecordedSurfaceProblem,
    },
    /// The cap cannot be separated from the rest of the tool body, although its outer side counts towards the exhaust,
    /// or differs from the rest by its cover.
    #[error("{} of {} panels of the tool's outline are its cap, which is set apart here", panels[0], panels[1])]
    Cap {
        /// Name of the surface in the file of a body; none for the parametric one.
        surface: Option<&'static str>,
        /// Number of panels on the cap and on the complete outline.
        panels: [usize; 2],
    },
    /// A spring does not act on its body.
    #[error("the spring `{name}` at ({}, {}, {}) is {} outside the {}", show(point[0], LENGTH), show(point[1], LENGTH),
        show(point[2], LENGTH), show(*distance, LENGTH), body.as_str())]
    Spring {
        /// Its name.
        name: String,
        /// Its body.
        body: Sprung,
        /// Its position \[m\].
        point: [f64; 3],
        /// Distance from the body \[m\].
        distance: f64,
    },
}

fn found_unit(unit: &str, found: &Dimension) -> String {
    if unit.is_empty() {
        "a number without a unit".to_owned()
    } else {
        format!("{found} (`{unit}`)")
    }
}

fn others(count: usize) -> String {
    match count {
        0 | 1 => String::new(),
        2 => ", and 1 other key".to_owned(),
        _ => format!(", and {} other keys", count - 1),
    }
}

fn computed(value: &str, primaries: &[(&'static str, String)]) -> String {
    let from: Vec<_> = primaries
        .iter()
        .map(|(key, value)| format!("{key} = {value}"))
        .collect();
    format!("{} gives {value}", from.join(", "))
}

impl DesignError {
    pub(crate) fn unreadable(path: &Path, source: io::Error, at: Option<&Place>) -> Self {
        let path = path.to_owned();
        let problem = if source.kind() == io::ErrorKind::NotFound {
            let nearest = nearest_design(&path);
            Problem::NotFound { path, nearest }
        } else {
            Problem::Unreadable { path, source }
        };
        problem.at(at.cloned().map(Box::new))
    }

    /// A file that is not TOML.
    pub(crate) fn not_toml(path: &Path, error: DocumentError) -> Self {
        match error {
            DocumentError::NotText { line } => Problem::NotText {
                path: path.to_owned(),
                line,
            }
            .at(None::<Box<Place>>),
            DocumentError::Syntax { message, at } => Problem::Syntax { message }.at(at),
        }
    }

    /// Place of the error; none if an entire file is missing or unreadable.
    pub fn place(&self) -> Option<&Place> {
        self.at.as_deref()
    }

    /// Full name of the key concerned; none if the error concerns no key or several.
    pub fn key(&self) -> Option<&str> {
        self.problem.key()
    }

    /// The remedy.
    pub fn remedy(&self) -> String {
        self.problem.remedy(self.place())
    }
}

impl Display for DesignError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.problem.fmt(f)
    }
}

impl Error for DesignError {
    fn source(&self) -> Option<&(dyn Error + 'static)> {
        self.problem.source()
    }
}

impl Problem {
    /// Adds the place to the error.
    pub(super) fn at(self, place: impl Into<Option<Box<Place>>>) -> DesignError {
        DesignError {
            problem: self,
            at: place.into(),
        }
    }

    fn key(&self) -> Option<&str> {
        match self {
            Self::UnknownKey { key, .. }
            | Self::Replaced { key, .. }
            | Self::WrongKind { key, .. }
            | Self::BadNumber { key, .. }
            | Self::BadUnit { key, .. }
            | Self::WrongUnit { key, .. }
            | Self::Gauge { key, .. }
            | Self::NotFinite { key, .. }
            | Self::OutsideLimits { key, .. }
            | Self::BadRange { key, .. }
            | Self::RangeWithoutValue { key, .. }
            | Self::BadProvenance { key, .. }
            | Self::BadDistribution { key, .. }
            | Self::NoFile { key, .. }
            | Self::Missing { key, .. } => Some(key),
            Self::Derived { key, .. } => Some(key),
            _ => None,
        }
    }

    fn remedy(&self, at: Option<&Place>) -> String {
        match self {
            Self::NotFound { path, nearest } => {
                let meant = nearest
                    .as_ref()
                    .map_or_else(String::new, |near| format!("did you mean `{}`? ", near.display()));
                match at {
                    Some(at) => format!(
                        "{meant}`base` is relative to the folder of the file it stands in, {}",
                        at.file()
                    ),
                    None if meant.is_empty() => format!(
                        "give the path of a design file, as in `nailnoise run designs/n80cb.toml`; \
                         or write `{}` with the one line `base = \"PATH/TO/n80cb.toml\"` and what differs from it",
                        path.display()
                    ),
                    None => meant.trim().to_owned(),
                }
            }
            Self::Unreadable { .. } => "a design is one readable file of TOML text".to_owned(),
            Self::NotText { .. } => "save the file as UTF-8 text".to_owned(),
            Self::Syntax { .. } => {
                "write `key = value`, texts in quotes: pressure = \"763.2 kPa\"; groups as `[supply]`".to_owned()
            }
            Self::InheritanceLoop { .. } => "remove `base` from one of these files".to_owned(),
            Self::UnknownKey { nearest, known, .. } => meant(nearest.as_deref(), known, "the keys here are"),
            Self::Replaced { successors, .. } => format!("give {successors}"),
            Self::UnknownGroup { nearest, known, .. } => meant(nearest.as_deref(), known, "the groups here are"),
            Self::Assembly(error) => error.help(),
            Self::DesignAssembly { .. } => {
                "published forms of the model exist for the tool of the keys: leave out `--as-published`, or `[cycle]`"
                    .to_owned()
            }
            Self::OnlyAssembly { .. } => {
                "add `base = \"n80cb.toml\"` in front of `[cycle]`: workpiece, support, air and microphones of that \
                 design count, and its tool is replaced; `check` and `cycle` need no base"
                    .to_owned()
            }
            Self::NotOfAssembly { remedy, .. } => (*remedy).to_owned(),
            Self::BadName { .. } => "use letters, digits, `_` and `-` alone: [sensors.block_top]".to_owned(),
            Self::Sensor { problem, .. } => problem.remedy(),
            Self::NoVolume { nearest, known, .. } => meant(nearest.as_deref(), known, "choose one of"),
            Self::TooCostly { keys, .. } => {
                let remedy = |(key, what): &(&str, &str)| format!("{what} `{key}`");
                let remedies: Vec<String> = keys.iter().map(remedy).collect();
                format!("{}, or allow more with --memory", remedies.join(" or "))
            }
            Self::Surface { problem, .. } => problem.remedy(),
            Self::RecordedSurface { problem, .. } => problem.remedy(),
            Self::Cap {
                surface: Some(name), ..
            } => format!(
                "name the outer side of the cap with the exhaust's outlets (gmsh: Physical Surface(\"{name}\") = \
                 ...), give its \
                 place in the design ([surfaces.NAME] with surface = \"{name}\"), or choose \"physical\", with a cover \
                 on both surfaces or none"
            ),
            Self::Cap { surface: None, .. } => {
                "the cap is the part above `body.nose_height` and `body.barrel_height` within `body.cap_radius`; or \
                 choose \"physical\", with a cover on both surfaces or none"
                    .to_owned()
            }
            Self::Spring { .. } => {
                "move x, y and z onto the body; the origin is the centre of the workpiece's underside, \
                                    z up"
                    .to_owned()
            }
            Self::WrongKind { key, expected, .. } => format!("give `{key}` {expected}"),
            Self::BadNumber { key, expected, .. } => {
                format!(
                    "give `{key}` as a number, a point and no comma in it, and a unit: {}",
                    expected.examples()
                )
            }
            Self::BadUnit { key, expected, .. } => format!("units of `{key}` are {}", expected.examples()),
            Self::WrongUnit {
                key, expected, unit, ..
            } if unit.is_empty() => format!(
                "add a unit to `{key}` ({}), or give the bare number in {} without quotes",
                expected.examples(),
                expected.unit()
            ),
            Self::WrongUnit { key, expected, .. } => format!("give `{key}` in one of {}", expected.examples()),
            Self::Gauge { key, .. } => format!("give `{key}` as absolute pressure: kPa, bar, psi"),
            Self::NotFinite { key, .. } => format!("give `{key}` a finite number"),
            Self::OutsideLimits { key, allowed, .. } => format!("give `{key}` a value {allowed}"),
            Self::BadRange { key, .. } => format!("write the lower end of the range of `{key}` first"),
            Self::RangeWithoutValue { key, .. } => {
                format!(
                    "give `{key}` a range that includes its value, such as range = \"+-10 %\", or range \
                    = \"exact\""
                )
            }
            Self::BadProvenance { .. } => "begin with published, computed, estimated, decided, numerical, constant or \
                design; the source may follow a colon: \"published: thesis Table 4-3\""
                .to_owned(),
            Self::BadDistribution { key, .. } => {
                format!("correct value or range of `{key}`, or leave its distribution out: it is uniform then")
            }
            Self::NoFile { key, .. } if key.ends_with("penetration_fit") => {
                "name it relative to the folder of this design; `nailnoise penetration fit` writes it".to_owned()
            }
            Self::NoFile { key, .. } => {
                format!(
                    "name it relative to the folder of this design, or write `{key} = \"\"` for the built-in geometry"
                )
            }
            Self::UnknownName { nearest, list, .. } => {
                let meant = nearest
                    .as_ref()
                    .map_or_else(String::new, |near| format!("did you mean \"{near}\"? "));
                format!("{meant}`nailnoise list {list}` prints all names; \"own\" is for values of your own")
            }
            Self::Missing {
                key,
                example,
                count,
                is_member: true,
            } => {
                let others = if *count > 1 { ", and the other keys" } else { "" };
                format!("add `{key} = {example}`{others}; `nailnoise schema` lists them")
            }
            Self::Missing { key, example, .. } => format!(
                "begin the file with `base = \"n80cb.toml\"` (relative to its folder) and give only what differs, \
                 or add `{key} = {example}`"
            ),
            Self::Derived { key, primaries, .. } => {
                let keys: Vec<_> = primaries.iter().map(|(key, _)| format!("`{key}`")).collect();
                let last = primaries
                    .last()
                    .and_then(|(key, _)| key.rsplit('.').next())
                    .unwrap_or_default();
                let follows = if Solution::default_for(key).is_some() {
                    format!("; or give `{key}` as {{ value = ..., follows = \"{last}\" }}")
                } else {
                    String::new()
                };
                format!("remove `{key}` and change {}{follows}", keys.join(", "))
            }
            Self::Conflict { conflict, others, .. } => {
                let also: Vec<_> = others
                    .iter()
                    .map(|(key, place)| format!("`{key}` is set at {place}"))
                    .collect();
                let also = if also.is_empty() {
                    String::new()
                } else {
                    format!("; {}", also.join(", "))
                };
                format!("{}{also}", conflict.remedy())
            }
        }
    }

    /// The name of its kind, and the label shown at its place.
    fn words(&self) -> [&'static str; 2] {
        match self {
            Self::NotFound { .. } => ["not_found", "asked for here"],
            Self::Unreadable { .. } => ["unreadable", "asked for here"],
            Self::NotText { .. } => ["not_text", ""],
            Self::Syntax { .. } => ["syntax", "here"],
            Self::InheritanceLoop { .. } => ["inheritance_loop", "closes the loop"],
            Self::UnknownKey { .. } => ["unknown_key", "unknown key"],
            Self::Replaced { .. } => ["replaced", "replaced"],
            Self::UnknownGroup { .. } => ["unknown_group", "unknown group"],
            Self::Assembly(_) => ["assembly", "here"],
            Self::DesignAssembly { .. } => ["own_assembly", "its own assembly"],
            Self::OnlyAssembly { .. } => ["only_assembly", "without a base"],
            Self::NotOfAssembly { .. } => ["not_of_assembly", "has no effect"],
            Self::BadName { .. } => ["bad_name", "no name"],
            Self::Sensor { .. } => ["sensor", "of this sensor"],
            Self::NoVolume { .. } => ["no_volume", "unknown volume"],
            Self::TooCostly { .. } => ["too_costly", "too costly"],
            Self::Surface { .. } => ["surface", "of this surface"],
            Self::RecordedSurface { .. } => ["recorded_surface", "recorded here"],
            Self::Cap { .. } => ["cap", "the convention"],
            Self::Spring { .. } => ["spring", "of this spring"],
            Self::WrongKind { .. } => ["wrong_kind", "wrong type"],
            Self::BadNumber { .. } => ["bad_number", "not a number with a unit"],
            Self::BadUnit { .. } => ["bad_unit", "unit not understood"],
            Self::WrongUnit { .. } => ["wrong_unit", "wrong unit"],
            Self::Gauge { .. } => ["gauge", "gauge pressure"],
            Self::NotFinite { .. } => ["not_finite", "not finite"],
            Self::OutsideLimits { .. } => ["outside_limits", "outside its limits"],
            Self::BadRange { .. } => ["bad_range", "wrong way round"],
            Self::RangeWithoutValue { .. } => ["range_without_value", "leaves out the value"],
            Self::BadProvenance { .. } => ["bad_provenance", "unknown provenance"],
            Self::BadDistribution { .. } => ["bad_distribution", "not possible here"],
            Self::NoFile { .. } => ["no_file", "no such file"],
            Self::UnknownName { .. } => ["unknown_name", "unknown name"],
            Self::Missing { is_member: true, .. } => ["missing", "incomplete"],
            Self::Missing { .. } => ["missing", "no base here"],
            Self::Derived { .. } => ["derived", "disagrees"],
            Self::Conflict { .. } => ["conflict", "in conflict"],
        }
    }
}

fn meant(nearest: Option<&str>, known: &[String], intro: &str) -> String {
    match nearest {
        Some(near) => format!("did you mean `{near}`?"),
        None => format!("{intro} {}", known.join(", ")),
    }
}

impl Diagnostic for DesignError {
    fn code<'a>(&'a self) -> Option<Box<dyn Display + 'a>> {
        Some(Box::new(format!("design::{}", self.problem.words()[0])))
    }

    fn help<'a>(&'a self) -> Option<Box<dyn Display + 'a>> {
        Some(Box::new(self.remedy()))
    }

    fn source_code(&self) -> Option<&dyn SourceCode> {
        self.place().map(Place::source_code)
    }

    fn labels(&self) -> Option<Box<dyn Iterator<Item = LabeledSpan> + '_>> {
        labels(self.place()?, self.problem.words()[1])
    }
}

/// A remark on a design for the user, which does not stop the run.
#[derive(Debug, Clone, thiserror::Error)]
#[non_exhaustive]
pub enum Warning {
    /// A value is outside the range given in the base. Its own range is assumed from that.
    #[error("`{key}` = {value} is outside its range {low} .. {high} in the base")]
    OutsideRange {
        /// Full name of the key.
        key: String,
        /// The value as shown.
        value: String,
        /// Lower end of the range as shown.
        low: String,
        /// Upper end of the range as shown.
        high: String,
        /// Place of the value.
        at: Box<Place>,
    },
    /// The base is missing, and the design of this name that comes with the program is used instead.
    #[error("`base = \"{name}\"` is not found beside the design: it is the one that comes with nailnoise \
        {}", env!("CARGO_PKG_VERSION"))]
    ShippedBase {
        /// The name of the base as given.
        name: String,
        /// Place of the name.
        at: Box<Place>,
    },
    /// The exhaust is computed up to a frequency below the end of the range in which sources are compared.
    #[error(
        "the exhaust is computed up to `analysis.exhaust_max_frequency` = {top} Hz only: its sound in the bands from \
         {} to {} \
         Hz is \
         missing from its level and from the total, which reach to `analysis.range_high` = {high} Hz",
        bands[0],
        bands[1]
    )]
    ExhaustTop {
        /// Upper end of the exhaust's range \[Hz\].
        top: f64,
        /// Upper end of the range of the levels \[Hz\].
        high: f64,
        /// First and last of the third-octave bands in which the exhaust is partly or completely missing \[Hz\].
        bands: [f64; 2],
        /// Where one of the two is given.
        at: Box<Place>,
    },
    /// A key belongs to an earlier version.
    #[error("`{key}` is now `{successor}`")]
    Renamed {
        /// Full name of the key as given.
        key: String,
        /// Its current name.
        successor: &'static str,
        /// Place of the key.
        at: Box<Place>,
    },
    /// A derived quantity is given and is consistent with its primary ones.
    #[error("`{key}` has no effect: it is computed from {}", primaries.join(", "))]
    Computed {
        /// Full name of the derived quantity.
        key: &'static str,
        /// The primary quantities.
        primaries: Vec<&'static str>,
        /// Place of the key.
        at: Box<Place>,
    },
    /// A block or own key of the assembly has no effect.
    #[error(transparent)]
    Unused(Unused),
}

impl Warning {
    /// The place in question.
    pub fn place(&self) -> &Place {
        match self {
            Self::OutsideRange { at, .. }
            | Self::ExhaustTop { at, .. }
            | Self::Computed { at, .. }
            | Self::Renamed { at, .. }
            | Self::ShippedBase { at, .. } => at,
            Self::Unused(unused) => &unused.at,
        }
    }
}

impl Diagnostic for Warning {
    fn severity(&self) -> Option<Severity> {
        Some(Severity::Warning)
    }

    fn code<'a>(&'a self) -> Option<Box<dyn Display + 'a>> {
        Some(Box::new(match self {
            Self::OutsideRange { .. } => "design::outside_range",
            Self::ExhaustTop { .. } => "design::exhaust_max_frequency",
            Self::Computed { .. } => "design::computed",
            Self::Renamed { .. } => "design::renamed",
            Self::ShippedBase { .. } => "design::shipped_base",
            Self::Unused(_) => "design::unused",
        }))
    }

    fn help<'a>(&'a self) -> Option<Box<dyn Display + 'a>> {
        Some(Box::new(match self {
            Self::OutsideRange { key, .. } => format!(
                "studies draw it from the base's range in proportion to the value; if the value is meant, give its \
                 own range: \
                 {key} = {{ value = ..., range = \"+-10 %\" }}"
            ),
            Self::ExhaustTop { top, .. } => format!(
                "raise `analysis.exhaust_max_frequency` to `analysis.range_high`, or lower `analysis.range_high` to \
                 {top} Hz so \
                 that all \
                 sources are compared in one range"
            ),
            Self::Computed { key, .. } => format!("remove `{key}`"),
            Self::Renamed { .. } => "`nailnoise migrate FILE --write` renames it in the file".to_owned(),
            Self::ShippedBase { name, .. } => format!(
                "`nailnoise init --from {0}` writes it beside the design, where another version of the program does \
                 not change it",
                name.trim_end_matches(".toml")
            ),
            Self::Unused(unused) => unused.help(),
        }))
    }

    fn source_code(&self) -> Option<&dyn SourceCode> {
        Some(self.place().source_code())
    }

    fn labels(&self) -> Option<Box<dyn Iterator<Item = LabeledSpan> + '_>> {
        let label = match self {
            Self::OutsideRange { .. } => "outside the range in the base",
            Self::ExhaustTop { .. } => "the exhaust ends below the range of the levels",
            Self::Computed { .. } => "computed",
            Self::Renamed { .. } => "old name",
            Self::ShippedBase { .. } => "not there",
            Self::Unused(_) => "not named",
        };
        labels(self.place(), label)
    }
}

fn labels<'a>(place: &Place, label: &str) -> Option<Box<dyn Iterator<Item = LabeledSpan> + 'a>> {
    Some(Box::new(std::iter::once(place.label(label))))
}

/// The design file in the same folder whose name is most similar to that of `path`.
fn nearest_design(path: &Path) -> Option<PathBuf> {
    let stem = path.file_stem()?.to_string_lossy().into_owned();
    let folder = path.parent()?;
    let listed = if folder.as_os_str().is_empty() {
        Path::new(".")
    } else {
        folder
    };
    let mut best: Option<(f64, PathBuf)> = None;
    for entry in std::fs::read_dir(listed).ok()?.flatten() {
        let name = PathBuf::from(entry.file_name());
        if name.extension().is_none_or(|extension| extension != "toml") {
            continue;
        }
        let likeness = strsim::jaro_winkler(&stem, &name.file_stem()?.to_string_lossy());
        let better = |(top, other): &(f64, PathBuf)| likeness > *top || (likeness == *top && name < *other);
        if likeness > 0.7 && best.as_ref().is_none_or(better) {
            best = Some((likeness, name));
        }
    }
    best.map(|(_, name)| folder.join(name))
}
