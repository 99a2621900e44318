//! Tests of contact during a log: `doctor`, `identify` and `validate` report it with its times. On request, its rows are left
//! out of the fit.

use std::path::Path;

use rist::fit::doctor::claims_of_log;
use rist::request::{IdentifyRequest, ReplayRequest};
use rist::{Estimate, Identification, LogSource, Model};
use tests::joint_log::unlike;
use tests::on_robot::{Push, Scene};

const FRICTION: [[f64; 3]; 6] =
    [[6.0, 5.0, 0.3], [6.0, 6.0, -0.2], [5.0, 4.0, 0.1], [1.5, 1.2, 0.0], [1.5, 1.0, 0.05], [1.0, 0.8, 0.0]];
/// Words that every sentence on a contact contains.
const NAMED: &str = "contact, or another load";
/// The remedy that is printed with a contact: the option that leaves these rows out.
const LEFT_OUT: &str = "[leave_out_contact]";

fn scene(model: &Model, seed: u64, pushes: Vec<Push>) -> Scene<'_> {
    Scene {
        model,
        x: model.parameters.values(&unlike(&model.robot, 5)),
        friction: FRICTION.to_vec(),
        seed,
        seconds: 40.0,
        rate: 250.0,
        noise: 0.2,
        speed_noise: 2e-3,
        amplitude: 1.0,
        pushes,
        loads: Vec::new(),
    }
}

fn identified(model: &Model, log: &LogSource, leave_out_contact: bool) -> Identification {
    let mut request = IdentifyRequest::default();
    (request.samples.covariance, request.samples.leave_out_contact) = (true, leave_out_contact);
    rist::identify(model, std::slice::from_ref(log), &request).unwrap()
}

/// The sentences of `doctor` on contact in a log.
fn examined(model: &Model, log: &LogSource) -> Vec<String> {
    let check = rist::examine(model, std::slice::from_ref(log), &Default::default()).unwrap();
    claims_of_log(&check, &[]).iter().map(ToString::to_string).filter(|claim| claim.contains(NAMED)).collect()
}

fn validated(model: &Model, estimate: &Estimate, log: &LogSource) -> (f64, String) {
    let logs = std::slice::from_ref(log);
    let total = rist::validate(model, estimate, logs).unwrap().total;
    let verdict = rist::fit::verdict::validation_verdict(model, estimate, logs, total, true).unwrap();
    (total, verdict.to_string().split_whitespace().collect::<Vec<_>>().join(" "))
}

#[test]
fn contact_is_named_and_left_out() {
    let model = Model::read(tests::model_path("ur5.urdf")).unwrap();
    let quiet = scene(&model, 31, Vec::new()).source();
    let pushes = [(10.0, 11.0, 2, [0.0, 60.0, 90.0]), (25.0, 25.8, 5, [60.0, 60.0, 0.0])];
    let push = |(from, to, link, force)| Push { link, from, to, force, largest: None };
    let (mut log, _) = scene(&model, 32, pushes.map(push).to_vec()).log();
    log.name = "pushed.csv".into();
    let pushed = LogSource::Held(log);

    // Without contact, no contact is reported and no rows are left out.
    for seed in 34..40 {
        assert_eq!(examined(&model, &scene(&model, seed, Vec::new()).source()), Vec::<String>::new(), "{seed}");
    }
    assert_eq!(examined(&model, &quiet), Vec::<String>::new());
    let good = identified(&model, &quiet, true).estimate;
    assert!(good.doubts.is_empty() && good.options.as_ref().unwrap().signal.leave_out.is_empty(), "{:?}", good.doubts);
    let (_, said) = validated(&model, &good, &scene(&model, 33, Vec::new()).source());
    assert!(!said.contains(NAMED), "{said}");

    // `doctor` and `identify` report both pushes, with the remedy.
    for sentences in [examined(&model, &pushed), identified(&model, &pushed, false).estimate.doubts] {
        let all = sentences.join("\n");
        for (from, joint) in [(10.0_f64, "shoulder_lift"), (25.0, "elbow")] {
            // The contact is found in a moving mean over 0.2 s. So its reported ends differ from the true ends by up to 0.1 s.
            let is_near =
                |t: f64| sentences.iter().any(|s| s.contains(&format!("from {t:.1} to ")) && s.contains(joint));
            assert!((-1..=1).any(|tenth| is_near(from + 0.1 * f64::from(tenth))), "{from} {all}");
        }
        assert!(all.contains("of pushed.csv") && all.contains("without these rows") && all.contains(LEFT_OUT), "{all}");
    }

    // With the option of the remedy, the rows of both pushes are left out, and the parameters agree with the true ones.
    let found = identified(&model, &pushed, true);
    let estimate = found.estimate;
    assert!(estimate.doubts.is_empty(), "{:?}", estimate.doubts);
    let left_out = &estimate.options.as_ref().unwrap().signal.leave_out;
    for (from, to, ..) in pushes {
        let holds = |t: f64| left_out.iter().any(|i| i.log == "pushed.csv" && i.seconds[0] <= t && t <= i.seconds[1]);
        assert!(holds(from + 0.05) && holds(to - 0.05) && !holds(from - 2.0), "{left_out:?}");
    }
    let error = |estimate: &Estimate| validated(&model, estimate, &scene(&model, 33, Vec::new()).source()).0;
    let corrupt = identified(&model, &pushed, false).estimate;
    let untouched = identified(&model, &scene(&model, 32, Vec::new()).source(), false).estimate;
    let [without, with, clean] = [&estimate, &corrupt, &untouched].map(error);
    // A tenth of the rows is left out, so the expected error of the parameters is 5 % larger. One random log is tested.
    assert!(without < 1.1 * clean && with > 1.5 * clean, "{without} {with} {clean}");

    // If the pushed log is predicted, the contact is reported as the cause of the error, and not a lack of motion.
    let (total, said) = validated(&model, &good, &pushed);
    assert!(total > 0.05 && said.contains(NAMED) && said.contains("without these rows"), "{total} {said}");
    assert!(!said.contains("too short or too poor") && !said.contains("stay unexplained"), "{said}");

    // If contact lasts for more than half of a short log, all its rows are used for the verdict.
    for from in [0.3, 0.8, 1.3] {
        let mut brief = scene(&model, 41, vec![push((from, 2.9, 5, [60.0, 60.0, 0.0]))]);
        brief.seconds = 3.0;
        let (total, said) = validated(&model, &good, &brief.source());
        assert!(total > 0.05 && !said.contains("without these rows"), "{total} {said}");
    }

    // The replay determines its noise level from the rows that were fitted. So it also finds the contacts in the fitted log.
    let request = ReplayRequest { anyway: true, ..ReplayRequest::default() };
    let reference = std::slice::from_ref(&pushed);
    let replay = rist::replay(&model, (Path::new("e.yaml"), &estimate), &pushed, reference, &request).unwrap();
    let starts: Vec<f64> = replay.contacts.iter().map(|contact| contact.start).collect();
    let [first, second] = starts[..] else { panic!("{replay}") };
    assert!((first - 10.0).abs() < 0.05 && (second - 25.0).abs() < 0.05, "{replay}");
}
