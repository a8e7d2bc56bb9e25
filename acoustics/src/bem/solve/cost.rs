//! Memory and time of the equations at one frequency, estimated from the size of a surface.

use super::problem::EquationSolver;

/// Number of patterns assumed when the solver is chosen.
pub(crate) const PATTERNS: f64 = 100.0;

/// Size of a surface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SurfaceSize {
    /// Number of pressure unknowns.
    pub unknowns: f64,
    /// Number of panels.
    pub panels: f64,
    /// Number of velocity values: the corners of all panels.
    pub values: f64,
    /// Number of symmetric parts of the body; each parity has its own equations.
    pub copies: f64,
    /// Number of images in floor and mirror planes, including the surface itself.
    pub images: f64,
}

/// Memory and time of one frequency on one core.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FrequencyCost {
    /// Whether the matrix is compressed.
    pub compressed: bool,
    /// Memory for a hundred patterns in every parity \[bytes\].
    pub bytes: f64,
    /// Memory for each further pattern \[bytes\].
    pub bytes_per_pattern: f64,
    /// Time excluding patterns and close pairs \[s\].
    pub seconds: f64,
    /// Time for each pattern \[s\].
    pub seconds_per_pattern: f64,
}

impl FrequencyCost {
    /// Time for this many patterns in every parity \[s\].
    pub fn seconds_with(&self, patterns: f64) -> f64 {
        self.seconds + self.seconds_per_pattern * patterns
    }

    /// Memory for this many patterns in every parity \[bytes\].
    pub fn bytes_with(&self, patterns: f64) -> f64 {
        self.bytes + self.bytes_per_pattern * (patterns - PATTERNS)
    }
}

impl SurfaceSize {
    /// Estimates the cost of one frequency. The automatic choice is the compressed matrix if it takes less than half
    /// the time of the dense one for a hundred patterns. The margin allows for surfaces with deep recesses, which may
    /// need twice the usual number of steps.
    pub fn cost(&self, solver: EquationSolver) -> FrequencyCost {
        let [dense, compressed] = [self.dense(), self.compressed()];
        let compress = match solver {
            EquationSolver::Auto => 2.0 * compressed.seconds_with(PATTERNS) < dense.seconds_with(PATTERNS),
            EquationSolver::Dense => false,
            EquationSolver::Compressed => true,
        };
        if compress { compressed } else { dense }
    }

    /// Time for a pair of points by the far rule \[s\]: 3 ns per image and 3 ns per parity.
    fn pair_of_points(&self) -> f64 {
        3e-9 * (self.images + self.copies)
    }

    /// Rates measured by `benches/bem.rs`: 120 GFlop/s for factorisation and 100 for patterns, in single precision.
    fn dense(&self) -> FrequencyCost {
        let (n, values, parities) = (self.unknowns, self.values, self.copies);
        FrequencyCost {
            compressed: false,
            bytes: parities * 16.0 * n * n,
            bytes_per_pattern: 0.0,
            seconds: 0.5 * values * values * self.pair_of_points() + parities * 8.0 / 3.0 * n.powi(3) / 120e9,
            // B v, the solution and the far field for each pattern.
            seconds_per_pattern: parities * (4.0 * n * values + 8.0 * n * n + 8e3 * values) / 100e9,
        }
    }

    /// At the highest frequency, `benches/bem_compressed.rs` measured 1 300 close panels per panel, and per unknown 750
    /// entries in near blocks and 24 sqrt(N) in others. Each entry of the latter takes 100 ns plus 17 ns per image to
    /// approximate, and 0.5 ns per pattern. Each pattern takes eight products at 0.15 ns per entry.
    fn compressed(&self) -> FrequencyCost {
        let (n, values, parities) = (self.unknowns, self.values, self.copies);
        let corners = values / self.panels.max(1.0);
        let close = values * (0.5 * values).min(1300.0 * corners);
        let near = n * n.min(750.0);
        let distant = 24.0 * n.powf(1.5);
        FrequencyCost {
            compressed: true,
            // The blocks, and the Krylov subspace of ten columns per pattern.
            bytes: parities * 8.0 * (near + distant) + 16.0 * n * 10.0 * PATTERNS,
            bytes_per_pattern: 16.0 * n * 10.0,
            seconds: close * self.pair_of_points() + parities * distant * (100e-9 + 17e-9 * self.images),
            seconds_per_pattern: parities
                * (4.0 * close / corners / 100e9
                    + distant * 0.5e-9
                    + 8.0 * 0.15e-9 * (near + distant)
                    + 8e3 * values / 100e9),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A surface of triangles in free space.
    fn triangles(unknowns: f64) -> SurfaceSize {
        SurfaceSize {
            unknowns,
            panels: 2.0 * unknowns,
            values: 6.0 * unknowns,
            copies: 1.0,
            images: 1.0,
        }
    }

    #[test]
    fn large_surfaces_are_compressed() {
        let compressed = |unknowns: f64| triangles(unknowns).cost(EquationSolver::Auto).compressed;
        assert_eq!([1e3, 3e3, 7e3, 2e4].map(compressed), [false, false, true, true]);
    }

    #[test]
    fn memory_of_patterns_counts_from_a_hundred() {
        for solver in [EquationSolver::Dense, EquationSolver::Compressed] {
            let cost = triangles(5e3).cost(solver);
            assert_eq!(cost.bytes_with(100.0), cost.bytes);
            assert_eq!(cost.bytes_with(200.0), cost.bytes + 100.0 * cost.bytes_per_pattern);
        }
    }
}
