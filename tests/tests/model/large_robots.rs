//! Tests that robots with many joints get the right base parameters.
//!
//! Each joint gives fewer regressor rows than there are columns, so a rank method that works for ten joints may fail for fifty.
//! The reference rank comes from a Newton-Euler regressor, computed column by column, which shares no code with `modeling`. If a
//! robot is too large for that, the expected number is known, and D_base X_base = D X must hold (D, X: standard regressor and
//! parameters).

use std::fmt::Write as _;
use std::process::Command;

use modeling::{BaseParameters, RobotFunction};
use nalgebra::DMatrix;
use robot::Robot;
use robot::format::{ReadOptions, read_urdf_with, read_yaml};
use tests::program::{done, folder, is_there, run};
use tests::random::Random;
use tests::{derived, dot, evaluated, recursion, standard_names};

#[derive(Clone, Copy, PartialEq)]
enum Axes {
    /// Axes at right angles: twists of 0, 90, -90 degrees in turn, lengths along z and x in turn.
    Right,
    /// General twists, and offsets in all directions.
    Oblique,
}

/// A URDF with n joints. The parent of each link is one of the last `reach` links; every `sliding`-th joint is prismatic.
fn urdf(n: usize, axes: Axes, reach: usize, sliding: Option<usize>) -> String {
    let random = &mut Random(n as u64);
    let mut text = format!("<robot name=\"many\"><link name=\"l0\">{BODY}</link>\n");
    for k in 1..=n {
        let parent = k - 1 - random.below(reach.min(k));
        let right = std::f64::consts::FRAC_PI_2;
        let (rpy, xyz) = match axes {
            Axes::Right => {
                let x = 0.3 * random.unit();
                let xyz = if k % 2 == 1 { [0.0, 0.0, x] } else { [x, 0.0, 0.0] };
                ([[0.0, right, -right][k % 3], 0.0, 0.0], xyz)
            }
            Axes::Oblique => ([0, 1, 2].map(|_| 1.4 * random.unit()), [0, 1, 2].map(|_| 0.3 * random.unit())),
        };
        let kind = if sliding.is_some_and(|every| k % every == 0) { "prismatic" } else { "revolute" };
        let three = |v: [f64; 3]| v.map(|x| if x.abs() == right { x.to_string() } else { format!("{x:.4}") }).join(" ");
        writeln!(
            text,
            "<link name=\"l{k}\">{BODY}</link><joint name=\"j{k}\" type=\"{kind}\"><parent link=\"l{parent}\"/>\
             <child link=\"l{k}\"/><origin xyz=\"{}\" rpy=\"{}\"/><axis xyz=\"0 0 1\"/>\
             <limit lower=\"-2\" upper=\"2\" velocity=\"3\" effort=\"50\"/></joint>",
            three(xyz),
            three(rpy)
        )
        .unwrap();
    }
    text + "</robot>"
}

const BODY: &str = "<inertial><origin xyz=\"0.1 0 0\" rpy=\"0 0 0\"/><mass value=\"1\"/>\
     <inertia ixx=\"0.02\" ixy=\"0.001\" ixz=\"0\" iyy=\"0.03\" iyz=\"0.002\" izz=\"0.025\"/></inertial>";

fn read(text: &str, floating_base: bool) -> Robot {
    let options = ReadOptions { floating_base, ..ReadOptions::default() };
    let robot = read_urdf_with(text, "many.urdf", options).unwrap_or_else(|e| panic!("{e}"));
    if floating_base { robot.floating() } else { robot }
}

/// The base parameters. At two random states, it is checked that they give the same torques as the standard parameters: D_base
/// X_base = D X.
fn regrouped(robot: &Robot) -> BaseParameters {
    let (_, regressor, base) = derived(robot);
    let base_regressor = base.regressor(&regressor);
    let random = &mut Random(1);
    for _ in 0..2 {
        let (state, x) = (random.state(robot), random.parameters(robot));
        let y = evaluated(&base_regressor, &[&state.inputs()]);
        let x_base = base.values(&x);
        for (row, tau) in y.chunks(base.len()).zip(recursion::torque(robot, &state, &x)) {
            let (found, size) = dot(row, &x_base);
            // The tolerance is for sums of thousands of terms, with rules for base parameters that add lengths over all links.
            assert!((found - tau).abs() <= 1e-12 * (1.0 + size), "{} joints: {found} {tau}", robot.links.len());
        }
    }
    let n_standard = standard_names(robot).len();
    assert_eq!(base.rank.exact.rank(), Some(base.len()));
    assert!(base.len() + base.no_effect.len() <= n_standard);
    base
}

/// The rank of the Newton-Euler regressor, and the gap after it: last kept divided by first dropped diagonal entry of a pivoted
/// QR. The columns are scaled.
fn independent_rank(robot: &Robot) -> (usize, f64) {
    let (n, p) = (robot.n_coordinates(), standard_names(robot).len());
    // The parameters of the last link need a dozen states, because in each state they are in only one row: the row of the last
    // joint.
    let states = p.div_ceil(n) + 4;
    let random = &mut Random(2);
    let mut observed = DMatrix::zeros(states * n, p);
    for s in 0..states {
        let state = random.state(robot);
        let mut unit = vec![0.0; p];
        for c in 0..p {
            unit[c] = 1.0;
            let column = recursion::torque(robot, &state, &unit);
            observed.view_mut((s * n, c), (n, 1)).copy_from_slice(&column);
            unit[c] = 0.0;
        }
    }
    let largest = observed.column_iter().map(|c| c.norm()).fold(0.0, f64::max);
    for mut column in observed.column_iter_mut() {
        let norm = column.norm();
        // A column without effect contains only rounding errors.
        if norm > 1e-10 * largest { column /= norm } else { column.fill(0.0) }
    }
    // A plain QR first reduces the matrix to p rows, which makes the pivoted QR fast.
    let r = observed.qr().unpack_r().col_piv_qr().unpack_r();
    let diagonal: Vec<f64> = r.diagonal().iter().map(|x| x.abs()).collect();
    // A dependent column of unit norm has a residual of about 1e-14. An independent column has a residual of more than 1e-8 in
    // these robots.
    let rank = diagonal.iter().filter(|x| **x > 1e-11).count();
    (rank, diagonal[rank - 1] / diagonal.get(rank).copied().unwrap_or(0.0))
}

fn has_its_rank(text: &str, floating: bool, expected: Option<usize>) {
    let robot = read(text, floating);
    let found = regrouped(&robot).len();
    let (rank, gap) = independent_rank(&robot);
    assert!(gap > 1e3, "the test cannot tell: {rank} with a gap of {gap:.0e}");
    assert_eq!(found, rank, "{} joints", robot.n_coordinates());
    if let Some(expected) = expected {
        assert_eq!(found, expected);
    }
}

#[test]
fn chains_of_right_angles() {
    // Lengths just below and above 44 joints, where columns were once dropped by mistake.
    for (n, expected) in [(43, 297), (44, 304), (45, 311), (60, 416)] {
        has_its_rank(&urdf(n, Axes::Right, 1, None), false, Some(expected));
    }
}

#[test]
fn a_chain_of_a_hundred() {
    has_its_rank(&urdf(100, Axes::Right, 1, None), false, Some(696));
}

#[test]
fn a_chain_of_two_hundred_loses_nothing() {
    // Shorter chains with these axes have 7 n - 4 base parameters for n joints; so 200 joints have 1396.
    assert_eq!(regrouped(&read(&urdf(200, Axes::Right, 1, None), false)).len(), 1396);
}

#[test]
fn oblique_chains_and_trees() {
    for (reach, sliding) in [(1, None), (6, None), (1, Some(4))] {
        has_its_rank(&urdf(50, Axes::Oblique, reach, sliding), false, None);
    }
}

#[test]
fn an_oblique_tree_of_a_hundred() {
    has_its_rank(&urdf(100, Axes::Oblique, 6, None), false, None);
}

#[test]
fn two_arms_on_a_floating_base() {
    // Joint 26 is attached to the base, like joint 1, which gives two arms.
    let text = urdf(50, Axes::Oblique, 1, None).replace("<parent link=\"l25\"/>", "<parent link=\"l0\"/>");
    has_its_rank(&text, true, None);
}

fn compiler_of_c() -> Option<&'static str> {
    let found = ["cc", "gcc", "clang"].into_iter().find(|cc| is_there(cc));
    if found.is_none() {
        println!("skipped: no C compiler");
    }
    found
}

/// Compiles the text `main` in C, without warnings, with the generated `many.h` and `many.c`, and runs it. Returns its output and
/// the expected torques. `main` can use q, dq, ddq of a random state, and the base parameters x.
fn printed_by_c(
    cc: &str,
    (robot, base, functions): (&Robot, &BaseParameters, &[RobotFunction]),
    main: &str,
) -> (String, Vec<f64>) {
    let module = modeling::module(robot, functions).unwrap_or_else(|e| panic!("{e}"));
    let files = codegen::c_files(&module, "this test", "many.h", None);
    let (state, x) = (Random(3).state(robot), Random(4).parameters(robot));
    let list = |v: &[f64]| v.iter().map(|x| format!("{x:?}")).collect::<Vec<_>>().join(", ");
    let head = format!(
        "#include <stdio.h>\n#include \"many.h\"\n\
         static const double q[] = {{{}}}, dq[] = {{{}}}, ddq[] = {{{}}}, x[] = {{{}}};\n",
        list(&state.q),
        list(&state.dq),
        list(&state.ddq),
        list(&base.values(&x)),
    );
    let folder = folder(&format!("many_{}", robot.n_coordinates()));
    for (file, text) in [("many.h", files.header), ("many.c", files.source), ("main.c", head + main)] {
        std::fs::write(folder.join(file), text).unwrap();
    }
    done(&folder, cc, "-std=c99 -Wall -Wextra -pedantic -Werror -o program main.c many.c -lm");
    (run(&mut Command::new(folder.join("program"))).out, recursion::torque(robot, &state, &x))
}

/// All functions of a robot compile in C without a warning, and the torque equals the torque by the recursion. If there are more
/// than eight angles, the code computes their sines in groups of four, each where it is needed.
#[test]
fn every_function_of_ten_joints_compiles_in_c() {
    let Some(cc) = compiler_of_c() else { return };
    for (n, axes) in [(9, Axes::Right), (10, Axes::Oblique)] {
        let robot = read(&urdf(n, axes, 1, None), false);
        let base = regrouped(&robot);
        let of_robot = RobotFunction::words().filter_map(|(word, _)| RobotFunction::of_robot(word));
        let words: Vec<RobotFunction> = of_robot.filter(|word| word.check(&robot).is_ok()).collect();
        assert!(words.len() > 10, "{}", words.len());
        let main = format!(
            "static double tau[{n}];\n\
             int main(void) {{ int i; many_inverse_dynamics(q, dq, ddq, x, tau);\n\
             for (i = 0; i < {n}; i++) printf(\"%.17g\\n\", tau[i]);\nreturn 0; }}\n"
        );
        let (printed, expected) = printed_by_c(cc, (&robot, &base, &words), &main);
        let tau: Vec<f64> = printed.lines().map(|line| line.parse().unwrap()).collect();
        assert_eq!(tau.len(), n);
        let size = expected.iter().fold(0.0, |a: f64, b| a.max(b.abs()));
        // Rounding of thousands of terms.
        assert!(tau.iter().zip(&expected).all(|(a, b)| (a - b).abs() < 1e-11 * (1.0 + size)), "{tau:?} {expected:?}");
    }
}

#[test]
fn a_generated_regressor_of_sixty_joints_gives_the_torque() {
    let Some(cc) = compiler_of_c() else { return };
    let robot = read(&urdf(60, Axes::Right, 1, None), false);
    let base = regrouped(&robot);
    let word = RobotFunction::of_robot("base-regressor").unwrap();
    let (n, p) = (60, base.len());
    let main = format!(
        "static double y[{n}][{p}];\n\
         int main(void) {{ int i, k; many_base_regressor(q, dq, ddq, y);\n\
         for (i = 0; i < {n}; i++) {{ double tau = 0, size = 0; for (k = 0; k < {p}; k++) {{ tau += y[i][k] * x[k]; \
         size += y[i][k] * x[k] > 0 ? y[i][k] * x[k] : -y[i][k] * x[k]; }}\n\
         printf(\"%.17g %.17g\\n\", tau, size); }} return 0; }}\n"
    );
    let (printed, expected) = printed_by_c(cc, (&robot, &base, &[word]), &main);
    assert_eq!(printed.lines().count(), n);
    for (line, tau) in printed.lines().zip(expected) {
        let (found, size) = line.split_once(' ').unwrap();
        let (found, size): (f64, f64) = (found.parse().unwrap(), size.parse().unwrap());
        // The tolerance is for sums of thousands of terms, with rules for base parameters that add lengths over all links.
        assert!((found - tau).abs() <= 1e-12 * (1.0 + size), "{found} {tau}");
    }
}

/// A chain whose links are 1e15 m long. In double precision, rounding errors of the first links hide all effects of the last
/// links. So the derivation is refused.
#[test]
fn what_rounding_drowns_is_refused() {
    let link = |j: usize| {
        let antecedent = if j == 1 { "base".into() } else { (j - 1).to_string() };
        format!("  - {{link: {j}, antecedent: {antecedent}, alpha: 0.3, d: 1.0e15, theta: q{j}}}\n")
    };
    let links: String = (1..=25).map(link).collect();
    let text = format!("convention: khalil-kleinfinger\nname: long\nrotor_inertia: none\nlinks:\n{links}");
    let robot = read_yaml(&text, "long.yaml").unwrap();
    let refused = tests::try_base_parameters(&robot).map(|base| base.len());
    assert!(refused.is_err(), "{refused:?}");
}
