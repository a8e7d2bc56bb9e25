//! Quantities that follow from the primary ones, each by one formula.
//!
//! They are computed and never given twice. A design that gives one all the same is refused where the two disagree by
//! more than [`AGREEMENT`], and warned that it has no effect where they agree.

use std::f64::consts::PI;

use nailnoise_dynamics as dynamics;

use super::dimension::*;
use super::groups::*;

/// Relative difference up to which a given derived quantity agrees with the computed one.
pub const AGREEMENT: f64 = 1e-3;

/// A derived quantity.
#[derive(Debug)]
pub struct Derived {
    /// Full name, in the group where a user would look for it.
    pub key: &'static str,
    /// Symbol.
    pub symbol: &'static str,
    /// Dimension.
    pub dimension: Dimension,
    /// Description.
    pub description: &'static str,
    /// The quantities it is computed from.
    pub primaries: &'static [&'static str],
    /// Its value in SI units.
    pub value: fn(&Values) -> f64,
}

impl Derived {
    /// The derived quantity of this full name.
    pub fn find(key: &str) -> Option<&'static Self> {
        DERIVED.iter().find(|derived| derived.key == key)
    }
}

macro_rules! derived {
    ($($key:literal $symbol:literal $dimension:ident $description:literal [$($primary:literal),+] $value:expr;)+) => {
        /// All derived quantities.
        pub const DERIVED: &[Derived] = &[$(Derived {
            key: $key,
            symbol: $symbol,
            dimension: $dimension,
            description: $description,
            primaries: &[$($primary),+],
            value: $value,
        }),+];
    };
}

derived! {
    "piston.area" "A_1" AREA "Area of the piston's upper side." ["piston.bore"] |v| piston(v).area();
    "piston.rod_area" "A_r" AREA "Area of the rod." ["piston.rod_diameter"] |v| piston(v).rod_area();
    "piston.lower_area" "A_2" AREA "Area of the piston's lower side, A_1 - A_r."
        ["piston.bore", "piston.rod_diameter"] |v| piston(v).lower_area();
    "head_valve.control_area" "A_h1" AREA "Area of the head valve's upper side."
        ["head_valve.outer_diameter", "head_valve.inner_diameter"] |v| head_valve(v).control_area();
    "head_valve.supply_area" "A_h2" AREA "Area of the head valve's underside outside the seat."
        ["head_valve.outer_diameter", "head_valve.seat_diameter"] |v| head_valve(v).supply_area();
    "head_valve.cylinder_area" "A_h3" AREA "Area of the head valve's underside inside the seat, A_h1 - A_h2."
        ["head_valve.seat_diameter", "head_valve.inner_diameter"] |v| head_valve(v).cylinder_area();
    "exhaust.area" "A_ma" AREA "Area of all exhaust holes." ["exhaust.holes", "exhaust.hole_diameter"]
        |v| exhaust(v).area();
    "trigger.delay" "tau" TIME "Delay of the trigger channel, L_ch/c."
        ["trigger.channel_length", "ambient.temperature"] |v| trigger(v).delay(&ambient(v));
    "trigger.fill_attenuation" "phi_in" NUMBER "Attenuation of the trigger channel at supply pressure (Eq. 4.50)."
        ["trigger.channel_length", "trigger.channel_diameter"]
        |v| trigger(v).attenuation(v.supply.pressure, &ambient(v));
    "trigger.vent_attenuation" "phi_out" NUMBER "Attenuation of the trigger channel at ambient pressure (Eq. 4.50)."
        ["trigger.channel_length", "trigger.channel_diameter"]
        |v| trigger(v).attenuation(v.ambient.pressure, &ambient(v));
    "nail.mass" "M_n" MASS "Mass of the nail."
        ["nail.length", "nail.diameter", "nail.head_diameter", "nail.head_thickness", "nail.density"]
        |v| nail(v).mass();
    "workpiece.mass" "M_w" MASS "Mass of the workpiece."
        ["workpiece.length", "workpiece.width", "workpiece.thickness", "wood.density"]
        |v| dynamics::Wood::from(v).block_mass();
    "support.sand.shear_speed" "V_s" VELOCITY "Shear wave speed of the sand, sqrt(G_0/rho)."
        ["support.sand.shear_modulus", "support.sand.density"] |v| v.support.sand.shear_speed();
    "body.volume" "V" VOLUME "Volume of air that the tool body displaces."
        ["body.barrel_radius", "body.cap_radius", "body.handle_radius", "body.magazine_radius", "body.nose_width"]
        |v| v.body.volume();
    "ambient.density" "rho_0" DENSITY "Density of the air, P_a/(R T_a)."
        ["ambient.pressure", "ambient.gas_constant", "ambient.temperature"] |v| ambient(v).density();
    "ambient.sound_speed" "c_0" VELOCITY "Speed of sound, sqrt(gamma R T_a)."
        ["ambient.heat_capacity_ratio", "ambient.gas_constant", "ambient.temperature"] |v| ambient(v).sound_speed();
}

// The cycle holds the formulas of its own parameters.

fn piston(v: &Values) -> dynamics::Piston {
    (&v.piston).into()
}

fn head_valve(v: &Values) -> dynamics::HeadValve {
    (&v.head_valve).into()
}

fn exhaust(v: &Values) -> dynamics::Exhaust {
    (&v.exhaust).into()
}

fn trigger(v: &Values) -> dynamics::Trigger {
    (&v.trigger).into()
}

fn nail(v: &Values) -> dynamics::Nail {
    (&v.nail).into()
}

fn ambient(v: &Values) -> dynamics::Ambient {
    (&v.ambient).into()
}

impl Sand {
    /// Shear wave speed \[m/s\], V_s = sqrt(G_0/rho).
    pub fn shear_speed(&self) -> f64 {
        (self.shear_modulus / self.density).sqrt()
    }
}

impl Body {
    /// Volume of air \[m3\] that barrel, cap, handle, magazine and nose displace, each as a closed solid of its outer
    /// dimensions; arms and overlaps are left out.
    pub fn volume(&self) -> f64 {
        let cylinder = |radius: f64, height: f64| PI * radius * radius * height;
        cylinder(self.barrel_radius, self.barrel_height)
            + cylinder(self.cap_radius, self.cap_height)
            + cylinder(self.handle_radius, self.handle_length)
            + cylinder(self.magazine_radius, self.magazine_height)
            + self.nose_width * self.nose_depth * self.nose_height
    }
}
