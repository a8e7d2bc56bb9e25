//! The choice of a law, by its word in a design.

use nailnoise_quantities::{Held, Kind, Value};
use serde::{Deserialize, Serialize};

use super::PenetrationLaw;

/// A law of the penetration resistance force for the nailing cycle, by its word in a design.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum ResistanceLaw {
    /// A published law, evaluated at [`REFERENCE_SPEED`](super::REFERENCE_SPEED).
    Published(PenetrationLaw),
    /// The same force at every depth, `wood.penetration_force`.
    Constant,
    /// A law fitted to own tests, a [`FittedLaw`](super::fit::FittedLaw).
    Fitted,
}

/// Words of the published laws, then those of the constant force and of a fitted law.
const WORDS: [&str; PenetrationLaw::WORDS.len() + 2] = {
    let mut words = ["constant"; PenetrationLaw::WORDS.len() + 2];
    words[PenetrationLaw::WORDS.len() + 1] = "fitted";
    let mut i = 0;
    while i < PenetrationLaw::WORDS.len() {
        words[i] = PenetrationLaw::WORDS[i];
        i += 1;
    }
    words
};

impl ResistanceLaw {
    /// The value of a key of this type.
    pub const KIND: Kind = Kind::Choice(&WORDS);
}

impl Held for ResistanceLaw {
    fn from_value(value: &Value) -> Option<Self> {
        match value {
            Value::Choice("constant") => Some(Self::Constant),
            Value::Choice("fitted") => Some(Self::Fitted),
            _ => PenetrationLaw::from_value(value).map(Self::Published),
        }
    }

    fn to_value(&self) -> Value {
        match self {
            Self::Published(law) => law.to_value(),
            Self::Constant => Value::Choice("constant"),
            Self::Fitted => Value::Choice("fitted"),
        }
    }
}

impl From<PenetrationLaw> for ResistanceLaw {
    fn from(law: PenetrationLaw) -> Self {
        Self::Published(law)
    }
}
