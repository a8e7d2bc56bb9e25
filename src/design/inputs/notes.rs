//! Inputs of the notes: a sentence for the fitted law, and one for each value outside its range.

use nailnoise_penetration::fit::{Placement, Variable};

use super::cycle::{conditions, fitted_law as law_of};
use super::radiation::cap;
use crate::design::{Convention, Design, VentSource, Warning};
use crate::error::Error;
use crate::stages::cycle::{ShotRecord, SummaryFigures};

/// Parts that the wrapping convention assigns to another source; `None` for the physical convention.
pub(crate) fn convention(design: &Design) -> Option<String> {
    let own = &design.sources;
    if own.convention == Convention::Physical {
        return None;
    }
    let cap = if cap(design).is_some() {
        "the outer side of the cap counts to the exhaust, with its own term of the body's radiated energy and half of \
         each cross \
         term: where it absorbs sound of the rest its energy is negative and has no level"
    } else {
        "the cap stays with the body: the radiation of a rigid body, or as that of a sphere, has no surface from \
         which a part could \
         be taken"
    };
    let vent = match own.trigger_vent {
        VentSource::Body => "the trigger vent counts to the body",
        VentSource::Exhaust => "the trigger vent stays with the exhaust",
    };
    Some(format!(
        "sources as selective wrapping separates them: {cap}; {vent}; the total is the same"
    ))
}

/// Records of surfaces without effect; `None` if there are none.
pub(crate) fn idle_records(design: &Design) -> Option<String> {
    let names: Vec<String> = design
        .idle_records()
        .map(|(name, _)| format!("recorded_surfaces.{name}"))
        .collect();
    (!names.is_empty()).then(|| {
        format!(
            "records of surfaces without effect, because their body is built in or absent: {}",
            names.join(", ")
        )
    })
}

/// How the shot of an assembly ended.
pub(crate) fn outcome_of_assembly(shot: &ShotRecord) -> String {
    let figures = |end: &str| match &shot.figures {
        SummaryFigures::Keys(_) => Vec::new(),
        SummaryFigures::Assembly(figures) => {
            let named = figures
                .iter()
                .filter_map(|(name, value)| Some((name.strip_suffix(end)?, *value)));
            named.map(|(name, value)| (name.replace('_', " "), value)).collect()
        }
    };
    let depths = figures("_depth")
        .into_iter()
        .map(|(name, depth)| format!("; {name} {:.1} mm deep", 1e3 * depth));
    let depths: String = depths.collect();
    format!("outcome of the assembly: {}{depths}", shot.outcome.replace('_', " "))
}

/// Values outside the ranges that the design states.
pub(crate) fn outside_ranges(design: &Design) -> Vec<String> {
    warnings_in_words(design, |warning| matches!(warning, Warning::OutsideRange { .. }))
}

/// Bands without exhaust noise, which is computed up to a lower frequency than the levels.
pub(crate) fn exhaust_max_frequency(design: &Design) -> Vec<String> {
    warnings_in_words(design, |warning| matches!(warning, Warning::ExhaustTop { .. }))
}

fn warnings_in_words(design: &Design, is_wanted: impl Fn(&Warning) -> bool) -> Vec<String> {
    let warnings = design.warnings().iter().filter(|warning| is_wanted(warning));
    warnings.map(ToString::to_string).collect()
}

/// Position of the shot within the data range of a fitted penetration law; empty for other laws.
///
/// # Errors
/// Same as [`law_of`].
pub(crate) fn fitted_law(design: &Design, shot: &ShotRecord) -> Result<Vec<String>, Error> {
    let Some(law) = law_of(design)? else {
        return Ok(Vec::new());
    };
    let impact = shot.figures.get("speed_before_impact").filter(|_| law.dynamic());
    let places = law.placement(&conditions(design, &law, impact));
    let place = |place: &Placement| {
        let [low, high] = place.range;
        let inside = if place.inside {
            ""
        } else {
            ", beyond it: the law is extrapolated"
        };
        format!(
            "{} = {:.4} (data {low:.4} to {high:.4}{inside})",
            place.variable, place.value
        )
    };
    let mut notes = vec![format!(
        "fitted penetration law: {}",
        places.iter().map(place).collect::<Vec<_>>().join(", ")
    )];
    if law.form().uses(Variable::Decay) {
        notes.push(
            "v/v0 is limited to the range of the tests: in a tool the gas continues to push the piston, in the tests \
             nothing pushes the projectile"
                .to_owned(),
        );
    } else if let Some(rate) = &law.file().rate {
        notes.push(format!(
            "the fitted law depends on the speed by beta {:.3} and v_m {:.2} m/s, from tests at {:.2e} to {:.2e} m/s",
            rate.speed.crushing, rate.speed.width, rate.speeds_m_s[0], rate.speeds_m_s[1]
        ));
    } else if !law.dynamic() {
        notes.push(format!(
            "the tests of the fitted law end at {:.3} mm/s; what the wood does at the speed of the shot is not known \
             from them",
            1e3 * law.reference_speed()
        ));
    }
    Ok(notes)
}
