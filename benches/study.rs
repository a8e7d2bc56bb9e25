//! Memory and processor time needed to evaluate a large study, from made-up levels for the N80CB's variables: `cargo
//! bench -p nailnoise --bench study -- DRAWS`, 20 000 by default.

use std::error::Error;
use std::path::Path;
use std::time::Instant;

use nailnoise::Design;
use nailnoise::stages::levels::{Levels, SourceLevels};
use nailnoise::study::{Draw, Draws, Request, ShotFigures, StudyResult, variables};
use nailnoise_acoustics::random::uniform;

/// Bands of a source, and intervals between the events of a shot.
const BANDS: usize = 30;
const INTERVALS: [&str; 6] = [
    "trigger_pull - rod_hits_nail",
    "rod_hits_nail - nail_point_in_wood",
    "nail_point_in_wood - piston_hits_bumper",
    "piston_hits_bumper - bottom_dead_centre",
    "bottom_dead_centre - piston_returned",
    "piston_returned - end",
];

fn main() -> Result<(), Box<dyn Error>> {
    // Cargo also passes `--bench`.
    let draws = std::env::args()
        .find_map(|argument| argument.parse().ok())
        .unwrap_or(20_000);
    let design = Design::load(Path::new(env!("CARGO_MANIFEST_DIR")).join("designs/n80cb.toml"))?;
    let variables = variables(&design)?;
    let count = variables.len();
    let before = resident("VmRSS")?;
    let draw = |number: usize| {
        let at = |place: usize| uniform(1, number as u64, place as u64);
        let level = |place: usize| Some(90.0 + 10.0 * at(place));
        let source = |(place, name): (usize, &str)| SourceLevels {
            source: name.to_owned(),
            lwa_db: level(place),
            method_db: [Some(1.0); 2],
            bands: (0..BANDS)
                .map(|band| (100.0 * band as f64, level(place + band)))
                .collect(),
            intervals: INTERVALS.map(|events| (events.to_owned(), level(place))).to_vec(),
        };
        Draw {
            structure: 0,
            candidate: number as u64,
            shares: (0..count).map(|place| at(place).clamp(1e-6, 1.0 - 1e-6)).collect(),
            shot: ShotFigures {
                outcome: "drives".to_owned(),
                mean_drive_speed: Some(20.0),
                penetration: 0.08,
                exhaust_mass: 3e-3,
            },
            levels: Levels {
                outcome: "drives".to_owned(),
                sources: ["workpiece", "exhaust", "body"]
                    .into_iter()
                    .enumerate()
                    .map(source)
                    .collect(),
                failed_checks: Vec::new(),
                sensors: Vec::new(),
            },
            method_db: vec![0.0; 3],
        }
    };
    let made = Draws {
        variables,
        draws: (0..draws).map(draw).collect(),
        ..Draws::default()
    };
    let held = resident("VmRSS")?;
    let request = Request::new(draws, 1);
    let begin = Instant::now();
    let result = StudyResult::new(&design, &request, &made, None);
    let most = resident("VmHWM")?;
    println!(
        "{} draws of {count} variables: the draws hold {:.1} kB each, the statement adds {:.1} kB each and takes \
         {:.0} s",
        result.draws,
        (held - before) / draws as f64,
        (most - held) / draws as f64,
        begin.elapsed().as_secs_f64()
    );
    Ok(())
}

/// A figure of the memory of this process \[kB\].
fn resident(figure: &str) -> Result<f64, Box<dyn Error>> {
    let status = std::fs::read_to_string("/proc/self/status")?;
    let line = status.lines().find(|line| line.starts_with(figure));
    let number = line.and_then(|line| line.split_whitespace().nth(1));
    Ok(number
        .ok_or("the system does not tell the memory of a process")?
        .parse()?)
}
