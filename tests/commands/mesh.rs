//! `mesh`, `check` and `modes` as a user meets them: the user's own meshes, those that ship, and damaged ones.

use crate::common::{command, folder, json};
use std::path::Path;
use std::process::Output;

use serde_json::Value;

/// Runs the command without gmsh: shipped bodies must not need it.
fn nailnoise(arguments: &[&str]) -> Output {
    command(arguments)
        .env("NAILNOISE_GMSH", "no-such-gmsh")
        .output()
        .unwrap()
}

/// Both streams on one line, since messages are wrapped.
fn said(output: &Output) -> String {
    let text = [output.stdout.as_slice(), output.stderr.as_slice()].concat();
    let text = String::from_utf8(text).unwrap();
    text.split_whitespace().collect::<Vec<_>>().join(" ")
}

/// The command ends with status 2 and names the fault.
#[track_caller]
fn refused(output: &Output, expected: &str) {
    assert_eq!(output.status.code(), Some(2), "{}", said(output));
    assert!(said(output).contains(expected), "{}", said(output));
}

#[test]
fn every_body_of_the_ready_designs_is_fit_and_needs_no_gmsh() {
    for (design, body, pieces, mass) in [
        ("designs/n80cb.toml", "workpiece", 1, 2.534),
        ("designs/n80cb.toml", "worktable", 1, 12.704),
        ("designs/n80cb.toml", "tool", 1, 4.1),
        ("designs/n80cb-sandbox.toml", "tool", 1, 4.1),
    ] {
        let result = json(&nailnoise(&["check", design, "--body", body, "--json"]));
        assert_eq!(result["schema"], "nailnoise-check/1");
        assert_eq!(result["faults"], Value::Array(Vec::new()), "{body}: {result:#}");
        assert_eq!(result["warnings"], Value::Array(Vec::new()), "{body}: {result:#}");
        assert_eq!(result["quality"]["pieces"], pieces, "{body}");
        assert!((result["mass"].as_f64().unwrap() / mass - 1.0).abs() < 1e-3, "{body}");
        for part in result["parts"].as_array().unwrap() {
            assert!(part["waves"]["elements"].as_f64().unwrap() >= 2.0, "{body}: {part}");
        }
    }
    let text = said(&nailnoise(&["check", "designs/n80cb.toml", "--body", "tool"]));
    for word in [
        "worst element",
        "closed and outward",
        "cost of modes",
        "housing",
        "gas_bore",
    ] {
        assert!(text.contains(word), "{word}: {text}");
    }
}

#[test]
fn new_geometry_without_gmsh_names_the_way_to_install_it() {
    let folder = folder("no-gmsh");
    let base = Path::new(env!("CARGO_MANIFEST_DIR")).join("designs/n80cb.toml");
    let design = folder.join("longer.toml");
    std::fs::write(
        &design,
        format!("base = \"{}\"\nbody.handle_length = \"171 mm\"\n", base.display()),
    )
    .unwrap();
    let output = nailnoise(&["check", design.to_str().unwrap(), "--body", "tool"]);
    refused(&output, "apt-get install --no-install-recommends gmsh");
    let step = folder.join("part.step");
    std::fs::write(&step, "ISO-10303-21;\n").unwrap();
    refused(&nailnoise(&["check", step.to_str().unwrap()]), "--size");
    let output = nailnoise(&["check", step.to_str().unwrap(), "--size", "5 mm"]);
    refused(&output, "no-such-gmsh cannot be started");
    let step = step.to_str().unwrap();
    refused(
        &nailnoise(&["mesh", "designs/n80cb.toml", "--body", "tool", "--solid", "2"]),
        "--solid has nothing",
    );
    let output = nailnoise(&["modes", "designs/n80cb.toml", "--body", "workpiece", "--mesh", step]);
    refused(&output, "no-such-gmsh cannot be started");
}

#[test]
fn a_file_that_states_its_unit_takes_no_other() {
    let folder = folder("stated-unit");
    for name in ["part.step", "part.STP", "part.igs", "part.iges"] {
        let path = folder.join(name);
        std::fs::write(&path, "ISO-10303-21;\n").unwrap();
        let file = path.to_str().unwrap();
        let states = "states the unit of its lengths";
        for command in ["mesh", "check"] {
            let unit = nailnoise(&[command, file, "--size", "25 mm", "--unit", "1 m"]);
            refused(&unit, states);
            refused(&unit, "leave --unit out");
        }
        let base = Path::new(env!("CARGO_MANIFEST_DIR")).join("designs/n80cb.toml");
        let design = folder.join("own.toml");
        std::fs::write(
            &design,
            format!("base = {base:?}\nbody.mesh = {name:?}\nbody.mesh_unit = \"1 in\"\n"),
        )
        .unwrap();
        let design = design.to_str().unwrap();
        let keyed = nailnoise(&["modes", design, "--body", "tool"]);
        refused(&keyed, states);
        refused(&keyed, "leave body.mesh_unit out");
        refused(
            &nailnoise(&["check", design, "--body", "tool", "--unit", "1 m"]),
            "leave --unit out",
        );
    }
    // BREP files state none; neither do meshes of other programs.
    let brep = folder.join("part.brep");
    std::fs::write(&brep, "DBRep_DrawableShape\n").unwrap();
    let output = nailnoise(&["mesh", brep.to_str().unwrap(), "--size", "5 mm", "--unit", "1 in"]);
    refused(&output, "no-such-gmsh cannot be started");
    let mesh = folder.join("own.msh");
    let file = mesh.to_str().unwrap();
    let make = ["mesh", "tests/data/small.toml", "--body", "workpiece", "--write", file];
    assert!(nailnoise(&make).status.success());
    refused(
        &nailnoise(&["mesh", file, "--unit", "1 in"]),
        "states the unit of its lengths",
    );
    for unit in [&[][..], &["--unit", "1 m"]] {
        assert!(nailnoise(&[&["mesh", file][..], unit].concat()).status.success());
    }
}

/// Modes of the N80CB's workpiece with a mesh in units of 0.3 m.
fn modes_of(mesh: &str) -> Output {
    let design = ["modes", "designs/n80cb.toml", "--body", "workpiece"];
    nailnoise(&[&design[..], &["--unit", "0.3 m", "--mesh", mesh]].concat())
}

/// A gmsh whose optimisation the system ends, as at its limit of processor time.
#[cfg(unix)]
#[test]
fn an_optimisation_that_runs_out_of_time_leaves_straight_sides_and_is_reported() {
    use std::os::unix::fs::PermissionsExt as _;

    if std::process::Command::new("gmsh").arg("--version").output().is_err() {
        eprintln!("skipped: there is no gmsh");
        return;
    }
    let folder = folder("optimisation-limit");
    let at = |name: &str| folder.join(name).to_str().unwrap().to_owned();
    // A pipe, whose curved sides fold elements that are longer than its wall is thick.
    let pipe = "SetFactory(\"OpenCASCADE\");\nCylinder(1) = {0,0,0, 0,0,60, 20};\nCylinder(2) = \
        {0,0,0, 0,0,60, 18.5};\n\
                BooleanDifference(3) = { Volume{1}; Delete; }{ Volume{2}; Delete; };\n";
    std::fs::write(at("pipe.geo"), pipe).unwrap();
    let made = std::process::Command::new("gmsh")
        .args([&at("pipe.geo"), "-0", "-o", &at("pipe.step")])
        .output();
    assert!(made.unwrap().status.success());
    let script = "#!/bin/sh\ncase \"$*\" in *\"optimise 0\"*) exec gmsh \"$@\";; esac\nkill -XCPU $$\n";
    std::fs::write(at("gmsh.sh"), script).unwrap();
    std::fs::set_permissions(at("gmsh.sh"), std::fs::Permissions::from_mode(0o755)).unwrap();
    let mesh = |program: &str, written: &str| {
        command(&["mesh", &at("pipe.step"), "--size", "10 mm", "--write", &at(written)])
            .env("NAILNOISE_GMSH", program)
            .output()
            .unwrap()
    };
    let (limited, own) = (mesh(&at("gmsh.sh"), "limited.msh"), mesh("gmsh", "own.msh"));
    assert!(limited.status.success() && own.status.success(), "{}", said(&limited));
    for words in [
        "pipe.step was ended after",
        "s of processor time",
        "are straight instead of curved",
    ] {
        assert!(said(&limited).contains(words), "{}", said(&limited));
        assert!(!said(&own).contains(words), "{}", said(&own));
    }
    // The result is a mesh without folded elements.
    let check = nailnoise(&["mesh", &at("limited.msh")]);
    assert!(check.status.success(), "{}", said(&check));
}

#[test]
fn mesh_check_and_modes_refuse_the_same_damaged_meshes() {
    let folder = folder("one-judgement");
    let path = folder.join("own.msh");
    let file = path.to_str().unwrap();
    let out = folder.join("converted.msh");
    let written = out.to_str().unwrap();
    // Inverted; all inverted; a third element beyond a face that two share.
    let third = tetrahedron("$Elements\n3\n", "$Elements\n4\n20 4 2 7 1 2 3 4 6\n")
        .replace("$Nodes\n5\n", "$Nodes\n6\n6 2 2 2\n");
    for (text, expected) in [
        (tetrahedron("17 4 2 7 1 1 2 3 4", "17 4 2 7 1 1 3 2 4"), "element 17"),
        (
            tetrahedron("17 4 2 7 1 1 2 3 4", "17 4 2 7 1 1 3 2 4").replace("18 4 2 7 1 2 3 4 5", "18 4 2 7 1 3 2 4 5"),
            "2 inverted",
        ),
        (third, "edges of the skin are open"),
    ] {
        std::fs::write(&path, text).unwrap();
        let mesh = nailnoise(&["mesh", file, "--unit", "0.3 m", "--write", written]);
        refused(&mesh, expected);
        assert!(!out.exists(), "{expected}");
        refused(&modes_of(file), expected);
        assert_eq!(
            nailnoise(&["check", file, "--unit", "0.3 m"]).status.code(),
            Some(2),
            "{expected}"
        );
    }
    std::fs::write(&path, tetrahedron("17", "17")).unwrap();
    assert!(
        nailnoise(&["mesh", file, "--unit", "0.3 m", "--write", written])
            .status
            .success()
    );
    assert!(nailnoise(&["check", file, "--unit", "0.3 m"]).status.success());
}

/// A tetrahedron with one line changed.
fn tetrahedron(from: &str, to: &str) -> String {
    let good = "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$PhysicalNames\n2\n2 9 \"base\"\n3 \
        7 \"block\"\n$EndPhysicalNames\n\
                $Nodes\n5\n1 0 0 0\n2 1 0 0\n3 0 1 0\n4 0 0 1\n5 1 1 1\n$EndNodes\n\
                $Elements\n3\n17 4 2 7 1 1 2 3 4\n18 4 2 7 1 2 3 4 5\n19 2 2 9 1 1 3 2\n$EndElements\n";
    assert!(good.contains(from), "{from}");
    good.replacen(from, to, 1)
}

#[test]
fn a_damaged_mesh_ends_with_status_2_and_the_element_the_groups_or_the_version() {
    let folder = folder("damaged");
    let path = folder.join("own.msh");
    let file = path.to_str().unwrap();
    for (from, to, expected) in [
        ("17 4 2 7 1 1 2 3 4", "17 4 2 7 1 1 3 2 4", "element 17"),
        (
            "18 4 2 7 1 2 3 4 5",
            "18 4 2 7 1 4 3 2 1",
            "element 18 has the same nodes as element 17",
        ),
        (
            "18 4 2 7 1 2 3 4 5",
            "18 4 2 7 1 2 3 4 6",
            "element 18 refers to node 6",
        ),
        ("2.2 0 8", "3.0 0 8", "format version 3.0"),
        (
            "3 7 \"block\"",
            "3 8 \"block\"",
            "surface \"base\", volume \"block\", volume 7 without a name",
        ),
        ("$MeshFormat", "solid", "not a .msh file"),
    ] {
        std::fs::write(&path, tetrahedron(from, to)).unwrap();
        let own = modes_of(file);
        refused(&own, expected);
        let output = nailnoise(&["check", file]);
        assert_eq!(output.status.code(), Some(2), "{}", said(&output));
    }
    std::fs::write(folder.join("part.obj"), "o\n").unwrap();
    refused(
        &nailnoise(&["check", folder.join("part.obj").to_str().unwrap()]),
        "known are .msh",
    );
    std::fs::write(&path, tetrahedron("17", "17")).unwrap();
    let output = [
        "modes",
        "designs/n80cb.toml",
        "--body",
        "worktable",
        "--unit",
        "0.3 m",
        "--mesh",
        file,
    ];
    refused(&nailnoise(&output), "floor");
    refused(
        &nailnoise(&["mesh", file, "--write", folder.join("own.stl").to_str().unwrap()]),
        "written as .vtu, .msh",
    );
}

#[test]
fn a_hundred_damaged_meshes_end_with_a_message_and_never_a_panic() {
    let folder = folder("hundred");
    let path = folder.join("damaged.msh");
    let file = path.to_str().unwrap();
    let format = ["text22", "binary22", "text41", "binary41"];
    let good: Vec<Vec<u8>> = format
        .iter()
        .map(|format| {
            let output = nailnoise(&[
                "mesh",
                "tests/data/small.toml",
                "--body",
                "worktable",
                "--format",
                format,
                "--write",
                file,
            ]);
            assert!(output.status.success(), "{}", said(&output));
            std::fs::read(&path).unwrap()
        })
        .collect();
    // The generator of Knuth, The Art of Computer Programming 2, section 3.3.4, so that a failure can be made again.
    let mut state = 4u64;
    let mut next = move |below: usize| {
        state = state
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1_442_695_040_888_963_407);
        ((state >> 33) % below as u64) as usize
    };
    let mut refused = 0;
    for trial in 0..100 {
        let mut bytes = good[trial % good.len()].clone();
        for _ in 0..=next(5) {
            let at = next(bytes.len());
            let end = (at + next(200)).min(bytes.len());
            match next(5) {
                0 => bytes[at] ^= 1 << next(8),
                1 => drop(bytes.drain(at..end)),
                2 => bytes[at..end].fill(next(256) as u8),
                3 => bytes.truncate(at.max(1)),
                _ => bytes.rotate_left(at.min(64)),
            }
        }
        std::fs::write(&path, &bytes).unwrap();
        let output = nailnoise(&["check", file]);
        assert!(
            matches!(output.status.code(), Some(0 | 2)),
            "{trial}: {}",
            said(&output)
        );
        assert!(!said(&output).contains("panicked"), "{trial}");
        refused += usize::from(output.status.code() == Some(2));
    }
    assert!(refused > 60, "{refused} of 100 were refused");
}

/// A body of 20 million degrees of freedom would take minutes and most of the memory.
#[test]
fn a_check_leaves_large_meshes_to_the_run() {
    let large = [
        ("analysis.worktable_element", "5 mm"),
        ("analysis.worktable_top_layers", "50"),
        ("analysis.mode_margin", "1"),
    ];
    let set = large.map(|(key, value)| format!("--set={key}={value}"));
    let arguments = [
        &["check", "designs/n80cb.toml", "--memory", "100TB"],
        &set.each_ref().map(String::as_str)[..],
    ];
    let output = nailnoise(&arguments.concat());
    assert!(output.status.success());
    assert!(said(&output).contains("not meshed here"), "{}", said(&output));
}

#[test]
fn an_exported_mesh_is_read_back_in_its_own_unit() {
    let folder = folder("round-trip");
    for (format, end) in [("text22", "msh"), ("binary41", "msh.gz")] {
        let path = folder.join(format!("table.{end}"));
        let file = path.to_str().unwrap();
        let write = ["mesh", "tests/data/small.toml", "--body", "worktable", "--json"];
        let made = json(&nailnoise(
            &[&write[..], &["--format", format, "--write", file]].concat(),
        ));
        let read = json(&nailnoise(&["mesh", file, "--json"]));
        for key in ["nodes", "elements", "kinds", "longest_edge"] {
            assert_eq!(made[key], read[key], "{key}");
        }
        // The file lists parts and groups in the order of their first elements.
        for key in ["parts", "groups"] {
            let sorted = |of: &Value| {
                let mut names: Vec<String> = of[key].as_array().unwrap().iter().map(Value::to_string).collect();
                names.sort();
                names
            };
            assert_eq!(sorted(&made), sorted(&read), "{key}");
        }
        let built = [
            "modes",
            "tests/data/small.toml",
            "--body",
            "worktable",
            "--json",
            "--out",
        ];
        let out = folder.join("out");
        let built = [&built[..], &[out.to_str().unwrap()]].concat();
        let own = json(&nailnoise(&[&built[..], &["--mesh", file]].concat()));
        let built = json(&nailnoise(&built));
        assert_eq!(own["modes"], built["modes"]);
    }
}

#[test]
fn modes_match_themselves_in_a_universal_file() {
    let out = folder("own-modes");
    let out = out.to_str().unwrap();
    let base = [
        "modes",
        "tests/data/small.toml",
        "--body",
        "workpiece",
        "--json",
        "--out",
        out,
    ];
    let modes = json(&nailnoise(&[&base[..], &["--uff", "--animate", "7"]].concat()));
    let folder = Path::new(out).join("modes/workpiece");
    let count = modes["modes"].as_array().unwrap().len();
    assert!(count > 6);
    let list = std::fs::read_to_string(folder.join("modes.pvd")).unwrap();
    assert_eq!(list.matches("<DataSet").count(), count);
    let film = std::fs::read_to_string(folder.join("mode-0007.pvd")).unwrap();
    assert_eq!(film.matches("<DataSet").count(), 24);
    refused(&nailnoise(&[&base[..], &["--animate", "9999"]].concat()), "mode 9999");
    let file = folder.join("modes.uff");
    let compared = json(&nailnoise(&[&base[..], &["--mac", file.to_str().unwrap()]].concat()));
    let correlation = &compared["correlation"];
    assert_eq!(
        (&correlation["unmatched"], &correlation["by_position"]),
        (&Value::from(0), &Value::from(true))
    );
    let mac = correlation["mac"].as_array().unwrap();
    // Rigid modes are any basis of their space, so that only the elastic ones must be the same twice.
    for (row, values) in mac.iter().enumerate().skip(6) {
        assert!(values[row].as_f64().unwrap() > 0.9999, "{row}");
        let pair = &correlation["pairs"][row];
        assert_eq!(pair["mode"], row + 1);
        assert!((pair["measured_hz"].as_f64().unwrap() / pair["computed_hz"].as_f64().unwrap() - 1.0).abs() < 1e-5);
    }
    let absent = nailnoise(&[&base[..], &["--mac", "no-such.uff"]].concat());
    refused(&absent, "no-such.uff");
    // The same modes without the nodes: no distance, and pairs by number only on request.
    let text = std::fs::read_to_string(&file).unwrap();
    let modes = folder.join("modes-only.uff");
    let begin = text.find("    -1\n    55\n").unwrap();
    std::fs::write(&modes, &text[begin..]).unwrap();
    let modes = modes.to_str().unwrap();
    let unpaired = nailnoise(&[&base[..], &["--mac", modes]].concat());
    refused(&unpaired, "has no coordinates");
    refused(&unpaired, "--by-number");
    let numbered = json(&nailnoise(&[&base[..], &["--mac", modes, "--by-number"]].concat()));
    let correlation = &numbered["correlation"];
    assert_eq!(
        (&correlation["by_position"], &correlation["farthest"]),
        (&Value::from(false), &Value::Null)
    );
    assert!(correlation["mac"][6][6].as_f64().unwrap() > 0.9999);
    let plain: Vec<&str> = base.iter().copied().filter(|word| *word != "--json").collect();
    let shown = said(&nailnoise(&[&plain[..], &["--mac", modes, "--by-number"]].concat()));
    assert!(
        shown.contains("matched by number, distance unknown without coordinates"),
        "{shown}"
    );
}

/// A housing without a seat: `check` reports the same as `run` before it solves a body.
#[test]
fn check_and_run_refuse_a_housing_in_the_same_words() {
    let folder = folder("housing");
    let mesh = folder.join("housing.msh");
    let mesh = mesh.to_str().unwrap();
    let write = [
        "mesh",
        "designs/n80cb.toml",
        "--body",
        "tool",
        "--format",
        "text22",
        "--write",
        mesh,
    ];
    assert!(nailnoise(&write).status.success());
    let text = std::fs::read_to_string(mesh).unwrap();
    assert!(text.contains("\"seat\""));
    std::fs::write(mesh, text.replace("\"seat\"", "\"stool\"")).unwrap();
    let base = Path::new(env!("CARGO_MANIFEST_DIR")).join("designs/n80cb.toml");
    let design = folder.join("own.toml");
    let text = format!("base = {base:?}\nbody.mesh = {mesh:?}\nbody.mesh_unit = \"1 m\"\n");
    std::fs::write(&design, text).unwrap();
    let design = design.to_str().unwrap();
    let no_surface = "has no surface \"seat\" for gas and head valve";
    for body in [&["--body", "tool"][..], &[]] {
        let output = nailnoise(&[&["check", design][..], body].concat());
        refused(&output, no_surface);
        refused(&output, "[surfaces.NAME] with surface = \"seat\"");
    }
    let out = folder.join("out");
    let run = nailnoise(&["run", design, "--no-cache", "--out", out.to_str().unwrap()]);
    refused(&run, "seat");
    assert!(!said(&run).contains("modes of the"), "{}", said(&run));
    assert!(!out.join("own").join("result.json").exists());
}

#[test]
fn check_shows_where_each_surface_is_and_who_named_it() {
    let result = json(&nailnoise(&["check", "designs/n80cb.toml", "--body", "tool", "--json"]));
    let groups = result["groups"].as_array().unwrap();
    let tip = groups.iter().find(|group| group["name"] == "nose_tip").unwrap();
    assert_eq!(tip["origin"], "file");
    let centre: Vec<f64> = tip["centre"]
        .as_array()
        .unwrap()
        .iter()
        .map(|c| c.as_f64().unwrap())
        .collect();
    assert!(centre.iter().all(|c| c.abs() < 1e-6), "{centre:?}");
}
