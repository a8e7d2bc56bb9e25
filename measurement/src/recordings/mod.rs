//! Recordings of a shot: WAV, universal files and tables, read as signals in SI units on a common time axis.

mod axis;
mod calibration;
mod csv;
mod fault;
mod format;
mod limits;
mod riff;
mod shot;
mod signals;
mod track;
mod universal;
pub mod wav;

use std::io::{self, Cursor, Read as _};
use std::path::Path;

use nailnoise_documents::{open_regular, read_regular};
use nailnoise_meshes::uff::is_universal;

pub use calibration::calibrator_rms;
pub use calibration::{Calibration, Calibrator, FullScale, Quantity};
pub use fault::Fault;
pub use limits::{EVENNESS, LOWEST_RATE, RUN, SAME_RATE, SHOT};
pub use nailnoise_documents::tables::Foreign;
pub use shot::{Offsets, Shot};
pub use signals::{Signals, Source, crossing, dead, read, read_shot, refuse, unreadable};
pub use track::{Numbers, Refusal, Selector, Track};

/// Largest universal file or table accepted \[byte\]; WAV files may have any length.
pub const LARGEST: u64 = 1 << 28;

/// Reads channels of a recording whose format is recognised from its bytes. `path` is for messages.
///
/// # Errors
/// The fault, with the index of the channel in `channels`; a fault of the complete file has index 0.
pub fn decode(bytes: &[u8], path: &Path, channels: &[&Selector]) -> Result<Vec<Track>, Refusal> {
    let tracks = if riff::is_riff(bytes) {
        wav::decode(Cursor::new(bytes), bytes.len() as u64, channels)
    } else if is_universal(bytes) {
        universal::decode(bytes, path, channels)
    } else {
        csv::decode(bytes, channels)
    }?;
    finite(tracks)
}

/// Reads channels of a recording from a file, like [`decode`]. WAV files are read block by block.
///
/// # Errors
/// The outer error is from the file system, or the file is not regular. Files other than WAV must not be longer than
/// [`LARGEST`]. The inner error is that of [`decode`].
pub fn read_tracks(path: &Path, channels: &[&Selector]) -> io::Result<Result<Vec<Track>, Refusal>> {
    let (mut file, length) = open_regular(path)?;
    let mut mark = Vec::new();
    file.by_ref().take(4).read_to_end(&mut mark)?;
    if riff::is_riff(&mark) {
        return Ok(wav::decode(file, length, channels).and_then(finite));
    }
    let bytes = read_regular(path, LARGEST).map_err(|error| match error.kind() {
        io::ErrorKind::InvalidInput => io::Error::new(error.kind(), format!("{error}; only WAV files may be larger")),
        _ => error,
    })?;
    Ok(decode(&bytes, path, channels))
}

/// Rejects samples that are not finite.
fn finite(tracks: Vec<Track>) -> Result<Vec<Track>, Refusal> {
    for (index, track) in tracks.iter().enumerate() {
        let wrong = track.samples.iter().enumerate().find(|(_, value)| !value.is_finite());
        if let Some((at, value)) = wrong {
            let sample = at + 1;
            return Err((index, Fault::NotFinite { sample, value: *value }));
        }
    }
    Ok(tracks)
}
