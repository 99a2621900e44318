//! Closes the orientation around a loop in a finite field by solving for one, two or three angles of the loop.
//!
//! Around the loop the product of all rotations is the identity: A_1 Rz(x_1) A_2 Rz(x_2) .. A_(n+1) = 1, with constant rotation
//! matrices A_i. The number of unknown angles may be
//!
//! - three, Rz(x) B Rz(y) C Rz(z) = M: the last row of B times the last column of C give a cos y + b sin y = M_33 - b_33 c_33,
//!   then the columns and rows of M give x and z;
//! - two, if all axes have one of two directions, Rz(x) B Rz(y) = M: the last row and column of M give both angles;
//! - one, if all axes are parallel: Rz(x) = M.

use crate::base::closed::planar_closing::Closing;
use crate::base::closed::pose::Pose;
use crate::base::closed::pose::{ExactMatrix, UNTURNED, about_z, column, product, transposed, turned};
use crate::base::closed::variables::{Powers, State, Variables, on_the_circle, quotient};
use crate::base::field::{CirclePoint, Residue};
use crate::kinematics::loop_chain::ChainJoint;
use robot::JointKind;

/// The product of all rotations around one loop, with given constants: A_1 Rz(x_1) A_2 Rz(x_2) .. A_(n+1).
pub(crate) struct Orientation {
    /// Pairs (A_i, x_i): the constant rotation matrix before a rotation about z, and the angle x_i of this rotation.
    letters: Vec<(ExactMatrix, Powers)>,
    last: ExactMatrix,
}

impl Orientation {
    pub(crate) fn new(
        variables: &Variables,
        placements: &[Pose],
        joints: &[ChainJoint],
        [cut, twin]: &[Vec<usize>; 2],
    ) -> Orientation {
        let mut word = Orientation { letters: Vec::new(), last: UNTURNED };
        let turn = |j: usize| match joints[j].kind {
            JointKind::Revolute => variables.powers(&joints[j]),
            _ => Vec::new(),
        };
        for &j in cut {
            word.fixed(&placements[j].rotation);
            word.turns(turn(j));
        }
        for &j in twin.iter().rev() {
            word.turns(turn(j).into_iter().map(|(k, p)| (k, -p)).collect());
            word.fixed(&transposed(&placements[j].rotation));
        }
        word
    }

    fn fixed(&mut self, by: &ExactMatrix) {
        self.last = product(&self.last, by);
    }

    fn turns(&mut self, powers: Powers) {
        if !powers.is_empty() {
            self.letters.push((std::mem::replace(&mut self.last, UNTURNED), powers));
        }
    }

    /// The same product in another form: the angles that `state` knows are multiplied into the constant matrices.
    fn reduced(&self, state: &State) -> Orientation {
        let mut word = Orientation { letters: Vec::new(), last: UNTURNED };
        for (before, powers) in &self.letters {
            word.fixed(before);
            let (known, rest) = state.turn(powers);
            word.fixed(&about_z(known));
            word.turns(rest);
        }
        word.fixed(&self.last);
        word
    }

    /// The variables in the angles of this product that `state` does not know, in ascending order of their indices.
    pub(crate) fn unknown(&self, state: &State) -> Vec<usize> {
        let mut all: Vec<usize> =
            self.letters.iter().flat_map(|l| l.1.iter().map(|t| t.0)).filter(|&k| state.points[k].is_none()).collect();
        all.sort_unstable();
        all.dedup();
        all
    }

    /// Whether `state` knows all angles of the product and the product is the identity.
    pub(crate) fn is_closed(&self, state: &State) -> bool {
        let word = self.reduced(state);
        word.letters.is_empty() && word.last == UNTURNED
    }

    /// Solves for the angles of the variables `by` so that the product is the identity; all other angles must be known.
    pub(crate) fn close(&self, variables: &Variables, state: &mut State, by: &[usize], other_root: bool) -> Closing {
        let word = self.reduced(state);
        let single = |powers: &Powers| match powers.as_slice() {
            [(k, p)] if p.abs() == 1 && variables.may_be_solved_as_angle(*k) && by.contains(k) => Some((*k, *p)),
            _ => None,
        };
        let Some(turns) = word.letters.iter().map(|l| single(&l.1)).collect::<Option<Vec<_>>>() else {
            return Closing::OtherForm;
        };
        if turns.len() != by.len() {
            return Closing::OtherForm;
        }
        // The outer constant matrices are moved to the right-hand side, which gives Rz B Rz C Rz = M.
        let Some((first, _)) = word.letters.first() else { return Closing::OtherForm };
        let M = product(&transposed(first), &transposed(&word.last));
        let inner: Vec<ExactMatrix> = word.letters[1..].iter().map(|l| l.0).collect();
        let found = match inner.as_slice() {
            [] => Ok(vec![(M[0][0], M[1][0])]),
            [B] => two(B, &M).ok_or(Closing::OtherForm),
            [B, C] => three(B, C, &M, other_root),
            _ => Err(Closing::OtherForm),
        };
        let points = match found {
            Ok(points) => points,
            Err(closing) => return closing,
        };
        for (&(k, p), (c, s)) in turns.iter().zip(points) {
            state.set_angle(k, (c, if p < 0 { -s } else { s }));
        }
        if self.is_closed(state) { Closing::Closed } else { Closing::OtherForm }
    }
}

fn plane([x, y, _]: [Residue; 3]) -> [Residue; 2] {
    [x, y]
}

/// Solves Rz(x) B Rz(y) = M for the points (cos, sin) of x and y; `None` if there is no solution.
fn two(B: &ExactMatrix, M: &ExactMatrix) -> Option<Vec<CirclePoint>> {
    let x = quotient(plane(column(M, 2)), plane(column(B, 2)))?;
    let y = quotient(plane(B[2]), plane(M[2]))?;
    Some(vec![(x[0], x[1]), (y[0], y[1])])
}

/// Solves Rz(x) B Rz(y) C Rz(z) = M for the points (cos, sin) of x, y and z. `other_root`: which of the two solutions is taken.
fn three(B: &ExactMatrix, C: &ExactMatrix, M: &ExactMatrix, other_root: bool) -> Result<Vec<CirclePoint>, Closing> {
    let (b, c) = (B[2], column(C, 2));
    let (along, across) = (b[0] * c[0] + b[1] * c[1], b[1] * c[0] - b[0] * c[1]);
    if along * along + across * across == Residue::ZERO {
        return Err(Closing::OtherForm);
    }
    let y = on_the_circle(along, across, M[2][2] - b[2] * c[2], other_root).ok_or(Closing::NoRoot)?;
    let B_y_C = product(&product(B, &about_z(y)), C);
    let x = quotient(plane(column(M, 2)), plane(column(&B_y_C, 2))).ok_or(Closing::OtherForm)?;
    let rest = product(&transposed(&product(&about_z((x[0], x[1])), &B_y_C)), M);
    let z = turned(&rest, [Residue::ONE, Residue::ZERO, Residue::ZERO]);
    Ok(vec![(x[0], x[1]), y, (z[0], z[1])])
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::base::field::circle;
    use random::SplitMix;

    /// The rotations around a loop of revolute joints about z. The link of each joint is rotated by an angle alpha about x.
    fn word(alphas: &[CirclePoint]) -> (Variables, Orientation) {
        let placement = |&(c, s): &CirclePoint| {
            let (one, zero) = (Residue::ONE, Residue::ZERO);
            Pose::placement(&[one, zero, zero, c, s, zero, one, zero, zero])
        };
        let placements: Vec<Pose> = alphas.iter().map(placement).collect();
        let joints: Vec<ChainJoint> =
            (0..alphas.len()).map(|k| ChainJoint { kind: JointKind::Revolute, terms: vec![(k, 1.0)] }).collect();
        let variables = Variables::new(1, joints.len(), &joints).unwrap();
        let all = [(0..joints.len()).collect(), Vec::new()];
        let word = Orientation::new(&variables, &placements, &joints, &all);
        (variables, word)
    }

    #[test]
    fn three_angles_close_any_loop() {
        let random = &mut SplitMix(3);
        let alphas: Vec<CirclePoint> = (0..6).map(|_| circle(random)).collect();
        let (variables, word) = word(&alphas);
        let mut n_closed = 0;
        for _ in 0..20 {
            let mut state = State::unknown(6);
            [1, 2, 4].iter().for_each(|&k| state.draw(k, random));
            // If `close` succeeds, the function has already checked that the product is the identity.
            if word.close(&variables, &mut state, &[0, 3, 5], false) == Closing::Closed {
                assert!(word.is_closed(&state));
                state.draw(1, random);
                assert!(!word.is_closed(&state));
                n_closed += 1;
            }
        }
        assert!(n_closed > 3, "{n_closed}");
    }

    #[test]
    fn axes_of_one_or_two_directions_take_one_or_two_angles() {
        let random = &mut SplitMix(4);
        let parallel = (Residue::ONE, Residue::ZERO);
        let (variables, flat) = word(&[parallel; 4]);
        let mut state = State::unknown(4);
        [0, 1, 3].iter().for_each(|&k| state.draw(k, random));
        assert_eq!(flat.close(&variables, &mut state, &[2], false), Closing::Closed);
        // The axes have two directions: alpha has first the point (cos, sin) = (c, s), and then (c, -s).
        let (c, s) = circle(random);
        let (variables, two) = word(&[parallel, parallel, (c, s), parallel, (c, -s)]);
        let mut state = State::unknown(5);
        [0, 2, 4].iter().for_each(|&k| state.draw(k, random));
        assert_eq!(two.close(&variables, &mut state.clone(), &[1], false), Closing::OtherForm);
        state.set_angle(4, parallel);
        assert_eq!(two.close(&variables, &mut state, &[1, 3], false), Closing::Closed);
    }
}
