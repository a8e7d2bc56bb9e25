//! A sound absorbing cover on the tool.

use std::sync::LazyLock;

use nailnoise::Design;
use nailnoise::design::{Convention, CoverSurfaces};
use nailnoise::result::RankedSource;
use nailnoise::run::Run;

use crate::common::{store, try_run};
use crate::convention::CAPPED;

/// The capped bar under a cover of a thickness \[m\].
fn covered(surfaces: CoverSurfaces, thickness: f64, convention: Convention) -> Run {
    let mut design = CAPPED.clone();
    let cover = &mut design.body.cover;
    (cover.surfaces, cover.thickness) = (surfaces, thickness);
    design.sources.convention = convention;
    try_run(&design, store()).unwrap().0
}

static BARE: LazyLock<Run> = LazyLock::new(|| covered(CoverSurfaces::None, 0.03, Convention::Physical));
static COVERED: LazyLock<Run> = LazyLock::new(|| covered(CoverSurfaces::Both, 0.03, Convention::Physical));

fn body(run: &Run) -> &RankedSource {
    run.result.ranking.iter().find(|own| own.source == "body").unwrap()
}

/// Level of the body in a band \[dB\].
fn level(run: &Run, hz: f64) -> f64 {
    let band = body(run).bands.iter().find(|band| band.hz == hz).unwrap();
    band.lw_db.unwrap()
}

#[test]
fn a_cover_without_thickness_leaves_the_level() {
    let thin = covered(CoverSurfaces::Both, 0.0, Convention::Physical);
    let [thin, bare] = [&thin, &BARE].map(|run| body(run).lwa_db.unwrap());
    assert!((thin - bare).abs() < 1e-3, "{thin} and {bare} dB(A)");
}

#[test]
fn a_cover_lowers_high_frequencies_and_no_other_source() {
    let high = level(&COVERED, 2000.0) - level(&BARE, 2000.0);
    assert!(high < -1.0, "{high} dB");
    for own in BARE.result.ranking.iter().filter(|own| own.source != "body") {
        let other = COVERED.result.ranking.iter().find(|other| other.source == own.source);
        assert_eq!(other.unwrap().lwa_db, own.lwa_db, "{}", own.source);
    }
}

#[test]
fn parts_of_a_covered_body_add_up_to_the_same_total() {
    let wrapping = covered(CoverSurfaces::Both, 0.03, Convention::Wrapping);
    let energy = |run: &Run| 10f64.powf(0.1 * run.result.total.lwa_db.unwrap());
    assert!((energy(&wrapping) / energy(&COVERED) - 1.0).abs() < 1e-9);
}

#[test]
fn a_cover_on_the_cap_and_one_on_the_rest_differ_from_a_cover_on_both() {
    let [cap, rest] = [CoverSurfaces::Cap, CoverSurfaces::Housing]
        .map(|surfaces| level(&covered(surfaces, 0.03, Convention::Physical), 2000.0));
    let [bare, both] = [&BARE, &COVERED].map(|run| level(run, 2000.0));
    assert!(
        both < rest && rest < bare && both < cap && cap < bare,
        "{both} {rest} {cap} {bare} dB"
    );
}

#[test]
fn a_note_describes_the_cover_and_where_its_law_is_extrapolated() {
    let note = COVERED
        .result
        .method_notes
        .iter()
        .find(|note| note.contains("porous cover"));
    assert!(
        note.unwrap()
            .contains("30.0 mm with 10.0 kPa s/m2 on the housing and cap"),
        "{note:?}"
    );
    assert!(
        !BARE
            .result
            .method_notes
            .iter()
            .any(|note| note.contains("porous cover"))
    );
}

#[test]
fn a_cover_on_a_body_without_boundary_elements_is_refused() {
    let refused = |settings: &str| {
        let text = format!("base = \"n80cb.toml\"\nbody.cover.surfaces = \"both\"\n{settings}\n");
        Design::parse(&text, "designs/covered.toml").unwrap_err().to_string()
    };
    for (settings, value) in [
        ("body.model = \"rigid\"", "`body.model` is \"rigid\""),
        ("acoustics.body_method = \"erp\"", "`acoustics.body_method` is \"erp\""),
        (
            "acoustics.fluid_loading = \"full\"",
            "`acoustics.fluid_loading` is \"full\"",
        ),
        (
            "acoustics.bem_equations = \"compressed\"",
            "`acoustics.bem_equations` is \"compressed\"",
        ),
    ] {
        let error = refused(settings);
        assert!(error.contains(value), "{error}");
    }
}
