//! Classes of tools and scaling rules, as stated in `rules.toml`.

use std::collections::BTreeMap;

use serde::Deserialize;

use super::error::{ScalingError, broken};

const TEXT: &str = include_str!("rules.toml");

/// Content of `rules.toml`.
#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Rules {
    /// Classes of tools by name.
    pub classes: BTreeMap<String, Class>,
    /// Rules in their order.
    pub rules: Vec<Rule>,
}

/// A class of tools with its defaults; quantities are text with a unit.
#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Class {
    /// Fasteners of the tools.
    pub what: String,
    /// Bore of the cylinder.
    pub bore: String,
    /// Stroke of the piston.
    pub stroke: String,
    /// Mass of the tool without fasteners.
    pub mass: String,
    /// Fastener, a name of `nailnoise list nails`.
    pub nail: String,
    /// Type of the magazine: `stick` or `coil`.
    pub magazine: String,
    /// Provenance of the defaults.
    pub source: String,
    /// Drive energy that a manufacturer states for a tool of the class, if known.
    pub energy: Option<String>,
    /// Source of that energy.
    pub energy_source: Option<String>,
}

/// A rule: exponents of bore, stroke and mass, all relative to the base, and the keys in its scope.
#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Rule {
    /// Description of the keys, and the reason for the scaling.
    pub what: String,
    /// Exponent of the bore.
    #[serde(default)]
    pub bore: f64,
    /// Exponent of the stroke.
    #[serde(default)]
    pub stroke: f64,
    /// Exponent of the mass of the tool.
    #[serde(default)]
    pub mass: f64,
    /// Minimum factor by which the range extends beyond the value on either side.
    #[serde(default = "least_spread")]
    pub spread: f64,
    /// Full names of the keys.
    pub keys: Vec<String>,
}

/// A value has a range of 10 % if its base has none.
fn least_spread() -> f64 {
    1.1
}

/// Ratios of bore, stroke and mass of a tool to those of the base.
#[derive(Debug, Clone, Copy)]
pub(super) struct Ratios {
    pub(super) bore: f64,
    pub(super) stroke: f64,
    pub(super) mass: f64,
}

impl Rules {
    /// The rules of the program.
    ///
    /// # Errors
    /// `None` is impossible with the rules of a tested program.
    pub fn load() -> Result<Self, ScalingError> {
        toml::from_str(TEXT).map_err(broken)
    }

    /// Names of the classes.
    pub fn names(&self) -> impl Iterator<Item = &str> {
        self.classes.keys().map(String::as_str)
    }
}

impl Rule {
    /// The factor by which values of the base are multiplied.
    pub(super) fn factor(&self, ratios: Ratios) -> f64 {
        ratios.bore.powf(self.bore) * ratios.stroke.powf(self.stroke) * ratios.mass.powf(self.mass)
    }

    /// The law as text: "bore^2 stroke^-1".
    pub fn law(&self) -> String {
        let powers = [("bore", self.bore), ("stroke", self.stroke), ("mass", self.mass)];
        let parts = powers.into_iter().filter(|(_, n)| *n != 0.0).map(|(name, n)| {
            if n == 1.0 {
                name.to_owned()
            } else {
                format!("{name}^{n}")
            }
        });
        parts.collect::<Vec<_>>().join(" ")
    }
}
