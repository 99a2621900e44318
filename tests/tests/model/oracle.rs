//! Tests of five URDF robots against Pinocchio: standard parameters, regressor, torque and rank.
//!
//! The tables in ../shared/oracle contain random states q, dq, ddq with the torque, the regressor and, for each moving link, m mx
//! my mz Ixx Ixy Iyy Ixz Iyz Izz about the origin of its joint frame, in that frame. The link frames of rist differ; the linear
//! map of the crate `robot` converts the parameters exactly.

use std::collections::HashMap;
use std::io::Read;
use std::path::Path;

use modeling::Derivation;
use robot::format::{Mimic, ReadOptions};
use robot::{Robot, RotorInertia, inertial_matrix};
use tests::{base_parameters, dot, evaluated, shared};

const ROBOTS: [(&str, usize); 5] =
    [("ur5", 36), ("panda", 51), ("solo12", 68), ("baxter", 103), ("double_pendulum", 6)];

/// Pinocchio's names of the inertial parameters, in the order of rist: XX XY XZ YY YZ ZZ MX MY MZ M.
const NAMES: [&str; 10] = ["Ixx", "Ixy", "Ixz", "Iyy", "Iyz", "Izz", "mx", "my", "mz", "m"];

struct Table {
    places: HashMap<String, usize>,
    joints: Vec<String>,
    rows: Vec<Vec<f64>>,
}

impl Table {
    fn read(path: &Path) -> Table {
        let mut text = String::new();
        let file = std::fs::File::open(path).unwrap_or_else(|e| panic!("{}: {e}", path.display()));
        flate2::read::GzDecoder::new(file).read_to_string(&mut text).unwrap();
        let mut lines = text.lines();
        let head: Vec<&str> = lines.next().unwrap().split(',').collect();
        let rows = lines.map(|line| line.split(',').map(|x| x.parse().unwrap()).collect()).collect();
        Table {
            places: head.iter().enumerate().map(|(k, name)| (name.to_string(), k)).collect(),
            joints: head.iter().filter_map(|h| h.strip_prefix("q_")).map(String::from).collect(),
            rows,
        }
    }

    fn place(&self, column: &str) -> usize {
        *self.places.get(column).unwrap_or_else(|| panic!("no column {column}"))
    }

    fn columns(&self, prefix: &str, names: &[String]) -> Vec<usize> {
        names.iter().map(|name| self.place(&format!("{prefix}_{name}"))).collect()
    }
}

/// For each robot: name, rank of the regressor, robot, and table of Pinocchio. The robots have ten parameters per link and no
/// rotor inertia.
fn cases() -> Vec<(&'static str, usize, Robot, Table)> {
    let Some(folder) = shared().map(|s| s.join("oracle")) else { return Vec::new() };
    // Pinocchio ignores mimic tags, so the two fingers of the panda are coordinates.
    let options = ReadOptions { mimic: Mimic::Independent, ..ReadOptions::default() };
    ROBOTS
        .into_iter()
        .map(|(name, rank)| {
            let path = folder.join(format!("{name}.urdf"));
            let robot = robot::format::read_with(&path, options).unwrap_or_else(|e| panic!("{e}"));
            assert!(robot.links.iter().all(|l| l.joint.rotor_inertia == RotorInertia::Absent), "{name}");
            (name, rank, robot, Table::read(&folder.join(format!("{name}.csv.gz"))))
        })
        .collect()
}

fn coordinates(robot: &Robot) -> Vec<String> {
    robot.coordinates.iter().map(|c| c.name.clone()).collect()
}

#[test]
fn standard_parameters_agree_in_the_joint_frames_of_the_file() {
    for (name, _, robot, table) in cases() {
        assert_eq!(coordinates(&robot), table.joints, "{name}: the order of the joints");
        for link in &robot.links {
            let about_joint = robot::transform_inertial(&link.inertial.unwrap_or_default(), &link.file_frame.inverse());
            for (parameter, value) in NAMES.into_iter().zip(about_joint) {
                let column = format!("X_{}_{parameter}", link.joint.name);
                let expected = table.rows[0][table.place(&column)];
                // rist rounds the angles of fixed joints to nearby special values, by up to 5e-12; Pinocchio does not.
                assert!((value - expected).abs() <= 1e-10, "{name} {column}: {value} {expected}");
            }
        }
    }
}

#[test]
fn regressor_and_torque_agree_through_the_exact_linear_map() {
    for (name, _, robot, table) in cases() {
        let names = coordinates(&robot);
        let regressor = Derivation::new(&robot).unwrap().regressor();
        let (n, p) = (names.len(), 10 * robot.links.len());
        assert_eq!(regressor.outputs.iter().map(|o| o.entries.len()).sum::<usize>(), n * p, "{name}");
        let x: Vec<f64> = robot.links.iter().flat_map(|l| l.inertial.unwrap_or_default()).collect();
        // The parameters of link j in rist are M_j times Pinocchio's parameters in the joint frame. M_j: matrix in `maps`.
        let maps: Vec<_> = robot.links.iter().map(|l| inertial_matrix(&l.file_frame)).collect();
        let inputs: Vec<usize> = ["q", "dq", "ddq"].iter().flat_map(|kind| table.columns(kind, &names)).collect();
        let torques = table.columns("tau", &names);
        assert!(table.rows.len() >= 20, "{name}");
        for row in &table.rows {
            let state: Vec<f64> = inputs.iter().map(|&k| row[k]).collect();
            let y = evaluated(&regressor, &[&state]);
            for (i, y) in y.chunks(p).enumerate() {
                let (tau, size) = dot(y, &x);
                let expected = row[torques[i]];
                assert!((tau - expected).abs() <= 1e-9 * size.max(1e-3), "{name} {}: {tau} {expected}", names[i]);
                let scale = y.iter().fold(0.0f64, |s, y| s.max(y.abs()));
                for (j, link) in robot.links.iter().enumerate() {
                    for (k, parameter) in NAMES.into_iter().enumerate() {
                        let found: f64 = (0..10).map(|r| y[10 * j + r] * maps[j][r][k]).sum();
                        let column = format!("Y_{}_{}_{parameter}", names[i], link.joint.name);
                        let expected = row[table.place(&column)];
                        assert!((found - expected).abs() <= 1e-9 * scale, "{name} {column}: {found} {expected}");
                    }
                }
            }
        }
    }
}

#[test]
fn ranks_are_those_of_the_robots() {
    for (name, rank, robot, _) in cases() {
        assert_eq!(base_parameters(&robot).len(), rank, "{name}");
    }
}
