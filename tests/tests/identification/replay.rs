//! Tests of `rist replay` on simulated logs of a working UR5: with pushes, with a load, with drift of friction, and without any
//! of these.

use std::path::{Path, PathBuf};

use linear_model::friction::terms::FrictionTerm;
use rist::describe::source::{IdentifiedValues, Language};
use rist::replay::{CarriedLoad, EARLY_S};
use rist::request::{FrictionChoice, GenerateRequest, IdentifyRequest, ReplayRequest};
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
    identified_with(model, "")
}

/// `friction`: the friction terms, as words; the default ones if it is empty.
fn identified_with(model: &Model, friction: &str) -> (Estimate, LogSource) {
    let log = scene(model, 1, 60.0).source();
    let mut request = IdentifyRequest::default();
    request.samples.covariance = true;
    if !friction.is_empty() {
        let terms = friction.split(',').map(|word| FrictionTerm::of_word(word).unwrap());
        request.samples.rows.friction = Some(FrictionChoice::Terms(terms.collect()));
    }
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

    // Without pushes, load or drift, the replay reports no contact and no load, and the friction equals the identified
    // friction.
    let quiet = replayed(&model, &known, &scene(&model, 2, 60.0).source());
    assert!(quiet.contacts.is_empty() && quiet.loads.is_empty(), "{quiet}");
    assert!(quiet.has_covariance);
    for joint in &quiet.joints {
        assert!(!joint.is_outdated() && joint.drifted().next().is_none(), "{quiet}");
    }

    // A push on the forearm (58 N) and a push on the last link (28 N).
    let mut pushed = scene(&model, 3, 40.0);
    pushed.pushes.push(Push { link: 2, from: 10.0, to: 10.6, force: [0.0, 30.0, 50.0], largest: None });
    pushed.pushes.push(Push { link: 5, from: 25.0, to: 25.4, force: [20.0, 20.0, 0.0], largest: None });
    let (log, largest) = pushed.log();
    let found = replayed(&model, &known, &LogSource::Held(log));
    assert!(found.loads.is_empty() && found.contacts.len() == 2, "{found}");
    for ((contact, push), (torque, joint)) in found.contacts.iter().zip(&pushed.pushes).zip(largest) {
        // A first-order observer with the gain 50 1/s reaches two thirds of a torque after 20 ms. A contact ends only after the
        // hold time of 0.1 s.
        assert!((0.0..0.05).contains(&(contact.start - push.from)), "{found}");
        assert!((0.0..0.25).contains(&(contact.end - push.to)), "{found}");
        assert!(contact.last_joint <= push.link && contact.last_joint + 1 >= joint, "{found} {joint}");
        if contact.joint == joint {
            // The push has a constant force, but its joint torque changes with the posture, and the observer is 20 ms late.
            assert!((contact.torque.abs() / torque - 1.0).abs() < 0.15, "{found} {torque}");
        }
    }

    // Force and moment at the origin of the last link: the torques of six joints determine all six components; the torques of
    // three joints determine at most three. The result is the wrench that acts on the link. In the scene, the force is the one
    // that the link exerts, so the result has the opposite sign.
    let on = |link: &str| {
        let request = ReplayRequest { wrench_on: Some(link.into()), ..ReplayRequest::default() };
        let reference = std::slice::from_ref(&known.1);
        let found =
            rist::replay(&model, (Path::new("e.yaml"), &known.0), &pushed.source(), reference, &request).unwrap();
        found.contacts[1].wrench.clone().unwrap()
    };
    let wrench = on("wrist_3");
    for (c, truth) in [-20.0, -20.0, 0.0, 2.0, -2.0, 0.0].into_iter().enumerate() {
        let (value, sigma) = (wrench.components[c].unwrap(), wrench.sigma[c]);
        // Allowed: four standard deviations, plus an eighth of the push, because the filter has followed the push for only two
        // time constants.
        assert!((value - truth).abs() < 4.0 * sigma + if c < 3 { 2.5 } else { 0.25 }, "{wrench:?}");
        assert!(sigma < if c < 3 { 10.0 } else { 2.0 }, "{wrench:?}");
    }
    assert!(on("forearm").components.iter().filter(|c| c.is_some()).count() <= 3);

    // A load of 2 kg from 10 s to 30 s.
    let mut loaded = scene(&model, 4, 40.0);
    let tool = load(2.0, [0.02, -0.03, 0.08]);
    loaded.loads.push(Carried { from: 10.0, to: 30.0, load: tool.clone() });
    let found = replayed(&model, &known, &loaded.source());
    assert!(found.contacts.is_empty(), "{found}");
    let [picked, put]: &[CarriedLoad; 2] = found.loads.as_slice().try_into().unwrap_or_else(|_| panic!("{found}"));
    assert!((picked.start - 10.0).abs() < 0.1 && (put.start - 30.0).abs() < 0.1, "{found}");
    let (mass, sigma) = picked.mass();
    // The result of one random log may deviate by four standard deviations. The standard deviation itself must be small enough
    // to be useful.
    assert!((mass - tool.mass).abs() < 4.0 * sigma && sigma < 0.06, "{found}");
    // Half a second after the load appeared, this slow motion hardly determines the mass, and the standard deviation says so. The
    // bench `online` has the errors of many loads.
    let early = picked.early.unwrap_or_else(|| panic!("{picked:?}"));
    assert!(early.sigma[9] > 0.3 && (early.parameters[9] - tool.mass).abs() < 2.0 * early.sigma[9], "{early:?}");
    assert!(picked.is_held() && !put.is_held(), "{found}");
    for (found, truth) in picked.centre().iter().zip(tool.centre_of_mass) {
        assert!(found.is_none_or(|found| (found - truth).abs() < 0.01), "{picked:?}");
    }

    // Coulomb friction of the second joint grows by a third.
    let mut worn = scene(&model, 6, 60.0);
    worn.friction[1][1] += 2.0;
    let found = replayed(&model, &known, &worn.source());
    assert!(found.loads.is_empty(), "{found}");
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
    let outputs = ["--series", "s.csv", "--report", "p.html", "--date", "today"];
    let run = tests::program::rist(&here, &[&["replay", &ur5, "e.yaml", "other.csv"], &outputs[..]].concat()).ended(0);
    assert!(run.out.contains("\ncontact: none\n") && run.out.contains("\nload on wrist_3: none\n"), "{}", run.out);
    let one_log = "the noise is from one log";
    assert!(run.out.contains(one_log), "{}", run.out);
    // The remedy is obeyed: another motion without contact as reference.
    let more = ["replay", &ur5, "e.yaml", "other.csv", "--reference", "log.csv", "--reference", "other.csv"];
    let run = tests::program::rist(&here, &more).ended(0);
    assert!(!run.out.contains(one_log), "{}", run.out);
    let series = std::fs::read_to_string(here.join("s.csv")).unwrap();
    assert!(series.starts_with("t,tau_ext_shoulder_pan,band_shoulder_pan,"), "{}", &series[..80]);
    assert!(series.lines().skip(1).all(|line| line.split(',').count() == 15 && !line.contains("NaN")));
    let page = std::fs::read_to_string(here.join("p.html")).unwrap();
    assert!(page.contains("No contact was found.") && page.contains("<dd>today</dd>"), "{page}");
    assert_eq!(page.matches("External torque of ").count(), 12, "a title and a caption for each joint");

    std::fs::rename(here.join("log.csv"), here.join("gone.csv")).unwrap();
    let refused = tests::program::rist(&here, &["replay", &ur5, "e.yaml", "other.csv"]).ended(2);
    assert!(refused.err.contains("log.csv") && refused.err.contains("--reference"), "{}", refused.err);
    tests::program::rist(&here, &["replay", &ur5, "e.yaml", "other.csv", "--reference", "gone.csv"]).ended(0);
    let other = tests::model_path("rx90.yaml").display().to_string();
    let refused =
        tests::program::rist(&here, &["replay", &other, "e.yaml", "other.csv", "--reference", "gone.csv"]).ended(2);
    assert!(refused.err.contains("made with `ur5"), "{}", refused.err);
}

/// A program in C that reads rows of q, dq and tau, and prints external torque, status, mass and the mass of the candidate of each
/// cycle.
const DRIVER: &str = r#"
#include <stdio.h>
#include "arm.h"

int main(void)
{
    static ur5_urdf_monitor m;
    double x[18];
    ur5_urdf_real q[6], dq[6], tau[6], load[10], sigma[10];
    int j, k;
    ur5_urdf_start(&m);
    for (;;) {
        for (k = 0; k < 18; k++)
            if (scanf("%lf", &x[k]) != 1)
                return 0;
        for (j = 0; j < 6; j++) {
            q[j] = (ur5_urdf_real)x[j];
            dq[j] = (ur5_urdf_real)x[6 + j];
            tau[j] = (ur5_urdf_real)x[12 + j];
        }
        k = ur5_urdf_monitor_step(&m, q, dq, tau, (ur5_urdf_real)(1.0 / 487.0));
        for (j = 0; j < 6; j++)
            printf("%.17g ", (double)m.external[j]);
        printf("%d %.17g", k, (double)m.load.parameters[9]);
        k = ur5_urdf_load_candidate(&m, load, sigma);
        printf(" %.17g\n", k ? (double)load[9] : 0.0);
    }
}
"#;

/// The columns of the driver's output: external torques, status, mass and mass of the candidate of each cycle. `real`: double or float.
fn driven(here: &Path, real: &str, log: &logs::Log) -> Vec<Vec<f64>> {
    use std::io::Write;
    let options =
        format!("-std=c99 -Wall -Wextra -Werror -pedantic -O2 -DUR5_URDF_REAL={real} driver.c arm.c -lm -o {real}");
    tests::program::done(here, "cc", &options);
    let mut child = std::process::Command::new(here.join(real))
        .stdin(std::process::Stdio::piped())
        .stdout(std::process::Stdio::piped())
        .spawn()
        .unwrap();
    let mut input = child.stdin.take().unwrap();
    let dq = log.dq.as_ref().unwrap();
    let rows: String = (0..log.t.len())
        .map(|r| {
            let row = log.q.iter().chain(dq).chain(&log.effort).map(|series| format!("{:?}", series[r]));
            row.collect::<Vec<_>>().join(" ") + "\n"
        })
        .collect();
    let writer = std::thread::spawn(move || input.write_all(rows.as_bytes()).unwrap());
    let out = child.wait_with_output().unwrap();
    writer.join().unwrap();
    let text = String::from_utf8(out.stdout).unwrap();
    text.lines().map(|line| line.split(' ').map(|x| x.parse().unwrap()).collect()).collect()
}

/// In both, the candidate is the same half a second after a load appeared, and there is none without contact.
fn same_candidates(replay: &Replay, driven: &[Vec<f64>]) {
    for carried in &replay.loads {
        let half = replay.series.iter().position(|cycle| cycle.t - carried.start >= EARLY_S).unwrap();
        let early = carried.early.unwrap().parameters[9];
        assert!((driven[half][8] - early).abs() < 1e-5, "{} {early}", driven[half][8]);
    }
    assert!(replay.series.iter().zip(driven).all(|(cycle, c)| cycle.is_contact || c[8] == 0.0));
}

/// A folder with the generated monitor and its driver.
fn generated(model: &Model, known: &(Estimate, LogSource), rate: f64) -> PathBuf {
    let functions = ["observer", "payload"].map(String::from);
    let request = GenerateRequest { functions: functions.to_vec(), rate, ..GenerateRequest::default() };
    let mut values = IdentifiedValues::of(model, &known.0).unwrap();
    let reference = std::slice::from_ref(&known.1);
    values.monitor = Some(rist::replay::monitor(model, (Path::new("e.yaml"), &known.0), reference, &request).unwrap());
    let generate = |values: Option<&IdentifiedValues>, language: &Language| {
        rist::generate(&model.robot, &functions, language, "this test", values, &[], false)
    };
    let language = Language::C { header: "arm.h".into() };
    let source = generate(Some(&values), &language).unwrap();
    for (values, language, said) in [(None, &language, "[estimate]"), (Some(&values), &Language::Rust, "[language=c]")]
    {
        let refused = generate(values, language).err().map(|e| e.to_string()).unwrap_or_default();
        assert!(refused.contains(said), "{refused}");
    }
    let here = tests::program::folder("monitor_in_c");
    std::fs::write(here.join("arm.c"), source.text).unwrap();
    std::fs::write(here.join("arm.h"), source.header.unwrap()).unwrap();
    std::fs::write(here.join("driver.c"), DRIVER).unwrap();
    here
}

/// All friction terms of an estimate are in the generated monitor.
#[test]
fn the_generated_monitor_in_c_has_the_friction_of_the_replay() {
    let model = Model::read(tests::model_path("ur5.urdf")).unwrap();
    let log = Scene { rate: 487.0, ..scene(&model, 8, 5.0) }.log().0;
    for friction in [
        "asymmetric,stribeck=0.2,load",
        "smooth-coulomb=0.1,offset,load@2,stribeck=0.3@3,viscous-asymmetry@4,root@5,rotor",
    ] {
        let known = identified_with(&model, friction);
        let replay = replayed(&model, &known, &LogSource::Held(log.clone()));
        let double = driven(&generated(&model, &known, 487.0), "double", &log);
        assert_eq!(double.len(), replay.series.len());
        for (cycle, double) in replay.series.iter().zip(&double) {
            for (j, torque) in cycle.torque.iter().enumerate() {
                // As in `the_generated_monitor_in_c_is_the_replay`.
                assert!((torque - double[j]).abs() < 1e-8, "{friction} {} {torque} {}", cycle.t, double[j]);
            }
        }
    }
}

#[test]
fn the_generated_monitor_in_c_is_the_replay() {
    let model = Model::read(tests::model_path("ur5.urdf")).unwrap();
    let known = identified(&model);
    // The rate is chosen so that no time constant of the monitor is a multiple of the sampling period. Then rounding of times
    // changes no decision.
    let mut busy = Scene { rate: 487.0, ..scene(&model, 8, 30.0) };
    busy.pushes.push(Push { link: 3, from: 5.0, to: 5.3, force: [20.0, 30.0, 0.0], largest: None });
    busy.loads.push(Carried { from: 10.0, to: 20.0, load: load(1.5, [0.0, 0.02, 0.06]) });
    let (mut log, _) = busy.log();
    let replay = replayed(&model, &known, &LogSource::Held(log.clone()));
    assert_eq!((replay.contacts.len(), replay.loads.len()), (1, 2), "{replay}");
    // The push ends at 5.3 s. The loads later do not lengthen its interval.
    assert!((5.3..6.0).contains(&replay.contacts[0].end), "{replay}");

    let here = generated(&model, &known, busy.rate);

    let double = driven(&here, "double", &log);
    assert_eq!(double.len(), replay.series.len());
    let single = driven(&here, "float", &log);
    let (mut largest, mut others) = (0.0_f64, 0);
    for ((cycle, double), single) in replay.series.iter().zip(&double).zip(&single) {
        for (j, torque) in cycle.torque.iter().enumerate() {
            // The observer forgets rounding errors within 20 ms, and torques are up to 100 N m. The times in the log are
            // rounded too.
            assert!((torque - double[j]).abs() < 1e-8, "{} {torque} {}", cycle.t, double[j]);
            largest = largest.max((double[j] - single[j]).abs());
        }
        others += usize::from(cycle.is_contact != (double[6] as i32 & 1 == 1));
        // The estimate of the load amplifies rounding, because the motion hardly determines some of its ten parameters.
        others += usize::from((cycle.mass - double[7]).abs() > 1e-5);
    }
    assert_eq!(others, 0);
    same_candidates(&replay, &double);
    let last = |of: &[Vec<f64>], t: f64| of[(t * 487.0) as usize][7];
    println!("f32: external torque within {largest:.2e} N m, mass {} and {}", last(&double, 19.0), last(&single, 19.0));
    // Single precision: a momentum of about ten kg m^2/s, times the gain of 50 1/s and the rounding 6e-8, gives 30 uN m per
    // rounding; some hundred roundings add up.
    assert!(largest < 5e-3, "{largest}");
    assert!((last(&double, 19.0) - last(&single, 19.0)).abs() < 0.01);

    // A state that is not a number is skipped, and the monitor starts again. A torque at the limit of 150 N m is reported.
    log.effort[1][6000..6100].fill(-150.0);
    let saturated = replayed(&model, &known, &LogSource::Held(log.clone()));
    for (joint, expected) in saturated.joints.iter().zip([0.0, 100.0 / busy.rate, 0.0, 0.0, 0.0, 0.0]) {
        assert!((joint.saturated - expected).abs() < 1e-6, "{saturated}");
    }
    assert!(saturated.to_string().contains("external torque unknown for 0.205 s, at the limit of the effort"));
    log.q[2][5000] = f64::NAN;
    let broken = driven(&here, "double", &log);
    assert_eq!(broken[5000][6] as i32, 8);
    assert!(broken.iter().flatten().all(|x| x.is_finite()));
    let at_limit = broken.iter().enumerate().filter(|(_, cycle)| cycle[6] as i32 & 16 != 0).map(|(r, _)| r);
    assert!(at_limit.eq(6000..6100));
}
