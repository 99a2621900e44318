//! The commands in the order of use, by what they are for: the flags that most people need, and an example each.

use Shown::{All, Only, Own};

/// A step of the work, with its commands in the order of use.
pub(crate) struct Group {
    pub title: &'static str,
    pub commands: &'static [Told],
}

/// What help says of a command.
pub(crate) struct Told {
    pub name: &'static str,
    /// The flags that `--help` shows.
    pub shown: Shown,
    /// Command lines, with what they are for.
    pub examples: &'static [(&'static str, &'static str)],
}

/// The flags that `--help` shows; `--help-all` shows all.
pub(crate) enum Shown {
    /// All of them.
    All,
    /// Its own, not how a description is read.
    Own,
    /// These.
    Only(&'static [&'static str]),
}

pub(crate) const GROUPS: [Group; 7] = [
    Group {
        title: "Try it",
        commands: &[Told {
            name: "example",
            shown: All,
            examples: &[("rist example", "a robot and two logs of it, to run the other commands on")],
        }],
    },
    Group {
        title: "Describe a robot",
        commands: &[
            Told {
                name: "inspect",
                shown: All,
                examples: &[
                    ("rist inspect robot.urdf", "the base parameters: what a torque can tell of the robot"),
                    (
                        "rist inspect robot.urdf --format html > robot.html",
                        "the same as a page with the regrouping drawn",
                    ),
                ],
            },
            Told {
                name: "lint",
                shown: All,
                examples: &[("rist lint robot.urdf", "masses, inertias and frames that cannot be meant")],
            },
            Told {
                name: "convert",
                shown: All,
                examples: &[
                    ("rist convert robot.urdf --to yaml --out robot.yaml", "the robot in modified DH frames"),
                    ("rist convert robot.urdf --parameters mujoco", "inertial parameters by the names of MuJoCo"),
                ],
            },
        ],
    },
    Group {
        title: "Make it move",
        commands: &[
            Told {
                name: "excite",
                shown: Only(&[
                    "motion",
                    "period",
                    "limits",
                    "effort_share",
                    "friction",
                    "starts",
                    "after",
                    "out",
                    "play",
                    "report",
                    "unproven",
                ]),
                examples: &[
                    (
                        "rist excite robot.urdf --out motion.yaml --play motion.csv",
                        "a motion, and its samples for a controller",
                    ),
                    (
                        "rist excite robot.urdf --limits cell.yaml --out motion.yaml --report motion.html",
                        "within the limits and walls of a cell, with a page that draws it",
                    ),
                ],
            },
            Told {
                name: "check",
                shown: Own,
                examples: &[
                    ("rist check robot.urdf motion.yaml", "prove its limits again, from the file alone"),
                    ("rist check robot.urdf moveit.yaml --limits cell.yaml", "a trajectory of another program"),
                ],
            },
            Told {
                name: "play",
                shown: Own,
                examples: &[(
                    "rist play robot.urdf motion.yaml --controller ur-e --speed 0.3 --from q1=0,q2=-1 --out m.script",
                    "a third of the speed, from where the robot stands and back",
                )],
            },
            Told {
                name: "visibility",
                shown: Own,
                examples: &[(
                    "rist visibility robot.urdf log.csv",
                    "whether a log is worth an identification, before torques",
                )],
            },
            Told {
                name: "plan",
                shown: Only(&[
                    "experiments",
                    "limits",
                    "profile",
                    "steps",
                    "duration",
                    "rate",
                    "starts",
                    "out",
                    "trajectories",
                    "format",
                ]),
                examples: &[
                    (
                        "rist plan robot.yaml --out plan.yaml --trajectories motions",
                        "eight short experiments for the spectrum method, and their samples",
                    ),
                    (
                        "rist identify robot.yaml logs --plan plan.yaml --method rist-mh",
                        "later, with the logs of these experiments",
                    ),
                ],
            },
            Told {
                name: "simulate",
                shown: Own,
                examples: &[(
                    "rist simulate robot.urdf motion.yaml --out logs",
                    "logs/motion.csv: what a robot in closed loop would record, with noise and friction",
                )],
            },
        ],
    },
    Group {
        title: "Look at logs",
        commands: &[
            Told {
                name: "columns",
                shown: Own,
                examples: &[(
                    "rist columns robot.urdf log.csv > options.yaml",
                    "names and units of columns that are not found by themselves",
                )],
            },
            Told {
                name: "postures",
                shown: Own,
                examples: &[
                    ("rist postures robot.urdf", "what a robot at rest can tell"),
                    ("rist postures robot.urdf postures.csv", "gravity parameters, zeros and mount from it"),
                ],
            },
            Told {
                name: "wrench",
                shown: Own,
                examples: &[("rist wrench log.csv", "mass, centre and inertia of what a force-torque sensor holds")],
            },
            Told {
                name: "doctor",
                shown: Own,
                examples: &[("rist doctor robot.urdf log.csv", "do they belong together, and if not, what mends it")],
            },
        ],
    },
    Group {
        title: "Identify",
        commands: &[
            Told {
                name: "identify",
                shown: Only(&[
                    "gain",
                    "friction",
                    "loaded",
                    "cutoff",
                    "delay",
                    "write_urdf",
                    "write_mjcf",
                    "validate",
                    "report",
                    "out",
                    "rotor_inertia",
                ]),
                examples: &[
                    (
                        "rist identify robot.urdf log.csv --validate other.csv --out estimate.yaml --report page.html",
                        "fit a log, predict another one, and write the page that shows both",
                    ),
                    (
                        "rist identify robot.urdf log.mcap --gain elbow=11.5,wrist=7+-2 --write-urdf new.urdf",
                        "bodies that can exist, from motor currents, in a URDF",
                    ),
                ],
            },
            Told {
                name: "validate",
                shown: Own,
                examples: &[(
                    "rist validate robot.urdf estimate.yaml other.csv --report page.html",
                    "how well the estimate predicts a log that it was not made from",
                )],
            },
            Told {
                name: "report",
                shown: Own,
                examples: &[
                    (
                        "rist report --model robot.urdf --estimate estimate.yaml --out page.html",
                        "the page of an estimate",
                    ),
                    ("rist report --model robot.urdf --motion motion.yaml --out motion.html", "the page of a motion"),
                ],
            },
        ],
    },
    Group {
        title: "Many logs, many robots",
        commands: &[
            Told {
                name: "accumulate",
                shown: Only(&["out", "like", "skip_broken", "options", "gain", "cutoff", "threads"]),
                examples: &[(
                    "rist accumulate robot.urdf a.csv b.csv --out monday.tri",
                    "a day of logs as one small file",
                )],
            },
            Told {
                name: "merge",
                shown: All,
                examples: &[("rist merge monday.tri tuesday.tri --out week.tri", "two days as one")],
            },
            Told {
                name: "solve",
                shown: All,
                examples: &[("rist solve week.tri --out estimate.yaml", "the estimate of all logs behind the sums")],
            },
            Told {
                name: "compare",
                shown: All,
                examples: &[("rist compare monday.tri friday.tri", "which parameters moved since Monday")],
            },
        ],
    },
    Group {
        title: "Use what was found",
        commands: &[
            Told {
                name: "generate",
                shown: Own,
                examples: &[
                    (
                        "rist generate robot.urdf --functions inverse-dynamics,inertia-matrix --out robot.rs",
                        "Rust without dependencies, for a control loop",
                    ),
                    (
                        "rist generate robot.urdf --functions controller --estimate estimate.yaml --language c --out robot",
                        "robot.c and robot.h, with the identified numbers",
                    ),
                ],
            },
            Told {
                name: "derive",
                shown: Own,
                examples: &[
                    ("rist derive robot.yaml --function gravity", "gravity torques as formulas"),
                    ("rist derive robot.yaml --function inertia-matrix --language sympy", "a script of SymPy"),
                ],
            },
            Told {
                name: "evaluate",
                shown: All,
                examples: &[(
                    "rist evaluate robot.urdf states.csv --quantity torque",
                    "torques as CSV, to check us by",
                )],
            },
            Told {
                name: "schema",
                shown: All,
                examples: &[("rist schema > schema.json", "for a program that calls us")],
            },
            Told {
                name: "completions",
                shown: All,
                examples: &[(
                    "rist completions bash > ~/.local/share/bash-completion/completions/rist",
                    "the tabulator key knows commands and flags",
                )],
            },
            Told {
                name: "man",
                shown: All,
                examples: &[("rist man --out man", "man/rist.1 and a page for each command")],
            },
            Told {
                name: "notices",
                shown: All,
                examples: &[("rist notices", "whose work is in the program, under which licences")],
            },
        ],
    },
];
