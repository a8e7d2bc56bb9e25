//! Time of one 100 ms cycle on one core.

#[path = "../tests/common/mod.rs"]
mod common;

use nailnoise_dynamics::blow::{self, Course};
use nailnoise_dynamics::{BlowModel, CycleRecord, Method, Settings, blow_input, simulate};

use common::n80cb;

/// The command's allocator.
#[global_allocator]
static MEMORY: mimalloc::MiMalloc = mimalloc::MiMalloc;

fn main() {
    divan::main();
}

#[divan::bench(args = [Method::Switching, Method::Bdf, Method::Esdirk34])]
fn base_design(method: Method) -> CycleRecord {
    let settings = Settings {
        method,
        tail: 1.0,
        ..Settings::default()
    };
    simulate(&n80cb(), &settings).expect("the base design runs")
}

/// The integration alone.
#[divan::bench]
fn without_samples() -> CycleRecord {
    let settings = Settings {
        sample_interval: 1.0,
        tail: 1.0,
        ..Settings::default()
    };
    simulate(&n80cb(), &settings).expect("the base design runs")
}

/// A shot of `nailnoise calibrate`, which reads few samples.
#[divan::bench]
fn calibration_shot() -> CycleRecord {
    let settings = Settings {
        relative_tolerance: 3e-5,
        sample_interval: 5e-5,
        ..Settings::default()
    };
    simulate(&n80cb(), &settings).expect("the base design runs")
}

/// The bars of an elastic blow, after the cycle.
#[divan::bench]
fn elastic_blow(bencher: divan::Bencher<'_, '_>) {
    let mut parameters = n80cb();
    parameters.model.blow = BlowModel::Elastic;
    let record = simulate(&parameters, &Settings::default()).expect("the base design runs");
    let input = blow_input(&parameters)
        .expect("a complete input")
        .expect("an elastic blow");
    bencher.bench(|| blow::elastic_blow(&input, &Course::of_record(&input, &record.record).expect("a strike")));
}

#[divan::bench]
fn published_all() -> CycleRecord {
    simulate(&n80cb().published_all(), &Settings::default()).expect("the published model runs")
}
