//! The work of the base design, frozen: a loss of efficiency fails like a wrong answer.

use nailnoise_dynamics::{Parameters, Settings, simulate};

#[test]
fn work_of_the_base_design() {
    let record = simulate(&Parameters::n80cb(), &Settings::default()).unwrap();
    insta::assert_json_snapshot!(record.work);
}
