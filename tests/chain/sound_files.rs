//! Files of sound at the microphones: they agree with `microphones.csv` and `microphones-bands.csv`, read as a user
//! reads them.

use std::collections::BTreeMap;
use std::sync::LazyLock;

use nailnoise::Design;
use nailnoise::chain::{Chain, Options};
use nailnoise::measurement::recordings::{Selector, decode};
use nailnoise::output::{Exports, RunView, of_run};
use nailnoise_acoustics::signals::fourier::RealTransform;
use nailnoise_acoustics::signals::{Weighting, band_containing, energy_weights};

use crate::common::{design, graph, run as of, small, store};

const RATE: f64 = 48_000.0;

/// Length of the transforms, twice that of the longest file.
const LENGTH: usize = 1 << 18;

/// Reference exposure (20 uPa)² s.
const REFERENCE: f64 = 4e-10;

/// A table by column.
type Rows = Vec<BTreeMap<String, String>>;

/// The files of a run, read back.
struct Files {
    levels: Rows,
    bands: Rows,
    /// Pressure by source and microphone, from 1 \[Pa\].
    sounds: BTreeMap<(String, usize), Vec<f64>>,
    about: String,
    range: [f64; 2],
    area: f64,
}

fn rows(text: &str) -> Rows {
    let mut lines = text.lines().map(|line| line.split(',').map(str::to_owned));
    let header: Vec<String> = lines.next().unwrap().collect();
    lines.map(|line| header.iter().cloned().zip(line).collect()).collect()
}

impl Files {
    fn new(design: &Design) -> Self {
        let run = &of(design);
        let view = RunView {
            design,
            run,
            exports: Exports::default(),
            report: &String::new,
        };
        let files = of_run(&view).unwrap();
        let content = |name: &str| {
            &files
                .iter()
                .find(|file| file.path.to_str() == Some(name))
                .unwrap()
                .content
        };
        let text = |name: &str| String::from_utf8(content(name).clone()).unwrap();
        let levels = rows(&text("microphones.csv"));
        let read = |row: &BTreeMap<String, String>| {
            let (source, microphone) = (row["source"].clone(), row["microphone"].parse().unwrap());
            let path = format!("microphones/{source}-{microphone}.wav");
            let tracks = decode(content(&path), path.as_ref(), &[&Selector::Channel(1)]).unwrap();
            let scale = number(row, "full scale of the file [Pa]");
            let pressure = tracks[0].samples.iter().map(|sample| scale * sample).collect();
            ((source, microphone), pressure)
        };
        Self {
            sounds: levels.iter().map(read).collect(),
            range: ["range from [Hz]", "range to [Hz]"].map(|column| number(&levels[0], column)),
            bands: rows(&text("microphones-bands.csv")),
            about: text("microphones/about.txt"),
            area: run.microphones.report.area_m2,
            levels,
        }
    }

    fn sound(&self, row: &BTreeMap<String, String>) -> &[f64] {
        &self.sounds[&(row["source"].clone(), row["microphone"].parse().unwrap())]
    }
}

fn number(row: &BTreeMap<String, String>, column: &str) -> f64 {
    row[column].parse().unwrap()
}

/// Exposure of a signal between two frequencies \[Pa² s\].
fn exposure(signal: &[f64], range: [f64; 2], weighting: Weighting) -> f64 {
    let transform = RealTransform::new(LENGTH);
    let frequency: Vec<f64> = (0..=LENGTH / 2).map(|k| k as f64 * RATE / LENGTH as f64).collect();
    let weights = energy_weights(&frequency, range, weighting);
    let lines = transform.lines(signal);
    let pairs = weights.iter().zip(&lines);
    pairs.map(|(w, x)| w * 2.0 * x.norm_sqr() / (RATE * RATE)).sum()
}

fn decibels(ratio: f64) -> f64 {
    10.0 * ratio.log10()
}

/// Boundary elements up to 400 Hz, in a range up to 2 kHz.
static BEM: LazyLock<Files> = LazyLock::new(|| Files::new(&design("tests/data/small-bem.toml")));
/// Workpiece by ERP, body as a sphere.
static ERP: LazyLock<Files> = LazyLock::new(|| Files::new(&small("")));

fn all() -> [&'static Files; 2] {
    [&*BEM, &*ERP]
}

#[test]
fn each_file_has_the_exposure_of_its_row() {
    for files in all() {
        assert_eq!(files.levels.len(), 36);
        for row in &files.levels {
            let found: f64 = files.sound(row).iter().map(|p| p * p / RATE).sum();
            let apart = decibels(found / REFERENCE) - number(row, "L_E [dB]");
            assert!(
                apart.abs() < 0.05,
                "{} {}: {apart} dB",
                row["source"],
                row["microphone"]
            );
        }
    }
}

#[test]
fn each_file_has_the_a_weighted_exposure_of_its_row() {
    for files in all() {
        for row in &files.levels {
            let found = exposure(files.sound(row), files.range, Weighting::A);
            let apart = decibels(found / REFERENCE) - number(row, "L_AE [dB]");
            assert!(
                apart.abs() < 0.15,
                "{} {}: {apart} dB",
                row["source"],
                row["microphone"]
            );
        }
    }
}

#[test]
fn nine_files_have_the_power_of_each_band() {
    for files in all() {
        for row in &files.bands {
            let band = band_containing(number(row, "band [Hz]"));
            let of = |number: usize| {
                let signal = &files.sounds[&(row["source"].clone(), number)];
                exposure(signal, [band.low, band.high], Weighting::Z)
            };
            let mean = (1..=9).map(of).sum::<f64>() / 9.0;
            let Ok(stated) = row["microphones L_W [dB]"].parse::<f64>() else {
                continue;
            };
            let apart = decibels(mean / REFERENCE * files.area) - stated;
            assert!(
                apart.abs() < 0.1,
                "{} {} Hz: {apart} dB",
                row["source"],
                row["band [Hz]"]
            );
        }
    }
}

#[test]
fn bands_of_each_source_reach_the_top_of_the_range() {
    for files in all() {
        for source in ["workpiece", "exhaust", "body"] {
            let own = files.bands.iter().filter(|row| row["source"] == source);
            let last = own.map(|row| number(row, "band [Hz]")).fold(0.0, f64::max);
            // The band of 2 kHz reaches beyond 2 kHz.
            assert_eq!((files.range[1], last), (2000.0, 1600.0), "{source}");
        }
    }
}

#[test]
fn a_file_holds_almost_nothing_outside_the_range() {
    for files in all() {
        for row in &files.levels {
            let signal = files.sound(row);
            let [low, high] = files.range;
            let outside =
                [[0.0, 0.8 * low], [1.1 * high, 0.5 * RATE]].map(|range| exposure(signal, range, Weighting::Z));
            let share = outside.iter().sum::<f64>() / exposure(signal, files.range, Weighting::Z);
            assert!(share < 5e-3, "{} {}: {share}", row["source"], row["microphone"]);
        }
    }
}

#[test]
fn the_files_of_the_sources_sum_to_that_of_the_total() {
    for files in all() {
        let step = number(&files.levels[0], "full scale of the file [Pa]") / 8_388_607.0;
        for microphone in 1..=9 {
            let own =
                ["total", "workpiece", "exhaust", "body"].map(|name| &files.sounds[&(name.to_owned(), microphone)]);
            for n in 0..own[0].len() {
                let parts: f64 = own[1..].iter().map(|signal| signal[n]).sum();
                assert!((parts - own[0][n]).abs() <= 2.1 * step, "{microphone}, sample {n}");
            }
        }
    }
}

#[test]
fn a_synthetic_part_is_marked_in_table_and_note() {
    let from = |files: &Files, source: &str| {
        let row = files.levels.iter().find(|row| row["source"] == source).unwrap();
        row["synthetic from [Hz]"].parse::<f64>().ok()
    };
    // Pressures fade over a third of an octave below the highest frequency of the boundary elements.
    let faded = from(&BEM, "workpiece").unwrap();
    assert!(
        (faded / (400.0 * 2f64.powf(-1.0 / 3.0)) - 1.0).abs() < 0.02,
        "{faded} Hz"
    );
    assert_eq!(from(&BEM, "total"), Some(faded));
    assert!(
        BEM.about.contains(&format!("synthetic above {faded} Hz")),
        "{}",
        BEM.about
    );
    assert_eq!((from(&ERP, "workpiece"), from(&ERP, "body")), (Some(50.0), None));
    assert!(ERP.about.contains("phases chosen"), "{}", ERP.about);
}

#[test]
fn a_synthetic_part_follows_the_power_over_time() {
    let row = BEM.levels.iter().find(|row| row["source"] == "workpiece").unwrap();
    let signal = BEM.sound(row);
    // The blow comes some 10 ms after the trigger; before it there is only what resonances and edges of bands spread,
    // as the noise is shaped without phase. Steady noise would have a twentieth there.
    let transform = RealTransform::new(LENGTH);
    let mut lines = transform.lines(signal);
    for (k, x) in lines.iter_mut().enumerate() {
        if (k as f64 * RATE / LENGTH as f64) < 500.0 {
            *x = Default::default();
        }
    }
    let above = transform.signal(lines);
    let energy = |from: f64, to: f64| -> f64 {
        let samples = [from, to].map(|time| (time * RATE) as usize);
        above[samples[0]..samples[1]].iter().map(|p| p * p).sum()
    };
    let share = energy(0.0, 5e-3) / energy(0.0, 0.1);
    assert!(share < 5e-3, "{share}");
}

#[test]
fn another_seed_draws_other_sound_with_the_same_levels() {
    let design = design("tests/data/small-bem.toml");
    let run = |noise_seed: u32| {
        let options = Options {
            noise_seed,
            ..Options::default()
        };
        let run = Chain::new(&graph(store()), &design, options)
            .unwrap()
            .run(&design)
            .unwrap();
        run.microphones
    };
    let [one, two] = [0, 1].map(run);
    let signal = |own: &nailnoise::stages::microphones::Microphones, place: usize| own.signals[place].1[0].clone();
    for (place, (a, b)) in one.report.sources.iter().zip(&two.report.sources).enumerate() {
        // The body is a sphere, whose phases are known.
        let drawn = a.source != "body";
        assert!((signal(&one, place) != signal(&two, place)) == drawn, "{}", a.source);
        for (a, b) in a.levels.iter().zip(&b.levels) {
            assert!((a.lae_db.unwrap() - b.lae_db.unwrap()).abs() < 1e-9);
        }
    }
}
