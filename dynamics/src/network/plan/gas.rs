//! Constants of volumes, faces and passages.

use super::mechanics::Pair;

/// Constants of a volume.
#[derive(Debug, Clone)]
pub(crate) struct VolumePlan {
    pub(crate) dead: f64,
    pub(crate) wall_area: f64,
    pub(crate) transfer: f64,
    pub(crate) wall_temperature: f64,
    /// Constant temperature of an isothermal volume.
    pub(crate) isothermal: Option<f64>,
    /// Ledger of heat and of the work of its faces (full ledger).
    pub(crate) ledger: Option<VolumeLedger>,
}

/// Positions of a volume's integrals in the state.
#[derive(Debug, Clone, Copy)]
pub(crate) struct VolumeLedger {
    pub(crate) heat: usize,
    pub(crate) work: usize,
}

/// Constants of a face. `area` and `perimeter` include the sign of the push.
#[derive(Debug, Clone)]
pub(crate) struct FacePlan {
    pub(crate) gas: usize,
    /// The volume that presses on it, and the volume that it sweeps.
    pub(crate) pressed: Option<usize>,
    pub(crate) volume: Option<usize>,
    pub(crate) pair: Pair,
    pub(crate) area: f64,
    pub(crate) zero: f64,
    pub(crate) perimeter: f64,
    /// Position of the work on the body, for a face of a volume; a separate one for a face that does not sweep it.
    pub(crate) work: Option<usize>,
}

/// Area of a restriction.
#[derive(Debug, Clone)]
pub(crate) enum AreaPlan {
    /// Constant C A.
    Constant(f64),
    /// Conical seat; `slope` is +-sin th cos th.
    Seat {
        travel: TravelPlan,
        diameter: f64,
        sine: f64,
        slope: f64,
    },
    /// Holes.
    Holes {
        travel: TravelPlan,
        area: f64,
        diameter: Option<f64>,
    },
    /// Area over time.
    Ramp { area: f64, time: f64 },
}

/// Travel that opens a restriction: Y = sign (x - at).
#[derive(Debug, Clone, Copy)]
pub(crate) struct TravelPlan {
    pub(crate) pair: Pair,
    pub(crate) sign: f64,
    pub(crate) at: f64,
    /// Index of this travel among the two of the passage.
    pub(crate) input: usize,
    /// Switch that is on while the restriction is open.
    pub(crate) switch: usize,
}

/// Discharge coefficient.
#[derive(Debug, Clone)]
pub(crate) enum CoefficientPlan {
    Constant(f64),
    Ratio { polynomial: Vec<f64>, from: f64, to: f64 },
}

/// A restriction.
#[derive(Debug, Clone)]
pub(crate) struct RestrictionPlan {
    pub(crate) area: AreaPlan,
    pub(crate) coefficient: CoefficientPlan,
}

impl RestrictionPlan {
    pub(crate) fn travel(&self) -> Option<TravelPlan> {
        match self.area {
            AreaPlan::Seat { travel, .. } | AreaPlan::Holes { travel, .. } => Some(travel),
            AreaPlan::Constant(_) | AreaPlan::Ramp { .. } => None,
        }
    }
}

/// A passage.
#[derive(Debug, Clone)]
pub(crate) struct PassagePlan {
    pub(crate) from: usize,
    pub(crate) to: usize,
    pub(crate) restrictions: Vec<RestrictionPlan>,
    /// Flow function, as an index into [`Plan::airs`].
    pub(crate) air: usize,
    pub(crate) one_way: bool,
    /// Switch that is on while the gate is open.
    pub(crate) gate: Option<usize>,
    /// Switch that is on while the further condition of the gate is satisfied.
    pub(crate) condition: Option<usize>,
    /// Pairs whose travels move its restrictions; if there is only one, the second repeats the first.
    pub(crate) travels: [Option<Pair>; 2],
    /// Positions of the mass and enthalpy flow integrals.
    pub(crate) ledger: Option<FlowLedger>,
    /// Whether a force uses its jet's thrust.
    pub(crate) jet: bool,
    /// Switches of gate, condition and restrictions; the passage is open if all are on.
    pub(crate) switches: Vec<usize>,
    /// Index of the gate's trigger, and whether the passage is open while it is off.
    pub(crate) follows: Option<(usize, bool)>,
    /// Delay of the flow.
    pub(crate) delay: Option<f64>,
    /// Factor of the flow that leaves the first space without delay and discharge coefficient.
    pub(crate) undelayed: Option<f64>,
    /// For a polytropic gas, energy per mass of the gas that leaves the first and the second space, and of inflow.
    pub(crate) weights: Option<[f64; 3]>,
    /// Whether a restriction without area closes it permanently.
    pub(crate) shut: bool,
}

/// Positions of a passage's integrals.
#[derive(Debug, Clone, Copy)]
pub(crate) struct FlowLedger {
    pub(crate) mass: usize,
    pub(crate) enthalpy: usize,
}
