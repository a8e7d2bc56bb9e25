//! The designs in README and documentation meet the expectation of a reader: they drive their nail.

use std::path::{Path, PathBuf};

use nailnoise::{Design, Error, chain};

use crate::common::folder;

/// Files that a page instructs its reader to make, but that a test does not have.
const OF_THE_READER: [&str; 1] = ["out/prf-fit/fit.toml"];

/// README and all pages, by their paths from the root.
fn pages(root: &Path) -> Vec<PathBuf> {
    let docs = std::fs::read_dir(root.join("docs")).unwrap();
    let mut pages: Vec<PathBuf> = docs.map(|entry| entry.unwrap().path()).collect();
    pages.retain(|page| page.extension().is_some_and(|own| own == "md"));
    pages.push(root.join("README.md"));
    pages.sort();
    pages
}

/// Blocks of TOML that name a base, with their lines, other than those of an assembly (`assembly.rs`).
fn designs(text: &str) -> Vec<(usize, String)> {
    let mut found = Vec::new();
    let mut block: Option<(usize, String)> = None;
    for (number, line) in text.lines().enumerate() {
        match &mut block {
            None if line.starts_with("```toml") => block = Some((number + 1, String::new())),
            None => {}
            Some(_) if line.starts_with("```") => found.extend(block.take()),
            Some((_, text)) => {
                text.push_str(line);
                text.push('\n');
            }
        }
    }
    found.retain(|(_, text)| text.lines().any(|line| line.starts_with("base = ")) && !text.contains("[cycle"));
    found
}

/// The outcome that a block states in a comment `# outcome: WORD`; an example drives by default.
fn expected(block: &str) -> &str {
    let stated = block.lines().find_map(|line| line.strip_prefix("# outcome: "));
    stated.map_or("drives", str::trim)
}

#[test]
fn every_documented_design_ends_as_its_page_says() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let folder = folder("documented-designs");
    std::fs::create_dir_all(folder.join("designs")).unwrap();
    std::fs::copy(root.join("designs/n80cb.toml"), folder.join("designs/n80cb.toml")).unwrap();
    // The design of the reader, as `nailnoise init` begins it.
    std::fs::write(folder.join("my-tool.toml"), "base = \"n80cb.toml\"\n").unwrap();
    // The housing that a page instructs its reader to draw: the cycle reads no mesh.
    std::fs::write(folder.join("housing.step"), "").unwrap();
    let file = folder.join("example.toml");
    let mut computed = 0;
    for page in pages(root) {
        for (line, block) in designs(&std::fs::read_to_string(&page).unwrap()) {
            std::fs::write(&file, &block).unwrap();
            let place = format!("{}:{line}", page.strip_prefix(root).unwrap().display());
            let record = Design::load(&file)
                .map_err(Error::from)
                .and_then(|design| chain::cycle(&design));
            match record {
                Ok(record) => assert_eq!(record.figures.outcome.name(), expected(&block), "{place}\n{block}"),
                Err(error) => {
                    let own = OF_THE_READER.iter().find(|own| block.contains(**own));
                    assert!(
                        own.is_some_and(|own| error.to_string().contains(own)),
                        "{place}: {error}"
                    );
                    continue;
                }
            }
            computed += 1;
        }
    }
    assert!(computed >= 7, "{computed} designs found");
}

#[test]
fn a_block_states_another_outcome_in_a_comment() {
    let page = "```toml\nbase = \"a.toml\"\n# outcome: underdriven\n```\n\n```toml\nkey = 1\n```\n```toml x\nbase \
        = \"b\"\n```";
    let found = designs(page);
    let lines: Vec<usize> = found.iter().map(|(line, _)| *line).collect();
    assert_eq!(lines, [1, 9]);
    assert_eq!(
        [expected(&found[0].1), expected(&found[1].1)],
        ["underdriven", "drives"]
    );
}
