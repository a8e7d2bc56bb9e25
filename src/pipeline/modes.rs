//! Modes as the cache keeps them: shapes, which are nearly all of it, are read straight into their matrix.

use std::io::Read;

use nailnoise_fem::ModalBasis;
use nalgebra::DMatrix;

use crate::cache::{Cache, Key};

/// Numbers of a shape taken at once.
const PART: usize = 1 << 13;

/// Modes, and the momentum of a rise at unit speed on every degree of freedom \[kg\].
pub(super) type Modes = (ModalBasis, Vec<f64>);

/// What is kept of them, if anything.
pub(super) fn kept(cache: &Cache, stage: &str, key: &Key) -> Option<Modes> {
    cache.decoded(stage, key, decode).flatten()
}

/// Keeps them.
///
/// ```text
/// 8 bytes  length of the head
/// head     all but the shapes, then their numbers of rows and columns, in the postcard format
/// rest     the shapes, column by column
/// ```
pub(super) fn keep(cache: &Cache, stage: &str, key: &Key, modes: &mut Modes) {
    let (basis, momentum) = modes;
    let shapes = std::mem::replace(&mut basis.shapes, DMatrix::zeros(0, 0));
    let head = postcard::to_stdvec(&(&*basis, momentum, shapes.shape()));
    basis.shapes = shapes;
    // Only a type without a fixed form has no postcard, and this one has.
    let Ok(head) = head else { return };
    let mut bytes = Vec::with_capacity(8 + head.len() + 8 * basis.shapes.len());
    bytes.extend((head.len() as u64).to_le_bytes());
    bytes.extend(head);
    bytes.extend(basis.shapes.iter().flat_map(|entry| entry.to_le_bytes()));
    cache.put_bytes(stage, key, &bytes);
}

/// None of bytes that are no modes.
fn decode(from: &mut dyn Read, length: usize) -> Option<Modes> {
    let mut of_head = [0; 8];
    from.read_exact(&mut of_head).ok()?;
    let of_head = usize::try_from(u64::from_le_bytes(of_head)).ok()?;
    let of_shapes = length.checked_sub(8)?.checked_sub(of_head)?;
    let mut head = vec![0; of_head];
    from.read_exact(&mut head).ok()?;
    type Head = (ModalBasis, Vec<f64>, (usize, usize));
    let (mut basis, momentum, (rows, columns)): Head = postcard::from_bytes(&head).ok()?;
    let count = rows.checked_mul(columns)?;
    if count.checked_mul(8)? != of_shapes {
        return None;
    }
    let mut entries = Vec::with_capacity(count);
    let mut part = vec![0; 8 * PART.min(count)];
    while entries.len() < count {
        part.truncate(8 * (count - entries.len()));
        from.read_exact(&mut part).ok()?;
        let (numbers, _) = part.as_chunks::<8>();
        entries.extend(numbers.iter().map(|number| f64::from_le_bytes(*number)));
    }
    basis.shapes = DMatrix::from_vec(rows, columns, entries);
    Some((basis, momentum))
}
