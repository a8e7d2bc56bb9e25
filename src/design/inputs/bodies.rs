//! Inputs of the finite-element bodies: geometry, materials, and the places of loads and supports.

use std::path::Path;

use nailnoise_fem::Material;
use nailnoise_fem::vibration::supports::contact_dashpot;
use nailnoise_fem::vibration::{Support, SupportLaw};
use nailnoise_meshes::{Tool, element_size};
use nalgebra::Matrix3;

use crate::design::{self, Design, NamedSurface, Spring, Sprung, SurfaceOf, SurfaceProblem};
use crate::error::Error;
use crate::model::supports::{self, Table};
use crate::stages::bodies::BodyError;
use crate::stages::bodies::{
    BodyKind, ContactFace, Extent, FileUnit, Geometry, Joint, JointSpring, LoadPlaces, MeshFile, MeshSource, NailPlace,
    Naming, PartMaterials, Properties, Remainder, SpringFoot, SurfacePlace, ToolPlaces, ToolShape,
};
use crate::stages::radiation::SurfaceError;

/// Inputs of the stages of a body.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct BodyInputs {
    /// Geometry and materials.
    pub(crate) geometry: Geometry,
    /// Places of loads.
    pub(crate) places: LoadPlaces,
    /// All modes below this frequency are computed \[Hz\].
    pub(crate) below_hz: f64,
    /// Largest residual accepted for any mode.
    pub(crate) residual_limit: f64,
    /// Loss factor of all modes \[-\].
    pub(crate) loss_factor: f64,
    /// Frequency up to which the result includes the body's motion \[Hz\].
    pub(crate) top_hz: f64,
}

/// A body of a design; with the places where the shot's forces act if `driven`.
///
/// # Errors
/// [`Error::NoSuchBody`] for the worktable of a design without one; the errors of materials and mesh file.
pub(crate) fn body(design: &Design, kind: BodyKind, driven: bool) -> Result<BodyInputs, Error> {
    let places = if driven {
        places(design, kind)?
    } else {
        LoadPlaces::default()
    };
    let loss_factor = match kind {
        BodyKind::Workpiece => design.wood.loss_factor,
        BodyKind::Worktable => table(design)?.loss_factor,
        BodyKind::Tool => design.body.loss_factor,
    };
    let (top_hz, _) = limits(design, kind);
    Ok(BodyInputs {
        geometry: geometry(design, kind, false)?,
        places,
        below_hz: below_hz(design, kind),
        residual_limit: design.analysis.mode_tolerance,
        loss_factor,
        top_hz,
    })
}

/// Frequency below which all modes of a body are computed \[Hz\].
pub(crate) fn below_hz(design: &Design, kind: BodyKind) -> f64 {
    design.analysis.mode_margin * limits(design, kind).0
}

/// Top frequency \[Hz\] and largest element size \[m\] of a body.
fn limits(design: &Design, kind: BodyKind) -> (f64, f64) {
    let analysis = &design.analysis;
    match kind {
        BodyKind::Workpiece => (analysis.workpiece_max_frequency, analysis.workpiece_element),
        BodyKind::Worktable => (analysis.worktable_max_frequency, analysis.worktable_element),
        BodyKind::Tool => (analysis.body_max_frequency, analysis.body_element),
    }
}

/// Geometry and materials of a body. With `remesh`, gmsh meshes the tool body even if a mesh of its dimensions comes
/// with the program.
///
/// # Errors
/// Same as `body`.
pub fn geometry(design: &Design, kind: BodyKind, remesh: bool) -> Result<Geometry, Error> {
    match kind {
        BodyKind::Workpiece => workpiece(design),
        BodyKind::Worktable => worktable(design),
        BodyKind::Tool => tool(design, remesh),
    }
}

fn workpiece(design: &Design) -> Result<Geometry, Error> {
    let (block, wood, support) = (&design.workpiece, &design.wood, supports::of(design));
    let material = Material::orthotropic(&wood.block_axes(), &Matrix3::identity(), wood.density)?;
    let own = own_mesh(
        design,
        BodyKind::Workpiece,
        (&block.mesh, block.mesh_unit),
        material.slowest_speed(),
    )?;
    Ok(Geometry {
        kind: BodyKind::Workpiece,
        mesh: own.unwrap_or(MeshSource::Block {
            size: block_size(design),
            element: design.analysis.workpiece_element,
            joint: joint(design).map(|joint| joint.height),
        }),
        naming: naming(design, BodyKind::Workpiece),
        properties: Properties {
            materials: PartMaterials::Same(Box::new(material)),
            clamped: support.fixed(),
            sand: support.added_sand()?.filter(|sand| sand.mass != 0.0),
            remainder: None,
        },
    })
}

/// The body under the workpiece.
fn table(design: &Design) -> Result<Table, Error> {
    supports::of(design).table()?.ok_or_else(|| Error::NoSuchBody {
        design: design.name().to_owned(),
        body: BodyKind::Worktable.name(),
        support: design.support.kind.as_str(),
    })
}

fn worktable(design: &Design) -> Result<Geometry, Error> {
    let Table {
        materials,
        built_in,
        fixed,
        ..
    } = table(design)?;
    let speeds = materials.iter().map(|(_, material)| material.slowest_speed());
    let slowest = speeds.fold(f64::INFINITY, f64::min);
    let keys = &design.support.worktable;
    let own = own_mesh(design, BodyKind::Worktable, (&keys.mesh, keys.mesh_unit), slowest)?;
    Ok(Geometry {
        kind: BodyKind::Worktable,
        mesh: own.unwrap_or(built_in),
        naming: naming(design, BodyKind::Worktable),
        properties: Properties {
            materials: PartMaterials::Named(materials),
            clamped: fixed,
            sand: None,
            remainder: None,
        },
    })
}

fn tool(design: &Design, remesh: bool) -> Result<Geometry, Error> {
    let b = &design.body;
    let materials = [
        ("housing", isotropic(&b.housing)?),
        ("cap", isotropic(&b.cap)?),
        ("nose", isotropic(&b.nose)?),
        ("sleeve", isotropic(&b.sleeve)?),
    ];
    let slowest = materials[0].1.slowest_speed();
    let own = own_mesh(design, BodyKind::Tool, (&b.mesh, b.mesh_unit), slowest)?;
    // A coil of nails as a solid cylinder with its axis along y.
    let (r, h) = (b.magazine_radius, b.magazine_height);
    let (along, across) = (r * r / 2.0, (3.0 * r * r + h * h) / 12.0);
    let remainder = || Remainder {
        total: design.tool.mass,
        shares: [
            ("nose_tip", b.lumped_nose, [0.0; 3]),
            ("magazine", b.lumped_magazine, [across, along, across]),
            ("seat", 1.0 - b.lumped_nose - b.lumped_magazine, [0.0; 3]),
        ],
    };
    Ok(Geometry {
        kind: BodyKind::Tool,
        mesh: own.unwrap_or_else(|| MeshSource::Tool(Box::new(tool_dimensions(design)), remesh)),
        naming: naming(design, BodyKind::Tool),
        properties: Properties {
            materials: PartMaterials::Named(materials.into()),
            clamped: None,
            sand: None,
            remainder: b.lumped.then(remainder),
        },
    })
}

/// The tool body's dimensions and element size.
fn tool_dimensions(design: &Design) -> Tool {
    Tool {
        dimensions: design.body.dimensions.clone(),
        sleeve_radius: design.piston.bore / 2.0,
        size: design.analysis.body_element,
    }
}

fn isotropic(c: &design::Isotropic) -> Result<Material, Error> {
    Ok(Material::isotropic(c.young_modulus, c.poisson_ratio, c.density)?)
}

/// The user's own mesh of a body, if there is one. A solid geometry is meshed for the wavelength at the slowest wave
/// speed \[m/s\].
fn own_mesh(
    design: &Design,
    kind: BodyKind,
    (file, unit): (&str, f64),
    slowest: f64,
) -> Result<Option<MeshSource>, Error> {
    if file.is_empty() {
        return Ok(None);
    }
    let (_, largest) = limits(design, kind);
    let size = element_size(below_hz(design, kind), slowest, design.analysis.elements_per_wave)?;
    let extent = extent(design, kind);
    let unit = FileUnit::of_key(unit, extent.key);
    let file = MeshFile::new(Path::new(file), unit, Some(size.min(largest)), Some(extent))?;
    Ok(Some(MeshSource::File(file)))
}

/// Largest ratio of the lengths of a body from a file and the built-in body, either way; less than the 25.4 between
/// inches and millimetres.
const LIKE_BUILT_IN: f64 = 20.0;

/// Longest sides of a hand-held tool \[m\].
const HAND_HELD: [f64; 2] = [0.05, 3.0];

/// Permitted length of a body from a file.
fn extent(design: &Design, kind: BodyKind) -> Extent {
    let like = |sides: [f64; 3]| {
        let longest = sides.into_iter().fold(0.0, f64::max);
        [longest / LIKE_BUILT_IN, longest * LIKE_BUILT_IN]
    };
    let table = &design.support.worktable;
    match kind {
        BodyKind::Workpiece => Extent {
            what: "a workpiece",
            longest: like(block_size(design)),
            key: "workpiece.mesh_unit",
        },
        BodyKind::Worktable => Extent {
            what: "a worktable",
            longest: like([table.length, table.width, table.height]),
            key: "support.worktable.mesh_unit",
        },
        BodyKind::Tool => Extent {
            what: "a hand-held tool",
            longest: HAND_HELD,
            key: "body.mesh_unit",
        },
    }
}

/// How the surfaces of a body from a file are named.
fn naming(design: &Design, kind: BodyKind) -> Naming {
    let of = SurfaceOf::from(kind);
    let place = |(entry, place): (&String, &NamedSurface)| {
        let along = [place.along_x, place.along_y, place.along_z];
        SurfacePlace {
            entry: entry.clone(),
            surface: place.surface.as_str(),
            at: [place.x, place.y, place.z],
            radius: place.radius,
            outward: along.iter().any(|c| *c != 0.0).then_some(along),
        }
    };
    let own = design.surfaces.iter().filter(|(_, place)| place.body == of);
    Naming {
        places: own.map(place).collect(),
        tool: (kind == BodyKind::Tool).then(|| ToolShape {
            bore: 0.5 * design.piston.bore,
        }),
    }
}

/// Required mass of a meshed body \[kg\], if it is a parameter of the cycle.
pub(crate) fn mass(design: &Design, kind: BodyKind) -> Option<f64> {
    (kind == BodyKind::Tool).then_some(design.tool.mass)
}

/// Places where the shot's forces, contacts and supports act on a body.
fn places(design: &Design, kind: BodyKind) -> Result<LoadPlaces, Error> {
    let support = supports::of(design);
    let contacts = |group, outward| -> Result<Vec<ContactFace>, Error> {
        let contacts = support.contacts()?.into_iter();
        Ok(contacts.map(|contact| contact.cells.on(group, outward)).collect())
    };
    Ok(match kind {
        BodyKind::Workpiece => LoadPlaces {
            nail: Some(nail_place(design)),
            contacts: contacts("bottom", [0.0, 0.0, -1.0])?,
            side_sand: support.sides()?.map(|sides| sides.cells),
            springs: spring_feet(design, Sprung::Workpiece),
            joint: joint(design),
            ..LoadPlaces::default()
        },
        BodyKind::Worktable => LoadPlaces {
            contacts: contacts("top", [0.0, 0.0, 1.0])?,
            springs: spring_feet(design, Sprung::Worktable),
            elsewhere: joint(design).map_or(0, |joint| joint.supports_count()),
            ..LoadPlaces::default()
        },
        BodyKind::Tool => LoadPlaces {
            tool: Some(ToolPlaces {
                valve: [design.head_valve.inner_diameter, design.head_valve.outer_diameter],
                check_holes: design.chambers.check_hole_position,
            }),
            ..LoadPlaces::default()
        },
    })
}

fn nail_place(design: &Design) -> NailPlace {
    NailPlace {
        at: [design.nail.offset_along, design.nail.offset_across],
        top: design.workpiece.thickness,
        entry: design.workpiece.thickness - design.workpiece.groove,
        length: super::assembly::fastener_length(design).unwrap_or(design.nail.length),
        nose: [design.body.nose_width, design.body.nose_depth],
    }
}

/// Length of the shank on each side of a joint that resists slip, in diameters.
///
/// The decay length of a dowel in wood, (4 E I/k)^(1/4), is 3.4 to 4.5 diameters for steel and a foundation modulus k
/// of 0.3 to 0.1 kN/mm2 (beam on an elastic foundation: E. W. Kuenzi 1955, "Theoretical design of a nailed or bolted
/// joint under lateral load", Forest Products Laboratory report 1951). Chosen: 5, so that the tail is included. The
/// total stiffness is a separate input; the length only sets the depth over which it acts.
const DOWEL: f64 = 5.0;

/// Joint of the board on the block, if there is a board.
fn joint(design: &Design) -> Option<Joint> {
    let (block, board) = (&design.workpiece, &design.workpiece.board);
    (board.thickness > 0.0).then(|| Joint {
        height: block.thickness - board.thickness,
        cells: supports::underside(design),
        nail: nail_place(design),
        dowel: DOWEL * design.nail.diameter,
    })
}

/// Springs and dashpots of that joint.
pub(crate) fn joint_supports(design: &Design) -> Vec<Support> {
    let (board, contact) = (&design.workpiece.board, &design.support.contact);
    let spring = |stiffness: f64| JointSpring {
        stiffness,
        damping: contact_dashpot(stiffness, board.loss_ratio, contact.loss_frequency),
    };
    let springs = [board.stiffness_per_area, board.axial_stiffness, board.shear_stiffness].map(spring);
    let [touch, axial, shear] = springs;
    joint(design).map_or_else(Vec::new, |joint| joint.supports(touch, axial, shear))
}

/// Lengths of the workpiece along x, y and z \[m\].
pub(crate) fn block_size(design: &Design) -> [f64; 3] {
    let block = &design.workpiece;
    [block.length, block.width, block.thickness]
}

/// Direction, stiffness \[N/m\] and damping \[N s/m\] of a spring along one axis.
type SpringAxis = ([f64; 3], f64, f64);

/// Springs on bodies that the design has, by name, each with its axes.
fn springs(design: &Design) -> impl Iterator<Item = (&String, &Spring, Vec<SpringAxis>)> {
    let present = design.springs.iter().filter(|(_, spring)| design.has(spring.body));
    present.map(|(name, spring)| {
        let axes = [
            ([1.0, 0.0, 0.0], spring.stiffness_x, spring.damping_x),
            ([0.0, 1.0, 0.0], spring.stiffness_y, spring.damping_y),
            ([0.0, 0.0, -1.0], spring.stiffness_z, spring.damping_z),
        ];
        let acts = |(_, stiffness, damping): &(_, f64, f64)| *stiffness > 0.0 || *damping > 0.0;
        (name, spring, axes.into_iter().filter(acts).collect())
    })
}

/// Feet of all springs, as they act on one body.
fn spring_feet(design: &Design, body: Sprung) -> Vec<SpringFoot> {
    let foot = |(name, spring, axes): (&String, &Spring, Vec<SpringAxis>)| SpringFoot {
        name: name.clone(),
        place: (spring.body == body).then_some(([spring.x, spring.y, spring.z], spring.radius)),
        axes: axes.into_iter().map(|(axis, ..)| axis).collect(),
    };
    springs(design).map(foot).collect()
}

/// Stiffness and damping of all springs, in the order of their load vectors.
pub(crate) fn spring_supports(design: &Design) -> Vec<Support> {
    let axes = springs(design).flat_map(|(.., axes)| axes);
    axes.map(|(_, stiffness, damping)| Support {
        stiffness,
        damping,
        gap: 0.0,
        law: SupportLaw::Bonded,
    })
    .collect()
}

/// Adds the place in the design file to an error of a body's stages, if it has one.
pub(crate) fn located(design: &Design, error: Error) -> Error {
    match error {
        Error::Body(BodyError::SpringOutside { spring, distance }) => match design.springs.get(&spring) {
            Some(own) => design.refuse_spring(&spring, own, distance).into(),
            None => BodyError::SpringOutside { spring, distance }.into(),
        },
        Error::Body(BodyError::SurfaceOutside { entry, distance }) => match design.surfaces.get(&entry) {
            Some(&NamedSurface { body, x, y, z, .. }) => {
                let problem = match distance {
                    Some(distance) => SurfaceProblem::Outside {
                        body,
                        point: [x, y, z],
                        distance,
                    },
                    None => SurfaceProblem::NoFace { body },
                };
                design.refuse_surface(&entry, problem).into()
            }
            None => BodyError::SurfaceOutside { entry, distance }.into(),
        },
        Error::Surface(SurfaceError::NoCapSurface { surface, panels }) => design.refuse_cap(surface, panels).into(),
        other => other,
    }
}
