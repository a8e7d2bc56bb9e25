//! A workpiece of two pieces: a board on a block, contact between them, a nail through both.

use nailnoise::Design;
use nailnoise::stages::bodies::{Body, BodyKind, MovingSurface};
use nailnoise::stages::radiation::{CoveredFaces, OpenFaces};
use nailnoise_acoustics::Air;
use nailnoise_acoustics::radiation::ModalRadiation;
use nalgebra::{Complex, DMatrix, SymmetricEigen};
use std::f64::consts::TAU;
use std::sync::Arc;

use crate::common::{body, run, small, store};

/// Slender, so that both pieces bend as beams.
const BEAM: &str = "support.kind = \"floor\"\nworkpiece.length = 0.8\nworkpiece.width = 0.06\nnail.length = 0.032\n\
                    analysis.workpiece_element = 0.02\nsupport.contact.points_along = \
                    21\nsupport.contact.points_across = 3\n\
                    body.nose_width = 0.03\nbody.nose_depth = 0.03\nbody.nose_wall = 0.003\n";

/// Cells of that contact.
const CELLS: usize = 21 * 3;

fn of(design: &Design) -> Arc<Body> {
    body(design, BodyKind::Workpiece, true, store()).body.get().unwrap()
}

/// Two equal beams on each other, and a single one.
fn beams() -> [Arc<Body>; 2] {
    let both = small(&format!(
        "{BEAM}workpiece.thickness = 0.04\nworkpiece.board.thickness = 0.02"
    ));
    let one = small(&format!("{BEAM}workpiece.thickness = 0.04"));
    [both, one].map(|design| of(&design))
}

/// Frequencies of a body on springs of one stiffness at some of its supports, ascending \[Hz\].
fn sprung(body: &Body, supports: std::ops::Range<usize>, stiffness: f64) -> Vec<f64> {
    let mut matrix = DMatrix::from_diagonal(&body.omega.iter().map(|omega| omega * omega).collect::<Vec<_>>().into());
    for support in body.contacts.columns_range(supports).column_iter() {
        matrix += support * support.transpose() * stiffness;
    }
    let squares = SymmetricEigen::new(matrix).eigenvalues;
    let mut hz: Vec<f64> = squares.iter().map(|square| square.max(0.0).sqrt() / TAU).collect();
    hz.sort_by(f64::total_cmp);
    hz
}

#[test]
fn two_pieces_have_twelve_rigid_motions() {
    let [both, one] = beams();
    let rigid = |body: &Body| body.omega.iter().filter(|omega| **omega == 0.0).count();
    assert_eq!([rigid(&both), rigid(&one)], [12, 6]);
}

/// Without shear between them two equal beams on each other bend like a single one, at about half the frequency of the
/// solid beam; separately they bend twice, together once.
#[test]
fn beams_that_touch_bend_together_and_slip() {
    let [both, solid] = beams();
    let elastic = |hz: &[f64]| -> Vec<f64> { hz.iter().copied().filter(|hz| *hz > 1.0).collect() };
    let apart = elastic(&sprung(&both, 0..0, 0.0));
    let touching = elastic(&sprung(&both, CELLS..2 * CELLS, 1e9));
    let solid = elastic(&sprung(&solid, 0..0, 0.0));
    assert!((apart[1] / apart[0] - 1.0).abs() < 1e-6, "{apart:?}");
    assert!(
        (touching[0] / apart[0] - 1.0).abs() < 0.01,
        "{} of {}",
        touching[0],
        apart[0]
    );
    // The second bending of a free beam is 2.76 times the first.
    assert!(touching[1] > 1.8 * apart[0], "{touching:?}");
    assert!(
        solid[0] > 1.8 * touching[0] && solid[0] < 2.0 * touching[0],
        "{} and {}",
        solid[0],
        touching[0]
    );
}

/// A nail in the middle does not resist the slip of bending, which is largest at the ends.
#[test]
fn the_nail_resists_slip_where_it_stands() {
    let [both, _] = beams();
    let nail = 2 * CELLS..2 * CELLS + 3;
    let rises = |body: &Body, support: usize| body.contacts.column(support).dot(&body.lift);
    // Both pieces rising together load nothing of the joint.
    for support in CELLS..nail.end {
        assert!(rises(&both, support).abs() < 1e-6 * both.lift.norm(), "{support}");
    }
    // The nail restrains three rigid motions of one piece against the other: along it, and across it twice.
    let held = sprung(&both, nail, 1e6);
    let free = held.iter().filter(|hz| **hz < 1.0).count();
    assert_eq!(free, 9, "{held:?}");
}

#[test]
fn a_shot_through_a_board_passes_all_checks_and_moves_both_pieces() {
    let run = run(&small("workpiece.board.thickness = \"38 mm\""));
    for check in &run.result.checks {
        assert!(check.ok, "{}: {} exceeds {}", check.name, check.value, check.limit);
    }
    let workpiece = run
        .result
        .ranking
        .iter()
        .find(|source| source.source == "workpiece")
        .unwrap();
    assert!(workpiece.lwa_db.is_some_and(f64::is_finite));
}

#[test]
fn the_faces_of_a_joint_radiate_nothing() {
    let covered = CoveredFaces {
        workpiece: OpenFaces::AboveUnderside,
        half_sides: [0.1, 0.1],
    };
    // A rise at unit speed.
    let power = |text: &str| {
        let body = of(&small(text));
        let modes = DMatrix::from_fn(body.skin.nrows(), 1, |row, _| if row % 3 == 2 { 1.0 } else { 0.0 });
        let moving = MovingSurface {
            body: "workpiece",
            surface: &body.surface,
            modes: &modes,
        };
        let erp = covered.erp(&moving, &Air::default()).unwrap();
        erp.energy_forms(&[1000.0], &DMatrix::from_element(1, 1, Complex::from(1.0)))
            .sum()
    };
    let (two, one) = (power("workpiece.board.thickness = \"38 mm\""), power(""));
    assert!((two / one - 1.0).abs() < 1e-6, "{two} of {one}");
}
