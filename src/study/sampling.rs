//! Draws of the variables: an Owen-scrambled Sobol' sequence, correlations, and rejection of conflicting values.
//!
//! Point `i` of the sequence depends only on `i`, the seed and the list of variables, so that the first draws are
//! independent of the number of draws, of threads and of the machine.
//!
//! Some values conflict, for example a seat wider than the valve. The variables of such rules form connected
//! components. Values are rejected and drawn again *within a component*, which gives the same distribution as rejecting
//! complete designs, and keeps the low-discrepancy points of all other variables.
//!
//! Variables with joint draws, those of a calibration, have the values of a row of these in place of the sequence.

use std::collections::{BTreeMap, BTreeSet};
use std::sync::Arc;

use nailnoise_acoustics::random::uniform;

use super::normal;
use super::variables::{Drawn, Variable, VariableKind};
use crate::design::{Correlation, Design, JointDraws, Value, Values};

/// Dimensions and length of the sequence; beyond them, it continues with another scramble.
const DIMENSIONS: usize = 256;
const LENGTH: u64 = 1 << 16;

/// Maximum number of times a component is drawn for one point.
const MOST_ATTEMPTS: u64 = 1000;

/// Number of designs with which rules between values are searched: a rule that one draw in twenty breaks is missed once
/// in 500 000.
const PROBES: u64 = 256;

/// Numbers of the sequence are multiples of 2^-24 starting at 0; half a step moves them away from the ends.
const HALF_STEP: f64 = 1.0 / (1 << 25) as f64;

/// Draws of a list of variables.
pub struct Sampler {
    variables: Vec<Variable>,
    components: Vec<Component>,
    seed: u64,
    /// Names of the variables that are literals of an assembly, which no rule compares.
    literals: BTreeSet<String>,
    /// Keys that an assembly leaves without effect.
    idle: BTreeSet<String>,
    /// Values that take the place of the sequence.
    joint: Option<JointShares>,
}

/// Joint draws of variables.
struct JointShares {
    draws: Arc<JointDraws>,
    /// Place of each variable in its distribution in each draw; NaN for one that is not in the draws.
    shares: Vec<Vec<f64>>,
}

/// Variables that are drawn together.
#[derive(Debug, Clone, PartialEq)]
struct Component {
    members: Vec<usize>,
    /// Whether some of their values conflict.
    conflicts: bool,
    /// Its members that are correlated.
    correlated: Vec<Correlated>,
}

/// Members of a component with a common correlation in the Gaussian copula.
#[derive(Debug, Clone, PartialEq)]
struct Correlated {
    members: Vec<usize>,
    pearson: f64,
}

/// A point: the position of each active variable in its distribution, which [`Variable::drawn`] converts to its value.
#[derive(Debug, Clone, PartialEq)]
pub struct Point {
    /// Share of its distribution below each variable, 0 .. 1; NaN for a fixed one.
    pub shares: Vec<f64>,
}

/// Which variables are drawn, around which values, and in which of many independent sequences.
#[derive(Clone, Copy)]
pub struct Frame<'a> {
    /// Values of all fixed quantities, for each of several designs with common draws.
    pub bases: &'a [Values],
    /// Whether each variable is drawn.
    pub active: &'a [bool],
    /// Number of the sequence.
    pub stream: u64,
    /// A point of the bases without conflicts. It gives all variables that are not drawn; without it, they are those of
    /// the bases.
    pub given: Option<&'a Point>,
    /// Number of the given point when partners of many points are drawn: their first candidates are the points of one
    /// sequence.
    pub partner_of: Option<u64>,
}

impl<'a> Frame<'a> {
    /// Draws around the values of the bases.
    pub fn new(bases: &'a [Values], active: &'a [bool], stream: u64) -> Self {
        Self {
            bases,
            active,
            stream,
            given: None,
            partner_of: None,
        }
    }
}

/// Variables that are drawn together have no compatible values.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[error("{MOST_ATTEMPTS} draws of {drawn} broke a rule, the last one that of {keys}")]
pub struct NoValues {
    /// Names of the variables.
    pub drawn: String,
    /// Keys of the rule that the last draw broke.
    pub keys: String,
}

/// Number of rejections of values, by the conflicting keys.
pub type Rejections = BTreeMap<String, u64>;

impl Sampler {
    /// A sampler of variables of a design. Rules between their values are found by trial draws.
    pub fn new(design: &Design, variables: Vec<Variable>, seed: u64) -> Self {
        let rules = rules(design, &variables);
        let components = components(&variables, &rules, &design.study().correlations);
        let literal = |variable: &&Variable| design.is_literal(&variable.name);
        let joint = design.study().draws.as_ref().map(|own| JointShares {
            draws: Arc::clone(own),
            shares: joint_shares(own, &variables),
        });
        Self {
            literals: variables.iter().filter(literal).map(|own| own.name.clone()).collect(),
            idle: design.idle_keys(),
            joint,
            variables,
            components,
            seed,
        }
    }

    /// Whether a variable has the values of joint draws.
    pub(super) fn is_joint(&self, variable: usize) -> bool {
        let first = self.joint.as_ref().and_then(|joint| joint.shares.first());
        first.is_some_and(|row| !row[variable].is_nan())
    }

    /// The variables, in the order of the sequence's dimensions.
    pub fn variables(&self) -> &[Variable] {
        &self.variables
    }

    /// Indices of the variables of each component.
    pub(super) fn components(&self) -> impl Iterator<Item = &[usize]> {
        self.components.iter().map(|component| component.members.as_slice())
    }

    /// Whether each variable is drawn with others whose values may conflict with its own.
    pub(crate) fn is_ruled(&self) -> Vec<bool> {
        let mut ruled = vec![false; self.variables.len()];
        let conflicting = self.components.iter().filter(|component| component.conflicts);
        conflicting
            .flat_map(|own| &own.members)
            .for_each(|&member| ruled[member] = true);
        ruled
    }

    /// For each component whose values in a point break a rule around a base, its variables.
    pub(crate) fn broken<'a>(&'a self, base: &'a Values, point: &'a Point) -> impl Iterator<Item = &'a [usize]> {
        let conflicting = self.components.iter().filter(|component| component.conflicts);
        conflicting
            .map(|component| component.members.as_slice())
            .filter(|members| self.broken_rule(base, members, point).is_some())
    }

    /// The point of independent standard normal numbers, one for each variable.
    pub(crate) fn of_normal(&self, z: &[f64]) -> Point {
        let mut z = z.to_vec();
        for correlated in self.components.iter().flat_map(|own| &own.correlated) {
            let mut own: Vec<f64> = correlated.members.iter().map(|&m| z[m]).collect();
            correlate(&mut own, correlated.pearson);
            correlated.members.iter().zip(own).for_each(|(&m, own)| z[m] = own);
        }
        let share = |z: &f64| normal::cumulative(*z).clamp(HALF_STEP, 1.0 - HALF_STEP);
        Point {
            shares: z.iter().map(share).collect(),
        }
    }

    /// The independent standard normal numbers of a point whose variables are all drawn: the inverse of
    /// [`of_normal`](Self::of_normal).
    pub(crate) fn to_normal(&self, point: &Point) -> Vec<f64> {
        let mut z: Vec<f64> = point.shares.iter().map(|share| normal::quantile(*share)).collect();
        for correlated in self.components.iter().flat_map(|own| &own.correlated) {
            let mut own: Vec<f64> = correlated.members.iter().map(|&m| z[m]).collect();
            decorrelate(&mut own, correlated.pearson);
            correlated.members.iter().zip(own).for_each(|(&m, own)| z[m] = own);
        }
        z
    }

    fn names(&self, members: &[usize]) -> Vec<&str> {
        members
            .iter()
            .map(|&member| self.variables[member].name.as_str())
            .collect()
    }

    /// Point `index` of a frame.
    ///
    /// # Errors
    /// [`NoValues`] if values of a component conflicted in every attempt.
    pub fn point(&self, frame: Frame<'_>, index: u64, rejections: &mut Rejections) -> Result<Point, NoValues> {
        let count = self.variables.len();
        let mut point = frame.given.cloned().unwrap_or_else(|| Point {
            shares: vec![f64::NAN; count],
        });
        // Each further candidate for a partner is taken from another scramble.
        let index = frame.partner_of.map_or(index, |number| index * LENGTH + number);
        if let Some(joint) = &self.joint {
            let row = &joint.shares[joint.draws.row_of(index, self.seed)];
            let places = point.shares.iter_mut().zip(row);
            let places = places.filter(|(_, share)| !share.is_nan());
            places.for_each(|(place, share)| *place = *share);
        }
        for component in &self.components {
            let of = |wanted: &dyn Fn(usize) -> bool| -> Vec<usize> {
                component.members.iter().copied().filter(|&m| wanted(m)).collect()
            };
            let members = of(&|m| frame.active[m] && !self.is_joint(m));
            if members.is_empty() {
                continue;
            }
            let set = of(&|m| frame.active[m] || self.is_joint(m));
            let bases = match component.conflicts {
                true => self.bases_around(component, frame),
                false => Vec::new(),
            };
            let mut broken = None;
            for attempt in 0..MOST_ATTEMPTS {
                self.draw(component, &members, (frame.stream, index, attempt), &mut point);
                broken = bases.iter().find_map(|base| self.broken_rule(base, &set, &point));
                if broken.is_none() {
                    break;
                }
                *rejections.entry(self.names(&component.members).join(", ")).or_default() += 1;
            }
            if let Some(keys) = broken {
                return Err(NoValues {
                    drawn: self.names(&members).join(", "),
                    keys,
                });
            }
        }
        Ok(point)
    }

    /// Draws the active members of a component.
    fn draw(
        &self,
        component: &Component,
        members: &[usize],
        (stream, index, attempt): (u64, u64, u64),
        point: &mut Point,
    ) {
        for &member in members {
            point.shares[member] = self.share(member, stream, index, attempt);
        }
        for correlated in &component.correlated {
            let own: Vec<usize> = correlated
                .members
                .iter()
                .copied()
                .filter(|m| members.contains(m))
                .collect();
            let mut z: Vec<f64> = own.iter().map(|&m| normal::quantile(point.shares[m])).collect();
            correlate(&mut z, correlated.pearson);
            for (member, z) in own.into_iter().zip(z) {
                point.shares[member] = normal::cumulative(z).clamp(HALF_STEP, 1.0 - HALF_STEP);
            }
        }
    }

    /// A number of the sequence, in (0, 1).
    fn share(&self, variable: usize, stream: u64, index: u64, attempt: u64) -> f64 {
        let block = (variable / DIMENSIONS) as u64 + ((index / LENGTH) << 8);
        let mixed = uniform(self.seed, stream, block) + uniform(self.seed ^ stream.rotate_left(17), attempt, block);
        let scramble = (mixed.fract() * f64::from(u32::MAX)) as u32;
        let number = sobol_burley::sample((index % LENGTH) as u32, (variable % DIMENSIONS) as u32, scramble);
        f64::from(number) + HALF_STEP
    }

    /// The bases with the values of the given point outside the active members of a component. These break no rule; the
    /// bases without them may, if the given point changes one of two values that a rule compares.
    fn bases_around(&self, component: &Component, frame: Frame<'_>) -> Vec<Values> {
        let mut bases = frame.bases.to_vec();
        if let Some(given) = frame.given {
            let mut around = given.clone();
            let own = component.members.iter().filter(|member| frame.active[**member]);
            own.for_each(|&member| around.shares[member] = f64::NAN);
            let changes = self.changes_of_values(&self.changes(&around));
            for base in &mut bases {
                // The given point was accepted, so its values can be set.
                let _ = base.set(&changes);
            }
        }
        bases
    }

    /// Keys of the rule that is broken when members are drawn; none if their values are compatible.
    fn broken_rule(&self, base: &Values, members: &[usize], point: &Point) -> Option<String> {
        let mut values = base.clone();
        match values.set(&self.changes_of_values(&self.changes_of(members, point))) {
            Ok(()) => Some(values.conflict_without(&self.idle)?.keys().join(", ")),
            Err(error) => Some(error.key().to_owned()),
        }
    }

    fn changes_of<'a>(&'a self, members: &[usize], point: &Point) -> Vec<(&'a str, Value)> {
        let changes = members.iter().filter_map(|&m| {
            let variable = &self.variables[m];
            Some(variable.changes(&variable.drawn(point.shares[m])?))
        });
        changes.flatten().collect()
    }

    /// Those of some changes that set values of the design, not literals of an assembly.
    fn changes_of_values<'a>(&self, changes: &[(&'a str, Value)]) -> Vec<(&'a str, Value)> {
        let of_values = changes.iter().filter(|(key, _)| !self.literals.contains(*key));
        of_values.cloned().collect()
    }

    /// Keys and values that a point sets.
    pub fn changes<'a>(&'a self, point: &Point) -> Vec<(&'a str, Value)> {
        let all: Vec<usize> = (0..self.variables.len()).collect();
        self.changes_of(&all, point)
    }
}

/// Places of variables in their distributions, by the values of joint draws.
fn joint_shares(draws: &JointDraws, variables: &[Variable]) -> Vec<Vec<f64>> {
    let column = |variable: &Variable| draws.names.iter().position(|name| *name == variable.name);
    let columns: Vec<Option<usize>> = variables.iter().map(column).collect();
    let share = |(variable, column): (&Variable, &Option<usize>), row: &[f64]| {
        let value = row[(*column)?];
        let share = match &variable.kind {
            VariableKind::Quantity(parameter) => parameter.share_below(value),
            VariableKind::LawScore => normal::cumulative(value),
            VariableKind::Method(_) => value,
            VariableKind::Alternatives(_) => return None,
        };
        Some(share.clamp(HALF_STEP, 1.0 - HALF_STEP))
    };
    let shares = |row: &Vec<f64>| {
        let places = variables.iter().zip(&columns);
        places.map(|own| share(own, row).unwrap_or(f64::NAN)).collect()
    };
    draws.rows.iter().map(shares).collect()
}

/// Gives independent standard normal numbers the common correlation `r`: multiplies them by the Cholesky factor of (1 -
/// r) I + r 1 1^T.
fn correlate(z: &mut [f64], r: f64) {
    let mut factor = CommonFactor::default();
    for own in z {
        let (above, diagonal) = (factor.sum, factor.diagonal());
        factor.next(*own, r);
        *own = above + diagonal * *own;
    }
}

/// The inverse of [`correlate`]; a number that is determined by those before it becomes 0.
fn decorrelate(z: &mut [f64], r: f64) {
    let mut factor = CommonFactor::default();
    for own in z {
        let (above, diagonal) = (factor.sum, factor.diagonal());
        *own = if diagonal > 0.0 { (*own - above) / diagonal } else { 0.0 };
        factor.next(*own, r);
    }
}

/// A row of the Cholesky factor of (1 - r) I + r 1 1^T, whose entries below the diagonal are equal in each column.
#[derive(Default)]
struct CommonFactor {
    /// Sum of the squares of the row's entries before the diagonal.
    squares: f64,
    /// Product of the row's entries with the numbers so far.
    sum: f64,
}

impl CommonFactor {
    fn diagonal(&self) -> f64 {
        (1.0 - self.squares).max(0.0).sqrt()
    }

    /// Advances to the next row, given the number of this one.
    fn next(&mut self, independent: f64, r: f64) {
        let diagonal = self.diagonal();
        let below = if diagonal > 0.0 {
            (r - self.squares) / diagonal
        } else {
            0.0
        };
        self.sum += below * independent;
        self.squares += below * below;
    }
}

/// Sets of variables whose values may conflict: for random designs, the smallest sets of their variables that break a
/// rule without the others.
fn rules(design: &Design, variables: &[Variable]) -> BTreeSet<Vec<usize>> {
    /// Distinct from any seed of a study, because the rules do not depend on it.
    const SEED: u64 = 0x5EED_0F9A_0BE5;
    let (base, idle): (&Values, _) = (design, design.idle_keys());
    let conflict = |members: &[usize], drawn: &[Drawn]| {
        let mut values = base.clone();
        let changes = members.iter().flat_map(|&m| variables[m].changes(&drawn[m]));
        let changes: Vec<_> = changes.filter(|(key, _)| !design.is_literal(key)).collect();
        match values.set(&changes) {
            Ok(()) => values.conflict_without(&idle),
            Err(_) => None,
        }
    };
    let mut found = BTreeSet::new();
    for probe in 0..PROBES {
        let drawn: Vec<Drawn> = variables
            .iter()
            .enumerate()
            .map(|(dimension, variable)| {
                variable.at((uniform(SEED, probe, dimension as u64) + HALF_STEP).min(1.0 - HALF_STEP))
            })
            .collect();
        let mut members: Vec<usize> = (0..variables.len()).collect();
        while let Some(broken) = conflict(&members, &drawn) {
            let named = broken.keys();
            let sets = |m: &usize| {
                variables[*m]
                    .changes(&drawn[*m])
                    .iter()
                    .any(|(key, _)| named.contains(key))
            };
            let mut rule: Vec<usize> = members.iter().copied().filter(sets).collect();
            if conflict(&rule, &drawn).is_none() {
                // Values that the message does not name are involved; those that are not needed are removed.
                rule.clone_from(&members);
                for member in members.clone() {
                    let rest: Vec<usize> = rule.iter().copied().filter(|other| *other != member).collect();
                    if conflict(&rest, &drawn).is_some() {
                        rule = rest;
                    }
                }
            }
            if rule.is_empty() {
                break;
            }
            members.retain(|member| !rule.contains(member));
            found.insert(rule);
        }
    }
    found
}

/// Joins variables that occur together in a rule or a correlation.
fn components(variables: &[Variable], rules: &BTreeSet<Vec<usize>>, correlations: &[Correlation]) -> Vec<Component> {
    let place = |key: &String| variables.iter().position(|variable| variable.name == *key);
    let correlated: Vec<Correlated> = correlations
        .iter()
        .map(|correlation| Correlated {
            members: correlation.keys.iter().filter_map(place).collect(),
            // Rank correlation of a bivariate normal distribution (Pearson 1907).
            pearson: 2.0 * (std::f64::consts::PI * correlation.rank / 6.0).sin(),
        })
        .filter(|correlated| correlated.members.len() > 1)
        .collect();
    let mut label: Vec<usize> = (0..variables.len()).collect();
    let sets = rules
        .iter()
        .chain(correlated.iter().map(|correlated| &correlated.members));
    for set in sets {
        let to = set.iter().map(|&member| label[member]).min().unwrap_or(0);
        let from: Vec<usize> = set.iter().map(|&member| label[member]).collect();
        label
            .iter_mut()
            .filter(|own| from.contains(own))
            .for_each(|own| *own = to);
    }
    let labels: BTreeSet<usize> = label.iter().copied().collect();
    let component = |of: usize| {
        let members: Vec<usize> = (0..variables.len()).filter(|&member| label[member] == of).collect();
        Component {
            conflicts: rules.iter().any(|rule| members.contains(&rule[0])),
            correlated: correlated
                .iter()
                .filter(|own| members.contains(&own.members[0]))
                .cloned()
                .collect(),
            members,
        }
    };
    labels.into_iter().map(component).collect()
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]

    use super::*;
    use crate::study::parameters::Parameter;
    use crate::study::variables::{Scope, VariableKind};

    const N: u64 = 4096;

    fn design(text: &str) -> Design {
        let folder = concat!(env!("CARGO_MANIFEST_DIR"), "/designs/drawn.toml");
        Design::parse(&format!("base = \"n80cb.toml\"\n{text}"), folder).unwrap()
    }

    /// Variables for these keys of a design, whether or not they change levels.
    fn of(design: &Design, keys: &[&str]) -> Vec<Variable> {
        let entry = |key: &&str| design.entries().into_iter().find(|entry| entry.key == *key).unwrap();
        let parameters = keys.iter().map(entry).filter_map(Parameter::of);
        let variable = |parameter: Parameter| Variable {
            name: parameter.key.clone(),
            scope: Scope::Shot,
            kind: VariableKind::Quantity(parameter),
        };
        parameters.map(variable).collect()
    }

    fn points(design: &Design, keys: &[&str], seed: u64) -> (Vec<Point>, Rejections) {
        let sampler = Sampler::new(design, of(design, keys), seed);
        let (active, mut rejections) = (vec![true; keys.len()], Rejections::new());
        let bases = [Values::clone(design)];
        let frame = Frame::new(&bases, &active, 0);
        let points = (0..N).map(|index| sampler.point(frame, index, &mut rejections).unwrap());
        (points.collect(), rejections)
    }

    fn ranks(values: impl Iterator<Item = f64>) -> Vec<f64> {
        let values: Vec<f64> = values.collect();
        let mut order: Vec<usize> = (0..values.len()).collect();
        order.sort_by(|a, b| values[*a].total_cmp(&values[*b]));
        let mut ranks = vec![0.0; values.len()];
        order
            .iter()
            .enumerate()
            .for_each(|(rank, &own)| ranks[own] = rank as f64);
        ranks
    }

    fn spearman(points: &[Point], a: usize, b: usize) -> f64 {
        let [x, y] = [a, b].map(|place| ranks(points.iter().map(|point| point.shares[place])));
        let n = points.len() as f64;
        let squares: f64 = x.iter().zip(&y).map(|(x, y)| (x - y).powi(2)).sum();
        1.0 - 6.0 * squares / (n * (n * n - 1.0))
    }

    #[test]
    fn numbers_are_recovered_from_their_correlated_ones() {
        for r in [-0.3, 0.0, 0.7] {
            let z = [0.3, -1.2, 2.0];
            let mut own = z;
            correlate(&mut own, r);
            assert!(r == 0.0 || own[1] != z[1]);
            decorrelate(&mut own, r);
            assert!(own.iter().zip(z).all(|(own, z)| (own - z).abs() < 1e-12), "{own:?}");
        }
    }

    #[test]
    fn points_fill_each_dimension_evenly() {
        let design = design("");
        let (points, _) = points(&design, &["supply.pressure", "piston.mass"], 3);
        for place in 0..2 {
            let mut cells = [0; 64];
            points
                .iter()
                .for_each(|point| cells[(64.0 * point.shares[place]) as usize] += 1);
            assert!(cells.iter().all(|count| *count == N / 64), "{cells:?}");
        }
    }

    #[test]
    fn a_rank_correlation_is_met() {
        let text = "[[study.correlation]]\nkeys = [\"piston.mass\", \"supply.pressure\", \"tool.mass\"]\nrank = 0.8\n";
        let keys = ["supply.pressure", "piston.mass", "tool.mass", "piston.stroke"];
        let (points, _) = points(&design(text), &keys, 1);
        for (a, b, expected) in [(0, 1, 0.8), (0, 2, 0.8), (1, 2, 0.8), (0, 3, 0.0)] {
            let found = spearman(&points, a, b);
            assert!((found - expected).abs() < 0.02, "{a} {b}: {found}");
        }
    }

    /// A row of joint draws sets all of its keys, and a key without joint draws obeys its rules around them.
    #[test]
    fn joint_draws_come_as_whole_rows() {
        let keys = ["head_valve.exhaust_lap", "head_valve.intake_lap", "piston.mass"];
        let rows = vec![vec![0.7e-3, 0.1295], vec![1.9e-3, 0.1325]];
        let names = [keys[0], keys[2]].map(str::to_owned).to_vec();
        let joint = JointDraws::new(String::new(), String::new(), names, rows.clone());
        let design = design("").with_joint_draws(Arc::new(joint));
        let variables = of(&design, &keys);
        let sampler = Sampler::new(&design, variables.clone(), 3);
        let bases = [Values::clone(&design)];
        let frame = Frame::new(&bases, &[true; 3], 0);
        for index in 0..40 {
            let point = sampler.point(frame, index, &mut Rejections::new()).unwrap();
            let value = |place: usize| match variables[place].drawn(point.shares[place]) {
                Some(Drawn::Value(Value::Number(value))) => value,
                other => panic!("{other:?}"),
            };
            // The seed begins with the second row.
            let row = &rows[(index as usize + 1) % 2];
            for (place, expected) in [(0, row[0]), (2, row[1])] {
                assert!(
                    (value(place) / expected - 1.0).abs() < 1e-9,
                    "{} {expected}",
                    value(place)
                );
            }
            assert!(value(0) <= value(1), "{} {}", value(0), value(1));
        }
    }

    /// The law of rejection: conditional on the rule, the pair is uniform over the remaining domain.
    #[test]
    fn values_that_do_not_go_together_are_drawn_anew_alone() {
        let design = design("");
        let keys = ["head_valve.exhaust_lap", "head_valve.intake_lap", "supply.pressure"];
        let (points, rejections) = points(&design, &keys, 1);
        assert_eq!(
            rejections.keys().collect::<Vec<_>>(),
            ["head_valve.exhaust_lap, head_valve.intake_lap"]
        );
        let [low, high] = [&keys[0], &keys[1]].map(|key| {
            let entry = design.entries().into_iter().find(|entry| entry.key == *key).unwrap();
            entry.range.unwrap()
        });
        let variables = of(&design, &keys);
        let value = |point: &Point, place: usize| match variables[place].drawn(point.shares[place]) {
            Some(Drawn::Value(Value::Number(value))) => value,
            other => panic!("{other:?}"),
        };
        assert!(points.iter().all(|point| value(point, 0) <= value(point, 1)));
        // The same with a fine grid.
        let cell = |[low, high]: [f64; 2], k: u32| low + (f64::from(k) + 0.5) / 500.0 * (high - low);
        let (mut sum, mut count) = (0.0, 0.0);
        for (i, j) in (0..500).flat_map(|i| (0..500).map(move |j| (i, j))) {
            if cell(low, i) <= cell(high, j) {
                (sum, count) = (sum + cell(low, i), count + 1.0);
            }
        }
        let mean = points.iter().map(|point| value(point, 0)).sum::<f64>() / N as f64;
        assert!(
            (mean - sum / count).abs() < 0.01 * (low[1] - low[0]),
            "{mean} {}",
            sum / count
        );
        let share = N as f64 / (N + rejections.values().sum::<u64>()) as f64;
        assert!((share - count / 250_000.0).abs() < 0.02, "{share}");
        // A variable without rules keeps its evenly distributed points.
        let mut cells = [0; 64];
        points
            .iter()
            .for_each(|point| cells[(64.0 * point.shares[2]) as usize] += 1);
        assert!(cells.iter().all(|count| *count == N / 64), "{cells:?}");
    }

    /// The seat of the given point is wider than the ring of the base. Other rules are judged with the ring of that
    /// point.
    #[test]
    fn rules_are_judged_around_the_given_point() {
        let design = design("");
        let keys = [
            "piston.friction.static_force",
            "piston.friction.sliding_force",
            "head_valve.outer_diameter",
            "head_valve.seat_diameter",
        ];
        let sampler = Sampler::new(&design, of(&design, &keys), 1);
        let given = Point {
            shares: vec![0.9, 0.1, 0.99, 0.9],
        };
        let bases = [Values::clone(&design)];
        let frame = Frame {
            given: Some(&given),
            ..Frame::new(&bases, &[true, true, true, false], 1)
        };
        let mut wider = bases[0].clone();
        wider
            .set(&sampler.changes(&Point {
                shares: vec![f64::NAN, f64::NAN, f64::NAN, 0.9],
            }))
            .unwrap();
        assert!(wider.conflict().is_some(), "the seat alone breaks a rule of the base");
        for index in 0..64 {
            let point = sampler.point(frame, index, &mut Rejections::new()).unwrap();
            assert_eq!(point.shares[3], 0.9);
            let mut values = bases[0].clone();
            values.set(&sampler.changes(&point)).unwrap();
            assert_eq!(values.conflict(), None);
        }
    }

    #[test]
    fn the_rule_that_no_draw_meets_is_named() {
        let design = design("head_valve.seat_diameter = { value = \"66 mm\", range = \"66 .. 66 mm\" }\n");
        let keys = ["head_valve.outer_diameter"];
        let sampler = Sampler::new(&design, of(&design, &keys), 1);
        let narrow = Point { shares: vec![0.01] };
        let mut bases = [Values::clone(&design)];
        bases[0]
            .set(&[("head_valve.seat_diameter", Value::Number(1.0))])
            .unwrap();
        let frame = Frame {
            given: Some(&narrow),
            ..Frame::new(&bases, &[true], 0)
        };
        let error = sampler.point(frame, 0, &mut Rejections::new()).unwrap_err();
        assert_eq!(error.drawn, "head_valve.outer_diameter");
        assert_eq!(error.keys, "head_valve.seat_diameter, head_valve.outer_diameter");
    }

    #[test]
    fn a_point_depends_on_seed_and_index_alone() {
        let design = design("");
        let keys = ["supply.pressure", "piston.mass"];
        let (first, again, other) = (
            points(&design, &keys, 1).0,
            points(&design, &keys, 1).0,
            points(&design, &keys, 2).0,
        );
        assert_eq!(first, again);
        assert_ne!(first[0], other[0]);
    }
}
