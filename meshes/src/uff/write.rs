//! Writes universal files.

use std::fmt::Write as _;

use crate::digits::exponential;
use crate::{FaceKind, MeshError, Surface};

/// A mode to be written.
#[derive(Clone, Copy, Debug)]
pub struct Mode<'a> {
    /// Natural frequency \[Hz\].
    pub hz: f64,
    /// Loss factor \[-\].
    pub loss_factor: f64,
    /// Shape over the degrees of freedom of the volume: 3 x its nodes, with modal mass 1 kg \[kg^-1/2\].
    pub shape: &'a [f64],
}

/// Writes the skin of a body and its modes as a universal file: datasets 2411 and 15 (nodes), 2412 (faces), and 55 (one
/// per mode).
///
/// The label of a node is its index in the volume mesh plus 1. Dataset 15 repeats 2411 in single precision for software
/// that cannot read the latter.
///
/// # Errors
/// [`MeshError::FieldLength`] if a shape has too few values for the nodes of the surface.
pub fn text(name: &str, surface: &Surface, modes: &[Mode<'_>]) -> Result<String, MeshError> {
    let highest = surface.volume_nodes.iter().max().map_or(0, |node| 3 * node + 3);
    for mode in modes {
        if mode.shape.len() < highest {
            return Err(MeshError::FieldLength {
                name: format!("mode of {:.1} Hz", mode.hz),
                found: mode.shape.len(),
                expected: highest,
            });
        }
    }
    // Writing to a string cannot fail, so the results of `writeln` are ignored.
    let mut text = String::new();
    let label = |point: usize| surface.volume_nodes[point] + 1;
    dataset(&mut text, 2411, |text| {
        for (point, p) in surface.points.iter().enumerate() {
            let _ = writeln!(text, "{:10}{:10}{:10}{:10}", label(point), 1, 1, 11);
            let _ = writeln!(
                text,
                "{}{}{}",
                field(p.x, 25, 16),
                field(p.y, 25, 16),
                field(p.z, 25, 16)
            );
        }
    });
    dataset(&mut text, 15, |text| {
        for (point, p) in surface.points.iter().enumerate() {
            let _ = writeln!(
                text,
                "{:10}{:10}{:10}{:10}{}{}{}",
                label(point),
                0,
                0,
                11,
                field(p.x, 13, 5),
                field(p.y, 13, 5),
                field(p.z, 13, 5)
            );
        }
    });
    dataset(&mut text, 2412, |text| {
        for (index, face) in surface.faces.iter().enumerate() {
            let (descriptor, order) = shell(face.kind);
            let _ = writeln!(
                text,
                "{:10}{descriptor:10}{:10}{:10}{:10}{:10}",
                index + 1,
                1,
                1,
                7,
                order.len()
            );
            for &k in order {
                let _ = write!(text, "{:10}", label(face.nodes[k]));
            }
            text.push('\n');
        }
    });
    for (index, mode) in modes.iter().enumerate() {
        dataset(&mut text, 55, |text| {
            // Five lines of identification; then structural, normal mode, 3 translations, displacement, real, 3 values
            // per node.
            let _ = writeln!(
                text,
                "{name}\nNONE\nNONE\nNONE\nmode {} at {:.3} Hz",
                index + 1,
                mode.hz
            );
            let _ = writeln!(text, "{:10}{:10}{:10}{:10}{:10}{:10}", 1, 2, 2, 8, 2, 3);
            let _ = writeln!(text, "{:10}{:10}{:10}{:10}", 2, 4, 1, index + 1);
            let numbers = [mode.hz, 1.0, 0.0, mode.loss_factor];
            let _ = writeln!(text, "{}", numbers.map(|x| field(x, 13, 5)).concat());
            for (point, &node) in surface.volume_nodes.iter().enumerate() {
                let _ = writeln!(text, "{:10}", label(point));
                let u = &mode.shape[3 * node..3 * node + 3];
                let _ = writeln!(
                    text,
                    "{}{}{}",
                    field(u[0], 13, 5),
                    field(u[1], 13, 5),
                    field(u[2], 13, 5)
                );
            }
        });
    }
    Ok(text)
}

/// Descriptor of a thin shell of this shape, and its nodes in order: corners and mid-side nodes alternate for a
/// parabolic shell.
fn shell(kind: FaceKind) -> (usize, &'static [usize]) {
    match kind {
        FaceKind::Tri3 => (91, &[0, 1, 2]),
        FaceKind::Tri6 => (92, &[0, 3, 1, 4, 2, 5]),
        FaceKind::Quad4 => (94, &[0, 1, 2, 3]),
        FaceKind::Quad8 | FaceKind::Quad9 => (95, &[0, 4, 1, 5, 2, 6, 3, 7]),
    }
}

fn dataset(text: &mut String, number: usize, content: impl FnOnce(&mut String)) {
    let _ = writeln!(text, "    -1\n{number:6}");
    content(text);
    text.push_str("    -1\n");
}

/// Formats a number for a fixed-width field. With more than two exponent digits, a field of width 13 would overflow;
/// such small values are physically meaningless.
fn field(x: f64, width: usize, digits: usize) -> String {
    let mut text = Vec::with_capacity(width);
    fortran(&mut text, if x.abs() < 1e-99 { 0.0 } else { x }, [width, digits]);
    String::from_utf8_lossy(&text).into_owned()
}

/// Appends a number in Fortran's format 1PEwidth.digits, with a sign and at least two digits in its exponent.
pub(super) fn fortran(text: &mut Vec<u8>, value: f64, [width, digits]: [usize; 2]) {
    let mut number = Vec::with_capacity(width);
    exponential(&mut number, value, digits);
    if let Some(mark) = number.iter().position(|&c| c == b'e') {
        number[mark] = b'E';
        if number.get(mark + 1) != Some(&b'-') {
            number.insert(mark + 1, b'+');
        }
        if number.len() == mark + 3 {
            number.insert(mark + 2, b'0');
        }
    }
    text.resize(text.len() + width.saturating_sub(number.len()), b' ');
    text.extend_from_slice(&number);
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_have_fortrans_width_and_exponent() {
        let written = |value: f64, form| {
            let mut text = Vec::new();
            fortran(&mut text, value, form);
            String::from_utf8(text).unwrap_or_default()
        };
        assert_eq!(written(4e-6, [13, 5]), "  4.00000E-06");
        assert_eq!(written(-1.5, [20, 12]), " -1.500000000000E+00");
        assert_eq!(written(2.5e-120, [20, 12]).len(), 20);
        assert_eq!(written(0.0, [13, 5]), "  0.00000E+00");
    }
}
