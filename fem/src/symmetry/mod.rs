//! Mirror symmetry of the eigenproblem.

mod sectors;

pub(crate) use sectors::{Sector, sectors, whole};
