//! Computed modes held against measured ones: the modal assurance criterion.

use std::collections::HashMap;

use nailnoise_meshes::uff::Measurement;
use nalgebra::{Complex, DMatrix, Point3};

use crate::pipeline::Body;

/// How measured points were found on a body, and how alike the modes are.
#[derive(Debug, Clone, PartialEq, serde::Serialize)]
pub struct Correlation {
    /// Whether points were matched by position; otherwise by number.
    pub by_position: bool,
    /// Measured points that were found.
    pub matched: usize,
    /// Measured points that were not.
    pub unmatched: usize,
    /// Largest distance between a measured point and its node \[m\]; 0 when matched by number.
    pub farthest: f64,
    /// The best computed mode for each measured one.
    pub pairs: Vec<Pair>,
    /// MAC, a row a measured mode, a column a computed one.
    pub mac: Vec<Vec<f64>>,
}

/// A measured mode and the computed one most like it.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize)]
pub struct Pair {
    /// Measured frequency \[Hz\].
    pub measured_hz: f64,
    /// Number of the computed mode, from 1.
    pub mode: usize,
    /// Its frequency \[Hz\].
    pub computed_hz: f64,
    /// Their MAC.
    pub mac: f64,
}

/// Compares measured modes with those of a body,
///
/// ```text
/// MAC = |phi_m^H phi_c|^2 / ((phi_m^H phi_m) (phi_c^H phi_c))
/// ```
///
/// (Allemang and Brown, IMAC 1982) over the degrees of freedom that were measured: those not zero in all modes. A measured
/// point is the node of the body's surface nearest to it, no farther than `reach` \[m\]; in a file without coordinates it
/// is the node of its number less 1. None when no point is found.
pub fn correlate((body, shapes): (&Body, &DMatrix<f64>), measurement: &Measurement, reach: f64) -> Option<Correlation> {
    let by_position = !measurement.nodes.is_empty();
    let mut labels: Vec<u64> = measurement
        .modes
        .iter()
        .flat_map(|mode| mode.shape.iter().map(|(label, _)| *label))
        .collect();
    labels.sort_unstable();
    labels.dedup();
    let mut farthest = 0.0_f64;
    let mut node_of: HashMap<u64, usize> = HashMap::new();
    for &label in &labels {
        if by_position {
            let near = measurement.nodes.get(&label).and_then(|p| nearest(body, p));
            if let Some((node, distance)) = near.filter(|(_, distance)| *distance <= reach) {
                farthest = farthest.max(distance);
                node_of.insert(label, node);
            }
        } else if let Some(node) = usize::try_from(label).ok().and_then(|label| label.checked_sub(1))
            && node < body.mesh.nodes.len()
        {
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
            (0..body.basis.hz.len())
                .map(|column| {
                    let (mut cross, mut own, mut other) = (Complex::new(0.0, 0.0), 0.0, 0.0);
                    for dof @ (label, axis) in &dofs {
                        let a = mode.get(dof).copied().unwrap_or_default();
                        let b = shapes[(3 * node_of[label] + axis, column)];
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
            Some(Pair {
                measured_hz: mode.hz,
                mode: best + 1,
                computed_hz: body.basis.hz[best],
                mac,
            })
        })
        .collect();
    Some(Correlation {
        by_position,
        matched: node_of.len(),
        unmatched: labels.len() - node_of.len(),
        farthest,
        pairs,
        mac,
    })
}

fn nearest(body: &Body, point: &Point3<f64>) -> Option<(usize, f64)> {
    let surface = &body.surface;
    let distances = surface.points.iter().map(|p| (p - point).norm());
    let (best, distance) = distances.enumerate().min_by(|a, b| a.1.total_cmp(&b.1))?;
    Some((surface.volume_nodes[best], distance))
}
