//! Drawings as SVG: hatched sections, dimension lines, leader lines and labels.
//!
//! Every key is a focusable group with a title, so that pointer, keyboard and screen reader give access to value and
//! provenance without a script.

use maud::{Markup, PreEscaped, html};

use super::shape::{Chamber, Line, LineStyle, Mark, Material, Outline, Point, Side};
use super::sheet::{KEY_TYPE, MARGIN, MM, Placed, Sheet, VALUE_TYPE, WIDTH, value_line};
use super::standing::Standing;
use super::{Drawing, STYLE};

impl Drawing {
    /// All views, one below the other, as one SVG file.
    pub fn svg(&self) -> String {
        file(self, &[])
    }

    /// The views with these names, one below the other, as one SVG file.
    pub fn svg_of(&self, names: &[&str]) -> String {
        file(self, names)
    }

    /// The views as figures for a page that contains [`STYLE`], with their titles.
    pub(crate) fn figures(&self) -> Vec<(String, Markup)> {
        self.sheets()
            .iter()
            .map(|sheet| (sheet.view.title.clone(), figure(sheet)))
            .collect()
    }

    /// The legend of provenances.
    pub(crate) fn legend(&self) -> Vec<(Standing, Markup)> {
        let mut standings: Vec<Standing> = self.shown().iter().map(|label| label.standing).collect();
        standings.sort();
        standings.dedup();
        standings.into_iter().map(|own| (own, sample(own))).collect()
    }
}

/// Gap between the views of a file.
const BETWEEN: f64 = 26.0;
/// Length and half width of an arrow head.
const ARROW: [f64; 2] = [7.0, 1.9];
/// Radius of a dot.
const DOT: f64 = 2.1;

/// SVG file with the views of these names, one below the other. Without names, it contains all views and the list of
/// misfits.
pub(super) fn file(drawing: &Drawing, names: &[&str]) -> String {
    let chosen = |sheet: &Sheet<'_>| names.is_empty() || names.contains(&sheet.view.name);
    let sheets: Vec<Sheet<'_>> = drawing.sheets().into_iter().filter(chosen).collect();
    let head = 58.0 + 18.0 * drawing.legend().len().div_ceil(3) as f64;
    let mut tops = vec![head];
    for sheet in &sheets {
        tops.push(tops.last().copied().unwrap_or(head) + sheet.size[1] + BETWEEN);
    }
    let misfits = drawing.misfits.iter().filter(|_| names.is_empty());
    let notes = misfits.map(|misfit| wrapped(&misfit.text)).collect::<Vec<_>>();
    let lines: usize = notes.iter().map(Vec::len).sum();
    let foot = tops.last().copied().unwrap_or(head);
    let height = foot + if lines > 0 { 30.0 + 16.0 * lines as f64 } else { 4.0 };
    let mut y = foot + 36.0;
    let mut placed = Vec::new();
    for note in &notes {
        for (index, line) in note.iter().enumerate() {
            placed.push((y, index == 0, line));
            y += 16.0;
        }
    }
    let view_box = format!("0 0 {WIDTH} {height:.0}");
    let markup = html! {
        svg class="drawing" xmlns="http://www.w3.org/2000/svg" viewBox=(view_box) width={ (WIDTH / MM) "mm" }
            height={ (format!("{:.1}", height / MM)) "mm" } {
            title { "Drawing of the tool: " (drawing.name) }
            desc { "Section, details, housing and support at the dimensions of the design. Each key is a group with \
                its value and provenance." }
            style { (PreEscaped(STYLE)) }
            rect.sheet width=(WIDTH) height=(format!("{height:.0}")) {}
            text.name x=(MARGIN) y="24" { (drawing.name) }
            text.note x=(MARGIN) y="44" { "Scales apply at a width of " (WIDTH / MM) " mm. Point at a key, or use the \
                Tab key, for range and source." @if drawing.is_based() { " Italics: from the base of the design." } }
            @for (index, (standing, symbol)) in drawing.legend().into_iter().enumerate() {
                g transform={ "translate(" (MARGIN + 6.0 + 290.0 * (index % 3) as f64) " "
                    (62.0 + 18.0 * (index / 3) as f64) ")" } {
                    (symbol)
                    text.note x="12" y="4" { (standing.words()) }
                }
            }
            @for (sheet, top) in sheets.iter().zip(&tops) {
                g transform={ "translate(0 " (format!("{top:.0}")) ")" } { (content(sheet, true)) }
            }
            @if !placed.is_empty() {
                text.title x=(MARGIN) y=(format!("{:.0}", foot + 14.0)) { "Keys that do not fit together as drawn" }
                @for (y, first, line) in &placed {
                    text.note x=(MARGIN + if *first { 0.0 } else { 12.0 })
                        y=(format!("{y:.0}")) { @if *first { "\u{2022} " } (line) }
                }
            }
        }
    };
    format!("{}\n", markup.into_string())
}

/// Wraps a text to lines of at most 140 characters.
fn wrapped(text: &str) -> Vec<String> {
    let mut lines = vec![String::new()];
    for word in text.split_whitespace() {
        match lines.last_mut() {
            Some(line) if line.is_empty() => line.push_str(word),
            Some(line) if line.chars().count() + word.chars().count() < 140 => {
                line.push(' ');
                line.push_str(word);
            }
            _ => lines.push(word.to_owned()),
        }
    }
    lines
}

/// A view as a figure of a page.
pub(super) fn figure(sheet: &Sheet<'_>) -> Markup {
    let [width, height] = sheet.size;
    html! {
        svg class="drawing" viewBox={ "0 0 " (width) " " (format!("{height:.0}")) } role="group"
            aria-label=(sheet.view.title) {
            (content(sheet, false))
        }
    }
}

/// The symbol of a class of provenance, with its line.
pub(super) fn sample(standing: Standing) -> Markup {
    html! { path class={ "symbol " (standing.class()) } d=(standing.symbol()) {} }
}

/// The content of a sheet. On a page, the heading is part of the page.
fn content(sheet: &Sheet<'_>, heading: bool) -> Markup {
    let view = sheet.view;
    let p = &sheet.picture;
    let clip = format!("d-{}-window", view.name);
    html! {
        defs {
            (hatchings(view.name))
            @if view.window.is_some() {
                clipPath id=(clip) { rect x=(n(p.x[0])) y=(n(p.y[0])) width=(n(p.x[1] - p.x[0]))
                    height=(n(p.y[1] - p.y[0])) {} }
            }
        }
        @if heading { text.title x=(MARGIN) y="16" { (view.title) } }
        text.scale x=(WIDTH - MARGIN) y="16" text-anchor="end" { "scale " (sheet.scale_words()) }
        g clip-path=[view.window.map(|_| format!("url(#{clip})"))] {
            @for part in &view.parts {
                path class={ "part " (material_class(part.material)) }
                    style=[fill(view.name, part.material)] d=(outlines(sheet, &part.outlines)) {
                    title { (part.name) }
                }
            }
            @for line in &view.lines { path class={ "line " (style_class(line)) }
                d=(polyline(sheet, &line.points, false)) {} }
        }
        @if view.window.is_some() { rect.window x=(n(p.x[0])) y=(n(p.y[0])) width=(n(p.x[1] - p.x[0]))
            height=(n(p.y[1] - p.y[0])) {} }
        @for (letter, window) in &view.details {
            @let [x0, y0] = sheet.at([window.low[0], window.high[1]]);
            @let [x1, y1] = sheet.at([window.high[0], window.low[1]]);
            rect.detail x=(n(x0)) y=(n(y0)) width=(n(x1 - x0)) height=(n(y1 - y0)) rx="3" {}
            text.letter x=(n(x1 + 3.0)) y=(n(y1 - 1.0)) { (letter) }
        }
        @for placed in &sheet.labels { (key(sheet, placed)) }
        (scale_bar(sheet))
    }
}

/// A key: its marks in the view, the leader line and the label.
fn key(sheet: &Sheet<'_>, placed: &Placed<'_>) -> Markup {
    let (label, annotation) = (placed.label, placed.annotation);
    let left = annotation.side == Side::Left;
    let [x, y] = placed.port;
    let anchor = sheet.at(annotation.anchor);
    let knee = placed.knee[0];
    let leader = format!("M{} {}H{}L{} {}", n(x), n(y), n(knee), n(anchor[0]), n(anchor[1]));
    let marks: String = annotation.marks.iter().map(|mark| drawn(sheet, mark)).collect();
    let areas: String = annotation.marks.iter().map(|mark| area(sheet, mark)).collect();
    let (symbol, text) = if left { (x - 6.0, x - 14.0) } else { (x + 6.0, x + 14.0) };
    let end = if left { "end" } else { "start" };
    html! {
        g class={ "key " (label.standing.class()) @if label.inherited { " inherited" } } data-key=(label.key)
            tabindex="0" role="img" aria-label=(label.title) {
            title { (label.title) }
            @if !areas.is_empty() { path.meant d=(areas) {} }
            path.leader d=(leader) {}
            @if !marks.is_empty() { path.dimension d=(marks) {} }
            path.target d={ (leader) (marks) } {}
            rect.target x=(n(placed.area.x[0])) y=(n(placed.area.y[0])) width=(n(placed.area.x[1] - placed.area.x[0]))
                height=(n(placed.area.y[1] - placed.area.y[0])) {}
            path class={ "symbol " (label.standing.class()) } transform={ "translate(" (n(symbol)) " " (n(y)) ")" }
                d=(label.standing.symbol()) {}
            text.key-name x=(n(text)) y=(n(y - 2.0)) text-anchor=(end) font-size=(KEY_TYPE) { (label.key) }
            text.value x=(n(text)) y=(n(y + 11.0)) text-anchor=(end)
                font-size=(VALUE_TYPE) { (with_subscripts(&value_line(label))) }
        }
    }
}

/// Text with subscripts: an underscore starts a subscript that ends at the next blank.
fn with_subscripts(text: &str) -> Markup {
    let words: Vec<(&str, Option<&str>)> = text
        .split(' ')
        .map(|word| {
            word.split_once('_')
                .map_or((word, None), |(base, below)| (base, Some(below)))
        })
        .collect();
    html! {
        @for (index, (base, below)) in words.into_iter().enumerate() {
            @if index > 0 { " " }
            (greek(base))
            @if let Some(below) = below { tspan dy="3" font-size="8.5" { (below) } tspan dy="-3" { "\u{200b}" } }
        }
    }
}

fn greek(word: &str) -> &str {
    match word {
        "theta" => "\u{3b8}",
        "rho" => "\u{3c1}",
        "pi" => "\u{3c0}",
        other => other,
    }
}

/// A number on the sheet.
fn n(value: f64) -> String {
    let text = format!("{value:.1}");
    text.strip_suffix(".0").map_or(text.clone(), str::to_owned)
}

fn polyline(sheet: &Sheet<'_>, points: &[Point], closed: bool) -> String {
    let mut path = String::new();
    for (index, point) in points.iter().enumerate() {
        let [x, y] = sheet.at(*point);
        path.push_str(&format!("{}{} {}", if index == 0 { "M" } else { "L" }, n2(x), n2(y)));
    }
    if closed {
        path.push('z');
    }
    path
}

/// A number on the sheet to a hundredth of a unit, so that thin walls are not lost to rounding.
fn n2(value: f64) -> String {
    crate::wording::trimmed(value, 2)
}

fn outlines(sheet: &Sheet<'_>, outlines: &[Outline]) -> String {
    let outline = |outline: &Outline| match outline {
        Outline::Polygon(points) => polyline(sheet, points, true),
        Outline::Circle { centre, radius } => {
            let [x, y] = sheet.at(*centre);
            let r = radius * sheet.scale * 1e3 * MM;
            format!(
                "M{} {}a{r} {r} 0 1 0 {d} 0a{r} {r} 0 1 0 -{d} 0z",
                n2(x - r),
                n2(y),
                r = n2(r),
                d = n2(2.0 * r)
            )
        }
    };
    outlines.iter().map(outline).collect()
}

/// The area of a mark; empty for other marks.
fn area(sheet: &Sheet<'_>, mark: &Mark) -> String {
    match mark {
        Mark::Area(points) => polyline(sheet, points, true),
        _ => String::new(),
    }
}

/// A mark as lines.
fn drawn(sheet: &Sheet<'_>, mark: &Mark) -> String {
    match mark {
        Mark::Span([a, b]) => span([sheet.at(*a), sheet.at(*b)]),
        Mark::HalfSpan([a, b]) => {
            let [a, b] = [sheet.at(*a), sheet.at(*b)];
            format!(
                "M{} {}L{} {}{}",
                n(a[0]),
                n(a[1]),
                n2(b[0]),
                n2(b[1]),
                arrow(b, direction(a, b))
            )
        }
        Mark::Extension([a, b]) => {
            let [a, b] = [sheet.at(*a), sheet.at(*b)];
            if (a[0] - b[0]).hypot(a[1] - b[1]) < 1.0 {
                // If the length is measured at the edge itself, a short stroke ends the dimension line.
                return String::new();
            }
            let [u, v] = direction(a, b);
            // The extension line goes slightly beyond the dimension line.
            format!(
                "M{} {}L{} {}",
                n2(a[0]),
                n2(a[1]),
                n2(b[0] + 4.0 * u),
                n2(b[1] + 4.0 * v)
            )
        }
        Mark::Dot(at) => {
            let [x, y] = sheet.at(*at);
            format!(
                "M{} {}a{DOT} {DOT} 0 1 0 {d} 0a{DOT} {DOT} 0 1 0 -{d} 0z",
                n(x - DOT),
                n(y),
                d = 2.0 * DOT
            )
        }
        Mark::Path(points) => {
            // A path is a line, not an area, so it returns along itself.
            let mut there = points.clone();
            there.extend(points.iter().rev().skip(1));
            polyline(sheet, &there, false)
        }
        Mark::Area(_) => String::new(),
    }
}

fn direction(a: Point, b: Point) -> Point {
    let length = (b[0] - a[0]).hypot(b[1] - a[1]).max(1e-9);
    [(b[0] - a[0]) / length, (b[1] - a[1]) / length]
}

/// A dimension line with arrows: inside if there is room, otherwise outside.
fn span([a, b]: [Point; 2]) -> String {
    let [u, v] = direction(a, b);
    let length = (b[0] - a[0]).hypot(b[1] - a[1]);
    let line = |from: Point, to: Point| format!("M{} {}L{} {}", n2(from[0]), n2(from[1]), n2(to[0]), n2(to[1]));
    if length >= 3.0 * ARROW[0] {
        return line(a, b) + &arrow(a, [-u, -v]) + &arrow(b, [u, v]);
    }
    let out = 2.0 * ARROW[0];
    line([a[0] - out * u, a[1] - out * v], [b[0] + out * u, b[1] + out * v]) + &arrow(a, [u, v]) + &arrow(b, [-u, -v])
}

/// The head of an arrow at a point.
fn arrow([x, y]: Point, [u, v]: Point) -> String {
    let [length, half] = ARROW;
    let back = [x - length * u, y - length * v];
    format!(
        "M{} {}L{} {}L{} {}z",
        n2(x),
        n2(y),
        n2(back[0] - half * v),
        n2(back[1] + half * u),
        n2(back[0] + half * v),
        n2(back[1] - half * u)
    )
}

/// A bar with a round length at the lower left of a sheet.
fn scale_bar(sheet: &Sheet<'_>) -> Markup {
    let units = sheet.scale * MM;
    let lengths = (-3..=4).flat_map(|decade| [1.0, 2.0, 5.0].map(|step| step * 10f64.powi(decade)));
    let length = lengths
        .filter(|mm| mm * units <= 130.0)
        .fold(f64::MIN_POSITIVE, f64::max);
    let [x, y] = [MARGIN, sheet.size[1] - 22.0];
    let end = x + length * units;
    let step = 0.2 * (end - x);
    html! {
        g.bar {
            @for k in 0..5u8 {
                rect class=(if k % 2 == 0 { "dark" } else { "light" }) x=(n2(x + f64::from(k) * step)) y=(n(y))
                    width=(n2(step)) height="4" {}
            }
            text.note x=(n(x)) y=(n(y + 16.0)) { "0" }
            text.note x=(n(end)) y=(n(y + 16.0)) text-anchor="middle" { (crate::wording::rounded(length, 3, 1e6))
                " mm" }
        }
    }
}

fn material_class(material: Material) -> &'static str {
    match material {
        Material::Housing => "housing",
        Material::Mechanism => "mechanism",
        Material::Steel => "steel",
        Material::Solid => "solid",
        Material::Rubber => "rubber",
        Material::Wood => "wood",
        Material::Plywood => "plywood",
        Material::Sand => "sand",
        Material::Floor => "floor",
        Material::Opening => "opening",
        Material::Gas(Chamber::AbovePiston) => "gas above",
        Material::Gas(Chamber::BelowPiston) => "gas below",
        Material::Gas(Chamber::Return) => "gas return",
        Material::Gas(Chamber::AboveValve) => "gas control",
        Material::Gas(Chamber::Supply) => "gas supply",
        Material::Gas(Chamber::Plenum) => "gas plenum",
    }
}

fn style_class(line: &Line) -> &'static str {
    match line.style {
        LineStyle::Centre => "centre",
        LineStyle::Phantom => "phantom",
        LineStyle::Hidden => "hidden",
        LineStyle::Edge => "edge",
        LineStyle::Break => "break",
    }
}

/// The hatching of a material; `None` if its class has a plain colour.
fn fill(view: &str, material: Material) -> Option<String> {
    let hatched = matches!(
        material,
        Material::Housing
            | Material::Mechanism
            | Material::Steel
            | Material::Rubber
            | Material::Wood
            | Material::Plywood
            | Material::Sand
            | Material::Floor
    );
    hatched.then(|| format!("fill:url(#d-{view}-{})", material_class(material)))
}

/// The hatching patterns, with the view's name in their names, because a page has several drawings.
fn hatchings(view: &str) -> Markup {
    let pattern = |name: &str, size: [f64; 2], turned: f64, strokes: &str| {
        html! {
            pattern id={ "d-" (view) "-" (name) } width=(size[0]) height=(size[1]) patternUnits="userSpaceOnUse"
                patternTransform={ "rotate(" (turned) ")" } {
                rect class={ "ground " (name) } width=(size[0]) height=(size[1]) {}
                path.hatch d=(strokes) {}
            }
        }
    };
    html! {
        (pattern("housing", [5.0, 5.0], 45.0, "M0 0V5"))
        (pattern("mechanism", [4.0, 4.0], -45.0, "M0 0V4"))
        (pattern("steel", [5.0, 5.0], -45.0, "M0 0V5M1.6 0V5"))
        (pattern("rubber", [3.4, 3.4], 45.0, "M0 0V3.4M0 0H3.4"))
        (pattern("wood", [46.0, 16.0], 0.0, "M0 3C12 1 30 5 46 3M0 8.5C16 10 28 6.5 46 8.5M0 13.5C10 14.5 34 12 46 \
            13.5"))
        (pattern("plywood", [12.0, 6.0], 0.0, "M0 1.5H12M0 4.5H5M8 4.5H12"))
        (pattern("sand", [13.0, 11.0], 0.0, "M1 2h1M6 5h1M10 1h1M3 8h1M9 9h1M12 6h.8"))
        (pattern("floor", [7.0, 7.0], 45.0, "M0 0V7"))
    }
}
