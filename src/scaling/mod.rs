//! A design of another tool, scaled from the N80CB by stated rules (`rules.toml`).

mod error;
mod fastener;
mod rules;
mod tool;
mod trial;
mod write;

use nailnoise_quantities::dimension::{ENERGY, LENGTH, MASS};
use nailnoise_quantities::measure;

use crate::design::Design;
use crate::error::Error;
use error::broken;
use tool::{Chosen, Tool};

pub use error::ScalingError;
pub use fastener::Fastener;
pub use rules::{Class, Rule, Rules};
pub use tool::{PSI, RATED};
pub use trial::{Setting, Settled, TrialShot};

/// The design from which other tools are scaled.
pub const BASE: &str = "n80cb.toml";

/// The data given for a new tool; missing data are taken from its class.
#[derive(Debug, Clone)]
pub struct Request {
    /// Class of the tool: a name in `rules.toml`.
    pub class: String,
    /// Path of the shipped design that is scaled: [`BASE`], or a design of the N80CB on another support.
    pub base: &'static str,
    /// Bore of the cylinder \[m\].
    pub bore: Option<f64>,
    /// Stroke of the piston \[m\].
    pub stroke: Option<f64>,
    /// Mass of the complete tool without fasteners \[kg\].
    pub mass: Option<f64>,
    /// The fastener.
    pub fastener: Option<Fastener>,
}

/// A finished design of a scaled tool.
#[derive(Debug, Clone)]
pub struct Scaled {
    /// The text of the design file.
    pub text: String,
    /// Its shot.
    pub settled: Settled,
    /// Description of the tool: class, bore, stroke and mass.
    pub what: String,
    /// Description of the fastener.
    pub fastener: String,
    /// Drive energy that manufacturers state for the class, with its source.
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
            base: self.base,
            bore: chosen(self.bore, &class.bore, LENGTH)?,
            stroke: chosen(self.stroke, &class.stroke, LENGTH)?,
            mass: chosen(self.mass, &class.mass, MASS)?,
            fastener,
        })
    }
}

/// The design of a tool with the name of its file. Pressure and depth adjustment are such that its shots drive the
/// fastener, if this is possible within the rated pressures.
///
/// # Errors
/// [`ScalingError`] for an unknown class or conflicting dimensions; errors of the cycle.
pub fn scaled(request: &Request, file: &str) -> Result<Scaled, Error> {
    let rules = Rules::load()?;
    let tool = request.tool(&rules)?;
    let base = Design::shipped(request.base).ok_or_else(|| broken("the base design cannot be read"))?;
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
