//! An assembly as layers of files: a base, and files that modify it.

use std::collections::BTreeMap;
use std::path::Path;

use nailnoise_documents::{Document, DocumentError, Place, read_regular};
use nailnoise_quantities::{Kind, any, range};

use super::fault::{AssemblyError, Fault};
use super::formula::{Term, parse};
use super::keys::standard;
use super::named::NamedInTexts;
use super::node::{Entry, FieldText, Node, Removed, Sources, Spot, Tree, entries};

/// Built-in assemblies: name and text.
pub const BUILT_IN: [(&str, &str); 9] = [
    ("n80cb", include_str!("../../../assemblies/n80cb.toml")),
    (
        "n80cb_as_published",
        include_str!("../../../assemblies/n80cb_as_published.toml"),
    ),
    ("n80cb_chamber", include_str!("../../../assemblies/n80cb_chamber.toml")),
    ("stapler", include_str!("../../../assemblies/stapler.toml")),
    (
        "gas_spring_nailer",
        include_str!("../../../assemblies/gas_spring_nailer.toml"),
    ),
    ("blow_gun", include_str!("../../../assemblies/blow_gun.toml")),
    ("air_gun_valve", include_str!("../../../assemblies/air_gun_valve.toml")),
    (
        "air_gun_spring",
        include_str!("../../../assemblies/air_gun_spring.toml"),
    ),
    ("impact_rig", include_str!("../../../assemblies/impact_rig.toml")),
];

/// The assembly used by a design without `[cycle]`.
const DEFAULT: &str = "n80cb";

/// Largest file of an assembly \[bytes\].
const LARGEST: u64 = 4_000_000;

/// Largest number of layered files.
const DEEPEST: usize = 16;

/// Tables that only group the fields of a block.
pub const LAYOUT: [&str; 5] = ["place", "item", "seated", "acts", "flow"];

/// Tables of `[cycle]` that contain blocks by name.
pub(super) const FAMILIES: [&str; 18] = [
    "reservoir",
    "body",
    "volume",
    "face",
    "passage",
    "contact",
    "spring",
    "friction",
    "force",
    "motor",
    "hold",
    "fastener",
    "blow",
    "trigger",
    "sensor",
    "event",
    "opening",
    "load",
];

/// A key that an assembly declares for its own use.
#[derive(Debug, Clone, PartialEq)]
pub struct DeclaredKey {
    /// Dimension and domain.
    pub kind: Kind,
    /// Symbol; empty if there is none.
    pub symbol: String,
    /// Description; empty if there is none.
    pub text: String,
    /// Where it is declared.
    pub at: Place,
}

/// The merged text of an assembly.
#[derive(Debug, Clone)]
pub struct AssemblyText {
    pub(super) name: String,
    pub(super) sources: Sources,
    /// The table `cycle`.
    pub(super) cycle: Node,
    declared: BTreeMap<String, DeclaredKey>,
    /// Values of keys given in the files.
    pub(super) values: BTreeMap<String, Node>,
    /// Names in the texts of the files, also of blocks that a nearer file removes.
    pub(super) named: NamedInTexts,
    /// Blocks and fields that a nearer file removes.
    pub(super) removed: Vec<Removed>,
}

impl AssemblyText {
    /// Reads an assembly file and the assemblies it is based on. Every group of the file must be a standard one or be
    /// declared under `[keys]`.
    ///
    /// # Errors
    /// If a file cannot be read, is not TOML, or gives an undeclared key.
    pub fn open(document: &Document) -> Result<Self, AssemblyError> {
        Self::open_files(std::slice::from_ref(document))
    }

    /// Reads an assembly whose files are `documents`, beginning with the base.
    ///
    /// # Errors
    /// Same as [`open`](Self::open).
    pub fn open_files(documents: &[Document]) -> Result<Self, AssemblyError> {
        let text = Self::open_design(documents)?;
        text.check_values()?;
        Ok(text)
    }

    /// Reads a built-in assembly, if one has this name.
    ///
    /// # Errors
    /// Same as [`open`](Self::open).
    pub fn built_in(name: &str) -> Option<Result<Self, AssemblyError>> {
        built_in(name).map(|document| Self::open(&document))
    }

    /// Reads the assembly of a design whose files are `documents`, beginning with the base. Without `[cycle]` it is the
    /// assembly n80cb. Groups that are not declared under `[keys]` are left to the reader of the design.
    ///
    /// # Errors
    /// If a file cannot be read or is not TOML.
    pub fn open_design(documents: &[Document]) -> Result<Self, AssemblyError> {
        let mut text = Self {
            name: String::new(),
            sources: Sources::default(),
            cycle: Node::empty(Spot {
                document: 0,
                span: 0..0,
            }),
            declared: BTreeMap::new(),
            values: BTreeMap::new(),
            named: NamedInTexts::default(),
            removed: Vec::new(),
        };
        for document in documents {
            text.add(document, 0)?;
        }
        if text.name.is_empty() {
            text.add_named(DEFAULT, None, 0)?;
        }
        Ok(text)
    }

    /// Name of the assembly.
    pub fn name(&self) -> &str {
        &self.name
    }

    /// Keys that the assembly declares, by full name.
    pub fn declared(&self) -> &BTreeMap<String, DeclaredKey> {
        &self.declared
    }

    /// The text that the files give for a field with this full name (`cycle.event.t4.becomes`), if it is a text.
    pub fn text_of(&self, path: &str) -> Option<&str> {
        let fields = path.strip_prefix("cycle.")?.split('.');
        let node = fields.into_iter().try_fold(&self.cycle, |node, key| node.get(key))?;
        node.text()
    }

    /// Names of the outcomes that the assembly declares, in their order.
    pub fn outcomes(&self) -> Vec<&str> {
        match self.cycle.get("outcome").map(|outcomes| &outcomes.value) {
            Some(Tree::Table(entries)) => entries.iter().map(|entry| entry.key.as_str()).collect(),
            Some(Tree::Array(pairs)) => {
                let pairs = pairs.iter().filter_map(|pair| match &pair.value {
                    Tree::Array(pair) => pair.first(),
                    _ => None,
                });
                pairs.filter_map(Node::text).collect()
            }
            _ => Vec::new(),
        }
    }

    /// Names of the surfaces of a body whose forces are given by the assembly.
    pub fn surfaces(&self, body: &str) -> Vec<&str> {
        let loads = self.cycle.get("load").and_then(|loads| loads.get(body));
        let entries = loads.map_or(&[][..], Node::entries).iter();
        let surfaces = entries.filter(|entry| entry.key != "if");
        surfaces.map(|entry| entry.key.as_str()).collect()
    }

    /// Checks that the surfaces of a body whose forces are given by the assembly are among these.
    ///
    /// # Errors
    /// The first other one, with its location.
    pub fn check_surfaces(&self, body: &str, known: &[&str]) -> Result<(), AssemblyError> {
        let loads = self.cycle.get("load").and_then(|loads| loads.get(body));
        let mut entries = loads.map_or(&[][..], Node::entries).iter();
        let Some(other) = entries.find(|entry| entry.key != "if" && !known.contains(&entry.key.as_str())) else {
            return Ok(());
        };
        let path = format!("cycle.load.{body}.{}", other.key);
        let fault = Fault::UnknownName {
            name: other.key.clone(),
            wanted: format!("surface of \"{body}\""),
            known: known.iter().map(|&name| name.to_owned()).collect(),
        };
        Err(self.error(&path, &other.spot, fault))
    }

    /// All fields and values of keys, one per line in alphabetical order; equal for assemblies that differ only in the
    /// division into files and the order of fields.
    pub fn canonical(&self) -> String {
        let line = |field: FieldText| format!("{}={}\n", field.path, field.text);
        let mut lines: Vec<String> = self.fields().into_iter().map(line).collect();
        lines.sort();
        lines.concat()
    }

    /// All fields, and the values of the keys that it declares.
    pub fn fields(&self) -> Vec<FieldText> {
        let mut fields = Vec::new();
        self.cycle.fields("cycle", &mut fields);
        for (path, node) in &self.values {
            if self.declared.contains_key(path) {
                node.fields(path, &mut fields);
            }
        }
        fields
    }

    /// Adds a document as a layer, after the assembly that it is based on.
    fn add(&mut self, document: &Document, depth: usize) -> Result<(), AssemblyError> {
        let index = self.sources.documents.len();
        self.sources.documents.push(document.clone());
        let syntax = |error: DocumentError| AssemblyError {
            path: String::new(),
            at: match &error {
                DocumentError::Syntax { at, .. } => at.clone(),
                DocumentError::NotText { .. } => document.place(0..0),
            },
            fault: Fault::Syntax(error.to_string()),
            changes: Box::default(),
        };
        let table = document.table().map_err(syntax)?;
        let mut groups = entries(index, &table);
        let cycle = groups
            .iter()
            .position(|entry| entry.key == "cycle")
            .map(|at| groups.remove(at));
        let keys = groups
            .iter()
            .position(|entry| entry.key == "keys")
            .map(|at| groups.remove(at));
        if let Some(cycle) = cycle {
            self.add_cycle(cycle.node, document, depth)?;
        }
        if let Some(keys) = keys {
            self.declare("", &keys.node)?;
        }
        for group in groups {
            self.add_values(&group.key, group.node);
        }
        self.sources.merged.push(index);
        Ok(())
    }

    fn add_cycle(&mut self, mut cycle: Node, document: &Document, depth: usize) -> Result<(), AssemblyError> {
        let Tree::Table(fields) = &mut cycle.value else {
            let fault = Fault::Kind {
                found: cycle.found(),
                expected: "a table".to_owned(),
            };
            return Err(self.error("cycle", &cycle.spot, fault));
        };
        let assembly = fields
            .iter()
            .position(|entry| entry.key == "assembly")
            .map(|at| fields.remove(at));
        let schema = fields
            .iter()
            .position(|entry| entry.key == "schema")
            .map(|at| fields.remove(at));
        canonical(fields);
        let own_name = || {
            let stem = document
                .path()
                .file_stem()
                .map(|stem| stem.to_string_lossy().into_owned());
            stem.filter(|stem| !stem.is_empty())
                .unwrap_or_else(|| "assembly".to_owned())
        };
        match assembly {
            Some(Entry { node, spot, .. }) => match &node.value {
                Tree::Text(name) => {
                    if depth >= DEEPEST {
                        let names = vec![name.clone(), "...".to_owned(), name.clone()];
                        return Err(self.error("cycle.assembly", &spot, Fault::Circle { names }));
                    }
                    self.restart();
                    let from = (document, node.spot.clone());
                    self.add_named(name, Some(from), depth + 1)?;
                }
                Tree::Table(_) => {
                    self.restart();
                    self.name = node
                        .get("name")
                        .and_then(Node::text)
                        .map_or_else(own_name, str::to_owned);
                    self.cycle = Node::empty(cycle.spot.clone());
                    self.check_schema(node.get("schema"))?;
                }
                _ => {
                    let fault = Fault::Kind {
                        found: node.found(),
                        expected: "the name of an assembly, or a table { name, schema }".to_owned(),
                    };
                    return Err(self.error("cycle.assembly", &node.spot, fault));
                }
            },
            None if schema.is_some() => {
                self.restart();
                self.name = own_name();
                self.cycle = Node::empty(cycle.spot.clone());
                self.check_schema(schema.as_ref().map(|entry| &entry.node))?;
            }
            None if self.name.is_empty() => self.add_named(DEFAULT, None, depth + 1)?,
            None => {}
        }
        self.named.add(&cycle);
        self.removed.extend(self.cycle.merge(cycle, "cycle"));
        Ok(())
    }

    /// Drops the blocks of the layers so far.
    fn restart(&mut self) {
        self.named = NamedInTexts::default();
        self.removed.clear();
        if let Tree::Table(fields) = &mut self.cycle.value {
            fields.clear();
        }
    }

    fn check_schema(&self, schema: Option<&Node>) -> Result<(), AssemblyError> {
        match schema {
            Some(node) if node.value != Tree::Number(1.0) => {
                let fault = Fault::Kind {
                    found: node.found(),
                    expected: "1, the version of this format".to_owned(),
                };
                Err(self.error("cycle.schema", &node.spot, fault))
            }
            _ => Ok(()),
        }
    }

    /// Adds an assembly by name: a built-in one, or a file next to the document that names it.
    fn add_named(&mut self, name: &str, from: Option<(&Document, Spot)>, depth: usize) -> Result<(), AssemblyError> {
        if let Some(document) = built_in(name) {
            return self.add(&document, depth);
        }
        let Some((document, spot)) = from else { return Ok(()) };
        let path = document.sibling(name);
        let read = read_regular(&path, LARGEST)
            .map_err(|error| error.to_string())
            .and_then(|bytes| Document::from_bytes(&path, bytes).map_err(|error| error.to_string()));
        match read {
            Ok(base) => self.add(&base, depth),
            Err(reason) => {
                let (name, known) = (name.to_owned(), BUILT_IN.map(|(name, _)| name.to_owned()).to_vec());
                Err(self.error("cycle.assembly", &spot, Fault::Unreadable { name, reason, known }))
            }
        }
    }

    /// Declares the keys of a table of `[keys]`.
    fn declare(&mut self, path: &str, node: &Node) -> Result<(), AssemblyError> {
        for entry in node.entries() {
            let full = dotted(path, &entry.key);
            if entry.node.get("domain").is_none() {
                if entry.node.entries().is_empty() {
                    let fault = Fault::Missing {
                        field: "domain".to_owned(),
                        example: "{ domain = \"1 .. 100 mm\", text = \"bore of the cylinder\" }".to_owned(),
                    };
                    return Err(self.error(&format!("keys.{full}"), &entry.node.spot, fault));
                }
                self.declare(&full, &entry.node)?;
                continue;
            }
            if let Some(spec) = standard(&full) {
                let allowed = spec.kind.allowed();
                return Err(self.error(&format!("keys.{full}"), &entry.spot, Fault::StandardKey { allowed }));
            }
            let declared = self.declaration(&full, &entry.node)?;
            self.declared.insert(full, declared);
        }
        Ok(())
    }

    fn declaration(&self, path: &str, node: &Node) -> Result<DeclaredKey, AssemblyError> {
        const FIELDS: [&str; 3] = ["domain", "symbol", "text"];
        let place = format!("keys.{path}");
        let mut texts = [const { String::new() }; 3];
        for entry in node.entries() {
            let Some(at) = FIELDS.iter().position(|field| *field == entry.key) else {
                let fault = Fault::UnknownField {
                    owner: "declaration of a key".to_owned(),
                    name: entry.key.clone(),
                    known: FIELDS.map(str::to_owned).to_vec(),
                };
                return Err(self.error(&format!("{place}.{}", entry.key), &entry.spot, fault));
            };
            let Some(text) = entry.node.text() else {
                let fault = Fault::Kind {
                    found: entry.node.found(),
                    expected: "a text".to_owned(),
                };
                return Err(self.error(&format!("{place}.{}", entry.key), &entry.node.spot, fault));
            };
            text.clone_into(&mut texts[at]);
        }
        let [domain, symbol, text] = texts;
        let kind = domain_kind(&domain).ok_or_else(|| {
            let fault = Fault::Literal {
                text: domain,
                problem: "it is not a domain".to_owned(),
                units: "1e-6 .. 100 m".to_owned(),
            };
            self.error(&format!("{place}.domain"), &node.spot, fault)
        })?;
        Ok(DeclaredKey {
            kind,
            symbol,
            text,
            at: *self.sources.place(&node.spot),
        })
    }

    /// Adds the values of a group; a later file replaces a value and retains its range and provenance.
    fn add_values(&mut self, path: &str, node: Node) {
        if node.is_table() && !node.is_literal_table() {
            if let Tree::Table(entries) = node.value {
                for entry in entries {
                    self.add_values(&dotted(path, &entry.key), entry.node);
                }
            }
            return;
        }
        self.named.add(&node);
        match self.values.get_mut(path) {
            Some(present) => {
                present.merge(node, path);
            }
            None => {
                self.values.insert(path.to_owned(), node);
            }
        }
    }

    /// The dimension and domain of a key that is declared or standard.
    pub(super) fn kind(&self, path: &str) -> Option<Kind> {
        let declared = self.declared.get(path).map(|declared| declared.kind);
        declared.or_else(|| standard(path).map(|spec| spec.kind))
    }

    fn check_values(&self) -> Result<(), AssemblyError> {
        for (path, node) in &self.values {
            if self.kind(path).is_none() {
                return Err(self.undeclared(path, node));
            }
        }
        Ok(())
    }

    /// The error of a value whose key is not declared.
    pub(super) fn undeclared(&self, path: &str, node: &Node) -> AssemblyError {
        let fault = Fault::Undeclared {
            key: path.to_owned(),
            known: self.declared.keys().cloned().collect(),
        };
        self.error(path, &node.spot, fault)
    }

    pub(super) fn error(&self, path: &str, spot: &Spot, fault: Fault) -> AssemblyError {
        AssemblyError {
            path: path.to_owned(),
            fault,
            at: self.sources.place(spot),
            changes: Box::default(),
        }
    }
}

/// The text of a built-in assembly.
fn built_in(name: &str) -> Option<Document> {
    let (name, text) = BUILT_IN.iter().find(|(own, _)| *own == name)?;
    Some(Document::new(Path::new(&format!("assemblies/{name}.toml")), text))
}

/// `path.name`, or `name` in the root table.
pub(super) fn dotted(path: &str, name: &str) -> String {
    nailnoise_quantities::dotted(path, name)
}

/// Dimension and domain of "1e-6 .. 100 m".
fn domain_kind(text: &str) -> Option<Kind> {
    let (_, high) = text.split_once("..")?;
    let dimension = match parse(high.trim().trim_start_matches('-')).ok()? {
        Term::Number { dimension, .. } => dimension,
        _ => return None,
    };
    let [low, high] = range(text, dimension, false).ok()?;
    (low.si < high.si).then(|| any(dimension).within(low.si, high.si).or_gauge())
}

/// Removes layout: the fields of a block's layout tables become its own, and the groups of `let` are merged into one
/// table.
fn canonical(fields: &mut [Entry]) {
    for field in fields {
        let Tree::Table(blocks) = &mut field.node.value else {
            continue;
        };
        if field.key == "let" {
            let groups = std::mem::take(blocks);
            for group in groups {
                flatten(group, blocks);
            }
        } else if FAMILIES.contains(&field.key.as_str()) {
            for block in blocks {
                let Tree::Table(entries) = &mut block.node.value else {
                    continue;
                };
                let own = std::mem::take(entries);
                for entry in own {
                    match entry.node.value {
                        Tree::Table(inner) if LAYOUT.contains(&entry.key.as_str()) => entries.extend(inner),
                        _ => entries.push(entry),
                    }
                }
            }
        }
    }
}

fn flatten(group: Entry, names: &mut Vec<Entry>) {
    if group.node.is_table() && !group.node.is_literal_table() {
        if let Tree::Table(entries) = group.node.value {
            for entry in entries {
                flatten(entry, names);
            }
        }
    } else {
        names.push(group);
    }
}
