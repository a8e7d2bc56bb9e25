//! The built-in assembly with the values of a design, and the errors of its run in terms of the design.

use std::sync::LazyLock;

use nailnoise_quantities::dimension::{LENGTH, TIME};

use super::checks;
use crate::network::{Assembly, AssemblyError, AssemblyText, Fault, KeyValue, Numerics, Record, RunError};
use crate::{CycleError, Geometry, Parameters, Settings};

/// Blocks that switch, by the names of the assembly and in words.
const BLOCKS: [(&str, &str); 11] = [
    ("bumper", "the bumper"),
    ("stopper", "the stopper"),
    ("cap", "the head valve's cap"),
    ("seat", "the head valve's seat"),
    ("nose", "the nose"),
    ("support", "the support"),
    ("guard", "the guard spring"),
    ("intake", "the intake"),
    ("exhaust", "the exhaust"),
    ("check", "the check-ring holes"),
    ("nail", "the nail in the wood"),
];

/// Gas volumes by the names of the assembly and in words.
const VOLUMES: [(&str, &str); 5] = [
    ("above_piston", "above-piston"),
    ("below_piston", "below-piston"),
    ("return_volume", "return"),
    ("above_valve", "above-valve"),
    ("supply", "supply-side"),
];

/// Channels of the record, in the order of the columns of its files. Later versions append to this list.
const CHANNELS: [&str; 59] = [
    "piston.position",
    "piston.velocity",
    "piston.acceleration",
    "head_valve.position",
    "head_valve.velocity",
    "head_valve.acceleration",
    "tool.position",
    "tool.velocity",
    "tool.acceleration",
    "workpiece.position",
    "workpiece.velocity",
    "workpiece.acceleration",
    "piston.travel",
    "valve_lift",
    "nail.tip",
    "nail.deepest",
    "piston.moving_mass",
    "above_piston.pressure",
    "above_piston.temperature",
    "above_piston.mass",
    "below_piston.pressure",
    "below_piston.temperature",
    "below_piston.mass",
    "return_volume.pressure",
    "return_volume.temperature",
    "return_volume.mass",
    "above_valve.pressure",
    "above_valve.temperature",
    "above_valve.mass",
    "supply.pressure",
    "supply.temperature",
    "supply.mass",
    "piston_gas_force",
    "valve_gas_force",
    "bumper.force",
    "stopper.force",
    "cap.force",
    "seat.force",
    "spring.force",
    "piston_friction.force",
    "valve_friction.force",
    "nail.force",
    "nose.force",
    "guard.force",
    "support.force",
    "hand.force",
    "exhaust.mass_flow",
    "exhaust_plenum_pressure",
    "exhaust_back_pressure",
    "exhaust_stagnation_temperature",
    "intake.mass_flow",
    "vent.mass_flow",
    "vent_pressure",
    "vent_temperature",
    "nail.guide_force",
    "thrust.force",
    "piston.speed",
    "head_valve.travel",
    "head_valve.speed",
];

/// Channels and columns of blocks that a design may switch off. Their histories are then zero, so that all designs by
/// keys have the same columns.
const SWITCHED: [[&str; 2]; 2] = [["nail.guide_force", "magazine_force"], ["thrust.force", "thrust_force"]];

/// Channels that the figures of a shot need: initial states for its log, and the channels that its summary reads.
const CHANNELS_OF_FIGURES: [&str; 17] = [
    "piston.position",
    "piston.velocity",
    "piston.speed",
    "head_valve.position",
    "head_valve.velocity",
    "head_valve.speed",
    "tool.position",
    "tool.velocity",
    "workpiece.position",
    "workpiece.velocity",
    "above_piston.pressure",
    "below_piston.pressure",
    "return_volume.pressure",
    "above_valve.pressure",
    "supply.pressure",
    "nail.tip",
    "nail.deepest",
];

/// Hole pitch of a cycle; used only by sources of noise \[m\].
const UNUSED_PITCH: f64 = 1.0;

/// The nailer as an assembly, ready for a run.
pub(super) struct Nailer<'p> {
    pub(super) parameters: &'p Parameters,
    pub(super) assembly: Assembly,
    pub(super) numerics: Numerics,
}

impl<'p> Nailer<'p> {
    /// The assembly of a design.
    ///
    /// # Errors
    /// Those of [`simulate`](super::simulate) that are found before the run.
    pub(super) fn new(parameters: &'p Parameters, settings: &Settings) -> Result<Self, CycleError> {
        static TEXT: LazyLock<Result<AssemblyText, AssemblyError>> = LazyLock::new(|| AssemblyText::open_design(&[]));
        checks::check(parameters)?;
        settings.check()?;
        let mut keys = parameters.keys();
        for (path, si, dimension) in [
            ("analysis.cycle_end", settings.end, TIME),
            ("analysis.cycle_tail", settings.tail, TIME),
            ("exhaust.pitch", UNUSED_PITCH, LENGTH),
        ] {
            keys.insert(path.to_owned(), KeyValue::Quantity { si, dimension });
        }
        let refused = |error: &AssemblyError| match error.fault {
            Fault::SpringLimit { limit, .. } => spring_range(parameters, limit),
            _ => CycleError::Assembly {
                cause: error.to_string(),
            },
        };
        let text = TEXT.as_ref().map_err(refused)?;
        let mut assembly = text.resolve(&keys).map_err(|error| refused(&error))?.assembly;
        assembly.set_resistance(
            parameters.penetration_table.as_ref(),
            parameters.penetration_fit.as_ref(),
        );
        Ok(Self {
            parameters,
            assembly,
            numerics: Numerics {
                method: settings.method,
                relative_tolerance: settings.relative_tolerance,
                sample_interval: Some(settings.sample_interval),
                channels: Some(&CHANNELS),
            },
        })
    }

    /// The same nailer without forces and pressures on surfaces in its record.
    pub(super) fn without_surfaces(mut self) -> Self {
        self.assembly.loads.clear();
        self.assembly.pressures.clear();
        self
    }

    /// The same nailer with only the histories in its record that its figures need.
    pub(super) fn for_figures(self) -> Self {
        let mut nailer = self.without_surfaces();
        nailer.assembly.columns.clear();
        nailer.assembly.openings.retain(|opening| opening.name == "exhaust");
        nailer.numerics.channels = Some(&CHANNELS_OF_FIGURES);
        nailer
    }

    /// The record with the channels in their order, and zero for blocks that the design switches off.
    pub(super) fn arranged(&self, mut record: Record) -> Record {
        if self.numerics.channels.is_some_and(|own| own == CHANNELS) {
            for [name, column] in SWITCHED {
                record.add_zero(name, column, "N");
            }
            record.arrange(&CHANNELS);
        }
        record
    }

    /// Index of a body.
    pub(super) fn body(&self, name: &str) -> Result<usize, CycleError> {
        let found = self.assembly.bodies.iter().position(|body| body.name == name);
        found.ok_or_else(|| CycleError::Assembly {
            cause: format!("no body `{name}`"),
        })
    }

    /// The error of a run in terms of the keys.
    pub(super) fn error(&self, error: RunError) -> CycleError {
        let p = self.parameters;
        match error {
            RunError::SpringLimit { limit, .. } => spring_range(p, limit),
            RunError::NotSeated { contact, force, .. } if contact == "seat" => CycleError::ValveNotClosed { force },
            RunError::NotSeated { .. } | RunError::NoEquilibrium { .. } => {
                let (guard, nose) = (p.contacts.guard_stiffness, p.contacts.nose_stiffness);
                let mass = p.tool.mass + p.piston.mass + p.head_valve.mass;
                CycleError::NotSeated {
                    guard: guard * nose / (guard + nose) * p.contacts.guard_travel,
                    press: p.hand.force + mass * p.ambient.gravity,
                }
            }
            RunError::Collapse { volume, size, time, .. } if volume == "below_piston" => {
                let area = Geometry::new(p).ring_area;
                CycleError::DryFire {
                    time,
                    compression: (p.chambers.below_piston - size) / area,
                    available: p.chambers.below_piston / area,
                }
            }
            RunError::Collapse {
                volume,
                size,
                mass,
                time,
                ..
            } => CycleError::Collapse {
                volume: in_words(&VOLUMES, &volume),
                time,
                size,
                mass,
            },
            RunError::Chatter {
                block,
                count,
                window,
                time,
            } => CycleError::Chatter {
                contact: in_words(&BLOCKS, &block),
                count,
                window,
                time,
            },
            RunError::Coupling { time, mismatch, limit } => CycleError::Coupling { time, mismatch, limit },
            RunError::BeyondFit {
                speed, lowest, highest, ..
            } => CycleError::BeyondFit { speed, lowest, highest },
            RunError::Integration { time, cause } => CycleError::Integration { time, cause },
            other => CycleError::Assembly {
                cause: other.to_string(),
            },
        }
    }
}

/// The error of a closing spring that its stops compress beyond its law.
fn spring_range(p: &Parameters, limit: f64) -> CycleError {
    CycleError::SpringRange {
        lift: p.head_valve.lift,
        preload: p.head_valve.spring_preload,
        limit,
    }
}

/// A block in words.
fn in_words(names: &[(&str, &'static str)], block: &str) -> &'static str {
    let found = names.iter().find(|(name, _)| *name == block);
    found.map_or("another block of the assembly", |(_, words)| words)
}
