//! Notes for a reader of the levels of the exhaust.

use nailnoise_acoustics::jets::ValveNoise;

use super::sound::{ExhaustDetails, Muffler, Openings};
use crate::stages::cycle::ShotRecord;

/// Part of the largest flow of an opening below which the flow counts as ended.
const ENDED: f64 = 0.05;

/// Notes on openings that still discharge at the end of the record.
pub(super) fn unended(record: &ShotRecord) -> impl Iterator<Item = String> {
    record.record.openings.iter().filter_map(|opening| {
        let last = *opening.mass_flow.last()?;
        let largest = opening.mass_flow.iter().copied().fold(0.0, f64::max);
        (last > ENDED * largest).then(|| {
            format!(
                "exhaust: {} still discharges {:.3} g/s at the end of the record, {:.0} % of its largest flow; the \
                 level excludes the rest: lengthen `end` of `[cycle]`, or `analysis.cycle_end`",
                opening.name,
                1e3 * last,
                100.0 * last / largest
            )
        })
    })
}

/// Notes on the methods of the exhaust, whose levels end at `range_high` \[Hz\].
pub(super) fn methods(
    range_high: f64,
    record: &ShotRecord,
    openings: &Openings,
    exhaust: &ExhaustDetails,
) -> Vec<String> {
    let mut notes = Vec::new();
    if let (Some(jets), Some(valve)) = (exhaust.jets_lw, exhaust.valve_noise_lw) {
        notes.push(format!(
            "exhaust jets, unweighted and over all frequencies: {jets:.1} dB, by {} as plates with drilled holes \
             {valve:.1} \
             dB. Their difference is the check; the level in the ranking is lower, because it ends at {range_high:.0} \
             Hz and is \
             that behind the muffler, where there is one; {:.0} % of the mixing noise is from jet speeds outside the \
             range of \
             its correlation",
            ValveNoise::STANDARD,
            100.0 * exhaust.outside_range
        ));
    }
    if let Some((duration, hz)) = exhaust.choked(record.sample_interval) {
        notes.push(format!(
            "exhaust: the holes are choked for {:.1} ms; a screech tone, if there is one, is above {:.1} kHz; its \
             level is not \
             predicted",
            1e3 * duration,
            1e-3 * hz
        ));
    }
    if let Some(jet) = exhaust.merged {
        notes.push(format!(
            "exhaust: {} holes {:.1} mm apart, at most 3 diameters: their jets merge and sound as one of {:.1} mm",
            openings.exhaust().map_or(0, |(own, _)| own.holes.count),
            1e3 * openings
                .exhaust()
                .and_then(|(own, _)| own.holes.pitch)
                .unwrap_or_default(),
            1e3 * jet.diameter
        ));
    }
    let outlet = openings.exhaust().map(|(_, outlet)| outlet);
    let temperature = exhaust.openings.first().map(|holes| holes.outflow_temperature);
    if let (Some(fitting), Some(temperature)) = (outlet.and_then(|own| own.fitting.as_ref()), temperature) {
        let limit = fitting
            .filled(temperature, &openings.air)
            .map_or(f64::NAN, |filled| filled.plane_wave_limit());
        let (gas, temperature) = match fitting.temperature {
            Some(own) => ("air", own),
            None => ("the outflow's gas", temperature),
        };
        notes.push(format!(
            "exhaust fitting: plane waves up to {limit:.0} Hz in {gas} at {temperature:.0} K, between \
             choked holes and an open end that its jet damps; above, the outflow radiates as if there were no \
             fitting. The jets of the holes are not filtered; the uncertainty of the level holds the case that they \
             are"
        ));
    }
    match outlet.and_then(|own| own.muffler.as_ref()) {
        None => {}
        Some(Muffler::InsertionLoss(_)) => notes.push(
            "muffler: its measured insertion loss is subtracted from the sound of the same shot without it; its back \
             pressure slows the cycle"
                .to_owned(),
        ),
        Some(Muffler::Chamber { .. }) => notes.push(
            "muffler: plane waves between a source of given volume flow and free space, damped by the jet at its \
             outlet; \
             the jets of the holes blow into the chamber, filled with outflow at its stagnation temperature; the \
             noise of \
             the jet at the outlet is counted, unmuffled"
                .to_owned(),
        ),
    }
    notes
}
