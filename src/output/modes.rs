//! `modes.csv`: the modes of the bodies.

use super::table::table;
use crate::error::Error;
use crate::stages::spectra::BodyInMotion;

/// `modes.csv`: every mode of every body that is included, also rigid-body modes, with the damping of the material.
pub(super) fn modes(moving: &[BodyInMotion]) -> Result<Vec<u8>, Error> {
    let header = [
        "body",
        "mode",
        "frequency [Hz]",
        "loss factor [-]",
        "eigen residual [-]",
    ];
    let rows = moving.iter().flat_map(|BodyInMotion { body, loss_factor, .. }| {
        let basis = &body.basis;
        basis
            .hz
            .iter()
            .zip(&basis.residuals)
            .enumerate()
            .map(|(number, (hz, residual))| {
                let (hz, eta) = if basis.rigid[number] {
                    (0.0, 0.0)
                } else {
                    (*hz, *loss_factor)
                };
                let number = (number + 1).to_string();
                [
                    body.name.to_owned(),
                    number,
                    format!("{hz:.3}"),
                    eta.to_string(),
                    format!("{residual:.1e}"),
                ]
            })
    });
    table(header, rows)
}
