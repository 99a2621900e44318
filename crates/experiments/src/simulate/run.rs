//! Runs several simulated motions together, so that their dynamics A(q) and h(q, dq) are evaluated in one call.
//!
//! Between two evaluations of the dynamics each motion advances by one stage; a step has four stages. The motions are
//! independent: each result equals the result of a separate run, bit for bit.

use numerics::positive_definite::solve_positive;

use crate::motion::record::Record;
use crate::motion::reference_motion::Reference;
use crate::simulate::closed_loop::{Law, Simulation, Steps, Stop, quantised};
use crate::simulate::dynamics::Dynamics;
use crate::simulate::stiff_friction::{FrictionLoad, StiffStep};

/// Stages of Runge-Kutta 4. For each: its weight in the sum, and the time of the next stage as a fraction of the step.
const STAGES: [(f64, f64); 4] = [(1.0, 0.5), (2.0, 0.5), (2.0, 1.0), (1.0, 0.0)];
/// A simulated motion counts as diverged if a position (rad or m) or a velocity (rad/s or m/s) exceeds this value.
const DIVERGENCE_BOUND: f64 = 1e6;

impl Simulation<'_> {
    /// Simulates the robot while it follows the reference. `feedforward[k][i]` (N m) is added to the controller's torque of
    /// coordinate k at sample i.
    ///
    /// The record has no noise and is not rounded. It ends early if the motion is not physical.
    pub fn run(&self, reference: &Reference, feedforward: Option<&[Vec<f64>]>) -> (Record, Stop) {
        self.run_under(reference, self.law(reference, feedforward))
    }

    /// Simulates the robot under another control law than its PD controllers; gives the record, and the reason for its end.
    pub fn run_under<'a>(&'a self, reference: &'a Reference, law: Box<Law<'a>>) -> (Record, Stop) {
        let mut run = SimulationRun::new(self, reference, law);
        follow(self.dynamics, std::slice::from_mut(&mut run));
        run.ended()
    }
}

/// Simulates all `runs` to their ends. The simulations of all runs must have the dynamics `dynamics`.
pub(crate) fn follow(dynamics: &dyn Dynamics, runs: &mut [SimulationRun]) {
    let n = dynamics.n_coordinates();
    let (mut inertia, mut bias) = (vec![0.0; runs.len() * n * n], vec![0.0; runs.len() * n]);
    loop {
        let states: Vec<(&[f64], &[f64])> = runs.iter().filter_map(SimulationRun::asks).collect();
        if states.is_empty() {
            return;
        }
        let count = states.len();
        dynamics.fill_each(&states, &mut inertia[..count * n * n], &mut bias[..count * n]);
        let answers = inertia.chunks_exact_mut((n * n).max(1)).zip(bias.chunks_exact_mut(n.max(1)));
        for (run, (inertia, bias)) in runs.iter_mut().filter(|run| run.asks().is_some()).zip(answers) {
            run.take(inertia, bias);
        }
    }
}

/// A simulated motion that is suspended until the next evaluation of its dynamics.
pub(crate) struct SimulationRun<'a> {
    simulation: &'a Simulation<'a>,
    reference: &'a Reference,
    law: Box<Law<'a>>,
    record: Record,
    stop: Option<Stop>,
    /// Indices of the current sample, of the integration step in this sample, and of the stage in this step.
    at: (usize, usize, usize),
    /// Position q and velocity dq of the current stage, rad (m) and rad/s (m/s). `begin`: both at the start of the step.
    q: Vec<f64>,
    dq: Vec<f64>,
    begin: (Vec<f64>, Vec<f64>),
    /// Weighted sums of the velocities and of the accelerations over the Runge-Kutta stages so far.
    sum_v: Vec<f64>,
    sum_a: Vec<f64>,
    /// Number of integration steps per sample; `stiff`: data of the implicit step, `None` for Runge-Kutta.
    steps: usize,
    stiff: Option<StiffStep>,
    /// `tau`: drive torques, N m, constant until the next sample. `held`: their currents, A.
    tau: Vec<f64>,
    held: Vec<f64>,
    /// Positions that the controller read at the last sample, and their filtered velocities.
    seen: Vec<f64>,
    velocity: Vec<f64>,
}

impl<'a> SimulationRun<'a> {
    /// Starts a run at the first sample of the reference, with the velocity of that sample.
    pub(crate) fn new(simulation: &'a Simulation, reference: &'a Reference, law: Box<Law<'a>>) -> SimulationRun<'a> {
        let n = simulation.dynamics.n_coordinates();
        let first =
            |series: &[Vec<f64>]| -> Vec<f64> { series.iter().map(|x| x.first().copied().unwrap_or(0.0)).collect() };
        let (q, dq, zeros) = (first(&reference.q), first(&reference.dq), || vec![0.0; n]);
        let (steps, stiff) = match simulation.steps {
            Steps::RungeKutta(steps) => (steps, None),
            Steps::ImplicitFriction(steps) => (steps, Some(StiffStep::new(n))),
        };
        // The first stage starts from the state at the start of the step, so `q` and `dq` equal `begin`.
        let mut run = SimulationRun {
            simulation,
            reference,
            law,
            record: Record { sample_time: reference.sample_time, q: vec![Vec::new(); n], current: vec![Vec::new(); n] },
            stop: None,
            at: (0, 0, 0),
            begin: (q.clone(), dq.clone()),
            velocity: dq.clone(),
            q,
            dq,
            sum_v: zeros(),
            sum_a: zeros(),
            steps,
            stiff,
            tau: zeros(),
            held: zeros(),
            seen: zeros(),
        };
        // The torque of the first sample acts from time zero.
        run.control();
        run
    }

    /// The record of the run, and the reason for its end.
    ///
    /// Panics if the motion has not ended.
    pub(crate) fn ended(self) -> (Record, Stop) {
        (self.record, self.stop.expect("the run was followed to its end"))
    }

    /// The state (q, dq) at which the run next needs the dynamics. `None` if the motion has ended.
    fn asks(&self) -> Option<(&[f64], &[f64])> {
        self.stop.is_none().then_some((&self.q, &self.dq))
    }

    /// One cycle of the controller: reads the rounded position, filters its backward difference, and computes the limited torque.
    fn control(&mut self) {
        let (i, reference, simulation) = (self.at.0, self.reference, self.simulation);
        if i >= reference.q.first().map_or(0, Vec::len) {
            self.stop = Some(Stop::End);
            return;
        }
        let h = reference.sample_time;
        let decay = (-simulation.controller.velocity_pole * h).exp();
        for k in 0..self.q.len() {
            let seen = quantised(self.q[k], simulation.quantum[k]);
            if i > 0 {
                self.velocity[k] = decay * self.velocity[k] + (1.0 - decay) * (seen - self.seen[k]) / h;
            }
            self.seen[k] = seen;
        }
        (self.law)(i, &self.seen, &self.velocity, &mut self.tau);
        for k in 0..self.q.len() {
            let limit = simulation.drives.greatest_torque[k];
            let torque = self.tau[k].clamp(-limit, limit);
            let current = torque / simulation.drives.gain[k];
            // The record contains the mean of the currents before and after each sample.
            self.record.q[k].push(self.q[k]);
            self.record.current[k].push(if i == 0 { current } else { 0.5 * (self.held[k] + current) });
            self.held[k] = current;
            self.tau[k] = torque;
        }
    }

    /// Advances the motion by one stage. `inertia` (A, n x n, row by row) and `bias` (h) are the inertia matrix and the bias
    /// torque at the state of [`SimulationRun::asks`]. Both are overwritten.
    fn take(&mut self, inertia: &mut [f64], bias: &mut [f64]) {
        let (sample, step, stage) = self.at;
        let free = bias;
        // free = tau - h: drive torque tau minus bias torque h. The integrator subtracts the friction.
        free.iter_mut().zip(&self.tau).for_each(|(free, tau)| *free = tau - *free);
        let length = self.reference.sample_time / self.steps as f64;
        let went_on = match &mut self.stiff {
            Some(stiff) => {
                let felt = FrictionLoad { friction: self.simulation.friction, tau: &self.tau, length };
                let (begin, state) = ((&self.begin.0[..], &self.begin.1[..]), (&mut self.q[..], &mut self.dq[..]));
                stiff.take(stage, &felt, begin, state, (inertia, free))
            }
            None => self.runge_kutta(stage, length, inertia, free),
        };
        if !went_on {
            return self.break_down();
        }
        if stage + 1 < STAGES.len() {
            self.at.2 = stage + 1;
            return;
        }
        // A diverging control loop ends the motion as not physical.
        if !self.q.iter().chain(&self.dq).all(|x| x.abs() < DIVERGENCE_BOUND) {
            return self.break_down();
        }
        self.begin.0.copy_from_slice(&self.q);
        self.begin.1.copy_from_slice(&self.dq);
        self.at = (sample, step + 1, 0);
        if step + 1 == self.steps {
            self.at = (sample + 1, 0, 0);
            self.control();
        }
    }

    /// One stage of Runge-Kutta 4 in a step of `length` s; `free`: drive torque minus bias torque, tau - h. Returns false if A is
    /// not positive definite.
    fn runge_kutta(&mut self, stage: usize, length: f64, inertia: &mut [f64], free: &mut [f64]) -> bool {
        // ddq = A^-1 (tau - h - G). A: inertia matrix; tau: drive torque; h: bias torque; G: friction torque.
        let ddq = free;
        for (k, ddq) in ddq.iter_mut().enumerate() {
            *ddq -= self.simulation.friction[k].torque(self.dq[k], self.tau[k]);
        }
        if !solve_positive(inertia, ddq) {
            return false;
        }
        let (weight, ahead) = STAGES[stage];
        let (q0, v0) = &self.begin;
        for k in 0..ddq.len() {
            let first = if stage == 0 { 0.0 } else { 1.0 };
            self.sum_v[k] = first * self.sum_v[k] + weight * self.dq[k];
            self.sum_a[k] = first * self.sum_a[k] + weight * ddq[k];
            let v = self.dq[k];
            self.dq[k] = v0[k] + ahead * length * ddq[k];
            self.q[k] = q0[k] + ahead * length * v;
        }
        if stage + 1 == STAGES.len() {
            for k in 0..self.q.len() {
                self.q[k] = q0[k] + length / 6.0 * self.sum_v[k];
                self.dq[k] = v0[k] + length / 6.0 * self.sum_a[k];
            }
        }
        true
    }

    fn break_down(&mut self) {
        self.stop = Some(Stop::NotPhysical { time: self.at.0 as f64 * self.reference.sample_time });
    }
}

#[cfg(test)]
mod tests {
    use linear_model::friction::law::FrictionLaw;

    use super::*;
    use crate::motion::profile::Profile;
    use crate::plan::exciting_trajectory::{ExcitingTrajectory, MovingJoints, SwingCourse};
    use crate::plan::motion_kind::MotionKind;
    use crate::simulate::closed_loop::{Drives, JointPd};
    use crate::simulate::defaults::POSITION_QUANTUM;

    /// A hanging arm with a light flange at its end; the flange makes its friction stiff.
    struct ArmAndFlange;

    impl Dynamics for ArmAndFlange {
        fn n_coordinates(&self) -> usize {
            2
        }

        fn fill(&self, q: &[f64], dq: &[f64], inertia: &mut [f64], bias: &mut [f64]) {
            // The coupling 0.007 is half of the greatest value for which the inertia matrix is positive definite.
            inertia.copy_from_slice(&[2.0, 0.007, 0.007, 1e-4]);
            bias.copy_from_slice(&[9.0 * q[0].sin() + 0.1 * dq[0] * dq[1], 1e-3 * q[1].sin()]);
        }
    }

    /// A reference in which both joints swing in opposite directions.
    fn swing() -> Reference {
        let (kind, profile, centre) = (MotionKind::Inertial, Profile::Smooth, [0.0; 2]);
        let joints = MovingJoints { kind, fast: 0, slow: &[], centre: &centre };
        let course = SwingCourse {
            profile,
            period: 500,
            acceleration: 60.0,
            slow_velocity: &centre,
            duration: 1.0,
            sample_time: 1e-3,
        };
        let swing = ExcitingTrajectory::swing(&joints, &course);
        let mut both = swing.reference();
        for series in [&mut both.q, &mut both.dq, &mut both.ddq] {
            series[1] = series[0].iter().map(|x| -0.6 * x).collect();
        }
        both
    }

    /// The record of the arm under friction of 1 N m at the flange, and the integration steps. `steps`: given steps; `None`: the
    /// steps that [`Simulation::with_short_steps`] selects.
    fn record(smoothing: f64, steps: Option<Steps>) -> (Record, Steps) {
        let reference = swing();
        let inertia = [2.0, 1e-4];
        let controller = JointPd::for_inertia(&inertia, &[8.0; 2], 900.0);
        let drives = Drives { gain: vec![1.0; 2], greatest_torque: vec![100.0, 20.0] };
        let law = |f| FrictionLaw { smoothing, ..FrictionLaw::asymmetric(0.5 * f, f, 0.4 * f, -0.9 * f) };
        let simulation = Simulation {
            dynamics: &ArmAndFlange,
            controller: &controller,
            drives: &drives,
            quantum: &[0.0; 2],
            friction: &[law(4.0), law(1.0)],
            steps: steps.unwrap_or(Steps::RungeKutta(2)),
        };
        let simulation = if steps.is_none() { simulation.with_short_steps(&reference) } else { simulation };
        let known = |k: usize| {
            let instants = reference.dq[k].iter().zip(&reference.ddq[k]);
            instants.map(|(v, a)| inertia[k] * a + simulation.friction[k].torque(*v, 0.0)).collect()
        };
        let feedforward: Vec<Vec<f64>> = (0..2).map(known).collect();
        let (record, stop) = simulation.run(&reference, Some(&feedforward));
        assert_eq!(stop, Stop::End);
        (record, simulation.steps)
    }

    fn apart(a: &Record, b: &Record, k: usize) -> f64 {
        a.q[k].iter().zip(&b.q[k]).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max)
    }

    #[test]
    fn steps_through_stiff_friction_are_of_second_order() {
        // With this smoothing, friction is smooth enough that both methods converge: half the step gives a quarter of the error.
        let (exact, _) = record(1.0, Some(Steps::RungeKutta(64)));
        let error = |steps| apart(&record(1.0, Some(Steps::ImplicitFriction(steps))).0, &exact, 0);
        let (coarse, fine) = (error(16), error(32));
        assert!(coarse / fine > 3.0 && fine < 1e-7, "{coarse:e} {fine:e}");
    }

    #[test]
    fn a_light_flange_takes_few_steps_and_moves_as_in_many() {
        // A friction slope of 190 N m s over an inertia of 7.5e-5 kg m^2 needs 1260 Runge-Kutta steps per sample.
        let (many, _) = record(0.005, Some(Steps::RungeKutta(1300)));
        let (few, steps) = record(0.005, None);
        assert!(matches!(steps, Steps::ImplicitFriction(1..=4)), "{steps:?}");
        for k in 0..2 {
            let moved = many.q[k].iter().fold(0.0_f64, |most, q| most.max(q.abs()));
            let off = apart(&few, &many, k);
            // The positions by the implicit steps and by the Runge-Kutta steps differ by less than the resolution of any
            // simulated encoder. The motion is longer than 1000 of these resolutions.
            assert!(off < POSITION_QUANTUM && moved > 1000.0 * POSITION_QUANTUM, "{k}: {off:e} of {moved}");
        }
    }

    #[test]
    fn friction_that_is_hardly_stiff_stays_with_runge_kutta() {
        // A friction slope of 1.4 N m s over an inertia of 7.5e-5 kg m^2 needs 10 Runge-Kutta steps per sample.
        let (_, steps) = record(1.0, None);
        assert!(matches!(steps, Steps::RungeKutta(9..=11)), "{steps:?}");
    }
}
