//! Damaged recordings: none panics, and each is refused with an error that names its file and a remedy, or still
//! contains all its samples.

use crate::written::{CORNER, Folder, HEAD, ONE, SAMPLES, binary_uff, csv, names, sine, uff, wav};
use nailnoise_measurement::{MeasurementError, Shot};
use rand_xoshiro::Xoshiro256PlusPlus;
use rand_xoshiro::rand_core::{Rng, SeedableRng};

/// Damaged files of each format.
const EACH: u64 = 40;

/// A microphone and an accelerometer, which may be of two formats.
fn read(folder: &Folder, keys: &str) -> Result<Shot, MeasurementError> {
    let manifest = folder.load(&format!(
        "{HEAD}[channels]\nmic5 = {{ file = \"recording\", {keys}, {CORNER} }}\n{ONE}"
    ))?;
    manifest.shot(0, 0)
}

/// A number below `bound`.
fn below(random: &mut Xoshiro256PlusPlus, bound: usize) -> usize {
    (random.next_u64() % bound as u64) as usize
}

/// One of several kinds of damage.
fn damage(mut bytes: Vec<u8>, random: &mut Xoshiro256PlusPlus) -> Vec<u8> {
    let length = bytes.len();
    // Headers are short compared with the samples; half of the damage is to them.
    let place = |random: &mut Xoshiro256PlusPlus| {
        let within = if random.next_u32().is_multiple_of(2) {
            length.min(600)
        } else {
            length
        };
        below(random, within)
    };
    match random.next_u32() % 8 {
        0 => bytes.truncate(below(random, length)),
        1 => {
            let at = place(random);
            bytes[at] ^= 1 << (random.next_u32() % 8);
        }
        2 => {
            let at = place(random).min(length - 4);
            bytes[at..at + 4].copy_from_slice(&u32::MAX.to_le_bytes());
        }
        3 => {
            let at = place(random);
            bytes.splice(at..at, *b"NaN");
        }
        4 => {
            let at = place(random);
            bytes.drain(at..length.min(at + 1 + below(random, 100)));
        }
        5 => bytes.clear(),
        6 => bytes.iter_mut().for_each(|byte| *byte = random.next_u32() as u8),
        _ => {
            let at = place(random);
            for byte in &mut bytes[at..length.min(at + 20)] {
                *byte = b'9';
            }
        }
    }
    bytes
}

/// Reads damaged files; returns how many were refused.
fn refused(name: &str, keys: &str, whole: &[u8]) -> u64 {
    let folder = Folder::new(&format!("damaged-{name}"));
    folder.write("recording", whole);
    assert_eq!(read(&folder, keys).unwrap().microphones[0].len(), SAMPLES);
    let mut refused = 0;
    for seed in 0..EACH {
        let mut random = Xoshiro256PlusPlus::seed_from_u64(seed);
        folder.write("recording", damage(whole.to_vec(), &mut random));
        match read(&folder, keys) {
            Ok(shot) => assert!(shot.microphones[0].iter().all(|sample| sample.is_finite())),
            Err(error) => {
                names(&error, &["recording", "mic5"]);
                refused += 1;
            }
        }
    }
    refused
}

#[test]
fn damaged_wav_files_are_refused_or_read_whole() {
    let refused = refused("wav", "full_scale = \"200 Pa\"", &wav(&[&sine(0.5)]));
    assert!(refused > EACH / 3, "{refused} of {EACH}");
}

#[test]
fn damaged_universal_files_are_refused_or_read_whole() {
    let text = refused("uff", "unit = \"Pa\"", &labelled(uff(&[&sine(0.5)])));
    assert!(text > EACH / 3, "{text} of {EACH}");
    let binary = refused(
        "uff-binary",
        "unit = \"Pa\"",
        &labelled(binary_uff(&sine(0.5), true, true)),
    );
    assert!(binary > EACH / 3, "{binary} of {EACH}");
}

/// A universal file of pressures.
fn labelled(mut bytes: Vec<u8>) -> Vec<u8> {
    let at = bytes.windows(4).position(|word| word == b"m/s2").unwrap();
    bytes[at..at + 4].copy_from_slice(b"Pa  ");
    bytes
}

#[test]
fn damaged_csv_files_are_refused_or_read_whole() {
    let refused = refused(
        "csv",
        "column = \"mic5 [Pa]\"",
        csv("time [s],mic5 [Pa]", &[&sine(0.5)]).as_bytes(),
    );
    assert!(refused > EACH / 3, "{refused} of {EACH}");
}
