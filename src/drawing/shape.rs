//! The contents of a drawing: parts with a material, lines, and annotations that show the length of a key.
//!
//! Coordinates are in metres in the plane of a view: x to the right, z upwards. Shapes are independent of the renderer.

/// Coordinates x and z of a point in a view \[m\].
pub type Point = [f64; 2];

/// A closed outline.
#[derive(Debug, Clone, PartialEq)]
pub enum Outline {
    /// Corners in order.
    Polygon(Vec<Point>),
    /// A circle.
    Circle {
        /// Its centre.
        centre: Point,
        /// Its radius \[m\].
        radius: f64,
    },
}

/// Material of a part, which determines its hatching.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Material {
    /// Cut light alloy of the housing.
    Housing,
    /// Cut light alloy of cylinder, piston and head valve; hatched in the opposite direction.
    Mechanism,
    /// Cut steel.
    Steel,
    /// A shaft or a nail, which is not cut lengthwise by convention.
    Solid,
    /// Bumper and seals.
    Rubber,
    /// Wood, cut along the grain.
    Wood,
    /// A board on the wood, or the plywood of a table.
    Plywood,
    /// Sand.
    Sand,
    /// The floor.
    Floor,
    /// A volume of gas.
    Gas(Chamber),
    /// An opening seen along its axis.
    Opening,
}

/// A gas volume of the cycle.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Chamber {
    /// Above the piston.
    AbovePiston,
    /// Below the piston.
    BelowPiston,
    /// Around the cylinder, for the return stroke.
    Return,
    /// Above the head valve.
    AboveValve,
    /// Handle and cylinder jacket.
    Supply,
    /// Between head valve and exhaust holes.
    Plenum,
}

/// A part of a view: the area within its outlines; an outline inside another is a hole.
#[derive(Debug, Clone, PartialEq)]
pub struct Part {
    /// Name for screen readers.
    pub name: &'static str,
    /// Its material.
    pub material: Material,
    /// Its outlines.
    pub outlines: Vec<Outline>,
}

impl Part {
    /// A part bounded by polygons.
    pub(crate) fn new(name: &'static str, material: Material, polygons: Vec<Vec<Point>>) -> Self {
        Self {
            name,
            material,
            outlines: polygons.into_iter().map(Outline::Polygon).collect(),
        }
    }

    /// Volume of the solid of revolution about x = 0 \[m3\], if half of the part lies on each side: 2 pi times the
    /// first moment of the half with x > 0 (Pappus). Circles are ignored.
    pub fn volume_of_revolution(&self) -> f64 {
        let moment = |polygon: &Vec<Point>| {
            // First moment of area of |x| about x = 0; both sides of the axis contribute, hence the factor of one half.
            let right: Vec<Point> = clip_right(polygon);
            let edges = right.iter().zip(right.iter().cycle().skip(1));
            edges
                .map(|([x0, z0], [x1, z1])| (x0 + x1) * (x0 * z1 - x1 * z0) / 6.0)
                .sum::<f64>()
                .abs()
        };
        let mut moments: Vec<f64> = self
            .outlines
            .iter()
            .filter_map(|outline| match outline {
                Outline::Polygon(polygon) => Some(moment(polygon)),
                Outline::Circle { .. } => None,
            })
            .collect();
        // Outermost outline first, then its holes.
        moments.sort_by(|a, b| b.total_cmp(a));
        let holes: f64 = moments.iter().skip(1).sum();
        std::f64::consts::TAU * (moments.first().copied().unwrap_or(0.0) - holes)
    }
}

/// The part of a polygon with x > 0 (Sutherland and Hodgman 1974).
fn clip_right(polygon: &[Point]) -> Vec<Point> {
    let mut right = Vec::new();
    for (a, b) in polygon.iter().zip(polygon.iter().cycle().skip(1)) {
        if a[0] >= 0.0 {
            right.push(*a);
        }
        if (a[0] < 0.0) != (b[0] < 0.0) {
            let share = a[0] / (a[0] - b[0]);
            right.push([0.0, a[1] + share * (b[1] - a[1])]);
        }
    }
    right
}

/// A line that belongs to no outline.
#[derive(Debug, Clone, PartialEq)]
pub struct Line {
    /// Its style.
    pub style: LineStyle,
    /// Its points.
    pub points: Vec<Point>,
}

/// Line types of ISO 128-2.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum LineStyle {
    /// Axis: long-dashed dotted.
    Centre,
    /// Opposite end of a movement: long-dashed double-dotted.
    Phantom,
    /// Edge hidden behind a part, or a schematic route: dashed.
    Hidden,
    /// Visible edge.
    Edge,
    /// Break line of a part.
    Break,
}

/// How an annotation shows its length in the view.
#[derive(Debug, Clone, PartialEq)]
pub enum Mark {
    /// A dimension line with an arrow at each end.
    Span([Point; 2]),
    /// A dimension line whose first end is outside the view, with an arrow at the second end.
    HalfSpan([Point; 2]),
    /// An extension line.
    Extension([Point; 2]),
    /// A dot on the item.
    Dot(Point),
    /// The area to highlight.
    Area(Vec<Point>),
    /// A path along which the length is measured.
    Path(Vec<Point>),
}

/// The column in which a label is placed.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Side {
    /// Left of the view.
    Left,
    /// Right of the view.
    Right,
}

/// A key of the design at its place in the view.
#[derive(Debug, Clone, PartialEq)]
pub struct Annotation {
    /// Full name of the key.
    pub key: &'static str,
    /// Its marks.
    pub marks: Vec<Mark>,
    /// Start of the leader line to its label.
    pub anchor: Point,
    /// Column of its label.
    pub side: Side,
}

impl Annotation {
    fn new(key: &'static str, side: Side, anchor: Point, marks: Vec<Mark>) -> Self {
        Self {
            key,
            marks,
            anchor,
            side,
        }
    }

    /// A dot on the item to which the key belongs.
    pub(crate) fn dot(key: &'static str, side: Side, at: Point) -> Self {
        Self::new(key, side, at, vec![Mark::Dot(at)])
    }

    /// A dot in an area that is highlighted together with it.
    pub(super) fn area(key: &'static str, side: Side, at: Point, area: Vec<Point>) -> Self {
        Self::new(key, side, at, vec![Mark::Area(area), Mark::Dot(at)])
    }

    /// A horizontal dimension line at the height z between two abscissas, with extension lines from the measured
    /// heights `from`.
    pub(crate) fn across(key: &'static str, side: Side, [a, b]: [f64; 2], z: f64, from: [f64; 2]) -> Self {
        let marks = vec![
            Mark::Span([[a, z], [b, z]]),
            Mark::Extension([[a, from[0]], [a, z]]),
            Mark::Extension([[b, from[1]], [b, z]]),
        ];
        let end = if side == Side::Left { a.min(b) } else { a.max(b) };
        Self::new(key, side, [end, z], marks)
    }

    /// A vertical dimension line at the abscissa x between two heights, with extension lines from the measured
    /// abscissas `from`.
    pub(crate) fn upright(key: &'static str, side: Side, [a, b]: [f64; 2], x: f64, from: [f64; 2]) -> Self {
        let marks = vec![
            Mark::Span([[x, a], [x, b]]),
            Mark::Extension([[from[0], a], [x, a]]),
            Mark::Extension([[from[1], b], [x, b]]),
        ];
        Self::new(key, side, [x, 0.5 * (a + b)], marks)
    }

    /// A diameter in a view that does not show the axis: the dimension line starts at the abscissa `left`.
    pub(super) fn diameter(key: &'static str, side: Side, left: f64, radius: f64, z: f64, from: f64) -> Self {
        let marks = vec![
            Mark::HalfSpan([[left, z], [radius, z]]),
            Mark::Extension([[radius, from], [radius, z]]),
        ];
        let anchor = if side == Side::Left { [left, z] } else { [radius, z] };
        Self::new(key, side, anchor, marks)
    }

    /// A path along which the length of the key is measured.
    pub(super) fn path(key: &'static str, side: Side, at: Point, path: Vec<Point>) -> Self {
        Self::new(key, side, at, vec![Mark::Path(path)])
    }
}

/// An axis-parallel rectangle.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Bounds {
    /// Lower left corner.
    pub low: Point,
    /// Upper right corner.
    pub high: Point,
}

impl Bounds {
    /// The smallest rectangle that contains all points; `None` without points.
    pub fn of(points: impl IntoIterator<Item = Point>) -> Option<Self> {
        points.into_iter().fold(None, |bounds: Option<Self>, [x, z]| {
            let Some(Self { low, high }) = bounds else {
                return Some(Self {
                    low: [x, z],
                    high: [x, z],
                });
            };
            Some(Self {
                low: [low[0].min(x), low[1].min(z)],
                high: [high[0].max(x), high[1].max(z)],
            })
        })
    }

    /// Width and height \[m\].
    pub fn size(&self) -> [f64; 2] {
        [self.high[0] - self.low[0], self.high[1] - self.low[1]]
    }

    /// Whether a point is inside the rectangle, apart from rounding.
    pub fn contains(&self, [x, z]: Point) -> bool {
        let slack = 1e-9;
        (self.low[0] - slack..=self.high[0] + slack).contains(&x)
            && (self.low[1] - slack..=self.high[1] + slack).contains(&z)
    }

    /// Its corners.
    pub(super) fn corners(&self) -> Vec<Point> {
        let ([left, bottom], [right, top]) = (self.low, self.high);
        vec![[left, bottom], [right, bottom], [right, top], [left, top]]
    }
}

/// A view: parts in painting order, lines, and the annotations of keys.
#[derive(Debug, Clone, PartialEq)]
pub struct View {
    /// Short name, used in identifiers.
    pub name: &'static str,
    /// Heading.
    pub title: String,
    /// Its parts.
    pub parts: Vec<Part>,
    /// Its lines.
    pub lines: Vec<Line>,
    /// The keys at their places.
    pub annotations: Vec<Annotation>,
    /// The rectangle that a detail shows; without one, the view shows everything.
    pub window: Option<Bounds>,
    /// Letters of details, with their windows in this view.
    pub details: Vec<(&'static str, Bounds)>,
}

impl View {
    /// The rectangle that the view shows.
    pub fn bounds(&self) -> Bounds {
        self.window.unwrap_or_else(|| {
            let parts = self.parts.iter().flat_map(|part| &part.outlines).flat_map(corners);
            let lines = self.lines.iter().flat_map(|line| line.points.iter().copied());
            let all = parts.chain(lines).chain(self.marked());
            Bounds::of(all).unwrap_or(Bounds {
                low: [0.0; 2],
                high: [1e-2; 2],
            })
        })
    }

    /// All points of annotations.
    pub fn marked(&self) -> impl Iterator<Item = Point> {
        let marks = self.annotations.iter().flat_map(|annotation| &annotation.marks);
        marks.flat_map(Mark::points)
    }
}

impl Mark {
    /// Its points.
    pub fn points(&self) -> Vec<Point> {
        match self {
            Self::Span(ends) | Self::HalfSpan(ends) | Self::Extension(ends) => ends.to_vec(),
            Self::Dot(at) => vec![*at],
            Self::Area(points) | Self::Path(points) => points.clone(),
        }
    }
}

/// Corners of an outline; for a circle, those of the enclosing square.
pub fn corners(outline: &Outline) -> Vec<Point> {
    match outline {
        Outline::Polygon(points) => points.clone(),
        Outline::Circle { centre: [x, z], radius } => Bounds {
            low: [x - radius, z - radius],
            high: [x + radius, z + radius],
        }
        .corners(),
    }
}

/// The corners of a rectangle between two abscissas and two heights.
pub(crate) fn rectangle([left, right]: [f64; 2], [bottom, top]: [f64; 2]) -> Vec<Point> {
    vec![[left, bottom], [right, bottom], [right, top], [left, top]]
}

/// The mirror image of a polygon about x = 0.
pub(super) fn mirrored(polygon: &[Point]) -> Vec<Point> {
    polygon.iter().map(|[x, z]| [-x, *z]).collect()
}
