//! Solid geometries (STEP, IGES, BREP) meshed by gmsh: which solids there are, whether memory suffices, and how long
//! gmsh may mend curved elements.

use std::path::Path;
use std::sync::atomic::{AtomicU64, Ordering};

use crate::gmsh::{HighOrderOptimization, Job, Made, made};
use crate::msh::Imported;
use crate::{MeshError, POOR};

/// The script of gmsh.
const SCRIPT: &str = include_str!("../geo/solid.geo");

/// Reports of the script with their contents.
const SHEETS: &str = "sheets"; // number of faces of a geometry without a solid
const SOLIDS: &str = "solids"; // a line a solid: volume [mm3], lower and upper corner of its box [mm]
const EXTENT: &str = "extent"; // longest side of a geometry that is too long or too short [mm]
const ELEMENTS: &str = "elements"; // estimated number of elements, where it is too large

/// Longest side of gmsh's tetrahedra over the size asked of it, as found on plates and housings: 1.4 to 1.8.
const LONGEST_OVER_TARGET: f64 = 1.5;

/// How far below the longest side allowed another mesh aims.
const MARGIN: f64 = 0.97;

/// Meshes made before a geometry is given up.
const MOST_MESHES: usize = 6;

/// Tetrahedra of gmsh 4.8 in a volume V with the surface A at the target h: 4 V/h^3 + 2.5 A/h^2. For a sphere, a plate
/// and a tube at 1.5 to 10 mm it is between 0.9 and 1.6 times the number found.
const IN_VOLUME: f64 = 4.0;
const ON_SURFACE: f64 = 2.5;

/// Memory of a quadratic tetrahedron in gmsh (0.9 kB) and in its file and mesh here \[byte\].
const BYTES: f64 = 1.5e3;

/// Time that gmsh has for the optimisation of curved elements: a start \[s\], and a multiple of the time of the mesh
/// itself. With 18 solids in 15 mm the mesh takes 2.5 s and its optimisation 185 s, for elements that straight sides
/// mend as well.
const OPTIMISATION: [f64; 2] = [10.0, 3.0];

/// Most solids that are listed one by one.
const LISTED: usize = 20;

/// Memory that gmsh may use \[byte\], as the bits of a number.
static MEMORY: AtomicU64 = AtomicU64::new(f64::INFINITY.to_bits());

/// Limits the memory of all meshes that gmsh makes for this process from now on \[GB\]. A geometry that would need more
/// is refused before it is meshed; the mesh of one that is not refused does not depend on the limit.
pub fn allow_memory(gigabytes: f64) {
    MEMORY.store((1e9 * gigabytes).to_bits(), Ordering::Relaxed);
}

/// A solid geometry to be meshed.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SolidGeometry<'a> {
    /// The file, STEP, IGES or BREP.
    pub path: &'a Path,
    /// Longest element side \[m\].
    pub size: f64,
    /// What its longest side along an axis may be \[m\].
    pub expected: [f64; 2],
    /// Number of the only solid that is meshed, from 1; all without one.
    pub solid: Option<usize>,
}

/// A solid of a file.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Solid {
    /// \[mm3\]
    volume: f64,
    /// Corners of the box around it \[mm\].
    low: [f64; 3],
    high: [f64; 3],
}

impl Solid {
    /// A line of the report.
    fn parse(line: &str) -> Option<Self> {
        let numbers: Vec<f64> = line.split_whitespace().map_while(|word| word.parse().ok()).collect();
        match numbers.as_slice() {
            &[volume, a, b, c, d, e, f] => Some(Self {
                volume,
                low: [a, b, c],
                high: [d, e, f],
            }),
            _ => None,
        }
    }
}

/// Lists solids: number, volume, sides of the box, centre of the box.
fn listed(solids: &[Solid]) -> String {
    let mut lines: Vec<String> = solids
        .iter()
        .take(LISTED)
        .enumerate()
        .map(|(index, solid)| {
            let sides = [0, 1, 2]
                .map(|k| format!("{:.1}", solid.high[k] - solid.low[k]))
                .join(" x ");
            let centre = [0, 1, 2]
                .map(|k| format!("{:.1}", 0.5 * (solid.high[k] + solid.low[k])))
                .join(", ");
            let volume = 1e-3 * solid.volume;
            format!("{}: {volume:.1} cm3, {sides} mm at ({centre}) mm", index + 1)
        })
        .collect();
    if solids.len() > LISTED {
        lines.push(format!("and {} more", solids.len() - LISTED));
    }
    lines.join("; ")
}

impl SolidGeometry<'_> {
    /// Meshes the geometry with quadratic tetrahedra none of whose sides is longer than asked for.
    ///
    /// gmsh takes a size as a target that its longest sides exceed by half. The mesh is measured, and made anew with a
    /// smaller target as long as a side is too long. All solids become the part `body`, touching ones joined. No
    /// surface has a name. Elements that curved sides fold are optimised for a limited time; those that are folded then
    /// get straight sides.
    ///
    /// # Errors
    /// Before anything is meshed. [`MeshError::Sheets`] for faces that enclose no solid, [`MeshError::NoSolid`],
    /// [`MeshError::Extent`] for a longest side that is not expected, [`MeshError::TooFine`] where memory does not
    /// suffice. [`MeshError::TooLong`], [`MeshError::NoGmsh`], [`MeshError::Gmsh`], or those of [`crate::msh::read`].
    pub fn mesh(&self) -> Result<Imported, MeshError> {
        let (mut target, mut longest) = (self.size / LONGEST_OVER_TARGET, f64::INFINITY);
        for _ in 0..MOST_MESHES {
            let made = self.made(target, HighOrderOptimization::None, None)?;
            let solids = solids_of(&made);
            let Some(mut built) = made.mesh else {
                return Err(self.refusal(target, &made.written, &solids));
            };
            longest = longest_edge(&built);
            if longest <= self.size {
                let mut notes = self.notes(&solids);
                if poor(&built) > 0 {
                    let limit = OPTIMISATION[0] + OPTIMISATION[1] * made.seconds;
                    notes.extend(self.optimise(&mut built, target, limit)?);
                }
                built.notes = notes;
                return Ok(built);
            }
            target *= MARGIN * self.size / longest;
        }
        Err(MeshError::TooLong {
            what: self.what(),
            longest,
            size: self.size,
        })
    }

    fn what(&self) -> String {
        self.path.display().to_string()
    }

    /// Runs the script for a target \[m\], for at most some processor time \[s\].
    fn made(&self, target: f64, optimization: HighOrderOptimization, seconds: Option<f64>) -> Result<Made, MeshError> {
        let end = self
            .path
            .extension()
            .map_or_else(String::new, |end| end.to_string_lossy().to_lowercase());
        let name = format!("geometry.{end}");
        let script = SCRIPT.replace("GEOMETRY", &name);
        let memory = f64::from_bits(MEMORY.load(Ordering::Relaxed));
        // gmsh does not read an infinite number.
        let finite = |number: f64| number.min(1e22);
        let job = Job {
            what: self.what(),
            script: &script,
            constants: vec![
                ("size", target * 1e3),
                ("least", self.expected[0] * 1e3),
                ("most", finite(self.expected[1] * 1e3)),
                ("solid", self.solid.unwrap_or(0) as f64),
                ("elements", finite(memory / BYTES)),
                ("in_volume", IN_VOLUME),
                ("on_surface", ON_SURFACE),
            ],
            beside: Some((self.path, name)),
            reports: &[SHEETS, SOLIDS, EXTENT, ELEMENTS],
            seconds,
        };
        made(&job, optimization)
    }

    /// Why the script made no mesh, from its reports.
    fn refusal(&self, target: f64, written: &[(&str, String)], solids: &[Solid]) -> MeshError {
        let number = |wanted: &str| {
            let (_, text) = written.iter().find(|(name, _)| *name == wanted)?;
            text.trim().parse::<f64>().ok()
        };
        let what = self.what();
        if let Some(faces) = number(SHEETS) {
            return MeshError::Sheets {
                what,
                faces: faces as usize,
            };
        }
        if let Some(extent) = number(EXTENT) {
            return MeshError::Extent {
                what,
                extent: extent * 1e-3,
                expected: self.expected,
            };
        }
        if let Some(elements) = number(ELEMENTS) {
            return MeshError::TooFine {
                what,
                size: target * LONGEST_OVER_TARGET,
                elements,
                gigabytes: 1e-9 * BYTES * elements,
                allowed: 1e-9 * f64::from_bits(MEMORY.load(Ordering::Relaxed)),
            };
        }
        MeshError::NoSolid {
            what,
            asked: self.solid.unwrap_or(0),
            solids: listed(solids),
        }
    }

    /// Remarks on a file of several solids.
    fn notes(&self, solids: &[Solid]) -> Vec<String> {
        let several = solids.len() > 1 && self.solid.is_none();
        several
            .then(|| {
                format!(
                    "{} has {} solids, all of which are meshed as one body: {}; take one of them by `nailnoise mesh \
                     FILE --solid \
                     NUMBER --write PART.msh`",
                    self.what(),
                    solids.len(),
                    listed(solids)
                )
            })
            .into_iter()
            .collect()
    }

    /// Mends elements that curved sides fold: by gmsh's optimisation within a limit \[s\], then by straight sides.
    fn optimise(&self, built: &mut Imported, target: f64, limit: f64) -> Result<Vec<String>, MeshError> {
        let folded = poor(built);
        let attempt = self.made(target, HighOrderOptimization::Each, Some(limit / EACH_SHARE));
        let mut notes = Vec::new();
        match attempt {
            Ok(Made { mesh: Some(better), .. }) if poor(&better) <= folded && longest_edge(&better) <= self.size => {
                *built = better;
            }
            Ok(_) | Err(MeshError::Gmsh { .. } | MeshError::Msh { .. }) => {}
            Err(MeshError::OutOfTime { seconds, .. }) => notes.push(format!(
                "gmsh's optimisation of {folded} elements with curved sides of {} was ended after {seconds} s of \
                 processor time",
                self.what()
            )),
            Err(other) => return Err(other),
        }
        let elements = poor(built);
        let straight = built.mesh.straighten();
        if straight > 0 && !notes.is_empty() {
            notes.push(format!(
                "{straight} sides of {elements} folded elements of {} are straight instead of curved",
                self.what()
            ));
        }
        Ok(notes)
    }
}

/// Share of a limit of processor time that the optimisation of each element has, see [`HighOrderOptimization`].
const EACH_SHARE: f64 = crate::gmsh::SHARE_WITHOUT_ANALOGY;

fn solids_of(made: &Made) -> Vec<Solid> {
    let report = made.written.iter().find(|(name, _)| *name == SOLIDS);
    report.map_or_else(Vec::new, |(_, text)| text.lines().filter_map(Solid::parse).collect())
}

fn longest_edge(built: &Imported) -> f64 {
    built.mesh.longest_edges().into_iter().fold(0.0, f64::max)
}

/// Number of elements that need to be mended.
fn poor(built: &Imported) -> usize {
    let elements = 0..built.mesh.element_count();
    elements
        .filter(|&element| built.mesh.jacobian(element).ratio < POOR)
        .count()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn geometry(solid: Option<usize>) -> SolidGeometry<'static> {
        SolidGeometry {
            path: Path::new("part.step"),
            size: 0.015,
            expected: [0.05, 3.0],
            solid,
        }
    }

    const TWO: &str = "125000 0 0 0 50 50 50\n8000 200 0 0 220 20 20\n";

    #[test]
    fn several_solids_are_listed_and_one_that_is_chosen_is_not() {
        let solids: Vec<Solid> = TWO.lines().filter_map(Solid::parse).collect();
        let notes = geometry(None).notes(&solids);
        assert_eq!(notes.len(), 1);
        for expected in [
            "2 solids",
            "1: 125.0 cm3, 50.0 x 50.0 x 50.0 mm at (25.0, 25.0, 25.0) mm",
            "2: 8.0 cm3, 20.0 x 20.0 x 20.0 mm at (210.0, 10.0, 10.0) mm",
            "--solid",
        ] {
            assert!(notes[0].contains(expected), "{}", notes[0]);
        }
        assert!(geometry(Some(2)).notes(&solids).is_empty());
        assert!(geometry(None).notes(&solids[..1]).is_empty());
    }

    #[test]
    fn every_report_without_a_mesh_is_a_refusal_with_its_cause() {
        let solids: Vec<Solid> = TWO.lines().filter_map(Solid::parse).collect();
        let refusal = |name: &'static str, text: &str| {
            let written = [(name, text.to_owned()), (SOLIDS, TWO.to_owned())];
            geometry(Some(3)).refusal(0.01, &written, &solids).to_string()
        };
        for (name, text, expected) in [
            (SHEETS, "976\n", "976 faces and no solid"),
            (EXTENT, "42.7\n", "4.2700e-2 m long"),
            (ELEMENTS, "2e9\n", "about 2.0e9 elements"),
            (SOLIDS, TWO, "no solid 3; there are 1: 125.0 cm3"),
        ] {
            let found = refusal(name, text);
            assert!(found.contains(expected), "{name}: {found}");
        }
    }

    /// 100 mm cubed in sides of 0.025 mm results from a unit of 1 m for a file in mm; the estimate refuses it on any
    /// machine.
    #[test]
    fn a_mesh_of_a_cube_that_is_a_thousand_times_too_fine_needs_more_memory_than_there_is() {
        let estimate = |h: f64| IN_VOLUME * (100.0 / h).powi(3) + ON_SURFACE * 6.0 * (100.0 / h).powi(2);
        assert!(1e-9 * BYTES * estimate(16.7e-3) > 1e3);
        // Found with gmsh 4.8.4: 2786 tetrahedra of 10 mm in a sphere of 50 mm.
        let sphere = IN_VOLUME * 523.6 + ON_SURFACE * 314.2;
        assert!((sphere / 2786.0 - 1.0).abs() < 0.1, "{sphere}");
    }
}
