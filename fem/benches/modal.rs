//! Stage shares and growth with the number of degrees of freedom: `cargo bench -p nailnoise-fem`.

#[path = "../tests/bodies/mod.rs"]
mod bodies;

use std::time::Instant;

use nailnoise_fem::{ModalSettings, modes};

fn main() {
    let args: Vec<String> = std::env::args().collect();
    let full = args.iter().any(|a| a == "--full");
    for divisions in [[17, 6, 4], [22, 9, 6], [34, 13, 8], [50, 19, 12]] {
        if divisions[0] > 22 && !full {
            continue;
        }
        let start = Instant::now();
        let system = bodies::free_workpiece(divisions);
        let assembled = start.elapsed();
        let start = Instant::now();
        let basis = modes(&system, &ModalSettings { block: std::env::var("B").map_or(16, |b| b.parse().unwrap()), ..ModalSettings::below(10e3) }).unwrap();
        println!(
            "{divisions:?} dofs {} assembly {assembled:.2?} modes {:.2?} {} {:?} {:?}",
            basis.dofs,
            start.elapsed(),
            basis.hz.len(),
            basis.work,
            basis.sturm
        );
        println!("{:?}", &basis.hz[..18]);
        println!(
            "residual {:e} orth {:e}",
            basis.residuals.iter().fold(0.0, |a: f64, b| a.max(*b)),
            basis.orthonormality
        );
    }
}
