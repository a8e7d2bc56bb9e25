//! Running stages: once each, from the store if they are stored, anew if an input or the code has changed.

use std::sync::Arc;
use std::sync::atomic::{AtomicUsize, Ordering};

use nailnoise_pipeline::store::{LIMIT, Store};
use nailnoise_pipeline::{Code, PipelineError, Postcard, Progress, Silent, Stage, Uncached, key};
use serde::Serialize;

use crate::{Failure, Graph, Stored, folder};

/// Squares of the first numbers; counts how often it is computed.
#[derive(Serialize)]
struct Squares {
    count: u64,
    #[serde(skip)]
    computed: Arc<AtomicUsize>,
}

impl Stage for Squares {
    type Output = Vec<u64>;
    type Error = Failure;
    type Codec = Postcard;
    const NAME: &'static str = "squares";
    const CODE: Code = Code(&[("test", "1")]);

    fn compute(&self, _: &Progress) -> Result<Vec<u64>, Failure> {
        self.computed.fetch_add(1, Ordering::Relaxed);
        Ok((0..self.count).map(|n| n * n).collect())
    }
}

/// The sum of others.
#[derive(Serialize)]
struct Sum {
    terms: Stored<Vec<u64>>,
}

impl Stage for Sum {
    type Output = u64;
    type Error = Failure;
    type Codec = Uncached;
    const NAME: &'static str = "sum";
    const CODE: Code = Code(&[("test", "1")]);

    fn compute(&self, _: &Progress) -> Result<u64, Failure> {
        Ok(self.terms.get()?.iter().sum())
    }
}

/// A stage of the same name and inputs as [`Squares`], by other code.
#[derive(Serialize)]
struct OtherSquares {
    count: u64,
}

impl Stage for OtherSquares {
    type Output = Vec<u64>;
    type Error = Failure;
    type Codec = Postcard;
    const NAME: &'static str = "squares";
    const CODE: Code = Code(&[("test", "2")]);

    fn compute(&self, _: &Progress) -> Result<Vec<u64>, Failure> {
        Ok(Vec::new())
    }
}

/// A stage that cannot be computed.
#[derive(Serialize)]
struct Failing;

impl Stage for Failing {
    type Output = Vec<u64>;
    type Error = Failure;
    type Codec = Postcard;
    const NAME: &'static str = "failing";
    const CODE: Code = Code(&[]);

    fn compute(&self, _: &Progress) -> Result<Vec<u64>, Failure> {
        Err(Failure::Own)
    }
}

fn graph(store: Store) -> Graph {
    Graph::new(Arc::new(store), Arc::new(Silent))
}

fn squares(count: u64, computed: &Arc<AtomicUsize>) -> Squares {
    Squares {
        count,
        computed: Arc::clone(computed),
    }
}

#[test]
fn an_output_is_made_once_in_a_graph() {
    let (graph, computed) = (graph(Store::none()), Arc::default());
    let first = graph.add(squares(4, &computed));
    let second = graph.add(squares(4, &computed));
    assert_eq!((*first.get().unwrap()).clone(), [0, 1, 4, 9]);
    assert_eq!(second.get().unwrap().len(), 4);
    assert_eq!(computed.load(Ordering::Relaxed), 1);
}

#[test]
fn a_kept_output_is_found_by_the_next_graph() {
    let (place, computed) = (folder("graph/kept"), Arc::default());
    for _ in 0..2 {
        let graph = graph(Store::at(place.clone(), LIMIT));
        assert_eq!(*graph.get(squares(3, &computed)).unwrap(), [0, 1, 4]);
    }
    assert_eq!(computed.load(Ordering::Relaxed), 1);
}

#[test]
fn another_input_is_another_key() {
    let computed = Arc::default();
    assert_ne!(key(&squares(3, &computed)), key(&squares(4, &computed)));
}

#[test]
fn other_code_is_another_key() {
    assert_ne!(key(&squares(3, &Arc::default())), key(&OtherSquares { count: 3 }));
}

#[test]
fn a_stored_input_counts_by_the_key_of_its_stage_not_by_its_value() {
    let sum = |key| Sum {
        terms: Stored::ready([key; 32], vec![1, 2]),
    };
    assert_ne!(key(&sum(1)), key(&sum(2)));
    let other_value = Sum {
        terms: Stored::ready([1; 32], vec![3]),
    };
    assert_eq!(key(&sum(1)), key(&other_value));
}

#[test]
fn the_key_of_a_stage_is_known_before_its_inputs_are_made() {
    let (graph, computed) = (graph(Store::none()), Arc::default());
    let sum = graph.add(Sum {
        terms: graph.add(squares(4, &computed)),
    });
    assert_ne!(*sum.key(), [0; 32]);
    assert_eq!(computed.load(Ordering::Relaxed), 0);
    assert_eq!(*sum.get().unwrap(), 14);
}

#[test]
fn the_error_of_an_input_is_reported_once() {
    let graph = graph(Store::none());
    let failing = graph.add(Failing);
    let sum = graph.add(Sum { terms: failing.clone() });
    assert!(matches!(sum.get(), Err(Failure::Own)));
    assert!(matches!(
        failing.get(),
        Err(Failure::Pipeline(PipelineError::Upstream { stage: "failing" }))
    ));
}
