//! Fields in vertical planes through the driving axis and in a horizontal plane above the workpiece.

use super::{BandField, EXPOSURE, FieldSeries, FieldShape, PRESSURE, decibels};
use crate::radiation::sound::BandSound;
use crate::signals::Band;
use nalgebra::{Point3, Vector3};
use serde::Serialize;

/// Half side length of the planes \[m\].
const HALF_SIDE: f64 = 1.0;

/// Height of the vertical planes above the workpiece \[m\].
const ABOVE: f64 = 1.0;

/// Height of the horizontal plane above the workpiece \[m\]; large enough for the element size of all its meshes.
const LEVEL: f64 = 0.1;

/// Spacing of the points of a plane \[m\].
const SPACING: f64 = 0.06;

/// Positions of the planes.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Cuts {
    /// x and y of the driving axis \[m\].
    pub axis: [f64; 2],
    /// Height of the reflecting plane, the lower end of the vertical planes \[m\].
    pub low: f64,
    /// Height of the top of the workpiece \[m\].
    pub top: f64,
}

impl Cuts {
    /// Two vertical planes through the driving axis, and a horizontal plane above the workpiece.
    pub(crate) fn planes(&self) -> [Plane; 3] {
        let [x, y] = self.axis;
        let (low, top) = (self.low, self.top);
        let side = 2.0 * HALF_SIDE;
        let up = Vector3::z() * (top + ABOVE - low);
        [
            Plane::new("xz", Point3::new(x - HALF_SIDE, y, low), [Vector3::x() * side, up]),
            Plane::new("yz", Point3::new(x, y - HALF_SIDE, low), [Vector3::y() * side, up]),
            Plane::new(
                "xy",
                Point3::new(x - HALF_SIDE, y - HALF_SIDE, top + LEVEL),
                [Vector3::x() * side, Vector3::y() * side],
            ),
        ]
    }
}

/// Pressure levels in planes.
pub(crate) fn in_planes(prefix: &str, planes: &[Plane], found: &BandSound, bands: &[Band]) -> Vec<FieldSeries> {
    let mut first = 0;
    let of_plane = |plane: &Plane| {
        let (shape, count) = (plane.shape(), plane.points().count());
        let rows = first..first + count;
        first += count;
        let picture = |(number, band): (usize, &Band)| BandField {
            hz: band.nominal_hz(),
            shape: 0,
            points: vec![(
                PRESSURE.to_owned(),
                decibels(
                    found.exposure.column(number).rows_range(rows.clone()).iter().copied(),
                    EXPOSURE,
                ),
            )],
            polygons: Vec::new(),
        };
        FieldSeries {
            name: format!("{prefix}-plane-{}", plane.name),
            shapes: vec![shape],
            bands: bands.iter().enumerate().map(picture).collect(),
        }
    };
    planes.iter().map(of_plane).collect()
}

/// A grid of points in a plane; some points may be omitted.
pub(crate) struct Plane {
    name: &'static str,
    /// Number of columns of the grid, and its points row by row.
    columns: usize,
    grid: Vec<Point3<f64>>,
    shown: Vec<bool>,
}

impl Plane {
    fn new(name: &'static str, corner: Point3<f64>, sides: [Vector3<f64>; 2]) -> Self {
        let [columns, rows] = sides.map(|side| (side.norm() / SPACING).round() as usize + 1);
        let at = |row: usize, column: usize| {
            let share = |i: usize, n: usize| i as f64 / (n - 1) as f64;
            corner + sides[0] * share(column, columns) + sides[1] * share(row, rows)
        };
        let grid: Vec<Point3<f64>> = (0..rows)
            .flat_map(|row| (0..columns).map(move |column| at(row, column)))
            .collect();
        Self {
            name,
            columns,
            shown: vec![true; grid.len()],
            grid,
        }
    }

    /// Retains the points that pass the test.
    pub(crate) fn keep(&mut self, test: impl Fn(&[Point3<f64>]) -> Vec<bool>) {
        for (shown, passes) in self.shown.iter_mut().zip(test(&self.grid)) {
            *shown &= passes;
        }
    }

    /// The remaining points.
    pub(crate) fn points(&self) -> impl Iterator<Item = Point3<f64>> + '_ {
        self.grid
            .iter()
            .zip(&self.shown)
            .filter(|(_, shown)| **shown)
            .map(|(point, _)| *point)
    }

    fn shape(&self) -> FieldShape {
        let mut number = vec![usize::MAX; self.grid.len()];
        let left = (0..self.grid.len()).filter(|&i| self.shown[i]);
        left.enumerate().for_each(|(place, i)| number[i] = place);
        let corner = |i: usize| {
            let corners = [i, i + 1, i + self.columns + 1, i + self.columns];
            (!(i + 1).is_multiple_of(self.columns)).then_some(corners)
        };
        let squares = (0..self.grid.len() - self.columns - 1).filter_map(corner);
        FieldShape {
            points: self.points().map(Into::into).collect(),
            polygons: squares
                .filter(|corners| corners.iter().all(|&i| self.shown[i]))
                .map(|corners| corners.map(|i| number[i]).to_vec())
                .collect(),
        }
    }
}
