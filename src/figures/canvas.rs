//! An SVG drawing on a grid of 0.05 mm.

use plotters::backend::{DrawingBackend, SVGBackend};
use plotters::style::text_anchor::{HPos, Pos, VPos};
use plotters::style::{Color, FontFamily, FontStyle, FontTransform, RGBColor, ShapeStyle, TextStyle};

use super::style::{FONT, MM, PAPER, TYPE, WIDTH};

/// The anchor of a text along its line; across it, text is centred.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Anchor {
    Start,
    Middle,
    End,
}

/// A drawing in progress, `(0, 0)` top left, in units of 0.05 mm.
pub(super) struct Canvas<'a> {
    backend: SVGBackend<'a>,
}

/// Draws a figure `height` units high and returns its SVG.
pub(super) fn draw(height: i32, paint: impl FnOnce(&mut Canvas<'_>)) -> String {
    let mut svg = String::new();
    {
        let mut canvas = Canvas {
            backend: SVGBackend::with_string(&mut svg, (WIDTH as u32, height as u32)),
        };
        canvas.rectangle([0, 0], [WIDTH, height], PAPER, 1.0);
        paint(&mut canvas);
        // Writing to a string cannot fail, here and below.
        let _ = canvas.backend.present();
    }
    // The size in print, and joints that do not shoot beyond a spike's tip.
    let mm = |units: i32| f64::from(units) / f64::from(MM);
    let head = format!(r#"<svg width="{WIDTH}" height="{height}""#);
    let printed = format!(
        r#"<svg width="{}mm" height="{}mm" stroke-linejoin="round" stroke-linecap="round""#,
        mm(WIDTH),
        mm(height)
    );
    svg.replacen(&head, &printed, 1)
}

impl Canvas<'_> {
    /// A line through points.
    pub(super) fn path(&mut self, points: impl IntoIterator<Item = [i32; 2]>, colour: RGBColor, width: u32) {
        let style = ShapeStyle {
            color: colour.to_rgba(),
            filled: false,
            stroke_width: width,
        };
        let _ = self.backend.draw_path(points.into_iter().map(|[x, y]| (x, y)), &style);
    }

    /// A straight dashed line along x.
    pub(super) fn dashes(&mut self, [from, to]: [i32; 2], y: i32, colour: RGBColor, width: u32) {
        let (dash, gap) = (MM + MM / 4, MM);
        let mut x = from;
        while x < to {
            self.path([[x, y], [(x + dash).min(to), y]], colour, width);
            x += dash + gap;
        }
    }

    /// A filled rectangle.
    pub(super) fn rectangle(&mut self, from: [i32; 2], to: [i32; 2], colour: RGBColor, opacity: f64) {
        let _ = self
            .backend
            .draw_rect((from[0], from[1]), (to[0], to[1]), &colour.mix(opacity), true);
    }

    /// A filled polygon.
    pub(super) fn polygon(&mut self, points: impl IntoIterator<Item = [i32; 2]>, colour: RGBColor, opacity: f64) {
        let _ = self
            .backend
            .fill_polygon(points.into_iter().map(|[x, y]| (x, y)), &colour.mix(opacity));
    }

    /// Text of the one size.
    pub(super) fn text(&mut self, text: &str, at: [i32; 2], anchor: Anchor, colour: RGBColor) {
        self.write(text, at, anchor, colour, FontStyle::Normal, FontTransform::None);
    }

    /// Bold text.
    pub(super) fn bold(&mut self, text: &str, at: [i32; 2], anchor: Anchor, colour: RGBColor) {
        self.write(text, at, anchor, colour, FontStyle::Bold, FontTransform::None);
    }

    /// Text that reads upwards, centred on `at`.
    pub(super) fn upwards(&mut self, text: &str, at: [i32; 2], colour: RGBColor) {
        self.write(
            text,
            at,
            Anchor::Middle,
            colour,
            FontStyle::Normal,
            FontTransform::Rotate270,
        );
    }

    fn write(
        &mut self,
        text: &str,
        at: [i32; 2],
        anchor: Anchor,
        colour: RGBColor,
        weight: FontStyle,
        turn: FontTransform,
    ) {
        let h_pos = match anchor {
            Anchor::Start => HPos::Left,
            Anchor::Middle => HPos::Center,
            Anchor::End => HPos::Right,
        };
        // The backend divides a font's size by 1.24.
        let size = f64::from(TYPE) * 1.24;
        let style = TextStyle::from((FontFamily::Name(FONT), size, weight))
            .color(&colour)
            .pos(Pos::new(h_pos, VPos::Center))
            .transform(turn);
        let _ = self.backend.draw_text(text, &style, (at[0], at[1]));
    }
}
