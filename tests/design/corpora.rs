//! Bytes of any kind as files, and numbers of any size as values: the fuzz targets' corpora, and values drawn over all
//! magnitudes.

#[allow(unreachable_pub)] // public in the crate of the fuzz targets
#[path = "../../fuzz/src/lib.rs"]
mod targets;

use std::fs;
use std::path::Path;

use nailnoise::design::{Design, Kind, Values};
use nailnoise_quantities::Group;
use proptest::prelude::*;

#[test]
fn the_corpora_of_the_fuzz_targets_end_without_a_panic() {
    for (name, target) in targets::TARGETS {
        let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("fuzz/corpus").join(name);
        let mut files = 0;
        for entry in fs::read_dir(&folder).unwrap() {
            target(&fs::read(entry.unwrap().path()).unwrap());
            files += 1;
        }
        assert!(files > 0, "{} is empty", folder.display());
    }
}

/// Seeds of the target `design`, too: they are complete, even if keys are added.
#[test]
fn the_shipped_designs_end_without_a_panic() {
    let designs = Path::new(env!("CARGO_MANIFEST_DIR")).join("designs");
    for entry in fs::read_dir(&designs).unwrap() {
        let path = entry.unwrap().path();
        if path.extension().is_some_and(|end| end == "toml") {
            targets::design(&fs::read(path).unwrap());
        }
    }
}

/// Every number of the design file with its kind.
fn numbers() -> Vec<(String, Kind)> {
    let mut numbers = Vec::new();
    Values::SPEC.each_key("", &mut |key, spec| {
        if spec.kind.domain().is_some() && !key.contains(nailnoise_quantities::MEMBER) {
            numbers.push((key.to_owned(), spec.kind));
        }
    });
    numbers
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(2000))]

    /// A value of any magnitude is read or refused by its key, and every value that is read lies in the domain.
    #[test]
    fn a_value_of_any_magnitude_is_read_within_its_domain_or_refused(
        index in any::<prop::sample::Index>(), exponent in -300.0..300.0_f64, negative in any::<bool>(),
    ) {
        let numbers = numbers();
        let (key, kind) = &numbers[index.index(numbers.len())];
        let value = 10f64.powf(exponent) * if negative { -1.0 } else { 1.0 };
        let value = if matches!(kind, Kind::Count(_)) { format!("{:.0}", value.clamp(-1e18, 1e18)) }
            else { format!("{value:e}") };
        let text = format!("base = \"n80cb.toml\"\n{key} = {value}\n");
        let path = concat!(env!("CARGO_MANIFEST_DIR"), "/designs/any.toml");
        let number: f64 = value.parse().unwrap();
        match Design::parse(&text, path) {
            Ok(_) => prop_assert!(kind.allows(number), "{key} = {value} was read"),
            Err(error) => prop_assert!(kind.allows(number) || error.to_string().contains(key.as_str()),
                "{key} = {value}: {error}"),
        }
    }
}
