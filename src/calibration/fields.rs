//! Fields that several measurements have: tables, names, errors.

use nailnoise_calibration::likelihood::Reading;
use nailnoise_documents::{KeyError, Keys, Value, found, nearest};
use nailnoise_quantities::dimension::NUMBER;
use nailnoise_quantities::{Dimension, measure};
use toml::de::DeValue;

use super::measurements::Condition;
use super::spread::Spread;

/// Largest number of shots per measurement.
pub(super) const MOST_SHOTS: usize = 100_000;

/// Weight of the default scatter: with n shots of sample deviation s, the variance combines n - 1 shots at s and this
/// many at the default.
const SHOTS_OF_DEFAULT: f64 = 4.0;

/// The tables in a group, in the order of the file.
pub(super) fn tables<'t, 'i>(
    root: &Keys<'t, 'i>,
    group: &str,
    example: &str,
) -> Result<Vec<(String, Keys<'t, 'i>)>, KeyError> {
    let Some(all) = root.table(group, &format!("[{group}]"))? else {
        return Ok(Vec::new());
    };
    let mut found = Vec::new();
    for key in all.keys().keys() {
        let name = key.get_ref().to_string();
        if let Some(table) = all.table(&name, example)? {
            found.push((name, table));
        }
    }
    Ok(found)
}

/// The index of the condition under which a measurement was made.
pub(super) fn condition_of(table: &Keys<'_, '_>, conditions: &[Condition]) -> Result<usize, KeyError> {
    const EXAMPLE: &str = "\"96 psig\"";
    table.required("condition", EXAMPLE)?;
    let condition = table.text("condition", EXAMPLE)?.unwrap_or_default();
    let known = conditions.iter().map(|own| own.name.as_str());
    place(table, "condition", condition, known, "condition")
}

/// A spread: an amount, a percentage, or both joined by a plus sign.
pub(super) fn spread(table: &Keys<'_, '_>, key: &str, dimension: Dimension) -> Result<Spread, KeyError> {
    spread_by(table, key, &|text| measure(text, dimension))
}

/// A spread that a table may leave out.
pub(super) fn stated_spread(table: &Keys<'_, '_>, key: &str, dimension: Dimension) -> Result<Option<Spread>, KeyError> {
    table.get(key).map(|_| spread(table, key, dimension)).transpose()
}

/// Index and error of the instrument of a reading; none if its table does not name one.
pub(super) fn instrument_of(
    table: &Keys<'_, '_>,
    known: &[(String, Keys<'_, '_>)],
    dimension: Dimension,
) -> Result<Option<(usize, Spread)>, KeyError> {
    if table.get("instrument").is_none() {
        return Ok(None);
    }
    let instrument = named(table, "instrument", known)?;
    Ok(Some((instrument, spread(&known[instrument].1, "error", dimension)?)))
}

/// The same as [`spread`] with amounts read by `amount`.
pub(super) fn spread_by(
    table: &Keys<'_, '_>,
    key: &str,
    amount: &dyn Fn(&str) -> Result<f64, String>,
) -> Result<Spread, KeyError> {
    let Some(value) = table.get(key) else {
        return Ok(Spread {
            share: 0.0,
            amount: 0.0,
        });
    };
    let help = "give an amount, percent of the value, or both, as \"1 % + 2 kPa\"";
    let refuse = |problem: String| table.error(key, problem, help);
    let DeValue::String(text) = value.get_ref() else {
        let amount = table.number(key, value, |_| Err(String::new()))?;
        return Ok(Spread { share: 0.0, amount });
    };
    let mut sum = Spread {
        share: 0.0,
        amount: 0.0,
    };
    for part in text.split(" + ") {
        let (to, number) = match part.trim().strip_suffix('%') {
            Some(percent) => (&mut sum.share, percent.trim().parse().ok().map(|own: f64| 0.01 * own)),
            None => {
                let own = amount(part).map_err(|problem| refuse(format!("is \"{text}\": {problem}")))?;
                (&mut sum.amount, Some(own))
            }
        };
        let number = number.filter(|own| *own >= 0.0 && own.is_finite());
        *to += number.ok_or_else(|| refuse(format!("is \"{text}\", which is not a spread")))?;
    }
    Ok(sum)
}

/// The standard deviation of one reading: `error`, divided by `k`, or `rounding`.
pub(super) fn error(table: &Keys<'_, '_>, dimension: Dimension) -> Result<Spread, KeyError> {
    error_by(table, &|text| measure(text, dimension))
}

/// The same with amounts read by `amount`.
pub(super) fn error_by(table: &Keys<'_, '_>, amount: &dyn Fn(&str) -> Result<f64, String>) -> Result<Spread, KeyError> {
    const EXACT: &str = "no instrument is exact: give `error`, or `rounding` as half of the last digit";
    let factor = match (table.get("error"), table.get("rounding"), table.get("k")) {
        (Some(_), Some(_), _) => {
            return Err(table.error("rounding", "cannot be combined with `error`", "give one of the two"));
        }
        (None, Some(_), Some(_)) => {
            return Err(table.error("k", "belongs to an expanded `error`", "remove it"));
        }
        (None, None, _) => return Err(table.error("error", "is missing", EXACT)),
        (Some(_), None, None) => 1.0,
        (Some(_), None, Some(k)) => {
            let k = table.number("k", k, |text| measure(text, NUMBER))?;
            1.0 / table.within("k", k, [1.0, 10.0], "")?
        }
        // A uniform distribution within the half width.
        (None, Some(_), None) => 1.0 / 3.0_f64.sqrt(),
    };
    let key = if table.get("error").is_some() {
        "error"
    } else {
        "rounding"
    };
    let own = spread_by(table, key, amount)?;
    if own.share + own.amount <= 0.0 {
        return Err(table.error(key, "is 0", EXACT));
    }
    Ok(Spread {
        share: factor * own.share,
        amount: factor * own.amount,
    })
}

/// The index of the instrument named by a key.
pub(super) fn named(table: &Keys<'_, '_>, key: &str, known: &[(String, Keys<'_, '_>)]) -> Result<usize, KeyError> {
    let name = table.text(key, "\"gauge\"")?.unwrap_or_default();
    place(
        table,
        key,
        name,
        known.iter().map(|(own, _)| own.as_str()),
        "instrument",
    )
}

/// The index of a name in a list.
pub(super) fn place<'n>(
    table: &Keys<'_, '_>,
    key: &str,
    name: &str,
    known: impl Iterator<Item = &'n str> + Clone,
    what: &str,
) -> Result<usize, KeyError> {
    known.clone().position(|own| own == name).ok_or_else(|| {
        let near = nearest(known.clone(), name).map_or_else(String::new, |near| format!("is it \"{near}\"? "));
        let all: Vec<&str> = known.collect();
        let help = match all.is_empty() {
            true => format!("add the {what} to [{what}]"),
            false => format!("{near}choose from {}", all.join(", ")),
        };
        table.error(key, format!("is \"{name}\", which is not a known {what}"), help)
    })
}

/// A text or a list of texts.
pub(super) fn words(table: &Keys<'_, '_>, key: &str, example: &str) -> Result<Vec<String>, KeyError> {
    let Some(value) = table.get(key) else {
        return Ok(Vec::new());
    };
    let list = match value.get_ref() {
        DeValue::Array(list) => list
            .iter()
            .map(|own| own.get_ref().as_str().map(str::to_owned))
            .collect(),
        own => own.as_str().map(|text| vec![text.to_owned()]),
    };
    list.ok_or_else(|| table.error(key, format!("is {}", found(value.get_ref())), format!("give {example}")))
}

/// Refuses values of several kinds, and none.
pub(super) fn of_given(table: &Keys<'_, '_>) -> Result<(), KeyError> {
    let given = ["value", "values", "at_most", "at_least"];
    let given: Vec<&str> = given.into_iter().filter(|key| table.get(key).is_some()).collect();
    if matches!(
        given[..],
        ["value"] | ["values"] | ["at_most"] | ["at_least"] | ["at_most", "at_least"]
    ) {
        return Ok(());
    }
    let help = "give `value`, `values` of repeated shots, or `at_most` and `at_least`";
    let problem = match given[..] {
        [] => "has no value",
        _ => "has values of several kinds",
    };
    Err(table.error(given.get(1).copied().unwrap_or(""), problem, help))
}

/// A value, its bounds or the mean of its repeats.
pub(super) struct Repeats {
    pub(super) reading: Reading,
    /// The value to which percentages refer.
    pub(super) typical: f64,
    pub(super) shots: f64,
    /// Standard deviation of one shot, if the file gives it through values or `scatter`.
    pub(super) scatter: Option<f64>,
}

/// The values of repeated shots, each read by `read`; none without the key.
pub(super) fn repeated(
    table: &Keys<'_, '_>,
    read: &dyn Fn(&str, &Value<'_>) -> Result<f64, KeyError>,
) -> Result<Option<Vec<f64>>, KeyError> {
    let Some(values) = table.get("values") else {
        return Ok(None);
    };
    if let Some(other) = ["shots", "scatter"].into_iter().find(|key| table.get(key).is_some()) {
        return Err(table.error(other, "follows from `values`", "remove it"));
    }
    let list = values.get_ref().as_array();
    let list = list.filter(|list| !list.is_empty()).ok_or_else(|| {
        let problem = match list {
            Some(_) => "is empty".to_owned(),
            None => format!("is {}", found(values.get_ref())),
        };
        table.error("values", problem, "give a list of values")
    })?;
    list.iter()
        .map(|own| read("values", own))
        .collect::<Result<_, _>>()
        .map(Some)
}

/// Mean of repeats, and the standard deviation of one of them, mixed with the default for that mean.
pub(super) fn mean_and_scatter(values: &[f64], by_default: impl Fn(f64) -> f64) -> (f64, f64) {
    let n = values.len() as f64;
    let mean = values.iter().sum::<f64>() / n;
    let squares: f64 = values.iter().map(|own| (own - mean).powi(2)).sum();
    let variance = (SHOTS_OF_DEFAULT * by_default(mean).powi(2) + squares) / (n - 1.0 + SHOTS_OF_DEFAULT);
    (mean, variance.sqrt())
}

/// The reading of `value`, `at_most` and `at_least`, in the unit of the data by `of`.
pub(super) fn reading(
    table: &Keys<'_, '_>,
    [value, most, least]: [Option<f64>; 3],
    of: impl Fn(f64) -> f64,
) -> Result<Reading, KeyError> {
    Ok(match (value, most, least) {
        (Some(value), ..) => Reading::Value(of(value)),
        (None, Some(most), Some(least)) if least < most => Reading::Within([of(least), of(most)]),
        (None, Some(_), Some(_)) => return Err(table.error("at_least", "is not below `at_most`", "swap the two")),
        (None, Some(most), None) => Reading::AtMost(of(most)),
        (None, None, least) => Reading::AtLeast(of(least.unwrap_or_default())),
    })
}
