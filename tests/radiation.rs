//! Boundary elements in the whole chain: block and table above the floor.
#![allow(clippy::unwrap_used)]

use nailnoise::Design;
use nailnoise::cache::{Cache, LIMIT};
use nailnoise::pipeline::{Options, Run, Silent, run};
use nailnoise::result::RankedSource;

fn of(design: &Design) -> Run {
    let cache = Cache::at(concat!(env!("CARGO_TARGET_TMPDIR"), "/modes").into(), LIMIT);
    run(design, Options::default(), &cache, &mut Silent).unwrap()
}

fn workpiece(run: &Run) -> &RankedSource {
    run.result.ranking.iter().find(|s| s.source == "workpiece").unwrap()
}

#[test]
fn block_and_table_radiate_as_one_surface() {
    let design = Design::load(concat!(env!("CARGO_MANIFEST_DIR"), "/tests/data/small-bem.toml")).unwrap();
    let first = of(&design);
    let source = workpiece(&first);
    let report = source.radiation.as_ref().unwrap();
    assert_eq!(source.method, "BEM");
    assert!(first.result.checks.iter().all(|check| check.ok));
    // Two evaluations of the power.
    assert!(report.surface_difference_db.unwrap().abs() < 0.1);
    // Modes and patches sum to the source.
    let shares: f64 = report.modes.iter().map(|mode| mode.share).sum();
    assert!((shares - 1.0).abs() < 1e-9, "{shares}");
    let energy = |db: Option<f64>| db.map_or(0.0, |db| 10f64.powf(0.1 * db));
    let parts: f64 = source.components.iter().map(|part| energy(part.lw_db)).sum();
    assert!((parts / energy(source.lw_db) - 1.0).abs() < 1e-6);
    // A body much smaller than the wave radiates far less than with radiation efficiency 1.
    let low = report.bands.iter().find(|band| band.hz == 100.0).unwrap();
    assert!(low.lw_db.unwrap() < low.erp_lw_db.unwrap() - 6.0, "{low:?}");

    // What nine microphones measure is the power, to the decibels that so few directions leave open.
    let microphones = first.microphones.as_ref().unwrap();
    let heard = &microphones.report;
    assert_eq!((heard.positions.len(), microphones.signals.len()), (9, 9));
    let [a, b, c] = heard.box_m;
    assert!((heard.area_m2 - 4.0 * (a * b + b * c + c * a)).abs() < 1e-12);
    let bias = heard.lwa_db.unwrap() - heard.true_lwa_db.unwrap();
    assert!(bias.abs() < 3.0, "{bias} dB");
    for (position, signal) in heard.positions.iter().zip(&microphones.signals) {
        let peak = signal.iter().fold(0.0f64, |peak, p| peak.max(p.abs()));
        assert!(peak > 0.0 && peak <= position.peak_pa && position.peak_pa < heard.full_scale_pa);
    }

    // Another shot on the same structure takes the matrices from the cache; what they give is the same to the bit.
    let again = of(&design);
    assert_eq!(workpiece(&again).lwa_db, source.lwa_db);
    assert_eq!(again.microphones.unwrap().signals, microphones.signals);
}
