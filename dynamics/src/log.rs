//! The log of a shot: everything that happens, in order.

use serde::Serialize;

/// Something that begins, ends or crosses a level.
///
/// A rising entry is the beginning: a contact pushes, a passage opens, a flow chokes, a level is exceeded, a motion
/// turns from up to down (y points down). A falling entry is the end.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Serialize)]
#[serde(rename_all = "snake_case")]
#[repr(usize)]
pub enum Crossing {
    /// Head valve's lift above 10 um (t1).
    FirstLift,
    /// P_h above P_a + 0.1 (P_sup - P_a) (t2).
    ControlPressure,
    /// Lift above the intake's lap: the intake is open (t3).
    Intake,
    /// Piston travel above 0.1 mm (t4).
    FirstTravel,
    /// Piston travel beyond the nail's head (t5).
    RodAtNail,
    /// Tip of the nail in the wood (t6).
    TipInWood,
    /// Tip deeper than the nail is long.
    FullDepth,
    /// Piston travel above 50.51 mm, the position mark (t7, t15).
    PositionMark,
    /// Check-ring holes uncovered (t8).
    CheckHoles,
    /// Piston faster down than the workpiece; its fall after t6 is t9.
    Advance,
    /// Piston travel beyond the bumper's face (t10).
    PistonAtBumper,
    /// Piston faster than 0.1 m/s against the tool (t11, t18).
    RestSpeed,
    /// Piston faster than 0.05 m/s against the tool (t14).
    StillSpeed,
    /// Guard spring touches the wood; its fall releases the trigger valve (t12, unless the operator has released it
    /// before).
    Guard,
    /// Nose level below the wood's surface; its rise after t12 is the landing.
    Landing,
    /// Lift above the exhaust's lap: the exhaust is shut (t13 at its fall).
    ExhaustShut,
    /// Piston below the upper stopper (t16 at its fall).
    PistonOffStopper,
    /// P_1 above 1.02 P_a (t17 at its fall).
    ChamberPressure,
    /// Intake unchoked: P_1 above the critical fraction of P_ext, whether or not it is open.
    IntakeUnchoked,
    /// Exhaust choked by the criterion of the thesis, P_a below the critical fraction of P_1, whether or not it is
    /// open.
    ChamberChoked,
    /// Exhaust holes choked: P_a below the critical fraction of P_m.
    HolesChoked,
    /// Reversal of the piston's motion relative to the tool.
    PistonReversal,
    /// Reversal of the head valve's motion relative to the tool.
    ValveReversal,
    /// Reversal of the tool's motion.
    ToolReversal,
    /// Bumper pushes the piston.
    BumperContact,
    /// Upper stopper pushes the piston.
    StopperContact,
    /// Cap pushes the head valve.
    CapContact,
    /// Seat pushes the head valve.
    SeatContact,
    /// Wood pushes the nose.
    NoseContact,
    /// Support pushes the workpiece.
    SupportContact,
    /// Rod drives the nail; its fall is the first reversal of the piston's own motion.
    NailDriven,
    /// Nail moves deeper into the wood; its fall is the deepest point so far.
    Penetration,
    /// Rod presses on the nail in the wood.
    NailContact,
    /// Trigger pulled (t0); its fall is the release by the guard or the operator.
    Trigger,
    /// Channel vents the volume above the head valve.
    Vent,
    /// Channel fills the volume above the head valve.
    Fill,
}

/// Direction of a crossing.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Direction {
    /// It began, or the level was exceeded.
    Rising,
    /// It ended.
    Falling,
}

/// State at an entry, after any changes.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct LogState {
    /// y_pr, piston travel \[m\].
    pub piston_travel: f64,
    /// v_pr, its rate \[m/s\].
    pub piston_velocity: f64,
    /// s, lift of the head valve \[m\].
    pub valve_lift: f64,
    /// ds/dt \[m/s\].
    pub valve_velocity: f64,
    /// y_w - y_g, rise of the nose off the wood \[m\].
    pub tool_rise: f64,
    /// v_g, velocity of the tool, down \[m/s\].
    pub tool_velocity: f64,
    /// z, depth of the rod's end, expressed as nail tip depth \[m\].
    pub tip_depth: f64,
    /// P_1, P_2, P_r, P_h, P_ext \[Pa\].
    pub pressures: [f64; 5],
}

/// An entry of the log.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct LogEntry {
    /// Time \[s\].
    pub time: f64,
    /// What was crossed.
    pub crossing: Crossing,
    /// Which way.
    pub direction: Direction,
    /// State there.
    pub state: LogState,
}

impl LogEntry {
    /// Whether the entry is a beginning.
    pub fn is_rising(&self) -> bool {
        self.direction == Direction::Rising
    }
}

impl Direction {
    pub(crate) fn new(rising: bool) -> Self {
        if rising { Self::Rising } else { Self::Falling }
    }
}

impl Crossing {
    /// Describes the entry in words: `the piston meets the bumper`.
    pub fn describe(self, direction: Direction) -> &'static str {
        let [rising, falling] = self.words();
        match direction {
            Direction::Rising => rising,
            Direction::Falling => falling,
        }
    }

    fn words(self) -> [&'static str; 2] {
        match self {
            Self::FirstLift => [
                "the head valve lifts by 10 um",
                "the head valve is within 10 um of its seat",
            ],
            Self::ControlPressure => ["P_h rises above its opening level", "P_h falls to its opening level"],
            Self::Intake => ["the intake opens", "the intake shuts"],
            Self::FirstTravel => [
                "the piston has moved 0.1 mm",
                "the piston is within 0.1 mm of the stopper",
            ],
            Self::RodAtNail => [
                "the rod passes the nail's place",
                "the rod is back above the nail's place",
            ],
            Self::TipInWood => [
                "the nail's tip meets the wood",
                "the rod's end is above its place at the wood",
            ],
            Self::FullDepth => ["the nail is in to its length", "the rod's end is above full depth"],
            Self::PositionMark => ["the piston passes 50.51 mm down", "the piston passes 50.51 mm up"],
            Self::CheckHoles => ["the check-ring holes are uncovered", "the check-ring holes are covered"],
            Self::Advance => [
                "the piston gains on the workpiece",
                "the piston stops against the workpiece",
            ],
            Self::PistonAtBumper => [
                "the piston is at the bumper's face",
                "the piston is above the bumper's face",
            ],
            Self::RestSpeed => ["the piston is faster than 0.1 m/s", "the piston is slower than 0.1 m/s"],
            Self::StillSpeed => [
                "the piston is faster than 0.05 m/s",
                "the piston is slower than 0.05 m/s",
            ],
            Self::Guard => ["the guard reaches the wood", "the guard leaves the wood"],
            Self::Landing => ["the nose is at the wood", "the nose is above the wood"],
            Self::ExhaustShut => ["the exhaust shuts", "the exhaust opens"],
            Self::PistonOffStopper => [
                "the piston is below the stopper's face",
                "the piston is at the stopper's face",
            ],
            Self::ChamberPressure => ["P_1 rises above 1.02 P_a", "P_1 falls to 1.02 P_a"],
            Self::IntakeUnchoked => [
                "P_1 rises above the intake's critical pressure",
                "P_1 is critical at the intake",
            ],
            Self::ChamberChoked => ["P_1 is critical against the atmosphere", "P_1 is subcritical"],
            Self::HolesChoked => ["the exhaust holes choke", "the exhaust holes unchoke"],
            Self::PistonReversal => ["the piston turns down", "the piston turns up"],
            Self::ValveReversal => ["the head valve turns to its seat", "the head valve turns to the cap"],
            Self::ToolReversal => ["the tool turns down", "the tool turns up"],
            Self::BumperContact => ["the piston meets the bumper", "the piston leaves the bumper"],
            Self::StopperContact => ["the piston meets the stopper", "the piston leaves the stopper"],
            Self::CapContact => ["the head valve meets the cap", "the head valve leaves the cap"],
            Self::SeatContact => ["the head valve meets its seat", "the head valve leaves its seat"],
            Self::NoseContact => ["the nose meets the wood", "the nose leaves the wood"],
            Self::SupportContact => ["the workpiece meets its support", "the workpiece leaves its support"],
            Self::NailDriven => ["the rod strikes the nail", "the rod leaves the nail"],
            Self::Penetration => ["the nail goes deeper", "the nail springs back"],
            Self::NailContact => ["the rod presses on the seated nail", "the rod is off the seated nail"],
            Self::Trigger => ["the trigger is pulled", "the trigger valve is released"],
            Self::Vent => ["the channel vents", "the channel ends to vent"],
            Self::Fill => ["the channel fills", "the channel ends to fill"],
        }
    }
}
