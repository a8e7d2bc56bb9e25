//! Converts the numbers of a file to Pa and m/s²: sensitivities, full scales, units and calibrators.

use nailnoise_acoustics::signals::fourier::{Transform, TransformSettings};
use nailnoise_quantities::dimension::{
    ACCELERATION, PRESSURE, VOLTAGE, VOLTAGE_PER_ACCELERATION, VOLTAGE_PER_PRESSURE,
};
use nailnoise_quantities::{Dimension, measure};

use super::fault::Fault;
use super::{Numbers, Selector, Track};
use nailnoise_documents::tables::{dimension_of, si_of, spelled};

/// Standard acceleration of free fall \[m/s²\] (ISO 80000-3).
const STANDARD_GRAVITY: f64 = 9.806_65;

/// Reference sound pressure \[Pa\] (ISO 1683).
const REFERENCE: f64 = 20e-6;

/// Quantity measured by a channel.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Quantity {
    /// Sound or gas pressure \[Pa\].
    Pressure,
    /// Acceleration \[m/s²\].
    Acceleration,
    /// The voltage of a switch \[V\].
    Voltage,
}

impl Quantity {
    fn dimension(self) -> Dimension {
        match self {
            Self::Pressure => PRESSURE,
            Self::Acceleration => ACCELERATION,
            Self::Voltage => VOLTAGE,
        }
    }

    /// Its SI unit.
    pub fn unit(self) -> &'static str {
        match self {
            Self::Pressure => "Pa",
            Self::Acceleration => "m/s2",
            Self::Voltage => "V",
        }
    }

    /// Accepted units, for remedies.
    pub fn examples(self) -> &'static str {
        match self {
            Self::Pressure => "Pa, kPa",
            Self::Acceleration => "m/s2, g",
            Self::Voltage => "V, mV",
        }
    }

    /// Parses a text as a value in SI units; `g` is the standard acceleration of free fall.
    ///
    /// # Errors
    /// A description of the error in the text.
    pub fn read(self, text: &str) -> Result<f64, String> {
        let falls = (self == Self::Acceleration)
            .then(|| text.trim().strip_suffix('g'))
            .flatten();
        match falls.and_then(|number| number.trim().parse::<f64>().ok()) {
            Some(number) if number.is_finite() => Ok(number * STANDARD_GRAVITY),
            _ => measure(text, self.dimension()),
        }
    }

    /// Smallest and largest value of a full scale, a threshold or a calibrator, in SI units.
    pub fn limits(self) -> [f64; 2] {
        match self {
            // From the threshold of hearing, 20 uPa, to beyond the pressures of explosives.
            Self::Pressure => [1e-6, 1e10],
            // From a seismometer to beyond the largest shock accelerometers, 1e6 g.
            Self::Acceleration => [1e-7, 1e8],
            Self::Voltage => [1e-9, 1e4],
        }
    }

    /// Its name with an article, for messages.
    fn noun(self) -> &'static str {
        match self {
            Self::Pressure => "a pressure",
            Self::Acceleration => "an acceleration",
            Self::Voltage => "a voltage",
        }
    }

    /// The value of one unit, given an instrument's label.
    fn of_unit(self, unit: &str) -> Result<f64, String> {
        let falls = self == Self::Acceleration && spelled(unit) == "g";
        if falls {
            return Ok(STANDARD_GRAVITY);
        }
        si_of(unit, self.dimension())
    }

    /// Description of a label that belongs to a different quantity than this one or the sensor's voltage. None for a
    /// label that is not a unit.
    fn contradicted_by(self, label: &str) -> Option<String> {
        if spelled(label).to_lowercase().starts_with("db") {
            return Some(format!("levels, in \"{label}\""));
        }
        let other = dimension_of(label).filter(|_| Unit::read(label, self).is_err())?;
        Some(match spelled(label).as_str() {
            "g" => format!("an acceleration or a mass, in \"{label}\""),
            _ => format!("{other}, in \"{label}\""),
        })
    }

    /// Parses a sensitivity, such as "50 mV/Pa" or "10 mV/g", in V per SI unit.
    ///
    /// # Errors
    /// A description of the error in the text.
    pub fn sensitivity(self, text: &str) -> Result<f64, String> {
        match (self, text.trim().strip_suffix("/g")) {
            (Self::Pressure, _) => measure(text, VOLTAGE_PER_PRESSURE),
            (Self::Acceleration, Some(voltage)) => measure(voltage, VOLTAGE).map(|volts| volts / STANDARD_GRAVITY),
            (Self::Acceleration, None) => measure(text, VOLTAGE_PER_ACCELERATION),
            (Self::Voltage, _) => Err("is a channel in V, which has no sensitivity".to_owned()),
        }
    }
}

/// The input that produces a recorder's largest number.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum FullScale {
    /// In V, after a sensor with a known sensitivity.
    Volts(f64),
    /// In the channel's quantity, in SI units.
    Quantity(f64),
}

/// A calibrator recording for a microphone or an accelerometer.
#[derive(Debug, Clone, PartialEq)]
pub struct Calibrator {
    /// The file, relative to the manifest.
    pub file: String,
    /// Its channel.
    pub selector: Selector,
    /// RMS of the tone in the channel's SI unit.
    pub rms: f64,
    /// Frequency of the tone \[Hz\].
    pub frequency: f64,
    /// SI units per number of the file, once the recording has been read.
    pub factor: Option<f64>,
}

/// Scale of the numbers of a channel according to the manifest.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Calibration {
    /// Sensitivity \[V per SI unit\].
    pub sensitivity: Option<f64>,
    /// Full scale.
    pub full_scale: Option<FullScale>,
    /// Unit of the file's numbers.
    pub unit: Option<String>,
    /// Calibrator recording.
    pub calibrator: Option<Calibrator>,
}

/// How the numbers of a track are converted to SI units.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Scale {
    /// SI units per number.
    pub(super) factor: f64,
    /// Full scale as a number of the file, if known.
    pub(super) full: Option<f64>,
}

/// A unit of the quantity, or of the sensor's voltage.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Unit {
    Quantity(f64),
    Volts(f64),
}

impl Unit {
    fn read(text: &str, quantity: Quantity) -> Result<Self, String> {
        let own = quantity.of_unit(text);
        own.map(Self::Quantity)
            .or_else(|problem| Quantity::Voltage.of_unit(text).map(Self::Volts).map_err(|_| problem))
    }

    fn differs(self, other: Self) -> bool {
        match (self, other) {
            (Self::Quantity(a), Self::Quantity(b)) | (Self::Volts(a), Self::Volts(b)) => (a - b).abs() > 1e-9 * a.abs(),
            _ => true,
        }
    }
}

impl Calibration {
    /// Checks a unit of the manifest.
    ///
    /// # Errors
    /// A description of the error.
    pub fn check_unit(unit: &str, quantity: Quantity) -> Result<(), String> {
        Unit::read(unit, quantity).map(drop)
    }

    /// Whether the recorder's full scale is known, so that clipping can be detected.
    pub fn limited(&self) -> bool {
        self.full_scale.is_some() || self.calibrator.is_some()
    }

    /// The scale of a track.
    pub(super) fn scale(&self, track: &Track, quantity: Quantity) -> Result<Scale, Fault> {
        let none = |why| Err(Fault::NoCalibration { why });
        contradiction(track, quantity)?;
        let in_unit = track.numbers == Numbers::InUnit;
        if let Some(calibrator) = &self.calibrator {
            let Some(factor) = calibrator.factor else {
                return none("the calibrator's record has not been read");
            };
            let full = (!in_unit).then_some(1.0);
            return Ok(Scale { factor, full });
        }
        match (self.unit(track, quantity)?, self.sensitivity, self.full_scale) {
            (Some(_), _, _) if track.numbers == Numbers::Integers => {
                none("`unit` is given, and the file contains integers, which have no unit")
            }
            (Some(Unit::Quantity(factor)), None, full) => Ok(Scale {
                factor,
                full: match full {
                    Some(FullScale::Quantity(value)) => Some(value / factor),
                    _ => None,
                },
            }),
            (Some(Unit::Quantity(_)), Some(_), _) => {
                none("the numbers are in a unit of the quantity already, and `sensitivity` contradicts that")
            }
            (Some(Unit::Volts(volts)), Some(sensitivity), full) => Ok(Scale {
                factor: volts / sensitivity,
                full: match full {
                    Some(FullScale::Volts(value)) => Some(value / volts),
                    _ => None,
                },
            }),
            (Some(Unit::Volts(_)), None, _) => none("the numbers are in V, and `sensitivity` is missing"),
            (None, _, _) if in_unit => none("neither the manifest nor the file states a unit"),
            (None, Some(sensitivity), Some(FullScale::Volts(volts))) => Ok(Scale {
                factor: volts / sensitivity,
                full: Some(1.0),
            }),
            (None, None, Some(FullScale::Quantity(value))) => Ok(Scale {
                factor: value,
                full: Some(1.0),
            }),
            (None, Some(_), _) => none("`sensitivity` is given without `full_scale` in V"),
            (None, None, _) => {
                none("the file contains fractions of full scale, and the manifest does not state the full scale")
            }
        }
    }

    /// The unit according to the manifest and the file, which must agree.
    fn unit(&self, track: &Track, quantity: Quantity) -> Result<Option<Unit>, Fault> {
        let label = (!track.unit.is_empty()).then(|| Unit::read(&track.unit, quantity));
        let Some(given) = &self.unit else {
            return label.transpose().map_err(|problem| Fault::Unit {
                unit: track.unit.clone(),
                problem,
            });
        };
        let given_unit = Unit::read(given, quantity).map_err(|problem| Fault::Unit {
            unit: given.clone(),
            problem,
        })?;
        match label {
            // A label that is not a unit, such as "EU", contradicts nothing.
            Some(Ok(label)) if label.differs(given_unit) => Err(Fault::UnitsDiffer {
                manifest: given.clone(),
                file: track.unit.clone(),
            }),
            _ => Ok(Some(given_unit)),
        }
    }
}

/// Rejects a track that the file declares to be a different quantity, whatever the manifest states about its numbers.
fn contradiction(track: &Track, quantity: Quantity) -> Result<(), Fault> {
    let refuse = |found: String| {
        Err(Fault::OtherQuantity {
            expected: quantity.noun(),
            found,
        })
    };
    if let Some(found) = quantity.contradicted_by(&track.unit) {
        return refuse(found);
    }
    // A label that can be parsed takes precedence over the data type, which many programs leave at a default.
    let labelled = Unit::read(&track.unit, quantity).is_ok();
    match track.measures.filter(|own| !labelled && *own != quantity.dimension()) {
        Some(other) => refuse(format!("{other} by its specific data type")),
        None => Ok(()),
    }
}

/// RMS value of a calibrator's level in SI units: "94 dB" re 20 uPa, or an RMS value such as "10 m/s2".
///
/// # Errors
/// A description of the error in the text.
pub fn calibrator_rms(text: &str, quantity: Quantity) -> Result<f64, String> {
    let Some(level) = text.trim().strip_suffix("dB") else {
        return quantity.read(text);
    };
    match level.trim().parse::<f64>() {
        Ok(level) if quantity == Quantity::Pressure && (0.0..=200.0).contains(&level) => {
            Ok(REFERENCE * 10f64.powf(level / 20.0))
        }
        Ok(_) if quantity != Quantity::Pressure => {
            Err("a level in dB is a sound pressure; give an RMS in m/s2".to_owned())
        }
        _ => Err("a level is 0 to 200 dB re 20 uPa".to_owned()),
    }
}

/// Relative half width of the band around a calibrator's tone: twice the tolerance of a class 2 calibrator (2 %, IEC
/// 60942).
const TONE: f64 = 0.04;

/// Smallest share of the record's energy, without its mean, that must be in the band of the tone.
const PURITY: f64 = 0.5;

/// Smallest duration of a calibrator recording \[s\].
const TONE_DURATION: f64 = 0.5;

impl Calibrator {
    /// SI units per number of a calibrator recording: the RMS of its tone from the energy of the Hann-windowed record w
    /// x in the tone's band,
    ///
    /// ```text
    /// rms^2 = 2 sum_f |X(f)|^2 df / (dt sum w^2)
    /// ```
    ///
    /// so that noise and harmonics of the calibrator do not matter, and its frequency need not be exact.
    pub fn measured(&self, track: &Track) -> Result<f64, Fault> {
        let duration = track.samples.len() as f64 / track.rate;
        if duration < TONE_DURATION {
            return Err(Fault::ShortTone {
                duration,
                needed: TONE_DURATION,
            });
        }
        let count = track.samples.len() as f64;
        let mean = track.samples.iter().sum::<f64>() / count;
        let window = |index: usize| (std::f64::consts::PI * (index as f64 + 0.5) / count).sin().powi(2);
        let windowed: Vec<f64> = track
            .samples
            .iter()
            .enumerate()
            .map(|(i, x)| window(i) * (x - mean))
            .collect();
        let interval = 1.0 / track.rate;
        let settings = TransformSettings {
            range_hz: [(1.0 - TONE) * self.frequency, (1.0 + TONE) * self.frequency],
            taper: 0.0,
            padding: 1.0,
        };
        let no_tone = |share: f64| Fault::NoTone {
            frequency: self.frequency,
            share,
            band: TONE,
        };
        let transform = Transform::new(windowed.len(), interval, &settings).map_err(|_| no_tone(0.0))?;
        let spectrum = transform.apply(&windowed).map_err(|_| no_tone(0.0))?;
        let tone = 2.0 * transform.resolution() * spectrum.iter().map(|x| x.norm_sqr()).sum::<f64>();
        let energy = interval * windowed.iter().map(|x| x * x).sum::<f64>();
        let share = if energy > 0.0 { tone / energy } else { 0.0 };
        if share < PURITY {
            return Err(no_tone(share));
        }
        let weight = interval * (0..windowed.len()).map(|index| window(index).powi(2)).sum::<f64>();
        Ok(self.rms / (tone / weight).sqrt())
    }
}
