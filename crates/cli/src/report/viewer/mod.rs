//! Scenes that turn: a part of a page that draws bodies in WebGL, with overlaps in the colors of
//! their depth, and the frames of a motion on a slider.
//!
//! Everything is inside the page, so that it works without a network. Positions are 16-bit
//! fractions of the scene's box. Bodies move by weights and maps, as in the motion, so that a frame
//! costs its maps and the depths of vertices inside others. Where WebGL is missing, the part stays
//! hidden, and the pictures of the page remain.

mod blob;
mod coarse;
mod model;

use base64::Engine;
use base64::engine::general_purpose::STANDARD;

pub(crate) use self::coarse::ShownSurfaces;
pub(crate) use self::model::{Model, Recording};

/// Style of the part.
pub(super) const STYLE: &str = include_str!("viewer.css");

const SCRIPT: &str = include_str!("viewer.js");

impl Model {
    /// Writes the part of the page.
    pub(super) fn to_html(&self) -> serde_json::Result<String> {
        // Names may hold anything: no markup ends the element that holds them.
        let model = serde_json::to_string(self)?.replace('<', "\\u003c");
        let blob = STANDARD.encode(self.bytes());
        Ok(format!(
            "<div id=\"stage\" class=\"stage\">\n\
             <canvas title=\"Drag to turn, shift-drag to move, scroll to zoom\"></canvas>\n\
             <div class=\"side\"><div class=\"scale\"></div><h3>Overlaps: click to look at one</h3><div class=\"pairs\"></div>\
             <h3>Bodies</h3><div class=\"bodies\"></div></div>\n\
             <div class=\"time\"><output></output><span class=\"top\"></span><svg viewBox=\"0 0 1000 104\" \
             preserveAspectRatio=\"none\"></svg><input type=\"range\" min=\"0\" step=\"1\" \
             aria-label=\"frame\"></div>\n</div>\n\
             <script type=\"application/json\" id=\"model\">{model}</script>\n\
             <script type=\"text/plain\" id=\"blob\">{blob}</script>\n\
             <script>\n{SCRIPT}</script>\n"
        ))
    }
}
