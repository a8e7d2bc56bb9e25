//! Jobs on threads of their own. The pool of threads serves the stages within a job, which wait for each other.

use std::panic::resume_unwind;
use std::sync::Mutex;
use std::sync::atomic::{AtomicUsize, Ordering};

use crate::chain::Chain;
use crate::error::Error;
use crate::graph::Graph;
use crate::stages::levels::{Levels, ShotLevels};
use crate::stages::{Postcard, Stage};

/// The message of a job that failed because of another's failure.
pub(super) const CONSEQUENCE: &str = "an input could not be computed";

/// Computes the jobs `0 .. count`, as many at a time as the pool has threads; the results come in the order of the jobs.
pub(super) fn on_threads<T: Send>(
    count: usize,
    compute: impl Fn(usize) -> Result<T, String> + Sync,
) -> Vec<Result<T, String>> {
    let next = AtomicUsize::new(0);
    let results: Mutex<Vec<Option<Result<T, String>>>> = Mutex::new((0..count).map(|_| None).collect());
    let work = || loop {
        let job = next.fetch_add(1, Ordering::Relaxed);
        if job >= count {
            return;
        }
        let result = compute(job);
        if let Ok(mut results) = results.lock() {
            results[job] = Some(result);
        }
    };
    std::thread::scope(|scope| {
        let others: Vec<_> = (1..rayon::current_num_threads().min(count))
            .map(|_| scope.spawn(work))
            .collect();
        work();
        // A panic goes on as it began: it may be the end of work that was abandoned.
        for thread in others {
            thread.join().unwrap_or_else(|panic| resume_unwind(panic));
        }
    });
    let results = results.into_inner().unwrap_or_default();
    let ended = || Err("its computation ended".to_owned());
    results.into_iter().map(|result| result.unwrap_or_else(ended)).collect()
}

/// The levels of the shot of a chain, where they are kept.
pub(super) fn kept_levels(graph: &Graph, chain: Result<Chain, Error>) -> Result<Levels, String> {
    let chain = chain.map_err(|error| error.in_words())?;
    let kept = graph
        .store()
        .load::<Levels, Postcard>(ShotLevels::NAME, chain.levels.key());
    kept.ok_or_else(|| "its levels are not kept".to_owned())
}

/// The levels of the shot of a chain whose bodies a run can use.
pub(super) fn levels_of_shot(chain: Result<Chain, Error>) -> Result<Levels, String> {
    let levels = chain.and_then(|chain| {
        chain.check_bodies()?;
        chain.levels.get()
    });
    levels
        .map(|levels| Levels::clone(&levels))
        .map_err(|error| match error {
            // The job in which the input failed has the reason.
            Error::Upstream { .. } => CONSEQUENCE.to_owned(),
            cause => cause.in_words(),
        })
}
