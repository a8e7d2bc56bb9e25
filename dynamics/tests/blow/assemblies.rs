//! Elastic blows of assemblies: the text of the N80CB, a stapler with two legs, a brad nailer, a finish nailer, random
//! assemblies; bars that are incomplete.

use std::collections::BTreeMap;
use std::path::Path;

use nailnoise_documents::Document;
use nailnoise_dynamics::blow::{Blow, BlowInput, Course, elastic_blow};
use nailnoise_dynamics::network::{Assembly, AssemblyError, AssemblyText, Numerics, Record, simulate};
use nailnoise_dynamics::{Settings, simulate as simulate_keys};

use crate::n80cb_assembly::n80cb_assembly;
use crate::random_assembly::{Random, first_seed, random_assembly};
use crate::{elastic_n80cb, stiffened};

/// A built-in tool with an elastic blow, and changes.
fn resolve(tool: &str, changes: &str) -> Result<Assembly, AssemblyError> {
    let text = format!("[model]\nblow = \"elastic\"\n[cycle]\nassembly = \"{tool}\"\n{changes}");
    let text = AssemblyText::open(&Document::new(Path::new("own.toml"), &text))?;
    Ok(text.resolve(&BTreeMap::new())?.assembly)
}

fn record(assembly: &Assembly, interval: f64) -> Record {
    let numerics = Numerics {
        relative_tolerance: Settings::default().relative_tolerance,
        sample_interval: Some(interval),
        ..Numerics::default()
    };
    simulate(assembly, &numerics).unwrap()
}

/// A tool with its bars and its cycle.
struct Tool {
    name: &'static str,
    input: BlowInput,
    record: Record,
}

impl Tool {
    /// The tools that drive a brad, a staple and a finish nail.
    fn all() -> [Self; 3] {
        let brad = "[staple]\nlength = \"25 mm\"\nmass = \"0.25 g\"\nforce = \"250 N\"\n[piston]\nstroke = \"40 mm\"\n\
                    [cycle.blow.staple.shank]\nlegs = 1\ndiameter = \"1.14 mm\"\nhead_diameter = \"1.6 mm\"\n";
        let tools = [
            ("brad", "stapler", brad),
            ("staple", "stapler", ""),
            ("finish nail", "gas_spring_nailer", ""),
        ];
        tools.map(|(name, tool, changes)| {
            let assembly = resolve(tool, changes).unwrap_or_else(|error| panic!("{error}; {}", error.help()));
            let input = BlowInput::of(&assembly, 0).unwrap();
            Self {
                name,
                input,
                record: record(&assembly, 4e-6),
            }
        })
    }

    fn blow(&self, input: &BlowInput) -> Blow {
        elastic_blow(input, &Course::of_record(input, &self.record).unwrap()).unwrap()
    }
}

#[test]
fn the_text_of_the_n80cb_has_the_blow_of_its_keys() {
    let (parameters, settings) = (elastic_n80cb(), Settings::default());
    let of_keys = {
        let record = simulate_keys(&parameters, &settings).unwrap();
        let input = nailnoise_dynamics::blow_input(&parameters).unwrap().unwrap();
        elastic_blow(&input, &Course::of_record(&input, &record.record).unwrap()).unwrap()
    };
    let assembly = n80cb_assembly(&parameters, settings.end, settings.tail);
    let record = record(&assembly, settings.sample_interval);
    let input = BlowInput::of(&assembly, 0).unwrap();
    let of_text = elastic_blow(&input, &Course::of_record(&input, &record).unwrap()).unwrap();
    assert_eq!((of_text.samples, of_text.contacts), (of_keys.samples, of_keys.contacts));
    let peak = of_keys
        .on_wood
        .iter()
        .fold(0.0, |peak: f64, force| peak.max(force.abs()));
    let pairs = of_text.on_wood.iter().zip(&of_keys.on_wood);
    let most = pairs.fold(0.0, |most: f64, (a, b)| most.max((a - b).abs()));
    assert!(most < 1e-9 * peak, "{most} N of {peak} N");
}

#[test]
fn momentum_and_energy_of_every_blow_balance() {
    for tool in Tool::all() {
        let blow = tool.blow(&tool.input);
        assert_eq!(blow.checks.len(), 2);
        for check in &blow.checks {
            assert!(check.ok && check.limit <= 1e-6, "{}: {check:?}", tool.name);
        }
        assert!(blow.contacts > 1, "{}: {} contacts", tool.name, blow.contacts);
        let [first, last] = blow.samples;
        let differs = |n: &usize| {
            blow.on_wood[*n] != tool.record.get(&format!("{}.force", tool.input.fastener.name)).unwrap()[*n]
        };
        assert!((first..last).any(|n| differs(&n)), "{}", tool.name);
    }
}

/// The impulse of bars a thousand times as stiff as steel is that of the plastic impact.
#[test]
fn rigid_bars_give_the_impulse_of_the_plastic_impact() {
    for tool in Tool::all() {
        for elements in [4, 16, 32] {
            let stiff = BlowInput {
                elements,
                ..stiffened(&tool.input)
            };
            let [elastic, cycle] = tool.blow(&stiff).impulses;
            let ratio = elastic / cycle;
            assert!(
                (ratio - 1.0).abs() < 0.01,
                "{}, {elements} elements: {ratio}",
                tool.name
            );
        }
    }
}

#[test]
fn bars_that_are_incomplete_are_refused_at_their_place() {
    for (changes, path, parts) in [
        (
            "[cycle.blow.staple.rod]\nreplace = true\nlength = \"60 mm\"\n",
            "cycle.blow.staple.rod",
            ["has no field `area`", "area = \"30 mm2\""],
        ),
        (
            "[cycle.blow.staple]\nshank = false\n",
            "cycle.blow.staple",
            ["has no field `shank`", "shank = { diameter = "],
        ),
        (
            "[cycle.blow.staple.shank]\nreplace = true\nlegs = 2\n",
            "cycle.blow.staple.shank",
            ["has no field `diameter`", "diameter = \"1.2 mm\""],
        ),
        (
            "[cycle.blow.staple.wood]\nreplace = true\nshear_speed = \"700 m/s\"\n",
            "cycle.blow.staple.wood",
            ["has no field `density`", "density = \"500 kg/m3\""],
        ),
        (
            "[cycle.blow.staple.rod]\nmodulus = \"207 MPa\"\n",
            "cycle.blow.staple.rod.modulus",
            ["allowed is", "correct the value or its unit"],
        ),
        (
            "[cycle.blow.stapel]\nrod = { length = \"60 mm\" }\n",
            "cycle.blow.stapel",
            ["not a known fastener", "did you mean \"staple\"?"],
        ),
    ] {
        let error = resolve("stapler", changes).unwrap_err();
        let message = format!("{error}; {}", error.help());
        assert_eq!(error.path, path, "{message}");
        assert!(error.at.line() > 0 && !error.at.file().is_empty());
        for part in parts {
            assert!(message.contains(part), "{message}\n  lacks: {part}");
        }
    }
}

/// The bars of any assembly keep momentum and energy, whatever drives them.
#[test]
fn the_blows_of_random_assemblies_balance() {
    let mut blows = 0;
    for seed in first_seed()..first_seed() + 100 {
        let text = random_assembly(&mut Random::new(seed));
        let document = Document::new(Path::new("random.toml"), &text);
        let assembly = AssemblyText::open(&document)
            .unwrap()
            .resolve(&BTreeMap::new())
            .unwrap()
            .assembly;
        let Some(mut input) = BlowInput::of(&assembly, 0) else {
            continue;
        };
        // The fasteners are short; few elements make long steps.
        input.elements = 4;
        let numerics = Numerics {
            sample_interval: Some(10e-6),
            ..Numerics::default()
        };
        let Ok(record) = simulate(&assembly, &numerics) else {
            continue;
        };
        let blow = Course::of_record(&input, &record).and_then(|course| elastic_blow(&input, &course));
        if let Some(blow) = blow {
            assert!(
                blow.checks.iter().all(|check| check.ok),
                "{seed}: {:?}\n{text}",
                blow.checks
            );
            blows += 1;
        }
    }
    assert!(blows > 10, "{blows} blows");
}
