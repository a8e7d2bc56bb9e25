//! A cache entry: a header of 66 bytes, followed by the value in the postcard format.
//!
//! ```text
//! 18 bytes  "nailnoise cache 2\n"
//! 32 bytes  SHA-256 of the inputs
//! 16 bytes  XXH3-128 of the value's bytes
//! ```
//! The file name consists of the stage, a hyphen and the digest of the inputs in hexadecimal.

use std::fs::{File, Metadata};
use std::io::{self, BufReader, Read, Seek as _, SeekFrom, Write};
use std::path::Path;
use std::time::SystemTime;

use thiserror::Error;

use super::checksum::{Checksum, Summed, checksum};
use super::key::hexadecimal;
use super::replace::replace;

const MAGIC: &[u8; 18] = b"nailnoise cache 2\n";

/// Leading bytes of entries of all versions.
const OF_ALL_VERSIONS: &[u8] = b"nailnoise cache ";

/// Size of the checksum \[bytes\].
const SUM: usize = size_of::<Checksum>();

/// Size of the header \[bytes\].
const HEADER: usize = MAGIC.len() + 32 + SUM;

/// Buffer size for reading and writing \[bytes\].
const BUFFER: usize = 1 << 16;

/// Extension of the entry files.
const EXTENSION: &str = "entry";

/// Fault of an entry.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum Damage {
    /// The object with its name is not a file.
    #[error("is {0}, not a file")]
    NoFile(&'static str),
    /// The file cannot be read.
    #[error("cannot be read ({0})")]
    Unreadable(#[from] io::Error),
    /// The file is not an entry of this format.
    #[error("is of another format")]
    Foreign,
    /// The inputs in its header differ from those in its file name.
    #[error("belongs to other inputs")]
    Misplaced,
    /// The bytes differ from those that were written.
    #[error("is damaged: its content does not match its checksum")]
    Altered,
}

/// Whether a file name is that of an entry: a stage and 64 hexadecimal digits.
pub(super) fn is_name(name: &str) -> bool {
    let digits = name
        .strip_suffix(EXTENSION)
        .and_then(|stem| stem.strip_suffix('.'))
        .and_then(|stem| stem.rsplit_once('-'))
        .map_or("", |(_, digits)| digits);
    digits.len() == 64 && digits.bytes().all(|digit| digit.is_ascii_hexdigit())
}

/// Whether a file begins like an entry of any version of the program, or is truncated within its header. Only an object
/// that is not a file obstructs an entry.
pub(super) fn is_own(path: &Path) -> bool {
    if !path.is_file() {
        return true;
    }
    let mut beginning = Vec::new();
    let read = File::open(path).and_then(|file| file.take(HEADER as u64).read_to_end(&mut beginning));
    let known = &OF_ALL_VERSIONS[..beginning.len().min(OF_ALL_VERSIONS.len())];
    read.is_ok() && beginning.starts_with(known)
}

/// The file name of an entry.
pub(super) fn name(stage: &str, digest: &[u8; 32]) -> String {
    let stage: String = stage
        .chars()
        .map(|c| if c.is_alphanumeric() { c } else { '-' })
        .collect();
    format!("{stage}-{}.{EXTENSION}", hexadecimal(digest))
}

/// Applies `decode` to the value's bytes while they are read; also returns their number. None if there is no entry. The
/// result is discarded if the bytes differ from those that were written.
pub(super) fn read_by<T>(
    path: &Path,
    inputs: &[u8; 32],
    decode: impl FnOnce(&mut dyn Read, usize) -> T,
) -> Result<Option<T>, Damage> {
    let Some((file, length, of_content)) = open(path, inputs)? else {
        return Ok(None);
    };
    let mut content = BufReader::with_capacity(BUFFER, Summed::over(file));
    let value = decode(&mut content, length);
    // If decoding failed, the rest of the file shows whether it is damaged or has another layout.
    io::copy(&mut content, &mut io::sink())?;
    let content = content.into_inner();
    if content.checksum() != of_content {
        return Err(Damage::Altered);
    }
    used(content.inner());
    Ok(Some(value))
}

/// Opens an entry, positioned at the value's bytes; returns their number and checksum. None if there is no entry.
fn open(path: &Path, inputs: &[u8; 32]) -> Result<Option<(File, usize, Checksum)>, Damage> {
    // A dangling link is not an entry, either; the next entry replaces it.
    let data = match std::fs::metadata(path) {
        Err(error) if error.kind() == io::ErrorKind::NotFound => return Ok(None),
        found => found?,
    };
    is_file(&data)?;
    let mut file = File::open(path)?;
    let length = file.metadata()?.len() as usize;
    let mut header = Vec::with_capacity(HEADER);
    (&mut file).take(HEADER as u64).read_to_end(&mut header)?;
    let (of_content, _) = parts(&header, Some(inputs))?;
    Ok(Some((file, length - HEADER, *of_content)))
}

/// Only regular files are opened: opening a pipe would block until it has a writer.
pub(super) fn is_file(data: &Metadata) -> Result<(), Damage> {
    if data.is_file() {
        return Ok(());
    }
    Err(Damage::NoFile(match data.file_type() {
        kind if kind.is_dir() => "a folder",
        kind if kind.is_symlink() => "a link to nothing",
        _ => "a pipe or a device",
    }))
}

/// Marks an entry as used now, if it exists.
pub(super) fn renew(path: &Path) {
    if path.is_file()
        && let Ok(file) = File::open(path)
    {
        used(&file);
    }
}

fn used(file: &File) {
    // The time determines the order of eviction; if it cannot be set, entries are evicted in the order of creation.
    let _ = file.set_modified(SystemTime::now());
}

/// Writes the bytes produced by `fill` without a copy in memory, and returns the size of the file. The file is not
/// synced: an entry left incomplete by a power failure is detected like any other damage.
pub(super) fn write_by(
    path: &Path,
    inputs: &[u8; 32],
    fill: impl FnOnce(&mut dyn Write) -> io::Result<()>,
) -> io::Result<u64> {
    if let Some(folder) = path.parent() {
        std::fs::create_dir_all(folder)?;
    }
    replace(path, |file| {
        file.write_all(&[&MAGIC[..], inputs, &[0; SUM]].concat())?;
        let mut content = Summed::over(&mut *file);
        fill(&mut content)?;
        let of_content = content.checksum();
        let size = file.stream_position()?;
        file.seek(SeekFrom::Start((MAGIC.len() + inputs.len()) as u64))?;
        file.write_all(&of_content)?;
        Ok(size)
    })
}

/// Checks that the file is intact and matches its name.
pub(super) fn verify(path: &Path) -> Result<(), Damage> {
    is_file(&std::fs::metadata(path).or_else(|_| std::fs::symlink_metadata(path))?)?;
    let bytes = std::fs::read(path)?;
    let (of_content, content) = parts(&bytes, None)?;
    if checksum(content) != *of_content {
        return Err(Damage::Altered);
    }
    let inputs = bytes[MAGIC.len()..]
        .first_chunk::<32>()
        .map(|digest| hexadecimal(digest))
        .unwrap_or_default();
    let name = path.file_stem().unwrap_or_default().to_string_lossy().into_owned();
    if name.ends_with(&inputs) {
        Ok(())
    } else {
        Err(Damage::Misplaced)
    }
}

/// Splits an entry into the checksum and the value's bytes.
fn parts<'a>(bytes: &'a [u8], inputs: Option<&[u8; 32]>) -> Result<(&'a Checksum, &'a [u8]), Damage> {
    let rest = bytes.strip_prefix(MAGIC).ok_or(Damage::Foreign)?;
    let (of_inputs, rest) = rest.split_first_chunk::<32>().ok_or(Damage::Altered)?;
    if inputs.is_some_and(|inputs| inputs != of_inputs) {
        return Err(Damage::Misplaced);
    }
    rest.split_first_chunk::<SUM>().ok_or(Damage::Altered)
}
