//! A-weighting compared with IEC 61672-1:2013, table 3: `cargo run --release --example 05_a_weighting`.

use nailnoise_acoustics::signals::Weighting;

fn main() {
    for (nominal, place, printed) in [(100, -10, -19.1), (1000, 0, 0.0), (10_000, 10, -2.5)] {
        // The table refers to exact frequencies, not nominal ones.
        let weight = Weighting::A.db(1000.0 * 10f64.powf(0.1 * f64::from(place)));
        println!("{nominal} Hz: {weight:.2} dB, printed {printed} dB");
        assert!((weight - printed).abs() < 0.05 + 1e-9);
    }
}
