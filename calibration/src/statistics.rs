//! Statistics of weighted draws.

/// The `p` quantile of some values, which are sorted in place. The values are the points of the distribution at the
/// midpoints of equal parts, with linear interpolation. NaN for an empty list.
pub fn quantile_of(values: &mut [f64], p: f64) -> f64 {
    values.sort_by(f64::total_cmp);
    let weights = vec![1.0; values.len()];
    sorted_quantile(values, &weights, p)
}

/// Same as [`quantile_of`] for weighted values; the weights need not sum to 1.
pub fn weighted_quantile(values: &[f64], weights: &[f64], p: f64) -> f64 {
    let mut order: Vec<usize> = (0..values.len()).collect();
    order.sort_by(|&a, &b| values[a].total_cmp(&values[b]));
    let values: Vec<f64> = order.iter().map(|&k| values[k]).collect();
    let weights: Vec<f64> = order.iter().map(|&k| weights[k]).collect();
    sorted_quantile(&values, &weights, p)
}

fn sorted_quantile(values: &[f64], weights: &[f64], p: f64) -> f64 {
    let total: f64 = weights.iter().sum();
    let mut below = 0.0;
    let mut previous: Option<(f64, f64)> = None;
    for (value, weight) in values.iter().zip(weights) {
        let middle = (below + 0.5 * weight) / total;
        if middle >= p {
            return match previous {
                Some((at, from)) if middle > at => from + (value - from) * (p - at) / (middle - at),
                _ => *value,
            };
        }
        (below, previous) = (below + weight, Some((middle, *value)));
    }
    previous.map_or(f64::NAN, |(_, value)| value)
}

/// Effective sample size (sum w)^2/sum w^2; 0 if all weights are 0.
pub fn effective_size(weights: &[f64]) -> f64 {
    let (sum, squares) = weights
        .iter()
        .fold((0.0, 0.0), |(sum, squares), w| (sum + w, squares + w * w));
    if squares > 0.0 { sum * sum / squares } else { 0.0 }
}

/// log(mean exp x), without overflow.
pub fn log_mean_exp(numbers: &[f64]) -> f64 {
    let most = numbers.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    if most == f64::NEG_INFINITY {
        return most;
    }
    let sum: f64 = numbers.iter().map(|x| (x - most).exp()).sum();
    most + (sum / numbers.len() as f64).ln()
}

/// Pearson's correlation; 0 if either variable is constant.
pub fn correlation(x: &[f64], y: &[f64]) -> f64 {
    let n = x.len() as f64;
    let mean = |values: &[f64]| values.iter().sum::<f64>() / n;
    let (mean_x, mean_y) = (mean(x), mean(y));
    let sum = |f: &dyn Fn(f64, f64) -> f64| -> f64 { x.iter().zip(y).map(|(x, y)| f(x - mean_x, y - mean_y)).sum() };
    let (xx, yy, xy) = (sum(&|x, _| x * x), sum(&|_, y| y * y), sum(&|x, y| x * y));
    if xx * yy > 0.0 { xy / (xx * yy).sqrt() } else { 0.0 }
}

/// Spearman's rank correlation.
pub fn rank_correlation(x: &[f64], y: &[f64]) -> f64 {
    correlation(&ranks(x), &ranks(y))
}

/// Ranks from 0; ties share their mean rank.
fn ranks(values: &[f64]) -> Vec<f64> {
    let mut order: Vec<usize> = (0..values.len()).collect();
    order.sort_by(|&a, &b| values[a].total_cmp(&values[b]));
    let mut ranks = vec![0.0; values.len()];
    let mut first = 0;
    while first < order.len() {
        let same = order[first..]
            .iter()
            .take_while(|&&k| values[k] == values[order[first]])
            .count();
        for &k in &order[first..first + same] {
            ranks[k] = first as f64 + 0.5 * (same - 1) as f64;
        }
        first += same;
    }
    ranks
}

/// Mean and standard deviation; the variance is divided by the number of values.
pub fn moments(numbers: &[f64]) -> [f64; 2] {
    let n = numbers.len() as f64;
    let mean = numbers.iter().sum::<f64>() / n;
    let variance = numbers.iter().map(|x| (x - mean).powi(2)).sum::<f64>() / n;
    [mean, variance.sqrt()]
}

/// Systematic resampling: draws `n` indices of weighted draws, from one number of the uniform distribution over 0..1.
pub fn resampled(weights: &[f64], n: usize, uniform: f64) -> Vec<usize> {
    let total: f64 = weights.iter().sum();
    let (mut place, mut below) = (0, weights.first().copied().unwrap_or_default());
    let mut chosen = Vec::with_capacity(n);
    for k in 0..n {
        let at = (k as f64 + uniform) / n as f64 * total;
        while below < at && place + 1 < weights.len() {
            place += 1;
            below += weights[place];
        }
        chosen.push(place);
    }
    chosen
}

/// Mean of numbers; 0 for an empty list.
pub(crate) fn mean(numbers: impl Iterator<Item = f64>) -> f64 {
    let (mut sum, mut count) = (0.0, 0.0);
    for number in numbers {
        sum += number;
        count += 1.0;
    }
    if count > 0.0 { sum / count } else { 0.0 }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_quantile_of_equal_weights_is_that_of_the_values() {
        let values = [3.0, 1.0, 2.0, 4.0];
        for p in [0.05, 0.3, 0.5, 0.9] {
            let weighted = weighted_quantile(&values, &[2.0; 4], p);
            assert!((weighted - quantile_of(&mut values.clone(), p)).abs() < 1e-12);
        }
        assert!((quantile_of(&mut values.clone(), 0.5) - 2.5).abs() < 1e-12);
    }

    #[test]
    fn a_value_without_weight_does_not_count() {
        let with = weighted_quantile(&[1.0, 9.0, 2.0, 3.0], &[1.0, 0.0, 1.0, 1.0], 0.5);
        assert!((with - 2.0).abs() < 1e-12);
    }

    #[test]
    fn the_effective_size_of_equal_weights_is_their_count() {
        assert!((effective_size(&[0.2; 7]) - 7.0).abs() < 1e-12);
        assert!((effective_size(&[1.0, 0.0]) - 1.0).abs() < 1e-12);
    }

    #[test]
    fn large_exponents_do_not_overflow() {
        assert!((log_mean_exp(&[1000.0, 1000.0]) - 1000.0).abs() < 1e-12);
        assert_eq!(log_mean_exp(&[f64::NEG_INFINITY; 2]), f64::NEG_INFINITY);
    }

    #[test]
    fn ranks_see_any_increasing_relation() {
        let x: Vec<f64> = (0..20).map(f64::from).collect();
        let y: Vec<f64> = x.iter().map(|x| (0.5 * x).exp()).collect();
        assert!((rank_correlation(&x, &y) - 1.0).abs() < 1e-12 && correlation(&x, &y) < 0.9);
        assert!((rank_correlation(&[1.0, 1.0, 2.0], &[1.0, 1.0, 5.0]) - 1.0).abs() < 1e-12);
    }

    #[test]
    fn resampling_gives_each_weight_its_share_within_one() {
        let weights = [0.1, 3.0, 0.0, 1.9];
        for uniform in [0.01, 0.5, 0.99] {
            let chosen = resampled(&weights, 4, uniform);
            for (place, weight) in weights.iter().enumerate() {
                let count = chosen.iter().filter(|own| **own == place).count() as f64;
                assert!((count - weight / 5.0 * 4.0).abs() < 1.0, "{chosen:?}");
            }
        }
        assert_eq!(resampled(&[1.0; 5], 5, 0.3), [0, 1, 2, 3, 4]);
    }

    #[test]
    fn resampling_draws_more_indices_than_there_are_weights() {
        assert_eq!(resampled(&[1.0, 3.0], 8, 0.5), [0, 0, 1, 1, 1, 1, 1, 1]);
    }
}
