//! What the moving bodies of a shot tell, once their motion is no longer needed.
//!
//! Modes, motion and spectra take hundreds of megabytes and most of a run's time. What the result needs of them is small
//! and a function of the design and of the cycle that drives them: it is kept, so that a design that changes only how the
//! exhaust sounds needs neither.

use nailnoise_acoustics::levels::{SourceSpectrum, Weighting};
use nailnoise_dynamics::{CouplingWork, CycleRecord};
use nailnoise_fem::transient::{Ending, ModalResponse};
use serde::{Deserialize, Serialize};

use super::radiator::{Radiator, tool_radiation};
use super::tool_sound::VIBRATION;
use super::vibration::{Bench, Moved, Vibration, modal_spectra};
use super::{Options, SensorRecord, Stiffness, Tool, cycle, radiation};
use crate::design::inputs;
use crate::design::{Coupling, Design};
use crate::error::Error;
use crate::result::{Check, Starts, Timing};
use crate::stages::Progress;
use crate::stages::exhaust::noise;
use crate::stages::intervals::EventEdges;
use crate::stages::microphones::AtMicrophones;
use crate::stages::response;
use crate::stages::sensors::{self, SensorMotion};
use crate::stages::sound::{Sound, SoundSource};
use crate::stages::spectra::side_by_side;
use crate::stages::starts::starts;
use crate::stages::truncation::{Part, Truncation, truncations};
use crate::store::Key;

/// What the moving bodies tell.
#[derive(Clone, Serialize, Deserialize)]
pub(super) struct Told {
    /// Workpiece with support, and tool body.
    pub(super) sources: [SoundSource; 2],
    /// When the last record ends \[s\].
    pub(super) end: f64,
    /// How the response ended, in words.
    pub(super) ending: String,
    /// Stiffness of an elastic tool body where the cycle's contacts act.
    pub(super) stiffness: Option<[Stiffness; 2]>,
    /// Energy that is absent above top frequencies.
    pub(super) truncations: Vec<Truncation>,
    /// What microphones hear of the sources.
    pub(super) heard: [AtMicrophones; 2],
    /// Levels of other starts.
    pub(super) starts: Option<Starts>,
    /// Checks of modes and response, then those of the tool's body.
    pub(super) checks: [Vec<Check>; 2],
    /// Signals of the sensors.
    pub(super) sensors: Vec<SensorRecord>,
}

/// A two-way run beside the one-way run of the same design.
pub(super) struct TwoWay {
    pub(super) work: CouplingWork,
    pub(super) checks: Vec<Check>,
    /// The cycle with its own lumped workpiece, and its sources.
    pub(super) one_way: (CycleRecord, [SourceSpectrum; 3]),
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

/// What bodies in motion tell, `body` being the sound of the tool's; and the same design one way, where it is coupled.
///
/// # Errors
/// [`Error`] of the stage that could not be computed.
pub(super) fn told(
    bench: &Bench<'_>,
    moved: &Moved,
    body: Sound,
    timing: &mut Timing,
    progress: &Progress,
) -> Result<(Told, Option<TwoWay>), Error> {
    let design = bench.design;
    let Moved {
        record,
        vibration,
        sensors,
        radiator,
        damping,
        coupling,
    } = moved;
    let Vibration {
        structure,
        response,
        spectra,
        tool,
    } = vibration;
    let damping = damping.as_deref();
    progress.stage("radiation");
    let mut of_sensors = Timing::default();
    let (sensors, workpiece) = rayon::join(
        || {
            let of_tool = tool.iter().map(|tool| &tool.sensors);
            let motions: Vec<&SensorMotion> = sensors.iter().chain(of_tool).collect();
            let grid = (response.step, response.samples());
            of_sensors.time("sensors", || {
                let accelerometers = inputs::sensors::accelerometers(design)?;
                sensors::signals(&accelerometers, grid, record, &motions)
            })
        },
        || {
            timing.time("radiation", || {
                radiation::workpiece(design, structure, radiator, damping, spectra)
            })
        },
    );
    let (sensors, workpiece) = (sensors?, workpiece?);
    timing.0.extend(of_sensors.0);
    let two_way = coupling.clone().map(|(work, checks)| {
        progress.stage("the same one way, to compare");
        let one_way = timing.time("one way", || one_way(bench, moved, progress))?;
        Ok::<_, Error>(TwoWay { work, checks, one_way })
    });
    let range = [design.analysis.range_low, design.analysis.range_high];
    let starts = if design.analysis.starts > 1 {
        progress.stage("other starts");
        let first = workpiece.spectrum.level(range, Weighting::A);
        let shot = inputs::response::shot(design)?;
        let bodies = shot.modal_bodies(structure.bodies(), damping);
        timing.time("other starts", || {
            starts(&shot, design.analysis.starts, first, |shot| {
                let response = match design.support.coupling {
                    Coupling::OneWay => shot.one_way(&bodies, record, bench.options.workpiece_force_scale)?,
                    Coupling::TwoWay => shot.two_way(&bodies, &inputs::cycle::cycle_settings(design))?.response,
                };
                let spectra = modal_spectra(design, structure, &response)?;
                let spectrum = radiation::workpiece_energy(radiator, &spectra)?;
                Ok(spectrum.level(range, Weighting::A))
            })
        })?
    } else {
        None
    };
    let parts = structure.bodies().map(|body| Part {
        name: body.name.into(),
        contribution: body.name.into(),
        top_hz: body.top_hz,
    });
    let mut truncated = truncations(("workpiece", &workpiece.spectrum), range, parts);
    let housing = tool.iter().map(|tool| Part {
        name: "tool".into(),
        contribution: VIBRATION.into(),
        top_hz: tool.body.top_hz,
    });
    truncated.extend(truncations(("body", &body.spectrum), range, housing));
    let end = moved.end();
    let heard = timing.time("bodies at the microphones", || {
        let array = inputs::microphones::array(design)?;
        let radiated = &workpiece.spectrum;
        let of_workpiece = match radiator {
            Radiator::Bem(bem) => array.boundary_elements(bem, &side_by_side(spectra), radiated, end),
            Radiator::Rayleigh(flush) => array.flush(&flush.sound, &spectra[0], radiated, end),
            Radiator::Erp(_) => array.spread_evenly(inputs::microphones::workpiece_centre(design), &workpiece, end),
        }?;
        let of_body = match tool.as_ref().and_then(|tool| Some((tool, tool.bem.as_ref()?))) {
            Some((tool, bem)) => array.boundary_elements(bem, &tool.spectra, &body.spectrum, end),
            None => array.oscillating_sphere(&inputs::microphones::tool_sphere(design), record, &body, end),
        }?;
        Ok::<_, Error>([of_workpiece, of_body])
    })?;
    let edges = EventEdges::new(&record.events, end);
    let sources = timing.time("intervals", || {
        [workpiece, body].map(|sound| SoundSource::new(sound, &edges, range))
    });
    let mut checks: [Vec<Check>; 2] = Default::default();
    structure.bodies().for_each(|body| checks[0].extend(body.checks()));
    checks[0].extend(response::checks("response", response));
    if let Some(tool) = tool {
        checks[1].extend(tool.body.checks());
        checks[1].extend(tool.checks.iter().cloned());
    }
    let told = Told {
        sources,
        end,
        ending: ending(response),
        stiffness: tool.as_ref().map(|tool| tool.stiffness.clone()),
        truncations: truncated,
        heard,
        starts,
        checks,
        sensors,
    };
    Ok((told, two_way.transpose()?))
}

/// The cycle of a coupled run with its own lumped workpiece, and the sources that it drives.
fn one_way(bench: &Bench<'_>, moved: &Moved, progress: &Progress) -> Result<(CycleRecord, [SourceSpectrum; 3]), Error> {
    let Bench {
        design,
        options,
        ref air,
        cache,
        ..
    } = *bench;
    let structure = &moved.vibration.structure;
    let record = cycle(design)?;
    let shot = inputs::response::shot(design)?;
    let bodies = shot.modal_bodies(structure.bodies(), moved.damping.as_deref());
    let response = shot.one_way(&bodies, &record, options.workpiece_force_scale)?;
    let spectra = modal_spectra(design, structure, &response)?;
    let workpiece = radiation::workpiece_energy(&moved.radiator, &spectra)?;
    let body = match &moved.vibration.tool {
        Some(tool) => {
            let body = tool.body.clone();
            let bem = tool_radiation(design, &body, air, cache, progress)?;
            Tool::new(design, (body, bem), &record)?.sound(design, &record, air)?
        }
        None => radiation::rigid_tool(design, &record, air)?,
    };
    let (exhaust, _) = noise(&inputs::exhaust::openings(design)?, &record)?;
    Ok((record, [workpiece, exhaust.spectrum, body.spectrum]))
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

    /// What the bodies tell is not taken for that of a design with any other value, but for the keys left out: that these
    /// do not reach the bodies is for tests/chain/laws.rs to show.
    #[test]
    fn every_key_but_those_of_exhaust_and_room_is_in_the_key() {
        let base = Design::load(concat!(env!("CARGO_MANIFEST_DIR"), "/tests/data/small.toml")).unwrap();
        let record = cycle(&base).unwrap();
        let digest = |design: &Design| key(design, Options::default(), &record).digest();
        let keys = base.keys();
        let mut left_out = Vec::new();
        for (key, kind, value) in &keys {
            let mut design = base.clone();
            let other = crate::design::another(value, *kind).unwrap_or_else(|| panic!("{key} has one value"));
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
