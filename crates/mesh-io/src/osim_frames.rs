//! Frames of OpenSim 4: bodies, and the offset frames among their components.
//!
//! An offset frame stands in the frame that its socket names by a path, absolute from the model on
//! (`/bodyset/femur_r`) or relative to itself (`..`, the one that holds it). This need not be a frame
//! of the body that holds it.
//!
//! Source: OpenSim API, classes `PhysicalOffsetFrame`, `Socket` and `ComponentPath`.

use std::collections::HashMap;

use glam::{DAffine3, DVec3};

use crate::ReadError;
use crate::osim_values::{malformed, rigid, text_of, vector};
use crate::text::quoted;
use crate::vtk::xml::Element;

/// Name of the set of bodies, in paths.
const BODY_SET: &str = "bodyset";

/// Path of the frame that does not move.
const GROUND: [&str; 1] = ["ground"];

/// Sockets by which a frame names its parent, of OpenSim 4 and of its first versions.
const PARENT: [&str; 2] = ["socket_parent", "socket_parent_connectee_name"];

/// Sockets by which a mesh names its frame.
const FRAME: [&str; 2] = ["socket_frame", "socket_frame_connectee_name"];

/// Frames of the bodies of a model, in the order of the file.
#[derive(Debug)]
pub(crate) struct Frames<'a> {
    model: &'a str,
    frames: Vec<Frame<'a>>,
    /// Numbers of the frames, by their paths; the first of two with one path.
    numbers: HashMap<Vec<&'a str>, usize>,
}

/// Body, or offset frame among the components of one.
#[derive(Debug)]
struct Frame<'a> {
    element: &'a Element,
    /// Names from the set of bodies on.
    path: Vec<&'a str>,
    /// Number of the body, unless this is an offset frame.
    body: Option<usize>,
}

/// Place of a frame: a body, and the map from the frame to it.
#[derive(Clone, Copy, Debug)]
pub(crate) struct FramePlace {
    pub(crate) body: usize,
    pub(crate) to_body: DAffine3,
}

impl<'a> Frames<'a> {
    /// Collects the frames of bodies.
    pub(crate) fn of(model: &'a Element, bodies: impl Iterator<Item = &'a Element>) -> Self {
        let model = name_of(model);
        let mut frames = Self { model, frames: Vec::new(), numbers: HashMap::new() };
        for (number, body) in bodies.enumerate() {
            frames.add(body, vec![BODY_SET, name_of(body)], Some(number));
        }
        frames
    }

    /// Adds a frame, and those among its components.
    fn add(&mut self, element: &'a Element, path: Vec<&'a str>, body: Option<usize>) {
        self.numbers.entry(path.clone()).or_insert(self.frames.len());
        self.frames.push(Frame { element, path: path.clone(), body });
        for components in element.children("components") {
            for offset in components.children("PhysicalOffsetFrame") {
                self.add(offset, [&path[..], &[name_of(offset)]].concat(), None);
            }
        }
    }

    /// Calls `visit` with each mesh that hangs on a frame, and the place of the frame.
    ///
    /// Meshes that follow the ground are passed over.
    pub(crate) fn visit_meshes(
        &self,
        mut visit: impl FnMut(&'a Element, FramePlace) -> Result<(), ReadError>,
    ) -> Result<(), ReadError> {
        for frame in &self.frames {
            for attached in frame.element.children("attached_geometry") {
                for mesh in attached.children("Mesh") {
                    if let Some(place) = self.place_of_mesh(frame, mesh)? {
                        visit(mesh, place)?;
                    }
                }
            }
        }
        Ok(())
    }

    /// Returns the place of the frame that a mesh follows; `None` for the ground.
    fn place_of_mesh(
        &self,
        holder: &Frame<'a>,
        mesh: &'a Element,
    ) -> Result<Option<FramePlace>, ReadError> {
        let Some(socket) = socket(mesh, FRAME) else { return self.place(holder) };
        let path = [&holder.path[..], &[name_of(mesh)]].concat();
        match self.connected(&path, socket)? {
            Some(frame) => self.place(frame),
            None => Ok(None),
        }
    }

    /// Returns the place of a frame; `None` where it stands in the ground.
    fn place(&self, frame: &Frame<'a>) -> Result<Option<FramePlace>, ReadError> {
        let (mut frame, mut to_body) = (frame, DAffine3::IDENTITY);

        // A chain that is longer than all frames comes back to one of them.
        for _ in 0..=self.frames.len() {
            if let Some(body) = frame.body {
                return Ok(Some(FramePlace { body, to_body }));
            }
            let translation = vector(frame.element, "translation", DVec3::ZERO)?;
            let orientation = vector(frame.element, "orientation", DVec3::ZERO)?;
            to_body = rigid(orientation, translation) * to_body;

            let parent = match socket(frame.element, PARENT) {
                Some(socket) => self.connected(&frame.path, socket)?,
                None => self.at(&frame.path[..frame.path.len() - 1]),
            };
            let Some(parent) = parent else { return Ok(None) };
            frame = parent;
        }
        Err(malformed(frame.element, "an offset frame stands in itself, by way of its parents"))
    }

    /// Returns the frame that a socket names, seen from a path; `None` for the ground.
    fn connected(
        &self,
        from: &[&'a str],
        socket: &'a Element,
    ) -> Result<Option<&Frame<'a>>, ReadError> {
        let text = std::str::from_utf8(&socket.text).unwrap_or_default().trim();
        let path = self.absolute(from, text);
        if path == GROUND {
            return Ok(None);
        }
        match self.at(&path) {
            Some(frame) => Ok(Some(frame)),
            None => {
                let problem = format!("{} is no body and no offset frame of one", quoted(text));
                Err(malformed(socket, problem))
            }
        }
    }

    /// Returns the names from the model on of a path that is written at `from`.
    fn absolute(&self, from: &[&'a str], text: &'a str) -> Vec<&'a str> {
        let is_absolute = text.starts_with('/');
        let mut path = if is_absolute { Vec::new() } else { from.to_vec() };
        for name in text.split('/') {
            match name {
                "" | "." => {}
                ".." => drop(path.pop()),
                name => path.push(name),
            }
        }

        // The first versions began with the name of the model.
        if is_absolute && path.len() > 1 && path[0] == self.model && path[0] != BODY_SET {
            path.remove(0);
        }
        path
    }

    fn at(&self, path: &[&str]) -> Option<&Frame<'a>> {
        self.numbers.get(path).map(|&number| &self.frames[number])
    }
}

/// Returns the socket of an element, unless it is empty.
fn socket<'a>(element: &'a Element, names: [&str; 2]) -> Option<&'a Element> {
    let sockets = names.into_iter().filter_map(|name| element.child(name));
    sockets.into_iter().find(|socket| !text_of(socket).is_empty())
}

fn name_of(element: &Element) -> &str {
    element.attribute("name").unwrap_or_default()
}
