//! The two-way coupled run: what it must reproduce, keep and say.
#![allow(clippy::unwrap_used)]

use nailnoise::cache::Cache;
use nailnoise::design::{Coupling, Design};
use nailnoise::pipeline::{
    self, COUPLED_LOADS, Coupled, Options, Run, Silent, Vibration, couple, cycle_settings, parameters,
};
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

/// The coarse design of the end-to-end tests with a rigid tool and something changed.
fn small(text: &str) -> Design {
    Design::parse(
        &format!("base = \"small.toml\"\nbody.model = \"rigid\"\n{text}\n"),
        "tests/data/over.toml",
    )
    .unwrap()
}

fn run(text: &str) -> Run {
    pipeline::run(&small(text), Options::default(), &Cache::none(), &mut Silent).unwrap()
}

fn level(run: &Run, source: &str) -> f64 {
    let source = run.result.ranking.iter().find(|ranked| ranked.source == source);
    source.unwrap().lwa_db.unwrap()
}

#[test]
fn every_support_carries_a_coupled_run_that_closes_its_balances() {
    let kinds = [
        "support.kind = \"worktable\"",
        "support.kind = \"sandbox\"\nsupport.sand.side_contact = 0.5\nsupport.sand.added_mass = 0.2",
        "support.kind = \"floor\"",
        "support.kind = \"clamped\"",
    ];
    for kind in kinds {
        let run = run(&format!("{kind}\nsupport.coupling = \"two-way\""));
        // The coarse basis leaves more above its top than a level may lack; all that is kept must close.
        let failed: Vec<_> = run.result.checks.iter().filter(|check| !check.ok).collect();
        let only_missing = failed.iter().all(|check| check.name.contains("last octave"));
        assert!(only_missing, "{kind}: {failed:?}");
        let coupling = run.result.coupling.as_ref().unwrap();
        assert_eq!(coupling.events.len(), 18, "{kind}");
        assert_eq!(coupling.levels.last().unwrap().source, "total");
        assert!(coupling.levels.iter().all(|level| level.one_way_lwa_db.is_some()));
        assert!(coupling.work.mismatch < 1e-3, "{kind}: {:?}", coupling.work);
    }
}

#[test]
fn sand_at_the_sides_holds_the_block_and_sand_under_it_weighs_it_down() {
    let sand = "support.kind = \"sandbox\"\nsupport.sand.bonded = true\n";
    let run =
        |text: &str| pipeline::run_in_full(&small(text), Options::default(), &Cache::none(), &mut Silent).unwrap();
    let (alone, still) = run(sand);
    let (held, between) = run(&format!("{sand}support.sand.side_contact = 0.5"));
    let (heavy, laden) = run(&format!("{sand}support.sand.added_mass = 0.3"));
    let carried = |vibration: &Vibration, cells: std::ops::Range<usize>| -> f64 {
        vibration
            .response
            .contact_forces
            .column(0)
            .rows(cells.start, cells.len())
            .sum()
    };
    let cells = 65;
    let whole = carried(&still, 0..cells);
    assert_eq!(between.response.contact_forces.nrows(), cells + 3 * 40);
    // The sides take a part of the static load off the base.
    let base = carried(&between, 0..cells);
    assert!(base < 0.9 * whole && base > 0.3 * whole, "{base} of {whole} N");
    // Sand under the block adds inertia, not weight.
    assert!((carried(&laden, 0..cells) - whole).abs() < 1e-6 * whole);
    assert!(!still.response.start[0].displacement.is_empty());
    let peak = |run: &Run| {
        run.result
            .sensors
            .iter()
            .find(|s| s.name == "workpiece")
            .map(|s| s.rms_g)
    };
    if let (Some(alone), Some(held)) = (peak(&alone), peak(&held)) {
        assert!(held < alone, "held sides quieten the block: {held} {alone} g");
    }
    assert!(level(&heavy, "exhaust") == level(&alone, "exhaust"));
}

#[test]
fn starts_scatter_and_widen_the_band() {
    let one = run("");
    let many = run("analysis.starts = 3");
    assert!(one.result.starts.is_none());
    let starts = many.result.starts.as_ref().unwrap();
    assert_eq!(starts.lwa_db.len(), 3);
    assert_eq!(starts.lwa_db[0], level(&one, "workpiece"), "the first start is the run");
    assert_eq!(level(&many, "workpiece"), level(&one, "workpiece"));
    assert!(starts.deviation_db > 0.0 && starts.deviation_db < 5.0, "{starts:?}");
    let plus = |run: &Run| {
        let ranked = run.result.ranking.iter().find(|ranked| ranked.source == "workpiece");
        ranked.unwrap().uncertainty_db.plus.unwrap()
    };
    let expected = plus(&one).hypot(2.0 * starts.deviation_db);
    assert!((plus(&many) - expected).abs() < 1e-12);
    // A glued block has nothing to scatter.
    assert!(
        run("analysis.starts = 3\nsupport.contact.bonded = true")
            .result
            .starts
            .is_none()
    );
}
