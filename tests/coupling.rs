//! The two-way coupled run: what it must reproduce, keep and say.
#![allow(clippy::unwrap_used)]

use nailnoise::design::{Coupling, Design};
use nailnoise::pipeline::{COUPLED_LOADS, Coupled, couple, cycle_settings, parameters};
use nailnoise_dynamics::{Geometry, Parameters, simulate};
use nailnoise_fem::transient::{ModalBody, Settings, Support, SupportLaw};
use nalgebra::DMatrix;

fn design() -> Design {
    Design::load("designs/n80cb.toml").unwrap()
}

/// The block's vertical motion alone, over a rigid support of the lumped cycle's stiffness and damping.
fn rigid(parameters: &Parameters, points: usize) -> (ModalBody, Vec<Support>) {
    let geometry = Geometry::new(parameters);
    let shape = 1.0 / geometry.workpiece_mass.sqrt();
    let mut loads = DMatrix::from_element(1, COUPLED_LOADS, shape);
    loads[(0, COUPLED_LOADS - 1)] = geometry.workpiece_mass.sqrt() * parameters.ambient.gravity;
    let body = ModalBody {
        name: "workpiece".into(),
        omega: vec![0.0],
        zeta: vec![0.0],
        loads,
        supports: DMatrix::from_element(1, points, shape),
    };
    let support = Support {
        stiffness: parameters.support.stiffness / points as f64,
        damping: geometry.support_damping / points as f64,
        gap: 0.0,
        law: SupportLaw::Unilateral,
    };
    (body, vec![support; points])
}

fn coupled(design: &Design, parameters: &Parameters, points: usize) -> Coupled {
    let (body, supports) = rigid(parameters, points);
    let settings = Settings {
        step: design.analysis.time_step,
        duration: design.analysis.duration,
        ..Settings::default()
    };
    couple(
        parameters,
        design.wood.friction_share,
        &cycle_settings(design),
        &[body],
        &supports,
        &settings,
    )
    .unwrap()
}

#[test]
fn a_rigid_block_on_a_rigid_support_gives_the_lumped_cycle() {
    let design = design();
    assert_eq!(design.support.coupling, Coupling::OneWay, "the default stays as it was");
    let parameters = parameters(&design).unwrap();
    let lumped = simulate(&parameters, &cycle_settings(&design)).unwrap();
    let found = coupled(&design, &parameters, 65);
    let (one, two) = (lumped.events.to_array(), found.record.events.to_array());
    for (k, (one, two)) in one.into_iter().zip(two).enumerate() {
        let (one, two) = (one.unwrap(), two.unwrap());
        assert!((one - two).abs() < 2e-6, "t{k}: {one} {two} s");
    }
    let (a, b) = (&lumped.summary, &found.record.summary);
    for (one, two) in [
        (a.penetration, b.penetration),
        (a.peak_support_force, b.peak_support_force),
        (a.peak_penetration_force, b.peak_penetration_force),
        (a.exhaust_mass, b.exhaust_mass),
    ] {
        assert!((one - two).abs() < 2e-3 * one, "{one} {two}");
    }
    let checks = found
        .record
        .checks
        .iter()
        .map(|check| (check.name.to_owned(), check.ok));
    let checks = checks.chain(found.response.checks.iter().map(|check| (check.name.clone(), check.ok)));
    for (name, ok) in checks.chain(found.checks.iter().map(|check| (check.name.clone(), check.ok))) {
        assert!(ok, "{name}");
    }
}

#[test]
fn forces_on_both_sides_are_the_same_at_every_sample() {
    let design = design();
    let parameters = parameters(&design).unwrap();
    let Coupled { record, response, .. } = coupled(&design, &parameters, 1);
    let mut largest: f64 = 0.0;
    for sample in 0..record.len() {
        let loads = response.loads.column(sample);
        let nail: f64 = loads.rows(0, COUPLED_LOADS - 2).sum();
        let f = &record.forces;
        largest = largest.max(f.penetration[sample]);
        assert!((f.penetration[sample] - nail).abs() < 1e-5, "{sample}");
        let seat = f.nose[sample].max(0.0) + f.guard[sample];
        assert!((seat - loads[COUPLED_LOADS - 2]).abs() < 1e-5, "{sample}");
        assert!(
            (f.support[sample] - response.contact_forces[(0, sample)]).abs() < 1e-6,
            "{sample}"
        );
    }
    assert!(largest > 3000.0);
}

#[test]
fn a_softer_support_takes_the_nail_less_deep() {
    let design = design();
    let stiff = parameters(&design).unwrap();
    let depth = |factor: f64| {
        let mut soft = stiff.clone();
        soft.support.stiffness *= factor;
        coupled(&design, &soft, 1).record.summary.penetration
    };
    assert!(
        depth(1.0) > depth(0.01),
        "a support that yields takes part of the drive"
    );
}
