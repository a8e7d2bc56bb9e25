//! Terms of a penetration law, identified by name.
//!
//! ```text
//! s = sqrt(F_r/(H_M NL)) = sum C_k m_k,   m_k a product of powers of
//!   x       = y/NL                       depth                          Pi2
//!   rate    = NL rho v^2/H_M             speed of penetration           Pi3 of Eq. 2.2
//!   slender = D/NL                       nail                           Pi4 of Eq. 2.2, Pi5 of Eq. 3.1
//!   inertia = NL rho v0^2/H_M            speed of impact                Pi3 of Eq. 3.1
//!   decay   = v/v0                       speed left                     Pi4 of Eq. 3.1
//!   energy  = M v0^2/(H_M NL^2)          energy of the projectile       Pi6 of Eq. 3.1
//! ```
//! Nili Ahmadabadi (2016), Eq. 2.2 and 3.1. Pi3 and Pi4 denote different groups in the two equations, so terms are
//! identified by name here.

use std::fmt;
use std::str::FromStr;

use thiserror::Error;

/// Number of variables.
pub const VARIABLES: usize = 6;

/// The highest degree of `poly(x,n)`; beyond it, the converted coefficients have no significant digits.
pub const HIGHEST_DEGREE: u32 = 15;

/// The largest power of a variable.
const HIGHEST_POWER: f64 = 20.0;

/// The most terms of a form.
const MOST_TERMS: usize = 60;

/// A dimensionless variable of the law.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
#[repr(usize)]
pub enum Variable {
    /// y/NL.
    X,
    /// NL rho v^2/H_M.
    Rate,
    /// D/NL.
    Slender,
    /// NL rho v0^2/H_M.
    Inertia,
    /// v/v0.
    Decay,
    /// M v0^2/(H_M NL^2).
    Energy,
}

impl Variable {
    /// All variables, in the order of [`Values`].
    pub const ALL: [Self; VARIABLES] = [
        Self::X,
        Self::Rate,
        Self::Slender,
        Self::Inertia,
        Self::Decay,
        Self::Energy,
    ];

    /// Its name in a form.
    pub fn name(self) -> &'static str {
        ["x", "rate", "slender", "inertia", "decay", "energy"][self as usize]
    }

    /// Whether it exists only for a projectile's impact.
    pub fn needs_impact(self) -> bool {
        matches!(self, Self::Inertia | Self::Decay | Self::Energy)
    }
}

/// Values of the variables, in the order of [`Variable::ALL`]; NaN if a drive does not have the variable.
pub type Values = [f64; VARIABLES];

/// A product of powers of the variables; the empty product is the constant.
#[derive(Debug, Clone, PartialEq)]
pub struct Term {
    powers: [f64; VARIABLES],
}

impl Term {
    /// The constant.
    const ONE: Self = Self {
        powers: [0.0; VARIABLES],
    };

    /// The power of a variable.
    pub fn power(&self, variable: Variable) -> f64 {
        self.powers[variable as usize]
    }

    /// The same term with another power of x.
    pub(super) fn with_depth_power(&self, power: f64) -> Self {
        let mut term = self.clone();
        term.powers[Variable::X as usize] = power;
        term
    }

    /// Its value.
    pub fn value(&self, values: &Values) -> f64 {
        self.powers
            .iter()
            .zip(values)
            .filter(|(power, _)| **power != 0.0)
            .map(|(power, value)| raise(*value, *power))
            .product()
    }

    /// Whether it varies during a drive: at constant speed, or after an impact.
    pub fn varies(&self, constant_speed: bool) -> bool {
        let has = |variable| self.power(variable) != 0.0;
        has(Variable::X) || has(Variable::Decay) || (has(Variable::Rate) && !constant_speed)
    }

    fn times(&self, other: &Self) -> Self {
        let mut powers = self.powers;
        powers
            .iter_mut()
            .zip(other.powers)
            .for_each(|(power, more)| *power += more);
        Self { powers }
    }
}

/// `value^power`, by multiplication if the power is an integer.
pub(super) fn raise(value: f64, power: f64) -> f64 {
    if power == power.trunc() {
        value.powi(power as i32)
    } else {
        value.powf(power)
    }
}

impl fmt::Display for Term {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let mut first = true;
        for variable in Variable::ALL {
            let power = self.power(variable);
            if power != 0.0 {
                if !first {
                    f.write_str("*")?;
                }
                first = false;
                f.write_str(variable.name())?;
                if power != 1.0 {
                    write!(f, "^{power}")?;
                }
            }
        }
        if first { f.write_str("1") } else { Ok(()) }
    }
}

/// Why a text is not a valid form.
#[derive(Debug, Clone, PartialEq, Error)]
#[error("\"{text}\" is no form of a penetration law: {problem}")]
pub struct FormError {
    /// The form.
    pub text: String,
    /// Description of the problem.
    pub problem: String,
}

impl FormError {
    /// How to fix it.
    pub fn remedy(&self) -> &'static str {
        "write a sum of terms such as \"poly(x,7) + rate + slender\": products (*) of powers (^) of x, rate, slender, \
         inertia, decay, energy, and 1 for a constant; poly(x,7) is 1 + x + ... + x^7"
    }
}

/// The terms of a law, in order.
#[derive(Debug, Clone, PartialEq)]
pub struct Form {
    terms: Vec<Term>,
}

impl Form {
    /// The terms.
    pub fn terms(&self) -> &[Term] {
        &self.terms
    }

    /// The form without its last term; none if nothing would remain.
    #[must_use]
    pub fn without_last(&self) -> Option<Self> {
        let (_, rest) = self.terms.split_last()?;
        (!rest.is_empty()).then(|| Self { terms: rest.to_vec() })
    }

    /// Whether any term contains this variable.
    pub fn uses(&self, variable: Variable) -> bool {
        self.terms.iter().any(|term| term.power(variable) != 0.0)
    }

    /// The highest power of x.
    pub fn degree(&self) -> f64 {
        self.terms
            .iter()
            .map(|term| term.power(Variable::X))
            .fold(0.0, f64::max)
    }
}

impl fmt::Display for Form {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        // Consecutive powers of x from the constant upwards form one polynomial.
        let power = |term: &Term, power: usize| *term == Term::ONE.with_depth_power(power as f64);
        let powers = self
            .terms
            .iter()
            .enumerate()
            .take_while(|(n, term)| power(term, *n))
            .count();
        let mut rest = self.terms.iter();
        let mut plus = "";
        if powers > 2 && powers - 1 <= HIGHEST_DEGREE as usize {
            write!(f, "poly(x,{})", powers - 1)?;
            rest.nth(powers - 1);
            plus = " + ";
        }
        for term in rest {
            write!(f, "{plus}{term}")?;
            plus = " + ";
        }
        Ok(())
    }
}

impl FromStr for Form {
    type Err = FormError;

    fn from_str(text: &str) -> Result<Self, FormError> {
        let failure = |problem: String| FormError {
            text: text.chars().take(200).collect(),
            problem,
        };
        let mut terms: Vec<Term> = Vec::new();
        for part in split(text, '+') {
            for term in product(part).map_err(failure)? {
                if terms.contains(&term) {
                    return Err(failure(format!("the term {term} stands in it twice")));
                }
                if terms.len() == MOST_TERMS {
                    return Err(failure(format!("it has more than {MOST_TERMS} terms")));
                }
                terms.push(term);
            }
        }
        for term in &terms {
            for variable in Variable::ALL {
                let power = term.power(variable);
                if power.abs() > HIGHEST_POWER {
                    return Err(failure(format!("the powers in {term} exceed {HIGHEST_POWER}")));
                }
                // Depth and speeds pass through zero during a drive.
                if power < 0.0 && matches!(variable, Variable::X | Variable::Rate | Variable::Decay) {
                    return Err(failure(format!("{term} is infinite where {} is 0", variable.name())));
                }
            }
        }
        Ok(Self { terms })
    }
}

/// Splits a text at separators outside brackets.
fn split(text: &str, separator: char) -> Vec<&str> {
    let (mut parts, mut depth, mut start) = (Vec::new(), 0_i32, 0);
    for (at, letter) in text.char_indices() {
        match letter {
            '(' => depth += 1,
            ')' => depth -= 1,
            _ if letter == separator && depth == 0 => {
                parts.push(&text[start..at]);
                start = at + letter.len_utf8();
            }
            _ => {}
        }
    }
    parts.push(&text[start..]);
    parts
}

/// Parses a product of factors into terms.
fn product(text: &str) -> Result<Vec<Term>, String> {
    let mut terms = vec![Term::ONE];
    for factor in split(text, '*') {
        let factors = factor_of(factor.trim())?;
        if terms.len() * factors.len() > MOST_TERMS {
            return Err(format!("it has more than {MOST_TERMS} terms"));
        }
        terms = terms
            .iter()
            .flat_map(|term| factors.iter().map(|factor| term.times(factor)))
            .collect();
    }
    Ok(terms)
}

/// Parses `1`, a variable with a power, or `poly(x,n)`.
fn factor_of(text: &str) -> Result<Vec<Term>, String> {
    let shown = || text.chars().take(40).collect::<String>();
    if text.is_empty() {
        return Err("a term is empty".to_owned());
    }
    if text == "1" {
        return Ok(vec![Term::ONE]);
    }
    if let Some(inner) = text.strip_prefix("poly(").and_then(|rest| rest.strip_suffix(')')) {
        let degree = inner
            .split_once(',')
            .filter(|(variable, _)| variable.trim() == "x")
            .and_then(|(_, degree)| degree.trim().parse::<u32>().ok())
            .filter(|degree| (1..=HIGHEST_DEGREE).contains(degree));
        let Some(degree) = degree else {
            return Err(format!(
                "\"{}\" is not poly(x,n) with n from 1 to {HIGHEST_DEGREE}",
                shown()
            ));
        };
        return Ok((0..=degree)
            .map(|power| Term::ONE.with_depth_power(f64::from(power)))
            .collect());
    }
    let (name, power) = text.split_once('^').map_or((text, Some(1.0)), |(name, power)| {
        (name.trim(), power.trim().parse::<f64>().ok())
    });
    let variable = Variable::ALL.into_iter().find(|variable| variable.name() == name);
    let Some(variable) = variable else {
        return Err(format!(
            "there is no variable \"{}\"",
            name.chars().take(40).collect::<String>()
        ));
    };
    let Some(power) = power.filter(|power| power.is_finite() && *power != 0.0) else {
        return Err(format!("the power in \"{}\" is no number other than 0", shown()));
    };
    let mut term = Term::ONE;
    term.powers[variable as usize] = power;
    Ok(vec![term])
}
