//! Numbers as text.

use crate::scene::Unit;

/// Writes a length to about a micrometer, whatever the unit.
pub(super) fn length(value: f64, unit: Unit) -> String {
    format!("{value:.*}", unit.decimals())
}

/// Writes a number with four significant digits and no exponent.
pub(super) fn measure(value: f64) -> String {
    // Decimals until four digits stand before the point; zero has none that would.
    let mut decimals = 0;
    let mut scaled = value.abs();
    while scaled < 1000.0 && decimals < 12 {
        scaled *= 10.0;
        decimals += 1;
    }

    format!("{value:.*}", if scaled < 1000.0 { 0 } else { decimals })
}

/// Writes a count with its noun: `1 pair`, `2 pairs`.
pub(crate) fn counted(count: usize, noun: &str) -> String {
    let plural = if count == 1 { "" } else { "s" };
    format!("{} {noun}{plural}", grouped(count))
}

/// Writes a count with separators of thousands.
pub(super) fn grouped(count: usize) -> String {
    let digits = count.to_string();
    let mut text = String::new();

    // A separator stands where a multiple of three digits is left.
    for (place, digit) in digits.chars().enumerate() {
        if place > 0 && (digits.len() - place).is_multiple_of(3) {
            text.push(',');
        }
        text.push(digit);
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn measures_have_four_significant_digits() {
        let cases = [
            (0.0, "0"),
            (0.000_012_345, "0.00001234"),
            (1.234_56, "1.235"),
            (-12.345_6, "-12.35"),
            (12_345.6, "12346"),
        ];
        for (value, expected) in cases {
            assert_eq!(measure(value), expected);
        }
    }

    #[test]
    fn thousands_are_separated() {
        let cases = [(0, "0"), (999, "999"), (1000, "1,000"), (579_046, "579,046")];
        for (count, expected) in cases {
            assert_eq!(grouped(count), expected);
        }
        assert_eq!(counted(1, "pair"), "1 pair");
        assert_eq!(counted(2, "pair"), "2 pairs");
    }
}
