//! Joint contact as dictionaries.

use musculo_collide::overlap::FaceContact;
use musculo_collide::{ContactMeasures, ElasticFoundation, FoundationLaw, JointContact};
use pyo3::prelude::*;
use pyo3::types::PyDict;

use crate::arrays::array;
use crate::error::refused;
use crate::record::{dict, vector};

/// Layer of cartilage, as Python has it.
#[derive(Debug, FromPyObject)]
pub(crate) struct Cartilage {
    youngs_modulus: f64,
    poissons_ratio: f64,
    thickness: f64,
    law: String,
}

impl Cartilage {
    pub(crate) fn foundation(&self) -> PyResult<ElasticFoundation> {
        let law = match self.law.as_str() {
            "linear" => FoundationLaw::Linear,
            "logarithmic" => FoundationLaw::Logarithmic,
            other => {
                let message =
                    format!("law is {other:?}, but must be \"linear\" or \"logarithmic\"");
                return Err(refused(message));
            }
        };
        let Self { youngs_modulus, poissons_ratio, thickness, .. } = *self;
        Ok(ElasticFoundation { youngs_modulus, poissons_ratio, thickness, law })
    }
}

/// Returns the record of the contact of one surface with another.
pub(crate) fn contact<'py>(
    py: Python<'py>,
    contact: &JointContact,
) -> PyResult<Bound<'py, PyDict>> {
    let mut regions = Vec::new();
    for region in &contact.regions {
        regions.push(measures(py, region)?);
    }
    let faces = &contact.faces;
    let column = |value: fn(&FaceContact) -> f64| array(py, faces.iter().map(value).collect());
    Ok(dict!(py, {
        total: measures(py, &contact.total)?,
        regions: regions,
        faces: array(py, faces.iter().map(|face| face.face).collect()),
        face_areas: column(|face| face.area),
        face_gaps: column(|face| face.mean_gap),
        face_pressures: column(|face| face.mean_pressure),
        face_regions: array(py, faces.iter().map(|face| face.region).collect()),
    }))
}

fn measures<'py>(py: Python<'py>, measures: &ContactMeasures) -> PyResult<Bound<'py, PyDict>> {
    Ok(dict!(py, {
        area: measures.area,
        area_lower: measures.area_lower,
        area_upper: measures.area_upper,
        center: vector(measures.center),
        mean_gap: measures.mean_gap,
        min_gap: measures.min_gap,
        mean_pressure: measures.mean_pressure,
        max_pressure: measures.max_pressure,
        force: vector(measures.force),
        center_of_pressure: vector(measures.center_of_pressure),
    }))
}
