//! Inputs of the radiation of workpiece and tool: surroundings, microphones, resolution, sand.

use nailnoise_acoustics::bem::{EquationSolver, SolidBox};
use nailnoise_acoustics::radiation::{AbsorbingSand, MovingSand};
use nailnoise_acoustics::radiator::Loading;
use nailnoise_fem::supports::Sand;
use nalgebra::Vector3;

use super::microphones::{positions, reflecting_plane, tool_height};
use crate::design::{
    BemEquations, BodyModel, Convention, Design, FluidLoading, RadiationMethod, SupportKind, SurfaceName,
    WorktablePreset,
};
use crate::error::Error;
use crate::stages::radiation::{
    CapSurface, Covered, FlushTop, Places, Resolution, ToolRadiation, WorkpieceBoundaryElements, WorkpieceRadiation,
};

/// Highest underside of a hung block whose floor is part of the equations \[m\]. The floor at the height h changes the
/// power by about sin(2 k h)/(2 k h), a ripple every c/2h. At twice the height it requires twice as many frequencies,
/// and it cancels in every wider band. The reflection of a farther floor at a microphone is the sound at the
/// microphone's image.
pub(crate) const FARTHEST_FLOOR: f64 = 1.0;

/// The part of the air's reaction that acts on the modes.
pub(crate) fn loading(design: &Design) -> Loading {
    match design.acoustics.fluid_loading {
        FluidLoading::None => Loading::None,
        FluidLoading::Damping => Loading::Damping,
        FluidLoading::Full => Loading::Full,
    }
}

/// How the radiation of the workpiece with its support is computed.
///
/// # Errors
/// [`Error::Sand`] when the sand's constants are outside the range of the foundation's formulas.
pub(crate) fn workpiece(design: &Design) -> Result<WorkpieceRadiation, Error> {
    Ok(match (design.support.kind, design.acoustics.method) {
        (SupportKind::Sandbox, _) => WorkpieceRadiation::Rayleigh(flush_top(design)?),
        (_, RadiationMethod::Erp) => WorkpieceRadiation::Erp(Covered {
            half_sides: [0.5 * design.workpiece.length, 0.5 * design.workpiece.width],
            underside_open: design.support.kind == SupportKind::Springs && design.support.clearance > 0.0,
        }),
        (_, RadiationMethod::Bem) => WorkpieceRadiation::BoundaryElements(workpiece_boundary_elements(design)),
    })
}

/// Boundary elements of the workpiece, and of a table below it.
pub(crate) fn workpiece_boundary_elements(design: &Design) -> WorkpieceBoundaryElements {
    WorkpieceBoundaryElements {
        resolution: resolution(design),
        boxes: boxes(design),
        on_table: design.support.kind == SupportKind::Worktable,
        floor: workpiece_floor(design),
    }
}

/// The microphones in the coordinates of the workpiece.
pub(crate) fn workpiece_places(design: &Design) -> Places {
    let image_in = workpiece_floor(design).is_none().then(|| reflecting_plane(design));
    let middle = match design.support.kind {
        SupportKind::Springs => 0.5 * design.workpiece.thickness,
        _ => 0.0,
    };
    Places::new(positions(design).into_iter(), image_in, middle)
}

/// Height of the rigid floor if it is part of the workpiece's equations; the block's underside is at 0 \[m\].
pub(crate) fn workpiece_floor(design: &Design) -> Option<f64> {
    let plane = reflecting_plane(design);
    (design.support.kind == SupportKind::Worktable || -plane <= FARTHEST_FLOOR).then_some(plane)
}

/// Boundary elements of the tool's body; none if the design does not request them.
pub(crate) fn tool(design: &Design) -> Option<ToolRadiation> {
    if design.acoustics.body_method == RadiationMethod::Erp {
        return None;
    }
    Some(ToolRadiation {
        resolution: resolution(design),
        floor: tool_floor(design),
    })
}

/// The microphones in the coordinates of the tool.
pub(crate) fn tool_places(design: &Design) -> Places {
    let nose = nose(design);
    let microphones = positions(design).into_iter().map(|point| point - nose);
    let image_in = tool_floor(design).is_none().then(|| plane_below_nose(design));
    Places::new(microphones, image_in, 0.5 * tool_height(design))
}

/// Height of the reflecting plane relative to the tip of the tool's nose \[m\], zero or negative.
fn plane_below_nose(design: &Design) -> f64 {
    reflecting_plane(design) - design.workpiece.thickness
}

/// That height if the plane is part of the tool's equations.
fn tool_floor(design: &Design) -> Option<f64> {
    let plane = plane_below_nose(design);
    (-plane < tool_height(design)).then_some(plane)
}

/// The outer side of the tool's cap, if it counts to another source than the rest of the body; none if the body's
/// radiation has no surface, such as that of a rigid body or a sphere.
pub(crate) fn cap(design: &Design) -> Option<CapSurface> {
    let body = &design.body;
    let by_surface = body.model == BodyModel::Elastic && design.acoustics.body_method == RadiationMethod::Bem;
    let apart = by_surface && design.sources.convention == Convention::Wrapping;
    apart.then(|| {
        if body.mesh.is_empty() {
            CapSurface::Above {
                height: body.nose_height + body.barrel_height,
                radius: body.cap_radius,
            }
        } else {
            CapSurface::Named(SurfaceName::CapOutside.as_str())
        }
    })
}

/// Position of the tool's nose in the coordinates of the workpiece \[m\].
pub(crate) fn nose(design: &Design) -> Vector3<f64> {
    let nail = &design.nail;
    Vector3::new(nail.offset_along, nail.offset_across, design.workpiece.thickness)
}

/// The block's top, flush with the sand.
///
/// # Errors
/// [`Error::Sand`] when the sand's constants are outside the range of the foundation's formulas.
pub(crate) fn flush_top(design: &Design) -> Result<FlushTop, Error> {
    let sand = &design.support.sand;
    let moving = sand.moving_surface.then(|| moving_sand(design)).transpose()?;
    Ok(FlushTop {
        top_hz: design.analysis.workpiece_top.min(design.analysis.range_high),
        places: Places::new(positions(design).into_iter(), None, design.workpiece.thickness),
        absorbing: absorbing_sand(design),
        moving,
    })
}

/// The sand's surface as an absorber.
pub(crate) fn absorbing_sand(design: &Design) -> AbsorbingSand {
    AbsorbingSand {
        resistivity: design.support.sand.flow_resistivity,
        share: design.support.sand.absorption_share,
    }
}

/// The sand's surface as it moves with the block.
///
/// # Errors
/// [`Error::Sand`] when the sand's constants are outside the range of the foundation's formulas.
pub(crate) fn moving_sand(design: &Design) -> Result<MovingSand, Error> {
    let (block, sand) = (&design.workpiece, &design.support.sand);
    let around = |length: f64| [-0.5 * length, 0.5 * length];
    let ground = Sand::new(sand.shear_modulus, sand.density, sand.poisson_ratio)?;
    Ok(MovingSand {
        footprint: [around(block.length), around(block.width)],
        sand: [around(sand.box_length), around(sand.box_width)],
        shear_speed: ground.shear_speed(),
        loss_factor: sand.loss_factor,
        to_hz: sand.moving_surface_top,
    })
}

fn resolution(design: &Design) -> Resolution {
    let acoustics = &design.acoustics;
    Resolution {
        top_hz: acoustics.bem_top,
        mean_top_hz: (acoustics.bem_mean_top > 0.0).then_some(acoustics.bem_mean_top),
        panels: acoustics.bem_panels,
        equations: match acoustics.bem_equations {
            BemEquations::Auto => EquationSolver::Auto,
            BemEquations::Dense => EquationSolver::Dense,
            BemEquations::Compressed => EquationSolver::Compressed,
        },
        tolerance: acoustics.bem_tolerance,
    }
}

fn centred([x, y]: [f64; 2], [low, high]: [f64; 2], part: usize) -> SolidBox {
    SolidBox {
        low: [-0.5 * x, -0.5 * y, low],
        high: [0.5 * x, 0.5 * y, high],
        part,
    }
}

/// The block, and where it stands on a table the table's top and legs, in the coordinates of the bodies.
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_near_plane_is_in_the_equations_a_far_one_at_the_microphones() {
        let design = |name: &str| Design::load(format!("{}/designs/{name}", env!("CARGO_MANIFEST_DIR"))).unwrap();
        let sand = tool(&design("n80cb-sandbox.toml")).unwrap();
        assert_eq!(sand.floor, Some(0.0));
        // Nine microphones and the operator's ear.
        assert_eq!(tool_places(&design("n80cb-sandbox.toml")).points.len(), 10);
        let table = design("n80cb.toml");
        let plane = reflecting_plane(&table) - table.workpiece.thickness;
        assert_eq!(tool(&table).unwrap().floor, None);
        let points = tool_places(&table).points;
        assert_eq!(points.len(), 20);
        for ([_, _, z], [_, _, image]) in points[..10].iter().zip(&points[10..]) {
            assert!(*z > plane && *image < plane);
            assert!((z + image - 2.0 * plane).abs() < 1e-12);
        }
    }
}
