//! Time of a transient run of 0.3 s with steps of 4 us and 65 contact points, and of its replay.

#[path = "../tests/common/block_on_table.rs"]
mod block_on_table;

use divan::Bencher;
use nailnoise_fem::vibration::{Motion, Settings, SupportLaw, respond};

fn main() {
    divan::main();
}

fn full() -> Settings {
    Settings {
        decay: f64::INFINITY,
        ..Settings::default()
    }
}

/// Numbers of block and table modes: first the 300 modes of the requirement (3 s), then the default design.
const SIZES: [(usize, usize); 2] = [(100, 200), (160, 500)];

#[divan::bench(args = SIZES, sample_count = 3)]
fn unilateral(bencher: Bencher, (block, table): (usize, usize)) {
    let case = block_on_table::block_on_table(block, table, SupportLaw::Unilateral);
    bencher.bench_local(|| respond(&case.bodies, &case.supports, &case.loads, &full()));
}

#[divan::bench(args = SIZES, sample_count = 3)]
fn bonded(bencher: Bencher, (block, table): (usize, usize)) {
    let case = block_on_table::block_on_table(block, table, SupportLaw::Bonded);
    bencher.bench_local(|| respond(&case.bodies, &case.supports, &case.loads, &full()));
}

#[divan::bench(sample_count = 3)]
fn replay_500_modes(bencher: Bencher) {
    let case = block_on_table::block_on_table(160, 500, SupportLaw::Unilateral);
    let Ok(response) = respond(&case.bodies, &case.supports, &case.loads, &full()) else {
        return;
    };
    bencher.bench_local(|| response.modal(1, 0..500, Motion::Acceleration));
}
