//! Tokens of a formula.

use nailnoise_quantities::{Dimension, quantity};

use super::term::SyntaxError;
use super::unit;

/// A token.
#[derive(Debug, Clone, PartialEq)]
pub(super) enum Token {
    Number { si: f64, dimension: Dimension, bare: bool },
    Name(String),
    Word(String),
    Symbol(&'static str),
}

impl Token {
    /// The token in words, for messages.
    pub(super) fn shown(&self) -> String {
        match self {
            Self::Number { si, .. } => si.to_string(),
            Self::Name(name) | Self::Word(name) => name.clone(),
            Self::Symbol(symbol) => (*symbol).to_owned(),
        }
    }
}

/// Symbols, the longer ones first.
const SYMBOLS: [&str; 14] = ["<=", ">=", "==", "!=", "<", ">", "+", "-", "*", "/", "^", "(", ")", ","];

/// The tokens of a text.
pub(super) fn tokens(text: &str) -> Result<Vec<Token>, SyntaxError> {
    let mut rest = text.trim_start();
    let mut tokens = Vec::new();
    while let Some(first) = rest.chars().next() {
        let (token, length) = if first.is_ascii_digit() || first == '.' {
            number(rest)?
        } else if first.is_ascii_alphabetic() || first == '_' {
            let length = name(rest);
            (Token::Name(rest[..length].to_owned()), length)
        } else if first == '\'' {
            let inner = &rest[1..];
            let end = inner.find('\'').ok_or(SyntaxError::End("a closing quote"))?;
            (Token::Word(inner[..end].to_owned()), end + 2)
        } else if let Some(symbol) = SYMBOLS.into_iter().find(|symbol| rest.starts_with(symbol)) {
            (Token::Symbol(symbol), symbol.len())
        } else {
            return Err(SyntaxError::Unexpected(first.to_string()));
        };
        tokens.push(token);
        rest = rest[length..].trim_start();
    }
    Ok(tokens)
}

/// Length of a name with dots.
fn name(text: &str) -> usize {
    let is_part = |c: char| c.is_ascii_alphanumeric() || c == '_';
    let mut end = 0;
    loop {
        end += text[end..].find(|c: char| !is_part(c)).unwrap_or(text.len() - end);
        let goes_on = text[end..]
            .strip_prefix('.')
            .is_some_and(|after| after.starts_with(|c: char| c.is_ascii_alphabetic() || c == '_'));
        if !goes_on {
            return end;
        }
        end += 1;
    }
}

/// A number with its unit, and its length.
fn number(text: &str) -> Result<(Token, usize), SyntaxError> {
    let bytes = text.as_bytes();
    let digits = |from: usize| from + bytes[from..].iter().take_while(|byte| byte.is_ascii_digit()).count();
    let mut end = digits(0);
    if bytes.get(end) == Some(&b'.') {
        end = digits(end + 1);
    }
    if matches!(bytes.get(end), Some(b'e' | b'E')) {
        let sign = usize::from(matches!(bytes.get(end + 1), Some(b'+' | b'-')));
        let exponent = digits((end + 1 + sign).min(bytes.len()));
        if exponent > end + 1 + sign {
            end = exponent;
        }
    }
    let unit = unit::length(&text[end..]);
    let word = text[end..].trim_start();
    let attached = !text[end..].starts_with(char::is_whitespace);
    if unit == 0 && attached && word.starts_with(|c: char| c.is_alphabetic() || c == '_') {
        let word = word.split(|c: char| !c.is_alphanumeric()).next().unwrap_or("");
        return Err(SyntaxError::Unit(word.to_owned()));
    }
    let whole = text[..end + unit].trim();
    let dimension =
        Dimension::of_unit(&text[end..end + unit]).map_err(|_| SyntaxError::Unit(text[end..end + unit].to_owned()))?;
    let read = quantity(whole, dimension, true).map_err(|_| SyntaxError::Number(whole.to_owned()))?;
    if read.gauge {
        return Err(SyntaxError::Gauge(whole.to_owned()));
    }
    let si = read.si;
    let token = Token::Number {
        si,
        dimension,
        bare: unit == 0,
    };
    Ok((token, end + unit))
}
