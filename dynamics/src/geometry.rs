//! Quantities that follow from the primary ones: areas, masses, delay and attenuation of the channel.

use std::f64::consts::PI;

use serde::Serialize;

use crate::{Ambient, Block, Chambers, Exhaust, HeadValve, Nail, Parameters, Piston, Support, SupportDamping, Trigger};

/// Derived quantities of a design (SI).
///
/// ```text
/// A_1 = pi/4 d_c^2,  A_r = pi/4 d_rod^2,  A_2 = A_1 - A_r        (C-27: no force at uniform pressure)
/// A_h1 = pi/4 (outer^2 - inner^2),  A_h2 = pi/4 (outer^2 - seat^2),  A_h3 = A_h1 - A_h2
/// A_ma = n pi/4 d^2
/// y_pbin = L - b - h,  y_pbp = L - b - l_n      (rod protrusion b beyond the nose, feed height h of the nail's head)
/// tau = L_ch/c,  c = sqrt(gamma R T_a)
/// phi = exp(-R_ch L_ch R T_a/(2 P c)),  R_ch = 32 mu/D_ch^2       (Eq. 4.50, laminar)
/// ```
/// The laminar attenuation of the reference channel is 0.9981 for venting and 0.9997 for filling (the source's values
/// are rounded to 0.998 and 0.9998). The flow there is actually turbulent; either way the effect is less than 1 us
/// (C-22).
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Geometry {
    /// A_1, piston area above \[m2\].
    pub piston_area: f64,
    /// A_r, rod area \[m2\].
    pub rod_area: f64,
    /// A_2, piston area below \[m2\].
    pub ring_area: f64,
    /// A_h1, control side of the head valve \[m2\].
    pub valve_control_area: f64,
    /// A_h2, supply side of the head valve \[m2\].
    pub valve_supply_area: f64,
    /// A_h3, cylinder side of the head valve \[m2\].
    pub valve_cylinder_area: f64,
    /// A_ma, total area of the exhaust holes \[m2\].
    pub exhaust_area: f64,
    /// y_pbin, piston travel at which the rod hits the nail's head \[m\].
    pub head_gap: f64,
    /// y_pbp, piston travel at which the nail's tip touches the wood \[m\].
    pub tip_gap: f64,
    /// M_n, mass of the nail \[kg\].
    pub nail_mass: f64,
    /// M_w, mass of the block \[kg\].
    pub workpiece_mass: f64,
    /// tau, delay of the trigger channel \[s\].
    pub channel_delay: f64,
    /// phi_in, attenuation of the channel when filling, at P_sup \[-\].
    pub attenuation_fill: f64,
    /// phi_out, attenuation of the channel when venting, at P_a \[-\].
    pub attenuation_vent: f64,
    /// c_ws, dashpot of the support \[N s/m\].
    pub support_damping: f64,
}

impl Geometry {
    /// Derives all quantities of `p`.
    pub fn new(p: &Parameters) -> Self {
        let workpiece_mass = p.workpiece.mass(p.wood.density);
        let support_damping = p.support.dashpot(workpiece_mass);
        Self {
            piston_area: p.piston.area(),
            rod_area: p.piston.rod_area(),
            ring_area: p.piston.lower_area(),
            valve_control_area: p.head_valve.control_area(),
            valve_supply_area: p.head_valve.supply_area(),
            valve_cylinder_area: p.head_valve.cylinder_area(),
            exhaust_area: p.exhaust.area(),
            head_gap: p.nail.head_gap(&p.piston),
            tip_gap: p.nail.tip_gap(&p.piston) + p.workpiece.groove,
            nail_mass: p.nail.mass(),
            workpiece_mass,
            channel_delay: p.trigger.delay(&p.ambient),
            attenuation_fill: p.trigger.attenuation(p.supply.pressure, &p.ambient),
            attenuation_vent: p.trigger.attenuation(p.ambient.pressure, &p.ambient),
            support_damping,
        }
    }
}

fn disc(diameter: f64) -> f64 {
    0.25 * PI * diameter * diameter
}

impl Piston {
    /// A_1 = pi/4 d_c^2, area of the upper side \[m2\].
    pub fn area(&self) -> f64 {
        disc(self.bore)
    }

    /// A_r = pi/4 d_r^2, area of the rod \[m2\].
    pub fn rod_area(&self) -> f64 {
        disc(self.rod_diameter)
    }

    /// A_2 = A_1 - A_r, area of the lower side \[m2\], so that uniform pressure gives no net force (C-27).
    pub fn lower_area(&self) -> f64 {
        self.area() - self.rod_area()
    }

    /// Distance from the rod's end to the nose's face with the piston on the upper stopper \[m\].
    fn rod_setback(&self) -> f64 {
        self.stroke - self.rod_protrusion
    }
}

impl HeadValve {
    /// A_h1 = pi/4 (outer^2 - inner^2), area of the upper side \[m2\].
    pub fn control_area(&self) -> f64 {
        disc(self.outer_diameter) - disc(self.inner_diameter)
    }

    /// A_h2 = pi/4 (outer^2 - seat^2), area of the underside outside the seat \[m2\].
    pub fn supply_area(&self) -> f64 {
        disc(self.outer_diameter) - disc(self.seat_diameter)
    }

    /// A_h3 = A_h1 - A_h2, area of the underside inside the seat \[m2\].
    pub fn cylinder_area(&self) -> f64 {
        self.control_area() - self.supply_area()
    }
}

impl Chambers {
    /// The discharge coefficient of a passage with the coefficient `own`; 0 selects that of the other passages.
    pub fn coefficient(&self, own: f64) -> f64 {
        if own > 0.0 { own } else { self.discharge_coefficient }
    }
}

impl Exhaust {
    /// A_ma = n pi/4 d^2, total area of the holes \[m2\].
    pub fn area(&self) -> f64 {
        f64::from(self.holes) * disc(self.hole_diameter)
    }

    /// C_d of the holes; that of the other passages if the design leaves it at 0.
    pub fn coefficient(&self, others: &Chambers) -> f64 {
        others.coefficient(self.discharge_coefficient)
    }
}

impl Trigger {
    /// tau = L_ch/c, delay of the channel \[s\].
    pub fn delay(&self, air: &Ambient) -> f64 {
        self.channel_length / air.sound_speed()
    }

    /// phi = exp(-R_ch L_ch R T_a/(2 P c)), attenuation of the channel at the absolute pressure P \[Pa\], with the
    /// laminar resistance R_ch = 32 mu/D_ch^2 (Eq. 4.50).
    pub fn attenuation(&self, pressure: f64, air: &Ambient) -> f64 {
        let resistance = 32.0 * air.viscosity / (self.channel_diameter * self.channel_diameter);
        let rt = air.gas_constant * air.temperature;
        (-resistance * self.channel_length * rt / (2.0 * pressure * air.sound_speed())).exp()
    }
}

impl Nail {
    /// y_pbin, piston travel at which the rod strikes the head of the waiting nail \[m\].
    pub fn head_gap(&self, piston: &Piston) -> f64 {
        piston.rod_setback() - self.feed_height
    }

    /// y_pbp, piston travel at which the tip of the nail, with its head at the end of the rod, touches the wood \[m\].
    pub fn tip_gap(&self, piston: &Piston) -> f64 {
        piston.rod_setback() - self.length
    }

    /// M_n, mass of the shanks, whose length excludes the head's thickness, and of the head \[kg\].
    pub fn mass(&self) -> f64 {
        let shank = f64::from(self.legs) * disc(self.diameter) * (self.length - self.head_thickness);
        self.density * (shank + disc(self.head_diameter) * self.head_thickness)
    }
}

impl Block {
    /// M_w, mass of the block of wood with this density \[kg/m3\] \[kg\].
    pub fn mass(&self, density: f64) -> f64 {
        density * self.length * self.width * self.thickness
    }
}

impl Support {
    /// c_ws, dashpot of the support under a block with this mass \[kg\] \[N s/m\].
    pub fn dashpot(&self, mass: f64) -> f64 {
        match self.damping {
            SupportDamping::Ratio(zeta) => 2.0 * zeta * (self.stiffness * mass).sqrt(),
            SupportDamping::Coefficient(c) => c,
        }
    }

    /// zeta_ws, damping ratio of the support under a block with this mass \[kg\] \[-\].
    pub fn damping_ratio(&self, mass: f64) -> f64 {
        match self.damping {
            SupportDamping::Ratio(zeta) => zeta,
            SupportDamping::Coefficient(c) => c / (2.0 * (self.stiffness * mass).sqrt()),
        }
    }
}

/// P_cr = (2/(gamma+1))^(gamma/(gamma-1)), critical pressure ratio of the ideal nozzle \[-\], for the ratio gamma of
/// heat capacities.
pub fn critical_ratio(gamma: f64) -> f64 {
    (2.0 / (gamma + 1.0)).powf(gamma / (gamma - 1.0))
}

impl Ambient {
    /// rho_0 = P_a/(R T_a), density of the air \[kg/m3\].
    pub fn density(&self) -> f64 {
        self.pressure / (self.gas_constant * self.temperature)
    }

    /// P_cr, [`critical_ratio`] of the air \[-\].
    pub fn critical_ratio(&self) -> f64 {
        critical_ratio(self.heat_capacity_ratio)
    }

    /// c_0 = sqrt(gamma R T_a), speed of sound \[m/s\].
    pub fn sound_speed(&self) -> f64 {
        (self.heat_capacity_ratio * self.gas_constant * self.temperature).sqrt()
    }
}
