//! The sound of tools that are described as assemblies.

use nailnoise::chain::{self, Chain, Options};
use nailnoise::design::Value;
use nailnoise::graph::Graph;
use nailnoise::measurement::markers::MarkerEvents;
use nailnoise::output::columns;
use nailnoise::run::Run;
use nailnoise::stages::cycle::ShotRecord;
use nailnoise::store::{LIMIT, Store};
use nailnoise::study::{Variable, variables};
use nailnoise::{Design, Error, virtual_test};

use crate::common::{ROOT, design, folder, run, run_with_chain, small};

/// The tool of the page "Describe another tool", on the small design.
fn stapler(more: &str) -> Design {
    small(&format!("[cycle]\nassembly = \"stapler\"\n{more}"))
}

fn sources(run: &Run) -> Vec<&str> {
    let mut names: Vec<&str> = run.result.ranking.iter().map(|own| own.source.as_str()).collect();
    names.sort_unstable();
    names
}

fn level(run: &Run, source: &str) -> f64 {
    let mut ranking = run.result.ranking.iter();
    ranking.find(|own| own.source == source).unwrap().lwa_db.unwrap()
}

#[test]
fn the_n80cb_as_an_assembly_has_the_levels_of_its_keys() {
    let (keys, assembly) = (run(&small("")), run(&small("[cycle]\nassembly = \"n80cb\"")));
    assert_eq!(keys.result.outcome, assembly.result.outcome);
    for source in ["workpiece", "exhaust", "body"] {
        let gap = level(&assembly, source) - level(&keys, source);
        assert!(gap.abs() < 0.005, "{source}: {gap} dB");
    }
    for event in &keys.record.events {
        let other = assembly.record.event(&event.name);
        match (event.time, other) {
            (Some(a), Some(b)) => assert!((a - b).abs() < 1e-6, "{}: {a} {b} s", event.name),
            (a, b) => assert_eq!(a, b, "{}", event.name),
        }
    }
    let figures = |run: &Run| {
        let own = run.result.performance.unwrap();
        [own.head_depth_m, own.energy_left_j, own.air_m3, own.shots_per_second]
    };
    assert!(figures(&keys)[..3].iter().all(Option::is_some), "{:?}", figures(&keys));
    for (of_keys, of_assembly) in figures(&keys).iter().zip(figures(&assembly)) {
        match (of_keys, of_assembly) {
            (Some(a), Some(b)) => assert!((b / a - 1.0).abs() < 2e-3, "{b} {a}"),
            (a, b) => assert_eq!(*a, b),
        }
    }
}

/// Names and values of the checks of elastic blows.
fn blow_checks(run: &Run) -> Vec<(String, bool)> {
    let checks = run.result.checks.iter();
    let of_blows = checks.filter(|check| check.name.contains("elastic blow"));
    of_blows.map(|check| (check.name.to_string(), check.ok)).collect()
}

#[test]
fn an_elastic_blow_of_the_n80cb_as_an_assembly_is_that_of_its_keys() {
    let elastic = "model.blow = \"elastic\"";
    let keys = run(&small(elastic));
    let assembly = run(&small(&format!("{elastic}\n[cycle]\nassembly = \"n80cb\"")));
    let gap = level(&assembly, "workpiece") - level(&keys, "workpiece");
    assert!(gap.abs() < 0.005, "{gap} dB");
    let checks = blow_checks(&assembly);
    assert!(checks.len() == 2 && checks.iter().all(|(_, ok)| *ok), "{checks:?}");
    assert_eq!(checks, blow_checks(&keys));
    assert_eq!(blow_checks(&run(&small("[cycle]\nassembly = \"n80cb\""))), []);
}

/// `model.blow` selects the blow of the built-in tools, and a block without `if` is always elastic.
#[test]
fn a_stapler_has_an_elastic_blow_by_the_key_or_by_its_block() {
    let [by_key, by_block, rigid] = ["model.blow = \"elastic\"", "", ""].map(str::to_owned);
    let own = "[cycle.blow.staple]\nif = true\n";
    for (head, more, count) in [(by_key, "", 2), (by_block, own, 2), (rigid, "", 0)] {
        let run = run(&small(&format!("{head}\n[cycle]\nassembly = \"stapler\"\n{more}")));
        let checks = blow_checks(&run);
        assert!(checks.len() == count && checks.iter().all(|(_, ok)| *ok), "{checks:?}");
    }
}

#[test]
fn an_elastic_blow_of_an_assembly_refuses_two_way_coupling() {
    for text in [
        "support.coupling = \"two-way\"\nmodel.blow = \"elastic\"\n[cycle]\nassembly = \"stapler\"",
        "support.coupling = \"two-way\"\n[cycle]\nassembly = \"stapler\"\n[cycle.blow.staple]\nif = true",
    ] {
        let base = format!("base = \"small.toml\"\n{text}\n");
        let design = Design::parse(&base, std::path::Path::new(ROOT).join("tests/data/over.toml"));
        let refused = design.map_err(Error::from).and_then(|design| chain::shot(&design));
        let refused = refused.unwrap_err().to_string();
        assert!(refused.contains("support.coupling"), "{refused}");
    }
}

#[test]
fn the_loads_of_the_n80cb_are_those_of_its_assembly() {
    let [keys, assembly] = ["", "[cycle]\nassembly = \"n80cb\""].map(|text| chain::shot(&small(text)).unwrap());
    let rms = |values: &[f64]| (values.iter().map(|v| v * v).sum::<f64>() / values.len() as f64).sqrt();
    // The corrections are small differences of large forces.
    for (own, others, limit) in [
        (&keys.record.loads, &assembly.record.loads, 2e-3),
        (&keys.impulse_corrections, &assembly.impulse_corrections, 0.03),
    ] {
        assert_eq!(own.len(), others.len());
        for load in own {
            let other = others.iter().find(|other| other.surface == load.surface).unwrap();
            let samples = load.force.len().min(other.force.len());
            let gap: Vec<f64> = (0..samples).map(|n| load.force[n] - other.force[n]).collect();
            assert!(
                rms(&gap) < limit * rms(&load.force).max(1.0),
                "{}: {} N of {} N",
                load.surface,
                rms(&gap),
                rms(&load.force)
            );
        }
    }
}

#[test]
fn a_stapler_has_three_sources_and_its_housing_radiates_by_its_mass() {
    let run = run(&stapler(""));
    assert_eq!(sources(&run), ["body", "exhaust", "workpiece"]);
    assert_eq!(run.result.outcome, "drives");
    let notes = run.result.notes.join("\n");
    assert!(notes.contains("rigid sphere of its mass, 0.90 kg"), "{notes}");
    let exhaust = run.result.ranking.iter().find(|own| own.source == "exhaust").unwrap();
    assert!(
        exhaust.components.len() >= 2,
        "exhaust and foot are parts of the source"
    );
    // 20 g of piston stop on wood and bumper: the level lies between a click and a framing nailer.
    assert!((60.0..110.0).contains(&run.result.total.lwa_db.unwrap()));
}

#[test]
fn a_gas_spring_tool_without_an_opening_has_two_sources() {
    let text = "[cycle]\nassembly = \"gas_spring_nailer\"\nend = \"30 ms\"\n[cycle.opening]\nbreather = false\n\
                [cycle.passage.breather]\nsilent = true";
    let run = run(&small(text));
    assert_eq!(sources(&run), ["body", "workpiece"]);
    assert!(run.result.notes.iter().any(|note| note.contains("has no opening")));
    assert!((run.result.ranking.iter().map(|own| own.share).sum::<f64>() - 1.0).abs() < 1e-9);
}

#[test]
fn a_blow_gun_has_its_nozzle_as_the_only_source() {
    let run = run(&small("[cycle]\nassembly = \"blow_gun\"\nend = \"40 ms\""));
    assert_eq!(sources(&run), ["exhaust"]);
    assert_eq!(run.result.ranking[0].share, 1.0);
}

/// A design of `designs/tools` on the bodies of the small design, with other values.
fn shipped_on_small_bodies(name: &str, values: &str) -> Design {
    let file = std::path::Path::new(ROOT).join("designs/tools").join(name);
    let own = std::fs::read_to_string(file).unwrap();
    let (_, own) = own.split_once("\nbase = \"../n80cb.toml\"\n").unwrap();
    small(&format!("{values}\n{own}"))
}

#[test]
fn every_design_of_another_tool_reaches_its_ranking() {
    let expected = |name: &str| match name {
        "blow-gun.toml" => (&["exhaust"][..], "blows"),
        "gas-spring-nailer.toml" => (&["body", "exhaust", "workpiece"][..], "drives"),
        "impact-rig.toml" => (&["exhaust", "workpiece"][..], "underdriven"),
        // As the design itself.
        "n80cb-as-published.toml" => (&["body", "exhaust", "workpiece"][..], "strikes_bumper"),
        "stapler.toml" => (&["body", "exhaust", "workpiece"][..], "drives"),
        other => panic!("{other}: add its sources and outcome"),
    };
    for file in std::fs::read_dir(std::path::Path::new(ROOT).join("designs/tools")).unwrap() {
        let name = file.unwrap().file_name().into_string().unwrap();
        let run = run(&shipped_on_small_bodies(&name, ""));
        assert_eq!(
            (&sources(&run)[..], run.result.outcome.as_str()),
            expected(&name),
            "{name}"
        );
        let failed = run.result.checks.iter().filter(|check| !check.ok);
        let failed: Vec<&str> = failed.map(|check| &*check.name).collect();
        assert!(failed.is_empty(), "{name}: {failed:?}");
        assert!(
            (run.result.ranking.iter().map(|own| own.share).sum::<f64>() - 1.0).abs() < 1e-9,
            "{name}"
        );
    }
}

/// The rig over a block, with other values of its launch.
fn rig(launch: &str) -> Design {
    shipped_on_small_bodies("impact-rig.toml", &format!("[launch]\n{launch}"))
}

#[test]
fn an_impact_rig_has_its_block_and_its_vent_as_sources() {
    let vented = run(&rig(""));
    assert_eq!(sources(&vented), ["exhaust", "workpiece"]);
    assert_ne!(vented.result.outcome, "misfires");
    let open = run(&rig("vent_area = \"0 mm2\""));
    assert_eq!(sources(&open), ["workpiece"]);
    assert_eq!(open.result.ranking[0].share, 1.0);
    let notes = [open.result.notes, open.result.method_notes].concat().join("\n");
    for absent in ["has no body `tool`", "has no opening"] {
        assert!(notes.contains(absent), "{notes}");
    }
}

/// Of the stages of a run, only those that its sources read are computed.
#[test]
fn a_tool_without_a_workpiece_solves_no_body_and_computes_no_radiation() {
    let text = "[cycle]\nassembly = \"blow_gun\"\nend = \"40 ms\"\n[acoustics]\nmethod = \"bem\"";
    let folder = folder("assemblies/no-workpiece");
    let (run, chain) = run_with_chain(&small(text), Store::at(folder, LIMIT));
    assert!(chain.structure.is_empty() && chain.tool.is_none());
    let timing = serde_json::to_value(&run.result.timing).unwrap();
    let stages: Vec<&String> = timing.as_object().unwrap().keys().collect();
    assert!(stages.iter().any(|stage| stage.contains("cycle")), "{stages:?}");
    for part in ["mesh", "modes", "radiation", "fluid", "response", "workpiece"] {
        assert!(!stages.iter().any(|stage| stage.contains(part)), "{part} of {stages:?}");
    }
    let notes = [run.result.notes, run.result.method_notes].concat().join("\n");
    assert!(notes.contains("has no body `workpiece`"), "{notes}");
    assert!(!notes.contains("landing") && !notes.contains("response"), "{notes}");
}

/// Of the outcomes of a tool, `study.require` takes those that its assembly declares.
#[test]
fn a_study_requires_outcomes_that_the_assembly_declares() {
    let required = |text: &str| small(text).study().require.clone();
    let own = required("[cycle]\nassembly = \"stapler\"\n[study]\nrequire = [\"misfires\", \"drives\"]");
    assert_eq!(own, ["misfires", "drives"]);
    let declared = "[cycle]\nassembly = \"blow_gun\"\n[cycle.outcome]\nhums = \"steady\"\n[study]\nrequire = \"hums\"";
    assert_eq!(required(declared), ["hums"]);
    // The requirement of the base applies to a tool that knows it.
    assert_eq!(required("[cycle]\nassembly = \"stapler\""), ["drives"]);
    assert!(required("[cycle]\nassembly = \"blow_gun\"").is_empty());
}

#[test]
fn a_required_outcome_that_the_assembly_does_not_declare_is_refused_with_those_it_declares() {
    let refused = |text: &str| {
        let beside = std::path::Path::new(ROOT).join("tests/data/over.toml");
        let error = Design::parse(&format!("base = \"small.toml\"\n{text}"), beside).unwrap_err();
        error.to_string()
    };
    let text = "[cycle]\nassembly = \"blow_gun\"\n[study]\nrequire = \"drives\"";
    let message = refused(text);
    for part in ["study.require", "\"drives\"", "does_not_blow, blows"] {
        assert!(message.contains(part), "{message}");
    }
    let none = "[cycle]\nassembly = \"blow_gun\"\noutcome = []\n[study]\nrequire = \"blows\"";
    assert!(refused(none).contains("[cycle.outcome]"), "{}", refused(none));
}

#[test]
fn a_landing_names_the_keys_of_its_tool() {
    // The hand lifts the tool and lets it fall.
    let text = "[cycle]\nassembly = \"stapler\"\nend = \"60 ms\"\n[cycle.force]\nlift = { on = \"tool\", table = \
                [[\"0 s\", \"0 N\"], [\"20 ms\", \"0 N\"], [\"21 ms\", \"-600 N\"], [\"24 ms\", \"0 N\"]] }\n\
                [cycle.contact.nose]\nstiffness = \"18 kN/mm\"";
    let notes = run(&small(text)).result.notes.join("\n");
    assert!(notes.contains("the tool lands on the workpiece"), "{notes}");
    assert!(
        notes.contains("which depends on `hand.force` and `cycle.contact.nose.stiffness`"),
        "{notes}"
    );
}

#[test]
fn events_of_an_assembly_have_its_own_words() {
    let text = "[cycle]\nassembly = \"stapler\"\n[cycle.event]\n\
                t12 = { text = \"piston returns\", becomes = \"piston.speed < 0 m/s\", after = \"strike\" }\n\
                t13 = { becomes = \"piston.travel <= 10 mm\", after = \"t12\" }";
    let run = run(&small(text));
    let words = &run.result.event_words;
    assert_eq!(words.in_words("t12"), "t12 piston returns");
    assert_eq!(words.in_words("t13"), "t13");
    assert_eq!(words.in_words("strike"), "strike: driver meets the staple");
    let keys = crate::common::run(&small(""));
    assert_eq!(keys.result.event_words.in_words("t12"), "t12 trigger valve released");
}

#[test]
fn an_expansion_chamber_lowers_the_exhaust() {
    let (bare, chamber) = (run(&small("")), run(&small("[cycle]\nassembly = \"n80cb_chamber\"")));
    assert!(level(&chamber, "exhaust") < level(&bare, "exhaust") - 0.5);
}

/// Names of the variables of a study.
fn names(variables: &[Variable]) -> Vec<&str> {
    variables.iter().map(|own| own.name.as_str()).collect()
}

#[test]
fn a_study_draws_literals_and_keys_of_an_assembly_and_no_key_without_effect() {
    let all = variables(&stapler("")).unwrap();
    let names = names(&all);
    for key in [
        "staple.force",
        "valve.exhaust_area",
        "cycle.contact.support.stiffness",
        "piston.mass",
    ] {
        assert!(names.contains(&key), "{key} of {names:?}");
    }
    for key in [
        "head_valve.mass",
        "trigger.fill_area",
        "chambers.return_volume",
        "nail.feed_height",
    ] {
        assert!(!names.contains(&key), "{key}");
    }
}

#[test]
fn a_literal_that_is_set_changes_the_shot_and_nothing_else() {
    let base = stapler("");
    let key = "cycle.contact.support.stiffness";
    let mut soft = base.clone();
    soft.set(&[(key, Value::Number(2e7))]).unwrap();
    let entry = |design: &Design| design.entries().into_iter().find(|own| own.key == key).unwrap().value;
    assert_eq!([entry(&base), entry(&soft)], [Value::Number(1e8), Value::Number(2e7)]);
    assert_ne!(base.digest(), soft.digest());
    let keys = |design: &Design| {
        let chain = Chain::new(&Graph::default(), design, Options::default()).unwrap();
        (*chain.cycle.key(), *chain.structure[0].modes.key())
    };
    let (before, after) = (keys(&base), keys(&soft));
    assert_ne!(before.0, after.0);
    assert_eq!(before.1, after.1);
    assert!(base.clone().set(&[(key, Value::Number(-1.0))]).is_err());
}

#[test]
fn switches_that_an_assembly_does_not_follow_are_refused_at_their_place() {
    for (key, text) in [
        ("model.gas", "model.gas = \"published\""),
        ("model.blow", "model.blow = \"elastic\""),
        ("wood.penetration_law", "wood.penetration_law = \"constant\""),
    ] {
        let own = small(&format!("{text}\n[cycle]\nassembly = \"blow_gun\""));
        let refused = chain::shot(&own).unwrap_err();
        let Error::Design(error) = refused else {
            panic!("{key}: {refused}")
        };
        assert!(error.to_string().contains(key), "{error}");
    }
}

#[test]
fn an_assembly_based_on_the_n80cb_follows_the_switches_of_the_model_and_the_wood() {
    let shot = |text: &str, cycle: &str| {
        chain::shot(&small(&format!("{text}\n{cycle}")))
            .unwrap()
            .fastener_depth()
    };
    let own = "[cycle]\nassembly = \"n80cb\"";
    for text in ["", "model.gas = \"published\"", "wood.penetration_law = \"constant\""] {
        let (of_assembly, of_keys) = (shot(text, own), shot(text, ""));
        assert!(
            (of_assembly - of_keys).abs() < 1e-6,
            "{text}: {of_assembly} m, {of_keys} m"
        );
    }
    assert!((shot("model.gas = \"published\"", own) - shot("", own)).abs() > 1e-5);
}

/// The speed that splits the force of a nail is that of the driver in the wood, and only where the law depends on it.
#[test]
fn a_fastener_of_an_assembly_has_a_speed_where_its_resistance_depends_on_it() {
    let own = "[cycle]\nassembly = \"n80cb\"";
    let rate = "wood.rate = \"speed\"";
    let [keys, assembly] = ["", own].map(|cycle| chain::shot(&small(&format!("{rate}\n{cycle}"))).unwrap());
    let record = &keys.record;
    let speed = assembly.workpiece.unwrap().fastener_speed.unwrap();
    let expected = record
        .history("piston.velocity")
        .iter()
        .zip(record.history("workpiece.velocity"));
    let expected: Vec<f64> = expected.map(|(piston, wood)| (piston - wood).max(0.0)).collect();
    let fastest = expected.iter().copied().fold(0.0, f64::max);
    assert!(fastest > 10.0, "{fastest} m/s");
    let rms = |values: &mut dyn Iterator<Item = f64>| {
        let (count, sum) = values.fold((0.0, 0.0), |(count, sum), v| (count + 1.0, sum + v * v));
        (sum / count).sqrt()
    };
    let gap = rms(&mut speed.iter().zip(&expected).map(|(a, b)| a - b));
    assert!(gap < 1e-3 * fastest, "{gap} of {fastest} m/s");
    assert!(
        chain::shot(&small(own))
            .unwrap()
            .workpiece
            .unwrap()
            .fastener_speed
            .is_none()
    );
}

/// Of the exhaust's path, and of no other volume; the one of the N80CB follows from its histories.
#[test]
fn volumes_of_the_exhausts_path_state_how_much_gas_leaves_choked() {
    let fraction = |shot: &ShotRecord, volume: &str| shot.figures.get(&format!("{volume}_choked_fraction"));
    let [keys, plain, chamber] = [
        "",
        "[cycle]\nassembly = \"n80cb\"",
        "[cycle]\nassembly = \"n80cb_chamber\"",
    ]
    .map(|cycle| chain::shot(&small(cycle)).unwrap());
    let record = &keys.record;
    let critical = (2.0_f64 / 2.4).powf(3.5);
    let flows = record.history("exhaust.mass_flow").iter().map(|flow| flow.max(0.0));
    let (mut choked, mut total) = (0.0, 0.0);
    for (flow, pressure) in flows.zip(record.history("above_piston.pressure")) {
        total += flow;
        choked += if keys.ambient_pressure < critical * pressure {
            flow
        } else {
            0.0
        };
    }
    let own = fraction(&plain, "above_piston").unwrap();
    assert!((own - choked / total).abs() < 1e-4, "{own} {}", choked / total);
    assert!(fraction(&plain, "below_piston").is_none() && fraction(&plain, "supply").is_none());
    let (cylinder, silencer) = (fraction(&chamber, "above_piston"), fraction(&chamber, "silencer"));
    // The chamber fills later, so that less of its gas leaves above the critical pressure.
    assert!(
        0.0 < silencer.unwrap() && silencer < cylinder,
        "{cylinder:?} {silencer:?}"
    );
    let without = "[cycle]\nassembly = \"n80cb_chamber\"\n[cycle.volume.silencer]\nexhaust_path = false";
    assert!(fraction(&chain::shot(&small(without)).unwrap(), "silencer").is_none());
}

#[test]
fn an_assembly_of_the_n80cb_has_its_columns() {
    let [keys, assembly] = ["", "[cycle]\nassembly = \"n80cb\""].map(|cycle| chain::shot(&small(cycle)).unwrap());
    let (of_keys, of_assembly) = (columns(&keys.record), columns(&assembly.record));
    for column in &of_keys {
        let same: Vec<_> = of_assembly.iter().filter(|own| own.name == column.name).collect();
        let [own] = same[..] else {
            panic!("{} columns {}", same.len(), column.name)
        };
        let zero = own.values.iter().all(|value| *value == 0.0);
        assert!(
            own.unit == column.unit || zero,
            "{}: {} {}",
            column.name,
            own.unit,
            column.unit
        );
        let peak = column.values.iter().fold(0.0, |peak: f64, value| peak.max(value.abs()));
        let gap = own.values.iter().zip(column.values).map(|(a, b)| (a - b).powi(2));
        let gap = (gap.sum::<f64>() / column.values.len() as f64).sqrt();
        assert!(gap <= 5e-3 * peak, "{}: {gap} of {peak}", column.name);
    }
}

/// A stapler has no event t7; `[cycle.marker]` names its own, and a name that it does not have is refused.
#[test]
fn markers_of_a_measurement_have_the_events_of_the_assembly() {
    let events = |cycle: &str| {
        let design = small(&format!("[cycle]\nassembly = {cycle}"));
        virtual_test::arrangement(&design).map(|own| own.events)
    };
    assert_eq!(events("\"n80cb\"").unwrap(), MarkerEvents::default());
    assert_eq!(events("\"stapler\"").unwrap().iter().count(), 0);
    let own = events("\"stapler\"\n[cycle.marker]\nt4 = \"strike\"").unwrap();
    assert_eq!(own.iter().collect::<Vec<_>>(), [("t4", "strike")]);
    let wrong = "base = \"small.toml\"\n[cycle]\nassembly = \"stapler\"\n[cycle.marker]\nt4 = \"t7\"\n";
    let beside = std::path::Path::new(ROOT).join("tests/data/over.toml");
    let refused = Design::parse(wrong, beside).unwrap_err().to_string();
    assert!(refused.contains("cycle.marker.t4"), "{refused}");
}

#[test]
fn two_way_coupling_without_a_workpiece_is_refused_at_its_place() {
    let own = small("support.coupling = \"two-way\"\n[cycle]\nassembly = \"blow_gun\"");
    let refused = chain::shot(&own).unwrap_err().to_string();
    assert!(refused.contains("support.coupling"), "{refused}");
}

#[test]
fn shipped_designs_with_assemblies_load_and_name_their_sources() {
    for (path, count) in [
        ("designs/tools/stapler.toml", 3),
        ("designs/tools/gas-spring-nailer.toml", 3),
        ("designs/tools/blow-gun.toml", 1),
        ("designs/tools/n80cb-as-published.toml", 3),
        ("designs/tools/impact-rig.toml", 2),
        ("designs/quieter/expansion-chamber.toml", 3),
    ] {
        let chain = Chain::new(&Graph::default(), &design(path), Options::default()).unwrap();
        assert_eq!(chain.source_names().count(), count, "{path}");
    }
}
