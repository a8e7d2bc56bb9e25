//! Pressures of the five gas volumes.

use super::sheet::{Level, Panel};
use super::{Figure, Shot, scale};

pub(super) fn figure(shot: &Shot<'_>) -> Figure {
    let r = shot.record;
    let volumes = [
        ("above piston", 0, &r.above_piston),
        ("below piston", 1, &r.below_piston),
        ("return volume", 2, &r.return_volume),
        ("above head valve", 3, &r.above_valve),
        ("supply side", 4, &r.supply),
    ];
    let curve = |(label, colour, volume): (&str, usize, &nailnoise_dynamics::Volume)| {
        shot.curve(label, colour, volume.pressure.iter().map(|p| 1e-3 * p))
    };
    let curves: Vec<_> = volumes.into_iter().map(curve).collect();
    let panel = Panel {
        y_label: "Pressure (kPa, absolute)",
        y_range: scale::range(curves.iter().flat_map(|curve| curve.y.iter().copied())),
        height: 88,
        curves,
        levels: vec![Level {
            label: "ambient".to_owned(),
            value: 1e-3 * shot.design.ambient.pressure,
            above: false,
        }],
        spans: Vec::new(),
    };
    Figure {
        name: "pressures",
        svg: shot.sheet("Pressures", vec![panel]).svg(),
    }
}
