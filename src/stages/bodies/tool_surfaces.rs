//! Recognises surfaces of a tool's housing by the axis and the bore of its cylinder.

use nailnoise_meshes::{MeshError, SmoothFace, Surface, open_faces};
use nalgebra::Vector3;
use serde::Serialize;

/// Dimensions by which the surfaces of a tool are recognised. The axis of the cylinder is x = y = 0, z points up from
/// the tip of the nose, and the handle points along +x.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct ToolShape {
    /// Radius of the bore \[m\].
    pub bore: f64,
}

/// Maximum deviation of the bore's nodes from its radius, relative to the radius.
const OFF_RADIUS: f64 = 0.05;

/// Minimum axial component of the mean normal of a plane; it corresponds to 2.5 degrees.
const PLANE: f64 = 0.999;

/// Minimum mean inward radial component of the normals of a bore.
const INWARD: f64 = 0.98;

/// A smooth face with its extent around the axis.
struct Ring<'a> {
    face: &'a SmoothFace,
    /// Distances of its nodes from the axis \[m\].
    radius: [f64; 2],
    /// Heights of its nodes \[m\].
    height: [f64; 2],
    /// Mean outward radial component of its normals.
    radial: f64,
    /// Whether it is exposed to the open air.
    open: bool,
}

impl ToolShape {
    /// Names of the surfaces of a tool.
    pub const NAMES: [&'static str; 7] = [
        "gas_bore",
        "bumper_seat",
        "seat",
        "cap",
        "nose_tip",
        "handle",
        "magazine",
    ];

    /// The recognised surfaces, by name, each with its element faces. The bore is a cylinder around the axis with the
    /// piston's radius. The bumper's seat is the floor inside it, and the seat is the annulus around its upper end. The
    /// cap is the lowest ceiling above it, and the tip of the nose the lowest plane around the axis. The handle is the
    /// largest outer face beyond half the reach along +x. The magazine has no distinctive shape.
    ///
    /// # Errors
    /// The errors of the surface.
    pub(super) fn guesses(
        &self,
        surface: &Surface,
        smooth: &[SmoothFace],
    ) -> Result<Vec<(&'static str, Vec<usize>)>, MeshError> {
        let open = open_faces(surface, None)?;
        let rings: Vec<Ring<'_>> = smooth.iter().map(|face| Ring::new(surface, face, &open)).collect();
        let largest = |a: &&Ring<'_>, b: &&Ring<'_>| a.face.area.total_cmp(&b.face.area);
        let lowest = |a: &&Ring<'_>, b: &&Ring<'_>| a.height[0].total_cmp(&b.height[0]);
        let around = |ring: &Ring<'_>| ring.face.centroid.x.hypot(ring.face.centroid.y) < 0.5 * self.bore;
        let near = |a: f64, b: f64| (a - b).abs() <= OFF_RADIUS * self.bore;
        let of_bore = |ring: &&Ring<'_>| ring.radius.iter().all(|r| near(*r, self.bore)) && ring.radial < -INWARD;
        let bore = rings.iter().filter(of_bore).max_by(largest);
        let mut guesses: Vec<(&'static str, Option<&Ring<'_>>)> = vec![("gas_bore", bore)];
        if let Some(bore) = bore {
            let [bottom, top] = bore.height;
            let up = |ring: &&Ring<'_>| ring.face.normal.z > PLANE && around(ring);
            let within = |ring: &&Ring<'_>| ring.radius[1] <= (1.0 + OFF_RADIUS) * self.bore;
            let floor = |ring: &&Ring<'_>| up(ring) && within(ring) && (ring.height[0] - bottom).abs() <= self.bore;
            let rim = |ring: &&Ring<'_>| {
                up(ring) && near(ring.radius[0], self.bore) && (ring.height[0] - top).abs() <= self.bore
            };
            let ceiling = |ring: &&Ring<'_>| ring.face.normal.z < -PLANE && around(ring) && ring.height[0] >= top;
            guesses.push(("bumper_seat", rings.iter().filter(floor).max_by(largest)));
            guesses.push(("seat", rings.iter().filter(rim).max_by(largest)));
            guesses.push(("cap", rings.iter().filter(ceiling).min_by(lowest)));
        }
        let tip = |ring: &&Ring<'_>| ring.face.normal.z < -PLANE && around(ring) && ring.open;
        guesses.push(("nose_tip", rings.iter().filter(tip).min_by(lowest)));
        let reach = surface.points.iter().map(|p| p.x).fold(0.0, f64::max);
        let grip = |ring: &&Ring<'_>| ring.open && ring.face.centroid.x > 0.5 * reach;
        guesses.push(("handle", rings.iter().filter(grip).max_by(largest)));
        let found = guesses.into_iter();
        Ok(found
            .filter_map(|(name, ring)| Some((name, ring?.face.faces.clone())))
            .collect())
    }
}

impl<'a> Ring<'a> {
    fn new(surface: &Surface, face: &'a SmoothFace, open: &[bool]) -> Self {
        let (mut radius, mut height) = ([f64::INFINITY, 0.0], [f64::INFINITY, f64::NEG_INFINITY]);
        let mut radial = 0.0;
        for &index in &face.faces {
            let own = &surface.faces[index];
            for &node in own.nodes.iter() {
                let p = surface.points[node];
                let r = p.x.hypot(p.y);
                radius = [radius[0].min(r), radius[1].max(r)];
                height = [height[0].min(p.z), height[1].max(p.z)];
            }
            let centre = surface.point_at(index, own.kind.centre());
            let outward = Vector3::new(centre.position.x, centre.position.y, 0.0).try_normalize(0.0);
            radial += outward.map_or(0.0, |outward| outward.dot(&centre.normal));
        }
        Self {
            face,
            radius,
            height,
            radial: radial / face.faces.len() as f64,
            open: face.faces.iter().any(|&index| open[index]),
        }
    }
}
