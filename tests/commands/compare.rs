//! Designs side by side, through the command.

use crate::common::{SMALL, folder, nailnoise, over};

use serde_json::Value;

fn close(a: &Value, b: f64) {
    assert!((a.as_f64().unwrap() - b).abs() < 1e-9, "{a} is not {b}");
}

#[test]
fn a_comparison_tells_what_differs_and_what_it_does() {
    let folder = folder("compare");
    let out = folder.join("out");
    let quiet = over(&folder, "quiet", "supply.pressure = \"600 kPa\"");
    let out = out.to_str().unwrap();
    let output = nailnoise(&["compare", SMALL, &quiet, "--json", "--out", out]);
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let first: Value = serde_json::from_slice(&output.stdout).unwrap();
    assert_eq!(first["designs"], serde_json::json!(["small", "quiet"]));
    let inputs = first["inputs"].as_array().unwrap();
    assert_eq!(inputs.len(), 1, "{inputs:#?}");
    assert_eq!(
        (&inputs[0]["key"], &inputs[0]["unit"]),
        (&"supply.pressure".into(), &"Pa".into())
    );
    assert_eq!(inputs[0]["values"], serde_json::json!([763_200.0, 600_000.0]));
    let exhaust = first["sources"]
        .as_array()
        .unwrap()
        .iter()
        .find(|s| s["source"] == "exhaust")
        .unwrap();
    let change = exhaust["change_db"][1].as_f64().unwrap();
    assert!(change < -1.0, "less pressure blows more quietly: {change} dB");
    close(&exhaust["change_db"][0], 0.0);
    close(
        &exhaust["change_db"][1],
        exhaust["level_db"][1].as_f64().unwrap() - exhaust["level_db"][0].as_f64().unwrap(),
    );

    // The files of the runs compare as the runs did, and hold what `run` leaves.
    let results = [format!("{out}/small"), format!("{out}/quiet/result.json")];
    let output = nailnoise(&["compare", &results[0], &results[1], "--json"]);
    let again: Value = serde_json::from_slice(&output.stdout).unwrap();
    assert!(first == again, "results from files differ from those of the runs");

    // Limits hold for the proposals, and a limit between the two levels tells them apart.
    let level = |k: usize| exhaust["level_db"][k].as_f64().unwrap();
    let limit = format!("exhaust={:.2}", 0.5 * (level(0) + level(1)));
    let gate = |order: [usize; 2]| {
        let output = nailnoise(&[
            "compare",
            &results[order[0]],
            &results[order[1]],
            "--fail-above",
            &limit,
        ]);
        (output.status.code(), String::from_utf8(output.stdout).unwrap())
    };
    let (status, text) = gate([0, 1]);
    assert_eq!(status, Some(0));
    for part in [
        "supply.pressure [Pa]",
        "exhaust",
        "ranking",
        "total",
        "speed before impact",
        "t7 [ms]",
    ] {
        assert!(text.contains(part), "no {part} in\n{text}");
    }
    assert_eq!(gate([1, 0]).0, Some(1));
}

#[test]
fn what_is_no_result_is_refused() {
    let folder = folder("compare-refused");
    let other = folder.join("other.json");
    std::fs::write(&other, "{\"schema\": \"nailnoise-run/0\"}").unwrap();
    let cut = folder.join("cut.json");
    std::fs::write(&cut, "{\"schema\": \"nailno").unwrap();
    let empty = folder.join("empty");
    std::fs::create_dir(&empty).unwrap();
    for (path, part) in [
        (&other, "nailnoise-run/0"),
        (&cut, "no result"),
        (&empty, "cannot read"),
    ] {
        let output = nailnoise(&["compare", path.to_str().unwrap(), SMALL]);
        let text = String::from_utf8_lossy(&output.stderr).into_owned();
        assert_eq!(output.status.code(), Some(2), "{text}");
        assert!(text.contains(part) && text.contains("help"), "{text}");
    }
    let output = nailnoise(&["compare", SMALL, SMALL, "--fail-above", "muffler=3"]);
    assert_eq!(output.status.code(), Some(2));
}
