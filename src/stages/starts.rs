//! Scatter of the level of a bouncing workpiece.
//!
//! A block that leaves its support and lands magnifies small differences that no design specifies: gaps of a micrometre
//! change when and how it lands, and so its vibration. The response is computed for several such starts; their spread is part
//! of the level's uncertainty.

use nailnoise_fem::transient::SupportLaw;

use super::response::Shot;
use crate::error::Error;
use crate::result::Starts;

/// A-weighted levels of the workpiece for `count` starts, `first` being that of start 0 \[dB\]; none for fewer than two starts,
/// or for a workpiece that cannot lose contact. `level` computes that of another start.
///
/// # Errors
/// Those of `level`.
pub(crate) fn starts(
    shot: &Shot,
    count: u32,
    first: Option<f64>,
    level: impl Fn(&Shot) -> Result<Option<f64>, Error>,
) -> Result<Option<Starts>, Error> {
    let unilateral = shot
        .supports
        .iter()
        .any(|support| support.law == SupportLaw::Unilateral);
    let (Some(first), true) = (first, unilateral && count > 1) else {
        return Ok(None);
    };
    let mut levels = vec![first];
    for start in 1..count {
        levels.extend(level(&shot.with_start(start))?);
    }
    let count = levels.len() as f64;
    let mean = levels.iter().sum::<f64>() / count;
    let squares: f64 = levels.iter().map(|level| (level - mean).powi(2)).sum();
    Ok(Some(Starts {
        mean_lwa_db: mean,
        deviation_db: (squares / (count - 1.0)).sqrt(),
        lwa_db: levels,
    }))
}
