//! `nailnoise completions`: completion of commands in a shell.

use std::path::{Path, PathBuf};

use clap::builder::{PossibleValue, PossibleValuesParser};
use clap::{Args, Command};
use clap_complete::{Generator as _, Shell};

use super::user_folders::{config, data};
use super::{Status, print};
use crate::atomic_write;
use crate::design::{Design, Entry};
use crate::error::Error;
use crate::shipped;

#[derive(Args)]
#[command(after_help = examples!(
    "nailnoise completions --install" => "for the shell that you use",
    "nailnoise completions zsh" => "prints those of zsh",
))]
pub(super) struct Arguments {
    /// The shell [default: the one that SHELL names]
    shell: Option<Shell>,
    /// Write them where the shell looks for them, instead of printing them
    #[arg(long)]
    install: bool,
    /// Write them into this folder
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
}

pub(super) fn execute(arguments: &Arguments, program: &mut Command) -> Result<Status, Error> {
    let shell = arguments.shell.or_else(Shell::from_env).ok_or(Error::NoShell)?;
    let mut named = with_names(program.clone())?;
    let mut text = Vec::new();
    clap_complete::generate(shell, &mut named, "nailnoise", &mut text);
    if shell == Shell::Bash {
        text.extend_from_slice(BASH.as_bytes());
    }
    if !arguments.install && arguments.out.is_none() {
        print(&String::from_utf8_lossy(&text))?;
        return Ok(Status::SUCCESS);
    }
    let folder = match &arguments.out {
        Some(folder) => folder.clone(),
        None => folder(shell)?,
    };
    let path = folder.join(shell.file_name("nailnoise"));
    atomic_write::write(&path, &text)?;
    print(&format!("{}{}\n", path.display(), remark(shell, &path)))?;
    Ok(Status::SUCCESS)
}

/// Leaves the cursor behind a completed `KEY=`, where the value follows.
const BASH: &str = r#"
_nailnoise_keys() {
    _nailnoise "$@"
    if [[ ${#COMPREPLY[@]} -eq 1 && ${COMPREPLY[0]} == *= ]]; then
        compopt -o nospace
    fi
}
complete -F _nailnoise_keys -o bashdefault -o default nailnoise
"#;

/// The program with the words that its options take: keys of a design for `--set` and `--vary`, designs that come with
/// the program for `--from`.
fn with_names(program: Command) -> Result<Command, Error> {
    let (path, text) = shipped::DESIGNS[0];
    let design = Design::parse(text, path)?;
    // The names of options live as long as the process, which writes them once and ends.
    let key = |entry: Entry| -> &'static str { Box::leak(format!("{}=", entry.key).into_boxed_str()) };
    let keys: Vec<&str> = design.entries().into_iter().map(key).collect();
    let designs: Vec<&str> = shipped::names().collect();
    Ok(named(program, &[("set", &keys), ("vary", &keys), ("from", &designs)]))
}

/// A command whose options, and those of its subcommands, have these values to choose from.
fn named(mut command: Command, words: &[(&str, &[&'static str])]) -> Command {
    let own: Vec<String> = command.get_arguments().map(|own| own.get_id().to_string()).collect();
    for (option, words) in words.iter().filter(|(option, _)| own.iter().any(|own| own == option)) {
        let values = words.iter().copied().map(PossibleValue::new).collect::<Vec<_>>();
        command = command.mut_arg(option, |argument| {
            argument.value_parser(PossibleValuesParser::new(values))
        });
    }
    let children: Vec<String> = command.get_subcommands().map(|own| own.get_name().to_owned()).collect();
    children.into_iter().fold(command, |command, child| {
        command.mut_subcommand(child, |own| named(own, words))
    })
}

/// Folder of a user's completions, either the shell's default or one that can be set.
fn folder(shell: Shell) -> Result<PathBuf, Error> {
    let what = "the completions of this shell";
    Ok(match shell {
        Shell::Bash => data(what)?.join("bash-completion").join("completions"),
        Shell::Fish => config(what)?.join("fish").join("completions"),
        Shell::Zsh => data(what)?.join("zsh").join("site-functions"),
        Shell::Elvish => config(what)?.join("elvish").join("lib"),
        _ => config(what)?.join("powershell"),
    })
}

/// The remaining step for the user.
fn remark(shell: Shell, path: &Path) -> String {
    let folder = path.parent().unwrap_or(Path::new("")).display();
    match shell {
        Shell::Bash => ": bash finds them in new terminals, if its package bash-completion is installed".to_owned(),
        Shell::Fish => ": fish finds them in new terminals".to_owned(),
        Shell::Zsh => format!("\n  write into ~/.zshrc, before compinit:  fpath=({folder} $fpath)"),
        Shell::Elvish => "\n  write into rc.elv:  use nailnoise".to_owned(),
        _ => format!("\n  write into the file $PROFILE:  . \"{}\"", path.display()),
    }
}
