//! Formulas and conditions as text: grammar and syntax tree.
//!
//! ```text
//! or      := and { "or" and }
//! and     := not { "and" not }
//! not     := "not" not | compare
//! compare := sum [ ("<" | "<=" | ">" | ">=" | "==" | "!=") sum ]
//! sum     := product { ("+" | "-") product }
//! product := unary { ("*" | "/") unary }
//! unary   := "-" unary | power
//! power   := atom [ "^" unary ]
//! atom    := number [ unit ] | name | name "(" or { "," or } ")" | "(" or ")" | "'" word "'"
//! ```
//! After a number, unit symbols take precedence over names: `10 um`, `0.1 m/s`, `200 W/(m2 K)`.

mod parser;
mod term;
mod tokens;
mod unit;

pub(super) use parser::parse;
pub(super) use term::{Relation, Term};
