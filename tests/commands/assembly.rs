//! Tools that a file describes as an assembly: the page that explains them, `check`, `cycle` and refusals.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::Output;

use crate::common::{ROOT, command, folder, json, over};

/// The blocks of TOML of the page.
pub(crate) fn blocks() -> Vec<String> {
    let page = fs::read_to_string(Path::new(ROOT).join("docs/another-tool.md")).unwrap();
    let parts = page.split("```toml\n").skip(1);
    parts.map(|part| part.split("```").next().unwrap().to_owned()).collect()
}

/// A folder with the tacker of the page, the design with a chamber and the blow gun.
fn tools(name: &str) -> PathBuf {
    let folder = folder(&format!("assembly/{name}"));
    let blocks = blocks();
    let (chamber, parts) = blocks.split_last().unwrap();
    fs::write(folder.join("tacker.toml"), parts.concat()).unwrap();
    fs::write(folder.join("chamber.toml"), chamber).unwrap();
    for file in ["designs/n80cb.toml", "dynamics/assemblies/blow_gun.toml"] {
        let file = Path::new(ROOT).join(file);
        fs::copy(&file, folder.join(file.file_name().unwrap())).unwrap();
    }
    folder
}

fn nailnoise(folder: &Path, arguments: &[&str]) -> Output {
    command(arguments).current_dir(folder).output().unwrap()
}

/// Time of an event \[ms\].
fn event(result: &serde_json::Value, name: &str) -> Option<f64> {
    let events = result["events"].as_array().unwrap();
    let found = events.iter().find(|event| event["name"] == name).unwrap();
    found["time"].as_f64().map(|time| 1e3 * time)
}

/// A vessel of 1 l at 8 bar that empties through 20 mm2. Any time t of it is proportional to V/A: dt/dV = t/V and
/// dt/dA = -t/A.
#[test]
fn the_sensitivities_of_a_vessel_are_those_of_its_closed_form() {
    let folder = folder("assembly/sensitivity");
    let text = "[cycle]\nassembly = { name = \"vessel\", schema = 1 }\n\
                gas = { constant = \"287.05 J/(kg K)\", ratio = 1.4 }\nend = \"0.4 s\"\n\
                [cycle.reservoir]\natmosphere = { pressure = \"101.325 kPa\", temperature = \"20 degC\" }\n\
                [cycle.volume.vessel]\ndead = { value = \"1 l\", range = \"0.5 .. 2 l\" }\npressure = \"800 kPa\"\n\
                [cycle.passage.valve]\nbetween = [\"vessel\", \"atmosphere\"]\n\
                area = { value = \"20 mm2\", range = \"10 .. 40 mm2\" }\n\
                [cycle.opening.valve]\npassage = \"valve\"\n\
                [cycle.event]\nempty = { becomes = \"vessel.pressure <= 300 kPa\" }\n";
    fs::write(folder.join("vessel.toml"), text).unwrap();
    let arguments = ["cycle", "vessel.toml", "--sensitivity", "--outputs", "empty,masses"];
    let result = json(&nailnoise(&folder, &[&arguments[..], &["--json"]].concat()));
    assert_eq!(result["schema"], "nailnoise-sensitivity/1");
    assert_eq!([&result["tool"], &result["assembly"]], ["vessel", "vessel"]);
    let empty = &result["outputs"][0];
    assert_eq!([&empty["name"], &empty["unit"]], ["empty", "s"]);
    let time = empty["value"].as_f64().unwrap();
    assert!((time / 0.189_309_726_663_923_9 - 1.0).abs() < 1e-7, "{time} s");
    for (key, exact) in [
        ("cycle.volume.vessel.dead", time / 1e-3),
        ("cycle.passage.valve.area", -time / 20e-6),
    ] {
        let mut ranking = empty["ranking"].as_array().unwrap().iter();
        let found = ranking.find(|own| own["key"] == key).unwrap();
        let derivative = found["derivative"].as_f64().unwrap();
        assert!(
            (derivative / exact - 1.0).abs() < 1e-5,
            "{key}: {derivative} instead of {exact}"
        );
    }
    let table = fs::read_to_string(folder.join("out/vessel/sensitivity.csv")).unwrap();
    assert_eq!(table.lines().count(), 1 + 2 * 2, "{table}");
    let printed = String::from_utf8(nailnoise(&folder, &arguments).stdout).unwrap();
    for word in ["sensitivity to 2 parameters", "empty =", "valve_mass ="] {
        assert!(printed.contains(word), "{word}\n{printed}");
    }
    let unknown = nailnoise(
        &folder,
        &[
            "cycle",
            "vessel.toml",
            "--sensitivity",
            "--parameters",
            "cycle.volume.vesel.dead",
        ],
    );
    assert_eq!(unknown.status.code(), Some(2));
}

#[test]
fn every_step_of_the_page_runs_and_the_tacker_drives() {
    let folder = tools("page");
    let blocks = blocks();
    for steps in 1..blocks.len() {
        fs::write(folder.join("step.toml"), blocks[..steps].concat()).unwrap();
        let result = json(&nailnoise(&folder, &["cycle", "step.toml", "--json"]));
        assert!(
            result["checks"]
                .as_array()
                .unwrap()
                .iter()
                .all(|check| check["ok"] == true),
            "step {steps}"
        );
    }
    let result = json(&nailnoise(&folder, &["cycle", "tacker.toml", "--json"]));
    assert_eq!(result["outcome"], "drives");
    assert!(
        event(&result, "strike") < event(&result, "driven") && event(&result, "driven") < event(&result, "returned")
    );
}

/// The quick exhaust valve of the page opens after the trigger is released, and the piston strikes both bumpers.
#[test]
fn the_quick_exhaust_valve_of_the_page_opens_as_its_pilot_is_vented() {
    let folder = tools("quick");
    let page = fs::read_to_string(Path::new(ROOT).join("docs/another-tool.md")).unwrap();
    let mut texts = page
        .split("```text\n")
        .skip(1)
        .map(|part| part.split("```").next().unwrap());
    let quick = texts.find(|text| text.contains("[cycle.body.shuttle]")).unwrap();
    fs::write(folder.join("quick.toml"), quick).unwrap();
    let result = json(&nailnoise(&folder, &["cycle", "quick.toml", "--json"]));
    assert_eq!(result["outcome"], "drives");
    let opened = event(&result, "quick_exhaust").unwrap();
    assert!((41.2..44.0).contains(&opened), "{opened} ms");
    let mass = |name: &str| {
        let mut ledger = result["ledger"].as_array().unwrap().iter();
        ledger.find(|own| own["name"] == name).unwrap()["value"]
            .as_f64()
            .unwrap()
    };
    assert!(mass("mass.exhaust") > 3.0 * mass("mass.vent"));
    let peak = |name: &str| {
        let mut peaks = result["peaks"].as_array().unwrap().iter();
        peaks.find(|own| own["block"] == name).unwrap()["force"]
            .as_f64()
            .unwrap()
    };
    assert!(peak("bumper") > 100.0 && peak("second_bumper") > 100.0);
}

/// Check (h) of the specification of networks.
#[test]
fn the_chamber_of_the_page_moves_the_events_of_the_exhaust() {
    let folder = tools("chamber");
    let result = json(&nailnoise(&folder, &["cycle", "chamber.toml", "--json"]));
    for (name, expected) in [
        ("t13", 42.971),
        ("t15", 65.301),
        ("t16", 76.192),
        ("t17", 79.558),
        ("t18", 81.625),
    ] {
        let time = event(&result, name).unwrap();
        assert!(
            (time - expected).abs() < 1.5e-3,
            "{name}: {time} ms in place of {expected} ms"
        );
    }
}

#[test]
fn a_literal_and_an_own_key_can_be_set_and_a_wrong_name_is_named() {
    let folder = tools("set");
    let pressure = |set: &[&str]| {
        let result = json(&nailnoise(
            &folder,
            &[&["cycle", "blow_gun.toml", "--json"], set].concat(),
        ));
        event(&result, "steady").unwrap()
    };
    let base = pressure(&[]);
    assert!(pressure(&["--set", "gun.volume=30cm3"]) > base);
    assert!(pressure(&["--set", "cycle.passage.valve.coefficient=0.3"]) > base);
    let output = nailnoise(&folder, &["cycle", "blow_gun.toml", "--set", "gun.volme=30cm3"]);
    let text = String::from_utf8(output.stderr).unwrap();
    assert_eq!(output.status.code(), Some(2));
    assert!(text.contains("did you mean `gun.volume`"), "{text}");
}

#[test]
fn check_lists_states_blocks_and_keys() {
    let folder = tools("check");
    let result = json(&nailnoise(&folder, &["check", "tacker.toml", "--json"]));
    assert_eq!(result["states"].as_array().unwrap().len(), 10);
    let tables = result["tables"].as_array().unwrap();
    let rows = |name: &str| {
        let table = tables.iter().find(|table| table["name"] == name).unwrap();
        table["rows"].as_array().unwrap().len()
    };
    assert_eq!(
        [rows("bodies"), rows("volumes"), rows("passages"), rows("openings")],
        [3, 2, 2, 1]
    );
    let text = String::from_utf8(nailnoise(&folder, &["check", "chamber.toml"]).stdout).unwrap();
    for part in [
        "silencer",
        "becomes valve_lift > 10 um",
        "cycle.volume.silencer.dead",
        "add up over roof",
    ] {
        assert!(text.contains(part), "{part}:\n{text}");
    }
}

#[test]
fn a_run_of_an_assembly_alone_asks_for_a_base() {
    let folder = tools("run");
    let output = nailnoise(&folder, &["run", "tacker.toml"]);
    let text = String::from_utf8(output.stderr).unwrap();
    assert_eq!(output.status.code(), Some(2), "{text}");
    assert!(
        text.contains("no workpiece, support and microphones") && text.contains("add `base = \"n80cb.toml\"`"),
        "{text}"
    );
}

#[test]
fn files_and_figures_are_written() {
    let folder = tools("files");
    let output = nailnoise(&folder, &["cycle", "tacker.toml", "--figures"]);
    assert!(output.status.success());
    let out = folder.join("out/tacker");
    let histories = fs::read_to_string(out.join("histories.csv")).unwrap();
    let header = histories.lines().next().unwrap();
    assert!(
        header.starts_with("time [s],") && header.contains("piston_travel [m]"),
        "{header}"
    );
    for file in [
        "openings.csv",
        "log.csv",
        "events.csv",
        "figures/motion.svg",
        "figures/flows.svg",
    ] {
        assert!(out.join(file).exists(), "{file}");
    }
}

/// The blow gun has no outcome that a study of the N80CB counts, so all its shots count.
#[test]
fn a_study_of_an_assembly_is_written_with_its_draws() {
    let folder = folder("assembly/study");
    let text = "[cycle]\nassembly = \"blow_gun\"\nend = \"40 ms\"\n[study]\nscreening = 4\nrequire = []";
    let gun = over(&folder, "gun", text);
    let output = nailnoise(&folder, &["study", &gun, "-n", "2", "--json", "--out", "out"]);
    assert_eq!(json(&output)["draws"], 2);
    assert!(folder.join("out/study/draws.csv").is_file());
}

/// An event named as one of the N80CB has the words of its own assembly, in the table and in the file.
#[test]
fn events_are_described_by_their_assembly() {
    let folder = tools("events");
    let own = "[cycle.event]\nt12 = { text = \"driver is back\", becomes = \"piston.travel <= 1 mm\", \
               after = \"strike\" }";
    let text = fs::read_to_string(folder.join("tacker.toml")).unwrap();
    let text = text.replacen("[cycle.event]", own, 1);
    fs::write(folder.join("words.toml"), text).unwrap();
    let output = nailnoise(&folder, &["cycle", "words.toml"]);
    let printed = String::from_utf8(output.stdout).unwrap();
    let file = fs::read_to_string(folder.join("out/words/events.csv")).unwrap();
    assert!(printed.contains("t12 driver is back"), "{printed}");
    assert!(file.contains("t12,driver is back,"), "{file}");
    assert!(!format!("{printed}{file}").contains("trigger valve"), "{printed}");
}

/// The head names the fastener of the tool, and nothing that the tool does not have.
#[test]
fn the_head_of_a_report_describes_the_tool_of_its_assembly() {
    let folder = folder("assembly/report");
    let head = |name: &str, text: &str| {
        let design = over(
            &folder,
            name,
            &format!("[cycle]\nassembly = {text}\n[study]\nscreening = 0"),
        );
        let output = nailnoise(&folder, &["run", &design, "--out", name]);
        assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
        let page = fs::read_to_string(folder.join(name).join("report.html")).unwrap();
        let begin = page.find("<dl class=\"given\">").unwrap();
        page[begin..begin + page[begin..].find("</dl>").unwrap()].to_owned()
    };
    let stapler = head("stapler", "\"stapler\"");
    assert!(stapler.contains("<dt>staple</dt><dd>14.0 mm, 0.12 g</dd>"), "{stapler}");
    assert!(
        !stapler.contains("<dt>nail</dt>") && stapler.contains("wood, block"),
        "{stapler}"
    );
    let gun = head("gun", "\"blow_gun\"\nend = \"30 ms\"");
    for absent in ["nail</dt>", "wood", "support"] {
        assert!(!gun.contains(absent), "{absent} in {gun}");
    }
    assert!(gun.contains("supply pressure"), "{gun}");
}

/// Mass that left through a passage of a test bench for silencers \[kg\].
fn discharged(arguments: &[&str], passage: &str) -> f64 {
    let folder = Path::new(ROOT).join("examples/silencer");
    let result = json(&nailnoise(&folder, &[&["cycle", "--json"], arguments].concat()));
    let ledger = result["ledger"].as_array().unwrap();
    let entry = ledger.iter().find(|entry| entry["name"] == format!("mass.{passage}"));
    entry.unwrap()["value"].as_f64().unwrap()
}

#[test]
fn a_vessel_empties_through_a_silencer_and_more_slowly_through_a_fifth_of_its_holes() {
    let exact = 2e-3 * 6.3e5 / (287.05 * 293.15);
    let bare = discharged(&["bare.toml"], "outlet");
    let silenced = discharged(&["silencer.toml"], "holes");
    assert!((bare / exact - 1.0).abs() < 1e-3, "{bare} kg of {exact}");
    assert!((silenced / exact - 1.0).abs() < 1e-3, "{silenced} kg of {exact}");
    let throttled = discharged(&["silencer.toml", "--set", "cycle.let.holes=20"], "holes");
    assert!(throttled < 0.9 * exact, "{throttled} kg of {exact}");
}

/// `check`, `cycle` and `run` refuse a value that the assembly does not follow in the same words, at its place. The
/// cycle alone does not use the support.
#[test]
fn commands_refuse_alike_what_an_assembly_does_not_follow() {
    let folder = folder("assembly/refused");
    for (name, text, cycle_uses_it) in [
        ("blow", "model.blow = \"elastic\"", true),
        ("gas", "model.gas = \"published\"", true),
        ("coupling", "support.coupling = \"two-way\"", false),
    ] {
        let design = over(
            &folder,
            name,
            &format!("{text}\n[cycle]\nassembly = \"blow_gun\"\nend = \"40 ms\"\n"),
        );
        let outputs = ["run", "check", "cycle"].map(|command| nailnoise(&folder, &[command, &design]));
        let [run, check, cycle] = outputs.map(|output| (output.status.code(), crate::common::messages(&output)));
        let (key, _) = text.split_once(" =").unwrap();
        assert!(
            run.0 == Some(2) && run.1.contains(key) && run.1.contains(&format!("{name}.toml:")),
            "{}",
            run.1
        );
        assert_eq!(check, run);
        match cycle_uses_it {
            true => assert_eq!(cycle, run),
            false => assert_eq!(cycle.0, Some(0), "{}", cycle.1),
        }
    }
}

/// `check` prints its tables, then refuses a tool that cannot start.
#[test]
fn check_refuses_a_tool_that_is_not_seated() {
    let folder = folder("assembly/unseated");
    let design = over(&folder, "light", "[cycle]\n[cycle.force.hand]\nforce = \"-500 N\"\n");
    let outputs = ["check", "cycle"].map(|command| nailnoise(&folder, &[command, &design]));
    for output in &outputs {
        let message = crate::common::messages(output);
        assert_eq!(output.status.code(), Some(2), "{message}");
        for part in ["\"tool\" is not seated", "light.toml", "`cycle.force.hand.force`"] {
            assert!(message.contains(part), "{message}");
        }
    }
    assert!(!outputs[0].stdout.is_empty());
}
