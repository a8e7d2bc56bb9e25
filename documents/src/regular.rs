//! Reading of input files: regular ones of a bounded length, so that no pipe or device can hang a program or fill its
//! memory.

use std::fs::File;
use std::io::{self, Read as _};
use std::path::Path;

/// Opens a file for reading; its length in bytes.
///
/// # Errors
/// Those of the file system; [`io::ErrorKind::InvalidInput`] for a folder, a pipe or a device.
pub fn open_regular(path: &Path) -> io::Result<(File, u64)> {
    let invalid = |what: &str| Err(io::Error::new(io::ErrorKind::InvalidInput, what));
    // Before it is opened: to open a pipe is to wait for its writer.
    let data = std::fs::metadata(path)?;
    if data.is_dir() {
        return invalid("it is a folder; give a file");
    }
    if !data.is_file() {
        return invalid("it is a pipe or a device; give a regular file");
    }
    Ok((File::open(path)?, data.len()))
}

/// Reads a file whole.
///
/// # Errors
/// Those of [`open_regular`]; [`io::ErrorKind::InvalidInput`] for a file longer than `most` bytes.
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
    // A file that grows meanwhile stays bounded.
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
