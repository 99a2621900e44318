//! The columns of the identification matrix W for a motion: base parameters, then friction of each joint.
//!
//! In a search the sign of dry friction is replaced by tanh(dq / v), because tanh has a derivative. v is 2 % of the greatest
//! velocity within the limits. The predicted standard deviations of the motion use the sign itself
//! ([`crate::excitation::visibility`]).
//!
//! A locked coordinate has no rows in W, because its dry friction at rest may have any value. A column is left out if it is a
//! linear combination of the columns before it, at random states within the limits.

use linear_model::friction::terms::{FrictionTerm, columns_before, columns_of};
use linear_model::linear_model::Model;
use numerics::triangle::TriangleBuilder;
use random::Random;

use crate::excitation::limits::CoordinateLimits;

/// Width v of the smooth sign of dry friction in a search, as a share of the greatest velocity within the limits.
pub(crate) const SIGN_TURN_SHARE: f64 = 0.02;

/// A column of the identification matrix W counts as linearly dependent on the columns before it if the norm of its residual (the
/// part that they do not explain) is below this share of its norm.
const DEPENDENT_COLUMN_SHARE: f64 = 1e-8;
/// A column of the identification matrix W with a norm below this share of the largest column norm counts as zero.
const ZERO_NORM_SHARE: f64 = 1e-12;

/// Least number of rows per column of the identification matrix W in the test of linear dependence, if no coordinate is locked.
/// The rows are at random states.
const RANDOM_ROWS_PER_COLUMN: usize = 40;

/// Fills `out` with the friction columns of joint j: [value, derivative by dq, derivative by ddq]. `v`: width of tanh(dq / v),
/// which replaces the sign of dq, rad/s (m/s).
pub(crate) fn friction_columns(terms: &[FrictionTerm], j: usize, dq: f64, ddq: f64, v: f64, out: &mut [[f64; 3]]) {
    let (mut places, sign) = (out.iter_mut(), (dq / v).tanh());
    let turn = (1.0 - sign * sign) / v;
    let mut put = |value: f64, along_dq: f64, along_ddq: f64| {
        if let Some(place) = places.next() {
            *place = [value, along_dq, along_ddq];
        }
    };
    for term in terms {
        match *term {
            FrictionTerm::Viscous => put(dq, 1.0, 0.0),
            FrictionTerm::Coulomb => put(sign, turn, 0.0),
            FrictionTerm::SmoothCoulomb(width) => {
                let s = (dq / width).tanh();
                put(s, (1.0 - s * s) / width, 0.0);
            }
            FrictionTerm::Offset => put(1.0, 0.0, 0.0),
            FrictionTerm::Asymmetric => {
                let forward = f64::from(u8::from(dq > 0.0));
                put(dq.max(0.0), forward, 0.0);
                put(0.5 * (1.0 + sign), 0.5 * turn, 0.0);
                put(dq.min(0.0), 1.0 - forward, 0.0);
                put(0.5 * (1.0 - sign), -0.5 * turn, 0.0);
            }
            FrictionTerm::Stribeck(speed) => {
                let fall = (-(dq / speed).powi(2)).exp();
                put(sign * fall, (turn - 2.0 * sign * dq / (speed * speed)) * fall, 0.0);
            }
            FrictionTerm::Rotor => put(ddq, 0.0, 1.0),
            // Load-dependent friction needs a measured torque, which does not exist before the experiment.
            FrictionTerm::Load => put(0.0, 0.0, 0.0),
            // `At` is a friction term of a single joint. A motion request refuses such terms, so their columns are zero here.
            FrictionTerm::At(..) => term.parameters_of(j).iter().for_each(|_| put(0.0, 0.0, 0.0)),
        }
    }
}

/// For each column of the identification matrix W: whether motions within the limits can separate it from the columns before it.
pub fn visible_columns(model: &Model, limits: &[CoordinateLimits]) -> Vec<bool> {
    let (n, p, base) = (model.n(), model.p(), model.regressor.parameters().len());
    let mut random = Random::new(1);
    let mut block = TriangleBuilder::new(p);
    let mut y = vec![0.0; n * base];
    // Random states within the limits; a locked coordinate keeps its position.
    for _ in 0..RANDOM_ROWS_PER_COLUMN * p.div_ceil(n.max(1)).max(1) {
        let mut between = |l: &CoordinateLimits, low: f64, high: f64, rest: f64| match l.locked {
            Some(_) => rest,
            None => random.between(low, high),
        };
        let mut state = |f: &dyn Fn(&CoordinateLimits) -> (f64, f64, f64)| -> Vec<f64> {
            limits.iter().map(f).zip(limits).map(|((low, high, rest), l)| between(l, low, high, rest)).collect()
        };
        let q = state(&|l| (l.position.0, l.position.1, l.locked.unwrap_or(0.0)));
        let dq = state(&|l| (-l.reachable_velocity(), l.reachable_velocity(), 0.0));
        let ddq = state(&|l| (-l.acceleration, l.acceleration, 0.0));
        model.regressor.fill(&q, &dq, &ddq, &mut y);
        // Row of the identification matrix W for each moving joint: the row of the regressor Y, then its friction columns, which
        // follow the columns of all base parameters.
        for i in (0..n).filter(|&i| limits[i].locked.is_none()) {
            let mut row = vec![0.0; p];
            row[..base].copy_from_slice(&y[i * base..][..base]);
            let mut friction = vec![[0.0; 3]; columns_of(model.friction, i)];
            friction_columns(
                model.friction,
                i,
                dq[i],
                ddq[i],
                SIGN_TURN_SHARE * limits[i].reachable_velocity(),
                &mut friction,
            );
            for (x, column) in row[base + columns_before(model.friction, i)..].iter_mut().zip(&friction) {
                *x = column[0];
            }
            block.push(&row, 0.0);
        }
    }
    // The diagonal entry of the QR triangle is the norm of the residual of a column with respect to the columns before it.
    let triangle = block.finish();
    let norms: Vec<f64> = (0..p).map(|c| triangle.column_norm(c)).collect();
    let largest = norms.iter().copied().fold(0.0, f64::max);
    (0..p)
        .map(|c| norms[c] > ZERO_NORM_SHARE * largest && triangle.at(c, c).abs() > DEPENDENT_COLUMN_SHARE * norms[c])
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::excitation::search::tests::limits;
    use crate::pendulum::Pendulum;
    use linear_model::friction::terms::{JointTerm, sign};

    #[test]
    fn columns_and_their_slopes() {
        use FrictionTerm::*;
        let terms = [Viscous, Coulomb, Offset, SmoothCoulomb(0.2), Asymmetric, Stribeck(0.4), Rotor];
        let count: usize = terms.iter().map(|t| t.parameters().len()).sum();
        let columns = |dq: f64, ddq: f64, v: f64| {
            let mut out = vec![[f64::NAN; 3]; count];
            friction_columns(&terms, 0, dq, ddq, v, &mut out);
            out
        };
        for dq in [-0.7, -0.1, 0.2, 1.3] {
            let mut exact = vec![];
            for term in terms {
                let mut out = vec![0.0; term.parameters().len()];
                term.fill(dq, 0.5, 0.0, sign(dq), &mut out);
                exact.extend(out);
            }
            let found = columns(dq, 0.5, 1e-3);
            assert!(found.iter().zip(&exact).all(|(a, b)| (a[0] - b).abs() < 1e-12), "{found:?} {exact:?}");
            let (h, at) = (1e-6, columns(dq, 0.5, 0.3));
            let slopes = |a: Vec<[f64; 3]>, b: Vec<[f64; 3]>| -> Vec<f64> {
                a.iter().zip(&b).map(|(a, b)| (a[0] - b[0]) / (2.0 * h)).collect()
            };
            let along_dq = slopes(columns(dq + h, 0.5, 0.3), columns(dq - h, 0.5, 0.3));
            let along_ddq = slopes(columns(dq, 0.5 + h, 0.3), columns(dq, 0.5 - h, 0.3));
            for (c, at) in at.iter().enumerate() {
                // Central differences with h = 1e-6: rounding errors are about 1e-10.
                assert!((at[1] - along_dq[c]).abs() < 1e-8 && (at[2] - along_ddq[c]).abs() < 1e-8, "{c}");
            }
        }
    }

    #[test]
    fn a_column_twice_is_seen_once() {
        let arm = Pendulum::new();
        let limits = |locked| CoordinateLimits { locked, ..limits((-1.0, 1.0), [1.0, 3.0, 100.0]) };
        // For one link, the column of the rotor inertia equals the column of the link's inertia ZZ1.
        let friction = [FrictionTerm::Viscous, FrictionTerm::Rotor];
        let model = Model::new(&arm, &friction, &[]);
        assert_eq!(visible_columns(&model, &[limits(None)]), [true, true, true, true, false]);
        assert_eq!(visible_columns(&model, &[limits(Some(0.3))]), [false; 5]);
        // A friction term of another joint has no column in the model of this one-joint arm.
        let friction = [FrictionTerm::At(2, JointTerm::Root), FrictionTerm::Viscous];
        assert_eq!(visible_columns(&Model::new(&arm, &friction, &[]), &[limits(None)]), [true; 4]);
    }
}
