//! Inputs of the nailing cycle: its parameters, and the settings of its integration.

use nailnoise_dynamics as dynamics;
use nailnoise_dynamics::prf::{PenetrationLaw, ResistanceLaw};
use nailnoise_fem::supports::{RectangularBase, Sand, contact_dashpot};

use crate::design::{self, Design, SupportKind};
use crate::error::Error;

/// How the cycle of a design is integrated and recorded.
pub fn cycle_settings(design: &Design) -> dynamics::Settings {
    let analysis = &design.analysis;
    dynamics::Settings {
        relative_tolerance: analysis.cycle_tolerance,
        sample_interval: analysis.time_step,
        end: analysis.cycle_end,
        tail: analysis.cycle_tail,
        ..dynamics::Settings::default()
    }
}

/// The cycle's parameters of a design.
///
/// # Errors
/// [`Error::Sand`] when the sand's constants are outside the range of the foundation's formulas.
pub fn parameters(design: &Design) -> Result<dynamics::Parameters, Error> {
    Ok(dynamics::Parameters {
        supply: (&design.supply).into(),
        piston: (&design.piston).into(),
        head_valve: (&design.head_valve).into(),
        chambers: (&design.chambers).into(),
        exhaust: (&design.exhaust).into(),
        trigger: (&design.trigger).into(),
        nail: (&design.nail).into(),
        wood: dynamics::Wood::from(&**design),
        contacts: (&design.contacts).into(),
        tool: (&design.tool).into(),
        hand: (&design.hand).into(),
        support: support(design)?,
        ambient: (&design.ambient).into(),
        model: (&design.model).into(),
    })
}

impl From<&design::Supply> for dynamics::Supply {
    fn from(own: &design::Supply) -> Self {
        Self {
            pressure: own.pressure,
            hose_area: own.hose_area,
        }
    }
}

impl From<&design::Piston> for dynamics::Piston {
    fn from(own: &design::Piston) -> Self {
        Self {
            mass: own.mass,
            stroke: own.stroke,
            bore: own.bore,
            rod_diameter: own.rod_diameter,
            friction: (&own.friction).into(),
        }
    }
}

impl From<&design::HeadValve> for dynamics::HeadValve {
    fn from(own: &design::HeadValve) -> Self {
        Self {
            mass: own.mass,
            lift: own.lift,
            outer_diameter: own.outer_diameter,
            inner_diameter: own.inner_diameter,
            seat_diameter: own.seat_diameter,
            intake_lap: own.intake_lap,
            exhaust_lap: own.exhaust_lap,
            intake_angle: own.intake_angle,
            exhaust_angle: own.exhaust_angle,
            exhaust_seat_diameter: own.exhaust_seat_diameter,
            spring_preload: own.spring_preload,
            friction: (&own.friction).into(),
        }
    }
}

impl From<&design::Chambers> for dynamics::Chambers {
    fn from(own: &design::Chambers) -> Self {
        Self {
            above_piston: own.above_piston,
            below_piston: own.below_piston,
            return_volume: own.return_volume,
            above_valve: own.above_valve,
            supply_volume: own.supply_volume,
            check_hole_area: own.check_hole_area,
            check_hole_position: own.check_hole_position,
            return_hole_area: own.return_hole_area,
            leak_area: own.leak_area,
            discharge_coefficient: own.discharge_coefficient,
            wall_heat_transfer: own.wall_heat_transfer,
            wall_above_piston: own.wall_above_piston,
            wall_below_piston: own.wall_below_piston,
            wall_return: own.wall_return,
            wall_above_valve: own.wall_above_valve,
            wall_supply: own.wall_supply,
        }
    }
}

impl From<&design::Exhaust> for dynamics::Exhaust {
    fn from(own: &design::Exhaust) -> Self {
        Self {
            holes: own.holes,
            hole_diameter: own.hole_diameter,
            thrust_share: own.thrust_share,
            muffler_area: (own.muffler.kind != design::MufflerKind::None).then_some(own.muffler.flow_area),
        }
    }
}

impl From<&design::Trigger> for dynamics::Trigger {
    fn from(own: &design::Trigger) -> Self {
        Self {
            channel_length: own.channel_length,
            channel_diameter: own.channel_diameter,
            vent_area: own.vent_area,
            fill_area: own.fill_area,
        }
    }
}

impl From<&design::Nail> for dynamics::Nail {
    fn from(own: &design::Nail) -> Self {
        Self {
            length: own.length,
            diameter: own.diameter,
            head_diameter: own.head_diameter,
            head_thickness: own.head_thickness,
            density: own.density,
            head_gap: own.head_gap,
            tip_gap: own.tip_gap,
            magazine_friction: own.magazine_friction,
        }
    }
}

impl From<&design::Contacts> for dynamics::Contacts {
    fn from(own: &design::Contacts) -> Self {
        Self {
            bumper_stiffness: own.bumper_stiffness,
            bumper_damping: own.bumper_damping,
            stopper_stiffness: own.stopper_stiffness,
            stopper_damping: own.stopper_damping,
            cap_stiffness: own.cap_stiffness,
            seat_stiffness: own.seat_stiffness,
            valve_damping_ratio: own.valve_damping_ratio,
            nose_stiffness: own.nose_stiffness,
            nose_damping_ratio: own.nose_damping_ratio,
            guard_stiffness: own.guard_stiffness,
            guard_travel: own.guard_travel,
        }
    }
}

impl From<&design::Tool> for dynamics::Tool {
    fn from(own: &design::Tool) -> Self {
        Self { mass: own.mass }
    }
}

impl From<&design::Hand> for dynamics::Hand {
    fn from(own: &design::Hand) -> Self {
        Self {
            force: own.force,
            mass: own.mass,
            stiffness: own.stiffness,
            damping: own.damping,
        }
    }
}

impl From<&design::Ambient> for dynamics::Ambient {
    fn from(own: &design::Ambient) -> Self {
        Self {
            pressure: own.pressure,
            temperature: own.temperature,
            gas_constant: own.gas_constant,
            heat_capacity_ratio: own.heat_capacity_ratio,
            viscosity: own.viscosity,
            gravity: own.gravity,
        }
    }
}

impl From<&design::Friction> for dynamics::Friction {
    fn from(own: &design::Friction) -> Self {
        Self {
            static_force: own.static_force,
            sliding_force: own.sliding_force,
            viscous: own.viscous,
        }
    }
}

impl From<&design::Values> for dynamics::Wood {
    fn from(d: &design::Values) -> Self {
        Self {
            hardness_modulus: d.wood.hardness_modulus,
            density: d.wood.density,
            length: d.workpiece.length,
            width: d.workpiece.width,
            thickness: d.workpiece.thickness,
            law: (&d.wood).into(),
            speed_term: d.wood.speed_term,
            slenderness_term: d.wood.slenderness_term,
            resistance_scale: d.wood.resistance_scale,
            head_stiffness_scale: d.wood.head_stiffness_scale,
            unloading_stiffness: d.wood.unloading_stiffness,
        }
    }
}

impl From<&design::Wood> for ResistanceLaw {
    fn from(wood: &design::Wood) -> Self {
        use design::PenetrationLaw as Law;
        Self::Published(match wood.penetration_law {
            Law::Smooth => PenetrationLaw::Smooth,
            Law::Annular => PenetrationLaw::Annular,
            Law::Helical => PenetrationLaw::Helical,
            Law::General => PenetrationLaw::General,
            Law::Reduced1 => PenetrationLaw::Reduced1,
            Law::Reduced2 => PenetrationLaw::Reduced2,
            Law::Reduced3 => PenetrationLaw::Reduced3,
            Law::Reduced4 => PenetrationLaw::Reduced4,
            Law::Reduced5 => PenetrationLaw::Reduced5,
            Law::Reduced6 => PenetrationLaw::Reduced6,
            Law::SolidWood => PenetrationLaw::SolidWood,
            Law::Constant => return Self::Constant(wood.penetration_force),
        })
    }
}

/// The support of the cycle's lumped workpiece: on a floor its contact as one spring and dashpot, on springs their sum, in
/// sand the vertical foundation stiffness K_z and the radiation dashpot rho V_La of the block's base.
fn support(d: &Design) -> Result<dynamics::Support, Error> {
    use dynamics::SupportDamping;
    Ok(match d.support.kind {
        // A block held at its foot is the spring k_ws = E A/L itself.
        SupportKind::Worktable | SupportKind::Clamped => dynamics::Support {
            stiffness: d.support.worktable.stiffness,
            damping: SupportDamping::Ratio(d.support.worktable.damping_ratio),
        },
        SupportKind::Sandbox => {
            let s = &d.support.sand;
            let sand = Sand::new(s.shear_modulus, s.density, s.poisson_ratio)?;
            let base = RectangularBase::new(d.workpiece.length, d.workpiece.width)?;
            dynamics::Support {
                stiffness: base.stiffness(&sand).z,
                damping: SupportDamping::Coefficient(sand.normal_dashpot() * base.area()),
            }
        }
        SupportKind::Springs => {
            let [stiffness, damping] = d.sprung(design::Sprung::Workpiece);
            dynamics::Support {
                stiffness,
                damping: SupportDamping::Coefficient(damping),
            }
        }
        SupportKind::Floor => {
            let c = &d.support.contact;
            let area = d.workpiece.length * d.workpiece.width;
            let dashpot = contact_dashpot(c.stiffness_per_area, c.loss_ratio, c.loss_frequency);
            dynamics::Support {
                stiffness: c.stiffness_per_area * area,
                damping: SupportDamping::Coefficient(dashpot * area),
            }
        }
    })
}

impl From<&design::Model> for dynamics::Model {
    fn from(m: &design::Model) -> Self {
        let form = |form: design::Form| match form {
            design::Form::Corrected => dynamics::Form::Corrected,
            design::Form::Published => dynamics::Form::Published,
        };
        Self {
            gas: form(m.gas),
            valve_underside: form(m.valve_underside),
            nail: form(m.nail),
            impact: form(m.impact),
            contacts: form(m.contacts),
            intake: form(m.intake),
            delay: form(m.delay),
            channel: form(m.channel),
            refill: form(m.refill),
            polytropic: m.polytropic,
            polytropic_inflow: m.polytropic_inflow,
            polytropic_outflow: m.polytropic_outflow,
            friction_velocity: m.friction_velocity,
            stribeck_velocity: m.stribeck_velocity,
            orifice_linear: m.orifice_linear,
        }
    }
}
