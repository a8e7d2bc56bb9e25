//! Texts of `nailnoise calibrate --structures`: elastic constants of plates from tap tests.

use nailnoise_quantities::rounded;

use super::table::{table, texts};
use crate::calibration::{NOT_CONVERGED, PeakRow, PlateResult, StructuresResult, Verdict};
use crate::error::Error;
use crate::output;
use crate::units::Units;

/// The file written last, whose presence shows that the folder is complete.
pub(super) const RESULT: &str = "structures.json";

/// Inputs in the table of plates.
const SHOWN: [&str; 3] = ["e_l", "e_r", "g_lr"];

/// Metric units of the columns and their sizes in SI units: of densities and of moduli.
const DENSITY: (&str, f64) = ("kg/m3", 1.0);
const MODULUS: (&str, f64) = ("GPa", 1e9);

/// `modes.csv`: one row per plate and mode.
pub(super) fn modes(result: &StructuresResult) -> Result<Vec<u8>, Error> {
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

/// A metric unit in these units, and its size in SI units.
fn unit_in((unit, size): (&'static str, f64), units: Units) -> (&'static str, f64) {
    let conversion = units.conversion(unit, 0.0);
    conversion.map_or((unit, size), |own| (own.unit, size / own.factor))
}

pub(super) fn text(result: &StructuresResult, units: Units) -> String {
    let [(density, of_density), (modulus, of_modulus)] = [DENSITY, MODULUS].map(|own| unit_in(own, units));
    let headings = SHOWN.map(|name| format!("{name} [{modulus}]"));
    let names = ["plate".to_owned(), format!("density [{density}]")].into_iter();
    let headings: Vec<String> = names.chain(headings).chain(["peaks used".to_owned()]).collect();
    let row = |own: &PlateResult| {
        let of = |name: &&str| {
            let input = own.inputs.iter().find(|input| input.name == *name);
            input.map_or_else(String::new, |input| shown(input.now, of_modulus))
        };
        let peaks = own.peaks.iter().filter(|peak| peak.nodal_lines.is_some());
        let used = peaks.clone().filter(|peak| peak.counts).count();
        let mut row = vec![own.name.clone(), shown(own.density, of_density)];
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
    let undetermined = result.undetermined();
    if !undetermined.is_empty() {
        text.push_str(&format!("  the peaks hardly determine {}\n", undetermined.join(", ")));
    }
    for own in &result.plates {
        text.push_str(&format!(
            "\nplate {}: modes up to {} Hz\n",
            own.name, result.modes_up_to
        ));
        if !own.faults.is_empty() {
            text.push_str(&format!("NOT CONVERGED: {NOT_CONVERGED}\n"));
        }
        text.push_str(&of_plate(own));
    }
    text
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
