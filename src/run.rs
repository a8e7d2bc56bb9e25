//! A run: the outputs of the chain, the ranking of the sources, checks and notes.

use std::sync::Arc;

use nailnoise_acoustics::signals::{SourceSpectrum, Weighting, energy_level};

use crate::chain::{Chain, Options, RecordedBody};
use crate::declaration;
use crate::design::Design;
use crate::design::inputs::{self, located};
use crate::error::Error;
use crate::graph::Graph;
use crate::headline::{headline, sentence};
use crate::model::sources::{ImpedanceComparison, SourceStages};
use crate::result::{Check, DesignId, FluidLoadingChange, Performance, RunResult, RunStudy, SCHEMA, Starts};
use crate::stages::apart::Apart;
use crate::stages::bodies::{FoundSurface, Origin};
use crate::stages::convention::{counted, received, spectra};
use crate::stages::cycle::{Engine, EventTimes, EventWords, ShotRecord};
use crate::stages::microphones::{AtMicrophones, Microphones};
use crate::stages::notes::SourceNotes;
use crate::stages::ranking::SoundPower;
use crate::stages::sensors::SensorRecord;
use crate::stages::sound::{SoundSource, SourceHistory};
use crate::stages::sources::SourceSound;
use crate::stages::transducers::PressureRecord;
use crate::stages::truncation::Truncation;
use crate::stages::{Input, Stored, changes, notes, ranking};

/// A result with its histories.
pub struct Run {
    /// The ranked sources with events, checks and notes.
    pub result: RunResult,
    /// The nailing cycle.
    pub record: Arc<ShotRecord>,
    /// A-weighted sound power of every source over time, loudest source first.
    pub powers: Vec<SoundPower>,
    /// Quantities of the sources at every sample of the cycle.
    pub histories: Vec<SourceHistory>,
    /// Signals of the design's sensors, by name.
    pub sensors: Arc<Vec<SensorRecord>>,
    /// Signals of the design's pressure transducers, by name.
    pub transducers: Arc<Vec<PressureRecord>>,
    /// Sound at microphones around the device, source by source.
    pub microphones: Microphones,
}

/// Predicts and ranks the sound power of a design's sources.
///
/// # Errors
/// [`Error`] of the stage that could not be computed.
pub fn run(graph: &Graph, design: &Design, options: Options) -> Result<Run, Error> {
    Chain::new(graph, design, options)?.run(design)
}

/// Reason why a run states no intervals if no study was looked for.
const UNKNOWN: &str = "no study was looked for";

impl RunResult {
    /// States the intervals of a study in the result; they determine K. If the design contradicts its draws, a failed
    /// check is inserted before the others.
    pub fn state_study(&mut self, study: RunStudy) {
        let before = self.study.contradiction();
        self.checks
            .retain(|check| before.as_ref().is_none_or(|own| own.name != check.name));
        self.checks.splice(0..0, study.contradiction());
        self.declaration = declaration::declaration(self.total.lwa_db, &self.ear, &study);
        self.study = study;
    }

    /// The checks of the computation, without the check of the design against its draws.
    pub fn numerical_checks(&self) -> impl Iterator<Item = &Check> {
        let contradiction = self.study.contradiction();
        let own = move |check: &&Check| contradiction.as_ref().is_none_or(|other| other.name != check.name);
        self.checks.iter().filter(own)
    }
}

impl Chain {
    /// Everything that the result of a run reads.
    pub fn outputs(&self) -> Vec<&dyn Input<Error>> {
        let mut all: Vec<&dyn Input<Error>> = vec![&self.motion, &self.sensors];
        all.extend(self.efficiencies.iter().map(|own| own as &dyn Input<Error>));
        all.extend(self.response_report.iter().map(|report| report as &dyn Input<Error>));
        all.extend(self.sources.iter().flat_map(SourceStages::outputs));
        all.extend(self.tool_report.iter().map(|report| report as &dyn Input<Error>));
        all.extend(self.one_way.iter().map(|one_way| &one_way.report as &dyn Input<Error>));
        all
    }

    /// Levels of linear motion with the frozen and the complete impedance of the air.
    fn fluid_loading_changes(&self, range_hz: [f64; 2]) -> Result<Vec<FluidLoadingChange>, Error> {
        // In any convention, a part is assigned here to the source that makes it.
        let level = |energy: &Stored<Apart<SourceSpectrum>>| {
            let energy = energy.get()?;
            let parts = energy.parts().into_iter();
            Ok::<_, Error>(energy_level(
                parts.map(|part| part.energy(range_hz, Weighting::A)).sum(),
            ))
        };
        let compared = self.sources.iter().filter_map(|own| {
            let impedance = own.compared.impedance.as_ref()?;
            Some((own.source.name(), impedance))
        });
        let change = |(source, impedance): (&str, &ImpedanceComparison)| {
            Ok(FluidLoadingChange {
                source: source.to_owned(),
                frozen_lwa_db: level(&impedance.frozen)?,
                complete_lwa_db: level(&impedance.complete)?,
                complete_acts: impedance.complete_acts,
            })
        };
        compared.map(change).collect()
    }

    /// Energies of the sources in the same shot, computed one way.
    fn one_way_energies(&self) -> Result<Vec<SourceSpectrum>, Error> {
        let energies = self.sources.iter().filter_map(|own| own.compared.one_way.as_ref());
        let energies = energies.map(|energy| Ok(Apart::clone(&*energy.get()?)));
        Ok(spectra(&energies.collect::<Result<Vec<_>, Error>>()?))
    }

    /// Levels from other starts of a source that can lose contact, with the name of the source.
    fn starts(&self) -> Result<Option<(&'static str, Starts)>, Error> {
        for own in &self.sources {
            if let Some(starts) = &own.compared.starts
                && let Some(starts) = &*starts.get()?
            {
                return Ok(Some((own.source.name(), starts.clone())));
            }
        }
        Ok(None)
    }

    /// Makes the outputs of the stages and ranks the sources. `design` is the design of the chain.
    ///
    /// # Errors
    /// [`Error`] of the stage that could not be computed.
    pub fn run(&self, design: &Design) -> Result<Run, Error> {
        self.ranked(design).map_err(|error| located(design, error))
    }

    /// Surfaces of the bodies that the program has recognised.
    fn guessed(&self) -> Result<Vec<String>, Error> {
        let mut guessed = Vec::new();
        for usable in &self.usable {
            let usable = usable.get()?;
            let own = usable.surfaces.iter().filter(|surface| surface.origin == Origin::Guess);
            guessed.extend(own.map(FoundSurface::in_words));
        }
        Ok(guessed)
    }

    /// Checks the requirements of a run on its bodies, before any of them is solved.
    ///
    /// # Errors
    /// The errors of meshes, of bodies that a run cannot use, and of surfaces that do not agree with their records.
    pub(crate) fn check_bodies(&self) -> Result<(), Error> {
        let usable: Vec<&dyn Input<Error>> = self.usable.iter().map(|usable| usable as &dyn Input<Error>).collect();
        self.graph.prepare(&usable)?;
        self.recorded.iter().try_for_each(RecordedBody::check)
    }

    /// Every source at the microphones and at the operator's ear. `design` is the design of the chain, or one with the
    /// same bodies and air.
    ///
    /// # Errors
    /// [`Error`] of the stage that could not be computed.
    pub(crate) fn received(&self, design: &Design) -> Result<Vec<AtMicrophones>, Error> {
        let array = inputs::microphones::array(design)?;
        let complete = (0..).zip(&self.sources).map(|(number, own)| {
            let sound = own.sound.get()?;
            Ok::<_, Error>(array.complete(&sound.heard, self.noise_seed, number))
        });
        Ok(received(&complete.collect::<Result<Vec<_>, Error>>()?))
    }

    fn ranked(&self, design: &Design) -> Result<Run, Error> {
        self.check_bodies()?;
        self.graph.prepare(&self.outputs())?;
        let progress = self.graph.progress();
        let (record, end) = (self.cycle.get()?, *self.end.get()?);
        let sounds = self.sources.iter().map(|own| own.sound.get());
        let sounds: Vec<Arc<SourceSound>> = sounds.collect::<Result<_, Error>>()?;
        let response = self.response_report.as_ref().map(Stored::get).transpose()?;
        let (motion, sensors) = (self.motion.get()?, self.sensors.get()?);
        let transducers = self.transducers.get()?;
        let tool = self.tool_report.as_ref().map(Stored::get).transpose()?;
        let mut efficiencies = Vec::new();
        for own in &self.efficiencies {
            efficiencies.extend(own.get()?.iter().cloned());
        }
        let starts = self.starts()?;
        let range_hz = [design.analysis.range_low, design.analysis.range_high];
        let fluid_loading_changes = self.fluid_loading_changes(range_hz)?;
        let truncations: Vec<&Truncation> = sounds.iter().flat_map(|sound| &sound.truncations).collect();
        let named = self.sources.iter().zip(&sounds);
        let of_sources = named.clone().map(|(own, sound)| (own.notes)(sound));
        let absent = SourceNotes {
            shot: inputs::assembly::absent_sources(&self.engine)
                .into_iter()
                .chain(inputs::notes::idle_records(design))
                .collect(),
            methods: Vec::new(),
        };
        let fluid_loading = named.filter_map(|(own, sound)| {
            let report = sound.source().radiation.as_ref()?;
            Some((own.source.name(), report.fluid_loading.as_ref()?))
        });
        let (headline, sentence, performance) = match (record.of_nailer(), &self.engine) {
            (Some(shot), _) => {
                let parameters = inputs::cycle::parameters(design)?;
                (
                    headline(&self.graph, design, shot)?,
                    sentence(shot, &parameters),
                    Some(Performance::of(shot.figures, &parameters)),
                )
            }
            (None, Engine::Assembly(cycle)) => {
                let performance = Performance::of_assembly(&record.record, &cycle.assembly, &design.ambient);
                (None, inputs::notes::outcome_of_assembly(&record), Some(performance))
            }
            (None, Engine::Keys(_)) => (None, inputs::notes::outcome_of_assembly(&record), None),
        };
        let notes = notes::notes(
            &notes::NoteInputs {
                shot: headline.as_ref().map_or(sentence, |own| own.text.clone()),
                sources: of_sources.chain([Ok(absent)]).collect::<Result<_, Error>>()?,
                fluid_loading: fluid_loading.collect(),
                fluid_loading_changes: &fluid_loading_changes,
                truncations: truncations.iter().map(|truncation| truncation.note()).collect(),
                ending: response.as_ref().map(|own| own.ending.as_str()),
                idle_sensors: inputs::sensors::without_body(design),
                idle_transducers: inputs::sensors::without_chamber(design)?,
                limited_sensors: inputs::sensors::limited(design),
                fitted_law: inputs::notes::fitted_law(design, &record)?,
                landing_keys: inputs::assembly::landing_keys(design)?,
                outside_ranges: inputs::notes::outside_ranges(design),
                idle_springs: design.idle_springs(),
                idle_surfaces: design.idle_surfaces(),
                guessed: self.guessed()?,
                convention: inputs::notes::convention(design),
            },
            &record,
        );
        notes.shot.iter().for_each(|note| progress.note(note));
        let analysed: Vec<Apart<&SoundSource>> = sounds
            .iter()
            .map(|sound| sound.heard.map(|heard| &heard.source))
            .collect();
        let counted = counted(&analysed, range_hz);
        let sources: Vec<&SoundSource> = counted.iter().collect();
        let (mut ranking, total) = ranking::rank(&sources, range_hz);
        let microphones = self.graph.time("microphones", || {
            let array = inputs::microphones::array(design)?;
            array.measurement(&inputs::microphones::room(design), &self.received(design)?)
        })?;
        let powers = ranking::powers(&ranking, &sources, end);
        let interval_checks = ranking::interval_checks(&ranking, &sources, design.acoustics.bem_tolerance);
        let coupling = self.one_way.as_ref().map(|one_way| {
            let report = one_way.report.get()?;
            let lumped = self.one_way_energies()?;
            let (before, after) = ((&*one_way.cycle.get()?, &lumped[..]), (&*record, &ranking[..], &total));
            let changes = changes::changes(report.work, before, after, range_hz);
            Ok::<_, Error>((changes, report.checks.clone()))
        });
        let (coupling, coupling_checks) = coupling.transpose()?.unzip();
        let mut checks = record.checks.clone();
        checks.extend(response.iter().flat_map(|own| own.checks.iter().cloned()));
        checks.extend(coupling_checks.into_iter().flatten());
        let impedances = self.sources.iter().filter_map(|own| own.compared.impedance.as_ref());
        for bonded in impedances.filter_map(|own| own.report.as_ref()) {
            let bonded = bonded.get()?;
            let of_bonded = bonded.checks.iter();
            checks.extend(of_bonded.map(|check| check.clone().of("bonded for comparison")));
        }
        checks.extend(tool.iter().flat_map(|tool| tool.checks.clone()));
        checks.extend(truncations.iter().map(|truncation| truncation.check()));
        checks.extend(sounds.iter().filter_map(|sound| sound.source().surface_check()));
        checks.extend(ranking::checks(&ranking, &total));
        checks.extend(interval_checks);
        checks.extend(sounds.iter().flat_map(|sound| sound.checks.iter().cloned()));
        if let Some((source, starts)) = &starts {
            ranking::widen(&mut ranking, source, starts);
        }
        let study = RunStudy::absent(UNKNOWN);
        let mut timing = self.graph.timing();
        timing.end(self.begin.elapsed());
        let result = RunResult {
            schema: SCHEMA,
            design: DesignId::from(design),
            inputs: design.entries().into_iter().map(Into::into).collect(),
            assembly: design.assembly_fields(),
            ranking,
            total,
            outcome: record.outcome.clone(),
            headline,
            cycle: record.figures.clone(),
            performance,
            events: EventTimes(record.events.clone()),
            event_words: EventWords::of(&record.events),
            coupling,
            fluid_loading_changes,
            radiation_efficiencies: efficiencies,
            motion: motion.to_vec(),
            starts: starts.map(|(_, starts)| starts),
            sensors: sensors.iter().map(SensorRecord::level).collect(),
            transducers: transducers.iter().map(PressureRecord::range).collect(),
            microphones: microphones.report.clone(),
            ear: microphones.ear.clone(),
            declaration: declaration::declaration(total.lwa_db, &microphones.ear, &study),
            study,
            checks,
            notes: notes.shot,
            method_notes: notes.methods,
            timing,
        };
        Ok(Run {
            result,
            record,
            powers,
            histories: sounds
                .iter()
                .flat_map(|sound| sound.histories.iter().cloned())
                .collect(),
            sensors,
            transducers,
            microphones,
        })
    }
}
