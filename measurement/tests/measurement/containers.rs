//! Recordings as written by recorders, test systems and spreadsheets: reading each returns the samples from which it
//! was made.

use std::io::{Seek as _, SeekFrom, Write as _};
use std::path::Path;

use crate::written::{CORNER, Folder, HEAD, ONE, RATE, SAMPLES, csv, names, sine, uff, wav};
use nailnoise_measurement::recordings::{Selector, read_tracks};
use nailnoise_measurement::{MeasurementError, Shot};

/// Amplitude of all recordings here \[m/s²\], a quarter of full scale.
const AMPLITUDE: f64 = 250.0;

/// A test with one accelerometer and these keys; its recording is the file `N` with these bytes.
fn accelerometer(folder: &Folder, bytes: impl AsRef<[u8]>, keys: &str) -> Result<Shot, MeasurementError> {
    folder.write("mic.wav", wav(&[&sine(0.1)]));
    folder.write("N", bytes);
    let manifest = folder.load(&format!(
        "{HEAD}[channels]\nmic5 = {{ file = \"mic.wav\", full_scale = \"200 Pa\", {CORNER} }}\nN = {{ file = \"N\", \
         {keys} }}\n{ONE}"
    ))?;
    manifest.shot(0, 0)
}

/// Asserts that a recording reads as the sine of [`AMPLITUDE`].
#[track_caller]
fn reads(folder: &Folder, name: &str, bytes: impl AsRef<[u8]>, keys: &str, tolerance: f64) {
    let shot = accelerometer(folder, bytes, keys).unwrap_or_else(|error| panic!("{name}: {error}"));
    let expected = sine(AMPLITUDE);
    assert_eq!(shot.accelerations[0].len(), SAMPLES, "{name}");
    for (found, expected) in shot.accelerations[0].iter().zip(&expected) {
        assert!((found - expected).abs() <= tolerance, "{name}: {found} for {expected}");
    }
}

fn chunk(name: &[u8], content: &[u8]) -> Vec<u8> {
    let mut bytes = [name, &(content.len() as u32).to_le_bytes(), content].concat();
    bytes.resize(bytes.len().next_multiple_of(2), 0);
    bytes
}

/// A `fmt ` chunk of one channel; `valid` bits make it extensible, `more` bytes follow.
fn format(tag: u16, container: u16, bits: u16, valid: Option<u16>, more: usize) -> Vec<u8> {
    let mut bytes = [valid.map_or(tag, |_| 0xfffe).to_le_bytes(), 1_u16.to_le_bytes()].concat();
    bytes.extend(RATE.to_le_bytes());
    bytes.extend((RATE * u32::from(container)).to_le_bytes());
    bytes.extend([container.to_le_bytes(), bits.to_le_bytes()].concat());
    if let Some(valid) = valid {
        bytes.extend([22_u16.to_le_bytes(), valid.to_le_bytes()].concat());
        bytes.extend(0_u32.to_le_bytes());
        bytes.extend(u32::from(tag).to_le_bytes());
        bytes.extend([0, 0, 0x10, 0, 0x80, 0, 0, 0xaa, 0, 0x38, 0x9b, 0x71]);
    }
    bytes.extend(vec![0; more]);
    chunk(b"fmt ", &bytes)
}

fn riff(chunks: &[Vec<u8>]) -> Vec<u8> {
    let body = [b"WAVE".to_vec(), chunks.concat()].concat();
    [&b"RIFF"[..], &(body.len() as u32).to_le_bytes(), &body].concat()
}

/// The sine as integers whose valid bits are the highest ones of their container (Microsoft, `WAVEFORMATEXTENSIBLE`).
fn integers(valid: u32, container: usize) -> Vec<u8> {
    let full = ((1_i64 << (valid - 1)) - 1) as f64;
    let shift = 8 * container as u32 - valid;
    let sample = |x: f64| ((0.25 * x * full).round() as i64) << shift;
    sine(1.0)
        .iter()
        .flat_map(|x| sample(*x).to_le_bytes()[..container].to_vec())
        .collect()
}

const FULL: &str = "full_scale = \"1000 m/s2\"";

/// Half a quantisation step for this number of bits \[m/s²\].
fn step(bits: u32) -> f64 {
    0.501 * 1000.0 / ((1_i64 << (bits - 1)) - 1) as f64
}

#[test]
fn fewer_valid_bits_than_their_container_read_at_their_level() {
    let folder = Folder::new("valid-bits");
    for (valid, container) in [
        (24, 3),
        (24, 4),
        (16, 4),
        (16, 3),
        (20, 3),
        (20, 4),
        (12, 2),
        (32, 4),
        (48, 8),
    ] {
        let format = format(1, container as u16, 8 * container as u16, Some(valid as u16), 0);
        let file = riff(&[format, chunk(b"data", &integers(valid, container))]);
        reads(&folder, &format!("{valid} in {container}"), file, FULL, step(valid));
    }
    // A plain header of 24 bits in blocks of 4 bytes.
    let file = riff(&[format(1, 4, 24, None, 0), chunk(b"data", &integers(24, 4))]);
    reads(&folder, "plain", file, FULL, step(24));
}

#[test]
fn chunks_of_all_lengths_and_orders_are_read() {
    let folder = Folder::new("chunks");
    let data = chunk(b"data", &integers(16, 2));
    let plain = || format(1, 2, 16, None, 0);
    let float = |x: f64| ((0.25 * x) as f32).to_le_bytes();
    let floats = chunk(b"data", &sine(1.0).into_iter().flat_map(float).collect::<Vec<u8>>());
    let double = |x: f64| (0.25 * x).to_le_bytes();
    let doubles = chunk(b"data", &sine(1.0).into_iter().flat_map(double).collect::<Vec<u8>>());
    let mut longer = integers(16, 2);
    longer.push(7);
    for (name, chunks) in [
        ("iXML", vec![plain(), chunk(b"iXML", b"<BWFXML/>"), data.clone()]),
        ("bext", vec![chunk(b"bext", &[0; 603]), plain(), data.clone()]),
        ("JUNK", vec![chunk(b"JUNK", &[0; 27]), plain(), data.clone()]),
        (
            "LIST",
            vec![plain(), chunk(b"LIST", b"INFOx"), data.clone(), chunk(b"id3 ", b"x")],
        ),
        ("format of 18 bytes", vec![format(1, 2, 16, None, 2), data.clone()]),
        ("format of 40 bytes", vec![format(1, 2, 16, None, 24), data.clone()]),
        ("cbSize 24", vec![format(1, 2, 16, Some(16), 2), data.clone()]),
        ("format behind", vec![data.clone(), plain()]),
        ("a byte more", vec![plain(), chunk(b"data", &longer)]),
        ("float of 40 bytes", vec![format(3, 4, 32, None, 24), floats.clone()]),
        (
            "fact of 8 bytes",
            vec![format(3, 4, 32, None, 2), chunk(b"fact", &[1; 8]), floats],
        ),
        ("float of 64 bits", vec![format(3, 8, 64, Some(64), 0), doubles]),
    ] {
        reads(&folder, name, riff(&chunks), FULL, step(16));
    }
}

#[test]
fn files_with_lengths_of_64_bits_are_read() {
    let folder = Folder::new("rf64");
    let samples = integers(24, 3);
    let mut ds64 = Vec::new();
    for length in [0, samples.len() as u64, SAMPLES as u64] {
        ds64.extend(length.to_le_bytes());
    }
    ds64.extend(0_u32.to_le_bytes());
    for mark in [b"RF64", b"BW64"] {
        let file = [
            &mark[..],
            b"\xff\xff\xff\xffWAVE",
            &chunk(b"ds64", &ds64),
            &format(1, 3, 24, None, 0),
            b"data\xff\xff\xff\xff",
            &samples,
        ]
        .concat();
        reads(&folder, "rf64", &file, FULL, step(24));
        let cut = accelerometer(&folder, &file[..file.len() - 30], FULL).unwrap_err();
        names(&cut, &["N", "channel N", "cut off", "12000 samples", "11990"]);
    }
}

/// A sparse RF64 file with this number of frames: 16 bits, `channels` channels, zeros except for the last two frames of
/// channel 2.
fn sparse(path: &Path, channels: u16, frames: u64) -> u64 {
    let frame = 2 * u64::from(channels);
    let ds64: Vec<u8> = [0, frame * frames, frames]
        .iter()
        .flat_map(|x| x.to_le_bytes())
        .collect();
    let mut fmt = [1_u16.to_le_bytes(), channels.to_le_bytes()].concat();
    fmt.extend(RATE.to_le_bytes());
    fmt.extend([0; 4]);
    fmt.extend([(2 * channels).to_le_bytes(), 16_u16.to_le_bytes()].concat());
    let ds64 = chunk(b"ds64", &[ds64, vec![0; 4]].concat());
    let head = [
        &b"RF64\xff\xff\xff\xffWAVE"[..],
        &ds64,
        &chunk(b"fmt ", &fmt),
        b"data\xff\xff\xff\xff",
    ]
    .concat();
    let mut file = std::fs::File::create(path).unwrap();
    file.write_all(&head).unwrap();
    let length = head.len() as u64 + frame * frames;
    file.set_len(length).unwrap();
    for (back, value) in [(2, 0x4000_i16), (1, -0x2000)] {
        file.seek(SeekFrom::Start(length - back * frame + 2)).unwrap();
        file.write_all(&value.to_le_bytes()).unwrap();
    }
    length
}

/// Length and last samples of two channels of a file that was once rejected for its size.
#[test]
fn a_recording_of_300_megabytes_is_read_block_by_block() {
    let folder = Folder::new("rf64-long");
    let path = folder.path("long.wav");
    let frames = 600_000;
    assert!(sparse(&path, 256, frames) > 300_000_000);
    let tracks = read_tracks(&path, &[&Selector::Channel(2), &Selector::Channel(1)]).unwrap();
    let tracks = tracks.unwrap();
    let samples = &tracks[0].samples;
    assert_eq!(samples.len() as u64, frames);
    let (rest, last) = samples.split_at(samples.len() - 2);
    let full = f64::from(i16::MAX);
    assert_eq!(last, [f64::from(0x4000) / full, -f64::from(0x2000) / full]);
    assert!(rest.iter().chain(&tracks[1].samples).all(|sample| *sample == 0.0));
    let file = std::fs::File::options().write(true).open(&path).unwrap();
    file.set_len(290_000_000).unwrap();
    let (_, fault) = read_tracks(&path, &[&Selector::Channel(2)]).unwrap().unwrap_err();
    assert!(fault.to_string().contains("promises 600000 samples, 566406"), "{fault}");
}

#[test]
fn other_containers_and_codings_are_named() {
    let folder = Folder::new("foreign");
    for (bytes, words) in [
        (&b"RIFX\0\0\0\x24WAVEfmt "[..], "RIFX"),
        (b"riff\x2e\x91\xcf\x11\xa5\xd6\x28\xdb", "W64"),
        (b"FORM\0\0\0\x24AIFFCOMM", "AIFF"),
        (b"fLaC\0\0\0\x22", "FLAC"),
        (b"caff\0\x01\0\0desc", "CAF"),
        (b"\x01\x02\x03\x00\x05\x1b[2J", "binary"),
    ] {
        let error = accelerometer(&folder, bytes, FULL).unwrap_err();
        names(&error, &["N, channel N", words]);
        assert!(!crate::written::said(&error).contains(|letter: char| letter.is_control() && letter != '\n'));
    }
    for (tag, words) in [(6, "A-law"), (7, "mu-law"), (0x11, "ADPCM")] {
        let file = riff(&[format(tag, 1, 8, None, 2), chunk(b"data", &[0x55; 20_000])]);
        names(&accelerometer(&folder, file, FULL).unwrap_err(), &["coded as", words]);
    }
    let avi = [b"RIFF\0\0\0\0AVI ".to_vec(), chunk(b"LIST", b"hdrl")].concat();
    names(&accelerometer(&folder, avi, FULL).unwrap_err(), &["AVI"]);
}

/// The dataset 58 of the sine with a part of its text replaced.
fn dataset(from: &str, to: &str) -> Vec<u8> {
    let text = String::from_utf8(uff(&[&sine(AMPLITUDE)])).unwrap();
    assert!(text.contains(from), "{from}");
    // In Latin-1, as test systems write it.
    text.replacen(from, to, 1).chars().map(|letter| letter as u8).collect()
}

#[test]
fn a_history_is_read_beside_frequency_responses_and_unknown_datasets() {
    let folder = Folder::new("beside");
    let good = dataset("m/s2", "m/s2");
    let complex = {
        let text = String::from_utf8(uff(&[&sine(1.0)[..8]])).unwrap();
        let type_and_count = format!("{:>10}{:>10}", 4, 8);
        assert!(text.contains(&type_and_count));
        text.replacen(&type_and_count, &format!("{:>10}{:>10}", 6, 4), 1)
            .replacen("\n    1 ", "\n    4 ", 1)
            .into_bytes()
    };
    let unknown = b"    -1\n  1858\nwhatever\n    -1\n".to_vec();
    reads(
        &folder,
        "behind",
        [complex.clone(), good.clone()].concat(),
        "channel = 2",
        1e-8,
    );
    reads(
        &folder,
        "between",
        [good.clone(), complex.clone(), unknown.clone()].concat(),
        "channel = 1",
        1e-8,
    );
    reads(
        &folder,
        "unknown",
        [unknown, good.clone()].concat(),
        "channel = 1",
        1e-8,
    );
    let error = accelerometer(&folder, [complex, good].concat(), "channel = 1").unwrap_err();
    names(
        &error,
        &["channel N", "frequency response", "2 is a time history", "`channel`"],
    );
}

#[test]
fn labels_of_units_are_read_as_instruments_write_them() {
    let folder = Folder::new("labels");
    for label in ["m/s\u{b2}", "m/s^2", "(m/s2)", "m/sec2", "m/s**2"] {
        let file = dataset(&format!("{:<20}", "m/s2"), &format!("{label:<20}"));
        reads(&folder, label, file, "channel = 1", 1e-8);
    }
    for label in ["sec", "Sec", "seconds", "S"] {
        reads(
            &folder,
            label,
            dataset(&format!("{:<20}", "s"), &format!("{label:<20}")),
            "channel = 1",
            1e-8,
        );
    }
    let error = accelerometer(
        &folder,
        dataset(&format!("{:<20}", "s"), &format!("{:<20}", "fathoms")),
        "channel = 1",
    );
    names(
        &error.unwrap_err(),
        &["unit \"fathoms\" of the times", "in s, ms or us"],
    );
}

#[test]
fn tables_read_alike_in_each_encoding_separator_and_layout() {
    let folder = Folder::new("tables");
    let text = csv("Time [sec],N [m/s\u{b2}]", &[&sine(AMPLITUDE)]);
    let (_, rows) = text.split_once('\n').unwrap();
    let german = text.replace(',', ";").replace('.', ",");
    let utf16 = |text: &str, order: fn(u16) -> [u8; 2]| text.encode_utf16().flat_map(order).collect::<Vec<u8>>();
    let quoted = |line: &str| format!("\"{}\"\n", line.replace(',', "\",\""));
    for (name, bytes) in [
        ("UTF-8", text.clone().into_bytes()),
        ("Latin-1", text.chars().map(|letter| letter as u8).collect()),
        ("UTF-16 LE", utf16(&format!("\u{feff}{text}"), u16::to_le_bytes)),
        ("UTF-16 BE", utf16(&format!("\u{feff}{german}"), u16::to_be_bytes)),
        ("decimal comma", german.clone().into_bytes()),
        ("tabs", german.replace(';', "\t").replace('\n', "\r\n").into_bytes()),
        ("quotes", text.lines().map(quoted).collect::<String>().into_bytes()),
        ("units below", format!("Time,N\n(s),(m/s2)\n\n{rows}").into_bytes()),
        (
            "lines before",
            format!("Model;DSO\n\nTime [s],N [m/s2]\n{rows}").into_bytes(),
        ),
        ("unnamed times", format!("x-axis,N\nsecond,m/s2\n{rows}").into_bytes()),
        ("slash", format!("t/s,N / (m/s2)\n{rows}").into_bytes()),
    ] {
        reads(&folder, name, bytes, "column = \"N\"", 1e-12);
    }
}

#[test]
fn a_record_in_units_of_another_quantity_is_refused() {
    let folder = Folder::new("other-quantity");
    for (label, words) in [
        ("Pa", "a pressure"),
        ("N", "a force"),
        ("dB", "levels"),
        ("V/Pa", "a sensitivity"),
    ] {
        let file = dataset(&format!("{:<20}", "m/s2"), &format!("{label:<20}"));
        for keys in ["channel = 1", "channel = 1, unit = \"m/s2\""] {
            let error = accelerometer(&folder, &file, keys).unwrap_err();
            names(&error, &["channel N", "is an acceleration", words, label, "`kind`"]);
        }
    }
    // Without a label, the specific data type decides: 12 is an acceleration, 15 a pressure.
    let unlabelled = dataset(&format!("{:<20}", "m/s2"), &format!("{:<20}", "NONE"));
    reads(&folder, "unlabelled", &unlabelled, "unit = \"m/s2\"", 1e-8);
    let pressure = String::from_utf8(unlabelled)
        .unwrap()
        .replacen("\n        12 ", "\n        15 ", 1);
    let error = accelerometer(&folder, pressure, "unit = \"m/s2\"").unwrap_err();
    names(
        &error,
        &[
            "channel N",
            "is an acceleration",
            "a pressure by its specific data type",
        ],
    );
}
