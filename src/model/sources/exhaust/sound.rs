//! The exhaust as a source: the air that leaves through exhaust holes, muffler and trigger vent.

use std::f64::consts::PI;

use nailnoise_acoustics::Air;
use nailnoise_acoustics::jets::{
    ExhaustNoise, ExhaustSettings, FlowHistory, Jet, Opening, PipeFitting, PlenumResonance, UNSTEADY_FLOW, ValveNoise,
    exhaust_noise, screech_track,
};
use nailnoise_acoustics::muffler::{self, BandLosses, MufflerChain};
use nailnoise_acoustics::signals::fourier::TransformSettings;
use nailnoise_acoustics::signals::{SourceSpectrum, Weighting, energy_level, energy_weights};
use nailnoise_dynamics::network::FlowHistory as OpeningFlow;
use serde::Serialize;

use crate::error::Error;
use crate::result::{Check, CrossCheck, Uncertainty};
use crate::stages::apart::{Apart, Moved, PartError};
use crate::stages::cycle::ShotRecord;
use crate::stages::intervals::EventEdges;
use crate::stages::microphones::{Heard, JetOutlet, MicrophoneArray};
use crate::stages::sound::{Sound, SoundSource, SourceHistory, parts_of};
use crate::stages::sources::{Emission, SourceSound};
use crate::stages::{Code, Progress, Stage, Stored, Uncached, code};

/// Name of the source.
pub(crate) const NAME: &str = "exhaust";

/// Code that the stages of this module call.
pub(crate) const CODE: Code = code!(
    dynamics,
    acoustics,
    model_sources_exhaust,
    stages_apart,
    stages_intervals,
    stages_microphones,
    stages_sound,
    stages_sources,
    stages_truncation,
    stages_cycle
);

/// Uncertainty of the exhaust's level \[dB\]: the largest difference between the jet correlations and a published fit
/// to measured millimetre jets, up to 6 atmospheres.
const MODEL_BAND: f64 = 4.0;

/// The basis of [`MODEL_BAND`] in words.
const MODEL_BASIS: &str = "distance of the jet correlations from a published fit to measured jets of millimetre holes";

/// Uncertainty of the level of jets that blow into a fitting \[dB\].
///
/// The correlations are for free jets. In a pipe of a few hole diameters, jets entrain gas that already moves, and
/// strike walls and bends of unknown position. Their quadrupoles drive cross modes instead of the open air. A decrease
/// of the velocity difference by a tenth lowers their power by 3.7 dB (eighth power), and the scattering of jet noise
/// at an edge raises it by a similar amount. The band of free jets is therefore widened by 2 dB either way.
const CONFINED_BAND: f64 = 6.0;

/// The basis of [`CONFINED_BAND`] in words.
const CONFINED_BASIS: &str = "the correlations are of free jets, and these blow into a fitting: 6 dB instead of 4; \
                              they radiate unchanged, or as its resonances amplify the outflow";

/// Largest relative difference between the mass that leaves in the cycle and that of the expanded jets.
const MASS_GAP: f64 = 0.05;

/// The openings through which air leaves, and the range in which their noise is computed.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub(crate) struct Openings {
    /// The ambient air.
    pub(crate) air: Air,
    /// Analysed range \[Hz\].
    pub(crate) range_hz: [f64; 2],
    /// Each opening of the tool, with those assigned to another source last.
    pub(crate) openings: Vec<NoisyOpening>,
}

/// An opening to the atmosphere that makes noise.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub(crate) struct NoisyOpening {
    /// Name of its flow in the shot.
    pub(crate) flow: String,
    /// Its name in results.
    pub(crate) name: String,
    /// Its holes.
    pub(crate) holes: Opening,
    /// Plenum, pipe and muffler of the exhaust, if it is the exhaust of the tool.
    pub(crate) exhaust: Option<ExhaustOutlet>,
    /// Name of the source to which it is assigned, if not the exhaust.
    pub(crate) counts_to: Option<&'static str>,
}

/// Elements that the exhaust air passes at its holes.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub(crate) struct ExhaustOutlet {
    /// Resonance of the plenum, if it filters the unsteady outflow.
    pub(crate) plenum: Option<PlenumResonance>,
    /// Pipe on the holes.
    pub(crate) fitting: Option<PipeFitting>,
    /// Muffler after the holes.
    pub(crate) muffler: Option<Muffler>,
}

impl Openings {
    /// The exhaust of the tool, if it has one.
    pub(crate) fn exhaust(&self) -> Option<(&NoisyOpening, &ExhaustOutlet)> {
        self.openings.iter().find_map(|own| Some((own, own.exhaust.as_ref()?)))
    }
}

/// A muffler behind the exhaust holes.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub(crate) enum Muffler {
    /// A measured insertion loss, which includes the muffler's own flow noise. It applies to the sound of the same shot
    /// without the muffler.
    InsertionLoss(BandLosses),
    /// An expansion chamber with a tail pipe.
    Chamber {
        /// Chamber and pipe; the Mach number of its outlet follows from the cycle.
        chain: MufflerChain,
        /// Effective area of its outlet \[m²\], if the outlet has its own jet.
        outlet_area: f64,
    },
}

/// Properties of the exhaust noise in addition to its energy.
#[derive(Debug, Clone)]
pub(crate) struct ExhaustDetails {
    /// Unweighted level of the jets by the efficiencies of IEC 60534-8-3:2010, an independent estimate \[dB re 1 pW
    /// s\].
    pub(crate) valve_noise_lw: Option<f64>,
    /// Unweighted level of the jets by the correlations used, over all frequencies \[dB re 1 pW s\].
    pub(crate) jets_lw: Option<f64>,
    /// Relative difference between the mass of the jets and that of the cycle's flow \[-\].
    pub(crate) mass_gap: f64,
    /// Share of the mixing energy from jet speeds outside the correlation's range \[-\].
    pub(crate) outside_range: f64,
    /// The single jet into which those of neighbouring holes merge, if they do.
    pub(crate) merged: Option<Opening>,
    /// Checks of the cycle without a muffler whose insertion loss was measured.
    pub(crate) unmuffled_checks: Vec<Check>,
    /// The noise of each opening: holes, muffler's outlet if present, trigger vent.
    pub(crate) openings: Vec<ExhaustNoise>,
    /// Screech frequency of the holes' jets at every sample of the cycle \[Hz\]; `None` while they are subsonic.
    pub(crate) screech: Vec<Option<f64>>,
}

impl ExhaustDetails {
    /// Checks that cycle and acoustics use the same flow, and the checks of the cycle without the muffler.
    pub(crate) fn checks(&self) -> impl Iterator<Item = Check> {
        let mass = Check::at_most(
            "exhaust: relative difference between the air mass of the jets and that of the cycle",
            self.mass_gap,
            MASS_GAP,
        );
        std::iter::once(mass).chain(self.unmuffled_checks.iter().cloned())
    }

    /// Time for which the holes' jets are choked \[s\], and the lowest screech frequency during this time \[Hz\].
    pub(crate) fn choked(&self, sample_interval: f64) -> Option<(f64, f64)> {
        let choked = || self.screech.iter().flatten();
        let lowest = choked().copied().reduce(f64::min)?;
        Some((choked().count() as f64 * sample_interval, lowest))
    }
}

/// The cycles from whose outflow the exhaust follows.
#[derive(Clone, Serialize)]
pub(crate) struct Cycles {
    /// That of the shot.
    pub(crate) shot: Stored<ShotRecord>,
    /// The same shot without a muffler, if the insertion loss of the muffler was measured.
    pub(crate) unmuffled: Option<Stored<ShotRecord>>,
}

/// Noise of the openings in the outflow of a shot.
///
/// Its output is not stored: computing it takes less time than reading it would.
#[derive(Serialize)]
pub(crate) struct OutflowNoise {
    /// The openings.
    pub(crate) openings: Openings,
    /// The cycles of shot and holes.
    pub(crate) cycles: Cycles,
}

/// Output of [`OutflowNoise`].
pub(crate) struct Outflow {
    /// Sound of the source.
    pub(crate) sound: Sound,
    /// Sound of the trigger vent with the source to which it is assigned, if that is not the exhaust.
    pub(crate) vent: Option<(Sound, &'static str)>,
    /// Properties in addition to the sound.
    pub(crate) details: ExhaustDetails,
}

impl Stage for OutflowNoise {
    type Output = Outflow;
    type Error = Error;
    type Codec = Uncached;
    const NAME: &'static str = "noise of the outflow";
    const CODE: Code = CODE;

    fn compute(&self, _: &Progress) -> Result<Outflow, Error> {
        let shot = self.cycles.shot.get()?;
        let Some(unmuffled) = &self.cycles.unmuffled else {
            return noise(&self.openings, &shot, &shot);
        };
        let unmuffled = unmuffled.get()?;
        let mut outflow = noise(&self.openings, &unmuffled, &shot)?;
        let checks = unmuffled.checks.iter();
        outflow.details.unmuffled_checks = checks.map(|check| check.clone().of("without the muffler")).collect();
        Ok(outflow)
    }
}

/// The vent as a part that is assigned to another source.
fn moved<T>(part: T, to: &'static str) -> Moved<T> {
    Moved {
        to: to.into(),
        error: PartError::OfPart,
        part,
    }
}

/// Sound of the exhaust.
#[derive(Clone, Serialize)]
pub(crate) struct ExhaustSound(pub(crate) Stored<Outflow>);

impl Emission for ExhaustSound {
    const CODE: Code = CODE;

    fn energy(&self) -> Result<Apart<SourceSpectrum>, Error> {
        let outflow = self.0.get()?;
        let vent = outflow.vent.as_ref();
        Ok(Apart {
            own: outflow.sound.spectrum.clone(),
            moved: vent.map(|(vent, to)| moved(vent.spectrum.clone(), to)),
        })
    }

    fn analysed(&self, edges: &EventEdges, range_hz: [f64; 2]) -> Result<Apart<SoundSource>, Error> {
        let outflow = self.0.get()?;
        let analysed = |sound: &Sound| SoundSource::new(sound.clone(), edges, range_hz);
        let vent = outflow.vent.as_ref();
        Ok(Apart {
            own: analysed(&outflow.sound),
            moved: vent.map(|(vent, to)| moved(analysed(vent), to)),
        })
    }

    fn checks(&self) -> Result<Vec<Check>, Error> {
        Ok(self.0.get()?.details.unmuffled_checks.clone())
    }
}

/// The exhaust as a source: its energy over frequency and time, and its sound at the microphones.
#[derive(Serialize)]
pub(crate) struct Exhaust {
    /// The noise of its openings.
    pub(crate) outflow: Stored<Outflow>,
    /// Where the jets leave the tool.
    pub(crate) outlet: JetOutlet,
    /// The microphones.
    pub(crate) microphones: MicrophoneArray,
    /// The cycle of the shot, whose events separate the intervals.
    pub(crate) cycle: Stored<ShotRecord>,
    /// End of all records of the shot \[s\].
    pub(crate) end: Stored<f64>,
    /// Seed of the jets' noise in the signals at the microphones.
    pub(crate) noise_seed: u32,
}

impl Stage for Exhaust {
    type Output = SourceSound;
    type Error = Error;
    type Codec = Uncached;
    const NAME: &'static str = "exhaust";
    const CODE: Code = CODE;

    fn compute(&self, _: &Progress) -> Result<SourceSound, Error> {
        let (end, outflow) = (*self.end.get()?, self.outflow.get()?);
        let details = &outflow.details;
        let edges = EventEdges::new(&self.cycle.get()?.events, end);
        let heard = |sound: &Sound, first: usize, openings: &[ExhaustNoise]| {
            let source = SoundSource::new(sound.clone(), &edges, self.microphones.range_hz);
            let numbered = (first, openings, self.noise_seed);
            let received = self
                .microphones
                .exhaust(&self.outlet, numbered, &source.spectrum, end)?;
            Ok::<_, Error>(Heard { source, received })
        };
        let vent = outflow.vent.as_ref();
        let count = details.openings.len() - usize::from(vent.is_some());
        let own = heard(&outflow.sound, 0, &details.openings[..count])?;
        let vent = vent.map(|(vent, to)| Ok::<_, Error>(moved(heard(vent, count, &details.openings[count..])?, to)));
        Ok(SourceSound {
            heard: Apart {
                own,
                moved: vent.transpose()?,
            },
            truncations: Vec::new(),
            checks: details.checks().collect(),
            histories: vec![SourceHistory {
                heading: "screech of the exhaust [Hz]".to_owned(),
                values: details.screech.clone(),
            }],
        })
    }
}

/// The noise of all openings from the shot's flow, and that of the vent if it is separate.
///
/// The exhaust has the sound of the shot `through_holes`, all other openings that of `shot`. The two shots are the same
/// unless the insertion loss of a muffler was measured. Such a loss is the level without the muffler minus that with
/// it, so it applies to holes that open into the air, in the shot without the muffler's back pressure. The measured
/// loss includes the effects of back pressure and of the gas inside the muffler on the jets. The holes before a chamber
/// blow into it, against its pressure and into outflow at the stagnation temperature of the holes.
///
/// # Errors
/// Impossible openings, plenum or muffler; air that leaves against a higher pressure.
pub(crate) fn noise(inputs: &Openings, through_holes: &ShotRecord, shot: &ShotRecord) -> Result<Outflow, Error> {
    let air = &inputs.air;
    let bare = ExhaustSettings {
        transform: TransformSettings {
            range_hz: inputs.range_hz,
            ..TransformSettings::default()
        },
        ..ExhaustSettings::default()
    };
    // If the tool has an exhaust, the check and the second method apply only to its jets.
    let of_exhaust = inputs.exhaust().is_some();
    let mut sum = JetSum::default();
    let (mut parts, mut openings, mut vent_alone) = (Vec::new(), Vec::new(), None);
    let (mut main, mut method) = (None::<MainJet>, None);
    for own in &inputs.openings {
        let of = own.exhaust.as_ref().map_or(shot, |_| through_holes);
        let Some(record) = of.record.opening(&own.flow) else {
            continue;
        };
        let muffler = own.exhaust.as_ref().and_then(|exhaust| exhaust.muffler.as_ref());
        let chamber = matches!(muffler, Some(Muffler::Chamber { .. }));
        let flow = FlowHistory {
            sample_interval: of.sample_interval,
            mass_flow: record.mass_flow.clone(),
            pressure: record.pressure.clone(),
            temperature: record.temperature.clone(),
            back_pressure: chamber.then(|| record.back_pressure.clone()),
        };
        let counted = own.exhaust.is_some() || !of_exhaust;
        let (jets, settings) = match &own.exhaust {
            None => (own.holes, bare.clone()),
            Some(exhaust) => (own.holes.merged(), exhaust.settings(record, air, &bare)),
        };
        let noise = exhaust_noise(&own.name, &flow, &jets, air, &settings)?;
        method.get_or_insert_with(|| noise.spectrum.method.clone());
        if counted {
            sum.add(&noise, &flow, air);
        }
        if counted && main.as_ref().is_none_or(|main| main.mass < noise.mass) {
            main = Some(MainJet {
                mass: noise.mass,
                place: openings.len(),
                merged: (jets != own.holes).then_some(jets),
                screech: screech_track(&flow, &jets, air),
            });
        }
        if let Some(to) = own.counts_to {
            vent_alone = Some((self::vent_alone(&noise), to));
        } else {
            // The two parts of the exhaust, its jets and its unsteady flow, are parts of the source.
            match &own.exhaust {
                Some(_) => parts.extend(parts_of(&noise.spectrum)),
                None => parts.push(noise.spectrum.clone()),
            }
        }
        openings.push(noise);
        if let Some(Muffler::Chamber { outlet_area, .. }) = muffler {
            // The sound of the holes' outflow has already passed the muffler; the tail pipe adds its own jet only.
            let tail = FlowHistory {
                pressure: record.back_pressure.clone(),
                back_pressure: None,
                ..flow
            };
            let outlet = ExhaustSettings {
                unsteady_flow: false,
                ..bare.clone()
            };
            let noise = exhaust_noise("muffler outlet", &tail, &round(*outlet_area), air, &outlet)?;
            sum.energy += noise.mixing_energy + noise.shock_energy;
            sum.valve_noise += ValveNoise::DRILLED_PLATE.energy(&tail, air);
            parts.push(noise.spectrum.clone());
            openings.push(noise);
        }
    }
    let own = openings.len() - usize::from(vent_alone.is_some());
    let (valve_noise_lw, jets_lw) = (energy_level(sum.valve_noise), energy_level(sum.energy));
    let spectrum = SourceSpectrum::sum(NAME, method.unwrap_or_default(), &parts);
    let main = main.unwrap_or_default();
    let fitting = inputs.exhaust().and_then(|(_, exhaust)| exhaust.fitting.as_ref());
    let [minus, plus] = match fitting {
        Some(fitting) if main.place < openings.len() => amplified_jets(fitting, &openings[main.place], &spectrum, air)?,
        _ => [0.0, 0.0],
    };
    let (mut band, mut basis) = (MODEL_BAND, MODEL_BASIS.to_owned());
    if fitting.is_some() {
        band = CONFINED_BAND;
        basis.push_str("; ");
        basis.push_str(CONFINED_BASIS);
    }
    let sound = Sound {
        spectrum,
        signals: Vec::new(),
        openings: openings[..own].iter().map(|opening| opening.history.clone()).collect(),
        uncertainty: Uncertainty {
            minus: Some(band + minus),
            plus: Some(band + plus),
            basis,
        },
        cross_check: Some(CrossCheck {
            quantity: "jets of the exhaust over all frequencies, before a muffler".into(),
            lw_db: jets_lw,
            other: ValveNoise::STANDARD.into(),
            other_lw_db: valve_noise_lw,
        }),
        radiation: None,
    };
    let details = ExhaustDetails {
        valve_noise_lw,
        jets_lw,
        mass_gap: sum.mass_gap(),
        outside_range: openings.get(main.place).map_or(0.0, |main| main.mixing_outside_range),
        merged: main.merged,
        unmuffled_checks: Vec::new(),
        openings,
        screech: main.screech,
    };
    Ok(Outflow {
        sound,
        vent: vent_alone,
        details,
    })
}

/// The opening through which most air leaves.
#[derive(Default)]
struct MainJet {
    /// Mass that leaves \[kg\].
    mass: f64,
    /// Its place among the openings.
    place: usize,
    /// The jet into which those of its holes merge, if they do.
    merged: Option<Opening>,
    /// Its screech frequency over the cycle \[Hz\].
    screech: Vec<Option<f64>>,
}

/// Mass of air below which the outflow is a rounding error and does not make a jet; a shot discharges grams \[kg\].
const LEAST_MASS: f64 = 1e-9;

/// The jets of several openings together.
#[derive(Default)]
struct JetSum {
    /// Energy of their mixing and shock noise \[J\].
    energy: f64,
    /// The same by the efficiencies of IEC 60534-8-3 \[J\].
    valve_noise: f64,
    /// Mass that leaves \[kg\].
    mass: f64,
    /// Mass of the expanded jets \[kg\].
    jet_mass: f64,
}

impl JetSum {
    fn add(&mut self, noise: &ExhaustNoise, flow: &FlowHistory, air: &Air) {
        self.energy += noise.mixing_energy + noise.shock_energy;
        self.valve_noise += ValveNoise::DRILLED_PLATE.energy(flow, air);
        self.mass += noise.mass;
        self.jet_mass += noise.jet_mass;
    }

    fn mass_gap(&self) -> f64 {
        if self.mass > LEAST_MASS {
            self.jet_mass / self.mass - 1.0
        } else {
            0.0
        }
    }
}

impl ExhaustOutlet {
    /// Settings of the noise of holes with this outlet.
    fn settings(&self, flow: &OpeningFlow, air: &Air, bare: &ExhaustSettings) -> ExhaustSettings {
        ExhaustSettings {
            plenum: self.plenum,
            fitting: self.fitting,
            muffler: self.muffler.as_ref().map(|muffler| match muffler {
                Muffler::InsertionLoss(losses) => muffler::Muffler::InsertionLoss(losses.clone()),
                Muffler::Chamber { chain, .. } => muffler::Muffler::Chain(MufflerChain {
                    outlet_mach: outlet_mach(flow, air),
                    ..chain.clone()
                }),
            }),
            ..bare.clone()
        }
    }
}

/// The trigger vent as a separate sound.
fn vent_alone(vent: &ExhaustNoise) -> Sound {
    Sound {
        spectrum: vent.spectrum.clone(),
        signals: Vec::new(),
        openings: vec![vent.history.clone()],
        uncertainty: Uncertainty {
            minus: Some(MODEL_BAND),
            plus: Some(MODEL_BAND),
            basis: MODEL_BASIS.to_owned(),
        },
        cross_check: None,
        radiation: None,
    }
}

/// Decrease and increase of the exhaust's A-weighted level \[dB\] if the resonances of a fitting act on the jets of the
/// holes as they do on the unsteady outflow. It is not known where in the fitting jets radiate, and as what type of
/// source.
fn amplified_jets(
    fitting: &PipeFitting,
    holes: &ExhaustNoise,
    whole: &SourceSpectrum,
    air: &Air,
) -> Result<[f64; 2], Error> {
    let spectrum = &holes.spectrum;
    let fitting = fitting.filled(holes.outflow_temperature, air)?;
    let weights = energy_weights(&spectrum.frequency, spectrum.range_hz, Weighting::A);
    let jets = |at: usize| -> f64 {
        let jets = spectrum.contributions.iter().filter(|part| part.name != UNSTEADY_FLOW);
        jets.map(|part| part.energy_density[at]).sum()
    };
    let (mut less, mut more) = (0.0, 0.0);
    for (at, (&hz, weight)) in spectrum.frequency.iter().zip(weights).enumerate() {
        let change = weight * jets(at) * (fitting.gain(hz)? - 1.0);
        *(if change < 0.0 { &mut less } else { &mut more }) += change;
    }
    let total = whole.energy(whole.range_hz, Weighting::A);
    let decibels = |change: f64| 10.0 * (1.0 + change / total).log10();
    Ok(if total > 0.0 {
        [-decibels(less), decibels(more)]
    } else {
        [0.0; 2]
    })
}

/// A round hole without contraction of this effective area \[m²\].
pub(super) fn round(effective_area: f64) -> Opening {
    Opening {
        count: 1,
        diameter: (4.0 * effective_area / PI).sqrt(),
        discharge_coefficient: 1.0,
        pitch: None,
    }
}

/// Mach number of the flow out of a muffler, at most 1, averaged over the mass that leaves.
fn outlet_mach(flow: &OpeningFlow, air: &Air) -> f64 {
    let (mut mass, mut sum) = (0.0, 0.0);
    for ((flow, behind), temperature) in flow.mass_flow.iter().zip(&flow.back_pressure).zip(&flow.temperature) {
        if let Some(jet) = Jet::expand(*behind, *temperature, air).filter(|_| *flow > 0.0) {
            sum += flow * jet.mach.min(1.0);
            mass += flow;
        }
    }
    if mass > 0.0 { sum / mass } else { 0.0 }
}
