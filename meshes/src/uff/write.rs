//! Writing universal files.

use std::fmt::Write as _;

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

/// A universal file of the skin of a body and its modes: datasets 2411 and 15 (nodes), 2412 (faces), 55 (a mode each).
///
/// The label of a node is its index in the volume mesh plus 1. Dataset 15 repeats 2411 in single precision for software
/// that knows no other.
///
/// # Errors
/// [`MeshError::FieldLength`] for a shape that does not reach to the last node of the surface.
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
                fortran(p.x, 25, 16),
                fortran(p.y, 25, 16),
                fortran(p.z, 25, 16)
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
                fortran(p.x, 13, 5),
                fortran(p.y, 13, 5),
                fortran(p.z, 13, 5)
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
            // Five lines of identification; structural, normal mode, 3 translations, displacement, real, 3 values a node.
            let _ = writeln!(
                text,
                "{name}\nNONE\nNONE\nNONE\nmode {} at {:.3} Hz",
                index + 1,
                mode.hz
            );
            let _ = writeln!(text, "{:10}{:10}{:10}{:10}{:10}{:10}", 1, 2, 2, 8, 2, 3);
            let _ = writeln!(text, "{:10}{:10}{:10}{:10}", 2, 4, 1, index + 1);
            let numbers = [mode.hz, 1.0, 0.0, mode.loss_factor];
            let _ = writeln!(text, "{}", numbers.map(|x| fortran(x, 13, 5)).concat());
            for (point, &node) in surface.volume_nodes.iter().enumerate() {
                let _ = writeln!(text, "{:10}", label(point));
                let u = &mode.shape[3 * node..3 * node + 3];
                let _ = writeln!(
                    text,
                    "{}{}{}",
                    fortran(u[0], 13, 5),
                    fortran(u[1], 13, 5),
                    fortran(u[2], 13, 5)
                );
            }
        });
    }
    Ok(text)
}

/// Descriptor of a thin shell of this shape, and its nodes in order: corners and mid-sides in turn where it is parabolic.
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

/// A number as Fortran's 1PEw.d writes it, with two digits of exponent at least.
fn fortran(x: f64, width: usize, digits: usize) -> String {
    let text = format!("{x:.digits$e}");
    let (mantissa, exponent) = text.split_once('e').unwrap_or((&text, "0"));
    let exponent: i32 = exponent.parse().unwrap_or(0);
    // Beyond two digits of exponent a field of 13 would run over; nothing this small moves.
    let (mantissa, exponent) = if exponent < -99 {
        (format!("{:.digits$}", 0.0), 0)
    } else {
        (mantissa.to_owned(), exponent)
    };
    let sign = if exponent < 0 { '-' } else { '+' };
    let number = format!("{mantissa}E{sign}{:02}", exponent.abs());
    format!("{number:>width$}")
}
