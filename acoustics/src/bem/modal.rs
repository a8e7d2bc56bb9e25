use super::blend::BlendedRadiation;
use super::problem::{Exterior, Patterns};
use super::receivers::{Heard, HeardModes, Receivers, heard};
use crate::error::{AcousticsError, same_length};
use crate::radiation::{
    Archive, ArchiveReader, ArchiveWriter, Erp, ModalRadiation, Resistance, SampledRadiation, Sampling,
};
use nalgebra::{Complex, DMatrix};
use std::collections::HashMap;
use std::sync::{Arc, Mutex, PoisonError};

/// Name of the last patch of [`ModalBem`]: what the far field's power has beyond that of the surface's intensity.
const REST: &str = "far field less surface";

/// Relative amplitude below which a mode adds nothing new to the patterns of a parity.
const RANK: f64 = 1e-6;

/// A mesh of the body and the frequency up to which it is used.
#[derive(Debug)]
pub struct Level {
    /// The exterior problem.
    pub problem: Exterior,
    /// Highest frequency \[Hz\].
    pub top_hz: f64,
    /// Normal velocities of all modes by parity, the same parities in the same order on every level.
    pub patterns: Vec<Patterns>,
}

/// What the sampling of a radiation matrix found.
#[derive(Debug, Clone, PartialEq)]
pub struct Summary {
    /// Frequencies solved.
    pub samples: usize,
    /// Largest interpolation error of an entry, relative to sqrt(R_ii R_jj).
    pub interpolation: f64,
    /// Largest difference between the power by surface and by far field of a mode within 30 dB of the loudest \[dB\].
    pub difference_db: f64,
    /// Largest asymmetry of R, relative to its largest entry.
    pub asymmetry: f64,
    /// Interpolation error of the pressure at the receivers, relative to the loudest mode at any of them.
    pub heard: f64,
}

/// Modal radiation of a body by boundary elements: R(f) of every parity with respect to the mirror planes.
///
/// Modes of different parity do not radiate together. Within a parity, R is sampled for those modes alone that are
/// independent there; the others are combinations of them:
///
/// ```text
/// R = sum_c T_c^T R_c T_c
/// ```
#[derive(Debug, Clone)]
pub struct ModalBem {
    patches: Vec<String>,
    modes: usize,
    /// T_c: independent modes x modes.
    combinations: Vec<DMatrix<f64>>,
    parities: Vec<BlendedRadiation>,
    heard: HeardModes,
    /// What the sampling found.
    pub summary: Summary,
}

impl ModalBem {
    /// Samples R(f) from `sampling.range_hz[0]` on, on meshes that get finer; the upper end of the range is the last
    /// level's. Above it the equivalent radiated power holds, with a blend over the uppermost third of an octave.
    ///
    /// # Errors
    /// [`AcousticsError::TooCoarse`], [`AcousticsError::Unresolved`], lengths that do not fit, no level.
    pub fn new(levels: Vec<Level>, sampling: &Sampling) -> Result<Self, AcousticsError> {
        Self::with_receivers(levels, sampling, &Receivers::default())
    }

    /// The same, with the pressure of every mode at receivers.
    ///
    /// # Errors
    /// Those of [`ModalBem::new`]; receivers below the floor or too close to the surface.
    pub fn with_receivers(
        levels: Vec<Level>,
        sampling: &Sampling,
        receivers: &Receivers,
    ) -> Result<Self, AcousticsError> {
        let Some(finest) = levels.last() else {
            return Err(AcousticsError::Length {
                what: "meshes of the boundary",
                found: 0,
                expected: 1,
            });
        };
        for level in &levels {
            level.problem.check_resolution(level.top_hz)?;
            same_length("parities of a level", level.patterns.len(), finest.patterns.len())?;
            let values = level.problem.boundary().velocity_values();
            for p in &level.patterns {
                same_length("rows of the normal velocities", p.velocities.nrows(), values)?;
            }
        }
        let mut patches = finest.problem.boundary().mesh().patches.clone();
        patches.push(REST.to_owned());
        let modes = finest.patterns.first().map_or(0, |p| p.velocities.ncols());
        let chosen = independent(finest);
        let mut ranges: Vec<Vec<SampledRadiation>> = vec![Vec::new(); chosen.len()];
        let mut samples: Vec<Vec<Vec<Heard>>> = vec![Vec::new(); chosen.len()];
        let mut hearing = HeardModes::new(receivers, &finest.problem);
        let mut erps = Vec::new();
        for (pick, patterns) in chosen.iter().zip(&finest.patterns) {
            let own = patterns.velocities.select_columns(&pick.modes);
            let mut erp = Erp::new(&finest.problem.radiating_surface(&own)?, finest.problem.air());
            erp.add_silent_patch(REST);
            erps.push(erp);
        }
        let mut summary = Summary {
            samples: 0,
            interpolation: 0.0,
            difference_db: 0.0,
            asymmetry: 0.0,
            heard: 0.0,
        };
        let mut low = sampling.range_hz[0];
        for level in levels {
            let range = Sampling {
                range_hz: [low, level.top_hz],
                ..*sampling
            };
            low = level.top_hz;
            let level = Level {
                problem: level.problem.with_near_field_kept(level.top_hz),
                ..level
            };
            let solver = Solver::new(&level, &chosen, receivers);
            let counts: Vec<usize> = chosen.iter().map(|pick| pick.modes.len()).collect();
            let at = |hz: f64| Ok(solver.at(hz)?.resistances.clone());
            let found = SampledRadiation::together("BEM", &counts, &patches, &range, at)?;
            for (c, found) in found.into_iter().enumerate().filter(|(c, _)| counts[*c] > 0) {
                summary.interpolation = summary.interpolation.max(found.interpolation_error());
                samples[c].push(solver.heard(c, &found)?);
                ranges[c].push(found);
            }
            solver.report(&mut summary);
        }
        let (mut combinations, mut parities) = (Vec::new(), Vec::new());
        for (((pick, ranges), samples), erp) in chosen.into_iter().zip(ranges).zip(samples).zip(erps) {
            if !pick.modes.is_empty() {
                hearing.push(&ranges, samples);
                combinations.push(pick.combination);
                parities.push(BlendedRadiation::new(ranges, erp));
            }
        }
        summary.heard = hearing.error();
        Ok(Self {
            patches,
            modes,
            combinations,
            parities,
            heard: hearing,
            summary,
        })
    }

    /// Fourier transform of the pressure at the receivers, receivers x bins \[Pa s\], for transforms of the modal
    /// accelerations, modes x bins \[m/s\]. It ends where boundary elements do, at the end of [`ModalBem::blend_hz`].
    ///
    /// # Errors
    /// A number of modes that differs from the body's.
    pub fn pressures(
        &self,
        frequency: &[f64],
        accelerations: &DMatrix<Complex<f64>>,
    ) -> Result<DMatrix<Complex<f64>>, AcousticsError> {
        same_length("modal spectra", accelerations.nrows(), self.modes)?;
        let mut pressures = DMatrix::zeros(self.heard.receivers(), frequency.len());
        let mut parity = 0;
        self.over_parities(accelerations, |radiation, a| {
            self.heard.add(parity, radiation, frequency, &a, &mut pressures);
            parity += 1;
        });
        Ok(pressures)
    }

    /// The equivalent radiated power of the same surface.
    pub fn reference(&self) -> ModalErp<'_> {
        ModalErp(self)
    }

    /// Where boundary elements give way to the limit: beginning and end of the blend \[Hz\].
    pub fn blend_hz(&self) -> [f64; 2] {
        self.parities.first().map_or([0.0; 2], BlendedRadiation::blend_hz)
    }

    /// Whether a patch is the difference between far field and surface.
    pub fn is_rest(patch: &str) -> bool {
        patch == REST
    }

    fn over_parities(
        &self,
        accelerations: &DMatrix<Complex<f64>>,
        mut each: impl FnMut(&BlendedRadiation, DMatrix<Complex<f64>>),
    ) {
        let (re, im) = (accelerations.map(|a| a.re), accelerations.map(|a| a.im));
        for (t, radiation) in self.combinations.iter().zip(&self.parities) {
            each(radiation, (t * &re).zip_map(&(t * &im), Complex::new));
        }
    }

    fn whole(&self, of: impl Fn(&BlendedRadiation) -> Resistance) -> Resistance {
        let mut whole = Resistance::zeros(self.modes);
        for (t, radiation) in self.combinations.iter().zip(&self.parities) {
            whole.real += t.transpose() * of(radiation).real * t;
        }
        whole
    }
}

impl ModalRadiation for ModalBem {
    fn method(&self) -> &str {
        "BEM"
    }

    fn modes(&self) -> usize {
        self.modes
    }

    fn patches(&self) -> &[String] {
        &self.patches
    }

    fn highest_hz(&self) -> f64 {
        f64::INFINITY
    }

    fn resistance(&self, hz: f64) -> Resistance {
        self.whole(|radiation| radiation.resistance(hz))
    }

    fn energy_forms(&self, frequency: &[f64], accelerations: &DMatrix<Complex<f64>>) -> DMatrix<f64> {
        let mut forms = DMatrix::zeros(self.patches.len(), frequency.len());
        self.over_parities(accelerations, |radiation, a| {
            forms += radiation.energy_forms(frequency, &a)
        });
        forms
    }

    fn root_signals(&self, frequency: &[f64], accelerations: &DMatrix<Complex<f64>>) -> DMatrix<Complex<f64>> {
        let mut parts = Vec::new();
        self.over_parities(accelerations, |radiation, a| {
            parts.push(radiation.root_signals(frequency, &a))
        });
        stacked(&parts, frequency.len())
    }
}

/// The equivalent radiated power of a body, see [`ModalBem::reference`].
#[derive(Debug, Clone, Copy)]
pub struct ModalErp<'a>(&'a ModalBem);

impl ModalRadiation for ModalErp<'_> {
    fn method(&self) -> &str {
        "ERP"
    }

    fn modes(&self) -> usize {
        self.0.modes
    }

    fn patches(&self) -> &[String] {
        &self.0.patches
    }

    fn highest_hz(&self) -> f64 {
        f64::INFINITY
    }

    fn resistance(&self, hz: f64) -> Resistance {
        self.0.whole(|radiation| radiation.erp().resistance(hz))
    }

    fn energy_forms(&self, frequency: &[f64], accelerations: &DMatrix<Complex<f64>>) -> DMatrix<f64> {
        let mut forms = DMatrix::zeros(self.0.patches.len(), frequency.len());
        self.0.over_parities(accelerations, |radiation, a| {
            forms += radiation.erp().energy_forms(frequency, &a)
        });
        forms
    }

    fn root_signals(&self, frequency: &[f64], accelerations: &DMatrix<Complex<f64>>) -> DMatrix<Complex<f64>> {
        let mut parts = Vec::new();
        self.0.over_parities(accelerations, |radiation, a| {
            parts.push(radiation.erp().root_signals(frequency, &a))
        });
        stacked(&parts, frequency.len())
    }
}

fn stacked(parts: &[DMatrix<Complex<f64>>], bins: usize) -> DMatrix<Complex<f64>> {
    let mut signals = DMatrix::zeros(parts.iter().map(DMatrix::nrows).sum(), bins);
    let mut row = 0;
    for part in parts {
        signals.rows_mut(row, part.nrows()).copy_from(part);
        row += part.nrows();
    }
    signals
}

/// Modes whose patterns are independent in a parity, and how all modes combine from them.
pub(super) struct Independent {
    pub(super) modes: Vec<usize>,
    pub(super) combination: DMatrix<f64>,
}

/// By the Cholesky factorisation with pivots of the patterns' Gram matrix, every mode scaled by its whole pattern.
pub(super) fn independent(level: &Level) -> Vec<Independent> {
    let boundary = level.problem.boundary();
    let mesh = boundary.mesh();
    let mut weights = Vec::with_capacity(boundary.velocity_values());
    for (p, panel) in mesh.panels.iter().enumerate() {
        let corners = panel.corners().len();
        weights.extend(std::iter::repeat_n(mesh.panel_area(p) / corners as f64, corners));
    }
    let grams: Vec<DMatrix<f64>> = level
        .patterns
        .iter()
        .map(|p| {
            let mut weighted = p.velocities.clone();
            for mut column in weighted.column_iter_mut() {
                column.iter_mut().zip(&weights).for_each(|(v, w)| *v *= w);
            }
            p.velocities.tr_mul(&weighted)
        })
        .collect();
    let modes = grams.first().map_or(0, DMatrix::ncols);
    let scale: Vec<f64> = (0..modes)
        .map(|m| {
            grams
                .iter()
                .map(|g| g[(m, m)])
                .sum::<f64>()
                .sqrt()
                .max(f64::MIN_POSITIVE)
        })
        .collect();
    grams.iter().map(|gram| pivoted(gram, &scale)).collect()
}

fn pivoted(gram: &DMatrix<f64>, scale: &[f64]) -> Independent {
    let n = scale.len();
    let mut rest: Vec<f64> = (0..n).map(|m| gram[(m, m)] / (scale[m] * scale[m])).collect();
    // Rows of the factor, pivot by pivot.
    let (mut pivots, mut rows) = (Vec::<usize>::new(), Vec::<Vec<f64>>::new());
    while let Some(pivot) = (0..n).max_by(|&a, &b| rest[a].total_cmp(&rest[b]).then(b.cmp(&a))) {
        if rest[pivot].is_nan() || rest[pivot] <= RANK * RANK {
            break;
        }
        let root = rest[pivot].sqrt();
        let row: Vec<f64> = (0..n)
            .map(|m| {
                let known: f64 = rows.iter().map(|r| r[pivot] * r[m]).sum();
                (gram[(pivot, m)] / (scale[pivot] * scale[m]) - known) / root
            })
            .collect();
        for (left, value) in rest.iter_mut().zip(&row) {
            *left -= value * value;
        }
        rest[pivot] = 0.0;
        pivots.push(pivot);
        rows.push(row);
    }
    // Patterns X D = (X D)_P T' with T' = L_P^-1 L^T, L_P the triangle of the pivots.
    let r = pivots.len();
    let mut combination = DMatrix::zeros(r, n);
    for m in 0..n {
        for i in (0..r).rev() {
            let known: f64 = (i + 1..r).map(|k| rows[i][pivots[k]] * combination[(k, m)]).sum();
            combination[(i, m)] = (rows[i][m] - known) / rows[i][pivots[i]];
        }
    }
    for m in 0..n {
        for i in 0..r {
            combination[(i, m)] *= scale[m] / scale[pivots[i]];
        }
    }
    Independent {
        modes: pivots,
        combination,
    }
}

/// R of every parity and patch, and what is heard of every parity.
struct Solved {
    resistances: Vec<Vec<Resistance>>,
    heard: Vec<Heard>,
}

/// One level's solutions, shared by its parities: the kernels of a frequency serve all of them.
struct Solver<'a> {
    problem: &'a Exterior,
    patterns: Vec<Patterns>,
    receivers: &'a Receivers,
    solved: Mutex<HashMap<u64, Arc<Solved>>>,
    worst: Mutex<(f64, f64)>,
}

impl<'a> Solver<'a> {
    fn new(level: &'a Level, chosen: &[Independent], receivers: &'a Receivers) -> Self {
        let own = |(p, pick): (&Patterns, &Independent)| Patterns {
            parity: p.parity,
            velocities: p.velocities.select_columns(&pick.modes),
        };
        Self {
            problem: &level.problem,
            patterns: level.patterns.iter().zip(chosen).map(own).collect(),
            receivers,
            solved: Mutex::default(),
            worst: Mutex::default(),
        }
    }

    /// What is heard of a parity at the samples of its radiation matrix.
    fn heard(&self, parity: usize, found: &SampledRadiation) -> Result<Vec<Heard>, AcousticsError> {
        let at = |hz: f64| Ok(self.at(hz)?.heard[parity].clone());
        found.samples_hz().into_iter().map(at).collect()
    }

    fn at(&self, hz: f64) -> Result<Arc<Solved>, AcousticsError> {
        let known = self
            .solved
            .lock()
            .unwrap_or_else(PoisonError::into_inner)
            .get(&hz.to_bits())
            .cloned();
        if let Some(known) = known {
            return Ok(known);
        }
        let solutions = self.problem.solve_parities(hz, &self.patterns)?;
        let two = self.problem.two_evaluations(&self.patterns, &solutions)?;
        let mut all = Vec::new();
        for (patterns, solution) in self.patterns.iter().zip(&solutions) {
            all.push(heard(self.problem, self.receivers, patterns, solution)?);
        }
        {
            let mut worst = self.worst.lock().unwrap_or_else(PoisonError::into_inner);
            let loudest = two.iter().map(|t| t.far_field.amax()).fold(0.0, f64::max);
            for t in &two {
                worst.0 = worst.0.max(t.difference_within(1e-3 * loudest));
                worst.1 = worst.1.max(t.asymmetry * t.far_field.amax() / loudest);
            }
        }
        let solution = Arc::new(Solved {
            resistances: two
                .iter()
                .map(|t| t.split().into_iter().map(single).collect())
                .collect(),
            heard: all,
        });
        let mut solved = self.solved.lock().unwrap_or_else(PoisonError::into_inner);
        Ok(solved.entry(hz.to_bits()).or_insert(solution).clone())
    }

    fn report(self, summary: &mut Summary) {
        let worst = self.worst.into_inner().unwrap_or_else(PoisonError::into_inner);
        summary.samples += self.solved.into_inner().unwrap_or_else(PoisonError::into_inner).len();
        summary.difference_db = summary.difference_db.max(worst.0);
        summary.asymmetry = summary.asymmetry.max(worst.1);
    }
}

/// Rounds to single precision, in which samples are kept in files: a result does not depend on whether they were.
fn single(mut r: Resistance) -> Resistance {
    r.real.iter_mut().for_each(|v| *v = f64::from(*v as f32));
    r
}

impl Archive for ModalBem {
    fn write(&self, to: &mut ArchiveWriter) {
        to.texts(&self.patches);
        to.count(self.modes);
        to.list(&self.combinations);
        to.list(&self.parities);
        to.count(self.summary.samples);
        let s = &self.summary;
        to.numbers(&[s.interpolation, s.difference_db, s.asymmetry, s.heard]);
        self.heard.write(to);
    }

    fn read(from: &mut ArchiveReader<'_>) -> Result<Self, AcousticsError> {
        let patches = from.texts()?;
        let modes = from.count()?;
        let combinations = from.list()?;
        let parities = from.list()?;
        let samples = from.count()?;
        let [interpolation, difference_db, asymmetry, heard] = from.numbers()?;
        let hearing = HeardModes::read(from)?;
        Ok(Self {
            patches,
            modes,
            combinations,
            parities,
            heard: hearing,
            summary: Summary {
                samples,
                interpolation,
                difference_db,
                asymmetry,
                heard,
            },
        })
    }
}
