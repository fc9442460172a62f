//! Results as dictionaries of numbers and arrays, from which Python makes its classes.

use glam::DVec3;
use musculo_collide::{
    AreaBracket, Coincidence, Depth, Overlap, OverlapMeasures, PairReport, Scene, SweepReport,
    SweptContact, VertexReport,
};
use pyo3::prelude::*;
use pyo3::types::PyDict;

use crate::arrays::{array, point_array, row_array};

/// Makes a dictionary of named values.
macro_rules! dict {
    ($py:expr, { $($key:ident: $value:expr),* $(,)? }) => {{
        let dict = PyDict::new($py);
        $(dict.set_item(stringify!($key), $value)?;)*
        dict
    }};
}
pub(crate) use dict;

type Record<'py> = PyResult<Bound<'py, PyDict>>;

/// Returns the record of one pair of bodies.
pub(crate) fn pair<'py>(py: Python<'py>, report: &PairReport, scene: &Scene) -> Record<'py> {
    let [a, b] = scene.names(report.pair);
    let [near_area_of_a, near_area_of_b] = match report.near_areas {
        Some(areas) => areas.map(|AreaBracket { lower, upper }| Some((lower, upper))),
        None => [None; 2],
    };
    let measures = report.overlap.as_ref().map(|found| overlap(py, &found.measures)).transpose()?;
    let depths =
        report.overlap.as_ref().map(|overlap| [overlap.depth_of_a_in_b, overlap.depth_of_b_in_a]);
    let [depth_of_a_in_b, depth_of_b_in_a] = depths.unwrap_or_default();
    Ok(dict!(py, {
        a: a,
        b: b,
        overlaps: report.overlaps,
        coincidence: report.coincidence.map(coincidence_name),
        overlap: measures,
        depth_of_a_in_b: depth(py, depth_of_a_in_b)?,
        depth_of_b_in_a: depth(py, depth_of_b_in_a)?,
        near_area_of_a: near_area_of_a,
        near_area_of_b: near_area_of_b,
        max_vertex_depth: report.max_vertex_depth,
        min_gap: report.min_gap,
        distance: report.distance,
        crossing_faces: row_array(py, &report.crossing_faces),
        vertices_of_a: vertices(py, &report.a_against_b)?,
        vertices_of_b: vertices(py, &report.b_against_a)?,
    }))
}

/// Returns the record of what two bodies share.
pub(crate) fn overlap<'py>(py: Python<'py>, measured: &Overlap) -> Record<'py> {
    let mut regions = Vec::new();
    for region in &measured.regions {
        regions.push(measures(py, region)?);
    }
    Ok(dict!(py, {
        total: measures(py, &measured.total)?,
        regions: regions,
        has_ties: measured.has_ties,
        no_inside: measured.no_inside.map(|reason| reason.map(|reason| reason.to_string())).to_vec(),
        covers_twice: measured.covers_twice.to_vec(),
    }))
}

fn measures<'py>(py: Python<'py>, measures: &OverlapMeasures) -> Record<'py> {
    Ok(dict!(py, {
        volume: measures.volume,
        centroid: measures.centroid.map(vector),
        area_of_a_inside_b: measures.area_of_a_inside_b,
        area_of_b_inside_a: measures.area_of_b_inside_a,
        touching_area: measures.touching_area,
        flush_area: measures.flush_area,
        curve_length: measures.curve_length,
        curve_loops: measures.curve_loops,
        curve_arcs: measures.curve_arcs,
        normal: vector(measures.normal),
        inside_vertices: (measures.inside_vertices[0], measures.inside_vertices[1]),
    }))
}

/// Returns the record of a depth.
pub(crate) fn depth(py: Python<'_>, depth: Option<Depth>) -> PyResult<Option<Bound<'_, PyDict>>> {
    let Some(depth) = depth else { return Ok(None) };
    Ok(Some(dict!(py, {
        lower: depth.lower,
        upper: depth.upper,
        point: vector(depth.point),
        face: depth.face,
        foot: vector(depth.foot),
        is_narrow: depth.is_narrow,
    })))
}

fn vertices<'py>(py: Python<'py>, report: &VertexReport) -> Record<'py> {
    let near = &report.near;
    let feet: Vec<DVec3> = near.iter().map(|near| near.foot).collect();
    let normals: Vec<DVec3> = near.iter().map(|near| near.normal).collect();
    Ok(dict!(py, {
        inside_count: report.inside_count.ok(),
        no_inside: report.inside_count.err().map(|reason| reason.to_string()),
        vertices: array(py, near.iter().map(|near| near.vertex).collect()),
        gaps: array(py, near.iter().map(|near| near.gap).collect()),
        feet: point_array(py, &feet),
        faces: array(py, near.iter().map(|near| near.face).collect()),
        normals: point_array(py, &normals),
    }))
}

/// Returns the record of a step.
pub(crate) fn sweep<'py>(py: Python<'py>, report: &SweepReport, scene: &Scene) -> Record<'py> {
    let mut pairs = Vec::new();
    for pair in &report.pairs {
        let [a, b] = scene.names(pair.pair);
        pairs.push(dict!(py, {
            a: a,
            b: b,
            contacts: swept_contacts(py, &pair.contacts)?,
        }));
    }
    Ok(dict!(py, {
        largest_free_step: report.largest_free_step,
        candidates: report.candidates,
        pairs: pairs,
    }))
}

fn swept_contacts<'py>(py: Python<'py>, contacts: &[SweptContact]) -> Record<'py> {
    let normals: Vec<DVec3> = contacts.iter().map(|found| found.contact.normal).collect();
    let is_edge_edge = |found: &SweptContact| found.kind == musculo_collide::ContactKind::EdgeEdge;
    Ok(dict!(py, {
        times: array(py, contacts.iter().map(|found| found.contact.time.unwrap_or(0.0)).collect()),
        latest: array(py, contacts.iter().map(|found| found.latest).collect()),
        normals: point_array(py, &normals),
        edge_edge: array(py, contacts.iter().map(is_edge_edge).collect()),
        certain: array(py, contacts.iter().map(|found| found.certain).collect()),
        at_start: array(py, contacts.iter().map(|found| found.at_start).collect()),
    }))
}

/// Returns the name that the program's reports have.
fn coincidence_name(coincidence: Coincidence) -> &'static str {
    match coincidence {
        Coincidence::SameMesh => "same_mesh",
        Coincidence::SameSurface => "same_surface",
        _ => "coincident",
    }
}

/// Returns a vector as three numbers.
pub(crate) fn vector(v: DVec3) -> (f64, f64, f64) {
    v.into()
}
