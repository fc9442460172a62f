//! Numbers as text.

use glam::DVec3;

use crate::scene::Unit;

/// Maximum number of decimals; smaller numbers have an exponent.
pub(super) const MAX_DECIMALS: usize = 12;

/// Writes a length to about a micrometer, whatever the unit.
pub(super) fn length(value: f64, unit: Unit) -> String {
    fixed(value, unit.decimals())
}

/// Writes a point to about a micrometer, whatever the unit.
pub(super) fn place(point: DVec3, unit: Unit) -> String {
    let decimals = unit.decimals();
    let digits = 10.0_f64.powi(decimals.try_into().unwrap_or(0));

    // A sum with 0 has no negative zeros.
    let rounded = (point * digits).round() / digits + DVec3::ZERO;
    rounded.to_array().map(|x| format!("{x:.decimals$}")).join(" ")
}

/// Writes the depth of an overlap, or "edges" where faces cross and no vertex is inside.
pub(super) fn depth(value: f64, unit: Unit) -> String {
    if value > 0.0 { length(value, unit) } else { "edges".to_owned() }
}

/// Writes a number with some decimals. One that is not zero, but would be written as zero,
/// has two significant digits instead.
pub(crate) fn fixed(value: f64, decimals: usize) -> String {
    // Only a digit other than 0 tells the number from zero.
    let text = format!("{value:.decimals$}");
    let is_zero = !text.contains(|digit| matches!(digit, '1'..='9'));
    if !is_zero || value == 0.0 || !value.is_finite() {
        return text;
    }

    // The first number of decimals that shows two digits.
    for decimals in decimals + 1..=MAX_DECIMALS {
        if value.abs() * 10.0_f64.powi(decimals.try_into().unwrap_or(0)) >= 10.0 {
            return format!("{value:.decimals$}");
        }
    }
    format!("{value:.1e}")
}

/// Writes a bound on how far a motion is free with some decimals, rounded toward zero. One that is not
/// zero has more decimals where it needs them.
pub(super) fn bound(value: f64, decimals: usize) -> String {
    // Digits beyond those that a number has are cut, not rounded.
    let digits = format!("{value:.40}");
    let Some(point) = digits.find('.') else { return digits };
    let is_zero =
        |decimals: usize| !digits[..=point + decimals].contains(|c| matches!(c, '1'..='9'));
    let enough = (decimals..=MAX_DECIMALS).find(|decimals| !is_zero(*decimals));
    digits[..=point + enough.unwrap_or(decimals)].to_owned()
}

/// Writes a number with four significant digits, and no exponent unless it is minute.
pub(super) fn measure(value: f64) -> String {
    // Decimals up to which the number has four digits.
    let mut decimals = 0;
    let mut scaled = value.abs();
    while scaled < 1000.0 && decimals < MAX_DECIMALS {
        scaled *= 10.0;
        decimals += 1;
    }

    if scaled >= 1000.0 {
        format!("{value:.decimals$}")
    } else if scaled > 0.0 {
        format!("{value:.3e}")
    } else {
        format!("{value:.0}")
    }
}

/// Writes a number with up to four significant digits, without zeros at its end.
pub(super) fn short(value: f64) -> String {
    let text = measure(value);
    if text.contains('e') || !text.contains('.') {
        return text;
    }
    text.trim_end_matches('0').trim_end_matches('.').to_owned()
}

/// Writes the number of a tick on an axis, with an exponent where it would be long.
pub(super) fn tick(value: f64) -> String {
    if value == 0.0 || (1e-3..1e6).contains(&value.abs()) {
        return short(value);
    }
    let text = format!("{value:.2e}");
    let (digits, exponent) = text.split_once('e').unwrap_or((&text, "0"));
    format!("{}e{exponent}", digits.trim_end_matches('0').trim_end_matches('.'))
}

/// Writes a count with its noun: `1 pair`, `2 pairs`.
pub(crate) fn counted(count: usize, noun: &str) -> String {
    let plural = if count == 1 { "" } else { "s" };
    format!("{} {noun}{plural}", grouped(count))
}

/// Writes a count with separators of thousands.
pub(super) fn grouped(count: usize) -> String {
    // A separator stands before every third digit from the end.
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

/// Writes the pairs that overlap from the start; nothing where there are none.
pub(super) fn overlapping_text(pairs: &[[String; 2]]) -> String {
    if pairs.is_empty() {
        return String::new();
    }
    let pairs: Vec<String> = pairs.iter().map(|pair| pair.join(" × ")).collect();
    format!("Overlapping from the start, without a first contact: {}\n", pairs.join(", "))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn no_number_but_zero_is_written_as_zero() {
        let cases = [
            (0.0, "0.000"),
            (-0.0, "-0.000"),
            (1.2345, "1.234"),
            (0.0005, "0.001"),
            (0.000_49, "0.00049"),
            (0.000_4, "0.00040"),
            (-0.000_012_34, "-0.000012"),
            (1.0e-11, "0.000000000010"),
            (4.0e-13, "4.0e-13"),
            (5e-324, "4.9e-324"),
        ];
        for (value, expected) in cases {
            assert_eq!(fixed(value, 3), expected, "{value:e}");
        }
        assert_eq!(length(0.000_4, Unit::Millimeter), "0.00040");
        assert_eq!(
            [depth(0.000_4, Unit::Millimeter), depth(0.0, Unit::Meter)],
            ["0.00040", "edges"]
        );
    }

    #[test]
    fn bounds_are_rounded_toward_zero() {
        let cases = [
            (0.123_46, "0.1234"),
            (0.123_449, "0.1234"),
            (-0.123_46, "-0.1234"),
            (1.0, "1.0000"),
            (0.999_99, "0.9999"),
            (0.000_059, "0.00005"),
            (1.999_99e-9, "0.000000001"),
            (4.96e-15, "0.0000"),
            (0.0, "0.0000"),
        ];
        for (value, expected) in cases {
            assert_eq!(bound(value, 4), expected, "{value:e}");
        }
    }

    #[test]
    fn measures_have_four_significant_digits() {
        let cases = [
            (0.0, "0"),
            (0.000_012_345, "0.00001234"),
            (1.234_56, "1.235"),
            (-12.345_6, "-12.35"),
            (12_345.6, "12346"),
            (2.5e-9, "0.000000002500"),
            (2.5e-10, "2.500e-10"),
            (f64::NAN, "NaN"),
            (f64::INFINITY, "inf"),
        ];
        for (value, expected) in cases {
            assert_eq!(measure(value), expected);
        }
        let shortened =
            [(1.0, "1"), (11.380_711_874, "11.38"), (0.4, "0.4"), (1200.0, "1200"), (0.0, "0")];
        for (value, expected) in shortened {
            assert_eq!(short(value), expected);
        }
    }

    #[test]
    fn ticks_are_short() {
        let cases = [
            (0.0, "0"),
            (0.1 + 0.2, "0.3"),
            (-0.05, "-0.05"),
            (0.0025, "0.0025"),
            (5e-4, "5e-4"),
            (1.5e-7, "1.5e-7"),
            (350_000.0, "350000"),
            (2e20, "2e20"),
        ];
        for (value, expected) in cases {
            assert_eq!(tick(value), expected);
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
