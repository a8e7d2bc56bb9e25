//! Every built-in assembly can be read and evaluated.

use std::collections::BTreeMap;

use nailnoise_dynamics::Settings;
use nailnoise_dynamics::network::{AssemblyText, BUILT_IN, KeyValue, Numerics, Record, simulate};

use crate::common;
use crate::keys::keys;

#[test]
fn built_in_assemblies_are_complete_with_their_own_keys_or_those_of_the_base_design() {
    for (name, _) in BUILT_IN {
        let text = AssemblyText::built_in(name).unwrap_or_else(|| panic!("{name} is missing"));
        let text = text.unwrap_or_else(|error| panic!("{error}; {}", error.help()));
        let keys: BTreeMap<String, KeyValue> = if name.starts_with("n80cb") {
            keys(&common::n80cb())
        } else {
            BTreeMap::new()
        };
        let resolved = text
            .resolve(&keys)
            .unwrap_or_else(|error| panic!("{error}; {}", error.help()));
        // One that changes another has its name.
        assert!(
            name.starts_with(resolved.assembly.name.as_str()),
            "{name}: {}",
            resolved.assembly.name
        );
        assert!(resolved.assembly.end > 0.0);
    }
}

#[test]
fn every_own_key_is_used_and_has_a_provenance() {
    for (name, _) in BUILT_IN.iter().filter(|(name, _)| !name.starts_with("n80cb")) {
        let Some(Ok(text)) = AssemblyText::built_in(name) else {
            panic!("{name}")
        };
        let Ok(resolved) = text.resolve(&BTreeMap::<String, KeyValue>::new()) else {
            panic!("{name}")
        };
        for path in text.declared().keys() {
            let literal = resolved.literals.iter().find(|literal| literal.path == *path);
            let literal = literal.unwrap_or_else(|| panic!("{name}: {path} is not used"));
            assert!(!literal.provenance.is_empty(), "{name}: {path} has no provenance");
        }
    }
}

/// Runs a built-in assembly with its own keys.
fn run(name: &str) -> Record {
    let Some(Ok(text)) = AssemblyText::built_in(name) else {
        panic!("{name}")
    };
    let Ok(resolved) = text.resolve(&BTreeMap::<String, KeyValue>::new()) else {
        panic!("{name}")
    };
    simulate(&resolved.assembly, &Numerics::default()).unwrap_or_else(|error| panic!("{name}: {error}"))
}

#[test]
fn built_in_assemblies_run_and_conserve_mass_energy_and_momentum() {
    for (name, _) in BUILT_IN.iter().filter(|(name, _)| !name.starts_with("n80cb")) {
        let record = run(name);
        assert!(record.is_certified(), "{name}: {:?}", record.checks);
        let events = record.events.iter().filter(|event| event.time.is_some()).count();
        assert_eq!(events, record.events.len(), "{name}: {:?}", record.events);
    }
}

/// The variant and the forms that the keys select describe one model.
#[test]
fn the_published_variant_equals_the_published_forms_of_the_keys() {
    let parameters = common::n80cb();
    let Some(Ok(text)) = AssemblyText::built_in("n80cb_as_published") else {
        panic!("it cannot be read")
    };
    let resolved = text.resolve(&keys(&parameters));
    let resolved = resolved.unwrap_or_else(|error| panic!("{error}; {}", error.help()));
    let settings = Settings {
        relative_tolerance: 1e-9,
        ..Settings::default()
    };
    let numerics = Numerics {
        relative_tolerance: settings.relative_tolerance,
        ..Numerics::default()
    };
    let variant = simulate(&resolved.assembly, &numerics).unwrap();
    let forms = nailnoise_dynamics::simulate(&parameters.published_all(), &settings).unwrap();
    for (number, expected) in forms.figures.events.to_array().into_iter().enumerate() {
        let found = variant.event(&format!("t{number}"));
        assert_eq!(found.is_some(), expected.is_some(), "t{number}");
        let apart = found
            .zip(expected)
            .map_or(0.0, |(found, expected)| (found - expected).abs());
        // The error of the integration.
        assert!(apart < 1e-7, "t{number}: {apart:e} s");
    }
    assert_eq!(variant.outcome.as_deref(), Some(forms.figures.outcome.name()));
}

/// Strike, bumper, stop and lift of the prototype \[ms\], and its speed at the strike \[m/s\].
#[test]
fn the_gas_spring_nailer_equals_the_prototype() {
    let record = run("gas_spring_nailer");
    let events = [
        ("strike", 7.9311),
        ("bumper_hit", 10.384),
        ("stop", 10.747),
        ("lifted", 376.815),
    ];
    for (name, expected) in events {
        let time = 1e3 * record.event(name).unwrap_or(f64::NAN);
        assert!(
            (time - expected).abs() < 1e-3,
            "{name}: {time} ms in place of {expected} ms"
        );
    }
    assert!(
        (record.strikes[0].before - 21.8376).abs() < 1e-3,
        "{:?}",
        record.strikes
    );
}

/// Rows of the measured air guns at the chosen parameters: 21.64 m/s at 30 psi, 92.0 m/s with the spring K11.
#[test]
fn the_air_guns_have_the_muzzle_velocities_of_the_prototype() {
    for (name, channel, expected) in [
        ("air_gun_valve", "projectile.speed", 21.64),
        ("air_gun_spring", "dart.speed", 92.0),
    ] {
        let record = run(name);
        let (Some(interval), Some(muzzle)) = (record.interval, record.event("muzzle")) else {
            panic!("{name}")
        };
        // Linear between the samples before and after the event.
        let before = (muzzle / interval).floor();
        let sample = |at: usize| record.get(channel).and_then(|values| values.get(at)).copied();
        let samples = sample(before as usize).zip(sample(before as usize + 1));
        let share = muzzle / interval - before;
        let speed = samples.map_or(f64::NAN, |(first, second)| first + share * (second - first));
        assert!(
            (speed - expected).abs() < 0.01,
            "{name}: {speed} m/s in place of {expected} m/s"
        );
    }
}
