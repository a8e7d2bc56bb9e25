//! First-order contributions of inputs to the variance of a level, computed from the draws.
//!
//! S_i = Var E[Y|X_i]/Var Y. The draws are put into bins of equal counts along an input; the variance between the bins'
//! means estimates Var E[Y|X_i]. Means of finite bins scatter even if the input has no effect: on average by
//! (M - 1)/(n - 1) of the variance. This part is subtracted (Kelley, "An unbiased correlation ratio measure", PNAS 21,
//! 554 (1935)).
//!
//! Shots on one structure share the inputs of the structure. Such an input has only as many independent values as there
//! are structures: its bins contain structures, n is their number, and the variance that it can explain is that between
//! structures.
//!
//! A resample repeats draws, so that its bins scatter additionally around those of the sample: Kelley's correction is
//! applied twice.
//!
//! With many inputs, some seem to matter by chance. An estimate counts if it is above the *largest* value of all inputs
//! in 19 of 20 random pairings of levels with inputs. Inputs of structures and inputs of shots have separate limits,
//! each of 39 in 40 pairings, because the fewer structures scatter more.

use nailnoise_acoustics::random::uniform;
use rayon::prelude::*;

/// Number of random pairings.
const PERMUTATIONS: usize = 400;

/// Fraction of pairings that may reach the limit of either kind of input.
const CHANCE: f64 = 0.05;

/// Minimum number of structures for an estimate of the contributions of their inputs.
const FEWEST_STRUCTURES: usize = 10;

/// Maximum number of bins.
const MOST_BINS: usize = 32;

const SEED: u64 = 0xC047_121B;

/// The unit for which an input has its own value: a draw, or a structure with all its draws.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Unit {
    /// Each draw.
    Draw,
    /// Each structure.
    Structure,
}

impl Unit {
    pub(super) const ALL: [Self; 2] = [Self::Draw, Self::Structure];
}

/// Structures of draws, numbered from 0; empty if all draws use that of the design.
pub(super) struct Structures {
    of_draws: Vec<usize>,
    /// The first draw on each structure.
    first_draws: Vec<usize>,
}

impl Structures {
    /// From the number of each draw's structure; `drawn` is whether structures differ at all.
    pub(super) fn new(numbers: &[usize], drawn: bool) -> Self {
        let mut known = numbers.to_vec();
        known.sort_unstable();
        known.dedup();
        let place = |number: &usize| known.partition_point(|own| own < number);
        let of_draws: Vec<usize> = numbers.iter().filter(|_| drawn).map(place).collect();
        let mut first = vec![None; known.len()];
        for (draw, &structure) in of_draws.iter().enumerate() {
            first[structure].get_or_insert(draw);
        }
        Self {
            of_draws,
            first_draws: first.into_iter().flatten().collect(),
        }
    }

    fn count(&self) -> usize {
        self.first_draws.len()
    }
}

/// Fraction of a variance that an input explains, corrected this number of times for the fraction explained by chance;
/// each correction multiplies the unexplained fraction by the same factor.
pub(super) fn corrected(explained: f64, chance: f64, corrections: i32) -> f64 {
    1.0 - (1.0 - explained) / (1.0 - chance).powi(corrections)
}

/// Levels of draws that may count several times, as sums over units.
pub(super) struct Sums {
    /// Number of draws in each unit, and the sum of their levels above the mean \[dB\].
    units: Vec<(f64, f64)>,
    /// Number of units, including repetitions.
    count: f64,
    /// Sums of squares between units, and of all draws \[dB2\].
    between: f64,
    total: f64,
}

impl Sums {
    /// From levels \[dB\] and the number of times each draw counts.
    pub(super) fn new(levels: &[f64], counts: &[u32], structures: &Structures, unit: Unit) -> Self {
        let weighted = || {
            levels
                .iter()
                .zip(counts)
                .map(|(level, &count)| (*level, f64::from(count)))
        };
        let (sum, draws) = weighted().fold((0.0, 0.0), |(sum, n), (level, count)| (sum + count * level, n + count));
        let mean = sum / draws;
        let own = weighted().map(|(level, count)| (count, count * (level - mean)));
        let total = weighted().map(|(level, count)| count * (level - mean).powi(2)).sum();
        match unit {
            Unit::Draw => Self {
                units: own.collect(),
                count: draws,
                between: total,
                total,
            },
            Unit::Structure => {
                let mut units = vec![(0.0, 0.0); structures.count()];
                for ((count, sum), &structure) in own.zip(&structures.of_draws) {
                    units[structure].0 += count;
                    units[structure].1 += sum;
                }
                let occupied = units.iter().filter(|unit| unit.0 > 0.0);
                let between = occupied.map(|(count, sum)| sum * sum / count).sum();
                let first = structures.first_draws.iter();
                Self {
                    units,
                    count: first.map(|&draw| f64::from(counts[draw])).sum(),
                    between,
                    total,
                }
            }
        }
    }
}

/// An input, divided into bins along its values.
pub(super) struct Binned {
    /// Content of the bins.
    pub(super) unit: Unit,
    /// Bin of each unit, below [`MOST_BINS`].
    bins: Vec<u8>,
    count: usize,
}

impl Binned {
    /// Divides units into about sqrt(n) bins of equal counts; equal values share a bin. `None` for a constant input,
    /// and for an input of too few structures.
    pub(super) fn new(values: &[f64], structures: &Structures) -> Option<Self> {
        if structures.count() == 0 {
            return Self::along(values, Unit::Draw);
        }
        let first = &structures.first_draws;
        let same = |(draw, &structure): (usize, &usize)| values[draw].total_cmp(&values[first[structure]]).is_eq();
        if !structures.of_draws.iter().enumerate().all(same) {
            return Self::along(values, Unit::Draw);
        }
        let values: Vec<f64> = first.iter().map(|&draw| values[draw]).collect();
        (structures.count() >= FEWEST_STRUCTURES)
            .then(|| Self::along(&values, Unit::Structure))
            .flatten()
    }

    /// Bins along one value per unit.
    fn along(values: &[f64], unit: Unit) -> Option<Self> {
        let n = values.len();
        let wanted = (n as f64).sqrt().round().clamp(2.0, MOST_BINS as f64) as usize;
        let mut order: Vec<usize> = (0..n).collect();
        order.sort_by(|a, b| values[*a].total_cmp(&values[*b]));
        let mut bins = vec![0; n];
        let (mut bin, mut first) = (0, 0);
        for (place, pair) in order.windows(2).enumerate() {
            bins[pair[0]] = bin;
            let full = (place + 1) * wanted >= (usize::from(bin) + 1) * n;
            if full && place + 1 > first && values[pair[1]] > values[pair[0]] {
                (bin, first) = (bin + 1, place + 1);
            }
            bins[pair[1]] = bin;
        }
        (bin > 0).then_some(Self {
            unit,
            bins,
            count: usize::from(bin) + 1,
        })
    }

    /// S of levels, which may be negative for an input without effect.
    pub(super) fn first_order(&self, sums: &Sums) -> f64 {
        self.explained(sums, &sums.units, 1)
    }

    /// S of the levels of a resample.
    pub(super) fn resampled(&self, sums: &Sums) -> f64 {
        self.explained(sums, &sums.units, 2)
    }

    /// S of the levels of `units`, which may be those of `sums` in another order, corrected this number of times for
    /// chance.
    fn explained(&self, sums: &Sums, units: &[(f64, f64)], corrections: i32) -> f64 {
        let mut bins = [(0.0, 0.0); MOST_BINS];
        for (&bin, (count, sum)) in self.bins.iter().zip(units) {
            let own = &mut bins[usize::from(bin)];
            own.0 += count;
            own.1 += sum;
        }
        let occupied = bins[..self.count].iter().filter(|(count, _)| *count > 0.0);
        let chance = (occupied.clone().count() as f64 - 1.0) / (sums.count - 1.0);
        if sums.between <= 0.0 || chance >= 1.0 {
            return 0.0;
        }
        let explained = occupied.map(|(count, sum)| sum * sum / count).sum::<f64>() / sums.between;
        corrected(explained, chance, corrections) * sums.between / sums.total
    }
}

/// The estimate that the largest of all inputs of one kind exceeds by chance in one of forty random pairings; in one of
/// twenty if there is only one kind.
pub(super) fn by_chance(inputs: &[&Binned], sums: &Sums, alone: bool) -> f64 {
    let largest = |permutation: u64| {
        let mut shuffled = sums.units.clone();
        for last in (1..shuffled.len()).rev() {
            let other = (uniform(SEED, permutation, last as u64) * (last + 1) as f64) as usize;
            shuffled.swap(last, other);
        }
        inputs
            .iter()
            .map(|input| input.explained(sums, &shuffled, 1))
            .fold(0.0, f64::max)
    };
    let mut largest: Vec<f64> = (0..PERMUTATIONS as u64).into_par_iter().map(largest).collect();
    largest.sort_by(f64::total_cmp);
    super::statistics::quantile(&largest, 1.0 - if alone { CHANCE } else { 0.5 * CHANCE })
}

/// Thirds of the draws along an input.
pub(super) struct Thirds {
    lower: Vec<usize>,
    upper: Vec<usize>,
}

impl Thirds {
    /// From the input's values.
    pub(super) fn new(values: &[f64]) -> Self {
        let mut order: Vec<usize> = (0..values.len()).collect();
        order.sort_by(|a, b| values[*a].total_cmp(&values[*b]));
        let third = (values.len() / 3).max(1);
        Self {
            lower: order[..third].to_vec(),
            upper: order[order.len() - third..].to_vec(),
        }
    }

    /// Mean level in the upper third minus that in the lower third \[dB\], for draws that may count several times.
    pub(super) fn effect(&self, levels: &[f64], counts: &[u32]) -> f64 {
        let mean = |part: &[usize]| {
            let sums = part.iter().fold((0.0, 0.0), |(sum, n), &draw| {
                let count = f64::from(counts[draw]);
                (sum + count * levels[draw], n + count)
            });
            sums.0 / sums.1
        };
        mean(&self.upper) - mean(&self.lower)
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]

    use super::*;
    use crate::study::statistics::Bootstrap;

    fn inputs(n: u32, seed: u32) -> Vec<[f64; 3]> {
        let number = |index, dimension| f64::from(sobol_burley::sample(index, dimension, seed));
        (0..n)
            .map(|index| [0, 1, 2].map(|dimension| number(index, dimension)))
            .collect()
    }

    /// Ishigami and Homma 1990, a = 7, b = 0.1.
    fn ishigami(u: &[f64; 3]) -> f64 {
        let [x, y, z] = u.map(|u| std::f64::consts::PI * (2.0 * u - 1.0));
        x.sin() + 7.0 * y.sin().powi(2) + 0.1 * z.powi(4) * x.sin()
    }

    const EXPECTED: [f64; 3] = [0.313_905, 0.442_411, 0.0];

    /// Draws without common structures.
    fn alone(n: usize) -> Structures {
        Structures::new(&vec![0; n], false)
    }

    fn first_order(values: &[f64], levels: &[f64]) -> f64 {
        let structures = alone(values.len());
        let sums = Sums::new(levels, &vec![1; levels.len()], &structures, Unit::Draw);
        Binned::new(values, &structures).unwrap().first_order(&sums)
    }

    fn estimates(n: u32, seed: u32) -> [f64; 3] {
        let points = inputs(n, seed);
        let levels: Vec<f64> = points.iter().map(ishigami).collect();
        [0, 1, 2].map(|input| {
            let values: Vec<f64> = points.iter().map(|point| point[input]).collect();
            first_order(&values, &levels)
        })
    }

    #[test]
    fn first_order_indices_of_the_ishigami_function_are_the_analytic_ones() {
        let mut squares = [0.0; 3];
        for seed in 0..20 {
            let found = estimates(500, seed);
            for ((square, found), expected) in squares.iter_mut().zip(found).zip(EXPECTED) {
                *square += (found - expected).powi(2) / 20.0;
            }
        }
        assert!(squares.iter().all(|square| square.sqrt() < 0.045), "{squares:?}");
    }

    #[test]
    fn first_order_indices_of_an_energy_sum_are_those_by_quadrature() {
        let points = inputs(1 << 14, 3);
        let z = |u: f64| super::super::normal::quantile(u + 1e-9);
        let level = |u: &[f64; 3]| crate::decibels::energy_sum([100.0 + 3.0 * z(u[0]), 97.0 + 4.0 * z(u[1])]);
        let levels: Vec<f64> = points.iter().map(level).collect();
        for (input, expected) in [0.580_996, 0.376_207].into_iter().enumerate() {
            let values: Vec<f64> = points.iter().map(|point| point[input]).collect();
            let found = first_order(&values, &levels);
            assert!((found - expected).abs() < 0.01, "{input}: {found}");
        }
    }

    #[test]
    fn an_input_that_does_nothing_stays_below_what_chance_gives() {
        let mut above = 0;
        for seed in 0..40 {
            let points = inputs(200, seed);
            let levels: Vec<f64> = points.iter().map(ishigami).collect();
            let values: Vec<f64> = points.iter().map(|point| point[2]).collect();
            let structures = alone(200);
            let sums = Sums::new(&levels, &[1; 200], &structures, Unit::Draw);
            let input = Binned::new(&values, &structures).unwrap();
            above += usize::from(input.first_order(&sums) > by_chance(&[&input], &sums, true));
        }
        // One in twenty means two in forty; seven or more have a probability of 0.3 %.
        assert!(above < 7, "{above} of 40");
    }

    #[test]
    fn an_input_of_few_values_has_a_bin_for_each() {
        let values: Vec<f64> = (0..90).map(|draw| f64::from(draw % 3)).collect();
        let levels: Vec<f64> = values.iter().map(|value| 90.0 + value).collect();
        let found = first_order(&values, &levels);
        assert!((found - 1.0).abs() < 1e-9, "{found}");
        assert!(Binned::new(&[1.0; 50], &alone(50)).is_none());
    }

    /// Levels of four shots on each of 64 structures: `a` times an input of the structure, `b` times another one, and
    /// `c` times an input of the shot, all uniform with the variance 1.
    struct TwoStages {
        structure: [Vec<f64>; 2],
        shot: Vec<f64>,
        levels: Vec<f64>,
        structures: Structures,
        numbers: Vec<usize>,
    }

    fn two_stages(seed: u64, [a, b, c]: [f64; 3]) -> TwoStages {
        let standard = |stream: u64, place: usize| 12_f64.sqrt() * (uniform(seed, stream, place as u64) - 0.5);
        let numbers: Vec<usize> = (0..256).map(|draw| 3 * (draw / 4) + 1).collect();
        let structure = [1, 2].map(|stream| (0..256).map(|draw| standard(stream, draw / 4)).collect::<Vec<f64>>());
        let shot: Vec<f64> = (0..256).map(|draw| standard(3, draw)).collect();
        TwoStages {
            levels: (0..256)
                .map(|draw| 95.0 + a * structure[0][draw] + b * structure[1][draw] + c * shot[draw])
                .collect(),
            structures: Structures::new(&numbers, true),
            structure,
            shot,
            numbers,
        }
    }

    #[test]
    fn shots_on_one_structure_are_not_independent_evidence_for_its_inputs() {
        let (mut above, mut mean) = (0, 0.0);
        for seed in 0..40 {
            let own = two_stages(seed, [0.0, 2.0, 1.0]);
            let input = Binned::new(&own.structure[0], &own.structures).unwrap();
            assert_eq!(input.unit, Unit::Structure);
            let sums = Sums::new(&own.levels, &[1; 256], &own.structures, input.unit);
            let found = input.first_order(&sums);
            mean += found / 40.0;
            above += usize::from(found > by_chance(&[&input], &sums, true));
        }
        assert!(above < 7, "{above} of 40");
        assert!(mean.abs() < 0.05, "{mean}");
    }

    #[test]
    fn inputs_of_structures_and_shots_have_their_parts_of_the_variance() {
        let mut mean = [0.0; 3];
        for seed in 0..100 {
            let own = two_stages(seed, [2.0, 1.0, 1.5]);
            let inputs = [&own.structure[0], &own.structure[1], &own.shot];
            for (mean, values) in mean.iter_mut().zip(inputs) {
                let input = Binned::new(values, &own.structures).unwrap();
                let sums = Sums::new(&own.levels, &[1; 256], &own.structures, input.unit);
                *mean += input.first_order(&sums) / 100.0;
            }
        }
        let expected = [4.0, 1.0, 2.25].map(|part| part / 7.25);
        for (found, expected) in mean.iter().zip(expected) {
            assert!((found - expected).abs() < 0.025, "{mean:?}, expected {expected}");
        }
    }

    #[test]
    fn inputs_of_few_structures_are_left_out() {
        let numbers: Vec<usize> = (0..36).map(|draw| draw / 4).collect();
        let values: Vec<f64> = numbers.iter().map(|number| *number as f64).collect();
        assert!(Binned::new(&values, &Structures::new(&numbers, true)).is_none());
    }

    /// Intervals stated as 90 % contain the true value in 84 to 95 % of 200 repetitions, for draws and for structures.
    #[test]
    fn intervals_cover_as_stated() {
        let mut covered = [0; 3];
        for seed in 0..200 {
            let own = two_stages(1000 + seed, [2.0, 1.5, 1.5]);
            let bootstrap = Bootstrap::new(&own.numbers);
            let inputs = [&own.structure[0], &own.structure[1], &own.shot];
            let inputs = inputs.map(|values| Binned::new(values, &own.structures).unwrap());
            let intervals = bootstrap.intervals(|counts| {
                let of = |input: &Binned| input.resampled(&Sums::new(&own.levels, counts, &own.structures, input.unit));
                inputs.iter().map(of).collect()
            });
            let expected = [4.0, 2.25, 2.25].map(|part| part / 8.5);
            for ((covered, interval), expected) in covered.iter_mut().zip(intervals).zip(expected) {
                let [low, high] = interval.map(Option::unwrap);
                *covered += u32::from((low..=high).contains(&expected));
            }
        }
        assert!(
            covered.iter().all(|own| (168..=190).contains(own)),
            "{covered:?} of 200"
        );
    }

    #[test]
    fn the_effect_is_the_difference_of_the_outer_thirds() {
        let values: Vec<f64> = (0..9).map(f64::from).collect();
        let levels: Vec<f64> = values.iter().map(|value| 90.0 + 2.0 * value).collect();
        let thirds = Thirds::new(&values);
        assert_eq!(thirds.effect(&levels, &[1; 9]), 12.0);
        assert_eq!(thirds.effect(&levels, &[3, 0, 0, 1, 1, 1, 0, 0, 3]), 16.0);
    }
}
