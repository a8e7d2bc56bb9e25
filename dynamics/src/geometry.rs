//! Quantities that follow from the primary ones: areas, masses, delay and attenuation of the channel.

use std::f64::consts::PI;

use serde::Serialize;

use crate::{Parameters, SupportDamping};

/// Derived quantities of a design (SI).
///
/// ```text
/// A_1 = pi/4 d_c^2,  A_r = pi/4 d_rod^2,  A_2 = A_1 - A_r        (C-27: no force at uniform pressure)
/// A_h1 = pi/4 (outer^2 - inner^2),  A_h2 = pi/4 (outer^2 - seat^2),  A_h3 = A_h1 - A_h2
/// A_ma = n pi/4 d^2
/// tau = L_ch/c,  c = sqrt(gamma R T_a)
/// phi = exp(-R_ch L_ch R T_a/(2 P c)),  R_ch = 32 mu/D_ch^2       (Eq. 4.50, laminar)
/// ```
/// The laminar attenuation of the reference channel is 0.9981 venting and 0.9997 filling (the source's set rounds to 0.998
/// and 0.9998); the flow there is turbulent, and either way the effect is below 1 us (C-22).
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
    /// A_ma, exhaust holes \[m2\].
    pub exhaust_area: f64,
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
        let disc = |d: f64| 0.25 * PI * d * d;
        let air = &p.ambient;
        let piston_area = disc(p.piston.bore);
        let rod_area = disc(p.piston.rod_diameter);
        let valve = &p.head_valve;
        let valve_control_area = disc(valve.outer_diameter) - disc(valve.inner_diameter);
        let valve_supply_area = disc(valve.outer_diameter) - disc(valve.seat_diameter);
        let nail = &p.nail;
        let nail_volume =
            disc(nail.diameter) * (nail.length - nail.head_thickness) + disc(nail.head_diameter) * nail.head_thickness;
        let workpiece_mass = p.wood.density * p.wood.length * p.wood.width * p.wood.thickness;

        let sound_speed = (air.heat_capacity_ratio * air.gas_constant * air.temperature).sqrt();
        let channel = &p.trigger;
        let resistance = 32.0 * air.viscosity / (channel.channel_diameter * channel.channel_diameter);
        let attenuation = |pressure: f64| {
            let rt = air.gas_constant * air.temperature;
            (-resistance * channel.channel_length * rt / (2.0 * pressure * sound_speed)).exp()
        };
        let support_damping = match p.support.damping {
            SupportDamping::Ratio(zeta) => 2.0 * zeta * (p.support.stiffness * workpiece_mass).sqrt(),
            SupportDamping::Coefficient(c) => c,
        };
        Self {
            piston_area,
            rod_area,
            ring_area: piston_area - rod_area,
            valve_control_area,
            valve_supply_area,
            valve_cylinder_area: valve_control_area - valve_supply_area,
            exhaust_area: f64::from(p.exhaust.holes) * disc(p.exhaust.hole_diameter),
            nail_mass: nail.density * nail_volume,
            workpiece_mass,
            channel_delay: channel.channel_length / sound_speed,
            attenuation_fill: attenuation(p.supply.pressure),
            attenuation_vent: attenuation(air.pressure),
            support_damping,
        }
    }
}
