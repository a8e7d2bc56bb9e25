//! Contributions of groups of inputs to the variance of a level, from pairs of draws that share a part of their inputs.
//!
//! Y and Y' have the same distribution. If they share only the inputs of a group and are independent otherwise, E (Y -
//! Y')^2/2 = E Var(Y|X_g). The index S_g = 1 - E (Y - Y')^2/(2 Var Y) is the reduction of the variance if the group is
//! known. If they share all but the group, E (Y - Y')^2/(2 Var Y) = E Var(Y|X_~g)/Var Y = T_g: the remaining variance
//! if all but the group is known (Jansen, "Analysis of variance designs for model output", Comput. Phys. Commun. 117,
//! 35 (1999)).
//!
//! Both are also valid under a condition, which makes inputs depend on each other, if the part that is not shared is
//! drawn again given the shared part and the condition (Kucherenko, Tarantola, Annoni, Comput. Phys. Commun. 183, 937
//! (2012)). S_g then includes the information of the group about the other inputs, and may be above T_g.

use super::statistics::{Bootstrap, Estimate};

/// Levels of a draw and of its partners.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Row {
    /// Level of the draw itself \[dB\].
    pub(super) base: f64,
    /// For each group \[dB\]: level of the partner that shares only the group, and of the one that shares all else.
    pub(super) partners: Vec<[f64; 2]>,
}

/// First-order and total contribution of each group, and the variance \[dB2\]; `None` if the level does not vary.
pub(super) fn indices(rows: &[Row]) -> Option<(Vec<[Estimate; 2]>, f64)> {
    let groups = rows.first()?.partners.len();
    let all = |row: &Row| -> Vec<f64> {
        let partners = row.partners.iter().flatten().copied();
        std::iter::once(row.base).chain(partners).collect()
    };
    let per_row = (1 + 2 * groups) as f64;
    let middle = rows.iter().flat_map(all).sum::<f64>() / (per_row * rows.len() as f64);
    // All draws have the same distribution, so the variance is that of all of them.
    let moments: Vec<[f64; 2]> = rows
        .iter()
        .map(|row| {
            let deviations = all(row).into_iter().map(|level| level - middle);
            deviations.fold([0.0; 2], |[sum, squares], d| {
                [sum + d / per_row, squares + d * d / per_row]
            })
        })
        .collect();
    let sums = |counts: &[u32], figure: &dyn Fn(usize) -> f64| -> f64 {
        let weighted = counts
            .iter()
            .enumerate()
            .map(|(row, count)| f64::from(*count) * figure(row));
        weighted.sum::<f64>() / f64::from(counts.iter().sum::<u32>())
    };
    let variance = |counts: &[u32]| sums(counts, &|row| moments[row][1]) - sums(counts, &|row| moments[row][0]).powi(2);
    let whole = variance(&vec![1; rows.len()]);
    if whole <= 0.0 {
        return None;
    }
    let bootstrap = Bootstrap::new(&vec![0; rows.len()]);
    let half_square = |group: usize, partner: usize| -> Vec<f64> {
        let apart = rows.iter().map(|row| row.base - row.partners[group][partner]);
        apart.map(|apart| 0.5 * apart * apart).collect()
    };
    let of_group = |group: usize| {
        let [alone, rest] = [half_square(group, 0), half_square(group, 1)];
        let part = |figures: &[f64], counts: &[u32]| sums(counts, &|row| figures[row]) / variance(counts);
        [
            bootstrap.estimate(|counts| 1.0 - part(&alone, counts)),
            bootstrap.estimate(|counts| part(&rest, counts)),
        ]
    };
    Some(((0..groups).map(of_group).collect(), whole))
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]

    use nailnoise_acoustics::random::uniform;

    use super::*;
    use crate::decibels::energy_sum;
    use crate::study::normal;

    /// Rows of a function of inputs that are uniform in 0 .. 1 under a condition, each input a group: the part that is
    /// not shared is drawn until it satisfies the condition.
    fn rows<const K: usize>(
        n: u64,
        seed: u64,
        level: impl Fn(&[f64; K]) -> f64,
        counts: impl Fn(&[f64; K]) -> bool,
    ) -> Vec<Row> {
        let point = |stream: u64, index: u64, attempt: u64| -> [f64; K] {
            let scramble = (uniform(seed, stream, attempt) * f64::from(u32::MAX)) as u32;
            let number = |k: usize| f64::from(sobol_burley::sample(index as u32, k as u32, scramble)) + 3e-8;
            std::array::from_fn(number)
        };
        let row = |index: u64| {
            let base = (0..)
                .map(|attempt| point(0, index, attempt))
                .find(|own| counts(own))
                .unwrap();
            let partner = |shared: &dyn Fn(usize) -> bool, stream: u64| {
                let joined = |attempt: u64| {
                    let other = point(stream, index, attempt);
                    std::array::from_fn(|k| if shared(k) { base[k] } else { other[k] })
                };
                (0..).map(joined).find(|own| counts(own)).unwrap()
            };
            let of = |group: usize| [level(&partner(&|k| k == group, 1)), level(&partner(&|k| k != group, 1))];
            Row {
                base: level(&base),
                partners: (0..K).map(of).collect(),
            }
        };
        (0..n).map(row).collect()
    }

    fn assert_indices(rows: &[Row], expected: &[[f64; 2]], tolerance: f64) {
        let (found, _) = indices(rows).unwrap();
        for (found, expected) in found.iter().zip(expected) {
            for (found, expected) in found.iter().zip(expected) {
                let value = found.value.unwrap();
                assert!((value - expected).abs() < tolerance, "{value}, expected {expected}");
            }
        }
    }

    /// Ishigami and Homma 1990, a = 7, b = 0.1.
    fn ishigami(u: &[f64; 3]) -> f64 {
        let [x, y, z] = u.map(|u| std::f64::consts::PI * (2.0 * u - 1.0));
        x.sin() + 7.0 * y.sin().powi(2) + 0.1 * z.powi(4) * x.sin()
    }

    const ISHIGAMI: [[f64; 2]; 3] = [[0.313_905, 0.557_589], [0.442_411, 0.442_411], [0.0, 0.243_684]];

    #[test]
    fn indices_of_the_ishigami_function_are_the_analytic_ones() {
        let rows = rows(1 << 14, 1, ishigami, |_| true);
        assert_indices(&rows, &ISHIGAMI, 0.01);
        let (_, variance) = indices(&rows).unwrap();
        assert!((variance - 13.844_588).abs() < 0.05, "{variance}");
    }

    /// Expected values by quadrature.
    #[test]
    fn indices_of_an_energy_sum_are_those_by_quadrature() {
        let level = |u: &[f64; 2]| {
            let z = u.map(|u| normal::quantile(u.min(1.0 - 3e-8)));
            energy_sum([100.0 + 3.0 * z[0], 97.0 + 4.0 * z[1]])
        };
        let expected = [[0.580_996, 0.623_793], [0.376_207, 0.419_004]];
        assert_indices(&rows(1 << 14, 2, level, |_| true), &expected, 0.01);
    }

    /// Inputs with a sum below 1, the level being the first of them: Var = 1/18, E Var(x|y) = E (1 - y)^2/12 = 1/24,
    /// and knowing y removes the rest.
    #[test]
    fn under_a_condition_an_input_tells_of_those_that_depend_on_it() {
        let below_one = |u: &[f64; 2]| u[0] + u[1] < 1.0;
        let rows = rows(1 << 14, 3, |u: &[f64; 2]| u[0], below_one);
        assert_indices(&rows, &[[1.0, 0.75], [0.25, 0.0]], 0.012);
    }

    /// Over 200 repetitions, 84 to 95 % of the intervals stated as 90 % contain the expected values.
    #[test]
    fn intervals_of_the_indices_cover_as_stated() {
        let level = |u: &[f64; 2]| u.iter().zip([2.0, 1.0]).map(|(u, a)| a * normal::quantile(*u)).sum();
        let mut covered = [0; 2];
        for seed in 0..200 {
            // Points that are random instead of evenly distributed: one of each scramble.
            let rows: Vec<Row> = (0..120)
                .flat_map(|k| rows(1, 1000 * seed + k, level, |_| true))
                .collect();
            let (found, _) = indices(&rows).unwrap();
            for (covered, estimate) in covered.iter_mut().zip(found[0]) {
                let [low, high] = estimate.interval.map(Option::unwrap);
                *covered += u32::from((low..=high).contains(&0.8));
            }
        }
        assert!(
            covered.iter().all(|covered| (168..=190).contains(covered)),
            "{covered:?} of 200"
        );
    }

    #[test]
    fn a_level_that_does_not_vary_has_no_indices() {
        let row = Row {
            base: 90.0,
            partners: vec![[90.0; 2]],
        };
        assert_eq!(indices(&[row.clone(), row]), None);
        assert_eq!(indices(&[]), None);
    }
}
