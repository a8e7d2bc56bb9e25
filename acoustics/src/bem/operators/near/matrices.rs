use rustfft::num_complex::Complex;

/// Matrices of one pair; rows are corner functions of the first panel, columns those of the second.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct PairMatrices {
    /// Integral of phi_i G phi_j.
    pub(crate) s: [[Complex<f64>; 4]; 4],
    /// Integral of phi_i dG/dn_y phi_j.
    pub(crate) k: [[Complex<f64>; 4]; 4],
    /// Integral of phi_i dG/dn_x phi_j.
    pub(crate) kp: [[Complex<f64>; 4]; 4],
    /// Integral of G (curl phi_i . curl phi_j - k² n_x . n_y phi_i phi_j).
    pub(crate) w: [[Complex<f64>; 4]; 4],
}

impl PairMatrices {
    pub(super) fn add_scaled(&mut self, factor: Complex<f64>, other: &Self) {
        let all = [
            (&mut self.s, &other.s),
            (&mut self.k, &other.k),
            (&mut self.kp, &other.kp),
            (&mut self.w, &other.w),
        ];
        for (to, from) in all {
            let entries = to.as_flattened_mut().iter_mut().zip(from.as_flattened());
            entries.for_each(|(to, from)| *to += factor * from);
        }
    }
}
