//! Texts of the times of frames, which tell frames apart.

use super::table::dash;
use super::text::{MAX_DECIMALS, fixed};

/// Decimals of times in seconds, where these tell frames apart.
const USUAL_DECIMALS: usize = 3;

/// Way to write the times of all frames of a motion.
#[derive(Clone, Copy, Debug)]
pub(crate) struct FrameTimes {
    decimals: usize,
}

impl FrameTimes {
    /// Takes milliseconds, or, of shorter steps, two digits of the shortest one.
    pub(crate) fn new(times: impl IntoIterator<Item = Option<f64>>) -> Self {
        let (mut shortest, mut before) = (f64::INFINITY, None);
        for time in times.into_iter().flatten() {
            if let Some(before) = before.replace(time) {
                shortest = shortest.min(time - before);
            }
        }

        // Differences of decimals are rounded: a step of 0.001 is a hair less.
        let power = |decimals: usize| 10.0_f64.powi(decimals.try_into().unwrap_or(0));
        if shortest * power(USUAL_DECIMALS) >= 0.99 {
            return Self { decimals: USUAL_DECIMALS };
        }
        let mut more = USUAL_DECIMALS..MAX_DECIMALS;
        let decimals = more.find(|&decimals| shortest * power(decimals) >= 9.9);
        Self { decimals: decimals.unwrap_or(MAX_DECIMALS) }
    }

    /// Writes the time of a frame, a dash where it has none.
    pub(crate) fn text(self, time: Option<f64>) -> String {
        time.map_or_else(dash, |time| fixed(time, self.decimals))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn short_steps_have_more_decimals() {
        let texts = |times: &[f64]| -> Vec<String> {
            let times = times.iter().map(|&time| Some(time));
            let written = FrameTimes::new(times.clone());
            times.map(|time| written.text(time)).collect()
        };
        assert_eq!(texts(&[0.0, 1.0 / 30.0, 2.0 / 30.0]), ["0.000", "0.033", "0.067"]);
        assert_eq!(texts(&[0.002, 0.003, 0.004]), ["0.002", "0.003", "0.004"]);
        assert_eq!(texts(&[0.0012, 0.001_24, 0.0013]), ["0.001200", "0.001240", "0.001300"]);
        assert_eq!(texts(&[7.0, 7.000_000_5]), ["7.00000000", "7.00000050"]);
        assert_eq!(texts(&[0.0, 1e-9]), ["0.0000000000", "0.0000000010"]);
        assert_eq!(texts(&[5.0]), ["5.000"]);
        assert_eq!(FrameTimes::new([None, None]).text(None), "-");
    }
}
