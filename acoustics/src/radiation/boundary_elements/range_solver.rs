use super::added_mass::{MassSamples, PackedMass};
use super::high_frequencies::mean_bands::MeanBand;
use super::independent::Independent;
use super::mesh_range::MeshRange;
use super::packed_pressure::PackedPressure;
use super::summary::Summary;
use crate::bem::solve::neumann::{NeumannData, Patterns};
use crate::bem::solve::problem::{Exterior, SurfacePressure, Threads};
use crate::bem::solve::sweep::{EquationSweep, Origin};
use crate::error::AcousticsError;
use crate::radiation::{PackedHermitian, Resistance};
use rayon::prelude::*;
use std::collections::HashMap;
use std::sync::{Arc, Mutex, PoisonError};

/// Solution at one frequency: R of each patch, added mass and surface pressure for each parity. Stored in compact form,
/// because hundreds of solutions are in memory at the same time.
pub(crate) struct Solved {
    resistances: Vec<PackedHermitian>,
    masses: Vec<PackedMass>,
    pressures: Arc<Vec<PackedPressure>>,
}

impl Solved {
    /// R for each parity and patch.
    pub(crate) fn resistances(&self) -> Vec<Vec<Resistance>> {
        self.resistances.iter().map(PackedHermitian::unpack).collect()
    }
}

/// Centre of an averaging band \[Hz\], and the mean R of each parity and patch over it.
pub(crate) type Mean = (f64, Vec<Vec<Resistance>>);

/// Solutions on one mesh range, shared by its parities: the kernels are evaluated once per frequency.
pub(crate) struct RangeSolver<'a> {
    problem: Exterior,
    data: Vec<NeumannData>,
    /// Whether solutions include the surface pressure.
    keeps_pressures: bool,
    /// Equations at several frequencies, if many are solved.
    sweep: Option<Mutex<EquationSweep>>,
    /// Called after each frequency solved.
    progress: &'a (dyn Fn() + Sync),
    solved: Mutex<HashMap<u64, Arc<Solved>>>,
    worst: Mutex<(f64, f64)>,
}

impl<'a> RangeSolver<'a> {
    /// Creates a solver for frequencies up to the upper end of the range, or to `highest_hz` beyond it.
    pub(crate) fn new(
        level: MeshRange,
        highest_hz: f64,
        chosen: &[Independent],
        progress: &'a (dyn Fn() + Sync),
    ) -> Result<Self, AcousticsError> {
        let per_wavelength = level.problem.panels_per_wavelength() * (level.top_hz / highest_hz).min(1.0);
        let problem = level.problem.with_panels_per_wavelength(per_wavelength)?;
        let data = || {
            let chosen = chosen.par_iter().zip(&level.patterns);
            chosen
                .map(|(pick, p)| problem.neumann_data(&pick.of(p)))
                .collect::<Vec<_>>()
        };
        let (data, _) = rayon::join(data, || problem.near());
        Ok(Self {
            data: data.into_iter().collect::<Result<_, _>>()?,
            problem,
            keeps_pressures: false,
            sweep: None,
            progress,
            solved: Mutex::default(),
            worst: Mutex::default(),
        })
    }

    /// Caches the integrals of close panels for all frequencies up to `highest_hz`, which pays off if many are solved.
    #[must_use]
    pub(crate) fn with_near_field_cache(self, highest_hz: f64) -> Self {
        let problem = self.problem.with_near_field_cache(highest_hz);
        Self { problem, ..self }
    }

    /// Caches the equations at some frequencies and interpolates those at others. This pays off if this mesh is used to
    /// sample a range. A compressed matrix is not interpolated.
    #[must_use]
    pub(crate) fn with_interpolated_equations(self) -> Self {
        let sweep = (!self.problem.is_compressed()).then(|| Mutex::new(EquationSweep::new(&self.problem)));
        Self { sweep, ..self }
    }

    /// Stores the surface pressure at all solved frequencies, for [`Self::pressures`].
    #[must_use]
    pub(crate) fn keeping_pressures(self) -> Self {
        Self {
            keeps_pressures: true,
            ..self
        }
    }

    /// Stops storing pressures.
    #[must_use]
    pub(crate) fn without_pressures(self) -> Self {
        Self {
            keeps_pressures: false,
            ..self
        }
    }

    /// The independent modes' velocities by parity.
    pub(crate) fn patterns(&self) -> impl Iterator<Item = &Patterns> {
        self.data.iter().map(NeumannData::patterns)
    }

    /// Solution at one frequency.
    pub(crate) fn at(&self, hz: f64) -> Result<Arc<Solved>, AcousticsError> {
        match self.known(hz) {
            Some(known) => Ok(known),
            None => self.solve(hz, Threads::One),
        }
    }

    fn solve(&self, hz: f64, threads: Threads) -> Result<Arc<Solved>, AcousticsError> {
        self.evaluated(hz, &self.problem.solve_prepared(hz, &self.data, threads)?, threads)
    }

    /// Solutions at several frequencies, in parallel.
    pub(crate) fn at_all(&self, hz: &[f64]) -> Result<Vec<Arc<Solved>>, AcousticsError> {
        let mut new: Vec<f64> = hz.iter().copied().filter(|&hz| self.known(hz).is_none()).collect();
        new.sort_by(f64::total_cmp);
        new.dedup();
        match &self.sweep {
            Some(sweep) => self.sweep_over(&mut sweep.lock().unwrap_or_else(PoisonError::into_inner), &new)?,
            None => solve_each(&new, |&hz, threads| self.solve(hz, threads)).map(drop)?,
        }
        hz.iter().map(|&hz| self.at(hz)).collect()
    }

    /// Solves at new frequencies: equations are assembled at some of them and interpolated at the others.
    fn sweep_over(&self, sweep: &mut EquationSweep, hz: &[f64]) -> Result<(), AcousticsError> {
        for &hz in hz {
            self.problem.check_resolution(hz)?;
        }
        let origins = sweep.plan(&self.problem, hz, &self.data);
        let (mut assembled, mut interpolated) = (Vec::new(), Vec::new());
        for (&hz, origin) in hz.iter().zip(origins) {
            match origin {
                Origin::Assemble(number) => assembled.push((hz, number)),
                Origin::Interpolate(weights) => interpolated.push((hz, weights)),
            }
        }
        let kept = solve_each(&assembled, |&(hz, number), threads| {
            let sums = self.problem.equations(hz, &self.data, threads)?;
            let kept = number.map(|number| (number, sweep.without_phase(&self.problem, hz, &sums)));
            self.evaluated(hz, &self.problem.solutions(hz, sums, &self.data, threads), threads)?;
            Ok(kept)
        });
        match kept {
            Ok(kept) => kept
                .into_iter()
                .flatten()
                .for_each(|(number, values)| sweep.keep(number, values)),
            Err(error) => {
                // After an error, reserved entries without equations must not remain.
                *sweep = EquationSweep::new(&self.problem);
                return Err(error);
            }
        }
        solve_each(&interpolated, |(hz, weights), threads| {
            let sums = sweep.interpolate(&self.problem, weights, threads);
            self.evaluated(*hz, &self.problem.solutions(*hz, sums, &self.data, threads), threads)
                .map(drop)
        })?;
        Ok(())
    }

    fn known(&self, hz: f64) -> Option<Arc<Solved>> {
        let solved = self.solved.lock().unwrap_or_else(PoisonError::into_inner);
        solved.get(&hz.to_bits()).cloned()
    }

    /// Evaluates the resistance in both ways from the pressures at one frequency.
    fn evaluated(
        &self,
        hz: f64,
        solutions: &[SurfacePressure],
        threads: Threads,
    ) -> Result<Arc<Solved>, AcousticsError> {
        let two = self.problem.two_evaluations(&self.data, solutions, threads)?;
        {
            let mut worst = self.worst.lock().unwrap_or_else(PoisonError::into_inner);
            let loudest = two.iter().map(|t| t.far_field.amax()).fold(0.0, f64::max);
            for t in &two {
                worst.0 = worst.0.max(t.difference_within(1e-3 * loudest));
                worst.1 = worst.1.max(t.asymmetry * t.far_field.amax() / loudest);
            }
        }
        (self.progress)();
        let kept = solutions.iter().filter(|_| self.keeps_pressures);
        let pressures = kept.map(|solution| PackedPressure::new(&solution.pressure)).collect();
        let solution = Arc::new(Solved {
            resistances: two
                .iter()
                .map(|t| PackedHermitian::new(t.far_field.nrows(), t.split().iter()))
                .collect(),
            masses: two.iter().map(|t| PackedMass::new(&t.added_mass)).collect(),
            pressures: Arc::new(pressures),
        });
        let mut solved = self.solved.lock().unwrap_or_else(PoisonError::into_inner);
        Ok(solved.entry(hz.to_bits()).or_insert(solution).clone())
    }

    /// Mean resistance of each parity and patch over several bands.
    pub(crate) fn means(&self, bands: &[MeanBand]) -> Result<Vec<Mean>, AcousticsError> {
        let all: Vec<f64> = bands.iter().flat_map(|band| &band.samples_hz).copied().collect();
        self.at_all(&all)?;
        let of_band = |band: &MeanBand| {
            let hz = &band.samples_hz;
            let mut mean: Vec<Vec<Resistance>> = Vec::new();
            for &hz in hz {
                let solved = self.at(hz)?.resistances();
                if mean.is_empty() {
                    mean = solved;
                    continue;
                }
                for (to, from) in mean.iter_mut().flatten().zip(solved.iter().flatten()) {
                    to.add_scaled(1.0, from);
                }
            }
            let scaled = |r: Resistance| r.scaled(1.0 / hz.len() as f64);
            let mean = mean.into_iter().map(|c| c.into_iter().map(scaled).collect());
            Ok((band.centre_hz, mean.collect()))
        };
        bands.iter().map(of_band).collect()
    }

    /// Mean resistances from a coarser mesh that resolves the same frequencies, corrected by the difference from this
    /// mesh at the centre of each band.
    pub(crate) fn means_beside(&self, coarser: &Self, bands: &[MeanBand]) -> Result<Vec<Mean>, AcousticsError> {
        let mut means = coarser.means(bands)?;
        let centre = |band: &MeanBand| MeanBand {
            samples_hz: vec![band.centre_hz],
            ..band.clone()
        };
        let middles: Vec<MeanBand> = bands.iter().map(centre).collect();
        let differences = self.means(&middles)?.into_iter().zip(coarser.means(&middles)?);
        for ((_, mean), ((_, own), (_, theirs))) in means.iter_mut().zip(differences) {
            let differences = own.iter().flatten().zip(theirs.iter().flatten());
            for (mean, (own, theirs)) in mean.iter_mut().flatten().zip(differences) {
                mean.add_scaled(1.0, own);
                mean.add_scaled(-1.0, theirs);
            }
        }
        Ok(means)
    }

    /// Adds the added masses at all frequencies solved so far.
    pub(crate) fn add_masses(&self, to: &mut MassSamples) {
        let solved = self.solved.lock().unwrap_or_else(PoisonError::into_inner);
        for (hz, solution) in solved.iter() {
            to.insert(f64::from_bits(*hz), &solution.masses);
        }
    }

    /// The surface pressure in each parity at one frequency, if stored by [`Self::keeping_pressures`].
    pub(crate) fn pressures(&self, hz: f64) -> Result<Arc<Vec<PackedPressure>>, AcousticsError> {
        Ok(Arc::clone(&self.at(hz)?.pressures))
    }

    /// Adds the number of solutions and the errors found so far to the summary.
    pub(crate) fn report(&self, summary: &mut Summary) {
        summary.samples += self.solved.lock().unwrap_or_else(PoisonError::into_inner).len();
        self.report_errors(summary);
    }

    /// Adds only the errors.
    pub(crate) fn report_errors(&self, summary: &mut Summary) {
        let worst = *self.worst.lock().unwrap_or_else(PoisonError::into_inner);
        summary.difference_db = summary.difference_db.max(worst.0);
        summary.asymmetry = summary.asymmetry.max(worst.1);
    }
}

/// Processes an even number of frequencies in parallel, one thread each, because all take equally long; if the number
/// is odd, two threads share the last one. The error returned is that of the first frequency that fails.
fn solve_each<T: Sync, R: Send>(
    frequencies: &[T],
    one: impl Fn(&T, Threads) -> Result<R, AcousticsError> + Sync,
) -> Result<Vec<R>, AcousticsError> {
    let (even, last) = frequencies.split_at(frequencies.len() / 2 * 2);
    let serially = even.par_iter().with_max_len(1).map(|item| one(item, Threads::One));
    let mut found: Vec<_> = serially.collect();
    found.extend(last.iter().map(|item| one(item, Threads::Two)));
    found.into_iter().collect()
}
