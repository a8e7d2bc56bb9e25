//! Comma-separated files: `levels.csv`, `intervals.csv`, `power.csv`, `events.csv`, `log.csv`, `histories.csv`,
//! `modes.csv`. Units stand in the header.

use std::fmt::Write;

use nailnoise_dynamics::{CycleRecord, Events, LogEntry};
use rayon::prelude::*;

use super::columns::columns;
use super::digits::{exponential, fixed};
use crate::result::{RadiationReport, RunResult};
use crate::run::Run;
use crate::stages::spectra::Driven;

/// Rows of a long table written beside each other.
const BLOCK: usize = 128;

/// Most bytes of a number with nine digits, its sign and its comma.
const WIDTH: usize = 18;

/// What each event is, in the order t0..t18.
pub const EVENT_NAMES: [&str; 19] = [
    "trigger pulled",
    "head valve lifts",
    "volume above the head valve vented",
    "intake opens",
    "piston starts",
    "rod meets the nail",
    "nail meets the wood",
    "piston at 50.51 mm down",
    "check-ring holes uncovered",
    "piston stops on the workpiece",
    "piston on the bumper",
    "piston at rest on the bumper",
    "trigger valve released",
    "exhaust opens",
    "return stroke begins",
    "piston at 50.51 mm up",
    "piston on the stopper",
    "exhaust ended",
    "piston at rest on the stopper",
];

/// What stands beside the power of a source; none where it is the equivalent radiated power.
fn report_of<'a>(result: &'a RunResult, source: &str) -> Option<&'a RadiationReport> {
    result
        .ranking
        .iter()
        .find(|own| own.source == source)?
        .radiation
        .as_ref()
}

/// `radiation.csv` of a source: one-third-octave bands by the far field, by the surface, with radiation efficiency 1, and by
/// the limit of high frequencies where boundary elements are known too; none where it has no second evaluation.
pub(super) fn radiation(result: &RunResult, source: &str) -> Option<String> {
    let report = report_of(result, source)?;
    let mut text = String::from(
        "band [Hz],far field L_W [dB],surface L_W [dB],radiation efficiency 1 L_W [dB],limit of high frequencies L_W [dB]\n",
    );
    for band in &report.bands {
        let levels = [band.lw_db, band.surface_lw_db, band.erp_lw_db, band.limit_lw_db].map(|level| optional(level, 3));
        let _ = writeln!(text, "{},{}", band.hz, levels.join(","));
    }
    Some(text)
}

/// `modes.csv`: every mode of every body that takes part, rigid motions among them, with the damping of the material.
pub(super) fn modes(moving: &[Driven]) -> String {
    let mut text = String::from("body,mode,frequency [Hz],loss factor [-],eigen residual [-]\n");
    for Driven { body, loss_factor, .. } in moving {
        let basis = &body.basis;
        for (number, (hz, residual)) in basis.hz.iter().zip(&basis.residuals).enumerate() {
            let (hz, eta) = if basis.rigid[number] {
                (0.0, 0.0)
            } else {
                (*hz, *loss_factor)
            };
            let _ = writeln!(text, "{},{},{hz:.3},{eta},{residual:.1e}", body.name, number + 1);
        }
    }
    text
}

/// `radiation-modes.csv` of a source: what each mode adds to its A-weighted energy, and how radiation damps it; none of a
/// rigid body.
pub(super) fn radiation_modes(result: &RunResult, source: &str) -> Option<String> {
    let report = report_of(result, source).filter(|report| !report.modes.is_empty())?;
    let mut text =
        String::from("body,mode,frequency [Hz],radiation damping ratio [-],share of A-weighted energy [-]\n");
    for m in &report.modes {
        let number = m
            .mode
            .map_or_else(|| "static corrections".to_owned(), |mode| mode.to_string());
        let damping = m
            .radiation_damping
            .map_or_else(String::new, |ratio| format!("{ratio:.3e}"));
        let _ = writeln!(
            text,
            "{},{number},{},{damping},{:.4e}",
            m.body,
            optional(m.hz, 2),
            m.share
        );
    }
    Some(text)
}

/// `levels.csv`: one-third-octave bands by sources, unweighted; then the A-weighted total of each. The header tells how
/// each source was computed. Silence is empty.
pub(super) fn levels(result: &RunResult) -> String {
    let mut text = String::from("band [Hz]");
    for source in &result.ranking {
        let _ = write!(
            text,
            ",{} L_W [dB] ({})",
            source.source,
            source.method.replace(',', " with")
        );
    }
    text.push('\n');
    let bands = result.ranking.first().map_or(0, |source| source.bands.len());
    for band in 0..bands {
        let _ = write!(text, "{}", result.ranking[0].bands[band].hz);
        for source in &result.ranking {
            text.push(',');
            text.push_str(&optional(source.bands[band].lw_db, 3));
        }
        text.push('\n');
    }
    text.push_str("A-weighted total");
    for source in &result.ranking {
        text.push(',');
        text.push_str(&optional(source.lwa_db, 3));
    }
    text.push('\n');
    text
}

/// `intervals.csv`: interval by source, the energy-additive level and that of the signal cut at the events. Silence is
/// empty.
pub(super) fn intervals(result: &RunResult) -> String {
    let mut text = String::from("from,to,from [s],to [s]");
    for source in &result.ranking {
        let _ = write!(text, ",{0} L_WA [dB],{0} L_WA cut [dB]", source.source);
    }
    text.push('\n');
    let count = result.ranking.first().map_or(0, |source| source.intervals.len());
    for index in 0..count {
        let interval = &result.ranking[0].intervals[index];
        let _ = write!(
            text,
            "{},{},{:.7},{:.7}",
            interval.from, interval.to, interval.from_s, interval.to_s
        );
        for source in &result.ranking {
            let own = &source.intervals[index];
            let _ = write!(text, ",{},{}", optional(own.lwa_db, 3), optional(own.lwa_cut_db, 3));
        }
        text.push('\n');
    }
    text
}

/// `power.csv`: A-weighted sound power of every source over time, mean of each cell around the time given, and the
/// screech frequency of the exhaust's jets there; empty while they are subsonic.
pub(super) fn power(run: &Run) -> Vec<u8> {
    let mut heading = String::from("time [s]");
    for power in &run.powers {
        let _ = write!(heading, ",{} W_A [W]", power.source);
    }
    heading.push_str(",screech of the exhaust [Hz]\n");
    let mut text = heading.into_bytes();
    let Some(first) = run.powers.first().map(|power| &power.history) else {
        return text;
    };
    for cell in 0..first.power.len() {
        let time = first.start + cell as f64 * first.sample_interval;
        fixed(&mut text, time, 7);
        for power in &run.powers {
            text.push(b',');
            exponential(&mut text, power.history.power[cell], 9);
        }
        let sample = (time >= 0.0).then(|| (time / run.record.sample_interval).round() as usize);
        let screech = sample.and_then(|sample| run.screech.get(sample).copied().flatten());
        text.push(b',');
        text.extend_from_slice(optional(screech, 1).as_bytes());
        text.push(b'\n');
    }
    text
}

/// `events.csv`: symbol, what it is, time. An event that does not occur has no time.
pub(super) fn events(events: &Events) -> String {
    let mut text = String::from("event,description,time_s\n");
    for (index, (time, name)) in events.to_array().iter().zip(EVENT_NAMES).enumerate() {
        let _ = writeln!(text, "t{index},{name},{}", optional(*time, 9));
    }
    text
}

/// `log.csv`: everything that happened, with the state at that instant.
pub(super) fn log(log: &[LogEntry]) -> String {
    let mut text = String::from(
        "time_s,entry,description,piston_travel_m,piston_velocity_m_s,valve_lift_m,valve_velocity_m_s,tool_rise_m,\
         tool_velocity_m_s,tip_depth_m,p_above_piston_pa,p_below_piston_pa,p_return_pa,p_above_valve_pa,p_supply_pa\n",
    );
    for entry in log {
        let word = |value: serde_json::Result<serde_json::Value>| {
            let value = value.unwrap_or_default();
            value.as_str().unwrap_or_default().to_owned()
        };
        let crossing = word(serde_json::to_value(entry.crossing));
        let direction = word(serde_json::to_value(entry.direction));
        let description = entry.crossing.describe(entry.direction);
        let _ = write!(text, "{:.9},{crossing} {direction},{description}", entry.time);
        let s = &entry.state;
        let motion = [
            s.piston_travel,
            s.piston_velocity,
            s.valve_lift,
            s.valve_velocity,
            s.tool_rise,
            s.tool_velocity,
            s.tip_depth,
        ];
        for value in motion.into_iter().chain(s.pressures) {
            let _ = write!(text, ",{value:.6e}");
        }
        text.push('\n');
    }
    text
}

/// `histories.csv`: time and every history of the cycle.
pub(super) fn histories(record: &CycleRecord) -> Vec<u8> {
    let columns = columns(record);
    let mut heading = String::from("time [s]");
    for column in &columns {
        let _ = write!(heading, ",{} [{}]", column.name, column.unit);
    }
    heading.push('\n');
    let rows = |first: usize| {
        let mut text = Vec::with_capacity(BLOCK * WIDTH * (columns.len() + 1));
        for index in first..record.len().min(first + BLOCK) {
            fixed(&mut text, record.time(index), 7);
            for column in &columns {
                text.push(b',');
                exponential(&mut text, column.values[index], 9);
            }
            text.push(b'\n');
        }
        text
    };
    let starts: Vec<usize> = (0..record.len()).step_by(BLOCK).collect();
    let blocks: Vec<Vec<u8>> = starts.into_par_iter().map(rows).collect();
    [heading.into_bytes(), blocks.concat()].concat()
}

pub(super) fn optional(value: Option<f64>, decimals: usize) -> String {
    value.map_or_else(String::new, |value| format!("{value:.decimals$}"))
}
