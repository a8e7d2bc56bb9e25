//! Evaluates the formulas of an assembly for given values of keys.

use std::cell::RefCell;
use std::collections::{BTreeMap, BTreeSet};

use nailnoise_quantities::dimension::{NUMBER, PRESSURE};
use nailnoise_quantities::{Dimension, Kind, any};

use super::compile::{Branch, Compiled, Scalar, Scope, Trouble, Word, compile};
use super::fault::{AssemblyError, Change, Fault};
use super::formula::parse;
use super::keys::{KeyValue, Keys};
use super::layers::{AssemblyText, dotted};
use super::literal::{Literal, details, dimension, read};
use super::names::{self, Block, CHANNELS, Names, family_name, quantities};
use super::node::{Node, Spot, Tree};
use crate::network::assembly::{BlockRef, Channel, Expression, Family};

/// Longest chain of names that depend on each other.
const DEEPEST: usize = 64;

/// The evaluation of one assembly.
pub(super) struct Resolver<'a> {
    pub(super) text: &'a AssemblyText,
    keys: &'a dyn Keys,
    pub(super) names: Names<'a>,
    state: RefCell<State>,
}

#[derive(Debug, Default)]
struct State {
    /// Names being evaluated, to detect cycles.
    stack: Vec<String>,
    /// Number of unselected branches being compiled, one inside the other.
    unselected: usize,
    /// Values of names that have been evaluated.
    values: BTreeMap<String, Compiled>,
    /// Values of names that only unselected branches have evaluated.
    unselected_values: BTreeMap<String, Compiled>,
    literals: Vec<Literal>,
    used: BTreeSet<String>,
}

impl State {
    /// The value of a name that has been evaluated. One from an unselected branch does not count in a selected one,
    /// where its keys have an effect.
    fn value(&self, name: &str) -> Option<&Compiled> {
        let unselected = || self.unselected_values.get(name).filter(|_| self.unselected > 0);
        self.values.get(name).or_else(unselected)
    }

    fn insert(&mut self, name: &str, value: &Compiled) {
        let values = if self.unselected == 0 {
            &mut self.values
        } else {
            &mut self.unselected_values
        };
        values.insert(name.to_owned(), value.clone());
    }

    /// Notes that a formula uses a key, unless an unselected branch reads it.
    fn note_use(&mut self, key: &str) {
        if self.unselected == 0 {
            self.used.insert(key.to_owned());
        }
    }
}

impl<'a> Resolver<'a> {
    /// The evaluation of an assembly over the values of keys.
    pub(super) fn new(text: &'a AssemblyText, keys: &'a dyn Keys) -> Result<Self, AssemblyError> {
        let mut resolver = Self {
            text,
            keys,
            names: Names::default(),
            state: RefCell::default(),
        };
        resolver.names = resolver.collect()?;
        Ok(resolver)
    }

    /// The literals and keys that were read.
    pub(super) fn finish(self) -> (Vec<Literal>, BTreeSet<String>) {
        let state = self.state.into_inner();
        (state.literals, state.used)
    }

    pub(super) fn error(&self, path: &str, spot: &Spot, fault: Fault) -> AssemblyError {
        self.text.error(path, spot, fault)
    }

    /// Names of all blocks, with those switched off by an `if` listed separately.
    fn collect(&self) -> Result<Names<'a>, AssemblyError> {
        let mut names = Names::default();
        for (table, family) in CHANNELS {
            for entry in self.text.cycle.get(table).map_or(&[][..], Node::entries) {
                let path = format!("cycle.{table}.{}", entry.key);
                self.check_name(&path, &entry.key, &entry.spot)?;
                if !self.is_on(&path, &entry.node)? {
                    names.off.push(&entry.key);
                    continue;
                }
                if let Some(other) = names.find(&entry.key) {
                    let other = family_name(other.block.family).to_owned();
                    return Err(self.error(&path, &entry.spot, Fault::DuplicateName { other }));
                }
                let index = names.blocks.iter().filter(|block| block.block.family == family).count();
                names.blocks.push(Block {
                    name: &entry.key,
                    block: BlockRef { family, index },
                    node: &entry.node,
                    spot: &entry.spot,
                });
            }
        }
        for entry in self.text.cycle.get("let").map_or(&[][..], Node::entries) {
            if is_reserved(&entry.key) {
                let path = format!("cycle.let.{}", entry.key);
                return Err(self.error(&path, &entry.spot, Fault::Reserved));
            }
        }
        for (table, list) in [("sensor", &mut names.sensors), ("event", &mut names.events)] {
            for entry in self.text.cycle.get(table).map_or(&[][..], Node::entries) {
                let path = format!("cycle.{table}.{}", entry.key);
                self.check_name(&path, &entry.key, &entry.spot)?;
                if self.is_on(&path, &entry.node)? {
                    list.push(entry.key.as_str());
                }
            }
        }
        let twice = names.sensors.iter().find_map(|sensor| names.find(sensor));
        if let Some(block) = twice {
            let path = format!("cycle.sensor.{}", block.name);
            let other = family_name(block.block.family).to_owned();
            return Err(self.error(&path, block.spot, Fault::DuplicateName { other }));
        }
        Ok(names)
    }

    pub(super) fn check_name(&self, path: &str, name: &str, spot: &Spot) -> Result<(), AssemblyError> {
        let first = name.starts_with(|c: char| c.is_ascii_lowercase());
        let rest = name
            .chars()
            .all(|c| c.is_ascii_lowercase() || c.is_ascii_digit() || c == '_');
        if is_reserved(name) {
            return Err(self.error(path, spot, Fault::Reserved));
        }
        if first && rest {
            return Ok(());
        }
        Err(self.error(path, spot, Fault::BadName))
    }

    /// Whether the `if` of a block is satisfied.
    pub(super) fn is_on(&self, path: &str, node: &Node) -> Result<bool, AssemblyError> {
        let Some(condition) = node.get("if") else {
            return Ok(true);
        };
        let path = dotted(path, "if");
        match (&condition.value, condition.text()) {
            (Tree::Flag(on), _) => Ok(*on),
            (_, Some(text)) => match self.formula(&path, condition, text, &KeyScope(self))? {
                Compiled::Truth(on) => Ok(on),
                _ => Err(self.error(
                    &path,
                    &condition.spot,
                    Fault::Kind {
                        found: format!("\"{text}\""),
                        expected: "a condition over keys, as hand.mass > 0".to_owned(),
                    },
                )),
            },
            (_, None) => Err(self.error(
                &path,
                &condition.spot,
                Fault::Kind {
                    found: condition.found(),
                    expected: "a condition over keys, as hand.mass > 0".to_owned(),
                },
            )),
        }
    }

    /// Compiles a formula at a node.
    pub(super) fn formula(
        &self,
        path: &str,
        node: &Node,
        text: &str,
        scope: &dyn Scope,
    ) -> Result<Compiled, AssemblyError> {
        let compiled = parse(text)
            .map_err(|error| Trouble::here(error.to_string(), error.help()))
            .and_then(|term| compile(&term, scope));
        compiled.map_err(|trouble| match trouble {
            Trouble::Elsewhere(error) => *error,
            Trouble::Fault(fault) => self.error(path, &node.spot, fault),
            Trouble::Here { problem, help } => self.error(
                path,
                &node.spot,
                Fault::Formula {
                    formula: text.to_owned(),
                    problem,
                    help,
                },
            ),
        })
    }

    /// The number at a node: a formula over keys or a literal.
    pub(super) fn quantity(&self, path: &str, node: &Node, kind: Kind) -> Result<f64, AssemblyError> {
        let expected = dimension(kind);
        let text = node.get("value").unwrap_or(node).text();
        let scalar = match text.and_then(|text| text.strip_prefix('=')) {
            Some(_) if node.get("range").is_some() => {
                let fields = ["a formula", "range"].map(str::to_owned).to_vec();
                return Err(self.error(path, &node.spot, Fault::Exclusive { fields }));
            }
            Some(formula) => match self.formula(path, node, formula, &KeyScope(self))? {
                Compiled::Scalar(scalar) => scalar,
                other => {
                    let found = other.kind();
                    let expected = expected.to_string();
                    return Err(self.error(path, &node.spot, Fault::Kind { found, expected }));
                }
            },
            None => self.literal(path, node, kind)?,
        };
        if let Some(found) = scalar.dimension
            && found != expected
        {
            let fault = Fault::Dimension {
                found: found.to_string(),
                expected: expected.to_string(),
                units: expected.examples(),
            };
            return Err(self.error(path, &node.spot, fault));
        }
        let value = scalar.number().unwrap_or(f64::NAN);
        if kind.allows(value) {
            return Ok(value);
        }
        let allowed = kind.allowed();
        Err(self.error(path, &node.spot, Fault::Domain { value, allowed }))
    }

    /// A literal, or the value that replaces it.
    fn literal(&self, path: &str, node: &Node, kind: Kind) -> Result<Scalar, AssemblyError> {
        let wrong = |fault| self.error(path, &node.spot, fault);
        let measured = read(node, kind).map_err(wrong)?;
        let details = details(node, kind).map_err(wrong)?;
        let ends = details.range.iter().flatten();
        let ambient = if measured.gauge || ends.clone().any(|end| end.gauge) {
            self.ambient_pressure(path, node)?
        } else {
            0.0
        };
        let range = details.range.map(|ends| ends.map(|end| end.absolute(ambient)));
        if let Some([low, high]) = range {
            let value = measured.absolute(ambient);
            let outside = [low, high].into_iter().find(|end| !kind.allows(*end));
            if let Some(value) = outside {
                let allowed = kind.allowed();
                return Err(wrong(Fault::Domain { value, allowed }));
            }
            // A value that a nearer file gives may lie outside the range of the base.
            let [from, to] = ["value", "range"].map(|field| node.get(field).map(|own| own.spot.document));
            if from == to && !(low..=high).contains(&value) {
                let allowed = format!("within its range, from {low} to {high}");
                return Err(wrong(Fault::Domain { value, allowed }));
            }
        }
        let si = match self.keys.value(path) {
            Some(KeyValue::Quantity { si, .. }) => si,
            _ => measured.absolute(ambient),
        };
        let literal = Literal {
            path: path.to_owned(),
            kind,
            si,
            range,
            provenance: details.provenance,
            note: details.note,
            at: *self.text.sources.place(&node.spot),
        };
        let mut state = self.state.borrow_mut();
        let is_selected = state.unselected == 0;
        if is_selected && !state.literals.iter().any(|known| known.path == literal.path) {
            state.literals.push(literal);
        }
        Ok(Scalar::constant(si, dimension(kind)))
    }

    /// Pressure of the atmosphere; gauge pressures are relative to it \[Pa\].
    fn ambient_pressure(&self, path: &str, node: &Node) -> Result<f64, AssemblyError> {
        const ATMOSPHERE: &str = "cycle.reservoir.atmosphere.pressure";
        if path == ATMOSPHERE {
            let fault = Fault::Literal {
                text: node.get("value").unwrap_or(node).text().unwrap_or_default().to_owned(),
                problem: "gauge pressures are relative to this pressure".to_owned(),
                units: PRESSURE.examples(),
            };
            return Err(self.error(path, &node.spot, fault));
        }
        let pressure = self
            .named(ATMOSPHERE)
            .map_err(|trouble| self.placed(path, node, trouble))?;
        match pressure {
            Some(Compiled::Scalar(scalar)) => Ok(scalar.number().unwrap_or(f64::NAN)),
            _ => Err(self.error(path, &node.spot, Fault::NoAtmosphere)),
        }
    }

    fn placed(&self, path: &str, node: &Node, trouble: Trouble) -> AssemblyError {
        match trouble {
            Trouble::Elsewhere(error) => *error,
            Trouble::Fault(fault) => self.error(path, &node.spot, fault),
            Trouble::Here { problem, help } => {
                let formula = node.text().unwrap_or_default().to_owned();
                self.error(path, &node.spot, Fault::Formula { formula, problem, help })
            }
        }
    }

    /// The value of a literal whose dimension is that of its unit.
    fn untyped(&self, path: &str, node: &Node) -> Result<Compiled, AssemblyError> {
        let value = node.get("value").unwrap_or(node);
        match (&value.value, value.text()) {
            (Tree::Flag(on), _) => Ok(Compiled::Truth(*on)),
            (_, Some(text)) => match text.strip_prefix('=') {
                Some(formula) => self.formula(path, value, formula, &KeyScope(self)),
                None => {
                    let kind = any(unit_dimension(text)).or_gauge();
                    self.literal(path, node, kind).map(Compiled::Scalar)
                }
            },
            (Tree::Number(number), _) => {
                let mut scalar = self.literal(path, node, any(NUMBER))?;
                if *number == 0.0 {
                    scalar.dimension = None;
                }
                Ok(Compiled::Scalar(scalar))
            }
            _ => Err(self.error(
                path,
                &value.spot,
                Fault::Kind {
                    found: value.found(),
                    expected: "a quantity or a formula".to_owned(),
                },
            )),
        }
    }

    /// The value of a name defined by other values, evaluated once; a name must not depend on itself.
    fn once(
        &self,
        name: &str,
        node: &Node,
        evaluate: impl FnOnce() -> Result<Compiled, AssemblyError>,
    ) -> Result<Compiled, Trouble> {
        {
            let mut state = self.state.borrow_mut();
            if let Some(value) = state.value(name) {
                return Ok(value.clone());
            }
            if let Some(at) = state.stack.iter().position(|other| other == name) {
                let mut names = state.stack[at..].to_vec();
                names.push(name.to_owned());
                drop(state);
                let error = self.error(name, &node.spot, Fault::Circle { names });
                return Err(Trouble::Elsewhere(Box::new(error)));
            }
            if state.stack.len() == DEEPEST {
                return Err(Trouble::here(
                    format!("names refer to each other more than {DEEPEST} deep"),
                    "combine formulas",
                ));
            }
            state.stack.push(name.to_owned());
        }
        let value = evaluate();
        let mut state = self.state.borrow_mut();
        state.stack.pop();
        let value = value.map_err(|error| Trouble::Elsewhere(Box::new(error)))?;
        state.insert(name, &value);
        Ok(value)
    }

    /// The value of a key, a name of `[cycle.let]` or a literal by its path, if there is one.
    fn named(&self, name: &str) -> Result<Option<Compiled>, Trouble> {
        if !name.contains('.') {
            let path = format!("cycle.let.{name}");
            let Some(node) = self.text.cycle.get("let").and_then(|lets| lets.get(name)) else {
                return Ok(None);
            };
            return self.once(&path, node, || self.untyped(&path, node)).map(Some);
        }
        if let Some(value) = self.keys.value(name) {
            self.state.borrow_mut().note_use(name);
            return Ok(Some(match value {
                KeyValue::Quantity { si, dimension } => Compiled::Scalar(Scalar::constant(si, dimension)),
                KeyValue::Switch(on) => Compiled::Truth(on),
                KeyValue::Choice { word, words } => word_of(word, words),
                KeyValue::Word(word) => Compiled::Word(Word::new(word)),
            }));
        }
        if let Some(rest) = name.strip_prefix("cycle.") {
            let node = rest.split('.').try_fold(&self.text.cycle, |node, key| node.get(key));
            return match node {
                Some(node) => self.once(name, node, || self.untyped(name, node)).map(Some),
                None => Ok(None),
            };
        }
        let kind = self.text.kind(name);
        let Some(node) = self.text.values.get(name) else {
            // A key needs no value where only an unselected branch reads it.
            return Ok(kind.filter(|_| !self.is_selected()).map(placeholder));
        };
        let value = self.once(name, node, || {
            let kind = kind.ok_or_else(|| self.text.undeclared(name, node))?;
            match kind {
                Kind::Quantity { .. } | Kind::Count(_) => self
                    .quantity(name, node, kind)
                    .map(|si| Compiled::Scalar(Scalar::constant(si, dimension(kind)))),
                Kind::Switch | Kind::Choice(_) | Kind::File | Kind::Name => {
                    let value = node.get("value").unwrap_or(node);
                    let words = match kind {
                        Kind::Choice(words) => words,
                        _ => &[],
                    };
                    match (&value.value, value.text()) {
                        (Tree::Flag(on), _) => Ok(Compiled::Truth(*on)),
                        (_, Some(word)) => Ok(word_of(word, words)),
                        _ => {
                            let found = value.found();
                            let expected = "a word".to_owned();
                            Err(self.error(name, &value.spot, Fault::Kind { found, expected }))
                        }
                    }
                }
            }
        })?;
        self.state.borrow_mut().note_use(name);
        Ok(Some(value))
    }

    /// Compiles the unselected branch of an `if`, without an effect of its keys. `None` if it refers to itself, which
    /// is an error only in a selected branch.
    fn compile_unselected(&self, branch: &mut Branch<'_>) -> Result<Option<Compiled>, Trouble> {
        self.state.borrow_mut().unselected += 1;
        let value = branch();
        self.state.borrow_mut().unselected -= 1;
        match value {
            Err(Trouble::Elsewhere(error)) if matches!(error.fault, Fault::Circle { .. }) => Ok(None),
            value => value.map(Some),
        }
    }

    fn is_selected(&self) -> bool {
        self.state.borrow().unselected == 0
    }

    /// All names that formulas may use, for messages.
    fn known(&self) -> Vec<String> {
        let lets = self.text.cycle.get("let").map_or(&[][..], Node::entries);
        let mut known: Vec<String> = lets.iter().map(|entry| entry.key.clone()).collect();
        known.extend(self.keys.names());
        known.extend(self.text.values.keys().cloned());
        known
    }

    /// The error for a name without a meaning.
    fn unknown(&self, name: &str, wanted: &str, mut known: Vec<String>) -> Trouble {
        if self.text.kind(name).is_some() {
            return Trouble::here(
                format!("the key `{name}` has no value"),
                "give it, or the design that has it, as base = \"designs/n80cb.toml\"",
            );
        }
        if let Some(Change { path, at }) = self.text.removal(name) {
            return Trouble::here(
                format!(
                    "`{name}` is no {wanted}: {}, line {}, removes `{path}`",
                    at.file(),
                    at.line()
                ),
                "change this formula as well, or keep what it names",
            );
        }
        known.extend(self.known());
        let near = nailnoise_documents::nearest(known.iter().map(String::as_str), name);
        let help = match near {
            Some(near) => format!("did you mean `{near}`?"),
            None => "declare a key under [keys], or a name under [cycle.let]".to_owned(),
        };
        Trouble::here(format!("`{name}` is no {wanted}"), help)
    }

    /// Names of a group of keys, if there is one.
    pub(super) fn has_group(&self, group: &str) -> bool {
        let prefix = format!("{group}.");
        self.keys.names().iter().any(|name| name.starts_with(&prefix))
            || self.text.values.keys().any(|name| name.starts_with(&prefix))
    }
}

/// Whether a name has a predefined meaning in formulas.
fn is_reserved(name: &str) -> bool {
    matches!(name, "ground" | "key" | "pi" | "and" | "or" | "not")
}

/// A value of the kind of a key, for an unselected branch.
fn placeholder(kind: Kind) -> Compiled {
    match kind {
        Kind::Quantity { .. } | Kind::Count(_) => Compiled::Scalar(Scalar::constant(f64::NAN, dimension(kind))),
        Kind::Switch => Compiled::Truth(false),
        Kind::Choice(words) => word_of(words.first().copied().unwrap_or_default(), words),
        Kind::File | Kind::Name => Compiled::Word(Word::new("")),
    }
}

/// A word of a key that may be one of some words.
fn word_of(text: &str, allowed: &'static [&'static str]) -> Compiled {
    let word = Word::new(text);
    Compiled::Word(Word { allowed, ..word })
}

/// Dimension of the unit of a quantity; dimensionless for a text that is not a quantity.
fn unit_dimension(text: &str) -> Dimension {
    let unit = text
        .trim()
        .trim_start_matches(|c: char| c.is_ascii_digit() || matches!(c, '+' | '-' | '.'));
    let exponent = unit
        .strip_prefix(['e', 'E'])
        .map(|rest| rest.trim_start_matches(['+', '-']))
        .filter(|rest| rest.starts_with(|c: char| c.is_ascii_digit()))
        .map(|rest| rest.trim_start_matches(|c: char| c.is_ascii_digit()));
    Dimension::of_unit(exponent.unwrap_or(unit)).unwrap_or(NUMBER)
}

/// Names in formulas over keys.
pub(super) struct KeyScope<'r, 'a>(pub(super) &'r Resolver<'a>);

impl Scope for KeyScope<'_, '_> {
    fn value(&self, name: &str) -> Result<Compiled, Trouble> {
        let name = name.strip_prefix("key.").unwrap_or(name);
        match self.0.named(name)? {
            Some(value) => Ok(value),
            None => Err(self.0.unknown(name, "key and no name of [cycle.let]", Vec::new())),
        }
    }

    fn is_selected(&self) -> bool {
        self.0.is_selected()
    }

    fn compile_unselected(&self, branch: &mut Branch<'_>) -> Result<Option<Compiled>, Trouble> {
        self.0.compile_unselected(branch)
    }
}

/// Names in expressions over the state: channels first, then sensors, names of `[cycle.let]` and keys.
pub(super) struct StateScope<'r, 'a> {
    pub(super) resolver: &'r Resolver<'a>,
    /// Whether the channels of switched-off blocks are zero.
    pub(super) off_is_zero: bool,
    /// Dimensions of the sensors in order.
    pub(super) sensors: &'r [Option<Dimension>],
}

impl StateScope<'_, '_> {
    fn channel(&self, name: &str) -> Result<Option<Compiled>, Trouble> {
        let names = &self.resolver.names;
        let Some((block, word)) = name.split_once('.') else {
            return Ok(None);
        };
        let known = |family: Family| {
            quantities(family)
                .iter()
                .find(|(own, _)| *own == word)
                .map(|(_, own)| *own)
        };
        if let Some(found) = names.find(block) {
            return Ok(known(found.block.family).map(|quantity| {
                Compiled::Scalar(Scalar {
                    value: Expression::Channel(Channel {
                        block: found.block,
                        quantity,
                    }),
                    dimension: Some(names::dimension(quantity)),
                })
            }));
        }
        let is_quantity = CHANNELS.iter().any(|(_, family)| known(*family).is_some());
        if names.off.contains(&block) && is_quantity {
            if self.off_is_zero || !self.is_selected() {
                let value = Expression::Constant(0.0);
                return Ok(Some(Compiled::Scalar(Scalar { value, dimension: None })));
            }
            let name = block.to_owned();
            return Err(Trouble::Fault(Fault::SwitchedOff { name }));
        }
        Ok(None)
    }
}

impl Scope for StateScope<'_, '_> {
    fn value(&self, name: &str) -> Result<Compiled, Trouble> {
        let names = &self.resolver.names;
        if let Some(key) = name.strip_prefix("key.") {
            return KeyScope(self.resolver).value(key);
        }
        if let Some(channel) = self.channel(name)? {
            return Ok(channel);
        }
        if let Some(index) = names.sensors.iter().position(|sensor| *sensor == name) {
            return Ok(Compiled::Scalar(Scalar {
                value: Expression::Sensor(index),
                dimension: self.sensors.get(index).copied().flatten(),
            }));
        }
        if let Some(value) = self.resolver.named(name)? {
            return Ok(value);
        }
        let mut known: Vec<String> = names.sensors.iter().map(|sensor| (*sensor).to_owned()).collect();
        for block in &names.blocks {
            let of = quantities(block.block.family).iter();
            known.extend(of.map(|(quantity, _)| format!("{}.{quantity}", block.name)));
        }
        Err(self
            .resolver
            .unknown(name, "channel, sensor, name of [cycle.let] or key", known))
    }

    fn is_selected(&self) -> bool {
        self.resolver.is_selected()
    }

    fn compile_unselected(&self, branch: &mut Branch<'_>) -> Result<Option<Compiled>, Trouble> {
        self.resolver.compile_unselected(branch)
    }
}
