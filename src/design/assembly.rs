//! The assembly of a design: its tables `[cycle]` and `[keys]`.

use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;
use std::sync::Arc;

use nailnoise_documents::{Document, Place};
use nailnoise_dynamics::network::{AssemblyError, AssemblyText, BUILT_IN, Fault, KeyValue, Literal};
use nailnoise_quantities::dimension::NUMBER;
use nailnoise_quantities::{Dimension, Group as _, Kind, Value};

use super::distribution::Distribution;
use super::entry::Entry;
use super::error::{DesignError, Problem};
use super::groups::Values;
use super::provenance::Provenance;
use super::range::RangeOrigin;
use super::set::SetError;
use super::source::File;
use crate::error::Error;
use crate::model::supports;
use crate::stages::bodies::tool_loads::AXIAL_SURFACES;
use crate::stages::cycle::{TOOL, WORKPIECE};

/// Groups of keys that only the cycle reads: an assembly uses those that its formulas name.
const OF_CYCLE: [&str; 10] = [
    "supply.",
    "piston.",
    "head_valve.",
    "chambers.",
    "trigger.",
    "contacts.",
    "tool.",
    "hand.",
    "model.",
    "nail.",
];

/// Keys that place the tool and its forces on the workpiece, whatever the tool is.
const OF_PLACE: [&str; 9] = [
    "nail.length",
    "nail.diameter",
    "nail.offset_along",
    "nail.offset_across",
    "body.nose_width",
    "body.nose_depth",
    "body.nose_height",
    "body.barrel_height",
    "body.cap_height",
];

/// Surfaces of a body on which an assembly may give the force.
const SURFACES: [(&str, &[&str]); 2] = [(TOOL, &AXIAL_SURFACES), (WORKPIECE, &["seat", "nail", "support"])];

/// The assembly of a design, with the literals that a program set.
#[derive(Debug, Clone)]
pub(super) struct DesignAssembly {
    /// Shared, because a study makes thousands of designs that differ only in values.
    read: Arc<EvaluatedAssembly>,
    /// Literals that were set since it was read \[SI\].
    set: BTreeMap<String, f64>,
}

#[derive(Debug, Clone)]
struct EvaluatedAssembly {
    text: Arc<AssemblyText>,
    /// Its numbers, which are keys.
    literals: Vec<Literal>,
    /// Keys of the design that its formulas use.
    used: BTreeSet<String>,
    /// Whether it gives the force on every surface of the housing.
    loads_housing: bool,
}

impl DesignAssembly {
    pub(super) fn new(text: AssemblyText) -> Self {
        Self {
            read: Arc::new(EvaluatedAssembly {
                loads_housing: loads_housing(&text),
                text: Arc::new(text),
                literals: Vec::new(),
                used: BTreeSet::new(),
            }),
            set: BTreeMap::new(),
        }
    }

    /// Evaluates the assembly with values of keys to find its literals and the keys that it uses.
    pub(super) fn read(&mut self, keys: &BTreeMap<String, KeyValue>) -> Result<(), DesignError> {
        let resolved = self.read.text.resolve(keys).map_err(refused)?;
        for (body, surfaces) in SURFACES {
            self.read.text.check_surfaces(body, surfaces).map_err(refused)?;
        }
        self.read = Arc::new(EvaluatedAssembly {
            loads_housing: self.read.loads_housing,
            text: Arc::clone(&self.read.text),
            literals: resolved.literals,
            used: resolved.keys,
        });
        Ok(())
    }

    pub(super) fn text(&self) -> &AssemblyText {
        &self.read.text
    }

    /// The text, shared with the cycle for the places of its blocks.
    pub(super) fn shared_text(&self) -> Arc<AssemblyText> {
        Arc::clone(&self.read.text)
    }

    /// The fields that are not literals, by full name: formulas, names, switches and words.
    pub(super) fn fields(&self) -> BTreeMap<String, String> {
        let literals: BTreeSet<&str> = self.read.literals.iter().map(|own| own.path.as_str()).collect();
        // Range and provenance of a literal are below its path.
        let is_literal = |path: &str| {
            let ends = path.match_indices('.').map(|(end, _)| end).chain([path.len()]);
            ends.into_iter().any(|end| literals.contains(&path[..end]))
        };
        let fields = self.read.text.fields().into_iter();
        let fields = fields.filter(|field| !is_literal(&field.path));
        fields.map(|field| (field.path, field.text)).collect()
    }

    fn literal(&self, key: &str) -> Option<&Literal> {
        self.read.literals.iter().find(|literal| literal.path == key)
    }

    pub(super) fn is_literal(&self, key: &str) -> bool {
        self.literal(key).is_some()
    }

    /// Whether a key of the design has an effect with this assembly.
    pub(super) fn uses(&self, key: &str) -> bool {
        let of_cycle = OF_CYCLE.iter().any(|group| key.starts_with(group));
        let of_housing = key.starts_with("body.") && !self.read.loads_housing;
        !(of_cycle || of_housing) || OF_PLACE.contains(&key) || self.read.used.contains(key)
    }

    /// Whether a formula reads a key.
    pub(super) fn reads(&self, key: &str) -> bool {
        self.read.used.contains(key)
    }

    /// Sets a literal.
    pub(super) fn set(&mut self, key: &str, value: &Value) -> Result<(), SetError> {
        let Some(literal) = self.literal(key) else {
            return Ok(());
        };
        let number = match value {
            Value::Number(number) => *number,
            Value::Count(count) => f64::from(*count),
            Value::Switch(_) | Value::Choice(_) | Value::File(_) | Value::Name(_) => {
                return Err(SetError::WrongKind {
                    key: key.to_owned(),
                    value: value.clone(),
                    expected: "a number",
                });
            }
        };
        if !literal.kind.allows(number) {
            return Err(SetError::OutsideLimits {
                key: key.to_owned(),
                value: number,
                allowed: literal.kind.allowed(),
            });
        }
        self.set.insert(key.to_owned(), number);
        Ok(())
    }

    /// Literals that were set, with their values \[SI\] and dimensions.
    pub(super) fn changed(&self) -> impl Iterator<Item = (&str, f64, Dimension)> {
        self.set.iter().filter_map(|(key, si)| {
            let literal = self.literal(key)?;
            let dimension = match literal.kind {
                Kind::Quantity { dimension, .. } => dimension,
                _ => return None,
            };
            Some((key.as_str(), *si, dimension))
        })
    }

    /// The literals as keys.
    pub(super) fn entries(&self) -> impl Iterator<Item = Entry> {
        self.read.literals.iter().map(|literal| {
            let set = self.set.get(&literal.path);
            let (provenance, source) = match (set, Provenance::parse(&literal.provenance)) {
                (None, Some(found)) => found,
                _ => (Provenance::Design, String::new()),
            };
            Entry {
                key: literal.path.clone(),
                symbol: "",
                value: Value::Number(set.copied().unwrap_or(literal.si)),
                unit: match literal.kind {
                    Kind::Quantity { dimension, .. } => dimension.unit(),
                    _ => String::new(),
                },
                range: literal.range,
                range_origin: literal.range.map(|_| RangeOrigin::Given),
                distribution: Distribution::default(),
                provenance,
                source,
                note: literal.note.clone(),
                file: literal.at.file().to_owned(),
                line: literal.at.line(),
            }
        })
    }
}

/// Whether the cycle gives the force on every surface of the housing.
pub(crate) fn loads_housing(text: &AssemblyText) -> bool {
    let surfaces = text.surfaces(TOOL);
    AXIAL_SURFACES.iter().all(|own| surfaces.contains(own))
}

/// Values of all keys of a design and of the literals that were set, with `support.stiffness`, `support.damping` and
/// `support.damping_ratio` set to those of the chosen support.
pub(super) fn keys<'k>(
    values: &Values,
    literals: impl Iterator<Item = (&'k str, f64, Dimension)>,
) -> Result<BTreeMap<String, KeyValue>, Error> {
    let mut keys = BTreeMap::new();
    values.visit("", &mut |path, spec, value| {
        keys.insert(path.to_owned(), KeyValue::of(spec, &value));
    });
    let support = supports::of(values).lumped()?;
    keys.extend(support.keys(values.workpiece.block.mass(values.wood.density)));
    let exhaust = KeyValue::Quantity {
        si: values.exhaust.coefficient(&values.chambers),
        dimension: NUMBER,
    };
    keys.insert("exhaust.discharge_coefficient".to_owned(), exhaust);
    for (path, si, dimension) in literals {
        keys.insert(path.to_owned(), KeyValue::Quantity { si, dimension });
    }
    Ok(keys)
}

/// Converts the error of an assembly to one of its design.
pub(crate) fn refused(error: AssemblyError) -> DesignError {
    let at = error.at.clone();
    Problem::Assembly(Box::new(error)).at(at)
}

/// The assembly of a chain of files, beginning with the design itself; none if no file has a table `[cycle]`.
pub(super) fn of_chain(chain: &[File]) -> Result<Option<AssemblyText>, DesignError> {
    if !has_cycle(chain)? {
        return Ok(None);
    }
    AssemblyText::open_design(&documents(chain)).map(Some).map_err(refused)
}

/// Whether a file of a chain has a table `[cycle]`.
pub(super) fn has_cycle(chain: &[File]) -> Result<bool, DesignError> {
    for file in chain {
        if file.table()?.contains_key("cycle") {
            return Ok(true);
        }
    }
    Ok(false)
}

/// Number of files of a chain, nearest first, up to the one that names the assembly; all if none names one.
pub(super) fn files_to_name(chain: &[File]) -> Result<usize, DesignError> {
    for (index, file) in chain.iter().enumerate() {
        let table = file.table()?;
        let cycle = table.get("cycle").and_then(|value| value.get_ref().as_table());
        if cycle.is_some_and(|cycle| cycle.contains_key("assembly") || cycle.contains_key("schema")) {
            return Ok(index + 1);
        }
    }
    Ok(chain.len())
}

/// The documents of a chain, beginning with the base.
pub(super) fn documents(chain: &[File]) -> Vec<Document> {
    chain.iter().rev().map(|file| file.document().clone()).collect()
}

/// A chain of files in which an assembly follows the file that names it. The keys that the assembly gives therefore
/// count unless that file or a nearer one gives them.
pub(super) fn with_assemblies(chain: Vec<File>) -> Result<Vec<File>, DesignError> {
    let mut all = Vec::with_capacity(chain.len());
    for file in chain {
        let assembly = named(&file)?;
        all.push(file);
        all.extend(assembly);
    }
    Ok(all)
}

/// The assembly that a file names in its table `[cycle]`. None if the file does not name one, or if the assembly cannot
/// be read. The reader of the assembly reports that error.
fn named(file: &File) -> Result<Option<File>, DesignError> {
    let table = file.table()?;
    let cycle = table.get("cycle").and_then(|value| value.get_ref().as_table());
    let Some(name) = cycle.and_then(|cycle| cycle.get("assembly")?.get_ref().as_str()) else {
        return Ok(None);
    };
    if let Some((name, text)) = BUILT_IN.into_iter().find(|(own, _)| *own == name) {
        return Ok(Some(File::new(Path::new(&format!("assemblies/{name}.toml")), text)));
    }
    Ok(File::read(&file.beside(name), None).ok())
}

/// The error of a command that needs more than an assembly, at the table `[cycle]` of the file closest to the design.
pub(super) fn only_assembly(text: &AssemblyText, chain: &[File]) -> DesignError {
    let place = chain.iter().find_map(|file| {
        let table = file.table().ok()?;
        let (key, _) = table.get_key_value("cycle")?;
        Some(file.place(key.span()))
    });
    Problem::OnlyAssembly {
        name: text.name().to_owned(),
    }
    .at(place)
}

/// Keys that an assembly adds to those of a design.
#[derive(Debug, Default)]
pub(crate) struct AssemblyKeys {
    /// Whether there is an assembly.
    given: bool,
    /// Full names of the keys that it declares.
    declared: BTreeSet<String>,
}

impl AssemblyKeys {
    pub(super) fn of(text: Option<&AssemblyText>) -> Self {
        Self {
            given: text.is_some(),
            declared: text
                .map(|text| text.declared().keys().cloned().collect())
                .unwrap_or_default(),
        }
    }

    /// Whether the key or group of this name is read by the reader of the assembly.
    pub(super) fn covers(&self, name: &str) -> bool {
        self.given && (matches!(name, "cycle" | "keys") || self.declared.contains(name)) || self.is_group(name)
    }

    /// Whether this is a group of keys that the assembly declares.
    pub(super) fn is_group(&self, name: &str) -> bool {
        let group = format!("{name}.");
        self.declared.iter().any(|key| key.starts_with(&group))
    }

    /// The error for an undeclared key in such a group.
    pub(super) fn undeclared(&self, key: &str, at: Box<Place>) -> DesignError {
        refused(AssemblyError {
            path: key.to_owned(),
            fault: Fault::Undeclared {
                key: key.to_owned(),
                known: self.declared.iter().cloned().collect(),
            },
            at,
            changes: Box::default(),
        })
    }
}
