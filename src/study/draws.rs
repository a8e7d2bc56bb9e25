//! The draws of a study: each a design with the levels of its shot.
//!
//! Structures (modes and radiation matrices) are dear, shots on them are cheap. Where structures are drawn, each serves several
//! shots: a joint draw of structure and shot that is accepted gives the structure, and further shots are drawn on it. Both have
//! the distribution of independent joint draws under the condition, because an accepted pair is a draw of the structure given
//! that it is accepted.
//!
//! Nothing is written but the outcomes of candidates and the levels of draws, as outputs of stages in the store: a study that
//! ended early goes on where it was, and a larger one begins with the draws of a smaller one.

use std::sync::Mutex;
use std::sync::atomic::{AtomicUsize, Ordering};

use super::sampling::{Frame, Point, Sampler};
use super::screening::{Candidate, Tally, drawn, screen};
use super::variables::{Drawn, Kind, Scope, Variable, variables, without_sensors};
use crate::chain::{Chain, Options};
use crate::design::{Design, Values};
use crate::error::Error;
use crate::graph::Graph;
use crate::stages::Progress;
use crate::stages::levels::Levels;
use crate::stages::outcomes::{Fate, Shot};

/// What a study is asked for.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Request {
    /// Number of draws.
    pub draws: usize,
    /// Seed.
    pub seed: u64,
    /// Shots on each structure that is drawn; `None` holds the structures of the design.
    pub shots_a_structure: Option<usize>,
}

/// A draw.
#[derive(Debug, Clone, PartialEq)]
pub struct Draw {
    /// Number of its structure; 0 where structures are held.
    pub structure: usize,
    /// Number of the candidate in its sequence.
    pub candidate: u64,
    /// What each variable is; none for one that is held.
    pub drawn: Vec<Option<Drawn>>,
    /// Place of each variable in its distribution, 0 .. 1; NaN for one that is held.
    pub shares: Vec<f64>,
    /// Figures of the shot.
    pub shot: Shot,
    /// Levels without errors of methods.
    pub levels: Levels,
    /// Error of each source's method in this draw \[dB\]: workpiece, exhaust, body.
    pub method_db: [f64; 3],
}

/// The draws of a study.
pub struct Draws {
    /// The variables.
    pub variables: Vec<Variable>,
    /// Names of variables in which values are rejected together.
    pub conflicting: Vec<Vec<String>>,
    /// The draws.
    pub draws: Vec<Draw>,
    /// What became of all candidates.
    pub tally: Tally,
    /// Draws whose sound cannot be computed, with the message.
    pub failures: Vec<(usize, String)>,
    /// Ends of methods' errors that are open and taken as 0 dB.
    pub open_ends: Vec<String>,
}

/// A draw before its sound.
struct Planned {
    structure: usize,
    candidate: Candidate,
}

/// Whether a study of `design` counts a shot.
fn accepts(design: &Design) -> impl Fn(&Fate) -> bool + use<'_> {
    let require = &design.study().require;
    move |fate: &Fate| match fate {
        Fate::Shot(shot) => require.is_empty() || require.contains(&shot.outcome.as_str()),
        Fate::DryFire | Fate::SolverFailure(_) | Fate::Refused(_) => false,
    }
}

/// Makes the draws that are asked for on a graph, and says on `progress` how far they are.
///
/// # Errors
/// Those of the chain of the design itself; [`Error::NothingDrawn`] where no candidate is accepted.
pub fn draws(graph: &Graph, design: &Design, request: &Request, progress: &Progress) -> Result<Draws, Error> {
    progress.stage("which quantities change the levels");
    let variables = graph.time("variables", || variables(design))?;
    let design = without_sensors(design);
    let sampler = graph.time("rules between values", || {
        Sampler::new(&design, variables, request.seed)
    });
    let (planned, tally) = plan(graph, (&design, &sampler), request, progress)?;
    let (draws, failures) = levels(graph, (&design, &sampler), planned, progress)?;
    let conflicting = sampler.conflicting().into_iter();
    Ok(Draws {
        open_ends: open_ends(&sampler, &draws),
        conflicting: conflicting
            .map(|names| names.into_iter().map(str::to_owned).collect())
            .collect(),
        variables: sampler.variables().to_vec(),
        draws,
        tally,
        failures,
    })
}

/// Candidates that are accepted, structure by structure.
fn plan(
    graph: &Graph,
    (design, sampler): (&Design, &Sampler),
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
    let base: &Values = design;
    let done = |before: usize| move |found: usize| progress.done((before + found) as u64, request.draws as u64);
    let Some(each) = request.shots_a_structure else {
        let frame = Frame {
            base,
            active: &shots,
            stream: 0,
        };
        let accept = accepts(design);
        let (accepted, tally) = screen(graph, (design, sampler), frame, request.draws, accept, done(0))?;
        let planned = accepted.into_iter().map(|candidate| Planned {
            structure: 0,
            candidate,
        });
        return Ok((planned.collect(), tally));
    };
    let structures = request.draws.div_ceil(each);
    let joint = Frame {
        base,
        active: &all,
        stream: 0,
    };
    let (first, mut tally) = screen(graph, (design, sampler), joint, structures, accepts(design), done(0))?;
    let mut planned = Vec::new();
    for (structure, candidate) in first.into_iter().enumerate() {
        let held = structure_of(design, sampler, &candidate.point, &shots);
        let more = each.min(request.draws - planned.len()) - 1;
        let mut own = vec![candidate];
        if more > 0 {
            let frame = Frame {
                base: &held,
                active: &shots,
                stream: structure as u64 + 1,
            };
            let accept = accepts(design);
            let (others, counts) = screen(graph, (design, sampler), frame, more, accept, done(planned.len()))?;
            tally.add(counts);
            // What shots of a structure have in common is what the first of them drew.
            let first = own[0].clone();
            own.extend(others.into_iter().map(|other| other.with(&first, &shots)));
        }
        planned.extend(own.into_iter().map(|candidate| Planned { structure, candidate }));
    }
    Ok((planned, tally))
}

/// The values of a design with the structure of a point.
fn structure_of(design: &Design, sampler: &Sampler, point: &Point, shots: &[bool]) -> Values {
    let mut values: Values = Values::clone(design);
    let mut structure = point.clone();
    let of_shots = structure.drawn.iter_mut().zip(shots).filter(|(_, shot)| **shot);
    of_shots.for_each(|(drawn, _)| *drawn = None);
    // A point that was accepted has values that can be set.
    let _ = values.set(&sampler.changes(&structure));
    values
}

impl Candidate {
    /// With what another one drew for all that is not part of the shot.
    fn with(mut self, other: &Self, shots: &[bool]) -> Self {
        for (place, _) in shots.iter().enumerate().filter(|(_, shot)| !**shot) {
            self.point.drawn[place].clone_from(&other.point.drawn[place]);
            self.point.shares[place] = other.point.shares[place];
        }
        self
    }
}

/// The levels of all planned draws, structure by structure, each draw on a thread of its own.
fn levels(
    graph: &Graph,
    (design, sampler): (&Design, &Sampler),
    planned: Vec<Planned>,
    progress: &Progress,
) -> Result<(Vec<Draw>, Vec<(usize, String)>), Error> {
    progress.stage("levels of the draws");
    let (total, done) = (planned.len() as u64, AtomicUsize::new(0));
    let (mut draws, mut failures) = (Vec::with_capacity(planned.len()), Vec::new());
    let mut first = 0;
    for group in planned.chunk_by(|a, b| a.structure == b.structure) {
        let of = |place: usize| -> Result<Chain, Error> {
            let point = &group[place].candidate.point;
            let drawn = drawn(design, sampler, design, point).map_err(|reason| Error::NoDesign { reason })?;
            Chain::new(graph, &drawn, Options::default())
        };
        // Holds the structure's stages while its draws come and go.
        let anchor = of(0);
        let (next, results) = (AtomicUsize::new(0), Mutex::new(vec![None; group.len()]));
        let work = || loop {
            let place = next.fetch_add(1, Ordering::Relaxed);
            if place >= group.len() {
                return;
            }
            let levels = of(place).and_then(|chain| {
                chain.check_bodies()?;
                chain.levels.get()
            });
            let levels = levels
                .map(|levels| Levels::clone(&levels))
                .map_err(|error| error.to_string());
            if let Ok(mut results) = results.lock() {
                results[place] = Some(levels);
            }
            progress.done(done.fetch_add(1, Ordering::Relaxed) as u64 + 1, total);
        };
        std::thread::scope(|scope| {
            let workers = rayon::current_num_threads().min(group.len());
            (1..workers).for_each(|_| drop(scope.spawn(work)));
            work();
        });
        drop(anchor);
        let results = results.into_inner().unwrap_or_default();
        for (place, (planned, levels)) in group.iter().zip(results).enumerate() {
            match (levels, &planned.candidate.fate) {
                (Some(Ok(levels)), Fate::Shot(shot)) => draws.push(Draw {
                    structure: planned.structure,
                    candidate: planned.candidate.index,
                    method_db: method_errors(sampler.variables(), &planned.candidate.point, &levels),
                    drawn: planned.candidate.point.drawn.clone(),
                    shares: planned.candidate.point.shares.clone(),
                    shot: shot.clone(),
                    levels,
                }),
                (Some(Err(message)), _) => failures.push((first + place, message)),
                _ => failures.push((first + place, "its computation ended".to_owned())),
            }
        }
        first += group.len();
    }
    Ok((draws, failures))
}

/// The error of each source's method in a draw \[dB\]; an end that is open counts as 0 dB.
fn method_errors(variables: &[Variable], point: &Point, levels: &Levels) -> [f64; 3] {
    let mut errors = [0.0; 3];
    for (variable, share) in variables.iter().zip(&point.shares).filter(|(_, share)| !share.is_nan()) {
        let Kind::Method(bounds) = &variable.kind else { continue };
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

/// Ends of methods' errors that are open, by source.
fn open_ends(sampler: &Sampler, draws: &[Draw]) -> Vec<String> {
    let mut open = std::collections::BTreeSet::new();
    for source in draws.iter().flat_map(|draw| &draw.levels.sources) {
        let name = format!("method.{}", source.source);
        let own = |variable: &Variable| variable.name == name && matches!(variable.kind, Kind::Method(None));
        if sampler.variables().iter().any(own) {
            let ends = ["below", "above"].into_iter().zip(source.method_db);
            let ends = ends.filter(|(_, bound)| bound.is_none());
            open.extend(ends.map(|(end, _)| format!("{} {end}", source.source)));
        }
    }
    open.into_iter().collect()
}

/// Levels of the design itself; none where its shot or its sound cannot be computed.
///
/// # Errors
/// Those of the chain's inputs.
pub fn nominal(graph: &Graph, design: &Design) -> Result<Option<std::sync::Arc<Levels>>, Error> {
    let chain = Chain::new(graph, &without_sensors(design), Options::default())?;
    Ok(chain.levels.get().ok())
}
