//! Modes of a body over frequency: radiation matrices, pressures at receivers, and fields in bands.

pub(crate) mod added_mass;
pub(crate) mod band_fields;
pub(crate) mod combination;
mod high_frequencies;
pub(crate) mod independent;
pub(crate) mod mean_ranges;
pub(crate) mod mesh_range;
pub(crate) mod modal;
pub(crate) mod packed_pressure;
pub(crate) mod range_solver;
pub(crate) mod receivers;
mod resistance;
mod shared;
pub(crate) mod solution_id;
pub(crate) mod summary;
pub(crate) mod surface_fit;
pub(crate) mod surface_pressures;

pub use band_fields::{BandFields, SurfaceBand, WholeSurface};
pub use high_frequencies::{MeanBand, MeanBands};
pub use mean_ranges::MeanRanges;
pub use mesh_range::MeshRange;
pub use modal::{ModalBem, ModalErp};
pub use receivers::{ModalPressures, Receivers};
pub use resistance::{Estimate, TwoEvaluations};
pub use summary::Summary;
pub use surface_fit::SurfaceFit;
pub use surface_pressures::SurfacePressures;
