//! Woods, nails and worktables by name: the settings of a name, the keys that win over it, and the keys that it
//! replaces.

use nailnoise::Design;
use nailnoise::design::{Assignment, DesignError, Entry, NailKind, Problem, Species, Value, nails, woods, worktables};

const BASE: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/designs/n80cb.toml");

fn over(text: &str) -> Result<Design, DesignError> {
    Design::parse(
        &format!("base = \"n80cb.toml\"\n{text}\n"),
        concat!(env!("CARGO_MANIFEST_DIR"), "/designs/over.toml"),
    )
}

fn set(assignments: &[&str]) -> Design {
    let assignments: Vec<Assignment> = assignments.iter().map(|text| text.parse().unwrap()).collect();
    Design::load_with(BASE, &assignments).unwrap()
}

fn entry(design: &Design, key: &str) -> Entry {
    design.entries().into_iter().find(|entry| entry.key == key).unwrap()
}

fn close(found: f64, expected: f64) {
    assert!((found / expected - 1.0).abs() < 1e-12, "{found} instead of {expected}");
}

#[test]
fn a_species_replaces_what_the_base_says_with_range_and_source() {
    let design = over("wood.species = \"Douglas-fir\"").unwrap();
    close(design.wood.hardness_modulus, 567.47e3);
    close(design.wood.density, 450.0);
    close(design.wood.elastic.e_l, 13.9e9);
    let density = entry(&design, "wood.density");
    assert_eq!(density.range, Some([400.0, 520.0]));
    assert!(density.source.contains("A I-1"), "{}", density.source);
    // The line that names the species gives the value.
    assert!(density.file.ends_with("over.toml") && density.line == 2);
    // Nothing remains of the base's note on the loss factor of its block.
    assert_eq!(entry(&design, "wood.loss_factor").note, "");
}

#[test]
fn a_key_beside_the_species_wins_whichever_stands_first() {
    for text in [
        "[wood]\nspecies = \"red oak\"\ndensity = \"700 kg/m3\"",
        "[wood]\ndensity = \"700 kg/m3\"\nspecies = \"red oak\"",
    ] {
        let design = over(text).unwrap();
        close(design.wood.density, 700.0);
        close(design.wood.hardness_modulus, 990e3);
        // That of the species, 620 to 740 kg/m3 for 680 kg/m3, in proportion.
        let [low, high] = entry(&design, "wood.density").range.unwrap();
        close(low, 620.0 / 680.0 * 700.0);
        close(high, 740.0 / 680.0 * 700.0);
    }
}

#[test]
fn a_key_of_the_command_line_wins_over_its_species_in_either_order() {
    for order in [
        ["wood.species=spruce", "wood.density=500"],
        ["wood.density=500", "wood.species=spruce"],
    ] {
        let design = set(&order);
        close(design.wood.density, 500.0);
        close(design.wood.hardness_modulus, 400e3);
    }
}

#[test]
fn the_names_of_the_base_design_change_none_of_its_values() {
    let base = Design::load(BASE).unwrap();
    assert_eq!(
        (base.wood.species, base.nail.kind),
        (Species::Pine, NailKind::Smooth12D)
    );
    let named = over("wood.species = \"pine\"\nnail.kind = \"12d smooth\"\nsupport.worktable.preset = \"A\"").unwrap();
    assert_eq!(base.digest(), named.digest());
}

#[test]
fn own_sets_nothing() {
    let base = Design::load(BASE).unwrap();
    let own = over("wood.species = \"own\"\nnail.kind = \"own\"").unwrap();
    let values = |design: &Design| -> Vec<(String, String)> {
        let words = design.in_words().into_iter();
        words
            .filter(|(key, _)| key != "wood.species" && key != "nail.kind")
            .collect()
    };
    assert_eq!(values(&base), values(&own));
}

#[test]
fn a_nail_sets_its_dimensions_and_its_mass_follows() {
    let design = over("nail.kind = \"10d annular\"").unwrap();
    close(design.nail.length, 76.2e-3);
    close(design.nail.diameter, 3.81e-3);
    let base = Design::load(BASE).unwrap();
    let shorter = 7850.0 * std::f64::consts::FRAC_PI_4 * 3.81e-3f64.powi(2) * 6.35e-3;
    close(base.nail.mass() - design.nail.mass(), shorter);
}

#[test]
fn a_staple_has_two_legs_and_a_law_whose_share_of_friction_spans_both_limits() {
    let design = over("wood.species = \"spruce\"\nnail.kind = \"16ga staple 50\"").unwrap();
    assert_eq!(design.nail.legs, 2);
    close(design.nail.diameter, 1.587e-3);
    assert_eq!(entry(&design, "wood.friction_share").range, Some([0.0, 1.0]));
    let legs = 2.0 * std::f64::consts::FRAC_PI_4 * 1.587e-3f64.powi(2) * (50e-3 - 1.59e-3);
    let crown = std::f64::consts::FRAC_PI_4 * 4.74e-3f64.powi(2) * 1.59e-3;
    close(design.nail.mass(), 7850.0 * (legs + crown));
}

#[test]
fn lumber_is_softer_than_the_dry_wood_of_the_tests_by_the_formula_for_moisture() {
    // Wood Handbook, Eq. 4-3: P = P_12 (P_12/P_green)^((12 - M)/(M_p - 12)), coast Douglas-fir 710 and 500 lbf, M_p =
    // 24 %.
    let at = |moisture: f64| (710.0f64 / 500.0).powf((12.0 - moisture) / 12.0);
    let hardness = |name: &str| {
        over(&format!("wood.species = \"{name}\""))
            .unwrap()
            .wood
            .hardness_modulus
    };
    let ratio = hardness("Douglas-fir lumber") / hardness("Douglas-fir");
    assert!((ratio / (at(15.0) / at(5.6)) - 1.0).abs() < 2e-3, "{ratio}");
}

#[test]
fn a_worktable_replaces_the_build_of_the_base_and_takes_what_is_given_with_it() {
    let base = Design::load(BASE).unwrap();
    let text = "[support.worktable]\npreset = \"C\"\nleg_wall = { value = \"3 mm\", range = \"2 .. 4 mm\" }";
    let design = over(text).unwrap();
    let table = &design.support.worktable;
    close(table.top_thickness, 12.7e-3);
    close(table.leg_width, 50e-3);
    close(table.leg_wall, 3e-3);
    close(table.length, base.support.worktable.length);
    assert_eq!(entry(&design, "support.worktable.leg_wall").range, Some([2e-3, 4e-3]));
    assert_eq!(
        entry(&design, "support.worktable.loss_factor").range,
        Some([0.005, 0.03])
    );
}

#[test]
fn wood_and_shank_choose_the_penetration_law() {
    for (text, law, share) in [
        ("wood.species = \"poplar plywood\"", "smooth", 0.81),
        (
            "wood.species = \"poplar plywood\"\nnail.kind = \"4d annular\"",
            "annular",
            0.55,
        ),
        (
            "wood.species = \"poplar plywood\"\nnail.kind = \"own\"",
            "general",
            0.81,
        ),
        ("nail.kind = \"10d annular\"", "solid_wood", 0.55),
    ] {
        let design = over(text).unwrap();
        assert_eq!(
            entry(&design, "wood.penetration_law").value,
            Value::Choice(law),
            "{text}"
        );
        close(design.wood.friction_share, share);
    }
}

#[test]
fn a_law_of_the_base_outlasts_another_nail_of_the_same_shank() {
    let folder = std::env::temp_dir().join(format!("nailnoise-names-{}", std::process::id()));
    std::fs::create_dir_all(&folder).unwrap();
    let middle = format!("base = {BASE:?}\nwood.penetration_law = \"constant\"\n");
    std::fs::write(folder.join("middle.toml"), middle).unwrap();
    let law = |nail: &str| {
        let path = folder.join("near.toml");
        let design = Design::parse(&format!("base = \"middle.toml\"\nnail.kind = \"{nail}\"\n"), path).unwrap();
        entry(&design, "wood.penetration_law").value
    };
    assert_eq!(law("10d smooth"), Value::Choice("constant"));
    assert_eq!(law("10d annular"), Value::Choice("solid_wood"));
    std::fs::remove_dir_all(folder).unwrap();
}

#[test]
fn an_unknown_name_is_refused_with_the_nearest_and_the_list() {
    for (text, near, list) in [
        ("wood.species = \"Duglas-fir\"", "Douglas-fir", "list woods"),
        ("wood.species = \"RED OAK\"", "red oak", "list woods"),
        ("nail.kind = \"10d anular\"", "10d annular", "list nails"),
    ] {
        let error = over(text).unwrap_err();
        assert!(
            matches!(&error.problem, Problem::UnknownName { nearest: Some(nearest), .. } if nearest == near)
                && error.place().is_some_and(|at| at.line() == 2),
            "{error:?}"
        );
        assert!(
            error.remedy().contains(near) && error.remedy().contains(list),
            "{}",
            error.remedy()
        );
    }
    let error = over("wood.species = \"bamboo\"").unwrap_err();
    assert!(matches!(&error.problem, Problem::UnknownName { nearest: None, .. }));
}

#[test]
fn every_name_of_the_lists_is_a_design_or_a_conflict_that_points_at_it() {
    let catalogues = [
        ("wood.species", woods()),
        ("nail.kind", nails()),
        ("support.worktable.preset", worktables()),
    ];
    for (key, named) in catalogues.map(|(key, named)| (key, named.unwrap())) {
        for own in named {
            match over(&format!("{key} = \"{}\"", own.name)) {
                Ok(design) => assert_eq!(entry(&design, key).value, Value::Choice(own.name)),
                Err(error) => assert_eq!(
                    error.place().map(|place| place.line()),
                    Some(2),
                    "{}: {error}",
                    own.name
                ),
            }
        }
    }
}

#[test]
fn alternatives_of_a_study_set_what_their_names_stand_for() {
    let design = over("[study.alternatives]\n\"wood.species\" = { pine = 1, \"red oak\" = 3 }").unwrap();
    let options = &design.study().alternatives["wood.species"];
    let density = |name: &str| {
        let option = options.iter().find(|option| option.name == name).unwrap();
        option
            .values
            .iter()
            .find(|(key, _)| key == "wood.density")
            .map(|(_, value)| value.clone())
    };
    assert_eq!(density("pine"), Some(Value::Number(429.46)));
    assert_eq!(density("red oak"), Some(Value::Number(680.0)));
}
