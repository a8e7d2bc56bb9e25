//! Typed access to the fields of a block.

use nailnoise_quantities::{Held, Kind, Value};

use super::changes::Part;
use super::compile::{Compiled, Word};
use super::fault::{AssemblyError, Changes, Fault, with_article};
use super::layers::dotted;
use super::node::{Node, Spot, Tree};
use super::resolver::{KeyScope, Resolver};
use super::table::{FieldSpec, FieldType, TableSpec};
use crate::network::assembly::{Base, BlockRef, Family, Push, Space};

/// Directions of a push.
pub(super) const PUSHES: [(&str, Push); 2] = [("down", Push::Down), ("up", Push::Up)];

/// The fields of a block or of a table within it.
pub(super) struct Fields<'r, 'a> {
    pub(super) resolver: &'r Resolver<'a>,
    /// Full name.
    pub(super) path: String,
    pub(super) node: &'a Node,
    table: &'static TableSpec,
}

impl<'r, 'a> Fields<'r, 'a> {
    /// Creates access to the fields of a table. All fields must be known.
    pub(super) fn new(
        resolver: &'r Resolver<'a>,
        path: String,
        node: &'a Node,
        table: &'static TableSpec,
    ) -> Result<Self, AssemblyError> {
        let owner = table.name;
        if !node.is_table() {
            let words: Vec<&str> = path.split('.').collect();
            let fault = match (words.as_slice(), &node.value) {
                ([_, table, name], Tree::Flag(false)) => Fault::UnknownName {
                    name: (*name).to_owned(),
                    wanted: format!("{owner} that `false` could remove"),
                    known: resolver.names.others_of(table, name),
                },
                _ => Fault::Kind {
                    found: node.found(),
                    expected: format!("the fields of {}", with_article(owner)),
                },
            };
            return Err(resolver.error(&path, &node.spot, fault));
        }
        let fields = Self {
            resolver,
            path,
            node,
            table,
        };
        for entry in node.entries() {
            if entry.key != "if" && table.others.is_none() && table.field(&entry.key).is_none() {
                let fault = Fault::UnknownField {
                    owner: owner.to_owned(),
                    name: entry.key.clone(),
                    known: table.names().map(str::to_owned).collect(),
                };
                return Err(resolver.error(&fields.full(&entry.key), &entry.spot, fault));
            }
            let twice = node.entries().iter().filter(|other| other.key == entry.key).count() > 1;
            if twice {
                let fields_found = vec![entry.key.clone(), entry.key.clone()];
                let fault = Fault::Exclusive { fields: fields_found };
                return Err(resolver.error(&fields.full(&entry.key), &entry.spot, fault));
            }
        }
        Ok(fields)
    }

    /// Full name of a field.
    pub(super) fn full(&self, key: &str) -> String {
        dotted(&self.path, key)
    }

    /// Location of a field, or of the table that does not contain it.
    fn spot(&self, key: &str) -> &'a Spot {
        &self.node.get(key).unwrap_or(self.node).spot
    }

    /// The error of a field. If a nearer file removes or changes the block that it names, the error states that change.
    pub(super) fn error(&self, key: &str, fault: Fault) -> AssemblyError {
        let text = self.resolver.text;
        let removal = |name: &str| text.removal(name).map(|removal| Changes(vec![removal]));
        let changes = match &fault {
            Fault::UnknownName { name, .. } => {
                removal(name).unwrap_or_else(|| text.changes(self.spot(key), &Part::of_any_block(name)))
            }
            Fault::UnknownWord { word, .. } => removal(word).unwrap_or_default(),
            _ => Changes::default(),
        };
        AssemblyError {
            changes: Box::new(changes),
            ..self.resolver.error(&self.full(key), self.spot(key), fault)
        }
    }

    /// An error of this block and `others`, which refer to each other in a circle by the field `key`. It is placed in
    /// the file nearest to the design, which closes the circle.
    pub(super) fn circle(&self, others: &[&Self], key: &str) -> AssemblyError {
        let rank = |block: &Self| self.resolver.text.sources.rank(block.spot(key));
        let nearer = |best, block| if rank(block) > rank(best) { block } else { best };
        let nearest = others.iter().copied().fold(self, nearer);
        let name = |block: &Self| block.path.rsplit('.').next().unwrap_or_default().to_owned();
        let circle = std::iter::once(self).chain(others.iter().copied());
        let names = circle.chain(std::iter::once(self)).map(name).collect();
        nearest.error(key, Fault::Circle { names })
    }

    /// An error of the block.
    pub(super) fn own_error(&self, fault: Fault) -> AssemblyError {
        self.resolver.error(&self.path, &self.node.spot, fault)
    }

    /// The declaration of a field.
    fn spec(&self, key: &str) -> Result<&'static FieldSpec, AssemblyError> {
        self.table.field(key).ok_or_else(|| {
            self.error(
                key,
                Fault::UnknownField {
                    owner: self.table.name.to_owned(),
                    name: key.to_owned(),
                    known: self.table.names().map(str::to_owned).collect(),
                },
            )
        })
    }

    /// Dimension and domain of a field.
    fn kind(&self, key: &str) -> Result<Kind, AssemblyError> {
        self.spec(key)?
            .of
            .quantity()
            .ok_or_else(|| self.wrong(key, "no quantity"))
    }

    /// Description of a text, as in "expected the name of a body".
    pub(super) fn expected(&self, key: &str) -> String {
        let of = self.table.field(key).map(|field| &field.of).or(self.table.others);
        of.and_then(FieldType::expected).unwrap_or_else(|| "a text".to_owned())
    }

    /// The error of an absent field.
    pub(super) fn missing(&self, key: &str) -> AssemblyError {
        let field = self.table.field(key);
        let example = match field.map(|field| (field.example, &field.of)) {
            Some(("", FieldType::Name(kind))) => format!("\"name of a {kind}\""),
            Some((_, FieldType::Words(words))) => {
                let quoted: Vec<String> = words.iter().map(|word| format!("\"{word}\"")).collect();
                quoted.join(" or ")
            }
            Some((example, _)) => example.to_owned(),
            None => String::new(),
        };
        self.own_error(Fault::Missing {
            field: key.to_owned(),
            example: format!("{key} = {example}"),
        })
    }

    /// The error for a field of the wrong kind.
    pub(super) fn wrong(&self, key: &str, expected: &str) -> AssemblyError {
        let found = self.node.get(key).map_or_else(String::new, Node::found);
        let expected = expected.to_owned();
        self.error(key, Fault::Kind { found, expected })
    }

    pub(super) fn get(&self, key: &str) -> Option<&'a Node> {
        self.node.get(key)
    }

    /// A number in SI.
    pub(super) fn quantity(&self, key: &str) -> Result<Option<f64>, AssemblyError> {
        self.quantity_of(key, self.kind(key)?)
    }

    /// A number in SI of another kind than that of the field.
    pub(super) fn quantity_of(&self, key: &str, kind: Kind) -> Result<Option<f64>, AssemblyError> {
        let read = |node| self.resolver.quantity(&self.full(key), node, kind);
        self.get(key).map(read).transpose()
    }

    /// A number that must be given.
    pub(super) fn required(&self, key: &str) -> Result<f64, AssemblyError> {
        self.quantity(key)?.ok_or_else(|| self.missing(key))
    }

    /// A number with a default in SI.
    pub(super) fn or(&self, key: &str, default: f64) -> Result<f64, AssemblyError> {
        Ok(self.quantity(key)?.unwrap_or(default))
    }

    /// The value of a key that a field names without a formula.
    pub(super) fn key(&self, key: &str, name: &str, kind: Kind) -> Result<f64, AssemblyError> {
        let formula = Node {
            value: Tree::Text(format!("={name}")),
            spot: self.spot(key).clone(),
        };
        self.resolver.quantity(&self.full(key), &formula, kind)
    }

    /// A switch, or a condition over keys.
    pub(super) fn flag(&self, key: &str, default: bool) -> Result<bool, AssemblyError> {
        const EXPECTED: &str = "true, false or a condition over keys";
        let Some(node) = self.get(key) else { return Ok(default) };
        match (&node.value, node.text().and_then(|text| text.strip_prefix('='))) {
            (Tree::Flag(on), _) => Ok(*on),
            (_, Some(text)) => {
                match self
                    .resolver
                    .formula(&self.full(key), node, text, &KeyScope(self.resolver))?
                {
                    Compiled::Truth(on) => Ok(on),
                    _ => Err(self.wrong(key, EXPECTED)),
                }
            }
            _ => Err(self.wrong(key, EXPECTED)),
        }
    }

    /// A text.
    pub(super) fn text(&self, key: &str) -> Result<Option<&'a str>, AssemblyError> {
        let Some(node) = self.get(key) else { return Ok(None) };
        node.text()
            .map(Some)
            .ok_or_else(|| self.wrong(key, &self.expected(key)))
    }

    /// One of some words, or a formula over keys that gives one.
    pub(super) fn word<T: Copy>(&self, key: &str, words: &[(&str, T)]) -> Result<Option<T>, AssemblyError> {
        let find = |text: &str| words.iter().find(|(word, _)| *word == text).map(|(_, value)| *value);
        self.chosen(key, words.iter().map(|(word, _)| *word), find)
    }

    /// One of the words of a key of some kind, or a formula over keys that gives one.
    pub(super) fn choice<T: Held>(
        &self,
        key: &str,
        words: &'static [&'static str],
    ) -> Result<Option<T>, AssemblyError> {
        let find = |text: &str| {
            let word = words.iter().find(|word| **word == text)?;
            T::from_value(&Value::Choice(word))
        };
        self.chosen(key, words.iter().copied(), find)
    }

    /// The meaning of a word: of a text, or of the value of a formula over keys. The other branches of the formula must
    /// be words of the field too.
    fn chosen<'w, T>(
        &self,
        key: &str,
        words: impl Iterator<Item = &'w str>,
        find: impl Fn(&str) -> Option<T>,
    ) -> Result<Option<T>, AssemblyError> {
        let (Some(text), Some(node)) = (self.text(key)?, self.get(key)) else {
            return Ok(None);
        };
        let word = match text.strip_prefix('=') {
            None => Word::new(text),
            Some(formula) => match self
                .resolver
                .formula(&self.full(key), node, formula, &KeyScope(self.resolver))?
            {
                Compiled::Word(word) => word,
                other => {
                    let (found, expected) = (other.kind(), self.expected(key));
                    return Err(self.error(key, Fault::Kind { found, expected }));
                }
            },
        };
        let every = std::iter::once(&word.text).chain(&word.unselected);
        if let Some(found) = every.into_iter().find(|word| find(word).is_none()) {
            let (found, words) = (found.clone(), words.map(str::to_owned).collect());
            return Err(self.error(key, Fault::Word { found, words }));
        }
        Ok(find(&word.text))
    }

    /// "down" or "up".
    pub(super) fn push(&self, key: &str) -> Result<Push, AssemblyError> {
        self.word(key, &PUSHES)?.ok_or_else(|| self.missing(key))
    }

    /// A table within.
    pub(super) fn table(&self, key: &str) -> Result<Option<Self>, AssemblyError> {
        let Some(node) = self.get(key) else { return Ok(None) };
        let of = self.table.field(key).map(|field| &field.of).or(self.table.others);
        let table = of.and_then(FieldType::table);
        let table = table.ok_or_else(|| self.wrong(key, &self.expected(key)))?;
        Fields::new(self.resolver, self.full(key), node, table).map(Some)
    }

    /// The block of one of some families that a text names.
    pub(super) fn block_of(
        &self,
        key: &str,
        name: &str,
        families: &[Family],
        wanted: &str,
    ) -> Result<BlockRef, AssemblyError> {
        let names = &self.resolver.names;
        if let Some(found) = names.find(name).filter(|found| families.contains(&found.block.family)) {
            return Ok(found.block);
        }
        let name = name.to_owned();
        let fault = if names.off.contains(&name.as_str()) {
            Fault::SwitchedOff { name }
        } else {
            let mut known = names.of(families);
            if families.contains(&Family::Body) && wanted.contains("ground") {
                known.push("ground".to_owned());
            }
            let wanted = wanted.to_owned();
            Fault::UnknownName { name, wanted, known }
        };
        Err(self.error(key, fault))
    }

    /// The block that a field names.
    pub(super) fn block(
        &self,
        key: &str,
        families: &[Family],
        wanted: &str,
    ) -> Result<Option<BlockRef>, AssemblyError> {
        let Some(name) = self.text(key)? else { return Ok(None) };
        self.block_of(key, name, families, wanted).map(Some)
    }

    /// The index of a block that must be named.
    pub(super) fn index(&self, key: &str, family: Family, wanted: &str) -> Result<usize, AssemblyError> {
        let block = self.block(key, &[family], wanted)?;
        block.map(|block| block.index).ok_or_else(|| self.missing(key))
    }

    /// A body or the ground.
    pub(super) fn base(&self, key: &str) -> Result<Option<Base>, AssemblyError> {
        const WANTED: &str = "body, and not ground";
        let Some(name) = self.text(key)? else { return Ok(None) };
        if name == "ground" {
            return Ok(Some(Base::Ground));
        }
        let body = self.block_of(key, name, &[Family::Body], WANTED)?;
        Ok(Some(Base::Body(body.index)))
    }

    /// The body that carries the reaction; by default the reference body of the travel of `on`.
    pub(super) fn against(&self, on: usize, parents: &[Base]) -> Result<Base, AssemblyError> {
        let against = self
            .base("against")?
            .unwrap_or_else(|| parents.get(on).copied().unwrap_or(Base::Ground));
        if against == Base::Body(on) {
            let space = self.text("against")?.unwrap_or_default().to_owned();
            return Err(self.error("against", Fault::SelfLoop { space }));
        }
        Ok(against)
    }

    /// A volume or reservoir by name.
    pub(super) fn space(&self, key: &str, name: &str) -> Result<Space, AssemblyError> {
        let block = self.block_of(key, name, &[Family::Volume, Family::Reservoir], "volume or reservoir")?;
        Ok(if block.family == Family::Volume {
            Space::Volume(block.index)
        } else {
            Space::Reservoir(block.index)
        })
    }

    /// The items of an array.
    pub(super) fn array(&self, key: &str, expected: &str) -> Result<Option<&'a [Node]>, AssemblyError> {
        match self.get(key).map(|node| &node.value) {
            None => Ok(None),
            Some(Tree::Array(items)) => Ok(Some(items)),
            Some(_) => Err(self.wrong(key, expected)),
        }
    }

    /// Numbers in SI.
    pub(super) fn numbers(&self, key: &str, expected: &str) -> Result<Option<Vec<f64>>, AssemblyError> {
        let Some(items) = self.array(key, expected)? else {
            return Ok(None);
        };
        let number = |item: &Node| match item.value {
            Tree::Number(number) if number.is_finite() => Ok(number),
            _ => Err(self.wrong(key, expected)),
        };
        if items.is_empty() {
            return Err(self.wrong(key, expected));
        }
        items.iter().map(number).collect::<Result<_, _>>().map(Some)
    }

    /// Pairs of quantities, in ascending order of the first.
    pub(super) fn points(&self, key: &str) -> Result<Option<Vec<[f64; 2]>>, AssemblyError> {
        let spec = self.spec(key)?;
        let example = spec.example;
        let kinds = match &spec.of {
            FieldType::List(FieldType::Pair([first, second])) => first.quantity().zip(second.quantity()),
            _ => None,
        };
        let kinds: [Kind; 2] = kinds.ok_or_else(|| self.wrong(key, example))?.into();
        let Some(items) = self.array(key, example)? else {
            return Ok(None);
        };
        let mut points: Vec<[f64; 2]> = Vec::with_capacity(items.len());
        for (index, item) in items.iter().enumerate() {
            let Tree::Array(pair) = &item.value else {
                return Err(self.wrong(key, example));
            };
            let [first, second] = &pair[..] else {
                return Err(self.wrong(key, example));
            };
            let read = |side: usize, node: &'a Node| {
                self.resolver
                    .quantity(&format!("{}.{index}.{side}", self.full(key)), node, kinds[side])
            };
            points.push([read(0, first)?, read(1, second)?]);
        }
        if points.len() < 2 || points.windows(2).any(|pair| pair[0][0] >= pair[1][0]) {
            return Err(self.wrong(key, &format!("at least two points in ascending order, as {example}")));
        }
        Ok(Some(points))
    }

    /// Requires exactly one of some fields.
    pub(super) fn one_of(&self, keys: &[&str], example: &str) -> Result<(), AssemblyError> {
        let fields: Vec<String> = keys
            .iter()
            .filter(|key| self.get(key).is_some())
            .map(|key| (*key).to_owned())
            .collect();
        match fields.len() {
            1 => Ok(()),
            0 => Err(self.own_error(Fault::Missing {
                field: keys.join("` or `"),
                example: example.to_owned(),
            })),
            _ => {
                // The field that the file closest to the design gives.
                let given = fields.iter().filter_map(|key| self.get(key));
                let last = given.max_by_key(|node| self.resolver.text.sources.rank(&node.spot));
                let spot = last.map_or(&self.node.spot, |node| &node.spot);
                Err(self.resolver.error(&self.path, spot, Fault::Exclusive { fields }))
            }
        }
    }
}
