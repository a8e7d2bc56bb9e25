//! Work on another thread, or on the thread at hand where the system gives no other (`ulimit -u`, `ulimit -v`).

use std::panic::resume_unwind;
use std::thread::{Builder, Scope, ScopedJoinHandle};

/// Work that [`beside`] has begun.
pub enum Begun<'scope, T> {
    /// On a thread.
    There(ScopedJoinHandle<'scope, T>),
    /// Done, for want of a thread.
    Here(T),
}

/// Begins work on a thread of a scope. Without a thread it is done at once.
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
    /// The result. A panic continues unchanged.
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
