//! Memory and time of the equations of one frequency, from the size of a surface only.

use super::problem::EquationSolver;

/// Patterns for which the way of solving the equations is chosen.
pub(crate) const PATTERNS: f64 = 100.0;

/// Size of a surface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SurfaceSize {
    /// Pressure unknowns.
    pub unknowns: f64,
    /// Panels.
    pub panels: f64,
    /// Velocity values: corners of all panels.
    pub values: f64,
    /// Symmetric parts of the body; each parity has its own equations.
    pub copies: f64,
    /// Images in floor and mirror planes, the surface itself among them.
    pub images: f64,
}

/// Memory and time of one frequency on one core.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FrequencyCost {
    /// Whether the matrix is compressed.
    pub compressed: bool,
    /// Memory with a hundred patterns in every parity \[bytes\].
    pub bytes: f64,
    /// Memory of every further pattern \[bytes\].
    pub bytes_per_pattern: f64,
    /// Time without patterns and without close pairs \[s\].
    pub seconds: f64,
    /// Time of every pattern \[s\].
    pub seconds_per_pattern: f64,
}

impl FrequencyCost {
    /// Time with so many patterns in every parity \[s\].
    pub fn seconds_with(&self, patterns: f64) -> f64 {
        self.seconds + self.seconds_per_pattern * patterns
    }

    /// Memory with so many patterns in every parity \[bytes\].
    pub fn bytes_with(&self, patterns: f64) -> f64 {
        self.bytes + self.bytes_per_pattern * (patterns - PATTERNS)
    }
}

impl SurfaceSize {
    /// Cost of a frequency. The matrix is compressed automatically if that takes less than half the time of the dense
    /// one with a hundred patterns, because surfaces with deep recesses may take twice the usual number of steps.
    pub fn cost(&self, solver: EquationSolver) -> FrequencyCost {
        let [dense, compressed] = [self.dense(), self.compressed()];
        let compress = match solver {
            EquationSolver::Auto => 2.0 * compressed.seconds_with(PATTERNS) < dense.seconds_with(PATTERNS),
            EquationSolver::Dense => false,
            EquationSolver::Compressed => true,
        };
        if compress { compressed } else { dense }
    }

    /// Time of a pair of points by the far rule \[s\]: 3 ns an image and 3 ns a parity.
    fn pair_of_points(&self) -> f64 {
        3e-9 * (self.images + self.copies)
    }

    /// As measured by `benches/bem.rs`: 120 GFlop/s for factors and 100 for patterns in single precision.
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

    /// At the highest frequency, `benches/bem_compressed.rs` measured 1 300 close panels each, 750 entries an unknown
    /// in near blocks and 24 sqrt(N) in others. An entry of the latter takes 100 ns and 17 ns an image for its
    /// approximation, and 0.5 ns a pattern. Each pattern takes eight products at 0.15 ns an entry.
    fn compressed(&self) -> FrequencyCost {
        let (n, values, parities) = (self.unknowns, self.values, self.copies);
        let corners = values / self.panels.max(1.0);
        let close = values * (0.5 * values).min(1300.0 * corners);
        let near = n * n.min(750.0);
        let distant = 24.0 * n.powf(1.5);
        FrequencyCost {
            compressed: true,
            // The blocks, and the Krylov space of ten columns a pattern.
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
