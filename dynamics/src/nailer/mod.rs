//! The nailer of a design's keys: the built-in assembly `n80cb` with these values, and the shot in terms of the nailer.
//!
//! | part | module |
//! |---|---|
//! | limits of the model | `checks` |
//! | assembly, and errors of a run in terms of the keys | `assembly` |
//! | figures, from channels and ledger | `figures`, `summary`, `log` |

mod assembly;
mod checks;
mod figures;
mod log;
mod summary;

use crate::blow::BlowInput;
use crate::network::{self, Effort, RunError};
use crate::{
    Compliance, CouplingWork, CycleError, CycleRecord, NailerFigures, Parameters, Settings, WoodForces, WoodMotion,
    Workpiece,
};

use assembly::Nailer;

/// Name of the body that the nailer works on.
const WORKPIECE: &str = "workpiece";

/// Name of the fastener.
const NAIL: &str = "nail";

/// Computes one nailing cycle, from the trigger pull to 5 ms after the piston comes to rest at the top. It ends no
/// later than `settings.end` or the landing of the tool. Its record has no forces and pressures on surfaces;
/// [`simulate_loads`] records them.
///
/// # Errors
/// [`CycleError`]. A value is out of range, the design is outside the model (spring range, overlapping laps, tool not
/// seated, valve not closed), a dry fire occurs, a contact chatters, or the integration cannot continue.
pub fn simulate(parameters: &Parameters, settings: &Settings) -> Result<CycleRecord, CycleError> {
    run(Nailer::new(parameters, settings)?.without_surfaces())
}

/// Computes one nailing cycle like [`simulate`], with the forces and pressures on the surfaces of tool and workpiece,
/// which drive their vibration.
///
/// # Errors
/// The errors of [`simulate`].
pub fn simulate_loads(parameters: &Parameters, settings: &Settings) -> Result<CycleRecord, CycleError> {
    run(Nailer::new(parameters, settings)?)
}

fn run(nailer: Nailer<'_>) -> Result<CycleRecord, CycleError> {
    let record = network::simulate(&nailer.assembly, &nailer.numerics).map_err(|error| nailer.error(error))?;
    figures::cycle_record(nailer, record)
}

/// Computes the figures of a nailing cycle, without its histories, and the work of the integration.
///
/// # Errors
/// The errors of [`simulate`].
pub fn simulate_figures(parameters: &Parameters, settings: &Settings) -> Result<(NailerFigures, Effort), CycleError> {
    let cycle = run(Nailer::new(parameters, settings)?.for_figures())?;
    Ok((cycle.figures, cycle.record.work))
}

/// Computes one nailing cycle like [`simulate_loads`] on an external workpiece, coupled in both directions. The forces
/// of the cycle act on the structure, and its motion acts on the cycle. Both are consistent at every sample.
///
/// The record's workpiece is then the surface under the nose, and its support that of the structure.
///
/// # Errors
/// The errors of [`simulate`], [`CycleError::Coupling`], and those of the structure.
pub fn simulate_on<W: Workpiece<Error: From<CycleError>>>(
    parameters: &Parameters,
    settings: &Settings,
    wood: &mut W,
) -> Result<(CycleRecord, CouplingWork), W::Error> {
    let nailer = Nailer::new(parameters, settings)?;
    let body = nailer.body(WORKPIECE)?;
    let found = network::simulate_on(&nailer.assembly, &nailer.numerics, body, &mut Adapter(wood));
    let (record, work) = found.map_err(|error| match error {
        CoupledError::Run(error) => nailer.error(error).into(),
        CoupledError::Workpiece(error) => error,
    })?;
    Ok((figures::cycle_record(nailer, record)?, work))
}

/// Inputs of the elastic blow of the rod on the nail; `None` if the blow is rigid.
///
/// # Errors
/// Those of [`simulate`] that are found before the run.
pub fn blow_input(parameters: &Parameters) -> Result<Option<BlowInput>, CycleError> {
    let nailer = Nailer::new(parameters, &Settings::default())?;
    let mut fasteners = nailer.assembly.fasteners.iter();
    let nail = fasteners.position(|fastener| fastener.name == NAIL);
    Ok(nail.and_then(|nail| BlowInput::of(&nailer.assembly, nail)))
}

/// An error of the run or of the structure.
enum CoupledError<E> {
    Run(RunError),
    Workpiece(E),
}

impl<E> From<RunError> for CoupledError<E> {
    fn from(error: RunError) -> Self {
        Self::Run(error)
    }
}

/// A workpiece whose errors remain separate from those of the run.
struct Adapter<'w, W>(&'w mut W);

impl<W: Workpiece> Workpiece for Adapter<'_, W> {
    type Error = CoupledError<W::Error>;

    fn start(&mut self, seat: f64) -> Result<WoodMotion, Self::Error> {
        self.0.start(seat).map_err(CoupledError::Workpiece)
    }

    fn compliance(&self, depth: f64) -> Compliance {
        self.0.compliance(depth)
    }

    fn trial(&mut self, forces: &WoodForces) -> Result<WoodMotion, Self::Error> {
        self.0.trial(forces).map_err(CoupledError::Workpiece)
    }

    fn accept(&mut self, forces: &WoodForces) -> Result<WoodMotion, Self::Error> {
        self.0.accept(forces).map_err(CoupledError::Workpiece)
    }
}
