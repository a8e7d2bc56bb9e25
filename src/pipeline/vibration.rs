//! The moving bodies of a shot, and what they tell once their motion is no longer needed.
//!
//! Modes, motion and spectra take hundreds of megabytes and most of a run's time. What the result needs of them is small
//! and a function of the design and of the cycle that drives them: it is kept, so that a design that changes only how the
//! exhaust sounds needs neither.

use std::time::Instant;

use nailnoise_acoustics::Air;
use nailnoise_acoustics::levels::{SourceSpectrum, Weighting};
use nailnoise_acoustics::radiation::ModalSpectra;
use nailnoise_dynamics::{CouplingWork, CycleRecord, Parameters};
use nailnoise_fem::transient::{Ending, ModalResponse};
use serde::{Deserialize, Serialize};

use super::intervals::Clock;
use super::microphones::{self, AtMicrophones};
use super::missing::{self, Missing};
use super::radiator::Radiator;
use super::sensors::{self, SensorRecord};
use super::sound::{Sound, Source};
use super::starts::starts;
use super::tool_radiator::tool_radiator;
use super::{
    Body, Driven, Observer, Options, Stiffness, Structure, Tell, Tool, Watched, bodies, cycle, exhaust, parameters,
    radiation, response, tool_body,
};
use crate::cache::{Cache, Key};
use crate::design::{BodyModel, Coupling, Design, SupportKind};
use crate::error::Error;
use crate::result::{Check, Starts, Timing};

/// The bodies of a shot in motion.
pub struct Vibration {
    /// Workpiece and support with their modes.
    pub structure: Structure,
    /// Their response to the shot.
    pub response: ModalResponse,
    /// Fourier transforms of the modal accelerations, one set a body.
    pub spectra: Vec<ModalSpectra>,
    /// The tool's body, unless it is rigid.
    pub tool: Option<Tool>,
}

impl Vibration {
    /// All elastic bodies: the workpiece, what it stands on, the tool.
    pub fn driven(&self) -> impl Iterator<Item = Driven<'_>> {
        let of_structure = |(index, (body, spectra))| Driven {
            body,
            response: &self.response,
            index,
            spectra,
        };
        self.structure
            .bodies()
            .zip(&self.spectra)
            .enumerate()
            .map(of_structure)
            .chain(self.tool.as_ref().map(Tool::driven))
    }
}

/// What the moving bodies tell.
#[derive(Clone, Serialize, Deserialize)]
pub(super) struct Told {
    /// Workpiece with support, and tool body.
    pub(super) sources: [Source; 2],
    /// When the last record ends \[s\].
    pub(super) end: f64,
    /// How the response ended, in words.
    pub(super) ending: String,
    /// Stiffness of an elastic tool body where the cycle's contacts act.
    pub(super) stiffness: Option<[Stiffness; 2]>,
    /// What is left out above top frequencies.
    pub(super) missing: Vec<Missing>,
    /// What microphones hear of the sources.
    pub(super) heard: [AtMicrophones; 2],
    /// Levels of other starts.
    pub(super) starts: Option<Starts>,
    /// Checks of modes and response, then those of the tool's body.
    pub(super) checks: [Vec<Check>; 2],
    /// Names, intervals and accelerations of the sensors.
    records: Vec<(String, f64, Vec<f64>)>,
}

impl Told {
    /// What the design's sensors record.
    pub(super) fn sensors(&self, design: &Design) -> Vec<SensorRecord> {
        let of_sensor = |(name, interval, acceleration): &(String, f64, Vec<f64>)| {
            Some(SensorRecord {
                name: name.clone(),
                body: design.sensors.iter().find(|(own, _)| *own == name)?.1.body,
                interval: *interval,
                acceleration: acceleration.clone(),
            })
        };
        self.records.iter().filter_map(of_sensor).collect()
    }
}

/// A two-way run beside the one-way run of the same design.
pub(super) struct TwoWay {
    pub(super) work: CouplingWork,
    pub(super) checks: Vec<Check>,
    /// The cycle with its own lumped workpiece, and its sources.
    pub(super) one_way: (CycleRecord, [SourceSpectrum; 3]),
}

/// Everything that moves, computed.
pub(super) struct Moved {
    pub(super) record: CycleRecord,
    pub(super) vibration: Vibration,
    pub(super) told: Told,
    pub(super) two_way: Option<TwoWay>,
}

/// What tells how microphones are read, not what they hear.
const OF_THE_ROOM: [&str; 2] = ["acoustics.room_absorption", "acoustics.background_level"];

/// All that what the bodies tell depends on when a cycle drives them one way: the cycle, and every value but those of the
/// exhaust, which reach the bodies through the cycle alone, and those of the room in which a measurement is made.
pub(super) fn key(design: &Design, options: Options, record: &CycleRecord) -> Key {
    Key::new()
        .with(&design.values_where(|key| !key.starts_with("exhaust.") && !OF_THE_ROOM.contains(&key)))
        .with(&options.workpiece_force_scale)
        .with(record)
}

/// What a stage of a run works with.
pub(super) struct Bench<'a> {
    pub(super) design: &'a Design,
    pub(super) options: Options,
    pub(super) parameters: Parameters,
    pub(super) air: Air,
    pub(super) cache: &'a Cache,
    /// When the run began.
    pub(super) begin: Instant,
}

impl<'a> Bench<'a> {
    /// With the cycle's parameters and the air of a design.
    ///
    /// # Errors
    /// Those of parameters and air.
    pub(super) fn new(design: &'a Design, options: Options, cache: &'a Cache) -> Result<Self, Error> {
        Ok(Self {
            design,
            options,
            parameters: parameters(design)?,
            air: Air::at(design.ambient.temperature, design.ambient.pressure)?,
            cache,
            begin: Instant::now(),
        })
    }
}

/// Sets the bodies in motion: by the cycle given, or together with one both ways.
///
/// # Errors
/// [`Error`] of the stage that could not be computed.
pub(super) fn moved(
    bench: &Bench<'_>,
    lumped: Option<CycleRecord>,
    timing: &mut Timing,
    observer: &mut dyn Observer,
) -> Result<Moved, Error> {
    let Bench {
        design,
        options,
        ref parameters,
        ref air,
        cache,
        ..
    } = *bench;
    let force_scale = options.workpiece_force_scale;
    // Neither workpiece with support nor the tool's body knows of the other.
    let watched = Watched::over(observer);
    let (of_structure, of_tool) = std::thread::scope(|scope| {
        let of_tool = scope.spawn(|| {
            let mut timing = Timing::default();
            let body = match design.body.model {
                BodyModel::Elastic => {
                    let modes = |tell: Tell<'_>| bodies::tool_body_telling(design, cache, tell);
                    Some(timing.time("tool modes", || watched.counting(("modes of the tool", "modes"), modes))?)
                }
                BodyModel::Rigid => None,
            };
            let side = match &lumped {
                Some(record) => ToolSide::Moved(Box::new(tool_in_motion(bench, body, record, &mut timing, &watched)?)),
                None => ToolSide::Still(Box::new(body)),
            };
            Ok::<_, Error>((side, timing))
        });
        let of_structure = structure_side(bench, lumped.as_ref(), timing, &watched);
        let of_tool = of_tool.join().unwrap_or_else(|panic| std::panic::resume_unwind(panic));
        (of_structure, of_tool)
    });
    let StructureSide {
        structure,
        radiator,
        damping,
        response,
        coupled,
    } = of_structure?;
    let (of_tool, of_tool_timing) = of_tool?;
    timing.0.extend(of_tool_timing.0);
    let added = damping.as_deref();
    let (record, coupling) = match (lumped, coupled) {
        (_, Some((record, work, checks))) => (record, Some((work, checks))),
        (Some(record), None) => (record, None),
        (None, None) => unreachable!("a cycle is given, or comes from a coupled run"),
    };
    let (tool, body) = match of_tool {
        ToolSide::Moved(moved) => *moved,
        ToolSide::Still(body) => tool_in_motion(bench, *body, &record, timing, &watched)?,
    };
    let shot = sensors::Shot {
        structure: &structure,
        response: &response,
        tool: tool.as_ref(),
        record: &record,
    };
    let sensors = timing.time("sensors", || sensors::sensors(design, shot))?;
    observer.stage("radiation");
    let spectra = timing.time("modal spectra", || {
        radiation::modal_spectra(design, &structure, &response)
    })?;
    let workpiece = timing.time("radiation", || {
        radiation::workpiece(design, &structure, &radiator, added, &spectra)
    })?;
    let two_way = match coupling {
        Some((work, checks)) => {
            observer.stage("the same one way, to compare");
            let one_way = timing.time("one way", || {
                let record = cycle(design)?;
                let force = (force_scale, 0);
                let response = response::response(design, &structure, added, parameters, &record, force)?;
                let spectra = radiation::modal_spectra(design, &structure, &response)?;
                let workpiece = radiation::workpiece_energy(&radiator, &spectra)?;
                let body = match &tool {
                    Some(_) => {
                        let body = tool_body(design, cache)?;
                        let bem = tool_radiator(design, &body, air, cache, &Watched::over(observer))?;
                        Tool::new(design, (body, bem), parameters, &record)?.sound(design, &record, air)?
                    }
                    None => radiation::rigid_tool(design, &record, air)?,
                };
                let (exhaust, _) = exhaust::exhaust(design, &record, air)?;
                Ok::<_, Error>((record, [workpiece, exhaust.spectrum, body.spectrum]))
            })?;
            Some(TwoWay { work, checks, one_way })
        }
        None => None,
    };
    let range = [design.analysis.range_low, design.analysis.range_high];
    let starts = if design.analysis.starts > 1 {
        observer.stage("other starts");
        let first = workpiece.spectrum.level(range, Weighting::A);
        timing.time("other starts", || {
            starts(design, &structure, &radiator, first, |start| {
                match design.support.coupling {
                    Coupling::OneWay => {
                        let force = (force_scale, start);
                        response::response(design, &structure, added, parameters, &record, force)
                    }
                    Coupling::TwoWay => Ok(response::coupled(design, &structure, added, parameters, start)?.response),
                }
            })
        })?
    } else {
        None
    };
    let mut missing = missing::above_top(design, &structure, &workpiece.spectrum);
    missing.extend(
        tool.as_ref()
            .and_then(|tool| missing::above_tool_top(design, tool, &body.spectrum)),
    );
    let tool_end = tool.as_ref().map_or(0.0, |tool| tool.response.duration());
    let end = response
        .duration()
        .max(tool_end)
        .max(record.sample_interval * record.len() as f64);
    let heard = timing.time("bodies at the microphones", || {
        let inputs = microphones::Inputs {
            radiator: &radiator,
            spectra: &spectra,
            record: &record,
            workpiece: &workpiece,
            body: &body,
            tool: tool.as_ref(),
            end,
        };
        microphones::of_bodies(design, air, &inputs)
    })?;
    let clock = Clock::new(&record.events, end);
    let sources = timing.time("intervals", || {
        [workpiece, body].map(|sound| Source::new(sound, &clock.times, range))
    });
    let mut checks: [Vec<Check>; 2] = Default::default();
    structure.bodies().for_each(|body| checks[0].extend(body.checks()));
    checks[0].extend(response::checks(&response));
    if let Some(tool) = &tool {
        checks[1].extend(tool.body.checks());
        checks[1].extend(tool.checks.iter().cloned());
    }
    let told = Told {
        sources,
        end,
        ending: ending(&response),
        stiffness: tool.as_ref().map(|tool| tool.stiffness.clone()),
        missing,
        heard,
        starts,
        checks,
        records: sensors
            .into_iter()
            .map(|sensor| (sensor.name, sensor.interval, sensor.acceleration))
            .collect(),
    };
    Ok(Moved {
        record,
        vibration: Vibration {
            structure,
            response,
            spectra,
            tool,
        },
        told,
        two_way,
    })
}

/// The tool's side of a run: at rest while its cycle is not known.
enum ToolSide {
    Still(Box<Option<Body>>),
    Moved(Box<(Option<Tool>, Sound)>),
}

/// What a cycle does to the tool's body, a rigid one without modes, and how it sounds.
fn tool_in_motion(
    bench: &Bench<'_>,
    body: Option<Body>,
    record: &CycleRecord,
    timing: &mut Timing,
    watched: &Watched<'_>,
) -> Result<(Option<Tool>, Sound), Error> {
    let Bench {
        design,
        ref parameters,
        ref air,
        cache,
        ..
    } = *bench;
    let tool = match body {
        Some(body) => {
            let bem = timing.time("radiation matrices of the tool", || {
                tool_radiator(design, &body, air, cache, watched)
            })?;
            Some(timing.time("tool response", || Tool::new(design, (body, bem), parameters, record))?)
        }
        None => None,
    };
    let sound = timing.time("body", || match &tool {
        Some(tool) => tool.sound(design, record, air),
        None => radiation::rigid_tool_twice(design, record, air),
    })?;
    Ok((tool, sound))
}

/// The side of workpiece and support.
struct StructureSide {
    structure: Structure,
    radiator: Radiator,
    /// Damping ratios that radiation adds.
    damping: Option<Vec<Vec<f64>>>,
    response: ModalResponse,
    /// The cycle of a two-way run, with work and checks of the coupling.
    coupled: Option<(CycleRecord, CouplingWork, Vec<Check>)>,
}

/// Workpiece and support, driven by a cycle or, without one, together with their own.
fn structure_side(
    bench: &Bench<'_>,
    lumped: Option<&CycleRecord>,
    timing: &mut Timing,
    watched: &Watched<'_>,
) -> Result<StructureSide, Error> {
    let Bench {
        design,
        options,
        ref parameters,
        ref air,
        cache,
        ..
    } = *bench;
    let structure = modes(design, cache, timing, watched)?;
    watched.stage("radiation matrices");
    let radiator = timing.time("radiation matrices", || {
        Radiator::new(design, &structure, air, cache, watched)
    })?;
    cache.take_notes().iter().for_each(|note| watched.note(note));
    let damping = design
        .acoustics
        .radiation_damping
        .then(|| timing.time("radiation damping", || radiator.damping(&structure)));
    let added = damping.as_deref();
    let (response, coupled) = match lumped {
        Some(record) => {
            watched.stage("response of workpiece and support");
            let force = (options.workpiece_force_scale, 0);
            let response = timing.time("response", || {
                response::response(design, &structure, added, parameters, record, force)
            })?;
            (response, None)
        }
        None => {
            watched.stage("nailing cycle with workpiece and support");
            let both = timing.time("cycle and response", || {
                response::coupled(design, &structure, added, parameters, 0)
            })?;
            (both.response, Some((both.record, both.work, both.checks)))
        }
    };
    Ok(StructureSide {
        structure,
        radiator,
        damping,
        response,
        coupled,
    })
}

/// Workpiece and support with their modes.
fn modes(design: &Design, cache: &Cache, timing: &mut Timing, watched: &Watched<'_>) -> Result<Structure, Error> {
    watched.stage("modes of the bodies");
    let block = |tell: Tell<'_>| bodies::workpiece_telling(design, cache, tell);
    let block = timing.time("workpiece modes", || {
        watched.counting(("modes of the workpiece", "modes"), block)
    })?;
    let table = |tell: Tell<'_>| bodies::table_telling(design, cache, tell);
    let worktable = match design.support.kind {
        SupportKind::Worktable => Some(timing.time("worktable modes", || {
            watched.counting(("modes of the worktable", "modes"), table)
        })?),
        SupportKind::Sandbox | SupportKind::Floor | SupportKind::Clamped | SupportKind::Springs => None,
    };
    Ok(Structure {
        workpiece: block,
        worktable,
        grid: bodies::contact_grid(design),
    })
}

fn ending(response: &ModalResponse) -> String {
    let end = response.duration();
    match response.ending {
        Ending::Decayed { level, .. } if level == f64::NEG_INFINITY => {
            format!("response ended at {end:.3} s, all of its energy gone")
        }
        Ending::Decayed { level, .. } => format!("response ended at {end:.3} s, its energy {level:.0} dB down"),
        Ending::Duration { level, .. } => format!("response cut at {end:.3} s, its energy {level:.0} dB down"),
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]

    use super::*;
    use crate::design::{Kind, Value};

    /// Another value of a key.
    fn moved(kind: Kind, value: Value) -> Option<Value> {
        Some(match (kind, value) {
            (_, Value::Number(0.0)) => Value::Number(1e-3),
            (_, Value::Number(number)) => Value::Number(number * (1.0 - 1e-6)),
            (_, Value::Count(count)) => Value::Count(count + 1),
            (_, Value::Switch(on)) => Value::Switch(!on),
            (Kind::Choice(words), Value::Choice(word)) => Value::Choice(words.iter().find(|other| **other != word)?),
            (_, Value::File(_)) => Value::File(concat!(env!("CARGO_MANIFEST_DIR"), "/README.md")),
            _ => return None,
        })
    }

    /// What the bodies tell is not taken for that of a design with any other value, but for the keys left out: that these
    /// do not reach the bodies is for tests/laws.rs to show.
    #[test]
    fn every_key_but_those_of_exhaust_and_room_is_in_the_key() {
        let base = Design::load(concat!(env!("CARGO_MANIFEST_DIR"), "/tests/data/small.toml")).unwrap();
        let record = cycle(&base).unwrap();
        let digest = |design: &Design| key(design, Options::default(), &record).digest();
        let keys = base.keys();
        let mut left_out = Vec::new();
        for (key, kind, value) in &keys {
            let mut design = base.clone();
            let other = moved(*kind, *value).unwrap_or_else(|| panic!("{key} has one value"));
            design.set(&[(key.as_str(), other)]).unwrap();
            if digest(&design) == digest(&base) {
                left_out.push(key.as_str());
            }
        }
        assert!(keys.len() > 300, "{} keys tried", keys.len());
        let expected = |key: &&str| key.starts_with("exhaust.") || OF_THE_ROOM.contains(key);
        let all: Vec<&str> = keys.iter().map(|(key, ..)| key.as_str()).filter(expected).collect();
        assert_eq!(left_out, all);
    }
}
