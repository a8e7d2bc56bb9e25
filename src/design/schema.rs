//! One declaration per key: its place, type, dimension, symbol, limits and description.
//!
//! [`group!`] turns a declaration into the struct the rest of the program reads, and into the [`GroupSpec`] by which
//! the design file is read, checked and documented. Nothing about a key stands anywhere else.

use std::collections::{BTreeMap, BTreeSet};
use std::sync::{Mutex, PoisonError};

use super::dimension::{Dimension, NUMBER, PRESSURE};

/// The limits that hold for a key in every design, apart from the range that a design gives it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Sign {
    /// Any finite number.
    Any,
    /// Zero or above.
    NonNegative,
    /// Above zero.
    Positive,
    /// From 0 to 1.
    Fraction,
    /// From -1 to 1.
    Component,
}

impl Sign {
    /// Whether `value` keeps the limit.
    pub fn allows(self, value: f64) -> bool {
        match self {
            Self::Any => value.is_finite(),
            Self::NonNegative => value.is_finite() && value >= 0.0,
            Self::Positive => value.is_finite() && value > 0.0,
            Self::Fraction => (0.0..=1.0).contains(&value),
            Self::Component => (-1.0..=1.0).contains(&value),
        }
    }

    /// The limit in words: "must be ...".
    pub fn describe(self) -> &'static str {
        match self {
            Self::Any => "any finite number",
            Self::NonNegative => "zero or above",
            Self::Positive => "above zero",
            Self::Fraction => "from 0 to 1",
            Self::Component => "from -1 to 1",
        }
    }
}

/// What a key holds.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Kind {
    /// A physical quantity, kept in SI units.
    Quantity {
        /// Its dimension; the unit in the file must have it.
        dimension: Dimension,
        /// Limits that hold in every design.
        sign: Sign,
        /// Whether a gauge pressure may be given, to which the ambient pressure is added.
        gauge: bool,
    },
    /// A whole number above zero.
    Count,
    /// `true` or `false`.
    Switch,
    /// One of these words.
    Choice(&'static [&'static str]),
    /// The name of a file, relative to the design file that gives it, or "" for none.
    File,
}

/// A quantity of any sign.
pub(crate) const fn any(dimension: Dimension) -> Kind {
    Kind::Quantity {
        dimension,
        sign: Sign::Any,
        gauge: false,
    }
}

/// A quantity of zero or above.
pub(crate) const fn nonnegative(dimension: Dimension) -> Kind {
    Kind::Quantity {
        dimension,
        sign: Sign::NonNegative,
        gauge: false,
    }
}

/// A quantity above zero.
pub(crate) const fn positive(dimension: Dimension) -> Kind {
    Kind::Quantity {
        dimension,
        sign: Sign::Positive,
        gauge: false,
    }
}

/// An absolute pressure above zero that may also be given as gauge pressure.
pub(crate) const fn gas_pressure() -> Kind {
    Kind::Quantity {
        dimension: PRESSURE,
        sign: Sign::Positive,
        gauge: true,
    }
}

/// A plain number from 0 to 1.
pub(crate) const fn fraction() -> Kind {
    Kind::Quantity {
        dimension: NUMBER,
        sign: Sign::Fraction,
        gauge: false,
    }
}

/// A component of a direction, from -1 to 1.
pub(crate) const fn component() -> Kind {
    Kind::Quantity {
        dimension: NUMBER,
        sign: Sign::Component,
        gauge: false,
    }
}

/// The value of a key after all design files of a chain are read.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize)]
#[serde(untagged)]
pub enum Value {
    /// A quantity in SI units.
    Number(f64),
    /// A whole number above zero.
    Count(u32),
    /// A switch.
    Switch(bool),
    /// The chosen word.
    Choice(&'static str),
    /// A file, relative to the working folder; empty for none.
    File(&'static str),
}

#[cfg(test)]
impl Value {
    /// Another value of a key of this kind, none where it has but one.
    pub(crate) fn another(self, kind: Kind) -> Option<Self> {
        Some(match (kind, self) {
            (_, Self::Number(0.0)) => Self::Number(1e-3),
            (_, Self::Number(number)) => Self::Number(number * (1.0 - 1e-6)),
            (_, Self::Count(count)) => Self::Count(count + 1),
            (_, Self::Switch(on)) => Self::Switch(!on),
            (Kind::Choice(words), Self::Choice(word)) => Self::Choice(words.iter().find(|other| **other != word)?),
            (_, Self::File(_)) => Self::File(concat!(env!("CARGO_MANIFEST_DIR"), "/README.md")),
            _ => return None,
        })
    }
}

/// A text that is kept as long as the process, once each, so that a value stays a plain copy.
pub(crate) fn kept(text: &str) -> &'static str {
    static KEPT: Mutex<BTreeSet<&'static str>> = Mutex::new(BTreeSet::new());
    let mut kept = KEPT.lock().unwrap_or_else(PoisonError::into_inner);
    if let Some(own) = kept.get(text) {
        return own;
    }
    let own: &'static str = Box::leak(text.to_owned().into_boxed_str());
    kept.insert(own);
    own
}

/// A key of the design file.
#[derive(Debug)]
pub struct KeySpec {
    /// Its name in its group.
    pub name: &'static str,
    /// Symbol in Nili Ahmadabadi (2016) or in the field; empty where there is none.
    pub symbol: &'static str,
    /// Description, one line of text an element.
    pub doc: &'static [&'static str],
    /// What it holds.
    pub kind: Kind,
}

impl KeySpec {
    /// The description on one line.
    pub fn description(&self) -> String {
        join(self.doc)
    }

    /// SI unit of the key; empty for numbers, counts, switches and choices.
    pub fn unit(&self) -> String {
        match self.kind {
            Kind::Quantity { dimension, .. } => dimension.unit(),
            _ => String::new(),
        }
    }
}

/// A group of the design file.
#[derive(Debug)]
pub struct GroupSpec {
    /// Description, one line of text an element.
    pub doc: &'static [&'static str],
    /// Its keys, in the order they are declared.
    pub keys: &'static [KeySpec],
    /// The groups within it, by name.
    pub groups: &'static [(&'static str, &'static GroupSpec)],
    /// Lists within it: groups of one declaration, as many as a design names, each under a name of its own.
    pub lists: &'static [(&'static str, &'static GroupSpec)],
}

impl GroupSpec {
    /// The description on one line.
    pub fn description(&self) -> String {
        join(self.doc)
    }

    /// The key of this name in the group itself.
    pub fn key(&self, name: &str) -> Option<&'static KeySpec> {
        self.keys.iter().find(|key| key.name == name)
    }

    /// The group of this name in the group itself.
    pub fn group(&self, name: &str) -> Option<&'static GroupSpec> {
        self.groups
            .iter()
            .find(|(own, _)| *own == name)
            .map(|(_, group)| *group)
    }

    /// The declaration of the members of the list of this name in the group itself.
    pub fn list(&self, name: &str) -> Option<&'static GroupSpec> {
        self.lists
            .iter()
            .find(|(own, _)| *own == name)
            .map(|(_, member)| *member)
    }

    /// Calls `f` with the full name and declaration of every key, groups after the keys beside them; the members of a
    /// list stand under `*`.
    pub fn each_key(&self, path: &str, f: &mut dyn FnMut(&str, &'static KeySpec)) {
        self.each_key_of(path, &|_| vec![MEMBER.to_owned()], f);
    }

    /// The same for the members that `names` tells of each list.
    pub fn each_key_of(
        &self,
        path: &str,
        names: &dyn Fn(&str) -> Vec<String>,
        f: &mut dyn FnMut(&str, &'static KeySpec),
    ) {
        for key in self.keys {
            f(&dotted(path, key.name), key);
        }
        for (name, group) in self.groups {
            group.each_key_of(&dotted(path, name), names, f);
        }
        for (list, member) in self.lists {
            let list = dotted(path, list);
            for name in names(&list) {
                member.each_key_of(&dotted(&list, &name), names, f);
            }
        }
    }
}

/// Stands for the name that a design gives a member of a list.
pub(crate) const MEMBER: &str = "NAME";

/// The values of a design by the full names of their keys.
pub(crate) type Found = BTreeMap<String, Value>;

/// The names of a list's members among keys in alphabetical order, alphabetically.
pub(crate) fn members<'a>(keys: impl Iterator<Item = &'a String>, list: &str) -> Vec<String> {
    let mut names: Vec<String> = keys
        .filter_map(|key| key.strip_prefix(list)?.strip_prefix('.')?.split('.').next())
        .map(str::to_owned)
        .collect();
    names.dedup();
    names
}

/// A type that a key of the design may have.
pub(crate) trait Held: Sized {
    /// The value as this type, if it is of this kind.
    fn from_value(value: Value) -> Option<Self>;
    /// The value as the design keeps it.
    fn to_value(&self) -> Value;
}

macro_rules! held {
    ($($ty:ty => $variant:ident),+) => {$(
        impl Held for $ty {
            fn from_value(value: Value) -> Option<Self> {
                if let Value::$variant(value) = value { Some(value) } else { None }
            }
            fn to_value(&self) -> Value {
                Value::$variant(*self)
            }
        }
    )+};
}
held!(f64 => Number, u32 => Count, bool => Switch, &'static str => File);

/// A group of the design as the rest of the program reads it.
pub(crate) trait Group: Sized {
    /// Declaration of the group.
    const SPEC: GroupSpec;
    /// The group with the values found for each key's full name; the name of the first one that lacks as error.
    fn build(path: &str, found: &Found) -> Result<Self, String>;
    /// Calls `f` with the full name, declaration and value of every key.
    fn visit(&self, path: &str, f: &mut dyn FnMut(&str, &'static KeySpec, Value));
}

/// The name of a key or group within the group `path`; the root's path is empty.
pub(crate) fn dotted(path: &str, name: &str) -> String {
    if path.is_empty() {
        name.to_owned()
    } else {
        format!("{path}.{name}")
    }
}

fn join(doc: &[&str]) -> String {
    doc.iter().map(|line| line.trim()).collect::<Vec<_>>().join(" ")
}

/// The symbol of a key for its documentation, where it has one.
macro_rules! symbol {
    ("") => {
        ""
    };
    ($symbol:tt) => {
        concat!("\nSymbol: ", $symbol, ".")
    };
}
pub(crate) use symbol;

/// Declares a group: documentation, then `name: type = kind, "symbol";` for each key, then the groups and the lists
/// within it.
macro_rules! group {
    (
        $(#[doc = $doc:literal])+
        $Group:ident {
            $($(#[doc = $key_doc:literal])+ $key:ident: $ty:ty = $kind:expr, $symbol:tt;)*
        }
        $(groups { $($sub:ident: $Sub:ident,)+ })?
        $(lists { $($list:ident: $Item:ident,)+ })?
    ) => {
        $(#[doc = $doc])+
        #[derive(Debug, Clone, PartialEq, serde::Serialize)]
        pub struct $Group {
            $($(#[doc = $key_doc])+ #[doc = $crate::design::schema::symbol!($symbol)] pub $key: $ty,)*
            $($(#[doc = concat!("See [`", stringify!($Sub), "`].")] pub $sub: $Sub,)+)?
            $($(
                #[doc = concat!("By name; see [`", stringify!($Item), "`].")]
                pub $list: std::collections::BTreeMap<String, $Item>,
            )+)?
        }

        impl $crate::design::schema::Group for $Group {
            const SPEC: $crate::design::schema::GroupSpec = $crate::design::schema::GroupSpec {
                doc: &[$($doc),+],
                keys: &[$($crate::design::schema::KeySpec {
                    name: stringify!($key),
                    symbol: $symbol,
                    doc: &[$($key_doc),+],
                    kind: $kind,
                }),*],
                groups: &[$($((stringify!($sub), &<$Sub as $crate::design::schema::Group>::SPEC)),+)?],
                lists: &[$($((stringify!($list), &<$Item as $crate::design::schema::Group>::SPEC)),+)?],
            };

            fn build(path: &str, found: &$crate::design::schema::Found) -> Result<Self, String> {
                Ok(Self {
                    $($key: {
                        let name = $crate::design::schema::dotted(path, stringify!($key));
                        found.get(&name).copied().and_then($crate::design::schema::Held::from_value).ok_or(name)?
                    },)*
                    $($($sub: $crate::design::schema::Group::build(
                        &$crate::design::schema::dotted(path, stringify!($sub)),
                        found,
                    )?,)+)?
                    $($($list: {
                        let list = $crate::design::schema::dotted(path, stringify!($list));
                        $crate::design::schema::members(found.keys(), &list)
                            .into_iter()
                            .map(|name| {
                                let path = $crate::design::schema::dotted(&list, &name);
                                Ok((name, $crate::design::schema::Group::build(&path, found)?))
                            })
                            .collect::<Result<_, String>>()?
                    },)+)?
                })
            }

            fn visit(
                &self,
                path: &str,
                f: &mut dyn FnMut(&str, &'static $crate::design::schema::KeySpec, $crate::design::schema::Value),
            ) {
                $(if let Some(spec) = <Self as $crate::design::schema::Group>::SPEC.key(stringify!($key)) {
                    let name = $crate::design::schema::dotted(path, stringify!($key));
                    f(&name, spec, $crate::design::schema::Held::to_value(&self.$key));
                })*
                $($($crate::design::schema::Group::visit(
                    &self.$sub,
                    &$crate::design::schema::dotted(path, stringify!($sub)),
                    f,
                );)+)?
                $($(for (name, member) in &self.$list {
                    let list = $crate::design::schema::dotted(path, stringify!($list));
                    $crate::design::schema::Group::visit(member, &$crate::design::schema::dotted(&list, name), f);
                })+)?
            }
        }
    };
}
pub(crate) use group;

/// Declares a choice between words: documentation, then `Variant = "word"` for each.
macro_rules! choice {
    (
        $(#[doc = $doc:literal])+
        $Choice:ident { $($(#[doc = $word_doc:literal])+ $variant:ident = $word:literal,)+ }
    ) => {
        $(#[doc = $doc])+
        #[derive(Debug, Clone, Copy, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
        pub enum $Choice {
            $($(#[doc = $word_doc])+ #[serde(rename = $word)] $variant,)+
        }

        impl $Choice {
            pub(crate) const KIND: $crate::design::schema::Kind =
                $crate::design::schema::Kind::Choice(&[$($word),+]);

            /// The word in the design file.
            pub fn as_str(self) -> &'static str {
                match self {
                    $(Self::$variant => $word,)+
                }
            }
        }

        impl $crate::design::schema::Held for $Choice {
            fn from_value(value: $crate::design::schema::Value) -> Option<Self> {
                match value {
                    $($crate::design::schema::Value::Choice($word) => Some(Self::$variant),)+
                    _ => None,
                }
            }
            fn to_value(&self) -> $crate::design::schema::Value {
                $crate::design::schema::Value::Choice(self.as_str())
            }
        }
    };
}
pub(crate) use choice;
