//! The design file: the definition of a nailer in the terms and units of an engineer.
//!
//! ```text
//! base = "n80cb.toml"                 # inherit everything, relative to this file, and give what differs
//! supply.pressure = "96 psig"         # a text with a unit; bare pressures are absolute, suffix g is gauge
//! piston.mass = 0.131                 # a number is in SI units
//! wood.density = { value = "429 kg/m3", range = "400 .. 480 kg/m3", provenance = "estimated: own scale" }
//! ```
//!
//! [`Design::load`] reads a file and those it inherits from, and converts every quantity to SI. It rejects impossible
//! designs: unknown keys, wrong dimensions, numbers that are not finite, values outside the physical limits,
//! conflicting values, and derived quantities that disagree with their primary ones. Each error names file, line, key
//! and remedy ([`DesignError`]).

mod assembly;
mod assembly_schema;
mod assignment;
mod catalogue;
mod checks;
mod conflict;
mod dependencies;
mod derived;
mod derived_range;
mod derived_value;
mod distribution;
mod entry;
mod error;
mod facts;
mod groups;
pub mod inputs;
mod joint_draws;
mod json_schema;
mod lists;
mod merged;
mod migration;
mod octaves;
mod optional_keys;
mod provenance;
mod range;
mod recorded_surfaces;
mod reference;
mod renamed;
mod report;
mod resolve;
pub(crate) mod rules;
mod sensors;
mod set;
mod settings;
mod show;
mod source;
mod springs;
mod study;
mod suggest;
mod surfaces;
mod tool_outcomes;
mod transducers;

use std::collections::{BTreeMap, BTreeSet};
use std::fmt::Write as _;
use std::ops::{Deref, DerefMut};
use std::path::{Path, PathBuf};
use std::sync::Arc;

use nailnoise_dynamics::network::{AssemblyText, KeyValue};
use nailnoise_quantities::Group;
use sha2::{Digest as _, Sha256};

pub use assignment::{Assignment, AssignmentError};
pub use catalogue::{NailKind, Named, NamedValue, Species, WorktablePreset, nails, woods, worktables};
pub use conflict::Conflict;
pub use dependencies::dependencies;
pub use derived::{AGREEMENT, DERIVED, Derived, Solution};
pub use distribution::Distribution;
pub use entry::Entry;
pub use error::{DesignError, Problem, Warning};
pub use facts::{KeyFacts, Measurement, OutsideValue, facts};
pub use groups::*;
pub use joint_draws::JointDraws;
pub use json_schema::json_schema;
pub use migration::{Migration, RenamedKey, ReplacedKey};
pub use nailnoise_documents::Place;
pub use nailnoise_quantities::{Dimension, GroupSpec, KeySpec, Kind, Name, Sign, UnitError, Value};
pub use octaves::Octaves;
pub use provenance::Provenance;
pub use range::RangeOrigin;
pub use recorded_surfaces::{RecordedSurface, RecordedSurfaceProblem, SurfaceChange};
pub use reference::reference;
pub use report::ReportSettings;
pub use sensors::{Carrier, Sensor, SensorProblem};
pub use set::SetError;
pub use springs::{Spring, Sprung};
pub use study::{Alternative, Correlation, SOURCES, StudySettings};
pub use surfaces::{NamedSurface, SurfaceName, SurfaceOf, SurfaceProblem};
pub use transducers::Transducer;

use crate::error::Error;
use crate::wording::hexadecimal;
use assembly::DesignAssembly;
pub(crate) use assembly::loads_housing;
use derived_range::DerivedRange;
use resolve::{Record, Records, Resolved};

pub(crate) use assembly::refused as refused_assembly;
pub(crate) use nailnoise_documents::nearest as nearest_word;
pub(crate) use renamed::renames;
pub(crate) use show::{mm as length_in_words, show as quantity_in_words};
pub(crate) use source::File;

/// A group of keys that every design has, but that a file with only an assembly does not have.
const OF_DESIGNS: &str = "acoustics";

/// A design: every quantity in SI units, with its origin.
///
/// The groups are fields of the design: `design.supply.pressure` is the supply pressure in Pa. A program may change
/// them. [`digest`](Self::digest) and [`entries`](Self::entries) reflect the change, and [`conflict`](Values::conflict)
/// checks the result.
#[derive(Debug, Clone)]
pub struct Design {
    name: String,
    path: PathBuf,
    values: Values,
    /// Shared, because a study makes thousands of designs that differ only in values.
    records: Arc<Records>,
    /// Derived quantities that a study draws.
    derived: Arc<Vec<DerivedRange>>,
    study: StudySettings,
    report: ReportSettings,
    /// The network of its tables `[cycle]`; none for the tool of the keys.
    assembly: Option<DesignAssembly>,
    warnings: Vec<Warning>,
    /// Standard normal scores with which the fitted penetration law is drawn; empty for the fitted law itself.
    law_scores: Vec<f64>,
}

impl Design {
    /// Reads a design file and those it inherits from.
    ///
    /// # Errors
    /// A [`DesignError`] for the first fault, with its place and remedy.
    pub fn load(path: impl AsRef<Path>) -> Result<Self, DesignError> {
        Self::load_with(path, &[])
    }

    /// Reads a design file and those it inherits from, with other values for some keys; the last value of a key wins.
    ///
    /// # Errors
    /// Same as [`load`](Self::load). A wrong assignment is reported as line 1 of the file `command line`.
    pub fn load_with(path: impl AsRef<Path>, assignments: &[Assignment]) -> Result<Self, DesignError> {
        let path = path.as_ref();
        Self::resolve(path, File::read(path, None)?, assignments)
    }

    /// Reads a design from text as if it were the file `path`; a `base` is relative to the folder of `path`.
    ///
    /// # Errors
    /// Same as [`load`](Self::load).
    pub fn parse(text: &str, path: impl AsRef<Path>) -> Result<Self, DesignError> {
        let path = path.as_ref();
        Self::resolve(path, File::new(path, text), &[])
    }

    /// The design with this path in the folder `designs` that comes with the program.
    pub fn shipped(path: &str) -> Option<Self> {
        Self::resolve(Path::new(path), File::shipped(path)?, &[]).ok()
    }

    fn resolve(path: &Path, file: File, assignments: &[Assignment]) -> Result<Self, DesignError> {
        let over = assignments.iter().rev().map(Assignment::file);
        let chain = assembly::with_assemblies(over.chain(file.chain()?).collect())?;
        let Resolved {
            mut values,
            records,
            derived,
            study,
            report,
            assembly,
            mut warnings,
        } = resolve::resolve(&chain)?;
        warnings.extend(File::shipped_base(&chain));
        let unused = assembly.iter().flat_map(AssemblyText::unused);
        warnings.extend(unused.map(Warning::Unused));
        let name = path
            .file_stem()
            .map_or_else(String::new, |stem| stem.to_string_lossy().into_owned());
        if assembly.as_ref().is_some_and(|text| !loads_housing(text)) {
            values.body.model = BodyModel::Rigid;
        }
        let mut design = Self {
            name,
            path: path.to_owned(),
            values,
            records: Arc::new(records),
            derived: Arc::new(derived),
            study,
            report,
            assembly: assembly.map(DesignAssembly::new),
            warnings,
            law_scores: Vec::new(),
        };
        let read = design.assembly_keys();
        if let (Some(own), Ok(keys)) = (&mut design.assembly, read) {
            own.read(&keys)?;
        }
        match design.conflict() {
            Some(conflict) => Err(resolve::conflicting(conflict, &design.records)),
            None => Ok(design),
        }
    }

    /// The assembly of a file and those it inherits from, together with the design whose keys it uses; without a design
    /// if no base is given and the file is not a design itself. `None` if no file has a table `[cycle]`.
    ///
    /// # Errors
    /// Same as [`load`](Self::load).
    pub(crate) fn load_assembly(
        path: &Path,
        assignments: &[Assignment],
    ) -> Result<Option<LoadedAssembly>, DesignError> {
        let files = File::read(path, None)?.chain()?;
        let has_base = files.len() > 1;
        let over = assignments.iter().rev().map(Assignment::file);
        let chain: Vec<File> = over.chain(files).collect();
        if !assembly::has_cycle(&chain)? {
            return Ok(None);
        }
        let is_design = |file: &File| Ok(file.table()?.contains_key(OF_DESIGNS));
        if has_base || chain.last().map_or(Ok(false), is_design)? {
            return Ok(Some(LoadedAssembly::OfDesign(Box::new(Self::load_with(
                path,
                assignments,
            )?))));
        }
        let text = AssemblyText::open_files(&assembly::documents(&chain)).map_err(assembly::refused)?;
        Ok(Some(LoadedAssembly::Alone(Box::new(text))))
    }

    /// Network given by the tables `[cycle]`; `None` for a design without such tables.
    pub fn assembly(&self) -> Option<&AssemblyText> {
        self.assembly.as_ref().map(DesignAssembly::text)
    }

    /// Same as [`assembly`](Self::assembly), shared.
    pub(crate) fn shared_assembly(&self) -> Option<Arc<AssemblyText>> {
        self.assembly.as_ref().map(DesignAssembly::shared_text)
    }

    /// Fields of its assembly that are not literals, by full name; empty for a design without one.
    pub(crate) fn assembly_fields(&self) -> BTreeMap<String, String> {
        self.assembly.as_ref().map(DesignAssembly::fields).unwrap_or_default()
    }

    /// Values of all keys and of the literals that were set, as the formulas of an assembly read them.
    ///
    /// # Errors
    /// Values of the support that do not yield its stiffness.
    pub(crate) fn assembly_keys(&self) -> Result<BTreeMap<String, KeyValue>, Error> {
        assembly::keys(&self.values, self.set_literals())
    }

    /// Literals of its assembly that were set since it was read, by full name.
    pub(crate) fn set_literals(&self) -> impl Iterator<Item = (&str, f64, Dimension)> {
        self.assembly.iter().flat_map(DesignAssembly::changed)
    }

    /// Sets keys and literals of an assembly by their full names, as [`Values::set`].
    ///
    /// # Errors
    /// [`SetError`] for the first that cannot be set; nothing is changed then.
    pub fn set(&mut self, changes: &[(&str, Value)]) -> Result<(), SetError> {
        let Some(own) = &self.assembly else {
            return self.values.set(changes);
        };
        let (literals, keys): (Vec<_>, Vec<_>) = changes.iter().cloned().partition(|(key, _)| own.is_literal(key));
        let mut own = own.clone();
        for (key, value) in literals {
            own.set(key, &value)?;
        }
        self.values.set(&keys)?;
        self.assembly = Some(own);
        Ok(())
    }

    /// Keys that an assembly leaves without effect; none for the tool of the keys.
    pub(crate) fn idle_keys(&self) -> BTreeSet<String> {
        let mut idle = BTreeSet::new();
        if let Some(own) = &self.assembly {
            self.values.visit("", &mut |key, _, _| {
                if !own.uses(key) {
                    idle.insert(key.to_owned());
                }
            });
        }
        idle
    }

    /// Whether the cycle depends on a key that the tool of the keys reads; false if no formula of an assembly does.
    pub(crate) fn cycle_reads(&self, key: &str) -> bool {
        self.assembly.as_ref().is_none_or(|own| own.reads(key))
    }

    /// Whether a key is a literal of its assembly.
    pub(crate) fn is_literal(&self, key: &str) -> bool {
        self.assembly.as_ref().is_some_and(|own| own.is_literal(key))
    }

    /// The first conflict between values that have an effect, if there is one.
    pub fn conflict(&self) -> Option<Conflict> {
        self.values.conflict_without(&self.idle_keys())
    }

    /// The error that an assembly does not follow the value of a key, at that key.
    pub(crate) fn refuse_for_assembly(&self, key: &str, remedy: &'static str) -> DesignError {
        let record = self.records.get(key);
        let value = record.map_or_else(String::new, |record| match &record.value {
            Value::Choice(word) => (*word).to_owned(),
            other => self.value_in_words(key, other.clone()),
        });
        Problem::NotOfAssembly {
            key: key.to_owned(),
            value,
            name: self.assembly().map_or_else(String::new, |text| text.name().to_owned()),
            remedy,
        }
        .at(record.map(|record| record.place.clone()))
    }

    /// Rejects a design with its own assembly, for operations that support only the built-in tool.
    ///
    /// # Errors
    /// [`Problem::DesignAssembly`].
    pub(crate) fn refuse_assembly(&self) -> Result<(), DesignError> {
        let Some(text) = self.assembly() else { return Ok(()) };
        Err(Problem::DesignAssembly {
            name: text.name().to_owned(),
        }
        .at(None))
    }

    /// The file's name without folder and extension.
    pub fn name(&self) -> &str {
        &self.name
    }

    /// Path of the file, as requested.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// Settings of a study other than ranges, and the definition of shots that count.
    pub fn study(&self) -> &StudySettings {
        &self.study
    }

    /// The design with joint draws of keys in place of those that its file names.
    pub(crate) fn with_joint_draws(&self, draws: std::sync::Arc<JointDraws>) -> Self {
        let mut design = self.clone();
        design.study.draws = Some(draws);
        design
    }

    /// The design with these outcomes as those of shots that count; all count if there are none.
    pub(crate) fn with_required(&self, outcomes: &[String]) -> Self {
        let mut design = self.clone();
        design.study.require = outcomes.to_vec();
        design
    }

    /// Texts in the head of the report, apart from the design. No result depends on it.
    pub fn report(&self) -> &ReportSettings {
        &self.report
    }

    /// Warnings about the design for the user; each is a [`miette::Diagnostic`].
    pub fn warnings(&self) -> &[Warning] {
        &self.warnings
    }

    /// Draws the fitted penetration law of this design from standard normal scores: one for the specimen, then one for
    /// each principal component of the covariance of the coefficients. Without scores, the fitted law itself is used.
    pub(crate) fn draw_law(&mut self, scores: Vec<f64>) {
        self.law_scores = scores;
    }

    /// The scores of [`draw_law`](Self::draw_law).
    pub(crate) fn law_scores(&self) -> &[f64] {
        &self.law_scores
    }

    /// SHA-256 of all values in hexadecimal digits.
    ///
    /// It is the same for two designs whose values agree to twelve digits. It does not depend on the form, the files
    /// and the units of the values, nor on provenance and range.
    pub fn digest(&self) -> String {
        self.digest_without(&[])
    }

    /// SHA-256 of all values except those of some keys.
    pub(crate) fn digest_without(&self, keys: &[&str]) -> String {
        let mut text = String::new();
        self.values.visit("", &mut |key, _, value| {
            if keys.contains(&key) {
                return;
            }
            // Writing to a string cannot fail.
            let _ = match value {
                Value::Number(0.0) => writeln!(text, "{key}=0"),
                Value::Number(value) => writeln!(text, "{key}={value:.11e}"),
                Value::Count(count) => writeln!(text, "{key}={count}"),
                Value::Switch(on) => writeln!(text, "{key}={on}"),
                Value::Choice(word) => writeln!(text, "{key}={word}"),
                Value::File(path) if path.is_empty() => writeln!(text, "{key}="),
                Value::File(path) => writeln!(text, "{key}={}", content(&path)),
                Value::Name(name) => writeln!(text, "{key}={}", name.0),
            };
        });
        for score in &self.law_scores {
            let _ = writeln!(text, "law_score={score:.11e}");
        }
        if let Some(own) = &self.assembly {
            text.push_str(&own.text().canonical());
            for (key, si, _) in own.changed().filter(|(key, ..)| !keys.contains(key)) {
                let _ = writeln!(text, "{key}={si:.11e}");
            }
        }
        hexadecimal(&Sha256::digest(text))
    }

    /// Every key with its kind and value, for tests that vary all of them.
    #[cfg(test)]
    pub(crate) fn keys(&self) -> Vec<(String, Kind, Value)> {
        let mut keys = Vec::new();
        self.values.visit("", &mut |key, spec, value| {
            keys.push((key.to_owned(), spec.kind, value))
        });
        keys
    }

    /// The error that a sensor of this design cannot make the measurement.
    pub(crate) fn refuse_sensor(&self, name: &str, problem: SensorProblem) -> DesignError {
        resolve::sensor(name, problem, &self.records)
    }

    /// The error that a transducer of this design is in a volume that its cycle does not have.
    pub(crate) fn refuse_chamber(&self, transducer: &str, chamber: &str, volumes: &[&str]) -> DesignError {
        let key = format!("transducers.{transducer}.chamber");
        let place = self.records.get(&key).map(|record| record.place.clone());
        Problem::NoVolume {
            nearest: nearest_word(volumes.iter().copied(), chamber).map(str::to_owned),
            known: volumes.iter().map(|&volume| volume.to_owned()).collect(),
            key,
            chamber: chamber.to_owned(),
        }
        .at(place)
    }

    /// The error that a spring of this design is not on its body.
    pub(crate) fn refuse_spring(&self, name: &str, spring: &Spring, distance: f64) -> DesignError {
        let point = [spring.x, spring.y, spring.z];
        resolve::spring(name, (spring.body, point, distance), &self.records)
    }

    /// The error that a stage of this design needs more memory than allowed, at the key of its cost that was set last.
    pub(crate) fn too_costly(
        &self,
        stage: &'static str,
        needs: String,
        allowed: String,
        keys: &'static [(&'static str, &'static str)],
    ) -> DesignError {
        resolve::too_costly((stage, needs, allowed), keys, &self.records)
    }

    /// The error that the cap's panels cannot be separated from those of the rest of the tool body; `panels` are their
    /// numbers.
    pub(crate) fn refuse_cap(&self, surface: Option<&'static str>, panels: [usize; 2]) -> DesignError {
        let key = match self.sources.convention {
            Convention::Wrapping => "sources.convention",
            Convention::Physical => "body.cover.surfaces",
        };
        let record = self.records.get(key);
        Problem::Cap { surface, panels }.at(record.map(|record| record.place.clone()))
    }

    /// The error that the place of a surface of this design is wrong.
    pub(crate) fn refuse_surface(&self, name: &str, problem: SurfaceProblem) -> DesignError {
        resolve::surface(name, problem, &self.records)
    }

    /// The error that the mesh of a body does not agree with the record of a surface of this design.
    pub(crate) fn refuse_record(&self, name: &str, problem: RecordedSurfaceProblem) -> DesignError {
        resolve::recorded_surface(name, problem, &self.records)
    }

    /// Every key with its value in a readable unit, in the order of the reference. A file name is followed by part of
    /// the digest of its content.
    pub fn in_words(&self) -> Vec<(String, String)> {
        let mut words = Vec::new();
        self.values.visit("", &mut |key, spec, value| {
            let text = match &value {
                Value::File(path) if !path.is_empty() => format!("{path} ({:.8})", content(path)),
                _ => resolve::shown(value, spec),
            };
            words.push((key.to_owned(), text));
        });
        words
    }

    /// A value of a key in a readable unit; empty for a key that the design does not have.
    pub(crate) fn value_in_words(&self, key: &str, value: Value) -> String {
        let mut words = String::new();
        self.values.visit("", &mut |own, spec, _| {
            if own == key {
                words = resolve::shown(value.clone(), spec);
            }
        });
        words
    }

    /// The first sentence of the description of each key.
    pub(crate) fn meanings(&self) -> BTreeMap<String, String> {
        let mut meanings = BTreeMap::new();
        self.values.visit("", &mut |key, spec, _| {
            let description = spec.description();
            let first = description
                .split_once(". ")
                .map_or(description.as_str(), |(first, _)| first);
            meanings.insert(key.to_owned(), first.trim_end_matches('.').to_owned());
        });
        meanings
    }

    /// Every key with its value and origin, in the order of the reference.
    ///
    /// A value that the program has changed since the design was read has the provenance "design".
    pub fn entries(&self) -> Vec<Entry> {
        let mut entries = Vec::new();
        self.values.visit("", &mut |key, spec, value| {
            let Some(record) = self.records.get(key) else { return };
            if self.assembly.as_ref().is_some_and(|own| !own.uses(key)) {
                return;
            }
            let Record {
                range,
                range_origin,
                distribution,
                note,
                place,
                ..
            } = record;
            // A numerical setting keeps its class with any value.
            let changed = value != record.value && record.provenance != Provenance::Numerical;
            entries.push(Entry {
                key: key.to_owned(),
                symbol: spec.symbol,
                value,
                unit: spec.unit(),
                range: *range,
                range_origin: *range_origin,
                distribution: *distribution,
                provenance: if changed { Provenance::Design } else { record.provenance },
                source: if changed { String::new() } else { record.source.clone() },
                note: note.clone(),
                file: place.file().to_owned(),
                line: place.line(),
            });
        });
        entries.extend(self.assembly.iter().flat_map(DesignAssembly::entries));
        entries
    }

    /// The derived quantities that a study draws, in the order of the reference, like [`entries`](Self::entries).
    pub fn drawn_derived(&self) -> impl Iterator<Item = (Entry, &'static Solution)> + '_ {
        self.derived.iter().map(|own| (own.entry(&self.values), own.solution))
    }
}

/// An assembly that a command reads.
#[derive(Debug)]
pub(crate) enum LoadedAssembly {
    /// It uses the keys of a design.
    OfDesign(Box<Design>),
    /// Its files give all values.
    Alone(Box<AssemblyText>),
}

/// SHA-256 of the content of a file, so that a digest depends on the content and not on the location; the name of the
/// file if it cannot be read.
fn content(path: &str) -> String {
    std::fs::read(path).map_or_else(|_| path.to_owned(), |bytes| hexadecimal(&Sha256::digest(bytes)))
}

impl Deref for Design {
    type Target = Values;

    fn deref(&self) -> &Values {
        &self.values
    }
}

impl DerefMut for Design {
    fn deref_mut(&mut self) -> &mut Values {
        &mut self.values
    }
}

/// Another value for a key of this kind; `None` if only one is possible.
#[cfg(test)]
pub(crate) fn another(value: &Value, kind: Kind) -> Option<Value> {
    Some(match (kind, value) {
        (_, Value::Number(0.0)) => Value::Number(1e-3),
        (_, Value::Number(number)) => Value::Number(number * (1.0 - 1e-6)),
        (_, Value::Count(count)) => Value::Count(count + 1),
        (_, Value::Switch(on)) => Value::Switch(!on),
        (Kind::Choice(words), Value::Choice(word)) => Value::Choice(words.iter().find(|other| *other != word)?),
        (_, Value::Name(name)) => Value::Name(Name(format!("{}_other", name.0))),
        (_, Value::File(_)) => Value::File(concat!(env!("CARGO_MANIFEST_DIR"), "/README.md").to_owned()),
        _ => return None,
    })
}
