//! Radiation of a surface flush with a plane: a block in sand. Operator, power, pressure at microphones, and field.

mod kernel;
mod plane;
mod radiator;
mod rayleigh;
mod sand;
mod sound;
mod sound_field;
mod sources;
mod spherical_waves;
mod surface_resistances;

pub use plane::SoundAbovePlane;
pub use radiator::FlushRadiator;
pub use rayleigh::Rayleigh;
pub use sand::{AbsorbingSand, MovingSand, miki_admittance};
pub use sound::FlushSound;
pub use sound_field::{band_sound_above_plane, flush_field};
pub use surface_resistances::SurfaceResistances;
