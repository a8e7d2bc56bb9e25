//! The Jacobian by elements: each block is evaluated once in dual numbers of its few variables, and the derivatives are
//! chained through the pressures and temperatures of the volumes.
//!
//! ```text
//! dP/dU = P/U,  dP/dx = -P s A/V,  dT/dU = T/U,  dT/dm = -T/m
//! ```

use super::assembly::ForceLaw;
use super::elements::Element;
use super::kernels::Ends;
use super::mode::Mode;
use super::plan::{Pair, Plan};
use super::rates::Workspace;
use super::resistance::interpolate;
use nailnoise_penetration::{Dual, Real};

use super::gas::Gas;

/// Derivatives of the rates with respect to the states, by columns with the length of the complete vector.
#[derive(Debug, Clone)]
pub(crate) struct Jacobian {
    values: Vec<f64>,
    rows: usize,
    /// Derivatives of each volume's pressure: column and value.
    pressure: Vec<Vec<(usize, f64)>>,
    temperature: Vec<[(usize, f64); 2]>,
    /// Velocities and accelerations of a workpiece that moves as prescribed.
    wood: Option<Prescribed>,
}

/// Motion of a workpiece over its clock, which has the column of the body's position.
#[derive(Debug, Clone, Copy)]
struct Prescribed {
    body: usize,
    grip: usize,
    /// Of surface and grip.
    velocity: [f64; 2],
    acceleration: [f64; 2],
}

impl Jacobian {
    pub(crate) fn new(plan: &Plan) -> Self {
        Self {
            values: vec![0.0; plan.size() * plan.states()],
            rows: plan.size(),
            pressure: vec![Vec::new(); plan.volumes.len()],
            temperature: vec![[(0, 0.0); 2]; plan.volumes.len()],
            wood: None,
        }
    }

    /// By columns, rows x states.
    pub(crate) fn values(&self) -> &[f64] {
        &self.values
    }

    #[inline]
    fn add(&mut self, row: usize, column: usize, value: f64) {
        self.values[column * self.rows + row] += value;
    }

    /// Adds `factor` times the derivatives of a gas's pressure and temperature to a row.
    #[inline]
    fn add_gas(&mut self, row: usize, gas: usize, by_pressure: f64, by_temperature: f64) {
        let Some(columns) = self.pressure.get(gas) else { return };
        for (column, value) in columns {
            self.values[column * self.rows + row] += by_pressure * value;
        }
        for (column, value) in self.temperature[gas] {
            self.values[column * self.rows + row] += by_temperature * value;
        }
    }

    /// Adds derivatives with respect to a pair's travel and its rate to a row.
    #[inline]
    fn add_pair(&mut self, row: usize, pair: Pair, by_travel: f64, by_speed: f64, ground: usize) {
        for (body, sign) in [(pair.on, 1.0), (pair.against, -1.0)] {
            if let Some((column, velocity, acceleration)) = self.prescribed(body) {
                self.add(row, column, sign * (by_travel * velocity + by_speed * acceleration));
            } else if body != ground {
                self.add(row, 2 * body, sign * by_travel);
                self.add(row, 2 * body + 1, sign * by_speed);
            }
        }
    }

    /// Column, velocity and acceleration of a place that moves as prescribed; none for others.
    #[inline]
    fn prescribed(&self, place: usize) -> Option<(usize, f64, f64)> {
        let wood = self.wood.as_ref()?;
        let of = |i: usize| (2 * wood.body, wood.velocity[i], wood.acceleration[i]);
        if place == wood.body {
            Some(of(0))
        } else {
            (place == wood.grip).then(|| of(1))
        }
    }
}

/// How a force on a body enters the rates: row and factor.
#[derive(Clone, Copy)]
struct Target {
    row: usize,
    factor: f64,
}

/// Rows that a pair's force enters, beginning with that of `on`.
fn targets(plan: &Plan, mode: &Mode, pair: Pair) -> [Target; 2] {
    let target = |body: usize, sign: f64| {
        if body == plan.ground() {
            Target {
                row: plan.ground_impulse,
                factor: sign,
            }
        } else if let Some(driven) = plan.driven
            && (body == driven.body || body == plan.grip())
        {
            // Forces; `wood_rows` computes the rows from them.
            Target {
                row: if body == driven.body { 2 * body + 1 } else { driven.work },
                factor: sign,
            }
        } else {
            Target {
                row: 2 * body + 1,
                factor: sign / plan.moving_mass(body, mode),
            }
        }
    };
    [target(pair.on, 1.0), target(pair.against, -1.0)]
}

impl Plan {
    /// Fills the Jacobian at a state.
    pub(crate) fn jacobian(&self, t: f64, y: &[f64], mode: &Mode, w: &mut Workspace, j: &mut Jacobian) {
        j.values.fill(0.0);
        self.instant(y, mode, w);
        j.wood = self.driven.map(|driven| {
            self.flows(t, mode, w);
            self.forces(t, mode, w);
            let places = [driven.body, self.grip()];
            Prescribed {
                body: driven.body,
                grip: self.grip(),
                velocity: places.map(|place| w.velocity[place]),
                acceleration: places.map(|place| w.acceleration[place]),
            }
        });
        for body in 0..self.bodies.len() {
            j.add(2 * body, 2 * body + 1, 1.0);
        }
        self.columns(y, w, j);
        self.face_elements(mode, w, j);
        self.passage_elements(t, mode, w, j);
        self.wall_elements(w, j);
        self.pair_elements(mode, w, &mut |element| self.scatter(mode, element, j));
        for imposed in &self.forces {
            if let (ForceLaw::Table(points), Some(work)) = (&imposed.law, imposed.work) {
                j.add_pair(work, imposed.pair, 0.0, interpolate(points, t).0, self.ground());
            }
        }
        self.isothermal_rows(j);
        self.wood_rows(w, j);
    }

    /// Derivatives of pressures and temperatures.
    fn columns(&self, y: &[f64], w: &Workspace, j: &mut Jacobian) {
        let (energy, mass) = (self.energy(), self.mass());
        for i in 0..self.volumes.len() {
            j.pressure[i].clear();
            j.pressure[i].push((energy + i, (self.gamma - 1.0) / w.volume[i]));
            j.temperature[i] = match self.temperature {
                Some(_) => [(energy + i, 0.0), (mass + i, 0.0)],
                None => [
                    (energy + i, (self.gamma - 1.0) / (y[mass + i] * self.gas_constant)),
                    (mass + i, -w.temperature[i] / y[mass + i]),
                ],
            };
        }
        for face in &self.faces {
            if let Some(i) = face.volume {
                let slope = -w.pressure[i] * face.area / w.volume[i];
                for (body, sign) in [(face.pair.on, 1.0), (face.pair.against, -1.0)] {
                    if let Some((column, velocity, _)) = j.prescribed(body) {
                        j.pressure[i].push((column, sign * slope * velocity));
                    } else if body != self.ground() {
                        j.pressure[i].push((2 * body, sign * slope));
                    }
                }
            }
        }
    }

    fn face_elements(&self, mode: &Mode, w: &Workspace, j: &mut Jacobian) {
        let ground = self.ground();
        for face in &self.faces {
            let Some(i) = face.pressed else { continue };
            for target in targets(self, mode, face.pair) {
                j.add_gas(target.row, i, target.factor * face.area, 0.0);
            }
            let growth = face.area * w.speed(face.pair);
            let power = face.area * w.pressure[i];
            let swept = face.volume.map(|i| (self.energy() + i, -self.expansion));
            let rows = [swept, face.work.map(|row| (row, 1.0))];
            let ledger = self.volumes[i].ledger.filter(|_| face.volume.is_some());
            let volume_work = ledger.map(|ledger| (ledger.work, 1.0));
            for (row, sign) in rows.into_iter().flatten().chain(volume_work) {
                j.add_gas(row, i, sign * growth, 0.0);
                j.add_pair(row, face.pair, 0.0, sign * power, ground);
            }
        }
    }

    fn passage_elements(&self, t: f64, mode: &Mode, w: &Workspace, j: &mut Jacobian) {
        let volumes = self.volumes.len();
        for (index, passage) in self.passages.iter().enumerate() {
            let arrives = passage.delay.is_none() && passage.is_open(mode);
            if !arrives && passage.undelayed.is_none() {
                continue;
            }
            let plain = self.ends(index, w);
            let along = |value: f64, input: usize| {
                let mut slope = [0.0; 6];
                slope[input] = 1.0;
                Dual { value, slope }
            };
            let gas = |gas: Gas<f64>, is_volume: bool, input: usize| {
                if is_volume {
                    Gas {
                        pressure: along(gas.pressure, input),
                        temperature: along(gas.temperature, input + 1),
                    }
                } else {
                    Gas {
                        pressure: Dual::constant(gas.pressure),
                        temperature: Dual::constant(gas.temperature),
                    }
                }
            };
            let ends = Ends {
                from: gas(plain.from, passage.from < volumes, 0),
                to: gas(plain.to, passage.to < volumes, 2),
                travel: [along(plain.travel[0], 4), along(plain.travel[1], 5)],
            };
            let air = &self.airs[passage.air];
            // A delayed flow depends on the past only.
            let flow = if arrives {
                passage.through(air, &ends, t, None)
            } else {
                passage.still(&ends)
            };
            let leaving = self.leaving(passage, mode, &ends, t, &flow);
            let [out, into] = passage.carried(&leaving, &flow);
            let mut scatter = |row: usize, factor: f64, value: &Dual<6>| {
                let [p0, t0, p1, t1, x0, x1] = value.slope;
                j.add_gas(row, passage.from, factor * p0, factor * t0);
                j.add_gas(row, passage.to, factor * p1, factor * t1);
                for (pair, slope) in passage.travels.into_iter().zip([x0, x1]) {
                    if let Some(pair) = pair {
                        j.add_pair(row, pair, factor * slope, 0.0, self.ground());
                    }
                }
            };
            for (gas, sign, [mass, energy]) in [(passage.from, -1.0, out), (passage.to, 1.0, into)] {
                if gas < volumes {
                    scatter(self.energy() + gas, sign, &energy);
                    scatter(self.mass() + gas, sign, &mass);
                }
            }
            if let Some(ledger) = passage.ledger {
                scatter(ledger.mass, 1.0, &flow.mass);
                scatter(ledger.enthalpy, 1.0, &flow.enthalpy);
            }
            if !passage.jet {
                continue;
            }
            let thrust = passage.thrust(air, &ends, &flow, t);
            for imposed in &self.forces {
                let ForceLaw::Jet { passage: of, share } = imposed.law else {
                    continue;
                };
                if of != index {
                    continue;
                }
                let [on, against] = targets(self, mode, imposed.pair);
                scatter(on.row, share * on.factor, &thrust);
                if imposed.pair.against == self.ground() {
                    scatter(self.outer_impulse, share, &thrust);
                } else {
                    scatter(against.row, share * against.factor, &thrust);
                }
                if let Some(work) = imposed.work {
                    scatter(work, share * w.speed(imposed.pair), &thrust);
                }
            }
            for imposed in &self.forces {
                if let (ForceLaw::Jet { passage: of, share }, Some(work)) = (&imposed.law, imposed.work)
                    && *of == index
                {
                    j.add_pair(work, imposed.pair, 0.0, share * thrust.value, self.ground());
                }
            }
        }
    }

    /// Heat from the walls: derivatives with respect to temperature and to the travels of the faces.
    fn wall_elements(&self, w: &Workspace, j: &mut Jacobian) {
        for (i, volume) in self.volumes.iter().enumerate() {
            if volume.transfer != 0.0 && volume.isothermal.is_none() {
                for row in self.heat_rows(i) {
                    j.add_gas(row, i, 0.0, -volume.transfer * w.wall[i]);
                }
            }
        }
        for face in &self.faces {
            let Some(i) = face.volume else { continue };
            let volume = &self.volumes[i];
            if face.perimeter != 0.0 && volume.transfer != 0.0 && volume.isothermal.is_none() {
                let slope = volume.transfer * face.perimeter * (volume.wall_temperature - w.temperature[i]);
                for row in self.heat_rows(i) {
                    j.add_pair(row, face.pair, slope, 0.0, self.ground());
                }
            }
        }
    }

    fn heat_rows(&self, volume: usize) -> impl Iterator<Item = usize> {
        let ledger = self.volumes[volume].ledger.map(|ledger| ledger.heat);
        [Some(self.energy() + volume), self.heat, ledger].into_iter().flatten()
    }

    /// The energy of an isothermal volume follows its mass; the wall heat is the difference from the energy balance,
    /// which the energy row contains so far.
    fn isothermal_rows(&self, j: &mut Jacobian) {
        let cv = self.cp - self.gas_constant;
        for (i, volume) in self.volumes.iter().enumerate() {
            let Some(temperature) = volume.isothermal else { continue };
            let (energy, mass) = (self.energy() + i, self.mass() + i);
            for column in 0..self.states() {
                let at = column * j.rows;
                let balance = j.values[at + energy];
                let rise = cv * temperature * j.values[at + mass];
                j.values[at + energy] = rise;
                let ledger = volume.ledger.map(|ledger| ledger.heat);
                for row in [self.heat, ledger].into_iter().flatten() {
                    j.values[at + row] += rise - balance;
                }
            }
        }
    }

    /// The rows of a driven body, whose motion is prescribed, and of the work on it.
    fn wood_rows(&self, w: &Workspace, j: &mut Jacobian) {
        let (Some(driven), Some(wood)) = (self.driven, j.wood) else {
            return;
        };
        let [seat, grip] = [2 * driven.body + 1, driven.work];
        for column in 0..self.states() {
            let at = column * j.rows;
            let [on_seat, on_grip] = [seat, grip].map(|row| j.values[at + row]);
            j.values[at + seat] = 0.0;
            j.values[at + self.ground_impulse] += on_seat + on_grip;
            j.values[at + grip] = on_seat * wood.velocity[0] + on_grip * wood.velocity[1];
        }
        let forces = [driven.body, self.grip()].map(|place| w.force[place]);
        let power = forces[0] * wood.acceleration[0] + forces[1] * wood.acceleration[1];
        j.add(driven.work, 2 * driven.body, power);
    }

    fn scatter(&self, mode: &Mode, element: &Element, j: &mut Jacobian) {
        let (pair, ground) = (element.pair, self.ground());
        for target in targets(self, mode, pair) {
            let [by_travel, by_speed] = element.force.slope.map(|slope| slope * target.factor);
            j.add_pair(target.row, pair, by_travel, by_speed, ground);
        }
        if let Some((row, power)) = element.power {
            j.add_pair(row, pair, power.slope[0], power.slope[1], ground);
        }
    }
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use std::collections::BTreeMap;
    use std::path::Path;

    use nailnoise_documents::Document;

    use super::*;
    use crate::WoodMotion;
    use crate::coupling::Step;
    use crate::network::assembly::Polytropic;
    use crate::network::drive::Drive;
    use crate::network::equations::Equations;
    use crate::network::mode::head;
    use crate::network::{Assembly, AssemblyText, KeyValue};

    /// A plan with one block of each kind and law.
    fn everything() -> Assembly {
        let document = Document::new(
            Path::new("everything.toml"),
            include_str!("../../tests/network/everything.toml"),
        );
        let text = AssemblyText::open(&document).unwrap_or_else(|error| panic!("{error}; {}", error.help()));
        let keys: BTreeMap<String, KeyValue> = BTreeMap::new();
        let resolved = text
            .resolve(&keys)
            .unwrap_or_else(|error| panic!("{error}; {}", error.help()));
        let mut assembly = resolved.assembly;
        assembly.ledger = crate::network::assembly::Ledger::Full;
        assembly
    }

    /// A state and a mode where every block acts.
    fn acting(plan: &Plan) -> (Vec<f64>, Mode) {
        let origin = plan.start().unwrap();
        let mut mode = origin.mode;
        for contact in plan.contacts.iter().filter(|contact| !contact.carries) {
            mode.switches[contact.switch] = 1;
        }
        for gate in plan.passages.iter().filter_map(|passage| passage.gate) {
            mode.switches[gate] = 1;
        }
        for fastener in &plan.fasteners {
            mode.switches[fastener.head] = head::ATTACHED;
            mode.switches[fastener.depth] = crate::network::mode::depth::LOADING;
            mode.memory[fastener.impact_speed] = 20.0;
        }
        (origin.y, mode)
    }

    #[test]
    fn every_kind_of_block_has_the_derivatives_of_differences() {
        let plan = Plan::new(&everything()).unwrap();
        let (y, mode) = acting(&plan);
        assert_differences(&plan, &y, &mode);
    }

    #[test]
    fn a_polytropic_gas_has_the_derivatives_of_differences() {
        let mut assembly = everything();
        assembly.polytropic = Some(Polytropic {
            exponent: 1.3,
            inflow: 1.2,
            temperature: 290.0,
        });
        let plan = Plan::new(&assembly).unwrap();
        let (y, mode) = acting(&plan);
        assert_differences(&plan, &y, &mode);
    }

    #[test]
    fn a_sunk_head_has_the_derivatives_of_differences() {
        let mut assembly = everything();
        for fastener in &mut assembly.fasteners {
            fastener.length = 5e-3;
        }
        let plan = Plan::new(&assembly).unwrap();
        let (y, mut mode) = acting(&plan);
        for fastener in &plan.fasteners {
            mode.switches[fastener.depth] = crate::network::mode::depth::SEATED;
        }
        assert_differences(&plan, &y, &mode);
    }

    #[test]
    fn a_driven_body_has_the_derivatives_of_differences_over_its_clock() {
        let assembly = everything();
        let body = assembly.bodies.iter().position(|body| body.name == "work").unwrap();
        let (plan, driven) = Plan::driven(&assembly, body).unwrap();
        let (mut y, mut mode) = acting(&plan);
        let at = y[2 * body];
        let motion = |position: f64, velocity: f64| WoodMotion {
            seat: [at + position, velocity],
            nail: [at + 1.5 * position, -velocity],
            support: 0.0,
        };
        let step = Step {
            start: motion(1e-5, 2.0),
            end: motion(2e-4, 3.0),
            free: motion(1e-4, 2.0),
            to: 1e-4,
        };
        mode.wood = Some(Drive::new(&step, 1e-4));
        plan.start_clock(&driven, &mut y);
        y[2 * body] = 4e-5;
        assert_differences(&plan, &y, &mode);
    }

    fn assert_differences(plan: &Plan, origin: &[f64], mode: &Mode) {
        let (n, size) = (plan.states(), plan.size());
        let (mut w, mut j) = (Workspace::new(plan), Jacobian::new(plan));
        let t = 7e-3;
        plan.jacobian(t, origin, mode, &mut w, &mut j);
        let mut rates = |y: &[f64]| {
            let mut rate = vec![0.0; size];
            plan.rates(t, y, mode, &mut w, &mut rate);
            rate
        };
        for column in 0..n {
            let x = origin[column];
            let step = if column < plan.energy() { 1e-7 } else { 1e-6 * x };
            let mut y = origin.to_vec();
            y[column] = x + step;
            let ahead = rates(&y);
            y[column] = x - step;
            let behind = rates(&y);
            for row in 0..size {
                let difference = (ahead[row] - behind[row]) / (2.0 * step);
                let found = j.values()[column * size + row];
                let rounding = 1e-15 * (ahead[row].abs() + 1e3) / step;
                let error = (found - difference).abs();
                assert!(
                    error <= 2e-4 * difference.abs() + 10.0 * rounding,
                    "row {row} by {column}: {found} instead of {difference}"
                );
            }
        }
    }

    #[test]
    fn the_estimate_of_the_spectral_radius_is_the_largest_eigenvalue() {
        let assembly = everything();
        let plan = Plan::new(&assembly).unwrap();
        let (y, mode) = acting(&plan);
        let (states, size) = (plan.states(), plan.size());
        let scale = crate::network::tolerances::tolerances(&plan, 1e-7);
        let equations = Equations::new(&plan, mode.clone(), Workspace::new(&plan).past);
        equations.linearise(0.0, &y);
        let estimate = equations.spectral_radius(&scale);
        let mut jacobian = Jacobian::new(&plan);
        plan.jacobian(0.0, &y, &mode, &mut Workspace::new(&plan), &mut jacobian);
        let entry = |i, j| jacobian.values()[j * size + i] * scale[j] / scale[i];
        let matrix = nalgebra::DMatrix::from_fn(states, states, entry);
        let eigenvalues = matrix.complex_eigenvalues();
        let largest = eigenvalues.iter().map(|value| value.norm()).fold(0.0, f64::max);
        assert!((estimate / largest - 1.0).abs() < 0.2, "{estimate:e} {largest:e} 1/s");
    }
}
