//! `nailnoise penetration law`: penetration laws, published and own, evaluated and compared.

use std::path::{Path, PathBuf};

use clap::Args;
use nailnoise_penetration::{
    CurveError, CurveLaw, FitQuality, NAILS, PenetrationCurve, PenetrationLaw, REFERENCE_SPEED, WOODS,
};
use serde::Serialize;

use super::limits::within;
use super::specimen;
use crate::atomic_write::AtomicWrite;
use crate::commands::Status;
use crate::commands::progress::note;
use crate::commands::table::table;
use crate::commands::{print, print_json};
use crate::error::Error;
use crate::figures;
use crate::output;
use crate::penetration::{self, PenetrationError};
use crate::tables::{dash, fixed};
use nailnoise_quantities::dimension::{FORCE, LENGTH, VELOCITY};
use nailnoise_quantities::measure;

/// Limits of constant forces \[N\], far beyond the strength of a nail; negative ones are rejected with a separate
/// message by the curve.
const FORCES: [f64; 2] = [-1e6, 1e6];

#[derive(Args)]
#[command(after_help = examples!(
    "nailnoise penetration law --list" => "the published laws, woods and nails",
    "nailnoise penetration law --law smooth,annular --wood pine --nail 8d" => "two laws side by side",
    "nailnoise penetration law --law general --wood \"red oak\" --nail \"57 x 2.5 mm\"" =>
        "a wood of `nailnoise list woods` and a nail of your own size",
    "nailnoise penetration law --constant \"1.2 kN\" --table own.csv --nail 8d" => "laws of your own",
))]
pub(super) struct Arguments {
    /// Only list the published laws, woods and nails
    #[arg(long)]
    list: bool,
    /// Published laws, for example smooth,annular
    #[arg(long, value_name = "LAWS", value_delimiter = ',', requires = "wood")]
    #[arg(required_unless_present_any = ["list", "constant", "table"])]
    law: Vec<String>,
    /// Constant forces, for example "1.2 kN,900 N"
    #[arg(long, value_name = "FORCES", value_delimiter = ',', value_parser = |text: &str| within(text, FORCE, FORCES))]
    constant: Vec<f64>,
    /// CSV files of laws: depth in m and force in N per line
    #[arg(long, value_name = "FILES", value_delimiter = ',')]
    table: Vec<PathBuf>,
    /// Woods, for example "pine" or "red oak": those of the published tests and of `nailnoise list woods`
    #[arg(long, value_name = "WOODS", value_delimiter = ',', requires = "law")]
    wood: Vec<String>,
    /// Nail sizes, for example 6d,12d; a name of `nailnoise list nails`; or length and diameter, as "57 x 2.5 mm"
    #[arg(long, value_name = "SIZES", value_delimiter = ',', required_unless_present = "list")]
    nail: Vec<String>,
    /// Penetration speed, 20 to 500 mm/min; a number alone is in m/s [default: 500 mm/min]
    #[arg(long, value_name = "SPEED", value_parser = |text: &str| measure(text, VELOCITY))]
    speed: Option<f64>,
    /// Depths of the table, for example "10 mm,25 mm" [default: tenths of the nail length]
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
    law: String,
    nail: &'static str,
    length: f64,
    /// Only for published laws, like all fields below.
    wood: Option<&'static str>,
    hardness_modulus: Option<f64>,
    density: Option<f64>,
    diameter: Option<f64>,
    fit: Option<FitQuality>,
    rows: Vec<Row>,
    work: f64,
}

#[derive(Serialize)]
struct Row {
    depth: f64,
    force: f64,
    work: f64,
}

pub(super) fn execute(arguments: &Arguments) -> Result<Status, Error> {
    if arguments.list {
        return if arguments.json { list_json() } else { list() };
    }
    let laws = resistances(arguments)?;
    let labels = labels(&laws);
    let result = evaluate(arguments, &laws, &labels)?;
    let folder = arguments.out.clone().unwrap_or_else(|| Path::new("out").join("prf"));
    let chart = figures::penetration(&result.shared(), &laws, &labels)?;
    let staging = AtomicWrite::within(&folder)?;
    let mut files = figures::write(&staging, Path::new(""), &[chart])?;
    let table = PathBuf::from("penetration.csv");
    staging.write(&table, &csv(&laws)?)?;
    staging.place(&[], &table)?;
    files.push(table);
    result.notes.iter().for_each(|text| note(text));
    if arguments.json {
        print_json(&result)?;
    } else {
        print(&text(&result, arguments.depth.is_empty()))?;
        for file in files {
            print(&format!("  {}\n", folder.join(file).display()))?;
        }
    }
    Ok(Status::SUCCESS)
}

/// Every law for every nail; the published ones also in every wood.
fn resistances(arguments: &Arguments) -> Result<Vec<PenetrationCurve>, Error> {
    let speed = arguments.speed.unwrap_or(REFERENCE_SPEED);
    let nails = arguments.nail.iter().map(|name| Ok(specimen::nail(name)?.0));
    let nails: Vec<_> = nails.collect::<Result<_, Error>>()?;
    let mut all = Vec::new();
    for law in &arguments.law {
        for wood in &arguments.wood {
            for nail in &nails {
                let (law, wood) = (penetration::law(law)?, specimen::wood(wood)?);
                let curve = PenetrationCurve::new(law, wood, nail, speed);
                all.push(curve.map_err(PenetrationError::from)?);
            }
        }
    }
    for force in &arguments.constant {
        for nail in &nails {
            all.push(PenetrationCurve::constant(*force, nail).map_err(PenetrationError::from)?);
        }
    }
    for path in &arguments.table {
        let table = penetration::table(path)?;
        let name = path.file_name().unwrap_or_default().to_string_lossy();
        for nail in &nails {
            let curve = PenetrationCurve::tabulated(&name, table.clone(), nail);
            all.push(curve.map_err(PenetrationError::from)?);
        }
    }
    Ok(all)
}

fn wood_name(law: &PenetrationCurve) -> &str {
    law.wood().map_or("", |wood| wood.name)
}

/// Names of the curves, composed of the properties that differ between them.
fn labels(laws: &[PenetrationCurve]) -> Vec<String> {
    let parts: [fn(&PenetrationCurve) -> &str; 3] = [|law| &law.name, |law| law.nail.name, wood_name];
    // A law without a wood does not count as a difference.
    let differ = |name: fn(&PenetrationCurve) -> &str| {
        let mut own = laws.iter().map(name).filter(|name| !name.is_empty());
        let first = own.next();
        own.any(|name| Some(name) != first)
    };
    let label = |law: &PenetrationCurve| {
        let own: Vec<&str> = parts
            .iter()
            .filter(|name| differ(**name))
            .map(|name| name(law))
            .filter(|name| !name.is_empty())
            .collect();
        if own.is_empty() {
            law.name.clone()
        } else {
            own.join(", ")
        }
    };
    laws.iter().map(label).collect()
}

fn evaluate(arguments: &Arguments, laws: &[PenetrationCurve], labels: &[String]) -> Result<PrfResult, CurveError> {
    let mut curves = Vec::new();
    let mut notes: Vec<String> = Vec::new();
    for (law, label) in laws.iter().zip(labels) {
        let length = law.nail.length;
        let specimen = match &law.law {
            CurveLaw::Published { specimen, .. } => Some(specimen),
            CurveLaw::Constant(_) | CurveLaw::Tabulated(_) => None,
        };
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
            law: law.name.clone(),
            nail: law.nail.name,
            length,
            wood: law.wood().map(|wood| wood.name),
            hardness_modulus: specimen.map(|s| s.hardness_modulus),
            density: specimen.map(|s| s.density),
            diameter: specimen.map(|s| s.diameter),
            fit: law.quality(),
            rows: depths.into_iter().map(row).collect::<Result<_, CurveError>>()?,
            work: law.work(length)?,
        });
        for note in law.notes() {
            if !notes.contains(&note) {
                notes.push(note);
            }
        }
    }
    notes.extend(untested(laws));
    if laws.len() > figures::MOST_LAWS {
        notes.push(format!(
            "the figure shows the first {} of {} curves",
            figures::MOST_LAWS,
            laws.len()
        ));
    }
    Ok(PrfResult {
        schema: "nailnoise-prf/1",
        speed: arguments.speed.unwrap_or(REFERENCE_SPEED),
        curves,
        notes,
    })
}

/// Notes on published laws for woods and nails that their tests did not have.
fn untested(laws: &[PenetrationCurve]) -> Vec<String> {
    let published = || laws.iter().filter(|law| law.wood().is_some());
    let mut names: Vec<&str> = published()
        .map(|law| law.nail.name)
        .filter(|name| NAILS.iter().all(|nail| nail.name != *name))
        .chain(
            published()
                .map(wood_name)
                .filter(|name| WOODS.iter().all(|wood| wood.name != *name)),
        )
        .collect();
    names.sort_unstable();
    names.dedup();
    let note = |name: &str| format!("{name}: not in the tests of the published laws, which extrapolate to it");
    names.into_iter().map(note).collect()
}

impl PrfResult {
    /// The properties common to all curves, as text.
    fn shared(&self) -> String {
        let one = |name: fn(&CurveResult) -> Option<&str>| {
            let mut own = self.curves.iter().filter_map(name);
            let first = own.next()?;
            own.all(|name| name == first).then(|| first.to_owned())
        };
        // Only published laws depend on the speed.
        let published = self.curves.iter().any(|curve| curve.fit.is_some());
        let speed = published.then(|| format!("{:.0} mm/min", 60e3 * self.speed));
        let shared = [one(|c| Some(&c.law)), one(|c| Some(c.nail)), one(|c| c.wood), speed];
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
            let fit = |digits: usize, value: fn(&FitQuality) -> f64| fixed(curve.fit.as_ref().map(value), digits);
            let diameter = curve.diameter.map(|diameter| format!("{:.3}", 1e3 * diameter));
            vec![
                curve.label.clone(),
                format!("{:.2}", 1e3 * curve.length),
                diameter.unwrap_or_else(|| "-".to_owned()),
                format!("{:.3}", curve.work),
                fit(2, |fit| 100.0 * fit.r_squared),
                fit(5, |fit| fit.standard_error),
                fit(5, |fit| fit.mean_absolute_error),
            ]
        })
        .collect();
    text.push_str(&table(
        &["", "length mm", "diameter mm", "work J", "R2 %", "SEE", "MAE"],
        &rows,
    ));
    let note = if result.curves.iter().any(|curve| curve.fit.is_some()) {
        "\n  SEE and MAE are published in units of sqrt(F_r/(H_M NL))\n\n"
    } else {
        "\n"
    };
    text.push_str(note);
    text
}

/// `penetration.csv`: force, its band of one standard error if a fit is published, and work, every 0.5 % of the nail's
/// length.
fn csv(laws: &[PenetrationCurve]) -> Result<Vec<u8>, Error> {
    let row = |law: &PenetrationCurve, step: u32| -> Result<[String; 8], Error> {
        let depth = law.nail.length * f64::from(step) / 200.0;
        let [low, high] = law
            .band(depth)?
            .map_or_else(Default::default, |band| band.map(|force| format!("{force:.4}")));
        Ok([
            law.name.clone(),
            wood_name(law).to_owned(),
            law.nail.name.to_owned(),
            format!("{depth:.7}"),
            format!("{:.4}", law.force(depth)?),
            low,
            high,
            format!("{:.6}", law.work(depth)?),
        ])
    };
    let rows = laws.iter().flat_map(|law| (0..=200).map(move |step| row(law, step)));
    output::table(
        [
            "law",
            "wood",
            "nail",
            "depth_m",
            "force_n",
            "force_low_n",
            "force_high_n",
            "work_j",
        ],
        rows.collect::<Result<Vec<_>, _>>()?,
    )
}

fn list() -> Result<Status, Error> {
    let laws: Vec<Vec<String>> = PenetrationLaw::ALL
        .iter()
        .map(|law| {
            let fit = law.fit_quality();
            let numbers = [
                format!("{:.2}", 100.0 * fit.r_squared),
                format!("{:.5}", fit.standard_error),
            ];
            [law.as_str().to_owned()]
                .into_iter()
                .chain(numbers)
                .chain([format!("{:.5}", fit.mean_absolute_error)])
                .collect()
        })
        .collect();
    let mut text = table(&["law", "R2 %", "SEE", "MAE"], &laws);
    text.push('\n');
    let further = specimen::further_woods()?;
    let woods: Vec<Vec<String>> = WOODS
        .iter()
        .chain(&further)
        .map(|wood| {
            let numbers = [wood.hardness_modulus * 1e-3, wood.density, 100.0 * wood.moisture];
            let [hardness, density, moisture] = numbers;
            vec![
                wood.name.to_owned(),
                format!("{hardness:.2}"),
                format!("{density:.2}"),
                fixed(Some(moisture).filter(|own| own.is_finite()), 1),
            ]
        })
        .collect();
    text.push_str(&table(&["wood", "H_M N/mm", "density kg/m3", "moisture %"], &woods));
    text.push('\n');
    let nails: Vec<Vec<String>> = NAILS
        .iter()
        .map(|nail| {
            let mm = |length: f64| format!("{:.3}", 1e3 * length);
            let helical = dash(nail.helical_diameter, mm);
            vec![nail.name.to_owned(), mm(nail.length), mm(nail.diameter), helical]
        })
        .collect();
    text.push_str(&table(
        &["nail", "length mm", "smooth and annular mm", "helical mm"],
        &nails,
    ));
    print(&text)?;
    Ok(Status::SUCCESS)
}

fn list_json() -> Result<Status, Error> {
    #[derive(Serialize)]
    struct Law {
        name: &'static str,
        coefficients: [f64; 10],
        fit: FitQuality,
    }
    let laws: Vec<Law> = PenetrationLaw::ALL
        .iter()
        .map(|law| Law {
            name: law.as_str(),
            coefficients: law.coefficients(),
            fit: law.fit_quality(),
        })
        .collect();
    print_json(&serde_json::json!({ "schema": "nailnoise-prf-list/1", "laws": laws, "woods": WOODS, "nails": NAILS }))?;
    Ok(Status::SUCCESS)
}
