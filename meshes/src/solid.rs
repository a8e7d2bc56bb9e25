//! Meshes solid geometries (STEP, IGES, BREP) with gmsh: lists the solids, checks the memory required, and limits the
//! time for repairing curved elements.

use std::path::Path;
use std::sync::atomic::{AtomicU64, Ordering};

use crate::gmsh::{HighOrderOptimization, Job, Made, made};
use crate::msh::Imported;
use crate::{MeshError, POOR};

/// The gmsh script.
const SCRIPT: &str = include_str!("../geo/solid.geo");

/// Names of the reports written by the script, with their contents.
const SHEETS: &str = "sheets"; // number of faces of a geometry without a solid
const SOLIDS: &str = "solids"; // one line per solid: volume [mm3], lower and upper corner of its box [mm]
const EXTENT: &str = "extent"; // longest side of a geometry that is too large or too small [mm]
const ELEMENTS: &str = "elements"; // estimated number of elements, if too large

/// Ratio of the longest side of gmsh's tetrahedra to the requested size; 1.4 to 1.8 on plates and housings.
const LONGEST_OVER_TARGET: f64 = 1.5;

/// Factor by which a further attempt aims below the longest side allowed.
const MARGIN: f64 = 0.97;

/// Number of attempts before a geometry is abandoned.
const MOST_MESHES: usize = 6;

/// Estimated number of tetrahedra that gmsh 4.8 makes in a volume V with surface area A at target size h: 4 V/h^3 + 2.5
/// A/h^2. For a sphere, a plate and a tube at 1.5 to 10 mm, it is 0.9 to 1.6 times the actual number.
const IN_VOLUME: f64 = 4.0;
const ON_SURFACE: f64 = 2.5;

/// Memory per quadratic tetrahedron: in gmsh (0.9 kB), in its file and in the mesh here \[byte\].
const BYTES: f64 = 1.5e3;

/// Time limit for the optimisation of curved elements in gmsh: a constant \[s\], and a multiple of the meshing time.
/// For 18 solids at 15 mm, meshing takes 2.5 s and optimisation 185 s, for elements that straight sides repair as well.
const OPTIMISATION: [f64; 2] = [10.0, 3.0];

/// Largest number of solids that a message lists individually.
const LISTED: usize = 20;

/// Memory that gmsh may use \[byte\], stored as the bits of an `f64`.
static MEMORY: AtomicU64 = AtomicU64::new(f64::INFINITY.to_bits());

/// Limits the memory of all meshes that gmsh makes for this process from now on \[GB\]. A geometry that would need more
/// is rejected before meshing; the limit does not otherwise affect the mesh.
pub fn allow_memory(gigabytes: f64) {
    MEMORY.store((1e9 * gigabytes).to_bits(), Ordering::Relaxed);
}

/// A solid geometry to mesh.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SolidGeometry<'a> {
    /// The STEP, IGES or BREP file.
    pub path: &'a Path,
    /// Longest element side \[m\].
    pub size: f64,
    /// Plausible range of its longest side along an axis \[m\].
    pub expected: [f64; 2],
    /// Number of the one solid to mesh, from 1; none to mesh all.
    pub solid: Option<usize>,
}

/// A solid of a file.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Solid {
    /// Volume \[mm3\].
    volume: f64,
    /// Corners of its bounding box \[mm\].
    low: [f64; 3],
    high: [f64; 3],
}

impl Solid {
    /// Parses a line of the report.
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

/// Lists solids with their numbers, volumes, box sides and box centres.
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
    /// Meshes the geometry with quadratic tetrahedra whose sides are no longer than `size`.
    ///
    /// gmsh treats a size as a target, which its longest sides exceed by half. The mesh is therefore measured and
    /// remade with a smaller target until no side is too long. All solids become the part `body`; touching solids are
    /// joined. Surfaces are not named. Elements folded by curved sides are optimised for a limited time; those still
    /// folded get straight sides.
    ///
    /// # Errors
    /// Before meshing: [`MeshError::Sheets`] for faces that enclose no solid, and [`MeshError::NoSolid`].
    /// [`MeshError::Extent`] for an implausible longest side. [`MeshError::TooFine`] if memory does not suffice. Then
    /// [`MeshError::TooLong`], [`MeshError::NoGmsh`], [`MeshError::Gmsh`], or those of [`crate::msh::read`].
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

    /// Runs the script with a target size \[m\] and a limit on processor time \[s\].
    fn made(&self, target: f64, optimization: HighOrderOptimization, seconds: Option<f64>) -> Result<Made, MeshError> {
        let end = self
            .path
            .extension()
            .map_or_else(String::new, |end| end.to_string_lossy().to_lowercase());
        let name = format!("geometry.{end}");
        let script = SCRIPT.replace("GEOMETRY", &name);
        let memory = f64::from_bits(MEMORY.load(Ordering::Relaxed));
        // gmsh cannot read infinity.
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

    /// The error that explains, from the script's reports, why no mesh was made.
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

    /// Remarks on a file with several solids.
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

    /// Repairs elements folded by curved sides: first by gmsh's optimisation within a time limit \[s\], then by
    /// straightening sides.
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

/// Fraction of the time limit available to the optimisation of individual elements, see [`HighOrderOptimization`].
const EACH_SHARE: f64 = crate::gmsh::SHARE_WITHOUT_ANALOGY;

fn solids_of(made: &Made) -> Vec<Solid> {
    let report = made.written.iter().find(|(name, _)| *name == SOLIDS);
    report.map_or_else(Vec::new, |(_, text)| text.lines().filter_map(Solid::parse).collect())
}

fn longest_edge(built: &Imported) -> f64 {
    built.mesh.longest_edges().into_iter().fold(0.0, f64::max)
}

/// Number of elements to be repaired.
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

    /// A 100 mm cube with sides of 0.025 mm results from reading a file in mm as m; the estimate rejects it on any
    /// machine.
    #[test]
    fn a_mesh_of_a_cube_that_is_a_thousand_times_too_fine_needs_more_memory_than_there_is() {
        let estimate = |h: f64| IN_VOLUME * (100.0 / h).powi(3) + ON_SURFACE * 6.0 * (100.0 / h).powi(2);
        assert!(1e-9 * BYTES * estimate(16.7e-3) > 1e3);
        // Measured with gmsh 4.8.4: 2786 tetrahedra of 10 mm in a sphere of 50 mm.
        let sphere = IN_VOLUME * 523.6 + ON_SURFACE * 314.2;
        assert!((sphere / 2786.0 - 1.0).abs() < 0.1, "{sphere}");
    }
}
