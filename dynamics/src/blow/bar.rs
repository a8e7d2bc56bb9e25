//! An elastic bar as masses and springs, integrated by the leapfrog scheme.

use crate::network::assembly::Rod;

/// A bar with n elements: displacements of its n + 1 nodes at whole steps, their velocities half a step before.
///
/// ```text
/// m_i v_i' = k (u_{i-1} - u_i) + k (u_{i+1} - u_i) + f_i      k = E A/h, m = rho A h, half of it at the ends
/// v_{n+1/2} = v_{n-1/2} + dt f(u_n)/m                        u_{n+1} = u_n + dt v_{n+1/2}
/// ```
///
/// At the Courant number c dt/h = 1 the scheme propagates waves exactly.
#[derive(Debug, Clone)]
pub struct Bar {
    /// Masses of the nodes \[kg\].
    pub mass: Vec<f64>,
    /// Stiffness of an element \[N/m\].
    pub stiffness: f64,
    /// Displacements \[m\].
    pub displacement: Vec<f64>,
    /// Velocities \[m/s\].
    pub velocity: Vec<f64>,
    /// Loads on the nodes in the current step, without those of springs and contact \[N\].
    pub load: Vec<f64>,
    /// Work done by the loads so far \[J\].
    pub work: f64,
}

impl Bar {
    /// A rod in uniform motion at `velocity` \[m/s\].
    pub fn new(rod: &Rod, elements: usize, velocity: f64) -> Self {
        let element = rod.mass() / elements as f64;
        let mut mass = vec![element; elements + 1];
        mass[0] *= 0.5;
        mass[elements] *= 0.5;
        Self {
            mass,
            stiffness: rod.modulus * rod.area * elements as f64 / rod.length,
            displacement: vec![0.0; elements + 1],
            velocity: vec![velocity; elements + 1],
            load: vec![0.0; elements + 1],
            work: 0.0,
        }
    }

    /// Index of the last node.
    pub fn last(&self) -> usize {
        self.mass.len() - 1
    }

    /// Momentum half a step ago \[kg m/s\].
    pub fn momentum(&self) -> f64 {
        self.mass.iter().zip(&self.velocity).map(|(m, v)| m * v).sum()
    }

    /// Energy half a step ago \[J\]. The strain energy is the product of the springs' elongations before and after the
    /// step of `dt` \[s\]; without loads, its sum with the kinetic energy is constant in this scheme.
    pub fn energy(&self, dt: f64) -> f64 {
        let kinetic: f64 = self.mass.iter().zip(&self.velocity).map(|(m, v)| m * v * v).sum();
        let elongation = |i: usize| self.displacement[i + 1] - self.displacement[i];
        let growth = |i: usize| dt * (self.velocity[i + 1] - self.velocity[i]);
        let springs: f64 = (0..self.last())
            .map(|i| elongation(i) * (elongation(i) - growth(i)))
            .sum();
        0.5 * (kinetic + self.stiffness * springs)
    }

    /// Adds the forces of a dashpot \[N s/m\] along every element to the loads.
    pub fn add_damping(&mut self, dashpot: f64) {
        for i in 0..self.last() {
            let force = dashpot * (self.velocity[i + 1] - self.velocity[i]);
            self.load[i] += force;
            self.load[i + 1] -= force;
        }
    }

    /// Advances the velocities by `dt` \[s\] under springs and loads.
    fn kick(&mut self, dt: f64) {
        let mut tension = 0.0;
        for i in 0..self.mass.len() {
            let next = if i < self.last() {
                self.stiffness * (self.displacement[i + 1] - self.displacement[i])
            } else {
                0.0
            };
            let change = dt * (next - tension + self.load[i]) / self.mass[i];
            self.work += dt * self.load[i] * (self.velocity[i] + 0.5 * change);
            self.velocity[i] += change;
            tension = next;
        }
    }

    /// Applies an impulse \[N s\] to a node within the step of `dt` \[s\].
    fn strike(&mut self, node: usize, impulse: f64, dt: f64) {
        let change = impulse / self.mass[node];
        self.work += 0.5 * dt * self.load[node] * change;
        self.velocity[node] += change;
    }

    /// Advances the displacements by `dt` \[s\].
    fn drift(&mut self, dt: f64) {
        for (u, v) in self.displacement.iter_mut().zip(&self.velocity) {
            *u += dt * v;
        }
    }
}

/// Unilateral contact of the last node of one bar with the first node of another. It prevents the gap from becoming
/// negative within a step and transmits only compression.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct EndContact {
    /// Gap between the ends in the undeformed position \[m\].
    pub gap: f64,
    /// Force in the last step \[N\], not negative.
    pub force: f64,
    /// Energy lost in inelastic impacts of the two end masses so far \[J\]. It vanishes as the elements become smaller.
    pub loss: f64,
}

/// Advances both bars by `dt` \[s\] under their loads and the contact between them; the first bar pushes the second.
pub fn advance(first: &mut Bar, second: &mut Bar, contact: &mut EndContact, dt: f64) {
    let end = first.last();
    let before = first.velocity[end] - second.velocity[0];
    first.kick(dt);
    second.kick(dt);
    let gap = contact.gap + second.displacement[0] - first.displacement[end];
    let closing = first.velocity[end] - second.velocity[0] - gap / dt;
    let (behind, ahead) = (first.mass[end], second.mass[0]);
    let impulse = (closing * behind * ahead / (behind + ahead)).max(0.0);
    if impulse > 0.0 {
        first.strike(end, -impulse, dt);
        second.strike(0, impulse, dt);
        let after = first.velocity[end] - second.velocity[0];
        contact.loss += 0.5 * impulse * (before + after);
    }
    contact.force = impulse / dt;
    first.drift(dt);
    second.drift(dt);
}
