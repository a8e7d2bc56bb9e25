//! The bodies of a design in a graph of stages.

use std::ops::Deref;
use std::sync::Arc;

use nailnoise_fem::LoadVector;
use nalgebra::DMatrix;

use crate::design::Design;
use crate::design::inputs::bodies::{self, BodyInputs};
use crate::error::Error;
use crate::graph::Graph;
use crate::stages::bodies::{Body, BodyKind, Discretisation, ModalModel, Modes, SensorModes, WholeModes};
use crate::stages::radiation::MovingSurface;
use crate::stages::{Progress, Stored};
use crate::store::Store;

/// The bodies of a design.
pub struct Structure {
    /// The wood block.
    pub workpiece: GraphBody,
    /// The worktable, when the block stands on one.
    pub worktable: Option<GraphBody>,
}

impl Structure {
    /// The bodies there are.
    pub fn bodies(&self) -> impl Iterator<Item = &Body> {
        self.in_graph().map(|body| &**body)
    }

    /// The same with their whole modes.
    pub(super) fn in_graph(&self) -> impl Iterator<Item = &GraphBody> {
        std::iter::once(&self.workpiece).chain(&self.worktable)
    }
}

/// A body with the graph in which its whole modes are.
#[derive(Clone)]
pub struct GraphBody {
    graph: Graph,
    body: Arc<Body>,
    nodes: BodyNodes,
}

/// The stages of a body in a graph.
#[derive(Clone)]
pub(crate) struct BodyNodes {
    pub(crate) modes: Stored<WholeModes>,
    pub(crate) body: Stored<Body>,
}

impl BodyNodes {
    /// Adds the stages of a body.
    pub(crate) fn add(graph: &Graph, inputs: BodyInputs) -> Self {
        let kind = inputs.discretisation.geometry.kind;
        let model = graph.add::<Discretisation>(inputs.discretisation);
        let modes = graph.add(Modes {
            kind,
            model: model.clone(),
            below_hz: inputs.below_hz,
            residual_limit: inputs.residual_limit,
        });
        let body = graph.add(ModalModel {
            kind,
            model,
            modes: modes.clone(),
            loss_factor: inputs.loss_factor,
            top_hz: inputs.top_hz,
        });
        Self { modes, body }
    }
}

impl Deref for GraphBody {
    type Target = Body;

    fn deref(&self) -> &Body {
        &self.body
    }
}

impl GraphBody {
    fn new(
        design: &Design,
        (kind, driven): (BodyKind, bool),
        store: &Store,
        progress: &Progress,
    ) -> Result<Self, Error> {
        let graph = Graph::new(Arc::new(store.clone()), progress.observer());
        let nodes = BodyNodes::add(&graph, bodies::body(design, kind, driven)?);
        let body = nodes.body.get().map_err(|error| bodies::with_place(design, error))?;
        Ok(Self { graph, body, nodes })
    }

    /// The whole modes, proven to be those of the body.
    ///
    /// # Errors
    /// Those of the modal solution, where the store has lost them; [`Error::OtherModes`].
    pub fn modes(&self) -> Result<Arc<WholeModes>, Error> {
        let modes = self.nodes.modes.get()?;
        self.body.shapes(&modes)?;
        Ok(modes)
    }

    /// Displacement that load vectors read in each mode: modes x load vectors.
    ///
    /// # Errors
    /// As [`Self::modes`].
    pub(super) fn participation(&self, vectors: Vec<LoadVector>) -> Result<DMatrix<f64>, Error> {
        if vectors.is_empty() {
            return Ok(DMatrix::zeros(self.body.omega.len(), 0));
        }
        let stage = SensorModes {
            vectors,
            body: self.nodes.body.clone(),
            modes: self.nodes.modes.clone(),
        };
        Ok(self.graph.get(stage)?.shapes.clone())
    }
}

impl Body {
    /// Its surface and how that moves.
    pub(crate) fn moving_surface(&self) -> MovingSurface<'_> {
        MovingSurface {
            body: self.name,
            surface: &self.surface,
            modes: &self.skin,
        }
    }
}

/// The workpiece, free.
///
/// # Errors
/// Those of mesh, material and modal solution.
pub fn workpiece(design: &Design, store: &Store) -> Result<GraphBody, Error> {
    driven(design, BodyKind::Workpiece, store, &Progress::silent())
}

/// The tool's body, free, with what drives it: forces along the axis, then pressures on walls.
///
/// # Errors
/// Those of mesh, material and modal solution; [`Error::NoLoadSurface`].
pub fn tool_body(design: &Design, store: &Store) -> Result<GraphBody, Error> {
    driven(design, BodyKind::Tool, store, &Progress::silent())
}

/// A body with the places of the shot's forces.
pub(super) fn driven(design: &Design, kind: BodyKind, store: &Store, progress: &Progress) -> Result<GraphBody, Error> {
    GraphBody::new(design, (kind, true), store, progress)
}

/// The modes of any body alone, without what drives it.
///
/// # Errors
/// Those of mesh, material and modal solution.
pub fn modes_of(design: &Design, kind: BodyKind, store: &Store, progress: &Progress) -> Result<GraphBody, Error> {
    GraphBody::new(design, (kind, false), store, progress)
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]

    use super::*;

    /// Beginnings of keys whose values reach no mesh, no mode and no load vector.
    const BEYOND_BODIES: [&str; 4] = ["acoustics.", "ambient.", "exhaust.", "supply."];

    /// Keys of the stages of all bodies.
    fn keys(design: &Design) -> Vec<[u8; 32]> {
        let graph = Graph::new(Arc::new(Store::none()), Progress::silent().observer());
        let of_body = |kind| {
            *BodyNodes::add(&graph, bodies::body(design, kind, true).unwrap())
                .body
                .key()
        };
        BodyKind::ALL.map(of_body).to_vec()
    }

    #[test]
    fn values_beyond_the_bodies_leave_their_keys_and_the_density_of_the_wood_changes_that_of_the_workpiece() {
        let base = Design::load(concat!(env!("CARGO_MANIFEST_DIR"), "/designs/n80cb.toml")).unwrap();
        let mut other = base.clone();
        let mut changed = 0;
        for (key, kind, value) in base.keys() {
            if BEYOND_BODIES.iter().any(|beyond| key.starts_with(beyond)) {
                let value = crate::design::another(&value, kind).unwrap_or_else(|| panic!("{key} has one value"));
                other.set(&[(key.as_str(), value)]).unwrap();
                changed += 1;
            }
        }
        assert!(changed > 30, "{changed} keys changed");
        assert_eq!(keys(&base), keys(&other));
        let mut denser = base.clone();
        denser.wood.density *= 1.01;
        let [before, after] = [keys(&base), keys(&denser)];
        assert_ne!(before[0], after[0]);
        assert_eq!(before[1..], after[1..]);
    }
}
