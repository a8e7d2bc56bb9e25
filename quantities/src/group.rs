//! Groups of quantities, with one declaration per key.
//!
//! [`group!`](crate::group!) turns a declaration into the struct that a program uses and into the [`GroupSpec`] with
//! which a file is read, checked and documented. This is the only place where a key is declared.

use std::collections::BTreeMap;

use crate::spec::{GroupSpec, KeySpec, dotted};
use crate::value::{Assign, Held, Value};

/// Values by the full name of their key.
pub type Found = BTreeMap<String, Value>;

/// Names of the members of the list `list`, extracted from full key names in alphabetical order.
pub fn members<'a>(keys: impl Iterator<Item = &'a String>, list: &str) -> Vec<String> {
    let mut names: Vec<String> = keys
        .filter_map(|key| key.strip_prefix(list)?.strip_prefix('.')?.split('.').next())
        .map(str::to_owned)
        .collect();
    names.dedup();
    names
}

/// A group of quantities as a program reads it.
pub trait Group: Sized {
    /// Declaration of the group.
    const SPEC: GroupSpec;
    /// Builds the group at `path` from the values found for its keys.
    ///
    /// # Errors
    /// The full name of the first key whose value is missing or of the wrong kind.
    fn build(path: &str, found: &Found) -> Result<Self, String>;
    /// Calls `f` with the full name, declaration and value of every key.
    fn visit(&self, path: &str, f: &mut dyn FnMut(&str, &'static KeySpec, Value));
    /// The declaration and a mutable reference to the value of the key `name` in this group (`friction.static_force`),
    /// if it exists. This takes a few string comparisons, whereas [`visit`](Self::visit) iterates over all keys.
    fn key_mut(&mut self, name: &str) -> Option<(&'static KeySpec, &mut dyn Assign)>;
}

/// The value of the key `name` of the group at `path`.
///
/// # Errors
/// The full name of the key if its value is missing or of the wrong kind.
pub fn read_key<T: Held>(path: &str, name: &str, found: &Found) -> Result<T, String> {
    let name = dotted(path, name);
    found.get(&name).and_then(T::from_value).ok_or(name)
}

/// Calls `f` for the key `name` of the group `G` at `path`.
#[doc(hidden)]
pub fn visit_key<G: Group, T: Held>(
    path: &str,
    name: &str,
    value: &T,
    f: &mut dyn FnMut(&str, &'static KeySpec, Value),
) {
    if let Some(spec) = G::SPEC.key(name) {
        f(&dotted(path, name), spec, value.to_value());
    }
}

/// The documentation of a key, with its symbol if it has one.
#[doc(hidden)]
#[macro_export]
macro_rules! key_doc {
    ($kind:expr, "") => {
        concat!("\nDeclared as `", stringify!($kind), "`.")
    };
    ($kind:expr, $symbol:tt) => {
        concat!("\nDeclared as `", stringify!($kind), "`, symbol ", $symbol, ".")
    };
}

/// Declares a group: documentation, then `name: type = kind, "symbol";` for each key, then the groups and the lists
/// within it.
///
/// The line `..part: Inner;` among the keys inserts the keys of the group `Inner` at that position. The struct contains
/// the inner group as the field `part` and dereferences to it, so that the keys of both are accessed alike.
///
/// The struct derives the `serde` traits, so the declaring crate must depend on `serde`.
#[macro_export]
macro_rules! group {
    (
        $(#[doc = $doc:literal])+
        $Group:ident {
            $($(#[doc = $key_doc:literal])+ $key:ident: $ty:ty = $kind:expr, $symbol:tt;)*
            $(
                ..$part:ident: $Part:ty;
                $($(#[doc = $late_doc:literal])+ $late:ident: $late_ty:ty = $late_kind:expr, $late_symbol:tt;)*
            )?
        }
        $(groups { $($sub:ident: $Sub:ident,)+ })?
        $(lists { $($list:ident: $Item:ident,)+ })?
    ) => {
        $(#[doc = $doc])+
        #[derive(Debug, Clone, PartialEq, serde::Serialize, serde::Deserialize)]
        #[serde(deny_unknown_fields)]
        pub struct $Group {
            $($(#[doc = $key_doc])+ #[doc = $crate::key_doc!($kind, $symbol)] pub $key: $ty,)*
            $(
                #[doc = concat!("Keys of [`", stringify!($Part), "`].")] pub $part: $Part,
                $($(#[doc = $late_doc])+ #[doc = $crate::key_doc!($late_kind, $late_symbol)] pub $late: $late_ty,)*
            )?
            $($(#[doc = concat!("See [`", stringify!($Sub), "`].")] pub $sub: $Sub,)+)?
            $($(
                #[doc = concat!("By name; see [`", stringify!($Item), "`].")]
                pub $list: std::collections::BTreeMap<String, $Item>,
            )+)?
        }

        $(
            impl std::ops::Deref for $Group {
                type Target = $Part;

                fn deref(&self) -> &$Part {
                    &self.$part
                }
            }

            impl std::ops::DerefMut for $Group {
                fn deref_mut(&mut self) -> &mut $Part {
                    &mut self.$part
                }
            }
        )?

        impl $crate::Group for $Group {
            const SPEC: $crate::GroupSpec = $crate::GroupSpec {
                doc: &[$($doc),+],
                keys: &[
                    &[$($crate::KeySpec {
                        name: stringify!($key),
                        symbol: $symbol,
                        doc: &[$($key_doc),+],
                        kind: $kind,
                    }),*],
                    $(
                        {
                            const COUNT: usize = <$Part as $crate::Group>::SPEC.key_count();
                            const KEYS: [$crate::KeySpec; COUNT] = <$Part as $crate::Group>::SPEC.joined_keys();
                            &KEYS
                        },
                        &[$($crate::KeySpec {
                            name: stringify!($late),
                            symbol: $late_symbol,
                            doc: &[$($late_doc),+],
                            kind: $late_kind,
                        }),*],
                    )?
                ],
                groups: &[$($((stringify!($sub), &<$Sub as $crate::Group>::SPEC)),+)?],
                lists: &[$($((stringify!($list), &<$Item as $crate::Group>::SPEC)),+)?],
                is_list: false,
            };

            fn build(path: &str, found: &$crate::Found) -> Result<Self, String> {
                Ok(Self {
                    $($key: $crate::read_key(path, stringify!($key), found)?,)*
                    $(
                        $part: $crate::Group::build(path, found)?,
                        $($late: $crate::read_key(path, stringify!($late), found)?,)*
                    )?
                    $($($sub: $crate::Group::build(
                        &$crate::dotted(path, stringify!($sub)),
                        found,
                    )?,)+)?
                    $($($list: {
                        let list = $crate::dotted(path, stringify!($list));
                        $crate::members(found.keys(), &list)
                            .into_iter()
                            .map(|name| {
                                let path = $crate::dotted(&list, &name);
                                Ok((name, $crate::Group::build(&path, found)?))
                            })
                            .collect::<Result<_, String>>()?
                    },)+)?
                })
            }

            fn visit(
                &self,
                path: &str,
                f: &mut dyn FnMut(&str, &'static $crate::KeySpec, $crate::Value),
            ) {
                $($crate::visit_key::<Self, _>(path, stringify!($key), &self.$key, f);)*
                $(
                    $crate::Group::visit(&self.$part, path, f);
                    $($crate::visit_key::<Self, _>(path, stringify!($late), &self.$late, f);)*
                )?
                $($($crate::Group::visit(
                    &self.$sub,
                    &$crate::dotted(path, stringify!($sub)),
                    f,
                );)+)?
                $($(for (name, member) in &self.$list {
                    let list = $crate::dotted(path, stringify!($list));
                    $crate::Group::visit(member, &$crate::dotted(&list, name), f);
                })+)?
            }

            fn key_mut(&mut self, name: &str) -> Option<(&'static $crate::KeySpec, &mut dyn $crate::Assign)> {
                let Some((_head, _rest)) = name.split_once('.') else {
                    let _of_part: Option<(&'static $crate::KeySpec, &mut dyn $crate::Assign)> = None;
                    $(if name == stringify!($key) {
                        return Some((Self::SPEC.key(name)?, &mut self.$key));
                    })*
                    $(
                        $(if name == stringify!($late) {
                            return Some((Self::SPEC.key(name)?, &mut self.$late));
                        })*
                        let _of_part = $crate::Group::key_mut(&mut self.$part, name);
                    )?
                    return _of_part;
                };
                $($(if _head == stringify!($sub) {
                    return $crate::Group::key_mut(&mut self.$sub, _rest);
                })+)?
                $($(if _head == stringify!($list) {
                    let (member, key) = _rest.split_once('.')?;
                    return $crate::Group::key_mut(self.$list.get_mut(member)?, key);
                })+)?
                None
            }
        }
    };
}
