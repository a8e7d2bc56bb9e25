//! What a shot is computed from: primary quantities of the tool, the nail, the wood and the support, in SI units.
//!
//! Nothing here is derived. Areas, volumes of the nail and block, masses, the channel's delay and attenuation come from
//! [`Geometry`](crate::Geometry). The symbols in the descriptions are those of Nili Ahmadabadi (2016), ch. 4.

use serde::{Deserialize, Serialize};

use crate::prf::{PenetrationLaw, ResistanceLaw};

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
    /// Trigger valve and its channel to the volume above the head valve.
    pub trigger: Trigger,
    /// The nail and where it stands under the rod.
    pub nail: Nail,
    /// The wood block.
    pub wood: Wood,
    /// Bumper, stopper, head-valve, nose and guard contacts.
    pub contacts: Contacts,
    /// The tool's body.
    pub tool: Tool,
    /// The hand that pushes the tool.
    pub hand: Hand,
    /// What the block stands on.
    pub support: Support,
    /// Surrounding air and gravity.
    pub ambient: Ambient,
    /// Which form of the physics is used, and numerical widths.
    pub model: Model,
}

/// Compressed-air supply.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Supply {
    /// P_sup, absolute supply pressure \[Pa\].
    pub pressure: f64,
    /// A_sup, flow area of fitting and hose \[m2\], multiplied by the discharge coefficient of the holes.
    pub hose_area: f64,
}

/// Coulomb friction with a Stribeck fall and a viscous part.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Friction {
    /// F_s, static friction \[N\].
    pub static_force: f64,
    /// F_d, sliding friction \[N\].
    pub sliding_force: f64,
    /// beta, viscous coefficient \[N s/m\].
    pub viscous: f64,
}

/// Piston with its driver rod.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Piston {
    /// M_p, mass of piston and rod \[kg\].
    pub mass: f64,
    /// L, travel from the upper stopper to the bumper \[m\].
    pub stroke: f64,
    /// d_c, bore of the cylinder \[m\].
    pub bore: f64,
    /// Diameter of the driver rod \[m\].
    pub rod_diameter: f64,
    /// Ring friction.
    pub friction: Friction,
}

/// Head valve: a ring that closes the cylinder's top (s = 0) or opens it to the supply (s = L_h).
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct HeadValve {
    /// M_h, mass \[kg\].
    pub mass: f64,
    /// L_h, full lift \[m\].
    pub lift: f64,
    /// Outer diameter of the ring, to which the control volume acts \[m\].
    pub outer_diameter: f64,
    /// Inner diameter of the ring \[m\]; A_h1 = pi/4 (outer^2 - inner^2).
    pub inner_diameter: f64,
    /// Diameter of the seat on the cylinder \[m\]; A_h2 = pi/4 (outer^2 - seat^2).
    pub seat_diameter: f64,
    /// Y_he0, lift at which the intake opens \[m\].
    pub intake_lap: f64,
    /// Y_he1, lift at which the exhaust closes \[m\].
    pub exhaust_lap: f64,
    /// theta_0, seat angle of the intake \[rad\].
    pub intake_angle: f64,
    /// theta_1, seat angle of the exhaust \[rad\].
    pub exhaust_angle: f64,
    /// d_ps, diameter of the exhaust seat \[m\].
    pub exhaust_seat_diameter: f64,
    /// y_sp, compression of the closing spring with the valve closed \[m\].
    pub spring_preload: f64,
    /// Seal friction.
    pub friction: Friction,
}

/// Gas volumes, the holes between them, and their walls.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Chambers {
    /// V_01, dead volume above the piston \[m3\].
    pub above_piston: f64,
    /// V_02, dead volume below the piston on the bumper \[m3\].
    pub below_piston: f64,
    /// V_r, return volume \[m3\].
    pub return_volume: f64,
    /// V_0h, dead volume above the open head valve \[m3\].
    pub above_valve: f64,
    /// V_ext, supply-side volume in handle and jacket \[m3\].
    pub supply_volume: f64,
    /// A_1r, check-ring holes from above the piston to the return volume \[m2\].
    pub check_hole_area: f64,
    /// y_rh, piston travel that uncovers the check-ring holes \[m\].
    pub check_hole_position: f64,
    /// A_2r, holes at the cylinder's foot to the return volume \[m2\].
    pub return_hole_area: f64,
    /// A_lk2, leak from below the piston to the atmosphere \[m2\].
    pub leak_area: f64,
    /// C_d, discharge coefficient of all holes, the exhaust included \[-\].
    pub discharge_coefficient: f64,
    /// h_w, heat transfer to the walls \[W/(m2 K)\].
    pub wall_heat_transfer: f64,
    /// A_w10, wall of the volume above the piston without the cylinder's bore \[m2\].
    pub wall_above_piston: f64,
    /// A_w20, wall of the volume below the piston without the cylinder's bore \[m2\].
    pub wall_below_piston: f64,
    /// A_wr, wall of the return volume \[m2\].
    pub wall_return: f64,
    /// A_wh, wall of the volume above the head valve \[m2\].
    pub wall_above_valve: f64,
    /// A_wx, wall of the supply-side volume \[m2\].
    pub wall_supply: f64,
}

/// Exhaust holes behind the head valve; A_ma = n pi d^2/4.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Exhaust {
    /// Number of holes.
    pub holes: u32,
    /// Diameter of one hole \[m\].
    pub hole_diameter: f64,
    /// Part of the jets' thrust that acts on the tool along y, from -1 (up) to 1 (towards the wood) \[-\]; 0 as
    /// published.
    pub thrust_share: f64,
    /// C A_s, effective area of a muffler behind the holes \[m2\]; none where they open into the atmosphere.
    #[serde(default)]
    pub muffler_area: Option<f64>,
}

/// Trigger valve and its channel to the volume above the head valve.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Trigger {
    /// L_ch, length of the channel \[m\].
    pub channel_length: f64,
    /// D_ch, diameter of the channel \[m\].
    pub channel_diameter: f64,
    /// (C A)_tv, effective area of the vent to the atmosphere \[m2\].
    pub vent_area: f64,
    /// (C A)_tvin, effective area of the fill from the supply \[m2\].
    pub fill_area: f64,
}

/// The nail and where it stands under the rod. Length includes the head.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Nail {
    /// l_n, length with the head \[m\].
    pub length: f64,
    /// D, shank diameter \[m\].
    pub diameter: f64,
    /// Diameter of the head \[m\].
    pub head_diameter: f64,
    /// Thickness of the head \[m\].
    pub head_thickness: f64,
    /// Density of the nail's steel \[kg/m3\].
    pub density: f64,
    /// y_pbin, piston travel to the nail's head \[m\].
    pub head_gap: f64,
    /// y_pbp, piston travel at which the nail's tip touches the wood \[m\]; at least `head_gap`.
    pub tip_gap: f64,
    /// Friction of magazine and guide on the nail while the rod drives it \[N\]; 0 as published.
    pub magazine_friction: f64,
}

/// The wood block.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Wood {
    /// H_M, hardness modulus \[N/m\]; also the stiffness k_w of the wood under the nail's head.
    pub hardness_modulus: f64,
    /// rho_w, density \[kg/m3\].
    pub density: f64,
    /// Length along the grain \[m\].
    pub length: f64,
    /// Width \[m\].
    pub width: f64,
    /// Thickness in the driving direction \[m\].
    pub thickness: f64,
    /// Penetration resistance force law.
    pub law: ResistanceLaw,
    /// C8 v_ref^2, speed term of the solid-wood law at [`REFERENCE_SPEED`](crate::prf::REFERENCE_SPEED) \[m2/s2\];
    /// the other laws do not use it.
    pub speed_term: f64,
    /// C9, slenderness term of the solid-wood law \[-\]; the other laws do not use it.
    pub slenderness_term: f64,
    /// Multiplier on the penetration law \[-\]; 1 is the law as published.
    pub resistance_scale: f64,
    /// Multiplier on the stiffness under the nail's head, k_w = scale H_M \[-\].
    pub head_stiffness_scale: f64,
    /// k_u, unloading stiffness of the seated nail \[N/m\].
    pub unloading_stiffness: f64,
}

/// Bumper, stopper, head-valve, nose and guard contacts.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Contacts {
    /// k_pb, bumper stiffness \[N/m\].
    pub bumper_stiffness: f64,
    /// beta_pb, bumper damping \[N s/m\].
    pub bumper_damping: f64,
    /// k_ps, upper stopper stiffness \[N/m\].
    pub stopper_stiffness: f64,
    /// beta_ps, upper stopper damping \[N s/m\].
    pub stopper_damping: f64,
    /// k_hc1, head valve on the cap \[N/m\].
    pub cap_stiffness: f64,
    /// k_hc2, head valve on the cylinder's seat \[N/m\].
    pub seat_stiffness: f64,
    /// zeta_hc, damping ratio of both head-valve contacts on the valve's mass \[-\].
    pub valve_damping_ratio: f64,
    /// k_wsn, nose on the wood \[N/m\].
    pub nose_stiffness: f64,
    /// zeta_wsn, damping ratio of the nose contact on the tool's mass \[-\].
    pub nose_damping_ratio: f64,
    /// k_sg, guard spring \[N/m\].
    pub guard_stiffness: f64,
    /// y_msg, guard travel: rise of the tool at which the trigger valve is released \[m\].
    pub guard_travel: f64,
}

/// The tool's body.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Tool {
    /// M_g, mass without piston and head valve \[kg\].
    pub mass: f64,
}

/// The hand that pushes the tool.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Hand {
    /// F_hm, constant push towards the wood \[N\].
    pub force: f64,
    /// m_m, mass of hand and arm that moves with the tool through spring and dashpot, pushed by the constant force
    /// \[kg\]; 0 where the force acts on the tool itself, as published.
    pub mass: f64,
    /// k_m, stiffness between this mass and the tool \[N/m\]; unused without it.
    pub stiffness: f64,
    /// c_m, damping between this mass and the tool \[N s/m\]; unused without it.
    pub damping: f64,
}

/// What the block stands on: compression only, F_sup = max(0, k y_w + c v_w) for y_w > 0.
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

/// Surrounding air and gravity.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Ambient {
    /// P_a, absolute pressure \[Pa\].
    pub pressure: f64,
    /// T_a, temperature \[K\].
    pub temperature: f64,
    /// R, specific gas constant \[J/(kg K)\].
    pub gas_constant: f64,
    /// gamma, ratio of specific heats \[-\].
    pub heat_capacity_ratio: f64,
    /// mu, dynamic viscosity \[Pa s\].
    pub viscosity: f64,
    /// g, gravity \[m/s2\].
    pub gravity: f64,
}

/// Which form of one part of the physics is used.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Form {
    /// The corrected form (switch value 1).
    #[default]
    Corrected,
    /// As printed in the thesis (switch value 0).
    Published,
}

/// Which form of the physics is used, and numerical widths.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Model {
    /// `thermo`: mass and energy balances, or the isothermal polytropic gas law (C-02).
    pub gas: Form,
    /// `hvp1`: P_1 acts on the valve's underside, and the valve sweeps all volumes (C-06, C-07).
    pub valve_underside: Form,
    /// `nailmode`: elasto-plastic penetration (C-09).
    pub nail: Form,
    /// `jump`: plastic rod-nail impact (C-08).
    pub impact: Form,
    /// `clampc`: contacts only push (C-13).
    pub contacts: Form,
    /// `bidir`: intake and exhaust flow both ways.
    pub intake: Form,
    /// `delaymode`: the channel delays the switching only (C-04).
    pub delay: Form,
    /// `chcons`: the channel's flow is the same at both ends (C-03).
    pub channel: Form,
    /// `refill`: the hose refills the supply-side volume (C-05).
    pub refill: Form,
    /// alpha, polytropic exponent of the published gas law \[-\].
    pub polytropic: f64,
    /// alpha_in, exponent of inflow in the published gas law \[-\].
    pub polytropic_inflow: f64,
    /// alpha_out, exponent of outflow in the published gas law \[-\].
    pub polytropic_outflow: f64,
    /// v_0, velocity over which friction turns \[m/s\].
    pub friction_velocity: f64,
    /// v_st, Stribeck velocity \[m/s\].
    pub stribeck_velocity: f64,
    /// Relative pressure difference below which an orifice is linearised \[-\] (C-28).
    pub orifice_linear: f64,
}

impl Parameters {
    /// The reference tool: an 80 mm coil nailer driving a 12d nail into pine on the worktable.
    ///
    /// Published where the source (Nili Ahmadabadi 2016) gives a value, engineering estimates elsewhere.
    pub fn n80cb() -> Self {
        Self {
            supply: Supply {
                pressure: 763_200.0,
                hose_area: 1.5e-5,
            },
            piston: Piston {
                mass: 0.131,
                stroke: 0.121_25,
                bore: 0.060,
                rod_diameter: 0.0065,
                friction: Friction {
                    static_force: 21.05,
                    sliding_force: 11.73,
                    viscous: 0.0,
                },
            },
            head_valve: HeadValve {
                mass: 0.06,
                lift: 0.0047,
                outer_diameter: 0.0663,
                inner_diameter: 0.051,
                seat_diameter: 0.064,
                intake_lap: 0.0014,
                exhaust_lap: 0.0012,
                intake_angle: std::f64::consts::FRAC_PI_4,
                exhaust_angle: std::f64::consts::FRAC_PI_4,
                exhaust_seat_diameter: 0.051,
                spring_preload: 0.0003,
                friction: Friction {
                    static_force: 26.36,
                    sliding_force: 17.68,
                    viscous: 0.0,
                },
            },
            chambers: Chambers {
                above_piston: 25e-6,
                below_piston: 15e-6,
                return_volume: 300e-6,
                above_valve: 1.5e-6,
                supply_volume: 1.1e-3,
                check_hole_area: 50e-6,
                check_hole_position: 0.080,
                return_hole_area: 300e-6,
                leak_area: 1e-6,
                discharge_coefficient: 0.82,
                wall_heat_transfer: 200.0,
                wall_above_piston: 0.006,
                wall_below_piston: 0.006,
                wall_return: 0.035,
                wall_above_valve: 0.004,
                wall_supply: 0.070,
            },
            exhaust: Exhaust {
                holes: 5,
                hole_diameter: 0.005_97,
                thrust_share: 0.0,
                muffler_area: None,
            },
            trigger: Trigger {
                channel_length: 0.10,
                channel_diameter: 0.006,
                vent_area: 4.6e-6,
                fill_area: 4.6e-6,
            },
            nail: Nail {
                length: 0.082_55,
                diameter: 0.003_81,
                head_diameter: 0.0076,
                head_thickness: 0.0016,
                density: 7850.0,
                head_gap: 0.0225,
                tip_gap: 0.0265,
                magazine_friction: 0.0,
            },
            wood: Wood {
                hardness_modulus: 383_640.0,
                density: 429.46,
                length: 0.4064,
                width: 0.1524,
                thickness: 0.095_25,
                law: ResistanceLaw::Published(PenetrationLaw::SolidWood),
                speed_term: crate::prf::SPEED_TERM,
                slenderness_term: crate::prf::SLENDERNESS_TERM,
                resistance_scale: 1.0,
                head_stiffness_scale: 1.0,
                unloading_stiffness: 1e7,
            },
            contacts: Contacts {
                bumper_stiffness: 9.8e5,
                bumper_damping: 265.0,
                stopper_stiffness: 1.12e6,
                stopper_damping: 226.0,
                cap_stiffness: 1.1e8,
                seat_stiffness: 2.14e8,
                valve_damping_ratio: 0.10,
                nose_stiffness: 5.1e8,
                nose_damping_ratio: 0.05,
                guard_stiffness: 2970.0,
                guard_travel: 0.015,
            },
            tool: Tool { mass: 4.1 },
            hand: Hand {
                force: 110.0,
                mass: 0.0,
                stiffness: 20e3,
                damping: 150.0,
            },
            support: Support {
                stiffness: 5.1e8,
                damping: SupportDamping::Ratio(0.05),
            },
            ambient: Ambient {
                pressure: 101_325.0,
                temperature: 293.15,
                gas_constant: 287.05,
                heat_capacity_ratio: 1.4,
                viscosity: 1.81e-5,
                gravity: 9.81,
            },
            model: Model::default(),
        }
    }
}

impl Default for Model {
    /// All corrections on.
    fn default() -> Self {
        Self {
            gas: Form::Corrected,
            valve_underside: Form::Corrected,
            nail: Form::Corrected,
            impact: Form::Corrected,
            contacts: Form::Corrected,
            intake: Form::Corrected,
            delay: Form::Corrected,
            channel: Form::Corrected,
            refill: Form::Corrected,
            polytropic: 1.2,
            polytropic_inflow: 1.4,
            polytropic_outflow: 1.0,
            friction_velocity: 1e-3,
            stribeck_velocity: 1e-2,
            orifice_linear: 1e-3,
        }
    }
}
