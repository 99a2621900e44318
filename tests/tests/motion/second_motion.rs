//! Tests of a motion that is designed after a first estimate, and of a plan that is proven to be near the optimum.

use experiments::excitation::artefact::ExcitingMotion;
use experiments::plan::candidates::{Candidate, CandidateGrid, candidates};
use experiments::plan::exciting_trajectory::ExcitingTrajectory;
use experiments::plan::plan_proof::{PlanProof, ProofNode};
use experiments::simulate::defaults::motion_limits;
use experiments::simulate::dynamics::RegressorDynamics;
use experiments::simulate::setup::SimulationSetup;
use identification::estimate::artefact::Estimate;
use linear_model::friction::terms::FrictionTerm;
use nalgebra::{Cholesky, DMatrix};
use numerics::information_matrix::{InformationMatrix, WeightedRows};
use rist::Model;
use rist::motion::planning::PlanRequest;
use tests::program::{estimate, folder, motion, rist as run};
use tests::promise::{columns, information};
use tests::workspace;

/// The information in an estimate, as weighted rows W: W'W is the inverse covariance matrix.
fn known(model: &Model, estimate: &Estimate) -> WeightedRows {
    let columns = columns(model, &FrictionTerm::STANDARD);
    let place: Vec<usize> =
        columns.iter().map(|id| estimate.parameters.iter().position(|p| p.id == *id).unwrap()).collect();
    let covariance = DMatrix::from_fn(columns.len(), columns.len(), |i, j| estimate.covariance[place[i]][place[j]]);
    let upper = Cholesky::new(Cholesky::new(covariance).unwrap().inverse()).unwrap().l().transpose();
    let mut rows = WeightedRows::new(columns.len());
    upper.row_iter().for_each(|row| rows.push(&row.iter().copied().collect::<Vec<_>>()));
    rows
}

/// The criterion of a design: det(F)^(1/p), F: sum of the information matrices of these rows, p: number of parameters.
fn determinant(rows: &[&WeightedRows]) -> f64 {
    let p = rows[0].width();
    let factor = InformationMatrix::sum(p, 0.0, rows.iter().map(|r| (*r, 1.0))).factor().unwrap();
    (factor.log_det / p as f64).exp()
}

/// A motion is designed after an estimate. Together with the estimate, it gives more information than a repetition of the first
/// motion, and more than a motion that is designed without the estimate.
#[test]
fn a_second_motion_shows_what_the_first_left_open() {
    let folder = folder("second_motion");
    let urdf = workspace().join("models/ur5.urdf");
    let urdf = urdf.to_str().unwrap();
    let excite = |name: &str, more: &[&str]| {
        let common = ["excite", urdf, "--repetitions", "1", "--starts", "2", "--out", name];
        let found = run(&folder, &[&common[..], more].concat()).ended(0);
        (motion(&folder.join(name)), found.out)
    };
    let (first, _) = excite("first.yaml", &["--period", "4"]);
    let (other, _) = excite("other.yaml", &["--period", "4", "--seed", "2"]);
    assert_eq!(run(&folder, &["simulate", urdf, "first.yaml", "--validation", "0", "--out", "logs"]).code, Some(0));
    std::fs::write(folder.join("options.yaml"), "covariance: true\n").unwrap();
    let identify = ["identify", urdf, "logs/motion.csv", "--options", "options.yaml", "--out", "estimate.yaml"];
    let found = run(&folder, &identify);
    assert!(folder.join("estimate.yaml").is_file(), "{}{}", found.out, found.err);
    let (second, said) = excite("second.yaml", &["--period", "4", "--after", "estimate.yaml"]);
    assert!(!said.contains("has no covariance"), "{said}");
    // The torque limits of the second motion are checked with the identified parameters. The motion file contains them for the
    // check.
    assert!(second.identified.is_some());
    assert_eq!(run(&folder, &["check", urdf, "second.yaml"]).code, Some(0));

    let model = Model::read(urdf).unwrap();
    let known = known(&model, &estimate(&folder.join("estimate.yaml")));
    // All motions are compared with the same torque noise: the noise that follows from the residuals of the estimate, as in the
    // design.
    let with = |motion: &ExcitingMotion| {
        determinant(&[&known, &information(&model, motion, &second.torque_noise, &FrictionTerm::STANDARD)])
    };
    let (after, again, another) = (with(&second), with(&first), with(&other));
    eprintln!("designed after {after:.4e}, the first again {again:.4e}, another {another:.4e}");
    assert!(after > again && after > another, "{after} {again} {another}");
}

/// Upper bound of log det F (F: information matrix) over all plans in which the number of runs of each candidate is between `low`
/// and `high`. It follows from the tangent of log det F at a design. As a reader of plan.yaml would do, it uses no code of the
/// search, except the Cholesky factor.
fn leaf_bound(blocks: &[WeightedRows], design: &[(usize, f64)], low: &[usize], high: &[usize], count: usize) -> f64 {
    let (p, least) = (blocks[0].width(), low.iter().sum::<usize>());
    if least > count || high.iter().sum::<usize>() < count {
        return f64::NEG_INFINITY;
    }
    let factor = |weights: &mut dyn Iterator<Item = (usize, f64)>| {
        InformationMatrix::sum(p, 0.0, weights.map(|(i, x)| (&blocks[i], x))).factor()
    };
    let Some(factor) = factor(&mut design.iter().copied()) else {
        // At a singular design there is no tangent. Then the bound is log det of the information of all allowed candidates, each
        // with its largest number of runs.
        let allowed = factor(&mut high.iter().enumerate().filter(|(_, x)| **x > 0).map(|(i, x)| (i, *x as f64)));
        return allowed.map_or(f64::NEG_INFINITY, |all| all.log_det);
    };
    let inverse = factor.inverse();
    let quadratic = |row: &[f64]| -> f64 {
        (0..p).map(|i| row[i] * (0..p).map(|j| inverse[i * p + j] * row[j]).sum::<f64>()).sum()
    };
    let gain: Vec<f64> = blocks.iter().map(|b| b.iter().map(quadratic).sum()).collect();
    let mut runs: Vec<f64> = (0..blocks.len()).flat_map(|i| vec![gain[i]; high[i] - low[i]]).collect();
    runs.sort_by(|a, b| b.total_cmp(a));
    let fixed: f64 = low.iter().zip(&gain).map(|(x, g)| *x as f64 * g).sum();
    factor.log_det - p as f64 + fixed + runs[..count - least].iter().sum::<f64>()
}

/// Whether two sets of rows W have the same information matrix W'W, up to the rounding of their scaled columns.
fn is_equal(a: &WeightedRows, b: &WeightedRows) -> bool {
    let of = |rows: &WeightedRows, i: usize, j: usize| rows.iter().map(|row| row[i] * row[j]).sum::<f64>();
    let size = |i: usize, j: usize| (of(a, i, i) * of(a, j, j)).sqrt() + 1e-6 * a.trace();
    let entries = (0..a.width()).flat_map(|i| (0..=i).map(move |j| (i, j)));
    entries.into_iter().all(|(i, j)| (of(a, i, j) - of(b, i, j)).abs() <= 1e-6 * size(i, j))
}

/// Upper bound of log det that a whole proof gives: the largest bound of its leaves. It is infinite if a candidate is left out
/// although no equal candidate is kept.
fn proven_bound(blocks: &[WeightedRows], proof: &PlanProof, count: usize) -> f64 {
    let mut worst = f64::NEG_INFINITY;
    // Candidates may be left out if an equal candidate is kept.
    let mut high = vec![count; blocks.len()];
    for &(left_out, kept) in &proof.equal {
        if !is_equal(&blocks[left_out], &blocks[kept]) || high[kept] == 0 {
            return f64::INFINITY;
        }
        high[left_out] = 0;
    }
    let mut left = vec![(0, vec![0; blocks.len()], high)];
    while let Some((node, low, high)) = left.pop() {
        match proof.tree[node] {
            ProofNode::Leaf { design } => {
                worst = worst.max(leaf_bound(blocks, &proof.designs[design], &low, &high, count));
            }
            ProofNode::Split { candidate, at_most, below, above } => {
                let (mut low_above, mut high_below) = (low.clone(), high.clone());
                high_below[candidate] = high[candidate].min(at_most);
                low_above[candidate] = low[candidate].max(at_most + 1);
                // If the range of the number of runs is empty, the branch contains no plan.
                if low[candidate] <= high_below[candidate] {
                    left.push((below, low.clone(), high_below));
                }
                if low_above[candidate] <= high[candidate] {
                    left.push((above, low_above, high));
                }
            }
        }
    }
    worst
}

/// The candidate motions for the plan of a request, in the order that its proof uses.
fn candidates_of(model: &Model, request: &PlanRequest) -> Vec<Candidate> {
    let limits = motion_limits(&model.robot).0;
    let dynamics = RegressorDynamics::new(model.regressor(), model.nominal_parameters().unwrap());
    let noise = SimulationSetup::for_robot(&model.robot, &dynamics).sensing.torque_noise;
    let grid = CandidateGrid {
        profile: request.profile,
        steps: request.steps,
        configurations: request.configurations,
        duration: request.duration,
        sample_time: 1.0 / request.rate,
        gravity: model.robot.gravity_number() != [0.0; 3],
        seed: request.seed,
    };
    candidates(&grid, &limits, model.regressor(), &noise)
}

/// Returns the plan, the lower bound of its D-efficiency that follows from its file, the scaled rows of the candidates, and the
/// shift of log det by the scaling.
fn efficiency_by_hand(
    model: &Model,
    request: &PlanRequest,
) -> (rist::motion::planning::ExperimentPlan, f64, Vec<WeightedRows>, f64) {
    tests::register_wings();
    let planned = rist::plan(model, request, &|_, _, _| ()).unwrap().plan;
    let read = rist::motion::planning::ExperimentPlan::from_yaml("plan.yaml", &planned.to_yaml().unwrap()).unwrap();
    assert_eq!(read, planned);
    let proof = read.proof.as_ref().unwrap();
    let candidates = candidates_of(model, request);
    let blocks: Vec<WeightedRows> = candidates.iter().map(|c| c.information.clone()).collect();
    // The columns are scaled to equal norm for the Cholesky factor. The scaling shifts log det by a constant.
    let p = blocks[0].width() as f64;
    let square = |c: usize| blocks.iter().flat_map(|b| b.iter()).map(|row| row[c] * row[c]).sum::<f64>();
    let scale: Vec<f64> = (0..blocks[0].width()).map(|c| square(c).sqrt().recip()).collect();
    let shift = 2.0 * scale.iter().map(|s| s.ln()).sum::<f64>();
    let scaled: Vec<WeightedRows> = blocks.iter().map(|b| b.scaled(&scale)).collect();
    let bound = proven_bound(&scaled, proof, request.experiments) - shift;
    // Tolerance between two summations of a few hundred numbers.
    assert!(bound <= proof.log_det_at_most + 1e-8, "{bound} {}", proof.log_det_at_most);
    let trajectories = read.trajectories("plan.yaml").unwrap();
    let place = |t: &ExcitingTrajectory| candidates.iter().position(|c| c.trajectory == *t).unwrap();
    let chosen: Vec<&WeightedRows> = trajectories.iter().map(|t| &scaled[place(t)]).collect();
    let of_plan = InformationMatrix::sum(p as usize, 0.0, chosen.iter().map(|r| (*r, 1.0)));
    let reached = of_plan.factor().unwrap().log_det - shift;
    (planned, ((reached - bound) / p).exp(), scaled, shift)
}

#[test]
fn the_bound_of_a_plan_follows_from_its_file() {
    let model = Model::read(workspace().join("models/planar2r_vertical.yaml")).unwrap();
    let request = PlanRequest { experiments: 6, starts: 2, nodes: 60, configurations: 8, ..PlanRequest::default() };
    let (planned, efficiency, scaled, shift) = efficiency_by_hand(&model, &request);
    let proof = planned.proof.as_ref().unwrap();
    assert!(efficiency >= planned.d_efficiency_at_least - 1e-9, "{efficiency} {}", planned.d_efficiency_at_least);
    assert!(planned.d_efficiency_at_least > 0.95, "{}", planned.d_efficiency_at_least);
    // If all designs in the proof are replaced by uniform ones, the bound must be larger than the stated one.
    let mut cut = proof.clone();
    cut.designs.iter_mut().for_each(|d| d.iter_mut().for_each(|x| x.1 = 1.0));
    assert!(proven_bound(&scaled, &cut, 6) - shift > proof.log_det_at_most);
}

/// The plan is chosen from 275 candidate experiments, 93 of which are equal to another one. Its D-efficiency (information
/// relative to the optimal plan) is proven to be at least 99.9 %. The limit of 4000 nodes of the search tree is twice the number
/// needed.
#[test]
fn a_plan_of_race_is_the_best_but_for_a_thousandth() {
    let model = Model::read(workspace().join("models/race.yaml")).unwrap();
    let request = PlanRequest { experiments: 12, nodes: 4000, ..PlanRequest::default() };
    let (planned, efficiency, scaled, shift) = efficiency_by_hand(&model, &request);
    let proof = planned.proof.as_ref().unwrap();
    assert_eq!((scaled.len(), proof.equal.len()), (275, 93));
    // The search stops when the relative gap between the plan and the upper bound is 0.001.
    assert!(planned.d_efficiency_at_least >= 0.999 - 1e-6, "{}", planned.d_efficiency_at_least);
    assert!(efficiency >= planned.d_efficiency_at_least - 1e-9, "{efficiency} {}", planned.d_efficiency_at_least);
    // The proof must fail if a candidate is left out although it is not equal to the kept one.
    let mut cut = proof.clone();
    let other = (1..scaled.len()).find(|i| proof.equal.iter().all(|(left_out, _)| left_out != i)).unwrap();
    cut.equal.push((other, 0));
    assert_eq!(proven_bound(&scaled, &cut, 12) - shift, f64::INFINITY);
}
