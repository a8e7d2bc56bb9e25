//! Contents of a run's result: the ranked sources, the events, the checks and the time each stage took.
//!
//! The JSON Schema of `run --json` and of `result.json` is derived from these types.

mod design_id;
mod performance;
mod study;

use std::borrow::Cow;
use std::collections::BTreeMap;

use crate::stages::cycle::{EventTimes, EventWords, ShotRecord, SummaryFigures};
pub use nailnoise_acoustics::radiation::radiator::{
    FluidLoading, Loading, ModeShare, RadiationBand, RadiationReport, Uncertainty,
};
use nailnoise_acoustics::signals::level_energy;
use nailnoise_dynamics::NailerFigures;
use nailnoise_dynamics::network::LedgerEntry;
use nailnoise_pipeline::Timing;
pub use nailnoise_quantities::Check;
use schemars::generate::SchemaSettings;
use schemars::transform::RecursiveTransform;
use schemars::{JsonSchema, Schema};
use serde::{Deserialize, Serialize};
use serde_json::Value;

use crate::design::Design;
use crate::stages::headline::Headline;
pub use crate::stages::modal_efficiency::{BodyEfficiencies, ModeEfficiency};
pub use crate::stages::motion_bands::{BandMotion, BodyBands};

pub use design_id::DesignId;
pub use performance::Performance;
pub(crate) use performance::{PerformanceFigure, free_air, free_volume, pressures};
pub use study::{DecidingInput, Ends, LevelSpread, NoStudy, OrderShare, Provided, RunStudy, StudySummary, Weighting};

/// Version of the layout of [`RunResult`]; it changes when a reader of the old layout would misread the new one.
pub const SCHEMA: &str = "nailnoise-run/1";

/// The result of `nailnoise run`. Levels are single-event levels in dB re 1 pW s, null for silence; all other numbers
/// are in SI units. Further keys may be added.
#[derive(Debug, Clone, Serialize, JsonSchema)]
#[schemars(title = "Result of nailnoise run")]
pub struct RunResult {
    /// Version of the layout; it changes when a reader of the old layout would misread the new one.
    #[schemars(extend("const" = SCHEMA))]
    pub schema: &'static str,
    /// The design of this result.
    pub design: DesignId,
    /// Every value of the design with its origin.
    pub inputs: Vec<Input>,
    /// Fields of the assembly that are no inputs by full name: formulas, names, switches and words, as the files give
    /// them. Absent for a design without an assembly.
    #[serde(skip_serializing_if = "BTreeMap::is_empty")]
    pub assembly: BTreeMap<String, String>,
    /// The sources, loudest first.
    pub ranking: Vec<RankedSource>,
    /// All sources together.
    pub total: Total,
    /// Intervals of the levels and P(first) from the draws of a study, or why they are not stated.
    pub study: RunStudy,
    /// Outcome of the shot: `drives`, `strikes_bumper`, `underdriven`, `overdriven`, `does_not_open`,
    /// `does_not_release` or `does_not_exhaust`; for an assembly the name of its outcome, or `unnamed` if none applies.
    pub outcome: String,
    /// If the nail is not driven or the exhaust does not open: the outcome, the figure by which the shot misses, and
    /// the inputs that would change it most. Absent for a shot that drives.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub headline: Option<Headline>,
    /// Figures of the shot.
    pub cycle: SummaryFigures,
    /// Reserve of the drive, air a shot, and rate; absent for an assembly.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub performance: Option<Performance>,
    /// Event times \[s\], t0..t18 or those that an assembly names; null where one does not occur.
    pub events: EventTimes,
    /// Descriptions of the events by name; absent for an assembly that gives none.
    #[serde(skip_serializing_if = "EventWords::is_empty")]
    pub event_words: EventWords,
    /// Effect of the structures on the shot and its sound, compared with a lumped workpiece; absent from a one-way run.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub coupling: Option<Coupling>,
    /// Levels of each source in linear motion with the air's impedance frozen at each mode's resonance, and with the
    /// complete one; absent unless the air's mass acts.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub fluid_loading_changes: Vec<FluidLoadingChange>,
    /// Radiation efficiencies of the modes of each elastic body, each mode alone at its natural frequency; empty for
    /// rigid bodies. Modes also radiate together, so that powers of single modes do not sum to that of the source.
    pub radiation_efficiencies: Vec<BodyEfficiencies>,
    /// Motion of the elastic bodies in one-third-octave bands over the whole shot; empty for rigid bodies.
    pub motion: Vec<BodyBands>,
    /// Scatter of the workpiece's level over several starts; absent from a run with one.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub starts: Option<Starts>,
    /// Measured values of the design's sensors, by name.
    pub sensors: Vec<SensorLevel>,
    /// Readings of the design's pressure transducers.
    pub transducers: Vec<TransducerRange>,
    /// Measurement by microphones around the device, for comparison with the radiated power.
    pub microphones: MicrophoneReport,
    /// Emission sound pressure at the operator's ear, for a declaration.
    pub ear: EarReport,
    /// The levels of a declaration.
    pub declaration: Declaration,
    /// Checks of every stage.
    pub checks: Vec<Check>,
    /// Notes for the reader on the shot, the values of the design, and sources that are only estimated.
    pub notes: Vec<String>,
    /// Ranges, errors and limits of the methods.
    pub method_notes: Vec<String>,
    /// Wall time of each stage and of the complete run \[s\]; some stages run in parallel.
    #[schemars(with = "BTreeMap<String, f64>")]
    pub timing: Timing,
}

impl RunResult {
    /// Text for the supply pressure, which designs may give either way; none for a tool without one.
    pub(crate) fn supply_in_words(&self) -> Option<String> {
        let pascals = |key: &str| match self.inputs.iter().find(|input| input.key == key)?.value {
            crate::design::Value::Number(pascals) => Some(pascals),
            _ => None,
        };
        Some(pressures(pascals("supply.pressure")?, pascals("ambient.pressure")?))
    }

    /// JSON Schema (draft 2020-12) of a result.
    pub fn json_schema() -> Schema {
        schema_of::<Self>()
    }

    /// The common range as text, `50 to 10000 Hz`; `None` without bands.
    pub(crate) fn range(&self) -> Option<String> {
        let bands = &self.ranking.first()?.bands;
        Some(format!("{} to {} Hz", bands.first()?.hz, bands.last()?.hz))
    }
}

/// JSON Schema (draft 2020-12) of a result, with descriptions in plain text.
pub(crate) fn schema_of<T: JsonSchema>() -> Schema {
    let settings = SchemaSettings::draft2020_12().for_serialize();
    settings
        .with_transform(RecursiveTransform(unescape))
        .into_generator()
        .into_root_schema_for::<T>()
}

/// Converts the description of a schema from rustdoc to plain text in one line.
fn unescape(schema: &mut Schema) {
    if let Some(Value::String(text)) = schema.get_mut("description") {
        let plain = [("\\[", "["), ("\\]", "]"), ("[`", "`"), ("`]", "`"), ("\n", " ")];
        *text = plain
            .iter()
            .fold(std::mem::take(text), |text, (from, to)| text.replace(from, to));
    }
}

impl From<&Design> for DesignId {
    fn from(design: &Design) -> Self {
        Self {
            name: design.name().to_owned(),
            digest: design.digest(),
        }
    }
}

/// A cycle of an assembly without its histories.
#[derive(Debug, Clone, Serialize)]
pub struct AssemblyFigures<'a> {
    /// Name of its outcome.
    pub outcome: &'a str,
    /// Event times \[s\].
    pub events: EventTimes,
    /// Figures of the shot.
    pub summary: &'a SummaryFigures,
    /// Integrals along the run.
    pub ledger: &'a [LedgerEntry],
    /// Checks of the balances.
    pub checks: &'a [Check],
}

/// A shot without its histories, by the engine of its cycle.
#[derive(Debug, Clone, Serialize)]
#[serde(untagged)]
pub enum FiguresOfShot<'a> {
    /// Of the tool of the keys.
    Keys(&'a NailerFigures),
    /// Of an assembly.
    Assembly(AssemblyFigures<'a>),
}

impl<'a> From<&'a ShotRecord> for FiguresOfShot<'a> {
    fn from(shot: &'a ShotRecord) -> Self {
        match &shot.nailer {
            Some(nailer) => Self::Keys(nailer),
            None => Self::Assembly(AssemblyFigures {
                outcome: &shot.outcome,
                events: EventTimes(shot.events.clone()),
                summary: &shot.figures,
                ledger: &shot.record.ledger,
                checks: &shot.checks,
            }),
        }
    }
}

/// A value of the design.
#[derive(Debug, Clone, Serialize, JsonSchema)]
pub struct Input {
    /// Full name of the key.
    pub key: String,
    /// Its value, quantities in SI units.
    #[schemars(with = "serde_json::Value", extend("type" = ["number", "string", "boolean"]))]
    pub value: crate::design::Value,
    /// SI unit; empty for plain numbers, counts, switches and choices.
    pub unit: String,
    /// Range of plausible values, in SI units; null if there is none.
    pub range: Option<[f64; 2]>,
    /// Origin of the range; null without one.
    #[serde(default)]
    pub range_origin: Option<crate::design::RangeOrigin>,
    /// Origin of the value.
    pub provenance: crate::design::Provenance,
}

impl From<crate::design::Entry> for Input {
    fn from(entry: crate::design::Entry) -> Self {
        Self {
            key: entry.key,
            value: entry.value,
            unit: entry.unit,
            range: entry.range,
            range_origin: entry.range_origin,
            provenance: entry.provenance,
        }
    }
}

/// One source in the ranking.
#[derive(Debug, Clone, Serialize, Deserialize, JsonSchema)]
pub struct RankedSource {
    /// `workpiece`, `exhaust` or `body`.
    pub source: String,
    /// A-weighted single-event sound power level over the common range \[dB re 1 pW s\]; null when silent.
    pub lwa_db: Option<f64>,
    /// The same without weighting.
    pub lw_db: Option<f64>,
    /// Fraction of the total A-weighted energy \[-\].
    pub share: f64,
    /// How it was computed.
    pub method: String,
    /// Range over which it was computed \[Hz\].
    pub range_hz: [f64; 2],
    /// A-weighted level over `range_hz` instead of the common range \[dB re 1 pW s\].
    pub lwa_own_range_db: Option<f64>,
    /// One-third-octave bands of the common range.
    pub bands: Vec<BandLevel>,
    /// Parts of the source, whose sum is the source.
    pub components: Vec<Component>,
    /// Possible error of the method.
    pub uncertainty_db: Uncertainty,
    /// The same quantity from an independent method, if there is one.
    pub cross_check: Option<CrossCheck>,
    /// Comparison of two evaluations of a surface's power; null for the equivalent radiated power, which is an
    /// estimate.
    pub radiation: Option<RadiationReport>,
    /// Sound radiated between adjacent events; the energies sum to that of the source.
    pub intervals: Vec<IntervalLevel>,
}

/// The item with the largest level; `None` if all are silent.
pub(crate) fn loudest<T>(items: &[T], level: impl Fn(&T) -> Option<f64>) -> Option<&T> {
    let with_levels = items.iter().filter_map(|item| Some((item, level(item)?)));
    with_levels.max_by(|a, b| a.1.total_cmp(&b.1)).map(|(item, _)| item)
}

impl RankedSource {
    /// The parts, loudest first.
    pub(crate) fn parts(&self) -> Vec<&Component> {
        let mut parts: Vec<_> = self.components.iter().collect();
        let level = |part: &Component| part.lwa_db.unwrap_or(f64::NEG_INFINITY);
        parts.sort_by(|a, b| level(b).total_cmp(&level(a)));
        parts
    }

    /// Name, level and band.
    pub(crate) fn placed(&self) -> crate::wording::Placed<'_> {
        (&self.source, self.lwa_db, self.uncertainty_db.bounds())
    }
}

/// Sound power as EN 12549 measures it, at the nine positions of ISO 3744 on a parallelepiped around the device above a
/// reflecting plane, next to the radiated power.
#[derive(Debug, Clone, Serialize, JsonSchema)]
pub struct MicrophoneReport {
    /// Half sides a and b and height c of the parallelepiped \[m\].
    pub box_m: [f64; 3],
    /// Its area S \[m2\].
    pub area_m2: f64,
    /// Positions of the microphones relative to the device's axis and the reflecting plane \[m\].
    pub positions_m: Vec<[f64; 3]>,
    /// Range of all levels and of the sound files \[Hz\]; neither contains anything outside.
    pub range_hz: [f64; 2],
    /// Pressure of a full-scale sample in the sound files \[Pa\].
    pub full_scale_pa: f64,
    /// Each source alone, without room and background.
    pub sources: Vec<ReceivedSource>,
    /// All sources together, in the design's room with its background.
    pub total: ArrayMeasurement,
}

/// Levels of a declaration in the dual-number form of ISO 4871, each rounded to the nearest decibel. All share the same
/// K, that of the sound power, because no study draws the directivity.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
pub struct Declaration {
    /// L_WA,1s \[dB re 1 pW s\]; null when silent.
    pub lwa_1s_db: Option<i32>,
    /// L_pA,1s at the operator's ear \[dB re 20 uPa\]; null when silent.
    pub lpa_1s_db: Option<i32>,
    /// L_pC,peak there \[dB re 20 uPa\]; null when silent, or if `ear.not_stated` gives a reason.
    pub lpc_peak_db: Option<i32>,
    /// K = 1.645 sigma over the draws of a study, for inputs and methods \[dB\]. Null if it is not stated: without a
    /// study of at least 32 draws, or if the design contradicts its draws.
    pub k_db: Option<i32>,
    /// Origin of sigma; null without K.
    pub k_basis: Option<String>,
    /// Reason why K is not stated; null if it is.
    #[serde(default)]
    pub k_not_stated: Option<String>,
}

/// Emission sound pressure of all sources at the operator's ear, without room and background.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct EarReport {
    /// Position of the ear relative to the centre of the block's underside, z up \[m\].
    pub position_m: [f64; 3],
    /// A-weighted level L_pA,1s of one shot over 1 s \[dB re 20 uPa\]; null when silent.
    pub lpa_1s_db: Option<f64>,
    /// Synthetic fraction of that exposure: above the frequencies up to which phases are known \[-\].
    pub synthetic_share: f64,
    /// C-weighted peak level L_pC,peak \[dB re 20 uPa\]; null when silent, or not stated.
    pub lpc_peak_db: Option<f64>,
    /// C-weighted peak level of the complete signal \[dB re 20 uPa\]; null when silent. If the peak is not stated, the
    /// phases are partly drawn, so that this is one draw among many.
    pub lpc_peak_signal_db: Option<f64>,
    /// Reason why L_pC,peak is not stated; null if it is.
    pub not_stated: Option<String>,
    /// Loudness of each source, and of all of them as `total`, by ISO 532-1:2017 for time-varying sounds.
    #[serde(default)]
    pub loudness: Vec<SourceLoudness>,
}

/// Loudness of one shot of a source at the operator's ear: Zwicker's method for time-varying sounds (ISO 532-1:2017,
/// clause 6), free field from the front, the same sound at both ears.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct SourceLoudness {
    /// Its name, or `total`.
    pub source: String,
    /// Maximum loudness N_max \[sone\]; null above 120 dB in a band up to 250 Hz, where the standard ends.
    pub n_max_sone: Option<f64>,
    /// Loudness level of N_max \[phon\].
    pub level_phon: Option<f64>,
    /// Time of N_max after the trigger is pulled \[s\].
    pub time_s: Option<f64>,
}

/// A source measured by the microphones.
#[derive(Debug, Clone, Serialize, Deserialize, JsonSchema)]
pub struct ReceivedSource {
    /// Its name.
    pub source: String,
    /// How its sound is propagated to a receiver.
    pub how: String,
    /// Frequencies over which it is received and compared \[Hz\].
    pub range_hz: [f64; 2],
    /// Frequency above which its signals are synthetic \[Hz\]: they have the energy and the power over time of the
    /// source, but phases that are drawn or chosen. Null if the phases are those of the model over the complete range.
    pub synthetic_from_hz: Option<f64>,
    /// Error of interpolated pressures over frequency, relative to the loudest mode at any microphone \[-\]; null if
    /// none are interpolated.
    pub interpolation_error: Option<f64>,
    /// Levels at each microphone.
    pub levels: Vec<MicrophoneLevel>,
    /// A-weighted level from the microphones, mean L_E + 10 lg S \[dB re 1 pW s\]; null when silent.
    pub lwa_db: Option<f64>,
    /// Level of the power radiated over the same range \[dB re 1 pW s\].
    pub true_lwa_db: Option<f64>,
    /// One-third-octave bands in the range, unweighted: from the microphones and radiated \[dB re 1 pW s\].
    pub bands: Vec<MicrophoneBand>,
}

/// All sources together by the procedure of ISO 3744, L_WA = mean L_EA + 10 lg S - K1 - K2. In power levels, the
/// energies of the sources are added: the interference of block and tool, which changes some low bands by up to a
/// decibel, appears only in `levels`.
#[derive(Debug, Clone, Serialize, JsonSchema)]
pub struct ArrayMeasurement {
    /// Levels at each microphone, for the direct sound alone: from the sum of all pressures, which the sound files of
    /// the total contain.
    pub levels: Vec<MicrophoneLevel>,
    /// A-weighted mean level with room and background \[dB re (20 uPa)2 s\]; null when silent.
    pub lpa_db: Option<f64>,
    /// Background correction \[dB\]; null if the background is too loud for a valid measurement.
    pub k1_db: Option<f64>,
    /// Room correction \[dB\].
    pub k2_db: f64,
    /// A-weighted level from the microphones \[dB re 1 pW s\]; null when silent or not valid.
    pub lwa_db: Option<f64>,
    /// Level of the power radiated over the same ranges \[dB re 1 pW s\].
    pub true_lwa_db: Option<f64>,
}

/// One microphone.
#[derive(Debug, Clone, Copy, Serialize, Deserialize, JsonSchema)]
pub struct MicrophoneLevel {
    /// A-weighted sound exposure level \[dB re (20 uPa)2 s\]; null when silent.
    pub lae_db: Option<f64>,
    /// The same unweighted.
    pub le_db: Option<f64>,
    /// Largest magnitude of the pressure \[Pa\].
    pub peak_pa: f64,
}

/// One band of a [`ReceivedSource`].
#[derive(Debug, Clone, Copy, Serialize, Deserialize, JsonSchema)]
pub struct MicrophoneBand {
    /// Nominal mid-band frequency (IEC 61260-1) \[Hz\].
    pub hz: f64,
    /// From the microphones; null when silent.
    pub lw_db: Option<f64>,
    /// Radiated; null when silent.
    pub true_lw_db: Option<f64>,
}

/// Comparison of two methods for one quantity.
#[derive(Debug, Clone, Serialize, Deserialize, JsonSchema)]
pub struct CrossCheck {
    /// The quantity.
    pub quantity: Cow<'static, str>,
    /// Its unweighted level by the method of the result \[dB re 1 pW s\]; null when silent.
    pub lw_db: Option<f64>,
    /// The other method.
    pub other: Cow<'static, str>,
    /// Its unweighted level by the other method \[dB re 1 pW s\]; null when silent.
    pub other_lw_db: Option<f64>,
}

impl IntervalLevel {
    /// The events at its ends: `t5-t6`.
    pub(crate) fn label(&self) -> String {
        format!("{}-{}", self.from, self.to)
    }
}

/// Sound radiated by a source between two events, A-weighted, over the common range.
#[derive(Debug, Clone, Serialize, Deserialize, JsonSchema)]
pub struct IntervalLevel {
    /// Event at its start, `t0` to `t18`; `start` for the beginning of the record.
    pub from: String,
    /// Event at its end; `end` for everything after the last event.
    pub to: String,
    /// Start \[s\].
    pub from_s: f64,
    /// End \[s\].
    pub to_s: f64,
    /// Single-event level of the energy radiated in it \[dB re 1 pW s\]; null when silent.
    pub lwa_db: Option<f64>,
    /// The level found by a measurement that cuts the signal at both events, which adds energy \[dB re 1 pW s\]; null
    /// when silent.
    pub lwa_cut_db: Option<f64>,
    /// Energies of both levels \[J\] if one is negative and has no level: the source absorbs more than it radiates.
    /// Absent otherwise.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub energies_j: Option<[f64; 2]>,
}

impl IntervalLevel {
    /// Energy of the interval \[J\].
    pub(crate) fn energy(&self) -> f64 {
        self.energies()[0]
    }

    /// Energy of the interval, and of the signal cut at its ends \[J\].
    pub(crate) fn energies(&self) -> [f64; 2] {
        self.energies_j
            .unwrap_or_else(|| [self.lwa_db, self.lwa_cut_db].map(level_energy))
    }
}

/// Level of one band.
#[derive(Debug, Clone, Copy, Serialize, Deserialize, JsonSchema)]
pub struct BandLevel {
    /// Nominal mid-band frequency (IEC 61260-1) \[Hz\].
    pub hz: f64,
    /// Unweighted single-event sound power level \[dB re 1 pW s\]; null when silent.
    pub lw_db: Option<f64>,
    /// The same with A weighting.
    pub lwa_db: Option<f64>,
    /// Unweighted and A-weighted energy \[J\] if one is negative and has no level: the part absorbs more than it
    /// radiates. Absent otherwise.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub energies_j: Option<[f64; 2]>,
}

impl BandLevel {
    /// Unweighted and A-weighted energy \[J\].
    pub(crate) fn energies(&self) -> [f64; 2] {
        self.energies_j
            .unwrap_or_else(|| [self.lw_db, self.lwa_db].map(level_energy))
    }

    /// Its frequency as text.
    pub(crate) fn label(&self) -> String {
        self.hz.to_string()
    }
}

/// Part of a source.
#[derive(Debug, Clone, Serialize, Deserialize, JsonSchema)]
pub struct Component {
    /// Patch or mechanism.
    pub name: String,
    /// A-weighted level over the common range \[dB re 1 pW s\]; null when silent.
    pub lwa_db: Option<f64>,
    /// The same without weighting.
    pub lw_db: Option<f64>,
    /// Unweighted and A-weighted energy \[J\] if one is negative and has no level: the part absorbs more than it
    /// radiates. Absent otherwise.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub energies_j: Option<[f64; 2]>,
    /// One-third-octave bands of the common range.
    pub bands: Vec<BandLevel>,
}

/// Measurement of a shot by an accelerometer.
#[derive(Debug, Clone, Serialize, JsonSchema)]
pub struct SensorLevel {
    /// Its name in the design.
    pub name: String,
    /// The body to which it is fixed: `workpiece`, `worktable`, `sand` or `tool`.
    pub body: &'static str,
    /// Root mean square of the acceleration over a period of 1 s that contains only the shot, (int a^2 dt / 1 s)^1/2
    /// \[g, 9.80665 m/s2\].
    pub rms_g: f64,
    /// Largest magnitude of the acceleration \[g\].
    pub peak_g: f64,
}

/// Readings of a pressure transducer during a shot. A piezoelectric one measures no static pressure: it reads changes
/// from the trigger on.
#[derive(Debug, Clone, Serialize, JsonSchema)]
pub struct TransducerRange {
    /// Its name in the design.
    pub name: String,
    /// Its chamber: `cylinder`, `return`, or a volume of the cycle.
    pub chamber: String,
    /// Lowest reading \[Pa\].
    pub lowest_pa: f64,
    /// Highest reading \[Pa\].
    pub highest_pa: f64,
}

/// Differences between coupling the structures two ways and driving them one way.
#[derive(Debug, Clone, Serialize, JsonSchema)]
pub struct Coupling {
    /// Event times.
    pub events: Vec<EventChange>,
    /// Figures of the shot, as in [`nailnoise_dynamics::Summary`], in SI units.
    pub figures: Vec<FigureChange>,
    /// Levels of the sources and of all together.
    pub levels: Vec<LevelChange>,
    /// Iterations with which cycle and structure were coupled.
    pub work: nailnoise_dynamics::CouplingWork,
}

/// Linear motion of a source with the air's impedance frozen at each mode's resonance, as a contact that can open
/// requires, compared with the complete impedance Z = R + jX at every frequency.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
pub struct FluidLoadingChange {
    /// The source.
    pub source: String,
    /// A-weighted single-event level with the frozen impedance \[dB re 1 pW s\]; null when silent.
    pub frozen_lwa_db: Option<f64>,
    /// The same with the complete one.
    pub complete_lwa_db: Option<f64>,
    /// Whether the complete impedance acts on the motion of this run. If not, its contact can open or acts back on the
    /// cycle: both levels are those of the same shot computed one way with the contact bonded.
    pub complete_acts: bool,
}

impl FluidLoadingChange {
    /// Level with the complete impedance minus that with the frozen one \[dB\].
    pub fn change_db(&self) -> Option<f64> {
        Some(self.complete_lwa_db? - self.frozen_lwa_db?)
    }
}

/// Levels of the workpiece for starts that differ by gaps of 1 um below the block.
#[derive(Debug, Clone, Serialize, Deserialize, JsonSchema)]
pub struct Starts {
    /// A-weighted single-event level of each start \[dB re 1 pW s\]; the first is that of the run.
    pub lwa_db: Vec<f64>,
    /// Their mean \[dB re 1 pW s\].
    pub mean_lwa_db: f64,
    /// Their standard deviation \[dB\].
    pub deviation_db: f64,
}

/// One event in both runs.
#[derive(Debug, Clone, Serialize, JsonSchema)]
pub struct EventChange {
    /// `t1` to `t18`.
    pub event: String,
    /// Time one way \[s\]; null if it does not occur.
    pub one_way_s: Option<f64>,
    /// Time two ways \[s\]; null if it does not occur.
    pub two_way_s: Option<f64>,
}

/// One figure of the shot in both runs.
#[derive(Debug, Clone, Serialize, JsonSchema)]
pub struct FigureChange {
    /// Its name among the figures of the shot.
    pub figure: std::borrow::Cow<'static, str>,
    /// Its SI unit.
    pub unit: &'static str,
    /// Value one way; null if there is none.
    pub one_way: Option<f64>,
    /// Value two ways; null if there is none.
    pub two_way: Option<f64>,
}

/// One source's level in both runs.
#[derive(Debug, Clone, Serialize, JsonSchema)]
pub struct LevelChange {
    /// The source, or `total`.
    pub source: String,
    /// A-weighted single-event level one way \[dB re 1 pW s\]; null when silent.
    pub one_way_lwa_db: Option<f64>,
    /// The same two ways.
    pub two_way_lwa_db: Option<f64>,
}

/// Name of the sum of all sources.
pub(crate) const TOTAL: &str = "total";

/// All sources together.
#[derive(Debug, Clone, Copy, Serialize, Deserialize, JsonSchema)]
pub struct Total {
    /// A-weighted single-event sound power level over the common range \[dB re 1 pW s\]; null when all are silent.
    pub lwa_db: Option<f64>,
    /// The same without weighting.
    pub lw_db: Option<f64>,
}
