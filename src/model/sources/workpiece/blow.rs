//! Model of the blow of the driver on the fastener, and its share of the error of the method.

use nailnoise_acoustics::radiation::radiator::Uncertainty;
use nailnoise_acoustics::signals::{SourceSpectrum, Weighting};
use serde::Serialize;

use crate::model::supports::Support;
use crate::stages::radiation::OpenFaces;
use crate::stages::response::DrivenFastener;

/// Lower edge of the third octave at 6.3 kHz \[Hz\]. From this frequency on, waves in rod and fastener raise the force
/// on the wood.
const WAVES_HZ: f64 = 5_623.4;

/// Lower edges of the third octaves at 1 and 4 kHz \[Hz\]. Between them, the elastic force on the wood converges to
/// 0.6 dB with the number of elements.
const CONVERGENT_HZ: [f64; 2] = [891.3, 3_548.1];

/// Model of the blow on the fastener in the workpiece.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
pub(super) enum Blow {
    /// The driver strikes the fastener as a rigid body.
    Rigid(Mounting),
    /// Waves travel in driver and fastener.
    Elastic,
}

/// Mounting of the workpiece, which decides how many third octaves share its level and so how much the level depends on
/// the model of the blow.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
pub(super) enum Mounting {
    /// On an elastic structure.
    OnStructure,
    /// In sand, with its top flush.
    InSand,
    /// On a rigid floor, in a clamp or on springs: few modes of the block share the level.
    Alone,
}

/// Error of the force on the wood from a frequency on, up to the next such frequency.
struct ForceError {
    from_hz: f64,
    /// How much lower and how much higher the true force may be \[dB\].
    error_db: [f64; 2],
}

impl Mounting {
    /// The mounting on a support.
    fn of(support: &dyn Support) -> Self {
        if support.open_faces() == OpenFaces::FlushTop {
            Self::InSand
        } else if support.bodies().is_empty() {
            Self::Alone
        } else {
            Self::OnStructure
        }
    }

    /// Change of the level of the workpiece below the frequencies of the waves, elastic minus rigid blow, in 90 % of
    /// the shots of the N80CB \[dB\]. It is the widest of the designs with this mounting, without the clamp, whose
    /// change the waves explain (docs, "The blow as waves").
    fn change_db(self) -> [f64; 2] {
        match self {
            Self::OnStructure => [0.8, 0.5],
            Self::InSand => [1.8, 1.1],
            Self::Alone => [4.9, 2.7],
        }
    }
}

impl Blow {
    /// The model for the fastener of a shot on a support.
    pub(super) fn of(fastener: &DrivenFastener, support: &dyn Support) -> Self {
        if fastener.blows.is_empty() {
            Self::Rigid(Mounting::of(support))
        } else {
            Self::Elastic
        }
    }

    /// Errors by ascending frequency. Those of a rigid blow are its differences from the elastic one; those of the
    /// elastic blow are its differences between two numbers of elements (docs, "The blow as waves").
    fn errors(self) -> Vec<ForceError> {
        let error = |from_hz, error_db| ForceError { from_hz, error_db };
        let [converged, scattered] = CONVERGENT_HZ;
        match self {
            Self::Rigid(mounting) => vec![error(0.0, mounting.change_db()), error(WAVES_HZ, [1.0, 13.0])],
            Self::Elastic => vec![
                error(converged, [0.6; 2]),
                error(scattered, [2.7; 2]),
                error(WAVES_HZ, [10.0; 2]),
            ],
        }
    }

    /// Adds the error of the blow to the uncertainty of the level of `source`: in the A-weighted energy, each band of
    /// frequencies with its own error. A bound that is open stays open.
    pub(super) fn widened(self, uncertainty: Uncertainty, source: &SourceSpectrum) -> Uncertainty {
        let errors = self.errors();
        let ends = errors.iter().skip(1).map(|next| next.from_hz);
        let ends = ends.chain([f64::INFINITY]);
        let [low, high] = source.range_hz;
        let energies: Vec<f64> = errors
            .iter()
            .zip(ends)
            .map(|(error, end)| source.energy([error.from_hz.clamp(low, high), end.clamp(low, high)], Weighting::A))
            .collect();
        let whole = source.energy(source.range_hz, Weighting::A);
        let change_db = |factor: fn([f64; 2]) -> f64| {
            let changes = errors.iter().zip(&energies);
            let change: f64 = changes
                .map(|(error, energy)| energy * (factor(error.error_db) - 1.0))
                .sum();
            if whole > 0.0 {
                10.0 * (1.0 + change / whole).log10().abs()
            } else {
                0.0
            }
        };
        let minus = change_db(|[minus, _]| 10f64.powf(-0.1 * minus));
        let plus = change_db(|[_, plus]| 10f64.powf(0.1 * plus));
        Uncertainty {
            minus: uncertainty.minus.map(|own| own + minus),
            plus: uncertainty.plus.map(|own| own + plus),
            basis: format!("{}; {}, -{minus:.1} to +{plus:.1} dB", uncertainty.basis, self.basis()),
        }
    }

    /// The effect that its error covers, in the basis of an uncertainty.
    fn basis(self) -> &'static str {
        match self {
            Self::Rigid(_) => "rigid blow of the driver",
            Self::Elastic => "convergence of the waves of the blow",
        }
    }

    /// States the error of the force on the wood.
    pub(super) fn note(self) -> String {
        let errors: Vec<String> = self
            .errors()
            .iter()
            .map(|error| {
                let [minus, plus] = error.error_db;
                let change = format!("-{minus} to +{plus} dB");
                match error.from_hz {
                    0.0 => change,
                    hz => format!("{change} from {:.1} kHz on", 1e-3 * hz),
                }
            })
            .collect();
        let errors = errors.join(", ");
        match self {
            Self::Rigid(_) => format!(
                "the driver strikes the fastener as a rigid body; the error of the method includes the waves that an \
                 elastic blow would add ({errors}, from shots of the N80CB)"
            ),
            Self::Elastic => format!(
                "the waves of the blow on the fastener depend on the number of elements; the error of the method \
                 includes this ({errors})"
            ),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn tone(range_hz: [f64; 2], hz: f64) -> Result<SourceSpectrum, Box<dyn std::error::Error>> {
        let frequency = vec![hz - 1.0, hz, hz + 1.0];
        Ok(SourceSpectrum::new(
            "workpiece",
            "test",
            frequency,
            vec![0.0, 1.0, 0.0],
            range_hz,
        )?)
    }

    fn bounds(minus: Option<f64>, plus: Option<f64>) -> Uncertainty {
        Uncertainty {
            minus,
            plus,
            basis: "test".to_owned(),
        }
    }

    #[test]
    fn below_the_waves_the_errors_of_force_and_level_are_equal() -> Result<(), Box<dyn std::error::Error>> {
        let source = tone([50.0, 11_220.0], 1_000.0)?;
        let found = Blow::Rigid(Mounting::InSand).widened(bounds(Some(0.2), Some(0.3)), &source);
        let [minus, plus] = found.bounds().map(Option::unwrap_or_default);
        assert!((minus - 2.0).abs() < 1e-9 && (plus - 1.4).abs() < 1e-9, "{found:?}");
        Ok(())
    }

    #[test]
    fn waves_change_the_level_by_their_share_of_the_energy() -> Result<(), Box<dyn std::error::Error>> {
        let tones = [1_000.0, 8_000.0].map(|hz| tone([50.0, 11_220.0], hz));
        let [low, high] = tones;
        let source = SourceSpectrum::sum("workpiece", "test", &[low?, high?]);
        let high = source.energy([7_000.0, 9_000.0], Weighting::A) / source.energy(source.range_hz, Weighting::A);
        let expected = 10.0 * ((1.0 - high) * 10f64.powf(0.06) + high * 10.0).log10();
        let found = Blow::Elastic.widened(bounds(Some(0.0), Some(0.0)), &source);
        let plus = found.plus.unwrap_or_default();
        assert!((plus - expected).abs() < 1e-9, "{plus} {expected}");
        Ok(())
    }

    #[test]
    fn an_open_bound_stays_open_and_silence_has_no_error() -> Result<(), Box<dyn std::error::Error>> {
        let source = tone([50.0, 11_220.0], 1_000.0)?;
        let open = Blow::Rigid(Mounting::Alone).widened(bounds(None, Some(1.0)), &source);
        assert!(
            open.minus.is_none() && open.plus.is_some_and(|plus| plus > 1.0),
            "{open:?}"
        );
        let silent = SourceSpectrum::silent("workpiece", "test", [50.0, 11_220.0]);
        let same = Blow::Elastic.widened(bounds(Some(0.1), Some(0.2)), &silent);
        assert_eq!(same.bounds(), [Some(0.1), Some(0.2)]);
        Ok(())
    }
}
