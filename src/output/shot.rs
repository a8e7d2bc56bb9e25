//! The shot as films for ParaView: velocity of each body's surface at instants around the events, and its motion at
//! uniform steps.

use nailnoise_dynamics::network::EventTime;
use nailnoise_fem::vibration::{ModalResponse, Motion};
use nailnoise_meshes::vtu::Array;
use nalgebra::DMatrix;
use rayon::prelude::*;

use super::film::Fields;
use crate::error::Error;
use crate::stages::spectra::BodyInMotion;

/// Instants shown after each event \[s\]: immediately after it, and while the waves travel through the body.
const AROUND: [f64; 3] = [5e-5, 3e-4, 1e-3];

/// Number of surface rows whose velocities are computed together.
const ROWS: usize = 512;

/// Number of frames of the film at uniform steps.
const FRAMES: usize = 120;

/// The film after the last event \[s\], while the vibration fades.
const FADING: f64 = 0.01;

/// Adds `BODY-shot.pvd` and one `.vtu` per instant: the velocity vector \[m/s\] at every point of the surface. Adds
/// `BODY-film.pvd` and `BODY-film.vtkhdf` with displacement \[m\] and velocity at uniform steps from the first event
/// on. Their times are those of the shot multiplied by `slow_motion`, so that ParaView in real time plays the film
/// slower by this factor.
pub(super) fn add(
    fields: &mut Fields,
    driven: &BodyInMotion,
    events: &[EventTime],
    slow_motion: u32,
) -> Result<(), Error> {
    let step = driven.vibration.response.step;
    let around = instants(events, &driven.vibration.response);
    let velocities = of_surface(driven, &around, Motion::Velocity)?;
    let frames = around.iter().zip(velocities).enumerate();
    let frames =
        frames.map(|(frame, (sample, velocity))| (*sample as f64 * step, format!("{frame:03}"), vec![velocity]));
    fields.series(&format!("{}-shot", driven.body.name), frames.collect());
    let uniform = uniform(events, &driven.vibration.response);
    let displacements = of_surface(driven, &uniform, Motion::Displacement)?;
    let velocities = of_surface(driven, &uniform, Motion::Velocity)?;
    let start = uniform.first().copied().unwrap_or_default();
    let frames = uniform
        .iter()
        .zip(displacements.into_iter().zip(velocities))
        .enumerate();
    let frames = frames.map(|(frame, (sample, (displacement, velocity)))| {
        let time = (*sample - start) as f64 * step * f64::from(slow_motion);
        (time, format!("{frame:03}"), vec![displacement, velocity])
    });
    let name = format!("{}-film", driven.body.name);
    fields.film(&name, &driven.body.surface, frames.collect());
    Ok(())
}

/// A vector of the motion at every point of the surface, for each of these samples.
fn of_surface(driven: &BodyInMotion, samples: &[usize], motion: Motion) -> Result<Vec<Array>, Error> {
    let (response, skin) = (&*driven.vibration.response, &driven.body.skin);
    let mut amplitudes = response.at(driven.index, samples, motion)?;
    if let Some(coordinates) = &driven.vibration.coordinates[driven.index] {
        amplitudes = coordinates * amplitudes;
    }
    let amplitudes = amplitudes.map(|own| own as f32);
    let rows = skin.nrows();
    let starts: Vec<usize> = (0..rows).step_by(ROWS).collect();
    let parts: Vec<DMatrix<f32>> = starts
        .into_par_iter()
        .map(|first| skin.rows(first, ROWS.min(rows - first)) * &amplitudes)
        .collect();
    let name = match motion {
        Motion::Displacement => "displacement [m]",
        Motion::Velocity => "velocity [m/s]",
        Motion::Acceleration => "acceleration [m/s2]",
    };
    let frame = |frame: usize| {
        let mut values = Vec::with_capacity(rows);
        parts.iter().for_each(|part| values.extend(part.column(frame).iter()));
        Array::new(name, 3, &values)
    };
    Ok((0..samples.len()).into_par_iter().map(frame).collect())
}

/// At most [`FRAMES`] equidistant samples, from the first event until the vibration fades after the last.
fn uniform(events: &[EventTime], response: &ModalResponse) -> Vec<usize> {
    let times = || events.iter().filter_map(|event| event.time);
    let (first, last) = (
        times().fold(f64::INFINITY, f64::min),
        times().fold(0.0, f64::max) + FADING,
    );
    let sample = |time: f64| (time.max(0.0) / response.step) as usize;
    let end = sample(last).min(response.samples() - 1);
    let start = sample(if first.is_finite() { first } else { 0.0 }).min(end);
    let stride = (end - start).div_ceil(FRAMES - 1).max(1);
    (start..=end).step_by(stride).collect()
}

/// Samples of the response around the events, ascending and without repetition.
fn instants(events: &[EventTime], response: &ModalResponse) -> Vec<usize> {
    let last = response.samples() - 1;
    let mut samples: Vec<usize> = events
        .iter()
        .filter_map(|event| event.time)
        .flat_map(|event| AROUND.map(|offset| ((event + offset) / response.step).round()))
        .filter(|&sample| sample >= 0.0 && sample <= last as f64)
        .map(|sample| sample as usize)
        .collect();
    samples.sort_unstable();
    samples.dedup();
    samples
}
