//! Surfaces of a body from a file as they were recorded, to recognise a changed file.

use nailnoise_quantities::dimension::{AREA, LENGTH};
use nailnoise_quantities::{any, component, group, positive};

use super::surfaces::{SurfaceName, SurfaceOf};

group! {
    /// A named surface of a body from a file as it was when `nailnoise check DESIGN --body BODY --record-surfaces FILE`
    /// wrote this record. `check` and every run compare it with the body's mesh, and refuse a file in which the surface
    /// has moved. No result depends on it. It has no effect on a body that is built in or absent. The origin is that of
    /// `surfaces.NAME`.
    RecordedSurface {
        /// The body.
        body: SurfaceOf = SurfaceOf::KIND, "";
        /// The surface.
        surface: SurfaceName = SurfaceName::KIND, "";
        /// Its area.
        area: f64 = positive(AREA), "A";
        /// Position of its centroid along x.
        x: f64 = any(LENGTH), "x";
        /// Position of its centroid along y.
        y: f64 = any(LENGTH), "y";
        /// Height of its centroid.
        z: f64 = any(LENGTH), "z";
        /// Component along x of its mean normal: the integral of the unit normal out of the body over the surface,
        /// divided by the area. Its length is 1 for a plane, and 0 for a complete bore or tube.
        normal_x: f64 = component(), "";
        /// Component along y of its mean normal.
        normal_y: f64 = component(), "";
        /// Component along z of its mean normal.
        normal_z: f64 = component(), "";
    }
}

/// A quantity of a surface that differs from its record, with its values in words.
#[derive(Debug, Clone, PartialEq)]
pub struct SurfaceChange {
    /// The quantity.
    pub quantity: &'static str,
    /// Keys of the record that state it.
    pub keys: &'static [&'static str],
    /// Its recorded value.
    pub recorded: String,
    /// Its value in the mesh.
    pub found: String,
    /// The difference of the two.
    pub difference: String,
    /// The largest difference allowed.
    pub allowed: String,
}

/// The fault in the record of a surface.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum RecordedSurfaceProblem {
    /// The surface belongs to another body.
    #[error("names the surface `{}`, which the {} does not have", surface.as_str(), body.as_str())]
    OfOtherBody {
        /// The surface.
        surface: SurfaceName,
        /// The body.
        body: SurfaceOf,
    },
    /// The mesh has no such surface any more.
    #[error("records the surface `{}`, which the mesh of the {} does not have; it has: {}", surface.as_str(),
        body.as_str(), known.join(", "))]
    Missing {
        /// The surface.
        surface: SurfaceName,
        /// The body.
        body: SurfaceOf,
        /// Surfaces of the mesh.
        known: Vec<String>,
    },
    /// The surface of this name is another one than was recorded.
    #[error("does not agree with the surface `{}` in the mesh of the {}: {}", surface.as_str(), body.as_str(),
        in_words(changes))]
    Changed {
        /// The surface.
        surface: SurfaceName,
        /// The body.
        body: SurfaceOf,
        /// What differs.
        changes: Vec<SurfaceChange>,
    },
}

/// The changes of a surface in one sentence.
fn in_words(changes: &[SurfaceChange]) -> String {
    let change = |own: &SurfaceChange| {
        let SurfaceChange {
            quantity,
            recorded,
            found,
            difference,
            allowed,
            ..
        } = own;
        format!("{quantity} {recorded} recorded, {found} found ({difference} apart, {allowed} allowed)")
    };
    changes.iter().map(change).collect::<Vec<_>>().join("; ")
}

impl RecordedSurfaceProblem {
    /// The keys of the record that are at fault.
    pub(crate) fn keys(&self) -> Vec<&'static str> {
        match self {
            Self::OfOtherBody { .. } => vec!["surface", "body"],
            Self::Missing { .. } => vec!["surface"],
            Self::Changed { changes, .. } => changes.iter().flat_map(|change| change.keys).copied().collect(),
        }
    }

    /// The remedy.
    pub(crate) fn remedy(&self) -> String {
        let (surface, body) = match self {
            Self::OfOtherBody { body, .. } => return body.known_surfaces(),
            Self::Missing { surface, body, .. } | Self::Changed { surface, body, .. } => {
                (surface.as_str(), body.as_str())
            }
        };
        format!(
            "if another face has the name now, correct the place of `{surface}` in [surfaces.NAME], or its name in the \
             file; if the change is meant, record the surfaces again (`nailnoise check DESIGN --body {body} \
             --record-surfaces FILE`) and replace the records in the design"
        )
    }
}
