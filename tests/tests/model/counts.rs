//! Tests of the numbers of operations of derived functions: the exact numbers for every model, and published numbers that they
//! must not exceed.

use std::collections::BTreeMap;
use std::fmt::Write;

use expr::Count;
use robot::{Robot, RotorInertia};
use tests::{derived, model, models};

/// Name of a function -> numbers of [multiplications, additions, sines and cosines].
type Counts = BTreeMap<String, [usize; 3]>;

fn counts(robot: &Robot) -> Counts {
    let (mut derivation, regressor, base) = derived(robot);
    let functions = [
        ("base_regressor", base.regressor(&regressor)),
        ("regressor", regressor),
        ("torque", derivation.torque()),
        ("inverse_dynamics", derivation.inverse_dynamics(&base)),
    ];
    let three = |c: Count| [c.mul, c.add, c.sin_cos];
    functions.into_iter().map(|(name, f)| (name.to_string(), three(f.bound().count()))).collect()
}

fn without_rotors(file: &str) -> Robot {
    let mut robot = model(file);
    for link in &mut robot.links {
        link.joint.rotor_inertia = RotorInertia::Absent;
    }
    robot
}

#[test]
fn counts_are_at_most_those_of_a_hand_written_recursion() {
    // Upper limits: (multiplications, additions) of the base regressor and of the standard regressor by a recursion that was
    // written by hand, with common subexpressions shared, numeric geometry, and without rotor inertia.
    for (file, base, standard) in [
        ("ur5.yaml", [357, 280], [451, 355]),
        ("kuka_lwr.yaml", [658, 472], [799, 601]),
        ("panda.yaml", [685, 500], [842, 640]),
    ] {
        let counts = counts(&without_rotors(file));
        for (function, limit) in [("base_regressor", base), ("regressor", standard)] {
            let [mul, add, _] = counts[function];
            assert!(mul <= limit[0] && add <= limit[1], "{file} {function}: {mul}/{add}, at most {limit:?}");
        }
    }
}

#[test]
fn torque_of_the_base_parameters_costs_no_more_than_the_best_published_recursion() {
    // Upper limits: the recursion of Khalil and Kleinfinger 1987, in the form with moments about the link origins, without unused
    // operations, with rotor inertia.
    for (file, limit) in [
        ("planar2r.yaml", [20, 12]),
        ("rx90.yaml", [253, 237]),
        ("puma560.yaml", [265, 249]),
        ("stanford.yaml", [234, 217]),
        ("ur5.yaml", [263, 248]),
        ("kuka_lwr.yaml", [304, 286]),
    ] {
        let [mul, add, _] = counts(&model(file))["inverse_dynamics"];
        assert!(mul <= limit[0] && add <= limit[1], "{file}: {mul}/{add}, at most {limit:?}");
    }
}

#[test]
fn counts_are_those_of_the_table() {
    let table: BTreeMap<String, Counts> = serde_yaml::from_str(include_str!("../../data/counts.yaml")).unwrap();
    let found: BTreeMap<String, Counts> = models().into_iter().map(|(file, robot)| (file, counts(&robot))).collect();
    let mut text = String::new();
    for (file, counts) in &found {
        writeln!(text, "{file}:").unwrap();
        for (function, count) in counts {
            writeln!(text, "  {function}: {count:?}").unwrap();
        }
    }
    assert!(table == found, "tests/data/counts.yaml does not hold these counts; where they are meant, write\n{text}");
}

#[test]
fn the_inertia_matrix_costs_less_than_symoro_printed() {
    // SYMORO+ printed 260 multiplications and 212 additions for the inertia matrix of the KUKA LWR.
    let robot = model("kuka_lwr.yaml");
    let (mut derivation, _, base) = derived(&robot);
    let count = derivation.inertia_matrix(&base).bound().count();
    assert!(count.mul < 260 && count.add < 212, "{count:?}");
}
