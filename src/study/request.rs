//! The request for a study: the number of draws, and which part of them to compute.

/// The request for a study.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Request {
    /// Number of draws.
    pub draws: usize,
    /// Seed.
    pub seed: u64,
    /// Number of shots on each drawn structure; with `None`, the structures of the design are fixed.
    pub shots_a_structure: Option<usize>,
    /// The draws that are computed.
    pub part: Subset,
    /// Whether the draws include the sensors on the workpiece.
    pub workpiece_sensors: bool,
}

impl Request {
    /// All of this number of draws, with the structures of the design and without its sensors.
    pub fn new(draws: usize, seed: u64) -> Self {
        Self {
            draws,
            seed,
            shots_a_structure: None,
            part: Subset::All,
            workpiece_sensors: false,
        }
    }
}

/// A part of the draws of a study.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Subset {
    /// All draws.
    All,
    /// Every `of`-th structure if structures are drawn, otherwise every `of`-th draw, starting with the `number`-th,
    /// from 1.
    Task {
        /// Its number, 1 .. `of`.
        number: u32,
        /// Number of tasks.
        of: u32,
    },
    /// The same with the outcomes of candidates that are already stored; none is computed in advance for other tasks.
    Screened {
        /// Its number, 1 .. `of`.
        number: u32,
        /// Number of tasks.
        of: u32,
    },
    /// All draws whose levels are stored.
    Kept,
}

impl Subset {
    /// Whether a structure belongs to it, or a draw if structures are fixed.
    pub(super) fn holds(self, place: usize) -> bool {
        match self {
            Self::Task { number, of } | Self::Screened { number, of } => place % of as usize == (number - 1) as usize,
            Self::All | Self::Kept => true,
        }
    }
}
