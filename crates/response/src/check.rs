//! Checks of input data: code behind them meets only finite values.

use glam::DVec3;

use crate::{ParameterError, ResponseError};

/// Allowed deviation of a normal from unit length, a plain number.
///
/// A normal from a file or from 32-bit storage is off by 1e-7; one that was
/// never normalized, by much more. Within it the normal is scaled to length 1.
const UNIT_TOLERANCE: f64 = 1e-6;

/// Deviation of a sum of weights that counts as rounding, a plain number.
/// Barycentric weights are good to 1e-12 even on slivers; a forgotten term is
/// off by 1e-2 and more, and would break the momentum by its weight.
pub(crate) const WEIGHT_TOLERANCE: f64 = 1e-9;

/// Returns a parameter if it `holds` and is finite.
///
/// # Errors
///
/// [`ParameterError`] with the range in words.
pub fn parameter(
    name: &'static str,
    value: f64,
    range: &'static str,
    holds: bool,
) -> Result<f64, ParameterError> {
    let is_valid = holds && value.is_finite();
    if is_valid { Ok(value) } else { Err(ParameterError { name, value, range }) }
}

/// Returns a parameter if it is finite and above 0.
///
/// # Errors
///
/// [`ParameterError`] where it is not.
pub fn positive(name: &'static str, value: f64) -> Result<f64, ParameterError> {
    parameter(name, value, "finite and above 0", value > 0.0)
}

/// Returns a parameter if it is finite and at least 0.
///
/// # Errors
///
/// [`ParameterError`] where it is not.
pub fn not_negative(name: &'static str, value: f64) -> Result<f64, ParameterError> {
    parameter(name, value, "finite and at least 0", value >= 0.0)
}

/// Implements `Deserialize` by a constructor, so that what is read is checked as what is made.
#[cfg(feature = "serde")]
macro_rules! deserialize_checked {
    ($name:ident { $($field:ident: $of:ty),+ }, $made:expr) => {
        impl<'de> serde::Deserialize<'de> for $name {
            fn deserialize<D: serde::Deserializer<'de>>(from: D) -> Result<Self, D::Error> {
                #[derive(serde::Deserialize)]
                struct Fields {
                    $($field: $of),+
                }
                let Fields { $($field),+ } = Fields::deserialize(from)?;
                $made.map_err(serde::de::Error::custom)
            }
        }
    };
}

#[cfg(feature = "serde")]
pub(crate) use deserialize_checked;

/// Returns a count as a 32-bit index.
pub(crate) fn index(what: &'static str, count: usize) -> Result<u32, ResponseError> {
    let limit = u32::MAX as usize - 1;
    match u32::try_from(count) {
        Ok(index) if count <= limit => Ok(index),
        _ => Err(ResponseError::TooMany { what, count, limit }),
    }
}

/// Checks the length of a list.
pub(crate) fn count(what: &'static str, expected: usize, got: usize) -> Result<(), ResponseError> {
    if expected == got { Ok(()) } else { Err(ResponseError::Count { what, expected, got }) }
}

/// Checks that there is one finite vector per particle.
pub(crate) fn particles(
    what: &'static str,
    expected: usize,
    values: &[DVec3],
) -> Result<(), ResponseError> {
    count("particle states", expected, values.len())?;
    let Some(particle) = values.iter().position(|value| !value.is_finite()) else { return Ok(()) };
    let value = first_not_finite(values[particle]);
    Err(ResponseError::ParticleNotFinite { what, particle, value })
}

/// Checks that there is one finite inverse mass `>= 0` per particle.
pub(crate) fn inverse_masses(expected: usize, values: &[f64]) -> Result<(), ResponseError> {
    count("inverse masses", expected, values.len())?;
    match values.iter().position(|w| !(w.is_finite() && *w >= 0.0)) {
        None => Ok(()),
        Some(particle) => Err(ResponseError::InverseMass { particle, value: values[particle] }),
    }
}

/// Checks that a contact refers to existing particles only.
pub(crate) fn particle_range(
    contact: usize,
    particles: impl IntoIterator<Item = u32>,
    particle_count: usize,
) -> Result<(), ResponseError> {
    match particles.into_iter().find(|particle| *particle as usize >= particle_count) {
        None => Ok(()),
        Some(particle) => {
            Err(ResponseError::ParticleOutOfRange { contact, particle, particle_count })
        }
    }
}

/// Checks a sum of weights, whose magnitudes sum to `scale`.
pub(crate) fn weight_sum(
    contact: usize,
    sum: f64,
    scale: f64,
    expected: f64,
) -> Result<(), ResponseError> {
    if (sum - expected).abs() <= WEIGHT_TOLERANCE * f64::max(scale, 1.0) {
        Ok(())
    } else {
        Err(ResponseError::Weights { contact, sum, expected })
    }
}

/// Returns a vector of a contact if it is finite.
pub(crate) fn contact_vector(
    contact: usize,
    what: &'static str,
    value: DVec3,
) -> Result<DVec3, ResponseError> {
    if value.is_finite() {
        return Ok(value);
    }
    Err(ResponseError::ContactNotFinite { contact, what, value: first_not_finite(value) })
}

/// Returns a number of a contact if it is finite.
pub(crate) fn contact_number(
    contact: usize,
    what: &'static str,
    value: f64,
) -> Result<f64, ResponseError> {
    if value.is_finite() {
        return Ok(value);
    }
    Err(ResponseError::ContactNotFinite { contact, what, value })
}

/// Returns a normal scaled to unit length, if it has that length within the tolerance.
pub(crate) fn normal(contact: usize, normal: DVec3) -> Result<DVec3, ResponseError> {
    let length = contact_vector(contact, "normal", normal)?.length();
    if (length - 1.0).abs() <= UNIT_TOLERANCE {
        Ok(normal / length)
    } else {
        Err(ResponseError::Normal { contact, length })
    }
}

fn first_not_finite(value: DVec3) -> f64 {
    value.to_array().into_iter().find(|component| !component.is_finite()).unwrap_or(0.0)
}
