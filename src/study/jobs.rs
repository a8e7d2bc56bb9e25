//! Jobs on separate threads. The pool of threads serves the stages within a job, which wait for each other.

use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Mutex, PoisonError};

use nailnoise_pipeline::{Begun, StageError as _, beside};

use crate::chain::Chain;
use crate::error::Error;
use crate::graph::Graph;
use crate::stages::levels::{Levels, ShotLevels};
use crate::stages::{Postcard, Stage};
use crate::study::StudyError;

/// Computes the jobs `0 .. count`, as many at a time as the pool has threads; the results come in the order of the
/// jobs.
pub(crate) fn on_threads<T: Send>(count: usize, compute: impl Fn(usize) -> T + Sync) -> Vec<T> {
    let next = AtomicUsize::new(0);
    let results: Mutex<Vec<Option<T>>> = Mutex::new((0..count).map(|_| None).collect());
    let work = || loop {
        let job = next.fetch_add(1, Ordering::Relaxed);
        if job >= count {
            return;
        }
        let result = compute(job);
        results.lock().unwrap_or_else(PoisonError::into_inner)[job] = Some(result);
    };
    std::thread::scope(|scope| {
        let others: Vec<_> = (1..rayon::current_num_threads().min(count))
            .map(|_| beside(scope, &work))
            .collect();
        work();
        // A panic continues unchanged: it may be the end of work that was abandoned.
        others.into_iter().for_each(Begun::join);
    });
    // Every job has a result here, since a panic has gone on.
    let results = results.into_inner().unwrap_or_else(PoisonError::into_inner);
    results.into_iter().flatten().collect()
}

/// The levels of the shot of a chain, if they are stored.
pub(super) fn kept_levels(graph: &Graph, chain: Result<Chain, Error>) -> Result<Levels, Error> {
    let kept = graph
        .store()
        .load::<Levels, Postcard>(ShotLevels::NAME, chain?.levels.key());
    kept.ok_or(StudyError::LevelsNotKept.into())
}

/// The levels of the shot of a chain whose bodies a run can use.
pub(crate) fn levels_of_shot(chain: Result<Chain, Error>) -> Result<Levels, Error> {
    let chain = chain?;
    chain.check_bodies()?;
    chain.levels.get().map(|levels| Levels::clone(&levels))
}

/// The reason why a job failed, as text. An input that several jobs share fails in the job that computes it; the error
/// of that job is the cause for all.
pub(super) fn reason<'a>(error: &'a Error, of_all: impl IntoIterator<Item = &'a Error>) -> String {
    let mut all = std::iter::once(error).chain(of_all);
    all.find(|error| error.is_cause()).unwrap_or(error).in_words()
}
