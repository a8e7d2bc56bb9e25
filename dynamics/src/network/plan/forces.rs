//! Compilation of contacts, springs, friction, imposed forces, motors, latches and fasteners.

use super::compiler::Compiler;
use super::mechanics::{
    ContactPlan, FastenerPlan, ForcePlan, FrictionPlan, HoldPlan, MotorPlan, Pair, SpringPlan, StickPlan,
};
use crate::network::assembly::{Base, ContactDamping, ForceLaw, SpringLaw, Stop};
use crate::network::resistance::ShankLaw;

pub(super) fn contacts(c: &mut Compiler<'_>) -> Vec<ContactPlan> {
    let assembly = c.assembly;
    assembly
        .contacts
        .iter()
        .map(|contact| {
            let carries = c.carries(contact.on, contact.against);
            let damped = match contact.damping {
                ContactDamping::Dashpot(d) | ContactDamping::HuntCrossley(d) => d != 0.0 && !carries,
            };
            let on_wood = c
                .driven
                .is_some_and(|body| contact.on == body || contact.against == Base::Body(body));
            // The force of a contact without a dashpot grows from zero.
            let jumps = matches!(contact.damping, ContactDamping::Dashpot(d) if d != 0.0);
            ContactPlan {
                carries,
                landing: (on_wood && jumps && !carries).then(|| [c.switch(), c.switch()]),
                pair: c.pair(contact.on, contact.against),
                side: match contact.stop {
                    Stop::Below => 1.0,
                    Stop::Above => -1.0,
                },
                at: contact.at,
                stiffness: contact.stiffness,
                damping: contact.damping,
                exponent: contact.exponent,
                may_pull: contact.may_pull,
                switch: c.switch(),
                loss: damped.then(|| c.integral(format!("dashpot.{}", contact.name), "J")),
            }
        })
        .collect()
}

pub(super) fn springs(c: &mut Compiler<'_>) -> Vec<SpringPlan> {
    let assembly = c.assembly;
    assembly
        .springs
        .iter()
        .map(|spring| {
            let carries = c.carries(spring.on, spring.against);
            SpringPlan {
                carries,
                pair: c.pair(spring.on, spring.against),
                sign: spring.push.sign(),
                free: spring.free,
                preload: spring.preload,
                law: match &spring.law {
                    SpringLaw::Linear(k) => vec![0.0, *k],
                    SpringLaw::Polynomial(coefficients) => coefficients.clone(),
                },
                damping: spring.damping,
                switch: (spring.unilateral && !carries).then(|| c.switch()),
                limit: spring.limit.filter(|_| !carries),
                loss: (spring.damping != 0.0 && !carries).then(|| c.integral(format!("dashpot.{}", spring.name), "J")),
            }
        })
        .collect()
}

pub(super) fn frictions(c: &mut Compiler<'_>) -> Vec<FrictionPlan> {
    let assembly = c.assembly;
    assembly
        .frictions
        .iter()
        .map(|friction| FrictionPlan {
            pair: c.pair(friction.on, friction.against),
            static_force: friction.static_force,
            sliding_force: friction.sliding_force,
            viscous: friction.viscous,
            width: friction.width,
            stribeck: friction.stribeck,
            stick: friction.stick.map(|(stiffness, damping)| StickPlan {
                stiffness,
                damping,
                switch: c.switch(),
                place: c.memory(1),
            }),
            loss: c.integral(format!("friction.{}", friction.name), "J"),
        })
        .collect()
}

pub(super) fn forces(c: &mut Compiler<'_>) -> Vec<ForcePlan> {
    let assembly = c.assembly;
    assembly
        .forces
        .iter()
        .map(|force| ForcePlan {
            pair: c.pair(force.on, force.against),
            law: force.law.clone(),
            work: match force.law {
                ForceLaw::Constant(_) => None,
                ForceLaw::Table(_) | ForceLaw::Jet { .. } => Some(c.integral(format!("work.{}", force.name), "J")),
            },
        })
        .collect()
}

pub(super) fn motors(c: &mut Compiler<'_>) -> Vec<MotorPlan> {
    let assembly = c.assembly;
    assembly
        .motors
        .iter()
        .map(|motor| MotorPlan {
            pair: c.pair(motor.on, motor.against),
            sign: motor.push.sign(),
            stall: motor.stall,
            free_speed: motor.free_speed,
            switch: c.switch(),
            work: c.integral(format!("work.{}", motor.name), "J"),
        })
        .collect()
}

pub(super) fn holds(c: &mut Compiler<'_>) -> Vec<HoldPlan> {
    let assembly = c.assembly;
    assembly
        .holds
        .iter()
        .map(|hold| HoldPlan {
            pair: c.pair(hold.on, hold.against),
            at: hold.at,
            stiffness: hold.stiffness,
            damping: hold.damping,
            switch: c.switch(),
            place: c.memory(1),
            loss: (hold.damping != 0.0).then(|| c.integral(format!("dashpot.{}", hold.name), "J")),
        })
        .collect()
}

pub(super) fn fasteners(c: &mut Compiler<'_>) -> Vec<FastenerPlan> {
    let assembly = c.assembly;
    assembly
        .fasteners
        .iter()
        .map(|f| FastenerPlan {
            work: match f.into {
                // The material that grips the fastener.
                Base::Body(body) if c.driven == Some(body) => Pair {
                    on: f.driver,
                    against: assembly.bodies.len() + 1,
                },
                into => c.pair(f.driver, into),
            },
            guide: c.pair(f.driver, f.guide),
            stroke: c.pair(f.driver, assembly.bodies[f.driver].parent),
            head_at: f.head_at,
            tip_at: f.tip_at,
            length: f.length,
            mass: f.mass,
            impact: f.impact,
            leaves_unloaded: f.leaves_unloaded,
            law: ShankLaw::of(f),
            reversible: f.reversible,
            head_stiffness: f.seated.head_stiffness,
            unloading: f.seated.unloading,
            guide_friction: f.seated.guide_friction,
            guide_width: f.seated.guide_width,
            head: c.switch(),
            depth: c.switch(),
            deepest: c.memory(2),
            impact_speed: c.memory(1),
            penetration: c.integral(format!("penetration.{}", f.name), "J"),
            guide_loss: (f.seated.guide_friction > 0.0).then(|| c.integral(format!("guide.{}", f.name), "J")),
        })
        .collect()
}
