//! Penetration resistance of the nail in a cycle.

use nailnoise_penetration::{Driven, Envelope, Shanks, Specimen};

use crate::{Form, Parameters};

impl Parameters {
    /// The envelope of the penetration resistance.
    pub fn penetration_envelope(&self) -> Envelope {
        let specimen = Specimen {
            length: self.nail.length,
            diameter: self.nail.diameter,
            hardness_modulus: self.wood.hardness_modulus,
            density: self.wood.density,
        };
        let driven = Driven {
            wood: &self.wood,
            table: self.penetration_table.as_ref(),
            fit: self.penetration_fit.as_ref(),
            specimen: &specimen,
            mass: self.piston.mass,
            shanks: Shanks {
                legs: self.nail.legs,
                friction_share: self.friction_share,
                coating: self.nail.coating,
            },
        };
        Envelope::new(&driven, self.nail.head_diameter, self.model.nail == Form::Corrected)
    }

    /// Envelope of the penetration resistance \[N\] for the nail's tip at its deepest `depth` \[m\].
    ///
    /// For many depths of one design, [`penetration_envelope`](Self::penetration_envelope) is faster.
    pub fn penetration_resistance(&self, depth: f64) -> f64 {
        self.penetration_envelope().force(depth)
    }
}
