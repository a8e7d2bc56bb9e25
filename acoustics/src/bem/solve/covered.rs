//! Surfaces under a porous cover: velocities of the air, powers and cost.

use super::cost::FrequencyCost;
use super::cover::SurfaceCover;
use super::far_field::Radiated;
use super::neumann::NeumannData;
use super::problem::{Exterior, SurfacePressure};
use crate::bem::error::BemError;
use crate::checks::{InputError, same_length};
use nalgebra::{Complex, DMatrix};

impl Exterior {
    /// Adds the cost of the columns of a cover, at most one for each unknown, to that of the motions.
    pub(crate) fn with_cost_of_cover(&self, cost: FrequencyCost) -> FrequencyCost {
        let Some(cover) = self.cover() else { return cost };
        let covered = cover.shares.iter().filter(|share| **share > 0.0).count() as f64;
        let (nodes, copies) = (self.boundary().nodes() as f64, self.boundary().copies() as f64);
        let columns = nodes * covered / cover.shares.len().max(1) as f64;
        FrequencyCost {
            bytes: cost.bytes + copies * 32.0 * nodes * columns,
            seconds: cost.seconds + cost.seconds_per_pattern * columns,
            ..cost
        }
    }

    /// Puts a porous layer on part of the surface. Velocities are those of the wall below it. The equations are solved
    /// with a dense matrix.
    ///
    /// # Errors
    /// If the shares are not one for each velocity value, or outside 0 to 1.
    pub fn with_cover(mut self, cover: SurfaceCover) -> Result<Self, BemError> {
        let values = self.boundary().velocity_values();
        same_length("covered shares of the corners", cover.shares.len(), values)?;
        if let Some(&value) = cover.shares.iter().find(|s| !(0.0..=1.0).contains(*s)) {
            return Err(InputError::OutsideRange {
                what: "covered share of a corner",
                value,
                low: 0.0,
                high: 1.0,
            }
            .into());
        }
        self.set_cover(cover);
        Ok(self)
    }

    /// Normal velocity of the air at the corners of all panels, real and imaginary parts, for given velocities of the
    /// wall and the pressure that they cause. `None` on a bare surface, where both velocities are equal.
    pub(crate) fn air_velocities(
        &self,
        velocities: &DMatrix<f64>,
        solution: &SurfacePressure,
    ) -> Option<[DMatrix<f64>; 2]> {
        let cover = self.cover()?;
        let of = cover.layer.transfer(solution.hz, self.air());
        let unknowns = self.unknowns_of_values();
        let mut air = velocities.map(Complex::from);
        for (v, p) in air
            .as_mut_slice()
            .chunks_exact_mut(unknowns.len().max(1))
            .zip(solution.pressure.column_iter())
        {
            cover.to_outer_face(&of, (p.as_slice(), &unknowns), v);
        }
        Some([air.map(|v| v.re), air.map(|v| v.im)])
    }

    /// The pressure unknown at each velocity value.
    pub(crate) fn unknowns_of_values(&self) -> Vec<usize> {
        let panels = self.boundary().mesh().panels.iter();
        panels.flat_map(|panel| self.boundary().unknowns_of(panel)).collect()
    }

    /// int v_i* p_j dS of every patch for the velocities v of the air, given those of the wall.
    pub(crate) fn powers(
        &self,
        velocities: &DMatrix<f64>,
        solution: &SurfacePressure,
    ) -> Result<Vec<DMatrix<Complex<f64>>>, BemError> {
        let Some(air) = self.air_velocities(velocities, solution) else {
            return self.impedance(velocities, solution);
        };
        let [real, imaginary] = air.each_ref().map(|part| self.impedance(part, solution));
        let pairs = real?.into_iter().zip(imaginary?);
        Ok(pairs.map(|(re, im)| re - im * Complex::<f64>::i()).collect())
    }

    /// int (1 + (T - 1) s) v_i p_j dS over the surface, which is symmetric by reciprocity.
    pub(crate) fn reciprocal_impedance(
        &self,
        data: &NeumannData,
        solution: &SurfacePressure,
    ) -> Result<DMatrix<Complex<f64>>, BemError> {
        let zeros = DMatrix::zeros(data.count(), data.count());
        let bare = self.impedances(data.by_patch(), solution)?;
        let mut sum = bare.iter().fold(zeros, |sum, z| sum + z);
        if let (Some(cover), Some(patterns)) = (self.cover(), data.cover()) {
            let excess = cover.layer.transfer(solution.hz, self.air()).velocity - 1.0;
            for z in self.impedance(&patterns.on_covered(data.velocities()), solution)? {
                sum += z * excess;
            }
        }
        Ok(sum)
    }

    /// Radiating fields with real velocities. The first half of the columns plus j times the second half is the field
    /// of a covered surface. `None` on a bare surface.
    pub(crate) fn with_real_velocities(&self, all: &[Radiated<'_>]) -> Option<Vec<(DMatrix<f64>, SurfacePressure)>> {
        let of = |(velocities, solution): &Radiated<'_>| {
            let [real, imaginary] = self.air_velocities(velocities, solution)?;
            let motions = real.ncols();
            let mut both = real.resize_horizontally(2 * motions, 0.0);
            both.columns_mut(motions, motions).copy_from(&imaginary);
            let pressure = solution.pressure.clone();
            let pressure = pressure.resize_horizontally(2 * motions, Complex::default());
            Some((both, SurfacePressure { pressure, ..**solution }))
        };
        all.iter().map(of).collect()
    }
}
