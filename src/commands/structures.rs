//! `nailnoise calibrate --structures`: elastic constants of plates from tap tests.

use std::path::Path;

use nailnoise_quantities::rounded;

use super::table::{table, texts};
use super::{Status, message, print, print_json, progress};
use crate::atomic_write::AtomicWrite;
use crate::calibration::{PeakRow, PlateResult, StructuresRequest, StructuresResult, Verdict, calibrate_structures};
use crate::error::Error;
use crate::output;

/// The file written last, whose presence shows that the folder is complete.
const LAST: &str = "structures.json";

/// Inputs in the table of plates: name, unit in the table, its size in SI units.
const SHOWN: [(&str, &str, f64); 3] = [("e_l", "GPa", 1e9), ("e_r", "GPa", 1e9), ("g_lr", "GPa", 1e9)];

/// Ratio of widths above which peaks tell little of an input.
const HARDLY: f64 = 0.9;

/// Calibrates the plates of a file and writes the files of the result.
pub(super) fn execute(
    path: &Path,
    folder: &Path,
    request: &StructuresRequest,
    prints_json: bool,
) -> Result<Status, Error> {
    let progress = progress();
    let result = calibrate_structures(path, request, &progress)?;
    progress.stage("writing files");
    let staging = AtomicWrite::within(folder)?;
    staging.write("modes.csv".as_ref(), &modes(&result)?)?;
    let json = serde_json::to_string_pretty(&result).map_err(Error::Json)? + "\n";
    staging.write(LAST.as_ref(), json.as_bytes())?;
    staging.place(&[], LAST.as_ref())?;
    progress.end();
    for own in &result.plates {
        let faults = own.faults.iter();
        faults.for_each(|fault| message(&format!("plate {} not converged: {fault}", own.name)));
    }
    if prints_json {
        print_json(&result)?;
    } else {
        print(&text(&result))?;
        print(&format!("\n  files in {}\n", folder.display()))?;
    }
    Ok(if !result.converged() {
        Status::from(3)
    } else if result.has_conflict() {
        Status::from(1)
    } else {
        Status::SUCCESS
    })
}

/// `modes.csv`: one row per plate and mode.
fn modes(result: &StructuresResult) -> Result<Vec<u8>, Error> {
    let header = [
        "plate",
        "nodal lines across the grain",
        "nodal lines along the grain",
        "P5 [Hz]",
        "P50 [Hz]",
        "P95 [Hz]",
        "has a peak",
    ];
    let rows = result.plates.iter().flat_map(|plate| {
        plate.modes.iter().map(|own| {
            let lines = own.nodal_lines.map(|lines| lines.to_string());
            let hz = own.hz.map(|hz| format!("{hz:.2}"));
            let numbers = lines.into_iter().chain(hz);
            std::iter::once(plate.name.clone())
                .chain(numbers)
                .chain([own.has_peak.to_string()])
                .collect::<Vec<_>>()
        })
    });
    output::table(header.into_iter().map(str::to_owned), rows)
}

fn shown([low, middle, high]: [f64; 3], size: f64) -> String {
    let number = |value: f64| rounded(value / size, 3, 1e5);
    format!("{} ({} .. {})", number(middle), number(low), number(high))
}

fn text(result: &StructuresResult) -> String {
    let headings = SHOWN.map(|(name, unit, _)| format!("{name} [{unit}]"));
    let names = ["plate", "density [kg/m3]"].into_iter().map(str::to_owned);
    let headings: Vec<String> = names.chain(headings).chain(["peaks used".to_owned()]).collect();
    let row = |own: &PlateResult| {
        let of = |(name, _, size): &(&str, &str, f64)| {
            let input = own.inputs.iter().find(|input| input.name == *name);
            input.map_or_else(String::new, |input| shown(input.now, *size))
        };
        let peaks = own.peaks.iter().filter(|peak| peak.nodal_lines.is_some());
        let used = peaks.clone().filter(|peak| peak.counts).count();
        let mut row = vec![own.name.clone(), shown(own.density, 1.0)];
        row.extend(SHOWN.iter().map(of));
        row.push(format!("{used} of {}", peaks.count()));
        row
    };
    let rows: Vec<Vec<String>> = result.plates.iter().map(row).collect();
    let headings: Vec<&str> = headings.iter().map(String::as_str).collect();
    let mut text = format!(
        "{}: {} draws a plate; P50 (90 %)\n\n{}",
        result.file,
        result.draws,
        table(&headings, &rows)
    );
    text.push_str(&hardly_told(result));
    for own in &result.plates {
        text.push_str(&format!(
            "\nplate {}: modes up to {} Hz\n",
            own.name, result.modes_up_to
        ));
        if !own.faults.is_empty() {
            text.push_str("NOT CONVERGED: do not rely on these intervals; double --draws, then --moves 48\n");
        }
        text.push_str(&of_plate(own));
    }
    text
}

/// Inputs of which the peaks of no plate tell much.
fn hardly_told(result: &StructuresResult) -> String {
    let Some(first) = result.plates.first() else {
        return String::new();
    };
    let is_hardly_told = |k: usize| result.plates.iter().all(|own| own.inputs[k].ratio > HARDLY);
    let names = (0..first.inputs.len()).filter(|&k| is_hardly_told(k));
    let names: Vec<&str> = names.map(|k| first.inputs[k].name).collect();
    if names.is_empty() {
        return String::new();
    }
    format!("  the peaks tell hardly anything of {}\n", names.join(", "))
}

/// Modes of a plate with their peaks; then readings without a listed mode, and conflicts.
fn of_plate(own: &PlateResult) -> String {
    let of_peak = |peak: &PeakRow| {
        vec![
            peak.name.clone(),
            format!("{:+.1}", peak.left_over),
            peak.verdict.as_str().to_owned(),
        ]
    };
    let rows = own.modes.iter().flat_map(|mode| {
        let [m, n] = mode.nodal_lines;
        let mode_cells = vec![format!("({m}, {n})"), shown(mode.hz, 1.0)];
        let peaks = own
            .peaks
            .iter()
            .filter(|peak| peak.nodal_lines == Some(mode.nodal_lines));
        let mut rows: Vec<Vec<String>> = peaks.map(|peak| [mode_cells.clone(), of_peak(peak)].concat()).collect();
        if rows.is_empty() {
            rows.push([mode_cells, vec![String::new(); 3]].concat());
        }
        rows
    });
    let rows: Vec<Vec<String>> = rows.collect();
    let mut text = texts(&["mode", "Hz, P50 (90 %)", "peak", "left over, sd", "verdict"], &rows);
    for peak in own.peaks.iter().filter(|peak| peak.verdict == Verdict::Conflict) {
        let others = match &peak.partner {
            Some(partner) => partner.clone(),
            None => "the other readings".to_owned(),
        };
        let treated = if peak.counts { "" } else { "; left out of all intervals" };
        text.push_str(&format!(
            "  CONFLICT: {} contradicts {others} (probability {:.1e}){treated}\n",
            peak.name, peak.probability
        ));
    }
    text
}
