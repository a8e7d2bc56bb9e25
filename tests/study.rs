//! A thousand designs drawn from the ranges of the N80CB: something becomes of every one.
#![allow(clippy::unwrap_used)] // a test may panic, in its helpers too

use nailnoise::Design;
use nailnoise::design::Value;
use nailnoise::study::{Fate, study, taking_part};

fn design() -> Design {
    Design::load(concat!(env!("CARGO_MANIFEST_DIR"), "/designs/n80cb.toml")).unwrap()
}

#[test]
fn a_thousand_designs_have_an_outcome_and_none_fails_in_the_solver() {
    let study = study(&design(), 1000, 1).unwrap();
    assert_eq!(study.draws.len(), 1000);
    let failed: Vec<_> = study
        .draws
        .iter()
        .filter(|draw| matches!(draw.fate, Fate::SolverFailure(_)))
        .collect();
    assert!(failed.is_empty(), "{failed:#?}");
    let rare = |name: &str| -> Vec<usize> {
        study
            .draws
            .iter()
            .filter(|draw| draw.fate.name() == name)
            .map(|draw| draw.candidate)
            .collect()
    };
    insta::assert_json_snapshot!(serde_json::json!({
        "candidates": study.candidates,
        "refused": study.refused,
        "counts": study.counts,
        "dry_fire": rare("dry_fire"),
        "does_not_release": rare("does_not_release"),
        "strikes_bumper": rare("strikes_bumper"),
    }));
}

#[test]
fn draws_depend_on_the_seed_and_not_on_threads() {
    let draws = |seed: u64, threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        let study = pool.install(|| study(&design(), 12, seed).unwrap());
        study
            .draws
            .iter()
            .map(|d| (d.candidate, d.values.clone(), d.fate.name()))
            .collect::<Vec<_>>()
    };
    assert_eq!(draws(7, 1), draws(7, 2));
    assert_ne!(draws(7, 2)[0].1, draws(8, 2)[0].1);
}

#[test]
fn what_is_drawn_takes_part_in_the_cycle_and_stays_in_its_range() {
    let design = design();
    let parameters = taking_part(&design).unwrap();
    let keys: Vec<&str> = parameters.iter().map(|p| p.key.as_str()).collect();
    for key in [
        "supply.pressure",
        "exhaust.holes",
        "contacts.cap_stiffness",
        "support.worktable.stiffness",
    ] {
        assert!(keys.contains(&key), "{key}");
    }
    // The body's outline, the sand under a worktable and the meshes are no part of the shot.
    for group in ["body.", "support.sand.", "analysis.", "wood.elastic."] {
        assert!(!keys.iter().any(|key| key.starts_with(group)), "{group}");
    }
    let study = study(&design, 30, 3).unwrap();
    for draw in &study.draws {
        for (parameter, value) in study.parameters.iter().zip(&draw.values) {
            let value = match value {
                Value::Number(value) => *value,
                Value::Count(count) => f64::from(*count),
                other => panic!("{other:?}"),
            };
            let [low, high] = parameter.range;
            assert!((low..=high).contains(&value), "{} = {value}", parameter.key);
        }
    }
}
