//! Recordings: each format reads back the written data, and each fault is refused with file, channel, value and remedy.

use std::io::Cursor;

use crate::written::{CORNER, Folder, HEAD, ONE, RATE, SAMPLES, binary_uff, csv, names, sine, tone, uff, wav};
use nailnoise_measurement::MeasurementError;
use nailnoise_measurement::Shot;
use nailnoise_measurement::recordings::wav::{Coding, encode};
use nailnoise_measurement::recordings::{LARGEST, SHOT, Selector, decode};

/// Largest difference of two signals.
fn difference(a: &[f64], b: &[f64]) -> f64 {
    assert_eq!(a.len(), b.len());
    a.iter().zip(b).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max)
}

/// A test of one accelerometer with these keys and a microphone; its recording is `N` with this extension.
fn accelerometer(folder: &Folder, extension: &str, keys: &str) -> Result<Shot, MeasurementError> {
    folder.write("mic.wav", wav(&[&sine(0.1)]));
    let comma = if keys.is_empty() { "" } else { ", " };
    let manifest = folder.load(&format!(
        "{HEAD}[channels]\nmic5 = {{ file = \"mic.wav\", full_scale = \"200 Pa\", {CORNER} }}\n\
         N = {{ file = \"N.{extension}\"{comma}{keys} }}\n{ONE}"
    ))?;
    manifest.shot(0, 0)
}

fn hound(bits: u16, kind: hound::SampleFormat, samples: &[i32]) -> Vec<u8> {
    let spec = hound::WavSpec {
        channels: 1,
        sample_rate: RATE,
        bits_per_sample: bits,
        sample_format: kind,
    };
    let mut bytes = Cursor::new(Vec::new());
    let mut writer = hound::WavWriter::new(&mut bytes, spec).unwrap();
    samples.iter().for_each(|sample| writer.write_sample(*sample).unwrap());
    writer.finalize().unwrap();
    bytes.into_inner()
}

#[test]
fn integers_of_16_24_and_32_bits_are_read_to_their_last_step() {
    let folder = Folder::new("integers");
    let signal = sine(50.0);
    for bits in [16, 24, 32] {
        let full = ((1_i64 << (bits - 1)) - 1) as f64;
        let samples: Vec<i32> = signal.iter().map(|x| (x / 200.0 * full).round() as i32).collect();
        folder.write("W-1-1.wav", hound(bits, hound::SampleFormat::Int, &samples));
        let (_, shot) = folder.microphone("wav", "full_scale = \"200 Pa\"").unwrap();
        assert_eq!(shot.rate, f64::from(RATE));
        assert!(
            difference(&shot.microphones[0], &signal) <= 0.501 * 200.0 / full,
            "{bits} bits"
        );
    }
}

#[test]
fn floats_are_read_back() {
    let folder = Folder::new("floats");
    let signal = sine(50.0);
    folder.write("W-1-1.wav", encode(&[&signal], RATE, 200.0, Coding::Float32).unwrap());
    let (_, shot) = folder.microphone("wav", "full_scale = \"200 Pa\"").unwrap();
    assert!(difference(&shot.microphones[0], &signal) < 50.0 * f64::from(f32::EPSILON));
}

#[test]
fn floats_in_a_unit_are_read_back() {
    let folder = Folder::new("floats-unit");
    let signal = sine(50.0);
    folder.write("W-1-1.wav", encode(&[&signal], RATE, 1e3, Coding::Float32).unwrap());
    let (_, shot) = folder.microphone("wav", "unit = \"kPa\"").unwrap();
    assert!(difference(&shot.microphones[0], &signal) < 50.0 * f64::from(f32::EPSILON));
}

#[test]
fn a_channel_of_many_is_the_one_named() {
    let folder = Folder::new("channels");
    let signals: Vec<Vec<f64>> = (1..=9).map(|k| sine(0.1 * f64::from(k))).collect();
    let all: Vec<&[f64]> = signals.iter().map(Vec::as_slice).collect();
    folder.write("W-1-1.wav", wav(&all));
    for channel in [1, 5, 9] {
        let keys = format!("channel = {channel}, full_scale = \"1 Pa\"");
        let (_, shot) = folder.microphone("wav", &keys).unwrap();
        assert!(difference(&shot.microphones[0], &signals[channel - 1]) < 1e-7);
    }
}

#[test]
fn nine_channels_of_one_file_are_in_the_order_of_the_microphones() {
    let folder = Folder::new("nine");
    let signals: Vec<Vec<f64>> = (1..=9).map(|k| sine(0.1 * f64::from(k))).collect();
    folder.write("W-1-1.wav", wav(&signals.iter().map(Vec::as_slice).collect::<Vec<_>>()));
    let channel = |number: usize| {
        // The file lists them backwards, and its channels count backwards from the microphones' numbers.
        let channel = 10 - number;
        format!(
            "mic{number} = {{ file = \"{{c}}-{{k}}.wav\", channel = {channel}, full_scale = \"1 Pa\", \
             position = [{:.1}, 1, 1.938] }}\n",
            0.2 * (number as f64 - 5.0)
        )
    };
    let channels: String = (1..=9).rev().map(channel).collect();
    let manifest = folder.load(&format!("{HEAD}[channels]\n{channels}{ONE}")).unwrap();
    let shot = manifest.shot(0, 0).unwrap();
    for (index, signal) in shot.microphones.iter().enumerate() {
        assert!(difference(signal, &signals[8 - index]) < 1e-7, "mic{}", index + 1);
    }
}

#[test]
fn universal_files_are_read_back_in_all_their_forms() {
    let folder = Folder::new("universal");
    let (first, second) = (sine(3.0), sine(7.0));
    folder.write("N.uff", uff(&[&first, &second]));
    for (keys, signal) in [("", &first), ("channel = 2", &second)] {
        let shot = accelerometer(&folder, "uff", keys).unwrap();
        assert!(difference(&shot.accelerations[0], signal) < 1e-11);
    }
    for (double, little) in [(true, true), (true, false), (false, true), (false, false)] {
        folder.write("N.uff", binary_uff(&first, double, little));
        let shot = accelerometer(&folder, "uff", "").unwrap();
        let most = if double { 0.0 } else { 3.0 * f64::from(f32::EPSILON) };
        assert!(difference(&shot.accelerations[0], &first) <= most, "{double} {little}");
    }
}

#[test]
fn columns_are_read_back() {
    let folder = Folder::new("columns");
    let (first, second) = (sine(3.0), sine(7.0));
    let text = csv("time [s],N [m/s2],TC", &[&first, &second]);
    for text in [
        text.clone(),
        text.replace(',', ";"),
        text.replace(',', "\t"),
        format!("\u{feff}# recorder\n{text}"),
    ] {
        folder.write("N.csv", text);
        for column in ["N [m/s2]", "N"] {
            let shot = accelerometer(&folder, "csv", &format!("column = \"{column}\"")).unwrap();
            assert_eq!(shot.accelerations[0], first);
        }
        let shot = accelerometer(&folder, "csv", "column = \"TC\", unit = \"m/s2\"").unwrap();
        assert_eq!(shot.accelerations[0], second);
    }
}

#[test]
fn times_in_milliseconds_give_the_same_rate() {
    let folder = Folder::new("milliseconds");
    let signal = sine(3.0);
    let mut text = "time [ms],N\n".to_owned();
    for (index, value) in signal.iter().enumerate() {
        text += &format!("{:.6},{value}\n", 1e3 * index as f64 / f64::from(RATE));
    }
    folder.write("N.csv", &text);
    assert_eq!(
        accelerometer(&folder, "csv", "column = \"N\", unit = \"m/s2\"")
            .unwrap()
            .rate,
        f64::from(RATE)
    );
    folder.write("N.csv", text.replace("time [ms]", "time_ms"));
    assert_eq!(
        accelerometer(&folder, "csv", "column = \"N\", unit = \"m/s2\"")
            .unwrap()
            .rate,
        f64::from(RATE)
    );
}

#[test]
fn a_sensitivity_divides_the_voltage() {
    let folder = Folder::new("sensitivity");
    folder.write("W-1-1.wav", wav(&[&sine(0.25)]));
    // A quarter of 10 V is 2.5 V, by 50 mV/Pa 50 Pa.
    let (_, shot) = folder
        .microphone("wav", "sensitivity = \"50 mV/Pa\", full_scale = \"10 V\"")
        .unwrap();
    assert!(difference(&shot.microphones[0], &sine(50.0)) < 200.0 / 8_388_607.0);
    folder.write("N.csv", csv("t,N [mV]", &[&sine(100.0)]));
    // 100 mV by 10 mV/g are 10 g.
    let shot = accelerometer(&folder, "csv", "column = \"N\", sensitivity = \"10 mV/g\"").unwrap();
    assert!(difference(&shot.accelerations[0], &sine(98.0665)) < 1e-12 * 98.0);
    let keys = "column = \"N\", sensitivity = \"1 mV/(m/s2)\"";
    let shot = accelerometer(&folder, "csv", keys).unwrap();
    assert!(difference(&shot.accelerations[0], &sine(100.0)) < 1e-12 * 100.0);
}

#[test]
fn g_is_the_acceleration_of_free_fall() {
    let folder = Folder::new("free-fall");
    folder.write("N.csv", csv("t,N", &[&sine(1.0)]));
    let shot = accelerometer(&folder, "csv", "column = \"N\", unit = \"g\"").unwrap();
    assert!(difference(&shot.accelerations[0], &sine(9.80665)) < 1e-14 * 10.0);
    folder.write(
        "N.uff",
        String::from_utf8(uff(&[&sine(1.0)]))
            .unwrap()
            .replace("m/s2                ", "g                   "),
    );
    let shot = accelerometer(&folder, "uff", "").unwrap();
    assert!(difference(&shot.accelerations[0], &sine(9.80665)) < 1e-11);
}

#[test]
fn a_calibrators_tone_of_94_db_is_1_0024_pa_whatever_its_frequency_and_noise() {
    let folder = Folder::new("calibrator");
    folder.write("W-1-1.wav", wav(&[&sine(0.25)]));
    let rms = 20e-6 * 10f64.powf(94.0 / 20.0);
    assert!((rms - 1.0024).abs() < 1e-4);
    for (hz, offset, other) in [(1000.0, 0.0, 0.0), (993.7, 0.01, 0.0), (1007.0, 0.0, 0.02)] {
        // 0.05 of full scale is the amplitude of the tone; an offset and hum of 50 Hz are added to it.
        let hum = tone(other, 50.0, 48_000);
        let record: Vec<f64> = tone(0.05, hz, 48_000)
            .iter()
            .zip(hum)
            .map(|(x, hum)| x + hum + offset)
            .collect();
        folder.write("calibrator.wav", wav(&[&record]));
        let keys = "calibrator = { file = \"calibrator.wav\", level = \"94 dB\", frequency = \"1 kHz\" }";
        let (_, shot) = folder.microphone("wav", keys).unwrap();
        let amplitude = 0.25 / 0.05 * rms * 2f64.sqrt();
        let level = 20.0 * (1.0 + difference(&shot.microphones[0], &sine(amplitude)) / amplitude).log10();
        assert!(level < 1e-3, "{hz} Hz: {level} dB");
    }
}

#[test]
fn a_calibrators_record_without_its_tone_is_refused() {
    let folder = Folder::new("no-tone");
    folder.write("W-1-1.wav", wav(&[&sine(0.25)]));
    let keys = "calibrator = { file = \"calibrator.wav\", level = \"94 dB\" }";
    folder.write("calibrator.wav", wav(&[&tone(0.05, 250.0, 48_000)]));
    names(
        &folder.microphone("wav", keys).unwrap_err(),
        &["calibrator.wav", "channel mic5", "no tone of 1000 Hz", "frequency"],
    );
    folder.write("calibrator.wav", wav(&[&tone(0.05, 1000.0, 4_800)]));
    names(
        &folder.microphone("wav", keys).unwrap_err(),
        &["calibrator.wav", "lasts 0.100 s", "0.5 s"],
    );
    std::fs::remove_file(folder.path("calibrator.wav")).unwrap();
    names(
        &folder.microphone("wav", keys).unwrap_err(),
        &["calibrator.wav", "channel mic5", "cannot read"],
    );
}

#[test]
fn three_samples_in_a_row_at_full_scale_are_refused() {
    let folder = Folder::new("clipped");
    let mut signal = sine(0.5);
    signal[4800] = 1.0;
    signal[4801] = 1.0;
    folder.write("W-1-1.wav", wav(&[&signal]));
    folder.microphone("wav", "full_scale = \"200 Pa\"").unwrap();
    signal[4802] = 1.0;
    let words = [
        "W-1-1.wav",
        "channel mic5",
        "3 samples",
        "0.100000 s",
        "200.000000 Pa",
        "larger input range",
    ];
    folder.write("W-1-1.wav", wav(&[&signal]));
    names(
        &folder.microphone("wav", "full_scale = \"200 Pa\"").unwrap_err(),
        &words,
    );
    folder.write("W-1-1.wav", encode(&[&signal], RATE, 1.0, Coding::Float32).unwrap());
    names(
        &folder.microphone("wav", "full_scale = \"200 Pa\"").unwrap_err(),
        &words,
    );
    // The last step of a converter of 16 bits, whose largest number is 32767 and not 32768.
    signal.iter_mut().for_each(|x| *x *= 32_767.0 / 32_768.0);
    folder.write("W-1-1.wav", encode(&[&signal], RATE, 1.0, Coding::Float32).unwrap());
    names(
        &folder.microphone("wav", "full_scale = \"200 Pa\"").unwrap_err(),
        &["clipped", "3 samples"],
    );
}

#[test]
fn text_recordings_clip_at_their_stated_full_scale() {
    let folder = Folder::new("clipped-text");
    let signal: Vec<f64> = sine(50.0).iter().map(|x| x.clamp(-40.0, 40.0)).collect();
    folder.write("N.csv", csv("t,N [g]", &[&signal]));
    accelerometer(&folder, "csv", "column = \"N\"").unwrap();
    let error = accelerometer(&folder, "csv", "column = \"N\", full_scale = \"40 g\"").unwrap_err();
    names(&error, &["N.csv", "channel N", "clipped", "392.266000 m/s2"]);
}

#[test]
fn a_missing_channel_is_refused_with_those_there_are() {
    let folder = Folder::new("no-channel");
    folder.write("W-1-1.wav", wav(&[&sine(0.5), &sine(0.5)]));
    let error = folder
        .microphone("wav", "channel = 3, full_scale = \"200 Pa\"")
        .unwrap_err();
    names(
        &error,
        &[
            "W-1-1.wav",
            "channel mic5",
            "no channel 3",
            "the file has 2",
            "counts from 1",
        ],
    );
    folder.write("N.uff", uff(&[&sine(1.0)]));
    names(
        &accelerometer(&folder, "uff", "channel = 2").unwrap_err(),
        &["N.uff", "channel N", "no channel 2", "has 1"],
    );
    folder.write("N.csv", csv("t,N", &[&sine(1.0)]));
    let error = accelerometer(&folder, "csv", "column = \"TC\", unit = \"g\"").unwrap_err();
    names(&error, &["N.csv", "channel N", "no column \"TC\"", "t, N"]);
}

#[test]
fn a_channel_is_selected_as_its_format_needs() {
    let folder = Folder::new("selector");
    folder.write("N.csv", csv("t,N", &[&sine(1.0)]));
    names(
        &accelerometer(&folder, "csv", "unit = \"g\"").unwrap_err(),
        &["N.csv", "a CSV file", "`column`"],
    );
    folder.write("N.uff", uff(&[&sine(1.0)]));
    names(
        &accelerometer(&folder, "uff", "column = \"N\"").unwrap_err(),
        &["N.uff", "a universal file", "`channel`"],
    );
    folder.write("N.wav", wav(&[&sine(1.0)]));
    names(
        &accelerometer(&folder, "wav", "column = \"N\"").unwrap_err(),
        &["N.wav", "a WAV file", "`channel`"],
    );
}

#[test]
fn channels_of_different_rates_are_refused() {
    let folder = Folder::new("rates");
    folder.write("N.wav", encode(&[&sine(0.1)], 44_100, 1.0, Coding::Integer24).unwrap());
    let error = accelerometer(&folder, "wav", "full_scale = \"100 g\"").unwrap_err();
    names(
        &error,
        &[
            "N.wav",
            "channel N",
            "44100 Hz",
            "mic.wav",
            "48000 Hz",
            "one sampling rate",
        ],
    );
}

#[test]
fn shots_of_different_rates_are_refused() {
    let folder = Folder::new("rates-of-shots");
    folder.write("W-1-1.wav", wav(&[&sine(0.1)]));
    folder.write(
        "W-1-2.wav",
        encode(&[&sine(0.1)], 44_100, 1.0, Coding::Integer24).unwrap(),
    );
    let manifest = folder.load(&format!(
        "{HEAD}[channels]\nmic5 = {{ file = \"{{c}}-{{k}}.wav\", full_scale = \"200 Pa\", {CORNER} }}\n{}",
        ONE.replace("repeats = 1", "repeats = 2")
    ));
    let manifest = manifest.unwrap();
    manifest.shot(0, 0).unwrap();
    let error = manifest.shot(0, 1).unwrap_err();
    names(
        &error,
        &["W-1-2.wav", "channel mic5", "44100 Hz", "W-1-1.wav", "48000 Hz"],
    );
}

#[test]
fn a_shot_that_the_manifest_lacks_is_refused() {
    let folder = Folder::new("no-shot");
    folder.write("W-1-1.wav", wav(&[&sine(0.1)]));
    let (manifest, _) = folder.microphone("wav", "full_scale = \"200 Pa\"").unwrap();
    for (configuration, repeat) in [(0, 1), (1, 0)] {
        let error = manifest.shot(configuration, repeat).unwrap_err();
        assert!(matches!(error, MeasurementError::NoShot { .. }), "{error}");
    }
}

#[test]
fn recordings_without_calibration_are_refused() {
    let folder = Folder::new("no-calibration");
    folder.write("W-1-1.wav", wav(&[&sine(0.1)]));
    let words = [
        "W-1-1.wav",
        "channel mic5",
        "no calibration",
        "`full_scale`",
        "`calibrator`",
    ];
    names(&folder.microphone("wav", "channel = 1").unwrap_err(), &words);
    names(
        &folder.microphone("wav", "sensitivity = \"50 mV/Pa\"").unwrap_err(),
        &words,
    );
    names(&folder.microphone("wav", "unit = \"Pa\"").unwrap_err(), &words);
    folder.write("N.csv", csv("t,N", &[&sine(1.0)]));
    names(
        &accelerometer(&folder, "csv", "column = \"N\"").unwrap_err(),
        &["N.csv", "channel N", "no calibration", "states a unit"],
    );
    folder.write("N.csv", csv("t,N [V]", &[&sine(1.0)]));
    names(
        &accelerometer(&folder, "csv", "column = \"N\"").unwrap_err(),
        &["no calibration", "`sensitivity` is missing"],
    );
}

#[test]
fn unknown_and_contradicting_units_are_refused() {
    let folder = Folder::new("units");
    let text = String::from_utf8(uff(&[&sine(1.0)])).unwrap();
    folder.write("N.uff", text.replace("m/s2                ", "parsec              "));
    names(
        &accelerometer(&folder, "uff", "").unwrap_err(),
        &["N.uff", "channel N", "\"parsec\"", "`unit` in the manifest"],
    );
    folder.write("N.uff", text.replace("m/s2                ", "Pa                  "));
    names(
        &accelerometer(&folder, "uff", "").unwrap_err(),
        &["\"Pa\"", "a pressure"],
    );
    folder.write("N.uff", &text);
    let error = accelerometer(&folder, "uff", "unit = \"g\"").unwrap_err();
    names(
        &error,
        &["N.uff", "channel N", "states the unit \"g\"", "the file \"m/s2\""],
    );
    // "EU" (engineering unit) contradicts nothing.
    folder.write("N.uff", text.replace("m/s2                ", "EU                  "));
    accelerometer(&folder, "uff", "unit = \"g\"").unwrap();
}

#[test]
fn samples_that_are_no_finite_numbers_are_refused() {
    let folder = Folder::new("not-finite");
    let mut signal = sine(0.1);
    // The writer refuses values that are not finite, so that the bytes of sample 100 are replaced.
    let mut bytes = encode(&[&signal], RATE, 1.0, Coding::Float32).unwrap();
    let at = bytes.len() - 4 * (SAMPLES - 99);
    bytes[at..at + 4].copy_from_slice(&f32::NAN.to_le_bytes());
    signal[99] = f64::NAN;
    assert!(encode(&[&signal], RATE, 1.0, Coding::Float32).is_err());
    folder.write("W-1-1.wav", bytes);
    let error = folder.microphone("wav", "full_scale = \"200 Pa\"").unwrap_err();
    names(&error, &["W-1-1.wav", "channel mic5", "sample 100 is NaN", "export"]);
    folder.write("N.csv", csv("t,N", &[&signal]));
    let error = accelerometer(&folder, "csv", "column = \"N\", unit = \"g\"").unwrap_err();
    names(&error, &["N.csv", "channel N", "line 101", "\"NaN\""]);
    signal[99] = f64::INFINITY;
    folder.write("N.uff", uff(&[&signal]));
    names(
        &accelerometer(&folder, "uff", "").unwrap_err(),
        &["N.uff", "channel N", "line 38", "inf"],
    );
    folder.write("N.uff", binary_uff(&signal, true, true));
    names(
        &accelerometer(&folder, "uff", "").unwrap_err(),
        &["N.uff", "channel N", "sample 100 is inf"],
    );
}

#[test]
fn an_uneven_time_axis_is_refused_at_its_sample() {
    let folder = Folder::new("uneven");
    let text = csv("t,N", &[&sine(1.0)]);
    let lines: Vec<&str> = text.lines().collect();
    // One sample is missing.
    let gap = [&lines[..101], &lines[102..]].concat().join("\n");
    folder.write("N.csv", gap);
    let error = accelerometer(&folder, "csv", "column = \"N\", unit = \"g\"").unwrap_err();
    names(
        &error,
        &["N.csv", "channel N", "uneven", "sample 101", "constant sampling rate"],
    );
    let still = text.replace(&format!("\n{}", lines[2]), "\n0,0");
    folder.write("N.csv", still);
    names(
        &accelerometer(&folder, "csv", "column = \"N\", unit = \"g\"").unwrap_err(),
        &["uneven"],
    );
    folder.write("N.csv", text.replacen("t,N", "x,N", 1));
    let error = accelerometer(&folder, "csv", "column = \"N\", unit = \"g\"").unwrap_err();
    names(&error, &["N.csv", "no column of times", "x, N", "time [s]"]);
}

#[test]
fn time_axes_of_one_shot_begin_together() {
    let folder = Folder::new("starts");
    folder.write("mic.csv", csv("t,mic5 [Pa]", &[&sine(1.0)]));
    folder.write(
        "N.csv",
        csv("t,N [g]", &[&sine(1.0)])
            .split_once('\n')
            .map(|(head, rest)| {
                let later = rest.lines().map(|line| {
                    let (time, value) = line.split_once(',').unwrap();
                    format!("{:.9},{value}\n", time.parse::<f64>().unwrap() + 0.02)
                });
                format!("{head}\n{}", later.collect::<String>())
            })
            .unwrap(),
    );
    let manifest = folder.load(&format!(
        "{HEAD}[channels]\nmic5 = {{ file = \"mic.csv\", column = \"mic5\", {CORNER} }}\nN = {{ file = \"N.csv\", \
         column = \"N\" }}\n{ONE}"
    ));
    names(
        &manifest.unwrap().shot(0, 0).unwrap_err(),
        &["N.csv", "channel N", "begins at 0.02 s", "mic.csv", "0 s"],
    );
}

#[test]
fn a_rate_below_25_khz_is_refused() {
    let folder = Folder::new("low-rate");
    folder.write(
        "W-1-1.wav",
        encode(&[&sine(0.1)], 24_000, 1.0, Coding::Integer24).unwrap(),
    );
    let error = folder.microphone("wav", "full_scale = \"200 Pa\"").unwrap_err();
    names(
        &error,
        &["W-1-1.wav", "channel mic5", "24000 Hz", "25000 Hz", "higher rate"],
    );
}

#[test]
fn a_record_shorter_than_the_shot_is_refused() {
    let folder = Folder::new("short");
    let needed = ((SHOT + 0.0125) * f64::from(RATE)).ceil() as usize;
    folder.write("W-1-1.wav", wav(&[&sine(0.1)[..needed]]));
    folder.microphone("wav", "full_scale = \"200 Pa\"").unwrap();
    folder.write("W-1-1.wav", wav(&[&sine(0.1)[..needed - 2]]));
    let error = folder.microphone("wav", "full_scale = \"200 Pa\"").unwrap_err();
    names(
        &error,
        &[
            "W-1-1.wav",
            "channel mic5",
            "ends 0.1500 s after the trigger",
            "0.15 s",
            "`trigger`",
        ],
    );
}

#[test]
fn records_of_different_lengths_are_cut_to_the_shortest() {
    let folder = Folder::new("lengths");
    folder.write("N.uff", uff(&[&sine(1.0)[..10_000]]));
    let shot = accelerometer(&folder, "uff", "").unwrap();
    assert_eq!(
        (shot.microphones[0].len(), shot.accelerations[0].len()),
        (10_000, 10_000)
    );
    assert!(difference(&shot.microphones[0], &tone(20.0, 500.0, 10_000)) < 1e-4);
}

#[test]
fn a_trigger_is_where_its_channel_crosses_the_threshold() {
    let folder = Folder::new("trigger");
    // Rest at 0.05 of full scale, then 0.55 within one sample: 2.5 V of 10 V is crossed at 0.4 of the step.
    let switch: Vec<f64> = (0..SAMPLES).map(|i| if i < 960 { 0.05 } else { 0.55 }).collect();
    folder.write("W-1-1.wav", wav(&[&sine(0.1), &switch]));
    let manifest = |threshold: &str| {
        format!(
            "{HEAD}[channels]\nmic5 = {{ file = \"{{c}}-{{k}}.wav\", full_scale = \"200 Pa\", {CORNER} }}\n\
             switch = {{ file = \"{{c}}-{{k}}.wav\", channel = 2, kind = \"trigger\", full_scale = \"10 V\" }}\n\
             [configurations]\nW-1 = {{ repeats = 1, trigger = {{ channel = \"switch\", threshold = \"{threshold}\" \
             }} }}\n"
        )
    };
    let loaded = folder.load(&manifest("2.5 V")).unwrap();
    let shot = loaded.shot(0, 0).unwrap();
    assert!(
        (shot.trigger - (959.0 + 0.4) / f64::from(RATE)).abs() < 1e-9,
        "{}",
        shot.trigger
    );
    assert!(shot.accelerations.is_empty() && loaded.accelerometers.is_empty());
    // A switch may run at full scale, which would be an overload of any other channel.
    let whole: Vec<f64> = (0..SAMPLES).map(|i| if i < 960 { 0.0 } else { 1.0 }).collect();
    folder.write("W-1-1.wav", wav(&[&sine(0.1), &whole]));
    loaded.shot(0, 0).unwrap();
    folder.write("W-1-1.wav", wav(&[&sine(0.1), &switch]));
    for never in ["6 V", "-1 V", "0.1 V"] {
        let error = folder.load(&manifest(never)).unwrap().shot(0, 0).unwrap_err();
        names(
            &error,
            &[
                "W-1-1.wav",
                "channel switch",
                "no trigger",
                "0.5000 to 5.5000 V",
                "`threshold`",
            ],
        );
    }
}

#[test]
fn a_table_above_the_limit_is_refused_before_it_is_read() {
    let folder = Folder::new("large");
    let file = std::fs::File::create(folder.path("W-1-1.csv")).unwrap();
    file.set_len(LARGEST + 1).unwrap();
    let error = folder
        .microphone("csv", "column = \"mic5\", unit = \"Pa\"")
        .unwrap_err();
    names(
        &error,
        &[
            "W-1-1.csv",
            "channel mic5",
            "at most 268 MB",
            "only WAV files may be larger",
        ],
    );
}

#[test]
fn samples_of_8_bits_are_read_around_their_offset() {
    let folder = Folder::new("width");
    let steps: Vec<i32> = (0..SAMPLES).map(|i| if i % 2 == 0 { 64 } else { -32 }).collect();
    folder.write("W-1-1.wav", hound(8, hound::SampleFormat::Int, &steps));
    let (_, shot) = folder.microphone("wav", "full_scale = \"128 Pa\"").unwrap();
    // One step is 1 Pa, up to the step between the definitions of full scale.
    let expected: Vec<f64> = steps.iter().map(|step| f64::from(*step)).collect();
    assert!(difference(&shot.microphones[0], &expected) < 1.0);
}

#[test]
fn a_value_beyond_full_scale_is_not_written_as_an_integer() {
    assert!(encode(&[&[0.0, 1.5]], RATE, 1.0, Coding::Integer24).is_err());
    assert!(encode(&[&[0.0, -1.0]], RATE, 1.0, Coding::Integer24).is_ok());
    assert!(encode(&[&[0.0], &[0.0, 0.0]], RATE, 1.0, Coding::Integer24).is_err());
    assert!(encode(&[], RATE, 1.0, Coding::Integer24).is_err());
}

/// `data/libsndfile-*.wav` were written by libsndfile (Python's soundfile): two channels, 0.5 sin(0.3 i) and half of
/// it.
#[test]
fn sound_files_of_another_program_are_read() {
    let files: [(&[u8], i32); 4] = [
        (include_bytes!("data/libsndfile-16.wav"), 16),
        (include_bytes!("data/libsndfile-24-extensible.wav"), 24),
        (include_bytes!("data/libsndfile-32-extensible.wav"), 32),
        (include_bytes!("data/libsndfile-float.wav"), 24),
    ];
    for (bytes, bits) in files {
        let tracks = decode(bytes, "a.wav".as_ref(), &[&Selector::Channel(1), &Selector::Channel(2)]).unwrap();
        for (track, amplitude) in tracks.iter().zip([0.5, 0.25]) {
            assert_eq!((track.rate, track.samples.len()), (48e3, 40));
            let expected: Vec<f64> = (0..40).map(|i| amplitude * (0.3 * f64::from(i)).sin()).collect();
            // It cuts off fractions of a step, and its full scale is a step larger.
            assert!(
                difference(&track.samples, &expected) < 1.5 * 2f64.powi(1 - bits),
                "{bits} bits"
            );
        }
    }
}
