//! The machine as the built-in assembly `impact_rig`.

use std::collections::BTreeMap;
use std::sync::LazyLock;

use nailnoise_penetration::ResistanceLaw;
use nailnoise_penetration::fit::FittedLaw;
use nailnoise_quantities::Group;
use nailnoise_quantities::dimension::{NUMBER, VELOCITY};

use super::{Machine, MachineError};
use crate::network::assembly::FastenerLaw;
use crate::network::{self, Assembly, AssemblyError, AssemblyText, KeyValue, LogEntry, Numerics, Record, RunError};

/// Tolerance of the integration, with which the energy of launch and drive closes to 1e-9.
const TOLERANCE: f64 = 1e-10;
/// Longest drive \[s\].
const LONGEST: f64 = 0.5;
/// Channels of a drive.
const CHANNELS: [&str; 4] = ["nail.tip", "projectile.velocity", "nail.force", "cell"];

/// One shot into one specimen.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Shot {
    /// v0, speed of the projectile at the nail \[m/s\].
    pub speed: f64,
    /// b, deviation of the specimen's s = sqrt(F_r/(H_M NL)) from the law.
    pub deviation: f64,
}

/// A machine with its values, ready for a run.
pub(super) struct Rig(Assembly);

impl Rig {
    /// The rig for a launch by gas, which ends at the nail. The law of the wood has no effect on it.
    pub(super) fn launching(machine: &Machine) -> Result<Self, MachineError> {
        let law = KeyValue::Word("constant".to_owned());
        Self::new(machine, |_| true, [("wood.penetration_law", law)], "strike")
    }

    /// The rig for a shot that begins at the nail and ends when the projectile leaves it.
    pub(super) fn driving(machine: &Machine, fit: Option<&FittedLaw>, shot: Shot) -> Result<Self, MachineError> {
        if machine.wood.penetration_law == ResistanceLaw::Fitted && fit.is_none() {
            return Err(MachineError::NoFit);
        }
        let quantity = |si, dimension| KeyValue::Quantity { si, dimension };
        let of_shot = [
            ("launch.speed", quantity(shot.speed, VELOCITY)),
            ("specimen.deviation", quantity(shot.deviation, NUMBER)),
        ];
        let mut rig = Self::new(machine, |key| !key.starts_with("launch."), of_shot, "left")?;
        rig.0.set_resistance(None, fit);
        rig.0.end = LONGEST;
        Ok(rig)
    }

    /// The assembly with the keys of a machine that are `used`, and those that replace them; its record ends at an
    /// event.
    fn new<const N: usize>(
        machine: &Machine,
        used: impl Fn(&str) -> bool,
        replaced: [(&str, KeyValue); N],
        last: &str,
    ) -> Result<Self, MachineError> {
        static TEXT: LazyLock<Option<Result<AssemblyText, AssemblyError>>> =
            LazyLock::new(|| AssemblyText::built_in("impact_rig"));
        let failed = |cause: String| MachineError::Run { cause };
        let text = TEXT
            .as_ref()
            .ok_or_else(|| failed("no assembly impact_rig".to_owned()))?;
        let text = text.as_ref().map_err(|error| failed(error.to_string()))?;
        let mut keys = BTreeMap::new();
        machine.visit("", &mut |path, spec, value| {
            if used(path) {
                keys.insert(path.to_owned(), KeyValue::of(spec, &value));
            }
        });
        keys.extend(replaced.map(|(key, value)| (key.to_owned(), value)));
        let resolved = text.resolve(&keys).map_err(|error| failed(error.to_string()))?;
        let mut assembly = resolved.assembly;
        let event = assembly.events.iter().position(|event| event.name == last);
        if let (Some(finish), Some(event)) = (&mut assembly.finish, event) {
            (finish.event, finish.tail) = (event, 0.0);
        }
        Ok(Self(assembly))
    }

    /// Runs the rig, with samples at intervals of `interval` \[s\] if that is finite.
    pub(super) fn run(&self, interval: f64) -> Result<Record, MachineError> {
        let numerics = Numerics {
            relative_tolerance: TOLERANCE,
            sample_interval: interval.is_finite().then_some(interval),
            channels: Some(&CHANNELS),
            ..Numerics::default()
        };
        network::simulate(&self.0, &numerics).map_err(|error| match error {
            RunError::BeyondFit {
                speed, lowest, highest, ..
            } => MachineError::BeyondFit { speed, lowest, highest },
            other => MachineError::Run {
                cause: other.to_string(),
            },
        })
    }

    /// Force of the wood on a nail that stops at a depth of its tip \[m\] after an impact at `speed` \[m/s\] \[N\].
    pub(super) fn stop_force(&self, depth: f64, speed: f64) -> f64 {
        let envelope = self.0.fasteners.first().and_then(|nail| match &nail.law {
            FastenerLaw::Wood(wood) => Some(wood.envelope(nail)),
            _ => None,
        });
        envelope.map_or(0.0, |envelope| envelope.at_rest(depth, speed))
    }
}

/// A logged change with its state.
pub(super) struct Logged<'r> {
    record: &'r Record,
    entry: &'r LogEntry,
}

impl<'r> Logged<'r> {
    /// The last change of a block to a word.
    pub(super) fn last(record: &'r Record, block: &str, words: &[&str]) -> Option<Self> {
        let mut all = record.log.iter().rev();
        let entry = all.find(|entry| entry.block == block && words.contains(&entry.word))?;
        Some(Self { record, entry })
    }

    pub(super) fn is(&self, word: &str) -> bool {
        self.entry.word == word
    }

    pub(super) fn time(&self) -> f64 {
        self.entry.time
    }

    /// A quantity of the state, `nail.tip`; 0 for one that the rig does not have.
    pub(super) fn value(&self, name: &str) -> f64 {
        let place = self.record.state_columns.iter().position(|column| column.name == name);
        place
            .and_then(|place| self.entry.state.get(place))
            .copied()
            .unwrap_or(0.0)
    }
}
