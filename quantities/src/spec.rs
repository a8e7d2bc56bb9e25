//! Declarations of keys and groups, as data.

use crate::kind::Kind;

/// A key of the design file.
#[derive(Debug, Clone, Copy)]
pub struct KeySpec {
    /// Its name in its group.
    pub name: &'static str,
    /// Symbol in Nili Ahmadabadi (2016) or in the field; empty if there is none.
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
    /// The keys in the group itself, in their order: its own, or its own before the part, those of the part, and its
    /// own after it.
    pub keys: &'static [&'static [KeySpec]],
    /// The groups within it, by name.
    pub groups: &'static [(&'static str, &'static GroupSpec)],
    /// Lists within it: groups of one declaration; a design gives any number of them, each with a name.
    pub lists: &'static [(&'static str, &'static GroupSpec)],
    /// Whether a file may give the keys as a list of values, in their order.
    pub is_list: bool,
}

impl GroupSpec {
    /// The description on one line.
    pub fn description(&self) -> String {
        join(self.doc)
    }

    /// The keys in the group itself, in their order.
    pub fn keys(&self) -> impl Iterator<Item = &'static KeySpec> + use<> {
        self.keys.iter().copied().flatten()
    }

    /// Number of the keys in the group itself.
    #[doc(hidden)]
    pub const fn key_count(&self) -> usize {
        let (mut count, mut slice) = (0, 0);
        while slice < self.keys.len() {
            count += self.keys[slice].len();
            slice += 1;
        }
        count
    }

    /// The keys in the group itself as one array of [`key_count`](Self::key_count) keys.
    #[doc(hidden)]
    pub const fn joined_keys<const COUNT: usize>(&self) -> [KeySpec; COUNT] {
        const BLANK: KeySpec = KeySpec {
            name: "",
            symbol: "",
            doc: &[],
            kind: Kind::Switch,
        };
        let mut all = [BLANK; COUNT];
        let (mut place, mut slice) = (0, 0);
        while slice < self.keys.len() {
            let mut key = 0;
            while key < self.keys[slice].len() {
                all[place] = self.keys[slice][key];
                (place, key) = (place + 1, key + 1);
            }
            slice += 1;
        }
        all
    }

    /// The key of this name in the group itself.
    pub fn key(&self, name: &str) -> Option<&'static KeySpec> {
        self.keys().find(|key| key.name == name)
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

    /// Calls `f` with the full name and declaration of every key, groups after the keys at their level; the members of
    /// a list come under `*`.
    pub fn each_key(&self, path: &str, f: &mut dyn FnMut(&str, &'static KeySpec)) {
        self.each_key_of(path, &|_| vec![MEMBER.to_owned()], f);
    }

    /// The same, with the members of each list as `names` gives them.
    pub fn each_key_of(
        &self,
        path: &str,
        names: &dyn Fn(&str) -> Vec<String>,
        f: &mut dyn FnMut(&str, &'static KeySpec),
    ) {
        for key in self.keys() {
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
pub const MEMBER: &str = "NAME";

/// The name of a key or group within the group `path`; the root's path is empty.
pub fn dotted(path: &str, name: &str) -> String {
    if path.is_empty() {
        name.to_owned()
    } else {
        format!("{path}.{name}")
    }
}

fn join(doc: &[&str]) -> String {
    doc.iter().map(|line| line.trim()).collect::<Vec<_>>().join(" ")
}
