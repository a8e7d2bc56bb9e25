//! A run: the outputs of the chain, the ranking of the sources, checks and notes.

use std::sync::Arc;

use nailnoise_acoustics::levels::{SourceSpectrum, Weighting, energy_level};
use nailnoise_dynamics::CycleRecord;

use crate::chain::{Chain, Options};
use crate::declaration;
use crate::design::inputs::{self, located};
use crate::design::{Design, SupportKind};
use crate::error::Error;
use crate::graph::Graph;
use crate::headline::{headline, sentence};
use crate::result::{Check, DesignId, FluidLoadingChange, RunResult, RunStudy, SCHEMA};
use crate::stages::bodies::{FoundSurface, Origin};
use crate::stages::convention::{counted, received, spectrum_with};
use crate::stages::microphones::Microphones;
use crate::stages::ranking::SoundPower;
use crate::stages::sensors::SensorRecord;
use crate::stages::transducers::PressureRecord;
use crate::stages::truncation::Truncation;
use crate::stages::{Input, Stored, changes, notes, ranking};

/// A result with its histories.
pub struct Run {
    /// The ranked sources with events, checks and notes.
    pub result: RunResult,
    /// The nailing cycle.
    pub record: Arc<CycleRecord>,
    /// A-weighted sound power of every source over time, loudest source first.
    pub powers: Vec<SoundPower>,
    /// Screech frequency of the exhaust's jets at every sample of the cycle \[Hz\]; none while they are subsonic.
    pub screech: Vec<Option<f64>>,
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

/// Why a run that nobody has told of a study states no intervals.
const UNKNOWN: &str = "no study was looked for";

impl RunResult {
    /// States the intervals of a study in the result: they decide K. A contradiction of the design and its draws is a
    /// check that fails, in front of the others.
    pub fn state_study(&mut self, study: RunStudy) {
        let before = self.study.contradiction();
        self.checks
            .retain(|check| before.as_ref().is_none_or(|own| own.name != check.name));
        self.checks.splice(0..0, study.contradiction());
        self.declaration = declaration::declaration(self.total.lwa_db, &self.ear, &study);
        self.study = study;
    }

    /// The checks of the computation, without that of the design against its draws.
    pub fn numerical_checks(&self) -> impl Iterator<Item = &Check> {
        let contradiction = self.study.contradiction();
        let own = move |check: &&Check| contradiction.as_ref().is_none_or(|other| other.name != check.name);
        self.checks.iter().filter(own)
    }
}

impl Chain {
    /// Everything that the result of a run reads.
    pub fn outputs(&self) -> Vec<&dyn Input> {
        let mut all: Vec<&dyn Input> = vec![
            &self.workpiece,
            &self.body,
            &self.exhaust,
            &self.sensors,
            &self.response_report,
        ];
        all.extend(self.starts.iter().map(|starts| starts as &dyn Input));
        all.extend(self.tool_report.iter().map(|report| report as &dyn Input));
        if let Some(one_way) = &self.one_way {
            let sources: [&dyn Input; 4] = [&one_way.report, &one_way.workpiece, &one_way.exhaust, &one_way.body];
            all.extend(sources);
        }
        if let Some(loading) = &self.loading {
            all.extend(loading.workpiece.iter().map(|energy| energy as &dyn Input));
            all.extend(loading.body.iter().flatten().map(|energy| energy as &dyn Input));
            all.extend(loading.report.iter().map(|report| report as &dyn Input));
        }
        all
    }

    /// Levels of linear motion with the frozen and the complete impedance of the air.
    fn fluid_loading_changes(&self, range_hz: [f64; 2]) -> Result<Vec<FluidLoadingChange>, Error> {
        let Some(loading) = &self.loading else {
            return Ok(Vec::new());
        };
        let energy = |spectrum: &SourceSpectrum| spectrum.energy(range_hz, Weighting::A);
        let change = |source: &str, [frozen, complete]: [f64; 2], complete_acts| FluidLoadingChange {
            source: source.to_owned(),
            frozen_lwa_db: energy_level(frozen),
            complete_lwa_db: energy_level(complete),
            complete_acts,
        };
        let [frozen, complete] = &loading.workpiece;
        let workpiece = [energy(&*frozen.get()?), energy(&*complete.get()?)];
        let mut changes = vec![change("workpiece", workpiece, loading.workpiece_is_linear)];
        if let Some([frozen, complete]) = &loading.body {
            // The cap counts to the housing here, in any convention.
            let whole = |(rest, cap): &(SourceSpectrum, Option<SourceSpectrum>)| {
                energy(rest) + cap.as_ref().map_or(0.0, energy)
            };
            changes.push(change("body", [whole(&*frozen.get()?), whole(&*complete.get()?)], true));
        }
        Ok(changes)
    }

    /// Makes the outputs of the stages and ranks the sources. `design` is the design of the chain.
    ///
    /// # Errors
    /// [`Error`] of the stage that could not be computed.
    pub fn run(&self, design: &Design) -> Result<Run, Error> {
        self.ranked(design).map_err(|error| located(design, error))
    }

    /// Surfaces of the bodies that the program recognised.
    fn guessed(&self) -> Result<Vec<String>, Error> {
        let mut guessed = Vec::new();
        for usable in &self.usable {
            let usable = usable.get()?;
            let own = usable.surfaces.iter().filter(|surface| surface.origin == Origin::Guess);
            guessed.extend(own.map(FoundSurface::in_words));
        }
        Ok(guessed)
    }

    /// Checks the requirements of a run on its bodies, before any is solved.
    ///
    /// # Errors
    /// Those of meshes, and of bodies that a run cannot use.
    pub(crate) fn check_bodies(&self) -> Result<(), Error> {
        let usable: Vec<&dyn Input> = self.usable.iter().map(|usable| usable as &dyn Input).collect();
        self.graph.prepare(&usable)
    }

    fn ranked(&self, design: &Design) -> Result<Run, Error> {
        self.check_bodies()?;
        self.graph.prepare(&self.outputs())?;
        let progress = self.graph.progress();
        let (record, end) = (self.cycle.get()?, *self.end.get()?);
        let (workpiece, body, exhaust) = (self.workpiece.get()?, self.body.get()?, self.exhaust.get()?);
        let (response, sensors) = (self.response_report.get()?, self.sensors.get()?);
        let transducers = self.transducers.get()?;
        let tool = self.tool_report.as_ref().map(Stored::get).transpose()?;
        let starts = match &self.starts {
            Some(starts) => Option::clone(&*starts.get()?),
            None => None,
        };
        let fluid_loading_changes =
            self.fluid_loading_changes([design.analysis.range_low, design.analysis.range_high])?;
        let truncations: Vec<&Truncation> = workpiece.truncations.iter().chain(&body.truncations).collect();
        let parameters = inputs::cycle::parameters(design)?;
        let headline = headline(&self.graph, design, &record)?;
        let notes = notes::notes(
            &notes::NoteInputs {
                shot: headline
                    .as_ref()
                    .map_or_else(|| sentence(&record, &parameters), |own| own.text.clone()),
                support: &inputs::notes::support(design),
                in_sand: design.support.kind == SupportKind::Sandbox,
                range_high: design.analysis.range_high,
                radiation: [&workpiece, &body].map(|source| source.source.radiation.as_ref()),
                fluid_loading_changes: &fluid_loading_changes,
                stiffness: tool.as_ref().map(|tool| &tool.stiffness),
                truncations: truncations.iter().map(|truncation| truncation.note()).collect(),
                ending: &response.ending,
                idle_sensors: inputs::sensors::without_body(design),
                limited_sensors: inputs::sensors::limited(design),
                fitted_law: inputs::notes::fitted_law(design, &record)?,
                outside_ranges: inputs::notes::outside_ranges(design),
                exhaust_top: inputs::notes::exhaust_top(design),
                idle_springs: design.idle_springs(),
                idle_surfaces: design.idle_surfaces(),
                guessed: self.guessed()?,
                convention: inputs::notes::convention(design),
            },
            &record,
            &inputs::exhaust::openings(design)?,
            &exhaust.details,
        );
        notes.shot.iter().for_each(|note| progress.note(note));
        let range_hz = [design.analysis.range_low, design.analysis.range_high];
        let (cap, vent) = (body.moved.as_ref(), exhaust.vent.as_ref());
        let parts = [cap, vent].map(|part| part.map(|part| &part.source));
        let [exhaust_source, body_source] = counted([&exhaust.source, &body.source], parts, range_hz);
        let sources = [&workpiece.source, &exhaust_source, &body_source];
        let (mut ranking, total) = ranking::rank(&sources, range_hz);
        let microphones = self.graph.time("microphones", || {
            let array = inputs::microphones::array(design)?;
            let (workpiece, _) = array.complete((&workpiece.source, &workpiece.received), None, (self.noise_seed, 0));
            let [vent, cap] = [vent, cap].map(|part| part.map(|part| (&part.source, &part.received)));
            let (exhaust, vent) = array.complete((&exhaust.source, &exhaust.received), vent, (self.noise_seed, 1));
            let (body, cap) = array.complete((&body.source, &body.received), cap, (self.noise_seed, 2));
            let [exhaust, body] = received([&exhaust, &body], [cap.as_ref(), vent.as_ref()]);
            array.measurement(&inputs::microphones::room(design), [&workpiece, &exhaust, &body])
        })?;
        let powers = ranking::powers(&ranking, &sources, end);
        let interval_checks = ranking::interval_checks(&ranking, &sources, design.acoustics.bem_tolerance);
        let coupling = self.one_way.as_ref().map(|one_way| {
            let report = one_way.report.get()?;
            let (exhaust, body) = (one_way.exhaust.get()?, one_way.body.get()?);
            let vent = exhaust.vent.as_ref().map(|vent| &vent.source.spectrum);
            let own = [(&exhaust.source.spectrum, body.1.as_ref()), (&body.0, vent)];
            let [exhaust, body] = own.map(|(source, part)| spectrum_with(source, part));
            let lumped = [SourceSpectrum::clone(&*one_way.workpiece.get()?), exhaust, body];
            let (before, after) = ((&*one_way.cycle.get()?, &lumped[..]), (&*record, &ranking[..], &total));
            let changes = changes::changes(report.work, before, after, range_hz);
            Ok::<_, Error>((changes, report.checks.clone()))
        });
        let (coupling, coupling_checks) = coupling.transpose()?.unzip();
        let mut checks = record.checks.clone();
        checks.extend(response.checks.iter().cloned());
        checks.extend(coupling_checks.into_iter().flatten());
        if let Some(report) = self.loading.as_ref().and_then(|loading| loading.report.as_ref()) {
            checks.extend(
                report
                    .get()?
                    .checks
                    .iter()
                    .map(|check| check.clone().of("bonded for comparison")),
            );
        }
        checks.extend(tool.iter().flat_map(|tool| tool.checks.clone()));
        checks.extend(truncations.iter().map(|truncation| truncation.check()));
        checks.extend([&workpiece, &body].into_iter().filter_map(|source| source.check()));
        checks.extend(ranking::checks(&ranking, &total));
        checks.extend(interval_checks);
        checks.extend(exhaust.details.checks());
        if let Some(starts) = &starts {
            ranking::widen(&mut ranking, starts);
        }
        let study = RunStudy::absent(UNKNOWN);
        let mut timing = self.graph.timing();
        timing.end(self.begin.elapsed());
        let result = RunResult {
            schema: SCHEMA,
            design: DesignId::from(design),
            inputs: design.entries().into_iter().map(Into::into).collect(),
            ranking,
            total,
            outcome: record.outcome,
            headline,
            cycle: record.summary.clone(),
            events: record.events,
            coupling,
            fluid_loading_changes,
            starts,
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
            screech: exhaust.details.screech.clone(),
            sensors,
            transducers,
            microphones,
        })
    }
}
