//! The tool body: a parametric geometry that gmsh meshes, with the meshes of the ready designs on board.

use std::path::Path;

use crate::MeshError;
use crate::gmsh::{self, Job};
use crate::msh::{self, Imported};

/// The script of the geometry; its constants are the fields of [`Tool`] in millimetres.
const SCRIPT: &str = include_str!("../geo/tool.geo");

/// Meshes that ship. Their first words say of which dimensions they are; `data/make.sh` writes them.
const SHIPPED: [&[u8]; 1] = [include_bytes!("../data/tool-n80cb.msh.gz")];

macro_rules! tool {
    ($($(#[doc = $doc:literal])+ $name:ident,)+) => {
        /// Dimensions of the tool body, all in m: barrel with cap on a hollow nose, hollow handle, coil-magazine can, sleeve.
        ///
        /// z up from the nose's tip, the handle along +x.
        #[derive(Clone, Copy, Debug, PartialEq, serde::Serialize)]
        pub struct Tool {
            $($(#[doc = $doc])+ pub $name: f64,)+
        }

        impl Tool {
            /// Name and value \[m\] of every dimension.
            pub fn dimensions(&self) -> Vec<(&'static str, f64)> {
                vec![$((stringify!($name), self.$name),)+]
            }
        }
    };
}

tool! {
    /// Outer radius of the barrel.
    barrel_radius,
    /// Wall, floor and roof of the barrel.
    barrel_wall,
    /// Height of the barrel.
    barrel_height,
    /// Outer radius of the cap.
    cap_radius,
    /// Wall of the cap.
    cap_wall,
    /// Height of the cap.
    cap_height,
    /// Outer radius of the handle.
    handle_radius,
    /// Wall of the handle.
    handle_wall,
    /// Length of the handle.
    handle_length,
    /// Height of the handle's axis.
    handle_level,
    /// Outer radius of the magazine.
    magazine_radius,
    /// Wall of the magazine.
    magazine_wall,
    /// Axial length of the magazine.
    magazine_height,
    /// Distance of the magazine's axis from the barrel's.
    magazine_offset,
    /// Height of the magazine's axis.
    magazine_level,
    /// Depth of the arm between nose and magazine.
    arm_depth,
    /// Height of the arm.
    arm_height,
    /// Distance from the barrel's axis to which the arm reaches.
    arm_reach,
    /// Width of the nose.
    nose_width,
    /// Depth of the nose.
    nose_depth,
    /// Wall of the nose.
    nose_wall,
    /// Height of the nose.
    nose_height,
    /// Length of the nose within the barrel's floor.
    nose_overlap,
    /// Inner radius of the sleeve.
    sleeve_radius,
    /// Wall of the sleeve.
    sleeve_wall,
    /// Height of the sleeve.
    sleeve_height,
    /// Length of the sleeve's upper end that a fit holds in the barrel; 0 when it stands free.
    sleeve_fit,
    /// Largest side of an element.
    size,
}

impl Tool {
    /// All dimensions in one line of text, to a nanometre: what a mesh was made for.
    pub fn signature(&self) -> String {
        let mut words = vec!["tool".to_owned()];
        words.extend(
            self.dimensions()
                .iter()
                .map(|(name, value)| format!("{name}={:.6}", value * 1e3)),
        );
        words.join(" ")
    }
}

/// Whether the mesh of a tool body ships, so that no gmsh is needed.
pub fn tool_ships(spec: &Tool) -> bool {
    let signature = spec.signature();
    SHIPPED.iter().any(|bytes| {
        msh::parse(bytes, 1.0, Path::new("shipped tool body")).is_ok_and(|shipped| shipped.comment == signature)
    })
}

/// The mesh of a tool body: quadratic tetrahedra, parts `housing`, `nose` and `sleeve`, face groups `nose_tip`,
/// `gas_bore`, `bumper_seat`, `seat`, `cap`, `handle`, `magazine`, `supply` (within the handle), `plenum` (within the cap)
/// and `sleeve_outside`, and `fit_slave` (the sleeve's upper end), which is to be tied to `fit_master` (the barrel's inner
/// side; `barrel_inside` where the sleeve stands free).
///
/// A mesh that ships is taken where it was made for these dimensions and `anew` is not asked for; gmsh makes any other.
///
/// # Errors
/// [`MeshError::NoGmsh`], [`MeshError::Gmsh`], or those of [`msh::read`].
pub fn tool(spec: &Tool, anew: bool) -> Result<Imported, MeshError> {
    let signature = spec.signature();
    if !anew {
        for bytes in SHIPPED {
            let shipped = msh::parse(bytes, 1.0, Path::new("shipped tool body"))?;
            if shipped.comment == signature {
                return Ok(shipped);
            }
        }
    }
    let mut built = gmsh::run(&Job {
        what: "the tool body".to_owned(),
        script: SCRIPT,
        constants: spec
            .dimensions()
            .into_iter()
            .map(|(name, value)| (name, value * 1e3))
            .collect(),
        beside: None,
    })?;
    built.mesh.straighten();
    built.comment = signature;
    Ok(built)
}
