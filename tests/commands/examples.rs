//! Every example runs as a reader would run it, and shows the figure it is there for.

use std::path::{Path, PathBuf};
use std::process::Command;

use crate::common::folder;

/// The program `cargo test` has built of an example, next to the tests' folder.
fn example(name: &str) -> PathBuf {
    let test = std::env::current_exe().unwrap();
    let profile = test.parent().and_then(Path::parent).unwrap();
    profile
        .join("examples")
        .join(name)
        .with_extension(std::env::consts::EXE_EXTENSION)
}

#[test]
fn rank_prints_three_sources_in_under_thirty_lines() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let output = Command::new(example("01_rank"))
        .arg("tests/data/small.toml")
        .current_dir(root)
        .output()
        .unwrap();
    let text = String::from_utf8(output.stdout).unwrap();
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    assert_eq!(text.lines().count(), 3, "{text}");
    assert!(text.contains("exhaust") && text.contains("dB(A)"), "{text}");
    assert!(include_str!("../../examples/01_rank.rs").lines().count() < 30);
}

#[test]
fn around_the_exhaust_is_loudest_beside_its_jets_and_louder_above_a_floor() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let output = Command::new(example("03_around_the_exhaust"))
        .arg("tests/data/small.toml")
        .current_dir(root)
        .output()
        .unwrap();
    let text = String::from_utf8(output.stdout).unwrap();
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let rows: Vec<Vec<f64>> = text
        .lines()
        .skip(1)
        .map(|line| line.split_whitespace().map(|word| word.parse().unwrap()).collect())
        .collect();
    assert_eq!(rows.len(), 7, "{text}");
    for row in &rows {
        // At most the 3 dB of an image as near as the source.
        assert!((0.0..=3.0).contains(&(row[2] - row[1])), "{text}");
    }
    let loudest = rows.iter().max_by(|a, b| a[1].total_cmp(&b[1])).unwrap();
    assert!(loudest[0] <= 60.0 && rows[6][1] < loudest[1] - 3.0, "{text}");
}

fn printed(name: &str) -> String {
    let output = Command::new(example(name))
        .arg("tests/data/small.toml")
        .current_dir(env!("CARGO_MANIFEST_DIR"))
        .output()
        .unwrap();
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    String::from_utf8(output.stdout).unwrap()
}

#[test]
fn pressure_drives_deeper_and_blows_louder() {
    let text = printed("02_pressure");
    let rows: Vec<Vec<f64>> = text
        .lines()
        .skip(1)
        .map(|line| {
            line.split_whitespace()
                .map(|word| word.parse().unwrap_or(f64::NAN))
                .collect()
        })
        .collect();
    assert_eq!(rows.len(), 5, "{text}");
    for pair in rows.windows(2) {
        for column in [2, 3, 4] {
            assert!(pair[1][column] > pair[0][column], "{text}");
        }
    }
    // Between an effect of only the mass and the eighth power of the speed of the jets, which choked ones hardly
    // follow.
    let rise = rows[4][4] - rows[0][4];
    assert!((1.0..5.0).contains(&rise), "{rise} dB from 650 to 850 kPa");
}

#[test]
fn block_has_every_mode() {
    let text = printed("04_block");
    let last = text.lines().last().unwrap();
    let numbers: Vec<&str> = last.split(' ').filter(|word| word.parse::<usize>().is_ok()).collect();
    assert_eq!(numbers.len(), 2, "{text}");
    assert_eq!(numbers[0], numbers[1], "{text}");
    let first: f64 = text.split(' ').next().unwrap().parse().unwrap();
    assert!((1000.0..4000.0).contains(&first), "{text}");
}

/// These compare one figure with its reference themselves.
#[test]
fn every_numbered_example_agrees_with_its_reference() {
    let examples = [
        "05_a_weighting",
        "06_speed_of_sound",
        "07_expansion_chamber",
        "08_valve_noise",
        "09_choked_vessel",
        "10_rod",
        "11_tapered_membrane",
        "12_piston",
    ];
    for name in examples {
        assert!(!printed(name).is_empty(), "{name}");
    }
}

#[test]
fn surface_velocities_are_written_for_every_corner_of_a_closed_surface_above_the_floor() {
    let folder = folder("surface-velocities");
    let output = Command::new(example("13_surface_velocities"))
        .args(["tests/data/small.toml", folder.to_str().unwrap(), "100"])
        .current_dir(env!("CARGO_MANIFEST_DIR"))
        .output()
        .unwrap();
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let text = std::fs::read_to_string(folder.join("surface.csv")).unwrap();
    let cells = |row: &str| -> Vec<f64> { row.split(',').skip(2).map(|cell| cell.parse().unwrap()).collect() };
    let corners: Vec<Vec<f64>> = text.lines().skip(1).map(cells).collect();
    assert!(
        corners.len() > 1000 && corners.len().is_multiple_of(4),
        "{}",
        corners.len()
    );
    // The vector areas of a surface that is open only in the floor add up to a vertical one.
    let mut area = [0.0; 3];
    for panel in corners.chunks(4) {
        let edge = |to: usize| [0, 1, 2].map(|axis| panel[to][axis] - panel[0][axis]);
        let (a, b) = (edge(1), edge(3));
        for (axis, area) in area.iter_mut().enumerate() {
            let (next, last) = ((axis + 1) % 3, (axis + 2) % 3);
            *area += a[next] * b[last] - a[last] * b[next];
        }
    }
    assert!(
        area[0].abs() < 1e-6 && area[1].abs() < 1e-6 && area[2] > 0.01,
        "{area:?}"
    );
    let powers = std::fs::read_to_string(folder.join("surface-power.csv")).unwrap();
    assert!(
        powers.lines().nth(1).is_some_and(|row| !row.contains("NaN")),
        "{powers}"
    );
}
