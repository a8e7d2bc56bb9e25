//! What must hold between the quantities of a design.
//!
//! Each rule reads plain values, so that a design changed by a program can be checked as well as a file.

use nailnoise_acoustics::muffler::plane_wave_limit;

use super::conflict::{Conflict, SAMPLES, SPRING_LIMIT};
use super::groups::*;

impl Values {
    /// The first conflict between the values, if there is one.
    ///
    /// A loaded design has none; a program that changes values may ask again.
    pub fn conflict(&self) -> Option<Conflict> {
        nail(self)
            .or_else(|| tool(self))
            .or_else(|| exhaust(self))
            .or_else(|| friction("piston.friction", &self.piston.friction))
            .or_else(|| friction("head_valve.friction", &self.head_valve.friction))
            .or_else(|| seated(self))
            .or_else(|| nose(self))
            .or_else(|| body(self))
            .or_else(|| support(self))
            .or_else(|| {
                let (body, key) = self.not_carried()?;
                Some(Conflict::NotCarried { body, key })
            })
            .or_else(|| elastic("wood.elastic", &self.wood.elastic.axes()))
            .or_else(|| analysis(self))
    }
}

/// Conflict unless `value` is below `limit`.
fn below(
    (small, value): (&'static str, f64),
    (large, limit): (&'static str, f64),
    because: &'static str,
) -> Option<Conflict> {
    (value >= limit).then_some(Conflict::Order {
        small,
        value,
        large,
        limit,
        strict: true,
        because,
    })
}

/// Conflict unless `value` is at most `limit`.
fn at_most(
    (small, value): (&'static str, f64),
    (large, limit): (&'static str, f64),
    because: &'static str,
) -> Option<Conflict> {
    (value > limit).then_some(Conflict::Order {
        small,
        value,
        large,
        limit,
        strict: false,
        because,
    })
}

fn nail(v: &Values) -> Option<Conflict> {
    let (length, thickness) = (v.nail.length, v.workpiece.thickness);
    if length > thickness {
        return Some(Conflict::NailLongerThanBlock { length, thickness });
    }
    let board = v.workpiece.board.thickness;
    if board > 0.0 {
        if !v.workpiece.mesh.is_empty() {
            return Some(Conflict::BoardOnMesh);
        }
        let through = below(
            ("workpiece.board.thickness", board),
            ("nail.length", length),
            "the nail goes through the board into the block",
        );
        if through.is_some() {
            return through;
        }
    }
    let shank = ("nail.diameter", v.nail.diameter);
    below(
        ("nail.head_thickness", v.nail.head_thickness),
        ("nail.length", length),
        "the head is part of the nail",
    )
    .or_else(|| {
        at_most(
            shank,
            ("nail.head_diameter", v.nail.head_diameter),
            "the head is wider than the shank",
        )
    })
    .or_else(|| {
        at_most(
            ("nail.length", length),
            ("nail.feed_height", v.nail.feed_height),
            "the nail waits inside the nose",
        )
    })
    .or_else(|| {
        let (feed_height, setback) = (v.nail.feed_height, v.piston.stroke - v.piston.rod_protrusion);
        (feed_height >= setback).then_some(Conflict::NailAboveRod { feed_height, setback })
    })
}

fn tool(v: &Values) -> Option<Conflict> {
    let valve = &v.head_valve;
    let seat = ("head_valve.seat_diameter", valve.seat_diameter);
    let lift = ("head_valve.lift", valve.lift);
    below(
        ("piston.rod_diameter", v.piston.rod_diameter),
        ("piston.bore", v.piston.bore),
        "the rod runs in the cylinder",
    )
    .or_else(|| {
        below(
            ("head_valve.inner_diameter", valve.inner_diameter),
            seat,
            "the seat lies on the ring",
        )
    })
    .or_else(|| {
        below(
            seat,
            ("head_valve.outer_diameter", valve.outer_diameter),
            "the seat lies on the ring",
        )
    })
    .or_else(|| {
        let lap = ("head_valve.exhaust_lap", valve.exhaust_lap);
        let intake = ("head_valve.intake_lap", valve.intake_lap);
        at_most(
            lap,
            intake,
            "the exhaust shuts before the intake opens, or the supply blows through",
        )
    })
    .or_else(|| {
        below(
            ("head_valve.intake_lap", valve.intake_lap),
            lift,
            "the intake opens within the lift",
        )
    })
    .or_else(|| {
        (valve.lift + valve.spring_preload > SPRING_LIMIT * (1.0 + 1e-9)).then_some(Conflict::SpringBeyondLaw {
            lift: valve.lift,
            preload: valve.spring_preload,
        })
    })
    .or_else(|| {
        let holes = ("chambers.check_hole_position", v.chambers.check_hole_position);
        below(
            holes,
            ("piston.stroke", v.piston.stroke),
            "the piston passes the check-ring holes",
        )
    })
}

/// Air flows out, through holes that stand apart and a muffler that is known over the range of the analysis.
fn exhaust(v: &Values) -> Option<Conflict> {
    let (supply, ambient) = (v.supply.pressure, v.ambient.pressure);
    if supply <= ambient {
        return Some(Conflict::SupplyBelowAmbient { supply, ambient });
    }
    let holes = ("exhaust.hole_diameter", v.exhaust.hole_diameter);
    if v.exhaust.holes > 1 {
        let apart = below(
            holes,
            ("exhaust.pitch", v.exhaust.pitch),
            "neighbouring holes do not overlap",
        );
        if apart.is_some() {
            return apart;
        }
    }
    let muffler = &v.exhaust.muffler;
    if v.exhaust.fitting.kind != FittingKind::None && muffler.kind != MufflerKind::None {
        return Some(Conflict::FittingAndMuffler);
    }
    if muffler.kind != MufflerKind::Chamber {
        return None;
    }
    let tail = muffler.tail_diameter;
    let bore = 0.25 * std::f64::consts::PI * tail * tail;
    if muffler.flow_area > bore {
        return Some(Conflict::MufflerArea {
            area: muffler.flow_area,
            diameter: tail,
            bore,
        });
    }
    let (top, sound_speed) = (v.analysis.exhaust_top, sound_speed(v));
    [
        ("exhaust.muffler.chamber_diameter", muffler.chamber_diameter),
        ("exhaust.muffler.tail_diameter", tail),
    ]
    .into_iter()
    .map(|(key, diameter)| (key, diameter, plane_wave_limit(diameter, sound_speed)))
    .find(|(_, _, highest)| *highest < top)
    .map(|(key, diameter, highest)| Conflict::NotPlaneWaves {
        key,
        diameter,
        highest,
        top,
    })
}

fn sound_speed(v: &Values) -> f64 {
    (v.ambient.heat_capacity_ratio * v.ambient.gas_constant * v.ambient.temperature).sqrt()
}

fn friction(group: &'static str, friction: &Friction) -> Option<Conflict> {
    let Friction {
        static_force,
        sliding_force,
        ..
    } = *friction;
    (static_force < sliding_force).then_some(Conflict::Friction {
        group,
        static_force,
        sliding_force,
    })
}

/// The tool sits on the wood before the shot: F_hm + (M_g + M_p + M_h) g > k_esg y_msg, the two springs in series.
fn seated(v: &Values) -> Option<Conflict> {
    let push = v.hand.force + (v.tool.mass + v.piston.mass + v.head_valve.mass) * v.ambient.gravity;
    let (k_sg, k_wsn) = (v.contacts.guard_stiffness, v.contacts.nose_stiffness);
    let guard = k_sg * k_wsn / (k_sg + k_wsn) * v.contacts.guard_travel;
    (push <= guard).then_some(Conflict::NotSeated { push, guard })
}

/// The nose stands wholly on the block.
fn nose(v: &Values) -> Option<Conflict> {
    let (nail, block, body) = (&v.nail, &v.workpiece, &v.body);
    let on_block = "the nose, which stands over the nail, must stand on the block";
    at_most(
        (
            "twice the size of `nail.offset_along` plus `body.nose_width`",
            2.0 * nail.offset_along.abs() + body.nose_width,
        ),
        ("workpiece.length", block.length),
        on_block,
    )
    .or_else(|| {
        at_most(
            (
                "twice the size of `nail.offset_across` plus `body.nose_depth`",
                2.0 * nail.offset_across.abs() + body.nose_depth,
            ),
            ("workpiece.width", block.width),
            on_block,
        )
    })
}

/// The walls of the tool body leave room for what they enclose. The barrel is as wide as bore, sleeve and gap require.
fn body(v: &Values) -> Option<Conflict> {
    let b = &v.body;
    let hollow = "the part is hollow";
    below(
        ("body.cap_wall", b.cap_wall),
        ("half of `body.cap_height`", b.cap_height / 2.0),
        hollow,
    )
    .or_else(|| {
        below(
            ("body.handle_wall", b.handle_wall),
            ("body.handle_radius", b.handle_radius),
            hollow,
        )
    })
    .or_else(|| {
        below(
            ("body.magazine_wall", b.magazine_wall),
            ("half of `body.magazine_height`", b.magazine_height / 2.0),
            hollow,
        )
    })
    .or_else(|| {
        let wall = ("body.nose_wall", b.nose_wall);
        below(wall, ("half of `body.nose_width`", b.nose_width / 2.0), hollow)
            .or_else(|| below(wall, ("half of `body.nose_depth`", b.nose_depth / 2.0), hollow))
    })
    .or_else(|| assembly(v))
    .or_else(|| {
        at_most(
            ("body.nose_overlap", b.nose_overlap),
            ("body.barrel_wall", b.barrel_wall),
            "the nose ends in the barrel's floor",
        )
    })
    .or_else(|| {
        below(
            ("body.sleeve_height", b.sleeve_height),
            (
                "`body.barrel_height` less twice `body.barrel_wall`",
                b.barrel_height - 2.0 * b.barrel_wall,
            ),
            "the sleeve stands between the barrel's floor and roof",
        )
    })
    .or_else(|| {
        below(
            ("body.sleeve_fit", b.sleeve_fit),
            ("body.sleeve_height", b.sleeve_height),
            "the fit holds the sleeve's upper end",
        )
    })
    .or_else(|| {
        (b.lumped_nose > 1.0 - b.lumped_magazine).then_some(Conflict::LumpedShares {
            nose: b.lumped_nose,
            magazine: b.lumped_magazine,
        })
    })
    .or_else(|| incompressible("body.housing.poisson_ratio", b.housing.poisson_ratio))
    .or_else(|| incompressible("body.nose.poisson_ratio", b.nose.poisson_ratio))
    .or_else(|| incompressible("body.sleeve.poisson_ratio", b.sleeve.poisson_ratio))
}

/// The parts of the tool body meet, and none is below the tip of the nose.
fn assembly(v: &Values) -> Option<Conflict> {
    let b = &v.body;
    let top = b.nose_height + b.barrel_height + b.cap_height;
    below(
        ("body.handle_radius", b.handle_radius),
        (
            "half of `piston.bore` plus `body.sleeve_wall` and `body.sleeve_gap`",
            b.barrel_radius(0.5 * v.piston.bore) - b.barrel_wall,
        ),
        "the handle's tube is narrower than the cavity of the barrel that it ends on",
    )
    .or_else(|| {
        at_most(
            ("body.handle_level", b.handle_level),
            (
                "`body.barrel_height` plus `body.nose_height` and `body.cap_height` less `body.handle_radius`",
                top - b.handle_radius,
            ),
            "the handle ends on barrel and cap, its top no higher than the cap's",
        )
    })
    .or_else(|| {
        at_most(
            ("body.nose_height", b.nose_height),
            (
                "`body.handle_level` less `body.handle_radius`",
                b.handle_level - b.handle_radius,
            ),
            "the handle ends on the barrel, its underside no lower than the barrel's",
        )
    })
    .or_else(|| {
        at_most(
            (
                "`body.magazine_offset` less `body.magazine_radius` plus `body.magazine_wall`",
                b.magazine_offset - b.magazine_radius + b.magazine_wall,
            ),
            ("body.arm_reach", b.arm_reach),
            "the arm from the nose reaches through the magazine's wall",
        )
    })
    .or_else(|| {
        at_most(
            ("body.magazine_radius", b.magazine_radius),
            ("body.magazine_level", b.magazine_level),
            "no part of the tool is below the nose's tip",
        )
    })
}

fn support(v: &Values) -> Option<Conflict> {
    let block = &v.workpiece;
    let length = ("workpiece.length", block.length);
    let width = ("workpiece.width", block.width);
    match v.support.kind {
        SupportKind::Worktable => {
            let table = &v.support.worktable;
            let on_table = "the block lies on the table";
            let leg = ("support.worktable.leg_width", table.leg_width);
            at_most(length, ("support.worktable.length", table.length), on_table)
                .or_else(|| at_most(width, ("support.worktable.width", table.width), on_table))
                .or_else(|| {
                    below(
                        leg,
                        ("half of `support.worktable.length`", table.length / 2.0),
                        "the legs stand apart",
                    )
                })
                .or_else(|| {
                    below(
                        leg,
                        ("half of `support.worktable.width`", table.width / 2.0),
                        "the legs stand apart",
                    )
                })
                .or_else(|| {
                    let top = ("support.worktable.top_thickness", table.top_thickness);
                    below(
                        top,
                        ("support.worktable.height", table.height),
                        "the top stands on legs",
                    )
                })
                .or_else(|| {
                    let wall = ("support.worktable.steel.tube_wall", table.steel.tube_wall);
                    below(
                        wall,
                        (
                            "half of `support.worktable.steel.tube_width`",
                            table.steel.tube_width / 2.0,
                        ),
                        "a tube is hollow",
                    )
                })
                .or_else(|| {
                    incompressible(
                        "support.worktable.steel.material.poisson_ratio",
                        table.steel.material.poisson_ratio,
                    )
                })
                .or_else(|| elastic("support.worktable.top", &table.top))
                .or_else(|| elastic("support.worktable.legs", &table.legs))
        }
        SupportKind::Sandbox => {
            let sand = &v.support.sand;
            let in_sand = "the block lies in the sand";
            at_most(length, ("support.sand.box_length", sand.box_length), in_sand)
                .or_else(|| at_most(width, ("support.sand.box_width", sand.box_width), in_sand))
                .or_else(|| {
                    let thickness = ("workpiece.thickness", block.thickness);
                    below(thickness, ("support.sand.box_depth", sand.box_depth), in_sand)
                })
                .or_else(|| incompressible("support.sand.poisson_ratio", sand.poisson_ratio))
                .or_else(|| microphones_above_sand(v))
        }
        SupportKind::Floor | SupportKind::Clamped | SupportKind::Springs => None,
    }
}

/// Conflict unless the microphones half way up stand above the sand: they are at half of 1 m more than the height of the
/// tool's middle above the floor.
fn microphones_above_sand(v: &Values) -> Option<Conflict> {
    let (sand, body) = (&v.support.sand, &v.body);
    let centre = 0.5 * (body.nose_height + body.barrel_height + body.cap_height);
    let highest = 1.0 + centre;
    (sand.measurement_plane == SandboxPlane::Floor && sand.box_depth >= highest).then_some(
        Conflict::MicrophonesInSand {
            depth: sand.box_depth,
            highest,
        },
    )
}

impl Grain {
    /// The constants with axis 1 along the grain, 2 radial and 3 tangential.
    pub fn axes(&self) -> Orthotropic {
        Orthotropic {
            e1: self.e_l,
            e2: self.e_r,
            e3: self.e_t,
            g12: self.g_lr,
            g13: self.g_lt,
            g23: self.g_rt,
            nu12: self.nu_lr,
            nu13: self.nu_lt,
            nu23: self.nu_rt,
        }
    }
}

impl Wood {
    /// The constants in the axes of the block: 1 along its length, 2 along its width, 3 along its thickness, with the
    /// growth rings as `driven` says.
    pub fn block_axes(&self) -> Orthotropic {
        let Orthotropic {
            e1,
            e2: e_r,
            e3: e_t,
            g12: g_lr,
            g13: g_lt,
            g23,
            nu12: nu_lr,
            nu13: nu_lt,
            nu23: nu_rt,
        } = self.elastic.axes();
        match self.driven {
            Rings::Tangential => self.elastic.axes(),
            // nu_TR = nu_RT E_T/E_R, the compliance being symmetric.
            Rings::Radial => Orthotropic {
                e1,
                e2: e_t,
                e3: e_r,
                g12: g_lt,
                g13: g_lr,
                g23,
                nu12: nu_lt,
                nu13: nu_lr,
                nu23: nu_rt * e_t / e_r,
            },
        }
    }
}

/// Positive definiteness of the compliance of an orthotropic solid: with r_ij = nu_ij sqrt(E_j/E_i), every
/// 1 - r_ij^2 > 0 and 1 - r_12^2 - r_13^2 - r_23^2 - 2 r_12 r_13 r_23 > 0; the shear moduli are positive by themselves.
fn elastic(group: &'static str, c: &Orthotropic) -> Option<Conflict> {
    let r12 = c.nu12 * (c.e2 / c.e1).sqrt();
    let r13 = c.nu13 * (c.e3 / c.e1).sqrt();
    let r23 = c.nu23 * (c.e3 / c.e2).sqrt();
    [
        ("1 - nu_12 nu_21", 1.0 - r12 * r12),
        ("1 - nu_13 nu_31", 1.0 - r13 * r13),
        ("1 - nu_23 nu_32", 1.0 - r23 * r23),
        (
            "1 - nu_12 nu_21 - nu_13 nu_31 - nu_23 nu_32 - 2 nu_21 nu_32 nu_13",
            1.0 - r12 * r12 - r13 * r13 - r23 * r23 - 2.0 * r12 * r13 * r23,
        ),
    ]
    .into_iter()
    .find(|(_, value)| *value <= 0.0)
    .map(|(minor, value)| Conflict::NotElastic { group, minor, value })
}

fn incompressible(key: &'static str, value: f64) -> Option<Conflict> {
    (value >= 0.5).then_some(Conflict::Incompressible { key, value })
}

fn analysis(v: &Values) -> Option<Conflict> {
    let a = &v.analysis;
    let (low, high) = (a.range_low, a.range_high);
    let top = high.max(a.exhaust_top);
    if v.ambient.heat_capacity_ratio <= 1.0 {
        return Some(Conflict::HeatCapacityRatio {
            value: v.ambient.heat_capacity_ratio,
        });
    }
    if low >= high {
        return Some(Conflict::EmptyRange { low, high });
    }
    if a.time_step * top * SAMPLES > 1.0 {
        return Some(Conflict::TimeStep {
            time_step: a.time_step,
            top,
        });
    }
    (a.cycle_tail >= a.duration).then_some(Conflict::Duration {
        short: "analysis.cycle_tail",
        value: a.cycle_tail,
        long: "analysis.duration",
        limit: a.duration,
    })
}
