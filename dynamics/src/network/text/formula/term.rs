//! Syntax tree of a formula.

use nailnoise_documents::nearest;
use nailnoise_quantities::Dimension;

use crate::network::assembly::{Binary, Function};

/// Syntax tree of a formula.
#[derive(Debug, Clone, PartialEq)]
pub(in crate::network::text) enum Term {
    /// A number; with its unit converted to SI. A zero without a unit fits every dimension.
    Number {
        si: f64,
        dimension: Dimension,
        bare: bool,
    },
    /// A name, with dots.
    Name(String),
    /// A word in quotes.
    Word(String),
    Negative(Box<Self>),
    Binary(Binary, Box<Self>, Box<Self>),
    /// pi d^2/4.
    Disc(Box<Self>),
    Function(Function, Vec<Self>),
    /// The second if the first, a condition over keys, is satisfied; else the third.
    Either(Box<[Self; 3]>),
    Compare(Relation, Box<Self>, Box<Self>),
    And(Box<Self>, Box<Self>),
    Or(Box<Self>, Box<Self>),
    Not(Box<Self>),
}

/// Relation of two terms.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(in crate::network::text) enum Relation {
    Less,
    LessOrEqual,
    Greater,
    GreaterOrEqual,
    Equal,
    NotEqual,
}

/// Names of the functions.
pub(in crate::network::text) const FUNCTIONS: [&str; 10] =
    ["disc", "sqrt", "exp", "sin", "cos", "tan", "min", "max", "abs", "if"];

/// Why a text is not a formula.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub(in crate::network::text) enum SyntaxError {
    #[error("`{0}` is not expected here")]
    Unexpected(String),
    #[error("it ends where {0} is expected")]
    End(&'static str),
    #[error("`{0}` is not a unit")]
    Unit(String),
    #[error("`{0}` is relative to the atmosphere; write the sum, as ambient.pressure + 6 bar")]
    Gauge(String),
    #[error("`{0}` is not a finite number")]
    Number(String),
    #[error("`{0}` is not a function; there are {functions}", functions = FUNCTIONS.join(", "))]
    Function(String),
    #[error("{name} takes {expected}, not {found}")]
    Arguments {
        name: String,
        expected: &'static str,
        found: usize,
    },
    #[error("it is nested too deeply")]
    Depth,
    #[error("it has more than {0} numbers, names and signs")]
    Long(usize),
}

impl SyntaxError {
    /// The remedy.
    pub(in crate::network::text) fn help(&self) -> String {
        let near = match self {
            Self::Function(name) => nearest(FUNCTIONS.into_iter(), name),
            _ => None,
        };
        near.map_or_else(
            || "the page \"Describe another tool\" has the grammar of formulas".to_owned(),
            |near| format!("did you mean `{near}`?"),
        )
    }
}
