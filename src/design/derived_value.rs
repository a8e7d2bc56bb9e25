//! Values of derived quantities from which a primary quantity follows.
//!
//! ```toml
//! exhaust.area = { value = "200 mm2", follows = "hole_diameter" }
//! ```
//!
//! On the command line, `--set exhaust.area=200mm2` suffices. The file closest to the design takes precedence: a value
//! of the follower in a closer file replaces that of the derived quantity, and vice versa.

use nailnoise_quantities::{Group, Measured, Value};

use super::derived::{Derived, Solution};
use super::error::{DesignError, Problem};
use super::groups::Values;
use super::set::SetError;
use super::settings::GivenDerived;
use super::show::show;
use nailnoise_documents::Place;

/// A value from which a primary quantity follows.
#[derive(Debug)]
struct DerivedValue {
    derived: &'static Derived,
    solution: &'static Solution,
    value: Measured,
    at: Box<Place>,
    depth: usize,
}

/// A primary quantity that follows from the value of a derived one.
pub(super) struct Dependent {
    /// Its full name.
    pub(super) follower: &'static str,
    pub(super) value: Value,
    /// Full name of the derived quantity.
    pub(super) from: &'static str,
    /// Place of the derived quantity.
    pub(super) at: Box<Place>,
    pub(super) depth: usize,
}

/// Values of derived quantities given so far by the files.
#[derive(Debug, Default)]
pub(super) struct MergedDerivedValues {
    found: Vec<DerivedValue>,
}

impl MergedDerivedValues {
    /// Removes the values whose followers are among the keys to which a file gives values.
    pub(super) fn drop_of_followers(&mut self, keys: &[String]) {
        self.found
            .retain(|own| !keys.iter().any(|key| key == own.solution.follower));
    }

    /// Adds the value of a file that gives values to `keys`; returns whether a quantity follows from it. Otherwise it
    /// must agree with the primary quantities.
    ///
    /// # Errors
    /// If nothing can follow from it as the file states.
    pub(super) fn take(
        &mut self,
        given: &GivenDerived,
        (depth, is_command_line): (usize, bool),
        keys: &[String],
    ) -> Result<bool, DesignError> {
        let Some((value, at)) = &given.value else {
            return Ok(false);
        };
        if given.follows.is_none() && (!is_command_line || Solution::default_for(given.derived.key).is_none()) {
            return Ok(false);
        }
        let solution = given.solution("a value that another quantity follows", at)?;
        if keys.iter().any(|key| key == solution.follower) {
            return Ok(false);
        }
        self.found.retain(|own| own.derived.key != given.derived.key);
        self.found.push(DerivedValue {
            derived: given.derived,
            solution,
            value: *value,
            at: at.clone(),
            depth,
        });
        Ok(true)
    }

    /// Sets the primary quantities that follow, and passes each to `record`.
    ///
    /// # Errors
    /// If one of them would be outside its limits.
    pub(super) fn apply(self, values: &mut Values, mut record: impl FnMut(Dependent)) -> Result<(), DesignError> {
        for own in self.found {
            let (key, follower) = (own.derived.key, own.solution.follower);
            let change = (own.solution.change, Value::Number(own.value.si));
            values.set(&[change]).map_err(|error| {
                let allowed = match error {
                    SetError::OutsideLimits { allowed, .. } => allowed,
                    other => other.to_string(),
                };
                let (key, found) = (key.to_owned(), show(own.value.si, own.derived.dimension));
                Problem::OutsideLimits { key, found, allowed }.at(own.at.clone())
            })?;
            values.visit("", &mut |path, _, value| {
                if path == follower {
                    let (at, depth) = (own.at.clone(), own.depth);
                    record(Dependent {
                        follower,
                        value,
                        from: key,
                        at,
                        depth,
                    });
                }
            });
        }
        Ok(())
    }
}
