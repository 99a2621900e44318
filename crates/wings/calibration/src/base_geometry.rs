//! Finds the base geometric parameters: the errors of the geometry that the measurements can determine. The other errors are
//! grouped into the base parameters.
//!
//! The Jacobian of the measurements is stacked over random postures. Its independent columns are found from left to right by
//! the same method as for base inertial parameters ([`modeling::independent_columns`]). At every posture, a dropped parameter
//! has the same effect as a combination of kept parameters. So the fitted errors of these kept parameters contain the error of
//! the dropped parameter [Khalil, Dombre 2002, chapter 11].
//!
//! A parameter without effect changes no measurement. The gap between kept and dropped columns is the evidence for the number
//! of base parameters. For full poses, the number is also determined in a finite field, where no tolerance is needed
//! ([`modeling::independent_geometric_errors`]).

use modeling::{GeometricError, independent_columns, independent_geometric_errors};
use nalgebra::{DMatrix, Matrix3, Vector3};
use random::Random;
use rist::Error;
use robot::{LinkId, Robot};

use crate::chain::{Convention, Placed, turned_by};
use crate::measurement::{MeasurementKind, Posture, Problem, Unknowns};
use crate::parameter::{Parameter, ParameterNames};

/// Number of random rows per parameter.
const ROWS_PER_PARAMETER: usize = 3;
/// Positions of a joint without limits are drawn from this range, rad (m).
const FREE_RANGE: f64 = std::f64::consts::PI;
/// Seed of the random postures.
const SEED: u64 = 0x6765_6f6d;
/// A coefficient below this is rounding: the columns are lengths of the size of a robot.
const ROUNDED_ZERO: f64 = 1e-9;

/// The base parameters among some parameters, with the evidence of their number.
#[derive(Clone, Debug, PartialEq)]
pub struct GeometricBase {
    /// Indices of the parameters that are kept.
    pub kept: Vec<usize>,
    /// Parameters that are grouped: each with its coefficients of kept parameters.
    pub grouped: Vec<(usize, Vec<(usize, f64)>)>,
    /// Parameters that change no measurement.
    pub without_effect: Vec<usize>,
    /// Smallest relative distance of a kept column from the span of the columns before it.
    pub smallest_kept: f64,
    /// Largest relative distance of a dropped column.
    pub largest_dropped: f64,
}

impl GeometricBase {
    /// The base parameters among the columns `selected` of a Jacobian.
    ///
    /// Fails if a column is not finite.
    pub fn of(jacobian: &DMatrix<f64>, selected: &[usize]) -> Result<GeometricBase, Error> {
        let scan = independent_columns(&jacobian.select_columns(selected)).map_err(|_| {
            Error::new("the derivatives of the poses are not finite: look at the lengths of the description")
        })?;
        let distance = |c: &usize| scan.distance[*c];
        let dropped = scan.zero.iter().chain(scan.dependent.iter().map(|d| &d.0));
        Ok(GeometricBase {
            smallest_kept: scan.kept.iter().map(distance).fold(1.0, f64::min),
            largest_dropped: dropped.map(distance).fold(0.0, f64::max),
            grouped: (scan.dependent.iter())
                .map(|(c, x)| {
                    let terms = scan.kept.iter().zip(x).filter(|(_, x)| x.abs() > ROUNDED_ZERO);
                    (selected[*c], terms.map(|(k, x)| (selected[*k], *x)).collect())
                })
                .collect(),
            kept: scan.kept.iter().map(|c| selected[*c]).collect(),
            without_effect: scan.zero.iter().map(|c| selected[*c]).collect(),
        })
    }

    /// The gap between kept and dropped columns.
    pub fn gap(&self) -> f64 {
        self.smallest_kept / self.largest_dropped.max(f64::EPSILON)
    }

    /// The rule of a grouped parameter: `d3 = 1 d2 + 0.5 zero q2`.
    pub fn rule(&self, grouped: usize, problem: &Problem, names: &ParameterNames) -> String {
        let name = |k: usize| names.of(problem.parameters[k]).to_string();
        let terms = self.grouped.iter().find(|(k, _)| *k == grouped).map(|(_, terms)| terms.as_slice()).unwrap_or(&[]);
        let terms: Vec<String> =
            terms.iter().map(|(k, x)| format!("{} {}", claims::significant(*x, 4), name(*k))).collect();
        format!("{} = {}", name(grouped), terms.join(" + ").replace("+ -", "- "))
    }
}

/// Whether the numeric base parameters are those of a finite field.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ExactGeometry {
    /// The same parameters are independent in the field.
    SameParameters,
    /// The number of independent parameters is the same in the field.
    SameNumber,
    /// In the field, where lengths are arbitrary, this number of parameters is independent.
    Other(usize),
}

impl ExactGeometry {
    /// Compares base parameters of full poses with a finite field. `selected`: indices of the parameters among which the base
    /// was searched. `None` for other measurements, for gears and compliances, and for robots with passive joints.
    pub fn of(robot: &Robot, problem: &Problem, selected: &[usize], base: &GeometricBase) -> Option<ExactGeometry> {
        if problem.kind != MeasurementKind::Pose {
            return None;
        }
        let error = |k: &usize| match problem.parameters[*k] {
            // The base is the frame before the first link.
            Parameter::Base { axis } => Some(GeometricError::Before { link: problem.chain.links[0], axis }),
            Parameter::Point { axis, .. } => Some(GeometricError::Tool { axis }),
            Parameter::Tool { axis } => Some(GeometricError::Tool { axis: axis + 3 }),
            Parameter::Zero { coordinate } => Some(GeometricError::Zero(coordinate)),
            Parameter::Dh { link, letter } => Some(GeometricError::Link { link: LinkId(link), error: letter as usize }),
            // The six errors of the frame of a joint have the span of the six errors of the frame before the link.
            Parameter::Frame { link, axis } => Some(GeometricError::Before { link: LinkId(link), axis }),
            _ => None,
        };
        let errors: Vec<GeometricError> = selected.iter().map(error).collect::<Option<_>>()?;
        let exact = independent_geometric_errors(robot, *problem.chain.links.last()?, &errors)?;
        let is_same = problem.chain.convention() == Convention::Dh
            && exact.iter().map(|&k| selected[k]).eq(base.kept.iter().copied());
        Some(match exact.len() {
            _ if is_same => ExactGeometry::SameParameters,
            number if number == base.kept.len() => ExactGeometry::SameNumber,
            number => ExactGeometry::Other(number),
        })
    }
}

impl std::fmt::Display for ExactGeometry {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            ExactGeometry::SameParameters => f.write_str("the same parameters are independent in a finite field"),
            ExactGeometry::SameNumber => f.write_str("the rank in a finite field is the same"),
            ExactGeometry::Other(number) => {
                write!(f, "with other lengths of the same structure, {number} are independent (finite field)")
            }
        }
    }
}

/// `count` random postures within the joint limits. Each has the same kind of measurement as the posture `like`.
pub(crate) fn random_postures(robot: &Robot, problem: &Problem, like: &Posture, count: usize) -> Vec<Posture> {
    let mut random = Random::new(SEED);
    let mut position = |k: &usize| {
        let limits = robot.coordinates[*k].limits.position.filter(|(low, high)| high - low < 2.0 * FREE_RANGE);
        let (low, high) = limits.unwrap_or((-FREE_RANGE, FREE_RANGE));
        random.between(low, high)
    };
    // The torques of a random posture are invented, with the size of the torques at the given postures. So a joint that
    // gravity never loads has no torque here either, and its compliance is not identifiable.
    let largest = |k: usize| problem.postures.iter().map(|p| p.torque[k].abs()).fold(0.0, f64::max);
    let sizes: Vec<f64> = (0..problem.chain.coordinates.len()).map(largest).collect();
    let least = ROUNDED_ZERO * sizes.iter().copied().fold(0.0, f64::max);
    let mut posture = |_| {
        let q: Vec<f64> = problem.chain.coordinates.iter().map(&mut position).collect();
        let torque = |(k, x): (usize, &f64)| if sizes[k] > least { sizes[k] * (x + k as f64).sin() } else { 0.0 };
        let torque = q.iter().enumerate().map(torque).collect();
        Posture { q, torque, ..like.clone() }
    };
    (0..count).map(&mut posture).collect()
}

/// Unknowns without special values: random frames, and no errors of the chain.
pub(crate) fn random_unknowns(problem: &Problem) -> Unknowns {
    let mut random = Random::new(SEED);
    let mut vector = || Vector3::from_fn(|_, _| random.between(-1.0, 1.0));
    let base = Placed { rotation: turned_by(vector()), position: vector() };
    let tool: Matrix3<f64> = turned_by(vector());
    let points = (0..problem.kind.points()).map(|_| 0.3 * vector()).collect();
    Unknowns { base, tool, anchor: 2.0 * vector(), radius: 0.5, points, ..problem.nominal() }
}

/// The base parameters among those for which `is_selected` is true, for the measurements of the first posture at any posture.
///
/// Fails if the geometry is not finite.
pub fn geometric_base(
    robot: &Robot,
    problem: &Problem,
    is_selected: impl Fn(Parameter) -> bool,
) -> Result<GeometricBase, Error> {
    let selected: Vec<usize> = (0..problem.parameters.len()).filter(|&k| is_selected(problem.parameters[k])).collect();
    let like = problem.postures.first().ok_or_else(|| Error::new("there is no posture"))?;
    let each = problem.with(vec![like.clone()]).linearised(&random_unknowns(problem)).residual.len().max(1);
    let count = (ROWS_PER_PARAMETER * selected.len()).div_ceil(each).max(selected.len());
    let at_random = problem.with(random_postures(robot, problem, like, count));
    GeometricBase::of(&at_random.linearised(&random_unknowns(problem)).jacobian, &selected)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::parameter::ParameterGroup;
    use crate::simulated::problem;

    fn is_rigid(parameter: Parameter) -> bool {
        matches!(parameter.group(), ParameterGroup::Frames | ParameterGroup::Zeros | ParameterGroup::Geometry)
    }

    fn selected(problem: &Problem) -> Vec<usize> {
        (0..problem.parameters.len()).filter(|&k| is_rigid(problem.parameters[k])).collect()
    }

    /// The base parameters of full poses are the same in a finite field, and their number is that of Khalil and Dombre: 4 for each
    /// revolute joint, 2 for each prismatic joint, and 6. For the frames of a URDF, the number is the same.
    #[test]
    fn base_parameters_are_those_of_a_finite_field() {
        let models = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("../../../models");
        for (file, [revolute, prismatic]) in [
            ("ur5.yaml", [6, 0]),
            ("panda.yaml", [7, 0]),
            ("stanford.yaml", [5, 1]),
            ("scara.yaml", [3, 1]),
            ("ur5.urdf", [6, 0]),
        ] {
            let robot = rist::read_robot(&models.join(file), &rist::ModelOptions::default()).unwrap();
            for convention in [Convention::Dh, Convention::Frames] {
                let problem = problem(&robot, convention, MeasurementKind::Pose, 1, &mut Random::new(1));
                let base = geometric_base(&robot, &problem, is_rigid).unwrap();
                let selected = selected(&problem);
                assert_eq!(base.kept.len(), 4 * revolute + 2 * prismatic + 6, "{file} {convention:?}");
                let wanted = match convention {
                    Convention::Dh => ExactGeometry::SameParameters,
                    Convention::Frames => ExactGeometry::SameNumber,
                };
                assert_eq!(ExactGeometry::of(&robot, &problem, &selected, &base), Some(wanted), "{file}");
            }
            // A base in which a parameter is missing is not the base of the field.
            let problem = problem(&robot, Convention::Dh, MeasurementKind::Pose, 1, &mut Random::new(1));
            let selected = selected(&problem);
            let mut base = geometric_base(&robot, &problem, is_rigid).unwrap();
            base.kept.pop();
            let number = base.kept.len() + 1;
            assert_eq!(
                ExactGeometry::of(&robot, &problem, &selected, &base),
                Some(ExactGeometry::Other(number)),
                "{file}"
            );
        }
    }
}
