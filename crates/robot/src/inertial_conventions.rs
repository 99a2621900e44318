//! Finds values of a description that are possible but probably not intended: no masses, copies, limits without effect.

use std::f64::consts::PI;

use crate::body::Body;
use crate::body_doubt::shown;
use crate::finding::{Finding, Mistake};
use crate::robot::{Drive, JointKind, LinkId, Robot};

/// A position limit of at least this absolute value, rad or m, means that there is no limit.
const NO_LIMIT: f64 = 1e5;
/// If at least this number of bodies have the same mass and inertia, they count as copies of one body.
const FEWEST_COPIES: usize = 3;
/// Two full turns, rad. A larger position limit is probably in degrees, unless it is a number of half turns in rad.
pub const DEGREES_LIMIT_RAD: f64 = 4.0 * PI + 1e-6;
/// The last body of a branch is too light if its mass is below this fraction of the mass of the body before it.
const LIGHT_SHARE: f64 = 0.01;
/// Tolerance, in half turns, for a limit that is a rounded number of half turns: 31.4 rad is ten of them.
const HALF_TURN_SLACK: f64 = 0.01;
/// Largest usual deviation of the total mass from the mass in the data sheet, as a fraction of the mass in the data sheet.
const SHEET_SHARE: f64 = 0.05;

/// Adds the findings on masses and copies, and then the findings on the limits. `sheet`: mass of the data sheet, kg.
pub(crate) fn inertial_conventions(robot: &Robot, bodies: &[Body], sheet: Option<f64>, findings: &mut Vec<Finding>) {
    no_mass(robot, bodies, findings);
    copied(robot, bodies, findings);
    light(robot, bodies, findings);
    let total: f64 = bodies.iter().map(|body| body.mass).sum();
    if let Some(sheet) = sheet.filter(|sheet| (total - sheet).abs() > SHEET_SHARE * sheet) {
        let of_base: f64 = bodies.iter().filter(|body| body.link.is_none()).map(|body| body.mass).sum();
        let off = 100.0 * (total - sheet) / sheet;
        let text = format!("{total:.3} kg with the base of {of_base:.3} kg, {sheet} kg are expected ({off:+.0} %)");
        findings.push(Finding::new(
            &robot.name,
            Mistake::TotalMass,
            "the total mass is not that of the data sheet",
            text,
        ));
    }
    limits(robot, findings);
}

/// Finds bodies whose mass and inertia are all zero. A link without mass in the middle of a branch is usual, because several
/// joint axes may pass through one point.
fn no_mass(robot: &Robot, bodies: &[Body], findings: &mut Vec<Finding>) {
    let is_empty = |body: &Body| body.mass == 0.0 && body.given == [0.0; 6];
    let mut find = |body: &Body, mistake, fact| findings.push(Finding::new(&body.name, mistake, fact, ""));
    let is_useless = bodies.len() > 1 && bodies.iter().all(is_empty);
    let carried = |j: LinkId| bodies.iter().filter(move |body| body.link == Some(j));
    let mut mass: Vec<f64> = robot.link_ids().map(|j| carried(j).map(|body| body.mass).sum()).collect();
    for j in robot.link_ids().rev() {
        if let Some(i) = robot.link(j).antecedent {
            mass[i.0] += mass[j.0];
        }
    }
    for body in bodies.iter().filter(|body| is_empty(body)) {
        match body.link {
            _ if is_useless => {
                let fact = "no body has a mass: give the parts a material in the CAD program and export again";
                find(body, Mistake::NoMassAtAll, fact);
            }
            None if body.own => {
                find(body, Mistake::MasslessBase, "the base has no mass, which matters where it floats");
            }
            None => {}
            Some(j) if body.own && (body.has_shape || mass[j.0] == 0.0) => {
                find(body, Mistake::NoMass, "mass and inertia are 0");
            }
            Some(_) => {}
        }
    }
}

/// Finds the last bodies of branches that are far lighter than the body before them although their motor is as strong. Such a
/// body would be lighter than its screws.
fn light(robot: &Robot, bodies: &[Body], findings: &mut Vec<Finding>) {
    let mass = |j: LinkId| bodies.iter().filter(|body| body.link == Some(j)).map(|body| body.mass).sum::<f64>();
    let effort = |j: LinkId| match robot.link(j).joint.variable.terms[..] {
        [(k, _)] => robot.coordinates.get(k.0)?.limits.effort.filter(|effort| *effort > 0.0),
        _ => None,
    };
    for j in robot.link_ids() {
        let link = robot.link(j);
        let is_last = !robot.links.iter().any(|other| other.antecedent == Some(j));
        let (Some(before), true) = (link.antecedent, is_last) else { continue };
        let is_like = (link.joint.kind, JointKind::Revolute) == (robot.link(before).joint.kind, link.joint.kind);
        let is_strong = is_like && effort(before).zip(effort(j)).is_some_and(|(before, own)| own >= before);
        let (own, other) = (mass(j), mass(before));
        let is_known = findings.iter().any(|f| f.subjects.contains(&link.name));
        if is_strong && !is_known && own > 0.0 && own < LIGHT_SHARE * other {
            let fact = "the last body is far lighter than the one before it, and its motor is as strong";
            let text = format!("{} kg after {} kg", shown(own, 4), shown(other, 4));
            findings.push(Finding::new(&link.name, Mistake::MassBesideOthers, fact, text));
        }
    }
}

/// Finds out whether most bodies have the same mass and inertia. Equal bodies in different branches, such as rotors or fingers,
/// are usual.
fn copied(robot: &Robot, bodies: &[Body], findings: &mut Vec<Finding>) {
    let heavy: Vec<&Body> = bodies.iter().filter(|body| body.mass > 0.0).collect();
    let alike = |a: &Body| heavy.iter().filter(|b| (b.mass, b.given) == (a.mass, a.given)).count();
    let Some(most) = heavy.iter().rev().max_by_key(|body| alike(body)) else { return };
    let count = alike(most);
    let same = || heavy.iter().filter(|body| (body.mass, body.given) == (most.mass, most.given));
    let carries =
        |a: LinkId, b: LinkId| a != b && std::iter::successors(Some(b), |&j| robot.link(j).antecedent).any(|j| j == a);
    let links: Vec<LinkId> = same().filter_map(|body| body.link).collect();
    let is_chain = links.iter().any(|&a| links.iter().any(|&b| carries(a, b)));
    if count >= FEWEST_COPIES && 2 * count > heavy.len() && is_chain {
        let fact = format!(
            "{count} of {} bodies have one mass, {} kg, and one inertia: were they copied?",
            heavy.len(),
            most.mass
        );
        for body in same() {
            findings.push(Finding::new(&body.name, Mistake::Copied, fact.clone(), ""));
        }
    }
}

fn limits(robot: &Robot, findings: &mut Vec<Finding>) {
    for link in robot.links.iter().filter(|link| link.joint.drive == Drive::Actuated) {
        let [(k, _)] = link.joint.variable.terms[..] else { continue };
        let Some((low, high)) = robot.coordinates.get(k.0).and_then(|c| c.limits.position) else { continue };
        let farthest = low.abs().max(high.abs());
        let is_half_turns = [low, high].iter().all(|x| (x / PI - (x / PI).round()).abs() < HALF_TURN_SLACK);
        let fact = if low > high {
            "the lower limit is above its upper limit"
        } else if farthest >= NO_LIMIT {
            "the limits are no limits: a search for a motion takes them at their word"
        } else if link.joint.kind == JointKind::Revolute && farthest > DEGREES_LIMIT_RAD && !is_half_turns {
            "the limits are many turns in rad: are degrees meant?"
        } else {
            continue;
        };
        findings.push(Finding::new(&link.joint.name, Mistake::Limits, fact, format!("{low} and {high}")));
    }
}

#[cfg(test)]
mod tests {
    use crate::format::read_urdf;
    use crate::lint::{LintOptions, Mistake, Severity, lint, lint_with};

    fn found(inertial: &str, geometry: &str, limit: &str) -> Vec<Mistake> {
        let link = |name: &str| {
            let shape = if geometry.is_empty() { "".into() } else { format!("<collision>{geometry}</collision>") };
            format!("<link name=\"{name}\"><inertial>{inertial}</inertial>{shape}</link>")
        };
        let text = format!(
            "<robot name=\"r\"><link name=\"b\"/>{}<joint name=\"j\" type=\"revolute\"><parent link=\"b\"/><child link=\"a\"/>\
             <limit {limit} effort=\"1\" velocity=\"1\"/></joint></robot>",
            link("a")
        );
        sorted(&text)
    }

    /// The kinds of all findings on a URDF, without findings that are only notes.
    fn sorted(text: &str) -> Vec<Mistake> {
        let found = lint(&read_urdf(text, "r.urdf").unwrap());
        found.into_iter().map(|f| f.mistake).filter(|m| m.severity() != Severity::Note).collect()
    }

    fn body(mass: f64, centre: &str, i: f64) -> String {
        format!(
            "<origin xyz=\"{centre}\"/><mass value=\"{mass}\"/><inertia ixx=\"{i}\" ixy=\"0\" ixz=\"0\" iyy=\"{i}\" iyz=\"0\" \
             izz=\"{i}\"/>"
        )
    }

    const BOX: &str = "<geometry><box size=\"0.3 0.2 0.2\"/></geometry>";
    const LIMIT: &str = "lower=\"-2\" upper=\"2\"";

    #[test]
    fn each_habit_is_found_and_a_sound_body_has_none() {
        let mesh = "<geometry><mesh filename=\"a.stl\"/></geometry>";
        for (inertial, geometry, limit, wanted) in [
            (body(8.0, "0 0 0", 0.06), BOX, LIMIT, vec![]),
            (body(0.0, "0 0 0", 0.0), BOX, LIMIT, vec![Mistake::NoMass]),
            (body(0.0, "0 0 0", 0.0), "", LIMIT, vec![Mistake::NoMass]),
            (body(50.0, "0 0 0", 0.0), BOX, LIMIT, vec![Mistake::MassWithoutInertia]),
            (body(1.0, "0 0 0", 1.0), BOX, LIMIT, vec![Mistake::Placeholder]),
            (body(0.05, "0 0 0", 4e-4), BOX, LIMIT, vec![Mistake::Density]),
            (body(8.0, "1.5 0 0", 0.06), BOX, LIMIT, vec![Mistake::CentreOutside]),
            (body(8.0, "0 0 0", 16.0), BOX, LIMIT, vec![Mistake::Size]),
            (body(150.0, "0 0 0", 1e-4), mesh, LIMIT, vec![Mistake::Units]),
            (body(8.0, "1.5 0 0", 0.06), mesh, LIMIT, vec![]),
            (body(8.0, "0 0 0", 0.06), BOX, "lower=\"2\" upper=\"-2\"", vec![Mistake::Limits]),
            (body(8.0, "0 0 0", 0.06), BOX, "lower=\"-170\" upper=\"170\"", vec![Mistake::Limits]),
            (body(8.0, "0 0 0", 0.06), BOX, "lower=\"-31.4159\" upper=\"31.4159\"", vec![]),
            (body(8.0, "0 0 0", 0.06), BOX, "lower=\"-999999\" upper=\"999999\"", vec![Mistake::Limits]),
        ] {
            assert_eq!(found(&inertial, geometry, limit), wanted, "{inertial} {limit}");
        }
    }

    #[test]
    fn one_body_in_most_links_is_a_copy() {
        let text = |masses: [f64; 4]| {
            let mut text = "convention: craig\nname: r\nlinks:\n".to_string();
            for k in 1..=4 {
                let before = if k == 1 { "base".into() } else { (k - 1).to_string() };
                text += &format!("- {{link: {k}, antecedent: {before}, alpha: pi/2, a: 0.3, theta: q{k}}}\n");
            }
            text += "standard_parameters:\n";
            for (k, mass) in masses.into_iter().enumerate() {
                let body = format!("mass: {mass}, centre_of_mass: [0.1, 0, 0], inertia: {{xx: 0.1, yy: 0.1, zz: 0.1}}");
                text += &format!("  {}: {{{body}}}\n", k + 1);
            }
            text
        };
        let urdf = |masses| {
            let (text, _) = crate::format::write_urdf(&crate::format::read_yaml(&text(masses), "r.yaml").unwrap());
            sorted(&text)
        };
        assert_eq!(urdf([2.0, 2.0, 2.0, 5.0]), [Mistake::Copied]);
        assert_eq!(urdf([2.0, 2.0, 3.0, 5.0]), []);
    }

    /// An arm of four bodies with these masses, the base first. All bodies have the same inertia, which fits the masses.
    /// Efforts are 9 and 5 N m.
    fn arm(masses: [f64; 4], efforts: [f64; 3]) -> String {
        let mut text = "<robot name=\"r\">".to_string();
        for (k, mass) in masses.into_iter().enumerate() {
            let i = mass * 0.003;
            text += &format!("<link name=\"l{k}\"><inertial>{}</inertial></link>", body(mass, "0.02 0 0.1", i));
        }
        for (k, effort) in efforts.into_iter().enumerate() {
            text += &format!(
                "<joint name=\"j{k}\" type=\"revolute\"><parent link=\"l{k}\"/><child link=\"l{}\"/><origin xyz=\"0 0 0.2\"/>\
                 <axis xyz=\"0 1 0\"/><limit lower=\"-1\" upper=\"1\" effort=\"{effort}\" velocity=\"1\"/></joint>",
                k + 1
            );
        }
        text + "</robot>"
    }

    #[test]
    fn masses_are_compared_with_the_others() {
        let strong = [200.0; 3];
        assert_eq!(sorted(&arm([3.0, 2.0, 1.5, 0.8], strong)), []);
        assert_eq!(sorted(&arm([3.0, 2.0, 1.5, 42.9], strong)), [Mistake::MassBesideOthers]);
        assert_eq!(sorted(&arm([3.0, 2.0, 1.5, 0.007], strong)), [Mistake::MassBesideOthers]);
        // The last body is a finger with a weak motor, so its small mass is no mistake.
        assert_eq!(sorted(&arm([3.0, 2.0, 1.5, 0.007], [200.0, 200.0, 1.0])), []);
        assert_eq!(sorted(&arm([0.0; 4], strong)), [Mistake::NoMassAtAll]);
        assert_eq!(sorted(&arm([3.0, 2.0, 1.5, 0.0], strong)), [Mistake::NoMass]);
        // A link without mass in the middle of a branch is usual. A base without mass is usual too if it does not float.
        assert_eq!(sorted(&arm([0.0, 2.0, 0.0, 0.8], strong)), []);
    }

    #[test]
    fn the_total_mass_is_compared_with_the_sheet() {
        let robot = read_urdf(&arm([3.0, 2.0, 1.5, 0.8], [200.0; 3]), "r.urdf").unwrap();
        let found = |mass| lint_with(&robot, LintOptions { meshes: &|_| None, mass: Some(mass) });
        assert_eq!(found(7.5), []);
        let [finding] = &found(10.0)[..] else { panic!("{:?}", found(10.0)) };
        assert!(finding.text().contains("7.300 kg with the base of 3.000 kg, 10 kg are expected (-27 %)"), "{finding}");
    }
}
