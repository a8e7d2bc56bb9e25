use super::blocks::{N, W, X, fields};
use super::panel::PanelShape;
use super::problem::{Exterior, SurfacePressure};
use super::rules;
use super::trig::sin_cos;
use crate::error::{AcousticsError, same_length};
use crate::radiation::gauss_legendre;
use faer::linalg::matmul::matmul;
use faer::{Accum, Mat, MatRef, Par};
use nailnoise_meshes::FaceKind;
use nalgebra::{DMatrix, Vector3};
use pulp::{Arch, Simd, WithSimd};
use rustfft::num_complex::Complex;
use std::f64::consts::PI;

/// Directions worked on at once.
const CHUNK: usize = 48;

/// Sines and cosines of an array whose length is a multiple of 8.
struct SineCosine<'a> {
    phase: &'a [f64],
    sine: &'a mut [f64],
    cosine: &'a mut [f64],
}

impl WithSimd for SineCosine<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let sine = S::as_mut_simd_f64s(self.sine).0;
        let cosine = S::as_mut_simd_f64s(self.cosine).0;
        for ((x, s), c) in S::as_simd_f64s(self.phase).0.iter().zip(sine).zip(cosine) {
            (*s, *c) = sin_cos(simd, *x);
        }
    }
}

/// A quadrature point: position, vector area, area, unknowns and velocity values with their corner functions.
pub(super) struct Source {
    pub(super) position: Vector3<f64>,
    pub(super) area: Vector3<f64>,
    pub(super) weight: f64,
    pub(super) corners: usize,
    pub(super) nodes: [usize; 4],
    pub(super) first_value: usize,
    pub(super) phi: [f64; 4],
}

impl Exterior {
    /// Radiation resistance R (patterns x patterns) from the far field of the surface's pressure and velocity:
    ///
    /// ```text
    /// p -> e^{-jkr}/(4 pi r) F(d)     F(d) = int e^{jk d.y} (jk d.n p + j omega rho v_n) dS
    /// R = 1/(16 pi² rho c) Re int F^H F dOmega
    /// ```
    ///
    /// with the images in floor and mirror planes and the half space above the floor. Symmetric and positive
    /// semidefinite by construction, and independent of [`Exterior::impedance`], which integrates the intensity on the surface.
    ///
    /// # Errors
    /// Patterns or pressures of another length.
    pub fn far_field_resistance(
        &self,
        velocities: &DMatrix<f64>,
        solution: &SurfacePressure,
    ) -> Result<DMatrix<f64>, AcousticsError> {
        let boundary = self.boundary();
        same_length(
            "rows of the normal velocities",
            velocities.nrows(),
            boundary.velocity_values(),
        )?;
        same_length("rows of the pressure", solution.pressure.nrows(), boundary.nodes())?;
        let (omega, modes) = (2.0 * PI * solution.hz, velocities.ncols());
        let k = omega / self.air().sound_speed;
        let (sources, _, radius) = self.quadrature();
        let padded = sources.len().next_multiple_of(8);
        let planes = boundary.planes().map(|plane| plane.is_some());
        let directions = directions(k * radius, planes);
        let n = boundary.nodes();
        let pressure = MatRef::from_column_major_slice(solution.pressure.as_slice(), n, modes);
        let velocity = MatRef::from_column_major_slice(velocities.as_slice(), velocities.nrows(), modes);
        let mut total = Mat::<f64>::zeros(modes, modes);
        let mut phase = vec![0.0; padded];
        let (mut sine, mut cosine) = ([0; 3].map(|_| vec![0.0; padded]), [0; 3].map(|_| vec![0.0; padded]));
        let impedance = self.air().impedance();
        for chunk in directions.chunks(CHUNK) {
            let rows = chunk.len();
            let mut on_p = Mat::<Complex<f64>>::zeros(n, rows);
            let mut on_v = Mat::<f64>::zeros(velocities.nrows(), 2 * rows);
            for (row, (d, _)) in chunk.iter().enumerate() {
                for axis in 0..3 {
                    for (phase, source) in phase.iter_mut().zip(&sources) {
                        *phase = k * d[axis] * source.position[axis];
                    }
                    Arch::new().dispatch(SineCosine {
                        phase: &phase,
                        sine: &mut sine[axis],
                        cosine: &mut cosine[axis],
                    });
                }
                for (i, source) in sources.iter().enumerate() {
                    let wave: [Standing; 3] = std::array::from_fn(|axis| {
                        let odd = solution.parity.is_odd(axis);
                        Standing::new(cosine[axis][i], sine[axis][i], planes[axis], odd)
                    });
                    let even = wave[0].value * wave[1].value * wave[2].value;
                    let slope = wave[0].slope * (d.x * source.area.x) * wave[1].value * wave[2].value
                        + wave[0].value * wave[1].slope * (d.y * source.area.y) * wave[2].value
                        + wave[0].value * wave[1].value * wave[2].slope * (d.z * source.area.z);
                    let on_pressure = slope * k;
                    let on_velocity = even * Complex::new(0.0, k * impedance * source.weight);
                    for j in 0..source.corners {
                        on_p[(source.nodes[j], row)] += on_pressure * source.phi[j];
                        let value = on_velocity * source.phi[j];
                        on_v[(source.first_value + j, row)] += value.re;
                        on_v[(source.first_value + j, rows + row)] += value.im;
                    }
                }
            }
            let mut from_p = Mat::<Complex<f64>>::zeros(rows, modes);
            let one = Complex::new(1.0, 0.0);
            matmul(
                from_p.as_mut(),
                Accum::Replace,
                on_p.transpose(),
                pressure,
                one,
                Par::Seq,
            );
            let mut field = Mat::<f64>::zeros(2 * rows, modes);
            matmul(
                field.as_mut(),
                Accum::Replace,
                on_v.transpose(),
                velocity,
                1.0,
                Par::Seq,
            );
            for m in 0..modes {
                for (row, (_, w)) in chunk.iter().enumerate() {
                    let root = (w / impedance).sqrt() / (4.0 * PI);
                    let (re, im) = (field[(row, m)], field[(rows + row, m)]);
                    field[(row, m)] = root * (re + from_p[(row, m)].re);
                    field[(rows + row, m)] = root * (im + from_p[(row, m)].im);
                }
            }
            matmul(
                total.as_mut(),
                Accum::Add,
                field.transpose(),
                field.as_ref(),
                1.0,
                Par::Seq,
            );
        }
        Ok(DMatrix::from_fn(modes, modes, |i, j| total[(i.min(j), i.max(j))]))
    }

    /// All quadrature points relative to an origin (the body's centre, or its foot on the floor), the origin, and the
    /// radius around it that holds them.
    pub(super) fn quadrature(&self) -> (Vec<Source>, Vector3<f64>, f64) {
        let mut sources = Vec::new();
        for block in self.blocks() {
            let rule = rules::far(block.corners);
            let kind = if block.corners == 3 {
                FaceKind::Tri3
            } else {
                FaceKind::Quad4
            };
            for f in 0..block.panels.len() {
                for (b, (xi, _)) in rule.iter().enumerate() {
                    let get = |field: usize| block.points[(b * fields(block.corners) + field) * block.width + f];
                    let shape = kind.at(*xi);
                    sources.push(Source {
                        position: Vector3::new(get(X), get(X + 1), get(X + 2)),
                        area: Vector3::new(get(N), get(N + 1), get(N + 2)),
                        weight: get(W),
                        corners: block.corners,
                        nodes: block.local[f].map(|l| block.nodes[l]),
                        first_value: block.first_value[f],
                        phi: std::array::from_fn(|j| shape.n[j]),
                    });
                }
            }
        }
        let mut low = Vector3::repeat(f64::INFINITY);
        let mut high = -low;
        for source in &sources {
            low = low.inf(&source.position);
            high = high.sup(&source.position);
        }
        let mut origin = 0.5 * (low + high);
        for (axis, plane) in self.boundary().planes().iter().enumerate() {
            origin[axis] = plane.unwrap_or(origin[axis]);
        }
        let mut radius: f64 = 0.0;
        for source in &mut sources {
            source.position -= origin;
            radius = radius.max(source.position.norm());
        }
        (sources, origin, radius)
    }
}

/// A factor of e^{jk d.y}, with its image along one axis: f(t) and its derivative, t = k d_a y_a.
///
/// e^{jt} alone, 2 cos t with the image of a field that continues evenly across the plane t = 0, 2j sin t with that of
/// one that changes its sign.
struct Standing {
    value: Complex<f64>,
    slope: Complex<f64>,
}

impl Standing {
    fn new(cosine: f64, sine: f64, plane: bool, odd: bool) -> Self {
        let (value, slope) = match (plane, odd) {
            (false, _) => (Complex::new(cosine, sine), Complex::new(-sine, cosine)),
            (true, false) => (Complex::new(2.0 * cosine, 0.0), Complex::new(-2.0 * sine, 0.0)),
            (true, true) => (Complex::new(0.0, 2.0 * sine), Complex::new(0.0, 2.0 * cosine)),
        };
        Self { value, slope }
    }
}

/// Directions and weights that integrate the squared far field of a body of size k a over the unit sphere, or over its
/// half above the floor: spherical harmonics up to k a + 6 (k a)^{1/3} + 6 (Wiscombe 1980, rounded up). With mirror
/// planes only the directions above them are listed, the others contribute as much.
fn directions(ka: f64, planes: [bool; 3]) -> Vec<(Vector3<f64>, f64)> {
    let order = (ka + 6.0 * ka.cbrt() + 6.0).ceil() as usize;
    let around = (2 * order + 1).next_multiple_of(4);
    let copies: f64 = planes[..2]
        .iter()
        .map(|mirror| if *mirror { 2.0 } else { 1.0 })
        .product();
    let mut result = Vec::new();
    for (z, w) in gauss_legendre((order + 1).next_multiple_of(2)) {
        if planes[2] && z < 0.0 {
            continue;
        }
        let r = (1.0 - z * z).sqrt();
        for i in 0..around {
            // Half a step off the planes, so that every direction has its images.
            let (sine, cosine) = (2.0 * PI * (i as f64 + 0.5) / around as f64).sin_cos();
            if planes[0] && cosine < 0.0 || planes[1] && sine < 0.0 {
                continue;
            }
            let weight = copies * w * 2.0 * PI / around as f64;
            result.push((Vector3::new(r * cosine, r * sine, z), weight));
        }
    }
    result
}
