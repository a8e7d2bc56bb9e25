//! The boundary-element equations of one frequency.

use crate::bem::mesh::boundary::Boundary;
use crate::bem::mesh::symmetry::Image;
use crate::bem::operators::blocks::Block;
use crate::bem::operators::near::NearField;
use crate::bem::operators::wave::Wave;

/// The equations of one frequency.
pub(crate) struct Equations<'a> {
    pub(crate) boundary: &'a Boundary,
    pub(crate) images: &'a [Image],
    pub(crate) blocks: &'a [Block],
    pub(crate) near: &'a NearField,
    /// Integrals of phi_i phi_j over each panel.
    pub(crate) masses: &'a [[[f64; 4]; 4]],
    pub(crate) wave: Wave,
}
