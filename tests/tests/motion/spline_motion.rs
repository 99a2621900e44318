//! Tests of a motion that is a quintic spline with a limit on drive power: search, proof, comparison with dense samples,
//! playing, simulation, and refusal of changed files.

use experiments::excitation::artefact::ExcitingMotion;
use experiments::excitation::limits::LimitKind;
use experiments::excitation::motion::Motion;
use experiments::excitation::proof::LimitProof;
use experiments::simulate::dynamics::torque;
use rist::Model;
use robot::value::CoordinateId;
use std::path::Path;
use tests::dense_samples::violations;
use tests::program::{self, folder, rist as run};
use tests::workspace;

/// Power limit, W, and the share of it that a motion may use.
const POWER: f64 = 60.0;
const SHARE: f64 = 0.9;

/// For each coordinate: [torque without dry friction, power with dry friction], N m (N), W. Computed from the nominal parameters.
fn drives(model: &Model, parameters: &[f64], state: &[[f64; 4]]) -> Vec<[f64; 2]> {
    let of = |d: usize| -> Vec<f64> { state.iter().map(|x| x[d]).collect() };
    let dq = of(1);
    let rigid = torque(model.regressor(), parameters, &of(0), &dq, &of(2));
    let one = |(k, tau): (usize, f64)| {
        let friction = model.robot.link(model.robot.joint_of(CoordinateId(k)).unwrap()).joint.friction;
        let tau = tau + friction.viscous.unwrap_or(0.0) * dq[k] + friction.offset.unwrap_or(0.0);
        [tau, tau * dq[k] + friction.coulomb.unwrap_or(0.0) * dq[k].abs()]
    };
    rigid.into_iter().enumerate().map(one).collect()
}

/// Checks the kinematic limits, torques and powers of a motion during one period, at a hundred times the rate of its file.
fn hold_samples(model: &Model, artefact: &ExcitingMotion, motion: &Motion) {
    assert_eq!(violations(artefact, 100.0).0, 0);
    let parameters = model.nominal_parameters().unwrap();
    let count = (motion.shape.period() * motion.rate * 100.0) as usize;
    let mut greatest = 0.0_f64;
    for i in 0..=count {
        let state = motion.at(motion.shape.period() * i as f64 / count as f64);
        for (joint, [tau, power]) in artefact.joints.iter().zip(drives(model, &parameters, &state)) {
            assert!(tau.abs() <= SHARE * joint.limits.effort.unwrap(), "{}: {tau}", joint.coordinate);
            assert!(power.abs() <= SHARE * POWER, "{}: {power}", joint.coordinate);
            greatest = greatest.max(power.abs());
        }
    }
    // The power limit must be active in this motion.
    assert!(greatest > 0.7 * SHARE * POWER, "{greatest}");
}

/// Checks the files for controllers, and that a simulated log of the motion can be identified.
fn hold_played(folder: &Path, urdf: &str) {
    let played = std::fs::read_to_string(folder.join("m.csv")).unwrap();
    assert_eq!(played.lines().count(), 1 + 8 * 200 + 1);
    assert!(std::fs::read_to_string(folder.join("m.script")).unwrap().contains("servoj"));
    assert!(std::fs::read_to_string(folder.join("ros.yaml")).unwrap().contains("time_from_start"));
    run(folder, &["simulate", urdf, "motion.yaml", "--validation", "0", "--out", "logs"]).ended(0);
    let found = run(folder, &["identify", urdf, "logs/motion.csv"]);
    assert!(found.out.contains("ZZR_shoulder_pan"), "{}{}", found.out, found.err);
}

#[test]
fn a_spline_is_found_proven_played_and_refused_where_it_is_broken() {
    let folder = folder("spline_motion");
    let urdf = workspace().join("models/ur5.urdf");
    let urdf = urdf.to_str().unwrap();
    std::fs::write(folder.join("limits.yaml"), format!("all: {{power: {POWER}}}\n")).unwrap();
    let excite =
        ["excite", urdf, "--motion", "spline", "--limits", "limits.yaml", "--period", "4", "--repetitions", "2"];
    let files = ["--play", "m.csv", "--play", "ros.yaml", "--play", "m.script", "--out", "motion.yaml"];
    run(&folder, &[&excite[..], &["--starts", "1", "--iterations", "15"], &files].concat()).told(
        0,
        &["a quintic spline of 9 spans, 2 times 4 s from rest to rest: 8 s at 200 Hz", "power           6 of 6  "],
    );
    let artefact = program::motion(&folder.join("motion.yaml"));
    assert!(
        artefact.proven
            && artefact.blend_s.is_none()
            && artefact.certificate.iter().all(|r| r.kept == LimitProof::Proven)
    );
    let (model, motion) = (Model::read(urdf).unwrap(), artefact.motion("motion.yaml").unwrap());
    hold_samples(&model, &artefact, &motion);

    hold_played(&folder, urdf);

    // The check proves the motion again and does not trust the certificate in the file.
    run(&folder, &["check", urdf, "motion.yaml"]).ended(0);
    let parameters = model.nominal_parameters().unwrap();
    let broken = |limit: LimitKind, joint: usize, change: &dyn Fn(&mut ExcitingMotion)| {
        let mut artefact = artefact.clone();
        change(&mut artefact);
        std::fs::write(folder.join("broken.yaml"), artefact.to_yaml().unwrap()).unwrap();
        let found = run(&folder, &["check", urdf, "broken.yaml"]).ended(1);
        // An example of the message: `power of elbow: 41.2 W at 1.25 s is beyond 36 W by 5.2 W`. The value must be the value of
        // the motion at that time.
        let head = format!("{limit} of {}: ", artefact.joints[joint].coordinate);
        let said = found.err.split("; ").find_map(|fault| fault.split_once(&head)).map(|(_, said)| said);
        let said = said.unwrap_or_else(|| panic!("{head}{}", found.err));
        let first = |text: &str| text.split_whitespace().next().and_then(|x| x.parse::<f64>().ok());
        let behind = |words: &str| first(said.split_once(words)?.1);
        let numbers = [first(said), behind(" at "), behind(" s is beyond "), behind(" by ")];
        let [value, time, bound, by] = numbers.map(|x| x.unwrap_or_else(|| panic!("{said}")));
        let motion = artefact.motion("broken.yaml").unwrap();
        let at = |t: f64| {
            let state = motion.at(t);
            match LimitKind::KINEMATIC.iter().position(|k| *k == limit) {
                Some(d) => state[joint][d],
                None => drives(&model, &parameters, &state)[joint][1],
            }
        };
        // The printed time has four decimals, and the slopes of the quantities are some hundreds per second. The jerk jumps
        // between repetitions, so the time just before is also tried. The printed value has four digits, so its relative rounding
        // error is at most 5e-4.
        let is_near = |t: f64| (at(t) - value).abs() < 0.05 + 5e-4 * value.abs();
        assert!(is_near(time) || is_near(time - 1e-9), "{limit}: {} {said}", at(time));
        // Both printed values have four digits, and their difference has three.
        let rounding = 5e-4 * (value.abs() + bound.abs()) + 5e-3 * by;
        assert!(((value - bound).abs() - by).abs() < rounding && value.abs() > bound.abs(), "{said}");
    };
    broken(LimitKind::Power, 1, &|m| m.joints[1].limits.power = Some(0.5 * POWER));
    broken(LimitKind::Velocity, 4, &|m| m.joints[4].limits.velocity *= 0.5);
    broken(LimitKind::Jerk, 5, &|m| m.joints[5].limits.jerk = 5.0);
    broken(LimitKind::Acceleration, 2, &|m| m.joints[2].control_points[4] += 6.0);
    broken(LimitKind::Position, 0, &|m| m.joints[0].centre += 7.0);
}

/// Three kinds of requests are refused: options of the other kind of motion (Fourier series), unknown coordinates, and limits
/// that need masses which are unknown.
#[test]
fn what_makes_no_spline_is_refused() {
    let folder = folder("spline_refused");
    let urdf = workspace().join("models/ur5.urdf");
    let urdf = urdf.to_str().unwrap();
    std::fs::write(folder.join("power.yaml"), "coordinates: {shoulder: {power: 20}}\n").unwrap();
    let weightless = std::fs::read_to_string(workspace().join("models/planar2r.yaml")).unwrap();
    let (description, _) = weightless.split_once("standard_parameters:").unwrap();
    std::fs::write(folder.join("weightless.yaml"), description).unwrap();
    std::fs::write(folder.join("limits.yaml"), "all: {power: 20}\n").unwrap();
    for (arguments, said) in [
        (vec![urdf, "--motion", "spline", "--blend", "1"], "--blend is of Fourier series"),
        (vec![urdf, "--motion", "spline", "--rate", "5", "--period", "5"], "raise --rate"),
        (vec![urdf, "--limits", "power.yaml"], "there is no coordinate `shoulder`"),
        (vec!["weightless.yaml", "--limits", "limits.yaml"], "the limit of power of q1 needs the torque"),
    ] {
        run(&folder, &[&["excite"][..], &arguments].concat()).failed(2, &[said]);
    }
}
