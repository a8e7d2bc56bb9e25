use serde::{Deserialize, Serialize};

/// An image of the surface in the floor and mirror planes: one bit for each axis of reflection.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct Image(u8);

impl Image {
    /// All combinations of reflections in the given planes, beginning with the surface itself.
    pub(crate) fn all(planes: &[Option<f64>; 3]) -> Vec<Self> {
        let axes = axes_of(planes);
        (0..8).filter(|image| image & !axes == 0).map(Self).collect()
    }

    /// -1 along axes of reflection, else 1.
    pub(crate) fn sign_along(self, axis: usize) -> f64 {
        if self.0 & (1 << axis) == 0 { 1.0 } else { -1.0 }
    }

    /// Determinant of the reflection.
    pub(crate) fn handedness(self) -> f64 {
        (0..3).map(|axis| self.sign_along(axis)).product()
    }

    /// Whether a point that lies in the planes of `mask` is its own image.
    pub(crate) fn fixes(self, mask: u8) -> bool {
        self.0 & !mask == 0
    }
}

/// The axes that have a plane, one bit each.
pub(crate) fn axes_of(planes: &[Option<f64>; 3]) -> u8 {
    (0..3).filter(|&a| planes[a].is_some()).map(|a| 1 << a).sum()
}

/// Parity of a motion about the mirror planes of constant x and y: even or odd. Motion is always even about the rigid
/// floor.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
pub struct Parity {
    /// Whether the sign changes across the plane of constant x.
    pub odd_x: bool,
    /// Whether the sign changes across the plane of constant y.
    pub odd_y: bool,
}

impl Parity {
    /// All parities with respect to the given mirror planes.
    pub fn all(mirrors: [bool; 2]) -> Vec<Self> {
        let signs = |mirror: bool| if mirror { [false, true].iter() } else { [false].iter() };
        signs(mirrors[0])
            .flat_map(|&odd_x| signs(mirrors[1]).map(move |&odd_y| Self { odd_x, odd_y }))
            .collect()
    }

    /// This parity with the one about the plane of constant x (axis 0) or y (axis 1) replaced.
    pub(crate) fn with(self, axis: usize, odd: bool) -> Self {
        match axis {
            0 => Self { odd_x: odd, ..self },
            _ => Self { odd_y: odd, ..self },
        }
    }

    /// Axes along which the field changes its sign, one bit each.
    pub(crate) fn odd_axes(self) -> usize {
        self.axes().into()
    }

    fn axes(self) -> u8 {
        u8::from(self.odd_x) | (u8::from(self.odd_y) << 1)
    }

    /// Sign of an image.
    pub(crate) fn sign(self, image: Image) -> f64 {
        if (image.0 & self.axes()).count_ones().is_multiple_of(2) {
            1.0
        } else {
            -1.0
        }
    }

    /// Whether the field changes its sign across the plane of this axis.
    pub(crate) fn is_odd(self, axis: usize) -> bool {
        self.axes() & (1 << axis) != 0
    }

    /// Whether the field is zero at a point that lies in the planes of `mask`.
    pub(crate) fn vanishes(self, mask: u8) -> bool {
        self.axes() & mask != 0
    }
}
