//! Values of a run for a declaration: sound power, and emission sound pressure at the operator's ear.

use maud::{Markup, html};

use super::typography::{with_code, with_subscripts};
use crate::declaration;
use crate::result::{RunResult, SourceLoudness};

/// The declared levels with their definitions, and K or the reason why it is not stated.
pub(super) fn section(result: &RunResult) -> Markup {
    let ear = &result.ear;
    let [along, across, height] = ear.position_m;
    html! {
        h3 { "Levels for a declaration (ISO 4871, EN 12549)" }
        ul.notes {
            @for line in declaration::lines(&result.declaration, ear) { li { (with_code(&line)) } }
            @if let Some(basis) = &result.declaration.k_basis { li { "sigma: " (basis) } }
            @if let Some(reason) = &result.declaration.k_not_stated { li { "K is not stated: " (with_code(reason)) } }
            @if !ear.loudness.is_empty() { li { (with_subscripts(&loudness(&ear.loudness))) } }
        }
        p.quiet {
            (with_subscripts("L_WA,1s in dB re 1 pW s, one shot; L_pA,1s in dB re 20 \u{b5}Pa over 1 s and L_pC,peak \
                in dB re 20 \u{b5}Pa at the operator's ear, "))
            (format!("x = {along:.2} m, y = {across:.2} m, z = {height:.2} m"))
            " from the middle of the block's underside (acoustics.ear_along, ear_across and ear_height). K = 1.645 \
             sigma over draws of inputs and methods is that of the sound power for all three. "
            @if ear.synthetic_share > 0.005 {
                (format!("{:.0} % ", 100.0 * ear.synthetic_share))
                "of the exposure at the ear lies above the frequencies to which phases are known."
            }
        }
    }
}

/// Loudness of the sources in one line.
fn loudness(sources: &[SourceLoudness]) -> String {
    let one = |own: &SourceLoudness| match own.n_max_sone.zip(own.level_phon) {
        Some((sone, phon)) => format!("{} {sone:.0} sone ({phon:.0} phon)", own.source),
        None => format!("{} above the range of the standard", own.source),
    };
    let all: Vec<String> = sources.iter().map(one).collect();
    format!(
        "Loudness N_max of one shot at the ear (ISO 532-1, time-varying, free field from the front): {}",
        all.join(", ")
    )
}
