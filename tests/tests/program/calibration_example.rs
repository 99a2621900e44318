//! The simulated calibration that is shipped: docs/ur5/poses.csv and the picture of its errors, docs/ur5/errors.svg, are made
//! again and compared. `SNAPSHOTS=write` writes both.

use calibration::{
    CalibrateRequest, Chain, Convention, MeasurementKind, Parameter, Placed, Posture, Problem, Unknowns,
};
use calibration::{ParameterGroup, calibrate};
use nalgebra::{Rotation3, UnitQuaternion, Vector3};
use random::Random;
use rist::{ModelOptions, Robot};
use tests::program::{folder, rist};
use tests::workspace;

/// Number of postures.
const POSTURES: usize = 40;
/// Standard deviation of the errors of the geometry, m and rad, and of the zeros, rad.
const GEOMETRY: f64 = 5e-4;
const ZEROS: f64 = 0.02;
/// Standard deviation of the noise of the tracker, m and rad.
const NOISE: f64 = 1e-4;

fn ur5() -> Robot {
    rist::read_robot(&workspace().join("models/ur5.urdf"), &ModelOptions::default()).unwrap()
}

/// The table of a tracker that measures whole poses of a UR5 with errors of its zeros and of its geometry.
fn poses(robot: &Robot) -> String {
    let tip = robot.link_ids().last().unwrap();
    let chain = Chain::new(robot, tip, Convention::Frames).unwrap();
    let mut random = Random::new(20);
    let deviation = |parameter: &Parameter| match parameter.group() {
        ParameterGroup::Zeros => ZEROS,
        ParameterGroup::Geometry if !matches!(parameter, Parameter::Gear { .. }) => GEOMETRY,
        _ => 0.0,
    };
    let values: Vec<f64> = chain.parameters.iter().map(|p| deviation(p) * random.normal()).collect();
    let names: Vec<&str> = chain.coordinates.iter().map(|k| robot.coordinates[*k].name.as_str()).collect();
    let mut text = names.join(",") + ",x [mm],y [mm],z [mm],qx,qy,qz,qw\n";
    let n = names.len();
    let problem = Problem::new(chain, MeasurementKind::Pose, vec![]);
    let rotation = Rotation3::new(Vector3::new(0.1, -0.2, 2.3)).into_inner();
    let base = Placed { rotation, position: Vector3::new(1.9, -0.4, 0.6) };
    let truth = Unknowns { base, points: vec![Vector3::new(0.0, 0.05, 0.12)], chain: values, ..problem.nominal() };
    for _ in 0..POSTURES {
        // A tenth of a millirad is written, so it is also what the robot does.
        let q: Vec<f64> = (0..n).map(|_| (1e4 * random.between(-2.5, 2.5)).round() * 1e-4).collect();
        let posture = Posture { line: 0, torque: vec![0.0; n], q, points: vec![], rotation: None, distance: None };
        let pose = truth.base.then(&problem.chain.pose(&posture.q, &posture.torque, &truth.chain));
        let mut noise = || Vector3::from_fn(|_, _| NOISE * random.normal());
        let point = 1e3 * (pose.at(&truth.points[0]) + noise());
        let turn = UnitQuaternion::from_matrix(&(Rotation3::new(noise()).into_inner() * pose.rotation));
        let cells = posture.q.iter().map(|x| format!("{x:.4}")).chain(point.iter().map(|x| format!("{x:.3}")));
        let turn = [turn.i, turn.j, turn.k, turn.w].map(|x| format!("{x:.6}"));
        text += &(cells.chain(turn).collect::<Vec<_>>().join(",") + "\n");
    }
    text
}

/// Compares a text with a shipped file, or writes the file.
fn shipped(file: &str, text: &str) {
    let path = workspace().join(file);
    if std::env::var_os("SNAPSHOTS").is_some_and(|word| word == "write") {
        std::fs::write(&path, text).unwrap();
    }
    assert!(std::fs::read_to_string(&path).unwrap_or_default() == text, "{file}: SNAPSHOTS=write writes it anew");
}

#[test]
fn the_shipped_calibration_is_made_again() {
    let robot = ur5();
    shipped("docs/ur5/poses.csv", &poses(&robot));
    let found = calibrate(&robot, &workspace().join("docs/ur5/poses.csv"), &CalibrateRequest::default(), None).unwrap();
    shipped("docs/ur5/errors.svg", &found.picture(&robot).unwrap());
}

/// The page has the errors before and after, as arrows and by posture. For distances it has no arrows.
#[test]
fn the_page_shows_the_errors_before_and_after() {
    let here = folder("calibration_page");
    let of = |file: &str| workspace().join(file).display().to_string();
    let (model, table) = (of("models/ur5.urdf"), of("docs/ur5/poses.csv"));
    let run = ["calibrate", &model, &table, "--report", "page.html", "--date", "today"];
    rist(&here, &run).told(0, &["trust: yes"]);
    let page = std::fs::read_to_string(here.join("page.html")).unwrap();
    for part in ["Trust it", "Errors on the robot", "From the side (x, z)", "Errors of orientations", "<dd>today</dd>"]
    {
        assert!(page.contains(part), "{part}: {page}");
    }
    // Two views with the robot and two sets of arrows; two charts of dots.
    assert_eq!(
        (page.matches("<path class=\"line").count() / 2, page.matches("role=\"img\"").count()),
        (6, 4),
        "{page}"
    );

    // Distances have no direction, so there are no arrows.
    let text = std::fs::read_to_string(&table).unwrap();
    let mut lines = text.lines();
    let mut distances = lines.next().unwrap().split(",x [mm]").next().unwrap().to_string() + ",distance\n";
    for line in lines {
        let cells: Vec<&str> = line.split(',').collect();
        let place: Vec<f64> = cells[6..9].iter().map(|x| 1e-3 * x.parse::<f64>().unwrap()).collect();
        let length = place.iter().map(|x| x * x).sum::<f64>().sqrt();
        distances += &format!("{},{length}\n", cells[..6].join(","));
    }
    std::fs::write(here.join("distances.csv"), distances).unwrap();
    rist(&here, &["calibrate", &model, "distances.csv", "--what", "zeros", "--report", "d.html"]);
    let page = std::fs::read_to_string(here.join("d.html")).unwrap();
    assert!(!page.contains("Errors on the robot") && page.contains("Errors of positions"), "{page}");
}
