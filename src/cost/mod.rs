//! Estimates the cost of a run from the design, before anything is meshed, solved or written.
//!
//! Estimates are within a factor of about two for the shipped designs. They are used to reject runs that exceed the
//! memory limit and to announce long ones, not to predict durations.

mod bodies;
mod means;
mod stage;

use means::RadiatingSurface;
use stage::SOUND_SPEED;

use crate::chain::solved_bodies;
use crate::design::inputs::bodies::block_size;
use crate::design::{BemEquations, BodyModel, Convention, Design, RadiationMethod};
use crate::error::Error;
use crate::model::supports;
use crate::stages::bodies::BodyKind;
use crate::stages::radiation::OpenFaces;

pub use nailnoise_documents::{MemoryLimit, address_space, available};
pub use stage::{Remedy, StageCost};

/// Memory for the histories of the nailing cycle, and their text in files \[byte per sample\].
const CYCLE_SAMPLE: f64 = 60.0 * 8.0 + 700.0;

/// Number of cycle samples integrated and written per second.
const CYCLE_RATE: f64 = 2e5;

/// Load histories of a response \[values per sample\].
const LOADS: f64 = 27.0;

/// Operations of a response per second: modes advanced, and pairs of contact points.
const RESPONSE_RATE: f64 = 1.5e8;

/// Spectra and pictures of a mode \[byte per frequency line\].
const SPECTRUM_LINE: f64 = 64.0;

/// Calibration of the estimate: unknowns of a sector, and processor time \[s\], for block and worktable of the N80CB up
/// to 3.2 kHz.
const RADIATION: (f64, f64) = (1210.0, 46.0);

/// Calibration of the estimate: panels, and processor time \[s\], for the body of the N80CB.
const TOOL_RADIATION: (f64, f64) = (275.0, 18.0);

/// Ratio of processor times for the same body with and without a separate cap, which doubles the velocity patterns.
const CAP_APART: f64 = 1.15;

/// Highest frequency of boundary elements on the shipped mesh of the tool's body \[Hz\].
const TOOL_TOP: f64 = 2300.0;

/// Smallest number of unknowns for which compressed equations take less than half the time of dense ones.
const COMPRESSED_FROM: f64 = 6000.0;

/// Exponent with which the time of compressed equations grows with the number of unknowns.
const COMPRESSED_GROWTH: f64 = 1.3;

/// Processor time above which a run is announced as long \[s\].
pub const LONG: f64 = 1800.0;

/// Cost of the nailing cycle.
pub fn of_cycle(design: &Design) -> StageCost {
    let analysis = &design.analysis;
    let samples = (analysis.cycle_end + analysis.cycle_tail) / analysis.time_step;
    StageCost {
        stage: "nailing cycle",
        counts: vec![("samples", samples)],
        gigabytes: 1e-9 * samples * CYCLE_SAMPLE,
        cpu_seconds: samples / CYCLE_RATE,
        keys: &[("analysis.time_step", "raise"), ("analysis.cycle_end", "lower")],
    }
}

/// Cost of the mesh and the modes of a body.
///
/// # Errors
/// Errors in materials and mesh file.
pub fn of_body(design: &Design, kind: BodyKind) -> Result<StageCost, Error> {
    bodies::modes(design, kind)
}

/// Cost of every stage of a run.
///
/// # Errors
/// Same as [`of_body`].
pub fn of_run(design: &Design) -> Result<Vec<StageCost>, Error> {
    let mut stages = vec![of_cycle(design)];
    let (mut of_tool, mut of_others) = (0.0, 0.0);
    let kinds = solved_bodies(design);
    for &kind in &kinds {
        let stage = of_body(design, kind)?;
        let modes = stage.modes().unwrap_or(0.0);
        match kind {
            BodyKind::Tool => of_tool += modes,
            BodyKind::Workpiece | BodyKind::Worktable => of_others += modes,
        }
        stages.push(stage);
    }
    if !kinds.is_empty() {
        stages.push(response(design, of_tool + of_others));
    }
    if kinds.contains(&BodyKind::Workpiece) {
        stages.extend(radiation(design, of_others));
    }
    stages.extend(radiation_of_tool(design, of_tool)?);
    Ok(stages)
}

fn response(design: &Design, modes: f64) -> StageCost {
    let (analysis, contact) = (&design.analysis, &design.support.contact);
    let samples = analysis.duration / analysis.time_step;
    let points = f64::from(contact.points_along) * f64::from(contact.points_across);
    let sensors = design.sensors.len() as f64;
    let top = analysis.range_high.max(analysis.workpiece_max_frequency);
    let lines = analysis.duration * top;
    let values = LOADS + points + 6.0 * sensors;
    let mut counts = vec![("samples", samples), ("modes", modes), ("contact points", points)];
    if analysis.starts > 1 {
        counts.push(("starts", f64::from(analysis.starts)));
    }
    StageCost {
        stage: "response",
        counts,
        gigabytes: 1e-9 * (8.0 * samples * values + SPECTRUM_LINE * lines * modes),
        cpu_seconds: f64::from(analysis.starts) * samples * (modes + 0.02 * points * points) / RESPONSE_RATE,
        keys: &[
            ("analysis.time_step", "raise"),
            ("analysis.duration", "lower"),
            ("analysis.starts", "lower"),
            ("support.contact.points_along", "lower"),
            ("support.contact.points_across", "lower"),
        ],
    }
}

/// Boundary elements of the workpiece with its support. The unknowns of the four sectors grow with the area and the
/// square of the top frequency; memory grows with their square and work with their cube, until the equations are
/// compressed.
fn radiation(design: &Design, modes: f64) -> Option<StageCost> {
    let support = supports::of(design);
    let flush = support.open_faces() == OpenFaces::FlushTop;
    let elements = design.acoustics.method == RadiationMethod::Bem && !flush;
    elements.then(|| {
        let [x, y, z] = block_size(design);
        let block = 2.0 * (x * y + y * z + z * x);
        let area = block + support.radiating_area();
        let acoustics = &design.acoustics;
        let panel = SOUND_SPEED / (acoustics.bem_max_frequency * acoustics.bem_panels);
        let panels = area / (panel * panel);
        let unknowns = panels / 4.0;
        let (unknowns_0, seconds_0) = RADIATION;
        let dense = seconds_0 * (unknowns / unknowns_0).powi(3);
        let (gigabytes, seconds) = of_equations(acoustics.bem_equations, unknowns, 4.0, dense);
        let mut stage = StageCost {
            stage: "radiation of the workpiece",
            counts: vec![("panels", panels)],
            gigabytes,
            cpu_seconds: seconds + 1e-3 * unknowns,
            keys: &[
                ("acoustics.bem_max_frequency", "lower"),
                ("acoustics.bem_panels", "lower"),
            ],
        };
        let surface = RadiatingSurface::Boxes(area);
        means::add(&mut stage, acoustics, (&surface, modes), acoustics.bem_max_frequency);
        stage
    })
}

/// Boundary elements of the tool's body, at single frequencies as far as its mesh resolves the wavelength.
fn radiation_of_tool(design: &Design, modes: f64) -> Result<Option<StageCost>, Error> {
    let acoustics = &design.acoustics;
    if acoustics.body_method == RadiationMethod::Erp || design.body.model == BodyModel::Rigid {
        return Ok(None);
    }
    let top = acoustics.bem_max_frequency.min(TOOL_TOP);
    let panel = SOUND_SPEED / (top * acoustics.bem_panels);
    let area = bodies::tool_area(design)?;
    let panels = area / (panel * panel);
    let (panels_0, seconds_0) = TOOL_RADIATION;
    let solved = match design.sources.convention {
        Convention::Physical => 1.0,
        Convention::Wrapping => 1.0 + CAP_APART,
    };
    // The parametric body is symmetric, which reduces the work to a third according to measurements. A body from a file
    // need not be symmetric.
    let (parts, share) = if design.body.mesh.is_empty() {
        (2.0, 1.0 / 3.0)
    } else {
        (1.0, 1.0)
    };
    let dense = share * seconds_0 * (panels / panels_0).powi(3);
    let (gigabytes, seconds) = of_equations(acoustics.bem_equations, 0.5 * panels / parts, parts, dense);
    let mut stage = StageCost {
        stage: "radiation of the tool",
        counts: vec![("panels", panels)],
        gigabytes,
        cpu_seconds: seconds,
        keys: &[
            ("acoustics.bem_max_frequency", "lower"),
            ("acoustics.bem_panels", "lower"),
        ],
    };
    means::add(
        &mut stage,
        acoustics,
        (&RadiatingSurface::Body { area, parts }, modes),
        top,
    );
    stage.cpu_seconds *= solved;
    Ok(Some(stage))
}

/// Memory \[GB\] and time \[s\] of the boundary-element equations; `dense` is the time for the dense matrix. The
/// compressed matrix of a parity has 750 N + 24 N^1.5 entries (`acoustics/benches/bem_compressed.rs`).
fn of_equations(solver: BemEquations, unknowns: f64, parities: f64, dense: f64) -> (f64, f64) {
    let compressed = match solver {
        BemEquations::Auto => unknowns > COMPRESSED_FROM,
        BemEquations::Dense => false,
        BemEquations::Compressed => true,
    };
    if !compressed {
        return (1e-9 * 3.0 * 16.0 * unknowns * unknowns, dense);
    }
    let entries = parities * (750.0 * unknowns + 24.0 * unknowns.powf(1.5));
    let time = 0.5 * dense * (COMPRESSED_FROM / unknowns).powf(3.0 - COMPRESSED_GROWTH);
    // With ten Krylov directions for each of a hundred patterns.
    (1e-9 * 3.0 * (8.0 * entries + 16e3 * unknowns), time)
}

/// Rejects a design if a stage exceeds the memory limit; also sets gmsh's limit for meshes of this process.
///
/// # Errors
/// [`Error::Design`] with the stage, its counts, and the key to change.
pub fn refuse(design: &Design, stages: &[StageCost], limit: MemoryLimit) -> Result<(), Error> {
    nailnoise_meshes::allow_memory(limit.gigabytes);
    match stages.iter().find(|stage| !limit.allows(stage.gigabytes)) {
        Some(stage) => {
            let needs = format!("about {:.2e} GB: {}", stage.gigabytes, stage.counted());
            let allowed = match limit.given {
                true => format!("{:.3} GB are allowed by --memory", limit.gigabytes),
                false => format!(
                    "{:.1} GB are allowed, three quarters of the free memory",
                    limit.gigabytes
                ),
            };
            Err(design.too_costly(stage.stage, needs, allowed, stage.keys).into())
        }
        None => Ok(()),
    }
}

/// Message that announces a run that takes long without stored results; none for others.
pub fn announcement(stages: &[StageCost]) -> Option<String> {
    let total: f64 = stages.iter().map(|stage| stage.cpu_seconds).sum();
    let longest = stages.iter().max_by(|a, b| a.cpu_seconds.total_cmp(&b.cpu_seconds))?;
    (total > LONG).then(|| {
        format!(
            "this takes about {:.1} hours of processor time unless it is cached from an earlier run, most of it for \
             the {} ({})",
            total / 3600.0,
            longest.stage,
            longest.counted()
        )
    })
}
