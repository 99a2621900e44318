//! Frames of a .par file that are placed relative to a loop frame instead of a link.
//!
//! A loop has two frames at its cut that coincide: the frame of the cut joint, and its twin, which is fixed to a link. A frame
//! that is placed on one of them is therefore fixed to that link. Its pose is the placement of the twin followed by its own
//! placement [Khalil, Kleinfinger 1986] (index 1: twin, index 2: frame):
//!
//! ```text
//! Rz(gamma1) Tz(b1) Rx(alpha1) Tx(d1) . Rz(theta1 + gamma2) Tz(r1 + b2) . Rx(alpha2) Tx(d2) Rz(theta2) Tz(r2)
//! ```
//! The product has three groups, separated by dots. If one of the groups is the identity, the product is a single placement with
//! exact expressions in the symbols. Otherwise a single placement is computed numerically. The frame is refused if this needs a
//! symbol that has no value.

use crate::angle_snap::{computed_angle, computed_length};
use crate::inertial::Pose;
use crate::robot::ModifiedDh;
use crate::value::{Symbol, Value};

/// Two z axes count as parallel if the sine of alpha is below this value.
const PARALLEL_SINE: f64 = 1e-12;

/// For each frame, the link to which it is fixed.
pub(super) struct LumpedFrames {
    /// Number of the link that carries each frame; zero for the base.
    pub link: Vec<usize>,
    /// For each frame, the twins (fixed frames on the other side of loop cuts) between it and its link, as indices from zero; the
    /// twin nearest to the frame is first.
    pub through: Vec<Vec<usize>>,
}

/// The link that carries each frame. If the antecedent of a frame is a loop frame, the search continues from the twin of this
/// loop. Fails with the index of a frame if antecedents are circular.
pub(super) fn carriers(antecedent: &[usize], n_links: usize, n_joints: usize) -> Result<LumpedFrames, usize> {
    let mut found = LumpedFrames { link: Vec::new(), through: Vec::new() };
    for j in 0..antecedent.len() {
        let (mut number, mut through) = (antecedent[j], Vec::new());
        while number > n_links {
            let twin = if number <= n_joints { number + n_joints - n_links } else { number } - 1;
            // The antecedents are circular. For example, a twin is placed on its own cut instead of on a link.
            if through.contains(&twin) || twin == j {
                return Err(j);
            }
            through.push(twin);
            number = antecedent[twin];
        }
        found.link.push(number);
        found.through.push(through);
    }
    Ok(found)
}

/// Two consecutive placements as one placement. `None` if it must be computed numerically and a symbol has no value.
pub(super) fn product(first: ModifiedDh, second: ModifiedDh, symbols: &[Symbol]) -> Option<ModifiedDh> {
    let zero = |v: &Value| v.as_multiple_of_pi(symbols).is_some_and(|(n, _)| n == 0);
    let sum = |a: Value, b: Value| match (zero(&a), zero(&b)) {
        (true, _) => b,
        (_, true) => a,
        _ => Value::Add(a.into(), b.into()),
    };
    let ModifiedDh { gamma, b, alpha, d, theta, r } = first.clone();
    let next = second.clone();
    if zero(&alpha) && zero(&d) {
        let (gamma, b) = (sum(gamma, sum(theta, next.gamma)), sum(b, sum(r, next.b)));
        return Some(ModifiedDh { gamma, b, ..second });
    }
    if zero(&next.alpha) && zero(&next.d) {
        let (theta, r) = (sum(theta, sum(next.gamma, next.theta)), sum(r, sum(next.b, next.r)));
        return Some(ModifiedDh { theta, r, ..first });
    }
    if zero(&sum(theta, next.gamma)) && zero(&sum(r, next.b)) {
        return Some(ModifiedDh { gamma, b, alpha: sum(alpha, next.alpha), d: sum(d, next.d), ..second });
    }
    let generic = symbols.iter().any(|s| s.generic);
    (!generic).then(|| in_numbers(&first.pose(symbols, 0.0, 0.0).compose(&second.pose(symbols, 0.0, 0.0))))
}

/// The placement (gamma .. r) that has this pose, as numbers.
fn in_numbers(pose: &Pose) -> ModifiedDh {
    let (r, [x, y, z]) = (pose.rotation, pose.position);
    // In the antecedent frame, the z axis of this frame is (sin gamma sin alpha, -cos gamma sin alpha, cos alpha).
    let sine = r[0][2].hypot(r[1][2]);
    let parallel = sine < PARALLEL_SINE;
    let gamma = if parallel { y.atan2(x) } else { r[0][2].atan2(-r[1][2]) };
    let (s, c) = gamma.sin_cos();
    let alpha = if parallel { 0.0_f64.atan2(r[2][2]) } else { sine.atan2(r[2][2]) };
    let across = c * y - s * x;
    let length = if parallel { 0.0 } else { -across / alpha.sin() };
    // The x axis of the antecedent, rotated by gamma about z, has the components (cos theta, -sin theta, 0) in this frame.
    let theta = (-(c * r[0][1] + s * r[1][1])).atan2(c * r[0][0] + s * r[1][0]);
    ModifiedDh {
        gamma: computed_angle(gamma),
        b: computed_length(z - length * alpha.cos()),
        alpha: computed_angle(alpha),
        d: computed_length(c * x + s * y),
        theta: computed_angle(theta),
        r: computed_length(length),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn placed(x: [f64; 6]) -> ModifiedDh {
        let [gamma, b, alpha, d, theta, r] = x.map(Value::Number);
        ModifiedDh { gamma, b, alpha, d, theta, r }
    }

    /// The single placement equals the product of the two placements, both if one of the three groups is the identity and if none
    /// is.
    #[test]
    fn two_placements_are_one() {
        let a = [0.3, 0.2, 0.7, 0.4, -0.5, 0.6];
        let b = [0.9, -0.1, -1.2, 0.8, 0.25, -0.35];
        let flat = |x: [f64; 6]| [x[0], x[1], 0.0, 0.0, x[4], x[5]];
        let met = [0.5, -0.6, b[2], b[3], b[4], b[5]];
        let turned = [a[0], a[1], 0.0, a[3], a[4], a[5]];
        let along = [b[0], b[1], 0.0, b[3], b[4], b[5]];
        for (first, second) in [(a, b), (flat(a), b), (a, flat(b)), (a, met), (turned, along), (flat(a), flat(b))] {
            let (first, second) = (placed(first), placed(second));
            let wanted = first.pose(&[], 0.0, 0.0).compose(&second.pose(&[], 0.0, 0.0));
            let found = product(first, second, &[]).unwrap().pose(&[], 0.0, 0.0);
            for i in 0..3 {
                assert!((found.position[i] - wanted.position[i]).abs() < 1e-14, "{found:?} {wanted:?}");
                for k in 0..3 {
                    assert!((found.rotation[i][k] - wanted.rotation[i][k]).abs() < 1e-14, "{found:?} {wanted:?}");
                }
            }
        }
    }

    #[test]
    fn a_symbol_without_a_value_has_no_number() {
        let symbols = [Symbol { name: "L".into(), value: Value::Number(0.7), generic: true }];
        let mut first = placed([0.3, 0.2, 0.7, 0.4, -0.5, 0.6]);
        first.d = Value::Symbol(crate::value::SymbolId(0));
        assert!(product(first.clone(), placed([0.9, -0.1, -1.2, 0.8, 0.25, -0.35]), &symbols).is_none());
        let exact = product(first, placed([0.1, 0.0, 0.0, 0.0, 0.2, 0.0]), &symbols).unwrap();
        assert_eq!(exact.d, Value::Symbol(crate::value::SymbolId(0)));
    }
}
