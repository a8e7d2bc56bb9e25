//! Laws of the full chain that apply to every design.

use crate::common::{body, graph, run_with_chain, store};
use nailnoise::Design;
use nailnoise::chain::{self, Options};
use nailnoise::design::{SupportKind, Value};
use nailnoise::result::RankedSource;
use nailnoise::run::{Run, run};
use nailnoise::stages::bodies::BodyKind;
use nailnoise::store::{LIMIT, Store};
use nailnoise_acoustics::Air;
use nailnoise_acoustics::jets::Jet;
use std::f64::consts::{PI, TAU};
use std::sync::LazyLock;

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
    run(
        &graph(store()),
        design,
        Options {
            workpiece_force_scale,
            ..Options::default()
        },
    )
    .unwrap()
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
fn a_workpiece_without_forces_radiates_nothing() {
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
    let block = body(&design, BodyKind::Workpiece, true, store()).body.get().unwrap();
    let first = block.basis.hz.iter().copied().find(|&hz| hz > 1.0).unwrap();
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
    let [before, after] = [&design, &raised].map(|d| chain::cycle(d).unwrap());
    let drive = |r: &nailnoise_dynamics::CycleRecord| r.figures.events.t9.unwrap() - r.figures.events.t6.unwrap();
    assert!(drive(&after) < drive(&before));
    assert!(after.figures.summary.exhaust_mass > before.figures.summary.exhaust_mass);
}

static SMALL_RUN: LazyLock<Run> = LazyLock::new(|| scaled(&small(), 1.0));

fn power(level: Option<f64>) -> f64 {
    level.map_or(0.0, |db| 10f64.powf(db / 10.0))
}

#[test]
fn each_event_begins_an_interval_and_the_last_one_ends_with_the_shot() {
    let occurring = SMALL_RUN
        .result
        .events
        .0
        .iter()
        .filter(|event| event.time.is_some())
        .count();
    for source in &SMALL_RUN.result.ranking {
        let intervals = &source.intervals;
        assert_eq!(intervals.len(), occurring);
        assert!(
            intervals
                .windows(2)
                .all(|pair| pair[0].to == pair[1].from && pair[0].to_s == pair[1].from_s)
        );
        assert_eq!(intervals[0].from, "t0");
        assert_eq!(intervals[occurring - 1].to, "end");
    }
}

#[test]
fn the_intervals_of_every_source_sum_to_it() {
    for source in &SMALL_RUN.result.ranking {
        let sum: f64 = source.intervals.iter().map(|interval| power(interval.lwa_db)).sum();
        // Intervals below the lowest level shown do not contribute.
        assert!((sum / power(source.lwa_db) - 1.0).abs() < 1e-9, "{}", source.source);
    }
}

#[test]
fn the_power_of_every_source_over_time_sums_to_it() {
    for source in &SMALL_RUN.result.ranking {
        let history = SMALL_RUN.powers.iter().find(|power| power.source == source.source);
        let over_time = 10.0 * (history.unwrap().history.total() / 1e-12).log10();
        assert!(
            (over_time - source.lwa_db.unwrap()).abs() < 0.01,
            "{}: {over_time}",
            source.source
        );
    }
}

#[test]
fn the_workpiece_sounds_at_the_end_of_the_drive_and_the_exhaust_in_the_return_stroke() {
    let share = |source: &str, event: &str| {
        let ranked = ranked(&SMALL_RUN, source);
        let interval = ranked.intervals.iter().find(|interval| interval.from == event).unwrap();
        power(interval.lwa_db) / power(ranked.lwa_db)
    };
    assert!(share("exhaust", "t14") > 0.3 && share("workpiece", "t9") > 0.1);
}

#[test]
fn the_exhaust_has_its_uncertainty_and_a_cross_check() {
    let exhaust = ranked(&SMALL_RUN, "exhaust");
    assert_eq!(
        (exhaust.uncertainty_db.minus, exhaust.uncertainty_db.plus),
        (Some(4.0), Some(4.0))
    );
    assert!(exhaust.cross_check.unwrap().other_lw_db.is_some());
}

/// The thrust of the cycle is that of convergent holes; choked jets expand further downstream and have slightly more.
#[test]
fn mass_and_thrust_of_the_jets_are_those_of_the_cycle() {
    let mut design = small();
    design.exhaust.thrust_share = 1.0;
    let record = chain::cycle(&design).unwrap();
    let air = Air::at(design.ambient.temperature, design.ambient.pressure).unwrap();
    let d = design.exhaust.hole_diameter;
    let area = design.exhaust.coefficient(&design.chambers) * f64::from(design.exhaust.holes) * 0.25 * PI * d * d;
    let flow = record.record.opening("exhaust").unwrap();
    let (mut jets, mut cycle) = ([0.0; 2], [0.0; 2]);
    for (i, thrust) in record.history("thrust.force").iter().enumerate() {
        if flow.mass_flow[i] <= 0.0 {
            continue;
        }
        cycle[0] += flow.mass_flow[i];
        cycle[1] += thrust;
        if let Some(jet) = Jet::expand(flow.pressure[i], flow.temperature[i], &air) {
            jets[0] += jet.mass_flow(area);
            jets[1] += jet.mass_flow(area) * jet.velocity;
        }
    }
    let [mass, thrust] = [0, 1].map(|i| jets[i] / cycle[i]);
    assert!((mass - 1.0).abs() < 0.01, "{mass}");
    assert!((0.99..1.06).contains(&thrust), "{thrust}");
}

/// Cached results of one design never reach another: a run with a full cache has the digits of a run without one,
/// whether or not the change affects the bodies.
#[test]
fn a_changed_design_has_the_same_digits_with_and_without_the_cache() {
    let folder = concat!(env!("CARGO_TARGET_TMPDIR"), "/changed");
    let _ = std::fs::remove_dir_all(folder);
    let cache = Store::at(folder.into(), LIMIT);
    let digits = |design: &Design, cache: &Store| digits(&run_with_chain(design, cache.clone()).0);
    let base = small();
    let (first, moved) = digits(&base, &cache);
    let (again, moved_again) = digits(&base, &cache);
    assert_eq!(again, first);
    assert!(moved && !moved_again, "the bodies are computed again");
    type Change = (fn(&mut Design), bool);
    let changes: [Change; 4] = [
        (|d| d.exhaust.pitch *= 2.0, true),
        (|d| d.exhaust.holes += 2, false),
        (|d| d.ambient.temperature += 10.0, false),
        (|d| d.workpiece.length *= 1.01, false),
    ];
    for (number, (change, kept)) in changes.into_iter().enumerate() {
        let mut design = small();
        change(&mut design);
        let (found, moved) = digits(&design, &cache);
        assert_eq!(!moved, kept, "change {number}");
        let (expected, _) = digits(&design, &Store::none());
        assert_ne!(found, first, "change {number} changes nothing");
        assert_eq!(found, expected, "change {number}");
    }
}

/// Every key of exhaust and room, for each kind of muffler: a run that takes the motion of the bodies from the store
/// has every digit of one without a store.
#[test]
fn a_cached_motion_is_reused_for_other_exhausts_and_rooms() {
    let folder = concat!(env!("CARGO_TARGET_TMPDIR"), "/left-out");
    let _ = std::fs::remove_dir_all(folder);
    let cache = || Store::at(folder.into(), LIMIT);
    let mut small = small();
    // The worktable is in the key like everything else; a block on the floor moves in a tenth of the time.
    small.support.kind = SupportKind::Floor;
    // A chamber of 30 mm carries plane waves up to 6.7 kHz.
    small.analysis.exhaust_max_frequency = 6e3;
    let (first, _) = digits(&run_with_chain(&small, cache()).0);
    let (mut tried, mut taken, mut acting) = (0, 0, 0);
    for muffler in ["none", "insertion_loss", "chamber"] {
        let mut base = small.clone();
        base.set(&[("exhaust.muffler.kind", Value::Choice(muffler))]).unwrap();
        for entry in base.entries() {
            let room = ["acoustics.room_absorption", "acoustics.background_level"].contains(&entry.key.as_str());
            let of_muffler = entry.key.starts_with("exhaust.muffler.");
            if !(room || entry.key.starts_with("exhaust.")) || of_muffler != (muffler != "none") {
                continue;
            }
            let other = match entry.value {
                Value::Number(0.0) => Value::Number(0.5),
                Value::Number(number) => Value::Number(number * 0.9),
                Value::Count(count) => Value::Count(count + 1),
                Value::Switch(on) => Value::Switch(!on),
                // Each of the three is one of the bases.
                kind => kind,
            };
            let mut design = base.clone();
            design.set(&[(entry.key.as_str(), other)]).unwrap();
            let (found, moved) = digits(&run_with_chain(&design, cache()).0);
            let (anew, _) = run_with_chain(&design, Store::none());
            assert_eq!(found, digits(&anew).0, "{} with muffler {muffler}", entry.key);
            tried += 1;
            taken += usize::from(!moved);
            acting += usize::from(found["ranking"] != first["ranking"] || found["microphones"] != first["microphones"]);
        }
    }
    // Holes, their diameter and the muffler's flow area reach the bodies, through the cycle.
    assert!(
        tried > 35 && taken > 25 && acting > 15,
        "{tried} tried, {taken} taken, {acting} act"
    );
}

/// A result without its timing, and whether workpiece and support were set in motion for it.
fn digits(run: &Run) -> (serde_json::Value, bool) {
    let mut value = serde_json::to_value(&run.result).unwrap();
    let timing = value["timing"].take();
    (value, timing.get("response of workpiece and support").is_some())
}

/// Levels of the parts of the exhaust.
fn parts(run: &Run) -> Vec<(String, f64)> {
    let of = |part: nailnoise::result::Component| Some((part.name, part.lw_db?));
    ranked(run, "exhaust").components.into_iter().filter_map(of).collect()
}

/// A measured insertion loss is the level without the muffler less that with it. Whatever back pressure the muffler
/// has, every part after it falls by the loss, and by nothing at a loss of zero.
#[test]
fn every_part_behind_a_measured_muffler_falls_by_its_insertion_loss() {
    let mut open = small();
    open.support.kind = SupportKind::Floor;
    let bare = parts(&scaled(&open, 1.0));
    for (flow_area, loss) in [(100.0, 0.0), (1e-4, 0.0), (1e-4, 10.0)] {
        let mut muffled = open.clone();
        muffled.exhaust.muffler.flow_area = flow_area;
        muffled
            .set(&[("exhaust.muffler.kind", Value::Choice("insertion_loss"))])
            .unwrap();
        for entry in open
            .entries()
            .iter()
            .filter(|own| own.key.starts_with("exhaust.muffler.octaves."))
        {
            muffled.set(&[(entry.key.as_str(), Value::Number(loss))]).unwrap();
        }
        let run = scaled(&muffled, 1.0);
        for ((name, before), (_, after)) in bare.iter().zip(parts(&run)) {
            // The vent does not pass the muffler; the time of its noise may change with the return of the piston.
            let (lower, tolerance) = if name == "trigger vent" {
                (0.0, 0.1)
            } else {
                (loss, 1e-6)
            };
            assert!(
                (before - after - lower).abs() < tolerance,
                "{flow_area} m2, {loss} dB, {name}: {before} {after}"
            );
        }
        assert!(run.result.checks.iter().all(|check| check.ok));
        assert!(
            run.result
                .checks
                .iter()
                .any(|check| check.name.starts_with("without the muffler: "))
        );
    }
}

#[test]
fn a_range_beyond_the_usual_bands_has_bands_that_sum_to_its_levels() {
    for (low, high, top) in [(40.0, 2e3, 1e4), (1.0, 2e3, 1e4), (50.0, 3e4, 4e4)] {
        let mut design = small();
        design.support.kind = SupportKind::Floor;
        (
            design.analysis.range_low,
            design.analysis.range_high,
            design.analysis.exhaust_max_frequency,
        ) = (low, high, top);
        let run = scaled(&design, 1.0);
        let sums = run
            .result
            .checks
            .iter()
            .filter(|check| check.name.ends_with("sum to the total"));
        assert!(
            sums.clone().count() >= 6 && sums.clone().all(|check| check.ok),
            "{low} {high}"
        );
        let bands = ranked(&run, "exhaust").bands;
        assert!(
            bands[0].hz <= 1.13 * low && bands[bands.len() - 1].hz >= high / 1.13,
            "{low} {high}"
        );
    }
}

/// Below its modes the block moves as a whole: its motion in bands is that of a sensor on its top.
///
/// int E_kin dt = m/2 int v^2 dt, and the mean of v_n^2 over the surface is v^2 times the share of top and underside.
/// The sensor is where the block, which the nail's force bends a little, moves as its mean.
#[test]
fn the_motion_of_a_rigid_block_in_bands_is_that_of_its_sensor() {
    let mut design = bonded();
    (design.nail.offset_along, design.nail.offset_across) = (0.0, 0.0);
    let sensor = design.sensors.get_mut("block_top").unwrap();
    (sensor.x, sensor.y) = (0.115, 0.0);
    let run = scaled(&design, 1.0);
    let record = run.sensors.iter().find(|own| own.name == "block_top").unwrap();
    // int v^2 dt = 2 int |A/omega|^2 df
    let square = |hz: f64| {
        let omega = TAU * hz;
        let mut sums = [0.0; 2];
        for (sample, a) in record.acceleration.iter().enumerate() {
            let (sine, cosine) = (omega * sample as f64 * record.interval).sin_cos();
            sums[0] += a * cosine * record.interval;
            sums[1] += a * sine * record.interval;
        }
        2.0 * (sums[0] * sums[0] + sums[1] * sums[1]) / (omega * omega)
    };
    let block = &design.workpiece;
    let [length, width, height] = [block.length, block.width, block.thickness];
    let mass = design.wood.density * length * width * height;
    let share = length * width / (length * width + height * (length + width));
    let motion = run.result.motion.iter().find(|own| own.body == "workpiece").unwrap();
    let bands: Vec<_> = motion
        .bands
        .iter()
        .filter(|band| (90.0..170.0).contains(&band.hz))
        .collect();
    assert_eq!(bands.len(), 3);
    for band in bands {
        let [low, high] = [-0.05, 0.05].map(|power| band.hz * 10f64.powf(power));
        let steps = 40;
        let step = (high - low) / f64::from(steps);
        let squares: f64 = (0..steps)
            .map(|k| step * square(low + (f64::from(k) + 0.5) * step))
            .sum();
        let kinetic = band.kinetic_energy_j_s / (0.5 * mass * squares);
        assert!((kinetic - 1.0).abs() < 0.05, "{} Hz: {kinetic}", band.hz);
        let surface = band.rms_velocity_m_s.powi(2) / (2.0 * band.kinetic_energy_j_s * share / mass);
        assert!((surface - 1.0).abs() < 0.01, "{} Hz: {surface}", band.hz);
    }
}
