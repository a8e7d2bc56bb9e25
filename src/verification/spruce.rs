//! Two cantilevered spruce plates, compared with measurements and another code.

use nailnoise_fem::{Constraints, Material, ModalBasis, ModalSettings, Orthotropic, assemble, modes};
use nailnoise_meshes::{Block, block};
use nalgebra::Matrix3;

use super::plates::frequencies;
use super::row::{Case, Row};
use crate::error::Error;

const COMPUTED: Case = Case {
    name: "spruce cantilever of 3 mm, thin plate",
    source: "finite differences of an orthotropic thin plate, MAGPIE (Nemus-Project/magpie-matlab, Bologna)",
};
const MEASURED: Case = Case {
    name: "spruce cantilever of 3 mm, measured",
    source: "measured, with moduli that MAGPIE identified from these frequencies (the same repository)",
};
const GUESSED: Case = Case {
    name: "spruce cantilever of 4.5 mm, measured",
    source: "measured, with the moduli from which the identification begins (the same repository)",
};

/// Differences \[Hz\] between the bending modes of the 3 mm plate and both references, see `docs/limits.md`.
const STIFFER: [f64; 2] = [0.0, 17.0];

/// A plate whose grain runs along x, clamped at x = 0.
struct Cantilever {
    /// Length, width, thickness \[m\].
    size: [f64; 3],
    /// \[kg/m³\].
    density: f64,
    /// Moduli along and across the grain, and in shear \[Pa\].
    moduli: [f64; 3],
    /// Contraction across the grain under tension along it.
    poisson: f64,
}

impl Cantilever {
    /// Modes below a frequency. Moduli through the thickness are not published and have little effect on a thin plate;
    /// they are set to those across the grain, as if the wood were transversely isotropic.
    fn modes(&self, top_hz: f64) -> Result<ModalBasis, Error> {
        let mesh = block(&Block {
            size: self.size,
            divisions: [20, 10, 1],
            origin: [0.0; 3],
        })?;
        let [e1, e2, g12] = self.moduli;
        let nu23 = 0.3;
        let constants = Orthotropic {
            e1,
            e2,
            e3: e2,
            g12,
            g13: g12,
            g23: e2 / (2.0 * (1.0 + nu23)),
            nu12: self.poisson,
            nu13: self.poisson,
            nu23,
        };
        let wood = Material::orthotropic(&constants, &Matrix3::identity(), self.density)?;
        let system = assemble(&mesh, &[wood], &Constraints::clamped(&mesh, "x_min")?)?;
        Ok(modes(&system, &ModalSettings::below(top_hz), &|_, _| ())?)
    }
}

pub(super) fn rows() -> Result<Vec<Row>, Error> {
    let thin = Cantilever {
        size: [0.223, 0.114, 0.003],
        density: 473.9,
        moduli: [13.8e9, 0.831e9, 0.605e9],
        poisson: 0.51,
    };
    let thick = Cantilever {
        size: [0.212, 0.108, 0.0045],
        density: 457.0,
        moduli: [13.1e9, 0.881e9, 0.504e9],
        poisson: 0.4,
    };
    let (thin, thick) = (thin.modes(330.0)?, thick.modes(600.0)?);
    let mut rows = frequencies(COMPUTED, &thin, &[51.240, 99.849, 315.05], 1e-2);
    rows.extend(frequencies(MEASURED, &thin, &[52.0, 98.0, 311.0], 3e-2));
    let mut rows: Vec<Row> = rows.into_iter().map(|row| row.documented(STIFFER)).collect();
    rows.extend(frequencies(GUESSED, &thick, &[87.0, 160.0, 540.0], 1e-1));
    Ok(rows)
}
