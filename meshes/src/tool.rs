//! The tool body: a parametric geometry meshed by gmsh; meshes of the shipped designs are embedded.

use std::f64::consts::TAU;
use std::io::Read;
use std::path::Path;

use flate2::read::GzDecoder;
use nailnoise_quantities::dimension::LENGTH;
use nailnoise_quantities::{Group, Value, group, nonnegative, positive};

use crate::MeshError;
use crate::gmsh::{self, Job};
use crate::msh::{self, Imported};

/// The script of the geometry; its constants are the fields of [`Tool`] in millimetres.
const SCRIPT: &str = include_str!("../geo/tool.geo");

/// Embedded meshes. Their comment states the dimensions; `data/make.sh` writes them.
const SHIPPED: [&[u8]; 1] = [include_bytes!("../data/tool-n80cb.msh.gz")];

/// Length of the initial part of an embedded mesh that contains its comment \[byte\].
const BEGINNING: u64 = 4096;

group! {
    /// Dimensions of the tool body: barrel with cap on a hollow nose, hollow handle, coil-magazine can, cylinder
    /// sleeve; z up from the nose's tip, the handle along +x.
    ToolDimensions {
        /// Wall of the barrel, its floor and its roof. Its outer radius follows from bore, sleeve, gap and wall.
        barrel_wall: f64 = positive(LENGTH).within(1e-4, 2.0), "";
        /// Height of the barrel.
        barrel_height: f64 = positive(LENGTH).within(1e-4, 2.0), "";
        /// Outer radius of the cap on the barrel.
        cap_radius: f64 = positive(LENGTH).within(1e-4, 2.0), "";
        /// Wall of the cap, closed on both sides.
        cap_wall: f64 = positive(LENGTH).within(1e-4, 2.0), "";
        /// Height of the cap.
        cap_height: f64 = positive(LENGTH).within(1e-4, 2.0), "";
        /// Length of the handle.
        handle_length: f64 = positive(LENGTH).within(1e-4, 2.0), "";
        /// Outer radius of the handle.
        handle_radius: f64 = positive(LENGTH).within(1e-4, 2.0), "";
        /// Wall of the handle's tube and its outer end.
        handle_wall: f64 = positive(LENGTH).within(1e-4, 2.0), "";
        /// Height of the handle's axis over the nose's tip.
        handle_level: f64 = positive(LENGTH).within(1e-4, 2.0), "";
        /// Outer radius of the magazine.
        magazine_radius: f64 = positive(LENGTH).within(1e-4, 2.0), "";
        /// Wall of the magazine, closed on both sides.
        magazine_wall: f64 = positive(LENGTH).within(1e-4, 2.0), "";
        /// Height (axial length) of the magazine.
        magazine_height: f64 = positive(LENGTH).within(1e-4, 2.0), "";
        /// Distance of the magazine's axis, which lies along y, from that of the barrel.
        magazine_offset: f64 = positive(LENGTH).within(1e-4, 2.0), "";
        /// Height of the magazine's axis, and of the arm that joins it to the nose, over the nose's tip.
        magazine_level: f64 = positive(LENGTH).within(1e-4, 2.0), "";
        /// Depth of the arm, along y.
        arm_depth: f64 = positive(LENGTH).within(1e-4, 2.0), "";
        /// Height of the arm.
        arm_height: f64 = positive(LENGTH).within(1e-4, 2.0), "";
        /// Distance to which the arm reaches into the magazine, from the barrel's axis.
        arm_reach: f64 = positive(LENGTH).within(1e-4, 2.0), "";
        /// Width of the steel nose.
        nose_width: f64 = positive(LENGTH).within(1e-4, 2.0), "";
        /// Depth of the steel nose.
        nose_depth: f64 = positive(LENGTH).within(1e-4, 2.0), "";
        /// Height of the steel nose.
        nose_height: f64 = positive(LENGTH).within(1e-4, 2.0), "";
        /// Wall of the nose, which is open below.
        nose_wall: f64 = positive(LENGTH).within(1e-4, 2.0), "";
        /// Length of the nose that sits in the barrel's floor, above its height.
        nose_overlap: f64 = positive(LENGTH).within(1e-4, 2.0), "";
        /// Wall of the cylinder sleeve, whose inner radius is half the piston's bore.
        sleeve_wall: f64 = positive(LENGTH).within(1e-4, 2.0), "";
        /// Height of the sleeve, which stands on the barrel's floor.
        sleeve_height: f64 = positive(LENGTH).within(1e-4, 2.0), "";
        /// Gap between sleeve and barrel, all round.
        sleeve_gap: f64 = positive(LENGTH).within(1e-4, 2.0), "";
        /// Length of the sleeve's upper end that a fit holds in the barrel; 0 when the sleeve stands free.
        sleeve_fit: f64 = nonnegative(LENGTH).within(0.0, 2.0), "";
    }
}

group! {
    /// The tool body to mesh.
    Tool {
        ..dimensions: ToolDimensions;
        /// Inner radius of the sleeve.
        sleeve_radius: f64 = positive(LENGTH), "";
        /// Largest side of an element.
        size: f64 = positive(LENGTH), "";
    }
}

impl ToolDimensions {
    /// Outer radius of the barrel, given the sleeve's inner radius \[m\].
    pub fn barrel_radius(&self, sleeve_radius: f64) -> f64 {
        sleeve_radius + self.sleeve_wall + self.sleeve_gap + self.barrel_wall
    }
}

impl Tool {
    /// Names and values \[m\] of the constants of the geometry script: the radius of the barrel, then all dimensions
    /// except the gap, which the radius already includes.
    pub fn dimensions(&self) -> Vec<(&'static str, f64)> {
        let mut dimensions = vec![("barrel_radius", self.barrel_radius(self.sleeve_radius))];
        self.visit("", &mut |_, spec, value| match value {
            Value::Number(metres) if spec.name != "sleeve_gap" => dimensions.push((spec.name, metres)),
            _ => {}
        });
        dimensions
    }

    /// All dimensions to a nanometre in one line, which identifies the geometry of a mesh.
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

/// Whether the mesh of a tool body is embedded, so that gmsh is not needed.
pub fn tool_ships(spec: &Tool) -> bool {
    shipped(spec).is_some()
}

/// The embedded mesh of a tool body. Only its beginning is decompressed, because studies call this for every design.
fn shipped(spec: &Tool) -> Option<&'static [u8]> {
    let signature = spec.signature();
    SHIPPED.into_iter().find(|bytes| {
        let mut beginning = Vec::new();
        let read = GzDecoder::new(*bytes).take(BEGINNING).read_to_end(&mut beginning);
        let mut lines = beginning.split(|&byte| byte == b'\n');
        read.is_ok() && lines.any(|line| line.starts_with(signature.as_bytes()))
    })
}

impl Tool {
    /// Limit on gmsh's processor time with the elastic analogy \[s\]: 20 s plus 38 ms per element-sized square of wall
    /// area, about five times the time for the shipped dimensions (4 to 9 s). Without the analogy, the shipped
    /// dimensions take 1.4 to 1.9 s, and a third of the limit applies. If the dimensions make the body intersect
    /// itself, gmsh may never finish.
    fn seconds(&self) -> f64 {
        let barrel = self.barrel_radius(self.sleeve_radius);
        let tubes = [
            (barrel, self.barrel_height),
            (self.cap_radius, self.cap_height + self.cap_radius),
            (self.handle_radius, self.handle_length),
            (self.magazine_radius, self.magazine_height + self.magazine_radius),
            (self.sleeve_radius, self.sleeve_height),
        ];
        let area: f64 = tubes.iter().map(|(radius, height)| TAU * radius * height).sum();
        20.0 + 0.038 * area / (self.size * self.size)
    }
}

/// Meshes a tool body with quadratic tetrahedra; the parts are `housing`, `cap`, `nose` and `sleeve`. The face groups
/// are `nose_tip`, `gas_bore`, `bumper_seat`, `seat`, `cap`, `handle`, `magazine`, `supply` (within the handle),
/// `plenum` (within the cap) and `sleeve_outside`. `fit_slave` (the sleeve's upper end) must be tied to `fit_master`
/// (the barrel's inner surface; `barrel_inside` for a free sleeve). Like the body, the mesh is symmetric about y = 0:
/// gmsh meshes the half at y >= 0, and the other half is its mirror image.
///
/// The embedded mesh is used if it was made for these dimensions, unless `anew` is set; otherwise gmsh makes the mesh.
///
/// # Errors
/// [`MeshError::NoGmsh`], [`MeshError::Gmsh`], or those of [`msh::read`].
pub fn tool(spec: &Tool, anew: bool) -> Result<Imported, MeshError> {
    if let Some(bytes) = shipped(spec).filter(|_| !anew) {
        return msh::parse(bytes, 1.0, Path::new("shipped tool body"));
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
        reports: &[],
        seconds: Some(spec.seconds()),
    })?;
    built.mesh.straighten();
    built.add_image();
    built.comment = spec.signature();
    Ok(built)
}
