//! Bodies and the forces between them.

use nailnoise_penetration::fit::FittedLaw;
use nailnoise_penetration::{Driven, Envelope, ForceTable, NailedWood, Shanks, Specimen};
use serde::Serialize;

use super::Base;

/// Direction along the tool's axis.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
pub enum Push {
    /// +y, towards the workpiece.
    Down,
    /// -y.
    Up,
}

impl Push {
    /// +1 for down, -1 for up.
    pub fn sign(self) -> f64 {
        match self {
            Self::Down => 1.0,
            Self::Up => -1.0,
        }
    }
}

/// Rigid body that moves along the axis.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Body {
    /// Name.
    pub name: String,
    /// Reference body of its travel.
    pub parent: Base,
    /// Mass \[kg\].
    pub mass: f64,
    /// State at the start.
    pub start: Start,
    /// Acceleration of gravity on it, along +y \[m/s2\].
    pub gravity: f64,
    /// Characteristic sizes of position and velocity for error control.
    pub weights: Weights,
}

/// State of a body at the start.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub enum Start {
    /// In equilibrium on a contact or a spring.
    RestOn(super::BlockRef),
    /// At a travel from its parent.
    At {
        /// Travel \[m\].
        travel: f64,
        /// Speed relative to the parent \[m/s\].
        speed: f64,
    },
}

/// Characteristic sizes that scale the integration error.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Weights {
    /// Position \[m\].
    pub position: f64,
    /// Velocity \[m/s\].
    pub velocity: f64,
}

/// One-sided contact: overlap u = x - at (stop below) or at - x (stop above), x = y_on - y_against.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Contact {
    /// Name.
    pub name: String,
    /// Index of the body that hits the stop.
    pub on: usize,
    /// Body that carries the stop.
    pub against: Base,
    /// Side of the stop.
    pub stop: Stop,
    /// Position of the stop \[m\].
    pub at: f64,
    /// Stiffness \[N/m^exponent\].
    pub stiffness: f64,
    /// Damping.
    pub damping: ContactDamping,
    /// Exponent of the overlap.
    pub exponent: f64,
    /// Whether the contact may pull.
    pub may_pull: bool,
}

impl Contact {
    /// Side and position \[m\] of this stop for the motion of `body` relative to `base`; `None` if it is between other
    /// bodies. A contact with the two bodies exchanged is the same stop, with side and sign reversed.
    pub fn stop_for(&self, body: usize, base: Base) -> Option<(Stop, f64)> {
        if (self.on, self.against) == (body, base) {
            return Some((self.stop, self.at));
        }
        let opposite = match self.stop {
            Stop::Below => Stop::Above,
            Stop::Above => Stop::Below,
        };
        let is_reversed = (Base::Body(self.on), self.against) == (base, Base::Body(body));
        is_reversed.then_some((opposite, -self.at))
    }
}

/// Side of the stop, seen from the body that hits it.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
pub enum Stop {
    /// The body moves down onto the stop.
    Below,
    /// The body moves up onto the stop.
    Above,
}

/// Damping of a contact.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub enum ContactDamping {
    /// Dashpot \[N s/m\].
    Dashpot(f64),
    /// Hysteresis factor a of Hunt and Crossley \[s/m\]: f = k u^n (1 + 1.5 a u').
    HuntCrossley(f64),
}

/// Spring: e = preload - s (x - free), force s F(e) on `on`.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Spring {
    /// Name.
    pub name: String,
    /// Index of the body it acts on.
    pub on: usize,
    /// Body that carries the reaction.
    pub against: Base,
    /// Direction of the push of a compressed spring on `on`.
    pub push: Push,
    /// Travel at which the deflection equals the preload \[m\].
    pub free: f64,
    /// Compression at `free` \[m\].
    pub preload: f64,
    /// Force law.
    pub law: SpringLaw,
    /// Largest compression of the law \[m\].
    pub limit: Option<f64>,
    /// Whether the spring only pushes.
    pub unilateral: bool,
    /// Dashpot in parallel \[N s/m\].
    pub damping: f64,
}

impl Spring {
    /// Compression at a travel \[m\].
    pub fn compression(&self, travel: f64) -> f64 {
        self.preload - self.push.sign() * (travel - self.free)
    }
}

/// Force of a spring as a function of its compression.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub enum SpringLaw {
    /// Stiffness \[N/m\].
    Linear(f64),
    /// Polynomial sum c_i e^i, N over m.
    Polynomial(Vec<f64>),
}

/// Smooth friction: [F_d + (F_s - F_d) exp(-(v/v_st)^2)] tanh(v/v_0) + beta v.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Friction {
    /// Name.
    pub name: String,
    /// Index of the body it acts on.
    pub on: usize,
    /// Body that carries the reaction.
    pub against: Base,
    /// F_s \[N\].
    pub static_force: f64,
    /// F_d \[N\].
    pub sliding_force: f64,
    /// beta \[N s/m\].
    pub viscous: f64,
    /// v_0 \[m/s\].
    pub width: f64,
    /// v_st \[m/s\].
    pub stribeck: f64,
    /// Stiffness and dashpot that hold the pair while it sticks; `None` for smooth friction.
    pub stick: Option<(f64, f64)>,
}

/// Imposed force or jet thrust, down on `on`.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Force {
    /// Name.
    pub name: String,
    /// Index of the body it acts on.
    pub on: usize,
    /// Body that carries the reaction.
    pub against: Base,
    /// Law.
    pub law: ForceLaw,
}

/// Law of an imposed force.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub enum ForceLaw {
    /// Constant, down \[N\].
    Constant(f64),
    /// (t \[s\], F \[N\]), linear between the points, constant outside.
    Table(Vec<[f64; 2]>),
    /// Share of a passage's jet thrust.
    Jet {
        /// Index of the passage.
        passage: usize,
        /// Share along +y.
        share: f64,
    },
}

/// Motor: f = s stall max(0, 1 - s v/free_speed) while its trigger is on.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Motor {
    /// Name.
    pub name: String,
    /// Index of the body it drives.
    pub on: usize,
    /// Body that carries the reaction.
    pub against: Base,
    /// Direction of the drive.
    pub push: Push,
    /// Force at zero speed \[N\].
    pub stall: f64,
    /// Speed at zero force \[m/s\].
    pub free_speed: f64,
    /// Index of the trigger that runs it.
    pub trigger: usize,
}

/// Latch: a spring and dashpot that hold a body at its position while a trigger is on.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Hold {
    /// Name.
    pub name: String,
    /// Index of the body that it latches.
    pub on: usize,
    /// Body that carries the reaction.
    pub against: Base,
    /// Travel of the latch at the start \[m\].
    pub at: f64,
    /// Stiffness \[N/m\].
    pub stiffness: f64,
    /// Dashpot \[N s/m\].
    pub damping: f64,
    /// Index of the trigger that closes it.
    pub trigger: usize,
}

/// Fastener that a driver hits and pushes into the workpiece.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Fastener {
    /// Name.
    pub name: String,
    /// Index of the driving body.
    pub driver: usize,
    /// Body it enters.
    pub into: Base,
    /// Body that guides it and carries the guide's friction.
    pub guide: Base,
    /// Travel of the driver (relative to its parent) at which it hits the head \[m\].
    pub head_at: f64,
    /// y_driver - y_into at which the tip touches the surface \[m\].
    pub tip_at: f64,
    /// Length l \[m\].
    pub length: f64,
    /// Mass m \[kg\].
    pub mass: f64,
    /// Whether the mass joins the driver in a plastic impact.
    pub impact: bool,
    /// Whether the driver leaves it when the workpiece no longer pushes it back, as unilateral contact requires.
    /// Otherwise the driver leaves it at the driver's reversal, which is the rule of the nailing cycle (Nili Ahmadabadi
    /// 2016, ch. 4).
    pub leaves_unloaded: bool,
    /// Resistance of the workpiece.
    pub law: FastenerLaw,
    /// Whether unloading follows the same curve (published form).
    pub reversible: bool,
    /// Head and unloading.
    pub seated: Seated,
}

/// Resistance F_r(z) of the workpiece, 0 for z <= 0 \[N\].
#[derive(Debug, Clone, PartialEq, Serialize)]
pub enum FastenerLaw {
    /// F_r = H l [p(z/l) + offset]^2 with the polynomial of thesis 4.59.
    SolidWood {
        /// H \[N/m\].
        hardness: f64,
        /// Offset of the bracket.
        offset: f64,
    },
    /// Constant \[N\].
    Constant(f64),
    /// (z \[m\], F \[N\]), linear between the points.
    Table(Vec<[f64; 2]>),
    /// A wood by its properties, with effects of speed, coating and head.
    Wood(Box<WoodLaw>),
}

/// Resistance of a wood by the keys of a design. A formula cannot give tables and fitted laws; they replace `table` and
/// `fit` of a resolved assembly.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct WoodLaw {
    /// The wood. Its stiffnesses under the head and of unloading are not used: [`Seated`] has those of the fastener.
    pub wood: NailedWood,
    /// Tabulated resistance, instead of the law of the wood.
    pub table: Option<ForceTable>,
    /// The law of the word `fitted`.
    pub fit: Option<FittedLaw>,
    /// Diameter of the shank \[m\].
    pub diameter: f64,
    /// Diameter of the head \[m\].
    pub head_diameter: f64,
    /// Mass that drives the fastener, for a fitted law \[kg\].
    pub driving_mass: f64,
    /// Number of shanks.
    pub legs: u32,
    /// Friction along the shank as a fraction of the resistance at full depth.
    pub friction_share: f64,
    /// Factor of a coating on that friction.
    pub coating: f64,
    /// b, deviation of the specimen's s = sqrt(F_r/(H_M l)) from the law.
    pub deviation: f64,
}

impl WoodLaw {
    /// The envelope of the resistance to a fastener.
    pub fn envelope(&self, fastener: &Fastener) -> Envelope {
        let specimen = Specimen {
            length: fastener.length,
            diameter: self.diameter,
            hardness_modulus: self.wood.hardness_modulus,
            density: self.wood.density,
        };
        let driven = Driven {
            wood: &self.wood,
            table: self.table.as_ref(),
            fit: self.fit.as_ref(),
            specimen: &specimen,
            mass: self.driving_mass,
            shanks: Shanks {
                legs: self.legs,
                friction_share: self.friction_share,
                coating: self.coating,
            },
        };
        Envelope::new(&driven, self.head_diameter, !fastener.reversible)
            .with_head_stiffness(fastener.seated.head_stiffness)
            .with_deviation(self.deviation, &specimen)
    }
}

/// Head and unloading of a fastener.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Seated {
    /// k_h, stiffness of the head on the surface \[N/m\].
    pub head_stiffness: f64,
    /// k_u, stiffness of unloading \[N/m\].
    pub unloading: f64,
    /// Friction of the guide on the fastener \[N\].
    pub guide_friction: f64,
    /// v_0 of the guide's friction, F tanh(v/v_0) \[m/s\].
    pub guide_width: f64,
}
