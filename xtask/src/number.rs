//! Numbers as tests print them: `0.31 s`, `<= 1e-3`, `>=10`, `2.5x`.

/// Bound on a number.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Bound {
    AtMost(f64),
    AtLeast(f64),
}

impl Bound {
    /// Reads `3`, `<= 3` or `>= 3`, with any text behind it.
    pub(crate) fn read(text: &str) -> Option<Self> {
        let text = text.trim();
        match text.strip_prefix(">=").or_else(|| text.strip_prefix('≥')) {
            Some(rest) => leading(rest).map(Self::AtLeast),
            None => leading(text.trim_start_matches(['<', '=', '≤'])).map(Self::AtMost),
        }
    }

    /// Returns true if a value keeps the bound; NaN does not.
    pub(crate) fn holds(self, value: f64) -> bool {
        match self {
            Self::AtMost(bound) => value <= bound,
            Self::AtLeast(bound) => value >= bound,
        }
    }
}

/// Reads the number that a text begins with; commas between digits are skipped.
pub(crate) fn leading(text: &str) -> Option<f64> {
    let text = text.trim_start().replace(',', "");

    // The longest beginning that is a number.
    let longest = text.find(|c: char| !(c.is_ascii_digit() || "+-.eE".contains(c)));
    let candidate = &text[..longest.unwrap_or(text.len())];
    (1..=candidate.len()).rev().find_map(|end| candidate[..end].parse().ok())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_of_tests_are_read() {
        let cases = [
            ("0.31 s", Some(0.31)),
            (" 1e-3", Some(1e-3)),
            ("2.5x", Some(2.5)),
            ("12,345 pairs", Some(12345.0)),
            ("3 e", Some(3.0)),
            ("7ea", Some(7.0)),
            ("none", None),
            ("", None),
        ];
        for (text, number) in cases {
            assert_eq!(leading(text), number, "{text}");
        }
        assert_eq!(Bound::read("<= 0.5 mm"), Some(Bound::AtMost(0.5)));
        assert_eq!(Bound::read("0.5"), Some(Bound::AtMost(0.5)));
        assert_eq!(Bound::read(">=10x"), Some(Bound::AtLeast(10.0)));
        assert_eq!(Bound::read("-"), None);
    }

    #[test]
    fn bounds_hold_on_their_side() {
        assert!(Bound::AtMost(1.0).holds(1.0) && !Bound::AtMost(1.0).holds(1.1));
        assert!(Bound::AtLeast(4.0).holds(4.0) && !Bound::AtLeast(4.0).holds(3.9));
        assert!(!Bound::AtMost(1.0).holds(f64::NAN) && !Bound::AtLeast(1.0).holds(f64::NAN));
    }
}
