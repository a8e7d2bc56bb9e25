//! Inputs of the radiation of workpiece and tool: surroundings, microphones, resolution and sand.

use nailnoise_acoustics::bem::{EquationSolver, SolidBox};
use nailnoise_acoustics::radiation::radiator::Loading;
use nailnoise_acoustics::{AcousticsError, Frame, PorousLayer};
use nalgebra::Vector3;

use super::bodies::block_size;
use super::microphones::{positions, reflecting_plane, tool_height};
use crate::design::{
    BemEquations, BodyModel, Convention, Cover, CoverFrame, CoverSurfaces, Design, FluidLoading, RadiationMethod,
    SurfaceName,
};
use crate::error::Error;
use crate::model::supports::{self, FlushSand};
use crate::stages::radiation::{
    CapSurface, CoveredFaces, CoveredSurfaces, FlushTop, Places, Resolution, ToolCover, ToolRadiation,
    WorkpieceBoundaryElements, WorkpieceRadiation,
};

/// The part of the air's reaction that acts on the modes.
pub(crate) fn loading(design: &Design) -> Loading {
    match design.acoustics.fluid_loading {
        FluidLoading::None => Loading::None,
        FluidLoading::Damping => Loading::Damping,
        FluidLoading::Full => Loading::Full,
    }
}

/// Settings for the radiation of the workpiece with its support.
///
/// # Errors
/// [`Error::Sand`] when the sand's constants are outside the range of the foundation's formulas.
pub(crate) fn workpiece(design: &Design) -> Result<WorkpieceRadiation, Error> {
    Ok(match (flush_top(design)?, design.acoustics.method) {
        (Some(top), _) => WorkpieceRadiation::Rayleigh(top),
        (None, RadiationMethod::Erp) => WorkpieceRadiation::Erp(covered_faces(design)),
        (None, RadiationMethod::Bem) => WorkpieceRadiation::BoundaryElements(workpiece_boundary_elements(design)),
    })
}

/// Faces of workpiece and support that do not radiate.
pub(crate) fn covered_faces(design: &Design) -> CoveredFaces {
    CoveredFaces {
        workpiece: supports::of(design).open_faces(),
        half_sides: [0.5 * design.workpiece.length, 0.5 * design.workpiece.width],
    }
}

/// Boundary-element settings of the workpiece and of a table below it.
pub(crate) fn workpiece_boundary_elements(design: &Design) -> WorkpieceBoundaryElements {
    let support = supports::of(design);
    let below = support.boxes();
    let [x, y, z] = block_size(design);
    let block = SolidBox {
        low: [-0.5 * x, -0.5 * y, 0.0],
        high: [0.5 * x, 0.5 * y, z],
        part: 0,
    };
    WorkpieceBoundaryElements {
        resolution: resolution(design),
        on_table: !below.is_empty(),
        boxes: std::iter::once(block).chain(below).collect(),
        floor: support.floor(),
    }
}

/// The microphones in the coordinates of the workpiece.
pub(crate) fn workpiece_places(design: &Design) -> Places {
    let support = supports::of(design);
    let image_in = support.floor().is_none().then(|| support.reflecting_plane());
    Places::new(positions(design).into_iter(), image_in, support.sound_centre())
}

/// Boundary-element settings of the tool body; `None` if the design does not request boundary elements.
///
/// # Errors
/// Those of [`cover`].
pub(crate) fn tool(design: &Design) -> Result<Option<ToolRadiation>, Error> {
    if design.acoustics.body_method == RadiationMethod::Erp {
        return Ok(None);
    }
    Ok(Some(ToolRadiation {
        resolution: resolution(design),
        floor: tool_floor(design),
        cover: cover(design)?,
    }))
}

/// The porous cover on the tool.
///
/// # Errors
/// Those of the ambient air and of the layer.
fn cover(design: &Design) -> Result<Option<ToolCover>, Error> {
    let cover = &design.body.cover;
    let cap = cap_surface(design);
    let surfaces = match cover.surfaces {
        CoverSurfaces::None => return Ok(None),
        CoverSurfaces::Housing => CoveredSurfaces::Housing(cap),
        CoverSurfaces::Cap => CoveredSurfaces::Cap(cap),
        CoverSurfaces::Both => CoveredSurfaces::Both,
    };
    let layer = porous_layer(cover)?.in_standard_air(&super::air(design)?);
    Ok(Some(ToolCover { layer, surfaces }))
}

fn porous_layer(cover: &Cover) -> Result<PorousLayer, Error> {
    let frame = match cover.frame {
        CoverFrame::Moving => Frame::Moving,
        CoverFrame::Resting => Frame::Resting,
    };
    Ok(PorousLayer::new(cover.thickness, cover.resistivity, frame).map_err(AcousticsError::from)?)
}

/// Description of the cover on the tool, for notes.
///
/// # Errors
/// Those of the layer.
pub(crate) fn cover_note(design: &Design) -> Result<Option<String>, Error> {
    let cover = &design.body.cover;
    let surfaces = match cover.surfaces {
        CoverSurfaces::None => return Ok(None),
        CoverSurfaces::Housing => "housing",
        CoverSurfaces::Cap => "cap",
        CoverSurfaces::Both => "housing and cap",
    };
    let (fitted, top) = (porous_layer(cover)?.fitted_to_hz(), design.analysis.range_high);
    let beyond = if fitted < top {
        format!("; the law of the material is extrapolated from {fitted:.0} Hz to {top:.0} Hz")
    } else {
        String::new()
    };
    Ok(Some(format!(
        "body: porous cover of {:.1} mm with {:.1} kPa s/m2 on the {surfaces}, its frame {}; the level is that of the \
         sound outside it{beyond}",
        1e3 * cover.thickness,
        1e-3 * cover.resistivity,
        match cover.frame {
            CoverFrame::Moving => "moving with the wall",
            CoverFrame::Resting => "at rest",
        },
    )))
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

/// This height if the plane is included in the equations of the tool.
fn tool_floor(design: &Design) -> Option<f64> {
    let plane = plane_below_nose(design);
    (-plane < tool_height(design)).then_some(plane)
}

/// The outer side of the tool's cap, if it is assigned to another source than the rest of the body. `None` if the
/// body's radiation has no surface, as for a rigid body or a sphere.
pub(crate) fn cap(design: &Design) -> Option<CapSurface> {
    let body = &design.body;
    let by_surface = body.model == BodyModel::Elastic && design.acoustics.body_method == RadiationMethod::Bem;
    let apart = by_surface && design.sources.convention == Convention::Wrapping;
    apart.then(|| cap_surface(design))
}

/// The outer side of the tool's cap.
pub(crate) fn cap_surface(design: &Design) -> CapSurface {
    let body = &design.body;
    if body.mesh.is_empty() {
        CapSurface::Above {
            height: body.nose_height + body.barrel_height,
            radius: body.cap_radius,
        }
    } else {
        CapSurface::Named(SurfaceName::CapOutside.as_str())
    }
}

/// Position of the tool's nose in the coordinates of the workpiece \[m\].
pub(crate) fn nose(design: &Design) -> Vector3<f64> {
    let nail = &design.nail;
    Vector3::new(nail.offset_along, nail.offset_across, design.workpiece.thickness)
}

/// The top of the block, if it is flush with the sand.
///
/// # Errors
/// [`Error::Sand`] when the sand's constants are outside the range of the foundation's formulas.
fn flush_top(design: &Design) -> Result<Option<FlushTop>, Error> {
    let sand = supports::of(design).flush_sand()?;
    Ok(sand.map(|FlushSand { absorbing, moving }| FlushTop {
        top_hz: design.analysis.workpiece_max_frequency.min(design.analysis.range_high),
        places: Places::new(positions(design).into_iter(), None, design.workpiece.thickness),
        absorbing,
        moving,
    }))
}

fn resolution(design: &Design) -> Resolution {
    let acoustics = &design.acoustics;
    Resolution {
        top_hz: acoustics.bem_max_frequency,
        mean_top_hz: (acoustics.bem_mean_max_frequency > 0.0).then_some(acoustics.bem_mean_max_frequency),
        panels: acoustics.bem_panels,
        equations: match acoustics.bem_equations {
            BemEquations::Auto => EquationSolver::Auto,
            BemEquations::Dense => EquationSolver::Dense,
            BemEquations::Compressed => EquationSolver::Compressed,
        },
        tolerance: acoustics.bem_tolerance,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_near_plane_is_in_the_equations_a_far_one_at_the_microphones() {
        let design = |name: &str| Design::load(format!("{}/designs/{name}", env!("CARGO_MANIFEST_DIR"))).unwrap();
        let sand = tool(&design("n80cb-sandbox.toml")).unwrap().unwrap();
        assert_eq!(sand.floor, Some(0.0));
        // Nine microphones and the operator's ear.
        assert_eq!(tool_places(&design("n80cb-sandbox.toml")).points.len(), 10);
        let table = design("n80cb.toml");
        let plane = reflecting_plane(&table) - table.workpiece.thickness;
        assert_eq!(tool(&table).unwrap().unwrap().floor, None);
        let points = tool_places(&table).points;
        assert_eq!(points.len(), 20);
        for ([_, _, z], [_, _, image]) in points[..10].iter().zip(&points[10..]) {
            assert!(*z > plane && *image < plane);
            assert!((z + image - 2.0 * plane).abs() < 1e-12);
        }
    }
}
