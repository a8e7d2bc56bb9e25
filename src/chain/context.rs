//! Context in which the stages of a design's shot are added.

use nailnoise_acoustics::Air;

use super::reference::SharedShapes;
use crate::design::Design;
use crate::graph::Graph;

/// A design whose stages are being added to a graph.
#[derive(Clone, Copy)]
pub(crate) struct Context<'a> {
    /// The graph.
    pub(crate) graph: &'a Graph,
    /// The design.
    pub(crate) design: &'a Design,
    /// The ambient air.
    pub(crate) air: Air,
    /// Shapes shared with other designs.
    pub(crate) shared: SharedShapes,
}
