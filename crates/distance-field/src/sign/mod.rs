//! Inside and outside: which nodes and points a surface encloses.

mod chain;
mod crossings;
mod enclosures;
mod winding;

pub(crate) use self::enclosures::{InsideRule, enclosures};
pub(crate) use self::winding::{Enclosed, Winding, enclosed, winding};
