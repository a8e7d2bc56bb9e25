//! Processing of one shot: lines at each microphone, subtraction of the residual, energies by band and interval,
//! markers and accelerations.

use nalgebra::Complex;
use rayon::prelude::*;

use crate::arrangement::{Arrangement, Part};
use crate::lines::{BEFORE, Bands, OneSecond};
use crate::markers::{Markers, STANDARD_GRAVITY, Signals, arrival, rms_and_peak};
use crate::recordings::Shot;
use crate::result::Processing;
use crate::wrapping::Configuration;

/// Signals of one shot of each configuration, for charts.
#[derive(Debug, Clone)]
pub struct ShotSignals {
    /// Its configuration.
    pub configuration: Configuration,
    /// Sampling rate \[1/s\].
    pub rate: f64,
    /// Pressure at the first microphone from 10 ms before the trigger onwards \[Pa\].
    pub microphone: Vec<f64>,
    /// Acceleration of each accelerometer over the same time \[m/s2\].
    pub accelerations: Vec<Vec<f64>>,
    /// Pressure of each transducer over the same time \[Pa\].
    pub pressures: Vec<Vec<f64>>,
    /// Its markers.
    pub markers: Markers,
}

/// Energies of one shot: mean exposures over the microphones \[Pa2 s\].
#[derive(Debug, Clone, Default)]
pub(super) struct Energies {
    pub(super) whole: f64,
    pub(super) bands: Vec<f64>,
    /// The markers on either side, their times \[s\], and the energy between them.
    pub(super) intervals: Vec<IntervalEnergy>,
}

#[derive(Debug, Clone)]
pub(super) struct IntervalEnergy {
    pub(super) names: [&'static str; 2],
    pub(super) seconds: [f64; 2],
    pub(super) energy: f64,
}

/// One shot after processing.
pub(super) struct ProcessedShot {
    pub(super) raw: Energies,
    pub(super) corrected: Option<Energies>,
    pub(super) zeroed: f64,
    pub(super) before_trigger: f64,
    pub(super) markers: Markers,
    pub(super) accelerations: Vec<(f64, f64)>,
    /// Time from the record's start to the trigger \[s\].
    pub(super) lead: f64,
    /// Time after the trigger at which the burst of t12 occurs at the device's centre, according to the microphones
    /// \[s\]; none if the body is wrapped or t12 is missing.
    pub(super) arrival: Option<f64>,
}

/// Residual of a test: mean squares of the lines at each microphone, averaged over all shots or for each shot.
pub(super) struct Residual {
    /// By repeat (one for the mean), microphone and line \[Pa2 s2\].
    pub(super) squares: Vec<Vec<Vec<f64>>>,
    /// Number of shots behind each mean.
    pub(super) shots: u32,
}

impl Residual {
    pub(super) fn of(&self, repeat: usize) -> &[Vec<f64>] {
        &self.squares[repeat % self.squares.len()]
    }
}

/// Data shared by all shots of a test.
pub(super) struct Context<'a> {
    pub(super) arrangement: &'a Arrangement,
    pub(super) processing: Processing,
    pub(super) transform: OneSecond,
    pub(super) bands: Bands,
    pub(super) travel: Vec<f64>,
}

impl<'a> Context<'a> {
    pub(super) fn new(arrangement: &'a Arrangement, processing: Processing, rate: f64) -> Self {
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
    pub(super) fn lines(&self, shot: &Shot) -> Vec<Vec<Complex<f64>>> {
        let of = |record: &Vec<f64>| self.transform.lines(&self.transform.cut(record, shot.trigger));
        shot.microphones.par_iter().map(of).collect()
    }

    pub(super) fn accumulate_residual(&self, residual: &mut Residual, lines: &[Vec<Complex<f64>>], repeats: usize) {
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

    /// Energies of a shot of a configuration, as recorded and after subtraction of a residual, and its corrected
    /// signals.
    pub(super) fn process(
        &self,
        configuration: Configuration,
        shot: &Shot,
        lines: &[Vec<Complex<f64>>],
        residual: Option<&[Vec<f64>]>,
    ) -> (ProcessedShot, Option<Vec<Vec<f64>>>) {
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
        let processed = ProcessedShot {
            before_trigger: signals
                .as_ref()
                .map_or(0.0, |signals| self.share_before_trigger(signals)),
            raw,
            corrected: after,
            zeroed,
            markers,
            accelerations: self.accelerations(shot),
            lead: shot.trigger,
            arrival: markers
                .t12
                .filter(|_| configuration == Configuration::Body)
                .and_then(|burst| {
                    let expected: Vec<f64> = self.travel.iter().map(|travel| shot.trigger + burst + travel).collect();
                    Some(burst + arrival(&shot.microphones, shot.rate, &expected)?)
                }),
        };
        (processed, signals)
    }

    /// Subtracts a residual from the lines. Also returns the share of the A-weighted energy that was set to zero.
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

    /// Mean exposures over the microphones; those of intervals need the signals.
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

    /// Energies between consecutive markers. The signal of each microphone is advanced by its travel time.
    fn intervals(&self, signals: &[Vec<f64>], markers: &Markers) -> Vec<IntervalEnergy> {
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
            IntervalEnergy {
                names: [pair[0].0, pair[1].0],
                seconds: [pair[0].1, pair[1].1],
                energy: energy / signals.len().max(1) as f64,
            }
        };
        found.windows(2).map(between).collect()
    }

    /// Share of the signals' energy before the trigger.
    fn share_before_trigger(&self, signals: &[Vec<f64>]) -> f64 {
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
        let acceleration = |parts: &[Part]| {
            let place = self.arrangement.accelerometer(parts)?;
            shot.accelerations.get(place).map(Vec::as_slice)
        };
        let cylinder = self.arrangement.transducer("PT-I");
        let signals = Signals {
            handle: acceleration(&[Part::Handle]),
            block: acceleration(&[Part::Block, Part::BoxEdge]),
            table: acceleration(&[Part::Table]),
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

    pub(super) fn signals(&self, configuration: Configuration, shot: &Shot, markers: Markers) -> ShotSignals {
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
