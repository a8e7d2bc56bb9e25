//! Radiation per unit of modal motion, and fluid loading of the modes.

use nailnoise_acoustics::radiation::boundary_elements::ModalBem;
use nailnoise_acoustics::radiation::radiator::{FluidLoads, Loading, Radiator};

use super::bodies::{Bodies, BodyStages};
use super::context::Context;
use super::reference::{ReferenceStructures, from_references, references};
use crate::design::inputs;
use crate::error::Error;
use crate::stages::bodies::{Body, BodyKind};
use crate::stages::radiation::{
    FluidLoadings, FlushMatrix, RadiatingShape, ToolRadiation, ToolRadiator, WorkpieceMethod, WorkpieceRadiation,
    WorkpieceRadiator,
};
use crate::stages::sound_fields::FieldMethod;
use crate::stages::{Digest, OnDemand, Stored};

/// Radiation of the bodies of a design.
pub(crate) struct Radiators {
    /// The workpiece with its support.
    pub(crate) workpiece: WorkpieceStages,
    /// Fluid loading of the modes of workpiece and support.
    pub(crate) workpiece_loads: Stored<Vec<FluidLoads>>,
    /// The tool, if boundary elements are requested.
    pub(crate) tool: Option<ToolStages>,
    /// The part of the fluid loading that acts on the modes.
    pub(crate) acts: Loading,
}

/// Radiation of the workpiece with its support.
pub(crate) struct WorkpieceStages {
    /// The radiator.
    pub(crate) radiator: Stored<Box<dyn Radiator>>,
    /// The same, with pressures at the microphones.
    pub(crate) at_microphones: Stored<Box<dyn Radiator>>,
    /// How its sound field is computed.
    pub(crate) field: FieldMethod,
    /// The key of its radiation matrix.
    matrix_key: Option<Digest>,
}

/// Radiation of the tool by boundary elements.
pub(crate) struct ToolStages {
    /// Its boundary elements.
    pub(crate) elements: ToolRadiation,
    /// The complete body.
    pub(crate) whole: ToolMatrix,
    /// With a second column per mode for the motion of only the cap, if the cap belongs to another source.
    pub(crate) cap: Option<ToolMatrix>,
    /// Fluid loading of its modes.
    pub(crate) loads: Stored<Vec<FluidLoads>>,
}

/// Radiation of the tool in the ambient air.
pub(crate) struct ToolMatrix {
    /// The radiator.
    pub(crate) radiator: Stored<ModalBem>,
    /// The same, with pressures at the microphones.
    pub(crate) at_microphones: Stored<ModalBem>,
    /// The key of its radiation matrix in standard air.
    key: Digest,
}

impl Radiators {
    /// Adds the radiation of a design's bodies.
    ///
    /// # Errors
    /// If the values of the design do not yield valid inputs.
    pub(crate) fn add(context: Context<'_>, bodies: &Bodies) -> Result<Self, Error> {
        let Context { graph, design, .. } = context;
        let acts = inputs::radiation::loading(design);
        let structure = bodies.structure_bodies();
        let workpiece = workpiece_radiation(context, &structure)?;
        let loss_factors = bodies.structure.iter().map(|stages| stages.loss_factor);
        let workpiece_loads = graph.add(FluidLoadings {
            radiator: workpiece.radiator.clone(),
            bodies: structure,
            with_mass: damping_ratios(acts, loss_factors),
        });
        let tool = match &bodies.tool {
            Some(stages) => tool_radiation(context, stages, acts)?,
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
    pub(crate) fn matrix_keys(&self) -> impl Iterator<Item = Digest> {
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

/// Damping ratios of structures with these loss factors, if the added mass acts.
fn damping_ratios(acts: Loading, loss_factors: impl Iterator<Item = f64>) -> Option<Vec<f64>> {
    (acts == Loading::Full).then(|| loss_factors.map(|loss_factor| 0.5 * loss_factor).collect())
}

/// Radiation of the tool by boundary elements; none if the design does not request them.
fn tool_radiation(context: Context<'_>, stages: &BodyStages, acts: Loading) -> Result<Option<ToolStages>, Error> {
    let Context {
        graph,
        design,
        air,
        shared,
    } = context;
    let Some(elements) = inputs::radiation::tool(design)? else {
        return Ok(None);
    };
    // A user's housing has its own modes: most of the tool's mass is lumped on it, and the motion that standard
    // structures of its shape cannot represent may amount to a decibel.
    let references = match design.body.mesh.is_empty() && shared.tool {
        true => references(graph, design, &[BodyKind::Tool])?,
        false => ReferenceStructures::new(),
    };
    let places = inputs::radiation::tool_places(design);
    let of = |shape: &RadiatingShape| {
        let radiation = from_references(graph, shape, &places, &references, std::slice::from_ref(&stages.body));
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
pub(crate) fn workpiece_radiation(context: Context<'_>, bodies: &[Stored<Body>]) -> Result<WorkpieceStages, Error> {
    let Context {
        graph,
        design,
        air,
        shared,
    } = context;
    let radiator = |method| {
        graph.add(WorkpieceRadiator {
            method,
            bodies: OnDemand(bodies.to_vec()),
            air,
        })
    };
    if bodies.is_empty() {
        // Nothing reads this radiator.
        let radiator = radiator(WorkpieceMethod::Erp(inputs::radiation::covered_faces(design)));
        return Ok(WorkpieceStages {
            at_microphones: radiator.clone(),
            radiator,
            field: FieldMethod::Absent,
            matrix_key: None,
        });
    }
    Ok(match inputs::radiation::workpiece(design)? {
        WorkpieceRadiation::BoundaryElements(elements) => {
            let kinds = [BodyKind::Workpiece, BodyKind::Worktable];
            let references = match shared.workpiece {
                true => references(graph, design, &kinds[..bodies.len()])?,
                false => ReferenceStructures::new(),
            };
            let shape = RadiatingShape::Workpiece(elements.clone());
            let places = inputs::radiation::workpiece_places(design);
            let radiation = from_references(graph, &shape, &places, &references, bodies);
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
