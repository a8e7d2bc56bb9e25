//! From recordings to levels: alignment, subtraction of the residual, levels by band and interval, uncertainty.

use nalgebra::Complex;
use rayon::prelude::*;

use super::alignment::delay;
use super::arrangement::Arrangement;
use super::lines::{BEFORE, Bands, OneSecond};
use super::markers::{LAST, MARKERS, Markers, STANDARD_GRAVITY, Signals, rms_and_peak};
use super::recordings::Shot;
use super::repeats::RepeatedLevel;
use super::result::{
    MeasuredAcceleration, MeasuredBand, MeasuredBound, MeasuredConfiguration, MeasuredInterval, MeasuredMarker,
    MeasuredSource, MeasurementResult, Processing, SCHEMA,
};
use super::subtraction::{SURVEY_LIMIT_DB, expected_energy};
use super::wrapping::Configuration;
use crate::error::Error;

/// Largest delay between shots that is looked for \[s\].
const MOST_DELAY: f64 = 0.02;

/// Level above the residual below which a source is not measured \[dB\].
const LEAST_ABOVE: f64 = 3.0;

/// Fewest repeats of a test (EN 12549).
pub const LEAST_REPEATS: usize = 5;

/// A configuration that was recorded.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Recorded {
    /// Which.
    pub configuration: Configuration,
    /// Number of its shots.
    pub repeats: usize,
}

/// The corrected signals of one shot of a source.
#[derive(Debug, Clone)]
pub struct CorrectedShot {
    /// The source.
    pub source: &'static str,
    /// Repeat, from 0.
    pub repeat: usize,
    /// Sampling rate \[1/s\].
    pub rate: f64,
    /// Pressure at each microphone from 10 ms before the trigger on \[Pa\].
    pub microphones: Vec<Vec<f64>>,
}

/// Signals of one shot of each configuration, for charts.
#[derive(Debug, Clone)]
pub struct ShotSignals {
    /// Its configuration.
    pub configuration: Configuration,
    /// Sampling rate \[1/s\].
    pub rate: f64,
    /// Pressure at the first microphone from 10 ms before the trigger on \[Pa\].
    pub microphone: Vec<f64>,
    /// Acceleration of each accelerometer over the same time \[m/s2\].
    pub accelerations: Vec<Vec<f64>>,
    /// Pressure of each transducer over the same time \[Pa\].
    pub pressures: Vec<Vec<f64>>,
    /// Its markers.
    pub markers: Markers,
}

/// What a test measured, with signals.
pub struct Measured {
    /// Levels.
    pub result: MeasurementResult,
    /// The first shot of each configuration.
    pub signals: Vec<ShotSignals>,
    /// Names of the accelerometers.
    pub accelerometers: Vec<String>,
    /// Names of the pressure transducers.
    pub transducers: Vec<String>,
}

/// Energies of one shot: mean exposures over the microphones \[Pa2 s\].
#[derive(Debug, Clone, Default)]
struct Energies {
    whole: f64,
    bands: Vec<f64>,
    /// Markers on either side, their instants \[s\], and the energy between them.
    intervals: Vec<Between>,
}

#[derive(Debug, Clone)]
struct Between {
    names: [&'static str; 2],
    seconds: [f64; 2],
    energy: f64,
}

/// One shot after processing.
struct Processed {
    raw: Energies,
    corrected: Option<Energies>,
    zeroed: f64,
    before_trigger: f64,
    markers: Markers,
    accelerations: Vec<(f64, f64)>,
}

/// Residual of a test: mean squares of the lines at each microphone, of all shots or shot by shot.
struct Residual {
    /// By repeat (one for the mean), microphone and line \[Pa2 s2\].
    squares: Vec<Vec<Vec<f64>>>,
    /// Shots behind each.
    shots: u32,
}

impl Residual {
    fn of(&self, repeat: usize) -> &[Vec<f64>] {
        &self.squares[repeat % self.squares.len()]
    }
}

/// Processes a test. `shot` reads a configuration's repeat, counted from 0; `keep` takes the corrected signals of each shot of
/// a source.
///
/// # Errors
/// Those of `shot` and `keep`; [`Error::Measurement`] for markers in the wrong order.
pub fn process(
    arrangement: &Arrangement,
    processing: Processing,
    recorded: &[Recorded],
    shot: impl Fn(Configuration, usize) -> Result<Shot, Error>,
    mut keep: impl FnMut(CorrectedShot) -> Result<(), Error>,
) -> Result<Measured, Error> {
    let room = arrangement.room_correction()?;
    let mut context: Option<Context<'_>> = None;
    let mut residual: Option<Residual> = None;
    let mut signals = Vec::new();
    let mut reference: Option<Vec<f64>> = None;
    let mut all: Vec<(Recorded, Vec<Processed>, Vec<Option<f64>>)> = Vec::new();
    // The residual first: the others need it. The delays refer to the first shot that is read.
    let mut order: Vec<Recorded> = recorded.to_vec();
    order.sort_by_key(|one| (one.configuration != Configuration::Residual, one.configuration));
    for one in order {
        let (mut shots, mut delays) = (Vec::new(), Vec::new());
        for repeat in 0..one.repeats {
            let recording = shot(one.configuration, repeat)?;
            let context = context.get_or_insert_with(|| Context::new(arrangement, processing, recording.rate));
            let lines = context.lines(&recording);
            if one.configuration == Configuration::Residual {
                let made = residual.get_or_insert_with(|| Residual {
                    squares: Vec::new(),
                    shots: if processing.paired { 1 } else { one.repeats as u32 },
                });
                context.add_residual(made, &lines, one.repeats);
            }
            let own = residual.as_ref().map(|residual| residual.of(repeat));
            let subtracted = match one.configuration {
                Configuration::Residual => None,
                Configuration::Total => own.filter(|_| processing.total_less_residual),
                _ => own,
            };
            let (processed, corrected) = context.process(&recording, &lines, subtracted);
            if let Some(pair) = processed.markers.disorder() {
                return Err(disorder(arrangement, one.configuration, repeat, pair));
            }
            if let Some((source, microphones)) = one.configuration.source().zip(corrected) {
                let rate = recording.rate;
                keep(CorrectedShot {
                    source,
                    repeat,
                    rate,
                    microphones,
                })?;
            }
            let moving = arrangement.accelerometer(&["N", "handle", "TC", "table_centre", "W", "block_top"]);
            let moving = moving.and_then(|place| recording.accelerations.get(place));
            let piece = moving.map(|record| context.transform.cut(record, recording.trigger));
            delays.push(match (&reference, &piece) {
                (Some(reference), Some(piece)) => delay(reference, piece, recording.rate, MOST_DELAY),
                _ => None,
            });
            if reference.is_none() {
                reference = piece;
            }
            if repeat == 0 {
                signals.push(context.signals(one.configuration, &recording, processed.markers));
            }
            shots.push(processed);
        }
        all.push((one, shots, delays));
    }
    all.sort_by_key(|(one, ..)| one.configuration);
    signals.sort_by_key(|shown: &ShotSignals| shown.configuration);
    let summary = Summary {
        arrangement,
        room,
        processing,
        hz: context
            .as_ref()
            .map_or_else(Vec::new, |context| context.bands.nominal_hz()),
        residual_shots: residual.as_ref().map_or(1, |residual| residual.shots),
        all,
    };
    Ok(Measured {
        result: summary.result(),
        signals,
        accelerometers: arrangement.accelerometers.clone(),
        transducers: arrangement.transducers.clone(),
    })
}

fn disorder(
    arrangement: &Arrangement,
    configuration: Configuration,
    repeat: usize,
    [first, second]: [(&'static str, f64); 2],
) -> Error {
    super::error::MeasurementError::Shot {
        configuration: arrangement.setup.configuration(configuration.number()),
        repeat: repeat + 1,
        problem: format!(
            "marker {} at {:.2} ms lies before {} at {:.2} ms",
            second.0,
            1e3 * second.1,
            first.0,
            1e3 * first.1
        ),
        help: "check the names of the channels and the trigger: N is on the handle, W on the block, TC under the table, PT-I \
               in the cylinder"
            .to_owned(),
    }
    .into()
}

/// What all shots of a test share.
struct Context<'a> {
    arrangement: &'a Arrangement,
    processing: Processing,
    transform: OneSecond,
    bands: Bands,
    travel: Vec<f64>,
}

impl<'a> Context<'a> {
    fn new(arrangement: &'a Arrangement, processing: Processing, rate: f64) -> Self {
        let transform = OneSecond::new(rate);
        Self {
            arrangement,
            processing,
            bands: Bands::new(&transform.frequencies(), arrangement.range_hz),
            travel: arrangement.travel_times(),
            transform,
        }
    }

    /// Lines at each microphone.
    fn lines(&self, shot: &Shot) -> Vec<Vec<Complex<f64>>> {
        let of = |record: &Vec<f64>| self.transform.lines(&self.transform.cut(record, shot.trigger));
        shot.microphones.par_iter().map(of).collect()
    }

    fn add_residual(&self, residual: &mut Residual, lines: &[Vec<Complex<f64>>], repeats: usize) {
        let share = if self.processing.paired {
            1.0
        } else {
            1.0 / repeats as f64
        };
        let squares = lines
            .iter()
            .map(|lines| lines.iter().map(|x| share * x.norm_sqr()).collect());
        if self.processing.paired || residual.squares.is_empty() {
            residual.squares.push(squares.collect());
            return;
        }
        for (sum, own) in residual.squares[0].iter_mut().zip(squares.collect::<Vec<Vec<f64>>>()) {
            sum.iter_mut().zip(own).for_each(|(sum, x)| *sum += x);
        }
    }

    /// Energies of a shot, raw and less a residual, and its corrected signals.
    fn process(
        &self,
        shot: &Shot,
        lines: &[Vec<Complex<f64>>],
        residual: Option<&[Vec<f64>]>,
    ) -> (Processed, Option<Vec<Vec<f64>>>) {
        let markers = self.markers(shot);
        let corrected = residual.map(|residual| self.corrected(lines, residual));
        let raw = self.energies(lines, None, &markers);
        let (signals, after, zeroed) = match corrected {
            Some((lines, zeroed)) => {
                let signals: Vec<Vec<f64>> = lines.par_iter().map(|lines| self.transform.signal(lines)).collect();
                let energies = self.energies(&lines, Some(&signals), &markers);
                (Some(signals), Some(energies), zeroed)
            }
            None => (None, None, 0.0),
        };
        let processed = Processed {
            before_trigger: signals.as_ref().map_or(0.0, |signals| self.before_trigger(signals)),
            raw,
            corrected: after,
            zeroed,
            markers,
            accelerations: self.accelerations(shot),
        };
        (processed, signals)
    }

    /// Lines less a residual, and the share of the A-weighted energy that was set to zero.
    fn corrected(&self, lines: &[Vec<Complex<f64>>], residual: &[Vec<f64>]) -> (Vec<Vec<Complex<f64>>>, f64) {
        let df = self.transform.df();
        let of = |(lines, squares): (&Vec<Complex<f64>>, &Vec<f64>)| {
            let mut zeroed = lines.clone();
            let mut kept = lines.clone();
            for ((zeroed, kept), square) in zeroed.iter_mut().zip(&mut kept).zip(squares) {
                let gain = self.processing.reading.gain_squared(kept.norm_sqr(), *square, df);
                *kept *= gain.sqrt();
                if gain > 0.0 {
                    *zeroed = Complex::default();
                }
            }
            (kept, self.bands.energy(&zeroed), self.bands.energy(lines))
        };
        let found: Vec<_> = lines.par_iter().zip(residual).map(of).collect();
        let (zeroed, all) = found.iter().fold((0.0, 0.0), |(z, a), own| (z + own.1, a + own.2));
        let share = if all > 0.0 { zeroed / all } else { 0.0 };
        (found.into_iter().map(|own| own.0).collect(), share)
    }

    /// Mean exposures over the microphones; intervals need the signals.
    fn energies(&self, lines: &[Vec<Complex<f64>>], signals: Option<&[Vec<f64>]>, markers: &Markers) -> Energies {
        let of = |lines: &Vec<Complex<f64>>| (self.bands.energy(lines), self.bands.band_energies(lines));
        let found: Vec<_> = lines.par_iter().map(of).collect();
        let count = found.len().max(1) as f64;
        let mut bands = vec![0.0; found.first().map_or(0, |own| own.1.len())];
        for (_, own) in &found {
            bands.iter_mut().zip(own).for_each(|(sum, e)| *sum += e / count);
        }
        Energies {
            whole: found.iter().map(|own| own.0).sum::<f64>() / count,
            bands,
            intervals: signals.map_or_else(Vec::new, |signals| self.intervals(signals, markers)),
        }
    }

    /// Energies between neighbouring markers, the signal of each microphone taken back by its travel time.
    fn intervals(&self, signals: &[Vec<f64>], markers: &Markers) -> Vec<Between> {
        let found = markers.found();
        let rate = self.transform.df() * self.transform.samples() as f64;
        let between = |pair: &[(&'static str, f64)]| {
            let of = |(signal, travel): (&Vec<f64>, &f64)| {
                let at =
                    |seconds: f64| (((BEFORE + seconds + travel) * rate).round().max(0.0) as usize).min(signal.len());
                let (begin, end) = (at(pair[0].1), at(pair[1].1));
                if begin >= end {
                    return 0.0;
                }
                let mut piece = vec![0.0; signal.len()];
                piece[begin..end].copy_from_slice(&signal[begin..end]);
                self.bands.energy(&self.transform.lines(&piece))
            };
            let energy: f64 = signals.par_iter().zip(&self.travel).map(of).sum();
            Between {
                names: [pair[0].0, pair[1].0],
                seconds: [pair[0].1, pair[1].1],
                energy: energy / signals.len().max(1) as f64,
            }
        };
        found.windows(2).map(between).collect()
    }

    /// Share of the signals' energy before the trigger.
    fn before_trigger(&self, signals: &[Vec<f64>]) -> f64 {
        let rate = self.transform.df() * self.transform.samples() as f64;
        let first = (BEFORE * rate).round() as usize;
        let energy = |x: &[f64]| x.iter().map(|x| x * x).sum::<f64>();
        let (before, all) = signals.iter().fold((0.0, 0.0), |(before, all), signal| {
            (
                before + energy(&signal[..first.min(signal.len())]),
                all + energy(signal),
            )
        });
        if all > 0.0 { before / all } else { 0.0 }
    }

    fn markers(&self, shot: &Shot) -> Markers {
        let acceleration = |names: &[&str]| {
            let place = self.arrangement.accelerometer(names)?;
            shot.accelerations.get(place).map(Vec::as_slice)
        };
        let cylinder = self.arrangement.transducer("PT-I");
        let signals = Signals {
            handle: acceleration(&["N", "handle"]),
            block: acceleration(&["W", "block_top", "SE", "sand_edge"]),
            table: acceleration(&["TC", "table_centre"]),
            cylinder: cylinder.and_then(|place| shot.pressures.get(place)).map(Vec::as_slice),
        };
        Markers::find(&signals, shot.rate, shot.trigger)
    }

    fn accelerations(&self, shot: &Shot) -> Vec<(f64, f64)> {
        let of = |record: &Vec<f64>| {
            let (rms, peak) = rms_and_peak(&self.transform.cut(record, shot.trigger), shot.rate);
            (rms / STANDARD_GRAVITY, peak / STANDARD_GRAVITY)
        };
        shot.accelerations.iter().map(of).collect()
    }

    fn signals(&self, configuration: Configuration, shot: &Shot, markers: Markers) -> ShotSignals {
        let cut = |record: &Vec<f64>| self.transform.cut(record, shot.trigger);
        ShotSignals {
            configuration,
            rate: shot.rate,
            microphone: shot.microphones.first().map_or_else(Vec::new, cut),
            accelerations: shot.accelerations.iter().map(cut).collect(),
            pressures: shot.pressures.iter().map(cut).collect(),
            markers,
        }
    }
}

/// Processed shots of all configurations.
struct Summary<'a> {
    arrangement: &'a Arrangement,
    room: f64,
    processing: Processing,
    /// Nominal mid-band frequencies \[Hz\].
    hz: Vec<f64>,
    residual_shots: u32,
    all: Vec<(Recorded, Vec<Processed>, Vec<Option<f64>>)>,
}

impl Summary<'_> {
    fn result(&self) -> MeasurementResult {
        let sources: Vec<MeasuredSource> = self
            .all
            .iter()
            .filter_map(|(one, shots, _)| self.source(*one, shots))
            .collect();
        let level_of = |name: &str| sources.iter().find(|own| own.source == name).and_then(|own| own.level);
        let closure = self.total().and_then(|total| {
            let parts = super::wrapping::SOURCES.map(level_of);
            let sum: Option<f64> = parts
                .iter()
                .map(|level| level.map(|level| 10f64.powf(0.1 * level.db)))
                .sum();
            Some(total.db - 10.0 * sum?.log10())
        });
        MeasurementResult {
            schema: SCHEMA.to_owned(),
            manifest: String::new(),
            setup: self.arrangement.setup,
            area_m2: self.arrangement.surface().area(),
            k2_db: self.room,
            range_hz: self.arrangement.range_hz,
            processing: self.processing,
            configurations: self.all.iter().map(|one| self.configuration(one)).collect(),
            bound: self.bound(&sources),
            closure_db: closure,
            notes: self.notes(&sources),
            sources,
        }
    }

    fn level(&self, exposure: f64) -> Option<f64> {
        self.arrangement.level(exposure, self.room)
    }

    /// Mean of the levels of energies.
    fn repeated(&self, energies: impl Iterator<Item = f64>) -> Option<RepeatedLevel> {
        let levels: Vec<f64> = energies.filter_map(|energy| self.level(energy)).collect();
        RepeatedLevel::of(&levels)
    }

    fn bands<'e>(&self, shots: impl Iterator<Item = &'e Energies> + Clone) -> Vec<MeasuredBand> {
        let of = |(place, hz): (usize, &f64)| MeasuredBand {
            hz: *hz,
            lwa_db: self
                .repeated(shots.clone().map(|own| own.bands[place]))
                .map(|level| level.db),
        };
        self.hz.iter().enumerate().map(of).collect()
    }

    fn intervals<'e>(&self, shots: impl Iterator<Item = &'e Energies>) -> Vec<MeasuredInterval> {
        let mut found: Vec<([&'static str; 2], Vec<&Between>)> = Vec::new();
        for own in shots.flat_map(|energies| &energies.intervals) {
            match found.iter_mut().find(|(names, _)| *names == own.names) {
                Some((_, all)) => all.push(own),
                None => found.push((own.names, vec![own])),
            }
        }
        let mut intervals: Vec<MeasuredInterval> = found
            .into_iter()
            .map(|([from, to], all)| {
                let mean = |edge: usize| all.iter().map(|own| own.seconds[edge]).sum::<f64>() / all.len() as f64;
                MeasuredInterval {
                    from: from.to_owned(),
                    to: to.to_owned(),
                    seconds: [mean(0), mean(1)],
                    lwa_db: self.repeated(all.iter().map(|own| own.energy)).map(|level| level.db),
                }
            })
            .collect();
        intervals.sort_by(|a, b| a.seconds[0].total_cmp(&b.seconds[0]));
        intervals
    }

    /// Mean energies as recorded, of all microphones and repeats, of the range and its bands.
    fn mean_raw(&self, configuration: Configuration) -> Option<(f64, Vec<f64>)> {
        let (_, shots, _) = self.all.iter().find(|(one, ..)| one.configuration == configuration)?;
        let count = shots.len() as f64;
        let mut bands = vec![0.0; self.hz.len()];
        for shot in shots {
            bands
                .iter_mut()
                .zip(&shot.raw.bands)
                .for_each(|(sum, e)| *sum += e / count);
        }
        Some((shots.iter().map(|shot| shot.raw.whole).sum::<f64>() / count, bands))
    }

    fn configuration(
        &self,
        (one, shots, delays): &(Recorded, Vec<Processed>, Vec<Option<f64>>),
    ) -> MeasuredConfiguration {
        let raw = || shots.iter().map(|shot| &shot.raw);
        let residual = self.mean_raw(Configuration::Residual).map(|own| own.0);
        let own = self.mean_raw(one.configuration).map(|own| own.0);
        let above = own.zip(residual.filter(|_| one.configuration != Configuration::Residual));
        let names = self.arrangement.accelerometers.iter().enumerate();
        let count = shots.len().max(1) as f64;
        let accelerations = names.map(|(place, name)| {
            let mean = |value: &dyn Fn(&(f64, f64)) -> f64| {
                shots
                    .iter()
                    .filter_map(|shot| shot.accelerations.get(place))
                    .map(value)
                    .sum::<f64>()
                    / count
            };
            MeasuredAcceleration {
                name: name.clone(),
                rms_g: mean(&|own| own.0),
                peak_g: mean(&|own| own.1),
            }
        });
        MeasuredConfiguration {
            configuration: one.configuration,
            name: self.arrangement.setup.configuration(one.configuration.number()),
            level: self.repeated(raw().map(|own| own.whole)),
            above_residual_db: above
                .filter(|(_, residual)| *residual > 0.0)
                .map(|(own, residual)| 10.0 * (own / residual).log10()),
            bands: self.bands(raw()),
            intervals: self.intervals(raw()),
            accelerations: accelerations.collect(),
            markers: markers(shots),
            delays_s: delays.clone(),
        }
    }

    fn source(&self, one: Recorded, shots: &[Processed]) -> Option<MeasuredSource> {
        let name = one.configuration.source()?;
        let corrected: Vec<&Energies> = shots.iter().filter_map(|shot| shot.corrected.as_ref()).collect();
        if corrected.is_empty() {
            return None;
        }
        let (residual, residual_bands) = self.mean_raw(Configuration::Residual)?;
        let (whole, bands) = self.mean_raw(one.configuration)?;
        let count = shots.len() as f64;
        let differences = bands.iter().zip(&residual_bands).map(|(own, residual)| own - residual);
        let silent = expected_energy(1.0, 1.0, self.residual_shots, SURVEY_LIMIT_DB);
        let bands_by_energy: Vec<MeasuredBand> = self
            .hz
            .iter()
            .zip(differences)
            .map(|(hz, energy)| MeasuredBand {
                hz: *hz,
                lwa_db: self.level(energy),
            })
            .collect();
        Some(MeasuredSource {
            source: name.to_owned(),
            configuration: self.arrangement.setup.configuration(one.configuration.number()),
            level: self.repeated(corrected.iter().map(|own| own.whole)),
            by_energy_db: self.level(whole - residual),
            floor_db: self.level(silent * residual),
            zeroed_share: shots.iter().map(|shot| shot.zeroed).sum::<f64>() / count,
            before_trigger_share: shots.iter().map(|shot| shot.before_trigger).sum::<f64>() / count,
            bands: self.bands(corrected.iter().copied()),
            negative_bands: bands_by_energy.iter().filter(|band| band.lwa_db.is_none()).count(),
            bands_by_energy,
            intervals: self.intervals(corrected.iter().copied()),
        })
    }

    /// The total: as recorded, or less the residual where that is asked for.
    fn totals(&self) -> Option<Vec<&Energies>> {
        let (_, shots, _) = self
            .all
            .iter()
            .find(|(one, ..)| one.configuration == Configuration::Total)?;
        Some(
            shots
                .iter()
                .map(|shot| shot.corrected.as_ref().unwrap_or(&shot.raw))
                .collect(),
        )
    }

    fn total(&self) -> Option<RepeatedLevel> {
        self.repeated(self.totals()?.iter().map(|own| own.whole))
    }

    fn bound(&self, sources: &[MeasuredSource]) -> Option<MeasuredBound> {
        let of = |name: &str| sources.iter().find(|own| own.source == name);
        let (exhaust, body) = (of("exhaust")?, of("body")?);
        let total = self.total()?;
        let energy = |level: Option<f64>| level.map_or(0.0, |level| 10f64.powf(0.1 * level));
        let left = |total: Option<f64>, exhaust: Option<f64>, body: Option<f64>| {
            let left = energy(total) - energy(exhaust) - energy(body);
            (left > 0.0).then(|| 10.0 * left.log10())
        };
        let bands: Vec<MeasuredBand> = self
            .bands(self.totals()?.into_iter())
            .iter()
            .zip(exhaust.bands.iter().zip(&body.bands))
            .map(|(total, (exhaust, body))| MeasuredBand {
                hz: total.hz,
                lwa_db: left(total.lwa_db, exhaust.lwa_db, body.lwa_db),
            })
            .collect();
        Some(MeasuredBound {
            level: RepeatedLevel::less(
                &total,
                &[exhaust.level, body.level].into_iter().flatten().collect::<Vec<_>>(),
            ),
            by_energy_db: left(Some(total.db), exhaust.by_energy_db, body.by_energy_db),
            negative_bands: bands.iter().filter(|band| band.lwa_db.is_none()).count(),
            bands,
        })
    }

    fn notes(&self, sources: &[MeasuredSource]) -> Vec<String> {
        let name = |one: &Recorded| self.arrangement.setup.configuration(one.configuration.number());
        let mut notes = Vec::new();
        for (one, ..) in self.all.iter().filter(|(one, ..)| one.repeats < LEAST_REPEATS) {
            notes.push(format!(
                "{}: {} repeats; EN 12549 asks for {LEAST_REPEATS}",
                name(one),
                one.repeats
            ));
        }
        for one in self.all.iter().map(|one| self.configuration(one)) {
            if let Some(above) = one.above_residual_db.filter(|above| *above < LEAST_ABOVE) {
                notes.push(format!(
                    "{}: {above:.1} dB above the residual; below {LEAST_ABOVE:.0} dB its source is not measured, the level shown is the floor",
                    one.name
                ));
            }
        }
        for own in sources {
            let near = own
                .level
                .zip(own.floor_db)
                .filter(|(level, floor)| level.db < floor + 3.0);
            if let Some((level, floor)) = near {
                notes.push(format!(
                    "{}: {:.1} dB lies at the floor of the subtraction, {floor:.1} dB; the source may be anything below",
                    own.source, level.db
                ));
            }
        }
        if sources.iter().any(|own| own.source == "workpiece") && self.total().is_some() {
            notes.push(
                "the workpiece bare is masked by the body's wrap; the bound holds whatever the wraps hide, unless the bias of \
                 exhaust and body is larger (see the levels by energy)"
                    .to_owned(),
            );
        }
        notes
    }
}

/// Mean markers of shots.
fn markers(shots: &[Processed]) -> Vec<MeasuredMarker> {
    let of = |marker: &super::markers::Marker| {
        let found = shots.iter().filter_map(|shot| {
            let all = shot.markers.found();
            all.into_iter().find(|(name, _)| *name == marker.name).map(|(_, at)| at)
        });
        let found: Vec<f64> = found.collect();
        let count = found.len();
        let mean = found.iter().sum::<f64>() / count as f64;
        let squares: f64 = found.iter().map(|at| (at - mean).powi(2)).sum();
        (count > 0).then(|| MeasuredMarker {
            name: marker.name.to_owned(),
            event: marker.event.map(str::to_owned),
            meaning: marker.meaning.to_owned(),
            repeats: count,
            seconds: mean,
            deviation_s: (count > 1).then(|| (squares / (count - 1) as f64).sqrt()),
        })
    };
    MARKERS.iter().chain([&LAST]).filter_map(of).collect()
}
