//! `nailnoise list`: the catalogue of woods, nails, worktables and designs.

use clap::{Args, ValueEnum};
use serde::Serialize;

use super::Status;
use super::table::table;
use super::{print, print_json};
use crate::design::{self, Design, Named, NamedValue, Provenance, Value, nearest_word};
use crate::error::Error;
use crate::shipped;
use crate::tables::fixed;
use crate::wording::{readable, trimmed};

/// Version of the layout of `list --json`.
const SCHEMA: &str = "nailnoise-list/2";

/// The design whose steel density determines the nails' mass.
const BASE: &str = "base = \"n80cb.toml\"\n";

#[derive(Args)]
#[command(after_help = examples!(
    "nailnoise list woods" => "the words of `wood.species`, with density, hardness and moduli",
    "nailnoise list woods Douglas-fir" => "every key that a wood sets, with range and source",
    "nailnoise list nails --json" => "all values of all nails in SI units, for a script",
))]
pub(super) struct Arguments {
    /// What to list
    #[arg(value_enum)]
    what: What,
    /// One wood, nail or table, with every key that it sets and its source
    #[arg(value_name = "NAME")]
    name: Option<String>,
    /// Print exactly one JSON value instead of tables
    #[arg(long)]
    json: bool,
}

#[derive(Clone, Copy, PartialEq, ValueEnum)]
enum What {
    /// Words of `wood.species`
    Woods,
    /// Words of `nail.kind`
    Nails,
    /// Words of `support.worktable.preset`
    Tables,
    /// Designs that come with the program, for `init --from` and as `base`
    Designs,
}

/// Layout of `list --json`; lists not requested are absent.
#[derive(Default, Serialize)]
struct Lists {
    schema: &'static str,
    #[serde(skip_serializing_if = "Option::is_none")]
    woods: Option<Vec<Named>>,
    #[serde(skip_serializing_if = "Option::is_none")]
    nails: Option<Vec<Named>>,
    #[serde(skip_serializing_if = "Option::is_none")]
    tables: Option<Vec<Named>>,
    #[serde(skip_serializing_if = "Option::is_none")]
    designs: Option<Vec<ShippedDesign>>,
}

/// A design of the program.
#[derive(Serialize)]
struct ShippedDesign {
    name: &'static str,
    what: String,
}

pub(super) fn execute(arguments: &Arguments) -> Result<Status, Error> {
    let mut lists = Lists {
        schema: SCHEMA,
        ..Lists::default()
    };
    let name = arguments.name.as_deref();
    let text = match arguments.what {
        What::Woods => {
            let woods = chosen("woods", design::woods()?, name)?;
            let text = name.map_or_else(|| of_woods(&woods), |_| of_one(&woods));
            lists.woods = Some(woods);
            text
        }
        What::Nails => {
            let nails = chosen("nails", design::nails()?, name)?;
            let text = name.map_or_else(|| of_nails(&nails), |_| of_one(&nails));
            lists.nails = Some(nails);
            text
        }
        What::Tables => {
            let tables = chosen("tables", design::worktables()?, name)?;
            let text = name.map_or_else(|| of_tables(&tables), |_| of_one(&tables));
            lists.tables = Some(tables);
            text
        }
        What::Designs if name.is_some() => return Err(Error::ListName { list: "designs" }),
        What::Designs => {
            let designs: Vec<ShippedDesign> = shipped::DESIGNS
                .iter()
                .map(|(path, text)| shipped_design(path, text))
                .collect();
            let rows = designs.iter().map(|own| vec![own.name.to_owned(), own.what.clone()]);
            let text = left(["design", "what it is"], rows.collect());
            lists.designs = Some(designs);
            format!("{text}\n  `nailnoise init --from NAME` writes one with its bases\n")
        }
    };
    if arguments.json {
        print_json(&lists)?;
    } else {
        print(&text)?;
    }
    Ok(Status::SUCCESS)
}

/// All entries, or the one with this name; case, hyphens and spaces are ignored.
fn chosen(list: &'static str, all: Vec<Named>, name: Option<&str>) -> Result<Vec<Named>, Error> {
    let Some(name) = name else { return Ok(all) };
    let plain = |text: &str| text.to_lowercase().replace(['-', '_', ' '], "");
    let words: Vec<String> = all.iter().map(|own| own.name.to_lowercase()).collect();
    let nearest = nearest_word(words.iter().map(String::as_str), name).map(str::to_owned);
    let found: Vec<Named> = all.into_iter().filter(|own| plain(own.name) == plain(name)).collect();
    if found.is_empty() {
        let name = name.to_owned();
        return Err(Error::UnknownName { list, name, nearest });
    }
    Ok(found)
}

fn value<'a>(named: &'a Named, key: &str) -> Option<&'a NamedValue> {
    named.sets.iter().find(|own| own.key == key)
}

fn number(value: &Value) -> Option<f64> {
    match value {
        Value::Number(number) => Some(*number),
        Value::Count(count) => Some(f64::from(*count)),
        _ => None,
    }
}

/// A value divided by a scale, marked if it is an estimate, with its range if requested.
fn cell(named: &Named, key: &str, (scale, digits): (f64, usize), with_range: bool) -> String {
    let Some(own) = value(named, key) else {
        return "-".to_owned();
    };
    let Some(x) = number(&own.value) else {
        return "-".to_owned();
    };
    let mark = if own.provenance == Provenance::Published {
        ""
    } else {
        "*"
    };
    let range = own
        .range
        .filter(|_| with_range)
        .map_or_else(String::new, |[low, high]| {
            format!(" ({:.digits$} .. {:.digits$})", low * scale, high * scale)
        });
    format!("{:.digits$}{mark}{range}", x * scale)
}

const MARK: &str = "  * estimated, the others published; (range of plausible values)";

fn of_woods(woods: &[Named]) -> String {
    let first = woods.iter().map(|wood| {
        vec![
            wood.name.to_owned(),
            cell(wood, "wood.density", (1.0, 0), true),
            cell(wood, "wood.hardness_modulus", (1e-3, 0), true),
            cell(wood, "wood.loss_factor", (1.0, 3), true),
        ]
    });
    let headings = [
        "wood.species",
        "density kg/m3",
        "hardness modulus N/mm",
        "loss factor -",
    ];
    let mut text = table(&headings, &first.collect::<Vec<_>>());
    let moduli = ["e_l", "e_r", "e_t", "g_lr", "g_lt", "g_rt"];
    let second = woods.iter().map(|wood| {
        let own = moduli
            .iter()
            .map(|key| cell(wood, &format!("wood.elastic.{key}"), (1e-9, 3), false));
        [wood.name.to_owned()].into_iter().chain(own).collect::<Vec<_>>()
    });
    let headings = [
        "wood.species",
        "E_L GPa",
        "E_R GPa",
        "E_T GPa",
        "G_LR GPa",
        "G_LT GPa",
        "G_RT GPa",
    ];
    text.push_str(&format!("\n{}", table(&headings, &second.collect::<Vec<_>>())));
    let third = woods.iter().map(|wood| {
        let own = ["nu_lr", "nu_lt", "nu_rt"].map(|key| cell(wood, &format!("wood.elastic.{key}"), (1.0, 3), false));
        [wood.name.to_owned(), wood.sort.clone()]
            .into_iter()
            .chain(own)
            .collect::<Vec<_>>()
    });
    let headings = ["wood.species", "class", "nu_LR -", "nu_LT -", "nu_RT -"];
    text.push_str(&format!("\n{}", table(&headings, &third.collect::<Vec<_>>())));
    text.push_str(&format!(
        "\n{MARK}\n  with the shank of `nail.kind` the class sets `wood.penetration_law` and `wood.friction_share`\n  \
         `nailnoise list woods NAME` prints the source of each value\n"
    ));
    text
}

fn of_nails(nails: &[Named]) -> String {
    let mm = |nail: &Named, key: &str, digits| cell(nail, key, (1e3, digits), false);
    let rows = nails.iter().map(|nail| {
        vec![
            nail.name.to_owned(),
            nail.sort.clone(),
            nail.magazine.clone(),
            legs(nail),
            mm(nail, "nail.length", 2),
            mm(nail, "nail.diameter", 3),
            mm(nail, "nail.head_diameter", 1),
            fixed(mass(nail).map(|kilograms| 1e3 * kilograms), 2),
        ]
    });
    let headings = [
        "nail.kind",
        "shank",
        "magazine",
        "legs",
        "length mm",
        "diameter mm",
        "head mm",
        "mass g",
    ];
    format!(
        "{}\n  * estimated or nominal, the others published; mass of steel of 7850 kg/m3, computed\n  \
         a head that is not round is given as a circle of its area\n  \
         slender shanks and staples are thinner than those tested: docs/own-wood.md has their law\n  \
         `nailnoise list nails NAME` prints ranges and sources\n",
        table(&headings, &rows.collect::<Vec<_>>())
    )
}

fn legs(nail: &Named) -> String {
    let count = value(nail, "nail.legs").and_then(|own| number(&own.value));
    fixed(count, 0)
}

/// Mass of a nail in the base design \[kg\].
fn mass(nail: &Named) -> Option<f64> {
    let mut design = Design::parse(BASE, "list.toml").ok()?;
    let sets: Vec<(&str, Value)> = nail
        .sets
        .iter()
        .map(|own| (own.key.as_str(), own.value.clone()))
        .collect();
    design.set(&sets).ok()?;
    Some(design.nail.mass())
}

/// Every key that a name sets.
fn of_one(named: &[Named]) -> String {
    let rows = named.iter().flat_map(|named| &named.sets).map(|own| {
        let (unit, scale) = match own.unit.as_str() {
            "Pa" => ("GPa", 1e-9),
            "N/m" => ("N/mm", 1e-3),
            unit => readable(unit),
        };
        let short = |x: f64| trimmed(x * scale, 4);
        let shown = match &own.value {
            Value::Number(x) => format!("{} {unit}", short(*x)).trim_end().to_owned(),
            Value::Choice(word) => (*word).to_owned(),
            Value::Count(count) => count.to_string(),
            _ => String::new(),
        };
        let range = own
            .range
            .map_or_else(String::new, |[low, high]| format!("{} .. {}", short(low), short(high)));
        vec![
            own.key.clone(),
            shown,
            range,
            format!("{}: {}", own.provenance, own.source),
        ]
    });
    left(["key", "value", "range", "source"], rows.collect())
}

fn of_tables(tables: &[Named]) -> String {
    let group = "support.worktable";
    let rows = tables.iter().map(|own| {
        let mm = |key: &str| cell(own, &format!("{group}.{key}"), (1e3, 1), key != "leg_wall");
        let material = value(own, &format!("{group}.material")).map_or_else(String::new, |own| match &own.value {
            Value::Choice(word) => (*word).to_owned(),
            _ => String::new(),
        });
        vec![
            own.name.to_owned(),
            material,
            mm("top_thickness"),
            mm("leg_width"),
            mm("leg_wall"),
            cell(own, &format!("{group}.loss_factor"), (1.0, 3), true),
        ]
    });
    let headings = ["preset", "material", "top mm", "legs mm", "wall mm", "loss factor -"];
    let what = tables.iter().map(|own| format!("  {}: {}\n", own.name, own.sort));
    format!(
        "{}\n{}\n{MARK}\n  a wall of 0 is a solid leg\n  `nailnoise list tables NAME` prints every key with its \
         source\n",
        what.collect::<String>(),
        table(&headings, &rows.collect::<Vec<_>>())
    )
}

/// A design with the first sentence of its comments.
fn shipped_design(path: &'static str, text: &str) -> ShippedDesign {
    let comment = text.lines().map_while(|line| line.strip_prefix('#')).map(str::trim);
    let comment = comment
        .take_while(|line| !line.is_empty())
        .collect::<Vec<_>>()
        .join(" ");
    let sentence = comment.split_once(". ").map_or(comment.as_str(), |(first, _)| first);
    ShippedDesign {
        name: path.trim_end_matches(".toml"),
        what: sentence.trim_end_matches('.').to_owned(),
    }
}

/// Width of a printed line.
const WIDTH: usize = 100;

/// Left-aligned text columns; the last one wraps.
fn left<const N: usize>(headings: [&str; N], rows: Vec<Vec<String>>) -> String {
    let all: Vec<Vec<String>> = [headings.map(str::to_owned).to_vec()].into_iter().chain(rows).collect();
    let width = |column: usize| all.iter().map(|row| row[column].chars().count()).max().unwrap_or(0);
    let widths: Vec<usize> = (0..N - 1).map(width).collect();
    let indent: usize = widths.iter().map(|width| width + 2).sum::<usize>() + 2;
    let mut text = String::new();
    for row in &all {
        let cells = row.iter().zip(&widths).map(|(cell, width)| format!("  {cell:<width$}"));
        let mut line: String = cells.collect::<String>() + " ";
        let mut length = indent - 1;
        for word in row[N - 1].split(' ') {
            if length + 1 + word.chars().count() > WIDTH {
                text.push_str(line.trim_end());
                text.push('\n');
                (line, length) = (" ".repeat(indent - 1), indent - 1);
            }
            line.push(' ');
            line.push_str(word);
            length += 1 + word.chars().count();
        }
        text.push_str(line.trim_end());
        text.push('\n');
    }
    text
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]

    use super::*;

    #[test]
    fn no_table_is_wider_than_a_terminal() {
        let woods = design::woods().unwrap();
        let nails = design::nails().unwrap();
        let tables = design::worktables().unwrap();
        let mut texts = vec![of_woods(&woods), of_nails(&nails), of_tables(&tables)];
        texts.extend(
            woods
                .into_iter()
                .chain(nails)
                .chain(tables)
                .map(|named| of_one(&[named])),
        );
        for line in texts.iter().flat_map(|text| text.lines()) {
            assert!(line.chars().count() <= WIDTH, "{line}");
        }
    }

    #[test]
    fn the_last_column_goes_on_below_itself() {
        let words = "word ".repeat(30);
        let text = left(["a", "b"], vec![vec!["x".to_owned(), words.trim().to_owned()]]);
        let lines: Vec<&str> = text.lines().collect();
        assert_eq!(lines.len(), 3);
        assert!(lines[2].starts_with("     word") && lines.iter().all(|line| line.len() <= WIDTH));
    }
}
