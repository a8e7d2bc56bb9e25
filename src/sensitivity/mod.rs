//! Response of the figures of a shot to the parameters of its design, or to the numbers of an assembly.
//!
//! For each key of the cycle that has a range, the derivative of each figure is computed from central differences. They
//! have steps of 8, 4, 2 and 1 % of the parameter's size and are extrapolated to a step of zero. If a step leaves the
//! limits of a design, the differences are one-sided. The cycle has contacts and switches. Its figures are smooth in
//! the parameters as long as these switch in the same order, so that differences across events converge to derivatives.
//! If the order changes, the differences do not agree, which the error shows.
//!
//! Parameters are ranked by the effect of their ranges on a figure. It is the derivative times half the range, unless
//! runs at the ends of the range show that the figure does not follow the derivative that far.
//!
//! The tolerance of the integration is a hundred times tighter than the design's. The remaining error, and that of the
//! sampled peaks, is measured by running the design with two tolerances and intervals. It is included in the error of
//! every derivative.

mod assembly_outputs;
mod extrapolate;
mod outputs;
mod subject;

use rayon::prelude::*;
use serde::Serialize;

pub use assembly_outputs::AssemblyOutput;
pub(crate) use outputs::interpolated;
pub use outputs::{OUTPUTS, Output, USUAL, choose};

use crate::design::inputs::assembly::{AssembledTool, cycle as assembled};
use crate::design::{Design, Value};
use crate::error::Error;
use crate::stages::Progress;
use crate::study::Parameter;
use extrapolate::{Estimate, extrapolate};
use subject::{Accuracy, OfDesign, OfKeys, OfTool, Run, Shot, Subject};

/// Longest step as a fraction of a parameter's size.
const FIRST_STEP: f64 = 0.08;
/// Number of steps; each is half the previous one.
const STEPS: usize = 4;
/// Number of runs between progress messages.
const BATCH: usize = 64;

/// Sensitivity of figures of a shot to the parameters of its design.
#[derive(Debug, Clone, Serialize)]
pub struct Sensitivity {
    /// Outcome of the shot of the design itself.
    pub outcome: String,
    /// The figures, and how the parameters rank for each.
    pub outputs: Vec<OutputSensitivity>,
    /// The parameters.
    pub parameters: Vec<ParameterOutcome>,
}

/// One figure of the shot.
#[derive(Debug, Clone, Serialize)]
pub struct OutputSensitivity {
    /// Name.
    pub name: String,
    /// SI unit.
    pub unit: &'static str,
    /// Value in the design; null if its phase does not occur.
    pub value: Option<f64>,
    /// Uncertainty of the value due to integration and sampling.
    pub noise: f64,
    /// Derivatives, largest weight first; parameters without a derivative are missing.
    pub ranking: Vec<Derivative>,
}

/// Derivative of a figure with respect to a parameter.
#[derive(Debug, Clone, Serialize)]
pub struct Derivative {
    /// The parameter.
    pub key: String,
    /// d(figure)/d(parameter), in SI units.
    pub derivative: f64,
    /// Estimated error of the derivative: truncation and noise.
    pub error: f64,
    /// Derivative times half the parameter's range: effect of the parameter's uncertainty on the figure.
    pub effect: f64,
    /// Change of the figure over the parameter's range: the magnitude of `effect`; if the figure does not follow its
    /// derivative to the ends of the range, the larger of the changes there.
    pub weight: f64,
    /// Smallest step of the parameter from which the derivative was computed.
    pub step: f64,
    /// The figure with the parameter at the lower and upper end of its range; null if that is not a valid design, or if
    /// the figure's phase does not occur.
    pub at_ends: [Option<f64>; 2],
}

impl Derivative {
    /// Whether the estimated error is below a tenth of the derivative.
    pub fn is_certain(&self) -> bool {
        self.error <= 0.1 * self.derivative.abs()
    }

    /// Whether the figure changes over the range as its derivative predicts, within a factor of two; `None` if an end
    /// is not a valid design.
    pub fn is_linear(&self) -> Option<bool> {
        let [low, high] = self.at_ends;
        let (moved, told) = (high? - low?, 2.0 * self.effect);
        Some(moved * told >= 0.0 && moved.abs() <= 2.0 * told.abs() && told.abs() <= 2.0 * moved.abs())
    }
}

/// A parameter, and whether the outcome changes within its range.
#[derive(Debug, Clone, Serialize)]
pub struct ParameterOutcome {
    /// The parameter.
    #[serde(flatten)]
    pub parameter: Parameter,
    /// The outcomes at the lower and upper end of the range, all other parameters unchanged.
    pub ends: [End; 2],
    /// Whether an end of the range, or one of the steps, has another outcome than the design.
    pub outcome_changes: bool,
}

/// The outcome with a parameter at an end of its range.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum End {
    /// The outcome of the shot.
    Outcome(String),
    /// The values conflict.
    Refused(String),
    /// The cycle fails with this error.
    Failed(String),
}

/// Sensitivity of `outputs` to the keys of the cycle in `design` that have a range, for a tool described by keys. If
/// `keys` are given, only these are varied.
///
/// # Errors
/// [`Error::Cycle`] if the design itself cannot be computed. [`Error::NoSuchParameter`] for the first of `keys` that is
/// not a parameter.
pub fn sensitivity(
    design: &Design,
    outputs: &[Output],
    keys: Option<&[&str]>,
    progress: &Progress,
) -> Result<Sensitivity, Error> {
    rank(&OfKeys { design, outputs }, keys, progress)
}

/// The same for the assembly of a design: sensitivity of the figures of these names to its literals and to the keys
/// that its formulas use. `None` for a design without an assembly.
///
/// # Errors
/// [`Error::Network`] if the assembly itself cannot be computed. [`Error::NoSuchOutput`] as [`AssemblyOutput::choose`],
/// [`Error::NoSuchParameter`] as [`sensitivity`].
pub fn sensitivity_of_assembly(
    design: &Design,
    names: &[impl AsRef<str>],
    keys: Option<&[&str]>,
    progress: &Progress,
) -> Result<Option<Sensitivity>, Error> {
    let Some(cycle) = assembled(design)? else {
        return Ok(None);
    };
    let subject = OfDesign {
        design,
        cycle: &cycle,
        outputs: &AssemblyOutput::choose(&cycle.assembly, names)?,
    };
    rank(&subject, keys, progress).map(Some)
}

/// The figures of a design's assembly with these names or in these groups, as [`AssemblyOutput::choose`]. `None` for a
/// design without an assembly.
///
/// # Errors
/// If the values of the design do not yield a valid assembly, and the errors of [`AssemblyOutput::choose`].
pub fn assembly_outputs(design: &Design, names: &[impl AsRef<str>]) -> Result<Option<Vec<AssemblyOutput>>, Error> {
    let cycle = assembled(design)?;
    cycle
        .map(|cycle| AssemblyOutput::choose(&cycle.assembly, names))
        .transpose()
}

/// The same for a tool without a design: sensitivity to the numbers of its files.
///
/// # Errors
/// Same as [`sensitivity_of_assembly`], except those of the figures.
pub fn sensitivity_of_tool(
    tool: &AssembledTool,
    outputs: &[AssemblyOutput],
    keys: Option<&[&str]>,
    progress: &Progress,
) -> Result<Sensitivity, Error> {
    rank(&OfTool { tool, outputs }, keys, progress)
}

fn rank(subject: &impl Subject, keys: Option<&[&str]>, progress: &Progress) -> Result<Sensitivity, Error> {
    let mut parameters = subject.parameters()?;
    // A derivative with respect to an integer does not exist.
    parameters.retain(|parameter| matches!(parameter.value, Value::Number(_)));
    if let Some(keys) = keys {
        if let Some(key) = keys.iter().find(|key| !parameters.iter().any(|own| own.key == **key)) {
            let near = |own: &&Parameter| strsim::damerau_levenshtein(&own.key, key);
            let nearest = parameters.iter().min_by_key(near).filter(|own| near(own) <= 3);
            let nearest = nearest.map(|own| own.key.clone());
            return Err(Error::NoSuchParameter {
                key: (*key).to_owned(),
                nearest,
            });
        }
        parameters.retain(|parameter| keys.contains(&parameter.key.as_str()));
    }
    let Shot {
        outcome,
        figures: values,
    } = subject.shot(Accuracy::USUAL)?;
    let checked = subject.shot(Accuracy::OTHER)?.figures;
    let noise: Vec<f64> = values
        .iter()
        .zip(&checked)
        .map(|(a, b)| a.zip(*b).map_or(0.0, |(a, b): (f64, f64)| (a - b).abs()))
        .collect();

    let jobs: Vec<(usize, f64)> = parameters
        .iter()
        .enumerate()
        .flat_map(|(index, p)| points(p).into_iter().map(move |x| (index, x)))
        .collect();
    let mut runs: Vec<Run> = Vec::with_capacity(jobs.len());
    for batch in jobs.chunks(BATCH) {
        let of_job = |(index, x): &(usize, f64)| subject.moved(&parameters[*index], *x);
        runs.par_extend(batch.par_iter().map(of_job));
        progress.done(runs.len() as u64, jobs.len() as u64);
    }
    let per_parameter: Vec<&[Run]> = runs.chunks(2 * STEPS + 2).collect();

    let ranking = |output: usize| {
        let value = values[output];
        let derive = |(p, runs): (&Parameter, &&[Run])| derivative(p, runs, output, value?, noise[output]);
        let mut ranking: Vec<Derivative> = parameters.iter().zip(&per_parameter).filter_map(derive).collect();
        ranking.sort_by(|a, b| b.weight.total_cmp(&a.weight));
        ranking
    };
    let outputs = subject.names();
    let outputs = outputs
        .into_iter()
        .enumerate()
        .map(|(index, (name, unit))| OutputSensitivity {
            name,
            unit,
            value: values[index],
            noise: noise[index],
            ranking: ranking(index),
        })
        .collect();
    let ends = |(parameter, runs): (Parameter, &&[Run])| {
        let ends = [&runs[2 * STEPS], &runs[2 * STEPS + 1]].map(End::from);
        let other = |run: &Run| match run {
            Run::Shot(shot) => shot.outcome != outcome,
            Run::Refused(_) => false,
            Run::Failed(_) => true,
        };
        ParameterOutcome {
            parameter,
            ends,
            outcome_changes: runs.iter().any(other),
        }
    };
    let parameters = parameters.clone().into_iter().zip(&per_parameter).map(ends).collect();
    Ok(Sensitivity {
        outcome,
        outputs,
        parameters,
    })
}

/// The longest step of a parameter: a fraction of its value or of half its range, whichever is smaller and not zero.
fn first_step(parameter: &Parameter) -> f64 {
    let value = parameter.number().abs();
    let size = if value > 0.0 {
        value.min(parameter.half_range())
    } else {
        parameter.half_range()
    };
    FIRST_STEP * size
}

/// The values of a parameter: up and down by each step, then to the ends of its range.
fn points(parameter: &Parameter) -> Vec<f64> {
    let (value, first) = (parameter.number(), first_step(parameter));
    let step = |k: usize| first / f64::from(1_u32 << k);
    let both = |k: usize| [value + step(k), value - step(k)];
    (0..STEPS).flat_map(both).chain(parameter.range).collect()
}

/// The derivative of figure `output`, whose value in the design is `value`.
fn derivative(parameter: &Parameter, runs: &[Run], output: usize, value: f64, noise: f64) -> Option<Derivative> {
    let first = first_step(parameter);
    let figure = |index: usize| match &runs[index] {
        Run::Shot(shot) => shot.figures[output],
        _ => None,
    };
    let step = |k: usize| first / f64::from(1_u32 << k);
    let central = (0..STEPS).map(|k| Some((figure(2 * k)? - figure(2 * k + 1)?) / (2.0 * step(k))));
    let side = |side: usize, sign: f64| {
        let difference = move |k: usize| Some((figure(2 * k + side)? - value) / (sign * step(k)));
        extrapolate(&(0..STEPS).map(difference).collect::<Vec<_>>(), first, 1, 2.0 * noise)
    };
    // Central if both sides are valid designs; otherwise one-sided.
    let estimate: Estimate = extrapolate(&central.collect::<Vec<_>>(), first, 2, noise)
        .or_else(|| side(0, 1.0))
        .or_else(|| side(1, -1.0))?;
    let effect = estimate.value * parameter.half_range();
    let Estimate {
        value: derivative,
        error,
        step,
    } = estimate;
    let at_ends = [figure(2 * STEPS), figure(2 * STEPS + 1)];
    let mut found = Derivative {
        key: parameter.key.clone(),
        derivative,
        error,
        effect,
        weight: effect.abs(),
        step,
        at_ends,
    };
    if found.is_linear() == Some(false) {
        found.weight = at_ends
            .into_iter()
            .flatten()
            .map(|end| (end - value).abs())
            .fold(0.0, f64::max);
    }
    Some(found)
}

impl From<&Run> for End {
    fn from(run: &Run) -> Self {
        match run {
            Run::Shot(shot) => Self::Outcome(shot.outcome.clone()),
            Run::Refused(reason) => Self::Refused(reason.clone()),
            Run::Failed(reason) => Self::Failed(reason.clone()),
        }
    }
}
