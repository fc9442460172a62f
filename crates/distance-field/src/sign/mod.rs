//! Inside and outside: which nodes a surface encloses.

mod chain;
mod crossings;
mod winding;

pub(crate) use self::winding::{Winding, enclosed_volume, winding};
