//! A result as people read it: the numbers of each row in one readable unit.

use super::result::CalibrationResult;
use crate::units::Units;
use crate::wording::readable_at;

/// The unit of a row, and the conversion to it from SI units.
struct Scale {
    unit: String,
    factor: f64,
    offset: f64,
}

impl Scale {
    /// The unit for these values of an SI unit.
    fn of(unit: &str, values: &[f64], units: Units) -> Self {
        let finite = values.iter().filter(|value| value.is_finite());
        let largest = finite.fold(0.0, |largest: f64, value| largest.max(value.abs()));
        let (metric, factor) = readable_at(unit, largest);
        match units.conversion(metric, factor * largest) {
            None => Self {
                unit: metric.to_owned(),
                factor,
                offset: 0.0,
            },
            Some(own) => Self {
                unit: own.unit.to_owned(),
                factor: factor * own.factor,
                offset: own.offset,
            },
        }
    }

    fn value(&self, value: f64) -> f64 {
        value * self.factor + self.offset
    }
}

impl CalibrationResult {
    /// The result for people: measurements, inputs, figures, conflicts and the errors of further measurements in
    /// readable units of this system instead of SI units.
    pub(crate) fn shown(&self, units: Units) -> Self {
        let mut shown = self.clone();
        for own in &mut shown.measurements {
            let readings = own.reading.into_iter().flatten();
            let values: Vec<f64> = readings.chain(own.before).chain(own.now).collect();
            let scale = Scale::of(&own.unit, &values, units);
            own.reading = own.reading.map(|end| end.map(|end| scale.value(end)));
            own.before = own.before.map(|end| scale.value(end));
            own.now = own.now.map(|end| scale.value(end));
            own.unit = scale.unit;
        }
        for own in &mut shown.conflicts {
            let scale = Scale::of(&own.unit, own.nearest.as_slice(), units);
            own.nearest = own.nearest.map(|nearest| scale.value(nearest));
            own.unit = scale.unit;
        }
        for own in &mut shown.inputs {
            let values: Vec<f64> = own.before.into_iter().chain(own.now).chain([own.medoid]).collect();
            let scale = Scale::of(&own.unit, &values, units);
            own.before = own.before.map(|end| scale.value(end));
            own.now = own.now.map(|end| scale.value(end));
            own.medoid = scale.value(own.medoid);
            own.unit = scale.unit;
        }
        for own in &mut shown.figures {
            let values: Vec<f64> = own.before.into_iter().chain(own.now).collect();
            let scale = Scale::of(&own.unit, &values, units);
            own.before = own.before.map(|end| scale.value(end));
            own.now = own.now.map(|end| scale.value(end));
            own.unit = scale.unit;
        }
        for own in &mut shown.next {
            let scale = Scale::of(&own.unit, &[own.error], units);
            own.error *= scale.factor;
            own.unit = scale.unit;
        }
        shown
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_values_of_a_row_have_one_readable_unit() {
        let depth = Scale::of("m", &[3.25e-4, -4.59e-3, f64::NAN], Units::Si);
        assert_eq!((depth.unit.as_str(), depth.value(3.25e-4)), ("mm", 0.325));
        let us = Scale::of("m", &[3.25e-4, -4.59e-3], Units::Us);
        assert_eq!(us.unit, "in");
        assert!((us.value(-4.59e-3) + 0.180_709).abs() < 1e-6);
        let pressure = Scale::of("Pa", &[7.6e5], Units::Us);
        assert!(pressure.unit == "psi" && (pressure.value(7.6e5) - 110.228).abs() < 1e-3);
        let level = Scale::of("dB", &[101.0], Units::Us);
        assert_eq!((level.unit.as_str(), level.value(101.0)), ("dB", 101.0));
        // 20 degC.
        let temperature = Scale::of("K", &[293.15], Units::Us);
        assert!(temperature.unit == "degF" && (temperature.value(293.15) - 68.0).abs() < 1e-9);
    }
}
