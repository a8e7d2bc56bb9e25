use super::compressed::{Accuracy, CompressedSurface, Equations};
use super::cover::SurfaceCover;
use super::neumann::{NeumannData, Patterns};
use crate::air::Air;
use crate::bem::error::BemError;
use crate::bem::mesh::boundary::Boundary;
use crate::bem::mesh::panel::PanelShape;
use crate::bem::mesh::rules;
use crate::bem::mesh::symmetry::{Image, Parity};
use crate::bem::operators::blocks::{Block, blocks};
use crate::bem::operators::equations::Sums;
use crate::bem::operators::near::{NearAt, NearField};
use crate::bem::operators::tile::{RightHandSide, Tile};
use crate::bem::operators::wave::Wave;
use crate::checks::{InputError, positive};
use faer::Mat;
use nalgebra::{Complex, DMatrix};
use rayon::prelude::*;
use serde::Serialize;
use std::f64::consts::PI;
use std::sync::OnceLock;

/// Accuracy of the compressed equations.
const ACCURACY: Accuracy = Accuracy {
    block: 1e-4,
    residual: 1e-4,
};

/// The exterior problem of a surface, set up once for all frequencies.
///
/// G is e^{-jkr} / (4 pi r), plus that of the image in a rigid floor; n points into the air. The pressure p and its
/// normal derivative dp/dn = -j omega rho v_n satisfy the equation of Burton & Miller (1971).
///
/// ```text
/// (1/2 - K - alpha H) p = -(S + alpha (1/2 + K')) dp/dn        alpha = -j s(f) min(1/k, L_c)
/// ```
///
/// This equation has a unique solution at every frequency. Either half without the other fails at resonances of the
/// interior problem. Well below the lowest of these, the coupling is not needed. There, the derivative equation would
/// reduce the accuracy of the small resistance of rigid-body motion. For a block of 0.4 m at 100 Hz, the error would be
/// a factor of 2; without the derivative equation, it is 2e-4. Therefore s rises as sin² from 0 at f_box/2 to 1 at 0.9
/// f_box, where f_box is the lowest resonance of the bounding box; no body inside it has a lower one. The Galerkin
/// method is used with continuous linear (bilinear) pressure; the normal velocity is linear on each panel and
/// discontinuous between panels. The hypersingular operator is integrated by parts (Maue 1949, Nedelec 2001 section
/// 3.3.4).
///
/// ```text
/// <phi, H psi> = -int int G (curl phi . curl psi - k² n_x . n_y phi psi)        curl phi = n x grad phi
/// ```
///
/// A body on the floor and its image form a closed surface. With test functions that are even about the floor, the
/// contour terms of the two cancel. Mirror planes are treated likewise; for a field that is odd about a plane, the
/// functions vanish in that plane.
#[derive(Debug)]
pub struct Exterior {
    boundary: Boundary,
    air: Air,
    blocks: Vec<Block>,
    /// Computed on first access, because describing a surface does not require it.
    near: OnceLock<NearField>,
    coupling: f64,
    per_wavelength: f64,
    images: Vec<Image>,
    /// Integrals of phi_i phi_j over each panel.
    masses: Vec<[[f64; 4]; 4]>,
    equations: EquationSolver,
    compressed: OnceLock<CompressedSurface>,
    /// Porous layer on the surface.
    cover: Option<SurfaceCover>,
}

/// How the equations of a surface are stored and solved.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
pub enum EquationSolver {
    /// Compressed if, according to [`SurfaceSize::cost`](crate::bem::SurfaceSize::cost), that takes less than half the
    /// time of the dense matrix.
    #[default]
    Auto,
    /// A dense matrix and its LU factors.
    Dense,
    /// Distant blocks of the matrix as products of thin matrices, by adaptive cross approximation, with a block Krylov
    /// solver.
    Compressed,
}

impl EquationSolver {
    /// Whether the program chooses the solver.
    pub fn is_auto(&self) -> bool {
        *self == Self::Auto
    }
}

/// How many threads may work on one frequency. With two threads, the kernels are summed in two halves, so the equations
/// differ by rounding.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Threads {
    /// Used when every thread solves a different frequency. A thread that waited for part of one frequency would start
    /// another one, with its own matrices.
    One,
    /// Used when a single frequency is solved at a time.
    Two,
}

impl Threads {
    /// Applies a function to each parity of a frequency.
    pub(crate) fn map<T: Send, R: Send>(self, items: Vec<T>, of: impl Fn(T) -> R + Send + Sync) -> Vec<R> {
        match self {
            Self::One => items.into_iter().map(of).collect(),
            Self::Two => items.into_par_iter().map(of).collect(),
        }
    }
}

/// Dependence of the coupling parameter alpha on the wavenumber.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Coupling {
    /// Zero.
    None,
    /// Rising from zero.
    Transition,
    /// -j L_c.
    Constant,
    /// -j / k.
    Inverse,
}

/// The pressure on a surface for a set of velocity patterns.
#[derive(Clone, Debug)]
pub struct SurfacePressure {
    /// Frequency \[Hz\].
    pub hz: f64,
    /// Parity of the patterns.
    pub parity: Parity,
    /// Pressure per unit of each pattern, pressure unknowns x patterns \[Pa s/m for velocities in m/s\].
    pub pressure: DMatrix<Complex<f64>>,
}

impl Exterior {
    /// Sets up the problem; close pairs and the tables of their rules are computed on first use.
    pub fn new(mut boundary: Boundary, air: &Air) -> Self {
        let blocks = blocks(&mut boundary);
        let mesh = boundary.mesh();
        let masses = (0..mesh.panels.len())
            .map(|p| {
                let kind = mesh.panels[p].kind();
                let mut mass = [[0.0; 4]; 4];
                for (xi, w) in rules::fine(kind) {
                    let dw = w * mesh.point_at(p, xi).area_vector().norm();
                    let n = kind.linear().at(xi).n;
                    for i in 0..4 {
                        for j in 0..4 {
                            mass[i][j] += dw * n[i] * n[j];
                        }
                    }
                }
                mass
            })
            .collect();
        Self {
            coupling: boundary.half_width(),
            per_wavelength: 6.0,
            images: boundary.images(),
            boundary,
            air: *air,
            blocks,
            near: OnceLock::new(),
            masses,
            equations: EquationSolver::default(),
            compressed: OnceLock::new(),
            cover: None,
        }
    }

    pub(super) fn set_cover(&mut self, cover: SurfaceCover) {
        self.cover = Some(cover);
    }

    /// The porous layer on the surface.
    pub fn cover(&self) -> Option<&SurfaceCover> {
        self.cover.as_ref()
    }

    /// Sets how the equations are solved; the default is the cheaper method.
    #[must_use]
    pub fn with_equation_solver(mut self, solver: EquationSolver) -> Self {
        self.equations = solver;
        self
    }

    /// Sets the number of panels per wavelength below which frequencies are rejected; the default is six.
    ///
    /// # Errors
    /// If the number is not positive.
    pub fn with_panels_per_wavelength(mut self, number: f64) -> Result<Self, BemError> {
        self.per_wavelength = positive("panels per wavelength", number)?;
        Ok(self)
    }

    /// Integrates pairs of panels that touch or nearly touch in advance for all frequencies up to `highest_hz`, and
    /// interpolates over frequency with an error of about 1e-5. This saves time at the expense of memory if many
    /// frequencies are solved.
    pub fn with_near_field_cache(mut self, highest_hz: f64) -> Self {
        self.near();
        if let Some(near) = self.near.get_mut() {
            near.keep(&self.boundary, 2.0 * PI * highest_hz / self.air.sound_speed);
        }
        self
    }

    pub(crate) fn near(&self) -> &NearField {
        self.near.get_or_init(|| NearField::new(&self.boundary, &self.blocks))
    }

    /// Panels per wavelength below which frequencies are rejected.
    pub fn panels_per_wavelength(&self) -> f64 {
        self.per_wavelength
    }

    /// Lowest resonance of the bounding box of the surface (and its image, if it stands on the floor) with zero
    /// pressure on its walls \[Hz\]; no interior resonance is lower.
    pub fn lowest_resonance(&self) -> f64 {
        let mut sides = self.boundary.extents();
        if self.boundary.stands_on_floor() {
            sides.z *= 2.0;
        }
        0.5 * self.air.sound_speed * sides.iter().map(|l| l.powi(-2)).sum::<f64>().sqrt()
    }

    /// omega / c \[1/m\].
    pub(crate) fn wavenumber(&self, hz: f64) -> f64 {
        2.0 * PI * hz / self.air.sound_speed
    }

    /// Dependence of the coupling parameter on the wavenumber near a frequency.
    pub(crate) fn coupling(&self, hz: f64) -> Coupling {
        let share = self.coupling_share(hz);
        if share == 0.0 {
            Coupling::None
        } else if share < 1.0 {
            Coupling::Transition
        } else if self.wavenumber(hz) * self.coupling < 1.0 {
            Coupling::Constant
        } else {
            Coupling::Inverse
        }
    }

    /// The factor s(f) of the coupling parameter.
    fn coupling_share(&self, hz: f64) -> f64 {
        let t = ((hz / self.lowest_resonance() - 0.5) / 0.4).clamp(0.0, 1.0);
        (0.5 * PI * t).sin().powi(2)
    }

    pub(crate) fn check_resolution(&self, hz: f64) -> Result<(), BemError> {
        let highest = self.boundary.highest_hz(self.air.sound_speed, self.per_wavelength);
        // The limit itself is allowed, because it may be the upper end of a range.
        if hz <= highest * (1.0 + 1e-9) {
            return Ok(());
        }
        let edge = self.boundary.mesh().longest_edge();
        Err(BemError::TooCoarse {
            hz,
            edge,
            per_wavelength: self.air.sound_speed / (hz * edge),
            needed: self.per_wavelength,
            highest,
        })
    }

    pub(crate) fn blocks(&self) -> &[Block] {
        &self.blocks
    }

    /// The surface.
    pub fn boundary(&self) -> &Boundary {
        &self.boundary
    }

    /// The air.
    pub fn air(&self) -> &Air {
        &self.air
    }

    /// Number of panel pairs too close for the far rule.
    pub fn close_pairs(&self) -> usize {
        self.near().len()
    }

    /// Number of distinct shapes of those pairs; congruent pairs are integrated once.
    pub fn close_shapes(&self) -> usize {
        self.near().shapes()
    }

    /// Pressure on the surface at the frequency `hz` for normal velocities that are even about any mirror planes. The
    /// velocities are corner values of each panel x patterns, see [`Boundary::project`].
    ///
    /// # Errors
    /// If the frequency is not positive or above the limit of the mesh, or if the patterns have the wrong length.
    pub fn solve(&self, hz: f64, velocities: &DMatrix<f64>) -> Result<SurfacePressure, BemError> {
        only(self.solve_parities(hz, &[Patterns::even(velocities)])?)
    }

    /// Pressure on the surface for patterns of several parities, computed on one thread. The kernels are evaluated
    /// once, and each parity has one matrix and one factorisation for all its patterns.
    ///
    /// # Errors
    /// Same as [`Exterior::solve`].
    pub fn solve_parities(&self, hz: f64, patterns: &[Patterns]) -> Result<Vec<SurfacePressure>, BemError> {
        self.solve_prepared(hz, &self.prepared(hz, patterns)?, Threads::One)
    }

    /// Prepares patterns for the equations at a frequency that the mesh resolves.
    pub(crate) fn prepared(&self, hz: f64, patterns: &[Patterns]) -> Result<Vec<NeumannData>, BemError> {
        positive("frequency [Hz]", hz)?;
        self.check_resolution(hz)?;
        patterns.iter().map(|p| self.neumann_data(p)).collect()
    }

    /// The same for prepared patterns.
    pub(crate) fn solve_prepared(
        &self,
        hz: f64,
        all: &[NeumannData],
        threads: Threads,
    ) -> Result<Vec<SurfacePressure>, BemError> {
        if self.is_compressed() {
            self.check_resolution(hz)?;
            return self.solve_compressed(hz, all);
        }
        Ok(self.solutions(hz, self.equations(hz, all, threads)?, all, threads))
    }

    /// 1/2 - K + alpha W, and (S + alpha (1/2 + K')) v, for every parity at the frequency `hz`.
    ///
    /// # Errors
    /// If the frequency is above the limit of the mesh.
    pub(crate) fn equations(&self, hz: f64, all: &[NeumannData], threads: Threads) -> Result<Vec<Sums>, BemError> {
        self.check_resolution(hz)?;
        Ok(self.assemble(self.wave(hz), all, threads))
    }

    /// Solves the equations of a frequency; both sides may have a common factor.
    pub(crate) fn solutions(
        &self,
        hz: f64,
        sums: Vec<Sums>,
        all: &[NeumannData],
        threads: Threads,
    ) -> Vec<SurfacePressure> {
        let factor = self.right_hand_factor(hz);
        let parities: Vec<_> = sums.into_iter().zip(all).collect();
        threads.map(parities, |(mut sums, data)| {
            if let (Some(patterns), Some(cover)) = (data.cover(), &self.cover) {
                let of = cover.layer.transfer(hz, &self.air);
                sums = patterns.folded(sums, data.count(), &of, factor);
            }
            self.hold_odd(data.parity(), &mut sums);
            SurfacePressure {
                hz,
                parity: data.parity(),
                pressure: sums.solve(factor),
            }
        })
    }

    /// Factor j omega rho of the right-hand side: with dp/dn = -j omega rho v, -(S + alpha K' + alpha/2) dp/dn is
    /// j omega rho (S + alpha K' + alpha/2) v.
    fn right_hand_factor(&self, hz: f64) -> Complex<f64> {
        Complex::new(0.0, 2.0 * PI * hz * self.air.density)
    }

    fn wave(&self, hz: f64) -> Wave {
        let k = self.wavenumber(hz);
        Wave {
            k,
            coupling: self.coupling_share(hz) * self.coupling.min(1.0 / k),
        }
    }

    /// Whether the matrix is compressed.
    pub fn is_compressed(&self) -> bool {
        self.frequency_cost().compressed
    }

    /// How the equations are solved; a dense matrix is used for a covered surface.
    pub(crate) fn equation_solver(&self) -> EquationSolver {
        match self.cover {
            Some(_) => EquationSolver::Dense,
            None => self.equations,
        }
    }

    fn solve_compressed(&self, hz: f64, all: &[NeumannData]) -> Result<Vec<SurfacePressure>, BemError> {
        let surface = self
            .compressed
            .get_or_init(|| CompressedSurface::new(&self.boundary, &self.blocks));
        let equations = Equations {
            boundary: &self.boundary,
            images: &self.images,
            blocks: &self.blocks,
            near: self.near(),
            masses: &self.masses,
            wave: self.wave(hz),
        };
        let patterns: Vec<(Parity, &DMatrix<f64>)> = all.iter().map(|d| (d.parity(), d.velocities())).collect();
        let pressures = surface
            .solve(&equations, &patterns, self.right_hand_factor(hz), ACCURACY)?
            .into_iter();
        let solved = pressures.zip(all).map(|(pressure, data)| SurfacePressure {
            hz,
            parity: data.parity(),
            pressure,
        });
        Ok(solved.collect())
    }

    /// Sets a field that is odd about a plane to zero in it.
    pub(crate) fn hold_odd(&self, parity: Parity, sums: &mut Sums) {
        let nodes = 0..self.boundary.nodes();
        for node in nodes.filter(|&node| parity.vanishes(self.boundary.in_planes(node))) {
            sums.hold(node);
        }
    }

    /// 1/2 - K + alpha W, and (S + alpha (1/2 + K')) v, for every parity.
    fn assemble(&self, wave: Wave, all: &[NeumannData], threads: Threads) -> Vec<Sums> {
        let mut sums = self.integrals(wave, all, threads);
        for (sums, data) in sums.iter_mut().zip(all) {
            self.add_mass(&mut sums.matrix, 0.5);
            // alpha is imaginary.
            let factor = -0.5 * wave.coupling;
            data.moments().add_to(factor, &mut sums.right[1]);
            if let Some(cover) = data.cover() {
                let surface = (&self.boundary, &self.masses[..]);
                cover.add_moments(surface, (data.count(), factor), &mut sums.right[1]);
            }
        }
        sums
    }

    /// -K + alpha W, and (S + alpha K') v, for every parity.
    pub(crate) fn integrals(&self, wave: Wave, all: &[NeumannData], threads: Threads) -> Vec<Sums> {
        let near = self.near().at(&self.boundary, wave.k);
        let of_every = |step: usize, first: usize| {
            let rows = (first..self.blocks.len()).step_by(step);
            self.integrals_of_blocks(wave, all, &near, rows)
        };
        let sums = match threads {
            Threads::One => of_every(1, 0),
            Threads::Two => {
                let (mut even, odd) = rayon::join(|| of_every(2, 0), || of_every(2, 1));
                even.par_iter_mut().zip(odd).for_each(|(even, odd)| even.add(&odd));
                even
            }
        };
        threads.map(sums, Sums::joined)
    }

    /// The integrals between some blocks and all blocks that do not precede them.
    fn integrals_of_blocks(
        &self,
        wave: Wave,
        all: &[NeumannData],
        near: &NearAt<'_>,
        rows: impl Iterator<Item = usize>,
    ) -> Vec<Sums> {
        let n = self.boundary.nodes();
        let on_blocks = all.iter().map(NeumannData::on_blocks);
        let mut right_hand_sides: Vec<_> = on_blocks.map(|p| RightHandSide::zeros(&self.blocks, p)).collect();
        let mut sums: Vec<Sums> = all.iter().map(|data| Sums::zeros(n, data.columns())).collect();
        let mut tile = Tile::default();
        for i in rows {
            for j in i..self.blocks.len() {
                tile.add(
                    self.boundary.planes(),
                    &self.images,
                    wave,
                    (&self.blocks, [i, j]),
                    near,
                    &mut right_hand_sides,
                    &mut sums,
                );
            }
        }
        for (sums, right_hand_side) in sums.iter_mut().zip(&right_hand_sides) {
            right_hand_side.spread(&self.blocks, &mut sums.right);
        }
        sums
    }

    /// Integrals of phi_i phi_j over each panel.
    pub(crate) fn masses(&self) -> &[[[f64; 4]; 4]] {
        &self.masses
    }

    /// Adds `factor` int phi_i phi_j dS.
    pub(crate) fn add_mass(&self, matrix: &mut Mat<Complex<f32>>, factor: f64) {
        for (panel, mass) in self.boundary.mesh().panels.iter().zip(&self.masses) {
            let nodes: Vec<usize> = self.boundary.unknowns_of(panel).collect();
            for (i, &row) in nodes.iter().enumerate() {
                for (j, &column) in nodes.iter().enumerate() {
                    matrix[(row, column)] += (factor * mass[i][j]) as f32;
                }
            }
        }
    }
}

/// The result of one parity.
pub(crate) fn only<T>(all: Vec<T>) -> Result<T, BemError> {
    let [one] = all.try_into().map_err(|all: Vec<T>| InputError::Length {
        what: "solutions of one parity",
        found: all.len(),
        expected: 1,
    })?;
    Ok(one)
}
