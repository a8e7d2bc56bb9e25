//! Runs work on another thread, or on the current one if the system grants none (`ulimit -u`, `ulimit -v`).

use std::panic::resume_unwind;
use std::thread::{Builder, Scope, ScopedJoinHandle};

/// Work started by [`beside`].
pub enum Begun<'scope, T> {
    /// Running on another thread.
    There(ScopedJoinHandle<'scope, T>),
    /// Already completed, because no thread was available.
    Here(T),
}

/// Starts work on a scoped thread. If no thread is available, it runs at once.
pub fn beside<'scope, T: Send + 'scope>(
    scope: &'scope Scope<'scope, '_>,
    work: &'scope (impl Fn() -> T + Sync),
) -> Begun<'scope, T> {
    match Builder::new().spawn_scoped(scope, work) {
        Ok(thread) => Begun::There(thread),
        Err(_) => Begun::Here(work()),
    }
}

impl<T> Begun<'_, T> {
    /// Waits for the result. A panic is propagated.
    pub fn join(self) -> T {
        match self {
            Self::There(thread) => thread.join().unwrap_or_else(|panic| resume_unwind(panic)),
            Self::Here(done) => done,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn work_gives_its_result_wherever_it_is_done() {
        let work = || 3;
        std::thread::scope(|scope| assert_eq!(beside(scope, &work).join() + Begun::Here(4).join(), 7));
    }
}
