//! Estimates the time and memory that the derivation of a robot needs, before it starts.
//!
//! n: number of coordinates; p: number of standard parameters; E: number of non-zero entries of the regressor (the parameters
//! of a link have entries in the row of each coordinate that moves the link); S = 3 p/n + 8: number of states for the numeric
//! rank; m_b: number of passive coordinates that are solved together in block b; L: number of loops. Then the work is
//!
//! ```text
//! time    17 us E + 0.4 ns p^3 + S T sum_b (1 us m_b + 1 ns m_b^3) + 0.5 ms L^3
//! memory  1300 B E + 16 B S n p + 8 B (p^2 + 14 n p)
//! ```
//! T is the number of evaluations of the loops for each state. The term with L is the time of the exact rank and of the closed
//! forms. The factors were measured with `rist inspect` on chains and trees of 30 to 200 links, on four-bars in series and on a
//! Gough-Stewart platform, on one core of a server of 2024. Estimates above half a second were within a factor of 1.7. The closed
//! forms of coupled fingers are not included: a humanoid with hands took 1.2 s, ten times the estimate.

use std::collections::BTreeSet;
use std::fmt;

use robot::value::CoordinateId;
use robot::{LinkId, Robot, StandardParameter};

/// An estimate of the time and memory of the derivation of a robot.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Size {
    /// Estimated time of the derivation, s.
    pub seconds: f64,
    /// Estimated memory of the derivation, B (bytes).
    pub bytes: f64,
    links: usize,
    parameters: usize,
}

/// Number T of evaluations of the loop closure for one state: steps of the path times evaluations per step.
const EVALUATIONS_PER_STATE: f64 = 150.0;
/// If the estimated time of a derivation exceeds this time, s, the user is asked before the derivation starts. The estimate may
/// be wrong by a factor of 1.7, so no derivation above 10 s starts without a question.
const SURPRISING_TIME_S: f64 = 10.0 / 1.7;
/// Memory of a small machine, B. If a derivation needs more, the user is asked before the derivation starts.
const SMALL_MACHINE_BYTES: f64 = (1u64 << 30) as f64;

impl Size {
    /// Estimates time and memory for the regressor and the base parameters of `robot`.
    pub fn of(robot: &Robot) -> Size {
        let parameters = StandardParameter::all(robot);
        let moved = moved(robot);
        let entries: usize = parameters.iter().map(|p| moved[p.link.0].len()).sum();
        let (n, p, entries) = (robot.n_coordinates().max(1) as f64, parameters.len() as f64, entries as f64);
        let states = 3.0 * (p / n).ceil() + 8.0;
        let solved: f64 = together(robot).iter().map(|&m| m as f64).map(|m| 1e-6 * m + 1e-9 * m.powi(3)).sum();
        Size {
            seconds: 17e-6 * entries
                + 0.4e-9 * p.powi(3)
                + states * EVALUATIONS_PER_STATE * solved
                + 0.5e-3 * (robot.loops.len() as f64).powi(3),
            bytes: 1300.0 * entries + 16.0 * states * n * p + 8.0 * (p * p + 14.0 * n * p),
            links: robot.links.len(),
            parameters: parameters.len(),
        }
    }

    /// Whether the time or the memory is so large that the user should be asked before the derivation.
    pub fn is_large(&self) -> bool {
        self.seconds > SURPRISING_TIME_S || self.bytes > SMALL_MACHINE_BYTES
    }
}

impl fmt::Display for Size {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(
            f,
            "the derivation of {} links with {} standard parameters takes about {:.0} s and {:.1} GiB",
            self.links,
            self.parameters,
            self.seconds.ceil(),
            self.bytes / SMALL_MACHINE_BYTES
        )
    }
}

/// For each link, the indices of the coordinates that move it. A passive coordinate may depend on any coordinate, so it counts
/// as all coordinates.
fn moved(robot: &Robot) -> Vec<BTreeSet<usize>> {
    let n = robot.n_coordinates();
    let mut moved: Vec<BTreeSet<usize>> = Vec::with_capacity(robot.links.len());
    for link in &robot.links {
        let mut own = link.antecedent.map_or(BTreeSet::new(), |LinkId(i)| moved[i].clone());
        for &(CoordinateId(k), _) in &link.joint.variable.terms {
            if k < n { own.extend([k]) } else { own.extend(0..n) }
        }
        moved.push(own);
    }
    moved
}

/// The number of passive coordinates of each group of loops. Loops that share passive coordinates are in one group.
fn together(robot: &Robot) -> Vec<usize> {
    let n = robot.n_coordinates();
    let mut groups: Vec<BTreeSet<usize>> = Vec::new();
    for one in &robot.loops {
        let mut passive = BTreeSet::new();
        let [cut, twin] = [&one.cut, &one.twin]
            .map(|frame| std::iter::successors(frame.antecedent, |&j| robot.link(j).antecedent).collect::<Vec<_>>());
        let on_one_side = cut.iter().filter(|j| !twin.contains(j)).chain(twin.iter().filter(|j| !cut.contains(j)));
        let joints = on_one_side.map(|&j| &robot.link(j).joint.variable).chain([&one.cut.variable, &one.twin.variable]);
        passive.extend(joints.flat_map(|v| &v.terms).map(|(k, _)| k.0).filter(|&k| k >= n));
        let (met, mut others): (Vec<_>, Vec<_>) = groups.into_iter().partition(|g| !g.is_disjoint(&passive));
        met.into_iter().for_each(|group| passive.extend(group));
        others.push(passive);
        groups = others;
    }
    groups.iter().map(BTreeSet::len).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn chain(links: usize) -> Robot {
        let link = |j: usize| {
            let antecedent = if j == 1 { "base".into() } else { (j - 1).to_string() };
            format!("  - {{link: {j}, antecedent: {antecedent}, alpha: pi/2, d: 0.1, theta: q{j}}}\n")
        };
        let links: String = (1..=links).map(link).collect();
        let text = format!("convention: khalil-kleinfinger\nname: chain\nrotor_inertia: none\nlinks:\n{links}");
        robot::format::read_yaml(&text, "chain.yaml").unwrap()
    }

    #[test]
    fn a_hundred_and_twenty_joints_pass_and_three_hundred_do_not() {
        assert!(!Size::of(&chain(6)).is_large());
        assert!(!Size::of(&chain(80)).is_large());
        assert!(!Size::of(&chain(120)).is_large());
        let large = Size::of(&chain(300));
        assert!(large.is_large());
        let text = large.to_string();
        assert!(text.contains("300 links with 3000 standard parameters") && text.contains("GiB"), "{text}");
    }

    #[test]
    fn loops_that_share_passive_joints_are_solved_together() {
        let four_bar = |k: usize, base: &str| {
            format!(
                "  - {{link: a{k}, antecedent: {base}, theta: q{k}}}
  - {{link: b{k}, antecedent: a{k}, drive: passive, joint: revolute, d: 0.2, start: -0.7}}
  - {{link: c{k}, antecedent: {base}, drive: passive, joint: revolute, d: 0.5, start: 0.7}}
"
            )
        };
        let text = format!(
            "convention: khalil-kleinfinger\nname: two\ncoordinates: [q1, q2]\nlinks:\n{}{}loops:\n{}{}",
            four_bar(1, "base"),
            four_bar(2, "b1"),
            "  - {cut: {antecedent: b1, joint: revolute, d: 0.55, start: 0.1}, twin: {antecedent: c1, d: 0.4}}\n",
            "  - {cut: {antecedent: b2, joint: revolute, d: 0.55, start: 0.1}, twin: {antecedent: c2, d: 0.4}}\n",
        );
        let robot = robot::format::read_yaml(&text, "two.yaml").unwrap();
        // Each loop has only two independent passive coordinates: in a planar loop, the angle of the cut joint follows from the
        // other angles.
        assert_eq!(together(&robot), [2, 2]);
    }
}
