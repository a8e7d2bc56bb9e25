//! Tables of fields: the contents of each block. Its reader takes names, domains and examples from them. The JSON
//! schema of an assembly is also made from them.

use nailnoise_quantities::Kind;

/// The fields of a block, or of a table within it.
#[derive(Debug)]
pub struct TableSpec {
    /// Name of the object that the table describes, as in "a field of a volume".
    pub name: &'static str,
    /// The fields with given names.
    pub fields: &'static [FieldSpec],
    /// Type of the entries whose names the assembly chooses; `None` if all names are given.
    pub others: Option<&'static FieldType>,
}

/// A field.
#[derive(Debug)]
pub struct FieldSpec {
    /// Name.
    pub name: &'static str,
    /// Type of its value.
    pub of: FieldType,
    /// Example of its value, as in a file; empty if the type is clear enough.
    pub example: &'static str,
    /// Description.
    pub text: &'static str,
}

/// Type of a value.
#[derive(Debug)]
pub enum FieldType {
    /// A quantity of this dimension and domain: a literal, or a formula over keys.
    Quantity(Kind),
    /// A plain number that is not a key.
    Number,
    /// A quantity of any dimension, a formula or a switch; or a group of these, which is layout only.
    Value,
    /// True, false, or a condition over keys.
    Flag,
    /// The name of another block, of this kind.
    Name(&'static str),
    /// One of some words.
    Words(&'static [&'static str]),
    /// A text, described in words: an expression over channels, a condition, a group of keys.
    Text(&'static str),
    /// A table.
    Table(&'static TableSpec),
    /// Tables by names that the assembly chooses.
    Blocks(&'static TableSpec),
    /// Values of the same type.
    List(&'static FieldType),
    /// Two values.
    Pair(&'static [FieldType; 2]),
    /// One of several types.
    Either(&'static [FieldType]),
}

impl TableSpec {
    /// A table whose fields all have given names.
    pub(super) const fn of(name: &'static str, fields: &'static [FieldSpec]) -> Self {
        Self {
            name,
            fields,
            others: None,
        }
    }

    /// A table whose entries the assembly names.
    pub(super) const fn open(name: &'static str, others: &'static FieldType) -> Self {
        Self {
            name,
            fields: &[],
            others: Some(others),
        }
    }

    /// A field by its name.
    pub fn field(&self, name: &str) -> Option<&'static FieldSpec> {
        self.fields.iter().find(|field| field.name == name)
    }

    /// Names of the fields.
    pub fn names(&self) -> impl Iterator<Item = &'static str> + use<> {
        self.fields.iter().map(|field| field.name)
    }
}

impl FieldSpec {
    const fn new(name: &'static str, of: FieldType, text: &'static str) -> Self {
        Self {
            name,
            of,
            example: "",
            text,
        }
    }

    /// The same with an example.
    pub(super) const fn such_as(self, example: &'static str) -> Self {
        Self { example, ..self }
    }
}

/// A quantity, with an example.
pub(super) const fn quantity(name: &'static str, kind: Kind, example: &'static str, text: &'static str) -> FieldSpec {
    FieldSpec::new(name, FieldType::Quantity(kind), text).such_as(example)
}

/// A switch.
pub(super) const fn flag(name: &'static str, text: &'static str) -> FieldSpec {
    FieldSpec::new(name, FieldType::Flag, text)
}

/// The name of a block of some kind.
pub(super) const fn name_of(name: &'static str, kind: &'static str, text: &'static str) -> FieldSpec {
    FieldSpec::new(name, FieldType::Name(kind), text)
}

/// A text that messages describe by `expected`.
pub(super) const fn text(name: &'static str, expected: &'static str, text: &'static str) -> FieldSpec {
    FieldSpec::new(name, FieldType::Text(expected), text)
}

/// One of some words.
pub(super) const fn one_of(name: &'static str, words: &'static [&'static str], text: &'static str) -> FieldSpec {
    FieldSpec::new(name, FieldType::Words(words), text)
}

/// A table.
pub(super) const fn table(name: &'static str, spec: &'static TableSpec, text: &'static str) -> FieldSpec {
    FieldSpec::new(name, FieldType::Table(spec), text)
}

/// Blocks of a family.
pub(super) const fn blocks(name: &'static str, spec: &'static TableSpec, text: &'static str) -> FieldSpec {
    FieldSpec::new(name, FieldType::Blocks(spec), text)
}

/// A field of another type.
pub(super) const fn field(name: &'static str, of: FieldType, text: &'static str) -> FieldSpec {
    FieldSpec::new(name, of, text)
}

/// The words of pairs of words and meanings.
pub(super) const fn words<T, const COUNT: usize>(pairs: &[(&'static str, T); COUNT]) -> [&'static str; COUNT] {
    let mut words = [""; COUNT];
    let mut index = 0;
    while index < COUNT {
        words[index] = pairs[index].0;
        index += 1;
    }
    words
}

impl FieldType {
    /// The quantity that a value of this type may be.
    pub fn quantity(&self) -> Option<Kind> {
        self.find(&|of| match of {
            Self::Quantity(kind) => Some(*kind),
            _ => None,
        })
    }

    /// The table that a value of this type may be.
    pub fn table(&self) -> Option<&'static TableSpec> {
        self.find(&|of| match of {
            Self::Table(table) => Some(*table),
            _ => None,
        })
    }

    /// Description of a text that a value of this type may be, as in "expected the name of a body".
    pub(super) fn expected(&self) -> Option<String> {
        self.find(&|of| match of {
            Self::Text(expected) => Some((*expected).to_owned()),
            Self::Name(kind) => Some(format!("the name of a {kind}")),
            Self::Words(words) => Some(words.join(" or ")),
            _ => None,
        })
    }

    fn find<T>(&self, get: &dyn Fn(&Self) -> Option<T>) -> Option<T> {
        match self {
            Self::Either(types) => types.iter().find_map(|of| of.find(get)),
            of => get(of),
        }
    }
}
