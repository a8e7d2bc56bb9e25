//! A sampled radiation resistance in a file.

use super::{Sample, SampledRadiation};
use crate::error::AcousticsError;
use crate::radiation::archive::{Archive, ArchiveReader, ArchiveWriter};
use crate::radiation::interval::Interval;
use std::f64::consts::PI;

/// Samples and their roots, kept in single precision.
impl Archive for SampledRadiation {
    fn write(&self, to: &mut ArchiveWriter) {
        to.texts(std::slice::from_ref(&self.method));
        to.count(self.modes);
        to.texts(&self.patches);
        to.count(self.samples.len());
        for sample in &self.samples {
            to.numbers(&[sample.hz]);
            // R fits single precision; Q = R / omega² at high frequencies may not.
            let omega2 = (2.0 * PI * sample.hz).powi(2);
            sample
                .patches
                .iter()
                .for_each(|q| to.hermitian(&q.clone().scaled(omega2)));
        }
        to.count(self.roots.len());
        for (root, sample) in self.roots.iter().zip(&self.samples) {
            to.count(usize::from(root.is_some()));
            if let Some(root) = root {
                to.hermitian(&root.clone().scaled(2.0 * PI * sample.hz));
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
            let inverse = (2.0 * PI * hz).powi(-2);
            let mut of_patches = Vec::new();
            for _ in &patches {
                of_patches.push(from.hermitian(modes)?.scaled(inverse));
            }
            samples.push(Sample {
                hz,
                patches: of_patches,
            });
        }
        let mut roots = Vec::new();
        for sample in 0..from.count()? {
            let hz = samples.get(sample).map(|sample: &Sample| sample.hz);
            let inverse = (2.0 * PI * hz.ok_or_else(|| from.damaged())?).recip();
            roots.push(match from.count()? {
                0 => None,
                _ => Some(from.hermitian(modes)?.scaled(inverse)),
            });
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
