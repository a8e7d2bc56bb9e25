//! Every built-in assembly can be read and evaluated.

use std::collections::BTreeMap;

use nailnoise_dynamics::network::{AssemblyText, BUILT_IN, KeyValue};

use crate::common;
use crate::keys::keys;

#[test]
fn built_in_assemblies_are_complete_with_their_own_keys_or_those_of_the_base_design() {
    for (name, _) in BUILT_IN {
        let text = AssemblyText::built_in(name).unwrap_or_else(|| panic!("{name} is missing"));
        let text = text.unwrap_or_else(|error| panic!("{error}; {}", error.help()));
        let keys: BTreeMap<String, KeyValue> = if name.starts_with("n80cb") {
            keys(&common::n80cb())
        } else {
            BTreeMap::new()
        };
        let resolved = text
            .resolve(&keys)
            .unwrap_or_else(|error| panic!("{error}; {}", error.help()));
        // One that changes another has its name.
        assert!(
            name.starts_with(resolved.assembly.name.as_str()),
            "{name}: {}",
            resolved.assembly.name
        );
        assert!(resolved.assembly.end > 0.0);
    }
}

#[test]
fn every_own_key_is_used_and_has_a_provenance() {
    for (name, _) in BUILT_IN.iter().filter(|(name, _)| !name.starts_with("n80cb")) {
        let Some(Ok(text)) = AssemblyText::built_in(name) else {
            panic!("{name}")
        };
        let Ok(resolved) = text.resolve(&BTreeMap::<String, KeyValue>::new()) else {
            panic!("{name}")
        };
        for path in text.declared().keys() {
            let literal = resolved.literals.iter().find(|literal| literal.path == *path);
            let literal = literal.unwrap_or_else(|| panic!("{name}: {path} is not used"));
            assert!(!literal.provenance.is_empty(), "{name}: {path} has no provenance");
        }
    }
}
