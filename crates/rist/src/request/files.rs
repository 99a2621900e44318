//! Files that commands read and write in addition to logs. In Python these are arguments, or methods of the result.
//!
//! A field is one option of a request (a struct with all options of a command); here, each field is a path.

use std::path::PathBuf;

use experiments::motion::point_trajectory::Interpolation;
use experiments::motion::trajectory_file::TrajectoryFormat;

const METHOD: &str = "Method";
const BODIES: &str = "Bodies and loads";
const OUTPUTS: &str = "Outputs";

words! { TrajectoryFormat:
    Csv = "csv" "A row per sample",
    RosYaml = "ros-yaml" "A JointTrajectory of ROS, as YAML",
    RosJson = "ros-json" "A JointTrajectory of ROS, as JSON",
}

request! {
    /// Output files for the motions of a plan.
    pub struct TrajectoryFiles {
        /// Write each motion into this directory, as a file that a controller can play.
        trajectories: Option<PathBuf> = None, value_name("DIRECTORY");
        /// Format of the files of [trajectories].
        format: TrajectoryFormat = TrajectoryFormat::Csv;
    }
}

request! {
    /// Options for a file of points from another source.
    pub struct PointsFiles {
        /// How the controller interpolates between the points of a table or a JointTrajectory [default: the smoothest way that
        /// the points allow].
        interpolation: Option<Interpolation> = None;
    }
}

request! {
    /// The content of a report page.
    pub struct ReportFiles {
        /// A plan of rist plan.
        plan: Option<PathBuf> = None, value_name("FILE");
        /// A motion of rist excite.
        motion: Option<PathBuf> = None, value_name("FILE");
        /// An estimate of rist identify or rist solve.
        estimate: Option<PathBuf> = None, value_name("FILE");
        /// Another estimate of the same robot, to compare with [estimate]: from another day, load or method.
        against: Option<PathBuf> = None, value_name("FILE");
        /// A validation of rist validate.
        validation: Option<PathBuf> = None, value_name("FILE");
        /// The robot description with which the estimate or the motion was made.
        model: Option<PathBuf> = None, value_name("FILE");
        /// Logs to draw; [model] is needed too [default: the logs from which the estimate was made].
        log: Vec<PathBuf> = Vec::new(), value_name("LOG");
        /// The date on the page, in any form.
        date: Option<String> = None;
        /// Also write the pictures as SVG files into this directory.
        svg: Option<PathBuf> = None, value_name("DIRECTORY");
    }
}

request! {
    /// Input file of the methods that identify parameters from the logs of a plan.
    pub struct PlanFiles {
        /// The plan whose experiments are in the logs.
        plan: Option<PathBuf> = None, value_name("FILE"), heading(METHOD);
    }
}

request! {
    /// Input and output files of least squares on samples.
    pub struct SamplesFiles {
        /// Predict this log, which is not fitted; may be given several times.
        validate: Vec<PathBuf> = Vec::new(), value_name("LOG"), heading(OUTPUTS);
        /// Also identify the load that the last link carries in this log; may be given several times.
        loaded: Vec<PathBuf> = Vec::new(), value_name("LOG"), heading(BODIES);
        /// Write an HTML page with verdict, torques, residuals, friction and parameters.
        report: Option<PathBuf> = None, value_name("FILE"), heading(OUTPUTS);
        /// The date on the page of [report], in any form.
        date: Option<String> = None, heading(OUTPUTS);
        /// Write measured and predicted torques, filtered as in the fit, as CSV, or as Parquet (FILE.parquet).
        series: Option<PathBuf> = None, value_name("FILE"), heading(OUTPUTS);
    }
}

request! {
    /// Output files of least squares on samples, for estimates that contain identified bodies.
    pub struct BodiesFiles {
        /// Write the URDF with the identified inertials, joint damping and friction; implies [consistent].
        write_urdf: Option<PathBuf> = None, value_name("FILE"), heading(OUTPUTS);
        /// Write a MuJoCo model with the identified inertials, joint damping, friction loss and armature; implies [consistent].
        /// If the description is an MJCF, the rest of its text stays; otherwise the model has no shapes.
        write_mjcf: Option<PathBuf> = None, value_name("FILE"), heading(OUTPUTS);
        /// Another MuJoCo model. [write_mjcf] replaces the inertials and joint values in it, and keeps its shapes and all the
        /// rest.
        into: Option<PathBuf> = None, value_name("MODEL.xml"), heading(OUTPUTS);
        /// Write the URDF and the MuJoCo model even if the verdict is no.
        anyway: bool = false, heading(OUTPUTS);
        ..
        /// Files of all estimates from samples.
        samples: SamplesFiles;
    }
}
