//! The uncertainty of a fitted penetration law as variables of a study: one of the specimen, and one a principal component of
//! the covariance of its coefficients.

use super::parameters::Parameter;
use super::variables::{Drawn, Kind, Scope, Variable};
use crate::design::inputs::cycle::fitted_law;
use crate::design::{Design, Value};
use crate::error::Error;

/// The key whose file holds the law; the variables are named after it.
const KEY: &str = "wood.penetration_fit";

/// A key whose scatter the specimens of a fit hold: to draw it too would count it twice.
const HELD: &str = "wood.hardness_modulus";

/// Leaves out what the scatter of a fitted law's specimens holds.
pub(super) fn leave_out_held(design: &Design, parameters: &mut Vec<Parameter>) -> Result<(), Error> {
    if fitted_law(design)?.is_some() {
        parameters.retain(|parameter| parameter.key != HELD);
    }
    Ok(())
}

/// Standard normal variables of the fitted laws of these designs, the specimen first; none without a fitted law.
pub(super) fn scores(designs: &[Design]) -> Result<Vec<Variable>, Error> {
    let mut most = 0;
    for design in designs {
        most = most.max(fitted_law(design)?.map_or(0, |law| law.draw_size()));
    }
    let variable = |place: usize| Variable {
        name: match place {
            0 => format!("{KEY}.specimen"),
            _ => format!("{KEY}.component_{place}"),
        },
        scope: Scope::Shot,
        kind: Kind::LawScore,
    };
    Ok((0..most).map(variable).collect())
}

/// The scores of a point, in their order.
pub(super) fn drawn_scores(variables: &[Variable], drawn: &[Option<Drawn>]) -> Vec<f64> {
    let scores = variables
        .iter()
        .zip(drawn)
        .filter_map(|(variable, drawn)| match (&variable.kind, drawn) {
            (Kind::LawScore, Some(Drawn::Value(Value::Number(score)))) => Some(*score),
            _ => None,
        });
    scores.collect()
}
