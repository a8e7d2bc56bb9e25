use nalgebra::DMatrix;

/// Phi^T K Phi with the Rayleigh kernel K_ab = sin(k r_ab)/(k r_ab) summed pair by pair.
///
/// The second evaluation beside the plane waves; it costs points² x modes. `sources` is points x columns, times area.
pub(crate) fn pairwise(k: f64, points: &[[f64; 2]], sources: &DMatrix<f64>) -> DMatrix<f64> {
    const CHUNK: usize = 256;
    let n = points.len();
    let mut result = DMatrix::zeros(sources.ncols(), sources.ncols());
    for start in (0..n).step_by(CHUNK) {
        let rows = CHUNK.min(n - start);
        let kernel = DMatrix::from_fn(rows, n, |i, j| {
            let (a, b) = (points[start + i], points[j]);
            let kr = k * (a[0] - b[0]).hypot(a[1] - b[1]);
            if kr < 1e-8 { 1.0 } else { kr.sin() / kr }
        });
        result += sources.rows(start, rows).transpose() * (kernel * sources);
    }
    result
}
