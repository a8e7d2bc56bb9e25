//! Pressures on a surface, packed.

use nalgebra::{Complex, DMatrix};
use serde::{Deserialize, Serialize};

/// The pressure of one parity on a surface, unknowns x modes, in 16 bits a number: its rounding, 1.5e-5 of the mode's largest
/// part, is far below the error of the equations, and hundreds of frequencies are held and kept.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub(crate) struct PackedPressure {
    unknowns: usize,
    /// Largest part of each mode, over [`i16::MAX`].
    scales: Vec<f32>,
    /// Real and imaginary parts, interleaved, over the scale of the mode.
    #[serde(with = "crate::blocks")]
    parts: Vec<i16>,
}

impl PackedPressure {
    pub(crate) fn new(pressure: &DMatrix<Complex<f64>>) -> Self {
        let (mut scales, mut parts) = (Vec::new(), Vec::with_capacity(2 * pressure.len()));
        for column in pressure.column_iter() {
            let largest = column.iter().map(|p| p.re.abs().max(p.im.abs())).fold(0.0, f64::max);
            let scale = (largest / f64::from(i16::MAX)).max(f64::from(f32::MIN_POSITIVE)) as f32;
            let packed = |part: f64| (part / f64::from(scale)).round() as i16;
            parts.extend(column.iter().flat_map(|p| [packed(p.re), packed(p.im)]));
            scales.push(scale);
        }
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
