//! Radiation per unit of modal motion, and fluid loads of the air on the modes.

use nailnoise_acoustics::Air;
use nailnoise_acoustics::bem::ModalBem;
use nailnoise_acoustics::radiator::{FluidLoads, Loading, Radiator};

use super::bodies::{Bodies, BodyStages};
use super::shape::{SharedShapes, Standards, by_shape, standards};
use crate::design::{Design, inputs};
use crate::error::Error;
use crate::graph::Graph;
use crate::stages::bodies::{Body, BodyKind};
use crate::stages::radiation::{
    FluidLoadings, FlushMatrix, RadiatingShape, ToolRadiation, ToolRadiator, WorkpieceMethod, WorkpieceRadiation,
    WorkpieceRadiator,
};
use crate::stages::sound_fields::FieldMethod;
use crate::stages::{Digest, Stored};

/// How the bodies of a design radiate.
pub(super) struct Radiators {
    /// The workpiece with its support.
    pub(super) workpiece: WorkpieceStages,
    /// Fluid loads of the air on the modes of workpiece and support.
    pub(super) workpiece_loads: Stored<Vec<FluidLoads>>,
    /// The tool, if boundary elements are requested.
    pub(super) tool: Option<ToolStages>,
    /// Fluid loads of the air that act on the modes.
    pub(super) acts: Loading,
}

/// Radiation of the workpiece with its support.
pub(super) struct WorkpieceStages {
    /// The radiator.
    pub(super) radiator: Stored<Box<dyn Radiator>>,
    /// The same with its pressures at the microphones.
    pub(super) at_microphones: Stored<Box<dyn Radiator>>,
    /// How its sound field is computed.
    pub(super) field: FieldMethod,
    /// The key of its radiation matrix.
    matrix_key: Option<Digest>,
}

/// Radiation of the tool by boundary elements.
pub(super) struct ToolStages {
    /// Its boundary elements.
    pub(super) elements: ToolRadiation,
    /// The full body.
    pub(super) whole: ToolMatrix,
    /// A second column for each mode with only the cap in motion, if the cap belongs to another source.
    pub(super) cap: Option<ToolMatrix>,
    /// Fluid loads of the air on its modes.
    pub(super) loads: Stored<Vec<FluidLoads>>,
}

/// Radiation of the tool in the ambient air.
pub(super) struct ToolMatrix {
    /// The radiator.
    pub(super) radiator: Stored<ModalBem>,
    /// The same with its pressures at the microphones.
    pub(super) at_microphones: Stored<ModalBem>,
    /// The key of its radiation matrix in standard air.
    key: Digest,
}

impl Radiators {
    /// Adds the radiation of a design's bodies.
    ///
    /// # Errors
    /// Values of the design that do not yield inputs.
    pub(super) fn add(
        graph: &Graph,
        design: &Design,
        bodies: &Bodies,
        (air, shared): (Air, SharedShapes),
    ) -> Result<Self, Error> {
        let acts = inputs::radiation::loading(design);
        let structure = bodies.structure_bodies();
        let workpiece = workpiece_radiation(graph, design, &structure, (air, shared))?;
        let loss_factors = bodies.structure.iter().map(|stages| stages.loss_factor);
        let workpiece_loads = graph.add(FluidLoadings {
            radiator: workpiece.radiator.clone(),
            bodies: structure,
            with_mass: damping_ratios(acts, loss_factors),
        });
        let tool = match &bodies.tool {
            Some(stages) => tool_radiation(graph, design, stages, (air, shared, acts))?,
            None => None,
        };
        Ok(Self {
            workpiece,
            workpiece_loads,
            tool,
            acts,
        })
    }

    /// Keys of all radiation matrices.
    pub(super) fn matrix_keys(&self) -> impl Iterator<Item = Digest> {
        let cap = self.tool.iter().flat_map(|tool| &tool.cap);
        let tool = self
            .tool
            .iter()
            .map(|tool| &tool.whole)
            .chain(cap)
            .map(|matrix| matrix.key);
        self.workpiece.matrix_key.into_iter().chain(tool)
    }
}

/// Damping ratios of structures with these loss factors, if the air's mass acts.
fn damping_ratios(acts: Loading, loss_factors: impl Iterator<Item = f64>) -> Option<Vec<f64>> {
    (acts == Loading::Full).then(|| loss_factors.map(|loss_factor| 0.5 * loss_factor).collect())
}

/// Radiation of the tool by boundary elements; none if the design does not request them.
fn tool_radiation(
    graph: &Graph,
    design: &Design,
    stages: &BodyStages,
    (air, shared, acts): (Air, SharedShapes, Loading),
) -> Result<Option<ToolStages>, Error> {
    let Some(elements) = inputs::radiation::tool(design) else {
        return Ok(None);
    };
    // A user's housing has individual modes: most of the tool's mass is lumped on it, and the motion that standard
    // structures in its shape miss may be worth a decibel.
    let standards = match design.body.mesh.is_empty() && shared.tool {
        true => standards(graph, design, &[BodyKind::Tool])?,
        false => Standards::new(),
    };
    let places = inputs::radiation::tool_places(design);
    let of = |shape: &RadiatingShape| {
        let radiation = by_shape(graph, (shape, &places), &standards, std::slice::from_ref(&stages.body));
        let at_microphones = radiation.at_microphones(graph);
        let key = *radiation.matrix.key();
        let [radiator, at_microphones] =
            [radiation.matrix, at_microphones].map(|matrix| graph.add(ToolRadiator { matrix, air }));
        ToolMatrix {
            radiator,
            at_microphones,
            key,
        }
    };
    let whole = of(&RadiatingShape::Tool(elements.clone()));
    let cap = inputs::radiation::cap(design).map(|cap| of(&RadiatingShape::Cap(elements.clone(), cap)));
    let loads = graph.add(FluidLoadings {
        radiator: whole.radiator.clone(),
        bodies: vec![stages.body.clone()],
        with_mass: damping_ratios(acts, std::iter::once(stages.loss_factor)),
    });
    Ok(Some(ToolStages {
        elements,
        whole,
        cap,
        loads,
    }))
}

/// Radiation of the workpiece with its support.
pub(super) fn workpiece_radiation(
    graph: &Graph,
    design: &Design,
    bodies: &[Stored<Body>],
    (air, shared): (Air, SharedShapes),
) -> Result<WorkpieceStages, Error> {
    let radiator = |method| {
        graph.add(WorkpieceRadiator {
            method,
            bodies: bodies.to_vec(),
            air,
        })
    };
    Ok(match inputs::radiation::workpiece(design)? {
        WorkpieceRadiation::BoundaryElements(elements) => {
            let kinds = [BodyKind::Workpiece, BodyKind::Worktable];
            let standards = match shared.workpiece {
                true => standards(graph, design, &kinds[..bodies.len()])?,
                false => Standards::new(),
            };
            let shape = RadiatingShape::Workpiece(elements.clone());
            let places = inputs::radiation::workpiece_places(design);
            let radiation = by_shape(graph, (&shape, &places), &standards, bodies);
            let (at_microphones, matrix) = (radiation.at_microphones(graph), radiation.matrix);
            WorkpieceStages {
                radiator: radiator(WorkpieceMethod::BoundaryElements(matrix.clone())),
                at_microphones: radiator(WorkpieceMethod::BoundaryElements(at_microphones)),
                matrix_key: Some(*matrix.key()),
                field: FieldMethod::BoundaryElements(elements, matrix),
            }
        }
        WorkpieceRadiation::Erp(covered) => {
            let radiator = radiator(WorkpieceMethod::Erp(covered));
            WorkpieceStages {
                at_microphones: radiator.clone(),
                radiator,
                field: FieldMethod::Erp,
                matrix_key: None,
            }
        }
        WorkpieceRadiation::Rayleigh(top) => {
            let alone = graph.add(FlushMatrix {
                places: top.places.clone(),
                top_hz: top.top_hz,
                air: FlushMatrix::computed_air(&air),
                body: bodies[0].clone(),
            });
            let matrix_key = Some(*alone.key());
            let radiator = radiator(WorkpieceMethod::Rayleigh(top.clone(), alone));
            WorkpieceStages {
                at_microphones: radiator.clone(),
                field: FieldMethod::Rayleigh(top, radiator.clone()),
                radiator,
                matrix_key,
            }
        }
    })
}
