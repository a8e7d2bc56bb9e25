//! The joint draws of a posterior: a row for each draw.

use super::levels::ByLevels;
use super::posterior::Posterior;
use crate::design::JointDraws;
use crate::study::{code_of_joint_draws, code_of_levelled_draws};

/// The joint draws of the keys and, with levels, of all inputs of the levels.
pub(super) fn joint(posterior: &Posterior, levels: Option<&ByLevels>, measured: &str) -> JointDraws {
    let tool = &posterior.tool;
    let mut names: Vec<String> = (0..tool.keys()).map(|k| tool.name(k).to_owned()).collect();
    let particles = posterior.state.particles.iter();
    let mut rows: Vec<Vec<f64>> = particles
        .map(|own| (0..tool.keys()).map(|k| tool.value(k, &own.z)).collect())
        .collect();
    let mut code = code_of_joint_draws();
    if let Some(levels) = levels {
        names.extend(levels.draws.further_names());
        let further = levels.chosen.iter().map(|&draw| levels.draws.further(draw));
        rows.iter_mut()
            .zip(further)
            .for_each(|(row, further)| row.extend(further));
        code = code_of_levelled_draws();
    }
    JointDraws::new(measured.to_owned(), code, names, rows)
}
