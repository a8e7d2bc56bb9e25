//! `[study]` of a design file: variables of a study in addition to the design's ranges, and the definition of shots
//! that count.
//!
//! ```toml
//! [study]
//! require = "drives"                        # an outcome of the tool, or a list of them
//! screening = 8                             # draws of `nailnoise run`
//! default_range = "+-10 %"                  # of values without a range; "base" or "exact" otherwise
//! draws = "calibrated.draws"                # joint draws of keys, in place of their ranges
//! [study.alternatives]
//! "support.worktable.preset" = { A = 0.5, B = 0.25, C = 0.25 }
//! exhaust = [ { holes = 5, hole_diameter = "5.97 mm" }, { holes = 1, hole_diameter = "13.35 mm" } ]
//! [study.model]
//! exhaust = "-4 .. 4 dB"                    # in place of the method's own band
//! [[study.correlation]]
//! keys = ["piston.mass", "piston.bore"]
//! rank = 0.8                                # Spearman's rank correlation
//! ```
//!
//! It changes neither a value of the design nor its digest.

use std::collections::BTreeMap;
use std::sync::Arc;

use nailnoise_quantities::dimension::NUMBER;
use nailnoise_quantities::{GroupSpec, KeySpec, Value, dotted, range};
use serde::Serialize;
use toml::Spanned;
use toml::de::{DeTable, DeValue};

use super::catalogue::Names;
use super::error::{DesignError, Problem};
use super::joint_draws::JointDraws;
use super::range::{DefaultRange, GivenRange};
use super::renamed::current;
use super::settings::{Field, Given};
use super::source::File;
use super::suggest;
use super::tool_outcomes::{OUTCOME, RequiredOutcome, ToolOutcomes};
use nailnoise_documents::Place;
use nailnoise_documents::{found, found_value, nearest};

/// Maximum number of draws in a screening; more would be a study.
const MOST_SCREENED: u32 = 8;

/// Maximum number of options of an alternative.
const MOST_OPTIONS: usize = 64;

/// Names of the sources for which a design may give the method's error, in the order of the program.
pub const SOURCES: [&str; 3] = ["workpiece", "exhaust", "body"];

/// Variables of a study in addition to the ranges of the design, and the definition of shots that count.
#[derive(Debug, Clone, Default, PartialEq, Serialize)]
pub struct StudySettings {
    /// A shot counts if it has one of these outcomes; all shots count if this is empty.
    pub require: Vec<String>,
    /// Draws of `nailnoise run` for a design without a study.
    pub screening: u32,
    /// Choices between sets of values, by name.
    pub alternatives: BTreeMap<String, Vec<Alternative>>,
    /// Bounds of the method's error for a source \[dB\], which replace the default.
    pub model: BTreeMap<&'static str, [f64; 2]>,
    /// Rank correlations between drawn quantities.
    pub correlations: Vec<Correlation>,
    /// Joint draws of keys, which take the place of their ranges.
    #[serde(skip)]
    pub draws: Option<Arc<JointDraws>>,
}

/// One of several sets of values.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Alternative {
    /// Its name.
    pub name: String,
    /// Its probability \[-\]; those of all options sum to 1.
    pub probability: f64,
    /// Keys and values, quantities in SI units.
    pub values: Vec<(String, Value)>,
}

/// Quantities that are drawn with the same rank correlation.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Correlation {
    /// Full names of the keys.
    pub keys: Vec<String>,
    /// Spearman's rank correlation of each pair \[-\].
    pub rank: f64,
}

/// A group of quantities that are correlated, with its place in the file.
type Placed<T> = (T, Box<Place>);

/// Settings of one file in `[study]`.
#[derive(Debug, Default)]
pub(crate) struct StudyLayer {
    /// Number of files between the design and this one.
    depth: usize,
    require: Option<Vec<RequiredOutcome>>,
    screening: Option<u32>,
    default_range: Option<DefaultRange>,
    draws: Option<Arc<JointDraws>>,
    alternatives: BTreeMap<String, Vec<DraftOption>>,
    model: BTreeMap<&'static str, [f64; 2]>,
    correlations: Option<Vec<Placed<Correlation>>>,
}

/// An option before gauge pressures are made absolute and weights are converted to probabilities.
#[derive(Debug)]
struct DraftOption {
    name: String,
    weight: f64,
    values: Vec<(String, Given)>,
}

impl StudyLayer {
    /// Reads `[study]` of a file, if present, by the declaration `root` of the design's keys. `depth` is the number of
    /// files between the design and this one.
    pub(crate) fn of(
        file: &File,
        table: &DeTable<'_>,
        root: &'static GroupSpec,
        depth: usize,
    ) -> Result<Option<Self>, DesignError> {
        let reader = Reader { file, root };
        let layer = table.get("study").map(|value| Self::read(&reader, value)).transpose()?;
        Ok(layer.map(|layer| Self { depth, ..layer }))
    }

    fn read(reader: &Reader<'_>, value: &Spanned<DeValue<'_>>) -> Result<Self, DesignError> {
        let mut layer = Self::default();
        for (key, value) in reader.table("study", value)? {
            match key.get_ref().as_ref() {
                "require" => layer.require = Some(reader.outcomes(value)?),
                "screening" => layer.screening = Some(reader.screening(value)?),
                "default_range" => layer.default_range = Some(reader.default_range(value)?),
                "draws" => layer.draws = Some(reader.draws(value)?),
                "alternatives" => {
                    for (key, value) in reader.table("study.alternatives", value)? {
                        let name = current(key.get_ref());
                        let options = reader.alternatives(name, key, value)?;
                        layer.alternatives.insert(name.to_owned(), options);
                    }
                }
                "model" => {
                    for (key, value) in reader.table("study.model", value)? {
                        let name = key.get_ref().as_ref();
                        let Some(source) = SOURCES.into_iter().find(|source| *source == name) else {
                            return Err(reader.unknown("study.model", key, &SOURCES));
                        };
                        layer.model.insert(source, reader.decibels(source, value)?);
                    }
                }
                "correlation" => layer.correlations = Some(reader.correlations(value)?),
                _ => {
                    let known = [
                        "require",
                        "screening",
                        "default_range",
                        "draws",
                        "alternatives",
                        "model",
                        "correlation",
                    ];
                    return Err(reader.unknown("study", key, &known));
                }
            }
        }
        Ok(layer)
    }
}

/// The default range of values without one, from the nearest file that states it.
pub(crate) fn default_range(layers: &[StudyLayer]) -> DefaultRange {
    layers
        .iter()
        .rev()
        .find_map(|layer| layer.default_range)
        .unwrap_or_default()
}

/// Joins the settings of the files, nearest last. `names` are the names of wood and nail, `ranged` tests whether a key
/// has a range, `ambient` is the reference for gauge pressures \[Pa\], and `outcomes` are those of the tool.
pub(crate) fn joined(
    layers: Vec<StudyLayer>,
    names: &Names,
    ranged: impl Fn(&str) -> bool,
    ambient: f64,
    outcomes: &ToolOutcomes,
) -> Result<StudySettings, DesignError> {
    let mut settings = StudySettings {
        screening: MOST_SCREENED,
        ..StudySettings::default()
    };
    let mut correlations = Vec::new();
    for layer in layers {
        if let Some(require) = layer.require {
            settings.require = outcomes.checked(layer.depth, require)?;
        }
        settings.screening = layer.screening.unwrap_or(settings.screening);
        settings.draws = layer.draws.or(settings.draws);
        for (name, options) in layer.alternatives {
            let sum: f64 = options.iter().map(|option| option.weight).sum();
            let absolute = |(key, given)| match given {
                Given::Quantity(measured) => (key, Value::Number(measured.absolute(ambient))),
                Given::Other(value) => (key, value),
            };
            let option = |option: DraftOption| {
                let own: Vec<(String, Value)> = option.values.into_iter().map(absolute).collect();
                Ok(Alternative {
                    name: option.name,
                    probability: option.weight / sum,
                    values: names.with_values(own)?,
                })
            };
            let options = options.into_iter().map(option).collect::<Result<_, DesignError>>()?;
            settings.alternatives.insert(name, options);
        }
        settings.model.extend(layer.model);
        correlations = layer.correlations.unwrap_or(correlations);
    }
    let mut seen: Vec<String> = Vec::new();
    for (correlation, at) in &correlations {
        for key in &correlation.keys {
            let expected = if !ranged(key) {
                "as quantities with a range"
            } else if seen.contains(key) {
                "each in one correlation only"
            } else {
                seen.push(key.clone());
                continue;
            };
            return Err(Problem::WrongKind {
                key: "study.correlation.keys".to_owned(),
                found: format!("`{key}`"),
                expected: expected.to_owned(),
            }
            .at(at.clone()));
        }
    }
    settings.correlations = correlations.into_iter().map(|(correlation, _)| correlation).collect();
    Ok(settings)
}

struct Reader<'a> {
    file: &'a File,
    root: &'static GroupSpec,
}

impl Reader<'_> {
    fn wrong(&self, key: &str, value: &Spanned<DeValue<'_>>, expected: &str) -> DesignError {
        Problem::WrongKind {
            key: key.to_owned(),
            found: found(value.get_ref()),
            expected: expected.to_owned(),
        }
        .at(self.file.place(value.span()))
    }

    fn unknown(&self, group: &str, key: &Spanned<std::borrow::Cow<'_, str>>, known: &[&str]) -> DesignError {
        let name = key.get_ref().as_ref();
        Problem::UnknownKey {
            key: format!("{group}.{name}"),
            nearest: nearest(known.iter().copied(), name).map(|near| dotted(group, near)),
            known: known.iter().map(|known| (*known).to_owned()).collect(),
        }
        .at(self.file.place(key.span()))
    }

    fn table<'t, 'i>(&self, key: &str, value: &'t Spanned<DeValue<'i>>) -> Result<&'t DeTable<'i>, DesignError> {
        let table = value.get_ref().as_table();
        table.ok_or_else(|| self.wrong(key, value, &format!("as a group of keys: [{key}]")))
    }

    fn outcomes(&self, value: &Spanned<DeValue<'_>>) -> Result<Vec<RequiredOutcome>, DesignError> {
        let one = |value: &Spanned<DeValue<'_>>| {
            let word = value.get_ref().as_str();
            let word = word.ok_or_else(|| self.wrong("study.require", value, OUTCOME))?;
            Ok(RequiredOutcome {
                word: word.to_owned(),
                found: found(value.get_ref()),
                at: self.file.place(value.span()),
            })
        };
        match value.get_ref() {
            DeValue::Array(list) => list.iter().map(one).collect(),
            _ => Ok(vec![one(value)?]),
        }
    }

    fn screening(&self, value: &Spanned<DeValue<'_>>) -> Result<u32, DesignError> {
        let count = match value.get_ref() {
            DeValue::Integer(integer) => u32::from_str_radix(integer.as_str(), integer.radix()).ok(),
            _ => None,
        };
        count.filter(|count| *count <= MOST_SCREENED).ok_or_else(|| {
            let expected = format!("as a whole number from 0 to {MOST_SCREENED}; `nailnoise study` makes more draws");
            self.wrong("study.screening", value, &expected)
        })
    }

    fn default_range(&self, value: &Spanned<DeValue<'_>>) -> Result<DefaultRange, DesignError> {
        let word = value.get_ref().as_str().unwrap_or_default();
        match GivenRange::parse(word, NUMBER, false) {
            _ if word.trim() == "base" => Ok(DefaultRange::Base),
            Ok(own @ (GivenRange::Exact | GivenRange::Relative(_))) => Ok(DefaultRange::Own(own)),
            _ => Err(self.wrong("study.default_range", value, "as \"base\", \"exact\" or \"+-10 %\"")),
        }
    }

    fn draws(&self, value: &Spanned<DeValue<'_>>) -> Result<Arc<JointDraws>, DesignError> {
        let expected = "as the name of a file that `nailnoise calibrate` wrote, beside this design";
        let name = value.get_ref().as_str();
        let name = name.ok_or_else(|| self.wrong("study.draws", value, expected))?;
        let read = JointDraws::read(&self.file.document().sibling(name));
        read.map(Arc::new).map_err(|cause| {
            Problem::WrongKind {
                key: "study.draws".to_owned(),
                found: format!("\"{name}\", which cannot be read ({cause})"),
                expected: expected.to_owned(),
            }
            .at(self.file.place(value.span()))
        })
    }

    /// A positive number, or a number in (-1, 1).
    fn number(&self, key: &str, value: &Spanned<DeValue<'_>>, weight: bool) -> Result<f64, DesignError> {
        let number = match value.get_ref() {
            DeValue::Float(float) => float.as_str().parse().ok(),
            DeValue::Integer(integer) => integer.as_str().parse().ok(),
            _ => None,
        };
        let allowed = |number: &f64| {
            number.is_finite()
                && if weight {
                    (0.0..=1e9).contains(number) && *number > 0.0
                } else {
                    number.abs() < 1.0
                }
        };
        let expected = if weight {
            "as a weight, a number above 0"
        } else {
            "as a number between -1 and 1"
        };
        number.filter(allowed).ok_or_else(|| self.wrong(key, value, expected))
    }

    fn decibels(&self, source: &str, value: &Spanned<DeValue<'_>>) -> Result<[f64; 2], DesignError> {
        let text = value.get_ref().as_str().and_then(|text| text.trim().strip_suffix("dB"));
        let ends = text.and_then(|text| range(text, NUMBER, false).ok());
        let ends = ends
            .map(|ends| ends.map(|end| end.si))
            .filter(|[low, high]| low <= high);
        ends.ok_or_else(|| self.wrong(&dotted("study.model", source), value, "as \"low .. high dB\""))
    }

    /// The declaration of a key or a group by its full name.
    fn find(&self, name: &str) -> Option<Result<&'static KeySpec, &'static GroupSpec>> {
        let mut group: &'static GroupSpec = self.root;
        let mut parts = name.split('.').peekable();
        while let Some(part) = parts.next() {
            match group.group(part) {
                Some(inner) => group = inner,
                None if parts.peek().is_none() => return group.key(part).map(Ok),
                None => return None,
            }
        }
        Some(Err(group))
    }

    fn alternatives(
        &self,
        name: &str,
        key: &Spanned<std::borrow::Cow<'_, str>>,
        value: &Spanned<DeValue<'_>>,
    ) -> Result<Vec<DraftOption>, DesignError> {
        let full = dotted("study.alternatives", name);
        let options = match (self.find(name), value.get_ref()) {
            (Some(Ok(spec)), DeValue::Table(table)) => {
                let option = |(word, weight): (&Spanned<std::borrow::Cow<'_, str>>, &Spanned<DeValue<'_>>)| {
                    let text = Spanned::new(word.span(), DeValue::String(word.get_ref().as_ref().into()));
                    let field = Field {
                        file: self.file,
                        key: name,
                    };
                    let (given, ..) = field.value(&text, spec)?;
                    Ok(DraftOption {
                        name: word.get_ref().to_string(),
                        weight: self.number(&full, weight, true)?,
                        values: vec![(name.to_owned(), given)],
                    })
                };
                table.iter().map(option).collect::<Result<Vec<_>, DesignError>>()?
            }
            (Some(Err(group)), DeValue::Array(list)) => {
                let options = list.iter().enumerate();
                options
                    .map(|(index, value)| self.option(name, group, index, value))
                    .collect::<Result<_, _>>()?
            }
            (Some(Ok(_)), _) => return Err(self.wrong(&full, value, "as values with weights: { A = 0.5, B = 0.5 }")),
            (Some(Err(_)), _) => {
                return Err(self.wrong(
                    &full,
                    value,
                    "as a list of groups of keys: [{ holes = 5 }, { holes = 1 }]",
                ));
            }
            (None, _) => {
                return Err(Problem::UnknownKey {
                    key: full,
                    nearest: suggest::key(self.root, name),
                    known: vec!["the full name of a key or group, in quotes".to_owned()],
                }
                .at(self.file.place(key.span())));
            }
        };
        if options.is_empty() || options.len() > MOST_OPTIONS {
            return Err(self.wrong(&full, value, &format!("with 1 to {MOST_OPTIONS} options")));
        }
        Ok(options)
    }

    /// An option of a group: its keys, and `weight`, with the default 1.
    fn option(
        &self,
        name: &str,
        group: &'static GroupSpec,
        index: usize,
        value: &Spanned<DeValue<'_>>,
    ) -> Result<DraftOption, DesignError> {
        let full = dotted("study.alternatives", name);
        let mut option = DraftOption {
            name: String::new(),
            weight: 1.0,
            values: Vec::new(),
        };
        let mut words = Vec::new();
        for (key, value) in self.table(&full, value)? {
            let word = key.get_ref().as_ref();
            if word == "weight" {
                option.weight = self.number(&full, value, true)?;
                continue;
            }
            let own = current(&dotted(name, word)).to_owned();
            let word = own.rsplit('.').next().unwrap_or(word);
            let Some(spec) = group.key(word) else {
                let known: Vec<&str> = group.keys().map(|key| key.name).chain(["weight"]).collect();
                return Err(self.unknown(&full, key, &known));
            };
            let (given, ..) = (Field {
                file: self.file,
                key: &own,
            })
            .value(value, spec)?;
            words.push(format!("{word} {}", found_value(value.get_ref()).trim_matches('"')));
            option.values.push((own, given));
        }
        option.name = if words.is_empty() {
            format!("option {}", index + 1)
        } else {
            words.join(", ")
        };
        Ok(option)
    }

    fn correlations(&self, value: &Spanned<DeValue<'_>>) -> Result<Vec<Placed<Correlation>>, DesignError> {
        let expected = "as tables: [[study.correlation]] with keys = [...] and rank = 0.5";
        let DeValue::Array(list) = value.get_ref() else {
            return Err(self.wrong("study.correlation", value, expected));
        };
        let one = |value: &Spanned<DeValue<'_>>| {
            let (mut keys, mut rank) = (Vec::new(), None);
            for (key, value) in self.table("study.correlation", value)? {
                match (key.get_ref().as_ref(), value.get_ref()) {
                    ("keys", DeValue::Array(list)) => {
                        let name = |value: &Spanned<DeValue<'_>>| Some(current(value.get_ref().as_str()?).to_owned());
                        let names: Option<Vec<String>> = list.iter().map(name).collect();
                        keys = names.ok_or_else(|| self.wrong("study.correlation.keys", value, "as a list of keys"))?;
                    }
                    ("keys", _) => return Err(self.wrong("study.correlation.keys", value, "as a list of keys")),
                    ("rank", _) => rank = Some(self.number("study.correlation.rank", value, false)?),
                    _ => return Err(self.unknown("study.correlation", key, &["keys", "rank"])),
                }
            }
            // The copula's matrix with the same correlation in all off-diagonal elements is positive definite above
            // -1/(k - 1).
            let pearson = |rank: f64| 2.0 * (std::f64::consts::PI * rank / 6.0).sin();
            match rank {
                Some(rank) if keys.len() >= 2 && 1.0 + (keys.len() - 1) as f64 * pearson(rank) > 0.0 => {
                    Ok((Correlation { keys, rank }, self.file.place(value.span())))
                }
                Some(_) if keys.len() >= 2 => Err(self.wrong(
                    "study.correlation.rank",
                    value,
                    "higher: so many quantities cannot all be against each other so strongly",
                )),
                _ => Err(self.wrong("study.correlation", value, "with two or more keys and a rank")),
            }
        };
        list.iter().map(one).collect()
    }
}
