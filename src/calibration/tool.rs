//! The tool of a design as a simulator of measurements: variables of the study, shared errors of readings, and one
//! cycle per condition.

use std::borrow::Cow;
use std::collections::BTreeMap;

use nailnoise_calibration::Simulator;
use nailnoise_calibration::likelihood::{Datum, ErrorCorrelation, ErrorLaw, Likelihood, Prediction, SharedError};
use nailnoise_dynamics::network::Assembly;
use rayon::prelude::*;

use super::error::CalibrationError;
use super::figures::Figure;
use super::measurements::{COMMON, InstrumentError, Measured, Measurements};
use super::quantities::{END_OF_DRIVE, Family, Quantity};
use super::shot::{Shot, assembly_of};
use crate::design::{Derived, Design, Value};
use crate::error::Error;
use crate::study::{
    Parameter, Point, Sampler, Variable, VariableKind, cycle_variables, differing_keys, drawn, value_at,
};

/// Length of a record that is not used \[s\].
const SHORTEST: f64 = 1e-3;

/// Shots under one condition.
pub(super) struct Shots {
    /// Name of the condition; that of the design itself if it only serves to check `require`.
    pub(super) name: String,
    /// The design with the settings of the condition.
    pub(super) design: Design,
    /// Allowed outcomes of a shot; any if empty.
    pub(super) outcomes: Vec<String>,
    /// Settings that were read from an instrument.
    shown: Vec<ShownError>,
    quantities: Vec<Quantity>,
    end: f64,
}

/// The error of an instrument in a setting.
struct ShownError {
    key: String,
    shown: f64,
    error: SharedError,
}

/// A shot that was computed.
pub(super) struct Observed {
    /// Name of its outcome.
    pub(super) outcome: Cow<'static, str>,
    /// Predictions for the readings of its condition, in order.
    pub(super) predictions: Vec<Prediction>,
}

/// The tool of a design under the conditions of its measurements.
pub(super) struct Tool {
    /// Draws of the keys.
    pub(super) sampler: Sampler,
    /// Names of the shared errors of readings, whose variables follow those of the keys.
    pub(super) shared: Vec<String>,
    /// The conditions; those of the file may be followed by one of the design itself.
    pub(super) conditions: Vec<Shots>,
    /// Figures of the design's own shot.
    pub(super) figures: Vec<Figure>,
    /// The design's own assembly; none for the tool of the keys.
    pub(super) assembly: Option<Assembly>,
}

impl Tool {
    /// The tool of a design and its measurements.
    ///
    /// # Errors
    /// If there are no variables, or the design's values do not yield a cycle.
    pub(super) fn new(design: &Design, measured: &Measurements, seed: u64) -> Result<Self, Error> {
        let variables = variables(design, measured)?;
        if variables.is_empty() {
            return Err(CalibrationError::NoVariables.into());
        }
        let keys = variables.len();
        let mut shared: Vec<String> = measured
            .instruments
            .iter()
            .map(|name| format!("instrument.{name}"))
            .collect();
        shared.extend(families(measured).iter().map(Family::name));
        let mut conditions: Vec<Shots> = measured
            .conditions
            .iter()
            .enumerate()
            .map(|(number, condition)| {
                let data = measured.data.iter().filter(|own| own.condition == number);
                let quantities: Vec<Quantity> = data.map(|own| own.quantity.clone()).collect();
                let shown = condition.shown.iter().map(|own| ShownError {
                    shown: number_of(&condition.design, &own.key),
                    key: own.key.clone(),
                    error: SharedError {
                        variable: keys + own.instrument,
                        coefficient: own.deviation,
                    },
                });
                Shots {
                    name: condition.name.clone(),
                    end: end(&condition.design, &quantities, !condition.outcomes.is_empty()),
                    outcomes: condition.outcomes.clone(),
                    shown: shown.collect(),
                    design: condition.design.clone(),
                    quantities,
                }
            })
            .collect();
        // The design's own requirements apply to its own values, unless a condition with these values is as strict.
        let require = &design.study().require;
        let is_required = |outcome: &String| require.contains(outcome);
        let is_own = |own: &Shots| {
            !own.outcomes.is_empty() && own.outcomes.iter().all(is_required) && are_equal(design, &own.design)
        };
        if !require.is_empty() && !conditions.iter().any(is_own) {
            conditions.push(Shots {
                name: design.name().to_owned(),
                design: design.clone(),
                outcomes: require.iter().map(ToString::to_string).collect(),
                shown: Vec::new(),
                quantities: Vec::new(),
                end: end(design, &[], true),
            });
        }
        for condition in &mut conditions {
            condition.design.sensors.clear();
        }
        let mut base = design.clone();
        base.sensors.clear();
        let assembly = assembly_of(design)?;
        Ok(Self {
            sampler: Sampler::new(&base, variables, seed),
            shared,
            conditions,
            figures: Figure::all(assembly.as_ref()),
            assembly,
        })
    }

    /// Number of variables that are keys of the design.
    pub(super) fn keys(&self) -> usize {
        self.sampler.variables().len()
    }

    /// Name of a variable.
    pub(super) fn name(&self, variable: usize) -> &str {
        match self.sampler.variables().get(variable) {
            Some(own) => &own.name,
            None => &self.shared[variable - self.keys()],
        }
    }

    /// The value of a variable at a point; a shared error is in standard deviations.
    pub(super) fn value(&self, variable: usize, z: &[f64]) -> f64 {
        let Some(own) = self.sampler.variables().get(variable) else {
            return z[variable];
        };
        let share = self.point(z).shares[variable];
        value_at(own, share.clamp(1e-12, 1.0 - 1e-12)).unwrap_or(f64::NAN)
    }

    /// The values of the keys in the form used by the study.
    pub(super) fn point(&self, z: &[f64]) -> Point {
        self.sampler.of_normal(&z[..self.keys()])
    }

    /// The design with a point's values, otherwise equal to `around`.
    pub(super) fn design(&self, around: &Design, z: &[f64]) -> Option<Design> {
        drawn(around, &self.sampler, around, &self.point(z)).ok()
    }

    /// Figures of the shots of `around` with the values of some points; NaN if missing.
    pub(super) fn figures_at<'z>(&self, around: &Design, points: impl Iterator<Item = &'z [f64]>) -> Vec<Vec<f64>> {
        let points: Vec<&[f64]> = points.collect();
        let figures = |z: &&[f64]| {
            let own = self.design(around, z)?;
            let shot = Shot::of(&own, own.analysis.cycle_end, false).ok()?;
            Some(self.figures.iter().map(|figure| figure.of(&shot)).collect())
        };
        let rows = points.par_iter().map(figures);
        rows.map(|row: Option<Vec<f64>>| row.unwrap_or_else(|| vec![f64::NAN; self.figures.len()]))
            .collect()
    }

    /// The shot of a point under a condition.
    ///
    /// # Errors
    /// Why the shot is missing: `refused`, `dry_fire` or `solver_failure`.
    pub(super) fn observe(&self, z: &[f64], condition: usize) -> Result<Observed, &'static str> {
        let own = &self.conditions[condition];
        let mut design = self.design(&own.design, z).ok_or("refused")?;
        for shown in &own.shown {
            let value = shown.shown + shown.error.coefficient * z[shown.error.variable];
            design
                .set(&[(&shown.key, Value::Number(value))])
                .map_err(|_| "refused")?;
        }
        let shot = Shot::of(&design, own.end, !own.outcomes.is_empty())?;
        let predict = |quantity: &Quantity| quantity.predict(&shot, &design.ambient, own.end);
        Ok(Observed {
            outcome: shot.outcome(),
            predictions: own.quantities.iter().map(predict).collect(),
        })
    }
}

impl Simulator for Tool {
    fn variables(&self) -> usize {
        self.keys() + self.shared.len()
    }

    fn predict(&self, z: &[f64], condition: usize) -> Result<Vec<Prediction>, Cow<'static, str>> {
        let observed = self.observe(z, condition)?;
        let allowed = &self.conditions[condition].outcomes;
        if allowed.is_empty() || allowed.iter().any(|own| *own == observed.outcome) {
            Ok(observed.predictions)
        } else {
            Err(observed.outcome)
        }
    }

    fn is_ruled(&self) -> Vec<bool> {
        let mut ruled = self.sampler.is_ruled();
        ruled.resize(self.variables(), false);
        ruled
    }

    fn restore(&self, proposed: &mut [f64], current: &[f64]) {
        for condition in &self.conditions {
            let point = self.point(proposed);
            let broken = self.sampler.broken(&condition.design, &point).flatten();
            for &member in broken {
                proposed[member] = current[member];
            }
        }
    }
}

/// Length of the record needed for these quantities \[s\].
fn end(design: &Design, quantities: &[Quantity], has_outcome: bool) -> f64 {
    let of_design = design.analysis.cycle_end;
    // A condition without quantities and outcome has only measured levels; its cycle is not needed here.
    let ends = quantities.iter().map(|own| own.end(of_design));
    let ends = ends.chain(has_outcome.then_some(of_design.min(END_OF_DRIVE)));
    ends.reduce(f64::max).unwrap_or(SHORTEST)
}

/// Whether two designs have the same values, up to the rounding of a conversion: 96 psig equals 763.2 kPa absolute.
fn are_equal(a: &Design, b: &Design) -> bool {
    const ROUNDING: f64 = 1e-3;
    let is_equal = |key: &String| {
        let [a, b] = [a, b].map(|own| number_of(own, key));
        (a - b).abs() <= ROUNDING * a.abs()
    };
    differing_keys(&[a, b]).iter().all(is_equal)
}

/// The value of a key that is a quantity.
fn number_of(design: &Design, key: &str) -> f64 {
    let entries = design.entries();
    let value = entries.iter().find(|entry| entry.key == key).map(|entry| &entry.value);
    match value {
        Some(Value::Number(value)) => *value,
        Some(Value::Count(count)) => f64::from(*count),
        _ => f64::NAN,
    }
}

/// Families of the readings, without duplicates.
fn families(measured: &Measurements) -> Vec<Family> {
    let mut families: Vec<Family> = measured.data.iter().filter_map(|own| own.quantity.family()).collect();
    families.sort();
    families.dedup();
    families
}

/// The variables of the cycle that no condition sets, narrowed if the key was measured.
fn variables(design: &Design, measured: &Measurements) -> Result<Vec<Variable>, Error> {
    let mut designs = vec![design];
    designs.extend(measured.conditions.iter().map(|own| &own.design));
    let mut set = differing_keys(&designs);
    set.extend(measured.conditions.iter().flat_map(|own| own.set.iter().cloned()));
    let is_set = |name: &str| {
        let primaries = Derived::find(name).map_or(&[][..], |derived| derived.primaries);
        set.iter().any(|key| key == name || primaries.contains(&key.as_str()))
    };
    let mut variables = cycle_variables(design)?;
    variables.retain(|own| !is_set(&own.name));
    for variable in &mut variables {
        let direct = measured.direct.iter().find(|own| own.key == variable.name);
        if let (Some(direct), VariableKind::Quantity(parameter)) = (direct, &mut variable.kind) {
            *parameter = Parameter::clone(parameter).measured(direct.value, direct.deviation);
        }
    }
    Ok(variables)
}

/// Scale of a reading's own error, and the errors shared with other readings. Half of the variance of the model's error
/// is common to the readings of a family, whose variable is `of_model`; `keys` is the number of variables before those
/// of the instruments.
pub(super) fn errors(
    [error, discrepancy]: [f64; 2],
    of_model: Option<usize>,
    (keys, instrument): (usize, Option<&InstrumentError>),
) -> (f64, Vec<SharedError>) {
    let common = if of_model.is_some() { COMMON } else { 0.0 };
    let scale = (error.powi(2) + (1.0 - common) * discrepancy.powi(2)).sqrt();
    let of_model = of_model.map(|variable| SharedError {
        variable,
        coefficient: discrepancy * f64::sqrt(common),
    });
    let of_instrument = instrument.map(|own| SharedError {
        variable: keys + own.instrument,
        coefficient: own.deviation,
    });
    (scale, of_model.into_iter().chain(of_instrument).collect())
}

/// The likelihood of the readings. Those in `held_out` are only predicted; `factors` widen the independent errors.
///
/// Half of the variance of a family's model error is shared by its readings, and half is independent.
///
/// # Errors
/// If the correlations are impossible.
pub(super) fn likelihood(
    tool: &Tool,
    measured: &Measurements,
    left_out: &[usize],
    factors: &BTreeMap<usize, f64>,
) -> Result<Likelihood, CalibrationError> {
    let keys = tool.keys();
    let families = families(measured);
    let datum = |(number, own): (usize, &Measured)| {
        let family = own
            .quantity
            .family()
            .and_then(|family| families.iter().position(|known| *known == family));
        let of_model = family.map(|place| keys + measured.instruments.len() + place);
        let (scale, shared) = errors([own.error, own.discrepancy], of_model, (keys, own.instrument.as_ref()));
        Datum {
            name: own.name.clone(),
            condition: own.condition,
            reading: own.reading,
            scale: scale * factors.get(&number).copied().unwrap_or(1.0),
            shared,
            counts: !left_out.contains(&number),
        }
    };
    let data = measured.data.iter().enumerate().map(datum).collect();
    let correlation = |own: &super::measurements::Correlation| ErrorCorrelation {
        data: own.data.clone(),
        r: own.r,
        parts: own.data.iter().map(|&k| measured.data[k].error).collect(),
    };
    let correlations: Vec<ErrorCorrelation> = measured.correlations.iter().map(correlation).collect();
    Ok(Likelihood::new(
        data,
        tool.conditions.len(),
        &correlations,
        ErrorLaw::Student,
    )?)
}
