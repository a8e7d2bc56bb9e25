//! Splits the resistance into friction and deformation-fracture parts.
//!
//! A second drive of the nail into its own hole measures only friction. The difference from the first drive is the
//! deformation-fracture part (Nili Ahmadabadi 2016, sec. 2.4.3). Helical nails rotate, so their second drive does not
//! follow the thread of the first. The functions fitted are our own: friction f x, deformation D min(1, x/x_k).

use super::drive::Drive;

/// Parts of the resistance as functions of depth.
#[derive(Debug, Clone, PartialEq, serde::Serialize)]
pub struct Split {
    /// f, friction at full depth \[N\].
    pub friction: f64,
    /// D, deformation-fracture part beyond x_k \[N\].
    pub deformation: f64,
    /// x_k, depth y/NL beyond which the deformation-fracture part is constant.
    pub knee: f64,
    /// f/(f + D), `wood.friction_share`.
    pub friction_share: f64,
    /// Standard error of the share over the pairs of drives; none for a single pair.
    pub share_error: Option<f64>,
    /// Number of pairs of first and second drives.
    pub pairs: usize,
    /// Root mean square errors of the two functions \[N\].
    pub errors: [f64; 2],
}

/// Number of depths over the nail's length at which the split is computed.
const STATIONS: usize = 100;

/// Splits pairs of first and second drives into the same holes; none without a common depth.
pub fn split(pairs: &[(&Drive, &Drive)]) -> Option<Split> {
    let mut all: [Vec<(f64, f64)>; 2] = [Vec::new(), Vec::new()];
    let mut shares = Vec::new();
    let mut used = 0;
    for (first, second) in pairs {
        let mut own: [Vec<(f64, f64)>; 2] = [Vec::new(), Vec::new()];
        for station in 1..=STATIONS {
            let x = station as f64 / STATIONS as f64;
            if let (Some(whole), Some(friction)) = (force(first, x), force(second, x)) {
                own[0].push((x, friction));
                own[1].push((x, whole - friction));
            }
        }
        if own[0].len() < 2 {
            continue;
        }
        used += 1;
        let (friction, (deformation, _)) = (proportional(&own[0]), plateau(&own[1]));
        shares.push(friction / (friction + deformation));
        all.iter_mut().zip(own).for_each(|(all, own)| all.extend(own));
    }
    if used == 0 {
        return None;
    }
    let friction = proportional(&all[0]);
    let (deformation, knee) = plateau(&all[1]);
    let rms = |points: &[(f64, f64)], law: &dyn Fn(f64) -> f64| {
        (points.iter().map(|(x, f)| (f - law(*x)).powi(2)).sum::<f64>() / points.len() as f64).sqrt()
    };
    let count = shares.len() as f64;
    let mean = shares.iter().sum::<f64>() / count;
    let variance = shares.iter().map(|share| (share - mean).powi(2)).sum::<f64>() / (count - 1.0);
    Some(Split {
        friction,
        deformation,
        knee,
        friction_share: (friction / (friction + deformation)).clamp(0.0, 1.0),
        share_error: (used > 1).then(|| (variance / count).sqrt()),
        pairs: used,
        errors: [
            rms(&all[0], &|x| friction * x),
            rms(&all[1], &|x| deformation * (x / knee).min(1.0)),
        ],
    })
}

/// Force at x by linear interpolation; none beyond the points.
fn force(drive: &Drive, x: f64) -> Option<f64> {
    let depth = x * drive.conditions.specimen.length;
    let right = drive.points.partition_point(|point| point.depth < depth);
    let (a, b) = (drive.points.get(right.checked_sub(1)?)?, drive.points.get(right)?);
    let part = (depth - a.depth) / (b.depth - a.depth);
    let root = a.root + part * (b.root - a.root);
    Some(drive.conditions.force_scale() * root * root)
}

/// f of the line f x through the origin.
fn proportional(points: &[(f64, f64)]) -> f64 {
    let [xx, xf] = points
        .iter()
        .fold([0.0; 2], |[xx, xf], (x, f)| [xx + x * x, xf + x * f]);
    xf / xx
}

/// D and x_k of D min(1, x/x_k), with the best station as x_k.
fn plateau(points: &[(f64, f64)]) -> (f64, f64) {
    let fit = |knee: f64| {
        let shape = |x: f64| (x / knee).min(1.0);
        let [ss, sf] = points.iter().fold([0.0; 2], |[ss, sf], (x, f)| {
            [ss + shape(*x).powi(2), sf + shape(*x) * f]
        });
        let level = sf / ss;
        let error: f64 = points.iter().map(|(x, f)| (f - level * shape(*x)).powi(2)).sum();
        (level, error)
    };
    let knees = (1..=STATIONS).map(|station| station as f64 / STATIONS as f64);
    let best = knees
        .map(|knee| (knee, fit(knee)))
        .min_by(|a, b| a.1.1.total_cmp(&b.1.1));
    best.map_or((0.0, 1.0), |(knee, (level, _))| (level, knee))
}
