//! Which groups of inputs decide a level: each draw has two partners for each group, one that shares the group with it
//! and one that shares all else. The part that is not shared is drawn anew until the shot counts.
//!
//! One decision or one measurement settles a group: tables of the design file, and the errors of methods. Quantities
//! with a common rule or correlation stay together, in the group of the first of them.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::draws::{Draw, Draws, Planned, levels};
use super::group_indices::{Row, indices};
use super::level_table::LevelTable;
use super::request::{Request, Subset};
use super::sampling::{Frame, Point, Sampler};
use super::screening::screen;
use super::statistics::Estimate;
use super::variables::{Scope, without_sensors};
use crate::design::{Design, Values};
use crate::error::Error;
use crate::graph::Graph;
use crate::output;
use crate::result::TOTAL;
use crate::stages::Progress;
use crate::study::StudyError;

/// The random sequence of the partners, separate from those of all structures.
const STREAM: u64 = u64::MAX;

/// Which part of a draw its partner shares.
const SHARED: [&str; 2] = ["group", "rest"];

/// Groups with their tables of the design file; a table that is not named is a separate group.
const GROUPS: [(&str, &[&str]); 7] = [
    ("supply", &["supply", "ambient"]),
    ("valves", &["head_valve", "trigger", "chambers"]),
    ("piston", &["piston", "contacts"]),
    ("nail and wood", &["nail", "wood"]),
    ("support", &["support"]),
    ("body", &["body", "tool", "hand"]),
    ("model", &["method", "model", "analysis", "acoustics"]),
];

/// Contributions of groups of inputs to the variance of the levels.
#[derive(Debug, Clone, Serialize, Deserialize, JsonSchema)]
pub struct GroupStudy {
    /// The groups.
    pub groups: Vec<Group>,
    /// Draws that have all their partners.
    pub rows: usize,
    /// Draws that lack one: no candidate for it counts, or it cannot be computed.
    pub incomplete: usize,
    /// Total, each source, and the difference of the two loudest.
    pub outputs: Vec<GroupContributions>,
}

/// A group of inputs.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Group {
    /// Its name.
    pub name: String,
    /// The variables in it.
    pub variables: Vec<String>,
}

/// Contributions of the groups to the variance of a level.
#[derive(Debug, Clone, Serialize, Deserialize, JsonSchema)]
pub struct GroupContributions {
    /// Source, `total`, or the difference of two sources.
    pub output: String,
    /// Variance over all draws and partners \[dB2\].
    pub variance_db2: f64,
    /// The groups, the largest total first.
    pub groups: Vec<GroupContribution>,
}

/// Contribution of a group.
#[derive(Debug, Clone, Serialize, Deserialize, JsonSchema)]
pub struct GroupContribution {
    /// The group.
    pub group: String,
    /// Part of the variance that knowing the group alone takes off \[-\].
    pub first_order: Estimate,
    /// Part of the variance that remains where all but the group is known \[-\].
    pub total: Estimate,
}

/// Groups of the variables that are drawn, in the order of the variables.
fn groups(sampler: &Sampler) -> Vec<(String, Vec<usize>)> {
    let variables = sampler.variables();
    let mut groups: Vec<(String, Vec<usize>)> = Vec::new();
    let mut components: Vec<&[usize]> = sampler.components().collect();
    components.sort_by_key(|members| members[0]);
    for members in components {
        let first = &variables[members[0]].name;
        let table = first.split('.').next().unwrap_or(first);
        let named = GROUPS.iter().find(|(_, tables)| tables.contains(&table));
        let name = named.map_or(table, |(name, _)| name);
        let drawn = members
            .iter()
            .copied()
            .filter(|&own| variables[own].scope != Scope::Structure);
        let drawn: Vec<usize> = drawn.collect();
        match groups.iter_mut().find(|(own, _)| own == name) {
            _ if drawn.is_empty() => {}
            Some((_, members)) => members.extend(drawn),
            None => groups.push((name.to_owned(), drawn)),
        }
    }
    groups
}

/// A draw, one of its groups, the set that its partner shares, and the partner.
struct PartnerDraw {
    row: usize,
    group: usize,
    shared: usize,
    draw: Draw,
}

/// Draws the partners of draws with fixed structures, computes their levels, and states the contributions, together
/// with a table of all partners.
///
/// # Errors
/// Those of the chain; [`Error::Table`] of the table.
pub fn group_study(
    graph: &Graph,
    design: &Design,
    request: &Request,
    made: &Draws,
    progress: &Progress,
) -> Result<(GroupStudy, Vec<u8>), Error> {
    if design.study().draws.is_some() {
        return Err(StudyError::JointDraws {
            problem: "tie the inputs of different groups together",
            help: "leave out --groups: contributions of joint draws are not separate",
        }
        .into());
    }
    let designs = [without_sensors(design)];
    let sampler = Sampler::new(&designs[0], made.variables.clone(), request.seed);
    let groups = groups(&sampler);
    let count = made.draws.len() * groups.len() * SHARED.len();
    progress.stage("shots of partners");
    let bases = [Values::clone(&designs[0])];
    let (mut planned, mut places) = (Vec::new(), Vec::new());
    for (row, draw) in made.draws.iter().enumerate() {
        let point = Point {
            shares: draw.shares.clone(),
        };
        for (group, (_, members)) in groups.iter().enumerate() {
            for (shared, _) in SHARED.iter().enumerate() {
                let anew = |(place, share): (usize, &f64)| !share.is_nan() && (shared == 0) != members.contains(&place);
                let active: Vec<bool> = draw.shares.iter().enumerate().map(anew).collect();
                let frame = Frame {
                    given: Some(&point),
                    partner_of: Some(row as u64),
                    ..Frame::new(&bases, &active, STREAM)
                };
                let found = screen(graph, (&designs, &sampler), frame, 1, Subset::All, |_| {});
                let found = match found {
                    Ok((found, _)) => found,
                    Err(Error::Study(StudyError::NothingDrawn { .. })) => Vec::new(),
                    Err(error) => return Err(error),
                };
                for candidate in found {
                    places.push((row, group, shared));
                    planned.push(Planned {
                        structure: 0,
                        candidate,
                    });
                }
            }
        }
        progress.done(places.len() as u64, count as u64);
    }
    let (draws, failures) = levels(graph, (&designs, &sampler), planned, Subset::All, progress)?;
    for (place, _) in failures.iter().rev() {
        places.remove(*place);
    }
    let partners = draws.into_iter().flatten().zip(places);
    let partners: Vec<PartnerDraw> = partners
        .map(|(draw, (row, group, shared))| PartnerDraw {
            row,
            group,
            shared,
            draw,
        })
        .collect();
    let table = csv(&groups, made, &partners)?;
    Ok((stated(&sampler, &groups, made, &partners), table))
}

/// Levels of a draw: each source, then the total.
fn levels_of(draw: &Draw) -> Vec<f64> {
    let table = LevelTable::new(std::slice::from_ref(draw));
    table.levels.concat().into_iter().chain(table.totals()).collect()
}

/// Levels of a draw and of those partners that there are, by group and by the part that they share.
struct Levels {
    base: Vec<f64>,
    partners: Vec<[Option<Vec<f64>>; 2]>,
}

impl Levels {
    /// Values of `figure` for the draw and for all its partners; none if one is missing.
    fn row(&self, figure: impl Fn(&[f64]) -> f64) -> Option<Row> {
        let pair = |[group, rest]: &[Option<Vec<f64>>; 2]| Some([figure(group.as_ref()?), figure(rest.as_ref()?)]);
        Some(Row {
            base: figure(&self.base),
            partners: self.partners.iter().map(pair).collect::<Option<_>>()?,
        })
    }
}

/// Results from the partners.
fn stated(sampler: &Sampler, groups: &[(String, Vec<usize>)], made: &Draws, partners: &[PartnerDraw]) -> GroupStudy {
    let of_draw = |draw: &Draw| Levels {
        base: levels_of(draw),
        partners: vec![[const { None }; 2]; groups.len()],
    };
    let mut all: Vec<Levels> = made.draws.iter().map(of_draw).collect();
    for own in partners {
        all[own.row].partners[own.group][own.shared] = Some(levels_of(&own.draw));
    }
    let names = LevelTable::new(&made.draws).names;
    let total = names.len();
    let rows = |figure: &dyn Fn(&[f64]) -> f64| -> Vec<Row> { all.iter().filter_map(|own| own.row(figure)).collect() };
    let mean = |source: usize| {
        let rows = rows(&|levels| levels[source]);
        rows.iter().map(|row| row.base).sum::<f64>() / rows.len().max(1) as f64
    };
    let mut order: Vec<usize> = (0..total).collect();
    order.sort_by(|a, b| mean(*b).total_cmp(&mean(*a)));
    let mut outputs: Vec<(String, Vec<usize>)> = vec![(TOTAL.to_owned(), vec![total])];
    outputs.extend(order.iter().map(|&source| (names[source].clone(), vec![source])));
    if let [first, second, ..] = order[..] {
        outputs.push((format!("{} less {}", names[first], names[second]), vec![first, second]));
    }
    let contributions = |(output, places): (String, Vec<usize>)| {
        let rows = rows(&|levels| match places[..] {
            [one, other] => levels[one] - levels[other],
            _ => levels[places[0]],
        });
        let finite = |row: &Row| row.base.is_finite() && row.partners.iter().flatten().all(|level| level.is_finite());
        let (estimates, variance_db2) = rows.iter().all(finite).then(|| indices(&rows)).flatten()?;
        let of_group = |((name, _), [first_order, total]): (&(String, Vec<usize>), [Estimate; 2])| GroupContribution {
            group: name.clone(),
            first_order,
            total,
        };
        let mut own: Vec<GroupContribution> = groups.iter().zip(estimates).map(of_group).collect();
        own.sort_by(|a, b| b.total.value.unwrap_or(0.0).total_cmp(&a.total.value.unwrap_or(0.0)));
        Some(GroupContributions {
            output,
            variance_db2,
            groups: own,
        })
    };
    let whole = rows(&|levels| levels[total]).len();
    let named = |(name, members): &(String, Vec<usize>)| Group {
        name: name.clone(),
        variables: members
            .iter()
            .map(|&own| sampler.variables()[own].name.clone())
            .collect(),
    };
    GroupStudy {
        groups: groups.iter().map(named).collect(),
        rows: whole,
        incomplete: all.len() - whole,
        outputs: outputs.into_iter().filter_map(contributions).collect(),
    }
}

/// `groups.csv`: a row for every draw and each of its partners, with levels \[dB re 1 pW s\].
fn csv(groups: &[(String, Vec<usize>)], made: &Draws, partners: &[PartnerDraw]) -> Result<Vec<u8>, Error> {
    let names = LevelTable::new(&made.draws).names;
    let header = ["draw", "group", "shares"].map(str::to_owned).into_iter();
    let levels = names.iter().map(String::as_str).chain([TOTAL]);
    let header = header.chain(levels.map(|name| format!("L_WA,1s {name} [dB]")));
    let row = |names: [String; 3], draw: &Draw| {
        let decibels = levels_of(draw).into_iter().map(|level| match level.is_finite() {
            true => format!("{level:.4}"),
            false => String::new(),
        });
        names.into_iter().chain(decibels).collect::<Vec<_>>()
    };
    let bases = made.draws.iter().enumerate();
    let bases = bases.map(|(number, draw)| row([number.to_string(), String::new(), "all".to_owned()], draw));
    let partners = partners.iter().map(|own| {
        let names = [
            own.row.to_string(),
            groups[own.group].0.clone(),
            SHARED[own.shared].to_owned(),
        ];
        row(names, &own.draw)
    });
    output::table(header, bases.chain(partners))
}
