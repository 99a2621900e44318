//! Tests that every derivation terminates: its amount of work is limited in advance. Its output grows only linearly with the
//! number of links.

use std::collections::BTreeMap;

use modeling::BaseParameters;
use robot::{Robot, format};
use tests::rules::coefficients;
use tests::{base_parameters, standard_names};

/// Base parameters of a robot, and the values of the constants that occur in the rules for them.
fn derived(robot: &Robot) -> (BaseParameters, Vec<(String, f64)>) {
    let parameters = base_parameters(robot);
    let constants = parameters.constants.clone();
    (parameters, constants)
}

fn yaml(text: &str) -> Robot {
    format::read_yaml(text, "robot.yaml").unwrap_or_else(|e| panic!("{e}"))
}

/// A URDF with joints given as (parent, child, origin xyz, origin rpy, mimicked joint).
fn urdf(joints: &[(&str, &str, &str, &str, Option<&str>)]) -> Robot {
    let mut text = String::from("<robot name='tree'><link name='base'/>\n");
    for (parent, child, xyz, rpy, mimic) in joints {
        let mimic = mimic.map_or(String::new(), |m| format!("<mimic joint='j{m}' multiplier='-1'/>"));
        text += &format!(
            "<link name='{child}'/><joint name='j{child}' type='continuous'><parent link='{parent}'/><child \
             link='{child}'/><origin xyz='{xyz}' rpy='{rpy}'/><axis xyz='0 0 1'/>{mimic}</joint>\n"
        );
    }
    format::read_urdf(&(text + "</robot>"), "tree.urdf").unwrap_or_else(|e| panic!("{e}"))
}

/// A chain of n joints on oblique axes; if `slides`, every fourth joint is prismatic.
fn oblique(n: usize, slides: bool) -> Robot {
    let mut text = String::from("convention: khalil-kleinfinger\nname: oblique\nlinks:\n");
    for j in 1..=n {
        let before = if j == 1 { "base".to_string() } else { (j - 1).to_string() };
        let (alpha, d, r) = (0.3 + 0.01 * j as f64, 0.1 + 0.003 * j as f64, 0.2 - 0.001 * j as f64);
        let joint = match slides && j % 4 == 0 {
            true => format!("joint: prismatic, theta: 0.{j}7, r: q{j}"),
            false => format!("r: {r:.4}, theta: q{j}"),
        };
        text += &format!("  - {{link: {j}, antecedent: {before}, alpha: {alpha:.3}, d: {d:.4}, {joint}}}\n");
    }
    yaml(&text)
}

/// A hand with two fingers after `n_before` joints. Each finger has three parallel joints; all mimic the first of them.
fn two_fingers(n_before: usize) -> Robot {
    let names: Vec<String> = (0..n_before + 6).map(|k| format!("l{k}")).collect();
    let mut joints: Vec<(&str, &str, &str, &str, Option<&str>)> = Vec::new();
    for k in 0..n_before {
        let parent = if k == 0 { "base" } else { &names[k - 1] };
        joints.push((parent, &names[k], "0.3 0.1 0.2", "0 1.5707963267948966 0.2", None));
    }
    let hand = &names[n_before - 1];
    for finger in 0..2 {
        for phalanx in 0..3 {
            let at = n_before + 3 * finger + phalanx;
            let parent = if phalanx == 0 { hand } else { &names[at - 1] };
            let mimic = (at > n_before).then_some(names[n_before].as_str());
            let xyz = ["0.061 0.096 0.032", "0.096 0.045 0.054", "0.043 -0.021 0.017"][phalanx];
            joints.push((parent, &names[at], xyz, if phalanx == 0 { "0 1.2 0.3" } else { "0 0 0" }, mimic));
        }
    }
    urdf(&joints)
}

#[test]
fn mimic_joints_in_parallel_chains_end() {
    for n_before in [2, 12] {
        let (parameters, _) = derived(&two_fingers(n_before));
        let rank = parameters.rank;
        assert_eq!(rank.exact.rank(), Some(rank.numeric));
        // Relations without a short closed form hold only for the numbers of this robot. They are counted separately from exact
        // relations.
        assert!(rank.exact_relations > 0, "{rank:?}");
    }
}

/// A single floating body: all ten parameters are base parameters, so there is nothing to regroup.
#[test]
fn a_robot_without_relations_to_solve_ends() {
    let text = "<robot name='drone'><link name='frame'/></robot>";
    let options = format::ReadOptions { floating_base: true, ..format::ReadOptions::default() };
    let drone = format::read_urdf_with(text, "drone.urdf", options).unwrap().floating();
    assert_eq!(derived(&drone).0.len(), 10);
}

#[test]
fn slides_on_one_axis_end() {
    let link = |j: usize, rest: &str| format!("  - {{link: {j}, antecedent: {}, {rest}}}\n", j - 1);
    let head = "convention: khalil-kleinfinger\nname: gantry\nlinks:\n  - {link: 1, antecedent: base, theta: q1}\n";
    let oblique = [
        link(2, "joint: prismatic, gamma: 0.4, b: 0.1, alpha: -1.8, d: 0.2, theta: -2.3, r: q2"),
        link(3, "joint: prismatic, gamma: -0.7, b: 0.3, alpha: 2.8, d: -0.1, theta: 2.7, r: q3"),
        link(4, "joint: prismatic, gamma: 1.1, b: -0.2, alpha: 1.1, d: 0.3, theta: 0.7, r: q4"),
    ];
    for n in 1..=3 {
        let (parameters, _) = derived(&yaml(&(head.to_string() + &oblique[..n].concat())));
        assert_eq!(parameters.rank.exact.rank(), Some(parameters.rank.numeric), "{n} slides");
    }
}

/// Rules for base parameters may be nested: the rule of a link contains parameters of the next link. Nested rules grow linearly
/// with the number of links. Expanded to standard parameters, they give the same coefficients.
#[test]
fn rules_of_long_chains_are_nested() {
    let text = |rules: &modeling::Rules| rules.base.iter().chain(&rules.regrouped).map(String::len).sum::<usize>();
    // The shortest chains whose expanded rules exceed 200 000 characters.
    for (n, slides) in [(12, false), (9, true)] {
        let short = oblique(n, slides);
        let (parameters, constants) = derived(&short);
        let (nested, expanded) = (parameters.rules(), parameters.expanded_rules().unwrap());
        assert!(nested.coefficients.is_empty() && !expanded.coefficients.is_empty());
        let names = standard_names(&short);
        let expected =
            |k: usize| parameters.base[k].terms.iter().map(|t| (names[t.parameter].clone(), t.coefficient)).collect();
        for (k, rule) in expanded.base.iter().enumerate() {
            same(&coefficients(rule.split_once(" = ").unwrap().1, &names, &constants), &expected(k), rule);
        }
        let outward = substituted(&nested.regrouped, &names, &constants);
        for (k, rule) in nested.base.iter().enumerate() {
            same(&put_in(rule, &outward, &names, &constants), &expected(k), rule);
        }

        let long = derived(&oblique(40, slides)).0;
        let rules = long.rules();
        assert!(rules.coefficients.is_empty() && !rules.regrouped.is_empty(), "40 oblique links are nested");
        // The text grows linearly, because the rules of a link contain at most ten parameters of the next link, each with a few
        // products of six numbers. The rules of the first links are up to a third shorter, since the base absorbs some
        // parameters.
        assert!(
            text(&rules) * n * 3 <= text(&nested) * 40 * 4,
            "{} for 40 links, {} for {n}",
            text(&rules),
            text(&nested)
        );
    }
}

type Sum = BTreeMap<String, f64>;

/// The regrouped parameters as sums of standard parameters. The last link comes first, because the rule of a link contains
/// parameters of the next link.
fn substituted(rules: &[String], names: &[String], constants: &[(String, f64)]) -> BTreeMap<String, Sum> {
    let mut known = BTreeMap::new();
    for rule in rules.iter().rev() {
        let sum = put_in(rule, &known, names, constants);
        known.insert(rule.split_once(" = ").unwrap().0.to_string(), sum);
    }
    known
}

fn put_in(rule: &str, known: &BTreeMap<String, Sum>, names: &[String], constants: &[(String, f64)]) -> Sum {
    let all: Vec<String> = names.iter().chain(known.keys()).cloned().collect();
    let mut sum = Sum::new();
    for (name, factor) in coefficients(rule.split_once(" = ").unwrap().1, &all, constants) {
        let own = Sum::from([(name.clone(), 1.0)]);
        for (standard, x) in known.get(&name).unwrap_or(&own) {
            *sum.entry(standard.clone()).or_default() += factor * x;
        }
    }
    sum
}

/// Checks that two sums have the same coefficients. The tolerance 1e-12 is for sums of some hundred products of order one. A term
/// that cancels may be absent in either sum.
fn same(found: &Sum, expected: &Sum, what: &str) {
    for name in found.keys().chain(expected.keys()) {
        let [a, b] = [found, expected].map(|sum| sum.get(name).copied().unwrap_or(0.0));
        assert!((a - b).abs() <= 1e-12 * (1.0 + b.abs()), "{what}: {name} {a} {b}");
    }
}
