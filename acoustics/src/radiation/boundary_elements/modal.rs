use super::added_mass::{AddedMasses, MassSamples};
use super::combination::Combination;
use super::high_frequencies::composite::{CompositeRadiation, HighFrequencyRadiation};
use super::high_frequencies::frequencies::limits;
use super::high_frequencies::mean_bands::MeanBands;
use super::independent::independent;
use super::mean_ranges::MeanRanges;
use super::mesh_range::MeshRange;
use super::range_solver::RangeSolver;
use super::receivers::ModalPressures;
use super::shared;
use super::solution_id::SolutionId;
use super::summary::Summary;
use super::surface_fit::SurfaceFit;
use super::surface_pressures::SurfacePressures;
use crate::air::Air;
use crate::bem::mesh::gaps::Gaps;
use crate::checks::{InputError, same_length};
use crate::error::AcousticsError;
use crate::radiation::fluid_loading::Impedance;
use crate::radiation::{AveragedResistance, Erp, ModalRadiation, ModalSpectra, Resistance, SampledRadiation, Sampling};
use nalgebra::{Complex, DMatrix, DVector};
use rayon::prelude::*;
use serde::{Deserialize, Serialize};
use std::f64::consts::TAU;
use std::sync::{Arc, OnceLock};

/// Name of the last patch of [`ModalBem`]: the power from the far field minus that from the intensity on the surface.
const REST: &str = "far field less surface";

/// Name of all patches of the surface combined.
const SURFACE: &str = "surface";

/// Number of samples added at a time when a mesh corrects a coarser one that does not resolve the same frequencies.
/// These samples are the most expensive ones.
const CORRECTIONS: usize = 3;

/// The same number if the coarser mesh resolves them, so that the difference is smooth.
const CORRECTIONS_OF_SHAPE: usize = 2;

/// Modal radiation of a body by boundary elements: R(f) of every parity with respect to the mirror planes.
///
/// Modes of different parity radiate independently. Within a parity, R is sampled only for linearly independent modes;
/// the others are combinations of them:
///
/// ```text
/// R = sum_c T_c^T R_c T_c
/// ```
#[derive(Debug, Clone, Serialize, Deserialize)]
pub struct ModalBem {
    patches: Vec<String>,
    modes: usize,
    /// T_c.
    combinations: Vec<Combination>,
    // Shared, so that conversion to different air conditions needs no memory.
    #[serde(with = "shared")]
    parities: Arc<Vec<CompositeRadiation>>,
    solution: SolutionId,
    /// Empty unless receivers were added.
    #[serde(with = "shared")]
    pressures: Arc<ModalPressures>,
    #[serde(with = "shared")]
    masses: Arc<AddedMasses>,
    /// Octaves of averaged boundary elements above single frequencies.
    mean_octaves: f64,
    /// Summary of the sampling.
    pub summary: Summary,
    air: AirScale,
    /// The parities of [`Self::undivided`], once requested.
    #[serde(skip)]
    sums: Arc<OnceLock<Arc<Vec<CompositeRadiation>>>>,
    /// If the solved modes belong to another body, how the modes combine from them.
    #[serde(skip)]
    fit: Option<Arc<SurfaceFit>>,
}

/// Conversion to air conditions other than those of the computation. At the same wavenumber k = omega/c, the boundary
/// conditions are the same.
///
/// ```text
/// R(f; rho, c) = (rho c)/(rho0 c0) R0(f c0/c)        p/a (f; rho, c) = rho/rho0 (p/a)0 (f c0/c)
/// X/omega (f; rho, c) = rho/rho0 (X/omega)0 (f c0/c)
/// ```
#[derive(Debug, Clone, Copy, Serialize, Deserialize)]
struct AirScale {
    /// c/c0.
    speed: f64,
    /// rho/rho0.
    density: f64,
}

impl AirScale {
    const NONE: Self = Self {
        speed: 1.0,
        density: 1.0,
    };

    /// Frequency in the computation that corresponds to a frequency in this air \[Hz\].
    fn computed(&self, hz: f64) -> f64 {
        hz / self.speed
    }

    fn all_computed(&self, frequency: &[f64]) -> Vec<f64> {
        frequency.iter().map(|&hz| self.computed(hz)).collect()
    }

    /// Factor on R.
    fn resistance(&self) -> f64 {
        self.density * self.speed
    }

    /// Factor on R / omega².
    fn form(&self) -> f64 {
        self.density / self.speed
    }
}

impl ModalBem {
    /// Samples R(f) from `sampling.range_hz[0]` upwards, on increasingly fine meshes; the upper end is that of the last
    /// level. In the range of a level, the next coarser mesh determines the frequency dependence of R(f), and the
    /// level's own mesh corrects it at fewer frequencies ([`SampledRadiation::of_parities`] describes the error
    /// estimate). If the coarser mesh resolves the same range, as that of
    /// [`Boundary::coarsened`](crate::bem::Boundary::coarsened) does, only the shape differs and few corrections are
    /// needed. The last mesh is also used for another half octave, with averages over a few frequencies;
    /// [`ModalBem::solve`] continues to higher frequencies. Above that, the high-frequency limit is used: Rayleigh's
    /// integral for flat faces, and the equivalent radiated power for curved parts and parts small compared with the
    /// wavelength.
    ///
    /// `progress` is called after each frequency solved.
    ///
    /// # Errors
    /// [`BemError::TooCoarse`](crate::bem::BemError), [`SamplingError::Unresolved`](crate::SamplingError); also for
    /// inconsistent lengths, or without any level.
    pub fn new(
        levels: Vec<MeshRange>,
        sampling: &Sampling,
        progress: &(dyn Fn() + Sync),
    ) -> Result<Self, AcousticsError> {
        Self::solve(levels, MeanRanges::default(), sampling, progress).map(|(radiation, _)| radiation)
    }

    /// Same as `new`, with averages up to a different frequency, on finer meshes above half an octave. Also returns the
    /// pressures on the surface at the sampled frequencies.
    ///
    /// # Errors
    /// Those of [`ModalBem::new`], and [`BemError::TooCoarse`](crate::bem::BemError) if the meshes of the averages do
    /// not reach the end of their bands.
    pub fn solve(
        levels: Vec<MeshRange>,
        means: MeanRanges,
        sampling: &Sampling,
        progress: &(dyn Fn() + Sync),
    ) -> Result<(Self, SurfacePressures), AcousticsError> {
        let Some(finest) = levels.last() else {
            return Err(InputError::Length {
                what: "meshes of the boundary",
                found: 0,
                expected: 1,
            }
            .into());
        };
        let bands = MeanBands::new(finest.top_hz, means.to_hz);
        means.check(&bands)?;
        for level in levels.iter().chain(&means.finer) {
            level.problem.check_resolution(level.top_hz)?;
            same_length("parities of a level", level.patterns.len(), finest.patterns.len())?;
            let values = level.problem.boundary().velocity_values();
            for p in &level.patterns {
                same_length("rows of the normal velocities", p.velocities.nrows(), values)?;
            }
        }
        let mut patches = finest.problem.boundary().mesh().patches.clone();
        patches.push(REST.to_owned());
        let modes = finest.motions();
        let chosen = independent(finest);
        let mut ranges: Vec<Vec<SampledRadiation>> = vec![Vec::new(); chosen.len()];
        let mut surface = SurfacePressures::default();
        let (mut erps, mut motions) = (Vec::new(), Vec::new());
        for (pick, patterns) in chosen.iter().zip(&finest.patterns) {
            let own = pick.of(patterns);
            let surface = finest.problem.radiating_surface(&own.velocities)?;
            erps.push(Erp::new(&surface, finest.problem.air()).with_silent_patch(REST));
            motions.push(own);
        }
        let limits = limits(&finest.problem, &motions, &bands);
        let mut summary = Summary {
            samples: 0,
            interpolation: 0.0,
            difference_db: 0.0,
            asymmetry: 0.0,
            gap_error_db: levels
                .iter()
                .chain(&means.finer)
                .filter_map(|mesh| Gaps::of(mesh.problem.boundary()).worst())
                .map(|gap| gap.level_error_db())
                .fold(0.0, f64::max),
        };
        let counts: Vec<usize> = chosen.iter().map(|pick| pick.modes.len()).collect();
        let tops: Vec<f64> = levels.iter().map(|level| level.top_hz).collect();
        let resolved: Vec<f64> = levels.iter().map(MeshRange::resolved_hz).collect();
        // Whether the preceding mesh resolves a range as well as the range's own mesh does. The results then differ
        // only by the shape, and the difference is smooth over frequency.
        let is_resolved_before = |number: usize| number > 0 && resolved[number - 1] >= tops[number] * (1.0 - 1e-9);
        let prepare = |(number, level): (usize, MeshRange)| {
            // The solver also predicts the next range, and the last one also solves the averages.
            let next = tops.get(number + 1).copied();
            let last = number + 2 == tops.len() && next.is_some_and(|next| resolved[number] >= next);
            let kept_to = next.filter(|_| !last).unwrap_or(bands.same_mesh_to_hz());
            let mut solver = RangeSolver::new(level, kept_to, &chosen, progress)?.keeping_pressures();
            if !is_resolved_before(number) {
                solver = solver.with_near_field_cache(kept_to);
            }
            // The last of several meshes is solved only at the few frequencies of corrections and averages.
            if number == 0 || next.is_some() {
                solver = solver.with_interpolated_equations();
            }
            Ok(solver)
        };
        let solvers: Vec<Result<_, AcousticsError>> = levels.into_par_iter().enumerate().map(prepare).collect();
        let mut low = sampling.range_hz[0];
        let mut coarser: Option<RangeSolver<'_>> = None;
        let mut alike: Option<RangeSolver<'_>> = None;
        let mut masses = MassSamples::default();
        for (number, solver) in solvers.into_iter().enumerate() {
            let solver = solver?;
            let range = Sampling {
                range_hz: [low, tops[number]],
                ..*sampling
            };
            low = tops[number];
            let follows = is_resolved_before(number);
            let predictor = coarser.as_ref().unwrap_or(&solver);
            let at = |solver: &RangeSolver<'_>, hz: &[f64]| {
                let solved = solver.at_all(hz)?.into_iter();
                Ok(solved.map(|solved| solved.resistances()).collect())
            };
            let mut found = SampledRadiation::of_rounds("BEM", &counts, &patches, &range, |hz| at(predictor, hz))?;
            let round = if follows { CORRECTIONS_OF_SHAPE } else { CORRECTIONS };
            let correction = match &coarser {
                Some(_) => SampledRadiation::correct(&mut found, (&range, round), |hz| at(&solver, hz))?,
                None => None,
            };
            // All parities are sampled at the same frequencies.
            if let Some(found) = found.first() {
                surface.add(found.grid(), (predictor, &solver), correction)?;
            }
            for (c, found) in found.into_iter().enumerate().filter(|(c, _)| counts[*c] > 0) {
                summary.interpolation = summary.interpolation.max(found.interpolation_error());
                ranges[c].push(found.with_roots());
            }
            solver.report(&mut summary);
            predictor.add_masses(&mut masses);
            solver.add_masses(&mut masses);
            alike = coarser.replace(solver).filter(|_| follows);
        }
        let mut nodes: Vec<Vec<(f64, Vec<Resistance>)>> = vec![Vec::new(); chosen.len()];
        if let Some(solver) = coarser.map(RangeSolver::without_pressures) {
            let alike = alike.map(RangeSolver::without_pressures);
            let mut own = bands.all();
            own.truncate(bands.on_same_mesh());
            let mut found = match &alike {
                Some(alike) => solver.means_beside(alike, &own)?,
                None => solver.means(&own)?,
            };
            drop((solver, alike));
            found.extend(MeanRanges::means(means.finer, &bands, &chosen, progress, &mut summary)?);
            for (hz, means) in found {
                nodes
                    .iter_mut()
                    .zip(means)
                    .for_each(|(nodes, mean)| nodes.push((hz, mean)));
            }
        }
        let present = counts.iter().enumerate().filter(|(_, count)| **count > 0);
        let masses = masses.thinned(&present.map(|(parity, _)| parity).collect::<Vec<_>>());
        let (mut combinations, mut parities) = (Vec::new(), Vec::new());
        let limits = nodes.into_iter().zip(limits);
        for (((pick, ranges), erp), (mut nodes, limit)) in chosen.into_iter().zip(ranges).zip(erps).zip(limits) {
            if !pick.modes.is_empty() {
                combinations.push(pick.combination);
                let solved = nodes.len();
                nodes.extend(limit.above);
                let above = HighFrequencyRadiation {
                    means: AveragedResistance::new(nodes),
                    solved,
                    limit: AveragedResistance::new(limit.below),
                };
                parities.push(CompositeRadiation::new(ranges, above, erp));
            }
        }
        let radiation = Self {
            patches,
            modes,
            combinations,
            parities: Arc::new(parities),
            pressures: Arc::new(ModalPressures::none(surface.solution())),
            solution: surface.solution(),
            masses: Arc::new(masses),
            mean_octaves: bands.octaves(),
            summary,
            air: AirScale::NONE,
            sums: Arc::default(),
            fit: None,
        };
        Ok((radiation, surface))
    }

    /// Adds pressures at receivers, as given by [`SurfacePressures::at`]; none if they belong to a different solution.
    pub fn with_pressures(&self, pressures: Arc<ModalPressures>) -> Option<Self> {
        (pressures.solution() == self.solution).then(|| Self {
            pressures,
            ..self.clone()
        })
    }

    /// Number of receivers at which pressures are known.
    pub(crate) fn receivers(&self) -> usize {
        self.pressures.receivers()
    }

    /// Error of interpolating the pressures at the receivers over frequency, relative to the loudest mode at any
    /// receiver.
    pub fn pressure_error(&self) -> f64 {
        self.pressures.error()
    }

    /// The radiation of other modes on the same surface, which `fit` represents as combinations of these; none if the
    /// fit is for different modes.
    pub fn of_modes(&self, fit: &SurfaceFit) -> Option<Self> {
        let combinations = fit.combinations_of(&self.combinations)?;
        Some(Self {
            modes: fit.modes(),
            combinations,
            fit: Some(Arc::new(fit.clone())),
            ..self.clone()
        })
    }

    /// Energy spectrum of the motion not represented by the known modes, assuming radiation efficiency 1; none if the
    /// radiation was solved for these modes.
    pub(crate) fn rest_energy(&self, spectra: &ModalSpectra) -> Option<Vec<f64>> {
        let fit = self.fit.as_ref()?;
        let factor = self.air.resistance();
        let energy = fit.rest_energy(&spectra.frequency, &spectra.accelerations);
        Some(energy.into_iter().map(|energy| factor * energy).collect())
    }

    /// Fourier transform of the pressure at the receivers, receivers x bins \[Pa s\], given transforms of the modal
    /// accelerations, modes x bins \[m/s\]. It is zero above the range of single frequencies, the end of
    /// [`ModalBem::solved_hz`].
    ///
    /// # Errors
    /// If the number of modes differs from the body's.
    pub fn pressures(
        &self,
        frequency: &[f64],
        accelerations: &DMatrix<Complex<f64>>,
    ) -> Result<DMatrix<Complex<f64>>, AcousticsError> {
        same_length("modal spectra", accelerations.nrows(), self.modes)?;
        let frequency = &self.air.all_computed(frequency)[..];
        let of_parities = self.over_parities(accelerations, |parity, radiation, a| {
            self.pressures.pressures(parity, radiation, frequency, &a)
        });
        let nothing = DMatrix::zeros(self.pressures.receivers(), frequency.len());
        Ok(of_parities.into_iter().fold(nothing, |sum, part| sum + part) * Complex::from(self.air.density))
    }

    /// Converts radiation computed for the air `computed` to `air`. The conversion is exact, because only the
    /// wavelength and rho c matter. Frequencies given as input, for example the upper end of the range, scale with the
    /// speed of sound.
    #[must_use]
    pub fn in_air(&self, computed: &Air, air: &Air) -> Self {
        Self {
            air: AirScale {
                speed: air.sound_speed / computed.sound_speed,
                density: air.density / computed.density,
            },
            ..self.clone()
        }
    }

    /// A column of the added mass of the air, X(omega)/omega at the frequency `hz`, for modal masses of 1.
    pub fn added_mass(&self, column: usize, hz: f64) -> DVector<f64> {
        let hz = self.air.computed(hz);
        let mut mass = DMatrix::zeros(self.modes, 1);
        for (parity, t) in self.combinations.iter().enumerate() {
            let moving = t.of_sparse(&[(column, 1.0)]);
            if moving.is_empty() {
                continue;
            }
            let own = self.masses.product(parity, hz, &moving).map(Complex::from);
            t.add_transposed(&DMatrix::from_column_slice(own.len(), 1, own.as_slice()), &mut mass);
        }
        mass.column(0).map(|m: Complex<f64>| self.air.density * m.re)
    }

    /// Combines all patches of the surface into one, whose energies are much cheaper to compute than those of each
    /// patch.
    #[must_use]
    pub(crate) fn undivided(&self) -> Self {
        let surface = self.patches.len() - 1;
        let sum = |parity: &CompositeRadiation| parity.with_sum_of_patches(surface, SURFACE);
        let sums = || Arc::new(self.parities.iter().map(sum).collect());
        Self {
            patches: vec![SURFACE.to_owned(), REST.to_owned()],
            parities: Arc::clone(self.sums.get_or_init(sums)),
            sums: Arc::default(),
            ..self.clone()
        }
    }

    /// The equivalent radiated power of the same surface.
    pub fn reference(&self) -> ModalErp<'_> {
        ModalErp(self)
    }

    /// Transition from averaged boundary elements to the high-frequency limit: start and end \[Hz\].
    pub fn transition_hz(&self) -> [f64; 2] {
        let computed = self
            .parities
            .first()
            .map_or([0.0; 2], CompositeRadiation::transition_hz);
        computed.map(|hz| hz * self.air.speed)
    }

    /// Transition from single frequencies to averages: start and end \[Hz\]. Phases are available up to its end.
    pub fn solved_hz(&self) -> [f64; 2] {
        let computed = self.parities.first().map_or([0.0; 2], CompositeRadiation::solved_hz);
        computed.map(|hz| hz * self.air.speed)
    }

    /// Frequency range covered by both boundary elements and the limit, for comparison \[Hz\].
    pub fn compared_hz(&self) -> [f64; 2] {
        let from = self.parities.first().map_or(0.0, CompositeRadiation::limit_from_hz);
        [
            from * self.air.speed,
            MeanBands::of_octaves(self.solved_hz()[1], self.mean_octaves).upper_hz(),
        ]
    }

    /// Energy from the limit only, in the units of [`ModalRadiation::energy_forms`], summed over all patches, at
    /// frequencies within [`ModalBem::compared_hz`].
    pub fn limit_forms(&self, frequency: &[f64], accelerations: &DMatrix<Complex<f64>>) -> Vec<f64> {
        let hz = self.air.all_computed(frequency);
        let of_parities = self.over_parities(accelerations, |_, radiation, a| radiation.limit_alone(&hz, &a));
        let at = |bin: usize| of_parities.iter().map(|forms| forms.column(bin).sum()).sum::<f64>();
        (0..frequency.len()).map(|bin| at(bin) * self.air.form()).collect()
    }

    /// Whether a patch is the difference between far field and surface.
    pub fn is_residual(patch: &str) -> bool {
        patch == REST
    }

    /// Applies `each` to every parity and to the motion of its independent modes, in parallel.
    fn over_parities<T: Send>(
        &self,
        accelerations: &DMatrix<Complex<f64>>,
        each: impl Fn(usize, &CompositeRadiation, DMatrix<Complex<f64>>) -> T + Sync,
    ) -> Vec<T> {
        let parities = self
            .combinations
            .par_iter()
            .zip(self.parities.par_iter())
            .with_max_len(1);
        let of_parity = |(parity, (t, radiation)): (usize, (&Combination, &CompositeRadiation))| {
            each(parity, radiation, t.of(accelerations))
        };
        parities.enumerate().map(of_parity).collect()
    }

    /// The energy forms summed over all parities, patches x frequencies.
    fn forms(
        &self,
        frequency: &[f64],
        accelerations: &DMatrix<Complex<f64>>,
        each: impl Fn(&CompositeRadiation, &[f64], &DMatrix<Complex<f64>>) -> DMatrix<f64> + Sync,
    ) -> DMatrix<f64> {
        let computed = &self.air.all_computed(frequency)[..];
        let of_parities = self.over_parities(accelerations, |_, radiation, a| each(radiation, computed, &a));
        let nothing = DMatrix::zeros(self.patches.len(), frequency.len());
        of_parities.into_iter().fold(nothing, |sum, part| sum + part) * self.air.form()
    }

    fn whole(&self, of: impl Fn(&CompositeRadiation) -> Resistance) -> Resistance {
        let mut whole = Resistance::zeros(self.modes);
        for (t, radiation) in self.combinations.iter().zip(self.parities.iter()) {
            let t = t.dense();
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
        let hz = self.air.computed(hz);
        self.whole(|radiation| radiation.resistance(hz).scaled(self.air.resistance()))
    }

    fn sparse_forms(&self, motions: &[(f64, Vec<(usize, f64)>)]) -> Vec<f64> {
        let mut sums = vec![0.0; motions.len()];
        for (t, radiation) in self.combinations.iter().zip(self.parities.iter()) {
            let own = motions.iter().map(|(hz, v)| (self.air.computed(*hz), t.of_sparse(v)));
            let own: Vec<(usize, _)> = own.enumerate().filter(|(_, (_, v))| !v.is_empty()).collect();
            let (places, own): (Vec<usize>, Vec<_>) = own.into_iter().unzip();
            for (place, form) in places.into_iter().zip(radiation.sparse_forms(&own)) {
                sums[place] += form * self.air.resistance();
            }
        }
        sums
    }

    fn energy_forms(&self, frequency: &[f64], accelerations: &DMatrix<Complex<f64>>) -> DMatrix<f64> {
        self.forms(frequency, accelerations, |radiation, frequency, a| {
            radiation.energy_forms(frequency, a)
        })
    }

    fn images(&self, frequency: &[f64], accelerations: &DMatrix<Complex<f64>>) -> DMatrix<Complex<f64>> {
        let mut images = DMatrix::zeros(self.modes, frequency.len());
        let frequency = &self.air.all_computed(frequency)[..];
        let of_parities = self.over_parities(accelerations, |_, radiation, a| radiation.images(frequency, &a));
        for (t, image) in self.combinations.iter().zip(&of_parities) {
            t.add_transposed(image, &mut images);
        }
        images * Complex::from(self.air.form())
    }

    fn signals(&self) -> usize {
        self.parities.iter().map(ModalRadiation::signals).sum()
    }

    fn root_signals(&self, frequency: &[f64], accelerations: &DMatrix<Complex<f64>>) -> DMatrix<Complex<f64>> {
        let frequency = &self.air.all_computed(frequency)[..];
        let parts = self.over_parities(accelerations, |_, radiation, a| radiation.root_signals(frequency, &a));
        stacked(&parts, frequency.len()) * Complex::from(self.air.form().sqrt())
    }
}

impl Impedance for ModalBem {
    fn modes(&self) -> usize {
        self.modes
    }

    /// The end of [`ModalBem::solved_hz`], above which only averages of R exist.
    fn top_hz(&self) -> f64 {
        self.solved_hz()[1]
    }

    fn product(&self, hz: &[f64], velocities: &DMatrix<Complex<f64>>) -> DMatrix<Complex<f64>> {
        let times = |power: i32| {
            let mut scaled = velocities.clone();
            for (mut column, hz) in scaled.column_iter_mut().zip(hz) {
                column *= Complex::new(0.0, TAU * hz).powi(power);
            }
            scaled
        };
        // R v = -(R/omega²) (j omega)² v.
        let mut force = -self.images(hz, &times(2));
        let computed = self.air.all_computed(hz);
        let of_parities = self.over_parities(&times(1), |parity, _, a| self.masses.products(parity, &computed, &a));
        let mut inertia = DMatrix::zeros(self.modes, hz.len());
        for (t, of) in self.combinations.iter().zip(&of_parities) {
            t.add_transposed(of, &mut inertia);
        }
        force += inertia * Complex::from(self.air.density);
        force
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
        let hz = self.0.air.computed(hz);
        self.0
            .whole(|radiation| radiation.erp().resistance(hz).scaled(self.0.air.resistance()))
    }

    fn energy_forms(&self, frequency: &[f64], accelerations: &DMatrix<Complex<f64>>) -> DMatrix<f64> {
        self.0.forms(frequency, accelerations, |radiation, frequency, a| {
            radiation.erp().energy_forms(frequency, a)
        })
    }

    fn signals(&self) -> usize {
        self.0.parities.iter().map(|radiation| radiation.erp().signals()).sum()
    }

    fn root_signals(&self, frequency: &[f64], accelerations: &DMatrix<Complex<f64>>) -> DMatrix<Complex<f64>> {
        let frequency = &self.0.air.all_computed(frequency)[..];
        let of_parity = |_, radiation: &CompositeRadiation, a| radiation.erp().root_signals(frequency, &a);
        let parts = self.0.over_parities(accelerations, of_parity);
        stacked(&parts, frequency.len()) * Complex::from(self.0.air.form().sqrt())
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
