//! Every example runs as a reader would run it, and shows the figure it is there for.

use std::path::{Path, PathBuf};
use std::process::Command;

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
