use super::mixing::interpolate;
use std::f64::consts::PI;

/// First lg(U_j/c0) of the table, and its step.
const START: f64 = -0.4;
const STEP: f64 = 0.05;

/// Rows of the table, and the angle between two \[rad\].
const ROWS: usize = 19;
const ROW: f64 = PI / 18.0;

/// lg D at lg(U_j/c0) = -0.4 (0.05) 0.4, with one row for every 10 degrees of the angle from the upstream direction, 0
/// to 180.
#[rustfmt::skip]
const LG_D: [[f64; 17]; ROWS] = [
    [-0.48, -0.52, -0.55, -0.6, -0.63, -0.67, -0.72, -0.8, -0.86, -0.97, -1.09, -1.23, -1.34, -1.41, -1.46, -1.44,
        -1.37],
    [-0.46, -0.5, -0.53, -0.58, -0.61, -0.65, -0.7, -0.78, -0.84, -0.95, -1.07, -1.21, -1.32, -1.39, -1.44, -1.42,
        -1.35],
    [-0.43, -0.47, -0.5, -0.55, -0.58, -0.62, -0.67, -0.75, -0.81, -0.92, -1.04, -1.18, -1.29, -1.36, -1.41, -1.39,
        -1.32],
    [-0.39, -0.43, -0.46, -0.51, -0.55, -0.59, -0.64, -0.72, -0.8, -0.91, -1.03, -1.15, -1.27, -1.32, -1.37, -1.36,
        -1.3],
    [-0.37, -0.38, -0.42, -0.46, -0.51, -0.54, -0.6, -0.68, -0.77, -0.88, -1.02, -1.13, -1.23, -1.29, -1.32, -1.31,
        -1.26],
    [-0.34, -0.35, -0.37, -0.43, -0.48, -0.51, -0.56, -0.65, -0.74, -0.85, -1.0, -1.1, -1.18, -1.24, -1.27, -1.25,
        -1.21],
    [-0.29, -0.33, -0.33, -0.4, -0.43, -0.47, -0.51, -0.59, -0.7, -0.81, -0.97, -1.05, -1.13, -1.17, -1.2, -1.19,
        -1.15],
    [-0.25, -0.27, -0.29, -0.34, -0.38, -0.43, -0.47, -0.57, -0.64, -0.77, -0.91, -1.0, -1.05, -1.09, -1.11, -1.09,
        -1.05],
    [-0.21, -0.23, -0.24, -0.28, -0.32, -0.36, -0.41, -0.49, -0.57, -0.68, -0.82, -0.9, -0.96, -0.99, -1.0, -0.97,
        -0.92],
    [-0.14, -0.16, -0.19, -0.22, -0.25, -0.28, -0.33, -0.39, -0.47, -0.58, -0.69, -0.78, -0.83, -0.85, -0.85, -0.81,
        -0.75],
    [-0.07, -0.09, -0.1, -0.13, -0.15, -0.17, -0.21, -0.27, -0.32, -0.41, -0.53, -0.6, -0.65, -0.67, -0.64, -0.59,
        -0.5],
    [0.03, 0.02, 0.0, -0.02, -0.03, -0.04, -0.06, -0.09, -0.13, -0.2, -0.29, -0.35, -0.38, -0.36, -0.33, -0.25, -0.11],
    [0.14, 0.13, 0.13, 0.11, 0.12, 0.12, 0.13, 0.11, 0.09, 0.05, -0.01, -0.03, 0.0, 0.04, 0.12, 0.2, 0.31],
    [0.23, 0.24, 0.25, 0.25, 0.27, 0.29, 0.29, 0.31, 0.34, 0.32, 0.31, 0.35, 0.43, 0.52, 0.58, 0.63, 0.67],
    [0.31, 0.34, 0.35, 0.37, 0.38, 0.41, 0.44, 0.47, 0.52, 0.57, 0.6, 0.65, 0.69, 0.73, 0.74, 0.73, 0.63],
    [0.37, 0.39, 0.42, 0.45, 0.47, 0.51, 0.53, 0.58, 0.63, 0.7, 0.76, 0.77, 0.71, 0.65, 0.56, 0.49, 0.39],
    [0.4, 0.44, 0.47, 0.49, 0.51, 0.54, 0.56, 0.57, 0.61, 0.63, 0.67, 0.65, 0.58, 0.42, 0.24, 0.1, 0.0],
    [0.45, 0.46, 0.47, 0.51, 0.56, 0.59, 0.61, 0.56, 0.51, 0.45, 0.37, 0.35, 0.33, 0.17, 0.04, -0.11, -0.2],
    [0.45, 0.49, 0.52, 0.54, 0.56, 0.59, 0.61, 0.54, 0.46, 0.38, 0.27, 0.25, 0.23, 0.09, -0.01, -0.16, -0.25],
];

/// Directivity of a jet's mixing noise: the mean square pressure at an angle, relative to that of an omnidirectional
/// source of the same power.
///
/// ```text
/// <p^2> = rho0 c0 W D(theta) / (4 pi r^2)        1/2 int_0^pi D(theta) sin theta d theta = 1
/// ```
///
/// NASA TM-83199, sec. 8.4, after SAE ARP876; values as transcribed in MIT-LAE/pyNA, lg D linear between them. Because
/// the table has only two decimals, its mean over all directions differs from 1 by up to 0.25 dB. D is divided by that
/// mean, computed in closed form for the interpolated table, so that it redistributes power without changing the total.
#[derive(Debug, Clone, PartialEq)]
pub struct MixingDirectivity {
    /// ln D for every 10 degrees from the upstream direction.
    ln_d: [f64; ROWS],
    /// Mean of the table over all directions, before normalisation.
    table_mean: f64,
}

impl MixingDirectivity {
    /// Directivity at the jet speed lg(U_j/c0), clamped to -0.4 .. 0.4.
    pub fn new(lg_velocity: f64) -> Self {
        let mut ln_d = LG_D.map(|row| interpolate(&row, (lg_velocity - START) / STEP) * std::f64::consts::LN_10);
        let table_mean = mean(&ln_d);
        ln_d.iter_mut().for_each(|ln| *ln -= table_mean.ln());
        Self { ln_d, table_mean }
    }

    /// D at the angle `from_axis` between the direction of the jet and that of the observer \[rad\]; 0 is downstream.
    pub fn at(&self, from_axis: f64) -> f64 {
        interpolate(&self.ln_d, (PI - from_axis) / ROW).exp()
    }

    /// Mean of the published table over all directions.
    pub fn table_mean(&self) -> f64 {
        self.table_mean
    }
}

/// 1/2 int e^{ln D} sin phi d phi, where ln D is linear with slope a between the rows: int e^{a phi} sin phi d phi =
/// e^{a phi} (a sin phi - cos phi) / (1 + a^2).
fn mean(ln_d: &[f64; ROWS]) -> f64 {
    let piece = |(i, pair): (usize, &[f64])| {
        let a = (pair[1] - pair[0]) / ROW;
        let end = |ln: f64, phi: f64| ln.exp() * (a * phi.sin() - phi.cos());
        let from = i as f64 * ROW;
        (end(pair[1], from + ROW) - end(pair[0], from)) / (1.0 + a * a)
    };
    0.5 * ln_d.windows(2).enumerate().map(piece).sum::<f64>()
}
