//! A cold subsonic jet of NASA's small hot jet rig, and its scaling to the holes of a nailer.

use nailnoise_acoustics::jets::{
    ExhaustSettings, FlowHistory, Jet, Opening, Outlet, ReceivedNoise, exhaust_noise, fine_scale_shape,
};
use nailnoise_acoustics::signals::fourier::TransformSettings;
use nailnoise_acoustics::signals::{REFERENCE_PRESSURE, Weighting};
use nailnoise_acoustics::{Air, GAS_CONSTANT, HEAT_RATIO};

use super::row::{Case, Row};
use crate::decibels::energy_sum;
use crate::error::Error;

const WHOLE: Case = Case {
    name: "cold jet, setpoint 7, overall",
    source: RIG,
};

const SPECTRUM: Case = Case {
    name: "cold jet, setpoint 7, third octaves",
    source: RIG,
};

/// The rig and where its spectra were published.
const RIG: &str = "NASA small hot jet acoustic rig; spectra with Gryazev et al., AIAA J. 2021, doi 10.2514/1.J060896";

const SCALED: Case = Case {
    name: "cold jet, scaled to 1 mm at 1 m",
    source: "setpoint 7 by p² ~ d²/r²; fit to millimetre jets (Maa) in Wei et al., J. Applied Acoustics 38, 378 (2019)",
};

const HOLES: Case = Case {
    name: "cold jet, scaled to holes of a nailer at 1 m",
    source: "setpoint 7 by p² ~ d²/r² and the Strouhal number, third octaves up to 10 kHz",
};

const SHAPE: Case = Case {
    name: "fine-scale similarity spectrum, peak at St 0.4",
    source: "Tam, Golebiowski and Seiner, AIAA 96-1716 (1996), with the overall level and the peak of setpoint 7",
};

/// Strouhal number of the peak per hertz with which [`SHAPE`] agrees with the rig's spectra; no computed level uses it.
const PEAK: f64 = 0.4;

/// Strouhal numbers of [`SHAPE`].
const COMPARED: [f64; 2] = [0.1, 3.2];

/// Diameters of holes \[m\], and the highest third octave of a nailer's levels \[Hz\].
const HOLE_DIAMETERS: [f64; 2] = [3e-3, 6e-3];
const HIGHEST: f64 = 10.0e3;

const DIAMETER: f64 = 0.0508;
const SPEED: f64 = 302.0;
const SOUND_SPEED: f64 = 340.0;
const DISTANCE: f64 = 5.08;

/// Angles from the downstream axis \[degrees\] with the overall levels there \[dB\].
const OVERALL: [[f64; 2]; 2] = [[60.0, 99.6], [90.0, 96.02]];

/// Third octaves, lossless: Strouhal number f d/U, level \[dB\] at 60 and at 90 degrees.
const BANDS: [[f64; 3]; 28] = [
    [0.0316, 67.81, 65.40],
    [0.0398, 70.27, 68.36],
    [0.0501, 72.49, 70.17],
    [0.0631, 74.77, 72.00],
    [0.0794, 77.10, 73.98],
    [0.1, 79.05, 76.11],
    [0.1259, 80.85, 77.83],
    [0.1585, 82.87, 79.31],
    [0.1995, 84.24, 80.49],
    [0.2512, 85.22, 81.83],
    [0.3162, 86.65, 82.19],
    [0.3981, 87.31, 83.32],
    [0.5012, 87.91, 83.63],
    [0.631, 88.21, 84.08],
    [0.7943, 88.28, 84.27],
    [1.0, 88.37, 84.48],
    [1.2589, 88.26, 84.44],
    [1.5849, 88.09, 84.45],
    [1.9953, 88.00, 84.38],
    [2.5119, 87.52, 84.11],
    [3.1623, 86.86, 83.71],
    [3.9811, 85.67, 83.10],
    [5.0119, 85.16, 82.29],
    [6.3096, 83.73, 81.09],
    [7.9433, 82.51, 79.78],
    [10.0, 81.25, 78.49],
    [12.5893, 79.68, 77.35],
    [15.8489, 76.01, 74.26],
];

/// Differences stated in `docs/limits.md` \[dB\]: too loud at low Strouhal numbers, too quiet at high ones.
const STATED: [f64; 2] = [-16.0, 8.5];

/// The same for the audible part of the spectrum of small holes \[dB\].
const STATED_AUDIBLE: [f64; 2] = [2.0, 7.0];

/// Frequency range of the analysis \[Hz\]: slightly wider than the outermost bands.
const RANGE_HZ: [f64; 2] = [100.0, 120_000.0];

/// The air of the rig, with a jet from a reservoir at the same temperature.
fn air() -> Result<Air, Error> {
    let temperature = SOUND_SPEED * SOUND_SPEED / (HEAT_RATIO * GAS_CONSTANT);
    Ok(Air::at(temperature, 101_325.0)?)
}

/// Ratio of the pressure of a reservoir at ambient temperature, whose jet reaches [`SPEED`], to ambient pressure.
fn pressure_ratio(air: &Air) -> f64 {
    let cooling = (HEAT_RATIO - 1.0) * SPEED * SPEED / (2.0 * HEAT_RATIO * GAS_CONSTANT * air.temperature);
    (1.0 - cooling).powf(-HEAT_RATIO / (HEAT_RATIO - 1.0))
}

/// Exposure of a steady jet of 20 ms at an angle \[rad\] from its axis, and its duration \[s\].
fn received(angle: f64) -> Result<Steady, Error> {
    let air = air()?;
    let pressure = pressure_ratio(&air) * air.pressure;
    let opening = Opening {
        count: 1,
        diameter: DIAMETER,
        discharge_coefficient: 1.0,
        pitch: None,
    };
    let samples = 5000;
    let sample_interval = 4e-6;
    let flow = Jet::expand(pressure, air.temperature, &air).map_or(0.0, |jet| jet.mass_flow(opening.effective_area()));
    let history = FlowHistory {
        sample_interval,
        mass_flow: vec![flow; samples],
        pressure: vec![pressure; samples],
        temperature: vec![air.temperature; samples],
        back_pressure: None,
    };
    let settings = ExhaustSettings {
        transform: TransformSettings {
            range_hz: RANGE_HZ,
            ..TransformSettings::default()
        },
        unsteady_flow: false,
        ..ExhaustSettings::default()
    };
    let noise = exhaust_noise("nozzle", &history, &opening, &air, &settings)?;
    let outlet = Outlet {
        position: [0.0; 3],
        directions: vec![[1.0, 0.0, 0.0]],
    };
    let (sine, cosine) = angle.sin_cos();
    Ok(Steady {
        noise: noise.at(&outlet, [DISTANCE * cosine, DISTANCE * sine, 0.0], None, &air)?,
        seconds: samples as f64 * sample_interval,
    })
}

/// The exposure at a point over the duration of a steady jet.
struct Steady {
    noise: ReceivedNoise,
    seconds: f64,
}

impl Steady {
    /// Sound pressure level between two frequencies \[dB\].
    fn level(&self, range_hz: [f64; 2]) -> f64 {
        let p2 = self.noise.exposure(range_hz, Weighting::Z) / self.seconds;
        10.0 * (p2 / REFERENCE_PRESSURE.powi(2)).log10()
    }
}

/// Half a third octave, as a ratio of frequencies.
fn half_band() -> f64 {
    10f64.powf(0.05)
}

/// The levels of a column of [`BANDS`].
fn measured(column: usize) -> Vec<f64> {
    BANDS.iter().map(|band| band[1 + column]).collect()
}

/// Third octaves of the similarity spectrum about [`PEAK`] with the overall level of a column of [`BANDS`].
fn similarity(column: usize) -> Vec<Row> {
    const PARTS: u32 = 20;
    let third_octave = |strouhal: f64| {
        let part = |i: u32| {
            let x = strouhal / PEAK * half_band().powf(2.0 * (f64::from(i) + 0.5) / f64::from(PARTS) - 1.0);
            x * 10f64.powf(0.1 * fine_scale_shape(x))
        };
        10.0 * (0..PARTS).map(part).sum::<f64>().log10()
    };
    let levels: Vec<f64> = BANDS.iter().map(|band| third_octave(band[0])).collect();
    let reference = measured(column);
    let gain = energy_sum(reference.iter().copied()) - energy_sum(levels.iter().copied());
    let compared = BANDS.iter().zip(levels).zip(reference);
    compared
        .filter(|((band, _), _)| (COMPARED[0]..COMPARED[1]).contains(&band[0]))
        .map(|((band, level), reference)| {
            let quantity = format!("{} degrees, St {}, dB", OVERALL[column][0], band[0]);
            SHAPE.row(quantity, reference, level + gain).within(3.0)
        })
        .collect()
}

/// A-weighted levels at 1 m of holes with the spectra of a column of [`BANDS`], as measured and as computed.
fn holes(column: usize, computed: &[f64]) -> Vec<Row> {
    let of_hole = |diameter: f64| {
        let scale = 20.0 * (diameter / DIAMETER * DISTANCE).log10();
        let hz = |strouhal: f64| strouhal * SPEED / diameter;
        let level = |levels: &[f64]| {
            let bands = BANDS.iter().zip(levels);
            let audible = bands.filter(|(band, _)| hz(band[0]) < HIGHEST * half_band());
            energy_sum(audible.map(|(band, level)| level + scale + Weighting::A.db(hz(band[0]))))
        };
        let [degrees, _] = OVERALL[column];
        let lowest = 1e-3 * hz(BANDS[0][0]);
        let quantity = format!("{degrees} degrees, {} mm, {lowest:.1} to 10 kHz, dB(A)", 1e3 * diameter);
        let row = HOLES.row(quantity, level(&measured(column)), level(computed));
        row.within(2.0).documented(STATED_AUDIBLE)
    };
    HOLE_DIAMETERS.map(of_hole).into()
}

pub(super) fn rows() -> Result<Vec<Row>, Error> {
    let (mut rows, mut spectrum, mut shape, mut audible) = (Vec::new(), Vec::new(), Vec::new(), Vec::new());
    for (column, [degrees, overall]) in OVERALL.into_iter().enumerate() {
        let steady = received(degrees.to_radians())?;
        let row = WHOLE.row(format!("{degrees} degrees, dB"), overall, steady.level(RANGE_HZ));
        rows.push(row.within(2.0));
        let level = |band: &[f64; 3]| {
            let hz = band[0] * SPEED / DIAMETER;
            steady.level([hz / half_band(), hz * half_band()])
        };
        let computed: Vec<f64> = BANDS.iter().map(level).collect();
        for (band, computed) in BANDS.iter().zip(&computed) {
            let quantity = format!("{degrees} degrees, St {}, dB", band[0]);
            let row = SPECTRUM.row(quantity, band[1 + column], *computed);
            spectrum.push(row.within(3.0).documented(STATED));
        }
        shape.extend(similarity(column));
        audible.extend(holes(column, &computed));
    }
    let computed = rows.last().map_or(f64::NAN, |row| row.computed);
    rows.append(&mut spectrum);
    rows.append(&mut shape);
    // From 50.8 mm at 5.08 m to 1 mm at 1 m.
    let scale = -20.0 * (1e3 * DIAMETER / DISTANCE).log10();
    let ratio = pressure_ratio(&air()?);
    let fit = 80.0 + 20.0 * ((ratio - 1.0).powi(2) / (ratio - 0.5)).log10();
    let nozzle = OVERALL[1][1] + scale;
    for (what, reference, computed) in [
        ("computed against setpoint 7", nozzle, computed + scale),
        ("computed against the fit", fit, computed + scale),
        ("the fit against setpoint 7", nozzle, fit),
    ] {
        rows.push(
            SCALED
                .row(format!("90 degrees, {what}, dB"), reference, computed)
                .within(2.0),
        );
    }
    rows.append(&mut audible);
    Ok(rows)
}
