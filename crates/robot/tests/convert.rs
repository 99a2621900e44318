//! Converts every model to YAML and URDF and back. Motion and parameters must be unchanged, or a note must state the change.

use std::path::Path;

use robot::{Robot, format};

fn models() -> Vec<Robot> {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let mut files: Vec<_> = ["../../models", "testdata/par"]
        .iter()
        .flat_map(|folder| std::fs::read_dir(root.join(folder)).unwrap())
        .map(|f| f.unwrap().path())
        .filter(|p| p.extension().is_some_and(|e| e == "yaml" || e == "urdf" || e == "par"))
        .collect();
    files.sort();
    assert!(files.len() > 15);
    files.iter().map(|f| format::read(f).unwrap_or_else(|e| panic!("{e}"))).collect()
}

fn close(a: f64, b: f64, tolerance: f64, what: &str) {
    assert!((a - b).abs() <= tolerance * a.abs().max(1.0), "{what}: {a} {b}");
}

fn same_motion(a: &Robot, b: &Robot, tolerance: f64) {
    let q: Vec<f64> = (0..a.n_variables()).map(|k| 0.3 + 0.7 * k as f64).collect();
    for (x, (y, link)) in a.link_poses(&q).iter().zip(b.link_poses(&q).iter().zip(&b.links)) {
        let y = y.compose(&link.file_frame);
        for i in 0..3 {
            close(x.position[i], y.position[i], tolerance, &a.name);
            (0..3).for_each(|j| close(x.rotation[i][j], y.rotation[i][j], tolerance, &a.name));
        }
    }
}

#[test]
fn yaml_carries_every_robot() {
    for robot in models() {
        let (text, _) = format::write_yaml(&robot);
        let back = format::read_yaml(&text, "back.yaml").unwrap_or_else(|e| panic!("{}: {e}\n{text}", robot.name));
        assert_eq!((back.name.as_str(), &back.source), (robot.name.as_str(), &robot.source));
        let mut plain = back.clone();
        plain.links.iter_mut().for_each(|l| l.file_frame = robot::Pose::IDENTITY);
        same_motion(&robot, &plain, 1e-14);
        assert_eq!(robot.gravity_number(), back.gravity_number());
        for (a, b) in robot.links.iter().zip(&back.links) {
            assert_eq!((a.inertial, a.joint.rotor_inertia), (b.inertial, b.joint.rotor_inertia), "{}", robot.name);
            assert_eq!((a.joint.kind, a.joint.drive), (b.joint.kind, b.joint.drive));
            assert_eq!((a.joint.friction, a.joint.drive_gain), (b.joint.friction, b.joint.drive_gain));
        }
        let limits = |r: &Robot| r.coordinates.iter().map(|c| c.limits).collect::<Vec<_>>();
        assert_eq!(limits(&robot), limits(&back));
        // The written text gives a generic symbol (one without a value in the file) its substitute value, so it is no longer
        // generic after reading.
        let generic = "   # generic: the description gave no value";
        assert_eq!(format::write_yaml(&back).0, text.replace(generic, ""));
    }
}

/// A URDF describes a tree by numbers. An open chain that is written as a URDF and read again has the same motion up to rounding,
/// and its `file_frame`s coincide with the frames that were written.
#[test]
fn urdf_carries_open_chains() {
    for robot in models() {
        let (text, notes) = format::write_urdf(&robot);
        let told = |subject: &str| notes.iter().any(|n| n.subject == subject);
        assert_eq!(told("loop 1"), !robot.loops.is_empty(), "{}", robot.name);
        assert_eq!(told("gravity"), robot.gravity_number() != [0.0, 0.0, -9.81]);
        let back = format::read_urdf(&text, "back.urdf").unwrap_or_else(|e| panic!("{}: {e}\n{text}", robot.name));
        if !robot.loops.is_empty() || robot.links.iter().any(|l| l.joint.drive == robot::Drive::Locked) {
            continue;
        }
        // The URDF reader puts joints in the order of the tree, and sorts them by name. So the coordinates must be matched by
        // name.
        let find = |name: &str| back.coordinates.iter().position(|c| c.name == name).unwrap();
        let order: Vec<usize> = robot.coordinates.iter().map(|c| find(&c.name)).collect();
        let q: Vec<f64> = (0..robot.n_coordinates()).map(|k| 0.3 + 0.7 * k as f64).collect();
        let mut turned = vec![0.0; q.len()];
        order.iter().zip(&q).for_each(|(&k, &q)| turned[k] = q);
        let (poses, theirs) = (robot.link_poses(&q), back.link_poses(&turned));
        for (pose, link) in poses.iter().zip(&robot.links) {
            let j = back.links.iter().position(|l| l.name == link.name).unwrap();
            let written = theirs[j].compose(&back.links[j].file_frame);
            for i in 0..3 {
                close(pose.position[i], written.position[i], 1e-12, &robot.name);
                (0..3).for_each(|k| close(pose.rotation[i][k], written.rotation[i][k], 1e-12, &robot.name));
            }
            let x = back.links[j].inertial.map(|x| robot::transform_inertial(&x, &back.links[j].file_frame.inverse()));
            for (a, b) in link.inertial.iter().flatten().zip(x.iter().flatten()) {
                close(*a, *b, 1e-13, &link.name);
            }
        }
    }
}
