//! Points that represent a rectangular contact area.

use nailnoise_meshes::gauss_legendre;

/// Distribution of the points of a [`ContactGrid`].
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum GridRule {
    /// Gauss-Legendre points and weights, the better default. Area, rocking stiffness and the coupling of smooth mode
    /// shapes are exact, and the outermost points lie closer to the edge, where a rocking block lands.
    GaussLegendre,
    /// Centres of equal cells: every point represents the same area, but n points per side lose 1/n^2 of the rocking
    /// stiffness (4 % for 5).
    CellCentred,
}

/// Points (x, y) on the rectangle |x| <= lx/2, |y| <= ly/2 with the areas they represent.
#[derive(Debug, Clone, PartialEq)]
pub struct ContactGrid {
    /// Coordinates from the centre \[m\], with x varying fastest.
    pub points: Vec<[f64; 2]>,
    /// Tributary areas \[m2\]; their sum is lx ly.
    pub areas: Vec<f64>,
}

impl ContactGrid {
    /// nx x ny points on a rectangle of lx x ly.
    pub fn new(lx: f64, ly: f64, nx: usize, ny: usize, rule: GridRule) -> Self {
        let (xs, wx) = line(nx, rule);
        let (ys, wy) = line(ny, rule);
        let mut grid = Self {
            points: Vec::with_capacity(nx * ny),
            areas: Vec::with_capacity(nx * ny),
        };
        for (y, wy) in ys.iter().zip(&wy) {
            for (x, wx) in xs.iter().zip(&wx) {
                grid.points.push([0.5 * lx * x, 0.5 * ly * y]);
                grid.areas.push(0.25 * lx * ly * wx * wy);
            }
        }
        grid
    }
}

fn line(n: usize, rule: GridRule) -> (Vec<f64>, Vec<f64>) {
    match rule {
        GridRule::CellCentred => {
            let width = 2.0 / n as f64;
            (
                (0..n).map(|i| -1.0 + (i as f64 + 0.5) * width).collect(),
                vec![width; n],
            )
        }
        GridRule::GaussLegendre => gauss_legendre(n).into_iter().unzip(),
    }
}
