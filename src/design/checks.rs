//! Constraints between the quantities of a design.
//!
//! Each rule uses plain values, so that a design changed by a program can be checked as well as a file.

use std::collections::BTreeSet;

use nailnoise_acoustics::muffler::plane_wave_limit;
use nailnoise_acoustics::signals::{Band, THIRD_OCTAVES};
use nailnoise_dynamics::BlowModel;

use super::conflict::{Conflict, SAMPLES, SPRING_LIMIT};
use super::groups::*;
use super::rules::{at_most, below, elastic, incompressible, refuse};
use crate::model::supports;

impl Values {
    /// The first conflict between values, if any.
    ///
    /// A loaded design has none; a program that changes values should check again.
    pub fn conflict(&self) -> Option<Conflict> {
        self.conflict_without(&BTreeSet::new())
    }

    /// The first conflict between the values other than those of keys without effect.
    pub(crate) fn conflict_without(&self, idle: &BTreeSet<String>) -> Option<Conflict> {
        let acts = |conflict: &Conflict| !conflict.keys().iter().any(|key| idle.contains(*key));
        RULES.iter().filter_map(|rule| rule(self).err()).find(acts)
    }
}

/// Applies the rules in order; the first violation is reported.
const RULES: [fn(&Values) -> Result<(), Conflict>; 13] = [
    nail,
    blow,
    tool,
    exhaust,
    |v| friction("piston.friction", &v.piston.friction),
    |v| friction("head_valve.friction", &v.head_valve.friction),
    seated,
    nose,
    body,
    cover,
    |v| supports::of(v).check(),
    |v| elastic("wood.elastic", &v.wood.elastic.axes()),
    analysis,
];

fn blow(v: &Values) -> Result<(), Conflict> {
    let elastic = v.model.blow == BlowModel::Elastic;
    refuse(
        elastic && v.support.coupling == Coupling::TwoWay,
        Conflict::ElasticTwoWay,
    )
}

fn nail(v: &Values) -> Result<(), Conflict> {
    let (length, thickness, groove) = (v.nail.length, v.workpiece.thickness, v.workpiece.groove);
    let nail = ("nail.length", length);
    let longer = Conflict::NailLongerThanBlock {
        length,
        thickness,
        groove,
    };
    refuse(length > thickness - groove, longer)?;
    let board = v.workpiece.board.thickness;
    if board > 0.0 {
        refuse(!v.workpiece.mesh.is_empty(), Conflict::BoardOnMesh)?;
        let through = "the nail goes through the board into the block";
        below(("workpiece.board.thickness", board), nail, through)?;
    }
    let head = ("nail.head_thickness", v.nail.head_thickness);
    below(head, nail, "the head is part of the nail")?;
    let (shank, head) = (v.nail.diameter, ("nail.head_diameter", v.nail.head_diameter));
    at_most(("nail.diameter", shank), head, "the head is wider than the shank")?;
    let feed_height = v.nail.feed_height;
    at_most(
        nail,
        ("nail.feed_height", feed_height),
        "the nail waits inside the nose",
    )?;
    let setback = v.piston.stroke - v.piston.rod_protrusion;
    refuse(feed_height >= setback, Conflict::NailAboveRod { feed_height, setback })
}

fn tool(v: &Values) -> Result<(), Conflict> {
    let (piston, valve) = (&v.piston, &v.head_valve);
    let bore = ("piston.bore", piston.bore);
    let rod = ("piston.rod_diameter", piston.rod_diameter);
    below(rod, bore, "the rod runs in the cylinder")?;
    let inner = ("head_valve.inner_diameter", valve.inner_diameter);
    let seat = ("head_valve.seat_diameter", valve.seat_diameter);
    let outer = ("head_valve.outer_diameter", valve.outer_diameter);
    below(inner, seat, "the seat lies on the ring")?;
    below(seat, outer, "the seat lies on the ring")?;
    let exhaust = ("head_valve.exhaust_lap", valve.exhaust_lap);
    let intake = ("head_valve.intake_lap", valve.intake_lap);
    let one_of_both = "the exhaust shuts before the intake opens, or the supply blows through";
    at_most(exhaust, intake, one_of_both)?;
    let (lift, preload) = (valve.lift, valve.spring_preload);
    below(intake, ("head_valve.lift", lift), "the intake opens within the lift")?;
    let beyond = lift + preload > SPRING_LIMIT * (1.0 + 1e-9);
    refuse(beyond, Conflict::SpringBeyondLaw { lift, preload })?;
    let holes = ("chambers.check_hole_position", v.chambers.check_hole_position);
    let stroke = ("piston.stroke", piston.stroke);
    below(holes, stroke, "the piston passes the check-ring holes")
}

/// Checks that air flows out, that holes are at a valid distance from each other, and that the muffler's properties are
/// known over the range of the analysis.
fn exhaust(v: &Values) -> Result<(), Conflict> {
    let (supply, ambient) = (v.supply.pressure, v.ambient.pressure);
    refuse(supply <= ambient, Conflict::SupplyBelowAmbient { supply, ambient })?;
    if v.exhaust.holes > 1 {
        let holes = ("exhaust.hole_diameter", v.exhaust.hole_diameter);
        let pitch = ("exhaust.pitch", v.exhaust.pitch);
        below(holes, pitch, "neighbouring holes do not overlap")?;
    }
    let muffler = &v.exhaust.muffler;
    let both = v.exhaust.fitting.kind != FittingKind::None && muffler.kind != MufflerKind::None;
    refuse(both, Conflict::FittingAndMuffler)?;
    match muffler.kind {
        MufflerKind::None => Ok(()),
        MufflerKind::InsertionLoss => insertion_loss(&v.analysis),
        MufflerKind::Chamber => chamber(v),
    }
}

/// Checks that the octaves of a measured insertion loss cover the range of the exhaust.
fn insertion_loss(analysis: &Analysis) -> Result<(), Conflict> {
    // The octaves from 63 Hz to 16 kHz contain the third octaves from 50 Hz to 20 kHz.
    let (first, last) = THIRD_OCTAVES.into_inner();
    let range = [Band::new(first).low, Band::new(last).high];
    for (key, value) in [
        ("analysis.range_low", analysis.range_low),
        ("analysis.exhaust_max_frequency", analysis.exhaust_max_frequency),
    ] {
        let outside = Conflict::InsertionLossRange { key, value, range };
        refuse(value < range[0] || value >= range[1], outside)?;
    }
    Ok(())
}

/// Checks that a chamber and its tail pipe can be modelled over the range of the exhaust.
fn chamber(v: &Values) -> Result<(), Conflict> {
    let muffler = &v.exhaust.muffler;
    let (area, diameter) = (muffler.flow_area, muffler.tail_diameter);
    let bore = 0.25 * std::f64::consts::PI * diameter * diameter;
    refuse(area > bore, Conflict::MufflerArea { area, diameter, bore })?;
    let (top, sound_speed) = (v.analysis.exhaust_max_frequency, sound_speed(v));
    for (key, diameter) in [
        ("exhaust.muffler.chamber_diameter", muffler.chamber_diameter),
        ("exhaust.muffler.tail_diameter", diameter),
    ] {
        let highest = plane_wave_limit(diameter, sound_speed);
        let across = Conflict::NotPlaneWaves {
            key,
            diameter,
            highest,
            top,
        };
        refuse(highest < top, across)?;
    }
    let resistivity = muffler.lining_resistivity;
    let lined = muffler.lining_thickness > 0.0;
    refuse(lined && resistivity < top, Conflict::LiningRange { resistivity, top })
}

fn sound_speed(v: &Values) -> f64 {
    (v.ambient.heat_capacity_ratio * v.ambient.gas_constant * v.ambient.temperature).sqrt()
}

fn friction(group: &'static str, friction: &Friction) -> Result<(), Conflict> {
    let (static_force, sliding_force) = (friction.static_force, friction.sliding_force);
    let conflict = Conflict::Friction {
        group,
        static_force,
        sliding_force,
    };
    refuse(static_force < sliding_force, conflict)
}

/// Checks that the tool sits on the wood before the shot: F_hm + (M_g + M_p + M_h) g > k_esg y_msg, with the two
/// springs in series.
fn seated(v: &Values) -> Result<(), Conflict> {
    let push = v.hand.force + (v.tool.mass + v.piston.mass + v.head_valve.mass) * v.ambient.gravity;
    let (k_sg, k_wsn) = (v.contacts.guard_stiffness, v.contacts.nose_stiffness);
    let guard = k_sg * k_wsn / (k_sg + k_wsn) * v.contacts.guard_travel;
    refuse(push <= guard, Conflict::NotSeated { push, guard })
}

/// Checks that the nose rests entirely on the block.
fn nose(v: &Values) -> Result<(), Conflict> {
    let (nail, block, body) = (&v.nail, &v.workpiece, &v.body);
    let on_block = "the nose, which stands over the nail, must stand on the block";
    let along = (
        "twice the size of `nail.offset_along` plus `body.nose_width`",
        2.0 * nail.offset_along.abs() + body.nose_width,
    );
    at_most(along, ("workpiece.length", block.length), on_block)?;
    let across = (
        "twice the size of `nail.offset_across` plus `body.nose_depth`",
        2.0 * nail.offset_across.abs() + body.nose_depth,
    );
    at_most(across, ("workpiece.width", block.width), on_block)
}

/// Checks that the walls of the tool body leave room for the parts inside. The width of the barrel follows from bore,
/// sleeve and gap.
fn body(v: &Values) -> Result<(), Conflict> {
    let b = &v.body;
    let half_cap = ("half of `body.cap_height`", b.cap_height / 2.0);
    let half_magazine = ("half of `body.magazine_height`", b.magazine_height / 2.0);
    let nose_wall = ("body.nose_wall", b.nose_wall);
    for (wall, room) in [
        (("body.cap_wall", b.cap_wall), half_cap),
        (
            ("body.handle_wall", b.handle_wall),
            ("body.handle_radius", b.handle_radius),
        ),
        (("body.magazine_wall", b.magazine_wall), half_magazine),
        (nose_wall, ("half of `body.nose_width`", b.nose_width / 2.0)),
        (nose_wall, ("half of `body.nose_depth`", b.nose_depth / 2.0)),
    ] {
        below(wall, room, "the part is hollow")?;
    }
    assembly(v)?;
    let overlap = ("body.nose_overlap", b.nose_overlap);
    let floor = ("body.barrel_wall", b.barrel_wall);
    at_most(overlap, floor, "the nose ends in the barrel's floor")?;
    let sleeve = ("body.sleeve_height", b.sleeve_height);
    let inside = (
        "`body.barrel_height` less twice `body.barrel_wall`",
        b.barrel_height - 2.0 * b.barrel_wall,
    );
    below(sleeve, inside, "the sleeve stands between the barrel's floor and roof")?;
    let fit = ("body.sleeve_fit", b.sleeve_fit);
    below(fit, sleeve, "the fit holds the sleeve's upper end")?;
    let (nose, magazine) = (b.lumped_nose, b.lumped_magazine);
    refuse(nose > 1.0 - magazine, Conflict::LumpedShares { nose, magazine })?;
    incompressible("body.housing.poisson_ratio", b.housing.poisson_ratio)?;
    incompressible("body.cap.poisson_ratio", b.cap.poisson_ratio)?;
    incompressible("body.nose.poisson_ratio", b.nose.poisson_ratio)?;
    incompressible("body.sleeve.poisson_ratio", b.sleeve.poisson_ratio)
}

/// Checks that a cover lies on a surface that radiates by boundary elements, with their dense matrix, and that no mass
/// of the air acts, which would include that of the air in the cover.
fn cover(v: &Values) -> Result<(), Conflict> {
    if v.body.cover.surfaces == CoverSurfaces::None {
        return Ok(());
    }
    let elastic = "it changes the radiation of an elastic housing by boundary elements";
    let refused = |broken, key, value, allowed, because| {
        refuse(
            broken,
            Conflict::Cover {
                key,
                value,
                allowed,
                because,
            },
        )
    };
    let a = &v.acoustics;
    let rigid = v.body.model == BodyModel::Rigid;
    refused(rigid, "body.model", "rigid", "\"elastic\"", elastic)?;
    let erp = a.body_method == RadiationMethod::Erp;
    refused(erp, "acoustics.body_method", "erp", "\"bem\"", elastic)?;
    refused(
        a.fluid_loading == FluidLoading::Full,
        "acoustics.fluid_loading",
        "full",
        "\"damping\" or \"none\"",
        "the mass of the air in the cover is not computed",
    )?;
    refused(
        a.bem_equations == BemEquations::Compressed,
        "acoustics.bem_equations",
        "compressed",
        "\"auto\" or \"dense\"",
        "a covered surface is solved with a dense matrix",
    )
}

/// Checks that the parts of the tool body meet, and that none is below the tip of the nose.
fn assembly(v: &Values) -> Result<(), Conflict> {
    let b = &v.body;
    let top = b.nose_height + b.barrel_height + b.cap_height;
    below(
        ("body.handle_radius", b.handle_radius),
        (
            "half of `piston.bore` plus `body.sleeve_wall` and `body.sleeve_gap`",
            b.barrel_radius(0.5 * v.piston.bore) - b.barrel_wall,
        ),
        "the handle's tube is narrower than the cavity of the barrel that it ends on",
    )?;
    at_most(
        ("body.handle_level", b.handle_level),
        (
            "`body.barrel_height` plus `body.nose_height` and `body.cap_height` less `body.handle_radius`",
            top - b.handle_radius,
        ),
        "the handle ends on barrel and cap, its top no higher than the cap's",
    )?;
    at_most(
        ("body.nose_height", b.nose_height),
        (
            "`body.handle_level` less `body.handle_radius`",
            b.handle_level - b.handle_radius,
        ),
        "the handle ends on the barrel, its underside no lower than the barrel's",
    )?;
    at_most(
        (
            "`body.magazine_offset` less `body.magazine_radius` plus `body.magazine_wall`",
            b.magazine_offset - b.magazine_radius + b.magazine_wall,
        ),
        ("body.arm_reach", b.arm_reach),
        "the arm from the nose reaches through the magazine's wall",
    )?;
    at_most(
        ("body.magazine_radius", b.magazine_radius),
        ("body.magazine_level", b.magazine_level),
        "no part of the tool is below the nose's tip",
    )
}

impl Grain {
    /// The constants for axis 1 along the grain, 2 radial and 3 tangential.
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
    /// growth rings according to `driven`.
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
            // nu_TR = nu_RT E_T/E_R, because the compliance is symmetric.
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

fn analysis(v: &Values) -> Result<(), Conflict> {
    let a = &v.analysis;
    let value = v.ambient.heat_capacity_ratio;
    refuse(value <= 1.0, Conflict::HeatCapacityRatio { value })?;
    let (low, high, time_step) = (a.range_low, a.range_high, a.time_step);
    refuse(low >= high, Conflict::EmptyRange { low, high })?;
    let top = high.max(a.exhaust_max_frequency);
    let coarse = time_step * top * SAMPLES > 1.0;
    refuse(coarse, Conflict::TimeStep { time_step, top })?;
    let tail = Conflict::Duration {
        short: "analysis.cycle_tail",
        value: a.cycle_tail,
        long: "analysis.duration",
        limit: a.duration,
    };
    refuse(a.cycle_tail >= a.duration, tail)?;
    let release = v.trigger.release_after;
    let never = Conflict::Duration {
        short: "trigger.release_after",
        value: release,
        long: "analysis.cycle_end",
        limit: a.cycle_end,
    };
    refuse(release >= a.cycle_end, never)
}
