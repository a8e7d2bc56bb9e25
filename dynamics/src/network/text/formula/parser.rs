//! Parser of formulas, by recursive descent.

use super::term::{Relation, SyntaxError, Term};
use super::tokens::{Token, tokens};
use crate::network::assembly::{Binary, Function};

/// Largest depth of nested terms.
const DEEPEST: u32 = 64;
/// Largest number of tokens, which bounds the depth of the tree of a sum.
const LONGEST: usize = 1000;

/// Reads a formula or condition.
pub(in crate::network::text) fn parse(text: &str) -> Result<Term, SyntaxError> {
    let tokens = tokens(text)?;
    if tokens.len() > LONGEST {
        return Err(SyntaxError::Long(LONGEST));
    }
    let mut parser = Parser {
        tokens: &tokens,
        depth: 0,
    };
    let term = parser.or()?;
    match parser.tokens.first() {
        None => Ok(term),
        Some(token) => Err(SyntaxError::Unexpected(token.shown())),
    }
}

struct Parser<'a> {
    tokens: &'a [Token],
    depth: u32,
}

impl Parser<'_> {
    /// Takes a symbol if it is the next token.
    fn take(&mut self, symbol: &str) -> bool {
        let found = matches!(self.tokens.first(), Some(Token::Symbol(own)) if *own == symbol);
        if found {
            self.tokens = &self.tokens[1..];
        }
        found
    }

    /// Takes a keyword if it is the next token.
    fn keyword(&mut self, word: &str) -> bool {
        let found = matches!(self.tokens.first(), Some(Token::Name(name)) if name == word);
        if found {
            self.tokens = &self.tokens[1..];
        }
        found
    }

    fn expect(&mut self, symbol: &'static str) -> Result<(), SyntaxError> {
        if self.take(symbol) {
            return Ok(());
        }
        Err(self
            .tokens
            .first()
            .map_or(SyntaxError::End(symbol), |token| SyntaxError::Unexpected(token.shown())))
    }

    /// Runs a rule one level deeper.
    fn deeper(&mut self, rule: impl FnOnce(&mut Self) -> Result<Term, SyntaxError>) -> Result<Term, SyntaxError> {
        if self.depth == DEEPEST {
            return Err(SyntaxError::Depth);
        }
        self.depth += 1;
        let term = rule(self);
        self.depth -= 1;
        term
    }

    fn or(&mut self) -> Result<Term, SyntaxError> {
        let mut term = self.and()?;
        while self.keyword("or") {
            term = Term::Or(Box::new(term), Box::new(self.and()?));
        }
        Ok(term)
    }

    fn and(&mut self) -> Result<Term, SyntaxError> {
        let mut term = self.not()?;
        while self.keyword("and") {
            term = Term::And(Box::new(term), Box::new(self.not()?));
        }
        Ok(term)
    }

    fn not(&mut self) -> Result<Term, SyntaxError> {
        if self.keyword("not") {
            return Ok(Term::Not(Box::new(self.deeper(Self::not)?)));
        }
        self.compare()
    }

    fn compare(&mut self) -> Result<Term, SyntaxError> {
        const RELATIONS: [(&str, Relation); 6] = [
            ("<=", Relation::LessOrEqual),
            (">=", Relation::GreaterOrEqual),
            ("==", Relation::Equal),
            ("!=", Relation::NotEqual),
            ("<", Relation::Less),
            (">", Relation::Greater),
        ];
        let left = self.sum()?;
        match RELATIONS.into_iter().find(|(symbol, _)| self.take(symbol)) {
            Some((_, relation)) => Ok(Term::Compare(relation, Box::new(left), Box::new(self.sum()?))),
            None => Ok(left),
        }
    }

    fn sum(&mut self) -> Result<Term, SyntaxError> {
        let mut term = self.product()?;
        loop {
            let operation = if self.take("+") {
                Binary::Add
            } else if self.take("-") {
                Binary::Subtract
            } else {
                return Ok(term);
            };
            term = Term::Binary(operation, Box::new(term), Box::new(self.product()?));
        }
    }

    fn product(&mut self) -> Result<Term, SyntaxError> {
        let mut term = self.unary()?;
        loop {
            let operation = if self.take("*") {
                Binary::Multiply
            } else if self.take("/") {
                Binary::Divide
            } else {
                return Ok(term);
            };
            term = Term::Binary(operation, Box::new(term), Box::new(self.unary()?));
        }
    }

    fn unary(&mut self) -> Result<Term, SyntaxError> {
        if self.take("-") {
            return Ok(Term::Negative(Box::new(self.deeper(Self::unary)?)));
        }
        let base = self.atom()?;
        if self.take("^") {
            let exponent = self.deeper(Self::unary)?;
            return Ok(Term::Binary(Binary::Power, Box::new(base), Box::new(exponent)));
        }
        Ok(base)
    }

    fn atom(&mut self) -> Result<Term, SyntaxError> {
        let (token, rest) = self.tokens.split_first().ok_or(SyntaxError::End("a value"))?;
        self.tokens = rest;
        match token {
            Token::Number { si, dimension, bare } => Ok(Term::Number {
                si: *si,
                dimension: *dimension,
                bare: *bare,
            }),
            Token::Word(word) => Ok(Term::Word(word.clone())),
            Token::Name(name) if matches!(name.as_str(), "and" | "or" | "not") => {
                Err(SyntaxError::Unexpected(name.clone()))
            }
            Token::Name(name) if self.take("(") => self.call(name),
            Token::Name(name) => Ok(Term::Name(name.clone())),
            Token::Symbol("(") => {
                let term = self.deeper(Self::or)?;
                self.expect(")")?;
                Ok(term)
            }
            Token::Symbol(symbol) => Err(SyntaxError::Unexpected((*symbol).to_owned())),
        }
    }

    fn call(&mut self, name: &str) -> Result<Term, SyntaxError> {
        let mut arguments = vec![self.deeper(Self::or)?];
        while self.take(",") {
            arguments.push(self.deeper(Self::or)?);
        }
        self.expect(")")?;
        if name == "if" {
            let found = arguments.len();
            let three: Result<[Term; 3], _> = arguments.try_into();
            return three
                .map(|three| Term::Either(Box::new(three)))
                .map_err(|_| SyntaxError::Arguments {
                    name: name.to_owned(),
                    expected: "a condition and two values",
                    found,
                });
        }
        let function = match name {
            "disc" => None,
            "sqrt" => Some(Function::Sqrt),
            "exp" => Some(Function::Exp),
            "sin" => Some(Function::Sin),
            "cos" => Some(Function::Cos),
            "tan" => Some(Function::Tan),
            "abs" => Some(Function::Abs),
            "min" => Some(Function::Min),
            "max" => Some(Function::Max),
            _ => return Err(SyntaxError::Function(name.to_owned())),
        };
        let pair = matches!(function, Some(Function::Min | Function::Max));
        let found = arguments.len();
        let wrong = |expected| {
            Err(SyntaxError::Arguments {
                name: name.to_owned(),
                expected,
                found,
            })
        };
        match (pair, found) {
            (true, 2) | (false, 1) => {}
            (true, _) => return wrong("two values"),
            (false, _) => return wrong("one value"),
        }
        match (function, arguments.pop()) {
            (None, Some(diameter)) => Ok(Term::Disc(Box::new(diameter))),
            (Some(function), Some(last)) => {
                arguments.push(last);
                Ok(Term::Function(function, arguments))
            }
            (_, None) => Err(SyntaxError::End("a value")),
        }
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]

    use super::*;
    use nailnoise_quantities::dimension::{LENGTH, NUMBER, VELOCITY};

    fn number(si: f64) -> Box<Term> {
        Box::new(Term::Number {
            si,
            dimension: NUMBER,
            bare: true,
        })
    }

    #[test]
    fn powers_bind_before_signs_and_products_before_sums() {
        let square = Term::Binary(Binary::Power, number(2.0), number(2.0));
        let product = Term::Binary(Binary::Multiply, number(3.0), number(4.0));
        let negative = Term::Negative(Box::new(square));
        let sum = Term::Binary(Binary::Add, Box::new(negative), Box::new(product));
        assert_eq!(parse("-2^2 + 3*4").unwrap(), sum);
    }

    #[test]
    fn a_choice_has_a_condition_and_two_values() {
        let condition = Term::Compare(Relation::Greater, Box::new(Term::Name("a".to_owned())), number(1.0));
        let word = |text: &str| Term::Word(text.to_owned());
        let expected = Term::Either(Box::new([condition, word("b"), word("c")]));
        assert_eq!(parse("if(a > 1, 'b', 'c')").unwrap(), expected);
        assert!(parse("if(a > 1, 'b')").is_err());
    }

    #[test]
    fn numbers_carry_units() {
        let term = |si, dimension| Term::Number {
            si,
            dimension,
            bare: false,
        };
        assert_eq!(parse("50.51 mm").unwrap(), term(0.05051, LENGTH));
        assert_eq!(parse("0.1 m/s").unwrap(), term(0.1, VELOCITY));
    }

    #[test]
    fn what_is_no_formula_is_refused() {
        for text in [
            "",
            "1 +",
            "(1",
            "f(1)",
            "min(1)",
            "1 2",
            "a b",
            "2 furlong",
            "3x",
            "a = b",
            "'open",
            "not",
        ] {
            assert!(parse(text).is_err(), "{text}");
        }
        assert_eq!(parse(&"(".repeat(500)), Err(SyntaxError::Depth));
        assert_eq!(parse(&format!("{}1", "-".repeat(500))), Err(SyntaxError::Depth));
        assert_eq!(
            parse(&format!("1{}", "+1".repeat(500))),
            Err(SyntaxError::Long(LONGEST))
        );
    }
}
