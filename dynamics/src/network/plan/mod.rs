//! The assembly compiled for integration: names become indices, and every kind of block becomes an array of constants.
//!
//! ```text
//! state = [y, v of each body | U of each volume | m of each volume | ledger]
//! ```
//! Bodies, volumes and blocks are in the order of the assembly, which is also the order of summation. The ground is the
//! body after the last; reservoirs follow the volumes in the lists of pressures and temperatures.
//!
//! | part | modules |
//! |---|---|
//! | constants of the blocks | `gas`, `mechanics` |
//! | compilation | `compiler` (positions and indices), `passages` (with faces), `forces` |

mod compiler;
mod forces;
mod gas;
mod mechanics;
mod passages;

use super::assembly::{Assembly, FastenerLaw, Ledger};
use super::drive::{Carrier, Driven};
use super::error::RunError;
use crate::network::gas::Air;
use compiler::{Compiler, LedgerItem};
use nailnoise_penetration::ResistanceLaw;

pub(crate) use gas::{AreaPlan, CoefficientPlan, FacePlan, PassagePlan, RestrictionPlan, VolumeLedger, VolumePlan};
pub(crate) use mechanics::{
    BodyPlan, ContactPlan, FastenerPlan, ForcePlan, FrictionPlan, HoldPlan, MotorPlan, Pair, SpringPlan,
};

/// Fraction of a fastener's length by which its table of resistance may be too short.
const ROUNDING: f64 = 1e-9;

/// A compiled assembly.
#[derive(Debug, Clone)]
pub(crate) struct Plan {
    pub(crate) assembly: Assembly,
    pub(crate) gas_constant: f64,
    pub(crate) gamma: f64,
    pub(crate) cp: f64,
    /// Constant temperature of a polytropic gas.
    pub(crate) temperature: Option<f64>,
    /// Fraction of the work of a volume that its energy loses; 1 unless the gas is polytropic.
    pub(crate) expansion: f64,
    /// Shortest delay of a flow \[s\]; infinite without one.
    pub(crate) shortest_delay: f64,
    pub(crate) airs: Vec<Air>,
    pub(crate) bodies: Vec<BodyPlan>,
    pub(crate) volumes: Vec<VolumePlan>,
    pub(crate) faces: Vec<FacePlan>,
    pub(crate) passages: Vec<PassagePlan>,
    pub(crate) contacts: Vec<ContactPlan>,
    pub(crate) springs: Vec<SpringPlan>,
    pub(crate) frictions: Vec<FrictionPlan>,
    pub(crate) forces: Vec<ForcePlan>,
    pub(crate) motors: Vec<MotorPlan>,
    pub(crate) holds: Vec<HoldPlan>,
    pub(crate) fasteners: Vec<FastenerPlan>,
    /// Switches that mirror the triggers.
    pub(crate) triggers: Vec<usize>,
    /// Number of switches and memories in a mode.
    pub(crate) switches: usize,
    pub(crate) memories: usize,
    /// Positions of the integrals of the heat into all gas, of the impulse on the ground, and of that of external
    /// forces.
    pub(crate) heat: Option<usize>,
    pub(crate) ground_impulse: usize,
    pub(crate) outer_impulse: usize,
    /// The body that an external structure replaces.
    pub(crate) driven: Option<Driven>,
    pub(crate) ledger: Vec<LedgerItem>,
    /// Index of the reservoir `atmosphere` among the pressures.
    pub(crate) atmosphere: usize,
    /// Longest travel among stops and faces, which scales the rounding error of an overlap \[m\].
    pub(crate) reach: f64,
}

impl Plan {
    /// Position of the first internal energy; also the number of positions and velocities.
    pub(crate) fn energy(&self) -> usize {
        2 * self.bodies.len()
    }

    /// Position of the first gas mass.
    pub(crate) fn mass(&self) -> usize {
        self.energy() + self.volumes.len()
    }

    /// Number of states with dynamics.
    pub(crate) fn states(&self) -> usize {
        self.energy() + 2 * self.volumes.len()
    }

    /// Length of the integrated vector.
    pub(crate) fn size(&self) -> usize {
        self.states() + self.ledger.len()
    }

    /// Index of the ground among bodies.
    pub(crate) fn ground(&self) -> usize {
        self.bodies.len()
    }
}

impl Plan {
    /// Compiles an assembly.
    ///
    /// # Errors
    /// [`RunError::Passage`] for a series that no kernel supports; [`RunError::SpringLimit`] for a spring whose law
    /// does not extend to a stop; [`RunError::NoFit`] and [`RunError::TableTooShort`] for a law of resistance.
    pub(crate) fn new(assembly: &Assembly) -> Result<Self, RunError> {
        Self::compile(assembly, None)
    }

    /// Compiles an assembly; an external structure may replace one of its bodies.
    pub(super) fn compile(assembly: &Assembly, driven: Option<usize>) -> Result<Self, RunError> {
        let full = assembly.ledger == Ledger::Full;
        let mut c = Compiler {
            assembly,
            driven,
            states: 2 * (assembly.bodies.len() + assembly.volumes.len()),
            ledger: Vec::new(),
            switches: 0,
            memories: 0,
        };
        let mut airs = vec![Air::new(
            assembly.gas_constant,
            assembly.heat_capacity_ratio,
            assembly.linear_ratio,
        )];
        let contacts = forces::contacts(&mut c);
        let springs = forces::springs(&mut c);
        let passages = passages::passages(&mut c, &mut airs, full)?;
        let balanced = assembly.polytropic.is_none();
        let heat = assembly
            .volumes
            .iter()
            .any(|v| balanced && (v.isothermal || v.wall.is_some_and(|w| w.transfer > 0.0)))
            .then(|| c.integral("heat".to_owned(), "J"));
        let volumes = assembly
            .volumes
            .iter()
            .map(|v| VolumePlan {
                dead: v.dead,
                wall_area: v.wall.map_or(0.0, |w| w.area),
                transfer: v.wall.filter(|_| balanced).map_or(0.0, |w| w.transfer),
                wall_temperature: v.wall.map_or(v.temperature, |w| w.temperature),
                isothermal: (balanced && v.isothermal).then_some(v.temperature),
                ledger: full.then(|| VolumeLedger {
                    heat: c.integral(format!("heat.{}", v.name), "J"),
                    work: c.integral(format!("work.{}", v.name), "J"),
                }),
            })
            .collect();
        let faces = passages::faces(&mut c);
        let frictions = forces::frictions(&mut c);
        let forces = forces::forces(&mut c);
        let motors = forces::motors(&mut c);
        let holds = forces::holds(&mut c);
        let fasteners = forces::fasteners(&mut c);
        let triggers = assembly.triggers.iter().map(|_| c.switch()).collect();
        let ground_impulse = c.integral("impulse.ground".to_owned(), "N s");
        let outer_impulse = c.integral("impulse.outer".to_owned(), "N s");
        let contact = contacts
            .iter()
            .position(|contact| contact.carries)
            .map(Carrier::Contact);
        let spring = springs.iter().position(|spring| spring.carries).map(Carrier::Spring);
        let driven = driven.map(|body| Driven {
            body,
            shown: contact.or(spring),
            work: c.integral(format!("coupling.{}", assembly.bodies[body].name), "J"),
        });
        let bodies = assembly
            .bodies
            .iter()
            .enumerate()
            .map(|(i, b)| BodyPlan {
                parent: c.body(b.parent),
                mass: b.mass,
                gravity: b.gravity,
                fastener: assembly.fasteners.iter().position(|f| f.driver == i),
            })
            .collect();
        let atmosphere = assembly.reservoirs.iter().position(|r| r.name == "atmosphere");
        let stops = assembly.contacts.iter().map(|c| c.at.abs());
        let reach = stops
            .chain(assembly.faces.iter().map(|f| f.zero.abs()))
            .fold(0.0, f64::max);
        let plan = Self {
            gas_constant: assembly.gas_constant,
            gamma: assembly.heat_capacity_ratio,
            cp: airs[0].cp,
            temperature: assembly.polytropic.map(|law| law.temperature),
            expansion: assembly
                .polytropic
                .map_or(1.0, |law| (law.exponent - 1.0) / (assembly.heat_capacity_ratio - 1.0)),
            shortest_delay: passages.iter().filter_map(|p| p.delay).fold(f64::INFINITY, f64::min),
            airs,
            bodies,
            volumes,
            faces,
            passages,
            contacts,
            springs,
            frictions,
            forces,
            motors,
            holds,
            fasteners,
            triggers,
            switches: c.switches,
            memories: c.memories,
            heat,
            ground_impulse,
            outer_impulse,
            driven,
            ledger: c.ledger,
            atmosphere: assembly.volumes.len() + atmosphere.unwrap_or(0),
            reach,
            assembly: assembly.clone(),
        };
        plan.check_springs()?;
        plan.check_fasteners()?;
        Ok(plan)
    }

    /// Rejects laws of resistance that are not given, or not over the length of their fastener.
    fn check_fasteners(&self) -> Result<(), RunError> {
        for described in &self.assembly.fasteners {
            let FastenerLaw::Wood(law) = &described.law else {
                continue;
            };
            match &law.table {
                None if law.wood.penetration_law == ResistanceLaw::Fitted && law.fit.is_none() => {
                    return Err(RunError::NoFit {
                        fastener: described.name.clone(),
                    });
                }
                Some(table) if table.last_depth() < described.length * (1.0 - ROUNDING) => {
                    return Err(RunError::TableTooShort {
                        fastener: described.name.clone(),
                        last: table.last_depth(),
                        length: described.length,
                    });
                }
                _ => {}
            }
        }
        Ok(())
    }

    /// Rejects springs that a stop of the same pair allows to exceed their law.
    fn check_springs(&self) -> Result<(), RunError> {
        for (spring, described) in self.springs.iter().zip(&self.assembly.springs) {
            let Some(limit) = spring.limit else { continue };
            for stop in &self.assembly.contacts {
                let Some((_, at)) = stop.stop_for(described.on, described.against) else {
                    continue;
                };
                let compression = described.compression(at);
                if compression > limit * (1.0 + 1e-12) {
                    return Err(RunError::SpringLimit {
                        spring: described.name.clone(),
                        compression,
                        limit,
                        place: format!("at the stop \"{}\"", stop.name),
                    });
                }
            }
        }
        Ok(())
    }
}
