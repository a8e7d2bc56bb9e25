//! Declares a group of quantities, reads values with units into it, and prints the keys that a user may set.
//!
//! ```text
//! cargo run -p nailnoise-quantities --example declare_a_group
//! ```

use nailnoise_quantities::dimension::{LENGTH, MASS};
use nailnoise_quantities::{Found, Group, Value, group, measure, positive};

group! {
    /// Piston with its driver rod.
    Piston {
        /// Mass of piston and rod.
        mass: f64 = positive(MASS), "M_p";
        /// Travel from the upper stopper to the bumper.
        stroke: f64 = positive(LENGTH), "L";
    }
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let found = Found::from([
        ("piston.mass".to_owned(), Value::Number(measure("131 g", MASS)?)),
        ("piston.stroke".to_owned(), Value::Number(measure("121 mm", LENGTH)?)),
    ]);
    let piston = Piston::build("piston", &found)?;

    piston.visit("piston", &mut |name, key, value| {
        println!(
            "{name:14} {:4} {:2}  {} ({value:?})",
            key.symbol,
            key.unit(),
            key.description()
        );
    });
    assert!((piston.mass - 0.131).abs() < 1e-12 && (piston.stroke - 0.121).abs() < 1e-12);
    Ok(())
}
