//! Designs side by side, through the command.

use std::fs;
use std::path::Path;
use std::sync::LazyLock;

use crate::common::{SMALL, folder, json, nailnoise, over};
use serde_json::Value;

fn close(a: &Value, b: f64) {
    assert!((a.as_f64().unwrap() - b).abs() < 1e-9, "{a} is not {b}");
}

/// The small design next to one with less supply pressure: the comparison, and the folder of the two runs.
static COMPARISON: LazyLock<(Value, String)> = LazyLock::new(|| {
    let folder = folder("compare");
    let out = folder.join("out").to_str().unwrap().to_owned();
    let quiet = over(&folder, "quiet", "supply.pressure = \"600 kPa\"");
    let comparison = json(&nailnoise(&["compare", SMALL, &quiet, "--json", "--out", &out]));
    (comparison, out)
});

/// The stored results of the two runs.
fn results() -> [String; 2] {
    let out = &COMPARISON.1;
    [format!("{out}/small"), format!("{out}/quiet/result.json")]
}

fn exhaust() -> &'static Value {
    let sources = COMPARISON.0["sources"].as_array().unwrap();
    sources.iter().find(|s| s["source"] == "exhaust").unwrap()
}

/// Exit status and output of a comparison with a limit between the levels of the two exhausts.
fn limited(before: &str, after: &str) -> (Option<i32>, String) {
    let level = |k: usize| exhaust()["level_db"][k].as_f64().unwrap();
    let limit = format!("exhaust={:.2}", 0.5 * (level(0) + level(1)));
    let output = nailnoise(&["compare", before, after, "--fail-above", &limit]);
    (output.status.code(), String::from_utf8(output.stdout).unwrap())
}

#[test]
fn a_comparison_names_its_designs() {
    assert_eq!(COMPARISON.0["designs"], serde_json::json!(["small", "quiet"]));
}

#[test]
fn a_comparison_lists_only_the_inputs_that_differ() {
    let inputs = COMPARISON.0["inputs"].as_array().unwrap();
    assert_eq!(inputs.len(), 1, "{inputs:#?}");
    assert_eq!(
        (&inputs[0]["key"], &inputs[0]["unit"]),
        (&"supply.pressure".into(), &"Pa".into())
    );
    assert_eq!(inputs[0]["values"], serde_json::json!([763_200.0, 600_000.0]));
}

/// A range that ends an octave higher contains three bands more, so that the level rises without a change of the tool.
#[test]
fn levels_over_unlike_ranges_of_frequency_are_not_compared_without_a_warning() {
    let folder = folder("compare-ranges");
    let [one, other] = ["1000 Hz", "2000 Hz"].map(|high| {
        let name = format!("to-{}", high.replace(' ', ""));
        over(&folder, &name, &format!("analysis.range_high = \"{high}\""))
    });
    let out = folder.join("out").to_str().unwrap().to_owned();
    let output = nailnoise(&["compare", &one, &other, "--out", &out]);
    let text = String::from_utf8(output.stdout).unwrap();
    let first = text.lines().next().unwrap();
    assert!(
        first.contains("do not compare") && first.contains("to 1000 Hz") && first.contains("to 2000 Hz"),
        "{first}"
    );
    let results = ["to-1000Hz", "to-2000Hz"].map(|name| format!("{out}/{name}"));
    let comparison = json(&nailnoise(&[
        "compare",
        &results[0],
        &results[1],
        "--json",
        "--out",
        &out,
    ]));
    assert_eq!(comparison["unlike_ranges"][1][1], 2000.0);
    assert!(COMPARISON.0["unlike_ranges"].is_null());
}

#[test]
fn changes_are_differences_from_the_first_design() {
    let (changes, levels) = (&exhaust()["change_db"], &exhaust()["level_db"]);
    close(&changes[0], 0.0);
    close(&changes[1], levels[1].as_f64().unwrap() - levels[0].as_f64().unwrap());
}

#[test]
fn less_pressure_lowers_the_exhaust_noise() {
    let change = exhaust()["change_db"][1].as_f64().unwrap();
    assert!(change < -1.0, "{change} dB");
}

#[test]
fn stored_results_compare_like_their_runs() {
    let [first, second] = results();
    let again = json(&nailnoise(&["compare", &first, &second, "--json"]));
    assert!(COMPARISON.0 == again);
}

#[test]
fn a_proposal_below_the_limit_passes_and_one_above_it_fails() {
    let [loud, quiet] = results();
    assert_eq!(limited(&loud, &quiet).0, Some(0));
    assert_eq!(limited(&quiet, &loud).0, Some(1));
}

#[test]
fn the_table_shows_inputs_sources_and_events() {
    let [loud, quiet] = results();
    let text = limited(&loud, &quiet).1;
    for part in [
        "supply.pressure [kPa]",
        "exhaust",
        "ranking",
        "total",
        "speed before impact",
        "t7 piston at",
    ] {
        assert!(text.contains(part), "no {part} in\n{text}");
    }
}

#[test]
fn a_file_that_is_not_a_result_is_refused() {
    let folder = folder("compare-refused");
    let other = folder.join("other.json");
    fs::write(&other, "{\"schema\": \"nailnoise-run/0\"}").unwrap();
    let cut = folder.join("cut.json");
    fs::write(&cut, "{\"schema\": \"nailno").unwrap();
    let empty = folder.join("empty");
    fs::create_dir(&empty).unwrap();
    for (path, part) in [
        (&other, "nailnoise-run/0"),
        (&cut, "cannot compare the result"),
        (&empty, "cannot read"),
    ] {
        let output = nailnoise(&["compare", path.to_str().unwrap(), SMALL]);
        let text = String::from_utf8_lossy(&output.stderr).into_owned();
        assert_eq!(output.status.code(), Some(2), "{text}");
        assert!(text.contains(part) && text.contains("help"), "{text}");
    }
}

/// The pages in a folder by name.
fn pages(folder: &Path) -> Vec<String> {
    let names = fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().file_name());
    let mut names: Vec<String> = names.map(|name| name.into_string().unwrap()).collect();
    names.retain(|name| name.ends_with(".html"));
    names.sort();
    names
}

/// A copy of a stored result in a separate folder.
fn copied(result: &str, to: &Path) -> String {
    fs::create_dir_all(to).unwrap();
    let from = Path::new(result);
    let from = if from.is_dir() {
        from.join("result.json")
    } else {
        from.to_owned()
    };
    fs::copy(from, to.join("result.json")).unwrap();
    to.to_str().unwrap().to_owned()
}

#[test]
fn a_page_is_named_after_its_designs_and_replaces_only_itself() {
    let [small, quiet] = results();
    let folder = folder("compare-pages");
    let out = folder.join("out");
    let compare = |a: &str, b: &str| {
        let output = nailnoise(&["compare", a, b, "--out", out.to_str().unwrap()]);
        assert!(output.status.success());
    };
    compare(&small, &quiet);
    assert_eq!(pages(&out), ["compare-small-quiet.html"]);
    let first = fs::read(out.join("compare-small-quiet.html")).unwrap();
    compare(&small, &quiet);
    compare(&quiet, &small);
    assert_eq!(pages(&out), ["compare-quiet-small.html", "compare-small-quiet.html"]);
    // Other results of the same names.
    let other = copied(&small, &folder.join("other"));
    compare(&other, &quiet);
    let expected = [
        "compare-quiet-small.html",
        "compare-small-quiet-2.html",
        "compare-small-quiet.html",
    ];
    assert_eq!(pages(&out), expected);
    assert_eq!(fs::read(out.join("compare-small-quiet.html")).unwrap(), first);
}

#[test]
fn a_name_in_a_result_leads_to_no_file_elsewhere() {
    let [small, quiet] = results();
    let folder = folder("compare-elsewhere");
    let changed = copied(&small, &folder.join("changed"));
    change(&changed, |result| result["design"]["name"] = "../../elsewhere".into());
    let out = folder.join("out");
    let output = nailnoise(&["compare", &changed, &quiet, "--out", out.to_str().unwrap()]);
    assert!(output.status.success());
    assert_eq!(pages(&out), ["compare-.._.._elsewhere-quiet.html"]);
}

/// Changes a stored result.
fn change(folder: &str, change: impl FnOnce(&mut Value)) {
    let file = Path::new(folder).join("result.json");
    let mut result: Value = serde_json::from_slice(&fs::read(&file).unwrap()).unwrap();
    change(&mut result);
    fs::write(file, result.to_string()).unwrap();
}

#[test]
fn a_result_whose_numbers_do_not_agree_is_refused_with_their_place() {
    let [small, quiet] = results();
    let folder = folder("compare-inconsistent");
    let louder = |level: &mut Value| *level = (level.as_f64().unwrap() + 0.5).into();
    type Change<'a> = &'a dyn Fn(&mut Value);
    let cases: [(&str, Change<'_>); 12] = [
        ("`ranking` is empty, expected is at least one source", &|r| {
            r["ranking"] = Value::Array(Vec::new())
        }),
        ("`total.lwa_db`", &|r| louder(&mut r["total"]["lwa_db"])),
        ("`total.lw_db`", &|r| louder(&mut r["total"]["lw_db"])),
        ("`ranking[0].lw_db`", &|r| {
            louder(&mut r["ranking"][0]["components"][0]["lw_db"])
        }),
        ("`ranking[1].lwa_db`", &|r| {
            r["ranking"][1]["bands"][9]["lwa_db"] = 200.into()
        }),
        ("`ranking[0].lwa_db`", &|r| {
            r["ranking"][0]["intervals"][7]["lwa_db"] = 200.into()
        }),
        ("`ranking[1].share`", &|r| r["ranking"][1]["share"] = 0.9.into()),
        ("`ranking[2].share` is -0.1, expected is 0.0", &|r| {
            r["ranking"][2]["share"] = (-0.1).into()
        }),
        ("`ranking[0].bands[3].lw_db` is 1000", &|r| {
            r["ranking"][0]["bands"][3]["lw_db"] = 1e3.into()
        }),
        ("`ranking[1].source` is \"workpiece\" again", &|r| {
            r["ranking"][1]["source"] = "workpiece".into()
        }),
        ("`ranking[0].lwa_db`: invalid type: string", &|r| {
            r["ranking"][0]["lwa_db"] = "loud".into()
        }),
        ("`ranking[0].share`: invalid type: null", &|r| {
            r["ranking"][0]["share"] = Value::Null
        }),
    ];
    for (place, wrong) in cases {
        let changed = copied(&small, &folder.join("changed"));
        change(&changed, wrong);
        let output = nailnoise(&["compare", &quiet, &changed]);
        let text = String::from_utf8_lossy(&output.stderr).into_owned();
        let line = text
            .split_whitespace()
            .filter(|word| *word != "|")
            .collect::<Vec<_>>()
            .join(" ");
        assert_eq!(output.status.code(), Some(2), "{place}: {text}");
        for part in [place, "result.json", "help"] {
            assert!(line.contains(part), "no {part} in {text}");
        }
    }
}

#[test]
fn a_limit_for_an_unknown_source_is_refused() {
    let output = nailnoise(&["compare", SMALL, SMALL, "--fail-above", "muffler=3"]);
    assert_eq!(output.status.code(), Some(2));
}
