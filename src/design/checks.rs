//! What must hold between the quantities of a design.
//!
//! Each rule reads plain values, so that a design changed by a program can be checked as well as a file.

use nailnoise_acoustics::muffler::plane_wave_limit;
use nailnoise_quantities::dimension::*;

use super::groups::*;
use super::show::{Short, show};
use super::springs::Sprung;

/// Compression up to which the printed polynomial of the closing spring (Eq. 4.60) holds \[m\].
const SPRING_LIMIT: f64 = 5e-3;

/// Two or more values that do not go together, with their numbers in SI units.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum Conflict {
    /// The nail would come out below the block.
    #[error("the nail ({}) is longer than the block is thick ({})", mm(*length), mm(*thickness))]
    NailLongerThanBlock {
        /// Length of the nail \[m\].
        length: f64,
        /// Thickness of the block \[m\].
        thickness: f64,
    },
    /// A board is part of the built-in block.
    #[error("`workpiece.board.thickness` puts a board on the built-in block, and `workpiece.mesh` replaces that block")]
    BoardOnMesh,
    /// The head of the waiting nail would be above the rod's end.
    #[error(
        "`nail.feed_height` ({}) must be below `piston.stroke` less `piston.rod_protrusion` ({})",
        mm(*feed_height),
        mm(*setback)
    )]
    NailAboveRod {
        /// Height of the head above the nose's face \[m\].
        feed_height: f64,
        /// Height of the rod's end before the shot, stroke less protrusion \[m\].
        setback: f64,
    },
    /// A length that must be smaller than another, or equal where `strict` is false.
    #[error("`{small}` ({}) must be {} `{large}` ({})", mm(*value), order(*strict), mm(*limit))]
    Order {
        /// Key of the smaller length.
        small: &'static str,
        /// Its value \[m\].
        value: f64,
        /// Key of the larger length.
        large: &'static str,
        /// Its value \[m\].
        limit: f64,
        /// Whether equality is refused too.
        strict: bool,
        /// Why.
        because: &'static str,
    },
    /// The closing spring is pressed beyond the range of its law.
    #[error("the head valve's lift ({}) and spring preload ({}) add up to {}, the spring's law (Eq. 4.60) ends at {}",
        mm(*lift), mm(*preload), mm(lift + preload), mm(SPRING_LIMIT))]
    SpringBeyondLaw {
        /// Full lift \[m\].
        lift: f64,
        /// Preload \[m\].
        preload: f64,
    },
    /// Static friction below sliding friction.
    #[error("`{group}` has less static ({} N) than sliding friction ({} N)",
        Short(*static_force), Short(*sliding_force))]
    Friction {
        /// The group.
        group: &'static str,
        /// Static friction \[N\].
        static_force: f64,
        /// Sliding friction \[N\].
        sliding_force: f64,
    },
    /// The guard's spring lifts the tool off the wood before the shot.
    #[error("hand and weight push with {} N, the guard's spring lifts with {} N: the tool does not sit on the wood",
        Short(*push), Short(*guard))]
    NotSeated {
        /// Push of the hand and weight of the tool \[N\].
        push: f64,
        /// Force of the guard's spring at its full travel \[N\].
        guard: f64,
    },
    /// Elastic constants with which a solid would give energy away.
    #[error("the elastic constants of `{group}` are not positive definite: {minor} = {}", Short(*value))]
    NotElastic {
        /// The group.
        group: &'static str,
        /// The minor of the compliance matrix, scaled by its diagonal, that is not above zero.
        minor: &'static str,
        /// Its value.
        value: f64,
    },
    /// Poisson's ratio of an isotropic solid.
    #[error("`{key}` is {}, an isotropic solid has less than 0.5", Short(*value))]
    Incompressible {
        /// The key.
        key: &'static str,
        /// Its value.
        value: f64,
    },
    /// A supply that cannot drive anything.
    #[error("`supply.pressure` ({} kPa absolute) is not above `ambient.pressure` ({} kPa)",
        Short(1e-3 * supply), Short(1e-3 * ambient))]
    SupplyBelowAmbient {
        /// Supply pressure \[Pa\].
        supply: f64,
        /// Ambient pressure \[Pa\].
        ambient: f64,
    },
    /// A muffler is asked for frequencies at which waves run across it.
    #[error("`{key}` ({}) carries plane waves alone up to {:.0} Hz, the exhaust is analysed to {:.0} Hz",
        mm(*diameter), highest, top)]
    NotPlaneWaves {
        /// Key of the diameter.
        key: &'static str,
        /// Its value \[m\].
        diameter: f64,
        /// Frequency at which the first wave across it propagates \[Hz\].
        highest: f64,
        /// Top of the analysis \[Hz\].
        top: f64,
    },
    /// The muffler's tail pipe cannot have the flow area given.
    #[error("`exhaust.muffler.flow_area` ({}) is more than the tail pipe of {} has ({})",
        show(*area, AREA), mm(*diameter), show(*bore, AREA))]
    MufflerArea {
        /// Flow area given \[m2\].
        area: f64,
        /// Diameter of the tail pipe \[m\].
        diameter: f64,
        /// Its bore \[m2\].
        bore: f64,
    },
    /// A fitting and a muffler on the same holes.
    #[error("`exhaust.fitting.kind` and `exhaust.muffler.kind` put a fitting and a muffler on the same holes")]
    FittingAndMuffler,
    /// Nothing carries a body that stands on springs.
    #[error("nothing carries the {}: it stands on springs, and none on it has a `stiffness_z` above 0", body.as_str())]
    NotCarried {
        /// The body.
        body: Sprung,
        /// The key that takes other supports away.
        key: &'static str,
    },
    /// Microphones below the sand, on a measurement surface that stands on the floor.
    #[error("a sandbox of {} on the floor is not below {}, where the microphones would be in the sand", mm(*depth), mm(*highest))]
    MicrophonesInSand {
        /// Depth of the box \[m\].
        depth: f64,
        /// Depth that it must not reach \[m\].
        highest: f64,
    },
    /// Ratio of specific heats of 1 or less.
    #[error("`ambient.heat_capacity_ratio` is {}, a gas has more than 1", Short(*value))]
    HeatCapacityRatio {
        /// Its value.
        value: f64,
    },
    /// The range for the ranking is empty.
    #[error("the range of the ranking runs from {} Hz to {} Hz", Short(*low), Short(*high))]
    EmptyRange {
        /// Lower end \[Hz\].
        low: f64,
        /// Upper end \[Hz\].
        high: f64,
    },
    /// The time step samples the top frequency too coarsely.
    #[error("a time step of {} us samples {} Hz {} times a period, fewer than {SAMPLES} times",
        Short(time_step * 1e6), Short(*top), Short(1.0 / (time_step * top)))]
    TimeStep {
        /// Time step \[s\].
        time_step: f64,
        /// Highest frequency asked for \[Hz\].
        top: f64,
    },
    /// A time that must be shorter than another.
    #[error("`{short}` ({} ms) must be below `{long}` ({} ms)", Short(value * 1e3), Short(limit * 1e3))]
    Duration {
        /// Key of the shorter time.
        short: &'static str,
        /// Its value \[s\].
        value: f64,
        /// Key of the longer time.
        long: &'static str,
        /// Its value \[s\].
        limit: f64,
    },
}

/// Samples a period at the highest frequency, for a record that a Fourier transform can use.
const SAMPLES: f64 = 4.0;

fn mm(length: f64) -> String {
    show(length, LENGTH)
}

fn order(strict: bool) -> &'static str {
    if strict { "below" } else { "at most" }
}

impl Conflict {
    /// The keys in conflict.
    pub fn keys(&self) -> Vec<&'static str> {
        match self {
            Self::NailLongerThanBlock { .. } => vec!["nail.length", "workpiece.thickness"],
            Self::BoardOnMesh => vec!["workpiece.board.thickness", "workpiece.mesh"],
            Self::NailAboveRod { .. } => vec!["nail.feed_height", "piston.rod_protrusion", "piston.stroke"],
            Self::Order { small, large, .. } => vec![small, large],
            Self::SpringBeyondLaw { .. } => vec!["head_valve.lift", "head_valve.spring_preload"],
            Self::Friction {
                group: "piston.friction",
                ..
            } => {
                vec!["piston.friction.static_force", "piston.friction.sliding_force"]
            }
            Self::Friction { .. } => vec!["head_valve.friction.static_force", "head_valve.friction.sliding_force"],
            Self::NotSeated { .. } => {
                vec![
                    "hand.force",
                    "contacts.guard_travel",
                    "contacts.guard_stiffness",
                    "tool.mass",
                ]
            }
            Self::NotElastic { group, .. } => elastic_keys(group),
            Self::Incompressible { key, .. } => vec![key],
            Self::SupplyBelowAmbient { .. } => vec!["supply.pressure", "ambient.pressure"],
            Self::NotPlaneWaves { key, .. } => vec![key, "exhaust.muffler.kind", "analysis.exhaust_top"],
            Self::NotCarried { key, .. } => vec![key],
            Self::MufflerArea { .. } => vec!["exhaust.muffler.flow_area", "exhaust.muffler.tail_diameter"],
            Self::MicrophonesInSand { .. } => vec!["support.sand.box_depth", "support.sand.measurement_plane"],
            Self::FittingAndMuffler => vec!["exhaust.fitting.kind", "exhaust.muffler.kind"],
            Self::HeatCapacityRatio { .. } => vec!["ambient.heat_capacity_ratio"],
            Self::EmptyRange { .. } => vec!["analysis.range_low", "analysis.range_high"],
            Self::TimeStep { .. } => vec!["analysis.time_step", "analysis.range_high", "analysis.exhaust_top"],
            Self::Duration { short, long, .. } => vec![short, long],
        }
    }

    /// What to do about it.
    pub fn remedy(&self) -> String {
        match self {
            Self::NailLongerThanBlock { .. } => {
                "shorten `nail.length` or raise `workpiece.thickness`: the point must stay in the wood".to_owned()
            }
            Self::BoardOnMesh => "set `workpiece.board.thickness` to 0, or remove `workpiece.mesh`".to_owned(),
            Self::NailAboveRod { .. } => {
                "lower `nail.feed_height` or `piston.rod_protrusion`, or raise `piston.stroke`: the rod \
                                          begins above the nail's head"
                    .to_owned()
            }
            Self::Order {
                small, large, because, ..
            } => format!("{because}: lower `{small}` or raise `{large}`"),
            Self::SpringBeyondLaw { .. } => {
                "lower `head_valve.lift` or `head_valve.spring_preload`; beyond 5 mm the printed polynomial falls"
                    .to_owned()
            }
            Self::Friction { group, .. } => format!("raise `{group}.static_force` or lower `{group}.sliding_force`"),
            Self::NotSeated { .. } => {
                "raise `hand.force`, or lower `contacts.guard_travel` or `contacts.guard_stiffness`".to_owned()
            }
            Self::NotElastic { group, .. } => {
                format!(
                    "lower the Poisson's ratios of `{group}`: nu_ij^2 < E_i/E_j must hold, and all minors be positive"
                )
            }
            Self::Incompressible { key, .. } => format!("give `{key}` a value below 0.5"),
            Self::SupplyBelowAmbient { .. } => {
                "give `supply.pressure` as absolute pressure, or with a gauge unit such as psig or barg".to_owned()
            }
            Self::NotPlaneWaves { key, highest, .. } => format!(
                "narrow `{key}`, lower `analysis.exhaust_top` to {:.0} Hz and `analysis.range_high` with it, or give \
                 the measured insertion loss: `exhaust.muffler.kind = \"insertion_loss\"`",
                highest.floor()
            ),
            Self::MufflerArea { .. } => {
                "lower `exhaust.muffler.flow_area` or widen `exhaust.muffler.tail_diameter`".to_owned()
            }
            Self::FittingAndMuffler => {
                "choose one: `exhaust.fitting.kind = \"none\"` or `exhaust.muffler.kind = \"none\"`".to_owned()
            }
            Self::MicrophonesInSand { .. } => {
                "lower `support.sand.box_depth`, or choose `support.sand.measurement_plane = \"sand\"`".to_owned()
            }
            Self::NotCarried { body, .. } => format!(
                "name its springs: [springs.NAME] with body = \"{}\", x, y, z, and stiffness and damping along each axis",
                body.as_str()
            ),
            Self::HeatCapacityRatio { .. } => "give `ambient.heat_capacity_ratio` as 1.4 for air".to_owned(),
            Self::EmptyRange { .. } => "give `analysis.range_low` below `analysis.range_high`".to_owned(),
            Self::TimeStep { top, .. } => {
                format!(
                    "lower `analysis.time_step` to {} us or less",
                    Short(1e6 / (SAMPLES * top))
                )
            }
            Self::Duration { short, long, .. } => format!("lower `{short}` or raise `{long}`"),
        }
    }
}

fn elastic_keys(group: &str) -> Vec<&'static str> {
    match group {
        "wood.elastic" => vec!["wood.elastic.nu_lr", "wood.elastic.nu_lt", "wood.elastic.nu_rt"],
        "support.worktable.top" => {
            vec![
                "support.worktable.top.nu12",
                "support.worktable.top.nu13",
                "support.worktable.top.nu23",
            ]
        }
        _ => vec![
            "support.worktable.legs.nu12",
            "support.worktable.legs.nu13",
            "support.worktable.legs.nu23",
        ],
    }
}

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
    let within = |offset: (&'static str, f64), nose: f64, block: (&'static str, f64)| {
        let reach = (offset.0, 2.0 * offset.1.abs() + nose);
        at_most(
            reach,
            block,
            "the nose, which stands over the nail, must stand on the block",
        )
    };
    let (nail, block, body) = (&v.nail, &v.workpiece, &v.body);
    within(
        ("nail.offset_along", nail.offset_along),
        body.nose_width,
        ("workpiece.length", block.length),
    )
    .or_else(|| {
        within(
            ("nail.offset_across", nail.offset_across),
            body.nose_depth,
            ("workpiece.width", block.width),
        )
    })
}

/// The walls of the tool body leave room for what they enclose. The barrel is as wide as bore, sleeve and gap require.
fn body(v: &Values) -> Option<Conflict> {
    let b = &v.body;
    let hollow = "the part is hollow";
    below(
        ("body.cap_wall", b.cap_wall),
        ("body.cap_height", b.cap_height / 2.0),
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
            ("body.magazine_height", b.magazine_height / 2.0),
            hollow,
        )
    })
    .or_else(|| {
        below(
            ("body.nose_wall", b.nose_wall),
            ("body.nose_width", b.nose_width.min(b.nose_depth) / 2.0),
            hollow,
        )
    })
    .or_else(|| parts_meet(v))
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
            ("body.barrel_height", b.barrel_height - 2.0 * b.barrel_wall),
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
        at_most(
            ("body.lumped_nose", b.lumped_nose),
            ("body.lumped_magazine", 1.0 - b.lumped_magazine),
            "the shares of nose and magazine add up to 1 at most",
        )
    })
    .or_else(|| incompressible("body.housing.poisson_ratio", b.housing.poisson_ratio))
    .or_else(|| incompressible("body.nose.poisson_ratio", b.nose.poisson_ratio))
    .or_else(|| incompressible("body.sleeve.poisson_ratio", b.sleeve.poisson_ratio))
}

/// The parts of the tool body meet, and none is below the tip of the nose.
fn parts_meet(v: &Values) -> Option<Conflict> {
    let b = &v.body;
    let top = b.nose_height + b.barrel_height + b.cap_height;
    below(
        ("body.handle_radius", b.handle_radius),
        (
            "body.barrel_radius",
            b.barrel_radius(0.5 * v.piston.bore) - b.barrel_wall,
        ),
        "the handle's tube is narrower than the cavity of the barrel that it ends on",
    )
    .or_else(|| {
        at_most(
            ("body.handle_level", b.handle_level),
            ("body.barrel_height", top - b.handle_radius),
            "the handle ends on barrel and cap, its top no higher than the cap's",
        )
    })
    .or_else(|| {
        at_most(
            ("body.nose_height", b.nose_height),
            ("body.handle_level", b.handle_level - b.handle_radius),
            "the handle ends on the barrel, its underside no lower than the barrel's",
        )
    })
    .or_else(|| {
        at_most(
            ("body.magazine_offset", b.magazine_offset),
            ("body.arm_reach", b.arm_reach + b.magazine_radius - b.magazine_wall),
            "the arm from the nose reaches through the magazine's wall, which is a radius from the magazine's axis",
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
                        ("support.worktable.length", table.length / 2.0),
                        "the legs stand apart",
                    )
                })
                .or_else(|| {
                    below(
                        leg,
                        ("support.worktable.width", table.width / 2.0),
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
                        ("support.worktable.steel.tube_width", table.steel.tube_width / 2.0),
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
