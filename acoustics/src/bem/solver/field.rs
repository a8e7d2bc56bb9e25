use crate::bem::solver::far_field::Source;
use crate::bem::solver::problem::{Exterior, SurfacePressure};
use crate::checks::{ReceiverError, same_length};
use nalgebra::{Complex, DMatrix, Point3, Vector3};
use std::f64::consts::PI;

impl Exterior {
    /// Complex pressure at points in the air for every pattern, points x patterns \[Pa s/m for velocities in m/s\]:
    /// direct sound, and reflection by the floor (zero without a floor); their sum is the pressure.
    ///
    /// ```text
    /// p(x) = int (dG/dn_y p + j omega rho G v_n) dS_y        G = e^{-jkr} / (4 pi r)
    /// ```
    ///
    /// with the images in mirror planes and floor. The rule is that of distant panels, so a point must keep a distance
    /// from the surface.
    ///
    /// # Errors
    /// [`ReceiverError::BelowFloor`], [`ReceiverError::NearSurface`] for a point closer to the surface than the
    /// longest edge of a panel, patterns or pressures of another length.
    pub fn pressure_at(
        &self,
        points: &[Point3<f64>],
        velocities: &DMatrix<f64>,
        solution: &SurfacePressure,
    ) -> Result<[DMatrix<Complex<f64>>; 2], ReceiverError> {
        let boundary = self.boundary();
        let (values, nodes) = (boundary.velocity_values(), boundary.nodes());
        same_length("rows of the normal velocities", velocities.nrows(), values)?;
        same_length("rows of the pressure", solution.pressure.nrows(), nodes)?;
        let omega = 2.0 * PI * solution.hz;
        let k = omega / self.air().sound_speed;
        let (sources, origin) = self.sources();
        let needed = boundary.mesh().longest_edge();
        let on_flow = Complex::new(0.0, omega * self.air().density);
        let of_floor = |by_floor: bool| {
            let mut on_p = DMatrix::<Complex<f64>>::zeros(points.len(), nodes);
            let mut on_v = DMatrix::<Complex<f64>>::zeros(points.len(), values);
            for (row, point) in points.iter().enumerate() {
                if let Some(floor) = boundary.floor()
                    && (point.z.is_nan() || point.z < floor)
                {
                    return Err(ReceiverError::BelowFloor { z: point.z, floor });
                }
                for image in boundary.images() {
                    if (image.sign_along(2) < 0.0) != by_floor {
                        continue;
                    }
                    let sign = solution.parity.sign(image);
                    for source in &sources {
                        let at = source.position + origin;
                        let y = Vector3::from_fn(|axis, _| boundary.mirrored(image, axis, at[axis]));
                        let area = Vector3::from_fn(|axis, _| image.sign_along(axis) * source.area[axis]);
                        let d = point.coords - y;
                        let r = d.norm();
                        if r.is_nan() || r < needed {
                            return Err(ReceiverError::NearSurface {
                                point: (*point).into(),
                                distance: r,
                                needed,
                            });
                        }
                        let g = Complex::from_polar(sign / (4.0 * PI * r), -k * r);
                        let slope = g * Complex::new(1.0, k * r) * (d.dot(&area) / (r * r));
                        let flow = g * on_flow * source.weight;
                        for j in 0..source.corners {
                            on_p[(row, source.nodes[j])] += slope * source.phi[j];
                            on_v[(row, source.first_value + j)] += flow * source.phi[j];
                        }
                    }
                }
            }
            let (re, im) = (on_v.map(|v| v.re) * velocities, on_v.map(|v| v.im) * velocities);
            Ok(on_p * &solution.pressure + re.zip_map(&im, Complex::new))
        };
        Ok([of_floor(false)?, of_floor(true)?])
    }

    fn sources(&self) -> (Vec<Source>, Vector3<f64>) {
        let (sources, origin, _) = self.quadrature();
        (sources, origin)
    }
}
