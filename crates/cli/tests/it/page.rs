//! Pages that turn, in a browser where one is installed.

use std::path::Path;
use std::process::Command;

use crate::motion::needle_through_plate;
use crate::support::{Workshop, obj};

const THIGH: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../../fixtures/thigh/scene.toml");

/// Largest size of a page of the fixture: its pictures take most of it.
const MAX_BYTES: usize = 2_500_000;

/// Names under which browsers draw pages without a window.
const BROWSERS: [&str; 4] =
    ["chromium", "chromium-browser", "google-chrome", "google-chrome-stable"];

/// Finds a browser on the path.
fn browser() -> Option<&'static str> {
    let is_there = |name: &&str| Command::new(name).arg("--version").output().is_ok();
    BROWSERS.into_iter().find(|name| is_there(name))
}

/// Draws a page as PNG; `after` names a frame and a pair. Panics on any error of its script.
fn screenshot(browser: &str, workshop: &Workshop, page: &str, after: &str) -> Vec<u8> {
    let profile = workshop.path("profile");
    let picture = workshop.path("page.png");
    let url = format!("file://{}{after}", workshop.path(page).display());
    let output = Command::new(browser)
        .args(["--headless=new", "--no-sandbox", "--disable-dev-shm-usage", "--hide-scrollbars"])
        .args(["--use-angle=swiftshader", "--enable-unsafe-swiftshader", "--ignore-gpu-blocklist"])
        .args(["--window-size=1200,800", "--virtual-time-budget=5000", "--enable-logging=stderr"])
        .arg(format!("--user-data-dir={}", profile.display()))
        .arg(format!("--screenshot={}", picture.display()))
        .arg(url)
        .output()
        .expect("the browser runs");
    let log = String::from_utf8_lossy(&output.stderr);
    assert!(!log.contains("CONSOLE") && !log.contains("Uncaught"), "{page}{after}: {log}");
    std::fs::read(picture).expect("a picture")
}

/// Returns the share of pixels that differ between two pictures of one size.
fn difference(a: &[u8], b: &[u8]) -> f64 {
    let [a, b] = [a, b].map(pixels);
    assert_eq!(a.len(), b.len(), "pictures of one size");
    let differing = a.iter().zip(&b).filter(|(a, b)| a != b).count();
    let [differing, all] = [differing, a.len()].map(|count| u32::try_from(count).expect("few"));
    f64::from(differing) / f64::from(all)
}

fn pixels(png: &[u8]) -> Vec<u8> {
    let mut reader = png::Decoder::new(std::io::Cursor::new(png)).read_info().expect("a picture");
    let mut pixels = vec![0; reader.output_buffer_size().expect("a size")];
    reader.next_frame(&mut pixels).expect("pixels");
    pixels
}

/// A page needs nothing from outside, and stays small.
#[test]
fn pages_are_whole() {
    let workshop = Workshop::new();
    workshop.check(&[THIGH, "--report", "check.html"]);
    workshop.run("motion", &[THIGH, "--report", "motion.html"]);
    for page in ["check.html", "motion.html"] {
        let text = workshop.read(page);
        assert!(text.len() < MAX_BYTES, "{page} has {} bytes", text.len());
        for outside in ["src=\"http", "href=", "@import", "fetch(", "url(http"] {
            assert!(!text.contains(outside), "{page} has {outside}");
        }
        assert!(text.contains("id=\"stage\""), "{page} has nothing that turns");
    }
    assert!(workshop.read("motion.html").contains("<svg"), "a chart, where there is no WebGL");
}

/// The camera has bodies in view where they move, and not only where they are at rest.
#[test]
fn all_frames_are_in_view() {
    let workshop = needle_through_plate();
    workshop.run("motion", &["scene.toml", "--report", "motion.html"]);
    let page = workshop.read("motion.html");
    let begin = "<script type=\"application/json\" id=\"model\">";
    let (_, model) = page.split_once(begin).expect("a model");
    let (model, _) = model.split_once("</script>").expect("its end");
    let model: serde_json::Value = serde_json::from_str(model).expect("JSON");
    let height = |corner: usize| model["view"][corner][2].as_f64().expect("a height");

    // The tip of the needle goes from 1 to -3, its back is at 1.8 first.
    assert!((height(0) + 3.0).abs() < 1e-9 && (height(1) - 1.8).abs() < 1e-9, "{}", model["view"]);
}

/// Names of bodies are text, whatever is in them.
#[test]
fn names_cannot_end_the_script() {
    let workshop = Workshop::new();
    let name = "<script>alert(1)<&>";
    workshop.write("scene.toml", format!("[[body]]\nfile = \"a.obj\"\nname = \"{name}\"\n"));
    workshop.write("a.obj", obj(&fixtures::shapes::icosphere(10.0, 1)));
    let run = workshop.check(&["scene.toml", "--report", "c.html"]);
    assert_eq!(run.status, 0, "{}", run.stderr);
    assert!(!workshop.read("c.html").contains("<script>alert"), "markup in a name");
}

#[test]
#[expect(clippy::print_stdout, reason = "the test prints what it skips or measures")]
fn pages_draw_and_turn_in_a_browser() {
    let Some(browser) = browser() else {
        println!("skipped: no browser on the path of {BROWSERS:?}");
        return;
    };
    let workshop = needle_through_plate();
    workshop.check(&[THIGH, "--report", "check.html"]);
    workshop.run("motion", &[THIGH, "--report", "motion.html"]);
    assert!(Path::new(&workshop.path("motion.html")).exists(), "a page");

    // Bodies are drawn: the page with a script differs from the same page without.
    let page = workshop.read("check.html");
    let start = page.rfind("<script>").expect("a script");
    workshop.write("still.html", &page[..start]);
    let drawn = screenshot(browser, &workshop, "check.html", "");
    let still = screenshot(browser, &workshop, "still.html", "");
    println!("measured: pixels that a scene draws | {:.3}", difference(&drawn, &still));
    assert!(difference(&drawn, &still) > 0.05, "nothing is drawn");

    // A frame, and a pair that is chosen, change the picture.
    let first = screenshot(browser, &workshop, "motion.html", "#frame=0");
    let middle = screenshot(browser, &workshop, "motion.html", "#frame=12");
    let pair = screenshot(browser, &workshop, "motion.html", "#frame=12&pair=1");
    for (name, a, b) in [("frame", &first, &middle), ("pair", &middle, &pair)] {
        assert!(difference(a, b) > 0.01, "another {name} is the same picture");
    }
}
