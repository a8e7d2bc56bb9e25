use nalgebra::{Complex, DMatrix};

/// Modal radiation resistance R(f) of one frequency: Hermitian, positive semidefinite, modes x modes.
///
/// With mass-normalised modal coordinates its unit is 1/s. It is real symmetric unless surface points move with phase
/// lags of their own, as sand around a block does; then `imaginary` holds the antisymmetric part.
#[derive(Debug, Clone, PartialEq)]
pub struct Resistance {
    /// Symmetric real part.
    pub real: DMatrix<f64>,
    /// Antisymmetric imaginary part; `None` where it is zero.
    pub imaginary: Option<DMatrix<f64>>,
}

impl Resistance {
    /// The quadratic form v^H R v.
    pub fn form(&self, v: &[Complex<f64>]) -> f64 {
        let n = v.len();
        let mut total = 0.0;
        for j in 0..n {
            for i in 0..n {
                let pair = v[i].conj() * v[j];
                total += self.real[(i, j)] * pair.re;
                if let Some(imaginary) = &self.imaginary {
                    total -= imaginary[(i, j)] * pair.im;
                }
            }
        }
        total
    }

    /// R times a real factor.
    pub fn scaled(mut self, factor: f64) -> Self {
        self.real *= factor;
        if let Some(imaginary) = &mut self.imaginary {
            *imaginary *= factor;
        }
        self
    }

    /// Rounded to single precision.
    pub(crate) fn single(mut self) -> Self {
        let round = |v: &mut f64| *v = f64::from(*v as f32);
        self.real.iter_mut().for_each(round);
        self.imaginary.iter_mut().flatten().for_each(round);
        self
    }

    /// Adds `factor` times another resistance.
    pub fn add_scaled(&mut self, factor: f64, other: &Self) {
        add_scaled(&mut self.real, factor, &other.real);
        if let Some(theirs) = &other.imaginary {
            let (rows, columns) = theirs.shape();
            add_scaled(
                self.imaginary.get_or_insert_with(|| DMatrix::zeros(rows, columns)),
                factor,
                theirs,
            );
        }
    }

    /// The zero resistance of so many modes.
    pub fn zeros(modes: usize) -> Self {
        Self {
            real: DMatrix::zeros(modes, modes),
            imaginary: None,
        }
    }
}

/// v^T R v by the entries of a real R, for those of v that are not zero.
pub(super) fn sparse_form(v: &[(usize, f64)], entry: impl Fn(usize, usize) -> f64) -> f64 {
    let row = |&(i, a): &(usize, f64)| a * v.iter().map(|&(j, b)| entry(i, j) * b).sum::<f64>();
    v.iter().map(row).sum()
}

fn add_scaled(to: &mut DMatrix<f64>, factor: f64, from: &DMatrix<f64>) {
    to.iter_mut().zip(from.iter()).for_each(|(a, b)| *a += factor * b);
}

/// A radiation operator reduced to modal coordinates.
pub trait ModalRadiation: Sync {
    /// Label of the operator, shown beside every result.
    fn method(&self) -> &str;

    /// Number of modes.
    fn modes(&self) -> usize;

    /// Names of the surface patches, whose resistances add up to the whole.
    fn patches(&self) -> &[String];

    /// Highest frequency the operator was computed for \[Hz\].
    fn highest_hz(&self) -> f64;

    /// Resistance R(f) of the whole surface at the frequency `hz`.
    fn resistance(&self, hz: f64) -> Resistance;

    /// v^T R(f) v of the whole surface for each frequency \[Hz\] and the modes of a real motion v that are not at rest, each
    /// once.
    fn sparse_forms(&self, motions: &[(f64, Vec<(usize, f64)>)]) -> Vec<f64> {
        let form = |(hz, v): &(f64, Vec<(usize, f64)>)| {
            let r = self.resistance(*hz).real;
            let row = |&(i, a): &(usize, f64)| a * v.iter().map(|&(j, b)| r[(i, j)] * b).sum::<f64>();
            v.iter().map(row).sum()
        };
        motions.iter().map(form).collect()
    }

    /// a^H (R_p / omega²) a for every patch p (rows) and frequency (columns), with the modal accelerations a in the
    /// columns of `accelerations` (modes x frequencies).
    fn energy_forms(&self, frequency: &[f64], accelerations: &DMatrix<Complex<f64>>) -> DMatrix<f64>;

    /// (R / omega²) a for the whole surface at every frequency (columns), modes x frequencies.
    fn images(&self, frequency: &[f64], accelerations: &DMatrix<Complex<f64>>) -> DMatrix<Complex<f64>> {
        let mut images = DMatrix::zeros(accelerations.nrows(), frequency.len());
        for (bin, &hz) in frequency.iter().enumerate() {
            let r = self.resistance(hz).scaled((std::f64::consts::TAU * hz).powi(-2));
            let a = accelerations.columns(bin, 1).into_owned();
            images.set_column(bin, &super::root::image(&r, &a).column(0));
        }
        images
    }

    /// How many signals [`Self::root_signals`] returns.
    fn signals(&self) -> usize {
        self.modes()
    }

    /// Signals x (rows) at every frequency (columns) with |x|² = a^H (R / omega²) a for the whole surface: x = S^H a
    /// with S the Hermitian root of R / omega², smooth over frequency. Where S is interpolated the energies hold to
    /// the interpolation error.
    fn root_signals(&self, frequency: &[f64], accelerations: &DMatrix<Complex<f64>>) -> DMatrix<Complex<f64>> {
        super::root::one_by_one(self, frequency, accelerations)
    }
}
