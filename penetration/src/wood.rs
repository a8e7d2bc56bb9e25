//! Wood properties used by the laws.

use nailnoise_quantities::dimension::{DENSITY, FORCE, LENGTH, NUMBER, STIFFNESS, VELOCITY, VELOCITY_SQUARED};
use nailnoise_quantities::{Kind, any, choice, fraction, group, nonnegative, positive};

use super::ResistanceLaw;

choice! {
    /// Dependence of the penetration resistance on the nail's speed.
    RateLaw {
        /// None: the quasi-static law at every speed.
        None = "none",
        /// Friction falls with speed, crushing strength rises with it.
        Speed = "speed",
    }
}

choice! {
    /// Force under the nail's head as it sinks into the wood.
    HeadLaw {
        /// A linear spring.
        Linear = "linear",
        /// A spring that yields at the pull-through resistance of the head.
        Yields = "yields",
    }
}

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

group! {
    /// The wood as the nail of a cycle meets it: the quasi-static wood and the effects of speed and of a sunk head.
    NailedWood {
        ..quasi_static: Wood;
        /// Dependence of the resistance on the nail's speed; a fitted law has its own.
        rate: RateLaw = RateLaw::KIND, "";
        /// Increase of the crushing strength per decade of speed; unused without a dependence on speed.
        crushing_rate: f64 = nonnegative(NUMBER).within(0.0, 1.0), "beta";
        /// Coefficient of friction of the shank in the wood at rest; unused without a dependence on speed.
        friction_at_rest: f64 = positive(NUMBER).within(0.01, 2.0), "m_0";
        /// Coefficient of friction at high speed; unused without a dependence on speed.
        friction_sliding: f64 = positive(NUMBER).within(0.01, 2.0), "m_1";
        /// Speed over which friction falls from rest to high speed; unused without a dependence on speed.
        friction_speed: f64 = positive(VELOCITY).within(1e-3, 1e3), "v_m";
        /// Speed of the shear waves that the shaken nail sends into the wood; used by an elastic blow only.
        shear_speed: f64 = positive(VELOCITY).within(10.0, 1e4), "c_s";
        /// Force under the nail's head.
        head_law: HeadLaw = HeadLaw::KIND, "";
        /// Multiplier on the pull-through resistance at which the head yields; unused with a linear head.
        head_yield_scale: f64 = positive(NUMBER).within(0.01, 100.0), "";
        /// Rise and fall of the tip's resistance in each growth ring that the nail crosses; 0 for wood without rings.
        ring_amplitude: f64 = fraction(), "a";
        /// Mean width of a growth ring; single ones differ from it by up to a quarter. Unused without rings.
        ring_width: f64 = positive(LENGTH).within(1e-4, 0.1), "s";
        /// Number from which the widths and the place of the surface in the first ring are drawn. Unused without rings.
        ring_seed: u32 = Kind::Count(1_000_000), "";
    }
}

impl NailedWood {
    /// A wood without effects of speed, with a linear spring under the head.
    pub fn quasi_static(wood: Wood) -> Self {
        Self {
            quasi_static: wood,
            rate: RateLaw::None,
            crushing_rate: 0.0,
            friction_at_rest: 1.0,
            friction_sliding: 1.0,
            friction_speed: 1.0,
            shear_speed: 700.0,
            head_law: HeadLaw::Linear,
            head_yield_scale: 1.0,
            ring_amplitude: 0.0,
            ring_width: 4e-3,
            ring_seed: 1,
        }
    }
}
