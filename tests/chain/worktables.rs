//! The steel table, whose tubes are tied to its plate, against one mesh of both.

use std::path::Path;

use crate::common::body;
use nailnoise::design::Design;
use nailnoise::stages::bodies::BodyKind;
use nailnoise::store::Store;
use nailnoise_fem::{Constraints, Material, ModalSettings, assemble, modes};
use nailnoise_meshes::{Grid, Mesh, subdivide};

/// Plate and tubes on one grid, whose lines run along both sides of every wall.
fn in_one_piece(top: [f64; 3], tube: f64, wall: f64, height: f64, size: [f64; 2]) -> Mesh {
    let line = |length: f64| {
        let ends = [
            0.0,
            wall,
            tube - wall,
            tube,
            length - tube,
            length - tube + wall,
            length - wall,
            length,
        ];
        let mut line = vec![0.0];
        for (k, stretch) in ends.windows(2).enumerate() {
            // Within a tube as fine as the tube is.
            let size = if k == 3 { size[0] } else { size[1] };
            line.extend(subdivide(stretch[0], stretch[1], size).unwrap());
        }
        line
    };
    let mut z = vec![0.0];
    z.extend(subdivide(0.0, height - top[2], size[1]).unwrap());
    let layers = z.len() - 1;
    z.extend(subdivide(height - top[2], height, top[2] / 2.0).unwrap());
    let grid = Grid::new(line(top[0]), line(top[1]), z).unwrap();
    let part = |cell: [usize; 3]| {
        let centre = grid.centre(cell);
        let inward = |k: usize| centre[k].min(top[k] - centre[k]);
        let leg = (0..2).all(|k| inward(k) < tube);
        let hollow = (0..2).all(|k| inward(k) > wall && inward(k) < tube - wall);
        (cell[2] >= layers || (leg && !hollow)).then_some(0)
    };
    grid.mesh(&["steel"], part, |_, axis, upper, centre| {
        if axis == 2 && !upper && centre.z == 0.0 {
            "floor"
        } else {
            "rest"
        }
    })
}

#[test]
fn tubes_tied_to_a_plate_vibrate_as_if_welded() {
    let preset = "support.worktable.preset=B".parse().unwrap();
    let mut design = Design::load_with(Path::new("designs/n80cb.toml"), &[preset]).unwrap();
    design.analysis.worktable_max_frequency = 400.0;
    let size = [
        design.analysis.worktable_element,
        design.analysis.worktable_tube_element,
    ];
    let tied = body(&design, BodyKind::Worktable, false, Store::none())
        .body
        .get()
        .unwrap();
    let table = &design.support.worktable;
    let top = [table.length, table.width, table.top_thickness];
    let mesh = in_one_piece(top, table.leg_width, table.leg_wall, table.height, size);
    let s = &table.metal;
    let material = Material::isotropic(s.young_modulus, s.poisson_ratio, s.density).unwrap();
    let held = Constraints::clamped(&mesh, "floor").unwrap();
    let system = assemble(&mesh, &[material], &held).unwrap();
    let welded = modes(
        &system,
        &ModalSettings::below(design.analysis.mode_margin * 400.0),
        &|_, _| (),
    )
    .unwrap();
    assert!(tied.basis.hz.len() >= 7 && tied.basis.hz.len() == welded.hz.len());
    for (index, (a, b)) in tied.basis.hz.iter().zip(&welded.hz).enumerate() {
        // The motion that the plate's coarser field cannot follow at the walls makes the tied table a little stiffer.
        assert!(
            (0.995..1.015).contains(&(a / b)),
            "mode {}: {a:.2} Hz tied, {b:.2} Hz welded",
            index + 1
        );
    }
}
