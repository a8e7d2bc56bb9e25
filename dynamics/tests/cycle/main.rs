//! Tests of the nailing cycle, one file for each module of the crate or each kind of evidence.
#![allow(clippy::unwrap_used)]

mod base_design;
mod closed_forms;
#[path = "../common/mod.rs"]
mod common;
mod coupled;
mod energy;
mod laws;
mod log;
#[path = "../common/mass.rs"]
mod mass;
#[path = "../common/n80cb_assembly.rs"]
mod n80cb_assembly;
mod options;
mod presets;
mod record;
mod reference;
mod reference_agrees;
mod regression;
mod work;

use std::sync::LazyLock;

use nailnoise_dynamics::{CycleRecord, Geometry, Parameters, Settings, simulate};

use common::n80cb;

/// The cycle of the base design, computed once for all tests.
static BASE: LazyLock<CycleRecord> = LazyLock::new(|| run(&n80cb()));

fn run(p: &Parameters) -> CycleRecord {
    simulate(p, &Settings::default()).unwrap()
}

/// Asserts Newton's second law for the four bodies together: at every sample the internal forces cancel.
fn internal_forces_cancel(p: &Parameters, r: &CycleRecord) {
    let masses = [p.head_valve.mass, p.tool.mass, Geometry::new(p).workpiece_mass];
    for i in 0..r.len() {
        let moving = r.history("piston.moving_mass")[i];
        let inertia = moving * r.history("piston.acceleration")[i]
            + masses[0] * r.history("head_valve.acceleration")[i]
            + masses[1] * r.history("tool.acceleration")[i]
            + masses[2] * r.history("workpiece.acceleration")[i];
        let thrust = r.history("thrust.force")[i];
        let weight = (moving + masses.iter().sum::<f64>()) * p.ambient.gravity;
        let outer = r.history("hand.force")[i] + thrust - r.history("support.force")[i] + weight;
        assert!((inertia - outer).abs() < 1e-6, "sample {i}: {inertia} N, {outer} N");
    }
}
