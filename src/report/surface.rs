//! Sound that the parts of a vibrating surface, and its modes, would radiate with radiation efficiency 1.
//!
//! ```text
//! e(x) = rho0 c0 2 int A(f) |v_n(x, f)|^2 df        v_n = sum over modes of phi_n a/(j omega)
//! ```
//! is the A-weighted equivalent radiated energy of an area \[J/m2\]. It shows where and how a surface moves and so
//! might radiate; the ranking states how much actually leaves as sound. With C = 2 sum of A(f) Re(a a^H)/omega^2 df
//! over the bins, e = rho0 c0 phi_n^T C phi_n, and a single mode r gives the energy rho0 c0 C_rr int phi_n^2 dS.

use nailnoise_acoustics::Air;
use nailnoise_acoustics::radiation::LowRank;
use nailnoise_acoustics::signals::{Band, Weighting, octaves};
use nailnoise_meshes::{QuadraturePoint, Surface, open_faces};
use nalgebra::{DMatrix, DVector, Vector3};
use rayon::prelude::*;
use serde::Serialize;

use crate::model::sources::of_body;
use crate::stages::bodies::{Body, BodyKind};
use crate::stages::modal_efficiency::BodyEfficiencies;
use crate::stages::radiation::CoveredFaces;
use crate::stages::spectra::BodyInMotion;

/// Reference energy \[J\]: 1 pW for 1 s.
const REFERENCE: f64 = 1e-12;

/// Surroundings and supports of the bodies.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Surroundings {
    /// Faces of workpiece and support that do not radiate.
    pub covered: CoveredFaces,
    /// Position of the tool's nose, the origin of its axes \[m\].
    pub nose: [f64; 3],
    /// The ambient air.
    pub air: Air,
}

/// A body's surface with the energy that its faces would radiate.
pub(super) struct ColouredSurface<'a> {
    pub(super) body: &'a Body,
    /// Loss factor of its modes \[-\].
    pub(super) loss_factor: f64,
    /// Position of its origin in the room \[m\].
    pub(super) origin: Vector3<f64>,
    /// Whether each face radiates into the air, which it does not if it touches or lies in another body or sand.
    pub(super) free: Vec<bool>,
    /// Range over which the body's motion is known \[Hz\].
    pub(super) range_hz: [f64; 2],
    /// A-weighted energy per area of each face over that range \[J/m2\].
    pub(super) whole: Vec<f64>,
    /// The same for the part of each of the [`octaves`] inside the range; `None` if there is no such part.
    pub(super) octaves: Vec<Option<Vec<f64>>>,
    /// A-weighted energy that each mode alone would radiate \[J\].
    pub(super) modes: Vec<f64>,
    /// Radiation efficiencies of the modes.
    pub(super) efficiencies: Option<&'a BodyEfficiencies>,
}

impl<'a> ColouredSurface<'a> {
    pub(super) fn new(
        around: &Surroundings,
        driven: &'a BodyInMotion,
        efficiencies: Option<&'a BodyEfficiencies>,
    ) -> Self {
        let (body, spectra) = (&*driven.body, &driven.motion.spectra);
        let surface = &body.surface;
        // One point per face: the picture shows no finer detail, and a one-point rule exists for every shape.
        let points = surface.quadrature(1).unwrap_or_default();
        let mut normal = normal_modes(surface, &points, &body.skin);
        // A mesh is shown completely if its cavities cannot be separated from its outer surface.
        let open = open_faces(surface, None).unwrap_or_else(|_| vec![true; surface.faces.len()]);
        let free: Vec<bool> = points
            .iter()
            .map(|point| {
                let patch = &surface.patches[surface.faces[point.face].patch];
                open[point.face] && !around.covered.covers(body.name, patch, &point.position)
            })
            .collect();
        let tool = body.name == BodyKind::Tool.name();
        if tool {
            // The sound of its rigid-body motion is that of a small sphere, which radiation efficiency 1 would
            // overestimate.
            for (mode, _) in body.omega.iter().enumerate().filter(|(_, omega)| **omega == 0.0) {
                normal.column_mut(mode).fill(0.0);
            }
        }
        let impedance = around.air.impedance();
        let modes = normal.ncols();
        let (mut whole, mut alone) = (vec![0.0; points.len()], DVector::zeros(modes));
        let [from, to] = spectra.range_hz;
        let of_octave = |octave: &Band| {
            let within = [octave.low.max(from), octave.high.min(to)];
            let covariance = spectra.velocity_covariance(within, |hz| Weighting::A.energy_factor(hz))?;
            Some((LowRank::of(&covariance), covariance.diagonal()))
        };
        let found: Vec<Option<(LowRank, DVector<f64>)>> = octaves().par_iter().map(of_octave).collect();
        let mut factors = Vec::with_capacity(found.len());
        let mut present = Vec::with_capacity(found.len());
        for of_octave in found {
            present.push(of_octave.is_some());
            factors.extend(of_octave.map(|(factor, diagonal)| {
                alone += diagonal;
                factor
            }));
        }
        let mut forms = LowRank::forms(&factors, &normal).into_iter();
        let of_octave = |present: bool| {
            let forms = forms.next().filter(|_| present)?;
            Some(forms.into_iter().map(|form| impedance * form).collect())
        };
        let octaves: Vec<Option<Vec<f64>>> = present.into_iter().map(of_octave).collect();
        for energies in octaves.iter().flatten() {
            whole.iter_mut().zip(energies).for_each(|(sum, e)| *sum += e);
        }
        for (mode, energy) in alone.iter_mut().enumerate() {
            let column = normal.column(mode);
            let squares = points.iter().zip(&free).zip(column.iter());
            let area: f64 = squares
                .filter(|((_, free), _)| **free)
                .map(|((point, _), value)| point.weight * f64::from(*value).powi(2))
                .sum();
            *energy *= impedance * area;
        }
        Self {
            body,
            loss_factor: driven.loss_factor,
            origin: if tool { around.nose.into() } else { Vector3::zeros() },
            free,
            range_hz: spectra.range_hz,
            whole,
            octaves,
            modes: alone.as_slice().to_vec(),
            efficiencies,
        }
    }
}

impl ColouredSurface<'_> {
    /// Level of a mode alone at radiation efficiency 1 \[dB re 1 pW s\]; `None` for silence.
    pub(super) fn level_at_one(&self, mode: usize) -> Option<f64> {
        level(self.modes[mode])
    }

    /// Radiation efficiency of a mode at its natural frequency \[dB\]; `None` if it is not known.
    pub(super) fn efficiency_db(&self, mode: usize) -> Option<f64> {
        self.efficiencies?.of_mode(mode)
    }

    /// Level of a mode alone with its own radiation efficiency \[dB re 1 pW s\]; `None` if that is not known.
    pub(super) fn own_level(&self, mode: usize) -> Option<f64> {
        Some(self.level_at_one(mode)? + self.efficiency_db(mode)?)
    }

    /// The source of the body.
    pub(super) fn source(&self) -> &'static str {
        let kind = BodyKind::ALL.into_iter().find(|kind| kind.name() == self.body.name);
        kind.and_then(of_body).map_or(self.body.name, |source| source.name())
    }
}

/// Displacement of the modes along the normal, at one point of each face: points x modes.
fn normal_modes(surface: &Surface, points: &[QuadraturePoint], modes: &DMatrix<f32>) -> DMatrix<f32> {
    // The weights of a face's nodes for the displacement at the point.
    let mut parts: Vec<([f32; 3], usize)> = Vec::new();
    let mut ends = Vec::with_capacity(points.len());
    for point in points {
        let nodes = surface.faces[point.face].nodes.iter().zip(&point.shape);
        parts.extend(
            nodes.map(|(&node, weight)| ([0, 1, 2].map(|axis| (weight * point.normal[axis]) as f32), 3 * node)),
        );
        ends.push(parts.len());
    }
    let mut normal = DMatrix::zeros(points.len(), modes.ncols());
    let columns = modes.as_slice().par_chunks(modes.nrows().max(1));
    normal
        .as_mut_slice()
        .par_chunks_mut(points.len().max(1))
        .zip(columns)
        .for_each(|(normal, mode)| {
            let mut first = 0;
            for (value, &end) in normal.iter_mut().zip(&ends) {
                let part = |(n, at): &([f32; 3], usize)| n[0] * mode[*at] + n[1] * mode[at + 1] + n[2] * mode[at + 2];
                *value = parts[first..end].iter().map(part).sum();
                first = end;
            }
        });
    normal
}

/// Level of an energy \[dB re 1 pW s\]; `None` for silence.
pub(super) fn level(energy: f64) -> Option<f64> {
    (energy > 0.0).then(|| 10.0 * (energy / REFERENCE).log10())
}
