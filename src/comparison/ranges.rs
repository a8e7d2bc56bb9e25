//! Whether levels are sums over the same range of frequency.

use super::finished::Finished;

/// Keys of the ends of the range over which levels are summed up.
const ENDS: [&str; 2] = ["analysis.range_low", "analysis.range_high"];

/// The ranges of the results \[Hz\], if they are not all the same. A difference of their levels is then not that of the
/// designs: the wider range contains bands that the other one leaves out.
pub(super) fn unlike(results: &[Finished]) -> Option<Vec<[f64; 2]>> {
    let end = |result: &Finished, key: &str| {
        let input = result.inputs.iter().find(|input| input.key == key);
        // The range of a result that does not state it is not known to be another.
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
