//! Combines the bodies into common modal arrays for a given step.

use std::f64::consts::{PI, TAU};
use std::ops::Range;

use nailnoise_meshes::gauss_legendre;
use nalgebra::DMatrix;

use super::error::TransientError;
use super::kernels::{Coefficients, Columns, Lane, lanes};
use super::model::{Loads, ModalBody, ModalState, Settings, Start, Support, SupportLaw};
use super::recurrence::{Recurrence, dissipation};

/// Position of one body in the combined arrays.
#[derive(Debug, Clone)]
pub(super) struct Part {
    /// Its lanes; the last one may be padded.
    pub(super) lanes: Range<usize>,
    /// Its number of modes.
    pub(super) modes: usize,
    /// Indices of the loads that act on it.
    pub(super) loads: Vec<usize>,
    /// Participation of these loads, one column per mode.
    pub(super) load_rows: Columns,
}

/// All modes of all bodies; each body is padded to full lanes with modes that never move.
#[derive(Debug, Clone)]
pub(super) struct System {
    pub(super) parts: Vec<Part>,
    /// Lanes of all parts.
    pub(super) height: usize,
    pub(super) coefficients: Coefficients,
    /// omega^2.
    pub(super) omega2: Vec<Lane>,
    /// Modal participation of the loads.
    pub(super) loads: Columns,
    /// Modal participation of the supports.
    pub(super) supports: Columns,
    /// The same, with one column per mode.
    pub(super) support_rows: Columns,
    /// Number of modes with omega h >= pi.
    pub(super) modes_beyond_step: usize,
}

/// Damping ratio used for the step h. A mode that the step cannot resolve (omega h >= pi; usually a residual vector) is
/// at least critically damped. It thus responds with its static compliance without ringing at a false frequency.
pub(super) fn effective_zeta(omega: f64, zeta: f64, step: f64) -> f64 {
    if omega * step >= PI { zeta.max(1.0) } else { zeta }
}

impl System {
    pub(super) fn new(bodies: &[ModalBody], loads: usize, supports: usize, step: f64) -> Self {
        let mut parts = Vec::with_capacity(bodies.len());
        let mut height = 0;
        for body in bodies {
            let end = height + lanes(body.modes());
            let acting: Vec<usize> = (0..loads)
                .filter(|&l| body.loads.column(l).iter().any(|&x| x != 0.0))
                .collect();
            let mut load_rows = Columns::zeros(lanes(acting.len()), 4 * lanes(body.modes()));
            for j in 0..body.modes() {
                let row = load_rows.column_mut(j).as_flattened_mut();
                for (x, &l) in row.iter_mut().zip(&acting) {
                    *x = body.loads[(j, l)];
                }
            }
            parts.push(Part {
                lanes: height..end,
                modes: body.modes(),
                loads: acting,
                load_rows,
            });
            height = end;
        }
        let mut system = Self {
            parts,
            height,
            coefficients: Coefficients::zeros(height),
            omega2: vec![[0.0; 4]; height],
            loads: Columns::zeros(height, loads),
            supports: Columns::zeros(height, supports),
            support_rows: Columns::zeros(lanes(supports), 4 * height),
            modes_beyond_step: 0,
        };
        let rule = gauss_legendre(10).into_iter().unzip();
        for (body, part) in bodies.iter().zip(&system.parts) {
            for (j, (&omega, &zeta)) in body.omega.iter().zip(&body.zeta).enumerate() {
                let (lane, slot) = (part.lanes.start + j / 4, j % 4);
                let zeta = effective_zeta(omega, zeta, step);
                let (recurrence, lost) = (
                    Recurrence::new(omega, zeta, step),
                    dissipation(omega, zeta, step, &rule),
                );
                system.coefficients.set(lane, slot, recurrence, lost);
                system.omega2[lane][slot] = omega * omega;
                system.modes_beyond_step += usize::from(omega * step >= PI);
                for l in 0..loads {
                    system.loads.column_mut(l)[lane][slot] = body.loads[(j, l)];
                }
                for i in 0..supports {
                    system.supports.column_mut(i)[lane][slot] = body.supports[(j, i)];
                    system.support_rows.column_mut(4 * lane + slot)[i / 4][i % 4] = body.supports[(j, i)];
                }
            }
        }
        system
    }

    /// C_d above C_v: the reduction of all penetrations and their rates at the end of a step due to a unit force at a
    /// support.
    pub(super) fn compliance(&self, bodies: &[ModalBody], supports: usize, step: f64) -> Columns {
        let mut joined = Columns::zeros(2 * lanes(supports), supports);
        let (mut c_d, mut c_v) = (DMatrix::zeros(supports, supports), DMatrix::zeros(supports, supports));
        for body in bodies {
            let step_of = |j: usize| {
                let zeta = effective_zeta(body.omega[j], body.zeta[j], step);
                Recurrence::new(body.omega[j], zeta, step)
            };
            let steps: Vec<Recurrence> = (0..body.modes()).map(step_of).collect();
            add_gram(&mut c_d, &body.supports, |j| steps[j].c1);
            add_gram(&mut c_v, &body.supports, |j| steps[j].c2);
        }
        for k in 0..supports {
            let column = joined.column_mut(k).as_flattened_mut();
            let half = column.len() / 2;
            for i in 0..supports {
                column[i] = c_d[(i, k)];
                column[half + i] = c_v[(i, k)];
            }
        }
        joined
    }

    /// Arranges one value per mode and body in lanes.
    pub(super) fn gather<'a>(&self, values: impl Iterator<Item = &'a [f64]>) -> Vec<Lane> {
        let mut joined = vec![[0.0; 4]; self.height];
        for (part, values) in self.parts.iter().zip(values) {
            joined[part.lanes.clone()].as_flattened_mut()[..values.len()].copy_from_slice(values);
        }
        joined
    }

    /// Splits displacements and velocities by body.
    pub(super) fn states(&self, q: &[Lane], v: &[Lane]) -> Vec<ModalState> {
        let cut = |x: &[Lane], part: &Part| x[part.lanes.clone()].as_flattened()[..part.modes].to_vec();
        self.parts
            .iter()
            .map(|p| ModalState {
                displacement: cut(q, p),
                velocity: cut(v, p),
            })
            .collect()
    }
}

/// Adds P^T diag(weights) P, where P has one row per mode. Uses plain loops: a library's product may fuse multiply and
/// add on some machines only, which would be visible for a bouncing block.
pub(super) fn add_gram(gram: &mut DMatrix<f64>, p: &DMatrix<f64>, weight: impl Fn(usize) -> f64) {
    let weights: Vec<f64> = (0..p.nrows()).map(weight).collect();
    for k in 0..p.ncols() {
        let weighted: Vec<f64> = p.column(k).iter().zip(&weights).map(|(p, w)| p * w).collect();
        for i in 0..=k {
            let sum: f64 = p.column(i).iter().zip(&weighted).map(|(a, b)| a * b).sum();
            gram[(i, k)] += sum;
            if i < k {
                gram[(k, i)] += sum;
            }
        }
    }
}

/// Checks sizes and values of all inputs.
pub(super) fn validate(
    bodies: &[ModalBody],
    supports: &[Support],
    loads: &Loads,
    settings: &Settings,
) -> Result<(), TransientError> {
    let size = |what: String, expected: usize, found: usize| {
        if expected == found {
            Ok(())
        } else {
            Err(TransientError::Size { what, expected, found })
        }
    };
    let value = |what: &dyn Fn() -> String, value: f64, ok: bool, range: &'static str| {
        if ok {
            Ok(())
        } else {
            Err(TransientError::Value {
                what: what(),
                value,
                range,
            })
        }
    };
    if !(1..=2).contains(&bodies.len()) {
        return Err(TransientError::Size {
            what: "bodies (one or two)".into(),
            expected: 1,
            found: bodies.len(),
        });
    }
    for body in bodies {
        let name = &body.name;
        let modes = body.modes();
        size(format!("damping ratios of `{name}`"), modes, body.zeta.len())?;
        size(
            format!("rows of the load participation of `{name}`"),
            modes,
            body.loads.nrows(),
        )?;
        size(
            format!("columns of the load participation of `{name}`"),
            loads.count(),
            body.loads.ncols(),
        )?;
        size(
            format!("rows of the support participation of `{name}`"),
            modes,
            body.supports.nrows(),
        )?;
        size(
            format!("columns of the support participation of `{name}`"),
            supports.len(),
            body.supports.ncols(),
        )?;
        for (j, (&omega, &zeta)) in body.omega.iter().zip(&body.zeta).enumerate() {
            let finite = |x: f64| x.is_finite() && x >= 0.0;
            value(
                &|| format!("omega of mode {j} of `{name}`"),
                omega,
                finite(omega),
                "finite and >= 0 (0 if rigid)",
            )?;
            value(
                &|| format!("damping ratio of mode {j} of `{name}`"),
                zeta,
                finite(zeta),
                "finite and >= 0",
            )?;
        }
        for (what, matrix) in [("load", &body.loads), ("support", &body.supports)] {
            let bad = matrix.iter().find(|x| !x.is_finite()).copied();
            value(
                &|| format!("a {what} participation of `{name}`"),
                bad.unwrap_or(0.0),
                bad.is_none(),
                "finite",
            )?;
        }
    }
    for (i, support) in supports.iter().enumerate() {
        let (k, c) = (support.stiffness, support.damping);
        value(
            &|| format!("stiffness of support {i}"),
            k,
            k.is_finite() && k >= 0.0,
            "finite and >= 0",
        )?;
        value(
            &|| format!("damping of support {i}"),
            c,
            c.is_finite() && c >= 0.0,
            "finite and >= 0",
        )?;
        value(
            &|| format!("gap of support {i}"),
            support.gap,
            support.gap.is_finite(),
            "finite",
        )?;
    }
    if loads.history.ncols() == 0 {
        return Err(TransientError::Size {
            what: "samples of the loads".into(),
            expected: 1,
            found: 0,
        });
    }
    size(
        "final values of the loads".into(),
        loads.count(),
        loads.final_values.len(),
    )?;
    let bad = loads
        .history
        .iter()
        .chain(&loads.final_values)
        .find(|x| !x.is_finite())
        .copied();
    value(&|| "a load".into(), bad.unwrap_or(0.0), bad.is_none(), "finite")?;
    let positive = |x: f64| x.is_finite() && x > 0.0;
    value(
        &|| "the loads' interval".into(),
        loads.interval,
        positive(loads.interval),
        "above 0",
    )?;
    value(&|| "the step".into(), settings.step, positive(settings.step), "above 0")?;
    let enough = positive(settings.duration) && settings.duration >= settings.step;
    value(
        &|| "the duration".into(),
        settings.duration,
        enough,
        "at least one step",
    )?;
    value(
        &|| "the taper".into(),
        settings.taper,
        settings.taper.is_finite() && settings.taper >= 0.0,
        "0 or above",
    )?;
    value(
        &|| "the decay".into(),
        settings.decay,
        settings.decay > 0.0,
        "above 0 dB",
    )?;
    let interval = settings.energy_interval;
    value(
        &|| "the energy interval".into(),
        interval,
        positive(interval),
        "above 0",
    )?;
    let limit = settings.contact_rate_limit;
    value(
        &|| "the contact rate limit".into(),
        limit,
        limit > 0.0 && limit <= 3.0,
        "above 0 and at most 3",
    )?;
    if let Start::State(states) = &settings.start {
        size("states at the start".into(), bodies.len(), states.len())?;
        for (body, state) in bodies.iter().zip(states) {
            size(
                format!("starting displacements of `{}`", body.name),
                body.modes(),
                state.displacement.len(),
            )?;
            size(
                format!("starting velocities of `{}`", body.name),
                body.modes(),
                state.velocity.len(),
            )?;
        }
    }
    contact_rate(bodies, supports, settings)
}

/// Rejects supports that make the bodies vibrate too fast for the step. The largest eigenvalue of
///
///   K^(1/2) P^T P K^(1/2),  P over the modes that the step can follow,
///
/// is the square of the highest angular frequency of the modes' inertia on the supports alone.
fn contact_rate(bodies: &[ModalBody], supports: &[Support], settings: &Settings) -> Result<(), TransientError> {
    let n = supports.len();
    if n == 0 {
        return Ok(());
    }
    let mut gram = DMatrix::<f64>::zeros(n, n);
    for body in bodies {
        let followed = |j: usize| if body.omega[j] * settings.step < PI { 1.0 } else { 0.0 };
        add_gram(&mut gram, &body.supports, followed);
    }
    for i in 0..n {
        for j in 0..n {
            gram[(i, j)] *= (supports[i].stiffness * supports[j].stiffness).sqrt();
        }
    }
    let omega = gram.symmetric_eigenvalues().max().max(0.0).sqrt();
    let rate = omega * settings.step;
    if rate <= settings.contact_rate_limit {
        return Ok(());
    }
    Err(TransientError::ContactBeyondStep {
        frequency: omega / TAU,
        rate,
        limit: settings.contact_rate_limit,
        step: settings.step,
        remedy: settings.contact_rate_limit / omega,
    })
}

/// Whether any support can open.
pub(super) fn any_unilateral(supports: &[Support]) -> bool {
    supports.iter().any(|s| s.law == SupportLaw::Unilateral)
}
