//! Radiation matrices as bytes, little-endian, for a cache.

use super::resistance::Resistance;
use crate::error::AcousticsError;
use nalgebra::{Complex, DMatrix};
use std::io::Read;

/// What can be kept in a file and read back exactly.
pub trait Archive: Sized {
    /// Appends itself.
    fn write(&self, to: &mut ArchiveWriter);

    /// Reads itself back.
    ///
    /// # Errors
    /// [`AcousticsError::Damaged`] when the bytes do not have this form.
    fn read(from: &mut ArchiveReader<'_>) -> Result<Self, AcousticsError>;

    /// All of it as bytes.
    fn to_bytes(&self) -> Vec<u8> {
        let mut to = ArchiveWriter::default();
        self.write(&mut to);
        to.0
    }

    /// What [`Archive::to_bytes`] wrote.
    ///
    /// # Errors
    /// [`AcousticsError::Damaged`] for any other bytes.
    fn from_bytes(bytes: &[u8]) -> Result<Self, AcousticsError> {
        let length = bytes.len();
        Self::from_reader(&mut { bytes }, length)
    }

    /// The same from `length` bytes that need not be in memory together.
    ///
    /// # Errors
    /// [`AcousticsError::Damaged`] for any other bytes, or where they end or fail before that.
    fn from_reader(from: &mut dyn Read, length: usize) -> Result<Self, AcousticsError> {
        let mut from = ArchiveReader {
            from,
            length,
            at: 0,
            taken: Vec::new(),
        };
        let result = Self::read(&mut from)?;
        if from.at == length {
            Ok(result)
        } else {
            Err(from.damaged())
        }
    }
}

/// Collects bytes.
#[derive(Debug, Default)]
pub struct ArchiveWriter(Vec<u8>);

impl ArchiveWriter {
    pub(crate) fn count(&mut self, n: usize) {
        self.0.extend((n as u64).to_le_bytes());
    }

    pub(crate) fn numbers(&mut self, values: &[f64]) {
        values.iter().for_each(|v| self.0.extend(v.to_le_bytes()));
    }

    pub(crate) fn texts(&mut self, texts: &[String]) {
        self.count(texts.len());
        for text in texts {
            self.count(text.len());
            self.0.extend(text.as_bytes());
        }
    }

    /// Numbers in single precision, with how many there are.
    pub(crate) fn singles(&mut self, values: &[f32]) {
        self.count(values.len());
        self.0.reserve(4 * values.len());
        values.iter().for_each(|value| self.0.extend(value.to_le_bytes()));
    }

    pub(crate) fn list<T: Archive>(&mut self, items: &[T]) {
        self.count(items.len());
        items.iter().for_each(|item| item.write(self));
    }

    /// The upper triangle of a Hermitian matrix in single precision: real part, then imaginary part if it has one.
    pub(crate) fn hermitian(&mut self, m: &Resistance) {
        self.count(m.real.nrows());
        self.count(usize::from(m.imaginary.is_some()));
        for part in std::iter::once(&m.real).chain(&m.imaginary) {
            for j in 0..part.ncols() {
                for i in 0..=j {
                    self.0.extend((part[(i, j)] as f32).to_le_bytes());
                }
            }
        }
    }
}

/// Takes bytes apart.
pub struct ArchiveReader<'a> {
    from: &'a mut dyn Read,
    /// Bytes in all, and how many are taken.
    length: usize,
    at: usize,
    /// The bytes taken last.
    taken: Vec<u8>,
}

/// Most bytes of long arrays in memory at once.
const PART: usize = 1 << 16;

impl ArchiveReader<'_> {
    pub(crate) fn damaged(&self) -> AcousticsError {
        AcousticsError::Damaged {
            at: self.at,
            length: self.length,
        }
    }

    /// Whether so many bytes are left.
    fn expect(&self, length: usize) -> Result<(), AcousticsError> {
        if length <= self.length - self.at {
            Ok(())
        } else {
            Err(self.damaged())
        }
    }

    fn take(&mut self, length: usize) -> Result<&[u8], AcousticsError> {
        self.expect(length)?;
        self.taken.resize(length, 0);
        if self.from.read_exact(&mut self.taken).is_err() {
            return Err(self.damaged());
        }
        self.at += length;
        Ok(&self.taken)
    }

    /// So many numbers of N bytes each, part by part.
    fn array<T, const N: usize>(
        &mut self,
        length: usize,
        number: impl Fn([u8; N]) -> T,
    ) -> Result<Vec<T>, AcousticsError> {
        let bytes = length.checked_mul(N).ok_or_else(|| self.damaged())?;
        self.expect(bytes)?;
        let mut values = Vec::with_capacity(length);
        while values.len() < length {
            let count = (length - values.len()).min(PART / N);
            let (part, _) = self.take(N * count)?.as_chunks::<N>();
            values.extend(part.iter().map(|bytes| number(*bytes)));
        }
        Ok(values)
    }

    pub(crate) fn count(&mut self) -> Result<usize, AcousticsError> {
        let mut bytes = [0; 8];
        bytes.copy_from_slice(self.take(8)?);
        let n = u64::from_le_bytes(bytes) as usize;
        // Everything counted takes a byte at least.
        if n <= self.length { Ok(n) } else { Err(self.damaged()) }
    }

    pub(crate) fn numbers<const N: usize>(&mut self) -> Result<[f64; N], AcousticsError> {
        let mut values = [0.0; N];
        for value in &mut values {
            let mut bytes = [0; 8];
            bytes.copy_from_slice(self.take(8)?);
            *value = f64::from_le_bytes(bytes);
        }
        Ok(values)
    }

    pub(crate) fn texts(&mut self) -> Result<Vec<String>, AcousticsError> {
        let n = self.count()?;
        let mut texts = Vec::new();
        for _ in 0..n {
            let length = self.count()?;
            let text = std::str::from_utf8(self.take(length)?).map(str::to_owned);
            texts.push(text.map_err(|_| self.damaged())?);
        }
        Ok(texts)
    }

    /// So many numbers in single precision.
    pub(crate) fn singles(&mut self, length: usize) -> Result<Vec<f32>, AcousticsError> {
        if self.count()? != length {
            return Err(self.damaged());
        }
        self.array(length, f32::from_le_bytes)
    }

    pub(crate) fn list<T: Archive>(&mut self) -> Result<Vec<T>, AcousticsError> {
        let n = self.count()?;
        (0..n).map(|_| T::read(self)).collect()
    }

    /// A Hermitian matrix of `n` rows.
    pub(crate) fn hermitian(&mut self, n: usize) -> Result<Resistance, AcousticsError> {
        if self.count()? != n {
            return Err(self.damaged());
        }
        let imaginary = self.count()? != 0;
        Ok(Resistance {
            real: self.triangle(n, 1.0)?,
            imaginary: imaginary.then(|| self.triangle(n, -1.0)).transpose()?,
        })
    }

    /// A matrix of `n` rows from its upper triangle; the lower one is that times `sign`.
    fn triangle(&mut self, n: usize, sign: f64) -> Result<DMatrix<f64>, AcousticsError> {
        let length = n.checked_mul(n + 1).and_then(|n| n.checked_mul(2));
        let length = length.ok_or_else(|| self.damaged())?;
        let mut values = self.take(length)?.chunks_exact(4);
        let mut m = DMatrix::zeros(n, n);
        for j in 0..n {
            for (i, bytes) in (0..=j).zip(&mut values) {
                let value = f64::from(f32::from_le_bytes([bytes[0], bytes[1], bytes[2], bytes[3]]));
                m[(j, i)] = sign * value;
                m[(i, j)] = value;
            }
        }
        Ok(m)
    }
}

impl<A: Archive, B: Archive> Archive for (A, B) {
    fn write(&self, to: &mut ArchiveWriter) {
        self.0.write(to);
        self.1.write(to);
    }

    fn read(from: &mut ArchiveReader<'_>) -> Result<Self, AcousticsError> {
        Ok((A::read(from)?, B::read(from)?))
    }
}

impl Archive for DMatrix<Complex<f64>> {
    fn write(&self, to: &mut ArchiveWriter) {
        self.map(|z| z.re).write(to);
        self.map(|z| z.im).write(to);
    }

    fn read(from: &mut ArchiveReader<'_>) -> Result<Self, AcousticsError> {
        let (re, im) = (DMatrix::<f64>::read(from)?, DMatrix::<f64>::read(from)?);
        if re.shape() == im.shape() {
            Ok(re.zip_map(&im, Complex::new))
        } else {
            Err(from.damaged())
        }
    }
}

impl Archive for DMatrix<f64> {
    fn write(&self, to: &mut ArchiveWriter) {
        to.count(self.nrows());
        to.count(self.ncols());
        to.numbers(self.as_slice());
    }

    fn read(from: &mut ArchiveReader<'_>) -> Result<Self, AcousticsError> {
        let (rows, columns) = (from.count()?, from.count()?);
        let length = rows.checked_mul(columns).ok_or_else(|| from.damaged())?;
        Ok(Self::from_vec(rows, columns, from.array(length, f64::from_le_bytes)?))
    }
}
