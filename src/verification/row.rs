use serde::Serialize;

/// A benchmark: its name and the origin of its reference values.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
pub struct Case {
    /// Name of the benchmark.
    #[serde(rename = "case")]
    pub name: &'static str,
    /// Publication, standard with edition, or closed form.
    pub source: &'static str,
}

impl Case {
    /// A row of this case, without a tolerance yet.
    pub fn row(self, quantity: impl Into<String>, reference: f64, computed: f64) -> Row {
        Row {
            case: self,
            quantity: quantity.into(),
            reference,
            computed,
            limits: [reference; 2],
            documented: None,
            decimals: 2,
        }
    }
}

/// One reference value and the computed one.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Row {
    /// The benchmark.
    #[serde(flatten)]
    pub case: Case,
    /// The quantity, with its unit.
    pub quantity: String,
    /// The reference value.
    pub reference: f64,
    /// The computed value.
    pub computed: f64,
    /// Smallest and largest permitted value; infinite (null in JSON) if there is no limit.
    pub limits: [f64; 2],
    /// Range of a known disagreement (computed minus reference), as stated in `docs/limits.md`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub documented: Option<[f64; 2]>,
    /// Decimals shown.
    #[serde(skip)]
    pub decimals: usize,
}

/// Result of comparing a computed value with its reference.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Verdict {
    /// Inside the limits.
    Agrees,
    /// Outside the limits, but as stated in `docs/limits.md`.
    Documented,
    /// Outside the limits.
    Fails,
}

impl Row {
    /// Permits a difference to either side.
    #[must_use]
    pub fn within(self, tolerance: f64) -> Self {
        let limits = [self.reference - tolerance, self.reference + tolerance];
        Self { limits, ..self }
    }

    /// Permits a fraction of the reference to either side.
    #[must_use]
    pub fn within_part(self, part: f64) -> Self {
        let tolerance = part * self.reference.abs();
        self.within(tolerance)
    }

    /// Sets both limits.
    #[must_use]
    pub fn limits(self, limits: [f64; 2]) -> Self {
        Self { limits, ..self }
    }

    /// Accepts a disagreement in the range stated in `docs/limits.md`, computed minus reference.
    #[must_use]
    pub fn documented(self, range: [f64; 2]) -> Self {
        Self {
            documented: Some(range),
            ..self
        }
    }

    /// Sets the decimals shown.
    #[must_use]
    pub fn decimals(self, decimals: usize) -> Self {
        Self { decimals, ..self }
    }

    /// Fraction of the tolerance used on the side of the deviation; 1 at its limit. If the reference is itself the
    /// lower limit (a minimum attenuation in decibels), the transmitted energy divided by the permitted energy.
    pub fn share(&self) -> f64 {
        let [low, high] = self.limits;
        let deviation = self.computed - self.reference;
        if self.reference == low {
            10f64.powf(-deviation / 10.0)
        } else if deviation < 0.0 {
            deviation / (low - self.reference)
        } else {
            deviation / (high - self.reference)
        }
    }

    /// The verdict; a value that is not a number fails.
    pub fn verdict(&self) -> Verdict {
        let deviation = self.computed - self.reference;
        match self.documented {
            _ if self.share() <= 1.0 => Verdict::Agrees,
            Some([least, most]) if (least..=most).contains(&deviation) => Verdict::Documented,
            _ => Verdict::Fails,
        }
    }

    /// A value of this row with its decimals; negative zero is shown as zero.
    pub fn number(&self, value: f64) -> String {
        let text = format!("{value:.0$}", self.decimals);
        let zero = text.chars().all(|c| "-0.".contains(c));
        if zero { text.replace('-', "") } else { text }
    }

    /// The limits, as `+-x` about the reference if they are symmetric, otherwise as `a to b`.
    pub fn tolerance(&self) -> String {
        let [low, high] = self.limits;
        let (below, above) = (self.reference - low, high - self.reference);
        // The difference of two sums has rounding errors of some 1e-12 of the reference.
        let rounding = 1e-12 * self.reference.abs() + 1e-9 * above;
        if below.is_finite() && (below - above).abs() <= rounding {
            let text = self.number(above);
            let shows = text
                .parse::<f64>()
                .is_ok_and(|shown| (shown - above).abs() <= 0.1 * above);
            return match above {
                _ if shows => format!("+-{text}"),
                above if above < 1e-4 => format!("+-{above:.0e}"),
                // Two digits.
                above => format!("+-{above:.0$}", (1.0 - above.log10().floor()).max(0.0) as usize),
            };
        }
        let one = |x: f64, open: &str| if x.is_finite() { self.number(x) } else { open.to_owned() };
        format!("{} to {}", one(low, "-inf"), one(high, "inf"))
    }

    /// The fraction of the tolerance used, such as `12 %`; `stated` if the disagreement is in `docs/limits.md`.
    pub fn used(&self) -> String {
        match self.verdict() {
            Verdict::Agrees => format!("{:.0} %", 100.0 * self.share().abs()),
            Verdict::Documented => "stated".to_owned(),
            Verdict::Fails => "FAILS".to_owned(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const CASE: Case = Case {
        name: "case",
        source: "source",
    };

    #[test]
    fn the_share_is_one_at_either_limit() {
        let row = |computed| CASE.row("x", 10.0, computed).limits([8.0, 14.0]);
        for (computed, share) in [(8.0, 1.0), (9.0, 0.5), (10.0, 0.0), (12.0, 0.5), (14.0, 1.0)] {
            assert_eq!(row(computed).share(), share);
        }
        assert_eq!(row(7.9).verdict(), Verdict::Fails);
        assert_eq!(row(14.0).verdict(), Verdict::Agrees);
    }

    #[test]
    fn a_least_attenuation_uses_the_energy_that_passes() {
        let row = CASE.row("attenuation, dB", 16.0, 26.0).limits([16.0, f64::INFINITY]);
        assert!((row.share() - 0.1).abs() < 1e-12);
    }

    #[test]
    fn a_documented_disagreement_holds_within_its_range_only() {
        let row = |computed| CASE.row("x", 10.0, computed).within(1.0).documented([-3.0, 2.0]);
        assert_eq!(row(10.5).verdict(), Verdict::Agrees);
        assert_eq!(row(7.0).verdict(), Verdict::Documented);
        assert_eq!(row(6.9).verdict(), Verdict::Fails);
        assert_eq!(row(12.1).verdict(), Verdict::Fails);
    }

    #[test]
    fn no_number_fails() {
        let row = CASE.row("x", 10.0, f64::NAN).within(1.0).documented([-30.0, 30.0]);
        assert_eq!(row.verdict(), Verdict::Fails);
    }

    #[test]
    fn a_tolerance_shows_at_least_one_digit() {
        let text = |tolerance| CASE.row("x", 1.0, 1.0).within(tolerance).tolerance();
        assert_eq!((text(0.25).as_str(), text(1e-6).as_str()), ("+-0.25", "+-1e-6"));
        assert_eq!(
            CASE.row("x", 1.0, 1.0).limits([f64::NEG_INFINITY, 2.0]).tolerance(),
            "-inf to 2.00"
        );
    }
}
