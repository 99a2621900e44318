//! All shipped models can be read, their loops close, and they cite their source.

use std::path::{Path, PathBuf};

use robot::{JointKind, Robot, RotorInertia, StandardParameter, format};

fn models() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../../models")
}

fn model(name: &str) -> Robot {
    format::read(&models().join(name)).unwrap_or_else(|e| panic!("{e}"))
}

#[test]
fn every_model_is_read_and_cites_its_source() {
    let mut files: Vec<PathBuf> = std::fs::read_dir(models()).unwrap().map(|f| f.unwrap().path()).collect();
    files.sort();
    assert!(files.len() >= 12);
    for file in files {
        let robot = format::read(&file).unwrap_or_else(|e| panic!("{e}"));
        // If a robot has files in two formats, the name of the second robot ends with the format.
        let stem = file.file_stem().and_then(|s| s.to_str()).unwrap();
        let extension = file.extension().and_then(|s| s.to_str()).unwrap();
        assert!(robot.name == stem || robot.name == format!("{stem}_{extension}"), "{}", robot.name);
        assert!(robot.n_coordinates() > 0);
        if file.extension().is_some_and(|e| e == "yaml") {
            assert!(robot.source.is_some(), "{}", robot.name);
        }
        // For a .par file, notes tell which relations of passive joints and which type of linkage the reader found.
        let is_of_loops = |text: &str| text.contains("by the loops") || text.contains("taken for the parallelogram");
        let told = robot.notes.iter().all(|n| extension == "par" && is_of_loops(&n.text));
        assert!(told, "{}: {:?}", robot.name, robot.notes);
    }
}

#[test]
fn race_is_what_its_file_says() {
    let race = model("race.yaml");
    let names: Vec<&str> = race.coordinates.iter().map(|c| c.name.as_str()).collect();
    assert_eq!(names, ["q1", "q2", "q3"]);
    assert_eq!((race.links.len(), race.loops.len()), (10, 3));
    let movers: Vec<usize> = (0..3).map(|k| race.joint_of(robot::CoordinateId(k)).unwrap().0 + 1).collect();
    assert_eq!(movers, [1, 2, 8]);
    let rotors = |j: &usize| race.links[j - 1].joint.rotor_inertia.is_modelled();
    assert_eq!((1..=10).filter(rotors).collect::<Vec<_>>(), [1, 2, 8]);
    assert_eq!(race.links[7].joint.rotor_inertia, RotorInertia::Known(0.0004));
    let q4 = &race.links[3];
    assert_eq!(q4.joint.variable.terms.iter().map(|t| t.1).collect::<Vec<_>>(), [-1.0, 1.0]);
    assert_eq!(q4.geometry.theta.as_multiple_of_pi(&race.symbols), Some((-5, 6)));
    let last = StandardParameter::all(&race).pop().unwrap().display(&race).to_string();
    assert_eq!(last, "M10");
    let known: Vec<f64> = StandardParameter::all(&race).into_iter().filter_map(|p| p.value(&race)).collect();
    assert_eq!((known.len(), known[9], known[10]), (103, 12.0, 0.02));
}

#[test]
fn panda_measures_behind_its_gears() {
    let panda = model("panda.yaml");
    assert!(panda.links.iter().all(|l| l.joint.rotor_inertia == RotorInertia::Absent));
    assert_eq!(panda.coordinates[3].limits.position, Some((-3.0718, -0.0698)));
    // Expected height of the flange above the base with the arm straight up, from the data sheet: .333 + .316 + .384 - .107 m.
    let flange = panda.link_poses(&[0.0; 7])[6].position;
    assert!((flange[0] - 0.088).abs() < 1e-12 && (flange[2] - (0.333 + 0.316 + 0.384)).abs() < 1e-12, "{flange:?}");
}

#[test]
fn degrees_become_radians_and_offsets_join_the_geometry() {
    let tx40 = model("tx40.yaml");
    let limits = tx40.coordinates[4].limits;
    assert!((limits.position.unwrap().1 - 133.5f64.to_radians()).abs() < 1e-15);
    assert_eq!(tx40.links[1].geometry.theta.as_multiple_of_pi(&[]), Some((-1, 2)));
    assert_eq!(model("stanford.yaml").links[2].joint.kind, JointKind::Prismatic);
}

/// Both UR5 files describe the same motion: the pose of each link's frame in one file relative to the frame in the other is
/// constant.
#[test]
fn the_two_ur5_move_alike() {
    let (yaml, urdf) = (model("ur5.yaml"), model("ur5.urdf"));
    let between = |q: &[f64]| -> Vec<robot::Pose> {
        let pairs = yaml.link_poses(q).into_iter().zip(urdf.link_poses(q)).zip(&urdf.links);
        pairs.map(|((a, b), link)| a.inverse().compose(&b.compose(&link.file_frame))).collect()
    };
    for (pose, j) in between(&[0.3, -1.1, 0.7, 2.0, -0.4, 1.3]).iter().zip(0..) {
        for i in 0..3 {
            assert!(pose.position[i].abs() < 1e-14, "{j}: {pose:?}");
            assert!((pose.rotation[i][i] - 1.0).abs() < 1e-14, "{j}: {pose:?}");
        }
    }
    for (a, b) in yaml.links.iter().zip(&urdf.links) {
        let x = robot::transform_inertial(&b.inertial.unwrap(), &b.file_frame.inverse());
        for (x, y) in x.iter().zip(a.inertial.unwrap()) {
            assert!((x - y).abs() < 1e-12, "{} {x} {y}", a.label);
        }
    }
}
