//! `paraview.py`: the script that opens the fields of a run in ParaView.

use super::Output;

/// The script.
pub(super) const SCRIPT: Output = Output::of_run("paraview.py", |_| Ok(include_bytes!("paraview.py").to_vec()));
