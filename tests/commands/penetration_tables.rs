//! `nailnoise penetration`: its tables are read in each encoding, separator and unit, and a law is the same in all of
//! them.

use std::path::Path;

use crate::common::{folder, messages, nailnoise};

/// Force \[N\] at a depth \[m\]: a law of the first degree in the root, s = 0.3 x + 0.1 of a 6d nail in pine.
fn force(depth: f64) -> f64 {
    let x = (depth / 50.8e-3).max(0.0);
    if x > 0.0 {
        383_640.0 * 50.8e-3 * (0.1 + 0.3 * x).powi(2)
    } else {
        0.0
    }
}

/// Rows of time, depth and force in units of these sizes.
fn rows([time, depth, newton]: [f64; 3]) -> Vec<[String; 3]> {
    let row = |k: i32| {
        let y = f64::from(k - 20) * 50.8e-3 / 200.0;
        [f64::from(k) / 100.0 / time, y / depth, force(y) / newton].map(|value| format!("{value:.9}"))
    };
    (0..221).map(row).collect()
}

fn table(headings: &str, rows: &[[String; 3]]) -> String {
    let lines = rows.iter().map(|row| row.join(","));
    std::iter::once(headings.to_owned())
        .chain(lines)
        .collect::<Vec<_>>()
        .join("\n")
        + "\n"
}

const DRIVES: &str = "id,group,repeat,drive,nail,shank,wood,speed_m_s,file\n\
                      a1,a,1,1,6d,smooth,pine,8.333e-3,a1.csv\na2,a,2,1,6d,smooth,pine,8.333e-3,a2.csv\n";

/// Coefficients of the law that `prf fit` finds.
#[track_caller]
fn fitted(folder: &Path, name: &str) -> Vec<f64> {
    let (drives, out) = (folder.join("drives.csv"), folder.join("out"));
    let form = ["--form", "poly(x,1)", "--json", "--out", out.to_str().unwrap()];
    let output = nailnoise(&[&["prf", "fit", drives.to_str().unwrap()][..], &form].concat());
    assert_eq!(output.status.code(), Some(0), "{name}: {}", messages(&output));
    let law = std::fs::read_to_string(out.join("fit.toml")).unwrap();
    let law: toml::Table = law.parse().unwrap();
    let terms = law["terms"].as_array().unwrap().iter();
    terms.map(|term| term["coefficient"].as_float().unwrap()).collect()
}

#[test]
fn a_law_is_the_same_whatever_form_its_recordings_have() {
    let folder = folder("prf-tables");
    let plain = table("time_s,depth_m,force_n", &rows([1.0; 3]));
    let milli = rows([1e-3, 1e-3, 1e3]);
    let utf16 = |text: &str| {
        format!("\u{feff}{text}")
            .encode_utf16()
            .flat_map(u16::to_le_bytes)
            .collect::<Vec<u8>>()
    };
    let quoted = |line: &str| format!("\"{}\"\n", line.replace(',', "\",\""));
    let forms: [(&str, Vec<u8>); 9] = [
        ("plain", plain.clone().into_bytes()),
        ("mark", format!("\u{feff}{plain}").into_bytes()),
        ("Latin-1", [b"# Pr\xfcfung\n", plain.as_bytes()].concat()),
        ("UTF-16", utf16(&plain)),
        ("quotes", plain.lines().map(quoted).collect::<String>().into_bytes()),
        ("semicolon", plain.replace(',', ";").replace('.', ",").into_bytes()),
        ("tab", plain.replace(',', "\t").into_bytes()),
        ("units", table("Time [ms],Depth [mm],Force / kN", &milli).into_bytes()),
        ("suffixes", table("time_ms,depth_mm,force_kn", &milli).into_bytes()),
    ];
    let mut reference: Option<Vec<f64>> = None;
    for (name, bytes) in forms {
        std::fs::write(folder.join("a1.csv"), &bytes).unwrap();
        std::fs::write(folder.join("a2.csv"), plain.as_bytes()).unwrap();
        for drives in [DRIVES.as_bytes().to_vec(), utf16(&DRIVES.replace(',', ";"))] {
            std::fs::write(folder.join("drives.csv"), drives).unwrap();
            let found = fitted(&folder, name);
            // The cleaning of the start and the means of bins shift the law a little, and alike.
            let reference = reference.get_or_insert_with(|| found.clone());
            for ((found, same), expected) in found.iter().zip(reference.iter()).zip([0.1, 0.3]) {
                assert!((found - same).abs() < 1e-7, "{name}: {found} for {same}");
                assert!((found - expected).abs() < 0.02, "{name}: {found} for {expected}");
            }
        }
    }
}

#[test]
fn a_law_of_points_has_the_units_of_its_headings() {
    let folder = folder("prf-units");
    let force_at_25_mm = |name: &str, text: &str| {
        let (table, out) = (folder.join("law.csv"), folder.join("out"));
        std::fs::write(&table, text).unwrap();
        let files = ["--table", table.to_str().unwrap(), "--out", out.to_str().unwrap()];
        let output = nailnoise(
            &[
                &["prf", "law", "--nail", "6d", "--depth", "25 mm", "--json"][..],
                &files,
            ]
            .concat(),
        );
        assert!(output.status.success(), "{name}: {}", messages(&output));
        let result: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
        result["curves"][0]["rows"][0]["force"].as_f64().unwrap()
    };
    for (name, text) in [
        ("SI", "depth_m,force_n\n0,0\n0.025,950\n0.06,1700\n"),
        ("no headings", "0,0\n0.025,950\n0.06,1700\n"),
        ("other names", "x,F\n0,0\n0.025,950\n0.06,1700\n"),
        ("units", "Depth [mm];Force [kN]\n0;0\n25;0,95\n60;1,7\n"),
        ("swapped", "force_kn,depth_mm\n0,0\n0.95,25\n1.7,60\n"),
    ] {
        let found = force_at_25_mm(name, text);
        assert!((found - 950.0).abs() < 1e-9, "{name}: {found}");
    }
}
