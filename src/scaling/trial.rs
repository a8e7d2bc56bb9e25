//! Trial shots of a scaled design: the pressure and the depth adjustment at which it drives its fastener.

use nailnoise_dynamics::{CycleError, CycleRecord, Outcome};

use super::tool::PSI;
use crate::chain;
use crate::design::{Design, inputs};
use crate::error::Error;

/// Gauge pressures in the order in which they are tried \[psi\]: the usual one first, then the lowest that works.
const PRESSURES: [f64; 6] = [90.0, 80.0, 70.0, 100.0, 110.0, 120.0];

/// Depth adjustments in the order in which they are tried, as factors on the scaled protrusion of the rod.
const DEPTHS: [f64; 5] = [1.0, 0.75, 0.5, 0.25, 0.0];

/// Steps of Simpson's rule over the nail's length.
const STEPS: u32 = 1000;

/// Settings that the user of a tool chooses.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Setting {
    /// Gauge pressure at the inlet \[Pa\].
    pub pressure: f64,
    /// Ratio of the rod's protrusion to that of the rules.
    pub depth: f64,
    /// Whether the finger releases the trigger, because the recoil does not lift the tool far enough.
    pub by_hand: bool,
}

/// A shot of the design.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TrialShot {
    /// Its outcome.
    pub outcome: Outcome,
    /// Depth of the head below the surface \[m\]; negative if it protrudes.
    pub head_depth: f64,
    /// Work of the rod on nail and wood \[J\].
    pub energy_at_nail: f64,
}

/// A design at the setting that was chosen.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Settled {
    /// The setting: one that drives the fastener; otherwise the highest pressure with the deepest adjustment.
    pub setting: Setting,
    /// The shot at that setting.
    pub shot: TrialShot,
    /// Work of the penetration law over the length of the fastener \[J\].
    pub needed: f64,
    /// Energy delivered by the tool until the head is flush, at 100 psig \[J\], which manufacturers state as the energy
    /// of a tool. `None` if the tool is so strong that nothing stops its piston.
    pub tool_energy: Option<f64>,
}

impl TrialShot {
    fn of(record: &CycleRecord) -> Self {
        let own = &record.figures;
        Self {
            outcome: own.outcome,
            head_depth: own.summary.head_depth,
            energy_at_nail: own.energy.penetration + own.energy.nail_impact,
        }
    }

    /// Whether the nail is driven and its head is no deeper than the design allows.
    pub fn drives(&self) -> bool {
        match self.outcome {
            Outcome::Drives => true,
            Outcome::StrikesBumper => self.head_depth >= 0.0,
            _ => false,
        }
    }
}

/// Tries pressures and depth adjustments on the design that `make` gives for a setting.
///
/// A shot that stops on the wood is preferred to one whose piston hits the bumper.
pub(super) fn settle(make: &dyn Fn(Setting) -> Result<Design, Error>) -> Result<Settled, Error> {
    let mut driven = None;
    let mut last = None;
    'all: for psi in PRESSURES {
        for depth in DEPTHS {
            let setting = Setting {
                pressure: psi * PSI,
                depth,
                by_hand: false,
            };
            let (setting, shot) = released(make, setting)?;
            if depth == 1.0 {
                last = Some((setting, shot));
            }
            match shot.outcome {
                Outcome::Drives => {
                    driven = Some((setting, shot));
                    break 'all;
                }
                Outcome::StrikesBumper if shot.drives() && driven.is_none() => driven = Some((setting, shot)),
                // Less protrusion cannot drive deeper.
                Outcome::Underdriven | Outcome::DoesNotOpen => break,
                _ => {}
            }
        }
    }
    let usual = Setting {
        pressure: PRESSURES[0] * PSI,
        depth: 1.0,
        by_hand: false,
    };
    let (setting, shot) = match driven.or(last) {
        Some(found) => found,
        None => released(make, usual)?,
    };
    let stated = Setting {
        pressure: 100.0 * PSI,
        depth: 1.0,
        by_hand: false,
    };
    Ok(Settled {
        setting,
        shot,
        needed: needed(&make(setting)?)?,
        tool_energy: tool_energy(&make(stated)?)?,
    })
}

/// A shot whose trigger is released by hand if the recoil does not release it.
fn released(make: &dyn Fn(Setting) -> Result<Design, Error>, setting: Setting) -> Result<(Setting, TrialShot), Error> {
    let design = make(setting)?;
    let record = match chain::cycle(&design) {
        // Nothing stops the piston before the bumper is compressed to its limit.
        Err(Error::Cycle(CycleError::DryFire { .. })) => {
            let shot = TrialShot {
                outcome: Outcome::Overdriven,
                head_depth: design.piston.rod_protrusion,
                energy_at_nail: needed(&design)?,
            };
            return Ok((setting, shot));
        }
        record => record?,
    };
    let events = &record.figures.events;
    if events.t12.is_some() || events.t3.is_none() {
        return Ok((setting, TrialShot::of(&record)));
    }
    let by_hand = Setting {
        by_hand: true,
        ..setting
    };
    Ok((by_hand, TrialShot::of(&chain::cycle(&make(by_hand)?)?)))
}

/// Integral of the penetration law over the fastener's length \[J\].
fn needed(design: &Design) -> Result<f64, Error> {
    let envelope = inputs::cycle::parameters(design)?.penetration_envelope();
    let h = design.nail.length / f64::from(STEPS);
    let weight = |i: u32| match i {
        0 | STEPS => 1.0,
        i => f64::from(2 + 2 * (i % 2)),
    };
    let terms = (0..=STEPS).map(|i| weight(i) * envelope.shank((h * f64::from(i)).max(1e-9 * h)));
    Ok(terms.sum::<f64>() * h / 3.0)
}

/// Energy of a shot until the head is flush \[J\]: energy lost in the impact on the nail, work of the penetration law,
/// and energy left in piston and nail. `None` if nothing stops the piston.
fn tool_energy(design: &Design) -> Result<Option<f64>, Error> {
    let record = match chain::cycle(design) {
        Err(Error::Cycle(CycleError::DryFire { .. })) => return Ok(None),
        record => record?,
    };
    let [depth, velocity, mass] =
        ["nail.deepest", "piston.velocity", "piston.moving_mass"].map(|own| record.history(own));
    let flush = depth.iter().position(|depth| *depth >= design.nail.length);
    let taken = match flush {
        Some(sample) => {
            let (v, m) = (velocity[sample], mass[sample]);
            needed(design)? + 0.5 * m * v * v
        }
        None => record.figures.energy.penetration,
    };
    Ok(Some(record.figures.energy.nail_impact + taken))
}
