//! Past flows of passages whose flow arrives with a delay.

use std::cell::RefCell;
use std::rc::Rc;

/// Time before the first flow that its rounding may require \[s\].
const ROUNDING: f64 = 1e-12;

/// Mass and enthalpy flow at a time, and their slopes.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Node {
    pub(crate) time: f64,
    pub(crate) flow: [f64; 2],
    pub(crate) slope: [f64; 2],
}

/// Past flows of each passage, at the ends of all steps; the workspaces of a run share them.
pub(crate) type PastFlows = Rc<RefCell<Vec<Vec<Node>>>>;

/// Flow at a past time, by cubic Hermite interpolation between the ends of steps; zero before the first.
pub(crate) fn interpolated(nodes: &[Node], time: f64) -> [f64; 2] {
    let right = nodes.partition_point(|node| node.time <= time);
    let (Some(a), Some(b)) = (right.checked_sub(1).and_then(|left| nodes.get(left)), nodes.get(right)) else {
        // After the last known flow it is constant, which matters only within the rounding of the time.
        return match nodes.last() {
            Some(last) if time >= last.time => last.flow,
            _ => nodes
                .first()
                .filter(|first| first.time - time < ROUNDING)
                .map_or([0.0; 2], |first| first.flow),
        };
    };
    let h = b.time - a.time;
    let x = (time - a.time) / h;
    std::array::from_fn(|i| {
        let (fa, da, db) = (a.flow[i], a.slope[i], b.slope[i]);
        let chord = b.flow[i] - fa;
        fa + x * (chord + (1.0 - x) * ((1.0 - 2.0 * x) * -chord + (1.0 - x) * da * h - x * db * h))
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn cubics_are_reproduced() {
        let f = |t: f64| 1.0 + t - 2.0 * t * t + 3.0 * t * t * t;
        let d = |t: f64| 1.0 - 4.0 * t + 9.0 * t * t;
        let node = |t: f64| Node {
            time: t,
            flow: [f(t), 2.0 * f(t)],
            slope: [d(t), 2.0 * d(t)],
        };
        let nodes = [node(0.0), node(0.3), node(1.0)];
        for t in [0.0, 0.1, 0.29, 0.3, 0.7, 1.0] {
            let [mass, enthalpy] = interpolated(&nodes, t);
            assert!(
                (mass - f(t)).abs() < 1e-14 && (enthalpy - 2.0 * f(t)).abs() < 1e-14,
                "{t}"
            );
        }
        assert_eq!(interpolated(&nodes, -0.1), [0.0; 2]);
    }
}
