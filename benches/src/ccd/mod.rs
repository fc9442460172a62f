//! Continuous collision queries beside other methods to answer them.

pub mod answers;
pub mod methods;
pub mod plain_roots;
pub mod queries;
