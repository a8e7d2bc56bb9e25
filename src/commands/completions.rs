//! `nailnoise completions`: completion of commands in a shell.

use std::path::{Path, PathBuf};

use clap::{Args, Command};
use clap_complete::{Generator as _, Shell};

use super::user_folders::{config, data};
use super::{Status, print};
use crate::error::Error;
use crate::staging;

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
    let mut text = Vec::new();
    clap_complete::generate(shell, program, "nailnoise", &mut text);
    if !arguments.install && arguments.out.is_none() {
        print(&String::from_utf8_lossy(&text))?;
        return Ok(Status::SUCCESS);
    }
    let folder = match &arguments.out {
        Some(folder) => folder.clone(),
        None => folder(shell)?,
    };
    let path = folder.join(shell.file_name("nailnoise"));
    staging::write(&path, &text)?;
    print(&format!("{}{}\n", path.display(), remark(shell, &path)))?;
    Ok(Status::SUCCESS)
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
