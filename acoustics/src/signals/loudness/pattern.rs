//! The pattern of specific loudness over critical-band rate, with the slopes of masking towards higher bands.

use super::core::CRITICAL_BANDS;

/// Upper ends of the critical bands \[Bark\] (table A.8).
const UPPER_END: [f64; CRITICAL_BANDS] = [
    0.9, 1.8, 2.8, 3.5, 4.4, 5.4, 6.6, 7.9, 9.2, 10.6, 12.3, 13.8, 15.2, 16.7, 18.1, 19.3, 20.6, 21.8, 22.7, 23.6, 24.0,
];

/// Lower ends of the ranges of specific loudness of [`STEEPNESS`] \[sone/Bark\] (table A.9).
const RANGE_END: [f64; 18] = [
    21.5, 18.0, 15.1, 11.5, 9.0, 6.1, 4.4, 3.1, 2.13, 1.36, 0.82, 0.42, 0.30, 0.22, 0.15, 0.10, 0.035, 0.0,
];

/// Steepness of the upper slopes \[sone/Bark²\] by range of specific loudness and by critical band, starting with the
/// second band; the last column applies to all higher bands (table A.9).
const STEEPNESS: [[f64; 8]; 18] = [
    [13.0, 8.2, 6.3, 5.5, 5.5, 5.5, 5.5, 5.5],
    [9.0, 7.5, 6.0, 5.1, 4.5, 4.5, 4.5, 4.5],
    [7.8, 6.7, 5.6, 4.9, 4.4, 3.9, 3.9, 3.9],
    [6.2, 5.4, 4.6, 4.0, 3.5, 3.2, 3.2, 3.2],
    [4.5, 3.8, 3.6, 3.2, 2.9, 2.7, 2.7, 2.7],
    [3.7, 3.0, 2.8, 2.35, 2.2, 2.2, 2.2, 2.2],
    [2.9, 2.3, 2.1, 1.9, 1.8, 1.7, 1.7, 1.7],
    [2.4, 1.7, 1.5, 1.35, 1.3, 1.3, 1.3, 1.3],
    [1.95, 1.45, 1.3, 1.15, 1.1, 1.1, 1.1, 1.1],
    [1.5, 1.2, 0.94, 0.86, 0.82, 0.82, 0.82, 0.82],
    [0.72, 0.67, 0.64, 0.63, 0.62, 0.62, 0.62, 0.62],
    [0.59, 0.53, 0.51, 0.50, 0.42, 0.42, 0.42, 0.42],
    [0.40, 0.33, 0.26, 0.24, 0.24, 0.22, 0.22, 0.22],
    [0.27, 0.21, 0.20, 0.18, 0.17, 0.17, 0.17, 0.17],
    [0.16, 0.15, 0.14, 0.12, 0.11, 0.11, 0.11, 0.11],
    [0.12, 0.11, 0.10, 0.08, 0.08, 0.08, 0.08, 0.08],
    [0.09, 0.08, 0.07, 0.06, 0.06, 0.06, 0.06, 0.05],
    [0.06, 0.05, 0.03, 0.02, 0.02, 0.02, 0.02, 0.02],
];

/// The first range, starting with `from`, whose lower end does not exceed this specific loudness.
fn range_at(specific: f64, from: usize) -> usize {
    (from..RANGE_END.len() - 1)
        .find(|&range| RANGE_END[range] <= specific)
        .unwrap_or(RANGE_END.len() - 1)
}

/// Total loudness: the area below the pattern of specific loudness \[sone\], given the core loudness \[sone/Bark\].
///
/// A band whose core loudness exceeds the slope of the bands below replaces it. Otherwise the slope continues; its
/// steepness depends on its specific loudness. ISO 532-1:2017, 5.7.
pub(super) fn total_loudness(core: &[f64; CRITICAL_BANDS]) -> f64 {
    let (mut total, mut rate, mut specific, mut range) = (0.0, 0.0, 0.0, 0);
    for (band, (&core, end)) in core.iter().zip(UPPER_END).enumerate() {
        let column = band.saturating_sub(1).min(STEEPNESS[0].len() - 1);
        while rate < end {
            if specific <= core {
                if specific < core {
                    range = range_at(core, 0);
                }
                total += core * (end - rate);
                (rate, specific) = (end, core);
            } else {
                let steepness = STEEPNESS[range][column];
                let foot = RANGE_END[range].max(core);
                let reached = rate + (specific - foot) / steepness;
                let (next, lower) = if reached > end {
                    (end, specific - (end - rate) * steepness)
                } else {
                    (reached, foot)
                };
                total += 0.5 * (next - rate) * (specific + lower);
                (rate, specific) = (next, lower);
            }
            if range + 1 < RANGE_END.len() && specific <= RANGE_END[range] {
                range += 1;
            }
        }
    }
    total
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn equal_core_loudness_fills_the_whole_scale() {
        let mut core = [2.0; CRITICAL_BANDS];
        core[20] = 2.0;
        assert!((total_loudness(&core) - 48.0).abs() < 1e-12);
    }

    #[test]
    fn masking_spreads_to_higher_bands_only() {
        let single = |band: usize| {
            let mut core = [0.0; CRITICAL_BANDS];
            core[band] = 1.0;
            total_loudness(&core)
        };
        // The area of the band itself, 1.3 Bark wide, plus a slope above it.
        assert!(single(8) > 1.3 + 0.5 && single(8) < 1.3 + 1.5, "{}", single(8));
        // There is nothing above the last band, which is 0.4 Bark wide.
        assert!((single(20) - 0.4).abs() < 1e-12);
    }
}
