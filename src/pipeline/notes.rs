//! What a reader must know beside the numbers of a run.

use nailnoise_dynamics::{CycleRecord, Outcome};

use super::exhaust::Exhaust;
use super::told::Told;
use crate::design::inputs::radiation::workpiece_floor;
use crate::design::{Design, MufflerKind, SupportKind};
use crate::result::RadiationReport;

/// How far the radiation of the workpiece is from what it is compared with.
fn radiation_note(what: &str, report: &RadiationReport) -> String {
    let decibels = |level: Option<f64>| level.map_or_else(|| "none".to_owned(), |level| format!("{level:.1} dB"));
    let difference = report.surface_difference_db.unwrap_or(0.0);
    let [least, most] = report.limit_error_db;
    format!(
        "{what}: boundary elements at {} frequencies up to {:.0} Hz and in the mean over neighbouring ones up to {:.0} Hz (surface \
         {difference:+.2} dB to the far field), the limit of high frequencies above, {} off where it takes over and {least:+.1} to \
         {most:+.1} dB in the last three bands of boundary elements; radiation efficiency 1 over all bands would give {}",
        report.frequencies,
        report.solved_hz[0],
        report.solved_hz[1],
        report
            .blend_error_db
            .map_or_else(|| "nothing".to_owned(), |error| format!("{error:+.1} dB")),
        decibels(report.erp_lwa_db),
    )
}

/// The same for a workpiece in sand.
fn flush_note(report: &RadiationReport) -> String {
    let level = report
        .erp_lwa_db
        .map_or_else(|| "none".to_owned(), |level| format!("{level:.1} dB"));
    format!(
        "workpiece in sand: Rayleigh's integral at {} frequencies, its power by the intensity on the surface {:+.3} dB to that \
         of the waves in all directions; radiation efficiency 1 of the block's top would give {level}",
        report.frequencies,
        report.surface_difference_db.unwrap_or(0.0),
    )
}

/// What the workpiece stands on, or hangs from.
fn standing(design: &Design) -> String {
    let support = &design.support;
    match support.kind {
        SupportKind::Worktable => format!("workpiece on worktable {}", support.worktable.preset.as_str()),
        SupportKind::Sandbox => "workpiece in sand".to_owned(),
        SupportKind::Floor => "workpiece alone on a rigid floor, its underside silent".to_owned(),
        SupportKind::Clamped => "workpiece alone, its underside held on a rigid floor".to_owned(),
        SupportKind::Springs if support.clearance > 0.0 => format!(
            "workpiece alone on its springs, its underside {:.3} m above the floor{}",
            support.clearance,
            match workpiece_floor(design) {
                Some(_) => "",
                None => ", which is left out of its power",
            }
        ),
        SupportKind::Springs => "workpiece alone on its springs and the floor, its underside silent".to_owned(),
    }
}

/// Notes on one run, most important first.
pub(super) fn notes(design: &Design, record: &CycleRecord, told: &Told, exhaust: &Exhaust) -> Vec<String> {
    let [workpiece, body] = &told.sources;
    let mut notes = vec![match record.outcome {
        Outcome::Drives => "the nail is driven".to_owned(),
        Outcome::StrikesBumper => "the piston strikes the bumper before it stops on the wood".to_owned(),
        Outcome::Underdriven => "the nail is not driven to its length".to_owned(),
        Outcome::DoesNotOpen => "the head valve does not open: no shot".to_owned(),
        Outcome::DoesNotRelease => "the tool does not rise far enough to release the trigger valve".to_owned(),
    }];
    notes.push(match (&workpiece.radiation, design.support.kind) {
        (Some(report), SupportKind::Sandbox) => flush_note(report),
        (Some(report), _) => radiation_note(&standing(design), report),
        (None, _) => format!(
            "{}: radiated power is the ERP reference (radiation efficiency 1), an estimate that is far too high at low \
             frequencies; it is the surface's own velocity alone, of which there is no second evaluation",
            standing(design)
        ),
    });
    match &told.stiffness {
        None => {
            let twice = body.radiation.as_ref().and_then(|report| report.surface_difference_db);
            notes.push(format!(
                "body: rigid motion only, without the vibration of its housing: a lower bound{}",
                twice.map_or_else(String::new, |decibels| format!(
                    "; its power by the surface of the sphere of its volume {decibels:+.3} dB to that by the sphere's far field"
                ))
            ));
        }
        Some([cap, rim]) => {
            notes.push(match &body.radiation {
                Some(report) => radiation_note("body, without what is nailed", report),
                None => "body: rigid motion, and vibration of its housing as ERP times the radiation efficiency of an \
                         oscillating sphere of its volume; an estimate of which there is no second evaluation"
                    .to_owned(),
            });
            notes.push(format!(
                "body: under the forces of the head valve the housing is as stiff as {:.0} N/um at the {} (the cycle's contact: \
                 {:.0}) and {:.0} N/um at the {} ({:.0}); this compliance is counted once, in the cycle's forces",
                1e-6 * cap.body,
                cap.place,
                1e-6 * cap.contact,
                1e-6 * rim.body,
                rim.place,
                1e-6 * rim.contact
            ));
        }
    }
    for part in &told.missing {
        notes.push(format!(
            "{} is absent above {:.0} Hz; its last octave continued would add {:.2} dB to the {}",
            part.part, part.top_hz, part.decibels, part.source
        ));
    }
    if let (Some(here), Some(there)) = (exhaust.jets_lw, exhaust.cross_check_lw) {
        notes.push(format!(
            "exhaust jets, unweighted and over all frequencies: {here:.1} dB, by the efficiencies of IEC 60534-8-3 {there:.1} \
             dB. Their difference is the check; the exhaust of the ranking is less, for it ends at {:.0} Hz and stands behind \
             the muffler where there is one; {:.0} % of the mixing noise is from jet speeds outside its correlation",
            design.analysis.range_high,
            100.0 * exhaust.outside_range
        ));
    }
    if let Some((duration, hz)) = exhaust.choked(record.sample_interval) {
        notes.push(format!(
            "exhaust: the holes are choked for {:.1} ms; a screech tone, should there be one, lies above {:.1} kHz, its \
             level is not predicted",
            1e3 * duration,
            1e-3 * hz
        ));
    }
    if let Some(jet) = exhaust.merged {
        notes.push(format!(
            "exhaust: {} holes {:.1} mm apart, at most 3 diameters: their jets merge and sound as one of {:.1} mm",
            design.exhaust.holes,
            1e3 * design.exhaust.pitch,
            1e3 * jet.diameter
        ));
    }
    if design.exhaust.muffler.kind == MufflerKind::Chamber {
        notes.push(
            "muffler: plane waves between a source of given volume flow and free space, damped by the jet at its outlet; \
             that jet's own noise is counted, unmuffled"
                .to_owned(),
        );
    }
    notes.push(told.ending.clone());
    let idle = super::sensors::idle(design);
    if !idle.is_empty() {
        notes.push(format!("sensors on bodies that this design lacks: {}", idle.join(", ")));
    }
    let limited = super::sensors::limited(design);
    if !limited.is_empty() {
        let each: Vec<String> = limited
            .iter()
            .map(|(name, hz)| format!("{name} at {hz:.0} Hz"))
            .collect();
        notes.push(format!(
            "sensors whose band ends with the modes of their body: {}",
            each.join(", ")
        ));
    }
    let idle = design.idle_springs();
    if !idle.is_empty() {
        notes.push(format!("springs on bodies that this design lacks: {}", idle.join(", ")));
    }
    notes.push("the tool's later landing is not part of the shot".to_owned());
    notes
}
