//! Inputs of a cycle given as a network: the assembly of a file and its numerical settings.

use std::collections::BTreeMap;
use std::path::Path;

use nailnoise_dynamics::network::{AssemblyText, KeyValue, Numerics, Resolved};
use nailnoise_quantities::Group as _;
use nailnoise_quantities::dimension::{DAMPING, STIFFNESS};

use crate::design::{Assignment, Design, LoadedAssembly, refused_assembly};
use crate::error::Error;
use crate::model::supports;

/// A tool that a file describes as an assembly.
#[derive(Debug)]
pub struct AssembledTool {
    /// Name of the file without folder and extension.
    pub name: String,
    /// The assembly as text.
    pub text: AssemblyText,
    /// The assembly with its literals and keys.
    pub resolved: Resolved,
    /// How the cycle is integrated and sampled.
    pub numerics: Numerics,
}

impl AssembledTool {
    /// Reads the assembly of a file, with other values for some keys; `None` if neither the file nor its bases have a
    /// table `[cycle]`.
    ///
    /// # Errors
    /// [`Error::Design`] with place and remedy.
    pub fn load(path: &Path, assignments: &[Assignment]) -> Result<Option<Self>, Error> {
        let Some(loaded) = Design::load_assembly(path, assignments)? else {
            return Ok(None);
        };
        let (text, keys, numerics) = match loaded {
            LoadedAssembly::Alone(text) => (text, BTreeMap::new(), Numerics::default()),
            LoadedAssembly::OfDesign(design) => {
                let Some(text) = design.assembly().cloned() else {
                    return Ok(None);
                };
                let numerics = Numerics {
                    relative_tolerance: design.analysis.cycle_tolerance,
                    sample_interval: Some(design.analysis.time_step),
                    ..Numerics::default()
                };
                (text, keys(&design)?, numerics)
            }
        };
        let resolved = text.resolve(&keys).map_err(refused_assembly)?;
        let name = path
            .file_stem()
            .map_or_else(String::new, |stem| stem.to_string_lossy().into_owned());
        Ok(Some(Self {
            name,
            text,
            resolved,
            numerics,
        }))
    }
}

/// Values of all keys of a design, with `support.stiffness` and `support.damping` set to those of the chosen support.
fn keys(design: &Design) -> Result<BTreeMap<String, KeyValue>, Error> {
    let mut keys = BTreeMap::new();
    design.visit("", &mut |path, spec, value| {
        keys.insert(path.to_owned(), KeyValue::of(spec, &value));
    });
    let support = supports::of(design).lumped()?;
    let damping = support.dashpot(design.workpiece.block.mass(design.wood.density));
    for (path, si, dimension) in [
        ("support.stiffness", support.stiffness, STIFFNESS),
        ("support.damping", damping, DAMPING),
    ] {
        keys.insert(path.to_owned(), KeyValue::Quantity { si, dimension });
    }
    Ok(keys)
}
