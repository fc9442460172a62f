//! Draws the 18-DOPs of a muscle-like surface, level by level, to an SVG picture on standard output.
//!
//! ```text
//! cargo run --release -p kdop --example draw_tree > tree.svg
//! ```
//!
//! Every panel shows the bounds of one level of the tree, seen along z: the octagons that the
//! directions x, y and x ± y cut out.
#![expect(clippy::print_stdout, reason = "a program that writes a picture")]

use glam::{DVec2, DVec3};
use kdop::{Dop18, Leaves, Tree};

/// Width and height of a panel \[mm of the surface\].
const PANEL: [f64; 2] = [240.0, 140.0];
/// A fill for each level, from warm to cold.
const FILLS: [&str; 6] = ["#d1495b", "#edae49", "#9bc53d", "#3caea3", "#30638e", "#5d3a9b"];

fn main() {
    let (points, triangles) = bent_spindle(96, 40);
    let tree = match Tree::build(Leaves::Triangles(&triangles), &points) {
        Ok(tree) => tree,
        Err(error) => return println!("<!-- {error} -->"),
    };

    // Two panels per row.
    let levels = tree.levels();
    let height = PANEL[1] * f64::from(u32::try_from(levels.len().div_ceil(2)).unwrap_or(1));
    println!(
        r##"<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {} {height}" font-family="sans-serif">"##,
        2.0 * PANEL[0]
    );
    println!(r##"<rect width="100%" height="100%" fill="#ffffff"/>"##);
    for (level, bounds) in (0..).zip(&levels) {
        draw_level(level, bounds);
    }
    println!("</svg>");
}

/// Prints the panel of one level.
fn draw_level(level: u32, bounds: &[Dop18]) {
    let corner = [f64::from(level % 2) * PANEL[0], f64::from(level / 2) * PANEL[1]];
    println!(r#"<g transform="translate({} {})">"#, corner[0] + 115.0, corner[1] + 75.0);
    let fill = FILLS[level as usize % FILLS.len()];
    for bound in bounds {
        println!(
            r#"<polygon points="{}" fill="{fill}" fill-opacity="0.18" stroke="{fill}" stroke-width="0.3"/>"#,
            outline(bound)
        );
    }
    println!(
        r##"<text x="-110" y="-64" font-size="6" fill="#333333">level {level}: {} bounds</text></g>"##,
        bounds.len()
    );
}

/// Returns the octagon of a bound seen along z: the planes x, x+y, y and x−y in turn.
fn outline(bound: &Dop18) -> String {
    let [x, y, s, d] = [0, 1, 3, 4].map(|k| bound.interval(k).map(f64::from));

    // Corners between neighboring planes, counterclockwise from the right.
    let corners = [
        [x[1], x[1] - d[1]],
        [x[1], s[1] - x[1]],
        [s[1] - y[1], y[1]],
        [d[0] + y[1], y[1]],
        [x[0], x[0] - d[0]],
        [x[0], s[0] - x[0]],
        [s[0] - y[0], y[0]],
        [d[1] + y[0], y[0]],
    ];
    corners.map(|[x, y]| format!("{x:.2},{:.2}", -y)).join(" ")
}

/// Builds a closed spindle 200 mm long, bent to an arc, of `rings` rings of `around` vertices.
fn bent_spindle(rings: u32, around: u32) -> (Vec<DVec3>, Vec<[u32; 3]>) {
    let on_axis = |s: f64| {
        let angle = 2.4 * (s - 0.5);
        let (sin, cos) = angle.sin_cos();
        (DVec2::new(90.0 * sin, 90.0 * cos - 65.0), DVec2::new(sin, cos))
    };
    let at = |s: f64, turns: f64| {
        let (axis, out) = on_axis(s);
        let (sin, cos) = (std::f64::consts::TAU * turns).sin_cos();
        let thick = (std::f64::consts::PI * s).sin().max(0.0).powf(0.6);
        (axis + out * (18.0 * thick * cos)).extend(26.0 * thick * sin)
    };
    let share = |i: u32, n: u32| f64::from(i) / f64::from(n);
    let mut points = vec![at(0.0, 0.0), at(1.0, 0.0)];
    for i in 1..=rings {
        points.extend((0..around).map(|j| at(share(i, rings + 1), share(j, around))));
    }

    // Two poles, then the rings.
    let vertex = |i: u32, j: u32| 2 + i * around + j % around;
    let mut triangles = Vec::new();
    for j in 0..around {
        triangles.push([0, vertex(0, j + 1), vertex(0, j)]);
        triangles.push([1, vertex(rings - 1, j), vertex(rings - 1, j + 1)]);
        for i in 0..rings - 1 {
            let [a, b] = [vertex(i, j), vertex(i, j + 1)];
            let [c, d] = [vertex(i + 1, j), vertex(i + 1, j + 1)];
            triangles.extend([[a, b, d], [a, d, c]]);
        }
    }
    (points, triangles)
}
