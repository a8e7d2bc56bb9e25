//! Universal files: written files are read back, and damage is an error that names it.
#![allow(clippy::unwrap_used)] // a test may panic, in its helpers too

use std::path::PathBuf;

use nailnoise_meshes::uff::{self, Mode, UffError};
use nailnoise_meshes::{Block, Surface, block};
use nalgebra::Complex;

/// A file for one test, deleted at its end.
struct Scratch(PathBuf);

impl Scratch {
    fn new(name: &str) -> Self {
        let folder = std::env::temp_dir().join(format!("nailnoise-uff-{}-{name}", std::process::id()));
        std::fs::create_dir_all(&folder).unwrap();
        Self(folder.join("modes.uff"))
    }

    fn holding(name: &str, text: &str) -> Self {
        let own = Self::new(name);
        std::fs::write(&own.0, text).unwrap();
        own
    }
}

impl Drop for Scratch {
    fn drop(&mut self) {
        let _ = std::fs::remove_dir_all(self.0.parent().unwrap());
    }
}

fn written(name: &str) -> (Scratch, Surface, Vec<Vec<f64>>) {
    let mesh = block(&Block {
        size: [0.4, 0.15, 0.1],
        divisions: [3, 2, 1],
        origin: [-0.2, 0.0, 1e-3],
    })
    .unwrap();
    let surface = Surface::of(&mesh);
    let shapes: Vec<Vec<f64>> = (1..=3)
        .map(|mode| {
            (0..3 * mesh.nodes.len())
                .map(|dof| (dof as f64 * 0.37 + f64::from(mode)).sin() * 10f64.powi(mode - 3))
                .collect()
        })
        .collect();
    let file = Scratch::new(name);
    let modes: Vec<Mode<'_>> = shapes
        .iter()
        .zip([0.0, 1483.25, 9876.5])
        .map(|(shape, hz)| Mode {
            hz,
            loss_factor: 0.02,
            shape,
        })
        .collect();
    std::fs::write(&file.0, uff::text("block", &surface, &modes).unwrap()).unwrap();
    (file, surface, shapes)
}

#[test]
fn nodes_are_read_back() {
    let (file, surface, _) = written("nodes");
    let read = uff::read(&file.0).unwrap();
    assert_eq!(read.nodes.len(), surface.points.len());
    for (point, &node) in surface.points.iter().zip(&surface.volume_nodes) {
        // Sixteen digits after the point.
        assert!((read.nodes[&(node as u64 + 1)] - point).norm() < 1e-15);
    }
}

#[test]
fn modes_are_read_back() {
    let (file, surface, shapes) = written("modes");
    let read = uff::read(&file.0).unwrap();
    assert_eq!(read.modes.len(), 3);
    for ((mode, shape), hz) in read.modes.iter().zip(&shapes).zip([0.0, 1483.25, 9876.5]) {
        assert!((mode.hz - hz).abs() <= 1e-5 * hz);
        assert_eq!(mode.shape.len(), surface.points.len());
        for (label, u) in &mode.shape {
            for axis in 0..3 {
                let expected = shape[3 * (*label as usize - 1) + axis];
                assert!((u[axis].re - expected).abs() <= 1e-5 * expected.abs());
                assert_eq!(u[axis].im, 0.0);
            }
        }
    }
}

#[test]
fn a_shape_that_is_too_short_is_refused() {
    let (_file, surface, shapes) = written("short");
    let mode = Mode {
        hz: 1.0,
        loss_factor: 0.0,
        shape: &shapes[0][..30],
    };
    assert!(uff::text("block", &surface, &[mode]).is_err());
}

#[test]
fn measured_complex_modes_are_read_with_their_frequency_in_hertz() {
    let text = "    -1\n    55\na\nNONE\nNONE\nNONE\nNONE\n         1         3         2         8         5         \
        3\n         \
                2         6         1         1\n -6.28319E+00  6.28319D+02  0.0 0.0 0.0 0.0\n        17\n  1.0 0.5 \
                0.0 0.0 \
                -1.0 0.25\n    -1\n";
    let read = uff::read(&Scratch::holding("complex", text).0).unwrap();
    assert!(read.nodes.is_empty());
    assert!((read.modes[0].hz - 100.005).abs() < 1e-3, "{}", read.modes[0].hz);
    let expected = [Complex::new(1.0, 0.5), Complex::new(0.0, 0.0), Complex::new(-1.0, 0.25)];
    assert_eq!(read.modes[0].shape, [(17, expected)]);
}

/// The text of a correct file.
fn good(name: &str) -> String {
    std::fs::read_to_string(&written(name).0.0).unwrap()
}

#[test]
fn a_truncated_file_is_refused() {
    let good = good("truncated");
    let file = Scratch::holding("cut", &good[..good.len() / 2]);
    assert!(matches!(uff::read(&file.0), Err(UffError::Truncated { .. })));
}

#[test]
fn a_file_without_modes_is_refused() {
    let good = good("geometry");
    let geometry = good.split("    -1\n    55\n").next().unwrap();
    for text in [geometry, "no universal file"] {
        let file = Scratch::holding("modeless", text);
        assert!(matches!(uff::read(&file.0), Err(UffError::NoModes { .. })));
    }
    let results = format!("{geometry}{}", dataset(2414, " 1\nLOADCASE 1\n 1\n"));
    let error = uff::read(&Scratch::holding("results", &results).0)
        .unwrap_err()
        .to_string();
    assert!(
        error.contains("it has 1 of dataset 2414") && error.contains("as dataset 55"),
        "{error}"
    );
}

#[test]
fn a_missing_file_is_an_error() {
    let absent = Scratch::new("absent");
    assert!(matches!(uff::read(&absent.0), Err(UffError::Read { .. })));
}

#[test]
fn a_wrong_line_is_named_with_its_number_and_text() {
    let good = good("line");
    let line = good.lines().position(|line| line.contains("mode 1 at")).unwrap();
    let mut lines: Vec<&str> = good.lines().collect();
    lines[line + 3] = "  one hertz";
    let error = uff::read(&Scratch::holding("wrong", &lines.join("\n")).0).unwrap_err();
    assert!(
        matches!(error, UffError::Line { line: at, dataset: 55, .. } if at == line + 4),
        "{error}"
    );
    assert!(error.to_string().contains("one hertz"), "{error}");
}

#[test]
fn damaged_files_cause_no_panic() {
    let (file, ..) = written("damaged");
    let good = std::fs::read(&file.0).unwrap();
    let mut state = 1u64;
    // The generator of Knuth, The Art of Computer Programming 2, section 3.3.4.
    let mut next = |below: usize| {
        state = state
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1_442_695_040_888_963_407);
        ((state >> 33) % below as u64) as usize
    };
    let mut refused = 0;
    for _ in 0..100 {
        let mut bytes = good.clone();
        for _ in 0..=next(6) {
            let at = next(bytes.len());
            match next(4) {
                0 => bytes[at] = b"-1 eE.\n\0"[next(8)],
                1 => bytes.truncate(at.max(1)),
                2 => {
                    let end = (at + next(90)).min(bytes.len());
                    bytes.drain(at..end);
                }
                _ => bytes[at] = next(256) as u8,
            }
        }
        std::fs::write(&file.0, &bytes).unwrap();
        refused += usize::from(uff::read(&file.0).is_err());
    }
    assert!(refused > 30, "{refused}");
}

/// A dataset 58 of these values.
fn history(header: &str, axes: [&str; 2], values: &str) -> String {
    let axis = |text: &str| format!("{text}\n");
    let none = "         0    0    0    0 NONE                 NONE                \n";
    format!(
        "    -1\n    58\nforce\nNONE\nNONE\nNONE\nNONE\n    1         0    0         0 NONE                1   3 \
         NONE                0   0\n\
         {header}\n{}{}{none}{none}{values}\n    -1\n",
        axis(axes[0]),
        axis(axes[1])
    )
}

const TIME: &str = "        17    0    0    0 time                 s                   ";
/// The functions of a file, which can all be read.
#[track_caller]
fn read(bytes: &[u8]) -> Vec<uff::Function> {
    let all = uff::functions(bytes, "a.uff".as_ref()).into_iter();
    all.map(|function| function.unwrap()).collect()
}

/// Why the first function of a file cannot be read.
#[track_caller]
fn refused(bytes: &[u8]) -> UffError {
    uff::functions(bytes, "a.uff".as_ref()).swap_remove(0).unwrap_err()
}

const FORCE: &str = "        13    0    0    0 force                kN                  ";

#[test]
fn a_time_history_is_read_in_each_of_its_forms() {
    let even = history(
        "         4         3         1  1.00000e+00  5.00000e-01  0.00000e+00",
        [TIME, FORCE],
        "  1.000000000000e+00  2.000000000000e+00 -3.000000000000e+00",
    );
    let single = history(
        "         2         3         1  1.00000e+00  5.00000e-01  0.00000e+00",
        [TIME, FORCE],
        "  1.00000e+00  2.00000e+00 -3.00000e+00",
    );
    let uneven = history(
        "         2         3         0  0.00000e+00  0.00000e+00  0.00000e+00",
        [TIME, FORCE],
        "  1.00000e+00  1.00000e+00  1.50000e+00  2.00000e+00\n  2.00000e+00 -3.00000e+00",
    );
    // Fields of 13 and 20 columns that run together.
    let close = history(
        "         4         3         0  0.00000e+00  0.00000e+00  0.00000e+00",
        [TIME, FORCE],
        " 1.00000e+000 1.00000000000000e+00 1.50000e+000 2.00000000000000e+00\n 2.00000e+000-3.0000000000000e+00",
    );
    for text in [even, single, uneven, close] {
        let found = read(text.as_bytes());
        assert_eq!(found.len(), 1);
        assert_eq!(found[0].abscissa, [1.0, 1.5, 2.0], "{text}");
        assert_eq!(found[0].ordinate, [1.0, 2.0, -3.0], "{text}");
        assert_eq!(
            (found[0].kinds, found[0].units.clone()),
            ([17, 13], ["s".to_owned(), "kN".to_owned()])
        );
        assert_eq!(found[0].lines[0], 14);
    }
}

#[test]
fn damaged_time_histories_name_their_line() {
    let header = "         4         3         1  1.00000e+00  5.00000e-01  0.00000e+00";
    let few = history(header, [TIME, FORCE], "  1.0  2.0");
    let text = history(header, [TIME, FORCE], "  1.0  2.0 none");
    let complex = history(&header.replacen('4', "6", 1), [TIME, FORCE], "  1.0  2.0 3.0");
    let binary = few.replacen("    58\n", "    58b     1     2\n", 1);
    for (text, line) in [
        (few, "line 9"),
        (text, "line 14"),
        (complex, "line 1"),
        (binary, "line 1"),
    ] {
        let error = refused(text.as_bytes()).to_string();
        assert!(error.contains(line), "{error}");
    }
}

#[test]
fn a_function_is_read_whatever_the_others_of_its_file_are() {
    let even = |data: u32| format!("{data:10}         3         1  1.00000e+00  5.00000e-01  0.00000e+00");
    let good = history(&even(2), [TIME, FORCE], "  1.00000e+00  2.00000e+00 -3.00000e+00");
    let complex = history(&even(5), [TIME, FORCE], "  1.0  2.0  3.0  4.0  5.0  6.0");
    let unknown = "    -1\n  1858\nanything\n    -1\n    -1\n   999b  7\nanything\n    -1\n";
    let cut = "    -1\n   151\nmodel\n";
    for (before, channels) in [
        (&complex, 2),
        (&history(&even(7), [TIME, FORCE], "1.0"), 2),
        (&unknown.to_owned(), 1),
    ] {
        let file = [before, good.as_str(), cut].concat();
        let all = uff::functions(file.as_bytes(), "a.uff".as_ref());
        assert_eq!(
            all[channels - 1].as_ref().unwrap().ordinate,
            [1.0, 2.0, -3.0],
            "{before}"
        );
        // The file is cut off behind it, which is an error of a dataset that may have been there.
        assert!(matches!(all[channels], Err(UffError::Truncated { dataset: 151, .. })));
    }
}

#[test]
fn letters_beyond_ascii_are_read_in_each_encoding() {
    let header = "         2         3         1  1.00000e+00  5.00000e-01  0.00000e+00";
    let text = history(
        header,
        [TIME, &FORCE.replacen("kN", "m/s² ", 1)],
        "  1.00000e+00  2.00000e+00 -3.00000e+00",
    );
    let latin: Vec<u8> = text.chars().map(|letter| letter as u8).collect();
    let utf16: Vec<u8> = text.encode_utf16().flat_map(u16::to_le_bytes).collect();
    for bytes in [
        text.clone().into_bytes(),
        latin,
        [&b"\xef\xbb\xbf"[..], text.as_bytes()].concat(),
        [&b"\xff\xfe"[..], &utf16].concat(),
    ] {
        assert!(uff::is_universal(&bytes));
        assert_eq!(read(&bytes)[0].units[1], "m/s²");
    }
}

/// A binary dataset of the samples 1, 2, -3 at 1, 1.5 and 2 s with this header and these bytes.
fn binary(data: u32, even: u32, order: u32, format: u32, bytes: &[u8]) -> Vec<u8> {
    let header = format!("{data:10}         3{even:10}  1.00000e+00  5.00000e-01  0.00000e+00");
    let text = history(&header, [TIME, FORCE], "");
    let kind = format!(
        "    58b{order:6}{format:6}{:12}{:12}     0     0           0           0",
        11,
        bytes.len()
    );
    let text = text.replacen("    58", &kind, 1);
    let text = text.strip_suffix("\n    -1\n").unwrap();
    [text.as_bytes(), bytes, b"\n    -1\n"].concat()
}

/// Samples as bytes, each with its time where that is not even.
fn bytes(times: bool, number: impl Fn(f64) -> Vec<u8>, time: impl Fn(f64) -> Vec<u8>) -> Vec<u8> {
    let samples = [(1.0, 1.0), (1.5, 2.0), (2.0, -3.0)];
    let pair = |(x, y)| [if times { time(x) } else { Vec::new() }, number(y)].concat();
    samples.into_iter().flat_map(pair).collect()
}

#[test]
fn a_binary_time_history_is_read_in_each_of_its_forms() {
    let single = |x: f64| (x as f32).to_le_bytes().to_vec();
    let single_big = |x: f64| (x as f32).to_be_bytes().to_vec();
    let double = |x: f64| x.to_le_bytes().to_vec();
    let double_big = |x: f64| x.to_be_bytes().to_vec();
    let files = [
        binary(4, 1, 1, 2, &bytes(false, double, double)),
        binary(4, 1, 2, 2, &bytes(false, double_big, double)),
        binary(2, 1, 1, 2, &bytes(false, single, single)),
        binary(2, 1, 2, 2, &bytes(false, single_big, single)),
        binary(2, 0, 1, 2, &bytes(true, single, single)),
        // The times of double precision are in single precision, or as some programs write them in double.
        binary(4, 0, 1, 2, &bytes(true, double, single)),
        binary(4, 0, 2, 2, &bytes(true, double_big, double_big)),
    ];
    for (index, file) in files.iter().enumerate() {
        // Another dataset behind it is found whatever the bytes are.
        let second = history(
            "         2         3         1  1.00000e+00  5.00000e-01  0.00000e+00",
            [TIME, FORCE],
            "  1.00000e+00  2.00000e+00 -3.00000e+00",
        );
        let found = read(&[file, second.as_bytes()].concat());
        assert_eq!(found.len(), 2, "{index}");
        for function in &found {
            assert_eq!(function.abscissa, [1.0, 1.5, 2.0], "{index}");
            assert_eq!(function.ordinate, [1.0, 2.0, -3.0], "{index}");
            assert_eq!(function.units, ["s", "kN"]);
        }
    }
}

#[test]
fn the_mark_of_an_end_among_the_bytes_ends_no_dataset() {
    let bytes: Vec<u8> = b"\n    -1\n    -1\n    -1\n  ".iter().copied().take(24).collect();
    let found = read(&binary(4, 1, 1, 2, &bytes));
    let expected: Vec<f64> = bytes
        .chunks_exact(8)
        .map(|word| f64::from_le_bytes(word.try_into().unwrap()))
        .collect();
    assert_eq!(found[0].ordinate, expected);
}

#[test]
fn damaged_binary_time_histories_are_refused() {
    let good = bytes(false, |x| x.to_le_bytes().to_vec(), |x| x.to_le_bytes().to_vec());
    let vax = refused(&binary(4, 1, 1, 1, &good)).to_string();
    assert!(vax.contains("line 1") && vax.contains("IEEE 754"), "{vax}");
    let few = refused(&binary(4, 1, 1, 2, &good[..16])).to_string();
    assert!(few.contains("line 9") && few.contains("bytes"), "{few}");
    let whole = binary(4, 1, 1, 2, &good);
    let cut = refused(&whole[..whole.len() - 12]);
    assert!(
        matches!(
            cut,
            UffError::Truncated {
                line: 1,
                dataset: 58,
                ..
            }
        ),
        "{cut}"
    );
    let nan = [&good[..8], &f64::NAN.to_le_bytes(), &good[16..]].concat();
    let nan = refused(&binary(4, 1, 1, 2, &nan)).to_string();
    assert!(nan.contains("sample 2 is NaN"), "{nan}");
}

/// `data/pyuff-58b.uff` was written by pyuff 2.5.8: two binary datasets and one in text, k 5 sin(0.3 i) for k = 1, 2, 3
/// at 48 kHz.
#[test]
fn a_file_of_another_program_is_read() {
    let bytes = include_bytes!("../data/pyuff-58b.uff");
    let found = read(bytes);
    assert_eq!(found.len(), 3);
    for (k, function) in (1..).zip(&found) {
        assert_eq!(function.kinds, [17, 12]);
        assert_eq!(function.units, ["s", "m/s2"]);
        assert_eq!(function.ordinate.len(), 40);
        for (i, (time, value)) in (0..).zip(function.abscissa.iter().zip(&function.ordinate)) {
            // Six digits of the interval; twelve of the samples in text.
            assert!((time - f64::from(i) / 48e3).abs() <= 2e-6 * time);
            assert!((value - f64::from(k) * 5.0 * (0.3 * f64::from(i)).sin()).abs() < 1e-10);
        }
    }
}

/// A file of one mode with nodes as given.
fn with_nodes(nodes: &str) -> Result<uff::Measurement, UffError> {
    let mode = "    -1\n    55\nNONE\nNONE\nNONE\nNONE\nNONE\n 1 2 2 8 2 3\n 2 4 1 1\n 100.0 1.0 0.0 0.02\n 7\n 1.0 \
        2.0 3.0\n    -1\n";
    uff::parse(format!("{nodes}{mode}").as_bytes(), std::path::Path::new("test.uff"))
}

fn dataset(number: u32, lines: &str) -> String {
    format!("    -1\n{number:6}\n{lines}    -1\n")
}

/// System 3: origin (1, 2, 3), x along global z, z along global x, so that y = -global y.
const SYSTEM_18: &str = " 3 0 0 8 1\nname\n 1.0 2.0 3.0 1.0 2.0 4.0\n 2.0 2.0 3.0\n";
const SYSTEM_2420: &str = " 1\npart\n 3 0 8\nname\n 0.0 0.0 1.0\n 0.0 -1.0 0.0\n 1.0 0.0 0.0\n 1.0 2.0 3.0\n";

#[test]
fn coordinates_and_axes_of_nodes_in_local_systems_are_global() {
    let turned = nalgebra::Matrix3::new(0.0, 0.0, 1.0, 0.0, -1.0, 0.0, 1.0, 0.0, 0.0);
    for (systems, given) in [(18, SYSTEM_18), (2420, SYSTEM_2420)] {
        for (nodes, lines) in [
            (15, " 7 3 3 11 0.1 0.2 0.3\n"),
            (2411, " 7 3 3 11\n 0.1 0.2 0.3\n"),
            (781, " 7 3 3 11\n 1.0D-1 2.0D-1 3.0D-1\n"),
        ] {
            let (systems, nodes) = (dataset(systems, given), dataset(nodes, lines));
            for text in [format!("{systems}{nodes}"), format!("{nodes}{systems}")] {
                let read = with_nodes(&text).unwrap();
                let expected = nalgebra::Point3::new(1.3, 1.8, 3.1);
                assert!((read.nodes[&7] - expected).norm() < 1e-12, "{:?}", read.nodes);
                assert!((read.axes[&7] - turned).amax() < 1e-12, "{:?}", read.axes);
            }
        }
    }
    let global = with_nodes(&dataset(15, " 7 0 0 11 0.1 0.2 0.3\n")).unwrap();
    assert!(global.axes.is_empty());
}

#[test]
fn a_system_in_terms_of_another_one_is_carried_on_to_the_global_one() {
    // System 4 is turned by 90 degrees about the z of system 3 and shifted by 1 along its x.
    let second = " 4 0 3 8 1\nname\n 1.0 0.0 0.0 1.0 1.0 0.0\n 1.0 0.0 1.0\n";
    let read =
        with_nodes(&(dataset(18, &format!("{second}{SYSTEM_18}")) + &dataset(15, " 7 4 4 11 1.0 0.0 0.0\n"))).unwrap();
    // Local (1, 0, 0) is (1, 1, 0) in system 3: the origin (1, 2, 3), 1 along global z and 1 against global y.
    assert!(
        (read.nodes[&7] - nalgebra::Point3::new(1.0, 1.0, 4.0)).norm() < 1e-12,
        "{:?}",
        read.nodes
    );
    let x = read.axes[&7].row(0).transpose();
    assert!((x - nalgebra::Vector3::new(0.0, -1.0, 0.0)).norm() < 1e-12, "{x}");
}

#[test]
fn displacements_in_a_cylindrical_system_have_the_directions_at_their_node() {
    let cylinder = " 3 1 0 8 1\nname\n 0.0 0.0 0.0 1.0 0.0 0.0\n 1.0 0.0 1.0\n";
    let read = with_nodes(&(dataset(18, cylinder) + &dataset(15, " 7 0 3 11 0.0 2.0 1.0\n"))).unwrap();
    // At 90 degrees the radius is along y and the angle against x.
    let expected = nalgebra::Matrix3::new(0.0, 1.0, 0.0, -1.0, 0.0, 0.0, 0.0, 0.0, 1.0);
    assert!((read.axes[&7] - expected).amax() < 1e-12, "{:?}", read.axes);
    let error = with_nodes(&(dataset(18, cylinder) + &dataset(15, " 7 3 0 11 0.0 2.0 1.0\n"))).unwrap_err();
    assert!(error.to_string().contains("cylindrical system"), "{error}");
}

#[test]
fn a_file_in_millimetres_is_read_in_metres() {
    let units = dataset(164, " 5mm (newton) 2\n 1.0D+03 1.0D+00 1.0D+00\n 2.7315D+02\n");
    let read = with_nodes(&(dataset(15, " 7 0 0 11 100.0 200.0 300.0\n") + &units)).unwrap();
    assert!(
        (read.nodes[&7] - nalgebra::Point3::new(0.1, 0.2, 0.3)).norm() < 1e-12,
        "{:?}",
        read.nodes
    );
}

#[test]
fn a_system_that_cannot_be_used_is_refused() {
    let node =
        |definition: u32, displacement: u32| dataset(15, &format!(" 7 {definition} {displacement} 11 0.1 0.2 0.3\n"));
    let second = |systems: &str| dataset(18, systems) + &node(0, 3);
    for (text, expected) in [
        (
            node(0, 1),
            "line 3, dataset 15: the node names coordinate system 1, which the file does not give (known: none)",
        ),
        (node(5, 0), "coordinate system 5"),
        (dataset(2411, " 7 2 1 11\n 0.1 0.2 0.3\n"), "coordinate system 2"),
        (dataset(18, SYSTEM_18) + &node(0, 4), "(known: 3)"),
        (
            second(&SYSTEM_18.replace(" 3 0 0 8 1", " 3 3 0 8 1")),
            "a Cartesian (0), cylindrical (1) or spherical (2)",
        ),
        (
            second(&SYSTEM_18.replace(" 3 0 0 8 1", " 3 2 0 8 1")),
            "spherical coordinate system (kind 2)",
        ),
        (
            dataset(2420, &SYSTEM_2420.replace(" 3 0 8", " 3 2 8")) + &node(3, 0),
            "export the nodes in global axes",
        ),
        (second(&SYSTEM_18.replace(" 3 0 0 8 1", " 3 0 0 8 2")), "method 1"),
        (
            second(&SYSTEM_18.replace(" 3 0 0 8 1", " 3 0 3 8 1")),
            "leads back to itself",
        ),
        (
            second(&SYSTEM_18.replace(" 3 0 0 8 1", " 3 0 9 8 1")),
            "coordinate system 9",
        ),
        (
            second(&SYSTEM_18.replace(" 2.0 2.0 3.0", " 1.0 2.0 5.0")),
            "not on one line",
        ),
        (
            dataset(2420, &SYSTEM_2420.replace(" 0.0 -1.0 0.0", " 0.0 -2.0 0.0")) + &node(0, 3),
            "unit vectors",
        ),
        (
            dataset(2420, &SYSTEM_2420.replace(" 0.0 -1.0 0.0", " 0.0 1.0 0.0")) + &node(0, 3),
            "right-handed",
        ),
    ] {
        let error = with_nodes(&text).expect_err(expected).to_string();
        assert!(error.contains(expected), "{error}");
    }
    // A spherical system that no node is in.
    assert!(with_nodes(&(dataset(18, &SYSTEM_18.replace(" 3 0 0 8 1", " 3 2 0 8 1")) + &node(0, 0))).is_ok());
    // The label of the global system in the files of `modes --uff`.
    assert!(with_nodes(&dataset(2411, " 7 1 1 11\n 0.1 0.2 0.3\n")).is_ok());
}

#[test]
fn units_of_the_file_are_those_of_dataset_164() {
    let path = std::path::Path::new("test.uff");
    let units = |text: &str| uff::units(text.as_bytes(), path);
    let own = |length: &str| {
        dataset(
            164,
            &format!("         9user units                   2\n  {length}  1.0D-03  1.0D+00\n  2.73D+02\n"),
        )
    };
    assert_eq!(units(&own("1.0D+03")).unwrap(), Some([1e-3, 1e3]));
    assert_eq!(units(&dataset(15, " 7 0 0 11 0.1 0.2 0.3\n")).unwrap(), None);
    for impossible in ["0.0D+00", "-1.0D+00", "1.0D+300"] {
        let error = units(&own(impossible)).unwrap_err().to_string();
        assert!(error.contains("factors of the units"), "{error}");
    }
}
