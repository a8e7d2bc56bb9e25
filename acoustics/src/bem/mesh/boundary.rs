use super::panel::{BoundaryMesh, Panel, PanelPoint, PanelShape};
use super::rules;
use super::symmetry::Image;
use crate::bem::error::BemError;
use nalgebra::{DMatrix, Matrix4, Point3, Vector3, Vector4};
use std::collections::HashMap;

/// A surface that is valid for the exterior problem: closed (or open only where it stands on the floor), with normals
/// into the air, and above the floor.
///
/// If body and air are symmetric about planes of constant x or y, only the part above those planes is needed; it is
/// open there.
#[derive(Clone, Debug)]
pub struct Boundary {
    mesh: BoundaryMesh,
    planes: [Option<f64>; 3],
    original: Vec<usize>,
    node: Vec<usize>,
    /// Planes that contain each unknown, one bit per axis, and [`FREE_EDGE`].
    in_planes: Vec<u8>,
    nodes: usize,
    repairs: Repairs,
}

/// Bit that marks an unknown on the free edge of a flat surface.
const FREE_EDGE: u8 = 8;

/// Changes made to obtain a valid surface.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Repairs {
    /// Number of panels whose normal was reversed.
    pub flipped: usize,
    /// Number of panels removed because they lie on the floor or in a mirror plane.
    pub on_floor: usize,
    /// Number of panels before the changes.
    pub panels: usize,
}

impl std::fmt::Display for Repairs {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(
            f,
            "of {} panels, {} turned round (their normals pointed into the body), {} left out (they lie on the floor)",
            self.panels, self.flipped, self.on_floor
        )
    }
}

impl Boundary {
    /// Checks `mesh` above a rigid floor in the plane z = `floor` \[m\], or in free space.
    ///
    /// Panels whose normal points into the body are reversed, and panels in the plane of the floor are removed;
    /// [`Boundary::repairs`] counts both.
    ///
    /// # Errors
    /// [`BemError::OpenSurface`], [`BemError::TangledSurface`], [`BemError::FloorThroughBody`],
    /// [`BemError::DegeneratePanel`].
    pub fn new(mesh: BoundaryMesh, floor: Option<f64>) -> Result<Self, BemError> {
        Self::symmetric(mesh, [None; 2], floor)
    }

    /// Same as [`Boundary::new`] for a body that is symmetric about the planes x = `mirrors[0]` and y = `mirrors[1]`
    /// \[m\]: `mesh` is the part above them.
    ///
    /// # Errors
    /// The errors of [`Boundary::new`], and [`BemError::MirrorThroughPart`].
    pub fn symmetric(mesh: BoundaryMesh, mirrors: [Option<f64>; 2], floor: Option<f64>) -> Result<Self, BemError> {
        Self::checked(mesh, [mirrors[0], mirrors[1], floor], true)
    }

    /// A flat surface with free edges, the midplane of a thin plate, for a [`Plate`](crate::bem::Plate). Its normals
    /// point to one side; for `mirrors`, see [`Boundary::symmetric`].
    ///
    /// # Errors
    /// The errors of [`Boundary::symmetric`], and [`BemError::NotFlat`].
    pub fn flat(mesh: BoundaryMesh, mirrors: [Option<f64>; 2]) -> Result<Self, BemError> {
        let flat = Self::checked(mesh, [mirrors[0], mirrors[1], None], false)?;
        let normal = |p: usize, xi: [f64; 2]| flat.mesh.point_at(p, xi).area_vector().normalize();
        let first = normal(0, [0.0; 2]);
        let plane = flat.mesh.point_at(0, [0.0; 2]).position.coords.dot(&first);
        let size = extent(&flat.mesh);
        for (p, panel) in flat.mesh.panels.iter().enumerate() {
            let off = panel
                .nodes()
                .iter()
                .map(|&n| (flat.mesh.points[n].coords.dot(&first) - plane).abs());
            let off = off.fold(0.0, f64::max);
            if off > 1e-6 * size {
                return Err(BemError::NotFlat {
                    panel: flat.original[p],
                    off,
                });
            }
        }
        Ok(flat)
    }

    fn checked(mut mesh: BoundaryMesh, planes: [Option<f64>; 3], closed: bool) -> Result<Self, BemError> {
        let floor = planes[2];
        let panels = mesh.panels.len();
        let size = extent(&mesh);
        let tolerance = 1e-6 * size;
        let mut original: Vec<usize> = (0..panels).collect();
        for (axis, plane) in planes.iter().enumerate() {
            let &Some(plane) = plane else { continue };
            let used = mesh
                .panels
                .iter()
                .flat_map(|p| p.nodes())
                .map(|&n| mesh.points[n][axis]);
            let (lowest, highest) = used.fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), z| (a.min(z), b.max(z)));
            if lowest < plane - tolerance {
                return Err(if axis == 2 {
                    BemError::FloorThroughBody {
                        floor: plane,
                        lowest,
                        highest,
                    }
                } else {
                    let axis = ["x", "y"][axis];
                    BemError::MirrorThroughPart { axis, plane, lowest }
                });
            }
            let flat = |p: usize| {
                mesh.panels[p]
                    .nodes()
                    .iter()
                    .all(|&n| (mesh.points[n][axis] - plane).abs() <= tolerance)
            };
            original.retain(|&p| !flat(p));
        }
        mesh.panels = original.iter().map(|&p| mesh.panels[p]).collect();
        for (p, &panel) in original.iter().enumerate() {
            let area = mesh.panel_area(p);
            if area.is_nan() || area <= 1e-14 * size * size {
                return Err(BemError::DegeneratePanel { panel, area });
            }
        }
        let in_planes = |n: usize| -> u8 {
            let inside = |axis: &usize| planes[*axis].is_some_and(|z| (mesh.points[n][*axis] - z).abs() <= tolerance);
            (0..3).filter(inside).map(|axis| 1 << axis).sum()
        };
        let mut masks: Vec<u8> = (0..mesh.points.len()).map(in_planes).collect();
        let (neighbours, open) = neighbours(&mesh, &masks)?;
        if let Some(&(a, b)) = open.iter().min().filter(|_| closed) {
            return Err(BemError::OpenSurface {
                edges: open.len(),
                at: nalgebra::center(&mesh.points[a], &mesh.points[b]).into(),
            });
        }
        for (a, b) in open {
            masks[a] |= FREE_EDGE;
            masks[b] |= FREE_EDGE;
        }
        let flipped = orient(&mut mesh, &neighbours, floor.unwrap_or(0.0));
        let mut node = vec![usize::MAX; mesh.points.len()];
        let mut in_planes = Vec::new();
        for panel in &mesh.panels {
            for &n in panel.corners() {
                if node[n] == usize::MAX {
                    node[n] = in_planes.len();
                    in_planes.push(masks[n]);
                }
            }
        }
        Ok(Self {
            nodes: in_planes.len(),
            repairs: Repairs {
                flipped,
                on_floor: panels - original.len(),
                panels,
            },
            mesh,
            planes,
            original,
            node,
            in_planes,
        })
    }

    /// The surface with outward normals and without the panels on the floor.
    pub fn mesh(&self) -> &BoundaryMesh {
        &self.mesh
    }

    /// Height of the rigid floor \[m\].
    pub fn floor(&self) -> Option<f64> {
        self.planes[2]
    }

    /// Position of the planes of constant x and y about which the body is symmetric \[m\].
    pub fn mirrors(&self) -> [Option<f64>; 2] {
        [self.planes[0], self.planes[1]]
    }

    /// Number of symmetric parts of the complete body.
    pub fn copies(&self) -> usize {
        1 << self.mirrors().iter().flatten().count()
    }

    pub(crate) fn planes(&self) -> &[Option<f64>; 3] {
        &self.planes
    }

    /// All images in floor and mirror planes, beginning with the surface itself.
    pub(crate) fn images(&self) -> Vec<Image> {
        Image::all(&self.planes)
    }

    /// A coordinate of the image of a point.
    pub(crate) fn mirrored(&self, image: Image, axis: usize, x: f64) -> f64 {
        match self.planes[axis] {
            Some(plane) if image.sign_along(axis) < 0.0 => 2.0 * plane - x,
            _ => x,
        }
    }

    /// Index of each panel in the original mesh.
    pub fn original(&self) -> &[usize] {
        &self.original
    }

    /// Changes made to obtain a valid surface.
    pub fn repairs(&self) -> Repairs {
        self.repairs
    }

    /// Number of pressure unknowns: the corners of the panels.
    pub fn nodes(&self) -> usize {
        self.nodes
    }

    /// Number of values that describe a normal velocity: one for each corner of each panel, panel by panel.
    pub fn velocity_values(&self) -> usize {
        self.mesh.panels.iter().map(|p| p.corners().len()).sum()
    }

    /// The pressure unknown at a point of the mesh; none at mid-side nodes.
    pub fn node_of(&self, point: usize) -> Option<usize> {
        (self.node[point] != usize::MAX).then(|| self.node[point])
    }

    /// Numbers the pressure unknowns in the order of first use by `panels`, which must contain all panels.
    pub(crate) fn number_nodes<'a>(&mut self, panels: impl Iterator<Item = &'a usize>) {
        let (mut number, mut in_planes) = (vec![usize::MAX; self.node.len()], Vec::with_capacity(self.nodes));
        for &panel in panels {
            for &point in self.mesh.panels[panel].corners() {
                if number[point] == usize::MAX {
                    number[point] = in_planes.len();
                    in_planes.push(self.in_planes[self.node[point]]);
                }
            }
        }
        (self.node, self.in_planes) = (number, in_planes);
    }

    /// Whether the surface has an edge on the floor.
    pub fn stands_on_floor(&self) -> bool {
        self.in_planes.iter().any(|mask| mask & 4 != 0)
    }

    /// Planes that contain an unknown, one bit per axis.
    pub(crate) fn in_planes(&self, node: usize) -> u8 {
        self.in_planes[node]
    }

    /// Whether an unknown lies on the free edge of a flat surface.
    pub(crate) fn on_free_edge(&self, node: usize) -> bool {
        self.in_planes[node] & FREE_EDGE != 0
    }

    /// Highest frequency at which the edges of all panels are at most 1/`per_wavelength` of a wavelength \[Hz\].
    pub fn highest_hz(&self, sound_speed: f64, per_wavelength: f64) -> f64 {
        sound_speed / (per_wavelength * self.mesh.longest_edge())
    }

    /// Extents of the bounding box of the complete body along x, y and z \[m\].
    pub fn extents(&self) -> Vector3<f64> {
        let mut low = Vector3::repeat(f64::INFINITY);
        let mut high = -low;
        for &n in self.mesh.panels.iter().flat_map(|p| p.corners()) {
            low = low.inf(&self.mesh.points[n].coords);
            high = high.sup(&self.mesh.points[n].coords);
        }
        for (axis, mirror) in self.mirrors().into_iter().enumerate() {
            low[axis] = mirror.map_or(low[axis], |plane| 2.0 * plane - high[axis]);
        }
        high - low
    }

    /// The pressure unknowns at a panel's corners.
    pub(crate) fn unknowns_of<'a>(&'a self, panel: &'a Panel) -> impl Iterator<Item = usize> + 'a {
        panel.corners().iter().filter_map(|&c| self.node_of(c))
    }

    /// Largest distance between two points of the bounding box of the complete body, or between a point and the floor
    /// image of another \[m\].
    pub(crate) fn longest_path(&self) -> f64 {
        let mut sides = self.extents();
        if let Some(floor) = self.planes()[2] {
            let corners = self.mesh.panels.iter().flat_map(|p| p.corners());
            let top = corners.map(|&n| self.mesh.points[n].z).fold(floor, f64::max);
            sides.z = 2.0 * (top - floor);
        }
        sides.norm()
    }

    /// Half of the second-largest extent of the surface \[m\]: the limit L_c of the coupling parameter.
    pub fn half_width(&self) -> f64 {
        let extents = self.extents();
        0.5 * (extents.sum() - extents.min() - extents.max())
    }

    /// Projects normal velocities, given as functions of position, on the corner functions of each panel. The
    /// least-squares fit on each panel preserves its volume flow.
    ///
    /// `velocity(panel, xi, point, values)` writes one value per pattern; the result is velocity values x patterns.
    pub fn project(
        &self,
        patterns: usize,
        mut velocity: impl FnMut(usize, [f64; 2], &PanelPoint, &mut [f64]),
    ) -> DMatrix<f64> {
        let mut result = DMatrix::zeros(self.velocity_values(), patterns);
        let mut values = vec![0.0; patterns];
        let mut row = 0;
        for (p, panel) in self.mesh.panels.iter().enumerate() {
            let corners = panel.corners().len();
            let mut mass = Matrix4::<f64>::identity();
            mass.view_mut((0, 0), (corners, corners)).fill(0.0);
            let mut moments = DMatrix::<f64>::zeros(4, patterns);
            for (xi, w) in rules::fine(panel.kind()) {
                let point = self.mesh.point_at(p, xi);
                let dw = w * point.area_vector().norm();
                velocity(p, xi, &point, &mut values);
                let n = panel.kind().linear().at(xi).n;
                for i in 0..corners {
                    for j in 0..corners {
                        mass[(i, j)] += dw * n[i] * n[j];
                    }
                    for (m, v) in values.iter().enumerate() {
                        moments[(i, m)] += dw * n[i] * v;
                    }
                }
            }
            let lu = mass.lu();
            for m in 0..patterns {
                let b = Vector4::from_column_slice(moments.column(m).as_slice());
                let x = lu.solve(&b).unwrap_or_else(Vector4::zeros);
                for i in 0..corners {
                    result[(row + i, m)] = x[i];
                }
            }
            row += corners;
        }
        result
    }

    /// Normal components, as corner values, of displacement fields given at the mesh's points, (3 x points) x modes.
    ///
    /// # Errors
    /// [`InputError::Length`](crate::InputError) if the number of rows is wrong.
    pub fn project_displacements(&self, fields: &DMatrix<f64>) -> Result<DMatrix<f64>, BemError> {
        crate::checks::same_length(
            "rows of the modal displacements",
            fields.nrows(),
            3 * self.mesh.points.len(),
        )?;
        Ok(self.project(fields.ncols(), |p, xi, point, values| {
            let panel = &self.mesh.panels[p];
            let shape = panel.kind().at(xi);
            let normal = point.area_vector().normalize();
            for (m, value) in values.iter_mut().enumerate() {
                *value = panel
                    .nodes()
                    .iter()
                    .zip(shape.n)
                    .map(|(&node, n)| n * (0..3).map(|c| normal[c] * fields[(3 * node + c, m)]).sum::<f64>())
                    .sum();
            }
        }))
    }
}

fn extent(mesh: &BoundaryMesh) -> f64 {
    let Some(first) = mesh.points.first() else { return 0.0 };
    mesh.points
        .iter()
        .map(|p: &Point3<f64>| (p - first).norm())
        .fold(0.0, f64::max)
}

/// The panel across an edge, and whether it traverses the edge in the same direction (its normal is then reversed).
type Beyond = (usize, bool);

/// The panel across every edge of every panel, and the edges that belong to a single panel and lie in no plane.
type Neighbours = (Vec<Vec<Beyond>>, Vec<(usize, usize)>);

fn neighbours(mesh: &BoundaryMesh, in_planes: &[u8]) -> Result<Neighbours, BemError> {
    let mut edges: HashMap<(usize, usize), Vec<(usize, bool)>> = HashMap::new();
    for (p, panel) in mesh.panels.iter().enumerate() {
        let c = panel.corners();
        for k in 0..c.len() {
            let (a, b) = (c[k], c[(k + 1) % c.len()]);
            edges.entry((a.min(b), a.max(b))).or_default().push((p, a < b));
        }
    }
    let mut result = vec![Vec::new(); mesh.panels.len()];
    let mut open: Vec<(usize, usize)> = Vec::new();
    for (&(a, b), users) in &edges {
        match users[..] {
            [(p, forward), (q, other)] if p != q => {
                result[p].push((q, forward == other));
                result[q].push((p, forward == other));
            }
            [_] if in_planes[a] & in_planes[b] != 0 => {}
            [_] => open.push((a, b)),
            _ => {
                let middle = nalgebra::center(&mesh.points[a], &mesh.points[b]);
                return Err(BemError::TangledSurface {
                    panels: users.len(),
                    at: middle.into(),
                });
            }
        }
    }
    Ok((result, open))
}

/// Reverses panels until all normals point out of the bodies; returns the number of panels reversed.
fn orient(mesh: &mut BoundaryMesh, neighbours: &[Vec<Beyond>], base: f64) -> usize {
    let mut turned: Vec<Option<bool>> = vec![None; mesh.panels.len()];
    for seed in 0..mesh.panels.len() {
        if turned[seed].is_some() {
            continue;
        }
        turned[seed] = Some(false);
        let (mut body, mut next) = (vec![seed], 0);
        while next < body.len() {
            let p = body[next];
            next += 1;
            for &(q, same) in &neighbours[p] {
                if turned[q].is_none() {
                    turned[q] = Some(turned[p].unwrap_or(false) != same);
                    body.push(q);
                }
            }
        }
        // V = closed integral of (z - z_0) n_z dS; panels in the plane z_0 contribute nothing.
        let volume: f64 = body
            .iter()
            .map(|&p| {
                let sign = if turned[p] == Some(true) { -1.0 } else { 1.0 };
                let moment = |(xi, w): ([f64; 2], f64)| {
                    let point = mesh.point_at(p, xi);
                    w * (point.position.z - base) * point.area_vector().z
                };
                sign * rules::fine(mesh.panels[p].kind()).into_iter().map(moment).sum::<f64>()
            })
            .sum();
        if volume < 0.0 {
            for &p in &body {
                turned[p] = turned[p].map(|t| !t);
            }
        }
    }
    let mut count = 0;
    for (panel, turned) in mesh.panels.iter_mut().zip(turned) {
        if turned == Some(true) {
            panel.flip();
            count += 1;
        }
    }
    count
}
