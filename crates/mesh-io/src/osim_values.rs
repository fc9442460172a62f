//! Values of the elements of OpenSim's models: text, numbers, and the places that they give.

use glam::{DAffine3, DQuat, DVec3};

use crate::error::Format;
use crate::vtk::xml::Element;
use crate::{FilePlace, ReadError};

pub(crate) const FORMAT: Format =
    Format { name: "OSIM", remedy: "write the model with OpenSim 3 or 4" };

/// Returns a turn by body-fixed angles in radians about x, y and z, and a translation.
pub(crate) fn rigid(angles: DVec3, translation: DVec3) -> DAffine3 {
    let rotation = DQuat::from_rotation_x(angles.x)
        * DQuat::from_rotation_y(angles.y)
        * DQuat::from_rotation_z(angles.z);
    DAffine3::from_rotation_translation(rotation, translation)
}

/// Returns the three numbers of a child, or others where there is none.
pub(crate) fn vector(element: &Element, name: &str, absent: DVec3) -> Result<DVec3, ReadError> {
    Ok(numbers(element, name)?.map_or(absent, DVec3::from_array))
}

/// Returns the numbers of a child, if there is one.
pub(crate) fn numbers<const N: usize>(
    element: &Element,
    name: &str,
) -> Result<Option<[f64; N]>, ReadError> {
    let Some(child) = element.child(name) else { return Ok(None) };
    let text = text_of(child);
    let mut numbers = Vec::new();
    for word in text.split_whitespace() {
        numbers.extend(word.parse::<f64>().ok().filter(|number| number.is_finite()));
    }
    let is_complete = numbers.len() == text.split_whitespace().count();
    match <[f64; N]>::try_from(numbers) {
        Ok(numbers) if is_complete => Ok(Some(numbers)),
        _ => Err(malformed(child, format!("<{name}> is '{text}', not {N} finite numbers"))),
    }
}

/// Returns the text of an element, without space around it.
pub(crate) fn text_of(element: &Element) -> String {
    String::from_utf8_lossy(&element.text).trim().to_owned()
}

/// Returns the refusal of an element.
pub(crate) fn malformed(element: &Element, problem: impl AsRef<str>) -> ReadError {
    FORMAT.malformed(FilePlace::Byte(element.at), problem)
}
