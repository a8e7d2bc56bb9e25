//! The result of a cycle: histories on a uniform grid, events, outcome, checks and work counters.

use nailnoise_quantities::Check;
use schemars::JsonSchema;
use serde::Serialize;

use crate::network::Effort;
use crate::{EnergyFlow, LogEntry};

/// One nailing cycle.
///
/// Every history has [`len`](Self::len) samples at t = 0, dt, 2 dt, ...; at a discontinuity a sample takes the value
/// after it. Positions and velocities are positive downwards, towards the wood.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct CycleRecord {
    /// dt, interval of the samples \[s\].
    pub sample_interval: f64,
    /// Piston with rod (and nail while it is attached).
    pub piston: Body,
    /// Head valve.
    pub head_valve: Body,
    /// Tool body.
    pub tool: Body,
    /// Workpiece.
    pub workpiece: Body,
    /// Relative motion of parts.
    pub motion: Motion,
    /// Volume 1, above the piston.
    pub above_piston: Volume,
    /// Volume 2, below the piston.
    pub below_piston: Volume,
    /// Return volume r.
    pub return_volume: Volume,
    /// Volume h, above the head valve.
    pub above_valve: Volume,
    /// Supply-side volume ext.
    pub supply: Volume,
    /// Forces between bodies.
    pub forces: Forces,
    /// Flow through the exhaust holes.
    pub exhaust: ExhaustFlow,
    /// Flow through the trigger valve's vent.
    pub vent: VentFlow,
    /// Event times.
    pub events: Events,
    /// Every contact, opening, choking change, reversal and trigger action, and the levels that define the events.
    pub log: Vec<LogEntry>,
    /// Outcome of the shot.
    pub outcome: Outcome,
    /// Figures of the shot.
    pub summary: Summary,
    /// Energy balance of the shot.
    pub energy: EnergyFlow,
    /// Checks of the run, each with its limit.
    pub checks: Vec<Check>,
    /// Work of the integrator.
    pub work: Effort,
}

impl CycleRecord {
    /// Number of samples.
    pub fn len(&self) -> usize {
        self.piston.position.len()
    }

    /// Whether the record is empty; never true of a record from [`simulate`](crate::simulate).
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Time of sample `index` \[s\].
    pub fn time(&self, index: usize) -> f64 {
        index as f64 * self.sample_interval
    }

    /// Whether every check passes.
    pub fn is_certified(&self) -> bool {
        self.checks.iter().all(|check| check.ok)
    }
}

/// Motion of one body.
#[derive(Debug, Clone, Default, PartialEq, Serialize)]
pub struct Body {
    /// y \[m\].
    pub position: Vec<f64>,
    /// v \[m/s\].
    pub velocity: Vec<f64>,
    /// dv/dt \[m/s2\]; excludes the jump at the impact of the rod on the nail.
    pub acceleration: Vec<f64>,
}

/// Relative motion of parts.
#[derive(Debug, Clone, Default, PartialEq, Serialize)]
pub struct Motion {
    /// y_pr = y_p - y_g, piston travel from the stopper \[m\].
    pub piston_travel: Vec<f64>,
    /// s = L_h - y_hr, lift of the head valve \[m\].
    pub valve_lift: Vec<f64>,
    /// z = y_p - y_w - y_pbp, depth of the rod's end, expressed as nail tip depth \[m\].
    pub tip_depth: Vec<f64>,
    /// z_max, largest nail tip depth so far, at least 0 \[m\].
    pub nail_depth: Vec<f64>,
    /// M_p + M_n while the nail is attached to the rod, else M_p \[kg\].
    pub moving_mass: Vec<f64>,
}

/// State of one gas volume.
#[derive(Debug, Clone, Default, PartialEq, Serialize)]
pub struct Volume {
    /// P, absolute \[Pa\].
    pub pressure: Vec<f64>,
    /// T \[K\].
    pub temperature: Vec<f64>,
    /// m \[kg\].
    pub mass: Vec<f64>,
}

/// Forces between bodies \[N\].
///
/// In the equations of motion, M is the moving mass:
/// ```text
/// M_t v_p' = piston_gas - bumper - stopper - penetration - piston_friction - magazine + M_t g
/// M_h v_h' = valve_gas + spring - cap - seat - valve_friction + M_h g
/// M_g v_g' = hand - piston_gas - valve_gas - spring + bumper + stopper + cap + seat + piston_friction + valve_friction
///            + magazine + thrust - nose - guard + M_g g
/// M_w v_w' = penetration + nose + guard - support + M_w g
/// ```
#[derive(Debug, Clone, Default, PartialEq, Serialize)]
pub struct Forces {
    /// F_gp, gas on the piston, down.
    pub piston_gas: Vec<f64>,
    /// F_gh, gas on the head valve, down.
    pub valve_gas: Vec<f64>,
    /// F_b >= 0, piston on the bumper, down on the tool.
    pub bumper: Vec<f64>,
    /// F_st <= 0, piston on the stopper (up on the tool).
    pub stopper: Vec<f64>,
    /// Head valve on the cap, <= 0 (up on the tool).
    pub cap: Vec<f64>,
    /// Head valve on the cylinder's seat, >= 0 (down on the tool).
    pub seat: Vec<f64>,
    /// F_s, closing spring on the valve, down.
    pub spring: Vec<f64>,
    /// F_fp, friction of the piston, up on it when it moves down.
    pub piston_friction: Vec<f64>,
    /// F_fh, friction of the head valve.
    pub valve_friction: Vec<f64>,
    /// F_pen, penetration resistance, up on the rod, down on the workpiece.
    pub penetration: Vec<f64>,
    /// F_n, nose on the workpiece, down on it.
    pub nose: Vec<f64>,
    /// F_e, guard spring on the workpiece, down on it.
    pub guard: Vec<f64>,
    /// F_sup, support on the workpiece, up.
    pub support: Vec<f64>,
    /// Hand on the tool, down; F_hm for a massless hand.
    pub hand: Vec<f64>,
    /// Friction of magazine and guide on the nail driven by the rod, up on it when it moves down.
    pub magazine: Vec<f64>,
    /// Part of the exhaust jets' thrust along y, down on the tool.
    pub thrust: Vec<f64>,
}

/// Flow through the exhaust holes.
#[derive(Debug, Clone, Default, PartialEq, Serialize)]
pub struct ExhaustFlow {
    /// Outward mass flow \[kg/s\]; negative for inflow.
    pub mass_flow: Vec<f64>,
    /// P_m upstream of the holes \[Pa\]; ambient while the exhaust is closed.
    pub plenum_pressure: Vec<f64>,
    /// P_s downstream of the holes \[Pa\]: the pressure in the muffler, or ambient without one.
    pub back_pressure: Vec<f64>,
    /// Stagnation temperature of the outflow, T_1 \[K\].
    pub stagnation_temperature: Vec<f64>,
    /// Whether the holes are choked: P_s/P_m below the critical ratio.
    pub choked: Vec<bool>,
    /// Whether the intake is choked.
    pub intake_choked: Vec<bool>,
    /// Mass flow through the intake into the volume above the piston \[kg/s\].
    pub intake_mass_flow: Vec<f64>,
}

/// Flow through the trigger valve's vent to the atmosphere.
#[derive(Debug, Clone, Default, PartialEq, Serialize)]
pub struct VentFlow {
    /// Outward mass flow \[kg/s\]; negative for inflow.
    pub mass_flow: Vec<f64>,
    /// P_h \[Pa\].
    pub pressure: Vec<f64>,
    /// T_h \[K\].
    pub temperature: Vec<f64>,
}

/// Event times \[s\]; `None` for an event that does not occur.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize, JsonSchema)]
pub struct Events {
    /// Trigger pulled.
    pub t0: Option<f64>,
    /// Head valve lifts by 10 um.
    pub t1: Option<f64>,
    /// P_h has first fallen to P_a + 0.1 (P_sup - P_a).
    pub t2: Option<f64>,
    /// Intake opens.
    pub t3: Option<f64>,
    /// Piston has moved 0.1 mm.
    pub t4: Option<f64>,
    /// Rod meets the nail.
    pub t5: Option<f64>,
    /// Nail's tip meets the wood.
    pub t6: Option<f64>,
    /// Piston at 50.51 mm, down.
    pub t7: Option<f64>,
    /// Piston uncovers the check-ring holes.
    pub t8: Option<f64>,
    /// Piston at rest relative to the workpiece, first time after t6.
    pub t9: Option<f64>,
    /// Piston on the bumper, first time after t9.
    pub t10: Option<f64>,
    /// Piston at rest after t10 (below 0.1 m/s for 2 ms).
    pub t11: Option<f64>,
    /// Trigger valve released, by the rising tool or by the operator.
    pub t12: Option<f64>,
    /// Exhaust opens.
    pub t13: Option<f64>,
    /// Return stroke begins (last time at which |v_pr| is at or below 0.05 m/s).
    pub t14: Option<f64>,
    /// Piston at 50.51 mm, up.
    pub t15: Option<f64>,
    /// Piston on the stopper.
    pub t16: Option<f64>,
    /// Exhaust has ended (P_1 <= 1.02 P_a).
    pub t17: Option<f64>,
    /// Piston at rest after t16 (below 0.1 m/s for 2 ms).
    pub t18: Option<f64>,
}

impl Events {
    /// The times in order, t0 first.
    pub fn to_array(&self) -> [Option<f64>; 19] {
        [
            self.t0, self.t1, self.t2, self.t3, self.t4, self.t5, self.t6, self.t7, self.t8, self.t9, self.t10,
            self.t11, self.t12, self.t13, self.t14, self.t15, self.t16, self.t17, self.t18,
        ]
    }
}

/// Outcome of a shot.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Outcome {
    /// The nail is driven and the piston stops on the wood.
    Drives,
    /// The piston hits the bumper before it stops on the wood, and the head does not end up too deep.
    StrikesBumper,
    /// The piston stops before the nail has reached its full depth.
    Underdriven,
    /// The head of the nail ends up deeper below the surface than the design allows.
    Overdriven,
    /// The head valve does not open the intake.
    DoesNotOpen,
    /// The tool does not rise far enough to release the trigger valve.
    DoesNotRelease,
    /// The trigger valve is released, but the exhaust does not open before the record ends.
    DoesNotExhaust,
}

impl Outcome {
    /// All outcomes.
    pub const ALL: [Self; 7] = [
        Self::Drives,
        Self::StrikesBumper,
        Self::Underdriven,
        Self::Overdriven,
        Self::DoesNotOpen,
        Self::DoesNotRelease,
        Self::DoesNotExhaust,
    ];

    /// Its name in serialised form.
    pub fn name(self) -> &'static str {
        match self {
            Self::Drives => "drives",
            Self::StrikesBumper => "strikes_bumper",
            Self::Underdriven => "underdriven",
            Self::Overdriven => "overdriven",
            Self::DoesNotOpen => "does_not_open",
            Self::DoesNotRelease => "does_not_release",
            Self::DoesNotExhaust => "does_not_exhaust",
        }
    }
}

/// Key figures of a shot (SI); `None` for a phase that does not occur.
#[derive(Debug, Clone, Default, PartialEq, Serialize, JsonSchema)]
pub struct Summary {
    /// Piston speed before the rod hits the nail \[m/s\].
    pub speed_before_impact: Option<f64>,
    /// Piston speed after the rod has hit the nail \[m/s\].
    pub speed_after_impact: Option<f64>,
    /// Mean speed of the piston over the nail's length in the wood, starting at t6 \[m/s\].
    pub mean_drive_speed: Option<f64>,
    /// Time at which the nail reaches its full depth \[s\].
    pub full_penetration: Option<f64>,
    /// Largest nail tip depth z_max \[m\].
    pub penetration: f64,
    /// Depth of the nail's head below the surface, z_max - l_n \[m\]; negative if it protrudes.
    pub head_depth: f64,
    /// Largest penetration resistance \[N\].
    pub peak_penetration_force: f64,
    /// Largest cap force \[N\].
    pub peak_cap_force: f64,
    /// Largest seat force \[N\].
    pub peak_seat_force: f64,
    /// Largest bumper force \[N\].
    pub peak_bumper_force: f64,
    /// Largest stopper force \[N\].
    pub peak_stopper_force: f64,
    /// Largest support force \[N\].
    pub peak_support_force: f64,
    /// Largest nose force \[N\].
    pub peak_nose_force: f64,
    /// Mass that left through the exhaust holes \[kg\].
    pub exhaust_mass: f64,
    /// Mass that left through the trigger vent \[kg\].
    pub vent_mass: f64,
    /// Mass that left through the rod-guide leak \[kg\].
    pub leak_mass: f64,
    /// Mass that entered from the hose \[kg\].
    pub supply_mass: f64,
    /// Fraction of the intake's open time with choked flow \[-\].
    pub intake_choked_fraction: Option<f64>,
    /// Fraction of t13..t17 with P_a/P_1 below the critical ratio \[-\].
    pub exhaust_chamber_choked_fraction: Option<f64>,
    /// Fraction of t13..t17 with P_a/P_m below the critical ratio \[-\].
    pub exhaust_choked_fraction: Option<f64>,
    /// Number of contacts of the head valve with the cap.
    pub cap_contacts: usize,
    /// Number of contacts of the head valve with its seat after leaving it.
    pub seat_contacts: usize,
}
