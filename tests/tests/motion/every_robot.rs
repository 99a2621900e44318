//! Tests that `rist excite` finds a motion for each of twenty robots, or refuses with the reason. Pinocchio and coal check each
//! motion.
//!
//! The robots are in [`tests::bodied_robots`]. `RIST_PYTHON` names a Python with coal, Pinocchio and numpy; the default is
//! `python3`. Without it the test prints a note. By default every third robot is tested, at 300 instants. `ROBOTS=all
//! INSTANTS=3000` tests all robots at more instants.

use std::process::Command;

use experiments::excitation::artefact::ExcitingMotion;
use experiments::excitation::limits::LimitKind;
use rist::Model;
use rist::request::ExciteRequest;
use serde_json::Value;
use tests::bodied_robots::bodied_robots;
use tests::program::folder;
use tests::workspace;

/// The Python interpreter that has the required modules. If there is none, prints a note and returns `None`.
fn python() -> Option<String> {
    let python = std::env::var("RIST_PYTHON").unwrap_or("python3".into());
    let imports = ["-c", "import coal, numpy, pinocchio"];
    let is_there = Command::new(&python).args(imports).output().is_ok_and(|o| o.status.success());
    if !is_there {
        println!("NOT looked at by coal and Pinocchio: {python} does not have them (RIST_PYTHON names another)");
    }
    is_there.then_some(python)
}

#[test]
fn robots_get_a_motion() {
    let here = folder("every_robot");
    let robots = bodied_robots();
    assert!(robots.len() == 20 && robots.iter().filter(|robot| !robot.is_arm).count() >= 6);
    let every = if std::env::var("ROBOTS").as_deref() == Ok("all") { 1 } else { 3 };
    let robots: Vec<_> = robots.iter().step_by(every).collect();
    let mut files = Vec::new();
    let mut refused = Vec::new();
    for robot in &robots {
        let path = here.join(robot.name).with_extension("urdf");
        std::fs::write(&path, robot.urdf()).unwrap();
        let model = Model::parse(&robot.urdf(), &path, &Default::default()).unwrap();
        let request = ExciteRequest { starts: 1, iterations: 5, repetitions: 1, ..ExciteRequest::default() };
        match rist::excite(&model, &request, &|_, _, _| ()) {
            Ok(motion) => {
                assert!(motion.proven, "{}: {:?}", robot.name, motion.claims().faults());
                held(robot.name, &motion);
                let file = path.with_extension("json");
                std::fs::write(&file, serde_json::to_string(&motion).unwrap()).unwrap();
                files.extend([path, file]);
            }
            Err(error) => {
                let said = error.to_string();
                assert!(said.contains(" m") && said.contains("distance"), "{}: {said}", robot.name);
                refused.push(said);
            }
        }
    }
    // At most two of twenty robots may be refused, or the same share of the tested ones.
    assert!(20 * refused.len() <= 2 * robots.len(), "{}", refused.join("\n"));
    let Some(python) = python() else { return };
    let instants = std::env::var("INSTANTS").unwrap_or("300".into());
    let script = workspace().join("tests/data/oracle/motion_by_coal.py");
    let run = Command::new(python).arg(script).arg(instants).args(&files).output().unwrap();
    let (out, err) = (String::from_utf8_lossy(&run.stdout), String::from_utf8_lossy(&run.stderr));
    assert!(run.status.success(), "{err}");
    let mut pairs = 0;
    for line in out.lines() {
        let found: Value = serde_json::from_str(line).unwrap();
        for what in ["contacts", "below_bound", "limits", "torques", "below_floor"] {
            assert_eq!(found[what], 0, "{line}");
        }
        pairs += found["pairs"].as_u64().unwrap();
    }
    assert!(2 * out.lines().count() == files.len(), "{err}");
    // Enough pairs of links must be compared; otherwise the distances would prove nothing.
    assert!(20 * pairs > 150 * robots.len() as u64, "{pairs}");
}

/// Checks that the certificate has a row for the torque of every joint, and at least one row for a distance or a region of
/// bodies.
fn held(name: &str, motion: &ExcitingMotion) {
    let count = |kind: LimitKind| motion.certificate.iter().filter(|row| row.limit == kind).count();
    assert!(count(LimitKind::Effort) == motion.joints.len(), "{name}");
    assert!(count(LimitKind::Distance) + count(LimitKind::Region) > 0, "{name}");
}
