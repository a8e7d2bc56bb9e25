//! Sound energy of a shot in frequency bands: on the surface, at points around it and in the far field.

use super::independent::{Independent, independent};
use super::mesh_range::MeshRange;
use crate::bem::mesh::boundary::Boundary;
use crate::bem::mesh::panel::PanelShape;
use crate::bem::mesh::rules;
use crate::bem::mesh::symmetry::Image;
use crate::bem::solve::neumann::Patterns;
use crate::bem::solve::problem::{Exterior, SurfacePressure};
use crate::checks::ReceiverError;
use crate::error::AcousticsError;
use crate::matrix::real_product;
use crate::radiation::ModalSpectra;
use crate::radiation::sound::{BandSound, Field, FieldPoints, Fields, bins_of, groups, of_bins, squares};
use crate::signals::{Band, Weighting, energy_weights};
use faer::Mat;
use nalgebra::{Complex, DMatrix, Point3, Vector3};
use rayon::prelude::*;
use std::f64::consts::PI;

/// Number of bins processed at once.
const CHUNK: usize = 64;

/// The complete surface, including its images in the mirror planes; panels are given by their corners.
#[derive(Debug, Clone, PartialEq)]
pub struct WholeSurface {
    /// Positions \[m\].
    pub points: Vec<Point3<f64>>,
    /// Corners of every panel, three or four, ordered for an outward normal.
    pub panels: Vec<Vec<usize>>,
    /// Area of every panel \[m2\].
    pub areas: Vec<f64>,
    /// Patch of each panel.
    pub patch: Vec<usize>,
    /// Names of the patches.
    pub patches: Vec<String>,
}

/// Pressure, intensity and velocity on the surface in one band.
#[derive(Debug, Clone, PartialEq)]
pub struct SurfaceBand {
    /// Its surface, as an index into [`BandFields::surfaces`].
    pub surface: usize,
    /// Sound exposure 2 int |p|² df at each point \[Pa² s\].
    pub exposure: Vec<f64>,
    /// Energy per area that leaves each panel, 2 int Re(p v_n*) df \[J/m2\]; negative where sound enters.
    pub intensity: Vec<f64>,
    /// Exposure of the normal velocity, 2 int |v_n|² df, averaged over each panel \[m2/s\].
    pub velocity: Vec<f64>,
}

/// The sound of a shot around a body by the boundary element method, in bands.
#[derive(Debug, Clone, PartialEq)]
pub struct BandFields {
    /// Sound exposure at the field points and energy in the far field.
    pub around: BandSound,
    /// Surfaces of different mesh sizes.
    pub surfaces: Vec<WholeSurface>,
    /// Fields on these surfaces, by band.
    pub bands: Vec<SurfaceBand>,
}

impl BandFields {
    /// Solves the problem at as many frequencies as the bands need, each on the coarsest mesh that resolves it.
    ///
    /// `levels` are in ascending order of frequency; their patterns are those of the modes of `spectra`.
    ///
    /// # Errors
    /// [`BemError::TooCoarse`](crate::bem::BemError) for a band above the last level; also for points that are not
    /// [clear](Exterior::is_clear) and for inconsistent lengths.
    pub fn new(
        levels: Vec<MeshRange>,
        bands: &[Band],
        spectra: &ModalSpectra,
        around: &FieldPoints<'_>,
    ) -> Result<Self, AcousticsError> {
        let mut result = Self {
            around: BandSound::zeros(bands, around),
            surfaces: Vec::new(),
            bands: Vec::new(),
        };
        let Some(finest) = levels.last() else { return Ok(result) };
        if let Some(band) = bands.last() {
            finest.problem.check_resolution(band.high)?;
        }
        for level in &levels {
            for (point, clear) in around.points.iter().zip(level.problem.is_clear(around.points)) {
                if !clear {
                    let needed = level.problem.boundary().mesh().longest_edge();
                    return Err(ReceiverError::NearSurface {
                        point: (*point).into(),
                        distance: 0.0,
                        needed,
                    }
                    .into());
                }
            }
        }
        let chosen = independent(finest);
        let mut first = 0;
        for level in levels {
            let mine = bands[first..]
                .iter()
                .take_while(|b| b.high <= level.top_hz * (1.0 + 1e-9))
                .count();
            let mine = &bands[first..first + mine];
            if mine.is_empty() {
                continue;
            }
            let surface = result.surfaces.len();
            let level = MeshRange {
                problem: level.problem.with_near_field_cache(level.top_hz),
                ..level
            };
            let whole = Whole::new(&level.problem, &level.patterns, &chosen);
            for group in groups(mine, |_| false) {
                let piece = whole.piece(group, around)?;
                result.around.samples += piece.samples();
                result.around.error = result.around.error.max(piece.error());
                for band in group {
                    let at = result.bands.len();
                    let surface = SurfaceBand {
                        surface,
                        ..whole.band(&piece, band, spectra, &mut result.around, at)
                    };
                    result.bands.push(surface);
                }
            }
            first += mine.len();
            result.surfaces.push(whole.surface);
        }
        Ok(result)
    }
}

/// One mesh range with its independent modes and images.
struct Whole<'a> {
    problem: &'a Exterior,
    /// Independent modes of each parity.
    patterns: Vec<Patterns>,
    chosen: &'a [Independent],
    surface: WholeSurface,
    /// Images in the mirror planes.
    images: Vec<Image>,
    /// For each panel, the unknowns at its corners, its area and the integrals of phi_i phi_j.
    panels: Vec<(Vec<usize>, f64, [[f64; 4]; 4])>,
}

impl<'a> Whole<'a> {
    fn new(problem: &'a Exterior, patterns: &[Patterns], chosen: &'a [Independent]) -> Self {
        let boundary = problem.boundary();
        let images: Vec<Image> = boundary
            .images()
            .into_iter()
            .filter(|i| i.sign_along(2) > 0.0)
            .collect();
        Self {
            patterns: chosen.iter().zip(patterns).map(|(pick, p)| pick.of(p)).collect(),
            surface: whole_surface(boundary, &images),
            panels: panels(boundary),
            problem,
            chosen,
            images,
        }
    }

    /// Pressure on the surface, at the field points and in the far field per unit of acceleration, by parity.
    fn piece(&self, group: &[Band], around: &FieldPoints<'_>) -> Result<Fields, AcousticsError> {
        let (radius, origin) = self.problem.reach();
        let speed = self.problem.air().sound_speed;
        let range = [group[0].low, group[group.len() - 1].high];
        let travel: Vec<f64> = around.points.iter().map(|p| (p - origin).norm()).collect();
        Fields::new(range, (radius, speed), |hz| {
            let omega = 2.0 * PI * hz;
            let per_acceleration = Complex::new(0.0, -1.0 / omega);
            let solutions = self.problem.solve_parities(hz, &self.patterns)?;
            let all: Vec<(&DMatrix<f64>, &SurfacePressure)> =
                self.patterns.iter().map(|p| &p.velocities).zip(&solutions).collect();
            let scaled = |m: Mat<Complex<f64>>, turn: &dyn Fn(usize) -> Complex<f64>| {
                let factors: Vec<Complex<f64>> = (0..m.nrows()).map(|i| per_acceleration * turn(i)).collect();
                Field::from_fn(m.nrows(), m.ncols(), |i, j| m[(i, j)] * factors[i])
            };
            let after = |way: f64| Complex::from_polar(1.0, omega / speed * way);
            let mut quantities = Vec::new();
            for solution in &solutions {
                // Allows for sound from anywhere on the surface, and for its reflection by the floor, with path
                // differences up to the size of the body.
                quantities.push(&solution.pressure * (per_acceleration * after(radius)));
            }
            for m in self.problem.around(around.points, &all) {
                quantities.push(scaled(m, &|i| after(travel[i])));
            }
            for m in self.problem.far_fields(&all, around.directions) {
                quantities.push(scaled(m, &|_| Complex::from(1.0)));
            }
            Ok(quantities)
        })
    }

    /// Accumulates the results of a band.
    fn band(
        &self,
        piece: &Fields,
        band: &Band,
        spectra: &ModalSpectra,
        around: &mut BandSound,
        number: usize,
    ) -> SurfaceBand {
        let weights = energy_weights(&spectra.frequency, [band.low, band.high], Weighting::Z);
        let bins = bins_of(&weights);
        let impedance = self.problem.air().impedance();
        let parts: Vec<([Vec<f64>; 2], SurfaceBand)> = bins
            .par_chunks(CHUNK)
            .map(|bins| {
                let frequency: Vec<f64> = bins.iter().map(|&b| spectra.frequency[b]).collect();
                let weights: Vec<f64> = bins.iter().map(|&b| 2.0 * weights[b]).collect();
                let motion = of_bins(spectra, bins);
                let accelerations: Vec<Field> = self
                    .chosen
                    .iter()
                    .map(|pick| real_product(&pick.combination.dense(), &motion))
                    .collect();
                let carried = |quantity: usize| -> Vec<Field> {
                    let first = quantity * self.chosen.len();
                    let of_parity = |(c, a): (usize, &Field)| piece.product(first + c, &frequency, a);
                    accelerations.iter().enumerate().map(of_parity).collect()
                };
                let sound = [1, 2].map(|quantity| squares(&sum(carried(quantity).into_iter()), &weights));
                let pressure = carried(0);
                (sound, self.on_surface(&pressure, &accelerations, &frequency, &weights))
            })
            .collect();
        let mut total = SurfaceBand {
            surface: 0,
            exposure: vec![0.0; self.surface.points.len()],
            intensity: vec![0.0; self.surface.panels.len()],
            velocity: vec![0.0; self.surface.panels.len()],
        };
        for ([exposure, far], part) in parts {
            // p -> F e^{-jkr}/(4 pi r)
            around.add(number, &exposure, (&far, 1.0 / (16.0 * PI * PI * impedance)));
            for (to, from) in [
                (&mut total.exposure, part.exposure),
                (&mut total.intensity, part.intensity),
                (&mut total.velocity, part.velocity),
            ] {
                to.iter_mut().zip(from).for_each(|(to, from)| *to += from);
            }
        }
        total
    }

    fn on_surface(&self, pressure: &[Field], accelerations: &[Field], hz: &[f64], weights: &[f64]) -> SurfaceBand {
        let (bins, radius) = (hz.len(), self.problem.reach().0);
        // The pressure is advanced by the travel time across the body, so the velocity must be advanced equally.
        let turn: Vec<Complex<f64>> = hz
            .iter()
            .map(|hz| {
                let omega = 2.0 * PI * hz;
                Complex::from_polar(1.0, omega / self.problem.air().sound_speed * radius) / Complex::new(0.0, omega)
            })
            .collect();
        let mut velocity: Vec<Field> = self
            .patterns
            .iter()
            .zip(accelerations)
            .map(|(p, a)| {
                let turned = Field::from_fn(a.nrows(), bins, |i, b| a[(i, b)] * turn[b]);
                real_product(&p.velocities, &turned)
            })
            .collect();
        if let Some(cover) = self.problem.cover() {
            let unknowns = self.problem.unknowns_of_values();
            for (v, p) in velocity.iter_mut().zip(pressure) {
                for ((mut v, p), hz) in v.column_iter_mut().zip(p.column_iter()).zip(hz) {
                    let of = cover.layer.transfer(*hz, self.problem.air());
                    cover.to_outer_face(&of, (p.as_slice(), &unknowns), v.as_mut_slice());
                }
            }
        }
        let mut found = SurfaceBand {
            surface: 0,
            exposure: Vec::with_capacity(self.surface.points.len()),
            intensity: Vec::with_capacity(self.surface.panels.len()),
            velocity: Vec::with_capacity(self.surface.panels.len()),
        };
        for &image in &self.images {
            let whole = |parts: &[Field]| {
                let signed = self
                    .patterns
                    .iter()
                    .zip(parts)
                    .map(|(p, part)| part * Complex::from(p.parity.sign(image)));
                sum(signed)
            };
            let (p, v) = (whole(pressure), whole(&velocity));
            for node in 0..p.nrows() {
                found
                    .exposure
                    .push((0..bins).map(|b| weights[b] * p[(node, b)].norm_sqr()).sum());
            }
            let mut first = 0;
            for (nodes, area, mass) in &self.panels {
                let (mut intensity, mut square) = (0.0, 0.0);
                for (i, row) in mass.iter().enumerate().take(nodes.len()) {
                    for (j, &m) in row.iter().enumerate().take(nodes.len()) {
                        for b in 0..bins {
                            let there = v[(first + i, b)];
                            let w = m * weights[b];
                            intensity += w * (p[(nodes[j], b)] * there.conj()).re;
                            square += w * (v[(first + j, b)] * there.conj()).re;
                        }
                    }
                }
                found.intensity.push(intensity / area);
                found.velocity.push(square / area);
                first += nodes.len();
            }
        }
        found
    }
}

/// Sum of the fields.
fn sum(parts: impl Iterator<Item = Field>) -> Field {
    parts
        .reduce(|sum, part| sum + part)
        .unwrap_or_else(|| Field::zeros(0, 0))
}

fn panels(boundary: &Boundary) -> Vec<(Vec<usize>, f64, [[f64; 4]; 4])> {
    let mesh = boundary.mesh();
    let of_panel = |p: usize| {
        let panel = &mesh.panels[p];
        let (mut mass, mut area) = ([[0.0; 4]; 4], 0.0);
        for (xi, w) in rules::fine(panel.kind()) {
            let dw = w * mesh.point_at(p, xi).area_vector().norm();
            let n = panel.kind().linear().at(xi).n;
            area += dw;
            for (i, row) in mass.iter_mut().enumerate() {
                for (j, m) in row.iter_mut().enumerate() {
                    *m += dw * n[i] * n[j];
                }
            }
        }
        let nodes = panel.corners().iter().filter_map(|&c| boundary.node_of(c)).collect();
        (nodes, area, mass)
    };
    (0..mesh.panels.len()).map(of_panel).collect()
}

/// All images of the unknowns' points, one image after another, and of the panels.
fn whole_surface(boundary: &Boundary, images: &[Image]) -> WholeSurface {
    let mesh = boundary.mesh();
    let mut places = vec![Vector3::zeros(); boundary.nodes()];
    for (point, x) in mesh.points.iter().enumerate() {
        if let Some(node) = boundary.node_of(point) {
            places[node] = x.coords;
        }
    }
    let panels = panels(boundary);
    let mut whole = WholeSurface {
        points: Vec::new(),
        panels: Vec::new(),
        areas: Vec::new(),
        patch: Vec::new(),
        patches: mesh.patches.clone(),
    };
    for &image in images {
        let first = whole.points.len();
        let place =
            |x: &Vector3<f64>| Point3::from_slice(&[0, 1, 2].map(|axis| boundary.mirrored(image, axis, x[axis])));
        whole.points.extend(places.iter().map(place));
        for ((nodes, area, _), panel) in panels.iter().zip(&mesh.panels) {
            let mut corners: Vec<usize> = nodes.iter().map(|n| first + n).collect();
            if image.handedness() < 0.0 {
                corners.reverse();
            }
            whole.panels.push(corners);
            whole.areas.push(*area);
            whole.patch.push(panel.patch);
        }
    }
    whole
}
