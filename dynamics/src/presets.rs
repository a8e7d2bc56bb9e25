//! The model as published, for comparison.

use std::f64::consts::PI;

use crate::{Form, Model, Parameters, SupportDamping};

/// A_h2 that gives the published valve balance its opening pressure, without P_1 on the underside \[m2\] (C-06).
const PUBLISHED_SUPPLY_AREA: f64 = 376e-6;

impl Parameters {
    /// The same design with the published nail model: elastic penetration and no impact of the rod.
    #[must_use]
    pub fn published_nail_only(mut self) -> Self {
        self.model.nail = Form::Published;
        self.model.impact = Form::Published;
        self
    }

    /// The same design with every form as published. It has no leak and no damping of valve and wood contacts. Only the
    /// rising tool releases the trigger, and the seat diameter is that required by the published force balance.
    #[must_use]
    pub fn published_all(mut self) -> Self {
        let published = Form::Published;
        self.model = Model {
            gas: published,
            valve_underside: published,
            nail: published,
            impact: published,
            contacts: published,
            intake: published,
            delay: published,
            channel: published,
            refill: published,
            ..self.model
        };
        self.chambers.leak_area = 0.0;
        self.trigger.release_after = 0.0;
        self.contacts.valve_damping_ratio = 0.0;
        self.contacts.nose_damping_ratio = 0.0;
        self.support.damping = SupportDamping::Ratio(0.0);
        let outer = self.head_valve.outer_diameter;
        self.head_valve.seat_diameter = (outer * outer - 4.0 / PI * PUBLISHED_SUPPLY_AREA).sqrt();
        self
    }
}
