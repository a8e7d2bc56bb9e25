//! Estimates the cost of a modal solution in advance.

use std::f64::consts::{PI, TAU};

use nailnoise_meshes::{Mesh, MeshError, Quality, Surface};
use serde::Serialize;

use crate::{Material, mirror_planes};

/// Estimated cost of a modal solution, accurate to a factor of about two.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct ModalCost {
    /// Degrees of freedom.
    pub dofs: usize,
    /// Number of modes.
    pub modes: f64,
    /// Number of independent problems into which mirror planes divide the body.
    pub sectors: usize,
    /// Memory \[GB\].
    pub gigabytes: f64,
    /// Processor time \[s\].
    pub cpu_seconds: f64,
}

impl ModalCost {
    /// Estimates the cost of all modes below `hz` of a mesh with one material per part and this mesh quality.
    ///
    /// The number of modes is the larger of two leading terms. For solids it is N = V w^3 / (6 pi^2) sum 1/c^3 (Dupuis,
    /// Mazo and Onsager 1960). For plates it is N = A w sqrt(12)/(4 pi c_P t) (Courant and Hilbert). With n degrees of
    /// freedom and nested dissection, the factor L has 28 n^(4/3) values for a compact body and 28 n lg2 n for thin
    /// walls; Lanczos needs s = 4 N solves and stores as many vectors. The operations are 6 L^2/n for two factors, 4 L
    /// s for the solves, and 4 n s^2 for orthogonalising the vectors. Mirror planes divide n and N by the number of
    /// sectors, and multiply the work by it.
    ///
    /// # Errors
    /// [`MeshError`] of the quadrature; does not occur for a valid mesh.
    pub fn estimate(mesh: &Mesh, materials: &[Material], quality: &Quality, hz: f64) -> Result<Self, MeshError> {
        let (volumes, thicknesses) = (mesh.part_volumes()?, wall_thicknesses(mesh)?);
        let parts = volumes.iter().zip(&thicknesses).zip(materials);
        let of_part = |((&volume, &thickness), material)| modes_below(material, volume, thickness, hz);
        let modes = 6.0 + parts.map(of_part).sum::<f64>();
        let thin = quality.skin_area * quality.longest_edge > 3.0 * quality.volume;
        let sectors = 1 << mirror_planes(mesh, materials);
        Ok(Self::of(3.0 * mesh.nodes.len() as f64, modes, sectors, thin))
    }

    /// Estimates the cost of `modes` modes with `n` degrees of freedom in `sectors` independent problems; `thin` is
    /// true for thin-walled bodies. For the formulas, see [`estimate`](Self::estimate).
    pub fn of(n: f64, modes: f64, sectors: u32, thin: bool) -> Self {
        let parallel = f64::from(sectors);
        let m = n / parallel;
        let factor = 28.0 * if thin { m * m.log2() } else { m.powf(4.0 / 3.0) };
        let vectors = 4.0 * modes / parallel + 64.0;
        let operations = 6.0 * factor * factor / m + 4.0 * factor * vectors + 4.0 * m * vectors * vectors;
        Self {
            dofs: n as usize,
            modes,
            sectors: sectors as usize,
            gigabytes: (8.0 * parallel * (factor + m * vectors) + 8.0 * factor + SPARSE * n) / 1e9,
            cpu_seconds: parallel * operations / RATE,
        }
    }
}

/// Number of elastic modes below `hz` of a solid with this volume \[m3\] and wall thickness \[m\], from the leading
/// terms given in [`ModalCost::estimate`].
pub fn modes_below(material: &Material, volume: f64, thickness: f64, hz: f64) -> f64 {
    let omega = TAU * hz;
    let c = |k: usize| (material.stiffness()[(k, k)] / material.density()).sqrt();
    let sum: f64 = (0..3)
        .map(|k| c(k).powi(-3) / 3.0 + 2.0 * c(k + 3).powi(-3) / 3.0)
        .sum();
    let solid = volume * omega.powi(3) / (6.0 * PI * PI) * sum;
    let plate = volume / thickness * omega * 12f64.sqrt() / (2.0 * TAU * plate_speed(c(5)) * thickness);
    solid.max(CLAMPED_SHARE * plate)
}

/// Longitudinal wave speed of a plate, given the shear speed: c_P = sqrt(2/(1 - nu)) c_S with nu = 0.3.
fn plate_speed(c_s: f64) -> f64 {
    (2.0_f64 / 0.7).sqrt() * c_s
}

/// Ratio of the number of modes in narrow walls with fixed edges to that of a large plate (0.51 for the tool body, 0.55
/// for the steel tables).
const CLAMPED_SHARE: f64 = 0.55;

/// Memory for stiffness and mass \[byte per degree of freedom\].
const SPARSE: f64 = 2e3;

/// Operations per second and core, measured on block, tables and tool body: 16e9 to 22e9 on an x86-64 of 2022.
const RATE: f64 = 18e9;

/// Mean wall thickness of each part, twice its volume divided by its share of the skin area \[m\].
///
/// # Errors
/// [`MeshError`] of the quadrature; does not occur for a valid mesh.
pub fn wall_thicknesses(mesh: &Mesh) -> Result<Vec<f64>, MeshError> {
    let volumes = mesh.part_volumes()?;
    let skin = Surface::of(mesh);
    let mut areas = vec![0.0; volumes.len()];
    for point in skin.quadrature(3)? {
        areas[mesh.parts[skin.faces[point.face].of.element]] += point.weight;
    }
    Ok(volumes
        .iter()
        .zip(areas)
        .map(|(volume, area)| 2.0 * volume / area)
        .collect())
}

/// The element side that is longest relative to the shortest wavelength along it.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct ShortestWave {
    /// Frequency \[Hz\].
    pub hz: f64,
    /// Wall thickness \[m\].
    pub thickness: f64,
    /// Shortest wavelength along that side \[m\].
    pub shortest: f64,
    /// Length of that side \[m\].
    pub side: f64,
    /// Number of such sides per wavelength.
    pub elements: f64,
}

impl ShortestWave {
    /// The shortest wavelengths along all element sides of a part with this wall thickness \[m\], in a solid and in a
    /// wall (Cremer, Heckl and Petersson, *Structure-Borne Sound*, section 3.3).
    ///
    /// ```text
    /// lambda_S = c_S / f,   lambda_B = sqrt(1.8 c_L t / f),
    /// ```
    ///
    /// where c_S and c_L are the wave speeds of the material in the direction of the side. Elements that are long only
    /// along the grain thus do not count as coarse.
    pub fn of_part(mesh: &Mesh, part: usize, material: &Material, hz: f64, thickness: f64) -> Self {
        let mut worst = Self {
            hz,
            thickness,
            shortest: f64::INFINITY,
            side: 0.0,
            elements: f64::INFINITY,
        };
        for view in mesh.elements().filter(|view| view.part == part) {
            for &[a, b] in view.kind.edges() {
                let edge = mesh.nodes[view.nodes[b]] - mesh.nodes[view.nodes[a]];
                let side = edge.norm();
                let [slow, fast] = material.wave_speeds(&(edge / side));
                let shortest = (slow / hz).min((1.8 * fast * thickness / hz).sqrt());
                if shortest / side < worst.elements {
                    worst = Self {
                        shortest,
                        side,
                        elements: shortest / side,
                        ..worst
                    };
                }
            }
        }
        worst
    }
}
