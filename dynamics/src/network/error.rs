//! Errors in compiling and running a network.

use thiserror::Error;

/// Why a network cannot be run.
#[derive(Debug, Clone, PartialEq, Error)]
#[non_exhaustive]
pub enum RunError {
    /// A passage is not supported by any kernel.
    #[error("passage \"{name}\" {reason}; divide it by a volume")]
    Passage {
        /// Name of the passage.
        name: String,
        /// Description of the unsupported feature.
        reason: &'static str,
    },
    /// A number of the run is out of range.
    #[error("{name} = {value} must be {rule}")]
    Value {
        /// Name of the number.
        name: &'static str,
        /// The value found.
        value: f64,
        /// The requirement.
        rule: &'static str,
    },
    /// An expression refers to a missing block or is nested too deeply.
    #[error("the expression of {owner} {reason}")]
    Expression {
        /// The event, sensor or load that contains it.
        owner: String,
        /// What is wrong.
        reason: &'static str,
    },
    /// A spring is compressed beyond the range of its law.
    #[error("spring \"{spring}\": {} mm {place}, its law holds to {} mm; shorten the travel or the preload",
        1e3 * compression, 1e3 * limit)]
    SpringLimit {
        /// Name of the spring.
        spring: String,
        /// Compression \[m\].
        compression: f64,
        /// Largest compression of the law \[m\].
        limit: f64,
        /// Where or when.
        place: String,
    },
    /// Nothing presses a contact at rest.
    #[error(
        "nothing presses \"{contact}\" at rest ({force:.1} N): \"{body}\" is not seated; raise the forces that press \
         it, or let it start at a travel"
    )]
    NotSeated {
        /// Name of the contact or spring.
        contact: String,
        /// Body that should rest on it.
        body: String,
        /// Force on it \[N\].
        force: f64,
    },
    /// No equilibrium of the bodies at rest was found.
    #[error(
        "the bodies that rest at the start find no equilibrium: {unbalanced} N remain on \"{body}\"; give it a \
         contact or a spring that carries it, or a travel"
    )]
    NoEquilibrium {
        /// Body with the largest force.
        body: String,
        /// Force that remains \[N\].
        unbalanced: f64,
    },
    /// A gas volume shrank to nothing.
    #[error(
        "volume \"{volume}\" shrinks to {:.3} cm3 with {body} at {time} s (mass of its gas {mass:.2e} kg); raise dead \
         or move the stop",
        1e6 * size
    )]
    Collapse {
        /// Name of the volume.
        volume: String,
        /// The body that moves into it and its travel, in words.
        body: String,
        /// Its size \[m3\].
        size: f64,
        /// Mass of its gas \[kg\].
        mass: f64,
        /// Time \[s\].
        time: f64,
    },
    /// A trigger and a gate switch each other endlessly.
    #[error("\"{trigger}\" and \"{gate}\" switch each other {count} times at {} ms; {remedy}", 1e3 * time)]
    Switching {
        /// Name of the trigger.
        trigger: String,
        /// Name of the passage, motor or latch.
        gate: String,
        /// What separates the two.
        remedy: &'static str,
        /// Changes counted.
        count: usize,
        /// Time \[s\].
        time: f64,
    },
    /// A block opens and closes endlessly.
    #[error(
        "chatter: \"{block}\" changed {count} times within {window} s at {time} s; check its stiffness and damping and \
         the mass behind it"
    )]
    Chatter {
        /// Name of the block.
        block: String,
        /// Changes counted.
        count: usize,
        /// Duration of the counting window \[s\].
        window: f64,
        /// Time \[s\].
        time: f64,
    },
    /// A fitted law of resistance is chosen but not given.
    #[error("the law \"fitted\" of fastener \"{fastener}\" needs a fitted law; name its file, or choose another law")]
    NoFit {
        /// Name of the fastener.
        fastener: String,
    },
    /// A table of resistance ends before the length of the fastener.
    #[error(
        "the table of fastener \"{fastener}\" ends at {} mm, its length is {} mm; add points up to its length",
        1e3 * last,
        1e3 * length
    )]
    TableTooShort {
        /// Name of the fastener.
        fastener: String,
        /// Last depth of the table \[m\].
        last: f64,
        /// Length of the fastener \[m\].
        length: f64,
    },
    /// The impact speed exceeds those of the data of a fitted law.
    #[error(
        "the driver strikes \"{fastener}\" at {speed} m/s, and its fitted law holds for {lowest} .. {highest} m/s; add \
         drives at this speed and mass, or fit with --extrapolate to allow it"
    )]
    BeyondFit {
        /// Name of the fastener.
        fastener: String,
        /// Impact speed \[m/s\].
        speed: f64,
        /// Lowest \[m/s\].
        lowest: f64,
        /// Highest \[m/s\].
        highest: f64,
    },
    /// A body cannot be replaced by an external structure.
    #[error("the body \"{body}\" {reason}; change it, or set support.coupling = \"one-way\"")]
    Workpiece {
        /// Name of the body.
        body: String,
        /// What prevents it.
        reason: &'static str,
    },
    /// The forces of the assembly and of an external workpiece do not agree.
    #[error(
        "at {time} s the forces of tool and workpiece differ by {mismatch} N, more than {limit} N, in every trial; set \
         a smaller analysis.time_step, or couple one way"
    )]
    Coupling {
        /// Time \[s\].
        time: f64,
        /// Difference of the forces \[N\].
        mismatch: f64,
        /// Largest difference allowed \[N\].
        limit: f64,
    },
    /// The integration could not continue.
    #[error(
        "the integration stopped at {time} s: {cause}; a tolerance ten times smaller or larger often passes the place; \
         otherwise check the ranges of the assembly"
    )]
    Integration {
        /// Time \[s\].
        time: f64,
        /// The solver's report.
        cause: String,
    },
}

impl RunError {
    /// Name of the block at fault, if it is a single block. Of two that switch each other, it is the one that can be
    /// delayed.
    pub fn block(&self) -> Option<&str> {
        match self {
            Self::Passage { name, .. } => Some(name),
            Self::SpringLimit { spring, .. } => Some(spring),
            Self::NotSeated { contact, .. } => Some(contact),
            Self::NoEquilibrium { body, .. } | Self::Workpiece { body, .. } => Some(body),
            Self::Collapse { volume, .. } => Some(volume),
            Self::Switching { gate, .. } => Some(gate),
            Self::Chatter { block, .. } => Some(block),
            Self::NoFit { fastener } | Self::TableTooShort { fastener, .. } | Self::BeyondFit { fastener, .. } => {
                Some(fastener)
            }
            Self::Value { .. } | Self::Expression { .. } | Self::Coupling { .. } | Self::Integration { .. } => None,
        }
    }
}
