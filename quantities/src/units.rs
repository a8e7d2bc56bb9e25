//! Units as engineers write them: "N s/mm", "kg/m3", "W/(m2 K)", "psig".

use crate::dimension::*;

/// A unit: a quantity of `x` units is `x * factor * 10^exponent + offset` in SI.
///
/// Powers of ten are stored separately, so that "763.2 kPa" is the same binary number as 763200 Pa.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Unit {
    pub(crate) dimension: Dimension,
    pub(crate) factor: f64,
    pub(crate) exponent: i32,
    pub(crate) offset: f64,
    /// Whether the unit is relative to ambient pressure.
    pub(crate) gauge: bool,
}

/// Why a text is not a unit.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum UnitError {
    /// A symbol that is neither a unit nor a prefix with a unit.
    #[error("`{0}` is no unit known here")]
    Unknown(String),
    /// A multiplication after a division, which is ambiguous.
    #[error("`{0}` can be read in two ways: write a/(b c) or a/b/c")]
    Ambiguous(String),
    /// Unbalanced brackets or invalid signs or exponents.
    #[error("`{0}` is no product of units")]
    Malformed(String),
}

struct Atom {
    symbol: &'static str,
    dimension: Dimension,
    factor: f64,
    exponent: i32,
    prefixes: bool,
}

const fn metric(symbol: &'static str, dimension: Dimension, exponent: i32) -> Atom {
    Atom {
        symbol,
        dimension,
        factor: 1.0,
        exponent,
        prefixes: true,
    }
}

const fn plain(symbol: &'static str, dimension: Dimension, factor: f64, exponent: i32) -> Atom {
    Atom {
        symbol,
        dimension,
        factor,
        exponent,
        prefixes: false,
    }
}

/// Pound-force per square inch: 0.453 592 37 kg x 9.806 65 m/s2 / (25.4 mm)^2.
const PSI: f64 = 0.453_592_37 * 9.806_65 / (0.0254 * 0.0254);

const ATOMS: &[Atom] = &[
    metric("m", LENGTH, 0),
    metric("g", MASS, -3),
    metric("s", TIME, 0),
    metric("K", TEMPERATURE, 0),
    metric("rad", ANGLE, 0),
    metric("N", FORCE, 0),
    metric("Pa", PRESSURE, 0),
    metric("J", ENERGY, 0),
    metric("W", POWER, 0),
    metric("V", VOLTAGE, 0),
    metric("Hz", FREQUENCY, 0),
    metric("bar", PRESSURE, 5),
    metric("l", VOLUME, -3),
    metric("L", VOLUME, -3),
    plain("%", NUMBER, 1.0, -2),
    plain("deg", ANGLE, std::f64::consts::PI / 180.0, 0),
    plain("°", ANGLE, std::f64::consts::PI / 180.0, 0),
    plain("min", TIME, 60.0, 0),
    plain("in", LENGTH, 254.0, -4),
    plain("inch", LENGTH, 254.0, -4),
    plain("ft", LENGTH, 3048.0, -4),
    plain("lb", MASS, 45_359_237.0, -8),
    plain("lbm", MASS, 45_359_237.0, -8),
    plain("oz", MASS, 28_349_523_125.0, -12),
    plain("lbf", FORCE, 0.453_592_37 * 9.806_65, 0),
    plain("psi", PRESSURE, PSI, 0),
    plain("psia", PRESSURE, PSI, 0),
    plain("bara", PRESSURE, 1.0, 5),
    plain("atm", PRESSURE, 101_325.0, 0),
];

const PREFIXES: &[(&str, i32)] = &[
    ("n", -9),
    ("u", -6),
    ("µ", -6),
    ("μ", -6),
    ("m", -3),
    ("c", -2),
    ("d", -1),
    ("k", 3),
    ("M", 6),
    ("G", 9),
];

impl Unit {
    const ONE: Self = Self {
        dimension: NUMBER,
        factor: 1.0,
        exponent: 0,
        offset: 0.0,
        gauge: false,
    };

    /// Parses a unit; an empty string means a plain number.
    pub(crate) fn parse(text: &str) -> Result<Self, UnitError> {
        let text = text.trim();
        if text.is_empty() {
            return Ok(Self::ONE);
        }
        if matches!(text, "degC" | "°C") {
            return Ok(Self {
                dimension: TEMPERATURE,
                offset: 273.15,
                ..Self::ONE
            });
        }
        if let Some(unit) = gauge(text) {
            return Ok(unit);
        }
        let mut reader = Reader { text, rest: text };
        let unit = reader.product(0)?;
        if reader.rest.is_empty() {
            Ok(unit)
        } else {
            Err(UnitError::Malformed(text.to_owned()))
        }
    }

    fn times(self, other: Self, power: i32) -> Option<Self> {
        Some(Self {
            dimension: self.dimension.times(other.dimension, power)?,
            factor: self.factor * other.factor.powi(power),
            exponent: self.exponent.checked_add(other.exponent.checked_mul(power)?)?,
            ..Self::ONE
        })
    }
}

impl Dimension {
    /// The dimension of a unit; a plain number for the empty text.
    ///
    /// # Errors
    /// [`UnitError`], the text is not a unit.
    pub fn of_unit(unit: &str) -> Result<Self, UnitError> {
        Unit::parse(unit).map(|unit| unit.dimension)
    }
}

/// A pressure unit with the suffix g, as in psig, barg, kPag.
fn gauge(text: &str) -> Option<Unit> {
    let unit = atom(text.strip_suffix('g')?)?;
    (unit.dimension == PRESSURE).then_some(Unit { gauge: true, ..unit })
}

fn atom(symbol: &str) -> Option<Unit> {
    let unit = |atom: &Atom, prefix: i32| Unit {
        dimension: atom.dimension,
        factor: atom.factor,
        exponent: atom.exponent + prefix,
        ..Unit::ONE
    };
    if let Some(found) = ATOMS.iter().find(|atom| atom.symbol == symbol) {
        return Some(unit(found, 0));
    }
    PREFIXES.iter().find_map(|(prefix, power)| {
        let stem = symbol.strip_prefix(prefix)?;
        ATOMS
            .iter()
            .find(|atom| atom.prefixes && atom.symbol == stem)
            .map(|atom| unit(atom, *power))
    })
}

/// Parses products and quotients of units with integer exponents.
struct Reader<'a> {
    text: &'a str,
    rest: &'a str,
}

impl Reader<'_> {
    const DEEPEST: u32 = 8;

    fn product(&mut self, depth: u32) -> Result<Unit, UnitError> {
        if depth > Self::DEEPEST {
            return Err(self.malformed());
        }
        let mut unit = self.factor(depth)?;
        let mut divided = false;
        loop {
            self.rest = self.rest.trim_start();
            let power = match self.rest.chars().next() {
                None | Some(')') => return Ok(unit),
                Some('/') => {
                    self.rest = &self.rest[1..];
                    divided = true;
                    -1
                }
                Some(_) if divided => return Err(UnitError::Ambiguous(self.text.to_owned())),
                Some(c @ ('*' | '·')) => {
                    self.rest = &self.rest[c.len_utf8()..];
                    1
                }
                Some(_) => 1,
            };
            let factor = self.factor(depth)?;
            unit = unit.times(factor, power).ok_or_else(|| self.malformed())?;
        }
    }

    fn factor(&mut self, depth: u32) -> Result<Unit, UnitError> {
        self.rest = self.rest.trim_start();
        if let Some(inner) = self.rest.strip_prefix('(') {
            self.rest = inner;
            let unit = self.product(depth + 1)?;
            self.rest = self.rest.strip_prefix(')').ok_or_else(|| self.malformed())?;
            return Ok(unit);
        }
        let end = self.rest.find(|c: char| !is_symbol(c)).unwrap_or(self.rest.len());
        let (symbol, rest) = self.rest.split_at(end);
        if symbol.is_empty() {
            return Err(self.malformed());
        }
        self.rest = rest;
        let unit = atom(symbol).ok_or_else(|| UnitError::Unknown(symbol.to_owned()))?;
        let power = self.exponent()?;
        Unit::ONE.times(unit, power).ok_or_else(|| self.malformed())
    }

    fn exponent(&mut self) -> Result<i32, UnitError> {
        for (raised, power) in [('²', 2), ('³', 3)] {
            if let Some(rest) = self.rest.strip_prefix(raised) {
                self.rest = rest;
                return Ok(power);
            }
        }
        let (marked, digits) = match self.rest.strip_prefix('^') {
            Some(rest) => (true, rest),
            None => (false, self.rest),
        };
        let (sign, digits) = match digits.strip_prefix('-') {
            Some(rest) => (-1, rest),
            None => (1, digits),
        };
        let end = digits.find(|c: char| !c.is_ascii_digit()).unwrap_or(digits.len());
        if end == 0 && !marked && sign == 1 {
            return Ok(1);
        }
        let power: i32 = digits[..end].parse().map_err(|_| self.malformed())?;
        if power > 9 {
            return Err(self.malformed());
        }
        self.rest = &digits[end..];
        Ok(sign * power)
    }

    fn malformed(&self) -> UnitError {
        UnitError::Malformed(self.text.to_owned())
    }
}

fn is_symbol(c: char) -> bool {
    c.is_alphabetic() || matches!(c, '%' | '°' | 'µ')
}

#[cfg(test)]
mod tests {
    use super::*;

    fn si(text: &str) -> (f64, Dimension) {
        let unit = Unit::parse(text).unwrap();
        (unit.factor * 10f64.powi(unit.exponent), unit.dimension)
    }

    #[test]
    fn engineers_units_have_their_si_values() {
        for (text, value, dimension) in [
            ("kPa", 1e3, PRESSURE),
            ("psi", 6_894.757_293_168_361, PRESSURE),
            ("N/mm", 1e3, STIFFNESS),
            ("N s/mm", 1e3, DAMPING),
            ("N·s/m", 1.0, DAMPING),
            ("kg/m3", 1.0, DENSITY),
            ("g/cm^3", 1e3, DENSITY),
            ("W/(m2 K)", 1.0, HEAT_TRANSFER),
            ("W/m²/K", 1.0, HEAT_TRANSFER),
            ("J/(kg K)", 1.0, GAS_CONSTANT),
            ("l/min", 1e-3 / 60.0, FLOW),
            ("m2/s2", 1.0, VELOCITY_SQUARED),
            ("J/kg", 1.0, VELOCITY_SQUARED),
            ("Pa s/m2", 1.0, FLOW_RESISTIVITY),
            ("N/mm3", 1e9, STIFFNESS_PER_AREA),
            ("lb", 0.453_592_37, MASS),
            ("in", 0.0254, LENGTH),
            ("us", 1e-6, TIME),
            ("µs", 1e-6, TIME),
            ("kHz", 1e3, FREQUENCY),
            ("s-1", 1.0, FREQUENCY),
            ("deg", 0.017_453_292_519_943_295, ANGLE),
            ("%", 0.01, NUMBER),
            ("lbf/in2", 6_894.757_293_168_361, PRESSURE),
        ] {
            let (got, of) = si(text);
            assert_eq!(of, dimension, "{text}");
            assert!((got / value - 1.0).abs() < 1e-14, "{text}: {got} is not {value}");
        }
    }

    #[test]
    fn gauge_is_a_suffix_of_pressures_only() {
        for text in ["psig", "barg", "kPag"] {
            assert!(Unit::parse(text).unwrap().gauge, "{text}");
        }
        assert!(!Unit::parse("kg").unwrap().gauge);
        assert!(!Unit::parse("psia").unwrap().gauge);
        assert!(Unit::parse("Ng").is_err());
    }

    #[test]
    fn a_product_after_a_division_is_refused() {
        for text in ["W/m2 K", "W/m2K", "J/kg*K"] {
            assert!(matches!(Unit::parse(text), Err(UnitError::Ambiguous(_))), "{text}");
        }
    }

    #[test]
    fn nonsense_is_refused() {
        for text in [
            "/",
            "m/",
            "m2^",
            "(m",
            "m)",
            "m99999999999",
            "m^--2",
            "furlong",
            "((((((((((m))))))))))",
            "m-",
        ] {
            assert!(Unit::parse(text).is_err(), "{text}");
        }
    }
}
