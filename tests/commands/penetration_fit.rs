//! `nailnoise penetration fit`: damaged and impossible data are refused with file, line and remedy.

use std::fs;
use std::path::Path;

use crate::common::{folder, messages, nailnoise, over};

/// Two conditions of two drives each by a testing machine, and one of two drives by a projectile.
const DRIVES: &str = "\
id,group,repeat,drive,nail,shank,length_m,diameter_m,nail_mass_kg,wood,hardness_modulus_n_m,density_kg_m3,\
speed_m_s,projectile_mass_kg,impact_speed_m_s,mass_ahead_of_cell_kg,file
a1,a,1,1,6d,smooth,,,,pine,,,8.333e-3,,,,a1.csv
a2,a,2,1,6d,smooth,,,,pine,,,8.333e-3,,,,a2.csv
b1,b,1,1,6d,smooth,,,,pine,,,3.333e-4,,,,b1.csv
b2,b,2,1,6d,smooth,,,,pine,,,3.333e-4,,,,b2.csv
";

/// A row of a nail struck by a projectile.
const IMPACT: &str = "c1,c,1,1,12d,smooth,,,0.0078,pine,,,,0.131,25,0,c1.csv\n";

/// Depth and force of a 6d nail in pine, from before the contact.
fn recording(deviation: f64) -> String {
    let mut text = "time_s,depth_m,force_n\n".to_owned();
    for k in 0..220 {
        let depth = (f64::from(k) - 20.0) * 50.8e-3 / 200.0;
        let x: f64 = (depth / 50.8e-3).max(0.0);
        let root = if x > 0.0 {
            0.9 * x.sqrt() * (1.0 - 0.5 * x) * (0.3 + deviation)
        } else {
            0.0
        };
        text.push_str(&format!(
            "{:.4},{depth:.7},{:.3}\n",
            f64::from(k) / 100.0,
            383_640.0 * 50.8e-3 * root * root
        ));
    }
    text
}

/// A universal file of two datasets 58: a displacement with this kind and unit, and a force.
fn universal(kind: u32, unit: &str) -> String {
    let dataset = |kind: u32, unit: &str, values: &str| {
        let none = "         0    0    0    0 NONE                 NONE                \n";
        format!(
            "    -1\n    58\n{}    1         0    0         0 NONE                1   3 NONE                0   0\n\
             {:>10}{:>10}{:>10}  0.00000e+00  1.00000e-01  0.00000e+00\n{:>10}    0    0    0 {:<20} {:<20}\n\
             {kind:>10}    0    0    0 {:<20} {unit:<20}\n{none}{none}{values}\n    -1\n",
            "NONE\n".repeat(5),
            4,
            8,
            1,
            17,
            "time",
            "s",
            "ordinate"
        )
    };
    dataset(kind, unit, "  0.0  5.0 10.0 20.0\n 30.0 35.0 40.0 50.0")
        + &dataset(13, "kN", "  0.0  0.1  0.2  0.3\n  0.5  0.6  0.7  0.8")
}

/// Writes the data with changes, fits them, and checks the expected messages of the command.
#[track_caller]
fn refused(name: &str, changes: &[(&str, &str, &str)], arguments: &[&str], expected: &[&str]) {
    let folder = folder(&format!("prf-fit-{name}"));
    let mut files: Vec<(String, String)> = vec![("drives.csv".to_owned(), DRIVES.to_owned())];
    for (place, id) in ["a1", "a2", "b1", "b2", "c1"].into_iter().enumerate() {
        files.push((format!("{id}.csv"), recording(0.01 * place as f64)));
    }
    for (file, from, to) in changes {
        let text = &mut files.iter_mut().find(|own| own.0 == *file).unwrap().1;
        if from.is_empty() {
            *text = (*to).to_owned();
        } else {
            assert!(text.contains(from), "{name}: no {from:?} in {file}");
            *text = text.replacen(from, to, 1);
        }
    }
    for (file, text) in &files {
        fs::write(folder.join(file), text).unwrap();
    }
    fails(name, &folder, arguments, expected);
}

#[track_caller]
fn fails(name: &str, folder: &Path, arguments: &[&str], expected: &[&str]) {
    let (data, out) = (folder.join("drives.csv"), folder.join("out"));
    let mut all = vec!["prf", "fit", data.to_str().unwrap(), "--out", out.to_str().unwrap()];
    if !arguments.contains(&"--form") {
        all.extend(["--form", "poly(x,3)"]);
    }
    all.extend(arguments);
    let output = nailnoise(&all);
    // Long messages are wrapped, with a bar before each further line.
    let said = messages(&output);
    let words = said.split_whitespace().filter(|word| !["|", "│"].contains(word));
    let said = words.collect::<Vec<_>>().join(" ");
    assert_eq!(output.status.code(), Some(2), "{name}: {said}");
    for words in expected {
        assert!(said.contains(words), "{name}: no {words:?} in: {said}");
    }
    assert!(!out.exists(), "{name} wrote files");
}

#[test]
fn damaged_lists_of_drives_are_refused() {
    let row = "a2,a,2,1,6d,smooth,,,,pine,,,8.333e-3,,,,a2.csv";
    let of = |from: &str, to: &str| row.replacen(from, to, 1);
    let header = DRIVES.lines().next().unwrap();
    for (name, changes, expected) in [
        ("empty", ["", ""], ["drives.csv, line 1", "help"]),
        ("no-drive", ["", header], ["drives.csv, line 1", "it has no drive"]),
        (
            "column",
            ["density_kg_m3", "density_kg_m"],
            [
                "line 1: there is no column \"density_kg_m\"",
                "is it \"density_kg_m3\"?",
            ],
        ),
        (
            "column-twice",
            ["group,repeat", "group,group"],
            ["line 1", "it has two columns \"group\""],
        ),
        ("no-id", ["id,group", "repeat,group"], ["line 1", "help"]),
        (
            "no-file",
            [",file\n", ",moisture\n"],
            ["line 1: the column \"file\" is missing", "names the columns"],
        ),
        (
            "fields",
            [row, &of("pine", "pine,pine")],
            ["line 3: it has 18 fields", "it may be empty"],
        ),
        (
            "id",
            [row, &of("a2", "")],
            ["line 3: the id is empty", "an id of its own"],
        ),
        (
            "id-twice",
            [row, &of("a2", "a1")],
            ["line 3: the drive \"a1\" is in the data twice", "an id of its own"],
        ),
        (
            "drive-3",
            [row, &of(",1,", ",3,")],
            ["line 3: drive is \"3\"", "2 the same nail again into its hole"],
        ),
        (
            "second-alone",
            [row, &of("a,2,1", "a,9,2")],
            ["line 3: drive 2 \"a2\" has no drive 1", "add the first drive"],
        ),
        (
            "speed-text",
            [row, &of("8.333e-3", "fast")],
            ["line 3: speed_m_s is \"fast\", no number", "give a number in the unit"],
        ),
        (
            "speed-comma",
            [row, &of("8.333e-3", "8,333e-3")],
            ["line 3: it has 18 fields", "help"],
        ),
        (
            "speed-zero",
            [row, &of("8.333e-3", "0")],
            [
                "line 3: speed_m_s is 0.0, and must be from 1e-8 to 1000.0",
                "correct speed_m_s",
            ],
        ),
        (
            "speed-negative",
            [row, &of("8.333e-3", "-1")],
            ["line 3: speed_m_s is -1", "correct speed_m_s"],
        ),
        (
            "speed-none",
            [row, &of("8.333e-3", "")],
            ["line 3: the speed of drive \"a2\" is not given once", "give speed_m_s"],
        ),
        (
            "hardness",
            [row, &of("pine,", "pine,0")],
            ["line 3: hardness_modulus_n_m is 0", "correct hardness_modulus_n_m"],
        ),
        (
            "density",
            [row, &of("pine,,", "pine,,-429")],
            ["line 3: density_kg_m3 is -429", "correct density_kg_m3"],
        ),
        (
            "length",
            [row, &of("smooth,", "smooth,NaN")],
            ["line 3: length_m is \"NaN\", no number", "help"],
        ),
        (
            "diameter",
            [row, &of("smooth,,", "smooth,,-3e-3")],
            ["line 3: diameter_m is -0.003", "correct diameter_m"],
        ),
        (
            "hardness-tiny",
            [row, &of("pine,", "pine,0.5")],
            [
                "line 3: hardness_modulus_n_m is 0.5, and must be from 1000.0 to",
                "ends with its unit",
            ],
        ),
        (
            "length-huge",
            [row, &of("smooth,", "smooth,1e9")],
            [
                "line 3: length_m is 1000000000.0, and must be from 0.001 to 2.0",
                "correct length_m",
            ],
        ),
        (
            "thicker-than-long",
            [row, &of("smooth,,", "smooth,0.003,0.004")],
            [
                "line 3: the nail of drive \"a2\" is 0.003 m long and 0.004 m thick",
                "below length_m",
            ],
        ),
        (
            "density-huge",
            [row, &of("pine,,", "pine,,1e9")],
            ["line 3: density_kg_m3 is 1000000000.0", "correct density_kg_m3"],
        ),
        (
            "shank",
            [row, &of("smooth", "wavy")],
            ["line 3: shank is \"wavy\"", "smooth, annular, helical"],
        ),
        (
            "nail",
            [row, &of("6d", "7d")],
            [
                "line 3: the length of the nail of drive \"a2\" is missing",
                "give length_m",
            ],
        ),
        (
            "wood",
            [row, &of("pine", "granite")],
            [
                "line 3: the hardness modulus of drive \"a2\" is missing",
                "hardness_modulus_n_m",
            ],
        ),
        (
            "both-speeds",
            [row, &of("8.333e-3,,", "8.333e-3,0.131,25")],
            ["line 3", "help"],
        ),
        (
            "file-empty",
            [row, &of("a2.csv", "")],
            ["line 3: drive \"a2\" names no file", "give the CSV file"],
        ),
        (
            "file-missing",
            [row, &of("a2.csv", "a3.csv")],
            ["cannot read", "line 3 of"],
        ),
        ("file-folder", [row, &of("a2.csv", ".")], ["cannot read", "line 3 of"]),
    ] {
        refused(name, &[("drives.csv", changes[0], changes[1])], &[], &expected);
    }
}

#[test]
fn damaged_impacts_are_refused() {
    let with = |from: &str, to: &str| {
        format!(
            "{}{}",
            DRIVES.lines().next().unwrap().to_owned() + "\n",
            IMPACT.replacen(from, to, 1)
        )
    };
    for (name, row, expected) in [
        (
            "no-mass",
            with("0.131", ""),
            [
                "line 2: the speed of drive \"c1\" is not given once",
                "projectile_mass_kg",
            ],
        ),
        (
            "mass-zero",
            with("0.131", "0"),
            ["line 2: projectile_mass_kg is 0", "correct projectile_mass_kg"],
        ),
        (
            "no-nail-mass",
            with("0.0078", ""),
            [
                "line 2: the mass of the nail of drive \"c1\" is missing",
                "give nail_mass_kg",
            ],
        ),
        (
            "ahead",
            with("25,0,", "25,0.2,"),
            ["line 2: mass_ahead_of_cell_kg is 0.2", "correct mass_ahead_of_cell_kg"],
        ),
    ] {
        refused(name, &[("drives.csv", "", &row)], &[], &expected);
    }
    let timeless: String = recording(0.0)
        .lines()
        .map(|line| format!("{}\n", line.split_once(',').unwrap().1))
        .collect();
    let changes =
        [("drives.csv", "", with("", "").as_str()), ("c1.csv", "", &timeless)].map(|(a, b, c)| (a, b, c.to_owned()));
    let changes: Vec<_> = changes.iter().map(|(a, b, c)| (*a, *b, c.as_str())).collect();
    refused(
        "no-time",
        &changes,
        &[],
        &[
            "c1.csv, line 1: a drive by a projectile needs the column time_s",
            "add the column",
        ],
    );
}

#[test]
fn damaged_recordings_are_refused() {
    let good = recording(0.01);
    let lines: Vec<&str> = good.lines().collect();
    let edited = |place: usize, line: &str| {
        let mut lines = lines.clone();
        lines[place] = line;
        lines.join("\n")
    };
    let silent: String = good
        .lines()
        .map(|line| format!("{},0\n", line.rsplit_once(',').unwrap().0))
        .collect();
    let silent = silent.replacen("depth_m,0", "depth_m,force_n", 1);
    let mut back = lines.clone();
    let returned = lines[100..140].to_vec();
    back.splice(160..160, returned.iter().copied());
    let timeless = |lines: &[&str]| {
        lines
            .iter()
            .map(|line| format!("{}\n", line.split_once(',').unwrap().1))
            .collect::<String>()
    };
    let negative: Vec<String> = lines
        .iter()
        .enumerate()
        .map(|(k, line)| {
            if (100..140).contains(&k) {
                format!("{},-400", line.rsplit_once(',').unwrap().0)
            } else {
                (*line).to_owned()
            }
        })
        .collect();
    for (name, text, expected) in [
        (
            "r-empty",
            String::new(),
            ["a2.csv, line 1: no line has two columns", "time_s,depth_m,force_n"],
        ),
        (
            "r-columns",
            good.replacen("depth_m", "dept_m", 1),
            ["a2.csv, line 1: its columns are", "time_s,depth_m,force_n"],
        ),
        (
            "r-text",
            edited(50, "0.3,deep,20"),
            [
                "a2.csv, line 51: \"depth_m\" is \"deep\", which is not a finite number",
                "one decimal mark",
            ],
        ),
        (
            "r-infinite",
            edited(50, "0.3,0.01,inf"),
            ["a2.csv, line 51: \"force_n\" is \"inf\"", "help"],
        ),
        (
            "r-fields",
            edited(50, "0.3,0.01"),
            ["a2.csv, line 51: it has 2 fields", "a number for every column"],
        ),
        (
            "r-short",
            lines[..4].join("\n"),
            ["a2.csv, line 1: there are 3 samples", "record at a higher rate"],
        ),
        (
            "r-silent",
            silent,
            ["a2.csv, line 1: the force is nowhere above 0 N", "give the force in N"],
        ),
        (
            "r-back",
            timeless(&back),
            ["a2.csv, line 15", "one file holds one drive"],
        ),
        (
            "r-negative",
            negative.join("\n"),
            ["a2.csv, line 1", "check the zero of the load cell"],
        ),
        (
            "r-time-back",
            edited(50, "0.01,0.0076,500"),
            [
                "a2.csv, line 51: the time does not rise by equal steps",
                "equal intervals",
            ],
        ),
        (
            "r-time-gap",
            good.replace("\n0.5", "\n7.5"),
            ["the time does not rise by equal steps", "equal intervals"],
        ),
        (
            "u-cut",
            universal(8, "mm").trim_end().trim_end_matches("-1").to_owned(),
            ["a2.csv: dataset 58 of line", "has no end"],
        ),
        (
            "u-depth",
            universal(12, "m/s2"),
            [
                "a2.csv, line 1: it holds no dataset 58 of displacement",
                "specific data type 8",
            ],
        ),
        ("u-two", universal(13, "N"), ["a2.csv", "help"]),
        (
            "u-unit",
            universal(8, "kg"),
            ["a2.csv, line 1: the unit \"kg\"", "label the ordinate's unit"],
        ),
        (
            "u-number",
            universal(8, "mm").replacen("30.0", "none", 1),
            ["a2.csv, line 15, dataset 58", "help"],
        ),
        (
            "u-binary",
            universal(8, "mm").replacen("    58\n", "    58b     1\n", 1),
            ["a2.csv, line 1: dataset 58 is binary", "as text"],
        ),
    ] {
        refused(
            name,
            &[("a2.csv", "", if text.is_empty() { "\n" } else { &text })],
            &[],
            &expected,
        );
    }
    let folder = folder("prf-fit-bytes");
    fs::write(folder.join("drives.csv"), [0xFF, 0xFE, 0x00]).unwrap();
    fails(
        "bytes",
        &folder,
        &[],
        &["drives.csv, line 1: no line has two columns", "help"],
    );
}

#[test]
fn laws_that_the_data_do_not_determine_are_refused() {
    let few: String = recording(0.0)
        .lines()
        .enumerate()
        .filter(|(k, _)| *k < 20 || k % 25 == 0)
        .map(|(_, line)| format!("{}\n", line.split_once(',').unwrap().1))
        .collect();
    let sparse: Vec<(&str, &str, &str)> = ["a1.csv", "a2.csv", "b1.csv", "b2.csv"]
        .map(|file| (file, "", few.as_str()))
        .to_vec();
    refused(
        "depths",
        &sparse,
        &["--form", "poly(x,12)"],
        &["distinct depths, too few for x^12", "or lower"],
    );
    let helical = format!("{DRIVES}a3,a,1,2,6d,helical,,3.0e-3,,pine,,,8.333e-3,,,,c1.csv\n");
    for (name, arguments, expected) in [
        (
            "form",
            &["--form", "poly(x,3) + speed"][..],
            ["there is no variable \"speed\"", "poly(x,7) + rate + slender"],
        ),
        ("form-power", &["--form", "1 + x^-1"], ["infinite where x is 0", "help"]),
        (
            "form-twice",
            &["--form", "1 + x + x"],
            ["the term x stands in it twice", "help"],
        ),
        (
            "one-nail",
            &["--form", "poly(x,3) + slender"],
            ["the data do not tell the term slender from 1", "drop slender or 1"],
        ),
        (
            "impact",
            &["--form", "poly(x,3) + decay"],
            [
                "line 2: the term decay needs the mass and speed of a projectile",
                "drop decay from --form",
            ],
        ),
        (
            "drives",
            &["--form", "1 + x + rate + rate^2 + rate^3 + rate^4"],
            ["4 drives do not determine 5 terms", "drive more nails"],
        ),
        (
            "split",
            &["--split"],
            ["no hole has a first and a second drive", "drive some nails again"],
        ),
        (
            "leave",
            &["--leave", "nail"],
            ["all drives belong to one nail", "--leave"],
        ),
        (
            "start",
            &["--start", "50kN"],
            ["a1.csv, line 1: the force does not reach 50000 N", "lower --start"],
        ),
        ("start-unit", &["--start", "5kg"], ["5kg", "--start"]),
        ("slope", &["--slope-samples", "4"], ["odd number", "--slope-samples"]),
    ] {
        refused(name, &[], arguments, &expected);
    }
    refused(
        "helical",
        &[("drives.csv", "", &helical)],
        &["--split"],
        &["line 6: a helical nail turns", "leave helical nails out"],
    );
}

#[test]
fn speeds_that_do_not_determine_the_law_of_the_speed_are_refused() {
    let one = [
        ("drives.csv", "3.333e-4", "8.333e-3"),
        ("drives.csv", "3.333e-4", "8.333e-3"),
    ];
    let refusal = ["do not determine beta and v_m", "--rate speed"];
    refused("one-speed", &one, &["--rate", "estimate"], &refusal);
    refused("slow-speeds", &[], &["--rate", "estimate"], &refusal);
    let form = ["--rate", "speed", "--form", "poly(x,3) + rate"];
    refused(
        "rate-twice",
        &[],
        &form,
        &["the term rate depends on the speed", "--rate none"],
    );
    refused(
        "share",
        &[],
        &["--rate", "speed", "--friction-share", "1.2"],
        &["from 0 to 1"],
    );
}

/// The law of the speed hardly changes a law from slow drives, because its reference speed is that of these drives.
#[test]
fn the_law_of_the_speed_is_written_with_the_fit() {
    let folder = folder("prf-fit-rate");
    fs::write(folder.join("drives.csv"), DRIVES).unwrap();
    for (place, id) in ["a1", "a2", "b1", "b2"].into_iter().enumerate() {
        fs::write(folder.join(format!("{id}.csv")), recording(0.01 * place as f64)).unwrap();
    }
    let (data, out) = (folder.join("drives.csv"), folder.join("out"));
    let fit = |extra: &[&str]| {
        let mut all = vec!["prf", "fit", data.to_str().unwrap(), "--out", out.to_str().unwrap()];
        all.extend(["--form", "poly(x,3)"]);
        all.extend(extra);
        let output = nailnoise(&all);
        assert!(output.status.success(), "{}", messages(&output));
        (
            String::from_utf8(output.stdout).unwrap(),
            fs::read_to_string(out.join("fit.toml")).unwrap(),
        )
    };
    let (_, plain) = fit(&[]);
    assert!(!plain.contains("[rate"));
    let (said, divided) = fit(&["--rate", "speed", "--friction-share", "0.5"]);
    assert!(
        said.contains("divided out: beta 0.050, v_m 1.000 m/s, friction 0.50"),
        "{said}"
    );
    assert!(
        divided.contains("[rate.speed]") && divided.contains("friction_share = 0.5"),
        "{divided}"
    );
}

/// Depth in mm and force in kN of a universal file are those of the CSV file in SI units.
#[test]
fn a_universal_file_is_the_same_recording() {
    let folder = folder("prf-fit-universal");
    fs::write(
        folder.join("drives.csv"),
        "id,nail,wood,speed_m_s,file\na,6d,pine,8.333e-3,a.uff\nb,6d,pine,8.333e-3,b.csv\n",
    )
    .unwrap();
    fs::write(folder.join("a.uff"), universal(8, "mm")).unwrap();
    let depths = [0, 5, 10, 20, 30, 35, 40, 50];
    let forces = [0, 100, 200, 300, 500, 600, 700, 800];
    let rows: String = depths
        .iter()
        .zip(forces)
        .map(|(y, f)| format!("{},{f}\n", f64::from(*y) * 1e-3))
        .collect();
    fs::write(folder.join("b.csv"), format!("depth_m,force_n\n{rows}")).unwrap();
    let (data, out) = (folder.join("drives.csv"), folder.join("out"));
    let arguments = [
        "prf",
        "fit",
        data.to_str().unwrap(),
        "--form",
        "1 + x",
        "--start",
        "recorded",
        "--out",
        out.to_str().unwrap(),
    ];
    let output = nailnoise(&arguments);
    assert!(output.status.success(), "{}", messages(&output));
    let residuals = fs::read_to_string(out.join("residuals.csv")).unwrap();
    let of = |id: &str| -> Vec<String> {
        let rows = residuals.lines().filter(|line| line.starts_with(&format!("{id},")));
        rows.map(|line| line.split_once(',').unwrap().1.split_once(',').unwrap().1.to_owned())
            .collect()
    };
    assert!(!of("a").is_empty());
    assert_eq!(of("a"), of("b"));
    // Without labels the units are those of dataset 164: mm and kN.
    let label = |unit: &str| format!("ordinate             {unit:<20}\n");
    let unlabelled = universal(8, "mm")
        .replace(&label("mm"), &label(""))
        .replace(&label("kN"), &label(""));
    let units =
        "    -1\n   164\n         9user units                   2\n  1.0D+03  1.0D-03  1.0D+00\n  0.0D+00\n    -1\n";
    fs::write(folder.join("a.uff"), format!("{units}{unlabelled}")).unwrap();
    assert!(nailnoise(&arguments).status.success());
    assert_eq!(fs::read_to_string(out.join("residuals.csv")).unwrap(), residuals);
}

#[test]
fn implausible_numbers_of_a_drive_are_refused_with_their_line() {
    for (name, from, to, words) in [
        ("force", 1, "1e308", "the force is 1e308 N; at most 10000000.0 N"),
        ("depth", 0, "-1e30", "the depth is -1e30 m; at most 10.0 m"),
    ] {
        let rows: Vec<String> = (0..40)
            .map(|k| {
                let mut row = [format!("{}", 1e-3 * f64::from(k)), format!("{}", 20 * k)];
                if k == 30 {
                    row[from] = to.to_owned();
                }
                row.join(",")
            })
            .collect();
        let recording = format!("depth_m,force_n\n{}\n", rows.join("\n"));
        refused(
            name,
            &[("a1.csv", "", &recording)],
            &[],
            &["a1.csv", "line 32", words, "units of the columns"],
        );
    }
}

/// A law written by the command, with one number of it replaced, ends the cycle of a design before it starts.
#[test]
fn a_law_of_impossible_numbers_is_refused_by_the_cycle() {
    let folder = folder("prf-fit-impossible");
    fs::write(folder.join("drives.csv"), DRIVES).unwrap();
    for (place, id) in ["a1", "a2", "b1", "b2"].into_iter().enumerate() {
        fs::write(folder.join(format!("{id}.csv")), recording(0.01 * place as f64)).unwrap();
    }
    let [drives, out] = ["drives.csv", "out"].map(|name| folder.join(name).to_str().unwrap().to_owned());
    let made = nailnoise(&["prf", "fit", &drives, "--form", "poly(x,3)", "--out", &out]);
    assert!(made.status.success(), "{}", messages(&made));
    let law = fs::read_to_string(folder.join("out/fit.toml")).unwrap();
    assert!(!law.contains("= inf") && !law.contains("= nan"), "{law}");
    let cycle = |law: &str| {
        fs::write(folder.join("fit.toml"), law).unwrap();
        let design = over(
            &folder,
            "design",
            "wood.penetration_law = \"fitted\"\nwood.penetration_fit = \"fit.toml\"\nnail.kind = \"6d smooth\"",
        );
        nailnoise(&["cycle", &design, "--json"])
    };
    // The shot is computed; that it overdrives its short nail is a failed check.
    let valid = cycle(&law);
    assert!(matches!(valid.status.code(), Some(0 | 3)), "{}", messages(&valid));
    assert!(String::from_utf8_lossy(&valid.stdout).contains("head_depth"));
    for (key, number, expected) in [
        ("coefficient", "1e308", "in the range of the data"),
        ("coefficient", "-1e9", "in the range of the data"),
        ("coefficient", "nan", "must be finite"),
        ("standard_error", "inf", "quality.standard_error"),
        ("vif", "nan", "vif of"),
        ("sigma_between", "1e300", "sigma_between"),
        ("sigma_within", "inf", "sigma_within"),
        ("r_squared", "-inf", "quality.r_squared"),
        ("x", "[0.0, 1e300]", "ranges.x"),
        ("speed_m_s", "[0.0, 1e9]", "ranges.speed_m_s"),
    ] {
        let place = law.find(&format!("\n{key} = ")).unwrap() + 1;
        let line = place + law[place..].find('\n').unwrap();
        let changed = format!("{}{key} = {number}{}", &law[..place], &law[line..]);
        let output = cycle(&changed);
        let said = messages(&output);
        let words = said.split_whitespace().filter(|word| !["|", "│"].contains(word));
        let said = words.collect::<Vec<_>>().join(" ");
        assert_eq!(output.status.code(), Some(2), "{key} = {number}: {said}");
        assert!(
            said.contains("fit.toml") && said.contains(expected),
            "{key} = {number}: {said}"
        );
    }
}
