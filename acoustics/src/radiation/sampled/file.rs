//! A sampled radiation resistance in a file.

use super::{Sample, SampledRadiation};
use crate::error::AcousticsError;
use crate::radiation::archive::{Archive, ArchiveReader, ArchiveWriter};
use crate::radiation::interval::Interval;
use crate::radiation::packed::Packed;

impl Archive for SampledRadiation {
    fn write(&self, to: &mut ArchiveWriter) {
        to.texts(std::slice::from_ref(&self.method));
        to.count(self.modes);
        to.texts(&self.patches);
        to.count(self.samples.len());
        for sample in &self.samples {
            to.numbers(&[sample.hz]);
            sample.patches.write(to);
        }
        to.count(self.roots.len());
        for root in &self.roots {
            to.count(usize::from(root.is_some()));
            if let Some(root) = root {
                root.write(to);
            }
        }
        to.count(self.intervals.len());
        for interval in &self.intervals {
            to.numbers(&[interval.low, interval.high]);
            to.count(interval.tried);
            to.count(interval.nodes.len());
            interval.nodes.iter().for_each(|node| to.count(*node));
        }
        to.numbers(&self.slopes);
        to.numbers(&[self.error]);
    }

    fn read(from: &mut ArchiveReader<'_>) -> Result<Self, AcousticsError> {
        let method = from.texts()?.pop().ok_or_else(|| from.damaged())?;
        let modes = from.count()?;
        let patches = from.texts()?;
        let mut samples = Vec::new();
        for _ in 0..from.count()? {
            let [hz] = from.numbers()?;
            let patches_of = Packed::read(from)?;
            if patches_of.modes() != modes || patches_of.matrices() != patches.len() {
                return Err(from.damaged());
            }
            samples.push(Sample {
                hz,
                patches: patches_of,
            });
        }
        let mut roots = Vec::new();
        for _ in 0..from.count()? {
            let root = match from.count()? {
                0 => None,
                _ => Some(Packed::read(from)?),
            };
            if root.as_ref().is_some_and(|r| r.modes() != modes || r.matrices() != 1) {
                return Err(from.damaged());
            }
            roots.push(root);
        }
        let mut intervals = Vec::new();
        for _ in 0..from.count()? {
            let [low, high] = from.numbers()?;
            let tried = from.count()?;
            let count = from.count()?;
            let nodes = (0..count).map(|_| from.count()).collect::<Result<Vec<_>, _>>()?;
            let known = nodes.iter().all(|n| *n < samples.len());
            let interval = Interval::kept(low, high, nodes, tried).filter(|_| known);
            intervals.push(interval.ok_or_else(|| from.damaged())?);
        }
        let mut slopes = Vec::new();
        for _ in 0..modes {
            let [slope] = from.numbers()?;
            slopes.push(slope);
        }
        let [error] = from.numbers()?;
        if intervals.is_empty() {
            return Err(from.damaged());
        }
        Ok(Self {
            method,
            modes,
            patches,
            intervals,
            samples,
            slopes,
            error,
            roots,
        })
    }
}
