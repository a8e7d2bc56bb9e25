//! From the design file to the cycle.

use nailnoise_dynamics as dynamics;
use nailnoise_fem::supports::{RectangularBase, Sand};

use crate::design::{self, Design, SupportKind};
use crate::error::Error;

/// Computes the nailing cycle of a design.
///
/// # Errors
/// [`Error::Cycle`] when the design cannot be computed.
pub fn cycle(design: &Design) -> Result<dynamics::CycleRecord, Error> {
    let analysis = &design.analysis;
    let settings = dynamics::Settings {
        relative_tolerance: analysis.cycle_tolerance,
        sample_interval: analysis.time_step,
        end: analysis.cycle_end,
        tail: analysis.cycle_tail,
        ..dynamics::Settings::default()
    };
    Ok(dynamics::simulate(&parameters(design)?, &settings)?)
}

/// The cycle's parameters of a design.
///
/// # Errors
/// [`Error::Sand`] when the sand's constants are outside the range of the foundation's formulas.
pub fn parameters(design: &Design) -> Result<dynamics::Parameters, Error> {
    let d = design;
    Ok(dynamics::Parameters {
        supply: dynamics::Supply {
            pressure: d.supply.pressure,
            hose_area: d.supply.hose_area,
        },
        piston: dynamics::Piston {
            mass: d.piston.mass,
            stroke: d.piston.stroke,
            bore: d.piston.bore,
            rod_diameter: d.piston.rod_diameter,
            friction: friction(&d.piston.friction),
        },
        head_valve: dynamics::HeadValve {
            mass: d.head_valve.mass,
            lift: d.head_valve.lift,
            outer_diameter: d.head_valve.outer_diameter,
            inner_diameter: d.head_valve.inner_diameter,
            seat_diameter: d.head_valve.seat_diameter,
            intake_lap: d.head_valve.intake_lap,
            exhaust_lap: d.head_valve.exhaust_lap,
            intake_angle: d.head_valve.intake_angle,
            exhaust_angle: d.head_valve.exhaust_angle,
            exhaust_seat_diameter: d.head_valve.exhaust_seat_diameter,
            spring_preload: d.head_valve.spring_preload,
            friction: friction(&d.head_valve.friction),
        },
        chambers: dynamics::Chambers {
            above_piston: d.chambers.above_piston,
            below_piston: d.chambers.below_piston,
            return_volume: d.chambers.return_volume,
            above_valve: d.chambers.above_valve,
            supply_volume: d.chambers.supply_volume,
            check_hole_area: d.chambers.check_hole_area,
            check_hole_position: d.chambers.check_hole_position,
            return_hole_area: d.chambers.return_hole_area,
            leak_area: d.chambers.leak_area,
            discharge_coefficient: d.chambers.discharge_coefficient,
            wall_heat_transfer: d.chambers.wall_heat_transfer,
            wall_above_piston: d.chambers.wall_above_piston,
            wall_below_piston: d.chambers.wall_below_piston,
            wall_return: d.chambers.wall_return,
            wall_above_valve: d.chambers.wall_above_valve,
            wall_supply: d.chambers.wall_supply,
        },
        exhaust: dynamics::Exhaust {
            holes: d.exhaust.holes,
            hole_diameter: d.exhaust.hole_diameter,
        },
        trigger: dynamics::Trigger {
            channel_length: d.trigger.channel_length,
            channel_diameter: d.trigger.channel_diameter,
            vent_area: d.trigger.vent_area,
            fill_area: d.trigger.fill_area,
        },
        nail: dynamics::Nail {
            length: d.nail.length,
            diameter: d.nail.diameter,
            head_diameter: d.nail.head_diameter,
            head_thickness: d.nail.head_thickness,
            density: d.nail.density,
            head_gap: d.nail.head_gap,
            tip_gap: d.nail.tip_gap,
        },
        wood: wood(d),
        contacts: dynamics::Contacts {
            bumper_stiffness: d.contacts.bumper_stiffness,
            bumper_damping: d.contacts.bumper_damping,
            stopper_stiffness: d.contacts.stopper_stiffness,
            stopper_damping: d.contacts.stopper_damping,
            cap_stiffness: d.contacts.cap_stiffness,
            seat_stiffness: d.contacts.seat_stiffness,
            valve_damping_ratio: d.contacts.valve_damping_ratio,
            nose_stiffness: d.contacts.nose_stiffness,
            nose_damping_ratio: d.contacts.nose_damping_ratio,
            guard_stiffness: d.contacts.guard_stiffness,
            guard_travel: d.contacts.guard_travel,
        },
        tool: dynamics::Tool { mass: d.tool.mass },
        hand: dynamics::Hand { force: d.hand.force },
        support: support(d)?,
        ambient: dynamics::Ambient {
            pressure: d.ambient.pressure,
            temperature: d.ambient.temperature,
            gas_constant: d.ambient.gas_constant,
            heat_capacity_ratio: d.ambient.heat_capacity_ratio,
            viscosity: d.ambient.viscosity,
            gravity: d.ambient.gravity,
        },
        model: model(&d.model),
    })
}

fn friction(f: &design::Friction) -> dynamics::Friction {
    dynamics::Friction {
        static_force: f.static_force,
        sliding_force: f.sliding_force,
        viscous: f.viscous,
    }
}

fn wood(d: &Design) -> dynamics::Wood {
    use design::PenetrationLaw as Law;
    use dynamics::prf::PenetrationLaw;
    dynamics::Wood {
        hardness_modulus: d.wood.hardness_modulus,
        density: d.wood.density,
        length: d.workpiece.length,
        width: d.workpiece.width,
        thickness: d.workpiece.thickness,
        law: match d.wood.penetration_law {
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
        },
        resistance_scale: d.wood.resistance_scale,
        head_stiffness_scale: d.wood.head_stiffness_scale,
        unloading_stiffness: d.wood.unloading_stiffness,
    }
}

/// The support of the cycle's lumped workpiece. In sand it is the vertical foundation stiffness K_z and the radiation
/// dashpot rho V_La of the block's base.
fn support(d: &Design) -> Result<dynamics::Support, Error> {
    use dynamics::SupportDamping;
    Ok(match d.support.kind {
        SupportKind::Worktable => dynamics::Support {
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
    })
}

fn model(m: &design::Model) -> dynamics::Model {
    let form = |form: design::Form| match form {
        design::Form::Corrected => dynamics::Form::Corrected,
        design::Form::Published => dynamics::Form::Published,
    };
    dynamics::Model {
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
