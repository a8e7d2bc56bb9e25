//! The sound field of a shot for inspection, in one-third octaves.

use std::sync::Arc;

use nailnoise_acoustics::Air;
use nailnoise_acoustics::radiation::ModalSpectra;
use nailnoise_acoustics::radiation::boundary_elements::ModalBem;
use nailnoise_acoustics::radiation::flush_with_sand::flush_field;
use nailnoise_acoustics::radiation::radiator::Radiator;
use nailnoise_acoustics::radiation::sound_fields::{
    Cuts, FieldSeries, SolvedSurface, SoundField, boundary_element_field, velocity_field,
};
use nalgebra::Vector3;
use serde::{Deserialize, Serialize};

use super::bodies::Body;
use super::radiation::{FlushTop, ToolRadiation, WorkpieceBoundaryElements, top_of};
use super::spectra::BodyMotion;
use super::{Code, Postcard, Progress, Stage, Stored, all, code};
use crate::error::Error;
use crate::result::Check;

/// Largest difference between the energy of a field and that of the source \[dB\].
const DIFFERENCE: f64 = 0.1;

/// Computes the sound field of workpiece and tool, and the velocity of all surfaces. The output is stored separately
/// from a run: pressures at thousands of points take a hundred times as much space as the data for levels.
#[derive(Serialize)]
pub struct SoundFields {
    /// Name of the source to which workpiece and support belong.
    pub source: &'static str,
    /// Method for the field of the workpiece.
    pub method: FieldMethod,
    /// Workpiece and support.
    pub bodies: Vec<Stored<Body>>,
    /// Motion of each body.
    pub motions: Vec<Stored<BodyMotion>>,
    /// The elastic tool.
    pub tool: Option<ToolField>,
    /// The ambient air.
    pub air: Air,
    /// Planes on which the field is shown.
    pub cuts: Cuts,
}

/// Method for the field of the workpiece with its support.
#[derive(Clone, Serialize)]
pub enum FieldMethod {
    /// By boundary elements, given their matrix in standard air.
    BoundaryElements(WorkpieceBoundaryElements, Stored<ModalBem>),
    /// By Rayleigh's integral, given the workpiece as a radiator.
    Rayleigh(FlushTop, Stored<Box<dyn Radiator>>),
    /// The equivalent radiated power yields no field.
    Erp,
    /// The tool has no workpiece.
    Absent,
}

/// The elastic tool and its field.
#[derive(Serialize)]
pub struct ToolField {
    /// Name of the source to which the tool belongs.
    pub source: &'static str,
    /// The body.
    pub body: Stored<Body>,
    /// Its motion.
    pub motion: Stored<BodyMotion>,
    /// Boundary elements and their matrix in the ambient air, if the design requests them.
    pub elements: Option<(ToolRadiation, Stored<ModalBem>)>,
    /// Position of its nose \[m\].
    pub nose: [f64; 3],
}

/// Output of [`SoundFields`].
#[derive(Debug, Clone, Serialize, Deserialize)]
pub struct Fields {
    /// Method for the workpiece's sound.
    pub method: String,
    /// Contents and omissions of the fields.
    pub notes: Vec<String>,
    /// Checks that the fields contain the energy of the source.
    pub checks: Vec<Check>,
    /// Surfaces with fields.
    pub series: Vec<FieldSeries>,
}

impl Stage for SoundFields {
    type Output = Fields;
    type Error = Error;
    type Codec = Postcard;
    const NAME: &'static str = "sound fields";
    const CODE: Code = code!(
        dynamics,
        meshes,
        fem,
        acoustics,
        stages_bodies,
        stages_radiation,
        stages_response,
        stages_sound_fields,
        stages_spectra,
        stages_cycle
    );

    fn compute(&self, _: &Progress) -> Result<Fields, Error> {
        let bodies = all(&self.bodies)?;
        let motions = all(&self.motions)?;
        let mut fields = self.workpiece(&bodies, &motions)?;
        if let Some(tool) = &self.tool {
            self.add_tool(tool, &mut fields)?;
        }
        for (body, motion) in bodies.iter().zip(&motions) {
            fields.series.push(self.velocity(body, motion, Vector3::zeros())?);
        }
        if let Some(ToolField { body, motion, nose, .. }) = &self.tool {
            fields
                .series
                .push(self.velocity(&*body.get()?, &*motion.get()?, (*nose).into())?);
        }
        Ok(fields)
    }
}

impl SoundFields {
    /// Field of the workpiece with its support.
    fn workpiece(&self, bodies: &[Arc<Body>], motions: &[Arc<BodyMotion>]) -> Result<Fields, Error> {
        let air = &self.air;
        let spectra: Vec<&ModalSpectra> = motions.iter().map(|motion| &motion.spectra).collect();
        Ok(match &self.method {
            FieldMethod::BoundaryElements(elements, matrix) => {
                let surfaces: Vec<_> = bodies.iter().map(|body| body.moving_surface()).collect();
                let bem = matrix.get()?.in_air(&Air::default(), air);
                let body = SolvedSurface {
                    source: self.source,
                    prefix: "sound",
                    levels: elements.mesh_hierarchy(&surfaces, air)?,
                    bem: &bem,
                    spectra: &ModalSpectra::side_by_side(&spectra),
                    at: Vector3::zeros(),
                };
                self.solved(body, elements.floor)?
            }
            FieldMethod::Rayleigh(top, radiator) => {
                let radiated = radiator.get()?.energy(self.source, &spectra)?;
                let surface = top.rayleigh(&top_of(&bodies[0].moving_surface())?, air)?;
                let field = flush_field("sound", &surface, spectra[0], &radiated, &self.cuts)?;
                Fields {
                    method: "Rayleigh's integral".to_owned(),
                    notes: vec![
                        format!(
                            "workpiece in sand by Rayleigh's integral at {} frequencies; error of the field between \
                             them \
                             {:.1e} of its largest value; absorbing sand takes the same share of the sound in every \
                             direction",
                            field.samples, field.error
                        ),
                        "the pressure is that of the workpiece and the sand that moves with it alone: no exhaust, no \
                         tool; on \
                         the surface itself Rayleigh's integral is not evaluated"
                            .to_owned(),
                    ],
                    checks: checks(self.source, &field),
                    series: field.series,
                }
            }
            FieldMethod::Absent => Fields {
                method: "none".to_owned(),
                notes: vec!["the tool has no workpiece: the fields show its body, if that is elastic".to_owned()],
                checks: Vec::new(),
                series: Vec::new(),
            },
            FieldMethod::Erp => Fields {
                method: "equivalent radiated power".to_owned(),
                notes: vec![
                    "the workpiece radiates with efficiency 1 (acoustics.method = \"erp\"): this method gives no \
                     pressure and \
                     no directivity, so the fields show the velocity of its surfaces and the energy that this \
                     velocity would \
                     radiate; boundary elements (acoustics.method = \"bem\") give all of them"
                        .to_owned(),
                ],
                checks: Vec::new(),
                series: Vec::new(),
            },
        })
    }

    /// Adds the field of the tool, if it is solved by boundary elements.
    fn add_tool(&self, tool: &ToolField, fields: &mut Fields) -> Result<(), Error> {
        let Some((elements, matrix)) = &tool.elements else {
            return Ok(());
        };
        let body = SolvedSurface {
            source: tool.source,
            prefix: "sound-tool",
            levels: vec![elements.level(&tool.body.get()?.moving_surface(), &self.air)?],
            bem: &*matrix.get()?,
            spectra: &tool.motion.get()?.spectra,
            at: tool.nose.into(),
        };
        let of_tool = self.solved(body, elements.floor)?;
        fields.notes.extend(of_tool.notes);
        fields.checks.extend(of_tool.checks);
        fields.series.extend(of_tool.series);
        Ok(())
    }

    /// Field from boundary elements, above a floor if it is included in the equations.
    fn solved(&self, body: SolvedSurface<'_>, floor: Option<f64>) -> Result<Fields, Error> {
        let source = body.source;
        let field = boundary_element_field(body, &self.cuts)?;
        Ok(Fields {
            method: "boundary elements".to_owned(),
            notes: vec![format!(
                "{source} by boundary elements at {} frequencies, in the bands up to {:.0} Hz that lie below the end \
                 of single \
                 frequencies; error of the field between them {:.1e} of its largest value; the pressure is that of \
                 this source \
                 alone, {}",
                field.samples,
                field.highest_hz,
                field.error,
                if floor.is_some() {
                    "above a rigid floor"
                } else {
                    "in free space"
                }
            )],
            checks: checks(source, &field),
            series: field.series,
        })
    }

    fn velocity(&self, body: &Body, motion: &BodyMotion, at: Vector3<f64>) -> Result<FieldSeries, Error> {
        let name = format!("velocity-{}", body.name);
        Ok(velocity_field(
            &name,
            (&body.surface, &body.skin),
            &motion.spectra,
            &self.air,
            at,
        )?)
    }
}

/// Checks that a field contains the energy of its source.
fn checks(source: &str, field: &SoundField) -> Vec<Check> {
    let check = |(what, decibels): &(&str, f64)| {
        let name = format!("sound field: energy by {what} relative to that of the {source} in these bands [dB]");
        Check::at_most(name, *decibels, DIFFERENCE)
    };
    field.balances.iter().map(check).collect()
}
