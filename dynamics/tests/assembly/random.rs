//! Random assemblies are read, and broken ones are refused with a place and a remedy.

use std::collections::BTreeMap;
use std::path::Path;

use nailnoise_documents::Document;
use nailnoise_dynamics::network::{
    AssemblyError, AssemblyText, BUILT_IN, KeyValue, Numerics, Resolved, simulate_balanced,
};

use crate::random_assembly::{Random, first_seed, random_assembly};

const COUNT: u64 = 500;

fn read(text: &str) -> Result<Resolved, AssemblyError> {
    let keys: BTreeMap<String, KeyValue> = BTreeMap::new();
    AssemblyText::open(&Document::new(Path::new("random.toml"), text))?.resolve(&keys)
}

fn check_place(text: &str, error: &AssemblyError) {
    // A text whose damaged first lines name no assembly changes the N80CB, whose blocks then miss their keys.
    let of_built_in = || {
        BUILT_IN
            .iter()
            .find(|(name, _)| error.at.file().ends_with(&format!("{name}.toml")))
    };
    let own = if error.at.file().ends_with("random.toml") {
        text
    } else {
        of_built_in().unwrap_or_else(|| panic!("{error}\n{text}")).1
    };
    let lines = own.lines().count().max(1);
    assert!((1..=lines).contains(&error.at.line()), "{error}\n{own}");
    assert!(!error.help().is_empty(), "{error}");
}

#[test]
fn valid_assemblies_are_read() {
    for seed in first_seed()..first_seed() + COUNT {
        let text = random_assembly(&mut Random::new(seed));
        let resolved = read(&text).unwrap_or_else(|error| panic!("{error}; {}\n{text}", error.help()));
        assert_eq!(resolved.assembly.reservoirs.len(), 2);
    }
}

/// Every option of the random texts occurs in some, and every fault has texts that it breaks.
#[test]
fn the_random_assemblies_have_every_option() {
    let texts: Vec<String> = (0..COUNT).map(|seed| random_assembly(&mut Random::new(seed))).collect();
    let options = [
        "iso6358",
        "ratio_polynomial",
        "exp(",
        "one_way",
        "delays =",
        "leaves =",
        "before = true",
        "\"table\"",
        "\"solid_wood\"",
        "\"wood\"",
        "legs = 2",
        "if = \"own.count > 5\"",
        "seat =",
        "holes =",
        "ramp =",
        "pipe =",
        "series =",
        "gravity =",
        "[cycle.hold",
        "[cycle.motor",
        "reverses\"",
        "choked\"",
        "clear =",
        "hysteresis =",
        "may_pull =",
        "polynomial = [2",
        "stick =",
        "table = [[\"0 s",
        "jet =",
        "[cycle.outcome]",
        "[cycle.sensor]",
    ];
    for option in options.into_iter().chain(FAULTS.map(|(from, _)| from)) {
        let with = texts.iter().filter(|text| text.contains(option)).count();
        assert!(with > 10, "{option} in {with} texts");
    }
    let resolved: Vec<Resolved> = texts.iter().filter_map(|text| read(text).ok()).collect();
    let count = |has: &dyn Fn(&Resolved) -> bool| resolved.iter().filter(|own| has(own)).count();
    let blows = count(&|own| !own.assembly.blows.is_empty());
    let switched = count(&|own| own.assembly.passages.iter().any(|own| own.name == "switched"));
    assert!(count(&|own| own.assembly.volumes.is_empty()) > 10);
    assert!(
        (50..450).contains(&blows) && (50..450).contains(&switched),
        "{blows}, {switched}"
    );
}

#[test]
fn random_assemblies_end_with_their_energy_balanced_or_with_an_error() {
    let mut ended = 0;
    for seed in first_seed()..first_seed() + COUNT / 5 {
        let text = random_assembly(&mut Random::new(seed));
        let Ok(resolved) = read(&text) else { panic!("{text}") };
        let numerics = Numerics {
            sample_interval: None,
            ..Numerics::default()
        };
        if let Ok(record) = simulate_balanced(&resolved.assembly, &numerics) {
            let gas = record.checks.iter().find(|check| check.name.starts_with("gas energy"));
            // Gas in a passage that delays its flow is in no volume.
            let is_delayed = text.contains("delays = \"flow\"");
            let has_no_gas = is_delayed || resolved.assembly.volumes.is_empty();
            assert!(
                gas.map_or(has_no_gas, |check| check.ok),
                "seed {seed}: {:?}\n{text}",
                record.checks
            );
            ended += 1;
        }
    }
    assert!(ended > COUNT / 10, "{ended} ended");
}

/// Faults that no assembly survives: a text and what takes its place once.
const FAULTS: [(&str, &str); 24] = [
    ("area =", "aera ="),
    (" mm2\"", " mm\""),
    ("between = [\"v0\"", "between = [\"v9\""),
    ("dead = ", "# dead = "),
    (" cm3\"", " furlong\""),
    ("pressure = \"=", "pressure = \"=disc("),
    ("pressure = \"=", "pressure = \"=Pb*"),
    ("t0 = { at", "t0 = { as"),
    ("schema = 1", "schema = 2"),
    ("end = \"20 ms\"", "end = \"20 mm\""),
    ("empty = { becomes", "empty = { after = \"t9\", becomes"),
    ("[cycle.volume.v0]", "[cycle.volume.v0"),
    ("atmosphere = { pressure", "atmos = { pressure"),
    ("v0.pressure <", "v0.pressure + 1 mm <"),
    ("if = \"own.count", "if = \"own.cuont"),
    ("own.count > 5, disc", "own.count > 5, dics"),
    ("disc(bore/8)", "bore/8"),
    // In a branch that the condition does not select.
    ("max(2 mm2", "max(2 mm"),
    ("max(2 mm2, disc(own", "max(2 mm2, disc(onw"),
    ("critical_ratio = 0.35", "critical_ratio = \"wide\""),
    ("when = \"", "when = \"un"),
    ("driver = \"b0\"", "driver = \"v0\""),
    ("[cycle.blow.nail]", "[cycle.blow.nial]"),
    (", modulus = \"207 GPa\"", ""),
];

#[test]
fn broken_assemblies_are_refused_with_a_place_and_a_remedy() {
    for seed in first_seed()..first_seed() + COUNT {
        let mut random = Random::new(seed + 10_000);
        let mut text = random_assembly(&mut random);
        // A fault in a block that is switched off is not found.
        for count in 1..=10 {
            text = text.replace(&format!("[own]\ncount = {count}\n"), "[own]\ncount = 6\n");
        }
        let usable: Vec<_> = FAULTS.iter().filter(|(from, _)| text.contains(from)).collect();
        let (from, to) = usable[random.below(usable.len())];
        let broken = text.replacen(from, to, 1);
        match read(&broken) {
            Err(error) => check_place(&broken, &error),
            Ok(_) => panic!("accepted with {to}:\n{broken}"),
        }
    }
}

#[test]
fn texts_with_random_damage_never_panic() {
    let mut refused = 0;
    for seed in first_seed()..first_seed() + COUNT {
        let mut random = Random::new(seed + 20_000);
        let text = random_assembly(&mut random);
        let mut characters: Vec<char> = text.chars().collect();
        for _ in 0..1 + random.below(4) {
            let at = random.below(characters.len());
            match random.below(3) {
                0 => drop(characters.drain(at..(at + random.below(20)).min(characters.len()))),
                1 => characters.insert(at, ['=', '"', '(', '^', '.', '9', '\u{e9}', '\n'][random.below(8)]),
                _ => characters.swap(at, at / 2),
            }
        }
        let damaged: String = characters.into_iter().collect();
        if let Err(error) = read(&damaged) {
            check_place(&damaged, &error);
            refused += 1;
        }
    }
    assert!(refused > COUNT / 2, "only {refused} were refused");
}
