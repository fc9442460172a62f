//! Overview of speed against accuracy: the methods that a reader chooses between, named at their
//! curves.

use std::error::Error;

use super::methods::METHODS;
use super::task::PairGroup;
use crate::chart::axes::Axis;
use crate::chart::curves::{
    CAPTION_LINE, Curve, CurveStyle, Panel, caption, draw_caption, picture,
};
use crate::chart::poster::Figure;
use crate::chart::sheet::Sheet;

const WIDTH: u32 = 1000;
const BODY: u32 = 480;

const TIME: Figure = Figure::new("time per frame [ms]", &["frame [ms]"]);
const ERROR: Figure = Figure::new("max error of a depth [mm]", &["max error [mm]"]);

/// Decimal logarithms of the errors that are shown; smaller ones are drawn at 0.
const ERRORS: [f64; 2] = [-3.0, 1.0];

const DEPTH: &str = "plan and depths of surfaces: the deepest point of any face or edge, within a proved bound; all other methods: vertices";

const LESSON: &str = "exact detection of vertices takes less time than almost every approximation of it, and contacts that are kept take less still while bodies touch at the same places. Fields pay for bones where an error of a tenth of a millimeter is allowed; a plan proves depths of whole surfaces in less time than it takes to compute them exactly";

/// Methods that are shown, with the names at their curves.
const SHOWN: [(&str, &str); 9] = [
    ("exact surfaces", "exact"),
    ("measures of overlaps", "depths of surfaces"),
    ("plan", "plan"),
    ("permanent contacts", "kept contacts"),
    ("reduced surfaces", "coarse surfaces"),
    ("distance field (exact band)", "distance field"),
    ("medial (exact feet)", "medial balls"),
    ("spatial hash", "spatial hash"),
    ("layered depth images", "depth images"),
];

/// Draws the overview as SVG: a panel per group of pairs.
///
/// # Errors
///
/// When it cannot be drawn.
pub(super) fn draw(sheet: &Sheet) -> Result<String, Box<dyn Error>> {
    let of_sheet = |name| sheet.settings.iter().find(|(own, _)| *own == name).cloned();
    let mut settings = vec![("depth", DEPTH.to_owned())];
    settings.extend(of_sheet("scene"));
    settings.push(("to take from it", LESSON.to_owned()));
    settings.extend(of_sheet("machine"));
    let lines = caption(&settings, WIDTH);
    let foot = CAPTION_LINE * (u32::try_from(lines.len())? + 1);

    let heading = "Speed against accuracy, by method";
    picture(heading, WIDTH, [BODY, foot], |body, foot| {
        let names = SHOWN.map(|(_, name)| name.to_owned());
        let (left, right) = body.split_horizontally(WIDTH / 2);
        panel(sheet, PairGroup::Bone).draw_named(&left, &names)?;
        panel(sheet, PairGroup::Muscles).draw_named(&right, &names)?;
        draw_caption(foot, &lines, 5)
    })
}

/// Returns time over error in one group of pairs.
fn panel(sheet: &Sheet, group: PairGroup) -> Panel {
    let mut curves = Vec::new();
    for (method, _) in SHOWN {
        let rows = sheet.rows_of("pairs", group.title()).filter(|row| row["method"] == method);
        let points = ERROR.with_times(TIME, rows);
        curves.push(Curve { style: style(method), points });
    }
    Panel {
        title: group.title().to_owned(),
        x: Axis { zero: Some(ERRORS[0]), ..Axis::powers(ERROR.label, ERRORS) },
        y_label: TIME.label.to_owned(),
        curves,
        has_front: true,
    }
}

/// Returns the style that a method has in the whole chart.
fn style(method: &str) -> CurveStyle {
    let all = METHODS.map(|method| method.key);
    let key = all.iter().find(|key| key.name == method).unwrap_or(&all[0]);
    key.style
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn all_shown_methods_are_charted() {
        for (method, _) in SHOWN {
            assert!(METHODS.iter().any(|charted| charted.key.name == method), "{method}");
        }
    }
}
