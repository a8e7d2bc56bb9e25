//! Keys of a manifest: each fault is refused with file, line, key, value and remedy.

use crate::written::{CORNER, Folder, HEAD, ONE, names, sine, wav};
use nailnoise_measurement::{Manifest, MeasurementError, Setup, Trigger};

const CHANNEL: &str = "file = \"{c}-{k}.wav\", full_scale = \"200 Pa\"";

/// A manifest of one microphone.
fn text() -> String {
    format!("{HEAD}[channels]\nmic5 = {{ {CHANNEL}, {CORNER} }}\n{ONE}")
}

fn parse(text: &str) -> Result<Manifest, MeasurementError> {
    Manifest::parse(text, "test.toml".as_ref())
}

/// Asserts that the manifest with one part replaced is refused at this line with these words.
fn refused(from: &str, to: &str, line: usize, words: &[&str]) {
    let text = text();
    assert!(text.contains(from), "{from}");
    let error = parse(&text.replacen(from, to, 1)).unwrap_err();
    names(&error, words);
    names(&error, &["test.toml"]);
    assert_eq!(error.place().unwrap().line(), line, "{error}");
}

#[test]
fn a_manifest_is_read_in_si_units() {
    let manifest = parse(
        "setup = \"sandbox\"\ncentre = [0, 0, \"572.5 mm\"]\nplane = \"sand\"\nsand_height = \"400 mm\"\n\
         temperature = \"21 degC\"\nstatic_pressure = \"100 kPa\"\nabsorption = \"200 m2\"\n[channels]\n\
         PT-I = { file = \"{c}-{k}.uff\", unit = \"kPa\" }\n\
         mic9 = { file = \"{c}-{k}.wav\", channel = 2, sensitivity = \"50 mV/Pa\", full_scale = \"10 V\", \
         position = [0, 0, 1.5725] }\n\
         N = { file = \"{c}-{k}.csv\", column = \"N [g]\" }\n\
         mic1 = { file = \"{c}-{k}.wav\", full_scale = \"200 Pa\", position = [1, 0, 0.98] }\n\
         SE = { file = \"{c}-{k}.uff\", channel = 2, unit = \"g\" }\n\
         switch = { file = \"{c}-{k}.wav\", channel = 3, kind = \"trigger\", full_scale = \"10 V\" }\n\
         [configurations]\n\
         S-2 = { repeats = 5, trigger = { channel = \"switch\", threshold = \"2.5 V\" } }\n\
         S-1 = { repeats = 6, trigger = \"12.5 ms\" }\n",
    )
    .unwrap();
    assert_eq!(manifest.setup, Setup::Sandbox);
    assert_eq!(manifest.centre, [0.0, 0.0, 0.5725]);
    assert_eq!(manifest.plane, 0.4);
    assert_eq!(manifest.temperature, 294.15);
    assert_eq!(manifest.static_pressure, 100e3);
    assert_eq!(manifest.absorption, Some(200.0));
    let names: Vec<&str> = manifest.microphones.iter().map(|own| own.name.as_str()).collect();
    assert_eq!(names, ["mic1", "mic9"]);
    assert_eq!(manifest.microphones[1].position, [0.0, 0.0, 1.5725]);
    assert_eq!(manifest.accelerometers, ["N", "SE"]);
    assert_eq!(manifest.pressures, ["PT-I"]);
    let [first, second] = manifest.configurations.as_slice() else {
        panic!()
    };
    assert_eq!((first.name.as_str(), first.number, first.repeats), ("S-1", 1, 6));
    assert_eq!(first.trigger, Trigger::At(0.0125));
    let switched = Trigger::Channel {
        name: "switch".to_owned(),
        threshold: 2.5,
    };
    assert_eq!((second.name.as_str(), second.number), ("S-2", 2));
    assert_eq!(second.trigger, switched);
}

#[test]
fn what_is_optional_has_the_standard_value() {
    let manifest = parse(&text()).unwrap();
    assert_eq!(manifest.static_pressure, 101_325.0);
    assert_eq!(manifest.absorption, None);
    assert_eq!(manifest.plane, 0.0);
}

#[test]
fn text_that_is_no_toml_is_refused_at_its_line() {
    let error = parse("setup = \"worktable\"\ncentre = [0, 0\n").unwrap_err();
    assert!(matches!(error, MeasurementError::Document(_)));
    names(&error, &["TOML"]);
}

#[test]
fn an_unknown_key_is_refused_with_the_nearest_one() {
    refused("plane =", "plan =", 3, &["`plan`", "is it `plane`?"]);
    refused(
        "full_scale",
        "full_scal",
        6,
        &["`channels.mic5.full_scal`", "is it `full_scale`?"],
    );
    refused(
        "repeats",
        "repeat",
        8,
        &["`configurations.W-1.repeat`", "is it `repeats`?"],
    );
}

#[test]
fn a_missing_key_is_refused_with_an_example() {
    refused("setup = \"worktable\"\n", "", 1, &["`setup` is missing", "worktable"]);
    refused(
        "temperature = \"21 degC\"\n",
        "",
        1,
        &["`temperature` is missing", "21 degC"],
    );
    refused("file = \"{c}-{k}.wav\", ", "", 6, &["`channels.mic5.file` is missing"]);
    refused(&format!(", {CORNER}"), "", 6, &["`channels.mic5.position` is missing"]);
}

#[test]
fn a_value_outside_its_limits_is_refused_with_its_unit() {
    refused("\"21 degC\"", "21", 4, &["`temperature` is 21 K", "SI units"]);
    refused(
        "\"21 degC\"",
        "\"21 Pa\"",
        4,
        &["`temperature` is \"21 Pa\"", "a pressure"],
    );
    refused("[0, 0, 0.938]", "[0, 0]", 2, &["`centre`", "three lengths"]);
    refused("[0, 0, 0.938]", "[0, 0, nan]", 2, &["`centre`", "not finite"]);
    refused(
        "\"200 Pa\"",
        "\"-200 Pa\"",
        6,
        &["`channels.mic5.full_scale` is -2e2 Pa", "outside 1e-6 to 1e10 Pa"],
    );
    refused("\"200 Pa\"", "\"200 parsec\"", 6, &["200 parsec", "Pa, kPa"]);
    refused("\"12.5 ms\"", "-0.1", 8, &["`configurations.W-1.trigger` is -0.1 s"]);
    refused(
        "repeats = 1",
        "repeats = 0",
        8,
        &["`configurations.W-1.repeats` is the number 0", "from 1"],
    );
}

#[test]
fn a_configuration_belongs_to_its_setup() {
    refused("W-1", "S-1", 8, &["`configurations.S-1`", "W-1, W-2"]);
    refused("W-1", "W-6", 8, &["`configurations.W-6`", "W-5"]);
    refused(
        "W-1 = { repeats = 1, trigger = \"12.5 ms\" }",
        "",
        7,
        &["has no configuration", "W-1, W-2"],
    );
}

#[test]
fn a_source_is_not_measured_without_the_residual() {
    refused(
        "W-1",
        "W-3",
        8,
        &["`configurations.W-3` needs the residual W-2", "record W-2"],
    );
}

#[test]
fn a_trigger_is_needed_and_refers_to_a_channel() {
    refused(
        ", trigger = \"12.5 ms\"",
        "",
        8,
        &["`configurations.W-1.trigger` is missing", "threshold"],
    );
    let channel = "{ channel = \"button\", threshold = \"2.5 V\" }";
    refused(
        "\"12.5 ms\"",
        channel,
        8,
        &["\"button\", which is not a channel", "mic5"],
    );
    refused(
        "\"12.5 ms\"",
        "{ channel = \"mic5\" }",
        8,
        &["`configurations.W-1.trigger.threshold` is missing"],
    );
    refused(
        "\"12.5 ms\"",
        "{ channel = \"mic5\", threshold = \"2 g\" }",
        8,
        &["2 g", "a mass"],
    );
}

#[test]
fn a_microphone_is_on_the_measurement_surface() {
    refused(
        "[1, 1, 1.938]",
        "[1, 1.06, 1.938]",
        6,
        &["`channels.mic5.position` is 0.060 m off", "box", "1.938 m"],
    );
    refused("[1, 1, 1.938]", "[0.2, 0.1, 1.0]", 6, &["is 0.800 m off"]);
    refused("[1, 1, 1.938]", "[1, 0, -0.06]", 6, &["is 0.060 m off"]);
    for near in [
        "[1, 1.04, 1.9]",
        "[\"96 cm\", 0, 0.969]",
        "[0.3, 0.2, 1.98]",
        "[-1, 0, -0.04]",
    ] {
        parse(&text().replace("[1, 1, 1.938]", near)).unwrap();
    }
}

#[test]
fn the_centre_is_above_the_reflecting_plane() {
    refused(
        "\"floor\"",
        "1.0",
        2,
        &["`centre` is 0.062 m below the reflecting plane", "plane"],
    );
}

#[test]
fn sand_belongs_to_a_sandbox_with_its_height() {
    refused("\"floor\"", "\"sand\"", 3, &["`plane` is \"sand\"", "sand_height"]);
    refused(
        "plane = \"floor\"",
        "plane = 0\nsand_height = 0.4",
        4,
        &["`sand_height` belongs to setup"],
    );
    refused("\"floor\"", "\"carpet\"", 3, &["`plane` is \"carpet\"", "floor"]);
}

#[test]
fn microphones_have_the_numbers_of_the_standard() {
    for name in ["mic0", "mic10", "mic"] {
        refused(
            "mic5 ",
            &format!("{name} "),
            6,
            &[&format!("`channels.{name}` is not a microphone"), "mic1 to mic9"],
        );
    }
    refused("mic5 ", "N ", 6, &["`channels.N.position` belongs to microphones"]);
    refused(
        &format!("mic5 = {{ {CHANNEL}, {CORNER}"),
        &format!("N = {{ {}", CHANNEL.replace("200 Pa", "9 g")),
        5,
        &["no microphone"],
    );
}

#[test]
fn a_channel_is_calibrated_in_one_way() {
    refused("\"200 Pa\"", "\"10 V\"", 6, &["is in V", "`sensitivity`"]);
    refused(
        "full_scale = \"200 Pa\"",
        "full_scale = \"200 Pa\", sensitivity = \"50 mV/Pa\"",
        6,
        &["is not a voltage", "in V"],
    );
    refused(
        "full_scale = \"200 Pa\"",
        "sensitivity = \"50 mV/N\", full_scale = \"10 V\"",
        6,
        &["50 mV/N", "a sensitivity to pressure"],
    );
    refused(
        "\"200 Pa\"",
        "\"200 Pa\", calibrator = { file = \"k.wav\", level = \"94 dB\" }",
        6,
        &["is given in addition to `calibrator`"],
    );
    refused(
        "full_scale = \"200 Pa\"",
        "calibrator = { file = \"k.wav\", level = 94 }",
        6,
        &["`channels.mic5.calibrator.level`", "94 dB"],
    );
    refused(
        "full_scale = \"200 Pa\"",
        "unit = \"g\"",
        6,
        &["`channels.mic5.unit` is \"g\"", "Pa, kPa"],
    );
}

#[test]
fn each_shot_has_its_own_file() {
    refused("{c}-{k}.wav", "{c}-{x}.wav", 6, &["{x}", "{k} the repeat"]);
    let five = text().replace("repeats = 1", "repeats = 5").replace("-{k}", "");
    names(&parse(&five).unwrap_err(), &["{c}.wav", "for all repeats", "{k}"]);
    let two = text().replace("{c}-", "") + "W-2 = { repeats = 1, trigger = 0 }\n";
    names(&parse(&two).unwrap_err(), &["{k}.wav", "for all configurations", "{c}"]);
}

#[test]
fn a_missing_repeat_is_refused_with_its_file_and_channel() {
    let folder = Folder::new("missing");
    folder.write("W-1-1.wav", wav(&[&sine(0.1)]));
    let error = folder.load(&text().replace("repeats = 1", "repeats = 2")).unwrap_err();
    names(&error, &["W-1-2.wav", "channel mic5", "`repeats`"]);
}

#[test]
fn a_manifest_that_is_no_file_is_refused() {
    let folder = Folder::new("absent");
    names(
        &Manifest::load(&folder.path("test.toml")).unwrap_err(),
        &["test.toml", "TOML file"],
    );
    names(&Manifest::load(&folder.path("")).unwrap_err(), &["folder"]);
    #[cfg(unix)]
    names(&Manifest::load("/dev/zero".as_ref()).unwrap_err(), &["device"]);
}

#[test]
fn a_recording_that_is_no_file_is_refused() {
    let folder = Folder::new("folder");
    std::fs::create_dir(folder.path("W-1-1.wav")).unwrap();
    names(&folder.load(&text()).unwrap_err(), &["W-1-1.wav", "not a regular file"]);
}

#[test]
fn few_repeats_are_a_warning() {
    let warnings = parse(&text()).unwrap().warnings;
    assert!(
        warnings.iter().any(|own| own.contains("W-1 has 1 shot")),
        "{warnings:?}"
    );
    let warnings = parse(&text().replace("repeats = 1", "repeats = 5")).unwrap().warnings;
    assert!(!warnings.iter().any(|own| own.contains("has 5 shots")), "{warnings:?}");
}

#[test]
fn what_a_test_lacks_is_a_warning() {
    let warnings = parse(&text()).unwrap().warnings.join("\n");
    for word in ["W-4 is not in the manifest: the body", "1 of the 9 microphones"] {
        assert!(warnings.contains(word), "{warnings}");
    }
    assert!(!warnings.contains("clipped"), "{warnings}");
    let warnings = parse(&text().replace("full_scale = \"200 Pa\"", "unit = \"Pa\""))
        .unwrap()
        .warnings
        .join("\n");
    assert!(
        warnings.contains("a clipped record is not recognised: mic5"),
        "{warnings}"
    );
}
