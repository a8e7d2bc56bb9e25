//! Checks that the numbers of a finished result are plausible and consistent, because anybody may have changed the
//! file.

use serde_json::Value;

use nailnoise_acoustics::signals::{REFERENCE_ENERGY, SILENCE};

use crate::decibels::energy;
use crate::result::{BandLevel, Component, IntervalLevel, RankedSource, Total};

/// Largest difference between a level and the sum of its parts \[dB\], for levels rounded to two decimals.
const ROUNDING_DB: f64 = 0.02;

/// Largest difference between a share and that of the energy \[-\].
const ROUNDING_SHARE: f64 = 1e-3;

/// Plausible ranges of numbers by the suffix of their key, the first that fits: levels \[dB\], shifts of frequencies
/// and frequencies \[Hz\], accelerations \[g\], sound pressures \[Pa\] and areas \[m2\].
const POSSIBLE: [(&str, [f64; 2]); 6] = [
    ("_db", [-300.0, 300.0]),
    ("shift_hz", [-1e6, 1e6]),
    ("hz", [0.0, 1e6]),
    ("_g", [0.0, 1e9]),
    ("_pa", [0.0, 1e9]),
    ("_m2", [0.0, 1e9]),
];

/// A place in a result, with its actual and its expected value.
#[derive(Debug, PartialEq)]
pub(super) struct Fault {
    /// Path in the JSON value.
    pub(super) at: String,
    pub(super) found: String,
    pub(super) expected: String,
}

/// Checks that every number of a result is within its plausible range.
pub(super) fn numbers(value: &Value) -> Result<(), Fault> {
    visit(value, "", None)
}

/// The limits are those of the closest enclosing key that has any.
fn visit(value: &Value, at: &str, limits: Option<[f64; 2]>) -> Result<(), Fault> {
    match value {
        Value::Object(members) => members.iter().try_for_each(|(key, member)| {
            let own = POSSIBLE.iter().find(|(end, _)| key.ends_with(end));
            let at = if at.is_empty() {
                key.clone()
            } else {
                format!("{at}.{key}")
            };
            visit(member, &at, own.map(|(_, limits)| *limits).or(limits))
        }),
        Value::Array(items) => items
            .iter()
            .enumerate()
            .try_for_each(|(place, item)| visit(item, &format!("{at}[{place}]"), limits)),
        Value::Number(number) => match (number.as_f64(), limits) {
            (Some(found), Some([low, high])) if !(low..=high).contains(&found) => Err(Fault {
                at: at.to_owned(),
                found: found.to_string(),
                expected: format!("a number from {low} to {high}"),
            }),
            _ => Ok(()),
        },
        _ => Ok(()),
    }
}

/// Checks that parts add up to their source and sources to the total, and that the ranking is in order.
pub(super) fn sums(ranking: &[RankedSource], total: &Total) -> Result<(), Fault> {
    let fault = |at: String, found: String, expected: &str| {
        Err(Fault {
            at,
            found,
            expected: expected.to_owned(),
        })
    };
    if ranking.is_empty() {
        return fault("ranking".to_owned(), "empty".to_owned(), "at least one source");
    }
    for (place, source) in ranking.iter().enumerate() {
        let at = format!("ranking[{place}]");
        if ranking[..place].iter().any(|other| other.source == source.source) {
            return fault(
                format!("{at}.source"),
                format!("\"{}\" again", source.source),
                "each source once",
            );
        }
        source_sums(source, &at)?;
    }
    let all = |level: fn(&RankedSource) -> Option<f64>| ranking.iter().map(level).map(energy).collect::<Vec<_>>();
    sum("total.lwa_db", total.lwa_db, &all(|source| source.lwa_db), "sources")?;
    sum("total.lw_db", total.lw_db, &all(|source| source.lw_db), "sources")?;
    let energy_of_all = energy(total.lwa_db);
    for (place, source) in ranking.iter().enumerate() {
        let (at, own) = (format!("ranking[{place}]"), energy(source.lwa_db));
        if ranking[..place]
            .last()
            .is_some_and(|louder| energy(louder.lwa_db) < own)
        {
            return fault(format!("{at}.lwa_db"), level(source.lwa_db), "the loudest source first");
        }
        let share = if energy_of_all > 0.0 { own / energy_of_all } else { 0.0 };
        if source.share < 0.0 || (share - source.share).abs() > ROUNDING_SHARE {
            let expected = format!("{share:.4}, its part of the total energy");
            return fault(format!("{at}.share"), source.share.to_string(), &expected);
        }
    }
    Ok(())
}

fn source_sums(source: &RankedSource, at: &str) -> Result<(), Fault> {
    let (weighted, plain) = (format!("{at}.lwa_db"), format!("{at}.lw_db"));
    let parts = &source.components;
    if !parts.is_empty() {
        let of =
            |level: Option<f64>, place: usize, part: &Component| part_energy(level, part.energies_j.map(|e| e[place]));
        let energies: Vec<f64> = parts.iter().map(|part| of(part.lwa_db, 1, part)).collect();
        sum_of_surfaces(&weighted, source.lwa_db, &energies, "components")?;
        let energies: Vec<f64> = parts.iter().map(|part| of(part.lw_db, 0, part)).collect();
        sum_of_surfaces(&plain, source.lw_db, &energies, "components")?;
    }
    let bands = |bands: &[BandLevel]| -> [Vec<f64>; 2] {
        let of =
            |level: Option<f64>, place: usize, band: &BandLevel| part_energy(level, band.energies_j.map(|e| e[place]));
        [
            bands.iter().map(|band| of(band.lwa_db, 1, band)).collect(),
            bands.iter().map(|band| of(band.lw_db, 0, band)).collect(),
        ]
    };
    let [of_weighted, of_plain] = bands(&source.bands);
    sum(&weighted, source.lwa_db, &of_weighted, "bands")?;
    sum(&plain, source.lw_db, &of_plain, "bands")?;
    for (place, part) in parts.iter().enumerate() {
        let [of_weighted, of_plain] = bands(&part.bands);
        let at = format!("{at}.components[{place}]");
        sum_of_surfaces(&format!("{at}.lwa_db"), part.lwa_db, &of_weighted, "bands")?;
        sum_of_surfaces(&format!("{at}.lw_db"), part.lw_db, &of_plain, "bands")?;
    }
    let of = |interval: &IntervalLevel| part_energy(interval.lwa_db, interval.energies_j.map(|e| e[0]));
    let intervals: Vec<f64> = source.intervals.iter().map(of).collect();
    sum(&weighted, source.lwa_db, &intervals, "intervals")
}

/// Checks that a level is that of the summed energies of its parts. A part of a surface that absorbs sound from the
/// others has no level, and the others then sum to more.
fn sum_of_surfaces(at: &str, whole: Option<f64>, parts: &[f64], what: &str) -> Result<(), Fault> {
    let radiated: f64 = parts.iter().sum();
    let absorbs = parts.contains(&0.0);
    if absorbs && energy(whole) < radiated {
        return Ok(());
    }
    sum(at, whole, parts, what)
}

/// Checks that a level is that of the summed energies of its parts; parts without a level may each have up to the
/// energy of silence.
fn sum(at: &str, whole: Option<f64>, parts: &[f64], what: &str) -> Result<(), Fault> {
    let energy: f64 = parts.iter().sum();
    let silent = parts.iter().filter(|part| **part == 0.0).count() as f64 * SILENCE / REFERENCE_ENERGY;
    let decibels = |energy: f64| (energy > 0.0).then(|| 10.0 * energy.log10());
    let expected = decibels(energy);
    let agrees = match (whole, expected, decibels(energy + silent)) {
        (Some(whole), least, Some(most)) => {
            whole <= most + ROUNDING_DB && least.is_none_or(|least| whole >= least - ROUNDING_DB)
        }
        (whole, expected, _) => whole.is_none() && expected.is_none(),
    };
    if agrees {
        return Ok(());
    }
    Err(Fault {
        at: at.to_owned(),
        found: level(whole),
        expected: format!("{}, the sum of its {what}", level(expected)),
    })
}

/// Energy of a part relative to the reference: the stated one, which may be negative, or that of its level.
fn part_energy(level: Option<f64>, stated: Option<f64>) -> f64 {
    stated.map_or_else(|| energy(level), |joule| joule / REFERENCE_ENERGY)
}

fn level(level: Option<f64>) -> String {
    level.map_or_else(|| "null".to_owned(), |level| format!("{level:.2} dB"))
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde_json::json;

    fn place(value: &Value) -> Option<String> {
        numbers(value).err().map(|fault| fault.at)
    }

    #[test]
    fn a_number_that_cannot_be_is_found_with_its_path() {
        let absurd = json!({"ranking": [{"bands": [{"lw_db": 80.0}, {"lw_db": 1e4}]}]});
        assert_eq!(place(&absurd).as_deref(), Some("ranking[0].bands[1].lw_db"));
        assert_eq!(place(&json!({"a": {"peak_pa": -0.1}})).as_deref(), Some("a.peak_pa"));
        let bound = json!({"uncertainty_db": {"minus": -1.0, "plus": 400.0}});
        assert_eq!(place(&bound).as_deref(), Some("uncertainty_db.plus"));
    }

    #[test]
    fn numbers_that_can_be_pass() {
        let value = json!({"lwa_db": null, "lw_db": -40.0, "share": -1e-32, "range_hz": [50, 2e4], "force": -1e5});
        assert_eq!(numbers(&value), Ok(()));
        assert_eq!(
            numbers(&json!({"modes": [{"frequency_hz": 90.0, "shift_hz": -0.4}]})),
            Ok(())
        );
        assert_eq!(
            place(&json!({"modes": [{"frequency_hz": -0.4}]})).as_deref(),
            Some("modes[0].frequency_hz")
        );
    }

    #[test]
    fn energies_sum_and_levels_do_not() {
        let check = |whole, parts: &[Option<f64>]| {
            let energies: Vec<f64> = parts.iter().map(|level| energy(*level)).collect();
            sum("total", whole, &energies, "sources")
        };
        assert_eq!(check(Some(103.01), &[Some(100.0), Some(100.0), None]), Ok(()));
        assert!(check(Some(103.1), &[Some(100.0), Some(100.0)]).is_err());
        assert_eq!(check(None, &[None]), Ok(()));
        assert!(check(None, &[Some(0.0)]).is_err());
    }

    #[test]
    fn surfaces_sum_to_more_where_one_absorbs() {
        let check = |whole, parts: &[Option<f64>]| {
            let energies: Vec<f64> = parts.iter().map(|level| energy(*level)).collect();
            sum_of_surfaces("source", whole, &energies, "components")
        };
        assert_eq!(check(Some(99.0), &[Some(100.0), None]), Ok(()));
        assert_eq!(check(None, &[Some(10.0), None]), Ok(()));
        assert!(check(Some(101.0), &[Some(100.0), None]).is_err());
        assert!(check(Some(99.0), &[Some(100.0)]).is_err());
    }
}
