//! `.msh` files of gmsh, versions 1, 2, 4.0 and 4.1, text and binary.
//!
//! Named volumes (`Physical Volume("housing")`) become the parts of the mesh, named surfaces its face groups; other
//! groups are ignored. In a file without names, the parts are its volume groups by number or, without groups, its
//! volumes. Numbers in messages are those of the file. The formats are described in the gmsh reference manual (C.
//! Geuzaine and J.-F. Remacle, version 4.8, chapters 9 and 10).

mod build;
mod cursor;
mod error;
mod raw;
mod sections;
mod v2;
mod v4;
mod write;

use std::io::{Read, Write};
use std::path::Path;

pub use build::Imported;
pub use error::MshError;
pub use write::{Format, to_bytes};

use crate::read_regular;

use crate::MeshError;

/// First bytes of a compressed file (RFC 1952).
const GZIP: [u8; 2] = [0x1f, 0x8b];

/// Largest file size accepted, compressed or not \[byte\].
pub const LARGEST: u64 = 4 << 30;

/// Reads a `.msh` file, which may be compressed with gzip. `unit` is the length of one unit of the file \[m\]. It is
/// ignored if the file's comments state that lengths are in metres, as those of [`to_bytes`] do.
///
/// # Errors
/// [`MeshError::Read`] or [`MeshError::Msh`].
pub fn read(path: &Path, unit: f64) -> Result<Imported, MeshError> {
    let bytes = read_regular(path, LARGEST).map_err(|source| MeshError::Read {
        path: path.to_owned(),
        source,
    })?;
    parse(&bytes, unit, path)
}

/// Parses the contents of a `.msh` file; `name` is for messages.
///
/// # Errors
/// Same as [`read`].
pub fn parse(bytes: &[u8], unit: f64, name: &Path) -> Result<Imported, MeshError> {
    let inflated;
    let bytes = if bytes.starts_with(&GZIP) {
        let mut text = Vec::new();
        flate2::read::GzDecoder::new(bytes)
            .take(LARGEST)
            .read_to_end(&mut text)
            .map_err(|source| MeshError::Read {
                path: name.to_owned(),
                source,
            })?;
        inflated = text;
        &inflated
    } else {
        bytes
    };
    sections::sections(bytes)
        .and_then(|raw| raw.build(unit))
        .map_err(|problem| MeshError::Msh {
            path: name.to_owned(),
            problem,
        })
}

/// Compresses a file with gzip, without a time stamp.
pub fn compressed(bytes: &[u8]) -> Vec<u8> {
    let mut encoder = flate2::GzBuilder::new()
        .mtime(0)
        .write(Vec::new(), flate2::Compression::best());
    // Writing to memory cannot fail.
    let _ = encoder.write_all(bytes);
    encoder.finish().unwrap_or_default()
}
