//! Comparison of a body's surfaces with those that a design has recorded. Without it, a point of the design could
//! silently refer to another face of a changed file.

use nailnoise_meshes::{Mesh, Surface};
use nalgebra::Vector3;

use crate::design::{Design, RecordedSurface, RecordedSurfaceProblem, SurfaceChange, SurfaceOf};
use crate::error::Error;
use crate::stages::bodies::BodyKind;
use crate::wording::trimmed;

/// Largest relative difference of an area. Between elements of 9 mm and of 18 mm, the areas of the housing in
/// `examples/housing` differ by at most 0.03 %, because quadratic elements follow a curved face.
const AREA: f64 = 0.05;

/// Largest distance between two centroids: this length \[m\], or this fraction of the side of a square of the same
/// area. The size of the elements moves the centroids of that housing by less than 0.01 mm, whereas a change of its
/// drawing moves them by millimetres.
const CENTRE: (f64, f64) = (1e-3, 0.02);

/// Factor on these two for a surface that a radius of the design cuts from a face, because such a surface consists of
/// complete elements. On the plate of that housing, a radius of 20 mm gives areas that differ by 3 %, and centroids 1.1
/// mm apart, between elements of 13 mm and of 18 mm.
const CUT: f64 = 3.0;

/// Largest distance between two mean normals: a plane that has turned by 6 degrees. The size of the elements changes
/// the normals of that housing by less than 0.001, the resolution of a record.
const NORMAL: f64 = 0.1;

/// Measures of a named surface.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct SurfaceMeasure {
    /// Its name.
    pub(crate) name: String,
    /// Its area \[m2\].
    pub(crate) area: f64,
    /// Its centroid \[m\].
    pub(crate) centre: Vector3<f64>,
    /// Integral of the outward unit normal over the surface, divided by the area \[-\].
    pub(crate) normal: Vector3<f64>,
}

impl SurfaceMeasure {
    /// The named surfaces of a mesh that have outer faces, in the order of the mesh.
    ///
    /// # Errors
    /// None that a valid mesh could cause.
    pub(crate) fn of_mesh(mesh: &Mesh) -> Result<Vec<Self>, Error> {
        let skin = Surface::of(mesh);
        let mut sums = vec![(0.0, Vector3::zeros(), Vector3::zeros()); skin.patches.len()];
        // Three points per direction integrate the Jacobian of a plane quadratic face exactly.
        // A face without area, in a damaged mesh, has no normal.
        for point in skin.quadrature(3)?.iter().filter(|point| point.weight > 0.0) {
            let (area, moment, normal) = &mut sums[skin.faces[point.face].patch];
            *area += point.weight;
            *moment += point.weight * point.position.coords;
            *normal += point.weight * point.normal;
        }
        let named = mesh.groups.iter().zip(sums).filter(|(_, (area, ..))| *area > 0.0);
        let measure = named.map(|(group, (area, moment, normal))| Self {
            name: group.name.clone(),
            area,
            centre: moment / area,
            normal: normal / area,
        });
        Ok(measure.collect())
    }
}

/// The errors of surfaces of a body from a file that do not agree with their records in the design.
///
/// # Errors
/// Those of [`SurfaceMeasure::of_mesh`].
pub(crate) fn changed(design: &Design, kind: BodyKind, mesh: &Mesh) -> Result<Vec<Error>, Error> {
    let body = SurfaceOf::from(kind);
    let records = design.recorded_surfaces.iter().filter(|(_, own)| own.body == body);
    let mut records = records.peekable();
    if records.peek().is_none() || !design.is_from_file(body) {
        return Ok(Vec::new());
    }
    let measures = SurfaceMeasure::of_mesh(mesh)?;
    let factor = |surface| {
        let mut places = design.surfaces.values();
        let is_cut = places.any(|own| own.body == body && own.surface == surface && own.radius > 0.0);
        if is_cut { CUT } else { 1.0 }
    };
    let problems = records.filter_map(|(name, record)| {
        let problem = problem(record, &measures, factor(record.surface))?;
        Some((name, problem))
    });
    Ok(problems
        .map(|(name, problem)| design.refuse_record(name, problem).into())
        .collect())
}

fn problem(record: &RecordedSurface, measures: &[SurfaceMeasure], factor: f64) -> Option<RecordedSurfaceProblem> {
    let RecordedSurface { body, surface, .. } = *record;
    let Some(found) = measures.iter().find(|found| found.name == surface.as_str()) else {
        return Some(RecordedSurfaceProblem::Missing {
            surface,
            body,
            known: measures.iter().map(|found| found.name.clone()).collect(),
        });
    };
    let changes = changes(record, found, factor);
    (!changes.is_empty()).then_some(RecordedSurfaceProblem::Changed { surface, body, changes })
}

/// The quantities of a surface that differ from its record; `factor` is that on the tolerances of area and centroid.
fn changes(record: &RecordedSurface, found: &SurfaceMeasure, factor: f64) -> Vec<SurfaceChange> {
    let mut changes = Vec::new();
    let cm2 = |area: f64| format!("{} cm2", trimmed(1e4 * area, area_decimals(record.area)));
    let of_area = found.area / record.area - 1.0;
    if of_area.abs() > factor * AREA {
        changes.push(SurfaceChange {
            quantity: "area",
            keys: &["area"],
            recorded: cm2(record.area),
            found: cm2(found.area),
            difference: percent(of_area.abs()),
            allowed: percent(factor * AREA),
        });
    }
    let mm = |length: f64| format!("{} mm", trimmed(1e3 * length, 2));
    let centre = Vector3::new(record.x, record.y, record.z);
    let (apart, allowed) = (
        (found.centre - centre).norm(),
        factor * CENTRE.0.max(CENTRE.1 * record.area.sqrt()),
    );
    if apart > allowed {
        changes.push(SurfaceChange {
            quantity: "centre",
            keys: &["x", "y", "z"],
            recorded: format!("{} mm", components(1e3 * centre)),
            found: format!("{} mm", components(1e3 * found.centre)),
            difference: mm(apart),
            allowed: mm(allowed),
        });
    }
    let normal = Vector3::new(record.normal_x, record.normal_y, record.normal_z);
    let turned = (found.normal - normal).norm();
    if turned > NORMAL {
        changes.push(SurfaceChange {
            quantity: "mean normal",
            keys: &["normal_x", "normal_y", "normal_z"],
            recorded: components(normal),
            found: components(found.normal),
            difference: trimmed(turned, 2),
            allowed: trimmed(NORMAL, 2),
        });
    }
    changes
}

fn percent(share: f64) -> String {
    format!("{} %", trimmed(100.0 * share, 1))
}

/// A vector with two decimals.
fn components(vector: Vector3<f64>) -> String {
    let [x, y, z] = [vector.x, vector.y, vector.z].map(|c| trimmed(c, 2));
    format!("({x}, {y}, {z})")
}

/// Decimals for an area in cm2: two, or more for four significant digits.
pub(crate) fn area_decimals(area: f64) -> usize {
    let digits = 3.0 - (1e4 * area).log10().floor();
    digits.clamp(2.0, 6.0) as usize
}
