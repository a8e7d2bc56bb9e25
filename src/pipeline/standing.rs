//! Boundary elements of the workpiece and of the table that it may stand on: which surfaces sound, above which floor, on
//! which meshes, and what they cost.
//!
//! Built-in block and table are boxes, symmetric about two planes, on meshes that get finer with frequency. A block
//! alone, on a rigid floor or held there, has that floor instead of an underside: no sound comes out of the gap between
//! them. One that hangs or stands on springs sounds all around, above the floor at `support.clearance`. A block of another
//! shape (`workpiece.mesh`) radiates from the faces of its own mesh.

use std::io::Read;

use nailnoise_acoustics::bem::{
    Boundary, BoundaryMesh, Exterior, Level, ModalBem, MovingPart, Parity, Patterns, Receivers, Side, SolidBox,
};
use nailnoise_acoustics::radiation::{Archive, Sampling};
use nailnoise_acoustics::{AcousticsError, Air};
use nailnoise_meshes::open_faces;
use nalgebra::{DMatrix, Point3};

use super::bodies::{Body, Structure};
use super::microphones::{positions, reflecting_plane};
use super::radiator::{FLOOR, LOWEST_SAMPLE, MOST_SAMPLES};
use crate::design::{Design, SupportKind, WorktablePreset};
use crate::error::Error;
use crate::stages::Progress;
use crate::store::{Key, Store};

/// Tops of the ranges that have a mesh of their own, over the top of all.
const RANGES: [f64; 4] = [0.16, 0.4, 0.65, 1.0];

/// Longest side of a panel over the largest extent of the body: at low frequencies the shape asks for as much as the wave.
const COARSEST: f64 = 1.0 / 16.0;

/// Highest underside of a hung block whose floor is part of the equations \[m\]. The floor at the height h changes the
/// power by about sin(2 k h)/(2 k h), a ripple every c/2h that asks for twice as many frequencies at twice the height and
/// cancels in every band that is wider; what a farther one reflects to a microphone is what the microphone's image hears.
const FARTHEST_FLOOR: f64 = 1.0;

/// Frequencies at which a range is sampled on the mesh below it, see [`expected_seconds`], as counted on the worktables.
const SAMPLES_PER_WAVELENGTH: f64 = 7.0;
const SAMPLES_BESIDE: f64 = 10.0;

/// Frequencies at which its own mesh corrects them.
const CORRECTIONS: f64 = 9.0;

/// Patches of the block on its table, and how many of them belong to the block.
const PATCHES: [&str; 6] = [
    "workpiece top",
    "workpiece sides",
    "worktable top",
    "worktable underside",
    "worktable edges",
    "worktable legs",
];
const OF_WORKPIECE: usize = 2;

/// Patches of a block alone.
const ALONE: [&str; 3] = ["workpiece top", "workpiece sides", "workpiece underside"];

/// Name of the stage in the cache.
const STAGE: &str = "radiation of workpiece and worktable";

/// Radiation of block and table, or of a block alone, from the cache where it is known.
///
/// # Errors
/// Those of mesh and radiation.
pub(super) fn standing(
    design: &Design,
    structure: &Structure,
    air: &Air,
    cache: &Store,
    progress: &Progress,
) -> Result<ModalBem, Error> {
    // Once for every air: the matrix depends on the wavelength.
    let computed = Air::default();
    let receivers = receivers(design);
    let key = key(design, structure, &receivers, &computed);
    let read = |from: &mut dyn Read, length| Ok::<_, Error>(ModalBem::from_reader(from, length)?);
    let bem = cache.decoded_or(STAGE, &key, read, || {
        let levels = levels(design, structure, &computed)?;
        let lowest = levels.first().map_or(0.0, |level| level.top_hz);
        let low = LOWEST_SAMPLE.min(0.5 * lowest);
        if let Some(finest) = levels.last() {
            let seconds = expected_seconds(&levels, low, structure);
            let estimate = finest.problem.estimate();
            progress.note(&format!(
                "boundary elements, computed once for this structure, about {seconds:.0} s of processor time in all; \
                 finest mesh: {estimate}"
            ));
            if levels.len() == 1 {
                progress.note(&format!(
                    "workpiece: the sides of its mesh are not those of workpiece.length, width and thickness; it radiates \
                     from its own faces, up to {:.0} Hz; {}",
                    finest.top_hz,
                    finest.problem.boundary().mended()
                ));
            }
        }
        let sampling = Sampling {
            range_hz: [low, design.acoustics.bem_top],
            tolerance: design.acoustics.bem_tolerance,
            floor: FLOOR,
            most_samples: MOST_SAMPLES,
        };
        let expected: f64 = expected(&levels, low).iter().sum::<f64>() + ModalBem::IN_MEAN as f64;
        let bem = progress.count_each(("boundary elements", "frequencies"), expected as u64, |one_more| {
            ModalBem::with_receivers_telling(levels, &sampling, &receivers, one_more)
        })?;
        Ok::<_, Error>(bem.to_bytes())
    })?;
    Ok(bem.in_air(&computed, air))
}

/// Frequencies of each range: they follow how many more wavelengths twice the body's largest extent, or its height above
/// the floor, holds at its top than at its bottom.
fn expected(levels: &[Level], low: f64) -> Vec<f64> {
    let mut from = low;
    let of_range = |level: &Level| {
        let boundary = level.problem.boundary();
        let heights = boundary
            .mesh()
            .points
            .iter()
            .map(|p| p.z - boundary.floor().unwrap_or(p.z));
        let extent = heights.fold(boundary.extents().max(), f64::max);
        let wavelengths = 2.0 * extent * (level.top_hz - from) / level.problem.air().sound_speed;
        from = level.top_hz;
        SAMPLES_PER_WAVELENGTH * wavelengths + SAMPLES_BESIDE
    };
    levels.iter().map(of_range).collect()
}

/// Processor time of all ranges \[s\], about.
fn expected_seconds(levels: &[Level], low: f64, structure: &Structure) -> f64 {
    let modes: usize = structure.bodies().map(|body| body.omega.len()).sum();
    let of_frequency = |level: &Level| {
        // Most modes of a symmetric body have one parity.
        let patterns = modes.div_ceil(level.problem.boundary().copies());
        level.problem.estimate().seconds_with(patterns)
    };
    let of_range = |(number, (level, sampled)): (usize, (&Level, f64))| {
        let kept = level.problem.estimate().seconds_kept;
        match number.checked_sub(1) {
            None => kept + sampled * of_frequency(level),
            Some(below) => kept + sampled * of_frequency(&levels[below]) + CORRECTIONS * of_frequency(level),
        }
    };
    let above = levels
        .last()
        .map_or(0.0, |level| ModalBem::IN_MEAN as f64 * of_frequency(level));
    above
        + levels
            .iter()
            .zip(expected(levels, low))
            .enumerate()
            .map(of_range)
            .sum::<f64>()
}

/// All that the radiation matrices depend on: boxes, floor, air, how finely they are computed, microphones, and the bodies
/// with their modes.
fn key(design: &Design, structure: &Structure, receivers: &Receivers, air: &Air) -> Key {
    let a = &design.acoustics;
    let mut key = Key::new()
        .with("coarser meshes, corrected; means above")
        .with(&format!("{:?} {:?} {air:?}", boxes(design), floor(design)))
        .with(&[a.bem_top, a.bem_panels, a.bem_tolerance])
        .with(&format!("{receivers:?}"));
    for body in structure.bodies() {
        key = key.with(body.name).with(&body.identity);
    }
    key
}

/// Height of the rigid floor where it is part of the equations; the block's underside is at 0 \[m\].
pub(super) fn floor(design: &Design) -> Option<f64> {
    let plane = reflecting_plane(design);
    (design.support.kind == SupportKind::Worktable || -plane <= FARTHEST_FLOOR).then_some(plane)
}

/// The microphones; where the floor is no part of the equations, their images in it behind them.
fn receivers(design: &Design) -> Receivers {
    let mut points = positions(design);
    if floor(design).is_none() {
        let image = |p: &Point3<f64>| Point3::new(p.x, p.y, 2.0 * reflecting_plane(design) - p.z);
        points.extend(points.iter().map(image).collect::<Vec<_>>());
    }
    let middle = match design.support.kind {
        SupportKind::Springs => 0.5 * design.workpiece.thickness,
        _ => 0.0,
    };
    Receivers {
        points,
        origin: Point3::new(0.0, 0.0, middle),
    }
}

fn centred([x, y]: [f64; 2], [low, high]: [f64; 2], part: usize) -> SolidBox {
    SolidBox {
        low: [-0.5 * x, -0.5 * y, low],
        high: [0.5 * x, 0.5 * y, high],
        part,
    }
}

/// The block, and where it stands on a table the table's top and legs (tubes are closed by top and floor). Their grid is that
/// of the bodies: the origin is the centre of the block's underside.
fn boxes(design: &Design) -> Vec<SolidBox> {
    let (block, table) = (&design.workpiece, &design.support.worktable);
    let mut boxes = vec![centred([block.length, block.width], [0.0, block.thickness], 0)];
    if design.support.kind != SupportKind::Worktable {
        return boxes;
    }
    let (thickness, leg) = match table.preset {
        WorktablePreset::A => (table.top_thickness, table.leg_width),
        WorktablePreset::B => (table.steel.top_thickness_b, table.steel.tube_width),
        WorktablePreset::C => (table.steel.top_thickness_c, table.steel.tube_width),
    };
    boxes.push(centred([table.length, table.width], [-thickness, 0.0], 1));
    let (x, y) = (0.5 * table.length, 0.5 * table.width);
    for from in [[-x, -y], [x - leg, -y], [-x, y - leg], [x - leg, y - leg]] {
        boxes.push(SolidBox {
            low: [from[0], from[1], -table.height],
            high: [from[0] + leg, from[1] + leg, -thickness],
            part: 2,
        });
    }
    boxes
}

/// Largest extent of what sounds \[m\].
fn largest_extent(boxes: &[SolidBox]) -> f64 {
    let extent = |axis: usize| {
        let ends = |b: &SolidBox| [b.low[axis], b.high[axis]];
        let (low, high) = boxes
            .iter()
            .map(ends)
            .fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), [from, to]| {
                (low.min(from), high.max(to))
            });
        high - low
    };
    (0..3).map(extent).fold(0.0, f64::max)
}

/// The surface of block and table on meshes that get finer with frequency, with the velocities of all modes. In any air the
/// meshes and the wavelengths up to which they serve are those of the matrix that is kept, see [`standing`].
///
/// # Errors
/// [`Error::NotBoxes`] for a mesh on a table that has not the sides of the design; those of mesh and radiation.
pub(super) fn levels(design: &Design, structure: &Structure, air: &Air) -> Result<Vec<Level>, Error> {
    let of_boxes = RANGES.iter().map(|share| of_boxes(design, structure, air, *share));
    let on_table = design.support.kind == SupportKind::Worktable;
    match of_boxes.collect() {
        Err(AcousticsError::Uncovered { .. }) if !on_table => Ok(vec![of_skin(design, &structure.workpiece, air)?]),
        Err(cause @ AcousticsError::Uncovered { .. }) => Err(Error::NotBoxes { cause }),
        other => Ok(other?),
    }
}

/// The boxes' surface up to a share of the top of all ranges.
fn of_boxes(design: &Design, structure: &Structure, air: &Air, share: f64) -> Result<Level, AcousticsError> {
    let (a, computed) = (&design.acoustics, Air::default());
    let (boxes, floor) = (boxes(design), floor(design));
    let on_table = design.support.kind == SupportKind::Worktable;
    let names: &[&str] = if on_table { &PATCHES } else { &ALONE };
    let own = if on_table { OF_WORKPIECE } else { ALONE.len() };
    let modes: Vec<DMatrix<f64>> = structure.bodies().map(|body| body.skin.map(f64::from)).collect();
    let parts: Vec<MovingPart<'_>> = structure
        .bodies()
        .zip(&modes)
        .zip([0..own, own..names.len()])
        .map(|((body, modes), patches)| MovingPart {
            skin: &body.surface,
            modes,
            patches,
        })
        .collect();
    let patch = |side: Side| match (side.part, side.axis, side.upper) {
        (0, 2, true) => 0,
        (0, 2, false) if !on_table => 2,
        (0, _, _) => 1,
        (1, 2, true) => 2,
        (1, 2, false) => 3,
        (1, _, _) => 4,
        _ => 5,
    };
    let top_hz = share * a.bem_top;
    let edge = (computed.sound_speed / (a.bem_panels * top_hz)).min(COARSEST * largest_extent(&boxes));
    let mirrors = [Some(0.0); 2];
    // A floor below the body needs no line of the grid.
    let lowest = boxes.iter().map(|b| b.low[2]).fold(f64::INFINITY, f64::min);
    let planes = [mirrors[0], mirrors[1], floor.filter(|floor| *floor >= lowest)];
    let names = names.iter().map(|&name| name.to_owned()).collect();
    let mesh = BoundaryMesh::of_boxes(&boxes, planes, edge, names, patch)?;
    let boundary = Boundary::symmetric(mesh, mirrors, floor)?;
    let patterns = boundary.transfer(&parts)?;
    let problem = Exterior::new(boundary, air).with_panels_per_wavelength(a.bem_panels)?;
    Ok(Level {
        problem,
        top_hz: top_hz * (air.sound_speed / computed.sound_speed),
        patterns,
    })
}

/// The faces of a block's own mesh, up to the frequency that they resolve.
fn of_skin(design: &Design, body: &Body, air: &Air) -> Result<Level, Error> {
    let (a, computed) = (&design.acoustics, Air::default());
    let open = open_faces(&body.surface, floor(design))?;
    let mut mesh = BoundaryMesh::of_skin(&body.surface);
    let mut open = open.into_iter();
    mesh.panels.retain(|_| open.next().unwrap_or(true));
    mesh.patches
        .iter_mut()
        .for_each(|name| name.insert_str(0, "workpiece "));
    let boundary = Boundary::new(mesh, floor(design))?;
    let patterns = Patterns {
        parity: Parity::default(),
        velocities: boundary.project_displacements(&body.skin.map(f64::from))?,
    };
    let resolved = boundary.highest_hz(computed.sound_speed, a.bem_panels);
    let problem = Exterior::new(boundary, air).with_panels_per_wavelength(a.bem_panels)?;
    Ok(Level {
        problem,
        top_hz: resolved.min(a.bem_top) * (air.sound_speed / computed.sound_speed),
        patterns: vec![patterns],
    })
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]

    use std::f64::consts::{PI, TAU};

    use nailnoise_acoustics::bem::TwoEvaluations;
    use nalgebra::Vector3;

    use super::super::bodies::{contact_grid, workpiece};
    use super::*;

    /// The coarse design with boundary elements to 400 Hz and something changed.
    fn small(text: &str) -> Design {
        let text = format!("base = \"small-bem.toml\"\nnail.length = \"20 mm\"\n{text}\n");
        Design::parse(&text, concat!(env!("CARGO_MANIFEST_DIR"), "/tests/data/over.toml")).unwrap()
    }

    /// Text of a block on a spring at a clearance.
    fn hung(clearance: f64) -> String {
        let zero = [
            "x = 0",
            "y = 0",
            "z = 0",
            "stiffness_x = 0",
            "stiffness_y = 0",
            "damping_x = 0",
        ]
        .join("\n");
        format!(
            "support.kind = \"springs\"\nsupport.clearance = {clearance}\n[springs.strap]\nbody = \"workpiece\"\n{zero}\n\
             damping_y = 0\ndamping_z = 20\nradius = 0.02\nstiffness_z = 2500"
        )
    }

    fn alone(design: &Design) -> Structure {
        Structure {
            workpiece: workpiece(design, &Store::none()).unwrap(),
            worktable: None,
            grid: contact_grid(design),
        }
    }

    /// Both evaluations of the resistance of a body that shakes along an axis \[kg/s\].
    fn shaken(level: &Level, body: &Body, axis: Vector3<f64>, hz: f64) -> [f64; 2] {
        let rigid: Vec<usize> = (0..body.omega.len()).filter(|&j| body.omega[j] == 0.0).collect();
        assert_eq!(rigid.len(), 6);
        let modes = body.skin.select_columns(&rigid).map(f64::from);
        let motion = DMatrix::from_fn(modes.nrows(), 1, |dof, _| axis[dof % 3]);
        let share = (modes.transpose() * &modes)
            .cholesky()
            .unwrap()
            .solve(&(modes.transpose() * motion));
        let pattern = |patterns: &Patterns| Patterns {
            velocities: patterns.velocities.select_columns(&rigid) * &share,
            ..patterns.clone()
        };
        let patterns: Vec<Patterns> = level.patterns.iter().map(pattern).collect();
        let found = level.problem.resistance_parities(hz, &patterns).unwrap();
        let surface = |two: &TwoEvaluations| two.patches.iter().map(|p| p[(0, 0)]).sum::<f64>();
        [
            found.iter().map(|two| two.far_field[(0, 0)]).sum(),
            found.iter().map(surface).sum(),
        ]
    }

    #[test]
    fn a_block_on_the_floor_is_half_of_one_twice_as_high_in_free_space() {
        let air = Air::default();
        let of = |text: &str| {
            let design = small(text);
            let structure = alone(&design);
            let finest = levels(&design, &structure, &air).unwrap().pop().unwrap();
            move |axis, hz| shaken(&finest, &structure.workpiece, axis, hz)
        };
        let held = of("support.kind = \"floor\"");
        let free = of(&format!("workpiece.thickness = \"190.5 mm\"\n{}", hung(3.0)));
        for (axis, hz) in [(Vector3::x(), 100.0), (Vector3::x(), 400.0), (Vector3::y(), 250.0)] {
            for (half, whole) in held(axis, hz).into_iter().zip(free(axis, hz)) {
                assert!((2.0 * half / whole - 1.0).abs() < 1e-3, "{hz} Hz: {half} of {whole}");
            }
        }
    }

    /// The force that a small shaken cube puts on the air is 1.6284 rho V a: the polarizability of a cube of no
    /// permittivity (Sihvola et al., IEEE Trans. Antennas Propag. 52, 2226 (2004)), which obeys the same equation. It
    /// radiates as a dipole, near the floor together with its image.
    #[test]
    fn a_small_cube_on_springs_radiates_as_a_dipole_and_above_a_floor_with_its_image() {
        let air = Air::default();
        let side: f64 = 0.06;
        let cube = format!(
            "workpiece.length = {side}\nworkpiece.width = {side}\nworkpiece.thickness = {side}\n\
             support.contact.points_along = 3\nsupport.contact.points_across = 3"
        );
        let of = |clearance: f64| {
            let design = small(&format!("{cube}\n{}", hung(clearance)));
            let structure = alone(&design);
            let finest = levels(&design, &structure, &air).unwrap().pop().unwrap();
            assert_eq!(finest.problem.boundary().floor().is_some(), clearance <= FARTHEST_FLOOR);
            move |axis, hz| shaken(&finest, &structure.workpiece, axis, hz)
        };
        let [free, near] = [3.0, 0.2].map(of);
        for hz in [50.0, 200.0] {
            let omega = TAU * hz;
            let force = 1.6284 * air.density * side.powi(3) * omega;
            let dipole = omega.powi(2) * force.powi(2) / (12.0 * PI * air.density * air.sound_speed.powi(3));
            let found = free(Vector3::z(), hz);
            // k a = 0.11 at 200 Hz adds its square.
            for found in found {
                assert!((found / dipole - 1.0).abs() < 0.01, "{hz} Hz: {found} against {dipole}");
            }
        }
        for hz in [100.0, 200.0, 350.0] {
            let x = 2.0 * TAU * hz / air.sound_speed * (0.2 + 0.5 * side);
            let image = 1.0 - 3.0 * (x.sin() / x + 2.0 * x.cos() / (x * x) - 2.0 * x.sin() / x.powi(3));
            let found = near(Vector3::z(), hz)[0] / free(Vector3::z(), hz)[0];
            assert!((found / image - 1.0).abs() < 0.01, "{hz} Hz: {found} against {image}");
        }
    }

    /// A mesh that is not the block of the design's dimensions.
    #[test]
    fn a_block_of_another_shape_radiates_from_its_own_faces_and_is_refused_on_a_table() {
        let air = Air::default();
        let floor = small("support.kind = \"floor\"\nworkpiece.thickness = \"90 mm\"");
        let structure = alone(&small("support.kind = \"floor\"\nworkpiece.thickness = \"90 mm\""));
        let boxes = levels(&floor, &structure, &air).unwrap().pop().unwrap();
        let longer = small("support.kind = \"floor\"\nworkpiece.thickness = \"90 mm\"\nworkpiece.length = \"410 mm\"");
        let own = levels(&longer, &structure, &air).unwrap();
        assert_eq!(own.len(), 1);
        assert!(
            own[0].problem.boundary().mended().on_floor == 0,
            "the underside is left out before"
        );
        assert!(own[0].problem.boundary().stands_on_floor());
        let names = &own[0].problem.boundary().mesh().patches;
        assert!(names.contains(&"workpiece top".to_owned()), "{names:?}");
        for (hz, axis) in [(100.0, Vector3::z()), (300.0, Vector3::x())] {
            let [a, b] = [&boxes, &own[0]].map(|level| shaken(level, &structure.workpiece, axis, hz)[0]);
            // The own faces are 60 mm wide.
            assert!((b / a - 1.0).abs() < 0.04, "{hz} Hz: {b} against {a}");
        }
        let table = small("support.kind = \"worktable\"\nworkpiece.length = \"410 mm\"");
        let error = levels(&table, &structure, &air).unwrap_err();
        assert!(matches!(error, Error::NotBoxes { .. }), "{error}");
        assert_eq!(error.exit_status(), 2);
    }
}
