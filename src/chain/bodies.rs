//! Bodies of a design, from mesh to modal coordinates, and their preflight checks.

use std::sync::Arc;

use crate::design::inputs;
use crate::design::inputs::bodies::BodyInputs;
use crate::design::inputs::recorded_surfaces;
use crate::design::{BodyModel, Carrier, Design, SurfaceOf};
use crate::error::Error;
use crate::graph::Graph;
use crate::model::supports;
use crate::stages::bodies::{
    Body, BodyKind, BodySensors, Discretisation, Meshed, ModalModel, Model, Modes, SensorModes, WholeModes,
};
use crate::stages::requirements::{Preflight, Radiating, Requirements};
use crate::stages::{OnDemand, Stored};

/// The stages of a body.
#[derive(Clone)]
pub struct BodyStages {
    /// Its mesh with materials.
    pub meshed: Stored<Meshed>,
    /// Its finite elements, with load vectors.
    pub model: Stored<Model>,
    /// Its modes, with their shapes at all nodes.
    pub modes: Stored<WholeModes>,
    /// The body in modal coordinates.
    pub body: Stored<Body>,
    /// Loss factor of all modes \[-\].
    pub loss_factor: f64,
    /// Highest frequency at which the result includes its motion \[Hz\].
    pub top_hz: f64,
}

impl BodyStages {
    /// Adds the stages of a body of a design; if it is `driven`, including the places where the forces of the shot act.
    ///
    /// # Errors
    /// [`Error::NoSuchBody`] for the worktable of a design without one; errors in materials and mesh file.
    pub fn add(graph: &Graph, design: &Design, kind: BodyKind, driven: bool) -> Result<Self, Error> {
        let BodyInputs {
            geometry,
            places,
            below_hz,
            residual_limit,
            loss_factor,
            top_hz,
        } = inputs::bodies::body(design, kind, driven)?;
        let mesh = graph.add(geometry.meshing());
        let order = graph.add(geometry.elimination(mesh.clone()));
        let meshed = graph.add(geometry.attachment(mesh));
        let model = graph.add(Discretisation {
            kind,
            meshed: meshed.clone(),
            places,
        });
        let modes = graph.add(Modes {
            kind,
            model: model.clone(),
            order,
            below_hz,
            residual_limit,
        });
        let body = graph.add(ModalModel {
            kind,
            model: model.clone(),
            modes: modes.clone(),
            top_hz,
            below_hz,
        });
        Ok(Self {
            meshed,
            model,
            modes,
            body,
            loss_factor,
            top_hz,
        })
    }

    /// Displacements of the body's modes at a design's sensors on it; none without sensors.
    pub(super) fn sensors(
        &self,
        graph: &Graph,
        design: &Design,
        carrier: Carrier,
    ) -> Result<Option<Stored<BodySensors>>, Error> {
        let points = inputs::sensors::points(design, carrier)?;
        let stage = |points| SensorModes {
            points,
            body: self.body.clone(),
            modes: self.modes.clone(),
        };
        Ok((!points.is_empty()).then(|| graph.add(stage(points))))
    }
}

/// Bodies of a design that are solved in a run: a tool without a workpiece has no support either.
pub fn solved_bodies(design: &Design) -> Vec<BodyKind> {
    let mut kinds = Vec::new();
    if inputs::assembly::has_workpiece(design) {
        kinds.push(BodyKind::Workpiece);
        kinds.extend(supports::of(design).bodies());
    }
    kinds.extend((design.body.model == BodyModel::Elastic).then_some(BodyKind::Tool));
    kinds
}

/// The bodies of a design that are solved in a run.
pub(crate) struct Bodies {
    /// Workpiece, and worktable if there is one; empty for a tool without a workpiece.
    pub(crate) structure: Vec<BodyStages>,
    /// The tool's body, unless it is rigid.
    pub(crate) tool: Option<BodyStages>,
    /// Preflight check of each body, available before any body is solved.
    pub(crate) usable: Vec<Stored<Preflight>>,
    /// Bodies whose surfaces the design has recorded.
    pub(crate) recorded: Vec<RecordedBody>,
}

/// A body from a file whose surfaces a design has recorded.
pub(crate) struct RecordedBody {
    kind: BodyKind,
    meshed: Stored<Meshed>,
    design: Design,
}

impl RecordedBody {
    /// Compares the surfaces of the mesh with the records.
    ///
    /// # Errors
    /// The errors of the mesh, and those of surfaces that have changed.
    pub(crate) fn check(&self) -> Result<(), Error> {
        let meshed = self.meshed.get()?;
        let changed = recorded_surfaces::changed(&self.design, self.kind, &meshed.imported.mesh)?;
        Error::of_body(self.kind.name(), changed)
    }
}

impl Bodies {
    /// Adds the bodies of a design. The tool and its support are independent of each other.
    ///
    /// # Errors
    /// Same as [`BodyStages::add`].
    pub(crate) fn add(graph: &Graph, design: &Design) -> Result<Self, Error> {
        let add = |kind| Ok((kind, BodyStages::add(graph, design, kind, true)?));
        let solved: Vec<(BodyKind, BodyStages)> = solved_bodies(design)
            .into_iter()
            .map(add)
            .collect::<Result<_, Error>>()?;
        let mut usable = Vec::new();
        for (kind, _) in &solved {
            usable.extend(requirements(graph, design, *kind, &solved)?);
        }
        let of_file = |(kind, _): &&(BodyKind, BodyStages)| {
            let records = design.recorded_surfaces.values();
            records
                .map(|own| own.body)
                .any(|body| body == SurfaceOf::from(*kind) && design.is_from_file(body))
        };
        let recorded = solved.iter().filter(of_file).map(|(kind, stages)| RecordedBody {
            kind: *kind,
            meshed: stages.meshed.clone(),
            design: design.clone(),
        });
        let recorded = recorded.collect();
        let (tools, structure): (Vec<_>, Vec<_>) = solved.into_iter().partition(|(kind, _)| *kind == BodyKind::Tool);
        Ok(Self {
            structure: structure.into_iter().map(|(_, stages)| stages).collect(),
            tool: tools.into_iter().next().map(|(_, stages)| stages),
            usable,
            recorded,
        })
    }

    /// Workpiece and worktable in modal coordinates.
    pub(crate) fn structure_bodies(&self) -> Vec<Stored<Body>> {
        self.structure.iter().map(|stages| stages.body.clone()).collect()
    }

    /// All bodies in modal coordinates: the structure, then the tool.
    pub(crate) fn modal(&self) -> impl Iterator<Item = &Stored<Body>> {
        self.structure.iter().chain(&self.tool).map(|stages| &stages.body)
    }
}

/// Adds the preflight check of a body to a graph; `stages` are those of all its bodies.
fn requirements(
    graph: &Graph,
    design: &Design,
    kind: BodyKind,
    stages: &[(BodyKind, BodyStages)],
) -> Result<Option<Stored<Preflight>>, Error> {
    let Some((_, own)) = stages.iter().find(|(other, _)| *other == kind) else {
        return Ok(None);
    };
    let (carrier, radiating) = match kind {
        BodyKind::Tool => {
            let cap = inputs::radiation::cap(design);
            let places = inputs::radiation::tool_places(design);
            let radiating = inputs::radiation::tool(design)?.map(|elements| Radiating::Tool(elements, cap, places));
            (Carrier::Tool, radiating)
        }
        BodyKind::Workpiece | BodyKind::Worktable => {
            let of = |wanted: BodyKind| stages.iter().find(|(kind, _)| *kind == wanted);
            let structure = [BodyKind::Workpiece, BodyKind::Worktable].into_iter().filter_map(of);
            let meshed = structure.map(|(_, stages)| stages.meshed.clone()).collect();
            let places = inputs::radiation::workpiece_places(design);
            let radiating = Radiating::Workpiece(inputs::radiation::workpiece(design)?, meshed, places);
            let carrier = match kind {
                BodyKind::Worktable => Carrier::Worktable,
                _ => Carrier::Workpiece,
            };
            (carrier, Some(radiating))
        }
    };
    Ok(Some(graph.add(Requirements {
        kind,
        meshed: own.meshed.clone(),
        model: OnDemand(own.model.clone()),
        sensors: inputs::sensors::points(design, carrier)?,
        mass: inputs::bodies::mass(design, kind),
        radiating,
    })))
}

/// A meshed body, and whether it can be used in a run.
pub struct CheckedBody {
    /// The mesh with materials.
    pub meshed: Arc<Meshed>,
    /// Why it cannot be used in a run; empty for a body that is not solved in any run of the design.
    pub problems: Vec<Error>,
}

/// Meshes bodies of a design and performs the checks that precede a run.
pub fn check_bodies(design: &Design, kinds: &[BodyKind]) -> Vec<Result<CheckedBody, Error>> {
    let (graph, solved) = (Graph::default(), solved_bodies(design));
    let locate = |error| inputs::located(design, error);
    let others = solved.iter().filter(|kind| !kinds.contains(kind));
    let all = kinds.iter().chain(others);
    let added = all.map(|&kind| (kind, BodyStages::add(&graph, design, kind, solved.contains(&kind))));
    // All meshes are made before any check, because a stage that reads a failed mesh no longer has the reason.
    let meshed = added.map(|(kind, stages)| {
        let meshed = stages.and_then(|stages| Ok((stages.meshed.get()?, stages)));
        (kind, meshed.map_err(locate))
    });
    let mut meshed: Vec<_> = meshed.collect();
    let stages = meshed
        .iter()
        .filter_map(|(kind, meshed)| Some((*kind, meshed.as_ref().ok()?.1.clone())));
    let stages: Vec<_> = stages.filter(|(kind, _)| solved.contains(kind)).collect();
    let checked = meshed.drain(..kinds.len()).map(|(kind, meshed)| {
        let (meshed, _) = meshed?;
        let usable = requirements(&graph, design, kind, &stages)?;
        let problem = usable.as_ref().and_then(|usable| usable.get().err());
        let mut problems = problem.map_or_else(Vec::new, |error| locate(error).parts());
        if usable.is_some() {
            problems.extend(recorded_surfaces::changed(design, kind, &meshed.imported.mesh)?);
        }
        Ok(CheckedBody { meshed, problems })
    });
    checked.collect()
}
