//! Tests that conversion between file formats and conventions does not change the torques.

use foreign::write_par;
use modeling::Derivation;
use robot::convention::Convention;
use robot::format::{read_par, read_urdf, read_yaml, write_urdf, write_yaml};
use robot::{Note, Robot, RotorInertia, StandardParameter};
use tests::{evaluated, model};

/// Physical parameters of link j: a general body without symmetry, so that an exchange of entries is detected.
fn body(j: usize) -> [f64; 10] {
    let scale = 1.0 + 0.3 * j as f64;
    let (m, c) = (2.0 * scale, [0.05, -0.02 * scale, 0.03]);
    let [x, y, z] = c;
    let own = [0.02, 0.001, -0.002, 0.03, 0.0015, 0.025].map(|i| i * scale);
    let carried = [y * y + z * z, -x * y, -x * z, x * x + z * z, -y * z, x * x + y * y];
    let inertia: [f64; 6] = std::array::from_fn(|i| own[i] + m * carried[i]);
    let [xx, xy, xz, yy, yz, zz] = inertia;
    [xx, xy, xz, yy, yz, zz, m * x, m * y, m * z, m]
}

/// The model with all inertial parameters known and without rotor inertias, because a URDF cannot contain rotor inertias.
fn known(file: &str) -> Robot {
    let mut robot = model(file);
    for (j, link) in robot.links.iter_mut().enumerate() {
        link.inertial = Some(body(j));
        link.joint.rotor_inertia = RotorInertia::Absent;
    }
    robot
}

fn torques(robot: &Robot) -> Vec<f64> {
    let mut derivation = Derivation::new(robot).unwrap();
    let torque = derivation.torque();
    let x: Vec<f64> = StandardParameter::all(robot).into_iter().map(|p| p.value(robot).unwrap()).collect();
    let n = robot.n_coordinates();
    let at = |s: usize| {
        let state: Vec<f64> = (0..3 * n).map(|i| (0.7 * i as f64 + 1.3 * s as f64).sin() * 1.5).collect();
        evaluated(&torque, &[&state, &x])
    };
    (0..4).flat_map(at).collect()
}

#[track_caller]
fn agree(what: &str, a: &[f64], b: &[f64], tolerance: f64) {
    assert_eq!(a.len(), b.len(), "{what}");
    let scale = a.iter().fold(1.0, |s: f64, x| s.max(x.abs()));
    for (a, b) in a.iter().zip(b) {
        assert!((a - b).abs() <= tolerance * scale, "{what}: {a} and {b}");
    }
}

#[test]
fn a_robot_has_the_same_torques_in_every_format() {
    for file in ["rx90.yaml", "puma560.yaml", "stanford.yaml", "ur5.yaml", "scara.yaml", "tx40.yaml", "race.yaml"] {
        let robot = known(file);
        let reference = torques(&robot);
        // The written decimals restore every number exactly, so only the rounding of the torque itself differs.
        let yaml = read_yaml(&write_yaml(&robot).0, "written.yaml").unwrap_or_else(|e| panic!("{file}: {e}"));
        agree(&format!("{file} through YAML"), &reference, &torques(&yaml), 1e-13);
        let par = read_par(&write_par(&robot).0, "written.par").unwrap_or_else(|e| panic!("{file}: {e}"));
        agree(&format!("{file} through .par"), &reference, &torques(&par), 1e-13);
        if robot.loops.is_empty() {
            // A URDF has other link frames, and inertias about the centre of mass. The conversion adds some rounding.
            let urdf = read_urdf(&write_urdf(&robot).0, "written.urdf").unwrap_or_else(|e| panic!("{file}: {e}"));
            agree(&format!("{file} through URDF"), &reference, &torques(&urdf), 1e-11);
        }
    }
}

#[test]
fn any_name_of_a_robot_reads_back_from_yaml_and_some_name_from_every_format() {
    let mut robot = model("planar2r.yaml");
    let long = format!("parallelogram{}4bar", "\0".repeat(8));
    let names =
        [&long, "a\nb: c", " edge ", "\u{1b}[2J", "\u{85}\u{2028}\u{feff}", "tab\there", "\"\\'", "# no", "007", "*)"];
    for name in names {
        robot.name = name.to_string();
        let written = write_yaml(&robot).0;
        let yaml = read_yaml(&written, "written.yaml").unwrap_or_else(|e| panic!("{name:?}: {e}\n{written}"));
        assert_eq!(yaml.name, name);
        assert_eq!(write_yaml(&yaml).0, written, "{name:?}");
        // Files in the formats .par and URDF cannot contain some characters. Either the name is read back exactly, or a note
        // reports the change.
        let (par, urdf) = (write_par(&robot), write_urdf(&robot));
        let told = |notes: &[Note]| notes.iter().any(|n| n.subject == "name");
        let read = read_par(&par.0, "written.par").unwrap_or_else(|e| panic!("{name:?}: {e}"));
        assert_eq!(read.name == name, !told(&par.1), "{name:?} through .par");
        let read = read_urdf(&urdf.0, "written.urdf").unwrap_or_else(|e| panic!("{name:?}: {e}"));
        assert_eq!(read.name == name, !told(&urdf.1), "{name:?} through URDF");
    }
}

/// Negative zero occurs in files (lower="-0") and as a sum of transformed parameters. It is written as 0, so that a second
/// conversion gives the same text.
#[test]
fn a_zero_with_a_sign_is_written_as_it_reads_back() {
    let mut robot = model("planar2r.yaml");
    robot.links[0].inertial = Some([-0.0; 10]);
    robot.links[0].joint.friction.offset = Some(-0.0);
    robot.coordinates[0].limits.position = Some((-0.0, 1.0));
    robot.gravity[0] = robot::Value::Number(-0.0);
    let written = write_yaml(&robot).0;
    assert_eq!(write_yaml(&read_yaml(&written, "written.yaml").unwrap()).0, written);
    assert!(!written.contains("-0,") && !written.contains("-0]") && !written.contains("-0}"), "{written}");
}

#[test]
fn parameters_through_every_convention_make_the_same_torques() {
    for file in ["rx90.yaml", "puma560.yaml", "stanford.yaml", "ur5.yaml", "tree.yaml"] {
        let robot = known(file);
        let reference = torques(&robot);
        for convention in Convention::ALL {
            let mut carried = robot.clone();
            for link in &mut carried.links {
                let x = link.inertial.unwrap();
                let named = convention.write(&x).unwrap();
                let value = |name: &str| named.values.iter().find(|(n, _)| *n == name).map(|v| v.1);
                link.inertial = Some(convention.read(value).unwrap());
            }
            agree(&format!("{file} as {}", convention.name()), &reference, &torques(&carried), 1e-13);
        }
    }
}
