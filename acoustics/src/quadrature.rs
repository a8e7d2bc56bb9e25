/// Nodes and weights of the `n`-point Gauss-Legendre rule on \[-1, 1\]; none for n = 0.
pub(crate) fn gauss_legendre(n: usize) -> Vec<(f64, f64)> {
    nailnoise_meshes::gauss_legendre(n).unwrap_or_default()
}
