//! Actions of a shot on workpiece and support: supports, loads, duration.

use nailnoise_fem::vibration::{Loads, ModalBody, ModalResponse, Settings, Support, SupportLaw, respond};
use nalgebra::{DMatrix, DVector};
use serde::Serialize;

use super::coupling::{self, COUPLED_LOADS, Coupled, CoupledTool, couple};
use super::nail_force::{self, DrivenFastener};
use crate::error::Error;
use crate::result::Check;
use crate::stages::bodies::{Body, ContactCells, STATIONS};
use crate::stages::cycle::{Engine, ShotRecord};

/// Largest gap that [`open_gaps`] opens \[m\].
const GAP: f64 = 1e-6;

/// Response to the forces of a cycle.
#[derive(Debug)]
pub struct OneWay {
    /// Motion of the bodies.
    pub response: ModalResponse,
    /// Checks of the nail's force.
    pub checks: Vec<Check>,
}

/// Inputs of a response, without the bodies and the cycle.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct ShotInputs {
    /// Acceleration of gravity \[m/s2\].
    pub gravity: f64,
    /// The fastener in the workpiece; `None` for a tool that drives none.
    pub fastener: Option<DrivenFastener>,
    /// Springs and dashpots, in the order of the columns of [`Body::contacts`].
    pub supports: Vec<Support>,
    /// Mass of sand \[kg\] that moves with the base of the workpiece, and the contact cells that carry its weight.
    pub added_sand: Option<(f64, ContactCells)>,
    /// Step \[s\].
    pub step: f64,
    /// Maximum simulated time \[s\].
    pub duration: f64,
    /// Number of the start, which sets the gaps of supports that can lose contact; 0 for none.
    pub start: u32,
}

impl ShotInputs {
    /// Whether the workpiece can lose contact with its support.
    pub fn can_lose_contact(&self) -> bool {
        self.supports
            .iter()
            .any(|support| support.law == SupportLaw::Unilateral)
    }

    /// The same shot with another start.
    #[must_use]
    pub fn with_start(&self, start: u32) -> Self {
        Self { start, ..self.clone() }
    }

    /// The same shot on supports that cannot open.
    #[must_use]
    pub fn bonded(&self) -> Self {
        let bonded = |support: &Support| Support {
            law: SupportLaw::Bonded,
            ..*support
        };
        Self {
            supports: self.supports.iter().map(bonded).collect(),
            ..self.clone()
        }
    }

    /// Response to the forces of a cycle on the wood, times `force_scale`.
    ///
    /// # Errors
    /// The errors of the transient solver.
    pub fn one_way(&self, bodies: &[ModalBody], shot: &ShotRecord, force_scale: f64) -> Result<OneWay, Error> {
        let nail = self.fastener.as_ref().and_then(|own| nail_force::forces(own, shot));
        let loads = self.loads(shot, nail.as_ref().map(|nail| &nail.stations), force_scale);
        Ok(OneWay {
            response: respond(bodies, &self.opened(), &loads, &self.settings())?,
            checks: nail.map_or_else(Vec::new, |nail| nail.checks),
        })
    }

    /// Cycle and response together, each acting on the other.
    ///
    /// # Errors
    /// The errors of the cycle and of the transient solver, and an error if the two do not converge.
    pub fn two_way(&self, bodies: &[ModalBody], engine: &Engine) -> Result<Coupled, Error> {
        let tool = CoupledTool {
            engine,
            fastener: self.fastener.as_ref(),
            gravity: self.gravity,
        };
        couple(tool, bodies, &self.opened(), &self.settings())
    }

    /// A body with its loss factor, in the form that the transient solver needs. Loads of the shot act only on the
    /// workpiece, gravity on every body.
    pub(super) fn modal_body(&self, body: &Body, loss_factor: f64, workpiece: bool) -> ModalBody {
        let gravity = self.gravity;
        let weight = match self.added_sand {
            Some((sand, cells)) if workpiece => body.weight_in_sand(gravity, sand, &cells.grid()),
            _ => body.weight(gravity),
        };
        let modes = body.omega.len();
        let mut loads = DMatrix::zeros(modes, COUPLED_LOADS);
        loads.columns_mut(0, body.loads.ncols()).copy_from(&body.loads);
        loads.set_column(coupling::GRAVITY, &weight);
        ModalBody {
            name: body.name.to_owned(),
            omega: body.omega.clone(),
            zeta: vec![0.5 * loss_factor; modes],
            loads,
            supports: body.contacts.clone(),
        }
    }

    fn settings(&self) -> Settings {
        Settings {
            step: self.step,
            duration: self.duration,
            ..Settings::default()
        }
    }

    /// The supports with the gaps of this start.
    fn opened(&self) -> Vec<Support> {
        let mut supports = self.supports.clone();
        open_gaps(&mut supports, self.start);
        supports
    }

    /// Loads of the shot: the nail stations, nose with guard spring, gravity.
    ///
    /// After the record, the tool is off the wood and the nail at rest: the forces of the shot vanish, and only gravity
    /// remains.
    fn loads(&self, shot: &ShotRecord, fastener: Option<&DMatrix<f64>>, force_scale: f64) -> Loads {
        let mut history = DMatrix::zeros(COUPLED_LOADS, shot.len());
        if let Some(forces) = fastener {
            history.rows_mut(0, STATIONS).copy_from(forces);
        }
        for (sample, force) in shot.workpiece.iter().flat_map(|on| on.seat.iter().enumerate()) {
            history[(coupling::NOSE, sample)] = *force;
        }
        history *= force_scale;
        history.row_mut(coupling::GRAVITY).fill(1.0);
        let mut final_values = DVector::zeros(COUPLED_LOADS);
        final_values[coupling::GRAVITY] = 1.0;
        Loads {
            interval: shot.sample_interval,
            history,
            final_values: final_values.as_slice().to_vec(),
        }
    }
}

/// Opens the unilateral supports by gaps of 0 to 1 um that depend only on the start; start 0 has none.
fn open_gaps(supports: &mut [Support], start: u32) {
    if start == 0 {
        return;
    }
    // A linear congruence (Knuth's MMIX), high bits.
    let mut state = u64::from(start);
    let mut next = || {
        state = state
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1_442_695_040_888_963_407);
        (state >> 11) as f64 / (1u64 << 53) as f64
    };
    next();
    for support in supports
        .iter_mut()
        .filter(|support| support.law == SupportLaw::Unilateral)
    {
        support.gap += GAP * next();
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn gaps_open_unilateral_supports_alone_and_differ_by_start() {
        let support = |law| Support {
            stiffness: 1.0,
            damping: 0.0,
            gap: 0.0,
            law,
        };
        let all = || {
            vec![
                support(SupportLaw::Unilateral),
                support(SupportLaw::Bonded),
                support(SupportLaw::Unilateral),
            ]
        };
        let opened = |start| {
            let mut supports = all();
            open_gaps(&mut supports, start);
            supports
        };
        assert_eq!(opened(0), all());
        let (one, two) = (opened(1), opened(2));
        assert_eq!(one[1], all()[1]);
        assert!(one[0].gap > 0.0 && one[0].gap <= GAP && one[0].gap != one[2].gap);
        assert_ne!(one, two);
        assert_eq!(one, opened(1));
    }
}
