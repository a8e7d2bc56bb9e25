//! Detects whether bytes differ from those written.
//!
//! The checksum detects damage. XXH3-128 (Collet) is as good for this as a cryptographic digest and many times faster:
//! it misses one altered file in 2^128. Inputs of stages and designs, which must never be confused, are digested with
//! SHA-256.

use std::io::{self, Read, Write};

use twox_hash::XxHash3_128;

/// XXH3-128, little-endian.
pub type Checksum = [u8; 16];

/// Checksum of a byte slice.
pub fn checksum(bytes: &[u8]) -> Checksum {
    XxHash3_128::oneshot(bytes).to_le_bytes()
}

/// Passes bytes through to a reader or writer and sums them.
pub(super) struct Summed<W> {
    to: W,
    sum: XxHash3_128,
}

impl<W> Summed<W> {
    pub(super) fn over(to: W) -> Self {
        let sum = XxHash3_128::new();
        Self { to, sum }
    }

    /// Checksum of all bytes so far.
    pub(super) fn checksum(&self) -> Checksum {
        self.sum.finish_128().to_le_bytes()
    }

    /// The underlying reader or writer.
    pub(super) fn inner(&self) -> &W {
        &self.to
    }
}

impl<R: Read> Read for Summed<R> {
    fn read(&mut self, bytes: &mut [u8]) -> io::Result<usize> {
        let read = self.to.read(bytes)?;
        self.sum.write(&bytes[..read]);
        Ok(read)
    }
}

impl<W: Write> Write for Summed<W> {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        let written = self.to.write(bytes)?;
        self.sum.write(&bytes[..written]);
        Ok(written)
    }

    fn flush(&mut self) -> io::Result<()> {
        self.to.flush()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Test vectors of the reference implementation (xxhash 0.8, seed 0).
    #[test]
    fn the_checksum_is_xxh3_of_128_bits() {
        assert_eq!(
            u128::from_le_bytes(checksum(b"")),
            0x99aa_06d3_0147_98d8_6001_c324_468d_497f
        );
    }

    #[test]
    fn in_parts_and_at_once_is_the_same() -> io::Result<()> {
        let bytes: Vec<u8> = (0..5000u32).map(|i| (i * i % 251) as u8).collect();
        for length in [0, 1, 16, 240, 241, 1024, 5000] {
            let mut copy = Vec::new();
            let mut summed = Summed::over(&mut copy);
            for part in bytes[..length].chunks(97) {
                summed.write_all(part)?;
            }
            assert_eq!(summed.checksum(), checksum(&bytes[..length]));
            assert_eq!(copy, bytes[..length]);
            let mut read = Summed::over(&bytes[..length]);
            io::copy(&mut read, &mut io::sink())?;
            assert_eq!(read.checksum(), checksum(&bytes[..length]));
        }
        Ok(())
    }
}
