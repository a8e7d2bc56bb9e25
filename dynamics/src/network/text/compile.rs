//! Converts the tree of a formula to an expression over the state; dimensions are checked and constants folded.

use std::f64::consts::PI;

use nailnoise_documents::nearest;
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
    /// Conditions on the state that must all be satisfied.
    Conditions(Vec<Comparison>),
    Word(Word),
}

/// A word.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Word {
    pub(super) text: String,
    /// Words of unselected branches.
    pub(super) unselected: Vec<String>,
    /// The choices of its key; empty for other words.
    pub(super) allowed: &'static [&'static str],
}

impl Word {
    pub(super) fn new(text: impl Into<String>) -> Self {
        Self {
            text: text.into(),
            unselected: Vec::new(),
            allowed: &[],
        }
    }
}

impl Compiled {
    /// Its kind in words.
    pub(super) fn kind(&self) -> String {
        match self {
            Self::Scalar(_) => "a number".to_owned(),
            Self::Truth(_) | Self::Conditions(_) => "a condition".to_owned(),
            Self::Word(word) => format!("the word '{}'", word.text),
        }
    }
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

    /// Whether the computed values have an effect. Those of an unselected branch do not, and need not be finite.
    fn is_selected(&self) -> bool;

    /// Compiles the unselected branch of an `if` to find its errors, without an effect of its keys. `None` if the
    /// branch refers to the value of the `if`.
    fn compile_unselected(&self, branch: &mut Branch<'_>) -> Result<Option<Compiled>, Trouble>;
}

/// Compiles a branch of an `if`.
pub(super) type Branch<'t> = dyn FnMut() -> Result<Compiled, Trouble> + 't;

/// Compiles a term.
pub(super) fn compile(term: &Term, scope: &dyn Scope) -> Result<Compiled, Trouble> {
    let scalar = |term: &Term| scalar(term, scope);
    let finite = |scalar: Scalar| match scalar.number() {
        Some(number) if !number.is_finite() && scope.is_selected() => Err(Trouble::here(
            "its value is not finite",
            "check divisions, roots and powers",
        )),
        _ => Ok(Compiled::Scalar(scalar)),
    };
    Ok(match term {
        Term::Number { si, dimension, bare } => Compiled::Scalar(Scalar {
            value: Expression::Constant(*si),
            dimension: (!(*bare && *si == 0.0)).then_some(*dimension),
        }),
        Term::Name(name) if name == "pi" => Compiled::Scalar(Scalar::constant(PI, NUMBER)),
        Term::Name(name) => scope.value(name)?,
        Term::Word(word) => Compiled::Word(Word::new(word)),
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
        Term::Binary(operation, left, right) => finite(binary(*operation, scalar(left)?, scalar(right)?)?)?,
        Term::Disc(diameter) => {
            let diameter = scalar(diameter)?;
            let quarter = Scalar::constant(0.25 * PI, NUMBER);
            let area = binary(Binary::Multiply, quarter, diameter.clone())?;
            finite(binary(Binary::Multiply, area, diameter)?)?
        }
        Term::Function(function, arguments) => {
            let arguments = arguments.iter().map(scalar).collect::<Result<Vec<_>, _>>()?;
            finite(call(*function, arguments)?)?
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

/// The value that a condition over keys selects. The keys of the other one have no effect, but its errors are found.
fn choose(terms: &[Term; 3], scope: &dyn Scope) -> Result<Compiled, Trouble> {
    let [condition, yes, no] = terms;
    let Compiled::Truth(satisfied) = compile(condition, scope)? else {
        return Err(Trouble::here(
            "`if` takes a condition over keys first",
            "write if(hand.mass > 0, a, b)",
        ));
    };
    let (selected, other) = if satisfied { (yes, no) } else { (no, yes) };
    let mut value = compile(selected, scope)?;
    match (&mut value, scope.compile_unselected(&mut || compile(other, scope))?) {
        (_, None) => {}
        (Compiled::Scalar(own), Some(Compiled::Scalar(other))) => {
            common("its branches are", own, &other)?;
        }
        (Compiled::Word(own), Some(Compiled::Word(other))) => {
            own.unselected.push(other.text);
            own.unselected.extend(other.unselected);
        }
        (Compiled::Truth(_) | Compiled::Conditions(_), Some(Compiled::Truth(_) | Compiled::Conditions(_))) => {}
        (own, Some(other)) => {
            return Err(Trouble::here(
                format!("its branches are {} and {}", own.kind(), other.kind()),
                "both must be of the same kind",
            ));
        }
    }
    Ok(value)
}

fn scalar(term: &Term, scope: &dyn Scope) -> Result<Scalar, Trouble> {
    match compile(term, scope)? {
        Compiled::Scalar(scalar) => Ok(scalar),
        Compiled::Word(word) => Err(Trouble::here(
            format!("'{}' is a word, not a number", word.text),
            "compare words with == or !=",
        )),
        Compiled::Truth(_) | Compiled::Conditions(_) => Err(Trouble::here(
            "a condition was found where a number is expected",
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
        (Some(a), Some(b)) => Expression::Constant(match operation {
            Binary::Add => a + b,
            Binary::Subtract => a - b,
            Binary::Multiply => a * b,
            Binary::Divide => a / b,
            Binary::Power => raise(a, b),
        }),
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
            Expression::Constant(match function {
                Function::Sqrt => a.sqrt(),
                Function::Exp => a.exp(),
                Function::Sin => a.sin(),
                Function::Cos => a.cos(),
                Function::Tan => a.tan(),
                Function::Abs => a.abs(),
                Function::Min => a.min(b),
                Function::Max => a.max(b),
            })
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

fn compare(relation: Relation, left: Compiled, right: Compiled) -> Result<Compiled, Trouble> {
    let equality = match relation {
        Relation::Equal => Some(true),
        Relation::NotEqual => Some(false),
        _ => None,
    };
    match (left, right, equality) {
        (Compiled::Scalar(left), Compiled::Scalar(right), _) => compare_numbers(relation, left, right),
        (Compiled::Word(left), Compiled::Word(right), Some(equal)) => {
            check_choice(&left, &right)?;
            check_choice(&right, &left)?;
            Ok(Compiled::Truth((left.text == right.text) == equal))
        }
        (Compiled::Truth(left), Compiled::Truth(right), Some(equal)) => Ok(Compiled::Truth((left == right) == equal)),
        _ => Err(Trouble::here(
            "it compares values of different kinds",
            "compare numbers with numbers, and words with == or != to a word in single quotes",
        )),
    }
}

/// Checks that the key behind the first word may have the second.
fn check_choice(key: &Word, word: &Word) -> Result<(), Trouble> {
    let allowed = key.allowed;
    if allowed.is_empty() || allowed.contains(&word.text.as_str()) {
        return Ok(());
    }
    let near = nearest(allowed.iter().copied(), &word.text);
    let near = near.map_or_else(String::new, |near| format!("did you mean '{near}'? "));
    Err(Trouble::here(
        format!("it compares a key with '{}', which it cannot be", word.text),
        format!("{near}its words are {}", allowed.join(", ")),
    ))
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
