//! Checks that the loads on the surfaces of a body add up to the force on it.

use std::collections::BTreeMap;

use crate::network::assembly::{
    Assembly, Base, Binary, BlockRef, Channel, Expression, Family, Function, Quantity, Space,
};
use crate::network::text::blocks::is_atmosphere;
use crate::network::text::fault::{AssemblyError, Fault};
use crate::network::text::names::{CHANNELS, quantities};
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
        let differences = sum.differences();
        if !differences.is_empty() {
            let path = format!("cycle.load.{name}");
            let table = resolver.text.cycle.get("load").and_then(|load| load.get(name));
            let spot = table.map_or(&resolver.text.cycle.spot, |table| &table.spot);
            let body = name.clone();
            return Err(resolver.error(&path, spot, Fault::LoadSum { body, differences }));
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
    /// Describes which loads are missing or counted twice; empty if they add up.
    fn differences(&self) -> Vec<String> {
        let mut differences = Vec::new();
        let zero = State::new();
        let (loads, force) = (self.loads(&zero), self.force(&zero));
        for (channel, unit, name) in self.channels() {
            let mut state = State::new();
            state.insert(key(channel), 1.0);
            let (found, expected) = (self.loads(&state) - loads, self.force(&state) - force);
            // Static forces that the subtraction rounds.
            let rounding = ROUNDING * (expected.abs() + 1e-3 * (loads.abs() + force.abs()));
            if (found - expected).abs() > rounding {
                differences.push(format!("{found:.6e}{unit} of {name} in place of {expected:.6e}"));
            }
        }
        let mut seed = 0;
        let agree = |seed: &mut u32| {
            let state = self.random(seed);
            let (loads, force) = (self.loads(&state), self.force(&state));
            (loads - force).abs() <= ROUNDING * (self.size(&state) + 1.0)
        };
        if differences.is_empty() && !(0..STATES).all(|_| agree(&mut seed)) {
            differences.push("they depend on quantities that exert no force on it".to_owned());
        }
        differences
    }

    /// Channels that act on a body, with the unit of their coefficient and their block.
    fn channels(&self) -> Vec<(Channel, &'static str, String)> {
        let a = self.assembly;
        let mut channels = Vec::new();
        for (index, volume) in a.volumes.iter().enumerate() {
            channels.push((
                channel(Family::Volume, index, Quantity::Gauge),
                " m2",
                volume.name.clone(),
            ));
        }
        let mut forces = |family: Family, names: Vec<&String>| {
            for (index, name) in names.into_iter().enumerate() {
                channels.push((channel(family, index, Quantity::Force), "", name.clone()));
            }
        };
        forces(Family::Contact, a.contacts.iter().map(|block| &block.name).collect());
        forces(Family::Spring, a.springs.iter().map(|block| &block.name).collect());
        forces(Family::Friction, a.frictions.iter().map(|block| &block.name).collect());
        forces(Family::Force, a.forces.iter().map(|block| &block.name).collect());
        forces(Family::Motor, a.motors.iter().map(|block| &block.name).collect());
        forces(Family::Hold, a.holds.iter().map(|block| &block.name).collect());
        forces(Family::Fastener, a.fasteners.iter().map(|block| &block.name).collect());
        for (index, fastener) in a.fasteners.iter().enumerate() {
            let guide = channel(Family::Fastener, index, Quantity::GuideForce);
            channels.push((guide, "", format!("{}.guide_force", fastener.name)));
        }
        channels
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
            let (family, index) = match face.gas {
                Space::Volume(index) => (Family::Volume, index),
                Space::Reservoir(index) => (Family::Reservoir, index),
            };
            let pressure = self.channel(channel(family, index, Quantity::Pressure), state);
            force += share(face.body, face.against) * face.push.sign() * face.area * pressure;
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
            force -= share(block.driver, Base::Body(block.into)) * read(Family::Fastener, index);
            let guide = self.channel(channel(Family::Fastener, index, Quantity::GuideForce), state);
            force -= share(block.driver, block.guide) * guide;
        }
        force
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
