//! Tables of poses, beside motions computed by hand, and tables that are refused.

use std::collections::BTreeMap;
use std::f64::consts::PI;
use std::fmt::Write as _;
use std::fs;

use glam::{DVec3, dvec3};
use musculo_collide::surface::TriangleSurface;
use musculo_collide::{BodyKind, Scene};

use super::pose_table::MeshFrame;
use super::{Motion, MotionParams, Replay, opensim, pose_rows};
use crate::scene::Unit;

/// One bone in the frame of its body, and a muscle, in millimeters.
fn scene() -> Scene {
    let mut scene = Scene::new();
    for (name, kind) in [("femur_r", BodyKind::Rigid), ("cartilage", BodyKind::Deformable)] {
        let surface = TriangleSurface::new(3, vec![[0, 1, 2]]).expect("a triangle");
        let x = vec![dvec3(10.0, 0.0, 0.0), dvec3(0.0, -400.0, 0.0), dvec3(3.0, 4.0, 5.0)];
        scene.add(name, kind, surface, x).expect("a body");
    }
    scene
}

/// Writes a table to a file of an extension, and replays it.
fn replay(text: &str, extension: &str, params: &MotionParams) -> Replay {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join(format!("motion.{extension}"));
    fs::write(&path, text).expect("a file");
    Motion::replay(&path, params, &scene()).expect("a motion")
}

fn in_body_frames() -> MotionParams {
    MotionParams {
        scene_unit: Unit::Millimeter,
        meshes: MeshFrame::Body,
        ..MotionParams::default()
    }
}

/// Turns a point about z, then y, then x: rotations about turned axes, seen from space.
fn turned(point: DVec3, [about_x, about_y, about_z]: [f64; 3]) -> DVec3 {
    let (sin, cos) = about_z.sin_cos();
    let p = dvec3(cos * point.x - sin * point.y, sin * point.x + cos * point.y, point.z);
    let (sin, cos) = about_y.sin_cos();
    let p = dvec3(cos * p.x + sin * p.z, p.y, -sin * p.x + cos * p.z);
    let (sin, cos) = about_x.sin_cos();
    dvec3(p.x, cos * p.y - sin * p.z, sin * p.y + cos * p.z)
}

const FRAMES: u32 = 100;

/// Angles in degrees and position in meters of the bone in a frame.
fn walk(frame: u32) -> ([f64; 3], DVec3) {
    let t = f64::from(frame) / 10.0;
    (
        [20.0 * t.sin(), 150.0 * (0.3 * t).cos(), 33.0 * t],
        dvec3(0.01 * t, 0.9 + 0.02 * t.sin(), -0.3),
    )
}

/// A table of 100 frames in degrees, with its columns in an order of their own, a point without
/// orientation, and keys of the header that say nothing of poses.
fn opensim_table() -> String {
    let mut text = "Positions\nversion=1\nnRows=100\nnColumns=10\ninDegrees=yes\n\n\
                    Units are S.I. units (second, meters, Newtons, ...)\n\nendheader\n\
                    femur_r_Oz\tfemur_r_X\ttime\tcenter_of_mass_X\tcenter_of_mass_Y\t\
                    center_of_mass_Z\tfemur_r_Oy\tfemur_r_Z\tfemur_r_Y\tfemur_r_Ox\n"
        .to_owned();
    for frame in 0..FRAMES {
        let ([ox, oy, oz], p) = walk(frame);
        let time = f64::from(frame) / 100.0;
        writeln!(text, "{oz}\t{}\t{time}\t1\t2\t3\t{oy}\t{}\t{}\t{ox}", p.x, p.z, p.y)
            .expect("text");
    }
    text
}

#[test]
fn opensim_kinematics_in_degrees_and_meters_move_bones_in_body_frames() {
    let replay = replay(&opensim_table(), "sto", &in_body_frames());
    assert_eq!(replay.frame_count(), 100);
    for frame in 0..FRAMES {
        let (angles, position) = walk(frame);
        let positions = &replay.positions(frame as usize)[0];
        for (&x, &rest) in positions.iter().zip(scene().bodies()[0].positions()) {
            let expected = turned(rest, angles.map(|angle| angle * PI / 180.0)) + 1000.0 * position;
            assert!(x.distance(expected) < 1e-9, "frame {frame}: {x} for {expected}");
        }
    }
    assert_eq!(replay.time(7), Some(0.07));
}

/// A point that is not the origin of the body's frame, as a center of mass, gives the same motion.
#[test]
fn meshes_as_in_the_first_pose_do_not_depend_on_the_origin_of_poses() {
    let of_origin = replay(&opensim_table(), "mot", &MotionParams::default());
    let mut shifted =
        "endheader\ntime b_X b_Y b_Z b_Ox b_Oy b_Oz\n".replacen("end", "inDegrees=no\nend", 1);
    for frame in 0..FRAMES {
        let (angles, p) = walk(frame);
        let [ox, oy, oz] = angles.map(|angle| angle * PI / 180.0);
        let p = p + turned(dvec3(0.01, -0.17, 0.02), [ox, oy, oz]);
        writeln!(shifted, "{frame} {} {} {} {ox} {oy} {oz}", p.x, p.y, p.z).expect("text");
    }
    let follows = BTreeMap::from([("femur_r".to_owned(), "b".to_owned())]);
    let of_center = replay(&shifted, "sto", &MotionParams { follows, ..MotionParams::default() });

    assert_eq!(of_origin.positions(0)[0], scene().bodies()[0].positions());
    for frame in 0..FRAMES as usize {
        let pairs = of_origin.positions(frame)[0]
            .clone()
            .into_iter()
            .zip(of_center.positions(frame)[0].clone());
        for (a, b) in pairs {
            assert!(a.distance(b) < 1e-9, "frame {frame}: {a} for {b}");
        }
    }
}

/// A quarter turn about x with a shift, by quaternion and by matrix; the cartilage follows the bone
/// by name.
#[test]
fn rows_of_poses_move_bodies_by_quaternion_or_matrix() {
    let quaternions = "# of a camera\n body , time, x, y, z, qx, qz, qy, qw, quality\n\
                       femur, 0, 0, 0, 0, 0, 0, 0, 1, 0.9\n\
                       femur, 0.5, 1, 2, 3, 0.70710678, 0, 0, 0.70710678, 0.8\n";
    let matrices = "time,body,r11,r12,r13,r21,r22,r23,r31,r32,r33,x,y,z\n\
                    0,femur,1,0,0,0,1,0,0,0,1,0,0,0\n\
                    0.5,femur,1,0,0,0,0,-1,0,1,0,1,2,3\n";
    let mut params = in_body_frames();
    for body in ["femur_r", "cartilage"] {
        params.follows.insert(body.to_owned(), "femur".to_owned());
    }

    for text in [quaternions, matrices] {
        let replay = replay(text, "csv", &params);
        let expected = [dvec3(11.0, 2.0, 3.0), dvec3(1.0, 2.0, -397.0), dvec3(4.0, -3.0, 7.0)];
        for body in 0..2 {
            for (&x, expected) in replay.positions(1)[body].iter().zip(expected) {
                assert!(x.distance(expected) < 1e-9, "{x} for {expected}");
            }
        }
    }

    // Rounded to three digits, it is a rotation all the same.
    let rounded = "time,body,r11,r12,r13,r21,r22,r23,r31,r32,r33,x,y,z\n\
                   0,femur,1,0,0,0,1,0,0,0,1,0,0,0\n\
                   0.5,femur,1,0,0,0,.866,-.5,0,.5,.866,1,2,3\n";
    let positions = replay(rounded, "csv", &params).positions(1)[0].clone();
    let rest = scene().bodies()[0].positions().to_vec();
    for (a, b) in [(0, 1), (1, 2), (2, 0)] {
        let lengths = [positions[a].distance(positions[b]), rest[a].distance(rest[b])];
        assert!((lengths[0] - lengths[1]).abs() < 1e-9, "{lengths:?}");
    }

    // Lengths of the table in centimeters.
    params.table_unit = Some(Unit::Centimeter);
    let x = replay(matrices, "csv", &params).positions(1)[0][0];
    assert!(x.distance(dvec3(20.0, 20.0, 30.0)) < 1e-9, "{x}");
}

#[test]
fn invalid_opensim_tables_are_refused_by_line_and_column() {
    let header = "inDegrees=yes\nendheader\n";
    let labels = "time b_X b_Y b_Z b_Ox b_Oy b_Oz\n";
    let cases = [
        String::new(),
        "endheader\n".to_owned(),
        format!("endheader\n{labels}0 0 0 0 0 0 0\n"),
        format!("inDegrees=perhaps\nendheader\n{labels}"),
        format!("Velocities\n{header}{labels}"),
        format!("{header}time knee_angle_r\n0 0\n"),
        format!("{header}b_X b_Y b_Z b_Ox b_Oy b_Oz\n"),
        format!("{header}time b_X b_Y b_Ox b_Oy b_Oz\n"),
        format!("{header}time b_X b_X b_Y b_Z b_Ox b_Oy b_Oz\n"),
        format!("{header}time b_X b_Y b_Z b_Ox b_Oy b_Oz Time\n"),
        format!("nColumns=8\n{header}{labels}"),
        format!("{header}{labels}0 0 0 0 0 0\n"),
        format!("{header}{labels}0 0 0 \u{1b}[2J 0 0 0\n"),
        format!("{header}{labels}0 0 0 NaN 0 0 0\n"),
        format!("{header}{labels}0.1 0 0 0 0 0 0\n0.1 0 0 0 0 0 0\n"),
        format!("nRows=3\n{header}{labels}0.1 0 0 0 0 0 0\n0.2 0 0 0 0 0 0\n"),
    ];
    let mut problems = String::new();
    for text in cases {
        let problem = opensim::parse(&text).map(|_| ()).expect_err(&text);
        writeln!(problems, "{problem}").expect("text");
    }
    insta::assert_snapshot!(problems);
}

#[test]
fn invalid_rows_of_poses_are_refused_by_line() {
    let labels = "time,body,qw,qx,qy,qz,x,y,z\n";
    let cases = [
        String::new(),
        "time,body,x,y,z\n".to_owned(),
        "time,body,r11,x,y,z\n".to_owned(),
        "time,time,body,qw,qx,qy,qz,x,y,z\n".to_owned(),
        format!("{labels}0,b,1,0,0,0,0,0\n"),
        format!("{labels}0,b,1,0,0,0,0,0,inf\n"),
        format!("{labels}0,b,1,1,0,0,0,0,0\n"),
        format!("{labels}0,b,1,0,0,0,0,0,0\n0,b,1,0,0,0,0,0,0\n"),
        format!("{labels}1,b,1,0,0,0,0,0,0\n0,b,1,0,0,0,0,0,0\n"),
        "time,body,r11,r12,r13,r21,r22,r23,r31,r32,r33,x,y,z\n0,b,1,0,0,0,1,0,0,0,-1,0,0,0\n"
            .to_owned(),
        "time,body,r11,r12,r13,r21,r22,r23,r31,r32,r33,x,y,z\n0,b,1,0,.02,0,1,0,0,0,1,0,0,0\n"
            .to_owned(),
        "time;body;qw;qx;qy;qz;x;y;z\n".to_owned(),
        "time\tbody\tqw\tqx\tqy\tqz\tx\ty\tz\n".to_owned(),
        "time,body,qw,qx,qy,qz,r11,r12,r13,r21,r22,r23,r31,r32,r33,x,y,z\n".to_owned(),
    ];
    let mut problems = String::new();
    for text in cases {
        let problem = pose_rows::parse(&text).map(|_| ()).expect_err(&text);
        writeln!(problems, "{problem}").expect("text");
    }
    insta::assert_snapshot!(problems);
}
