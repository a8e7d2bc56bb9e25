//! The header and the sections of a `.msh` file.

use super::MshError;
use super::cursor::{Cursor, Encoding};
use super::raw::Raw;
use super::v4::Layout;
use super::{v2, v4};

/// Reads all sections of a file.
pub(super) fn sections(bytes: &[u8]) -> Result<Raw, MshError> {
    let mut cursor = Cursor::new(bytes);
    // Files of version 1 have no header.
    let version = match cursor.clone().open() {
        Ok(Some(name)) if name == "MeshFormat" => {
            cursor.open()?;
            header(&mut cursor)?
        }
        Ok(Some(name)) if name == "NOD" => Version::V1,
        _ => return Err(MshError::NotMsh),
    };
    let mut raw = Raw {
        groups: vec![Vec::new()],
        offsets: vec![0],
        ..Raw::default()
    };
    let mut entities = v4::Entities::default();
    let (mut has_nodes, mut has_elements) = (false, false);
    while let Some(section) = cursor.open()? {
        match (section.as_str(), version) {
            ("PhysicalNames", _) => read_names(&mut cursor, &mut raw)?,
            ("Entities", Version::V4(layout)) => entities.read(&mut cursor, layout)?,
            ("PartitionedEntities", Version::V4(layout)) => entities.read_partitioned(&mut cursor, layout)?,
            ("NOD", Version::V1) | ("Nodes", Version::V2) => v2::nodes(&mut cursor, &mut raw)?,
            ("ParametricNodes", Version::V2) => v2::parametric_nodes(&mut cursor, &mut raw)?,
            ("Nodes", Version::V4(layout)) => v4::nodes(&mut cursor, layout, &mut raw)?,
            ("ELM", Version::V1) => v2::elements_of_version_1(&mut cursor, &mut raw)?,
            ("Elements", Version::V2) => v2::elements(&mut cursor, &mut raw)?,
            ("Elements", Version::V4(layout)) => v4::elements(&mut cursor, layout, &entities, &mut raw)?,
            ("Comments", _) => {
                raw.comment = cursor.line();
                cursor.skip_section()?;
                continue;
            }
            _ => {
                cursor.skip_section()?;
                continue;
            }
        }
        cursor.close()?;
        has_nodes |= matches!(section.as_str(), "NOD" | "Nodes" | "ParametricNodes");
        has_elements |= matches!(section.as_str(), "ELM" | "Elements");
    }
    let names = match version {
        Version::V1 => ["NOD", "ELM"],
        Version::V2 | Version::V4(_) => ["Nodes", "Elements"],
    };
    for (section, found) in names.into_iter().zip([has_nodes, has_elements]) {
        if !found {
            return Err(MshError::NoSection { section });
        }
    }
    Ok(raw)
}

fn read_names(cursor: &mut Cursor<'_>, raw: &mut Raw) -> Result<(), MshError> {
    let count = cursor.text_integer()?;
    let count = cursor.count("names", u64::try_from(count).unwrap_or(u64::MAX), 7)?;
    for _ in 0..count {
        let (dimension, number) = (cursor.text_integer()?, cursor.text_integer()?);
        let name = cursor.quoted()?;
        raw.names.push((dimension, number, name));
    }
    Ok(())
}

#[derive(Debug, Clone, Copy)]
enum Version {
    V1,
    V2,
    V4(Layout),
}

fn header(cursor: &mut Cursor<'_>) -> Result<Version, MshError> {
    let word = cursor.word()?;
    let version = match word {
        "2.2" | "2.1" | "2" | "2.0" => Version::V2,
        "4" | "4.0" => Version::V4(Layout::V40),
        "4.1" => Version::V4(Layout::V41),
        _ => {
            let found = word.chars().take(20).collect();
            return Err(MshError::Version { found });
        }
    };
    let binary = cursor.text_integer()?;
    let size = cursor.text_integer()?;
    let header = |what, found: i64, expected| MshError::Header {
        what,
        found: found.to_string(),
        expected,
    };
    match (version, size) {
        (Version::V2, 8) | (Version::V4(_), 4 | 8) => {}
        _ => return Err(header("data size", size, "numbers of 8 bytes are read")),
    }
    match binary {
        0 => {}
        1 => {
            cursor.end_of_line();
            let swapped = match cursor.raw_four()? {
                [1, 0, 0, 0] => false,
                [0, 0, 0, 1] => true,
                found => {
                    let found = i64::from(i32::from_le_bytes(found));
                    return Err(header("byte order", found, "a binary 1 tells the order of bytes"));
                }
            };
            let size = if size == 4 { 4 } else { 8 };
            cursor.encoding = Encoding::Binary { swapped, size };
        }
        _ => return Err(header("file type", binary, "0 is text and 1 is binary")),
    }
    cursor.close()?;
    Ok(version)
}
