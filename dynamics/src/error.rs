//! Errors of a cycle.

use std::borrow::Cow;

use thiserror::Error;

/// Why a cycle cannot be computed.
#[derive(Debug, Clone, PartialEq, Error)]
#[non_exhaustive]
pub enum CycleError {
    /// A value is not finite or outside its domain.
    #[error("{name} = {value} must be {rule}")]
    Value {
        /// Full name of the quantity in the design (`piston.mass`).
        name: String,
        /// The value found.
        value: f64,
        /// The requirement.
        rule: Cow<'static, str>,
    },
    /// The closing spring would be compressed beyond the range of its published characteristic.
    #[error(
        "head_valve.lift {lift} m + head_valve.spring_preload {preload} m exceeds {limit} m, the range of the spring \
         characteristic (Eq. 4.60); shorten the lift or the preload"
    )]
    SpringRange {
        /// L_h \[m\].
        lift: f64,
        /// y_sp \[m\].
        preload: f64,
        /// Largest compression \[m\].
        limit: f64,
    },
    /// Intake and exhaust would be open at the same time.
    #[error(
        "head_valve.exhaust_lap {exhaust} m exceeds head_valve.intake_lap {intake} m: the supply would blow straight \
         into the exhaust; make the exhaust lap the smaller"
    )]
    LapOverlap {
        /// Y_he1 \[m\].
        exhaust: f64,
        /// Y_he0 \[m\].
        intake: f64,
    },
    /// A diameter that must be smaller than another is not.
    #[error("{inner_name} {inner} m must be smaller than {outer_name} {outer} m")]
    DiameterOrder {
        /// Name of the smaller diameter.
        inner_name: &'static str,
        /// Its value \[m\].
        inner: f64,
        /// Name of the larger diameter.
        outer_name: &'static str,
        /// Its value \[m\].
        outer: f64,
    },
    /// The tip of the waiting nail would protrude from the nose.
    #[error(
        "nail.length {length} m exceeds nail.feed_height {feed_height} m: the nail waits inside the nose; raise \
         nail.feed_height or use a shorter nail"
    )]
    NailBelowNose {
        /// l_n \[m\].
        length: f64,
        /// Height of the head above the nose's face \[m\].
        feed_height: f64,
    },
    /// The head of the waiting nail would be above the end of the rod.
    #[error(
        "nail.feed_height {feed_height} m must be smaller than piston.stroke {stroke} m less piston.rod_protrusion \
         {protrusion} m, where the rod ends before the shot"
    )]
    NailAboveRod {
        /// Height of the head above the nose's face \[m\].
        feed_height: f64,
        /// L \[m\].
        stroke: f64,
        /// Length of the rod beyond the nose's face at the end of the stroke \[m\].
        protrusion: f64,
    },
    /// The nail is longer than the block is thick below its groove.
    #[error(
        "nail.length {length} m exceeds workpiece.thickness less workpiece.groove, {thickness} m; use a shorter nail \
         or a thicker block"
    )]
    NailLongerThanBlock {
        /// l_n \[m\].
        length: f64,
        /// Thickness of the block below its groove \[m\].
        thickness: f64,
    },
    /// The tabulated penetration law ends before the nail does.
    #[error(
        "the table of the penetration law ends at {last} m, the nail is {length} m long; add points up to its length"
    )]
    TableTooShort {
        /// Last depth of the table \[m\].
        last: f64,
        /// Nail length \[m\].
        length: f64,
    },
    /// A fitted law is chosen but not given.
    #[error(
        "wood.penetration_law = \"fitted\" needs a fitted law; name its file in wood.penetration_fit, or choose \
         another law"
    )]
    NoFit,
    /// The impact speed exceeds those of the fitted law's data.
    #[error(
        "the rod strikes the nail at {speed} m/s, and the fitted law holds for {lowest} .. {highest} m/s; add drives \
         at this \
         speed and mass, or fit with --extrapolate to allow it"
    )]
    BeyondFit {
        /// v0 \[m/s\].
        speed: f64,
        /// Lowest \[m/s\].
        lowest: f64,
        /// Highest \[m/s\].
        highest: f64,
    },
    /// The guard spring lifts the tool off the wood before the shot.
    #[error(
        "the tool is not seated: the guard spring carries {guard} N, hand and weight press with {press} N; push harder \
         (hand.force) or shorten contacts.guard_travel"
    )]
    NotSeated {
        /// Force of the guard spring with the nose on the wood \[N\].
        guard: f64,
        /// Hand force and weights \[N\].
        press: f64,
    },
    /// The supply pressure does not press the head valve onto its seat before the shot.
    #[error(
        "the head valve does not close: {force} N on its seat at rest; raise supply.pressure or \
         head_valve.outer_diameter"
    )]
    ValveNotClosed {
        /// F_close \[N\].
        force: f64,
    },
    /// The piston compressed the bumper so far that no volume remains below it.
    #[error(
        "dry fire: at {time} s the piston compresses the bumper by {compression} m, more than the dead volume below it \
         allows ({available} m); the nail or wood does not stop this piston"
    )]
    DryFire {
        /// Time \[s\].
        time: f64,
        /// Bumper compression \[m\].
        compression: f64,
        /// V_02/A_2 \[m\].
        available: f64,
    },
    /// A gas volume or its mass became zero or negative.
    #[error(
        "the {volume} volume collapsed at {time} s (V = {size} m3, m = {mass} kg); check chambers and travel limits"
    )]
    Collapse {
        /// Which volume.
        volume: &'static str,
        /// Time \[s\].
        time: f64,
        /// Its size \[m3\].
        size: f64,
        /// Its mass \[kg\].
        mass: f64,
    },
    /// A contact opens and closes endlessly.
    #[error(
        "chatter: {contact} changed {count} times within {window} s at {time} s, more often than any contact of a \
         nailer \
         vibrates; check its stiffness and damping and the mass behind it"
    )]
    Chatter {
        /// Which contact or switch.
        contact: &'static str,
        /// Changes counted.
        count: usize,
        /// Duration of the counting window \[s\].
        window: f64,
        /// Time \[s\].
        time: f64,
    },
    /// The assembly of the nailer does not accept these values.
    #[error("the assembly `n80cb` refuses these values: {cause}")]
    Assembly {
        /// The report of its reader.
        cause: String,
    },
    /// Cycle and wood do not agree on their forces.
    #[error(
        "the cycle and the wood do not agree on their forces at {time} s: {mismatch} N apart, {limit} N allowed; use a \
         smaller settings.sample_interval (in a design analysis.time_step), or couple one way"
    )]
    Coupling {
        /// Time \[s\].
        time: f64,
        /// Difference of the forces \[N\].
        mismatch: f64,
        /// Largest difference allowed \[N\].
        limit: f64,
    },
    /// The integration could not continue.
    #[error(
        "the integration stopped at {time} s: {cause}; \
         a tolerance ten times smaller or larger (settings.relative_tolerance, in a design analysis.cycle_tolerance) \
         often passes the place; otherwise check the design's ranges"
    )]
    Integration {
        /// Time \[s\].
        time: f64,
        /// The solver's report.
        cause: String,
    },
}
