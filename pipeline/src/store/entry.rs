//! One entry: a header of 66 bytes, then the value in the postcard format.
//!
//! ```text
//! 18 bytes  "nailnoise cache 2\n"
//! 32 bytes  SHA-256 of the inputs
//! 16 bytes  XXH3-128 of the value's bytes
//! ```
//! The name is the stage, a hyphen, and the digest of the inputs in hexadecimal digits.

use std::fs::{File, Metadata};
use std::io::{self, BufReader, Read, Seek as _, SeekFrom, Write};
use std::path::Path;
use std::time::SystemTime;

use thiserror::Error;

use super::checksum::{Checksum, Summed, checksum};
use super::key::hexadecimal;
use super::replace::replace;

const MAGIC: &[u8; 18] = b"nailnoise cache 2\n";

/// Bytes with which entries of all versions begin.
const OF_ALL_VERSIONS: &[u8] = b"nailnoise cache ";

/// Bytes of the checksum.
const SUM: usize = size_of::<Checksum>();

/// Bytes before the value's.
const HEADER: usize = MAGIC.len() + 32 + SUM;

/// Bytes of small values that are read or written at once.
const BUFFER: usize = 1 << 16;

/// Extension of the files.
const EXTENSION: &str = "entry";

/// The fault of an entry.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum Damage {
    /// Something else than a file has its name.
    #[error("is {0}, not a file")]
    NoFile(&'static str),
    /// The file cannot be read.
    #[error("cannot be read ({0})")]
    Unreadable(#[from] io::Error),
    /// It is not an entry of this format.
    #[error("is of another format")]
    Foreign,
    /// Its header names other inputs than its file name.
    #[error("belongs to other inputs")]
    Misplaced,
    /// Its bytes are not those that were written.
    #[error("is damaged: its content does not match its checksum")]
    Altered,
}

/// Whether a file of this name is an entry: a stage and 64 hexadecimal digits.
pub(super) fn is_name(name: &str) -> bool {
    let digits = name
        .strip_suffix(EXTENSION)
        .and_then(|stem| stem.strip_suffix('.'))
        .and_then(|stem| stem.rsplit_once('-'))
        .map_or("", |(_, digits)| digits);
    digits.len() == 64 && digits.bytes().all(|digit| digit.is_ascii_hexdigit())
}

/// Whether a file begins as an entry of this or another version of the program, or has been cut short of its header.
/// Only an object that is not a file is in the way of an entry.
pub(super) fn is_own(path: &Path) -> bool {
    if !path.is_file() {
        return true;
    }
    let mut beginning = Vec::new();
    let read = File::open(path).and_then(|file| file.take(HEADER as u64).read_to_end(&mut beginning));
    let known = &OF_ALL_VERSIONS[..beginning.len().min(OF_ALL_VERSIONS.len())];
    read.is_ok() && beginning.starts_with(known)
}

/// The file's name.
pub(super) fn name(stage: &str, digest: &[u8; 32]) -> String {
    let stage: String = stage
        .chars()
        .map(|c| if c.is_alphanumeric() { c } else { '-' })
        .collect();
    format!("{stage}-{}.{EXTENSION}", hexadecimal(digest))
}

/// Result of `decode` from the value's bytes as they are read, and their number, if there are any. The result is
/// discarded unless the bytes are those that were written.
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
    // A value that could not be decoded is damaged, or else is another one: the rest of the file decides.
    io::copy(&mut content, &mut io::sink())?;
    let content = content.into_inner();
    if content.checksum() != of_content {
        return Err(Damage::Altered);
    }
    used(content.inner());
    Ok(Some(value))
}

/// The file at the beginning of the value's bytes, their number and checksum, if there is one.
fn open(path: &Path, inputs: &[u8; 32]) -> Result<Option<(File, usize, Checksum)>, Damage> {
    // A link to nothing is not an entry, either; the next one replaces it.
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

/// Only a file can be opened without waiting: a pipe waits for a writer.
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

/// Counts an entry as used now, if it exists.
pub(super) fn renew(path: &Path) {
    if path.is_file()
        && let Ok(file) = File::open(path)
    {
        used(&file);
    }
}

fn used(file: &File) {
    // The time determines the order of removal; if it cannot be set, entries go in the order of their arrival.
    let _ = file.set_modified(SystemTime::now());
}

/// Writes the bytes that `fill` gives and returns the size of the file, without a copy of them in memory. The file is
/// not synced: an entry that a failure of power leaves in parts is noticed like any other damage.
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

/// Whether the file is intact and has the name of its entry.
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

/// The checksum of the value's bytes, and these.
fn parts<'a>(bytes: &'a [u8], inputs: Option<&[u8; 32]>) -> Result<(&'a Checksum, &'a [u8]), Damage> {
    let rest = bytes.strip_prefix(MAGIC).ok_or(Damage::Foreign)?;
    let (of_inputs, rest) = rest.split_first_chunk::<32>().ok_or(Damage::Altered)?;
    if inputs.is_some_and(|inputs| inputs != of_inputs) {
        return Err(Damage::Misplaced);
    }
    rest.split_first_chunk::<SUM>().ok_or(Damage::Altered)
}
