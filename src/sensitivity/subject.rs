//! The tools whose shots are differentiated: that of the keys of a design, and assemblies with or without a design.

use std::collections::BTreeMap;

use nailnoise_dynamics::network::{self, Assembly, KeyValue, Numerics, Record, RunError};
use nailnoise_dynamics::{CycleError, CycleRecord, Settings, simulate};
use nailnoise_quantities::Kind;

use super::{AssemblyOutput, Output};
use crate::design::inputs::assembly::{AssembledTool, cycle as assembled};
use crate::design::inputs::cycle::{cycle_settings, parameters as cycle_parameters};
use crate::design::{Design, Distribution, Entry, Provenance, RangeOrigin, Value, refused_assembly};
use crate::error::Error;
use crate::stages::cycle::{AssembledCycle, UNNAMED};
use crate::study::{Parameter, taking_part};

/// Tolerance of the integration as a fraction of the design's.
const CLOSER: f64 = 1e-2;
/// Maximum sampling interval, for accurate peaks \[s\].
const SAMPLES: f64 = 4e-6;

/// Factors on tolerance and sampling interval.
#[derive(Debug, Clone, Copy)]
pub(super) struct Accuracy {
    pub(super) tolerance: f64,
    pub(super) interval: f64,
}

impl Accuracy {
    /// That of all derivatives.
    pub(super) const USUAL: Self = Self {
        tolerance: 1.0,
        interval: 1.0,
    };
    /// A different one, which shows the noise.
    pub(super) const OTHER: Self = Self {
        tolerance: 0.5,
        interval: 0.62,
    };
}

/// A run with one parameter changed.
pub(super) enum Run {
    Shot(Shot),
    Refused(String),
    Failed(String),
}

/// Outcome and figures of a shot.
pub(super) struct Shot {
    pub(super) outcome: String,
    pub(super) figures: Vec<Option<f64>>,
}

/// A tool whose shot can be computed with a parameter changed.
pub(super) trait Subject: Sync {
    /// The numbers of its cycle that have a range.
    fn parameters(&self) -> Result<Vec<Parameter>, Error>;

    /// Names and SI units of the figures.
    fn names(&self) -> Vec<(String, &'static str)>;

    /// The shot of the tool itself.
    fn shot(&self, accuracy: Accuracy) -> Result<Shot, Error>;

    /// The shot with another value of a parameter.
    fn moved(&self, parameter: &Parameter, x: f64) -> Run;
}

/// The tool of the keys of a design.
pub(super) struct OfKeys<'a> {
    pub(super) design: &'a Design,
    pub(super) outputs: &'a [Output],
}

impl OfKeys<'_> {
    fn settings(&self, accuracy: Accuracy) -> Settings {
        let close = cycle_settings(self.design);
        Settings {
            relative_tolerance: close.relative_tolerance * CLOSER * accuracy.tolerance,
            sample_interval: close.sample_interval.min(SAMPLES) * accuracy.interval,
            ..close
        }
    }

    fn read(&self, record: &CycleRecord) -> Shot {
        Shot {
            outcome: record.figures.outcome.name().to_owned(),
            figures: self.outputs.iter().map(|output| output.of(record)).collect(),
        }
    }
}

impl Subject for OfKeys<'_> {
    fn parameters(&self) -> Result<Vec<Parameter>, Error> {
        taking_part(self.design)
    }

    fn names(&self) -> Vec<(String, &'static str)> {
        let all = self.outputs.iter();
        all.map(|output| (output.name.to_owned(), output.unit)).collect()
    }

    fn shot(&self, accuracy: Accuracy) -> Result<Shot, Error> {
        let record = simulate(&cycle_parameters(self.design)?, &self.settings(accuracy))?;
        Ok(self.read(&record))
    }

    fn moved(&self, parameter: &Parameter, x: f64) -> Run {
        let moved = match changed(self.design, parameter, x) {
            Ok(moved) => moved,
            Err(reason) => return Run::Refused(reason),
        };
        let shot = match cycle_parameters(&moved) {
            Ok(shot) => shot,
            Err(error) => return Run::Refused(error.to_string()),
        };
        match simulate(&shot, &self.settings(Accuracy::USUAL)) {
            Ok(record) => Run::Shot(self.read(&record)),
            Err(
                error @ (CycleError::Integration { .. }
                | CycleError::Collapse { .. }
                | CycleError::Chatter { .. }
                | CycleError::DryFire { .. }),
            ) => Run::Failed(error.to_string()),
            Err(error) => Run::Refused(error.to_string()),
        }
    }
}

/// A design with another value of a parameter, or why there is none.
fn changed(design: &Design, parameter: &Parameter, x: f64) -> Result<Design, String> {
    let mut moved = design.clone();
    let set = moved.set(&[(parameter.change(), Value::Number(x))]);
    set.map_err(|error| error.to_string())?;
    match moved.conflict() {
        Some(conflict) => Err(conflict.to_string()),
        None => Ok(moved),
    }
}

/// The shot of an assembly.
fn of_network(
    assembly: &Assembly,
    numerics: &Numerics,
    accuracy: Accuracy,
    outputs: &[AssemblyOutput],
) -> Result<Shot, RunError> {
    let interval = numerics.sample_interval.unwrap_or(SAMPLES).min(SAMPLES);
    let numerics = Numerics {
        relative_tolerance: numerics.relative_tolerance * CLOSER * accuracy.tolerance,
        sample_interval: Some(interval * accuracy.interval),
        ..*numerics
    };
    let record: Record = network::simulate(assembly, &numerics)?;
    Ok(Shot {
        figures: outputs.iter().map(|output| output.of(&record)).collect(),
        outcome: record.outcome.unwrap_or_else(|| UNNAMED.to_owned()),
    })
}

/// The run of an assembly with a parameter changed.
fn run_of(shot: Result<Shot, RunError>) -> Run {
    match shot {
        Ok(shot) => Run::Shot(shot),
        Err(
            error @ (RunError::Integration { .. }
            | RunError::Collapse { .. }
            | RunError::Chatter { .. }
            | RunError::Switching { .. }),
        ) => Run::Failed(error.to_string()),
        Err(error) => Run::Refused(error.to_string()),
    }
}

fn names(outputs: &[AssemblyOutput]) -> Vec<(String, &'static str)> {
    let all = outputs.iter();
    all.map(|output| (output.name.clone(), output.unit)).collect()
}

/// The assembly of a design.
pub(super) struct OfDesign<'a> {
    pub(super) design: &'a Design,
    pub(super) cycle: &'a AssembledCycle,
    pub(super) outputs: &'a [AssemblyOutput],
}

impl Subject for OfDesign<'_> {
    fn parameters(&self) -> Result<Vec<Parameter>, Error> {
        taking_part(self.design)
    }

    fn names(&self) -> Vec<(String, &'static str)> {
        names(self.outputs)
    }

    fn shot(&self, accuracy: Accuracy) -> Result<Shot, Error> {
        let shot = of_network(&self.cycle.assembly, &self.cycle.numerics, accuracy, self.outputs);
        shot.map_err(|error| self.cycle.placed(error))
    }

    fn moved(&self, parameter: &Parameter, x: f64) -> Run {
        let moved = match changed(self.design, parameter, x) {
            Ok(moved) => moved,
            Err(reason) => return Run::Refused(reason),
        };
        match assembled(&moved) {
            Ok(Some(cycle)) => run_of(of_network(
                &cycle.assembly,
                &self.cycle.numerics,
                Accuracy::USUAL,
                self.outputs,
            )),
            Ok(None) => Run::Refused("the design has no assembly".to_owned()),
            Err(error) => Run::Refused(error.to_string()),
        }
    }
}

/// An assembly without a design.
pub(super) struct OfTool<'a> {
    pub(super) tool: &'a AssembledTool,
    pub(super) outputs: &'a [AssemblyOutput],
}

impl OfTool<'_> {
    /// The assembly with another value of a literal, or why there is none.
    fn with(&self, key: &str, x: f64) -> Result<Assembly, String> {
        let mut literals = self.tool.resolved.literals.iter();
        let Some(literal) = literals.find(|literal| literal.path == key) else {
            return Err(format!("the assembly has no number `{key}`"));
        };
        let Kind::Quantity { dimension, .. } = literal.kind else {
            return Err(format!("`{key}` is not a quantity"));
        };
        if !literal.kind.allows(x) {
            return Err(format!("{key} = {x} must be {}", literal.kind.allowed()));
        }
        let keys = BTreeMap::from([(key.to_owned(), KeyValue::Quantity { si: x, dimension })]);
        let resolved = self.tool.text.resolve(&keys);
        resolved
            .map(|own| own.assembly)
            .map_err(|error| refused_assembly(error).to_string())
    }
}

impl Subject for OfTool<'_> {
    fn parameters(&self) -> Result<Vec<Parameter>, Error> {
        let own = &self.tool.resolved;
        let entries = own.literals.iter().map(|literal| Entry {
            key: literal.path.clone(),
            symbol: "",
            value: Value::Number(literal.si),
            unit: match literal.kind {
                Kind::Quantity { dimension, .. } => dimension.unit(),
                _ => String::new(),
            },
            range: literal.range,
            range_origin: literal.range.map(|_| RangeOrigin::Given),
            distribution: Distribution::default(),
            provenance: Provenance::Design,
            source: String::new(),
            note: literal.note.clone(),
            file: literal.at.file().to_owned(),
            line: literal.at.line(),
        });
        let acts = |parameter: &Parameter| {
            let [low, high] = parameter.range;
            let other = if low == parameter.number() { high } else { low };
            self.with(&parameter.key, other)
                .is_ok_and(|moved| moved != own.assembly)
        };
        Ok(entries.filter_map(Parameter::of).filter(acts).collect())
    }

    fn names(&self) -> Vec<(String, &'static str)> {
        names(self.outputs)
    }

    fn shot(&self, accuracy: Accuracy) -> Result<Shot, Error> {
        let (tool, assembly) = (self.tool, &self.tool.resolved.assembly);
        let shot = of_network(assembly, &tool.numerics, accuracy, self.outputs);
        Ok(shot.map_err(|error| tool.text.placed(assembly, error))?)
    }

    fn moved(&self, parameter: &Parameter, x: f64) -> Run {
        match self.with(&parameter.key, x) {
            Ok(assembly) => run_of(of_network(
                &assembly,
                &self.tool.numerics,
                Accuracy::USUAL,
                self.outputs,
            )),
            Err(reason) => Run::Refused(reason),
        }
    }
}
