//! Values of keys, and their types.

/// The value of a key.
#[derive(Debug, Clone, PartialEq, serde::Serialize)]
#[serde(untagged)]
pub enum Value {
    /// A quantity in SI units.
    Number(f64),
    /// A positive integer.
    Count(u32),
    /// A switch.
    Switch(bool),
    /// The chosen word.
    Choice(&'static str),
    /// A file, relative to the working directory; empty if there is none.
    File(String),
    /// A name.
    Name(Name),
}

/// A name as the value of a key, such as the name of a block of an assembly.
#[derive(Debug, Clone, Default, PartialEq, Eq, Hash, serde::Serialize, serde::Deserialize)]
#[serde(transparent)]
pub struct Name(pub String);

/// A type that a key's value may have.
pub trait Held: Sized {
    /// Converts a value to this type, if it is of the matching kind.
    fn from_value(value: &Value) -> Option<Self>;
    /// Converts to a value.
    fn to_value(&self) -> Value;
}

/// A destination for a value of any type.
pub trait Assign {
    /// Assigns a value if it is of the matching kind; returns whether it did.
    fn assign(&mut self, value: &Value) -> bool;
}

impl<T: Held> Assign for T {
    fn assign(&mut self, value: &Value) -> bool {
        let read = T::from_value(value);
        let taken = read.is_some();
        if let Some(value) = read {
            *self = value;
        }
        taken
    }
}

macro_rules! held {
    ($($ty:ty => $variant:ident),+) => {$(
        impl Held for $ty {
            fn from_value(value: &Value) -> Option<Self> {
                if let Value::$variant(value) = value { Some(value.clone()) } else { None }
            }
            fn to_value(&self) -> Value {
                Value::$variant(self.clone())
            }
        }
    )+};
}
held!(f64 => Number, u32 => Count, bool => Switch, String => File, Name => Name);

/// Declares a choice between words: documentation, then `Variant = "word"` for each.
#[macro_export]
macro_rules! choice {
    (
        $(#[doc = $doc:literal])+
        $Choice:ident { $($(#[doc = $word_doc:literal])+ $variant:ident = $word:literal,)+ }
    ) => {
        $(#[doc = $doc])+
        #[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, serde::Serialize, serde::Deserialize)]
        pub enum $Choice {
            $($(#[doc = $word_doc])+ #[serde(rename = $word)] $variant,)+
        }

        impl $Choice {
            /// All variants, in the order of their declaration.
            pub const ALL: &'static [Self] = &[$(Self::$variant),+];
            /// The words of all variants.
            pub const WORDS: &'static [&'static str] = &[$($word),+];
            /// The kind of a key of this type.
            pub const KIND: $crate::Kind = $crate::Kind::Choice(Self::WORDS);

            /// The word of this variant.
            pub fn as_str(self) -> &'static str {
                match self {
                    $(Self::$variant => $word,)+
                }
            }
        }

        impl $crate::Held for $Choice {
            fn from_value(value: &$crate::Value) -> Option<Self> {
                match value {
                    $crate::Value::Choice(word) => Self::ALL.iter().copied().find(|own| own.as_str() == *word),
                    _ => None,
                }
            }
            fn to_value(&self) -> $crate::Value {
                $crate::Value::Choice(self.as_str())
            }
        }
    };
}
