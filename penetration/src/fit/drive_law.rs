//! A fitted law for one nail, wood and mass, in the form used by the nailing cycle.

use super::form::{Term, VARIABLES, Variable};
use super::law::{FittedLaw, SLACK};
use super::rate_fit::FittedRate;

/// C times a product of powers of depth, speed and impact speed.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Monomial {
    coefficient: f64,
    depth: f64,
    speed: f64,
    impact: f64,
}

/// A fitted law for one nail, wood and mass: force as a function of depth, speed and impact speed.
#[derive(Debug, Clone, PartialEq)]
pub struct LawOfDrive {
    terms: Vec<Monomial>,
    length: f64,
    scale: f64,
    /// Range of v/v0 in the data. The speed is limited to it; none for a law without speed.
    decay: Option<[f64; 2]>,
    /// Impact speed at the middle of the data \[m/s\].
    usual_impact: f64,
    /// Range of valid impact speeds \[m/s\].
    impacts: [f64; 2],
    /// Dependence on speed in the tests that the quasi-static law excludes.
    rate: Option<Box<FittedRate>>,
}

/// Force with its derivatives.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Resisting {
    /// F_r \[N\].
    pub force: f64,
    /// dF_r/dy \[N/m\].
    pub by_depth: f64,
    /// dF_r/dv \[N s/m\].
    pub by_speed: f64,
}

impl FittedLaw {
    /// The law for a nail in a wood, driven by a mass \[kg\].
    pub fn of(&self, specimen: &crate::Specimen, mass: f64) -> LawOfDrive {
        LawOfDrive::new(self, specimen, mass)
    }
}

impl LawOfDrive {
    fn new(law: &FittedLaw, specimen: &crate::Specimen, mass: f64) -> Self {
        let inertia = specimen.length * specimen.density / specimen.hardness_modulus;
        let energy = mass / (specimen.hardness_modulus * specimen.length * specimen.length);
        let dynamic = law.dynamic();
        let reference = law.reference_speed();
        let monomial = |(term, coefficient): (&Term, &f64)| {
            let power: [f64; VARIABLES] = Variable::ALL.map(|variable| term.power(variable));
            let [x, rate, slender, pi3, decay, pi6] = power;
            let fixed = coefficient
                * (specimen.diameter / specimen.length).powf(slender)
                * inertia.powf(rate + pi3)
                * energy.powf(pi6);
            Monomial {
                // A law from constant-speed tests is used at their highest speed.
                coefficient: if dynamic {
                    fixed
                } else {
                    fixed * reference.powf(2.0 * rate)
                },
                depth: x,
                speed: decay + if dynamic { 2.0 * rate } else { 0.0 },
                impact: 2.0 * (pi3 + pi6) - decay,
            }
        };
        let mut terms: Vec<Monomial> = law
            .form()
            .terms()
            .iter()
            .zip(law.coefficients().iter())
            .map(monomial)
            .collect();
        if law.specimen_deviation() != 0.0 {
            terms.push(Monomial {
                coefficient: law.specimen_deviation(),
                depth: 0.0,
                speed: 0.0,
                impact: 0.0,
            });
        }
        let mut impacts = [0.0, f64::INFINITY];
        for (variable, per_square) in [(Variable::Inertia, inertia), (Variable::Energy, energy)] {
            if let Some([low, high]) = law.file().ranges.of(variable)
                && law.form().uses(variable)
                && !law.file().extrapolate
            {
                impacts[0] = f64::max(impacts[0], (low / per_square).sqrt() * (1.0 - SLACK));
                impacts[1] = f64::min(impacts[1], (high / per_square).sqrt() * (1.0 + SLACK));
            }
        }
        let varies = terms.iter().any(|term| term.speed != 0.0);
        Self {
            decay: law.file().ranges.decay.filter(|_| varies),
            usual_impact: law
                .file()
                .ranges
                .impact_speed_m_s
                .map_or(reference, |[low, high]| 0.5 * (low + high)),
            terms,
            impacts,
            rate: law.file().rate.clone().map(Box::new),
            length: specimen.length,
            scale: specimen.hardness_modulus * specimen.length,
        }
    }

    /// Dependence on speed that multiplies the law; none unless the fit divided the forces of the tests by it.
    pub fn rate(&self) -> Option<&FittedRate> {
        self.rate.as_deref()
    }

    /// Range of valid impact speeds \[m/s\]: that of the data of `inertia` and `energy`.
    pub fn impacts(&self) -> [f64; 2] {
        self.impacts
    }

    /// Impact speed at the middle of the data \[m/s\], assumed if none is known.
    pub fn usual_impact(&self) -> f64 {
        self.usual_impact
    }

    /// The force at `depth` \[m\] and `speed` \[m/s\] after an impact at `impact` \[m/s\]. The ratio v/v0 is limited to
    /// the range of the data, because the gas behind the piston continues to push. The similarity law of Eq. 3.1 does
    /// not include this.
    #[inline]
    pub fn evaluate(&self, depth: f64, speed: f64, impact: f64) -> Resisting {
        let x = depth / self.length;
        let (held, free) = match self.decay {
            Some([low, high]) => {
                let held = speed.clamp(low * impact, high * impact);
                (held, held == speed)
            }
            None => (1.0, false),
        };
        let (mut root, mut by_x, mut by_v) = (0.0, 0.0, 0.0);
        for term in &self.terms {
            let rest = term.coefficient * power(impact, term.impact);
            let of_speed = power(held, term.speed);
            root += rest * of_speed * power(x, term.depth);
            if term.depth != 0.0 {
                by_x += rest * of_speed * term.depth * power(x, term.depth - 1.0);
            }
            if free && term.speed != 0.0 {
                by_v += rest * power(x, term.depth) * term.speed * power(held, term.speed - 1.0);
            }
        }
        if root > 0.0 {
            Resisting {
                force: self.scale * root * root,
                by_depth: 2.0 * self.scale * root * by_x / self.length,
                by_speed: 2.0 * self.scale * root * by_v,
            }
        } else {
            Resisting {
                force: 0.0,
                by_depth: 0.0,
                by_speed: 0.0,
            }
        }
    }
}

#[inline]
fn power(value: f64, power: f64) -> f64 {
    match power {
        0.0 => 1.0,
        1.0 => value,
        2.0 => value * value,
        // Integration steps may probe points above the surface.
        _ if power == power.trunc() => value.powi(power as i32),
        _ => value.max(0.0).powf(power),
    }
}
