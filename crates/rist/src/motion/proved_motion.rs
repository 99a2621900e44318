//! From what a search found to a motion that is proven, and what the proof costs.
//!
//! A search looks at torques at instants; between them they are greater. A motion that is made smaller until its torques
//! are proven loses much where gravity is most of them: then the search goes on with a limit that is lower by what was
//! missing, and finds another motion.

use experiments::excitation::criterion::Aim;
use experiments::excitation::fitting::{Fitted, Obligations, fitted};
use experiments::excitation::motion::{Motion, Shape};
use experiments::excitation::problem::Problem;
use experiments::excitation::proof::{CertificateRow, Kept};
use experiments::excitation::search::{Found, criterion_of, searched_on};
use experiments::excitation::torque_wall::TorqueWall;
use numerics::interruption::Interruption;

use crate::request::ExciteRequest;

/// A motion with its certificate.
pub(crate) struct ProvedMotion {
    pub(crate) motion: Motion,
    pub(crate) certificate: Vec<CertificateRow>,
    /// What it has of det^(1/p) (or 1/cond) of the best motion of the search, at the instants of the search.
    pub(crate) kept_share: f64,
    /// The greatest torque or power over its limit that instants or a proof of the motion showed, before it was made smaller.
    beyond: f64,
}

/// Share of the search's best below which the search goes on.
const ENOUGH_KEPT: f64 = 0.9;
/// Times that it goes on.
const MOST_SEARCHES_MORE: usize = 2;
/// What a lower limit is lower than what was missing.
const BELOW_MISSING: f64 = 0.99;

/// The first of the motions that is proven; the first of all where none is. `None` where there are none.
pub(crate) fn proved(
    request: &ExciteRequest,
    problem: &Problem,
    obligations: &Obligations,
    shape: Shape,
    found: Vec<Found>,
) -> Option<ProvedMotion> {
    let best = found.first()?.criterion;
    let first = found.first()?.joints.clone();
    // A motion made smaller until it is proven, and the share of the criterion that is left of it.
    let fit = |joints: Vec<Vec<f64>>| {
        let Fitted { motion, certificate, beyond } = fitted(request.motion(shape, joints), obligations);
        let criterion = criterion_of(problem, &motion.joints).unwrap_or(f64::INFINITY);
        ProvedMotion { motion, certificate, kept_share: (best - criterion).exp(), beyond }
    };
    // The best found that needs no more than that; later ones are fitted only where the first fails.
    let goes_on = |_: &Found| Interruption::check().is_ok();
    let mut all = found.into_iter().take_while(goes_on).map(|found| fit(found.joints));
    let first_fit = all.next()?;
    let mut beyond = first_fit.beyond;
    let mut chosen = if is_proven(&first_fit.certificate) {
        first_fit
    } else {
        all.find(|fit| is_proven(&fit.certificate)).unwrap_or(first_fit)
    };
    // Search on from the best, below limits lowered by what its proof was short of.
    let mut share = 1.0;
    let mut from = first;
    for _ in 0..MOST_SEARCHES_MORE {
        let is_enough = is_proven(&chosen.certificate) && chosen.kept_share >= ENOUGH_KEPT;
        let Some(wall) = problem.torque.filter(|_| !is_enough && Interruption::check().is_ok()) else { break };
        share *= BELOW_MISSING / beyond;
        let lower = TorqueWall { share: share * wall.share, ..wall.clone() };
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

/// What the proof costs, where that is much; else `None`.
pub(crate) fn cost_note(proved: &ProvedMotion, aim: Aim) -> Option<String> {
    let what = match aim {
        Aim::Determinant => "det^(1/p)",
        Aim::Condition => "1/cond_fro",
    };
    (proved.kept_share < ENOUGH_KEPT).then(|| {
        format!(
            "the motion has {:.0} % of the {what} of the best one that the search found, which no proof could be given for: \
             limits of torque that are farther away, or a longer [period], would leave more",
            100.0 * proved.kept_share
        )
    })
}

fn is_proven(rows: &[CertificateRow]) -> bool {
    rows.iter().all(|r| r.kept == Kept::Proven)
}
