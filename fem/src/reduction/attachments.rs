//! Attachments of a mesh: separately meshed bodies, lumped masses, springs to the ground.

use nailnoise_meshes::Location;
use nalgebra::{Matrix3, Point3};

/// Attachments of a mesh; empty by default.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Attachments {
    /// Connections between bodies whose meshes share no nodes.
    pub ties: Vec<Tie>,
    /// Rigid bodies attached to face groups.
    pub masses: Vec<LumpedMass>,
    /// Springs to ground.
    pub springs: Vec<GroundSpring>,
}

/// A tied interface: each node of the slave group moves with the master element behind it.
///
/// The displacement u(x_s) is the sum of N_a(x_s) u_a over the nodes of the element behind the nearest master face. The
/// shape functions are those of the volume, extrapolated beyond the face if the surfaces do not quite meet. They
/// reproduce every linear field, so rigid motion does not strain the interface. The slave's degrees of freedom are
/// eliminated, so no interface stiffness is needed. The finer mesh should be the slave; otherwise, deformation that the
/// master cannot represent is suppressed.
#[derive(Clone, Debug, PartialEq)]
pub struct Tie {
    /// Face group whose nodes are tied.
    pub slave: String,
    /// Face group that they are tied to.
    pub master: String,
    /// Largest distance between a slave node and the master's faces \[m\].
    pub tolerance: f64,
}

/// How a lumped mass is coupled to the nodes of its group.
#[derive(Clone, Copy, Debug, PartialEq, Eq, serde::Serialize)]
pub enum Coupling {
    /// The nodes move with the mass as a rigid body, as on a stiff flange; they are eliminated.
    Rigid,
    /// The mass follows the mean translation and rotation of the faces without stiffening them (an interpolation
    /// element, "RBE3"); it is eliminated.
    Distributed,
}

/// A rigid body attached to the faces of a group.
#[derive(Clone, Debug, PartialEq)]
pub struct LumpedMass {
    /// The face group it is attached to.
    pub group: String,
    /// Mass \[kg\].
    pub mass: f64,
    /// Inertia tensor about its own centre of mass \[kg m^2\].
    pub inertia: Matrix3<f64>,
    /// Its centre of mass, which need not lie on the faces \[m\].
    pub centre: Point3<f64>,
    /// How it is coupled.
    pub coupling: Coupling,
}

/// Where a spring to ground acts.
#[derive(Clone, Debug, PartialEq)]
pub enum Place {
    /// Uniformly over the faces of a group.
    Group(String),
    /// At a point of the mesh.
    Point(Location),
}

/// A massless spring between the mesh and the ground.
#[derive(Clone, Debug, PartialEq)]
pub struct GroundSpring {
    /// Point or faces at which it acts.
    pub place: Place,
    /// Total stiffness, symmetric and positive semidefinite \[N/m\].
    pub stiffness: Matrix3<f64>,
}
