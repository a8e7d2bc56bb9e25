//! New geometry is meshed by the gmsh command (C. Geuzaine and J.-F. Remacle, 2009), which need not be installed for
//! anything else.

use std::path::{Path, PathBuf};
use std::process::{Command, Output};

use crate::child;
use crate::msh::{self, Imported};
use crate::temporary::TemporaryFolder;
use crate::{FaceGroup, FaceRef, Mesh, MeshError, Surface};

/// Name of the environment variable that names the program.
const PROGRAM: &str = "NAILNOISE_GMSH";

/// File in which a script leaves the longest side \[mm\] of a geometry that it does not mesh for its size.
const EXTENT: &str = "extent";

/// Beginning of the names of the folders in which gmsh works.
const FOLDER: &str = "nailnoise-gmsh-";

/// What gmsh can be asked to mesh.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Job<'a> {
    /// Name for messages.
    pub(crate) what: String,
    /// The script.
    pub(crate) script: &'a str,
    /// Constants of the script.
    pub(crate) constants: Vec<(&'static str, f64)>,
    /// A geometry that the script opens, copied beside it under this name.
    pub(crate) beside: Option<(&'a Path, String)>,
    /// Processor time after which gmsh is ended if it mends folded elements by the elastic analogy \[s\], and of which an attempt
    /// without it has [`SHARE_WITHOUT_ANALOGY`]; no limit without it.
    pub(crate) seconds: Option<f64>,
}

/// The constant of the scripts that says how gmsh mends the elements that curved sides fold.
const OPTIMISE: &str = "optimise";

/// How gmsh mends folded elements: values of `Mesh.HighOrderOptimize`, in the order in which they are tried.
///
/// The elastic analogy deforms the whole mesh, and takes three quarters of gmsh's time, although some ten of 8 500 elements of half
/// a tool are folded.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum HighOrderOptimization {
    /// Optimisation of each folded element with those around it.
    Each = 1,
    /// The elastic analogy, then optimisation.
    Elastic = 2,
}

impl HighOrderOptimization {
    /// Whole seconds of processor time of a limit with the elastic analogy \[s\].
    fn limit(self, seconds: f64) -> u64 {
        let share = match self {
            Self::Each => SHARE_WITHOUT_ANALOGY,
            Self::Elastic => 1.0,
        };
        (share * seconds).ceil() as u64
    }
}

/// Share of a limit of processor time that gmsh has without the elastic analogy. The N80CB takes a quarter of the time without it.
const SHARE_WITHOUT_ANALOGY: f64 = 1.0 / 3.0;

/// Opens a solid geometry with the script below; lengths come in millimetres, whatever the file's own unit. A geometry whose
/// longest side is not among the expected ones is measured and not meshed.
const SOLID: &str = r#"
SetFactory("OpenCASCADE");
DefineConstant[ size = 10, least = 0, most = 1e22, optimise = 1 ];
solids() = ShapeFromFile("GEOMETRY");
solids() = Volume{:};
If (#solids() > 1)
  Coherence;
EndIf
solids() = Volume{:};
low_() = {1e22, 1e22, 1e22};
high_() = {-1e22, -1e22, -1e22};
For k In {0 : #solids() - 1}
  box() = BoundingBox Volume{solids(k)};
  For axis In {0 : 2}
    low_(axis) = (box(axis) < low_(axis)) ? box(axis) : low_(axis);
    high_(axis) = (box(3 + axis) > high_(axis)) ? box(3 + axis) : high_(axis);
  EndFor
EndFor
extent = Max(high_(0) - low_(0), Max(high_(1) - low_(1), high_(2) - low_(2)));
If (#solids() > 0 && (extent < least || extent > most))
  Printf("%.9g", extent) > "extent";
  Exit;
EndIf
Physical Volume("body") = Volume{:};
Mesh.CharacteristicLengthMax = size;
Mesh.ElementOrder = 2;
Mesh.HighOrderOptimize = optimise;
Mesh.ScalingFactor = 0.001;
"#;

/// Longest side of gmsh's tetrahedra over the size asked of it, as found on plates and housings: 1.4 to 1.8.
const LONGEST_OVER_TARGET: f64 = 1.5;

/// How far below the longest side allowed another mesh aims.
const MARGIN: f64 = 0.97;

/// Meshes made before a geometry is given up.
const MOST_MESHES: usize = 6;

/// Meshes a solid geometry (STEP, BREP or IGES) with quadratic tetrahedra none of whose sides is longer than `size` \[m\].
///
/// gmsh takes a size as a target that its longest sides exceed by half. The mesh is measured, and made anew with a smaller
/// target as long as a side is too long. All solids become the part `body`, touching ones joined. No surface has a name.
///
/// # Errors
/// [`MeshError::Extent`] for a geometry whose longest side along an axis is not within `expected` \[m\], found before
/// anything is meshed; [`MeshError::TooLong`], [`MeshError::NoGmsh`], [`MeshError::Gmsh`], or those of [`msh::read`].
pub fn solid(path: &Path, size: f64, expected: [f64; 2]) -> Result<Imported, MeshError> {
    let end = path
        .extension()
        .map_or_else(String::new, |end| end.to_string_lossy().to_lowercase());
    let name = format!("geometry.{end}");
    let script = SOLID.replace("GEOMETRY", &name);
    let what = path.display().to_string();
    let meshed = |target: f64| {
        let job = Job {
            what: what.clone(),
            script: &script,
            constants: vec![
                ("size", target * 1e3),
                ("least", expected[0] * 1e3),
                ("most", (expected[1] * 1e3).min(1e22)),
            ],
            beside: Some((path, name.clone())),
            seconds: None,
        };
        run(&job).map_err(|error| match error {
            MeshError::Extent { what, extent, .. } => MeshError::Extent { what, extent, expected },
            other => other,
        })
    };
    let (mut target, mut longest) = (size / LONGEST_OVER_TARGET, f64::INFINITY);
    for _ in 0..MOST_MESHES {
        let mut built = meshed(target)?;
        longest = built.mesh.longest_edges().into_iter().fold(0.0, f64::max);
        if longest <= size {
            built.mesh.straighten();
            return Ok(built);
        }
        target *= MARGIN * size / longest;
    }
    Err(MeshError::TooLong { what, longest, size })
}

/// The version of the gmsh that would be used.
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

/// Whether there is a gmsh to start; it is not started.
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

/// Meshes by a script, anew with the elastic analogy where the quick way leaves inverted elements.
pub(crate) fn run(job: &Job<'_>) -> Result<Imported, MeshError> {
    with_fewest_inverted(|optimization| mesh_once(job, optimization))
}

/// The first mesh if it has no inverted elements, else the one with fewer; the first, too, where the second cannot be made,
/// because straight sides mend it.
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

/// Runs a script in a temporary folder and reads the mesh.
fn mesh_once(job: &Job<'_>, optimization: HighOrderOptimization) -> Result<Imported, MeshError> {
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
    // One thread: the mesh must be the same on every machine.
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
    let output = start(&mut command, &program)?;
    if let Some(seconds) = seconds.filter(|_| child::ran_out(&output)) {
        return Err(MeshError::Gmsh {
            what: job.what.clone(),
            reason: format!(
                "it had not ended after {seconds} s of processor time, several times what such a body takes: its dimensions do not go \
                 together, or its elements are too small for it"
            ),
        });
    }
    let said = String::from_utf8_lossy(&[output.stdout, output.stderr].concat()).into_owned();
    let failed = |reason: String| MeshError::Gmsh {
        what: job.what.clone(),
        reason,
    };
    if let Some(extent) = std::fs::read_to_string(at(EXTENT))
        .ok()
        .and_then(|text| text.trim().parse::<f64>().ok())
    {
        return Err(MeshError::Extent {
            what: job.what.clone(),
            extent: extent * 1e-3,
            expected: [0.0, f64::INFINITY],
        });
    }
    let result = at("mesh.msh");
    let fatal = fatal(&said);
    if fatal.is_some() || !result.exists() {
        let reason = match fatal {
            Some(first) => first.to_owned(),
            None => format!("it ended with {} and wrote no mesh", output.status),
        };
        return Err(failed(reason));
    }
    let mut built = msh::read(&result, 1.0).map_err(|error| failed(error.to_string()))?;
    built.mesh.nodes.iter_mut().for_each(|p| *p = p.map(rounded));
    Ok(built)
}

/// The first error that gmsh reports, without frame and counts of its summary. A folded element that stays folded after its
/// optimisation is an error to gmsh; straightening mends it.
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

/// A length to the nearest 2^-26 m (15 nm), so that a mesh that ships compressed is the one that is made.
fn rounded(length: f64) -> f64 {
    const GRAIN: f64 = (1 << 26) as f64;
    (length * GRAIN).round() / GRAIN
}

/// Names the outer faces of a mesh by the planes they lie in: `bottom`, `top` and `sides`.
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

    /// A cube of one element. To swap two of its corners inverts it.
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
            mesh,
            element_numbers: vec![1],
            node_numbers: (1..=8).collect(),
            unused_nodes: 0,
            comment: format!("{optimization:?}"),
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
        let tool = include_str!("../geo/tool.geo");
        for script in [SOLID, tool] {
            assert!(script.contains(&format!("{OPTIMISE} = {}", HighOrderOptimization::Each as u8)));
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
