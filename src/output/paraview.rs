//! `paraview.py` and `film.py`: scripts that open the fields of a run and play its film in ParaView.

use super::Output;

/// The script that opens the fields.
pub(super) const SCRIPT: Output = Output::of_run("paraview.py", |_| Ok(include_bytes!("paraview.py").to_vec()));

/// The script that plays the film.
pub(super) const FILM: Output =
    Output::of_run("film.py", |_| Ok(include_bytes!("film.py").to_vec())).only_if(|of| of.exports.films);
