//! Modal bodies in the air around them.

use nailnoise_acoustics::radiation::radiator::FluidLoads;
use nailnoise_fem::vibration::ModalBody;
use nalgebra::DMatrix;

/// A body with radiation damping, in the coordinates of its modes in air if the air's added mass acts; then also the
/// amplitudes of its modes in vacuum in terms of these (modes in vacuum x modes in air).
pub(in crate::stages) fn in_air(mut body: ModalBody, loads: &FluidLoads) -> (ModalBody, Option<DMatrix<f64>>) {
    let Some(wet) = &loads.wet else {
        let added = body.zeta.iter_mut().zip(&loads.damping);
        added.for_each(|(zeta, added)| *zeta += added);
        return (body, None);
    };
    let zeta = wet.of_structure.iter().zip(&wet.of_radiation).map(|(s, r)| s + r);
    let body = ModalBody {
        omega: wet.omega.clone(),
        zeta: zeta.collect(),
        loads: wet.shapes.tr_mul(&body.loads),
        supports: wet.shapes.tr_mul(&body.supports),
        name: body.name,
    };
    (body, Some(wet.shapes.clone()))
}
