//! A case of full size (block, table, 13 x 5 contact points): its checks and its counts of work.

use std::sync::LazyLock;

use nailnoise_fem::vibration::{ModalResponse, Settings, SupportLaw, Work, respond};

use crate::block_on_table::block_on_table;

static RESPONSE: LazyLock<ModalResponse> = LazyLock::new(|| {
    let case = block_on_table(160, 500, SupportLaw::Unilateral);
    let settings = Settings {
        duration: 0.08,
        ..Settings::default()
    };
    respond(&case.bodies, &case.supports, &case.loads, &settings).unwrap()
});

#[test]
fn a_bouncing_block_of_full_size_passes_its_checks() {
    let r = &*RESPONSE;
    crate::passes_its_checks(r);
    assert!(r.checks[0].value < 1e-6, "{:?}", r.checks[0]);
}

#[test]
fn the_block_bounces_and_loses_energy_in_its_contacts() {
    let r = &*RESPONSE;
    assert!(r.open_fraction > 0.1, "{}", r.open_fraction);
    assert!(r.energy.contact_lost.last().unwrap() > &0.0);
}

#[test]
fn the_run_needs_as_much_work_as_before() {
    let r = &*RESPONSE;
    // The number of static iterations depends on rounding.
    assert!(r.work.static_iterations <= 12, "{:?}", r.work);
    insta::assert_json_snapshot!(Work { static_iterations: 0, ..r.work }, @r#"
    {
      "steps": 20000,
      "contact_steps": 4438,
      "contact_iterations": 505,
      "contact_changes": 684,
      "factorisations": 0,
      "static_iterations": 0,
      "modes_beyond_step": 0
    }
    "#);
}

#[test]
fn a_repeated_run_has_the_same_bits() {
    let case = block_on_table(40, 60, SupportLaw::Unilateral);
    let settings = Settings {
        duration: 0.03,
        ..Settings::default()
    };
    let [a, b] = [(), ()].map(|()| respond(&case.bodies, &case.supports, &case.loads, &settings).unwrap());
    assert_eq!(a.contact_forces, b.contact_forces);
    assert_eq!(a.end, b.end);
}
