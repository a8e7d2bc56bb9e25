//! A design of another tool, scaled from the N80CB by stated rules (`rules.toml`).

mod error;
mod fastener;
mod rules;
mod trial;
mod write;

use nailnoise_quantities::dimension::{ENERGY, LENGTH, MASS};
use nailnoise_quantities::measure;

use crate::design::{Design, length_in_words};
use crate::error::Error;
use crate::wording::trimmed;
use error::broken;

pub use error::ScalingError;
pub use fastener::Fastener;
pub use rules::{Class, Rule, Rules};
pub use trial::{Settled, Shot};

/// The design that is scaled.
pub const BASE: &str = "n80cb.toml";

/// Rated gauge pressures of the tools of all classes, those of the N80CB: 70 to 120 psig \[Pa\].
pub const RATED: [f64; 2] = [70.0 * PSI, 120.0 * PSI];

/// Pound-force per square inch \[Pa\].
pub const PSI: f64 = 6_894.757_293_168;

/// A tool to make a design of: what is not given is that of its class.
#[derive(Debug, Clone)]
pub struct Request {
    /// Class of the tool, a name of `rules.toml`.
    pub class: String,
    /// Bore of the cylinder \[m\].
    pub bore: Option<f64>,
    /// Travel of the piston \[m\].
    pub stroke: Option<f64>,
    /// Mass of the whole tool without fasteners \[kg\].
    pub mass: Option<f64>,
    /// The fastener.
    pub fastener: Option<Fastener>,
}

/// A value, and whether it was given or is that of the class.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Chosen {
    /// The value in SI units.
    pub(crate) value: f64,
    /// Whether it was given.
    pub(crate) given: bool,
}

/// A tool whose values are known.
#[derive(Debug, Clone)]
pub(crate) struct Tool<'a> {
    pub(crate) name: &'a str,
    pub(crate) class: &'a Class,
    pub(crate) bore: Chosen,
    pub(crate) stroke: Chosen,
    pub(crate) mass: Chosen,
    pub(crate) fastener: Fastener,
}

/// A finished design of another tool.
#[derive(Debug, Clone)]
pub struct Scaled {
    /// The text of the design file.
    pub text: String,
    /// Its shot.
    pub settled: Settled,
    /// Description of the tool: class, bore, stroke and mass.
    pub what: String,
    /// The fastener in words.
    pub fastener: String,
    /// Drive energy that makers state for the class and its source.
    pub published: Option<(f64, String)>,
}

impl Request {
    fn tool<'a>(&self, rules: &'a Rules) -> Result<Tool<'a>, ScalingError> {
        let Some((name, class)) = rules.classes.get_key_value(&self.class) else {
            return Err(ScalingError::UnknownClass {
                class: self.class.clone(),
                known: rules.names().collect::<Vec<_>>().join(", "),
            });
        };
        let chosen = |given: Option<f64>, own: &str, dimension| -> Result<Chosen, ScalingError> {
            Ok(Chosen {
                value: given.map_or_else(|| measure(own, dimension).map_err(broken), Ok)?,
                given: given.is_some(),
            })
        };
        let fastener = match &self.fastener {
            Some(fastener) => fastener.clone(),
            None => class.nail.parse().map_err(broken)?,
        };
        Ok(Tool {
            name,
            class,
            bore: chosen(self.bore, &class.bore, LENGTH)?,
            stroke: chosen(self.stroke, &class.stroke, LENGTH)?,
            mass: chosen(self.mass, &class.mass, MASS)?,
            fastener,
        })
    }
}

/// The design of a tool under the name of its file, at the pressure and depth adjustment at which its shots drive the
/// fastener, if there are any within the rated pressures.
///
/// # Errors
/// [`ScalingError`] for an unknown class, and for dimensions that do not go together; errors of the cycle.
pub fn scaled(request: &Request, file: &str) -> Result<Scaled, Error> {
    let rules = Rules::load()?;
    let tool = request.tool(&rules)?;
    let base = Design::shipped(BASE).ok_or_else(|| broken("the base design cannot be read"))?;
    let settled = trial::settle(&|setting| {
        let text = write::text(&rules, &tool, &base, setting)?;
        Ok(Design::parse(&text, file).map_err(|source| ScalingError::Together {
            tool: tool.words(),
            source: Box::new(source),
        })?)
    })?;
    let published = match (&tool.class.energy, &tool.class.energy_source) {
        (Some(energy), Some(source)) => Some((measure(energy, ENERGY).map_err(broken)?, source.clone())),
        _ => None,
    };
    Ok(Scaled {
        text: write::text(&rules, &tool, &base, settled.setting)?,
        what: tool.words(),
        fastener: tool.fastener.words(),
        settled,
        published,
    })
}

impl Tool<'_> {
    /// "finish-nailer of 38 mm bore, 95 mm stroke and 1.2 kg".
    fn words(&self) -> String {
        let [bore, stroke] = [self.bore, self.stroke].map(|chosen| length_in_words(chosen.value));
        let mass = trimmed(self.mass.value, 3);
        format!("{} of {bore} bore, {stroke} stroke and {mass} kg", self.name)
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]

    use nailnoise_dynamics::Outcome;

    use super::*;
    use crate::design::{Provenance, Value};

    fn of(class: &str) -> Request {
        Request {
            class: class.to_owned(),
            bore: None,
            stroke: None,
            mass: None,
            fastener: None,
        }
    }

    fn design(scaled: &Scaled) -> Design {
        Design::parse(&scaled.text, concat!(env!("CARGO_MANIFEST_DIR"), "/designs/own.toml")).unwrap()
    }

    #[test]
    fn every_class_drives_its_fastener_within_the_rated_pressure_without_a_warning() {
        for class in Rules::load().unwrap().names() {
            let scaled = scaled(&of(class), "own.toml").unwrap();
            let (settled, design) = (&scaled.settled, design(&scaled));
            assert!(settled.shot.drives(), "{class}: {settled:?}");
            assert!((RATED[0]..=RATED[1]).contains(&settled.setting.pressure), "{class}");
            assert!(settled.shot.head_depth >= 0.0, "{class}: {settled:?}");
            assert!(design.warnings().is_empty(), "{class}: {:?}", design.warnings());
            // The file itself drives, not only the design of the trial.
            let outcome = crate::chain::cycle(&design).unwrap().outcome;
            assert_eq!(outcome, settled.shot.outcome, "{class}");
        }
    }

    #[test]
    fn every_scaled_value_is_marked_and_lies_within_its_range() {
        for class in ["finish-nailer", "stapler"] {
            let scaled = scaled(&of(class), "own.toml").unwrap();
            let mut marked = 0;
            for entry in design(&scaled).entries() {
                let Value::Number(value) = entry.value else { continue };
                if let Some([low, high]) = entry.range {
                    assert!(low <= value && value <= high, "{class}: {}", entry.key);
                }
                if entry.provenance == Provenance::Scaled && !entry.key.starts_with("sensors.") {
                    assert!(
                        entry.range.is_some_and(|[low, high]| low < high),
                        "{class}: {}",
                        entry.key
                    );
                    marked += 1;
                }
            }
            assert!(marked > 50, "{class}: {marked} values are marked");
        }
    }

    /// With areas as bore^2 and volumes and masses as stroke bore^2 the shot is similar: speeds are those of the base, and the
    /// energy is as the swept volume. Hose, friction and gravity are not similar.
    #[test]
    fn the_energy_of_a_stroke_is_as_the_swept_volume() {
        let energy = |bore: f64, stroke: f64| {
            let request = Request {
                bore: Some(bore),
                stroke: Some(stroke),
                fastener: Some("50 x 1.2 mm".parse().unwrap()),
                mass: Some(4.29 * (bore / 60e-3).powi(2) * stroke / 121.25e-3),
                ..of("framing-nailer")
            };
            scaled(&request, "own.toml").unwrap().settled.free_energy / (bore * bore * stroke)
        };
        let base = energy(60e-3, 121.25e-3);
        for (bore, stroke) in [(50e-3, 121.25e-3), (60e-3, 90e-3), (40e-3, 90e-3)] {
            let ratio = energy(bore, stroke) / base;
            assert!((ratio - 1.0).abs() < 0.1, "{bore} m, {stroke} m: {ratio}");
        }
    }

    #[test]
    fn the_base_scaled_to_its_own_size_is_the_base() {
        let design = design(&scaled(&of("framing-nailer"), "own.toml").unwrap());
        let base = Design::shipped(BASE).unwrap();
        assert!((design.piston.mass - base.piston.mass).abs() < 1e-12);
        assert!((design.chambers.supply_volume - base.chambers.supply_volume).abs() < 1e-12);
        assert!((design.tool.mass / base.tool.mass - 1.0).abs() < 1e-3);
    }

    #[test]
    fn a_tool_that_is_too_weak_is_told_as_such() {
        let request = Request {
            bore: Some(30e-3),
            fastener: Some("12d smooth".parse().unwrap()),
            stroke: Some(121.25e-3),
            ..of("framing-nailer")
        };
        let settled = scaled(&request, "own.toml").unwrap().settled;
        assert_eq!(settled.shot.outcome, Outcome::Underdriven);
        assert!(settled.shot.head_depth < -0.01 && settled.needed > settled.shot.energy_at_nail);
        assert_eq!(settled.setting.pressure, RATED[1], "told at the highest rated pressure");
    }

    #[test]
    fn dimensions_that_do_not_go_together_are_refused_with_the_option_to_change() {
        let request = Request {
            stroke: Some(60e-3),
            fastener: Some("12d smooth".parse().unwrap()),
            ..of("framing-nailer")
        };
        let Err(Error::Scaling(error)) = scaled(&request, "own.toml") else {
            panic!("a nail longer than the stroke");
        };
        assert!(error.remedy().contains("--stroke"), "{error}");
    }

    /// The published energy of a roofing nailer, 410 in lbf at 100 psig (Builder, 2004), within the 25 % that the moving mass
    /// and the areas of a scaled tool are uncertain by.
    #[test]
    fn a_roofing_nailer_has_the_energy_that_its_maker_states() {
        let scaled = scaled(&of("roofing-nailer"), "own.toml").unwrap();
        let (published, _) = scaled.published.clone().unwrap();
        assert!((published - 410.0 * 0.0254 * 4.448_222).abs() < 0.05);
        let ratio = scaled.settled.free_energy / published;
        assert!((0.8..1.25).contains(&ratio), "{} J", scaled.settled.free_energy);
    }
}
