//! What determines the draws of a calibration.

use super::measurements::Measurements;
use super::tool::Tool;
use crate::design::Design;
use crate::graph::program_key;
use crate::store::Key;

/// Key of candidates and draws: everything except which readings are used.
pub(super) fn key(design: &Design, tool: &Tool, measured: &Measurements, (draws, seed): (usize, u64)) -> Key {
    let variables: Vec<String> = tool.sampler.variables().iter().map(|own| format!("{own:?}")).collect();
    let conditions: Vec<String> = measured.conditions.iter().map(|own| own.design.digest()).collect();
    let data = format!("{:?} {:?} {:?}", measured.data, measured.correlations, measured.direct);
    let shown: Vec<String> = measured
        .conditions
        .iter()
        .map(|own| format!("{:?} {:?}", own.shown, own.outcomes))
        .collect();
    program_key()
        .with(&design.digest())
        .with(&variables)
        .with(&tool.shared)
        .with(&conditions)
        .with(&shown)
        .with(&data)
        .with(&design.study().require)
        .with(&draws)
        .with(&seed)
}
