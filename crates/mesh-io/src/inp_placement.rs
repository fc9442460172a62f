//! Placement of an instance in the assembly of an Abaqus input file: a translation, then a rotation about an axis.
//!
//! The axis is one of the assembly. Source: "Abaqus Keywords Reference Guide", `*INSTANCE`, for the data lines; "MCNP Code
//! User's Manual", section 8.7.2 of the edition with HDF5 meshes, for their order: the translation is applied before the rotation.

use glam::{DMat3, DVec3};
use surface::vectors::outer;

use crate::ReadError;
use crate::copy::max_rounding_in_text;
use crate::error::Format;
use crate::inp_keyword::real;
use crate::text::{Line, placed_fields, quoted};

/// Rounding of a position that is placed, or whose placement is undone \[units in the last place of the largest
/// number on the way\]: less than 8 operations per coordinate, with factors of a rotation that are rounded twice.
const ROUNDING_STEPS: f64 = 64.0;

/// Rigid transform from the axes of a part to those of the assembly, where the two differ.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Placement {
    translation: DVec3,
    rotation: Option<Rotation>,
}

/// Rotation about an axis.
#[derive(Clone, Debug, PartialEq)]
struct Rotation {
    /// Point of the axis.
    center: DVec3,
    matrix: DMat3,
}

impl Placement {
    /// Returns the position in the assembly of one in the part.
    pub(crate) fn place(&self, x: DVec3) -> DVec3 {
        let x = x + self.translation;
        match &self.rotation {
            Some(Rotation { center, matrix }) => *center + *matrix * (x - *center),
            None => x,
        }
    }

    /// Returns the position in the part of one in the assembly, rounded.
    pub(crate) fn undo(&self, x: DVec3) -> DVec3 {
        let x = match &self.rotation {
            Some(Rotation { center, matrix }) => *center + matrix.transpose() * (x - *center),
            None => x,
        };
        x - self.translation
    }

    /// Returns a bound on the distance between a position in the assembly, whose coordinates are at most
    /// `max_coordinate`, and where it is once it is undone, written, and placed again.
    pub(crate) fn max_rounding(&self, max_coordinate: f64) -> f64 {
        let center = self.rotation.as_ref().map_or(DVec3::ZERO, |rotation| rotation.center);
        let size =
            3.0_f64.sqrt() * max_coordinate + 2.0 * center.length() + self.translation.length();
        max_rounding_in_text(size) + ROUNDING_STEPS * f64::EPSILON * size
    }
}

/// Data lines below the keyword of an instance.
#[derive(Debug, Default)]
pub(crate) struct PlacementLines {
    translation: Option<DVec3>,
    rotation: Option<Rotation>,
}

impl PlacementLines {
    /// Reads a line: first the translation, then two points of the axis and the angle in degrees.
    pub(crate) fn read(&mut self, format: &Format, line: &Line<'_>) -> Result<(), ReadError> {
        if self.translation.is_none() {
            let [x, y, z] = numbers(format, line, "a translation of 3 numbers")?;
            self.translation = Some(DVec3::new(x, y, z));
            return Ok(());
        }
        if self.rotation.is_some() {
            let problem = "an instance is placed by two lines: a translation and a rotation";
            return Err(format.on_line(line.number, problem));
        }
        let [ax, ay, az, bx, by, bz, angle] =
            numbers(format, line, "a rotation of 7 numbers, two points and an angle")?;
        let (a, b) = (DVec3::new(ax, ay, az), DVec3::new(bx, by, bz));
        let Some(axis) = direction(a, b) else {
            let problem = if a == b {
                format!("both points of an axis of rotation are at {}", short(a))
            } else {
                format!(
                    "the points {} and {} of an axis of rotation are too far apart",
                    short(a),
                    short(b)
                )
            };
            return Err(format.on_line(line.number, problem));
        };
        self.rotation = Some(Rotation { center: a, matrix: rotation_matrix(axis, angle) });
        Ok(())
    }

    /// Returns the placement, `None` where it changes nothing.
    pub(crate) fn placement(self) -> Option<Placement> {
        let translation = self.translation.unwrap_or_default();
        let rotation = self.rotation.filter(|rotation| rotation.matrix != DMat3::IDENTITY);
        let is_identity = translation == DVec3::ZERO && rotation.is_none();
        (!is_identity).then_some(Placement { translation, rotation })
    }
}

/// Returns the numbers of a line; those that it leaves out are 0.
fn numbers<const N: usize>(
    format: &Format,
    line: &Line<'_>,
    meaning: &str,
) -> Result<[f64; N], ReadError> {
    let mut numbers = [0.0; N];
    for (place, field) in placed_fields(line.text, line.start, b',').enumerate() {
        if field.text.is_empty() {
            continue;
        }
        let value = real(field.text).filter(|value| value.is_finite());
        let (Some(value), Some(target)) = (value, numbers.get_mut(place)) else {
            let problem = format!("{} is no number of {meaning}", quoted(field.text));
            return Err(format.on_line(line.number, problem));
        };
        *target = value;
    }
    Ok(numbers)
}

/// Returns the text of a point, in which large numbers have exponents.
fn short(point: DVec3) -> String {
    format!("{:?}", point.to_array())
}

/// Returns the direction from one point to another, `None` where they are one or too far apart for numbers.
fn direction(a: DVec3, b: DVec3) -> Option<DVec3> {
    // Neither squares of long axes nor those of short ones leave the range of numbers.
    let along = b - a;
    let size = along.abs().max_element();
    if !(size > 0.0 && size.is_finite()) {
        return None;
    }
    (along / size).try_normalize()
}

/// Returns the right-handed rotation about an axis through the origin, by an angle in degrees; exact for quarter
/// turns about a coordinate axis.
fn rotation_matrix(axis: DVec3, degrees: f64) -> DMat3 {
    // Whole quarter turns are taken off first, without rounding.
    let turn = degrees % 360.0;
    let quarters = (turn / 90.0).round();
    let (sin, cos) = (turn - 90.0 * quarters).to_radians().sin_cos();
    let (sin, cos) = match quarters.rem_euclid(4.0) {
        quarter if quarter < 0.5 => (sin, cos),
        quarter if quarter < 1.5 => (cos, -sin),
        quarter if quarter < 2.5 => (-sin, -cos),
        _ => (-cos, sin),
    };

    // Rodrigues' formula.
    let cross = DMat3::from_cols(
        DVec3::new(0.0, axis.z, -axis.y),
        DVec3::new(-axis.z, 0.0, axis.x),
        DVec3::new(axis.y, -axis.x, 0.0),
    );
    DMat3::IDENTITY * cos + cross * sin + outer(axis, axis) * (1.0 - cos)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Precision;
    use crate::text::Lines;

    static FORMAT: Format = Format { name: "INP", remedy: "" };

    fn placed(lines: &str) -> Result<Option<Placement>, ReadError> {
        let mut read = PlacementLines::default();
        for line in Lines::new(lines.as_bytes()) {
            read.read(&FORMAT, &line)?;
        }
        Ok(read.placement())
    }

    /// Positions computed by hand.
    #[test]
    fn the_translation_comes_before_the_rotation() {
        let x = DVec3::new(1.0, 2.0, 3.0);
        let cases = [
            ("10., -2., 0.5", [11.0, 0.0, 3.5]),
            ("1., ,", [2.0, 2.0, 3.0]),
            // About z, from x to y.
            ("0, 0, 0\n0, 0, 0, 0, 0, 1, 90", [-2.0, 1.0, 3.0]),
            ("0, 0, 0\n0, 0, 0, 0, 0, 1, -270", [-2.0, 1.0, 3.0]),
            ("0, 0, 0\n0, 0, 7, 0, 0, 5, 90", [2.0, -1.0, 3.0]),
            ("0, 0, 0\n0, 0, 0, 0, 1e200, 0, 450.", [3.0, 2.0, -1.0]),
            ("0, 0, 0\n0, 0, 0, 1e-200, 0, 0, 180", [1.0, -2.0, -3.0]),
            // First to (5, 2, 3), then by (4, 2) about (1, 0): (-1, 4) of the assembly.
            ("4, 0, 0\n1, 0, 0, 1, 0, 9, 90", [-1.0, 4.0, 3.0]),
        ];
        for (lines, expected) in cases {
            let placement = placed(lines).expect(lines).expect(lines);
            assert_eq!(placement.place(x), DVec3::from_array(expected), "{lines}");
            assert_eq!(placement.undo(DVec3::from_array(expected)), x, "{lines}");
        }

        // A third of a turn about the diagonal takes each axis to the next.
        let placement = placed("0,0,0\n1,1,1,2,2,2,120").expect("numbers").expect("a rotation");
        let rounding = placement.max_rounding(3.0);
        assert!(placement.place(x).distance(DVec3::new(3.0, 1.0, 2.0)) < rounding);
        assert!(rounding < 1e-12, "{rounding}");
        for lines in ["", "0., 0., -0.", "0,0,0\n1,2,3,4,5,6,720"] {
            assert_eq!(placed(lines).expect(lines), None, "{lines}");
        }
    }

    /// Positions far from both the part and the axis.
    #[test]
    fn positions_that_are_placed_again_are_within_the_bound() {
        let mut random = fixtures::random::Random(5);
        for round in 0..2000 {
            let mut number = |size: f64| size * (random.unit() - 0.5);
            let [t, a, b] = [1e6, 1e3, 1.0].map(|size| [(); 3].map(|()| number(size)));
            let [t, a, b] = [t, a, b].map(DVec3::from_array);
            let mut lines = PlacementLines { translation: Some(t), rotation: None };
            let axis = direction(a, a + b).expect("two points");
            let matrix = rotation_matrix(axis, number(1000.0));
            lines.rotation = Some(Rotation { center: a, matrix });
            let placement = lines.placement().expect("a placement");

            let x = DVec3::from_array([(); 3].map(|()| number(200.0)));
            let written = placement.undo(x).to_array().map(|x| {
                let text = Precision::TwentyCharacters.text(x);
                text.parse::<f64>().expect("a number")
            });
            let off = placement.place(DVec3::from_array(written)).distance(x);
            let bound = placement.max_rounding(100.0);
            assert!(off <= bound, "round {round}: {off:e} > {bound:e}");
        }
    }

    #[test]
    fn lines_that_place_nothing_are_refused() {
        for (lines, problem) in [
            ("1, 2, x", "line 1: 'x' is no number of a translation of 3 numbers"),
            ("1, 2, 3, 4", "line 1: '4' is no number of a translation"),
            ("1, nan, 3", "line 1: 'nan' is no number of a translation"),
            ("0, 0, 0\n0, 0, 0, 0, 0, y, 9", "line 2: 'y' is no number of a rotation of 7"),
            (
                "0, 0, 0\n1, 2, 3, 1, 2, 3, 9",
                "line 2: both points of an axis of rotation are at [1.0, 2.0",
            ),
            (
                "0, 0, 0\n1e308, 0, 0, -1e308, 0, 0, 9",
                "line 2: the points [1e308, 0.0, 0.0] and [-1e308, 0.0, 0.0] of an axis of rotation are too far apart",
            ),
            ("0, 0, 0\n1, 2, 3, 1, 2, 4, 9\n1", "line 3: an instance is placed by two lines"),
        ] {
            let refusal = placed(lines).expect_err(lines).to_string();
            assert!(refusal.contains(problem), "{refusal}");
        }
    }
}
