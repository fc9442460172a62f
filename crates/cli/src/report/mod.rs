//! What was found, in every form it leaves the program in.
//!
//! `document` gathers it once; the table, the JSON and the HTML are written
//! from there and so cannot disagree. `fields` spreads it over vertices, for
//! the meshes in colour (`vtp`) and the pictures (`views`).

mod division;
mod document;
mod field;
mod fields;
mod html;
mod medial;
mod motion;
mod motion_chart;
mod resolution;
mod resolved;
mod table;
mod text;
mod views;

pub(crate) use self::division::divisions;
pub(crate) use self::document::{BodyRecord, BodySource, Document, PairRecord};
pub(crate) use self::field::{BuiltRecord, FieldRecord, field_table};
pub(crate) use self::fields::{ContactField, displacement_vtp};
pub(crate) use self::html::html;
pub(crate) use self::medial::{MedialRecord, medial_table};
pub(crate) use self::motion::{MotionDocument, StepRecord, motion_table};
pub(crate) use self::motion_chart::motion_chart;
pub(crate) use self::resolution::resolution_table;
pub(crate) use self::resolved::{ResolvedDocument, ResolvedFrame, resolved_table};
pub(crate) use self::table::table;
pub(crate) use self::views::Gallery;
