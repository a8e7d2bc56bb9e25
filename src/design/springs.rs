//! Springs and dashpots to the ground: a support of the user's own.

use super::dimension::{DAMPING, LENGTH, STIFFNESS};
use super::groups::{SupportKind, TableFoot, Values};
use super::schema::{any, choice, group, nonnegative};

choice! {
    /// What a spring holds.
    Sprung {
        /// The block of wood.
        Workpiece = "workpiece",
        /// The worktable.
        Worktable = "worktable",
    }
}

group! {
    /// Springs with dashpots beside them between a point of a body and the ground, one along each axis: a rubber foot, a
    /// strap, a beam of another machine. They push and pull, and their dashpots act in full, not as damping of modes. None
    /// has an effect while the design lacks its body. The origin is the centre of the workpiece's underside, x along its
    /// length, y along its width, z up.
    Spring {
        /// What it holds.
        body: Sprung = Sprung::KIND, "";
        /// Position along the workpiece's length.
        x: f64 = any(LENGTH), "x";
        /// Position along the workpiece's width.
        y: f64 = any(LENGTH), "y";
        /// Height above the workpiece's underside.
        z: f64 = any(LENGTH), "z";
        /// Radius of its foot: it acts evenly on the body's surface within this distance of its place; 0 at the point alone,
        /// whose give under a force grows as a mesh gets finer.
        radius: f64 = nonnegative(LENGTH), "a";
        /// Stiffness along x.
        stiffness_x: f64 = nonnegative(STIFFNESS), "k_x";
        /// Stiffness along y.
        stiffness_y: f64 = nonnegative(STIFFNESS), "k_y";
        /// Stiffness along z.
        stiffness_z: f64 = nonnegative(STIFFNESS), "k_z";
        /// Dashpot along x.
        damping_x: f64 = nonnegative(DAMPING), "c_x";
        /// Dashpot along y.
        damping_y: f64 = nonnegative(DAMPING), "c_y";
        /// Dashpot along z.
        damping_z: f64 = nonnegative(DAMPING), "c_z";
    }
}

impl Values {
    /// Whether the design has this body.
    pub(crate) fn has(&self, body: Sprung) -> bool {
        body == Sprung::Workpiece || self.support.kind == SupportKind::Worktable
    }

    /// Names of the springs whose body the design lacks.
    pub(crate) fn idle_springs(&self) -> Vec<&str> {
        let absent = self.springs.iter().filter(|(_, spring)| !self.has(spring.body));
        absent.map(|(name, _)| name.as_str()).collect()
    }

    /// Stiffness and damping along z of all springs on a body \[N/m\], \[N s/m\].
    pub(crate) fn sprung(&self, body: Sprung) -> [f64; 2] {
        let on = self.springs.values().filter(|spring| spring.body == body);
        on.fold([0.0; 2], |[k, c], spring| {
            [k + spring.stiffness_z, c + spring.damping_z]
        })
    }

    /// The body that stands on springs alone and has none along z, and the key that says so.
    pub(crate) fn not_carried(&self) -> Option<(Sprung, &'static str)> {
        let (body, key) = match (self.support.kind, self.support.worktable.foot) {
            (SupportKind::Springs, _) => (Sprung::Workpiece, "support.kind"),
            (SupportKind::Worktable, TableFoot::Springs) => (Sprung::Worktable, "support.worktable.foot"),
            _ => return None,
        };
        (self.sprung(body)[0] == 0.0).then_some((body, key))
    }
}
