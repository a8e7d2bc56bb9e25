//! The text of a scaled design.

use std::fmt::Write as _;

use nailnoise_penetration::Specimen;
use nailnoise_quantities::{Group as _, Kind};

use super::error::{ScalingError, broken};
use super::fastener::Fastener;
use super::rules::{Ratios, Rule, Rules};
use super::tool::{Chosen, PSI, RATED, Tool};
use super::trial::Setting;
use crate::design::{Design, Entry, Value, quantity_in_words};
use crate::shipped::file_name;

/// Distance of the waiting nail's tip from the end of the nose \[m\], as in the base.
const TIP_INSIDE: f64 = 4e-3;

/// Crown of the medium staples of the catalogue, 7/16 in \[m\].
const CROWN: f64 = 11.11e-3;

/// Head diameter of the base's nail, for which the wood has the stiffness k_w = H_M \[m\].
const HEAD: f64 = 7.6e-3;

/// Thinnest shank that was tested \[m\].
const THINNEST: f64 = 2.032e-3;

/// Stiffness of a soft tip: rubber of 10 MPa, 3 mm thick, below the face of a small nose with an area of 170 mm2
/// \[N/m\].
const TIP_STIFFNESS: f64 = 0.57e6;

/// Damping ratio of a soft tip, of rubber with a loss factor near 0.4.
const TIP_DAMPING: f64 = 0.2;

/// Text of the design of a tool, as differences from the base, at a pressure and depth adjustment.
pub(super) fn text(rules: &Rules, tool: &Tool, base: &Design, setting: Setting) -> Result<String, ScalingError> {
    let entries = base.entries();
    let mut file = File {
        base,
        entries: &entries,
        text: head(tool),
    };
    let of_base = |key: &str| file.number(key);
    let moving = of_base("piston.mass")? + of_base("head_valve.mass")?;
    let ratios = Ratios {
        bore: tool.bore.value / of_base("piston.bore")?,
        stroke: tool.stroke.value / of_base("piston.stroke")?,
        mass: tool.mass.value / (of_base("tool.mass")? + moving),
    };
    file.given(tool, ratios, setting)?;
    file.nail(tool)?;
    for rule in &rules.rules {
        file.rule(rule, ratios, setting)?;
    }
    file.handle_sensor(rules, ratios)?;
    Ok(file.text)
}

fn head(tool: &Tool) -> String {
    format!(
        "# A {}, scaled from the N80CB\n\
         # by the rules of `nailnoise init --like` (docs/own-tool.md). Every value below has a range and says where \
         it comes\n\
         # from; \"scaled\" are those of the rules. All other values are those of the base. Replace what you know, in \
         the order\n\
         # of docs/own-tool.md.\n\
         # Magazine: {}. The model has a round one for every tool.\n\n\
         base = \"{}\"\n",
        tool.words(),
        tool.class.magazine,
        file_name(tool.base)
    )
}

/// A design file being written.
struct File<'a> {
    base: &'a Design,
    entries: &'a [Entry],
    text: String,
}

impl File<'_> {
    fn entry(&self, key: &str) -> Result<&Entry, ScalingError> {
        let found = self.entries.iter().find(|entry| entry.key == key);
        found.ok_or_else(|| broken(format!("the base has no key {key}")))
    }

    /// A number of the base in SI units.
    fn number(&self, key: &str) -> Result<f64, ScalingError> {
        match self.entry(key)?.value {
            Value::Number(number) => Ok(number),
            _ => Err(broken(format!("{key} is not a number"))),
        }
    }

    fn line(&mut self, text: &str) {
        self.text.push_str(text);
        self.text.push('\n');
    }

    /// One key with its range \[SI\] and provenance.
    fn key(&mut self, key: &str, value: f64, range: [f64; 2], provenance: &str) -> Result<(), ScalingError> {
        let mut values = self.base.clone();
        let Some((spec, _)) = values.key_mut(key) else {
            return Err(broken(format!("there is no key {key}")));
        };
        let Kind::Quantity { dimension, .. } = spec.kind else {
            return Err(broken(format!("{key} is not a quantity")));
        };
        let [value, low, high] = [value, range[0], range[1]].map(|x| quantity_in_words(x, dimension));
        let (number, unit) = low.split_once(' ').unwrap_or((&low, ""));
        // In a range, the unit follows its upper end only.
        let quoted = |text: &str| {
            if unit.is_empty() {
                text.to_owned()
            } else {
                format!("\"{text}\"")
            }
        };
        let _ = writeln!(
            self.text,
            "{key} = {{ value = {}, range = \"{number} .. {high}\", provenance = \"{provenance}\" }}",
            quoted(&value)
        );
        Ok(())
    }

    /// Values that were requested or taken from the class.
    fn given(&mut self, tool: &Tool, ratios: Ratios, setting: Setting) -> Result<(), ScalingError> {
        let source = &tool.class.source;
        let own = |chosen: Chosen| match chosen.given {
            true => (0.02, "design: given to init, 2 % assumed".to_owned()),
            false => (0.1, source.clone()),
        };
        self.line("\n# The tool");
        let psi = |pressure: f64| format!("{:.0}", pressure / PSI);
        let _ = writeln!(
            self.text,
            "supply.pressure = {{ value = \"{} psig\", range = \"{} .. {} psig\", \
             provenance = \"decided: within the rating\" }}",
            psi(setting.pressure),
            psi(RATED[0]),
            psi(RATED[1])
        );
        if setting.by_hand {
            self.line(
                "trigger.release_after = { value = \"45 ms\", range = \"30 .. 60 ms\", \
                 provenance = \"estimated: a finger; the recoil does not lift this tool off its guard\" }",
            );
            // With the stiff nose of the base, the landing would be the loudest event of the shot.
            let source = "decided: a soft tip; the blow of the landing is not part of a shot";
            self.line("# This tool lands on the workpiece before its exhaust has ended.");
            self.key("contacts.nose_stiffness", TIP_STIFFNESS, [0.2e6, 1.5e6], source)?;
            self.key("contacts.nose_damping_ratio", TIP_DAMPING, [0.1, 0.4], source)?;
        }
        if ratios.bore < 1.0 {
            self.line(
                "analysis.worktable_max_frequency = { value = \"6.3 kHz\", \
                 provenance = \"decided: a smaller tool drives the table at higher frequencies\" }",
            );
        }
        for (key, chosen) in [("piston.bore", tool.bore), ("piston.stroke", tool.stroke)] {
            let (width, source) = own(chosen);
            let range = [1.0 - width, 1.0 + width].map(|x| x * chosen.value);
            self.key(key, chosen.value, range, &source)?;
        }
        let moving =
            (self.number("piston.mass")? + self.number("head_valve.mass")?) * ratios.bore.powi(2) * ratios.stroke;
        let mass = tool.mass.value - moving;
        if mass <= 0.0 {
            return Err(broken(
                "the tool is lighter than its moving parts; give a larger --mass",
            ));
        }
        let (width, source) = own(tool.mass);
        let range = [1.0 - width, 1.0 + width].map(|x| x * mass);
        self.key("tool.mass", mass, range, &format!("{source}; less the moving parts"))
    }

    fn nail(&mut self, tool: &Tool) -> Result<(), ScalingError> {
        self.line("\n# The fastener");
        let length = tool.fastener.length();
        match &tool.fastener {
            Fastener::Named(named) => {
                let line = format!(
                    "nail.kind = {{ value = \"{}\", provenance = \"design: fastener of the tool\" }}",
                    named.name
                );
                self.line(&line);
            }
            Fastener::Size { length, diameter } => self.size(tool, *length, *diameter)?,
        }
        let inside = "scaled: the tip waits 4 mm inside the nose, as that of the N80CB";
        self.key(
            "nail.feed_height",
            length + TIP_INSIDE,
            [length + 0.1 * TIP_INSIDE, length + 2.4 * TIP_INSIDE],
            inside,
        )
    }

    /// A fastener given by its dimensions; for a stapler, a staple with a medium crown.
    fn size(&mut self, tool: &Tool, length: f64, diameter: f64) -> Result<(), ScalingError> {
        let class: Fastener = tool.class.nail.parse().map_err(broken)?;
        let staple = class.number("nail.legs") == Some(2.0);
        let given = "design: given to init";
        self.line("nail.kind = { value = \"own\", provenance = \"design: given to init\" }");
        self.key("nail.length", length, [0.99 * length, 1.01 * length], given)?;
        self.key("nail.diameter", diameter, [0.97 * diameter, 1.03 * diameter], given)?;
        let legs = if staple { 2 } else { 1 };
        self.line(&format!(
            "nail.legs = {{ value = {legs}, provenance = \"decided: of the class\" }}"
        ));
        let (head, thickness, source) = if staple {
            let circle = (4.0 / std::f64::consts::PI * CROWN * diameter).sqrt();
            (circle, diameter, "estimated: circle of the area of a crown of 11.11 mm")
        } else if diameter < THINNEST {
            (1.5 * diameter, 0.6 * diameter, "estimated: 1.5 and 0.6 wire diameters")
        } else {
            (
                2.0 * diameter,
                0.42 * diameter,
                "estimated: in the proportion of a 12d nail",
            )
        };
        self.key("nail.head_diameter", head, [0.85 * head, 1.2 * head], source)?;
        self.key(
            "nail.head_thickness",
            thickness,
            [0.75 * thickness, 1.35 * thickness],
            source,
        )?;
        let specimen = Specimen {
            length,
            diameter,
            hardness_modulus: self.number("wood.hardness_modulus")?,
            density: self.number("wood.density")?,
        };
        if specimen.nearest_tested().is_some() {
            let share = self.number("wood.friction_share")?;
            let limits = "estimated: a smooth 6d nail; 0 and 1 scale with area and perimeter alone";
            self.key("wood.friction_share", share, [0.0, 1.0], limits)?;
        }
        let stiffness = head / HEAD;
        let punch = "scaled: diameter of the head over that of a 12d nail, as a flat punch (Sneddon 1965)";
        self.key(
            "wood.head_stiffness_scale",
            stiffness,
            [0.5 * stiffness, 2.0 * stiffness],
            punch,
        )
    }

    fn rule(&mut self, rule: &Rule, ratios: Ratios, setting: Setting) -> Result<(), ScalingError> {
        let factor = rule.factor(ratios);
        self.line(&format!("\n# {}: {}, here {factor:.3}", rule.what, rule.law()));
        for key in &rule.keys {
            let adjusted = key == "piston.rod_protrusion" && setting.depth != 1.0;
            // If nothing changes, the base's value with its source.
            if factor == 1.0 && !adjusted {
                continue;
            }
            let entry = self.entry(key)?;
            let (value, range) = (factor * self.number(key)?, entry.range);
            let [low, high] = range.unwrap_or([f64::INFINITY, 0.0]).map(|end| factor * end);
            let low = if range.is_some() { low } else { value };
            let high = if range.is_some() { high } else { value };
            let range = [low.min(value / rule.spread), high.max(value * rule.spread)];
            let (value, range, note) = if adjusted {
                let value = setting.depth * value;
                let note = format!(
                    "; depth adjustment turned back to {:.0} %, so that the head ends at the surface",
                    100.0 * setting.depth
                );
                (value, [range[0].min(value), range[1]], note)
            } else {
                (value, range, String::new())
            };
            self.key(key, value, range, &format!("scaled: N80CB by {}{note}", rule.law()))?;
        }
        Ok(())
    }

    /// The sensor on the handle stays on it.
    fn handle_sensor(&mut self, rules: &Rules, ratios: Ratios) -> Result<(), ScalingError> {
        let mut top = 0.0;
        for key in ["body.handle_level", "body.handle_radius"] {
            let rule = rules.rules.iter().find(|rule| rule.keys.iter().any(|own| own == key));
            top += self.number(key)? * rule.map_or(1.0, |rule| rule.factor(ratios));
        }
        self.line("\n# On top of the handle");
        let z = quantity_in_words(top, nailnoise_quantities::dimension::LENGTH);
        self.line(&format!(
            "sensors.handle.z = {{ value = \"{z}\", provenance = \"scaled: with the handle\" }}"
        ));
        Ok(())
    }
}
