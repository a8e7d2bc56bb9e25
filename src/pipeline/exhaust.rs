//! Sound energy of the air that leaves: exhaust holes, muffler and trigger vent.

use std::f64::consts::PI;

use nailnoise_acoustics::exhaust::{
    ExhaustNoise, ExhaustSettings, FlowHistory, Jet, Opening, PlenumResonance, ValveNoise, exhaust_noise,
    screech_track, valve_noise_energy,
};
use nailnoise_acoustics::fourier::TransformSettings;
use nailnoise_acoustics::levels::{SourceSpectrum, energy_level};
use nailnoise_acoustics::muffler::{BandLosses, Lining, Muffler, MufflerChain, MufflerElement};
use nailnoise_acoustics::{AcousticsError, Air};
use nailnoise_dynamics::CycleRecord;

use super::intervals::Clock;
use super::microphones::{self, AtMicrophones};
use super::ranking::parts_of;
use super::sound::{Sound, Source};
use super::vibration::Bench;
use crate::design::{self, Design, MufflerKind};
use crate::error::Error;
use crate::result::{Check, CrossCheck, Timing, Uncertainty};

/// Uncertainty of the exhaust's level \[dB\]: half the 8 dB by which jet correlations and valve noise efficiencies may
/// differ for one blow-down.
const MODEL_BAND: f64 = 4.0;

/// What is known of the exhaust beside its sound.
pub(super) struct Exhaust {
    /// Unweighted level of the holes' jets by the efficiencies of IEC 60534-8-3, an independent estimate \[dB\].
    pub(super) cross_check_lw: Option<f64>,
    /// Unweighted level of the holes' jets by the correlations used, over all frequencies \[dB\].
    pub(super) jets_lw: Option<f64>,
    /// Mass that the jets carry over the mass of the cycle's flow, less one.
    pub(super) mass_gap: f64,
    /// Share of the mixing energy from jet speeds outside the correlation's range \[-\].
    pub(super) outside_range: f64,
    /// The jets that merge: what sounds in the place of the holes.
    pub(super) merged: Option<Opening>,
    /// The openings one by one: holes, muffler's outlet where there is one, trigger vent.
    pub(super) openings: Vec<ExhaustNoise>,
    /// Screech frequency of the holes' jets at every sample of the cycle \[Hz\]; none while they are subsonic.
    pub(super) screech: Vec<Option<f64>>,
}

/// Largest difference between the mass that leaves in the cycle and that of the jets as the acoustics expand it.
const MASS_GAP: f64 = 0.05;

impl Exhaust {
    /// Check that cycle and acoustics see the same flow.
    pub(super) fn check(&self) -> Check {
        Check::at_most(
            "exhaust: mass of the jets over the cycle's, less 1",
            self.mass_gap,
            MASS_GAP,
        )
    }

    /// How long the holes' jets are choked \[s\], and the lowest screech frequency meanwhile \[Hz\].
    pub(super) fn choked(&self, sample_interval: f64) -> Option<(f64, f64)> {
        let choked = || self.screech.iter().flatten();
        let lowest = choked().copied().reduce(f64::min)?;
        Some((choked().count() as f64 * sample_interval, lowest))
    }
}

/// The exhaust as a source: how much it sounds, when, and what the microphones hear of it.
pub(super) struct Blown {
    pub(super) jets: Source,
    pub(super) exhaust: Exhaust,
    /// The events between which it is told apart.
    pub(super) clock: Clock,
    pub(super) heard: AtMicrophones,
    /// End of the shot that it was taken for \[s\].
    pub(super) end: f64,
}

/// The exhaust of a shot whose records last until `end` \[s\].
///
/// # Errors
/// Those of the acoustics.
pub(super) fn blown(bench: &Bench<'_>, record: &CycleRecord, end: f64, timing: &mut Timing) -> Result<Blown, Error> {
    let (design, air) = (bench.design, &bench.air);
    let (sound, exhaust) = timing.time("exhaust", || exhaust(design, record, air))?;
    let clock = Clock::new(&record.events, end);
    let range = [design.analysis.range_low, design.analysis.range_high];
    let jets = timing.time("intervals of the exhaust", || Source::new(sound, &clock.times, range));
    let heard = timing.time("exhaust at the microphones", || {
        microphones::of_exhaust(design, air, (&exhaust, &jets.spectrum), end)
    })?;
    Ok(Blown {
        jets,
        exhaust,
        clock,
        heard,
        end,
    })
}

/// The noise of a cycle's openings one by one, for what hears them at a place
/// ([`ExhaustNoise::at`]): exhaust holes, a muffler's outlet where there is one, trigger vent.
///
/// # Errors
/// Openings, plenum or muffler that cannot be, air that leaves against a higher pressure.
pub fn exhaust_openings(design: &Design, record: &CycleRecord) -> Result<Vec<ExhaustNoise>, Error> {
    let air = Air::at(design.ambient.temperature, design.ambient.pressure)?;
    Ok(exhaust(design, record, &air)?.1.openings)
}

/// Computes the noise of exhaust holes, muffler and trigger vent from the cycle's flow.
///
/// # Errors
/// Those of the acoustics.
pub(super) fn exhaust(design: &Design, record: &CycleRecord, air: &Air) -> Result<(Sound, Exhaust), Error> {
    let bare = ExhaustSettings {
        transform: TransformSettings {
            range_hz: [design.analysis.range_low, design.analysis.exhaust_top],
            ..TransformSettings::default()
        },
        ..ExhaustSettings::default()
    };
    let own = &design.exhaust;
    let muffled = own.muffler.kind != MufflerKind::None;
    let mass = &record.exhaust.mass_flow;
    let temperature = &record.exhaust.stagnation_temperature;
    let through = |pressure: &[f64], behind: Option<&[f64]>, mass: &[f64], temperature: &[f64]| FlowHistory {
        sample_interval: record.sample_interval,
        mass_flow: mass.to_vec(),
        pressure: pressure.to_vec(),
        temperature: temperature.to_vec(),
        back_pressure: behind.map(<[f64]>::to_vec),
    };
    let behind = &record.exhaust.back_pressure;
    let flow = through(
        &record.exhaust.plenum_pressure,
        muffled.then_some(behind),
        mass,
        temperature,
    );
    let holes = Opening {
        count: own.holes as usize,
        diameter: own.hole_diameter,
        discharge_coefficient: design.chambers.discharge_coefficient,
        pitch: Some(own.pitch),
    };
    holes.check_area(nailnoise_dynamics::Exhaust::from(own).area())?;
    let jets = holes.merged();
    let settings = ExhaustSettings {
        plenum: own.plenum.resonance.then_some(PlenumResonance {
            volume: own.plenum.volume,
            neck_length: own.plenum.neck_length,
            quality: own.plenum.quality,
        }),
        muffler: muffler(&own.muffler, outlet_mach(record, air))?,
        ..bare.clone()
    };
    let noise = exhaust_noise("exhaust holes", &flow, &jets, air, &settings)?;
    let mut parts = parts_of(&noise.spectrum);
    let (mass_gap, outside_range) = (
        if noise.mass > 0.0 {
            noise.jet_mass / noise.mass - 1.0
        } else {
            0.0
        },
        noise.mixing_outside_range,
    );
    let method = noise.spectrum.method.clone();
    let (mut jets_energy, mut other_energy) = (
        noise.mixing_energy + noise.shock_energy,
        valve_noise_energy(&flow, air, &ValveNoise::default()),
    );
    let mut openings = vec![noise];
    if own.muffler.kind == MufflerKind::Chamber {
        // The sound of the holes' outflow has passed the muffler already; what the tail pipe adds is its own jet.
        let tail = through(behind, None, mass, temperature);
        let outlet = ExhaustSettings {
            unsteady_flow: false,
            ..bare.clone()
        };
        let noise = exhaust_noise("muffler outlet", &tail, &round(own.muffler.flow_area), air, &outlet)?;
        jets_energy += noise.mixing_energy + noise.shock_energy;
        other_energy += valve_noise_energy(&tail, air, &ValveNoise::default());
        parts.push(noise.spectrum.clone());
        openings.push(noise);
    }
    let vent = &record.vent;
    let vent = through(&vent.pressure, None, &vent.mass_flow, &vent.temperature);
    // The design gives the vent's effective area, C_d included.
    let vent = exhaust_noise("trigger vent", &vent, &round(design.trigger.vent_area), air, &bare)?;
    parts.push(vent.spectrum.clone());
    openings.push(vent);
    let (cross_check_lw, jets_lw) = (energy_level(other_energy), energy_level(jets_energy));
    let sound = Sound {
        spectrum: SourceSpectrum::sum("exhaust", method, &parts),
        signals: Vec::new(),
        openings: openings.iter().map(|opening| opening.history.clone()).collect(),
        uncertainty: Uncertainty {
            minus: Some(MODEL_BAND),
            plus: Some(MODEL_BAND),
            basis: "distance of the jet correlations from the efficiencies of IEC 60534-8-3".to_owned(),
        },
        cross_check: Some(CrossCheck {
            quantity: "jets of the exhaust over all frequencies, before a muffler".into(),
            lw_db: jets_lw,
            other: "IEC 60534-8-3".into(),
            other_lw_db: cross_check_lw,
        }),
        radiation: None,
    };
    let exhaust = Exhaust {
        cross_check_lw,
        jets_lw,
        mass_gap,
        outside_range,
        merged: (jets != holes).then_some(jets),
        openings,
        screech: screech_track(&flow, &jets, air),
    };
    Ok((sound, exhaust))
}

/// A round hole without contraction of this effective area \[m2\].
fn round(effective_area: f64) -> Opening {
    Opening {
        count: 1,
        diameter: (4.0 * effective_area / PI).sqrt(),
        discharge_coefficient: 1.0,
        pitch: None,
    }
}

/// Mach number of the flow out of a muffler, at most 1, averaged over the mass that leaves.
fn outlet_mach(record: &CycleRecord, air: &Air) -> f64 {
    let flow = &record.exhaust;
    let (mut mass, mut sum) = (0.0, 0.0);
    for ((flow, behind), temperature) in flow
        .mass_flow
        .iter()
        .zip(&flow.back_pressure)
        .zip(&flow.stagnation_temperature)
    {
        if let Some(jet) = Jet::expand(*behind, *temperature, air).filter(|_| *flow > 0.0) {
            sum += flow * jet.mach.min(1.0);
            mass += flow;
        }
    }
    if mass > 0.0 { sum / mass } else { 0.0 }
}

/// The design's muffler as the acoustics knows it; `outlet_mach` is the Mach number of the flow that leaves it.
fn muffler(own: &design::Muffler, outlet_mach: f64) -> Result<Option<Muffler>, AcousticsError> {
    Ok(match own.kind {
        MufflerKind::None => None,
        MufflerKind::InsertionLoss => Some(Muffler::InsertionLoss(BandLosses::new(&thirds(&own.octaves))?)),
        MufflerKind::Chamber => {
            let lining = (own.lining_thickness > 0.0).then_some(Lining {
                thickness: own.lining_thickness,
                resistivity: own.lining_resistivity,
            });
            let element = |length, diameter, lining| MufflerElement {
                length,
                diameter,
                lining,
            };
            Some(Muffler::Chain(MufflerChain {
                elements: vec![
                    element(own.chamber_length, own.chamber_diameter, None),
                    element(own.tail_length, own.tail_diameter, lining),
                ],
                outlet_diameter: own.tail_diameter,
                outlet_mach,
            }))
        }
    })
}

/// Octaves as third octaves: mid-band frequency \[Hz\] and insertion loss \[dB\], that of an octave in each of its three.
fn thirds(octaves: &design::Octaves) -> Vec<(f64, f64)> {
    let losses = [
        octaves.hz_63,
        octaves.hz_125,
        octaves.hz_250,
        octaves.hz_500,
        octaves.hz_1000,
        octaves.hz_2000,
        octaves.hz_4000,
        octaves.hz_8000,
        octaves.hz_16000,
    ];
    let of_octave = |(octave, loss): (usize, &f64)| {
        let first = 3 * octave as i32 - 13;
        [0, 1, 2].map(|third| (1000.0 * 10f64.powf(0.1 * f64::from(first + third)), *loss))
    };
    losses.iter().enumerate().flat_map(of_octave).collect()
}
