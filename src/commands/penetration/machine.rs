//! `nailnoise penetration machine`: a shot of the test machine, or virtual tests of a plan.

use std::fmt::Write as _;
use std::path::{Path, PathBuf};

use clap::Args;
use nailnoise_acoustics::random::uniform;
use nailnoise_dynamics::machine::{Drive, Launched, Machine, Shot, drive, launch, read};
use nailnoise_penetration::fit::{FittedLaw, standard_normal};
use serde::Serialize;

use crate::atomic_write::AtomicWrite;
use crate::commands::Status;
use crate::commands::table::table;
use crate::commands::{message, print, print_json};
use crate::error::Error;
use crate::output;
use crate::penetration::PenetrationError;
use crate::penetration::drives::COLUMNS;
use crate::penetration::machine::machine as read_machine;
use crate::penetration::read_bytes;
use nailnoise_documents::tables::{Table, TableFault, number};

/// Largest residual of the energy balance, relative to the projectile's energy.
const BALANCE: f64 = 1e-8;

#[derive(Args)]
#[command(after_help = examples!(
    "nailnoise penetration machine machine.toml" => "a shot of the machine",
    "nailnoise penetration machine machine.toml --virtual 12" => "recordings of 12 repeats with noise, for `prf fit`",
))]
pub(super) struct Arguments {
    /// File of the machine (TOML)
    machine: PathBuf,
    /// Write the recordings of N repeats with the noise of sensors and wood, for `prf fit`
    #[arg(long = "virtual", value_name = "N", value_parser = clap::value_parser!(u32).range(1..=1000))]
    repeats: Option<u32>,
    /// Masses and speeds of a plan, a file of `prf plan`, in place of the machine's own
    #[arg(long, value_name = "FILE", requires = "repeats")]
    plan: Option<PathBuf>,
    /// Seed of the noise
    #[arg(long, value_name = "SEED", default_value_t = 1)]
    seed: u64,
    /// Print exactly one JSON value instead of tables
    #[arg(long)]
    json: bool,
    /// Folder for shot.csv, or drives.csv and the recordings [default: out/prf-machine]
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
}

/// Layout of `prf machine --json`.
#[derive(Serialize)]
struct MachineResult {
    schema: &'static str,
    launch: Option<Launched>,
    shots: Vec<Drive>,
    /// Number of drives written with noise.
    drives: usize,
    warnings: Vec<String>,
    file: String,
}

pub(super) fn execute(arguments: &Arguments) -> Result<Status, Error> {
    let (machine, fit) = read_machine(&arguments.machine)?;
    let folder = arguments
        .out
        .clone()
        .unwrap_or_else(|| Path::new("out").join("prf-machine"));
    let staging = AtomicWrite::within(&folder)?;
    let (mut launched, mut shots) = (None, Vec::new());
    let conditions = match &arguments.plan {
        Some(path) => conditions(path)?,
        None => {
            let found = launch(&machine).map_err(PenetrationError::Machine)?;
            launched = Some(found);
            vec![(machine.projectile.mass, found.speed)]
        }
    };
    let interval = 1.0 / machine.sensors.rate;
    let mut rows: Vec<[String; COLUMNS.len()]> = Vec::new();
    let mut warnings = Vec::new();
    for (place, (mass, speed)) in conditions.into_iter().enumerate() {
        let mut machine = machine.clone();
        machine.projectile.mass = mass;
        let shot = Shot { speed, deviation: 0.0 };
        let clean = drive(&machine, fit.as_ref(), shot, interval).map_err(PenetrationError::Machine)?;
        for warning in machine.warnings(clean.joint_speed) {
            if !warnings.contains(&warning) {
                warnings.push(warning);
            }
        }
        for repeat in 1..=arguments.repeats.unwrap_or(0) {
            let row = virtual_test(&machine, fit.as_ref(), speed, (place, repeat), arguments.seed, &staging)?;
            rows.push(row);
        }
        if arguments.repeats.is_none() {
            staging.write(Path::new("shot.csv"), &samples(&clean)?)?;
        }
        shots.push(clean);
    }
    let last = if arguments.repeats.is_some() {
        "drives.csv"
    } else {
        "shot.csv"
    };
    let drives = rows.len();
    if arguments.repeats.is_some() {
        staging.write(Path::new(last), &output::table(COLUMNS, rows)?)?;
    }
    staging.place(&[], Path::new(last))?;
    warnings
        .iter()
        .for_each(|warning| message(&format!("warning: {warning}")));
    let worst = shots.iter().map(|shot| shot.energy.balance).fold(0.0, f64::max);
    let result = MachineResult {
        schema: "nailnoise-prf-machine/1",
        launch: launched,
        shots,
        drives,
        warnings,
        file: folder.join(last).display().to_string(),
    };
    if arguments.json {
        print_json(&result)?;
    } else {
        print(&text(&result))?;
    }
    if worst > BALANCE {
        message(&format!(
            "check failed: the energy of a shot is off by {worst:.1e}, limit {BALANCE:.0e}"
        ));
        return Ok(Status::from(3));
    }
    Ok(Status::SUCCESS)
}

/// Masses \[kg\] and impact speeds \[m/s\] of a plan; rows without an impact speed are omitted.
fn conditions(path: &Path) -> Result<Vec<(f64, f64)>, PenetrationError> {
    let data = |line: usize, problem: String| PenetrationError::Data {
        path: path.to_owned(),
        line,
        problem,
        help: "give a file that `nailnoise penetration plan` writes".to_owned(),
    };
    let bytes = read_bytes(path).map_err(|cause| data(1, cause.to_string()))?;
    let wrong =
        |fault| PenetrationError::of_table(path, fault, 1, "give a file that `nailnoise penetration plan` writes");
    let table = Table::of_text(&bytes).map_err(wrong)?;
    let place = |name: &str| table.headings.iter().position(|heading| heading.text == name);
    let (Some(mass), Some(speed)) = (place("mass_kg"), place("impact_speed_m_s")) else {
        let problem = "it has no columns mass_kg and impact_speed_m_s".to_owned();
        return Err(data(table.line, problem));
    };
    let mut found = Vec::new();
    let read = table.rows(|line, record| {
        if record[speed].is_empty() {
            return Ok(());
        }
        let positive = |place: usize| number(&record[place]).filter(|number| *number > 0.0);
        let (Some(mass), Some(speed)) = (positive(mass), positive(speed)) else {
            return Err(TableFault::Line {
                line,
                column: None,
                problem: "mass and speed are not numbers above 0".to_owned(),
            });
        };
        found.push((mass, speed));
        Ok(())
    });
    read.map_err(wrong)?;
    if found.is_empty() {
        return Err(data(1, "it has no row with a speed of impact".to_owned()));
    }
    Ok(found)
}

/// Writes the recording of one virtual test; returns its row in the table.
fn virtual_test(
    machine: &Machine,
    fit: Option<&FittedLaw>,
    speed: f64,
    (place, repeat): (usize, u32),
    seed: u64,
    staging: &AtomicWrite,
) -> Result<[String; COLUMNS.len()], Error> {
    let mut count = 0;
    // Independent of the order of the tests.
    let test = place as u64 * 1_000_000 + u64::from(repeat);
    let mut normal = || {
        count += 1;
        standard_normal(uniform(seed, test, count))
    };
    let deviation = machine.scatter.sigma_between * normal();
    let shot = Shot { speed, deviation };
    let interval = 1.0 / machine.sensors.rate;
    let drive = drive(machine, fit, shot, interval).map_err(PenetrationError::Machine)?;
    let readings = read(machine, &drive, &mut normal);
    let file = format!("drive-{}-{repeat}.csv", place + 1);
    let mut text = String::from("time_s,depth_m,force_n\n");
    for ((time, depth), force) in readings.time.iter().zip(&readings.depth).zip(&readings.force) {
        // Writing to a string cannot fail.
        let _ = writeln!(text, "{time:.9},{depth:.9},{force:.5}");
    }
    staging.write_unsynced(Path::new(&file), text.as_bytes())?;
    let (nail, wood) = (&machine.nail, &machine.wood);
    Ok([
        format!("{}-{repeat}", place + 1),
        format!("{} kg {speed:.2} m/s", machine.projectile.mass),
        repeat.to_string(),
        "1".to_owned(),
        String::new(),
        String::new(),
        nail.length.to_string(),
        nail.diameter.to_string(),
        nail.mass.to_string(),
        "virtual".to_owned(),
        wood.hardness_modulus.to_string(),
        wood.density.to_string(),
        String::new(),
        String::new(),
        machine.projectile.mass.to_string(),
        speed.to_string(),
        machine.projectile.mass_ahead_of_cell.to_string(),
        file,
    ])
}

/// `shot.csv`: force and motion without noise.
fn samples(drive: &Drive) -> Result<Vec<u8>, Error> {
    let rows = drive.samples.iter().map(|sample| {
        [sample.time, sample.depth, sample.speed, sample.force, sample.cell].map(|value| format!("{value:.9}"))
    });
    output::table(["time_s", "depth_m", "speed_m_s", "force_n", "force_cell_n"], rows)
}

fn text(result: &MachineResult) -> String {
    let mut text = String::new();
    if let Some(launch) = &result.launch {
        let _ = writeln!(
            text,
            "speed at the nail {:.4} m/s; free after {:.4} m, {:.3} ms\n",
            launch.speed,
            launch.travel,
            1e3 * launch.time
        );
    }
    let rows: Vec<Vec<String>> = result
        .shots
        .iter()
        .map(|shot| {
            let e = &shot.energy;
            let joules = [e.projectile, e.impact, e.shank, e.head, e.elastic, e.gravity, e.rest];
            let head = [
                format!("{:.2}", shot.impact_speed),
                format!("{:.2}", 1e3 * shot.stop_depth),
                format!("{:.3}", 1e3 * shot.stop_time),
                format!("{:.0}", shot.stop_force),
                format!("{:.3}", shot.rebound),
            ];
            head.into_iter()
                .chain(joules.map(|joule| format!("{joule:.3}")))
                .collect()
        })
        .collect();
    text.push_str(&table(
        &[
            "v0 m/s",
            "depth mm",
            "stop ms",
            "force N",
            "rebound m/s",
            "energy J",
            "impact",
            "shank",
            "head",
            "elastic",
            "gravity",
            "rest",
        ],
        &rows,
    ));
    if result.drives > 0 {
        let _ = writeln!(text, "\n  {} drives with noise", result.drives);
    }
    let _ = writeln!(text, "\n  {}", result.file);
    text
}
