//! Fourier transforms of the modal accelerations of a body.

use std::collections::BTreeMap;
use std::ops::Range;
use std::sync::{Mutex, PoisonError};

use nailnoise_acoustics::fourier::TransformSettings;
use nailnoise_acoustics::radiation::ModalSpectra;
use nailnoise_fem::transient::{ModalResponse, Motion};
use nalgebra::DMatrix;

use crate::error::Error;

/// Modes whose motion is computed together: their forces are one matrix product.
const BLOCK: usize = 32;

/// Spectra within `range_hz` of the modal accelerations of the body at `index` of a response, and the accelerations of points
/// of that body at the response's samples (samples x points), given the displacement of each mode there (`points`, modes x
/// points).
///
/// # Errors
/// Those of the response and of the Fourier transform.
pub(crate) fn body_spectra(
    response: &ModalResponse,
    index: usize,
    range_hz: [f64; 2],
    points: &DMatrix<f64>,
) -> Result<(ModalSpectra, DMatrix<f64>), Error> {
    let settings = TransformSettings {
        range_hz,
        ..TransformSettings::default()
    };
    let sum = Mutex::new(OrderedSum {
        sum: DMatrix::zeros(response.samples(), points.ncols()),
        next: 0,
        early: BTreeMap::new(),
    });
    let spectra = ModalSpectra::from_blocks(
        points.nrows(),
        BLOCK,
        response.samples(),
        response.step,
        &settings,
        |modes| {
            let motion = response.modal(index, modes.clone(), Motion::Acceleration)?;
            if points.ncols() > 0 {
                let part = &motion * points.rows(modes.start, modes.len());
                sum.lock().unwrap_or_else(PoisonError::into_inner).add(modes, part);
            }
            Ok::<_, Error>(motion)
        },
    )?;
    let OrderedSum { sum, .. } = sum.into_inner().unwrap_or_else(PoisonError::into_inner);
    Ok((spectra, sum))
}

/// A sum whose terms arrive in any order and are added in order, so that the result does not depend on the threads.
struct OrderedSum {
    sum: DMatrix<f64>,
    /// First mode of the next term.
    next: usize,
    /// Terms that arrived early, each with the mode after its last.
    early: BTreeMap<usize, (usize, DMatrix<f64>)>,
}

impl OrderedSum {
    fn add(&mut self, modes: Range<usize>, term: DMatrix<f64>) {
        self.early.insert(modes.start, (modes.end, term));
        while let Some((end, term)) = self.early.remove(&self.next) {
            self.sum += term;
            self.next = end;
        }
    }
}

/// The spectra of several bodies as those of one; above the top frequency of a body its modes are at rest.
pub(crate) fn side_by_side(spectra: &[ModalSpectra]) -> ModalSpectra {
    let modes = spectra.iter().map(|s| s.accelerations.nrows()).sum();
    let widest = spectra.iter().max_by_key(|s| s.frequency.len());
    let (frequency, range_hz) = widest.map_or_else(Default::default, |s| (s.frequency.clone(), s.range_hz));
    let mut accelerations = DMatrix::zeros(modes, frequency.len());
    let mut row = 0;
    for s in spectra {
        let (rows, bins) = s.accelerations.shape();
        accelerations
            .view_mut((row, 0), (rows, bins))
            .copy_from(&s.accelerations);
        row += rows;
    }
    ModalSpectra {
        frequency,
        accelerations,
        range_hz,
    }
}
