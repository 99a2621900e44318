//! Tables of Denavit and Hartenberg and of Craig, in degrees and millimetres, give the same robot as a table of Khalil.

mod recursion;

use robot::format::read_yaml;
use robot::{Pose, Robot};

fn read(text: &str) -> Robot {
    read_yaml(text, "arm.yaml").unwrap_or_else(|e| panic!("{e}\n{text}"))
}

/// theta d a alpha of four joints, rad and m. The third joint is prismatic.
const ROWS: [[f64; 4]; 4] =
    [[0.3, 0.4, 0.1, -0.7], [-0.2, 0.15, 0.5, 0.4], [0.9, 0.2, -0.3, 1.1], [0.0, -0.25, 0.2, -1.3]];
/// Mass, kg, and position, m, of the three points of each body, in the frame at the far end of its link.
const POINTS: [(f64, [f64; 3]); 3] = [(1.5, [0.1, 0.2, -0.3]), (0.4, [-0.5, 0.1, 0.7]), (2.0, [0.3, -0.6, 0.2])];

/// XX .. M of the points, about the origin of a frame a and in its axes. `pose`: pose in a of the frame in which the points are
/// given.
fn sums(pose: &Pose) -> [f64; 10] {
    let mut x = [0.0; 10];
    for (m, p) in POINTS {
        let p = [0, 1, 2].map(|i| pose.position[i] + (0..3).map(|k| pose.rotation[i][k] * p[k]).sum::<f64>());
        let square: f64 = p.iter().map(|p| p * p).sum();
        let e = |i: usize, j: usize| m * (if i == j { square } else { 0.0 } - p[i] * p[j]);
        let of = [e(0, 0), e(0, 1), e(0, 2), e(1, 1), e(1, 2), e(2, 2), m * p[0], m * p[1], m * p[2], m];
        (0..10).for_each(|k| x[k] += of[k]);
    }
    x
}

/// The pose Tx(a) Rx(alpha) of the frame at the far end of a link.
fn far_end([_, _, a, alpha]: [f64; 4]) -> Pose {
    let (s, c) = alpha.sin_cos();
    Pose { rotation: [[1.0, 0.0, 0.0], [0.0, c, -s], [0.0, s, c]], position: [a, 0.0, 0.0] }
}

fn parameters(label: usize, x: [f64; 10]) -> String {
    let names = ["XX", "XY", "XZ", "YY", "YZ", "ZZ", "MX", "MY", "MZ", "M"];
    let entries: Vec<String> = names.iter().zip(x).map(|(name, x)| format!("{name}: {x}")).collect();
    format!("  {label}: {{{}}}\n", entries.join(", "))
}

/// The arm, read from a YAML text. `row`: the placement keys of link k. `body`: the parameters of link k.
fn arm(head: &str, row: impl Fn(usize) -> String, body: impl Fn(usize) -> String) -> Robot {
    let mut text = format!("{head}\nname: arm\nrotor_inertia: none\nlinks:\n");
    for k in 1..=4 {
        let before = if k == 1 { "base".into() } else { (k - 1).to_string() };
        let joint = if k == 3 { "prismatic" } else { "revolute" };
        text += &format!("- {{link: {k}, antecedent: {before}, joint: {joint}, {}}}\n", row(k));
    }
    text += "standard_parameters:\n";
    (1..=4).for_each(|k| text += &body(k));
    read(&text)
}

fn same(a: &Robot, b: &Robot) {
    for k in 0..4 {
        let state = |shift: f64| -> Vec<f64> { (0..4).map(|j| (f64::from(j + 3 * k) * 1.7 + shift).sin()).collect() };
        let (q, dq, ddq) = (state(0.2), state(1.1), state(2.3));
        let (x, y) = (recursion::torque(a, &q, &dq, &ddq), recursion::torque(b, &q, &dq, &ddq));
        let scale = x.iter().fold(1e-3, |s: f64, x| s.max(x.abs()));
        for (x, y) in x.iter().zip(&y) {
            // Allowance for the rounding of two chains of frames.
            assert!((x - y).abs() <= 1e-12 * scale, "{x} {y}");
        }
    }
}

/// theta and d of row k as text, in the units of the table. The joint variable among them contains the coordinate `q{k}`.
fn moving(k: usize, angle: f64, length: f64) -> [String; 2] {
    let of = |x: f64, moves: bool| if moves { format!("q{k} + {x}") } else { x.to_string() };
    [of(angle, k != 3), of(length, k == 3)]
}

fn khalil(k: usize) -> String {
    let [theta, d, ..] = ROWS[k - 1];
    let [theta, r] = moving(k, theta, d);
    let [_, _, a, alpha] = if k == 1 { [0.0; 4] } else { ROWS[k - 2] };
    format!("alpha: {alpha}, d: {a}, theta: {theta}, r: {r}")
}

#[test]
fn a_table_of_denavit_and_hartenberg_is_that_of_khalil_with_its_bodies_moved() {
    let wanted = arm("convention: khalil-kleinfinger", khalil, |k| parameters(k, sums(&far_end(ROWS[k - 1]))));
    let standard = |k: usize| {
        let [theta, d, a, alpha] = ROWS[k - 1];
        let [theta, d] = moving(k, theta, d);
        format!("theta: {theta}, d: {d}, a: {a}, alpha: {alpha}")
    };
    let own = |k: usize| parameters(k, sums(&Pose::IDENTITY));
    for word in ["denavit-hartenberg", "standard", "paul"] {
        let found = arm(&format!("convention: {word}"), standard, own);
        same(&found, &wanted);
        // The file frames of the links must equal the frames A_1 A_2 .. A_k that follow from the table.
        let q = [0.2, -0.4, 0.1, 0.7];
        let mut place = Pose::IDENTITY;
        for (j, [theta, d, a, alpha]) in ROWS.into_iter().enumerate() {
            let (theta, d) = if j == 2 { (theta, d + q[j]) } else { (theta + q[j], d) };
            let (s, c) = theta.sin_cos();
            let near = Pose { rotation: [[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]], position: [0.0, 0.0, d] };
            place = place.compose(&near).compose(&far_end([theta, d, a, alpha]));
            let frame = found.link_poses(&q)[j].compose(&found.links[j].file_frame);
            for i in 0..3 {
                assert!((frame.position[i] - place.position[i]).abs() < 1e-14);
                assert!((0..3).all(|k| (frame.rotation[i][k] - place.rotation[i][k]).abs() < 1e-14));
            }
        }
    }
    let craig = |k: usize| khalil(k).replace("d: ", "a: ").replace("r: ", "d: ");
    let found = arm("convention: craig", craig, |k| parameters(k, sums(&far_end(ROWS[k - 1]))));
    same(&found, &wanted);
}

#[test]
fn degrees_millimetres_and_centres_of_mass_are_converted() {
    let degrees = |k: usize| {
        let [theta, d, a, alpha] = ROWS[k - 1];
        let [theta, d] = moving(k, theta.to_degrees(), 1000.0 * d);
        format!(
            "theta: {theta}, d: {d}, a: {}, alpha: {}, limits: {{position: [-90, 180]}}",
            1000.0 * a,
            alpha.to_degrees()
        )
    };
    let x = sums(&Pose::IDENTITY);
    let body = |k: usize| {
        let centre = [0, 1, 2].map(|i| x[6 + i] / x[9]);
        let square: f64 = centre.iter().map(|c| c * c).sum();
        let names = ["xx", "xy", "xz", "yy", "yz", "zz"];
        let pairs = [(0, 0), (0, 1), (0, 2), (1, 1), (1, 2), (2, 2)];
        let about = names.iter().zip(pairs).zip(x).map(|((name, (i, j)), x0)| {
            let shift = if i == j { square } else { 0.0 } - centre[i] * centre[j];
            format!("{name}: {}", x0 - x[9] * shift)
        });
        let about: Vec<String> = about.collect();
        let mm: Vec<String> = centre.iter().map(|c| (1000.0 * c).to_string()).collect();
        format!("  {k}: {{mass: {}, centre_of_mass: [{}], inertia: {{{}}}}}\n", x[9], mm.join(", "), about.join(", "))
    };
    let found = arm("convention: denavit-hartenberg\nangles: deg\nlengths: mm", degrees, body);
    let wanted = arm("convention: khalil-kleinfinger", khalil, |k| parameters(k, sums(&far_end(ROWS[k - 1]))));
    same(&found, &wanted);
    let limits = |k: usize| found.coordinates[k].limits.position.unwrap();
    let pi = std::f64::consts::PI;
    assert!((limits(0).0 + pi / 2.0).abs() < 1e-15 && (limits(2).1 - 0.18).abs() < 1e-15);
    // A right angle in degrees is read as an exact multiple of pi.
    let right = read(
        "convention: craig\nangles: deg\nname: r\nlinks: [{link: 1, antecedent: base, alpha: -90, theta: q1 + 270}]\n",
    );
    assert_eq!(right.links[0].geometry.alpha.as_multiple_of_pi(&[]), Some((-1, 2)));
    assert_eq!(right.links[0].geometry.theta.as_multiple_of_pi(&[]), Some((3, 2)));
    // A symbol has the unit of the place where it is used: degrees in an angle, millimetres in a length.
    let symbol = read(
        "convention: craig\nangles: deg\nlengths: mm\nname: r\nsymbols: {A: 30, L: 250}\nlinks: [{link: 1, antecedent: base, \
         alpha: A, a: L, theta: q1 - 2*A}]\n",
    );
    let g = &symbol.links[0].geometry;
    let found = [&g.alpha, &g.d, &g.theta].map(|v| v.number(&symbol.symbols));
    assert!([pi / 6.0, 0.25, -pi / 3.0].iter().zip(found).all(|(a, b)| (a - b).abs() < 1e-15), "{found:?}");
}

#[test]
fn what_is_likely_another_unit_or_table_is_refused_with_the_remedy() {
    let link = |head: &str, row: &str| {
        let text = format!("{head}\nname: r\nlinks:\n- {{link: 1, antecedent: base, {row}}}\n");
        read_yaml(&text, "r.yaml").map(|r| r.notes).map_err(|e| e.to_string())
    };
    for (head, row, wanted) in [
        ("convention: khalil-kleinfinger", "theta: q1 - 90", "theta of link 1 is -90.0000 rad"),
        ("convention: craig\nangles: deg", "theta: q1 - 900", "write it within one turn"),
        ("convention: craig", "r: 0.1, theta: q1", "unknown key `r` in a link"),
        ("convention: craig\nangles: degrees", "theta: q1", "`angles` is rad or deg"),
    ] {
        let message = link(head, row).unwrap_err();
        assert!(message.contains(wanted), "{message}");
    }
    let notes = link("convention: khalil-kleinfinger", "theta: q1, r: 400").unwrap();
    assert_eq!(notes[0].text, "a length of it is 400 m: millimetres are read with `lengths: mm`");
    // A symbol has no fixed value, so an expression with a symbol is accepted even if its angle exceeds a full turn.
    let generic = "convention: khalil-kleinfinger\nsymbols: {A: 7}";
    assert_eq!(link(generic, "theta: q1 + A").unwrap(), []);
    let both = "convention: craig\nname: r\nlinks: [{link: 1, antecedent: base, theta: q1}]\nstandard_parameters: {1: {mass: 1, \
                centre_of_mass: [0, 0, 0], XX: 1}}\n";
    assert!(read_yaml(both, "r.yaml").unwrap_err().message.contains("one of them"));
    let cut = "convention: standard\nname: r\nlinks: [{link: 1, antecedent: base, theta: q1}]\nloops: []\n";
    assert!(read_yaml(cut, "r.yaml").unwrap_err().message.contains("loops are written with"));
}
