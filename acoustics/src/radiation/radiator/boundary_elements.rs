//! One or several bodies, by boundary elements up to their highest frequency and by the high-frequency limit above.

use super::{
    Detail, FluidLoading, FluidLoads, Loading, MovingBody, Pressures, RadiatedSound, RadiationBand, RadiationReport,
    Radiator, Uncertainty, damping_ratios, mode_shares, motions,
};
use crate::error::AcousticsError;
use crate::radiation::boundary_elements::ModalBem;
use crate::radiation::fluid_loading::{DryModes, Impedance, WetModes};
use crate::radiation::{ModalRadiation, ModalSpectra, mode_energies, radiated_energy, radiated_signals};
use crate::signals::{BandLevel, SourceSpectrum, Weighting, energy_level, energy_weights};
use nalgebra::DVector;
use std::f64::consts::TAU;

/// Number of uppermost boundary-element bands used to estimate the error of the limit.
const JUDGED: usize = 3;

/// Octaves over which pressures fade out at the upper end of single frequencies.
pub const FADE_OCTAVES: f64 = 1.0 / 3.0;

impl Radiator for ModalBem {
    fn energy(&self, source: &str, motions: &[&ModalSpectra]) -> Result<SourceSpectrum, AcousticsError> {
        radiated_energy(source, self, &ModalSpectra::side_by_side(motions))
    }

    fn sound(
        &self,
        source: &'static str,
        bodies: &[MovingBody<'_>],
        detail: Detail,
    ) -> Result<RadiatedSound, AcousticsError> {
        let together = ModalSpectra::side_by_side(&motions(bodies));
        let bem = match detail {
            Detail::Levels => &self.undivided(),
            Detail::Report => self,
        };
        let mut spectrum = radiated_energy(source, bem, &together)?;
        let surface = share_out(&mut spectrum);
        let differences = Differences::new(bem, &together, [&spectrum, &surface]);
        let report = match detail {
            Detail::Levels => None,
            Detail::Report => {
                let erp = radiated_energy(source, &self.reference(), &together)?;
                let mut report = report(self, &differences, [&spectrum, &surface, &erp]);
                let weights = energy_weights(&spectrum.frequency, spectrum.range_hz, Weighting::A);
                let energies = mode_energies(self, &together, &weights)?;
                report.modes = mode_shares(bodies, &energies);
                report.fluid_loading = FluidLoading::new(bodies, &energies, self.solved_hz()[1]);
                Some(report)
            }
        };
        let signals = vec![(source, radiated_signals(self, &together, &spectrum)?)];
        let lacking_db = lacking_db(self, &spectrum, &together);
        Ok(RadiatedSound {
            uncertainty: uncertainty(self, &spectrum, together.range_hz, (&differences, lacking_db)),
            spectrum,
            signals,
            report,
        })
    }

    fn loads(&self, bodies: &[DryModes], acts: Loading) -> Result<Vec<FluidLoads>, AcousticsError> {
        let omega: Vec<f64> = bodies.iter().flat_map(|body| body.omega()).copied().collect();
        let damping = damping_ratios(self, &omega);
        let mut first = 0;
        let of_body = |body: &DryModes| {
            let (own, n) = (first, body.count());
            first += n;
            let mass_at = |mode: usize, hz: f64| self.added_mass(own + mode, hz)[own + mode];
            let damping = damping[own..own + n].to_vec();
            let mut loads = FluidLoads::new(damping, body.omega(), (own, self), mass_at);
            if acts == Loading::Full {
                // Rigid motion has no added mass, so that its mass balances forces and weight.
                let elastic = |mode: usize| f64::from(u8::from(body.omega()[mode] > 0.0));
                let column = |mode: usize, omega: f64| {
                    let mass = self.added_mass(own + mode, omega / TAU);
                    DVector::from_fn(n, |other, _| elastic(mode) * elastic(other) * mass[own + other])
                };
                let form = |omega: f64, v: &DVector<f64>| {
                    let motion = v.iter().enumerate().map(|(mode, v)| (own + mode, *v)).collect();
                    self.sparse_forms(&[(omega / TAU, motion)]).iter().sum()
                };
                loads.wet = Some(WetModes::new(body, TAU, column, form)?);
            }
            Ok(loads)
        };
        bodies.iter().map(of_body).collect()
    }

    fn pressures(&self, motions: &[&ModalSpectra]) -> Result<Option<Pressures>, AcousticsError> {
        if self.receivers() == 0 {
            return Ok(None);
        }
        let together = ModalSpectra::side_by_side(motions);
        let to = self.solved_hz()[1];
        let from = to * 2f64.powf(-FADE_OCTAVES);
        Ok(Some(Pressures {
            method: "boundary elements",
            values: ModalBem::pressures(self, &together.frequency, &together.accelerations)?,
            frequency: together.frequency.clone(),
            fade_hz: Some([from, to]),
            range_hz: [together.range_hz[0], from.min(together.range_hz[1])],
            interpolation_error: self.pressure_error(),
        }))
    }

    fn impedance(&self) -> Option<&dyn Impedance> {
        Some(self)
    }
}

/// Uncertainty from the difference between the two evaluations and, above the boundary elements, from the error of the
/// high-frequency limit. That error is estimated as the limit's difference from boundary elements in their uppermost
/// bands. Two bounds are added: for motion that standard modes of the same surface do not represent, and for panels at
/// thin gaps.
fn uncertainty(
    bem: &ModalBem,
    source: &SourceSpectrum,
    range: [f64; 2],
    (differences, lacking_db): (&Differences, Option<f64>),
) -> Uncertainty {
    let above = |factor: f64| {
        let join = bem.transition_hz()[0].clamp(range[0], range[1]);
        let (low, high) = (
            source.energy([range[0], join], Weighting::A),
            source.energy([join, range[1]], Weighting::A),
        );
        10.0 * ((low + factor * high) / (low + high)).log10()
    };
    let [mut least, mut most] = differences.limit_error_db;
    if let Some(error) = differences.blend_error_db {
        (least, most) = (least.min(error), most.max(error));
    }
    let evaluations =
        differences.surface_db.map_or(0.0, f64::abs) + lacking_db.unwrap_or(0.0) + bem.summary.gap_error_db;
    let lacking = lacking_db.map_or_else(String::new, |db| {
        format!("; motion that the standard modes of the same surface do not represent, at most {db:.2} dB")
    });
    let gap = match bem.summary.gap_error_db {
        0.0 => String::new(),
        db => format!("; panels at the rims of thin gaps, at most {db:.2} dB"),
    };
    Uncertainty {
        minus: Some(evaluations - above(10f64.powf(-most.max(0.0) / 10.0)).min(0.0)),
        plus: Some(evaluations + above(10f64.powf(-least.min(0.0) / 10.0)).max(0.0)),
        basis: format!(
            "difference between surface and far-field power, and above {:.0} Hz the error of the high-frequency \
             limit, {least:+.1} to \
             {most:+.1} dB in the last bands of the boundary elements{lacking}{gap}",
            bem.transition_hz()[0]
        ),
    }
}

/// Bound on the error in the A-weighted level \[dB\] due to motion that standard modes of the same surface do not
/// represent. None if the radiation was solved for the body's own modes. If the missing energy E_r radiates with
/// efficiency 1 and in phase with the rest, it changes the energy E by at most 2 sqrt(E E_r) + E_r.
fn lacking_db(bem: &ModalBem, source: &SourceSpectrum, together: &ModalSpectra) -> Option<f64> {
    let rest = SourceSpectrum {
        energy_density: bem.rest_energy(together)?,
        contributions: Vec::new(),
        ..source.clone()
    };
    let [whole, rest] = [source, &rest].map(|spectrum| spectrum.energy(together.range_hz, Weighting::A));
    Some(if whole > 0.0 {
        20.0 * (1.0 + (rest / whole).sqrt()).log10()
    } else {
        0.0
    })
}

/// Distributes the difference between far field and surface over the patches that radiate, so that they add up to the
/// far-field power; returns the spectrum from the surface.
fn share_out(source: &mut SourceSpectrum) -> SourceSpectrum {
    let mut surface = source.clone();
    surface.contributions.clear();
    let (rest, mut patches): (Vec<_>, Vec<_>) = source
        .contributions
        .drain(..)
        .partition(|part| ModalBem::is_residual(&part.name));
    for bin in 0..source.energy_density.len() {
        let rest: f64 = rest.iter().map(|part| part.energy_density[bin]).sum();
        surface.energy_density[bin] = (source.energy_density[bin] - rest).max(0.0);
        let giving: f64 = patches.iter().map(|part| part.energy_density[bin].max(0.0)).sum();
        for part in &mut patches {
            let e = &mut part.energy_density[bin];
            *e += if giving > 0.0 { rest * e.max(0.0) / giving } else { 0.0 };
        }
    }
    patches.retain(|part| part.energy_density.iter().any(|e| *e != 0.0));
    source.contributions = patches;
    surface
}

/// Differences between evaluations of the power of a source.
struct Differences {
    /// Surface minus far field, where only boundary elements are used \[dB, A-weighted\].
    surface_db: Option<f64>,
    /// Smallest and largest difference between the high-frequency limit and boundary elements in their uppermost bands
    /// \[dB\].
    limit_error_db: [f64; 2],
    /// Difference between the high-frequency limit and boundary elements in their uppermost third of an octave \[dB\].
    blend_error_db: Option<f64>,
    /// Surface minus far field in each band of the spectrum that boundary elements cover \[dB\].
    by_band_db: Vec<Option<f64>>,
}

impl Differences {
    fn new(bem: &ModalBem, together: &ModalSpectra, [far_field, surface]: [&SourceSpectrum; 2]) -> Self {
        let range = far_field.range_hz;
        let level = |spectrum: &SourceSpectrum| energy_level(spectrum.energy(solved(bem, range), Weighting::A));
        let limit = limit(bem, together, far_field);
        let compared = bem.compared_hz();
        let within = |[low, high]: [f64; 2]| low >= compared[0].max(range[0]) && high <= compared[1].min(range[1]);
        let error = |[low, high]: [f64; 2]| {
            let energies = [&limit, far_field].map(|spectrum| spectrum.energy([low, high], Weighting::Z));
            (within([low, high]) && energies.iter().all(|e| *e > 0.0))
                .then(|| 10.0 * (energies[0] / energies[1]).log10())
        };
        let bands = far_field.band_levels(range);
        let by_band_db: Vec<Option<f64>> = bands.iter().map(|b| error([b.band.low, b.band.high])).collect();
        let ends = by_band_db.iter().rev().flatten().take(JUDGED);
        let ends = ends.fold([f64::INFINITY, f64::NEG_INFINITY], |[least, most], &error| {
            [least.min(error), most.max(error)]
        });
        Self {
            surface_db: level(surface)
                .zip(level(far_field))
                .map(|(surface, far_field)| surface - far_field),
            limit_error_db: if ends[0] <= ends[1] { ends } else { [0.0; 2] },
            blend_error_db: error([compared[1] * 2f64.powf(-1.0 / 3.0), compared[1]]),
            by_band_db,
        }
    }
}

/// The part of a range where only boundary elements are used \[Hz\].
fn solved(bem: &ModalBem, range: [f64; 2]) -> [f64; 2] {
    [range[0], bem.transition_hz()[0].min(range[1])]
}

/// The report of one source: its power from the far field, from the surface, with radiation efficiency 1, and from the
/// high-frequency limit where boundary elements are available too.
fn report(
    bem: &ModalBem,
    differences: &Differences,
    [far_field, surface, erp]: [&SourceSpectrum; 3],
) -> RadiationReport {
    let range = far_field.range_hz;
    let join_hz = bem.transition_hz();
    let bands = far_field.band_levels(range);
    let (by_surface, by_erp) = (surface.band_levels(range), erp.band_levels(range));
    let inside = |b: &BandLevel| b.band.high > range[0] && b.band.low < range[1];
    let rows = bands
        .iter()
        .zip(&differences.by_band_db)
        .zip(by_surface.iter().zip(&by_erp));
    RadiationReport {
        join_hz,
        solved_hz: [bem.solved_hz()[1], bem.compared_hz()[1]],
        frequencies: bem.summary.samples,
        interpolation_error: bem.summary.interpolation,
        surface_difference_db: differences.surface_db,
        limit_error_db: differences.limit_error_db,
        blend_error_db: differences.blend_error_db,
        erp_lwa_db: energy_level(erp.energy(range, Weighting::A)),
        fluid_loading: None,
        modes: Vec::new(),
        bands: rows
            .filter(|((far, _), _)| inside(far))
            .map(|((far, error), (surface, erp))| RadiationBand {
                hz: far.band.nominal_hz(),
                lw_db: far.lw,
                surface_lw_db: if far.band.high <= join_hz[0] { surface.lw } else { None },
                erp_lw_db: erp.lw,
                limit_lw_db: far.lw.zip(*error).map(|(lw, error)| lw + error),
            })
            .collect(),
    }
}

/// The power from the high-frequency limit only; zero outside the range of comparison.
fn limit(bem: &ModalBem, together: &ModalSpectra, far_field: &SourceSpectrum) -> SourceSpectrum {
    let [from, to] = bem.compared_hz();
    // One extra bin on either side includes the ends.
    let inside: Vec<usize> = (0..together.frequency.len())
        .filter(|&bin| (0.95 * from..1.05 * to).contains(&together.frequency[bin]))
        .collect();
    let hz: Vec<f64> = inside.iter().map(|&bin| together.frequency[bin]).collect();
    let forms = bem.limit_forms(&hz, &together.accelerations.select_columns(&inside));
    let mut energy_density = vec![0.0; together.frequency.len()];
    for (bin, form) in inside.into_iter().zip(forms) {
        energy_density[bin] = 2.0 * form;
    }
    SourceSpectrum {
        energy_density,
        contributions: Vec::new(),
        ..far_field.clone()
    }
}
