//! Continuous collision queries beside other ways to answer them.

pub mod measure;
pub mod methods;
pub mod queries;
