//! Proposes the next points to try.

use crate::acquisition::{log_expected_improvement, log_feasibility};
use crate::kriging::Kriging;
use crate::space::{Point, Space};

/// Number of points of the space that are rated before the local search.
const GLOBAL: u32 = 512;

/// Number of points rated around each of the best observations.
const LOCAL: u32 = 64;

/// Number of best observations and best rated points from which local searches start.
const STARTS: usize = 4;

/// First and last step of the local search, relative to the range \[-\].
const STEPS: [f64; 2] = [0.1, 1e-3];

/// Maximum number of observations to which a model is fitted: those nearest to the best.
const MAX_OBSERVATIONS: usize = 200;

/// Maximum number of points of the sequence that are examined to find a new one.
const MAX_EXAMINED: u32 = 4096;

/// Weight of the sum of the objectives relative to the largest one (Knowles, "ParEGO", IEEE Transactions on
/// Evolutionary Computation 10, 50 (2006)).
const SUM: f64 = 0.05;

/// Number of dimensions of the sequence: shares and their perturbations.
const SEQUENCE: u32 = 256;

/// A point that was tried.
#[derive(Debug, Clone, PartialEq)]
pub struct Observation {
    /// The point.
    pub point: Point,
    /// Excess beyond each constraint, which is met if the excess is at most 0; `None` if unknown. The number of
    /// constraints is the same in all observations.
    pub excesses: Vec<Option<f64>>,
    /// The objectives, which are minimised; `None` if they were not computed. Their number is the same in all
    /// observations.
    pub objectives: Option<Vec<f64>>,
}

impl Observation {
    /// Whether the objectives are known and all constraints are met.
    pub fn feasible(&self) -> bool {
        let met = |excess: &Option<f64>| excess.is_some_and(|excess| excess <= 0.0);
        self.objectives.is_some() && self.excesses.iter().all(met)
    }

    /// Sum of the excesses beyond the limits.
    fn violation(&self) -> f64 {
        self.excesses.iter().flatten().map(|excess| excess.max(0.0)).sum()
    }
}

/// A search for the points with the lowest objectives.
#[derive(Debug, Clone, PartialEq)]
pub struct Optimiser {
    /// The points that may be tried.
    pub space: Space,
    /// Seed; other seeds try other points.
    pub seed: u64,
}

/// Models that predict other points from the observations.
struct Models<'a> {
    space: &'a Space,
    objective: Option<(Kriging, f64)>,
    constraints: Vec<Kriging>,
    /// Indices of the observations, best first.
    ranked: Vec<usize>,
}

impl Models<'_> {
    /// Logarithm of the expected improvement that meets the constraints; if no observation meets them, of the
    /// probability of meeting them.
    fn acquisition(&self, point: &[f64]) -> f64 {
        let own = self.space.coordinates(point);
        let met: f64 = self
            .constraints
            .iter()
            .map(|model| log_feasibility(model.predict(&own)))
            .sum();
        let objective = self.objective.as_ref();
        met + objective.map_or(0.0, |(model, best)| {
            log_expected_improvement(model.predict(&own), *best)
        })
    }

    /// Adds a point with its predicted values as if it had been observed (Ginsbourger, Le Riche and Carraro, "Kriging
    /// is well-suited to parallelize optimization", 2010: the believer).
    fn believe(&mut self, point: &[f64]) {
        let own = self.space.coordinates(point);
        let further = |model: &Kriging| model.with(&own, model.predict(&own).mean);
        for model in self
            .constraints
            .iter_mut()
            .chain(self.objective.as_mut().map(|(model, _)| model))
        {
            if let Some(believed) = further(model) {
                *model = believed;
            }
        }
    }
}

impl Optimiser {
    /// Number of points that are tried before a model is used.
    fn initial(&self) -> usize {
        2 * self.space.len() + 4
    }

    /// The next `count` points to try, none of them observed; fewer if the space does not have that many.
    pub fn propose(&self, observed: &[Observation], count: usize) -> Vec<Point> {
        let mut seen: Vec<Point> = observed.iter().map(|own| own.point.clone()).collect();
        let mut proposed = Vec::new();
        let mut models = None;
        while proposed.len() < count {
            let next = if seen.len() < self.initial() {
                self.untried(&seen)
            } else {
                let models = models.get_or_insert_with(|| self.models(observed));
                let next = self.search(models, observed, &seen).or_else(|| self.untried(&seen));
                if let Some(point) = &next {
                    models.believe(point);
                }
                next
            };
            let Some(next) = next else { break };
            seen.push(next.clone());
            proposed.push(next);
        }
        proposed
    }

    /// The first point of the sequence that has not been tried.
    fn untried(&self, seen: &[Point]) -> Option<Point> {
        let points = (0..MAX_EXAMINED).map(|index| self.space.at(&self.shares(index, 0)));
        points.into_iter().find(|point| !seen.contains(point))
    }

    /// Shares of all dimensions at an index of a scrambled Sobol' sequence.
    fn shares(&self, index: u32, sequence: u64) -> Vec<f64> {
        let share = |dimension: usize| number(index, dimension, self.seed, sequence);
        (0..self.space.len()).map(share).collect()
    }

    fn models(&self, observed: &[Observation]) -> Models<'_> {
        let space = &self.space;
        let owners = space.owners();
        let scores = self.scores(observed);
        let best = observed.iter().zip(&scores).filter(|(own, _)| own.feasible());
        let best = best.filter_map(|(_, score)| *score).reduce(f64::min);
        let ranked = Self::ranked(observed, &scores);
        let near = self.nearest(observed, ranked.first().copied());
        let of = |value: &dyn Fn(usize) -> Option<f64>| -> (Vec<Vec<f64>>, Vec<f64>) {
            let known = near.iter().filter_map(|&place| Some((place, value(place)?)));
            known
                .map(|(place, value)| (space.coordinates(&observed[place].point), value))
                .unzip()
        };
        let objective = best.and_then(|best| {
            let (points, mut values) = of(&|place| scores[place]);
            // Far above the best, only the rank matters.
            let mut sorted = values.clone();
            sorted.sort_by(f64::total_cmp);
            let most = best + 3.0 * (sorted[sorted.len() / 2] - best).max(1e-9);
            values.iter_mut().for_each(|value| *value = compressed(*value, most));
            Some((Kriging::fit(&points, &owners, &values)?, best))
        });
        let constraints = (0..observed.first().map_or(0, |own| own.excesses.len())).filter_map(|constraint| {
            let (points, mut values) = of(&|place| observed[place].excesses[constraint]);
            // Excesses span decades; those near the limit matter.
            let mut sizes: Vec<f64> = values.iter().map(|own| own.abs()).collect();
            sizes.sort_by(f64::total_cmp);
            let scale = sizes.get(sizes.len() / 2)?.max(1e-9);
            values
                .iter_mut()
                .for_each(|own| *own = (own.abs() / scale).ln_1p().copysign(*own));
            let varies = values.iter().any(|own| *own != values[0]);
            varies.then(|| Kriging::fit(&points, &owners, &values)).flatten()
        });
        Models {
            space,
            constraints: constraints.collect(),
            objective,
            ranked,
        }
    }

    /// The objectives of each observation as one number; for several objectives, the augmented Tchebycheff norm with
    /// weights that change from proposal to proposal.
    fn scores(&self, observed: &[Observation]) -> Vec<Option<f64>> {
        let known = || observed.iter().filter_map(|own| own.objectives.as_ref());
        let count = known().next().map_or(0, Vec::len);
        if count < 2 {
            return observed
                .iter()
                .map(|own| own.objectives.as_ref().map(|own| own[0]))
                .collect();
        }
        let feasible = observed.iter().any(Observation::feasible);
        let own = || {
            observed
                .iter()
                .filter(|own| own.feasible() || !feasible)
                .filter_map(|own| own.objectives.as_ref())
        };
        let ends: Vec<[f64; 2]> = (0..count)
            .map(|place| {
                let all = own().map(|own| own[place]);
                all.fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], x| {
                    [low.min(x), high.max(x)]
                })
            })
            .collect();
        // Uniform over all weights with a sum of 1.
        let index = known().count() as u32;
        let weights: Vec<f64> = (0..count)
            .map(|place| -number(index, place, self.seed, 1).max(1e-9).ln())
            .collect();
        let sum: f64 = weights.iter().sum();
        let score = |own: &Vec<f64>| {
            let parts: Vec<f64> = (0..count)
                .map(|place| {
                    let [low, high] = ends[place];
                    weights[place] / sum * (own[place] - low) / (high - low).max(1e-12)
                })
                .collect();
            parts.iter().copied().fold(f64::NEG_INFINITY, f64::max) + SUM * parts.iter().sum::<f64>()
        };
        observed.iter().map(|own| own.objectives.as_ref().map(score)).collect()
    }

    /// Indices of the observations, best first: feasible ones by score, then the others by their violation.
    fn ranked(observed: &[Observation], scores: &[Option<f64>]) -> Vec<usize> {
        let mut places: Vec<usize> = (0..observed.len()).collect();
        let rating = |place: usize| match scores[place].filter(|_| observed[place].feasible()) {
            Some(score) => (0.0, score),
            None => (1.0, observed[place].violation()),
        };
        places.sort_by(|&a, &b| {
            let [(a, by), (b, other)]: [(f64, f64); 2] = [a, b].map(rating);
            a.total_cmp(&b).then(by.total_cmp(&other))
        });
        places
    }

    /// Indices of the observations nearest to the best. Models are fitted to these.
    fn nearest(&self, observed: &[Observation], best: Option<usize>) -> Vec<usize> {
        let mut places: Vec<usize> = (0..observed.len()).collect();
        if let Some(best) = best.filter(|_| observed.len() > MAX_OBSERVATIONS) {
            let of = |place: usize| self.space.coordinates(&observed[place].point);
            let center = of(best);
            let distance = |place: usize| of(place).iter().zip(&center).map(|(a, b)| (a - b).powi(2)).sum::<f64>();
            places.sort_by(|&a, &b| distance(a).total_cmp(&distance(b)));
            places.truncate(MAX_OBSERVATIONS);
        }
        places
    }

    /// The most promising point that has not been tried.
    fn search(&self, models: &Models<'_>, observed: &[Observation], seen: &[Point]) -> Option<Point> {
        let sequence = 2 + seen.len() as u64;
        let spread = (0..GLOBAL).map(|index| self.space.at(&self.shares(index, sequence)));
        let around = models
            .ranked
            .iter()
            .take(STARTS)
            .enumerate()
            .flat_map(|(rank, &place)| {
                let indices = (0..LOCAL).map(move |index| GLOBAL + rank as u32 * LOCAL + index);
                indices.map(move |index| self.perturbed(&observed[place].point, index, sequence))
            });
        let rate = |point: Point| (models.acquisition(&point), point);
        let untried = |point: &Point| !seen.contains(point);
        let mut rated: Vec<(f64, Point)> = spread.chain(around).filter(untried).map(rate).collect();
        rated.sort_by(|a, b| b.0.total_cmp(&a.0));
        rated.truncate(STARTS);
        for (acquisition, point) in &mut rated {
            let mut step = STEPS[0];
            while step > STEPS[1] {
                let next = self.space.neighbours(point, step).into_iter().filter(untried).map(rate);
                match next.max_by(|a, b| a.0.total_cmp(&b.0)) {
                    Some((better, moved)) if better > *acquisition + 1e-9 => (*acquisition, *point) = (better, moved),
                    _ => step *= 0.5,
                }
            }
        }
        rated
            .into_iter()
            .max_by(|a, b| a.0.total_cmp(&b.0))
            .map(|(_, point)| point)
    }

    /// A point near another, at a distance of any magnitude; about half of its dimensions differ.
    fn perturbed(&self, point: &[f64], index: u32, sequence: u64) -> Point {
        let dimensions = self.space.len();
        let uniform = |place: usize| number(index, place, self.seed, sequence);
        // From 0.001 to 0.3 of the range.
        let size = 0.3 * 10.0_f64.powf(-2.5 * uniform(2 * dimensions));
        let moved = (0..dimensions).map(|place| {
            let kept = uniform(place) < 0.5;
            let by = 2.0 * uniform(dimensions + place) - 1.0;
            match self.space.has_choices(place) {
                _ if kept => point[place],
                true => self.space.at(&vec![uniform(dimensions + place); dimensions])[place],
                false => point[place] + 2.0 * size * by,
            }
        });
        self.space.nearest(&moved.collect::<Vec<f64>>())
    }
}

/// A number from 0 to 1 at an index of a scrambled Sobol' sequence (Burley, "Practical hash-based Owen scrambling",
/// 2020).
fn number(index: u32, dimension: usize, seed: u64, sequence: u64) -> f64 {
    let mixed = (seed ^ sequence.wrapping_mul(0x9E37_79B9_7F4A_7C15)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
    let folded = (mixed >> 32) as u32 ^ mixed as u32;
    f64::from(sobol_burley::sample(index, dimension as u32 % SEQUENCE, folded))
}

/// The value itself up to `most`, and its logarithm above.
fn compressed(value: f64, most: f64) -> f64 {
    if value <= most {
        value
    } else {
        most + (value - most).ln_1p()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::front;
    use crate::space::Dimension;

    /// Tries `count` points, given a function for excesses and objectives.
    fn tried(
        optimiser: &Optimiser,
        count: usize,
        batch: usize,
        function: impl Fn(&[f64]) -> (Vec<Option<f64>>, Option<Vec<f64>>),
    ) -> Vec<Observation> {
        let mut observed: Vec<Observation> = Vec::new();
        while observed.len() < count {
            let points = optimiser.propose(&observed, batch);
            if points.is_empty() {
                break;
            }
            observed.extend(points.into_iter().map(|point| {
                let (excesses, objectives) = function(&point);
                Observation {
                    point,
                    excesses,
                    objectives,
                }
            }));
        }
        observed
    }

    fn best(observed: &[Observation]) -> f64 {
        let feasible = observed.iter().filter(|own| own.feasible());
        feasible
            .filter_map(|own| Some(own.objectives.as_ref()?[0]))
            .fold(f64::INFINITY, f64::min)
    }

    fn real(dimensions: usize, seed: u64) -> Optimiser {
        Optimiser {
            space: Space::new(vec![Dimension::Real; dimensions]),
            seed,
        }
    }

    /// Branin's function over the unit square; its minimum is 0.397 887.
    fn branin(point: &[f64]) -> f64 {
        use std::f64::consts::PI;
        let (x, y) = (15.0 * point[0] - 5.0, 15.0 * point[1]);
        (y - 5.1 / (4.0 * PI * PI) * x * x + 5.0 / PI * x - 6.0).powi(2)
            + 10.0 * (1.0 - 1.0 / (8.0 * PI)) * x.cos()
            + 10.0
    }

    #[test]
    fn branins_minimum_is_found_in_30_points() {
        for seed in 1..=5 {
            let found = best(&tried(&real(2, seed), 30, 1, |point| {
                (Vec::new(), Some(vec![branin(point)]))
            }));
            assert!(found < 0.42, "seed {seed}: {found}");
        }
    }

    #[test]
    fn a_minimum_on_a_constraint_is_approached_from_its_feasible_side() {
        // The minimum of x + y with x y >= 0.16 is 0.8; the objective of an infeasible point is unknown.
        for seed in 1..=5 {
            let observed = tried(&real(2, seed), 40, 1, |point| {
                let excess = 0.16 - point[0] * point[1];
                (vec![Some(excess)], (excess <= 0.0).then(|| vec![point[0] + point[1]]))
            });
            let found = best(&observed);
            assert!((0.8..0.81).contains(&found), "seed {seed}: {found}");
        }
    }

    #[test]
    fn points_beyond_a_step_of_a_constraint_are_not_tried_again_and_again() {
        // The shot drives within a window of x; the minimum is at its lower end.
        for seed in 1..=3 {
            let optimiser = real(2, seed);
            let mut observed: Vec<Observation> = Vec::new();
            while observed.iter().filter(|own| own.feasible()).count() < 25 && observed.len() < 80 {
                let points = optimiser.propose(&observed, 1);
                observed.extend(points.into_iter().map(|point| {
                    let (x, y) = (point[0], point[1]);
                    let inside = (0.25..0.65).contains(&x);
                    let objective = 7.0 * (1.0 - ((0.25 - x) / 0.05).exp()) + (y - 0.5).powi(2);
                    Observation {
                        point,
                        excesses: vec![Some(if inside { -1.0 } else { 1.0 }), Some(0.1 * (0.25 - x))],
                        objectives: inside.then(|| vec![objective]),
                    }
                }));
            }
            assert!(
                observed.len() < 65,
                "seed {seed}: {} points for 25 trials",
                observed.len()
            );
            assert!(best(&observed) < 0.01, "seed {seed}: {}", best(&observed));
        }
    }

    #[test]
    fn whole_numbers_and_choices_are_found() {
        for seed in 1..=5 {
            let space = Space::new(vec![Dimension::Real, Dimension::steps(12), Dimension::Choices(4)]);
            let observed = tried(&Optimiser { space, seed }, 40, 1, |point| {
                let of_choice = [0.3, 0.0, 0.4, 0.2][point[2] as usize];
                let objective = (point[0] - 0.37).powi(2) + (point[1] - 7.0 / 11.0).powi(2) + of_choice;
                (Vec::new(), Some(vec![objective]))
            });
            let found = best(&observed);
            assert!(found < 1e-3, "seed {seed}: {found}");
        }
    }

    #[test]
    fn a_front_of_two_objectives_is_spread() {
        // The front of |x - (0.2, 0.2)|^2 and |x - (0.8, 0.8)|^2 is the line between the two points.
        let observed = tried(&real(2, 1), 50, 1, |point| {
            let distance = |center: f64| point.iter().map(|x| (x - center).powi(2)).sum::<f64>();
            (Vec::new(), Some(vec![distance(0.2), distance(0.8)]))
        });
        let objectives: Vec<Vec<f64>> = observed.iter().filter_map(|own| own.objectives.clone()).collect();
        let found = front(&objectives);
        let off = |place: &usize| (observed[*place].point[0] - observed[*place].point[1]).abs();
        assert!(found.len() > 12, "{} points", found.len());
        assert!(found.iter().map(off).fold(0.0, f64::max) < 0.2);
        let ends = [found[0], found[found.len() - 1]].map(|place| observed[place].point[0]);
        assert!(ends[0] < 0.27 && ends[1] > 0.73, "{ends:?}");
    }

    #[test]
    fn the_same_observations_yield_the_same_points_and_a_batch_has_different_ones() {
        let function = |point: &[f64]| (Vec::new(), Some(vec![branin(point)]));
        let observed = tried(&real(2, 1), 12, 4, function);
        let [one, other] = [real(2, 1), real(2, 1)].map(|own| own.propose(&observed, 4));
        assert_eq!(one, other);
        for (place, point) in one.iter().enumerate() {
            assert!(!one[..place].contains(point) && observed.iter().all(|own| own.point != *point));
        }
        assert_ne!(one, real(2, 2).propose(&observed, 4));
    }

    #[test]
    fn a_finite_space_is_tried_once() {
        let space = Space::new(vec![Dimension::steps(3), Dimension::Choices(4)]);
        let observed = tried(&Optimiser { space, seed: 1 }, 100, 5, |point| {
            (vec![Some(point[0] - 0.6)], Some(vec![point[1]]))
        });
        assert_eq!(observed.len(), 12);
    }
}
