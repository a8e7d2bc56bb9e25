//! Values given on the command line.

use nailnoise::Design;
use nailnoise::design::{Assignment, AssignmentError, DesignError, Problem};

const PATH: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/designs/n80cb.toml");

fn load(assignments: &[&str]) -> Result<Design, DesignError> {
    let assignments: Vec<Assignment> = assignments.iter().map(|text| text.parse().unwrap()).collect();
    Design::load_with(PATH, &assignments)
}

fn wrong(text: &str) -> AssignmentError {
    text.parse::<Assignment>().unwrap_err()
}

#[test]
fn a_value_is_read_as_in_a_design_file_with_or_without_quotes() {
    let design = load(&[
        "piston.mass=120 g",
        "exhaust.holes = 3",
        "nail.length=\"75 mm\"",
        "support.kind=sandbox",
        "exhaust.hole_diameter=0.006",
    ])
    .unwrap();
    assert_eq!((design.piston.mass, design.exhaust.holes), (0.12, 3));
    assert_eq!((design.nail.length, design.exhaust.hole_diameter), (0.075, 0.006));
    let same = Design::parse(
        "base = \"n80cb.toml\"\npiston.mass = \"120 g\"\nexhaust.holes = 3\nnail.length = \"75 mm\"\n\
         support.kind = \"sandbox\"\nexhaust.hole_diameter = 0.006",
        concat!(env!("CARGO_MANIFEST_DIR"), "/designs/other.toml"),
    )
    .unwrap();
    assert_eq!(design.digest(), same.digest());
}

#[test]
fn the_last_value_for_a_key_counts_and_has_the_range_of_the_file_in_proportion() {
    let design = load(&["piston.mass=100 g", "piston.mass=120 g"]).unwrap();
    let of = |design: &Design| {
        let entry = design.entries().into_iter().find(|entry| entry.key == "piston.mass");
        entry.unwrap()
    };
    assert_eq!(design.piston.mass, 0.12);
    let (own, base) = (of(&design), of(&load(&[]).unwrap()));
    // 131 g with 129 to 133 g.
    let [low, high] = own.range.unwrap();
    assert!((low - 0.129 / 0.131 * 0.12).abs() < 1e-12 && (high - 0.133 / 0.131 * 0.12).abs() < 1e-12);
    assert_eq!(own.file, "command line");
    assert_ne!(base.file, "command line");
}

#[test]
fn an_inline_table_gives_range_and_provenance() {
    let design = load(&["piston.mass={ value = \"120 g\", range = \"110 .. 130 g\" }"]).unwrap();
    let entries = design.entries();
    let entry = entries.iter().find(|entry| entry.key == "piston.mass").unwrap();
    assert_eq!(entry.range, Some([0.11, 0.13]));
}

#[test]
fn a_wrong_value_is_the_error_of_a_design_file_and_names_the_command_line() {
    let message = |text: &str| load(&[text]).unwrap_err();
    let unknown = message("piston.mas=120 g");
    assert!(
        matches!(&unknown.problem, Problem::UnknownKey { nearest: Some(near), .. }
        if near == "piston.mass" && unknown.place().is_some_and(|at| at.file() == "command line"))
    );
    assert!(matches!(
        message("piston.mass=12 bar").problem,
        Problem::WrongUnit { .. }
    ));
    assert!(matches!(
        message("piston.mass=-1").problem,
        Problem::OutsideLimits { .. }
    ));
    assert!(matches!(
        message("exhaust.holes=few").problem,
        Problem::WrongKind { .. }
    ));
    assert!(matches!(message("piston=1").problem, Problem::WrongKind { .. }));
}

#[test]
fn what_is_no_assignment_is_refused() {
    for text in ["", "=", "piston.mass", "piston.mass=", "=3"] {
        assert_eq!(wrong(text), AssignmentError::Incomplete(text.to_owned()));
    }
    for key in ["piston mass", "piston..mass", "a\nb", "[piston]", "piston.mass #"] {
        assert_eq!(wrong(&format!("{key}=1")), AssignmentError::BadKey(key.to_owned()));
    }
    assert_eq!(wrong("base=other.toml"), AssignmentError::Base);
}

#[test]
fn no_value_can_give_another_key() {
    // A line break would end the value; as a text it is refused by its key.
    let error = load(&["piston.mass=0.1\npiston.stroke=0.2"]).unwrap_err();
    assert!(error.to_string().contains("piston.mass"), "{error}");
}
