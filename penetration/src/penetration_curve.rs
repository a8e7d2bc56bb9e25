//! Penetration laws for one nail: force, work and uncertainty of the fit as functions of depth.
//!
//! ```text
//! F_r = H_M NL max(0, root(x))^2,  x = y/NL        W(y) = integral of F_r from 0 to y
//! ```
//! Nili Ahmadabadi (2016), Eq. 2.2 and 4.59. The standard error of the estimate SEE applies to the root, so F_r lies
//! between H_M NL (root - SEE)^2 and H_M NL (root + SEE)^2.

use thiserror::Error;

use super::RangeError;
use super::{FitQuality, ForceTable, NAILS, NailSize, PenetrationLaw, Shank, Specimen, WoodKind};

/// Number of Simpson intervals over a nail's length: the error is below 1e-9 of the work.
const INTERVALS: u32 = 2000;

/// Why a penetration law cannot be evaluated.
#[derive(Debug, Clone, PartialEq, Error)]
#[non_exhaustive]
pub enum CurveError {
    /// The nail size was not tested with a helical shank.
    #[error("the law \"{law}\" is of helical shanks, and the nail {nail} was not tested with one")]
    NoSuchShank {
        /// The law.
        law: &'static str,
        /// The nail size.
        nail: &'static str,
        /// The tested sizes.
        known: String,
    },
    /// A depth or speed is outside the range of the laws.
    #[error("the law \"{law}\" of a {nail} nail in {wood} cannot be evaluated")]
    Outside {
        /// The law.
        law: &'static str,
        /// The wood.
        wood: &'static str,
        /// The nail.
        nail: &'static str,
        /// The value outside the range.
        source: RangeError,
    },
    /// The constant force is negative or not finite.
    #[error("a constant resistance of {force} N is no force of the wood")]
    Force {
        /// The force \[N\].
        force: f64,
    },
    /// A depth beyond the nail's length, or beyond the points of a table.
    #[error("depth {depth} m is beyond the range of \"{law}\" with a {nail} nail, 0 to {most} m")]
    TooDeep {
        /// The law.
        law: String,
        /// The nail.
        nail: &'static str,
        /// The depth \[m\].
        depth: f64,
        /// The largest valid depth \[m\].
        most: f64,
    },
}

impl CurveError {
    /// How to fix it.
    pub fn remedy(&self) -> String {
        match self {
            Self::NoSuchShank { known, .. } => format!("choose from: {known}"),
            Self::Outside { .. } => {
                "speeds are 3.33e-4 to 8.4e-3 m/s (20 to 500 mm/min), depths 0 to the nail's length".to_owned()
            }
            Self::Force { .. } => "give a finite force, 0 or more".to_owned(),
            Self::TooDeep { .. } => {
                "ask for smaller depths, or for a table add points up to the nail's length".to_owned()
            }
        }
    }
}

/// The law behind a curve.
#[derive(Debug, Clone)]
pub enum CurveLaw {
    /// A published law, with its wood and its variables.
    Published {
        /// The law.
        law: PenetrationLaw,
        /// The wood.
        wood: &'static WoodKind,
        /// Nail and wood.
        specimen: Specimen,
        /// v, penetration speed \[m/s\].
        speed: f64,
    },
    /// The same force at every depth \[N\].
    Constant(f64),
    /// A force given by points over depth.
    Tabulated(ForceTable),
}

/// A penetration law for one nail: force, work and uncertainty as functions of depth.
#[derive(Debug, Clone)]
pub struct PenetrationCurve {
    /// Name of the law.
    pub name: String,
    /// The law.
    pub law: CurveLaw,
    /// The nail.
    pub nail: &'static NailSize,
}

impl PenetrationCurve {
    /// Creates the curve of `law` for `nail` in `wood` at penetration speed `speed` \[m/s\].
    ///
    /// # Errors
    /// [`CurveError::NoSuchShank`] if the size was not tested with the law's shank; [`CurveError::Outside`] if the
    /// speed is not quasi-static.
    pub fn new(
        law: PenetrationLaw,
        wood: &'static WoodKind,
        nail: &'static NailSize,
        speed: f64,
    ) -> Result<Self, CurveError> {
        let shank = match law {
            PenetrationLaw::Helical => Shank::Helical,
            PenetrationLaw::Annular => Shank::Annular,
            _ => Shank::Smooth,
        };
        let diameter = nail.shank_diameter(shank).ok_or_else(|| {
            let tested: Vec<&str> = NAILS
                .iter()
                .filter(|nail| nail.shank_diameter(shank).is_some())
                .map(|nail| nail.name)
                .collect();
            CurveError::NoSuchShank {
                law: law.as_str(),
                nail: nail.name,
                known: tested.join(", "),
            }
        })?;
        let specimen = Specimen {
            length: nail.length,
            diameter,
            hardness_modulus: wood.hardness_modulus,
            density: wood.density,
        };
        let curve = Self {
            name: law.as_str().to_owned(),
            law: CurveLaw::Published {
                law,
                wood,
                specimen,
                speed,
            },
            nail,
        };
        curve.force(0.0).map(|_| curve)
    }

    /// Creates a curve with the same `force` \[N\] at every depth of `nail`.
    ///
    /// # Errors
    /// [`CurveError::Force`] if the force is negative or not finite.
    pub fn constant(force: f64, nail: &'static NailSize) -> Result<Self, CurveError> {
        if !(force.is_finite() && force >= 0.0) {
            return Err(CurveError::Force { force });
        }
        Ok(Self {
            name: format!("constant {force} N"),
            law: CurveLaw::Constant(force),
            nail,
        })
    }

    /// Creates a curve from `table`, called `name`, for `nail`.
    ///
    /// # Errors
    /// [`CurveError::TooDeep`] if the table ends before the nail does.
    pub fn tabulated(name: &str, table: ForceTable, nail: &'static NailSize) -> Result<Self, CurveError> {
        let curve = Self {
            name: name.to_owned(),
            law: CurveLaw::Tabulated(table),
            nail,
        };
        curve.force(nail.length).map(|_| curve)
    }

    /// The wood of a published law; none for the other laws.
    pub fn wood(&self) -> Option<&'static WoodKind> {
        match &self.law {
            CurveLaw::Published { wood, .. } => Some(wood),
            CurveLaw::Constant(_) | CurveLaw::Tabulated(_) => None,
        }
    }

    /// F_r, force \[N\] at `depth` \[m\]; zero at or above the surface.
    ///
    /// # Errors
    /// [`CurveError::Outside`] beyond the nail's length or at a speed that is not quasi-static; [`CurveError::TooDeep`]
    /// for unpublished laws.
    pub fn force(&self, depth: f64) -> Result<f64, CurveError> {
        let most = match &self.law {
            CurveLaw::Published {
                law,
                wood,
                specimen,
                speed,
            } => {
                return law
                    .force(specimen, depth, *speed)
                    .map_err(|source| CurveError::Outside {
                        law: law.as_str(),
                        wood: wood.name,
                        nail: self.nail.name,
                        source,
                    });
            }
            CurveLaw::Constant(_) => self.nail.length,
            CurveLaw::Tabulated(table) => self.nail.length.min(table.last_depth()),
        };
        if depth.is_nan() || depth > most * (1.0 + 1e-9) {
            return Err(CurveError::TooDeep {
                law: self.name.clone(),
                nail: self.nail.name,
                depth,
                most,
            });
        }
        Ok(match &self.law {
            CurveLaw::Tabulated(table) => table.force(depth),
            CurveLaw::Constant(force) if depth > 0.0 => *force,
            CurveLaw::Constant(_) | CurveLaw::Published { .. } => 0.0,
        })
    }

    /// The force at `depth` \[m\] with the root one standard error lower and higher \[N\]; none unless a published fit
    /// gives the error.
    ///
    /// # Errors
    /// Same as [`force`](Self::force).
    pub fn band(&self, depth: f64) -> Result<Option<[f64; 2]>, CurveError> {
        let force = self.force(depth)?;
        let CurveLaw::Published { law, specimen, .. } = &self.law else {
            return Ok(None);
        };
        let scale = specimen.hardness_modulus * specimen.length;
        let (root, error) = ((force / scale).sqrt(), law.fit_quality().standard_error);
        Ok(Some(
            [root - error, root + error].map(|root| scale * root.max(0.0).powi(2)),
        ))
    }

    /// W, work from the surface to `depth` \[J\].
    ///
    /// # Errors
    /// Same as [`force`](Self::force).
    pub fn work(&self, depth: f64) -> Result<f64, CurveError> {
        self.force(depth)?;
        let h = depth.max(0.0) / f64::from(INTERVALS);
        let mut sum = 0.0;
        for i in 0..=INTERVALS {
            let weight = if i == 0 || i == INTERVALS {
                1.0
            } else {
                f64::from(2 + 2 * (i % 2))
            };
            // The force is discontinuous at the surface, so the first point lies just below it.
            sum += weight * self.force((h * f64::from(i)).clamp(depth * 1e-12, depth))?;
        }
        Ok(sum * h / 3.0)
    }

    /// Published quality of the fit, in units of the root unless a ratio.
    pub fn quality(&self) -> Option<FitQuality> {
        match &self.law {
            CurveLaw::Published { law, .. } => Some(law.fit_quality()),
            CurveLaw::Constant(_) | CurveLaw::Tabulated(_) => None,
        }
    }

    /// Restrictions that limit the use of the law.
    pub fn notes(&self) -> Vec<String> {
        let CurveLaw::Published { law, wood, .. } = &self.law else {
            return Vec::new();
        };
        let name = law.as_str();
        let plywood = wood.name.contains("plywood");
        let mut notes = Vec::new();
        if (*law == PenetrationLaw::SolidWood) == plywood {
            let (fitted, kind) = if plywood {
                ("solid wood", "plywood")
            } else {
                ("plywood", "solid wood")
            };
            notes.push(format!(
                "the law {name} was fitted to {fitted}, and {} is {kind}",
                wood.name
            ));
        }
        if matches!(law, PenetrationLaw::Reduced3 | PenetrationLaw::Reduced5) {
            notes.push(format!(
                "the force of {name} dips before full depth: an artefact of the fit"
            ));
        }
        notes
    }
}
