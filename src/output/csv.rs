//! Tables of a run: `levels.csv`, `intervals.csv`, `power.csv`, `events.csv`, `log.csv`, `histories.csv`, `modes.csv`.
//! Units stand in the header.

use nailnoise_dynamics::{CycleRecord, Events, LogEntry};

use super::columns::columns;
use super::table::{numbers, optional, table};
use crate::error::Error;
use crate::result::{RadiationReport, RankedSource, RunResult};
use crate::run::Run;
use crate::stages::spectra::Driven;

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
pub(super) fn radiation(result: &RunResult, source: &str) -> Option<Result<Vec<u8>, Error>> {
    let report = report_of(result, source)?;
    let header = [
        "band [Hz]",
        "far field L_W [dB]",
        "surface L_W [dB]",
        "radiation efficiency 1 L_W [dB]",
        "limit of high frequencies L_W [dB]",
    ];
    let rows = report.bands.iter().map(|band| {
        let levels = [band.lw_db, band.surface_lw_db, band.erp_lw_db, band.limit_lw_db];
        [band.hz.to_string()].into_iter().chain(levels.map(level))
    });
    Some(table(header, rows))
}

/// `modes.csv`: every mode of every body that takes part, rigid motions among them, with the damping of the material.
pub(super) fn modes(moving: &[Driven]) -> Result<Vec<u8>, Error> {
    let header = [
        "body",
        "mode",
        "frequency [Hz]",
        "loss factor [-]",
        "eigen residual [-]",
    ];
    let rows = moving.iter().flat_map(|Driven { body, loss_factor, .. }| {
        let basis = &body.basis;
        basis
            .hz
            .iter()
            .zip(&basis.residuals)
            .enumerate()
            .map(|(number, (hz, residual))| {
                let (hz, eta) = if basis.rigid[number] {
                    (0.0, 0.0)
                } else {
                    (*hz, *loss_factor)
                };
                let number = (number + 1).to_string();
                [
                    body.name.to_owned(),
                    number,
                    format!("{hz:.3}"),
                    eta.to_string(),
                    format!("{residual:.1e}"),
                ]
            })
    });
    table(header, rows)
}

/// `radiation-modes.csv` of a source: what each mode adds to its A-weighted energy, and how radiation damps it; none of a
/// rigid body.
pub(super) fn radiation_modes(result: &RunResult, source: &str) -> Option<Result<Vec<u8>, Error>> {
    let report = report_of(result, source).filter(|report| !report.modes.is_empty())?;
    let header = [
        "body",
        "mode",
        "frequency [Hz]",
        "radiation damping ratio [-]",
        "share of A-weighted energy [-]",
    ];
    let rows = report.modes.iter().map(|m| {
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
            format!("{:.4e}", m.share),
        ]
    });
    Some(table(header, rows))
}

/// `levels.csv`: one-third-octave bands by sources, unweighted; then the A-weighted total of each. The header tells how
/// each source was computed. Silence is empty.
pub(super) fn levels(result: &RunResult) -> Result<Vec<u8>, Error> {
    let ranking = &result.ranking;
    let row = |first: String, levels: &dyn Fn(&RankedSource) -> Option<f64>| -> Vec<String> {
        [first]
            .into_iter()
            .chain(ranking.iter().map(|source| level(levels(source))))
            .collect()
    };
    let titles = ranking
        .iter()
        .map(|source| format!("{} L_W [dB] ({})", source.source, source.method.replace(',', " with")));
    let bands = ranking.first().map_or(&[][..], |source| &source.bands);
    let rows = bands
        .iter()
        .enumerate()
        .map(|(band, first)| row(first.hz.to_string(), &|source| source.bands[band].lw_db));
    let total = row("A-weighted total".to_owned(), &|source| source.lwa_db);
    table(["band [Hz]".to_owned()].into_iter().chain(titles), rows.chain([total]))
}

/// `intervals.csv`: interval by source, the energy-additive level and that of the signal cut at the events. Silence is
/// empty.
pub(super) fn intervals(result: &RunResult) -> Result<Vec<u8>, Error> {
    let ranking = &result.ranking;
    let titles = ranking
        .iter()
        .flat_map(|source| ["L_WA", "L_WA cut"].map(|quantity| format!("{} {quantity} [dB]", source.source)));
    let header = ["from", "to", "from [s]", "to [s]"].map(str::to_owned);
    let intervals = ranking.first().map_or(&[][..], |source| &source.intervals);
    let rows = intervals.iter().enumerate().map(|(index, interval)| {
        let times = [interval.from_s, interval.to_s].map(|time| format!("{time:.7}"));
        let levels = ranking.iter().flat_map(move |source| {
            let own = &source.intervals[index];
            [own.lwa_db, own.lwa_cut_db].map(level)
        });
        [interval.from.clone(), interval.to.clone()]
            .into_iter()
            .chain(times)
            .chain(levels)
    });
    table(header.into_iter().chain(titles), rows)
}

/// `power.csv`: A-weighted sound power of every source over time, mean of each cell around the time given, and the
/// screech frequency of the exhaust's jets there; empty while they are subsonic.
pub(super) fn power(run: &Run) -> Result<Vec<u8>, Error> {
    let titles = run.powers.iter().map(|power| format!("{} W_A [W]", power.source));
    let header = ["time [s]".to_owned()].into_iter().chain(titles);
    let cells = run.powers.first().map_or(0, |power| power.history.power.len());
    let rows = (0..cells).map(|cell| {
        let first = &run.powers[0].history;
        let time = first.start + cell as f64 * first.sample_interval;
        let powers = run
            .powers
            .iter()
            .map(move |power| format!("{:.9e}", power.history.power[cell]));
        let sample = (time >= 0.0).then(|| (time / run.record.sample_interval).round() as usize);
        let screech = sample.and_then(|sample| run.screech.get(sample).copied().flatten());
        [format!("{time:.7}")]
            .into_iter()
            .chain(powers)
            .chain([optional(screech, 1)])
    });
    table(header.chain(["screech of the exhaust [Hz]".to_owned()]), rows)
}

/// `events.csv`: symbol, what it is, time. An event that does not occur has no time.
pub(super) fn events(events: &Events) -> Result<Vec<u8>, Error> {
    let times = events.to_array();
    let rows = times.iter().zip(EVENT_NAMES).enumerate();
    let rows = rows.map(|(index, (time, name))| [format!("t{index}"), name.to_owned(), optional(*time, 9)]);
    table(["event", "description", "time_s"], rows)
}

/// `log.csv`: everything that happened, with the state at that instant.
pub(super) fn log(log: &[LogEntry]) -> Result<Vec<u8>, Error> {
    let header = [
        "time_s",
        "entry",
        "description",
        "piston_travel_m",
        "piston_velocity_m_s",
        "valve_lift_m",
        "valve_velocity_m_s",
        "tool_rise_m",
        "tool_velocity_m_s",
        "tip_depth_m",
        "p_above_piston_pa",
        "p_below_piston_pa",
        "p_return_pa",
        "p_above_valve_pa",
        "p_supply_pa",
    ];
    let rows = log.iter().map(|entry| {
        let word = |value: serde_json::Result<serde_json::Value>| {
            let value = value.unwrap_or_default();
            value.as_str().unwrap_or_default().to_owned()
        };
        let crossing = word(serde_json::to_value(entry.crossing));
        let direction = word(serde_json::to_value(entry.direction));
        let description = entry.crossing.describe(entry.direction).to_owned();
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
        let state = motion
            .into_iter()
            .chain(s.pressures)
            .map(|value| format!("{value:.6e}"));
        let entry = [
            format!("{:.9}", entry.time),
            format!("{crossing} {direction}"),
            description,
        ];
        entry.into_iter().chain(state)
    });
    table(header, rows)
}

/// `histories.csv`: time and every history of the cycle.
pub(super) fn histories(record: &CycleRecord) -> Result<Vec<u8>, Error> {
    let columns = columns(record);
    let titles = columns
        .iter()
        .map(|column| format!("{} [{}]", column.name, column.unit));
    let values: Vec<&[f64]> = columns.iter().map(|column| column.values).collect();
    numbers(
        ["time [s]".to_owned()].into_iter().chain(titles),
        (|index| record.time(index), 7),
        (&values, 9),
    )
}

/// A level to a thousandth of a decibel; empty for silence.
fn level(value: Option<f64>) -> String {
    optional(value, 3)
}
