//! What to measure next, in a few lines at the end of another command's text.

use crate::calibration::NextRow;

/// Measurements that are named.
const NAMED: usize = 3;

/// Smallest fall of the width for an hour of work that is named \[dB/h\].
const LEAST: f64 = 0.1;

/// A line for each of the most valuable measurements; empty if there is none.
pub(super) fn next_lines(rows: &[NextRow]) -> String {
    let named: Vec<&NextRow> = rows
        .iter()
        .filter(|own| own.narrower_an_hour >= LEAST)
        .take(NAMED)
        .collect();
    let Some(first) = named.first() else {
        return String::new();
    };
    let line = |own: &&NextRow| {
        let least = if own.is_bound { "at least " } else { "" };
        format!(
            "    {}, {:.0} min: {:.1} dB and {:.2}; for an hour of work {least}{:.1} dB narrower and P(first) +{:.2}\n",
            own.measurement,
            own.minutes,
            own.width[1],
            own.first[1],
            own.narrower_an_hour,
            // On average no measurement makes the order less sure; a negative value is an error of sampling.
            own.surer_an_hour.max(0.0)
        )
    };
    let lines: String = named.iter().map(line).collect();
    format!(
        "  measure next (the total is known to {:.1} dB, its 90 % interval; P(first) of the loudest source is {:.2})\n\
         {lines}    other measurements: `nailnoise calibrate DESIGN --next`\n",
        first.width[0], first.first[0]
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    fn row(name: &str, narrower_an_hour: f64) -> NextRow {
        NextRow {
            measurement: name.to_owned(),
            condition: String::new(),
            error: 1.0,
            unit: "dB".to_owned(),
            minutes: 45.0,
            width: [10.0, 4.0],
            first: [0.8, 0.9],
            narrower_an_hour,
            surer_an_hour: 0.1,
            is_bound: false,
        }
    }

    #[test]
    fn only_the_most_valuable_measurements_are_named() {
        let rows = [row("a", 8.0), row("b", 2.0), row("c", 1.0), row("d", 0.9)];
        let text = next_lines(&rows);
        assert!(
            text.contains("known to 10.0 dB") && text.contains("a, 45 min: 4.0 dB and 0.90"),
            "{text}"
        );
        assert!(text.contains("c, 45 min") && !text.contains("d, 45 min"), "{text}");
        assert_eq!(next_lines(&[row("a", 0.01)]), "");
        assert_eq!(next_lines(&[]), "");
    }
}
