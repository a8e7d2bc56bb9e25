//! `drives.csv`: one row per drive, with the name of its recording.

use std::collections::{BTreeMap, HashSet};
use std::path::{Path, PathBuf};

use nailnoise_penetration::Specimen;
use nailnoise_penetration::fit::{Conditions, Driving, Masses};
use sha2::{Digest as _, Sha256};

use super::{PenetrationError, nail, read_bytes, unreadable, wood};
use crate::wording::hexadecimal;
use nailnoise_documents::tables::{Table, TableFault, number};

/// Columns of `drives.csv`.
pub const COLUMNS: [&str; 18] = [
    "id",
    "group",
    "repeat",
    "drive",
    "nail",
    "shank",
    "length_m",
    "diameter_m",
    "nail_mass_kg",
    "wood",
    "hardness_modulus_n_m",
    "density_kg_m3",
    "moisture",
    "speed_m_s",
    "projectile_mass_kg",
    "impact_speed_m_s",
    "mass_ahead_of_cell_kg",
    "file",
];

/// Domains of the numbers \[SI\]: lowest and highest value of each column, from a pin in balsa to a pile in stone, at
/// speeds from creep to that of a bullet. A value outside indicates a wrong unit.
const DOMAINS: [(&str, [f64; 2]); 10] = [
    ("length_m", [1e-3, 2.0]),
    ("diameter_m", [1e-4, 0.1]),
    ("nail_mass_kg", [1e-6, 100.0]),
    ("hardness_modulus_n_m", [1e3, 1e9]),
    ("density_kg_m3", [10.0, 5e3]),
    ("moisture", [0.0, 1e3]),
    ("speed_m_s", [1e-8, 1e3]),
    ("projectile_mass_kg", [1e-4, 1e4]),
    ("impact_speed_m_s", [1e-3, 1e3]),
    ("mass_ahead_of_cell_kg", [0.0, 1e4]),
];

/// Shank types.
const SHANKS: [&str; 3] = ["smooth", "annular", "helical"];

/// Maximum number of drives in a file.
const MOST_DRIVES: usize = 100_000;

/// A drive, as described by its row.
#[derive(Debug, Clone)]
pub struct Row {
    /// Name of the drive.
    pub id: String,
    /// The condition of which it is a repeat.
    pub group: String,
    /// Repeat of the condition.
    pub repeat: String,
    /// 1, or 2 for a second drive into the same hole.
    pub drive: u8,
    /// Name of the nail.
    pub nail: String,
    /// Shank type; may be empty.
    pub shank: String,
    /// Name of the wood.
    pub wood: String,
    /// Nail, wood and speed.
    pub conditions: Conditions,
    /// Masses in an impact test.
    pub masses: Masses,
    /// The recording.
    pub file: PathBuf,
    /// The file that contains the row, and its line.
    pub place: (PathBuf, usize),
}

/// The rows of a file of drives, and the digest of the file.
///
/// # Errors
/// [`PenetrationError::Data`] with file, line and column.
pub fn rows(path: &Path) -> Result<(Vec<Row>, String), PenetrationError> {
    let bytes = read_bytes(path).map_err(|cause| unreadable(path, &cause, "name a CSV file with a row a drive"))?;
    let digest = digest(&bytes);
    let data = |line: usize, problem: String, help: String| PenetrationError::Data {
        path: path.to_owned(),
        line,
        problem,
        help,
    };
    let known = || COLUMNS.join(", ");
    let table = Table::of_text(&bytes).map_err(|fault| {
        let help = format!("the first line names the columns: {}", known());
        PenetrationError::of_table(path, fault, 1, &help)
    })?;
    let headings: Vec<String> = table.headings.iter().map(|heading| heading.text.clone()).collect();
    for (place, heading) in headings.iter().enumerate() {
        if !COLUMNS.contains(&heading.as_str()) {
            let near = COLUMNS
                .iter()
                .min_by_key(|name| strsim::damerau_levenshtein(name, heading));
            let near = near.filter(|name| strsim::damerau_levenshtein(name, heading) <= 2 + heading.len() / 4);
            let hint = near.map_or_else(String::new, |near| format!("is it \"{near}\"? "));
            let shown: String = heading.chars().take(40).collect();
            return Err(data(
                table.line,
                format!("there is no column \"{shown}\""),
                format!("{hint}the columns are: {}", known()),
            ));
        }
        if headings[..place].contains(heading) {
            return Err(data(
                table.line,
                format!("it has two columns \"{heading}\""),
                "keep one of them".to_owned(),
            ));
        }
    }
    for needed in ["id", "file"] {
        if !headings.iter().any(|heading| heading == needed) {
            return Err(data(
                table.line,
                format!("the column \"{needed}\" is missing"),
                format!(
                    "the first line names the columns; the file has: {}",
                    headings.join(", ")
                ),
            ));
        }
    }
    let mut found = Vec::new();
    let mut refused = None;
    let read = table.rows(|line, record| {
        if found.len() == MOST_DRIVES {
            let problem = format!("there are more than {MOST_DRIVES} drives; split the file");
            return Err(TableFault::Line {
                line,
                column: None,
                problem,
            });
        }
        let fields: BTreeMap<&str, &str> = headings.iter().map(String::as_str).zip(record.iter()).collect();
        if refused.is_none() {
            match (Fields { path, line, fields }).row() {
                Ok(row) => found.push(row),
                Err(error) => refused = Some(error),
            }
        }
        Ok(())
    });
    if let Some(error) = refused {
        return Err(error);
    }
    read.map_err(|fault| {
        let help = "give every row a field for every column; it may be empty";
        PenetrationError::of_table(path, fault, 1, help)
    })?;
    if found.is_empty() {
        return Err(data(1, "it has no drive".to_owned(), "add a row a drive".to_owned()));
    }
    Ok((found, digest))
}

/// SHA-256 in hexadecimal digits.
pub fn digest(bytes: &[u8]) -> String {
    hexadecimal(&Sha256::digest(bytes))
}

/// Rejects drives with the same name, and second drives without their first.
///
/// # Errors
/// [`PenetrationError::Data`] with the place of the row.
pub fn check(rows: &[Row]) -> Result<(), PenetrationError> {
    let mut ids = HashSet::new();
    let firsts: HashSet<_> = rows.iter().filter(|row| row.drive == 1).map(hole).collect();
    for row in rows {
        let data = |problem: String, help: &str| PenetrationError::Data {
            path: row.place.0.clone(),
            line: row.place.1,
            problem,
            help: help.to_owned(),
        };
        if !ids.insert(&row.id) {
            return Err(data(
                format!("the drive \"{}\" is in the data twice", row.id),
                "give every drive an id of its own",
            ));
        }
        if row.drive == 2 && !firsts.contains(&hole(row)) {
            return Err(data(
                format!("drive 2 \"{}\" has no drive 1 with the same group and repeat", row.id),
                "add the first drive into the same hole, or leave the second out",
            ));
        }
    }
    Ok(())
}

/// The columns that two drives into one hole share.
pub fn hole(row: &Row) -> (&str, &str) {
    (&row.group, &row.repeat)
}

/// A row with its place.
struct Fields<'a> {
    path: &'a Path,
    line: usize,
    fields: BTreeMap<&'a str, &'a str>,
}

impl Fields<'_> {
    fn text(&self, column: &str) -> &str {
        self.fields.get(column).copied().unwrap_or("")
    }

    fn error(&self, problem: String, help: impl Into<String>) -> PenetrationError {
        PenetrationError::Data {
            path: self.path.to_owned(),
            line: self.line,
            problem,
            help: help.into(),
        }
    }

    /// A number, if given; it must be in its domain.
    fn number(&self, column: &str) -> Result<Option<f64>, PenetrationError> {
        let text = self.text(column);
        if text.is_empty() {
            return Ok(None);
        }
        match number(text) {
            Some(number) => self.within(column, number).map(Some),
            None => {
                let shown: String = text.chars().take(40).collect();
                Err(self.error(
                    format!("{column} is \"{shown}\", no number"),
                    "give a number in the unit that the column's name ends with, with a point before the decimals",
                ))
            }
        }
    }

    /// The number, if it is in the domain of its column.
    fn within(&self, column: &str, number: f64) -> Result<f64, PenetrationError> {
        let domain = DOMAINS.iter().find(|(name, _)| *name == column);
        match domain {
            Some((_, [low, high])) if !(*low..=*high).contains(&number) => Err(self.error(
                format!("{column} is {number:?}, and must be from {low:?} to {high:?}"),
                format!("correct {column}; its name ends with its unit"),
            )),
            _ => Ok(number),
        }
    }

    /// Shank type in lower case; may be empty.
    fn shank(&self) -> Result<String, PenetrationError> {
        let shank = self.text("shank").to_lowercase();
        if shank.is_empty() || SHANKS.contains(&shank.as_str()) {
            return Ok(shank);
        }
        let shown: String = shank.chars().take(40).collect();
        Err(self.error(
            format!("shank is \"{shown}\""),
            format!("give one of {}, or leave it empty", SHANKS.join(", ")),
        ))
    }

    fn row(&self) -> Result<Row, PenetrationError> {
        let id = self.text("id").to_owned();
        if id.is_empty() {
            return Err(self.error("the id is empty".to_owned(), "give every drive an id of its own"));
        }
        let drive = match self.text("drive") {
            "" | "1" => 1,
            "2" => 2,
            other => {
                let shown: String = other.chars().take(40).collect();
                return Err(self.error(
                    format!("drive is \"{shown}\""),
                    "1 is a nail into new wood, 2 the same nail again into its hole",
                ));
            }
        };
        let shank = self.shank()?;
        self.number("moisture")?;
        let (nail_name, wood_name) = (self.text("nail"), self.text("wood"));
        let (given_length, given_diameter) = (self.number("length_m")?, self.number("diameter_m")?);
        let (given_modulus, given_density) = (self.number("hardness_modulus_n_m")?, self.number("density_kg_m3")?);
        // Published dimensions replace those that the row omits.
        let published = nail(nail_name).ok();
        let helical = shank == "helical";
        let diameter = given_diameter.or_else(|| {
            published.and_then(|nail| {
                if helical {
                    nail.helical_diameter
                } else {
                    Some(nail.diameter)
                }
            })
        });
        let length = given_length.or_else(|| published.map(|nail| nail.length));
        let kind = wood(wood_name).ok();
        let modulus = given_modulus.or_else(|| kind.map(|wood| wood.hardness_modulus));
        let density = given_density.or_else(|| kind.map(|wood| wood.density));
        let missing = |what: &str, column: &str| {
            self.error(
                format!("{what} of drive \"{id}\" is missing"),
                format!(
                    "give {column}, or name a published nail (6d) or wood (pine); `nailnoise penetration law --list` \
                     shows them"
                ),
            )
        };
        let specimen = Specimen {
            length: length.ok_or_else(|| missing("the length of the nail", "length_m"))?,
            diameter: diameter.ok_or_else(|| missing("the diameter of the nail", "diameter_m"))?,
            hardness_modulus: modulus.ok_or_else(|| missing("the hardness modulus", "hardness_modulus_n_m"))?,
            density: density.ok_or_else(|| missing("the density of the wood", "density_kg_m3"))?,
        };
        if specimen.diameter >= specimen.length {
            return Err(self.error(
                format!(
                    "the nail of drive \"{id}\" is {} m long and {} m thick",
                    specimen.length, specimen.diameter
                ),
                "give a diameter_m below length_m",
            ));
        }
        let speed = self.number("speed_m_s")?;
        let impact = (self.number("projectile_mass_kg")?, self.number("impact_speed_m_s")?);
        let nail_mass = self.number("nail_mass_kg")?;
        let ahead = self.number("mass_ahead_of_cell_kg")?.unwrap_or(0.0);
        let driving = match (speed, impact) {
            (Some(speed), (None, None)) => Driving::Constant { speed },
            (None, (Some(mass), Some(speed))) => Driving::Impact { mass, speed },
            _ => {
                return Err(self.error(
                    format!("the speed of drive \"{id}\" is not given once"),
                    "give speed_m_s of a testing machine, or projectile_mass_kg and impact_speed_m_s",
                ));
            }
        };
        if matches!(driving, Driving::Impact { .. }) && nail_mass.is_none() {
            return Err(self.error(
                format!("the mass of the nail of drive \"{id}\" is missing"),
                "give nail_mass_kg: nail and projectile move together after the impact",
            ));
        }
        if matches!(driving, Driving::Impact { mass, .. } if !(0.0..mass).contains(&ahead)) {
            return Err(self.error(
                format!("mass_ahead_of_cell_kg is {ahead}, and must be 0 or more, below projectile_mass_kg"),
                "correct mass_ahead_of_cell_kg",
            ));
        }
        let file = self.text("file");
        if file.is_empty() {
            return Err(self.error(
                format!("drive \"{id}\" names no file"),
                "give the CSV file of the recording: time_s,depth_m,force_n",
            ));
        }
        let group = match self.text("group") {
            "" => id.clone(),
            group => group.to_owned(),
        };
        Ok(Row {
            group,
            repeat: self.text("repeat").to_owned(),
            drive,
            nail: match nail_name {
                "" => format!("{:.2} x {:.3} mm", 1e3 * specimen.length, 1e3 * specimen.diameter),
                name => name.to_owned(),
            },
            shank,
            wood: wood_name.to_owned(),
            conditions: Conditions { specimen, driving },
            masses: Masses {
                nail: nail_mass.unwrap_or(0.0),
                ahead,
            },
            file: self.path.parent().unwrap_or_else(|| Path::new("")).join(file),
            place: (self.path.to_owned(), self.line),
            id,
        })
    }
}
