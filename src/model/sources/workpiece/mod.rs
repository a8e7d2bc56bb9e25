//! The workpiece with its support.

mod blow;
pub(super) mod sound;

use nailnoise_acoustics::radiation::radiator::Loading;

use self::blow::Blow;
use self::sound::{CODE, NAME, WorkpieceRadiated, WorkpieceSound, WorkpieceSource};
use super::{Compared, ImpedanceComparison, Source, SourceStages};
use crate::chain::ShotStages;
use crate::design::inputs;
use crate::error::Error;
use crate::measurement::wrapping::Role;
use crate::model::supports;
use crate::result::RadiationReport;
use crate::stages::apart::Apart;
use crate::stages::bodies::BodyKind;
use crate::stages::cycle::{Engine, WORKPIECE};
use crate::stages::notes::{SourceNotes, decibels, radiation_note};
use crate::stages::radiation::OpenFaces;
use crate::stages::response::{ResponseReport, Vibration};
use crate::stages::sources::SourceSound;
use crate::stages::spectra::BodyMotion;
use crate::stages::starts::OtherStarts;
use crate::stages::{Code, OnDemand, Stored};
use nailnoise_acoustics::signals::SourceSpectrum;

/// The workpiece with its support.
pub(super) struct Workpiece;

impl Source for Workpiece {
    fn name(&self) -> &'static str {
        NAME
    }

    fn colour(&self) -> usize {
        0
    }

    fn role(&self) -> Role {
        Role::Workpiece
    }

    fn code(&self) -> Code {
        CODE
    }

    fn bodies(&self) -> &'static [BodyKind] {
        &[BodyKind::Workpiece, BodyKind::Worktable]
    }

    fn radiation_table(&self) -> String {
        "radiation".to_owned()
    }

    fn is_present(&self, engine: &Engine) -> bool {
        inputs::assembly::has_body(engine, WORKPIECE)
    }

    fn add(&self, shot: &ShotStages<'_>) -> Result<SourceStages, Error> {
        let own = emission(shot, shot.structure.clone());
        let sound = shot.context.graph.add(WorkpieceSource {
            radiated: shot.context.graph.add(WorkpieceRadiated {
                sound: own.clone(),
                at_microphones: shot.radiators.workpiece.at_microphones.clone(),
            }),
            bodies: shot.bodies.structure_bodies(),
            top_hz: shot.bodies.structure.iter().map(|stages| stages.top_hz).collect(),
            cycle: shot.cycle.clone(),
            end: shot.end.clone(),
            microphones: shot.microphones.clone(),
            centre: inputs::microphones::workpiece_centre(shot.context.design),
        });
        let other_starts = 1..shot.context.design.analysis.starts;
        let starts = (shot.motions.shot.can_lose_contact() && !other_starts.is_empty()).then(|| {
            let others = other_starts.map(|start| shot.motions.driven(start, shot.motions.two_way).vibration);
            shot.context.graph.add(OtherStarts {
                first: sound.clone(),
                others: OnDemand(others.map(|vibration| energy_of(shot, &vibration)).collect()),
                range_hz: shot.motions.range_hz,
            })
        });
        let one_way = shot
            .coupled
            .is_some()
            .then(|| energy_of(shot, &shot.motions.driven(0, false).vibration));
        let impedance = (shot.radiators.acts == Loading::Full).then(|| compare_impedances(shot, &own));
        let support = supports::of(shot.context.design);
        let (words, flush) = (support.in_words(), support.open_faces() == OpenFaces::FlushTop);
        let blow = own.blow;
        Ok(SourceStages {
            source: &Workpiece,
            analysis: shot.analysis(own),
            sound,
            compared: Compared {
                one_way,
                impedance,
                starts,
            },
            notes: Box::new(move |sound| {
                let mut notes = notes(sound, &words, flush);
                notes.methods.extend(blow.map(Blow::note));
                Ok(notes)
            }),
        })
    }
}

/// Sound of workpiece and support in motion.
fn emission(shot: &ShotStages<'_>, motions: Vec<Stored<BodyMotion>>) -> WorkpieceSound {
    let fastener = shot.motions.shot.fastener.as_ref();
    let support = supports::of(shot.context.design);
    WorkpieceSound {
        radiator: shot.radiators.workpiece.radiator.clone(),
        bodies: shot.bodies.structure_bodies(),
        loads: shot.radiators.workpiece_loads.clone(),
        acts: shot.radiators.acts,
        loss_factors: shot.motions.structure.loss_factors.clone(),
        motions,
        blow: fastener.map(|fastener| Blow::of(fastener, &*support)),
    }
}

/// Energy in a vibration, without sensors.
fn energy_of(shot: &ShotStages<'_>, vibration: &Stored<Vibration>) -> Stored<Apart<SourceSpectrum>> {
    shot.energy(emission(shot, shot.motions.analysed(vibration, false)))
}

/// Energies with the frozen and the complete impedance of the air: of the shot itself if its motion is linear.
fn compare_impedances(shot: &ShotStages<'_>, own: &WorkpieceSound) -> ImpedanceComparison {
    if shot.motions.is_linear() {
        return ImpedanceComparison {
            frozen: energy_of(shot, &shot.frozen),
            complete: shot.energy(own.clone()),
            complete_acts: true,
            report: None,
        };
    }
    let [frozen, complete] = shot.motions.bonded();
    ImpedanceComparison {
        frozen: energy_of(shot, &frozen),
        complete: energy_of(shot, &complete),
        complete_acts: false,
        report: Some(shot.context.graph.add(ResponseReport {
            bodies: Vec::new(),
            vibration: complete,
        })),
    }
}

fn notes(sound: &SourceSound, support: &str, flush: bool) -> SourceNotes {
    match &sound.source().radiation {
        None => SourceNotes {
            shot: vec![format!(
                "{support}: radiated power is the ERP reference (radiation efficiency 1), an estimate that is far too \
                 high at \
                 low frequencies; it follows from the surface velocity alone, of which there is no second evaluation"
            )],
            methods: Vec::new(),
        },
        Some(report) => SourceNotes {
            shot: Vec::new(),
            methods: vec![match flush {
                true => flush_note(support, report),
                false => radiation_note(support, report),
            }],
        },
    }
}

/// Radiation of a workpiece whose top is flush with a plane, compared with other methods.
fn flush_note(support: &str, report: &RadiationReport) -> String {
    format!(
        "{support}: Rayleigh's integral at {} frequencies, its power by the intensity on the surface {:+.3} dB to that \
         of the waves in all directions; radiation efficiency 1 of the block's top would give {}",
        report.frequencies,
        report.surface_difference_db.unwrap_or(0.0),
        decibels(report.erp_lwa_db),
    )
}
