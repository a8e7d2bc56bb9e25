//! Event markers of the measurement: times determined from accelerometers and pressure transducers.
//!
//! Markers t0 to t13 are those of the published tests; [`MARKERS`] maps them to the events of the cycle. They are
//! determined by the following rules. Block or table: first at 2 g (t3), largest acceleration during the drive (t7).
//! Handle: below 6 g for 2 ms (t10), above 6 g again (t12; if it still rings above 6 g after t11, the onset of a burst
//! of twice its peak), above 6 g for the last time (t13). Transducer in the cylinder wall: it is exposed to the
//! pressure above the piston from its steepest rise (t4) to its next step of either sign (t11). Its fluctuation ends
//! (t8) when its range over 2 ms falls below 2 %.
//!
//! If only the body is bare, the burst of t12 is also located from the microphones ([`arrival`]), which shows whether
//! they share the clock of the accelerometers.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};

/// Acceleration at which the block or table starts to move \[m/s2\]: 2 g.
const START: f64 = 2.0 * STANDARD_GRAVITY;

/// Acceleration of the handle that indicates an impact \[m/s2\]: 6 g.
const IMPACT: f64 = 6.0 * STANDARD_GRAVITY;

/// Standard acceleration of gravity (ISO 80000-3) \[m/s2\].
pub const STANDARD_GRAVITY: f64 = 9.80665;

/// How long the handle must stay below the limit \[s\]; also the window for the range of a pressure.
const QUIET: f64 = 2e-3;

/// Time after the passage of the piston during which its return is not searched for \[s\].
const SETTLED: f64 = 5e-3;

/// Time after a burst's first steep rise that is included in the search for its onset \[s\].
const RISE: f64 = 0.2e-3;

/// Time before and after the expected arrival of a burst at a microphone within which it is searched for \[s\].
const ARRIVAL: f64 = 4e-3;

/// Smallest number of samples for which a variance is computed.
const FEWEST: usize = 4;

/// Range of a settled pressure relative to that of the record.
const FLUCTUATION: f64 = 0.02;

/// Time over which the steepest change of a pressure is computed \[s\].
const STEEP: f64 = 0.1e-3;

/// A marker, the corresponding event of the cycle, and how it is determined.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Marker {
    /// Its name.
    pub name: &'static str,
    /// Event of the cycle; `None` without counterpart.
    pub event: Option<&'static str>,
    /// What happens.
    pub meaning: &'static str,
}

/// The markers that the signals show, in chronological order.
pub const MARKERS: [Marker; 9] = [
    marker("t0", Some("t0"), "trigger"),
    marker("t3", None, "block or table starts to move"),
    marker("t4", Some("t7"), "piston passes the transducer downwards"),
    marker("t7", None, "largest acceleration of table or block"),
    marker("t8", Some("t11"), "pressure in the cylinder has come to rest"),
    marker("t10", None, "handle is quiet"),
    marker("t11", Some("t15"), "piston passes the transducer upwards"),
    marker("t12", Some("t16"), "piston hits its stop"),
    marker("t13", Some("t18"), "handle is quiet for good"),
];

/// The burst of t12 as located from the microphones, if only the body is bare.
pub const AT_MICROPHONES: Marker = marker(
    "t12 at the microphones",
    Some("t16"),
    "its sound arrives, less the travel time from the device's centre",
);

const fn marker(name: &'static str, event: Option<&'static str>, meaning: &'static str) -> Marker {
    Marker { name, event, meaning }
}

/// Events of the cycle that the markers represent: those of [`MARKERS`] for a tool with the events of the published
/// tests.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct MarkerEvents(BTreeMap<String, String>);

impl Default for MarkerEvents {
    fn default() -> Self {
        let named = MARKERS.iter().filter_map(|own| Some((own.name, own.event?)));
        Self(named.map(|(name, event)| (name.to_owned(), event.to_owned())).collect())
    }
}

impl MarkerEvents {
    /// Events by the names of their markers.
    pub fn new(events: BTreeMap<String, String>) -> Self {
        Self(events)
    }

    /// The markers whose events a tool has, given the names of its events.
    pub fn among(mut self, events: &[&str]) -> Self {
        self.0.retain(|_, event| events.contains(&event.as_str()));
        self
    }

    /// Gives a marker an event.
    pub fn set(&mut self, marker: &str, event: &str) {
        self.0.insert(marker.to_owned(), event.to_owned());
    }

    /// Markers and their events.
    pub fn iter(&self) -> impl Iterator<Item = (&str, &str)> {
        self.0.iter().map(|(marker, event)| (marker.as_str(), event.as_str()))
    }

    /// The event of a marker; none without counterpart.
    pub fn of(&self, marker: &str) -> Option<&str> {
        let own = match marker {
            name if name == AT_MICROPHONES.name => "t12",
            name => name,
        };
        self.0.get(own).map(String::as_str)
    }
}

/// Times from the trigger \[s\]; `None` if the signal is missing or never satisfies the rule.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize, Deserialize)]
pub struct Markers {
    /// Block or table first at 2 g.
    pub t3: Option<f64>,
    /// The cylinder's transducer becomes exposed to the pressure above the piston.
    pub t4: Option<f64>,
    /// Largest acceleration of table or block.
    pub t7: Option<f64>,
    /// The cylinder's pressure has settled.
    pub t8: Option<f64>,
    /// The handle is quiet.
    pub t10: Option<f64>,
    /// The cylinder's transducer is no longer exposed to the pressure above the piston.
    pub t11: Option<f64>,
    /// The handle exceeds 6 g again.
    pub t12: Option<f64>,
    /// The handle stays at or below 6 g from here on.
    pub t13: Option<f64>,
}

/// Signals from which markers are determined; they share a sampling rate.
#[derive(Debug, Clone, Copy, Default)]
pub struct Signals<'a> {
    /// Handle, N \[m/s2\].
    pub handle: Option<&'a [f64]>,
    /// Block, W, or another channel that shows its first motion \[m/s2\].
    pub block: Option<&'a [f64]>,
    /// Table under its centre, TC \[m/s2\].
    pub table: Option<&'a [f64]>,
    /// Transducer in the cylinder wall, PT-I \[Pa\].
    pub cylinder: Option<&'a [f64]>,
}

impl Markers {
    /// Determines the markers of a shot sampled at `rate` \[1/s\], with its trigger at `trigger` \[s\] from the
    /// record's start.
    pub fn find(signals: &Signals<'_>, rate: f64, trigger: f64) -> Self {
        let from = (trigger * rate).ceil().max(0.0) as usize;
        let time = |sample: usize| sample as f64 / rate - trigger;
        let first = |signal: &[f64], begin: usize, limit: f64| {
            let rest = signal.get(begin..)?;
            rest.iter().position(|a| a.abs() >= limit).map(|i| begin + i)
        };
        let t3 = signals
            .block
            .or(signals.table)
            .and_then(|signal| first(signal, from, START));
        let (t4, t8, t11) = signals.cylinder.map_or((None, None, None), |p| cylinder(p, rate, from));
        // Only the drive counts: a bouncing block may land with a larger acceleration after the piston has reversed.
        let t7 = signals.table.or(signals.block).and_then(|signal| {
            let end = t11.unwrap_or(signal.len()).min(signal.len());
            largest(&signal[..end], from, f64::abs)
        });
        let quiet = (QUIET * rate).ceil() as usize;
        // The handle rings from the drive onwards; the next burst is the return of the piston.
        let t10 = signals
            .handle
            .zip(t7.or(t4).or(t3))
            .and_then(|(signal, begin)| quiet_from(signal, begin, IMPACT, quiet))
            .filter(|quiet| t11.is_none_or(|back| *quiet <= back));
        // If the handle still rings above 6 g when the piston returns, t12 is a burst instead of the end of a quiet
        // period.
        let t12 = match (signals.handle, t10, t11) {
            (Some(signal), Some(begin), None) => first(signal, begin, IMPACT),
            (Some(signal), _, Some(back)) => burst(signal, back, rate),
            _ => None,
        };
        let t13 = signals.handle.zip(t12).and_then(|(signal, begin)| {
            let last = signal.get(begin..)?.iter().rposition(|a| a.abs() > IMPACT)?;
            Some(begin + last + 1)
        });
        Self {
            t3: t3.map(time),
            t4: t4.map(time),
            t7: t7.map(time),
            t8: t8.map(time),
            t10: t10.map(time),
            t11: t11.map(time),
            t12: t12.map(time),
            t13: t13.map(time),
        }
    }

    /// Names and times of the markers found, in chronological order.
    pub fn found(&self) -> Vec<(&'static str, f64)> {
        let own = [
            Some(0.0),
            self.t3,
            self.t4,
            self.t7,
            self.t8,
            self.t10,
            self.t11,
            self.t12,
            self.t13,
        ];
        let names = MARKERS.iter().map(|marker| marker.name);
        let mut found: Vec<_> = names.zip(own).filter_map(|(name, at)| Some((name, at?))).collect();
        found.sort_by(|a, b| a.1.total_cmp(&b.1));
        found
    }

    /// The first pair of markers in the wrong order.
    pub fn out_of_order(&self) -> Option<[(&'static str, f64); 2]> {
        let order = [
            ("t3", self.t3),
            ("t7", self.t7),
            ("t10", self.t10),
            ("t12", self.t12),
            ("t13", self.t13),
        ];
        let drive = [("t4", self.t4), ("t8", self.t8), ("t11", self.t11)];
        let wrong = |markers: &[(&'static str, Option<f64>)]| {
            let found: Vec<_> = markers.iter().filter_map(|(name, at)| Some((*name, (*at)?))).collect();
            found
                .windows(2)
                .find(|pair| pair[1].1 < pair[0].1)
                .map(|pair| [pair[0], pair[1]])
        };
        wrong(&order).or_else(|| wrong(&drive))
    }
}

/// The sample with the largest value from `begin` onwards.
fn largest(signal: &[f64], begin: usize, value: impl Fn(f64) -> f64) -> Option<usize> {
    let rest = signal.get(begin..)?;
    let best = rest
        .iter()
        .enumerate()
        .max_by(|a, b| value(*a.1).total_cmp(&value(*b.1)))?;
    Some(begin + best.0)
}

/// The first sample from `begin` onwards after which a signal stays below `limit` for `quiet` samples.
fn quiet_from(signal: &[f64], begin: usize, limit: f64, quiet: usize) -> Option<usize> {
    let mut since = begin;
    for (i, a) in signal.iter().enumerate().skip(begin) {
        if a.abs() >= limit {
            since = i + 1;
        } else if i + 1 - since >= quiet {
            return Some(since);
        }
    }
    None
}

/// The first sample of a burst in a signal that may still ring: it exceeds the impact limit and twice the peak of the 2
/// ms before its onset.
fn burst(signal: &[f64], begin: usize, rate: f64) -> Option<usize> {
    let start = onset(signal, begin, rate)?;
    let window = ((QUIET * rate).ceil() as usize).max(1);
    let peak = |piece: &[f64]| piece.iter().fold(0.0, |peak: f64, a| peak.max(a.abs()));
    let before = peak(&signal[start.saturating_sub(window)..start]);
    let after = peak(&signal[start..(start + window).min(signal.len())]);
    (after >= IMPACT && after > 2.0 * before).then_some(start)
}

/// Onset of the first steep burst from `begin` onwards: the sample that divides the sample-to-sample changes x of the
/// signal, up to that burst, into two parts whose variances minimise the information criterion (Maeda 1985, Zisin 38,
/// p. 365),
///
/// ```text
/// AIC(k) = k ln var(x_1 .. x_k) + (n - k) ln var(x_k+1 .. x_n)
/// ```
///
/// Changes increase with frequency, so an impact stands out from the ringing of low modes. The burst is steep where a
/// change reaches half of the largest change.
fn onset(signal: &[f64], begin: usize, rate: f64) -> Option<usize> {
    let changes = changes(signal.get(begin..)?);
    let largest = changes.iter().fold(0.0, |largest: f64, x| largest.max(x.abs()));
    let steep = changes.iter().position(|x| x.abs() >= 0.5 * largest)?;
    let rise = (RISE * rate).ceil() as usize;
    Some(begin + least(&criterion(&changes[..(steep + rise).min(changes.len())]))?)
}

fn changes(signal: &[f64]) -> Vec<f64> {
    signal.windows(2).map(|pair| pair[1] - pair[0]).collect()
}

/// The information criterion of [`onset`] at every sample of a signal; infinite if a part is too short for a variance.
fn criterion(signal: &[f64]) -> Vec<f64> {
    let variances = || {
        let (mut count, mut mean, mut squares) = (0.0, 0.0, 0.0);
        move |x: &f64| {
            count += 1.0;
            let off = x - mean;
            mean += off / count;
            squares += off * (x - mean);
            squares / count
        }
    };
    // Avoids the logarithm of zero for silence.
    let silence = f64::MIN_POSITIVE;
    let before: Vec<f64> = signal.iter().map(variances()).collect();
    let mut after: Vec<f64> = signal.iter().rev().map(variances()).collect();
    after.reverse();
    let divisions = FEWEST..signal.len().saturating_sub(FEWEST);
    let of = |k: usize| {
        let (first, second) = (k as f64, (signal.len() - k) as f64);
        first * before[k - 1].max(silence).ln() + second * after[k].max(silence).ln()
    };
    let at = |k: usize| if divisions.contains(&k) { of(k) } else { f64::INFINITY };
    (0..signal.len()).map(at).collect()
}

/// Index of the smallest finite value.
fn least(criterion: &[f64]) -> Option<usize> {
    let finite = (0..criterion.len()).filter(|&k| criterion[k].is_finite());
    finite.min_by(|&a, &b| criterion[a].total_cmp(&criterion[b]))
}

/// How much later than expected the burst of t12 arrives at the microphones \[s\], given their pressures and the time
/// at which each expects it, from the record's start \[s\].
///
/// The microphones are treated as one array: the chosen sample has the smallest sum of their information criteria
/// (Maeda 1985), because single microphones may be in directions in which the tool hardly radiates. It is searched for
/// within 4 ms; `None` if a record ends earlier.
pub fn arrival(pressures: &[Vec<f64>], rate: f64, expected: &[f64]) -> Option<f64> {
    let around = (ARRIVAL * rate).round() as usize;
    let mut sum = vec![0.0; 2 * around];
    for (pressure, expected) in pressures.iter().zip(expected) {
        let begin = ((expected * rate).round() as usize).checked_sub(around)?;
        let window = pressure.get(begin..=begin + 2 * around)?;
        sum.iter_mut()
            .zip(criterion(&changes(window)))
            .for_each(|(sum, own)| *sum += own);
    }
    Some((least(&sum)? as f64 - around as f64) / rate)
}

/// Samples at which the transducer becomes exposed to the pressure above the piston, at which that pressure has
/// settled, and at which the exposure ends.
fn cylinder(pressure: &[f64], rate: f64, from: usize) -> (Option<usize>, Option<usize>, Option<usize>) {
    let step = ((STEEP * rate).round() as usize).max(1);
    let Some(rest) = pressure.get(from..).filter(|rest| rest.len() > 2 * step) else {
        return (None, None, None);
    };
    let slopes: Vec<f64> = rest.windows(step + 1).map(|window| window[step] - window[0]).collect();
    let middle = |at: usize| from + at + step.div_ceil(2);
    let rise = largest(&slopes, 0, |slope| slope);
    // When the piston returns, the pressure above it may have fallen below that of the return chamber, so the step may
    // have either sign. The pressure also falls faster while the exhaust is open. A step stands out from the slopes on
    // either side. The step of the piston's passage initially rings in the record.
    let settled = (SETTLED * rate).ceil() as usize;
    let beside = |at: usize| 0.5 * (slopes[at - 2 * step] + slopes[at + 2 * step]);
    let steps = slopes.len().saturating_sub(2 * step);
    let fall = rise.and_then(|rise| {
        let candidates = (rise + settled).max(2 * step)..steps;
        let height = |at: &usize| (slopes[*at] - beside(*at)).abs();
        candidates.max_by(|a, b| height(a).total_cmp(&height(b)))
    });
    let (low, high) = rest.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), p| {
        (low.min(*p), high.max(*p))
    });
    let window = ((QUIET * rate).ceil() as usize).max(1);
    let end = rise.zip(fall).and_then(|(rise, fall)| {
        (rise + step..fall.saturating_sub(window)).find(|&begin| {
            let (least, most) = rest[begin..begin + window]
                .iter()
                .fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), p| {
                    (low.min(*p), high.max(*p))
                });
            most - least < FLUCTUATION * (high - low)
        })
    });
    (rise.map(middle), end.map(|sample| from + sample), fall.map(middle))
}

/// Root mean square over one second, and peak, of an acceleration, in the unit of the record.
pub fn rms_and_peak(piece: &[f64], rate: f64) -> (f64, f64) {
    let square: f64 = piece.iter().map(|a| a * a).sum::<f64>() / rate;
    let peak = piece.iter().fold(0.0, |peak: f64, a| peak.max(a.abs()));
    (square.sqrt(), peak)
}

#[cfg(test)]
mod tests {
    use std::f64::consts::PI;

    use super::*;

    const RATE: f64 = 160_000.0;

    /// Bursts of 800 Hz that decay in 20 ms: instant \[s\] and peak \[g\].
    fn bursts(at: &[(f64, f64)]) -> Vec<f64> {
        let sample = |i: usize| {
            let burst = |(start, peak): &(f64, f64)| {
                let t = i as f64 / RATE - start;
                if t < 0.0 {
                    0.0
                } else {
                    peak * STANDARD_GRAVITY * (-t / 0.02).exp() * (2.0 * PI * 800.0 * t).sin()
                }
            };
            at.iter().map(burst).sum()
        };
        (0..RATE as usize).map(sample).collect()
    }

    #[test]
    fn a_decaying_burst_has_the_rms_of_its_integral() {
        let (rms, _) = rms_and_peak(&bursts(&[(0.0, 100.0)]), RATE);
        assert!(
            (rms / STANDARD_GRAVITY - 7.0707).abs() < 5e-4,
            "{}",
            rms / STANDARD_GRAVITY
        );
    }

    #[test]
    fn a_burst_arrives_at_the_microphones_together() {
        // Four records of the burst, each with its own delay. The first two contain only a hum at a tenth of its
        // frequency.
        let delays = [0.0, 3e-3, 5e-3, 8e-3];
        let record = |n: usize, delay: f64| {
            let hum = |k: usize| 60.0 * (2.0 * PI * 80.0 * k as f64 / RATE).sin();
            let burst = if n < 2 {
                vec![0.0; (0.4 * RATE) as usize]
            } else {
                bursts(&[(0.1 + delay, 60.0)])
            };
            burst.iter().enumerate().map(|(k, p)| p + hum(k)).collect::<Vec<f64>>()
        };
        let records: Vec<_> = delays.iter().enumerate().map(|(n, delay)| record(n, *delay)).collect();
        for late in [-2e-3, 0.0, 2e-3] {
            let expected = delays.map(|delay| 0.1 + delay - late);
            let found = arrival(&records, RATE, &expected).unwrap();
            assert!((found - late).abs() < 0.1e-3, "{found}");
        }
    }

    #[test]
    fn nothing_arrives_after_the_end_of_a_record() {
        assert_eq!(arrival(&[bursts(&[(0.1, 60.0)])], RATE, &[100.0]), None);
    }

    /// The envelope 100 g e^(-t/20 ms) is at 6 g after 56.27 ms; the last crest above 6 g lies at most half a period
    /// earlier.
    #[test]
    fn the_handle_is_quiet_where_its_envelope_falls_to_6_g() {
        let handle = bursts(&[(0.01, 100.0)]);
        let signals = Signals {
            handle: Some(&handle),
            block: Some(&handle),
            ..Signals::default()
        };
        let found = Markers::find(&signals, RATE, 0.0).t10.unwrap_or(f64::NAN) - 0.01;
        assert!((0.05627 - found) > 0.0 && (0.05627 - found) < 0.5 / 800.0, "{found}");
    }

    #[test]
    fn bursts_of_the_handle_become_markers_in_their_order() {
        let handle = bursts(&[(0.02, 100.0), (0.12, 60.0)]);
        let block = bursts(&[(0.02, 300.0)]);
        let signals = Signals {
            handle: Some(&handle),
            block: Some(&block),
            ..Signals::default()
        };
        let found = Markers::find(&signals, RATE, 0.01);
        // 2 g of 300 g are reached within a fiftieth of a radian.
        assert!((found.t3.unwrap_or(f64::NAN) - 0.01).abs() < 2e-5);
        // 6 g of 60 g are reached a tenth of a radian of 800 Hz later; 0.7 g remain of the first burst.
        assert!((found.t12.unwrap_or(f64::NAN) - 0.11).abs() < 0.03e-3);
        assert!(found.t13 > found.t12 && found.t10 < found.t12);
        assert_eq!(found.out_of_order(), None);
    }

    #[test]
    fn the_transducer_sees_the_piston_pass_twice() {
        let sample = |i: usize| {
            let t = i as f64 / RATE;
            match t {
                t if t < 0.010 => 0.0,
                t if t < 0.060 => 5e5 * (1.0 + 0.2 * (-(t - 0.010) / 2e-3).exp() * (2.0 * PI * 300.0 * t).sin()),
                _ => 2e4,
            }
        };
        let pressure: Vec<f64> = (0..(0.2 * RATE) as usize).map(sample).collect();
        let signals = Signals {
            cylinder: Some(&pressure),
            ..Signals::default()
        };
        let found = Markers::find(&signals, RATE, 0.002);
        assert!((found.t4.unwrap_or(f64::NAN) - 0.008).abs() < 0.1e-3);
        assert!((found.t11.unwrap_or(f64::NAN) - 0.058).abs() < 0.1e-3);
        // 2 % of the range are 12 kPa. Over 2 ms the oscillation of 100 kPa and 300 Hz spans about 1.5 of its
        // amplitudes, which is below that after 2 ms ln(150/12).
        assert!(
            (found.t8.unwrap_or(f64::NAN) - 0.008 - 5e-3).abs() < 1e-3,
            "{:?}",
            found.t8
        );
    }

    /// The handle rings at 60 g and above until the piston strikes again with 300 g.
    #[test]
    fn a_burst_is_found_on_a_handle_that_still_rings() {
        let sample = |i: usize| {
            let t = i as f64 / RATE;
            let ringing = 60.0 * (2.0 * PI * 800.0 * t).sin();
            let struck = if t > 0.08 {
                300.0 * (2.0 * PI * 2000.0 * (t - 0.08)).sin()
            } else {
                0.0
            };
            STANDARD_GRAVITY * (ringing + struck)
        };
        let handle: Vec<f64> = (0..(0.1 * RATE) as usize).map(sample).collect();
        let found = burst(&handle, (0.05 * RATE) as usize, RATE).map_or(f64::NAN, |at| at as f64 / RATE);
        assert!((found - 0.08).abs() < 0.05e-3, "{found}");
    }

    #[test]
    fn ringing_alone_is_no_burst() {
        let handle = bursts(&[(0.01, 500.0)]);
        assert_eq!(burst(&handle, (0.03 * RATE) as usize, RATE), None);
    }

    /// The block lands with 500 g after the piston has turned back.
    #[test]
    fn the_largest_acceleration_is_that_of_the_drive() {
        let block = bursts(&[(0.02, 300.0), (0.10, 500.0)]);
        let pressure: Vec<f64> = (0..block.len())
            .map(|i| {
                if (0.015..0.060).contains(&(i as f64 / RATE)) {
                    5e5
                } else {
                    0.0
                }
            })
            .collect();
        let signals = Signals {
            block: Some(&block),
            cylinder: Some(&pressure),
            ..Signals::default()
        };
        let found = Markers::find(&signals, RATE, 0.0).t7.unwrap_or(f64::NAN);
        assert!((found - 0.02).abs() < 1e-3, "{found}");
    }

    #[test]
    fn markers_out_of_order_are_named() {
        let markers = Markers {
            t3: Some(0.02),
            t7: Some(0.01),
            ..Markers::default()
        };
        assert_eq!(markers.out_of_order(), Some([("t3", 0.02), ("t7", 0.01)]));
        assert_eq!(Markers::default().out_of_order(), None);
    }
}
