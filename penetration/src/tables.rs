//! Published coefficients, qualities of fit, woods and nails.

use serde::Serialize;

use super::{PenetrationLaw, REFERENCE_SPEED};

/// Published speed term C8 v_ref^2 of the solid-wood law (Eq. 4.59). The source prints the law with v_ref already
/// included (C-23) \[m2/s2\].
const SPEED_TERM: f64 = -122.91;

/// Published slenderness term C9 of the solid-wood law (Eq. 4.59) \[-\].
const SLENDERNESS_TERM: f64 = -1.15;

/// Published quality of a fit, in units of sqrt(Pi1) unless a ratio.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct FitQuality {
    /// Coefficient of determination \[-\].
    pub r_squared: f64,
    /// Standard error of the estimate.
    pub standard_error: f64,
    /// Mean absolute error.
    pub mean_absolute_error: f64,
}

impl PenetrationLaw {
    /// The coefficients C0..C9 of Eq. 2.2 (Tables 2-6 and 2-8, Eq. 4.59); C8 \[-\] multiplies Pi3. Dropped terms are
    /// zero.
    pub fn coefficients(self) -> [f64; 10] {
        use PenetrationLaw as P;
        match self {
            P::Smooth => [
                0.029, 1.818, -12.253, 46.080, -98.877, 121.013, -78.382, 20.800, 3.910e6, -0.332,
            ],
            P::Annular => [
                0.040, 2.008, -11.942, 40.305, -79.911, 92.291, -57.107, 14.556, -1.3378e6, -0.351,
            ],
            P::Helical => [
                0.078, 1.953, -12.262, 42.953, -83.472, 90.517, -51.420, 11.939, -2.795e5, -1.198,
            ],
            P::General => [
                0.014, 1.924, -12.171, 43.241, -87.738, 101.653, -62.521, 15.813, 5.547e5, 0.067,
            ],
            P::Reduced1 => [
                0.018, 1.924, -12.164, 43.219, -87.706, 101.641, -62.533, 15.822, 5.813e5, 0.0,
            ],
            P::Reduced2 => [
                0.019, 1.920, -12.139, 43.154, -87.666, 101.738, -62.698, 15.893, 0.0, 0.0,
            ],
            P::Reduced3 => [0.023, 1.670, -8.679, 23.753, -34.117, 24.553, -6.986, 0.0, 0.0, 0.0],
            P::Reduced4 => [0.030, 1.358, -5.516, 11.034, -10.237, 3.554, 0.0, 0.0, 0.0, 0.0],
            P::Reduced5 => [0.043, 0.939, -2.552, 3.112, -1.332, 0.0, 0.0, 0.0, 0.0, 0.0],
            P::Reduced6 => [0.062, 0.559, -0.834, 0.442, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0],
            P::SolidWood => [
                0.085,
                2.038,
                -12.95,
                46.49,
                -94.97,
                110.18,
                -67.56,
                16.99,
                SPEED_TERM / (REFERENCE_SPEED * REFERENCE_SPEED),
                SLENDERNESS_TERM,
            ],
        }
    }

    /// Published quality of the fit (Tables 2-7, 2-9, A I-3).
    pub fn fit_quality(self) -> FitQuality {
        use PenetrationLaw as P;
        let (percent, standard_error, mean_absolute_error) = match self {
            P::Smooth => (94.88, 0.00899, 0.00675),
            P::Annular => (90.74, 0.01255, 0.00975),
            P::Helical => (94.10, 0.01097, 0.00841),
            P::General => (85.76, 0.01628, 0.01334),
            P::Reduced1 => (85.75, 0.01629, 0.01336),
            P::Reduced2 => (85.65, 0.01634, 0.01332),
            P::Reduced3 => (85.56, 0.01639, 0.01338),
            P::Reduced4 => (85.30, 0.01654, 0.01349),
            P::Reduced5 => (84.25, 0.01712, 0.01392),
            P::Reduced6 => (81.95, 0.01832, 0.01494),
            P::SolidWood => (91.84, 0.01408, 0.01075),
        };
        FitQuality {
            r_squared: percent / 100.0,
            standard_error,
            mean_absolute_error,
        }
    }
}

/// A wood of the published tests.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct WoodKind {
    /// Name.
    pub name: &'static str,
    /// H_M, hardness modulus \[N/m\].
    pub hardness_modulus: f64,
    /// rho, density \[kg/m3\].
    pub density: f64,
    /// Moisture content \[-\].
    pub moisture: f64,
}

const fn wood(name: &'static str, hardness_modulus: f64, density: f64, moisture: f64) -> WoodKind {
    WoodKind {
        name,
        hardness_modulus,
        density,
        moisture,
    }
}

/// The woods of the published tests (Tables 2-2, 4-2, A I-1).
pub const WOODS: [WoodKind; 6] = [
    wood("Douglas-fir plywood", 560.11e3, 543.59, 0.057),
    wood("Canadian softwood plywood", 371.77e3, 449.71, 0.056),
    wood("poplar plywood", 478.96e3, 464.00, 0.056),
    wood("Douglas-fir", 567.47e3, 450.0, 0.056),
    wood("pine", 383.64e3, 429.46, 0.056),
    wood("poplar", 375.35e3, 413.04, 0.056),
];

/// The shape of a nail's shank.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Shank {
    /// Smooth.
    Smooth,
    /// Annular rings.
    Annular,
    /// Helical thread.
    Helical,
}

/// A nail size of the published tests.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct NailSize {
    /// Penny size.
    pub name: &'static str,
    /// NL, length \[m\].
    pub length: f64,
    /// D of smooth and annular shanks \[m\].
    pub diameter: f64,
    /// D of helical shanks \[m\], if the size was tested with one.
    pub helical_diameter: Option<f64>,
}

impl NailSize {
    /// Nominal diameter for a shank \[m\], if the size exists with that shank.
    pub fn shank_diameter(&self, shank: Shank) -> Option<f64> {
        match shank {
            Shank::Smooth | Shank::Annular => Some(self.diameter),
            Shank::Helical => self.helical_diameter,
        }
    }
}

const fn nail(name: &'static str, length: f64, diameter: f64, helical_diameter: Option<f64>) -> NailSize {
    NailSize {
        name,
        length,
        diameter,
        helical_diameter,
    }
}

/// The nail sizes of the published tests.
pub const NAILS: [NailSize; 7] = [
    nail("3d", 31.75e-3, 2.032e-3, None),
    nail("4d", 38.10e-3, 2.794e-3, None),
    nail("6d", 50.80e-3, 3.048e-3, None),
    nail("8d", 63.50e-3, 3.302e-3, Some(3.048e-3)),
    nail("10d", 76.20e-3, 3.810e-3, Some(3.556e-3)),
    nail("12d", 82.55e-3, 3.810e-3, Some(3.556e-3)),
    nail("16d", 88.90e-3, 4.064e-3, Some(3.810e-3)),
];
