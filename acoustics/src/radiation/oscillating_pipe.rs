//! A pipe on a rigid body, carried along by its motion.

use std::f64::consts::PI;
use std::sync::LazyLock;

use nailnoise_meshes::gauss_legendre;
use nalgebra::{Complex, DMatrix};

use super::compact::sphere_efficiency;
use super::operator::ModalRadiation;
use super::resistance::Resistance;
use crate::air::Air;
use crate::checks::{InputError, positive};

/// Number of points over half of the directions; exact to 1e-9 for pipes of up to four wavelengths.
const POINTS: usize = 32;

/// Radiation of the wall of a pipe that moves as a rigid body along a line. The motion is divided into a part along the
/// axis of the pipe and a part across it. The two dipoles are at right angles, so their powers add.
///
/// ```text
/// E(f) = 2 |A/omega|^2 R                 R = s^2 R_along + (1 - s^2) R_across
///
/// R_across = rho0 c0 L^2/pi int_0^pi [sin(u)/u]^2/(sin t |H_1'(ka sin t)|^2) dt       u = (kL/2) cos t
/// R_along  = rho0 c0 (4 pi b^2/3) (kb)^4/(4 + (kb)^4)                                (4 pi/3) b^3 = V_wall
/// ```
///
/// Across: the mode n = 1 of a cylinder of the length L and the outer radius a, continued by a rigid baffle of the same
/// radius (M. C. Junger and D. Feit, Sound, Structures, and Their Interaction, 2nd ed. 1986, sec. 6.8: the far field of
/// a cylinder by stationary phase; Morse and Ingard 1968, sec. 7.3, per length). H_1' is the derivative of the Hankel
/// function. The gas inside moves with the wall. At low frequencies this is the dipole of the mass that the pipe
/// displaces and of an equal added mass, R = rho0 c0 pi L^2 (ka)^4/3. Flow around the free ends lowers this added mass.
/// For a free cylinder 1.2 times as long as it is wide, the factor is 0.62 (DNV-RP-C205, 2010, table A-2), and the
/// level is 1.8 dB lower.
///
/// Along: the wall slides through the air, and the gas inside belongs to the surface at the closed end. Only the
/// annular ends push air. They are modelled as a sphere with the volume of the wall.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PipeWall {
    /// Length L \[m\].
    pub length: f64,
    /// Outer radius a \[m\].
    pub outer_radius: f64,
    /// Thickness of the wall \[m\].
    pub thickness: f64,
    /// Cosine s of the angle between the axis of the pipe and the line of motion \[-\].
    pub alignment: f64,
}

/// Radiation resistance of a [`PipeWall`] in air: an operator with a single mode, the motion of the pipe.
#[derive(Debug, Clone)]
pub struct OscillatingPipe {
    wall: PipeWall,
    air: Air,
    patches: [String; 1],
}

impl OscillatingPipe {
    /// The operator of a pipe; `name` is the name of its sound.
    ///
    /// # Errors
    /// If a dimension is not positive, the wall is thicker than the radius, or the cosine is outside -1 to 1.
    pub fn new(name: impl Into<String>, wall: PipeWall, air: &Air) -> Result<Self, InputError> {
        positive("length of the pipe [m]", wall.length)?;
        positive("outer radius of the pipe [m]", wall.outer_radius)?;
        positive("thickness of the pipe's wall [m]", wall.thickness)?;
        for (what, value, low, high) in [
            (
                "thickness of the pipe's wall [m]",
                wall.thickness,
                0.0,
                wall.outer_radius,
            ),
            ("cosine of the pipe's direction", wall.alignment, -1.0, 1.0),
        ] {
            if !(value >= low && value <= high) {
                return Err(InputError::OutsideRange { what, value, low, high });
            }
        }
        Ok(Self {
            wall,
            air: *air,
            patches: [name.into()],
        })
    }

    /// R at the frequency `hz` \[N s/m\].
    fn resistance_at(&self, hz: f64) -> f64 {
        let PipeWall { length, alignment, .. } = self.wall;
        let k = 2.0 * PI * hz / self.air.sound_speed;
        let ka = k * self.wall.outer_radius;
        let of_direction = |&(cosine, weight): &(f64, f64)| {
            let (u, sine) = (0.5 * k * length * cosine, (1.0 - cosine * cosine).sqrt());
            let diffraction = if u.abs() < 1e-4 { 1.0 } else { u.sin() / u };
            // dt = d(cos t)/sin t
            weight * diffraction * diffraction / (sine * sine * hankel_slope_squared(ka * sine))
        };
        let impedance = self.air.impedance();
        let across = impedance * length * length / PI * DIRECTIONS.iter().map(of_direction).sum::<f64>();
        let b = (0.75 * self.wall.volume() / PI).cbrt();
        let along = impedance * 4.0 * PI * b * b / 3.0 * sphere_efficiency(self.wall.volume(), &self.air, hz);
        alignment * alignment * along + (1.0 - alignment * alignment) * across
    }

    /// Power radiated per squared acceleration, R/omega^2, at each frequency.
    fn power_per_squared_acceleration<'a>(&'a self, frequency: &'a [f64]) -> impl Iterator<Item = f64> + 'a {
        let of = |&hz: &f64| self.resistance_at(hz.max(LOWEST)) / (2.0 * PI * hz.max(LOWEST)).powi(2);
        frequency.iter().map(of)
    }
}

impl PipeWall {
    /// Volume of the wall \[m3\].
    pub fn volume(&self) -> f64 {
        let inner = self.outer_radius - self.thickness;
        PI * (self.outer_radius.powi(2) - inner * inner) * self.length
    }
}

/// Lowest frequency at which R/omega^2, which vanishes at 0, is evaluated \[Hz\].
const LOWEST: f64 = 1e-2;

/// Cosines from 0 to 1 with the weights of the integral from -1 to 1.
static DIRECTIONS: LazyLock<Vec<(f64, f64)>> = LazyLock::new(|| {
    let half = |(x, weight): (f64, f64)| (0.5 * (1.0 + x), weight);
    gauss_legendre(POINTS).into_iter().map(half).collect()
});

/// |H_1'(x)|^2 = (J_0 - J_1/x)^2 + (N_0 - N_1/x)^2.
fn hankel_slope_squared(x: f64) -> f64 {
    let slope = |zero: f64, one: f64| zero - one / x;
    slope(libm::j0(x), libm::j1(x)).powi(2) + slope(libm::y0(x), libm::y1(x)).powi(2)
}

impl ModalRadiation for OscillatingPipe {
    fn method(&self) -> &str {
        "oscillating pipe"
    }

    fn modes(&self) -> usize {
        1
    }

    fn patches(&self) -> &[String] {
        &self.patches
    }

    fn highest_hz(&self) -> f64 {
        f64::INFINITY
    }

    fn resistance(&self, hz: f64) -> Resistance {
        Resistance {
            real: DMatrix::from_element(1, 1, self.resistance_at(hz)),
            imaginary: None,
        }
    }

    fn energy_forms(&self, frequency: &[f64], accelerations: &DMatrix<Complex<f64>>) -> DMatrix<f64> {
        let forms = self.power_per_squared_acceleration(frequency).zip(accelerations.iter());
        DMatrix::from_iterator(1, frequency.len(), forms.map(|(r, a)| r * a.norm_sqr()))
    }

    fn root_signals(&self, frequency: &[f64], accelerations: &DMatrix<Complex<f64>>) -> DMatrix<Complex<f64>> {
        let signals = self.power_per_squared_acceleration(frequency).zip(accelerations.iter());
        DMatrix::from_iterator(1, frequency.len(), signals.map(|(r, a)| a * r.sqrt()))
    }
}
