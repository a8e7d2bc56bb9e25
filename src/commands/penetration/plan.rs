//! `nailnoise penetration plan`: plans tests at high speed for a nail. It shows the depths that they reach and the
//! terms that they can separate.

use std::path::{Path, PathBuf};

use clap::{Args, ValueEnum};
use nailnoise_dynamics::machine::{
    Launch, MASSES, Machine, MachineError, Projectile, ScatterOfWood, Sensors, Shot, TestBlock, TestNail, drive, plan,
    speed_for_mean,
};
use nailnoise_dynamics::{Ambient, Wood};
use nailnoise_penetration::fit::{Conditions, Drive, Driving, FittedLaw, Form, Method, Point, Regression};
use nailnoise_penetration::{NailSize, PenetrationLaw, REFERENCE_SPEED, ResistanceLaw, Specimen, WoodKind};
use nailnoise_quantities::dimension::{ENERGY, MASS, NUMBER};
use nalgebra::DMatrix;
use serde::Serialize;

use super::limits::within;
use crate::atomic_write;
use crate::chain;
use crate::commands::Status;
use crate::commands::progress::note;
use crate::commands::table::table;
use crate::commands::{Changes, print, print_json};
use crate::design::Assignment;
use crate::error::Error;
use crate::output;
use crate::penetration::{self, PenetrationError};
use crate::tables::fixed;

/// Density of a nail's steel \[kg/m3\].
const STEEL: f64 = 7850.0;
/// Limits of the energy of a level \[J\] and of the mass of a projectile \[kg\]: from a tack to a pile driver.
const ENERGIES: [f64; 2] = [1e-3, 1e6];
const PROJECTILES: [f64; 2] = [1e-4, 1e4];
/// Number of depths at which a plan is evaluated.
const STATIONS: u32 = 20;

#[derive(Args)]
#[command(after_help = examples!(
    "nailnoise penetration plan --nail 12d --energy 42.125J" => "masses, speeds, and the terms that they can separate",
    "nailnoise penetration plan --nail 12d --from my-tool.toml" => "the energy of the piston of a design",
))]
pub(super) struct Arguments {
    /// Nail size, for example 12d
    #[arg(long, value_name = "SIZE")]
    nail: String,
    /// Energy of the middle level of every mass, for example 42.125J
    #[arg(long, value_name = "ENERGY", value_parser = |text: &str| within(text, ENERGY, ENERGIES))]
    #[arg(required_unless_present = "from", conflicts_with = "from")]
    energy: Option<f64>,
    /// Take the energy from the piston of a design: its mass and its mean speed while it drives the nail
    #[arg(long, value_name = "DESIGN")]
    from: Option<PathBuf>,
    /// Another value for a key of the design of --from, as supply.pressure=80psig; may be repeated
    #[arg(long, value_name = "KEY=VALUE", requires = "from")]
    set: Vec<Assignment>,
    /// Masses of the projectiles, for example "0.131 kg,0.2 kg" [default: 0.131 0.2 0.3 0.4 0.5 kg]
    #[arg(long, value_name = "MASSES", value_delimiter = ',',
        value_parser = |text: &str| within(text, MASS, PROJECTILES))]
    mass: Vec<f64>,
    /// Meaning of the speeds of the plan
    #[arg(long, value_name = "WHAT", value_enum, default_value_t = SpeedIs::Impact)]
    speed_is: SpeedIs,
    /// Wood by which the depths are predicted
    #[arg(long, value_name = "WOOD", default_value = "pine")]
    wood: String,
    /// Published law by which the depths are predicted
    #[arg(long, value_name = "LAW", default_value = "solid_wood")]
    law: String,
    /// Fitted law in its place, a file of `prf fit`
    #[arg(long, value_name = "FILE")]
    fit: Option<PathBuf>,
    /// Form whose terms the plan should separate
    #[arg(long, value_name = "TERMS", default_value = "poly(x,3) + decay + inertia + energy")]
    form: String,
    /// Scatter between specimens of s = sqrt(F_r/(H_M NL)), for the number of repeats
    #[arg(long, value_name = "NUMBER", default_value = "0.01",
        value_parser = |text: &str| within(text, NUMBER, [0.0, 100.0]))]
    sigma_between: f64,
    /// Wished standard error of the terms that are constant in a drive
    #[arg(long, value_name = "NUMBER", value_parser = |text: &str| within(text, NUMBER, [1e-6, 100.0]))]
    standard_error: Option<f64>,
    /// Print exactly one JSON value instead of tables
    #[arg(long)]
    json: bool,
    /// File of the plan [default: out/prf-plan/plan.csv]
    #[arg(long, value_name = "FILE")]
    out: Option<PathBuf>,
}

#[derive(Clone, Copy, PartialEq, Eq, ValueEnum)]
enum SpeedIs {
    /// Speeds of the projectile just before it strikes the nail
    Impact,
    /// Mean speeds of the nail to its full depth, its length over the time
    Mean,
}

/// Layout of `prf plan --json`.
#[derive(Serialize)]
struct PlanResult {
    schema: &'static str,
    nail: &'static str,
    energy: f64,
    rows: Vec<Row>,
    /// Why the plan cannot separate the terms of the form; null if it can.
    not_identifiable: Option<String>,
    /// Repeats of every row needed for the requested standard error, by term that is constant within a drive.
    repeats: Vec<(String, u64)>,
    notes: Vec<String>,
    file: String,
}

#[derive(Serialize)]
struct Row {
    mass: f64,
    /// The speed in the plan \[m/s\].
    speed: f64,
    /// The impact speed \[m/s\]; null if no impact leads to that mean speed.
    impact_speed: Option<f64>,
    energy: f64,
    /// Predicted depth of the tip \[m\]; null if the law is not valid.
    depth: Option<f64>,
}

pub(super) fn execute(arguments: &Arguments) -> Result<Status, Error> {
    let nail = penetration::nail(&arguments.nail)?;
    let wood = penetration::wood(&arguments.wood)?;
    let law = penetration::law(&arguments.law)?;
    let fit = arguments.fit.as_deref().map(penetration::fitted).transpose()?;
    let form: Form = arguments.form.parse().map_err(PenetrationError::Form)?;
    let energy = match (arguments.energy, &arguments.from) {
        (Some(energy), _) => energy,
        (None, Some(path)) => energy_of(path, &arguments.set)?,
        (None, None) => f64::NAN,
    };
    let masses: &[f64] = if arguments.mass.is_empty() {
        &MASSES
    } else {
        &arguments.mass
    };
    let levels = plan(energy, masses).map_err(PenetrationError::Plan)?;
    let mut notes = vec![format!(
        "mass of the nail estimated from its shank, {:.2} g; air and friction of the flight are left out",
        1e3 * nail_mass(nail)
    )];
    if fit.is_none() {
        notes.push(format!(
            "depths by the quasi-static law {} in {}, which is uncertain at these speeds: a guide to where the nail \
             stops",
            law.as_str(),
            wood.name
        ));
    }
    let (mut rows, mut drives) = (Vec::new(), Vec::new());
    for level in levels {
        let machine = machine(level.mass, nail, wood, law, fit.is_some());
        for (speed, energy) in level.speeds.into_iter().zip(level.energies) {
            let impact_speed = match arguments.speed_is {
                SpeedIs::Impact => Some(speed),
                SpeedIs::Mean => match speed_for_mean(&machine, fit.as_ref(), speed) {
                    Ok(found) => found,
                    Err(MachineError::BeyondFit { .. }) => None,
                    Err(error) => return Err(PenetrationError::Machine(error).into()),
                },
            };
            let depth = impact_speed.and_then(|speed| trial(&machine, fit.as_ref(), speed, nail, &mut drives));
            rows.push(Row {
                mass: level.mass,
                speed,
                impact_speed,
                energy,
                depth,
            });
        }
    }
    let not_identifiable = Regression::new(&form, &drives, Method::of(&form, &drives))
        .err()
        .map(|error| error.to_string());
    let repeats = match (arguments.standard_error, &not_identifiable) {
        (Some(wished), None) => repeats(&form, &drives, arguments.sigma_between, wished),
        _ => Vec::new(),
    };
    let path = arguments
        .out
        .clone()
        .unwrap_or_else(|| Path::new("out").join("prf-plan").join("plan.csv"));
    atomic_write::write(&path, &csv(&rows)?)?;
    notes.iter().for_each(|text| note(text));
    let result = PlanResult {
        schema: "nailnoise-prf-plan/1",
        nail: nail.name,
        energy,
        rows,
        not_identifiable,
        repeats,
        notes,
        file: path.display().to_string(),
    };
    if arguments.json {
        print_json(&result)?;
    } else {
        print(&text(&result, &form))?;
    }
    Ok(Status::SUCCESS)
}

/// M v^2/2 of a design's piston at its mean speed while it drives the nail \[J\].
fn energy_of(path: &Path, set: &[Assignment]) -> Result<f64, Error> {
    let design = Changes { set: set.to_vec() }.load(path)?;
    let record = chain::cycle(&design)?;
    let speed = record.figures.summary.mean_drive_speed.unwrap_or(0.0);
    Ok(0.5 * design.piston.mass * speed * speed)
}

fn nail_mass(nail: &NailSize) -> f64 {
    0.25 * std::f64::consts::PI * nail.diameter * nail.diameter * nail.length * STEEL
}

/// A machine with this projectile; gas, sensors and block are not used in a plan.
fn machine(mass: f64, nail: &NailSize, wood: &WoodKind, law: PenetrationLaw, fitted: bool) -> Machine {
    let c = law.coefficients();
    Machine {
        projectile: Projectile {
            mass,
            mass_ahead_of_cell: 0.0,
        },
        launch: Launch {
            speed: 1.0,
            reservoir_pressure: 0.0,
            reservoir_volume: 0.0,
            valve_area: 0.0,
            dead_volume: 0.0,
            bore: 0.0,
            rod_diameter: 0.0,
            vent_area: 0.0,
            below_volume: 0.0,
            stroke: 0.0,
            carrier_mass: 0.0,
            friction: 0.0,
            bumpers: 0,
            bumper_stiffness: 0.0,
            bumper_damping: 0.0,
            nail_distance: 0.0,
        },
        nail: TestNail {
            length: nail.length,
            diameter: nail.diameter,
            mass: nail_mass(nail),
        },
        wood: Wood {
            density: wood.density,
            hardness_modulus: wood.hardness_modulus,
            penetration_law: if fitted { ResistanceLaw::Fitted } else { law.into() },
            speed_term: c[8] * REFERENCE_SPEED * REFERENCE_SPEED,
            slenderness_term: c[9],
            penetration_force: 0.0,
            resistance_scale: 1.0,
            head_stiffness_scale: 1.0,
            // Affects only the rebound, which a plan does not show.
            unloading_stiffness: 1e7,
        },
        block: TestBlock {
            thickness: f64::INFINITY,
        },
        sensors: Sensors {
            rate: 0.0,
            depth_noise: 0.0,
            force_noise: 0.0,
            cell_frequency: 0.0,
            cell_damping: 1.0,
        },
        scatter: ScatterOfWood { sigma_between: 0.0 },
        ambient: Ambient {
            pressure: 101_325.0,
            temperature: 293.15,
            gas_constant: 287.05,
            heat_capacity_ratio: 1.4,
            viscosity: 1.82e-5,
            gravity: 9.81,
        },
    }
}

/// The depth that a shot reaches, and its motion as a drive of the plan.
fn trial(
    machine: &Machine,
    fit: Option<&FittedLaw>,
    speed: f64,
    nail: &NailSize,
    drives: &mut Vec<Drive>,
) -> Option<f64> {
    let shot = Shot { speed, deviation: 0.0 };
    let found = drive(machine, fit, shot, 1e-5).ok()?;
    let conditions = Conditions {
        specimen: Specimen {
            length: nail.length,
            diameter: nail.diameter,
            hardness_modulus: machine.wood.hardness_modulus,
            density: machine.wood.density,
        },
        driving: Driving::Impact {
            mass: machine.projectile.mass,
            speed,
        },
    };
    let loading: Vec<_> = found
        .samples
        .iter()
        .filter(|s| s.time < found.stop_time && s.depth <= nail.length)
        .collect();
    let every = loading.len().div_ceil(STATIONS as usize).max(1);
    let id = format!("{} kg {speed:.2} m/s", machine.projectile.mass);
    drives.push(Drive {
        group: id.clone(),
        id,
        nail: nail.name.to_owned(),
        wood: String::new(),
        conditions,
        points: loading
            .into_iter()
            .step_by(every)
            .map(|s| Point {
                depth: s.depth,
                speed: s.speed,
                root: conditions.root(s.force),
            })
            .collect(),
    });
    Some(found.stop_depth)
}

/// Repeats of every row needed for a standard error of the terms that are constant within a drive: sigma_b^2 (Z^T
/// Z)^-1/repeats.
fn repeats(form: &Form, drives: &[Drive], sigma_between: f64, wished: f64) -> Vec<(String, u64)> {
    let constant: Vec<_> = form.terms().iter().filter(|term| !term.varies(false)).collect();
    let matrix = DMatrix::from_fn(drives.len(), constant.len(), |row, column| {
        let drive = &drives[row];
        constant[column].value(&drive.conditions.values(drive.points[0].depth, drive.points[0].speed))
    });
    let Some(inverse) = (matrix.transpose() * &matrix).try_inverse() else {
        return Vec::new();
    };
    let count = |variance: f64| {
        (sigma_between * sigma_between * variance / (wished * wished))
            .ceil()
            .clamp(1.0, 1e9)
    };
    let variances = inverse.diagonal();
    let named = constant.iter().zip(variances.iter());
    named
        .map(|(term, variance)| (term.to_string(), count(*variance) as u64))
        .collect()
}

fn csv(rows: &[Row]) -> Result<Vec<u8>, Error> {
    let optional = |value: Option<f64>| value.map_or_else(String::new, |value| format!("{value:.6}"));
    output::table(
        [
            "mass_kg",
            "speed_m_s",
            "impact_speed_m_s",
            "energy_j",
            "predicted_depth_m",
        ],
        rows.iter().map(|row| {
            [
                format!("{}", row.mass),
                format!("{:.6}", row.speed),
                optional(row.impact_speed),
                format!("{:.4}", row.energy),
                optional(row.depth),
            ]
        }),
    )
}

fn text(result: &PlanResult, form: &Form) -> String {
    let optional = |value: Option<f64>, scale: f64, digits: usize| fixed(value.map(|value| scale * value), digits);
    let rows: Vec<Vec<String>> = result
        .rows
        .iter()
        .map(|row| {
            vec![
                format!("{:.4}", row.mass),
                format!("{:.2}", row.speed),
                optional(row.impact_speed, 1.0, 2),
                format!("{:.2}", row.energy),
                optional(row.depth, 1e3, 1),
            ]
        })
        .collect();
    let mut text = format!(
        "tests of {} nails, middle level {:.3} J\n\n",
        result.nail, result.energy
    );
    text.push_str(&table(
        &["mass kg", "speed m/s", "impact m/s", "energy J", "depth mm"],
        &rows,
    ));
    match &result.not_identifiable {
        Some(problem) => text.push_str(&format!("\n  {form}: {problem}\n")),
        None => text.push_str(&format!("\n  the plan separates the terms of {form}\n")),
    }
    for (term, repeats) in &result.repeats {
        text.push_str(&format!(
            "  {term}: {repeats} repeats of every row for the wished standard error\n"
        ));
    }
    text.push_str(&format!("\n  {}\n", result.file));
    text
}
