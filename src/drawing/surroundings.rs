//! Views of bodies outside the nailing cycle: the vibrating housing, and the workpiece with its support.

use super::mechanism::magazine;
use super::shape::{Annotation, Line, LineStyle, Material, Part, Side, View, mirrored, rectangle};
use crate::design::{Body, Values};
use crate::model::supports;

use Side::{Left, Right};

/// The parts of the housing as in the mesh of `meshes/geo/tool.geo`, in the plane of the handle.
pub fn housing_parts(v: &Values) -> Vec<Part> {
    let b = &v.body;
    let bore = 0.5 * v.piston.bore;
    let outer = b.barrel_radius(bore);
    let [foot, roof] = [b.nose_height, b.nose_height + b.barrel_height];
    let hollow = |radius: f64, [low, high]: [f64; 2], wall: f64| {
        let inner = radius - wall;
        vec![
            rectangle([-radius, radius], [low, high]),
            rectangle([-inner, inner], [low + wall, high - wall]),
        ]
    };
    let [x, end] = [outer - 0.5 * b.barrel_wall, outer - 4e-3 + b.handle_length];
    let handle =
        |radius: f64, wall: f64| rectangle([x, end - wall], [b.handle_level - radius, b.handle_level + radius]);
    let half = 0.5 * b.nose_width;
    let floor = foot + b.barrel_wall;
    let sleeve = rectangle([bore, bore + b.sleeve_wall], [floor, floor + b.sleeve_height]);
    let nose = rectangle([half - b.nose_wall, half], [0.0, b.nose_height + b.nose_overlap]);
    let mut parts = magazine(v);
    parts.extend([
        Part::new(
            "handle",
            Material::Housing,
            vec![
                handle(b.handle_radius, 0.0),
                handle(b.handle_radius - b.handle_wall, b.handle_wall),
            ],
        ),
        Part::new("barrel", Material::Housing, hollow(outer, [foot, roof], b.barrel_wall)),
        Part::new(
            "cap",
            Material::Housing,
            hollow(b.cap_radius, [roof, roof + b.cap_height], b.cap_wall),
        ),
        Part::new("cylinder sleeve", Material::Mechanism, vec![mirrored(&sleeve), sleeve]),
        Part::new("nose", Material::Steel, vec![mirrored(&nose), nose]),
    ]);
    parts
}

/// The housing.
pub(super) fn housing(v: &Values) -> View {
    let b = &v.body;
    let outer = b.barrel_radius(0.5 * v.piston.bore);
    let top = b.nose_height + b.barrel_height + b.cap_height;
    View {
        name: "housing",
        title: "Housing, as it vibrates".to_owned(),
        parts: housing_parts(v),
        lines: vec![
            Line {
                style: LineStyle::Centre,
                points: vec![[0.0, -6e-3], [0.0, top + 6e-3]],
            },
            Line {
                style: LineStyle::Centre,
                points: vec![[0.0, b.handle_level], [outer + b.handle_length + 4e-3, b.handle_level]],
            },
        ],
        annotations: housing_annotations(b, 0.5 * v.piston.bore),
        window: None,
        details: Vec::new(),
    }
}

fn housing_annotations(b: &Body, bore: f64) -> Vec<Annotation> {
    let outer = b.barrel_radius(bore);
    let [foot, roof] = [b.nose_height, b.nose_height + b.barrel_height];
    let (top, floor) = (roof + b.cap_height, foot + b.barrel_wall);
    let end = outer - 4e-3 + b.handle_length;
    let sleeve = bore + b.sleeve_wall;
    let seat = floor + b.sleeve_height;
    let half = 0.5 * b.nose_width;
    let lane = |k: f64| -(outer.max(b.cap_radius) + 8e-3 + 10e-3 * k);
    let [mx, mz] = [b.magazine_offset, b.magazine_level];
    let low = 0.3 * b.sleeve_height + floor;
    let grip = outer + 0.7 * (end - outer);
    let inner_grip = b.handle_radius - b.handle_wall;
    vec![
        Annotation::upright("body.cap_height", Left, [roof, top], lane(0.0), [-b.cap_radius; 2]),
        Annotation::across("body.cap_radius", Right, [0.0, b.cap_radius], top + 9e-3, [top; 2]),
        Annotation::across(
            "body.cap_wall",
            Left,
            [-b.cap_radius, -b.cap_radius + b.cap_wall],
            0.5 * (roof + top),
            [0.5 * (roof + top); 2],
        ),
        Annotation::upright("body.barrel_height", Left, [foot, roof], lane(1.0), [-outer; 2]),
        Annotation::across(
            "body.barrel_wall",
            Left,
            [-outer, -outer + b.barrel_wall],
            low + 0.52 * b.sleeve_height,
            [low + 0.52 * b.sleeve_height; 2],
        ),
        Annotation::upright("body.sleeve_height", Left, [floor, seat], lane(0.0), [-bore; 2]),
        Annotation::across("body.sleeve_wall", Left, [-sleeve, -bore], low, [low; 2]),
        Annotation::across(
            "body.sleeve_gap",
            Left,
            [-sleeve - b.sleeve_gap, -sleeve],
            low + 0.26 * b.sleeve_height,
            [low + 0.26 * b.sleeve_height; 2],
        ),
        Annotation::upright(
            "body.sleeve_fit",
            Right,
            [seat - b.sleeve_fit, seat],
            0.5 * bore,
            [sleeve; 2],
        ),
        Annotation::upright("body.nose_height", Left, [0.0, foot], lane(0.0), [-half, -outer]),
        Annotation::across("body.nose_width", Left, [-half, half], -9e-3, [0.0; 2]),
        Annotation::across(
            "body.nose_wall",
            Left,
            [-half, -half + b.nose_wall],
            0.3 * foot,
            [0.3 * foot; 2],
        ),
        Annotation::upright(
            "body.nose_overlap",
            Left,
            [foot, foot + b.nose_overlap],
            -half - 6e-3,
            [-half; 2],
        ),
        Annotation::across(
            "body.handle_length",
            Right,
            [outer - 4e-3, end],
            b.handle_level + b.handle_radius + 10e-3,
            [b.handle_level + b.handle_radius; 2],
        ),
        Annotation::upright(
            "body.handle_radius",
            Right,
            [b.handle_level, b.handle_level + b.handle_radius],
            grip,
            [grip; 2],
        ),
        Annotation::upright(
            "body.handle_wall",
            Right,
            [b.handle_level - b.handle_radius, b.handle_level - inner_grip],
            outer + 0.45 * (end - outer),
            [outer + 0.45 * (end - outer); 2],
        ),
        Annotation::upright(
            "body.handle_level",
            Right,
            [0.0, b.handle_level],
            end + 8e-3,
            [half, end],
        ),
        Annotation::across("body.magazine_offset", Right, [0.0, mx], -18e-3, [0.0, mz]),
        Annotation::upright(
            "body.magazine_level",
            Right,
            [0.0, mz],
            mx + b.magazine_radius + 9e-3,
            [half, mx],
        ),
        Annotation::across("body.magazine_radius", Right, [mx, mx + b.magazine_radius], mz, [mz; 2]),
        Annotation::upright(
            "body.magazine_wall",
            Right,
            [mz - b.magazine_radius, mz - b.magazine_radius + b.magazine_wall],
            mx,
            [mx; 2],
        ),
        Annotation::dot(
            "body.magazine_height",
            Right,
            [mx + 0.5 * b.magazine_radius, mz + 0.5 * b.magazine_radius],
        ),
        Annotation::upright(
            "body.arm_height",
            Right,
            [mz - 0.5 * b.arm_height, mz + 0.5 * b.arm_height],
            0.5 * (half + b.arm_reach),
            [0.5 * (half + b.arm_reach); 2],
        ),
        Annotation::across(
            "body.arm_reach",
            Right,
            [0.0, b.arm_reach],
            mz - 0.5 * b.arm_height - 6e-3,
            [mz - 0.5 * b.arm_height; 2],
        ),
        Annotation::dot("body.arm_depth", Right, [half + 0.2 * (b.arm_reach - half), mz]),
        Annotation::dot("body.nose_depth", Left, [-half + 0.5 * b.nose_wall, 0.7 * foot]),
    ]
}

/// The workpiece on or in its support, seen along its width.
pub(super) fn support(v: &Values) -> View {
    let w = &v.workpiece;
    let half = 0.5 * w.length;
    let top = w.thickness;
    let board = w.board.thickness;
    let block = Part::new(
        "workpiece",
        Material::Wood,
        vec![rectangle([-half, half], [0.0, top - board])],
    );
    let nail = v.nail.offset_along;
    let mut view = View {
        name: "support",
        title: format!("Workpiece and support: {}", v.support.kind.as_str()),
        parts: Vec::new(),
        lines: vec![Line {
            style: LineStyle::Centre,
            points: vec![[nail, -0.02], [nail, top + 0.04]],
        }],
        annotations: vec![
            Annotation::across("workpiece.length", Left, [-half, half], top + 0.06, [top; 2]),
            Annotation::upright("workpiece.thickness", Right, [0.0, top], half + 0.03, [half; 2]),
            Annotation::dot("workpiece.width", Right, [0.4 * half, 0.5 * top]),
        ],
        window: None,
        details: Vec::new(),
    };
    if nail != 0.0 {
        let offset = Annotation::across("nail.offset_along", Left, [0.0, nail], top + 0.03, [top; 2]);
        view.annotations.push(offset);
    }
    supports::of(v).draw(&mut view);
    view.parts.push(block);
    if board > 0.0 {
        let upper = rectangle([-half, half], [top - board, top]);
        view.parts
            .push(Part::new("board on the workpiece", Material::Plywood, vec![upper]));
        let x = -half - 0.02;
        let dimension = Annotation::upright("workpiece.board.thickness", Left, [top - board, top], x, [-half; 2]);
        view.annotations.push(dimension);
    }
    view
}
