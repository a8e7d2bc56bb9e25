//! Reasons why a law cannot be fitted.

use thiserror::Error;

use super::law_error::LawError;

/// Why a law cannot be fitted to drives.
#[derive(Debug, Clone, PartialEq, Error)]
#[non_exhaustive]
pub enum FitError {
    /// No drive has points.
    #[error("there are no points to fit")]
    Empty,
    /// A value of a drive is impossible in a test.
    #[error("drive \"{drive}\": {what} is {value}, and must be {rule}")]
    Value {
        /// The drive.
        drive: String,
        /// The quantity.
        what: &'static str,
        /// Its value \[SI\].
        value: f64,
        /// The requirement.
        rule: &'static str,
    },
    /// A term depends on a variable that some drives do not have.
    #[error(
        "the term {term} needs the mass and speed of a projectile, and drive \"{drive}\" was made at constant speed"
    )]
    NoImpact {
        /// The term.
        term: String,
        /// The first drive without an impact.
        drive: String,
    },
    /// Too few distinct depths for the degree of the polynomial.
    #[error("the data have {depths} distinct depths, too few for x^{degree}")]
    TooFewDepths {
        /// Distinct depths.
        depths: usize,
        /// Highest power of x.
        degree: f64,
    },
    /// Too few drives for the terms that are constant within a drive.
    #[error("{drives} drives do not determine {terms} terms that are constant in a drive")]
    TooFewDrives {
        /// Number of drives.
        drives: usize,
        /// Number of terms that are constant within a drive.
        terms: usize,
    },
    /// Too few points for the terms.
    #[error("{points} points do not determine {terms} terms")]
    TooFewPoints {
        /// Number of points.
        points: usize,
        /// Number of terms.
        terms: usize,
    },
    /// The data cannot separate a term from others.
    #[error("the data do not tell the term {term} from {}", if partners.is_empty() { "0".to_owned() }
        else { partners.join(", ") })]
    NotIdentifiable {
        /// The term.
        term: String,
        /// The terms whose combination equals it in these data; none if it is zero everywhere.
        partners: Vec<String>,
    },
    /// A term of the form depends on the speed, as the law of the speed already does.
    #[error("the term {term} depends on the speed, and so does the law of the speed")]
    TermOfSpeed {
        /// The term.
        term: String,
    },
    /// The speeds of the points do not differ enough to determine the law of the speed.
    #[error(
        "all points have speeds from {:.4e} to {:.4e} m/s, which do not determine beta and v_m",
        speeds[0],
        speeds[1]
    )]
    OneSpeed {
        /// Lowest and highest speed \[m/s\].
        speeds: [f64; 2],
    },
    /// The estimation of the law of the speed does not converge.
    #[error("beta and v_m do not converge within {steps} steps")]
    NoRate {
        /// Number of steps.
        steps: usize,
    },
    /// The fit contains numbers that are not valid in a law.
    #[error("the fit gives no law: {0}")]
    NoLaw(LawError),
    /// A matrix decomposition did not converge.
    #[error("the covariance of the coefficients cannot be computed")]
    Covariance,
    /// The group to be left out is the only one.
    #[error("all drives belong to one {what}, so that none can be left out")]
    OneFold {
        /// Kind of group.
        what: &'static str,
    },
}

impl FitError {
    /// How to fix it.
    pub fn remedy(&self) -> String {
        match self {
            Self::Empty => "give at least one drive with points below the surface".to_owned(),
            Self::Value { .. } => "correct the value in the file of the drives".to_owned(),
            Self::NoImpact { term, .. } => {
                format!("drop {term} from --form, or give projectile_mass_kg and impact_speed_m_s for every drive")
            }
            Self::TooFewDepths { depths, .. } => {
                format!(
                    "use poly(x,{}) or lower, or smaller bins of depth",
                    depths.saturating_sub(1)
                )
            }
            Self::TooFewDrives { .. } => {
                "drive more nails under different conditions, or drop terms from --form".to_owned()
            }
            Self::TooFewPoints { .. } => "give more points, or drop terms from --form".to_owned(),
            Self::NotIdentifiable { term, partners } => match partners.first() {
                Some(partner) => format!(
                    "drop {term} or {partner} from --form, or add drives in which {term} changes and {partner} does not"
                ),
                None => format!("drop {term} from --form"),
            },
            Self::TermOfSpeed { term } => format!("drop {term} from --form, or give --rate none"),
            Self::OneSpeed { .. } => {
                "add drives at other speeds, a factor of 10 apart or more, or give --rate speed to take the published \
                 beta and v_m"
                    .to_owned()
            }
            Self::NoRate { .. } => "give --rate speed to take the published beta and v_m".to_owned(),
            Self::NoLaw(_) => {
                "check the values of the drives: a length, a modulus, a speed or a force in another unit spoils a fit"
                    .to_owned()
            }
            Self::Covariance => "drop the terms with the largest VIF from --form".to_owned(),
            Self::OneFold { .. } => "leave out something that the drives differ in, with --leave".to_owned(),
        }
    }
}
