//! Parts of the section through the tool: cylinder, piston, head valve, barrel and cap, handle, nose, nail, wood, and
//! the gas between them.

use super::layout::Layout;
use super::shape::{Chamber, Line, LineStyle, Material, Outline, Part, Point, mirrored, rectangle};
use crate::design::{FittingKind, MufflerKind, Values};

/// A polygon and its mirror image, for both sides of a section.
fn both(polygon: Vec<Point>) -> Vec<Vec<Point>> {
    let left = mirrored(&polygon);
    vec![left, polygon]
}

/// All parts of the section in painting order.
pub(super) fn parts(v: &Values, l: &Layout) -> Vec<Part> {
    let mut parts = magazine(v);
    parts.extend(gas(v, l));
    parts.extend(housing(v, l));
    parts.extend(cylinder(v, l));
    parts.extend(head_valve(v, l));
    parts.extend(exhaust(v, l));
    parts.extend(trigger(v, l));
    parts.extend(nose_and_nail(v));
    parts
}

/// The magazine and the arm that joins it to the nose; both end on the barrel.
pub(super) fn magazine(v: &Values) -> Vec<Part> {
    let b = &v.body;
    let centre = [b.magazine_offset, b.magazine_level];
    let circle = |radius| Outline::Circle { centre, radius };
    let arm = rectangle(
        [0.5 * b.nose_width, b.arm_reach],
        [
            b.magazine_level - 0.5 * b.arm_height,
            b.magazine_level + 0.5 * b.arm_height,
        ],
    );
    vec![
        Part {
            name: "magazine",
            material: Material::Housing,
            outlines: vec![
                circle(b.magazine_radius),
                circle((b.magazine_radius - b.magazine_wall).max(0.0)),
            ],
        },
        Part::new("arm of the magazine", Material::Housing, vec![arm]),
    ]
}

/// The gas volumes; the parts are painted over them.
fn gas(v: &Values, l: &Layout) -> Vec<Part> {
    let (b, s) = (&v.body, &l.valve);
    let volume = |name, chamber, polygons| Part::new(name, Material::Gas(chamber), polygons);
    let inner = b.cap_radius - b.cap_wall;
    let handle = rectangle(
        [l.barrel[1], l.handle_end - b.handle_wall],
        [
            b.handle_level - b.handle_radius + b.handle_wall,
            b.handle_level + b.handle_radius - b.handle_wall,
        ],
    );
    let jacket = rectangle(
        [s.seat.min(s.jacket[0]), s.jacket[0]],
        [l.seat + s.jacket[1], l.seat + s.guide],
    );
    let mut supply = both(jacket);
    supply.push(handle);
    if let Some(port) = port(v, l) {
        supply.push(rectangle([s.jacket[0], l.barrel[1]], port));
    }
    let around = rectangle([l.bore + b.sleeve_wall, l.barrel[0]], [l.floor, l.seat + s.jacket[1]]);
    let tube = rectangle(
        [-s.tube_bore, s.tube_bore],
        [l.seat + s.plug_levels[1], l.roof + b.cap_wall],
    );
    let plenum = rectangle([-inner, inner], [l.roof + b.cap_wall, l.top - b.cap_wall]);
    let recess = rectangle([-s.recess[0], s.recess[0]], [l.seat + s.lip, l.seat + s.recess[1]]);
    let lip = rectangle([-s.inner, s.inner], [l.seat, l.seat + s.lip]);
    let cylinder = rectangle([-l.bore, l.bore], [l.piston[0], l.seat]);
    vec![
        volume("supply side", Chamber::Supply, supply),
        volume("return volume", Chamber::Return, both(around)),
        volume(
            "exhaust passage and space under the cap",
            Chamber::Plenum,
            vec![tube, plenum],
        ),
        volume("volume above the piston", Chamber::AbovePiston, vec![cylinder]),
        volume(
            "volume above the piston, open to the exhaust",
            Chamber::AbovePiston,
            vec![lip],
        ),
        volume("exhaust passage", Chamber::AbovePiston, vec![recess]),
        volume(
            "volume below the piston",
            Chamber::BelowPiston,
            vec![rectangle([-l.bore, l.bore], [l.floor.min(l.bumper), l.piston[1]])],
        ),
        volume(
            "volume above the head valve",
            Chamber::AboveValve,
            [
                both(rectangle([s.inner, s.outer], [l.seat + s.height, l.seat + s.stop])),
                both(rectangle(s.pocket, [l.seat + s.pocket_floor, l.seat + s.height])),
            ]
            .concat(),
        ),
    ]
}

/// Heights of the opening from the handle to the space around the head valve; `None` if the two do not meet.
pub(super) fn port(v: &Values, l: &Layout) -> Option<[f64; 2]> {
    let b = &v.body;
    let inner = b.handle_radius - b.handle_wall;
    let low = (l.seat + l.valve.jacket[1]).max(b.handle_level - inner);
    let high = (l.seat + l.valve.guide).min(b.handle_level + inner);
    (high - low > 1e-3).then_some([low, high])
}

/// Barrel with the exhaust tube and the cylinder of the head valve, cap and handle.
fn housing(v: &Values, l: &Layout) -> Vec<Part> {
    let (b, s) = (&v.body, &l.valve);
    let (at, foot) = (|height: f64| l.seat + height, b.nose_height);
    let guide = 0.5 * v.piston.rod_diameter + 0.3e-3;
    let under = l.roof - b.barrel_wall;
    // From the bore of the exhaust tube around its end and along the volume above the ring and the supply space to the
    // floor.
    let inside = vec![
        [s.tube_bore, l.roof],
        [s.tube_bore, at(s.tube)],
        [s.inner, at(s.tube)],
        [s.inner, at(s.stop).min(under)],
        [s.outer, at(s.stop).min(under)],
        [s.outer, at(s.guide)],
        [s.jacket[0], at(s.guide)],
    ];
    let below = vec![
        [s.jacket[0], at(s.jacket[1])],
        [l.barrel[0], at(s.jacket[1])],
        [l.barrel[0], l.floor],
        [guide, l.floor],
        [guide, foot],
        [l.barrel[1], foot],
    ];
    let whole = [inside.clone(), below.clone(), vec![[l.barrel[1], l.roof]]].concat();
    let mut barrel = vec![mirrored(&whole)];
    match port(v, l) {
        None => barrel.push(whole),
        Some([low, high]) => {
            let mut upper = inside;
            upper.extend([[s.jacket[0], high], [l.barrel[1], high], [l.barrel[1], l.roof]]);
            let mut lower = vec![[s.jacket[0], low]];
            lower.extend(below);
            lower.push([l.barrel[1], low]);
            barrel.extend([upper, lower]);
        }
    }
    let (cap, wall) = (b.cap_radius, b.cap_wall);
    let hole = 0.5 * v.exhaust.hole_diameter.min(b.cap_height - 2.0 * wall);
    let [low, high] = [l.exhaust - hole, l.exhaust + hole];
    let (inner, ceiling, deck) = (cap - wall, l.top - wall, l.roof + wall);
    let upper = vec![
        [-cap, high],
        [-cap, l.top],
        [cap, l.top],
        [cap, l.roof],
        [s.tube_bore, l.roof],
        [s.tube_bore, deck],
        [inner, deck],
        [inner, ceiling],
        [-inner, ceiling],
        [-inner, high],
    ];
    let lower = vec![
        [-cap, low],
        [-inner, low],
        [-inner, deck],
        [-s.tube_bore, deck],
        [-s.tube_bore, l.roof],
        [-cap, l.roof],
    ];
    let [x, end] = [l.barrel[1], l.handle_end];
    let [z, radius, tube] = [b.handle_level, b.handle_radius, b.handle_radius - b.handle_wall];
    let hose = l.hose.min(tube);
    let half = |up: f64| {
        vec![
            [x, z + up * radius],
            [end, z + up * radius],
            [end, z + up * hose],
            [end - b.handle_wall, z + up * hose],
            [end - b.handle_wall, z + up * tube],
            [x, z + up * tube],
        ]
    };
    vec![
        Part::new("handle", Material::Housing, vec![half(1.0), half(-1.0)]),
        Part::new("barrel", Material::Housing, barrel),
        Part::new("cap", Material::Housing, vec![upper, lower]),
    ]
}

/// Sleeve with its holes, bumper, piston and rod.
fn cylinder(v: &Values, l: &Layout) -> Vec<Part> {
    let (b, s) = (&v.body, &l.valve);
    let [inner, outer] = [l.bore, l.bore + b.sleeve_wall];
    let collar = s.seat.max(inner + 0.3e-3);
    let sleeve = vec![
        [inner, l.floor],
        [inner, l.seat],
        [collar, l.seat],
        [collar, l.seat - s.collar],
        [outer, l.seat - s.collar],
        [outer, l.floor],
    ];
    let [check, edge] = l.check_hole;
    let [back, foot] = l.return_hole;
    let through = |[low, high]: [f64; 2]| both(rectangle([inner, outer], [low, high]));
    let rod = 0.5 * v.piston.rod_diameter;
    let hole = rod + 0.4e-3;
    let mut parts = vec![Part::new("cylinder sleeve", Material::Mechanism, both(sleeve))];
    if b.sleeve_fit > s.collar {
        parts.push(Part::new(
            "fit of the sleeve",
            Material::Rubber,
            both(rectangle(
                [outer, l.barrel[0]],
                [l.seat - b.sleeve_fit, l.seat - s.collar],
            )),
        ));
    }
    parts.extend([
        Part::new("check-ring holes", Material::Opening, through([edge - check, edge])),
        Part::new("return holes", Material::Opening, through([foot, foot + back])),
        Part::new(
            "bumper",
            Material::Rubber,
            both(rectangle(
                [hole, l.bumper_radius.max(hole + 1e-3)],
                [l.floor.min(l.bumper - 0.5e-3), l.bumper],
            )),
        ),
        Part::new(
            "driver rod",
            Material::Solid,
            vec![rectangle([-rod, rod], [l.rod_tip, l.piston[1]])],
        ),
        Part::new(
            "piston",
            Material::Mechanism,
            vec![rectangle([-l.bore, l.bore], [l.piston[1], l.piston[0]])],
        ),
    ]);
    parts
}

/// Ring of the head valve, plug, seals and spring.
fn head_valve(v: &Values, l: &Layout) -> Vec<Part> {
    let s = &l.valve;
    let at = |r: f64, height: f64| [r, l.seat + height];
    let lip = s.plug.min(s.inner);
    let wall = s.outer - s.inner;
    let (pocket, depth) = (s.pocket, s.pocket_floor);
    let ring = vec![
        at(lip, 0.0),
        at(lip, s.lip),
        at(s.recess[0], s.lip),
        at(s.recess[0], s.recess[1]),
        at(s.inner, s.recess[1]),
        at(s.inner, s.height),
        at(pocket[0], s.height),
        at(pocket[0], depth),
        at(pocket[1], depth),
        at(pocket[1], s.height),
        at(s.outer, s.height),
        at(s.outer, -v.head_valve.intake_lap),
        at(s.seat, -v.head_valve.intake_lap),
        at(s.seat, 0.0),
    ];
    // Cone of the plug below the sealing edge, at the seat angle to the axis.
    let depth_of_cone = 0.09 * s.height;
    let cone = (depth_of_cone * v.head_valve.exhaust_angle.tan()).min(0.6 * s.plug);
    let plug = vec![
        at(-s.plug + cone, s.plug_levels[0] - depth_of_cone),
        at(s.plug - cone, s.plug_levels[0] - depth_of_cone),
        at(s.plug, s.plug_levels[0]),
        at(s.plug, s.plug_levels[1]),
        at(0.12 * s.plug, s.plug_levels[1]),
        [0.12 * s.plug, l.top - v.body.cap_wall],
        [-0.12 * s.plug, l.top - v.body.cap_wall],
        at(-0.12 * s.plug, s.plug_levels[1]),
        at(-s.plug, s.plug_levels[1]),
        at(-s.plug, s.plug_levels[0]),
    ];
    let seal = 0.07 * s.height;
    let o_ring = |r: f64, z: f64| Outline::Circle {
        centre: at(r, z),
        radius: seal,
    };
    let wire = 0.08 * wall;
    let middle = 0.5 * (pocket[0] + pocket[1]);
    let turn = |side: f64, k: f64| Outline::Circle {
        centre: at(
            side * (middle + (if k as i32 % 2 == 0 { 0.07 } else { -0.07 }) * wall),
            depth + wire + k / 4.0 * (s.stop - depth - 2.0 * wire),
        ),
        radius: wire,
    };
    let turns = (0..5).flat_map(|k| [turn(1.0, f64::from(k)), turn(-1.0, f64::from(k))]);
    vec![
        Part::new("plug of the exhaust", Material::Steel, vec![plug]),
        Part::new("ring of the head valve", Material::Mechanism, both(ring)),
        Part {
            name: "seals of the head valve",
            material: Material::Rubber,
            outlines: [(s.inner + seal, 0.82), (s.outer - seal, 0.64)]
                .iter()
                .flat_map(|(r, z)| [o_ring(*r, z * s.height), o_ring(-r, z * s.height)])
                .collect(),
        },
        Part {
            name: "closing spring of the head valve",
            material: Material::Solid,
            outlines: turns.collect(),
        },
    ]
}

/// Left end of parts fitted outside the exhaust holes: the side of the cap.
fn outlet(v: &Values) -> f64 {
    -v.body.cap_radius
}

/// Wall thickness of fittings and mufflers \[m\]; schematic.
const FITTED_WALL: f64 = 2e-3;

/// A pipe fitting or a muffler outside the exhaust holes.
fn exhaust(v: &Values, l: &Layout) -> Vec<Part> {
    let (start, z) = (outlet(v), l.exhaust);
    let walls = |[from, to]: [f64; 2], diameter: f64| {
        let [inner, outer] = [0.5 * diameter, 0.5 * diameter + FITTED_WALL];
        [
            rectangle([from, to], [z + inner, z + outer]),
            rectangle([from, to], [z - outer, z - inner]),
        ]
    };
    let fitting = &v.exhaust.fitting;
    let muffler = &v.exhaust.muffler;
    let mut parts = Vec::new();
    if fitting.kind == FittingKind::Pipe {
        let pipe = walls([start - fitting.length, start], fitting.diameter);
        parts.push(Part::new("pipe fitting", Material::Steel, pipe.to_vec()));
    }
    match muffler.kind {
        MufflerKind::Chamber => {
            let end = start - muffler.chamber_length;
            let out = 0.5 * muffler.chamber_diameter + FITTED_WALL;
            let tail = (0.5 * muffler.tail_diameter).min(out);
            let plate = |up: f64| rectangle([end - FITTED_WALL, end], [z + up * tail, z + up * out]);
            let mut chamber = walls([end, start], muffler.chamber_diameter).to_vec();
            chamber.extend([plate(1.0), plate(-1.0)]);
            let tail = walls([end - muffler.tail_length, end], muffler.tail_diameter);
            parts.push(Part::new("chamber of the muffler", Material::Steel, chamber));
            parts.push(Part::new("tail pipe of the muffler", Material::Steel, tail.to_vec()));
            if muffler.lining_thickness > 0.0 {
                let lined = muffler.tail_diameter + 2.0 * FITTED_WALL;
                let [inner, outer] = [0.5 * lined, 0.5 * lined + muffler.lining_thickness];
                let across = [end - muffler.tail_length, end - FITTED_WALL];
                let lining = vec![
                    rectangle(across, [z + inner, z + outer]),
                    rectangle(across, [z - outer, z - inner]),
                ];
                parts.push(Part::new("lining of the tail pipe", Material::Rubber, lining));
            }
        }
        MufflerKind::InsertionLoss | MufflerKind::None => {}
    }
    parts
}

/// The trigger valve below the handle, with its vent drawn as a round hole of the same area.
fn trigger(v: &Values, l: &Layout) -> Vec<Part> {
    let [.., [x, z]] = l.channel;
    let half = (0.7 * v.trigger.channel_diameter).max(5e-3);
    let depth = 3.0 * half;
    let vent = 0.5
        * (4.0 * v.trigger.vent_area / std::f64::consts::PI)
            .sqrt()
            .min(1.6 * half);
    let middle = z - 0.6 * depth;
    vec![
        Part::new(
            "trigger valve",
            Material::Mechanism,
            vec![rectangle([x - half, x + half], [z - depth, z])],
        ),
        Part::new(
            "vent of the trigger valve",
            Material::Opening,
            vec![rectangle([x, x + half], [middle - vent, middle + vent])],
        ),
    ]
}

/// Nose, guard, and the nail before the shot.
fn nose_and_nail(v: &Values) -> Vec<Part> {
    let (b, nail) = (&v.body, &v.nail);
    let half = 0.5 * b.nose_width;
    let wall = rectangle([half - b.nose_wall, half], [0.0, b.nose_height + b.nose_overlap]);
    let [head, shank] = [0.5 * nail.head_diameter, 0.5 * nail.diameter];
    let [top, tip] = [nail.feed_height, nail.feed_height - nail.length];
    let neck = top - nail.head_thickness;
    let taper = (tip + 1.5 * nail.diameter).min(neck);
    let outline = vec![
        [-head, top],
        [head, top],
        [head, neck],
        [shank, neck],
        [shank, taper],
        [0.0, tip],
        [-shank, taper],
        [-shank, neck],
        [-head, neck],
    ];
    let guard = rectangle([-half - 5e-3, -half - 2e-3], [0.0, guard_top(v)]);
    vec![
        Part::new("nose", Material::Steel, both(wall)),
        Part::new("guard, pressed onto the wood", Material::Steel, vec![guard]),
        Part::new("nail", Material::Solid, vec![outline]),
    ]
}

/// Top of the guard on the wood \[m\]; schematic.
pub(super) fn guard_top(v: &Values) -> f64 {
    v.contacts.guard_travel + 12e-3
}

/// The axis, and the opposite end of the movement of piston and rod.
pub(super) fn lines(v: &Values, l: &Layout, bottom: f64) -> Vec<Line> {
    let rod = 0.5 * v.piston.rod_diameter;
    let [upper, lower] = l.piston.map(|level| level - v.piston.stroke);
    let tip = -v.piston.rod_protrusion;
    let line = |style, points| Line { style, points };
    let [a, b, c] = l.channel;
    vec![
        line(LineStyle::Centre, vec![[0.0, bottom], [0.0, l.top + 6e-3]]),
        line(
            LineStyle::Phantom,
            vec![
                [-rod, lower],
                [-l.bore, lower],
                [-l.bore, upper],
                [l.bore, upper],
                [l.bore, lower],
                [rod, lower],
                [rod, tip],
                [-rod, tip],
                [-rod, lower],
            ],
        ),
        line(LineStyle::Hidden, vec![[a[0], l.seat + l.valve.stop], a, b, c]),
    ]
}
