//! Hidden twins: tools are drawn from the ranges, measured with the stated errors, and calibrated. In 90 % of the
//! cases, the 90 % intervals should contain the hidden inputs and figures.
//!
//! ```sh
//! export NAILNOISE_TWINS=0..20 NAILNOISE_TWINS_STORE=/tmp/twins
//! cargo test --release --lib hidden_twins -- --ignored --nocapture
//! ```
//!
//! An interrupted twin is resumed from the store. `NAILNOISE_TWINS_WRONG=drive` multiplies one reading by 1.3.
#![allow(clippy::unwrap_used)]

use std::fmt::Write as _;
use std::path::{Path, PathBuf};

use nailnoise_documents::Document;

use super::check::Truth;
use super::key::key;
use super::measurements::Measurements;
use super::posterior::{Calibration, Request, Treatment};
use super::quantities::Quantity;
use super::random::standard_normal;
use super::reader::Reader;
use super::result::{CalibrationResult, result};
use super::tool::Tool;
use crate::design::{Assignment, Design};
use crate::stages::{Progress, Silent};
use crate::store::Store;
use crate::study::Drawn;

/// Three depths, air, three times, a speed and a pressure, at three supply pressures.
const FILE: &str = r#"
schema = "nailnoise-calibration/1"
[instrument]
gauge = { error = "1 %" }
[condition.96]
set = { "supply.pressure" = "96 psig" }
instrument = { "supply.pressure" = "gauge" }
outcome = "drives"
[condition.70]
set = { "supply.pressure" = "70 psig" }
instrument = { "supply.pressure" = "gauge" }
[condition.110]
set = { "supply.pressure" = "110 psig" }
instrument = { "supply.pressure" = "gauge" }
[measured.depth-96]
condition = "96"
quantity = "head_depth"
value = "<0> m"
scatter = "1.5 mm"
shots = 5
error = "0.2 mm"
[measured.depth-70]
condition = "70"
quantity = "head_depth"
value = "<1> m"
scatter = "1.5 mm"
shots = 5
error = "0.2 mm"
[measured.depth-110]
condition = "110"
quantity = "head_depth"
value = "<2> m"
scatter = "1.5 mm"
shots = 5
error = "0.2 mm"
[measured.air]
condition = "96"
quantity = "air_per_shot"
value = "<3> m3"
scatter = "1 %"
shots = 1
error = "4 %"
[measured.drive]
condition = "96"
quantity = "interval"
events = ["t6", "t9"]
value = "<4> s"
scatter = "3 %"
shots = 5
error = "0.1 ms"
[measured.valve]
condition = "96"
quantity = "interval"
events = ["t0", "t6"]
value = "<5> s"
scatter = "3 %"
shots = 5
error = "0.2 ms"
[measured.blow]
condition = "96"
quantity = "interval"
events = ["t6", "t14"]
value = "<6> s"
scatter = "3 %"
shots = 5
error = "0.2 ms"
[measured.speed]
condition = "96"
quantity = "mean_drive_speed"
value = "<7> m/s"
scatter = "3 %"
shots = 5
error = "2 %"
[measured.p1]
condition = "96"
quantity = "peak_pressure"
of = "above_piston"
value = "<8> Pa"
scatter = "1 %"
shots = 1
error = "2 %"
"#;

/// A seed different from those of calibrations.
const HIDDEN: u64 = 0x71D5_EED5;

fn measurements(design: &Design, text: &str) -> Measurements {
    let with = |own: &[Assignment]| Design::load_with(design.path(), own);
    Reader {
        design,
        assembly: None,
        with: &with,
    }
    .read(&Document::new(Path::new("twin.toml"), text))
    .unwrap()
}

/// The text filled with these readings.
fn filled(readings: &[f64]) -> String {
    let mut text = FILE.to_owned();
    for (k, reading) in readings.iter().enumerate() {
        text = text.replace(&format!("<{k}>"), &format!("{reading:e}"));
    }
    text
}

/// A hidden tool that drives the nail and whose exhaust ends within the record, and its readings without errors.
fn hidden_tool(tool: &Tool, measured: &Measurements, twin: u64) -> (Vec<f64>, Vec<f64>) {
    let likelihood = super::tool::likelihood(tool, measured, &[], &Default::default()).unwrap();
    let truth = Truth::draw(tool, &likelihood, (1 + twin, HIDDEN ^ twin)).unwrap();
    let values = truth.predictions.iter().map(|own| own.value()).collect();
    (truth.z, values)
}

/// The true values with errors as stated in the file.
fn readings(tool: &Tool, measured: &Measurements, z: &[f64], truth: &[f64], twin: u64) -> Vec<f64> {
    let likelihood = super::tool::likelihood(tool, measured, &[], &Default::default()).unwrap();
    let error = |k: usize| {
        let e = standard_normal(HIDDEN.rotate_left(9) ^ twin, 1, k as u64);
        likelihood.data()[k].scale * e + likelihood.shared(k, z)
    };
    truth.iter().enumerate().map(|(k, truth)| truth + error(k)).collect()
}

fn calibrated(design: &Design, text: &str, store: &Store, seed: u64) -> CalibrationResult {
    let measured = measurements(design, text);
    let request = Request {
        draws: std::env::var("NAILNOISE_TWINS_DRAWS").map_or(512, |own| own.parse().unwrap()),
        moves: 24,
        seed,
        hold_out: Vec::new(),
        treatment: Treatment::LeaveOut,
        next: false,
        levels: 128,
        redraw: Vec::new(),
    };
    let tool = Tool::new(design, &measured, seed).unwrap();
    let calibration = Calibration {
        key: key(design, &tool, &measured, &request),
        tool,
        measured: &measured,
        request: &request,
        store,
        progress: &Progress::to(std::sync::Arc::new(Silent)),
    };
    let posterior = calibration.posterior(Vec::new()).unwrap();
    result(&posterior, design, &measured, &request, "twin.toml").0
}

#[test]
#[ignore = "minutes a twin"]
fn hidden_twins_are_covered() {
    let range = std::env::var("NAILNOISE_TWINS").unwrap_or_else(|_| "0..1".to_owned());
    let (first, end) = range.split_once("..").unwrap();
    let wrong = std::env::var("NAILNOISE_TWINS_WRONG").ok();
    let store = std::env::var("NAILNOISE_TWINS_STORE").map_or_else(
        |_| Store::none(),
        |folder| Store::shared(&PathBuf::from(folder)).unwrap(),
    );
    let design = Design::load(concat!(env!("CARGO_MANIFEST_DIR"), "/designs/n80cb.toml")).unwrap();
    // Percentage errors refer to typical values.
    let typical = filled(&[0.0, -5e-3, 3e-3, 1.2e-3, 4e-3, 12e-3, 50e-3, 20.0, 6e5]);
    let (mut inputs, mut figures, mut counted) = ([0, 0], [0, 0], 0);
    for twin in first.parse::<u64>().unwrap()..end.parse().unwrap() {
        let begin = std::time::Instant::now();
        let measured = measurements(&design, &typical);
        let tool = Tool::new(&design, &measured, HIDDEN).unwrap();
        let (z, truth) = hidden_tool(&tool, &measured, twin);
        let measured = measurements(&design, &filled(&truth));
        let mut read = readings(&tool, &measured, &z, &truth, twin);
        if let Some(name) = &wrong {
            let k = measured.data.iter().position(|own| own.name == *name).unwrap();
            assert_ne!(measured.data[k].quantity, Quantity::HeadDepth, "a depth has no ratio");
            read[k] *= 1.3;
        }
        let result = calibrated(&design, &filled(&read), &store, 1 + twin);
        let hidden_figures = tool.figures_at(&design, std::iter::once(z.as_slice())).remove(0);
        let point = tool.point(&z);
        let within = |value: f64, [low, high]: [f64; 2]| usize::from((low..=high).contains(&value));
        let mut own = [0, 0];
        for (variable, share) in tool.sampler.variables().iter().zip(&point.shares) {
            let row = result.inputs.iter().find(|own| own.name == variable.name).unwrap();
            if let Drawn::Value(crate::design::Value::Number(value)) = variable.at(*share) {
                own = [own[0] + within(value, row.now), own[1] + 1];
            }
        }
        let pairs = result
            .figures
            .iter()
            .zip(&hidden_figures)
            .filter(|(_, truth)| truth.is_finite());
        let of_figures = pairs.fold([0, 0], |[hit, all], (row, truth)| {
            [hit + within(*truth, [row.now[0], row.now[2]]), all + 1]
        });
        let mut line = String::new();
        for row in &result.figures {
            write!(
                line,
                " {:.2}",
                (row.now[2] - row.now[0]) / (row.before[2] - row.before[0])
            )
            .unwrap();
        }
        let named: Vec<_> = result
            .conflicts
            .iter()
            .map(|own| (&own.measurement, &own.partner, own.probability))
            .collect();
        println!(
            "twin {twin}: converged {} {:?}; inputs {own:?}, figures {of_figures:?}; halves {:.2}, ancestors {}, \
             candidates {}, {:?}, {:.0} s; ratios{line}; conflicts {named:?}",
            result.converged,
            result.faults,
            result.halves_apart,
            result.ancestors,
            result.candidates,
            result.work,
            begin.elapsed().as_secs_f64()
        );
        if result.converged {
            counted += 1;
            inputs = [inputs[0] + own[0], inputs[1] + own[1]];
            figures = [figures[0] + of_figures[0], figures[1] + of_figures[1]];
        }
    }
    let share = |[hit, all]: [usize; 2]| hit as f64 / all as f64;
    println!(
        "{counted} converged: inputs {:.3}, figures {:.3}",
        share(inputs),
        share(figures)
    );
    if wrong.is_none() && counted > 9 {
        assert!((0.8..=0.98).contains(&share(figures)), "coverage of figures");
    }
}
