//! Layout of the state vector: 20 states, followed by the time integrals used to check the run.

/// Number of states with dynamics.
pub(crate) const STATES: usize = 20;
/// Number of integrals.
pub(crate) const INTEGRALS: usize = 25;
/// Length of the integrated vector.
pub(crate) const SIZE: usize = STATES + INTEGRALS;

/// States: positions and velocities of the five bodies.
pub(crate) const BODIES: usize = 5;
pub(crate) const Y_P: usize = 0;
pub(crate) const V_P: usize = 1;
pub(crate) const Y_H: usize = 2;
pub(crate) const V_H: usize = 3;
pub(crate) const Y_G: usize = 4;
pub(crate) const V_G: usize = 5;
pub(crate) const Y_W: usize = 6;
pub(crate) const V_W: usize = 7;
/// The hand's mass; at rest and unused if the hand is only a force.
pub(crate) const Y_M: usize = 8;
pub(crate) const V_M: usize = 9;
/// Internal energies U_1, U_2, U_r, U_h, U_ext.
pub(crate) const ENERGY: usize = 10;
/// Masses m_1, m_2, m_r, m_h, m_ext.
pub(crate) const MASS: usize = 15;

/// Gas volumes, in the order of energies and masses.
pub(crate) const VOLUMES: usize = 5;
/// Volume 1, above the piston.
pub(crate) const ABOVE: usize = 0;
/// Volume 2, below the piston.
pub(crate) const BELOW: usize = 1;
/// Return volume.
pub(crate) const RETURN: usize = 2;
/// Volume above the head valve.
pub(crate) const CONTROL: usize = 3;
/// Supply-side volume.
pub(crate) const SUPPLY: usize = 4;

/// Names of the volumes, for messages.
pub(crate) const VOLUME_NAMES: [&str; VOLUMES] =
    ["above-piston", "below-piston", "return", "above-valve", "supply-side"];

/// Integrals: mass and enthalpy through the four openings to the outside.
pub(crate) const EXHAUST_MASS: usize = STATES;
pub(crate) const VENT_MASS: usize = STATES + 1;
pub(crate) const LEAK_MASS: usize = STATES + 2;
pub(crate) const SUPPLY_MASS: usize = STATES + 3;
pub(crate) const EXHAUST_ENTHALPY: usize = STATES + 4;
pub(crate) const VENT_ENTHALPY: usize = STATES + 5;
pub(crate) const LEAK_ENTHALPY: usize = STATES + 6;
pub(crate) const SUPPLY_ENTHALPY: usize = STATES + 7;
/// Heat from the walls into the gas.
pub(crate) const HEAT: usize = STATES + 8;
/// Work of the gas on piston and valve, the sum of P dV, and the piston's share.
pub(crate) const GAS_WORK: usize = STATES + 9;
pub(crate) const PISTON_WORK: usize = STATES + 10;
/// Work against friction.
pub(crate) const PISTON_FRICTION: usize = STATES + 11;
pub(crate) const VALVE_FRICTION: usize = STATES + 12;
pub(crate) const MAGAZINE_FRICTION: usize = STATES + 13;
/// Work on the wood at the nail.
pub(crate) const PENETRATION: usize = STATES + 14;
/// Work of the dashpots of the six contacts, in the order of `Contact`, and of the hand's dashpot.
pub(crate) const DASHPOTS: usize = STATES + 15;
/// Work on the wood if its motion is prescribed from outside. It uses the place of the lumped support's dashpot, which
/// is then inactive.
pub(crate) const WOOD_WORK: usize = DASHPOTS + 5;
pub(crate) const HAND_DASHPOT: usize = STATES + 21;
/// Work of the exhaust's thrust on the tool.
pub(crate) const THRUST_WORK: usize = STATES + 22;
/// Impulse of the support, and of the other external forces.
pub(crate) const SUPPORT_IMPULSE: usize = STATES + 23;
pub(crate) const OUTER_IMPULSE: usize = STATES + 24;

/// The integrated vector.
pub(crate) type State = [f64; SIZE];
