//! Boundary elements in the whole chain, block and table above the floor; and what microphones hear of every source.
#![allow(clippy::unwrap_used)]

use nailnoise::Design;
use nailnoise::cache::{Cache, LIMIT};
use nailnoise::pipeline::{Options, Run, Silent, run};
use nailnoise::result::{HeardSource, RankedSource};

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

    let heard = as_radiated(&first, "workpiece", 3.0);
    assert_eq!(heard.how, "boundary elements");

    // Another shot on the same structure takes the matrices from the cache; what they give is the same to the bit.
    let again = of(&design);
    assert_eq!(workpiece(&again).lwa_db, source.lwa_db);
    assert_eq!(again.microphones.signals, first.microphones.signals);
}

/// What nine microphones measure of a source is its power, to the decibels that so few directions leave open; its
/// signals hold the exposures of its levels.
fn as_radiated<'a>(run: &'a Run, source: &str, within_db: f64) -> &'a HeardSource {
    let report = &run.microphones.report;
    let heard = report.sources.iter().find(|s| s.source == source).unwrap();
    let bias = heard.lwa_db.unwrap() - heard.true_lwa_db.unwrap();
    assert!(bias.abs() < within_db, "{source}: {bias} dB");
    let (_, signals) = run.microphones.signals.iter().find(|(name, _)| name == source).unwrap();
    assert_eq!((heard.levels.len(), signals.len()), (9, 9));
    for (level, signal) in heard.levels.iter().zip(signals) {
        let peak = signal.iter().fold(0.0f64, |peak, p| peak.max(p.abs()));
        assert!(peak > 0.0 && peak <= level.peak_pa && peak < report.full_scale_pa);
        // Jets are drawn at random, and reach to 20 kHz where the range of the levels here ends at 2 kHz.
        let exposure: f64 = signal.iter().map(|p| p * p).sum::<f64>() / 48_000.0;
        let found = 10.0 * (exposure / 4e-10).log10();
        let expected = level.le_db.unwrap();
        assert!(
            (-1.0..10.0).contains(&(found - expected)),
            "{source}: {found} {expected}"
        );
    }
    heard
}

#[test]
fn every_source_is_heard_and_a_measurement_is_corrected_for_room_and_background() {
    let small = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/data/small.toml");
    let free = of(&Design::load(small).unwrap());
    let report = &free.microphones.report;
    let [a, b, c] = report.box_m;
    assert!((report.area_m2 - 4.0 * (a * b + b * c + c * a)).abs() < 1e-12);
    for source in ["workpiece", "exhaust", "body"] {
        as_radiated(&free, source, 2.0);
    }
    let total = &report.total;
    assert_eq!((total.k1_db, total.k2_db), (Some(0.0), 0.0));
    let sum: f64 = report.sources.iter().map(|s| 10f64.powf(0.1 * s.lwa_db.unwrap())).sum();
    assert!((total.lwa_db.unwrap() - 10.0 * sum.log10()).abs() < 1e-9);

    // A room of A = 4 S: the mean level rises by 3 dB where array and power agree, and K2 takes as much off.
    let beside = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/data/over.toml");
    let over = |text: &str| {
        let text = format!("base = \"small.toml\"\n[acoustics]\n{text}\n");
        of(&Design::parse(&text, beside).unwrap())
    };
    let room = over(&format!("room_absorption = \"{} m2\"", 4.0 * report.area_m2));
    let in_room = &room.microphones.report.total;
    let (level, bias) = (
        total.lwa_db.unwrap(),
        total.lwa_db.unwrap() - total.true_lwa_db.unwrap(),
    );
    assert!((in_room.k2_db - 10.0 * 2f64.log10()).abs() < 1e-9);
    assert!((in_room.lwa_db.unwrap() - level).abs() <= bias.abs() && in_room.lpa_db > total.lpa_db);
    // A background 10 dB below the tool is corrected for; one as loud as it makes the measurement void.
    let background = |below: f64| over(&format!("background_level = {}", total.lpa_db.unwrap() - below));
    let quiet = background(10.0).microphones.report.total;
    assert!((quiet.k1_db.unwrap() - 0.414).abs() < 1e-3);
    assert!((quiet.lwa_db.unwrap() - level).abs() < 1e-9);
    let loud = background(0.0).microphones.report.total;
    assert_eq!((loud.k1_db, loud.lwa_db), (None, None));
}
