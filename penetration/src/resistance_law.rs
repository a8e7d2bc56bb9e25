//! The penetration law chosen by a word in the design.

use nailnoise_quantities::{Held, Kind, Value};
use serde::{Deserialize, Serialize};

use super::PenetrationLaw;

/// A law of penetration resistance for the nailing cycle, chosen by a word in the design.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum ResistanceLaw {
    /// A published law, evaluated at [`REFERENCE_SPEED`](super::REFERENCE_SPEED).
    Published(PenetrationLaw),
    /// The same force at every depth, `wood.penetration_force`.
    Constant,
    /// A law fitted to the user's tests, a [`FittedLaw`](super::fit::FittedLaw).
    Fitted,
}

/// Words for the published laws, followed by those for the constant force and the fitted law.
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
    /// The kind of a key of this type.
    pub const KIND: Kind = Kind::Choice(Self::WORDS);
    /// The words of all laws.
    pub const WORDS: &'static [&'static str] = &WORDS;
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
