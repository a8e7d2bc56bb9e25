//! The readings of the machine's sensors: white noise, a sample rate, and a cell of second order.

use std::f64::consts::TAU;

use super::driving::Drive;
use super::{Machine, Sensors};

/// Samples before the impact, which show the zero of the cell.
const BEFORE: usize = 50;

/// Readings at equal intervals.
#[derive(Debug, Clone, PartialEq)]
pub struct Readings {
    /// Time from the impact \[s\].
    pub time: Vec<f64>,
    /// Depth by laser \[m\].
    pub depth: Vec<f64>,
    /// Force measured by the cell \[N\].
    pub force: Vec<f64>,
}

/// The readings of a drive that is sampled at the rate of the sensors; `normal` gives independent numbers of N(0, 1).
pub fn read(machine: &Machine, drive: &Drive, normal: &mut impl FnMut() -> f64) -> Readings {
    let sensors = &machine.sensors;
    let interval = 1.0 / sensors.rate;
    let cell = filtered(
        sensors,
        &drive.samples.iter().map(|sample| sample.cell).collect::<Vec<_>>(),
    );
    let mut readings = Readings {
        time: Vec::new(),
        depth: Vec::new(),
        force: Vec::new(),
    };
    let mut push = |time: f64, depth: f64, force: f64| {
        readings.time.push(time);
        readings.depth.push(depth + sensors.depth_noise * normal());
        readings.force.push(force + sensors.force_noise * normal());
    };
    for before in (1..=BEFORE).rev() {
        let time = -(before as f64) * interval;
        push(time, drive.impact_speed * time, 0.0);
    }
    for (sample, cell) in drive.samples.iter().zip(cell) {
        push(sample.time, sample.depth, cell);
    }
    readings
}

/// The response x'' + 2 zeta w x' + w^2 x = w^2 f of the cell to a force that is linear between the samples, to fourth
/// order in the substeps.
fn filtered(sensors: &Sensors, force: &[f64]) -> Vec<f64> {
    if sensors.cell_frequency == 0.0 {
        return force.to_vec();
    }
    let omega = TAU * sensors.cell_frequency;
    let interval = 1.0 / sensors.rate;
    // At least thirty steps per period of the cell.
    let steps = (30.0 * sensors.cell_frequency * interval).ceil().clamp(1.0, 1e4) as usize;
    let h = interval / steps as f64;
    let (mut x, mut v) = (0.0, 0.0);
    let rate = |x: f64, v: f64, f: f64| (v, omega * omega * (f - x) - 2.0 * sensors.cell_damping * omega * v);
    let mut read = Vec::with_capacity(force.len());
    for (k, now) in force.iter().enumerate() {
        if k > 0 {
            let before = force[k - 1];
            let at = |part: f64| before + (now - before) * part;
            for step in 0..steps {
                let [a, b, c] = [0.0, 0.5, 1.0].map(|part| at((step as f64 + part) / steps as f64));
                let k1 = rate(x, v, a);
                let k2 = rate(x + 0.5 * h * k1.0, v + 0.5 * h * k1.1, b);
                let k3 = rate(x + 0.5 * h * k2.0, v + 0.5 * h * k2.1, b);
                let k4 = rate(x + h * k3.0, v + h * k3.1, c);
                x += h / 6.0 * (k1.0 + 2.0 * (k2.0 + k3.0) + k4.0);
                v += h / 6.0 * (k1.1 + 2.0 * (k2.1 + k3.1) + k4.1);
            }
        }
        read.push(x);
    }
    read
}
