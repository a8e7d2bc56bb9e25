//! Views of quantities that the section cannot show to scale: the gas volumes and the pattern of the exhaust holes.

use super::label::text;
use super::shape::{Annotation, Chamber, Line, LineStyle, Material, Outline, Part, Point, Side, View, rectangle};
use crate::design::{Value, Values};

use Side::{Left, Right};

/// Maximum number of exhaust holes drawn.
const MOST_HOLES: u32 = 200;

/// The gas volumes and the displacement of the piston, drawn as cubes of the same volume.
pub(super) fn volumes(v: &Values) -> View {
    let c = &v.chambers;
    let swept = v.piston.area() * v.piston.stroke;
    let gas = [
        (
            "chambers.supply_volume",
            "supply side",
            Chamber::Supply,
            c.supply_volume,
        ),
        (
            "chambers.return_volume",
            "return volume",
            Chamber::Return,
            c.return_volume,
        ),
        (
            "chambers.above_piston",
            "above the piston",
            Chamber::AbovePiston,
            c.above_piston,
        ),
        (
            "chambers.below_piston",
            "below the piston",
            Chamber::BelowPiston,
            c.below_piston,
        ),
        (
            "exhaust.plenum.volume",
            "under the cap",
            Chamber::Plenum,
            v.exhaust.plenum.volume,
        ),
        (
            "chambers.above_valve",
            "above the head valve",
            Chamber::AboveValve,
            c.above_valve,
        ),
    ];
    let mut x = 0.0;
    let (mut parts, mut annotations, mut lines) = (Vec::new(), Vec::new(), Vec::new());
    let mut edges = |style, square: &[Point]| {
        let points = [square, &square[..1]].concat();
        lines.push(Line { style, points });
    };
    for (index, (key, name, chamber, volume)) in gas.into_iter().enumerate() {
        let edge = volume.cbrt();
        let square = rectangle([x, x + edge], [0.0, edge]);
        let side = if index < 2 { Left } else { Right };
        let height = if side == Left { 0.8 - 0.3 * index as f64 } else { 0.5 };
        annotations.push(Annotation::area(
            key,
            side,
            [x + 0.5 * edge, height * edge],
            square.clone(),
        ));
        edges(LineStyle::Edge, &square);
        parts.push(Part::new(name, Material::Gas(chamber), vec![square]));
        x += edge + 6e-3;
        if index == 1 {
            let edge = swept.cbrt();
            edges(LineStyle::Phantom, &rectangle([x, x + edge], [0.0, edge]));
            x += edge + 6e-3;
        }
    }
    View {
        name: "volumes",
        title: format!(
            "Gas volumes as cubes; dash-dotted the {} that the piston sweeps, A\u{2081} L",
            text(&Value::Number(swept), "m3")
        ),
        parts,
        lines,
        annotations,
        window: None,
        details: Vec::new(),
    }
}

/// The exhaust holes seen from outside, in rows, with their pitch as the distance of adjacent holes.
pub(super) fn holes(v: &Values) -> View {
    let (exhaust, drawn) = (&v.exhaust, v.exhaust.holes.min(MOST_HOLES));
    let columns = (f64::from(drawn) * 2.0).sqrt().ceil().max(f64::from(drawn.min(6))) as u32;
    let [radius, pitch] = [0.5 * exhaust.hole_diameter, exhaust.pitch];
    let centre = |hole: u32| {
        let [column, row] = [hole % columns, hole / columns];
        [f64::from(column) * pitch, -f64::from(row) * pitch]
    };
    let outlines = (0..drawn).map(|hole| Outline::Circle {
        centre: centre(hole),
        radius,
    });
    let above = radius + 6e-3;
    let mut annotations = vec![
        Annotation::dot("exhaust.holes", Left, centre(0)),
        Annotation::across(
            "exhaust.hole_diameter",
            Left,
            [-radius, radius],
            -radius - 4e-3,
            [0.0, 0.0],
        ),
    ];
    if drawn > 1 {
        annotations.push(Annotation::across(
            "exhaust.pitch",
            Right,
            [0.0, pitch],
            above,
            [0.0; 2],
        ));
    }
    let more = if drawn < exhaust.holes {
        format!(", the first {drawn} of {}", exhaust.holes)
    } else {
        String::new()
    };
    View {
        name: "holes",
        title: format!("Exhaust holes from outside{more}; their arrangement is not a key"),
        parts: vec![Part {
            name: "exhaust holes",
            material: Material::Opening,
            outlines: outlines.collect(),
        }],
        lines: Vec::new(),
        annotations,
        window: None,
        details: Vec::new(),
    }
}
