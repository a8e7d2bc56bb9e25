//! The statements of one file about a key: value, range, provenance and note, each with its place.

use std::borrow::Cow;
use std::ops::Range;

use nailnoise_quantities::dimension::NUMBER;
use nailnoise_quantities::{
    self as quantities, Dimension, GroupSpec, KeySpec, Kind, Measured, Name, QuantityError, Value, dotted,
};
use toml::Spanned;
use toml::de::{DeArray, DeTable, DeValue};

use super::assembly::AssemblyKeys;
use super::derived::{Derived, SOLUTIONS, Solution};
use super::distribution::Distribution;
use super::error::{DesignError, Problem};
use super::provenance::Provenance;
use super::range::GivenRange;
use super::renamed::{current, successors};
use super::source::File;
use super::suggest;
use nailnoise_documents::Place;
use nailnoise_documents::{found, found_value, nearest};

/// A value as given, before gauge pressures are made absolute.
#[derive(Debug, Clone)]
pub(crate) enum Given {
    Quantity(Measured),
    Other(Value),
}

/// The statements of one file about a key.
#[derive(Debug)]
pub(crate) struct Setting {
    pub(crate) key: String,
    pub(crate) spec: &'static KeySpec,
    pub(crate) value: Option<(Given, String, Box<Place>)>,
    pub(crate) range: Option<(GivenRange, Box<Place>)>,
    pub(crate) distribution: Option<(Distribution, Box<Place>)>,
    pub(crate) provenance: Option<(Provenance, String)>,
    pub(crate) note: Option<String>,
}

impl Setting {
    fn nothing(key: String, spec: &'static KeySpec) -> Self {
        Self {
            key,
            spec,
            value: None,
            range: None,
            distribution: None,
            provenance: None,
            note: None,
        }
    }
}

/// The statements of one file about a derived quantity: a value that it must match, a value that determines a primary
/// quantity, or a range for the draws of a study.
#[derive(Debug)]
pub(crate) struct GivenDerived {
    pub(crate) derived: &'static Derived,
    pub(crate) value: Option<(Measured, Box<Place>)>,
    pub(crate) range: Option<(GivenRange, Box<Place>)>,
    pub(crate) distribution: Option<(Distribution, Box<Place>)>,
    pub(crate) provenance: Option<(Provenance, String)>,
    pub(crate) note: Option<String>,
    /// The primary quantity that follows.
    pub(crate) follows: Option<(String, Box<Place>)>,
}

impl GivenDerived {
    /// The solution by which a quantity follows from the statement `found` at this place.
    ///
    /// # Errors
    /// If there is none.
    pub(super) fn solution(&self, found: &str, at: &Place) -> Result<&'static Solution, DesignError> {
        let key = self.derived.key;
        let is_meant = |own: &&Solution| {
            let last = own.follower.rsplit('.').next();
            let named = |word: &str| own.follower == word || last == Some(word);
            self.follows.as_ref().is_none_or(|(word, _)| named(word))
        };
        let own = SOLUTIONS.iter().filter(|own| own.key == key);
        if let Some(solution) = own.clone().find(is_meant) {
            return Ok(solution);
        }
        let known: Vec<String> = own.map(|own| format!("\"{}\"", own.follower)).collect();
        let (found, expected) = match &self.follows {
            Some((word, _)) if !known.is_empty() => {
                (format!("the text \"{word}\""), format!("as {}", known.join(" or ")))
            }
            _ => (
                found.to_owned(),
                format!("without {found}: no quantity follows from it"),
            ),
        };
        let at = self.follows.as_ref().map_or(at, |(_, at)| at).clone();
        let key = key.to_owned();
        Err(Problem::WrongKind { key, found, expected }.at(Box::new(at)))
    }
}

/// All statements of one file.
#[derive(Debug, Default)]
pub(crate) struct Layer {
    pub(crate) settings: Vec<Setting>,
    pub(crate) derived: Vec<GivenDerived>,
}

impl Layer {
    /// Reads the `table` of a `file` by the declaration `root`, except the keys of its assembly.
    pub(crate) fn read(
        file: &File,
        table: &DeTable<'_>,
        root: &'static GroupSpec,
        own: &AssemblyKeys,
    ) -> Result<Self, DesignError> {
        let mut layer = Self::default();
        Reader { file, root, own }.group(table, root, "", &mut layer)?;
        Ok(layer)
    }
}

/// Maximum number of members in a list of a design; every sensor stores the signals of a complete shot.
const MOST_MEMBERS: usize = 250;

/// Keys whose values are names, with the list in which `nailnoise list` prints them.
const NAMED: &[(&str, &str)] = &[
    ("wood.species", "woods"),
    ("nail.kind", "nails"),
    ("support.worktable.preset", "tables"),
];

struct Reader<'a> {
    file: &'a File,
    root: &'static GroupSpec,
    own: &'a AssemblyKeys,
}

impl Reader<'_> {
    fn group(
        &self,
        table: &DeTable<'_>,
        spec: &'static GroupSpec,
        path: &str,
        layer: &mut Layer,
    ) -> Result<(), DesignError> {
        for (key, value) in table {
            let name = key.get_ref().as_ref();
            let full = current(&dotted(path, name)).to_owned();
            let name = full.rsplit('.').next().unwrap_or(name);
            // Read elsewhere; none contains a quantity of the tool.
            if path.is_empty() && matches!(name, "base" | "study" | "report") {
                continue;
            }
            if let Some(spec) = spec.key(name) {
                layer.settings.push(self.setting(full, spec, value)?);
            } else if let Some(inner) = spec.group(name).filter(|inner| inner.is_list && gives_list(value)) {
                self.list(&full, inner, value, layer)?;
            } else if let Some(inner) = spec.group(name) {
                self.group(self.table(&full, key.span(), value)?, inner, &full, layer)?;
            } else if let Some(member) = spec.list(name) {
                let table = self.table(&full, key.span(), value)?;
                if table.len() > MOST_MEMBERS {
                    return Err(Problem::OutsideLimits {
                        key: full,
                        found: format!("a list of {}", table.len()),
                        allowed: format!("a list of {MOST_MEMBERS} at most"),
                    }
                    .at(self.file.place(key.span())));
                }
                for (key, value) in table {
                    let name = key.get_ref().as_ref();
                    let full = dotted(&full, name);
                    if name.is_empty() || !name.chars().all(|c| c.is_ascii_alphanumeric() || c == '_' || c == '-') {
                        let (name, at) = (name.to_owned(), self.file.place(key.span()));
                        return Err(Problem::BadName { name }.at(at));
                    }
                    self.group(self.table(&full, key.span(), value)?, member, &full, layer)?;
                }
            } else if self.own.covers(&full) {
                // Read with the assembly, which may declare a key with the name of a derived quantity.
                self.check_declared(&full, key.span(), value)?;
            } else if let Some(derived) = Derived::find(&full) {
                layer.derived.push(self.derived(derived, value)?);
            } else if let Some(successors) = successors(&full) {
                let at = self.file.place(key.span());
                return Err(Problem::Replaced { key: full, successors }.at(at));
            } else {
                return Err(self.unknown(full, spec, key.span(), value));
            }
        }
        Ok(())
    }

    /// Checks that a group of an assembly contains only keys that it declares.
    fn check_declared(&self, full: &str, span: Range<usize>, value: &Spanned<DeValue<'_>>) -> Result<(), DesignError> {
        if !self.own.covers(full) {
            return Err(self.own.undeclared(full, self.file.place(span)));
        }
        match value.get_ref() {
            DeValue::Table(table) if self.own.is_group(full) => table
                .iter()
                .try_for_each(|(key, value)| self.check_declared(&dotted(full, key.get_ref()), key.span(), value)),
            _ => Ok(()),
        }
    }

    fn table<'t, 'i>(
        &self,
        full: &str,
        span: Range<usize>,
        value: &'t Spanned<DeValue<'i>>,
    ) -> Result<&'t DeTable<'i>, DesignError> {
        match value.get_ref() {
            DeValue::Table(table) => Ok(table),
            other => Err(Problem::WrongKind {
                key: full.to_owned(),
                found: found(other),
                expected: format!("as a group of keys: [{full}]"),
            }
            .at(self.file.place(span))),
        }
    }

    fn unknown(&self, full: String, spec: &GroupSpec, span: Range<usize>, value: &Spanned<DeValue<'_>>) -> DesignError {
        let at = self.file.place(span);
        // A table may be a misspelt group, or a misspelt key with range and provenance.
        let inner = value.get_ref().as_table();
        if inner.is_some_and(|table| !table.contains_key("value")) {
            let nearest = suggest::group(self.root, &full);
            let known = spec
                .groups
                .iter()
                .map(|(name, _)| (*name).to_owned())
                .collect::<Vec<_>>();
            if nearest.is_some() || !known.is_empty() {
                return Problem::UnknownGroup {
                    group: full,
                    nearest,
                    known,
                }
                .at(at);
            }
        }
        let nearest = suggest::key(self.root, &full);
        let keys = spec.keys().map(|key| key.name);
        let known = keys
            .chain(spec.groups.iter().map(|(name, _)| *name))
            .map(str::to_owned)
            .collect();
        Problem::UnknownKey {
            key: full,
            nearest,
            known,
        }
        .at(at)
    }

    fn derived(&self, derived: &'static Derived, value: &Spanned<DeValue<'_>>) -> Result<GivenDerived, DesignError> {
        let field = Field {
            file: self.file,
            key: derived.key,
        };
        let mut given = GivenDerived {
            derived,
            value: None,
            range: None,
            distribution: None,
            provenance: None,
            note: None,
            follows: None,
        };
        let number = |value: &Spanned<DeValue<'_>>| {
            let measured = field.measured(value, derived.dimension, false)?;
            Ok(Some((measured, self.file.place(value.span()))))
        };
        let DeValue::Table(table) = value.get_ref() else {
            given.value = number(value)?;
            return Ok(given);
        };
        for (name, value) in table {
            match name.get_ref().as_ref() {
                "value" => given.value = number(value)?,
                "range" => given.range = Some(field.range_of(value, derived.dimension, false)?),
                "distribution" => given.distribution = Some(field.distribution_of(value)?),
                "provenance" => given.provenance = Some(field.provenance(value)?),
                "note" => given.note = Some(field.text(value, "note")?),
                "follows" => given.follows = Some((field.text(value, "follows")?, self.file.place(value.span()))),
                other => {
                    let known = ["value", "range", "distribution", "provenance", "note", "follows"];
                    let known = known.map(str::to_owned).to_vec();
                    return Err(Problem::UnknownKey {
                        key: dotted(derived.key, other),
                        nearest: nearest(known.iter().map(String::as_str), other).map(|near| dotted(derived.key, near)),
                        known,
                    }
                    .at(self.file.place(name.span())));
                }
            }
        }
        Ok(given)
    }

    fn setting(
        &self,
        key: String,
        spec: &'static KeySpec,
        value: &Spanned<DeValue<'_>>,
    ) -> Result<Setting, DesignError> {
        let field = Field {
            file: self.file,
            key: &key,
        };
        let mut setting = Setting::nothing(key.clone(), spec);
        let DeValue::Table(table) = value.get_ref() else {
            setting.value = Some(field.value(value, spec)?);
            return Ok(setting);
        };
        for (name, value) in table {
            field.take(&mut setting, name, value)?;
        }
        Ok(setting)
    }

    /// The keys of a group given as a list with one value per key; a range may be such a list, too.
    fn list(
        &self,
        group: &str,
        spec: &'static GroupSpec,
        value: &Spanned<DeValue<'_>>,
        layer: &mut Layer,
    ) -> Result<(), DesignError> {
        let keys: Vec<&'static KeySpec> = spec.keys().collect();
        for (place, key) in keys.iter().enumerate() {
            let full = dotted(group, key.name);
            let field = Field {
                file: self.file,
                key: &full,
            };
            let mut setting = Setting::nothing(full.clone(), key);
            match value.get_ref() {
                DeValue::Table(table) => {
                    for (name, value) in table {
                        field.take(&mut setting, name, self.element(group, value, place, keys.len())?)?;
                    }
                }
                _ => setting.value = Some(field.value(self.element(group, value, place, keys.len())?, key)?),
            }
            layer.settings.push(setting);
        }
        Ok(())
    }

    /// The element at `place` of a list with `count` values given for `group`; a single value applies to every element.
    fn element<'t, 'i>(
        &self,
        group: &str,
        value: &'t Spanned<DeValue<'i>>,
        place: usize,
        count: usize,
    ) -> Result<&'t Spanned<DeValue<'i>>, DesignError> {
        let Some(list) = value.get_ref().as_array() else {
            return Ok(value);
        };
        let whole = list.get(place).filter(|_| list.len() == count);
        whole.ok_or_else(|| {
            let problem = Problem::WrongKind {
                key: group.to_owned(),
                found: format!("a list of {}", list.len()),
                expected: format!("as a list of {count} values"),
            };
            problem.at(self.file.place(value.span()))
        })
    }
}

/// Whether a value is a list, or a list with a range and a provenance.
fn gives_list(value: &Spanned<DeValue<'_>>) -> bool {
    match value.get_ref() {
        DeValue::Table(table) => table.get("value").is_some_and(|value| value.get_ref().is_array()),
        value => value.is_array(),
    }
}

/// Reads the entries of one key.
pub(super) struct Field<'a> {
    pub(super) file: &'a File,
    pub(super) key: &'a str,
}

impl Field<'_> {
    /// Takes the entry with one name.
    fn take(
        &self,
        setting: &mut Setting,
        name: &Spanned<Cow<'_, str>>,
        value: &Spanned<DeValue<'_>>,
    ) -> Result<(), DesignError> {
        match name.get_ref().as_ref() {
            "value" => setting.value = Some(self.value(value, setting.spec)?),
            "range" => setting.range = Some(self.range(value, setting.spec)?),
            "distribution" => setting.distribution = Some(self.distribution(value, setting.spec)?),
            "provenance" => setting.provenance = Some(self.provenance(value)?),
            "note" => setting.note = Some(self.text(value, "note")?),
            other => {
                let known = ["value", "range", "distribution", "provenance", "note"];
                let known = known.map(str::to_owned).to_vec();
                return Err(Problem::UnknownKey {
                    key: dotted(self.key, other),
                    nearest: nearest(known.iter().map(String::as_str), other).map(|near| dotted(self.key, near)),
                    known,
                }
                .at(self.file.place(name.span())));
            }
        }
        Ok(())
    }

    pub(super) fn value(
        &self,
        value: &Spanned<DeValue<'_>>,
        spec: &KeySpec,
    ) -> Result<(Given, String, Box<Place>), DesignError> {
        let at = self.file.place(value.span());
        let text = found_value(value.get_ref());
        let outside = || {
            Problem::OutsideLimits {
                key: self.key.to_owned(),
                found: text.clone(),
                allowed: spec.kind.allowed(),
            }
            .at(at.clone())
        };
        let given = match (spec.kind, value.get_ref()) {
            (Kind::Quantity { dimension, gauge, .. }, _) => {
                let measured = self.measured(value, dimension, gauge)?;
                // A gauge pressure may be negative; its limits are those of the absolute pressure.
                if !measured.gauge && !spec.kind.allows(measured.si) {
                    return Err(outside());
                }
                Given::Quantity(measured)
            }
            (Kind::Count(_), DeValue::Integer(integer)) => {
                let count = i64::from_str_radix(integer.as_str(), integer.radix()).ok();
                let count = count
                    .and_then(|count| u32::try_from(count).ok())
                    .filter(|count| spec.kind.allows(f64::from(*count)));
                Given::Other(Value::Count(count.ok_or_else(outside)?))
            }
            (Kind::Switch, DeValue::Boolean(on)) => Given::Other(Value::Switch(*on)),
            (Kind::Choice(words), DeValue::String(word)) => match words.iter().find(|own| **own == word.as_ref()) {
                Some(word) => Given::Other(Value::Choice(word)),
                None => return Err(self.unknown_word(value, word, words)),
            },
            (Kind::File, DeValue::String(name)) if name.is_empty() => Given::Other(Value::File(String::new())),
            (Kind::File, DeValue::String(name)) => {
                let path = self.file.beside(name);
                let reason = match std::fs::metadata(&path) {
                    Ok(data) if data.is_file() => None,
                    Ok(_) => Some("it is not a regular file".to_owned()),
                    Err(source) => Some(source.to_string()),
                };
                if let Some(reason) = reason {
                    return Err(Problem::NoFile {
                        key: self.key.to_owned(),
                        path,
                        reason,
                    }
                    .at(at));
                }
                Given::Other(Value::File(path.to_string_lossy().into_owned()))
            }
            (Kind::Name, DeValue::String(name)) => Given::Other(Value::Name(Name(name.to_string()))),
            (Kind::Name, _) => return Err(self.wrong_kind(value, "as a name in quotes".to_owned())),
            (Kind::File, _) => return Err(self.wrong_kind(value, "as the name of a file in quotes".to_owned())),
            (Kind::Count(_), _) => return Err(self.wrong_kind(value, "as a whole number".to_owned())),
            (Kind::Switch, _) => return Err(self.wrong_kind(value, "as true or false, without quotes".to_owned())),
            (Kind::Choice(words), _) => return Err(self.wrong_kind(value, one_of(words))),
        };
        Ok((given, text, at))
    }

    fn unknown_word(&self, value: &Spanned<DeValue<'_>>, word: &str, words: &[&str]) -> DesignError {
        let Some((_, list)) = NAMED.iter().find(|(key, _)| *key == self.key) else {
            return self.wrong_kind(value, one_of(words));
        };
        let plain = |word: &str| word.to_lowercase().replace(['-', '_', ' '], "");
        let same = words.iter().copied().find(|own| plain(own) == plain(word));
        let nearest = same.or_else(|| {
            let lower: Vec<String> = words.iter().map(|own| own.to_lowercase()).collect();
            let near = nearest(lower.iter().map(String::as_str), word)?;
            words.iter().copied().find(|own| own.to_lowercase() == near)
        });
        Problem::UnknownName {
            key: self.key.to_owned(),
            found: word.to_owned(),
            nearest: nearest.map(str::to_owned),
            list,
        }
        .at(self.file.place(value.span()))
    }

    fn measured(
        &self,
        value: &Spanned<DeValue<'_>>,
        dimension: Dimension,
        gauge: bool,
    ) -> Result<Measured, DesignError> {
        let si = match value.get_ref() {
            DeValue::String(text) => {
                return quantities::quantity(text, dimension, gauge)
                    .map_err(|error| self.quantity(error, text, dimension, value.span()));
            }
            DeValue::Float(float) => float.as_str().parse().unwrap_or(f64::NAN),
            // Hexadecimal and similar integers are certainly integers, but not a way to write a quantity.
            DeValue::Integer(integer) if integer.radix() == 10 => integer.as_str().parse().unwrap_or(f64::NAN),
            _ => {
                let examples = dimension.examples();
                return Err(self.wrong_kind(
                    value,
                    format!("as {dimension}: a number in SI, or a text with a unit ({examples})"),
                ));
            }
        };
        if si.is_finite() {
            return Ok(Measured { si, gauge: false });
        }
        let (found, at) = (found_value(value.get_ref()), self.file.place(value.span()));
        Err(Problem::NotFinite {
            key: self.key.to_owned(),
            found,
        }
        .at(at))
    }

    fn range(&self, value: &Spanned<DeValue<'_>>, spec: &KeySpec) -> Result<(GivenRange, Box<Place>), DesignError> {
        match spec.kind {
            Kind::Quantity { dimension, gauge, .. } => self.range_of(value, dimension, gauge),
            Kind::Count(_) => self.range_of(value, NUMBER, false),
            Kind::Switch | Kind::Choice(_) | Kind::File | Kind::Name => {
                Err(self.wrong_kind(value, "without a range: it is not a quantity".to_owned()))
            }
        }
    }

    /// A range of this dimension: two ends, a width around the value, or none.
    pub(super) fn range_of(
        &self,
        value: &Spanned<DeValue<'_>>,
        dimension: Dimension,
        gauge: bool,
    ) -> Result<(GivenRange, Box<Place>), DesignError> {
        let range = match value.get_ref() {
            DeValue::String(text) => GivenRange::parse(text, dimension, gauge)
                .map_err(|error| self.quantity(error, text, dimension, value.span()))?,
            DeValue::Array(ends) => GivenRange::Ends(self.ends(ends, value, dimension, gauge)?),
            _ => return Err(self.wrong_kind(value, RANGE.to_owned())),
        };
        Ok((range, self.file.place(value.span())))
    }

    fn ends(
        &self,
        ends: &DeArray<'_>,
        value: &Spanned<DeValue<'_>>,
        dimension: Dimension,
        gauge: bool,
    ) -> Result<[Measured; 2], DesignError> {
        let mut ends = ends.iter();
        match (ends.next(), ends.next(), ends.next()) {
            (Some(low), Some(high), None) => Ok([
                self.measured(low, dimension, gauge)?,
                self.measured(high, dimension, gauge)?,
            ]),
            _ => Err(self.wrong_kind(value, RANGE.to_owned())),
        }
    }

    fn distribution(
        &self,
        value: &Spanned<DeValue<'_>>,
        spec: &KeySpec,
    ) -> Result<(Distribution, Box<Place>), DesignError> {
        if !matches!(spec.kind, Kind::Quantity { .. } | Kind::Count(_)) {
            return Err(self.wrong_kind(value, "without a distribution: it is not a quantity".to_owned()));
        }
        self.distribution_of(value)
    }

    fn distribution_of(&self, value: &Spanned<DeValue<'_>>) -> Result<(Distribution, Box<Place>), DesignError> {
        let word = value.get_ref().as_str().unwrap_or_default();
        let known = Distribution::parse(word);
        let known =
            known.ok_or_else(|| self.wrong_kind(value, one_of(&Distribution::ALL.map(Distribution::as_str))))?;
        Ok((known, self.file.place(value.span())))
    }

    fn provenance(&self, value: &Spanned<DeValue<'_>>) -> Result<(Provenance, String), DesignError> {
        let text = self.text(value, "provenance")?;
        Provenance::parse(&text).ok_or_else(|| {
            Problem::BadProvenance {
                key: self.key.to_owned(),
                found: text,
            }
            .at(self.file.place(value.span()))
        })
    }

    fn text(&self, value: &Spanned<DeValue<'_>>, name: &str) -> Result<String, DesignError> {
        match value.get_ref() {
            DeValue::String(text) => Ok(text.to_string()),
            _ => Err(Field {
                file: self.file,
                key: &dotted(self.key, name),
            }
            .wrong_kind(value, "as text in quotes".to_owned())),
        }
    }

    fn wrong_kind(&self, value: &Spanned<DeValue<'_>>, expected: String) -> DesignError {
        let found = found(value.get_ref());
        Problem::WrongKind {
            key: self.key.to_owned(),
            found,
            expected,
        }
        .at(self.file.place(value.span()))
    }

    fn quantity(&self, error: QuantityError, text: &str, expected: Dimension, span: Range<usize>) -> DesignError {
        let key = self.key.to_owned();
        let at = self.file.place(span);
        let problem = match error {
            QuantityError::Number => Problem::BadNumber {
                key,
                found: text.to_owned(),
                expected,
            },
            QuantityError::NotFinite => Problem::NotFinite {
                key,
                found: format!("\"{text}\""),
            },
            QuantityError::NoUnit => Problem::WrongUnit {
                key,
                unit: String::new(),
                found: NUMBER,
                expected,
            },
            QuantityError::Unit(problem) => Problem::BadUnit { key, problem, expected },
            QuantityError::Dimension { unit, found } => Problem::WrongUnit {
                key,
                unit,
                found,
                expected,
            },
            QuantityError::Gauge { unit } => Problem::Gauge { key, unit },
        };
        problem.at(at)
    }
}

const RANGE: &str = "with a range: \"low .. high unit\", [low, high], \"+-10 %\" or \"exact\"";

fn one_of(words: &[&str]) -> String {
    let quoted: Vec<_> = words.iter().map(|word| format!("\"{word}\"")).collect();
    match quoted.as_slice() {
        [one] => format!("as {one}"),
        _ => format!("as one of {}", quoted.join(", ")),
    }
}
