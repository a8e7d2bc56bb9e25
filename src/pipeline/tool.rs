//! The tool's body as a source: its housing, driven by the forces of the cycle, and how it sounds.
//!
//! The cycle's tool moves along its axis alone, held by hand and guide; so does the body as a whole. What holds it against
//! turning is taken as spread like its inertia, which bends nothing. Its elastic modes are free.
//!
//! Forces come from the cycle with their lumped contact stiffnesses, which stand for the compliance of cap and cylinder.
//! The body gives way once more under these forces, but nothing of that goes back into them and no spring stands between:
//! the compliance is counted once. The notes of a run tell the body's own stiffness beside the lumped one.

use std::borrow::Cow;

use nailnoise_acoustics::Air;
use nailnoise_acoustics::bem::ModalBem;
use nailnoise_acoustics::levels::{SourceSpectrum, Weighting};
use nailnoise_acoustics::radiation::{
    CompactErp, Erp, ModalSpectra, radiated_energy, radiated_signals, sphere_efficiency,
};
use nailnoise_dynamics::{CycleRecord, Parameters};
use nailnoise_fem::transient::{Loads, ModalBody, ModalResponse, ModalState, Motion, Settings, Start, respond};
use nailnoise_meshes::open_faces;
use nalgebra::{Complex, DMatrix, DVector};
use serde::{Deserialize, Serialize};

use super::Body;
use super::Driven;
use super::bodies::GraphBody;
use super::radiation::{by_boundary_elements, rigid_tool};
use super::radiator::damping_of;
use super::sensors::{Moving, Sensed, Sensing};
use super::sound::Sound;
use super::vibration::spectrum_range;
use crate::design::Design;
use crate::error::Error;
use crate::result::{Check, CrossCheck, Uncertainty};
use crate::stages::bodies::tool_loads::{self, AXIAL, Axial, LOADS};
use crate::stages::radiation::radiating_surface;
use crate::stages::spectra::body_spectra;

/// The elastic body of the tool and what the shot does to it.
pub struct Tool {
    /// Its modes.
    pub body: GraphBody,
    /// Its response.
    pub response: ModalResponse,
    /// Fourier transforms of its modal accelerations.
    pub spectra: ModalSpectra,
    /// Checks of the response.
    pub checks: Vec<Check>,
    /// Its stiffness at cap and cylinder rim beside that of the cycle's contacts \[N/m\].
    pub stiffness: [Stiffness; 2],
    /// What sensors on it read.
    pub(super) sensed: Sensed,
    /// How it radiates by boundary elements, where the design asks for them.
    pub(super) bem: Option<ModalBem>,
    /// Damping ratio that this adds to its modes, where the design lets radiation damp them.
    damping: Option<Vec<f64>>,
}

/// Stiffness of the body where a contact of the cycle acts.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Stiffness {
    /// Where.
    pub place: Cow<'static, str>,
    /// Static force over mean displacement there, of the free body relative to its rigid motion \[N/m\].
    pub body: f64,
    /// The contact's in the cycle \[N/m\].
    pub contact: f64,
}

/// Largest sum of all forces less that of the cycle's equation of motion, over its largest.
const FORCE_LIMIT: f64 = 1e-9;

/// Largest force that pressure on closed walls leaves along the axis, over the largest sum of all forces: what a mesh's
/// approximate cylinders leave.
const STRAY_LIMIT: f64 = 1e-4;

/// Largest deviation of the body's velocity from the cycle's, over its largest: forces that jump between two samples.
const VELOCITY_LIMIT: f64 = 5e-3;

/// Largest relative deviation of the body's mass from the tool's in the cycle.
const MASS_LIMIT: f64 = 1e-3;

impl Tool {
    /// The response of the tool's body to a cycle.
    ///
    /// # Errors
    /// Those of the transient solver and of the Fourier transform.
    pub(super) fn new(
        design: &Design,
        (body, bem): (GraphBody, Option<ModalBem>),
        parameters: &Parameters,
        record: &CycleRecord,
    ) -> Result<Self, Error> {
        let guided = Guided::new(&body, design.ambient.gravity);
        let loads = loads(&guided, tool_loads::histories(parameters, &body.mesh, record)?, record);
        let analysis = &design.analysis;
        let settings = Settings {
            step: analysis.time_step,
            duration: analysis.duration,
            decay: f64::INFINITY, // its flight does not decay
            start: Start::State(vec![guided.rest(&body, &loads)]),
            require_contact: false,
            ..Settings::default()
        };
        let damping = match &bem {
            Some(bem) if design.acoustics.radiation_damping => Some(damping_of(bem, &body.omega)),
            _ => None,
        };
        let of_radiation = |mode: usize| damping.as_ref().map_or(0.0, |damping| damping[mode]);
        let modal = ModalBody {
            name: body.name.to_owned(),
            omega: body.omega.clone(),
            zeta: (0..body.omega.len())
                .map(|j| 0.5 * body.loss_factor + of_radiation(j))
                .collect(),
            loads: guided.loads.clone(),
            supports: DMatrix::zeros(body.omega.len(), 0),
        };
        let response = respond(&[modal], &[], &loads, &settings)?;
        let sensing = Sensing::of(design, Moving::Tool, &body)?;
        let (spectra, motion) = body_spectra(&response, 0, spectrum_range(design, &body), &sensing.shapes)?;
        let checks = guided.checks(parameters, record, &loads, &response)?;
        let stiffness = [
            (Axial::Cap, "cap", parameters.contacts.cap_stiffness),
            (Axial::Rim, "cylinder's rim", parameters.contacts.seat_stiffness),
        ]
        .map(|(place, name, contact)| Stiffness {
            place: name.into(),
            body: 1.0 / compliance(&body, &guided.loads, place as usize),
            contact,
        });
        Ok(Self {
            sensed: sensing.sensed(motion),
            body,
            response,
            spectra,
            checks,
            stiffness,
            bem,
            damping,
        })
    }

    /// It with its response.
    pub fn driven(&self) -> Driven<'_> {
        Driven {
            body: &self.body,
            response: &self.response,
            index: 0,
            spectra: &self.spectra,
        }
    }

    /// Its sound: by boundary elements where the design asks for them, beside that of a sphere.
    ///
    /// # Errors
    /// Those of surface and radiation.
    pub(super) fn sound(&self, design: &Design, record: &CycleRecord, air: &Air) -> Result<Sound, Error> {
        let Some(bem) = &self.bem else {
            return self.sound_as_sphere(design, record, air);
        };
        let damping = self.damping.as_ref().map(std::slice::from_ref);
        let mut sound = by_boundary_elements("body", bem, (&[&self.body], damping), &self.spectra)?;
        let range = [design.analysis.range_low, design.analysis.range_high];
        sound.cross_check = Some(CrossCheck {
            quantity: "the tool's body".into(),
            lw_db: sound.spectrum.level(range, Weighting::Z),
            other: "rigid motion and ERP of a sphere of its volume".into(),
            other_lw_db: self.as_sphere(bem, design, record, air)?.level(range, Weighting::Z),
        });
        sound.uncertainty.basis += "; what is nailed neither reflects nor shades";
        Ok(sound)
    }

    /// How many modes are rigid: those of a free body, whose frequencies rise, come first.
    fn rigid(&self) -> usize {
        self.body.omega.iter().take_while(|&&omega| omega == 0.0).count()
    }

    /// The energy of [`Self::sound_as_sphere`], from the skin of the boundary elements.
    fn as_sphere(
        &self,
        bem: &ModalBem,
        design: &Design,
        record: &CycleRecord,
        air: &Air,
    ) -> Result<SourceSpectrum, Error> {
        let mut elastic = self.spectra.clone();
        elastic.accelerations.rows_mut(0, self.rigid()).fill(Complex::default());
        let mut housing = radiated_energy(VIBRATION, &bem.reference(), &elastic)?;
        housing.contributions.clear();
        for (energy, &hz) in housing.energy_density.iter_mut().zip(&housing.frequency) {
            *energy *= sphere_efficiency(design.body.volume(), air, hz);
        }
        let rigid = rigid_tool(design, record, air)?.spectrum;
        Ok(SourceSpectrum::sum("body", "as a sphere", &[rigid, housing]))
    }

    /// Rigid motion as that of the sphere of its volume, elastic modes by their ERP into the open air times the radiation
    /// efficiency of that sphere.
    fn sound_as_sphere(&self, design: &Design, record: &CycleRecord, air: &Air) -> Result<Sound, Error> {
        let mut sound = rigid_tool(design, record, air)?;
        sound.spectrum.source = "rigid motion".to_owned();
        let (rigid, surface) = (self.rigid(), &self.body.surface);
        let elastic = self.body.omega.len() - rigid;
        let open = open_faces(surface, None)?;
        let shapes = self.body.skin.columns(rigid, elastic);
        let erp = Erp::new(&radiating_surface(surface, shapes, |point| open[point.face])?, air);
        let spectra = ModalSpectra {
            frequency: self.spectra.frequency.clone(),
            accelerations: self.spectra.accelerations.rows(rigid, elastic).into_owned(),
            range_hz: self.spectra.range_hz,
        };
        let range = [design.analysis.range_low, design.analysis.range_high];
        let reference = radiated_energy(VIBRATION, &erp, &spectra)?;
        let compact = CompactErp::new(erp, design.body.volume(), air)?;
        let vibration = radiated_energy(VIBRATION, &compact, &spectra)?;
        let signals = (VIBRATION, radiated_signals(&compact, &spectra, &vibration)?);
        let rigid = sound.spectrum;
        let weighted = |part: &SourceSpectrum| rigid.energy(range, Weighting::A) + part.energy(range, Weighting::A);
        let (here, above) = (weighted(&vibration), weighted(&reference));
        sound.cross_check = Some(CrossCheck {
            quantity: "vibration of the housing".into(),
            lw_db: vibration.level(range, Weighting::Z),
            other: "ERP, radiation efficiency 1".into(),
            other_lw_db: reference.level(range, Weighting::Z),
        });
        sound.uncertainty = Uncertainty {
            minus: None,
            plus: (here > 0.0).then(|| 10.0 * (above / here).log10()),
            basis: "radiation efficiency of the housing's vibration: that of an oscillating sphere of the tool's volume is \
                    taken; up to 1"
                .to_owned(),
        };
        let source_range = spectra.range_hz;
        sound.spectrum = SourceSpectrum::sum(
            "body",
            "rigid motion, ERP of the housing as compact body",
            &[rigid, vibration],
        );
        sound.spectrum.range_hz = source_range;
        sound.signals[0].0 = "rigid motion";
        sound.signals.push(signals);
        Ok(sound)
    }
}

/// Name of the part of the source that the elastic modes radiate.
pub(super) const VIBRATION: &str = "housing";

/// The body guided along its axis.
struct Guided {
    /// Participation of all loads and of weight: modes x (loads + 1), downwards.
    loads: DMatrix<f64>,
    /// Modal coordinates of a unit descent, zero for elastic modes \[kg^1/2\].
    descent: DVector<f64>,
    /// Its mass \[kg\].
    mass: f64,
    /// Force along the axis that each pressure on walls leaves before it is taken out \[m2\].
    stray: Vec<f64>,
}

impl Guided {
    /// Leaves the descent alone of all rigid motions; a force of resultant R descends the body with R/M, and pressures on
    /// closed walls have none.
    fn new(body: &Body, gravity: f64) -> Self {
        let rigid: Vec<usize> = (0..body.omega.len()).filter(|&j| body.omega[j] == 0.0).collect();
        let mut descent = DVector::zeros(body.omega.len());
        rigid.iter().for_each(|&j| descent[j] = -body.lift[j]);
        let mass = descent.norm_squared();
        let mut loads = DMatrix::zeros(body.omega.len(), LOADS + 1);
        loads.columns_mut(0, LOADS).copy_from(&body.loads);
        loads.set_column(LOADS, &body.weight(gravity));
        let mut stray = Vec::new();
        for (load, mut column) in loads.column_iter_mut().enumerate() {
            let mut resultant = descent.dot(&column);
            if (AXIAL..LOADS).contains(&load) {
                stray.push(resultant);
                resultant = 0.0;
            }
            rigid.iter().for_each(|&j| column[j] = descent[j] * resultant / mass);
        }
        Self {
            loads,
            descent,
            mass,
            stray,
        }
    }

    /// Force along the axis of each load per unit.
    fn resultants(&self) -> DVector<f64> {
        self.loads.tr_mul(&self.descent)
    }

    /// Bent as the loads at the start bend it, at rest.
    fn rest(&self, body: &Body, loads: &Loads) -> ModalState {
        let force = &self.loads * loads.history.column(0);
        let mut state = ModalState::rest(body.omega.len());
        for (j, omega) in body.omega.iter().enumerate().filter(|(_, omega)| **omega > 0.0) {
            state.displacement[j] = force[j] / (omega * omega);
        }
        state
    }

    fn checks(
        &self,
        parameters: &Parameters,
        record: &CycleRecord,
        loads: &Loads,
        response: &ModalResponse,
    ) -> Result<Vec<Check>, Error> {
        let (tool, mass) = (&record.tool, parameters.tool.mass);
        let largest = |values: &[f64]| values.iter().fold(f64::MIN_POSITIVE, |a: f64, b| a.max(b.abs()));
        let force = mass * largest(&tool.acceleration);
        let sums = loads.history.tr_mul(&self.resultants());
        let gap = |(sum, a): (&f64, &f64)| (sum - mass * a).abs();
        let off = sums.iter().zip(&tool.acceleration).map(gap).fold(0.0, f64::max);
        let stray = |sample: usize| {
            let pressures = loads.history.column(sample);
            let left = |(k, area): (usize, &f64)| pressures[AXIAL + k] * area;
            self.stray.iter().enumerate().map(left).sum::<f64>().abs()
        };
        let stray = (0..record.len()).map(stray).fold(0.0, f64::max);
        let fall = DMatrix::from_column_slice(self.descent.len(), 1, self.descent.as_slice()) / self.mass;
        let velocity = response.points(0, &fall, Motion::Velocity)?;
        let drift = |(n, v): (usize, &f64)| {
            let sample = (n as f64 * record.sample_interval / response.step).round() as usize;
            velocity.get(sample).map_or(0.0, |found| (found - v).abs())
        };
        let drift = tool.velocity.iter().enumerate().map(drift).fold(0.0, f64::max);
        let mut checks = vec![
            Check::at_most(
                "tool: mass beside the cycle's",
                (self.mass / mass - 1.0).abs(),
                MASS_LIMIT,
            ),
            Check::at_most("tool: sum of forces beside the cycle's", off / force, FORCE_LIMIT),
            Check::at_most("tool: force that closed walls leave", stray / force, STRAY_LIMIT),
            Check::at_most(
                "tool: velocity beside the cycle's",
                drift / largest(&tool.velocity),
                VELOCITY_LIMIT,
            ),
        ];
        let named = |c: &nailnoise_fem::transient::Check| Check {
            name: format!("tool: {}", c.name),
            value: c.value,
            limit: c.limit,
            ok: c.ok,
        };
        checks.extend(response.checks.iter().map(named));
        Ok(checks)
    }
}

/// The loads of a shot. After the record inner forces keep their values and the hand takes up what the others leave: the
/// tool floats on; its landing is no part of the shot.
fn loads(guided: &Guided, histories: DMatrix<f64>, record: &CycleRecord) -> Loads {
    let mut history = DMatrix::from_element(LOADS + 1, record.len(), 1.0);
    history.rows_mut(0, LOADS).copy_from(&histories);
    let mut last = history.column(record.len() - 1).into_owned();
    last[Axial::Handle as usize] -= guided.resultants().dot(&last);
    Loads {
        interval: record.sample_interval,
        history,
        final_values: last.as_slice().to_vec(),
    }
}

/// Mean displacement under a unit of a load where it acts, of the free body relative to its rigid motion \[m/N\]:
/// sum over elastic modes, static corrections among them, of p_j^2/omega_j^2.
fn compliance(body: &Body, loads: &DMatrix<f64>, load: usize) -> f64 {
    let term = |(p, omega): (&f64, &f64)| if *omega > 0.0 { (p / omega).powi(2) } else { 0.0 };
    loads.column(load).iter().zip(&body.omega).map(term).sum()
}
