//! How far the level of a bouncing block scatters.
//!
//! A block that flies and lands magnifies what no design can know: with gaps of a micrometre between it and its support
//! it comes down a little earlier here and later there, and rings differently. The response is computed for several such
//! starts; their spread is part of the level's uncertainty.

use nailnoise_acoustics::levels::Weighting;
use nailnoise_fem::transient::{ModalResponse, Support, SupportLaw};

use super::bodies::Structure;
use super::radiation;
use super::radiator::Radiator;
use super::vibration::modal_spectra;
use crate::design::{Design, SupportKind};
use crate::error::Error;
use crate::result::Starts;

/// Largest gap between block and support \[m\].
const GAP: f64 = 1e-6;

/// Opens the unilateral supports by gaps of 0 to 1 um, the same for the same start; the first start has none.
pub(super) fn open_gaps(supports: &mut [Support], start: u32) {
    if start == 0 {
        return;
    }
    // A linear congruence (Knuth's MMIX), high bits.
    let mut state = u64::from(start);
    let mut next = || {
        state = state
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1_442_695_040_888_963_407);
        (state >> 11) as f64 / (1u64 << 53) as f64
    };
    next();
    for support in supports
        .iter_mut()
        .filter(|support| support.law == SupportLaw::Unilateral)
    {
        support.gap += GAP * next();
    }
}

/// Levels of the workpiece for all starts, `first` being that of the run; none for one start or a block that is held.
///
/// # Errors
/// Those of the responses and of the radiation.
pub(super) fn starts(
    design: &Design,
    structure: &Structure,
    radiator: &Radiator,
    first: Option<f64>,
    mut response: impl FnMut(u32) -> Result<ModalResponse, Error>,
) -> Result<Option<Starts>, Error> {
    let held = match design.support.kind {
        SupportKind::Worktable | SupportKind::Floor => design.support.contact.bonded,
        SupportKind::Sandbox => design.support.sand.bonded,
        SupportKind::Clamped | SupportKind::Springs => true,
    };
    let (Some(first), false) = (first, held || design.analysis.starts < 2) else {
        return Ok(None);
    };
    let range = [design.analysis.range_low, design.analysis.range_high];
    let mut levels = vec![first];
    for start in 1..design.analysis.starts {
        let spectra = modal_spectra(design, structure, &response(start)?)?;
        let spectrum = radiation::workpiece_energy(radiator, &spectra)?;
        levels.extend(spectrum.level(range, Weighting::A));
    }
    let count = levels.len() as f64;
    let mean = levels.iter().sum::<f64>() / count;
    let squares: f64 = levels.iter().map(|level| (level - mean).powi(2)).sum();
    Ok(Some(Starts {
        mean_lwa_db: mean,
        deviation_db: (squares / (count - 1.0)).sqrt(),
        lwa_db: levels,
    }))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn gaps_open_what_can_let_go_and_differ_by_start() {
        let support = |law| Support {
            stiffness: 1.0,
            damping: 0.0,
            gap: 0.0,
            law,
        };
        let all = || {
            vec![
                support(SupportLaw::Unilateral),
                support(SupportLaw::Bonded),
                support(SupportLaw::Unilateral),
            ]
        };
        let opened = |start| {
            let mut supports = all();
            open_gaps(&mut supports, start);
            supports
        };
        assert_eq!(opened(0), all());
        let (one, two) = (opened(1), opened(2));
        assert_eq!(one[1], all()[1]);
        assert!(one[0].gap > 0.0 && one[0].gap <= GAP && one[0].gap != one[2].gap);
        assert_ne!(one, two);
        assert_eq!(one, opened(1));
    }
}
