//! Inputs of a nailing cycle: primary quantities of the tool, the nail, the wood and the support, in SI units.
//!
//! Nothing here is derived. [`Geometry`](crate::Geometry) gives the areas, the volumes of the nail and block, the
//! masses, and the delay and attenuation of the channel. The symbols are those of Nili Ahmadabadi (2016), ch. 4.

use nailnoise_penetration::fit::FittedLaw;
use nailnoise_penetration::{ForceTable, NailedWood};
use nailnoise_quantities::dimension::*;
use nailnoise_quantities::{
    Group, KeySpec, Kind, Value, any, choice, component, fraction, gas_pressure, group, nonnegative, positive,
};
use serde::{Deserialize, Serialize};

/// One tool, one nail, one block of wood, one hand: all the inputs of a nailing cycle (SI units throughout).
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Parameters {
    /// Compressed-air supply.
    pub supply: Supply,
    /// Piston with its driver rod.
    pub piston: Piston,
    /// Head valve between supply, cylinder and exhaust.
    pub head_valve: HeadValve,
    /// Gas volumes, the holes between them, and their walls.
    pub chambers: Chambers,
    /// Exhaust holes behind the head valve.
    pub exhaust: Exhaust,
    /// C A_s, effective area of a muffler behind the holes \[m2\]; none if they open into the atmosphere.
    pub muffler_area: Option<f64>,
    /// Trigger valve and its channel to the volume above the head valve.
    pub trigger: Trigger,
    /// The nail and its position under the rod.
    pub nail: Nail,
    /// The wood.
    pub wood: NailedWood,
    /// Friction along the shank as a fraction of the resistance at full depth. It affects the resistance outside the
    /// tested sizes of nails.
    pub friction_share: f64,
    /// Penetration resistance by points, instead of the law of the wood.
    pub penetration_table: Option<ForceTable>,
    /// The law of the word `fitted`.
    pub penetration_fit: Option<FittedLaw>,
    /// The wood block.
    pub workpiece: Block,
    /// Bumper, stopper, head-valve, nose and guard contacts.
    pub contacts: Contacts,
    /// The tool's body.
    pub tool: Tool,
    /// The hand that pushes the tool.
    pub hand: Hand,
    /// Support of the block.
    pub support: Support,
    /// Surrounding air and gravity.
    pub ambient: Ambient,
    /// Form of the physics, and numerical widths.
    pub model: Model,
}

impl Parameters {
    /// Calls `f` with the full name, declaration and value of every quantity.
    pub(crate) fn visit(&self, f: &mut dyn FnMut(&str, &'static KeySpec, Value)) {
        self.supply.visit("supply", f);
        self.piston.visit("piston", f);
        self.head_valve.visit("head_valve", f);
        self.chambers.visit("chambers", f);
        self.exhaust.visit("exhaust", f);
        self.trigger.visit("trigger", f);
        self.nail.visit("nail", f);
        self.wood.visit("wood", f);
        self.workpiece.visit("workpiece", f);
        self.contacts.visit("contacts", f);
        self.tool.visit("tool", f);
        self.hand.visit("hand", f);
        self.ambient.visit("ambient", f);
        self.model.visit("model", f);
    }
}

group! {
    /// Compressed-air supply.
    Supply {
        /// Supply pressure, absolute; a unit that ends in g (psig, barg) is a gauge pressure.
        pressure: f64 = gas_pressure(), "P_sup";
        /// Flow area of the hose and its fitting.
        hose_area: f64 = nonnegative(AREA), "A_sup";
        /// Discharge coefficient of hose and fitting; 0 for that of the other passages.
        hose_coefficient: f64 = fraction(), "C_d,sup";
    }
}

group! {
    /// Coulomb friction that falls from its static to its sliding value, and a viscous part.
    Friction {
        /// Static friction.
        static_force: f64 = nonnegative(FORCE), "F_s";
        /// Sliding friction.
        sliding_force: f64 = nonnegative(FORCE), "F_d";
        /// Viscous friction coefficient.
        viscous: f64 = nonnegative(DAMPING), "beta";
    }
}

group! {
    /// Piston with its driver rod.
    Piston {
        /// Mass of piston and rod.
        mass: f64 = positive(MASS), "M_p";
        /// Travel from the upper stopper to the bumper.
        stroke: f64 = positive(LENGTH), "L";
        /// Bore of the cylinder.
        bore: f64 = positive(LENGTH), "d_c";
        /// Diameter of the driver rod.
        rod_diameter: f64 = positive(LENGTH), "d_r";
        /// Length of the driver rod from the piston to its end; used by an elastic blow only.
        rod_length: f64 = positive(LENGTH), "";
        /// Young's modulus of the driver rod and the nail; used by an elastic blow only.
        rod_modulus: f64 = positive(PRESSURE).within(1e9, 1e12), "E";
        /// Length of the rod that stands out of the nose's face when the piston touches the bumper; negative where the
        /// rod ends inside the nose.
        rod_protrusion: f64 = any(LENGTH), "";
    }
    groups {
        friction: Friction,
    }
}

group! {
    /// Head valve: a ring that shuts the cylinder's top, or opens it to the supply and shuts the exhaust.
    HeadValve {
        /// Mass of the valve.
        mass: f64 = positive(MASS), "M_h";
        /// Full lift, from the cylinder's seat to the cap.
        lift: f64 = positive(LENGTH), "L_h";
        /// Outer diameter of the ring; A_h1 = pi/4 (outer^2 - inner^2).
        outer_diameter: f64 = positive(LENGTH), "D_o";
        /// Diameter of the seat on the cylinder; A_h2 = pi/4 (outer^2 - seat^2).
        seat_diameter: f64 = positive(LENGTH), "D_s";
        /// Inner diameter of the ring.
        inner_diameter: f64 = positive(LENGTH), "D_i";
        /// Lift at which the intake opens.
        intake_lap: f64 = nonnegative(LENGTH), "Y_he0";
        /// Lift at which the exhaust shuts; at most the intake's, or air passes from supply to exhaust.
        exhaust_lap: f64 = nonnegative(LENGTH), "Y_he1";
        /// Seat angle of the intake.
        intake_angle: f64 = positive(ANGLE), "theta_0";
        /// Seat angle of the exhaust.
        exhaust_angle: f64 = positive(ANGLE), "theta_1";
        /// Diameter of the exhaust's seat.
        exhaust_seat_diameter: f64 = positive(LENGTH), "d_ps";
        /// Compression of the closing spring with the valve shut.
        spring_preload: f64 = nonnegative(LENGTH), "y_sp";
        /// Multiplier on the force of the closing spring, Eq. 4.60, which is that of one tool.
        spring_scale: f64 = positive(NUMBER).within(1e-3, 1e3), "Fs_scale";
    }
    groups {
        friction: Friction,
    }
}

group! {
    /// Gas volumes, the holes between them, and their walls.
    Chambers {
        /// Dead volume above the piston.
        above_piston: f64 = positive(VOLUME), "V_01";
        /// Dead volume below the piston when it stands on the bumper.
        below_piston: f64 = positive(VOLUME), "V_02";
        /// Return volume around the cylinder.
        return_volume: f64 = positive(VOLUME), "V_r";
        /// Dead volume above the open head valve.
        above_valve: f64 = positive(VOLUME), "V_0h";
        /// Volume on the supply side: handle and cylinder jacket.
        supply_volume: f64 = positive(VOLUME), "V_ext";
        /// Area of the check-ring holes from above the piston to the return volume.
        check_hole_area: f64 = nonnegative(AREA), "A_1r";
        /// Piston travel that uncovers the check-ring holes.
        check_hole_position: f64 = positive(LENGTH), "y_rh";
        /// Area of the open holes at the cylinder's foot to the return volume.
        return_hole_area: f64 = positive(AREA), "A_2r";
        /// Area of the leak past the rod, from below the piston to the atmosphere.
        leak_area: f64 = nonnegative(AREA), "A_lk2";
        /// Discharge coefficient of the passages that have no coefficient of their own.
        discharge_coefficient: f64 = fraction().within(0.01, 1.0), "C_d";
        /// Discharge coefficient of the check-ring holes; 0 for that of the other passages.
        check_hole_coefficient: f64 = fraction(), "C_d,1r";
        /// Discharge coefficient of the holes at the cylinder's foot; 0 for that of the other passages.
        return_hole_coefficient: f64 = fraction(), "C_d,2r";
        /// Discharge coefficient of the leak; 0 for that of the other passages.
        leak_coefficient: f64 = fraction(), "C_d,lk2";
        /// Heat transfer between gas and walls.
        wall_heat_transfer: f64 = nonnegative(HEAT_TRANSFER), "h_w";
        /// Wall of the volume above the piston, without the cylinder's bore.
        wall_above_piston: f64 = nonnegative(AREA), "A_w10";
        /// Wall of the volume below the piston, without the cylinder's bore.
        wall_below_piston: f64 = nonnegative(AREA), "A_w20";
        /// Wall of the return volume.
        wall_return: f64 = nonnegative(AREA), "A_wr";
        /// Wall of the volume above the head valve.
        wall_above_valve: f64 = nonnegative(AREA), "A_wh";
        /// Wall of the supply side.
        wall_supply: f64 = nonnegative(AREA), "A_wx";
    }
}

group! {
    /// Exhaust holes behind the head valve; A_ma = n pi d^2/4.
    Exhaust {
        /// Number of holes.
        holes: u32 = Kind::Count(10_000), "n";
        /// Diameter of one hole.
        hole_diameter: f64 = positive(LENGTH), "d";
        /// Discharge coefficient of the holes, and of the valve's seat before them; 0 in a design for that of the other
        /// passages.
        discharge_coefficient: f64 = fraction(), "C_d";
        /// Part of the jets' thrust that acts on the tool along the driving direction, positive towards the wood.
        thrust_share: f64 = component(), "";
    }
}

group! {
    /// Trigger valve, and the channel from it to the volume above the head valve.
    Trigger {
        /// Length of the channel.
        channel_length: f64 = positive(LENGTH), "L_ch";
        /// Diameter of the channel.
        channel_diameter: f64 = positive(LENGTH), "D_ch";
        /// Effective area, C_d included, of the vent to the atmosphere.
        vent_area: f64 = positive(AREA), "C A_tv";
        /// Effective area, C_d included, of the fill from the supply side.
        fill_area: f64 = positive(AREA), "C A_tvin";
        /// Time from the trigger pull at which the operator releases the trigger valve, if the rising tool has not done
        /// so before; 0 where the rise of the tool by `contacts.guard_travel` is the only release.
        release_after: f64 = nonnegative(TIME), "";
    }
}

group! {
    /// The nail, and where it stands under the rod.
    Nail {
        /// Length with the head.
        length: f64 = positive(LENGTH), "l_n";
        /// Diameter of the shank; for a wire that is not round, of a circle of the same area.
        diameter: f64 = positive(LENGTH), "D";
        /// Number of shanks: 1, or 2 for a staple. Each meets the wood as one nail; their forces act on the nail's
        /// axis.
        legs: u32 = Kind::Count(2), "";
        /// Diameter of the head; of a staple's crown or a T head, that of a circle of the same area.
        head_diameter: f64 = positive(LENGTH), "D_h";
        /// Thickness of the head; of a staple the wire's.
        head_thickness: f64 = positive(LENGTH), "t_h";
        /// Density of the steel.
        density: f64 = positive(DENSITY), "rho_n";
        /// Height of the waiting nail's head above the nose's face. The feed of a coil nailer guides the heads, so that
        /// nails of every length wait with their heads at this height.
        feed_height: f64 = positive(LENGTH), "";
        /// Depth of the head below the wood's surface from which a nail counts as overdriven.
        overdrive_limit: f64 = positive(LENGTH), "";
        /// Factor of a coating on the friction along the shank: 1 for a bright nail, less for a lubricant.
        coating: f64 = positive(NUMBER).within(0.01, 10.0), "q";
        /// Friction of magazine and guide on the nail while the rod drives it.
        magazine_friction: f64 = nonnegative(FORCE), "";
    }
}

group! {
    /// Dimensions of the block of wood.
    Block {
        /// Length, along the grain.
        length: f64 = positive(LENGTH), "L";
        /// Width.
        width: f64 = positive(LENGTH), "W";
        /// Thickness, in the direction of driving.
        thickness: f64 = positive(LENGTH), "H";
        /// Depth of a groove in the top along which the nails are driven; 0 for a plain block. The nose stands beside
        /// it on the top; the nail enters at its bottom.
        groove: f64 = nonnegative(LENGTH), "";
    }
}

group! {
    /// Lumped contacts: springs and dampers that act in compression only.
    Contacts {
        /// Stiffness of the bumper under the piston.
        bumper_stiffness: f64 = positive(STIFFNESS), "k_pb";
        /// Damping of the bumper.
        bumper_damping: f64 = nonnegative(DAMPING), "beta_pb";
        /// Stiffness of the upper stopper.
        stopper_stiffness: f64 = positive(STIFFNESS), "k_ps";
        /// Damping of the upper stopper.
        stopper_damping: f64 = nonnegative(DAMPING), "beta_ps";
        /// Stiffness of the head valve on the cap.
        cap_stiffness: f64 = positive(STIFFNESS).within(1.0, 1e21), "k_hc1";
        /// Stiffness of the head valve on the cylinder's seat.
        seat_stiffness: f64 = positive(STIFFNESS), "k_hc2";
        /// Damping ratio of both head-valve contacts, on the valve's mass.
        valve_damping_ratio: f64 = nonnegative(NUMBER).within(0.0, 10.0), "zeta_hc";
        /// Stiffness of the nose on the wood.
        nose_stiffness: f64 = positive(STIFFNESS), "k_wsn";
        /// Damping ratio of the nose contact, on the tool's mass.
        nose_damping_ratio: f64 = nonnegative(NUMBER).within(0.0, 10.0), "zeta_wsn";
        /// Stiffness of the guard's spring.
        guard_stiffness: f64 = positive(STIFFNESS), "k_sg";
        /// Guard travel: rise of the tool off the wood at which the trigger valve is released.
        guard_travel: f64 = positive(LENGTH), "y_msg";
    }
}

group! {
    /// The tool without its moving parts.
    Tool {
        /// Mass of the tool without piston and head valve.
        mass: f64 = positive(MASS), "M_g";
    }
}

group! {
    /// The hand that holds the tool.
    Hand {
        /// Constant push towards the wood.
        force: f64 = nonnegative(FORCE), "F_hm";
        /// Mass of hand and arm that the push acts on; 0 where it acts on the tool itself.
        mass: f64 = nonnegative(MASS), "m_m";
        /// Stiffness between the hand's mass and the tool; unused without the mass.
        stiffness: f64 = positive(STIFFNESS), "k_m";
        /// Damping between the hand's mass and the tool; unused without the mass.
        damping: f64 = nonnegative(DAMPING), "c_m";
    }
}

group! {
    /// Surrounding air and gravity.
    Ambient {
        /// Absolute pressure.
        pressure: f64 = positive(PRESSURE).within(1e4, 1e6), "P_a";
        /// Temperature.
        temperature: f64 = positive(TEMPERATURE), "T_a";
        /// Specific gas constant of air.
        gas_constant: f64 = positive(GAS_CONSTANT), "R";
        /// Ratio of specific heats.
        heat_capacity_ratio: f64 = positive(NUMBER).within(1.01, 1.7), "gamma";
        /// Dynamic viscosity.
        viscosity: f64 = positive(VISCOSITY), "mu";
        /// Acceleration of gravity.
        gravity: f64 = nonnegative(ACCELERATION), "g";
    }
}

choice! {
    /// Force of the nail on the wood while the rod drives it.
    BlowModel {
        /// That of the cycle, where rod and nail are one rigid mass.
        Rigid = "rigid",
        /// Above 2 kHz that of rod and nail as elastic bars.
        Elastic = "elastic",
    }
}

choice! {
    /// Which form of one part of the physics is used.
    Form {
        /// The corrected form.
        Corrected = "corrected",
        /// As printed in the thesis.
        Published = "published",
    }
}

group! {
    /// Which form of the physics is used, corrected or as published, and widths that smooth it.
    Model {
        /// Gas: balances of mass and energy, or the published isothermal polytropic law.
        gas: Form = Form::KIND, "thermo";
        /// Head valve: the pressure above the piston acts on its underside and it sweeps all volumes, or neither.
        valve_underside: Form = Form::KIND, "hvp1";
        /// Nail: elasto-plastic penetration, or resistance that ends at full depth and at the first reversal.
        nail: Form = Form::KIND, "nailmode";
        /// Rod on nail: a plastic impact that keeps momentum, or a mass that jumps at constant velocity. `blow` selects
        /// elastic bars.
        impact: Form = Form::KIND, "jump";
        /// Blow of the rod on the nail: rigid, or waves in elastic bars.
        blow: BlowModel = BlowModel::KIND, "";
        /// Contacts: compression only, or dampers that may pull.
        contacts: Form = Form::KIND, "clampc";
        /// Intake and exhaust: flow both ways, or one way.
        intake: Form = Form::KIND, "bidir";
        /// Trigger channel: only the switching is delayed, or the flow is.
        delay: Form = Form::KIND, "delaymode";
        /// Trigger channel: the same flow at both ends, or the supply side loses the undelayed one.
        channel: Form = Form::KIND, "chcons";
        /// Supply hose: refills the supply side, or is absent.
        refill: Form = Form::KIND, "refill";
        /// Polytropic exponent of the published gas law.
        polytropic: f64 = positive(NUMBER).within(0.5, 2.0), "alpha";
        /// Exponent of inflow in the published gas law.
        polytropic_inflow: f64 = positive(NUMBER).within(0.5, 2.0), "alpha_in";
        /// Exponent of outflow in the published gas law.
        polytropic_outflow: f64 = positive(NUMBER).within(0.5, 2.0), "alpha_out";
        /// Velocity over which friction turns its sign.
        friction_velocity: f64 = positive(VELOCITY).within(1e-6, 1.0), "v_0";
        /// Velocity over which friction falls from static to sliding.
        stribeck_velocity: f64 = positive(VELOCITY).within(1e-6, 1.0), "v_st";
        /// Relative pressure difference below which an orifice is linearised.
        orifice_linear: f64 = positive(NUMBER).within(1e-6, 0.1), "1 - P_d/P_u";
    }
}

/// Support of the block: compression only, F_sup = max(0, k y_w + c v_w) for y_w > 0.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Support {
    /// k_ws, stiffness \[N/m\].
    pub stiffness: f64,
    /// Damping of the support.
    pub damping: SupportDamping,
}

/// Damping of the support, as a ratio on the block's mass or given directly.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum SupportDamping {
    /// zeta_ws, c = 2 zeta sqrt(k_ws M_w) \[-\] (worktable).
    Ratio(f64),
    /// c itself \[N s/m\] (sandbox: rho V_La A).
    Coefficient(f64),
}
