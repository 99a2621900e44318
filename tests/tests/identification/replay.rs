//! Tests of `rist replay` on simulated logs of a UR5 at work: pushes, a load, drift of friction, nothing at all.

use std::path::Path;

use rist::replay::CarriedLoad;
use rist::request::{IdentifyRequest, ReplayRequest};
use rist::{Estimate, KnownLoad, LogSource, Model, Replay};
use tests::joint_log::unlike;
use tests::on_robot::{Carried, Push, Scene};

const FRICTION: [[f64; 3]; 6] =
    [[6.0, 5.0, 0.3], [6.0, 6.0, -0.2], [5.0, 4.0, 0.1], [1.5, 1.2, 0.0], [1.5, 1.0, 0.05], [1.0, 0.8, 0.0]];

fn scene(model: &Model, seed: u64, seconds: f64) -> Scene<'_> {
    let x = model.parameters.values(&unlike(&model.robot, 5));
    let friction = FRICTION.to_vec();
    let (pushes, loads) = (Vec::new(), Vec::new());
    Scene {
        model,
        x,
        friction,
        seed,
        seconds,
        rate: 500.0,
        noise: 0.2,
        speed_noise: 2e-3,
        amplitude: 1.0,
        pushes,
        loads,
    }
}

fn identified(model: &Model) -> (Estimate, LogSource) {
    let log = scene(model, 1, 60.0).source();
    let mut request = IdentifyRequest::default();
    request.samples.covariance = true;
    let found = rist::identify(model, std::slice::from_ref(&log), &request).unwrap();
    (found.estimate, log)
}

fn replayed(model: &Model, (estimate, reference): &(Estimate, LogSource), log: &LogSource) -> Replay {
    let reference = std::slice::from_ref(reference);
    let file = Path::new("e.yaml");
    rist::replay(model, (file, estimate), log, reference, &ReplayRequest::default()).unwrap()
}

fn load(mass: f64, centre_of_mass: [f64; 3]) -> KnownLoad {
    let link = "wrist_3".into();
    KnownLoad {
        link,
        mass,
        centre_of_mass,
        inertia: linear_model::known_load::Inertia { xx: 4e-3, yy: 3e-3, zz: 2e-3, ..Default::default() },
    }
}

#[test]
fn pushes_and_loads_are_found_and_told_apart() {
    let model = Model::read(tests::model_path("ur5.urdf")).unwrap();
    let known = identified(&model);

    // Nothing happens: no contact and no load, and the friction is that of the identification.
    let quiet = replayed(&model, &known, &scene(&model, 2, 60.0).source());
    assert!(quiet.contacts.is_empty() && quiet.loads.is_empty(), "{quiet}");
    assert!(quiet.has_covariance && quiet.held > 0.9, "{}", quiet.held);
    for joint in &quiet.joints {
        assert!(!joint.is_outdated() && joint.drifted().next().is_none(), "{quiet}");
    }

    // A push of 40 N on the forearm, and one of 30 N on the last link.
    let mut pushed = scene(&model, 3, 40.0);
    pushed.pushes.push(Push { link: 2, from: 10.0, to: 10.6, force: [0.0, 30.0, 50.0] });
    pushed.pushes.push(Push { link: 5, from: 25.0, to: 25.4, force: [20.0, 20.0, 0.0] });
    let (log, largest) = pushed.log();
    let found = replayed(&model, &known, &LogSource::Held(log));
    assert!(found.loads.is_empty() && found.contacts.len() == 2, "{found}");
    for ((contact, push), (torque, joint)) in found.contacts.iter().zip(&pushed.pushes).zip(largest) {
        // A first-order observer of 50 1/s shows two thirds of a torque after 20 ms; a contact ends after the hold time of 0.1 s.
        assert!((0.0..0.05).contains(&(contact.start - push.from)), "{found}");
        assert!((0.0..0.25).contains(&(contact.end - push.to)), "{found}");
        assert!(contact.last_joint <= push.link && contact.last_joint + 1 >= joint, "{found} {joint}");
        if contact.joint == joint {
            // The torque of a constant force changes with the posture, and the observer is late by 20 ms.
            assert!((contact.torque.abs() / torque - 1.0).abs() < 0.15, "{found} {torque}");
        }
    }

    // A load of 2 kg from 10 s to 30 s.
    let mut loaded = scene(&model, 4, 40.0);
    let tool = load(2.0, [0.02, -0.03, 0.08]);
    loaded.loads.push(Carried { from: 10.0, to: 30.0, load: tool.clone() });
    let found = replayed(&model, &known, &loaded.source());
    assert!(found.contacts.is_empty(), "{found}");
    let [picked, put]: &[CarriedLoad; 2] = found.loads.as_slice().try_into().unwrap_or_else(|_| panic!("{found}"));
    assert!((picked.start - 10.0).abs() < 0.1 && (put.start - 30.0).abs() < 0.1, "{found}");
    let (mass, sigma) = picked.mass();
    // One draw: four standard deviations are allowed, and the sigma is that of a load worth knowing.
    assert!((mass - tool.mass).abs() < 4.0 * sigma && sigma < 0.06, "{found}");
    assert!(picked.is_held() && !put.is_held(), "{found}");
    for (found, truth) in picked.centre().iter().zip(tool.centre_of_mass) {
        assert!(found.is_none_or(|found| (found - truth).abs() < 0.01), "{picked:?}");
    }

    // Coulomb friction of the second joint grows by a third.
    let mut worn = scene(&model, 6, 60.0);
    worn.friction[1][1] += 2.0;
    let found = replayed(&model, &known, &worn.source());
    let drift = &found.joints[1];
    assert!(drift.drifted().any(|k| k == 1), "{found}");
    assert!((drift.drift[1] - 2.0).abs() < 4.0 * drift.drift_sigma[1].max(0.1), "{found}");
}

#[test]
fn the_program_replays_and_refuses() {
    let here = tests::program::folder("replay");
    let ur5 = tests::model_path("ur5.urdf").display().to_string();
    tests::program::rist(&here, &["example", "."]).ended(0);
    tests::program::rist(&here, &["identify", &ur5, "log.csv", "--covariance", "--out", "e.yaml"]).ended(0);
    let run = tests::program::rist(&here, &["replay", &ur5, "e.yaml", "other.csv", "--series", "s.csv"]).ended(0);
    assert!(run.out.contains("\ncontact: none\n") && run.out.contains("\nload on wrist_3: none\n"), "{}", run.out);
    let series = std::fs::read_to_string(here.join("s.csv")).unwrap();
    assert!(series.starts_with("t,tau_ext_shoulder_pan,band_shoulder_pan,"), "{}", &series[..80]);
    assert!(series.lines().skip(1).all(|line| line.split(',').count() == 15 && !line.contains("NaN")));

    std::fs::rename(here.join("log.csv"), here.join("gone.csv")).unwrap();
    let refused = tests::program::rist(&here, &["replay", &ur5, "e.yaml", "other.csv"]).ended(2);
    assert!(refused.err.contains("log.csv") && refused.err.contains("--reference"), "{}", refused.err);
    tests::program::rist(&here, &["replay", &ur5, "e.yaml", "other.csv", "--reference", "gone.csv"]).ended(0);
    let other = tests::model_path("rx90.yaml").display().to_string();
    let refused =
        tests::program::rist(&here, &["replay", &other, "e.yaml", "other.csv", "--reference", "gone.csv"]).ended(2);
    assert!(refused.err.contains("made with `ur5"), "{}", refused.err);
}
