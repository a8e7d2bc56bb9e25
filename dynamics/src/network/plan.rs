//! The assembly compiled for integration: names become indices, and every kind of block becomes an array of constants.
//!
//! ```text
//! state = [y, v of each body | U of each volume | m of each volume | ledger]
//! ```
//! Bodies, volumes and blocks keep the order of the assembly, which is also the order of summation. The ground is the
//! body after the last; reservoirs follow the volumes in the lists of pressures and temperatures.

use super::assembly::{
    Assembly, Base, Coefficient, Cone, ContactDamping, ForceLaw, Ledger, Opens, PassageLaw, Push, Space, SpringLaw,
    Stop,
};
use super::drive::{Carrier, Driven};
use super::error::RunError;
use super::gas::Air;
use super::resistance::ShankLaw;

/// Two bodies between which a block acts; the ground has the index after the last body.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Pair {
    pub(crate) on: usize,
    pub(crate) against: usize,
}

/// Constants of a body.
#[derive(Debug, Clone)]
pub(crate) struct BodyPlan {
    pub(crate) parent: usize,
    pub(crate) mass: f64,
    pub(crate) gravity: f64,
    /// Index of a fastener that may join the body.
    pub(crate) fastener: Option<usize>,
}

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
    pub(crate) volume: Option<usize>,
    pub(crate) pair: Pair,
    pub(crate) area: f64,
    pub(crate) zero: f64,
    pub(crate) perimeter: f64,
    /// Position of the work on the body, for a face of a volume.
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
    /// Which of the two travels of the passage it is.
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
    /// Whether a restriction without area closes it permanently.
    pub(crate) shut: bool,
}

/// Positions of a passage's integrals.
#[derive(Debug, Clone, Copy)]
pub(crate) struct FlowLedger {
    pub(crate) mass: usize,
    pub(crate) enthalpy: usize,
}

/// A contact.
#[derive(Debug, Clone)]
pub(crate) struct ContactPlan {
    pub(crate) pair: Pair,
    /// u = side (x - at): +1 for a stop below, -1 above.
    pub(crate) side: f64,
    pub(crate) at: f64,
    pub(crate) stiffness: f64,
    pub(crate) damping: ContactDamping,
    pub(crate) exponent: f64,
    pub(crate) may_pull: bool,
    /// Whether it carries a workpiece that an external structure replaces, so that it does not act.
    pub(crate) carries: bool,
    /// For a contact with a dashpot on such a workpiece, switches that are on if it was open at the start of the window
    /// and if it closed in the window; it then stays closed until the end of the window.
    pub(crate) landing: Option<[usize; 2]>,
    pub(crate) switch: usize,
    pub(crate) loss: Option<usize>,
}

/// A spring.
#[derive(Debug, Clone)]
pub(crate) struct SpringPlan {
    pub(crate) pair: Pair,
    pub(crate) sign: f64,
    pub(crate) free: f64,
    pub(crate) preload: f64,
    /// Coefficients of F(e).
    pub(crate) law: Vec<f64>,
    pub(crate) damping: f64,
    /// Switch of a spring that only pushes.
    pub(crate) switch: Option<usize>,
    pub(crate) limit: Option<f64>,
    /// Whether it carries a workpiece that an external structure replaces, so that it does not act.
    pub(crate) carries: bool,
    pub(crate) loss: Option<usize>,
}

/// Friction.
#[derive(Debug, Clone)]
pub(crate) struct FrictionPlan {
    pub(crate) pair: Pair,
    pub(crate) static_force: f64,
    pub(crate) sliding_force: f64,
    pub(crate) viscous: f64,
    pub(crate) width: f64,
    pub(crate) stribeck: f64,
    pub(crate) stick: Option<StickPlan>,
    pub(crate) loss: usize,
}

/// Spring and dashpot that hold a pair while it sticks.
#[derive(Debug, Clone)]
pub(crate) struct StickPlan {
    pub(crate) stiffness: f64,
    pub(crate) damping: f64,
    pub(crate) switch: usize,
    /// Memory of the travel at which it stopped.
    pub(crate) place: usize,
}

/// An imposed force.
#[derive(Debug, Clone)]
pub(crate) struct ForcePlan {
    pub(crate) pair: Pair,
    pub(crate) law: ForceLaw,
    /// Position of its work integral, if the work does not follow from positions.
    pub(crate) work: Option<usize>,
}

/// A motor.
#[derive(Debug, Clone)]
pub(crate) struct MotorPlan {
    pub(crate) pair: Pair,
    pub(crate) sign: f64,
    pub(crate) stall: f64,
    pub(crate) free_speed: f64,
    pub(crate) switch: usize,
    pub(crate) work: usize,
}

/// A latch.
#[derive(Debug, Clone)]
pub(crate) struct HoldPlan {
    pub(crate) pair: Pair,
    pub(crate) at: f64,
    pub(crate) stiffness: f64,
    pub(crate) damping: f64,
    pub(crate) switch: usize,
    /// Memory of the travel at which it caught.
    pub(crate) place: usize,
    pub(crate) loss: Option<usize>,
}

/// A fastener.
#[derive(Debug, Clone)]
pub(crate) struct FastenerPlan {
    /// Driver relative to the workpiece.
    pub(crate) work: Pair,
    /// Driver relative to the guide.
    pub(crate) guide: Pair,
    /// Driver relative to its parent.
    pub(crate) stroke: Pair,
    pub(crate) head_at: f64,
    pub(crate) tip_at: f64,
    pub(crate) length: f64,
    pub(crate) mass: f64,
    pub(crate) impact: bool,
    pub(crate) law: ShankLaw,
    pub(crate) reversible: bool,
    pub(crate) head_stiffness: f64,
    pub(crate) unloading: f64,
    pub(crate) guide_friction: f64,
    pub(crate) guide_width: f64,
    /// Switch of the driver on the head.
    pub(crate) head: usize,
    /// Switch of the fastener in the work.
    pub(crate) depth: usize,
    /// Memory of the deepest depth z*, followed by that of the force f*.
    pub(crate) deepest: usize,
    pub(crate) penetration: usize,
    pub(crate) guide_loss: Option<usize>,
}

/// Name and unit of an integral.
#[derive(Debug, Clone)]
pub(crate) struct LedgerItem {
    pub(crate) name: String,
    pub(crate) unit: &'static str,
}

/// A compiled assembly.
#[derive(Debug, Clone)]
pub(crate) struct Plan {
    pub(crate) assembly: Assembly,
    pub(crate) gas_constant: f64,
    pub(crate) gamma: f64,
    pub(crate) cp: f64,
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

/// Allocates positions of integrals, switches and memories.
struct Compiler<'a> {
    assembly: &'a Assembly,
    /// Body that an external structure replaces.
    driven: Option<usize>,
    states: usize,
    ledger: Vec<LedgerItem>,
    switches: usize,
    memories: usize,
}

impl Compiler<'_> {
    fn integral(&mut self, name: String, unit: &'static str) -> usize {
        self.ledger.push(LedgerItem { name, unit });
        self.states + self.ledger.len() - 1
    }

    fn switch(&mut self) -> usize {
        self.switches += 1;
        self.switches - 1
    }

    fn memory(&mut self, count: usize) -> usize {
        self.memories += count;
        self.memories - count
    }

    fn body(&self, base: Base) -> usize {
        match base {
            Base::Ground => self.assembly.bodies.len(),
            Base::Body(i) => i,
        }
    }

    fn pair(&self, on: usize, against: Base) -> Pair {
        Pair {
            on,
            against: self.body(against),
        }
    }

    /// Whether a block between two bodies carries the driven body.
    fn carries(&self, on: usize, against: Base) -> bool {
        self.driven == Some(on) && against == Base::Ground
    }

    fn gas(&self, space: Space) -> usize {
        match space {
            Space::Volume(i) => i,
            Space::Reservoir(i) => self.assembly.volumes.len() + i,
        }
    }

    fn restrictions(&mut self, passage: &super::assembly::Passage) -> Result<Restrictions, RunError> {
        let count = passage.restrictions.len();
        let refuse = |reason| RunError::Passage {
            name: passage.name.clone(),
            reason,
        };
        if count == 0 || count > 3 {
            return Err(refuse("has no restriction, or more than three in series"));
        }
        let mut found = Restrictions {
            list: Vec::with_capacity(count),
            travels: [None; 2],
        };
        let assembly = self.assembly;
        for restriction in &passage.restrictions {
            let mut travel = |pair: Pair, push: Push, at: f64| {
                let input = match found.travels {
                    [None, _] => 0,
                    [Some(first), _] if first == pair => 0,
                    [Some(_), None] => 1,
                    [_, Some(second)] if second == pair => 1,
                    _ => return Err(refuse("is opened by more than two motions")),
                };
                found.travels[input] = Some(pair);
                Ok(TravelPlan {
                    pair,
                    sign: push.sign(),
                    at,
                    input,
                    switch: self.switch(),
                })
            };
            let constant = match (&restriction.coefficient, restriction.pipe) {
                (Coefficient::Constant(c), None) => Some(*c),
                (Coefficient::Constant(c), Some(pipe)) => {
                    Some(1.0 / (1.0 / (c * c) + pipe.friction * pipe.length / pipe.diameter).sqrt())
                }
                (Coefficient::RatioPolynomial { .. }, _) if count > 1 => {
                    return Err(refuse("has a coefficient over the pressure ratio in a series"));
                }
                (Coefficient::RatioPolynomial { .. }, Some(_)) => {
                    return Err(refuse("has a coefficient over the pressure ratio and a pipe"));
                }
                (Coefficient::RatioPolynomial { .. }, None) => None,
            };
            let area = match restriction.opens {
                Opens::Constant { area } => AreaPlan::Constant(area * constant.unwrap_or(1.0)),
                Opens::Ramp { area, time } if time > 0.0 => AreaPlan::Ramp {
                    area: area * constant.unwrap_or(1.0),
                    time,
                },
                Opens::Ramp { area, .. } => AreaPlan::Constant(area * constant.unwrap_or(1.0)),
                Opens::Seat {
                    body,
                    against,
                    push,
                    at,
                    diameter,
                    angle,
                    cone,
                } => {
                    let (sine, cosine) = angle.sin_cos();
                    let sign = match cone {
                        Cone::Narrows => -1.0,
                        Cone::Widens => 1.0,
                    };
                    AreaPlan::Seat {
                        travel: travel(pair_of(assembly, body, against), push, at)?,
                        diameter,
                        sine,
                        slope: sign * sine * cosine,
                    }
                }
                Opens::Holes {
                    body,
                    against,
                    push,
                    at,
                    area,
                    diameter,
                } => AreaPlan::Holes {
                    travel: travel(pair_of(assembly, body, against), push, at)?,
                    area,
                    diameter,
                },
            };
            let moving = matches!(area, AreaPlan::Seat { .. } | AreaPlan::Holes { .. });
            let coefficient = match &restriction.coefficient {
                Coefficient::Constant(_) if moving => CoefficientPlan::Constant(constant.unwrap_or(1.0)),
                Coefficient::Constant(_) => CoefficientPlan::Constant(1.0),
                Coefficient::RatioPolynomial { coefficients, from, to } => CoefficientPlan::Ratio {
                    polynomial: coefficients.clone(),
                    from: *from,
                    to: *to,
                },
            };
            found.list.push(RestrictionPlan { area, coefficient });
        }
        Ok(found)
    }
}

fn pair_of(assembly: &Assembly, on: usize, against: Base) -> Pair {
    let against = match against {
        Base::Ground => assembly.bodies.len(),
        Base::Body(i) => i,
    };
    Pair { on, against }
}

/// Restrictions of a passage, and the motions that open them.
struct Restrictions {
    list: Vec<RestrictionPlan>,
    travels: [Option<Pair>; 2],
}

impl Plan {
    /// Compiles an assembly.
    ///
    /// # Errors
    /// [`RunError::Passage`] for a series that no kernel supports; [`RunError::SpringLimit`] for a spring whose law
    /// does not extend to a stop.
    pub(crate) fn new(assembly: &Assembly) -> Result<Self, RunError> {
        Self::compile(assembly, None)
    }

    /// Compiles an assembly, of which an external structure may replace a body.
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
        let contacts = contacts(&mut c);
        let springs = springs(&mut c);
        let passages = passages(&mut c, &mut airs, full)?;
        let heat = assembly
            .volumes
            .iter()
            .any(|v| v.isothermal || v.wall.is_some_and(|w| w.transfer > 0.0))
            .then(|| c.integral("heat".to_owned(), "J"));
        let volumes = assembly
            .volumes
            .iter()
            .map(|v| VolumePlan {
                dead: v.dead,
                wall_area: v.wall.map_or(0.0, |w| w.area),
                transfer: v.wall.map_or(0.0, |w| w.transfer),
                wall_temperature: v.wall.map_or(v.temperature, |w| w.temperature),
                isothermal: v.isothermal.then_some(v.temperature),
                ledger: full.then(|| VolumeLedger {
                    heat: c.integral(format!("heat.{}", v.name), "J"),
                    work: c.integral(format!("work.{}", v.name), "J"),
                }),
            })
            .collect();
        let faces = faces(&mut c);
        let frictions = frictions(&mut c);
        let forces = forces(&mut c);
        let motors = motors(&mut c);
        let holds = holds(&mut c);
        let fasteners = fasteners(&mut c);
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
        Ok(plan)
    }

    /// Rejects springs that a stop of the same pair allows to exceed their law.
    fn check_springs(&self) -> Result<(), RunError> {
        for (spring, described) in self.springs.iter().zip(&self.assembly.springs) {
            let Some(limit) = spring.limit else { continue };
            for (contact, stop) in self.contacts.iter().zip(&self.assembly.contacts) {
                let compression = spring.preload - spring.sign * (contact.at - spring.free);
                if contact.pair == spring.pair && compression > limit * (1.0 + 1e-12) {
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

fn contacts(c: &mut Compiler<'_>) -> Vec<ContactPlan> {
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

fn springs(c: &mut Compiler<'_>) -> Vec<SpringPlan> {
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

fn passages(c: &mut Compiler<'_>, airs: &mut Vec<Air>, full: bool) -> Result<Vec<PassagePlan>, RunError> {
    let assembly = c.assembly;
    assembly
        .passages
        .iter()
        .enumerate()
        .map(|(index, passage)| {
            let boundary = matches!(
                (passage.from, passage.to),
                (Space::Volume(_), Space::Reservoir(_)) | (Space::Reservoir(_), Space::Volume(_))
            );
            let air = match passage.law {
                PassageLaw::Nozzle => 0,
                PassageLaw::Iso6358 { critical_ratio } => {
                    airs.push(airs[0].elliptic(critical_ratio));
                    airs.len() - 1
                }
            };
            let restrictions = c.restrictions(passage)?;
            let jet =
                |force: &super::assembly::Force| matches!(force.law, ForceLaw::Jet { passage, .. } if passage == index);
            let shut = |r: &RestrictionPlan| matches!(r.area, AreaPlan::Constant(area) if area <= 0.0);
            let gate = passage.gate.as_ref().map(|_| c.switch());
            let also = passage.gate.as_ref().and_then(|gate| gate.also.as_ref());
            let condition = also.map(|_| c.switch());
            let moving = restrictions.list.iter().filter_map(RestrictionPlan::travel);
            let switches = moving.map(|way| way.switch).chain(gate).chain(condition);
            Ok(PassagePlan {
                switches: switches.collect(),
                shut: restrictions.list.iter().any(shut),
                from: c.gas(passage.from),
                to: c.gas(passage.to),
                restrictions: restrictions.list,
                travels: restrictions.travels,
                air,
                one_way: passage.one_way,
                gate,
                condition,
                ledger: (boundary || full).then(|| FlowLedger {
                    mass: c.integral(format!("mass.{}", passage.name), "kg"),
                    enthalpy: c.integral(format!("enthalpy.{}", passage.name), "J"),
                }),
                jet: assembly.forces.iter().any(jet),
            })
        })
        .collect()
}

fn faces(c: &mut Compiler<'_>) -> Vec<FacePlan> {
    let assembly = c.assembly;
    let mut work = vec![None; assembly.bodies.len()];
    assembly
        .faces
        .iter()
        .map(|face| {
            let volume = match face.gas {
                Space::Volume(i) => Some(i),
                Space::Reservoir(_) => None,
            };
            let place = &mut work[face.body];
            if volume.is_some() && place.is_none() {
                *place = Some(c.integral(format!("work.{}", assembly.bodies[face.body].name), "J"));
            }
            FacePlan {
                gas: c.gas(face.gas),
                volume,
                pair: c.pair(face.body, face.against),
                area: face.push.sign() * face.area,
                zero: face.zero,
                perimeter: face.push.sign() * face.perimeter,
                work: volume.and(*place),
            }
        })
        .collect()
}

fn frictions(c: &mut Compiler<'_>) -> Vec<FrictionPlan> {
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

fn forces(c: &mut Compiler<'_>) -> Vec<ForcePlan> {
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

fn motors(c: &mut Compiler<'_>) -> Vec<MotorPlan> {
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

fn holds(c: &mut Compiler<'_>) -> Vec<HoldPlan> {
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

fn fasteners(c: &mut Compiler<'_>) -> Vec<FastenerPlan> {
    let assembly = c.assembly;
    assembly
        .fasteners
        .iter()
        .map(|f| FastenerPlan {
            work: Pair {
                on: f.driver,
                against: if c.driven == Some(f.into) {
                    // The material that grips the fastener.
                    assembly.bodies.len() + 1
                } else {
                    f.into
                },
            },
            guide: c.pair(f.driver, f.guide),
            stroke: c.pair(f.driver, assembly.bodies[f.driver].parent),
            head_at: f.head_at,
            tip_at: f.tip_at,
            length: f.length,
            mass: f.mass,
            impact: f.impact,
            law: ShankLaw::of(f),
            reversible: f.reversible,
            head_stiffness: f.seated.head_stiffness,
            unloading: f.seated.unloading,
            guide_friction: f.seated.guide_friction,
            guide_width: f.seated.guide_width,
            head: c.switch(),
            depth: c.switch(),
            deepest: c.memory(2),
            penetration: c.integral(format!("penetration.{}", f.name), "J"),
            guide_loss: (f.seated.guide_friction > 0.0).then(|| c.integral(format!("guide.{}", f.name), "J")),
        })
        .collect()
}
