//! `nailnoise prf`: published penetration laws, evaluated and compared.

use std::fmt::Write as _;
use std::path::{Path, PathBuf};
use std::process::ExitCode;

use clap::Args;
use nailnoise_dynamics::prf::{FitQuality, NAILS, PenetrationLaw, REFERENCE_SPEED, WOODS};
use nailnoise_meshes::write_atomic;
use serde::Serialize;

use super::table::table;
use super::{print, print_json};
use crate::design::{LENGTH, VELOCITY, measure};
use crate::error::Error;
use crate::figures;
use crate::penetration::{self, PenetrationError, Resistance, law_name};

#[derive(Args)]
pub(super) struct Arguments {
    /// List the published laws, woods and nails, and do nothing else
    #[arg(long)]
    list: bool,
    /// Laws, as smooth,annular
    #[arg(long, value_name = "LAWS", value_delimiter = ',', required_unless_present = "list")]
    law: Vec<String>,
    /// Woods, as "pine" or "poplar plywood"
    #[arg(long, value_name = "WOODS", value_delimiter = ',', required_unless_present = "list")]
    wood: Vec<String>,
    /// Nail sizes, as 6d,12d
    #[arg(long, value_name = "SIZES", value_delimiter = ',', required_unless_present = "list")]
    nail: Vec<String>,
    /// Penetration speed, 20 to 500 mm/min; a number alone is in m/s [default: 500 mm/min]
    #[arg(long, value_name = "SPEED", value_parser = |text: &str| measure(text, VELOCITY))]
    speed: Option<f64>,
    /// Depths of the table, as "10 mm,25 mm" [default: tenths of the nail's length]
    #[arg(long, value_name = "DEPTHS", value_delimiter = ',', value_parser = |text: &str| measure(text, LENGTH))]
    depth: Vec<f64>,
    /// Print exactly one JSON value instead of tables
    #[arg(long)]
    json: bool,
    /// Folder for penetration.svg and penetration.csv [default: out/prf]
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
}

/// Layout of `prf --json`.
#[derive(Serialize)]
struct PrfResult {
    schema: &'static str,
    speed: f64,
    curves: Vec<CurveResult>,
    notes: Vec<String>,
}

#[derive(Serialize)]
struct CurveResult {
    label: String,
    law: &'static str,
    wood: &'static str,
    hardness_modulus: f64,
    density: f64,
    nail: &'static str,
    length: f64,
    diameter: f64,
    rows: Vec<Row>,
    work: f64,
    fit: FitQuality,
}

#[derive(Serialize)]
struct Row {
    depth: f64,
    force: f64,
    work: f64,
}

pub(super) fn execute(arguments: &Arguments) -> Result<ExitCode, Error> {
    if arguments.list {
        return if arguments.json { list_json() } else { Ok(list()) };
    }
    let laws = resistances(arguments)?;
    let labels = labels(&laws);
    let result = evaluate(arguments, &laws, &labels)?;
    let folder = arguments.out.clone().unwrap_or_else(|| Path::new("out").join("prf"));
    let mut files = figures::write(&folder, &[figures::penetration(&result.shared(), &laws, &labels)?])?;
    let path = folder.join("penetration.csv");
    write_atomic(&path, csv(&laws)?.as_bytes()).map_err(|source| Error::Write {
        path: path.clone(),
        source,
    })?;
    files.push(path);
    result.notes.iter().for_each(|note| eprintln!("note: {note}"));
    if arguments.json {
        print_json(&result)?;
    } else {
        print(&text(&result, arguments.depth.is_empty()));
        for file in files {
            print(&format!("  {}\n", file.display()));
        }
    }
    Ok(ExitCode::SUCCESS)
}

/// Every law for every nail in every wood.
fn resistances(arguments: &Arguments) -> Result<Vec<Resistance>, PenetrationError> {
    let speed = arguments.speed.unwrap_or(REFERENCE_SPEED);
    let mut all = Vec::new();
    for law in &arguments.law {
        for wood in &arguments.wood {
            for nail in &arguments.nail {
                let [law, wood, nail] = [law, wood, nail];
                let (law, wood, nail) = (
                    penetration::law(law)?,
                    penetration::wood(wood)?,
                    penetration::nail(nail)?,
                );
                all.push(Resistance::new(law, wood, nail, speed)?);
            }
        }
    }
    Ok(all)
}

/// Names of the curves: what they do not all share.
fn labels(laws: &[Resistance]) -> Vec<String> {
    let differ = |name: fn(&Resistance) -> &'static str| laws.iter().any(|law| name(law) != name(&laws[0]));
    let parts: [fn(&Resistance) -> &'static str; 3] =
        [|law| law_name(law.law), |law| law.nail.name, |law| law.wood.name];
    let label = |law: &Resistance| {
        let own: Vec<&str> = parts
            .iter()
            .filter(|name| differ(**name))
            .map(|name| name(law))
            .collect();
        if own.is_empty() {
            law_name(law.law).to_owned()
        } else {
            own.join(", ")
        }
    };
    laws.iter().map(label).collect()
}

fn evaluate(arguments: &Arguments, laws: &[Resistance], labels: &[String]) -> Result<PrfResult, PenetrationError> {
    let mut curves = Vec::new();
    let mut notes: Vec<String> = Vec::new();
    for (law, label) in laws.iter().zip(labels) {
        let length = law.specimen.length;
        let depths = match arguments.depth.as_slice() {
            [] => (1..=10).map(|tenth| length * f64::from(tenth) / 10.0).collect(),
            depths => depths.to_vec(),
        };
        let row = |depth: f64| {
            Ok(Row {
                depth,
                force: law.force(depth)?,
                work: law.work(depth)?,
            })
        };
        curves.push(CurveResult {
            label: label.clone(),
            law: law_name(law.law),
            wood: law.wood.name,
            hardness_modulus: law.specimen.hardness_modulus,
            density: law.specimen.density,
            nail: law.nail.name,
            length,
            diameter: law.specimen.diameter,
            rows: depths.into_iter().map(row).collect::<Result<_, PenetrationError>>()?,
            work: law.work(length)?,
            fit: law.quality(),
        });
        for note in law.notes() {
            if !notes.contains(&note) {
                notes.push(note);
            }
        }
    }
    if laws.len() > figures::MOST_LAWS {
        notes.push(format!(
            "the figure shows the first {} of {} curves",
            figures::MOST_LAWS,
            laws.len()
        ));
    }
    Ok(PrfResult {
        schema: "nailnoise-prf/1",
        speed: laws[0].speed,
        curves,
        notes,
    })
}

impl PrfResult {
    /// What all curves share, in words.
    fn shared(&self) -> String {
        let first = &self.curves[0];
        let one = |name: fn(&CurveResult) -> &'static str| {
            self.curves
                .iter()
                .all(|curve| name(curve) == name(first))
                .then(|| name(first).to_owned())
        };
        let speed = Some(format!("{:.0} mm/min", 60e3 * self.speed));
        let shared = [one(|c| c.law), one(|c| c.nail), one(|c| c.wood), speed];
        shared.into_iter().flatten().collect::<Vec<_>>().join(", ")
    }
}

fn text(result: &PrfResult, tenths: bool) -> String {
    let first = &result.curves[0];
    let mut text = format!("penetration resistance, {}\n\n", result.shared());
    let mut headings = vec![if tenths {
        "force N at x = y/NL"
    } else {
        "force N at depth mm"
    }];
    headings.extend(result.curves.iter().map(|curve| curve.label.as_str()));
    let rows: Vec<Vec<String>> = (0..first.rows.len())
        .map(|row| {
            let depth = first.rows[row].depth;
            let left = if tenths {
                format!("{:.1}", depth / first.length)
            } else {
                format!("{:.2}", 1e3 * depth)
            };
            let forces = result
                .curves
                .iter()
                .map(|curve| format!("{:.2}", curve.rows[row].force));
            std::iter::once(left).chain(forces).collect()
        })
        .collect();
    text.push_str(&table(&headings, &rows));
    text.push('\n');
    let rows: Vec<Vec<String>> = result
        .curves
        .iter()
        .map(|curve| {
            let fit = &curve.fit;
            vec![
                curve.label.clone(),
                format!("{:.2}", 1e3 * curve.length),
                format!("{:.3}", 1e3 * curve.diameter),
                format!("{:.3}", curve.work),
                format!("{:.2}", 100.0 * fit.r_squared),
                format!("{:.5}", fit.standard_error),
                format!("{:.5}", fit.mean_absolute_error),
            ]
        })
        .collect();
    text.push_str(&table(
        &["", "length mm", "diameter mm", "work J", "R2 %", "SEE", "MAE"],
        &rows,
    ));
    text.push_str("\n  SEE and MAE are published in units of sqrt(F_r/(H_M NL))\n\n");
    text
}

/// `penetration.csv`: force, its band of one standard error and work, every 0.5 % of the nail's length.
fn csv(laws: &[Resistance]) -> Result<String, PenetrationError> {
    let mut text = String::from("law,wood,nail,depth_m,force_n,force_low_n,force_high_n,work_j\n");
    for law in laws {
        for step in 0..=200 {
            let depth = law.specimen.length * f64::from(step) / 200.0;
            let [low, high] = law.band(depth)?;
            let (force, work) = (law.force(depth)?, law.work(depth)?);
            let (name, wood, nail) = (law_name(law.law), law.wood.name, law.nail.name);
            // Writing to a string cannot fail.
            let _ = writeln!(
                text,
                "{name},{wood},{nail},{depth:.7},{force:.4},{low:.4},{high:.4},{work:.6}"
            );
        }
    }
    Ok(text)
}

fn list() -> ExitCode {
    let laws: Vec<Vec<String>> = PenetrationLaw::ALL
        .into_iter()
        .map(|law| {
            let fit = law.fit_quality();
            let numbers = [
                format!("{:.2}", 100.0 * fit.r_squared),
                format!("{:.5}", fit.standard_error),
            ];
            [law_name(law).to_owned()]
                .into_iter()
                .chain(numbers)
                .chain([format!("{:.5}", fit.mean_absolute_error)])
                .collect()
        })
        .collect();
    let mut text = table(&["law", "R2 %", "SEE", "MAE"], &laws);
    text.push('\n');
    let woods: Vec<Vec<String>> = WOODS
        .iter()
        .map(|wood| {
            let numbers = [wood.hardness_modulus * 1e-3, wood.density, 100.0 * wood.moisture];
            let [hardness, density, moisture] = numbers;
            vec![
                wood.name.to_owned(),
                format!("{hardness:.2}"),
                format!("{density:.2}"),
                format!("{moisture:.1}"),
            ]
        })
        .collect();
    text.push_str(&table(&["wood", "H_M N/mm", "density kg/m3", "moisture %"], &woods));
    text.push('\n');
    let nails: Vec<Vec<String>> = NAILS
        .iter()
        .map(|nail| {
            let mm = |length: f64| format!("{:.3}", 1e3 * length);
            let helical = nail.helical_diameter.map_or_else(|| "-".to_owned(), mm);
            vec![nail.name.to_owned(), mm(nail.length), mm(nail.diameter), helical]
        })
        .collect();
    text.push_str(&table(
        &["nail", "length mm", "smooth and annular mm", "helical mm"],
        &nails,
    ));
    print(&text);
    ExitCode::SUCCESS
}

fn list_json() -> Result<ExitCode, Error> {
    #[derive(Serialize)]
    struct Law {
        name: &'static str,
        coefficients: [f64; 10],
        fit: FitQuality,
    }
    let laws: Vec<Law> = PenetrationLaw::ALL
        .into_iter()
        .map(|law| Law {
            name: law_name(law),
            coefficients: law.coefficients(),
            fit: law.fit_quality(),
        })
        .collect();
    print_json(&serde_json::json!({ "schema": "nailnoise-prf-list/1", "laws": laws, "woods": WOODS, "nails": NAILS }))?;
    Ok(ExitCode::SUCCESS)
}
