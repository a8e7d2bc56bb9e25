//! Texts of `nailnoise calibrate --check`: virtual tools that are measured and calibrated.

use super::table::texts;
use crate::calibration::{CheckCost, CheckRequest, CheckResult, CheckRow};

/// File of the result, and folder of the finished runs.
pub(super) const RESULT: &str = "check.json";
pub(super) const RUNS: &str = "check";

/// Seconds of a minute and of an hour.
const MINUTE: f64 = 60.0;
const HOUR: f64 = 3600.0;

/// What a check costs.
pub(super) fn ahead(asked: &CheckRequest<'_>, cost: CheckCost) -> String {
    let time = match cost.seconds {
        ..90.0 => format!("{:.0} s", cost.seconds),
        90.0..5400.0 => format!("{:.0} min", cost.seconds / MINUTE),
        _ => format!("{:.1} h", cost.seconds / HOUR),
    };
    format!(
        "{} calibrations of {} draws need about {:.1} million nailing cycles, {time} on this machine; finished runs \
         are kept in {}",
        asked.runs,
        asked.request.draws,
        1e-6 * cost.cycles,
        asked.folder.display()
    )
}

/// Formats the result for the terminal.
pub(super) fn text(result: &CheckResult) -> String {
    let mut text = format!(
        "{}: {} virtual tools, measured as {} states and calibrated with {} draws each\n\n",
        result.design.name, result.runs, result.measured, result.draws
    );
    let number =
        |value: Option<f64>, decimals: usize| value.map_or_else(|| "-".to_owned(), |own| format!("{own:.decimals$}"));
    let row = |own: &CheckRow| {
        let [half, most] = own
            .within
            .map(|share| number(Some(share).filter(|own| own.is_finite()), 2));
        let known = own.places.iter().flatten().count();
        vec![
            own.name.clone(),
            known.to_string(),
            half,
            most,
            number(own.statistic, 2),
            number(own.p, 3),
        ]
    };
    let rows: Vec<Vec<String>> = result.quantities.iter().filter(|own| own.tested).map(row).collect();
    if !rows.is_empty() {
        let headings = ["quantity", "runs", "in 50 %", "in 90 %", "A^2", "p"];
        text.push_str(&texts(&headings, &rows));
    }
    text.push_str(&format!(
        "  {} runs count; {} not converged and {} in conflict are left out\n",
        result.counted, result.not_converged, result.in_conflict
    ));
    let [counted, apart] = result.within_90;
    for (share, which) in [(counted, "the runs that count"), (apart, "the others")] {
        if let Some(share) = share {
            text.push_str(&format!(
                "  90 % intervals contain {share:.3} of all truths in {which}\n"
            ));
        }
    }
    text.push_str(&match (result.is_uniform, result.least) {
        (Some(true), Some(least)) => {
            format!("  the truths lie in their posteriors as chance has it (p {least:.2} for all together)\n")
        }
        (Some(false), Some(least)) => format!(
            "  NOT UNIFORM: the truths do not lie in their posteriors as chance has it (p {least:.1e} for all \
             together)\n"
        ),
        _ => "  fewer than 8 runs count, too few for a test\n".to_owned(),
    });
    for note in &result.notes {
        text.push_str(&format!("  - {note}\n"));
    }
    text
}
