//! What benchmarks share: bodies from files, a clock, interleaved timing, and ratios with what is allowed of
//! them; and the methods that some compare; and the pictures drawn of them.

pub mod bodies;
pub mod ccd;
pub mod chart;
pub mod clock;
pub mod ratio;
pub mod response;
pub mod soak;
