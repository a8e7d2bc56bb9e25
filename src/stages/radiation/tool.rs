//! Radiation of the tool's body by boundary elements: the faces of its housing in the open air, above a rigid floor.
//!
//! The workpiece is not included: it neither reflects the tool's sound nor shields it, except in sand, where its top is
//! flush with the reflecting plane. In every case, it closes the nose. The body is in its position before the shot.
//!
//! If the housing is symmetric, as the parametric one is about y = 0, only one half is solved, for even and for odd
//! motions ([`SymmetricPart`]).
//!
//! A plane farther below the tool than the tool's height is not included in the equations either. It changes the power
//! of a small source at the height h by sin(2 k h)/(2 k h). Below a table, this gives ripples with a period of 170 Hz,
//! which would require three times as many frequencies and average out in every wider band. Its reflection at a
//! microphone is the sound at the microphone's image.

use nailnoise_acoustics::bem::{
    BemError, Boundary, BoundaryMesh, ClosedOutline, Gaps, Panel, Parity, Patterns, Rim, SurfaceCover, SymmetricPart,
};
use nailnoise_acoustics::radiation::boundary_elements::{MeanBands, MeanRanges, MeshRange};
use nailnoise_acoustics::{Air, InputError};
use nailnoise_meshes::Surface;
use nalgebra::DMatrix;
use rayon::prelude::*;
use serde::Serialize;

use super::boundary_elements::{LOWEST_SAMPLE, MOST_AT_GAPS, MeshRanges, Places, Resolution, Solution};
use super::error::SurfaceError;
use super::tool_parts::{CapSurface, ToolCover};
use crate::error::Error;
use crate::stages::Progress;
use crate::stages::bodies::BodyError;
use crate::stages::bodies::MovingSurface;

/// Surfaces around enclosed air: supply in the handle and around the sleeve, exhaust in the cap.
const ENCLOSED: [&str; 3] = ["supply", "sleeve_outside", "plenum"];

/// Maximum number of panels of a coarser mesh relative to the finest for it to be useful.
const WORTH_WHILE: f64 = 0.6;

/// Minimum number of frequencies at which a piece of a range is sampled.
const SAMPLES: f64 = 8.0;

/// Highest frequency at which the coarser mesh is used alone, relative to the top of all ranges.
const ALONE: f64 = 0.4;

/// Boundary elements of the tool's housing.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct ToolRadiation {
    /// Resolution.
    pub resolution: Resolution,
    /// Height of the reflecting plane in the tool's coordinates \[m\], if it is included in the equations.
    pub floor: Option<f64>,
    /// Porous cover.
    pub cover: Option<ToolCover>,
}

impl ToolRadiation {
    /// The solution in standard air, on the mesh of the first of several bodies with the same shape, for the modes of
    /// all of them; it depends only on the wavelength.
    ///
    /// # Errors
    /// The errors of mesh and boundary elements.
    pub fn compute(&self, bodies: &[MovingSurface<'_>], progress: &Progress) -> Result<Solution, Error> {
        self.solve(
            &self.housings(bodies, None)?,
            ("tool", "boundary elements of the tool"),
            progress,
        )
    }

    /// The same with two columns per mode: first the modes of the full body, then the same modes with only the cap
    /// moving.
    ///
    /// # Errors
    /// Same as [`Self::compute`], and [`SurfaceError::NoCapSurface`].
    pub fn compute_with_cap(
        &self,
        bodies: &[MovingSurface<'_>],
        cap: &CapSurface,
        progress: &Progress,
    ) -> Result<Solution, Error> {
        self.solve(
            &self.housings(bodies, Some(cap))?,
            ("tool with its cap apart", "boundary elements of the tool's cap"),
            progress,
        )
    }

    fn solve(
        &self,
        housings: &[Housing],
        (body, task): (&str, &'static str),
        progress: &Progress,
    ) -> Result<Solution, Error> {
        let air = Air::default();
        let levels = self.of_housings(housings, &air)?;
        let finest = levels.last().ok_or(OTHER_SURFACE)?;
        let top_hz = finest.top_hz;
        let ranges = MeshRanges {
            solves: solves(&levels, &self.resolution.mean_bands(top_hz)),
            means: self.mean_ranges(&housings[0], finest, &air)?,
            levels,
            lowest_hz: LOWEST_SAMPLE.min(0.1 * top_hz),
        };
        ranges.note(body, SAMPLES, progress);
        if let Some(finest) = ranges.finest() {
            let repairs = finest.problem.boundary().repairs();
            if repairs.flipped > 0 {
                progress.note(&format!("tool: {repairs}; look at its mesh"));
            }
        }
        ranges.solve(task, &self.resolution, progress)
    }

    /// Checks the mesh of the housing before its modes are computed. It must be able to radiate, be far enough from the
    /// microphones, and have a cap if one is required.
    ///
    /// # Errors
    /// Same as [`Self::level`], [`SurfaceError::NoCapSurface`], and the errors of the microphones.
    pub fn check(&self, surface: &Surface, cap: Option<&CapSurface>, places: &Places) -> Result<(), Error> {
        let modes = DMatrix::zeros(3 * surface.points.len(), 0);
        let body = MovingSurface {
            body: "tool",
            surface,
            modes: &modes,
        };
        places.check(&self.mesh_hierarchy(&[body], cap, &Air::default())?)
    }

    /// The housing's own mesh with its nose closed, up to the frequency that it resolves.
    ///
    /// # Errors
    /// The errors of the mesh.
    pub fn level(&self, body: &MovingSurface<'_>, air: &Air) -> Result<MeshRange, Error> {
        self.finest(&[*body], None, air)?.ok_or(OTHER_SURFACE)
    }

    /// The housing in panels that resolve the waves at a frequency \[Hz\]: those of its mesh, with panels that are too
    /// large divided.
    ///
    /// # Errors
    /// Same as [`Self::level`].
    pub fn resolving(&self, body: &MovingSurface<'_>, hz: f64, air: &Air) -> Result<MeshRange, Error> {
        self.of_finer_mesh(&self.housing(body, None)?, hz, air)
    }

    /// The housing's mesh with each mode; for a separate cap, the modes of the cap alone follow those of the full body.
    /// The modes of further bodies with the same shape follow those of the first, on its mesh; `None` if their surfaces
    /// differ.
    ///
    /// # Errors
    /// Same as [`Self::level`], [`SurfaceError::OpenCavity`], and [`SurfaceError::NoCapSurface`].
    pub fn finest(
        &self,
        bodies: &[MovingSurface<'_>],
        cap: Option<&CapSurface>,
        air: &Air,
    ) -> Result<Option<MeshRange>, Error> {
        self.joined(&self.housings(bodies, cap)?, air)
    }

    /// The mesh of the first housing with the motions of all housings, each transferred from its own mesh; `None` if
    /// the surfaces differ.
    fn joined(&self, housings: &[Housing], air: &Air) -> Result<Option<MeshRange>, Error> {
        let mut all = self.of_own_mesh(&housings[0], air)?;
        for housing in &housings[1..] {
            if !append(&mut all, &self.of_own_mesh(housing, air)?, 0) {
                return Ok(None);
            }
        }
        Ok(Some(all))
    }

    fn housings(&self, bodies: &[MovingSurface<'_>], cap: Option<&CapSurface>) -> Result<Vec<Housing>, Error> {
        bodies.iter().map(|body| self.housing(body, cap)).collect()
    }

    /// The moving outer surface of the housing.
    fn housing(&self, body: &MovingSurface<'_>, cap: Option<&CapSurface>) -> Result<Housing, Error> {
        let outline = ClosedOutline::new(body.surface, self.floor)?;
        refuse_open_cavities(&outline.mesh)?;
        let motion = outline.motion(body.surface, body.modes);
        let part = SymmetricPart::of(outline.mesh);
        let boundary = Boundary::symmetric(part.mesh.clone(), part.mirrors(), self.floor)?;
        Ok(Housing {
            rims: Gaps::of(&boundary).coarse_rims(),
            motions: part.by_parity(motion),
            mirrors: part.mirrors(),
            cap: cap.map(|cap| cap.panels(&part.mesh)).transpose()?,
            covered: self.cover.map(|cover| cover.panels(&part.mesh)).transpose()?,
            mesh: part.mesh,
        })
    }

    /// The housing's own mesh.
    fn of_own_mesh(&self, housing: &Housing, air: &Air) -> Result<MeshRange, Error> {
        let boundary = Boundary::symmetric(housing.mesh.clone(), housing.mirrors, self.floor)?;
        let top_hz = boundary.highest_hz(air.sound_speed, self.resolution.panels);
        let top_hz = top_hz.min(self.resolution.top_hz);
        if !housing.rims.is_empty() {
            return self.of_panels_within(housing, boundary.mesh().longest_edge(), top_hz, air);
        }
        let parts = housing.parts(&boundary, |panel| panel);
        self.range(boundary, (&housing.motions, parts), top_hz, air)
    }

    /// The housing in finer panels, which resolve the waves at `top_hz`.
    fn of_finer_mesh(&self, housing: &Housing, top_hz: f64, air: &Air) -> Result<MeshRange, Error> {
        let edge = air.sound_speed / (self.resolution.panels * top_hz);
        self.of_panels_within(housing, edge, top_hz, air)
    }

    /// The housing in panels whose sides are at most `edge` long \[m\], and shorter at the rims of thin gaps.
    fn of_panels_within(&self, housing: &Housing, edge: f64, top_hz: f64, air: &Air) -> Result<MeshRange, Error> {
        let finer = housing
            .mesh
            .subdivided_fine_at(edge, &housing.rims, MOST_AT_GAPS)
            .map_err(BemError::from)?;
        let motions = housing
            .motions
            .iter()
            .map(|(parity, motion)| Ok((*parity, finer.fields(motion)?)));
        let motions: Vec<_> = motions.collect::<Result<_, InputError>>().map_err(BemError::from)?;
        let boundary = Boundary::symmetric(finer.mesh, housing.mirrors, self.floor)?;
        let parts = housing.parts(&boundary, |panel| finer.parents[panel]);
        self.range(boundary, (&motions, parts), top_hz, air)
    }

    /// A boundary with the velocities of all panels, optionally followed by those of the cap alone, from displacements
    /// of every parity, and with its cover.
    fn range(
        &self,
        boundary: Boundary,
        (motions, parts): (&[(Parity, DMatrix<f64>)], PanelParts),
        top_hz: f64,
        air: &Air,
    ) -> Result<MeshRange, Error> {
        let of_parity = |(parity, motion): &(Parity, DMatrix<f64>)| {
            let velocities = boundary.project_displacements(motion)?;
            Ok::<_, Error>(Patterns {
                parity: *parity,
                velocities: match &parts.cap {
                    Some(part) => beside_part(velocities, boundary.mesh(), part),
                    None => velocities,
                },
            })
        };
        let patterns = motions.par_iter().map(of_parity).collect::<Result<_, _>>()?;
        let covered = self.cover.as_ref().zip(parts.covered);
        let cover = covered.map(|(cover, covered)| cover.on(&boundary, &covered));
        Ok(with_cover(
            self.resolution.range(boundary, patterns, top_hz, air)?,
            cover,
        )?)
    }

    /// The meshes for the means above the highest single frequency, with the motions of further bodies taken from the
    /// finest mesh below.
    fn mean_ranges(&self, housing: &Housing, finest: &MeshRange, air: &Air) -> Result<MeanRanges, Error> {
        self.resolution.mean_ranges(finest.top_hz, |hz| {
            let mut finer = self.of_finer_mesh(housing, hz, air)?;
            let own = finer.motions();
            if finest.motions() == own || append(&mut finer, finest, own) {
                Ok(finer)
            } else {
                Err(OTHER_SURFACE)
            }
        })
    }

    /// The meshes for the solution of the housing.
    ///
    /// # Errors
    /// Same as [`Self::finest`].
    pub fn mesh_hierarchy(
        &self,
        bodies: &[MovingSurface<'_>],
        cap: Option<&CapSurface>,
        air: &Air,
    ) -> Result<Vec<MeshRange>, Error> {
        self.of_housings(&self.housings(bodies, cap)?, air)
    }

    /// The housing's mesh. If it saves enough time, a coarser mesh of the same surface that resolves the same waves
    /// precedes it. In the lower part of the range, only that mesh is used; in the upper part, it predicts the matrix
    /// between the few frequencies solved on the finer mesh.
    fn of_housings(&self, housings: &[Housing], air: &Air) -> Result<Vec<MeshRange>, Error> {
        let panels = self.resolution.panels;
        let fine = self.joined(housings, air)?.ok_or(OTHER_SURFACE)?;
        let boundary = fine.problem.boundary();
        let edge = air.sound_speed / (panels * fine.top_hz);
        let worth_while = WORTH_WHILE * boundary.mesh().panels.len() as f64;
        // A coarser surface would have panels that are too wide at the rims of gaps.
        if !housings[0].rims.is_empty() {
            return Ok(vec![fine]);
        }
        // A surface that cannot be coarsened is solved unchanged.
        let coarse = match boundary.coarsened(edge) {
            Ok(coarse) if coarse.mesh().panels.len() as f64 <= worth_while => coarse,
            _ => return Ok(vec![fine]),
        };
        let carried = |p: &Patterns| {
            let velocities = coarse.project_from(boundary, &p.velocities)?;
            Ok::<_, Error>(Patterns {
                parity: p.parity,
                velocities,
            })
        };
        let patterns: Vec<Patterns> = fine.patterns.iter().map(carried).collect::<Result<_, _>>()?;
        let cover = fine.problem.cover();
        let cover = cover
            .map(|cover| ToolCover::carried(cover, boundary, &coarse))
            .transpose()?;
        let below = self.resolution.range(coarse, patterns, ALONE * fine.top_hz, air)?;
        Ok(vec![with_cover(below, cover)?, fine])
    }
}

/// The outer surface of a housing with its nose closed; if it is symmetric, only the part on one side of its mirror
/// planes.
struct Housing {
    mesh: BoundaryMesh,
    mirrors: [Option<f64>; 2],
    /// Rims of the thin gaps for which its panels are too wide.
    rims: Vec<Rim>,
    /// Displacements of every parity at the mesh's points, (3 x points) x modes.
    motions: Vec<(Parity, DMatrix<f64>)>,
    /// For each panel, whether it is part of the cap, if that is separate.
    cap: Option<Vec<bool>>,
    /// For each panel, whether it is covered, if there is a cover.
    covered: Option<Vec<bool>>,
}

/// Parts of a boundary: for each panel, whether it belongs to the cap and to the covered surface.
struct PanelParts {
    cap: Option<Vec<bool>>,
    covered: Option<Vec<bool>>,
}

impl Housing {
    /// Parts of a boundary, given the housing's panel that contains each panel of the boundary's original mesh.
    fn parts(&self, boundary: &Boundary, parent: impl Fn(usize) -> usize) -> PanelParts {
        let of = |part: &Option<Vec<bool>>| {
            part.as_ref()
                .map(|part| of_panels(boundary, |panel| part[parent(panel)]))
        };
        PanelParts {
            cap: of(&self.cap),
            covered: of(&self.covered),
        }
    }
}

/// A mesh with a porous cover, if there is one.
fn with_cover(range: MeshRange, cover: Option<SurfaceCover>) -> Result<MeshRange, BemError> {
    Ok(match cover {
        Some(cover) => MeshRange {
            problem: range.problem.with_cover(cover)?,
            ..range
        },
        None => range,
    })
}

/// For each panel of a boundary, whether it belongs to a part, which is given by panel numbers in the original mesh.
fn of_panels(boundary: &Boundary, part: impl Fn(usize) -> bool) -> Vec<bool> {
    boundary.original().iter().map(|&panel| part(panel)).collect()
}

/// Rejects an outline that contains walls of enclosed air. A cavity with a slit to the outside is a Helmholtz
/// resonator, which multiplies the radiation of all modes near its resonance. The cavities of a tool are closed.
fn refuse_open_cavities(outline: &BoundaryMesh) -> Result<(), Error> {
    let name = |panel: &Panel| outline.patches[panel.patch].as_str();
    match outline.panels.iter().map(name).find(|name| ENCLOSED.contains(name)) {
        Some(surface) => Err(SurfaceError::OpenCavity {
            surface: surface.to_owned(),
        }
        .into()),
        None => Ok(()),
    }
}

/// Bodies whose surfaces differ have no common modes.
const OTHER_SURFACE: Error = Error::Body(BodyError::OtherModes {
    body: "reference bodies",
});

/// Appends the motions on another mesh of the same surface, starting at number `first`; returns false if the surfaces
/// differ.
fn append(to: &mut MeshRange, from: &MeshRange, first: usize) -> bool {
    let [own, other] = [&*to, from].map(|range| range.problem.boundary());
    let carried = from.patterns.par_iter().map(|patterns| {
        let further = patterns.velocities.columns_range(first..).into_owned();
        own.interpolate_from(other, &further)
    });
    let Some(carried) = carried.collect::<Option<Vec<_>>>() else {
        return false;
    };
    for (Patterns { velocities, .. }, further) in to.patterns.iter_mut().zip(carried) {
        let known = velocities.ncols();
        velocities.resize_horizontally_mut(known + further.ncols(), 0.0);
        velocities.columns_range_mut(known..).copy_from(&further);
    }
    true
}

/// Velocity patterns (corner values of the panels x modes), followed by the same patterns with only the panels in
/// `part` moving.
fn beside_part(velocities: DMatrix<f64>, mesh: &BoundaryMesh, part: &[bool]) -> DMatrix<f64> {
    let modes = velocities.ncols();
    let mut both = velocities.resize_horizontally(2 * modes, 0.0);
    let mut row = 0;
    for (panel, own) in mesh.panels.iter().zip(part) {
        for row in row..row + panel.corners().len() {
            if *own {
                (0..modes).for_each(|mode| both[(row, modes + mode)] = both[(row, mode)]);
            }
        }
        row += panel.corners().len();
    }
    both
}

/// Approximate number of frequencies that are solved on each mesh. A single mesh is used for three pieces of the range.
/// One with a coarser mesh below it is used for half as many on the last piece and for the centres of the means.
fn solves(levels: &[MeshRange], bands: &MeanBands) -> Vec<f64> {
    let means = bands.on_same_mesh();
    let in_means = MeanBands::samples(means) as f64;
    match levels {
        [_, _] => vec![4.0 * SAMPLES + in_means, 0.5 * SAMPLES + means as f64],
        _ => vec![3.0 * SAMPLES + in_means; levels.len()],
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]

    use super::*;
    use crate::chain::BodyStages;
    use crate::design::Design;
    use crate::graph::Graph;
    use crate::stages::bodies::BodyKind;
    use crate::stages::radiation::CoveredSurfaces;
    use nailnoise_acoustics::bem::EquationSolver;
    use nailnoise_acoustics::{Frame, PorousLayer};
    use nailnoise_meshes::{ElementKind, Grid, Mesh};
    use nalgebra::Point3;

    /// A cube of 3 x 3 x 3 cells with a cavity called `plenum`, whose wall may have a hole.
    fn outline(hole: bool) -> BoundaryMesh {
        let line = || vec![0.0, 0.1, 0.2, 0.3];
        let grid = Grid::new(line(), line(), line()).unwrap();
        let empty = |[x, y, z]: [usize; 3]| x == 1 && y == 1 && (z == 1 || (hole && z == 2));
        let inside = |x: f64| (0.05..0.25).contains(&x);
        let mesh = grid.mesh(
            &["cube"],
            |cell| (!empty(cell)).then_some(0),
            |_, _, _, at| {
                if [at.x, at.y, at.z].into_iter().all(inside) {
                    "plenum"
                } else {
                    "outside"
                }
            },
        );
        ClosedOutline::new(&Surface::of(&mesh), None).unwrap().mesh
    }

    #[test]
    fn a_cavity_that_is_open_to_the_outside_is_refused() {
        refuse_open_cavities(&outline(false)).unwrap();
        let error = refuse_open_cavities(&outline(true)).unwrap_err();
        assert!(error.to_string().contains("`plenum`"), "{error}");
    }

    #[test]
    fn the_shipped_housing_has_no_gap_that_needs_other_panels() {
        for name in ["n80cb.toml", "n80cb-sandbox.toml"] {
            let path = format!("{}/designs/{name}", env!("CARGO_MANIFEST_DIR"));
            let design = Design::load(path).unwrap();
            let stages = BodyStages::add(&Graph::default(), &design, BodyKind::Tool, false).unwrap();
            let surface = Surface::of(&stages.meshed.get().unwrap().imported.mesh);
            let radiation = crate::design::inputs::radiation::tool(&design).unwrap().unwrap();
            let modes = DMatrix::zeros(3 * surface.points.len(), 0);
            let body = MovingSurface {
                body: "tool",
                surface: &surface,
                modes: &modes,
            };
            let housing = radiation.housing(&body, None).unwrap();
            let boundary = Boundary::symmetric(housing.mesh.clone(), housing.mirrors, radiation.floor);
            assert_eq!(housing.mirrors, [None, Some(0.0)]);
            let gaps = Gaps::of(&boundary.unwrap());
            println!("{name}: {:?}", gaps.iter().collect::<Vec<_>>());
            assert!(housing.rims.is_empty(), "{:?}", gaps.worst());
        }
    }

    /// A cube of 0.3 m with this number of cells per axis, each divided into six tetrahedra with straight sides, and
    /// its displacements (0, 0, z) and (y, x, 0).
    fn strained(divisions: usize) -> (Surface, DMatrix<f32>) {
        let points = divisions + 1;
        let coordinates = |number: usize| [number % points, number / points % points, number / (points * points)];
        let step = 0.3 / divisions as f64;
        let nodes: Vec<Point3<f64>> = (0..points.pow(3))
            .map(|number| Point3::from(coordinates(number).map(|n| n as f64 * step)))
            .collect();
        let strides = [1, points, points * points];
        // Along three edges from the lowest corner of a cell to its highest corner.
        let paths = [[0, 1, 2], [1, 2, 0], [2, 0, 1], [0, 2, 1], [2, 1, 0], [1, 0, 2]];
        let mut connectivity = Vec::new();
        for first in (0..nodes.len()).filter(|&number| coordinates(number).iter().all(|&n| n < divisions)) {
            for (number, [a, b, c]) in paths.into_iter().enumerate() {
                let second = first + strides[a];
                let third = second + strides[b];
                let last = third + strides[c];
                // The second half has the opposite orientation.
                connectivity.extend(if number < 3 {
                    [first, second, third, last]
                } else {
                    [first, second, last, third]
                });
            }
        }
        let elements = connectivity.len() / 4;
        let surface = Surface::of(&Mesh {
            nodes,
            kinds: vec![ElementKind::Tet4; elements],
            offsets: (0..=elements).map(|element| 4 * element).collect(),
            connectivity,
            parts: vec![0; elements],
            part_names: vec!["cube".to_owned()],
            groups: vec![],
        });
        let modes = DMatrix::from_fn(3 * surface.points.len(), 2, |dof, mode| {
            let at = surface.points[dof / 3];
            let displacement = [[0.0, 0.0, at.z], [at.y, at.x, 0.0]][mode][dof % 3];
            displacement as f32
        });
        (surface, modes)
    }

    #[test]
    fn the_modes_of_another_mesh_follow_on_the_first() {
        let (elements, ..) = shaken(None);
        let ([first, other], air) = ([2, 3].map(strained), Air::default());
        let [own, further] = [&first, &other].map(|(surface, modes)| MovingSurface {
            body: "tool",
            surface,
            modes,
        });
        let alone = elements.finest(&[own], None, &air).unwrap().unwrap();
        let both = elements.finest(&[own, further], None, &air).unwrap().unwrap();
        let [alone, both] = [&alone, &both].map(|range| &range.patterns[0].velocities);
        assert!(alone.column(0).amax() > 0.2 && alone.column(1).amax() > 0.2);
        assert_eq!((both.ncols(), both.columns(0, 2)), (4, alone.columns(0, 2)));
        // Linear motions of flat sides are transferred exactly.
        assert!((both.columns(2, 2) - alone).amax() < 1e-6);
    }

    /// A block of 0.3 m on the ground of the tool's coordinates as a housing that moves rigidly along z, with its upper
    /// side as the cap.
    fn shaken(mean_top_hz: Option<f64>) -> (ToolRadiation, Surface, DMatrix<f32>) {
        let line = || vec![0.0, 0.1, 0.2, 0.3];
        let grid = Grid::new(line(), line(), line()).unwrap();
        let mesh = grid.mesh(
            &["cube"],
            |_| Some(0),
            |_, axis, upper, _| match (axis, upper) {
                (2, true) => "cap_outside",
                _ => "outside",
            },
        );
        let surface = Surface::of(&mesh);
        let modes = DMatrix::from_fn(3 * surface.points.len(), 1, |dof, _| f32::from(u8::from(dof % 3 == 2)));
        let elements = ToolRadiation {
            resolution: Resolution {
                top_hz: 1e5,
                mean_top_hz,
                panels: 6.0,
                equations: EquationSolver::Auto,
                tolerance: 0.02,
            },
            floor: None,
            cover: None,
        };
        (elements, surface, modes)
    }

    #[test]
    fn means_have_meshes_that_resolve_them_in_the_motion_of_the_housing_and_of_its_cap() {
        let (elements, surface, modes) = shaken(Some(800.0));
        let body = MovingSurface {
            body: "tool",
            surface: &surface,
            modes: &modes,
        };
        let (cap, air) = (CapSurface::Named("cap_outside"), Air::default());
        let housing = elements.housing(&body, Some(&cap)).unwrap();
        let single = elements.of_own_mesh(&housing, &air).unwrap();
        let means = elements.mean_ranges(&housing, &single, &air).unwrap();
        // The cover of its mouth is a fan of triangles.
        assert!((single.top_hz - 270.0).abs() < 1.0, "{}", single.top_hz);
        assert_eq!(means.finer.len(), 3);
        let mut panels = single.problem.boundary().mesh().panels.len();
        for range in &means.finer {
            let boundary = range.problem.boundary();
            assert!(range.resolved_hz() >= range.top_hz * (1.0 - 1e-9));
            assert!(boundary.mesh().panels.len() > panels);
            panels = boundary.mesh().panels.len();
            // Volume flows of both patterns through the upper side, 0.09 m2.
            let velocities = &range.patterns[0].velocities;
            let (mut row, mut flows) = (0, [0.0; 2]);
            for (number, panel) in boundary.mesh().panels.iter().enumerate() {
                let corners = panel.corners().len();
                let upper = boundary.mesh().patches[panel.patch] == "cap_outside";
                for (pattern, flow) in flows.iter_mut().enumerate() {
                    let own = velocities.view((row, pattern), (corners, 1));
                    assert!(upper || pattern == 0 || own.amax() < 1e-12);
                    let area = boundary.copies() as f64 * boundary.mesh().panel_area(number);
                    *flow += f64::from(u8::from(upper)) * own.mean() * area;
                }
                row += corners;
            }
            assert!(flows.iter().all(|flow| (flow - 0.09).abs() < 1e-9), "{flows:?}");
        }
        assert!((means.finer[2].top_hz - 800.0).abs() < 1e-6);
    }

    #[test]
    fn a_cover_lies_on_its_surfaces_on_every_mesh() {
        let cap = CapSurface::Named("cap_outside");
        // The upper side has 0.09 m2 of 0.54 m2.
        let cases = [
            (CoveredSurfaces::Cap(cap), 0.09),
            (CoveredSurfaces::Housing(cap), 0.45),
            (CoveredSurfaces::Both, 0.54),
        ];
        for (surfaces, expected) in cases {
            let (elements, surface, modes) = shaken(Some(800.0));
            let elements = ToolRadiation {
                cover: Some(ToolCover {
                    layer: PorousLayer::new(0.01, 1e4, Frame::Moving).unwrap(),
                    surfaces,
                }),
                ..elements
            };
            let body = MovingSurface {
                body: "tool",
                surface: &surface,
                modes: &modes,
            };
            let air = Air::default();
            let housing = elements.housing(&body, None).unwrap();
            let single = elements.of_own_mesh(&housing, &air).unwrap();
            let means = elements.mean_ranges(&housing, &single, &air).unwrap();
            for range in std::iter::once(&single).chain(&means.finer) {
                let boundary = range.problem.boundary();
                let shares = &range.problem.cover().unwrap().shares;
                let (mut first, mut covered) = (0, 0.0);
                for (number, panel) in boundary.mesh().panels.iter().enumerate() {
                    covered += boundary.copies() as f64 * shares[first] * boundary.mesh().panel_area(number);
                    first += panel.corners().len();
                }
                assert!((covered - expected).abs() < 1e-9, "{surfaces:?}: {covered} m2");
            }
        }
    }

    #[test]
    fn half_an_octave_of_means_needs_no_finer_mesh() {
        let (elements, surface, modes) = shaken(None);
        let body = MovingSurface {
            body: "tool",
            surface: &surface,
            modes: &modes,
        };
        let housing = elements.housing(&body, None).unwrap();
        let single = elements.of_own_mesh(&housing, &Air::default()).unwrap();
        let means = elements.mean_ranges(&housing, &single, &Air::default()).unwrap();
        assert!(means.finer.is_empty() && means.to_hz.is_none());
    }
}
