//! Inputs of the exhaust: its openings, plenum and muffler, and where its jets leave the tool.

use std::f64::consts::PI;

use nailnoise_acoustics::AcousticsError;
use nailnoise_acoustics::jets::{Opening, PipeFitting, PlenumResonance};
use nailnoise_acoustics::muffler::{BandLosses, Lining, MufflerChain, MufflerElement};
use nailnoise_dynamics::network::Assembly;
use nailnoise_dynamics::network::assembly::{self, Coefficient, Restriction};

use super::super::housing::sound::NAME as HOUSING;
use super::sound::{ExhaustOutlet, Muffler, NoisyOpening, Openings, round};
use crate::design::inputs::air;
use crate::design::inputs::microphones::{on_axis, tool_height};
use crate::design::{self, Convention, Design, FittingGas, FittingKind, MufflerKind, VentSource};
use crate::error::Error;
use crate::stages::cycle::Engine;
use crate::stages::microphones::JetOutlet;

/// The openings of a design's tool.
///
/// # Errors
/// Impossible air, holes whose area differs from that of the cycle, a muffler without losses.
pub(super) fn openings(design: &Design, engine: &Engine) -> Result<Openings, Error> {
    Ok(Openings {
        air: air(design)?,
        range_hz: [design.analysis.range_low, design.analysis.exhaust_max_frequency],
        openings: match engine {
            Engine::Keys(_) => of_keys(design)?,
            Engine::Assembly(cycle) => of_assembly(design, &cycle.assembly)?,
        },
    })
}

/// Exhaust holes, then the vent of the trigger valve.
fn of_keys(design: &Design) -> Result<Vec<NoisyOpening>, Error> {
    let own = &design.exhaust;
    let vent_apart =
        design.sources.convention == Convention::Wrapping && design.sources.trigger_vent == VentSource::Body;
    let holes = Opening {
        count: own.holes as usize,
        diameter: own.hole_diameter,
        discharge_coefficient: own.coefficient(&design.chambers),
        pitch: Some(own.pitch),
    };
    holes.check_area(own.area())?;
    Ok(vec![
        NoisyOpening {
            flow: "exhaust".to_owned(),
            name: "exhaust holes".to_owned(),
            holes,
            exhaust: Some(exhaust(design)?),
            counts_to: None,
        },
        NoisyOpening {
            flow: "vent".to_owned(),
            name: "trigger vent".to_owned(),
            holes: round(design.trigger.vent_area),
            exhaust: None,
            counts_to: vent_apart.then_some(HOUSING),
        },
    ])
}

/// The openings of an assembly, in its order. The discharge coefficient of an opening is that of its passage.
fn of_assembly(design: &Design, assembly: &Assembly) -> Result<Vec<NoisyOpening>, Error> {
    let opening = |own: &assembly::Opening| {
        let coefficient = match assembly.passages[own.passage].restrictions.get(own.restriction) {
            Some(restriction) => coefficient(restriction),
            None => 1.0,
        };
        let count = own.count.max(1.0);
        Ok(NoisyOpening {
            flow: own.name.clone(),
            name: own.name.replace('_', " "),
            holes: Opening {
                count: count as usize,
                diameter: (4.0 * own.area / (PI * count)).sqrt(),
                discharge_coefficient: coefficient,
                pitch: own.pitch,
            },
            exhaust: match own.outlet.as_deref() {
                Some("exhaust") => Some(exhaust(design)?),
                _ => None,
            },
            counts_to: None,
        })
    };
    assembly.openings.iter().map(opening).collect()
}

/// A discharge coefficient for the jet. If it depends on the pressure ratio, the middle of its range is used.
fn coefficient(restriction: &Restriction) -> f64 {
    match restriction.coefficient {
        Coefficient::RatioPolynomial { from, to, .. } => 0.5 * (from + to),
        Coefficient::Constant(value) => restriction.discharge_coefficient().unwrap_or(value),
    }
}

/// Plenum, pipe and muffler of the group `exhaust`.
fn exhaust(design: &Design) -> Result<ExhaustOutlet, Error> {
    let own = &design.exhaust;
    Ok(ExhaustOutlet {
        plenum: own.plenum.resonance.then_some(PlenumResonance {
            volume: own.plenum.volume,
            neck_length: own.plenum.neck_length,
            quality: own.plenum.quality,
        }),
        fitting: (own.fitting.kind == FittingKind::Pipe).then_some(PipeFitting {
            length: own.fitting.length,
            diameter: own.fitting.diameter,
            outlet_mach: own.fitting.outlet_mach,
            temperature: match own.fitting.gas {
                FittingGas::Outflow => None,
                FittingGas::Ambient => Some(design.ambient.temperature),
            },
        }),
        muffler: muffler(&own.muffler)?,
    })
}

/// The outlet of the jets: the top of the tool.
pub(super) fn outlet(design: &Design) -> JetOutlet {
    JetOutlet {
        position: on_axis(design, tool_height(design)),
        thrust_share: design.exhaust.thrust_share,
    }
}

fn muffler(own: &design::Muffler) -> Result<Option<Muffler>, AcousticsError> {
    Ok(match own.kind {
        MufflerKind::None => None,
        MufflerKind::InsertionLoss => Some(Muffler::InsertionLoss(BandLosses::new(&thirds(&own.octaves))?)),
        MufflerKind::Chamber => {
            let lining = (own.lining_thickness > 0.0).then_some(Lining {
                thickness: own.lining_thickness,
                resistivity: own.lining_resistivity,
            });
            let element = |length, diameter, lining| MufflerElement {
                length,
                diameter,
                lining,
            };
            Some(Muffler::Chamber {
                chain: MufflerChain {
                    elements: vec![
                        element(own.chamber_length, own.chamber_diameter, None),
                        element(own.tail_length, own.tail_diameter, lining),
                    ],
                    outlet_diameter: own.tail_diameter,
                    outlet_mach: 0.0,
                },
                outlet_area: own.flow_area,
            })
        }
    })
}

/// Octaves as third octaves: mid-band frequency \[Hz\] and insertion loss \[dB\], that of an octave in each of its
/// three.
fn thirds(octaves: &[f64]) -> Vec<(f64, f64)> {
    let of_octave = |(octave, loss): (usize, &f64)| {
        let first = 3 * octave as i32 - 13;
        [0, 1, 2].map(|third| (1000.0 * 10f64.powf(0.1 * f64::from(first + third)), *loss))
    };
    octaves.iter().enumerate().flat_map(of_octave).collect()
}
