//! The table of identified parameters, grouped by link, with interval, meaning and nominal value of each.
//!
//! sigma: standard deviation of a parameter. Nominal values are the values of the description.

use std::collections::BTreeMap;

use identification::estimate::artefact::Estimate;
use identification::estimate::identified::{INTERVAL, Identified, Status};
use linear_model::coupling_parameter::CouplingParameter;
use linear_model::parameter::{BaseName, ParameterId};
use modeling::BaseParameters;
use robot::value::CoordinateId;
use robot::{Inertial, Robot};
use serde::Serialize;

use crate::number::{percent, significant, unit, with_interval};
use crate::sheet::link_title;

/// The robot to which an estimate belongs.
#[derive(Clone, Copy)]
pub struct Subject<'a> {
    /// The robot description.
    pub robot: &'a Robot,
    /// The base parameters of the robot.
    pub parameters: &'a BaseParameters,
    /// Nominal values of the base parameters, in the order of `parameters`; `None` if the description has no inertials.
    pub described: Option<&'a [f64]>,
}

/// The table rows for the parameters of one link.
#[derive(Serialize)]
pub(crate) struct LinkParameters {
    title: String,
    rows: Vec<ParameterRow>,
}

#[derive(Serialize)]
struct ParameterRow {
    order: usize,
    name: String,
    value: String,
    half: String,
    unit: String,
    /// The value as a number. The script of the page sorts the table by this number.
    number: f64,
    /// |value| / sigma; 0 if the parameter is not identifiable.
    deviations: f64,
    /// Length of the bar that shows |value| / sigma, 0 to 100.
    bar: f64,
    relative: String,
    described: String,
    /// Difference between the nominal value and the estimate, in standard deviations; `None` without a nominal value.
    off: Option<f64>,
    meaning: String,
    rule: String,
    status: &'static str,
    is_doubtful: bool,
}

/// Value of |value| / sigma with which a bar has its full length.
const FULL_BAR_SIGMAS: f64 = 50.0;

/// The table of the parameters of an estimate, grouped by link.
pub(crate) fn groups(estimate: &Estimate, subject: Option<Subject>) -> Vec<LinkParameters> {
    let nominal: BTreeMap<String, NominalValue> = subject.map(nominal_by_parameter).unwrap_or_default();
    let mut groups: Vec<LinkParameters> = Vec::new();
    for (order, parameter) in estimate.parameters.iter().enumerate() {
        let title = title(&parameter.id, subject, &nominal);
        let row = row(order, parameter, &nominal);
        match groups.iter_mut().find(|group| group.title == title) {
            Some(group) => group.rows.push(row),
            None => groups.push(LinkParameters { title, rows: vec![row] }),
        }
    }
    groups
}

/// What the description gives for one base parameter.
struct NominalValue {
    link: String,
    meaning: String,
    rule: String,
    described: Option<f64>,
}

fn nominal_by_parameter(subject: Subject) -> BTreeMap<String, NominalValue> {
    let Subject { robot, parameters, described } = subject;
    let rules = parameters.rules();
    let one = |(k, base): (usize, &modeling::BaseParameter)| {
        let nominal = NominalValue {
            link: link_title(robot, parameters.standard[base.column].link),
            meaning: parameters.meaning(robot, k),
            rule: if base.terms.len() > 1 { rules.base[k].clone() } else { String::new() },
            described: described.map(|values| values[k]),
        };
        (base.name.clone(), nominal)
    };
    parameters.base.iter().enumerate().map(one).collect()
}

/// The title of the group of a parameter: the link of the parameter, or for friction the link that the joint moves.
fn title(id: &ParameterId, subject: Option<Subject>, nominal: &BTreeMap<String, NominalValue>) -> String {
    let label = match id {
        ParameterId::Base(name) => match nominal.get(&id.to_string()) {
            Some(nominal) => return nominal.link.clone(),
            None => &name.label,
        },
        ParameterId::Friction(_, label) | ParameterId::Coupling(_, label) | ParameterId::DriveGain(label) => label,
    };
    let of_label = |subject: Subject| {
        let robot = subject.robot;
        let is_meant = |name: &str| linear_model::label::Label::of_coordinate(name) == *label;
        let k = robot.coordinates.iter().position(|c| is_meant(&c.name))?;
        Some(link_title(robot, robot.joint_of(CoordinateId(k))?))
    };
    subject.and_then(of_label).unwrap_or_else(|| match id {
        ParameterId::Base(_) => format!("link {}", label.to_string().trim_start_matches('_')),
        _ => format!("joint {}", label.to_string().trim_start_matches('_')),
    })
}

fn row(order: usize, parameter: &Identified, nominal: &BTreeMap<String, NominalValue>) -> ParameterRow {
    let name = parameter.id.to_string();
    let nominal = nominal.get(&name);
    let sigma = parameter.sigma.unwrap_or(f64::NAN);
    let (value, half) = match parameter.value {
        Some(value) => with_interval(value, if sigma.is_finite() { INTERVAL * sigma } else { 0.0 }),
        None => ("not identifiable".into(), String::new()),
    };
    let number = parameter.value.unwrap_or(0.0);
    // Two ratios: the value divided by sigma, and the difference of the value from the nominal value divided by sigma.
    let deviations = if sigma > 0.0 && sigma.is_finite() { number.abs() / sigma } else { 0.0 };
    let described = nominal.and_then(|nominal| nominal.described);
    let off = described.zip(parameter.value).map(|(d, value)| (d - value).abs() / sigma);
    ParameterRow {
        order,
        value,
        half,
        unit: unit(&parameter.unit.to_string()),
        number,
        deviations,
        bar: (100.0 * deviations / FULL_BAR_SIGMAS).min(100.0),
        relative: parameter.relative_sigma.map_or(String::new(), |x| percent(0.01 * x)),
        described: described.map_or(String::new(), |x| significant(x, 3)),
        off: off.filter(|off| off.is_finite()),
        meaning: nominal.map_or_else(|| meaning(&parameter.id), |nominal| nominal.meaning.clone()),
        rule: nominal.map_or(String::new(), |nominal| nominal.rule.clone()),
        status: match parameter.status {
            Status::Identified | Status::Given => "",
            Status::NotSignificant => "zero is inside its interval",
            Status::Weak => "weak: little motion decides it",
            Status::NotIdentifiable => "the data say nothing about it",
        },
        is_doubtful: !matches!(parameter.status, Status::Identified | Status::Given),
        name,
    }
}

/// The meaning of a base parameter in words, from its name alone.
fn of_base(name: &BaseName) -> String {
    let label = name.label.to_string();
    let link = label.trim_start_matches('_');
    let what = match name.inertial {
        Inertial::M => format!("mass of link {link}"),
        Inertial::Ia => format!("rotor inertia of the motor of joint {link}"),
        Inertial::Mx => format!("first moment of link {link} along x"),
        Inertial::My => format!("first moment of link {link} along y"),
        Inertial::Mz => format!("first moment of link {link} along z"),
        Inertial::Xx => format!("moment of inertia of link {link} about x"),
        Inertial::Yy => format!("moment of inertia of link {link} about y"),
        Inertial::Zz => format!("moment of inertia of link {link} about z"),
        Inertial::Xy => format!("product of inertia of link {link}, x with y"),
        Inertial::Xz => format!("product of inertia of link {link}, x with z"),
        Inertial::Yz => format!("product of inertia of link {link}, y with z"),
    };
    let lever = if name.lever.is_empty() { String::new() } else { format!(", by the length {}", name.lever) };
    let others = if name.absorbs { ", with what no motion separates from it" } else { "" };
    format!("{what}{lever}{others}")
}

/// The meaning in words of a parameter without a regrouping rule.
fn meaning(id: &ParameterId) -> String {
    let text = match id {
        ParameterId::Base(name) => return of_base(name),
        ParameterId::DriveGain(_) => "torque per unit of current",
        ParameterId::Coupling(CouplingParameter::Rotor, _) => "rotor inertia of the coupled motor",
        ParameterId::Coupling(CouplingParameter::Viscous, _) => "viscous friction of the coupled motor",
        ParameterId::Coupling(CouplingParameter::Coulomb, _) => "Coulomb friction of the coupled motor",
        ParameterId::Coupling(CouplingParameter::Inertia, _) => "inertia of an element between joints",
        ParameterId::Coupling(CouplingParameter::ElementViscous, _) => "viscous friction of an element between joints",
        ParameterId::Coupling(CouplingParameter::ElementCoulomb, _) => "Coulomb friction of an element between joints",
        ParameterId::Coupling(CouplingParameter::Stiffness, _) => "stiffness of an element between joints",
        ParameterId::Coupling(CouplingParameter::Sine, _) => "torque of an element with the sine of its position",
        ParameterId::Coupling(CouplingParameter::Cosine, _) => "torque of an element with the cosine of its position",
        ParameterId::Coupling(CouplingParameter::Offset, _) => "constant torque of an element between joints",
        ParameterId::Friction(friction, _) => friction.meaning(),
    };
    text.into()
}
