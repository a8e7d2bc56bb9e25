//! Laws of the whole chain: what any design must obey, whatever its levels.
#![allow(clippy::unwrap_used)] // a test may panic, in its helpers too

use nailnoise::Design;
use nailnoise::design::SupportKind;
use nailnoise::pipeline::{Options, Run, Silent, run};
use nailnoise::result::RankedSource;

fn small() -> Design {
    Design::load(concat!(env!("CARGO_MANIFEST_DIR"), "/tests/data/small.toml")).unwrap()
}

/// The block glued into sand: a linear structure.
fn bonded() -> Design {
    let mut design = small();
    design.support.kind = SupportKind::Sandbox;
    design.support.sand.bonded = true;
    design
}

fn ranked(run: &Run, source: &str) -> RankedSource {
    run.result.ranking.iter().find(|s| s.source == source).unwrap().clone()
}

fn scaled(design: &Design, workpiece_force_scale: f64) -> Run {
    run(design, Options { workpiece_force_scale }, &mut Silent).unwrap()
}

#[test]
fn twice_the_force_is_six_decibels_of_the_workpiece_and_of_nothing_else() {
    let design = bonded();
    let (once, twice) = (scaled(&design, 1.0), scaled(&design, 2.0));
    let gain = ranked(&twice, "workpiece").lwa_db.unwrap() - ranked(&once, "workpiece").lwa_db.unwrap();
    assert!((gain - 20.0 * 2f64.log10()).abs() < 1e-6, "{gain}");
    for source in ["exhaust", "body"] {
        assert_eq!(ranked(&twice, source).lwa_db, ranked(&once, source).lwa_db);
    }
}

#[test]
fn a_workpiece_without_forces_is_silent() {
    let run = scaled(&bonded(), 0.0);
    let workpiece = ranked(&run, "workpiece");
    assert_eq!((workpiece.lwa_db, workpiece.lw_db), (None, None));
    assert!(workpiece.bands.iter().all(|band| band.lw_db.is_none()));
    assert!(run.result.total.lwa_db.is_some());
}

#[test]
fn more_damping_raises_no_band_above_the_first_mode() {
    let design = bonded();
    let mut damped = bonded();
    damped.wood.loss_factor *= 2.0;
    let (before, after) = (scaled(&design, 1.0), scaled(&damped, 1.0));
    let first = before
        .structure
        .workpiece
        .basis
        .hz
        .iter()
        .copied()
        .find(|&hz| hz > 1.0)
        .unwrap();
    let (before, after) = (ranked(&before, "workpiece"), ranked(&after, "workpiece"));
    let mut compared = 0;
    for (a, b) in before.bands.iter().zip(&after.bands).filter(|(a, _)| a.hz > first) {
        assert!(
            b.lw_db.unwrap() <= a.lw_db.unwrap() + 1e-9,
            "{} Hz: {:?} {:?}",
            a.hz,
            a.lw_db,
            b.lw_db
        );
        compared += 1;
    }
    assert!(compared > 0);
}

#[test]
fn more_supply_pressure_drives_faster_and_blows_more_air() {
    let design = small();
    let mut raised = small();
    raised.supply.pressure *= 1.1;
    let [before, after] = [&design, &raised].map(|d| nailnoise::pipeline::cycle(d).unwrap());
    let drive = |r: &nailnoise_dynamics::CycleRecord| r.events.t9.unwrap() - r.events.t6.unwrap();
    assert!(drive(&after) < drive(&before));
    assert!(after.summary.exhaust_mass > before.summary.exhaust_mass);
}
