//! The tool's housing: its rigid motion, and its vibration if it is elastic.

mod fitting;
pub(super) mod sound;

use std::sync::Arc;

use nailnoise_acoustics::radiation::radiator::Loading;

use self::fitting::FittingWall;
use self::sound::{CODE, Cap, Elastic, HousingAtMicrophones, HousingSound, HousingSource, NAME};
use super::exhaust::sound::NAME as EXHAUST;
use super::{Compared, ImpedanceComparison, Source, SourceStages};
use crate::chain::ShotStages;
use crate::design::inputs;
use crate::design::{Convention, Design, FittingKind};
use crate::error::Error;
use crate::measurement::wrapping::Role;
use crate::stages::bodies::BodyKind;
use crate::stages::cycle::{Engine, ShotRecord, TOOL};
use crate::stages::notes::{SourceNotes, radiation_note};
use crate::stages::sources::SourceSound;
use crate::stages::spectra::BodyMotion;
use crate::stages::tool_response::{Stiffness, ToolChecks};
use crate::stages::{Code, Stored};

/// The tool's housing, whose name in results is that of the tool's body.
pub(super) struct Housing;

impl Source for Housing {
    fn name(&self) -> &'static str {
        NAME
    }

    fn colour(&self) -> usize {
        2
    }

    fn role(&self) -> Role {
        Role::Body
    }

    fn code(&self) -> Code {
        CODE
    }

    fn bodies(&self) -> &'static [BodyKind] {
        &[BodyKind::Tool]
    }

    fn is_present(&self, engine: &Engine) -> bool {
        inputs::assembly::has_body(engine, TOOL)
    }

    fn add(&self, shot: &ShotStages<'_>) -> Result<SourceStages, Error> {
        let motion = shot.tool.as_ref().map(|tool| tool.motion.clone());
        let own = emission(shot, &shot.cycle, motion);
        let tool = shot.radiators.tool.as_ref();
        let sound = shot.context.graph.add(HousingSource {
            sound: own.clone(),
            at_microphones: tool.map(|tool| HousingAtMicrophones {
                whole: tool.whole.at_microphones.clone(),
                cap: tool.cap.as_ref().map(|cap| cap.at_microphones.clone()),
            }),
            end: shot.end.clone(),
            microphones: shot.microphones.clone(),
            sphere: inputs::microphones::tool_sphere(shot.context.design, &shot.motions.engine),
        });
        let one_way = shot.coupled.is_some().then(|| {
            let lumped = &shot.motions.lumped;
            let motion = shot.motions.tool(lumped).map(|tool| tool.motion);
            shot.energy(emission(shot, lumped, motion))
        });
        let frozen = shot.motions.tool_with_frozen_impedance(&shot.cycle);
        let frozen = frozen.filter(|_| shot.radiators.acts == Loading::Full);
        let impedance = frozen.map(|frozen| ImpedanceComparison {
            frozen: shot.energy(emission(shot, &shot.cycle, Some(frozen))),
            complete: shot.energy(own.clone()),
            complete_acts: true,
            report: None,
        });
        let report = shot.tool_report.clone();
        let rigid = inputs::assembly::rigid_housing(shot.context.design, &shot.motions.engine);
        let cover = inputs::radiation::cover_note(shot.context.design)?;
        Ok(SourceStages {
            source: &Housing,
            analysis: shot.analysis(own),
            sound,
            compared: Compared {
                one_way,
                impedance,
                starts: None,
            },
            notes: Box::new(move |sound| {
                let report: Option<Arc<ToolChecks>> = report.as_ref().map(Stored::get).transpose()?;
                let mut notes = notes(
                    sound,
                    report.as_ref().map(|report| &report.stiffness[..]),
                    rigid.as_deref(),
                );
                notes.methods.extend(cover.clone());
                Ok(notes)
            }),
        })
    }
}

/// Sound of the housing in a cycle, with its vibration if it is elastic.
fn emission(shot: &ShotStages<'_>, cycle: &Stored<ShotRecord>, motion: Option<Stored<BodyMotion>>) -> HousingSound {
    let design = shot.context.design;
    let tool = shot.radiators.tool.as_ref();
    let cap = tool.and_then(|tool| tool.cap.as_ref());
    HousingSound {
        elastic: shot.bodies.tool.as_ref().zip(motion).map(|(stages, motion)| Elastic {
            body: stages.body.clone(),
            top_hz: stages.top_hz,
            motion,
            radiator: tool.map(|tool| tool.whole.radiator.clone()),
            loads: tool.map(|tool| tool.loads.clone()),
            acts: shot.radiators.acts,
            loss_factor: stages.loss_factor,
            cap: cap.map(|cap| Cap {
                radiator: cap.radiator.clone(),
                counts_to: EXHAUST,
            }),
        }),
        volume: inputs::assembly::tool_volume(design, &shot.motions.engine),
        air: shot.context.air,
        range_hz: shot.motions.range_hz,
        cycle: cycle.clone(),
        fitting: fitting(design),
    }
}

/// The wall of the pipe on the exhaust, which points as the jets do.
fn fitting(design: &Design) -> Option<FittingWall> {
    let own = &design.exhaust.fitting;
    if own.kind != FittingKind::Pipe {
        return None;
    }
    let (alignment, height) = (design.exhaust.thrust_share, inputs::microphones::tool_height(design));
    let across = (1.0 - alignment * alignment).max(0.0).sqrt() * (design.body.cap_radius + 0.5 * own.length);
    let along = 0.5 * height + 0.5 * own.length * alignment.abs();
    Some(FittingWall {
        length: own.length,
        outer_radius: 0.5 * own.diameter + own.wall_thickness,
        thickness: own.wall_thickness,
        alignment,
        position: inputs::microphones::on_axis(design, height),
        distance: across.hypot(along),
        cap: inputs::radiation::cap_surface(design),
        counts_to: (design.sources.convention == Convention::Wrapping).then_some(EXHAUST),
    })
}

fn notes(sound: &SourceSound, stiffness: Option<&[Stiffness]>, rigid: Option<&str>) -> SourceNotes {
    let radiation = sound.source().radiation.as_ref();
    let Some(stiffness) = stiffness else {
        let difference = radiation.and_then(|report| report.surface_difference_db);
        let difference = difference.map_or_else(String::new, |decibels| {
            format!("; power of the equivalent sphere from its surface {decibels:+.3} dB relative to its far field")
        });
        return SourceNotes {
            shot: vec![format!(
                "body: rigid motion only, without the vibration of its housing: a lower bound{difference}{}",
                rigid.map_or_else(String::new, |rigid| format!("; {rigid}"))
            )],
            methods: Vec::new(),
        };
    };
    let estimate = "body: rigid motion, and vibration of its housing as ERP times the radiation efficiency of an \
        oscillating \
                    sphere of its volume; an estimate of which there is no second evaluation";
    let stiffness = match stiffness {
        [cap, rim] => Some(format!(
            "body: under the forces of the head valve the housing is as stiff as {:.0} N/um at the {} (the cycle's \
             contact: {:.0}) and {:.0} N/um at the {} ({:.0}); this compliance is counted once, in the cycle's forces",
            1e-6 * cap.body,
            cap.place,
            1e-6 * cap.contact,
            1e-6 * rim.body,
            rim.place,
            1e-6 * rim.contact
        )),
        _ => None,
    };
    let solved = radiation.map(|report| radiation_note("body, without the workpiece", report));
    SourceNotes {
        shot: radiation.is_none().then(|| estimate.to_owned()).into_iter().collect(),
        methods: solved.into_iter().chain(stiffness).collect(),
    }
}
