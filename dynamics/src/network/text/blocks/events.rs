//! Sensors, events, triggers and outcomes.

use nailnoise_quantities::dimension::TIME;
use nailnoise_quantities::{Dimension, nonnegative};

use super::list::{each, entries};
use super::tables::events::{EVENT, PICKS, SENSOR, STEP, TRIGGER};
use crate::network::assembly::{
    Action, Comparison, Condition, Edge, Event, Expression, Family, Opens, Outcome, OutcomeTest, Passage, Pick, Sensor,
    Trigger, Word,
};
use crate::network::text::compile::{Compiled, Scalar};
use crate::network::text::fault::{AssemblyError, Fault};
use crate::network::text::fields::Fields;
use crate::network::text::names::{Block, quantities, words};
use crate::network::text::node::{Node, Tree};
use crate::network::text::resolver::{Resolver, StateScope};

/// A sensor and its dimension.
pub(super) struct Measured {
    pub(super) sensor: Sensor,
    dimension: Dimension,
}

/// Dimensions of the sensors in order.
pub(super) fn dimensions(sensors: &[Measured]) -> Vec<Option<Dimension>> {
    sensors.iter().map(|sensor| Some(sensor.dimension)).collect()
}

pub(super) fn sensors(resolver: &Resolver<'_>) -> Result<Vec<Measured>, AssemblyError> {
    let fields = entries(resolver, "sensor", &SENSOR)?;
    let unit = |(_, fields): &(&str, Fields<'_, '_>)| {
        let unit = fields.text("unit")?.unwrap_or_default();
        Dimension::of_unit(unit).map_err(|error| {
            let (text, problem) = (unit.to_owned(), error.to_string());
            let units = "m, Pa, N, ...".to_owned();
            fields.error("unit", Fault::Literal { text, problem, units })
        })
    };
    let units = fields.iter().map(unit).collect::<Result<Vec<_>, _>>()?;
    let known: Vec<Option<Dimension>> = units.iter().copied().map(Some).collect();
    let mut sensors = Vec::new();
    for ((name, fields), dimension) in fields.iter().zip(units) {
        let scalar = expression(fields, "is", &known, false)?.ok_or_else(|| fields.missing("is"))?;
        expect(fields, "is", &scalar, dimension)?;
        sensors.push(Measured {
            sensor: Sensor {
                name: (*name).to_owned(),
                value: scalar.value,
                unit: dimension.unit(),
            },
            dimension,
        });
    }
    for start in 0..fields.len() {
        let mut path = vec![start];
        if reaches(&sensors, start, start, &mut path, &mut vec![false; sensors.len()]) {
            let others: Vec<_> = path[1..path.len() - 1]
                .iter()
                .map(|sensor| &fields[*sensor].1)
                .collect();
            return Err(fields[start].1.circle(&others, "is"));
        }
    }
    Ok(sensors)
}

/// Whether the sensor `at` depends on the sensor `target`; `path` is the chain between them.
fn reaches(sensors: &[Measured], at: usize, target: usize, path: &mut Vec<usize>, seen: &mut [bool]) -> bool {
    let mut needs = Vec::new();
    each_sensor(&sensors[at].sensor.value, &mut |index| needs.push(index));
    for next in needs {
        path.push(next);
        if next == target {
            return true;
        }
        if !seen[next] {
            seen[next] = true;
            if reaches(sensors, next, target, path, seen) {
                return true;
            }
        }
        path.pop();
    }
    false
}

fn each_sensor(expression: &Expression, f: &mut dyn FnMut(usize)) {
    match expression {
        Expression::Sensor(index) => f(*index),
        Expression::Constant(_) | Expression::Channel(_) => {}
        Expression::Negative(inner) => each_sensor(inner, f),
        Expression::Binary(_, left, right) => {
            each_sensor(left, f);
            each_sensor(right, f);
        }
        Expression::Function(_, arguments) => arguments.iter().for_each(|argument| each_sensor(argument, f)),
    }
}

/// An expression over the state.
pub(super) fn expression(
    fields: &Fields<'_, '_>,
    key: &str,
    sensors: &[Option<Dimension>],
    off_is_zero: bool,
) -> Result<Option<Scalar>, AssemblyError> {
    let Some(text) = fields.text(key)? else {
        return Ok(None);
    };
    let scope = StateScope {
        resolver: fields.resolver,
        off_is_zero,
        sensors,
    };
    if let Some(block) = block_of_words(fields.resolver, text) {
        let channels = quantities(block.block.family).iter();
        return Err(fields.error(
            key,
            Fault::WordsForExpression {
                words: text.to_owned(),
                channels: channels.map(|(own, _)| format!("{}.{own}", block.name)).collect(),
            },
        ));
    }
    let node = fields.get(key).unwrap_or(fields.node);
    match fields.resolver.formula(&fields.full(key), node, text, &scope)? {
        Compiled::Scalar(scalar) => Ok(Some(scalar)),
        other => {
            let (found, expected) = (other.kind(), fields.expected(key));
            Err(fields.error(key, Fault::Kind { found, expected }))
        }
    }
}

/// Rejects a different dimension.
pub(super) fn expect(
    fields: &Fields<'_, '_>,
    key: &str,
    scalar: &Scalar,
    expected: Dimension,
) -> Result<(), AssemblyError> {
    match scalar.dimension {
        Some(found) if found != expected => Err(fields.error(
            key,
            Fault::Dimension {
                found: found.to_string(),
                expected: expected.to_string(),
                units: expected.examples(),
            },
        )),
        _ => Ok(()),
    }
}

/// Parses a condition on the state at a node.
fn condition(
    fields: &Fields<'_, '_>,
    path: &str,
    node: &Node,
    sensors: &[Option<Dimension>],
) -> Result<Condition, AssemblyError> {
    const EXPECTED: &str = "a condition, as \"piston.travel > 1 mm\", or in `becomes` the word of a block, as \"bumper \
                            closes\"";
    let wrong = |found: String| {
        let expected = EXPECTED.to_owned();
        fields.resolver.error(path, &node.spot, Fault::Kind { found, expected })
    };
    let text = node.text().ok_or_else(|| wrong(node.found()))?;
    let scope = StateScope {
        resolver: fields.resolver,
        off_is_zero: false,
        sensors,
    };
    match fields.resolver.formula(path, node, text, &scope)? {
        Compiled::Conditions(all) => Ok(Condition { all }),
        // A condition over keys only is always or never satisfied.
        Compiled::Truth(truth) => Ok(Condition {
            all: vec![Comparison {
                margin: Expression::Constant(if truth { 1.0 } else { -1.0 }),
                strict: true,
            }],
        }),
        other => Err(wrong(other.kind())),
    }
}

/// The logged word of a block, such as "guard opens" or "exhaust.seat shuts", if the text is one.
fn word(resolver: &Resolver<'_>, passages: &[Passage], text: &str) -> Option<Word> {
    let (name, action) = text.trim().split_once(char::is_whitespace)?;
    let (name, part) = name
        .split_once('.')
        .map_or((name, None), |(name, part)| (name, Some(part)));
    let block = resolver.names.find(name)?.block;
    let (_, action) = words(block.family).iter().find(|(word, _)| *word == action.trim())?;
    let restriction = match (block.family, passages.get(block.index)) {
        (Family::Passage, Some(passage)) => restriction(passage, part, *action)?,
        _ if part.is_some() => return None,
        _ => 0,
    };
    Some(Word {
        block,
        restriction,
        action: *action,
    })
}

/// The restriction of a passage that logs an action: the one named, or the only one that can. Words of the passage
/// itself do not name one.
fn restriction(passage: &Passage, part: Option<&str>, action: Action) -> Option<usize> {
    if !action.is_of_restriction() {
        let is_gate = matches!(action, Action::GateOpens | Action::GateShuts);
        return (part.is_none() && (!is_gate || passage.gate.is_some())).then_some(0);
    }
    let logs = |opens: &Opens| match action {
        Action::Opens | Action::Shuts => matches!(opens, Opens::Seat { .. }),
        _ => matches!(opens, Opens::Holes { .. }),
    };
    let mut able = passage
        .restrictions
        .iter()
        .enumerate()
        .filter(|(_, restriction)| part.is_none_or(|part| restriction.name == part) && logs(&restriction.opens));
    let (index, _) = able.next()?;
    able.next().is_none().then_some(index)
}

/// All words of the blocks that a trigger may follow, for messages.
fn all_words(resolver: &Resolver<'_>, passages: &[Passage]) -> Vec<String> {
    let is_followed = |block: &Block<'_>| block.block.family != Family::Trigger;
    words_of(resolver, passages, &is_followed)
}

/// The words of the block with which a text begins, if the text is words and not an expression.
fn words_of_named(resolver: &Resolver<'_>, passages: &[Passage], text: &str) -> Option<Vec<String>> {
    let found = block_of_words(resolver, text)?;
    Some(words_of(resolver, passages, &|block: &Block<'_>| {
        block.block == found.block
    }))
}

/// The block with which a text begins, if the text is words and not an expression.
fn block_of_words<'r, 'a>(resolver: &'r Resolver<'a>, text: &str) -> Option<&'r Block<'a>> {
    let (name, action) = text.trim().split_once(char::is_whitespace)?;
    let is_words = action.chars().all(|c| c.is_alphabetic() || c == '_' || c == ' ');
    // `and` and `or` combine conditions.
    let is_condition = action
        .split_whitespace()
        .any(|word| matches!(word, "and" | "or" | "not"));
    let name = name.split_once('.').map_or(name, |(name, _)| name);
    resolver.names.find(name).filter(|_| is_words && !is_condition)
}

/// A name that is not that of a block, followed by a word of the log.
fn word_of_unknown_block(resolver: &Resolver<'_>, text: &str) -> Option<Fault> {
    let (name, action) = text.trim().split_once(char::is_whitespace)?;
    let (name, _) = name.split_once('.').unwrap_or((name, ""));
    let action = action.trim();
    let logs = |block: &&Block<'_>| words(block.block.family).iter().any(|(word, _)| *word == action);
    let known: Vec<String> = resolver
        .names
        .blocks
        .iter()
        .filter(logs)
        .map(|block| block.name.to_string())
        .collect();
    (resolver.names.find(name).is_none() && !known.is_empty()).then(|| Fault::UnknownName {
        name: name.to_owned(),
        wanted: format!("block with the word \"{action}\""),
        known,
    })
}

/// All words of some blocks.
fn words_of(resolver: &Resolver<'_>, passages: &[Passage], is_wanted: &dyn Fn(&Block<'_>) -> bool) -> Vec<String> {
    let mut all = Vec::new();
    for block in resolver.names.blocks.iter().filter(|block| is_wanted(block)) {
        for (action, _) in words(block.block.family) {
            let mut candidates = vec![format!("{} {action}", block.name)];
            if let (Family::Passage, Some(passage)) = (block.block.family, passages.get(block.block.index)) {
                let parts = passage
                    .restrictions
                    .iter()
                    .filter(|restriction| !restriction.name.is_empty());
                candidates.extend(parts.map(|part| format!("{}.{} {action}", block.name, part.name)));
            }
            all.extend(
                candidates
                    .into_iter()
                    .filter(|text| word(resolver, passages, text).is_some()),
            );
        }
    }
    all
}

pub(super) fn triggers(resolver: &Resolver<'_>, passages: &[Passage]) -> Result<Vec<Trigger>, AssemblyError> {
    let read = |(name, fields): (&str, Fields<'_, '_>)| {
        Ok(Trigger {
            name: name.to_owned(),
            starts: fields.flag("starts", false)?,
            set: trigger_words(&fields, "set", passages)?,
            clear: trigger_words(&fields, "clear", passages)?,
            schedule: schedule(&fields)?,
        })
    };
    each(resolver, Family::Trigger, &TRIGGER)?
        .into_iter()
        .map(read)
        .collect()
}

fn trigger_words(fields: &Fields<'_, '_>, key: &str, passages: &[Passage]) -> Result<Vec<Word>, AssemblyError> {
    let items = match fields.get(key) {
        None => return Ok(Vec::new()),
        Some(node) => match &node.value {
            Tree::Array(items) => &items[..],
            _ => std::slice::from_ref(node),
        },
    };
    let read = |item: &Node| {
        let text = item.text().ok_or_else(|| fields.wrong(key, &fields.expected(key)))?;
        // Triggers that follow each other could switch endlessly.
        let word = word(fields.resolver, passages, text).filter(|word| word.block.family != Family::Trigger);
        word.ok_or_else(|| {
            let named = block_of_words(fields.resolver, text).filter(|block| block.block.family != Family::Trigger);
            let known = named.and_then(|_| words_of_named(fields.resolver, passages, text));
            let known = known.unwrap_or_else(|| all_words(fields.resolver, passages));
            let word = text.to_owned();
            fields.error(key, Fault::UnknownWord { word, known })
        })
    };
    items.iter().map(read).collect()
}

/// Times and states: pairs, or tables with `at`, `on` and `if`.
fn schedule(fields: &Fields<'_, '_>) -> Result<Vec<(f64, bool)>, AssemblyError> {
    const EXPECTED: &str = "times and states in ascending order, as [[\"5 ms\", false]]";
    let mut schedule: Vec<(f64, bool)> = Vec::new();
    for (index, item) in fields
        .array("schedule", EXPECTED)?
        .unwrap_or_default()
        .iter()
        .enumerate()
    {
        let path = format!("{}.{index}", fields.full("schedule"));
        let (time, on) = match &item.value {
            Tree::Array(pair) => match &pair[..] {
                [time, on] => (Some(time), Some(on)),
                _ => (None, None),
            },
            Tree::Table(_) => {
                if !fields.resolver.is_on(&path, item)? {
                    continue;
                }
                let step = Fields::new(fields.resolver, path.clone(), item, &STEP)?;
                (step.get("at"), step.get("on"))
            }
            _ => (None, None),
        };
        let (
            Some(time),
            Some(Node {
                value: Tree::Flag(on), ..
            }),
        ) = (time, on)
        else {
            return Err(fields.wrong("schedule", EXPECTED));
        };
        let time = fields.resolver.quantity(&path, time, nonnegative(TIME))?;
        if schedule.last().is_some_and(|(last, _)| *last >= time) {
            return Err(fields.wrong("schedule", EXPECTED));
        }
        schedule.push((time, *on));
    }
    Ok(schedule)
}

/// The event named by a field.
pub(super) fn event_index(
    fields: &Fields<'_, '_>,
    key: &str,
    resolver: &Resolver<'_>,
) -> Result<Option<usize>, AssemblyError> {
    let Some(name) = fields.text(key)? else {
        return Ok(None);
    };
    event(resolver, name)
        .map(Some)
        .ok_or_else(|| fields.error(key, no_event(resolver, name)))
}

fn event(resolver: &Resolver<'_>, name: &str) -> Option<usize> {
    resolver.names.events.iter().position(|event| *event == name)
}

fn no_event(resolver: &Resolver<'_>, name: &str) -> Fault {
    Fault::UnknownName {
        name: name.to_owned(),
        wanted: "event".to_owned(),
        known: resolver.names.events.iter().map(|event| (*event).to_owned()).collect(),
    }
}

pub(super) fn events(
    resolver: &Resolver<'_>,
    sensors: &[Measured],
    passages: &[Passage],
) -> Result<Vec<Event>, AssemblyError> {
    let dimensions = dimensions(sensors);
    let mut events = Vec::new();
    let blocks = entries(resolver, "event", &EVENT)?;
    for (name, fields) in &blocks {
        fields.one_of(&["at", "becomes", "is"], "becomes = \"piston.travel > 1 mm\"")?;
        let condition = |key: &str| {
            let Some(node) = fields.get(key) else { return Ok(None) };
            let text = node.text().unwrap_or_default();
            if let Some(known) = words_of_named(resolver, passages, text) {
                let word = text.to_owned();
                return Err(fields.error(key, Fault::WordForCondition { word, known }));
            }
            condition(fields, &fields.full(key), node, &dimensions).map(Some)
        };
        if let Some(text) = fields.get("at").and_then(Node::text)
            && let Some(known) = words_of_named(resolver, passages, text)
        {
            let word = text.to_owned();
            return Err(fields.error("at", Fault::WordForTime { word, known }));
        }
        let becomes = fields.get("becomes").and_then(Node::text);
        let logged = becomes.and_then(|text| word(resolver, passages, text));
        if let (None, Some(text)) = (logged, becomes)
            && let Some(known) = words_of_named(resolver, passages, text)
        {
            let word = text.to_owned();
            return Err(fields.error("becomes", Fault::UnknownWord { word, known }));
        }
        if let Some(fault) = becomes.and_then(|text| word_of_unknown_block(resolver, text)) {
            return Err(fields.error("becomes", fault));
        }
        let other = |key: &str| {
            let text = fields.get(key).and_then(Node::text).unwrap_or_default();
            match words_of_named(resolver, passages, text) {
                Some(known) => {
                    let word = text.to_owned();
                    Err(fields.error(key, Fault::WordForEvent { word, known }))
                }
                None => event_index(fields, key, resolver),
            }
        };
        let edge = if let Some(word) = logged {
            Edge::Logged(word)
        } else if let Some(becomes) = condition("becomes")? {
            Edge::Becomes(becomes)
        } else if let Some(is) = condition("is")? {
            Edge::Is(is)
        } else {
            Edge::At(fields.required("at")?)
        };
        events.push(Event {
            name: (*name).to_owned(),
            description: fields.text("text")?.unwrap_or_default().to_owned(),
            edge,
            after: other("after")?,
            delay: fields.or("delay", 0.0)?,
            before: other("before")?,
            until: other("until")?,
            condition: condition("where")?,
            lasting: fields.or("for", 0.0)?,
            pick: fields.word("pick", &PICKS)?.unwrap_or(Pick::First),
        });
    }
    for start in 0..blocks.len() {
        let mut path = vec![start];
        while let Some(next) = events[path[path.len() - 1]].after {
            if next == start {
                let others: Vec<_> = path[1..].iter().map(|event| &blocks[*event].1).collect();
                return Err(blocks[start].1.circle(&others, "after"));
            }
            if path.len() > events.len() {
                break;
            }
            path.push(next);
        }
    }
    Ok(events)
}

/// Outcomes in order: pairs in an array, or a table of tests by name.
pub(super) fn outcomes(
    top: &Fields<'_, '_>,
    sensors: &[Measured],
    passages: &[Passage],
) -> Result<Vec<Outcome>, AssemblyError> {
    const EXPECTED: &str = "names and tests, as [[\"drives\", \"t12\"]] or { drives = \"t12\" }";
    let wrong = || top.wrong("outcome", EXPECTED);
    let mut tests: Vec<(&str, &Node)> = Vec::new();
    match top.get("outcome").map(|node| (&node.value, node)) {
        None => {}
        Some((Tree::Array(items), _)) => {
            for item in items {
                let Tree::Array(pair) = &item.value else {
                    return Err(wrong());
                };
                let [name, test] = &pair[..] else { return Err(wrong()) };
                tests.push((name.text().ok_or_else(wrong)?, test));
            }
        }
        Some((Tree::Table(_), node)) => {
            tests.extend(node.entries().iter().map(|entry| (entry.key.as_str(), &entry.node)));
        }
        Some(_) => return Err(wrong()),
    }
    let read = |(name, test): (&str, &Node)| {
        let text = test.text().ok_or_else(wrong)?;
        let word = text.strip_prefix("no ").unwrap_or(text);
        if let Some(known) = words_of_named(top.resolver, passages, word).filter(|_| !word.contains(" before ")) {
            let word = word.to_owned();
            let fault = Fault::WordForEvent { word, known };
            return Err(top.resolver.error("cycle.outcome", &test.spot, fault));
        }
        Ok(Outcome {
            name: name.to_owned(),
            test: outcome_test(top, test, text, &dimensions(sensors))?,
        })
    };
    tests.into_iter().map(read).collect()
}

/// "E", "no E", "E before F", or a condition at the end.
fn outcome_test(
    top: &Fields<'_, '_>,
    node: &Node,
    text: &str,
    sensors: &[Option<Dimension>],
) -> Result<OutcomeTest, AssemblyError> {
    let resolver = top.resolver;
    let named = |name: &str| {
        event(resolver, name).ok_or_else(|| resolver.error("cycle.outcome", &node.spot, no_event(resolver, name)))
    };
    let words: Vec<&str> = text.split_whitespace().collect();
    match words[..] {
        ["no", name] => Ok(OutcomeTest::Missing(named(name)?)),
        [first, "before", second] => Ok(OutcomeTest::Before(named(first)?, named(second)?)),
        [name] => Ok(OutcomeTest::Happened(named(name)?)),
        _ => condition(top, "cycle.outcome", node, sensors).map(OutcomeTest::AtEnd),
    }
}
