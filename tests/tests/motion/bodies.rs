//! Tests that an exciting motion keeps the links apart from each other, and away from floor, walls and boxes. rist proves this.
//! The test compares the proof with dense samples and an independent geometry, and checks that changed files are refused.

use std::path::Path;

use experiments::excitation::artefact::ExcitingMotion;
use experiments::excitation::limits::LimitKind;
use experiments::excitation::proof::{CertificateRow, LimitProof};
use experiments::excitation::space_limits::Floor;
use rist::Model;
use rist::request::ExciteRequest;
use tests::has;
use tests::program::{self, Run, folder, rist as run};

/// An arm with three joints and links of half a metre. Each body is a capsule or cylinder, that is, a segment with a radius.
const ARM: &str = r#"<robot name="arm">
  <link name="post"><collision><origin xyz="0 0 0.2"/><geometry><capsule radius="0.08" length="0.4"/></geometry></collision></link>
  <joint name="turn" type="revolute"><parent link="post"/><child link="column"/><origin xyz="0 0 0.6"/><axis xyz="0 0 1"/>
    <limit lower="-3" upper="3" velocity="2" effort="100"/></joint>
  <link name="column"><inertial><mass value="2"/><inertia ixx="0.02" ixy="0" ixz="0" iyy="0.02" iyz="0" izz="0.01"/></inertial>
    <collision><geometry><sphere radius="0.06"/></geometry></collision></link>
  <joint name="lift" type="revolute"><parent link="column"/><child link="upper"/><axis xyz="0 1 0"/>
    <limit lower="-2" upper="2.5" velocity="2" effort="100"/></joint>
  <link name="upper"><inertial><origin xyz="0.25 0 0"/><mass value="3"/><inertia ixx="0.005" ixy="0" ixz="0" iyy="0.07" iyz="0" izz="0.07"/></inertial>
    <collision><origin xyz="0.25 0 0" rpy="0 1.5707963267948966 0"/><geometry><capsule radius="0.05" length="0.5"/></geometry></collision></link>
  <joint name="bend" type="revolute"><parent link="upper"/><child link="fore"/><origin xyz="0.5 0.02 0"/><axis xyz="0 1 0"/>
    <limit lower="-2.9" upper="2.9" velocity="3" effort="50"/></joint>
  <link name="fore"><inertial><origin xyz="0.2 0 0"/><mass value="1.5"/><inertia ixx="0.002" ixy="0" ixz="0" iyy="0.03" iyz="0" izz="0.03"/></inertial>
    <collision><origin xyz="0.25 0 0" rpy="0 1.5707963267948966 0"/><geometry><capsule radius="0.04" length="0.5"/></geometry></collision></link>
</robot>"#;

/// The required floor height, distance between links, and wall position, m.
const FLOOR: f64 = 0.05;
const DISTANCE: f64 = 0.03;
const WALL: f64 = 0.7;

const LIMITS: &str = "space:\n  floor: 0.05\n  distance: 0.03\n  walls: [{point: [0.7, 0, 0], normal: [-1, 0, 0]}]\n  boxes: \
                      [{low: [-1, -0.9, 0], high: [2, 0.9, 2], links: [fore]}]\n";

type Point = [f64; 3];

fn dot(a: Point, b: Point) -> f64 {
    tests::dot(&a, &b).0
}

/// Distance of two line segments, m. It is the minimum of a convex quadratic function over the unit square, at an inner point or
/// on an edge.
fn distance(a: [Point; 2], b: [Point; 2]) -> f64 {
    let minus = |a: Point, b: Point| [0, 1, 2].map(|k| a[k] - b[k]);
    let (u, v, w) = (minus(a[1], a[0]), minus(b[1], b[0]), minus(a[0], b[0]));
    let at = |s: f64, t: f64| {
        let d = [0, 1, 2].map(|k| w[k] + s * u[k] - t * v[k]);
        dot(d, d).sqrt()
    };
    let ratio = |x: f64, y: f64| if y > 0.0 { (x / y).clamp(0.0, 1.0) } else { 0.0 };
    let s_of = |t: f64| ratio(t * dot(u, v) - dot(u, w), dot(u, u));
    let t_of = |s: f64| ratio(s * dot(u, v) + dot(v, w), dot(v, v));
    let inside = dot(u, u) * dot(v, v) - dot(u, v).powi(2);
    let s = ratio(dot(u, v) * dot(v, w) - dot(v, v) * dot(u, w), inside);
    let edges = [
        (s_of(0.0), 0.0),
        (s_of(1.0), 1.0),
        (0.0, t_of(0.0)),
        (1.0, t_of(1.0)),
        (s, t_of(s)),
        (s_of(t_of(s)), t_of(s)),
    ];
    edges.into_iter().map(|(s, t)| at(s, t)).fold(f64::INFINITY, f64::min)
}

/// Segments of upper arm and forearm at these joint positions, m, computed independently from the numbers in `ARM`.
fn segments([turn, lift, bend]: Point) -> [[Point; 2]; 2] {
    let place = |across: f64, aside: f64, up: f64| {
        let (s, c) = turn.sin_cos();
        [c * across - s * aside, s * across + c * aside, 0.6 + up]
    };
    // A positive rotation about y moves x downwards.
    let (elbow_x, elbow_z) = (0.5 * lift.cos(), -0.5 * lift.sin());
    let (tip_x, tip_z) = (elbow_x + 0.5 * (lift + bend).cos(), elbow_z - 0.5 * (lift + bend).sin());
    let upper = [place(0.0, 0.0, 0.0), place(elbow_x, 0.0, elbow_z)];
    [upper, [place(elbow_x, 0.02, elbow_z), place(tip_x, 0.02, tip_z)]]
}

/// Checks that the last line of the output states what is proven, what is assumed and what is not checked.
fn the_last_line_tells_all(out: &str) {
    let last = out.trim_end().lines().last().unwrap();
    let said = [
        "proven, between samples too: position of 3, ",
        "distance of 4, floor of upper and of fore, region of ",
        "; floor at z = 0.05 m, lowest point 0.0",
        "; assumed: distance of upper and column and of fore and upper, margins; NOT looked at: approach and return",
    ];
    said.iter().for_each(|said| assert!(last.contains(said), "`{said}` is not in {last}"));
    assert!(!last.contains("BROKEN") && !out.contains("every limit"), "{out}");
}

#[test]
fn bodies_keep_their_distance_between_samples_too() {
    let folder = folder("bodies");
    std::fs::write(folder.join("arm.urdf"), ARM).unwrap();
    std::fs::write(folder.join("limits.yaml"), LIMITS).unwrap();
    let excite =
        ["excite", "arm.urdf", "--limits", "limits.yaml", "--period", "6", "--repetitions", "1", "--starts", "2"];
    let found = run(&folder, &[&excite[..], &["--iterations", "15", "--out", "motion.yaml"]].concat()).ended(0);
    the_last_line_tells_all(&found.out);
    let joined = "distance of upper and column, fore and upper: assumed by default: they touch in 99 % of 1000 poses";
    assert!(found.out.contains(joined), "{}", found.out);
    assert!(found.err.contains(" m above the "), "{}", found.err);
    let artefact = program::motion(&folder.join("motion.yaml"));
    let gaps: Vec<&str> =
        artefact.certificate.iter().filter(|r| r.limit == LimitKind::Distance).map(|r| r.subject.as_str()).collect();
    assert_eq!(gaps, ["column and post", "upper and post", "fore and post", "fore and column"]);
    assert!(
        artefact
            .certificate
            .iter()
            .any(|r| r.subject == "fore at the greatest y of the box" && r.kept == LimitProof::Proven)
    );

    // The least distances, computed with an independent geometry at a hundred times the sample rate.
    let motion = artefact.motion("motion.yaml").unwrap();
    let (post, column) = ([[0.0; 3], [0.0, 0.0, 0.4]], [[0.0, 0.0, 0.6]; 2]);
    let count = (motion.duration() * motion.rate * 100.0) as usize;
    let mut least = [f64::INFINITY; 4];
    for k in 0..=count {
        let state = motion.at(motion.duration() * k as f64 / count as f64);
        let [upper, fore] = segments([state[0][0], state[1][0], state[2][0]]);
        let near = [
            distance(upper, post) - 0.05 - 0.08 - DISTANCE,
            distance(fore, post).min(distance(fore, column) + 0.02) - 0.04 - 0.08 - DISTANCE,
            upper.iter().map(|p| p[2] - 0.05).chain(fore.iter().map(|p| p[2] - 0.04)).fold(f64::INFINITY, f64::min)
                - FLOOR,
            WALL - upper.iter().map(|p| p[0] + 0.05).chain(fore.iter().map(|p| p[0] + 0.04)).fold(0.0, f64::max),
        ];
        (0..4).for_each(|i| least[i] = least[i].min(near[i]));
        assert!(fore.iter().all(|p| p[1].abs() <= 0.86), "{fore:?}");
    }
    assert!(least.iter().all(|x| *x >= 0.0), "{least:?}");

    // The check proves the motion again and does not trust the certificate in the file.
    assert_eq!(run(&folder, &["check", "arm.urdf", "motion.yaml"]).code, Some(0));
    let broken = |name: &str, change: &dyn Fn(&mut ExcitingMotion), said: &str| {
        let mut artefact = artefact.clone();
        change(&mut artefact);
        std::fs::write(folder.join(name), artefact.to_yaml().unwrap()).unwrap();
        run(&folder, &["check", "arm.urdf", name]).failed(1, &[said]);
    };
    let reached = |limit: LimitKind, subject: &str| {
        artefact.certificate.iter().find(|r| r.limit == limit && r.subject == subject).unwrap().value
    };
    let farther = reached(LimitKind::Distance, "fore and post") + 0.001;
    broken("distance.yaml", &|m| m.space.distance = Some(farther), "distance of fore and post: ");
    let higher = FLOOR + reached(LimitKind::Region, "fore at the floor") + 0.001;
    broken("floor.yaml", &|m| m.space.floor = Some(Floor::At(higher)), "region of fore at the floor: -0.00");
    broken("wall.yaml", &|m| m.space.walls[0].point[0] = 0.2, "at the wall: -");
    broken("lower.yaml", &|m| m.joints[1].centre += 1.5, " is beyond ");
}

#[test]
fn impossible_rooms_get_an_answer() {
    let folder = folder("bodies_impossible");
    std::fs::write(folder.join("arm.urdf"), ARM).unwrap();
    let quick = ["--starts", "1", "--iterations", "2"];
    for (limits, said) in [
        ("space: {floor: 0.62}", "column is 0.0800 m beyond the floor, and no joint that is not locked moves it away"),
        ("space: {floor: 3, walls: []}\ncoordinates: {}", "beyond the floor"),
        (
            "space: {boxes: [{low: [5, 5, 0], high: [6, 6, 2], links: [fore]}]}",
            "broken are region of fore at the least x of the box (0 m) in 300, ",
        ),
        (
            "space: {floor: 0, walls: [{point: [1, 0, 0], normal: [-1, 0, 0], links: [hand]}]}",
            "there is no link `hand`",
        ),
        ("space: {distance: 0.8}", "of 300 poses within the limits 0 keep all of them; broken are distance of "),
        ("space: {distance: .nan}", "space: distance is NaN"),
    ] {
        std::fs::write(folder.join("limits.yaml"), limits).unwrap();
        let found =
            run(&folder, &[&["excite", "arm.urdf", "--limits", "limits.yaml"][..], &quick[..]].concat()).ended(2);
        assert!(found.err.contains(said), "{limits}: {}", found.err);
    }
    // If the mesh file of a link is missing, the output contains the path of the file, and makes no claim about this link.
    let text = ARM.replace("<capsule radius=\"0.04\" length=\"0.5\"/>", "<mesh filename=\"package://arm/fore.stl\"/>");
    let model = Model::parse(&text, Path::new("nowhere/arm.urdf"), &Default::default()).unwrap();
    let request = ExciteRequest { starts: 1, iterations: 2, period: Some(6.0), ..ExciteRequest::default() };
    let found = rist::excite(&model, &request, &|_, _, _| ()).unwrap();
    let said = found.claims().left_out_sentences();
    let unread = "not looked at, because mesh package://arm/fore.stl: there is no";
    for subject in ["distance of fore: ", "floor of fore: "] {
        assert!(said.iter().any(|s| s.starts_with(&format!("{subject}{unread}"))), "{subject}: {said:?}");
    }
    assert!(found.certificate.iter().all(|r| !r.subject.starts_with("fore ")));
    assert!(found.proven && found.to_string().contains("NOT looked at: distance of fore, floor of fore"));
    // If the user asks for a distance or floor, a missing mesh is an error: the search is refused and the check fails.
    std::fs::write(folder.join("unread.urdf"), text).unwrap();
    std::fs::write(folder.join("motion.yaml"), ExcitingMotion::to_yaml(&found).unwrap()).unwrap();
    for (limits, subject) in [
        ("space: {floor: 0}", "floor of fore: not looked at, because mesh"),
        ("space: {distance: 0.02}", "distance of fore: not looked at, because mesh"),
        ("space: {walls: [{point: [3, 0, 0], normal: [-1, 0, 0]}]}", "region of fore at the wall: not looked at"),
    ] {
        std::fs::write(folder.join("limits.yaml"), limits).unwrap();
        run(&folder, &[&["excite", "unread.urdf", "--limits", "limits.yaml"][..], &quick[..]].concat())
            .failed(2, &[subject]);
        run(&folder, &["check", "unread.urdf", "motion.yaml", "--limits", "limits.yaml"]).failed(1, &[subject]);
    }
    // If the user asks for no distance, floor or wall, the missing mesh is only reported.

    run(&folder, &["check", "unread.urdf", "motion.yaml"]).told(0, &["NOT looked at: distance of fore"]);
}

/// By default the floor is the plane z = 0 of the base. The user can state that there is none, and can accept a pair of links.
#[test]
fn what_a_user_signs_is_said() {
    let folder = folder("bodies_signed");
    std::fs::write(folder.join("arm.urdf"), ARM).unwrap();
    let run = |limits: &str, more: &[&str]| {
        std::fs::write(folder.join("limits.yaml"), limits).unwrap();
        run(&folder, &[&more[..1], &["arm.urdf", "--limits", "limits.yaml"], &more[1..]].concat())
    };
    let quick = ["excite", "--starts", "1", "--iterations", "2", "--period", "6", "--out", "motion.yaml"];
    let last = |out: &str| out.trim_end().lines().last().unwrap_or_default().to_string();
    let plain = run("{}", &quick);
    assert!(last(&plain.out).contains("; floor at z = 0 m, lowest point 0."), "{}{}", plain.out, plain.err);
    assert!(!last(&plain.out).contains("no floor"));
    let limits = "space: {floor: none, accept: [[fore, post, the forearm is soft]]}";
    let signed = run(limits, &quick);
    let end = last(&signed.out);
    has(&end, &["; no floor, lowest point ", "assumed: distance of 3, floor, margins;"]);
    has(&signed.out, &["distance of fore and post: assumed by the user: the forearm is soft\n"]);
    assert!(signed.out.contains("floor: assumed by the user: nothing stands below the robot (floor: none)\n"));
    assert!(!signed.out.contains("distance        4 of "), "{}", signed.out);
    // A motion file may contain exceptions, such as a pair of links that is not checked. They count only if the limits file of
    // the user repeats them.
    run(limits, &["check", "motion.yaml"]).ended(0);
    let check = run("{}", &["check", "motion.yaml"]);
    assert!(check.out.contains("note: the motion's own file leaves out pairs of links or the floor"), "{}", check.out);
    assert!(check.out.contains("distance        ") && check.out.contains("fore and post"), "{}", check.out);

    run("space: {accept: [[fore, post]]}", &quick).failed(2, &["expected are two links and the reason"]);
}

/// The check uses the limits that the present version of rist requires, and not only the limits in the motion file. If the
/// certificate in the file lacks limits, as in files of earlier versions, they are checked and named.
#[test]
fn beyond_own_list() {
    let folder = folder("bodies_beyond");
    std::fs::write(folder.join("arm.urdf"), ARM).unwrap();
    let made = ["--starts", "1", "--iterations", "2", "--period", "6", "--limits", "none.yaml", "--out", "motion.yaml"];
    std::fs::write(folder.join("none.yaml"), "space: {floor: none, distance: 0.001}").unwrap();
    run(&folder, &[&["excite", "arm.urdf"][..], &made].concat()).ended(0);
    let motion = program::motion(&folder.join("motion.yaml"));
    let of = |file: &str| run(&folder, &["check", "arm.urdf", file]);
    let said = "the motion's own file did not look at these, and is held to them here: ";
    let whole = of("motion.yaml");
    assert!(whole.out.contains(said) && whole.out.contains("fore at the floor"), "{}", whole.out);
    let without_floor = run(&folder, &["check", "arm.urdf", "motion.yaml", "--limits", "none.yaml"]);
    assert!(!without_floor.out.contains(said), "{}", without_floor.out);
    // If rows are deleted from the certificate, the check proves the same limits, or finds the same limits broken.
    let is_kept = |row: &CertificateRow| !matches!(row.limit, LimitKind::Distance | LimitKind::Region);
    let mut bare = motion.clone();
    bare.certificate.retain(is_kept);
    bare.left_out = None;
    std::fs::write(folder.join("bare.yaml"), bare.to_yaml().unwrap()).unwrap();
    let bare = of("bare.yaml");
    assert!(bare.out.contains(said) && bare.out.contains("fore and post, "), "{}", bare.out);
    let end = |run: &Run| run.out.trim_end().lines().last().unwrap_or_default().to_string();
    assert_eq!((end(&bare), bare.code), (end(&whole), whole.code));
}
