//! Tests of a robot whose base parameters are refused, because equal lengths may be a coincidence. Commands that need base
//! parameters fail with the same reason; the other commands work.

use tests::has;
use tests::loops::BY_CHANCE;
use tests::program::{folder, rist};

#[test]
fn what_uses_base_parameters_refuses_a_rank_that_only_chance_makes() {
    let here = folder("one_gate");
    std::fs::write(here.join("arm.yaml"), BY_CHANCE).unwrap();
    std::fs::write(here.join("log.csv"), "t,q1,tau1\n0,0,0\n0.01,0,0\n").unwrap();
    std::fs::write(here.join("states.csv"), "q1,dq1,ddq1\n0,0,0\n").unwrap();
    for arguments in [
        &["inspect", "arm.yaml"][..],
        &["inspect", "arm.yaml", "--format", "json"],
        &["generate", "arm.yaml", "--out", "arm.rs"],
        &["generate", "arm.yaml", "--language", "c", "--out", "arm.c"],
        &["evaluate", "arm.yaml", "states.csv", "--quantity", "base-regressor"],
        &["plan", "arm.yaml", "--out", "plan.yaml"],
        &["excite", "arm.yaml", "--out", "motion.yaml"],
        &["doctor", "arm.yaml", "log.csv"],
        &["identify", "arm.yaml", "log.csv", "--out", "estimate.yaml"],
        &["accumulate", "arm.yaml", "log.csv", "--out", "sums.tri"],
    ] {
        let run = rist(&here, arguments).ended(2);
        has(&run.err, &["the numeric rank is 3, the exact one 8", "ZZ2", "one symbol"]);
    }
    for file in ["arm.rs", "arm.c", "plan.yaml", "motion.yaml", "estimate.yaml", "sums.tri"] {
        assert!(!here.join(file).exists(), "{file} was written");
    }

    for arguments in [
        &["evaluate", "arm.yaml", "states.csv", "--quantity", "torque"][..],
        &["evaluate", "arm.yaml", "states.csv", "--quantity", "regressor"],
        &["derive", "arm.yaml", "--function", "pose=3"],
        &["derive", "arm.yaml", "--function", "forward-dynamics"],
        &["generate", "arm.yaml", "--functions", "torque,pose=3", "--out", "free.rs"],
        &["convert", "arm.yaml", "--to", "urdf", "--out", "free.urdf"],
        &["lint", "arm.yaml"],
    ] {
        let run = rist(&here, arguments);
        let refused = run.err.contains("exact one") || run.code == Some(2);
        // A model without inertial parameters has no numeric torque.
        let lacks = run.err.contains("does not give the parameters");
        assert!(!refused || lacks, "{arguments:?}: {}{}", run.out, run.err);
    }
    let code = std::fs::read_to_string(here.join("free.rs")).unwrap();
    assert!(code.contains("There are no base parameters") && code.contains("pub fn torque"), "{code}");

    // If both lengths have the same symbol, their equality is intended, and base parameters are given. If one length has another
    // value, the robot is an ordinary four-bar.
    let meant = BY_CHANCE.replace("L2: 0.5, L3: 0.2", "L9: 1").replace("d: L2", "d: L0").replace("d: L3", "d: L1");
    std::fs::write(here.join("meant.yaml"), meant).unwrap();
    rist(&here, &["inspect", "meant.yaml"]).told(0, &["3 base parameters"]);
    rist(&here, &["inspect", "arm.yaml", "--value", "L3=0.3"]).told(0, &["8 base parameters"]);
}

#[test]
fn what_takes_long_is_refused_with_the_figures() {
    let here = folder("size");
    let link = |j: usize| {
        let antecedent = if j == 1 { "base".into() } else { (j - 1).to_string() };
        format!("  - {{link: {j}, antecedent: {antecedent}, alpha: pi/2, d: 0.1, theta: q{j}}}\n")
    };
    let chain = |n: usize| {
        let links: String = (1..=n).map(link).collect();
        let text = format!("convention: khalil-kleinfinger\nname: long\nrotor_inertia: none\nlinks:\n{links}");
        std::fs::write(here.join("long.yaml"), text).unwrap();
    };
    // The derivation for 220 links would take long, so the message states the needed time before the work starts.
    for n in [220, 300] {
        chain(n);
        for command in ["inspect", "generate", "excite"] {
            let run = rist(&here, &[command, "long.yaml"]).ended(2);
            let size = format!("{n} links with {} standard parameters", 10 * n);
            let parts = [&size, " s and ", " GiB", "--any-size"];
            assert!(parts.iter().all(|part| run.err.contains(part)), "{command}: {}", run.err);
        }
    }
    chain(60);
    rist(&here, &["inspect", "long.yaml"]).told(0, &["base parameters"]);
}

/// The lengths of links are of very different size, so that the search for the passive joints would overflow. Such a robot is
/// refused with a message.
#[test]
fn a_long_link_in_a_loop_ends_in_a_sentence() {
    let here = folder("long_link");
    for length in ["1e3", "2e5", "1e6", "1e9", "1e12", "1e15"] {
        let text = BY_CHANCE.replace("L0: 0.5", &format!("L0: {length}"));
        std::fs::write(here.join("long.yaml"), text).unwrap();
        rist(&here, &["inspect", "long.yaml"]).failed(2, &["in which the loops close"]);
    }
}
