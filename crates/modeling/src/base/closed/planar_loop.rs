//! A planar loop in a finite field. The loop is closed by solving for two or three of its variables.
//!
//! Every rigid side is a vector of the plane, turned by the angles before it (as in `robot`'s polygon). A sliding joint
//! lengthens the side in which it lies:
//!
//! ```text
//! sum_k (a_k + sum_j s_j u_kj) exp(i Phi_k) = 0,      Phi_cut - Phi_twin = delta
//! ```
//! a_k is side k at zero variables, s_j the position of a sliding joint along u_kj, Phi_k the sum of the angles before side k,
//! and delta a constant angle. Phi_cut and Phi_twin are the sums of all angles of the two branches of the loop. The second
//! equation gives one angle as a sum of the others. The first equation gives the last two variables
//! ([`crate::base::closed::planar_closing`]).

use std::collections::BTreeMap;

use robot::JointKind;

use crate::base::closed::planar_closing::{Closing, Flat, PlanarGroup, plus, rotated, slide, triangle, two_slides};
use crate::base::closed::pose::{Pose, column, dot, product, transposed, turned};
use crate::base::closed::variables::{Powers, State, Variables, raised};
use crate::base::field::{CirclePoint, Residue, turned as sum};
use crate::kinematics::loop_chain::ChainJoint;

/// One planar loop with given constants: the sides of the loop, and the condition of its orientation.
#[derive(Clone, Debug)]
pub(crate) struct PlanarLoop {
    sides: Vec<Side>,
    turn: Powers,
    delta: CirclePoint,
    /// Distance of the two ends of the loop normal to the plane of the loop. The loop can close only if this distance is zero.
    pub offset: Residue,
}

#[derive(Clone, Debug)]
struct Side {
    vector: Flat,
    slides: Vec<(usize, Flat)>,
    turn: Powers,
}

impl PlanarLoop {
    /// Makes the loop of two branches (lists of links). `None` if a joint of the loop does not move in the plane of the loop.
    /// `placements` and `joints` are indexed by link.
    pub(crate) fn new(
        variables: &Variables,
        placements: &[Pose],
        joints: &[ChainJoint],
        branches: &[Vec<usize>; 2],
    ) -> Option<PlanarLoop> {
        let [cut, twin] = [0, 1].map(|b| Branch::new(variables, placements, joints, &branches[b]));
        let revolute = |j: &&PlanarJoint| j.kind == JointKind::Revolute;
        // The frame of the first revolute joint; its z axis is the normal of the plane.
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

    /// The variables of the loop that `state` does not know, in ascending order of their indices.
    pub(crate) fn unknown(&self, state: &State) -> Vec<usize> {
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

    /// The orientation error of the closed loop: the constant angle that the two branches are apart, as (cos, sin) in the field.
    /// `None` while an angle is unknown.
    pub(crate) fn defect(&self, state: &State) -> Option<CirclePoint> {
        let (known, rest) = state.turn(&self.turn);
        let (c, s) = self.delta;
        rest.is_empty().then(|| sum(known, (c, -s)))
    }

    /// The number of variables to solve for at `state`: two for the position, and one more if an angle of the orientation is
    /// unknown.
    pub(crate) fn n_solved(&self, state: &State) -> usize {
        2 + usize::from(!state.turn(&self.turn).1.is_empty())
    }

    /// Solves for the variables `by` so that the loop is closed; all other variables must be known. `other_root`: which of two
    /// solutions is taken.
    pub(crate) fn close(&self, variables: &Variables, state: &mut State, by: &[usize], other_root: bool) -> Closing {
        let angles: Vec<usize> = by.iter().copied().filter(|&k| variables.may_be_solved_as_angle(k)).collect();
        let lengths: Vec<usize> = by.iter().copied().filter(|&k| variables.may_be_solved_as_length(k)).collect();
        if angles.len() + lengths.len() != by.len() {
            return Closing::OtherForm;
        }
        // The pivot is the angle that follows from the equation of the orientation. If possible, choose an angle that turns no
        // side.
        let (known, rest) = state.turn(&self.turn);
        let turns_a_side = |k: usize| self.sides.iter().any(|s| s.turn.iter().any(|t| t.0 == k));
        let candidates = rest.iter().filter(|t| t.1.abs() == 1);
        let Some(&(pivot, sign)) = candidates.min_by_key(|t| turns_a_side(t.0)) else {
            if !rest.is_empty() || sum(known, (self.delta.0, -self.delta.1)) != (Residue::ONE, Residue::ZERO) {
                return Closing::OtherForm;
            }
            return self.close_sides(state, &angles, &lengths, other_root, None);
        };
        // The pivot angle is x_pivot = sign (delta - known angles - other unknown angles).
        let (c, s) = sum(self.delta, (known.0, -known.1));
        let others: Powers = rest.iter().filter(|t| t.0 != pivot).map(|&(k, p)| (k, -sign * p)).collect();
        let given = KnownAngle { pivot, known: raised((c, s), sign), others };
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
        given: Option<&KnownAngle>,
    ) -> Closing {
        let Some(groups) = self.groups(state, angles, lengths, given) else { return Closing::OtherForm };
        match (angles, lengths) {
            ([x, y], []) => triangle(state, &groups, [*x, *y], other_root),
            ([x], [s]) => slide(state, &groups, *x, *s, other_root),
            ([], [s, t]) => two_slides(state, &groups, [*s, *t]),
            _ => Closing::OtherForm,
        }
    }

    /// Groups the sides that turn by the same unknown angles; known angles are applied. `None` if a side depends on an unknown
    /// variable other than `angles` and `lengths`. `given`: the angle that follows from the orientation.
    fn groups(
        &self,
        state: &State,
        angles: &[usize],
        lengths: &[usize],
        given: Option<&KnownAngle>,
    ) -> Option<Vec<PlanarGroup>> {
        let mut groups: BTreeMap<Vec<i128>, PlanarGroup> = BTreeMap::new();
        for side in &self.sides {
            // Turn the side by the known angles, and replace the pivot angle by the angles from which it follows.
            let (mut point, mut rest) = state.turn(&side.turn);
            if let Some(given) = given
                && let Some(&(_, power)) = rest.iter().find(|t| t.0 == given.pivot)
            {
                point = sum(point, raised(given.known, power));
                rest.retain(|t| t.0 != given.pivot);
                let others: Powers = given.others.iter().map(|&(k, p)| (k, p * power)).collect();
                rest = added(&rest, &others, 1);
            }
            // Sides with equal exponents of the unknown angles form one group.
            let key: Vec<i128> = angles.iter().map(|k| rest.iter().find(|t| t.0 == *k).map_or(0, |t| t.1)).collect();
            if rest.iter().any(|t| t.1 != 0 && !angles.contains(&t.0)) {
                return None;
            }
            let zero = [Residue::ZERO; 2];
            let group = groups.entry(key.clone()).or_insert_with(|| PlanarGroup {
                turn: key,
                vector: zero,
                per_length: vec![zero; lengths.len()],
            });
            group.vector = plus(group.vector, rotated(point, side.vector));
            // A sliding joint lengthens the side in which it lies: a known length adds to `vector`, an unknown length adds to
            // `per_length`.
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

/// An angle (the pivot) that follows from the orientation of the loop: x_pivot = known + sum of the others.
struct KnownAngle {
    pivot: usize,
    known: CirclePoint,
    others: Powers,
}

/// One branch of a loop with all variables zero. It consists of the joints from the last common link of both branches to the
/// loop frame of this branch.
struct Branch {
    joints: Vec<PlanarJoint>,
    end: Pose,
}

struct PlanarJoint {
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
                moving.push(PlanarJoint { kind: joint.kind, at, powers, slides });
            }
        }
        Branch { joints: moving, end: at }
    }

    /// The sides of the branch with their angles, in axes with z normal to the plane, and the angle of the end frame. `None` if a
    /// joint does not move in the plane.
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
        // A revolute joint ends a side and turns all sides after it, about +z or -z of the plane.
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
                // A prismatic joint must slide within the plane. It lengthens the side in which it lies.
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

/// The sum a + factor b of two angles, each given by pairs (variable, exponent); zero exponents are left out.
fn added(a: &[(usize, i128)], b: &[(usize, i128)], factor: i128) -> Powers {
    let mut sum: BTreeMap<usize, i128> = BTreeMap::new();
    a.iter().for_each(|&(k, p)| *sum.entry(k).or_default() += p);
    b.iter().for_each(|&(k, p)| *sum.entry(k).or_default() += factor * p);
    sum.into_iter().filter(|t| t.1 != 0).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use random::SplitMix;

    /// The pose of a link that is displaced by the distance d along x.
    fn along_x(d: Residue) -> Pose {
        Pose { position: [d, Residue::ZERO, Residue::ZERO], ..Pose::IDENTITY }
    }

    fn joint(kind: JointKind, k: usize) -> ChainJoint {
        ChainJoint { kind, terms: vec![(k, 1.0)] }
    }

    /// Checks a four-bar: variable 0 turns a crank, 1 a coupler, 2 a rocker, 3 the cut. Solving for variable 3 and any two of
    /// the others closes the loop: the two ends of the loop meet.
    #[test]
    fn a_four_bar_is_closed_by_any_two_of_its_angles() {
        let random = &mut SplitMix(1);
        let mut lengths = || along_x(Residue::random(random));
        let placements = [Pose::IDENTITY, lengths(), lengths(), lengths(), lengths()];
        let mut joints: Vec<ChainJoint> = (0..4).map(|k| joint(JointKind::Revolute, [0, 1, 3, 2][k])).collect();
        joints.push(ChainJoint { kind: JointKind::Fixed, terms: Vec::new() });
        let variables = Variables::new(1, 4, &joints).unwrap();
        // Link indices of the two branches: crank, coupler, cut; rocker, twin.
        let one = PlanarLoop::new(&variables, &placements, &joints, &[vec![0, 1, 2], vec![3, 4]]).unwrap();
        assert_eq!((one.offset, one.unknown(&State::unknown(4))), (Residue::ZERO, vec![0, 1, 2, 3]));
        let mut n_closed = 0;
        for seed in 0..20 {
            let random = &mut SplitMix(seed);
            for (drawn, by) in [(0, [1, 2, 3]), (1, [0, 2, 3]), (2, [0, 1, 3])] {
                let mut state = State::unknown(4);
                state.draw(drawn, random);
                assert_eq!(one.n_solved(&state), 3);
                if one.close(&variables, &mut state, &by, seed % 2 == 0) == Closing::Closed {
                    assert_eq!(one.defect(&state), Some((Residue::ONE, Residue::ZERO)));
                    let open = one.sides.iter().fold([Residue::ZERO; 2], |open, side| {
                        plus(open, rotated(state.turn(&side.turn).0, side.vector))
                    });
                    assert_eq!(open, [Residue::ZERO; 2]);
                    n_closed += 1;
                }
            }
        }
        assert!(n_closed > 15, "{n_closed}");
    }

    /// Checks a crank (angle 0) and an arm (angle 1) on the base, with a block that slides along the arm (variable 2). Solving
    /// for arm and slide, or for crank and slide, closes the loop.
    #[test]
    fn a_sliding_block_is_closed_by_its_slide() {
        let quarter = |entries: [i64; 9]| Pose::placement(&entries.map(Residue::integer));
        // gamma and alpha are quarter turns, so that the z axis of the slide is along the x axis of the arm.
        let (slide, back) = (quarter([0, 1, 0, 0, 1, 0, 1, 0, 0]), quarter([1, 0, 0, 0, -1, 0, 1, 0, 0]));
        let random = &mut SplitMix(2);
        let placements =
            [along_x(Residue::random(random)), slide, back, Pose::IDENTITY, along_x(Residue::random(random))];
        let joints = [
            joint(JointKind::Revolute, 1),
            joint(JointKind::Prismatic, 2),
            joint(JointKind::Revolute, 3),
            joint(JointKind::Revolute, 0),
            ChainJoint { kind: JointKind::Fixed, terms: Vec::new() },
        ];
        let variables = Variables::new(1, 4, &joints).unwrap();
        let one = PlanarLoop::new(&variables, &placements, &joints, &[vec![0, 1, 2], vec![3, 4]]).unwrap();
        let mut n_closed = 0;
        for seed in 0..20 {
            for (drawn, by) in [(0, [3, 2, 1]), (1, [3, 2, 0])] {
                let mut state = State::unknown(4);
                state.draw(drawn, &mut SplitMix(seed));
                if one.close(&variables, &mut state, &by, false) == Closing::Closed {
                    let open = one.sides.iter().fold([Residue::ZERO; 2], |open, side| {
                        let slid = side.slides.iter().fold(side.vector, |sum, (k, along)| {
                            plus(sum, along.map(|x| x * state.lengths[*k].unwrap()))
                        });
                        plus(open, rotated(state.turn(&side.turn).0, slid))
                    });
                    assert_eq!(open, [Residue::ZERO; 2]);
                    n_closed += 1;
                }
            }
        }
        assert!(n_closed > 10, "{n_closed}");
    }
}
