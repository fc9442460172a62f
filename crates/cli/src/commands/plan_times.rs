//! Times of frames.

use std::fmt;
use std::time::Duration;

/// Times of the frames of a plan, in their order.
#[derive(Debug, Default)]
pub(super) struct FrameTimes(Vec<Duration>);

impl FrameTimes {
    pub(super) fn add(&mut self, time: Duration) {
        self.0.push(time);
    }

    /// Returns minimum, median and maximum in milliseconds; `None` where nothing was measured. The
    /// first of several frames, which reserves memory, is left out.
    pub(super) fn milliseconds(&self) -> Option<[f64; 3]> {
        let counted = if self.0.len() > 1 { &self.0[1..] } else { &self.0[..] };
        let mut times = Vec::new();
        for time in counted {
            times.push(1e3 * time.as_secs_f64());
        }
        times.sort_by(f64::total_cmp);
        // The median is not moved by the few frames in which the system did something else.
        let median = *times.get(times.len().saturating_sub(1) / 2)?;
        Some([*times.first()?, median, *times.last()?])
    }
}

impl fmt::Display for FrameTimes {
    /// Writes median, minimum and maximum.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.milliseconds() {
            Some([min, median, max]) => write!(f, "{median:.1} ms ({min:.1} to {max:.1})"),
            None => write!(f, "not measured"),
        }
    }
}
