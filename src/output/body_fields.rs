//! `modes.csv` and `fields/*`: the moving bodies, for ParaView.

use nailnoise_dynamics::network::EventTime;
use nailnoise_meshes::vtu::{Frames, Grid};
use serde::Serialize;

use super::film::Fields;
use super::{Output, fields, modes, shot};
use crate::error::Error;
use crate::stages::cycle::ShotRecord;
use crate::stages::spectra::{BodyInMotion, MovingBody};
use crate::stages::{Code, Postcard, Progress, Stage, Stored, code};

/// Table of the modes of the bodies.
pub(super) const MODES: Output = Output::of_bodies("modes.csv");

/// Vibration of the bodies, with films on request.
pub(super) const FIELDS: Output = Output::of_bodies("fields/*");

/// Files of the bodies in a shot: `modes.csv`, and `fields/*` for ParaView, with films on request.
///
/// # Errors
/// The errors of the bodies' response.
fn made(moving: &[BodyInMotion], events: &[EventTime], films: bool, slow_motion: u32) -> Result<Fields, Error> {
    let mut made = Fields::default();
    made.text("modes.csv", modes::modes(moving)?);
    for driven in moving {
        made.show(Frames::of(&Grid::of_surface(&driven.body.surface))?);
        fields::add(&mut made, driven, films);
        if films {
            shot::add(&mut made, driven, events, slow_motion)?;
        }
    }
    Ok(made)
}

/// Makes the files of the moving bodies: their modes, and their vibration for ParaView.
#[derive(Serialize)]
pub struct BodyFields {
    /// The bodies.
    pub moving: Vec<MovingBody>,
    /// The cycle, whose events the films show.
    pub cycle: Stored<ShotRecord>,
    /// Whether the files include films of the shot and series over the bands.
    pub films: bool,
    /// How many times slower than the shot the film at uniform steps plays.
    pub slow_motion: u32,
}

impl Stage for BodyFields {
    type Output = Fields;
    type Error = Error;
    type Codec = Postcard;
    const NAME: &'static str = "fields of the bodies";
    const CODE: Code = code!(
        dynamics,
        meshes,
        fem,
        acoustics,
        stages_apart,
        stages_bodies,
        stages_intervals,
        stages_microphones,
        stages_radiation,
        stages_response,
        stages_sensors,
        stages_sound,
        stages_sound_fields,
        stages_spectra,
        output,
        stages_cycle
    );

    fn compute(&self, _: &Progress) -> Result<Fields, Error> {
        let moving: Vec<BodyInMotion> = self.moving.iter().map(MovingBody::get).collect::<Result<_, _>>()?;
        made(&moving, &self.cycle.get()?.events, self.films, self.slow_motion)
    }
}
