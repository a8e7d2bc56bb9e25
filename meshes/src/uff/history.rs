//! Writing time histories: dataset 58, "function at nodal DOF", in text.

use std::fmt::Write as _;

use super::write::fortran;

/// What a time history is of: its specific data type, name and unit.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Ordinate {
    /// An acceleration, data type 12 \[m/s²\].
    Acceleration,
    /// A pressure, data type 15 \[Pa\].
    Pressure,
}

impl Ordinate {
    fn axis(self) -> (u32, &'static str, &'static str) {
        match self {
            Self::Acceleration => (12, "acceleration", "m/s2"),
            Self::Pressure => (15, "pressure", "Pa"),
        }
    }
}

/// Samples of a quantity at even intervals, to be written.
#[derive(Debug, Clone, Copy)]
pub struct History<'a> {
    /// What was recorded: the first line of description, of which 80 characters are kept.
    pub title: &'a str,
    /// Where it comes from: the second line.
    pub origin: &'a str,
    /// Name of the sensor, of which ten characters are kept.
    pub sensor: &'a str,
    /// Node number of the sensor.
    pub node: usize,
    /// The quantity.
    pub ordinate: Ordinate,
    /// Time between samples \[s\]; the format keeps six digits of it.
    pub interval: f64,
    /// The samples, in the unit of the quantity.
    pub values: &'a [f64],
}

impl History<'_> {
    /// Appends the dataset to a file.
    ///
    /// Function type 1 is a time response, data type 4 real double precision, abscissa spacing 1 even; specific data type 17
    /// is time. Reference direction 0 is a scalar, which a sensor's axis is.
    pub fn write(&self, text: &mut Vec<u8>) {
        text.extend_from_slice(self.records().as_bytes());
        for line in self.values.chunks(4) {
            line.iter().for_each(|value| fortran(text, *value, [20, 12]));
            text.push(b'\n');
        }
        text.extend_from_slice(b"    -1\n");
    }

    /// The records of the dataset before its values.
    fn records(&self) -> String {
        // Writing to a string cannot fail, so the results of `writeln` are ignored.
        let mut text = format!("{:>6}\n{:>6}\n", -1, 58);
        let (kind, quantity, unit) = self.ordinate.axis();
        for line in [
            self.title,
            self.origin,
            "NONE",
            &format!("{quantity} of one shot"),
            "NONE",
        ] {
            let _ = writeln!(text, "{line:.80}");
        }
        let _ = writeln!(
            text,
            "{:>5}{:>10}{:>5}{:>10} {:<10.10}{:>10}{:>4} {:<10.10}{:>10}{:>4}",
            1, 0, 0, 0, self.sensor, self.node, 0, "NONE", 0, 0
        );
        let mut abscissa = Vec::new();
        for value in [0.0, self.interval, 0.0] {
            fortran(&mut abscissa, value, [13, 5]);
        }
        let abscissa = String::from_utf8_lossy(&abscissa);
        let _ = writeln!(text, "{:>10}{:>10}{:>10}{abscissa}", 4, self.values.len(), 1);
        for (kind, label, unit) in [
            (17, "time", "s"),
            (kind, quantity, unit),
            (0, "NONE", "NONE"),
            (0, "NONE", "NONE"),
        ] {
            let _ = writeln!(text, "{kind:>10}{:>5}{:>5}{:>5} {label:<20} {unit:<20}", 0, 0, 0);
        }
        text
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_history_becomes_one_dataset_of_four_values_a_line() {
        let values = [1.0, -2.0, 3.0, 4.0, 5.0];
        let mut text = Vec::new();
        History {
            title: "block_top (workpiece)",
            origin: "nailnoise",
            sensor: "block_top",
            node: 1,
            ordinate: Ordinate::Acceleration,
            interval: 4e-6,
            values: &values,
        }
        .write(&mut text);
        let text = String::from_utf8(text).unwrap_or_default();
        let lines: Vec<&str> = text.lines().collect();
        assert_eq!(
            (lines[0], lines[1], lines[lines.len() - 1]),
            ("    -1", "    58", "    -1")
        );
        assert_eq!(lines[2], "block_top (workpiece)");
        assert_eq!(lines.len(), 2 + 5 + 2 + 4 + 2 + 1);
        assert_eq!(lines[8].split_whitespace().nth(1), Some("5"));
        let read = lines[13..15].iter().flat_map(|line| line.split_whitespace());
        let read: Vec<f64> = read.map(|word| word.parse().unwrap_or(f64::NAN)).collect();
        assert_eq!(read, values);
    }
}
