//! Reads input files: regular files of limited length only, so that a pipe or device cannot block the program or fill
//! its memory.

use std::fs::File;
use std::io::{self, Read as _};
use std::path::Path;

/// Opens a regular file for reading and returns its length in bytes.
///
/// # Errors
/// Errors of the file system; [`io::ErrorKind::InvalidInput`] for a folder, a pipe or a device.
pub fn open_regular(path: &Path) -> io::Result<(File, u64)> {
    let invalid = |what: &str| Err(io::Error::new(io::ErrorKind::InvalidInput, what));
    // Checked before opening, because opening a pipe blocks until there is a writer.
    let data = std::fs::metadata(path)?;
    if data.is_dir() {
        return invalid("it is a folder; give a file");
    }
    if !data.is_file() {
        return invalid("it is a pipe or a device; give a regular file");
    }
    Ok((File::open(path)?, data.len()))
}

/// Reads a regular file completely.
///
/// # Errors
/// Those of [`open_regular`]; [`io::ErrorKind::InvalidInput`] for a file of more than `most` bytes.
pub fn read_regular(path: &Path, most: u64) -> io::Result<Vec<u8>> {
    let (file, length) = open_regular(path)?;
    let too_long = |length: u64| {
        let message = format!(
            "it has {:.1} MB, at most {:.0} MB are read",
            1e-6 * length as f64,
            1e-6 * most as f64
        );
        Err(io::Error::new(io::ErrorKind::InvalidInput, message))
    };
    if length > most {
        return too_long(length);
    }
    let mut bytes = Vec::with_capacity(usize::try_from(length).unwrap_or(0));
    // The file may grow while it is read; the limit still applies.
    file.take(most + 1).read_to_end(&mut bytes)?;
    if bytes.len() as u64 > most {
        return too_long(bytes.len() as u64);
    }
    Ok(bytes)
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]

    use super::*;

    #[test]
    fn devices_folders_and_long_files_are_refused() {
        let own = Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/src/regular.rs"));
        assert!(read_regular(own, 1_000_000).is_ok());
        let long = read_regular(own, 10).unwrap_err();
        assert!(long.to_string().contains("at most"), "{long}");
        assert!(read_regular(own.parent().unwrap(), 10).is_err());
        #[cfg(unix)]
        {
            let device = read_regular(Path::new("/dev/zero"), 10).unwrap_err();
            assert!(device.to_string().contains("device"), "{device}");
        }
    }
}
