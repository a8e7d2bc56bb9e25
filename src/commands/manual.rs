//! `nailnoise manual`: the manual pages of all commands.

use std::path::PathBuf;

use clap::{Args, Command};
use clap_mangen::Man;

use super::user_folders::{beside_the_program, data};
use super::{Status, print};
use crate::error::Error;
use crate::staging::Staging;

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
    if !arguments.install && arguments.out.is_none() {
        let mut page = &program;
        for name in &arguments.command {
            page = page
                .find_subcommand(name)
                .ok_or_else(|| Error::NoSuchCommand { name: name.clone() })?;
        }
        print(&String::from_utf8_lossy(&render(page)))?;
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
    let staging = Staging::within(&folder)?;
    let mut count = 0;
    let mut open = vec![&program];
    while let Some(command) = open.pop() {
        staging.write(name(command).as_ref(), &render(command))?;
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

/// `nailnoise-prf-fit.1`.
fn name(command: &Command) -> String {
    Man::new(command.clone()).get_filename()
}

fn render(command: &Command) -> Vec<u8> {
    let mut page = Vec::new();
    // Writing to memory cannot fail.
    let _ = Man::new(command.clone()).render(&mut page);
    page
}
