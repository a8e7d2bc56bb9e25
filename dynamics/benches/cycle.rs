//! Time of one 100 ms cycle on one core.

use nailnoise_dynamics::{CycleRecord, Method, Parameters, Settings, simulate};

fn main() {
    divan::main();
}

#[divan::bench(args = [Method::Bdf, Method::Esdirk34])]
fn base_design(method: Method) -> CycleRecord {
    let settings = Settings {
        method,
        tail: 1.0,
        ..Settings::default()
    };
    simulate(&Parameters::n80cb(), &settings).expect("the base design runs")
}

#[divan::bench]
fn published_all() -> CycleRecord {
    simulate(&Parameters::n80cb().published_all(), &Settings::default()).expect("the published model runs")
}
