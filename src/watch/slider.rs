//! Sliders of the page: keys of the design with a range, and the values set on the page.

use std::fs::File;
use std::io::{self, ErrorKind, Write as _};
use std::path::{Path, PathBuf};

use nailnoise_quantities::Dimension;
use serde::Serialize;

use crate::design::{Assignment, Design, Value};
use crate::units::{Conversion, Units};
use crate::wording::readable_at;

/// Maximum number of sliders on the page.
const MOST: usize = 8;

/// Maximum number of saved designs in the same folder.
const SAVED: u32 = 10_000;

/// A key that the page can move within its range.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Slider {
    /// Full name of the key.
    pub key: String,
    /// Ends of its range, in `unit`.
    pub range: [f64; 2],
    /// Current value, in `unit`.
    pub value: f64,
    /// A readable unit; empty for plain numbers and counts.
    pub unit: String,
    /// Whether only whole numbers are values.
    pub whole: bool,
}

impl Slider {
    /// Sliders for the first of these keys that have a range in the design, in these units.
    pub fn of(design: &Design, keys: impl Iterator<Item = String>, units: Units) -> Vec<Self> {
        let entries = design.entries();
        let slider = |key: String| {
            let entry = entries.iter().find(|entry| entry.key == key)?;
            let range = entry.range.filter(|[low, high]| low < high)?;
            let (value, whole) = match entry.value {
                Value::Number(number) => (number, false),
                Value::Count(count) => (f64::from(count), true),
                _ => return None,
            };
            let (factor, unit) = match Dimension::of_unit(&entry.unit).ok()?.readable() {
                (_, radian) if radian == "rad" => {
                    let (degree, factor) = readable_at(&radian, range[1]);
                    (factor, degree.to_owned())
                }
                own => own,
            };
            let [low, high] = range.map(|end| end * factor);
            // A value outside its range is shown at the end of the slider.
            let value = value * factor;
            let (low, high, value, unit) = match Self::conversion(units, &unit, high) {
                Some(own) => (own.of(low), own.of(high), own.of(value), own.unit.to_owned()),
                None => (low, high, value, unit),
            };
            Some(Self {
                key,
                range: [low.min(value), high.max(value)],
                value,
                unit,
                whole,
            })
        };
        keys.filter_map(slider).take(MOST).collect()
    }

    /// The conversion to a unit that a design file can have.
    fn conversion(units: Units, unit: &str, largest: f64) -> Option<Conversion> {
        let own = units.conversion(unit, largest.abs())?;
        Dimension::of_unit(own.unit).is_ok().then_some(own)
    }

    /// The assignment of a value within the range; `None` for other values.
    pub(super) fn assign(&self, value: f64) -> Option<Assignment> {
        let [low, high] = self.range;
        // The page rounds the ends.
        let margin = 1e-6 * (high - low);
        let value = if self.whole { value.round() } else { value };
        let within = (low - margin..=high + margin).contains(&value);
        within
            .then(|| format!("{}={value} {}", self.key, self.unit).parse().ok())
            .flatten()
    }
}

/// Writes a design with these values, based on the design file `over`, to a free name in the same folder; returns the
/// file.
///
/// # Errors
/// The errors of the system.
pub(super) fn save(over: &Path, values: &[Assignment]) -> io::Result<PathBuf> {
    let base = over.file_name().unwrap_or_default().to_string_lossy();
    let stem = over.file_stem().unwrap_or_default().to_string_lossy();
    let lines = values.iter().map(|own| format!("{own}\n"));
    let text = format!(
        "base = {}\n\n{}",
        toml::Value::String(base.into_owned()),
        lines.collect::<String>()
    );
    for number in 1..SAVED {
        let path = over.with_file_name(format!("{stem}-{number}.toml"));
        match File::create_new(&path) {
            Ok(mut file) => {
                file.write_all(text.as_bytes())?;
                file.sync_all()?;
                return Ok(path);
            }
            Err(error) if error.kind() == ErrorKind::AlreadyExists => {}
            Err(error) => return Err(error),
        }
    }
    Err(ErrorKind::AlreadyExists.into())
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::*;

    const SHIPPED: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/designs/n80cb.toml");

    fn sliders(keys: &[&str]) -> Vec<Slider> {
        Slider::of(
            &Design::load(SHIPPED).unwrap(),
            keys.iter().map(|key| (*key).to_owned()),
            Units::Si,
        )
    }

    #[test]
    fn keys_with_a_range_have_sliders_in_readable_units() {
        let found = sliders(&["piston.mass", "wood.species", "no.key", "supply.pressure"]);
        let keys: Vec<(&str, &str)> = found.iter().map(|own| (own.key.as_str(), own.unit.as_str())).collect();
        assert_eq!(keys[0].0, "piston.mass");
        assert!(keys.iter().all(|(_, unit)| !unit.is_empty()), "{keys:?}");
        assert!(
            found
                .iter()
                .all(|own| own.range[0] <= own.value && own.value <= own.range[1])
        );
    }

    #[test]
    fn an_angle_is_in_degrees_which_a_design_can_have() {
        let own = &sliders(&["head_valve.intake_angle"])[0];
        let design = Design::load_with(SHIPPED, &[own.assign(own.value).unwrap()]).unwrap();
        assert_eq!(own.unit, "deg");
        assert!(
            (design.head_valve.intake_angle.to_degrees() - own.value).abs() < 1e-9,
            "{own:?}"
        );
    }

    #[test]
    fn a_value_within_the_range_is_the_designs_and_another_is_none() {
        let own = &sliders(&["piston.mass"])[0];
        let [low, high] = own.range;
        let design = Design::load_with(SHIPPED, &[own.assign(high).unwrap()]).unwrap();
        let again = &Slider::of(&design, ["piston.mass".to_owned()].into_iter(), Units::Si)[0];
        assert!((again.value / high - 1.0).abs() < 1e-9, "{again:?}");
        assert_eq!(own.assign(low - 0.1 * (high - low)), None);
        assert_eq!(own.assign(f64::NAN), None);
    }

    #[test]
    fn a_saved_design_can_be_read_and_replaces_no_other() {
        let folder = std::env::temp_dir().join(format!("nailnoise-sliders-{}", std::process::id()));
        std::fs::create_dir_all(&folder).unwrap();
        let own = folder.join("own.toml");
        std::fs::write(&own, format!("base = {:?}\n", SHIPPED)).unwrap();
        let values = ["exhaust.holes=7".parse::<Assignment>().unwrap()];
        let files: Vec<PathBuf> = (0..2).map(|_| save(&own, &values).unwrap()).collect();
        assert_ne!(files[0], files[1]);
        for file in &files {
            assert_eq!(Design::load(file).unwrap().exhaust.holes, 7);
        }
        std::fs::remove_dir_all(&folder).unwrap();
    }
}
