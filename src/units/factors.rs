//! Conversion of metric units to those of the United States.
//!
//! Exact definitions: the inch of 25.4 mm and the avoirdupois pound of 0.453 592 37 kg (international yard and pound
//! agreement of 1959), the standard acceleration of gravity of 9.806 65 m/s2 (CGPM 1901), the British thermal unit of 1
//! 055.055 852 62 J (International Table, 1956). NIST SP 811, appendix B, lists the resulting factors. Standard air has
//! 0.075 lb/ft3 (AMCA 210).

const INCH: f64 = 0.0254;
const FOOT: f64 = 12.0 * INCH;
const POUND: f64 = 0.453_592_37;
const OUNCE: f64 = POUND / 16.0;
const POUND_FORCE: f64 = POUND * 9.806_65;
const PSI: f64 = POUND_FORCE / (INCH * INCH);
const BTU: f64 = 1_055.055_852_62;
const RANKINE: f64 = 5.0 / 9.0;
const CUBIC_FOOT: f64 = FOOT * FOOT * FOOT;

/// Density of the air of a standard cubic foot \[kg/m3\].
const STANDARD_AIR: f64 = 0.075 * POUND / CUBIC_FOOT;

/// Lowest temperature that is not taken for a difference \[K\].
const ABSOLUTE: f64 = 200.0;

/// A conversion: `value * factor + offset` in `unit`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Conversion {
    /// The unit of the result.
    pub(crate) unit: &'static str,
    /// Size of the metric unit in that unit.
    pub(crate) factor: f64,
    /// Value at the zero of the metric unit; zero except for temperatures.
    pub(crate) offset: f64,
}

impl Conversion {
    /// The converted value.
    pub(crate) fn of(self, value: f64) -> f64 {
        value * self.factor + self.offset
    }
}

/// The conversion of a metric unit; `None` for units that are used in both systems. `largest` is the largest magnitude
/// of the values that are shown together, in the metric unit.
pub(super) fn to_us(unit: &str, largest: f64) -> Option<Conversion> {
    let below = |limit: f64| largest < limit;
    let (si, (us, of)) = match unit {
        "um" => (1e-6, ("in", INCH)),
        "mm" => (1e-3, ("in", INCH)),
        "cm" => (1e-2, ("in", INCH)),
        "m" if below(1.0) => (1.0, ("in", INCH)),
        "m" => (1.0, ("ft", FOOT)),
        "mm2" => (1e-6, ("in2", INCH * INCH)),
        "cm2" => (1e-4, ("in2", INCH * INCH)),
        "m2" if below(0.1) => (1.0, ("in2", INCH * INCH)),
        "m2" => (1.0, ("ft2", FOOT * FOOT)),
        "mm3" => (1e-9, ("in3", INCH * INCH * INCH)),
        "cm3" => (1e-6, ("in3", INCH * INCH * INCH)),
        "L" | "l" if below(0.05) => (1e-3, ("in3", INCH * INCH * INCH)),
        "L" | "l" => (1e-3, ("ft3", CUBIC_FOOT)),
        "m3" if below(1e-3) => (1.0, ("in3", INCH * INCH * INCH)),
        "m3" => (1.0, ("ft3", CUBIC_FOOT)),
        "g" if below(500.0) => (1e-3, ("oz", OUNCE)),
        "g" => (1e-3, ("lb", POUND)),
        "kg" if below(0.05) => (1.0, ("oz", OUNCE)),
        "kg" => (1.0, ("lb", POUND)),
        "N" => (1.0, ("lbf", POUND_FORCE)),
        "kN" => (1e3, ("lbf", POUND_FORCE)),
        "Pa" if below(1e8) => (1.0, ("psi", PSI)),
        "Pa" => (1.0, ("ksi", 1e3 * PSI)),
        "kPa" => (1e3, ("psi", PSI)),
        "MPa" if below(100.0) => (1e6, ("psi", PSI)),
        "MPa" => (1e6, ("ksi", 1e3 * PSI)),
        "GPa" => (1e9, ("ksi", 1e3 * PSI)),
        "bar" => (1e5, ("psi", PSI)),
        "barg" => (1e5, ("psig", PSI)),
        "N/mm2" => (1e6, ("psi", PSI)),
        "J" => (1.0, ("ft-lbf", FOOT * POUND_FORCE)),
        "kJ" => (1e3, ("ft-lbf", FOOT * POUND_FORCE)),
        "N m" => (1.0, ("lbf ft", FOOT * POUND_FORCE)),
        "m/s" => (1.0, ("ft/s", FOOT)),
        "mm/s" => (1e-3, ("in/s", INCH)),
        "mm/min" => (1e-3, ("in/min", INCH)),
        "m/s2" => (1.0, ("ft/s2", FOOT)),
        "kg/m3" => (1.0, ("lb/ft3", POUND / CUBIC_FOOT)),
        "g/cm3" => (1e3, ("lb/ft3", POUND / CUBIC_FOOT)),
        "kg/m2" => (1.0, ("lb/ft2", POUND / (FOOT * FOOT))),
        "N/m" => (1.0, ("lbf/in", POUND_FORCE / INCH)),
        "N/mm" => (1e3, ("lbf/in", POUND_FORCE / INCH)),
        "kN/mm" => (1e6, ("lbf/in", POUND_FORCE / INCH)),
        "N/m3" => (1.0, ("lbf/in3", POUND_FORCE / (INCH * INCH * INCH))),
        "m2/s2" => (1.0, ("ft2/s2", FOOT * FOOT)),
        "W/(m2 K)" => (1.0, ("Btu/(h ft2 degF)", BTU / (3600.0 * FOOT * FOOT * RANKINE))),
        "J/(kg K)" => (1.0, ("ft-lbf/(lb degR)", FOOT * POUND_FORCE / (POUND * RANKINE))),
        "N s" => (1.0, ("lbf s", POUND_FORCE)),
        "N s/m" => (1.0, ("lbf s/in", POUND_FORCE / INCH)),
        "N s/mm" => (1e3, ("lbf s/in", POUND_FORCE / INCH)),
        "L/min" | "l/min" => (1e-3, ("cfm", CUBIC_FOOT)),
        "L/s" | "l/s" => (60e-3, ("cfm", CUBIC_FOOT)),
        "g/s" => (60e-3, ("scfm", STANDARD_AIR * CUBIC_FOOT)),
        "kg/s" => (60.0, ("scfm", STANDARD_AIR * CUBIC_FOOT)),
        "degC" => return Some(fahrenheit(32.0)),
        "K" if !below(ABSOLUTE) => return Some(fahrenheit(32.0 - 1.8 * 273.15)),
        _ => return None,
    };
    Some(Conversion {
        unit: us,
        factor: si / of,
        offset: 0.0,
    })
}

fn fahrenheit(offset: f64) -> Conversion {
    Conversion {
        unit: "degF",
        factor: 1.8,
        offset,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// NIST SP 811 (2008), appendix B.8, inverted; AMCA 210 for standard air.
    #[test]
    fn units_have_their_published_factors() {
        for (unit, value, us, published) in [
            ("um", 25.4, "in", 1e-3),
            ("mm", 25.4, "in", 1.0),
            ("cm", 2.54, "in", 1.0),
            ("m", 0.0254, "in", 1.0),
            ("m", 3.048, "ft", 10.0),
            ("mm2", 645.16, "in2", 1.0),
            ("cm2", 6.4516, "in2", 1.0),
            ("m2", 6.4516e-4, "in2", 1.0),
            ("m2", 0.929_030_4, "ft2", 10.0),
            ("mm3", 16_387.064, "in3", 1.0),
            ("cm3", 16.387_064, "in3", 1.0),
            ("L", 0.016_387_064, "in3", 1.0),
            ("L", 28.316_846_592, "ft3", 1.0),
            ("l", 28.316_846_592, "ft3", 1.0),
            ("m3", 1.638_706_4e-5, "in3", 1.0),
            ("m3", 0.028_316_846_592, "ft3", 1.0),
            ("g", 28.349_523_125, "oz", 1.0),
            ("g", 4_535.923_7, "lb", 10.0),
            ("kg", 0.028_349_523_125, "oz", 1.0),
            ("kg", 0.453_592_37, "lb", 1.0),
            ("N", 4.448_221_615_260_5, "lbf", 1.0),
            ("kN", 4.448_221_615_260_5, "lbf", 1000.0),
            ("Pa", 6_894.757_293_168, "psi", 1.0),
            ("Pa", 6.894_757_293_168e9, "ksi", 1000.0),
            ("kPa", 6.894_757_293_168, "psi", 1.0),
            ("MPa", 0.689_475_729_316_8, "psi", 100.0),
            ("MPa", 689.475_729_316_8, "ksi", 100.0),
            ("GPa", 6.894_757_293_168, "ksi", 1000.0),
            ("bar", 6.894_757_293_168, "psi", 100.0),
            ("barg", 6.894_757_293_168, "psig", 100.0),
            ("N/mm2", 6.894_757_293_168, "psi", 1000.0),
            ("J", 1.355_817_948_331_4, "ft-lbf", 1.0),
            ("kJ", 1.355_817_948_331_4, "ft-lbf", 1000.0),
            ("N m", 1.355_817_948_331_4, "lbf ft", 1.0),
            ("m/s", 0.3048, "ft/s", 1.0),
            ("mm/s", 25.4, "in/s", 1.0),
            ("mm/min", 25.4, "in/min", 1.0),
            ("m/s2", 0.3048, "ft/s2", 1.0),
            ("kg/m3", 16.018_463_373_96, "lb/ft3", 1.0),
            ("g/cm3", 0.016_018_463_373_96, "lb/ft3", 1.0),
            ("kg/m2", 4.882_427_636_383, "lb/ft2", 1.0),
            ("N/m", 175.126_835_246_476, "lbf/in", 1.0),
            ("N/mm", 0.175_126_835_246_476, "lbf/in", 1.0),
            ("kN/mm", 0.175_126_835_246_476, "lbf/in", 1000.0),
            ("N/m3", 271_447.137_526_313, "lbf/in3", 1.0),
            ("m2/s2", 0.092_903_04, "ft2/s2", 1.0),
            ("W/(m2 K)", 5.678_263_341_113_488, "Btu/(h ft2 degF)", 1.0),
            ("J/(kg K)", 5.380_320_456, "ft-lbf/(lb degR)", 1.0),
            ("N s", 4.448_221_615_260_5, "lbf s", 1.0),
            ("N s/m", 175.126_835_246_476, "lbf s/in", 1.0),
            ("N s/mm", 0.175_126_835_246_476, "lbf s/in", 1.0),
            ("L/min", 28.316_846_592, "cfm", 1.0),
            ("l/min", 28.316_846_592, "cfm", 1.0),
            ("L/s", 0.471_947_443_2, "cfm", 1.0),
            ("l/s", 0.471_947_443_2, "cfm", 1.0),
            ("g/s", 0.566_990_462_5, "scfm", 1.0),
            ("kg/s", 0.566_990_462_5e-3, "scfm", 1.0),
            ("degC", 100.0, "degF", 212.0),
            ("degC", -40.0, "degF", -40.0),
            ("K", 273.15, "degF", 32.0),
        ] {
            let found = to_us(unit, f64::abs(value)).unwrap();
            assert_eq!(found.unit, us, "{unit}");
            let own = found.of(value);
            assert!(
                (own - published).abs() < 1e-11 * published.abs().max(1.0),
                "{value} {unit} is {own} {us}, expected {published}"
            );
        }
    }

    #[test]
    fn levels_times_and_differences_of_temperature_stay() {
        for (unit, value) in [
            ("dB", 100.0),
            ("Hz", 500.0),
            ("ms", 4.0),
            ("s", 1.0),
            ("K", 2.0),
            ("", 1.0),
        ] {
            assert_eq!(to_us(unit, value), None, "{unit}");
        }
    }
}
