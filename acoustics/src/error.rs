use thiserror::Error;

use crate::bem::error::BemError;
use crate::checks::{InputError, ReceiverError};
use crate::jets::error::ExhaustError;
use crate::muffler::error::MufflerError;
use crate::radiation::error::RadiationError;
use crate::radiation::fluid_loading::FluidLoadingError;
use crate::signals::error::LevelsError;
use crate::signals::fourier::FourierError;
use crate::signals::interpolation::error::SamplingError;
use crate::signals::loudness::error::LoudnessError;

/// Any error of this crate; each module has its own.
#[derive(Debug, Error)]
pub enum AcousticsError {
    /// An invalid argument.
    #[error(transparent)]
    Input(#[from] InputError),
    /// From computing the sound pressure at a point.
    #[error(transparent)]
    Receiver(#[from] ReceiverError),
    /// From a Fourier transform.
    #[error(transparent)]
    Fourier(#[from] FourierError),
    /// From a spectrum or its signals.
    #[error(transparent)]
    Levels(#[from] LevelsError),
    /// From computing loudness.
    #[error(transparent)]
    Loudness(#[from] LoudnessError),
    /// From sampling a quantity over frequency.
    #[error(transparent)]
    Sampling(#[from] SamplingError),
    /// From a radiation operator.
    #[error(transparent)]
    Radiation(#[from] RadiationError),
    /// From the boundary element method.
    #[error(transparent)]
    Bem(#[from] BemError),
    /// From computing fluid-loaded modes.
    #[error(transparent)]
    FluidLoading(#[from] FluidLoadingError),
    /// From computing the noise of an opening.
    #[error(transparent)]
    Exhaust(#[from] ExhaustError),
    /// From a muffler.
    #[error(transparent)]
    Muffler(#[from] MufflerError),
    /// The mesh does not have the requested patch or quadrature rule.
    #[error(transparent)]
    Mesh(#[from] nailnoise_meshes::MeshError),
}

impl AcousticsError {
    /// Whether the remedy is to change the design rather than the program.
    pub fn is_of_the_design(&self) -> bool {
        match self {
            Self::Input(cause)
            | Self::Receiver(ReceiverError::Input(cause))
            | Self::Fourier(FourierError::Input(cause))
            | Self::Levels(LevelsError::Input(cause))
            | Self::Loudness(LoudnessError::Input(cause))
            | Self::Radiation(RadiationError::Input(cause))
            | Self::Bem(BemError::Input(cause))
            | Self::FluidLoading(FluidLoadingError::Input(cause))
            | Self::Exhaust(ExhaustError::Input(cause))
            | Self::Muffler(MufflerError::Input(cause)) => matches!(cause, InputError::OutsideRange { .. }),
            Self::Receiver(ReceiverError::BelowFloor { .. }) | Self::Radiation(RadiationError::SandBox { .. }) => true,
            Self::Exhaust(_) | Self::Muffler(_) => true,
            _ => false,
        }
    }
}
