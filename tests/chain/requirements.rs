//! Requirements of a run on its bodies, known before any of them is solved.

use crate::common::{design, folder};
use std::sync::{Arc, Mutex};

use nailnoise::chain::{Chain, Options, check_bodies};
use nailnoise::design::inputs::bodies::geometry;
use nailnoise::design::{NamedSurface, SupportKind, SurfaceName, SurfaceOf};
use nailnoise::graph::Graph;
use nailnoise::stages::Observer;
use nailnoise::stages::bodies::{BodyKind, Origin};
use nailnoise::store::Store;
use nailnoise::{Design, Error};
use nailnoise_meshes::msh::{self, Format};
use nailnoise_meshes::{Block, Mesh, Surface, block};
use nalgebra::{Point3, Vector3};

/// Takes a mesh \[m\] for a body of a design.
fn put(design: &mut Design, kind: BodyKind, mesh: &Mesh, name: &str) {
    let path = folder(&format!("requirements-{name}")).join("own.msh");
    std::fs::write(&path, msh::to_bytes(mesh, Format::Binary41, "of a test")).unwrap();
    let path = path.to_str().unwrap().to_owned();
    match kind {
        BodyKind::Tool => (design.body.mesh, design.body.mesh_unit) = (path, 1.0),
        BodyKind::Workpiece => (design.workpiece.mesh, design.workpiece.mesh_unit) = (path, 1.0),
        BodyKind::Worktable => panic!("no test replaces the table"),
    }
}

/// The shipped housing of the N80CB.
fn housing() -> Mesh {
    let n80cb = design("designs/n80cb.toml");
    geometry(&n80cb, BodyKind::Tool, false)
        .unwrap()
        .mesh()
        .unwrap()
        .imported
        .mesh
}

/// The N80CB in sand, whose run solves workpiece and tool, with a separate housing.
fn n80cb(mesh: &Mesh, name: &str) -> Design {
    let mut own = design("designs/n80cb-sandbox.toml");
    put(&mut own, BodyKind::Tool, mesh, name);
    own
}

/// Problems of a body in words.
fn problems(design: &Design, kind: BodyKind) -> Vec<String> {
    let checked = check_bodies(design, &[kind]).pop().unwrap();
    match checked {
        Ok(checked) => checked.problems.iter().map(Error::to_string).collect(),
        Err(error) => vec![error.to_string()],
    }
}

/// One problem, which contains these words.
#[track_caller]
fn refused(design: &Design, kind: BodyKind, words: &[&str]) {
    let problems = problems(design, kind);
    assert_eq!(problems.len(), 1, "{problems:#?}");
    assert!(words.iter().all(|word| problems[0].contains(word)), "{problems:#?}");
}

/// Names of the stages that are computed.
#[derive(Default)]
struct Stages(Mutex<Vec<String>>);

impl Observer for Stages {
    fn stage(&self, name: &str) {
        self.0.lock().unwrap().push(name.to_owned());
    }

    fn note(&self, _: &str) {}
}

#[test]
fn a_run_lists_all_missing_surfaces_before_it_solves_any_body() {
    let mut mesh = housing();
    mesh.groups
        .retain(|group| !["seat", "cap", "magazine"].contains(&&*group.name));
    let design = n80cb(&mesh, "missing");
    let stages = Arc::new(Stages::default());
    let graph = Graph::new(Arc::new(Store::none()), stages.clone());
    let error = Chain::new(&graph, &design, Options::default()).and_then(|chain| chain.run(&design).map(drop));
    let Err(Error::Unusable { problems, .. }) = error else {
        panic!("{error:?}")
    };
    // The seat carries a force and a mass, the cap two forces.
    let problems: Vec<String> = problems.iter().map(Error::to_string).collect();
    for name in [
        "\"seat\" for gas",
        "\"cap\" for gas",
        "on the surface \"magazine\"",
        "on the surface \"seat\"",
    ] {
        assert_eq!(
            problems.iter().filter(|problem| problem.contains(name)).count(),
            1,
            "{name}: {problems:#?}"
        );
    }
    let begun = stages.0.lock().unwrap();
    assert!(
        begun.iter().any(|name| name == "mesh") && !begun.iter().any(|name| name == "modes"),
        "{begun:?}"
    );
    // The check gives the same.
    assert_eq!(self::problems(&design, BodyKind::Tool), problems);
}

#[test]
fn the_surfaces_of_a_housing_without_names_are_those_that_its_names_say() {
    let (named, bare) = named_and_bare();
    let design = n80cb(&bare, "guess");
    let meshed = check_bodies(&design, &[BodyKind::Tool]).pop().unwrap().unwrap().meshed;
    for name in ["gas_bore", "bumper_seat", "seat", "cap", "nose_tip"] {
        let found = meshed.surfaces.iter().find(|found| found.name == name).unwrap();
        assert_eq!(found.origin, Origin::Guess);
        let patch = named.patch(name).unwrap();
        let (area, centre) = (named.patch_area(patch), named.patch_centre(patch).unwrap());
        assert!(
            (found.area / area - 1.0).abs() < 1e-3,
            "{name}: {} m2, not {area}",
            found.area
        );
        assert!(
            (Point3::from(found.centre) - centre).norm() < 1e-4,
            "{name}: {:?}, not {centre}",
            found.centre
        );
    }
    // The tube of the handle, without its end.
    let handle = meshed.surfaces.iter().find(|found| found.name == "handle").unwrap();
    let tube = std::f64::consts::TAU * 0.02 * 0.17;
    assert!(
        (handle.area / tube - 1.0).abs() < 0.05 && handle.centre[0] > 0.1,
        "{handle:?}"
    );
    assert!(!meshed.surfaces.iter().any(|found| found.name == "magazine"));
}

/// The skin of the housing with its names, and the housing without them.
fn named_and_bare() -> (Surface, Mesh) {
    let mut mesh = housing();
    let named = Surface::of(&mesh);
    mesh.groups.retain(|group| group.name.starts_with("fit_"));
    (named, mesh)
}

/// A place on the tool.
fn place(surface: SurfaceName, [x, y, z]: [f64; 3], along: [f64; 3], radius: f64) -> NamedSurface {
    NamedSurface {
        body: SurfaceOf::Tool,
        surface,
        x,
        y,
        z,
        radius,
        along_x: along[0],
        along_y: along[1],
        along_z: along[2],
    }
}

#[test]
fn a_point_of_the_design_names_the_whole_face_on_which_it_lies() {
    let (named, bare) = named_and_bare();
    let mut design = n80cb(&bare, "places");
    let (inside, end) = ([-1.0, 0.0, 0.0], [0.0, -1.0, 0.0]);
    design.surfaces.insert(
        "cylinder".to_owned(),
        place(SurfaceName::GasBore, [0.03, 0.0, 0.2], inside, 0.0),
    );
    design.surfaces.insert(
        "can".to_owned(),
        place(SurfaceName::Magazine, [0.09, -0.035, 0.075], end, 0.0),
    );
    let opposite = place(SurfaceName::Magazine, [0.09, 0.035, 0.075], [0.0, 1.0, 0.0], 0.0);
    design.surfaces.insert("other_end".to_owned(), opposite);
    let checked = check_bodies(&design, &[BodyKind::Tool]).pop().unwrap().unwrap();
    assert!(checked.problems.is_empty(), "{:#?}", checked.problems);
    for name in ["gas_bore", "magazine"] {
        let found = checked.meshed.surfaces.iter().find(|found| found.name == name).unwrap();
        assert_eq!(found.origin, Origin::Design);
        let area = named.patch_area(named.patch(name).unwrap());
        assert!(
            (found.area / area - 1.0).abs() < 1e-3,
            "{name}: {} m2, not {area}",
            found.area
        );
    }
}

#[test]
fn a_radius_cuts_a_face_to_what_is_near_its_point() {
    let mut bare = housing();
    bare.groups.retain(|group| group.name.starts_with("fit_"));
    let mut design = n80cb(&bare, "radius");
    let (near, out) = (0.04, [0.0, 0.0, 1.0]);
    design.surfaces.insert(
        "grip".to_owned(),
        place(SurfaceName::Handle, [0.15, 0.0, 0.29], out, near),
    );
    let meshed = check_bodies(&design, &[BodyKind::Tool]).pop().unwrap().unwrap().meshed;
    let grip = meshed.surfaces.iter().find(|found| found.name == "handle").unwrap();
    let ball = std::f64::consts::PI * near * near;
    assert!(
        grip.area > 0.3 * ball && grip.area < 1.5 * ball,
        "{} cm2",
        1e4 * grip.area
    );
    assert!((Vector3::from(grip.centre) - Vector3::new(0.15, 0.0, 0.29)).norm() < near);
}

#[test]
fn a_place_off_the_body_is_refused_with_its_distance() {
    let mut design = n80cb(&housing(), "off");
    let at = place(SurfaceName::Magazine, [0.0, 0.0, 0.5], [0.0; 3], 0.0);
    design.surfaces.insert("far".to_owned(), at);
    refused(&design, BodyKind::Tool, &["`far`", "outside the tool", "155 mm"]);
}

#[test]
fn a_piece_that_nothing_joins_is_refused_with_its_place() {
    let mut mesh = housing();
    let beside = block(&Block {
        size: [0.01; 3],
        divisions: [1; 3],
        origin: [0.3, 0.0, 0.0],
    });
    mesh.join(&Mesh {
        part_names: vec!["housing".to_owned()],
        groups: Vec::new(),
        ..beside.unwrap()
    });
    let design = n80cb(&mesh, "pieces");
    refused(
        &design,
        BodyKind::Tool,
        &["2 pieces", "1.00 cm3", "(305.0, 5.0, 5.0) mm"],
    );
}

#[test]
fn a_tool_of_another_mass_than_that_of_the_cycle_is_refused() {
    let mut design = design("designs/n80cb-sandbox.toml");
    design.body.lumped = false;
    refused(&design, BodyKind::Tool, &["weighs", "`tool.mass` = 4.100 kg"]);
}

#[test]
fn a_sensor_off_its_body_is_found_with_the_mesh() {
    let mut design = design("designs/n80cb-sandbox.toml");
    let sensor = design.sensors.get_mut("handle").unwrap();
    sensor.z += 0.1;
    refused(&design, BodyKind::Tool, &["handle", "outside the tool"]);
}

#[test]
fn a_file_in_a_wrong_unit_is_refused_with_the_unit_to_give() {
    let mut design = n80cb(&housing(), "unit");
    // As another program writes it, without a word on its unit.
    let text = String::from_utf8(msh::to_bytes(&housing(), Format::Text22, "")).unwrap();
    assert!(text.contains("lengths in m"));
    std::fs::write(&design.body.mesh, text.replace("lengths in m", "of another program")).unwrap();
    for unit in [1e3, 1e-3, 0.0254] {
        design.body.mesh_unit = unit;
        let error = check_bodies(&design, &[BodyKind::Tool])
            .pop()
            .unwrap()
            .map(|_| ())
            .unwrap_err();
        let help = miette::Diagnostic::help(&error).unwrap().to_string();
        assert!(error.to_string().contains("a hand-held tool that is"), "{error}");
        assert!(help.contains("body.mesh_unit = \"1 m\""), "{unit}: {help}");
    }
}

#[test]
fn a_file_that_states_a_wrong_unit_is_refused_without_another_unit() {
    let mut mesh = housing();
    mesh.nodes.iter_mut().for_each(|p| *p *= 1e3);
    let design = n80cb(&mesh, "stated-unit");
    let error = check_bodies(&design, &[BodyKind::Tool])
        .pop()
        .unwrap()
        .map(|_| ())
        .unwrap_err();
    let help = miette::Diagnostic::help(&error).unwrap().to_string();
    assert!(help.contains("states that its lengths are in m"), "{help}");
}

#[test]
fn a_block_of_another_length_cannot_radiate_from_a_table_and_both_bodies_say_so() {
    let mut design = design("tests/data/small-bem.toml");
    assert_eq!(design.support.kind, SupportKind::Worktable);
    let [length, width, thickness] = [
        design.workpiece.length,
        design.workpiece.width,
        design.workpiece.thickness,
    ];
    let longer = block(&Block {
        size: [1.3 * length, width, thickness],
        divisions: [4, 2, 2],
        origin: [-0.65 * length, -0.5 * width, 0.0],
    });
    put(&mut design, BodyKind::Workpiece, &longer.unwrap(), "longer");
    refused(&design, BodyKind::Workpiece, &["radiate as boxes"]);
    refused(&design, BodyKind::Worktable, &["radiate as boxes"]);
}

#[test]
fn the_shipped_designs_meet_their_requirements() {
    for name in ["n80cb", "n80cb-sandbox", "n80cb-free", "n80cb-feet"] {
        let design = design(&format!("designs/{name}.toml"));
        for kind in nailnoise::chain::solved_bodies(&design) {
            assert_eq!(problems(&design, kind), Vec::<String>::new(), "{name}");
        }
    }
}
