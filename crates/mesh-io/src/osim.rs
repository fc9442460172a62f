//! OpenSim models (`.osim`): which mesh hangs on which body, its scale and its offset.
//!
//! Models of OpenSim 4 have `Mesh` elements in the `attached_geometry` of bodies and of offset frames
//! among their components ([`crate::osim_frames`]). Models of OpenSim 3 have a `VisibleObject` per
//! body, with the `DisplayGeometry` of its `GeometrySet`: both scales act before both transforms.
//! Other shapes than meshes, what hangs on the ground, and frames of joints are left out.
//!
//! Source: OpenSim API, classes `Mesh`, `PhysicalFrame` (which converts models of OpenSim 3) and,
//! before version 4, `DisplayGeometry` and `ModelVisualizer`. Orientations are body-fixed rotations
//! about x, y and z.

use glam::{DAffine3, DVec3};

use crate::osim_frames::Frames;
use crate::osim_values::{FORMAT, malformed, numbers, rigid, text_of, vector};
use crate::vtk::xml::Element;
use crate::{FilePlace, ReadError};

/// Bodies of an OpenSim model, in the order of the file. Lengths are in meters.
#[derive(Clone, Debug, PartialEq)]
pub struct OpenSimModel {
    /// The bodies.
    pub bodies: Vec<ModelBody>,
}

/// Body of a model.
#[derive(Clone, Debug, PartialEq)]
pub struct ModelBody {
    /// Name of the body, as in tables of kinematics.
    pub name: String,
    /// Mass center in the frame of the body, which tables of kinematics have the position of.
    pub mass_center: DVec3,
    /// Meshes that hang on the body.
    pub meshes: Vec<ModelMesh>,
}

/// Mesh that hangs on a body.
#[derive(Clone, Debug, PartialEq)]
pub struct ModelMesh {
    /// File of the mesh, as the model names it.
    pub file: String,
    /// Map from the coordinates of the file to the frame of the body: scale, then offset.
    pub placement: DAffine3,
}

impl OpenSimModel {
    /// Parses the content of a file.
    ///
    /// # Errors
    ///
    /// [`ReadError::Malformed`] with the byte of the first offense, and [`ReadError::Empty`].
    pub fn parse(content: &[u8]) -> Result<Self, ReadError> {
        if content.is_empty() {
            return Err(ReadError::Empty);
        }
        let document = Element::parse(content, false);
        let document =
            document.map_err(|error| FORMAT.malformed(FilePlace::Byte(error.at), error.problem))?;
        let model = document.child("OpenSimDocument").and_then(|open_sim| open_sim.child("Model"));
        let Some(model) = model else {
            return Err(malformed(&document, "has no <OpenSimDocument> with a <Model>"));
        };

        // Motions name the bodies that they move: two of one name could not be told apart.
        let objects = model.child("BodySet").and_then(|set| set.child("objects"));
        let elements = || objects.iter().flat_map(|objects| objects.children("Body"));
        let mut bodies: Vec<ModelBody> = Vec::new();
        for element in elements() {
            let body = ModelBody::read(element)?;
            if bodies.iter().any(|other| other.name == body.name) {
                let problem = format!("a second body is named '{}'", body.name);
                return Err(malformed(element, problem));
            }
            bodies.push(body);
        }
        if bodies.is_empty() {
            return Err(malformed(model, "the model has no bodies"));
        }

        // OpenSim 4 attaches meshes to frames, which may stand in those of other bodies.
        add_attached(model, elements(), &mut bodies)?;
        Ok(Self { bodies })
    }
}

impl ModelBody {
    fn read(element: &Element) -> Result<Self, ReadError> {
        let name = element.attribute("name").unwrap_or_default().to_owned();
        if name.is_empty() {
            return Err(malformed(element, "a body has no name"));
        }
        let mass_center = vector(element, "mass_center", DVec3::ZERO)?;

        // OpenSim 3 lists meshes as what is visible.
        let mut meshes = Vec::new();
        if let Some(visible) = element.child("VisibleObject") {
            add_displayed(visible, &mut meshes)?;
        }
        Ok(Self { name, mass_center, meshes })
    }
}

/// Adds the meshes of OpenSim 4 to the bodies that they follow.
fn add_attached<'a>(
    model: &'a Element,
    elements: impl Iterator<Item = &'a Element>,
    bodies: &mut [ModelBody],
) -> Result<(), ReadError> {
    Frames::of(model, elements).visit_meshes(|mesh, place| {
        let placement = place.to_body * DAffine3::from_scale(scale_of(mesh)?);
        let file = file_of(mesh, "mesh_file")?;
        bodies[place.body].meshes.push(ModelMesh { file, placement });
        Ok(())
    })
}

/// Adds the meshes of a body of OpenSim 3.
fn add_displayed(visible: &Element, meshes: &mut Vec<ModelMesh>) -> Result<(), ReadError> {
    // Both scales act on the coordinates of the file, before both transforms.
    let (of_body, scale) = (transform_of(visible)?, scale_of(visible)?);
    let objects = visible.child("GeometrySet").and_then(|set| set.child("objects"));
    for geometry in objects.iter().flat_map(|objects| objects.children("DisplayGeometry")) {
        let scale = DAffine3::from_scale(scale * scale_of(geometry)?);
        let placement = of_body * transform_of(geometry)? * scale;
        let file = file_of(geometry, "geometry_file")?;
        meshes.push(ModelMesh { file, placement });
    }
    Ok(())
}

/// Returns the name of a mesh file.
fn file_of(element: &Element, name: &str) -> Result<String, ReadError> {
    let file = element.child(name).map(text_of).unwrap_or_default();
    if file.is_empty() {
        return Err(malformed(element, format!("a mesh has no <{name}>")));
    }
    Ok(file)
}

/// Returns the scale of a mesh: 1 along each axis, unless the model has another.
fn scale_of(element: &Element) -> Result<DVec3, ReadError> {
    let scale = vector(element, "scale_factors", DVec3::ONE)?;
    if scale.cmpeq(DVec3::ZERO).any() {
        return Err(malformed(element, format!("a mesh is scaled by {scale}")));
    }
    Ok(scale)
}

/// Returns the offset of a mesh of OpenSim 3: three angles, then a translation.
fn transform_of(element: &Element) -> Result<DAffine3, ReadError> {
    let Some([rx, ry, rz, x, y, z]) = numbers(element, "transform")? else {
        return Ok(DAffine3::IDENTITY);
    };
    Ok(rigid(DVec3::new(rx, ry, rz), DVec3::new(x, y, z)))
}

#[cfg(test)]
mod tests {
    use std::f64::consts::FRAC_PI_2;
    use std::fmt::Write as _;

    use super::*;

    fn model(body: &str) -> Vec<u8> {
        format!(
            "<?xml version=\"1.0\"?><OpenSimDocument Version=\"40000\"><Model name=\"leg\">\
             <BodySet><objects>{body}</objects></BodySet></Model></OpenSimDocument>"
        )
        .into_bytes()
    }

    #[test]
    fn meshes_of_open_sim_4_hang_on_bodies_and_offset_frames() {
        let text = format!(
            "<Body name=\"femur_r\"><mass_center>0 -0.17 0</mass_center>\
             <attached_geometry><Sphere name=\"s\"/><Mesh name=\"m\">\
             <scale_factors>2 1 1</scale_factors><mesh_file> femur.vtp </mesh_file></Mesh>\
             </attached_geometry><components><PhysicalOffsetFrame name=\"o\">\
             <translation>0 0 3</translation><orientation>0 0 {FRAC_PI_2}</orientation>\
             <attached_geometry><Mesh><mesh_file>cap.stl</mesh_file></Mesh></attached_geometry>\
             </PhysicalOffsetFrame></components></Body><Body name=\"torso\"/>"
        );
        let bodies = OpenSimModel::parse(&model(&text)).expect("a model").bodies;
        assert_eq!(bodies.len(), 2);
        assert_eq!(bodies[0].mass_center, DVec3::new(0.0, -0.17, 0.0));
        let [femur, cap] = &bodies[0].meshes[..] else { panic!("two meshes: {bodies:?}") };
        assert_eq!([&femur.file[..], &cap.file[..]], ["femur.vtp", "cap.stl"]);
        let x = DVec3::new(1.0, 5.0, 7.0);
        assert_eq!(femur.placement.transform_point3(x), DVec3::new(2.0, 5.0, 7.0));
        let expected = DVec3::new(-5.0, 1.0, 10.0);
        assert!(cap.placement.transform_point3(x).distance(expected) < 1e-14);
        assert!(bodies[1].meshes.is_empty());
    }

    #[test]
    fn meshes_of_open_sim_3_hang_on_visible_objects() {
        let text = format!(
            "<Body name=\"tibia\"><VisibleObject><GeometrySet><objects><DisplayGeometry>\
             <geometry_file>tibia.vtp</geometry_file><transform>0 0 {FRAC_PI_2} 1 0 0</transform>\
             <scale_factors>1 1 1</scale_factors></DisplayGeometry></objects></GeometrySet>\
             <scale_factors>1 3 1</scale_factors></VisibleObject></Body>"
        );
        let bodies = OpenSimModel::parse(&model(&text)).expect("a model").bodies;
        let mesh = &bodies[0].meshes[0];
        let x = mesh.placement.transform_point3(DVec3::new(2.0, 0.0, 0.0));
        assert!(x.distance(DVec3::new(1.0, 2.0, 0.0)) < 1e-14, "{x}");
        let y = mesh.placement.transform_point3(DVec3::new(0.0, 2.0, 0.0));
        assert!(y.distance(DVec3::new(-5.0, 0.0, 0.0)) < 1e-14, "{y}");
    }

    /// A frame stands in the frame that its socket names, not in the element that holds it.
    #[test]
    fn offset_frames_stand_in_the_frames_that_their_sockets_name() {
        let frame = |name: &str, socket: &str, x: f64, more: &str| {
            format!(
                "<PhysicalOffsetFrame name=\"{name}\"><socket_parent>{socket}</socket_parent>\
                 <translation>{x} 0 0</translation><attached_geometry><Mesh name=\"m\">\
                 <socket_frame>..</socket_frame><mesh_file>{name}.stl</mesh_file></Mesh>\
                 </attached_geometry>{more}</PhysicalOffsetFrame>"
            )
        };
        let inner = frame("inner", "/bodyset/femur/late", 16.0, "");
        let inner = format!("<components>{inner}</components>");
        let frames = [
            frame("own", "..", 1.0, &inner),
            frame("absolute", "/bodyset/tibia", 2.0, ""),
            frame("beside", "../late", 4.0, ""),
            frame("late", "/bodyset/femur", 8.0, ""),
            frame("across", "../../tibia/far", 32.0, ""),
            frame("fixed", "/ground", 64.0, ""),
        ];
        let far = frame("far", "/leg/bodyset/tibia", 128.0, "");
        let text = format!(
            "<Body name=\"femur\"><components>{}</components></Body>\
             <Body name=\"tibia\"><components>{far}</components></Body>",
            frames.concat()
        );
        let bodies = OpenSimModel::parse(&model(&text)).expect("a model").bodies;

        // Each sum of powers of two has one way to be a sum.
        let mut placed = Vec::new();
        for body in &bodies {
            for mesh in &body.meshes {
                placed
                    .push(format!("{} {} {}", body.name, mesh.file, mesh.placement.translation.x));
            }
        }
        let expected = [
            "femur own.stl 1",
            "femur inner.stl 24",
            "femur beside.stl 12",
            "femur late.stl 8",
            "tibia absolute.stl 2",
            "tibia across.stl 160",
            "tibia far.stl 128",
        ];
        assert_eq!(placed, expected);
    }

    #[test]
    fn offset_frames_turn_what_stands_in_them() {
        let mesh =
            "<attached_geometry><Mesh><mesh_file>m.stl</mesh_file></Mesh></attached_geometry>";
        let text = format!(
            "<Body name=\"b\"><components><PhysicalOffsetFrame name=\"turned\">\
             <translation>0 0 5</translation><orientation>0 0 {FRAC_PI_2}</orientation>\
             </PhysicalOffsetFrame><PhysicalOffsetFrame name=\"moved\">\
             <socket_parent>../turned</socket_parent><translation>2 0 0</translation>{mesh}\
             </PhysicalOffsetFrame></components></Body>"
        );
        let bodies = OpenSimModel::parse(&model(&text)).expect("a model").bodies;
        let x = bodies[0].meshes[0].placement.transform_point3(DVec3::X);
        assert!(x.distance(DVec3::new(0.0, 3.0, 5.0)) < 1e-14, "{x}");
    }

    #[test]
    fn geometry_in_another_frame_follows_its_socket() {
        let mesh = "<attached_geometry><Mesh><socket_frame>/bodyset/tibia</socket_frame>\
                    <mesh_file>m.stl</mesh_file></Mesh></attached_geometry>";
        let text = format!("<Body name=\"femur\">{mesh}</Body><Body name=\"tibia\"/>");
        let bodies = OpenSimModel::parse(&model(&text)).expect("a model").bodies;
        assert_eq!(bodies.iter().map(|body| body.meshes.len()).collect::<Vec<_>>(), [0, 1]);
    }

    #[test]
    fn sockets_without_a_frame_are_refused() {
        let frame = |name: &str, socket: &str| {
            format!(
                "<PhysicalOffsetFrame name=\"{name}\"><socket_parent>{socket}</socket_parent>\
                 <attached_geometry><Mesh><mesh_file>m.stl</mesh_file></Mesh></attached_geometry>\
                 </PhysicalOffsetFrame>"
            )
        };
        let refusal = |frames: &str| {
            let body = format!("<Body name=\"b\"><components>{frames}</components></Body>");
            OpenSimModel::parse(&model(&body)).expect_err("not placed").to_string()
        };
        for socket in ["/bodyset/other", "/jointset/hip/b_offset", "b", "../../../.."] {
            let error = refusal(&frame("o", socket));
            let problem = format!("'{socket}' is no body and no offset frame of one");
            assert!(error.contains(&problem), "{error}");
        }
        for frames in [frame("o", "."), frame("o", "../p") + &frame("p", "../o")] {
            let error = refusal(&frames);
            assert!(error.contains("stands in itself"), "{error}");
        }
    }

    /// The order of OpenSim: scales first, whichever element has them, then both transforms.
    #[test]
    fn scales_of_open_sim_3_do_not_stretch_offsets() {
        let text = "<Body name=\"tibia\"><VisibleObject><GeometrySet><objects><DisplayGeometry>\
             <geometry_file>tibia.vtp</geometry_file><transform>0 0 0 1 10 0</transform>\
             <scale_factors>2 2 2</scale_factors></DisplayGeometry></objects></GeometrySet>\
             <scale_factors>1 3 1</scale_factors><transform>0 0 0 0 0 5</transform>\
             </VisibleObject></Body>";
        let bodies = OpenSimModel::parse(&model(text)).expect("a model").bodies;
        let x = bodies[0].meshes[0].placement.transform_point3(DVec3::ONE);
        assert_eq!(x, DVec3::new(3.0, 16.0, 7.0));
    }

    #[test]
    fn invalid_models_are_refused_by_place() {
        let mesh = |inner: &str| {
            model(&format!(
                "<Body name=\"b\"><attached_geometry><Mesh>{inner}</Mesh></attached_geometry></Body>"
            ))
        };
        let cases = [
            Vec::new(),
            b"<OpenSimDocument><Model>".to_vec(),
            b"<Model></Model>".to_vec(),
            model(""),
            model("<Body/>"),
            model("<Body name=\"b\"/><Body name=\"b\"/>"),
            model("<Body name=\"b\"><mass_center>0 0</mass_center></Body>"),
            model("<Body name=\"b\"><mass_center>0 0 NaN</mass_center></Body>"),
            mesh(""),
            mesh("<mesh_file>b.vtp</mesh_file><scale_factors>1 0 1</scale_factors>"),
            mesh("<mesh_file>b.vtp</mesh_file><scale_factors>1 1 \u{1b}[2J</scale_factors>"),
        ];
        let mut problems = String::new();
        for content in cases {
            let problem = OpenSimModel::parse(&content).expect_err("not a model");
            writeln!(problems, "{problem}").expect("text");
        }
        insta::assert_snapshot!(problems);
    }
}
