//! A planar loop in the field, closed by solving for two or three of its variables.
//!
//! As in `robot`'s polygon, every rigid side is a vector of the plane that is turned by the angles before it; a sliding
//! joint lengthens its side:
//!
//! ```text
//! sum_k (a_k + sum_j s_j u_kj) exp(i Phi_k) = 0,      Phi_cut - Phi_twin = delta
//! ```
//! The second equation gives one angle by a sum. With all variables known but two, the sides fall into groups of one
//! unknown angle each, and the first equation is
//!
//! - two angles, three groups: a triangle of known sides, v_0 + v_1 exp(i psi_1) + v_2 exp(i psi_2) = 0. From
//!   |v_0 + v_1 exp(i psi_1)|^2 = |v_2|^2 follows a cos psi_1 + b sin psi_1 = c;
//! - one angle, one length, two groups: |a_0 + s u_0|^2 = |a_1 + s u_1|^2, quadratic in s;
//! - two lengths: linear.

use std::collections::BTreeMap;

use robot::JointKind;

use crate::base::closed::pose::{Pose, column, dot, product, transposed, turned};
use crate::base::closed::variables::{Powers, State, Variables, on_the_circle, quotient, raised};
use crate::base::field::{Point, Residue, solve, turned as sum};
use crate::kinematics::loop_chain::ChainJoint;

type Flat = [Residue; 2];

/// One loop at given constants.
#[derive(Clone, Debug)]
pub(crate) struct PlanarLoop {
    sides: Vec<Side>,
    turn: Powers,
    delta: Point,
    /// How far the ends are apart across the plane: zero where the loop can close.
    pub offset: Residue,
}

#[derive(Clone, Debug)]
struct Side {
    vector: Flat,
    slides: Vec<(usize, Flat)>,
    turn: Powers,
}

/// What came of an attempt to close a loop.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Closing {
    Closed,
    /// The roots that close it are not in the field.
    NoRoot,
    /// These variables cannot be solved for in this way.
    OtherForm,
}

impl PlanarLoop {
    /// `None` where its joints do not all move in one plane. `placements` and `joints` by link.
    pub fn new(
        variables: &Variables,
        placements: &[Pose],
        joints: &[ChainJoint],
        branches: &[Vec<usize>; 2],
    ) -> Option<PlanarLoop> {
        let [cut, twin] = [0, 1].map(|b| Branch::new(variables, placements, joints, &branches[b]));
        let revolute = |j: &&Joint| j.kind == JointKind::Revolute;
        // The frame of the first revolute joint: its z is the normal of the plane.
        let frame = transposed(&cut.joints.iter().chain(&twin.joints).find(revolute)?.at.rotation);
        let mut sides = Vec::new();
        let (outward, phi_cut) = cut.sides(&frame)?;
        let (back, phi_twin) = twin.sides(&frame)?;
        sides.extend(outward);
        sides.extend(back.into_iter().map(Side::reversed));

        let between = product(&twin.end.rotation, &transposed(&cut.end.rotation));
        let between = product(&product(&frame, &between), &transposed(&frame));
        if between[2][2] != Residue::ONE {
            return None;
        }
        let across = |pose: &Pose| turned(&frame, pose.position)[2];
        Some(PlanarLoop {
            sides,
            turn: added(&phi_cut, &phi_twin, -1),
            delta: (between[0][0], between[1][0]),
            offset: across(&twin.end) - across(&cut.end),
        })
    }

    /// The variables of the loop that are not known.
    pub fn unknown(&self, state: &State) -> Vec<usize> {
        let of_side = |s: &Side| s.turn.iter().map(|t| t.0).chain(s.slides.iter().map(|t| t.0)).collect::<Vec<_>>();
        let mut all: Vec<usize> = self
            .turn
            .iter()
            .map(|t| t.0)
            .chain(self.sides.iter().flat_map(of_side))
            .filter(|&k| !state.knows(k))
            .collect();
        all.sort_unstable();
        all.dedup();
        all
    }

    /// The defect of the orientation where all its angles are known.
    pub fn defect(&self, state: &State) -> Option<Point> {
        let (known, rest) = state.turn(&self.turn);
        let (c, s) = self.delta;
        rest.is_empty().then(|| sum(known, (c, -s)))
    }

    /// How many variables close it, given what is known.
    pub fn n_solved(&self, state: &State) -> usize {
        2 + usize::from(!state.turn(&self.turn).1.is_empty())
    }

    /// Closes the loop by these variables; all others are known.
    pub fn close(&self, variables: &Variables, state: &mut State, by: &[usize], other_root: bool) -> Closing {
        let angles: Vec<usize> = by.iter().copied().filter(|&k| variables.may_be_solved_as_angle(k)).collect();
        let lengths: Vec<usize> = by.iter().copied().filter(|&k| variables.may_be_solved_as_length(k)).collect();
        if angles.len() + lengths.len() != by.len() {
            return Closing::OtherForm;
        }
        // The angle that the orientation gives: one that turns no side, where there is such.
        let (known, rest) = state.turn(&self.turn);
        let turns_a_side = |k: usize| self.sides.iter().any(|s| s.turn.iter().any(|t| t.0 == k));
        let candidates = rest.iter().filter(|t| t.1.abs() == 1);
        let Some(&(pivot, sign)) = candidates.min_by_key(|t| turns_a_side(t.0)) else {
            if !rest.is_empty() || sum(known, (self.delta.0, -self.delta.1)) != (Residue::ONE, Residue::ZERO) {
                return Closing::OtherForm;
            }
            return self.close_sides(state, &angles, &lengths, other_root, None);
        };
        // x_pivot = sign (delta - known - the others)
        let (c, s) = sum(self.delta, (known.0, -known.1));
        let others: Powers = rest.iter().filter(|t| t.0 != pivot).map(|&(k, p)| (k, -sign * p)).collect();
        let given = Given { pivot, known: raised((c, s), sign), others };
        let angles: Vec<usize> = angles.into_iter().filter(|&k| k != pivot).collect();
        let outcome = self.close_sides(state, &angles, &lengths, other_root, Some(&given));
        if outcome == Closing::Closed {
            let (point, open) = state.turn(&given.others);
            if !open.is_empty() {
                return Closing::OtherForm;
            }
            state.set_angle(pivot, sum(given.known, point));
        }
        outcome
    }

    fn close_sides(
        &self,
        state: &mut State,
        angles: &[usize],
        lengths: &[usize],
        other_root: bool,
        given: Option<&Given>,
    ) -> Closing {
        let Some(groups) = self.groups(state, angles, lengths, given) else { return Closing::OtherForm };
        match (angles, lengths) {
            ([x, y], []) => triangle(state, &groups, [*x, *y], other_root),
            ([x], [s]) => slide(state, &groups, *x, *s, other_root),
            ([], [s, t]) => two_slides(state, &groups, [*s, *t]),
            _ => Closing::OtherForm,
        }
    }

    /// The sides that turn by the same unknown angles, each group turned by what is known and added up.
    fn groups(&self, state: &State, angles: &[usize], lengths: &[usize], given: Option<&Given>) -> Option<Vec<Group>> {
        let mut groups: BTreeMap<Vec<i128>, Group> = BTreeMap::new();
        for side in &self.sides {
            let (mut point, mut rest) = state.turn(&side.turn);
            if let Some(given) = given
                && let Some(&(_, power)) = rest.iter().find(|t| t.0 == given.pivot)
            {
                point = sum(point, raised(given.known, power));
                rest.retain(|t| t.0 != given.pivot);
                let others: Powers = given.others.iter().map(|&(k, p)| (k, p * power)).collect();
                rest = added(&rest, &others, 1);
            }
            let key: Vec<i128> = angles.iter().map(|k| rest.iter().find(|t| t.0 == *k).map_or(0, |t| t.1)).collect();
            if rest.iter().any(|t| t.1 != 0 && !angles.contains(&t.0)) {
                return None;
            }
            let zero = [Residue::ZERO; 2];
            let group = groups.entry(key.clone()).or_insert_with(|| Group {
                turn: key,
                vector: zero,
                per_length: vec![zero; lengths.len()],
            });
            group.vector = plus(group.vector, rotated(point, side.vector));
            for &(k, along) in &side.slides {
                let along = rotated(point, along);
                match (state.lengths[k], lengths.iter().position(|&l| l == k)) {
                    (Some(length), _) => group.vector = plus(group.vector, along.map(|x| x * length)),
                    (None, Some(place)) => group.per_length[place] = plus(group.per_length[place], along),
                    (None, None) => return None,
                }
            }
        }
        Some(groups.into_values().filter(|g| !g.vanishes()).collect())
    }
}

/// An angle that follows from others: its known part, and theirs.
struct Given {
    pivot: usize,
    known: Point,
    others: Powers,
}

/// (vector + sum of lengths times per_length) exp(i turn . angles).
struct Group {
    turn: Vec<i128>,
    vector: Flat,
    per_length: Vec<Flat>,
}

impl Group {
    fn vanishes(&self) -> bool {
        let zero = [Residue::ZERO; 2];
        self.vector == zero && self.per_length.iter().all(|v| *v == zero)
    }
}

/// Two unknown angles.
fn triangle(state: &mut State, groups: &[Group], [x, y]: [usize; 2], other_root: bool) -> Closing {
    let [g0, g1, g2] = groups else { return Closing::OtherForm };
    let difference = |g: &Group| [g.turn[0] - g0.turn[0], g.turn[1] - g0.turn[1]];
    let ([a, b], [c, d]) = (difference(g1), difference(g2));
    let determinant = a * d - b * c;
    if determinant.abs() != 1 {
        return Closing::OtherForm;
    }
    // |v0|^2 + |v1|^2 + 2 Re(conj(v0) v1 exp(i psi)) = |v2|^2
    let square = |v: Flat| v[0] * v[0] + v[1] * v[1];
    let (v0, v1, v2) = (g0.vector, g1.vector, g2.vector);
    let [re, im] = [v0[0] * v1[0] + v0[1] * v1[1], v0[0] * v1[1] - v0[1] * v1[0]];
    let two = Residue::integer(2);
    let k = square(v2) - square(v0) - square(v1);
    let Some(first) = on_the_circle(two * re, -(two * im), k, other_root) else { return Closing::NoRoot };
    let third = plus(v0, rotated(first, v1)).map(|x| -x);
    let Some(second) = quotient(third, v2) else { return Closing::NoRoot };
    let second = (second[0], second[1]);
    // psi = M (x, y), so (x, y) = M^-1 psi with M^-1 = [d -b; -c a] / determinant.
    let angle = |p: i128, q: i128| sum(raised(first, p * determinant), raised(second, q * determinant));
    state.set_angle(x, angle(d, -b));
    state.set_angle(y, angle(-c, a));
    Closing::Closed
}

/// One unknown angle, one unknown length.
fn slide(state: &mut State, groups: &[Group], x: usize, s: usize, other_root: bool) -> Closing {
    let [g0, g1] = groups else { return Closing::OtherForm };
    let turn = g1.turn[0] - g0.turn[0];
    if turn.abs() != 1 {
        return Closing::OtherForm;
    }
    let inner = |a: Flat, b: Flat| a[0] * b[0] + a[1] * b[1];
    let square_difference = |a: Flat, b: Flat| inner(a, a) - inner(b, b);
    let (a0, u0, a1, u1) = (g0.vector, g0.per_length[0], g1.vector, g1.per_length[0]);
    let (two, four) = (Residue::integer(2), Residue::integer(4));
    let (a, b, c) = (square_difference(u0, u1), two * (inner(a0, u0) - inner(a1, u1)), square_difference(a0, a1));
    let length = if a == Residue::ZERO {
        if b == Residue::ZERO {
            return Closing::OtherForm;
        }
        -(c * b.inverse())
    } else {
        let Some(root) = (b * b - four * a * c).root() else { return Closing::NoRoot };
        let root = if other_root { -root } else { root };
        (root - b) * (two * a).inverse()
    };
    let end = |a: Flat, u: Flat| plus(a, u.map(|u| u * length));
    let Some(z) = quotient(end(a0, u0).map(|x| -x), end(a1, u1)) else { return Closing::NoRoot };
    state.set_angle(x, raised((z[0], z[1]), turn));
    state.set_length(s, length);
    Closing::Closed
}

fn two_slides(state: &mut State, groups: &[Group], [s, t]: [usize; 2]) -> Closing {
    let [g] = groups else { return Closing::OtherForm };
    let row = |i: usize| vec![g.per_length[0][i], g.per_length[1][i], -g.vector[i]];
    let Some(x) = solve(vec![row(0), row(1)], 2) else { return Closing::OtherForm };
    state.set_length(s, x[0]);
    state.set_length(t, x[1]);
    Closing::Closed
}

/// One side of a loop, from the last common link to its frame, at zero variables.
struct Branch {
    joints: Vec<Joint>,
    end: Pose,
}

struct Joint {
    kind: JointKind,
    at: Pose,
    powers: Powers,
    slides: Vec<(usize, Residue)>,
}

impl Branch {
    fn new(variables: &Variables, placements: &[Pose], joints: &[ChainJoint], links: &[usize]) -> Branch {
        let mut at = Pose::IDENTITY;
        let mut moving = Vec::new();
        for &j in links {
            at = at.then(&placements[j]);
            let joint = &joints[j];
            if joint.kind != JointKind::Fixed && !joint.terms.is_empty() {
                let revolute = joint.kind == JointKind::Revolute;
                let powers = if revolute { variables.powers(joint) } else { Vec::new() };
                let slides = joint.terms.iter().map(|&(k, c)| (k, Residue::number(c)));
                let slides = if revolute { Vec::new() } else { slides.collect() };
                moving.push(Joint { kind: joint.kind, at, powers, slides });
            }
        }
        Branch { joints: moving, end: at }
    }

    /// The sides with their angles, in axes whose z is the normal of the plane, and the angle of the end.
    fn sides(&self, frame: &[[Residue; 3]; 3]) -> Option<(Vec<Side>, Powers)> {
        let mut sides = Vec::new();
        let mut phi: Powers = Vec::new();
        let mut from = [Residue::ZERO; 3];
        let mut slides: Vec<(usize, Flat)> = Vec::new();
        let flat = |v: [Residue; 3]| {
            let v = turned(frame, v);
            [v[0], v[1]]
        };
        let normal = frame[2];
        let between = |to: [Residue; 3], from: [Residue; 3]| flat([0, 1, 2].map(|i| to[i] - from[i]));
        for joint in &self.joints {
            let axis = column(&joint.at.rotation, 2);
            let along = dot(axis, normal);
            if joint.kind == JointKind::Revolute {
                sides.push(Side {
                    vector: between(joint.at.position, from),
                    slides: std::mem::take(&mut slides),
                    turn: phi.clone(),
                });
                from = joint.at.position;
                let sign = if along == Residue::ONE {
                    1
                } else if along == -Residue::ONE {
                    -1
                } else {
                    return None;
                };
                phi = added(&phi, &joint.powers, sign);
            } else {
                if along != Residue::ZERO {
                    return None;
                }
                let along = flat(axis);
                slides.extend(joint.slides.iter().map(|&(k, c)| (k, along.map(|x| x * c))));
            }
        }
        sides.push(Side { vector: between(self.end.position, from), slides, turn: phi.clone() });
        Some((sides, phi))
    }
}

impl Side {
    fn reversed(self) -> Side {
        let slides = self.slides.into_iter().map(|(k, v)| (k, v.map(|x| -x))).collect();
        Side { vector: self.vector.map(|x| -x), slides, turn: self.turn }
    }
}

/// a + factor b, without zeros.
fn added(a: &[(usize, i128)], b: &[(usize, i128)], factor: i128) -> Powers {
    let mut sum: BTreeMap<usize, i128> = BTreeMap::new();
    a.iter().for_each(|&(k, p)| *sum.entry(k).or_default() += p);
    b.iter().for_each(|&(k, p)| *sum.entry(k).or_default() += factor * p);
    sum.into_iter().filter(|t| t.1 != 0).collect()
}

fn plus(a: Flat, b: Flat) -> Flat {
    [a[0] + b[0], a[1] + b[1]]
}

fn rotated((c, s): Point, [x, y]: Flat) -> Flat {
    [c * x - s * y, s * x + c * y]
}
