//! Virtual wrapping tests: the signals that the microphones and sensors of EN 12549 would record for a design in each
//! configuration.
//!
//! Each shot of each configuration is separate: supply pressure and the wood's resistance scatter, jets and background
//! have new noise, and the trigger is pulled at a different instant. The pressures of the sources pass through
//! minimum-phase filters for the wraps and are added. [`exact`] does the same with energies, without recordings.

pub mod bare;
pub mod comparison;
pub mod exact;
mod minimum_phase;
mod resampling;
mod sources;

use std::sync::Arc;

use rayon::prelude::*;

use crate::chain::{Chain, Options};
use crate::design::inputs::{self, located};
use crate::design::{Design, Value};
use crate::error::Error;
use crate::graph::Graph;
use crate::measurement::arrangement::Arrangement;
use crate::measurement::lines::BEFORE;
use crate::measurement::markers::MarkerEvents;
use crate::measurement::recordings::Shot;
use crate::measurement::wrapping::{Configuration, InsertionLoss, Role, Wrapping};
use crate::model::supports;
use crate::stages::Input;
use crate::stages::cycle::ShotRecord;
use crate::stages::microphones::Heard;
use crate::stages::microphones::noise::{normal, under_envelope};
use crate::stages::sensors::SensorRecord;
use crate::stages::transducers::PressureRecord;
use crate::study::StudyError;
use minimum_phase::MinimumPhase;
use resampling::Resampling;
use sources::Synthesis;

/// Frequencies between which the losses of wraps and of the muffler increase \[Hz\].
const WRAP_HZ: [f64; 2] = [125.0, 4000.0];
const MUFFLER_HZ: [f64; 2] = [50.0, 400.0];

/// Keys whose values scatter from shot to shot.
const SCATTERED: [&str; 2] = ["supply.pressure", "wood.resistance_scale"];

/// Time over which the end of a sensor's record fades to zero \[s\].
const FADE: f64 = 5e-3;

/// The wraps of a design.
pub fn wrapping(design: &Design) -> Wrapping {
    let wraps = &design.test.wraps;
    let loss = |[low, high]: [f64; 2], a: f64, b: f64| InsertionLoss {
        low: (low, a),
        high: (high, b),
    };
    Wrapping {
        workpiece: loss(WRAP_HZ, wraps.workpiece_low, wraps.workpiece_high),
        body: loss(WRAP_HZ, wraps.body_low, wraps.body_high),
        muffler: loss(MUFFLER_HZ, wraps.muffler_low, wraps.muffler_high),
        exhaust_mask: crate::measurement::wrapping::decibels_as_share(wraps.exhaust_mask),
        workpiece_mask: crate::measurement::wrapping::decibels_as_share(wraps.workpiece_mask),
    }
}

/// Microphones and channels of a design's virtual test.
///
/// # Errors
/// [`Error::NoTestSetup`] for a support that the standard does not have; the errors of the air.
pub fn arrangement(design: &Design) -> Result<Arrangement, Error> {
    let setup = supports::of(design).test_setup().ok_or_else(|| Error::NoTestSetup {
        design: design.name().to_owned(),
        support: design.support.kind.as_str(),
    })?;
    let array = inputs::microphones::array(design)?;
    let [x, y, plane] = array.foot;
    let names = inputs::sensors::accelerometers(design)?;
    Ok(Arrangement {
        setup,
        centre: [x, y, plane + array.centre_height].into(),
        microphone_names: (1..=array.positions().len())
            .map(|number| format!("mic{number}"))
            .collect(),
        microphones: array.positions(),
        plane,
        air: array.air,
        absorption: (design.acoustics.room_absorption > 0.0).then_some(design.acoustics.room_absorption),
        range_hz: array.range_hz,
        accelerometers: names.into_iter().map(|own| own.name).collect(),
        transducers: inputs::sensors::transducers(design)?
            .into_iter()
            .map(|own| own.name)
            .collect(),
        events: marker_events(design)?,
    })
}

/// Events of the markers: those of the N80CB that an assembly has, and those that it names.
fn marker_events(design: &Design) -> Result<MarkerEvents, Error> {
    let events = MarkerEvents::default();
    let Some(cycle) = inputs::assembly::cycle(design)? else {
        return Ok(events);
    };
    let names: Vec<&str> = cycle.assembly.events.iter().map(|own| own.name.as_str()).collect();
    let mut events = events.among(&names);
    for marker in &cycle.assembly.markers {
        events.set(&marker.name, &marker.event);
    }
    Ok(events)
}

/// A sensor's record whose end fades to zero, if its body still moves slightly.
fn faded(record: &[f64], interval: f64) -> Vec<f64> {
    let count = ((FADE / interval).round() as usize).min(record.len());
    let first = record.len() - count;
    let fall = |i: usize| 0.5 * (1.0 + (std::f64::consts::PI * (i as f64 + 0.5) / count as f64).cos());
    let mut faded = record.to_vec();
    faded[first..].iter_mut().enumerate().for_each(|(i, a)| *a *= fall(i));
    faded
}

/// Adds signals to a sum for each microphone; a shorter signal ends in silence.
fn add_signals(sum: &mut Vec<Vec<f64>>, signals: Vec<Vec<f64>>) {
    sum.resize(sum.len().max(signals.len()), Vec::new());
    for (sum, signal) in sum.iter_mut().zip(signals) {
        sum.resize(sum.len().max(signal.len()), 0.0);
        sum.iter_mut().zip(signal).for_each(|(sum, p)| *sum += p);
    }
}

/// A shot of a virtual test before wraps are applied.
pub struct BareShot {
    /// The cycle.
    pub cycle: Arc<ShotRecord>,
    /// Pressures of workpiece, exhaust and body at each microphone from the trigger on \[Pa\].
    pub sources: [Vec<Vec<f64>>; 3],
    /// Signals of the accelerometers.
    pub sensors: Arc<Vec<SensorRecord>>,
    /// Signals of the pressure transducers.
    pub transducers: Arc<Vec<PressureRecord>>,
}

/// A virtual test of a design.
pub struct VirtualTest<'a> {
    design: &'a Design,
    graph: &'a Graph,
    /// Retains bodies and radiation matrices for all shots.
    _base: Chain,
    /// Microphones and channels.
    pub arrangement: Arrangement,
    synthesis: Synthesis,
    wrapping: Wrapping,
    seed: u64,
}

impl<'a> VirtualTest<'a> {
    /// A test of a design with these wraps; all scatter and noise depends on `seed`.
    ///
    /// # Errors
    /// Same as [`arrangement`], or if values of the design yield no valid inputs.
    pub fn new(graph: &'a Graph, design: &'a Design, wrapping: Wrapping, seed: u64) -> Result<Self, Error> {
        let arrangement = arrangement(design)?;
        let rate = design.test.sampling_rate;
        Ok(Self {
            design,
            graph,
            _base: Chain::new(graph, design, Options::default()).map_err(|error| located(design, error))?,
            synthesis: Synthesis {
                rate,
                travel: arrangement.travel_times(),
                top_hz: design.analysis.range_high,
            },
            arrangement,
            wrapping,
            seed,
        })
    }

    /// Number of the noise sequence of a shot.
    fn stream(configuration: Configuration, repeat: usize) -> u64 {
        (1000 * configuration.number() + repeat) as u64
    }

    /// Keys that would scatter, but that the formulas of the design's assembly do not read.
    pub fn without_scatter(&self) -> Vec<&'static str> {
        let mut keys = SCATTERED.to_vec();
        keys.retain(|key| !self.design.cycle_reads(key));
        keys
    }

    /// The design of one shot: supply pressure and resistance scatter, and the mass of the wrap is added if it is used.
    /// If the formulas of an assembly do not read one of these keys, it causes no scatter.
    fn scattered(&self, configuration: Configuration, repeat: usize) -> Result<Design, Error> {
        let stream = Self::stream(configuration, repeat);
        let (test, mut design) = (&self.design.test, self.design.clone());
        let factor = |deviation: f64, place: u64| 1.0 + deviation * normal(self.seed, stream, place);
        let wrapped = !matches!(configuration, Configuration::Total | Configuration::Body);
        let added = if wrapped && test.wraps.adds_mass {
            test.wraps.mass
        } else {
            0.0
        };
        let changes = [
            (SCATTERED[0], design.supply.pressure * factor(test.pressure_scatter, 0)),
            (
                SCATTERED[1],
                design.wood.resistance_scale * factor(test.resistance_scatter, 1),
            ),
            ("tool.mass", design.tool.mass + added),
        ];
        let changes: Vec<(&str, Value)> = changes
            .into_iter()
            .map(|(key, value)| (key, Value::Number(value)))
            .collect();
        design.set(&changes).map_err(|error| StudyError::NoDesign {
            reason: error.to_string(),
        })?;
        Ok(design)
    }

    /// The shot of the design itself, without scatter.
    ///
    /// # Errors
    /// The errors of the chain.
    pub fn own(&self) -> Result<BareShot, Error> {
        self.shot(self.design, 0)
    }

    /// One shot of a configuration, with unwrapped sources.
    ///
    /// # Errors
    /// The errors of the chain.
    pub fn bare(&self, configuration: Configuration, repeat: usize) -> Result<BareShot, Error> {
        self.shot(
            &self.scattered(configuration, repeat)?,
            Self::stream(configuration, repeat),
        )
    }

    /// Largest pressure of any source at any microphone \[Pa\].
    pub fn peak(&self, bare: &BareShot) -> f64 {
        let pressures = bare.sources.iter().flatten().flatten();
        pressures.fold(0.0, |peak: f64, p| peak.max(p.abs()))
    }

    fn shot(&self, design: &Design, stream: u64) -> Result<BareShot, Error> {
        let options = Options {
            noise_seed: (self.seed as u32).wrapping_mul(100_003).wrapping_add(stream as u32),
            ..Options::default()
        };
        let chain = Chain::new(self.graph, design, options)?;
        chain.check_bodies().map_err(|error| located(design, error))?;
        let mut outputs: Vec<&dyn Input<Error>> = chain
            .sources
            .iter()
            .map(|own| &own.sound as &dyn Input<Error>)
            .collect();
        outputs.extend([&chain.sensors as &dyn Input<Error>, &chain.transducers]);
        self.graph.prepare(&outputs).map_err(|error| located(design, error))?;
        let count = chain.sources.len() as u64;
        // Numbers of the noise of a shot: those of the sources, then those of parts by the source that they are
        // assigned to.
        let stream = (2 * count + 2).max(8) * stream;
        // A tool without one of the sources has no signal for it.
        let silent = vec![Vec::new(); self.arrangement.microphones.len()];
        let mut sources = Role::ALL.map(|_| silent.clone());
        let mut add = |role: Role, heard: &Heard, number: u64| {
            let noise = (self.seed, stream + number);
            let signals = self.synthesis.signals(&heard.source, &heard.received, noise);
            add_signals(&mut sources[role as usize], signals);
        };
        let sounds = chain.sources.iter().map(|own| Ok((own.source, own.sound.get()?)));
        let sounds = sounds.collect::<Result<Vec<_>, Error>>()?;
        for (number, (source, sound)) in (1..).zip(&sounds) {
            add(source.role(), &sound.heard.own, number);
        }
        // A part that is assigned to another source has its own frequency range.
        for moved in sounds.iter().filter_map(|(_, sound)| sound.heard.moved.as_ref()) {
            let places = (1..).zip(&sounds);
            for (number, (source, _)) in places.filter(|(_, (source, _))| source.name() == moved.to) {
                add(source.role(), &moved.part, count + number);
            }
        }
        Ok(BareShot {
            cycle: chain.cycle.get()?,
            sources,
            sensors: chain.sensors.get()?,
            transducers: chain.transducers.get()?,
        })
    }

    /// The signals that the channels record of a shot in a configuration.
    pub fn record(&self, bare: &BareShot, configuration: Configuration, repeat: usize) -> Shot {
        let stream = Self::stream(configuration, repeat);
        let test = &self.design.test;
        let rate = self.synthesis.rate;
        let trigger = test.trigger_delay * nailnoise_acoustics::random::uniform(self.seed, stream, 99);
        // The trigger coincides with a sample, because the signals of the sources start with it.
        let start = ((BEFORE + trigger) * rate).round() as usize;
        let samples = (test.record_length * rate).round() as usize;
        let wraps = self.filters(bare);
        let microphone = |place: usize| {
            let mut record = self.background(samples, (stream, place));
            for (role, (signals, wrap)) in Role::ALL.into_iter().zip(bare.sources.iter().zip(&wraps)) {
                let passed = self.passed(&signals[place], (role, wrap), configuration);
                record.iter_mut().skip(start).zip(passed).for_each(|(sum, p)| *sum += p);
            }
            record
        };
        let sensor = |(place, own): (usize, &SensorRecord)| {
            let length = ((own.acceleration.len() as f64 * own.interval + BEFORE) * rate).ceil() as usize;
            let resampling = Resampling::new((own.acceleration.len(), 1.0 / own.interval), (length, rate));
            let noise =
                |n: usize| test.acceleration_noise * normal(self.seed, 64 * stream + 32 + place as u64, n as u64);
            let mut record: Vec<f64> = (0..samples).map(noise).collect();
            let moved = resampling.apply(&faded(&own.acceleration, own.interval));
            record.iter_mut().skip(start).zip(moved).for_each(|(sum, a)| *sum += a);
            record
        };
        let transducer = |own: &PressureRecord| {
            let length = (own.values.len() as f64 * own.interval * rate).floor() as usize;
            let resampling = Resampling::new((own.values.len(), 1.0 / own.interval), (length, rate));
            let mut record = vec![0.0; samples];
            let read = resampling.apply(&faded(&own.values, own.interval));
            record.iter_mut().skip(start).zip(read).for_each(|(sum, p)| *sum += p);
            record
        };
        let places = 0..self.arrangement.microphones.len();
        Shot {
            rate,
            trigger: start as f64 / rate,
            microphones: places.into_par_iter().map(microphone).collect(),
            accelerations: bare.sensors.par_iter().enumerate().map(sensor).collect(),
            pressures: bare.transducers.par_iter().map(transducer).collect(),
        }
    }

    /// Filters of the wraps and the muffler, in the order of the sources, for the signals of a shot.
    fn filters(&self, bare: &BareShot) -> [MinimumPhase; 3] {
        let length = bare.sources.iter().flatten().map(Vec::len).max().unwrap_or(0);
        Role::ALL.map(|source| {
            MinimumPhase::new(length, self.synthesis.rate, |hz| {
                self.wrapping.at(hz).of_source(source).sqrt()
            })
        })
    }

    /// The signal of a source after the wraps of a configuration.
    fn passed(&self, signal: &[f64], (source, wrap): (Role, &MinimumPhase), configuration: Configuration) -> Vec<f64> {
        let scaled = |share: f64| signal.iter().map(|p| share.sqrt() * p).collect();
        match (source, configuration) {
            (_, Configuration::Total) => signal.to_vec(),
            (Role::Workpiece, Configuration::Workpiece) => scaled(self.wrapping.workpiece_mask),
            (Role::Exhaust, Configuration::Exhaust) => scaled(self.wrapping.exhaust_mask),
            (Role::Body, Configuration::Body) => signal.to_vec(),
            _ if signal.is_empty() => Vec::new(),
            // Wraps that transmit nothing have no phase.
            (source, _) if self.wrapping.at(1000.0).of_source(source) == 0.0 => Vec::new(),
            _ => wrap.apply(signal),
        }
    }

    /// Steady background noise at a microphone \[Pa\].
    fn background(&self, samples: usize, (stream, place): (u64, usize)) -> Vec<f64> {
        let level = self.design.acoustics.background_level;
        if level <= 0.0 {
            return vec![0.0; samples];
        }
        let rate = self.synthesis.rate;
        let scale = exact::background_density(level) * samples as f64 / rate;
        let density = |hz: f64| {
            if (exact::BACKGROUND_HZ[0]..=exact::BACKGROUND_HZ[1]).contains(&hz) {
                scale / hz
            } else {
                0.0
            }
        };
        under_envelope(
            &vec![1.0; samples],
            rate,
            density,
            (self.seed, 64 * stream + place as u64 + 16),
        )
    }

    /// Densities of the sources of a shot at the lines of one second, averaged over the microphones \[Pa2 s/Hz\].
    pub fn densities(&self, bare: &BareShot) -> [Vec<f64>; 3] {
        let transform = crate::measurement::lines::OneSecond::new(self.synthesis.rate);
        bare.sources
            .each_ref()
            .map(|signals| sources::mean_density(signals, &transform))
    }
}
