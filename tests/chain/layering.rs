//! The layering of the source. Its files can be ordered so that none names an item of a later one; stages use neither
//! store nor commands; and a stage's key digests all the code that it uses.

use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::{Path, PathBuf};

use crate::common::ROOT;
use crate::modules::{Crate, Names, Sources, circles, sources};

/// The modules of a library of the workspace.
fn library(source: &str) -> Crate {
    Crate::new(&sources(&Path::new(ROOT).join(source)))
}

fn assert_no_circle(source: &str) {
    let found = circles(&library(source).arrows());
    let lines = found.iter().enumerate().flat_map(|(number, group)| {
        let line = move |[from, to]: &[PathBuf; 2]| format!("{number}: {} uses {}", from.display(), to.display());
        group.iter().map(line)
    });
    let lines: Vec<String> = lines.collect();
    assert!(
        lines.is_empty(),
        "files of {source} use each other:\n{}",
        lines.join("\n")
    );
}

#[test]
fn files_of_quantities_form_no_circle() {
    assert_no_circle("quantities/src");
}

#[test]
fn files_of_documents_form_no_circle() {
    assert_no_circle("documents/src");
}

#[test]
fn files_of_calibration_form_no_circle() {
    assert_no_circle("calibration/src");
}

#[test]
fn files_of_measurement_form_no_circle() {
    assert_no_circle("measurement/src");
}

#[test]
fn files_of_pipeline_form_no_circle() {
    assert_no_circle("pipeline/src");
}

#[test]
fn files_of_penetration_form_no_circle() {
    assert_no_circle("penetration/src");
}

#[test]
fn files_of_dynamics_form_no_circle() {
    assert_no_circle("dynamics/src");
}

#[test]
fn files_of_meshes_form_no_circle() {
    assert_no_circle("meshes/src");
}

#[test]
fn files_of_fem_form_no_circle() {
    assert_no_circle("fem/src");
}

#[test]
fn files_of_acoustics_form_no_circle() {
    assert_no_circle("acoustics/src");
}

#[test]
fn files_of_the_program_form_no_circle() {
    assert_no_circle("src");
}

#[test]
fn files_of_the_python_module_form_no_circle() {
    assert_no_circle("python/src");
}

/// Number of dependency cycles in a crate with these files.
fn circles_of(files: &[(&str, &str)]) -> usize {
    let files = files
        .iter()
        .map(|(path, text)| (PathBuf::from(path), (*text).to_owned()));
    circles(&Crate::new(&files.collect::<Sources>()).arrows()).len()
}

#[test]
fn a_circle_through_a_mod_file_would_be_found() {
    let gathers = |own: &str| {
        circles_of(&[
            ("lib.rs", "mod a;"),
            ("a/mod.rs", &format!("mod b; pub use b::f; pub struct S; {own}")),
            ("a/b.rs", "use super::S; pub fn f(_: S) {}"),
        ])
    };
    assert_eq!(gathers("use b::g;"), 1);
    assert_eq!(gathers("impl S { fn g(self) { f(self) } }"), 1);
    assert_eq!(gathers(""), 0);
}

#[test]
fn a_circle_through_a_path_in_an_expression_would_be_found() {
    let through = |body: &str| {
        circles_of(&[
            ("lib.rs", "mod a; mod b; mod c;"),
            ("a.rs", &format!("pub fn f() {{ {body} }}")),
            ("b.rs", "use crate::c; pub fn g() { c::h() }"),
            ("c.rs", "pub fn h() { crate::a::f() }"),
        ])
    };
    assert_eq!(through("crate::b::g()"), 1);
    assert_eq!(through("println!(\"{}\", crate::b::g())"), 1);
    assert_eq!(through("let _: crate::b::Type;"), 1);
    assert_eq!(through("other::b::g()"), 0);
}

#[test]
fn a_circle_through_a_reexport_would_be_found() {
    let first = |text: &str| {
        circles_of(&[
            ("lib.rs", "mod a; mod b; pub use b::*; pub use a::f;"),
            ("a.rs", text),
            ("b.rs", "pub struct S; impl S { fn g(self) { crate::f(self) } }"),
        ])
    };
    assert_eq!(first("pub fn f(_: crate::S) {}"), 1);
    assert_eq!(
        first("pub fn f<T>(_: T) {} #[cfg(test)] mod tests { use crate::S; }"),
        0
    );
}

/// Modules of the program that no stage may use.
const ABOVE_STAGES: [&str; 9] = [
    "artifacts",
    "chain",
    "commands",
    "graph",
    "output",
    "report",
    "atomic_write",
    "study",
    "watch",
];

#[test]
fn stages_use_neither_store_nor_graph_nor_commands() {
    let program = library("src");
    let is_stage = |module: &&Names| match &module[..] {
        [first, ..] if first == "stages" => true,
        [model, sources, .., last] => model == "model" && sources == "sources" && last == "sound",
        _ => false,
    };
    for module in program.modules().filter(is_stage) {
        let file = program.file(module).display();
        for item in program.items(module) {
            let first = item.module.first().map_or("", String::as_str);
            assert!(!ABOVE_STAGES.contains(&first), "{file} uses {first}");
            let design = first == "design" && item.name.as_deref() == Some("Design");
            assert!(!design, "{file} takes a whole design");
        }
        // `stages` re-exports the part of the pipeline that they may use: neither graph nor store.
        let gathers = module.len() == 1;
        let pipeline = program.foreign(module).iter().any(|name| name == "nailnoise_pipeline");
        assert!(gathers || !pipeline, "{file} uses the pipeline directly");
    }
}

/// Quoted names of sources that mean something else, by file and name: keys of designs, bodies, headings, labels.
const OTHER_NAMES: &[(&str, &[&str], &str)] = &[
    (
        "src/calibration/quantity_reader.rs",
        &["body"],
        "a key of a measurement, a block",
    ),
    ("src/commands/assembly/check.rs", &["body"], "a heading"),
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
    (
        "src/stages/cycle/of_assembly.rs",
        &["workpiece"],
        "a body of an assembly",
    ),
    ("src/output", &["body"], "headings"),
    ("src/report", &["workpiece", "body"], "headings"),
    (
        "src/stages/bodies",
        &["workpiece", "body"],
        "names of bodies and of a stage",
    ),
    ("src/study/groups.rs", &["body"], "a group of inputs"),
    ("src/commands/stage_words.rs", &["body"], "a stage"),
];

#[test]
fn no_file_outside_its_own_names_a_source() {
    let root = Path::new(ROOT);
    let mut found = BTreeSet::new();
    // A file `tests.rs` is a module of tests, as the part of a file after `#[cfg(test)]` is.
    let is_tests = |path: &Path| path.file_name().is_some_and(|own| own == "tests.rs");
    for (path, text) in sources(&root.join("src"))
        .into_iter()
        .filter(|(path, _)| !is_tests(path))
    {
        let code = text.split("#[cfg(test)]").next().unwrap();
        let lines = code.lines().filter(|line| !line.trim_start().starts_with("//"));
        let lines: Vec<&str> = lines.collect();
        let relative = Path::new("src").join(path);
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
fn unit(module: &Names) -> Option<String> {
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

/// The crates of the workspace that a unit depends on, if it is a crate.
fn crates_below(unit: &str) -> Vec<String> {
    let Ok(manifest) = fs::read_to_string(Path::new(ROOT).join(unit).join("Cargo.toml")) else {
        return Vec::new();
    };
    let own = manifest
        .lines()
        .filter_map(|line| line.strip_prefix("nailnoise-")?.split('.').next());
    own.flat_map(|name| [vec![name.to_owned()], crates_below(name)].concat())
        .collect()
}

#[test]
fn the_code_in_a_stages_key_is_that_of_all_it_uses() {
    let program = library("src");
    // Crates of the workspace and other units that each unit uses.
    let mut used: BTreeMap<String, BTreeSet<String>> = BTreeMap::new();
    for module in program.modules() {
        let Some(own) = unit(module) else { continue };
        let units = used.entry(own).or_default();
        let foreign = program.foreign(module);
        units.extend(
            foreign
                .iter()
                .filter_map(|name| name.strip_prefix("nailnoise_").map(str::to_owned)),
        );
        units.extend(program.items(module).iter().filter_map(|item| unit(&item.module)));
    }
    let (mut lists, mut wrong) = (0, Vec::new());
    for module in program.modules() {
        let Some(own) = unit(module) else { continue };
        let file = program.file(module);
        let text = fs::read_to_string(Path::new(ROOT).join("src").join(file)).unwrap();
        for named in named_units(&text) {
            lists += 1;
            let mut needed = BTreeSet::from([own.clone()]);
            let mut open = vec![own.clone()];
            while let Some(unit) = open.pop() {
                for next in used.get(&unit).into_iter().flatten() {
                    if needed.insert(next.clone()) {
                        open.push(next.clone());
                    }
                }
            }
            // The digest of a crate includes those of the crates below it.
            let below: BTreeSet<String> = named.iter().flat_map(|unit| crates_below(unit)).collect();
            let missing: Vec<_> = needed
                .iter()
                .filter(|unit| !named.contains(*unit) && !below.contains(*unit))
                .collect();
            if !missing.is_empty() {
                wrong.push(format!("{}: code! lacks {missing:?}", file.display()));
            }
        }
    }
    assert_eq!(wrong, Vec::<String>::new());
    assert!(lists > 10, "{lists} lists found");
}
