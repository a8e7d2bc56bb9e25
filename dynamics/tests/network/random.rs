//! Random assemblies end in a record with everything conserved, or in an error with a remedy.

use std::collections::BTreeMap;
use std::path::Path;

use nailnoise_documents::Document;
use nailnoise_dynamics::network::{AssemblyText, KeyValue, Numerics, RunError, simulate_balanced};

use crate::random_assembly::{Random, first_seed, random_assembly};

#[test]
fn random_assemblies_conserve_mass_energy_and_momentum() {
    let keys: BTreeMap<String, KeyValue> = BTreeMap::new();
    let numerics = Numerics {
        sample_interval: None,
        ..Numerics::default()
    };
    let mut ended = 0;
    let mut failed = Vec::new();
    let mut worst = (0.0, 0);
    for seed in first_seed()..first_seed() + 500 {
        let text = random_assembly(&mut Random::new(seed));
        let document = Document::new(Path::new("random.toml"), &text);
        let own = AssemblyText::open(&document).unwrap();
        let assembly = own.resolve(&keys).unwrap().assembly;
        match simulate_balanced(&assembly, &numerics) {
            Ok(record) => {
                ended += 1;
                let part = record.checks.iter().find(|check| check.name.ends_with("[-]"));
                let value = part.map_or(f64::INFINITY, |check| check.value.abs());
                if value > worst.0 {
                    worst = (value, seed);
                }
                for check in record.checks.iter().filter(|check| !check.ok) {
                    failed.push(format!("{seed}: {} {:e}", check.name, check.value));
                }
            }
            Err(error) => {
                println!("{seed}: {error}");
                let is_of_no_block = matches!(error, RunError::Integration { .. });
                let placed = own.placed(&assembly, error);
                assert!(is_of_no_block || placed.block.is_some(), "{seed}: {placed}");
            }
        }
    }
    println!(
        "{ended} of 500 end; largest error of the energy {:e} of that of gas and bodies, seed {}",
        worst.0, worst.1
    );
    assert!(failed.is_empty(), "{failed:#?}");
    assert!(worst.0 < 1e-6, "error of the energy {:e}, seed {}", worst.0, worst.1);
    assert!(ended > 400, "{ended} of 500 end");
}
