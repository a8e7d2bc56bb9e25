//! Wood properties used by the laws.

use nailnoise_quantities::dimension::{DENSITY, FORCE, NUMBER, STIFFNESS, VELOCITY_SQUARED};
use nailnoise_quantities::{any, group, nonnegative, positive};

use super::ResistanceLaw;

group! {
    /// The wood as the nail meets it.
    Wood {
        /// Density.
        density: f64 = positive(DENSITY), "rho_w";
        /// Hardness modulus; also the stiffness k_w of the wood under the nail's head.
        hardness_modulus: f64 = positive(STIFFNESS), "H_M";
        /// Law of penetration resistance.
        penetration_law: ResistanceLaw = ResistanceLaw::KIND, "F_r";
        /// Coefficient of the speed term of the solid-wood law, at its reference speed.
        speed_term: f64 = any(VELOCITY_SQUARED).within(-1e5, 1e5), "C8 v_ref^2";
        /// Coefficient of the slenderness term D/l_n of the solid-wood law.
        slenderness_term: f64 = any(NUMBER).within(-100.0, 100.0), "C9";
        /// Force of the constant law; unused with the others.
        penetration_force: f64 = nonnegative(FORCE), "";
        /// Multiplier on the penetration law.
        resistance_scale: f64 = nonnegative(NUMBER).within(0.0, 1e3), "Fr_scale";
        /// Multiplier on the stiffness under the nail's head, k_w = scale H_M.
        head_stiffness_scale: f64 = positive(NUMBER).within(1e-9, 1e3), "kw_scale";
        /// Unloading stiffness of the seated nail.
        unloading_stiffness: f64 = positive(STIFFNESS), "k_u";
    }
}
