//! The two-way coupled run: results that it must reproduce, conserve and state.

use std::sync::Arc;

use crate::common::{run_with_chain, try_run};
use nailnoise::design::inputs::cycle::{cycle_settings, parameters};
use nailnoise::design::{Coupling, Design};
use nailnoise::run::Run;
use nailnoise::stages::cycle::{Cycle, Engine};
use nailnoise::stages::response::{COUPLED_LOADS, Coupled, CoupledTool, DrivenFastener, FastenerLaw, couple};
use nailnoise::store::Store;
use nailnoise_dynamics::{Geometry, NailerFigures, Parameters, simulate};
use nailnoise_fem::vibration::{ModalBody, ModalResponse, Motion, Settings, Support, SupportLaw};
use nalgebra::DMatrix;

fn design() -> Design {
    Design::load("designs/n80cb.toml").unwrap()
}

/// Only the block's vertical motion, over a rigid support of the lumped cycle's stiffness and damping.
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
    let cycle = Cycle {
        parameters: parameters.clone(),
        settings: cycle_settings(design),
    };
    let fastener = DrivenFastener {
        law: FastenerLaw::Nail(Box::new(parameters.clone())),
        friction_share: parameters.friction_share,
        blows: Vec::new(),
    };
    let tool = CoupledTool {
        engine: &Engine::Keys(Box::new(cycle)),
        fastener: Some(&fastener),
        gravity: parameters.ambient.gravity,
    };
    couple(tool, &[body], &supports, &settings).unwrap()
}

/// The figures of a coupled shot of the tool of the keys.
fn figures(coupled: &Coupled) -> &NailerFigures {
    coupled.shot.nailer.as_ref().unwrap()
}

#[test]
fn a_rigid_block_on_a_rigid_support_gives_the_lumped_cycle() {
    let design = design();
    assert_eq!(design.support.coupling, Coupling::OneWay, "the default stays as it was");
    let parameters = parameters(&design).unwrap();
    let lumped = simulate(&parameters, &cycle_settings(&design)).unwrap();
    let found = coupled(&design, &parameters, 65);
    let (one, two) = (lumped.figures.events.to_array(), figures(&found).events.to_array());
    for (k, (one, two)) in one.into_iter().zip(two).enumerate() {
        let (one, two) = (one.unwrap(), two.unwrap());
        assert!((one - two).abs() < 2e-6, "t{k}: {one} {two} s");
    }
    let (a, b) = (&lumped.figures.summary, &figures(&found).summary);
    for (one, two) in [
        (a.penetration, b.penetration),
        (a.peak_support_force, b.peak_support_force),
        (a.peak_penetration_force, b.peak_penetration_force),
        (a.exhaust_mass, b.exhaust_mass),
    ] {
        assert!((one - two).abs() < 2e-3 * one, "{one} {two}");
    }
    let checks = figures(&found).checks.iter().chain(&found.response.checks);
    for check in checks.chain(&found.checks) {
        assert!(check.ok, "{}", check.name);
    }
}

#[test]
fn forces_on_both_sides_are_the_same_at_every_sample() {
    let design = design();
    let parameters = parameters(&design).unwrap();
    let found = coupled(&design, &parameters, 1);
    let (record, response) = (&found.shot.record, &found.response);
    let names = ["nail.force", "nose.force", "guard.force", "support.force"];
    let [penetration, nose, guard, support] = names.map(|name| record.history(name));
    let mut largest: f64 = 0.0;
    for sample in 0..record.len() {
        let loads = response.loads.column(sample);
        let nail: f64 = loads.rows(0, COUPLED_LOADS - 2).sum();
        largest = largest.max(penetration[sample]);
        assert!((penetration[sample] - nail).abs() < 1e-5, "{sample}");
        let seat = nose[sample].max(0.0) + guard[sample];
        assert!((seat - loads[COUPLED_LOADS - 2]).abs() < 1e-5, "{sample}");
        assert!(
            (support[sample] - response.contact_forces[(0, sample)]).abs() < 1e-6,
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
        figures(&coupled(&design, &soft, 1)).summary.penetration
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
    run_with_chain(&small(text), Store::none()).0
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
        // The coarse basis leaves more above its top than a level may miss; the remainder must close.
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

/// Failed checks other than those of the coarse basis, which leaves more above its top than a level may miss.
fn failed(run: &Run) -> Vec<String> {
    let failed = run.result.checks.iter().filter(|check| !check.ok);
    let names = failed.map(|check| check.name.to_string());
    names.filter(|name| !name.contains("last octave")).collect()
}

/// The assembly of the page "Describe another tool" with the workpiece and the support of the design.
const STAPLER: &str = "[cycle]\nassembly = \"stapler\"\n[cycle.body.workpiece]\n\
                       mass = \"=wood.density*workpiece.length*workpiece.width*workpiece.thickness\"\n\
                       [cycle.contact.support]\nstiffness = \"=support.stiffness\"";

#[test]
fn an_own_assembly_couples_two_ways_and_the_run_reports_the_change() {
    let [one, two] = ["one-way", "two-way"].map(|kind| run(&format!("support.coupling = \"{kind}\"\n{STAPLER}")));
    assert!(one.result.coupling.is_none());
    assert_eq!([&*one.result.outcome, &*two.result.outcome], ["drives", "drives"]);
    assert_eq!(failed(&two), [""; 0]);
    let mut names: Vec<&str> = two.result.ranking.iter().map(|own| own.source.as_str()).collect();
    names.sort_unstable();
    assert_eq!(names, ["body", "exhaust", "workpiece"]);
    let coupling = two.result.coupling.as_ref().unwrap();
    assert!(
        coupling.work.unsettled == 0 && coupling.work.mismatch < 1e-3,
        "{:?}",
        coupling.work
    );
    for change in &coupling.events {
        assert_eq!(change.one_way_s, one.record.event(&change.event), "{}", change.event);
        assert_eq!(change.two_way_s, two.record.event(&change.event), "{}", change.event);
    }
    let events: Vec<&str> = coupling.events.iter().map(|change| change.event.as_str()).collect();
    assert_eq!(events, ["pulled", "starts", "strike", "stop", "bumper_hit", "returned"]);
    for change in &coupling.levels[..3] {
        let apart = |found: Option<f64>, run: &Run| (found.unwrap() - level(run, &change.source)).abs();
        assert!(apart(change.one_way_lwa_db, &one) < 1e-9, "{change:?}");
        assert!(apart(change.two_way_lwa_db, &two) < 1e-9, "{change:?}");
    }
    let of = |figure: &str| coupling.figures.iter().find(|own| own.figure == figure).unwrap();
    assert_eq!([of("peak_support_force").unit, of("staple_depth").unit], ["N", "m"]);
    // The table yields more than the lumped support of its stiffness under a mass that moves with it.
    let support = of("peak_support_force");
    assert_ne!(support.one_way, support.two_way);
    let depth = of("staple_depth");
    assert!(
        (depth.two_way.unwrap() - depth.one_way.unwrap()).abs() < 0.5e-3,
        "{depth:?}"
    );
}

#[test]
fn the_n80cb_as_an_assembly_couples_as_its_keys_do() {
    let [keys, assembly] =
        ["", "[cycle]\nassembly = \"n80cb\""].map(|cycle| run(&format!("support.coupling = \"two-way\"\n{cycle}")));
    assert_eq!(failed(&assembly), [""; 0]);
    assert_eq!(keys.result.outcome, assembly.result.outcome);
    for event in &keys.record.events {
        let other = assembly.record.event(&event.name);
        let apart = event.time.zip(other).map(|(own, other)| (own - other).abs());
        assert!(
            apart.is_some_and(|apart| apart < 1e-6),
            "{}: {:?} {other:?} s",
            event.name,
            event.time
        );
    }
    for source in ["workpiece", "exhaust", "body"] {
        let gap = level(&assembly, source) - level(&keys, source);
        assert!(gap.abs() < 0.02, "{source}: {gap} dB");
    }
    let work = |run: &Run| {
        let coupling = run.result.coupling.as_ref().unwrap();
        (coupling.work.steps, coupling.work.unsettled)
    };
    assert_eq!(work(&keys), work(&assembly));
}

/// The block of `designs/n80cb-free.toml` on the coarse mesh: it swings at 5 Hz, far below the audible range, and every
/// check closes.
#[test]
fn a_suspended_block_swings_below_the_audible_range() {
    let free = Design::load("designs/n80cb-free.toml").unwrap();
    let mut design = small("");
    design.support.kind = free.support.kind;
    design.springs = free.springs.clone();
    let (run, chain) = run_with_chain(&design, Store::none());
    let failed: Vec<_> = run.result.checks.iter().filter(|check| !check.ok).collect();
    assert!(
        failed.iter().all(|check| check.name.contains("last octave")),
        "{failed:?}"
    );
    let stiffness: f64 = design.springs.values().map(|spring| spring.stiffness_z).sum();
    let mass = chain.structure[0].body.get().unwrap().lift.norm_squared();
    let hz = (stiffness / mass).sqrt() / std::f64::consts::TAU;
    assert!((hz - 5.0).abs() < 0.05, "{hz} Hz");
    let table = self::run("");
    let level = |run: &Run| level(run, "workpiece");
    assert!(level(&run) < level(&table), "the table is louder than the block alone");
}

#[test]
fn sand_at_the_sides_adds_stiffness_and_sand_below_adds_mass() {
    let sand = "support.kind = \"sandbox\"\nsupport.sand.bonded = true\n";
    let run = |text: &str| {
        let (run, chain) = run_with_chain(&small(text), Store::none());
        (run, Arc::clone(&chain.vibration.get().unwrap().response))
    };
    let (alone, still) = run(sand);
    let (held, between) = run(&format!("{sand}support.sand.side_contact = 0.5"));
    let (heavy, laden) = run(&format!("{sand}support.sand.added_mass = 0.3"));
    let carried = |response: &ModalResponse, cells: std::ops::Range<usize>| -> f64 {
        response.contact_forces.column(0).rows(cells.start, cells.len()).sum()
    };
    let cells = 65;
    let whole = carried(&still, 0..cells);
    assert_eq!(between.contact_forces.nrows(), cells + 3 * 40);
    // The sides take a part of the static load off the base.
    let base = carried(&between, 0..cells);
    assert!(base < 0.9 * whole && base > 0.3 * whole, "{base} of {whole} N");
    // Sand under the block adds inertia, not weight.
    assert!((carried(&laden, 0..cells) - whole).abs() < 1e-6 * whole);
    assert!(!still.start[0].displacement.is_empty());
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

/// Four springs under the corners of the block, each a quarter of a total along z, dashpots likewise, softer sideways.
fn on_springs(stiffness: f64, damping: f64, text: &str) -> Design {
    let mut all = format!("support.kind = \"springs\"\n{text}\n");
    for (corner, (x, y)) in [(-0.17, -0.05), (-0.17, 0.05), (0.17, -0.05), (0.17, 0.05)]
        .into_iter()
        .enumerate()
    {
        let part = |total: f64| 0.25 * total;
        all.push_str(&format!(
            "[springs.corner_{corner}]\nbody = \"workpiece\"\nx = {x:?}\ny = {y:?}\nz = 0\nradius = 0.02\n"
        ));
        for (axis, share) in [("x", 0.3), ("y", 0.3), ("z", 1.0)] {
            all.push_str(&format!("stiffness_{axis} = {:?}\n", share * part(stiffness)));
            all.push_str(&format!("damping_{axis} = {:?}\n", share * part(damping)));
        }
    }
    small(&all)
}

/// After the shot: q = a e^(-c t/2M) cos(omega t + phase), omega^2 = k/M - (c/2M)^2, M from the mesh and its density.
#[test]
fn a_block_on_springs_and_dashpots_decays_like_a_damped_mass() {
    let (k, c) = (2e5, 30.0);
    let design = on_springs(k, c, "analysis.duration = \"0.3 s\"\nwood.loss_factor = 0");
    let (run, chain) = run_with_chain(&design, Store::none());
    assert!(
        run.result
            .checks
            .iter()
            .all(|check| check.ok || check.name.contains("last octave"))
    );
    let (body, vibration) = (chain.structure[0].body.get().unwrap(), chain.vibration.get().unwrap());
    let response = &vibration.response;
    let mass = body.lift.norm_squared();
    let rise = DMatrix::from_column_slice(body.lift.len(), 1, body.lift.as_slice()) / mass;
    let velocity = response.points(0, &rise, Motion::Velocity).unwrap();
    let h = response.step;
    let from = ((run.record.sample_interval * run.record.len() as f64 + 0.01) / h) as usize;
    // Zeros with the sign rising, between samples by a straight line, and the peak after each.
    let mut zeros = Vec::new();
    for n in from..velocity.len() - 1 {
        let (a, b) = (velocity[n], velocity[n + 1]);
        if a < 0.0 && b >= 0.0 {
            zeros.push((n as f64 - a / (b - a)) * h);
        }
    }
    assert!(zeros.len() > 5, "{zeros:?}");
    let periods = (zeros.len() - 1) as f64;
    let length = zeros[zeros.len() - 1] - zeros[0];
    let omega = std::f64::consts::TAU * periods / length;
    let expected = (k / mass - (0.5 * c / mass).powi(2)).sqrt();
    // The wood under each spring gives way, too.
    assert!((omega / expected - 1.0).abs() < 5e-3, "{omega} {expected} rad/s");
    let peak = |zero: f64| {
        let first = (zero / h) as usize;
        let period = (std::f64::consts::TAU / expected / h) as usize;
        velocity.as_slice()[first..(first + period).min(velocity.len())]
            .iter()
            .fold(0.0, |m: f64, v| m.max(*v))
    };
    let last = zeros.len() - 2;
    let decay = (peak(zeros[0]) / peak(zeros[last])).ln() / (zeros[last] - zeros[0]);
    assert!(
        (decay / (0.5 * c / mass) - 1.0).abs() < 0.01,
        "{decay} {} 1/s",
        0.5 * c / mass
    );
    // Weight and seated tool rest on the springs.
    let parameters = parameters(&design).unwrap();
    let held: f64 = response.contact_forces.column(0).iter().sum();
    let seat = run.record.workpiece.as_ref().unwrap().seat[0];
    let weight = mass * parameters.ambient.gravity + seat;
    assert!((held - weight).abs() < 1e-3 * weight, "{held} {weight} N");
}

#[test]
fn springs_carry_both_ways_and_a_table_on_feet_closes_its_balances() {
    let coupled = on_springs(1e6, 60.0, "support.coupling = \"two-way\"");
    let (two_way, chain) = run_with_chain(&coupled, Store::none());
    let coupled = chain.vibration.get().unwrap();
    let fine = |run: &Run| {
        let failed: Vec<_> = run.result.checks.iter().filter(|check| !check.ok).collect();
        assert!(
            failed.iter().all(|check| check.name.contains("last octave")),
            "{failed:?}"
        );
    };
    fine(&two_way);
    // The force of the support in the cycle is the load on the springs along z, not their lateral restraint.
    let (record, response) = (&two_way.record.record, &coupled.response);
    let vertical = |n: usize| {
        (0..4)
            .map(|corner| response.contact_forces[(3 * corner + 2, n)])
            .sum::<f64>()
    };
    for n in (0..record.len()).step_by(50) {
        assert!((record.history("support.force")[n] - vertical(n)).abs() < 1e-6 * (1.0 + vertical(n).abs()));
    }
    let feet = Design::load("designs/n80cb-feet.toml").unwrap();
    let mut table = small("support.worktable.foot = \"clamped\"");
    table.support.worktable.foot = feet.support.worktable.foot;
    table.springs = feet.springs.clone();
    let (run, chain) = run_with_chain(&table, Store::none());
    fine(&run);
    let (under, vibration) = (chain.structure[1].body.get().unwrap(), chain.vibration.get().unwrap());
    assert_eq!(
        under.omega.iter().filter(|omega| **omega == 0.0).count(),
        6,
        "the table is free"
    );
    let contact = &table.support.contact;
    let cells = (contact.points_along * contact.points_across) as usize;
    let at_rest = vibration.response.contact_forces.column(0);
    assert_eq!(at_rest.len(), cells + 12);
    let gravity = table.ambient.gravity;
    let feet: f64 = (0..4).map(|foot| at_rest[cells + 3 * foot + 2]).sum();
    let above: f64 = at_rest.rows(0, cells).sum();
    let expected = above + gravity * under.lift.norm_squared();
    assert!((feet - expected).abs() < 1e-6 * expected, "{feet} {expected} N");
}

#[test]
fn a_spring_beside_its_body_is_refused_and_so_are_springs_that_cannot_hold() {
    let mut off = on_springs(1e6, 60.0, "");
    off.springs.get_mut("corner_1").unwrap().z = -0.02;
    let error = |design: &Design| {
        let error = try_run(design, Store::none()).map(|_| ()).unwrap_err();
        let causes = std::iter::successors(Some(&error as &dyn std::error::Error), |error| error.source());
        causes.map(|error| error.to_string()).collect::<Vec<_>>().join(": ")
    };
    let text = error(&off);
    assert!(
        text.contains("`corner_1`") && text.contains("20 mm outside the workpiece"),
        "{text}"
    );
    // One spring under a corner cannot support the block level.
    let mut one = on_springs(1e6, 60.0, "");
    one.springs.retain(|name, _| name == "corner_0");
    let text = error(&one);
    assert!(text.contains("no static equilibrium"), "{text}");
}
