//! Bookkeeping of the sources: parts that the convention of wrapping moves from one source to another, and parts that
//! stay.

use std::f64::consts::PI;
use std::sync::LazyLock;

use nailnoise::Design;
use nailnoise::chain::{Chain, Options};
use nailnoise::design::{Convention, FittingGas, FittingKind, RadiationMethod, VentSource};
use nailnoise::result::{BandLevel, IntervalLevel, RankedSource};
use nailnoise::run::Run;
use nailnoise_meshes::{FaceGroup, FaceRef, Surface};

use crate::common::{graph, store, try_run};
use crate::tool::{bar, bar_mesh, put};

/// The bar of the tests of the tool by boundary elements; half of the sides of its upper end is the outer side of a
/// cap.
pub(crate) static CAPPED: LazyLock<Design> = LazyLock::new(|| {
    let (mut design, mut mesh) = (bar(1.0), bar_mesh());
    let surface = Surface::of(&mesh);
    let right = |of: &FaceRef| {
        let face = surface.faces.iter().find(|face| face.of == *of).unwrap();
        face.nodes.iter().map(|&node| surface.points[node].y).sum::<f64>() > 0.0
    };
    let seat = mesh.groups.iter_mut().find(|group| group.name == "seat").unwrap();
    let (cap, rest): (Vec<FaceRef>, Vec<FaceRef>) = seat.faces.iter().partition(|face| right(face));
    seat.faces = rest;
    mesh.groups.push(FaceGroup {
        name: "cap_outside".to_owned(),
        faces: cap,
    });
    put(&mut design, &mesh, "capped.msh");
    design.acoustics.body_method = RadiationMethod::Bem;
    design.acoustics.bem_max_frequency = 800.0;
    design
});

fn capped(convention: Convention, vent: VentSource) -> Design {
    let mut design = CAPPED.clone();
    (design.sources.convention, design.sources.trigger_vent) = (convention, vent);
    design
}

fn run(convention: Convention, vent: VentSource) -> Run {
    let design = capped(convention, vent);
    try_run(&design, store()).unwrap().0
}

/// An energy of a band.
type OfBand<'a> = &'a dyn Fn(&BandLevel) -> f64;

static PHYSICAL: LazyLock<Run> = LazyLock::new(|| run(Convention::Physical, VentSource::Body));
static WRAPPING: LazyLock<Run> = LazyLock::new(|| run(Convention::Wrapping, VentSource::Body));

fn energy(level: Option<f64>) -> f64 {
    level.map_or(0.0, |level| 10f64.powf(0.1 * level))
}

/// Energy of a part re 1 pW s: the stated one if negative, else that of its level.
fn stated(level: Option<f64>, joule: Option<f64>) -> f64 {
    joule.map_or_else(|| energy(level), |joule| 1e12 * joule)
}

fn source<'a>(run: &'a Run, name: &str) -> &'a RankedSource {
    run.result.ranking.iter().find(|own| own.source == name).unwrap()
}

#[track_caller]
fn equal(a: f64, b: f64, tolerance: f64, what: &str) {
    assert!(
        (a / b - 1.0).abs() < tolerance,
        "{what}: {a} and {b}, {:e}",
        a / b - 1.0
    );
}

#[test]
fn totals_of_both_conventions_are_equal() {
    let [physical, wrapping] = [&PHYSICAL, &WRAPPING].map(|run| &run.result.total);
    equal(energy(physical.lwa_db), energy(wrapping.lwa_db), 1e-12, "A-weighted");
    equal(energy(physical.lw_db), energy(wrapping.lw_db), 1e-12, "unweighted");
    assert_eq!(
        source(&PHYSICAL, "workpiece").lwa_db,
        source(&WRAPPING, "workpiece").lwa_db
    );
    for name in ["exhaust", "body"] {
        let [before, after] = [&PHYSICAL, &WRAPPING].map(|run| source(run, name).lwa_db.unwrap());
        assert!((before - after).abs() > 1e-3, "{name}: {before} and {after} dB");
    }
    assert!(
        WRAPPING
            .result
            .checks
            .iter()
            .all(|check| !check.name.contains("sum to the total") || check.ok)
    );
}

#[test]
fn sources_of_both_conventions_sum_to_the_same_in_every_band_and_interval() {
    let bands = |run: &Run, of: OfBand<'_>| -> Vec<f64> {
        let number = run.result.ranking[0].bands.len();
        let of_band = |k: usize| run.result.ranking.iter().map(|own| of(&own.bands[k])).sum();
        (0..number).map(of_band).collect()
    };
    let plain = |band: &BandLevel| stated(band.lw_db, band.energies_j.map(|e| e[0]));
    let weighted = |band: &BandLevel| stated(band.lwa_db, band.energies_j.map(|e| e[1]));
    // The weighting is integrated by a rule on the intervals of a grid, which is finer where the grids of two parts are
    // joined.
    let forms: [(OfBand<'_>, f64); 2] = [(&plain, 1e-12), (&weighted, 1e-9)];
    for (of, tolerance) in forms {
        for (k, (a, b)) in bands(&PHYSICAL, of).into_iter().zip(bands(&WRAPPING, of)).enumerate() {
            equal(a, b, tolerance, &format!("band {k}"));
        }
    }
    let intervals = |run: &Run, place: usize| -> Vec<f64> {
        let level = |own: &IntervalLevel| [own.lwa_db, own.lwa_cut_db][place];
        let of = |own: &IntervalLevel| stated(level(own), own.energies_j.map(|e| e[place]));
        let number = run.result.ranking[0].intervals.len();
        let of_interval = |k: usize| run.result.ranking.iter().map(|own| of(&own.intervals[k])).sum();
        (0..number).map(of_interval).collect()
    };
    for place in [0, 1] {
        let pairs = intervals(&PHYSICAL, place).into_iter().zip(intervals(&WRAPPING, place));
        for (k, (a, b)) in pairs.enumerate().filter(|(_, (a, _))| *a > 0.0) {
            equal(a, b, 1e-10, &format!("interval {k}"));
        }
    }
}

#[test]
fn powers_over_time_sum_to_the_same_in_every_cell() {
    let sums = |run: &Run| -> Vec<f64> {
        let cells = run.powers[0].history.power.len();
        let of_cell = |cell: usize| run.powers.iter().map(|own| own.history.power[cell]).sum();
        (0..cells).map(of_cell).collect()
    };
    let (physical, wrapping) = (sums(&PHYSICAL), sums(&WRAPPING));
    let peak = physical.iter().copied().fold(0.0, f64::max);
    assert_eq!(physical.len(), wrapping.len());
    for (a, b) in physical.iter().zip(&wrapping) {
        assert!((a - b).abs() < 1e-12 * peak, "{a} {b}");
    }
}

#[test]
fn microphones_receive_the_same_from_all_sources_together() {
    let [physical, wrapping] = [&PHYSICAL, &WRAPPING].map(|run| &run.microphones);
    for (a, b) in physical.report.total.levels.iter().zip(&wrapping.report.total.levels) {
        equal(energy(a.lae_db), energy(b.lae_db), 1e-11, "exposure");
        equal(a.peak_pa, b.peak_pa, 1e-11, "peak");
    }
    equal(
        energy(physical.report.total.lwa_db),
        energy(wrapping.report.total.lwa_db),
        1e-11,
        "level by the array",
    );
    let total = |run: &Run| {
        run.microphones
            .signals
            .iter()
            .find(|(name, _)| name == "total")
            .unwrap()
            .1
            .clone()
    };
    for (a, b) in total(&PHYSICAL).iter().flatten().zip(total(&WRAPPING).iter().flatten()) {
        assert!((a - b).abs() < 1e-11 * physical.report.full_scale_pa, "{a} {b}");
    }
    // The sources themselves are others.
    let of = |run: &Run| {
        run.microphones
            .signals
            .iter()
            .find(|(name, _)| name == "exhaust")
            .unwrap()
            .1[0]
            .clone()
    };
    assert_ne!(of(&PHYSICAL), of(&WRAPPING));
}

#[test]
fn the_cap_is_a_part_of_the_exhaust_and_the_vent_of_the_source_that_the_design_gives_it_to() {
    let has = |run: &Run, name: &str, part: &str| source(run, name).components.iter().any(|own| own.name == part);
    assert!(has(&PHYSICAL, "exhaust", "trigger vent") && !has(&PHYSICAL, "exhaust", "cap"));
    assert!(has(&WRAPPING, "exhaust", "cap") && !has(&WRAPPING, "exhaust", "trigger vent"));
    assert!(has(&WRAPPING, "body", "trigger vent") && has(&WRAPPING, "body", "cap, counted elsewhere"));
    let switched = run(Convention::Wrapping, VentSource::Exhaust);
    assert!(has(&switched, "exhaust", "trigger vent") && has(&switched, "exhaust", "cap"));
    assert!(!has(&switched, "body", "trigger vent"));
    equal(
        energy(PHYSICAL.result.total.lwa_db),
        energy(switched.result.total.lwa_db),
        1e-12,
        "total",
    );
    assert!(
        WRAPPING
            .result
            .method_notes
            .iter()
            .any(|note| note.contains("selective wrapping"))
    );
}

/// The same tool with a pipe on its exhaust.
fn fitted(convention: Convention) -> Design {
    let mut design = capped(convention, VentSource::Body);
    design.exhaust.fitting.kind = FittingKind::Pipe;
    design
}

static FITTED: LazyLock<[Run; 2]> = LazyLock::new(|| {
    [Convention::Physical, Convention::Wrapping].map(|convention| try_run(&fitted(convention), store()).unwrap().0)
});

#[test]
fn the_wall_of_a_fitting_counts_to_the_body_or_to_the_exhaust_and_the_totals_are_equal() {
    let [physical, wrapping] = &*FITTED;
    let has = |run: &Run, name: &str, part: &str| source(run, name).components.iter().any(|own| own.name == part);
    assert!(has(physical, "body", "fitting") && !has(physical, "exhaust", "cap and fitting"));
    assert!(has(wrapping, "exhaust", "cap and fitting") && has(wrapping, "body", "cap, counted elsewhere"));
    assert!(!has(wrapping, "body", "fitting"));
    let sum = |run: &Run, band: usize| -> f64 {
        let of = |own: &RankedSource| stated(own.bands[band].lw_db, own.bands[band].energies_j.map(|e| e[0]));
        run.result.ranking.iter().map(of).sum()
    };
    for band in 0..physical.result.ranking[0].bands.len() {
        equal(sum(physical, band), sum(wrapping, band), 1e-12, &format!("band {band}"));
    }
    let [a, b] = [physical, wrapping].map(|run| energy(run.result.total.lwa_db));
    equal(a, b, 1e-12, "total");
    let [a, b] = [physical, wrapping].map(|run| energy(run.microphones.report.total.lwa_db));
    equal(a, b, 1e-11, "level by the array");
}

#[test]
fn the_fitting_adds_its_own_energy_to_the_body() {
    let (with, without) = (source(&FITTED[0], "body"), source(&PHYSICAL, "body"));
    let own = with.components.iter().find(|part| part.name == "fitting").unwrap();
    for (with, (without, own)) in with.bands.iter().zip(without.bands.iter().zip(&own.bands)) {
        let [with, without, own] = [with.lw_db, without.lw_db, own.lw_db].map(energy);
        assert!(own > 0.0);
        equal(with, without + own, 1e-9, "band");
    }
}

#[test]
fn without_a_fitting_its_keys_change_nothing() {
    let mut design = capped(Convention::Wrapping, VentSource::Body);
    let pipe = &mut design.exhaust.fitting;
    pipe.length *= 3.0;
    pipe.diameter *= 1.5;
    pipe.wall_thickness *= 2.0;
    pipe.outlet_mach = 0.9;
    pipe.gas = FittingGas::Ambient;
    let other = try_run(&design, store()).unwrap().0;
    let [other, own] = [&other, &*WRAPPING].map(|run| {
        let found = &run.result;
        serde_json::to_string(&(&found.ranking, &found.total, &found.ear, &found.motion, &found.checks)).unwrap()
    });
    assert_eq!(other, own);
}

#[test]
fn a_fitting_across_the_axis_of_a_rigid_tool_is_a_dipole_of_twice_the_mass_that_it_displaces() {
    let mut design = fitted(Convention::Physical);
    design.body.model = nailnoise::design::BodyModel::Rigid;
    let run = try_run(&design, store()).unwrap().0;
    let body = source(&run, "body");
    let own = body.components.iter().find(|part| part.name == "fitting").unwrap();
    let [whole, own] = [body.bands[0].lw_db, own.bands[0].lw_db].map(energy);
    let pipe = &design.exhaust.fitting;
    let displaced = 0.25 * PI * (pipe.diameter + 2.0 * pipe.wall_thickness).powi(2) * pipe.length;
    // The tool is a sphere, whose added mass is half of the mass that it displaces.
    let dipoles = 2.0 * displaced / (1.5 * design.body.volume(design.piston.bore));
    equal(own / (whole - own), dipoles * dipoles, 0.03, "energy at 50 Hz");
}

/// A draw sums the parts of a surface before the motion multiplies them, a run after it: both round in single
/// precision.
#[test]
fn the_levels_of_a_draw_are_those_of_the_run() {
    let same = |own: Option<f64>, run: Option<f64>, what: &str| match (own, run) {
        (Some(own), Some(run)) => assert!((own - run).abs() < 1e-6, "{what}: {own} dB, {run} dB"),
        (own, run) => assert_eq!(own, run, "{what}"),
    };
    let design = capped(Convention::Wrapping, VentSource::Body);
    let chain = Chain::new(&graph(store()), &design, Options::default()).unwrap();
    let levels = chain.levels.get().unwrap();
    for own in &levels.sources {
        let run = source(&WRAPPING, &own.source);
        same(own.lwa_db, run.lwa_db, &own.source);
        for (own_db, run_db) in own.method_db.into_iter().zip(run.uncertainty_db.bounds()) {
            same(own_db, run_db, &format!("method of {}", own.source));
        }
    }
}

#[test]
fn a_body_without_a_named_cap_is_refused_and_a_rigid_one_says_that_the_cap_stays() {
    let mut design = capped(Convention::Wrapping, VentSource::Body);
    put(&mut design, &bar_mesh(), "capless.msh");
    let error = try_run(&design, store()).map(drop).unwrap_err();
    assert_eq!(error.exit_status(), 2);
    let text = format!("{:?}", miette::Report::new(error));
    assert!(text.contains("cap_outside") && text.contains("physical"), "{text}");
    design.sources.convention = Convention::Physical;
    assert!(try_run(&design, store()).is_ok());
    design.sources.convention = Convention::Wrapping;
    design.body.model = nailnoise::design::BodyModel::Rigid;
    let run = try_run(&design, store()).unwrap().0;
    assert!(
        run.result
            .method_notes
            .iter()
            .any(|note| note.contains("the cap stays with the body"))
    );
    assert!(
        source(&run, "body")
            .components
            .iter()
            .any(|part| part.name == "trigger vent")
    );
}

/// The intensity on the cap's faces, in the motion of the full body, is another evaluation of the same part by another
/// matrix. It has in addition the sound that the cap and the rest exchange in the near field, which is small here.
#[test]
fn the_cap_radiates_what_the_intensity_on_its_faces_says() {
    let part = |run: &Run, of: &str, name: &str| {
        let components = &source(run, of).components;
        components.iter().find(|own| own.name == name).unwrap().clone()
    };
    let (by_faces, by_motion) = (
        part(&PHYSICAL, "body", "cap_outside"),
        part(&WRAPPING, "exhaust", "cap"),
    );
    let apart = |a: Option<f64>, b: Option<f64>| (a.unwrap() - b.unwrap()).abs();
    let level = apart(by_faces.lwa_db, by_motion.lwa_db);
    assert!(level < 0.05, "{level} dB");
    for (a, b) in by_faces.bands.iter().zip(&by_motion.bands) {
        let band = apart(a.lw_db, b.lw_db);
        assert!(band < 0.1, "{} Hz: {band} dB", a.hz);
    }
}
