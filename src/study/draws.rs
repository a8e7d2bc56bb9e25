//! The draws of a study: each is a design with the levels of its shot.
//!
//! Structures (modes and radiation matrices) are expensive, shots on them are inexpensive. If structures are drawn,
//! each is used for several shots: an accepted joint draw of structure and shot gives the structure, and further shots
//! are drawn on it. Both have the distribution of independent joint draws under the condition, because the structure of
//! an accepted pair has its distribution given acceptance.
//!
//! Joint draws of a calibration include dimensions of the bodies that decide the cycle. Where structures are fixed, the
//! cycle has all values of a joint draw, and the bodies those of the design.
//!
//! The outcomes of candidates and the levels of draws are stage outputs in the store. A study that ended early
//! continues from there, and a larger one begins with the draws of a smaller one.

use std::sync::atomic::{AtomicUsize, Ordering};

use super::jobs::{kept_levels, levels_of_shot, on_threads, reason};
use super::request::{Request, Subset};
use super::sampling::{Frame, Point, Sampler};
use super::screening::{Candidate, Tally, drawn, screen};
use super::variables::{
    Scope, Variable, VariableKind, common_variables, drawn_scores, with_workpiece_sensors, without_sensors,
};
use crate::chain::{Chain, Options, SharedShapes, engine};
use crate::design::{Coupling, Design, Values};
use crate::error::Error;
use crate::graph::Graph;
use crate::model::sources::ALL;
use crate::stages::levels::{Levels, ShotLevels};
use crate::stages::outcomes::{ShotFigures, ShotOutcome};
use crate::stages::{Progress, Stage, code};
use crate::store::Key;
use crate::study::StudyError;
use crate::wording::hexadecimal;

/// A draw.
#[derive(Debug, Clone, PartialEq)]
pub struct Draw {
    /// Number of its structure; 0 if structures are fixed.
    pub structure: usize,
    /// Number of the candidate in its sequence.
    pub candidate: u64,
    /// Position of each variable in its distribution, 0 .. 1, which [`Variable::drawn`] converts to its value; NaN for
    /// a fixed one.
    pub shares: Vec<f64>,
    /// Figures of the shot.
    pub shot: ShotFigures,
    /// Levels without errors of methods.
    pub levels: Levels,
    /// Error of each source's method in this draw \[dB\], in the order of the sources in the levels.
    pub method_db: Vec<f64>,
}

/// The draws of a study.
#[derive(Debug, Clone, Default)]
pub struct Draws {
    /// The variables.
    pub variables: Vec<Variable>,
    /// The draws.
    pub draws: Vec<Draw>,
    /// Number of structures drawn; 0 if they are those of the design.
    pub structures: usize,
    /// Outcomes of all candidates.
    pub tally: Tally,
    /// Draws whose sound cannot be computed, with the message.
    pub failures: Vec<(usize, String)>,
    /// Ends of methods' error ranges that are open and taken as 0 dB.
    pub open_ends: Vec<String>,
}

impl Request {
    /// The design with the sensors of its draws.
    fn with_sensors(&self, design: &Design) -> Design {
        if self.workpiece_sensors {
            with_workpiece_sensors(design)
        } else {
            without_sensors(design)
        }
    }
}

/// A draw before its sound is computed.
pub(super) struct Planned {
    pub(super) structure: usize,
    pub(super) candidate: Candidate,
}

/// Makes the requested draws on a graph and reports their number to `progress`.
///
/// # Errors
/// The errors of the chain of the design itself; [`StudyError::NothingDrawn`] if no candidate is accepted;
/// [`StudyError::NoLevels`] if the levels of no draw can be computed.
pub fn draws(graph: &Graph, design: &Design, request: &Request, progress: &Progress) -> Result<Draws, Error> {
    let made = common_draws(graph, &[design], request, progress)?;
    Ok(made.into_iter().next().unwrap_or_default())
}

/// Common draws of several designs: in each draw, everything that the designs share is the same, so that it cancels in
/// their differences. A draw counts if it counts in all of them. The draws of each design come in the same order.
///
/// # Errors
/// Same as [`draws`].
pub fn common_draws(
    graph: &Graph,
    designs: &[&Design],
    request: &Request,
    progress: &Progress,
) -> Result<Vec<Draws>, Error> {
    let Some(first) = designs.first() else {
        return Ok(Vec::new());
    };
    progress.stage("which quantities change the levels");
    let variables = graph.time("variables", || common_variables(designs))?;
    let sampler = graph.time("rules between values", || {
        Sampler::new(&without_sensors(first), variables, request.seed)
    });
    check_joint(designs, request)?;
    let designs: Vec<Design> = designs.iter().map(|design| request.with_sensors(design)).collect();
    let (mut planned, tally) = plan(graph, (&designs, &sampler), request, progress)?;
    let held = request.shots_a_structure.is_none();
    let mut place = 0..;
    planned.retain(|own| {
        let draw = place.next().unwrap_or_default();
        request.part.holds(if held { draw } else { own.structure })
    });
    let (draws, failures) = levels(graph, (&designs, &sampler), planned, request.part, progress)?;
    if let (true, Some((_, reason))) = (draws.iter().all(Vec::is_empty), failures.first())
        && request.part != Subset::Kept
    {
        return Err(StudyError::NoLevels {
            draws: failures.len(),
            reason: reason.clone(),
        }
        .into());
    }
    let of_design = |draws: Vec<Draw>| Draws {
        open_ends: open_ends(&sampler, &draws),
        variables: sampler.variables().to_vec(),
        structures: match draws.last() {
            Some(last) if !held => last.structure + 1,
            _ => 0,
        },
        draws,
        tally: tally.clone(),
        failures: failures.clone(),
    };
    Ok(draws.into_iter().map(of_design).collect())
}

/// Accepted candidates, by structure.
fn plan(
    graph: &Graph,
    (designs, sampler): (&[Design], &Sampler),
    request: &Request,
    progress: &Progress,
) -> Result<(Vec<Planned>, Tally), Error> {
    progress.stage("shots of candidates");
    let scopes = |wanted: &[Scope]| -> Vec<bool> {
        let scopes = sampler.variables().iter().map(|variable| variable.scope);
        scopes.map(|scope| wanted.contains(&scope)).collect()
    };
    let shots = scopes(&[Scope::Shot, Scope::Method]);
    let all = scopes(&[Scope::Shot, Scope::Method, Scope::Structure]);
    let bases: Vec<Values> = designs.iter().map(|design| Values::clone(design)).collect();
    let frame = |active, stream| Frame::new(&bases, active, stream);
    let done = |before: usize| move |found: usize| progress.done((before + found) as u64, request.draws as u64);
    let Some(each) = request.shots_a_structure else {
        let frame = frame(&shots, 0);
        let (accepted, tally) = screen(graph, (designs, sampler), frame, request.draws, request.part, done(0))?;
        let planned = accepted.into_iter().map(|candidate| Planned {
            structure: 0,
            candidate,
        });
        return Ok((planned.collect(), tally));
    };
    let structures = request.draws.div_ceil(each);
    let (first, mut tally) = screen(
        graph,
        (designs, sampler),
        frame(&all, 0),
        structures,
        request.part,
        done(0),
    )?;
    let mut planned = Vec::new();
    let own = first.into_iter().enumerate();
    for (structure, candidate) in own.filter(|(structure, _)| request.part.holds(*structure)) {
        let more = each.min(request.draws - each * structure) - 1;
        let mut own = vec![candidate];
        if more > 0 {
            let given = own[0].point.clone();
            let frame = Frame {
                given: Some(&given),
                ..frame(&shots, structure as u64 + 1)
            };
            let (others, counts) = screen(graph, (designs, sampler), frame, more, Subset::All, done(planned.len()))?;
            tally.add(counts);
            own.extend(others);
        }
        planned.extend(own.into_iter().map(|candidate| Planned { structure, candidate }));
    }
    Ok((planned, tally))
}

/// Draws of each design, and those that could not be computed.
pub(super) type Made = (Vec<Vec<Draw>>, Vec<(usize, String)>);

/// The levels of all planned draws, by structure, each shot on a separate thread.
pub(super) fn levels(
    graph: &Graph,
    (designs, sampler): (&[Design], &Sampler),
    planned: Vec<Planned>,
    part: Subset,
    progress: &Progress,
) -> Result<Made, Error> {
    progress.stage("levels of the draws");
    let (total, done) = ((planned.len() * designs.len()) as u64, AtomicUsize::new(0));
    let (mut draws, mut failures) = (vec![Vec::with_capacity(planned.len()); designs.len()], Vec::new());
    let mut first = 0;
    for group in planned.chunk_by(|a, b| a.structure == b.structure) {
        let shared = |design| shared_shapes(graph, (design, sampler), &group[0].candidate.point);
        let shared: Vec<SharedShapes> = designs
            .iter()
            .map(|design| shared(design).unwrap_or_default())
            .collect();
        let of = |place: usize, which: usize| -> Result<Chain, Error> {
            let options = Options {
                shared: shared[which],
                ..Options::default()
            };
            chain_of(
                graph,
                (&designs[which], sampler),
                &group[place].candidate.point,
                options,
            )
        };
        // Retains the stages of the structures while their draws are computed.
        let anchors: Vec<_> = (0..designs.len()).map(|which| of(0, which)).collect();
        let count = group.len() * designs.len();
        let all = on_threads(count, |job| {
            let chain = of(job / designs.len(), job % designs.len());
            let levels = match part {
                Subset::Kept => kept_levels(graph, chain),
                Subset::All | Subset::Task { .. } | Subset::Screened { .. } => levels_of_shot(chain),
            };
            progress.done(done.fetch_add(1, Ordering::Relaxed) as u64 + 1, total);
            levels
        });
        drop(anchors);
        for (place, (planned, results)) in group.iter().zip(all.chunks(designs.len())).enumerate() {
            let candidate = &planned.candidate;
            let draw = |(result, outcome): (&Result<Levels, Error>, &ShotOutcome)| match (result, outcome) {
                (Ok(levels), ShotOutcome::Shot(shot)) => Ok(Draw {
                    structure: planned.structure,
                    candidate: candidate.index,
                    method_db: method_errors(sampler.variables(), &candidate.point.shares, levels),
                    shares: candidate.point.shares.clone(),
                    shot: shot.clone(),
                    levels: levels.clone(),
                }),
                (Err(error), _) => Err(reason(error, all.iter().filter_map(|result| result.as_ref().err()))),
                (Ok(_), outcome) => Err(format!("its shot ends as {}", outcome.name())),
            };
            let own = results.iter().zip(&candidate.outcomes).map(draw);
            match own.collect::<Result<Vec<Draw>, String>>() {
                Ok(own) => draws.iter_mut().zip(own).for_each(|(draws, own)| draws.push(own)),
                Err(message) => failures.push((first + place, message)),
            }
        }
        first += group.len();
    }
    Ok((draws, failures))
}

/// The chain of a point. Joint draws give their dimensions of bodies only to the cycle.
fn chain_of(
    graph: &Graph,
    (design, sampler): (&Design, &Sampler),
    point: &Point,
    options: Options,
) -> Result<Chain, Error> {
    let own = design_of(design, sampler, point)?;
    let Some(held) = held_bodies(sampler, point) else {
        return Chain::new(graph, &own, options);
    };
    let mut bodies = design.clone();
    bodies
        .set(&sampler.changes(&held))
        .map_err(|error| StudyError::NoDesign {
            reason: error.to_string(),
        })?;
    bodies.draw_law(drawn_scores(sampler.variables(), &point.shares));
    Chain::with_engine(graph, &bodies, engine(&own)?, options)
}

/// Further outputs of the shots of a design's draws, whose bodies are fixed, each shot on a separate thread. `common`
/// is the first of the designs with these draws; the design may have sensors.
pub(crate) fn outputs_of_draws<T: Send>(
    graph: &Graph,
    (common, design): (&Design, &Design),
    made: &Draws,
    progress: &Progress,
    of: impl Fn(&Chain) -> Result<T, Error> + Sync,
) -> Vec<Result<T, Error>> {
    let sampler = Sampler::new(&without_sensors(common), made.variables.clone(), 0);
    let done = AtomicUsize::new(0);
    on_threads(made.draws.len(), |draw| {
        let point = Point {
            shares: made.draws[draw].shares.clone(),
        };
        let chain = chain_of(graph, (design, &sampler), &point, Options::default());
        let found = chain.and_then(|chain| of(&chain));
        progress.done(done.fetch_add(1, Ordering::Relaxed) as u64 + 1, made.draws.len() as u64);
        found
    })
}

/// Digest of the code by which joint draws are conditioned: they belong to the cycle that they were made with.
pub(crate) fn code_of_joint_draws() -> String {
    hexadecimal(&Key::empty().with(&code![dynamics]).digest())
}

/// Digest of the code that determines levels of draws.
pub(super) fn code_of_levels() -> String {
    let levels = Key::empty().with(&ShotLevels::NAME).with(&ShotLevels::CODE);
    let key = ALL.into_iter().fold(levels, |key, source| key.with(&source.code()));
    hexadecimal(&key.digest())
}

/// The same for joint draws that are conditioned on levels, too.
pub(crate) fn code_of_levelled_draws() -> String {
    format!("{} {}", code_of_joint_draws(), code_of_levels())
}

/// Whether designs can be drawn by joint draws.
fn check_joint(designs: &[&Design], request: &Request) -> Result<(), Error> {
    let joint = |design: &&Design| design.study().draws.clone();
    let mut all = designs.iter().filter_map(joint);
    let Some(first) = all.next() else { return Ok(()) };
    let refuse = |problem: &'static str, help: &'static str| Err(StudyError::JointDraws { problem, help }.into());
    if ![code_of_joint_draws(), code_of_levelled_draws()].contains(&first.code) {
        return refuse(
            "were made by other code of the nailing cycle or of the levels",
            "calibrate the design again: `nailnoise calibrate`",
        );
    }
    if designs.first().is_some_and(|own| own.study().draws.is_none()) || all.any(|own| own.digest != first.digest) {
        return refuse(
            "are not common to all designs",
            "name the calibrated design first, and give the others `base = \"calibrated.toml\"`",
        );
    }
    if request.shots_a_structure.is_some() {
        return refuse("give one shot to each structure", "leave out --structures");
    }
    if designs.iter().any(|own| own.support.coupling == Coupling::TwoWay) {
        return refuse(
            "drive bodies of the design one way",
            "give `support.coupling = \"one-way\"`",
        );
    }
    Ok(())
}

/// A point without the dimensions of the bodies that joint draws give to the cycle; `None` if there are none.
fn held_bodies(sampler: &Sampler, point: &Point) -> Option<Point> {
    let mut held = point.clone();
    let mut found = false;
    for (place, variable) in sampler.variables().iter().enumerate() {
        if variable.scope == Scope::Structure && sampler.is_joint(place) {
            held.shares[place] = f64::NAN;
            found = true;
        }
    }
    found.then_some(held)
}

/// The design of a point.
fn design_of(design: &Design, sampler: &Sampler, point: &Point) -> Result<Design, Error> {
    drawn(design, sampler, design, point).map_err(|reason| StudyError::NoDesign { reason }.into())
}

/// The shapes of a drawn structure that other structures may share: those that depend only on its alternatives. A
/// dimension drawn from a range gives each structure a different shape.
fn shared_shapes(graph: &Graph, (design, sampler): (&Design, &Sampler), point: &Point) -> Result<SharedShapes, Error> {
    let mut chosen = point.clone();
    for (share, variable) in chosen.shares.iter_mut().zip(sampler.variables()) {
        if !matches!(variable.kind, VariableKind::Alternatives(_)) {
            *share = f64::NAN;
        }
    }
    let bodies = held_bodies(sampler, point);
    SharedShapes::of(
        graph,
        &design_of(design, sampler, &chosen)?,
        &design_of(design, sampler, bodies.as_ref().unwrap_or(point))?,
    )
}

/// The error of each source's method in a draw \[dB\]; an open end counts as 0 dB.
pub(crate) fn method_errors(variables: &[Variable], shares: &[f64], levels: &Levels) -> Vec<f64> {
    let mut errors = vec![0.0; levels.sources.len()];
    for (variable, share) in variables.iter().zip(shares).filter(|(_, share)| !share.is_nan()) {
        let VariableKind::Method(bounds) = &variable.kind else {
            continue;
        };
        for (error, source) in errors.iter_mut().zip(&levels.sources) {
            if variable.name == format!("method.{}", source.source) {
                let own = source.method_db.map(|bound| bound.unwrap_or(0.0).abs());
                let [low, high] = bounds.unwrap_or([-own[0], own[1]]);
                *error = low + share * (high - low);
            }
        }
    }
    errors
}

/// Open ends of methods' error ranges, by source.
fn open_ends(sampler: &Sampler, draws: &[Draw]) -> Vec<String> {
    let mut open = std::collections::BTreeSet::new();
    for source in draws.iter().flat_map(|draw| &draw.levels.sources) {
        let name = format!("method.{}", source.source);
        let own = |variable: &Variable| variable.name == name && matches!(variable.kind, VariableKind::Method(None));
        if sampler.variables().iter().any(own) {
            let ends = ["below", "above"].into_iter().zip(source.method_db);
            let ends = ends.filter(|(_, bound)| bound.is_none());
            open.extend(ends.map(|(end, _)| format!("{} {end}", source.source)));
        }
    }
    open.into_iter().collect()
}

/// Levels of the design itself; `None` if its shot or its sound cannot be computed.
///
/// # Errors
/// The errors of the chain's inputs.
pub fn nominal(graph: &Graph, design: &Design, request: &Request) -> Result<Option<std::sync::Arc<Levels>>, Error> {
    let chain = Chain::new(graph, &request.with_sensors(design), Options::default())?;
    Ok(chain.levels.get().ok())
}
