//! Radiation and microphones in the full chain.

use std::path::{Path, PathBuf};
use std::sync::{Arc, LazyLock};

use crate::common::{design, folder, run as of, run_with_chain, small, store};
use nailnoise::Design;
use nailnoise::output::{outdated_fields, write_sound_fields};
use nailnoise::result::{BodyEfficiencies, RadiationReport, RankedSource, ReceivedSource};
use nailnoise::run::Run;
use nailnoise::stages::sound_fields::Fields;

fn workpiece(run: &Run) -> &RankedSource {
    run.result.ranking.iter().find(|s| s.source == "workpiece").unwrap()
}

static BLOCK_ON_TABLE: LazyLock<Run> = LazyLock::new(|| of(&design("tests/data/small-bem.toml")));

fn radiation(run: &Run) -> &RadiationReport {
    workpiece(run).radiation.as_ref().unwrap()
}

/// Asserts that the surface and the far field give the same power.
fn is_evaluated_twice(run: &Run, within_db: f64) {
    assert_eq!(workpiece(run).method, "BEM");
    assert!(radiation(run).surface_difference_db.unwrap().abs() < within_db);
    let named = "workpiece: power by the surface less that by the far field [dB]";
    assert!(run.result.checks.iter().any(|check| check.name == named && check.ok));
}

fn mode_shares_sum_to_one(run: &Run) {
    let shares: f64 = radiation(run).modes.iter().map(|mode| mode.share).sum();
    assert!((shares - 1.0).abs() < 1e-9, "{shares}");
}

/// Level of radiation efficiency 1 less the level at 100 Hz \[dB\].
fn deficit_at_100_hz(run: &Run) -> f64 {
    let low = radiation(run).bands.iter().find(|band| band.hz == 100.0).unwrap();
    low.erp_lw_db.unwrap() - low.lw_db.unwrap()
}

#[test]
fn block_and_table_radiate_as_one_surface_with_the_same_power_on_it_and_far_away() {
    is_evaluated_twice(&BLOCK_ON_TABLE, 0.1);
    assert!(BLOCK_ON_TABLE.result.checks.iter().all(|check| check.ok));
}

#[test]
fn modes_and_patches_sum_to_the_source() {
    mode_shares_sum_to_one(&BLOCK_ON_TABLE);
    let source = workpiece(&BLOCK_ON_TABLE);
    let energy = |db: Option<f64>| db.map_or(0.0, |db| 10f64.powf(0.1 * db));
    let parts: f64 = source.components.iter().map(|part| energy(part.lw_db)).sum();
    assert!((parts / energy(source.lw_db) - 1.0).abs() < 1e-6);
}

#[test]
fn a_body_smaller_than_the_wavelength_radiates_less_than_with_radiation_efficiency_1() {
    let deficit = deficit_at_100_hz(&BLOCK_ON_TABLE);
    assert!(deficit > 6.0, "{deficit} dB");
}

fn efficiencies<'a>(run: &'a Run, body: &str) -> &'a BodyEfficiencies {
    let bodies = &run.result.radiation_efficiencies;
    bodies.iter().find(|own| own.body == body).unwrap()
}

#[test]
fn each_mode_of_block_and_table_has_the_efficiency_of_its_natural_frequency() {
    for body in ["workpiece", "worktable"] {
        let own = efficiencies(&BLOCK_ON_TABLE, body);
        assert!(own.method.starts_with("boundary elements, above "), "{own:?}");
        let shares = radiation(&BLOCK_ON_TABLE).modes.iter();
        let shares: Vec<_> = shares
            .filter(|share| share.body == body && share.mode.is_some())
            .collect();
        assert_eq!(own.modes.len(), shares.len());
        for (mode, share) in own.modes.iter().zip(shares) {
            assert_eq!(Some(mode.mode), share.mode);
            assert!((mode.hz - share.hz.unwrap()).abs() < 1e-9 * mode.hz.max(1.0));
            // A mode without a natural frequency has no efficiency; all others radiate.
            assert_eq!(mode.efficiency_db.is_some(), mode.hz > 1.0, "{mode:?}");
        }
    }
}

/// The first modes of the table bend its top, which is smaller than the waves in air. No mode exceeds the peak of a
/// panel's efficiency at coincidence, 2.2 for modes with five half-waves (Wallace 1972), by more than 1 dB.
#[test]
fn slow_modes_of_the_table_radiate_little_and_fast_ones_about_as_much_as_with_radiation_efficiency_1() {
    let modes = &efficiencies(&BLOCK_ON_TABLE, "worktable").modes;
    let known = modes.iter().filter_map(|mode| Some((mode.hz, mode.efficiency_db?)));
    let known: Vec<(f64, f64)> = known.collect();
    println!("{known:?}");
    let mean = |low: f64, high: f64| {
        let inside: Vec<f64> = known
            .iter()
            .filter(|(hz, _)| (low..high).contains(hz))
            .map(|(_, db)| *db)
            .collect();
        assert!(!inside.is_empty(), "no mode from {low} to {high} Hz");
        inside.iter().sum::<f64>() / inside.len() as f64
    };
    // Both are in the range of boundary elements or of the change to their limit.
    let [slow, fast] = [mean(1.0, 150.0), mean(500.0, 650.0)];
    assert!(slow < -6.0 && fast.abs() < 3.0, "{slow} dB, {fast} dB");
    assert!(known.iter().all(|(_, db)| *db < 10.0 * 2.2f64.log10() + 1.0));
}

#[test]
fn microphones_receive_block_and_table_by_boundary_elements() {
    let received = as_radiated(&BLOCK_ON_TABLE, "workpiece", 3.0);
    assert_eq!(received.how, "boundary elements");
}

#[test]
fn another_run_with_cached_matrices_has_the_same_bits() {
    let (first, again) = (&*BLOCK_ON_TABLE, of(&design("tests/data/small-bem.toml")));
    assert_eq!(workpiece(&again).lwa_db, workpiece(first).lwa_db);
    assert_eq!(again.microphones.signals, first.microphones.signals);
}

/// The design of block and table with other keys.
fn without_table(text: &str) -> Design {
    let beside = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/data/over.toml");
    Design::parse(&format!("base = \"small-bem.toml\"\n{text}\n"), beside).unwrap()
}

/// Blocks without a table, each with the words of its note: on the floor, clamped, hung low, hung high.
static WITHOUT_TABLE: LazyLock<[(&str, Run); 4]> = LazyLock::new(|| {
    let springs: String = ["a", "b"]
        .map(|name| {
            let x = if name == "a" { -0.15 } else { 0.15 };
            format!(
                "[springs.{name}]\nbody = \"workpiece\"\nx = {x}\ny = 0\nz = 0\nradius = 0.02\nstiffness_x = 0\n\
                 stiffness_y = 0\nstiffness_z = 1250\ndamping_x = 0\ndamping_y = 0\ndamping_z = 40\n"
            )
        })
        .concat();
    let hung = |clearance: f64| format!("support.kind = \"springs\"\nsupport.clearance = {clearance}\n{springs}");
    [
        ("on a rigid floor", "support.kind = \"floor\"".to_owned()),
        ("held on a rigid floor", "support.kind = \"clamped\"".to_owned()),
        ("0.300 m above the floor", hung(0.3)),
        ("1.500 m above the floor, which is left out of its power", hung(1.5)),
    ]
    .map(|(note, text)| (note, of(&without_table(&text))))
});

#[test]
fn without_a_table_surface_and_far_field_give_the_same_power() {
    for (_, run) in &*WITHOUT_TABLE {
        is_evaluated_twice(run, 0.1);
        mode_shares_sum_to_one(run);
    }
}

#[test]
fn without_a_table_a_note_names_the_place_of_the_block() {
    for (place, run) in &*WITHOUT_TABLE {
        let notes = &run.result.method_notes;
        assert!(
            notes
                .iter()
                .any(|note| note.contains(place) && note.contains("boundary elements")),
            "{notes:?}"
        );
    }
}

#[test]
fn without_a_table_low_frequencies_radiate_less_than_with_radiation_efficiency_1() {
    for (place, run) in &*WITHOUT_TABLE {
        let deficit = deficit_at_100_hz(run);
        assert!(deficit > 10.0, "{place}: {deficit} dB");
    }
}

#[test]
fn without_a_table_microphones_receive_the_block_by_boundary_elements() {
    for (_, run) in &*WITHOUT_TABLE {
        assert_eq!(as_radiated(run, "workpiece", 4.0).how, "boundary elements");
    }
}

#[test]
fn top_and_underside_of_a_hung_block_short_circuit_each_other() {
    let [floor, _, low, high] = WITHOUT_TABLE.each_ref().map(|(_, run)| deficit_at_100_hz(run));
    assert!(low > floor + 10.0 && high > floor + 10.0, "{floor} {low} {high}");
}

#[test]
fn surface_and_far_field_of_the_rigid_tool_give_the_same_power_in_each_band() {
    for (_, run) in &*WITHOUT_TABLE {
        let body = run.result.ranking.iter().find(|s| s.source == "body").unwrap();
        let report = body.radiation.as_ref().unwrap();
        assert!(report.surface_difference_db.unwrap().abs() < 1e-5);
        for band in &report.bands {
            assert!(
                (band.lw_db.unwrap() - band.surface_lw_db.unwrap()).abs() < 1e-5,
                "{band:?}"
            );
            assert!(band.erp_lw_db.unwrap() > band.lw_db.unwrap() - 2.0, "{band:?}");
        }
    }
}

#[test]
fn with_radiation_efficiency_1_a_note_states_that_there_is_no_second_evaluation() {
    let estimate = of(&without_table("support.kind = \"floor\"\nacoustics.method = \"erp\""));
    assert!(workpiece(&estimate).radiation.is_none());
    let notes = &estimate.result.notes;
    assert!(
        notes.iter().any(|note| note.contains("no second evaluation")),
        "{notes:?}"
    );
}

/// Asserts that nine microphones measure the power of a source within the uncertainty of so few directions, and that
/// its signals have the exposures of its levels.
fn as_radiated<'a>(run: &'a Run, source: &str, within_db: f64) -> &'a ReceivedSource {
    let report = &run.microphones.report;
    let received = report.sources.iter().find(|s| s.source == source).unwrap();
    let bias = received.lwa_db.unwrap() - received.true_lwa_db.unwrap();
    assert!(bias.abs() < within_db, "{source}: {bias} dB");
    let (_, signals) = run.microphones.signals.iter().find(|(name, _)| name == source).unwrap();
    assert_eq!((received.levels.len(), signals.len()), (9, 9));
    for (level, signal) in received.levels.iter().zip(signals) {
        let peak = signal.iter().fold(0.0f64, |peak, p| peak.max(p.abs()));
        assert!(peak > 0.0 && peak <= level.peak_pa && peak < report.full_scale_pa);
        let exposure: f64 = signal.iter().map(|p| p * p).sum::<f64>() / 48_000.0;
        let found = 10.0 * (exposure / 4e-10).log10();
        let expected = level.le_db.unwrap();
        assert!((found - expected).abs() < 0.05, "{source}: {found} {expected}");
    }
    received
}

static FREE_FIELD: LazyLock<Run> = LazyLock::new(|| of(&small("")));

/// The small design with other keys of the room.
fn in_room(text: &str) -> Run {
    of(&small(&format!("[acoustics]\n{text}")))
}

#[test]
fn the_measurement_surface_has_the_area_of_its_box() {
    let report = &FREE_FIELD.microphones.report;
    let [a, b, c] = report.box_m;
    assert!((report.area_m2 - 4.0 * (a * b + b * c + c * a)).abs() < 1e-12);
}

#[test]
fn microphones_receive_every_source() {
    for source in ["workpiece", "exhaust", "body"] {
        as_radiated(&FREE_FIELD, source, 2.0);
    }
}

#[test]
fn the_measured_total_is_the_sum_of_the_sources_without_corrections_in_a_free_field() {
    let report = &FREE_FIELD.microphones.report;
    let total = &report.total;
    assert_eq!((total.k1_db, total.k2_db), (Some(0.0), 0.0));
    let sum: f64 = report.sources.iter().map(|s| 10f64.powf(0.1 * s.lwa_db.unwrap())).sum();
    assert!((total.lwa_db.unwrap() - 10.0 * sum.log10()).abs() < 1e-9);
}

#[test]
fn k2_corrects_the_reverberation_of_the_room() {
    // A room of A = 4 S raises the mean level by 3 dB where array and power agree.
    let total = &FREE_FIELD.microphones.report.total;
    let area = FREE_FIELD.microphones.report.area_m2;
    let room = in_room(&format!("room_absorption = \"{} m2\"", 4.0 * area));
    let found = &room.microphones.report.total;
    let (level, bias) = (
        total.lwa_db.unwrap(),
        total.lwa_db.unwrap() - total.true_lwa_db.unwrap(),
    );
    assert!((found.k2_db - 10.0 * 2f64.log10()).abs() < 1e-9);
    assert!((found.lwa_db.unwrap() - level).abs() <= bias.abs() && found.lpa_db > total.lpa_db);
}

#[test]
fn k1_corrects_a_background_10_db_below_the_tool() {
    let total = &FREE_FIELD.microphones.report.total;
    let quiet = in_room(&format!("background_level = {}", total.lpa_db.unwrap() - 10.0));
    let quiet = &quiet.microphones.report.total;
    assert!((quiet.k1_db.unwrap() - 0.414).abs() < 1e-3);
    assert!((quiet.lwa_db.unwrap() - total.lwa_db.unwrap()).abs() < 1e-9);
}

#[test]
fn a_background_as_loud_as_the_tool_invalidates_the_measurement() {
    let level = FREE_FIELD.microphones.report.total.lpa_db.unwrap();
    let loud = in_room(&format!("background_level = {level}"));
    let loud = &loud.microphones.report.total;
    assert_eq!((loud.k1_db, loud.lwa_db), (None, None));
}

/// A workpiece in sand up to 400 Hz, with its sound fields.
static IN_SAND: LazyLock<(Run, Arc<Fields>)> = LazyLock::new(|| {
    let design = small(
        "[support]\nkind = \"sandbox\"\n[analysis]\nrange_high = \"400 Hz\"\nworkpiece_max_frequency = \"1 kHz\"",
    );
    let (run, chain) = run_with_chain(&design, store());
    let fields = chain.fields.get().unwrap();
    (run, fields)
});

#[test]
fn in_sand_surface_and_far_field_give_the_same_power() {
    let (run, _) = &*IN_SAND;
    let difference = radiation(run).surface_difference_db;
    assert!(difference.unwrap().abs() < 1e-3, "{difference:?}");
    let named = "workpiece: power by the surface less that by the far field [dB]";
    assert!(run.result.checks.iter().any(|check| check.name == named && check.ok));
    for band in radiation(run).bands.iter().filter(|band| band.hz < 400.0) {
        assert!(
            (band.surface_lw_db.unwrap() - band.lw_db.unwrap()).abs() < 1e-2,
            "{band:?}"
        );
    }
}

#[test]
fn in_sand_a_block_smaller_than_the_wavelength_radiates_less_than_its_top_with_radiation_efficiency_1() {
    for band in radiation(&IN_SAND.0).bands.iter().filter(|band| band.hz < 400.0) {
        assert!(band.erp_lw_db.unwrap() > band.lw_db.unwrap(), "{band:?}");
    }
}

#[test]
fn in_sand_the_shares_of_the_modes_sum_to_one() {
    mode_shares_sum_to_one(&IN_SAND.0);
}

#[test]
fn sound_fields_pass_their_checks() {
    let checks = &IN_SAND.1.checks;
    assert!(!checks.is_empty() && checks.iter().all(|check| check.ok), "{checks:?}");
}

#[test]
fn sound_fields_have_planes_a_sphere_and_a_surface_in_each_band() {
    let found = &IN_SAND.1;
    let names: Vec<&str> = found.series.iter().map(|series| series.name.as_str()).collect();
    let expected = [
        "sound-plane-xz",
        "sound-plane-yz",
        "sound-plane-xy",
        "sound-sphere",
        "velocity-workpiece",
    ];
    assert_eq!(names, expected);
    // From 63 Hz, the first complete band, to 315 Hz.
    for series in &found.series {
        let bands: Vec<f64> = series.bands.iter().map(|band| band.hz).collect();
        assert_eq!(
            bands,
            [63.0, 80.0, 100.0, 125.0, 160.0, 200.0, 250.0, 315.0],
            "{}",
            series.name
        );
    }
}

#[test]
fn files_of_sound_fields_are_outdated_for_another_design_only() {
    let folder = folder("pictures");
    write_sound_fields(&folder, "this", &IN_SAND.1).unwrap();
    let list = std::fs::read_to_string(folder.join("fields/sound-sphere.pvd")).unwrap();
    assert!(
        list.contains("timestep=\"63\"") && list.contains("sound-sphere/00315.vtu"),
        "{list}"
    );
    assert!(outdated_fields(&folder, "this", false).is_empty());
    let mut outdated = outdated_fields(&folder, "another", false);
    outdated.sort();
    let mut files: Vec<PathBuf> = std::fs::read_dir(folder.join("fields"))
        .unwrap()
        .map(|entry| Path::new("fields").join(entry.unwrap().file_name()))
        .collect();
    files.sort();
    assert_eq!(outdated, files);
}

#[test]
fn an_index_of_sound_fields_names_no_file_elsewhere() {
    let folder = folder("pictures-index");
    std::fs::create_dir(folder.join("fields")).unwrap();
    let index = r#"{"design": "this", "method": "", "notes": [], "series": ["..", "../../other", "/", "plane"]}"#;
    std::fs::write(folder.join("fields/sound.json"), index).unwrap();
    let outdated = outdated_fields(&folder, "another", false);
    assert_eq!(
        outdated,
        ["fields/plane.pvd", "fields/plane", "fields/sound.json"].map(PathBuf::from)
    );
}

/// A run with radiation efficiency 1, with its fields.
static EFFICIENCY_1: LazyLock<(Run, Arc<Fields>)> = LazyLock::new(|| {
    let design = small("[acoustics]\nmethod = \"erp\"\n[analysis]\nrange_high = \"400 Hz\"");
    let (run, chain) = run_with_chain(&design, store());
    let fields = chain.fields.get().unwrap();
    (run, fields)
});

#[test]
fn with_radiation_efficiency_1_fields_show_velocities_only_and_a_note_states_why() {
    let found = EFFICIENCY_1.1.as_ref();
    assert!(
        found.checks.is_empty() && found.notes[0].contains("no pressure"),
        "{:?}",
        found.notes
    );
    let names: Vec<&str> = found.series.iter().map(|series| series.name.as_str()).collect();
    assert_eq!(names, ["velocity-workpiece", "velocity-worktable"]);
}

#[test]
fn with_radiation_efficiency_1_no_mode_has_an_efficiency_of_its_own() {
    let bodies = &EFFICIENCY_1.0.result.radiation_efficiencies;
    assert_eq!(bodies.len(), 2);
    for own in bodies {
        assert!(
            own.modes.is_empty() && own.method.starts_with("not computed: "),
            "{own:?}"
        );
    }
}

#[test]
fn with_radiation_efficiency_1_all_faces_radiate_slightly_more_than_the_run() {
    // The run leaves out the faces between the bodies.
    let (run, found) = &*EFFICIENCY_1;
    let bands = &workpiece(run).bands;
    for (number, band) in found.series[0].bands.iter().enumerate() {
        let mut energy = 0.0;
        for series in &found.series {
            let shape = &series.shapes[0];
            let (_, values) = &series.bands[number].polygons[1];
            for (corners, value) in shape.polygons.iter().zip(values) {
                energy += value * area(corners.iter().map(|&corner| shape.points[corner]).collect());
            }
        }
        let level = 10.0 * (energy / 1e-12).log10();
        let of_run = bands.iter().find(|own| own.hz == band.hz).unwrap().lw_db.unwrap();
        assert!(
            (0.0..6.0).contains(&(level - of_run)),
            "{} Hz: {level} {of_run}",
            band.hz
        );
    }
}

/// Area of a plane polygon.
fn area(corners: Vec<[f64; 3]>) -> f64 {
    let corners: Vec<nalgebra::Vector3<f64>> = corners.into_iter().map(Into::into).collect();
    let triangle = |k: usize| (corners[k] - corners[0]).cross(&(corners[k + 1] - corners[0]));
    0.5 * (1..corners.len() - 1)
        .map(triangle)
        .sum::<nalgebra::Vector3<f64>>()
        .norm()
}
