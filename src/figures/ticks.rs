//! Ticks of axes for wide and narrow windows; a printed chart is as wide as a wide window.

use super::chart::Axis;

/// Minimum plot width in a wide and in a narrow window \[px\]; labels that fit there always fit.
pub(crate) const WIDE: f64 = 600.0;
const NARROW: f64 = 270.0;

/// Width of a character in a label, and distance between labels \[px\].
const DIGIT: f64 = 6.7;
const APART: f64 = 9.0;

/// A tick on an axis, with its label.
pub(crate) struct Tick {
    /// Distance from the start of the axis, as a fraction of its length.
    pub(crate) at: f64,
    /// Its label.
    pub(crate) label: String,
    /// Whether there is room for the label in a narrow window.
    pub(crate) narrow: bool,
}

/// Ticks of a linear axis at multiples of 1, 2 or 5 times a power of ten, about `count` of them.
fn round(range: [f64; 2], count: usize) -> Vec<(f64, String)> {
    let [low, high] = range;
    let raw = (high - low) / count.max(1) as f64;
    if !(raw.is_finite() && raw > 0.0) {
        return Vec::new();
    }
    let power = 10f64.powf(raw.log10().floor());
    let step = [1.0, 2.0, 5.0, 10.0].map(|digit| digit * power);
    let step = step.into_iter().find(|step| *step >= raw * 0.999).unwrap_or(raw);
    let decimals = (-step.log10().floor()).max(0.0) as usize;
    let (first, last) = ((low / step - 1e-6).ceil() as i64, (high / step + 1e-6).floor() as i64);
    let tick = |number: i64| {
        let value = number as f64 * step;
        (value, format!("{value:.decimals$}").replace('-', "\u{2212}"))
    };
    (first..=last).map(tick).collect()
}

/// Ticks of a horizontal axis, with labels that do not overlap.
pub(crate) fn across(axis: &Axis) -> Vec<Tick> {
    let [low, high] = axis.range;
    let of = |value: f64| (value - low) / (high - low);
    let all: Vec<(f64, String)> = if axis.categories.is_empty() {
        round(axis.range, 8)
            .into_iter()
            .map(|(value, label)| (of(value), label))
            .collect()
    } else {
        let middle = |place: &usize| (of(*place as f64 + 0.5), axis.categories[*place].clone());
        axis.ticks.iter().map(middle).collect()
    };
    // The labels at this stride do not overlap.
    let stride = |width: f64| {
        let room = |stride: &usize| {
            let shown: Vec<&(f64, String)> = all.iter().step_by(*stride).collect();
            shown.windows(2).all(|pair| {
                let digits = pair[0].1.chars().count() + pair[1].1.chars().count();
                0.5 * DIGIT * digits as f64 + APART <= width * (pair[1].0 - pair[0].0)
            })
        };
        (1..=all.len()).find(room).unwrap_or(1)
    };
    let [wide, narrow] = [stride(WIDE), stride(NARROW)];
    // Labels in a narrow window are a subset of those in a wide one.
    let narrow = narrow.div_ceil(wide) * wide;
    let shown = all.into_iter().enumerate().filter(|(place, _)| place % wide == 0);
    shown
        .map(|(place, (at, label))| Tick {
            at,
            label,
            narrow: place % narrow == 0,
        })
        .collect()
}

/// Ticks of a linear vertical axis of this height \[px\], from its lower end.
pub(crate) fn upwards(axis: &Axis, height: u32) -> Vec<Tick> {
    let [low, high] = axis.range;
    round(axis.range, (height / 45).max(2) as usize)
        .into_iter()
        .map(|(value, label)| Tick {
            at: (value - low) / (high - low),
            label,
            narrow: true,
        })
        .collect()
}

/// Rows for labels at these positions (fractions of the axis) so that labels in a row do not overlap, for a wide and a
/// narrow window.
pub(crate) fn rows(places: &[f64], label: f64) -> Vec<[usize; 2]> {
    let in_width = |width: f64| {
        let mut ends: Vec<f64> = Vec::new();
        let row = |place: &f64| {
            let start = place * width - 0.5 * label;
            let free = ends.iter().position(|end| *end <= start);
            let row = free.unwrap_or_else(|| {
                ends.push(0.0);
                ends.len() - 1
            });
            ends[row] = start + label;
            row
        };
        places.iter().map(row).collect::<Vec<_>>()
    };
    in_width(WIDE)
        .into_iter()
        .zip(in_width(NARROW))
        .map(|(wide, narrow)| [wide, narrow])
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ticks_are_round_numbers_within_the_axis() {
        let labels = |range| round(range, 5).into_iter().map(|(_, label)| label).collect::<Vec<_>>();
        assert_eq!(labels([40.0, 100.0]), ["40", "60", "80", "100"]);
        assert_eq!(labels([-0.11, 0.21]), ["\u{2212}0.1", "0.0", "0.1", "0.2"]);
        assert!(labels([1.0, 1.0]).is_empty());
    }

    #[test]
    fn labels_of_categories_do_not_touch() {
        let names = (0..24).map(|name| format!("{name}000")).collect();
        let ticks = across(&Axis::categories("", "", names));
        for (width, own) in [
            (WIDE, ticks.iter().collect::<Vec<_>>()),
            (NARROW, ticks.iter().filter(|tick| tick.narrow).collect()),
        ] {
            assert!(own.len() > 3);
            for pair in own.windows(2) {
                let room = width * (pair[1].at - pair[0].at);
                assert!(room >= DIGIT * pair[0].label.len() as f64, "{room}");
            }
        }
    }

    #[test]
    fn labels_of_close_events_take_other_rows() {
        assert_eq!(rows(&[0.1, 0.11, 0.5], 20.0), [[0, 0], [1, 1], [0, 0]]);
    }
}
