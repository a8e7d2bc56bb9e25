//! Rows of a result for measured levels, and for the levels of the design's own shot.

use std::collections::BTreeMap;

use nailnoise_calibration::conflict::CONFLICT;
use nailnoise_calibration::likelihood::Reading;

use super::levels::{ByLevels, ERRORS, FEWEST, LevelRow, LevelWork, Levelled};
use super::measurements::{MeasuredLevel, Measurements};
use super::posterior::Found;
use super::result::{CalibrationResult, ConflictRow, MeasurementRow, Table, Verdict};
use crate::design::Design;
use crate::error::Error;
use crate::result::TOTAL;
use crate::store::Store;
use crate::study::{LevelStudy, Serving};

/// P5, P50 and P95 of each source and of the total in the study of a design, if there is one \[dB re 1 pW s\].
///
/// # Errors
/// If the design cannot be digested.
pub(super) fn ranges(store: &Store, design: &Design) -> Result<BTreeMap<String, [f64; 3]>, Error> {
    let Some(serving) = Serving::of(store, design)? else {
        return Ok(BTreeMap::new());
    };
    let study = serving.result;
    let sources = study.sources.iter().map(|own| (own.source.as_str(), &own.level));
    let percentiles = |(name, level): (&str, &LevelStudy)| {
        let [low, high] = level.ends(study.draws).map(|own| own.value);
        Some((name.to_owned(), [low?, level.level_db.p50.value?, high?]))
    };
    Ok(sources.chain([(TOTAL, &study.total)]).filter_map(percentiles).collect())
}

/// Adds the levels to a result and to the table of its draws.
pub(super) fn add(
    levels: &ByLevels,
    (measured, ranges): (&Measurements, &BTreeMap<String, [f64; 3]>),
    result: &mut CalibrationResult,
    table: &mut Table,
) {
    let own = &levels.draws;
    for found in own.conflicts.iter().filter_map(|own| own.of_cycle) {
        let row = &mut result.measurements[found];
        (row.counts, row.verdict) = (false, Verdict::Conflict);
    }
    let rows = measured.levels.iter().enumerate();
    let rows: Vec<MeasurementRow> = rows.map(|(k, level)| row(own, measured, (k, level))).collect();
    result.measurements.extend(rows);
    let conflicts: Vec<ConflictRow> = own
        .conflicts
        .iter()
        .map(|found| conflict(own, measured, found))
        .collect();
    result.conflicts.extend(conflicts);
    let outputs = own.sources().iter().map(String::as_str).chain([TOTAL]);
    let level = |(place, output): (usize, &str)| {
        let [before, now] = own.percentiles(|draw| own.level(output, draw));
        LevelRow {
            output: output.to_owned(),
            ranges: ranges.get(output).copied(),
            before,
            now,
            first: (output != TOTAL).then(|| own.first(place)),
        }
    };
    result.levels = outputs.clone().enumerate().map(level).collect();
    result.level_work = Some(LevelWork {
        shots: own.shots,
        errors: ERRORS,
        effective: own.effective,
    });
    if own.effective < FEWEST {
        result.converged = false;
        result.faults.push(format!(
            "the levels leave {:.0} effective shots of {}, and intervals need {FEWEST}",
            own.effective, own.shots
        ));
    }
    notes(own, measured, &mut result.notes);
    table.names.extend(own.further_names());
    table
        .names
        .extend(outputs.clone().map(|output| format!("level.{output}")));
    for (row, &draw) in table.rows.iter_mut().zip(&levels.chosen) {
        row.extend(own.further(draw));
        row.extend(outputs.clone().map(|output| own.level(output, draw)));
    }
}

fn row(own: &Levelled, measured: &Measurements, (k, level): (usize, &MeasuredLevel)) -> MeasurementRow {
    let shown = |level_db: f64| level.quantity.shown(level_db).1;
    let [before, now] = own.percentiles(|draw| own.prediction(k, draw));
    let probability = own.probability(k);
    let in_conflict = |found: &&Found| found.datum == k || found.partner == Some(k);
    let verdict = match own.conflicts.iter().find(in_conflict) {
        Some(found) if found.unreached.is_some() => Verdict::NotReached,
        Some(_) => Verdict::Conflict,
        None if probability < CONFLICT => Verdict::Conflict,
        None if own.held_out.contains(&k) => Verdict::Predicted,
        None => Verdict::Met,
    };
    MeasurementRow {
        name: level.name.clone(),
        condition: measured.conditions[level.condition].name.clone(),
        unit: level.quantity.shown(0.0).0.to_owned(),
        reading: match level.reading {
            Reading::Value(value) => [Some(shown(value)); 2],
            Reading::AtMost(most) => [None, Some(shown(most))],
            Reading::AtLeast(least) => [Some(shown(least)), None],
            Reading::Within(ends) => ends.map(|end| Some(shown(end))),
        },
        before: [before[0], before[2]].map(shown),
        now: [now[0], now[2]].map(shown),
        left_over: own.left_over(k),
        probability,
        counts: own.likelihood.data()[k].counts,
        verdict,
    }
}

fn conflict(own: &Levelled, measured: &Measurements, found: &Found) -> ConflictRow {
    let level = &measured.levels[found.datum];
    let partner = found.partner.map(|k| measured.levels[k].name.clone());
    let of_cycle = found.of_cycle.map(|k| measured.data[k].name.clone());
    let pressed = own.pressed(found.datum).into_iter().map(|(source, is_upper, share)| {
        let end = if is_upper { "upper" } else { "lower" };
        format!(
            "widen `study.model.{source}`: with this level {:.0} % of the draws are at the {end} bound of its method's \
             error",
            100.0 * share
        )
    });
    let check = "check the calibration of the instrument, its position, and the sound of the room and of the \
        background, which the level must not contain";
    ConflictRow {
        measurement: level.name.clone(),
        partner: partner.or(of_cycle),
        probability: found.probability,
        nearest: found.unreached.map(|own| level.quantity.shown(own.nearest).1),
        unit: level.quantity.shown(0.0).0.to_owned(),
        distance: found.unreached.map(|own| own.distance),
        gain: None,
        widened: found.factor,
        remedies: pressed.chain([check.to_owned()]).collect(),
    }
}

fn notes(own: &Levelled, measured: &Measurements, notes: &mut Vec<String>) {
    notes.push(format!(
        "levels of {} shots with {ERRORS} errors of the methods each; weighted by the measured levels they count as \
         {:.0} shots",
        own.shots, own.effective
    ));
    let left_out = own.conflicts.iter().filter(|own| own.factor.is_none());
    let left_out: Vec<&str> = left_out
        .flat_map(|found| {
            let levels = [Some(found.datum), found.partner].into_iter().flatten();
            let levels = levels.map(|k| measured.levels[k].name.as_str());
            levels.chain(found.of_cycle.map(|k| measured.data[k].name.as_str()))
        })
        .collect();
    if !left_out.is_empty() {
        notes.push(format!(
            "all intervals leave out {} because of the conflict",
            left_out.join(", ")
        ));
    }
}
