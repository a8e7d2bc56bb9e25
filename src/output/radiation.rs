//! `radiation*.csv`: the power of a vibrating surface from several evaluations, and by mode.

use super::table::{level, optional, table};
use super::{File, Output, RunView};
use crate::error::Error;
use crate::model::sources;
use crate::result::{ModeShare, RadiationReport, RunResult};

/// Bands of each source whose power is evaluated twice, and modes of each source that vibrates.
pub(super) const TABLES: Output = Output::files("radiation*.csv", |of| {
    let mut files = Vec::new();
    for source in sources::ALL {
        let (name, table) = (source.name(), source.radiation_table());
        if report_of(of, name).is_some() {
            files.push(File::new(format!("{table}.csv"), bands(of, name)?));
        }
        if !modes_of(of, name).is_empty() {
            files.push(File::new(format!("{table}-modes.csv"), modes(of, name)?));
        }
    }
    Ok(files)
});

/// Radiation report of a source; `None` for the equivalent radiated power.
fn report_of<'a>(of: &RunView<'a>, source: &str) -> Option<&'a RadiationReport> {
    of.run
        .result
        .ranking
        .iter()
        .find(|own| own.source == source)?
        .radiation
        .as_ref()
}

/// One-third-octave bands from the far field, from the surface, with radiation efficiency 1, and from the
/// high-frequency limit if boundary elements are known too.
fn bands(of: &RunView<'_>, source: &str) -> Result<Vec<u8>, Error> {
    let header = [
        "band [Hz]",
        "far field L_W [dB]",
        "surface L_W [dB]",
        "radiation efficiency 1 L_W [dB]",
        "limit of high frequencies L_W [dB]",
    ];
    let bands = report_of(of, source).map_or(&[][..], |report| &report.bands);
    let rows = bands.iter().map(|band| {
        let levels = [band.lw_db, band.surface_lw_db, band.erp_lw_db, band.limit_lw_db];
        [band.hz.to_string()].into_iter().chain(levels.map(level))
    });
    table(header, rows)
}

/// Modes in that report; empty for a rigid body.
fn modes_of<'a>(of: &RunView<'a>, source: &str) -> &'a [ModeShare] {
    report_of(of, source).map_or(&[], |report| &report.modes)
}

/// Contribution of each mode to the A-weighted energy of the source, and its radiation damping.
fn modes(of: &RunView<'_>, source: &str) -> Result<Vec<u8>, Error> {
    let header = [
        "body",
        "mode",
        "frequency [Hz]",
        "radiation damping ratio [-]",
        "added mass [-]",
        "frequency shift by it [Hz]",
        "share of A-weighted energy [-]",
        "radiation efficiency alone [dB]",
    ];
    let rows = modes_of(of, source).iter().map(|m| {
        let number = m
            .mode
            .map_or_else(|| "static corrections".to_owned(), |mode| mode.to_string());
        let damping = m
            .radiation_damping
            .map_or_else(String::new, |ratio| format!("{ratio:.3e}"));
        [
            m.body.to_string(),
            number,
            optional(m.hz, 2),
            damping,
            m.added_mass.map_or_else(String::new, |mass| format!("{mass:.3e}")),
            optional(m.shift_hz, 3),
            format!("{:.4e}", m.share),
            optional(efficiency_db(&of.run.result, m), 2),
        ]
    });
    table(header, rows)
}

/// Radiation efficiency of a mode alone \[dB\]; `None` for static corrections, and if it is not known.
fn efficiency_db(result: &RunResult, share: &ModeShare) -> Option<f64> {
    let bodies = &result.radiation_efficiencies;
    let own = bodies.iter().find(|own| own.body == share.body)?;
    own.of_mode(share.mode?.checked_sub(1)?)
}
