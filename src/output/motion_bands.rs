//! `motion.csv`: motion of the elastic bodies in one-third-octave bands.

use super::table::table;
use super::{Output, RunView};
use crate::error::Error;

/// Motion in bands.
pub(super) const BANDS: Output = Output::of_run("motion.csv", rows).only_if(exist);

const HEADER: [&str; 5] = [
    "body",
    "band [Hz]",
    "kinetic energy over time [J s]",
    "RMS normal velocity [m/s]",
    "RMS normal acceleration [m/s2]",
];

fn exist(of: &RunView<'_>) -> bool {
    !of.run.result.motion.is_empty()
}

/// One row per body and band; both RMS values are means over the area of the outer surface and over 1 s.
fn rows(of: &RunView<'_>) -> Result<Vec<u8>, Error> {
    let rows = of.run.result.motion.iter().flat_map(|body| {
        body.bands.iter().map(|band| {
            let [kinetic, velocity, acceleration] = [
                band.kinetic_energy_j_s,
                band.rms_velocity_m_s,
                band.rms_acceleration_m_s2,
            ]
            .map(|value| format!("{value:.4e}"));
            [
                body.body.clone(),
                format!("{:.0}", band.hz),
                kinetic,
                velocity,
                acceleration,
            ]
        })
    });
    table(HEADER, rows)
}
