//! Checks that the loads on the surfaces of a body add up to the force on it.

use std::collections::BTreeMap;

use nailnoise_quantities::rounded;

use crate::network::assembly::{
    Assembly, Base, Binary, BlockRef, Channel, Expression, Family, Fastener, Function, Quantity, Space,
};
use crate::network::text::blocks::is_atmosphere;
use crate::network::text::fault::{AssemblyError, Fault};
use crate::network::text::names::{CHANNELS, quantities};
use crate::network::text::node::{Node, Spot};
use crate::network::text::resolver::Resolver;

/// Relative difference attributed to rounding.
const ROUNDING: f64 = 1e-9;
/// Number of random states.
const STATES: usize = 8;

/// Values of the channels of a made-up state, by family, index and quantity.
type State = BTreeMap<(usize, usize, usize), f64>;

/// Checks at random states that the loads of each body add up to the force on it without its weight.
pub(super) fn add_up(resolver: &Resolver<'_>, assembly: &Assembly) -> Result<(), AssemblyError> {
    for (body, name) in assembly
        .bodies
        .iter()
        .enumerate()
        .map(|(index, body)| (index, &body.name))
    {
        if !assembly.loads.iter().any(|load| load.body == body) {
            continue;
        }
        let sum = Sum {
            resolver,
            assembly,
            body,
        };
        let wrong = sum.differences();
        if !wrong.is_empty() {
            let path = format!("cycle.load.{name}");
            let table = resolver.text.cycle.get("load").and_then(|load| load.get(name));
            // The load or the block without a load that the file closest to the design gives.
            let loads = table.into_iter().flat_map(Node::entries).map(|load| &load.node.spot);
            let blocks = wrong.iter().filter_map(|own| resolver.names.find(&own.block));
            let own = table.map_or(&resolver.text.cycle.spot, |table| &table.spot);
            let candidates = blocks.map(|block| block.spot).chain(loads);
            let rank = |spot: &Spot| resolver.text.sources.rank(spot);
            let spot = candidates.fold(own, |spot, other| if rank(other) > rank(spot) { other } else { spot });
            let fault = Fault::LoadSum {
                body: name.clone(),
                differences: wrong.iter().map(|own| own.text.clone()).collect(),
                remedies: wrong.into_iter().filter_map(|own| own.remedy).collect(),
            };
            return Err(resolver.error(&path, spot, fault));
        }
    }
    Ok(())
}

/// Loads of one body.
struct Sum<'r, 'a> {
    resolver: &'r Resolver<'a>,
    assembly: &'r Assembly,
    body: usize,
}

/// A force that the loads do not contain exactly once.
struct Difference {
    /// The difference in words.
    text: String,
    /// The term that corrects it, if any.
    remedy: Option<String>,
    /// Name of its block.
    block: String,
}

/// A channel that may act on a body.
struct Acting {
    channel: Channel,
    /// Its name in expressions.
    name: String,
}

impl Acting {
    fn is_pressure(&self) -> bool {
        self.channel.quantity == Quantity::Gauge
    }

    /// The difference, given the contribution of one channel unit to the loads and to the force on the body \[- or
    /// m2\].
    fn difference(&self, found: f64, expected: f64) -> Difference {
        let name = &self.name;
        let remedy = Some(self.term(expected - found));
        let (unit, factor) = if self.is_pressure() {
            ("100 kPa", 1e5)
        } else {
            ("1 N", 1.0)
        };
        let [found, expected] = [found, expected].map(|share| format!("{} N", rounded(factor * share, 6, 1e6)));
        Difference {
            text: format!("{unit} of `{name}` adds {found} to the loads, but {expected} to the force on the body"),
            remedy,
            block: name.split('.').next().unwrap_or_default().to_owned(),
        }
    }

    /// The term that corrects the loads by a multiple of the channel \[- or m2\].
    fn term(&self, share: f64) -> String {
        let sign = if share < 0.0 { "-" } else { "+" };
        let name = &self.name;
        if self.is_pressure() {
            let area = rounded(1e6 * share.abs(), 6, 1e9);
            return format!("`{sign} A*{name}` with A = {area} mm2");
        }
        if (share.abs() - 1.0).abs() < ROUNDING {
            return format!("`{sign} {name}`");
        }
        format!("`{sign} {}*{name}`", rounded(share.abs(), 6, 1e6))
    }
}

/// Identifies a channel in a state.
fn key(channel: Channel) -> (usize, usize, usize) {
    let family = CHANNELS
        .iter()
        .position(|(_, family)| *family == channel.block.family)
        .unwrap_or(0);
    let of = quantities(channel.block.family);
    let quantity = of
        .iter()
        .position(|(_, quantity)| *quantity == channel.quantity)
        .unwrap_or(0);
    (family, channel.block.index, quantity)
}

fn channel(family: Family, index: usize, quantity: Quantity) -> Channel {
    Channel {
        block: BlockRef { family, index },
        quantity,
    }
}

impl Sum<'_, '_> {
    /// The forces that are missing or counted twice; empty if the loads add up.
    fn differences(&self) -> Vec<Difference> {
        let mut differences = Vec::new();
        let zero = State::new();
        let (loads, force) = (self.loads(&zero), self.force(&zero));
        for acting in self.acting() {
            let state = State::from([(key(acting.channel), 1.0)]);
            let (found, expected) = (self.loads(&state) - loads, self.force(&state) - force);
            // Static forces that the subtraction rounds.
            let rounding = ROUNDING * (expected.abs() + 1e-3 * (loads.abs() + force.abs()));
            if (found - expected).abs() > rounding {
                differences.push(acting.difference(found, expected));
            }
        }
        let mut seed = 0;
        let agree = |seed: &mut u32| {
            let state = self.random(seed);
            let (loads, force) = (self.loads(&state), self.force(&state));
            (loads - force).abs() <= ROUNDING * (self.size(&state) + 1.0)
        };
        if differences.is_empty() && !(0..STATES).all(|_| agree(&mut seed)) {
            differences.push(Difference {
                text: "they depend on quantities that exert no force on it".to_owned(),
                remedy: None,
                block: String::new(),
            });
        }
        differences
    }

    /// Channels that may act on a body.
    fn acting(&self) -> Vec<Acting> {
        let a = self.assembly;
        let of = |family: Family, index: usize, quantity: Quantity, name: String| Acting {
            channel: channel(family, index, quantity),
            name,
        };
        let volumes = a.volumes.iter().enumerate();
        let mut acting: Vec<Acting> = volumes
            .map(|(index, own)| of(Family::Volume, index, Quantity::Gauge, format!("{}.gauge", own.name)))
            .collect();
        let mut forces = |family: Family, names: Vec<&String>| {
            let names = names.into_iter().enumerate();
            acting.extend(names.map(|(index, name)| of(family, index, Quantity::Force, format!("{name}.force"))));
        };
        forces(Family::Contact, a.contacts.iter().map(|block| &block.name).collect());
        forces(Family::Spring, a.springs.iter().map(|block| &block.name).collect());
        forces(Family::Friction, a.frictions.iter().map(|block| &block.name).collect());
        forces(Family::Force, a.forces.iter().map(|block| &block.name).collect());
        forces(Family::Motor, a.motors.iter().map(|block| &block.name).collect());
        forces(Family::Hold, a.holds.iter().map(|block| &block.name).collect());
        forces(Family::Fastener, a.fasteners.iter().map(|block| &block.name).collect());
        let guides = a.fasteners.iter().enumerate();
        acting.extend(guides.map(|(index, own)| {
            let name = format!("{}.guide_force", own.name);
            of(Family::Fastener, index, Quantity::GuideForce, name)
        }));
        acting
    }

    /// A state of random values of all channels.
    fn random(&self, seed: &mut u32) -> State {
        let mut state = State::new();
        for block in &self.resolver.names.blocks {
            for (_, quantity) in quantities(block.block.family) {
                // Linear congruential generator (Numerical Recipes).
                *seed = seed.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
                let value = f64::from(*seed >> 8) / f64::from(1 << 24);
                state.insert(
                    key(channel(block.block.family, block.block.index, *quantity)),
                    100.0 * value - 50.0,
                );
            }
        }
        state
    }

    /// Sum of the loads \[N\].
    fn loads(&self, state: &State) -> f64 {
        let of = self.assembly.loads.iter().filter(|load| load.body == self.body);
        of.map(|load| self.value(&load.force, state)).sum()
    }

    /// Magnitude of the forces of a state, for rounding \[N\].
    fn size(&self, state: &State) -> f64 {
        let largest = state.values().fold(0.0f64, |most, value| most.max(value.abs()));
        let ambient = self.assembly.faces.iter().map(|face| face.area * 1e5).sum::<f64>();
        largest * (self.assembly.contacts.len() + self.assembly.faces.len() + 8) as f64 + ambient
    }

    /// Force on the body without its weight \[N\].
    fn force(&self, state: &State) -> f64 {
        let a = self.assembly;
        let own = Base::Body(self.body);
        let share = |on: usize, against: Base| f64::from(on == self.body) - f64::from(against == own);
        let read = |family: Family, index: usize| self.channel(channel(family, index, Quantity::Force), state);
        let mut force = 0.0;
        for face in &a.faces {
            force += share(face.body, face.against) * face.push.sign() * face.area * self.pressure(face.gas, state);
        }
        for (index, block) in a.contacts.iter().enumerate() {
            force -= share(block.on, block.against) * read(Family::Contact, index);
        }
        for (index, block) in a.frictions.iter().enumerate() {
            force -= share(block.on, block.against) * read(Family::Friction, index);
        }
        for (index, block) in a.springs.iter().enumerate() {
            force += share(block.on, block.against) * read(Family::Spring, index);
        }
        for (index, block) in a.forces.iter().enumerate() {
            force += share(block.on, block.against) * read(Family::Force, index);
        }
        for (index, block) in a.motors.iter().enumerate() {
            force += share(block.on, block.against) * read(Family::Motor, index);
        }
        for (index, block) in a.holds.iter().enumerate() {
            force += share(block.on, block.against) * read(Family::Hold, index);
        }
        for (index, block) in a.fasteners.iter().enumerate() {
            force -= share(block.driver, block.into) * read(Family::Fastener, index);
            let guide = self.channel(channel(Family::Fastener, index, Quantity::GuideForce), state);
            force -= share(block.driver, block.guide) * guide;
        }
        force
    }

    fn pressure(&self, gas: Space, state: &State) -> f64 {
        let channel = Channel {
            block: gas.block(),
            quantity: Quantity::Pressure,
        };
        self.channel(channel, state)
    }

    /// Pressure of the atmosphere \[Pa\].
    fn atmosphere(&self) -> f64 {
        let mut all = self.assembly.reservoirs.iter().enumerate();
        let found = all.find(|(index, _)| is_atmosphere(self.resolver, Space::Reservoir(*index)));
        found.map_or(0.0, |(_, reservoir)| reservoir.pressure)
    }

    /// Value of a channel: pressures follow from the gauge pressure, those of reservoirs are constant, and channels not
    /// in the state are zero.
    fn channel(&self, channel: Channel, state: &State) -> f64 {
        let Channel { block, quantity } = channel;
        if let (Family::Reservoir, Some(reservoir)) = (block.family, self.assembly.reservoirs.get(block.index)) {
            return match quantity {
                Quantity::Pressure => reservoir.pressure,
                Quantity::Gauge => reservoir.pressure - self.atmosphere(),
                _ => reservoir.temperature,
            };
        }
        if let (Family::Face, Some(face)) = (block.family, self.assembly.faces.get(block.index)) {
            return face.area * self.pressure(face.gas, state);
        }
        // A guide without friction exerts no force, whether the loads name it or not.
        let is_free = |fastener: &Fastener| fastener.seated.guide_friction == 0.0;
        if quantity == Quantity::GuideForce && self.assembly.fasteners.get(block.index).is_some_and(is_free) {
            return 0.0;
        }
        let read = |quantity: Quantity| state.get(&key(Channel { block, quantity })).copied().unwrap_or(0.0);
        if block.family == Family::Volume && quantity == Quantity::Pressure {
            return read(Quantity::Gauge) + self.atmosphere();
        }
        read(quantity)
    }

    fn value(&self, expression: &Expression, state: &State) -> f64 {
        let value = |inner: &Expression| self.value(inner, state);
        match expression {
            Expression::Constant(number) => *number,
            Expression::Channel(channel) => self.channel(*channel, state),
            Expression::Sensor(index) => self
                .assembly
                .sensors
                .get(*index)
                .map_or(0.0, |sensor| value(&sensor.value)),
            Expression::Negative(inner) => -value(inner),
            Expression::Binary(operation, left, right) => {
                let (left, right) = (value(left), value(right));
                match operation {
                    Binary::Add => left + right,
                    Binary::Subtract => left - right,
                    Binary::Multiply => left * right,
                    Binary::Divide => left / right,
                    Binary::Power => left.powf(right),
                }
            }
            Expression::Function(function, arguments) => {
                let mut values = arguments.iter().map(value);
                let first = values.next().unwrap_or(0.0);
                match function {
                    Function::Sqrt => first.sqrt(),
                    Function::Exp => first.exp(),
                    Function::Sin => first.sin(),
                    Function::Cos => first.cos(),
                    Function::Tan => first.tan(),
                    Function::Abs => first.abs(),
                    Function::Min => values.fold(first, f64::min),
                    Function::Max => values.fold(first, f64::max),
                }
            }
        }
    }
}
