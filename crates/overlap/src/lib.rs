//! Exact overlap of two surfaces: volume, areas, curve, centroid, and certified depth.
//!
//! Two surfaces that cross share a solid. Its volume, its centroid, the areas of its border and the
//! length of the curve in which the surfaces cross are sums over the stretches of that curve, one or
//! two terms per stretch and one per face inside: no boolean mesh is built, nothing is triangulated.
//! Every decision is one exact sign under one infinitesimal move of the first body, so that bodies
//! that touch, coincide or share faces need no special case. [`Overlap::regions`] has the same
//! measures for each separate contact region.
//!
//! The depth of one surface in the other is the greatest distance of any point of it, not of a vertex
//! only; [`OverlapDetector::depths`] brackets it as closely as asked, by branch and bound. It says
//! how deep a surface is, not how to leave the body: in the middle of a thin body all ways are short.
//!
//! [`OverlapDetector::joint_contact`] reports what the tools of joint mechanics do: contact area,
//! center, gaps, and the pressure of an elastic layer, per region and on the mesh.
//!
//! # Accuracy
//!
//! On 64 overlapping pairs of bones, muscles and cartilage against exact constructions: areas and
//! length within 1e-11 relative, volumes within 2e-11, loops equal (the crate's tests print the
//! figures when the data is there). Planted scenes come within 1e-14 of the scene's size.
//!
//! # Surfaces that bound nothing
//!
//! | surface | answer |
//! |---|---|
//! | closed and oriented | all measures |
//! | A open | area of A inside B, curve with open arcs; no volume |
//! | an edge with one face, or with two that run the same way | named in [`Overlap::no_inside`] |
//! | a part whose faces look outward in another part, or inward in the open | named in [`Overlap::covers_twice`]; measures count places as often as they are covered |
//! | parts that cross each other or themselves | the same, where a vertex of the other body is in what they cover twice; else measures count it twice without a note |
//!
//! Source: the sums follow from Green's and Gauss's theorems; the ties from H. Edelsbrunner and
//! E. P. Mücke, "Simulation of Simplicity", ACM Transactions on Graphics 9(1), 1990.
//!
//! # Features
//!
//! - `serde`: results and parameters implement `Serialize` and `Deserialize`.

mod cavities;
mod contact_sums;
mod coplanar;
mod curve;
mod cut_edges;
mod depth;
mod error;
mod foundation;
mod inside;
mod joint;
mod located;
mod measures;
mod near_area;
mod overlap;
mod patches;
mod regions;
mod triangulation;

pub use glam;

pub use crate::contact_sums::{ContactMeasures, FaceContact, JointContact};
pub use crate::depth::{Depth, DepthParams};
pub use crate::error::JointContactError;
pub use crate::foundation::{ElasticFoundation, FoundationLaw};
pub use crate::joint::JointContactParams;
pub use crate::located::OverlapMeasures;
pub use crate::near_area::{AreaBracket, NearAreas};
pub use crate::overlap::{CurveChain, Overlap, OverlapDetector};
pub use crate::patches::ClippedFace;

/// Compiles and runs the README's example.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;
