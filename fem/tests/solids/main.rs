//! Elements, materials and modes.
#![allow(clippy::unwrap_used)]

#[path = "../common/bodies.rs"]
mod bodies;
#[path = "../common/kinds.rs"]
mod kinds;

mod material;

mod assembly {
    mod element;
    mod stress;
    mod system;
}
mod eigen {
    mod assurance;
    mod modes;
    mod spheres;
}
mod factor {
    mod elimination;
}
mod reduction {
    mod attachments;
}
mod symmetry {
    mod sectors;
}
