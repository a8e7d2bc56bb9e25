//! The real case in size: its checks, its end, its replay.

mod transient_case;

use nailnoise_fem::transient::{Settings, SupportLaw, respond};

#[test]
fn probe() {
    for law in [SupportLaw::Unilateral, SupportLaw::Bonded] {
        let case = transient_case::block_on_table(160, 500, law);
        let settings = Settings {
            decay: f64::INFINITY,
            ..Settings::default()
        };
        let start = std::time::Instant::now();
        let r = respond(&case.bodies, &case.supports, &case.loads, &settings).unwrap();
        println!("{:?}", start.elapsed());
        println!("{:?} {:?} open {} {:?}", r.work, r.ending, r.open_fraction, r.checks);
        let e = &r.energy;
        for k in (0..e.time.len()).step_by(150) {
            println!(
                "{:.4} T {:.3e} {:.3e} V {:.3e} {:.3e} D {:.3e} {:.3e} Ec {:.2e} lost {:.4e} W {:.4e}",
                e.time[k],
                e.kinetic[0][k],
                e.kinetic[1][k],
                e.strain[0][k],
                e.strain[1][k],
                e.dissipated[0][k],
                e.dissipated[1][k],
                e.contact_elastic[k],
                e.contact_lost[k],
                e.work[k]
            );
        }
        let start = std::time::Instant::now();
        let a = r
            .modal(0, 0..160, nailnoise_fem::transient::Motion::Acceleration)
            .unwrap();
        println!("replay {:?} {}", start.elapsed(), a.max());
    }
}
