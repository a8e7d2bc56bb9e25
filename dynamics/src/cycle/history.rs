//! Past flow of the trigger channel, for the published form that delays the flow itself (C-04).

use super::state::{SIZE, State};
use super::system::System;
use nailnoise_penetration::{Dual, Real};

/// Mass and enthalpy flow.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Stream<S> {
    /// \[kg/s\].
    pub(crate) mass: S,
    /// \[W\].
    pub(crate) enthalpy: S,
}

impl<S: Real> Stream<S> {
    pub(crate) fn still() -> Self {
        Self {
            mass: S::constant(0.0),
            enthalpy: S::constant(0.0),
        }
    }

    pub(crate) fn scaled(self, factor: f64) -> Self {
        Self {
            mass: self.mass * factor,
            enthalpy: self.enthalpy * factor,
        }
    }
}

impl Stream<f64> {
    /// The same flow, independent of the present state.
    pub(crate) fn lift<S: Real>(self) -> Stream<S> {
        Stream {
            mass: S::constant(self.mass),
            enthalpy: S::constant(self.enthalpy),
        }
    }
}

/// Flow that left or entered the channel one delay earlier.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Past {
    pub(crate) vent: Stream<f64>,
    pub(crate) fill: Stream<f64>,
}

impl Past {
    pub(crate) fn none() -> Self {
        Self {
            vent: Stream::still(),
            fill: Stream::still(),
        }
    }
}

/// Flow at a time with its slope.
#[derive(Debug, Clone, Copy)]
struct Node {
    time: f64,
    flow: Stream<f64>,
    slope: Stream<f64>,
}

/// Flow at the ends of all steps with cubic Hermite interpolation; separate for the pulled and the released trigger,
/// because the flow is discontinuous between them.
#[derive(Debug, Clone, Default)]
pub(crate) struct History {
    pulled: Vec<Node>,
    released: Vec<Node>,
}

impl History {
    /// Stores the flow at the end of a step or the start of a segment.
    pub(crate) fn push(&mut self, system: &System, released: bool, time: f64, y: &State, rate: &State) {
        let along: [Dual<1>; SIZE] = std::array::from_fn(|i| Dual {
            value: y[i],
            slope: [rate[i]],
        });
        let stream = system.stream(&system.instant(&along).gas, released);
        let flow = Stream {
            mass: stream.mass.value,
            enthalpy: stream.enthalpy.value,
        };
        let slope = Stream {
            mass: stream.mass.slope[0],
            enthalpy: stream.enthalpy.slope[0],
        };
        let nodes = if released { &mut self.released } else { &mut self.pulled };
        nodes.push(Node { time, flow, slope });
    }

    /// Flow at a past time.
    pub(crate) fn at(&self, time: f64) -> Past {
        Past {
            vent: read(&self.pulled, time),
            fill: read(&self.released, time),
        }
    }
}

fn read(nodes: &[Node], time: f64) -> Stream<f64> {
    let right = nodes.partition_point(|node| node.time <= time);
    let (Some(a), Some(b)) = (right.checked_sub(1).and_then(|left| nodes.get(left)), nodes.get(right)) else {
        // Before the first flow it is zero; after the last known one it is constant, which matters only within the
        // rounding of the time.
        return match nodes.last() {
            Some(last) if time >= last.time => last.flow,
            _ => nodes
                .first()
                .filter(|first| first.time - time < 1e-12)
                .map_or(Stream::still(), |first| first.flow),
        };
    };
    let h = b.time - a.time;
    let x = (time - a.time) / h;
    let cubic = |fa: f64, fb: f64, da: f64, db: f64| {
        let chord = fb - fa;
        fa + x * (chord + (1.0 - x) * ((1.0 - 2.0 * x) * -chord + (1.0 - x) * da * h - x * db * h))
    };
    Stream {
        mass: cubic(a.flow.mass, b.flow.mass, a.slope.mass, b.slope.mass),
        enthalpy: cubic(a.flow.enthalpy, b.flow.enthalpy, a.slope.enthalpy, b.slope.enthalpy),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn cubics_are_reproduced() {
        let f = |t: f64| 1.0 + t - 2.0 * t * t + 3.0 * t * t * t;
        let d = |t: f64| 1.0 - 4.0 * t + 9.0 * t * t;
        let node = |t: f64| {
            let stream = |x: f64| Stream {
                mass: x,
                enthalpy: 2.0 * x,
            };
            Node {
                time: t,
                flow: stream(f(t)),
                slope: stream(d(t)),
            }
        };
        let nodes = [node(0.0), node(0.3), node(1.0)];
        for t in [0.0, 0.1, 0.29, 0.3, 0.7, 1.0] {
            let found = read(&nodes, t);
            assert!(
                (found.mass - f(t)).abs() < 1e-14 && (found.enthalpy - 2.0 * f(t)).abs() < 1e-14,
                "{t}"
            );
        }
        assert_eq!(read(&nodes, -0.1).mass, 0.0);
    }
}
