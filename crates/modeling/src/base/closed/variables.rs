//! The variables of a robot with loops (coordinates and passive variables), and their known values in a finite field.
//!
//! An angle x is a point (cos x, sin x) of the circle. If joints turn by ratios n/d of x, the point of x/D is stored, where D is
//! the common denominator, and a joint turns by the power D n/d of this point. A variable can be solved for as an angle only if
//! its ratios are integers, because the field lacks the roots for other ratios.

use crate::base::angles::least_common_multiple;
use crate::base::field::{CirclePoint, DIGITS, Residue, circle, short_ratio, times};
use crate::kinematics::loop_chain::ChainJoint;
use random::SplitMix;
use robot::JointKind;

/// Constant properties of all variables of a robot: first the coordinates, then the passive variables.
#[derive(Clone, Debug)]
pub(crate) struct Variables {
    /// Number of coordinates; the remaining variables are passive.
    pub n: usize,
    /// For each variable, the common denominator D of the ratios with which joints follow the variable.
    pub denominators: Vec<u128>,
    turns: Vec<bool>,
    slides: Vec<bool>,
}

/// An angle as pairs (variable k, exponent of the point of x_k/D_k): the product of these powers is the point of the angle.
pub(crate) type Powers = Vec<(usize, i128)>;

impl Variables {
    /// Makes the properties of `total` variables, `n` of them coordinates. `None` if the factor of a revolute joint is no ratio
    /// of small integers.
    pub(crate) fn new(n: usize, total: usize, joints: &[ChainJoint]) -> Option<Variables> {
        let mut all =
            Variables { n, denominators: vec![1; total], turns: vec![false; total], slides: vec![false; total] };
        for joint in joints {
            for &(k, c) in &joint.terms {
                match joint.kind {
                    JointKind::Revolute => {
                        all.turns[k] = true;
                        let (_, d) = short_ratio(c, DIGITS)?;
                        all.denominators[k] = least_common_multiple(all.denominators[k], d as u128)?;
                    }
                    JointKind::Prismatic => all.slides[k] = true,
                    JointKind::Fixed => {}
                }
            }
        }
        Some(all)
    }

    pub(crate) fn len(&self) -> usize {
        self.turns.len()
    }

    /// Whether variable k turns joints, only by integer ratios, and slides no joint.
    pub(crate) fn may_be_solved_as_angle(&self, k: usize) -> bool {
        self.turns[k] && !self.slides[k] && self.denominators[k] == 1
    }

    /// Whether variable k slides joints and turns no joint.
    pub(crate) fn may_be_solved_as_length(&self, k: usize) -> bool {
        self.slides[k] && !self.turns[k]
    }

    /// The angle of a revolute joint as pairs (variable k, exponent of the point of x_k/D_k); D_k: common denominator of the
    /// variable's ratios. Zero exponents are left out.
    pub(crate) fn powers(&self, joint: &ChainJoint) -> Powers {
        let power = |&(k, c): &(usize, f64)| {
            let (n, d) = short_ratio(c, DIGITS).unwrap_or_default();
            (k, i128::from(n) * (self.denominators[k] / d.max(1) as u128) as i128)
        };
        joint.terms.iter().map(power).filter(|t| t.1 != 0).collect()
    }
}

/// The values of all variables in the finite field, as far as the values are known.
#[derive(Clone, Debug)]
pub(crate) struct State {
    /// For each variable x, the point (cos, sin) of x/D; D: common denominator of the variable. `None` while the variable is
    /// unknown.
    pub points: Vec<Option<CirclePoint>>,
    /// The value of each variable as a length, in the field; `None` while the variable is unknown.
    pub lengths: Vec<Option<Residue>>,
}

impl State {
    pub(crate) fn unknown(total: usize) -> State {
        State { points: vec![None; total], lengths: vec![None; total] }
    }

    /// Whether the value of variable k is known, both as an angle and as a length.
    pub(crate) fn knows(&self, k: usize) -> bool {
        self.points[k].is_some() && self.lengths[k].is_some()
    }

    pub(crate) fn draw(&mut self, k: usize, random: &mut SplitMix) {
        self.draw_angle(k, random);
        self.lengths[k] = Some(Residue::random(random));
    }

    /// Draws a random angle for variable k. The value of the variable as a length stays unknown.
    pub(crate) fn draw_angle(&mut self, k: usize, random: &mut SplitMix) {
        self.points[k] = Some(circle(random));
    }

    pub(crate) fn set_angle(&mut self, k: usize, point: CirclePoint) {
        self.points[k] = Some(point);
        self.lengths[k] = Some(Residue::ONE);
    }

    pub(crate) fn set_length(&mut self, k: usize, length: Residue) {
        self.points[k] = Some((Residue::ONE, Residue::ZERO));
        self.lengths[k] = Some(length);
    }

    /// Splits an angle (pairs of variable and exponent). Returns the point of the sum of its known terms, and its unknown
    /// terms.
    pub(crate) fn turn(&self, powers: &[(usize, i128)]) -> (CirclePoint, Powers) {
        let (mut sum, mut rest) = ((Residue::ONE, Residue::ZERO), Vec::new());
        for &(k, power) in powers {
            match self.points[k] {
                Some(point) => sum = crate::base::field::turned(sum, raised(point, power)),
                None => rest.push((k, power)),
            }
        }
        (sum, rest)
    }
}

/// The point (cos, sin) of an angle times `power`, which may be negative.
pub(crate) fn raised(point: CirclePoint, power: i128) -> CirclePoint {
    let (c, s) = times(point, power.unsigned_abs());
    if power < 0 { (c, -s) } else { (c, s) }
}

/// Quotient z = a/b of two vectors of the plane as complex numbers; `None` if |b|^2 = 0.
pub(crate) fn quotient(a: [Residue; 2], b: [Residue; 2]) -> Option<[Residue; 2]> {
    let square = b[0] * b[0] + b[1] * b[1];
    if square == Residue::ZERO {
        return None;
    }
    let scale = square.inverse();
    Some([(a[0] * b[0] + a[1] * b[1]) * scale, (a[1] * b[0] - a[0] * b[1]) * scale])
}

/// A point (c, s) of the circle with a c + b s = k. `other` selects the second of the two solutions. `None` if the field has no
/// solution, or if a^2 + b^2 = 0.
pub(crate) fn on_the_circle(a: Residue, b: Residue, k: Residue, other: bool) -> Option<CirclePoint> {
    let square = a * a + b * b;
    if square == Residue::ZERO {
        return None;
    }
    let root = (square - k * k).root()?;
    let root = if other { -root } else { root };
    let scale = square.inverse();
    Some(((a * k - b * root) * scale, (b * k + a * root) * scale))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn points_that_are_solved_for_solve() {
        let random = &mut SplitMix(5);
        let mut found = 0;
        for _ in 0..40 {
            let [a, b, k] = [(); 3].map(|()| Residue::random(random));
            for other in [false, true] {
                if let Some((c, s)) = on_the_circle(a, b, k, other) {
                    assert_eq!((a * c + b * s, c * c + s * s), (k, Residue::ONE));
                    found += 1;
                }
            }
            let z = quotient([a, b], [k, a]).unwrap();
            assert_eq!([z[0] * k - z[1] * a, z[0] * a + z[1] * k], [a, b]);
        }
        // Half of all field elements have a square root, so about half of the 80 attempts succeed.
        assert!((20..60).contains(&found), "{found}");
    }

    #[test]
    fn an_angle_is_known_in_part() {
        let joint = |c: f64| ChainJoint { kind: JointKind::Revolute, terms: vec![(0, c), (1, -1.0)] };
        let joints = [joint(0.5), joint(2.0)];
        let variables = Variables::new(1, 2, &joints).unwrap();
        assert_eq!(variables.denominators, [2, 1]);
        assert_eq!(variables.powers(&joints[1]), [(0, 4), (1, -1)]);
        let mut state = State::unknown(2);
        state.draw(0, &mut SplitMix(1));
        let (known, rest) = state.turn(&variables.powers(&joints[0]));
        assert_eq!((Some(known), rest), (state.points[0], vec![(1, -1)]));
    }
}
