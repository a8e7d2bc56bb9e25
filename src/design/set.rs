//! Setting keys by their full names, for programs that change a design: studies, sensitivities, sweeps.

use nailnoise_quantities::{Group, Kind, Value};

use super::groups::Values;
use super::suggest;

/// Why a key cannot be set. The values are then as they were.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum SetError {
    /// There is no such key.
    #[error("there is no key `{key}`{}", nearest.as_ref().map_or_else(String::new, |near| format!("; is it `{near}`?")))]
    UnknownKey {
        /// The name given.
        key: String,
        /// The key most like it, if one is near.
        nearest: Option<String>,
    },
    /// The key holds another kind of value.
    #[error("`{key}` cannot be {value:?}: it holds {expected}")]
    WrongKind {
        /// Full name of the key.
        key: String,
        /// The value given.
        value: Value,
        /// What the key holds.
        expected: &'static str,
    },
    /// The value is outside what the physics allows in every design.
    #[error("`{key}` = {value} must be {allowed}")]
    OutsideLimits {
        /// Full name of the key.
        key: String,
        /// The value given, in SI units.
        value: f64,
        /// What is allowed.
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
    /// Sets keys by their full names (`piston.mass`), quantities in SI units. A key given twice takes its last value.
    ///
    /// `wood.species` and `nail.kind` change as words only: what a name sets is read with a design file or an assignment.
    /// Each value is held to the limits of its own key; whether the values go together is asked of
    /// [`conflict`](Self::conflict).
    ///
    /// # Errors
    /// [`SetError`] for the first key that cannot be set; nothing is changed then.
    pub fn set(&mut self, changes: &[(&str, Value)]) -> Result<(), SetError> {
        for (key, value) in changes {
            let Some((spec, _)) = self.key_mut(key) else {
                return Err(SetError::UnknownKey {
                    key: (*key).to_owned(),
                    nearest: suggest::key(&Self::SPEC, key),
                });
            };
            check(key, spec.kind, value)?;
        }
        // Every change is of its key's kind, so that nothing can fail any more.
        for (key, value) in changes {
            if let Some((_, place)) = self.key_mut(key) {
                place.assign(value);
            }
        }
        Ok(())
    }
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
        (Kind::Switch, Value::Switch(_)) | (Kind::File, Value::File(_)) => Ok(()),
        (Kind::Choice(words), Value::Choice(word)) if words.contains(word) => Ok(()),
        (Kind::Quantity { .. }, _) => wrong("a quantity"),
        (Kind::Count(_), _) => wrong("a whole number"),
        (Kind::Switch, _) => wrong("true or false"),
        (Kind::Choice(_), _) => wrong("one of its words"),
        (Kind::File, _) => wrong("the name of a file"),
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]

    use crate::design::{Design, another};

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
