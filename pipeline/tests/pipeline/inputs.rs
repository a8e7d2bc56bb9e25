//! The inputs of a stage: all outputs of other stages that its key contains.

use std::collections::BTreeMap;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Arc, Barrier};

use nailnoise_pipeline::{Code, OnDemand, Progress, Stage, Uncached, key};
use serde::Serialize;

use crate::{Failure, Graph, Stored};

/// A number; counts how many are made.
#[derive(Serialize)]
struct Number {
    number: u64,
    #[serde(skip)]
    made: Arc<AtomicUsize>,
}

impl Stage for Number {
    type Output = u64;
    type Error = Failure;
    type Codec = Uncached;
    const NAME: &'static str = "number";
    const CODE: Code = Code(&[]);

    fn compute(&self, _: &Progress) -> Result<u64, Failure> {
        self.made.fetch_add(1, Ordering::SeqCst);
        Ok(self.number)
    }
}

/// Reads none of its inputs; counts how many are made before it is computed.
#[derive(Serialize)]
struct Reader<T> {
    inputs: T,
    #[serde(skip)]
    made: Arc<AtomicUsize>,
}

impl<T: Serialize + Send + Sync + 'static> Stage for Reader<T> {
    type Output = usize;
    type Error = Failure;
    type Codec = Uncached;
    const NAME: &'static str = "reader";
    const CODE: Code = Code(&[]);

    fn compute(&self, _: &Progress) -> Result<usize, Failure> {
        Ok(self.made.load(Ordering::SeqCst))
    }
}

/// Inputs made before a stage with these fields is computed, of the numbers 0 to 4.
fn made_before<T: Serialize + Send + Sync + 'static>(fields: impl FnOnce([Stored<u64>; 5]) -> T) -> usize {
    let (graph, made) = (Graph::default(), Arc::<AtomicUsize>::default());
    let number = |number| {
        graph.add(Number {
            number,
            made: Arc::clone(&made),
        })
    };
    let inputs = fields([0, 1, 2, 3, 4].map(number));
    *graph.get(Reader { inputs, made }).unwrap()
}

#[derive(Serialize)]
enum Method {
    One(f64, Stored<u64>),
    Two { first: Stored<u64>, second: Stored<u64> },
    Neither,
}

#[test]
fn inputs_are_found_wherever_a_field_has_them() {
    assert_eq!(made_before(|_| 3.0), 0);
    assert_eq!(made_before(|[a, ..]| a), 1);
    assert_eq!(made_before(|[a, b, ..]| (Some(a), None::<Stored<u64>>, [b])), 2);
    assert_eq!(made_before(|all| vec![all.to_vec(), Vec::new()]), 5);
    assert_eq!(made_before(|[a, b, ..]| BTreeMap::from([("a", a), ("b", b)])), 2);
    assert_eq!(made_before(|[a, ..]| Method::One(1.0, a)), 1);
    assert_eq!(made_before(|[first, second, ..]| Method::Two { first, second }), 2);
    assert_eq!(made_before(|_| Method::Neither), 0);
}

#[test]
fn an_input_in_two_fields_is_one_input() {
    assert_eq!(made_before(|[a, ..]| [a.clone(), a]), 1);
}

#[test]
fn inputs_on_demand_are_not_made_before() {
    assert_eq!(made_before(|[a, ..]| OnDemand(a)), 0);
    assert_eq!(made_before(|[a, b, c, ..]| (a, OnDemand(vec![b]), c)), 2);
}

#[test]
fn inputs_on_demand_count_in_the_key_as_others() {
    let reader = |key| {
        let made = Arc::default();
        Reader {
            inputs: vec![Stored::ready([key; 32], 5_u64)],
            made,
        }
    };
    let on_demand = |key| {
        let made = Arc::default();
        Reader {
            inputs: OnDemand(vec![Stored::ready([key; 32], 5_u64)]),
            made,
        }
    };
    assert_eq!(key(&reader(1)), key(&on_demand(1)));
    assert_ne!(key(&on_demand(1)), key(&on_demand(2)));
}

#[test]
fn a_value_at_hand_is_an_input_as_well() {
    let made = Arc::<AtomicUsize>::default();
    let other = Graph::default().add(Number {
        number: 1,
        made: Arc::clone(&made),
    });
    let inputs = (Stored::ready([1; 32], 2_u64), other);
    assert_eq!(*Graph::default().get(Reader { inputs, made }).unwrap(), 1);
}

/// Waits until another stage is being computed at the same time.
#[derive(Serialize)]
struct Meeting {
    number: u64,
    #[serde(skip)]
    both: Arc<Barrier>,
}

impl Stage for Meeting {
    type Output = ();
    type Error = Failure;
    type Codec = Uncached;
    const NAME: &'static str = "meeting";
    const CODE: Code = Code(&[]);

    fn compute(&self, _: &Progress) -> Result<(), Failure> {
        self.both.wait();
        Ok(())
    }
}

/// It would wait forever for inputs that are made one after the other.
#[test]
fn inputs_are_made_side_by_side() {
    let (graph, both) = (Graph::default(), Arc::new(Barrier::new(2)));
    let meeting = |number| {
        graph.add(Meeting {
            number,
            both: Arc::clone(&both),
        })
    };
    let inputs = [1, 2].map(meeting);
    let made = Arc::default();
    graph.get(Reader { inputs, made }).unwrap();
}
