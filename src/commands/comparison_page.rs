//! The file of a comparison page: its name follows from the compared files and does not collide with other comparisons.

use std::fs::File;
use std::io::Read as _;
use std::path::{Path, PathBuf};

use sha2::{Digest as _, Sha256};

use crate::report::compared_by;
use crate::wording::hexadecimal;

/// Longest name without extension \[bytes\]; file systems allow 255.
const LONGEST: usize = 120;

/// Number of bytes at the start of a page that identify the compared files.
const BEGINNING: u64 = 4096;

/// Digest of the compared files in order; repeating the comparison yields the same digest.
pub(super) fn identity(paths: &[PathBuf]) -> String {
    let mut digest = Sha256::new();
    for path in paths {
        let path = path.canonicalize().unwrap_or_else(|_| path.clone());
        digest.update(path.as_os_str().as_encoded_bytes());
        digest.update([0]);
    }
    hexadecimal(&digest.finalize())
}

/// `OUT/compare-A-B.html`, with a number appended if the page of a different comparison has this name.
pub(super) fn place(out: &Path, designs: &[String], identity: &str) -> PathBuf {
    let stem = stem(designs);
    let names = (1..).map(|number: u32| match number {
        1 => format!("{stem}.html"),
        _ => format!("{stem}-{number}.html"),
    });
    let mut paths = names.map(|name| out.join(name));
    let free = paths.find(|path| path.symlink_metadata().is_err() || is_of(path, identity));
    free.unwrap_or_else(|| out.join("compare.html"))
}

/// Makes a file name that is valid on all systems. A result read from a file may have any design name.
fn stem(designs: &[String]) -> String {
    let safe = |c: char| {
        if c.is_alphanumeric() || "-_.+".contains(c) {
            c
        } else {
            '_'
        }
    };
    let mut stem = String::from("compare");
    for c in designs.iter().flat_map(|name| std::iter::once('-').chain(name.chars())) {
        if stem.len() + c.len_utf8() > LONGEST {
            break;
        }
        stem.push(safe(c));
    }
    stem
}

fn is_of(path: &Path, identity: &str) -> bool {
    let mut beginning = Vec::new();
    // Only regular files can be read without blocking.
    let read =
        path.is_file() && File::open(path).is_ok_and(|file| file.take(BEGINNING).read_to_end(&mut beginning).is_ok());
    read && String::from_utf8_lossy(&beginning).contains(&compared_by(identity).into_string())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn names(names: &[&str]) -> Vec<String> {
        names.iter().map(|name| (*name).to_owned()).collect()
    }

    #[test]
    fn a_page_is_named_after_its_designs() {
        assert_eq!(stem(&names(&["n80cb", "n80cb-sandbox"])), "compare-n80cb-n80cb-sandbox");
    }

    #[test]
    fn no_name_of_a_design_leaves_the_folder() {
        let stem = stem(&names(&["../../etc", "a/b\\c:d\n"]));
        assert_eq!(stem, "compare-.._.._etc-a_b_c_d_");
    }

    #[test]
    fn a_name_is_short_enough_for_a_file_system() {
        let long = stem(&vec!["\u{e9}".repeat(90); 3]);
        assert!((LONGEST - 2..=LONGEST).contains(&long.len()), "{}", long.len());
    }
}
