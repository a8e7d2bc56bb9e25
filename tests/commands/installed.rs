//! The program without the repository, as `cargo install` leaves it: its designs, completions, manual pages and version
//! are in it.

use std::fs;
use std::path::Path;
use std::process::{Command, Output};

use crate::common::{command, folder, json, messages};

/// The command in a folder of the user, without the repository.
fn alone(folder: &Path, arguments: &[&str]) -> Output {
    let mut command = command(arguments);
    for name in ["XDG_DATA_HOME", "XDG_CONFIG_HOME", "MANPATH"] {
        command.env_remove(name);
    }
    command.current_dir(folder).env("HOME", folder).output().unwrap()
}

fn printed(output: &Output) -> String {
    assert!(output.status.success(), "{}", messages(output));
    String::from_utf8(output.stdout.clone()).unwrap()
}

#[test]
fn a_shipped_design_is_written_and_works() {
    let folder = folder("installed-init");
    let text = printed(&alone(&folder, &["init", "--from", "muffler", "quieter.toml"]));
    assert!(text.contains("quieter.toml") && text.contains("n80cb.toml"), "{text}");
    let result = json(&alone(&folder, &["cycle", "quieter.toml", "--json"]));
    assert_eq!(result["outcome"], "drives");
    let again = alone(&folder, &["init", "--from", "muffler", "quieter.toml"]);
    assert_eq!(again.status.code(), Some(2));
    let base = alone(&folder, &["init", "--from", "on-worktable", "n80cb.toml"]);
    assert_eq!(
        base.status.code(),
        Some(2),
        "a design does not take the place of its base"
    );
    let unknown = alone(&folder, &["init", "--from", "n80"]);
    assert!(unknown.status.code() == Some(2) && messages(&unknown).contains("n80cb-sandbox"));
}

#[test]
fn a_base_that_is_not_there_is_that_of_the_program_and_a_warning_says_so() {
    let folder = folder("installed-base");
    fs::write(
        folder.join("own.toml"),
        "base = \"n80cb-sandbox.toml\"\nexhaust.holes = 4\n",
    )
    .unwrap();
    let output = alone(&folder, &["cycle", "own.toml", "--json"]);
    let own = json(&output);
    let told = messages(&output).split_whitespace().collect::<Vec<_>>().join(" ");
    assert!(
        told.contains("it is the one that comes with") && told.contains("init --from n80cb-sandbox"),
        "{told}"
    );
    // Beside the design it is the same, without a warning.
    printed(&alone(&folder, &["init", "--from", "n80cb-sandbox"]));
    let output = alone(&folder, &["cycle", "own.toml", "--json"]);
    assert_eq!(json(&output)["design"], own["design"]);
    assert!(!messages(&output).contains("comes with"), "{}", messages(&output));
    // An existing file counts, even a broken one; a file that is not in the program is reported as missing.
    fs::write(folder.join("n80cb-sandbox.toml"), "base = ").unwrap();
    assert_eq!(alone(&folder, &["cycle", "own.toml", "--json"]).status.code(), Some(2));
    fs::write(folder.join("own.toml"), "base = \"n80bc.toml\"\n").unwrap();
    assert_eq!(alone(&folder, &["cycle", "own.toml", "--json"]).status.code(), Some(2));
}

#[test]
fn completions_are_installed_where_the_shell_looks() {
    let folder = folder("installed-completions");
    for (shell, place) in [
        ("bash", ".local/share/bash-completion/completions/nailnoise.bash"),
        ("fish", ".config/fish/completions/nailnoise.fish"),
        ("zsh", ".local/share/zsh/site-functions/_nailnoise"),
    ] {
        let text = printed(&alone(&folder, &["completions", shell, "--install"]));
        let path = folder.join(place);
        assert!(text.contains(path.to_str().unwrap()), "{text}");
        let written = fs::read_to_string(path).unwrap();
        assert_eq!(written, printed(&alone(&folder, &["completions", shell])));
        // Bash and zsh write options with their hyphens, fish without.
        assert!(written.contains("watch") && written.contains("threads"), "{shell}");
        // Words of `--set`, and of `init --from`.
        assert!(
            written.contains("supply.pressure=") && written.contains("n80cb-sandbox"),
            "{shell}"
        );
    }
}

#[test]
fn every_command_has_a_manual_page() {
    let folder = folder("installed-manual");
    let text = printed(&alone(&folder, &["manual", "--install"]));
    let pages = folder.join(".local/share/man/man1");
    assert!(text.contains(pages.to_str().unwrap()), "{text}");
    for name in [
        "nailnoise",
        "nailnoise-run",
        "nailnoise-watch",
        "nailnoise-penetration-fit",
        "nailnoise-cache-verify",
    ] {
        let page = fs::read_to_string(pages.join(name).with_extension("1")).unwrap();
        assert!(
            page.contains(".TH nailnoise") && page.contains(".SH OPTIONS"),
            "{name}: {page}"
        );
    }
    let page = printed(&alone(&folder, &["manual", "penetration", "fit"]));
    assert_eq!(
        page,
        fs::read_to_string(pages.join("nailnoise-penetration-fit.1")).unwrap()
    );
    for part in [
        ".SH EXAMPLES",
        "nailnoise penetration fit",
        ".SH \"EXIT STATUS\"",
        "a numerical check failed",
    ] {
        assert!(page.contains(part), "{part}: {page}");
    }
    assert_eq!(alone(&folder, &["manual", "nothing"]).status.code(), Some(2));
}

#[test]
fn the_version_says_what_was_built() {
    let folder = folder("installed-version");
    let short = printed(&alone(&folder, &["-V"]));
    assert_eq!(short, format!("nailnoise {}\n", env!("CARGO_PKG_VERSION")));
    let long = printed(&alone(&folder, &["--version"]));
    assert!(long.starts_with(short.trim_end()), "{long}");
    for part in ["commit: ", "sources (SHA-256): ", "build: ", "target: ", "features: "] {
        assert!(long.contains(part), "no {part} in {long}");
    }
    assert!(long.contains(std::env::consts::ARCH), "{long}");
}

#[test]
fn quiet_prints_no_notes() {
    let folder = folder("installed-quiet");
    let arguments = [
        "prf",
        "law",
        "--law",
        "smooth",
        "--wood",
        "pine",
        "--nail",
        "8d",
        "--speed",
        "500 mm/min",
    ];
    let loud = alone(&folder, &arguments);
    assert!(messages(&loud).contains("note:"), "{}", messages(&loud));
    let quiet = alone(&folder, &[&arguments[..], &["--quiet"]].concat());
    assert_eq!((messages(&quiet).as_str(), printed(&quiet)), ("", printed(&loud)));
    let small = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/data/small.toml");
    let run = ["run", small.to_str().unwrap(), "--out", "out"];
    let loud = printed(&alone(&folder, &run));
    let quiet = alone(&folder, &[&run[..], &["--quiet"]].concat());
    assert_eq!(messages(&quiet), "");
    let quiet = printed(&quiet);
    assert!(
        loud.contains("\n  - the nail is driven") && !quiet.contains("\n  - "),
        "{quiet}"
    );
    assert!(quiet.contains("checks ok"), "{quiet}");
}

/// Manual pages are roff that man renders without a complaint, if man is there.
#[test]
fn man_renders_the_pages() {
    let folder = folder("installed-man");
    printed(&alone(&folder, &["manual", "--out", "pages"]));
    let page = folder.join("pages/nailnoise-run.1");
    let Ok(output) = Command::new("groff")
        .args(["-man", "-Tutf8", "-ww", "-P-cbou"])
        .arg(page)
        .output()
    else {
        return;
    };
    let text = String::from_utf8_lossy(&output.stdout).into_owned();
    assert!(output.status.success() && text.contains("--components"), "{text}");
}
