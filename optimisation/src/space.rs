//! The space of the designs: ranges, ordered steps and choices.

use std::f64::consts::FRAC_1_SQRT_2;

/// A point: per dimension, a share of its range from 0 to 1, or the number of a choice from 0.
pub type Point = Vec<f64>;

/// One dimension of a space.
#[derive(Debug, Clone, PartialEq)]
pub enum Dimension {
    /// Every share of a range from 0 to 1.
    Real,
    /// These ascending shares of a range, from 0 to 1: a whole number on a linear or logarithmic scale.
    Ordered(Vec<f64>),
    /// So many choices without an order.
    Choices(usize),
}

impl Dimension {
    /// So many equal steps from 0 to 1.
    pub fn steps(count: usize) -> Self {
        let last = count.saturating_sub(1).max(1) as f64;
        Self::Ordered((0..count).map(|step| step as f64 / last).collect())
    }

    /// The value for a share from 0 to 1 of the dimension: all its values have equal parts.
    fn at(&self, share: f64) -> f64 {
        let part = |count: usize| ((share * count as f64) as usize).min(count.saturating_sub(1));
        match self {
            Self::Real => share.clamp(0.0, 1.0),
            Self::Ordered(shares) => shares.get(part(shares.len())).copied().unwrap_or_default(),
            Self::Choices(count) => part(*count) as f64,
        }
    }

    /// The nearest value of the dimension.
    fn nearest(&self, value: f64) -> f64 {
        match self {
            Self::Real => value.clamp(0.0, 1.0),
            Self::Ordered(shares) => {
                let near = |a: &&f64, b: &&f64| (*a - value).abs().total_cmp(&(*b - value).abs());
                shares.iter().min_by(near).copied().unwrap_or_default()
            }
            Self::Choices(count) => value.round().clamp(0.0, count.saturating_sub(1) as f64),
        }
    }

    /// Values next to one, for a local search with a step: all others of a choice.
    fn neighbours(&self, value: f64, step: f64) -> Vec<f64> {
        match self {
            Self::Real => vec![(value - step).max(0.0), (value + step).min(1.0)],
            Self::Ordered(shares) => {
                let below = shares.iter().rev().find(|share| **share < value);
                let above = shares.iter().find(|share| **share > value);
                let far = [value - step, value + step].map(|far| self.nearest(far));
                below.into_iter().chain(above).copied().chain(far).collect()
            }
            Self::Choices(count) => (0..*count).map(|choice| choice as f64).collect(),
        }
    }
}

/// A space of designs.
#[derive(Debug, Clone, PartialEq)]
pub struct Space {
    dimensions: Vec<Dimension>,
}

impl Space {
    /// The space of these dimensions.
    pub fn new(dimensions: Vec<Dimension>) -> Self {
        Self { dimensions }
    }

    /// Number of dimensions.
    pub fn len(&self) -> usize {
        self.dimensions.len()
    }

    /// Whether the space has no dimension.
    pub fn is_empty(&self) -> bool {
        self.dimensions.is_empty()
    }

    /// The point at shares from 0 to 1 of all dimensions.
    pub(crate) fn at(&self, shares: &[f64]) -> Point {
        let both = self.dimensions.iter().zip(shares);
        both.map(|(dimension, share)| dimension.at(*share)).collect()
    }

    /// The point of the space next to these values.
    pub(crate) fn nearest(&self, values: &[f64]) -> Point {
        let both = self.dimensions.iter().zip(values);
        both.map(|(dimension, value)| dimension.nearest(*value)).collect()
    }

    /// Points that differ in one dimension, by a step where the dimension has steps.
    pub(crate) fn neighbours(&self, point: &[f64], step: f64) -> Vec<Point> {
        let along = |(place, dimension): (usize, &Dimension)| {
            let values = dimension.neighbours(point[place], step);
            let other = values.into_iter().filter(move |value| *value != point[place]);
            other.map(move |value| {
                let mut moved = point.to_vec();
                moved[place] = value;
                moved
            })
        };
        self.dimensions.iter().enumerate().flat_map(along).collect()
    }

    /// Whether a dimension has choices.
    pub(crate) fn has_choices(&self, place: usize) -> bool {
        matches!(self.dimensions[place], Dimension::Choices(_))
    }

    /// Coordinates in which points are compared, each with the number of its dimension. A choice is a corner of a
    /// simplex, so that all choices have the distance 1 of each other.
    pub(crate) fn coordinates(&self, point: &[f64]) -> Vec<f64> {
        let of = |(dimension, value): (&Dimension, &f64)| match dimension {
            Dimension::Real | Dimension::Ordered(_) => vec![*value],
            Dimension::Choices(count) => {
                let corner = |choice| if choice as f64 == *value { FRAC_1_SQRT_2 } else { 0.0 };
                (0..*count).map(corner).collect()
            }
        };
        self.dimensions.iter().zip(point).flat_map(of).collect()
    }

    /// The dimension of each coordinate.
    pub(crate) fn owners(&self) -> Vec<usize> {
        let count = |dimension: &Dimension| match dimension {
            Dimension::Real | Dimension::Ordered(_) => 1,
            Dimension::Choices(count) => *count,
        };
        let owners = self.dimensions.iter().enumerate();
        owners
            .flat_map(|(place, dimension)| std::iter::repeat_n(place, count(dimension)))
            .collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn all_values_of_a_dimension_have_equal_parts_of_the_shares() {
        for dimension in [Dimension::steps(4), Dimension::Choices(4)] {
            let mut counts = std::collections::BTreeMap::new();
            for share in (0..400).map(|place| (f64::from(place) + 0.5) / 400.0) {
                *counts.entry(dimension.at(share).to_bits()).or_insert(0) += 1;
            }
            assert_eq!(counts.into_values().collect::<Vec<_>>(), [100; 4]);
        }
    }

    #[test]
    fn choices_have_equal_distances() {
        let space = Space::new(vec![Dimension::Real, Dimension::Choices(3)]);
        let distance = |a: f64, b: f64| {
            let [a, b] = [a, b].map(|choice| space.coordinates(&[0.5, choice]));
            a.iter().zip(b).map(|(a, b)| (a - b).powi(2)).sum::<f64>().sqrt()
        };
        for (a, b) in [(0.0, 1.0), (0.0, 2.0), (1.0, 2.0)] {
            assert!((distance(a, b) - 1.0).abs() < 1e-12);
        }
        assert_eq!(space.owners(), [0, 1, 1, 1]);
    }

    #[test]
    fn neighbours_are_points_of_the_space_and_reach_every_choice() {
        let space = Space::new(vec![Dimension::steps(5), Dimension::Choices(3), Dimension::Real]);
        let found = space.neighbours(&[0.25, 1.0, 0.99], 0.1);
        assert!(found.iter().all(|point| space.nearest(point) == *point), "{found:?}");
        assert!(found.contains(&vec![0.5, 1.0, 0.99]) && found.contains(&vec![0.0, 1.0, 0.99]));
        assert!(found.contains(&vec![0.25, 0.0, 0.99]) && found.contains(&vec![0.25, 2.0, 0.99]));
        assert!(found.contains(&vec![0.25, 1.0, 1.0]));
    }
}
