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
        let mut mode = Mode::new(self);
        let signals = Signals::new(self, &mut mode);
        let mut y = vec![0.0; self.size()];
        self.first_guess(&mut y);
        let mut w = Workspace::new(self);
        for (i, volume) in self.assembly.volumes.iter().enumerate() {
            w.pressure[i] = volume.pressure;
        }
        for stick in self.frictions.iter().filter_map(|f| f.stick.as_ref()) {
            mode.switches[stick.switch] = friction::IDLE;
        }
        self.close_contacts(&y, &mut mode, &mut w, true);
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

    /// Sets the initial positions of the bodies, parents first: the prescribed travel, or the position in which the
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

    /// Closes the contacts that overlap and, if `seats`, those on which a body rests.
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
        let carriers = self.carriers();
        let resting: Vec<usize> = (0..self.bodies.len())
            .filter(|body| carriers[*body] == Some(*body))
            .collect();
        if resting.is_empty() {
            return Ok(());
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
        let mut left = f64::INFINITY;
        let mut worst = 0;
        // Rounding of positions leaves a force on a stiff contact that no step can remove.
        let rounding = 8.0 * f64::EPSILON * self.reach.max(1e-3);
        let mut moved = f64::INFINITY;
        for iteration in 0..ITERATIONS {
            let (force, size) = self.static_forces(y, mode, w, &carriers);
            let largest = |a: &usize, b: &usize| force[*a].abs().total_cmp(&force[*b].abs());
            worst = resting.iter().copied().max_by(largest).unwrap_or(0);
            left = force[worst].abs();
            let before = mode.switches.clone();
            if iteration > 0 {
                self.close_contacts(y, mode, w, false);
            }
            if (left <= BALANCED * size.max(1e-12) || moved <= rounding) && before == mode.switches {
                for (body, velocity) in velocities.iter().enumerate() {
                    y[2 * body + 1] = *velocity;
                }
                return Ok(());
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
        Err(self.unsettled(worst, left))
    }

    /// The error for a body without equilibrium.
    fn unsettled(&self, body: usize, unbalanced: f64) -> RunError {
        let name = |block| self.assembly.name_of(block).to_owned();
        match self.assembly.bodies[body].start {
            Start::RestOn(block) if block.family == Family::Contact => RunError::NotSeated {
                contact: name(block),
                body: self.assembly.bodies[body].name.clone(),
                force: -unbalanced,
            },
            _ => RunError::NoEquilibrium {
                body: self.assembly.bodies[body].name.clone(),
                unbalanced,
            },
        }
    }

    /// Rejects bodies that are lifted off the contact they rest on, unless a latch holds them.
    fn check_seats(&self, y: &[f64], mode: &Mode) -> Result<(), RunError> {
        for (body, described) in self.assembly.bodies.iter().enumerate() {
            let Start::RestOn(block) = described.start else {
                continue;
            };
            if block.family != Family::Contact {
                continue;
            }
            let contact = &self.contacts[block.index];
            let held = self
                .holds
                .iter()
                .any(|h| mode.is_on(h.switch) && (h.pair.on == body || h.pair.against == body));
            if mode.is_on(contact.switch) || held {
                continue;
            }
            let position = |i: usize| if i == self.ground() { 0.0 } else { y[2 * i] };
            let x = position(contact.pair.on) - position(contact.pair.against);
            let (u, _) = contact.overlap(x, 0.0);
            return Err(RunError::NotSeated {
                contact: self.assembly.name_of(block).to_owned(),
                body: described.name.clone(),
                force: contact.push(u, 0.0).force,
            });
        }
        Ok(())
    }
}
