//! Modal assurance criterion: computed modes compared with measured ones.

use std::collections::HashMap;

use nailnoise_meshes::Surface;
use nailnoise_meshes::uff::Measurement;
use nalgebra::{Complex, DMatrix, Point3};
use serde::Serialize;

/// Result of a comparison: how measured points were matched with nodes, and how similar the modes are.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Correlation {
    /// Whether points were matched by position instead of by number.
    pub by_position: bool,
    /// Number of measured points that were matched.
    pub matched: usize,
    /// Number of measured points that were not matched.
    pub unmatched: usize,
    /// Largest distance between a measured point and its node \[m\]; none if no point has coordinates.
    pub farthest: Option<f64>,
    /// The most similar computed mode for each measured one.
    pub pairs: Vec<ModePair>,
    /// MAC: one row per measured mode, one column per computed mode.
    pub mac: Vec<Vec<f64>>,
}

/// A measured mode and the computed mode most similar to it.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct ModePair {
    /// Measured frequency \[Hz\].
    pub measured_hz: f64,
    /// Number of the computed mode, from 1.
    pub mode: usize,
    /// Its frequency \[Hz\].
    pub computed_hz: f64,
    /// Their MAC.
    pub mac: f64,
}

/// How measured points are matched with nodes.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Pairing {
    /// Each point with the nearest node of the surface.
    Position {
        /// Largest distance between them \[m\].
        reach: f64,
    },
    /// Point n with node n - 1 of the mesh, as [`nailnoise_meshes::uff::text`] numbers them.
    Number,
}

/// Compares measured modes with computed ones of frequencies `hz` \[Hz\] and `shapes` of 3 nodes x modes or more.
///
/// ```text
/// MAC = |phi_m^H phi_c|^2 / ((phi_m^H phi_m) (phi_c^H phi_c))
/// ```
///
/// (Allemang and Brown, IMAC 1982) over the measured degrees of freedom, along the axes of each measured point; those
/// that are zero in all modes do not count. None if no point is matched.
pub fn correlate(
    (hz, shapes): (&[f64], &DMatrix<f64>),
    surface: &Surface,
    measurement: &Measurement,
    pairing: Pairing,
) -> Option<Correlation> {
    let nodes = shapes.nrows() / 3;
    let mut labels: Vec<u64> = measurement
        .modes
        .iter()
        .flat_map(|mode| mode.shape.iter().map(|(label, _)| *label))
        .collect();
    labels.sort_unstable();
    labels.dedup();
    let mut farthest: Option<f64> = None;
    let mut node_of: HashMap<u64, usize> = HashMap::new();
    for &label in &labels {
        let place = measurement.nodes.get(&label);
        let matched = match pairing {
            Pairing::Position { reach } => place
                .and_then(|place| nearest(surface, place))
                .filter(|(_, distance)| *distance <= reach)
                .map(|(node, distance)| (node, Some(distance))),
            Pairing::Number => usize::try_from(label)
                .ok()
                .and_then(|label| label.checked_sub(1))
                .filter(|node| *node < nodes)
                .map(|node| (node, place.and_then(|place| distance_of(surface, node, place)))),
        };
        if let Some((node, distance)) = matched {
            farthest = farthest.into_iter().chain(distance).reduce(f64::max);
            node_of.insert(label, node);
        }
    }
    if node_of.is_empty() {
        return None;
    }
    let measured: Vec<HashMap<(u64, usize), Complex<f64>>> = measurement
        .modes
        .iter()
        .map(|mode| {
            let values = mode.shape.iter().filter(|(label, _)| node_of.contains_key(label));
            values
                .flat_map(|(label, u)| (0..3).map(move |axis| ((*label, axis), u[axis])))
                .collect()
        })
        .collect();
    let mut dofs: Vec<(u64, usize)> = measured
        .iter()
        .flat_map(|mode| mode.iter().filter(|(_, u)| u.norm_sqr() > 0.0).map(|(dof, _)| *dof))
        .collect();
    dofs.sort_unstable();
    dofs.dedup();
    let mac: Vec<Vec<f64>> = measured
        .iter()
        .map(|mode| {
            (0..hz.len())
                .map(|column| {
                    let (mut cross, mut own, mut other) = (Complex::new(0.0, 0.0), 0.0, 0.0);
                    for dof @ (label, axis) in &dofs {
                        let a = mode.get(dof).copied().unwrap_or_default();
                        let row = 3 * node_of[label];
                        let b = match measurement.axes.get(label) {
                            Some(axes) => (0..3).map(|k| axes[(*axis, k)] * shapes[(row + k, column)]).sum(),
                            None => shapes[(row + axis, column)],
                        };
                        cross += a.conj() * b;
                        own += a.norm_sqr();
                        other += b * b;
                    }
                    let product = own * other;
                    if product > 0.0 { cross.norm_sqr() / product } else { 0.0 }
                })
                .collect()
        })
        .collect();
    let pairs = measurement
        .modes
        .iter()
        .zip(&mac)
        .filter_map(|(mode, row)| {
            let (best, &mac) = row.iter().enumerate().max_by(|a, b| a.1.total_cmp(b.1))?;
            Some(ModePair {
                measured_hz: mode.hz,
                mode: best + 1,
                computed_hz: hz[best],
                mac,
            })
        })
        .collect();
    Some(Correlation {
        by_position: matches!(pairing, Pairing::Position { .. }),
        matched: node_of.len(),
        unmatched: labels.len() - node_of.len(),
        farthest,
        pairs,
        mac,
    })
}

/// Volume node of the surface point nearest to `point`, and its distance \[m\].
fn nearest(surface: &Surface, point: &Point3<f64>) -> Option<(usize, f64)> {
    let distances = surface.points.iter().map(|p| (p - point).norm());
    let (best, distance) = distances.enumerate().min_by(|a, b| a.1.total_cmp(&b.1))?;
    Some((surface.volume_nodes[best], distance))
}

/// Distance between a volume node and a point \[m\]; none if the node is not on the surface.
fn distance_of(surface: &Surface, node: usize, point: &Point3<f64>) -> Option<f64> {
    let place = surface.volume_nodes.iter().position(|own| *own == node)?;
    Some((surface.points[place] - point).norm())
}
