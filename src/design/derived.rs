//! Quantities derived from the primary ones by one formula each.
//!
//! They are computed and need not be given. A design that nevertheless gives one is rejected if the two differ by more
//! than [`AGREEMENT`]. If they agree, the user is warned that it has no effect.

use std::f64::consts::PI;

use nailnoise_quantities::dimension::*;
use nailnoise_quantities::{Dimension, Value};

use super::groups::*;

/// Relative tolerance for the agreement of a given derived quantity with the computed one.
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

/// How a primary quantity is determined from a drawn derived one.
#[derive(Debug)]
pub struct Solution {
    /// Full name of the derived quantity.
    pub key: &'static str,
    /// The primary quantity that is adjusted; all others keep their values.
    pub follower: &'static str,
    /// The name under which [`Values::set`] applies the derived quantity in this way.
    pub change: &'static str,
    /// Sets the follower; returns whether a value exists.
    pub(super) solve: fn(&mut Values, f64) -> bool,
}

/// All solutions; the first one for a derived quantity is the default.
pub(super) const SOLUTIONS: &[Solution] = &[
    Solution {
        key: "exhaust.area",
        follower: "exhaust.hole_diameter",
        change: "exhaust.area",
        solve: |v, area| {
            let diameter = (4.0 * area / (PI * f64::from(v.exhaust.holes))).sqrt();
            v.set(&[("exhaust.hole_diameter", Value::Number(diameter))]).is_ok()
        },
    },
    Solution {
        key: "exhaust.area",
        follower: "exhaust.holes",
        change: "exhaust.area by exhaust.holes",
        // The nearest integer, at least one hole.
        solve: |v, area| {
            let holes = 4.0 * area / (PI * v.exhaust.hole_diameter * v.exhaust.hole_diameter);
            let holes = holes.round().clamp(1.0, f64::from(u32::MAX)) as u32;
            v.set(&[("exhaust.holes", Value::Count(holes))]).is_ok()
        },
    },
];

impl Solution {
    /// The default solution for a derived quantity, if another quantity can follow from it.
    pub(super) fn default_for(key: &str) -> Option<&'static Self> {
        SOLUTIONS.iter().find(|own| own.key == key)
    }

    /// The solution that [`Values::set`] applies under this name.
    pub(super) fn find(change: &str) -> Option<&'static Self> {
        SOLUTIONS.iter().find(|own| own.change == change)
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
    "piston.area" "A_1" AREA "Area of the piston's upper side." ["piston.bore"] |v| v.piston.area();
    "piston.rod_area" "A_r" AREA "Area of the rod." ["piston.rod_diameter"] |v| v.piston.rod_area();
    "piston.lower_area" "A_2" AREA "Area of the piston's lower side, A_1 - A_r."
        ["piston.bore", "piston.rod_diameter"] |v| v.piston.lower_area();
    "head_valve.control_area" "A_h1" AREA "Area of the head valve's upper side."
        ["head_valve.outer_diameter", "head_valve.inner_diameter"] |v| v.head_valve.control_area();
    "head_valve.supply_area" "A_h2" AREA "Area of the head valve's underside outside the seat."
        ["head_valve.outer_diameter", "head_valve.seat_diameter"] |v| v.head_valve.supply_area();
    "head_valve.cylinder_area" "A_h3" AREA "Area of the head valve's underside inside the seat, A_h1 - A_h2."
        ["head_valve.seat_diameter", "head_valve.inner_diameter"] |v| v.head_valve.cylinder_area();
    "exhaust.area" "A_ma" AREA "Area of all exhaust holes." ["exhaust.holes", "exhaust.hole_diameter"]
        |v| v.exhaust.area();
    "trigger.delay" "tau" TIME "Delay of the trigger channel, L_ch/c."
        ["trigger.channel_length", "ambient.temperature"] |v| v.trigger.delay(&v.ambient);
    "trigger.fill_attenuation" "phi_in" NUMBER "Attenuation of the trigger channel at supply pressure (Eq. 4.50)."
        ["trigger.channel_length", "trigger.channel_diameter"]
        |v| v.trigger.attenuation(v.supply.pressure, &v.ambient);
    "trigger.vent_attenuation" "phi_out" NUMBER "Attenuation of the trigger channel at ambient pressure (Eq. 4.50)."
        ["trigger.channel_length", "trigger.channel_diameter"]
        |v| v.trigger.attenuation(v.ambient.pressure, &v.ambient);
    "nail.gap_to_rod" "y_pbin" LENGTH "Piston travel at which the rod strikes the nail's head."
        ["piston.stroke", "piston.rod_protrusion", "nail.feed_height"] |v| v.nail.head_gap(&v.piston);
    "nail.gap_to_wood" "y_pbp" LENGTH "Piston travel at which the nail's tip touches the wood."
        ["piston.stroke", "piston.rod_protrusion", "nail.length", "workpiece.groove"]
        |v| v.nail.tip_gap(&v.piston) + v.workpiece.groove;
    "nail.mass" "M_n" MASS "Mass of the nail."
        ["nail.length", "nail.diameter", "nail.head_diameter", "nail.head_thickness", "nail.density"]
        |v| v.nail.mass();
    "workpiece.mass" "M_w" MASS "Mass of the workpiece."
        ["workpiece.length", "workpiece.width", "workpiece.thickness", "wood.density"]
        |v| v.workpiece.mass(v.wood.density);
    "support.sand.shear_speed" "V_s" VELOCITY "Shear wave speed of the sand, sqrt(G_0/rho)."
        ["support.sand.shear_modulus", "support.sand.density"] |v| v.support.sand.shear_speed();
    "body.barrel_radius" "" LENGTH "Outer radius of the barrel, around bore, sleeve and gap."
        ["piston.bore", "body.sleeve_wall", "body.sleeve_gap", "body.barrel_wall"]
        |v| v.body.barrel_radius(0.5 * v.piston.bore);
    "body.volume" "V" VOLUME "Volume of air that the tool body displaces."
        ["piston.bore", "body.sleeve_gap", "body.cap_radius", "body.handle_radius", "body.magazine_radius",
            "body.nose_width"]
        |v| v.body.volume(v.piston.bore);
    "ambient.density" "rho_0" DENSITY "Density of the air, P_a/(R T_a)."
        ["ambient.pressure", "ambient.gas_constant", "ambient.temperature"] |v| v.ambient.density();
    "ambient.sound_speed" "c_0" VELOCITY "Speed of sound, sqrt(gamma R T_a)."
        ["ambient.heat_capacity_ratio", "ambient.gas_constant", "ambient.temperature"] |v| v.ambient.sound_speed();
}

impl Sand {
    /// Shear wave speed \[m/s\], V_s = sqrt(G_0/rho).
    pub fn shear_speed(&self) -> f64 {
        (self.shear_modulus / self.density).sqrt()
    }
}

impl Body {
    /// Volume of air displaced by barrel, cap, handle, magazine and nose \[m3\], each as a closed solid with its outer
    /// dimensions, given the cylinder's bore \[m\]; arms and overlaps are neglected.
    pub fn volume(&self, bore: f64) -> f64 {
        let cylinder = |radius: f64, height: f64| PI * radius * radius * height;
        cylinder(self.barrel_radius(0.5 * bore), self.barrel_height)
            + cylinder(self.cap_radius, self.cap_height)
            + cylinder(self.handle_radius, self.handle_length)
            + cylinder(self.magazine_radius, self.magazine_height)
            + self.nose_width * self.nose_depth * self.nose_height
    }
}
