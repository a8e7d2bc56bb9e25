//! A trigger acts at the instant of the word for which it waits, also where the word does not switch a mode.

use std::collections::BTreeMap;
use std::path::Path;

use nailnoise_documents::Document;
use nailnoise_dynamics::network::{AssemblyText, KeyValue, Numerics, Record, simulate, simulate_balanced};

use crate::runs::HEAD;

fn resolved(blocks: &str) -> nailnoise_dynamics::network::Assembly {
    let document = Document::new(Path::new("own.toml"), &format!("{HEAD}{blocks}"));
    let text = AssemblyText::open(&document).unwrap_or_else(|error| panic!("{error}"));
    let resolved = text.resolve(&BTreeMap::<String, KeyValue>::new());
    resolved
        .unwrap_or_else(|error| panic!("{error}; {}", error.help()))
        .assembly
}

fn record(blocks: &str) -> Record {
    simulate(&resolved(blocks), &Numerics::default()).unwrap_or_else(|error| panic!("{error}"))
}

/// Time of the first entry of the log with this block and word \[s\].
fn time(record: &Record, block: &str, word: &str) -> f64 {
    let mut log = record.log.iter();
    let entry = log.find(|entry| entry.block == block && entry.word == word);
    entry.unwrap_or_else(|| panic!("no {block} {word}")).time
}

/// The record of a vessel that a hose fills until the flow unchokes, with further fields of the gate, and the times at
/// which the flow unchokes and the gate shuts \[s\].
fn filled(gate: &str) -> (Record, [f64; 2]) {
    let record = record(&format!(
        r#"reservoir.hose = {{ pressure = "6 barg", temperature = "20 degC" }}
volume.vessel = {{ dead = "100 cm3", pressure = "101.325 kPa" }}
trigger.filling = {{ starts = true, clear = "inlet unchoked" }}
[cycle.passage.inlet]
between = ["hose", "vessel"]
area = "10 mm2"
open = {{ when = "filling"{gate} }}
"#
    ));
    let times = ["unchoked", "gate shuts"].map(|word| time(&record, "inlet", word));
    (record, times)
}

/// The flow unchokes at P/P_hose = (2/2.4)^3.5 = 0.5283.
#[test]
fn a_gate_shuts_as_its_flow_unchokes() {
    let (record, [unchoked, shuts]) = filled("");
    assert!((shuts - unchoked).abs() < 1e-9, "{unchoked} s, {shuts} s");
    let pressure = record.get("vessel.pressure").and_then(<[f64]>::last).copied().unwrap();
    let expected = 701.325e3 * (2.0f64 / 2.4).powf(3.5);
    assert!((pressure / expected - 1.0).abs() < 1e-6, "{pressure} Pa, {expected} Pa");
}

/// The narrow nozzle behind a wide valve unchokes, and the words are those of the passage.
#[test]
fn a_series_unchokes_as_a_passage() {
    let record = record(
        r#"volume.vessel = { dead = "20 cm3", pressure = "7 barg" }
[cycle.passage.gun]
between = ["vessel", "atmosphere"]
series = [{ name = "valve", area = "12 mm2" }, { name = "nozzle", area = "7 mm2" }]
silent = true
[cycle.event]
unchoked = { becomes = "gun unchoked" }
"#,
    );
    let unchoked = record.log.iter().find(|entry| entry.word == "unchoked").unwrap();
    assert_eq!((unchoked.block.as_str(), unchoked.restriction.as_str()), ("gun", ""));
    assert_eq!(record.event("unchoked"), Some(unchoked.time));
}

/// A ball thrown up at v turns at t = v/g and v^2/(2 g) above its start.
const THROWN: &str = r#"gravity = "9.81 m/s2"
body.ball = { mass = "1 kg", start = { travel = "0 mm", speed = "-0.2 m/s" } }
trigger.top.set = "ball reverses"
hold.latch = { on = "ball", stiffness = "5 kN/mm", while = "top" }
"#;

#[test]
fn a_latch_catches_a_body_where_it_turns() {
    let record = record(THROWN);
    let caught = time(&record, "latch", "catches");
    assert!((caught - 0.2 / 9.81).abs() < 1e-9, "{caught} s");
    let travel = record.get("ball.travel").and_then(<[f64]>::last).copied().unwrap();
    assert!((travel + 0.2 * 0.2 / (2.0 * 9.81)).abs() < 1e-5, "{travel} m");
}

#[test]
fn a_delay_begins_at_the_word() {
    let (_, [unchoked, shuts]) = filled(r#", delay = "10 us", before = true"#);
    assert!((shuts - unchoked - 1e-5).abs() < 1e-9, "{unchoked} s, {shuts} s");
}

/// A body that rings on a latch.
#[test]
fn a_run_whose_balance_drifts_is_repeated_at_a_smaller_tolerance() {
    let assembly = resolved(&THROWN.replace(
        "trigger.top.set = \"ball reverses\"",
        "trigger.top.schedule = [[\"10 ms\", true]]",
    ));
    let numerics = Numerics::default();
    let [plain, balanced] = [simulate, simulate_balanced].map(|run| run(&assembly, &numerics).unwrap());
    assert!(plain.checks.iter().any(|check| !check.ok), "{:?}", plain.checks);
    assert!(balanced.checks.iter().all(|check| check.ok), "{:?}", balanced.checks);
}
