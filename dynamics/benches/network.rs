//! Time of networks on one core: the 100 ms cycle of the N80CB, and chains of volumes, passages and bodies.

#[path = "../tests/common/assembly.rs"]
mod assembly;
#[path = "../tests/common/chain.rs"]
mod chain;
#[path = "../tests/common/mod.rs"]
mod common;
#[path = "../tests/common/n80cb_assembly.rs"]
mod n80cb_assembly;

use nailnoise_dynamics::network::{Numerics, Record, simulate};

use common::n80cb;

/// The command's allocator.
#[global_allocator]
static MEMORY: mimalloc::MiMalloc = mimalloc::MiMalloc;

fn main() {
    divan::main();
}

#[divan::bench(args = [false, true])]
fn n80cb_100_ms(samples: bool) -> Record {
    let numerics = Numerics {
        sample_interval: samples.then_some(4e-6),
        ..Numerics::default()
    };
    let assembly = n80cb_assembly::n80cb_assembly(&n80cb(), 0.1, 1.0);
    simulate(&assembly, &numerics).expect("the base design runs")
}

#[divan::bench(args = [1, 2, 4, 8, 16])]
fn chain_of_volumes(bencher: divan::Bencher<'_, '_>, count: usize) {
    let assembly = chain::chain(count);
    let numerics = Numerics {
        sample_interval: None,
        ..Numerics::default()
    };
    let steps = simulate(&assembly, &numerics).expect("the chain runs").work.steps;
    bencher
        .counter(divan::counter::ItemsCount::new(steps))
        .bench(|| simulate(&assembly, &numerics).expect("the chain runs"));
}
