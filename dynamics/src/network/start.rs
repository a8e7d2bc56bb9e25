//! The state at t = 0: bodies at rest on their contacts, gas at its initial pressure.

use super::assembly::{Base, Family, Start};
use super::error::RunError;
use super::mode::{Mode, depth, friction};
use super::plan::Plan;
use super::rates::Workspace;
use super::signals::Signals;

/// Number of iterations in the search for equilibrium.
const ITERATIONS: usize = 60;
/// Force that may remain, as a fraction of the sum of the forces' magnitudes.
const BALANCED: f64 = 1e-11;

/// State, mode and signals at t = 0.
pub(crate) struct Origin {
    pub(crate) y: Vec<f64>,
    pub(crate) mode: Mode,
    pub(crate) signals: Signals,
}

impl Plan {
    /// Computes the state at t = 0.
    ///
    /// Bodies that rest on a contact or a spring are in equilibrium. Newton's method finds it for the set of contacts
    /// under compression. A body with a prescribed travel transfers its forces to its parent.
    ///
    /// # Errors
    /// [`RunError::NotSeated`] if a body is lifted off its contact; [`RunError::NoEquilibrium`] if nothing supports a
    /// body.
    pub(crate) fn start(&self) -> Result<Origin, RunError> {
        let mut w = Workspace::new(self);
        let Origin {
            mut y,
            mut mode,
            signals,
        } = self.guess(&mut w);
        self.settle(&mut y, &mut mode, &mut w)?;
        self.check_seats(&y, &mode)?;
        self.place(&y, &mut w);
        for (i, volume) in self.assembly.volumes.iter().enumerate() {
            y[self.energy() + i] = volume.pressure * w.volume[i] / (self.gamma - 1.0);
            y[self.mass() + i] = volume.pressure * w.volume[i] / (self.gas_constant * volume.temperature);
        }
        self.instant(&y, &mode, &mut w);
        for plan in &self.frictions {
            if let Some(stick) = &plan.stick {
                mode.memory[stick.place] = w.travel(plan.pair);
                mode.switches[stick.switch] = match w.speed(plan.pair) {
                    v if v > 0.0 => friction::FORTH,
                    v if v < 0.0 => friction::BACK,
                    _ => friction::STUCK,
                };
            }
        }
        for passage in &self.passages {
            for way in passage.restrictions.iter().filter_map(|r| r.travel()) {
                let opening = way.sign * (w.travel(way.pair) - way.at);
                mode.switches[way.switch] = u8::from(opening > 0.0);
            }
        }
        for (i, fastener) in self.fasteners.iter().enumerate() {
            let z = self.depth(i, &w);
            if z > 0.0 {
                mode.switches[fastener.depth] = if z < fastener.length {
                    depth::LOADING
                } else {
                    depth::SEATED
                };
            }
        }
        Ok(Origin { y, mode, signals })
    }

    /// The state at t = 0 with the bodies where their contacts close without force.
    fn guess(&self, w: &mut Workspace) -> Origin {
        let mut mode = Mode::new(self);
        let signals = Signals::new(self, &mut mode);
        let mut y = vec![0.0; self.size()];
        self.first_guess(&mut y);
        for (i, volume) in self.assembly.volumes.iter().enumerate() {
            w.pressure[i] = volume.pressure;
        }
        for stick in self.frictions.iter().filter_map(|f| f.stick.as_ref()) {
            mode.switches[stick.switch] = friction::IDLE;
        }
        self.close_contacts(&y, &mut mode, w, true);
        Origin { y, mode, signals }
    }

    /// Computes only positions and velocities.
    fn place(&self, y: &[f64], w: &mut Workspace) {
        self.stand(y, None, w);
        for (i, volume) in self.volumes.iter().enumerate() {
            w.volume[i] = volume.dead;
        }
        for face in &self.faces {
            if let Some(i) = face.volume {
                w.volume[i] += face.area * (w.travel(face.pair) - face.zero);
            }
        }
    }

    /// Sets the initial positions of the bodies, parents first: the prescribed travel, or the position where the
    /// contact closes without force.
    fn first_guess(&self, y: &mut [f64]) {
        let ground = self.ground();
        // As many rounds as the longest chain of bodies may need.
        for _ in 0..self.bodies.len() {
            for (body, described) in self.assembly.bodies.iter().enumerate() {
                let at = |y: &[f64], other: usize| {
                    if other == ground {
                        [0.0; 2]
                    } else {
                        [y[2 * other], y[2 * other + 1]]
                    }
                };
                let [position, velocity] = match described.start {
                    Start::At { travel, speed } => {
                        let [base, rate] = at(y, self.bodies[body].parent);
                        [base + travel, rate + speed]
                    }
                    Start::RestOn(block) => {
                        let (pair, place) = match block.family {
                            Family::Contact => (self.contacts[block.index].pair, self.contacts[block.index].at),
                            Family::Spring => {
                                let spring = &self.springs[block.index];
                                (spring.pair, spring.free)
                            }
                            _ => continue,
                        };
                        let position = if pair.on == body {
                            at(y, pair.against)[0] + place
                        } else {
                            at(y, pair.on)[0] - place
                        };
                        [position, 0.0]
                    }
                };
                y[2 * body] = position;
                y[2 * body + 1] = velocity;
            }
        }
    }

    /// Closes the contacts that overlap and, if `seats`, those that a body rests on.
    fn close_contacts(&self, y: &[f64], mode: &mut Mode, w: &mut Workspace, seats: bool) {
        self.place(y, w);
        for (i, contact) in self.contacts.iter().enumerate() {
            let u = contact.overlap(w.travel(contact.pair), 0.0).0;
            let rested =
                seats
                    && self.assembly.bodies.iter().any(
                        |body| matches!(body.start, Start::RestOn(b) if b.family == Family::Contact && b.index == i),
                    );
            mode.switches[contact.switch] = u8::from(!contact.carries && (u > 0.0 || rested));
        }
        for spring in &self.springs {
            if let Some(switch) = spring.switch {
                mode.switches[switch] = u8::from(spring.compression(w.travel(spring.pair)) > 0.0);
            }
        }
    }

    /// For each body, the body that carries its forces: itself if it rests, else its first resting ancestor; none for
    /// the ground.
    fn carriers(&self) -> Vec<Option<usize>> {
        let rests = |body: usize| matches!(self.assembly.bodies[body].start, Start::RestOn(_));
        (0..self.bodies.len())
            .map(|body| {
                let mut carrier = body;
                for _ in 0..self.bodies.len() {
                    if rests(carrier) {
                        return Some(carrier);
                    }
                    carrier = match self.assembly.bodies[carrier].parent {
                        Base::Ground => return None,
                        Base::Body(parent) => parent,
                    };
                }
                None
            })
            .collect()
    }

    /// Forces on the resting bodies, including those transferred to them, and the sum of the magnitudes of all forces.
    fn static_forces(&self, y: &[f64], mode: &Mode, w: &mut Workspace, carriers: &[Option<usize>]) -> (Vec<f64>, f64) {
        self.place(y, w);
        w.velocity.fill(0.0);
        self.forces(0.0, mode, w);
        let mut force = vec![0.0; self.bodies.len()];
        let mut size = 0.0;
        for (body, carrier) in carriers.iter().enumerate() {
            let plan = &self.bodies[body];
            let own = w.force[body] + plan.mass * plan.gravity;
            size += plan.mass * plan.gravity.abs();
            if let Some(carrier) = carrier {
                force[*carrier] += own;
            }
        }
        size += self
            .faces
            .iter()
            .map(|face| (w.pressure[face.gas] * face.area).abs())
            .sum::<f64>();
        size += w.contact.iter().map(|contact| contact.force.abs()).sum::<f64>();
        size += w.imposed.iter().chain(&w.motor).map(|force| force.abs()).sum::<f64>();
        (force, size)
    }

    /// Newton's method for the positions of the resting bodies; contacts open and close according to their overlap.
    fn settle(&self, y: &mut [f64], mode: &mut Mode, w: &mut Workspace) -> Result<(), RunError> {
        match self.equilibrium(y, mode, w, true) {
            Some(remaining) => Err(self.unsettled(&remaining)),
            None => Ok(()),
        }
    }

    /// Newton's method as in [`settle`](Self::settle), with contacts that can `open` or else act in both directions.
    /// Returns the forces that remain if no equilibrium is found.
    fn equilibrium(&self, y: &mut [f64], mode: &mut Mode, w: &mut Workspace, open: bool) -> Option<Remaining> {
        let carriers = self.carriers();
        let resting: Vec<usize> = (0..self.bodies.len())
            .filter(|body| carriers[*body] == Some(*body))
            .collect();
        if resting.is_empty() {
            return None;
        }
        let velocities: Vec<f64> = (0..self.bodies.len()).map(|body| y[2 * body + 1]).collect();
        let n = resting.len();
        let shift = |y: &mut [f64], carrier: usize, by: f64| {
            for (body, of) in carriers.iter().enumerate() {
                if *of == Some(carrier) {
                    y[2 * body] += by;
                }
            }
        };
        // Rounding of positions leaves a force on a stiff contact that no step can remove.
        let rounding = 8.0 * f64::EPSILON * self.reach.max(1e-3);
        let mut moved = f64::INFINITY;
        for iteration in 0..ITERATIONS {
            let (force, size) = self.static_forces(y, mode, w, &carriers);
            let largest = |a: &usize, b: &usize| force[*a].abs().total_cmp(&force[*b].abs());
            let worst = resting.iter().copied().max_by(largest).unwrap_or(0);
            let left = force[worst].abs();
            let before = mode.switches.clone();
            if open && iteration > 0 {
                self.close_contacts(y, mode, w, false);
            }
            if (left <= BALANCED * size.max(1e-12) || moved <= rounding) && before == mode.switches {
                for (body, velocity) in velocities.iter().enumerate() {
                    y[2 * body + 1] = *velocity;
                }
                return None;
            }
            let (force, _) = self.static_forces(y, mode, w, &carriers);
            // Stiffnesses by finite differences with steps small compared with any stroke; the forces are smooth there.
            let step = 1e-7 * self.reach.max(1e-3);
            let mut stiffness = nalgebra::DMatrix::<f64>::zeros(n, n);
            for (column, body) in resting.iter().enumerate() {
                shift(y, *body, step);
                let (ahead, _) = self.static_forces(y, mode, w, &carriers);
                shift(y, *body, -2.0 * step);
                let (behind, _) = self.static_forces(y, mode, w, &carriers);
                shift(y, *body, step);
                for (row, other) in resting.iter().enumerate() {
                    stiffness[(row, column)] = -(ahead[*other] - behind[*other]) / (2.0 * step);
                }
            }
            let right = nalgebra::DVector::from_iterator(n, resting.iter().map(|body| force[*body]));
            let Some(change) = stiffness.lu().solve(&right).filter(|x| x.iter().all(|x| x.is_finite())) else {
                break;
            };
            for (body, by) in resting.iter().zip(change.iter()) {
                shift(y, *body, *by);
            }
            moved = change.amax();
        }
        let (force, _) = self.static_forces(y, mode, w, &carriers);
        let largest = |a: &usize, b: &usize| force[*a].abs().total_cmp(&force[*b].abs());
        let body = resting.iter().copied().max_by(largest).unwrap_or(0);
        Some(Remaining {
            body,
            force: force[body].abs(),
        })
    }

    /// The error for bodies without equilibrium: one that is lifted off its contact, or else the one with the largest
    /// force.
    fn unsettled(&self, remaining: &Remaining) -> RunError {
        let lifted = self
            .contacts_of_rest()
            .filter_map(|(body, contact)| Some((body, contact, self.press(contact)?)))
            .min_by(|a, b| a.2.total_cmp(&b.2));
        match lifted {
            Some((body, contact, press)) if press < 0.0 => self.not_seated(body, contact, press),
            _ => RunError::NoEquilibrium {
                body: self.assembly.bodies[remaining.body].name.clone(),
                unbalanced: remaining.force,
            },
        }
    }

    /// Bodies that rest on a contact, with its index.
    fn contacts_of_rest(&self) -> impl Iterator<Item = (usize, usize)> {
        let bodies = self.assembly.bodies.iter().enumerate();
        bodies.filter_map(|(body, described)| match described.start {
            Start::RestOn(block) if block.family == Family::Contact => Some((body, block.index)),
            _ => None,
        })
    }

    /// The load on a contact that a body rests on; negative if the contact would have to pull \[N\]. It is the force of
    /// the contact in the equilibrium with all such contacts acting in both directions. None if no such equilibrium
    /// exists.
    fn press(&self, contact: usize) -> Option<f64> {
        let mut w = Workspace::new(self);
        let Origin { mut y, mut mode, .. } = self.guess(&mut w);
        match self.equilibrium(&mut y, &mut mode, &mut w, false) {
            Some(_) => None,
            None => {
                let plan = &self.contacts[contact];
                Some(plan.push(self.overlap_at(&y, contact), 0.0).force)
            }
        }
    }

    /// Overlap of a contact in a state \[m\].
    fn overlap_at(&self, y: &[f64], contact: usize) -> f64 {
        let plan = &self.contacts[contact];
        let position = |i: usize| if i == self.ground() { 0.0 } else { y[2 * i] };
        let travel = position(plan.pair.on) - position(plan.pair.against);
        plan.overlap(travel, 0.0).0
    }

    fn not_seated(&self, body: usize, contact: usize, force: f64) -> RunError {
        RunError::NotSeated {
            contact: self.assembly.contacts[contact].name.clone(),
            body: self.assembly.bodies[body].name.clone(),
            force,
        }
    }

    /// Rejects bodies that are lifted off the contact they rest on, unless a latch holds them.
    fn check_seats(&self, y: &[f64], mode: &Mode) -> Result<(), RunError> {
        for (body, index) in self.contacts_of_rest() {
            let held = self
                .holds
                .iter()
                .any(|h| mode.is_on(h.switch) && (h.pair.on == body || h.pair.against == body));
            if mode.is_on(self.contacts[index].switch) || held {
                continue;
            }
            let force = self.press(index);
            let force = force.unwrap_or_else(|| self.contacts[index].push(self.overlap_at(y, index), 0.0).force);
            return Err(self.not_seated(body, index, force));
        }
        Ok(())
    }
}

/// The largest force without an equilibrium.
struct Remaining {
    body: usize,
    /// Its magnitude \[N\].
    force: f64,
}
