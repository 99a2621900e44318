//! Computed-torque control of a simulated planar robot with two joints. All dynamics come from one generated file.
//!
//! tau = A(q) (ddq_r + kd de + kp e) + h(q, dq), with e = q_r - q. A and h are computed together, as inverse dynamics in base
//! parameters [Khalil, Dombre 2002, section 14.4]. The generated file needs no std and does not allocate, so it suits firmware.
//! It was written by `rist generate models/planar2r_vertical.yaml --functions inverse-dynamics,forward-dynamics`. A test of the
//! repository compares it with the output of the generator.
//!
//! `cargo run --package rist --example computed_torque`

#[rustfmt::skip]
#[path = "computed_torque/arm.rs"]
#[allow(unreachable_pub)] // users paste the generated file unchanged
mod arm;

/// Values of the base parameters ZZR1 MXR1 MY1 ZZ2 MX2 MY2 IA2, SI units. In practice an identification gives them.
const X: [f64; 7] = [0.9, 1.1, 0.0, 0.12, 0.3, 0.0, 0.05];

/// Time step of the loop, s.
const STEP: f64 = 1e-3;

fn main() {
    println!("{} ({:016x}), joints {:?}", arm::NAME, arm::FINGERPRINT, arm::COORDINATES);
    for (name, value) in arm::PARAMETERS.iter().zip(X) {
        println!("  {name} = {value}");
    }
    let (mut q, mut dq) = ([0.4, -0.6], [0.0, 0.0]);
    let (kp, kd) = (400.0, 40.0);
    for k in 0..2000 {
        let t = f64::from(k) * STEP;
        // Reference of both joints: position r, rad, and its first and second derivatives.
        let (r, dr, ddr) = (0.5 * t.sin(), 0.5 * t.cos(), -0.5 * t.sin());
        let v: [f64; 2] = core::array::from_fn(|j| ddr + kd * (dr - dq[j]) + kp * (r - q[j]));
        let (mut tau, mut ddq) = ([0.0; 2], [0.0; 2]);
        arm::inverse_dynamics(&q, &dq, &v, &X, &mut tau);
        // The robot is simulated by forward dynamics from the same generated file.
        arm::forward_dynamics(&q, &dq, &tau, &X, &mut ddq);
        for j in 0..2 {
            dq[j] += STEP * ddq[j];
            q[j] += STEP * dq[j];
        }
    }
    // The regressor gives the same torque: tau = Y X.
    let (mut y, mut tau) = ([[0.0; 7]; 2], [0.0; 2]);
    arm::base_regressor(&q, &dq, &[1.0, -1.0], &mut y);
    arm::inverse_dynamics(&q, &dq, &[1.0, -1.0], &X, &mut tau);
    let by_regressor: [f64; 2] = core::array::from_fn(|j| y[j].iter().zip(X).map(|(y, x)| y * x).sum());
    assert!((0..2).all(|j| (by_regressor[j] - tau[j]).abs() < 1e-12));
    // The function for the entries of Y that are not always zero gives the same values as Y.
    let mut entries = [0.0; arm::NON_ZEROS.len()];
    arm::base_regressor_non_zeros(&q, &dq, &[1.0, -1.0], &mut entries);
    assert!(entries.iter().zip(arm::NON_ZEROS).all(|(x, (i, c))| *x == y[i][c]));

    let r = 0.5 * (2000.0 * STEP).sin();
    println!("after 2 s the joints are at {:.4} and {:.4} rad, the reference at {r:.4} rad", q[0], q[1]);
    // With Euler steps of 1 ms, the error of the joints stays below 1 mrad; the reference moves at up to 0.5 rad/s.
    assert!(q.iter().all(|q| (q - r).abs() < 1e-3));
}
