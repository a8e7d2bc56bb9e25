//! Figures of a shot whose sensitivity can be requested.

use nailnoise_dynamics::CycleRecord;

use crate::error::Error;

/// A figure of a shot.
#[derive(Clone, Copy)]
pub struct Output {
    /// Its name in the output.
    pub name: &'static str,
    /// The group by which it can be chosen: `speed`, `penetration`, `events`, `forces` or `masses`.
    pub group: &'static str,
    /// SI unit.
    pub unit: &'static str,
    read: fn(&CycleRecord) -> Option<f64>,
}

impl Output {
    /// Its value in a record; `None` if its phase does not occur.
    pub fn of(&self, record: &CycleRecord) -> Option<f64> {
        (self.read)(record)
    }
}

impl std::fmt::Debug for Output {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{} [{}]", self.name, self.unit)
    }
}

macro_rules! event {
    ($name:ident) => {
        Output {
            name: stringify!($name),
            group: "events",
            unit: "s",
            read: |r| r.figures.events.$name,
        }
    };
}

const fn output(
    name: &'static str,
    group: &'static str,
    unit: &'static str,
    read: fn(&CycleRecord) -> Option<f64>,
) -> Output {
    Output {
        name,
        group,
        unit,
        read,
    }
}

/// All figures, in the order of the reports.
pub const OUTPUTS: &[Output] = &[
    output("speed_before_impact", "speed", "m/s", |r| {
        r.figures.summary.speed_before_impact
    }),
    output("speed_after_impact", "speed", "m/s", |r| {
        r.figures.summary.speed_after_impact
    }),
    output("mean_drive_speed", "speed", "m/s", |r| {
        r.figures.summary.mean_drive_speed
    }),
    output("penetration", "penetration", "m", |r| {
        Some(r.figures.summary.penetration)
    }),
    output("penetration_work", "penetration", "J", |r| {
        Some(r.figures.energy.penetration)
    }),
    event!(t1),
    event!(t2),
    event!(t3),
    event!(t4),
    event!(t5),
    event!(t6),
    event!(t7),
    event!(t8),
    event!(t9),
    event!(t10),
    event!(t11),
    event!(t12),
    event!(t13),
    event!(t14),
    event!(t15),
    event!(t16),
    event!(t17),
    event!(t18),
    output("peak_penetration_force", "forces", "N", |r| {
        Some(peak(r.history("nail.force"), 1.0))
    }),
    output("peak_support_force", "forces", "N", |r| {
        Some(peak(r.history("support.force"), 1.0))
    }),
    output("peak_nose_force", "forces", "N", |r| {
        Some(peak(r.history("nose.force"), 1.0))
    }),
    output("peak_cap_force", "forces", "N", |r| {
        Some(peak(r.history("cap.force"), -1.0))
    }),
    output("peak_seat_force", "forces", "N", |r| {
        Some(peak(r.history("seat.force"), 1.0))
    }),
    output("peak_bumper_force", "forces", "N", |r| {
        Some(peak(r.history("bumper.force"), 1.0))
    }),
    output("peak_stopper_force", "forces", "N", |r| {
        Some(peak(r.history("stopper.force"), -1.0))
    }),
    output("exhaust_mass", "masses", "kg", |r| Some(r.figures.summary.exhaust_mass)),
    output("vent_mass", "masses", "kg", |r| Some(r.figures.summary.vent_mass)),
    output("leak_mass", "masses", "kg", |r| Some(r.figures.summary.leak_mass)),
    output("supply_mass", "masses", "kg", |r| Some(r.figures.summary.supply_mass)),
];

/// The default figures, unless others are named.
pub const USUAL: [&str; 7] = [
    "speed_before_impact",
    "mean_drive_speed",
    "penetration",
    "penetration_work",
    "t13",
    "peak_support_force",
    "exhaust_mass",
];

/// The figures with these names or in these groups, in the order of [`OUTPUTS`]; `all` selects every figure.
///
/// # Errors
/// [`Error::NoSuchOutput`] for the first name that is neither a figure nor a group.
pub fn choose(names: &[impl AsRef<str>]) -> Result<Vec<Output>, Error> {
    let is = |output: &Output, name: &str| name == "all" || output.name == name || output.group == name;
    let names: Vec<&str> = names.iter().map(|name| name.as_ref().trim()).collect();
    if let Some(name) = names.iter().find(|name| !OUTPUTS.iter().any(|output| is(output, name))) {
        let known = OUTPUTS.iter().map(|output| output.name).collect::<Vec<_>>().join(", ");
        return Err(Error::NoSuchOutput {
            name: (*name).to_owned(),
            known,
        });
    }
    Ok(OUTPUTS
        .iter()
        .filter(|output| names.iter().any(|name| is(output, name)))
        .copied()
        .collect())
}

/// Largest value of `sign` times a history, interpolated between samples.
///
/// The samples of a contact of 70 us miss its peak by up to 0.4 %, and this error changes with every parameter; the
/// parabola through the three highest samples leaves about 1e-5.
pub(super) fn peak(values: &[f64], sign: f64) -> f64 {
    let value = |index: usize| sign * values[index];
    let Some(top) = (0..values.len()).max_by(|a, b| value(*a).total_cmp(&value(*b))) else {
        return 0.0;
    };
    if top == 0 || top + 1 == values.len() {
        return value(top);
    }
    let (left, middle, right) = (value(top - 1), value(top), value(top + 1));
    // A peak at the beginning or end of a contact is a jump, which a parabola does not fit.
    if left <= 0.0 || right <= 0.0 {
        return middle;
    }
    let curvature = left - 2.0 * middle + right;
    let slope = 0.5 * (right - left);
    if curvature < 0.0 {
        middle - 0.5 * slope * slope / curvature
    } else {
        middle
    }
}

/// Interpolates a history at a given time by the cubic through the four samples around it, or linearly between the
/// first two and the last two; none outside the record.
///
/// The error of linear interpolation varies with the time between samples, by more than a derivative tolerates.
pub(super) fn smoothly_interpolated(values: &[f64], interval: f64, time: f64) -> Option<f64> {
    let place = time / interval;
    let index = place.floor() as usize;
    let t = place - index as f64;
    match (
        index.checked_sub(1).and_then(|before| values.get(before)),
        values.get(index..index + 3),
    ) {
        (Some(a), Some(&[b, c, d])) => {
            let [left, right] = [t * (1.0 - t) * (2.0 - t), t * (1.0 - t) * (1.0 + t)];
            let middle = (1.0 - t) * (1.0 + t) * (2.0 - t) * b + t * (1.0 + t) * (2.0 - t) * c;
            Some(0.5 * middle - (left * a + right * d) / 6.0)
        }
        _ => interpolated(values, interval, time),
    }
}

/// A history with a sampling interval at a given time, interpolated linearly; none outside the record.
pub(crate) fn interpolated(values: &[f64], interval: f64, time: f64) -> Option<f64> {
    let place = time / interval;
    let index = place.floor().max(0.0) as usize;
    let (low, high) = (values.get(index)?, values.get(index + 1).or(values.get(index))?);
    Some(low + (high - low) * (place - index as f64))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_peak_between_samples_is_found() {
        for phase in [0.0, 0.2, 0.5, 0.9] {
            let wave: Vec<f64> = (0..40)
                .map(|i| (0.17 * (f64::from(i) + phase)).sin().max(0.0))
                .collect();
            // A parabola through samples at an interval h misses the crest of a sine by no more than h^4/64.
            assert!(
                (peak(&wave, 1.0) - 1.0).abs() < 0.17f64.powi(4) / 64.0,
                "{}",
                peak(&wave, 1.0)
            );
            let mirrored: Vec<f64> = wave.iter().map(|f| -f).collect();
            assert_eq!(peak(&mirrored, -1.0), peak(&wave, 1.0));
        }
    }

    #[test]
    fn a_cubic_is_interpolated_exactly() {
        let cubic = |t: f64| 1.0 + t * (2.0 + t * (-3.0 + 0.5 * t));
        let samples: Vec<f64> = (0..8).map(|i| cubic(0.1 * f64::from(i))).collect();
        for time in [0.1, 0.15, 0.37, 0.59] {
            let found = smoothly_interpolated(&samples, 0.1, time).unwrap_or(f64::NAN);
            assert!((found - cubic(time)).abs() < 1e-14, "{time}: {found}");
        }
        assert_eq!(
            smoothly_interpolated(&samples, 0.1, 0.05),
            Some(0.5 * (samples[0] + samples[1]))
        );
        assert_eq!(smoothly_interpolated(&samples, 0.1, 0.9), None);
    }

    #[test]
    fn a_jump_and_a_plateau_keep_their_height() {
        assert_eq!(peak(&[0.0, 0.0, 5.0, 4.0, 3.0], 1.0), 5.0);
        assert_eq!(peak(&[1.0, 2.0, 2.0, 1.0], 1.0), 2.0 + 0.125);
        assert_eq!(peak(&[0.0; 4], 1.0), 0.0);
        assert_eq!(peak(&[], 1.0), 0.0);
    }

    #[test]
    fn names_are_unique() {
        let mut names: Vec<&str> = OUTPUTS.iter().map(|output| output.name).collect();
        names.sort_unstable();
        names.dedup();
        assert_eq!(names.len(), OUTPUTS.len());
    }
}
