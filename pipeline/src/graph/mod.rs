//! Runs stages: looks up their outputs in the store, or else computes and stores them, in parallel where possible, and
//! measures their time.
//!
//! The graph contains no physics; it handles only keys, codecs and inputs of stages. Each output is made once and
//! shared within a graph as long as it is referenced; it is freed when no pending stage needs it.

mod stopwatch;

use std::any::Any;
use std::collections::HashMap;
use std::marker::PhantomData;
use std::sync::{Arc, Mutex, PoisonError, Weak};

use stopwatch::Stopwatch;

use crate::codec::Codec;
use crate::error::{PipelineError, StageError, first_cause};
use crate::inputs::{self, Input};
use crate::progress::{Observer, Progress, Silent, WithoutStages};
use crate::stage::Stage;
use crate::store::{Digest, Key, Store};
use crate::stored::{Source, Stored};
use crate::threads::{Begun, beside};
use crate::timing::Timing;

/// A set of stages that share a store, an observer and a clock.
pub struct Graph<E> {
    context: Arc<Context>,
    nodes: Arc<Mutex<HashMap<Digest, Weak<dyn Any + Send + Sync>>>>,
    errors: PhantomData<fn() -> E>,
}

impl<E> Clone for Graph<E> {
    fn clone(&self) -> Self {
        Self {
            context: Arc::clone(&self.context),
            nodes: Arc::clone(&self.nodes),
            errors: PhantomData,
        }
    }
}

/// Common data of all nodes of a graph.
struct Context {
    store: Arc<Store>,
    progress: Progress,
    timing: Mutex<Timing>,
}

impl<E: StageError> Graph<E> {
    /// An empty graph.
    pub fn new(store: Arc<Store>, observer: Arc<dyn Observer>) -> Self {
        Self {
            context: Arc::new(Context {
                store,
                progress: Progress::to(observer),
                timing: Mutex::default(),
            }),
            nodes: Arc::default(),
            errors: PhantomData,
        }
    }

    /// Creates an empty graph that does not report the start of stages, for work that runs the same stages many times.
    pub fn quiet(store: &Store, observer: Arc<dyn Observer>) -> Self {
        Self::new(Arc::new(store.clone()), Arc::new(WithoutStages(observer)))
    }

    /// Adds a stage, whose output is made when it is first read. Stages with the same key share one output.
    pub fn add<S: Stage<Error = E>>(&self, stage: S) -> Stored<S::Output, E> {
        let (key, inputs) = inputs::collect(|| key(&stage));
        let mut nodes = self.nodes.lock().unwrap_or_else(PoisonError::into_inner);
        let known = nodes
            .get(&key)
            .and_then(Weak::upgrade)
            .and_then(|node| node.downcast::<Node<S>>().ok());
        let node = known.unwrap_or_else(|| {
            let node = Arc::new(Node {
                key,
                context: Arc::clone(&self.context),
                state: Mutex::new(State::Pending(stage, inputs)),
            });
            let any: Arc<dyn Any + Send + Sync> = Arc::clone(&node) as _;
            nodes.insert(key, Arc::downgrade(&any));
            node
        });
        Stored::new(key, node)
    }

    /// Returns the output of a stage.
    ///
    /// # Errors
    /// The error of the stage or of one of its inputs.
    pub fn get<S: Stage<Error = E>>(&self, stage: S) -> Result<Arc<S::Output>, E> {
        self.add(stage).get()
    }

    /// Makes several outputs in parallel.
    ///
    /// # Errors
    /// The first error that is a cause rather than a consequence.
    pub fn prepare(&self, inputs: &[&dyn Input<E>]) -> Result<(), E> {
        prepare(inputs)
    }

    /// Runs the caller's own work and records its time under `name`.
    pub fn time<T>(&self, name: &'static str, work: impl FnOnce() -> T) -> T {
        self.context.time(name, work)
    }

    /// Wall time of each stage so far.
    pub fn timing(&self) -> Timing {
        self.context
            .timing
            .lock()
            .unwrap_or_else(PoisonError::into_inner)
            .clone()
    }

    /// Where progress is reported.
    pub fn progress(&self) -> &Progress {
        &self.context.progress
    }

    /// The store of the outputs.
    pub fn store(&self) -> &Store {
        &self.context.store
    }
}

impl<E: StageError> Default for Graph<E> {
    /// An empty graph that stores nothing and reports no progress.
    fn default() -> Self {
        Self::new(Arc::default(), Arc::new(Silent))
    }
}

/// Digest of a stage's name, of its code and of its inputs.
pub fn key<S: Stage>(stage: &S) -> Digest {
    Key::empty().with(S::NAME).with(&S::CODE).with(stage).digest()
}

impl Context {
    fn time<T>(&self, name: &'static str, work: impl FnOnce() -> T) -> T {
        let (value, own) = Stopwatch::run(work);
        self.timing
            .lock()
            .unwrap_or_else(PoisonError::into_inner)
            .add(name, own);
        value
    }
}

/// A stage and its state.
struct Node<S: Stage> {
    key: Digest,
    context: Arc<Context>,
    state: Mutex<State<S>>,
}

enum State<S: Stage> {
    /// Contains the inputs, which are released once the output is made.
    Pending(S, Vec<Arc<dyn Input<S::Error>>>),
    Done(Arc<S::Output>),
    Failed,
}

impl<S: Stage> Source<S::Output, S::Error> for Node<S> {
    fn get(&self) -> Result<Arc<S::Output>, S::Error> {
        // Waiting here could deadlock: the output may need a thread of the caller's parallel loop.
        debug_assert!(
            rayon::current_thread_index().is_none(),
            "inputs are read before parallel work begins"
        );
        let mut state = Stopwatch::wait(|| self.state.lock().unwrap_or_else(PoisonError::into_inner));
        let made = match &*state {
            State::Done(value) => return Ok(Arc::clone(value)),
            State::Failed => return Err(PipelineError::Upstream { stage: S::NAME }.into()),
            State::Pending(stage, inputs) => self.make(stage, inputs),
        };
        match made {
            Ok(value) => {
                let value = Arc::new(value);
                *state = State::Done(Arc::clone(&value));
                Ok(value)
            }
            Err(error) => {
                *state = State::Failed;
                Err(error)
            }
        }
    }
}

impl<S: Stage> Node<S> {
    /// Loads the output from the store, or computes and stores it.
    fn make(&self, stage: &S, inputs: &[Arc<dyn Input<S::Error>>]) -> Result<S::Output, S::Error> {
        let Context { store, progress, .. } = &*self.context;
        let before = if S::Codec::KEPT {
            store.stamp(S::NAME, &self.key)
        } else {
            None
        };
        if let Some(value) = self.kept() {
            return Ok(value);
        }
        Stopwatch::wait(|| {
            let inputs: Vec<&dyn Input<S::Error>> = inputs.iter().map(|input| &**input).collect();
            prepare(&inputs)
        })?;
        // The claim is held until the output is stored. Inputs are made first, so that other processes wait only for
        // this stage.
        let _claim = S::Codec::KEPT.then(|| {
            let step = || {
                // The cause of a long wait.
                store.take_notes().iter().for_each(|note| progress.note(note));
                progress.observer().step();
            };
            Stopwatch::wait(|| store.claim(S::NAME, &self.key, before, step))
        });
        if S::Codec::KEPT
            && store.stamp(S::NAME, &self.key) != before
            && let Some(value) = self.kept()
        {
            return Ok(value);
        }
        progress.stage(S::NAME);
        let value = self.context.time(S::NAME, || stage.compute(progress))?;
        if S::Codec::KEPT {
            self.context
                .time(S::NAME, || store.save::<_, S::Codec>(S::NAME, &self.key, &value));
            store.take_notes().iter().for_each(|note| progress.note(note));
        }
        Ok(value)
    }

    /// Loads the output from the store, if present.
    fn kept(&self) -> Option<S::Output> {
        let Context { store, progress, .. } = &*self.context;
        if !S::Codec::KEPT {
            return None;
        }
        let found = self
            .context
            .time(S::NAME, || store.load::<_, S::Codec>(S::NAME, &self.key));
        store.take_notes().iter().for_each(|note| progress.note(note));
        found
    }
}

/// Makes inputs in parallel, each on a separate thread, so that the thread pool remains free for the work within each.
fn prepare<E: StageError>(inputs: &[&dyn Input<E>]) -> Result<(), E> {
    let Some((last, others)) = inputs.split_last() else {
        return Ok(());
    };
    let others: Vec<_> = others.iter().map(|input| || input.prepare()).collect();
    let results: Vec<Result<(), E>> = std::thread::scope(|scope| {
        let others: Vec<_> = others.iter().map(|work| beside(scope, work)).collect();
        let last = last.prepare();
        others.into_iter().map(Begun::join).chain([last]).collect()
    });
    first_cause(results.into_iter().filter_map(Result::err))
}
