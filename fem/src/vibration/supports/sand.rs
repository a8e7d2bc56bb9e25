//! Sand as an elastic half-space below and around an embedded rectangular block.

use std::f64::consts::PI;

use thiserror::Error;

/// An input is outside the range of the formula used.
#[derive(Debug, Clone, PartialEq, Error)]
#[error("{what} is {value}, but {formula} holds for {range}")]
pub struct SandError {
    /// The quantity.
    pub what: &'static str,
    /// The value found.
    pub value: f64,
    /// The formula.
    pub formula: &'static str,
    /// Its range.
    pub range: &'static str,
}

fn within(
    ok: bool,
    what: &'static str,
    value: f64,
    formula: &'static str,
    range: &'static str,
) -> Result<(), SandError> {
    if ok && value.is_finite() {
        Ok(())
    } else {
        Err(SandError {
            what,
            value,
            formula,
            range,
        })
    }
}

/// Small-strain shear modulus \[Pa\] of clean sand of round grains, void ratio e, mean effective pressure p' \[Pa\]
/// (Hardin & Richart, 1963, J. Soil Mech. Found. Div. ASCE 89 SM1):
///
///   G0 = 6900 (2.17 - e)^2/(1 + e) sqrt(p')   with G0 and p' in kPa
///
/// # Errors
/// [`SandError`] outside 0.3 <= e <= 0.8 or p' <= 0.
pub fn sand_shear_modulus_round(void_ratio: f64, pressure: f64) -> Result<f64, SandError> {
    const FORMULA: &str = "Hardin & Richart's modulus of round-grained sand";
    within(
        (0.3..=0.8).contains(&void_ratio),
        "void ratio",
        void_ratio,
        FORMULA,
        "0.3 to 0.8",
    )?;
    within(
        pressure > 0.0,
        "effective pressure",
        pressure,
        FORMULA,
        "pressures above 0",
    )?;
    Ok(hardin_richart(6900.0, 2.17, void_ratio, pressure))
}

/// Small-strain shear modulus \[Pa\] of clean sand of angular grains (Hardin & Richart, 1963). For a void ratio e and a
/// mean effective pressure p' \[Pa\],
///
///   G0 = 3230 (2.97 - e)^2/(1 + e) sqrt(p')   with G0 and p' in kPa
///
/// # Errors
/// [`SandError`] outside 0.6 <= e <= 1.3 or p' <= 0.
pub fn sand_shear_modulus_angular(void_ratio: f64, pressure: f64) -> Result<f64, SandError> {
    const FORMULA: &str = "Hardin & Richart's modulus of angular-grained sand";
    within(
        (0.6..=1.3).contains(&void_ratio),
        "void ratio",
        void_ratio,
        FORMULA,
        "0.6 to 1.3",
    )?;
    within(
        pressure > 0.0,
        "effective pressure",
        pressure,
        FORMULA,
        "pressures above 0",
    )?;
    Ok(hardin_richart(3230.0, 2.97, void_ratio, pressure))
}

fn hardin_richart(factor: f64, limit: f64, e: f64, pressure: f64) -> f64 {
    let kilo = 1e3;
    factor * (limit - e).powi(2) / (1.0 + e) * (pressure / kilo).sqrt() * kilo
}

/// Sand as a homogeneous elastic half-space.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Sand {
    /// Small-strain shear modulus G \[Pa\].
    pub shear_modulus: f64,
    /// Density rho [kg/m3].
    pub density: f64,
    /// Poisson's ratio nu \[1\].
    pub poisson: f64,
}

impl Sand {
    /// Sand with physical constants.
    ///
    /// # Errors
    /// [`SandError`] unless G > 0, rho > 0 and 0 <= nu < 0.5.
    pub fn new(shear_modulus: f64, density: f64, poisson: f64) -> Result<Self, SandError> {
        const FORMULA: &str = "an elastic half-space";
        within(
            shear_modulus > 0.0,
            "shear modulus",
            shear_modulus,
            FORMULA,
            "moduli above 0",
        )?;
        within(density > 0.0, "density", density, FORMULA, "densities above 0")?;
        within(
            (0.0..0.5).contains(&poisson),
            "Poisson's ratio",
            poisson,
            FORMULA,
            "0 <= nu < 0.5",
        )?;
        Ok(Self {
            shear_modulus,
            density,
            poisson,
        })
    }

    /// Shear wave speed V_s = sqrt(G/rho) [m/s].
    pub fn shear_speed(&self) -> f64 {
        (self.shear_modulus / self.density).sqrt()
    }

    /// Lysmer's analogue velocity V_La = 3.4 V_s/(pi (1 - nu)) [m/s] (Gazetas, 1991, Foundation Engineering Handbook,
    /// ch. 15): the apparent speed of the compression-extension waves that a vibrating footing radiates downwards.
    fn lysmer_speed(&self) -> f64 {
        3.4 * self.shear_speed() / (PI * (1.0 - self.poisson))
    }

    /// Radiation dashpot per area for motion normal to a face, c'' = rho V_La [Pa s/m].
    pub fn normal_dashpot(&self) -> f64 {
        self.density * self.lysmer_speed()
    }

    /// Radiation dashpot per area for motion along a face, rho V_s [Pa s/m].
    pub fn shear_dashpot(&self) -> f64 {
        self.density * self.shear_speed()
    }
}

/// A rigid rectangular base of 2L x 2B with L >= B; x runs along 2L.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RectangularBase {
    half_length: f64,
    half_width: f64,
}

/// Static stiffnesses of a rigid base on a half-space.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FoundationStiffness {
    /// Vertical K_z [N/m].
    pub z: f64,
    /// Along the length K_x [N/m].
    pub x: f64,
    /// Along the width K_y [N/m].
    pub y: f64,
    /// Rocking about the x axis (the long one) K_rx [N m].
    pub rocking_x: f64,
    /// Rocking about the y axis K_ry [N m].
    pub rocking_y: f64,
    /// Torsion about the vertical K_t [N m].
    pub torsion: f64,
}

impl RectangularBase {
    /// Base of full length 2L and full width 2B \[m\].
    ///
    /// # Errors
    /// [`SandError`] unless 2L >= 2B > 0.
    pub fn new(length: f64, width: f64) -> Result<Self, SandError> {
        const FORMULA: &str = "a rectangular base";
        within(width > 0.0, "width", width, FORMULA, "widths above 0")?;
        within(
            length >= width,
            "length",
            length,
            FORMULA,
            "lengths not below the width; exchange the two",
        )?;
        Ok(Self {
            half_length: 0.5 * length,
            half_width: 0.5 * width,
        })
    }

    /// Area 2L 2B \[m2\].
    pub fn area(&self) -> f64 {
        4.0 * self.half_length * self.half_width
    }

    /// Radius a = sqrt(A/pi) of the circle of the same area \[m\].
    pub fn equivalent_radius(&self) -> f64 {
        (self.area() / PI).sqrt()
    }

    /// Static stiffnesses on the surface of a half-space (Pais & Kausel, 1988, Soil Dyn. Earthq. Eng. 7, table 2;
    /// the same as in Gazetas, 1991, to a few per cent):
    ///
    ///   K_z  = G B/(1 - nu) [3.1 (L/B)^0.75 + 1.6]
    ///   K_x  = G B/(2 - nu) [6.8 (L/B)^0.65 + 2.4]
    ///   K_y  = G B/(2 - nu) [6.8 (L/B)^0.65 + 0.8 L/B + 1.6]
    ///   K_rx = G B^3/(1 - nu) [3.2 L/B + 0.8]
    ///   K_ry = G B^3/(1 - nu) [3.73 (L/B)^2.4 + 0.27]
    ///   K_t  = G B^3 [4.25 (L/B)^2.45 + 4.06]
    pub fn stiffness(&self, sand: &Sand) -> FoundationStiffness {
        let (g, nu) = (sand.shear_modulus, sand.poisson);
        let (l, b) = (self.half_length, self.half_width);
        let ratio = l / b;
        let b3 = b.powi(3);
        FoundationStiffness {
            z: g * b / (1.0 - nu) * (3.1 * ratio.powf(0.75) + 1.6),
            x: g * b / (2.0 - nu) * (6.8 * ratio.powf(0.65) + 2.4),
            y: g * b / (2.0 - nu) * (6.8 * ratio.powf(0.65) + 0.8 * ratio + 1.6),
            rocking_x: g * b3 / (1.0 - nu) * (3.2 * ratio + 0.8),
            rocking_y: g * b3 / (1.0 - nu) * (3.73 * ratio.powf(2.4) + 0.27),
            torsion: g * b3 * (4.25 * ratio.powf(2.45) + 4.06),
        }
    }

    /// Vertical bedding modulus k'' = K_z/(2L 2B) [Pa/m], uniform over the base. A rocking base then has a stiffness
    /// k'' I that is below K_rx and K_ry, because a half-space is stiffer towards the edges.
    pub fn normal_bedding(&self, sand: &Sand) -> f64 {
        self.stiffness(sand).z / self.area()
    }

    /// Shear bedding moduli of the base along x and y, K_x/(2L 2B) and K_y/(2L 2B) [Pa/m].
    pub fn shear_bedding(&self, sand: &Sand) -> (f64, f64) {
        let k = self.stiffness(sand);
        (k.x / self.area(), k.y / self.area())
    }
}
