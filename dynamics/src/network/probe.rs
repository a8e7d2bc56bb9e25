//! Channels and expressions compiled for evaluation: values read from the workspace, and a postfix list of operations.

use super::assembly::{Binary, Channel, Comparison, Condition, Expression, Family, Function, Quantity};
use super::error::RunError;
use super::mode::{Mode, depth};
use super::plan::{Pair, Plan};
use super::rates::Workspace;

/// Largest stack depth of an expression.
const DEPTH: usize = 32;

/// How far a state must be evaluated to obtain a quantity.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) enum Need {
    /// Positions and gas.
    Instant,
    /// Flows as well.
    Flows,
    /// Forces and accelerations as well.
    Forces,
}

/// A quantity in the workspace.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum Probe {
    Travel(Pair),
    Speed(Pair),
    Position(usize),
    Velocity(usize),
    Acceleration(usize),
    MovingMass(usize),
    Pressure(usize),
    Gauge(usize),
    Temperature(usize),
    Mass(usize),
    Volume(usize),
    MassFlow(usize),
    /// Pressure upstream of a restriction of a passage.
    Before(usize, usize),
    /// Pressure downstream of a restriction of a passage.
    Behind(usize, usize),
    /// Temperature of the gas upstream of a passage's flow.
    Upstream(usize),
    /// Whether the last restriction in flow direction is choked.
    Choked(usize),
    /// Whether a restriction is choked for flow towards the second end.
    ChokedAt(usize, usize),
    Overlap(usize),
    Face(usize),
    Contact(usize),
    Spring(usize),
    Friction(usize),
    Imposed(usize),
    Motor(usize),
    Hold(usize),
    Resistance(usize),
    Guide(usize),
    /// Depth of the tip, negative above the surface.
    Tip(usize),
    Depth(usize),
    Deepest(usize),
    Advance(usize),
    On(usize),
}

impl Probe {
    /// The quantity of a channel; none if the block does not have it.
    pub(crate) fn new(plan: &Plan, channel: Channel) -> Option<Self> {
        let i = channel.block.index;
        let parent = || {
            plan.bodies.get(i).map(|body| Pair {
                on: i,
                against: body.parent,
            })
        };
        let volumes = plan.volumes.len();
        let gas = match channel.block.family {
            Family::Volume => Some(i),
            Family::Reservoir => Some(volumes + i),
            _ => None,
        };
        Some(match (channel.block.family, channel.quantity) {
            (Family::Body, Quantity::Travel) => Self::Travel(parent()?),
            (Family::Body, Quantity::Speed) => Self::Speed(parent()?),
            (Family::Body, Quantity::Position) => Self::Position(i),
            (Family::Body, Quantity::Velocity) => Self::Velocity(i),
            (Family::Body, Quantity::Acceleration) => Self::Acceleration(i),
            (Family::Body, Quantity::MovingMass) => Self::MovingMass(i),
            (Family::Volume | Family::Reservoir, Quantity::Pressure) => Self::Pressure(gas?),
            (Family::Volume | Family::Reservoir, Quantity::Gauge) => Self::Gauge(gas?),
            (Family::Volume | Family::Reservoir, Quantity::Temperature) => Self::Temperature(gas?),
            (Family::Volume, Quantity::Mass) => Self::Mass(i),
            (Family::Volume, Quantity::Volume) => Self::Volume(i),
            (Family::Passage, Quantity::MassFlow) => Self::MassFlow(i),
            (Family::Passage, Quantity::Plenum) => {
                Self::Before(i, plan.passages.get(i)?.restrictions.len().saturating_sub(1))
            }
            (Family::Passage, Quantity::Choked) => Self::Choked(i),
            (Family::Contact, Quantity::Overlap) => Self::Overlap(i),
            (Family::Face, Quantity::Force) => Self::Face(i),
            (Family::Contact, Quantity::Force) => Self::Contact(i),
            (Family::Spring, Quantity::Force) => Self::Spring(i),
            (Family::Friction, Quantity::Force) => Self::Friction(i),
            (Family::Force, Quantity::Force) => Self::Imposed(i),
            (Family::Motor, Quantity::Force) => Self::Motor(i),
            (Family::Hold, Quantity::Force) => Self::Hold(i),
            (Family::Fastener, Quantity::Force) => Self::Resistance(i),
            (Family::Fastener, Quantity::GuideForce) => Self::Guide(i),
            (Family::Fastener, Quantity::Depth) => Self::Depth(i),
            (Family::Fastener, Quantity::Tip) => Self::Tip(i),
            (Family::Fastener, Quantity::Deepest) => Self::Deepest(i),
            (Family::Fastener, Quantity::Advance) => Self::Advance(i),
            (Family::Trigger, Quantity::On) => Self::On(*plan.triggers.get(i)?),
            _ => return None,
        })
    }

    pub(crate) fn need(self) -> Need {
        match self {
            Self::MassFlow(_) | Self::Before(..) | Self::Behind(..) | Self::Upstream(_) | Self::Choked(_) => {
                Need::Flows
            }
            Self::Acceleration(_)
            | Self::Contact(_)
            | Self::Spring(_)
            | Self::Friction(_)
            | Self::Imposed(_)
            | Self::Motor(_)
            | Self::Hold(_)
            | Self::Resistance(_)
            | Self::Guide(_) => Need::Forces,
            _ => Need::Instant,
        }
    }

    /// The passage whose flow it needs.
    pub(crate) fn passage(self) -> Option<usize> {
        match self {
            Self::MassFlow(i) | Self::Upstream(i) | Self::Choked(i) => Some(i),
            Self::Before(i, _) | Self::Behind(i, _) | Self::ChokedAt(i, _) => Some(i),
            _ => None,
        }
    }

    /// Its value for an evaluated state.
    #[inline]
    pub(crate) fn value(self, plan: &Plan, mode: &Mode, w: &Workspace) -> f64 {
        match self {
            Self::Travel(pair) => w.travel(pair),
            Self::Speed(pair) => w.speed(pair),
            Self::Position(i) => w.position[i],
            Self::Velocity(i) => w.velocity[i],
            Self::Acceleration(i) => w.acceleration[i],
            Self::MovingMass(i) => plan.moving_mass(i, mode),
            Self::Pressure(i) => w.pressure[i],
            Self::Gauge(i) => w.pressure[i] - w.pressure[plan.atmosphere],
            Self::Temperature(i) => w.temperature[i],
            Self::Mass(i) => w.mass[i],
            Self::Volume(i) => w.volume[i],
            Self::MassFlow(i) => w.flow[i].mass,
            Self::Before(i, restriction) => plan.around(i, restriction, w)[0],
            Self::Behind(i, restriction) => plan.around(i, restriction, w)[1],
            Self::Upstream(i) => {
                let passage = &plan.passages[i];
                let forward = w.flow[i].mass >= 0.0;
                w.temperature[if forward { passage.from } else { passage.to }]
            }
            Self::Choked(i) => f64::from(u8::from(plan.is_choked(i, mode, w))),
            Self::ChokedAt(i, restriction) => {
                let around = plan.around(i, restriction, w);
                f64::from(u8::from(plan.is_choked_by(i, around, mode)))
            }
            Self::Overlap(i) => {
                let contact = &plan.contacts[i];
                contact.overlap(w.travel(contact.pair), 0.0).0
            }
            Self::Face(i) => w.pressure[plan.faces[i].gas] * plan.faces[i].area,
            Self::Contact(i) => plan.contacts[i].side * w.contact[i].force,
            Self::Spring(i) => w.spring[i].force,
            Self::Friction(i) => w.friction[i].force,
            Self::Imposed(i) => w.imposed[i],
            Self::Motor(i) => w.motor[i],
            Self::Hold(i) => w.hold[i].force,
            Self::Resistance(i) => w.fastener[i][0],
            Self::Guide(i) => w.fastener[i][1],
            Self::Tip(i) => plan.depth(i, w),
            Self::Depth(i) => plan.depth(i, w).max(0.0),
            Self::Deepest(i) => plan.deepest(i, mode, w),
            Self::Advance(i) => w.speed(plan.fasteners[i].work),
            Self::On(switch) => f64::from(mode.switches[switch]),
        }
    }
}

impl Plan {
    /// z of a fastener's tip.
    pub(crate) fn depth(&self, fastener: usize, w: &Workspace) -> f64 {
        let fastener = &self.fasteners[fastener];
        w.travel(fastener.work) - fastener.tip_at
    }

    /// Deepest z so far, at least 0.
    pub(crate) fn deepest(&self, fastener: usize, mode: &Mode, w: &Workspace) -> f64 {
        let plan = &self.fasteners[fastener];
        match mode.switches[plan.depth] {
            depth::LOADING | depth::SEATED => self.depth(fastener, w).max(0.0),
            _ => mode.memory[plan.deepest],
        }
    }

    /// Pressures upstream and downstream of a restriction; requires flows.
    pub(crate) fn around(&self, passage: usize, restriction: usize, w: &Workspace) -> [f64; 2] {
        self.passages[passage].pressures_at(restriction, &self.ends(passage, w), &w.flow[passage])
    }

    /// Whether pressures before and behind a restriction of a passage choke its flow.
    pub(crate) fn is_choked_by(&self, passage: usize, [before, behind]: [f64; 2], mode: &Mode) -> bool {
        let plan = &self.passages[passage];
        plan.is_open(mode) && behind < self.airs[plan.air].critical * before
    }

    /// Whether the last restriction in flow direction is choked.
    fn is_choked(&self, passage: usize, mode: &Mode, w: &Workspace) -> bool {
        let around = if w.flow[passage].mass >= 0.0 {
            self.around(passage, self.passages[passage].restrictions.len() - 1, w)
        } else {
            let [behind, before] = self.around(passage, 0, w);
            [before, behind]
        };
        self.is_choked_by(passage, around, mode)
    }

    /// Evaluates a state as far as necessary.
    #[inline]
    pub(crate) fn observe(&self, need: Need, t: f64, y: &[f64], mode: &Mode, w: &mut Workspace) {
        self.instant(y, mode, w);
        if need >= Need::Flows {
            self.flows(t, mode, w);
        }
        if need == Need::Forces {
            self.forces(t, mode, w);
        }
    }
}

#[derive(Debug, Clone, Copy, PartialEq)]
enum Operation {
    Constant(f64),
    Probe(Probe),
    Negate,
    Binary(Binary),
    Function(Function),
}

/// An expression as a postfix list.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Program {
    operations: Vec<Operation>,
    /// The linear form, if the expression is one.
    linear: Option<Linear>,
    pub(crate) need: Need,
}

/// Sum of quantities with factors, and a constant.
#[derive(Debug, Clone, Default, PartialEq)]
struct Linear {
    terms: Vec<(f64, Probe)>,
    offset: f64,
}

impl Linear {
    /// The linear form of an expression; none if it has another form. `sensors` counts the sensors passed on the way.
    fn new(plan: &Plan, expression: &Expression, sensors: usize) -> Option<Self> {
        match expression {
            Expression::Constant(value) => Some(Self {
                terms: Vec::new(),
                offset: *value,
            }),
            Expression::Channel(channel) => Some(Self {
                terms: vec![(1.0, Probe::new(plan, *channel)?)],
                offset: 0.0,
            }),
            Expression::Sensor(index) if sensors <= plan.assembly.sensors.len() => {
                Self::new(plan, &plan.assembly.sensors.get(*index)?.value, sensors + 1)
            }
            Expression::Negative(a) => Some(Self::new(plan, a, sensors)?.scaled(-1.0)),
            Expression::Binary(binary, a, b) => {
                let (a, b) = (Self::new(plan, a, sensors)?, Self::new(plan, b, sensors)?);
                match binary {
                    Binary::Add => Some(a.plus(b)),
                    Binary::Subtract => Some(a.plus(b.scaled(-1.0))),
                    Binary::Multiply if a.terms.is_empty() => Some(b.scaled(a.offset)),
                    Binary::Multiply if b.terms.is_empty() => Some(a.scaled(b.offset)),
                    _ => None,
                }
            }
            Expression::Sensor(_) | Expression::Function(..) => None,
        }
    }

    fn scaled(mut self, factor: f64) -> Self {
        self.terms.iter_mut().for_each(|(scale, _)| *scale *= factor);
        self.offset *= factor;
        self
    }

    fn plus(mut self, other: Self) -> Self {
        self.terms.extend(other.terms);
        self.offset += other.offset;
        self
    }

    fn value(&self, plan: &Plan, mode: &Mode, w: &Workspace) -> f64 {
        let mut terms = self.terms.iter();
        let Some((scale, probe)) = terms.next() else {
            return self.offset;
        };
        let first = scale * probe.value(plan, mode, w);
        terms.fold(first, |sum, (scale, probe)| sum + scale * probe.value(plan, mode, w)) + self.offset
    }
}

impl Program {
    /// Compiles an expression of `owner`.
    pub(crate) fn new(plan: &Plan, owner: &str, expression: &Expression) -> Result<Self, RunError> {
        let mut program = Self {
            operations: Vec::new(),
            linear: None,
            need: Need::Instant,
        };
        let deepest = program.push(plan, owner, expression, 0)?;
        if deepest > DEPTH {
            return Err(Self::refuse(
                owner,
                "is nested too deeply; name a part of it as a sensor",
            ));
        }
        program.linear = Linear::new(plan, expression, 0);
        Ok(program)
    }

    fn refuse(owner: &str, reason: &'static str) -> RunError {
        RunError::Expression {
            owner: owner.to_owned(),
            reason,
        }
    }

    /// Appends an expression; returns the largest stack depth.
    fn push(&mut self, plan: &Plan, owner: &str, expression: &Expression, sensors: usize) -> Result<usize, RunError> {
        Ok(match expression {
            Expression::Constant(value) => {
                self.operations.push(Operation::Constant(*value));
                1
            }
            Expression::Channel(channel) => {
                let probe = Probe::new(plan, *channel)
                    .ok_or_else(|| Self::refuse(owner, "reads a quantity that its block does not have"))?;
                self.need = self.need.max(probe.need());
                self.operations.push(Operation::Probe(probe));
                1
            }
            Expression::Sensor(index) => {
                let sensor = plan.assembly.sensors.get(*index);
                let sensor = sensor.ok_or_else(|| Self::refuse(owner, "reads a sensor that does not exist"))?;
                if sensors > plan.assembly.sensors.len() {
                    return Err(Self::refuse(
                        owner,
                        "reads sensors that depend on each other in a circle",
                    ));
                }
                self.push(plan, owner, &sensor.value, sensors + 1)?
            }
            Expression::Negative(a) => {
                let height = self.push(plan, owner, a, sensors)?;
                self.operations.push(Operation::Negate);
                height
            }
            Expression::Binary(operation, a, b) => {
                let left = self.push(plan, owner, a, sensors)?;
                let right = self.push(plan, owner, b, sensors)?;
                self.operations.push(Operation::Binary(*operation));
                left.max(right + 1)
            }
            Expression::Function(function, arguments) => {
                let count = match function {
                    Function::Min | Function::Max => 2,
                    _ => 1,
                };
                if arguments.len() != count {
                    return Err(Self::refuse(owner, "gives a function the wrong number of arguments"));
                }
                let mut height = 0;
                for (i, argument) in arguments.iter().enumerate() {
                    height = height.max(i + self.push(plan, owner, argument, sensors)?);
                }
                self.operations.push(Operation::Function(*function));
                height
            }
        })
    }

    /// Terms and offset of the linear form, if the expression is one.
    pub(crate) fn linear(&self) -> Option<(&[(f64, Probe)], f64)> {
        let linear = self.linear.as_ref()?;
        Some((&linear.terms, linear.offset))
    }

    /// The value at an evaluated state.
    pub(crate) fn value(&self, plan: &Plan, mode: &Mode, w: &Workspace) -> f64 {
        if let Some(linear) = &self.linear {
            return linear.value(plan, mode, w);
        }
        let mut stack = [0.0; DEPTH];
        let mut height = 0;
        for operation in &self.operations {
            match operation {
                Operation::Constant(value) => {
                    stack[height] = *value;
                    height += 1;
                }
                Operation::Probe(probe) => {
                    stack[height] = probe.value(plan, mode, w);
                    height += 1;
                }
                Operation::Negate => stack[height - 1] = -stack[height - 1],
                Operation::Binary(binary) => {
                    height -= 1;
                    stack[height - 1] = binary.apply(stack[height - 1], stack[height]);
                }
                Operation::Function(function) => {
                    let x = stack[height - 1];
                    match function {
                        Function::Min | Function::Max => {
                            height -= 1;
                            let other = stack[height - 1];
                            let smaller = matches!(function, Function::Min);
                            stack[height - 1] = if smaller { other.min(x) } else { other.max(x) };
                        }
                        Function::Sqrt => stack[height - 1] = x.sqrt(),
                        Function::Exp => stack[height - 1] = x.exp(),
                        Function::Sin => stack[height - 1] = x.sin(),
                        Function::Cos => stack[height - 1] = x.cos(),
                        Function::Tan => stack[height - 1] = x.tan(),
                        Function::Abs => stack[height - 1] = x.abs(),
                    }
                }
            }
        }
        stack[0]
    }
}

impl Binary {
    fn apply(self, a: f64, b: f64) -> f64 {
        match self {
            Self::Add => a + b,
            Self::Subtract => a - b,
            Self::Multiply => a * b,
            Self::Divide => a / b,
            Self::Power => a.powf(b),
        }
    }
}

/// A compiled comparison.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Level {
    margin: Program,
    strict: bool,
}

impl Level {
    pub(crate) fn new(plan: &Plan, owner: &str, comparison: &Comparison) -> Result<Self, RunError> {
        Ok(Self {
            margin: Program::new(plan, owner, &comparison.margin)?,
            strict: comparison.strict,
        })
    }

    /// All comparisons of a condition.
    pub(crate) fn all(plan: &Plan, owner: &str, condition: &Condition) -> Result<Vec<Self>, RunError> {
        condition.all.iter().map(|c| Self::new(plan, owner, c)).collect()
    }

    pub(crate) fn need(&self) -> Need {
        self.margin.need
    }

    /// Height above the level: the comparison is satisfied if positive, or also if zero unless strict.
    pub(crate) fn height(&self, plan: &Plan, mode: &Mode, w: &Workspace) -> f64 {
        let margin = self.margin.value(plan, mode, w);
        if self.strict { margin } else { -margin }
    }

    /// Whether a height satisfies the comparison.
    pub(crate) fn is_satisfied(&self, height: f64) -> bool {
        (height > 0.0) == self.strict
    }
}
