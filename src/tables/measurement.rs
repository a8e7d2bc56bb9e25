//! Tables of a wrapping test, the same for the terminal and the page.

use super::{Cell, Column, Table, dash, decibels, fixed};
use crate::measurement::repeats::RepeatedLevel;
use crate::measurement::result::{MeasuredConfiguration, MeasurementResult};

const LEVELS: [&str; 4] = ["shots", "L_{WA,1s} dB", "repeats 95 %", "with method k=2"];

/// Number of shots, level, and its two uncertainties.
fn cells(level: Option<&RepeatedLevel>) -> [Cell; 4] {
    let plus_minus = |value: Option<f64>| Cell::from(dash(value, |value| format!("+-{value:.1}")));
    [
        level.map_or(0, |own| own.repeats).to_string().into(),
        Cell::from(decibels(level.map(|own| own.db))).strong(),
        plus_minus(level.and_then(|own| own.half_width_db)),
        plus_minus(level.map(|own| own.expanded_db)),
    ]
}

/// Levels of the configurations as recorded.
pub(crate) fn configurations(result: &MeasurementResult) -> Table {
    let rows = result.configurations.iter().map(|own| {
        let name = std::iter::once(Cell::from(own.name.as_str()));
        name.chain(cells(own.level.as_ref()))
            .chain([decibels(own.above_residual_db).into()])
            .collect()
    });
    let numbers = LEVELS.into_iter().chain(["above residual dB"]).map(Column::number);
    Table::new(std::iter::once(Column::words("recorded")).chain(numbers), rows)
}

/// Levels of the sources, and the upper bound of the workpiece.
pub(crate) fn sources(result: &MeasurementResult) -> Table {
    let percent = |share: f64| Cell::from(format!("{:.1} %", 100.0 * share));
    let sources = result.sources.iter().map(|own| {
        let name = [
            own.source.as_str().into(),
            format!("{} less residual", own.configuration).into(),
        ];
        let behind = [
            decibels(own.by_energy_db).into(),
            decibels(own.floor_db).into(),
            percent(own.zeroed_share),
            percent(own.before_trigger_share),
        ];
        name.into_iter()
            .chain(cells(own.level.as_ref()))
            .chain(behind)
            .collect()
    });
    let bound = result.bound.iter().map(|own| {
        let name = ["workpiece, upper bound".into(), "total less exhaust and body".into()];
        name.into_iter()
            .chain(cells(own.level.as_ref()))
            .chain([decibels(own.by_energy_db).into()])
            .collect()
    });
    let shares = ["set to zero", "before the trigger"].map(|heading| Column::number(heading).page_only());
    let columns = [Column::words("less residual"), Column::words("measured by").page_only()].into_iter();
    let numbers = LEVELS.into_iter().chain(["by energy", "floor"]).map(Column::number);
    Table::new(columns.chain(numbers).chain(shares), sources.chain(bound))
}

/// Markers of the shots of a configuration.
pub(crate) fn markers(own: &MeasuredConfiguration) -> Table {
    let ms = |seconds: Option<f64>| fixed(seconds.map(|seconds| 1e3 * seconds), 2);
    let rows = own.markers.iter().map(|marker| {
        vec![
            marker.name.as_str().into(),
            marker.event.as_deref().unwrap_or("-").into(),
            marker.meaning.as_str().into(),
            marker.repeats.to_string().into(),
            ms(Some(marker.seconds)).into(),
            ms(marker.deviation_s).into(),
        ]
    });
    let words = ["marker", "event of the cycle", "what happens"].map(Column::words);
    let numbers = ["shots", "mean ms", "deviation ms"].map(Column::number);
    Table::new(words.into_iter().chain(numbers), rows)
}

/// Accelerations of all configurations.
pub(crate) fn accelerations(result: &MeasurementResult) -> Table {
    let sensors = result
        .configurations
        .iter()
        .flat_map(|own| own.accelerations.iter().map(move |sensor| (own, sensor)));
    let rows = sensors.map(|(own, sensor)| {
        vec![
            own.name.as_str().into(),
            sensor.name.as_str().into(),
            format!("{:.2}", sensor.rms_g).into(),
            format!("{:.0}", sensor.peak_g).into(),
        ]
    });
    let words = ["configuration", "accelerometer"].map(Column::words);
    Table::new(
        words
            .into_iter()
            .chain(["RMS over 1 s, g", "peak, g"].map(Column::number)),
        rows,
    )
}
