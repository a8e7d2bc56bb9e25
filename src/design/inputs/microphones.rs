//! Inputs of the microphones: their positions, the reflecting plane, the room, and the sphere with the volume of the
//! tool.

use nailnoise_acoustics::radiation::sound::Iso3744Box;
use nailnoise_acoustics::radiation::sound_fields::Cuts;
use nalgebra::Point3;

use super::air;
use super::assembly::tool_volume;
use crate::design::Design;
use crate::error::Error;
use crate::model::supports;
use crate::stages::cycle::Engine;
use crate::stages::microphones::{MicrophoneArray, Room, ToolSphere};

/// The microphones of a design.
///
/// # Errors
/// If the state of the air is impossible.
pub(crate) fn array(design: &Design) -> Result<MicrophoneArray, Error> {
    Ok(MicrophoneArray {
        air: air(design)?,
        foot: foot(design),
        reflecting_plane: reflecting_plane(design),
        centre_height: centre_height(design),
        ear: ear(design),
        range_hz: [design.analysis.range_low, design.analysis.range_high],
    })
}

/// Positions of the microphones, followed by that of the operator's ear, in the coordinates of the bodies \[m\].
pub(crate) fn positions(design: &Design) -> Vec<Point3<f64>> {
    let mut all = Iso3744Box::around(centre_height(design)).positions_around(foot(design).into());
    all.push(ear(design).into());
    all
}

/// Area of the measurement surface \[m2\].
pub(crate) fn area(design: &Design) -> f64 {
    Iso3744Box::around(centre_height(design)).area()
}

/// The operator's ear \[m\].
fn ear(design: &Design) -> [f64; 3] {
    let acoustics = &design.acoustics;
    let [x, y, z] = on_axis(design, acoustics.ear_height);
    [x + acoustics.ear_along, y + acoustics.ear_across, z]
}

/// Point where the driving axis meets the plane of the measurement surface \[m\].
fn foot(design: &Design) -> [f64; 3] {
    let [x, y, _] = on_axis(design, 0.0);
    [x, y, measurement_plane(design)]
}

/// Height of the device's centre above the plane of the measurement surface \[m\]. The centre is half the tool's height
/// above the workpiece.
fn centre_height(design: &Design) -> f64 {
    let [_, _, centre] = on_axis(design, 0.5 * tool_height(design));
    centre - measurement_plane(design)
}

/// Height of the base plane of the measurement surface \[m\]: the reflecting plane, or the floor under a sandbox.
fn measurement_plane(design: &Design) -> f64 {
    supports::of(design).measurement_plane()
}

/// The room of a design.
pub(crate) fn room(design: &Design) -> Room {
    Room {
        absorption: design.acoustics.room_absorption,
        background_level: design.acoustics.background_level,
    }
}

/// Sphere with the volume of the tool.
pub(crate) fn tool_sphere(design: &Design, engine: &Engine) -> ToolSphere {
    ToolSphere {
        centre: on_axis(design, 0.5 * tool_height(design)),
        volume: tool_volume(design, engine),
    }
}

/// Planes on which the sound field is shown.
pub(crate) fn cuts(design: &Design) -> Cuts {
    Cuts {
        axis: [design.nail.offset_along, design.nail.offset_across],
        low: reflecting_plane(design),
        top: design.workpiece.thickness,
    }
}

/// Centre of the workpiece \[m\].
pub(crate) fn workpiece_centre(design: &Design) -> [f64; 3] {
    [0.0, 0.0, 0.5 * design.workpiece.thickness]
}

/// Point on the driving axis at `height` above the workpiece \[m\].
pub(crate) fn on_axis(design: &Design, height: f64) -> [f64; 3] {
    let nail = &design.nail;
    [
        nail.offset_along,
        nail.offset_across,
        design.workpiece.thickness + height,
    ]
}

/// Height of the tool above the workpiece \[m\].
pub(crate) fn tool_height(design: &Design) -> f64 {
    design.body.nose_height + design.body.barrel_height + design.body.cap_height
}

/// Height of the reflecting plane above the workpiece's underside \[m\].
pub(crate) fn reflecting_plane(design: &Design) -> f64 {
    supports::of(design).reflecting_plane()
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]

    use super::*;
    use crate::design::SandboxPlane;

    /// The specification gives these areas for a device whose centre is 0.1725 m above the sand.
    #[test]
    fn the_floor_under_the_sandbox_makes_the_measurement_surface_larger() {
        let path = concat!(env!("CARGO_MANIFEST_DIR"), "/designs/n80cb-as-tested-sandbox.toml");
        let area = |plane: SandboxPlane| {
            let mut design = Design::load(path).unwrap();
            design.support.sand.measurement_plane = plane;
            assert!((0.5 * tool_height(&design) - 0.1725).abs() < 1e-12);
            let microphones = array(&design).unwrap();
            // All microphones stay above the sand, which reflects in both cases.
            assert_eq!(microphones.reflecting_plane, design.workpiece.thickness);
            assert!(
                microphones
                    .positions()
                    .iter()
                    .all(|p| p.z > design.workpiece.thickness + 0.3)
            );
            Iso3744Box::around(microphones.centre_height).area()
        };
        let [sand, floor] = [SandboxPlane::Sand, SandboxPlane::Floor].map(area);
        assert!(
            (sand - 13.38).abs() < 1e-9 && (floor - 16.58).abs() < 1e-9,
            "{sand} {floor}"
        );
        assert!((10.0 * (floor / sand).log10() - 0.931).abs() < 5e-4);
    }
}
