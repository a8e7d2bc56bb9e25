//! Resolves a chain of files to one value per key.

use std::collections::{BTreeSet, HashMap};

use nailnoise_acoustics::signals::band_containing;
use nailnoise_quantities::dimension::NUMBER;
use nailnoise_quantities::{Dimension, Group, KeySpec, Kind, Measured, Value, dotted, members};

use super::assembly::{self, AssemblyKeys};
use super::catalogue::Names;
use super::derived::{AGREEMENT, Derived};
use super::derived_range::{DerivedRange, MergedDerived};
use super::derived_value::MergedDerivedValues;
use super::distribution::Distribution;
use super::error::{DesignError, Problem, Warning};
use super::groups::Values;
use super::merged::Merged;
use super::optional_keys;
use super::provenance::Provenance;
use super::range::{DefaultRange, RangeOrigin, Ranged, includes, inherited};
use super::recorded_surfaces::RecordedSurfaceProblem;
use super::renamed::old_keys;
use super::report::ReportSettings;
use super::sensors::SensorProblem;
use super::settings::{Given, Layer, Setting};
use super::show::show;
use super::source::File;
use super::springs::Sprung;
use super::study::{self, StudyLayer, StudySettings};
use super::surfaces::SurfaceProblem;
use super::tool_outcomes::ToolOutcomes;
use nailnoise_documents::Place;
use nailnoise_dynamics::network::AssemblyText;

/// A key with its resolved value and its origin.
#[derive(Debug, Clone)]
pub(crate) struct Record {
    pub(crate) value: Value,
    pub(crate) range: Option<[f64; 2]>,
    pub(crate) range_origin: Option<RangeOrigin>,
    /// The range that the base states, if the value is given without one.
    range_of_base: Option<[f64; 2]>,
    pub(crate) distribution: Distribution,
    pub(crate) provenance: Provenance,
    pub(crate) source: String,
    pub(crate) note: String,
    pub(crate) place: Box<Place>,
    depth: usize,
}

/// All keys of a design by their full names.
pub(crate) type Records = HashMap<String, Record>;

/// A design whose values are known and compatible.
#[derive(Debug)]
pub(crate) struct Resolved {
    pub(crate) values: Values,
    pub(crate) records: Records,
    pub(crate) derived: Vec<DerivedRange>,
    pub(crate) study: StudySettings,
    pub(crate) report: ReportSettings,
    pub(crate) assembly: Option<AssemblyText>,
    pub(crate) warnings: Vec<Warning>,
}

/// Reads the files of a chain, nearest first, and resolves every key.
pub(crate) fn resolve(chain: &[File]) -> Result<Resolved, DesignError> {
    let mut merged = HashMap::new();
    let mut layers = Vec::new();
    let mut studies = Vec::new();
    let mut report = ReportSettings::default();
    let assembly = assembly::of_chain(chain)?;
    let own = AssemblyKeys::of(assembly.as_ref());
    let outcomes = ToolOutcomes::of(assembly.as_ref(), assembly::files_to_name(chain)?);
    let mut warnings = Vec::new();
    for (depth, file) in chain.iter().enumerate().rev() {
        let table = file.table()?;
        let old = old_keys(&table).into_iter();
        warnings.extend(old.filter_map(|old| {
            Some(Warning::Renamed {
                key: old.key,
                successor: old.new?,
                at: file.place(old.span),
            })
        }));
        let layer = Layer::read(file, &table, &Values::SPEC, &own)?;
        layers.push((depth, file.is_command_line(), layer));
        studies.extend(StudyLayer::of(file, &table, &Values::SPEC, depth)?);
        report.read(file, &table)?;
    }
    let mut derived = MergedDerived::default();
    let mut derived_values = MergedDerivedValues::default();
    let (names, agreeing) = merge_layers(&mut merged, (&mut derived, &mut derived_values), layers)?;
    optional_keys::add_missing(&mut merged);
    let default = study::default_range(&studies);
    let has_workpiece = merged
        .get("workpiece.length")
        .is_some_and(|merged| merged.value.is_some());
    complete(&merged, chain).map_err(|error| match &assembly {
        Some(text) if !has_workpiece => assembly::only_assembly(text, chain),
        _ => error,
    })?;

    let ambient = match merged.get("ambient.pressure").and_then(|merged| merged.value.as_ref()) {
        Some((Given::Quantity(pressure), ..)) => pressure.si,
        _ => 0.0,
    };
    let mut records = Records::with_capacity(merged.len());
    for (key, merged) in merged {
        if let Some(record) = record(&key, merged, ambient, default)? {
            records.insert(key, record);
        }
    }
    let ranged = |key: &str| {
        let range = records.get(key).and_then(|record| record.range);
        range.is_some_and(|[low, high]| low < high) || derived.draws(key)
    };
    let study = study::joined(studies, &names, ranged, ambient, &outcomes)?;
    let found = records
        .iter()
        .map(|(key, record)| (key.clone(), record.value.clone()))
        .collect();
    let mut values =
        Values::build("", &found).map_err(|key| missing_key((key, false), 1, "a value".to_owned(), chain))?;
    derived_values.apply(&mut values, |dependent| {
        if let Some(record) = records.get_mut(dependent.follower) {
            record.value = dependent.value;
            record.provenance = Provenance::Design;
            record.source = format!("follows from `{}`", dependent.from);
            (record.place, record.depth) = (dependent.at, dependent.depth);
        }
    })?;
    // With an assembly the keys that it uses are known later.
    if let Some(conflict) = values.conflict().filter(|_| assembly.is_none()) {
        return Err(conflicting(conflict, &records));
    }
    if let Some((name, problem)) = values.sensor_problem() {
        return Err(sensor(name, problem, &records));
    }
    if let Some((name, problem)) = values.surface_problem() {
        return Err(surface(name, problem, &records));
    }
    if let Some((name, problem)) = values.record_problem() {
        return Err(recorded_surface(name, problem, &records));
    }
    warnings.extend(outside_range(&values, &records));
    warnings.extend(exhaust_max_frequency(&values, &records));
    for given in agreeing {
        warnings.push(agree(given, &values)?);
    }
    let derived = derived.resolved(&values, default, ambient)?;
    Ok(Resolved {
        values,
        records,
        derived,
        study,
        report,
        assembly,
        warnings,
    })
}

/// Merges the settings of the files, the furthest base first. Names rank below the keys of their file, and all values
/// of the command line count as one file: a key wins over a name regardless of their order.
fn merge_layers(
    merged: &mut HashMap<String, Merged>,
    (derived, derived_values): (&mut MergedDerived, &mut MergedDerivedValues),
    layers: Vec<(usize, bool, Layer)>,
) -> Result<(Names, Vec<Agreeing>), DesignError> {
    let (on_command_line, in_files): (Vec<_>, Vec<_>) =
        layers.into_iter().partition(|(_, is_command_line, _)| *is_command_line);
    let files = in_files.into_iter().map(|layer| vec![layer]);
    let (mut names, mut agreeing) = (Names::default(), Vec::new());
    for file in files.chain([on_command_line]) {
        let all: Vec<&Setting> = file.iter().flat_map(|(.., layer)| &layer.settings).collect();
        let depth = file.iter().map(|(depth, ..)| *depth).max().unwrap_or(0);
        for setting in names.expand(&all)? {
            // Discards everything that a base states, including range and note.
            merged.remove(&setting.key);
            merge(merged, setting, depth);
        }
        let ranged = all.iter().filter(|setting| setting.range.is_some());
        let ranged: Vec<String> = ranged.map(|setting| setting.key.clone()).collect();
        ranged.iter().for_each(|key| derived.drop_of_follower(key));
        let valued = all.iter().filter(|setting| setting.value.is_some());
        let valued: Vec<String> = valued.map(|setting| setting.key.clone()).collect();
        derived_values.drop_of_followers(&valued);
        let mut of_file = Vec::new();
        for (depth, is_command_line, layer) in file {
            for setting in layer.settings {
                merge(merged, setting, depth);
            }
            let here = (depth, is_command_line);
            of_file.extend(layer.derived.into_iter().map(|given| (here, given)));
        }
        for (here, mut given) in of_file {
            if derived_values.take(&given, here, &valued)? {
                agreeing.retain(|own: &Agreeing| own.derived.key != given.derived.key);
            } else if let Some((value, at)) = given.value.take() {
                agreeing.push(Agreeing {
                    derived: given.derived,
                    value,
                    at,
                });
            }
            derived.take(given, merged, &ranged)?;
        }
    }
    Ok((names, agreeing))
}

fn merge(merged: &mut HashMap<String, Merged>, setting: Setting, depth: usize) {
    let Setting {
        key,
        spec,
        value,
        range,
        distribution,
        provenance,
        note,
    } = setting;
    let entry = merged.entry(key).or_insert_with(|| Merged {
        spec,
        value: None,
        range: None,
        value_of_range: None,
        distribution: None,
        provenance: Provenance::Design,
        source: String::new(),
        note: String::new(),
        depth,
    });
    if value.is_some() {
        if entry.range.is_some() && entry.value_of_range.is_none() {
            entry.value_of_range = entry.given();
        }
        entry.value = value;
        // A numerical setting keeps its class with any value.
        if entry.provenance != Provenance::Numerical {
            entry.provenance = Provenance::Design;
        }
        entry.source.clear();
        entry.depth = depth;
    }
    if range.is_some() {
        (entry.range, entry.value_of_range) = (range, None);
    }
    if distribution.is_some() {
        entry.distribution = distribution;
    }
    if let Some((provenance, source)) = provenance {
        (entry.provenance, entry.source) = (provenance, source);
    }
    if let Some(note) = note {
        entry.note = note;
    }
}

/// Checks that every key has a value in one of the files.
fn complete(merged: &HashMap<String, Merged>, chain: &[File]) -> Result<(), DesignError> {
    let mut first: Option<(String, String)> = None;
    let mut count = 0;
    let keys: BTreeSet<&String> = merged.keys().collect();
    Values::SPEC.each_key_of("", &|list| members(keys.iter().copied(), list), &mut |key, spec| {
        if merged.get(key).is_none_or(|merged| merged.value.is_none()) {
            count += 1;
            first.get_or_insert_with(|| (key.to_owned(), example(spec.kind)));
        }
    });
    let Some((key, example)) = first else { return Ok(()) };
    // Includes the given keys of a list's member, if the key belongs to one.
    let group = key.rsplit_once('.').map_or("", |(group, _)| group);
    let mut lists = Values::SPEC.lists.iter();
    let is_member = lists.any(|(list, _)| group.starts_with(&dotted(list, "")));
    let beside = merged
        .iter()
        .filter(|(other, _)| is_member && other.rsplit_once('.').is_some_and(|(own, _)| own == group));
    let places = beside.filter_map(|(_, merged)| merged.value.as_ref().map(|(.., place)| (merged.depth, place)));
    let first = places.min_by_key(|(depth, place)| (*depth, place.span().start));
    let mut error = missing_key((key, is_member), count, example, chain);
    if let Some((_, place)) = first {
        error.at = Some(place.clone());
    }
    Err(error)
}

/// Error for a missing key, which may belong to a member of a list.
fn missing_key((key, is_member): (String, bool), count: usize, example: String, chain: &[File]) -> DesignError {
    // The chain contains at least the design itself.
    let at = chain[chain.len() - 1].place(0..0);
    Problem::Missing {
        key,
        example,
        count,
        is_member,
    }
    .at(at)
}

fn example(kind: Kind) -> String {
    match kind {
        Kind::Quantity { dimension: NUMBER, .. } => "NUMBER".to_owned(),
        Kind::Quantity { dimension, .. } => format!("\"NUMBER {}\"", dimension.unit()),
        Kind::Count(_) => "COUNT".to_owned(),
        Kind::Switch => "true".to_owned(),
        Kind::Choice(words) => format!("\"{}\"", words.first().unwrap_or(&"")),
        Kind::File => "\"\"".to_owned(),
        Kind::Name => "\"NAME\"".to_owned(),
    }
}

fn record(key: &str, merged: Merged, ambient: f64, default: DefaultRange) -> Result<Option<Record>, DesignError> {
    let Merged {
        spec,
        value,
        range,
        value_of_range,
        distribution,
        provenance,
        source,
        note,
        depth,
    } = merged;
    let Some((given, text, place)) = value else {
        return Ok(None);
    };
    let dimension = dimension(spec.kind);
    let value = match given {
        Given::Other(value) => value,
        Given::Quantity(measured) => {
            let value = measured.absolute(ambient);
            if !spec.kind.allows(value) {
                let found = format!("{text}, {} absolute", show(value, dimension));
                let (key, allowed) = (key.to_owned(), spec.kind.allowed());
                return Err(Problem::OutsideLimits { key, found, allowed }.at(place));
            }
            Value::Number(value)
        }
    };
    let number = |value: &Value| match value {
        Value::Number(value) => *value,
        Value::Count(count) => f64::from(*count),
        Value::Switch(_) | Value::Choice(_) | Value::File(_) | Value::Name(_) => f64::NAN,
    };
    let ranged = match range {
        None => None,
        Some((given, at)) => {
            let own = number(&value);
            let base = match value_of_range {
                Some(Given::Quantity(measured)) => measured.absolute(ambient),
                Some(Given::Other(value)) => number(&value),
                None => own,
            };
            let stated = given.of(base, ambient);
            let [low, high] = stated.map(|end| show(end, dimension));
            let key = key.to_owned();
            if stated[0] > stated[1] {
                return Err(Problem::BadRange { key, low, high }.at(at));
            }
            let ranged = inherited(own, (base, stated), default, spec.kind.domain());
            if !includes(ranged.range, own) {
                let value = show(own, dimension);
                return Err(Problem::RangeWithoutValue { key, value, low, high }.at(at));
            }
            Some(ranged)
        }
    };
    let range = ranged.map(|own| own.range);
    let distribution = match distribution {
        None => Distribution::default(),
        Some((distribution, at)) => {
            let problem = match range {
                Some(range) => distribution.problem(number(&value), range),
                None => Some("it has no range"),
            };
            if let Some(because) = problem {
                return Err(Problem::BadDistribution {
                    key: key.to_owned(),
                    distribution: distribution.as_str(),
                    because,
                }
                .at(at));
            }
            distribution
        }
    };
    Ok(Some(Record {
        value,
        range,
        range_origin: ranged.map(|own: Ranged| own.origin),
        range_of_base: ranged.and_then(|own| own.of_base),
        distribution,
        provenance,
        source,
        note,
        place,
        depth,
    }))
}

fn dimension(kind: Kind) -> Dimension {
    match kind {
        Kind::Quantity { dimension, .. } => dimension,
        _ => NUMBER,
    }
}

/// The conflict, reported at the key that was set last: in the file nearest to the design, and there furthest down.
pub(crate) fn conflicting(conflict: super::Conflict, records: &Records) -> DesignError {
    let mut places: Vec<_> = conflict
        .keys()
        .into_iter()
        .filter_map(|key| records.get(key).map(|record| (key, record)))
        .collect();
    places.sort_by_key(|(_, record)| (record.depth, usize::MAX - record.place.span().start));
    let others = places
        .iter()
        .skip(1)
        .map(|(key, record)| (*key, record.place.to_string()))
        .collect();
    let at = places[0].1.place.clone();
    Problem::Conflict { conflict, others }.at(at)
}

/// The fault of a sensor, reported at the key that was set last: in the file nearest to the design, and there furthest
/// down.
pub(crate) fn sensor(name: &str, problem: SensorProblem, records: &Records) -> DesignError {
    let at = last_set("sensors", name, problem.keys(), records);
    let name = name.to_owned();
    Problem::Sensor { name, problem }.at(at)
}

/// The fault in the place of a surface, reported at the key that was set last.
pub(crate) fn surface(name: &str, problem: SurfaceProblem, records: &Records) -> DesignError {
    let at = last_set("surfaces", name, problem.keys(), records);
    let name = name.to_owned();
    Problem::Surface { name, problem }.at(at)
}

/// The fault in the record of a surface, reported at the key at fault that was set last.
pub(crate) fn recorded_surface(name: &str, problem: RecordedSurfaceProblem, records: &Records) -> DesignError {
    let at = last_set("recorded_surfaces", name, &problem.keys(), records);
    let name = name.to_owned();
    Problem::RecordedSurface { name, problem }.at(at)
}

/// The error that a spring is not on its body, reported at the key of its place that was set last.
pub(crate) fn spring(name: &str, (body, point, distance): (Sprung, [f64; 3], f64), records: &Records) -> DesignError {
    let at = last_set("springs", name, &["x", "y", "z", "body"], records);
    Problem::Spring {
        name: name.to_owned(),
        body,
        point,
        distance,
    }
    .at(at)
}

/// The error that a stage needs more memory than allowed, reported at the key of its cost that was set last.
pub(crate) fn too_costly(
    (stage, needs, allowed): (&'static str, String, String),
    keys: &'static [(&'static str, &'static str)],
    records: &Records,
) -> DesignError {
    let set = keys.iter().filter_map(|(key, _)| records.get(*key));
    let last = set.min_by_key(|record| (record.depth, usize::MAX - record.place.span().start));
    Problem::TooCostly {
        stage,
        needs,
        allowed,
        keys,
    }
    .at(last.map(|record| record.place.clone()))
}

/// Place of the last key set of a list's member.
fn last_set(list: &str, name: &str, keys: &[&str], records: &Records) -> Option<Box<Place>> {
    let member = dotted(list, name);
    let set = keys.iter().filter_map(|key| records.get(&dotted(&member, key)));
    let last = set.min_by_key(|record| (record.depth, usize::MAX - record.place.span().start));
    last.map(|record| record.place.clone())
}

/// Warnings for values outside the range of their base, which determines the range of a value without one.
fn outside_range(values: &Values, records: &Records) -> Vec<Warning> {
    let mut warnings = Vec::new();
    values.visit("", &mut |key, spec, value| {
        let Some(Record {
            range_of_base: Some([low, high]),
            place,
            ..
        }) = records.get(key)
        else {
            return;
        };
        let value = match value {
            Value::Number(value) => value,
            Value::Count(count) => f64::from(count),
            Value::Switch(_) | Value::Choice(_) | Value::File(_) | Value::Name(_) => return,
        };
        if !includes([*low, *high], value) {
            let dimension = dimension(spec.kind);
            warnings.push(Warning::OutsideRange {
                key: key.to_owned(),
                value: show(value, dimension),
                low: show(*low, dimension),
                high: show(*high, dimension),
                at: place.clone(),
            });
        }
    });
    warnings
}

/// Warning for an exhaust computed to a lower frequency than the levels, at the key that is set in the nearest file.
fn exhaust_max_frequency(values: &Values, records: &Records) -> Option<Warning> {
    let (top, high) = (values.analysis.exhaust_max_frequency, values.analysis.range_high);
    if top >= high {
        return None;
    }
    let keys = ["analysis.exhaust_max_frequency", "analysis.range_high"];
    let set = keys.iter().filter_map(|key| records.get(*key));
    let nearest = set.min_by_key(|record| record.depth)?;
    Some(Warning::ExhaustTop {
        top,
        high,
        bands: [top, high].map(|hz| band_containing(hz).nominal_hz()),
        at: nearest.place.clone(),
    })
}

/// A value that a file gives for a derived quantity.
struct Agreeing {
    derived: &'static Derived,
    value: Measured,
    at: Box<Place>,
}

/// Checks that a given derived quantity agrees with the computed one; it has no further effect.
fn agree(given: Agreeing, values: &Values) -> Result<Warning, DesignError> {
    let Agreeing { derived, value, at } = given;
    let computed = (derived.value)(values);
    if (value.si - computed).abs() <= AGREEMENT * computed.abs() {
        return Ok(Warning::Computed {
            key: derived.key,
            primaries: derived.primaries.to_vec(),
            at,
        });
    }
    let mut primaries = Vec::new();
    values.visit("", &mut |key, spec, value| {
        if let Some(own) = derived.primaries.iter().find(|own| **own == key) {
            primaries.push((*own, shown(value, spec)));
        }
    });
    Err(Problem::Derived {
        key: derived.key,
        given: show(value.si, derived.dimension),
        value: show(computed, derived.dimension),
        primaries,
    }
    .at(at))
}

/// A value in a readable unit.
pub(crate) fn shown(value: Value, spec: &KeySpec) -> String {
    match value {
        Value::Number(value) => show(value, dimension(spec.kind)),
        Value::Count(count) => count.to_string(),
        Value::Switch(on) => on.to_string(),
        Value::Choice(word) => word.to_owned(),
        Value::File(path) => path,
        Value::Name(name) => name.0,
    }
}

/// Every primary quantity that a derived one names is a key.
#[test]
fn derived_quantities_name_keys() {
    let mut keys = Vec::new();
    Values::SPEC.each_key("", &mut |key, _| keys.push(key.to_owned()));
    for derived in super::derived::DERIVED {
        assert!(!keys.iter().any(|key| key == derived.key), "{} is a key", derived.key);
        for primary in derived.primaries {
            assert!(keys.iter().any(|key| key == primary), "{} names {primary}", derived.key);
        }
    }
}
