//! Derivatives of a shot: against closed forms, against differences made by hand, and at the edges of the permitted
//! values.

use nailnoise::chain;
use nailnoise::design::Value;
use nailnoise::design::inputs::cycle::{cycle_settings, parameters};
use nailnoise::sensitivity::{
    Derivative, End, OUTPUTS, Sensitivity, assembly_outputs, choose, sensitivity, sensitivity_of_assembly,
};
use nailnoise::stages::Progress;
use nailnoise::{Design, Error};
use nailnoise_dynamics::network::Record;
use nailnoise_dynamics::{CycleRecord, Outcome, Settings, simulate};

/// The N80CB with a range for the density of the nail's steel.
fn design() -> Design {
    let text = "base = \"n80cb.toml\"\nnail.density = { value = \"7850 kg/m3\", range = \"7600 .. 8000 kg/m3\" }\n";
    Design::parse(text, concat!(env!("CARGO_MANIFEST_DIR"), "/designs/dense.toml")).unwrap()
}

fn of<'a>(sensitivity: &'a Sensitivity, output: &str, key: &str) -> &'a Derivative {
    let output = sensitivity.outputs.iter().find(|o| o.name == output).unwrap();
    output
        .ranking
        .iter()
        .find(|d| d.key == key)
        .unwrap_or_else(|| panic!("{key} has no derivative of {}", output.name))
}

/// The design with one key moved, integrated closely.
fn moved(design: &Design, key: &str, value: f64) -> CycleRecord {
    let mut design = design.clone();
    design.set(&[(key, Value::Number(value))]).unwrap();
    let settings = Settings {
        relative_tolerance: 1e-10,
        ..cycle_settings(&design)
    };
    simulate(&parameters(&design).unwrap(), &settings).unwrap()
}

/// The rod loses speed only to the nail, v' = v M_p/(M_p + M_n): dv'/d(rho) = -v M_p V_n/(M_p + M_n)^2 with M_n = rho
/// V_n.
#[test]
fn the_impact_depends_on_the_density_of_the_nail_by_momentum() {
    let design = design();
    let outputs = choose(&["speed", "t3", "t4"]).unwrap();
    let s = sensitivity(&design, &outputs, Some(&["nail.density"]), &Progress::silent()).unwrap();
    let v = s
        .outputs
        .iter()
        .find(|o| o.name == "speed_before_impact")
        .unwrap()
        .value
        .unwrap();
    let n = &design.nail;
    let disc = |diameter: f64, length: f64| std::f64::consts::FRAC_PI_4 * diameter * diameter * length;
    let volume = disc(n.diameter, n.length - n.head_thickness) + disc(n.head_diameter, n.head_thickness);
    let (rod, nail) = (design.piston.mass, n.density * volume);
    let exact = -v * rod * volume / (rod + nail).powi(2);
    let after = of(&s, "speed_after_impact", "nail.density");
    assert!(
        (after.derivative / exact - 1.0).abs() < 1e-5,
        "{after:?}, exactly {exact:e}"
    );
    assert!(
        (after.derivative - exact).abs() <= after.error,
        "{after:?}, exactly {exact:e}"
    );
    // Nothing before the impact depends on the nail.
    for output in ["speed_before_impact", "t3", "t4"] {
        let before = of(&s, output, "nail.density");
        assert_eq!((before.derivative, before.effect), (0.0, 0.0), "{output}");
    }
}

#[test]
fn differences_made_by_hand_agree_within_the_error() {
    let design = design();
    let outputs = choose(&[
        "mean_drive_speed",
        "t13",
        "exhaust_mass",
        "peak_support_force",
        "penetration_work",
    ])
    .unwrap();
    let keys = ["supply.pressure", "wood.hardness_modulus"];
    let s = sensitivity(&design, &outputs, Some(&keys), &Progress::silent()).unwrap();
    for (key, value, step) in [
        (keys[0], design.supply.pressure, 2e3),
        (keys[1], design.wood.hardness_modulus, 1e3),
    ] {
        let near = [value - step, value + step].map(|x| moved(&design, key, x));
        let far = [value - 2.0 * step, value + 2.0 * step].map(|x| moved(&design, key, x));
        for (output, found) in outputs.iter().zip(&s.outputs) {
            let slope = |[low, high]: &[CycleRecord; 2], width: f64| {
                (output.of(high).unwrap() - output.of(low).unwrap()) / width
            };
            let (near, far) = (slope(&near, 2.0 * step), slope(&far, 4.0 * step));
            // Richardson's estimate by hand, with its own truncation and noise.
            let (hand, open) = ((4.0 * near - far) / 3.0, (near - far).abs() / 3.0 + found.noise / step);
            let own = of(&s, output.name, key);
            assert!(
                (own.derivative - hand).abs() <= own.error + open,
                "{output:?} to {key}: {own:?}, by hand {hand:e}"
            );
        }
    }
}

#[test]
fn signs_are_those_of_the_physics() {
    let s = sensitivity(
        &design(),
        &choose(&[
            "t1",
            "mean_drive_speed",
            "exhaust_mass",
            "leak_mass",
            "peak_stopper_force",
        ])
        .unwrap(),
        Some(&[
            "supply.pressure",
            "trigger.vent_area",
            "chambers.leak_area",
            "wood.resistance_scale",
            "contacts.stopper_stiffness",
        ]),
        &Progress::silent(),
    )
    .unwrap();
    for (output, key, sign) in [
        ("mean_drive_speed", "supply.pressure", 1.0),
        ("exhaust_mass", "supply.pressure", 1.0),
        ("t1", "trigger.vent_area", -1.0),
        ("leak_mass", "chambers.leak_area", 1.0),
        ("mean_drive_speed", "wood.resistance_scale", -1.0),
        ("peak_stopper_force", "contacts.stopper_stiffness", 1.0),
    ] {
        let d = of(&s, output, key);
        assert!(d.is_certain() && d.derivative * sign > 0.0, "{output} to {key}: {d:?}");
    }
    // A leak this small does not affect its source: its mass is the area times a flow.
    let leak = of(&s, "leak_mass", "chambers.leak_area");
    let mass = s.outputs.iter().find(|o| o.name == "leak_mass").unwrap().value.unwrap();
    assert!(
        (leak.derivative * design().chambers.leak_area / mass - 1.0).abs() < 0.02,
        "{leak:?}"
    );
    for output in &s.outputs {
        assert!(
            output.ranking.windows(2).all(|pair| pair[0].weight >= pair[1].weight),
            "{}",
            output.name
        );
    }
}

#[test]
fn at_the_edge_of_what_is_allowed_differences_are_one_sided() {
    // Viscous friction is 0 and cannot be less; lift and preload are all that the closing spring's law allows.
    let design = design();
    let keys = ["piston.friction.viscous", "head_valve.lift"];
    let s = sensitivity(
        &design,
        &choose(&["mean_drive_speed"]).unwrap(),
        Some(&keys),
        &Progress::silent(),
    )
    .unwrap();
    let viscous = of(&s, "mean_drive_speed", keys[0]);
    assert!(viscous.derivative < 0.0 && viscous.is_certain(), "{viscous:?}");
    let step = 0.02;
    let drive = |key: &str, x: f64| moved(&design, key, x).figures.summary.mean_drive_speed.unwrap();
    let [base, near, far] = [0.0, step, 2.0 * step].map(|x| drive(keys[0], x));
    let hand = (4.0 * near - far - 3.0 * base) / (2.0 * step);
    assert!(
        (viscous.derivative / hand - 1.0).abs() < 1e-3,
        "{viscous:?}, by hand {hand:e}"
    );
    let lift = s.parameters.iter().find(|p| p.parameter.key == keys[1]).unwrap();
    assert!(
        matches!(&lift.ends[1], End::Refused(why) if why.contains("spring")),
        "{:?}",
        lift.ends
    );
    assert!(of(&s, "mean_drive_speed", keys[1]).is_certain());
}

#[test]
fn a_range_over_which_the_shot_changes_is_flagged() {
    let keys = [
        "wood.resistance_scale",
        "contacts.seat_stiffness",
        "contacts.cap_stiffness",
    ];
    let s = sensitivity(
        &design(),
        &choose(&["speed_before_impact"]).unwrap(),
        Some(&keys),
        &Progress::silent(),
    )
    .unwrap();
    assert_eq!(s.outcome, Outcome::Drives.name());
    let of_key = |key: &str| s.parameters.iter().find(|p| p.parameter.key == key).unwrap();
    let wood = of_key(keys[0]);
    assert!(wood.outcome_changes);
    assert_eq!(
        wood.ends,
        [Outcome::Overdriven, Outcome::Underdriven].map(|own| End::Outcome(own.name().to_owned()))
    );
    assert!(!of_key(keys[1]).outcome_changes);
    // A range of three decades: the derivative here does not predict its far end, the run there does.
    let cap = of(&s, "speed_before_impact", keys[2]);
    assert_eq!(cap.is_linear(), Some(false));
    assert!(cap.weight < 0.1 && cap.effect.abs() > 1.0, "{cap:?}");
}

/// The built-in stapler, with a range for the mass of a staple.
fn stapler() -> Design {
    let text = "base = \"n80cb.toml\"\n\
                staple.mass = { value = \"0.12 g\", range = \"0.10 .. 0.15 g\" }\n\
                [cycle]\nassembly = \"stapler\"\n";
    Design::parse(text, concat!(env!("CARGO_MANIFEST_DIR"), "/designs/stapled.toml")).unwrap()
}

/// The record of a design's assembly with one key moved, integrated closely.
fn shot_of(design: &Design, key: &str, value: f64) -> Record {
    let mut design = design.clone();
    let closely = ("analysis.cycle_tolerance", Value::Number(1e-10));
    design.set(&[(key, Value::Number(value)), closely]).unwrap();
    let shot = chain::shot(&design).unwrap();
    assert!(shot.nailer.is_none(), "the tool of the keys");
    *shot.record
}

fn of_assembly(design: &Design, names: &[&str], keys: &[&str]) -> Sensitivity {
    let found = sensitivity_of_assembly(design, names, Some(keys), &Progress::silent());
    found.unwrap().unwrap()
}

/// The driver loses speed only to the staple: dv'/dm = -v M/(M + m)^2.
#[test]
fn the_impact_of_an_assembly_depends_on_the_mass_of_its_fastener_by_momentum() {
    let design = stapler();
    let s = of_assembly(&design, &["speed", "starts"], &["staple.mass"]);
    assert_eq!(s.outcome, "drives");
    let v = s.outputs.iter().find(|own| own.name == "speed_before_staple").unwrap();
    assert_eq!(v.unit, "m/s");
    let (driver, staple) = (design.piston.mass, 0.12e-3);
    let exact = -v.value.unwrap() * driver / (driver + staple).powi(2);
    let after = of(&s, "speed_after_staple", "staple.mass");
    assert!(
        (after.derivative / exact - 1.0).abs() < 1e-5 && (after.derivative - exact).abs() <= after.error,
        "{after:?}, exactly {exact:e}"
    );
    for output in ["speed_before_staple", "starts"] {
        let before = of(&s, output, "staple.mass");
        assert_eq!((before.derivative, before.effect), (0.0, 0.0), "{output}");
    }
    let mass = &s.parameters[0].parameter;
    assert_eq!((mass.unit.as_str(), mass.range), ("kg", [0.10e-3, 0.15e-3]));
}

/// A literal and a key of the assembly against central differences made by hand. The mass through the exhaust is left
/// out: bounces of the piston scatter it by 1e-8 kg between neighbouring values, more than half a per cent of the force
/// changes it.
#[test]
fn differences_of_literals_made_by_hand_agree_within_the_error() {
    let design = stapler();
    let keys = ["staple.force", "cycle.contact.support.stiffness"];
    let names = [
        "speed_before_staple",
        "staple_depth",
        "stop",
        "peak_staple_force",
        "peak above.pressure",
        "above.pressure at stop",
    ];
    let outputs = assembly_outputs(&design, &names).unwrap().unwrap();
    let s = of_assembly(&design, &names, &keys);
    for (key, value, step) in [(keys[0], 180.0, 0.9), (keys[1], 1e8, 1e6)] {
        let at = |x: f64| shot_of(&design, key, x);
        let [near, far] = [1.0, 2.0].map(|n| [at(value - n * step), at(value + n * step)]);
        for (output, found) in outputs.iter().zip(&s.outputs) {
            let slope =
                |[low, high]: &[Record; 2], width: f64| (output.of(high).unwrap() - output.of(low).unwrap()) / width;
            let (near, far) = (slope(&near, 2.0 * step), slope(&far, 4.0 * step));
            let (hand, open) = ((4.0 * near - far) / 3.0, (near - far).abs() / 3.0 + found.noise / step);
            let own = of(&s, &output.name, key);
            assert!(
                (own.derivative - hand).abs() <= own.error + open,
                "{} to {key}: {own:?}, by hand {hand:e}",
                output.name
            );
        }
    }
}

#[test]
fn outputs_of_an_assembly_are_chosen_by_name_or_group() {
    let design = stapler();
    let names = |chosen: &[&str]| -> Vec<String> {
        let chosen = assembly_outputs(&design, chosen).unwrap().unwrap();
        chosen.into_iter().map(|own| own.name).collect()
    };
    assert_eq!(
        names(&[]),
        [
            "speed_before_staple",
            "speed_after_staple",
            "staple_depth",
            "staple_work",
            "coupling_mass",
            "exhaust_mass",
            "foot_mass"
        ]
    );
    assert_eq!(names(&["stop", "peak_bumper_force"]), ["stop", "peak_bumper_force"]);
    let mut all = names(&["all"]);
    let count = all.len();
    all.sort_unstable();
    all.dedup();
    assert_eq!(all.len(), count);
    let refused = assembly_outputs(&design, &["loudness"]).unwrap_err().to_string();
    assert!(refused.contains("loudness"), "{refused}");
}

#[test]
fn outputs_are_chosen_by_name_or_group() {
    let names = |chosen: &[&str]| choose(chosen).unwrap().iter().map(|o| o.name).collect::<Vec<_>>();
    assert_eq!(names(&["all"]).len(), OUTPUTS.len());
    assert_eq!(names(&["events"]).len(), 18);
    assert_eq!(
        names(&["exhaust_mass", "penetration"]),
        ["penetration", "penetration_work", "exhaust_mass"]
    );
    assert!(matches!(choose(&["loudness"]), Err(Error::NoSuchOutput { name, .. }) if name == "loudness"));
}
