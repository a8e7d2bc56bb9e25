//! Projection on reference structures: their radiation matrix, solved by boundary elements, serves other bodies.

use nailnoise_acoustics::radiation::boundary_elements::{ModalBem, ModalPressures};
use nailnoise_meshes::gmsh;

use super::bodies::{BodyStages, solved_bodies};
use crate::design::{Design, inputs};
use crate::error::Error;
use crate::graph::Graph;
use crate::stages::bodies::{Body, BodyKind};
use crate::stages::radiation::{
    MatrixWithMicrophones, Places, PressureAtMicrophones, PressureOnSurface, ProjectedMatrix, ProjectedPressures,
    RadiatingShape, RadiationMatrix, ReferenceProjection, ReferenceResult, Solution, SurfaceModes, ToolCapSolution,
    ToolSolution, WorkpieceSolution,
};
use crate::stages::{Digest, OnDemand, Stored};

/// Whether other designs have the shape of a design's bodies. If none does, boundary elements are solved for its own
/// modes, and reference bodies need no modes.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct SharedShapes {
    /// Shape of the workpiece with its table.
    pub workpiece: bool,
    /// Shape of the tool.
    pub tool: bool,
}

impl Default for SharedShapes {
    /// All shapes are shared.
    fn default() -> Self {
        Self {
            workpiece: true,
            tool: true,
        }
    }
}

impl SharedShapes {
    /// Shapes that two designs have in common.
    ///
    /// # Errors
    /// Errors in the bodies' materials and mesh files.
    pub(crate) fn of(graph: &Graph, design: &Design, other: &Design) -> Result<Self, Error> {
        let alike = |is_tool: bool| -> Result<bool, Error> {
            let keys = |design: &Design| {
                let kinds = solved_bodies(design).into_iter();
                let kinds: Vec<BodyKind> = kinds.filter(|kind| (*kind == BodyKind::Tool) == is_tool).collect();
                let bodies = reference_bodies(graph, design, &kinds)?;
                Ok::<_, Error>(bodies.map(|bodies| bodies.iter().map(|body| *body.key()).collect::<Vec<Digest>>()))
            };
            Ok(keys(design)? == keys(other)?)
        };
        Ok(Self {
            workpiece: alike(false)?,
            tool: alike(true)?,
        })
    }
}

/// The first reference bodies with the shape of the design's bodies; `None` if no standard exists for them.
fn reference_bodies(graph: &Graph, design: &Design, kinds: &[BodyKind]) -> Result<Option<Vec<Stored<Body>>>, Error> {
    let references = inputs::reference_structures::references(design, kinds)?;
    references
        .map(|references| bodies(graph, &references.first, kinds))
        .transpose()
}

/// The bodies of a design.
fn bodies(graph: &Graph, design: &Design, kinds: &[BodyKind]) -> Result<Vec<Stored<Body>>, Error> {
    kinds
        .iter()
        .map(|&kind| Ok(BodyStages::add(graph, design, kind, true)?.body))
        .collect()
}

/// Standard structures whose modes may represent the motion of a design's bodies, with their names, in the order in
/// which they are tried.
pub(super) type ReferenceStructures = Vec<(SurfaceModes, &'static str)>;

/// Reference structures in the shape of a design's tool, or of its workpiece and table; none if these have no standard.
///
/// # Errors
/// Errors in the bodies' materials and mesh files.
pub(super) fn references(graph: &Graph, design: &Design, kinds: &[BodyKind]) -> Result<ReferenceStructures, Error> {
    let Some(references) = inputs::reference_structures::references(design, kinds)? else {
        return Ok(Vec::new());
    };
    let structure = |design: &Design| bodies(graph, design, kinds);
    let first = structure(&references.first)?;
    let alone = (SurfaceModes(vec![first.clone()]), "reference bodies of the same shape");
    // Without gmsh, the second structure is omitted if the design's own meshes do not need gmsh.
    let second = match &references.second {
        Some(second) if gmsh::is_found() || !inputs::reference_structures::needs_gmsh(second, kinds)? => {
            structure(second)?
        }
        _ => return Ok(vec![alone]),
    };
    let both = (
        SurfaceModes(vec![first, second]),
        "two reference structures of the same shape",
    );
    Ok(match kinds == [BodyKind::Tool] && references.walls_differ() {
        true => vec![both],
        false => vec![alone, both],
    })
}

/// Radiation of bodies by boundary elements.
pub(super) struct Radiation {
    /// Powers.
    pub(super) matrix: Stored<ModalBem>,
    /// Pressures at the microphones for the same modes.
    pub(super) pressures: Stored<ModalPressures>,
}

impl Radiation {
    /// Combines powers and pressures at the microphones.
    pub(super) fn at_microphones(&self, graph: &Graph) -> Stored<ModalBem> {
        graph.add(MatrixWithMicrophones {
            matrix: self.matrix.clone(),
            pressures: self.pressures.clone(),
        })
    }
}

/// The radiation of bodies from that of reference bodies of their shape.
pub(super) fn from_references(
    graph: &Graph,
    shape: &RadiatingShape,
    places: &Places,
    references: &ReferenceStructures,
    bodies: &[Stored<Body>],
) -> Radiation {
    let own = solved(graph, shape, places, SurfaceModes(vec![bodies.to_vec()]));
    let (mut powers, mut pressures) = (Vec::new(), Vec::new());
    for (standard, name) in references {
        let limit = shape.limit(standard.0.len());
        let of_standard = solved(graph, shape, places, standard.clone());
        if of_standard.matrix.key() == own.matrix.key() && powers.is_empty() {
            return own;
        }
        let fit = graph.add(ReferenceProjection {
            shape: shape.clone(),
            standard: standard.clone(),
            bodies: bodies.to_vec(),
        });
        powers.push(ReferenceResult {
            fit: fit.clone(),
            known: of_standard.matrix,
            name,
            limit,
        });
        pressures.push(ReferenceResult {
            fit,
            known: of_standard.pressures,
            name,
            limit,
        });
    }
    if powers.is_empty() {
        return own;
    }
    Radiation {
        matrix: graph.add(ProjectedMatrix {
            references: OnDemand(powers),
            own: OnDemand(own.matrix),
        }),
        pressures: graph.add(ProjectedPressures {
            references: OnDemand(pressures),
            own: OnDemand(own.pressures),
        }),
    }
}

/// Results of boundary elements for the modes of bodies.
fn solved(graph: &Graph, shape: &RadiatingShape, places: &Places, modes: SurfaceModes) -> Radiation {
    let bodies = modes.0.first().cloned().unwrap_or_default();
    let solution = solution(graph, shape, modes);
    let surface = graph.add(PressureOnSurface {
        solution: OnDemand(solution.clone()),
    });
    Radiation {
        matrix: graph.add(RadiationMatrix {
            solution: OnDemand(solution),
            surface: OnDemand(surface.clone()),
        }),
        pressures: graph.add(PressureAtMicrophones {
            shape: shape.clone(),
            bodies,
            surface,
            places: places.clone(),
        }),
    }
}

/// The solution of boundary elements for the modes of bodies.
fn solution(graph: &Graph, shape: &RadiatingShape, modes: SurfaceModes) -> Stored<Solution> {
    match shape.clone() {
        RadiatingShape::Workpiece(elements) => graph.add(WorkpieceSolution { elements, modes }),
        RadiatingShape::Tool(elements) => graph.add(ToolSolution { elements, modes }),
        RadiatingShape::Cap(elements, cap) => graph.add(ToolCapSolution { elements, cap, modes }),
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]

    use std::f64::consts::TAU;

    use nailnoise_acoustics::radiation::radiator::Radiator;
    use nailnoise_acoustics::radiation::{ModalRadiation, ModalSpectra};
    use nailnoise_meshes::msh::{self, Format};
    use nailnoise_meshes::{Block, FaceGroup, FaceRef, Surface, block};
    use nalgebra::{Complex, DMatrix, DVector, Vector3};

    use super::super::context::Context;
    use super::super::radiation::workpiece_radiation;
    use super::*;
    use crate::design::{BodyModel, Convention, RadiationMethod};
    use crate::stages::radiation::WorkpieceRadiation;
    use crate::stages::sound_fields::FieldMethod;

    /// Key of the boundary-element solution of the workpiece, and that of the matrix of the design's modes.
    fn solved_keys(design: &Design) -> [Digest; 2] {
        let graph = Graph::default();
        let WorkpieceRadiation::BoundaryElements(elements) = inputs::radiation::workpiece(design).unwrap() else {
            panic!("boundary elements")
        };
        let kinds = [BodyKind::Workpiece, BodyKind::Worktable];
        let standard = reference_bodies(&graph, design, &kinds).unwrap().unwrap();
        let own = kinds.map(|kind| BodyStages::add(&graph, design, kind, true).unwrap().body);
        [standard, own.to_vec()].map(|bodies| {
            let shape = RadiatingShape::Workpiece(elements.clone());
            *solution(&graph, &shape, SurfaceModes(vec![bodies])).key()
        })
    }

    #[test]
    fn boundary_elements_are_kept_by_the_shape_of_workpiece_and_table() {
        let base = Design::load(concat!(env!("CARGO_MANIFEST_DIR"), "/tests/data/small-bem.toml")).unwrap();
        let [known, own] = solved_keys(&base);
        assert_eq!(known, own, "the N80CB has the standard materials");
        let mut other = base.clone();
        other.wood.density *= 1.05;
        other.wood.elastic.e_l *= 0.9;
        other.wood.loss_factor *= 2.0;
        other.nail.length *= 0.9;
        other.nail.offset_along += 0.03;
        other.support.worktable.top_density *= 1.1;
        let [same, own] = solved_keys(&other);
        assert_eq!(known, same);
        assert_ne!(known, own);
        for longer in [
            |design: &mut Design| design.workpiece.thickness *= 1.01,
            |design: &mut Design| design.support.worktable.height *= 1.01,
        ] {
            let mut other = base.clone();
            longer(&mut other);
            assert_ne!(known, solved_keys(&other)[0]);
        }
    }

    /// Keys of the powers of workpiece and table, and of their pressures at the microphones.
    fn radiation_keys(design: &Design) -> [Digest; 2] {
        let graph = Graph::default();
        let bodies = [BodyKind::Workpiece, BodyKind::Worktable]
            .map(|kind| BodyStages::add(&graph, design, kind, true).unwrap().body);
        let shape = RadiatingShape::Workpiece(inputs::radiation::workpiece_boundary_elements(design));
        let places = inputs::radiation::workpiece_places(design);
        let modes = SurfaceModes(vec![bodies.to_vec()]);
        let Radiation { matrix, pressures } = solved(&graph, &shape, &places, modes);
        [*matrix.key(), *pressures.key()]
    }

    #[test]
    fn other_microphones_need_no_boundary_elements() {
        let base = Design::load(concat!(env!("CARGO_MANIFEST_DIR"), "/tests/data/small-bem.toml")).unwrap();
        let mut other = base.clone();
        other.acoustics.ear_across *= 1.1;
        let ([powers, pressures], [same, moved]) = (radiation_keys(&base), radiation_keys(&other));
        assert_eq!(powers, same);
        assert_ne!(pressures, moved);
    }

    #[test]
    fn designs_share_the_shapes_that_materials_and_masses_leave() {
        let base = Design::load(concat!(env!("CARGO_MANIFEST_DIR"), "/designs/n80cb.toml")).unwrap();
        let shared = |change: fn(&mut Design)| {
            let mut other = base.clone();
            change(&mut other);
            let SharedShapes { workpiece, tool } = SharedShapes::of(&Graph::default(), &base, &other).unwrap();
            [workpiece, tool]
        };
        assert_eq!(shared(|_| {}), [true, true]);
        assert_eq!(shared(|design| design.wood.density *= 1.1), [true, true]);
        assert_eq!(shared(|design| design.tool.mass *= 1.1), [true, true]);
        assert_eq!(shared(|design| design.support.worktable.height *= 1.1), [false, true]);
        assert_eq!(shared(|design| design.body.cap_radius *= 1.1), [true, false]);
    }

    /// Whether each of the references represents the motion of a design's workpiece and table. Also returns the largest
    /// difference in power \[dB\] between the radiation from reference structures and boundary elements with the
    /// design's modes, under a force of 1 N at the nail's head and 1 N on the middle of the table.
    fn carried_over(design: &Design) -> (Vec<bool>, f64) {
        let graph = Graph::default();
        let air = inputs::air(design).unwrap();
        let kinds = [BodyKind::Workpiece, BodyKind::Worktable];
        let bodies = kinds.map(|kind| BodyStages::add(&graph, design, kind, true).unwrap().body);
        let context = Context {
            graph: &graph,
            design,
            air,
            shared: SharedShapes::default(),
        };
        let radiation = workpiece_radiation(context, &bodies).unwrap();
        let FieldMethod::BoundaryElements(elements, from_references) = radiation.field else {
            panic!("boundary elements")
        };
        let holds = |(standard, name): (SurfaceModes, &str)| {
            let fitted = ReferenceProjection {
                shape: RadiatingShape::Workpiece(elements.clone()),
                standard,
                bodies: bodies.to_vec(),
            };
            let fitted = graph.get(fitted).unwrap();
            println!("{name} lack at most {:.1e}", fitted.worst());
            fitted.holds()
        };
        let held = references(&graph, design, &kinds)
            .unwrap()
            .into_iter()
            .map(holds)
            .collect();
        let modes = SurfaceModes(vec![bodies.to_vec()]);
        let shape = RadiatingShape::Workpiece(elements);
        let own = solved(&graph, &shape, &inputs::radiation::workpiece_places(design), modes).matrix;
        let (from_references, own) = (from_references.get().unwrap(), own.get().unwrap());
        let mut largest: f64 = 0.0;
        for hz in [60.0f64, 130.0, 240.0, 390.0] {
            let mut power = [0.0; 2];
            for first_body in [0, 1] {
                let mut amplitudes = Vec::new();
                for (number, body) in bodies.iter().enumerate() {
                    let body = body.get().unwrap();
                    let loads = if number == 0 { &body.loads } else { &body.contacts };
                    let column = loads.column(if number == 0 { 0 } else { loads.ncols() / 2 });
                    for (force, omega) in column.iter().zip(&body.omega) {
                        let (square, driven) = (omega * omega, (TAU * hz).powi(2));
                        let response = force / (square - driven).hypot(0.05 * square);
                        amplitudes.push(if number == first_body { response } else { 0.0 });
                    }
                }
                for (power, matrix) in power.iter_mut().zip([&from_references, &own]) {
                    let resistance = ModalRadiation::resistance(&**matrix, hz).real;
                    let v = DVector::from_column_slice(&amplitudes);
                    *power += v.dot(&(resistance * &v));
                }
            }
            let apart = 10.0 * (power[0] / power[1]).log10();
            println!("{hz} Hz: {apart:+.4} dB");
            largest = largest.max(apart.abs());
        }
        (held, largest)
    }

    #[test]
    fn another_wood_radiates_as_by_boundary_elements_of_its_own() {
        let mut design = Design::load(concat!(env!("CARGO_MANIFEST_DIR"), "/tests/data/small-bem.toml")).unwrap();
        design.wood.density *= 1.05;
        design.nail.length *= 0.9;
        let (held, apart) = carried_over(&design);
        assert!(held[0]);
        assert!(apart < 0.02, "{apart} dB");
    }

    #[test]
    fn a_nail_elsewhere_radiates_as_by_boundary_elements_of_its_own() {
        let mut design = Design::load(concat!(env!("CARGO_MANIFEST_DIR"), "/tests/data/small-bem.toml")).unwrap();
        (design.nail.offset_along, design.nail.offset_across) = (0.06, -0.02);
        let (held, apart) = carried_over(&design);
        assert!(held[0]);
        assert!(apart < 0.02, "{apart} dB");
    }

    #[test]
    fn a_soft_block_radiates_by_two_structures_as_by_boundary_elements_of_its_own() {
        let mut design = Design::load(concat!(env!("CARGO_MANIFEST_DIR"), "/tests/data/small-bem.toml")).unwrap();
        let wood = &mut design.wood.elastic;
        for modulus in [&mut wood.e_l, &mut wood.e_r, &mut wood.e_t] {
            *modulus *= 0.1;
        }
        for modulus in [&mut wood.g_lr, &mut wood.g_lt, &mut wood.g_rt] {
            *modulus *= 0.3;
        }
        let (held, apart) = carried_over(&design);
        assert_eq!(held, [false, true]);
        assert!(apart < 0.02, "{apart} dB");
    }

    #[test]
    fn two_structures_of_the_tool_are_solved_together_where_walls_can_differ() {
        let base = Design::load(concat!(env!("CARGO_MANIFEST_DIR"), "/designs/n80cb.toml")).unwrap();
        let walls_differ = |design: &Design| {
            let references = inputs::reference_structures::references(design, &[BodyKind::Tool]).unwrap();
            references.unwrap().walls_differ()
        };
        assert!(walls_differ(&base));
        let mut other = base.clone();
        other.body.cap_wall *= 1.1;
        assert!(walls_differ(&other));
        other.body.cap_radius *= 1.1;
        assert!(!walls_differ(&other));
        assert!(!walls_differ(&slab("walls")));
    }

    /// The surfaces of the tool used by boundary elements: with and without a separate cap.
    fn tool_shapes(design: &Design) -> [RadiatingShape; 2] {
        let elements = inputs::radiation::tool(design).unwrap().unwrap();
        let mut wrapped = design.clone();
        wrapped.sources.convention = Convention::Wrapping;
        let cap = inputs::radiation::cap(&wrapped).unwrap();
        [
            RadiatingShape::Tool(elements.clone()),
            RadiatingShape::Cap(elements, cap),
        ]
    }

    /// Keys of the boundary-element solutions of the tool, and of the matrices of its modes.
    fn solved_keys_of_tool(design: &Design) -> [[Digest; 2]; 2] {
        let graph = Graph::default();
        let standard = reference_bodies(&graph, design, &[BodyKind::Tool]).unwrap().unwrap();
        let own = BodyStages::add(&graph, design, BodyKind::Tool, true).unwrap().body;
        [standard, vec![own]]
            .map(|bodies| SurfaceModes(vec![bodies]))
            .map(|modes| tool_shapes(design).map(|shape| *solution(&graph, &shape, modes.clone()).key()))
    }

    #[test]
    fn boundary_elements_are_kept_by_the_shape_of_the_tool() {
        let base = Design::load(concat!(env!("CARGO_MANIFEST_DIR"), "/designs/n80cb.toml")).unwrap();
        let [known, own] = solved_keys_of_tool(&base);
        assert_eq!(known, own, "the N80CB is the standard tool");
        for change in [
            |design: &mut Design| design.tool.mass *= 1.05,
            |design: &mut Design| design.body.lumped_magazine *= 1.1,
            |design: &mut Design| design.head_valve.outer_diameter *= 0.99,
            |design: &mut Design| design.chambers.check_hole_position *= 0.8,
            |design: &mut Design| design.body.housing.young_modulus *= 1.5,
            |design: &mut Design| design.body.nose.density *= 1.01,
            |design: &mut Design| design.body.sleeve.poisson_ratio *= 0.95,
            |design: &mut Design| design.body.handle_wall *= 1.1,
            |design: &mut Design| design.body.cap_wall *= 1.1,
            |design: &mut Design| design.body.nose_wall *= 0.9,
            |design: &mut Design| {
                // The gap compensates for the change of the wall.
                design.body.barrel_wall += 1e-4;
                design.body.sleeve_gap -= 1e-4;
            },
        ] {
            let mut other = base.clone();
            change(&mut other);
            let [same, own] = solved_keys_of_tool(&other);
            assert_eq!(known, same);
            assert!(known.iter().zip(&own).all(|(known, own)| known != own));
        }
        let mut damped = base.clone();
        damped.body.loss_factor *= 2.0;
        assert_eq!(solved_keys_of_tool(&damped), [known, known]);
        for larger in [
            |design: &mut Design| design.body.cap_radius *= 1.01,
            |design: &mut Design| design.body.handle_length *= 1.01,
            |design: &mut Design| design.piston.bore *= 1.01,
            |design: &mut Design| design.body.barrel_wall *= 1.1,
        ] {
            let mut other = base.clone();
            larger(&mut other);
            let [known_of_other, _] = solved_keys_of_tool(&other);
            assert!(known.iter().zip(&known_of_other).all(|(known, other)| known != other));
        }
    }

    /// A slab as housing, with the surfaces on which the forces of a tool act; its modes start at about 700 Hz. Its
    /// file is named after the test, because tests run in parallel.
    fn slab(name: &str) -> Design {
        const SIZE: [f64; 3] = [0.1, 0.012, 0.3];
        let mut mesh = block(&Block {
            size: SIZE,
            divisions: [3, 1, 8],
            origin: [-0.05, -0.006, 0.0],
        })
        .unwrap();
        let surface = Surface::of(&mesh);
        let names = [
            "cap",
            "nose_tip",
            "handle",
            "cap_outside",
            "seat",
            "bumper_seat",
            "gas_bore",
        ];
        let mut groups: [Vec<FaceRef>; 7] = Default::default();
        for face in &surface.faces {
            let sum: Vector3<f64> = face.nodes.iter().map(|&node| surface.points[node].coords).sum();
            let centre = sum / face.nodes.len() as f64;
            let group = match () {
                () if centre.z > SIZE[2] - 1e-9 => 0,
                () if centre.z < 1e-9 => 1,
                () if centre.x > 0.05 - 1e-9 => 2,
                () if centre.z > 0.25 && centre.y > 0.006 - 1e-9 => 3,
                () if centre.z > 0.25 => 4,
                () if centre.z < 0.05 => 5,
                () => 6,
            };
            groups[group].push(face.of);
        }
        mesh.groups = names
            .into_iter()
            .zip(groups)
            .map(|(name, faces)| FaceGroup {
                name: name.to_owned(),
                faces,
            })
            .collect();
        let path = std::env::temp_dir().join(format!("nailnoise-slab-{}-{name}.msh", std::process::id()));
        std::fs::write(&path, msh::to_bytes(&mesh, Format::Binary41, "of a test")).unwrap();
        let mut design = Design::load(concat!(env!("CARGO_MANIFEST_DIR"), "/tests/data/small-bem.toml")).unwrap();
        design.body.model = BodyModel::Elastic;
        design.body.mesh = path.to_string_lossy().into_owned();
        design.body.mesh_unit = 1.0;
        design.acoustics.body_method = RadiationMethod::Bem;
        design.acoustics.bem_max_frequency = 1500.0;
        design.acoustics.bem_tolerance = 0.005;
        design.analysis.body_max_frequency = 8000.0;
        design.sensors.remove("handle"); // the slab has none
        design
    }

    /// Fourier transforms of the modal accelerations due to a force of 1 N at one load, the same at all frequencies
    /// \[m/s\].
    fn driven(body: &Body, load: usize, to_hz: f64) -> ModalSpectra {
        let frequency: Vec<f64> = (0..=(to_hz / 5.0) as usize).map(|bin| 5.0 * bin as f64).collect();
        let column = body.loads.column(load);
        let accelerations = DMatrix::from_fn(body.omega.len(), frequency.len(), |mode, bin| {
            let (square, driven) = (body.omega[mode].powi(2), (TAU * frequency[bin]).powi(2));
            // Static corrections and modes have stiffness with a loss factor of 0.02; rigid modes are purely inertial,
            // 1/m.
            let response = Complex::new(square - driven, 0.02 * square);
            if bin == 0 {
                Complex::default()
            } else {
                Complex::from(-driven * column[mode]) / response
            }
        });
        ModalSpectra {
            frequency,
            accelerations,
            range_hz: [50.0, to_hz],
        }
    }

    /// Radiation and pressures derived from the standard housing without lumped mass, compared with boundary elements
    /// for the design's modes: a mass of 0.3 kg, mostly at the nose, and a different modulus, Poisson's ratio and
    /// density.
    #[test]
    fn another_tool_mass_and_alloy_radiate_as_by_boundary_elements_of_their_own() {
        let mut design = slab("carried");
        design.body.housing.young_modulus = 60e9;
        design.body.housing.poisson_ratio = 0.30;
        design.body.housing.density = 2500.0;
        (design.body.lumped, design.body.lumped_nose, design.body.lumped_magazine) = (true, 0.6, 0.0);
        design.tool.mass = 2500.0 * 0.1 * 0.012 * 0.3 + 0.3;
        let graph = Graph::default();
        let references = references(&graph, &design, &[BodyKind::Tool]).unwrap();
        let bodies = vec![BodyStages::add(&graph, &design, BodyKind::Tool, true).unwrap().body];
        let body = bodies[0].get().unwrap();
        assert!(
            body.omega
                .iter()
                .filter(|omega| **omega > 0.0 && **omega < TAU * 1500.0)
                .count()
                > 0
        );
        // Rings of the bore outside the slab do not load it.
        let loads: Vec<usize> = (0..body.loads.ncols())
            .filter(|&load| body.loads.column(load).norm() > 0.0)
            .collect();
        assert!(loads.len() > 10);
        for shape in tool_shapes(&design) {
            let fitted = graph.get(ReferenceProjection {
                shape: shape.clone(),
                standard: references[0].0.clone(),
                bodies: bodies.clone(),
            });
            let fitted = fitted.unwrap();
            println!("lacking at most {:.1e}", fitted.worst());
            assert!(fitted.worst() < 2e-4, "{:?}", fitted.lacking);
            let at = (&shape, &inputs::radiation::tool_places(&design));
            let own = solved(&graph, at.0, at.1, SurfaceModes(vec![bodies.clone()]));
            let from_references = from_references(&graph, at.0, at.1, &references, &bodies);
            let both = [from_references, own].map(|radiation| radiation.at_microphones(&graph).get().unwrap());
            for &load in &loads {
                let spectra = match shape {
                    RadiatingShape::Cap(..) => {
                        let whole = driven(&body, load, 4000.0);
                        let modes = whole.accelerations.nrows();
                        let accelerations = whole.accelerations.insert_rows(0, modes, Complex::default());
                        ModalSpectra { accelerations, ..whole }
                    }
                    _ => driven(&body, load, 4000.0),
                };
                let [a, b] = [0, 1].map(|index| both[index].energy("body", &[&spectra]).unwrap());
                for (a, b) in a
                    .band_levels(spectra.range_hz)
                    .iter()
                    .zip(b.band_levels(spectra.range_hz))
                {
                    if let (Some(a_db), Some(b_db)) = (a.lw, b.lw) {
                        let hz = a.band.nominal_hz();
                        assert!(
                            (a_db - b_db).abs() < 0.02,
                            "load {load}, {hz} Hz: {a_db} against {b_db} dB"
                        );
                    }
                }
                let [p, q] = [0, 1].map(|index| {
                    let bem: &ModalBem = &both[index];
                    bem.pressures(&spectra.frequency, &spectra.accelerations).unwrap()
                });
                let apart = (&p - &q).norm() / q.norm();
                assert!(apart < 0.005, "load {load}: pressures {apart} of their norm apart");
            }
        }
    }

    #[test]
    fn where_the_standard_tool_lacks_motion_the_modes_of_the_tool_are_solved() {
        let mut design = slab("own");
        // Few modes of the standard, and a mass at the nose equal to the slab's.
        design.analysis.body_max_frequency = 2000.0;
        design.body.housing.poisson_ratio = 0.25;
        (design.body.lumped, design.body.lumped_nose, design.body.lumped_magazine) = (true, 0.9, 0.0);
        design.tool.mass = 1810.0 * 0.1 * 0.012 * 0.3 + 1.0;
        let graph = Graph::default();
        let references = references(&graph, &design, &[BodyKind::Tool]).unwrap();
        let bodies = vec![BodyStages::add(&graph, &design, BodyKind::Tool, true).unwrap().body];
        let [shape, _] = tool_shapes(&design);
        assert_eq!(references.len(), 2);
        for (standard, _) in &references {
            let fitted = graph.get(ReferenceProjection {
                shape: shape.clone(),
                standard: standard.clone(),
                bodies: bodies.clone(),
            });
            let fitted = fitted.unwrap();
            println!("lacking at most {:.1e}", fitted.worst());
            assert!(
                fitted.fit.is_some() && fitted.worst() > shape.limit(standard.0.len()),
                "{:?}",
                fitted.lacking
            );
        }
        let at = (&shape, &inputs::radiation::tool_places(&design));
        let own = solved(&graph, at.0, at.1, SurfaceModes(vec![bodies.clone()]))
            .matrix
            .get()
            .unwrap();
        let from_references = from_references(&graph, at.0, at.1, &references, &bodies)
            .matrix
            .get()
            .unwrap();
        for hz in [100.0, 800.0, 1400.0] {
            assert_eq!(from_references.resistance(hz).real, own.resistance(hz).real);
        }
    }
}
