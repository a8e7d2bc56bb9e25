//! Pressure transducers of the design as tested.

use nailnoise::Design;
use nailnoise::chain::{Chain, Options};
use nailnoise::graph::Graph;
use nailnoise::stages::transducers::PressureRecord;
use nailnoise_dynamics::CycleRecord;

use crate::common::{ROOT, small};

/// The readings of both transducers without a loss of charge, and the cycle.
fn readings() -> (Vec<PressureRecord>, CycleRecord) {
    let mut design = Design::load(format!("{ROOT}/designs/n80cb-as-tested.toml")).unwrap();
    for own in design.transducers.values_mut() {
        own.discharge_time = 1e9;
    }
    let chain = Chain::new(&Graph::default(), &design, Options::default()).unwrap();
    let readings = chain.transducers.get().unwrap();
    (Vec::clone(&readings), nailnoise::chain::cycle(&design).unwrap())
}

#[test]
fn a_transducer_in_the_cylinder_reads_above_the_piston_from_t7_to_t15_and_below_it_at_all_other_times() {
    let (readings, record) = readings();
    let reading = readings.iter().find(|own| own.name == "PT-I").unwrap();
    assert_eq!(
        (reading.interval, reading.values.len()),
        (record.sample_interval(), record.len())
    );
    let [t7, t15] = [record.figures.events.t7.unwrap(), record.figures.events.t15.unwrap()];
    let (above, below) = (
        record.history("above_piston.pressure"),
        record.history("below_piston.pressure"),
    );
    let mut apart: f64 = 0.0;
    for (n, value) in reading.values.iter().enumerate() {
        let time = record.time(n);
        // The sample at the passage itself belongs to either.
        if [t7, t15]
            .iter()
            .any(|event| (time - event).abs() <= record.sample_interval())
        {
            continue;
        }
        let volume = if t7 < time && time < t15 { above } else { below };
        assert!((value - (volume[n] - below[0])).abs() < 1.0, "{time} s");
        apart = apart.max((above[n] - below[n]).abs());
    }
    assert!(apart > 1e5, "the volumes differ by {apart} Pa");
}

#[test]
fn a_transducer_in_the_return_chamber_reads_its_change_of_pressure() {
    let (readings, record) = readings();
    let reading = readings.iter().find(|own| own.name == "PT-R").unwrap();
    let pressure = record.history("return_volume.pressure");
    let most = reading.values.iter().fold(0.0, |most: f64, value| most.max(*value));
    assert!(most > 1e4, "{most} Pa");
    for (value, p) in reading.values.iter().zip(pressure) {
        assert!((value - (p - pressure[0])).abs() < 1.0);
    }
}

/// Readings of transducers in these chambers without a loss of charge.
fn in_chambers(design: &str, chambers: &[&str]) -> Result<Vec<PressureRecord>, nailnoise::Error> {
    let transducer = |(n, chamber): (usize, &&str)| {
        format!("[transducers.P{n}]\nchamber = \"{chamber}\"\nposition = \"30 mm\"\ndischarge_time = \"1 s\"\n")
    };
    let transducers: String = chambers.iter().enumerate().map(transducer).collect();
    let mut design = small(&format!("{design}\n{transducers}"));
    for own in design.transducers.values_mut() {
        own.discharge_time = 1e9;
    }
    let chain = Chain::new(&Graph::default(), &design, Options::default())?;
    Ok(Vec::clone(&chain.transducers.get().unwrap()))
}

#[test]
fn a_transducer_in_a_volume_of_the_cycle_reads_its_change_of_pressure() {
    let chambers = [
        "above_piston",
        "below_piston",
        "return_volume",
        "above_valve",
        "supply",
        "return",
    ];
    let readings = in_chambers("", &chambers).unwrap();
    let record = nailnoise::chain::cycle(&small("")).unwrap();
    let volumes = [
        "above_piston",
        "below_piston",
        "return_volume",
        "above_valve",
        "supply",
        "return_volume",
    ];
    for (reading, volume) in readings.iter().zip(volumes) {
        let pressure = record.history(&format!("{volume}.pressure"));
        for (value, p) in reading.values.iter().zip(pressure) {
            assert!((value - (p - pressure[0])).abs() < 1.0, "{}", reading.name);
        }
    }
}

#[test]
fn the_transducers_of_an_assembly_are_in_its_volumes() {
    let stapler = "[cycle]\nassembly = \"stapler\"";
    let readings = in_chambers(stapler, &["above", "return"]).unwrap();
    let names: Vec<&str> = readings.iter().map(|own| own.name.as_str()).collect();
    assert_eq!(names, ["P0"], "a stapler has no return chamber");
    let shot = nailnoise::chain::shot(&small(stapler)).unwrap();
    let pressure = shot.volume_pressure("above").unwrap();
    for (value, p) in readings[0].values.iter().zip(pressure) {
        assert!((value - (p - pressure[0])).abs() < 1.0);
    }
    assert!(readings[0].values.iter().any(|value| *value > 1e5));
    let message = in_chambers(stapler, &["abov"]).unwrap_err().to_string();
    assert!(message.contains("the cycle has no volume of this name"), "{message}");
}
