//! Contact scene of two sheets pressed together, of any size.

use glam::DVec3;
use response::{ContactLaw, ContactRows, Margins, ResponseError};
use surface::{Contact, Stencil, SurfaceError, TriangleSurface};

/// Height of the upper sheet's vertices over the lower one.
const GAP: f64 = 0.01;

/// Two sheets: every vertex of the upper one is in contact with a face of the lower one.
#[derive(Debug)]
pub struct Sheets {
    /// Positions of the upper sheet's vertices, then of the lower one's.
    pub x: Vec<DVec3>,
    /// Velocities: uneven, toward each other, with slip.
    pub v: Vec<DVec3>,
    /// Inverse masses.
    pub inverse_mass: Vec<f64>,
    /// One contact per upper vertex.
    pub contacts: Vec<Contact>,
    /// The lower sheet, whose vertex 0 is particle `side * side`.
    pub lower: TriangleSurface,
    /// First particle of the lower sheet.
    pub first_lower: u32,
}

impl Sheets {
    /// Makes sheets of `side` × `side` vertices.
    ///
    /// # Errors
    ///
    /// When there are too many vertices to number.
    pub fn new(side: u32) -> Result<Self, SurfaceError> {
        let count = side * side;
        let (mut x, mut v) = (Vec::new(), Vec::new());
        for k in 0..2 * count {
            let is_upper = k < count;
            // The upper sheet is shifted, so that contacts are inside faces.
            let (shift, height) = if is_upper { (0.3, GAP) } else { (0.0, 0.0) };
            let [column, row] = [k % count % side, k % count / side].map(f64::from);
            x.push(DVec3::new(column + shift, row + shift, height));
            v.push(velocity(k, is_upper));
        }

        // Every square of vertices is two faces, which the vertex above it is in contact with.
        let mut faces = Vec::new();
        for k in 0..(side - 1) * (side - 1) {
            let a = k / (side - 1) * side + k % (side - 1);
            faces.extend([[a, a + 1, a + side], [a + 1, a + side + 1, a + side]]);
        }
        let mut contacts = Vec::new();
        for k in 0..count {
            contacts.push(contact(k, side, &faces, &x));
        }
        let lower = TriangleSurface::new(count as usize, faces)?;
        let inverse_mass = vec![1.0; 2 * count as usize];
        Ok(Self { x, v, inverse_mass, contacts, lower, first_lower: count })
    }

    /// Returns the contacts as rows with friction.
    ///
    /// # Errors
    ///
    /// Never for the sheets made here.
    pub fn rows(&self) -> Result<ContactRows, ResponseError> {
        let mut rows = ContactRows::new(self.x.len());
        rows.extend(&self.contacts, ContactLaw::new(Margins::new(GAP, 1.0)?, 0.3)?)?;
        Ok(rows)
    }
}

fn velocity(k: u32, is_upper: bool) -> DVec3 {
    let uneven = f64::from(k.wrapping_mul(2_654_435_761) >> 16) / 65_536.0;
    if is_upper { DVec3::new(uneven, 0.3, -1.0 - uneven) } else { DVec3::ZERO }
}

fn contact(k: u32, side: u32, faces: &[[u32; 3]], x: &[DVec3]) -> Contact {
    let (column, row) = ((k % side).min(side - 2), (k / side).min(side - 2));
    let face = faces[2 * (row * (side - 1) + column) as usize];
    let corners = face.map(|corner| corner + side * side);

    // The contact is at the closest point of the face below.
    let at = corners.map(|corner| x[corner as usize]);
    let closest = surface::closest_on_triangle(x[k as usize], at);
    let away = x[k as usize] - closest.point;
    let normal = away.normalize();
    let stencil = Stencil::vertex_face(k, corners, closest.barycentric);
    Contact { stencil, anchor: None, normal, offset: 0.0, gap: away.dot(normal), time: None }
}
