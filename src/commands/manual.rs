//! `nailnoise manual`: the manual pages of all commands.

use std::path::PathBuf;

use clap::{Args, Command};
use clap_mangen::Man;

use super::user_folders::{beside_the_program, data};
use super::{Status, print};
use crate::atomic_write::AtomicWrite;
use crate::error::Error;

#[derive(Args)]
#[command(after_help = examples!(
    "nailnoise manual --install" => "then: man nailnoise, man nailnoise-run",
    "nailnoise manual prf fit | man -l -" => "one page, without installing any",
))]
pub(super) struct Arguments {
    /// The command whose page is printed [default: the program as a whole]
    #[arg(value_name = "COMMAND")]
    command: Vec<String>,
    /// Write all pages where `man` looks for those of this program: in `share` beside the folder `bin` that holds it,
    /// else in the user's
    #[arg(long, conflicts_with = "command")]
    install: bool,
    /// Write all pages into this folder
    #[arg(long, value_name = "DIR", conflicts_with = "command")]
    out: Option<PathBuf>,
}

pub(super) fn execute(arguments: &Arguments, program: Command) -> Result<Status, Error> {
    let mut program = program.disable_help_subcommand(true);
    program.build();
    let status = status_of(&program);
    if !arguments.install && arguments.out.is_none() {
        let mut page = &program;
        for name in &arguments.command {
            page = page
                .find_subcommand(name)
                .ok_or_else(|| Error::NoSuchCommand { name: name.clone() })?;
        }
        print(&String::from_utf8_lossy(&render(page, &status)))?;
        return Ok(Status::SUCCESS);
    }
    let folder = match &arguments.out {
        Some(folder) => folder.clone(),
        None => match beside_the_program() {
            Some(share) => share,
            None => data("manual pages")?,
        }
        .join("man")
        .join("man1"),
    };
    let staging = AtomicWrite::within(&folder)?;
    let mut count = 0;
    let mut open = vec![&program];
    while let Some(command) = open.pop() {
        staging.write(name(command).as_ref(), &render(command, &status))?;
        count += 1;
        open.extend(command.get_subcommands().filter(|own| !own.is_hide_set()));
    }
    let first = name(&program);
    staging.place(&[], first.as_ref())?;
    print(&format!(
        "{count} pages in {}\n  `man nailnoise` shows the first; if it is not found, add the folder above man1 to \
         MANPATH\n",
        folder.display()
    ))?;
    Ok(Status::SUCCESS)
}

/// `nailnoise-penetration-fit.1`.
fn name(command: &Command) -> String {
    Man::new(command.clone()).get_filename()
}

/// The page of a command: the sections of its help, then examples and the exit status of the program.
fn render(command: &Command, status: &str) -> Vec<u8> {
    let man = Man::new(command.clone());
    let mut page = Vec::new();
    let mut write = || -> std::io::Result<()> {
        man.render_title(&mut page)?;
        man.render_name_section(&mut page)?;
        man.render_synopsis_section(&mut page)?;
        man.render_description_section(&mut page)?;
        man.render_options_section(&mut page)?;
        if command.get_subcommands().any(|own| !own.is_hide_set()) {
            man.render_subcommands_section(&mut page)?;
        }
        page.extend(examples(command).into_bytes());
        page.extend(exit_status(status).into_bytes());
        if command.get_version().is_some() {
            man.render_version_section(&mut page)?;
        }
        Ok(())
    };
    // Writing to memory cannot fail.
    let _ = write();
    page
}

/// The section with the examples of a help text: lines with a command, each followed by its purpose.
fn examples(command: &Command) -> String {
    let help = command.get_after_help().map(ToString::to_string).unwrap_or_default();
    let (examples, _) = help.split_once(STATUS).unwrap_or((&help, ""));
    let mut lines = examples
        .lines()
        .skip(1)
        .filter(|line| !line.trim().is_empty())
        .peekable();
    if lines.peek().is_none() {
        return String::new();
    }
    let mut section = ".SH EXAMPLES\n".to_owned();
    for line in lines {
        match line.starts_with("      ") {
            true => section.push_str(&format!("{}\n", escaped(line.trim()))),
            false => section.push_str(&format!(".TP\n\\fB{}\\fR\n", escaped(line.trim()))),
        }
    }
    section
}

/// Text before the exit status in the help of the program.
const STATUS: &str = "Exit status: ";

/// The exit status in the help of the program: codes with their meanings, `0 done; 1 ...`.
fn status_of(program: &Command) -> String {
    let help = program.get_after_help().map(ToString::to_string).unwrap_or_default();
    help.split_once(STATUS)
        .map_or_else(String::new, |(_, codes)| codes.trim_end_matches('.').to_owned())
}

/// The section with the meanings of the exit status.
fn exit_status(status: &str) -> String {
    let codes = status.split("; ").filter_map(|own| own.split_once(' '));
    let paragraph = |(code, meaning): (&str, &str)| format!(".TP\n\\fB{code}\\fR\n{}\n", escaped(meaning));
    format!(".SH \"EXIT STATUS\"\n{}", codes.map(paragraph).collect::<String>())
}

/// A line of text that `man` shows as it is.
fn escaped(text: &str) -> String {
    let text = text.replace('\\', "\\e").replace('-', "\\-").replace('\'', "\\(aq");
    match text.starts_with('.') {
        true => format!("\\&{text}"),
        false => text,
    }
}
