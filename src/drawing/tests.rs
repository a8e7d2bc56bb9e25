//! The drawing against the parameters, and its legibility for designs within the ranges.

use std::f64::consts::PI;

use nailnoise_acoustics::random::uniform;

use super::layout::{HOLES, Layout};
use super::{Annotation, Drawing, Mark, Outline, Rectangle, Side, Standing, View, corners, housing_parts};
use crate::design::inputs::bodies as inputs;
use crate::design::{Design, Provenance, Value};
use crate::stages::bodies::BodyKind;

/// A light finish nailer.
const LIGHT: &str = "
piston = { bore = \"38 mm\", stroke = \"95 mm\" }
tool.mass = \"1.2 kg\"
exhaust = { holes = 12, hole_diameter = \"3 mm\", pitch = \"8 mm\" }
nail = { length = \"64 mm\", feed_height = \"66 mm\", diameter = \"1.6 mm\", head_diameter = \"2.4 mm\" }
chambers.check_hole_position = \"60 mm\"
body.handle_radius = \"16 mm\"
[head_valve]
outer_diameter = \"44 mm\"
seat_diameter = \"41 mm\"
inner_diameter = \"31 mm\"
exhaust_seat_diameter = \"31 mm\"
";

fn over(base: &str, text: &str) -> Design {
    let text = format!("base = \"{base}\"\n{text}");
    Design::parse(&text, "designs/over.toml").unwrap_or_else(|error| panic!("{error}"))
}

/// The designs that come with the program and others, on all supports, with every fitting on the exhaust.
fn designs() -> Vec<Design> {
    let muffler = "exhaust.muffler = { kind = \"chamber\", flow_area = \"100 mm2\", lining_thickness = \"8 mm\" }
        analysis = { exhaust_max_frequency = \"6 kHz\", range_high = \"6 kHz\" }";
    let mut designs: Vec<Design> = ["floor", "clamped"]
        .map(|kind| over("n80cb.toml", &format!("support.kind = \"{kind}\"\n{LIGHT}")))
        .into();
    designs.extend([
        over("n80cb.toml", ""),
        over(
            "n80cb.toml",
            "support.worktable.preset = \"C\"\nnail.offset_along = \"40 mm\"",
        ),
        over("n80cb.toml", muffler),
        over("n80cb.toml", "exhaust.holes = 1"),
        over("n80cb.toml", "exhaust.holes = 900\nexhaust.hole_diameter = \"0.4 mm\""),
        over("n80cb.toml", "piston.stroke = \"170 mm\""),
        over("n80cb-sandbox.toml", LIGHT),
        over("n80cb-as-tested.toml", ""),
        over("n80cb-free.toml", ""),
        over("n80cb-board.toml", LIGHT),
    ]);
    designs
}

/// Designs and draws from their ranges that are free of conflicts.
fn each_drawn(mut visit: impl FnMut(&Design)) {
    let mut count = 0;
    for (number, design) in designs().iter().enumerate() {
        visit(design);
        let entries: Vec<(String, [f64; 2])> = design
            .entries()
            .into_iter()
            .filter(|entry| matches!(entry.value, Value::Number(_)))
            .filter_map(|entry| Some((entry.key, entry.range?)))
            .collect();
        for draw in 0..25 {
            // One key in four is anywhere in its range; most such designs are free of conflicts.
            let value = |(key, (name, [low, high])): (u64, &(String, [f64; 2]))| {
                let place = uniform(number as u64, draw, key);
                (uniform(77 + number as u64, draw, key) < 0.25)
                    .then(|| (name.clone(), Value::Number(low + (high - low) * place)))
            };
            let changes: Vec<(String, Value)> = (0u64..).zip(&entries).filter_map(value).collect();
            let changes: Vec<(&str, Value)> = changes
                .iter()
                .map(|(key, value)| (key.as_str(), value.clone()))
                .collect();
            let mut drawn = design.clone();
            if drawn.set(&changes).is_ok() && drawn.conflict().is_none() {
                visit(&drawn);
                count += 1;
            }
        }
    }
    assert!(count > 60, "{count} designs without a conflict");
}

#[test]
fn no_two_labels_overlap_and_none_is_on_the_view_or_off_the_sheet() {
    each_drawn(|design| {
        let drawing = Drawing::new(design);
        for sheet in drawing.sheets() {
            let name = sheet.view.name;
            let whole = Rectangle {
                x: [0.0, sheet.size[0]],
                y: [0.0, sheet.size[1]],
            };
            assert_eq!(
                sheet.labels.len(),
                sheet.view.annotations.len(),
                "{name}: a key is unknown"
            );
            for (index, placed) in sheet.labels.iter().enumerate() {
                let key = &placed.label.key;
                assert!(whole.contains(&placed.area), "{name}: {key} at {:?}", placed.area);
                assert!(!placed.area.overlaps(&sheet.picture), "{name}: {key} is on the view");
                for other in &sheet.labels[..index] {
                    let overlap = placed.area.overlaps(&other.area);
                    assert!(!overlap, "{name}: {key} overlaps {}", other.label.key);
                }
            }
        }
    });
}

#[test]
fn every_shape_is_within_its_view_and_every_view_within_its_sheet() {
    each_drawn(|design| {
        for sheet in Drawing::new(design).sheets() {
            let (view, bounds) = (sheet.view, sheet.view.bounds());
            for point in view.marked() {
                assert!(
                    bounds.contains(point),
                    "{}: a mark at {point:?} of {bounds:?}",
                    view.name
                );
            }
            let shapes = view.parts.iter().flat_map(|part| &part.outlines).flat_map(corners);
            for point in shapes.filter(|_| view.window.is_none()) {
                assert!(bounds.contains(point), "{}: a part at {point:?}", view.name);
                let [x, y] = sheet.at(point);
                assert!(x.is_finite() && y.is_finite() && x > 0.0 && y > 0.0, "{}", view.name);
                assert!(x < sheet.size[0] && y < sheet.size[1], "{}: [{x}, {y}]", view.name);
            }
        }
    });
}

#[test]
fn leader_lines_of_a_column_do_not_cross() {
    let side = |a: [f64; 2], b: [f64; 2], c: [f64; 2]| (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]);
    let cross = |[a, b]: [[f64; 2]; 2], [c, d]: [[f64; 2]; 2]| {
        side(a, b, c) * side(a, b, d) < -1e-3 && side(c, d, a) * side(c, d, b) < -1e-3
    };
    for design in designs() {
        for sheet in Drawing::new(&design).sheets() {
            for column in [Side::Left, Side::Right] {
                let labels = sheet.labels.iter().filter(|placed| placed.annotation.side == column);
                let lines: Vec<_> = labels
                    .map(|placed| ([placed.knee, sheet.at(placed.annotation.anchor)], &placed.label.key))
                    .collect();
                for (index, (line, key)) in lines.iter().enumerate() {
                    for (other, of) in &lines[..index] {
                        assert!(!cross(*line, *other), "{}: {key} crosses {of}", sheet.view.name);
                    }
                }
            }
        }
    }
}

/// Length of the dimension line of an annotation, doubled if the line starts on the axis outside a detail.
fn dimension(annotation: &Annotation) -> Option<f64> {
    annotation.marks.iter().find_map(|mark| match mark {
        Mark::Span([a, b]) => Some((a[0] - b[0]).hypot(a[1] - b[1])),
        Mark::HalfSpan([_, end]) => Some(2.0 * end[0]),
        _ => None,
    })
}

#[test]
fn every_dimension_line_is_as_long_as_its_key() {
    each_drawn(|design| {
        let entries = design.entries();
        let mut lines = 0;
        for (view, annotation) in Drawing::new(design)
            .views
            .iter()
            .flat_map(|view| view.annotations.iter().map(move |annotation| (view, annotation)))
        {
            let Some(length) = dimension(annotation) else { continue };
            let entry = entries.iter().find(|entry| entry.key == annotation.key);
            let Some(Value::Number(value)) = entry.map(|entry| &entry.value) else {
                panic!("{} is not a length", annotation.key);
            };
            let (key, name) = (annotation.key, view.name);
            assert!(
                (length - value.abs()).abs() < 1e-9,
                "{name}: {key} is {length} m for {value} m"
            );
            lines += 1;
        }
        assert!(lines > 40, "{lines} dimension lines");
    });
}

fn part<'a>(view: &'a View, name: &str) -> &'a super::Part {
    let found = view.parts.iter().find(|part| part.name == name);
    found.unwrap_or_else(|| panic!("no {name}"))
}

#[test]
fn volumes_and_areas_as_drawn_are_those_of_the_cycle() {
    let design = over("n80cb.toml", "");
    let (layout, drawing) = (Layout::new(&design), Drawing::new(&design));
    let [section, holes] = ["section", "holes"].map(|name| {
        let found = drawing.views.iter().find(|view| view.name == name);
        found.unwrap_or_else(|| panic!("no view {name}"))
    });
    let close = |name: &str, drawn: f64, given: f64| {
        assert!(
            (drawn / given - 1.0).abs() < 1e-9,
            "{name}: {drawn} drawn, {given} given"
        );
    };
    let length = |key: &str| {
        let found = section.annotations.iter().find(|annotation| annotation.key == key);
        found.and_then(dimension).unwrap_or_default()
    };
    // Compares Pappus' theorem, applied to the outlines, with the geometry of the cycle.
    let swept = 0.25 * PI * length("piston.bore").powi(2) * length("piston.stroke");
    close("swept volume", swept, design.piston.area() * design.piston.stroke);
    let above = part(section, "volume above the piston").volume_of_revolution();
    close("V_01", above, design.chambers.above_piston);
    let piston = part(section, "piston").volume_of_revolution();
    close(
        "piston",
        piston,
        design.piston.area() * (layout.piston[0] - layout.piston[1]),
    );
    let around = layout.bore.powi(2) - layout.bumper_radius.powi(2);
    close(
        "V_02",
        PI * around * (layout.bumper - layout.floor),
        design.chambers.below_piston,
    );
    let circle = |outline: &Outline| match outline {
        Outline::Circle { radius, .. } => PI * radius * radius,
        Outline::Polygon(_) => 0.0,
    };
    let area: f64 = part(holes, "exhaust holes").outlines.iter().map(circle).sum();
    close("A_ma", area, design.exhaust.area());
    let holes = |diameter: f64| HOLES * 0.25 * PI * diameter * diameter;
    close("A_1r", holes(layout.check_hole[0]), design.chambers.check_hole_area);
    close("A_2r", holes(layout.return_hole[0]), design.chambers.return_hole_area);
    close("A_sup", PI * layout.hose * layout.hose, design.supply.hose_area);
    close("L_ch", layout.channel_length(), design.trigger.channel_length);
    // Travel to the nail: from the tip of the rod to the head of the nail before the shot.
    close(
        "y_pbin",
        layout.rod_tip - design.nail.feed_height,
        design.nail.head_gap(&design.piston),
    );
    let ring = layout.valve.outer.powi(2) - layout.valve.inner.powi(2);
    close("A_h1", PI * ring, design.head_valve.control_area());
}

/// gmsh made the mesh from its own script.
#[test]
fn the_housing_as_drawn_has_the_volumes_of_its_mesh() {
    let design = over("n80cb.toml", "");
    let geometry = inputs::geometry(&design, BodyKind::Tool, false).unwrap_or_else(|error| panic!("{error}"));
    let meshed = geometry.mesh().unwrap_or_else(|error| panic!("{error}"));
    let mesh = &meshed.imported.mesh;
    let volumes = mesh.part_volumes().unwrap_or_else(|error| panic!("{error}"));
    let of = |name: &str| {
        let place = mesh.part_names.iter().position(|own| own == name);
        place.map_or(f64::NAN, |place| volumes[place])
    };
    let drawn = housing_parts(&design);
    let find = |name: &str| drawn.iter().find(|part| part.name == name).map(|part| &part.outlines);
    let sleeve = drawn.iter().find(|part| part.name == "cylinder sleeve");
    // Two halves of the section make one solid; each outline alone is half of it on its side of the axis.
    let [left, right] = [0, 1].map(|side| {
        let outlines = sleeve.map(|part| vec![part.outlines[side].clone()]).unwrap_or_default();
        super::Part {
            name: "sleeve",
            material: super::Material::Mechanism,
            outlines,
        }
        .volume_of_revolution()
    });
    assert!(left == 0.0, "{left}");
    assert!(
        (right / of("sleeve") - 1.0).abs() < 5e-3,
        "{right} m3 drawn, {} in the mesh",
        of("sleeve")
    );
    // The nose is a box tube, so the area of both walls of the section follows from its perimeter.
    let b = &design.body;
    let walls: f64 = find("nose").map_or(0.0, |outlines| {
        let width = |outline: &Outline| {
            let xs: Vec<f64> = corners(outline).iter().map(|point| point[0]).collect();
            xs.iter().copied().fold(f64::MIN, f64::max) - xs.iter().copied().fold(f64::MAX, f64::min)
        };
        outlines.iter().map(width).sum()
    });
    let inner = (b.nose_width - walls) * (b.nose_depth - walls);
    let nose = (b.nose_width * b.nose_depth - inner) * (b.nose_height + b.nose_overlap);
    assert!(
        (nose / of("nose") - 1.0).abs() < 5e-3,
        "{nose} m3 drawn, {} in the mesh",
        of("nose")
    );
}

#[test]
fn a_key_is_a_group_with_its_value_as_title_and_can_be_focused() {
    let design = over("n80cb.toml", LIGHT);
    let drawing = Drawing::new(&design);
    let svg = drawing.svg();
    assert!(
        !svg.contains("NaN") && !svg.contains("inf"),
        "a coordinate is not finite"
    );
    let keys: Vec<&str> = svg.split("data-key=\"").skip(1).collect();
    let annotations: usize = drawing.views.iter().map(|view| view.annotations.len()).sum();
    assert_eq!(keys.len(), annotations);
    for key in keys {
        let name = key.split('"').next().unwrap_or_default();
        let title = key
            .split("<title>")
            .nth(1)
            .and_then(|rest| rest.split("</title>").next());
        let expected = format!("{name} = {}", drawing.labels[name].value);
        assert!(
            title.is_some_and(|title| title.starts_with(&expected)),
            "{title:?} for {expected}"
        );
        assert!(
            key.starts_with(&format!("{name}\" tabindex=\"0\"")),
            "{name} cannot be focused"
        );
    }
    let mut names: Vec<&str> = svg
        .split(" id=\"")
        .skip(1)
        .filter_map(|rest| rest.split('"').next())
        .collect();
    names.sort_unstable();
    let count = names.len();
    names.dedup();
    assert_eq!(names.len(), count, "an identifier is there twice");
}

#[test]
fn values_of_the_base_are_told_from_those_of_the_design() {
    let drawing = Drawing::new(&over("n80cb.toml", LIGHT));
    assert!(!drawing.labels["piston.bore"].inherited);
    assert_eq!(drawing.labels["piston.bore"].standing, Standing::Given);
    assert!(drawing.labels["piston.rod_diameter"].inherited);
    assert_eq!(drawing.labels["piston.rod_diameter"].standing, Standing::Assumed);
    let base = Design::load(concat!(env!("CARGO_MANIFEST_DIR"), "/designs/n80cb.toml"));
    let base = Drawing::new(&base.unwrap_or_else(|error| panic!("{error}")));
    assert!(base.labels.values().all(|label| !label.inherited));
    assert_eq!(base.labels["piston.stroke"].standing, Standing::Published);
}

#[test]
fn every_provenance_has_a_symbol_of_its_own_class() {
    for provenance in Provenance::ALL {
        let text = format!("piston.mass = {{ value = \"131 g\", provenance = \"{provenance}: somewhere\" }}");
        let label = Drawing::new(&over("n80cb.toml", &text)).labels["piston.mass"].clone();
        let expected = match provenance {
            Provenance::Published => Standing::Published,
            Provenance::Computed => Standing::Computed,
            Provenance::Estimated => Standing::Assumed,
            Provenance::Scaled => Standing::Scaled,
            Provenance::Design => Standing::Given,
            _ => Standing::Decided,
        };
        assert_eq!(label.standing, expected, "{provenance}");
    }
    for (index, one) in Standing::ALL.iter().enumerate() {
        for other in &Standing::ALL[..index] {
            assert_ne!((one.symbol(), one.class()), (other.symbol(), other.class()));
        }
    }
}

#[test]
fn a_stroke_longer_than_the_sleeve_is_a_misfit() {
    let keys = |text: &str| -> Vec<&str> {
        let drawing = Drawing::new(&over("n80cb.toml", text));
        drawing.misfits.iter().flat_map(|misfit| misfit.keys.clone()).collect()
    };
    assert!(!keys("").contains(&"piston.stroke"));
    assert!(keys("piston.stroke = \"170 mm\"").contains(&"piston.stroke"));
    assert!(keys("piston.rod_diameter = \"8.5 mm\"").contains(&"piston.rod_diameter"));
}

#[test]
fn the_pictures_in_docs_are_those_of_the_shipped_design() {
    let design = Design::load("designs/n80cb.toml").unwrap_or_else(|error| panic!("{error}"));
    let drawing = Drawing::new(&design);
    for (path, drawn) in [
        ("docs/pictures/drawing.svg", drawing.svg()),
        ("docs/pictures/section.svg", drawing.svg_of(&["section"])),
    ] {
        if std::env::var_os("NAILNOISE_UPDATE_DOCS").is_some() {
            std::fs::write(path, &drawn).unwrap_or_else(|error| panic!("{error}"));
        }
        let committed = std::fs::read_to_string(path).unwrap_or_default();
        assert!(
            committed == drawn,
            "{path} is old: run this test with NAILNOISE_UPDATE_DOCS=1"
        );
    }
}
