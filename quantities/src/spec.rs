//! Declarations of keys and groups, as data.

use crate::kind::Kind;

/// A key of the design file.
#[derive(Debug, Clone, Copy)]
pub struct KeySpec {
    /// Its name in its group.
    pub name: &'static str,
    /// Symbol in Nili Ahmadabadi (2016) or in the field; empty if there is none.
    pub symbol: &'static str,
    /// Description, one line of text per element.
    pub doc: &'static [&'static str],
    /// Kind of its value.
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
    /// Description, one line of text per element.
    pub doc: &'static [&'static str],
    /// The keys directly in the group, in order: those declared before the part, those of the part, and those declared
    /// after it.
    pub keys: &'static [&'static [KeySpec]],
    /// Its subgroups, by name.
    pub groups: &'static [(&'static str, &'static GroupSpec)],
    /// Its lists: the design may give any number of groups of the same declaration, each with a name.
    pub lists: &'static [(&'static str, &'static GroupSpec)],
    /// Whether a file may give the values as an ordered list.
    pub is_list: bool,
}

impl GroupSpec {
    /// The description on one line.
    pub fn description(&self) -> String {
        join(self.doc)
    }

    /// The keys directly in the group, in order.
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

    /// Finds a key directly in this group.
    pub fn key(&self, name: &str) -> Option<&'static KeySpec> {
        self.keys().find(|key| key.name == name)
    }

    /// Finds a direct subgroup.
    pub fn group(&self, name: &str) -> Option<&'static GroupSpec> {
        self.groups
            .iter()
            .find(|(own, _)| *own == name)
            .map(|(_, group)| *group)
    }

    /// The declaration of the members of a list directly in this group.
    pub fn list(&self, name: &str) -> Option<&'static GroupSpec> {
        self.lists
            .iter()
            .find(|(own, _)| *own == name)
            .map(|(_, member)| *member)
    }

    /// Calls `f` with the full name and declaration of every key, the keys of each level before its subgroups; list
    /// members have the name `*`.
    pub fn each_key(&self, path: &str, f: &mut dyn FnMut(&str, &'static KeySpec)) {
        self.each_key_of(path, &|_| vec![MEMBER.to_owned()], f);
    }

    /// Same as `each_key`, with the names of list members given by `names`.
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

/// Placeholder for the name that a design gives a list member.
pub const MEMBER: &str = "NAME";

/// The full name of a key or group within the group `path`; the path of the root is empty.
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
