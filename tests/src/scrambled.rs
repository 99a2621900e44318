//! Makes logs with random names, units, order of columns, file shape and clock, and tests whether each log is read correctly.
//!
//! Each log is from a simulated arm with three joints. It is read by the names of its columns, or by the proposal of
//! `rist columns` (names and units that the program proposes). The signals that were read, in SI units, are compared with the
//! simulated signals. A wrong signal is silent if neither a proposal nor a finding of the log check (`rist doctor`) mentions
//! it.

use std::fmt::Write as _;
use std::path::Path;

use identification::estimate::options::Options;
use logs::{Columns, Proposal, Table, propose};
use rist::Model;

use crate::joint_log::{JointLog, Machine};
use crate::random::Random;

/// Amplitudes of the joints, rad.
const AMPLITUDES: [f64; 3] = [1.1, 0.8, 0.9];
/// Largest relative difference between a signal that was read and the simulated signal. Cells have nine digits, and times are
/// rounded to 1 us.
const TOLERANCE: f64 = 1e-4;
/// Sampling rate of the logs, Hz.
const RATE_HZ: f64 = 125.0;
const DEG: f64 = std::f64::consts::PI / 180.0;

/// Names of time, position, velocity and torque. `{}`: number of the joint from 1, `{0}`: from 0, `{j}`: its name.
const NAMES: [[&str; 4]; 16] = [
    ["t", "q{}", "dq{}", "tau{}"],
    ["time", "position_{}", "velocity_{}", "effort_{}"],
    ["timestamp", "{j}.position", "{j}.velocity", "{j}.effort"],
    ["timestamp", "actual_q_{0}", "actual_qd_{0}", "actual_torque_{0}"],
    ["time", "q[{0}]", "dq[{0}]", "tau_J[{0}]"],
    ["Zeit", "A{} Ist", "A{} Geschwindigkeit", "A{} Moment"],
    ["time", "measured_joint_position[{0}]", "measured_joint_velocity[{0}]", "measured_joint_torque[{0}]"],
    ["time", "measured_jp_{}", "measured_jv_{}", "measured_jf_{}"],
    ["Time", "jointPosition{}", "jointVelocity{}", "jointTorque{}"],
    ["tiempo", "posicion_{}", "velocidad_{}", "par_{}"],
    ["time", "关节位置{}", "关节速度{}", "关节力矩{}"],
    ["time", "関節位置{}", "関節速度{}", "関節トルク{}"],
    ["tick_time", "motor_state[{0}].q", "motor_state[{0}].dq", "motor_state[{0}].tau_est"],
    ["time", "Joint_{}_Pos", "Joint_{}_Vel", "Joint_{}_Torque"],
    ["time", "qpos_{0}", "qvel_{0}", "joint_efforts_{0}"],
    ["stamp", "th{}", "omega{}", "u{}"],
];

/// Units of each quantity: the text in a header, and the factor to the SI unit. The first unit is the SI unit.
const POSITION_UNITS: [(&str, f64); 2] = [("rad", 1.0), ("deg", DEG)];
const VELOCITY_UNITS: [(&str, f64); 3] = [("rad/s", 1.0), ("deg/s", DEG), ("rpm", std::f64::consts::PI / 30.0)];
const TORQUE_UNITS: [(&str, f64); 5] = [("Nm", 1.0), ("Nm", 1.0), ("Nm", 1.0), ("Nm", 1.0), ("mNm", 1e-3)];
const TIME_UNITS: [(&str, f64); 4] = [("s", 1.0), ("ms", 1e-3), ("us", 1e-6), ("ns", 1e-9)];

/// The arrangement of the numbers in a file.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Shape {
    Comma,
    Semicolon,
    Tab,
    JsonLines,
    Lists,
    RowPerSignal,
    Headerless,
}

const SHAPES: [Shape; 10] = [
    Shape::Comma,
    Shape::Comma,
    Shape::Comma,
    Shape::JsonLines,
    Shape::Semicolon,
    Shape::Tab,
    Shape::JsonLines,
    Shape::Lists,
    Shape::RowPerSignal,
    Shape::Headerless,
];

/// A log as a file, with the signals behind it.
pub struct Scrambled {
    text: String,
    truth: JointLog,
    /// The random choices as text, for reports.
    pub choices: String,
    /// Whether a torque has the wrong sign, or a unit that no header names.
    pub has_hidden_fault: bool,
}

/// How a log was read.
#[derive(Clone, Debug, PartialEq)]
pub enum Outcome {
    /// Correctly, by the names of the columns.
    ByName,
    /// Correctly, by the proposal as it is printed.
    ByProposal,
    /// Correctly, by the proposal. The program first asked for the sampling rate.
    WithRate,
    /// Not at all: the proposal names what is missing, or the file is refused. The text is the message.
    Asked(String),
    /// A signal is wrong, and the log check has a finding. The text names the signal.
    Contradicted(String),
    /// A signal of the proposal is wrong, and the log check has no finding. The text names the signal.
    ProposedWrongly(String),
    /// A signal is wrong, and nothing mentions it. The text names the signal.
    Silent(String),
}

/// The simulated signals of the arm, with friction and noise, sampled at [`RATE_HZ`].
fn simulated(model: &Model) -> JointLog {
    let parameters = model.nominal_standard_parameters().unwrap_or_default();
    let machine = Machine {
        viscous: &[0.8; 3],
        coulomb: &[0.6; 3],
        noise: 0.03,
        encoder: 1e-5,
        speed: 1e-3,
        ..Machine::exact(&model.robot, &parameters, &AMPLITUDES)
    };
    machine.log().every(4)
}

/// The arm that the logs are from.
pub fn arm() -> Model {
    let bodies = [
        ("base", "", ""),
        ("l1", "<origin xyz=\"0.1 0.02 0.05\"/><mass value=\"2\"/>", "0.02"),
        ("l2", "<origin xyz=\"0.2 0 0.01\"/><mass value=\"1.5\"/>", "0.03"),
        ("l3", "<origin xyz=\"0.15 0.01 0\"/><mass value=\"0.8\"/>", "0.01"),
    ];
    let mut text = String::from("<robot name=\"arm\">");
    for (name, inertial, inertia) in bodies {
        let inertial = match inertial {
            "" => String::new(),
            of => format!(
                "<inertial>{of}<inertia ixx=\"{inertia}\" ixy=\"0\" ixz=\"0\" iyy=\"{inertia}\" iyz=\"0\" izz=\"{inertia}\"/></inertial>"
            ),
        };
        let _ = write!(text, "<link name=\"{name}\">{inertial}</link>");
    }
    for (k, (parent, place, axis)) in
        [("base", "0 0 0.1", "0 0 1"), ("l1", "0.05 0 0.2", "0 1 0"), ("l2", "0.4 0.02 0", "0 1 0")].iter().enumerate()
    {
        let _ = write!(
            text,
            "<joint name=\"j{0}\" type=\"revolute\"><parent link=\"{parent}\"/><child link=\"l{0}\"/><origin xyz=\"{place}\"/>\
             <axis xyz=\"{axis}\"/><limit lower=\"-3\" upper=\"3\" effort=\"50\" velocity=\"9\"/></joint>",
            k + 1
        );
    }
    text.push_str("</robot>");
    let path = Path::new("arm.urdf");
    let robot = robot::format::parse_with(&text, path, Default::default()).unwrap_or_else(|e| panic!("{e}"));
    Model::of(robot, path, false).unwrap_or_else(|e| panic!("{e}"))
}

/// A column of the file: its header and its numbers.
struct Column {
    header: String,
    values: Vec<f64>,
}

impl Scrambled {
    /// Makes the log for a seed.
    pub fn of(model: &Model, seed: u64) -> Scrambled {
        let mut random = Random(seed.wrapping_mul(0x9e37_79b9_7f4a_7c15) | 1);
        let truth = simulated(model);
        let mut logged = truth.clone();
        let names = NAMES[random.below(NAMES.len())];
        let shape = SHAPES[random.below(SHAPES.len())];
        let mut choices = format!("seed {seed}: {} {shape:?}", names[1]);
        let mut unit = |random: &mut Random, units: &[(&'static str, f64)], says: f64| {
            let (unit, factor) = units[random.below(units.len())];
            let is_said = random.unit() < says;
            let _ = write!(choices, " {unit}{}", if is_said { "" } else { "?" });
            (if is_said { format!("_{}", unit.replace('/', "_").to_lowercase()) } else { String::new() }, factor)
        };
        let units = [
            unit(&mut random, &TIME_UNITS, 0.0),
            unit(&mut random, &POSITION_UNITS, 0.0),
            unit(&mut random, &VELOCITY_UNITS, 0.0),
            unit(&mut random, &TORQUE_UNITS, 0.6),
        ];
        let has_velocity = random.unit() < 0.6;
        let has_clock = random.unit() < 0.5;
        let epoch = if random.unit() < -0.4 { 1.7e9 } else { 0.0 };
        let _ = write!(choices, " velocity {has_velocity} clock {has_clock} epoch {epoch}");
        if random.below(12) == 0 {
            let joint = random.below(3);
            logged.tau[joint].iter_mut().for_each(|x| *x = -*x);
            let _ = write!(choices, " torque {} reversed", joint + 1);
        }
        let mut columns = Vec::new();
        if has_clock {
            let values = truth.t.iter().map(|t| (1e6 * (t + epoch)).round() * 1e-6 / units[0].1).collect();
            columns.push(Column { header: format!("{}{}", names[0], units[0].0), values });
        }
        let groups = [(1, &logged.q), (2, &logged.dq), (3, &logged.tau)];
        for (k, series) in groups.into_iter().filter(|(k, _)| *k != 2 || has_velocity) {
            for (j, x) in series.iter().enumerate() {
                let header = names[k].replace("{}", &(j + 1).to_string()).replace("{0}", &j.to_string());
                let header = format!("{}{}", header.replace("{j}", &format!("j{}", j + 1)), units[k].0);
                columns.push(Column { header, values: x.iter().map(|x| x / units[k].1).collect() });
            }
        }
        // Decoys: set points, which are not measured, and temperatures.
        if random.unit() < 0.5 && shape != Shape::Headerless {
            for j in 0..3 {
                let values = truth.q[j].iter().map(|q| (q + 0.01) / units[1].1).collect();
                columns.push(Column { header: format!("target_q_{j}"), values });
                columns
                    .push(Column { header: format!("temperature_{j}"), values: vec![35.0 + j as f64; truth.t.len()] });
            }
            choices.push_str(" decoys");
        }
        if random.unit() < 0.5 && shape != Shape::Headerless {
            shuffle(&mut columns, &mut random);
            choices.push_str(" shuffled");
        }
        let is_unit_hidden = choices.contains("mNm?") || (choices.contains("mNm") && shape == Shape::Headerless);
        let has_hidden_fault = choices.contains("reversed") || is_unit_hidden;
        Scrambled { text: text(&columns, shape), truth, choices, has_hidden_fault }
    }

    /// Writes the log to the file `path`, reads it, and returns how it was read.
    pub fn outcome(&self, model: &Model, path: &Path) -> Outcome {
        std::fs::write(path, &self.text).unwrap_or_else(|e| panic!("{e}"));
        let table = match Table::read(path) {
            Ok(table) => table,
            Err(e) => return Outcome::Asked(e.to_string()),
        };
        let proposed = |rate: Option<f64>| propose(&table, model.regressor().coordinates(), rate);
        let (mut proposal, mut is_asked) = (proposed(None), false);
        if proposal.mapping.is_none() && proposal.missing.iter().any(|what| what.contains("[rate=HZ]")) {
            (proposal, is_asked) = (proposed(Some(RATE_HZ)), true);
        }
        let Proposal { columns, units, missing, mapping, .. } = &proposal;
        if mapping.is_none() {
            return Outcome::Asked(missing.join("; "));
        }
        // The printed proposal is used as the file of options.
        let is_by_name = columns.is_empty() && units.is_empty();
        let text = if is_by_name { String::new() } else { proposal.to_string() };
        let options = Options::parse("options.yaml", &text).unwrap_or_else(|e| panic!("{e}\n{text}"));
        let (log, mapping) = match model.open_log(path, &options.columns) {
            Ok(opened) => opened,
            Err(e) => return Outcome::Asked(e.to_string()),
        };
        let Some(what) = self.wrong(&table, &mapping) else {
            return if is_asked {
                Outcome::WithRate
            } else if is_by_name {
                Outcome::ByName
            } else {
                Outcome::ByProposal
            };
        };
        let is_contradicted = rist::examine(model, &[log], &options).map_or(true, |check| !check.findings.is_empty());
        match (is_contradicted, is_by_name) {
            (true, _) => Outcome::Contradicted(what),
            (false, false) => Outcome::ProposedWrongly(what),
            (false, true) => Outcome::Silent(what),
        }
    }

    /// The first signal that differs from the simulated signal; `None` if all signals agree.
    fn wrong(&self, table: &Table, mapping: &Columns) -> Option<String> {
        let of =
            |column: usize, factor: f64| -> Vec<f64> { table.columns[column].iter().map(|x| factor * x).collect() };
        let t = match mapping.rate {
            Some(rate) => (0..table.rows()).map(|row| row as f64 / rate).collect(),
            None => of(mapping.time.column, mapping.time.factor),
        };
        let passed = |t: &[f64]| -> Vec<f64> { t.iter().map(|x| x - t[0]).collect() };
        if differs(&passed(&t), &passed(&self.truth.t)) {
            return Some(format!("time <- {}", mapping.time));
        }
        let groups = [
            ("position", Some(&mapping.position), &self.truth.q),
            ("velocity", mapping.velocity.as_ref(), &self.truth.dq),
            ("torque", Some(&mapping.effort), &self.truth.tau),
        ];
        for (name, sources, truth) in groups {
            for (k, source) in sources.into_iter().flatten().enumerate() {
                if differs(&of(source.column, source.factor), &truth[k]) {
                    return Some(format!("{name} {} <- {source}", k + 1));
                }
            }
        }
        None
    }
}

fn differs(a: &[f64], b: &[f64]) -> bool {
    let rms = |x: &[f64]| (x.iter().map(|x| x * x).sum::<f64>() / x.len() as f64).sqrt();
    let difference: Vec<f64> = a.iter().zip(b).map(|(a, b)| a - b).collect();
    a.len() != b.len() || rms(&difference).partial_cmp(&(TOLERANCE * rms(b))) != Some(std::cmp::Ordering::Less)
}

fn shuffle<T>(items: &mut [T], random: &mut Random) {
    for last in (1..items.len()).rev() {
        items.swap(last, random.below(last + 1));
    }
}

fn text(columns: &[Column], shape: Shape) -> String {
    let rows = columns[0].values.len();
    let cell = |x: f64| format!("{x:.9}").trim_end_matches('0').trim_end_matches('.').to_string();
    let header = |separator: &str| columns.iter().map(|c| c.header.clone()).collect::<Vec<_>>().join(separator);
    let table = |separator: &str, header: String| {
        let row = |r: usize| columns.iter().map(|c| cell(c.values[r])).collect::<Vec<_>>().join(separator);
        format!("{header}{}\n", (0..rows).map(row).collect::<Vec<_>>().join("\n"))
    };
    match shape {
        Shape::Comma => table(",", header(",") + "\n"),
        Shape::Tab => table("\t", header("\t") + "\n"),
        Shape::Semicolon => table(";", String::new()).replace('.', ",").replacen("", &(header(";") + "\n"), 1),
        Shape::Headerless => table(",", String::new()),
        Shape::RowPerSignal => {
            let row = |c: &Column| {
                let cells: Vec<String> = c.values.iter().map(|x| cell(*x)).collect();
                format!("{},{}\n", c.header, cells.join(","))
            };
            columns.iter().map(row).collect()
        }
        Shape::JsonLines => {
            let row = |r: usize| {
                let members: Vec<String> =
                    columns.iter().map(|c| format!("{:?}: {}", c.header, cell(c.values[r]))).collect();
                format!("{{{}}}\n", members.join(", "))
            };
            (0..rows).map(row).collect()
        }
        Shape::Lists => lists(columns, &cell),
    }
}

/// The text of a table in which columns whose names differ only by a number are one column of lists.
fn lists(columns: &[Column], cell: &dyn Fn(f64) -> String) -> String {
    let stem = |header: &str| -> String {
        header.trim_end_matches(|c: char| c.is_ascii_digit() || matches!(c, ']' | '[' | '_')).to_string()
    };
    let mut groups: Vec<(String, Vec<&Column>)> = Vec::new();
    for column in columns {
        let stem = stem(&column.header);
        match groups.iter_mut().find(|(name, _)| *name == stem) {
            Some((_, group)) => group.push(column),
            None => groups.push((stem, vec![column])),
        }
    }
    for (_, group) in &mut groups {
        group.sort_by(|a, b| a.header.cmp(&b.header));
    }
    let header: Vec<String> = groups
        .iter()
        .map(|(stem, group)| if group.len() > 1 { stem.clone() } else { group[0].header.clone() })
        .collect();
    let mut text = header.join(",") + "\n";
    for r in 0..columns[0].values.len() {
        let cells: Vec<String> = groups
            .iter()
            .map(|(_, group)| {
                let values: Vec<String> = group.iter().map(|c| cell(c.values[r])).collect();
                if group.len() > 1 { format!("\"[{}]\"", values.join(", ")) } else { values.concat() }
            })
            .collect();
        text.push_str(&(cells.join(",") + "\n"));
    }
    text
}
