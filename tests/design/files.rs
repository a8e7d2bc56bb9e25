//! The design file: reading, derived values, refusals and their messages.

use std::collections::BTreeMap;
use std::fs;
use std::path::Path;

use miette::{Diagnostic, GraphicalReportHandler, GraphicalTheme};
use nailnoise::design::{
    Assignment, DERIVED, Design, DesignError, Entry, Problem, Provenance, RangeOrigin, Rings, SupportKind, Value,
    reference,
};
use proptest::prelude::*;

const BASE: &str = "designs/n80cb.toml";

fn load(path: &str) -> Design {
    Design::load(path).unwrap_or_else(|error| panic!("{}", render(&error)))
}

/// A design with `text` over the N80CB.
fn over(text: &str) -> Result<Design, DesignError> {
    Design::parse(&format!("base = \"n80cb.toml\"\n{text}\n"), "designs/over.toml")
}

fn changed(text: &str) -> Design {
    over(text).unwrap_or_else(|error| panic!("{}", render(&error)))
}

fn render(diagnostic: &dyn Diagnostic) -> String {
    let mut text = String::new();
    GraphicalReportHandler::new_themed(GraphicalTheme::unicode_nocolor())
        .with_width(100)
        .render_report(&mut text, diagnostic)
        .expect("writing to a string");
    text
}

/// The text with the lines and columns of the N80CB's file left out, so that editing the file changes no snapshot.
fn without_base_lines(text: &str) -> String {
    let mut parts = text.split("n80cb.toml:");
    let first = parts.next().unwrap_or("").to_owned();
    parts.fold(first, |text, part| {
        let rest = part.trim_start_matches(|c: char| c.is_ascii_digit() || c == ':');
        format!("{text}n80cb.toml:LINE{rest}")
    })
}

fn entries(design: &Design) -> BTreeMap<String, Entry> {
    design
        .entries()
        .into_iter()
        .map(|entry| (entry.key.clone(), entry))
        .collect()
}

fn number(value: Value) -> f64 {
    match value {
        Value::Number(number) => number,
        Value::Count(count) => f64::from(count),
        other => panic!("{other:?} is no number"),
    }
}

/// Values under every key of a design file.
fn settings(table: &toml::Table, path: &str, found: &mut BTreeMap<String, toml::Value>) {
    for (name, value) in table {
        let key = if path.is_empty() {
            name.clone()
        } else {
            format!("{path}.{name}")
        };
        match value {
            toml::Value::Table(table) if !table.contains_key("value") => settings(table, &key, found),
            value => drop(found.insert(key, value.clone())),
        }
    }
}

/// A number with its unit in SI units. The power of ten is joined to the digits, so that the binary number is the
/// nearest.
fn si(number: &str, unit: &str) -> f64 {
    let power = match unit {
        "deg" => return number.parse::<f64>().unwrap().to_radians(),
        "degC" => return number.parse::<f64>().unwrap() + 273.15,
        "GPa" | "N/mm3" => 9,
        "MPa" | "kN/mm" => 6,
        "kPa" | "kPa s/m2" | "kHz" | "N/mm" | "N s/mm" => 3,
        "mm" | "mm/s" | "ms" | "g" | "l" => -3,
        "cm2" => -4,
        "mm2" | "cm3" | "us" | "uPa s" => -6,
        "" | "m" | "m2" | "s" | "Hz" | "kg" | "kg/m3" | "N" | "N s/m" | "m/s" | "m/s2" | "m2/s2" | "J/(kg K)"
        | "W/(m2 K)" => 0,
        other => panic!("the unit {other} has no power of ten here"),
    };
    let (digits, exponent) = number.split_once('e').unwrap_or((number, "0"));
    let exponent: i32 = exponent.parse().unwrap();
    format!("{digits}e{}", power + exponent).parse().unwrap()
}

/// The numbers of a text in SI units: one of a quantity, two of a range; none of a word.
fn numbers(text: &str) -> Vec<f64> {
    let words: Vec<&str> = text.split(' ').collect();
    let is_number = |word: &&&str| **word == ".." || word.parse::<f64>().is_ok();
    let unit = words.iter().take_while(is_number).count();
    let digits = words[..unit].iter().filter(|word| **word != "..");
    digits.map(|number| si(number, &words[unit..].join(" "))).collect()
}

/// Whether both are the same numbers; angles and temperatures, which are computed, are the same to rounding.
fn same(found: &[f64], expected: &[f64]) -> bool {
    let near = |(a, b): (&f64, &f64)| (a - b).abs() <= f64::EPSILON * b.abs();
    found.len() == expected.len() && found.iter().zip(expected).all(near)
}

#[test]
fn values_and_ranges_are_those_of_the_file_in_si_units() {
    let text = fs::read_to_string(BASE).unwrap();
    let mut file = BTreeMap::new();
    settings(&text.parse().unwrap(), "", &mut file);
    // The preset of its worktable sets the build.
    let tables: toml::Table = include_str!("../../src/design/catalogue/worktables.toml")
        .parse()
        .unwrap();
    settings(tables["A"]["sets"].as_table().unwrap(), "", &mut file);
    // A list gives a value per band.
    let octaves = file.remove("exhaust.muffler.octaves").unwrap();
    let bands = [63, 125, 250, 500, 1000, 2000, 4000, 8000, 16000];
    for (band, value) in bands.iter().zip(octaves["value"].as_array().unwrap()) {
        file.insert(format!("exhaust.muffler.octaves.{band}"), value.clone());
    }
    // No keys of the design, and derived quantities.
    let is_derived = |key: &String| DERIVED.iter().any(|derived| key.starts_with(derived.key));
    file.retain(|key, _| !key.starts_with("study.") && !is_derived(key));
    let entries = entries(&load(BASE));
    assert_eq!(file.keys().collect::<Vec<_>>(), entries.keys().collect::<Vec<_>>());
    for (key, given) in &file {
        let entry = &entries[key];
        match (given.get("value").unwrap_or(given), &entry.value) {
            (toml::Value::String(text), Value::Number(own)) => {
                assert!(same(&[*own], &numbers(text)), "{key} is {own}, not {text}");
            }
            (toml::Value::String(text), Value::Choice(word)) => assert_eq!(text, word, "{key}"),
            (toml::Value::String(text), Value::File(path)) => assert_eq!(text, path, "{key}"),
            (toml::Value::String(text), Value::Name(name)) => assert_eq!(*text, name.0, "{key}"),
            (toml::Value::Boolean(on), Value::Switch(own)) => assert_eq!(on, own, "{key}"),
            (toml::Value::Float(number), Value::Number(own)) => assert_eq!(number, own, "{key}"),
            (toml::Value::Integer(number), own) => assert_eq!(*number as f64, self::number(own.clone()), "{key}"),
            other => panic!("{key}: {other:?}"),
        }
        let range = entry.range.map_or_else(Vec::new, |range| range.to_vec());
        let text = given.get("range").map_or("", |range| range.as_str().unwrap());
        assert!(
            same(&range, &numbers(text)),
            "the range of {key} is {range:?}, not {text}"
        );
    }
}

#[test]
fn every_number_of_the_cycle_has_a_range() {
    let groups = [
        "supply",
        "piston",
        "head_valve",
        "chambers",
        "exhaust",
        "trigger",
        "nail",
        "wood",
        "contacts",
        "tool",
        "hand",
        "model",
    ];
    let base = load(BASE);
    let followers: Vec<&str> = base.drawn_derived().map(|(_, solution)| solution.follower).collect();
    for (key, entry) in entries(&base) {
        let group = key.split('.').next().unwrap();
        let fixed =
            matches!(entry.provenance, Provenance::Constant | Provenance::Decided) || followers.contains(&key.as_str());
        if groups.contains(&group) && matches!(entry.value, Value::Number(_)) && !fixed && !key.contains(".muffler.") {
            assert!(entry.range.is_some(), "{key} has no range");
        }
    }
}

#[test]
fn every_quantity_says_where_it_comes_from() {
    for entry in load(BASE).entries() {
        assert_ne!(entry.provenance, Provenance::Design, "{} has no provenance", entry.key);
        if entry.provenance == Provenance::Estimated && matches!(entry.value, Value::Number(_)) {
            assert!(entry.range.is_some(), "{} is estimated and has no range", entry.key);
        }
    }
}

#[test]
fn derived_quantities_follow_from_the_primary_ones() {
    let design = load(BASE);
    for (key, value, tolerance) in [
        ("workpiece.mass", 2.5335318619584, 1e-12),
        ("nail.mass", 0.007814578377566488, 1e-12),
        // The reference takes c = 343 m/s, the design file 343.2 m/s from the temperature: 0.2 us.
        ("trigger.delay", 0.0002915451895043732, 1e-3),
        ("trigger.fill_attenuation", 0.9998, 1e-4),
        ("trigger.vent_attenuation", 0.998, 1e-4),
        ("piston.area", 0.0028274333882308137, 1e-12),
        ("piston.rod_area", 3.318307240354219e-05, 1e-12),
        ("piston.lower_area", 0.0027942503158272713, 1e-12),
        ("head_valve.control_area", 0.0014095462298677666, 1e-12),
        ("head_valve.supply_area", 0.0002353759755885813, 1e-12),
        ("exhaust.area", 1.4e-4, 1e-5),
        ("ambient.density", 1.204, 1e-3),
        ("ambient.sound_speed", 343.2, 1e-3),
        ("support.sand.shear_speed", 111.8, 1e-3),
    ] {
        let derived = DERIVED
            .iter()
            .find(|derived| derived.key == key)
            .expect("a derived quantity");
        let own = (derived.value)(&design);
        assert!((own / value - 1.0).abs() < tolerance, "{key} is {own}, not {value}");
    }
}

#[test]
fn ready_designs_load_without_warnings() {
    for path in [
        BASE,
        "designs/n80cb-sandbox.toml",
        "designs/n80cb-free.toml",
        "designs/n80cb-feet.toml",
        "designs/n80cb-board.toml",
        "tests/data/small.toml",
    ] {
        let design = load(path);
        assert!(
            design.warnings().is_empty(),
            "{path}: {}",
            render(&design.warnings()[0])
        );
    }
    assert_eq!(load("tests/data/small.toml").name(), "small");
}

#[test]
fn the_sandbox_differs_in_the_support_only() {
    let (table, sand) = (entries(&load(BASE)), entries(&load("designs/n80cb-sandbox.toml")));
    let differ: Vec<_> = table
        .keys()
        .filter(|key| table[*key].value != sand[*key].value)
        .collect();
    assert_eq!(differ, ["support.kind"]);
    assert_eq!(load("designs/n80cb-sandbox.toml").support.kind, SupportKind::Sandbox);
}

#[test]
fn a_bare_value_keeps_the_note_and_the_range_in_proportion_and_becomes_the_designs_own() {
    let (base, own) = (entries(&load(BASE)), entries(&changed("hand.force = \"120 N\"")));
    let (base, own) = (&base["hand.force"], &own["hand.force"]);
    assert_eq!(
        (base.provenance, own.provenance),
        (Provenance::Estimated, Provenance::Design)
    );
    assert_eq!((own.value.clone(), &own.note), (Value::Number(120.0), &base.note));
    // 110 N with 40 to 150 N.
    assert_near(own.range, [40.0 / 110.0 * 120.0, 150.0 / 110.0 * 120.0]);
    assert_eq!(own.range_origin, Some(RangeOrigin::AssumedFromBase));
    assert_eq!(base.range_origin, Some(RangeOrigin::Given));
    assert_eq!((own.file.as_str(), own.line), ("designs/over.toml", 2));
    assert_eq!(base.file, BASE);
}

#[test]
fn a_table_replaces_only_what_it_gives() {
    let own = entries(&changed(
        "hand.force = { range = \"100 .. 120 N\", note = \"a scale\" }",
    ));
    let own = &own["hand.force"];
    assert_eq!(
        (own.value.clone(), own.range),
        (Value::Number(110.0), Some([100.0, 120.0]))
    );
    assert_eq!((own.provenance, own.note.as_str()), (Provenance::Estimated, "a scale"));
    let own = entries(&changed(
        "hand.force = { value = 115, provenance = \"published: EN 12549\" }",
    ));
    let own = &own["hand.force"];
    assert_eq!(
        (own.provenance, own.source.as_str()),
        (Provenance::Published, "EN 12549")
    );
    assert_near(own.range, [40.0 / 110.0 * 115.0, 150.0 / 110.0 * 115.0]);
}

fn assert_near(range: Option<[f64; 2]>, expected: [f64; 2]) {
    let found = range.unwrap_or([f64::NAN; 2]);
    let near = found
        .iter()
        .zip(expected)
        .all(|(own, other)| (own - other).abs() <= 1e-9 * other.abs());
    assert!(near, "{found:?}, expected {expected:?}");
}

#[test]
fn a_range_may_be_a_width_around_the_value_or_none() {
    let of = |text: &str| entries(&changed(text))["hand.force"].range;
    assert_near(
        of("hand.force = { value = \"120 N\", range = \"+-10 %\" }"),
        [108.0, 132.0],
    );
    assert_near(
        of("hand.force = { value = \"120 N\", range = \"+-5 N\" }"),
        [115.0, 125.0],
    );
    assert_near(
        of("hand.force = { value = \"120 N\", range = \"exact\" }"),
        [120.0, 120.0],
    );
    // Around the value of the base, if a file gives only the width.
    assert_near(of("hand.force.range = \"+-10 %\""), [99.0, 121.0]);
}

#[test]
fn the_default_range_of_the_study_is_that_of_all_values_without_one() {
    let own = |default: &str| {
        let design = changed(&format!("study.default_range = \"{default}\"\nhand.force = \"120 N\""));
        let entries = entries(&design);
        (entries["hand.force"].clone(), entries["piston.mass"].clone())
    };
    let (force, mass) = own("+-5 %");
    assert_near(force.range, [114.0, 126.0]);
    assert_eq!(force.range_origin, Some(RangeOrigin::AssumedByDefault));
    // A value of the base has the range that the base states.
    assert_eq!(
        (mass.range, mass.range_origin),
        (Some([0.129, 0.133]), Some(RangeOrigin::Given))
    );
    assert_near(own("exact").0.range, [120.0, 120.0]);
    assert_near(own("base").0.range, [40.0 / 110.0 * 120.0, 150.0 / 110.0 * 120.0]);
    assert!(over("study.default_range = \"10\"").is_err());
}

/// Files between the design and the file that states the range do not matter, 0 among their values neither.
#[test]
fn the_range_of_a_value_does_not_depend_on_the_values_in_between() {
    let direct = entries(&changed("hand.force = \"120 N\""))["hand.force"].range;
    for between in ["0 N", "80 N", "500 N"] {
        let assignments =
            [format!("hand.force={between}"), "hand.force=120 N".to_owned()].map(|text| text.parse().unwrap());
        let design = Design::load_with(BASE, &assignments).unwrap();
        assert_eq!(entries(&design)["hand.force"].range, direct, "{between}");
    }
}

#[test]
fn a_range_without_its_value_is_an_error() {
    for text in [
        "hand.force = { value = \"200 N\", range = \"100 .. 150 N\" }",
        "hand.force = { range = \"115 .. 150 N\" }", // the base's 110 N
    ] {
        let error = over(text).unwrap_err();
        assert!(
            matches!(&error.problem, Problem::RangeWithoutValue { key, .. } if key == "hand.force"),
            "{error}"
        );
        assert!(error.remedy().contains("+-10 %"), "{}", error.remedy());
    }
    // The value of a nearer file is within the range that a base states for it.
    assert!(over("hand.force = { value = \"120 N\", range = \"115 .. 150 N\" }").is_ok());
}

#[test]
fn a_numerical_setting_is_one_with_another_value() {
    let own = entries(&changed("analysis.time_step = \"2 us\""));
    assert_eq!(own["analysis.time_step"].provenance, Provenance::Numerical);
}

fn area(text: &str) -> Option<Entry> {
    let design = changed(text);
    design.drawn_derived().next().map(|(entry, _)| entry)
}

#[test]
fn the_range_of_a_derived_quantity_follows_the_primary_ones() {
    let base = area("").unwrap();
    assert_eq!((base.key.as_str(), base.range), ("exhaust.area", Some([1e-4, 1e-3])));
    let number = |entry: &Entry| self::number(entry.value.clone());
    for text in [
        "exhaust.holes = 12",
        "exhaust = { holes = 12, hole_diameter = \"3 mm\" }",
    ] {
        let own = area(text).unwrap();
        let ratio = number(&own) / number(&base);
        assert_near(own.range, [1e-4 * ratio, 1e-3 * ratio]);
        assert_eq!(own.range_origin, Some(RangeOrigin::AssumedFromBase));
    }
}

#[test]
fn a_derived_quantity_is_drawn_where_no_nearer_file_gives_its_follower_a_range() {
    assert!(area("exhaust.hole_diameter = { value = \"6 mm\", range = \"exact\" }").is_none());
    assert!(area("exhaust.holes = { value = 6, range = \"exact\" }").is_some());
    let by_holes = changed("exhaust.area = { range = \"50 .. 300 mm2\", follows = \"holes\" }");
    let (_, solution) = by_holes.drawn_derived().next().unwrap();
    assert_eq!(solution.follower, "exhaust.holes");
    assert_eq!(entries(&by_holes)["exhaust.holes"].range, None);
    for wrong in [
        "exhaust.area = { range = \"50 .. 300 mm2\", follows = \"pitch\" }",
        "exhaust.area = { range = \"200 .. 300 mm2\" }", // without the 140 mm2
        "exhaust.area = { range = \"50 .. 300 mm2\" }\nexhaust.hole_diameter = \
         { value = \"6 mm\", range = \"+-10 %\" }",
        "piston.area = { range = \"2000 .. 3000 mm2\" }",
    ] {
        assert!(over(wrong).is_err(), "{wrong}");
    }
}

#[test]
fn inheritance_passes_through_several_files() {
    let text = "base = \"../tests/data/small.toml\"\nanalysis.range_high = \"1 kHz\"";
    let design = Design::parse(text, "designs/through.toml").unwrap();
    assert_eq!(
        (design.analysis.range_high, design.analysis.workpiece_max_frequency),
        (1e3, 2e3)
    );
    assert_eq!(design.piston.mass, 0.131);
}

#[test]
fn an_exhaust_that_ends_below_the_levels_is_a_warning_with_its_bands() {
    let design = changed("[analysis]\nexhaust_max_frequency = \"6.5 kHz\"");
    let [warning] = design.warnings() else {
        panic!("{:?}", design.warnings())
    };
    let said = render(warning).split_whitespace().collect::<Vec<_>>().join(" ");
    for words in [
        "`analysis.exhaust_max_frequency` = 6500 Hz",
        "from 6300 to 10000 Hz",
        "exhaust_max_frequency = \"6.5 kHz\"",
    ] {
        assert!(said.contains(words), "{words}: {said}");
    }
    // One range for all sources.
    assert!(
        changed("[analysis]\nexhaust_max_frequency = \"6.5 kHz\"\nrange_high = \"6.5 kHz\"")
            .warnings()
            .is_empty()
    );
}

#[test]
fn a_value_outside_its_range_is_a_warning() {
    let design = changed("[hand]\nforce = \"200 N\"");
    insta::assert_snapshot!(render(&design.warnings()[0]));
    assert_eq!(design.warnings().len(), 1);
    // Both ends belong to the range.
    assert!(changed("hand.force = \"150 N\"").warnings().is_empty());
    // A range of the design's own takes the place of the base's.
    assert!(
        changed("hand.force = { value = 200, range = [150, 250] }")
            .warnings()
            .is_empty()
    );
}

/// 5 holes of 8 mm have 251.3 mm2.
#[test]
fn a_primary_quantity_follows_from_a_derived_one_where_the_design_says_so() {
    let area = "251.32741228718345 mm2";
    let is_8_mm = |design: &Design| (design.exhaust.hole_diameter / 8e-3 - 1.0).abs() < 1e-12;
    let by_diameter = changed(&format!(
        "exhaust.area = {{ value = \"{area}\", follows = \"hole_diameter\" }}"
    ));
    assert!(is_8_mm(&by_diameter) && by_diameter.exhaust.holes == 5);
    let entry = &entries(&by_diameter)["exhaust.hole_diameter"];
    assert_eq!((entry.line, entry.source.as_str()), (2, "follows from `exhaust.area`"));
    // The range of the base, 100 to 1000 mm2 around 140 mm2, is scaled.
    let drawn = by_diameter.drawn_derived().next().unwrap().0;
    let ratio = by_diameter.exhaust.area() / load(BASE).exhaust.area();
    assert_near(drawn.range, [1e-4 * ratio, 1e-3 * ratio]);
    // A range in the same file is that of the value.
    let ranged = changed("exhaust.area = { value = \"300 mm2\", range = \"200 .. 400 mm2\", follows = \"holes\" }");
    assert_eq!(ranged.exhaust.holes, 11);
    assert_near(ranged.drawn_derived().next().unwrap().0.range, [2e-4, 4e-4]);
    // On the command line, the value alone is sufficient. A value of the follower in the same place must agree with it.
    let with = |sets: &[&str]| {
        let sets: Vec<Assignment> = sets.iter().map(|set| set.parse().unwrap()).collect();
        Design::load_with(BASE, &sets)
    };
    assert!(is_8_mm(&with(&[&format!("exhaust.area={area}")]).unwrap()));
    assert!(with(&["exhaust.area=200mm2", "exhaust.hole_diameter=8mm"]).is_err());
    assert!(with(&["piston.area=2000mm2"]).is_err());
    assert!(with(&["exhaust.area=-1mm2"]).is_err());
}

#[test]
fn a_derived_quantity_that_agrees_has_no_effect_and_warns() {
    let design = changed("exhaust.area = \"140 mm2\"");
    insta::assert_snapshot!(render(&design.warnings()[0]));
    assert_eq!(design.digest(), load(BASE).digest());
    // The derived quantity is compared with the design's own primary quantities.
    assert!(over("exhaust.area = \"280 mm2\"").is_err());
    assert_eq!(
        changed("exhaust = { holes = 10, area = \"280 mm2\" }").warnings().len(),
        1
    );
}

#[test]
fn gauge_pressure_counts_from_the_designs_ambient_pressure() {
    let psi = 6_894.757_293_168_361;
    let sea = changed("supply.pressure = \"96 psig\"").supply.pressure;
    assert!((sea - (96.0 * psi + 101_325.0)).abs() < 1e-6);
    let high = changed("ambient.pressure = \"80 kPa\"\nsupply.pressure = \"96 psig\"")
        .supply
        .pressure;
    assert!((sea - high - 21_325.0).abs() < 1e-6);
    assert!((changed("supply.pressure = \"110.7 psi\"").supply.pressure - 110.7 * psi).abs() < 1e-6);
    let range = entries(&changed("supply.pressure = { range = \"70 .. 120 psig\" }"))["supply.pressure"].range;
    assert!((range.unwrap()[0] - (70.0 * psi + 101_325.0)).abs() < 1e-6);
}

#[test]
fn the_digest_follows_the_values_and_nothing_else() {
    let base = load(BASE);
    for same in [
        "piston.mass = 0.131",
        "[piston]\nmass = { value = \"131000 mg\", note = \"weighed\", range = [0.1, 0.2] }",
        "piston = { mass = \"131e-3 kg\" }",
        "piston.stroke = \"4.773622047244094 in\"",
        "ambient.temperature = 293.15",
        "supply.pressure = { range = \"0 .. 2 MPa\", provenance = \"decided\" }",
    ] {
        assert_eq!(changed(same).digest(), base.digest(), "{same}");
    }
    for entry in base.entries() {
        let text = match entry.value {
            Value::Number(0.0) => format!("{} = 1e-3", entry.key),
            Value::Number(value) => format!("{} = {:e}", entry.key, value * 0.999),
            Value::Count(count) => format!("{} = {}", entry.key, count + 1),
            Value::Switch(on) => format!("{} = {}", entry.key, !on),
            Value::Choice(_) | Value::File(_) | Value::Name(_) => continue,
        };
        assert_ne!(changed(&text).digest(), base.digest(), "{text}");
    }
    assert_ne!(changed("model.gas = \"published\"").digest(), base.digest());
}

#[test]
fn a_program_may_change_values_and_check_them() {
    let mut design = load(BASE);
    let digest = design.digest();
    design.supply.pressure *= 1.1;
    assert_ne!(design.digest(), digest);
    assert_eq!(entries(&design)["supply.pressure"].provenance, Provenance::Design);
    assert_eq!(design.conflict(), None);
    design.ambient.heat_capacity_ratio = 1.0;
    assert_eq!(design.conflict().unwrap().keys(), ["ambient.heat_capacity_ratio"]);
    design.ambient.heat_capacity_ratio = 1.4;
    design.nail.length = 0.1;
    assert_eq!(
        design.conflict().unwrap().keys(),
        ["nail.length", "workpiece.thickness"]
    );
}

/// Conflicting values: the message of the design, and the key at which the error points.
const CONFLICTS: &[(&str, &str)] = &[
    ("nail.head_thickness = \"83 mm\"", "nail.head_thickness"),
    ("nail.diameter = \"8 mm\"", "nail.diameter"),
    (
        "exhaust = { fitting.kind = \"pipe\", muffler.kind = \"chamber\" }",
        "exhaust.fitting.kind",
    ),
    ("piston.rod_protrusion = \"40 mm\"", "piston.rod_protrusion"),
    ("head_valve.seat_diameter = \"50 mm\"", "head_valve.seat_diameter"),
    ("head_valve.outer_diameter = \"63 mm\"", "head_valve.outer_diameter"),
    ("head_valve.intake_lap = \"4.7 mm\"", "head_valve.intake_lap"),
    (
        "chambers.check_hole_position = \"130 mm\"",
        "chambers.check_hole_position",
    ),
    ("piston.friction.static_force = 11", "piston.friction"),
    ("head_valve.friction.sliding_force = 27", "head_valve.friction"),
    ("nail.offset_along = \"200 mm\"", "nail.offset_along"),
    ("nail.offset_across = \"-65 mm\"", "nail.offset_across"),
    ("support.worktable.length = \"400 mm\"", "support.worktable.length"),
    (
        "support.worktable.leg_width = \"200 mm\"",
        "support.worktable.leg_width",
    ),
    ("support.worktable.height = \"30 mm\"", "support.worktable.height"),
    ("support.worktable.top.nu13 = 4", "support.worktable.top"),
    ("support.worktable.legs.nu23 = -1.4", "support.worktable.legs"),
    (
        "support = { kind = \"sandbox\", sand.box_width = \"150 mm\" }",
        "support.sand.box_width",
    ),
    (
        "support = { kind = \"sandbox\", sand.box_depth = \"95 mm\" }",
        "support.sand.box_depth",
    ),
    (
        "support = { kind = \"sandbox\", sand.poisson_ratio = 0.5 }",
        "support.sand.poisson_ratio",
    ),
    ("analysis.range_low = \"10 kHz\"", "range of the ranking"),
    ("analysis.time_step = \"20 us\"", "time step of 20 us"),
    ("analysis.cycle_tail = \"0.3 s\"", "analysis.cycle_tail"),
    ("trigger.release_after = \"0.2 s\"", "trigger.release_after"),
];

#[test]
fn a_value_outside_its_domain_is_refused_by_its_key() {
    for (key, value) in [
        ("ambient.heat_capacity_ratio", "1"),
        ("support.sand.poisson_ratio", "0.6"),
    ] {
        let error = over(&format!("{key} = {value}")).expect_err(key);
        assert!(matches!(error.problem, Problem::OutsideLimits { .. }), "{error}");
        assert!(error.to_string().contains(key), "{error}");
        assert_eq!(error.place().unwrap().line(), 2);
    }
}

#[test]
fn values_that_do_not_go_together_are_refused() {
    for (text, named) in CONFLICTS {
        let error = over(text).expect_err(text);
        assert!(matches!(error.problem, Problem::Conflict { .. }), "{text}: {error}");
        assert!(
            error.to_string().contains(named),
            "{text}: {error} does not name {named}"
        );
        assert_eq!(error.place().unwrap().line(), 2, "{text}: {}", render(&error));
        assert!(!error.remedy().is_empty());
    }
    // Keys that the support does not use are not checked.
    changed("support.sand.box_width = \"150 mm\"");
    changed("support = { kind = \"sandbox\", worktable.length = \"400 mm\" }");
}

#[test]
fn the_growth_rings_turn_with_the_block() {
    let design = load(BASE);
    let (grain, radial) = (&design.wood.elastic, design.wood.block_axes());
    assert_eq!(design.wood.driven, Rings::Radial);
    assert_eq!((radial.e1, radial.e2, radial.e3), (grain.e_l, grain.e_t, grain.e_r));
    assert_eq!(
        (radial.g12, radial.g13, radial.g23),
        (grain.g_lt, grain.g_lr, grain.g_rt)
    );
    // The compliance is symmetric: nu_23/E_2 = nu_32/E_3.
    assert!((radial.nu23 / radial.e2 - grain.nu_rt / grain.e_r).abs() < 1e-25);
    let tangential = changed("wood.driven = \"tangential\"").wood.block_axes();
    assert_eq!(
        (tangential.e2, tangential.e3, tangential.nu23),
        (grain.e_r, grain.e_t, grain.nu_rt)
    );
}

/// Every file in `tests/data/bad`: the line of the error, the key or file it names, and a part of the remedy.
#[rustfmt::skip]
const BAD: &[(&str, usize, &str, &str)] = &[
    ("ambiguous-unit", 3, "chambers.wall_heat_transfer", "W/(m2 K)"),
    ("arm-short", 3, "body.arm_reach", "raise `body.arm_reach`"),
    ("backward-range", 3, "piston.mass", "lower end"),
    ("base-not-text", 1, "base", "in quotes"),
    ("below-vacuum", 3, "supply.pressure", "from 1000 to 1e7 Pa"),
    ("board-on-mesh", 5, "workpiece.board.thickness", "remove `workpiece.mesh`"),
    ("decimal-comma", 3, "piston.rod_diameter", "no comma"),
    ("deep-groove", 2, "below its groove", "lower `workpiece.groove`"),
    ("derived-area", 3, "exhaust.area", "change `exhaust.holes`, `exhaust.hole_diameter`"),
    ("derived-mass", 4, "workpiece.mass", "`wood.density`"),
    ("elastic", 4, "wood.elastic", "Poisson"),
    ("elastic-two-way", 7, "model.blow", "`model.blow = \"rigid\"`"),
    ("gaps", 3, "nail.head_gap", "`nail.feed_height`"),
    ("gauge-ambient", 3, "ambient.pressure", "absolute"),
    ("group-as-value", 3, "supply", "[supply]"),
    ("half-a-hole", 3, "exhaust.holes", "whole number"),
    ("handle-above-cap", 3, "body.handle_level", "lower `body.handle_level`"),
    ("handle-below-barrel", 3, "body.handle_level", "raise `body.handle_level`"),
    ("handle-wide", 3, "body.handle_radius", "lower `body.handle_radius`"),
    ("infinite", 3, "piston.stroke", "finite"),
    ("key-of-another-group", 3, "tool.stroke", "`piston.stroke`"),
    ("laps", 3, "head_valve.exhaust_lap", "`head_valve.intake_lap`"),
    ("load-surface", 3, "cycle.load.tool.handel", "did you mean \"handle\"?"),
    ("long-nail", 5, "nail", "`workpiece.thickness`"),
    ("loop-a", 2, "loop-b.toml", "remove `base`"),
    ("loop-b", 1, "loop-a.toml", "remove `base`"),
    ("magazine-below-nose", 3, "body.magazine_level", "raise `body.magazine_level`"),
    ("malformed", 3, "TOML", "[supply]"),
    ("missing-base", 1, "n80bc.toml", "did you mean `designs/n80cb.toml`"),
    ("muffler-passage", 6, "exhaust.muffler.flow_area", "`exhaust.muffler.tail_diameter`"),
    ("muffler-too-wide", 4, "exhaust.muffler.chamber_diameter", "`analysis.exhaust_max_frequency`"),
    ("nan", 4, "tool.mass", "finite"),
    ("negative-mass", 4, "piston.mass", "from 1e-5 to 1000 kg"),
    ("no-base", 1, "supply.pressure", "base = \"n80cb.toml\""),
    ("no-holes", 3, "exhaust.holes", "from 1 to 10000"),
    ("no-such-mesh", 4, "body.mesh", "relative to the folder"),
    ("no-unit", 3, "piston.bore", "mm"),
    ("not-seated", 4, "guard", "`hand.force`"),
    ("overlapping-holes", 3, "exhaust.hole_diameter", "`exhaust.pitch`"),
    ("own-base", 1, "own-base.toml", "remove `base`"),
    ("quoted-switch", 3, "support.sand.bonded", "without quotes"),
    ("rod", 3, "piston.rod_diameter", "`piston.bore`"),
    ("sensor-band", 3, "block_top", "below"),
    ("sensor-name", 3, "block top", "letters"),
    ("sensor-without-body", 4, "sensors.mine.body", "sensors.mine.body ="),
    ("spring", 3, "spring", "`head_valve.lift`"),
    ("springs-none", 3, "nothing carries the workpiece", "springs.NAME"),
    ("supply-below-ambient", 3, "supply.pressure", "psig"),
    ("twice", 4, "duplicate key", "key = value"),
    ("undeclared-key", 6, "mine.bix", "did you mean `mine.box`?"),
    ("unknown-choice", 3, "support.kind", "sandbox"),
    ("unknown-field", 3, "piston.mass.rnage", "piston.mass.range"),
    ("unknown-group", 3, "headvalve", "`head_valve`"),
    ("unknown-key", 4, "supply.presure", "`supply.pressure`"),
    ("unknown-provenance", 3, "piston.mass", "published"),
    ("unknown-unit", 3, "piston.bore", "mm"),
    ("unquoted", 3, "TOML", "quotes"),
    ("wrong-unit", 4, "piston.mass", "kg, g, lb"),
    ("wrong-unit-in-range", 4, "piston.mass", "kg, g, lb"),
];

#[test]
fn bad_designs_are_refused_with_file_line_key_and_remedy() {
    let folder = Path::new("tests/data/bad");
    let mut files: Vec<_> = fs::read_dir(folder)
        .unwrap()
        .map(|entry| entry.unwrap().path())
        .collect();
    files.sort_by_key(|file| file.file_stem().map(|stem| stem.to_owned()));
    let stems: Vec<_> = files
        .iter()
        .map(|file| file.file_stem().unwrap().to_str().unwrap())
        .collect();
    assert_eq!(
        stems,
        BAD.iter().map(|(stem, ..)| *stem).collect::<Vec<_>>(),
        "a file without its line in the table"
    );

    let mut gallery = String::new();
    for (stem, line, key, remedy) in BAD {
        let path = folder.join(format!("{stem}.toml"));
        let error = Design::load(&path).expect_err(stem);
        let place = error.place().unwrap_or_else(|| panic!("{stem} has no place"));
        assert_eq!(place.line(), *line, "{stem}");
        assert!(error.to_string().contains(key), "{stem}: {error} does not name {key}");
        assert!(
            error.remedy().contains(remedy),
            "{stem}: {} does not say {remedy}",
            error.remedy()
        );
        let text = render(&error);
        // A loop is closed by the other file of the two.
        let named = if stem.starts_with("loop") { "loop-" } else { stem };
        assert!(
            text.contains(named) && text.contains(&format!(".toml:{line}:")),
            "{stem}:\n{text}"
        );
        assert!(text.lines().count() <= 24, "{stem} fills more than a screen:\n{text}");
        gallery.push_str(&format!("{stem}\n{text}\n"));
    }
    insta::assert_snapshot!(without_base_lines(&gallery));
}

#[test]
fn a_missing_file_names_the_path_and_what_to_do() {
    let near = Design::load("designs/n80bc.toml").unwrap_err();
    assert_eq!(near.to_string(), "there is no design file `designs/n80bc.toml`");
    assert_eq!(near.remedy(), "did you mean `designs/n80cb.toml`?");
    let far = Design::load("no/such/folder/tool.toml").unwrap_err();
    insta::assert_snapshot!(render(&far));
    let folder = Design::load("designs").unwrap_err();
    assert!(matches!(folder.problem, Problem::Unreadable { .. }));
}

#[test]
fn bytes_that_are_no_text_are_refused_with_their_line() {
    let path = std::env::temp_dir().join(format!("nailnoise-not-text-{}.toml", std::process::id()));
    fs::write(&path, b"# one\n# two \xff\n").unwrap();
    let error = Design::load(&path).unwrap_err();
    fs::remove_file(&path).unwrap();
    assert!(matches!(error.problem, Problem::NotText { line: 2, .. }), "{error}");
}

#[test]
fn the_reference_in_docs_is_generated() {
    let (path, generated) = (Path::new("docs/design-file.md"), reference());
    if std::env::var_os("NAILNOISE_UPDATE_DOCS").is_some() {
        fs::write(path, &generated).unwrap();
    }
    let committed = fs::read_to_string(path).unwrap_or_default();
    assert!(
        committed == generated,
        "docs/design-file.md is old: run this test with NAILNOISE_UPDATE_DOCS=1"
    );
}

#[test]
fn the_examples_of_the_reference_load() {
    let text = reference();
    for (number, example) in text.split("```toml\n").skip(1).enumerate() {
        let example = example.split("```").next().unwrap();
        let design = Design::parse(example, format!("designs/example-{number}.toml"));
        design.unwrap_or_else(|error| panic!("{}", render(&error)));
    }
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 256, failure_persistence: None, ..ProptestConfig::default() })]

    /// Whatever a slip of the hand does to the file, the result is a design or an error that can be shown.
    #[test]
    fn edited_text_never_panics(
        edits in prop::collection::vec((any::<prop::sample::Index>(), 0usize..40, "[ -~\n\u{e9}\u{b5}]{0,8}"), 1..4)
    ) {
        let mut text: Vec<char> = fs::read_to_string(BASE).unwrap().chars().collect();
        for (at, removed, inserted) in edits {
            let start = at.index(text.len());
            let end = (start + removed).min(text.len());
            text.splice(start..end, inserted.chars());
            if text.is_empty() {
                text.push('\n');
            }
        }
        let text: String = text.into_iter().collect();
        match Design::parse(&text, BASE) {
            Ok(design) => prop_assert!(design.warnings().iter().all(|warning| !render(warning).is_empty())),
            Err(error) => prop_assert!(!render(&error).is_empty() && !error.remedy().is_empty()),
        }
    }

    /// Any text as a value is a number of the right dimension or an error.
    #[test]
    fn any_value_never_panics(
        value in "(\\PC{0,12}|[-+]?[0-9.eE_,]{0,8} ?[a-zA-Z0-9/*^() \u{b0}\u{b5}\u{b2}-]{0,10})"
    ) {
        let value = value.replace(['\\', '"'], "");
        for key in ["supply.pressure", "wood.slenderness_term", "ambient.temperature"] {
            for text in [format!("{key} = \"{value}\""), format!("{key}.range = \"{value} .. {value}\"")] {
                match over(&text) {
                    Ok(design) => prop_assert!(design.supply.pressure.is_finite() && design.supply.pressure > 0.0),
                    Err(error) => prop_assert!(!render(&error).is_empty()),
                }
            }
        }
    }
}
