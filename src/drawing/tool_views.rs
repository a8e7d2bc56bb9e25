//! The section through the tool and its two details: the head valve, and the nose with nail and rod.

use super::layout::Layout;
use super::mechanism::{guard_top, lines, parts, port};
use super::shape::{Annotation, Bounds, Line, LineStyle, Material, Part, Side, View, rectangle};
use crate::design::{FittingKind, MufflerKind, Values};

use Side::{Left, Right};

/// Depth of the wood shown below the nose \[m\], if the block is thicker.
const WOOD: f64 = 40e-3;

/// The section through the tool on the wood, before the shot.
pub(super) fn section(v: &Values, l: &Layout) -> View {
    let depth = v.workpiece.thickness.min(WOOD.max(v.piston.rod_protrusion + 15e-3));
    let mut view = View {
        name: "section",
        title: "Section through the tool, at rest on the wood".to_owned(),
        parts: parts(v, l),
        lines: lines(v, l, -depth),
        annotations: section_annotations(v, l),
        window: None,
        details: vec![("X", valve_window(v, l)), ("Y", nose_window(v))],
    };
    let reach = Bounds::of(
        view.parts
            .iter()
            .flat_map(|part| &part.outlines)
            .flat_map(super::shape::corners),
    );
    let wide = reach.map_or([-0.05, 0.05], |bounds| [bounds.low[0], bounds.high[0]]);
    // The guard of the nose and the magazine determine how much of the wood is shown.
    let across = [wide[0].max(-0.06), wide[1].min(0.13)];
    let (wood, edges) = wood(v, across, depth);
    view.parts.splice(0..0, wood);
    view.lines.extend(edges);
    view
}

/// The wood between two abscissas down to a depth, with its board and break lines.
fn wood(v: &Values, [left, right]: [f64; 2], depth: f64) -> (Vec<Part>, Vec<Line>) {
    let board = v.workpiece.board.thickness.min(depth);
    let mut parts = vec![Part::new(
        "workpiece",
        Material::Wood,
        vec![rectangle([left, right], [-depth, -board])],
    )];
    if board > 0.0 {
        let name = "board on the workpiece";
        parts.push(Part::new(
            name,
            Material::Plywood,
            vec![rectangle([left, right], [-board, 0.0])],
        ));
    }
    let broken = |points| Line {
        style: LineStyle::Break,
        points,
    };
    let zigzag = |x: f64| {
        let middle = -0.5 * depth;
        vec![
            [x, 2e-3],
            [x, middle + 4e-3],
            [x - 3e-3, middle + 1.5e-3],
            [x + 3e-3, middle - 1.5e-3],
            [x, middle - 4e-3],
            [x, -depth - 2e-3],
        ]
    };
    let mut edges = vec![broken(zigzag(left)), broken(zigzag(right))];
    if depth < v.workpiece.thickness {
        edges.push(broken(vec![[left, -depth], [right, -depth]]));
    }
    (parts, edges)
}

fn section_annotations(v: &Values, l: &Layout) -> Vec<Annotation> {
    let (b, s) = (&v.body, &l.valve);
    let [piston_top, piston_foot] = l.piston;
    let outside = l.barrel[1];
    let middle = 0.5 * (b.nose_height + l.roof);
    let lane = |k: f64| -(outside + 7e-3 + 9e-3 * k);
    let check = l.check_hole[1];
    let hole = |[low, high]: [f64; 2], side: f64| {
        let [a, c] = [side * l.bore, side * (l.bore + b.sleeve_wall)];
        rectangle([a.min(c), a.max(c)], [low, high])
    };
    let back = [l.return_hole[1], l.return_hole[1] + l.return_hole[0]];
    let rod = 0.5 * v.piston.rod_diameter;
    let gap = 0.5 * (l.bore + b.sleeve_wall + l.barrel[0]);
    let [start, corner, end] = l.channel;
    let inner = b.handle_radius - b.handle_wall;
    let reach = v.piston.stroke;
    let mut annotations = vec![
        Annotation::across(
            "piston.bore",
            Right,
            [-l.bore, l.bore],
            piston_foot - 0.28 * reach,
            [piston_foot - 0.28 * reach; 2],
        ),
        Annotation::upright(
            "piston.stroke",
            Left,
            [piston_foot, piston_foot - reach],
            lane(1.6),
            [-l.bore, -l.bore],
        ),
        Annotation::across(
            "piston.rod_diameter",
            Right,
            [-rod, rod],
            piston_foot - 0.12 * reach,
            [piston_foot - 0.12 * reach; 2],
        ),
        Annotation::upright(
            "piston.rod_protrusion",
            Left,
            [0.0, -v.piston.rod_protrusion],
            -(0.5 * b.nose_width + 12e-3),
            [-0.5 * b.nose_width, -rod],
        ),
        Annotation::upright(
            "chambers.check_hole_position",
            Left,
            [piston_top, check],
            lane(0.3),
            [-l.bore, -l.bore],
        ),
        Annotation::area(
            "chambers.check_hole_area",
            Left,
            [-(l.bore + 0.5 * b.sleeve_wall), check - 0.5 * l.check_hole[0]],
            hole([check - l.check_hole[0], check], -1.0),
        ),
        Annotation::area(
            "chambers.return_hole_area",
            Left,
            [-(l.bore + 0.5 * b.sleeve_wall), 0.5 * (back[0] + back[1])],
            hole(back, -1.0),
        ),
        Annotation::dot("chambers.leak_area", Left, [-rod, b.nose_height + 0.7 * b.barrel_wall]),
        Annotation::area(
            "chambers.above_piston",
            Left,
            [-0.55 * l.bore, 0.5 * (piston_top + l.seat)],
            rectangle([-l.bore, l.bore], [piston_top, l.seat]),
        ),
        Annotation::area(
            "chambers.below_piston",
            Right,
            [0.5 * (l.bumper_radius + l.bore), 0.5 * (l.floor + l.bumper)],
            rectangle([l.bumper_radius, l.bore], [l.floor.min(l.bumper), l.bumper]),
        ),
        Annotation::area(
            "chambers.return_volume",
            Right,
            [gap, middle - 0.1 * b.barrel_height],
            rectangle([l.bore + b.sleeve_wall, l.barrel[0]], [l.floor, l.seat + s.jacket[1]]),
        ),
        Annotation::area(
            "chambers.supply_volume",
            Right,
            [outside + 0.62 * (l.handle_end - outside), b.handle_level + 0.35 * inner],
            rectangle(
                [outside, l.handle_end - b.handle_wall],
                [b.handle_level - inner, b.handle_level + inner],
            ),
        ),
        Annotation::dot(
            "supply.pressure",
            Right,
            [outside + 0.8 * (l.handle_end - outside), b.handle_level - 0.3 * inner],
        ),
        Annotation::dot(
            "supply.hose_area",
            Right,
            [l.handle_end - 0.5 * b.handle_wall, b.handle_level],
        ),
        Annotation::path(
            "trigger.channel_length",
            Right,
            [start[0] + 0.6 * (corner[0] - start[0]), corner[1]],
            vec![[start[0], l.seat + s.stop], start, corner, end],
        ),
        Annotation::dot(
            "trigger.channel_diameter",
            Right,
            [corner[0], 0.5 * (corner[1] + end[1])],
        ),
        vent(v, l),
        Annotation::dot("trigger.fill_area", Right, [end[0], end[1] - 0.25 * vent_depth(v)]),
        Annotation::dot(
            "exhaust.hole_diameter",
            Left,
            [-(b.cap_radius - 0.5 * b.cap_wall), l.exhaust],
        ),
        Annotation::dot(
            "exhaust.plenum.volume",
            Left,
            [-0.5 * b.cap_radius, l.top - 1.6 * b.cap_wall],
        ),
        Annotation::dot("exhaust.plenum.neck_length", Left, [-b.cap_radius, l.exhaust]),
        Annotation::upright(
            "nail.feed_height",
            Left,
            [0.0, v.nail.feed_height],
            -(0.5 * b.nose_width + 12e-3),
            [-0.5 * b.nose_width, -0.5 * v.nail.head_diameter],
        ),
        Annotation::dot("wood.species", Right, [0.03, -6e-3]),
        Annotation::dot(
            "head_valve.lift",
            Left,
            [-0.5 * (s.inner + s.outer), l.seat + s.height + 0.5 * v.head_valve.lift],
        ),
    ];
    annotations.extend(outlet(v, l));
    if port(v, l).is_none() {
        annotations.retain(|annotation| annotation.key != "trigger.fill_area");
    }
    annotations
}

fn vent_depth(v: &Values) -> f64 {
    3.0 * (0.7 * v.trigger.channel_diameter).max(5e-3)
}

fn vent(v: &Values, l: &Layout) -> Annotation {
    let [.., [x, z]] = l.channel;
    let depth = vent_depth(v);
    Annotation::dot("trigger.vent_area", Right, [x + depth / 6.0, z - 0.6 * depth])
}

/// Keys of fittings on the exhaust holes.
fn outlet(v: &Values, l: &Layout) -> Vec<Annotation> {
    let (start, z) = (-v.body.cap_radius, l.exhaust);
    let fitting = &v.exhaust.fitting;
    let muffler = &v.exhaust.muffler;
    let mut found = Vec::new();
    if fitting.kind == FittingKind::Pipe {
        let (end, half) = (start - fitting.length, 0.5 * fitting.diameter);
        let below = z - half - 8e-3;
        found.push(Annotation::across(
            "exhaust.fitting.length",
            Left,
            [end, start],
            below,
            [z - half; 2],
        ));
        let x = start - 0.7 * fitting.length;
        found.push(Annotation::upright(
            "exhaust.fitting.diameter",
            Left,
            [z - half, z + half],
            x,
            [x; 2],
        ));
    }
    match muffler.kind {
        MufflerKind::Chamber => {
            let end = start - muffler.chamber_length;
            let [chamber, tail] = [0.5 * muffler.chamber_diameter, 0.5 * muffler.tail_diameter];
            let (above, below) = (z + chamber + 9e-3, z - chamber - 9e-3);
            let x = start - 0.4 * muffler.chamber_length;
            let out = end - 0.6 * muffler.tail_length;
            found.extend([
                Annotation::across(
                    "exhaust.muffler.chamber_length",
                    Left,
                    [end, start],
                    above,
                    [z + chamber; 2],
                ),
                Annotation::upright(
                    "exhaust.muffler.chamber_diameter",
                    Left,
                    [z - chamber, z + chamber],
                    x,
                    [x; 2],
                ),
                Annotation::across(
                    "exhaust.muffler.tail_length",
                    Left,
                    [end - muffler.tail_length, end],
                    below,
                    [z - tail; 2],
                ),
                Annotation::upright(
                    "exhaust.muffler.tail_diameter",
                    Left,
                    [z - tail, z + tail],
                    out,
                    [out; 2],
                ),
                Annotation::dot("exhaust.muffler.flow_area", Left, [end, z]),
            ]);
            if muffler.lining_thickness > 0.0 {
                let [inner, outer] = [tail + 2e-3, tail + 2e-3 + muffler.lining_thickness];
                let x = end - 0.3 * muffler.tail_length;
                found.push(Annotation::upright(
                    "exhaust.muffler.lining_thickness",
                    Left,
                    [z + inner, z + outer],
                    x,
                    [x; 2],
                ));
            }
        }
        MufflerKind::InsertionLoss => found.push(Annotation::dot("exhaust.muffler.flow_area", Left, [start, z])),
        MufflerKind::None => {}
    }
    found
}

/// Window of the head valve's detail: the right half of the ring with its seat and stop.
fn valve_window(v: &Values, l: &Layout) -> Bounds {
    let s = &l.valve;
    let wall = s.outer - s.inner;
    Bounds {
        low: [
            s.plug.min(s.inner) - (0.5 * wall).max(0.3 * s.height).max(4e-3),
            l.seat - s.collar.max(v.head_valve.intake_lap + 2.5e-3) - 1.5e-3,
        ],
        high: [s.outer.max(s.jacket[0]) + 2.5e-3, l.seat + s.stop + 2.5e-3],
    }
}

/// The head valve on its seat, enlarged.
pub(super) fn head_valve(v: &Values, l: &Layout) -> View {
    let s = &l.valve;
    let window = valve_window(v, l);
    let at = |height: f64| l.seat + height;
    let valve = &v.head_valve;
    let [left, right] = [window.low[0], window.high[0]];
    let lip = s.plug.min(s.inner);
    let stop = at(s.stop);
    let wall = s.outer - s.inner;
    let skirt = 0.5 * (s.seat + s.outer);
    let beside = s.outer + 0.45 * (right - s.outer);
    let cone = 0.09 * s.height;
    let annotations = vec![
        Annotation::upright(
            "head_valve.lift",
            Right,
            [at(s.height), stop],
            s.inner + 0.25 * wall,
            [s.inner + 0.25 * wall; 2],
        ),
        Annotation::diameter(
            "head_valve.inner_diameter",
            Left,
            left,
            s.inner,
            at(0.92 * s.height),
            at(0.92 * s.height),
        ),
        Annotation::diameter(
            "head_valve.exhaust_seat_diameter",
            Left,
            left,
            s.plug,
            at(0.5 * (s.plug_levels[0] + s.plug_levels[1])),
            at(s.plug_levels[0]),
        ),
        Annotation::diameter(
            "head_valve.seat_diameter",
            Left,
            left,
            s.seat,
            at(-valve.intake_lap) - 1.0e-3,
            at(0.0),
        ),
        Annotation::diameter(
            "head_valve.outer_diameter",
            Left,
            left,
            s.outer,
            window.low[1] + 1.0e-3,
            at(-valve.intake_lap),
        ),
        Annotation::upright(
            "head_valve.intake_lap",
            Right,
            [at(-valve.intake_lap), at(0.0)],
            beside,
            [s.outer, s.seat],
        ),
        Annotation::upright(
            "head_valve.exhaust_lap",
            Left,
            [at(s.lip), at(s.plug_levels[0])],
            lip - 0.22 * wall,
            [lip, s.plug],
        ),
        Annotation::path(
            "head_valve.intake_angle",
            Right,
            [skirt, at(-valve.intake_lap)],
            vec![
                [s.seat, at(-valve.intake_lap) - 1.2e-3],
                [s.seat, at(-valve.intake_lap)],
                [
                    s.seat + 1.2e-3 * valve.intake_angle.sin(),
                    at(-valve.intake_lap) - 1.2e-3 * valve.intake_angle.cos(),
                ],
            ],
        ),
        Annotation::path(
            "head_valve.exhaust_angle",
            Left,
            [
                s.plug - 0.5 * cone * valve.exhaust_angle.tan().min(3.0),
                at(s.plug_levels[0] - 0.5 * cone),
            ],
            vec![
                [s.plug, at(s.plug_levels[0]) - cone],
                [s.plug, at(s.plug_levels[0])],
                [
                    s.plug - cone * valve.exhaust_angle.tan().min(3.0),
                    at(s.plug_levels[0]) - cone,
                ],
            ],
        ),
        Annotation::dot(
            "head_valve.spring_preload",
            Right,
            [s.inner + 0.65 * wall, at(s.height)],
        ),
        Annotation::area(
            "chambers.above_valve",
            Right,
            [s.outer - 0.08 * wall, at(s.height + 0.5 * valve.lift)],
            rectangle([s.inner, s.outer], [at(s.height), stop]),
        ),
        Annotation::dot("head_valve.mass", Right, [s.outer - 0.12 * wall, at(0.36 * s.height)]),
    ];
    View {
        name: "valve",
        title: "Detail X: head valve on its seat".to_owned(),
        parts: parts(v, l),
        lines: Vec::new(),
        annotations,
        window: Some(window),
        details: Vec::new(),
    }
}

/// Window of the nose's detail: nail and rod, from the wood to above the tip of the rod.
fn nose_window(v: &Values) -> Bounds {
    let half = 0.5 * v.body.nose_width;
    let deep = (v.piston.rod_protrusion + 6e-3).max(10e-3);
    let high = v.nail.feed_height.max(v.piston.stroke - v.piston.rod_protrusion) + 8e-3;
    Bounds {
        low: [-half - 19e-3, -deep],
        high: [half + 12e-3, high.max(guard_top(v) + 3e-3)],
    }
}

/// Nail and nose before the shot, enlarged.
pub(super) fn nose(v: &Values, l: &Layout) -> View {
    let (b, nail) = (&v.body, &v.nail);
    let window = nose_window(v);
    let half = 0.5 * b.nose_width;
    let [head, shank] = [0.5 * nail.head_diameter, 0.5 * nail.diameter];
    let [top, tip] = [nail.feed_height, nail.feed_height - nail.length];
    let rod = 0.5 * v.piston.rod_diameter;
    let middle = tip + 0.45 * nail.length;
    let guard = guard_top(v);
    let annotations = vec![
        Annotation::upright("nail.length", Right, [tip, top], half + 4e-3, [0.0, head]),
        Annotation::upright("nail.feed_height", Left, [0.0, top], -half - 10e-3, [-half, -head]),
        Annotation::across("nail.diameter", Right, [-shank, shank], middle, [middle; 2]),
        Annotation::across("nail.head_diameter", Right, [-head, head], top + 3e-3, [top, top]),
        Annotation::upright(
            "nail.head_thickness",
            Right,
            [top - nail.head_thickness, top],
            head + 1.2e-3,
            [head, head],
        ),
        Annotation::across(
            "piston.rod_diameter",
            Left,
            [-rod, rod],
            l.rod_tip + 3e-3,
            [l.rod_tip + 3e-3; 2],
        ),
        Annotation::upright(
            "piston.rod_protrusion",
            Left,
            [0.0, -v.piston.rod_protrusion],
            -half - 14e-3,
            [-half, -rod],
        ),
        Annotation::across(
            "body.nose_wall",
            Right,
            [half - b.nose_wall, half],
            tip + 0.7 * nail.length,
            [tip + 0.7 * nail.length; 2],
        ),
        Annotation::across("body.nose_width", Right, [-half, half], -4.5e-3, [0.0; 2]),
        Annotation::upright(
            "contacts.guard_travel",
            Left,
            [guard - v.contacts.guard_travel, guard],
            -half - 7.5e-3,
            [-half - 5e-3; 2],
        ),
    ];
    let (wood, _) = wood(v, [window.low[0], window.high[0]], -window.low[1] + 1e-3);
    let lowered = guard - v.contacts.guard_travel;
    let mut lines = lines(v, l, window.low[1]);
    lines.push(Line {
        style: LineStyle::Phantom,
        points: vec![[-half - 5e-3, lowered], [-half - 2e-3, lowered]],
    });
    View {
        name: "nose",
        title: "Detail Y: nail, rod and nose before the shot".to_owned(),
        parts: [wood, parts(v, l)].concat(),
        lines,
        annotations,
        window: Some(window),
        details: Vec::new(),
    }
}
