//! Physical dimensions.

use std::fmt;

/// Exponents of length, mass, time, temperature, plane angle and electric current.
///
/// Plane angle has its own dimension, so that a plain ratio given in degrees is an error.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Dimension {
    length: i8,
    mass: i8,
    time: i8,
    temperature: i8,
    angle: i8,
    current: i8,
}

impl Dimension {
    /// The dimension with these exponents of length, mass, time, temperature, angle and current.
    pub(crate) const fn new(length: i8, mass: i8, time: i8, temperature: i8, angle: i8, current: i8) -> Self {
        Self {
            length,
            mass,
            time,
            temperature,
            angle,
            current,
        }
    }

    /// The product `self * other^power`, or `None` if an exponent exceeds the range of `i8`.
    pub fn times(self, other: Self, power: i32) -> Option<Self> {
        let exponent = |a: i8, b: i8| i8::try_from(i32::from(b).checked_mul(power)?.checked_add(i32::from(a))?).ok();
        Some(Self {
            length: exponent(self.length, other.length)?,
            mass: exponent(self.mass, other.mass)?,
            time: exponent(self.time, other.time)?,
            temperature: exponent(self.temperature, other.temperature)?,
            angle: exponent(self.angle, other.angle)?,
            current: exponent(self.current, other.current)?,
        })
    }

    /// The dimension whose square is `self`, or `None` if an exponent is odd.
    pub fn square_root(self) -> Option<Self> {
        let exponents = [
            self.length,
            self.mass,
            self.time,
            self.temperature,
            self.angle,
            self.current,
        ];
        let even = exponents.iter().all(|exponent| exponent % 2 == 0);
        let [length, mass, time, temperature, angle, current] = exponents.map(|exponent| exponent / 2);
        even.then_some(Self::new(length, mass, time, temperature, angle, current))
    }

    /// The SI unit of the design file for this dimension; empty for a plain number.
    pub fn unit(self) -> String {
        self.named()
            .map_or_else(|| self.base_units(), |named| named.unit.to_owned())
    }

    /// Common engineering units of this dimension, for the remedy of an error.
    pub fn examples(self) -> String {
        self.named()
            .map_or_else(|| self.base_units(), |named| named.examples.to_owned())
    }

    /// Smallest and largest plausible magnitude of a quantity of this dimension, in SI units, for a hand-held machine,
    /// its surroundings and its test rig. Unbounded if the dimension has no name.
    pub fn magnitudes(self) -> [f64; 2] {
        self.named()
            .map_or([f64::MIN_POSITIVE, f64::MAX], |named| named.magnitudes)
    }

    /// Scale factor and unit for displaying a value of this dimension.
    pub fn readable(self) -> (f64, String) {
        match self {
            LENGTH => (1e3, "mm".to_owned()),
            AREA => (1e6, "mm2".to_owned()),
            VOLUME => (1e6, "cm3".to_owned()),
            TIME => (1e3, "ms".to_owned()),
            PRESSURE => (1e-3, "kPa".to_owned()),
            _ => (1.0, self.unit()),
        }
    }

    fn named(self) -> Option<&'static Named> {
        NAMED.iter().find(|named| named.dimension == self)
    }

    fn base_units(self) -> String {
        let exponents = [
            ("m", self.length),
            ("kg", self.mass),
            ("s", self.time),
            ("K", self.temperature),
            ("rad", self.angle),
            ("A", self.current),
        ];
        let power = |unit: &str, n: i8| if n == 1 { unit.to_owned() } else { format!("{unit}{n}") };
        let parts: Vec<_> = exponents
            .iter()
            .filter(|(_, n)| *n != 0)
            .map(|(unit, n)| power(unit, *n))
            .collect();
        parts.join(" ")
    }
}

/// "a pressure", "a length", or the base units if the dimension has no name.
impl fmt::Display for Dimension {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.named() {
            Some(named) => f.write_str(named.name),
            None => write!(f, "a quantity in {}", self.base_units()),
        }
    }
}

struct Named {
    dimension: Dimension,
    name: &'static str,
    unit: &'static str,
    examples: &'static str,
    magnitudes: [f64; 2],
}

macro_rules! dimensions {
    ($($constant:ident = [$($exponent:literal),+] $name:literal, $unit:literal, $examples:literal, $least:literal,
        $most:literal;)+) => {
        $(#[doc = concat!("Dimension of ", $name, ", in SI `", $unit, "`.")]
        pub const $constant: Dimension = Dimension::new($($exponent),+);)+
        const NAMED: &[Named] = &[$(Named {
            dimension: $constant,
            name: $name,
            unit: $unit,
            examples: $examples,
            magnitudes: [$least, $most],
        }),+];
    };
}

dimensions! {
    NUMBER = [0, 0, 0, 0, 0, 0] "a plain number", "", "none, or %", 1e-15, 1e9;
    LENGTH = [1, 0, 0, 0, 0, 0] "a length", "m", "m, mm, in", 1e-6, 100.0;
    AREA = [2, 0, 0, 0, 0, 0] "an area", "m2", "m2, cm2, mm2", 1e-15, 100.0;
    VOLUME = [3, 0, 0, 0, 0, 0] "a volume", "m3", "m3, l, cm3", 1e-9, 1.0;
    MASS = [0, 1, 0, 0, 0, 0] "a mass", "kg", "kg, g, lb", 1e-5, 1000.0;
    TIME = [0, 0, 1, 0, 0, 0] "a time", "s", "s, ms, us", 1e-7, 10.0;
    FREQUENCY = [0, 0, -1, 0, 0, 0] "a frequency", "Hz", "Hz, kHz", 0.01, 100000.0;
    TEMPERATURE = [0, 0, 0, 1, 0, 0] "a temperature", "K", "K, degC", 150.0, 500.0;
    ANGLE = [0, 0, 0, 0, 1, 0] "an angle", "rad", "rad, deg", 0.01, 1.6;
    VELOCITY = [1, 0, -1, 0, 0, 0] "a velocity", "m/s", "m/s, mm/s", 1e-6, 1000.0;
    VELOCITY_SQUARED = [2, 0, -2, 0, 0, 0] "a squared velocity", "m2/s2", "m2/s2, J/kg", 1e-6, 1e6;
    ACCELERATION = [1, 0, -2, 0, 0, 0] "an acceleration", "m/s2", "m/s2", 0.001, 100.0;
    FORCE = [1, 1, -2, 0, 0, 0] "a force", "N", "N, kN, lbf", 0.001, 100000.0;
    PRESSURE = [-1, 1, -2, 0, 0, 0] "a pressure", "Pa", "Pa, kPa, MPa, GPa, bar, psi", 1.0, 1e13;
    STIFFNESS = [0, 1, -2, 0, 0, 0] "a stiffness", "N/m", "N/m, N/mm, kN/mm", 1.0, 1e15;
    DAMPING = [0, 1, -1, 0, 0, 0] "a mass flow (or damping coefficient)", "N s/m", "N s/m, N s/mm; kg/s, g/s",
        0.001, 1e7;
    STIFFNESS_PER_AREA = [-2, 1, -2, 0, 0, 0] "a stiffness per area", "N/m3", "N/m3, N/mm3", 1.0, 1e14;
    DENSITY = [-3, 1, 0, 0, 0, 0] "a density", "kg/m3", "kg/m3, g/cm3", 1.0, 30000.0;
    HEAT_TRANSFER = [0, 1, -3, -1, 0, 0] "a heat transfer coefficient", "W/(m2 K)", "W/(m2 K)", 0.001, 100000.0;
    GAS_CONSTANT = [2, 0, -2, -1, 0, 0] "a specific gas constant", "J/(kg K)", "J/(kg K)", 50.0, 5000.0;
    VISCOSITY = [-1, 1, -1, 0, 0, 0] "a dynamic viscosity", "Pa s", "Pa s, mPa s", 1e-6, 0.01;
    FLOW_RESISTIVITY = [-3, 1, -1, 0, 0, 0] "a flow resistivity", "Pa s/m2", "Pa s/m2, kPa s/m2", 10.0, 1e9;
    ENERGY = [2, 1, -2, 0, 0, 0] "an energy", "J", "J, mJ", 1e-9, 1e6;
    POWER = [2, 1, -3, 0, 0, 0] "a power", "W", "W, mW", 1e-9, 1e6;
    FLOW = [3, 0, -1, 0, 0, 0] "a volume flow", "m3/s", "m3/s, l/min", 1e-9, 10.0;
    MASS_FLOW = [0, 1, -1, 0, 0, 0] "a mass flow", "kg/s", "kg/s, g/s", 1e-9, 10.0;
    VOLTAGE = [2, 1, -3, 0, 0, -1] "a voltage", "V", "V, mV", 1e-9, 1e4;
    VOLTAGE_PER_PRESSURE = [3, 0, -1, 0, 0, -1] "a sensitivity to pressure", "V/Pa", "V/Pa, mV/Pa, mV/kPa", 1e-12, 1e3;
    VOLTAGE_PER_ACCELERATION = [1, 1, -1, 0, 0, -1] "a sensitivity to acceleration", "V/(m/s2)",
        "mV/g, mV/(m/s2)", 1e-9, 1e3;
}
