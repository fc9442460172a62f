//! Reports: the content of every output.
//!
//! `document` gathers the results of a check once; text, JSON and HTML are written from
//! it and so agree. `contact_field` spreads them over vertices and `overlap_files` over clipped
//! faces, for meshes in color; `gallery` draws the latter.

mod attachment_record;
mod body_color;
mod check_page;
mod check_tables;
mod contact_field;
mod contact_triangles;
mod division;
mod document;
mod field;
mod frame_pair;
mod frame_times;
mod gallery;
mod inverted_part;
mod joint_contact;
mod joint_views;
mod long_table;
mod medial;
mod motion;
mod motion_chart;
mod motion_page;
mod overlap_files;
mod page;
mod pair_record;
mod range;
mod range_map;
mod resolution;
mod resolution_document;
mod resolved;
mod self_crossing;
mod series;
mod table;
mod text;
mod tie_record;
mod until_contact;
mod viewer;
mod volume_record;

pub(crate) use self::check_page::{Pictures, check_page};
pub(crate) use self::check_tables::check_text;
pub(crate) use self::contact_field::{ContactField, depth_vtp, displacement_vtp, displacement_vtu};
pub(crate) use self::division::divisions;
pub(crate) use self::document::{BodyRecord, CheckDocument};
pub(crate) use self::field::{BuiltRecord, FieldRecord};
pub(crate) use self::gallery::Gallery;
pub(crate) use self::inverted_part::InvertedPart;
pub(crate) use self::joint_contact::{PairContact, PairJointContact, stage_contact_files};
pub(crate) use self::long_table::{LongTable, TableFrame};
pub(crate) use self::medial::MedialRecord;
pub(crate) use self::motion::{FrameRecord, MotionDocument, StepRecord, rest_text};
pub(crate) use self::motion_chart::motion_chart;
pub(crate) use self::motion_page::motion_page;
pub(crate) use self::overlap_files::{FileFolder, OverlapShape, stage_overlap_files};
pub(crate) use self::pair_record::PairRecord;
pub(crate) use self::range::{FirstContactRecord, RangeDocument};
pub(crate) use self::range_map::{MapCell, RangeMap};
pub(crate) use self::resolution::{pushed_out, resolution_text};
pub(crate) use self::resolution_document::{ElementsRecord, ResolutionDocument};
pub(crate) use self::resolved::{FrameInfo, ResolvedDocument, ResolvedFrame};
pub(crate) use self::self_crossing::self_crossings;
pub(crate) use self::series::Series;
pub(crate) use self::text::{counted, fixed};
pub(crate) use self::until_contact::{MeetingTimeRecord, UntilContactDocument};
pub(crate) use self::viewer::{Recording, ShownSurfaces};
pub(crate) use self::volume_record::{QualityRecord, VolumeRecord};
