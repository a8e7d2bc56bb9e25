use crate::air::Air;
use crate::bem::compressed::{Accuracy, CompressedSurface, Equations};
use crate::bem::error::BemError;
use crate::bem::mesh::boundary::Boundary;
use crate::bem::mesh::panel::{Panel, PanelShape};
use crate::bem::mesh::rules;
use crate::bem::mesh::symmetry::{Image, Parity};
use crate::bem::operators::blocks::{Block, blocks};
use crate::bem::operators::equations::Sums;
use crate::bem::operators::near::NearField;
use crate::bem::operators::tile::{RightHandSide, Tile};
use crate::bem::operators::wave::Wave;
use crate::checks::{InputError, positive, same_length};
use faer::linalg::matmul::matmul;
use faer::{Accum, Mat, MatRef, Par};
use nalgebra::{Complex, DMatrix};
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
/// With G = e^{-jkr} / (4 pi r), plus that of the image in a rigid floor, and n into the air, the pressure p and its
/// normal derivative dp/dn = -j omega rho v_n satisfy (Burton & Miller 1971)
///
/// ```text
/// (1/2 - K - alpha H) p = -(S + alpha (1/2 + K')) dp/dn        alpha = -j s(f) min(1/k, L_c)
/// ```
///
/// This equation has a unique solution at every frequency, while each half fails at resonances of the interior problem.
/// Well below the lowest of these the correction is not needed, and the derivative equation would reduce the accuracy
/// of the small surface resistance of rigid-body motion (by a factor of 2 at 100 Hz for a block of 0.4 m; 2e-4 without
/// it). Therefore s rises as sin² from 0 at half of f_box to 1 at 0.9 f_box, where f_box is the lowest resonance of the
/// bounding box; no body inside it has a lower one. The method is Galerkin's with continuous linear (bilinear)
/// pressure; the normal velocity is linear on each panel and discontinuous between panels. The hypersingular operator
/// is integrated by parts (Maue 1949, Nedelec 2001 section 3.3.4),
///
/// ```text
/// <phi, H psi> = -int int G (curl phi . curl psi - k² n_x . n_y phi psi)        curl phi = n x grad phi
/// ```
///
/// On a body that stands on the floor, the surface and its image form a closed surface: with test functions that are
/// even in the height above the floor, the contour terms of the two cancel. Mirror planes work likewise; where a field
/// is odd about a plane, its functions vanish in the plane.
#[derive(Debug)]
pub struct Exterior {
    boundary: Boundary,
    air: Air,
    blocks: Vec<Block>,
    /// Found when it is first read: a surface that is only described has no use for it.
    near: OnceLock<NearField>,
    coupling: f64,
    per_wavelength: f64,
    images: Vec<Image>,
    /// Integrals of phi_i phi_j over every panel.
    masses: Vec<[[f64; 4]; 4]>,
    equations: EquationSolver,
    compressed: OnceLock<CompressedSurface>,
}

/// How the equations of a surface are stored and solved.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
pub enum EquationSolver {
    /// Compressed if that takes less than half as long as with the dense matrix by
    /// [`SurfaceSize::cost`](crate::bem::SurfaceSize::cost).
    #[default]
    Auto,
    /// A dense matrix and its LU factors.
    Dense,
    /// Distant blocks of the matrix as products of thin matrices by adaptive cross approximation, and a block Krylov
    /// method.
    Compressed,
}

impl EquationSolver {
    /// Whether the program chooses.
    pub fn is_auto(&self) -> bool {
        *self == Self::Auto
    }
}

/// Normal velocities of one parity about the mirror planes.
#[derive(Clone, Debug)]
pub struct Patterns {
    /// Their parity; the default without mirror planes.
    pub parity: Parity,
    /// Corner values of every panel x patterns, see [`Boundary::project`].
    pub velocities: DMatrix<f64>,
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
    /// Sets the problem up; close pairs and the tables of their rules are found with the first use.
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
        }
    }

    /// Sets how the equations are solved; the default is what costs less.
    #[must_use]
    pub fn with_equation_solver(mut self, solver: EquationSolver) -> Self {
        self.equations = solver;
        self
    }

    /// Sets the cap L_c \[m\] of the coupling parameter; the default is half the width of the body.
    ///
    /// # Errors
    /// A length that is not positive.
    pub fn with_coupling(mut self, length: f64) -> Result<Self, BemError> {
        self.coupling = positive("cap of the coupling parameter [m]", length)?;
        Ok(self)
    }

    /// Sets the number of panels per wavelength below which frequencies are refused; the default is six.
    ///
    /// # Errors
    /// A number that is not positive.
    pub fn with_panels_per_wavelength(mut self, number: f64) -> Result<Self, BemError> {
        self.per_wavelength = positive("panels per wavelength", number)?;
        Ok(self)
    }

    /// Integrates pairs of panels that touch or nearly touch once for all frequencies up to `highest_hz`, and
    /// interpolates over frequency with an error of about 1e-5. This saves time and costs memory if many frequencies
    /// are solved.
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

    /// Panels per wavelength below which frequencies are refused.
    pub fn panels_per_wavelength(&self) -> f64 {
        self.per_wavelength
    }

    /// Lowest resonance of the box around the surface (and its image, if it stands on the floor), pressure zero on its
    /// walls \[Hz\]: no resonance of the inside is lower.
    pub fn lowest_resonance(&self) -> f64 {
        let mut sides = self.boundary.extents();
        if self.boundary.stands_on_floor() {
            sides.z *= 2.0;
        }
        0.5 * self.air.sound_speed * sides.iter().map(|l| l.powi(-2)).sum::<f64>().sqrt()
    }

    /// s(f) of the coupling parameter.
    fn coupling_share(&self, hz: f64) -> f64 {
        let t = ((hz / self.lowest_resonance() - 0.5) / 0.4).clamp(0.0, 1.0);
        (0.5 * PI * t).sin().powi(2)
    }

    pub(crate) fn check_resolution(&self, hz: f64) -> Result<(), BemError> {
        let highest = self.boundary.highest_hz(self.air.sound_speed, self.per_wavelength);
        // The upper end of a range may equal this frequency.
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

    /// Pairs of panels too close for the far rule.
    pub fn close_pairs(&self) -> usize {
        self.near().len()
    }

    /// Shapes of those pairs: congruent pairs are integrated once.
    pub fn close_shapes(&self) -> usize {
        self.near().shapes()
    }

    /// Pressure on the surface at the frequency `hz` for normal velocities (corner values of every panel x patterns,
    /// see [`Boundary::project`]) that continue evenly across the mirror planes, if there are any.
    ///
    /// # Errors
    /// A frequency that is not positive or above what the mesh resolves, patterns of another length.
    pub fn solve(&self, hz: f64, velocities: &DMatrix<f64>) -> Result<SurfacePressure, BemError> {
        let even = Patterns {
            parity: Parity::default(),
            velocities: velocities.clone(),
        };
        let [pressure] = self
            .solve_parities(hz, &[even])?
            .try_into()
            .map_err(|all: Vec<_>| InputError::Length {
                what: "solutions of one parity",
                found: all.len(),
                expected: 1,
            })?;
        Ok(pressure)
    }

    /// Pressure on the surface for patterns of several parities: the kernels are evaluated once, every parity has one
    /// matrix and one factorisation for all its patterns; on one thread.
    ///
    /// # Errors
    /// As [`Exterior::solve`].
    pub fn solve_parities(&self, hz: f64, patterns: &[Patterns]) -> Result<Vec<SurfacePressure>, BemError> {
        positive("frequency [Hz]", hz)?;
        self.check_resolution(hz)?;
        for p in patterns {
            let rows = p.velocities.nrows();
            same_length("rows of the normal velocities", rows, self.boundary.velocity_values())?;
        }
        let omega = 2.0 * PI * hz;
        let k = omega / self.air.sound_speed;
        let wave = Wave {
            k,
            coupling: self.coupling_share(hz) * self.coupling.min(1.0 / k),
        };
        // dp/dn = -j omega rho v turns -(S + alpha K' + alpha/2) dp/dn into j omega rho (...) v.
        let factor = Complex::new(0.0, omega * self.air.density);
        if self.is_compressed() {
            return self.solve_compressed(hz, wave, factor, patterns);
        }
        let sums = self.assemble(wave, patterns);
        let solved = sums.into_iter().zip(patterns).map(|(mut sums, patterns)| {
            self.hold_odd(patterns.parity, &mut sums);
            SurfacePressure {
                hz,
                parity: patterns.parity,
                pressure: sums.solve(factor),
            }
        });
        Ok(solved.collect())
    }

    /// Whether the matrix is compressed.
    pub fn is_compressed(&self) -> bool {
        self.frequency_cost().compressed
    }

    pub(crate) fn equation_solver(&self) -> EquationSolver {
        self.equations
    }

    fn solve_compressed(
        &self,
        hz: f64,
        wave: Wave,
        factor: Complex<f64>,
        patterns: &[Patterns],
    ) -> Result<Vec<SurfacePressure>, BemError> {
        let surface = self
            .compressed
            .get_or_init(|| CompressedSurface::new(&self.boundary, &self.blocks));
        let equations = Equations {
            boundary: &self.boundary,
            images: &self.images,
            blocks: &self.blocks,
            near: self.near(),
            masses: &self.masses,
            wave,
        };
        let all: Vec<(Parity, &DMatrix<f64>)> = patterns.iter().map(|p| (p.parity, &p.velocities)).collect();
        let pressures = surface.solve(&equations, &all, factor, ACCURACY)?;
        let solved = pressures
            .into_iter()
            .zip(patterns)
            .map(|(pressure, patterns)| SurfacePressure {
                hz,
                parity: patterns.parity,
                pressure,
            });
        Ok(solved.collect())
    }

    /// A field that is odd about a plane is zero in it.
    pub(crate) fn hold_odd(&self, parity: Parity, sums: &mut Sums) {
        let nodes = 0..self.boundary.nodes();
        for node in nodes.filter(|&node| parity.vanishes(self.boundary.in_planes(node))) {
            sums.hold(node);
        }
    }

    /// 1/2 - K + alpha W, and (S + alpha (1/2 + K')) v, for every parity.
    fn assemble(&self, wave: Wave, all: &[Patterns]) -> Vec<Sums> {
        let mut sums = self.integrals(wave, all);
        for (sums, patterns) in sums.iter_mut().zip(all) {
            self.add_jump(wave, &patterns.velocities, sums);
        }
        sums
    }

    /// -K + alpha W, and (S + alpha K') v, for every parity.
    pub(crate) fn integrals(&self, wave: Wave, all: &[Patterns]) -> Vec<Sums> {
        let n = self.boundary.nodes();
        let right_hand_side = |p: &Patterns| RightHandSide::new(&self.blocks, p.parity, &p.velocities);
        let mut right_hand_sides: Vec<RightHandSide> = all.iter().map(right_hand_side).collect();
        let empty = |p: &Patterns| Sums::zeros(n, p.velocities.ncols());
        let mut sums: Vec<Sums> = all.iter().map(empty).collect();
        let mut tile = Tile::default();
        let near = self.near().at(&self.boundary, wave.k);
        for i in 0..self.blocks.len() {
            for j in i..self.blocks.len() {
                tile.add(
                    self.boundary.planes(),
                    &self.images,
                    wave,
                    (&self.blocks, [i, j]),
                    &near,
                    &mut right_hand_sides,
                    &mut sums,
                );
            }
        }
        for (sums, right_hand_side) in sums.iter_mut().zip(&right_hand_sides) {
            right_hand_side.spread(&self.blocks, &mut sums.right);
            sums.join();
        }
        sums
    }

    /// The pressure unknowns at a panel's corners.
    fn unknowns_of(&self, panel: &Panel) -> Vec<usize> {
        let corners = panel.corners().iter();
        corners.filter_map(|&c| self.boundary.node_of(c)).collect()
    }

    /// 1/2 on both sides.
    fn add_jump(&self, wave: Wave, velocities: &DMatrix<f64>, sums: &mut Sums) {
        self.add_mass(&mut sums.matrix, 0.5);
        // alpha is imaginary.
        self.add_moments(velocities, -0.5 * wave.coupling, &mut sums.right[1]);
    }

    /// Adds `factor` int phi_i phi_j dS.
    pub(crate) fn add_mass(&self, matrix: &mut Mat<Complex<f32>>, factor: f64) {
        for (panel, mass) in self.boundary.mesh().panels.iter().zip(&self.masses) {
            let nodes = self.unknowns_of(panel);
            for (i, &row) in nodes.iter().enumerate() {
                for (j, &column) in nodes.iter().enumerate() {
                    matrix[(row, column)] += (factor * mass[i][j]) as f32;
                }
            }
        }
    }

    /// Adds `factor` int phi_i v dS for every pattern v, unknowns x patterns.
    pub(crate) fn add_moments(&self, velocities: &DMatrix<f64>, factor: f64, to: &mut Mat<f64>) {
        let (nodes, moments) = self.moments(velocities, |_| true);
        for (m, moments) in moments.column_iter().enumerate() {
            let to = to.col_as_slice_mut(m);
            for (&node, moment) in nodes.iter().zip(moments.iter()) {
                to[node] += factor * moment;
            }
        }
    }

    /// int phi_i v dS over some of the panels for every pattern v: the unknowns of these panels, and these x patterns.
    fn moments(&self, velocities: &DMatrix<f64>, among: impl Fn(&Panel) -> bool) -> (Vec<usize>, DMatrix<f64>) {
        let mut rows = vec![None; self.boundary.nodes()];
        let (mut nodes, mut pieces, mut first) = (Vec::new(), Vec::new(), 0);
        for (panel, mass) in self.boundary.mesh().panels.iter().zip(&self.masses) {
            if among(panel) {
                let row = |node: usize| {
                    *rows[node].get_or_insert_with(|| {
                        nodes.push(node);
                        nodes.len() - 1
                    })
                };
                let own: Vec<usize> = self.unknowns_of(panel).into_iter().map(row).collect();
                pieces.push((first, own, mass));
            }
            first += panel.corners().len();
        }
        let mut moments = DMatrix::zeros(nodes.len(), velocities.ncols());
        for (mut to, v) in moments.column_iter_mut().zip(velocities.column_iter()) {
            let v = v.as_slice();
            for (first, own, mass) in &pieces {
                let corners = &v[*first..first + own.len()];
                for (&row, mass) in own.iter().zip(*mass) {
                    to[row] += corners.iter().zip(mass).map(|(v, mass)| v * mass).sum::<f64>();
                }
            }
        }
        (nodes, moments)
    }

    /// Modal radiation impedance Z_ij = int v_i p_j dS of every patch: its real part is R, its imaginary part is omega
    /// times the added mass of air. With mirror planes, the impedance of the whole body.
    ///
    /// # Errors
    /// Patterns or pressures of another length.
    pub fn impedance(
        &self,
        velocities: &DMatrix<f64>,
        solution: &SurfacePressure,
    ) -> Result<Vec<DMatrix<Complex<f64>>>, BemError> {
        same_length(
            "rows of the normal velocities",
            velocities.nrows(),
            self.boundary.velocity_values(),
        )?;
        same_length("rows of the pressure", solution.pressure.nrows(), self.boundary.nodes())?;
        let mesh = self.boundary.mesh();
        let patches = mesh
            .panels
            .iter()
            .map(|p| p.patch + 1)
            .max()
            .unwrap_or(0)
            .max(mesh.patches.len());
        let (modes, columns) = (velocities.ncols(), solution.pressure.ncols());
        let copies = self.boundary.copies() as f64;
        let of_patch = |patch: usize| {
            let (nodes, moments) = self.moments(velocities, |panel| panel.patch == patch);
            let moments = MatRef::from_column_major_slice(moments.as_slice(), nodes.len(), modes);
            let [re, im] = [|z: Complex<f64>| z.re, |z: Complex<f64>| z.im].map(|part| {
                let p = Mat::from_fn(nodes.len(), columns, |i, j| part(solution.pressure[(nodes[i], j)]));
                let mut z = Mat::<f64>::zeros(modes, columns);
                matmul(
                    z.as_mut(),
                    Accum::Replace,
                    moments.transpose(),
                    p.as_ref(),
                    copies,
                    Par::Seq,
                );
                z
            });
            DMatrix::from_fn(modes, columns, |i, j| Complex::new(re[(i, j)], im[(i, j)]))
        };
        Ok((0..patches).map(of_patch).collect())
    }
}
