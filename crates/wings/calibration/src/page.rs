//! The HTML page of a calibration: the verdict, the errors before and after as arrows on the robot and per posture, the fits, and
//! the calibrated parameters.
//!
//! Before: the description with fitted frames of base and tool. After: the fit that the user asked for.

use claims::significant;
use identification::estimate::verdict::{Trust, claim_line};
use nalgebra::Vector3;
use report::chart::Chart;
use report::identification::Origin;
use report::sections::{Section, SectionsPage};
use robot::Robot;

use crate::calibrate::Calibration;
use crate::level::Level;
use crate::measurement::ResidualKind;
use crate::parameter::ParameterGroup;
use crate::verdict::shown;

/// The longest arrow of the errors before calibration, relative to the size of the measured positions.
const ARROW_SHARE: f64 = 0.25;
/// The two views of the robot: names and axes of the drawn plane, of the base frame.
const VIEWS: [(&str, [usize; 2]); 2] = [("From the side (x, z)", [0, 2]), ("From above (x, y)", [0, 1])];
const AXES: [&str; 3] = ["x, m", "y, m", "z, m"];

/// A measured point in the base frame, m, and the error of its prediction before and after, m.
struct PointError {
    place: Vector3<f64>,
    errors: [Vector3<f64>; 2],
}

/// The kind of an error, and the points (posture, error in mm or mrad) before and after.
type PostureErrors = (ResidualKind, [Vec<(f64, f64)>; 2]);

impl Calibration {
    /// The page as HTML. `robot`: the robot of the calibration.
    pub fn page(&self, robot: &Robot, origin: &Origin) -> String {
        let verdict = &self.verdict;
        let (tone, answer) = match verdict.trust {
            Trust::Yes => ("yes", "Trust it"),
            Trust::WithCare => ("care", "With care"),
            Trust::No => ("no", "Do not use it"),
        };
        let next = verdict.next.iter().map(|next| format!("next: {next}"));
        let points = self.point_errors();
        let arrows = self.arrows(robot, &points);
        let series = self.posture_errors();
        let sections =
            [self.fits(), arrows, Some(postures(&series)), Some(self.parameter_table()), Some(self.claims())];
        let page = SectionsPage {
            kind: "calibration",
            title: robot.name.clone(),
            tone,
            verdict: answer.into(),
            reasons: verdict.reasons.iter().cloned().chain(next).collect(),
            sections: sections.into_iter().flatten().collect(),
        };
        page.html(origin)
    }

    /// The description, and the fit that the user asked for.
    fn before_and_after(&self) -> [&Level; 2] {
        [&self.levels[0], self.level()]
    }

    /// The table of the fits.
    fn fits(&self) -> Option<Section<'_>> {
        let row = |level: &Level| {
            let count = level.fit.active.len().to_string();
            vec![level.what.to_string(), shown(&level.fitted), shown(&level.left_out), count]
        };
        Some(Section {
            heading: "Accuracy".into(),
            text: vec![format!(
                "{} postures of {}. A fit is judged by its error on postures that were left out of it in turn.",
                self.problem.postures.len(),
                self.tip
            )],
            heads: vec!["fit of", "error on fitted postures", "on postures left out", "parameters"],
            rows: self.levels.iter().map(row).collect(),
            ..Section::default()
        })
    }

    /// The measured points with the errors of their predictions; empty if distances were measured.
    fn point_errors(&self) -> Vec<PointError> {
        if self.problem.kind.is_distance() {
            return Vec::new();
        }
        // The measurements are in the frame of the instrument. Both fits are drawn with the base of the last one.
        let to_base = self.level().fit.unknowns.base.inverse();
        let of_posture = |r: usize| {
            let posture = &self.problem.postures[r];
            let predicted = self.before_and_after().map(|level| {
                let at = &level.fit.unknowns;
                let pose = at.base.then(&self.problem.chain.pose(&posture.q, &posture.torque, &at.chain));
                at.points.iter().map(|own| pose.at(own)).collect::<Vec<_>>()
            });
            let whole = posture.points.iter().enumerate().filter(|(_, x)| x.iter().all(|x| x.is_finite()));
            whole
                .map(|(k, measured)| {
                    let measured = Vector3::from(*measured);
                    let errors = [0, 1].map(|level| to_base.rotation * (measured - predicted[level][k]));
                    PointError { place: to_base.at(&measured), errors }
                })
                .collect::<Vec<_>>()
        };
        (0..self.problem.postures.len()).flat_map(of_posture).collect()
    }

    /// The view from the side with the errors as arrows, as an SVG file; `None` without measured points.
    pub fn picture(&self, robot: &Robot) -> Option<String> {
        let views = self.arrows(robot, &self.point_errors())?;
        Some(views.charts.first()?.alone())
    }

    /// Two views of the robot with the errors as arrows; `None` without measured points.
    fn arrows(&self, robot: &Robot, points: &[PointError]) -> Option<Section<'static>> {
        // Scale of the arrows: the longest error before calibration is drawn about ARROW_SHARE times as long as `size`.
        let largest = points.iter().map(|p| p.errors[0].norm()).fold(0.0, f64::max);
        let centre = points.iter().map(|p| p.place).sum::<Vector3<f64>>() / points.len().max(1) as f64;
        let size = points.iter().map(|p| (p.place - centre).norm()).fold(0.0, f64::max);
        if largest == 0.0 || size == 0.0 {
            return None;
        }
        let scale = nice(ARROW_SHARE * size / largest);
        let links = self.skeleton(robot);
        let view = |(title, plane): (&str, [usize; 2])| {
            let flat = |v: &Vector3<f64>| (v[plane[0]], v[plane[1]]);
            let arrows = |level: usize| {
                points.iter().map(|p| vec![flat(&p.place), flat(&(p.place + scale * p.errors[level]))]).collect()
            };
            Chart::new(title, (AXES[plane[0]], AXES[plane[1]]))
                .true_to_scale()
                .line("robot", "c", &links.iter().map(flat).collect::<Vec<_>>())
                .pieces("before", "a", arrows(0))
                .pieces("after", "b", arrows(1))
        };
        Some(Section {
            heading: "Errors on the robot".into(),
            text: vec![format!(
                "A line begins at each measured point. It is the error of the prediction (measured minus predicted), {} times as \
                 long, before and after the calibration. Axes of the base frame. The robot is drawn at the first posture.",
                significant(scale, 3)
            )],
            charts: VIEWS.map(view).into(),
            ..Section::default()
        })
    }

    /// The origins of the links of the chain at the first posture, in the base frame, m.
    fn skeleton(&self, robot: &Robot) -> Vec<Vector3<f64>> {
        let mut q = vec![0.0; robot.n_variables()];
        let first = self.problem.postures.first().map_or(&[][..], |posture| &posture.q);
        self.problem.chain.coordinates.iter().zip(first).for_each(|(k, x)| q[*k] = *x);
        let poses = robot.link_poses(&q);
        let links = self.problem.chain.links.iter().map(|j| Vector3::from(poses[j.0].position));
        std::iter::once(Vector3::zeros()).chain(links).collect()
    }

    /// Root mean square error of each posture before and after: kind of the error, then both series in mm or mrad.
    fn posture_errors(&self) -> Vec<PostureErrors> {
        let series = |kind: ResidualKind, level: &Level| -> Vec<(f64, f64)> {
            let of = |r: usize| {
                let all = self.problem.residuals_of(&level.fit.unknowns, &[r]);
                let squares: Vec<f64> = all.iter().filter(|(_, own, _)| *own == kind).map(|(x, ..)| x * x).collect();
                let norm = squares.iter().sum::<f64>().sqrt();
                (!squares.is_empty()).then_some((r as f64 + 1.0, 1e3 * norm))
            };
            (0..self.problem.postures.len()).filter_map(of).collect()
        };
        let kinds = [ResidualKind::Length, ResidualKind::Angle];
        let all = kinds.map(|kind| (kind, self.before_and_after().map(|level| series(kind, level))));
        all.into_iter().filter(|(_, [before, _])| !before.is_empty()).collect()
    }

    /// The table of the calibrated parameters.
    fn parameter_table(&self) -> Section<'_> {
        let all = self.parameters(self.level());
        let of_robot = all.iter().filter(|p| p.parameter.group() != ParameterGroup::Frames);
        Section {
            heading: format!("Parameters: {}", self.level().what),
            text: vec!["Error of the description, with its 95 % interval.".into()],
            heads: vec!["parameter", "value", "half interval", "unit"],
            rows: of_robot.map(|p| self.parameter_cells(p).into()).collect(),
            ..Section::default()
        }
    }

    /// What was checked, and what the postures do not tell.
    fn claims(&self) -> Section<'_> {
        Section {
            heading: "Checks".into(),
            text: self.notes.iter().cloned().chain(self.verdict.claims.iter().map(claim_line)).collect(),
            ..Section::default()
        }
    }
}

/// The charts of the errors of each posture.
fn postures(series: &[PostureErrors]) -> Section<'_> {
    let charts = series.iter().map(|(kind, [before, after])| {
        let (title, axis) = match kind {
            ResidualKind::Length => ("Errors of positions", "error, mm"),
            ResidualKind::Angle => ("Errors of orientations", "error, mrad"),
        };
        Chart::new(title, ("posture", axis)).with_zero().dots("before", "a", before).dots("after", "b", after)
    });
    Section { heading: "Errors by posture".into(), charts: charts.collect(), ..Section::default() }
}

/// The largest of 1, 2 and 5 times a power of ten that is at most x.
fn nice(x: f64) -> f64 {
    let power = 10f64.powf(x.log10().floor());
    [5.0, 2.0, 1.0].into_iter().map(|k| k * power).find(|k| *k <= x).unwrap_or(power)
}
