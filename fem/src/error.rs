//! Errors of modal models, from the mesh to the modes.

/// An error of the modal models; every variant contains the numbers and names the remedy.
#[derive(Debug, thiserror::Error)]
pub enum FemError {
    /// A material constant is not a positive finite number.
    #[error("{what} is {value}; give a positive finite number")]
    NotPositive {
        /// Name of the constant.
        what: &'static str,
        /// The value found.
        value: f64,
    },
    /// The elastic constants imply negative strain energy for some strain.
    #[error(
        "the elastic constants are not positive definite: smallest eigenvalue of the scaled compliance is \
         {eigenvalue:e}; \
         lower the Poisson ratios (|nu_ij| < sqrt(E_i / E_j))"
    )]
    NotPositiveDefinite {
        /// Smallest eigenvalue of the compliance scaled to a unit diagonal.
        eigenvalue: f64,
    },
    /// The material axes are not orthogonal.
    #[error("the material axes deviate from orthonormal by {deviation:e}; give three unit vectors at right angles")]
    Axes {
        /// Largest entry of |Q^T Q - I|.
        deviation: f64,
    },
    /// Parts and materials do not match.
    #[error("the mesh has {parts} parts but {materials} materials were given; give one for each part")]
    Materials {
        /// Parts of the mesh.
        parts: usize,
        /// Materials given.
        materials: usize,
    },
    /// An element is inverted or degenerate.
    #[error("element {element} has Jacobian determinant {determinant:e} m^3; it is inverted or flat: repair the mesh")]
    Inverted {
        /// Element index.
        element: usize,
        /// The determinant found \[m^3\].
        determinant: f64,
    },
    /// No degree of freedom is free.
    #[error("all {dofs} degrees of freedom are constrained; free some of them")]
    NothingFree {
        /// Degrees of freedom of the mesh.
        dofs: usize,
    },
    /// The fill-reducing order could not be found.
    #[error("nested dissection failed: {reason}; check the mesh for disconnected or damaged elements")]
    Order {
        /// Reason given by the library.
        reason: String,
    },
    /// The system exceeds its index type or the available memory.
    #[error("the factor of {dofs} degrees of freedom does not fit; use a coarser mesh")]
    TooLarge {
        /// Degrees of freedom.
        dofs: usize,
    },
    /// A factorisation met an unusable pivot.
    #[error("factorisation of K - sigma M at sigma = {shift:e} failed at pivot {pivot}; check masses and constraints")]
    Pivot {
        /// Its shift \[(rad/s)^2\].
        shift: f64,
        /// Index of the pivot in elimination order.
        pivot: usize,
    },
    /// A factorisation does not reproduce its matrix.
    #[error("the factor of K - sigma M at sigma = {shift:e} has relative residual {residual:e} (limit {limit:e})")]
    Probe {
        /// Its shift \[(rad/s)^2\].
        shift: f64,
        /// Residual of a solve for a known vector.
        residual: f64,
        /// The limit.
        limit: f64,
    },
    /// The iteration did not converge.
    #[error(
        "{converged} of {wanted} modes converged within {vectors} Lanczos vectors; allow more or lower the frequency"
    )]
    NotConverged {
        /// Number of modes below the edge by the Sturm count.
        wanted: usize,
        /// Number of modes that converged.
        converged: usize,
        /// Number of vectors used.
        vectors: usize,
    },
    /// The number of modes found differs from the Sturm count.
    #[error("{found} modes found below {upper_hz} Hz, the Sturm count is {count}; change the upper frequency slightly")]
    Incomplete {
        /// Number of modes found.
        found: usize,
        /// Sturm count.
        count: usize,
        /// The edge \[Hz\].
        upper_hz: f64,
    },
    /// No edge without a nearby mode was found.
    #[error("modes lie too dense at {upper_hz} Hz for an edge between them; choose another upper frequency")]
    NoGap {
        /// The last edge tried \[Hz\].
        upper_hz: f64,
    },
    /// A mode does not satisfy its equation.
    #[error(
        "a mode has the residual {residual:e}, the limit is {limit:e}; repair badly shaped elements or raise the \
         limit (in a \
         design analysis.mode_tolerance)"
    )]
    Residual {
        /// The largest residual.
        residual: f64,
        /// The limit.
        limit: f64,
    },
    /// A load vector does not match the mesh.
    #[error("the loads have {found} rows, the mesh has {expected} degrees of freedom; give three rows a node")]
    LoadRows {
        /// Rows given.
        found: usize,
        /// Rows needed.
        expected: usize,
    },
    /// A constraint refers to a node that does not exist.
    #[error("node {node} is constrained, the mesh has {nodes} nodes")]
    Node {
        /// The node.
        node: usize,
        /// Number of nodes in the mesh.
        nodes: usize,
    },
    /// A node is tied to two masters.
    #[error("node {node} of face group \"{group}\" is tied already; make it the slave of one interface or mass only")]
    TiedTwice {
        /// The node.
        node: usize,
        /// The group of the second tie.
        group: String,
    },
    /// Ties depend on each other in a cycle.
    #[error("node {node} is tied to nodes that are tied to it; exchange master and slave of one interface")]
    TieCycle {
        /// A node of the cycle.
        node: usize,
    },
    /// A node is both fixed and tied.
    #[error(
        "node {node} is held along axis {axis} and tied as well; hold the master or take the node out of one group"
    )]
    HeldAndTied {
        /// The node.
        node: usize,
        /// The axis.
        axis: usize,
    },
    /// A face group cannot carry a mass or a spring.
    #[error("face group \"{group}\" has an area of {area} m^2 and does not resist rotation; choose more faces")]
    Patch {
        /// The group.
        group: String,
        /// Its area \[m^2\].
        area: f64,
    },
    /// An inertia tensor is physically impossible.
    #[error(
        "the lumped mass on \"{group}\" has the principal moments {moments:?} kg m^2; give a symmetric tensor with \
         each of them at most the sum of the others"
    )]
    Inertia {
        /// The group it is attached to.
        group: String,
        /// Principal moments \[kg m^2\].
        moments: [f64; 3],
    },
    /// A spring stiffness is not symmetric and positive semidefinite.
    #[error(
        "a spring's stiffness has asymmetry {asymmetry:e} N/m and lowest eigenvalue {lowest:e} N/m; give a symmetric \
         matrix without negative eigenvalues"
    )]
    Spring {
        /// Largest entry of |k - k^T| \[N/m\].
        asymmetry: f64,
        /// Lowest eigenvalue \[N/m\].
        lowest: f64,
    },
    /// A mesh error.
    #[error(transparent)]
    Mesh(#[from] nailnoise_meshes::MeshError),
}
