use super::error::ExhaustError;
use super::fitting::PipeFitting;
use super::histogram::{PeakHistogram, Spreading};
use super::history::{Burst, ExhaustHistory};
use super::jet::Jet;
use super::mixing::{MIXING_RANGE, mixing_power};
use super::monopole::{PlenumResonance, monopole};
use super::opening::{FlowHistory, Opening};
use super::{shock, similarity};
use crate::air::Air;
use crate::error::AcousticsError;
use crate::muffler::Muffler;
use crate::signals::fourier::TransformSettings;
use crate::signals::{Contribution, PowerSignals, SourceSpectrum};
use nalgebra::{Complex, DMatrix};
use serde::Serialize;

/// Name of the contribution from unsteady outflow, a monopole.
pub const UNSTEADY_FLOW: &str = "unsteady flow";

/// Strouhal number f D_j/U_j at which mixing noise peaks, in the spectrum per hertz.
///
/// IEC 60534-8-3:2010, table 4, gives 0.2 for jets from drilled plates (0.1 to 0.3 for free jets, 5.4.2). These values
/// are for the peak in third octaves; third octaves of the similarity spectrum peak at 0.6. A cold jet at 302 m/s in
/// NASA's rig peaks at 1 in third octaves, at 60 and 90 degrees; `docs/uncertainty.md` discusses the differences.
const MIXING_STROUHAL: f64 = 0.2;

/// Largest fraction of the mass that may leave against a higher pressure, due to inertia or at the end of a filling
/// flow.
const ADVERSE_MASS: f64 = 0.01;

/// How the exhaust is analysed.
#[derive(Debug, Clone, PartialEq)]
pub struct ExhaustSettings {
    /// Range, taper and padding of the transform.
    pub transform: TransformSettings,
    /// Plenum resonance that filters the unsteady outflow.
    pub plenum: Option<PlenumResonance>,
    /// Pipe on the openings, which filters the unsteady outflow; jet noise passes unchanged.
    pub fitting: Option<PipeFitting>,
    /// Muffler between the openings and the open air.
    pub muffler: Option<Muffler>,
    /// Whether the unsteady outflow is included. It is excluded at the outlet of a muffler, because it is already
    /// included at the holes upstream.
    pub unsteady_flow: bool,
}

impl Default for ExhaustSettings {
    /// 20 Hz to 20 kHz, without plenum resonance, fitting or muffler.
    fn default() -> Self {
        let transform = TransformSettings {
            range_hz: [20.0, 20_000.0],
            ..TransformSettings::default()
        };
        Self {
            transform,
            plenum: None,
            fitting: None,
            muffler: None,
            unsteady_flow: true,
        }
    }
}

/// The noise of one opening over a cycle.
#[derive(Debug, Clone, Serialize)]
pub struct ExhaustNoise {
    /// Energy spectrum with the contributions `mixing`, `shock` and `unsteady flow`.
    pub spectrum: SourceSpectrum,
    /// Energy of mixing noise over all frequencies, upstream of a muffler \[J\].
    pub mixing_energy: f64,
    /// Energy of shock noise over all frequencies, upstream of a muffler \[J\].
    pub shock_energy: f64,
    /// Share of the mixing energy from jet speeds outside the range of the correlation.
    pub mixing_outside_range: f64,
    /// Mass that left through the opening, according to the cycle \[kg\].
    pub mass: f64,
    /// Stagnation temperature of the outflow, averaged over its mass \[K\]; that of the air if nothing flows.
    pub outflow_temperature: f64,
    /// Mass of the isentropic jets \[kg\]; close to `mass` if areas and pressures are consistent with those of the
    /// cycle.
    pub jet_mass: f64,
    /// Noise over time.
    #[serde(skip)]
    pub history: ExhaustHistory,
}

/// Exhaust noise of one opening: turbulent mixing, broadband shock noise and the monopole of the unsteady outflow.
///
/// The opening is silent while the flow is inward, or the pressure is at or below ambient.
///
/// # Errors
/// If histories differ in length or contain values that are not finite. Also for an impossible opening, jets that
/// merge, air that leaves against a higher pressure, or a muffler that does not cover the analysed range.
pub fn exhaust_noise(
    source: impl Into<String>,
    history: &FlowHistory,
    opening: &Opening,
    air: &Air,
    settings: &ExhaustSettings,
) -> Result<ExhaustNoise, AcousticsError> {
    history.check()?;
    opening.check()?;
    let area = opening.effective_area();
    let dt = history.sample_interval;
    let (mut mixing, mut shocks) = (PeakHistogram::new(), PeakHistogram::new());
    let (mut mixing_energy, mut shock_energy, mut outside) = (0.0, 0.0, 0.0);
    let (mut mass, mut jet_mass) = (0.0, 0.0);
    let (mut adverse_mass, mut worst) = (0.0, None);
    let (mut mixing_bursts, mut shock_bursts) = (Vec::new(), Vec::new());
    for (sample, ((&flow, &pressure), &temperature)) in history
        .mass_flow
        .iter()
        .zip(&history.pressure)
        .zip(&history.temperature)
        .enumerate()
    {
        if flow <= 0.0 {
            continue;
        }
        mass += flow * dt;
        let air = &history.surroundings(sample, air);
        let Some(jet) = Jet::expand(pressure, temperature, air) else {
            adverse_mass += flow * dt;
            if worst.is_none_or(|(_, largest, _)| flow > largest) {
                worst = Some((sample, flow, pressure));
            }
            continue;
        };
        jet_mass += jet.mass_flow(area) * dt;
        let jet_area = jet.area(area);
        let energy = mixing_power(&jet, jet_area, air) * dt;
        let peak_hz = MIXING_STROUHAL * jet.velocity / (jet.diameter_ratio * opening.diameter);
        let lg_velocity = (jet.velocity / air.sound_speed).log10();
        mixing.deposit(peak_hz, energy);
        mixing_bursts.push(Burst {
            sample,
            peak_hz,
            energy,
            lg_velocity,
        });
        mixing_energy += energy;
        if !MIXING_RANGE.contains(&lg_velocity) {
            outside += energy;
        }
        if let Some(peak_hz) = shock::shock_peak_frequency(&jet, jet_area / opening.count as f64, air) {
            let energy = shock::factor(&jet, jet_area, air) * dt;
            shocks.deposit(peak_hz, energy);
            shock_bursts.push(Burst {
                sample,
                peak_hz,
                energy,
                lg_velocity,
            });
            shock_energy += energy;
        }
    }
    if let Some((sample, flow, pressure)) = worst.filter(|_| adverse_mass > ADVERSE_MASS * mass) {
        return Err(ExhaustError::BelowAmbient {
            sample,
            flow,
            pressure,
            ambient: air.pressure,
        }
        .into());
    }
    let plenum = settings.plenum.as_ref();
    plenum.map_or(Ok(()), PlenumResonance::check)?;
    let temperature = outflow_temperature(history).unwrap_or(air.temperature);
    let plenum = plenum.map(|plenum| (plenum, plenum.frequency(opening, temperature, air)));
    let (frequency, mut signal) = monopole(history, air, &settings.transform, plenum)?;
    if !settings.unsteady_flow {
        signal.fill(Complex::ZERO);
    }
    if let Some(fitting) = &settings.fitting {
        let fitting = fitting.filled(temperature, air)?;
        for (x, &hz) in signal.iter_mut().zip(&frequency) {
            *x *= fitting.response(hz)?;
        }
    }
    // The bins extend up to one resolution beyond the range. Those outside serve only for interpolation and use the
    // muffler's value at the end of the range, beyond which it need not be known.
    let [low, high] = settings.transform.range_hz;
    let passed: Option<Vec<f64>> = match &settings.muffler {
        Some(muffler) => Some(
            frequency
                .iter()
                .map(|&hz| muffler.energy_factor(hz.clamp(low, high), air))
                .collect::<Result<_, _>>()?,
        ),
        None => None,
    };
    if let Some(passed) = &passed {
        signal
            .iter_mut()
            .zip(passed)
            .for_each(|(x, factor)| *x *= factor.sqrt());
    }
    let unsteady: Vec<f64> = signal.iter().map(|x| 2.0 * x.norm_sqr()).collect();
    let outflow = SourceSpectrum::new("", "", frequency.clone(), unsteady.clone(), settings.transform.range_hz)?;
    let over_time = ExhaustHistory {
        sample_interval: dt,
        samples: history.mass_flow.len(),
        frequency: frequency.clone(),
        passed: passed.clone(),
        mixing: mixing_bursts,
        shocks: shock_bursts,
        monopole: PowerSignals::new(&outflow, DMatrix::from_row_slice(1, signal.len(), &signal))?,
    };
    let normal = similarity::total();
    let muffled = |mut density: Vec<f64>| {
        if let Some(passed) = &passed {
            density.iter_mut().zip(passed).for_each(|(e, factor)| *e *= factor);
        }
        density
    };
    let parts = [
        (
            "mixing",
            muffled(mixing.spread(&Spreading::new(|x| similarity::shape(x) / normal, &frequency))),
        ),
        (
            "shock",
            muffled(shocks.spread(&Spreading::new(shock::shape, &frequency))),
        ),
        (UNSTEADY_FLOW, unsteady),
    ];
    let density = (0..frequency.len())
        .map(|i| parts.iter().map(|(_, e)| e[i]).sum())
        .collect();
    let method = "jet correlations and unsteady flow";
    let mut spectrum = SourceSpectrum::new(source, method, frequency, density, settings.transform.range_hz)?;
    spectrum.contributions = parts
        .map(|(name, energy_density)| Contribution {
            name: name.to_owned(),
            energy_density,
        })
        .into();
    Ok(ExhaustNoise {
        spectrum,
        mixing_energy,
        shock_energy: shock_energy * shock::total(),
        mixing_outside_range: if mixing_energy > 0.0 {
            outside / mixing_energy
        } else {
            0.0
        },
        mass,
        outflow_temperature: temperature,
        jet_mass,
        history: over_time,
    })
}

/// Mass-averaged stagnation temperature of the outflow \[K\].
fn outflow_temperature(history: &FlowHistory) -> Option<f64> {
    let mass: f64 = history.mass_flow.iter().map(|m| m.max(0.0)).sum();
    let heat: f64 = history
        .mass_flow
        .iter()
        .zip(&history.temperature)
        .map(|(m, t)| m.max(0.0) * t)
        .sum();
    (mass > 0.0).then(|| heat / mass)
}
