//! The classes `rist.ExperimentPlan` and `rist.ExcitingMotion`.
//!
//! A plan is a list of experiments; an exciting motion is one motion of all joints. Both state their limits and can prove them
//! again.

use std::path::{Path, PathBuf};

use pyo3::prelude::*;
use rist::motion::motion_plot_data::{ShownMotion, checked_motion, found_motion, motion_of_file};
use rist::page::{Origin, PageRequest, PlanProof};
use rist::request::spelling::Audience;
use rist::{PlayFormat, TrajectoryFormat, trajectory_file};

use crate::artefact::{artefact, make_directory, read_text, save};
use crate::error::{OrError, error};
use crate::model::Model;
use crate::work::alone;

artefact! {
    ExperimentPlan,
    rist::motion::planning::ExperimentPlan,
    "Experiments for identification by spectrum analysis, with the accuracy that they promise.",
    /// Names of the experiments: their logs are e01.csv, ..
    #[getter]
    fn names(&self) -> Vec<String> {
        self.inner.experiments.iter().map(|e| e.name.clone()).collect()
    }
    /// Writes each motion into a directory, as a file that a controller can play, sampled at `rate` Hz: "csv", or a
    /// JointTrajectory of ROS as "yaml" or "json".
    #[pyo3(signature = (directory, rate, format="csv"))]
    fn write_trajectories(&self, directory: PathBuf, rate: f64, format: &str) -> PyResult<()> {
        let formats = [TrajectoryFormat::Csv, TrajectoryFormat::RosYaml, TrajectoryFormat::RosJson];
        let Some(format) = formats.into_iter().find(|known| known.extension() == format) else {
            return Err(error(format_args!("write_trajectories: format={format:?}: one of csv, yaml, json is expected")));
        };
        if !(rate.is_finite() && rate > 0.0) {
            return Err(error(format_args!("write_trajectories: rate={rate}: a positive number of Hz is expected")));
        }
        make_directory(&directory)?;
        for (e, t) in self.inner.experiments.iter().zip(self.inner.trajectories("plan").or_error()?) {
            let text = trajectory_file(&t.reference(), &self.inner.coordinates, rate, format);
            save(&directory.join(format!("{}.{}", e.name, format.extension())), &text, &[])?;
        }
        Ok(())
    }
    /// Writes one self-contained HTML page. With the model, or the path of its description, the limits of each experiment and
    /// the guaranteed efficiency of the plan are proved again. Without a model, the page shows the statements of the file.
    #[pyo3(signature = (path, date=None, model=None))]
    fn report(
        &self,
        py: Python<'_>,
        path: PathBuf,
        date: Option<&str>,
        model: Option<&Bound<'_, PyAny>>,
    ) -> PyResult<()> {
        let model = model.map(Model::of).transpose()?;
        let model = model.as_ref().map(Bound::get).or(self.model.as_ref().map(Py::get)).map(|model| &*model.inner);
        let proof = model.map(|model| alone(py, || rist::plan_proof(model, Path::new("the plan"), &self.inner))?.or_error());
        save(&path, &self.page_with(date, model, proof.transpose()?.as_ref()), &[])
    }
}

impl ExperimentPlan {
    /// The page of the plan; with the result of a new proof, if there is one.
    fn page_with(&self, date: Option<&str>, model: Option<&rist::Model>, plan_proof: Option<&PlanProof>) -> String {
        let command = "rist.ExperimentPlan.report";
        let origin = Origin { date, version: env!("CARGO_PKG_VERSION"), command, model: None };
        let (plan, reader) = (Some(&self.inner), Audience::Python);
        let request = PageRequest { model, plan, plan_proof, origin, reader, ..PageRequest::default() };
        rist::page::page(&request).0
    }

    /// The page of the plan without a new proof.
    fn page(&self, date: Option<&str>) -> Option<String> {
        let model = self.model.as_ref().map(|model| model.get().inner.as_ref());
        Some(self.page_with(date, model, None))
    }

    /// Takes a plan, or the path of one. Fails if it was made with another model.
    pub fn of(given: &Bound<'_, PyAny>, model: &rist::Model) -> PyResult<rist::motion::planning::ExperimentPlan> {
        let (plan, path) = match given.cast::<ExperimentPlan>() {
            Ok(plan) => (plan.get().inner.clone(), PathBuf::from("plan")),
            Err(_) => {
                let path: PathBuf =
                    given.extract().map_err(|_| error("a plan is an ExperimentPlan or the path of plan.yaml"))?;
                (
                    rist::motion::planning::ExperimentPlan::from_yaml(&path.display().to_string(), &read_text(&path)?)
                        .or_error()?,
                    path,
                )
            }
        };
        model.check(&path, &plan.model).or_error()?;
        Ok(plan)
    }
}

artefact! {
    ExcitingMotion,
    rist::motion::exciting::ExcitingMotion,
    "One motion of all joints that excites the parameters, with the proof that it keeps its limits.",
    /// Whether every checked limit is proven, also between the samples, and every requested check was possible.
    #[getter]
    fn proven(&self) -> bool {
        self.inner.proven
    }
    /// Assumptions about what the description does not say, as sentences.
    #[getter]
    fn notes(&self) -> Vec<String> {
        self.inner.notes.clone()
    }
    /// Condition number of the scaled columns of the parameters that the motion excites.
    #[getter]
    fn condition_number(&self) -> f64 {
        self.inner.condition_number
    }
    /// Writes one self-contained HTML page: the motion within its limits, the path of the tip, and the parameters that the
    /// motion excites. For a motion from a file, give its model, or the path of the description: only then is everything drawn,
    /// and the limits are proved again.
    #[pyo3(signature = (path, date=None, model=None))]
    fn report(
        &self,
        py: Python<'_>,
        path: PathBuf,
        date: Option<&str>,
        model: Option<&Bound<'_, PyAny>>,
    ) -> PyResult<()> {
        let given = model.map(Model::of).transpose()?;
        let given = given.as_ref().map(|model| &*model.get().inner);
        let page = match given {
            Some(model) => alone(py, || self.page_with(date, ProofOrigin::ProvedAnew(model)))?,
            None => self.page_with(date, self.shown()),
        };
        save(&path, &page.or_error()?.0, &[])
    }
    /// Writes the motion for a controller to play. The end of the file name selects the format: .csv, .yaml or .json (ROS
    /// JointTrajectory), .script (URScript servoj). Raises rist.Error if the limits are not proven, unless unproven=True.
    #[pyo3(signature = (path, unproven=false, model=None))]
    fn write_play(&self, path: PathBuf, unproven: bool, model: Option<&Bound<'_, PyAny>>) -> PyResult<()> {
        let model = model.map(Model::of).transpose()?;
        let Some(model) = model.as_ref().map(Bound::get).or(self.model.as_ref().map(Py::get)) else {
            return Err(error("write_play: a motion out of a file is played with its model: give model="));
        };
        let model = &model.inner;
        model.check(Path::new("the motion"), &self.inner.model).or_error()?;
        if !self.inner.proven && !unproven {
            let faults = self.inner.claims().faults().join("; ");
            return Err(error(format_args!("its limits are not proven: {faults} (unproven=True writes it anyway)")));
        }
        let player = PlayFormat::of_file(&path, model).or_error()?;
        save(&path, &player.text(&self.inner).or_error()?, &[&model.path])
    }
    /// Draws positions and velocities over time, with the limits of the positions. Returns axes of matplotlib; without
    /// matplotlib, a rist.Picture of the page.
    fn plot<'py>(slf: &Bound<'py, Self>) -> PyResult<Bound<'py, PyAny>> {
        slf.py().import("rist._plot")?.call_method1("motion", (slf,))
    }
    /// The charts of the HTML page of this motion: the name and the SVG text of each chart.
    fn _pictures(&self) -> PyResult<Vec<(String, String)>> {
        Ok(self.page_with(None, self.shown()).or_error()?.1)
    }
    /// The motion to play, sampled at `rate_hz`, as a text in CSV.
    fn trajectory(&self) -> PyResult<String> {
        let names: Vec<String> = self.inner.joints.iter().map(|j| j.coordinate.clone()).collect();
        let reference = self.inner.motion("the motion").or_error()?.reference();
        Ok(trajectory_file(&reference, &names, self.inner.rate_hz, TrajectoryFormat::Csv))
    }
}

/// Where the limits that a page shows were proved.
enum ProofOrigin<'a> {
    /// By the search that found the motion with this model.
    Found(&'a rist::Model),
    /// By a new proof with this model, independent of the statements in the file.
    ProvedAnew(&'a rist::Model),
    /// Nowhere: without a model, the page repeats the statements in the file.
    OfFile,
}

impl ExcitingMotion {
    /// The page of the motion, and its charts. Torques and the path of the end effector need a model.
    fn page_with(
        &self,
        date: Option<&str>,
        shown: ProofOrigin<'_>,
    ) -> Result<(String, Vec<(String, String)>), rist::Error> {
        let (artefact, file) = (&self.inner, Path::new("motion"));
        let (model, plot_data) = match shown {
            ProofOrigin::Found(model) => (Some(model), found_motion(model, artefact)?),
            ProofOrigin::ProvedAnew(model) => (Some(model), checked_motion(model, file, artefact)?),
            ProofOrigin::OfFile => (None, motion_of_file(file, artefact)?),
        };
        let command = "rist.ExcitingMotion.report";
        let origin = Origin { date, version: env!("CARGO_PKG_VERSION"), command, model: None };
        let motion = Some(ShownMotion { artefact, plot_data: &plot_data });
        let request = PageRequest { model, motion, origin, reader: Audience::Python, ..PageRequest::default() };
        let (page, pictures) = rist::page::page(&request);
        Ok((page, pictures))
    }

    /// Where the limits on the page were proved. If the model is known, the search that found the motion has proved them.
    /// Otherwise there is no proof, and the page repeats the statements in the file.
    fn shown(&self) -> ProofOrigin<'_> {
        self.model.as_ref().map_or(ProofOrigin::OfFile, |model| ProofOrigin::Found(&model.get().inner))
    }

    /// The page of the motion; `None` if it cannot be drawn.
    fn page(&self, date: Option<&str>) -> Option<String> {
        Some(self.page_with(date, self.shown()).ok()?.0)
    }

    /// Takes a motion, or the path of one.
    pub fn of(given: &Bound<'_, PyAny>) -> PyResult<rist::motion::exciting::ExcitingMotion> {
        if let Ok(motion) = given.cast::<ExcitingMotion>() {
            return Ok(motion.get().inner.clone());
        }
        let path: PathBuf =
            given.extract().map_err(|_| error("a motion is an ExcitingMotion or the path of motion.yaml"))?;
        rist::motion::exciting::ExcitingMotion::from_yaml(&path.display().to_string(), &read_text(&path)?).or_error()
    }
}
