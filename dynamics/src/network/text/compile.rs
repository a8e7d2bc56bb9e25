//! Converts the tree of a formula to an expression over the state; dimensions are checked and constants folded.

use std::f64::consts::PI;

use nailnoise_quantities::Dimension;
use nailnoise_quantities::dimension::{ANGLE, NUMBER};

use super::fault::{AssemblyError, Fault};
use super::formula::{Relation, Term};
use crate::network::assembly::{Binary, Comparison, Expression, Function};

/// Value of a formula.
#[derive(Debug, Clone, PartialEq)]
pub(super) enum Compiled {
    Scalar(Scalar),
    /// A condition whose truth value is known.
    Truth(bool),
    /// Conditions on the state, all of which must be satisfied.
    Conditions(Vec<Comparison>),
    Word(String),
}

/// A number, either known or a function of the state.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Scalar {
    pub(super) value: Expression,
    /// `None` for a zero without a unit, which is compatible with every dimension.
    pub(super) dimension: Option<Dimension>,
}

impl Scalar {
    pub(super) fn constant(si: f64, dimension: Dimension) -> Self {
        Self {
            value: Expression::Constant(si),
            dimension: Some(dimension),
        }
    }

    /// The number, if it is known.
    pub(super) fn number(&self) -> Option<f64> {
        match self.value {
            Expression::Constant(number) => Some(number),
            _ => None,
        }
    }
}

/// Why a formula cannot be compiled.
#[derive(Debug)]
pub(super) enum Trouble {
    /// The fault is in this formula.
    Here { problem: String, help: String },
    /// A separate fault.
    Fault(Fault),
    /// The fault is in another value that the formula needs.
    Elsewhere(Box<AssemblyError>),
}

impl Trouble {
    pub(super) fn here(problem: impl Into<String>, help: impl Into<String>) -> Self {
        Self::Here {
            problem: problem.into(),
            help: help.into(),
        }
    }
}

/// Meaning of names.
pub(super) trait Scope {
    /// The value of a name.
    fn value(&self, name: &str) -> Result<Compiled, Trouble>;
}

/// Compiles a term.
pub(super) fn compile(term: &Term, scope: &dyn Scope) -> Result<Compiled, Trouble> {
    let scalar = |term: &Term| scalar(term, scope);
    Ok(match term {
        Term::Number { si, dimension, bare } => Compiled::Scalar(Scalar {
            value: Expression::Constant(*si),
            dimension: (!(*bare && *si == 0.0)).then_some(*dimension),
        }),
        Term::Name(name) if name == "pi" => Compiled::Scalar(Scalar::constant(PI, NUMBER)),
        Term::Name(name) => scope.value(name)?,
        Term::Word(word) => Compiled::Word(word.clone()),
        Term::Negative(inner) => {
            let inner = scalar(inner)?;
            let value = inner.number().map_or_else(
                || Expression::Negative(Box::new(inner.value.clone())),
                |number| Expression::Constant(-number),
            );
            Compiled::Scalar(Scalar {
                value,
                dimension: inner.dimension,
            })
        }
        Term::Binary(operation, left, right) => Compiled::Scalar(binary(*operation, scalar(left)?, scalar(right)?)?),
        Term::Disc(diameter) => {
            let diameter = scalar(diameter)?;
            let quarter = Scalar::constant(0.25 * PI, NUMBER);
            let area = binary(Binary::Multiply, quarter, diameter.clone())?;
            Compiled::Scalar(binary(Binary::Multiply, area, diameter)?)
        }
        Term::Function(function, arguments) => {
            let arguments = arguments.iter().map(scalar).collect::<Result<Vec<_>, _>>()?;
            Compiled::Scalar(call(*function, arguments)?)
        }
        Term::Either(terms) => return choose(terms, scope),
        Term::Compare(relation, left, right) => {
            return compare(*relation, compile(left, scope)?, compile(right, scope)?);
        }
        Term::And(left, right) => and(compile(left, scope)?, compile(right, scope)?)?,
        Term::Or(left, right) => match (compile(left, scope)?, compile(right, scope)?) {
            (Compiled::Truth(left), Compiled::Truth(right)) => Compiled::Truth(left || right),
            _ => {
                return Err(Trouble::here(
                    "`or` combines conditions over keys only",
                    "use max(a, b) > 0",
                ));
            }
        },
        Term::Not(inner) => match compile(inner, scope)? {
            Compiled::Truth(truth) => Compiled::Truth(!truth),
            _ => {
                return Err(Trouble::here(
                    "`not` applies to conditions over keys only",
                    "reverse the comparison",
                ));
            }
        },
    })
}

/// The value that a condition over keys selects; the other one is not evaluated, so that its keys have no effect.
fn choose(terms: &[Term; 3], scope: &dyn Scope) -> Result<Compiled, Trouble> {
    let [condition, yes, no] = terms;
    match compile(condition, scope)? {
        Compiled::Truth(satisfied) => compile(if satisfied { yes } else { no }, scope),
        _ => Err(Trouble::here(
            "`if` takes a condition over keys first",
            "write if(hand.mass > 0, a, b)",
        )),
    }
}

fn scalar(term: &Term, scope: &dyn Scope) -> Result<Scalar, Trouble> {
    match compile(term, scope)? {
        Compiled::Scalar(scalar) => Ok(scalar),
        Compiled::Word(word) => Err(Trouble::here(
            format!("'{word}' is a word, not a number"),
            "compare words with == or !=",
        )),
        Compiled::Truth(_) | Compiled::Conditions(_) => Err(Trouble::here(
            "a condition stands where a number is expected",
            "take the condition out of the arithmetic",
        )),
    }
}

/// The common dimension of two terms; `None` if both are zeros without a unit.
fn common(what: &str, left: &Scalar, right: &Scalar) -> Result<Option<Dimension>, Trouble> {
    match (left.dimension, right.dimension) {
        (Some(left), Some(right)) if left != right => Err(Trouble::here(
            format!("{what} {left} and {right}"),
            "both must have the same dimension",
        )),
        (Some(dimension), _) | (None, Some(dimension)) => Ok(Some(dimension)),
        (None, None) => Ok(None),
    }
}

fn overflow() -> Trouble {
    Trouble::here("the exponents of its dimension are too large", "check the powers")
}

fn binary(operation: Binary, left: Scalar, right: Scalar) -> Result<Scalar, Trouble> {
    let plain = |scalar: &Scalar| scalar.dimension.unwrap_or(NUMBER);
    let dimension = match operation {
        Binary::Add => common("it adds", &left, &right)?,
        Binary::Subtract => common("it subtracts", &left, &right)?,
        Binary::Multiply => Some(plain(&left).times(plain(&right), 1).ok_or_else(overflow)?),
        Binary::Divide => Some(plain(&left).times(plain(&right), -1).ok_or_else(overflow)?),
        Binary::Power => Some(power(plain(&left), &right)?),
    };
    let value = match (left.number(), right.number()) {
        (Some(a), Some(b)) => Expression::Constant(finite(match operation {
            Binary::Add => a + b,
            Binary::Subtract => a - b,
            Binary::Multiply => a * b,
            Binary::Divide => a / b,
            Binary::Power => raise(a, b),
        })?),
        _ => Expression::Binary(operation, Box::new(left.value), Box::new(right.value)),
    };
    Ok(Scalar { value, dimension })
}

/// Largest exponent that is evaluated by multiplication.
const WHOLE: f64 = 64.0;

fn raise(base: f64, exponent: f64) -> f64 {
    if exponent.fract() == 0.0 && exponent.abs() <= WHOLE {
        base.powi(exponent as i32)
    } else {
        base.powf(exponent)
    }
}

fn power(base: Dimension, exponent: &Scalar) -> Result<Dimension, Trouble> {
    if exponent.dimension.is_some_and(|dimension| dimension != NUMBER) {
        return Err(Trouble::here("an exponent has a unit", "an exponent is a plain number"));
    }
    if base == NUMBER {
        return Ok(NUMBER);
    }
    let number = exponent.number().ok_or_else(|| {
        Trouble::here(
            "the exponent of a quantity changes with the state",
            "give the exponent as a number",
        )
    })?;
    if number == 0.5 {
        return root(base);
    }
    if number.fract() != 0.0 || number.abs() > WHOLE {
        let problem = format!("{base} cannot be raised to the power {number}");
        return Err(Trouble::here(problem, "raise a ratio, or use a whole exponent"));
    }
    NUMBER.times(base, number as i32).ok_or_else(overflow)
}

fn root(dimension: Dimension) -> Result<Dimension, Trouble> {
    dimension.square_root().ok_or_else(|| {
        Trouble::here(
            format!("{dimension} has no square root"),
            "check the dimensions under the root",
        )
    })
}

fn call(function: Function, mut arguments: Vec<Scalar>) -> Result<Scalar, Trouble> {
    let first = arguments.first().and_then(|argument| argument.dimension);
    let dimension = match function {
        Function::Sqrt => first.map(root).transpose()?,
        Function::Exp => {
            plain("exp", first, &[NUMBER])?;
            Some(NUMBER)
        }
        Function::Sin | Function::Cos | Function::Tan => {
            plain("an angle's function", first, &[ANGLE, NUMBER])?;
            Some(NUMBER)
        }
        Function::Abs => first,
        Function::Min | Function::Max => match &arguments[..] {
            [left, right] => common("it compares", left, right)?,
            _ => first,
        },
    };
    let numbers: Option<Vec<f64>> = arguments.iter().map(Scalar::number).collect();
    let value = match numbers.as_deref() {
        Some([a, rest @ ..]) => {
            let b = rest.first().copied().unwrap_or(*a);
            Expression::Constant(finite(match function {
                Function::Sqrt => a.sqrt(),
                Function::Exp => a.exp(),
                Function::Sin => a.sin(),
                Function::Cos => a.cos(),
                Function::Tan => a.tan(),
                Function::Abs => a.abs(),
                Function::Min => a.min(b),
                Function::Max => a.max(b),
            })?)
        }
        _ => Expression::Function(function, arguments.drain(..).map(|argument| argument.value).collect()),
    };
    Ok(Scalar { value, dimension })
}

fn plain(what: &str, found: Option<Dimension>, allowed: &[Dimension]) -> Result<(), Trouble> {
    match found {
        Some(dimension) if !allowed.contains(&dimension) => Err(Trouble::here(
            format!("{what} is taken of {dimension}"),
            "divide by a quantity of the same dimension",
        )),
        _ => Ok(()),
    }
}

fn finite(value: f64) -> Result<f64, Trouble> {
    if value.is_finite() {
        Ok(value)
    } else {
        Err(Trouble::here(
            "its value is not finite",
            "check divisions, roots and powers",
        ))
    }
}

fn compare(relation: Relation, left: Compiled, right: Compiled) -> Result<Compiled, Trouble> {
    let equality = match relation {
        Relation::Equal => Some(true),
        Relation::NotEqual => Some(false),
        _ => None,
    };
    match (left, right, equality) {
        (Compiled::Scalar(left), Compiled::Scalar(right), _) => compare_numbers(relation, left, right),
        (Compiled::Word(left), Compiled::Word(right), Some(equal)) => Ok(Compiled::Truth((left == right) == equal)),
        (Compiled::Truth(left), Compiled::Truth(right), Some(equal)) => Ok(Compiled::Truth((left == right) == equal)),
        _ => Err(Trouble::here(
            "it compares values of different kinds",
            "compare numbers with numbers, and words with == or != to a word in single quotes",
        )),
    }
}

fn compare_numbers(relation: Relation, left: Scalar, right: Scalar) -> Result<Compiled, Trouble> {
    common("it compares", &left, &right)?;
    if let (Some(a), Some(b)) = (left.number(), right.number()) {
        return Ok(Compiled::Truth(match relation {
            Relation::Less => a < b,
            Relation::LessOrEqual => a <= b,
            Relation::Greater => a > b,
            Relation::GreaterOrEqual => a >= b,
            Relation::Equal => a == b,
            Relation::NotEqual => a != b,
        }));
    }
    let (high, low, strict) = match relation {
        Relation::Less => (right, left, true),
        Relation::LessOrEqual => (right, left, false),
        Relation::Greater => (left, right, true),
        Relation::GreaterOrEqual => (left, right, false),
        Relation::Equal | Relation::NotEqual => {
            return Err(Trouble::here(
                "a quantity that changes is never exactly equal to another",
                "use <, <=, > or >=",
            ));
        }
    };
    let margin = if low.number() == Some(0.0) {
        high.value
    } else {
        Expression::Binary(Binary::Subtract, Box::new(high.value), Box::new(low.value))
    };
    Ok(Compiled::Conditions(vec![Comparison { margin, strict }]))
}

fn and(left: Compiled, right: Compiled) -> Result<Compiled, Trouble> {
    Ok(match (left, right) {
        (Compiled::Truth(left), Compiled::Truth(right)) => Compiled::Truth(left && right),
        (Compiled::Truth(truth), Compiled::Conditions(conditions))
        | (Compiled::Conditions(conditions), Compiled::Truth(truth)) => {
            if truth {
                Compiled::Conditions(conditions)
            } else {
                Compiled::Truth(false)
            }
        }
        (Compiled::Conditions(mut left), Compiled::Conditions(right)) => {
            left.extend(right);
            Compiled::Conditions(left)
        }
        _ => {
            return Err(Trouble::here(
                "`and` combines conditions",
                "write two comparisons, as a > b and c > d",
            ));
        }
    })
}
