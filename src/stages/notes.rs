//! Notes of a run: facts that a reader needs in addition to its numbers.

use crate::result::{FluidLoading, FluidLoadingChange, Loading, RadiationReport};
use crate::stages::cycle::ShotRecord;

/// Notes on one source.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct SourceNotes {
    /// Notes on the shot: a level that is only an estimate or a bound, or ends at a lower frequency than the others.
    pub shot: Vec<String>,
    /// Notes on the method: its range, errors and limits.
    pub methods: Vec<String>,
}

/// Inputs of the notes of a run, in addition to its cycle.
pub struct NoteInputs<'a> {
    /// The outcome of the shot, in words.
    pub shot: String,
    /// Notes on each source.
    pub sources: Vec<SourceNotes>,
    /// Name of each source with fluid loading.
    pub fluid_loading: Vec<(&'a str, &'a FluidLoading)>,
    /// Levels with the frozen and the complete impedance of the air, if its mass acts.
    pub fluid_loading_changes: &'a [FluidLoadingChange],
    /// Parts without levels above a frequency.
    pub truncations: Vec<String>,
    /// How the response ended, in words; `None` for a tool without a workpiece.
    pub ending: Option<&'a str>,
    /// Names of the keys on which a landing of the tool depends.
    pub landing_keys: Vec<String>,
    /// Sensors on bodies that are not in the design.
    pub idle_sensors: Vec<&'a str>,
    /// Pressure transducers in chambers that the tool does not have.
    pub idle_transducers: Vec<&'a str>,
    /// Sensors whose band ends with the modes of their body, and the frequency of that end \[Hz\].
    pub limited_sensors: Vec<(&'a str, f64)>,
    /// Position of the shot within the range of a fitted penetration law, in words.
    pub fitted_law: Vec<String>,
    /// Values outside the ranges given by the design, in words.
    pub outside_ranges: Vec<String>,
    /// Springs on bodies that are not in the design.
    pub idle_springs: Vec<&'a str>,
    /// Surfaces on bodies that are built in.
    pub idle_surfaces: Vec<&'a str>,
    /// Surfaces that the program recognised, in words.
    pub guessed: Vec<String>,
    /// Parts that are not assigned by the physical convention, in words.
    pub convention: Option<String>,
}

/// Notes on a run, most important first.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Notes {
    /// Notes on the shot, the values of the design, and sources that are only estimated.
    pub shot: Vec<String>,
    /// Notes on methods: their ranges, errors and limits.
    pub methods: Vec<String>,
}

/// Notes on a run.
pub fn notes(inputs: &NoteInputs<'_>, record: &ShotRecord) -> Notes {
    let mut shot = vec![inputs.shot.clone()];
    shot.extend(inputs.fitted_law.iter().cloned());
    shot.extend(inputs.outside_ranges.iter().cloned());
    let landing = Landing::of(record);
    shot.extend(landing.as_ref().map(|own| own.note(&inputs.landing_keys)));
    shot.extend(inputs.sources.iter().flat_map(|source| source.shot.iter().cloned()));
    let list = |what: &str, names: &[&str]| (!names.is_empty()).then(|| format!("{what}: {}", names.join(", ")));
    shot.extend(list(
        "unused springs, because their body is not in this design",
        &inputs.idle_springs,
    ));
    shot.extend(list(
        "unused surfaces, because their body is built in or absent",
        &inputs.idle_surfaces,
    ));
    shot.extend(list(
        "unused pressure transducers, because the tool does not have their chamber",
        &inputs.idle_transducers,
    ));
    let guessed: Vec<&str> = inputs.guessed.iter().map(String::as_str).collect();
    shot.extend(list(
        "surfaces recognised by shape, because the body's file does not name them",
        &guessed,
    ));
    let of_sources = inputs.sources.iter().flat_map(|source| source.methods.iter().cloned());
    let mut methods: Vec<String> = of_sources.collect();
    methods.extend(loading_note(&inputs.fluid_loading));
    methods.extend(complete_impedance_note(inputs.fluid_loading_changes));
    methods.extend(inputs.truncations.iter().cloned());
    methods.extend(inputs.convention.iter().cloned());
    methods.extend(inputs.ending.map(str::to_owned));
    methods.extend(list(
        "unused sensors, because their body is not in this design",
        &inputs.idle_sensors,
    ));
    let limited: Vec<String> = inputs
        .limited_sensors
        .iter()
        .map(|(name, hz)| format!("{name} at {hz:.0} Hz"))
        .collect();
    let limited: Vec<&str> = limited.iter().map(String::as_str).collect();
    methods.extend(list(
        "sensors whose upper frequency limit is that of the modes of their body",
        &limited,
    ));
    if landing.is_none() && record.tool.is_some() && record.workpiece.is_some() {
        methods.push("the tool's later landing is not part of the shot".to_owned());
    }
    Notes { shot, methods }
}

/// The return of a recoiled tool to the workpiece within the record.
struct Landing {
    /// When the nose meets the workpiece \[s\].
    time: f64,
    /// Speed of the nose at that time \[m/s\].
    speed: f64,
    /// Largest force on the nose after that \[N\].
    force: f64,
}

impl Landing {
    /// Time for which the nose must have left the workpiece \[s\]: contacts that chatter during the drive do not count
    /// as landings.
    const FLIGHT: f64 = 5e-3;

    fn of(record: &ShotRecord) -> Option<Self> {
        let (workpiece, tool) = (record.workpiece.as_ref()?, record.tool.as_ref()?);
        let nose = &workpiece.nose;
        let flight = (Self::FLIGHT / record.sample_interval) as usize;
        let mut free = 0;
        for (sample, force) in nose.iter().enumerate() {
            if *force > 0.0 {
                if free > flight {
                    return Some(Self {
                        time: record.time(sample),
                        speed: tool.velocity[sample - 1] - workpiece.motion.velocity[sample - 1],
                        force: nose[sample..].iter().copied().fold(0.0, f64::max),
                    });
                }
                free = 0;
            } else {
                free += 1;
            }
        }
        None
    }

    /// The landing in words, with the keys on which it depends.
    fn note(&self, keys: &[String]) -> String {
        let quoted: Vec<String> = keys.iter().map(|key| format!("`{key}`")).collect();
        let depends = match quoted.as_slice() {
            [] => String::new(),
            [one] => format!(", which depends on {one}"),
            [others @ .., last] => format!(", which depends on {} and {last}", others.join(", ")),
        };
        format!(
            "the tool lands on the workpiece after {:.1} ms, at {:.1} m/s, before the end of its cycle: levels \
             include this \
             blow of up to {:.1} kN{depends}",
            1e3 * self.time,
            self.speed,
            1e-3 * self.force
        )
    }
}

/// Radiation of a surface by boundary elements, compared with other methods.
pub fn radiation_note(what: &str, report: &RadiationReport) -> String {
    let [least, most] = report.limit_error_db;
    let blend = report.blend_error_db;
    format!(
        "{what}: boundary elements at {} single frequencies up to {:.0} Hz, averaged over bands up to {:.0} Hz (power \
         from the \
         surface {:+.2} dB relative to the far field); the high-frequency limit above (error at the transition: {}; \
         in the last \
         three bands of the boundary elements: {least:+.1} to {most:+.1} dB); radiation efficiency 1 in all bands \
         would give {}",
        report.frequencies,
        report.solved_hz[0],
        report.solved_hz[1],
        report.surface_difference_db.unwrap_or(0.0),
        blend.map_or_else(|| "unknown".to_owned(), |error| format!("{error:+.1} dB")),
        decibels(report.erp_lwa_db),
    )
}

/// Added mass of a mode relative to its modal mass above which it should be included in the motion.
const NOTABLE_MASS: f64 = 0.02;

/// Effect of fluid loading on some sources.
fn loading_note(sources: &[(&str, &FluidLoading)]) -> Option<String> {
    let mut parts = Vec::new();
    let mut heaviest = None;
    for (name, loading) in sources {
        let (damping, mass) = (loading.damping_db, loading.mass_db);
        let acting = match loading.acts {
            Loading::None => 0.0,
            Loading::Damping => damping,
            Loading::Full => damping + mass.unwrap_or(0.0),
        };
        // Avoids the sign of a negative zero.
        let db = |level: f64| format!("{:.1}", if level.abs() < 0.05 { 0.0 } else { level });
        let left_out = |acts: bool| if acts { "" } else { ", left out," };
        let mut part = format!(
            "{name} {} dB (damping{} {}",
            db(acting),
            left_out(loading.acts.damps()),
            db(damping)
        );
        if let Some(mass) = mass {
            part += &format!("; mass{} {}", left_out(loading.acts == Loading::Full), db(mass));
        }
        part += ")";
        if let Some(shift) = loading.largest_shift {
            part += &format!(", mode frequencies lowered by at most {:.2} %", -100.0 * shift);
        }
        let mass = loading.largest_mass.filter(|_| loading.acts != Loading::Full);
        if let Some(mass) = mass.filter(|mass| *mass > NOTABLE_MASS) {
            heaviest = Some(mass.max(heaviest.unwrap_or(0.0)));
        }
        parts.push(part);
    }
    let warning = heaviest.map_or_else(String::new, |mass: f64| {
        format!(
            "; the added mass of the air is up to {:.1} % of a mode's mass: set `acoustics.fluid_loading = \"full\"` \
             to include it",
            100.0 * mass
        )
    });
    (!parts.is_empty()).then(|| format!("fluid loading: {}{warning}", parts.join("; ")))
}

/// Effect of the full impedance at every frequency, compared with that frozen at each mode's resonance.
fn complete_impedance_note(changes: &[FluidLoadingChange]) -> Option<String> {
    let part = |change: &FluidLoadingChange| {
        let acts = match change.complete_acts {
            true => "acts in this run",
            false => {
                "with every contact bonded; this run uses the frozen impedance, because a contact can open or its \
                 cycle is \
                 coupled to the bodies"
            }
        };
        Some(format!("{} {:+.2} dB ({acts})", change.source, change.change_db()?))
    };
    let parts: Vec<String> = changes.iter().filter_map(part).collect();
    (!parts.is_empty()).then(|| {
        format!(
            "fluid loading, change by the complete impedance relative to the impedance frozen at each mode's \
             resonance: {}",
            parts.join("; ")
        )
    })
}

/// A level as text; silence is "none".
pub fn decibels(level: Option<f64>) -> String {
    level.map_or_else(|| "none".to_owned(), |level| format!("{level:.1} dB"))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::design::Design;

    /// A tool that a finger releases in flight falls from its highest position with the acceleration due to gravity and
    /// push.
    #[test]
    fn a_tool_lands_at_the_speed_of_its_fall() {
        let mut design = Design::shipped("n80cb.toml").unwrap();
        assert!(Landing::of(&crate::chain::shot(&design).unwrap()).is_none());
        design.contacts.guard_travel = 60e-3;
        design.contacts.guard_stiffness = 500.0;
        design.trigger.release_after = 0.06;
        design.hand.force = 300.0;
        let landing = Landing::of(&crate::chain::shot(&design).unwrap()).unwrap();
        let record = crate::chain::cycle(&design).unwrap();
        let before = (landing.time / record.sample_interval()) as usize - 1;
        let height =
            |sample: usize| record.history("workpiece.position")[sample] - record.history("tool.position")[sample];
        let top = (0..before).max_by(|&a, &b| height(a).total_cmp(&height(b))).unwrap();
        let acceleration = 9.81 + record.history("hand.force")[top] / design.tool.mass;
        let fall = (2.0 * acceleration * (height(top) - height(before))).sqrt();
        assert!(
            (landing.speed / fall - 1.0).abs() < 0.1,
            "{} against {fall}",
            landing.speed
        );
        let note = |keys: &[&str]| landing.note(&keys.iter().map(|key| (*key).to_owned()).collect::<Vec<_>>());
        assert!(note(&[]).starts_with("the tool lands on the workpiece") && note(&[]).ends_with(" kN"));
        assert!(note(&["hand.mass"]).ends_with(" kN, which depends on `hand.mass`"));
        assert!(note(&["a", "b", "c"]).ends_with(" kN, which depends on `a`, `b` and `c`"));
    }
}
