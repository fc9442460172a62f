//! Vectors of the command line.

use std::str::FromStr;

use glam::DVec3;

/// Three numbers, separated by commas.
#[derive(Clone, Copy, Debug)]
pub(super) struct Vector(pub(super) DVec3);

impl FromStr for Vector {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let mut numbers = Vec::new();
        for part in text.split(',') {
            match part.trim().parse::<f64>() {
                Ok(number) if number.is_finite() => numbers.push(number),
                _ => return Err(format!("'{part}' is no finite number")),
            }
        }
        let numbers: [f64; 3] =
            numbers.try_into().map_err(|_| "expected three numbers, separated by commas")?;
        Ok(Self(numbers.into()))
    }
}
