//! Setting keys by their full names, for programs that change a design: studies, sensitivities, sweeps.

use std::collections::HashMap;

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
        let mut values = HashMap::new();
        self.visit("", &mut |key, spec, value| {
            values.insert(key.to_owned(), (spec.kind, value));
        });
        for (key, value) in changes {
            let Some((kind, held)) = values.get_mut(*key) else {
                return Err(SetError::UnknownKey {
                    key: (*key).to_owned(),
                    nearest: suggest::key(&Self::SPEC, key),
                });
            };
            check(key, *kind, value)?;
            *held = value.clone();
        }
        // Every key has been visited and every change is of its key's kind, so that nothing can be missing.
        let found = values.into_iter().map(|(key, (_, value))| (key, value)).collect();
        if let Ok(changed) = Self::build("", &found) {
            *self = changed;
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
