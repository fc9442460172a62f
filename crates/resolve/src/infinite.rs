//! Serialization of numbers that may be infinite, which formats such as JSON do not have: as none.

use serde::{Deserialize, Deserializer, Serialize, Serializer};

pub(crate) fn serialize<S: Serializer>(value: &f64, serializer: S) -> Result<S::Ok, S::Error> {
    Some(*value).filter(|value| value.is_finite()).serialize(serializer)
}

pub(crate) fn deserialize<'de, D: Deserializer<'de>>(deserializer: D) -> Result<f64, D::Error> {
    Ok(Option::deserialize(deserializer)?.unwrap_or(f64::INFINITY))
}

#[cfg(test)]
mod tests {
    use crate::GapRound;

    /// Before the first round of a scene in which nothing is near.
    #[test]
    fn what_is_infinite_is_read_again() {
        for min_distance in [f64::INFINITY, 0.25] {
            let round = GapRound { min_distance, ..GapRound::default() };
            let text = serde_json::to_string(&round).expect("JSON");
            let read: GapRound = serde_json::from_str(&text).expect("the same");
            assert_eq!(read, round, "{text}");
        }
    }
}
