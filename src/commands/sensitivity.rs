//! `nailnoise cycle --sensitivity`: effect of the ranges of a design or an assembly on its shot, one at a time.

use std::fmt::Write as _;
use std::path::Path;

use serde::Serialize;

use super::Status;
use super::table::table;
use super::{Common, given_or_named, print, print_json, progress};
use crate::atomic_write;
use crate::design::Design;
use crate::design::inputs::assembly::AssembledTool;
use crate::error::Error;
use crate::output;
use crate::result::DesignId;
use crate::sensitivity::{
    self, AssemblyOutput, Derivative, End, OutputSensitivity, ParameterOutcome, Sensitivity, USUAL,
};
use crate::tables::dash;

/// Number of parameters shown for each result; the file contains all.
const SHOWN: usize = 10;

/// Layout of `cycle --sensitivity --json`.
#[derive(Serialize)]
struct Layout<'a> {
    schema: &'static str,
    #[serde(flatten)]
    subject: Named<'a>,
    #[serde(flatten)]
    sensitivity: &'a Sensitivity,
}

/// The differentiated model: a design, or a tool whose file has no base design.
#[derive(Serialize)]
#[serde(untagged)]
enum Named<'a> {
    Design { design: DesignId },
    Tool { tool: &'a str, assembly: &'a str },
}

pub(super) fn execute(
    common: &Common,
    design: &Design,
    outputs: &[String],
    parameters: &[String],
) -> Result<Status, Error> {
    let keys: Vec<&str> = parameters.iter().map(|key| key.trim()).collect();
    let keys = (!keys.is_empty()).then_some(keys.as_slice());
    let folder = common.out(design)?;
    let progress = progress();
    progress.stage("sensitivity of the nailing cycle");
    let sensitivity = match sensitivity::sensitivity_of_assembly(design, outputs, keys, &progress)? {
        Some(found) => found,
        None => {
            let outputs = if outputs.is_empty() {
                sensitivity::choose(&USUAL)?
            } else {
                sensitivity::choose(outputs)?
            };
            sensitivity::sensitivity(design, &outputs, keys, &progress)?
        }
    };
    progress.end();
    let named = Named::Design {
        design: DesignId::from(design),
    };
    finish(common, &folder, (design.name(), named), &sensitivity)
}

/// The same for an assembly without a design.
pub(super) fn execute_tool(
    common: &Common,
    tool: &AssembledTool,
    outputs: &[String],
    parameters: &[String],
) -> Result<Status, Error> {
    let keys: Vec<&str> = parameters.iter().map(|key| key.trim()).collect();
    let keys = (!keys.is_empty()).then_some(keys.as_slice());
    let outputs = AssemblyOutput::choose(&tool.resolved.assembly, outputs)?;
    let folder = given_or_named(common.options.out.as_deref(), &tool.name, &common.design)?;
    let progress = progress();
    progress.stage("sensitivity of the cycle");
    let sensitivity = sensitivity::sensitivity_of_tool(tool, &outputs, keys, &progress)?;
    progress.end();
    let named = Named::Tool {
        tool: &tool.name,
        assembly: &tool.resolved.assembly.name,
    };
    finish(common, &folder, (&tool.name, named), &sensitivity)
}

/// Writes the table and prints the result.
fn finish(
    common: &Common,
    folder: &Path,
    (name, subject): (&str, Named<'_>),
    sensitivity: &Sensitivity,
) -> Result<Status, Error> {
    let path = folder.join("sensitivity.csv");
    atomic_write::write(&path, &csv(sensitivity)?)?;
    if common.options.json {
        print_json(&Layout {
            schema: "nailnoise-sensitivity/1",
            subject,
            sensitivity,
        })?;
    } else {
        common.shown.print(&text(name, sensitivity))?;
        print(&format!("\n  all parameters in {}\n", path.display()))?;
    }
    Ok(Status::SUCCESS)
}

fn text(name: &str, sensitivity: &Sensitivity) -> String {
    let outcome = sensitivity.outcome.replace('_', " ");
    let count = sensitivity.parameters.len();
    let mut text = format!("{name}: {outcome}; sensitivity to {count} parameters, all in SI units\n");
    for output in &sensitivity.outputs {
        let unit = output.unit;
        let value = output.value.map_or_else(
            || "does not occur".to_owned(),
            |value| format!("{} {unit}", short(value)),
        );
        // Writing to a string cannot fail, here and below.
        let _ = writeln!(text, "\n{} = {value}", output.name);
        let headings = [
            "parameter",
            "value",
            "derivative",
            "error",
            "x half range",
            "at low end",
            "at high end",
            "",
        ];
        let rows: Vec<Vec<String>> = output
            .ranking
            .iter()
            .take(SHOWN)
            .filter_map(|derivative| Some(row(derivative, parameter(sensitivity, &derivative.key)?)))
            .collect();
        text.push_str(&table(&headings, &rows));
    }
    let changing: Vec<Vec<String>> = sensitivity
        .parameters
        .iter()
        .filter(|parameter| parameter.outcome_changes)
        .map(|parameter| {
            let [low, high] = parameter.ends.each_ref().map(end);
            vec![parameter.parameter.key.clone(), low, high]
        })
        .collect();
    if !changing.is_empty() {
        text.push_str("\noutcome changes within the range of\n");
        text.push_str(&table(&["parameter", "at low end", "at high end"], &changing));
    }
    text
}

fn parameter<'a>(sensitivity: &'a Sensitivity, key: &str) -> Option<&'a ParameterOutcome> {
    sensitivity
        .parameters
        .iter()
        .find(|parameter| parameter.parameter.key == key)
}

fn row(derivative: &Derivative, parameter: &ParameterOutcome) -> Vec<String> {
    let end = |value: Option<f64>| dash(value, short);
    let mut notes = Vec::new();
    if !derivative.is_certain() {
        notes.push("uncertain");
    }
    if derivative.is_linear() == Some(false) {
        notes.push("not linear");
    }
    if parameter.outcome_changes {
        notes.push("outcome changes");
    }
    vec![
        derivative.key.clone(),
        format!("{} {}", short(parameter.parameter.number()), parameter.parameter.unit)
            .trim_end()
            .to_owned(),
        format!("{:+.4e}", derivative.derivative),
        format!("{:.0e}", derivative.error),
        format!("{:+.3e}", derivative.effect),
        end(derivative.at_ends[0]),
        end(derivative.at_ends[1]),
        notes.join(", "),
    ]
}

/// Five digits, with a power of ten for very large or small numbers.
fn short(value: f64) -> String {
    if value == 0.0 || (1e-2..1e5).contains(&value.abs()) {
        let digits = if value == 0.0 {
            0
        } else {
            4 - value.abs().log10().floor() as i32
        };
        format!("{value:.*}", digits.clamp(0, 6) as usize)
    } else {
        format!("{value:.4e}")
    }
}

fn end(end: &End) -> String {
    match end {
        End::Outcome(outcome) => outcome.replace('_', " "),
        End::Refused(_) => "no design".to_owned(),
        End::Failed(_) => "cannot be computed".to_owned(),
    }
}

/// `sensitivity.csv`: one row for each result and parameter.
fn csv(sensitivity: &Sensitivity) -> Result<Vec<u8>, Error> {
    let header = [
        "output",
        "output_unit",
        "output_value",
        "parameter",
        "parameter_unit",
        "parameter_value",
        "range_low",
        "range_high",
        "derivative",
        "error",
        "effect",
        "at_low",
        "at_high",
        "outcome_low",
        "outcome_high",
    ];
    let row = |output: &OutputSensitivity, derivative: &Derivative| {
        let parameter = parameter(sensitivity, &derivative.key)?;
        let number = |value: f64| format!("{value:e}");
        let optional = |value: Option<f64>| value.map_or_else(String::new, number);
        let [low, high] = derivative.at_ends.map(optional);
        let [from, to] = parameter.parameter.range.map(number);
        let [left, right] = parameter.ends.each_ref().map(end);
        Some([
            output.name.clone(),
            output.unit.to_string(),
            optional(output.value),
            derivative.key.clone(),
            parameter.parameter.unit.clone(),
            number(parameter.parameter.number()),
            from,
            to,
            number(derivative.derivative),
            number(derivative.error),
            number(derivative.effect),
            low,
            high,
            left,
            right,
        ])
    };
    let outputs = sensitivity.outputs.iter();
    let rows = outputs.flat_map(|output| {
        output
            .ranking
            .iter()
            .filter_map(move |derivative| row(output, derivative))
    });
    output::table(header, rows)
}
