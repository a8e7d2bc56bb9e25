//! The uncertainty of a fitted penetration law as variables of a study: one for the specimen, and one for each
//! principal component of the covariance of its coefficients.

use super::parameters::Parameter;
use crate::design::Design;
use crate::design::inputs::cycle::fitted_law;
use crate::error::Error;

/// The key whose file contains the law; the variables are named after it.
const KEY: &str = "wood.penetration_fit";

/// A key whose scatter is already included in the specimens of a fit, so that drawing it too would count it twice.
const HELD: &str = "wood.hardness_modulus";

/// Removes the key whose scatter the specimens of a fitted law include.
pub(super) fn leave_out_held(design: &Design, parameters: &mut Vec<Parameter>) -> Result<(), Error> {
    if fitted_law(design)?.is_some() {
        parameters.retain(|parameter| parameter.key != HELD);
    }
    Ok(())
}

/// Names of the standard normal scores of the fitted laws of these designs, the specimen first; empty without a fitted
/// law.
pub(super) fn score_names(designs: &[Design]) -> Result<Vec<String>, Error> {
    let mut most = 0;
    for design in designs {
        most = most.max(fitted_law(design)?.map_or(0, |law| law.draw_size()));
    }
    let name = |place: usize| match place {
        0 => format!("{KEY}.specimen"),
        _ => format!("{KEY}.component_{place}"),
    };
    Ok((0..most).map(name).collect())
}
