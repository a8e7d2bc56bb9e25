//! The network of an assembly as a diagram.
//!
//! Every space, body and trigger is a column; every passage, face, contact, spring, friction, force and fastener is a
//! row that connects the columns of its two ends. No two rows cross, so that the diagram stays legible for any number
//! of blocks.

use maud::{Markup, PreEscaped, html};
use nailnoise_dynamics::network::assembly::{
    Assembly, Base, ForceLaw, Opens, Passage, Push, Space, SpringLaw, Stop, Trigger, Word,
};

/// Width of the diagram \[px\].
const WIDTH: f64 = 1200.0;
/// Width of the text to the left of the rows \[px\].
const TEXT: f64 = 310.0;
/// Height of the columns' heads \[px\].
const HEAD: f64 = 96.0;
/// Height of a row \[px\].
const ROW: f64 = 24.0;
/// Height of a heading between rows \[px\].
const HEADING: f64 = 34.0;

/// Style of the diagram; its selectors name its class, because a page shows it next to other charts.
const STYLE: &str = include_str!("network.css");

/// The block that a column represents.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Column {
    Reservoir(usize),
    Volume(usize),
    Ground,
    Body(usize),
    Trigger(usize),
}

/// How the link of a row is drawn.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Mark {
    /// A flow; one way with an arrow.
    Flow { one_way: bool, makes_noise: bool },
    /// A face of a body.
    Face,
    /// A stop.
    Contact,
    /// A zigzag.
    Spring,
    /// Two lines.
    Friction,
    /// An arrow that acts on its second end.
    Force,
    /// A fastener.
    Fastener,
}

impl Mark {
    fn class(self) -> &'static str {
        match self {
            Self::Flow { .. } => "passage",
            Self::Face => "face",
            Self::Fastener => "fastener",
            Self::Contact | Self::Spring | Self::Friction | Self::Force => "force",
        }
    }
}

/// A row of the diagram.
struct Row {
    name: String,
    what: String,
    ends: [Column; 2],
    mark: Mark,
    /// Columns that switch it: bodies whose travel opens it, and triggers.
    switched_by: Vec<Column>,
}

/// Rows under a heading.
struct Section {
    heading: &'static str,
    rows: Vec<Row>,
}

/// The diagram as an SVG file, 1200 px wide.
pub(crate) fn svg(tool: &str, assembly: &Assembly) -> String {
    let diagram = Diagram::new(assembly);
    let height = diagram.height();
    let counts = [
        (assembly.volumes.len(), "volume", "volumes"),
        (assembly.passages.len(), "passage", "passages"),
        (assembly.bodies.len(), "moving body", "moving bodies"),
        (assembly.triggers.len(), "trigger", "triggers"),
    ];
    let counts = counts.map(|(number, one, many)| format!("{number} {}", if number == 1 { one } else { many }));
    let markup = html! {
        svg.network xmlns="http://www.w3.org/2000/svg" viewBox=(format!("0 0 {WIDTH} {height:.0}")) width=(WIDTH)
            height=(format!("{height:.0}")) {
            title { "Network of " (tool) }
            desc { "Spaces, bodies and triggers are columns; passages, faces and forces are rows between them." }
            style { (PreEscaped(STYLE)) }
            rect width=(WIDTH) height=(format!("{height:.0}")) fill="#fff" {}
            text.title x="16" y="30" { (tool) ": assembly " (assembly.name) }
            text.quiet x="16" y="50" { (counts.join(", ")) }
            (diagram.markup())
        }
    };
    markup.into_string()
}

struct Diagram<'a> {
    assembly: &'a Assembly,
    columns: Vec<Column>,
    sections: Vec<Section>,
    triggers: Vec<String>,
}

impl<'a> Diagram<'a> {
    fn new(assembly: &'a Assembly) -> Self {
        let rows = Rows(assembly);
        let sections: Vec<Section> = [
            ("Passages", rows.passages()),
            ("Gas on bodies", rows.faces()),
            ("Contacts", rows.contacts()),
            ("Springs, friction, forces", rows.forces()),
            ("Fasteners", rows.fasteners()),
        ]
        .into_iter()
        .filter(|(_, rows)| !rows.is_empty())
        .map(|(heading, rows)| Section { heading, rows })
        .collect();
        let used = |column: Column| {
            let mut rows = sections.iter().flat_map(|section| &section.rows);
            rows.any(|row| row.ends.contains(&column) || row.switched_by.contains(&column))
        };
        let all = (0..assembly.reservoirs.len()).map(Column::Reservoir);
        let all = all.chain((0..assembly.volumes.len()).map(Column::Volume));
        let all = all.chain((0..assembly.bodies.len()).map(Column::Body));
        let all = all.chain([Column::Ground]);
        let all = all.chain((0..assembly.triggers.len()).map(Column::Trigger));
        Self {
            columns: all.filter(|column| used(*column)).collect(),
            triggers: assembly.triggers.iter().map(|own| rows.trigger(own)).collect(),
            sections,
            assembly,
        }
    }

    fn height(&self) -> f64 {
        let rows: usize = self.sections.iter().map(|section| section.rows.len()).sum();
        let lists = self.triggers.len() + self.assembly.events.len().min(1);
        let lists = if lists > 0 { HEADING + ROW * lists as f64 } else { 0.0 };
        60.0 + HEAD + HEADING * self.sections.len() as f64 + ROW * rows as f64 + lists + 24.0
    }

    /// Centre of a column \[px\].
    fn x(&self, column: Column) -> f64 {
        let place = self.columns.iter().position(|own| *own == column).unwrap_or(0);
        let width = self.column_width();
        TEXT + width * (place as f64 + 0.5)
    }

    fn column_width(&self) -> f64 {
        (WIDTH - TEXT - 12.0) / self.columns.len().max(1) as f64
    }

    fn markup(&self) -> Markup {
        let top = 60.0;
        let first = top + HEAD;
        let mut y = first;
        let mut rows = Vec::new();
        for section in &self.sections {
            y += HEADING;
            rows.push(html! { text.head x="16" y=(px(y - 10.0)) { (section.heading) } });
            for row in &section.rows {
                rows.push(self.row(row, y + 0.5 * ROW));
                y += ROW;
            }
        }
        let bottom = y + 4.0;
        let mut lists = Vec::new();
        if !self.triggers.is_empty() {
            y += HEADING;
            lists.push(html! { text.head x="16" y=(px(y - 10.0)) { "Triggers" } });
        }
        for trigger in &self.triggers {
            y += ROW;
            lists.push(html! { text x="16" y=(px(y - 8.0)) { (trigger) } });
        }
        html! {
            @for column in &self.columns {
                line.life x1=(px(self.x(*column))) x2=(px(self.x(*column))) y1=(px(first - 8.0)) y2=(px(bottom)) {}
                (self.head(*column, top))
            }
            @for row in &rows { (row) }
            @for line in &lists { (line) }
        }
    }

    fn head(&self, column: Column, top: f64) -> Markup {
        let a = self.assembly;
        let (class, name, lines) = match column {
            Column::Reservoir(i) => {
                let own = &a.reservoirs[i];
                ("reservoir", own.name.as_str(), vec![kilopascals(own.pressure)])
            }
            Column::Volume(i) => {
                let own = &a.volumes[i];
                let size = format!("{} cm3", significant(1e6 * own.dead));
                ("volume", own.name.as_str(), vec![size, kilopascals(own.pressure)])
            }
            Column::Ground => ("solid", "ground", Vec::new()),
            Column::Body(i) => {
                let own = &a.bodies[i];
                let mass = match own.mass {
                    mass if mass < 1.0 => format!("{} g", significant(1e3 * mass)),
                    mass => format!("{} kg", significant(mass)),
                };
                let parent = match own.parent {
                    Base::Ground => Vec::new(),
                    Base::Body(parent) => vec![format!("in {}", a.bodies[parent].name)],
                };
                ("solid", own.name.as_str(), [vec![mass], parent].concat())
            }
            Column::Trigger(i) => {
                let own = &a.triggers[i];
                let starts = if own.starts { "starts on" } else { "starts off" };
                ("trigger", own.name.as_str(), vec![starts.to_owned()])
            }
        };
        let width = self.column_width().min(112.0) - 6.0;
        let x = self.x(column);
        // Names are broken at underscores if the column is narrow.
        let letters = ((width - 6.0) / 6.6).max(4.0) as usize;
        let names = broken(name, letters);
        html! {
            rect class=(class) x=(px(x - 0.5 * width)) y=(px(top)) width=(px(width)) height=(px(HEAD - 12.0)) rx="5" {}
            @for (line, text) in names.iter().enumerate() {
                text.name x=(px(x)) y=(px(top + 16.0 + 14.0 * line as f64)) text-anchor="middle"
                    style=(fitted(text, width)) { (text) }
            }
            @for (line, text) in lines.iter().enumerate() {
                text.quiet x=(px(x)) y=(px(top + 18.0 + 14.0 * (names.len() + line) as f64)) text-anchor="middle"
                    style=(fitted(text, width)) { (text) }
            }
        }
    }

    fn row(&self, row: &Row, y: f64) -> Markup {
        let [from, to] = row.ends.map(|end| self.x(end));
        let class = row.mark.class();
        let direction = if to >= from { 1.0 } else { -1.0 };
        let middle = 0.5 * (from + to);
        html! {
            g {
                text x="16" y=(px(y + 4.0)) {
                    tspan.name { (row.name.replace('_', " ")) } " " tspan.quiet { (row.what) }
                }
                @for column in &row.switched_by {
                    @let x = self.x(*column);
                    @let near = if (x - from).abs() < (x - to).abs() { from } else { to };
                    line class=(if matches!(column, Column::Trigger(_)) { "gate dashed" } else { "force dashed" })
                        x1=(px(near)) x2=(px(x)) y1=(px(y)) y2=(px(y)) {}
                    @match column {
                        Column::Trigger(_) => path.gate d=(diamond(x, y)) {},
                        _ => circle.force cx=(px(x)) cy=(px(y)) r="3.4" fill-opacity="0" stroke-width="1.3" {},
                    }
                }
                @match row.mark {
                    Mark::Spring => path class={ (class) " link" } d=(zigzag(from, to, y)) {},
                    Mark::Friction => {
                        line class={ (class) " link" } x1=(px(from)) x2=(px(to)) y1=(px(y - 2.0)) y2=(px(y - 2.0)) {}
                        line class={ (class) " link" } x1=(px(from)) x2=(px(to)) y1=(px(y + 2.0)) y2=(px(y + 2.0)) {}
                    },
                    _ => line class={ (class) " link" } x1=(px(from)) x2=(px(to)) y1=(px(y)) y2=(px(y)) {},
                }
                @match row.mark {
                    Mark::Flow { one_way, makes_noise } => {
                        path class=(class) d=(bow_tie(middle, y)) {}
                        @if one_way { path class=(class) d=(arrow_head(to - direction * 4.0, y, direction)) {} }
                        @if makes_noise { path.sound d=(sound_symbol(to, y, direction)) {} }
                    },
                    Mark::Contact => path class={ (class) " link" } d=(stop(to, y, direction)) {},
                    Mark::Force | Mark::Face | Mark::Fastener => {
                        path class=(class) d=(arrow_head(to - direction * 2.0, y, direction)) {}
                    },
                    Mark::Spring | Mark::Friction => {},
                }
                circle class=(class) cx=(px(from)) cy=(px(y)) r="3" {}
                @if !matches!(row.mark, Mark::Contact) { circle class=(class) cx=(px(to)) cy=(px(y)) r="3" {} }
            }
        }
    }
}

/// Makes the rows of an assembly.
struct Rows<'a>(&'a Assembly);

impl Rows<'_> {
    fn passages(&self) -> Vec<Row> {
        let a = self.0;
        let row = |(index, passage): (usize, &Passage)| {
            let opening = a.openings.iter().find(|own| own.passage == index);
            let mut what: Vec<String> = passage.restrictions.iter().map(|own| area(&own.opens)).collect();
            if passage.one_way {
                what.push("one way".to_owned());
            }
            if let Some(gate) = &passage.gate {
                let trigger = &a.triggers[gate.trigger].name;
                what.push(format!(
                    "open {}{trigger}",
                    if gate.inverted { "unless " } else { "when " }
                ));
            }
            if let Some(opening) = opening {
                what.push(match opening.name == passage.name {
                    true => "opening".to_owned(),
                    false => format!("opening {}", opening.name.replace('_', " ")),
                });
            }
            let mut switched_by: Vec<Column> = Vec::new();
            for restriction in &passage.restrictions {
                if let Opens::Seat { body, .. } | Opens::Holes { body, .. } = restriction.opens {
                    switched_by.push(Column::Body(body));
                }
            }
            switched_by.extend(passage.gate.as_ref().map(|gate| Column::Trigger(gate.trigger)));
            Row {
                name: passage.name.clone(),
                what: what.join(", "),
                ends: [space(passage.from), space(passage.to)],
                mark: Mark::Flow {
                    one_way: passage.one_way,
                    makes_noise: opening.is_some(),
                },
                switched_by,
            }
        };
        a.passages.iter().enumerate().map(row).collect()
    }

    fn faces(&self) -> Vec<Row> {
        let faces = self.0.faces.iter();
        faces
            .map(|face| Row {
                name: face.name.clone(),
                what: format!("{} mm2 push {}", significant(1e6 * face.area), side(face.push)),
                ends: [space(face.gas), Column::Body(face.body)],
                mark: Mark::Face,
                switched_by: Vec::new(),
            })
            .collect()
    }

    fn contacts(&self) -> Vec<Row> {
        let contacts = self.0.contacts.iter();
        contacts
            .map(|own| Row {
                name: own.name.clone(),
                what: format!(
                    "{} stops at {} mm, {} N/mm",
                    if own.stop == Stop::Below { "down" } else { "up" },
                    significant(1e3 * own.at),
                    significant(1e-3 * own.stiffness)
                ),
                ends: [Column::Body(own.on), base(own.against)],
                mark: Mark::Contact,
                switched_by: Vec::new(),
            })
            .collect()
    }

    fn forces(&self) -> Vec<Row> {
        let a = self.0;
        let row = |name: &str, what: String, ends: [Column; 2], mark| Row {
            name: name.to_owned(),
            what,
            ends,
            mark,
            switched_by: Vec::new(),
        };
        let springs = a.springs.iter().map(|own| {
            let law = match &own.law {
                SpringLaw::Linear(stiffness) => format!("{} N/mm", significant(1e-3 * stiffness)),
                SpringLaw::Polynomial(_) => "polynomial".to_owned(),
            };
            let what = format!("pushes {}, {law}", side(own.push));
            row(&own.name, what, [base(own.against), Column::Body(own.on)], Mark::Spring)
        });
        let frictions = a.frictions.iter().map(|own| {
            let what = format!("{} N sliding", significant(own.sliding_force));
            row(
                &own.name,
                what,
                [base(own.against), Column::Body(own.on)],
                Mark::Friction,
            )
        });
        let forces = a.forces.iter().map(|own| {
            let what = match &own.law {
                ForceLaw::Constant(force) => format!("{} N down", significant(*force)),
                ForceLaw::Table(_) => "over time".to_owned(),
                ForceLaw::Jet { passage, .. } => format!("thrust of {}", a.passages[*passage].name),
            };
            row(&own.name, what, [base(own.against), Column::Body(own.on)], Mark::Force)
        });
        let motors = a.motors.iter().map(|own| Row {
            switched_by: vec![Column::Trigger(own.trigger)],
            ..row(
                &own.name,
                format!(
                    "motor {}, {} N stall, while {}",
                    side(own.push),
                    significant(own.stall),
                    a.triggers[own.trigger].name
                ),
                [base(own.against), Column::Body(own.on)],
                Mark::Force,
            )
        });
        let holds = a.holds.iter().map(|own| Row {
            switched_by: vec![Column::Trigger(own.trigger)],
            ..row(
                &own.name,
                format!("latch while {}", a.triggers[own.trigger].name),
                [base(own.against), Column::Body(own.on)],
                Mark::Spring,
            )
        });
        springs
            .chain(frictions)
            .chain(forces)
            .chain(motors)
            .chain(holds)
            .collect()
    }

    fn fasteners(&self) -> Vec<Row> {
        let fasteners = self.0.fasteners.iter();
        fasteners
            .map(|own| Row {
                name: own.name.clone(),
                what: format!(
                    "{} mm, {} g",
                    significant(1e3 * own.length),
                    significant(1e3 * own.mass)
                ),
                ends: [Column::Body(own.driver), base(own.into)],
                mark: Mark::Fastener,
                switched_by: Vec::new(),
            })
            .collect()
    }

    /// Description of a trigger.
    fn trigger(&self, own: &Trigger) -> String {
        let words = |words: &[Word]| {
            let word = |word: &Word| format!("{} {}", self.0.name_of(word.block), word.action.word());
            words.iter().map(word).collect::<Vec<_>>().join(" or ")
        };
        let mut parts = vec![if own.starts { "starts on" } else { "starts off" }.to_owned()];
        for (time, on) in &own.schedule {
            parts.push(format!(
                "{} at {} ms",
                if *on { "on" } else { "off" },
                significant(1e3 * time)
            ));
        }
        if !own.set.is_empty() {
            parts.push(format!("on when {}", words(&own.set)));
        }
        if !own.clear.is_empty() {
            parts.push(format!("off when {}", words(&own.clear)));
        }
        format!("{}: {}", own.name.replace('_', " "), parts.join(", "))
    }
}

fn space(space: Space) -> Column {
    match space {
        Space::Volume(index) => Column::Volume(index),
        Space::Reservoir(index) => Column::Reservoir(index),
    }
}

fn base(base: Base) -> Column {
    match base {
        Base::Ground => Column::Ground,
        Base::Body(index) => Column::Body(index),
    }
}

fn side(push: Push) -> &'static str {
    match push {
        Push::Down => "down",
        Push::Up => "up",
    }
}

fn area(opens: &Opens) -> String {
    let mm2 = |area: &f64| format!("{} mm2", significant(1e6 * area));
    match opens {
        Opens::Constant { area } => mm2(area),
        Opens::Seat { diameter, .. } => format!("seat {} mm", significant(1e3 * diameter)),
        Opens::Holes { area, .. } => format!("holes {}", mm2(area)),
        Opens::Ramp { area, time } => format!("{} in {} ms", mm2(area), significant(1e3 * time)),
    }
}

fn kilopascals(pressure: f64) -> String {
    format!("{} kPa", significant(1e-3 * pressure))
}

/// A number with up to four digits.
fn significant(value: f64) -> f64 {
    if value == 0.0 {
        return 0.0;
    }
    let digits = 3 - value.abs().log10().floor() as i32;
    let scale = 10f64.powi(digits);
    (value * scale).round() / scale
}

/// A name split into lines of limited length, at underscores if possible.
fn broken(name: &str, letters: usize) -> Vec<String> {
    let mut lines: Vec<String> = Vec::new();
    for word in name.split('_') {
        match lines.last_mut() {
            Some(line) if line.chars().count() + 1 + word.chars().count() <= letters => {
                line.push(' ');
                line.push_str(word);
            }
            _ => lines.push(word.to_owned()),
        }
    }
    lines
}

/// The size of a text that fits into a width \[px\], up to the common one.
fn fitted(text: &str, width: f64) -> String {
    let size = (width - 4.0) / (0.62 * text.chars().count().max(1) as f64);
    format!("font-size:{:.1}px", size.clamp(7.5, 12.0))
}

fn px(value: f64) -> String {
    format!("{value:.1}")
}

fn diamond(x: f64, y: f64) -> String {
    format!("M{:.1} {y:.1}l5 -5l5 5l-5 5z", x - 5.0)
}

fn bow_tie(x: f64, y: f64) -> String {
    format!("M{:.1} {:.1}v8l12 -8v8z", x - 6.0, y - 4.0)
}

fn arrow_head(x: f64, y: f64, direction: f64) -> String {
    format!("M{x:.1} {y:.1}l{:.1} -4v8z", -8.0 * direction)
}

fn stop(x: f64, y: f64, direction: f64) -> String {
    format!(
        "M{x:.1} {:.1}v12M{x:.1} {:.1}l{:.1} 4M{x:.1} {y:.1}l{:.1} 4",
        y - 6.0,
        y - 6.0,
        4.0 * direction,
        4.0 * direction
    )
}

fn sound_symbol(x: f64, y: f64, direction: f64) -> String {
    let arc = |radius: f64| {
        let (start, sweep) = (x + direction * radius * 0.7, if direction > 0.0 { 1 } else { 0 });
        format!(
            "M{start:.1} {:.1}A{radius:.1} {radius:.1} 0 0 {sweep} {start:.1} {:.1}",
            y - 0.7 * radius,
            y + 0.7 * radius
        )
    };
    [5.0, 8.0, 11.0].map(arc).concat()
}

fn zigzag(from: f64, to: f64, y: f64) -> String {
    let (first, last) = (from + 0.25 * (to - from), to - 0.25 * (to - from));
    let teeth: Vec<String> = (1..8)
        .map(|tooth| {
            let side = if tooth % 2 == 0 { -5.0 } else { 5.0 };
            format!(
                "L{:.1} {:.1}",
                first + (last - first) * f64::from(tooth) / 8.0,
                y + side
            )
        })
        .collect();
    format!(
        "M{from:.1} {y:.1}H{first:.1}{}L{last:.1} {y:.1}H{to:.1}",
        teeth.concat()
    )
}
