//! Contacts, conditions and events of the tests' own assemblies.

use nailnoise_dynamics::network::assembly::*;

/// A linear contact.
pub(crate) fn contact(name: &str, on: usize, against: Base, stop: Stop, at: f64, k: f64, c: f64) -> Contact {
    Contact {
        name: name.to_owned(),
        on,
        against,
        stop,
        at,
        stiffness: k,
        damping: ContactDamping::Dashpot(c),
        exponent: 1.0,
        may_pull: false,
    }
}

/// A channel of a block.
pub(crate) fn channel(family: Family, index: usize, quantity: Quantity) -> Expression {
    Expression::Channel(Channel {
        block: BlockRef { family, index },
        quantity,
    })
}

/// a >= b, or a > b if `strict`.
pub(crate) fn compare(a: Expression, b: f64, strict: bool) -> Condition {
    Condition {
        all: vec![Comparison {
            margin: Expression::Binary(Binary::Subtract, Box::new(a), Box::new(Expression::Constant(b))),
            strict,
        }],
    }
}

/// a <= b.
pub(crate) fn at_most(a: Expression, b: f64) -> Condition {
    compare(Expression::Negative(Box::new(a)), -b, false)
}

/// An event that waits for nothing else.
pub(crate) fn event(name: &str, edge: Edge) -> Event {
    Event {
        name: name.to_owned(),
        description: String::new(),
        edge,
        after: None,
        delay: 0.0,
        before: None,
        until: None,
        condition: None,
        lasting: 0.0,
        pick: Pick::First,
    }
}
