//! Finite-element bodies of a design: mesh, modes, and the patterns through which forces reach them.
//!
//! Workpiece and worktable meet in the plane z = 0, z up; the workpiece's centre is at x = y = 0, x along the grain.

use nailnoise_fem::supports::{ContactGrid, GridRule};
use nailnoise_fem::{ModalBasis, ModalSettings, System, assemble_with, modes_telling};
use nailnoise_meshes::{Mesh, Surface};
use nalgebra::{DMatrix, DVector, Point3, Vector3};

use super::geometry::{BodyKind, Geometry, added_mass};
use super::pattern::{Pattern, Rectangle};
use super::{Tell, shank, sides, springs, tool_loads};
use crate::cache::{Cache, Key};
use crate::design::{Design, Sprung, SupportKind};
use crate::error::Error;
use crate::result::Check;

/// A body in modal coordinates, with its geometry.
pub struct Body {
    /// `workpiece`, `worktable` or `tool`.
    pub name: &'static str,
    /// Its mesh.
    pub mesh: Mesh,
    /// Its outer faces.
    pub surface: Surface,
    /// Its modes, proven complete up to their top frequency.
    pub basis: ModalBasis,
    /// Modes, then static corrections: 3 nodes x modes \[kg^-1/2\].
    pub shapes: DMatrix<f64>,
    /// Angular frequencies of the columns of `shapes` \[rad/s\]; 0 for rigid modes.
    pub omega: Vec<f64>,
    /// Loss factor of all modes \[-\].
    pub loss_factor: f64,
    /// Frequency up to which the body's motion is part of the result \[Hz\].
    pub top_hz: f64,
    /// Modal momentum of the body as it rises at unit speed, Phi^T M (0, 0, 1) \[kg^1/2\].
    pub lift: DVector<f64>,
    /// Modal force of gravity \[N kg^-1/2\].
    pub weight: DVector<f64>,
    /// Generalised displacement of each load, downwards positive: modes x loads.
    pub loads: DMatrix<f64>,
    /// Generalised displacement of each contact cell along the body's outward normal, then of the sand's cells at its sides
    /// and of springs to the ground: modes x supports.
    pub contacts: DMatrix<f64>,
}

/// The bodies of a design.
pub struct Structure {
    /// The wood block.
    pub workpiece: Body,
    /// The worktable, when the block stands on one.
    pub worktable: Option<Body>,
    /// Cells in which the block's underside touches what it stands on.
    pub grid: ContactGrid,
}

impl Structure {
    /// The bodies there are.
    pub fn bodies(&self) -> impl Iterator<Item = &Body> {
        std::iter::once(&self.workpiece).chain(&self.worktable)
    }
}

/// Where loads act on the workpiece, in the order of the columns of [`Body::loads`]: the nail's stations, then the nose.
pub(super) const WORKPIECE_LOADS: usize = shank::STATIONS + 1;

/// The contact cells of the workpiece's underside.
pub(super) fn contact_grid(design: &Design) -> ContactGrid {
    let (block, contact) = (&design.workpiece, &design.support.contact);
    let (along, across) = (contact.points_along as usize, contact.points_across as usize);
    ContactGrid::new(block.length, block.width, along, across, GridRule::CellCentred)
}

/// What is nailed, free.
///
/// # Errors
/// Those of mesh, material and modal solution.
pub fn workpiece(design: &Design, cache: &Cache) -> Result<Body, Error> {
    workpiece_telling(design, cache, &|_, _| ())
}

/// [`workpiece`], and tells how many modes are found.
pub(super) fn workpiece_telling(design: &Design, cache: &Cache, tell: Tell<'_>) -> Result<Body, Error> {
    let geometry = Geometry::of(design, BodyKind::Workpiece, false)?;
    let (mesh, thickness) = (&geometry.mesh, design.workpiece.thickness);
    let mut loads = Vec::with_capacity(WORKPIECE_LOADS);
    let nail = [design.nail.offset_along, design.nail.offset_across];
    for depth in shank::depths(design.nail.length) {
        loads.push(Pattern::point(mesh, Point3::new(nail[0], nail[1], thickness - depth))?.reversed());
    }
    let nose = Rectangle {
        centre: nail,
        size: [design.body.nose_width, design.body.nose_depth],
        height: thickness,
    };
    loads.push(Pattern::patch(mesh, "top", nose)?.reversed());
    let mut contacts = match design.support.kind {
        SupportKind::Clamped | SupportKind::Springs => Vec::new(),
        SupportKind::Worktable | SupportKind::Sandbox | SupportKind::Floor => {
            let under = contact_patterns(design, mesh, "bottom")?;
            let outward = under.iter().map(Pattern::reversed); // outward is down
            outward.chain(sides::patterns(design, mesh)?).collect()
        }
    };
    contacts.extend(springs::patterns(design, mesh, Sprung::Workpiece)?);
    let mut body = Model {
        geometry,
        loads,
        contacts,
    }
    .solve(design, cache, tell)?;
    if design.support.kind == SupportKind::Sandbox {
        // Sand that moves with the base rests in the sand: its weight is not the block's.
        let weight = design.ambient.gravity * added_mass(design)?;
        let cells = contact_grid(design).areas;
        let area: f64 = cells.iter().sum();
        for (cell, cell_area) in cells.iter().enumerate() {
            let share = body.contacts.column(cell) * (weight * cell_area / area);
            body.weight -= share;
        }
    }
    Ok(body)
}

/// The worktable, clamped at the floor or on springs.
///
/// # Errors
/// [`Error::NoSuchBody`] when the support is a sandbox; those of mesh, material and modal solution.
pub fn table(design: &Design, cache: &Cache) -> Result<Body, Error> {
    table_telling(design, cache, &|_, _| ())
}

/// [`table`], and tells how many modes are found.
pub(super) fn table_telling(design: &Design, cache: &Cache, tell: Tell<'_>) -> Result<Body, Error> {
    let geometry = Geometry::of(design, BodyKind::Worktable, false)?;
    let mut contacts = contact_patterns(design, &geometry.mesh, "top")?;
    contacts.extend(springs::patterns(design, &geometry.mesh, Sprung::Worktable)?);
    Model {
        geometry,
        loads: Vec::new(),
        contacts,
    }
    .solve(design, cache, tell)
}

/// The tool's body, free, with what drives it: forces along the axis, then pressures on walls.
///
/// # Errors
/// As [`Geometry::of`], [`Error::NoLoadSurface`], and those of the modal solution.
pub fn tool_body(design: &Design, cache: &Cache) -> Result<Body, Error> {
    tool_body_telling(design, cache, &|_, _| ())
}

/// [`tool_body`], and tells how many modes are found.
pub(super) fn tool_body_telling(design: &Design, cache: &Cache, tell: Tell<'_>) -> Result<Body, Error> {
    let geometry = Geometry::of(design, BodyKind::Tool, false)?;
    let loads = tool_loads::patterns(design, &geometry.mesh)?;
    Model {
        geometry,
        loads,
        contacts: Vec::new(),
    }
    .solve(design, cache, tell)
}

/// The modes of any body alone, without what drives it.
///
/// # Errors
/// As [`Geometry::of`], and those of the modal solution.
pub fn modes_of(design: &Design, kind: BodyKind, cache: &Cache) -> Result<Body, Error> {
    modes_of_telling(design, kind, cache, &|_, _| ())
}

/// [`modes_of`], and tells how many modes are found.
pub(crate) fn modes_of_telling(design: &Design, kind: BodyKind, cache: &Cache, tell: Tell<'_>) -> Result<Body, Error> {
    Model {
        geometry: Geometry::of(design, kind, false)?,
        loads: Vec::new(),
        contacts: Vec::new(),
    }
    .solve(design, cache, tell)
}

/// Mean upward displacement of each contact cell on a face group in the plane z = 0.
fn contact_patterns(design: &Design, mesh: &Mesh, group: &str) -> Result<Vec<Pattern>, Error> {
    let (block, contact) = (&design.workpiece, &design.support.contact);
    let size = [
        block.length / f64::from(contact.points_along),
        block.width / f64::from(contact.points_across),
    ];
    let cells = contact_grid(design);
    let patch = |&centre: &[f64; 2]| {
        Pattern::patch(
            mesh,
            group,
            Rectangle {
                centre,
                size,
                height: 0.0,
            },
        )
    };
    Ok(cells.points.iter().map(patch).collect::<Result<_, _>>()?)
}

/// A finite-element model before its modes are known.
struct Model {
    geometry: Geometry,
    loads: Vec<Pattern>,
    contacts: Vec<Pattern>,
}

impl Model {
    fn solve(self, design: &Design, cache: &Cache, tell: Tell<'_>) -> Result<Body, Error> {
        let Geometry {
            kind,
            mesh,
            materials,
            constraints,
            attachments,
            top_hz,
            loss_factor,
            ..
        } = self.geometry;
        let (residual_limit, edge) = (design.analysis.mode_tolerance, design.analysis.mode_margin * top_hz);
        let settings = ModalSettings {
            residual_limit,
            ..ModalSettings::below(edge)
        };
        // The debug form names every field, its numbers with all their digits: no input can be forgotten.
        let key = of_mesh(Key::new(), &mesh)
            .with(&format!("{materials:?} {constraints:?} {attachments:?} {settings:?}"))
            .with(&self.loads)
            .with(&self.contacts);
        let (basis, lift) = cache.get_or(&format!("modes of the {}", kind.name()), key, || {
            let dofs = 3 * mesh.nodes.len();
            let patterns: Vec<_> = self
                .loads
                .iter()
                .chain(&self.contacts)
                .filter(|pattern| !pattern.is_nothing())
                .map(|pattern| pattern.dense(dofs))
                .collect();
            let settings = if patterns.is_empty() {
                settings
            } else {
                settings.with_loads(DMatrix::from_columns(&patterns))
            };
            let system = assemble_with(&mesh, &materials, &constraints, &attachments)?;
            let tell = |found: usize, of: usize| tell(found as u64, of as u64);
            Ok::<_, Error>((modes_telling(&system, &settings, &tell)?, upward_momentum(&system)))
        })?;
        let shapes = basis.all_shapes();
        let omega = basis.all_hz().iter().map(|hz| std::f64::consts::TAU * hz).collect();
        let lift = shapes.tr_mul(&DVector::from_vec(lift));
        let weight = &lift * -design.ambient.gravity;
        let participation = |patterns: &[Pattern]| {
            let columns: Vec<_> = patterns.iter().map(|pattern| pattern.of_modes(&shapes)).collect();
            if columns.is_empty() {
                DMatrix::zeros(shapes.ncols(), 0)
            } else {
                DMatrix::from_columns(&columns)
            }
        };
        let (loads, contacts) = (participation(&self.loads), participation(&self.contacts));
        let surface = Surface::of(&mesh);
        Ok(Body {
            name: kind.name(),
            surface,
            basis,
            omega,
            loss_factor,
            top_hz,
            lift,
            weight,
            loads,
            contacts,
            mesh,
            shapes,
        })
    }
}

/// A key that depends on a mesh as well.
fn of_mesh(key: Key, mesh: &Mesh) -> Key {
    let Mesh {
        nodes,
        kinds,
        offsets,
        connectivity,
        parts,
        part_names,
        groups,
    } = mesh;
    let nodes: Vec<[f64; 3]> = nodes.iter().map(|p| [p.x, p.y, p.z]).collect();
    let groups: Vec<(&str, Vec<(usize, usize)>)> = groups
        .iter()
        .map(|group| {
            let faces = group.faces.iter().map(|face| (face.element, face.face));
            (group.name.as_str(), faces.collect())
        })
        .collect();
    key.with(&nodes)
        .with(kinds)
        .with(offsets)
        .with(connectivity)
        .with(parts)
        .with(part_names)
        .with(&groups)
}

/// M (0, 0, 1) on the free degrees of freedom, to be multiplied by the shapes: the momentum of everything, what is tied
/// and lumped included, when it moves upwards at unit speed \[kg\].
fn upward_momentum(system: &System) -> Vec<f64> {
    let velocity = system.equations.translation(Vector3::z());
    let mut momentum = vec![0.0; velocity.nrows()];
    for (row, column, &value) in system.mass.triplet_iter() {
        momentum[row] += value * velocity[column];
        if row != column {
            momentum[column] += value * velocity[row]; // only the lower triangle is stored
        }
    }
    let of_dof = |dof: usize| system.equations.equation(dof / 3, dof % 3).map_or(0.0, |e| momentum[e]);
    (0..system.equations.dofs()).map(of_dof).collect()
}

impl Body {
    /// Checks of the modal solution.
    pub fn checks(&self) -> Vec<Check> {
        let worst = self.basis.residuals.iter().fold(0.0, |worst: f64, &r| worst.max(r));
        let missing = self.basis.sturm.count as f64 - self.basis.hz.len() as f64;
        vec![
            Check::at_most(format!("{}: eigen residual", self.name), worst, 1e-8),
            Check::at_most(
                format!("{}: orthonormality", self.name),
                self.basis.orthonormality,
                1e-8,
            ),
            Check::at_most(format!("{}: Sturm count less modes found", self.name), missing, 0.0),
        ]
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use nailnoise_fem::{Attachments, Constraints, Material, Tie};
    use nailnoise_meshes::{Block, block};
    use std::f64::consts::TAU;

    use super::super::geometry::Origin;

    const E: f64 = 70e9;
    const NU: f64 = 0.33;

    /// Static swept volume of a free body under a unit of pressure on patches, from its modes and static corrections.
    fn swept(mesh: Mesh, attachments: Attachments, patches: &[&str]) -> f64 {
        let path = concat!(env!("CARGO_MANIFEST_DIR"), "/designs/n80cb.toml");
        let mut design = Design::load(path).unwrap();
        design.analysis.mode_margin = 1.0;
        let loads = vec![Pattern::pressure(&Surface::of(&mesh), patches, |_| true).unwrap()];
        let geometry = Geometry {
            kind: BodyKind::Tool,
            mesh,
            element_numbers: Vec::new(),
            unused_nodes: 0,
            materials: vec![Material::isotropic(E, NU, 2700.0).unwrap()],
            constraints: Constraints::free(),
            attachments,
            loss_factor: 0.0,
            top_hz: 3000.0,
            origin: Origin::BuiltIn,
        };
        let model = Model {
            geometry,
            loads,
            contacts: Vec::new(),
        };
        let body = model.solve(&design, &Cache::none(), &|_, _| ()).unwrap();
        let elastic = body.omega.iter().zip(&body.loads).filter(|(omega, _)| **omega > 0.0);
        elastic.map(|(omega, p)| (p / omega).powi(2)).sum()
    }

    /// Pressure from all sides shrinks a block by V/K, K = E/(3 (1 - 2 nu)): a linear field, which the elements hold.
    #[test]
    fn modes_and_corrections_give_the_static_shrinking_of_a_block_exactly() {
        let size = [0.3, 0.2, 0.1];
        let mesh = block(&Block {
            size,
            divisions: [3, 2, 1],
            origin: [0.0; 3],
        })
        .unwrap();
        let every: Vec<String> = mesh.groups.iter().map(|g| g.name.clone()).collect();
        let every: Vec<&str> = every.iter().map(String::as_str).collect();
        let exact = size.iter().product::<f64>() * 3.0 * (1.0 - 2.0 * NU) / E;
        let found = swept(mesh, Attachments::default(), &every);
        assert!((found / exact - 1.0).abs() < 1e-6, "{found:e} {exact:e}");
    }

    /// A cylinder open at its ends under inner pressure p (Lame): u(a) = p a/E ((b^2 + a^2)/(b^2 - a^2) + nu).
    #[test]
    fn a_cylinder_widens_under_pressure_as_lames_formula_says() {
        let (a, b, height) = (0.030, 0.034, 0.02);
        let mut mesh = block(&Block {
            size: [1.0, b - a, height],
            divisions: [24, 1, 2],
            origin: [0.0, a, 0.0],
        })
        .unwrap();
        // The strip's lower side along y becomes the bore; its two ends meet and are tied.
        let mut groups = Vec::new();
        let at = |mesh: &Mesh, axis: usize, value: f64| {
            let on = |f: &nailnoise_meshes::SurfaceFace, s: &Surface| {
                f.nodes.iter().all(|&n| (s.points[n][axis] - value).abs() < 1e-9)
            };
            let surface = Surface::of(mesh);
            surface
                .faces
                .iter()
                .filter(|f| on(f, &surface))
                .map(|f| f.of)
                .collect::<Vec<_>>()
        };
        for (name, axis, value) in [("bore", 1, a), ("seam_slave", 0, 0.0), ("seam_master", 0, 1.0)] {
            groups.push(nailnoise_meshes::FaceGroup {
                name: name.to_owned(),
                faces: at(&mesh, axis, value),
            });
        }
        mesh.groups = groups;
        for p in &mut mesh.nodes {
            let (angle, r) = (TAU * p.x, p.y);
            // Clockwise, so that elements keep their orientation.
            (p.x, p.y) = (r * angle.sin(), r * angle.cos());
        }
        let tie = Tie {
            slave: "seam_slave".to_owned(),
            master: "seam_master".to_owned(),
            tolerance: 1e-6,
        };
        let attachments = Attachments {
            ties: vec![tie],
            ..Attachments::default()
        };
        let widening = a / E * ((b * b + a * a) / (b * b - a * a) + NU);
        let exact = TAU * a * height * widening;
        let found = swept(mesh, attachments, &["bore"]);
        assert!((found / exact - 1.0).abs() < 5e-3, "{found:e} {exact:e}");
    }
}
