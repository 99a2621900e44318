//! Decides whether the load after a force-torque sensor can be trusted. Makes claims (statements with their evidence) on the
//! residual of the fit, on other interpretations of the numbers in the log, and on whether a robot wrist can carry the load.
//!
//! The residual e = sqrt(f^2 + (n / ARM_M)^2) combines the residual f of the forces (N) and the residual n of the torques (N
//! m). e is compared with the standard deviation and with the noise of the signals. In a log of a motion, the noise follows
//! from third differences. For postures at rest, the noise follows from the residual of two equations that do not contain the
//! poses: the forces lie on a sphere, |F - b| = m g, and the torques are linear in the forces, N = c x F + d. If e exceeds 3 %
//! of the standard deviation (`SMALL_SHARE`), each of the usual [`Corrections`] is tried. The best correction is named if it
//! divides e by at least `NOISE_RATIO`. The noise is only used if no correction explains the residual.
//!
//! Not detected: a common scale of all signals, unless the resulting mass is too large for a wrist.

use crate::wrench_options::Corrections;
use crate::wrenches::Wrenches;
use claims::{Claim, EvidenceLevel, Figure, Need, Outcome, Purpose, Subject, Trial, Trust, lowering, worst};
use linear_model::pseudo_inertia::{Ten, smallest_eigenvalue};
use numerics::least_squares::solve;
use numerics::triangle::TriangleBuilder;
use numerics::vector::dot;

use crate::wrench_load::{WrenchLoad, wrench_load};
use crate::wrench_meaning::{ARM_M, NOISE_RATIO, alternative, contradicted, in_options, left, residual_share};
use identification::estimate::digits::percent;
use identification::estimate::identified::INTERVAL;
use identification::estimate::topics::{BODIES, COMMON_SCALE, LOG, PARAMETERS, RESIDUAL, cannot_tell};
use identification::estimate::verdict::{sentence, what_mends};

/// Largest residual of a good sensor, as a fraction of the signals' standard deviation. `LARGE_SHARE`: if the residual looks like
/// noise but is above this fraction, no conclusion is possible.
const SMALL_SHARE: f64 = 0.03;
const LARGE_SHARE: f64 = 0.1;
/// Largest mass that a wrist can carry, kg. `FARTHEST_CENTRE_M`: largest distance of its centre of mass, m.
const LARGEST_MASS_KG: f64 = 500.0;
const FARTHEST_CENTRE_M: f64 = 2.0;
/// If the parameters are outside the physically possible range by more than this number of standard deviations, noise is not the
/// reason.
const IMPOSSIBLE_DEVIATIONS: f64 = 3.0;

/// The verdict on a load, with the claims that support it.
pub struct WrenchVerdict {
    /// Level of trust: whether the load can be used, and for what.
    pub trust: Trust,
    /// All claims on the load.
    pub claims: Vec<Claim>,
    /// For each claim that lowers the trust, a sentence.
    pub reasons: Vec<String>,
    /// The remedy of the first claim that lowers the trust; `None` if there is none.
    pub next: Option<String>,
}

impl WrenchVerdict {
    /// The verdict on the load `found`, which was estimated from `log`.
    pub fn of(log: &Wrenches, found: &WrenchLoad) -> WrenchVerdict {
        let mut claims = vec![of_residual(log, found)];
        // If another interpretation of the log explains the residual, the load is wrong. Then there are no claims on its mass,
        // its centre of mass and its inertia.
        if claims[0].subject().topic != LOG {
            claims.extend([of_mass(found), of_centre(log, found), of_body(found)].into_iter().flatten());
        }
        let why = "a factor of all forces and torques would not have shown";
        let is_on_scale = |claim: &Claim| claim.subject().topic == COMMON_SCALE;
        if !claims.iter().any(is_on_scale) {
            claims.push(cannot_tell(Subject::whole(COMMON_SCALE), why, "a load that was weighed"));
        }
        let further = [LOG, PARAMETERS, BODIES].map(|topic| Need::where_claimed(Subject::whole(topic)));
        let first = Purpose::new("the load", Need::new(Subject::whole(RESIDUAL)));
        let first = first.and(Need::uncontradicted(Subject::whole(COMMON_SCALE)));
        let purpose = further.into_iter().fold(first, Purpose::and);
        let standing = worst(&claims, &purpose);
        let of_it = |claim: &&&Claim| standing != EvidenceLevel::Refused || claim.is_contradicted();
        let lowered = lowering(&claims, &purpose);
        let lowered: Vec<&Claim> = lowered.iter().filter(of_it).copied().collect();
        let (reasons, next) = (lowered.iter().map(|c| sentence(c)).collect(), lowered.first().map(|c| what_mends(c)));
        WrenchVerdict { trust: standing.trust(), reasons, next, claims }
    }
}

/// The claim on the residual; or a claim that another interpretation of the numbers explains the residual.
fn of_residual(log: &Wrenches, found: &WrenchLoad) -> Claim {
    let (left, noise, share) = (left(found), noise(log), residual_share(log, found));
    let is_noise = left <= NOISE_RATIO * noise;
    // If another interpretation of the log explains a large residual, the claim contradicts the log.
    if share > SMALL_SHARE
        && let Some(claim) = alternative(log, share)
    {
        return claim;
    }
    // If the residual is as large as the noise but a large part of the signals, no conclusion is possible. Any other residual
    // that is small, or not larger than the noise, agrees with the model.
    if is_noise && share > LARGE_SHARE {
        let why = format!("the residual looks like noise, and is {} of what varies", percent(share));
        return cannot_tell(Subject::whole(RESIDUAL), why, "more attitudes, a longer log, or a heavier load");
    }
    if is_noise || share <= SMALL_SHARE {
        let smallest = Figure::new(100.0 * share, "% of what varies");
        return Claim::new(Subject::whole(RESIDUAL), Outcome::Agrees { smallest });
    }
    // The remaining case: a large residual, more than the noise, without a known cause.
    let [force, torque] = found.residuals;
    let times = claims::significant(left / noise, 2);
    let fault = format!(
        "residual of {force:.4} N and {torque:.5} N m rms per sample: {} of what varies, and {times} times the noise",
        percent(share)
    );
    let advice = "look at the poses and clocks of both, at contacts and cables";
    if share <= LARGE_SHARE {
        return cannot_tell(Subject::whole(RESIDUAL), fault, advice);
    }
    let why =
        "no unit of the angles, order of the quaternion, inverse of the poses, axes of the base or turn of the sensor explains it".into();
    contradicted(RESIDUAL, fault, advice.into(), Trial::NotTried { why })
}

/// The noise of the signals, as the standard deviation that the combined residual e of forces and torques would have.
fn noise(log: &Wrenches) -> f64 {
    // The third difference of white noise has the variance 20 sigma^2.
    let by_differences = |signal: &[[f64; 3]]| {
        let third = |w: &[[f64; 3]], i: usize| w[3][i] - 3.0 * (w[2][i] - w[1][i]) - w[0][i];
        let sum: f64 = signal.windows(4).map(|w| (0..3).map(|i| third(w, i).powi(2)).sum::<f64>()).sum();
        (sum / (60.0 * signal.len() as f64)).sqrt()
    };
    if !log.t.is_empty() {
        return by_differences(&log.force).hypot(by_differences(&log.torque) / ARM_M);
    }
    let square = |f: &[f64; 3]| f.iter().map(|x| x * x).sum::<f64>();
    // The equation of the sphere |F - b| = m g is linear in b and m^2 g^2 - |b|^2: |F|^2 = 2 b F + m^2 g^2 - |b|^2.
    let sphere = log.force.iter().map(|f| ([2.0 * f[0], 2.0 * f[1], 2.0 * f[2], 1.0], square(f)));
    let (squares, x) = least(sphere);
    let radius = (x[3] + square(&[x[0], x[1], x[2]])).max(f64::MIN_POSITIVE).sqrt();
    let rows = log.force.iter().zip(&log.torque).flat_map(|(&[x, y, z], n)| {
        let of_axis = [[0.0, z, -y], [-z, 0.0, x], [y, -x, 0.0]];
        let unit = |i: usize, k: usize| f64::from(u8::from(i == k));
        [0, 1, 2].map(|i| {
            let [a, b, c] = of_axis[i];
            ([a, b, c, unit(i, 0), unit(i, 1), unit(i, 2)], n[i])
        })
    });
    (squares / (2.0 * radius)).hypot(least(rows).0 / ARM_M)
}

/// A least squares fit: the standard deviation of its residual, and its solution.
fn least<const N: usize>(rows: impl Iterator<Item = ([f64; N], f64)>) -> (f64, Vec<f64>) {
    let mut block = TriangleBuilder::new(N);
    rows.for_each(|(row, y)| {
        block.push(&row, y);
    });
    let found = solve(&block.finish());
    (found.variance.sqrt(), found.x)
}

fn of_mass(found: &WrenchLoad) -> Option<Claim> {
    let (mass, certain) = (found.parameters[9], INTERVAL * found.sigma[9]);
    if !found.determined[9] || mass <= certain {
        let why = "the mass is not significant: there is no load, or the sensor keeps its attitude, or its driver takes \
                   the weight out";
        return Some(cannot_tell(Subject::whole(PARAMETERS), why, "more attitudes, of the sensor's own signals"));
    }
    let fault = format!("{mass:.0} kg is more than a wrist carries: the signals are no N and N m");
    let advice = "the sensor's units per N and N m, in the file of [options]: corrections: {force: .., torque: ..}";
    let trial = Trial::NotTried { why: "a log does not determine the factor".into() };
    (mass - certain > LARGEST_MASS_KG).then(|| contradicted(COMMON_SCALE, fault, advice.into(), trial))
}

/// Distance of the centre of mass from the origin of the sensor, m. `None` if the log does not determine the distance.
fn distance(found: &WrenchLoad) -> Option<f64> {
    let (mass, certain) = (found.parameters[9], INTERVAL * found.sigma[9]);
    let is_determined = found.determined[6..].iter().all(|is| *is) && mass > certain;
    is_determined.then(|| dot(&found.parameters[6..9], &found.parameters[6..9]).sqrt() / mass)
}

fn of_centre(log: &Wrenches, found: &WrenchLoad) -> Option<Claim> {
    let before = distance(found).filter(|m| *m > FARTHEST_CENTRE_M)?;
    let fault = format!("the centre of mass is {before:.1} m from the sensor, farther than a wrist carries anything");
    let millis = Corrections { torque: 1e-3, ..Corrections::default() };
    let after = wrench_load(&log.clone().corrected(&millis)).ok().and_then(|found| distance(&found));
    Some(match after.filter(|m| *m < FARTHEST_CENTRE_M) {
        Some(after) => {
            let [before, after] = [before, after].map(|x| Figure::new(x, "m"));
            let trial = Trial::Tried { quantity: "distance of the centre of mass".into(), before, after };
            contradicted(LOG, fault + ": are the torques in N mm?", in_options(&millis), trial)
        }
        None => {
            let why = "torques in N mm do not explain it".into();
            contradicted(LOG, fault, "look at the unit of the torques".into(), Trial::NotTried { why })
        }
    })
}

fn of_body(found: &WrenchLoad) -> Option<Claim> {
    let is_whole = found.determined.iter().all(|is| *is);
    if !is_whole || smallest_eigenvalue(&found.parameters) >= 0.0 {
        return None;
    }
    let wide: Ten = std::array::from_fn(|k| {
        let inflated = if [0, 3, 5, 9].contains(&k) { IMPOSSIBLE_DEVIATIONS * found.sigma[k] } else { 0.0 };
        found.parameters[k] + inflated
    });
    let fault = "no body has these parameters: its inertia is negative about some axis";
    let advice = "look at the units of torques, lengths and clock";
    if smallest_eigenvalue(&wide) >= 0.0 {
        return Some(cannot_tell(Subject::whole(BODIES), fault, "a motion that turns faster"));
    }
    let trial = Trial::NotTried { why: "no unit follows from it".into() };
    Some(contradicted(BODIES, fault.into(), advice.into(), trial))
}

#[cfg(test)]
mod tests {
    use nalgebra::{Matrix3, Rotation3, UnitQuaternion};

    use super::*;
    use crate::wrench_load::tests::{log, rests};
    use crate::wrench_meaning::OWN_SIGNALS;

    fn verdict(log: &Wrenches) -> WrenchVerdict {
        WrenchVerdict::of(log, &wrench_load(log).unwrap())
    }

    /// A copy of a log in which each row is changed.
    fn changed(log: &Wrenches, change: impl Fn(Matrix3<f64>, [&mut [f64; 3]; 3]) -> Matrix3<f64>) -> Wrenches {
        let mut log = log.clone();
        for k in 0..log.force.len() {
            let turn = Matrix3::from_fn(|i, j| log.rotation[k][i][j]);
            let row = [&mut log.force[k], &mut log.torque[k], &mut log.position[k]];
            let turn = change(turn, row);
            log.rotation[k] = std::array::from_fn(|i| std::array::from_fn(|j| turn[(i, j)]));
        }
        log
    }

    fn turn(by: &Matrix3<f64>, vectors: [&mut [f64; 3]; 2]) {
        for vector in vectors {
            *vector = (by * nalgebra::Vector3::from(*vector)).into();
        }
    }

    /// A log whose roll, pitch and yaw are in degrees but were read as rad.
    fn in_degrees(log: &Wrenches) -> Wrenches {
        let read = changed(log, |turn, _| {
            let (roll, pitch, yaw) = Rotation3::from_matrix_unchecked(turn).euler_angles();
            Rotation3::from_euler_angles(roll.to_degrees(), pitch.to_degrees(), yaw.to_degrees()).into_inner()
        });
        Wrenches { in_degrees: log.rotation.clone(), ..read }
    }

    /// Logs with a mistake. For each: a part of the text of the expected claim, and the option that must be printed to correct
    /// the log.
    fn mistakes(log: &Wrenches) -> Vec<(Wrenches, &'static str, &'static str)> {
        let turned = |angle: [f64; 3]| {
            let by = Rotation3::from_euler_angles(angle[0], angle[1], angle[2]).into_inner();
            changed(log, |r, [f, n, _]| {
                turn(&by.transpose(), [f, n]);
                r
            })
        };
        vec![
            (in_degrees(log), "the angles of the orientation are in degrees", "corrections: {degrees: true}"),
            (turned([0.0, 0.0, 0.52]), "turned against the frame of the poses", "turn: ["),
            (turned([1.57, 0.0, 0.0]), "turned against the frame of the poses", "turn: ["),
            (turned([-2.0, 0.7, 2.8]), "turned against the frame of the poses", "turn: ["),
            (
                changed(log, |r, _| {
                    let q = UnitQuaternion::from_matrix(&r);
                    // The columns x, y, z, w contain w, x, y, z.
                    let read = nalgebra::Quaternion::new(q.k, q.w, q.i, q.j);
                    UnitQuaternion::from_quaternion(read).to_rotation_matrix().into_inner()
                }),
                "the first number of the quaternions is w",
                "corrections: {scalar_first: true}",
            ),
            (
                changed(log, |r, [_, _, p]| {
                    *p = (-(r.transpose() * nalgebra::Vector3::from(*p))).into();
                    r.transpose()
                }),
                "the poses are those of the frame at rest in the sensor",
                "corrections: {inverted_poses: true}",
            ),
            (
                changed(log, |r, [f, n, _]| {
                    turn(&r, [f, n]);
                    r
                }),
                "in the axes of the frame at rest",
                "corrections: {base_axes: true}",
            ),
            (
                changed(log, |r, [_, n, _]| {
                    *n = n.map(|x| 1e3 * x);
                    r
                }),
                "are the torques in N mm?",
                "corrections: {torque: 0.001}",
            ),
        ]
    }

    #[test]
    fn each_mistake_is_found_and_its_remedy_mends_it() {
        for log in [log(12.0, 0.03, 1.0, 5), rests(40, 0.03, 6), rests(14, 0.03, 7), log(12.0, 0.03, -1.0, 8)] {
            for (wrong, fault, correction) in mistakes(&log) {
                let said = verdict(&wrong);
                let (reasons, next) = (said.reasons.join("; "), said.next.unwrap());
                assert_eq!(said.trust, Trust::No, "{fault}: {:?}", said.claims);
                assert!(reasons.contains(fault) && next.contains(correction), "{fault}: {reasons}: {next}");
                let yaml = next.split_once(": corrections: ").unwrap().1;
                let by: Corrections = linear_model::yaml::read(yaml).unwrap();
                let mended = verdict(&wrong.corrected(&by));
                assert_eq!(mended.trust, Trust::Yes, "{fault}: {:?}", mended.claims);
            }
            let counts = changed(&log, |r, [f, n, _]| {
                [&mut *f, n].into_iter().for_each(|v| *v = v.map(|x| 1e3 * x));
                r
            });
            let said = verdict(&counts);
            assert!(said.trust == Trust::No && said.reasons[0].contains("2100 kg is more"), "{:?}", said.reasons);
        }
    }

    #[test]
    fn what_nothing_explains_has_no_remedy_that_was_tried() {
        let mut pushed = log(12.0, 0.03, 1.0, 5);
        (1000..1300).for_each(|k| pushed.force[k][2] += 40.0);
        let said = verdict(&pushed);
        assert!(said.trust == Trust::No && said.reasons[0].contains("times the noise"), "{:?}", said.reasons);
        assert!(!said.next.unwrap().contains("corrections"));
    }

    #[test]
    fn signals_without_weight_are_named() {
        let weightless = changed(&log(12.0, 0.03, 1.0, 5), |r, [f, n, _]| {
            // The weight of 2.1 kg at the centre of mass of the test load is subtracted from the signals.
            let weight = r.transpose() * nalgebra::Vector3::new(0.0, 0.0, 2.1 * 9.81);
            let torque = nalgebra::Vector3::new(0.02, -0.03, 0.12).cross(&weight);
            (0..3).for_each(|i| (f[i], n[i]) = (f[i] - weight[i], n[i] - torque[i]));
            r
        });
        let said = verdict(&weightless);
        assert!(said.trust == Trust::No && said.reasons.len() == 1, "{:?}", said.reasons);
        assert!(said.reasons[0].contains("the driver takes the weight out"), "{:?}", said.reasons);
        assert_eq!(said.next.unwrap(), OWN_SIGNALS);
    }

    #[test]
    fn a_clean_log_is_not_accused() {
        for seed in 0..8 {
            for noise in [0.0, 0.02, 0.2, 1.0, 3.0] {
                let sign = if seed % 2 == 0 { 1.0 } else { -1.0 };
                let moving = verdict(&log(12.0, noise, sign, seed));
                let standing = verdict(&rests(12 + 4 * seed as usize, noise, seed));
                for said in [moving, standing] {
                    assert!(said.reasons.is_empty() || said.trust == Trust::WithCare, "{noise}: {:?}", said.reasons);
                    assert!(noise > 0.2 || said.trust == Trust::Yes, "{noise}: {:?}", said.claims);
                }
            }
        }
    }
}
