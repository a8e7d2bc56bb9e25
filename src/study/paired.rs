//! Two designs with common draws: the change of the levels from one to the other, and its uncertainty.

use schemars::JsonSchema;
use serde::Serialize;

use super::draws::Draws;
use super::level_table::LevelTable;
use super::request::Request;
use super::statistics::{Bootstrap, Estimate, Quantiles};
use super::variables::differing_keys;
use crate::design::Design;
use crate::result::TOTAL;
use crate::wording::drawn_structures;

/// A design compared with a reference by common draws. Everything that both share is the same in each draw, including
/// the errors of methods, and cancels in the change.
#[derive(Debug, Clone, Serialize, JsonSchema)]
pub struct PairedStudy {
    /// Name of the reference.
    pub reference: String,
    /// Name of the other design.
    pub design: String,
    /// Number of draws that count in both.
    pub draws: usize,
    /// Seed.
    pub seed: u64,
    /// Number of structures drawn; 0 if each design has its own fixed structure.
    pub structures: usize,
    /// Keys for which the designs have different values and that are not drawn.
    pub decided: Vec<String>,
    /// Each source, then the total.
    pub changes: Vec<Change>,
}

/// Change of a level from the reference to the design.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
pub struct Change {
    /// `workpiece`, `exhaust`, `body` or `total`.
    pub source: String,
    /// P5, P50 and P95 of the level of the design \[dB re 1 pW s\].
    pub level_db: Quantiles,
    /// P5, P50 and P95 of the change over the draws \[dB\].
    pub change_db: Quantiles,
    /// Mean change \[dB\].
    pub mean_db: Estimate,
    /// Probability that the design is quieter than the reference.
    pub quieter: Estimate,
    /// Width of the interval from P5 to P95 of the change \[dB\].
    pub width_db: Option<f64>,
    /// Width for the reference's level \[dB\]; without common draws, the change would be at least this wide.
    pub level_width_db: Option<f64>,
}

impl PairedStudy {
    /// Text on the basis of the changes.
    pub(crate) fn basis(&self) -> String {
        let decided = match self.decided.as_slice() {
            [] => "nothing".to_owned(),
            keys => keys.join(", "),
        };
        format!(
            "{} against {} over {} common draws (seed {}), {}; not drawn, because the designs differ in them: \
             {decided}",
            self.design,
            self.reference,
            self.draws,
            self.seed,
            drawn_structures(self.structures)
        )
    }

    /// Computes results from common draws of a reference and a design.
    pub fn new((reference, a): (&Design, &Draws), (design, b): (&Design, &Draws), request: &Request) -> Self {
        Self {
            reference: reference.name().to_owned(),
            design: design.name().to_owned(),
            draws: a.draws.len(),
            seed: request.seed,
            structures: a.structures,
            decided: differing_keys(&[reference, design]),
            changes: changes(a, b),
        }
    }
}

/// Change of each source, then of the total, from common draws of a reference and a design.
pub(super) fn changes(a: &Draws, b: &Draws) -> Vec<Change> {
    let clusters: Vec<usize> = a.draws.iter().map(|draw| draw.structure).collect();
    let bootstrap = Bootstrap::new(&clusters);
    let [of_a, of_b] = [a, b].map(|made| LevelTable::new(&made.draws));
    let width = |own: &Quantiles| Some(own.p95.value? - own.p05.value?);
    let change = |source: &str, before: &[f64], after: &[f64]| {
        // Silence in both counts as no change.
        let difference = |(a, b): (&f64, &f64)| if a == b { 0.0 } else { b - a };
        let changes: Vec<f64> = before.iter().zip(after).map(difference).collect();
        let change_db = bootstrap.quantiles(&changes);
        Change {
            source: source.to_owned(),
            level_db: bootstrap.quantiles(after),
            change_db,
            mean_db: bootstrap.mean(&changes),
            quieter: bootstrap.share(&changes.iter().map(|change| *change < 0.0).collect::<Vec<_>>()),
            width_db: width(&change_db),
            level_width_db: width(&bootstrap.quantiles(before)),
        }
    };
    let names = of_a.names.iter().enumerate();
    let mut changes: Vec<Change> = names
        .map(|(place, name)| change(name, &of_a.column(place), &of_b.column(of_b.place(name))))
        .collect();
    changes.push(change(TOTAL, &of_a.totals(), &of_b.totals()));
    changes
}
