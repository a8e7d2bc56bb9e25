use super::far_field::Radiated;
use super::problem::{Exterior, SurfacePressure};
use crate::bem::mesh::symmetry::Image;
use crate::checks::{ReceiverError, same_length};
use faer::Mat;
use nalgebra::{Complex, DMatrix, Point3};

impl Exterior {
    /// Complex pressure at points in the air for every pattern, points x patterns \[Pa s/m for velocities in m/s\]. The
    /// direct sound and the reflection by the floor (zero without a floor) are returned separately; their sum is the
    /// pressure.
    ///
    /// ```text
    /// p(x) = int (dG/dn_y p + j omega rho G v_n) dS_y        G = e^{-jkr} / (4 pi r)
    /// ```
    ///
    /// with the images in mirror planes and floor. The quadrature rule is that of distant panels, so points must not be
    /// close to the surface.
    ///
    /// # Errors
    /// [`ReceiverError::BelowFloor`]. [`ReceiverError::NearSurface`] for a point closer to the surface than the longest
    /// panel edge. Also an error if patterns or pressures have the wrong length.
    pub fn pressure_at(
        &self,
        points: &[Point3<f64>],
        velocities: &DMatrix<f64>,
        solution: &SurfacePressure,
    ) -> Result<[DMatrix<Complex<f64>>; 2], ReceiverError> {
        let mut all = self.pressures_at(points, &[(velocities, solution)])?;
        Ok(all.pop().unwrap_or_default())
    }

    /// The same for several solutions at one frequency, whose waves are evaluated only once.
    pub(crate) fn pressures_at(
        &self,
        points: &[Point3<f64>],
        all: &[Radiated<'_>],
    ) -> Result<Vec<[DMatrix<Complex<f64>>; 2]>, ReceiverError> {
        let boundary = self.boundary();
        for (velocities, solution) in all {
            let (values, nodes) = (boundary.velocity_values(), boundary.nodes());
            same_length("rows of the normal velocities", velocities.nrows(), values)?;
            same_length("rows of the pressure", solution.pressure.nrows(), nodes)?;
        }
        self.check_points(points)?;
        let (direct, by_floor): (Vec<Image>, Vec<Image>) = boundary
            .images()
            .into_iter()
            .partition(|image| image.sign_along(2) > 0.0);
        let matrix = |m: Mat<Complex<f64>>| DMatrix::from_fn(m.nrows(), m.ncols(), |i, j| m[(i, j)]);
        let direct = self.around_by(&direct, points, all).into_iter().map(matrix);
        let by_floor = self.around_by(&by_floor, points, all).into_iter().map(matrix);
        Ok(direct
            .zip(by_floor)
            .map(|(direct, by_floor)| [direct, by_floor])
            .collect())
    }

    /// Rejects points below the floor, or too close to the surface or one of its images.
    pub(crate) fn check_points(&self, points: &[Point3<f64>]) -> Result<(), ReceiverError> {
        let boundary = self.boundary();
        let images = self.imaged(&boundary.images());
        let needed = boundary.mesh().longest_edge();
        for point in points {
            if let Some(floor) = boundary.floor()
                && (point.z.is_nan() || point.z < floor)
            {
                return Err(ReceiverError::BelowFloor { z: point.z, floor });
            }
            for (y, _) in images.iter().flatten() {
                let distance = (point.coords - y).norm();
                if distance.is_nan() || distance < needed {
                    return Err(ReceiverError::NearSurface {
                        point: (*point).into(),
                        distance,
                        needed,
                    });
                }
            }
        }
        Ok(())
    }
}
