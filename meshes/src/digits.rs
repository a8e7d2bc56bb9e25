//! Formats numbers as text in files.
//!
//! This code is separate, because writing `histories.csv` (17 MB) with the standard library takes 1.8 times as long.
//!
//! The digits are those of the standard library. They are computed as value x 10^k in double precision where the error
//! cannot change the rounding; close to a rounding boundary the standard library is used.

use std::io::Write;
use std::sync::LazyLock;

/// Largest exponent of ten in the table: products with numbers of [`USUAL`] size remain normal numbers.
const EXPONENT: i32 = 300;

/// Range of magnitudes for which the table contains the power of ten.
const USUAL: std::ops::Range<f64> = 1e-280..1e280;

/// Bound on the relative error of a product with a power of ten: the rounding of both, with a margin.
const ERROR: f64 = 2.0 * f64::EPSILON;

/// Largest number of digits.
const MOST: usize = 20;

static POWERS: LazyLock<Vec<f64>> = LazyLock::new(|| {
    let power = |exponent: i32| format!("1e{exponent}").parse().unwrap_or(f64::NAN);
    (-EXPONENT..=EXPONENT).map(power).collect()
});

/// 10^exponent; none outside the table.
fn power(exponent: i32) -> Option<f64> {
    POWERS.get(usize::try_from(exponent + EXPONENT).ok()?).copied()
}

/// Appends a number formatted as `{:.digits$e}`.
pub fn exponential(text: &mut Vec<u8>, value: f64, digits: usize) {
    if value == 0.0 && value.is_sign_positive() {
        text.extend_from_slice(b"0.");
        text.resize(text.len() + digits, b'0');
        text.extend_from_slice(b"e0");
    } else if let Some((rounded, exponent)) = significant(value.abs(), digits) {
        pointed(text, value < 0.0, rounded, digits);
        text.push(b'e');
        if exponent < 0 {
            text.push(b'-');
        }
        whole(text, exponent.unsigned_abs().into(), 1);
    } else {
        // Writing to memory cannot fail.
        let _ = write!(text, "{value:.digits$e}");
    }
}

/// Appends a number formatted as `{:.digits$}`.
pub fn fixed(text: &mut Vec<u8>, value: f64, digits: usize) {
    let scaled = power(digits as i32).and_then(|power| nearest(value.abs() * power));
    match scaled.filter(|_| digits > 0) {
        Some(rounded) => pointed(text, value.is_sign_negative(), rounded, digits),
        None => {
            let _ = write!(text, "{value:.digits$}");
        }
    }
}

/// The leading `digits` + 1 digits of a positive number as an integer, and the exponent of the first digit; none if the
/// rounding is uncertain.
fn significant(size: f64, digits: usize) -> Option<(u64, i32)> {
    if !USUAL.contains(&size) || digits == 0 {
        return None;
    }
    let (least, digits) = (power(digits as i32)?, digits as i32);
    // log10(2) times the binary exponent is too low by less than one.
    let binary = ((size.to_bits() >> 52) as i32) - 1023;
    let mut exponent = (f64::from(binary) * std::f64::consts::LOG10_2).floor() as i32;
    let mut scaled = size * power(digits - exponent)?;
    if scaled >= 10.0 * least {
        exponent += 1;
        scaled = size * power(digits - exponent)?;
    }
    let rounded = nearest(scaled)?;
    let most = 10 * least as u64;
    // A number rounded up to the next power of ten has one digit too many.
    Some(if rounded == most {
        (most / 10, exponent + 1)
    } else {
        (rounded, exponent)
    })
}

/// The integer nearest to a product; none if the error of the product makes it uncertain.
fn nearest(product: f64) -> Option<u64> {
    let rest = product.fract();
    let certain = product < 1e15 && (rest - 0.5).abs() > ERROR * product;
    certain.then(|| product as u64 + u64::from(rest > 0.5))
}

/// Appends an integer with a decimal point before its last digits.
fn pointed(text: &mut Vec<u8>, negative: bool, value: u64, digits: usize) {
    if negative {
        text.push(b'-');
    }
    whole(text, value, digits + 1);
    let point = text.len() - digits;
    text.push(b'.');
    let end = text.len() - 1;
    text.copy_within(point..end, point + 1);
    text[point] = b'.';
}

/// Appends an integer with at least this many digits.
fn whole(text: &mut Vec<u8>, mut value: u64, least: usize) {
    let mut reversed = [b'0'; MOST];
    let mut count = 0;
    while value > 0 {
        reversed[count] = b'0' + (value % 10) as u8;
        value /= 10;
        count += 1;
    }
    text.extend(reversed[..count.max(least)].iter().rev());
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    /// Compares both with the standard library.
    fn agree(value: f64, digits: usize) {
        let (mut own, mut plain) = (Vec::new(), Vec::new());
        exponential(&mut own, value, digits);
        fixed(&mut plain, value, digits);
        assert_eq!(String::from_utf8_lossy(&own), format!("{value:.digits$e}"));
        assert_eq!(String::from_utf8_lossy(&plain), format!("{value:.digits$}"));
    }

    #[test]
    fn numbers_at_the_edges_of_their_digits_are_those_of_the_standard_library() {
        let mut values = vec![
            0.0,
            f64::NAN,
            f64::INFINITY,
            f64::MIN_POSITIVE,
            f64::MAX,
            5e-324,
            2f64.powi(53),
        ];
        for exponent in -30..30 {
            let ten = 10f64.powi(exponent);
            // Ties: halves of the last digit, exact or nearly so.
            for digits in [
                ten,
                9.5 * ten,
                9.9999995 * ten,
                1.0000005 * ten,
                1.0000015 * ten,
                0.5 * ten,
                2.5 * ten,
            ] {
                values.extend([digits, digits.next_up(), digits.next_down()]);
            }
        }
        for value in values {
            for digits in [1, 3, 6, 7, 9, 12] {
                agree(value, digits);
                agree(-value, digits);
            }
        }
    }

    proptest! {
        #[test]
        fn all_numbers_are_those_of_the_standard_library(value: f64, bits: u64, digits in 1_usize..13) {
            agree(value, digits);
            agree(f64::from_bits(bits), digits);
        }

        #[test]
        fn decimal_numbers_are_those_of_the_standard_library(
            digits in 0_u64..100_000_000_000, exponent in -12..12, kept in 1_usize..13
        ) {
            agree(format!("{digits}e{exponent}").parse().unwrap_or(f64::NAN), kept);
        }
    }
}
