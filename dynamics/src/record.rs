//! The result of a cycle: the record of its network, and the shot in terms of the nailer.

use nailnoise_quantities::Check;
use schemars::JsonSchema;
use serde::Serialize;

use crate::network::{Assembly, Record};
use crate::{EnergyFlow, LogEntry};

/// One nailing cycle: its histories by name, and the shot in terms of the nailer.
///
/// Positions, velocities and forces are positive downwards, towards the wood. The channels are those of the built-in
/// assembly `n80cb` (SI units, absolute pressures), each as `BLOCK.QUANTITY`:
///
/// | channels | blocks |
/// |---|---|
/// | `position`, `velocity`, `acceleration` | bodies `piston`, `head_valve`, `tool`, `workpiece` |
/// | `travel`, `speed` | `piston` from the stopper, y_pr = y_p - y_g, and `head_valve` from the cap |
/// | `piston.moving_mass` | M_p + M_n while the nail is attached to the rod, else M_p |
/// | `valve_lift` | s, lift of the head valve from its seat |
/// | `nail.tip`, `nail.deepest` | depth of the rod's end as nail tip depth; the largest so far, at least 0 |
/// | `pressure`, `temperature`, `mass` | `above_piston`, `below_piston`, `return_volume`, `above_valve`, `supply` |
/// | `mass_flow` | passages `intake`, `exhaust`, `vent` |
/// | `force` | forces between bodies |
/// | `nail.guide_force` | friction of magazine and guide on the nail driven by the rod, up on it when it moves down |
///
/// An acceleration excludes the jump at the impact of the rod on the nail. The openings `exhaust` and `vent` have the
/// flow with the states before and behind it. The forces of blocks that a design switches off are zero.
///
/// In the equations of motion, a name is that of a channel `NAME.force`, with these exceptions: `piston_gas` and
/// `valve_gas` are the channels `piston_gas_force` and `valve_gas_force`, `penetration` is `nail.force`, and `magazine`
/// is `nail.guide_force`. M_t is the moving mass; the other M are the masses of the bodies.
/// ```text
/// M_t v_p' = piston_gas - bumper - stopper - penetration - piston_friction - magazine + M_t g
/// M_h v_h' = valve_gas + spring - cap - seat - valve_friction + M_h g
/// M_g v_g' = hand - piston_gas - valve_gas - spring + bumper + stopper + cap + seat + piston_friction + valve_friction
///            + magazine + thrust - nose - guard + M_g g
/// M_w v_w' = penetration + nose + guard - support + M_w g
/// ```
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct CycleRecord {
    /// The network of blocks that was integrated.
    pub assembly: Assembly,
    /// Its record. The events are t0 to t18.
    pub record: Record,
    /// The shot in terms of the nailer.
    pub figures: NailerFigures,
}

/// A shot in terms of the nailer.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct NailerFigures {
    /// Outcome of the shot.
    pub outcome: Outcome,
    /// Event times.
    pub events: Events,
    /// Figures of the shot.
    pub summary: Summary,
    /// Energy balance of the shot.
    pub energy: EnergyFlow,
    /// Every contact, opening, choking change, reversal and trigger action, and the levels that define the events.
    pub log: Vec<LogEntry>,
    /// Checks of the run, each with its limit.
    pub checks: Vec<Check>,
}

impl CycleRecord {
    /// dt, interval of the samples \[s\].
    pub fn sample_interval(&self) -> f64 {
        self.record.interval.unwrap_or_default()
    }

    /// Number of samples.
    pub fn len(&self) -> usize {
        self.record.len()
    }

    /// Whether the record is empty; never true of a record from [`simulate`](crate::simulate).
    pub fn is_empty(&self) -> bool {
        self.record.is_empty()
    }

    /// Time of sample `index` \[s\].
    pub fn time(&self, index: usize) -> f64 {
        self.record.time(index)
    }

    /// History of a quantity by its name; empty if the record does not have it.
    pub fn history(&self, name: &str) -> &[f64] {
        self.record.history(name)
    }

    /// Whether every check passes.
    pub fn is_certified(&self) -> bool {
        self.figures.checks.iter().all(|check| check.ok)
    }
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
