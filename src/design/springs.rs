//! Springs and dashpots to the ground: a support of the user's own.

use nailnoise_quantities::dimension::{DAMPING, LENGTH, STIFFNESS};
use nailnoise_quantities::{any, choice, group, nonnegative};

choice! {
    /// Body on a spring.
    Sprung {
        /// The block of wood.
        Workpiece = "workpiece",
        /// The worktable.
        Worktable = "worktable",
    }
}

group! {
    /// Springs with parallel dashpots between a point of a body and the ground, one along each axis: a rubber foot, a
    /// strap, a beam of another machine. They push and pull, and their dashpots act in full, not as damping of modes. A
    /// spring is ignored if the design does not have its body. The origin is the centre of the workpiece's underside, x
    /// along its length, y along its width, z up.
    Spring {
        /// The body it is attached to.
        body: Sprung = Sprung::KIND, "";
        /// Position along the workpiece's length.
        x: f64 = any(LENGTH), "x";
        /// Position along the workpiece's width.
        y: f64 = any(LENGTH), "y";
        /// Height above the workpiece's underside.
        z: f64 = any(LENGTH), "z";
        /// Radius of its foot: it acts evenly on the body's surface within this distance of its place; 0 at the point
        /// alone, whose give under a force grows as a mesh gets finer.
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
