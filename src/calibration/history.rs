//! Values of a recorded history between its samples and outside them.

use crate::sensitivity::interpolated;

/// Value of a history at a time up to `end` \[s\]. Before the trigger pull and after a record that ended early, the
/// tool is at rest.
pub(super) fn interpolated_clamped(values: &[f64], interval: f64, time: f64, end: f64) -> Option<f64> {
    let last = interval * values.len().checked_sub(1)? as f64;
    if time > end.max(last) {
        return None;
    }
    interpolated(values, interval, time.clamp(0.0, last))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn values_outside_the_record_are_those_of_its_ends() {
        let at = |time: f64| interpolated_clamped(&[1.0, 3.0, 5.0], 0.5, time, 2.0);
        assert_eq!(
            [-1.0, 0.25, 1.0, 1.5].map(at),
            [Some(1.0), Some(2.0), Some(5.0), Some(5.0)]
        );
        assert_eq!(at(2.5), None);
    }
}
