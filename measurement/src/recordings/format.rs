//! The `fmt ` chunk of a WAV file, which describes the coding of samples.

use super::fault::Fault;

/// `WAVE_FORMAT_PCM`, `WAVE_FORMAT_IEEE_FLOAT`, `WAVE_FORMAT_EXTENSIBLE` (Microsoft, mmreg.h).
const PCM: u16 = 1;
const FLOAT: u16 = 3;
const EXTENSIBLE: u16 = 0xfffe;

/// The endings of the GUIDs for the above formats, for Microsoft and for ambisonic files.
const GUIDS: [[u8; 12]; 2] = [
    [0, 0, 0x10, 0, 0x80, 0, 0, 0xaa, 0, 0x38, 0x9b, 0x71],
    [0x21, 0x07, 0xd3, 0x11, 0x86, 0x44, 0xc8, 0xc1, 0xca, 0, 0, 0],
];

/// Other codings, which are compressed.
const OTHERS: [(u16, &str); 19] = [
    (0x02, "ADPCM of Microsoft"),
    (0x06, "A-law"),
    (0x07, "mu-law"),
    (0x11, "ADPCM of IMA"),
    (0x14, "ADPCM, G.723"),
    (0x16, "ADPCM of IMA"),
    (0x22, "TrueSpeech"),
    (0x31, "GSM 6.10"),
    (0x40, "ADPCM, G.721"),
    (0x45, "ADPCM, G.726"),
    (0x50, "MPEG layer 1 or 2"),
    (0x55, "MP3"),
    (0x64, "ADPCM, G.726"),
    (0x92, "AC-3"),
    (0xff, "AAC"),
    (0x161, "Windows Media Audio"),
    (0x162, "Windows Media Audio"),
    (0x2000, "AC-3"),
    (0xf1ac, "FLAC"),
];

/// How numbers are coded.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Coded {
    /// Integers with this many valid bits, which are the most significant ones of their container.
    Integer { bits: u32 },
    /// IEEE 754.
    Float,
}

/// How the samples of a file are coded.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Format {
    pub(super) channels: usize,
    /// Sampling rate \[Hz\].
    pub(super) rate: u32,
    /// Bytes of a sample.
    pub(super) container: usize,
    pub(super) coded: Coded,
}

impl Format {
    /// Number of bytes read from the chunk: those of the extensible format.
    pub(super) const LARGEST: usize = 40;

    /// Parses the chunk, which must have at least 14 bytes; anything after the fields of its format is ignored.
    pub(super) fn read(chunk: &[u8]) -> Result<Self, Fault> {
        let malformed = |problem: String| Fault::Format { problem };
        let short = |at: usize| u16::from_le_bytes([chunk[at], chunk[at + 1]]);
        if chunk.len() < 16 {
            let length = chunk.len();
            return Err(malformed(format!(
                "its chunk \"fmt \" has {length} bytes, at least 16 are needed"
            )));
        }
        let (channels, block, bits) = (usize::from(short(2)), usize::from(short(12)), u32::from(short(14)));
        let rate = u32::from_le_bytes([chunk[4], chunk[5], chunk[6], chunk[7]]);
        let (mut tag, mut valid) = (short(0), bits);
        if tag == EXTENSIBLE {
            let Some(guid) = chunk.get(24..40) else {
                return Err(malformed(
                    "its chunk \"fmt \" is extensible and too short for that".to_owned(),
                ));
            };
            valid = u32::from(short(18));
            tag = u16::from_le_bytes([guid[0], guid[1]]);
            let known = guid[2..4] == [0, 0] && GUIDS.iter().any(|end| guid[4..] == *end);
            if !known {
                let digits: String = guid.iter().map(|byte| format!("{byte:02x}")).collect();
                let coding = format!("of the unknown format {digits}");
                return Err(Fault::Coding { coding });
            }
        }
        if !matches!(tag, PCM | FLOAT) {
            let coding = OTHERS.iter().find(|(own, _)| *own == tag);
            let coding = coding.map_or_else(
                || format!("of the unknown format {tag}"),
                |(_, name)| format!("coded as {name}"),
            );
            return Err(Fault::Coding { coding });
        }
        if channels == 0 {
            return Err(malformed("its header states no channel".to_owned()));
        }
        // A plain 24-bit header may have blocks of 4 bytes per channel.
        let container = if block > 0 && block % channels == 0 {
            block / channels
        } else {
            bits.div_ceil(8) as usize
        };
        let capacity = 8 * container as u32;
        // Some programs write 0, or more than the container has.
        let valid = if (1..=capacity.min(bits.max(1))).contains(&valid) {
            valid
        } else {
            bits
        };
        let coded = match tag {
            PCM if (1..=8).contains(&container) && (2..=capacity).contains(&valid) => Coded::Integer { bits: valid },
            FLOAT if matches!((container, bits), (4, 32) | (8, 64)) => Coded::Float,
            _ => {
                let kind = if tag == PCM { "integer" } else { "float" };
                return Err(Fault::Width {
                    bits: bits as u16,
                    bytes: container,
                    kind,
                });
            }
        };
        Ok(Self {
            channels,
            rate,
            container,
            coded,
        })
    }

    /// A sample as a fraction of full scale; the largest integer maps to 1.
    pub(super) fn sample(&self, bytes: &[u8]) -> f64 {
        match (self.coded, bytes) {
            (Coded::Float, &[a, b, c, d]) => f64::from(f32::from_le_bytes([a, b, c, d])),
            (Coded::Float, _) => <[u8; 8]>::try_from(bytes).map_or(f64::NAN, f64::from_le_bytes),
            (Coded::Integer { bits }, _) => integer(bytes) as f64 / self.full(bits),
        }
    }

    /// The largest integer: all valid bits except the sign set, above the unused ones.
    fn full(&self, bits: u32) -> f64 {
        let unused = 8 * self.container as u32 - bits;
        (((1_i128 << (bits - 1)) - 1) << unused) as f64
    }

    /// Number of bits per sample that the header declares unused, if an offset by them is detectable: full bytes of an
    /// integer.
    fn unused(&self) -> Option<(u32, u32)> {
        let Coded::Integer { bits } = self.coded else {
            return None;
        };
        let unused = 8 * self.container as u32 - bits;
        (unused >= 8 && self.container >= 2).then_some((bits, unused))
    }
}

/// Which bits of their containers are used by the samples of a file.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct BitAlignment {
    /// Whether any sample uses one of the bits that the header declares unused.
    low: bool,
    /// Whether any sample needs more than the lowest valid bits.
    high: bool,
}

impl BitAlignment {
    /// Considers samples of all channels.
    pub(super) fn update(&mut self, format: &Format, data: &[u8]) {
        let Some((bits, unused)) = format.unused().filter(|_| !self.high) else {
            return;
        };
        let high = 1_i64 << (bits - 1);
        for sample in data.chunks_exact(format.container).map(integer) {
            self.low |= sample & ((1 << unused) - 1) != 0;
            self.high |= !(-high..high).contains(&sample);
        }
    }

    /// Rejects samples that use the bits declared unused and leave the highest ones empty. The program that wrote them
    /// put the valid bits at the wrong end, and they would be read with too low a level.
    pub(super) fn check(self, format: &Format) -> Result<(), Fault> {
        match format.unused() {
            Some((bits, _)) if self.low && !self.high => Err(Fault::RightAligned {
                bits,
                container: 8 * format.container,
            }),
            _ => Ok(()),
        }
    }
}

/// An integer with the least significant byte first; single-byte integers have an offset of 128.
fn integer(bytes: &[u8]) -> i64 {
    match bytes {
        [byte] => i64::from(*byte) - 128,
        _ => {
            let mut wide = [0; 8];
            wide[8 - bytes.len()..].copy_from_slice(bytes);
            i64::from_le_bytes(wide) >> (64 - 8 * bytes.len())
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn chunk(tag: u16, channels: u16, block: u16, bits: u16) -> Vec<u8> {
        let mut bytes = [tag.to_le_bytes(), channels.to_le_bytes()].concat();
        bytes.extend(48_000_u32.to_le_bytes());
        bytes.extend(0_u32.to_le_bytes());
        bytes.extend([block.to_le_bytes(), bits.to_le_bytes()].concat());
        bytes
    }

    fn extensible(block: u16, bits: u16, valid: u16, tag: u8) -> Vec<u8> {
        let mut bytes = chunk(EXTENSIBLE, 1, block, bits);
        bytes.extend([22_u16.to_le_bytes(), valid.to_le_bytes()].concat());
        bytes.extend(0_u32.to_le_bytes());
        bytes.extend([tag, 0, 0, 0]);
        bytes.extend(GUIDS[0]);
        bytes
    }

    /// A quarter of full scale, by the definition: the valid bits are the highest ones.
    #[test]
    fn valid_bits_are_the_highest_ones_of_their_container() {
        for (header, container, valid) in [
            (extensible(4, 32, 24, 1), 4, 24),
            (extensible(4, 32, 16, 1), 4, 16),
            (extensible(3, 24, 16, 1), 3, 16),
            (extensible(3, 24, 20, 1), 3, 20),
            (extensible(4, 32, 32, 1), 4, 32),
            (extensible(4, 32, 0, 1), 4, 32),
            (chunk(PCM, 1, 4, 24), 4, 24),
            (chunk(PCM, 1, 2, 12), 2, 12),
            (chunk(PCM, 1, 8, 64), 8, 64),
            (chunk(PCM, 1, 2, 16), 2, 16),
        ] {
            let format = Format::read(&header);
            let Ok(format) = format else { panic!("{format:?}") };
            let quarter = (1_i64 << (valid - 3)) << (8 * container - valid);
            let bytes = &quarter.to_le_bytes()[..container];
            let found = format.sample(bytes);
            assert!(
                (found - 0.25).abs() < 2f64.powi(-(valid as i32)),
                "{valid} in {container}: {found}"
            );
        }
    }

    #[test]
    fn a_byte_is_unsigned_and_wider_integers_are_signed() {
        assert_eq!([0, 128, 255].map(|byte: u8| integer(&[byte])), [-128, 0, 127]);
        assert_eq!(integer(&[0xff, 0xff, 0xff]), -1);
        assert_eq!(integer(&[0, 0, 0x80]), -(1 << 23));
        assert_eq!(integer(&i64::MIN.to_le_bytes()), i64::MIN);
    }

    #[test]
    fn samples_at_the_wrong_end_are_refused() {
        let format = Format::read(&extensible(4, 32, 24, 1));
        let Ok(format) = format else { panic!("{format:?}") };
        let file = |shift: u32| {
            [5_i32, -70_001, 8_000_000]
                .iter()
                .flat_map(|x| (x << shift).to_le_bytes())
                .collect::<Vec<u8>>()
        };
        let check = |shift: u32| {
            let mut bits = BitAlignment::default();
            // In two blocks, as a large file is read.
            file(shift).chunks(8).for_each(|block| bits.update(&format, block));
            bits.check(&format)
        };
        assert!(check(8).is_ok());
        assert!(check(0).is_err_and(|fault| fault.to_string().contains("24 valid bits in containers of 32")));
    }

    #[test]
    fn other_codings_are_named() {
        for (header, words) in [
            (chunk(6, 1, 1, 8), "A-law"),
            (chunk(7, 1, 1, 8), "mu-law"),
            (chunk(2, 1, 256, 4), "ADPCM"),
            (chunk(0x55, 1, 1, 0), "MP3"),
            (chunk(0x1234, 1, 1, 8), "4660"),
            (extensible(1, 8, 8, 7), "mu-law"),
            (chunk(FLOAT, 1, 2, 16), "16 bits"),
            (chunk(PCM, 1, 16, 128), "128 bits"),
        ] {
            let said = Format::read(&header).map_err(|fault| fault.to_string());
            assert!(
                said.as_ref().is_err_and(|said| said.contains(words)),
                "{words}: {said:?}"
            );
        }
        assert!(Format::read(&chunk(PCM, 0, 2, 16)).is_err());
        assert!(Format::read(&[1, 0, 1]).is_err());
    }
}
