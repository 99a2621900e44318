//! Tests of the table in docs/what-is-read.md: each kind of robot description and log can be read with the stated options, and
//! cannot be read correctly without them.
//!
//! `SNAPSHOTS=write cargo test -p tests --test program what_is_read` writes the page anew.

use std::path::Path;

use identification::estimate::options::Options;
use logs::{Columns, Table, propose};
use robot::format::{ReadOptions, parse_with};
use tests::{register_wings, text_of as text, workspace};

/// A description: its kind, the name of a file, its text, and whether the base must be asked to float.
const DESCRIPTIONS: [(&str, &str, &str, bool); 11] = [
    (
        "YAML, modified Denavit-Hartenberg",
        "arm.yaml",
        "convention: khalil-kleinfinger\nname: arm\nlinks: [{link: 1, antecedent: base, theta: q1}]\n",
        false,
    ),
    (
        "YAML, Craig's table",
        "arm.yaml",
        "convention: craig\nname: arm\nlinks: [{link: 1, antecedent: base, a: 0.1, theta: q1}]\n",
        false,
    ),
    (
        "YAML, standard Denavit-Hartenberg in degrees and millimetres",
        "arm.yaml",
        "convention: denavit-hartenberg\nangles: deg\nlengths: mm\nname: arm\nlinks: [{link: 1, antecedent: base, a: 100, \
         alpha: 90, theta: q1}]\n",
        false,
    ),
    ("URDF", "arm.urdf", URDF, false),
    ("URDF with a floating or planar root joint", "arm.urdf", FLOATING, true),
    ("xacro with macros, properties, arguments, includes", "arm.xacro", XACRO, false),
    ("MJCF", "arm.xml", MJCF, false),
    ("MJCF with a free joint", "arm.xml", FREE, true),
    (
        "SYMORO's .par",
        "arm.par",
        "(* Robotname = 'arm' *)\nNL = 1\nNJ = 1\nNF = 1\nType = 0\nAnt = {0}\nSigma = {0}\nmu = {1}\n",
        false,
    ),
    ("YAML with a loop", "arm.yaml", LOOP, false),
    ("SDF", "arm.sdf", SDF, false),
];

const URDF: &str = "<robot name=\"r\"><link name=\"b\"/><link name=\"l\"/><joint name=\"j\" type=\"continuous\"><parent link=\"b\"/>\
                    <child link=\"l\"/></joint></robot>";
const FLOATING: &str = "<robot name=\"r\"><link name=\"w\"/><link name=\"b\"/><joint name=\"f\" type=\"floating\"><parent \
                        link=\"w\"/><child link=\"b\"/></joint></robot>";
const XACRO: &str = "<robot name=\"r\" xmlns:xacro=\"http://www.ros.org/wiki/xacro\"><xacro:arg name=\"n\" default=\"2\"/>\
                     <xacro:macro name=\"l\" params=\"k\"><link name=\"l${k}\"/></xacro:macro><xacro:l k=\"1\"/>\
                     <xacro:l k=\"$(arg n)\"/><joint name=\"j\" type=\"continuous\"><parent link=\"l1\"/><child \
                     link=\"l2\"/></joint></robot>";
const MJCF: &str = "<mujoco><worldbody><body><joint/><geom size=\"0.1\"/></body></worldbody></mujoco>";
const FREE: &str = "<mujoco><worldbody><body><freejoint/><geom size=\"0.1\"/></body></worldbody></mujoco>";
const SDF: &str = "<sdf version=\"1.9\"><model name=\"m\"><link name=\"a\"/><link name=\"b\"/><joint name=\"j\" type=\"revolute\">\
                   <parent>a</parent><child>b</child></joint></model></sdf>";
const LOOP: &str = "convention: khalil-kleinfinger\nname: p\nlinks:\n- {link: 1, antecedent: base, theta: q1}\n- {link: 2, \
                    antecedent: base, d: 1, theta: q1, drive: passive}\n- {link: 3, antecedent: 1, d: 1, theta: -q1, drive: \
                    passive}\nloops:\n- {cut: {antecedent: 3, d: 1, theta: q1}, twin: {antecedent: 2, d: 1}}\n";

/// Files that are refused: (kind, file name, program or function that the message names for a conversion).
const CONVERTED: [(&str, &str, &str); 1] = [("a compiled model of MuJoCo", "arm.mjb", "mj_saveLastXML")];

/// Logs with two joints j1, j2: (kind, header line of a CSV, needed options).
const LOGS: [(&str, &str, &str); 15] = [
    ("columns by number", "t,q1,q2,tau1,tau2", ""),
    ("columns by joint, as in ROS", "time,j1/position,j2/position,j1/effort,j2/effort", ""),
    ("columns counted from 0, currents", "timestamp,actual_q_0,actual_q_1,actual_current_0,actual_current_1", ""),
    ("units in brackets", "t [s],q1 [°],q2 [°],tau1 [Nm],tau2 [Nm]", ""),
    ("names with a prefix", "t,position_left_j1,position_left_j2,effort_left_j1,effort_left_j2", ""),
    ("degrees and N mm that no header names", "t,q1,q2,tau1,tau2", "units: {position: deg, torque: N mm}"),
    ("ticks and counts of a servo", "t,q1,q2,i1,i2", "units: {position: ticks(4096), current: int16 counts(2.69 mA)}"),
    (
        "position servos that report neither torque nor current",
        "t,q1,q2,goal_j1,goal_j2",
        "columns: {goal: \"goal_{joint}\"}",
    ),
    ("per mille of a rated torque", "t,q_j1,q_j2,torque_j1,torque_j2", "units: {torque: permille(25 N m)}"),
    (
        "a trace in German",
        "Zeit,A1 Ist,A2 Ist,A1 Moment,A2 Moment",
        "columns: {time: Zeit, position: \"A{} Ist\", torque: \"A{} Moment\"}",
    ),
    (
        "names of the joints inside the headers",
        "t,my_j1_x,my_j2_x,your_j1_y,your_j2_y",
        "columns: {position: \"my_{joint}_x\", torque: \"your_{joint}_y\"}",
    ),
    (
        "messages of any type in MCAP and rosbag2",
        "time,motor_state[0].q,motor_state[1].q,motor_state[0].tau_est,motor_state[1].tau_est",
        "columns: {position: \"motor_state[{}].q\", torque: \"motor_state[{}].tau_est\"}",
    ),
    ("a joint that another mechanism moves", "t,q_j1,q_j2,x,tau_j2", "columns: {prescribed: [j1]}"),
    ("a joint without a drive", "t,q_j1,q_j2,x,tau_j2", "columns: {free: [j1]}"),
    ("no header", "", "columns: {time: c1, position: [c2, c3], torque: [c4, c5]}"),
];

/// Table of the readers of each log format. It checks that README and docs/identification.md name each format.
fn readers() -> String {
    let mut table =
        String::from("\nA wing is an optional package of rist.\n\n| format of the log | read by |\n|---|---|\n");
    let foreign = foreign::wing().log_formats;
    for name in logs::format_names() {
        let reader = match name {
            "Parquet" | "LeRobot" => "core, with the feature `parquet`",
            "rosbag2 files in sqlite3" => "the wing `foreign`, with the feature `rosbag2-sqlite`",
            _ if foreign.iter().any(|format| format.name == name) => "the wing `foreign`",
            _ => "core",
        };
        table += &format!("| {name} | {reader} |\n");
        let word = name.split(' ').next().unwrap();
        for page in ["README.md", "docs/identification.md"] {
            assert!(text(page).contains(word), "{page} lacks {word}");
        }
    }
    table + "\nARCHITECTURE.md says with the readers how much of the build time each feature takes.\n"
}

fn joints() -> [String; 2] {
    ["j1".to_string(), "j2".to_string()]
}

fn table(head: &str) -> Table {
    let mut text = if head.is_empty() { String::new() } else { format!("{head}\n") };
    for k in 0..200 {
        let t = f64::from(k) * 0.005;
        text += &format!("{t},{},{},{},{}\n", (3.0 * t).sin(), (2.0 * t).cos(), 4.0 * (3.0 * t).cos(), 1.5 * t);
    }
    Table::from_bytes("log.csv", text.as_bytes()).unwrap_or_else(|e| panic!("{e}"))
}

#[test]
fn the_page_says_what_each_kind_takes() {
    register_wings();
    let mut page = String::from(
        "# What is read\n\nThe test tests/tests/program/what_is_read.rs writes this page. It reads an example of each kind with the options \
         in the table, and checks that the example is not read correctly with fewer options.\n\n| description | needed options |\n|---|---|\n",
    );
    for (kind, file, text, floats) in DESCRIPTIONS {
        let read =
            |floating_base| parse_with(text, Path::new(file), ReadOptions { floating_base, ..ReadOptions::default() });
        assert_eq!(read(false).is_err(), floats, "{kind}: {:?}", read(false).err());
        if let Err(error) = read(floats) {
            panic!("{kind}: {error}");
        }
        page += &format!("| {kind} | {} |\n", if floats { "`--floating-base`" } else { "none" });
    }
    for (kind, file, tool) in CONVERTED {
        let refused = parse_with("<robot/>", Path::new(file), ReadOptions::default()).unwrap_err().to_string();
        assert!(refused.contains(tool.trim_matches('`')), "{kind}: {refused}");
        page += &format!("| {kind} | not read; first convert it with {tool} |\n");
    }
    page += "\nA xacro also needs `--arg NAME=VALUE` for each argument without a default. It needs `--package NAME=FOLDER` for each \
             package from which it includes files, if the package is not in a folder above the xacro. An expression that reads the environment (`$(env)`) is refused, and the message names it.\n";
    page += "\n| log | needed options |\n|---|---|\n";
    for (kind, head, options) in LOGS {
        let table = table(head);
        let names =
            Options::parse("options.yaml", &format!("{options}\nmodel: arm\n")).unwrap_or_else(|e| panic!("{e}"));
        Columns::find(&table, &joints(), &names.columns).unwrap_or_else(|e| panic!("{kind}: {e}"));
        let bare = Columns::find(&table, &joints(), &Options::default().columns);
        // Without options of `columns`, such a log cannot be read at all. Without options for units, it can be read, but with
        // wrong units.
        assert_eq!(bare.is_err(), options.starts_with("columns"), "{kind}");
        let takes = if options.is_empty() { "none".into() } else { format!("`{options}`") };
        page += &format!("| {kind} | {takes} |\n");
    }
    page += "\nThe examples are CSV, but all formats of logs have such columns: gzip, zstd, `.npz`, `.mat`, Arrow, Parquet, data sets of LeRobot, MCAP and rosbag2. No options are needed for a clock in two columns (seconds and nanoseconds), and for episodes that `episode_index` or the clock separates. `rist columns \
             ROBOT LOG` proposes the options, with reasons.\n";
    let trace = LOGS.iter().find(|log| log.0 == "a trace in German").expect("one of them");
    let trace = propose(&table(trace.1), &joints(), None);
    assert!(trace.mapping.is_some() && trace.to_string().contains("position: \"A{} Ist\""), "{trace}");
    page += &readers();
    let path = workspace().join("docs/what-is-read.md");
    if std::env::var_os("SNAPSHOTS").is_some() {
        std::fs::write(&path, &page).unwrap();
    }
    assert_eq!(std::fs::read_to_string(&path).unwrap_or_default(), page, "SNAPSHOTS=write writes it anew");
}
