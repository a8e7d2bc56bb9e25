//! Uniform time axes, and the first sample that is not uniform.

use super::fault::Fault;
use super::{EVENNESS, SAME_RATE};

/// Number of samples in a uniform section from which its step can be determined.
const PIECE: usize = 3;

/// Sampling rate and first time of a uniform time axis \[s\].
///
/// A rate that equals an integer within the six digits of a universal file is rounded to it.
pub(super) fn even_axis(times: &[f64]) -> Result<(f64, f64), Fault> {
    let [start, .., end] = times else {
        return Err(Fault::Empty { samples: times.len() });
    };
    let step = (end - start) / (times.len() - 1) as f64;
    let off = |index: usize| (times[index] - (start + step * index as f64)).abs() > EVENNESS * step;
    if step > 0.0 && step.is_finite() && !(0..times.len()).any(off) {
        return Ok((nominal(1.0 / step), *start));
    }
    Err(uneven(times))
}

/// The first sample that deviates from the uniform axis of the preceding samples or, if these are too few, of the
/// following ones.
fn uneven(times: &[f64]) -> Fault {
    let mut steps: Vec<f64> = times.windows(2).map(|pair| pair[1] - pair[0]).collect();
    steps.sort_by(f64::total_cmp);
    let median = steps[steps.len() / 2];
    if let Some(index) = (1..times.len())
        .find(|index| times[*index] <= times[*index - 1])
        .filter(|_| median <= 0.0)
    {
        return Fault::NotIncreasing {
            sample: index + 1,
            time: times[index],
            before: times[index - 1],
        };
    }
    let fault = |index: usize, expected: f64| Fault::Uneven {
        sample: index + 1,
        time: times[index],
        expected,
    };
    let last = times.len() - 1;
    let forwards = piece(median, last, |index| times[index] - times[0]);
    let backwards = piece(median, last, |index| times[last] - times[last - index]);
    match (forwards, backwards) {
        (Some((index, _)), Some((behind, away))) if index < PIECE && behind >= PIECE => {
            fault(last - behind, times[last] - away)
        }
        (Some((index, away)), _) => fault(index, times[0] + away),
        // Seen from the first sample, all rounding errors are just within the limit.
        (None, _) => fault(last, times[0] + median * last as f64),
    }
}

/// The first of the indices 1 to `last` whose distance from index 0 is not a multiple of the step, and the distance
/// expected there. The steps that are consistent with all distances up to an index form an interval, which each further
/// index narrows.
fn piece(median: f64, last: usize, distance: impl Fn(usize) -> f64) -> Option<(usize, f64)> {
    let (mut low, mut high) = (0.5 * median, 1.5 * median);
    let mut step = median;
    for index in 1..=last {
        let count = index as f64;
        low = low.max((distance(index) - EVENNESS * median) / count);
        high = high.min((distance(index) + EVENNESS * median) / count);
        if low > high {
            return Some((index, step * count));
        }
        step = 0.5 * (low + high);
    }
    None
}

fn nominal(rate: f64) -> f64 {
    let whole = rate.round();
    if (rate - whole).abs() <= 0.5 * SAME_RATE * rate {
        whole
    } else {
        rate
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Index and expected time of the first deviating sample.
    fn off(times: &[f64]) -> (usize, f64) {
        match even_axis(times) {
            Err(Fault::Uneven { sample, expected, .. }) => (sample, expected),
            other => panic!("{other:?}"),
        }
    }

    #[test]
    fn the_sample_that_is_off_is_named_with_the_time_where_it_should_be() {
        for (times, sample, expected) in [
            (&[1.0, 2.0, 3.0, 4.0, 6.0][..], 5, 5.0),
            (&[0.0, 5.0, 6.0, 7.0, 8.0], 1, 4.0),
            (&[1.0, 2.0, 3.0, 4.5, 5.0, 6.0, 7.0], 4, 4.0),
            (&[0.0, 0.0, 1.0, 2.0, 3.0, 4.0], 1, -1.0),
            (&[0.0, 1.0, 2.0, 3.0, 2.5, 5.0, 6.0], 5, 4.0),
        ] {
            let (found, time) = off(times);
            assert_eq!(found, sample, "{times:?}");
            assert!((time - expected).abs() < 0.1, "{times:?}: {time}");
        }
    }

    #[test]
    fn a_missing_sample_of_many_is_found_at_its_place() {
        let times: Vec<f64> = (0..20_000)
            .filter(|i| *i != 7000)
            .map(|i| f64::from(i) / 48e3)
            .collect();
        let (sample, expected) = off(&times);
        assert_eq!(sample, 7001);
        assert!((expected * 48e3 - 7000.0).abs() < 1e-2, "{}", expected * 48e3);
    }

    #[test]
    fn times_that_fall_or_stay_are_refused() {
        for times in [[0.0, 0.0, 0.0, 0.0], [3.0, 2.0, 1.0, 0.0]] {
            let fault = even_axis(&times);
            assert!(
                matches!(fault, Err(Fault::NotIncreasing { sample: 2, .. })),
                "{fault:?}"
            );
        }
    }

    #[test]
    fn rounded_times_are_even() {
        let times: Vec<f64> = (0..=960).map(|i| (f64::from(i) / 48e3 * 1e6).round() * 1e-6).collect();
        assert_eq!(even_axis(&times).ok().map(|(rate, _)| rate.round()), Some(48_000.0));
    }
}
