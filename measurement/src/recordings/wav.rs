//! WAV files: integers of 8 to 64 bits and floats of 32 and 64 bits, any number of channels.

use std::io::{self, Cursor, Read, Seek};

use hound::{SampleFormat, WavSpec, WavWriter};

use super::fault::Fault;
use super::format::{BitAlignment, Coded, Format};
use super::riff::Riff;
use super::track::{Numbers, Refusal, Selector, Track, numbers};
use nailnoise_documents::MemoryLimit;

/// Sample format for writing.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Coding {
    /// Integers of 24 bits; the largest one is full scale.
    Integer24,
    /// Floats of 32 bits; 1 is full scale.
    Float32,
}

/// Encodes signals of equal length as a WAV file, one channel each.
///
/// `rate` is in Hz; `full_scale`, in the unit of the signals, is the value of the largest sample.
///
/// # Errors
/// If signals differ in length, their number is zero or above 65 535, or the file would exceed the limit of WAV (4
/// GiB). Values must be finite and, for integers, within full scale.
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

/// Replaces the extensible format chunk of 40 bytes, which hound writes for more than 16 bits, with one of 16 bytes,
/// because Python's `wave` before 3.12 and other simple readers cannot read the extensible form.
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

/// The largest integer with this many bits.
fn largest(bits: u16) -> f64 {
    ((1_i64 << (bits - 1)) - 1) as f64
}

/// Number of bytes of a file in memory at a time, unless a single frame is larger.
const BLOCK: usize = 1 << 20;

/// Reads channels of a WAV file of `length` bytes block by block; only the requested samples stay in memory.
pub(super) fn decode<R: Read + Seek>(reader: R, length: u64, channels: &[&Selector]) -> Result<Vec<Track>, Refusal> {
    let wanted = numbers(channels, "a WAV file")?;
    let malformed = |problem: String| (0, Fault::Format { problem });
    let mut riff = Riff::new(reader, length);
    if let Some(form) = riff.form().map_err(unread)?.filter(|form| form != b"WAVE") {
        let form = String::from_utf8_lossy(&form);
        let problem = format!("it is a RIFF file of the form {:?}, not WAVE", form.trim());
        return Err(malformed(problem));
    }
    let found = riff.chunks().map_err(unread)?;
    let named = |name: [u8; 4]| found.iter().filter(move |chunk| chunk.name == name);
    let mut pauses = named(*b"wavl").next().is_some();
    for list in named(*b"LIST") {
        pauses |= riff.prefix(list, 4).map_err(unread)? == b"wavl";
    }
    if pauses {
        return Err(malformed(
            "its samples are in a list with pauses (wavl), which is not read".to_owned(),
        ));
    }
    let format = named(*b"fmt ").next();
    let format = format.ok_or_else(|| malformed("it is a WAV file without its chunk \"fmt \"".to_owned()))?;
    let format = riff.prefix(format, Format::LARGEST).map_err(unread)?;
    let format = Format::read(&format).map_err(|fault| (0, fault))?;
    let mut data = named(*b"data");
    let Some(samples) = data.next() else {
        // The file may end before the chunk begins.
        return Err(malformed(
            "it is a WAV file without its chunk \"data\"; it may be cut off".to_owned(),
        ));
    };
    if data.next().is_some() {
        return Err(malformed("it is a WAV file with two chunks \"data\"".to_owned()));
    }
    let count = format.channels;
    for (index, channel) in wanted.iter().copied().enumerate() {
        if !(1..=count).contains(&channel) {
            let channels = count;
            return Err((index, Fault::NoChannel { channel, channels }));
        }
    }
    // An incomplete last sample is ignored, as in every reader.
    let frame = count * format.container;
    let frames = samples.found / frame as u64;
    let stated = samples.length.map_or(frames, |length| length / frame as u64);
    let frames = usize::try_from(frames).unwrap_or(usize::MAX);
    if (frames as u64) < stated {
        let expected = usize::try_from(stated).unwrap_or(usize::MAX);
        return Err((
            0,
            Fault::CutOff {
                expected,
                found: frames,
            },
        ));
    }
    if frames == 0 {
        return Err((0, Fault::Empty { samples: 0 }));
    }
    let mut records = allocate_records(frames, wanted.len(), MemoryLimit::default()).map_err(|fault| (0, fault))?;
    let mut content = riff.content(samples).map_err(unread)?;
    let mut alignment = BitAlignment::default();
    let mut block = vec![0; frame * (BLOCK / frame).clamp(1, frames)];
    let mut left = frames;
    while left > 0 {
        let now = left.min(block.len() / frame);
        let bytes = &mut block[..now * frame];
        content.read_exact(bytes).map_err(unread)?;
        alignment.update(&format, bytes);
        for (channel, record) in wanted.iter().zip(&mut records) {
            let place = (channel - 1) * format.container;
            let sample = |frame: &[u8]| format.sample(&frame[place..place + format.container]);
            record.extend(bytes.chunks_exact(frame).map(sample));
        }
        left -= now;
    }
    alignment.check(&format).map_err(|fault| (0, fault))?;
    let numbers = match format.coded {
        Coded::Integer { .. } => Numbers::Integers,
        Coded::Float => Numbers::Fractions,
    };
    let tracks = records.into_iter().map(|samples| Track {
        rate: f64::from(format.rate),
        start: None,
        samples,
        numbers,
        unit: String::new(),
        measures: None,
    });
    Ok(tracks.collect())
}

/// A failure of the file system.
fn unread(error: io::Error) -> Refusal {
    let problem = error.to_string();
    (0, Fault::Format { problem })
}

/// Empty records with capacity for this many samples each.
fn allocate_records(samples: usize, channels: usize, limit: MemoryLimit) -> Result<Vec<Vec<f64>>, Fault> {
    let gigabytes = 1e-9 * size_of::<f64>() as f64 * samples as f64 * channels as f64;
    let fault = || Fault::Memory {
        samples,
        channels,
        gigabytes,
        allowed: limit.gigabytes,
    };
    if !limit.allows(gigabytes) {
        return Err(fault());
    }
    let record = |_| {
        let mut record = Vec::new();
        record.try_reserve_exact(samples).map_err(|_| fault())?;
        Ok(record)
    };
    (0..channels).map(record).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_sound_file_reads_back_its_pressures() {
        let signal: Vec<f64> = (0..1000).map(|i| 3.0 * (0.05 * f64::from(i)).sin()).collect();
        let bytes = encode(&[&signal], 48_000, 5.0, Coding::Integer24).unwrap_or_default();
        let length = bytes.len() as u64;
        let Ok(tracks) = decode(Cursor::new(&bytes), length, &[&Selector::Channel(1)]) else {
            panic!("not a sound file");
        };
        assert_eq!((tracks[0].rate, tracks[0].samples.len()), (48_000.0, 1000));
        for (sample, pressure) in tracks[0].samples.iter().zip(&signal) {
            assert!((sample * 5.0 - pressure).abs() < 0.51 * 5.0 / largest(24));
        }
    }

    /// A format chunk of 16 bytes, and data after 44 bytes: the form that every reader of WAV files supports.
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

    #[test]
    fn a_record_larger_than_the_memory_is_refused_with_its_size() {
        let limit = MemoryLimit {
            gigabytes: 1.0,
            given: false,
        };
        assert_eq!(allocate_records(1000, 2, limit).map(|records| records.len()), Ok(2));
        let said = allocate_records(200_000_000, 2, limit).map_err(|fault| (fault.to_string(), fault.remedy()));
        let Err((said, remedy)) = said else {
            panic!("not refused")
        };
        assert!(said.contains("200000000 samples") && said.contains("3.2 GB"), "{said}");
        assert!(said.contains("1.0 GB") && remedy.contains("cut"), "{said} {remedy}");
        // More than any machine has, if the system does not report the free memory.
        let open = MemoryLimit {
            gigabytes: f64::INFINITY,
            given: false,
        };
        assert!(allocate_records(usize::MAX, 1, open).is_err());
    }

    /// A file of this many bytes that begins with a header and ends with a tail; all bytes between them are zero.
    struct Sparse {
        head: Vec<u8>,
        tail: Vec<u8>,
        length: u64,
        at: u64,
    }

    impl Read for Sparse {
        fn read(&mut self, bytes: &mut [u8]) -> io::Result<usize> {
            let count = bytes.len().min((self.length - self.at) as usize);
            bytes[..count].fill(0);
            let tail = self.length - self.tail.len() as u64;
            for (from, part) in [(0, &self.head), (tail, &self.tail)] {
                for (place, value) in (from..).zip(part) {
                    if (self.at..self.at + count as u64).contains(&place) {
                        bytes[(place - self.at) as usize] = *value;
                    }
                }
            }
            self.at += count as u64;
            Ok(count)
        }
    }

    impl Seek for Sparse {
        fn seek(&mut self, to: io::SeekFrom) -> io::Result<u64> {
            if let io::SeekFrom::Start(at) = to {
                self.at = at.min(self.length);
            }
            Ok(self.at)
        }
    }

    /// RF64: 1 100 000 frames of 2048 channels of 16 bits, 4.5 GB in total; one channel takes 9 MB.
    #[test]
    fn a_recording_beyond_four_gigabytes_is_read() {
        const CHANNELS: u16 = 2048;
        let frames: u64 = 1_100_000;
        let content = 2 * u64::from(CHANNELS) * frames;
        let ds64: Vec<u8> = [0, content, frames].iter().flat_map(|x| x.to_le_bytes()).collect();
        let mut head = [
            &b"RF64\xff\xff\xff\xffWAVEds64"[..],
            &28_u32.to_le_bytes(),
            &ds64,
            &[0; 4],
        ]
        .concat();
        head.extend(
            [
                &b"fmt "[..],
                &16_u32.to_le_bytes(),
                &1_u16.to_le_bytes(),
                &CHANNELS.to_le_bytes(),
            ]
            .concat(),
        );
        head.extend([48_000_u32.to_le_bytes(), [0; 4]].concat());
        head.extend([(2 * CHANNELS).to_le_bytes(), 16_u16.to_le_bytes()].concat());
        head.extend(b"data\xff\xff\xff\xff");
        let length = head.len() as u64 + content;
        assert!(length > 4_300_000_000);
        let file = Sparse {
            head,
            tail: 0x4000_i16.to_le_bytes().to_vec(),
            length,
            at: 0,
        };
        let tracks = decode(file, length, &[&Selector::Channel(2048)]);
        let Ok([track]) = tracks.as_deref() else {
            panic!("not read")
        };
        let [rest @ .., last] = track.samples.as_slice() else {
            panic!("empty")
        };
        assert_eq!(
            (track.samples.len() as u64, *last),
            (frames, f64::from(0x4000) / largest(16))
        );
        assert!(rest.iter().all(|sample| *sample == 0.0));
    }
}
