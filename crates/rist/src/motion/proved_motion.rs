//! Chooses a motion whose limits are proven among the results of a search, and computes the loss of information that the proof
//! causes.
//!
//! A search evaluates torques only at instants, but torques can be greater between these instants. The amplitudes are then
//! reduced until the torques are proven. If gravity dominates the torques, this loses much information. In this case the search
//! is repeated with a lower torque limit, which gives another motion.
//!
//! The criterion det^(1/p) measures the information of a motion on p parameters; cond is the condition number.

use experiments::excitation::criterion::SearchObjective;
use experiments::excitation::fitting::{Fitted, Obligations, fitted};
use experiments::excitation::motion::{Motion, MotionShape};
use experiments::excitation::problem::Problem;
use experiments::excitation::proof::{CertificateRow, LimitProof};
use experiments::excitation::search::{StartResult, criterion_of, searched_on};
use experiments::excitation::torque_barrier::TorqueBarrier;
use numerics::interruption::Interruption;

use crate::request::ExciteRequest;

/// A motion with its certificate.
pub(crate) struct ProvedMotion {
    pub(crate) motion: Motion,
    pub(crate) certificate: Vec<CertificateRow>,
    /// Criterion det^(1/p) (or 1/cond) of this motion, divided by the criterion of the best motion of the search. Both are
    /// computed at the instants of the search.
    pub(crate) kept_share: f64,
    /// Largest ratio of torque or power to its limit before the amplitudes were reduced. The ratio is taken at instants, or
    /// from the bound of the proof.
    beyond: f64,
}

/// A further search follows if the proven motion has less than this share of the best criterion.
const ENOUGH_KEPT: f64 = 0.9;
/// Largest number of further searches.
const MOST_SEARCHES_MORE: usize = 2;
/// A lowered torque limit is multiplied by this factor. So the limit is slightly below the value that would just remove the
/// excess.
const BELOW_MISSING: f64 = 0.99;

/// The first motion of `found` whose limits are proven, or the first motion if none is proven. The motion of a further search
/// replaces this motion in two cases: only the further motion is proven, or the further motion has a larger share of the best
/// criterion. `None` if `found` is empty.
pub(crate) fn proved(
    request: &ExciteRequest,
    problem: &Problem,
    obligations: &Obligations,
    shape: MotionShape,
    found: Vec<StartResult>,
) -> Option<ProvedMotion> {
    let best = found.first()?.criterion;
    let first = found.first()?.joints.clone();
    // Reduces the amplitudes of a motion until the limits of the motion are proven, and computes the share of the best
    // criterion that remains.
    let fit = |joints: Vec<Vec<f64>>| {
        let Fitted { motion, certificate, beyond } = fitted(request.motion(shape, joints), obligations);
        let criterion = criterion_of(problem, &motion.joints).unwrap_or(f64::INFINITY);
        ProvedMotion { motion, certificate, kept_share: (best - criterion).exp(), beyond }
    };
    // Other motions are tried only if the best motion is not proven after this reduction.
    let goes_on = |_: &StartResult| Interruption::check().is_ok();
    let mut all = found.into_iter().take_while(goes_on).map(|found| fit(found.joints));
    let first_fit = all.next()?;
    let mut beyond = first_fit.beyond;
    let mut chosen = if is_proven(&first_fit.certificate) {
        first_fit
    } else {
        all.find(|fit| is_proven(&fit.certificate)).unwrap_or(first_fit)
    };
    // Further searches start at the best motion. Each further search lowers the torque limits by the excess that the last proof
    // found.
    let mut share = 1.0;
    let mut from = first;
    for _ in 0..MOST_SEARCHES_MORE {
        let is_enough = is_proven(&chosen.certificate) && chosen.kept_share >= ENOUGH_KEPT;
        let Some(wall) = problem.torque.filter(|_| !is_enough && Interruption::check().is_ok()) else { break };
        share *= BELOW_MISSING / beyond;
        let lower = TorqueBarrier { share: share * wall.share, ..wall.clone() };
        let lower = Problem { torque: Some(&lower), ..problem.clone() };
        let Some(again) = searched_on(&lower, request.iterations, request.search().threads, &from) else { break };
        from.clone_from(&again.joints);
        let fit = fit(again.joints);
        beyond = fit.beyond;
        let rank = |fit: &ProvedMotion| (is_proven(&fit.certificate), fit.kept_share);
        if rank(&fit) > rank(&chosen) {
            chosen = fit;
        }
    }
    Some(chosen)
}

/// A note on the loss of information caused by the proof; `None` if the loss is small.
pub(crate) fn cost_note(proved: &ProvedMotion, aim: SearchObjective) -> Option<String> {
    let what = match aim {
        SearchObjective::Determinant => "det^(1/p)",
        SearchObjective::Condition => "1/cond_fro",
    };
    (proved.kept_share < ENOUGH_KEPT).then(|| {
        format!(
            "the motion has {:.0} % of the {what} of the best one that the search found, which no proof could be given for: \
             limits of torque that are farther away, or a longer [period], would allow more",
            100.0 * proved.kept_share
        )
    })
}

fn is_proven(rows: &[CertificateRow]) -> bool {
    rows.iter().all(|r| r.kept == LimitProof::Proven)
}
