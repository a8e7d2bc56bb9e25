//! Conflicting values of a design: message, keys and remedy.

use nailnoise_quantities::dimension::*;

use super::show::{Short, mm, show};
use super::springs::Sprung;

/// Compression limit of the published polynomial of the closing spring (Eq. 4.60) \[m\].
pub(super) const SPRING_LIMIT: f64 = 5e-3;

/// Two or more conflicting values, with their numbers in SI units.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum Conflict {
    /// The nail would protrude below the block.
    #[error(
        "the nail ({}) is longer than the block is thick{} ({})",
        mm(*length),
        if *groove > 0.0 { " below its groove" } else { "" },
        mm(*thickness - *groove)
    )]
    NailLongerThanBlock {
        /// Length of the nail \[m\].
        length: f64,
        /// Thickness of the block \[m\].
        thickness: f64,
        /// Depth of the groove \[m\].
        groove: f64,
    },
    /// A board requires the built-in block.
    #[error("`workpiece.board.thickness` puts a board on the built-in block, and `workpiece.mesh` replaces that block")]
    BoardOnMesh,
    /// The blow as elastic bars needs a cycle that is complete before the structures respond.
    #[error("`model.blow = \"elastic\"` acts on bodies that respond one way, and `support.coupling` is \"two-way\"")]
    ElasticTwoWay,
    /// The head of the waiting nail would be above the end of the rod.
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
    /// A length must be smaller than another, or at most equal if `strict` is false.
    #[error("{} ({}) must be {} {} ({})", term(small), mm(*value), order(*strict), term(large), mm(*limit))]
    Order {
        /// The smaller length: a key, or a term with keys in backticks.
        small: &'static str,
        /// Its value \[m\].
        value: f64,
        /// The larger length, likewise.
        large: &'static str,
        /// Its value \[m\].
        limit: f64,
        /// Whether equality is rejected too.
        strict: bool,
        /// The reason.
        because: &'static str,
    },
    /// Nose and magazine carry more than the total lumped mass.
    #[error("`body.lumped_nose` ({nose}) and `body.lumped_magazine` ({magazine}) must not add up to more than 1")]
    LumpedShares {
        /// Share on the nose \[-\].
        nose: f64,
        /// Share on the magazine \[-\].
        magazine: f64,
    },
    /// The closing spring is compressed beyond the range of its law.
    #[error("the head valve's lift ({}) and spring preload ({}) add up to {}, the spring's law (Eq. 4.60) ends at {}",
        mm(*lift), mm(*preload), mm(lift + preload), mm(SPRING_LIMIT))]
    SpringBeyondLaw {
        /// Full lift \[m\].
        lift: f64,
        /// Preload \[m\].
        preload: f64,
    },
    /// Static friction is below sliding friction.
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
    /// Elastic constants imply negative strain energy.
    #[error("the elastic constants of `{group}` are not positive definite: the scaled compliance has the eigenvalue {}",
        Short(*eigenvalue))]
    NotElastic {
        /// The group.
        group: &'static str,
        /// Smallest eigenvalue of the compliance matrix, scaled by its diagonal \[-\].
        eigenvalue: f64,
    },
    /// Poisson's ratio is impossible for an isotropic solid.
    #[error("`{key}` is {}, an isotropic solid has less than 0.5", Short(*value))]
    Incompressible {
        /// The key.
        key: &'static str,
        /// Its value.
        value: f64,
    },
    /// The supply pressure is not above ambient.
    #[error("`supply.pressure` ({} kPa absolute) is not above `ambient.pressure` ({} kPa)",
        Short(1e-3 * supply), Short(1e-3 * ambient))]
    SupplyBelowAmbient {
        /// Supply pressure \[Pa\].
        supply: f64,
        /// Ambient pressure \[Pa\].
        ambient: f64,
    },
    /// Cross modes propagate in the muffler within the range of the analysis.
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
    /// The analysis of the exhaust exceeds the range in which the muffler's insertion loss was measured.
    #[error("`{key}` is {}, the octaves of the measured insertion loss cover {} to {}", show(*value, FREQUENCY),
        show(range[0], FREQUENCY), show(range[1], FREQUENCY))]
    InsertionLossRange {
        /// Key of the end of the range.
        key: &'static str,
        /// Its value \[Hz\].
        value: f64,
        /// Range of the octaves \[Hz\].
        range: [f64; 2],
    },
    /// The analysis of the exhaust exceeds the range of the law for the muffler's lining.
    #[error("the law of a porous lining ends where the frequency in Hz is its flow resistivity in Pa s/m2, here at \
        {}; the \
         exhaust is analysed to {}", show(*resistivity, FREQUENCY), show(*top, FREQUENCY))]
    LiningRange {
        /// Flow resistivity \[Pa s/m2\].
        resistivity: f64,
        /// Top of the analysis \[Hz\].
        top: f64,
    },
    /// The muffler's tail pipe is too small for the given flow area.
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
    /// Both a fitting and a muffler are on the same holes.
    #[error("`exhaust.fitting.kind` and `exhaust.muffler.kind` put a fitting and a muffler on the same holes")]
    FittingAndMuffler,
    /// A cover needs another setting.
    #[error("`body.cover.surfaces` puts a cover on the tool, and `{key}` is \"{value}\": {because}")]
    Cover {
        /// The key of the setting.
        key: &'static str,
        /// Its value.
        value: &'static str,
        /// The values that a cover allows.
        allowed: &'static str,
        /// The reason.
        because: &'static str,
    },
    /// Nothing supports a body that rests on springs.
    #[error("nothing carries the {}: it stands on springs, and none on it has a `stiffness_z` above 0", body.as_str())]
    NotCarried {
        /// The body.
        body: Sprung,
        /// The key that removes other supports.
        key: &'static str,
    },
    /// Microphones would be below the sand, on a measurement surface that stands on the floor.
    #[error("a sandbox of {} on the floor is not below {}, where the microphones would be in the \
        sand", mm(*depth), mm(*highest))]
    MicrophonesInSand {
        /// Depth of the box \[m\].
        depth: f64,
        /// Limit of the depth \[m\].
        highest: f64,
    },
    /// Ratio of specific heats of 1 or less.
    #[error("`ambient.heat_capacity_ratio` is {}, a gas has more than 1", Short(*value))]
    HeatCapacityRatio {
        /// Its value.
        value: f64,
    },
    /// The frequency range for the ranking is empty.
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
        /// Highest required frequency \[Hz\].
        top: f64,
    },
    /// A time must be shorter than another.
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

/// Samples per period at the highest frequency needed for a Fourier transform.
pub(super) const SAMPLES: f64 = 4.0;

fn order(strict: bool) -> &'static str {
    if strict { "below" } else { "at most" }
}

/// Formats a length for a message: a key in backticks, or an unchanged term.
fn term(length: &str) -> String {
    if length.contains('`') {
        length.to_owned()
    } else {
        format!("`{length}`")
    }
}

/// The keys of a length.
fn keys_of(length: &'static str) -> Vec<&'static str> {
    if length.contains('`') {
        length.split('`').skip(1).step_by(2).collect()
    } else {
        vec![length]
    }
}

impl Conflict {
    /// The keys in conflict.
    pub fn keys(&self) -> Vec<&'static str> {
        match self {
            Self::NailLongerThanBlock { groove, .. } if *groove > 0.0 => {
                vec!["nail.length", "workpiece.groove", "workpiece.thickness"]
            }
            Self::NailLongerThanBlock { .. } => vec!["nail.length", "workpiece.thickness"],
            Self::ElasticTwoWay => vec!["model.blow", "support.coupling"],
            Self::BoardOnMesh => vec!["workpiece.board.thickness", "workpiece.mesh"],
            Self::NailAboveRod { .. } => vec!["nail.feed_height", "piston.rod_protrusion", "piston.stroke"],
            Self::Order { small, large, .. } => [keys_of(small), keys_of(large)].concat(),
            Self::LumpedShares { .. } => vec!["body.lumped_nose", "body.lumped_magazine"],
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
            Self::NotPlaneWaves { key, .. } => vec![key, "exhaust.muffler.kind", "analysis.exhaust_max_frequency"],
            Self::InsertionLossRange { key, .. } => vec![key, "exhaust.muffler.kind"],
            Self::LiningRange { .. } => vec!["exhaust.muffler.lining_resistivity", "analysis.exhaust_max_frequency"],
            Self::NotCarried { key, .. } => vec![key],
            Self::MufflerArea { .. } => vec!["exhaust.muffler.flow_area", "exhaust.muffler.tail_diameter"],
            Self::MicrophonesInSand { .. } => vec!["support.sand.box_depth", "support.sand.measurement_plane"],
            Self::FittingAndMuffler => vec!["exhaust.fitting.kind", "exhaust.muffler.kind"],
            Self::Cover { key, .. } => vec!["body.cover.surfaces", key],
            Self::HeatCapacityRatio { .. } => vec!["ambient.heat_capacity_ratio"],
            Self::EmptyRange { .. } => vec!["analysis.range_low", "analysis.range_high"],
            Self::TimeStep { .. } => vec![
                "analysis.time_step",
                "analysis.range_high",
                "analysis.exhaust_max_frequency",
            ],
            Self::Duration { short, long, .. } => vec![short, long],
        }
    }

    /// The remedy.
    pub fn remedy(&self) -> String {
        match self {
            Self::NailLongerThanBlock { groove, .. } if *groove > 0.0 => "shorten `nail.length`, lower \
                `workpiece.groove` or raise `workpiece.thickness`: the point must stay in the wood"
                .to_owned(),
            Self::NailLongerThanBlock { .. } => {
                "shorten `nail.length` or raise `workpiece.thickness`: the point must stay in the wood".to_owned()
            }
            Self::ElasticTwoWay => "set `support.coupling = \"one-way\"`, or `model.blow = \"rigid\"`".to_owned(),
            Self::BoardOnMesh => "set `workpiece.board.thickness` to 0, or remove `workpiece.mesh`".to_owned(),
            Self::NailAboveRod { .. } => {
                "lower `nail.feed_height` or `piston.rod_protrusion`, or raise `piston.stroke`: the rod \
                                          begins above the nail's head"
                    .to_owned()
            }
            Self::Order {
                small, large, because, ..
            } => {
                let [small, large] = [small, large].map(|length| keys_of(length)[0]);
                format!("{because}: lower `{small}` or raise `{large}`")
            }
            Self::LumpedShares { .. } => {
                "lower one of them; what nose and magazine leave of the lumped mass rests on the sleeve's seat"
                    .to_owned()
            }
            Self::SpringBeyondLaw { .. } => {
                "lower `head_valve.lift` or `head_valve.spring_preload`; beyond 5 mm the printed polynomial falls"
                    .to_owned()
            }
            Self::Friction { group, .. } => format!("raise `{group}.static_force` or lower `{group}.sliding_force`"),
            Self::NotSeated { .. } => {
                "raise `hand.force`, or lower `contacts.guard_travel` or `contacts.guard_stiffness`".to_owned()
            }
            Self::NotElastic { group, .. } => {
                format!("lower the Poisson's ratios of `{group}`: nu_ij^2 < E_i/E_j must hold for each pair of axes")
            }
            Self::Incompressible { key, .. } => format!("give `{key}` a value below 0.5"),
            Self::SupplyBelowAmbient { .. } => {
                "give `supply.pressure` as absolute pressure, or with a gauge unit such as psig or barg".to_owned()
            }
            Self::NotPlaneWaves { key, highest, .. } => format!(
                "narrow `{key}`, lower `analysis.exhaust_max_frequency` to {:.0} Hz and `analysis.range_high` with it, \
                 or give the measured insertion loss: `exhaust.muffler.kind = \"insertion_loss\"`",
                highest.floor()
            ),
            Self::InsertionLossRange { key, value, range } => {
                let (change, limit) = if *value < range[0] {
                    ("raise", range[0].ceil())
                } else {
                    ("lower", range[1].floor())
                };
                format!("{change} `{key}` to {limit:.0} Hz")
            }
            Self::LiningRange { resistivity, .. } => format!(
                "raise `exhaust.muffler.lining_resistivity`, lower `analysis.exhaust_max_frequency` to {:.0} Hz, or \
                 set \
                 `exhaust.muffler.lining_thickness` to 0 for a bare pipe",
                resistivity.floor()
            ),
            Self::MufflerArea { .. } => {
                "lower `exhaust.muffler.flow_area` or widen `exhaust.muffler.tail_diameter`".to_owned()
            }
            Self::FittingAndMuffler => {
                "choose one: `exhaust.fitting.kind = \"none\"` or `exhaust.muffler.kind = \"none\"`".to_owned()
            }
            Self::Cover { key, allowed, .. } => {
                format!("set `{key}` to {allowed}, or `body.cover.surfaces = \"none\"`")
            }
            Self::MicrophonesInSand { .. } => {
                "lower `support.sand.box_depth`, or choose `support.sand.measurement_plane = \"sand\"`".to_owned()
            }
            Self::NotCarried { body, .. } => format!(
                "name its springs: [springs.NAME] with body = \"{}\", x, y, z, and stiffness and damping along each \
                 axis",
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
