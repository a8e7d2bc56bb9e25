//! Folders of the user, according to the XDG Base Directory Specification; on Windows according to its own variables.

use std::env;
use std::path::{Path, PathBuf};

use crate::error::Error;

/// Folder for data of a user: `$XDG_DATA_HOME`, else `~/.local/share`.
pub(super) fn data(what: &'static str) -> Result<PathBuf, Error> {
    find(what, "XDG_DATA_HOME", "LOCALAPPDATA", &[".local", "share"])
}

/// Folder for settings of a user: `$XDG_CONFIG_HOME`, else `~/.config`.
pub(super) fn config(what: &'static str) -> Result<PathBuf, Error> {
    find(what, "XDG_CONFIG_HOME", "APPDATA", &[".config"])
}

fn find(
    what: &'static str,
    variable: &'static str,
    on_windows: &'static str,
    below_home: &[&str],
) -> Result<PathBuf, Error> {
    let set = |name: &str| env::var_os(name).map(PathBuf::from).filter(|path| path.is_absolute());
    let of_system = || if cfg!(windows) { set(on_windows) } else { None };
    let at_home = || Some(set("HOME")?.join(below_home.iter().collect::<PathBuf>()));
    let found = set(variable).or_else(of_system).or_else(at_home);
    found.ok_or(Error::NoUserFolder { what, variable })
}

/// The folder `share` next to the folder `bin` that contains this program, if any.
pub(super) fn beside_the_program() -> Option<PathBuf> {
    let program = env::current_exe().ok()?;
    let bin = program.parent().filter(|folder| folder.ends_with("bin"))?;
    bin.parent().map(|above: &Path| above.join("share"))
}
