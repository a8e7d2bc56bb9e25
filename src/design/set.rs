//! Sets keys by their full names, for programs that change a design: studies, sensitivities, sweeps.

use nailnoise_quantities::{Group, Kind, Value, positive};

use super::derived::{Derived, Solution};
use super::groups::Values;
use super::renamed::current;
use super::suggest;

/// Reason why a key cannot be set. The values are unchanged then.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum SetError {
    /// The key does not exist.
    #[error("there is no key `{key}`{}", nearest.as_ref().map_or_else(String::new, |near|
        format!("; is it `{near}`?")))]
    UnknownKey {
        /// The name given.
        key: String,
        /// The most similar key, if one is close.
        nearest: Option<String>,
    },
    /// The key expects another kind of value.
    #[error("`{key}` cannot be {value:?}: expected is {expected}")]
    WrongKind {
        /// Full name of the key.
        key: String,
        /// The value given.
        value: Value,
        /// The kind of value that the key expects.
        expected: &'static str,
    },
    /// The value is outside the physical limits that apply to every design.
    #[error("`{key}` = {value} must be {allowed}")]
    OutsideLimits {
        /// Full name of the key.
        key: String,
        /// The value given, in SI units.
        value: f64,
        /// The permitted values.
        allowed: String,
    },
}

impl SetError {
    /// The key that cannot be set.
    pub fn key(&self) -> &str {
        match self {
            Self::UnknownKey { key, .. } | Self::WrongKind { key, .. } | Self::OutsideLimits { key, .. } => key,
        }
    }
}

impl Values {
    /// Sets keys by their full names (`piston.mass`), quantities in SI units. If a key is given twice, its last value
    /// counts.
    ///
    /// For `wood.species` and `nail.kind`, only the name is set: its settings are read only from a design file or an
    /// assignment. Each value is checked against the limits of its key; [`conflict`](Self::conflict) checks whether the
    /// values are compatible.
    ///
    /// A key of an earlier version is replaced by its successor.
    ///
    /// A derived quantity with a [`Solution`] is set last, by solving for the primary quantity that follows from it.
    ///
    /// # Errors
    /// [`SetError`] for the first key that cannot be set; then nothing is changed.
    pub fn set(&mut self, changes: &[(&str, Value)]) -> Result<(), SetError> {
        let changes: Vec<(&str, &Value)> = changes.iter().map(|(key, value)| (current(key), value)).collect();
        let solved = |key: &str| Solution::find(key);
        for &(key, value) in &changes {
            if let Some(solution) = solved(key) {
                check_derived(solution, value)?;
                continue;
            }
            let Some((spec, _)) = self.key_mut(key) else {
                return Err(SetError::UnknownKey {
                    key: key.to_owned(),
                    nearest: suggest::key(&Self::SPEC, key),
                });
            };
            check(key, spec.kind, value)?;
        }
        let solutions = changes.iter().filter_map(|&(key, value)| Some((solved(key)?, value)));
        let before = solutions.clone().next().is_some().then(|| self.clone());
        // Every change has the kind of its key, so that only a derived quantity can still fail.
        for &(key, value) in &changes {
            if let Some((_, place)) = self.key_mut(key) {
                place.assign(value);
            }
        }
        for (solution, value) in solutions {
            if let Value::Number(number) = value
                && !(solution.solve)(self, *number)
            {
                if let Some(before) = before {
                    *self = before;
                }
                return Err(SetError::OutsideLimits {
                    key: solution.key.to_owned(),
                    value: *number,
                    allowed: format!("so that `{}`, which follows, is within its limits", solution.follower),
                });
            }
        }
        Ok(())
    }
}

fn check_derived(solution: &Solution, value: &Value) -> Result<(), SetError> {
    let kind = Derived::find(solution.key).map(|derived| positive(derived.dimension));
    kind.map_or(Ok(()), |kind| check(solution.key, kind, value))
}

fn check(key: &str, kind: Kind, value: &Value) -> Result<(), SetError> {
    let wrong = |expected| {
        Err(SetError::WrongKind {
            key: key.to_owned(),
            value: value.clone(),
            expected,
        })
    };
    let within = |value: f64| {
        let outside = || SetError::OutsideLimits {
            key: key.to_owned(),
            value,
            allowed: kind.allowed(),
        };
        kind.allows(value).then_some(()).ok_or_else(outside)
    };
    match (kind, value) {
        (Kind::Quantity { .. }, Value::Number(number)) => within(*number),
        (Kind::Count(_), Value::Count(count)) => within(f64::from(*count)),
        (Kind::Switch, Value::Switch(_)) | (Kind::File, Value::File(_)) | (Kind::Name, Value::Name(_)) => Ok(()),
        (Kind::Choice(words), Value::Choice(word)) if words.contains(word) => Ok(()),
        (Kind::Quantity { .. }, _) => wrong("a quantity"),
        (Kind::Count(_), _) => wrong("a whole number"),
        (Kind::Switch, _) => wrong("true or false"),
        (Kind::Choice(_), _) => wrong("one of its words"),
        (Kind::File, _) => wrong("the name of a file"),
        (Kind::Name, _) => wrong("a name"),
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]

    use nailnoise_quantities::Value;

    use crate::design::{Design, another};

    /// A = n pi d^2/4 uses the number of holes that is set with it, in either order.
    #[test]
    fn a_derived_quantity_that_is_set_is_the_one_that_follows() {
        let file = concat!(env!("CARGO_MANIFEST_DIR"), "/designs/n80cb.toml");
        let base = Design::load(file).unwrap();
        for changes in [
            [
                ("exhaust.area", Value::Number(3e-4)),
                ("exhaust.holes", Value::Count(12)),
            ],
            [
                ("exhaust.holes", Value::Count(12)),
                ("exhaust.area", Value::Number(3e-4)),
            ],
        ] {
            let mut design = base.clone();
            design.set(&changes).unwrap();
            assert_eq!(design.exhaust.holes, 12);
            assert!((design.exhaust.area() / 3e-4 - 1.0).abs() < 1e-12);
        }
        let mut by_holes = base.clone();
        by_holes
            .set(&[("exhaust.area by exhaust.holes", Value::Number(3e-4))])
            .unwrap();
        let one = base.exhaust.area() / f64::from(base.exhaust.holes);
        assert_eq!(by_holes.exhaust.hole_diameter, base.exhaust.hole_diameter);
        assert!((by_holes.exhaust.area() - 3e-4).abs() <= 0.5 * one);
        assert!(base.clone().set(&[("exhaust.area", Value::Number(-1.0))]).is_err());
    }

    #[test]
    fn a_change_moves_its_own_key_and_no_other() {
        // A design with members of a list.
        let file = concat!(env!("CARGO_MANIFEST_DIR"), "/designs/n80cb-as-tested.toml");
        let design = Design::load(file).unwrap();
        let before = design.keys();
        let mut moved = 0;
        for (place, (key, kind, value)) in before.iter().enumerate() {
            let Some(value) = another(value, *kind) else { continue };
            let mut changed = design.clone();
            changed.set(&[(key, value.clone())]).unwrap();
            for (other, (own, was)) in changed.keys().iter().zip(&before).enumerate() {
                let expected = if other == place { &value } else { &was.2 };
                assert_eq!(&own.2, expected, "{key} set, {}", own.0);
            }
            moved += 1;
        }
        assert!(moved > 200, "{moved} keys");
    }
}
