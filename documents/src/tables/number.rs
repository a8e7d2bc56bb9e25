//! Parses numbers in tables.

/// A finite number with a decimal point or comma; the exponent may be marked by `D`.
pub fn number(field: &str) -> Option<f64> {
    let parsed = field.parse::<f64>().or_else(|_| {
        let mut text = field.replace('\u{2212}', "-").replace(['D', 'd'], "E");
        if text.matches(',').count() == 1 && !text.contains('.') {
            text = text.replace(',', ".");
        }
        text.parse()
    });
    parsed.ok().filter(|number| number.is_finite())
}
