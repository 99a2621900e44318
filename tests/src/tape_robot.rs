//! A robot whose functions are derived by `modeling` and evaluated by a tape (a list of operations). Tests and benches identify
//! its parameters.
//!
//! tau = Y(q, dq, ddq) X = A(q) ddq + h(q, dq). Y (n x p): base regressor; A (n x n): inertia matrix; h: bias torque; X (p): base
//! parameters, X = B phi; phi: standard parameters. Robots with loops that are closed numerically are not supported.

use std::sync::Arc;

use experiments::simulate::dynamics::{Dynamics, torque};
use expr::Tape;
use linear_model::parameter::BaseParameter;
use linear_model::pseudo_inertia::Ten;
use linear_model::regressor::Regressor;
use linear_model::standard_map::StandardMap;
use modeling::BaseParameters;
use robot::{Inertial, JointKind, LinkId, Robot, StandardParameter};

use crate::joint_log::described;

/// A robot with parameter values. It can be used as a regressor and as dynamics.
#[derive(Clone)]
pub struct TapeRobot {
    pub robot: Robot,
    /// The base parameters as combinations of standard parameters.
    pub base: BaseParameters,
    /// Values of the standard parameters, in the order of the columns of the standard regressor; zero if the description gives
    /// none.
    pub standard: Vec<f64>,
    pub truth: Vec<f64>,
    coordinates: Vec<String>,
    parameters: Vec<BaseParameter>,
    tapes: Arc<Tapes>,
}

struct Tapes {
    /// The tape of the base regressor: q, dq, ddq -> Y.
    regressor: Tape,
    /// The tape of the inertia matrix: q, X -> A.
    inertia: Tape,
    /// The tape of the bias torque: q, dq, X -> h.
    bias: Tape,
}

impl TapeRobot {
    /// Derives the functions of a robot. Panics if its number of base parameters is ambiguous, or if a joint variable is not an
    /// affine function of q.
    pub fn new(robot: Robot) -> TapeRobot {
        assert!(robot.passive.is_empty(), "{}: a joint is no affine function of q", robot.name);
        let (mut derivation, columns, base) = crate::derived(&robot);
        let tapes = Tapes {
            regressor: Tape::new(&base.regressor(&columns).bound()),
            inertia: Tape::new(&derivation.inertia_matrix(&base).bound()),
            bias: Tape::new(&derivation.bias(&base).bound()),
        };
        let standard = described(&robot);
        TapeRobot {
            truth: base.values(&standard),
            standard,
            coordinates: robot.coordinates.iter().map(|c| c.name.clone()).collect(),
            parameters: rist::describe::model::base_columns(&robot, &base),
            tapes: Arc::new(tapes),
            base,
            robot,
        }
    }

    pub fn with_standard(&self, standard: Vec<f64>) -> TapeRobot {
        TapeRobot { truth: self.base.values(&standard), standard, ..self.clone() }
    }

    /// q, dq, ddq and torques of an arm with two joints at time t, s. Each joint moves by two sines.
    pub fn swing_of_two(&self, t: f64) -> [Vec<f64>; 4] {
        let sine = |w: f64, a: f64| [a * (w * t).sin(), a * w * (w * t).cos(), -a * w * w * (w * t).sin()];
        let of_joint = |(w1, w2): (f64, f64)| std::array::from_fn(|k| sine(w1, 0.8)[k] + sine(w2, 0.3)[k]);
        let joints: [[f64; 3]; 2] = [(1.9, 5.3), (2.7, 4.1)].map(of_joint);
        let [q, dq, ddq] = [0, 1, 2].map(|k| joints.map(|joint| joint[k]).to_vec());
        let tau = torque(self, &self.truth, &q, &dq, &ddq);
        [q, dq, ddq, tau]
    }

    /// The robot with other base parameters `x`. A base parameter contains one standard parameter with the factor 1 (its column);
    /// this one gets the value. All other standard parameters are zero.
    pub fn with_base(&self, x: &[f64]) -> TapeRobot {
        let mut standard = vec![0.0; self.standard.len()];
        self.base.base.iter().zip(x).for_each(|(b, x)| standard[b.column] = *x);
        self.with_standard(standard)
    }

    /// The robot with the standard parameters of each link multiplied by the factor of the link.
    pub fn with_scaled_links(&self, factors: &[f64]) -> TapeRobot {
        let scaled = |(p, x): (&StandardParameter, &f64)| factors[p.link.0] * x;
        self.with_standard(self.base.standard.iter().zip(&self.standard).map(scaled).collect())
    }

    /// The robot with an additional body fixed to a link. `body`: ten parameters in the frame of the link.
    pub fn with_body(&self, link: LinkId, body: &Ten) -> TapeRobot {
        let mut standard = self.standard.clone();
        for (p, x) in self.base.standard.iter().zip(&mut standard) {
            if p.link == link && p.inertial != Inertial::Ia {
                *x += body[p.inertial as usize];
            }
        }
        self.with_standard(standard)
    }

    /// Index of the base parameter whose regressor column is the column of this standard parameter, for example `MX3`; `None` if
    /// there is none.
    pub fn column(&self, name: &str) -> Option<usize> {
        self.base.base.iter().position(|b| self.base.standard[b.column].display(&self.robot).to_string() == name)
    }

    /// The map X = B phi from standard to base parameters, with numbers in B. It also states which standard parameters are the
    /// ten parameters of a body, and which are rotor inertias, which must not be negative.
    pub fn map(&self) -> StandardMap {
        let standard = &self.base.standard;
        let of_base = |(k, b): (usize, &modeling::BaseParameter)| {
            b.terms.iter().map(|t| (k, t.parameter, t.coefficient)).collect::<Vec<_>>()
        };
        let terms: Vec<(usize, usize, f64)> = self.base.base.iter().enumerate().flat_map(of_base).collect();
        let columns = |of: Inertial| (0..standard.len()).filter(move |&c| standard[c].inertial == of);
        StandardMap::new(
            standard.iter().map(|s| s.display(&self.robot).to_string()).collect(),
            self.base.len(),
            &terms,
            columns(Inertial::Xx).map(|c| (self.robot.link(standard[c].link).name.clone(), c)).collect(),
            columns(Inertial::Ia).collect(),
        )
    }

    /// The ten parameters of each body of the map, from the present standard parameters.
    pub fn bodies(&self) -> Vec<Ten> {
        crate::by_link(&self.robot, &self.standard).into_iter().map(|(body, _)| body).collect()
    }

    /// The ten parameters of each body of the map, from the description; `None` for a link without inertial parameters.
    pub fn references(&self) -> Vec<Option<Ten>> {
        let first = self.base.standard.iter().filter(|s| s.inertial == Inertial::Xx);
        first.map(|s| self.robot.link(s.link).inertial).collect()
    }
}

impl Regressor for TapeRobot {
    fn coordinates(&self) -> &[String] {
        &self.coordinates
    }

    fn parameters(&self) -> &[BaseParameter] {
        &self.parameters
    }

    fn is_prismatic(&self, k: usize) -> bool {
        let moves = |j: &robot::Joint| j.variable.terms.iter().any(|t| t.0.0 == k);
        self.robot.links.iter().any(|l| l.joint.kind == JointKind::Prismatic && moves(&l.joint))
    }

    fn fill(&self, q: &[f64], dq: &[f64], ddq: &[f64], y: &mut [f64]) {
        let tape = &self.tapes.regressor;
        tape.evaluate(&[q, dq, ddq].concat(), &mut tape.workspace(), y);
    }

    fn fill_many(&self, states: &[f64], y: &mut [f64]) {
        let tape = &self.tapes.regressor;
        tape.evaluate_many(states, &mut tape.workspace(), y);
    }
}

impl Dynamics for TapeRobot {
    fn n_coordinates(&self) -> usize {
        self.coordinates.len()
    }

    fn fill(&self, q: &[f64], dq: &[f64], inertia: &mut [f64], bias: &mut [f64]) {
        let Tapes { inertia: of_inertia, bias: of_bias, .. } = &*self.tapes;
        of_inertia.evaluate(&[q, &self.truth].concat(), &mut of_inertia.workspace(), inertia);
        of_bias.evaluate(&[q, dq, &self.truth].concat(), &mut of_bias.workspace(), bias);
    }
}
