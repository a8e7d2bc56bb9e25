//! Thin air gaps between a surface and the floor below, and panels that resolve the flow at their rims.
//!
//! In a gap of height h between a surface and the floor, the pressure obeys Reynolds' equation and varies over the
//! lateral extent of the gap, so panels may be many heights wide. At the rim, where the gap opens, the flow turns
//! within a distance of about h. Wide panels misplace the rim: they change the end correction of the gap by about 0.04
//! of their width w, whatever its height. The mass of the air in the gap is proportional to the cube of its extent.
//! That mass and the radiated power are therefore in error by about 3 0.04 w P/A, where A is the area of the gap and P
//! the length of its rim. At the rim, panels are therefore half as wide as the gap is high; they become wider with
//! distance from it.
//!
//! The constants come from blocks that heave 2 to 20 mm above a floor, see `docs/verification.md`.

use super::boundary::Boundary;
use super::panel::BoundaryMesh;
use super::symmetry::Image;
use nalgebra::{Point3, Vector3};
use rayon::prelude::*;
use std::collections::HashMap;

/// Width of the panels at the rim of a gap, relative to its height.
pub(crate) const RIM_WIDTH: f64 = 0.5;

/// Increase in panel width per distance from the rim: each panel may be twice as wide as its neighbour.
pub(crate) const GROWTH: f64 = 1.0;

/// Gap height below which panels are not refined further \[m\]; there, the neglect of viscosity outweighs the
/// discretisation error.
pub(crate) const LEAST_HEIGHT: f64 = 1e-3;

/// Largest ratio of the height of a thin gap to its area per rim length: a strip is at least four times as wide as it
/// is high, a square eight times. At the edges of higher gaps, panels need not be finer than at other edges.
const THIN: f64 = 0.5;

/// Tolerance factor for rounding in panels of exactly the required width.
const SLACK: f64 = 1.001;

/// Smallest cosine of the angle between the normal and the vertical for which a panel faces the floor. The same limit
/// applies to a panel that hides the floor.
const FACING: f64 = 0.5;

/// Cosine of the angle between two panels above which the edge is not sharp.
const SHARP: f64 = 0.866;

/// Error in the mass of the air in a gap relative to w P/A: three times the change 0.04 of the end correction per panel
/// width, that is 0.12. The value chosen is 0.15, a quarter more, because the study contains only rectangular blocks
/// and one cylinder. The errors found there are 4.8 and 6.2 %, with a bound of 7.5 %; the constant widens an
/// uncertainty and does not change any level.
const MASS_ERROR: f64 = 0.15;

/// Error of the power in third octaves relative to w P/A \[dB\]: for rim panels narrower than the gap is high, and for
/// wider ones. Near resonances of the gap, the power depends strongly on its extent, especially in thin gaps.
const BAND_ERROR: [f64; 2] = [1.0, 1.5];

/// Error of the power in wide bands relative to w P/A \[dB\]. Shifts of resonances cancel in such bands.
const LEVEL_ERROR: f64 = 0.5;

/// A thin gap: a connected part of the surface whose distance from the floor is less than half its area divided by the
/// length of its rim.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Gap {
    /// Smallest height \[m\].
    pub height: f64,
    /// Area divided by the length of the rim \[m\]: half the width of a strip, half the radius of a disc.
    pub extent: f64,
    /// Width across the rim of the widest panel at the rim \[m\].
    pub panel_width: f64,
}

impl Gap {
    /// Bound on the relative error of the mass of the air in the gap, and of the power below its resonances.
    ///
    /// Determined with a block that heaves 2 to 20 mm above a floor, with panels of 0.25 to 7.5 heights; see
    /// `docs/verification.md`.
    pub fn mass_error(&self) -> f64 {
        MASS_ERROR * self.panel_width / self.extent
    }

    /// Bound on the error of the power in third octaves \[dB\], for motion that pumps air through the gap.
    ///
    /// Determined as for [`Gap::mass_error`], from 0.3 to 2 kHz.
    pub fn band_error_db(&self) -> f64 {
        let [narrow, wide] = BAND_ERROR;
        // Panels exactly as wide as the gap is high count as narrow, up to rounding.
        let error = if self.panel_width < SLACK * self.height {
            narrow
        } else {
            wide
        };
        10.0 * (1.0 + error * self.panel_width / self.extent).log10()
    }

    /// Bound on the error of the total power over all bands \[dB\].
    ///
    /// Determined as for [`Gap::band_error_db`].
    pub fn level_error_db(&self) -> f64 {
        10.0 * (1.0 + LEVEL_ERROR * self.panel_width / self.extent).log10()
    }
}

/// Part of the rim of a gap.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Rim {
    /// Its ends \[m\].
    pub ends: [Point3<f64>; 2],
    /// Height of the gap there \[m\].
    pub height: f64,
}

impl Rim {
    /// Largest allowed length of a panel side between two points \[m\].
    fn side(&self, [a, b]: [Point3<f64>; 2], width: f64) -> f64 {
        let along = self.ends[1] - self.ends[0];
        let apart = |x: Point3<f64>| {
            let t = ((x - self.ends[0]).dot(&along) / along.norm_squared()).clamp(0.0, 1.0);
            (x - (self.ends[0] + along * t)).norm()
        };
        let apart = [a, nalgebra::center(&a, &b), b].map(apart);
        width * self.height.max(LEAST_HEIGHT) + GROWTH * apart.into_iter().fold(f64::INFINITY, f64::min)
    }
}

/// Largest length of a panel side between two points that all `rims` allow \[m\], with panels of `width` heights at the
/// rims.
pub(crate) fn longest_side(rims: &[Rim], ends: [Point3<f64>; 2], width: f64) -> f64 {
    let sides = rims.iter().map(|rim| rim.side(ends, width));
    sides.fold(f64::INFINITY, f64::min)
}

/// All thin gaps between a surface and the floor, and their rims: edges across which the surface turns by more than 30
/// degrees. Gaps between two parts of a surface are excluded because their error bounds are unknown, and so are gaps
/// that open along a fillet.
#[derive(Clone, Debug, Default)]
pub struct Gaps {
    all: Vec<(Gap, Vec<Rim>)>,
}

impl Gaps {
    /// Finds the gaps of a surface from the distance between each panel's centre and the floor along its normal.
    pub fn of(boundary: &Boundary) -> Self {
        let heights = heights(boundary);
        if heights.iter().all(Option::is_none) {
            return Self::default();
        }
        let mesh = boundary.mesh();
        let normals: Vec<Vector3<f64>> = (0..mesh.panels.len()).map(|p| normal(mesh, p)).collect();
        let edges = edges(mesh);
        // A panel above the floor is grouped with neighbours of similar height.
        let similar = |p: usize, q: usize| match (heights[p], heights[q]) {
            (Some(a), Some(b)) => a.max(b) <= 2.0 * a.min(b) || normals[p].dot(&normals[q]) > SHARP,
            _ => false,
        };
        let mut group: Vec<usize> = (0..mesh.panels.len()).collect();
        for panels in edges.values() {
            if let [p, q] = panels[..]
                && similar(p, q)
            {
                let (a, b) = (root(&group, p), root(&group, q));
                group[a] = b;
            }
        }
        let mut area: HashMap<usize, (f64, f64)> = HashMap::new();
        for (p, height) in heights.iter().enumerate() {
            if let Some(height) = height {
                let (area, least) = area.entry(root(&group, p)).or_insert((0.0, f64::INFINITY));
                *area += mesh.panel_area(p);
                *least = least.min(*height);
            }
        }
        let mut rims: HashMap<usize, (Vec<Rim>, f64)> = HashMap::new();
        let mut sorted: Vec<_> = edges.iter().collect();
        sorted.sort();
        for (&(a, b), panels) in sorted {
            // An edge of a single panel lies in a mirror plane, where the gap continues.
            let [p, q] = panels[..] else { continue };
            for (own, other) in [(p, q), (q, p)] {
                let Some(height) = heights[own] else { continue };
                if similar(p, q) || normals[p].dot(&normals[q]) > SHARP {
                    continue;
                }
                let ends = [mesh.points[a], mesh.points[b]];
                // At the closed end of a slot, the surface turns towards the air.
                let turn =
                    (mesh.point_at(other, mesh.panels[other].kind().centre()).position - ends[0]).dot(&normals[own]);
                if turn > 0.0 || heights[other].is_some_and(|beyond| beyond < height) {
                    continue;
                }
                let (rims, widest) = rims.entry(root(&group, own)).or_default();
                let share = mesh.panels[own].corners().len() as f64 - 2.0;
                let across = mesh.panel_area(own) * 2.0 / share.max(1.0) / (ends[1] - ends[0]).norm();
                let across = if share > 1.0 {
                    across
                } else {
                    across.min(longest(mesh, own))
                };
                *widest = widest.max(across);
                rims.push(Rim { ends, height });
            }
        }
        let mut all: Vec<(Gap, Vec<Rim>)> = Vec::new();
        for (number, (rims, panel_width)) in rims {
            let Some(&(area, height)) = area.get(&number) else {
                continue;
            };
            let length: f64 = rims.iter().map(|rim| (rim.ends[1] - rim.ends[0]).norm()).sum();
            let gap = Gap {
                height,
                extent: area / length,
                panel_width,
            };
            if gap.height < THIN * gap.extent {
                all.push((gap, rims));
            }
        }
        all.sort_by(|a, b| {
            a.0.height
                .total_cmp(&b.0.height)
                .then(a.0.extent.total_cmp(&b.0.extent))
        });
        Self { all }
    }

    /// The gaps, in ascending order of height.
    pub fn iter(&self) -> impl Iterator<Item = &Gap> {
        self.all.iter().map(|(gap, _)| gap)
    }

    /// The gap with the largest error.
    pub fn worst(&self) -> Option<Gap> {
        let error = |gap: &&Gap| gap.panel_width / gap.extent;
        self.iter().max_by(|a, b| error(a).total_cmp(&error(b))).copied()
    }

    /// Rims of gaps where panels are wider than half the height.
    pub fn coarse_rims(&self) -> Vec<Rim> {
        let coarse = self
            .all
            .iter()
            .filter(|(gap, _)| gap.panel_width > SLACK * RIM_WIDTH * gap.height.max(LEAST_HEIGHT));
        coarse.flat_map(|(_, rims)| rims.iter().copied()).collect()
    }
}

fn root(group: &[usize], mut p: usize) -> usize {
    while group[p] != p {
        p = group[p];
    }
    p
}

/// Panels adjacent to each edge.
fn edges(mesh: &BoundaryMesh) -> HashMap<(usize, usize), Vec<usize>> {
    let mut edges: HashMap<(usize, usize), Vec<usize>> = HashMap::new();
    for (p, panel) in mesh.panels.iter().enumerate() {
        let c = panel.corners();
        for k in 0..c.len() {
            let (a, b) = (c[k], c[(k + 1) % c.len()]);
            edges.entry((a.min(b), a.max(b))).or_default().push(p);
        }
    }
    edges
}

fn normal(mesh: &BoundaryMesh, panel: usize) -> Vector3<f64> {
    let centre = mesh.panels[panel].kind().centre();
    mesh.point_at(panel, centre).area_vector().normalize()
}

fn longest(mesh: &BoundaryMesh, panel: usize) -> f64 {
    let c = mesh.panels[panel].corners();
    let side = |k: usize| (mesh.points[c[k]] - mesh.points[c[(k + 1) % c.len()]]).norm();
    (0..c.len()).map(side).fold(0.0, f64::max)
}

/// Distance from each panel's centre to the floor along its normal \[m\]. None if the floor is not below it or is
/// farther away than half the extent of the body, or if another panel hides it.
fn heights(boundary: &Boundary) -> Vec<Option<f64>> {
    let mesh = boundary.mesh();
    let farthest = 0.5 * boundary.extents().max();
    let to_floor = |p: usize| {
        let from = mesh.point_at(p, mesh.panels[p].kind().centre()).position;
        let along = normal(mesh, p);
        let floor = boundary.floor().filter(|_| along.z < -FACING)?;
        let height = (floor - from.z) / along.z;
        (height < farthest).then_some((height, from, along))
    };
    let below: Vec<_> = (0..mesh.panels.len()).map(to_floor).collect();
    if below.iter().all(Option::is_none) {
        return vec![None; below.len()];
    }
    let images = boundary.images().into_iter().filter(|i| i.sign_along(2) > 0.0);
    let facets = facets(boundary, &images.collect::<Vec<_>>());
    let seen = |below: &Option<(f64, Point3<f64>, Vector3<f64>)>| {
        let (height, from, along) = (*below)?;
        let hidden = |facet: &Facet| facet.hit(from, along).is_some_and(|distance| distance < height);
        (!facets.iter().any(hidden)).then_some(height)
    };
    below.par_iter().map(seen).collect()
}

/// A triangle of the surface or of its image.
struct Facet {
    corner: Point3<f64>,
    sides: [Vector3<f64>; 2],
    normal: Vector3<f64>,
    centre: Point3<f64>,
    reach: f64,
}

impl Facet {
    /// Distance at which a ray hits the triangle from the air side \[m\].
    fn hit(&self, from: Point3<f64>, along: Vector3<f64>) -> Option<f64> {
        let towards = self.centre - from;
        let ahead = towards.dot(&along);
        if self.normal.dot(&along) > -FACING || towards.norm_squared() - ahead * ahead > self.reach * self.reach {
            return None;
        }
        // Möller & Trumbore (J. Graphics Tools 2, 21 (1997)).
        let [u, v] = self.sides;
        let h = along.cross(&v);
        let inverse = 1.0 / u.dot(&h);
        let s = from - self.corner;
        let a = inverse * s.dot(&h);
        let q = s.cross(&u);
        let (b, t) = (inverse * along.dot(&q), inverse * v.dot(&q));
        let slack = 1e-9;
        (a >= -slack && b >= -slack && a + b <= 1.0 + slack && t > 1e-6 * self.reach).then_some(t)
    }
}

/// The triangles of all panels and of their images in the mirror planes.
fn facets(boundary: &Boundary, images: &[Image]) -> Vec<Facet> {
    let mesh = boundary.mesh();
    let mut facets = Vec::new();
    for &image in images {
        for panel in &mesh.panels {
            let place = |n: usize| {
                let x = mesh.points[n];
                Point3::from(Vector3::from_fn(|axis, _| boundary.mirrored(image, axis, x[axis])))
            };
            let c = panel.corners();
            for k in 2..c.len() {
                let [x, y, z] = [c[0], c[k - 1], c[k]].map(place);
                let sides = [y - x, z - x];
                let centre = Point3::from((x.coords + y.coords + z.coords) / 3.0);
                let reach = [x, y, z].map(|x| (x - centre).norm()).into_iter().fold(0.0, f64::max);
                facets.push(Facet {
                    corner: x,
                    sides,
                    normal: sides[0].cross(&sides[1]).normalize() * image.handedness(),
                    centre,
                    reach,
                });
            }
        }
    }
    facets
}
