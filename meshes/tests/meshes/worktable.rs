//! Solid worktables.
#![allow(clippy::unwrap_used)] // a test may panic, in its helpers too

use crate::common::{assert_sound, close};
use nailnoise_meshes::{MeshError, Worktable, worktable};

fn table() -> Worktable {
    Worktable {
        top: [0.450, 0.400],
        thickness: 0.038,
        leg: [0.089, 0.089],
        height: 0.670,
        element_size: 0.045,
        leg_element_size: 0.080,
        top_layers: 1,
        origin: [0.0; 3],
    }
}

const LEG: f64 = 0.089 * 0.089;
const TOP: f64 = 0.450 * 0.400;

#[test]
fn plate_and_legs_are_one_closed_body_with_their_volume() {
    let mesh = worktable(&table()).unwrap();
    let surface = assert_sound(&mesh);
    close(surface.volume(), TOP * 0.038 + 4.0 * LEG * 0.632, 1e-13);
    assert_eq!(mesh.part_names, ["top", "leg"]);
}

#[test]
fn each_patch_has_its_area() {
    let surface = assert_sound(&worktable(&table()).unwrap());
    let areas = [
        ("top", TOP),
        ("underside", TOP - 4.0 * LEG),
        ("sides", 2.0 * (0.450 + 0.400) * 0.038),
        ("leg_sides", 16.0 * 0.089 * 0.632),
        ("floor", 4.0 * LEG),
    ];
    for (name, area) in areas {
        close(surface.patch_area(surface.patch(name).unwrap()), area, 1e-13);
    }
    assert_eq!(surface.patches.len(), 5);
}

#[test]
fn the_legs_stand_on_the_floor() {
    let mesh = worktable(&table()).unwrap();
    let floor = mesh.group_nodes("floor").unwrap();
    assert!(floor.iter().all(|&n| mesh.nodes[n].z == 0.0));
}

#[test]
fn no_node_is_double_or_unused() {
    let mesh = worktable(&table()).unwrap();
    let mut keys: Vec<[i64; 3]> = mesh
        .nodes
        .iter()
        .map(|p| [p.x, p.y, p.z].map(|v| (v * 1e9).round() as i64))
        .collect();
    let count = keys.len();
    keys.sort_unstable();
    keys.dedup();
    assert_eq!(keys.len(), count);
    let mut used = vec![false; count];
    mesh.connectivity.iter().for_each(|&i| used[i] = true);
    assert!(used.into_iter().all(|u| u));
}

#[test]
fn dimensions_that_do_not_fit_are_refused() {
    let legs = Worktable {
        leg: [0.3, 0.089],
        ..table()
    };
    assert!(matches!(worktable(&legs), Err(MeshError::DoesNotFit { .. })));
    let thick = Worktable {
        thickness: 0.7,
        ..table()
    };
    assert!(matches!(worktable(&thick), Err(MeshError::DoesNotFit { .. })));
    let nan = Worktable {
        height: f64::NAN,
        ..table()
    };
    assert!(matches!(worktable(&nan), Err(MeshError::Dimension { .. })));
}
