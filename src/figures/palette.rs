//! Colours of series.

/// Colours of series: Okabe and Ito, "Color universal design" (2008), without yellow, which is too light for lines;
/// colour-blind readers can distinguish them. Twelve more follow for designs shown together; none of them is the colour
/// of a source.
pub(crate) const PALETTE: [[u8; 3]; 20] = [
    [0x00, 0x72, 0xB2], // blue
    [0xD5, 0x5E, 0x00], // vermilion
    [0x00, 0x9E, 0x73], // bluish green
    [0xCC, 0x79, 0xA7], // reddish purple
    [0xE6, 0x9F, 0x00], // orange
    [0x56, 0xB4, 0xE9], // sky blue
    [0x00, 0x00, 0x00], // black
    [0x8C, 0x8C, 0x8C], // grey
    [0x33, 0x22, 0x88], // indigo
    [0x11, 0x77, 0x33], // green
    [0xAA, 0x44, 0x99], // purple
    [0x8F, 0x8F, 0x2C], // olive
    [0xC9, 0x5F, 0x71], // rose
    [0x2C, 0x8C, 0x7F], // teal
    [0x88, 0x22, 0x55], // wine
    [0x4C, 0x80, 0xAE], // steel
    [0x9A, 0x4F, 0x2A], // sienna
    [0x68, 0x70, 0x7C], // slate
    [0xB3, 0x7F, 0x00], // gold
    [0x75, 0x57, 0xC4], // violet
];
/// Indices in the palette.
pub(crate) const BLACK: usize = 6;
pub(crate) const GREY: usize = 7;

/// The colour at an index of the palette, as `#RRGGBB`.
pub(crate) fn hexadecimal(place: usize) -> String {
    let [red, green, blue] = PALETTE[place];
    format!("#{red:02X}{green:02X}{blue:02X}")
}

/// Places of designs side by side: neighbours differ in lightness, so that colour-blind readers can tell them apart.
const DESIGNS: [usize; 12] = [8, 18, 13, 14, 19, 11, 15, 12, 9, 16, 17, 10];

/// Place in the palette of a design among others.
pub(crate) fn of_design(place: usize) -> usize {
    DESIGNS[place % DESIGNS.len()]
}
