use super::{Directions, image};
use crate::air::Air;
use crate::checks::{ReceiverError, positive};
use crate::error::AcousticsError;
use crate::signals::SourceSpectrum;
use crate::signals::fourier::{Transform, TransformSettings};
use nalgebra::{Complex, Point3, Vector3};
use std::f64::consts::PI;

/// Pressure at a point per unit acceleration of a rigid sphere along `axis`, with its image in a rigid floor at height
/// `floor` if there is one \[Pa per m/s²\].
///
/// ```text
/// p = rho0 A a^3 cos(theta) (1 + jkr) e^{-jk(r - a)} / (r^2 (2 + 2 jka - (ka)^2))
/// ```
///
/// The exact field in free space (Morse and Ingard 1968, sec. 7.2), whose power is that of
/// [`crate::radiation::rigid_body_energy`]. The image moves as the mirror image of the sphere; scattering between the
/// two is neglected.
///
/// `volume` is that of the sphere \[m³\]; `axis` may have any positive length.
///
/// # Errors
/// If the volume is not positive, the axis has no length, or the point is inside the sphere or below the floor.
pub fn oscillating_sphere_pressure(
    hz: f64,
    volume: f64,
    centre: Point3<f64>,
    axis: Vector3<f64>,
    place: Point3<f64>,
    floor: Option<f64>,
    air: &Air,
) -> Result<Complex<f64>, ReceiverError> {
    let a = (3.0 * positive("volume of the body [m3]", volume)? / (4.0 * PI)).cbrt();
    let axis = axis / positive("length of the axis of motion", axis.norm())?;
    let k = 2.0 * PI * hz / air.sound_speed;
    let denominator = Complex::new(2.0 - (k * a).powi(2), 2.0 * k * a);
    let of_sphere = |centre: Point3<f64>, axis: Vector3<f64>| {
        let way = place - centre;
        let r = way.norm();
        if r.is_nan() || r < a {
            return Err(ReceiverError::NearSurface {
                point: place.into(),
                distance: r,
                needed: a,
            });
        }
        let cosine = way.dot(&axis) / r;
        let wave = Complex::from_polar(air.density * a.powi(3) * cosine / (r * r), -k * (r - a));
        Ok(wave * Complex::new(1.0, k * r) / denominator)
    };
    let direct = of_sphere(centre, axis)?;
    let Some(floor) = floor else {
        return Ok(direct);
    };
    for z in [centre.z, place.z] {
        if z.is_nan() || z < floor {
            return Err(ReceiverError::BelowFloor { z, floor });
        }
    }
    Ok(direct + of_sphere(image(centre, floor), Vector3::new(axis.x, axis.y, -axis.z))?)
}

/// Distance in wavelengths at which the pressure of a sphere counts as far field: the near field adds a fraction
/// 1/(kr)² to its square.
const FAR: f64 = 1e3;

/// Number of rings of directions over which the far field is integrated: Gauss points, exact for the square of a cosine
/// from two rings upwards.
const RINGS: usize = 4;

/// The energy of [`crate::radiation::rigid_body_energy`], computed from the field instead of the surface's resistance:
/// the pressure far away in free space, integrated over all directions.
///
/// ```text
/// E(f) = 2 r^2 / (rho0 c0) int |p|^2 dOmega
/// ```
///
/// # Errors
/// Same as [`crate::radiation::rigid_body_energy`].
pub fn rigid_body_far_field(
    source: impl Into<String>,
    acceleration: &[f64],
    sample_interval: f64,
    volume: f64,
    air: &Air,
    settings: &TransformSettings,
) -> Result<SourceSpectrum, AcousticsError> {
    let transform = Transform::new(acceleration.len(), sample_interval, settings)?;
    let frequency = transform.frequencies();
    let directions = Directions::new(RINGS, 1, false);
    let mut density = Vec::with_capacity(frequency.len());
    for (&hz, motion) in frequency.iter().zip(transform.apply(acceleration)?) {
        let r = FAR * air.sound_speed / hz;
        let mut energy = 0.0;
        for (direction, solid_angle) in directions.vectors.iter().zip(&directions.weights) {
            let place = Point3::from(r * direction);
            let unit = oscillating_sphere_pressure(hz, volume, Point3::origin(), Vector3::z(), place, None, air)?;
            energy += 2.0 * r * r / air.impedance() * (unit * motion).norm_sqr() * solid_angle;
        }
        density.push(energy);
    }
    Ok(SourceSpectrum::new(
        source,
        "far field",
        frequency,
        density,
        settings.range_hz,
    )?)
}
