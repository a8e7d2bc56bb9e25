//! The layering of the source: imports form no circle, stages import neither store nor commands, and a stage's key digests
//! the code of all that it imports.
//!
//! The tests read `use` lines, as `rustfmt` writes them; paths written out in expressions are not seen.

use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::{Path, PathBuf};

use crate::common::ROOT;

/// A module as its path from the crate's root: `["stages", "cycle"]`.
type Module = Vec<String>;

/// The files of a crate by module.
fn files(source: &Path) -> BTreeMap<Module, PathBuf> {
    let mut found = BTreeMap::new();
    let mut folders = vec![source.to_owned()];
    while let Some(folder) = folders.pop() {
        for entry in fs::read_dir(&folder).unwrap() {
            let path = entry.unwrap().path();
            if path.is_dir() {
                folders.push(path);
            } else if path.extension().is_some_and(|extension| extension == "rs") {
                let relative = path.strip_prefix(source).unwrap().with_extension("");
                let mut module: Module = relative
                    .iter()
                    .map(|part| part.to_string_lossy().into_owned())
                    .collect();
                if ["mod", "lib", "main"].contains(&module.last().unwrap().as_str()) {
                    module.pop();
                }
                found.insert(module, path);
            }
        }
    }
    found
}

/// The paths of the `use` lines of a file, its tests left out.
fn uses(path: &Path) -> Vec<Vec<String>> {
    let text = fs::read_to_string(path).unwrap();
    let code = text.split("#[cfg(test)]").next().unwrap();
    let statements = code.split(';').filter_map(|statement| {
        let lines = statement.lines().map(str::trim);
        let line: String = lines
            .skip_while(|line| !(line.starts_with("use ") || line.starts_with("pub") && line.contains(" use ")))
            .collect();
        line.split_once("use ")
            .map(|(_, path)| path.replace(char::is_whitespace, ""))
    });
    statements.flat_map(|path| expanded(&path)).collect()
}

/// `a::{b, c::d}` as `a::b` and `a::c::d`.
fn expanded(path: &str) -> Vec<Vec<String>> {
    let Some(open) = path.find('{') else {
        let path = path
            .split("as")
            .next()
            .filter(|_| path.contains("::as"))
            .unwrap_or(path);
        return vec![
            path.split("::")
                .filter(|part| !part.is_empty())
                .map(str::to_owned)
                .collect(),
        ];
    };
    let (head, inner) = (&path[..open], path[open + 1..].trim_end_matches('}'));
    let (mut depth, mut from, mut parts) = (0, 0, Vec::new());
    for (at, mark) in inner.char_indices() {
        match mark {
            '{' => depth += 1,
            '}' => depth -= 1,
            ',' if depth == 0 => {
                parts.push(inner[from..at].to_owned());
                from = at + 1;
            }
            _ => {}
        }
    }
    let mut last = inner[from..].to_owned();
    // The closing braces that belong to the last part were cut off with this group's own.
    last.extend(std::iter::repeat_n(
        '}',
        last.matches('{').count().saturating_sub(last.matches('}').count()),
    ));
    parts.push(last);
    let nonempty = parts.iter().filter(|part| !part.is_empty());
    nonempty.flat_map(|part| expanded(&format!("{head}{part}"))).collect()
}

/// The modules of the same crate that a module imports from.
fn imports(module: &Module, path: &Path, files: &BTreeMap<Module, PathBuf>) -> BTreeSet<Module> {
    let mut found = BTreeSet::new();
    for used in uses(path) {
        let mut at = match used[0].as_str() {
            "crate" => Module::new(),
            "super" | "self" => module.clone(),
            _ => continue,
        };
        for part in &used {
            match part.as_str() {
                "crate" | "self" => {}
                "super" => drop(at.pop()),
                part => at.push(part.to_owned()),
            }
        }
        while !at.is_empty() && !files.contains_key(&at) {
            at.pop();
        }
        if at != *module {
            found.insert(at);
        }
    }
    found
}

/// A file that only gathers its folder's modules.
fn gathers(path: &Path) -> bool {
    ["mod.rs", "lib.rs", "main.rs"].contains(&path.file_name().unwrap().to_str().unwrap())
}

/// A circle of imports, if there is one.
fn circle(graph: &BTreeMap<Module, BTreeSet<Module>>) -> Option<Vec<Module>> {
    let mut done = BTreeSet::new();
    fn visit<'a>(
        at: &'a Module,
        graph: &'a BTreeMap<Module, BTreeSet<Module>>,
        path: &mut Vec<&'a Module>,
        done: &mut BTreeSet<&'a Module>,
    ) -> Option<Vec<Module>> {
        if let Some(from) = path.iter().position(|&module| module == at) {
            return Some(path[from..].iter().map(|&module| module.clone()).collect());
        }
        if !done.insert(at) {
            return None;
        }
        path.push(at);
        let found = graph
            .get(at)
            .into_iter()
            .flatten()
            .find_map(|next| visit(next, graph, path, done));
        path.pop();
        found
    }
    graph
        .keys()
        .find_map(|module| visit(module, graph, &mut Vec::new(), &mut done))
}

fn assert_no_circle(source: &str) {
    let files = files(&Path::new(ROOT).join(source));
    let own = files.iter().filter(|(_, path)| !gathers(path));
    let graph = own.map(|(module, path)| {
        let imported = imports(module, path, &files);
        let imported = imported.into_iter().filter(|other| !gathers(&files[other])).collect();
        (module.clone(), imported)
    });
    assert_eq!(circle(&graph.collect()), None, "imports of {source} form a circle");
}

#[test]
fn imports_of_dynamics_form_no_circle() {
    assert_no_circle("dynamics/src");
}

#[test]
fn imports_of_meshes_form_no_circle() {
    assert_no_circle("meshes/src");
}

#[test]
fn imports_of_fem_form_no_circle() {
    assert_no_circle("fem/src");
}

#[test]
fn imports_of_acoustics_form_no_circle() {
    assert_no_circle("acoustics/src");
}

#[test]
fn imports_of_the_program_form_no_circle() {
    assert_no_circle("src");
}

#[test]
fn a_circle_would_be_found() {
    let module = |name: &str| vec![name.to_owned()];
    let graph = BTreeMap::from([
        (module("a"), BTreeSet::from([module("b")])),
        (module("b"), BTreeSet::from([module("c")])),
        (module("c"), BTreeSet::from([module("b")])),
    ]);
    assert_eq!(circle(&graph), Some(vec![module("b"), module("c")]));
}

/// Modules of the program that no stage may import from.
const ABOVE_STAGES: [&str; 10] = [
    "bundle", "chain", "commands", "graph", "output", "report", "staging", "store", "study", "watch",
];

#[test]
fn stages_import_neither_store_nor_graph_nor_commands() {
    let files = files(&Path::new(ROOT).join("src"));
    let makes_stages = |module: &Module| match &module[..] {
        [first, ..] if first == "stages" => true,
        [model, sources, .., last] => model == "model" && sources == "sources" && last == "sound",
        _ => false,
    };
    for (module, path) in files.iter().filter(|(module, _)| makes_stages(module)) {
        for other in imports(module, path, &files) {
            let first = other.first().map_or("", String::as_str);
            assert!(
                !ABOVE_STAGES.contains(&first),
                "{} imports from {first}",
                path.display()
            );
        }
        let sees_designs = uses(path).iter().any(|used| used.join("::") == "crate::design::Design");
        assert!(!sees_designs, "{} takes a whole design", path.display());
    }
}

/// Names of sources in quotes that are not names of sources, by file and name: keys of designs, bodies, headings,
/// labels.
const OTHER_NAMES: &[(&str, &[&str], &str)] = &[
    ("src/commands/check.rs", &["body"], "an argument"),
    ("src/commands/explain.rs", &["body"], "a heading"),
    (
        "src/design",
        &["workpiece", "exhaust", "body"],
        "keys, carriers, names that a design may give",
    ),
    ("src/drawing/surroundings.rs", &["workpiece"], "a label"),
    ("src/drawing/tool_views.rs", &["workpiece"], "a label"),
    ("src/figures/cycle.rs", &["exhaust"], "a curve of the cycle"),
    ("src/model/sources", &["workpiece", "exhaust", "body"], "the sources"),
    ("src/output/csv.rs", &["body"], "a heading"),
    ("src/report", &["workpiece", "body"], "headings"),
    (
        "src/stages/bodies",
        &["workpiece", "body"],
        "names of bodies and of a stage",
    ),
    ("src/study/groups.rs", &["body"], "a group of inputs"),
];

#[test]
fn no_file_outside_its_own_names_a_source() {
    let root = Path::new(ROOT);
    let mut found = BTreeSet::new();
    for path in files(&root.join("src")).into_values() {
        let text = fs::read_to_string(&path).unwrap();
        let code = text.split("#[cfg(test)]").next().unwrap();
        let lines = code.lines().filter(|line| !line.trim_start().starts_with("//"));
        let lines: Vec<&str> = lines.collect();
        let relative = path.strip_prefix(root).unwrap();
        for name in nailnoise::design::SOURCES {
            if lines.iter().any(|line| line.contains(&format!("\"{name}\""))) {
                found.insert((relative.display().to_string(), name));
            }
        }
    }
    let is_other = |(path, name): &&(String, &str)| {
        let mut others = OTHER_NAMES.iter();
        !others.any(|(prefix, names, _)| path.starts_with(prefix) && names.contains(name))
    };
    let wrong: Vec<_> = found.iter().filter(is_other).collect();
    assert!(wrong.is_empty(), "these files name a source: {wrong:?}");
    for (prefix, names, what) in OTHER_NAMES {
        let unused = |name: &&&str| !found.iter().any(|(path, own)| path.starts_with(prefix) && own == *name);
        let unused: Vec<_> = names.iter().filter(unused).collect();
        assert!(unused.is_empty(), "{prefix} no longer has {what} {unused:?}");
    }
}

#[test]
fn a_design_may_give_the_error_of_each_source_and_of_no_other() {
    let names: Vec<&str> = nailnoise::model::sources::names().collect();
    assert_eq!(names, nailnoise::design::SOURCES);
}

/// The units of code that each `code!` of a file names.
fn named_units(text: &str) -> Vec<BTreeSet<String>> {
    let lists = text.split("code!").skip(1).filter_map(|rest| {
        let list = rest.strip_prefix(['[', '('])?;
        list.split([']', ')']).next()
    });
    lists
        .map(|list| {
            list.split(',')
                .map(|unit| unit.trim().to_owned())
                .filter(|unit| !unit.is_empty())
                .collect()
        })
        .collect()
}

/// The unit of code of a module, if its code may make the output of a stage. The stages of a source are its file, or
/// `sound.rs` in its folder.
fn unit(module: &Module) -> Option<String> {
    match &module[..] {
        [stages, unit, ..] if stages == "stages" => Some(format!("stages_{unit}")),
        [model, sources, source] if model == "model" && sources == "sources" => {
            let folder = Path::new(ROOT).join("src/model/sources").join(source);
            (!folder.is_dir()).then(|| format!("model_sources_{source}"))
        }
        [model, sources, source, stages] if model == "model" && sources == "sources" && stages == "sound" => {
            Some(format!("model_sources_{source}"))
        }
        [exports, ..] if exports == "output" || exports == "report" => Some(exports.clone()),
        _ => None,
    }
}

/// Modules of `stages` whose code reaches no result.
const WITHOUT_PHYSICS: [&str; 2] = ["stages_codec", "stages_progress"];

#[test]
fn the_code_in_a_stages_key_is_that_of_all_it_imports() {
    let files = files(&Path::new(ROOT).join("src"));
    // Imports of each unit: crates of the workspace and other units.
    let mut imported: BTreeMap<String, BTreeSet<String>> = BTreeMap::new();
    for (module, path) in &files {
        let Some(own) = unit(module) else { continue };
        let units = imported.entry(own).or_default();
        let crates = uses(path)
            .into_iter()
            .filter_map(|used| used[0].strip_prefix("nailnoise_").map(str::to_owned));
        units.extend(crates);
        units.extend(imports(module, path, &files).iter().filter_map(unit));
    }
    let (mut lists, mut wrong) = (0, Vec::new());
    for (module, path) in &files {
        let Some(own) = unit(module) else { continue };
        let text = fs::read_to_string(path).unwrap();
        for named in named_units(&text) {
            lists += 1;
            let mut needed = BTreeSet::from([own.clone()]);
            let mut open = vec![own.clone()];
            while let Some(unit) = open.pop() {
                for next in imported.get(&unit).into_iter().flatten() {
                    if needed.insert(next.clone()) {
                        open.push(next.clone());
                    }
                }
            }
            needed.retain(|unit| !WITHOUT_PHYSICS.contains(&unit.as_str()));
            // The digest of a crate includes those of the crates below it.
            let missing: Vec<_> = needed.difference(&named).collect();
            if !missing.is_empty() {
                wrong.push(format!("{}: code! lacks {missing:?}", path.display()));
            }
        }
    }
    assert_eq!(wrong, Vec::<String>::new());
    assert!(lists > 10, "{lists} lists found");
}
