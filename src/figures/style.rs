//! The one look of all figures: sizes for print, colours that colour-blind readers can tell apart.
//!
//! A figure is drawn on a grid of 0.05 mm, so that whole grid units are finer than any printer's dot, and is as wide as
//! the text of a page (180 mm). Type is 8 pt, lines 1 pt, as journals ask.

use plotters::style::RGBColor;

/// Grid units in a millimetre.
pub(super) const MM: i32 = 20;

/// Width of a figure, in grid units.
pub(super) const WIDTH: i32 = 180 * MM;
/// Left edge of the panels.
pub(super) const LEFT: i32 = 17 * MM;
/// Right edge of the panels.
pub(super) const RIGHT: i32 = WIDTH - 4 * MM;

/// Height of 8 pt type.
pub(super) const TYPE: i32 = 56;
/// Distance of lines of type.
pub(super) const LEADING: i32 = 4 * MM;
/// Mean advance of a character in parts of the type's height; a little wide, so that labels keep apart in any font.
pub(super) const ADVANCE: f64 = 0.54;
/// Font of all text: whichever of these the reader has.
pub(super) const FONT: &str = "Helvetica, Arial, Liberation Sans, DejaVu Sans, sans-serif";

/// Width of a curve.
pub(super) const CURVE: u32 = 7;
/// Width of frames and ticks.
pub(super) const FRAME: u32 = 4;
/// Width of grid and event lines.
pub(super) const HAIR: u32 = 2;
/// Length of a tick.
pub(super) const TICK: i32 = MM;

/// Text and frames.
pub(super) const INK: RGBColor = RGBColor(0x22, 0x22, 0x22);
/// What stands back: secondary text.
pub(super) const GREY: RGBColor = RGBColor(0x66, 0x66, 0x66);
/// Lines of events.
pub(super) const PALE: RGBColor = RGBColor(0xB8, 0xB8, 0xB8);
/// Grid.
pub(super) const FAINT: RGBColor = RGBColor(0xEA, 0xEA, 0xEA);
/// Behind everything.
pub(super) const PAPER: RGBColor = RGBColor(0xFF, 0xFF, 0xFF);

/// Colours of curves: Okabe and Ito, "Color universal design" (2008), without the yellow that is too light for lines.
pub(crate) const PALETTE: [RGBColor; 8] = [
    RGBColor(0x00, 0x72, 0xB2), // blue
    RGBColor(0xD5, 0x5E, 0x00), // vermilion
    RGBColor(0x00, 0x9E, 0x73), // bluish green
    RGBColor(0xCC, 0x79, 0xA7), // reddish purple
    RGBColor(0xE6, 0x9F, 0x00), // orange
    RGBColor(0x56, 0xB4, 0xE9), // sky blue
    RGBColor(0x00, 0x00, 0x00), // black
    RGBColor(0x8C, 0x8C, 0x8C), // grey
];
