//! The exhaust: the air that leaves through exhaust holes, muffler and trigger vent.

mod inputs;
mod notes;
pub(super) mod sound;

use nailnoise_acoustics::jets::ExhaustNoise;

use self::inputs::{openings, outlet};
use self::sound::{CODE, Cycles, Exhaust, ExhaustSound, NAME, Outflow, OutflowNoise, noise};
use super::{Compared, Source, SourceStages};
use crate::chain::{Context, Drive, Motions, ShotStages, engine, shot};
use crate::design::inputs::notes::exhaust_max_frequency;
use crate::design::{Design, MufflerKind};
use crate::error::Error;
use crate::measurement::wrapping::Role;
use crate::stages::cycle::{Engine, ShotRecord};
use crate::stages::notes::SourceNotes;
use crate::stages::{Code, Stored};

/// The exhaust.
pub(super) struct ExhaustAir;

impl Source for ExhaustAir {
    fn name(&self) -> &'static str {
        NAME
    }

    fn colour(&self) -> usize {
        1
    }

    fn role(&self) -> Role {
        Role::Exhaust
    }

    fn code(&self) -> Code {
        CODE
    }

    fn chart_of_parts(&self) -> Option<&'static str> {
        Some("Parts of the exhaust")
    }

    fn is_present(&self, engine: &Engine) -> bool {
        match engine {
            Engine::Keys(_) => true,
            Engine::Assembly(cycle) => !cycle.assembly.openings.is_empty(),
        }
    }

    fn add(&self, shot: &ShotStages<'_>) -> Result<SourceStages, Error> {
        let outflow = outflow(shot, &shot.cycle, shot.motions.two_way)?;
        let one_way = shot.coupled.as_ref().map(|_| {
            let outflow = self::outflow(shot, &shot.motions.lumped, false)?;
            Ok::<_, Error>(shot.energy(ExhaustSound(outflow)))
        });
        let (openings, cycle, known) = (
            openings(shot.context.design, &shot.motions.engine)?,
            shot.cycle.clone(),
            outflow.clone(),
        );
        let (on_shot, [_, range_high]) = (exhaust_max_frequency(shot.context.design), shot.motions.range_hz);
        Ok(SourceStages {
            source: &ExhaustAir,
            analysis: shot.analysis(ExhaustSound(outflow.clone())),
            sound: shot.context.graph.add(Exhaust {
                outflow,
                outlet: outlet(shot.context.design),
                microphones: shot.microphones.clone(),
                cycle: shot.cycle.clone(),
                end: shot.end.clone(),
                noise_seed: shot.noise_seed,
            }),
            compared: Compared {
                one_way: one_way.transpose()?,
                ..Compared::default()
            },
            notes: Box::new(move |_| {
                let (record, known) = (cycle.get()?, known.get()?);
                Ok(SourceNotes {
                    shot: on_shot.iter().cloned().chain(notes::unended(&record)).collect(),
                    methods: notes::methods(range_high, &record, &openings, &known.details),
                })
            }),
        })
    }
}

/// Noise of the outflow in a shot. If the insertion loss of a muffler was measured, the sound of the holes is that of
/// the same shot without that muffler.
fn outflow(shot: &ShotStages<'_>, cycle: &Stored<ShotRecord>, two_way: bool) -> Result<Stored<Outflow>, Error> {
    let unmuffled = without_measured_muffler(shot.context.design).map(|bare| {
        let context = Context {
            design: &bare,
            ..shot.context
        };
        let engine = engine(&bare)?;
        let drive = Drive {
            lumped: shot.context.graph.add(engine.clone()),
            engine,
            force_scale: shot.motions.force_scale,
        };
        let motions = Motions::new(context, shot.bodies, shot.radiators, drive)?;
        Ok::<_, Error>(motions.driven(0, two_way).cycle)
    });
    Ok(shot.context.graph.add(OutflowNoise {
        openings: openings(shot.context.design, &shot.motions.engine)?,
        cycles: Cycles {
            shot: cycle.clone(),
            unmuffled: unmuffled.transpose()?,
        },
    }))
}

/// The same design without the muffler after its exhaust holes, if the insertion loss of that was measured.
fn without_measured_muffler(design: &Design) -> Option<Design> {
    (design.exhaust.muffler.kind == MufflerKind::InsertionLoss).then(|| {
        let mut bare = design.clone();
        bare.exhaust.muffler.kind = MufflerKind::None;
        bare
    })
}

/// The noise of a cycle's openings one by one, which yields the sound at any place ([`ExhaustNoise::at`]): exhaust
/// holes, a muffler's outlet if present, trigger vent. For a muffler with a measured insertion loss, the cycle without
/// it is also computed, with one-way coupling.
///
/// # Errors
/// Impossible openings, plenum or muffler; air that leaves against a higher pressure.
pub fn noise_of_openings(design: &Design, record: &ShotRecord) -> Result<Vec<ExhaustNoise>, Error> {
    let unmuffled = without_measured_muffler(design).as_ref().map(shot).transpose()?;
    let holes = unmuffled.as_ref().unwrap_or(record);
    Ok(noise(&openings(design, &engine(design)?)?, holes, record)?
        .details
        .openings)
}
