//! Frames side by side in one SVG, seen along the bone.

use std::fmt::Write;

use glam::DVec3;

use crate::muscle::Muscle;

/// Width and height of a frame, in millimeters of the scene and in pixels.
const FRAME: [f64; 2] = [74.0, 90.0];
const SCALE: f64 = 3.0;
/// Height of the bone's axis over the lower edge of a frame.
const AXIS: f64 = 52.0;

pub(crate) struct Picture {
    bone: f64,
    body: String,
    columns: u32,
    column: u32,
    row: u32,
}

impl Picture {
    pub(crate) fn new(bone: f64) -> Self {
        Self { bone, body: String::new(), columns: 0, column: 0, row: 0 }
    }

    pub(crate) fn begin_row(&mut self, name: &str) {
        self.row += 1;
        self.column = 0;
        let [_, y] = self.place(DVec3::Z * (FRAME[1] - AXIS - 5.0));
        self.body += &format!("<text x=\"8\" y=\"{y:.1}\" font-size=\"15\">{name}</text>\n");
    }

    pub(crate) fn add(&mut self, muscle: &Muscle, time: f64) {
        let [x, y] = self.place(DVec3::ZERO);
        let radius = SCALE * self.bone;
        self.body += &format!(
            "<circle cx=\"{x:.1}\" cy=\"{y:.1}\" r=\"{radius:.1}\" fill=\"#e8e0cc\" stroke=\"#8a7f66\"/>\n\
             <text x=\"{x:.1}\" y=\"{:.1}\" font-size=\"12\" text-anchor=\"middle\">{:.0} ms</text>\n",
            y + SCALE * (AXIS - 4.0),
            1e3 * time,
        );
        let path = self.edges(muscle);
        self.body += &format!(
            "<path d=\"{path}\" stroke=\"#b03030\" stroke-width=\"0.6\" fill=\"none\"/>\n"
        );
        self.column += 1;
        self.columns = self.columns.max(self.column);
    }

    pub(crate) fn finish(self) -> String {
        let width = SCALE * FRAME[0] * f64::from(self.columns);
        let height = SCALE * FRAME[1] * f64::from(self.row);
        format!(
            "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {width:.0} {height:.0}\" \
             font-family=\"sans-serif\">\n<rect width=\"100%\" height=\"100%\" fill=\"white\"/>\n{}</svg>\n",
            self.body
        )
    }

    fn edges(&self, muscle: &Muscle) -> String {
        let mut path = String::new();
        for edge in muscle.surface.edges() {
            let [[x0, y0], [x1, y1]] = edge.map(|k| self.place(muscle.x[k as usize]));
            // Writing to a string cannot fail.
            let _ = write!(path, "M{x0:.1} {y0:.1}L{x1:.1} {y1:.1}");
        }
        path
    }

    /// Pixels of a point of the frame under way.
    fn place(&self, x: DVec3) -> [f64; 2] {
        let left = SCALE * FRAME[0] * (f64::from(self.column) + 0.5);
        let axis = SCALE * (FRAME[1] * f64::from(self.row) - AXIS);
        [left + SCALE * x.x, axis - SCALE * x.z]
    }
}
