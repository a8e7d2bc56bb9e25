//! Number, friction and coating of the shanks of a fastener.

/// How the fastener's resistance differs from that of a single shank.
#[derive(Debug, Clone, Copy)]
pub struct Shanks {
    /// Number of shanks: 1, or 2 for a staple. Each meets the wood like a single nail.
    pub legs: u32,
    /// Friction along the shank as a fraction of the force at full depth.
    pub friction_share: f64,
    /// Factor of a coating on the friction along the shank; 1 for a bright nail.
    pub coating: f64,
}

impl Shanks {
    /// One shank, with the friction share of a smooth nail (Nili Ahmadabadi 2016, sec. 2.4.3: 81 % of a 6d nail in
    /// poplar plywood).
    pub const SMOOTH: Self = Self {
        legs: 1,
        friction_share: 0.81,
        coating: 1.0,
    };
}
