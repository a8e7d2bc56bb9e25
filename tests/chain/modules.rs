//! The modules of a crate and the arrows between its files: from each file to those that define the names it uses.
//!
//! Items are followed through re-exports to the file that defines them, so that a `mod.rs` that only gathers its folder
//! has no arrows to it. Names are read in `use` items, in paths of types, expressions and patterns, and in the
//! arguments of macros. Code for tests is left out. Methods are not seen, because a path does not name them.

use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::{Path, PathBuf};

use syn::visit_mut::{self, VisitMut};

/// A path of names: `["stages", "cycle"]` for a module, from the root of the crate.
pub(crate) type Names = Vec<String>;

/// An item of a module, or the module itself where `name` is none.
#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) struct Item {
    /// The module that defines it.
    pub(crate) module: Names,
    /// Its name.
    pub(crate) name: Option<String>,
}

/// The modules of a crate, without those for tests.
#[derive(Default)]
pub(crate) struct Crate {
    modules: BTreeMap<Names, Unit>,
}

/// Names that a module uses.
#[derive(Default)]
struct Unit {
    /// Its file, from the folder of the sources.
    file: PathBuf,
    /// Names of `use` items with their paths.
    imports: BTreeMap<String, Names>,
    /// The names among these that the module gives on.
    exported: BTreeSet<String>,
    /// Modules from which all names are imported.
    globs: Vec<Names>,
    /// Modules whose names are all given on.
    exported_globs: Vec<Names>,
    /// Names of the items that it defines.
    defined: BTreeSet<String>,
    /// Names of local variables, which hide items in paths of one name.
    variables: BTreeSet<String>,
    /// All paths as written.
    paths: BTreeSet<Names>,
}

/// Source files of a crate by their paths from its folder.
pub(crate) type Sources = BTreeMap<PathBuf, String>;

/// The source files below a folder.
pub(crate) fn sources(folder: &Path) -> Sources {
    let mut found = Sources::new();
    let mut folders = vec![folder.to_owned()];
    while let Some(open) = folders.pop() {
        for entry in fs::read_dir(&open).unwrap() {
            let path = entry.unwrap().path();
            if path.is_dir() {
                folders.push(path);
            } else if path.extension().is_some_and(|extension| extension == "rs") {
                let text = fs::read_to_string(&path).unwrap();
                found.insert(path.strip_prefix(folder).unwrap().to_owned(), text);
            }
        }
    }
    found
}

impl Crate {
    /// The modules of a library, from its root `lib.rs`.
    pub(crate) fn new(sources: &Sources) -> Self {
        let mut own = Self::default();
        own.read(Names::new(), PathBuf::from("lib.rs"), sources);
        own
    }

    fn read(&mut self, module: Names, file: PathBuf, sources: &Sources) {
        let text = sources
            .get(&file)
            .unwrap_or_else(|| panic!("no file {}", file.display()));
        let parsed = syn::parse_file(text).unwrap_or_else(|error| panic!("{}: {error}", file.display()));
        self.add(module, file, parsed.items, sources);
    }

    fn add(&mut self, module: Names, file: PathBuf, items: Vec<syn::Item>, sources: &Sources) {
        let mut unit = Unit {
            file: file.clone(),
            ..Unit::default()
        };
        let mut children = Vec::new();
        for mut item in items {
            match item {
                syn::Item::Mod(child) if !for_tests(&child.attrs) => children.push(child),
                _ => unit.visit_item_mut(&mut item),
            }
        }
        self.modules.insert(module.clone(), unit);
        for child in children {
            let name = child.ident.to_string();
            let inner = [module.clone(), vec![name.clone()]].concat();
            match child.content {
                Some((_, items)) => self.add(inner, file.clone(), items, sources),
                None => {
                    let stem = file.file_stem().unwrap().to_string_lossy().into_owned();
                    let gathers = ["lib", "mod"].contains(&stem.as_str());
                    let folder = if gathers {
                        file.with_file_name("")
                    } else {
                        file.with_extension("")
                    };
                    let files = [folder.join(format!("{name}.rs")), folder.join(&name).join("mod.rs")];
                    let found = files.into_iter().find(|path| sources.contains_key(path));
                    self.read(inner, found.unwrap_or_else(|| panic!("no file of {name}")), sources);
                }
            }
        }
    }

    /// All modules.
    pub(crate) fn modules(&self) -> impl Iterator<Item = &Names> {
        self.modules.keys()
    }

    /// The file of a module, from the folder of the sources.
    pub(crate) fn file(&self, module: &Names) -> &Path {
        &self.modules[module].file
    }

    /// The items of the same crate that a module names.
    pub(crate) fn items(&self, module: &Names) -> BTreeSet<Item> {
        let unit = &self.modules[module];
        let is_variable = |path: &&Names| path.len() == 1 && unit.variables.contains(&path[0]);
        let paths = unit.paths.iter().filter(|path| !is_variable(path));
        paths
            .filter_map(|path| self.resolved(&self.absolute(module, path, 0)?, 0))
            .collect()
    }

    /// The first names of the paths of a module that do not lie in the crate: other crates, and local names.
    pub(crate) fn foreign(&self, module: &Names) -> BTreeSet<String> {
        let paths = self.modules[module].paths.iter();
        let foreign = paths.filter(|path| self.absolute(module, path, 0).is_none());
        foreign.filter_map(|path| path.first().cloned()).collect()
    }

    /// The files whose items each file names.
    pub(crate) fn arrows(&self) -> BTreeMap<PathBuf, BTreeSet<PathBuf>> {
        let mut arrows: BTreeMap<PathBuf, BTreeSet<PathBuf>> = BTreeMap::new();
        for (module, unit) in &self.modules {
            let items = self.items(module);
            // The use of a module's name is an arrow to the items that are named through it.
            let named = items.iter().filter(|item| item.name.is_some());
            let files = named.map(|item| self.modules[&item.module].file.clone());
            let others = files.filter(|file| *file != unit.file);
            arrows.entry(unit.file.clone()).or_default().extend(others);
        }
        arrows
    }

    /// A path as written in a module, from the crate's root; none if it does not lie in the crate.
    fn absolute(&self, module: &Names, path: &[String], depth: usize) -> Option<Names> {
        let (first, rest) = path.split_first()?;
        let unit = &self.modules[module];
        let mut at = match first.as_str() {
            "crate" => Names::new(),
            "self" => module.clone(),
            "super" => module[..module.len().checked_sub(1)?].to_vec(),
            name => {
                if depth > DEEPEST {
                    return None;
                }
                if let Some(import) = unit.imports.get(name).filter(|import| import[..] != *path) {
                    self.absolute(module, import, depth + 1)?
                } else if self.has_module(module, name) {
                    [module.clone(), vec![name.to_owned()]].concat()
                } else {
                    let globs = unit.globs.iter();
                    let mut from = globs.filter_map(|glob| self.absolute(module, glob, depth + 1));
                    let from = from.find(|from| self.has_module(from, name) || self.exports(from, name))?;
                    [from, vec![name.to_owned()]].concat()
                }
            }
        };
        for name in rest {
            match name.as_str() {
                "super" => drop(at.pop()),
                name => at.push(name.to_owned()),
            }
        }
        Some(at)
    }

    fn has_module(&self, module: &Names, name: &str) -> bool {
        self.modules
            .contains_key(&[module.clone(), vec![name.to_owned()]].concat())
    }

    fn exports(&self, module: &Names, name: &str) -> bool {
        self.modules
            .get(module)
            .is_some_and(|unit| unit.exported.contains(name))
    }

    fn defines(&self, module: &Names, name: &str) -> bool {
        let unit = self.modules.get(module);
        unit.is_some_and(|unit| unit.defined.contains(name) || unit.exported.contains(name))
    }

    /// The item of a path from the crate's root.
    fn resolved(&self, path: &[String], depth: usize) -> Option<Item> {
        let mut at = Names::new();
        for (place, name) in path.iter().enumerate() {
            if self.has_module(&at, name) {
                at.push(name.clone());
                continue;
            }
            let unit = &self.modules[&at];
            let import = unit.imports.get(name).filter(|_| unit.exported.contains(name));
            if let Some(import) = import.filter(|_| depth < DEEPEST) {
                match self.absolute(&at, import, 0) {
                    Some(target) => return self.resolved(&[target, path[place + 1..].to_vec()].concat(), depth + 1),
                    // A name of another crate, unless a macro of this module.
                    None if !unit.defined.contains(name) => return None,
                    None => {}
                }
            }
            let given_on = unit
                .exported_globs
                .iter()
                .filter(|_| depth < DEEPEST && !unit.defined.contains(name));
            let given_on = given_on.filter_map(|glob| self.absolute(&at, glob, 0));
            let mut given_on = given_on.filter(|from| self.defines(from, name));
            if let Some(from) = given_on.next() {
                return self.resolved(&[from, path[place..].to_vec()].concat(), depth + 1);
            }
            return Some(Item {
                module: at,
                name: Some(name.clone()),
            });
        }
        Some(Item { module: at, name: None })
    }
}

/// Most re-exports of a name that are followed.
const DEEPEST: usize = 8;

/// Whether an item is compiled for tests alone.
fn for_tests(attributes: &[syn::Attribute]) -> bool {
    attributes.iter().any(|attribute| match &attribute.meta {
        syn::Meta::List(list) => list.path.is_ident("cfg") && list.tokens.to_string() == "test",
        _ => false,
    })
}

impl Unit {
    fn import(&mut self, mut prefix: Names, tree: syn::UseTree, exported: bool) {
        match tree {
            syn::UseTree::Path(path) => {
                prefix.push(path.ident.to_string());
                self.import(prefix, *path.tree, exported);
            }
            syn::UseTree::Group(group) => {
                for tree in group.items {
                    self.import(prefix.clone(), tree, exported);
                }
            }
            syn::UseTree::Name(name) => {
                let name = name.ident.to_string();
                if name != "self" {
                    prefix.push(name);
                }
                let last = prefix.last().cloned().unwrap_or_default();
                self.named(last, prefix, exported);
            }
            syn::UseTree::Rename(rename) => {
                prefix.push(rename.ident.to_string());
                self.named(rename.rename.to_string(), prefix, exported);
            }
            syn::UseTree::Glob(_) => {
                self.globs.push(prefix.clone());
                if exported {
                    self.exported_globs.push(prefix);
                } else {
                    // The items that are meant are not written: all of that module counts.
                    self.paths.insert([prefix, vec!["*".to_owned()]].concat());
                }
            }
        }
    }

    fn named(&mut self, name: String, path: Names, exported: bool) {
        if exported {
            self.exported.insert(name.clone());
        } else {
            self.paths.insert(path.clone());
        }
        self.imports.insert(name, path);
    }

    /// Paths in the arguments of a macro.
    fn tokens(&mut self, tokens: proc_macro2::TokenStream) {
        let mut path = Names::new();
        let mut colons = 0;
        for token in tokens {
            match token {
                proc_macro2::TokenTree::Ident(name) => {
                    if colons != 2 {
                        self.keep(&mut path);
                    }
                    path.push(name.to_string());
                    colons = 0;
                }
                proc_macro2::TokenTree::Punct(mark) if mark.as_char() == ':' && !path.is_empty() => colons += 1,
                other => {
                    self.keep(&mut path);
                    colons = 0;
                    if let proc_macro2::TokenTree::Group(group) = other {
                        self.tokens(group.stream());
                    }
                }
            }
        }
        self.keep(&mut path);
    }

    fn keep(&mut self, path: &mut Names) {
        if path.len() > 1 {
            self.paths.insert(path.clone());
        }
        path.clear();
    }
}

impl VisitMut for Unit {
    fn visit_item_mut(&mut self, item: &mut syn::Item) {
        let (attributes, name) = match item {
            syn::Item::Const(item) => (&item.attrs, Some(&item.ident)),
            syn::Item::Enum(item) => (&item.attrs, Some(&item.ident)),
            syn::Item::Fn(item) => (&item.attrs, Some(&item.sig.ident)),
            syn::Item::Impl(item) => (&item.attrs, None),
            syn::Item::Macro(item) => (&item.attrs, item.ident.as_ref()),
            syn::Item::Static(item) => (&item.attrs, Some(&item.ident)),
            syn::Item::Struct(item) => (&item.attrs, Some(&item.ident)),
            syn::Item::Trait(item) => (&item.attrs, Some(&item.ident)),
            syn::Item::Type(item) => (&item.attrs, Some(&item.ident)),
            syn::Item::Use(item) => (&item.attrs, None),
            _ => return,
        };
        if for_tests(attributes) {
            return;
        }
        self.defined.extend(name.map(ToString::to_string));
        if let syn::Item::Macro(item) = item {
            // A macro that declares items names them at its outermost level: `choice! { Kind { ... } }`.
            let names = item.mac.tokens.clone().into_iter().filter_map(|token| match token {
                proc_macro2::TokenTree::Ident(name) => Some(name.to_string()),
                _ => None,
            });
            self.defined.extend(names);
        }
        visit_mut::visit_item_mut(self, item);
    }

    fn visit_impl_item_fn_mut(&mut self, item: &mut syn::ImplItemFn) {
        if !for_tests(&item.attrs) {
            visit_mut::visit_impl_item_fn_mut(self, item);
        }
    }

    fn visit_item_use_mut(&mut self, item: &mut syn::ItemUse) {
        let exported = !matches!(item.vis, syn::Visibility::Inherited);
        self.import(Names::new(), item.tree.clone(), exported);
    }

    fn visit_path_mut(&mut self, path: &mut syn::Path) {
        let names = path.segments.iter().map(|segment| segment.ident.to_string());
        self.paths.insert(names.collect());
        visit_mut::visit_path_mut(self, path);
    }

    fn visit_pat_ident_mut(&mut self, pattern: &mut syn::PatIdent) {
        self.variables.insert(pattern.ident.to_string());
        visit_mut::visit_pat_ident_mut(self, pattern);
    }

    fn visit_visibility_mut(&mut self, _: &mut syn::Visibility) {}

    fn visit_macro_mut(&mut self, own: &mut syn::Macro) {
        self.visit_path_mut(&mut own.path);
        self.tokens(own.tokens.clone());
    }

    fn visit_attribute_mut(&mut self, _: &mut syn::Attribute) {}
}

/// Files that reach each other, each group with the arrows within it; none where the files can be put in an order.
pub(crate) fn circles(arrows: &BTreeMap<PathBuf, BTreeSet<PathBuf>>) -> Vec<BTreeSet<[PathBuf; 2]>> {
    let reach = |from: &PathBuf| {
        let (mut seen, mut open) = (BTreeSet::new(), vec![from]);
        while let Some(at) = open.pop() {
            for next in arrows.get(at).into_iter().flatten() {
                if seen.insert(next.clone()) {
                    open.push(next);
                }
            }
        }
        seen
    };
    let reached: BTreeMap<&PathBuf, BTreeSet<PathBuf>> = arrows.keys().map(|file| (file, reach(file))).collect();
    let reaches = |from: &PathBuf, to: &PathBuf| reached.get(from).is_some_and(|reached| reached.contains(to));
    let mut groups: BTreeMap<BTreeSet<PathBuf>, BTreeSet<[PathBuf; 2]>> = BTreeMap::new();
    for (from, to) in arrows
        .iter()
        .flat_map(|(from, all)| all.iter().map(move |to| (from, to)))
    {
        if reaches(to, from) {
            let group = reached[from].iter().filter(|file| reaches(file, from));
            let arrows = groups.entry(group.cloned().collect()).or_default();
            arrows.insert([from.clone(), to.clone()]);
        }
    }
    groups.into_values().collect()
}
