//! Interpolation over frequency: the equations are assembled at some frequencies and interpolated at the others.
//!
//! The operators are integrals of e^{-jkr} times polynomials in k, where r ranges from 0 to the largest distance D
//! between two points, including images. After division by the common phase e^{-jkD/2}, the n-th derivative of e^{-jkr}
//! is at most (D/2)^n. The interpolation polynomial through n wavenumbers k_i therefore differs from it by at most
//! (Davis, Interpolation and Approximation, 1963, section 3.1)
//!
//! ```text
//! prod_i |k - k_i| (D/2)^n / n!
//! ```
//!
//! Each additional power of k raises the derivatives by a factor of about 1 + n / (k D/2). There is one power in K, and
//! there are two in W, or in K if the equations are multiplied by k.
//!
//! Resonances of the air do not slow the convergence, because they arise in the inverse of the matrix. A common factor
//! on both sides does not change the solution. The phase is therefore divided out; where the coupling parameter is
//! -j/k, the equations are also multiplied by k. In the transition range of the coupling, the equations are not
//! interpolated.

use super::neumann::NeumannData;
use super::problem::{Coupling, Exterior, Threads};
use crate::bem::operators::equations::Sums;
use nalgebra::Complex;
use pulp::Arch;

/// Largest error of interpolated equations relative to an entry, by the estimate above.
const TOLERANCE: f64 = 1e-5;
/// Largest sum of the weights' magnitudes, which amplifies rounding.
const LEBESGUE: f64 = 30.0;
/// Largest memory for the equations of a surface \[bytes\].
const MEMORY: usize = 450_000_000;
/// Typical number of frequencies whose equations are cached.
const USUAL_FREQUENCIES: f64 = 25.0;

/// Equations of a surface at several frequencies.
#[derive(Debug)]
pub(crate) struct EquationSweep {
    /// D/2 \[m\].
    half_distance: f64,
    kept: Vec<Kept>,
    bytes: usize,
}

/// The equations of one frequency without their common phase.
#[derive(Debug)]
struct Kept {
    k: f64,
    coupling: Coupling,
    /// Values for each parity, see [`Sums::flat`]; empty until assembled.
    values: Vec<Vec<f32>>,
}

/// How the equations of a frequency are obtained.
#[derive(Debug)]
pub(crate) enum Origin {
    /// Assembled from the kernels, and cached under this number if given.
    Assemble(Option<usize>),
    /// Interpolated from cached equations with these weights.
    Interpolate(Vec<(usize, f32)>),
}

impl EquationSweep {
    pub(crate) fn new(problem: &Exterior) -> Self {
        Self {
            half_distance: 0.5 * problem.boundary().longest_path(),
            kept: Vec::new(),
            bytes: 0,
        }
    }

    /// Plans how to obtain the equations of some frequencies: the frequency with the largest estimated error is
    /// assembled first, until all others can be interpolated.
    pub(crate) fn plan(&mut self, problem: &Exterior, hz: &[f64], data: &[NeumannData]) -> Vec<Origin> {
        let n = problem.boundary().nodes();
        let bytes: usize = data.iter().map(|data| 8 * n * (n + data.columns())).sum();
        self.make_room(problem, hz, bytes);
        let mut ways: Vec<Option<Origin>> = hz.iter().map(|_| None).collect();
        loop {
            let open = (0..hz.len()).filter(|&i| ways[i].is_none());
            let found = open.map(|i| (i, self.weights(problem.wavenumber(hz[i]), problem.coupling(hz[i]))));
            let worst = found.max_by(|(_, a), (_, b)| a.0.total_cmp(&b.0));
            let Some((worst, (error, weights))) = worst else { break };
            let way = if error <= TOLERANCE {
                Origin::Interpolate(weights)
            } else {
                let keeps = problem.coupling(hz[worst]) != Coupling::Transition && self.bytes + bytes <= MEMORY;
                Origin::Assemble(keeps.then(|| {
                    self.bytes += bytes;
                    self.kept.push(Kept {
                        k: problem.wavenumber(hz[worst]),
                        coupling: problem.coupling(hz[worst]),
                        values: Vec::new(),
                    });
                    self.kept.len() - 1
                }))
            };
            ways[worst] = Some(way);
        }
        ways.into_iter().flatten().collect()
    }

    /// If the equations of new frequencies do not fit in memory, drops cached ones outside their range, the most
    /// distant first.
    fn make_room(&mut self, problem: &Exterior, hz: &[f64], bytes: usize) {
        let k = hz.iter().map(|&hz| problem.wavenumber(hz));
        let (low, high) = k.fold((f64::INFINITY, 0.0), |(low, high), k| (k.min(low), k.max(high)));
        let outside = |kept: &Kept| (low - kept.k).max(kept.k - high);
        while self.bytes + hz.len() * bytes > MEMORY {
            let distances = self.kept.iter().map(outside).enumerate();
            let Some((number, distance)) = distances.max_by(|(_, a), (_, b)| a.total_cmp(b)) else {
                break;
            };
            if distance <= 0.0 {
                break;
            }
            self.kept.remove(number);
            self.bytes -= bytes;
        }
    }

    /// The equations at a frequency, divided by their common phase factor for storage in the cache.
    pub(crate) fn without_phase(&self, problem: &Exterior, hz: f64, sums: &[Sums]) -> Vec<Vec<f32>> {
        let k = problem.wavenumber(hz);
        let size = if problem.coupling(hz) == Coupling::Inverse {
            k
        } else {
            1.0
        };
        let factor = Complex::from_polar(size, k * self.half_distance);
        sums.iter().map(|sums| sums.flat(factor)).collect()
    }

    /// Caches equations under a number from [`Self::plan`].
    pub(crate) fn keep(&mut self, number: usize, values: Vec<Vec<f32>>) {
        self.kept[number].values = values;
    }

    /// Interpolated equations, up to the factor of [`Self::without_phase`].
    pub(crate) fn interpolate(&self, problem: &Exterior, weights: &[(usize, f32)], threads: Threads) -> Vec<Sums> {
        let parities = weights.first().map_or(0, |(number, _)| self.kept[*number].values.len());
        let of_parity = |parity: usize| {
            let known: Vec<(&[f32], f32)> = weights
                .iter()
                .map(|&(number, weight)| (&self.kept[number].values[parity][..], weight))
                .collect();
            let n = problem.boundary().nodes();
            let patterns = known[0].0.len() / (2 * n) - n;
            Sums::from_flat([n, patterns], |start, to| {
                Arch::new().dispatch(|| combine(&known, start, to));
            })
        };
        threads.map((0..parities).collect(), of_parity)
    }

    /// Estimated interpolation error at a wavenumber, and the weights of the cached equations: as many of the nearest
    /// ones as needed.
    fn weights(&self, k: f64, coupling: Coupling) -> (f64, Vec<(usize, f32)>) {
        let alike = |(_, kept): &(usize, &Kept)| kept.coupling == coupling && coupling != Coupling::Transition;
        let mut nodes: Vec<(usize, f64)> = self
            .kept
            .iter()
            .enumerate()
            .filter(alike)
            .map(|(i, kept)| (i, kept.k))
            .collect();
        nodes.sort_by(|a, b| (a.1 - k).abs().total_cmp(&(b.1 - k).abs()));
        let powers = if coupling == Coupling::None { 1 } else { 2 };
        let growth = |count: usize| (1.0 + count as f64 / (k * self.half_distance)).powi(powers);
        let (mut of_phase, mut count) = (1.0, 0);
        while of_phase * growth(count) > TOLERANCE && count < nodes.len() {
            count += 1;
            of_phase *= (nodes[count - 1].1 - k).abs() * self.half_distance / count as f64;
        }
        let error: f64 = of_phase * growth(count);
        nodes.truncate(count);
        let weight = |&(i, own): &(usize, f64)| {
            let others = nodes.iter().filter(|(j, _)| *j != i);
            let weight: f64 = others.map(|(_, other)| (k - other) / (own - other)).product();
            (i, weight)
        };
        let weights: Vec<(usize, f64)> = nodes.iter().map(weight).collect();
        let lebesgue: f64 = weights.iter().map(|(_, w)| w.abs()).sum();
        let error = if lebesgue > LEBESGUE { error.max(1.0) } else { error };
        (error, weights.into_iter().map(|(i, w)| (i, w as f32)).collect())
    }
}

/// Adds up arrays times their weights from `start` onwards; inlined, so that it is compiled for the processor's
/// instruction set.
#[inline(always)]
fn combine(known: &[(&[f32], f32)], start: usize, to: &mut [f32]) {
    to.fill(0.0);
    for (from, weight) in known {
        let from = &from[start..][..to.len()];
        to.iter_mut().zip(from).for_each(|(to, from)| *to += weight * from);
    }
}

impl Exterior {
    /// Approximate memory of the cached equations \[bytes\] if many frequencies are interpolated, with this many
    /// patterns in every parity; none with a compressed matrix.
    pub fn bytes_of_kept_equations(&self, patterns: usize) -> f64 {
        let (n, copies) = (self.boundary().nodes() as f64, self.boundary().copies() as f64);
        let bytes = USUAL_FREQUENCIES * copies * 8.0 * n * (n + patterns as f64);
        if self.is_compressed() {
            0.0
        } else {
            bytes.min(MEMORY as f64)
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::air::Air;
    use crate::bem::mesh::boundary::Boundary;
    use crate::bem::mesh::boxes::SolidBox;
    use crate::bem::mesh::panel::BoundaryMesh;
    use crate::bem::mesh::symmetry::Parity;
    use crate::bem::solve::neumann::Patterns;
    use crate::bem::solve::problem::SurfacePressure;
    use nalgebra::DMatrix;

    /// Half of a box of 0.5 m with the given thickness \[m\] above the floor, in both parities about its mirror plane.
    fn problem(thickness: f64) -> (Exterior, Vec<NeumannData>) {
        let (mirrors, floor) = ([Some(0.0), None], 0.0);
        let block = SolidBox {
            low: [-0.25, -0.2, 0.3],
            high: [0.25, 0.2, 0.3 + thickness],
            part: 0,
        };
        let planes = [mirrors[0], mirrors[1], Some(floor)];
        let mesh = BoundaryMesh::of_boxes(&[block], planes, 0.04, vec!["all".to_owned()], |_| 0).unwrap();
        let boundary = Boundary::symmetric(mesh, mirrors, Some(floor)).unwrap();
        let air = Air::default();
        let data = [false, true].map(|odd_x| {
            let velocities = boundary.project(3, |_, _, point, v| {
                let x = point.position;
                let odd = if odd_x { x.x } else { 1.0 };
                for (m, v) in v.iter_mut().enumerate() {
                    *v = odd * (5.0 * m as f64 * x.z + 3.0 * x.y).cos();
                }
            });
            let parity = Parity { odd_x, odd_y: false };
            Patterns { parity, velocities }
        });
        let problem = Exterior::new(boundary, &air);
        let data = data.iter().map(|p| problem.neumann_data(p).unwrap()).collect();
        (problem, data)
    }

    /// Largest difference in a pattern's pressure, relative to its largest value.
    fn difference(found: &[SurfacePressure], exact: &[SurfacePressure]) -> f64 {
        let norm = |p: &DMatrix<Complex<f64>>, m: usize| p.column(m).iter().map(|z| z.norm()).fold(0.0, f64::max);
        let of_pattern = |(found, exact): (&SurfacePressure, &SurfacePressure), m: usize| {
            norm(&(&found.pressure - &exact.pressure), m) / norm(&exact.pressure, m)
        };
        let pairs = found.iter().zip(exact).flat_map(|pair| (0..3).map(move |m| (pair, m)));
        pairs.map(|(pair, m)| of_pattern(pair, m)).fold(0.0, f64::max)
    }

    /// Solves 20 frequencies of a range with interpolation where possible; returns the number of frequencies assembled,
    /// and the largest difference of the others from a direct solution.
    fn interpolated(thickness: f64, range: impl Fn(f64) -> [f64; 2]) -> (usize, f64) {
        let (problem, data) = problem(thickness);
        let mut sweep = EquationSweep::new(&problem);
        let [low, high] = range(problem.lowest_resonance());
        let hz: Vec<f64> = (0..20).map(|i| low + (high - low) * f64::from(i) / 19.0).collect();
        let ways = sweep.plan(&problem, &hz, &data);
        let (mut assembled, mut worst) = (0, 0.0_f64);
        for (&hz, way) in hz.iter().zip(&ways) {
            if let Origin::Assemble(number) = way {
                let sums = problem.equations(hz, &data, Threads::One).unwrap();
                let values = sweep.without_phase(&problem, hz, &sums);
                sweep.keep(number.unwrap(), values);
                assembled += 1;
            }
        }
        for (&hz, way) in hz.iter().zip(&ways) {
            if let Origin::Interpolate(weights) = way {
                let found = problem.solutions(
                    hz,
                    sweep.interpolate(&problem, weights, Threads::One),
                    &data,
                    Threads::One,
                );
                let exact = problem.solve_prepared(hz, &data, Threads::One).unwrap();
                let error = difference(&found, &exact);
                println!("{hz:7.1} Hz: {} weights, {error:.1e}", weights.len());
                worst = worst.max(error);
            }
        }
        println!("{assembled} of {} assembled, {worst:.1e}", hz.len());
        (assembled, worst)
    }

    #[test]
    fn interpolated_equations_have_the_solutions_of_assembled_ones() {
        let below = interpolated(0.2, |resonance| [20.0, 0.49 * resonance]);
        assert!(below.0 <= 12 && below.1 < 2e-5, "{below:?}");
        let above = interpolated(0.2, |resonance| [0.91 * resonance, 1.4 * resonance]);
        assert!(above.0 <= 15 && above.1 < 2e-5, "{above:?}");
    }

    #[test]
    fn equations_of_a_thin_plate_are_interpolated_as_well() {
        let thin = interpolated(0.01, |_| [20.0, 1400.0]);
        assert!(thin.0 <= 17 && thin.1 < 2e-5, "{thin:?}");
    }

    #[test]
    fn halves_of_the_blocks_add_up_to_all() {
        let (problem, data) = problem(0.2);
        assert!(problem.blocks().len() > 1);
        let [all, halves] =
            [Threads::One, Threads::Two].map(|threads| problem.equations(600.0, &data, threads).unwrap());
        for (all, halves) in all.iter().zip(&halves) {
            let pairs = all
                .flat(Complex::from(1.0))
                .into_iter()
                .zip(halves.flat(Complex::from(1.0)));
            let apart = pairs.clone().map(|(a, b)| (a - b).abs()).fold(0.0, f32::max);
            let largest = pairs.map(|(a, _)| a.abs()).fold(0.0, f32::max);
            assert!(apart < 1e-6 * largest, "{apart:e} of {largest:e}");
        }
    }

    #[test]
    fn equations_are_assembled_while_the_coupling_sets_in() {
        let (problem, data) = problem(0.2);
        let mut sweep = EquationSweep::new(&problem);
        let hz: Vec<f64> = (0..30)
            .map(|i| problem.lowest_resonance() * (0.55 + 0.01 * f64::from(i)))
            .collect();
        let ways = sweep.plan(&problem, &hz, &data);
        assert!(ways.iter().all(|way| matches!(way, Origin::Assemble(None))), "{ways:?}");
    }
}
