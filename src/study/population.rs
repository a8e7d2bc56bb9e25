//! The population of a study's draws, and its comparison with that of another design.
//!
//! A study may be used for a design if the distributions of its drawn quantities are the same and everything else
//! agrees. If some distributions differ, its draws may be weighted by the ratio of the densities (importance sampling),
//!
//! ```text
//! w_i = prod_j q_j(x_ij)/p_j(x_ij)        n_eff = (sum w_i)^2 / sum w_i^2        (Kish 1965)
//! ```
//!
//! with the densities p_j of the study and q_j of the design for the quantities j that differ. p_j must be positive
//! wherever q_j is. Conditions such as "drives" and the rejection of conflicting values are the same in both and
//! cancel.

use serde::{Deserialize, Serialize};

use super::parameters::{CUT, Parameter};
use super::result::StudyResult;
use crate::design::{Design, Distribution, Provenance, Value};
use crate::error::Error;
use crate::store::Key;
use crate::wording::hexadecimal;

/// Relative tolerance for equal ends of ranges; provided studies have five digits.
const SAME: f64 = 1e-4;

/// The distribution of a drawn quantity.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub(super) struct Marginal {
    pub(super) key: String,
    range: [f64; 2],
    distribution: Distribution,
    /// The value of the design, if the distribution depends on it.
    mode: Option<f64>,
    is_count: bool,
}

impl Marginal {
    fn of(parameter: &Parameter) -> Self {
        let depends = parameter.distribution == Distribution::Triangular;
        Self {
            key: parameter.key.clone(),
            range: parameter.range,
            distribution: parameter.distribution,
            mode: depends.then(|| parameter.number()),
            is_count: matches!(parameter.value, Value::Count(_)),
        }
    }

    /// The quantity with this distribution.
    fn parameter(&self) -> Parameter {
        let number = self.mode.unwrap_or(self.range[0]);
        Parameter {
            key: self.key.clone(),
            symbol: "",
            unit: String::new(),
            value: match self.is_count {
                true => Value::Count(number.round().max(1.0) as u32),
                false => Value::Number(number),
            },
            range: self.range,
            distribution: self.distribution,
            cut: [-CUT, CUT],
            change: None,
        }
    }

    fn is_same(&self, other: &Self) -> bool {
        let same = |a: f64, b: f64| (a - b).abs() <= SAME * a.abs().max(b.abs());
        let modes = match (self.mode, other.mode) {
            (Some(own), Some(other)) => same(own, other),
            (own, other) => own.is_none() && other.is_none(),
        };
        self.distribution == other.distribution
            && self.is_count == other.is_count
            && modes
            && self.range.iter().zip(other.range).all(|(own, other)| same(*own, other))
    }

    /// The quantile of the distribution.
    pub(super) fn at(&self, share: f64) -> f64 {
        match self.parameter().at(share) {
            Value::Number(value) => value,
            Value::Count(count) => f64::from(count),
            Value::Switch(_) | Value::Choice(_) | Value::File(_) | Value::Name(_) => f64::NAN,
        }
    }

    /// Whether every value of `other` is possible here.
    fn includes(&self, other: &Self) -> bool {
        let [low, high] = self.support();
        let [other_low, other_high] = other.support();
        let slack = SAME * (high - low).max(low.abs().max(high.abs()));
        low - slack <= other_low && other_high <= high + slack
    }

    fn support(&self) -> [f64; 2] {
        self.parameter().support()
    }
}

/// Variables of a study, and a digest of everything else.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub(super) struct Population {
    drawn: Vec<Marginal>,
    /// Keys with a range that the study does not draw, because they change no level or belong to fixed structures.
    not_drawn: Vec<String>,
    /// Digest of all values that are not drawn, and of the settings in `[study]`.
    rest: String,
}

/// The difference between the populations of a study and of a design.
#[derive(Debug, Clone, PartialEq)]
pub(super) enum Difference {
    /// They are the same.
    None,
    /// The distributions of these quantities differ: that of the study, and that of the design.
    Distributions(Vec<(Marginal, Marginal)>),
    /// Another difference, so that the draws cannot be used for the design.
    Other,
}

/// All quantities of a design whose range is more than a point, except properties of the numerical method, with the key
/// that their draw sets.
fn ranged(design: &Design) -> Vec<(Parameter, String)> {
    let entries = design.entries().into_iter();
    let entries = entries.filter(|entry| entry.provenance != Provenance::Numerical);
    let own = entries.filter_map(Parameter::of).map(|own| (own.clone(), own.key));
    let derived = design
        .drawn_derived()
        .filter_map(|(entry, solution)| Parameter::of(entry).map(|own| (own, solution.follower.to_owned())));
    own.chain(derived).collect()
}

impl Population {
    /// The population of a study of a design.
    ///
    /// # Errors
    /// If a design cannot be digested.
    pub(super) fn of(design: &Design, result: &StudyResult) -> Result<Self, Error> {
        let is_drawn = |key: &str| result.variables.iter().any(|own| own.drawn && own.name == key);
        let (drawn, others): (Vec<_>, Vec<_>) = ranged(design).into_iter().partition(|(own, _)| is_drawn(&own.key));
        let keys: Vec<&str> = drawn.iter().map(|(_, set)| set.as_str()).collect();
        Ok(Self {
            rest: rest(design, &keys)?,
            drawn: drawn.iter().map(|(own, _)| Marginal::of(own)).collect(),
            not_drawn: others.into_iter().map(|(own, _)| own.key).collect(),
        })
    }

    /// Whether the same quantities have the same distributions in both, in the same order. Values that are not drawn
    /// may differ.
    pub(super) fn has_distributions_of(&self, other: &Self) -> bool {
        let pairs = self.drawn.iter().zip(&other.drawn);
        self.drawn.len() == other.drawn.len()
            && pairs
                .into_iter()
                .all(|(own, other)| own.key == other.key && own.is_same(other))
    }

    /// The difference between this population and that of a design.
    ///
    /// # Errors
    /// If a design cannot be digested.
    pub(super) fn difference(&self, design: &Design) -> Result<Difference, Error> {
        let own = ranged(design);
        let of_study = |key: &str| self.drawn.iter().find(|marginal| marginal.key == key);
        let (drawn, others): (Vec<_>, Vec<_>) = own.into_iter().partition(|(own, _)| of_study(&own.key).is_some());
        let is_known = |(own, _): &(Parameter, String)| self.not_drawn.contains(&own.key);
        if drawn.len() != self.drawn.len() || !others.iter().all(is_known) {
            return Ok(Difference::Other);
        }
        let keys: Vec<&str> = drawn.iter().map(|(_, set)| set.as_str()).collect();
        if rest(design, &keys)? != self.rest {
            return Ok(Difference::Other);
        }
        let pairs = drawn.iter().filter_map(|(own, _)| {
            let (study, own) = (of_study(&own.key)?.clone(), Marginal::of(own));
            (!study.is_same(&own)).then_some((study, own))
        });
        let pairs: Vec<_> = pairs.collect();
        let correlated = design.study().correlations.iter().flat_map(|own| &own.keys);
        let is_correlated = correlated
            .clone()
            .any(|key| pairs.iter().any(|(own, _)| own.key == *key));
        Ok(match pairs.as_slice() {
            [] => Difference::None,
            // The density of a copula does not factor into those of its quantities.
            pairs if is_correlated || pairs.iter().any(|(study, own)| !study.includes(own)) => Difference::Other,
            _ => Difference::Distributions(pairs),
        })
    }
}

fn rest(design: &Design, keys: &[&str]) -> Result<String, Error> {
    let own = design.study();
    let settings = (&own.require, &own.alternatives, &own.model, &own.correlations);
    let settings = serde_json::to_string(&settings).map_err(Error::Json)?;
    let key = Key::empty().with(&settings).with(&design.digest_without(keys));
    let key = match &own.draws {
        Some(joint) => key.with(&joint.digest),
        None => key,
    };
    Ok(hexadecimal(&key.digest()))
}

/// The weight of a draw, from the values of the quantities whose distributions differ.
pub(super) fn weight<'a>(values: impl Iterator<Item = (&'a (Marginal, Marginal), f64)>) -> f64 {
    let ratio = |((study, own), x): (&(Marginal, Marginal), f64)| {
        let [own, study] = [own, study].map(|marginal| marginal.parameter().density(x));
        if study > 0.0 { own / study } else { 0.0 }
    };
    values.map(ratio).product()
}

/// The equivalent number of unweighted draws (Kish 1965).
pub(super) fn effective(weights: &[f64]) -> f64 {
    let [sum, squares] = [1, 2].map(|power| weights.iter().map(|weight| weight.powi(power)).sum::<f64>());
    if squares > 0.0 { sum * sum / squares } else { 0.0 }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]

    use super::*;
    use nailnoise_acoustics::random::uniform;

    fn marginal(range: [f64; 2], distribution: Distribution) -> Marginal {
        Marginal {
            key: "key".to_owned(),
            range,
            distribution,
            mode: (distribution == Distribution::Triangular).then_some(0.5 * (range[0] + range[1])),
            is_count: false,
        }
    }

    /// The weighted mean of x is that of the other distribution, from the moments of each.
    #[test]
    fn weighted_draws_have_the_moments_of_the_other_distribution() {
        let study = marginal([1.0, 4.0], Distribution::Uniform);
        for (own, mean) in [
            (marginal([2.0, 3.0], Distribution::Uniform), 2.5),
            (marginal([1.0, 4.0], Distribution::Triangular), 2.5),
            (marginal([1.0, 4.0], Distribution::LogUniform), 3.0 / 4.0_f64.ln()),
            (marginal([1.5, 2.5], Distribution::Normal), 2.0),
        ] {
            let pair = (study.clone(), own);
            let draws: Vec<f64> = (0..80_000).map(|draw| study.at(uniform(1, 2, draw))).collect();
            let weights: Vec<f64> = draws.iter().map(|x| weight([(&pair, *x)].into_iter())).collect();
            let sum: f64 = weights.iter().sum();
            let found = draws.iter().zip(&weights).map(|(x, w)| x * w).sum::<f64>() / sum;
            assert!((found - mean).abs() < 0.02, "{found}, expected {mean}");
            // A density integrates to 1, so that the mean weight is 1.
            assert!((sum / 80_000.0 - 1.0).abs() < 0.02, "{sum}");
        }
    }

    #[test]
    fn equal_weights_are_worth_all_draws_and_one_weight_is_worth_one() {
        assert!((effective(&[2.0; 7]) - 7.0).abs() < 1e-12);
        assert!((effective(&[0.0, 3.0, 0.0]) - 1.0).abs() < 1e-12);
        assert_eq!(effective(&[0.0; 3]), 0.0);
    }

    fn drawn(text: &str) -> Design {
        let folder = concat!(env!("CARGO_MANIFEST_DIR"), "/designs/drawn.toml");
        Design::parse(&format!("base = \"n80cb.toml\"\n{text}"), folder).unwrap()
    }

    /// The population of a study that draws these keys of the base.
    fn population(keys: &[&str]) -> Population {
        let base = drawn("");
        let (drawn, others): (Vec<_>, Vec<_>) = ranged(&base)
            .into_iter()
            .partition(|(own, _)| keys.contains(&own.key.as_str()));
        let set: Vec<&str> = drawn.iter().map(|(_, set)| set.as_str()).collect();
        Population {
            rest: rest(&base, &set).unwrap(),
            drawn: drawn.iter().map(|(own, _)| Marginal::of(own)).collect(),
            not_drawn: others.into_iter().map(|(own, _)| own.key).collect(),
        }
    }

    #[test]
    fn a_study_serves_designs_whose_distributions_it_includes() {
        let study = population(&["supply.pressure", "exhaust.area", "exhaust.holes"]);
        let of = |text: &str| study.difference(&drawn(text)).unwrap();
        assert_eq!(of(""), Difference::None);
        // Another value in the same range is drawn from the same distribution.
        assert_eq!(
            of("supply.pressure = { value = \"700 kPa\", range = \"583 .. 929 kPa\" }"),
            Difference::None
        );
        let narrower = of("supply.pressure = { value = \"700 kPa\", range = \"680 .. 720 kPa\" }");
        let Difference::Distributions(pairs) = narrower else {
            panic!("{narrower:?}");
        };
        assert_eq!(pairs.len(), 1);
        for other in [
            "supply.pressure = \"700 kPa\"", // its own range begins below that of the study
            "supply.pressure = { range = \"exact\" }",
            "piston.mass = \"140 g\"", // not drawn
            "study.require = \"overdriven\"",
            "ambient.temperature = { range = \"0 .. 40 degC\" }", // drawn here, not there
            "exhaust = { holes = 12, hole_diameter = \"3 mm\" }",
        ] {
            assert_eq!(of(other), Difference::Other, "{other}");
        }
    }
}
