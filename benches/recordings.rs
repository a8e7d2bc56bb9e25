//! Time to read recordings of one second at 160 kHz: nine channels of WAV, and one of each text format.

use std::f64::consts::TAU;
use std::path::Path;

use divan::Bencher;
use nailnoise::measurement::recordings::wav::{Coding, encode};
use nailnoise::measurement::recordings::{Selector, decode};
use nailnoise_meshes::uff::{History, Ordinate};

const RATE: u32 = 160_000;

fn main() {
    divan::main();
}

fn signal() -> Vec<f64> {
    (0..RATE)
        .map(|i| 3.0 * (TAU * 777.7 * f64::from(i) / f64::from(RATE)).sin())
        .collect()
}

fn read(bencher: Bencher<'_, '_>, bytes: &[u8], selectors: &[Selector]) {
    let selectors: Vec<&Selector> = selectors.iter().collect();
    bencher.bench(|| decode(bytes, Path::new("bench"), &selectors).map(|tracks| tracks.len()));
}

#[divan::bench]
fn wav_of_nine_channels(bencher: Bencher<'_, '_>) {
    let signal = signal();
    let bytes = encode(&[&signal[..]; 9], RATE, 5.0, Coding::Integer24).unwrap_or_default();
    read(bencher, &bytes, &(1..=9).map(Selector::Channel).collect::<Vec<_>>());
}

#[divan::bench]
fn universal_file_in_text(bencher: Bencher<'_, '_>) {
    let values = signal();
    let mut bytes = Vec::new();
    let history = History {
        title: "N",
        origin: "bench",
        sensor: "N",
        node: 1,
        ordinate: Ordinate::Acceleration,
        interval: 1.0 / f64::from(RATE),
        values: &values,
    };
    history.write(&mut bytes);
    read(bencher, &bytes, &[Selector::Channel(1)]);
}

#[divan::bench]
fn csv_of_one_column(bencher: Bencher<'_, '_>) {
    let row = |(index, value): (usize, &f64)| format!("{:.9},{value}\n", index as f64 / f64::from(RATE));
    let rows: String = signal().iter().enumerate().map(row).collect();
    let text = format!("time [s],N [g]\n{rows}");
    read(bencher, text.as_bytes(), &[Selector::Column("N".to_owned())]);
}
