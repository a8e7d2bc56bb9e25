//! The wall of a pipe that moves as a whole.

use std::f64::consts::PI;

use nailnoise_acoustics::Air;
use nailnoise_acoustics::radiation::{ModalRadiation, OscillatingPipe, PipeWall, sphere_efficiency};

const WALL: PipeWall = PipeWall {
    length: 0.12,
    outer_radius: 0.0445,
    thickness: 0.0055,
    alignment: 0.0,
};

fn resistance(wall: PipeWall, hz: f64) -> f64 {
    OscillatingPipe::new("pipe", wall, &Air::default())
        .unwrap()
        .resistance(hz)
        .real[(0, 0)]
}

fn frequency(ka: f64) -> f64 {
    ka * Air::default().sound_speed / (2.0 * PI * WALL.outer_radius)
}

/// Two values of |H_1'|^2 follow from tables: Abramowitz and Stegun, tables 9.1: J_0(1) = 0.7651976866,
/// J_1(1) = 0.4400505857, Y_0(1) = 0.0882569642, Y_1(1) = -0.7812128213.
const SLOPE_AT_1: f64 = (0.765_197_686_6 - 0.440_050_585_7) * (0.765_197_686_6 - 0.440_050_585_7)
    + (0.088_256_964_2 + 0.781_212_821_3) * (0.088_256_964_2 + 0.781_212_821_3);

#[test]
fn a_compact_pipe_across_its_axis_is_a_dipole_of_its_mass_and_an_equal_added_mass() {
    let ka: f64 = 0.01;
    let dipole = Air::default().impedance() * PI * WALL.length.powi(2) * ka.powi(4) / 3.0;
    let found = resistance(WALL, frequency(ka));
    assert!((found / dipole - 1.0).abs() < 1e-3, "{found} {dipole}");
}

#[test]
fn a_long_pipe_radiates_by_its_length_as_the_first_mode_of_a_cylinder() {
    // 2 rho0 c0 L/(k |H_1'(ka)|^2), less an end effect that does not grow with the length.
    let of = |length: f64| resistance(PipeWall { length, ..WALL }, frequency(1.0));
    let by_length = (of(0.6) - of(0.3)) / 0.3;
    let expected = 2.0 * Air::default().impedance() * WALL.outer_radius / SLOPE_AT_1;
    assert!((by_length / expected - 1.0).abs() < 0.02, "{by_length} {expected}");
}

#[test]
fn above_its_circumference_the_pipe_radiates_as_plane_waves() {
    let (hz, air) = (frequency(20.0), Air::default());
    let plane = air.impedance() * PI * WALL.outer_radius * WALL.length;
    assert!((resistance(WALL, hz) / plane - 1.0).abs() < 0.03);
}

#[test]
fn along_its_axis_only_the_wall_displaces_air() {
    let (air, hz) = (Air::default(), 800.0);
    let volume = PI * (0.0445f64.powi(2) - 0.039f64.powi(2)) * 0.12;
    let radius = (0.75 * volume / PI).cbrt();
    let sphere = air.impedance() * 4.0 * PI * radius * radius / 3.0 * sphere_efficiency(volume, &air, hz);
    let along = PipeWall {
        alignment: -1.0,
        ..WALL
    };
    assert!((resistance(along, hz) / sphere - 1.0).abs() < 1e-12);
    let slanted = PipeWall { alignment: 0.6, ..WALL };
    let sum = 0.36 * resistance(along, hz) + 0.64 * resistance(WALL, hz);
    assert!((resistance(slanted, hz) / sum - 1.0).abs() < 1e-12);
}

#[test]
fn impossible_pipes_are_refused() {
    for wall in [
        PipeWall { length: 0.0, ..WALL },
        PipeWall {
            thickness: 0.05,
            ..WALL
        },
        PipeWall { alignment: 1.1, ..WALL },
    ] {
        assert!(OscillatingPipe::new("pipe", wall, &Air::default()).is_err());
    }
}
