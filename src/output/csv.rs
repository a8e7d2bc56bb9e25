//! Tables of a run: `ranking.csv`, `levels.csv`, `intervals.csv`, `power.csv`, `events.csv`, `log.csv`,
//! `histories.csv`, `modes.csv`. A header has the form `name [unit]`; names of columns are an interface, which
//! docs/output.md lists.

use nailnoise_acoustics::levels::energy_level;
use nailnoise_dynamics::{CycleRecord, Events, LogEntry};

use super::columns::columns;
use super::table::{coarse, numbers, optional, table};
use crate::error::Error;
use crate::result::{BandLevel, IntervalLevel, RadiationReport, RankedSource, RunResult};
use crate::run::Run;
use crate::stages::spectra::Driven;

/// Description of each event, in the order t0..t18.
pub const EVENT_NAMES: [&str; 19] = [
    "trigger pulled",
    "head valve lifts",
    "volume above valve vented",
    "intake opens",
    "piston starts",
    "rod meets the nail",
    "nail meets the wood",
    "piston at 50.51 mm down",
    "check-ring holes uncovered",
    "piston stops relative to the workpiece",
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

/// Sources with dedicated places in tables, and the name of their sum.
const SOURCES: [&str; 3] = ["workpiece", "exhaust", "body"];
const TOTAL: &str = "total";

/// An event, given as "t12", with its name.
pub fn event_name(number: &str) -> String {
    let index = number.strip_prefix('t').and_then(|index| index.parse::<usize>().ok());
    let name = index.and_then(|index| EVENT_NAMES.get(index));
    name.map_or_else(|| number.to_owned(), |name| format!("{number} {name}"))
}

/// Report next to the power of a source; none for the equivalent radiated power.
fn report_of<'a>(result: &'a RunResult, source: &str) -> Option<&'a RadiationReport> {
    result
        .ranking
        .iter()
        .find(|own| own.source == source)?
        .radiation
        .as_ref()
}

/// `radiation.csv` of a source: one-third-octave bands by the far field, by the surface, with radiation efficiency 1,
/// and by the limit of high frequencies if boundary elements are known too; none if it has no second evaluation.
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

/// `radiation-modes.csv` of a source: contribution of each mode to its A-weighted energy, and its damping by radiation;
/// none for a rigid body.
pub(super) fn radiation_modes(result: &RunResult, source: &str) -> Option<Result<Vec<u8>, Error>> {
    let report = report_of(result, source).filter(|report| !report.modes.is_empty())?;
    let header = [
        "body",
        "mode",
        "frequency [Hz]",
        "radiation damping ratio [-]",
        "added mass [-]",
        "frequency shift by it [Hz]",
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
            m.added_mass.map_or_else(String::new, |mass| format!("{mass:.3e}")),
            optional(m.shift_hz, 3),
            format!("{:.4e}", m.share),
        ]
    });
    Some(table(header, rows))
}

/// The sources in an order that no level changes: workpiece, exhaust, body, then others by name.
fn in_order(result: &RunResult) -> Vec<&RankedSource> {
    let place = |source: &&RankedSource| {
        let known = SOURCES.iter().position(|known| *known == source.source);
        (known.unwrap_or(SOURCES.len()), source.source.clone())
    };
    let mut sources: Vec<&RankedSource> = result.ranking.iter().collect();
    sources.sort_by_key(place);
    sources
}

/// `ranking.csv`: the sources, loudest first, and the total; columns of a study are empty without one.
pub(super) fn ranking(result: &RunResult) -> Result<Vec<u8>, Error> {
    let over_draws = |source: &str| {
        let study = result.study.known();
        let spread = study.map(|study| study.spread(source));
        [
            level(spread.and_then(|own| own.low_db)),
            level(spread.and_then(|own| own.high_db)),
            optional(spread.and_then(|own| own.first), 4),
            study.map_or_else(String::new, |study| study.draws.to_string()),
        ]
    };
    let sources = result.ranking.iter().map(|source| {
        let own = [
            source.source.clone(),
            level(source.lwa_db),
            level(source.lw_db),
            format!("{:.6}", source.share),
            source.method.replace(", ", "; ").replace(',', ";"),
        ];
        own.into_iter().chain(over_draws(&source.source))
    });
    let total = [
        TOTAL.to_owned(),
        level(result.total.lwa_db),
        level(result.total.lw_db),
        String::new(),
        String::new(),
    ];
    let header = [
        "source",
        "L_WA [dB]",
        "L_W [dB]",
        "share of A-weighted energy [-]",
        "method",
        "interval low L_WA [dB]",
        "interval high L_WA [dB]",
        "P(first) [-]",
        "draws",
    ];
    table(header, sources.chain([total.into_iter().chain(over_draws(TOTAL))]))
}

/// Titles of a column of each quantity for each source and the total.
fn titles<const N: usize>(sources: &[&RankedSource], quantities: [&str; N]) -> Vec<String> {
    let names = sources.iter().map(|source| source.source.as_str()).chain([TOTAL]);
    names
        .flat_map(|name| quantities.map(|quantity| format!("{name} {quantity}")))
        .collect()
}

/// `levels.csv`: one-third-octave bands by sources and of all together, unweighted and A-weighted. Silence is empty.
pub(super) fn levels(result: &RunResult) -> Result<Vec<u8>, Error> {
    let sources = in_order(result);
    let bands = sources.first().map_or(&[][..], |source| &source.bands);
    let rows = bands.iter().enumerate().map(|(index, first)| {
        let own: Vec<&BandLevel> = sources.iter().filter_map(|source| source.bands.get(index)).collect();
        let sums = [0, 1].map(|weighted| own.iter().map(|band| band.energies()[weighted]).sum());
        let levels = own.iter().flat_map(|band| [band.lw_db, band.lwa_db]);
        let levels: Vec<String> = levels.chain(sums.map(energy_level)).map(level).collect();
        [first.hz.to_string()].into_iter().chain(levels)
    });
    let header = titles(&sources, ["L_W [dB]", "L_WA [dB]"]);
    table(["band [Hz]".to_owned()].into_iter().chain(header), rows)
}

/// `intervals.csv`: interval by source and of all together, the energy-additive level and that of the signal cut at the events.
/// Silence is empty.
pub(super) fn intervals(result: &RunResult) -> Result<Vec<u8>, Error> {
    let sources = in_order(result);
    let header = ["from", "to", "from [s]", "to [s]"].map(str::to_owned);
    let intervals = sources.first().map_or(&[][..], |source| &source.intervals);
    let rows = intervals.iter().enumerate().map(|(index, interval)| {
        let times = [interval.from_s, interval.to_s].map(|time| format!("{time:.7}"));
        let own: Vec<&IntervalLevel> = sources
            .iter()
            .filter_map(|source| source.intervals.get(index))
            .collect();
        let sums = [0, 1].map(|cut| own.iter().map(|interval| interval.energies()[cut]).sum());
        let levels = own.iter().flat_map(|interval| [interval.lwa_db, interval.lwa_cut_db]);
        let levels: Vec<String> = levels.chain(sums.map(energy_level)).map(level).collect();
        [interval.from.clone(), interval.to.clone()]
            .into_iter()
            .chain(times)
            .chain(levels)
    });
    let titles = titles(&sources, ["L_WA [dB]", "L_WA cut [dB]"]);
    table(header.into_iter().chain(titles), rows)
}

/// `power.csv`: A-weighted sound power of every source and of all together over time, mean of each cell around the time given,
/// and the screech frequency of the exhaust's jets there; empty while they are subsonic.
pub(super) fn power(run: &Run) -> Result<Vec<u8>, Error> {
    let sources = in_order(&run.result);
    let named = |source: &&RankedSource| run.powers.iter().find(|power| power.source == source.source);
    let powers: Vec<_> = sources.iter().filter_map(named).collect();
    let cells = powers.first().map_or(0, |power| power.history.power.len());
    let rows = (0..cells).map(|cell| {
        let first = &powers[0].history;
        let time = first.start + cell as f64 * first.sample_interval;
        let own = powers.iter().map(move |power| power.history.power[cell]);
        let total: f64 = own.clone().sum();
        let sample = (time >= 0.0).then(|| (time / run.record.sample_interval).round() as usize);
        let screech = sample.and_then(|sample| run.screech.get(sample).copied().flatten());
        [format!("{time:.7}")]
            .into_iter()
            .chain(own.chain([total]).map(|power| format!("{power:.6e}")))
            .chain([optional(screech, 1)])
    });
    let titles = titles(&sources, ["W_A [W]"]);
    let header = ["time [s]".to_owned()].into_iter().chain(titles);
    table(header.chain(["screech of the exhaust [Hz]".to_owned()]), rows)
}

/// `events.csv`: symbol, description, time. An event that does not occur has an empty time.
pub(super) fn events(events: &Events) -> Result<Vec<u8>, Error> {
    let times = events.to_array();
    let rows = times.iter().zip(EVENT_NAMES).enumerate();
    let rows = rows.map(|(index, (time, name))| [format!("t{index}"), name.to_owned(), optional(*time, 9)]);
    table(["event", "description", "time [s]"], rows)
}

/// `log.csv`: everything that happened, with the state at that instant.
pub(super) fn log(log: &[LogEntry]) -> Result<Vec<u8>, Error> {
    let header = [
        "time [s]",
        "entry",
        "description",
        "piston_travel [m]",
        "piston_velocity [m/s]",
        "valve_lift [m]",
        "valve_velocity [m/s]",
        "tool_rise [m]",
        "tool_velocity [m/s]",
        "tip_depth [m]",
        "above_piston_pressure [Pa]",
        "below_piston_pressure [Pa]",
        "return_volume_pressure [Pa]",
        "above_valve_pressure [Pa]",
        "supply_pressure [Pa]",
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

/// `histories.csv`: time and every history of the cycle; all samples and digits, or every so many samples and seven digits.
pub(super) fn histories(record: &CycleRecord, all: bool) -> Result<Vec<u8>, Error> {
    let columns = columns(record);
    let titles = columns
        .iter()
        .map(|column| format!("{} [{}]", column.name, column.unit));
    let (stride, digits) = if all {
        (1, 9)
    } else {
        (coarse(record.sample_interval), 6)
    };
    let values: Vec<&[f64]> = columns.iter().map(|column| column.values).collect();
    numbers(
        ["time [s]".to_owned()].into_iter().chain(titles),
        (|index| record.time(index), 7),
        (&values, digits),
        stride,
    )
}

/// A level to a thousandth of a decibel; empty for silence.
fn level(value: Option<f64>) -> String {
    optional(value, 3)
}
