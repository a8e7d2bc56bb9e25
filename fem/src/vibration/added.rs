//! Motion that a linear correction adds to the result of the time integration.

use std::f64::consts::TAU;
use std::fmt;
use std::ops::Range;
use std::sync::Arc;

use nalgebra::{Complex, DMatrix};
use realfft::{ComplexToReal, RealFftPlanner};

use super::model::Motion;

/// Motion beyond that of the time integration, given by spectral lines at the complex frequencies s_k = sigma + j 2 pi
/// k/(N h). The motion is
///
///   d_n = e^{sigma t_n}/N sum_k D_k e^{j omega_k t_n},    d' and d'': D_k times s_k and s_k^2,
///
/// summed over both signs of the frequency. N is the length of the transform in samples, and h the step.
#[derive(Clone)]
pub struct AddedMotion {
    /// Lines k = 0, 1, ... of each body (modes x lines).
    lines: Vec<DMatrix<Complex<f64>>>,
    step: f64,
    length: usize,
    sigma: f64,
    inverse: Arc<dyn ComplexToReal<f64>>,
}

impl AddedMotion {
    /// Creates the motion from the lines of each body (modes x lines, below half the length), the step \[s\], the
    /// length of the transform \[samples\] and sigma \[1/s\].
    pub fn new(lines: Vec<DMatrix<Complex<f64>>>, step: f64, length: usize, sigma: f64) -> Self {
        Self {
            lines,
            step,
            length,
            sigma,
            inverse: RealFftPlanner::new().plan_fft_inverse(length),
        }
    }

    /// Number of modes of a body; 0 for a body without lines.
    pub(super) fn modes(&self, body: usize) -> usize {
        self.lines.get(body).map_or(0, DMatrix::nrows)
    }

    /// The motion of some modes of a body for the first `samples` samples, samples x modes.
    pub fn records(&self, body: usize, modes: Range<usize>, samples: usize, motion: Motion) -> DMatrix<f64> {
        let chosen = self.lines[body].rows(modes.start, modes.len()).into_owned();
        self.records_of(&chosen, samples, motion)
    }

    /// The motion of points of a body, given the mode shapes at the points (modes x points): samples x points.
    pub fn of_points(&self, body: usize, shapes: &DMatrix<f64>, samples: usize, motion: Motion) -> DMatrix<f64> {
        let lines = &self.lines[body];
        let [re, im] = [lines.map(|x| x.re), lines.map(|x| x.im)].map(|part| shapes.transpose() * part);
        self.records_of(&re.zip_map(&im, Complex::new), samples, motion)
    }

    /// The motion of arbitrary lines, one row each, for the first `samples` samples: samples x rows.
    fn records_of(&self, lines: &DMatrix<Complex<f64>>, samples: usize, motion: Motion) -> DMatrix<f64> {
        let mut records = DMatrix::zeros(samples, lines.nrows());
        let mut spectrum = self.inverse.make_input_vec();
        let mut record = self.inverse.make_output_vec();
        for (row, mut to) in records.column_iter_mut().enumerate() {
            spectrum.fill(Complex::default());
            for (k, line) in spectrum.iter_mut().enumerate().take(lines.ncols()) {
                *line = lines[(row, k)] * self.factor(k, motion);
            }
            spectrum[0].im = 0.0;
            if let Some(last) = spectrum.last_mut() {
                last.im = 0.0;
            }
            let done = self.inverse.process(&mut spectrum, &mut record);
            debug_assert!(done.is_ok(), "buffers of the plan's own lengths");
            for (n, (to, x)) in to.iter_mut().zip(&record).enumerate() {
                *to = x * self.growth(n);
            }
        }
        records
    }

    /// The motion of all modes of a body at one sample.
    pub(super) fn at(&self, body: usize, sample: usize, motion: Motion) -> Vec<f64> {
        let lines = &self.lines[body];
        let mut sum = vec![Complex::<f64>::default(); lines.nrows()];
        for (k, column) in lines.column_iter().enumerate() {
            // Whole turns are removed from the phase, so that it remains exact.
            let turns = (k * sample % self.length) as f64 / self.length as f64;
            let both_signs = if k == 0 { 1.0 } else { 2.0 };
            let factor = Complex::from_polar(both_signs, TAU * turns) * self.factor(k, motion);
            sum.iter_mut()
                .zip(column.iter())
                .for_each(|(sum, line)| *sum += line * factor);
        }
        sum.into_iter().map(|x| x.re * self.growth(sample)).collect()
    }

    fn factor(&self, line: usize, motion: Motion) -> Complex<f64> {
        let s = Complex::new(self.sigma, TAU * line as f64 / (self.length as f64 * self.step));
        match motion {
            Motion::Displacement => Complex::from(1.0),
            Motion::Velocity => s,
            Motion::Acceleration => s * s,
        }
    }

    /// e^{sigma t}/N.
    fn growth(&self, sample: usize) -> f64 {
        (self.sigma * self.step * sample as f64).exp() / self.length as f64
    }
}

impl fmt::Debug for AddedMotion {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("AddedMotion")
            .field("step", &self.step)
            .field("length", &self.length)
            .field("sigma", &self.sigma)
            .finish_non_exhaustive()
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]

    use super::*;
    use crate::vibration::{Loads, ModalBody, ModalResponse, Settings, Start, respond};

    /// A body with two freely oscillating modes, and the same with lines added at the third and fifth frequency.
    fn responses() -> (ModalResponse, ModalResponse) {
        let body = ModalBody {
            name: "body".into(),
            omega: vec![1000.0, 3000.0],
            zeta: vec![0.01; 2],
            loads: DMatrix::from_element(2, 1, 1.0),
            supports: DMatrix::zeros(2, 0),
        };
        let settings = Settings {
            duration: 2e-3,
            decay: f64::INFINITY,
            start: Start::Rest,
            require_contact: false,
            ..Settings::default()
        };
        let plain = respond(&[body], &[], &Loads::constant(&[1.0]), &settings).unwrap();
        let lines = DMatrix::from_fn(2, 6, |i, k| match k {
            3 => Complex::new(1.0, i as f64),
            5 => Complex::new(0.3, -0.2),
            _ => Complex::default(),
        });
        let added = AddedMotion::new(vec![lines], plain.step, 1200, 40.0);
        (plain.clone(), plain.with_added(added).unwrap())
    }

    const MOTIONS: [Motion; 3] = [Motion::Displacement, Motion::Velocity, Motion::Acceleration];

    #[test]
    fn an_added_motion_is_the_sum_of_its_lines_however_it_is_asked_for() {
        let (plain, added) = responses();
        let shapes = DMatrix::from_row_slice(2, 1, &[0.7, -0.4]);
        for motion in MOTIONS {
            let whole = added.modal(0, 0..2, motion).unwrap();
            let difference = &whole - plain.modal(0, 0..2, motion).unwrap();
            let size = difference.amax();
            for n in [0, 7, 450] {
                for i in 0..2 {
                    let line = |k: usize, d: Complex<f64>| {
                        let s = Complex::new(40.0, TAU * k as f64 / (1200.0 * plain.step));
                        let power = MOTIONS.iter().position(|other| *other == motion).unwrap() as i32;
                        2.0 / 1200.0 * (d * s.powi(power) * (s * plain.step * n as f64).exp()).re
                    };
                    let expected = line(3, Complex::new(1.0, i as f64)) + line(5, Complex::new(0.3, -0.2));
                    assert!((difference[(n, i)] - expected).abs() < 1e-9 * size, "{motion:?}");
                }
            }
            let at = added.at(0, &[450], motion).unwrap();
            assert!(
                (at - whole.row(450).transpose()).amax() < 1e-9 * whole.amax(),
                "{motion:?}"
            );
            let points = added.points(0, &shapes, motion).unwrap();
            assert!((points - &whole * &shapes).amax() < 1e-9 * whole.amax(), "{motion:?}");
        }
    }

    #[test]
    fn velocity_and_acceleration_are_the_derivatives_of_the_displacement() {
        let (_, added) = responses();
        let of = |motion| added.modal(0, 0..1, motion).unwrap();
        for [motion, rate] in [[MOTIONS[0], MOTIONS[1]], [MOTIONS[1], MOTIONS[2]]] {
            let (x, rate) = (of(motion), of(rate));
            for n in 1..x.len() - 1 {
                let slope = (x[n + 1] - x[n - 1]) / (2.0 * added.step);
                assert!((slope - rate[n]).abs() < 1e-2 * rate.amax(), "{motion:?}, sample {n}");
            }
        }
    }
}
