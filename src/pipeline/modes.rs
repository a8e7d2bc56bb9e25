//! Modes as the cache keeps them: their shapes, which are nearly all of it, are read straight into a matrix.
//!
//! Kept are the shapes on every node in double precision, which boundary elements and exports want, and once more those on the
//! surface in single precision, which is a fifth of the bytes and all that another shot takes of them.

use std::io::Read;

use nailnoise_fem::ModalBasis;
use nalgebra::{DMatrix, Scalar};
use serde::Serialize;
use serde::de::DeserializeOwned;

use super::geometry::BodyKind;
use crate::store::{Key, Store};

/// Numbers of a shape taken at once.
const PART: usize = 1 << 13;

/// Modes, and the momentum of a rise at unit speed on every degree of freedom \[kg\].
pub(super) type Modes = (ModalBasis, Vec<f64>);

/// The modes of a body and what is kept of them, by the digest of all that they are computed from.
pub(super) struct Kept<'a> {
    cache: &'a Store,
    kind: BodyKind,
    key: Key,
}

impl<'a> Kept<'a> {
    pub(super) fn new(cache: &'a Store, kind: BodyKind, identity: &[u8; 32]) -> Self {
        let key = Key::new().with(identity);
        Self { cache, kind, key }
    }

    fn whole(&self) -> String {
        format!("modes of the {}", self.kind.name())
    }

    fn skin(&self) -> String {
        format!("modes on the surface of the {}", self.kind.name())
    }

    /// All of the modes, if they are kept.
    pub(super) fn modes(&self) -> Option<Modes> {
        let decode = |from: &mut dyn Read, length| decode(from, length, f64::from_le_bytes);
        let found = self.cache.decoded(&self.whole(), &self.key, decode).flatten();
        let ((known, momentum), shapes): ((ModalBasis<()>, Vec<f64>), _) = found?;
        Some((known.swap_shapes(shapes).0, momentum))
    }

    /// Keeps all of the modes.
    pub(super) fn keep_modes(&self, (basis, momentum): Modes) -> Modes {
        let (known, shapes) = basis.swap_shapes(());
        self.keep(&self.whole(), &(&known, &momentum), &shapes, f64::to_le_bytes);
        (known.swap_shapes(shapes).0, momentum)
    }

    /// Shapes on the surface, see [`super::Body::skin`]. The whole modes are then likely to be wanted later.
    pub(super) fn surface(&self) -> Option<DMatrix<f32>> {
        let decode = |from: &mut dyn Read, length| decode(from, length, f32::from_le_bytes);
        let ((), shapes) = self.cache.decoded(&self.skin(), &self.key, decode).flatten()?;
        self.cache.renew(&self.whole(), &self.key);
        Some(shapes)
    }

    /// Keeps them.
    pub(super) fn keep_surface(&self, shapes: &DMatrix<f32>) {
        self.keep(&self.skin(), &(), shapes, f32::to_le_bytes);
    }

    /// Keeps a matrix and what belongs to it.
    ///
    /// ```text
    /// 8 bytes  length of the head
    /// head     what belongs to it, then the numbers of rows and columns, in the postcard format
    /// rest     the entries, column by column, little-endian
    /// ```
    fn keep<H: Serialize, T: Scalar + Copy, const N: usize>(
        &self,
        stage: &str,
        head: &H,
        matrix: &DMatrix<T>,
        bytes_of: impl Fn(T) -> [u8; N],
    ) {
        // Only a type without a fixed form has no postcard, and these have.
        let Ok(head) = postcard::to_stdvec(&(head, matrix.shape())) else {
            return;
        };
        let entries = matrix.as_slice();
        let mut bytes = Vec::with_capacity(8 + head.len() + N * entries.len());
        bytes.extend((head.len() as u64).to_le_bytes());
        bytes.extend(head);
        bytes.extend(entries.iter().flat_map(|entry| bytes_of(*entry)));
        self.cache.put_bytes(stage, &self.key, &bytes);
    }
}

/// None of bytes that are no such matrix.
fn decode<H: DeserializeOwned, T: Scalar, const N: usize>(
    from: &mut dyn Read,
    length: usize,
    number: impl Fn([u8; N]) -> T,
) -> Option<(H, DMatrix<T>)> {
    let mut of_head = [0; 8];
    from.read_exact(&mut of_head).ok()?;
    let of_head = usize::try_from(u64::from_le_bytes(of_head)).ok()?;
    let of_entries = length.checked_sub(8)?.checked_sub(of_head)?;
    let mut head = vec![0; of_head];
    from.read_exact(&mut head).ok()?;
    let (head, (rows, columns)): (H, (usize, usize)) = postcard::from_bytes(&head).ok()?;
    let count = rows.checked_mul(columns)?;
    if count.checked_mul(N)? != of_entries {
        return None;
    }
    let mut entries = Vec::with_capacity(count);
    let mut part = vec![0; N * PART.min(count)];
    while entries.len() < count {
        part.truncate(N * (count - entries.len()));
        from.read_exact(&mut part).ok()?;
        let (numbers, _) = part.as_chunks::<N>();
        entries.extend(numbers.iter().map(|bytes| number(*bytes)));
    }
    Some((head, DMatrix::from_vec(rows, columns, entries)))
}
