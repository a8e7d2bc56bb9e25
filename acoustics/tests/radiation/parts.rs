//! The energies of the parts of a surface: the books of one radiation problem.

use nailnoise_acoustics::radiation::{
    ModalRadiation, ModalSpectra, PartOfSurface, Resistance, radiated_energy, radiated_signals,
};
use nailnoise_acoustics::signals::{PowerSignals, Weighting};
use nalgebra::{Complex, DMatrix, dmatrix};

/// Patches that move independently, with a resistance R omega^2: the factor makes R / omega^2 constant.
struct Patches {
    resistance: DMatrix<f64>,
    names: Vec<String>,
}

impl Patches {
    fn new(resistance: DMatrix<f64>) -> Self {
        Self {
            resistance,
            names: vec!["all".to_owned()],
        }
    }

    /// Modes of the whole, followed by the same with only `part` in motion.
    fn with_part(&self, part: usize) -> Self {
        let n = self.resistance.nrows();
        let basis = DMatrix::from_fn(n, 2 * n, |row, column| {
            f64::from(row == column || column == n + part && row == part)
        });
        Self::new(basis.transpose() * &self.resistance * basis)
    }
}

impl ModalRadiation for Patches {
    fn method(&self) -> &str {
        "test"
    }

    fn modes(&self) -> usize {
        self.resistance.nrows()
    }

    fn patches(&self) -> &[String] {
        &self.names
    }

    fn highest_hz(&self) -> f64 {
        f64::INFINITY
    }

    fn resistance(&self, hz: f64) -> Resistance {
        Resistance {
            real: self.resistance.clone() * (std::f64::consts::TAU * hz).powi(2),
            imaginary: None,
        }
    }

    fn energy_forms(&self, _: &[f64], accelerations: &DMatrix<Complex<f64>>) -> DMatrix<f64> {
        let images = self.resistance.map(Complex::from) * accelerations;
        DMatrix::from_fn(1, accelerations.ncols(), |_, bin| {
            accelerations.column(bin).dotc(&images.column(bin)).re
        })
    }
}

/// One frequency at which R / omega^2 is `resistance` and A are the `velocities`: E = 2 A^H (R / omega^2) A.
fn books(resistance: &DMatrix<f64>, velocities: [Complex<f64>; 2]) -> (f64, [f64; 2]) {
    let patches = Patches::new(resistance.clone());
    let spectra = ModalSpectra {
        frequency: vec![100.0],
        accelerations: DMatrix::from_column_slice(2, 1, &velocities),
        range_hz: [50.0, 200.0],
    };
    let whole = radiated_energy("whole", &patches, &spectra).unwrap().energy_density[0];
    let parts = [0, 1].map(|part| {
        let found = PartOfSurface::new("part", &patches.with_part(part), &spectra).unwrap();
        found.spectrum.energy_density[0]
    });
    (whole, parts)
}

#[test]
fn a_part_has_its_own_term_and_half_of_each_cross_term() {
    let resistance = dmatrix![2.0, -1.2; -1.2, 3.0];
    let turned = Complex::from_polar(0.8, 0.3);
    let (whole, parts) = books(&resistance, [Complex::from(1.0), turned]);
    assert!((whole - 4.171_508).abs() < 5e-7, "{whole}");
    assert!(
        (parts[0] - 2.165_754).abs() < 5e-7 && (parts[1] - 2.005_754).abs() < 5e-7,
        "{parts:?}"
    );
    assert!((parts[0] + parts[1] - whole).abs() < 1e-12 * whole);
    // Own terms are those of the separate parts.
    let own = [[1.0.into(), 0.0.into()], [0.0.into(), turned]].map(|v| books(&resistance, v).0);
    assert!((own[0] - 4.0).abs() < 1e-12 && (own[1] - 3.84).abs() < 1e-12, "{own:?}");
}

#[test]
fn a_part_may_absorb_and_the_parts_still_sum_to_the_whole() {
    let (whole, parts) = books(&dmatrix![2.0, -1.2; -1.2, 3.0], [0.3.into(), 1.0.into()]);
    assert!((whole - 4.92).abs() < 1e-12, "{whole}");
    assert!(
        (parts[0] + 0.36).abs() < 1e-12 && (parts[1] - 5.28).abs() < 1e-12,
        "{parts:?}"
    );
}

/// Three patches in transient motion.
#[test]
fn parts_sum_to_the_whole_in_every_line_cell_and_interval() {
    let patches = Patches::new(dmatrix![2.0, -1.2, 0.4; -1.2, 3.0, -0.9; 0.4, -0.9, 1.0]);
    let frequency: Vec<f64> = (10..400).map(|n| 5.0 * f64::from(n)).collect();
    let spectra = ModalSpectra {
        accelerations: DMatrix::from_fn(3, frequency.len(), |mode, bin| {
            let (m, b) = (mode as f64, bin as f64);
            Complex::from_polar(1.0 + (0.7 * m + 0.013 * b).sin(), 0.31 * b * (m + 1.0) + m)
        }),
        frequency,
        range_hz: [50.0, 2000.0],
    };
    let (edges, range) = ([0.0, 0.013, 0.05, 0.12], [60.0, 1900.0]);
    let whole = radiated_energy("whole", &patches, &spectra).unwrap();
    let signals: PowerSignals = radiated_signals(&patches, &spectra, &whole).unwrap();
    let over_time = signals.analyse(&edges, range);
    let parts = [0, 1, 2].map(|part| PartOfSurface::new("part", &patches.with_part(part), &spectra).unwrap());
    let histories = parts.each_ref().map(|part| part.analyse(&edges, range));
    let close = |sum: f64, whole: f64, scale: f64| assert!((sum - whole).abs() < 1e-12 * scale, "{sum} {whole}");
    let most = whole.energy_density.iter().copied().fold(0.0, f64::max);
    for (bin, energy) in whole.energy_density.iter().enumerate() {
        close(
            parts.iter().map(|part| part.spectrum.energy_density[bin]).sum(),
            *energy,
            most,
        );
    }
    for weighting in [Weighting::A, Weighting::Z] {
        let energy = whole.energy(range, weighting);
        close(
            parts.iter().map(|part| part.spectrum.energy(range, weighting)).sum(),
            energy,
            energy,
        );
    }
    let peak = over_time.history.power.iter().copied().fold(0.0, f64::max);
    for (cell, power) in over_time.history.power.iter().enumerate() {
        close(histories.iter().map(|own| own.history.power[cell]).sum(), *power, peak);
    }
    for (index, interval) in over_time.intervals.iter().enumerate() {
        close(
            histories.iter().map(|own| own.intervals[index].energy).sum(),
            interval.energy,
            interval.energy,
        );
        let cut = histories.iter().map(|own| own.intervals[index].cut_energy).sum();
        close(cut, interval.cut_energy, interval.cut_energy);
    }
}
