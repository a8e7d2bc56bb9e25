use serde::{Deserialize, Serialize};
use std::ops::RangeInclusive;

/// Band numbers k of the usual one-third-octave bands, 50 Hz to 20 kHz.
pub const THIRD_OCTAVES: RangeInclusive<i32> = -13..=13;

/// Band numbers k of the octave bands shown, 63 Hz to 8 kHz.
const OCTAVES: RangeInclusive<i32> = -4..=3;

/// Octave frequency ratio G of the base-ten system (IEC 61260-1:2014, 5.2.1).
const LG_G: f64 = 0.3;

/// An exact base-ten one-third-octave band (IEC 61260-1:2014, 5.4 and 5.5).
///
/// ```text
/// f_m = 1000 Hz G^{k/3}      f_1,2 = f_m G^{-1/6, +1/6}      G = 10^{3/10}
/// ```
///
/// The common edge of adjacent bands is bitwise the same.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Band {
    /// Band number k; 0 is the band of 1 kHz.
    pub index: i32,
    /// Exact mid-band frequency f_m \[Hz\].
    pub hz: f64,
    /// Lower edge f_1 \[Hz\].
    pub low: f64,
    /// Upper edge f_2 \[Hz\].
    pub high: f64,
}

impl Band {
    /// Band number `index`.
    pub fn new(index: i32) -> Self {
        Self {
            index,
            hz: 1000.0 * 10f64.powf(LG_G * f64::from(index) / 3.0),
            low: edge(index),
            high: edge(index + 1),
        }
    }

    /// Mid-band frequency rounded to the nominal values (IEC 61260-1:2014, annex E): 31.5, 40, 50 ...
    pub fn nominal_hz(&self) -> f64 {
        const SERIES: [f64; 10] = [1.0, 1.25, 1.6, 2.0, 2.5, 3.15, 4.0, 5.0, 6.3, 8.0];
        let digit = SERIES[self.index.rem_euclid(10) as usize];
        // Hundredths of a hertz are exact here, so that 31.5 is not printed as 31.499999.
        (digit * 10f64.powi(3 + self.index.div_euclid(10)) * 1000.0).round() / 1000.0
    }
}

/// Lower edge of band k \[Hz\]: 1000 G^{(2k-1)/6}.
pub(crate) fn edge(index: i32) -> f64 {
    1000.0 * 10f64.powf(LG_G * f64::from(2 * index - 1) / 6.0)
}

/// The bands of [`THIRD_OCTAVES`].
pub fn third_octaves() -> Vec<Band> {
    THIRD_OCTAVES.map(Band::new).collect()
}

/// The bands of a range \[Hz\]: those of [`THIRD_OCTAVES`], and further ones that the range overlaps. An end of the
/// range that is not positive and finite adds none.
pub fn bands_of(range_hz: [f64; 2]) -> Vec<Band> {
    let [low, high] = range_hz;
    let (mut first, mut last) = THIRD_OCTAVES.into_inner();
    if low > 0.0 && low < f64::INFINITY {
        first = first.min(band_containing(low).index);
    }
    if high > 0.0 && high < f64::INFINITY {
        // An edge belongs to the band above it, which a range that ends there does not overlap.
        let top = band_containing(high);
        last = last.max(top.index - i32::from(high <= top.low));
    }
    (first..=last).map(Band::new).collect()
}

/// The octave bands from 63 Hz to 8 kHz: f_m = 1000 Hz G^k, f_1,2 = f_m G^{-1/2, +1/2}. Each has the number and the
/// mid-band frequency of its middle third octave.
pub fn octaves() -> Vec<Band> {
    let octave = |k: i32| Band {
        low: edge(3 * k - 1),
        high: edge(3 * k + 2),
        ..Band::new(3 * k)
    };
    OCTAVES.map(octave).collect()
}

/// The band that contains the frequency `hz` > 0; an edge belongs to the band above it.
pub fn band_containing(hz: f64) -> Band {
    let mut index = (10.0 * (hz / 1000.0).log10()).round() as i32;
    if hz < edge(index) {
        index -= 1;
    } else if hz >= edge(index + 1) {
        index += 1;
    }
    Band::new(index)
}
