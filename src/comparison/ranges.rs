//! Checks whether levels are sums over the same frequency range.

use super::finished::Finished;

/// Keys for the ends of the frequency range of levels.
const ENDS: [&str; 2] = ["analysis.range_low", "analysis.range_high"];

/// The frequency ranges of the results \[Hz\], if they are not all the same. A difference between their levels is then
/// not due only to the designs, because the wider range contains additional bands.
pub(super) fn unlike(results: &[Finished]) -> Option<Vec<[f64; 2]>> {
    let end = |result: &Finished, key: &str| {
        let input = result.inputs.iter().find(|input| input.key == key);
        // A result that does not state its range is not assumed to differ.
        input.and_then(|input| input.value.as_f64()).unwrap_or(f64::NAN)
    };
    let ranges: Vec<[f64; 2]> = results.iter().map(|result| ENDS.map(|key| end(result, key))).collect();
    let differs = |a: f64, b: f64| (a - b).abs() > 1e-9 * a.abs();
    let first = ranges.first()?;
    let unlike = ranges
        .iter()
        .any(|range| range.iter().zip(first).any(|(a, b)| differs(*a, *b)));
    unlike.then_some(ranges)
}

/// The warning to a reader, with the range of each design.
pub(super) fn warning(designs: &[String], ranges: &[[f64; 2]]) -> String {
    let each = designs
        .iter()
        .zip(ranges)
        .map(|(name, [low, high])| format!("{name} from {low} Hz to {high} Hz"));
    format!(
        "do not compare these levels: they are sums over unlike ranges of frequency ({}); give all designs the same \
         analysis.range_low and analysis.range_high",
        each.collect::<Vec<_>>().join(", ")
    )
}
