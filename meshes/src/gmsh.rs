//! Meshes new geometry with the gmsh command (C. Geuzaine and J.-F. Remacle, 2009). gmsh is not needed for anything
//! else.

use std::path::{Path, PathBuf};
use std::process::{Command, Output};

use crate::child;
use crate::msh::{self, Imported};
use crate::temporary::TemporaryFolder;
use crate::{FaceGroup, FaceRef, Mesh, MeshError, Surface};

/// Environment variable that names the gmsh program.
const PROGRAM: &str = "NAILNOISE_GMSH";

/// Prefix of gmsh's working folders.
const FOLDER: &str = "nailnoise-gmsh-";

/// A meshing task for gmsh.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Job<'a> {
    /// Name used in messages.
    pub(crate) what: String,
    /// The script.
    pub(crate) script: &'a str,
    /// Constants defined for the script.
    pub(crate) constants: Vec<(&'static str, f64)>,
    /// A geometry file that the script opens, and the name under which it is copied next to the script.
    pub(crate) beside: Option<(&'a Path, String)>,
    /// Files that the script may write; their contents are returned in [`Made::written`].
    pub(crate) reports: &'static [&'static str],
    /// Limit on the processor time if gmsh repairs folded elements by elastic analogy \[s\]. Without the analogy the
    /// limit is multiplied by [`SHARE_WITHOUT_ANALOGY`]. None means no limit.
    pub(crate) seconds: Option<f64>,
}

/// The script constant that selects how gmsh repairs elements folded by curved sides.
const OPTIMISE: &str = "optimise";

/// How gmsh repairs folded elements: values of `Mesh.HighOrderOptimize` in the order of the attempts.
///
/// The elastic analogy deforms the entire mesh and takes three quarters of gmsh's time, although only about ten of the
/// 8500 elements in half a tool are folded.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum HighOrderOptimization {
    /// None: folded elements are left as they are.
    None = 0,
    /// Optimisation of each folded element together with its neighbours.
    Each = 1,
    /// The elastic analogy, then optimisation.
    Elastic = 2,
}

impl HighOrderOptimization {
    /// The limit on processor time, given the limit with the elastic analogy \[s\], rounded to full seconds.
    fn limit(self, seconds: f64) -> u64 {
        let share = match self {
            Self::None | Self::Each => SHARE_WITHOUT_ANALOGY,
            Self::Elastic => 1.0,
        };
        (share * seconds).ceil() as u64
    }
}

/// Fraction of the time limit that applies without the elastic analogy. The N80CB needs a quarter of the time without
/// it.
pub(crate) const SHARE_WITHOUT_ANALOGY: f64 = 1.0 / 3.0;

/// Version of the gmsh command that would be used.
///
/// # Errors
/// [`MeshError::NoGmsh`].
pub fn version() -> Result<String, MeshError> {
    let program = program();
    let output = start(child::command(&program).arg("--version"), &program)?;
    // gmsh prints its version to standard error.
    let text = [output.stdout, output.stderr].concat();
    Ok(String::from_utf8_lossy(&text).trim().to_owned())
}

/// Whether a gmsh command exists; it is not started.
pub fn is_found() -> bool {
    let program = program();
    let is_file = |path: PathBuf| path.is_file() || path.with_extension(std::env::consts::EXE_EXTENSION).is_file();
    let folders = std::env::var_os("PATH").unwrap_or_default();
    is_file(PathBuf::from(&program)) || std::env::split_paths(&folders).any(|folder| is_file(folder.join(&program)))
}

fn program() -> String {
    std::env::var(PROGRAM)
        .ok()
        .filter(|name| !name.is_empty())
        .unwrap_or_else(|| "gmsh".to_owned())
}

fn start(command: &mut Command, program: &str) -> Result<Output, MeshError> {
    child::output(command).map_err(|error| MeshError::NoGmsh {
        program: program.to_owned(),
        reason: error.to_string(),
    })
}

/// Meshes a script, and repeats it with the elastic analogy if the faster method leaves inverted elements.
pub(crate) fn run(job: &Job<'_>) -> Result<Imported, MeshError> {
    with_fewest_inverted(|optimization| mesh_once(job, optimization))
}

/// Returns the first mesh if none of its elements are inverted, else the one with fewer inverted elements. If the
/// second mesh cannot be made, the first is returned, because straightening sides repairs it.
fn with_fewest_inverted(
    mut made: impl FnMut(HighOrderOptimization) -> Result<Imported, MeshError>,
) -> Result<Imported, MeshError> {
    let quick = made(HighOrderOptimization::Each)?;
    let inverted = quick.mesh.inverted();
    if inverted == 0 {
        return Ok(quick);
    }
    let elastic = made(HighOrderOptimization::Elastic).ok();
    Ok(elastic.filter(|mesh| mesh.mesh.inverted() < inverted).unwrap_or(quick))
}

/// Result of a script.
#[derive(Debug)]
pub(crate) struct Made {
    /// The mesh; none if the script ended before meshing and wrote a report.
    pub(crate) mesh: Option<Imported>,
    /// Contents of each of [`Job::reports`] that was written.
    pub(crate) written: Vec<(&'static str, String)>,
    /// Time taken by gmsh \[s\].
    pub(crate) seconds: f64,
}

/// Runs a script that always produces a mesh.
fn mesh_once(job: &Job<'_>, optimization: HighOrderOptimization) -> Result<Imported, MeshError> {
    let made = made(job, optimization)?;
    made.mesh.ok_or_else(|| MeshError::Gmsh {
        what: job.what.clone(),
        reason: "it wrote no mesh".to_owned(),
    })
}

/// Runs a script in a temporary folder and reads the mesh.
pub(crate) fn made(job: &Job<'_>, optimization: HighOrderOptimization) -> Result<Made, MeshError> {
    let temporary = std::env::temp_dir();
    let folder = TemporaryFolder::new(&temporary, FOLDER).map_err(|source| MeshError::Write {
        path: temporary,
        source,
    })?;
    let at = |name: &str| folder.path().join(name);
    let write =
        |path: PathBuf, bytes: &[u8]| std::fs::write(&path, bytes).map_err(|source| MeshError::Write { path, source });
    write(at("script.geo"), job.script.as_bytes())?;
    if let Some((path, name)) = &job.beside {
        let bytes = std::fs::read(path).map_err(|source| MeshError::Read {
            path: path.to_path_buf(),
            source,
        })?;
        write(at(name), &bytes)?;
    }
    let program = program();
    let mut command = child::command(&program);
    command.current_dir(folder.path());
    // A single thread, because the mesh must be the same on every machine.
    command.args([
        "script.geo",
        "-3",
        "-format",
        "msh41",
        "-bin",
        "-nt",
        "1",
        "-v",
        "2",
        "-o",
        "mesh.msh",
    ]);
    let constant = (OPTIMISE, f64::from(optimization as u8));
    for (name, value) in job.constants.iter().chain([&constant]) {
        command.args(["-setnumber", name, &value.to_string()]);
    }
    let seconds = job.seconds.map(|seconds| optimization.limit(seconds));
    if let Some(seconds) = seconds {
        child::limit(&mut command, seconds);
    }
    let started = std::time::Instant::now();
    let output = start(&mut command, &program)?;
    if let Some(seconds) = seconds.filter(|_| child::ran_out(&output)) {
        return Err(MeshError::OutOfTime {
            what: job.what.clone(),
            seconds,
        });
    }
    let said = String::from_utf8_lossy(&[output.stdout, output.stderr].concat()).into_owned();
    let failed = |reason: String| MeshError::Gmsh {
        what: job.what.clone(),
        reason,
    };
    let report = |name: &&'static str| Some((*name, std::fs::read_to_string(at(name)).ok()?));
    let written: Vec<(&str, String)> = job.reports.iter().filter_map(report).collect();
    let result = at("mesh.msh");
    let fatal = fatal(&said);
    let seconds = started.elapsed().as_secs_f64();
    if fatal.is_none() && !result.exists() && !written.is_empty() {
        return Ok(Made {
            mesh: None,
            written,
            seconds,
        });
    }
    if fatal.is_some() || !result.exists() {
        let reason = match fatal {
            Some(first) => first.to_owned(),
            None => format!("it ended with {} and wrote no mesh", output.status),
        };
        return Err(failed(reason));
    }
    let mut built = msh::read(&result, 1.0).map_err(|error| failed(error.to_string()))?;
    built.mesh.nodes.iter_mut().for_each(|p| *p = p.map(rounded));
    Ok(Made {
        mesh: Some(built),
        written,
        seconds,
    })
}

/// The first error reported by gmsh, without the frame and counts of its summary. gmsh treats an element that remains
/// folded after optimisation as an error, but straightening repairs it.
fn fatal(said: &str) -> Option<&str> {
    let lines = said.lines().filter_map(|line| line.trim().strip_prefix("Error"));
    let mut errors = lines.map(|line| line.trim_start_matches([' ', ':']));
    let of_summary = |line: &str| {
        let count = line.trim_start_matches(|c: char| c.is_ascii_digit());
        let counts = [" warning", " warnings", " error", " errors"];
        line.starts_with(['-', 'M']) || line.starts_with("Check the full log") || counts.contains(&count)
    };
    let mended = |line: &str| line.contains("ptimization failed") || line.contains("critical value");
    errors.find(|line| !line.is_empty() && !of_summary(line) && !mended(line))
}

/// Rounds a length to 2^-26 m (15 nm), so that the compressed mesh that is shipped equals the generated one.
fn rounded(length: f64) -> f64 {
    const GRAIN: f64 = (1 << 26) as f64;
    (length * GRAIN).round() / GRAIN
}

/// Names the outer faces of a mesh by the plane they lie in: `bottom`, `top` or `sides`.
pub fn name_by_height(mesh: &mut Mesh) {
    let (low, high) = mesh.bounds();
    let tolerance = 1e-6 * (high - low).norm();
    let mut groups: [(&str, Vec<FaceRef>); 3] = [("bottom", vec![]), ("top", vec![]), ("sides", vec![])];
    for face in Surface::of(mesh).faces.iter().map(|face| face.of) {
        let nodes = mesh.face_nodes(face);
        let all = |height: f64| nodes.iter().all(|&n| (mesh.nodes[n].z - height).abs() <= tolerance);
        if all(low.z) {
            groups[0].1.push(face);
        } else if all(high.z) {
            groups[1].1.push(face);
        } else {
            groups[2].1.push(face);
        }
    }
    mesh.groups = groups
        .into_iter()
        .filter(|(_, faces)| !faces.is_empty())
        .map(|(name, faces)| FaceGroup {
            name: name.to_owned(),
            faces,
        })
        .collect();
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]

    use super::*;
    use crate::{Block, block};

    /// A cube of one element. Swapping two of its corners inverts it.
    fn cube(inverted: bool, optimization: HighOrderOptimization) -> Imported {
        let mut mesh = block(&Block {
            size: [1.0; 3],
            divisions: [1; 3],
            origin: [0.0; 3],
        })
        .unwrap();
        if inverted {
            mesh.nodes.swap(mesh.connectivity[0], mesh.connectivity[1]);
        }
        Imported {
            comment: format!("{optimization:?}"),
            ..Imported::built(mesh)
        }
    }

    #[test]
    fn the_elastic_analogy_is_for_meshes_that_are_inverted_without_it() {
        for (folded, expected) in [
            (&[][..], "Each"),
            (&[HighOrderOptimization::Each], "Elastic"),
            (&[HighOrderOptimization::Each, HighOrderOptimization::Elastic], "Each"),
        ] {
            let made = with_fewest_inverted(|optimization| Ok(cube(folded.contains(&optimization), optimization)));
            assert_eq!(made.unwrap().comment, expected);
        }
    }

    #[test]
    fn both_scripts_take_the_kind_of_optimization() {
        let (solid, tool) = (include_str!("../geo/solid.geo"), include_str!("../geo/tool.geo"));
        for script in [solid, tool] {
            assert!(script.contains(&format!("{OPTIMISE} = ")));
            assert!(script.contains(&format!("Mesh.HighOrderOptimize = {OPTIMISE};")));
        }
    }

    #[test]
    fn an_attempt_without_the_analogy_has_a_third_of_the_time() {
        assert_eq!(
            [HighOrderOptimization::Each, HighOrderOptimization::Elastic].map(|optimization| optimization.limit(38.5)),
            [13, 39]
        );
    }

    #[test]
    fn a_fold_that_straightening_mends_is_no_error_and_the_summary_is_no_reason() {
        let folded = "Warning : Final volume mesh: worst distortion = -0.1\n\
                      Error   : Failed to reach critical value in pass 1 for measure(s): ScaledJac\n\
                      Error   : Optimization failed (some measures below critical value)\n\
                      Error   : ------------------------------\n\
                      Error   : Mesh generation error summary\n\
                      Error   :     5 warnings\n\
                      Error   :     2 errors\n\
                      Error   : Check the full log for details\n";
        assert_eq!(fatal(folded), None);
        let crossed = format!("{folded}Error   : PLC Error:  A segment and a facet intersect at point\n");
        assert_eq!(
            fatal(&crossed),
            Some("PLC Error:  A segment and a facet intersect at point")
        );
    }
}
