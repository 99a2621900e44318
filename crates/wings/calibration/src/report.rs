//! Writes the result of a calibration as text and as JSON.
//!
//! Base parameters are the errors that measurements can determine; a rule states how another error is contained in them.

use std::fmt;

use claims::significant;
use identification::estimate::verdict::claim_line;
use rist::Error;
use robot::{Robot, format::roll_pitch_yaw};
use serde_json::{Value, json};

use crate::base_geometry::{ExactGeometry, geometric_base};
use crate::calibrate::{CalibratedParameter, Calibration, chain_of, names_of};
use crate::chain::Placed;
use crate::folds::PredictionError;
use crate::level::Level;
use crate::measurement::{MeasurementKind, Posture, Problem};
use crate::parameter::{Parameter, ParameterGroup};
use crate::request::CalibrateRequest;
use crate::verdict::{errors, shown};

/// Number of significant digits of printed values.
const DIGITS: usize = 4;

fn error_json(error: &PredictionError) -> Value {
    json!({"length": error.length, "angle": error.angle})
}

fn frame_json(frame: &Placed) -> Value {
    json!({"xyz": frame.pose().position, "rpy": roll_pitch_yaw(&frame.pose().rotation)})
}

impl Calibration {
    fn level_json(&self, level: &Level) -> Value {
        // The parameters of the frames are left out, because base, tool and points have their own keys below.
        let parameters: Vec<Value> = self
            .parameters(level)
            .into_iter()
            .filter(|p| p.parameter.group() != ParameterGroup::Frames)
            .map(
                |p| json!({"name": p.name, "value": p.value, "sigma": p.sigma, "interval": p.interval, "unit": p.unit}),
            )
            .collect();
        let rules = level.base.grouped.iter().map(|(k, _)| level.base.rule(*k, &self.problem, &self.names));
        let unknowns = &level.fit.unknowns;
        let points: Vec<[f64; 3]> = unknowns.points.iter().map(|p| (*p).into()).collect();
        let named = |all: &[usize]| -> Vec<String> {
            all.iter().map(|&k| self.names.of(self.problem.parameters[k]).to_string()).collect()
        };
        json!({
            "what": level.what,
            "parameters": parameters,
            "base": frame_json(&unknowns.base),
            "tool": frame_json(&Placed { rotation: unknowns.tool, position: unknowns.points[0] }),
            "points": points,
            "grouped": rules.collect::<Vec<_>>(),
            "without_effect": named(&level.base.without_effect),
            "not_determined": named(&level.undetermined),
            "rank": {"kept": level.base.kept.len(), "smallest_kept": level.base.smallest_kept,
                "largest_dropped": level.base.largest_dropped},
            "prior": level.deviation,
            "noise": {"length": level.fit.noise.length, "angle": level.fit.noise.angle},
            "fitted": error_json(&level.fitted),
            "left_out": error_json(&level.left_out),
            "outliers": self.outliers(level),
        })
    }

    /// The calibration as JSON.
    pub fn to_json(&self) -> Value {
        let verdict = &self.verdict;
        json!({
            "postures": self.problem.postures.len(),
            "left_out_rows": self.left_out_rows,
            "tip": self.tip,
            "levels": self.levels.iter().map(|level| self.level_json(level)).collect::<Vec<_>>(),
            "recommended": self.recommended().what,
            "notes": self.notes,
            "verdict": {"trust": verdict.trust.word(), "reasons": verdict.reasons, "next": verdict.next,
                "claims": verdict.claims},
        })
    }

    /// Name, value, half of the 95 % interval and unit of a parameter. Small lengths and angles are readable in mm and mrad.
    pub(crate) fn parameter_cells(&self, p: &CalibratedParameter) -> [String; 4] {
        let (factor, unit) = match p.unit {
            "m" => (1e3, "mm"),
            "rad" => (1e3, "mrad"),
            "1" => (100.0, "%"),
            other => (1.0, other),
        };
        let value = |x: f64| significant(factor * x, DIGITS);
        [p.name.clone(), value(p.value), value(p.interval), unit.into()]
    }

    fn kind(&self) -> String {
        match self.problem.kind {
            MeasurementKind::Pose => "poses".into(),
            MeasurementKind::Points(1) => "positions of a point".into(),
            MeasurementKind::Points(n) => format!("positions of {n} points"),
            MeasurementKind::Distance => "distances".into(),
            MeasurementKind::Sphere => "a touched sphere".into(),
        }
    }
}

impl fmt::Display for Calibration {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let level = self.level();
        writeln!(f, "{} postures of {}: {}", self.problem.postures.len(), self.tip, self.kind())?;
        if self.left_out_rows > 0 {
            writeln!(f, "{} rows are left out: a number is missing", self.left_out_rows)?;
        }
        self.notes.iter().try_for_each(|note| writeln!(f, "note: {note}"))?;
        writeln!(f, "\n{:<12} {:<26} {:<26} parameters", "fit of", "error on fitted postures", "on postures left out")?;
        for one in &self.levels {
            let count = one.fit.active.len();
            writeln!(f, "{:<12} {:<26} {:<26} {count}", one.what, shown(&one.fitted), shown(&one.left_out))?;
        }
        if let Some(deviation) = level.deviation {
            writeln!(
                f,
                "the errors of the geometry are held near zero by {} mm and mrad, which predicts best",
                significant(1e3 * deviation, 2)
            )?;
        }
        writeln!(f, "\n{}: error of the description, with its 95 % interval", level.what)?;
        let parameters = self.parameters(level);
        // The frames of base and tool describe the measurement and are no errors of the robot, so they are not listed.
        let of_robot = parameters.iter().filter(|p| p.parameter.group() != ParameterGroup::Frames);
        of_robot.into_iter().try_for_each(|p| {
            let [name, value, interval, unit] = self.parameter_cells(p);
            writeln!(f, "{name:<28} {value:>10} +- {interval:<10} {unit}")
        })?;
        let grouped = level.base.grouped.len();
        if grouped > 0 {
            writeln!(f, "{grouped} other parameters are grouped into these: they are in the result file")?;
        }
        writeln!(f)?;
        let verdict = &self.verdict;
        // The first level fits only the frames (the description alone), the last level is the fit that the user asked for.
        if let [before, .., after] = errors(&self.problem, &self.levels).as_slice() {
            let without = if self.outliers(level).is_empty() { "" } else { ", without the wrong ones" };
            let (before, after) = (shown(before), shown(after));
            writeln!(f, "error on postures left out{without}: {before} by the description alone, {after} calibrated")?;
        }
        let lines = verdict.claims.iter().filter(|claim| !claim.is_contradicted()).map(claim_line);
        lines.into_iter().try_for_each(|line| writeln!(f, "{line}"))?;
        writeln!(f, "trust: {}", verdict.trust.word())?;
        verdict.reasons.iter().try_for_each(|reason| writeln!(f, "  - {reason}"))?;
        verdict.next.iter().try_for_each(|next| writeln!(f, "next: {next}"))
    }
}

/// The base geometric parameters of a robot as text: the parameters that measurements of full poses determine, and for each
/// other parameter the rule by which it is contained in them.
///
/// Fails if the chain is unknown, or if a loop moves it.
pub fn inspected(robot: &Robot, request: &CalibrateRequest) -> Result<(String, Value), Error> {
    let chain = chain_of(robot, request)?;
    let n = chain.coordinates.len();
    // Only the kind of the measurement (a pose) matters. The numbers do not: `geometric_base` uses random postures.
    let posture = Posture {
        line: 0,
        q: vec![0.0; n],
        torque: vec![0.0; n],
        points: vec![[0.0; 3]],
        rotation: Some(nalgebra::Matrix3::identity()),
        distance: None,
    };
    let problem = Problem::new(chain, MeasurementKind::Pose, vec![posture]);
    let names = names_of(robot, 1);
    let is_selected =
        |p: Parameter| matches!(p.group(), ParameterGroup::Frames | ParameterGroup::Zeros | ParameterGroup::Geometry);
    let base = geometric_base(robot, &problem, is_selected)?;
    let selected: Vec<usize> = (0..problem.parameters.len()).filter(|&k| is_selected(problem.parameters[k])).collect();
    let exact = ExactGeometry::of(robot, &problem, &selected, &base);
    let name = |k: &usize| names.of(problem.parameters[*k]).to_string();
    let kept: Vec<String> = base.kept.iter().map(name).collect();
    let rules: Vec<String> = base.grouped.iter().map(|(k, _)| base.rule(*k, &problem, &names)).collect();
    let none: Vec<String> = base.without_effect.iter().map(name).collect();
    let evidence = format!(
        "{} base geometric parameters of full poses, base and tool free (smallest distance of a kept column {:.1e}, largest of a \
         dropped one {:.1e}){}",
        kept.len(),
        base.smallest_kept,
        base.largest_dropped,
        exact.map_or(String::new(), |exact| format!("; {exact}"))
    );
    let mut text = format!("{evidence}\n{}\n", kept.join(", "));
    if !rules.is_empty() {
        text += &format!("\n{} grouped parameters act like:\n{}\n", rules.len(), rules.join("\n"));
    }
    if !none.is_empty() {
        text += &format!("\nwithout effect: {}\n", none.join(", "));
    }
    let json = json!({"kept": kept, "rules": rules, "without_effect": none, "smallest_kept": base.smallest_kept,
        "largest_dropped": base.largest_dropped, "finite_field": exact.map(|exact| exact.to_string())});
    Ok((text, json))
}
