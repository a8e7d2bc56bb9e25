//! Surface pressures in compact form.

use nalgebra::{Complex, DMatrix};
use serde::{Deserialize, Serialize};

/// Adding 1.5 x 2^52 rounds to the nearest integer, which is then in the lowest bits.
const NEAREST: f64 = 6_755_399_441_055_744.0;

/// The pressure of one parity on a surface, unknowns x modes, with 16 bits per number, because hundreds of frequencies
/// are stored in memory and in files. The rounding error, 1.5e-5 of the mode's largest value, is comparable to the
/// error of the equations.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub(crate) struct PackedPressure {
    unknowns: usize,
    /// Largest value of each mode, divided by [`i16::MAX`].
    scales: Vec<f32>,
    /// Interleaved real and imaginary parts, divided by the scale of the mode.
    #[serde(with = "crate::blocks")]
    parts: Vec<i16>,
}

impl PackedPressure {
    pub(crate) fn new(pressure: &DMatrix<Complex<f64>>) -> Self {
        let (mut scales, mut parts) = (Vec::new(), vec![0; 2 * pressure.len()]);
        let rows = pressure.nrows().max(1);
        let columns = pressure.as_slice().chunks_exact(rows);
        for (column, packed) in columns.zip(parts.chunks_exact_mut(2 * rows)) {
            scales.push(pack(column, packed));
        }
        scales.resize(pressure.ncols(), f32::MIN_POSITIVE);
        Self {
            unknowns: pressure.nrows(),
            scales,
            parts,
        }
    }

    pub(crate) fn unpack(&self) -> DMatrix<Complex<f64>> {
        let (parts, _) = self.parts.as_chunks::<2>();
        DMatrix::from_fn(self.unknowns, self.scales.len(), |row, mode| {
            let scale = f64::from(self.scales[mode]);
            let part = parts.get(mode * self.unknowns + row).copied().unwrap_or_default();
            let [re, im] = part.map(f64::from);
            Complex::new(scale * re, scale * im)
        })
    }
}

/// Returns the scale of a mode, and writes its values divided by the scale.
fn pack(mode: &[Complex<f64>], packed: &mut [i16]) -> f32 {
    // Comparisons are used instead of `f64::max`, which handles NaN and therefore needs several instructions.
    let larger = |a: f64, b: f64| if b > a { b } else { a };
    let [re, im] = mode.iter().fold([0.0f64; 2], |[re, im], p| {
        [larger(re, p.re.abs()), larger(im, p.im.abs())]
    });
    let scale = (larger(re, im) / f64::from(i16::MAX)).max(f64::from(f32::MIN_POSITIVE)) as f32;
    let inverse = 1.0 / f64::from(scale);
    let nearest = |part: f64| (part * inverse + NEAREST).to_bits() as i16;
    for (p, to) in mode.iter().zip(packed.as_chunks_mut().0) {
        *to = [nearest(p.re), nearest(p.im)];
    }
    scale
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn packed_pressures_are_within_their_rounding() {
        let pressure = DMatrix::from_fn(40, 3, |row, mode| {
            let amplitude = [1e-12, 0.0, 3e7][mode];
            Complex::from_polar(amplitude * (1.0 + row as f64), 0.7 * row as f64)
        });
        let unpacked = PackedPressure::new(&pressure).unpack();
        for (found, expected) in unpacked.column_iter().zip(pressure.column_iter()) {
            let largest = expected.iter().map(|p| p.norm()).fold(0.0, f64::max);
            let apart = (found - expected).iter().map(|p| p.norm()).fold(0.0, f64::max);
            assert!(apart <= 2.3e-5 * largest, "{apart:e} of {largest:e}");
        }
    }
}
