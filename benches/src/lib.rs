//! What benchmarks share: interleaved timing, and ratios with what is allowed of them; and the
//! methods that some compare.

pub mod ccd;
pub mod ratio;
pub mod response;
