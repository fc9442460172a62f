//! What reports of motions say: numbers of small scenes, and reasons of frames that are not resolved.

use fixtures::shapes;
use glam::DVec3;
use serde_json::Value;

use crate::support::{Workshop, obj};

const REST: &str = "[1,0,0,0, 0,1,0,0, 0,0,1,0, 0,0,0,1]";

/// Writes a scene of a bone that stays and muscles, with two frames at times a step apart.
fn scene(
    workshop: &Workshop,
    bone: &fixtures::Mesh,
    muscles: &[(&str, fixtures::Mesh)],
    more: &str,
) {
    workshop.write("bone.obj", obj(bone));
    let mut scene = "unit = \"m\"\nmotion = \"rest.json\"\n[[body]]\nfile = \"bone.obj\"\n\
                     kind = \"rigid\"\n"
        .to_owned();
    for (name, mesh) in muscles {
        workshop.write(&format!("{name}.obj"), obj(mesh));
        scene += &format!("[[body]]\nfile = \"{name}.obj\"\n");
    }
    workshop.write("scene.toml", scene + more);
    let frame = |time: &str| format!("{{\"t\": {time}, \"bone\": {REST}}}");
    let frames = [frame("0"), frame("4e-5")].join(", ");
    workshop.write("rest.json", format!("{{\"frames\": [{frames}]}}"));
}

/// Returns the texts of a picture.
fn texts(svg: &str) -> Vec<&str> {
    let parts = svg.split("<text").skip(1);
    parts.filter_map(|part| Some(part.split_once('>')?.1.split_once('<')?.0.trim())).collect()
}

/// Two balls of a radius of 1 cm that share a cap 1 mm high, in meters: both axes have ticks, none
/// of which is that of another value.
#[test]
fn charts_of_scenes_in_meters_have_ticks() {
    let workshop = Workshop::new();
    let ball = shapes::icosphere(0.01, 2);
    scene(&workshop, &ball, &[("muscle", ball.clone().translated(DVec3::X * 0.019))], "");
    let run = workshop.run("motion", &["scene.toml", "--chart", "m.svg"]);
    assert_eq!(run.status, 1, "{}", run.stderr);

    let svg = workshop.read("m.svg");
    let texts = texts(&svg);
    for title in ["deepest overlap [m]", "volume of overlaps [m³]"] {
        let place = texts.iter().position(|text| *text == title).expect("a panel");
        let ticks: Vec<&str> =
            texts[place + 2..].iter().copied().take_while(|text| !text.ends_with(']')).collect();
        let end = ticks.iter().skip(1).position(|tick| *tick == "0").expect("frames");
        let mut values = ticks[..=end].to_vec();
        values.dedup();
        assert!(values.len() == end + 1 && end > 3, "{title}: {ticks:?}");
    }
}

/// A body that crosses itself where one round is not enough, apart from a bone.
#[test]
fn a_frame_is_not_resolved_for_a_named_reason() {
    let workshop = Workshop::new();
    let ball = shapes::icosphere(0.01, 2);
    let both = ball.clone().joined(&ball.clone().translated(DVec3::new(0.003, 0.001, 0.0)));
    let away = ball.translated(DVec3::Y * 0.05);
    scene(&workshop, &away, &[("muscle", both)], "uncross = true\n");
    let arguments = ["scene.toml", "--resolve", "apart", "--rounds", "1", "--json", "m.json"];
    let run = workshop.run("motion", &arguments);
    assert_eq!(run.status, 1, "{}", run.stderr);
    for frame in 0..2 {
        let line = format!("frame {frame}: muscle still crosses itself\n");
        assert!(run.stdout.contains(&line), "{}", run.stdout);
    }
    assert!(run.stdout.contains("deepest 0.000000 m before"), "{}", run.stdout);

    let document: Value = serde_json::from_str(&workshop.read("m.json")).expect("JSON");
    for frame in document["frames"].as_array().expect("frames") {
        assert_eq!(frame["self_overlaps"], serde_json::json!(["muscle"]), "{frame}");
        assert_eq!(frame["before"], serde_json::json!({"pairs": 0, "deepest": 0.0}), "{frame}");
    }
}

/// Two ties of one pair are one pair, and times below a millisecond are not 0.
#[test]
fn a_pair_that_is_tied_twice_is_left_out_once() {
    let workshop = Workshop::new();
    let ball = shapes::icosphere(0.01, 2);
    let ties = "[[tie]]\na = \"bone\"\nb = \"muscle\"\nwithin = 0.004\n\
                [[tie]]\na = \"muscle\"\nb = \"bone\"\nwithin = 0.005\n";
    scene(&workshop, &ball, &[("muscle", ball.clone().translated(DVec3::X * 0.021))], ties);
    let run = workshop.run("motion", &["scene.toml", "--resolve", "apart", "--gap", "0.0001"]);
    assert_eq!(run.status, 0, "{}{}", run.stdout, run.stderr);
    let line = "is proved in every frame for all pairs but 1 tied, faces and edges included.\n";
    assert!(run.stdout.contains(line) && run.stdout.contains(" 0.000040 "), "{}", run.stdout);
}

/// A page moves a body by at most 32 maps: tissue of further segments would move with the wrong one.
#[test]
fn skins_of_more_segments_than_a_page_shows_are_refused() {
    let workshop = Workshop::new();
    let ball = shapes::icosphere(0.01, 1);
    scene(&workshop, &ball, &[("muscle", ball.clone().translated(DVec3::X * 0.03))], "");
    let outcome = |segments: u32| {
        let blends: Vec<[f64; 2]> =
            (1..segments).map(|k| 0.001 * f64::from(k)).map(|z| [z, z + 0.0005]).collect();
        let names = vec!["bone"; segments as usize];
        let skin = serde_json::json!({"axis": [0, 0, 1], "segments": names, "blends": blends});
        let motion = workshop
            .read("rest.json")
            .replace("{\"frames\"", &format!("{{\"skin\": {skin}, \"frames\""));
        workshop.write("skin.json", motion);
        workshop.run("motion", &["scene.toml", "--motion", "skin.json", "--report", "m.html"])
    };
    assert_eq!(outcome(32).status, 0);
    let refused = outcome(33);
    assert_eq!(refused.status, 2, "{}", refused.stdout);
    let problem = "skin.json: the skin has 33 segments, but a page shows 32 at most";
    assert!(refused.stderr.contains(problem), "{}", refused.stderr);
}

/// A page has the times of its frames as the table has them: a step of 40 µs is not 0.
#[test]
fn short_times_are_told_apart_on_a_page() {
    let workshop = Workshop::new();
    let ball = shapes::icosphere(0.01, 1);
    scene(&workshop, &ball, &[("muscle", ball.clone().translated(DVec3::X * 0.019))], "");
    let run = workshop.run("motion", &["scene.toml", "--report", "m.html"]);
    assert_eq!(run.status, 1, "{}", run.stderr);

    let page = workshop.read("m.html");
    let (_, model) = page.split_once("id=\"model\">").expect("a model");
    let (model, _) = model.split_once("</script>").expect("its end");
    let model: Value = serde_json::from_str(model).expect("JSON");
    let times = [0, 1].map(|frame| model["frames"][frame]["time"].as_str().expect("a text"));
    assert_eq!(times, ["0.000000", "0.000040"]);
    assert!(times.iter().all(|time| run.stdout.contains(time)), "{}", run.stdout);
}
