//! Histories that are read from the workspace, by the vector that contains them.

use crate::network::mode::Mode;
use crate::network::plan::{Pair, Plan};
use crate::network::probe::{Probe, Program};
use crate::network::rates::Workspace;

/// Source of a history.
#[derive(Debug, PartialEq)]
pub(super) enum Source {
    Probe(Probe),
    /// Minus a quantity.
    Negative(Probe),
    Program(Program),
    /// A sum of other columns.
    Combination,
}

/// A sum of columns with factors, and a constant.
#[derive(Debug)]
pub(super) struct Combination {
    /// Place of the sum.
    pub(super) place: usize,
    /// Factors and places of the columns.
    pub(super) terms: Vec<(f64, usize)>,
    pub(super) offset: f64,
}

impl Combination {
    /// Computes the sum for all samples of a block.
    pub(super) fn evaluate(&self, block: &mut [f64]) {
        let mut sum = [0.0; BLOCK];
        for (number, (scale, place)) in self.terms.iter().enumerate() {
            let column = &block[place * BLOCK..][..BLOCK];
            if number == 0 {
                sum.iter_mut().zip(column).for_each(|(sum, x)| *sum = scale * x);
            } else {
                sum.iter_mut().zip(column).for_each(|(sum, x)| *sum += scale * x);
            }
        }
        sum.iter_mut().for_each(|sum| *sum += self.offset);
        block[self.place * BLOCK..][..BLOCK].copy_from_slice(&sum);
    }
}

impl Source {
    #[inline]
    pub(super) fn value(&self, plan: &Plan, mode: &Mode, w: &Workspace) -> f64 {
        match self {
            Self::Probe(probe) => probe.value(plan, mode, w),
            Self::Negative(probe) => -probe.value(plan, mode, w),
            Self::Program(program) => program.value(plan, mode, w),
            // Computed for a whole block.
            Self::Combination => 0.0,
        }
    }
}

/// Number of samples of each history collected before they are appended. The histories are far apart in
/// memory, and each sample would touch as many pages as there are histories.
pub(super) const BLOCK: usize = 32;

/// Quantities that are copied from the workspace, by the vector that contains them: place of the history, index.
///
/// Most histories are such quantities, and one loop for each vector takes a fraction of the time of a `match` for each
/// history.
#[derive(Debug, Default)]
pub(super) struct Reads {
    position: Vec<(usize, usize)>,
    velocity: Vec<(usize, usize)>,
    acceleration: Vec<(usize, usize)>,
    travel: Vec<(usize, Pair)>,
    speed: Vec<(usize, Pair)>,
    pressure: Vec<(usize, usize)>,
    temperature: Vec<(usize, usize)>,
    mass: Vec<(usize, usize)>,
    mass_flow: Vec<(usize, usize)>,
    spring: Vec<(usize, usize)>,
    friction: Vec<(usize, usize)>,
    imposed: Vec<(usize, usize)>,
    resistance: Vec<(usize, usize)>,
    contact: Vec<(usize, usize)>,
    /// Pressures before and behind a restriction, and whether it is choked.
    restrictions: Vec<RestrictionPlaces>,
    /// Places of all other histories.
    pub(super) others: Vec<usize>,
}

/// Places of the histories of a restriction of a passage.
#[derive(Debug)]
struct RestrictionPlaces {
    passage: usize,
    restriction: usize,
    before: Option<usize>,
    behind: Option<usize>,
    choked: Option<usize>,
}

impl Reads {
    /// The places of a restriction; new ones if it has none.
    fn restriction(&mut self, passage: usize, restriction: usize) -> &mut RestrictionPlaces {
        let of = |places: &RestrictionPlaces| (places.passage, places.restriction) == (passage, restriction);
        let index = self.restrictions.iter().position(of).unwrap_or_else(|| {
            self.restrictions.push(RestrictionPlaces {
                passage,
                restriction,
                before: None,
                behind: None,
                choked: None,
            });
            self.restrictions.len() - 1
        });
        &mut self.restrictions[index]
    }

    pub(super) fn new(sources: &[Source]) -> Self {
        let mut reads = Self::default();
        for (place, source) in sources.iter().enumerate() {
            let probe = match source {
                Source::Probe(probe) => probe,
                Source::Combination => continue,
                Source::Negative(_) | Source::Program(_) => {
                    reads.others.push(place);
                    continue;
                }
            };
            let (list, index) = match *probe {
                Probe::Travel(pair) => {
                    reads.travel.push((place, pair));
                    continue;
                }
                Probe::Speed(pair) => {
                    reads.speed.push((place, pair));
                    continue;
                }
                Probe::Before(i, restriction) => {
                    reads.restriction(i, restriction).before = Some(place);
                    continue;
                }
                Probe::Behind(i, restriction) => {
                    reads.restriction(i, restriction).behind = Some(place);
                    continue;
                }
                Probe::ChokedAt(i, restriction) => {
                    reads.restriction(i, restriction).choked = Some(place);
                    continue;
                }
                Probe::Position(i) => (&mut reads.position, i),
                Probe::Velocity(i) => (&mut reads.velocity, i),
                Probe::Acceleration(i) => (&mut reads.acceleration, i),
                Probe::Pressure(i) => (&mut reads.pressure, i),
                Probe::Temperature(i) => (&mut reads.temperature, i),
                Probe::Mass(i) => (&mut reads.mass, i),
                Probe::MassFlow(i) => (&mut reads.mass_flow, i),
                Probe::Spring(i) => (&mut reads.spring, i),
                Probe::Friction(i) => (&mut reads.friction, i),
                Probe::Imposed(i) => (&mut reads.imposed, i),
                Probe::Resistance(i) => (&mut reads.resistance, i),
                Probe::Contact(i) => (&mut reads.contact, i),
                _ => {
                    reads.others.push(place);
                    continue;
                }
            };
            list.push((place, index));
        }
        reads
    }

    #[inline]
    pub(super) fn copy(&self, plan: &Plan, mode: &Mode, w: &Workspace, block: &mut [f64], row: usize) {
        let mut put = |place: usize, value: f64| block[place * BLOCK + row] = value;
        for (list, values) in [
            (&self.position, &w.position),
            (&self.velocity, &w.velocity),
            (&self.acceleration, &w.acceleration),
            (&self.pressure, &w.pressure),
            (&self.temperature, &w.temperature),
            (&self.mass, &w.mass),
            (&self.imposed, &w.imposed),
        ] {
            list.iter().for_each(|(place, i)| put(*place, values[*i]));
        }
        self.travel
            .iter()
            .for_each(|(place, pair)| put(*place, w.travel(*pair)));
        self.speed.iter().for_each(|(place, pair)| put(*place, w.speed(*pair)));
        self.mass_flow
            .iter()
            .for_each(|(place, i)| put(*place, w.flow[*i].mass));
        self.spring
            .iter()
            .for_each(|(place, i)| put(*place, w.spring[*i].force));
        self.friction
            .iter()
            .for_each(|(place, i)| put(*place, w.friction[*i].force));
        self.resistance
            .iter()
            .for_each(|(place, i)| put(*place, w.fastener[*i][0]));
        for (place, i) in &self.contact {
            put(*place, plan.contacts[*i].side * w.contact[*i].force);
        }
        for places in &self.restrictions {
            let around = plan.around(places.passage, places.restriction, w);
            let choked = plan.is_choked_by(places.passage, around, mode);
            let values = [around[0], around[1], f64::from(u8::from(choked))];
            for (place, value) in [places.before, places.behind, places.choked].into_iter().zip(values) {
                if let Some(place) = place {
                    put(place, value);
                }
            }
        }
    }
}
