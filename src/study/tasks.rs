//! Parts of studies, draws of shots and sweeps that a scheduler may compute on any machine and in any order.
//!
//! Each part leaves stage outputs in a store. The work itself ([`draws`](super::draws), [`shots`](super::shots()),
//! [`sweep`](super::sweep())) then finds them there. Its result does not depend on who computed the parts, and missing
//! parts are computed.

use super::jobs::levels_of_shot;
use super::sampling::{Frame, Sampler};
use super::screening::{BLOCK, block_of, qualifies};
use super::shots::ShotSampler;
use super::variables::{Scope, common_variables, without_sensors};
use crate::chain::{Chain, Options};
use crate::design::{Design, Values};
use crate::error::Error;
use crate::graph::Graph;
use crate::stages::levels::Levels;
use crate::stages::outcomes::ShotOutcome;
use crate::wording::hexadecimal;

/// The candidates of a study, or of draws of shots, in blocks.
pub struct Candidates {
    design: Design,
    sampler: Sampler,
    active: Vec<bool>,
    /// Whether the outcome determines which of them count.
    conditional: bool,
}

impl Candidates {
    /// The tasks of a study, with drawn or fixed structures.
    ///
    /// # Errors
    /// The errors of the chain's inputs.
    pub fn of_study(design: &Design, seed: u64, structures: bool) -> Result<Self, Error> {
        let variables = common_variables(&[design])?;
        let design = without_sensors(design);
        let sampler = Sampler::new(&design, variables, seed);
        let scopes = sampler.variables().iter().map(|variable| variable.scope);
        let active = scopes.map(|scope| structures || scope != Scope::Structure).collect();
        Ok(Self {
            design,
            sampler,
            active,
            conditional: true,
        })
    }

    /// The tasks for draws of shots.
    ///
    /// # Errors
    /// The errors of the cycle's inputs.
    pub fn of_shots(design: &Design, seed: u64) -> Result<Self, Error> {
        let ShotSampler { design, sampler, .. } = ShotSampler::new(design, seed)?;
        Ok(Self {
            active: vec![true; sampler.variables().len()],
            design,
            sampler,
            conditional: false,
        })
    }

    /// Computes the shots of a block, and returns the number of accepted candidates.
    ///
    /// # Errors
    /// The errors of the graph.
    pub fn outcomes(&self, graph: &Graph, block: u64) -> Result<usize, Error> {
        let designs = std::slice::from_ref(&self.design);
        let bases = [Values::clone(&self.design)];
        let frame = Frame::new(&bases, &self.active, 0);
        let (_, outcomes) = block_of((designs, &self.sampler), frame, block * BLOCK..(block + 1) * BLOCK);
        let outcomes = graph.get(outcomes)?;
        let counts = |outcome: &&ShotOutcome| match outcome {
            ShotOutcome::Refused(_) => false,
            outcome => !self.conditional || qualifies(&self.design, outcome),
        };
        Ok(outcomes.iter().filter(counts).count())
    }
}

/// Number of candidates in a block.
pub const CANDIDATES: u64 = BLOCK;

/// Computes the levels of a design in the form that sweeps and studies use: without its sensors.
///
/// # Errors
/// The errors of the chain.
pub fn levels(graph: &Graph, design: &Design) -> Result<Levels, Error> {
    levels_of_shot(Chain::new(graph, &without_sensors(design), Options::default()))
}

/// Name of the modes and radiation matrices of a design; designs with the same name share them.
///
/// # Errors
/// The errors of the chain's inputs.
pub fn structures(design: &Design) -> Result<String, Error> {
    let graph = Graph::default();
    let chain = Chain::new(&graph, &without_sensors(design), Options::default())?;
    Ok(hexadecimal(chain.structures.as_flattened()))
}
