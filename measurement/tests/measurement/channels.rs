//! Channels that would bias a level: dead ones, several at one place, constant parts, scales without units.

use crate::written::{Folder, HEAD, ONE, RATE, SAMPLES, names, sine};
use nailnoise_measurement::arrangement::Arrangement;
use nailnoise_measurement::processing::process_recordings;
use nailnoise_measurement::recordings::wav::{Coding, encode};
use nailnoise_measurement::result::{MeasurementResult, Processing};
use nailnoise_measurement::subtraction::Reading;
use nailnoise_measurement::{Manifest, MeasurementError};

/// The places of EN 12549 around the centre of [`HEAD`].
const PLACES: [[f64; 3]; 9] = [
    [1.0, 0.0, 0.938],
    [0.0, 1.0, 0.938],
    [-1.0, 0.0, 0.938],
    [0.0, -1.0, 0.938],
    [1.0, 1.0, 1.938],
    [-1.0, 1.0, 1.938],
    [-1.0, -1.0, 1.938],
    [1.0, -1.0, 1.938],
    [0.0, 0.0, 1.938],
];

fn microphones(keys: &str) -> String {
    let microphone = |(index, place): (usize, &[f64; 3])| {
        let number = index + 1;
        format!("mic{number} = {{ file = \"shot.wav\", channel = {number}, {keys}, position = {place:?} }}\n")
    };
    PLACES.iter().enumerate().map(microphone).collect()
}

fn test(folder: &Folder, channels: &[Vec<f64>]) -> Result<Manifest, MeasurementError> {
    let signals: Vec<&[f64]> = channels.iter().map(Vec::as_slice).collect();
    folder.write("shot.wav", encode(&signals, RATE, 100.0, Coding::Float32).unwrap());
    folder.load(&format!(
        "{HEAD}[channels]\n{}{ONE}",
        microphones("full_scale = \"100 Pa\"")
    ))
}

fn measured(manifest: &Manifest) -> MeasurementResult {
    let arrangement = Arrangement::of(manifest).unwrap();
    let processing = Processing {
        reading: Reading::default(),
        paired: false,
        total_less_residual: false,
    };
    process_recordings(
        manifest,
        &arrangement,
        processing,
        |_, _| (),
        |_| Ok::<(), MeasurementError>(()),
    )
    .unwrap()
    .result
}

#[test]
fn a_dead_microphone_is_refused_by_name_and_so_are_nine() {
    let folder = Folder::new("dead");
    let mut channels = vec![sine(10.0); 9];
    test(&folder, &channels).unwrap().shot(0, 0).unwrap();
    // Zeros of an open cable, and the constant of a stuck converter.
    for value in [0.0, 1.5] {
        channels[3] = vec![value; SAMPLES];
        let error = test(&folder, &channels).unwrap().shot(0, 0).unwrap_err();
        names(
            &error,
            &["shot.wav, channel mic4", "dead", "12000 samples", "remove the channel"],
        );
    }
    let error = test(&folder, &vec![vec![0.0; SAMPLES]; 9])
        .unwrap()
        .shot(0, 0)
        .unwrap_err();
    names(&error, &["channel mic1", "dead", "so are those of mic2, mic3", "mic9"]);
}

#[test]
fn a_microphone_far_from_the_others_is_noted() {
    let folder = Folder::new("quiet");
    let mut channels = vec![sine(10.0); 9];
    channels[6] = sine(0.1);
    let notes = measured(&test(&folder, &channels).unwrap()).notes.join("\n");
    assert!(notes.contains("mic7 reads 40 dB less than the median"), "{notes}");
    // As near as the directivity of a tool allows.
    channels[6] = sine(3.0);
    let notes = measured(&test(&folder, &channels).unwrap()).notes.join("\n");
    assert!(!notes.contains("mic7"), "{notes}");
}

#[test]
fn a_constant_part_changes_no_band() {
    let folder = Folder::new("offset");
    // A click whose energy is above 63 Hz only to a small part, at the end of the record too.
    let click = |i: usize| {
        let t = i as f64 / f64::from(RATE) - 0.05;
        if t > 0.0 {
            30.0 * (-t / 0.01).exp() * (2000.0 * t).sin()
        } else {
            0.0
        }
    };
    let signal: Vec<f64> = (0..SAMPLES).map(click).collect();
    let offset: Vec<f64> = signal.iter().map(|p| p + 2.0).collect();
    let [plain, shifted] = [signal, offset].map(|signal| measured(&test(&folder, &vec![signal; 9]).unwrap()));
    let bands = |result: &MeasurementResult| result.configurations[0].bands.clone();
    for (plain, shifted) in bands(&plain).iter().zip(&bands(&shifted)) {
        let difference = shifted.lwa_db.unwrap() - plain.lwa_db.unwrap();
        assert!(difference.abs() < 1e-3, "{} Hz: {difference} dB", plain.hz);
    }
    let notes = shifted.notes.join("\n");
    assert!(
        notes.contains("constant part of up to 2.06 Pa removed from mic1, mic2"),
        "{notes}"
    );
    assert!(!plain.notes.join("\n").contains("constant part"));
}

#[test]
fn two_microphones_at_one_place_are_refused() {
    let text = |place: &str| {
        format!(
            "{HEAD}[channels]\n{}{ONE}",
            microphones("full_scale = \"100 Pa\"").replacen("[0.0, 1.0, 0.938]", place, 1)
        )
    };
    let parse = |place: &str| Manifest::parse(&text(place), "test.toml".as_ref());
    for (place, distance) in [("[1.0, 0.0, 0.938]", "0.000 m"), ("[1.0, 0.06, 0.938]", "0.060 m")] {
        let error = parse(place).unwrap_err();
        names(
            &error,
            &[
                "test.toml, line 7",
                "`channels.mic2.position`",
                distance,
                "mic1",
                "correct the position",
            ],
        );
    }
    parse("[1.0, 0.7, 0.938]").unwrap();
}

#[test]
fn channels_that_read_one_record_are_a_warning() {
    let text = format!("{HEAD}[channels]\n{}{ONE}", microphones("full_scale = \"100 Pa\""));
    let parse = |text: &str| Manifest::parse(text, "test.toml".as_ref()).unwrap().warnings.join("\n");
    assert!(!parse(&text).contains("same record"));
    let twice = parse(&text.replace("channel = 7", "channel = 2"));
    assert!(
        twice.contains("mic2, mic7 read the same record: channel 2 of shot.wav"),
        "{twice}"
    );
}

#[test]
fn a_scale_has_a_unit_and_a_size_that_exists() {
    let parse = |keys: &str| {
        Manifest::parse(
            &format!("{HEAD}[channels]\n{}{ONE}", microphones(keys)),
            "test.toml".as_ref(),
        )
    };
    for (keys, words) in [
        (
            "full_scale = \"100\"",
            "`channels.mic1.full_scale` is \"100\", which has no unit",
        ),
        ("full_scale = \"1e-320 Pa\"", "outside 1e-6 to 1e10 Pa"),
        ("full_scale = \"1e300 Pa\"", "outside 1e-6 to 1e10 Pa"),
        (
            "sensitivity = \"50 mV/Pa\", full_scale = \"1e9 V\"",
            "outside 1e-9 to 1e4 V",
        ),
        (
            "sensitivity = \"50\", full_scale = \"10 V\"",
            "`channels.mic1.sensitivity` is \"50\", which has no unit",
        ),
        (
            "sensitivity = \"1e-200 V/Pa\", full_scale = \"10 V\"",
            "outside 1e-12 to 1e3 V/Pa",
        ),
        (
            "calibrator = { file = \"c.wav\", level = \"1\" }",
            "`channels.mic1.calibrator.level` is \"1\", which has no unit",
        ),
    ] {
        names(&parse(keys).unwrap_err(), &["test.toml", words]);
    }
}

#[test]
fn names_that_a_spreadsheet_or_a_terminal_would_obey_are_refused() {
    for name in [
        "=1+1",
        "@x",
        "-2+3",
        "+cmd",
        "N\\u001b[2J",
        "N\\t",
        "a\\u009b31m",
        "x\\u202e",
    ] {
        let text = format!(
            "{HEAD}[channels]\n{}\"{name}\" = {{ file = \"N.wav\", full_scale = \"10 g\" }}\n{ONE}",
            microphones("full_scale = \"100 Pa\"")
        );
        let error = Manifest::parse(&text, "test.toml".as_ref()).unwrap_err();
        names(
            &error,
            &[
                "test.toml, line 15",
                "not a valid channel name",
                "begin it with a letter",
            ],
        );
    }
}
