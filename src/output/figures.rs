//! `figures/*.svg`: charts for print.

use super::{File, Output, RunView};
use crate::error::Error;
use crate::figures;

/// Charts of levels and power, on request.
pub(super) const FIGURES: Output = Output::files("figures/*.svg", charts).only_if(|of| of.exports.figures);

fn charts(of: &RunView<'_>) -> Result<Vec<File>, Error> {
    let level = of.run.result.total.lwa_db;
    let level = level.map_or_else(|| "silent".to_owned(), |level| format!("L_{{WA,1s}} {level:.1} dB"));
    let subject = format!("{}: one shot, {level}", of.design.name());
    let charts = figures::in_units(figures::sound(&subject, of.run), of.exports.units);
    let file = |chart: &figures::Chart| File::new(format!("figures/{}.svg", chart.name), chart.svg());
    Ok(charts.iter().map(file).collect())
}
