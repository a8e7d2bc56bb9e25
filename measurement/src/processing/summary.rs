//! Combined results of all shots of a test: levels with uncertainty, sources, bound, closure, notes.

use super::shots::{Energies, IntervalEnergy, ProcessedShot};
use crate::arrangement::Arrangement;
use crate::lines::BEFORE;
use crate::markers::{AT_MICROPHONES, MARKERS, Marker, MarkerEvents};
use crate::repeats::RepeatedLevel;
use crate::result::{
    MeasuredAcceleration, MeasuredBand, MeasuredBound, MeasuredConfiguration, MeasuredInterval, MeasuredMarker,
    MeasuredSource, MeasurementResult, Processing, SCHEMA,
};
use crate::subtraction::{SURVEY_LIMIT_DB, expected_energy};
use crate::wrapping::{Configuration, Role};

/// Smallest number of repeats in a test (EN 12549).
pub const LEAST_REPEATS: usize = 5;

/// A configuration that was recorded.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Recorded {
    /// Which.
    pub configuration: Configuration,
    /// Number of its shots.
    pub repeats: usize,
}

/// Level above the residual below which a source counts as not measured \[dB\].
const LEAST_ABOVE: f64 = 3.0;

/// Largest difference between the travel times to a microphone from parts of the device and from its centre \[s\].
const PATHS: f64 = 1.5e-3;

/// Processed shots of all configurations.
pub(super) struct Summary<'a> {
    pub(super) arrangement: &'a Arrangement,
    pub(super) room: f64,
    pub(super) processing: Processing,
    /// Nominal mid-band frequencies \[Hz\].
    pub(super) hz: Vec<f64>,
    pub(super) residual_shots: u32,
    /// Anomalies of individual channels.
    pub(super) channels: Vec<String>,
    pub(super) all: Vec<(Recorded, Vec<ProcessedShot>, Vec<Option<f64>>)>,
}

impl Summary<'_> {
    pub(super) fn result(&self) -> MeasurementResult {
        let sources: Vec<MeasuredSource> = self
            .all
            .iter()
            .filter_map(|(one, shots, _)| self.source(*one, shots))
            .collect();
        let level_of = |role: Role| {
            sources
                .iter()
                .find(|own| own.source == role.name())
                .and_then(|own| own.level)
        };
        let closure = self.total().and_then(|total| {
            let parts = Role::ALL.map(level_of);
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
        let mut found: Vec<([&'static str; 2], Vec<&IntervalEnergy>)> = Vec::new();
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

    /// Energies as recorded, averaged over microphones and repeats: for the complete range and for each band.
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
        (one, shots, delays): &(Recorded, Vec<ProcessedShot>, Vec<Option<f64>>),
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
            markers: markers(shots, &self.arrangement.events),
            delays_s: delays.clone(),
        }
    }

    fn source(&self, one: Recorded, shots: &[ProcessedShot]) -> Option<MeasuredSource> {
        let role = one.configuration.source()?;
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
            source: role.name().to_owned(),
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

    /// The total: as recorded, or minus the residual if requested.
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
        let of = |role: Role| sources.iter().find(|own| own.source == role.name());
        let (exhaust, body) = (of(Role::Exhaust)?, of(Role::Body)?);
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
        let mut notes = self.channels.clone();
        for (one, ..) in self.all.iter().filter(|(one, ..)| one.repeats < LEAST_REPEATS) {
            notes.push(format!(
                "{}: {} repeats; EN 12549 requires {LEAST_REPEATS}",
                name(one),
                one.repeats
            ));
        }
        for (one, shots, _) in &self.all {
            let late = shots.iter().filter(|shot| shot.lead < BEFORE * (1.0 - 1e-6)).count();
            if late > 0 {
                notes.push(format!(
                    "{}: {late} of {} records begin less than {:.0} ms before the trigger, so that the start of the \
                     shot may be \
                     missing: record earlier",
                    name(one),
                    shots.len(),
                    1e3 * BEFORE
                ));
            }
        }
        for one in self.all.iter().map(|one| self.configuration(one)) {
            if let Some(above) = one.above_residual_db.filter(|above| *above < LEAST_ABOVE) {
                notes.push(format!(
                    "{}: {above:.1} dB above the residual; below {LEAST_ABOVE:.0} dB its source is not measured, the \
                     level shown is the floor",
                    one.name
                ));
            }
            let at = |name: &str| one.markers.iter().find(|own| own.name == name).map(|own| own.seconds);
            let late = at(AT_MICROPHONES.name)
                .zip(at("t12"))
                .map(|(arrived, burst)| arrived - burst);
            if let Some(late) = late.filter(|late| late.abs() > PATHS) {
                notes.push(format!(
                    "{}: the microphones put the burst t12 {:+.1} ms from where the handle puts it, more than the \
                     {:.1} ms that the \
                     paths of the sound explain: check that microphones and accelerometers share a clock, and the \
                     positions",
                    one.name,
                    1e3 * late,
                    1e3 * PATHS
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
                    "{}: {:.1} dB lies at the floor of the subtraction, {floor:.1} dB; the source may be anything \
                     below",
                    own.source, level.db
                ));
            }
        }
        if sources.iter().any(|own| own.source == Role::Workpiece.name()) && self.total().is_some() {
            notes.push(
                "the workpiece bare is masked by the body's wrap; the bound holds whatever the wraps hide, unless the \
                 bias of \
                 exhaust and body is larger (see the levels by energy)"
                    .to_owned(),
            );
        }
        notes
    }
}

/// Mean markers of shots.
fn markers(shots: &[ProcessedShot], events: &MarkerEvents) -> Vec<MeasuredMarker> {
    let found = |shot: &ProcessedShot, marker: &Marker| match marker.name {
        name if name == AT_MICROPHONES.name => shot.arrival,
        name => shot
            .markers
            .found()
            .into_iter()
            .find(|own| own.0 == name)
            .map(|own| own.1),
    };
    let of = |marker: &Marker| {
        let found: Vec<f64> = shots.iter().filter_map(|shot| found(shot, marker)).collect();
        let count = found.len();
        let mean = found.iter().sum::<f64>() / count as f64;
        let squares: f64 = found.iter().map(|at| (at - mean).powi(2)).sum();
        (count > 0).then(|| MeasuredMarker {
            name: marker.name.to_owned(),
            event: events.of(marker.name).map(str::to_owned),
            meaning: marker.meaning.to_owned(),
            repeats: count,
            seconds: mean,
            deviation_s: (count > 1).then(|| (squares / (count - 1) as f64).sqrt()),
        })
    };
    MARKERS.iter().chain([&AT_MICROPHONES]).filter_map(of).collect()
}
