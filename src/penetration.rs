//! Penetration laws side by side, published and own: force and work of a nail in a wood, with what the fit is worth.
//!
//! ```text
//! F_r = H_M NL max(0, root(x))^2,  x = y/NL        W(y) = integral of F_r from 0 to y
//! ```
//! Nili Ahmadabadi (2016), Eq. 2.2 and 4.59; see [`nailnoise_dynamics::prf`] for the coefficients. The standard error of
//! the estimate belongs to the root, so that F_r lies between H_M NL (root - SEE)^2 and H_M NL (root + SEE)^2.

use std::path::{Path, PathBuf};

use miette::Diagnostic;
use nailnoise_dynamics::CycleError;
use nailnoise_dynamics::prf::{
    FitQuality, ForceTable, NAILS, NailSize, PenetrationLaw, Shank, Specimen, TableError, WOODS, WoodKind,
};
use thiserror::Error;

/// Intervals of Simpson's rule over a nail's length: its error is below 1e-9 of the work.
const INTERVALS: u32 = 2000;

/// Why laws cannot be compared.
#[derive(Debug, Clone, PartialEq, Error, Diagnostic)]
#[non_exhaustive]
pub enum PenetrationError {
    /// A law, wood or nail that is not among the published ones.
    #[error("there is no {what} \"{name}\" among the published ones")]
    #[diagnostic(help("{}choose from: {known}", nearest.map_or_else(String::new, |near| format!("is it \"{near}\"? "))))]
    Unknown {
        /// `law`, `wood` or `nail`.
        what: &'static str,
        /// The name given.
        name: String,
        /// The name most like it, if one is near.
        nearest: Option<&'static str>,
        /// All names.
        known: String,
    },
    /// A nail size that was not tested with a helical shank.
    #[error("the law \"{law}\" is of helical shanks, and the nail {nail} was not tested with one")]
    #[diagnostic(help("choose from: {known}"))]
    NoSuchShank {
        /// The law.
        law: &'static str,
        /// The nail size.
        nail: &'static str,
        /// The sizes tested.
        known: String,
    },
    /// A depth or speed outside the range of the laws.
    #[error("the law \"{law}\" of a {nail} nail in {wood} cannot be evaluated")]
    #[diagnostic(help("speeds are 3.33e-4 to 8.4e-3 m/s (20 to 500 mm/min), depths 0 to the nail's length"))]
    Outside {
        /// The law.
        law: &'static str,
        /// The wood.
        wood: &'static str,
        /// The nail.
        nail: &'static str,
        /// What is outside.
        source: CycleError,
    },
    /// A constant force that is none.
    #[error("a constant resistance of {force} N is no force of the wood")]
    #[diagnostic(help("give a finite force, 0 or more"))]
    Force {
        /// The force \[N\].
        force: f64,
    },
    /// A table that cannot be read.
    #[error("cannot read {}: {cause}", path.display())]
    #[diagnostic(help("name a CSV file of depths in m and forces in N"))]
    Unreadable {
        /// The file.
        path: PathBuf,
        /// What the system said.
        cause: String,
    },
    /// A file that holds no law.
    #[error("{} holds no penetration law", path.display())]
    #[diagnostic(help("a line holds a depth in m and a force in N with a comma between; depths increase from 0"))]
    Table {
        /// The file.
        path: PathBuf,
        /// What is wrong with it.
        source: TableError,
    },
    /// A depth beyond the nail, or beyond the points of a table.
    #[error("depth {depth} m is beyond the range of \"{law}\" with a {nail} nail, 0 to {most} m")]
    #[diagnostic(help("ask for smaller depths, or for a table add points up to the nail's length"))]
    TooDeep {
        /// The law.
        law: String,
        /// The nail.
        nail: &'static str,
        /// The depth \[m\].
        depth: f64,
        /// The last valid one \[m\].
        most: f64,
    },
}

/// Reads a law from a CSV file of depths \[m\] and forces \[N\].
///
/// # Errors
/// [`PenetrationError::Unreadable`] or [`PenetrationError::Table`] with the file.
pub fn table(path: &Path) -> Result<ForceTable, PenetrationError> {
    let text = std::fs::read_to_string(path).map_err(|cause| PenetrationError::Unreadable {
        path: path.to_owned(),
        cause: cause.to_string(),
    })?;
    ForceTable::from_csv(&text).map_err(|source| PenetrationError::Table {
        path: path.to_owned(),
        source,
    })
}

/// The name of a law, as in the design file.
pub fn law_name(law: PenetrationLaw) -> &'static str {
    use PenetrationLaw as P;
    match law {
        P::Smooth => "smooth",
        P::Annular => "annular",
        P::Helical => "helical",
        P::General => "general",
        P::Reduced1 => "reduced1",
        P::Reduced2 => "reduced2",
        P::Reduced3 => "reduced3",
        P::Reduced4 => "reduced4",
        P::Reduced5 => "reduced5",
        P::Reduced6 => "reduced6",
        P::SolidWood => "solid_wood",
    }
}

/// The published law of this name; case, hyphens and spaces do not matter.
///
/// # Errors
/// [`PenetrationError::Unknown`] with all names.
pub fn law(name: &str) -> Result<PenetrationLaw, PenetrationError> {
    find("law", name, &PenetrationLaw::ALL, |law| law_name(*law)).copied()
}

/// The wood of this name among those of the published tests.
///
/// # Errors
/// [`PenetrationError::Unknown`] with all names.
pub fn wood(name: &str) -> Result<&'static WoodKind, PenetrationError> {
    find("wood", name, &WOODS, |wood| wood.name)
}

/// The nail of this penny size among those of the published tests.
///
/// # Errors
/// [`PenetrationError::Unknown`] with all sizes.
pub fn nail(name: &str) -> Result<&'static NailSize, PenetrationError> {
    find("nail", name, &NAILS, |nail| nail.name)
}

fn find<T>(
    what: &'static str,
    name: &str,
    all: &'static [T],
    own: fn(&T) -> &'static str,
) -> Result<&'static T, PenetrationError> {
    let plain = |text: &str| text.trim().to_lowercase().replace(['-', '_', ' '], "");
    all.iter().find(|item| plain(own(item)) == plain(name)).ok_or_else(|| {
        let distance = |item: &T| strsim::damerau_levenshtein(&plain(own(item)), &plain(name));
        let nearest = all
            .iter()
            .min_by_key(|item| distance(item))
            .filter(|item| distance(item) <= 2 + name.len() / 4);
        let known = all.iter().map(own).collect::<Vec<_>>().join(", ");
        PenetrationError::Unknown {
            what,
            name: name.to_owned(),
            nearest: nearest.map(own),
            known,
        }
    })
}

/// A law to compare.
#[derive(Debug, Clone)]
pub enum Law {
    /// A published law, with the wood it is evaluated for and what it depends on.
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
    /// A force over depth by points.
    Tabulated(ForceTable),
}

/// A law for one nail.
#[derive(Debug, Clone)]
pub struct Resistance {
    /// Name of the law.
    pub name: String,
    /// The law.
    pub law: Law,
    /// The nail.
    pub nail: &'static NailSize,
}

impl Resistance {
    /// The law `law` for `nail` in `wood` at penetration speed `speed` \[m/s\].
    ///
    /// # Errors
    /// [`PenetrationError::NoSuchShank`] where the size was not tested with the law's shank;
    /// [`PenetrationError::Outside`] for a speed that is not quasi-static.
    pub fn new(
        law: PenetrationLaw,
        wood: &'static WoodKind,
        nail: &'static NailSize,
        speed: f64,
    ) -> Result<Self, PenetrationError> {
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
            PenetrationError::NoSuchShank {
                law: law_name(law),
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
        let resistance = Self {
            name: law_name(law).to_owned(),
            law: Law::Published {
                law,
                wood,
                specimen,
                speed,
            },
            nail,
        };
        resistance.force(0.0).map(|_| resistance)
    }

    /// The same `force` \[N\] at every depth of `nail`.
    ///
    /// # Errors
    /// [`PenetrationError::Force`] for a force that is not finite or below zero.
    pub fn constant(force: f64, nail: &'static NailSize) -> Result<Self, PenetrationError> {
        if !(force.is_finite() && force >= 0.0) {
            return Err(PenetrationError::Force { force });
        }
        Ok(Self {
            name: format!("constant {force} N"),
            law: Law::Constant(force),
            nail,
        })
    }

    /// The law `table` called `name` for `nail`.
    ///
    /// # Errors
    /// [`PenetrationError::TooDeep`] where the table ends before the nail does.
    pub fn tabulated(name: &str, table: ForceTable, nail: &'static NailSize) -> Result<Self, PenetrationError> {
        let resistance = Self {
            name: name.to_owned(),
            law: Law::Tabulated(table),
            nail,
        };
        resistance.force(nail.length).map(|_| resistance)
    }

    /// The wood of a published law; the others are of no wood.
    pub fn wood(&self) -> Option<&'static WoodKind> {
        match &self.law {
            Law::Published { wood, .. } => Some(wood),
            Law::Constant(_) | Law::Tabulated(_) => None,
        }
    }

    /// F_r, force \[N\] at `depth` \[m\]; zero at or above the surface.
    ///
    /// # Errors
    /// [`PenetrationError::Outside`] beyond the nail's length, or at a speed that is not quasi-static;
    /// [`PenetrationError::TooDeep`] for laws that are not published.
    pub fn force(&self, depth: f64) -> Result<f64, PenetrationError> {
        let most = match &self.law {
            Law::Published {
                law,
                wood,
                specimen,
                speed,
            } => {
                return law
                    .force(specimen, depth, *speed)
                    .map_err(|source| PenetrationError::Outside {
                        law: law_name(*law),
                        wood: wood.name,
                        nail: self.nail.name,
                        source,
                    });
            }
            Law::Constant(_) => self.nail.length,
            Law::Tabulated(table) => self.nail.length.min(table.last_depth()),
        };
        if depth.is_nan() || depth > most * (1.0 + 1e-9) {
            return Err(PenetrationError::TooDeep {
                law: self.name.clone(),
                nail: self.nail.name,
                depth,
                most,
            });
        }
        Ok(match &self.law {
            Law::Tabulated(table) => table.force(depth),
            Law::Constant(force) if depth > 0.0 => *force,
            Law::Constant(_) | Law::Published { .. } => 0.0,
        })
    }

    /// The force at `depth` \[m\] with the root one standard error lower and higher \[N\]; nothing where no fit is
    /// published.
    ///
    /// # Errors
    /// As [`force`](Self::force).
    pub fn band(&self, depth: f64) -> Result<Option<[f64; 2]>, PenetrationError> {
        let force = self.force(depth)?;
        let Law::Published { law, specimen, .. } = &self.law else {
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
    /// As [`force`](Self::force).
    pub fn work(&self, depth: f64) -> Result<f64, PenetrationError> {
        self.force(depth)?;
        let h = depth.max(0.0) / f64::from(INTERVALS);
        let mut sum = 0.0;
        for i in 0..=INTERVALS {
            let weight = if i == 0 || i == INTERVALS {
                1.0
            } else {
                f64::from(2 + 2 * (i % 2))
            };
            // The force begins with a step at the surface: the first point stands just below it.
            sum += weight * self.force((h * f64::from(i)).clamp(depth * 1e-12, depth))?;
        }
        Ok(sum * h / 3.0)
    }

    /// Published quality of the fit, in units of the root where not a ratio.
    pub fn quality(&self) -> Option<FitQuality> {
        match &self.law {
            Law::Published { law, .. } => Some(law.fit_quality()),
            Law::Constant(_) | Law::Tabulated(_) => None,
        }
    }

    /// What a reader must know beside the numbers.
    pub fn notes(&self) -> Vec<String> {
        let Law::Published { law, wood, .. } = &self.law else {
            return Vec::new();
        };
        let name = law_name(*law);
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
