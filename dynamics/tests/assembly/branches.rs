//! Both branches of an `if` in a formula are checked; the keys of the one that is not selected have no effect.

use crate::errors::{changed, refused};

#[test]
fn the_branch_that_is_not_selected_is_checked() {
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
fn a_word_that_a_key_cannot_be_is_refused_in_a_comparison() {
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
fn a_branch_that_is_not_selected_has_no_effect() {
    let area = |formula: &str| {
        let own = changed(&format!("[cycle.passage.leak]\narea = \"={formula}\""));
        own.unwrap_or_else(|error| panic!("{formula}: {error}"))
    };
    let plain = area("3 mm2");
    // A number that is not finite, and a key that is not read elsewhere.
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

/// Two names that refer to each other through branches of which one at a time is selected.
#[test]
fn names_may_refer_to_each_other_in_branches_of_which_one_is_selected() {
    let text = "[cycle.let]\nown_a = \"=if(piston.bore > 1 mm, 3 mm2, own_b)\"\n\
                own_b = \"=if(piston.bore > 1 mm, own_a, 2 mm2)\"\n[cycle.passage.leak]\narea = \"=own_b\"";
    assert!(changed(text).is_ok(), "{:?}", changed(text).err());
}
