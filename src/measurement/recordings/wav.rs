//! WAV files: integers of 16, 24 and 32 bits and floats of 32 bits, any number of channels.

use std::io::{self, Cursor};

use hound::{SampleFormat, WavReader, WavSpec, WavWriter};

use super::fault::Fault;
use super::{Numbers, Refusal, Selector, Track, numbers};

/// How samples are written.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Coding {
    /// Integers of 24 bits; the largest one is full scale.
    Integer24,
    /// Floats of 32 bits; 1 is full scale.
    Float32,
}

/// A WAV file of signals of one length, a channel each.
///
/// `rate` is in Hz; `full_scale`, in the unit of the signals, is the value of the largest sample.
///
/// # Errors
/// Signals of different lengths, none or more than 65 535 of them, values that are not finite or, as integers, beyond
/// full scale, or more bytes than a WAV file can hold (4 GiB).
pub fn encode(signals: &[&[f64]], rate: u32, full_scale: f64, coding: Coding) -> io::Result<Vec<u8>> {
    let invalid = |what: &str| io::Error::new(io::ErrorKind::InvalidInput, what);
    let length = signals.first().map_or(0, |signal| signal.len());
    if signals.iter().any(|signal| signal.len() != length) {
        return Err(invalid("the channels of a WAV file have one length"));
    }
    if signals
        .iter()
        .any(|signal| signal.iter().any(|value| !value.is_finite()))
    {
        return Err(invalid("the samples of a WAV file are finite"));
    }
    let channels = u16::try_from(signals.len()).ok().filter(|count| *count > 0);
    let channels = channels.ok_or_else(|| invalid("a WAV file has 1 to 65535 channels"))?;
    let (bits_per_sample, sample_format) = match coding {
        Coding::Integer24 => (24, SampleFormat::Int),
        Coding::Float32 => (32, SampleFormat::Float),
    };
    let spec = WavSpec {
        channels,
        sample_rate: rate,
        bits_per_sample,
        sample_format,
    };
    let mut bytes = Cursor::new(Vec::new());
    let mut writer = WavWriter::new(&mut bytes, spec).map_err(io::Error::other)?;
    let full = largest(bits_per_sample);
    for index in 0..length {
        for signal in signals {
            let fraction = signal[index] / full_scale;
            if coding == Coding::Integer24 && (fraction * full).round().abs() > full {
                return Err(invalid("a sample is beyond the full scale of its WAV file"));
            }
            let written = match coding {
                Coding::Integer24 => writer.write_sample((fraction * full).round() as i32),
                Coding::Float32 => writer.write_sample(fraction as f32),
            };
            written.map_err(io::Error::other)?;
        }
    }
    writer.finalize().map_err(io::Error::other)?;
    plain(bytes.into_inner(), coding).ok_or_else(|| io::Error::other("the header of a WAV file is not extensible"))
}

/// A WAV file with the format chunk of 16 bytes in the place of the extensible one of 40 bytes that hound writes for more than
/// 16 bits, because Python's `wave` before 3.12 and other simple readers open no extensible one.
fn plain(mut file: Vec<u8>, coding: Coding) -> Option<Vec<u8>> {
    const CHUNK: std::ops::Range<usize> = 12..20;
    const FORMAT: std::ops::Range<usize> = 20..22;
    const EXTENSION: std::ops::Range<usize> = 36..60;
    let extensible = [&b"fmt "[..], &40_u32.to_le_bytes()].concat();
    if file.get(CHUNK)? != extensible || file.get(FORMAT)? != 0xfffe_u16.to_le_bytes() || file.len() < EXTENSION.end {
        return None;
    }
    let tag: u16 = match coding {
        Coding::Integer24 => 1,
        Coding::Float32 => 3,
    };
    file[FORMAT].copy_from_slice(&tag.to_le_bytes());
    file[16..20].copy_from_slice(&16_u32.to_le_bytes());
    file.drain(EXTENSION);
    let rest = u32::try_from(file.len() - 8).ok()?;
    file[4..8].copy_from_slice(&rest.to_le_bytes());
    Some(file)
}

/// The largest integer of so many bits.
fn largest(bits: u16) -> f64 {
    ((1_i64 << (bits - 1)) - 1) as f64
}

/// Reads channels of a WAV file.
pub(super) fn decode(bytes: &[u8], channels: &[&Selector]) -> Result<Vec<Track>, Refusal> {
    let wanted = numbers(channels, "a WAV file")?;
    let format = |error: hound::Error| {
        let problem = error.to_string();
        (0, Fault::Format { problem })
    };
    let mut reader = WavReader::new(bytes).map_err(format)?;
    let spec = reader.spec();
    let count = usize::from(spec.channels);
    for (index, channel) in wanted.iter().copied().enumerate() {
        if !(1..=count).contains(&channel) {
            let channels = count;
            return Err((index, Fault::NoChannel { channel, channels }));
        }
    }
    let expected = reader.len() as usize / count;
    let (numbers, all) = match (spec.sample_format, spec.bits_per_sample) {
        (SampleFormat::Int, bits @ (16 | 24 | 32)) => {
            let full = largest(bits);
            let scaled = |sample: i32| f64::from(sample) / full;
            (
                Numbers::Integers,
                select(reader.samples().map_while(Result::ok).map(scaled), count, &wanted),
            )
        }
        (SampleFormat::Float, 32) => {
            let samples = reader.samples::<f32>().map_while(Result::ok).map(f64::from);
            (Numbers::Fractions, select(samples, count, &wanted))
        }
        (kind, bits) => {
            let kind = if kind == SampleFormat::Int { "integer" } else { "float" };
            return Err((0, Fault::Width { bits, kind }));
        }
    };
    let tracks = all.into_iter().map(|samples| Track {
        rate: f64::from(spec.sample_rate),
        start: None,
        samples,
        numbers,
        unit: String::new(),
    });
    let tracks: Vec<Track> = tracks.collect();
    match tracks.iter().map(|track| track.samples.len()).min().unwrap_or(0) {
        found if found < expected => Err((0, Fault::CutOff { expected, found })),
        0 => Err((0, Fault::Empty { samples: 0 })),
        _ => Ok(tracks),
    }
}

/// The wanted channels, from 1, of interleaved samples of `count` channels.
fn select(samples: impl Iterator<Item = f64>, count: usize, wanted: &[usize]) -> Vec<Vec<f64>> {
    let mut all = vec![Vec::new(); wanted.len()];
    // Where each channel of the file goes; one may be asked for twice.
    let mut targets = vec![Vec::new(); count];
    for (index, channel) in wanted.iter().enumerate() {
        targets[channel - 1].push(index);
    }
    let mut at = 0;
    for sample in samples {
        for &index in &targets[at] {
            all[index].push(sample);
        }
        at = if at + 1 == count { 0 } else { at + 1 };
    }
    all
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_sound_file_reads_back_its_pressures() {
        let signal: Vec<f64> = (0..1000).map(|i| 3.0 * (0.05 * f64::from(i)).sin()).collect();
        let bytes = encode(&[&signal], 48_000, 5.0, Coding::Integer24).unwrap_or_default();
        let Ok(tracks) = decode(&bytes, &[&Selector::Channel(1)]) else {
            panic!("not a sound file");
        };
        assert_eq!((tracks[0].rate, tracks[0].samples.len()), (48_000.0, 1000));
        for (sample, pressure) in tracks[0].samples.iter().zip(&signal) {
            assert!((sample * 5.0 - pressure).abs() < 0.51 * 5.0 / largest(24));
        }
    }

    /// 16 bytes of format, data behind 44 bytes: as every reader of WAV files knows it.
    #[test]
    fn the_header_is_the_plain_one() {
        for (coding, tag, bytes) in [(Coding::Integer24, 1, 3), (Coding::Float32, 3, 4)] {
            let file = encode(&[&[0.5; 10], &[-0.5; 10]], 48_000, 1.0, coding).unwrap_or_default();
            assert_eq!(
                (&file[12..16], file[16], file[20], file[22]),
                (&b"fmt "[..], 16, tag, 2)
            );
            assert_eq!(
                (&file[36..40], usize::from(file[40]), file.len()),
                (&b"data"[..], 20 * bytes, 44 + 20 * bytes)
            );
            assert_eq!(usize::from(file[4]), file.len() - 8);
        }
    }
}
