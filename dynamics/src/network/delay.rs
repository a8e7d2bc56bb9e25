//! Passages whose flow arrives with a delay, or leaves without it (published forms of a trigger's channel).

use super::gas::{Air, Gas};
use super::kernels::{Ends, Flow};
use super::mode::Mode;
use super::past_flows::{Node, interpolated};
use super::plan::{PassagePlan, Plan};
use super::rates::Workspace;
use nailnoise_penetration::{Dual, Real};

impl Plan {
    /// Whether the trigger of a passage lets it flow, without the delay of its gate.
    fn is_released(&self, passage: &PassagePlan, mode: &Mode) -> bool {
        let Some((trigger, inverted)) = passage.follows else {
            return passage.is_open(mode);
        };
        let others = passage.switches.iter().filter(|switch| Some(**switch) != passage.gate);
        !passage.shut
            && mode.is_on(self.triggers[trigger]) != inverted
            && others.into_iter().all(|switch| mode.is_on(*switch))
    }

    /// Flow that arrives through a passage one delay after it entered.
    pub(crate) fn arriving(&self, index: usize, delay: f64, t: f64, mode: &Mode, w: &Workspace) -> Flow<f64> {
        let passage = &self.passages[index];
        let mut flow = passage.still(&self.ends(index, w));
        if passage.is_open(mode) {
            let [mass, enthalpy] = w
                .past
                .borrow()
                .get(index)
                .map_or([0.0; 2], |nodes| interpolated(nodes, t - delay));
            // An interpolated flow of a passage in one direction may be slightly negative.
            if !(passage.one_way && mass < 0.0) {
                (flow.mass, flow.enthalpy) = (mass, enthalpy);
            }
        }
        flow
    }

    /// Flow that leaves the first space of a passage, given the one that arrives.
    #[inline]
    pub(crate) fn leaving<S: Real>(
        &self,
        passage: &PassagePlan,
        mode: &Mode,
        ends: &Ends<S>,
        t: f64,
        arriving: &Flow<S>,
    ) -> Flow<S> {
        let Some(factor) = passage.undelayed else {
            return *arriving;
        };
        if !self.is_released(passage, mode) {
            return passage.still(ends);
        }
        let flow = passage.through(self.air(passage), ends, t, None);
        Flow {
            mass: flow.mass * factor,
            enthalpy: flow.enthalpy * factor,
            ..flow
        }
    }

    pub(crate) fn air(&self, passage: &PassagePlan) -> &Air {
        &self.airs[passage.air]
    }

    /// Stores the flows that enter the delayed passages at a state; `rate` is its derivative, and the workspace
    /// contains the instant.
    pub(crate) fn remember(&self, t: f64, y: &[f64], rate: &[f64], mode: &Mode, w: &Workspace) {
        let mut past = w.past.borrow_mut();
        for (index, passage) in self.passages.iter().enumerate() {
            if passage.delay.is_none() || !self.is_released(passage, mode) {
                continue;
            }
            let plain = self.ends(index, w);
            let gas = |gas: usize, plain: Gas<f64>| {
                let [pressure, temperature] = self.gas_rates(gas, y, rate, w);
                Gas {
                    pressure: along(plain.pressure, pressure),
                    temperature: along(plain.temperature, temperature),
                }
            };
            let travel = |place: usize| {
                let speed = passage.travels[place].map_or(0.0, |pair| w.speed(pair));
                along(plain.travel[place], speed)
            };
            let ends = Ends {
                from: gas(passage.from, plain.from),
                to: gas(passage.to, plain.to),
                travel: [travel(0), travel(1)],
            };
            let flow = passage.through(self.air(passage), &ends, t, None);
            if let Some(nodes) = past.get_mut(index) {
                nodes.push(Node {
                    time: t,
                    flow: [flow.mass.value, flow.enthalpy.value],
                    slope: [flow.mass.slope[0], flow.enthalpy.slope[0]],
                });
            }
        }
    }

    /// Rates of pressure and temperature of a gas; zero for a reservoir.
    fn gas_rates(&self, gas: usize, y: &[f64], rate: &[f64], w: &Workspace) -> [f64; 2] {
        if gas >= self.volumes.len() {
            return [0.0; 2];
        }
        let (u, m) = (self.energy() + gas, self.mass() + gas);
        let pressure = w.pressure[gas] * (rate[u] / y[u] - w.growth[gas] / w.volume[gas]);
        let temperature = match self.temperature {
            Some(_) => 0.0,
            None => w.temperature[gas] * (rate[u] / y[u] - rate[m] / y[m]),
        };
        [pressure, temperature]
    }
}

fn along(value: f64, slope: f64) -> Dual<1> {
    Dual { value, slope: [slope] }
}
