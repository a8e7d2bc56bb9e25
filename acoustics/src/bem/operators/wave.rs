//! Wavenumber and coupling, and the matrices between two blocks of panels.

use super::blocks::Block;
use faer::MatRef;
use nalgebra::Complex;

/// Wavenumber, and the coupling parameter alpha = -j `coupling`.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Wave {
    pub(crate) k: f64,
    pub(crate) coupling: f64,
}

impl Wave {
    pub(crate) fn alpha(self) -> Complex<f64> {
        Complex::new(0.0, -self.coupling)
    }
}

/// Values between the corners of the panels e and f, with f fastest so that vectors contain neighbouring panels:
/// `data[((part * rows + row) * corners_f + j) * width_f + f]`, where part 0 is real and 1 imaginary.
#[derive(Debug, Default)]
pub(crate) struct Buffer {
    pub(crate) data: Vec<f32>,
    pub(crate) rows: usize,
    pub(crate) columns: usize,
}

impl Buffer {
    pub(crate) fn reset(&mut self, rows: usize, columns: usize) {
        (self.rows, self.columns) = (rows, columns);
        self.data.clear();
        self.data.resize(2 * rows * columns, 0.0);
    }

    pub(crate) fn start(&self, part: usize, row: usize) -> usize {
        (part * self.rows + row) * self.columns
    }

    pub(crate) fn add(&mut self, row: usize, column: usize, value: Complex<f64>) {
        let (re, im) = (self.start(0, row) + column, self.start(1, row) + column);
        self.data[re] += value.re as f32;
        self.data[im] += value.im as f32;
    }

    /// Real rows above imaginary rows.
    pub(crate) fn stacked(&self) -> MatRef<'_, f32> {
        MatRef::from_row_major_slice(&self.data, 2 * self.rows, self.columns)
    }
}

/// The operators for one pair of blocks and one parity. A = -K + alpha W acts on pressures, B = S + alpha K' on normal
/// derivatives. Since S and W are symmetric and K' is the transpose of K, one pass yields both directions. B acts on
/// values at the points of the far rule, which are as many as the corners.
#[derive(Debug, Default)]
pub(crate) struct Operators {
    /// A from f to the nodes of e.
    pub(crate) a: Buffer,
    /// Transpose of A from e to f: -K' + alpha W, at the nodes of e.
    pub(crate) a_back: Buffer,
    /// B from the points of f to the nodes of e.
    pub(crate) b: Buffer,
    /// Transpose of B from e to f: S + alpha K, at the points of the panels e.
    pub(crate) b_back: Buffer,
}

impl Operators {
    pub(crate) fn reset(&mut self, [e, f]: [&Block; 2], diagonal: bool) {
        let columns = f.corners * f.width;
        self.a.reset(e.nodes.len(), columns);
        self.b.reset(e.nodes.len(), columns);
        self.a_back.reset(if diagonal { 0 } else { e.nodes.len() }, columns);
        self.b_back
            .reset(if diagonal { 0 } else { e.corners * e.width }, columns);
    }
}
