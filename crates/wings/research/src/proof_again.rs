//! Verifies the proof in a plan file: computes the proven bound again from the robot description and the candidates in the
//! file.
//!
//! The rows of each candidate are computed from its motion. The proof is a tree of splits of the set of plans. Each leaf has a
//! design, and the tangent of log det F at this design is an upper bound for the plans of the leaf
//! ([`experiments::plan::relaxed_design`]; F: information matrix). Each experiment of the plan names one of the candidates. The
//! quality that the file states is not used.

use linear_model::regressor::Regressor;
use logs::Error;
use numerics::information_matrix::{InformationMatrix, WeightedRows};
use numerics::interruption::Interruption;
use processor::{in_order, threads};

use experiments::plan::candidates::Candidate;
use experiments::plan::exchange::{Criterion, scales, value_of};
use experiments::plan::exciting_trajectory::ExcitingTrajectory;
use experiments::plan::experiment_plan::ExperimentPlan;
use experiments::plan::plan_proof::{PlanProof, ProofNode};
use experiments::plan::planned_experiment::{CandidateMotion, PlannedExperiment};
use experiments::plan::relaxed_design::{Bounds, Tangent, tangent};

/// Two candidates count as equal if their information matrices differ by at most this fraction of the trace.
const EQUAL_SHARE: f64 = 1e-9;

/// The lower bound of the plan's D-efficiency, in [0, 1], computed from its proof. `None` if there is no proof, or a proof of an
/// earlier version that does not list its candidates.
///
/// Fails if the proof is invalid: a candidate is not a valid motion, an experiment differs from the candidate that it names, or
/// the tree is malformed.
pub(crate) fn efficiency_again(
    plan: &ExperimentPlan,
    regressor: &dyn Regressor,
    file: &str,
) -> Result<Option<f64>, Error> {
    let Some(proof) = plan.proof.as_ref().filter(|proof| !proof.candidates.is_empty()) else { return Ok(None) };
    let fail = |what: String| Error::at(file, 0, format!("its proof: {what}"));
    let chosen = chosen(plan, proof).map_err(fail)?;
    let trajectories = proof.candidates.iter().enumerate().map(|(i, candidate)| {
        plan.trajectory(&experiment(candidate)).map_err(|what| fail(format!("candidate {i}: {what}")))
    });
    let trajectories = trajectories.collect::<Result<Vec<_>, _>>()?;
    let (mut blocks, noise) = (Vec::new(), &plan.torque_noise);
    if noise.len() != regressor.coordinates().len() || noise.iter().any(|s| !(s.is_finite() && *s > 0.0)) {
        return Err(fail(format!("torque_noise {noise:?}: expected is a positive number per coordinate")));
    }
    let rows = |_, t: &ExcitingTrajectory| Candidate::new(t.clone(), regressor, noise).information;
    in_order(&trajectories, threads(), rows, |_, rows| {
        Interruption::check().map_err(|e| Error::new(e.message()))?;
        blocks.push(rows);
        Ok::<(), Error>(())
    })?;
    let p = blocks.first().map_or(0, WeightedRows::width);
    let scale = scales(p, blocks.iter());
    let blocks: Vec<WeightedRows> = blocks.iter().map(|b| b.scaled(&scale)).collect();
    let bound = bound(proof, &blocks, chosen.len()).map_err(fail)?;
    let value = value_of(&blocks, &chosen, Criterion::Determinant);
    Ok(Some(((value - bound.max(value)) / p.max(1) as f64).exp()))
}

fn experiment(candidate: &CandidateMotion) -> PlannedExperiment {
    let CandidateMotion { kind, fast, slow, centre, swing, sweep } = candidate.clone();
    PlannedExperiment { kind, fast, slow, centre, swing, sweep, ..PlannedExperiment::default() }
}

/// The indices of the candidates that the experiments name. Fails if an experiment differs from its candidate.
fn chosen(plan: &ExperimentPlan, proof: &PlanProof) -> Result<Vec<usize>, String> {
    let one = |e: &PlannedExperiment| {
        let index = e.candidate.ok_or(format!("experiment {} names no candidate", e.name))?;
        let own = CandidateMotion {
            kind: e.kind.clone(),
            fast: e.fast.clone(),
            slow: e.slow.clone(),
            centre: e.centre.clone(),
            swing: e.swing.clone(),
            sweep: e.sweep.clone(),
        };
        match proof.candidates.get(index) {
            Some(candidate) if *candidate == own => Ok(index),
            _ => Err(format!("experiment {} is not candidate {index}", e.name)),
        }
    };
    plan.experiments.iter().map(one).collect()
}

/// The largest upper bound of log det F (F: information matrix) over all leaves of the proof's tree. This value is the bound
/// for all plans.
fn bound(proof: &PlanProof, blocks: &[WeightedRows], count: usize) -> Result<f64, String> {
    let mut high = vec![count; blocks.len()];
    check_equal(proof, blocks)?;
    proof.equal.iter().for_each(|(left_out, _)| high[*left_out] = 0);
    let mut tangents: Vec<Option<Tangent>> = vec![None; proof.designs.len()];
    let mut worst = f64::NEG_INFINITY;
    let mut left = vec![(0, Bounds { low: vec![0; blocks.len()], high })];
    let mut is_seen = vec![false; proof.tree.len()];
    // Traverses the tree from its root. `left`: nodes that are not visited yet, each with the bounds from the splits above it.
    while let Some((node, bounds)) = left.pop() {
        let of_node = proof.tree.get(node).filter(|_| !is_seen[node]);
        let node_found = of_node.ok_or(format!("node {node} is none of the tree, or stands in it twice"))?;
        is_seen[node] = true;
        match *node_found {
            ProofNode::Split { candidate, at_most, below, above } => {
                if candidate >= blocks.len() {
                    return Err(format!("there is no candidate {candidate}"));
                }
                let (mut fewer, mut more) = (bounds.clone(), bounds);
                fewer.cut(candidate, at_most, true);
                more.cut(candidate, at_most.min(count), false);
                left.extend([(below, fewer), (above, more)]);
            }
            ProofNode::Leaf { design } => {
                // If a lower bound is above an upper bound, the leaf contains no plans.
                if bounds.low.iter().zip(&bounds.high).any(|(low, high)| low > high) {
                    continue;
                }
                let known = tangents.get_mut(design).ok_or(format!("there is no design {design}"))?;
                if known.is_none() {
                    // Several leaves may use a design, so its tangent is computed only once.
                    *known = Some(tangent_of(&proof.designs[design], blocks)?);
                }
                let bound = known.as_ref().map_or(f64::INFINITY, |tangent| tangent.bound(&bounds, count).0);
                worst = if bound.is_nan() { f64::INFINITY } else { worst.max(bound) };
            }
        }
    }
    Ok(worst)
}

/// The tangent (linear upper bound of log det F) at a design in the file. Fails if the design is malformed.
fn tangent_of(design: &[(usize, f64)], blocks: &[WeightedRows]) -> Result<Tangent, String> {
    let mut x = vec![0.0; blocks.len()];
    for &(i, share) in design {
        match x.get_mut(i).filter(|_| share.is_finite() && share >= 0.0) {
            Some(x) => *x = share,
            None => return Err(format!("a design runs candidate {i} {share} times")),
        }
    }
    tangent(blocks, &x).ok_or("a design has not full rank".into())
}

/// Fails if a candidate has other information than the candidate that replaces it, or if the replacement is itself replaced.
fn check_equal(proof: &PlanProof, blocks: &[WeightedRows]) -> Result<(), String> {
    for &(left_out, kept) in &proof.equal {
        let (Some(a), Some(b)) = (blocks.get(left_out), blocks.get(kept)) else {
            return Err(format!("there is no candidate {left_out} or {kept}"));
        };
        let square = |rows: &WeightedRows| InformationMatrix::sum(rows.width(), 0.0, [(rows, 1.0)]);
        let (a, b) = (square(a), square(b));
        let p = blocks[left_out].width();
        let is_equal = (0..p).all(|i| (0..=i).all(|j| (a.at(i, j) - b.at(i, j)).abs() <= EQUAL_SHARE * a.trace()));
        if kept >= left_out || proof.equal.iter().any(|(other, _)| *other == kept) || !is_equal {
            return Err(format!("candidate {kept} does not stand for candidate {left_out}"));
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::test_arm::Pendulum;
    use crate::test_arm::test_plans::{grid, limits};
    use experiments::plan::candidates::candidates;
    use experiments::plan::exchange::{ExchangeSettings, SearchEffort};
    use linear_model::reference::ModelReference;

    /// The D-efficiency of the plan is computed from the proof in the file. A change of the file that would increase the
    /// D-efficiency is detected.
    #[test]
    fn a_proof_is_worth_what_its_file_proves() {
        rist::wings::register(vec![crate::wing()]);
        let (arm, noise) = (Pendulum::new(), [0.1]);
        let model = ModelReference { name: "pendulum".into(), fingerprint: "0123".into() };
        let search = SearchEffort { starts: 2, nodes: 200, ..SearchEffort::default() };
        let choice = ExchangeSettings { count: 4, criterion: Criterion::Determinant, search };
        let found = candidates(&grid(), &limits()[..1], &arm, &noise);
        let plan = ExperimentPlan::choose(model, &arm, &found, &noise, &choice, &|_, _, _| ());
        let text = plan.to_yaml().unwrap();
        let plan = ExperimentPlan::from_yaml("plan.yaml", &text).unwrap();
        let again = |plan: &ExperimentPlan| efficiency_again(plan, &arm, "plan.yaml");
        let efficiency = again(&plan).unwrap().unwrap();
        // The leaves may prove a higher efficiency than the file states, because the search ends within its tolerance.
        let said = plan.d_efficiency_at_least;
        assert!(efficiency >= said - 1e-9 && efficiency <= 1.0, "{efficiency} {said}");
        let mut worse = plan.clone();
        let proof = worse.proof.as_mut().unwrap();
        proof.designs.iter_mut().for_each(|design| design.iter_mut().for_each(|x| x.1 *= 2.0));
        assert!(again(&worse).unwrap().unwrap() < 0.9 * efficiency);
        let refused = |change: &dyn Fn(&mut ExperimentPlan)| {
            let mut changed = plan.clone();
            change(&mut changed);
            again(&changed).unwrap_err().to_string()
        };
        let text = refused(&|plan| plan.experiments[0].candidate = None);
        assert!(text.contains("its proof: experiment e01 names no candidate"), "{text}");
        let text = refused(&|plan| plan.experiments[0].centre[0] += 0.1);
        assert!(text.contains("experiment e01 is not candidate"), "{text}");
        let text = refused(&|plan| plan.proof.as_mut().unwrap().equal.push((1, 0)));
        assert!(text.contains("candidate 0 does not stand for candidate 1"), "{text}");
        let text = refused(&|plan| {
            plan.proof.as_mut().unwrap().tree = vec![ProofNode::Split { candidate: 0, at_most: 1, below: 0, above: 0 }];
        });
        assert!(text.contains("node 0 is none of the tree, or stands in it twice"), "{text}");
        let text = refused(&|plan| plan.torque_noise[0] = 0.0);
        assert!(text.contains("torque_noise"), "{text}");
        let none = ExperimentPlan { proof: None, ..plan };
        assert_eq!(again(&none).unwrap(), None);
    }
}
