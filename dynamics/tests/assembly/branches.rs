//! The reader checks both branches of an `if` in a formula. Keys of the unselected branch have no effect.

use crate::errors::{changed, refused};

#[test]
fn the_unselected_branch_is_checked() {
    refused(&[
        (
            "[cycle.passage.leak]\narea = \"=if(piston.bore > 1 mm, 3 mm2, 4 mm)\"",
            &["its branches are an area and a length"],
        ),
        (
            "[cycle.passage.leak]\narea = \"=if(piston.bore > 1 mm, 3 mm2, disc(piston.boer))\"",
            &["`piston.boer` is no key", "did you mean `piston.bore`?"],
        ),
        (
            "[cycle.passage.leak]\narea = \"=if(piston.bore > 1 mm, 3 mm2, 'wide')\"",
            &["its branches are a number and the word 'wide'"],
        ),
        (
            "[cycle.passage.fill.open]\ndelays = \"=if(piston.bore > 1 mm, 'flow', 'swiching')\"",
            &["\"swiching\"", "did you mean \"switching\"?"],
        ),
    ]);
}

#[test]
fn a_comparison_with_a_word_outside_the_choices_of_a_key_is_refused() {
    refused(&[
        (
            "[cycle.passage.leak]\none_way = \"=model.gas == 'publisht'\"",
            &["compares a key with 'publisht'", "did you mean 'published'?"],
        ),
        (
            "[cycle.passage.leak]\nif = \"exhaust.muffler.kind != 'nnoe'\"",
            &["compares a key with 'nnoe'", "did you mean 'none'?"],
        ),
    ]);
}

#[test]
fn the_unselected_branch_has_no_effect() {
    let area = |formula: &str| {
        let own = changed(&format!("[cycle.passage.leak]\narea = \"={formula}\""));
        own.unwrap_or_else(|error| panic!("{formula}: {error}"))
    };
    let plain = area("3 mm2");
    // The unselected branch divides by zero, or reads a key that no other formula reads.
    let infinite = area("if(piston.bore > 1 m, 3 mm2/(1 - 1), 3 mm2)");
    assert_eq!(plain.assembly, infinite.assembly);
    let key = "support.damping_ratio";
    let unread = area(&format!("if(piston.bore > 1 m, 3 mm2*{key}, 3 mm2)"));
    assert_eq!(plain, unread);
    assert!(
        area(&format!("if(piston.bore < 1 m, 3 mm2*{key}, 3 mm2)"))
            .keys
            .contains(key)
    );
}

/// Two names refer to each other, each in a branch that the other does not select.
#[test]
fn mutual_references_are_allowed_if_an_unselected_branch_breaks_the_circle() {
    let text = "[cycle.let]\nown_a = \"=if(piston.bore > 1 mm, 3 mm2, own_b)\"\n\
                own_b = \"=if(piston.bore > 1 mm, own_a, 2 mm2)\"\n[cycle.passage.leak]\narea = \"=own_b\"";
    assert!(changed(text).is_ok(), "{:?}", changed(text).err());
}
