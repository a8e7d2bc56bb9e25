//! Attachments of a mesh: separately meshed bodies, lumped masses, springs to the ground.

use nailnoise_meshes::Location;
use nalgebra::{Matrix3, Point3};

/// Attachments of a mesh; none by default.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Attachments {
    /// Interfaces between bodies whose meshes do not share nodes.
    pub ties: Vec<Tie>,
    /// Rigid bodies fixed to face groups.
    pub masses: Vec<LumpedMass>,
    /// Springs to ground.
    pub springs: Vec<GroundSpring>,
}

/// A tied interface: each node of the slave group moves with the master element behind it.
///
/// The motion u(x_s) is the sum of N_a(x_s) u_a over the nodes of the element behind the nearest master face. The shape
/// functions are those of the volume, extrapolated beyond the face if the surfaces do not quite meet. They reproduce
/// every linear field, so the interface neither strains under rigid motion nor needs a stiffness; the slave's degrees
/// of freedom are eliminated. The finer of the two meshes should be the slave: motion that the master's field cannot
/// follow is not tied.
#[derive(Clone, Debug, PartialEq)]
pub struct Tie {
    /// Face group whose nodes follow.
    pub slave: String,
    /// Face group of the body they follow.
    pub master: String,
    /// Largest distance between a slave node and the master's faces \[m\].
    pub tolerance: f64,
}

/// How a lumped mass moves with the nodes of its group.
#[derive(Clone, Copy, Debug, PartialEq, Eq, serde::Serialize)]
pub enum Coupling {
    /// The nodes move with the mass as one rigid body, as on a stiff flange; they are eliminated.
    Rigid,
    /// The mass moves with the mean translation and rotation of the faces and stiffens nothing (an interpolation
    /// element, "RBE3"): it is eliminated.
    Distributed,
}

/// A rigid body fixed to the faces of a group.
#[derive(Clone, Debug, PartialEq)]
pub struct LumpedMass {
    /// The face group that carries it.
    pub group: String,
    /// Mass \[kg\].
    pub mass: f64,
    /// Inertia tensor about its own centre of mass \[kg m^2\].
    pub inertia: Matrix3<f64>,
    /// Its centre of mass, which may lie off the faces \[m\].
    pub centre: Point3<f64>,
    /// How it is fixed.
    pub coupling: Coupling,
}

/// Where a spring to ground acts.
#[derive(Clone, Debug, PartialEq)]
pub enum Place {
    /// Evenly over the faces of a group.
    Group(String),
    /// At a point of the mesh.
    Point(Location),
}

/// A massless spring between the mesh and the ground.
#[derive(Clone, Debug, PartialEq)]
pub struct GroundSpring {
    /// Where it acts.
    pub place: Place,
    /// Total stiffness, symmetric and positive semidefinite \[N/m\].
    pub stiffness: Matrix3<f64>,
}
