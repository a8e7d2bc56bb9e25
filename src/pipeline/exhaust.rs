//! Sound energy of the air that leaves: exhaust holes and trigger vent.

use nailnoise_acoustics::Air;
use nailnoise_acoustics::exhaust::{
    ExhaustSettings, FlowHistory, Opening, ValveNoise, exhaust_noise, valve_noise_energy,
};
use nailnoise_acoustics::fourier::TransformSettings;
use nailnoise_acoustics::levels::{SourceSpectrum, energy_level};
use nailnoise_dynamics::CycleRecord;

use super::sound::Sound;
use crate::design::Design;
use crate::error::Error;
use crate::result::{Check, CrossCheck, Uncertainty};

/// Uncertainty of the exhaust's level \[dB\]: half the 8 dB by which jet correlations and valve noise efficiencies may
/// differ for one blow-down.
const MODEL_BAND: f64 = 4.0;

/// The exhaust as one source.
pub(super) struct Exhaust {
    /// Its energy; the contributions are the mechanisms and the trigger vent.
    pub(super) sound: Sound,
    /// Unweighted level of the holes' jets by the efficiencies of IEC 60534-8-3, an independent estimate \[dB\].
    pub(super) cross_check_lw: Option<f64>,
    /// Unweighted level of the holes' jets by the correlations used, over all frequencies \[dB\].
    pub(super) jets_lw: Option<f64>,
    /// Mass that the jets carry over the mass of the cycle's flow, less one.
    pub(super) mass_gap: f64,
    /// Share of the mixing energy from jet speeds outside the correlation's range \[-\].
    pub(super) outside_range: f64,
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
}

/// Computes the noise of exhaust holes and trigger vent from the cycle's flow.
pub(super) fn exhaust(design: &Design, record: &CycleRecord, air: &Air) -> Result<Exhaust, Error> {
    let settings = ExhaustSettings {
        transform: TransformSettings {
            range_hz: [design.analysis.range_low, design.analysis.exhaust_top],
            ..TransformSettings::default()
        },
        plenum: None,
        muffler: None,
    };
    let flow = FlowHistory {
        sample_interval: record.sample_interval,
        mass_flow: record.exhaust.mass_flow.clone(),
        pressure: record.exhaust.plenum_pressure.clone(),
        temperature: record.exhaust.stagnation_temperature.clone(),
    };
    let holes = Opening {
        count: design.exhaust.holes as usize,
        diameter: design.exhaust.hole_diameter,
        discharge_coefficient: design.chambers.discharge_coefficient,
        pitch: None,
    };
    let noise = exhaust_noise("exhaust holes", &flow, &holes, air, &settings)?;
    let vent_flow = FlowHistory {
        sample_interval: record.sample_interval,
        mass_flow: record.vent.mass_flow.clone(),
        pressure: record.vent.pressure.clone(),
        temperature: record.vent.temperature.clone(),
    };
    // The design gives the vent's effective area, C_d included: a round hole of that area without contraction.
    let vent = Opening {
        count: 1,
        diameter: (4.0 * design.trigger.vent_area / std::f64::consts::PI).sqrt(),
        discharge_coefficient: 1.0,
        pitch: None,
    };
    let vent = exhaust_noise("trigger vent", &vent_flow, &vent, air, &settings)?;
    let mut parts = parts_of(&noise.spectrum);
    parts.push(vent.spectrum);
    let cross_check_lw = energy_level(valve_noise_energy(&flow, air, &ValveNoise::default()));
    let jets_lw = energy_level(noise.mixing_energy + noise.shock_energy);
    Ok(Exhaust {
        sound: Sound {
            spectrum: SourceSpectrum::sum("exhaust", noise.spectrum.method.clone(), &parts),
            signals: Vec::new(),
            openings: vec![noise.history, vent.history],
            uncertainty: Uncertainty {
                minus: Some(MODEL_BAND),
                plus: Some(MODEL_BAND),
                basis: "distance of the jet correlations from the efficiencies of IEC 60534-8-3".to_owned(),
            },
            cross_check: Some(CrossCheck {
                quantity: "jets of the exhaust holes over all frequencies",
                lw_db: jets_lw,
                other: "IEC 60534-8-3",
                other_lw_db: cross_check_lw,
            }),
        },
        cross_check_lw,
        jets_lw,
        mass_gap: if noise.mass > 0.0 {
            noise.jet_mass / noise.mass - 1.0
        } else {
            0.0
        },
        outside_range: noise.mixing_outside_range,
    })
}

/// The contributions of a spectrum as spectra of their own.
fn parts_of(spectrum: &SourceSpectrum) -> Vec<SourceSpectrum> {
    let part = |contribution: &nailnoise_acoustics::levels::Contribution| SourceSpectrum {
        source: contribution.name.clone(),
        energy_density: contribution.energy_density.clone(),
        contributions: Vec::new(),
        ..spectrum.clone()
    };
    spectrum.contributions.iter().map(part).collect()
}
