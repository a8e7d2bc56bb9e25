//! Reads the file of tap tests, `nailnoise-structures/1`.

use nailnoise_documents::{Document, KeyError, Keys, found};
use nailnoise_quantities::dimension::{DENSITY, FREQUENCY, LENGTH, MASS as WEIGHT, NUMBER, PRESSURE};
use nailnoise_quantities::{Dimension, measure, range};
use toml::de::DeValue;

use super::super::error::CalibrationError;
use super::super::fields::{error, spread, tables};
use super::tap_test::{
    AIR_SHARE, E_L, E_R, G_LR, G_LT, G_RT, INPUTS, Input, LENGTH as ALONG, Law, MASS, NU_LR, THICKNESS, TapTest, WIDTH,
};

/// Name and version of the layout.
const SCHEMA: &str = "nailnoise-structures/1";

/// Standard deviation of the model for a free body, as a share of a frequency \[E\].
const DISCREPANCY: f64 = 0.015;

/// Fewest and most peaks of a plate: three moduli are sought.
const PEAKS: [usize; 2] = [3, 16];

/// Limits of dimensions \[m\], masses \[kg\] and frequencies \[Hz\].
const DIMENSIONS: [f64; 2] = [1e-4, 10.0];
const MASSES: [f64; 2] = [1e-4, 1e3];
const FREQUENCIES: [f64; 2] = [0.1, 1e5];

/// Largest thickness, as a share of the smaller side, of a plate in the sense of the theory.
const THICKEST: f64 = 0.1;

/// Standard deviations between the middle of a range and its ends, as in a design.
const AT_ENDS: f64 = 2.0;

/// Elastic constants: place, name, dimension, an example.
const WOOD: [(usize, &str, Dimension, &str); 6] = [
    (E_L, "e_l", PRESSURE, "7 .. 17 GPa"),
    (E_R, "e_r", PRESSURE, "0.25 .. 1.6 GPa"),
    (G_LR, "g_lr", PRESSURE, "0.4 .. 1.2 GPa"),
    (G_LT, "g_lt", PRESSURE, "0.4 .. 1.2 GPa"),
    (G_RT, "g_rt", PRESSURE, "20 .. 100 MPa"),
    (NU_LR, "nu_lr", NUMBER, "0.3 .. 0.5"),
];

/// Tap tests of a file.
#[derive(Debug, Clone)]
pub(super) struct TapTests {
    /// Modes are predicted up to this frequency \[Hz\].
    pub(super) max_frequency: f64,
    pub(super) tests: Vec<TapTest>,
}

/// Reads tap tests.
///
/// # Errors
/// The first invalid key, with its place and remedy.
pub(super) fn read(document: &Document) -> Result<TapTests, CalibrationError> {
    let keys = document.table()?;
    let root = Keys::of_document(document, &keys, "file of tap tests");
    root.only(&["schema", "modes_up_to", "wood", "air", "plate"])?;
    root.required("schema", &format!("\"{SCHEMA}\""))?;
    if root.text("schema", &format!("\"{SCHEMA}\""))? != Some(SCHEMA) {
        let problem = "is another layout";
        return Err(root.error("schema", problem, format!("give \"{SCHEMA}\"")).into());
    }
    root.required("modes_up_to", "\"600 Hz\"")?;
    let max_frequency = root.quantity("modes_up_to", FREQUENCY, FREQUENCIES)?;
    let mut inputs = [Input {
        name: "",
        unit: "",
        law: Law::Normal(0.0, 0.0),
    }; INPUTS];
    let wood = group(&root, "wood", "[wood] with e_l, e_r, g_lr, g_lt, g_rt and nu_lr")?;
    wood.only(&WOOD.map(|own| own.1))?;
    for (place, name, dimension, example) in WOOD {
        inputs[place] = Input {
            name,
            unit: if dimension == PRESSURE { "Pa" } else { "" },
            law: ranged(&wood, name, dimension, example)?,
        };
    }
    let air = group(&root, "air", "[air] with density and share")?;
    air.only(&["density", "share"])?;
    air.required("density", "\"1.2 kg/m3\"")?;
    let air_density = air.quantity("density", DENSITY, [0.0, 100.0])?.unwrap_or_default();
    inputs[AIR_SHARE] = Input {
        name: "air share",
        unit: "",
        law: ranged(&air, "share", NUMBER, "0.4 .. 1")?,
    };
    let plates = tables(&root, "plate", "[plate.NAME]")?;
    if plates.is_empty() {
        let help = "add [plate.NAME] with length, width, thickness, mass, peaks and error";
        return Err(root.error("plate", "has no plate", help).into());
    }
    let tests = plates
        .iter()
        .map(|(name, table)| plate(name, table, inputs, air_density));
    Ok(TapTests {
        max_frequency: max_frequency.unwrap_or_default(),
        tests: tests.collect::<Result<_, KeyError>>()?,
    })
}

/// A group that must be in the file.
fn group<'t, 'i>(root: &Keys<'t, 'i>, name: &str, example: &str) -> Result<Keys<'t, 'i>, KeyError> {
    let missing = || root.error(name, "is missing", format!("add {example}"));
    root.table(name, example)?.ok_or_else(missing)
}

/// The distribution of `{ range = "7 .. 17 GPa" }`. The ends are two standard deviations from the middle; for a
/// modulus, those of its logarithm.
fn ranged(table: &Keys<'_, '_>, key: &str, dimension: Dimension, example: &str) -> Result<Law, KeyError> {
    let example = format!("{{ range = \"{example}\" }}");
    table.required(key, &example)?;
    let own = group(table, key, &format!("{key} = {example}"))?;
    own.only(&["range", "provenance"])?;
    own.text("provenance", "\"measured: ..\"")?;
    own.required("range", &example)?;
    let text = own.text("range", &example)?.unwrap_or_default();
    let wrong = |problem: String| own.error("range", problem, format!("give it as {example}"));
    let [low, high] = range(text, dimension, false)
        .map_err(|problem| wrong(format!("is \"{text}\": {problem}")))?
        .map(|end| end.si);
    if !(low < high && low >= 0.0) || (dimension == PRESSURE && low <= 0.0) {
        return Err(wrong(format!("is \"{text}\", which does not rise above 0")));
    }
    let moments = |low: f64, high: f64| (0.5 * (low + high), (high - low) / (2.0 * AT_ENDS));
    Ok(if dimension == PRESSURE {
        let (mean, deviation) = moments(low.ln(), high.ln());
        Law::LogNormal(mean, deviation)
    } else {
        let (mean, deviation) = moments(low, high);
        Law::Normal(mean, deviation)
    })
}

/// A dimension or mass with its error.
fn measured(table: &Keys<'_, '_>, key: &str, dimension: Dimension, limits: [f64; 2]) -> Result<Law, KeyError> {
    let example = match key {
        "mass" => "{ value = \"236.0 g\", error = \"0.2 g\" }",
        _ => "{ value = \"4.8 mm\", error = \"0.05 mm\" }",
    };
    table.required(key, example)?;
    let own = group(table, key, &format!("{key} = {example}"))?;
    own.only(&["value", "error", "rounding", "k"])?;
    own.required("value", example)?;
    let value = own.quantity("value", dimension, limits)?.unwrap_or_default();
    let deviation = error(&own, dimension)?.at(value);
    if deviation > 0.2 * value {
        return Err(own.error("value", "is below five times its error", "correct value or error"));
    }
    Ok(Law::Normal(value, deviation))
}

/// Frequencies in ascending order.
fn frequencies(table: &Keys<'_, '_>, key: &str) -> Result<Vec<f64>, KeyError> {
    const EXAMPLE: &str = "[\"47.0 Hz\", \"70.5 Hz\"]";
    let Some(value) = table.get(key) else {
        return Ok(Vec::new());
    };
    let list = value.get_ref().as_array().ok_or_else(|| {
        let problem = format!("is {}, it must be a list of frequencies", found(value.get_ref()));
        table.error(key, problem, format!("give it as {key} = {EXAMPLE}"))
    })?;
    let read = |own| {
        let hz = table.number(key, own, |text| measure(text, FREQUENCY))?;
        table.within(key, hz, FREQUENCIES, "Hz")
    };
    let list = list.iter().map(read).collect::<Result<Vec<f64>, KeyError>>()?;
    if list.windows(2).any(|pair| pair[0] >= pair[1]) {
        return Err(table.error(key, "is not in ascending order", "sort the peaks, each once"));
    }
    Ok(list)
}

fn plate(name: &str, table: &Keys<'_, '_>, mut inputs: [Input; INPUTS], air_density: f64) -> Result<TapTest, KeyError> {
    let dimensions = [(ALONG, "length"), (WIDTH, "width"), (THICKNESS, "thickness")];
    let own = ["mass", "peaks", "check", "error", "rounding", "k", "discrepancy"];
    table.only(&[&dimensions.map(|own| own.1)[..], &own].concat())?;
    let mut size = [0.0; 3];
    for (place, key) in dimensions {
        let law = measured(table, key, LENGTH, DIMENSIONS)?;
        size[place] = law.at(0.0);
        let unit = "m";
        inputs[place] = Input { name: key, unit, law };
    }
    let [length, width, thickness] = size;
    if thickness > THICKEST * length.min(width) {
        let problem = "is more than a tenth of a side, which is not a plate";
        return Err(table.error(
            "thickness",
            problem,
            "correct the dimensions, or calibrate a thinner plate",
        ));
    }
    inputs[MASS] = Input {
        name: "mass",
        unit: "kg",
        law: measured(table, "mass", WEIGHT, MASSES)?,
    };
    table.required("peaks", "[\"47.0 Hz\", \"70.5 Hz\", \"121 Hz\"]")?;
    let used = frequencies(table, "peaks")?;
    let checks = frequencies(table, "check")?;
    let [fewest, most] = PEAKS;
    if !(fewest..=most).contains(&used.len()) {
        let problem = format!("has {} frequencies", used.len());
        return Err(table.error(
            "peaks",
            problem,
            format!("give {fewest} to {most}: three moduli are sought"),
        ));
    }
    if let Some(both) = checks.iter().find(|hz| used.contains(hz)) {
        return Err(table.error(
            "check",
            format!("repeats the peak at {both} Hz"),
            "leave it out in one of the two",
        ));
    }
    let mut peaks: Vec<(f64, bool)> = used.iter().map(|hz| (*hz, false)).collect();
    peaks.extend(checks.iter().map(|hz| (*hz, true)));
    peaks.sort_by(|a, b| a.0.total_cmp(&b.0));
    let reading = error(table, FREQUENCY)?;
    let discrepancy = match table.get("discrepancy").map(|value| value.get_ref()) {
        None => DISCREPANCY,
        Some(DeValue::String(text)) if text.contains('%') => {
            let share = spread(table, "discrepancy", FREQUENCY)?;
            table.within("discrepancy", share.at(1.0), [0.0, 0.5], "")?
        }
        Some(other) => {
            let problem = format!("is {}, it must be a percentage", found(other));
            return Err(table.error("discrepancy", problem, "give it as discrepancy = \"1.5 %\""));
        }
    };
    Ok(TapTest {
        name: name.to_owned(),
        inputs,
        air_density,
        errors: peaks.iter().map(|(hz, _)| reading.at(*hz)).collect(),
        is_check: peaks.iter().map(|(_, is_check)| *is_check).collect(),
        peaks: peaks.into_iter().map(|(hz, _)| hz).collect(),
        discrepancy,
    })
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use super::*;

    const SPRUCE: &str = include_str!("../../../examples/plates/spruce.toml");

    fn of(text: &str) -> Result<TapTests, CalibrationError> {
        read(&Document::new(Path::new("plates.toml"), text))
    }

    #[test]
    fn the_example_has_ten_plates_of_six_peaks() {
        let file = of(SPRUCE).unwrap();
        assert_eq!(file.tests.len(), 10);
        assert!(
            file.tests
                .iter()
                .all(|own| own.peaks.len() == 6 && !own.is_check.contains(&true))
        );
        assert!((file.tests[0].inputs[MASS].law.at(0.0) - 0.236).abs() < 1e-12);
    }

    /// The ends of a range are two standard deviations from its middle, in the logarithm for a modulus.
    #[test]
    fn a_range_is_the_distribution_between_two_standard_deviations() {
        let inputs = of(SPRUCE).unwrap().tests[0].inputs;
        for (place, low, high) in [(E_L, 7e9, 17e9), (NU_LR, 0.3, 0.5)] {
            let law = inputs[place].law;
            assert!((law.at(-2.0) / low - 1.0).abs() < 1e-12 && (law.at(2.0) / high - 1.0).abs() < 1e-12);
        }
    }

    #[test]
    fn a_fault_is_named_with_its_line_and_remedy() {
        let faults = [
            (
                "nailnoise-structures/1",
                "nailnoise-structures/9",
                "schema",
                "another layout",
            ),
            ("\"7 .. 17 GPa\"", "\"17 .. 7 GPa\"", "wood.e_l", "give it as"),
            ("\"7 .. 17 GPa\"", "\"7 .. 17 mm\"", "wood.e_l", "give it as"),
            ("\"70.5 Hz\", ", "\"270.5 Hz\", ", "plate.1L.peaks", "ascending"),
            ("\"4.8 mm\"", "\"4.8 cm\"", "plate.1L.thickness", "not a plate"),
            ("\"4.8 mm\"", "\"4.8 kg\"", "plate.1L.thickness", "kg"),
            ("rounding = \"0.25 Hz\"", "", "plate.1L.error", "no instrument is exact"),
            ("thickness =", "thicknes =", "plate.1L.thicknes", "is it"),
            (
                "[\"47.0 Hz\", \"70.5 Hz\", \"121.0 Hz\", \"132.5 Hz\", \"174.0 Hz\", \"199.5 Hz\"]",
                "[\"47 Hz\"]",
                "plate.1L.peaks",
                "three moduli",
            ),
            ("share = {", "shares = {", "air.shares", "is it"),
            (
                "rounding = \"0.25 Hz\"",
                "rounding = \"0.25 Hz\"\ncheck = [\"47 Hz\"]",
                "plate.1L.check",
                "repeats",
            ),
        ];
        for (from, to, key, words) in faults {
            assert!(SPRUCE.contains(from), "{from}");
            let CalibrationError::Key(error) = of(&SPRUCE.replacen(from, to, 1)).unwrap_err() else {
                panic!("{key} is not a fault of a key");
            };
            let text = format!("{error}\n{}", error.help);
            assert!(text.contains(key) && text.contains(words), "{text}");
            assert!(text.contains("plates.toml, line "), "{text}");
        }
    }
}
