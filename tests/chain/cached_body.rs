//! Bodies read back from the store.

use std::fs;

use nailnoise::stages::bodies::{Body, BodyKind};
use nailnoise::store::{LIMIT, Store};

use crate::common::{SMALL, body, design, folder};

/// A body out of the cache moves like the one that was solved. Its shapes on all nodes are read on demand, computed
/// once more if they are lost, and refused if they are not those of its motion.
#[test]
fn a_cached_body_is_read_back_with_its_mode_shapes() {
    let cache = Store::at(folder("cached-body"), LIMIT);
    let design = design(SMALL);
    let workpiece = || body(&design, BodyKind::Workpiece, true, cache.clone());
    let solved = workpiece().body.get().unwrap();
    let kept = workpiece().body.get().unwrap();
    assert_eq!(
        (&kept.skin, &kept.basis, &kept.loads),
        (&solved.skin, &solved.basis, &solved.loads)
    );
    let first = workpiece().modes.get().unwrap();
    let shapes = &first.shapes;
    for (point, node) in solved.surface.volume_nodes.iter().enumerate() {
        let on_surface = solved.skin.rows(3 * point, 3).map(f64::from);
        let difference = (shapes.rows(3 * node, 3) - on_surface).amax();
        assert!(
            difference <= f64::from(f32::EPSILON) * shapes.amax(),
            "{point}: {difference:e}"
        );
    }
    assert_eq!(*solved.shapes(&first).unwrap(), *shapes);
    let entries = cache.entries().unwrap();
    let whole = entries.iter().find(|entry| entry.stage == "modes").unwrap();
    fs::remove_file(&whole.path).unwrap();
    let modes = workpiece().modes.get().unwrap();
    assert_eq!(modes.shapes, *shapes);
    assert!(whole.path.exists(), "kept again");
    let mut other = Body::clone(&kept);
    other.skin.neg_mut();
    let error = other.shapes(&modes).unwrap_err().to_string();
    assert!(error.contains("the modes of the workpiece are not those"), "{error}");
}
