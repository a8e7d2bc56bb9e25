//! One-third octaves of measured levels.

use nailnoise_acoustics::signals::{Band, bands_of};
use nailnoise_documents::{KeyError, Keys, Value};
use nailnoise_quantities::dimension::FREQUENCY;
use nailnoise_quantities::measure;

use crate::design::Design;

/// Relative rounding of frequencies.
const ROUNDING: f64 = 1e-6;

/// Nominal mid-band frequencies of the bands that are completely within a range \[Hz\]. The prediction of a band that
/// the range cuts does not contain all of its energy.
pub(super) fn within([low, high]: [f64; 2]) -> Vec<f64> {
    let is_within = |own: &Band| own.low >= low * (1.0 - ROUNDING) && own.high <= high * (1.0 + ROUNDING);
    let bands = bands_of([low, high]).into_iter().filter(is_within);
    bands.map(|own| own.nominal_hz()).collect()
}

/// The range of a design's levels \[Hz\].
pub(super) fn range(design: &Design) -> [f64; 2] {
    [design.analysis.range_low, design.analysis.range_high]
}

/// The nominal mid-band frequency that a value names \[Hz\].
///
/// # Errors
/// If it is not that of a band within the range of the design.
pub(super) fn band(table: &Keys<'_, '_>, value: &Value<'_>, design: &Design) -> Result<f64, KeyError> {
    let hz = table.number("band", value, |text| measure(text, FREQUENCY))?;
    let range = range(design);
    let known = within(range);
    let is_own = |own: &&f64| (hz / **own - 1.0).abs() < ROUNDING;
    known.iter().find(is_own).copied().ok_or_else(|| {
        let names: Vec<String> = known.iter().map(f64::to_string).collect();
        let problem = format!(
            "is {hz} Hz, which is not a one-third octave within {} to {} Hz",
            range[0], range[1]
        );
        table.wrong(
            "band",
            value.span(),
            problem,
            format!("choose from {} Hz", names.join(", ")),
        )
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bands_that_the_range_cuts_are_left_out() {
        // The band of 100 Hz begins at 89.1 Hz, that of 160 Hz ends at 177.8 Hz.
        assert_eq!(within([89.0, 178.0]), [100.0, 125.0, 160.0]);
        assert_eq!(within([90.0, 177.0]), [125.0]);
    }
}
