//! The place of a prescribed workpiece among the bodies of a plan.

use super::assembly::{Assembly, Base, Start};
use super::drive::{Drive, Driven};
use super::error::RunError;
use super::mode::Mode;
use super::plan::{ContactPlan, Pair, Plan};
use super::rates::Workspace;

impl Plan {
    /// Compiles an assembly with an external structure instead of a body.
    ///
    /// # Errors
    /// The errors of [`new`](Plan::new), and [`RunError::Workpiece`].
    pub(crate) fn driven(assembly: &Assembly, body: usize) -> Result<(Self, Driven), RunError> {
        let mut assembly = assembly.clone();
        let refuse = |name: &str, reason| RunError::Workpiece {
            body: name.to_owned(),
            reason,
        };
        let Some(own) = assembly.bodies.get_mut(body) else {
            return Err(refuse("", "does not exist"));
        };
        if own.parent != Base::Ground {
            return Err(refuse(
                &own.name,
                "moves on another body, so that no structure can replace it",
            ));
        }
        if assembly.fasteners.iter().any(|fastener| fastener.driver == body) {
            return Err(refuse(
                &own.name,
                "drives a fastener, so that no structure can replace it",
            ));
        }
        // The structure has its own mass and weight.
        (own.mass, own.gravity) = (0.0, 0.0);
        own.start = Start::At {
            travel: 0.0,
            speed: 0.0,
        };
        for friction in &mut assembly.frictions {
            if friction.on == body && friction.against == Base::Ground {
                (friction.static_force, friction.sliding_force, friction.viscous) = (0.0, 0.0, 0.0);
                friction.stick = None;
            }
        }
        let plan = Self::compile(&assembly, Some(body))?;
        match plan.driven {
            Some(driven) => Ok((plan, driven)),
            None => Err(refuse("", "does not exist")),
        }
    }

    /// Index of the material that grips the fastener among the positions of the workspace. The motions of surface and
    /// grip without their forces follow.
    pub(crate) fn grip(&self) -> usize {
        self.ground() + 1
    }

    /// Sets the position of the driven body at the start.
    pub(crate) fn place_wood(&mut self, driven: &Driven, position: f64) {
        self.assembly.bodies[driven.body].start = Start::At {
            travel: position,
            speed: 0.0,
        };
    }

    /// Sets the states of the driven body to those at the start of a window.
    pub(crate) fn start_clock(&self, driven: &Driven, y: &mut [f64]) {
        (y[2 * driven.body], y[2 * driven.body + 1]) = (0.0, 1.0);
    }

    /// Positions and velocities of bodies and workpiece.
    #[inline]
    pub(crate) fn stand(&self, y: &[f64], wood: Option<&Drive>, w: &mut Workspace) {
        for body in 0..self.bodies.len() {
            w.position[body] = y[2 * body];
            w.velocity[body] = y[2 * body + 1];
        }
        if let Some(driven) = &self.driven {
            self.stand_wood(driven.body, y[2 * driven.body], wood, w);
        }
    }

    fn stand_wood(&self, body: usize, clock: f64, wood: Option<&Drive>, w: &mut Workspace) {
        let grip = self.grip();
        let Some(drive) = wood else {
            for place in grip..grip + 3 {
                (w.position[place], w.velocity[place]) = (w.position[body], w.velocity[body]);
            }
            return;
        };
        for (place, motion) in [body, grip, grip + 1, grip + 2].into_iter().zip(drive.motions(clock)) {
            (w.position[place], w.velocity[place]) = motion;
        }
        w.clock = clock;
        w.support = drive.support(clock);
    }

    /// Overlap of a contact and its rate as seen by its margin.
    ///
    /// A body that lands on the workpiece with a dashpot starts with a finite force, which pushes the workpiece away.
    /// With the motion due to that force, neither contact nor gap would be consistent. The contact test therefore uses
    /// the motion without it; the difference is of second order in the window length.
    pub(crate) fn approach(&self, contact: &ContactPlan, mode: &Mode, w: &Workspace) -> (f64, f64) {
        let mut pair = contact.pair;
        if let (Some([open, _]), Some(driven)) = (contact.landing, &self.driven)
            && mode.is_on(open)
            && !mode.is_on(contact.switch)
        {
            let free = |body: usize| if body == driven.body { self.grip() + 1 } else { body };
            pair = Pair {
                on: free(pair.on),
                against: free(pair.against),
            };
        }
        contact.overlap(w.travel(pair), w.speed(pair))
    }

    /// Depth of a fastener's tip for the test of contact, which uses the motion without the fastener's own force.
    pub(crate) fn touching(&self, fastener: usize, w: &Workspace) -> f64 {
        let plan = &self.fasteners[fastener];
        let mut pair = plan.work;
        if self.driven.is_some() && pair.against == self.grip() {
            pair.against = self.grip() + 2;
        }
        w.travel(pair) - plan.tip_at
    }
}
