//! Effects of the ranges of a design on its shot and its levels.
//!
//! [`variables`] lists the variables, [`Sampler`] draws them, [`screen`] computes the shots of candidates and accepts
//! those that count, [`draws`] computes their levels, and [`StudyResult`] contains the results. [`shots`] draws only
//! for the cycle.

mod at_hand;
mod condition;
mod contributions;
mod correlation_ratio;
mod draw_table;
mod draws;
mod error;
mod group_indices;
mod groups;
mod jobs;
mod law;
pub mod legend;
mod level_table;
mod notes;
mod one_at_a_time;
mod paired;
mod parameters;
mod polynomial;
mod population;
mod provided;
mod request;
mod result;
mod sampling;
mod screening;
mod serving;
mod shots;
mod statistics;
mod study_store;
mod surrogate;
mod sweep;
mod table;
pub mod tasks;
pub mod tolerance;
mod variable_report;
mod variables;
mod weighted;

use nailnoise_calibration::normal;

pub use at_hand::{DrawnKey, DrawsAtHand};
pub use condition::{Condition, ConditionInput};
pub use contributions::{Contribution, Contributions};
pub use draw_table::DrawTable;
pub use draws::{Draw, Draws, common_draws, draws, nominal};
pub(crate) use draws::{code_of_joint_draws, code_of_levelled_draws, method_errors, outputs_of_draws};
pub use error::StudyError;
pub use groups::{Group, GroupContribution, GroupContributions, GroupStudy, group_study};
pub(crate) use jobs::{levels_of_shot, on_threads};
pub(crate) use level_table::total_of;
pub use level_table::{column, levels_of, value_at};
pub use one_at_a_time::{InputChanges, InputEnd, OneAtATime, one_at_a_time, one_at_a_time_csv};
pub use paired::{Change, PairedStudy};
pub use parameters::{Parameter, taking_part};
pub use provided::{FoundProvided, ProvidedState, ProvidedStudy};
pub use request::{Request, Subset};
pub use result::{
    Candidates, Convergence, LabelledStudy, LevelStudy, Louder, OrderProbability, SCHEMA, SourceStudy, StudyResult,
    names_of_ends,
};
pub use sampling::{Frame, NoValues, Point, Rejections, Sampler};
pub(crate) use screening::drawn;
pub use screening::{Candidate, Tally, screen};
pub use serving::{Serving, StudySource, study};
pub use shots::{Counted, DrawnShot, ShotSampler, Shots, cycle_variables, shots};
pub use statistics::{Estimate, Quantiles};
pub use study_store::{Found, store_study, stored_study};
pub use surrogate::{Surrogate, SurrogateIndex, common_reason};
pub(crate) use sweep::number as number_and_unit;
pub use sweep::{Axis, SweptPoint, at_point, distinct, sweep};
pub use table::draw_files;
pub use variable_report::VariableReport;
pub(crate) use variables::without_sensors;
pub use variables::{Drawn, Scope, Variable, VariableKind, common_variables, differing_keys, in_force, variables};

pub use crate::stages::outcomes::{ShotFigures, ShotOutcome};
