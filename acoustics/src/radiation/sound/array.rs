use crate::checks::{InputError, positive};
use nalgebra::{Point3, Vector3};

/// The box of ISO 3744 around a device, with the nine microphones that EN 12549 places on it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Iso3744Box {
    /// Half side lengths a and b, and height c above the reflecting plane \[m\].
    pub sides: [f64; 3],
}

/// Distance between measurement surface and device, a = b = c - h \[m\] (EN 12549).
const DISTANCE: f64 = 1.0;

/// The positions in units of a, b and c.
const POSITIONS: [[f64; 3]; 9] = [
    [1.0, 0.0, 0.5],
    [0.0, 1.0, 0.5],
    [-1.0, 0.0, 0.5],
    [0.0, -1.0, 0.5],
    [1.0, 1.0, 1.0],
    [-1.0, 1.0, 1.0],
    [-1.0, -1.0, 1.0],
    [1.0, -1.0, 1.0],
    [0.0, 0.0, 1.0],
];

impl Iso3744Box {
    /// The box around a device whose centre is `height` \[m\] above the reflecting plane: a = b = 1 m, c = h + 1 m (EN
    /// 12549).
    pub fn around(height: f64) -> Self {
        Self {
            sides: [DISTANCE, DISTANCE, DISTANCE + height],
        }
    }

    /// The microphones relative to the base of the device's axis on the reflecting plane \[m\].
    pub fn positions(&self) -> [Vector3<f64>; 9] {
        let [a, b, c] = self.sides;
        POSITIONS.map(|[x, y, z]| Vector3::new(a * x, b * y, c * z))
    }

    /// Microphone positions around an axis with its base at `foot` \[m\].
    pub fn positions_around(&self, foot: Point3<f64>) -> Vec<Point3<f64>> {
        self.positions().iter().map(|offset| foot + offset).collect()
    }

    /// S = 4 (ab + bc + ca) \[m²\].
    pub fn area(&self) -> f64 {
        let [a, b, c] = self.sides;
        4.0 * (a * b + b * c + c * a)
    }
}

/// Level difference below which the background correction is invalid, and that above which it is zero \[dB\] (ISO
/// 3744).
const BACKGROUND: [f64; 2] = [6.0, 15.0];

/// Background correction K1 \[dB\] for a level of source and background together that is `difference` \[dB\] above the
/// level of the background. It is 0 above 15 dB, and `None` below 6 dB, where the measurement is invalid.
///
/// ```text
/// K1 = -10 lg(1 - 10^(-0.1 dL))
/// ```
///
/// ISO 3744:2010, 8.2.3.
pub fn background_correction(difference: f64) -> Option<f64> {
    if difference > BACKGROUND[1] {
        return Some(0.0);
    }
    (difference >= BACKGROUND[0]).then(|| -10.0 * (1.0 - 10f64.powf(-0.1 * difference)).log10())
}

/// Environmental correction K2 \[dB\] for a measurement surface of `area` \[m²\] in a room with equivalent absorption
/// area `absorption` \[m²\].
///
/// ```text
/// K2 = 10 lg(1 + 4 S / A)
/// ```
///
/// ISO 3744:2010, A.3.
///
/// # Errors
/// If an area is not positive.
pub fn environmental_correction(area: f64, absorption: f64) -> Result<f64, InputError> {
    let ratio = positive("measurement surface [m2]", area)? / positive("absorption area of the room [m2]", absorption)?;
    Ok(10.0 * (1.0 + 4.0 * ratio).log10())
}
