//! Tests that no output overwrites a file that an input refers to (meshes, included parts, episodes), and that a program that is
//! stopped leaves no hidden files.

use std::path::Path;
use std::process::Command;

use logs::{Cells, parquet_bytes};
use tests::program::{LIMITED_ARM, folder, program, rist};

const JOINT: &str = r#"<joint name="j" type="revolute"><parent link="a"/><child link="b"/><axis xyz="0 1 0"/>
    <limit lower="-1" upper="1" velocity="1" effort="99"/></joint>"#;
const INERTIA: &str = r#"<inertia ixx="1" iyy="1" izz="1" ixy="0" ixz="0" iyz="0"/>"#;
const XACRO: &str = r#"<robot name="r" xmlns:xacro="http://www.ros.org/wiki/xacro">"#;

/// Writes robot files, one for each way in which a description can refer to another file.
fn robots(here: &Path) {
    let write = |name: &str, text: &str| std::fs::write(here.join(name), text).unwrap();
    let body = |mass: &str, mesh: &str| {
        let inertial = format!("<inertial><origin xyz=\"0.1 0.2 0.1\"/><mass value=\"{mass}\"/>{INERTIA}</inertial>");
        format!("<link name=\"a\"/><link name=\"b\">{inertial}{mesh}</link>{JOINT}</robot>")
    };
    write("arm.urdf", &format!("<robot name=\"r\">{}", body("1", "")));
    write("include.xacro", &format!("{XACRO}<xacro:include filename=\"arm.urdf\"/></robot>"));
    write("masses.yaml", "m: 2\n");
    let masses = "<xacro:property name=\"d\" value=\"${xacro.load_yaml('masses.yaml')}\"/>";
    write("masses.xacro", &format!("{XACRO}{masses}{}", body("${d['m']}", "")));
    write("part.xml", "<mujoco><default><geom density=\"500\"/></default></mujoco>");
    let geom = "<joint name=\"q\" axis=\"0 1 0\" range=\"-1 1\"/><geom type=\"box\" size=\".1 .1 .1\"/>";
    let bodies = format!("<worldbody><body name=\"x\">{geom}</body></worldbody>");
    write("arm.mjcf", &format!("<mujoco model=\"a\"><include file=\"part.xml\"/>{bodies}</mujoco>"));
    let mesh = "<collision><geometry><mesh filename=\"hand.stl\"/></geometry></collision>";
    write("mesh.urdf", &format!("<robot name=\"r\">{}", body("1", mesh)));
    let facet = "facet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex 0 1 0\nendloop\nendfacet\n";
    write("hand.stl", &format!("solid\n{facet}endsolid\n"));
}

/// Writes a data set (LeRobot) with two episodes of the robot `LIMITED_ARM`.
fn data_set(here: &Path) {
    for sub in ["set/meta", "set/data/chunk-000"] {
        std::fs::create_dir_all(here.join(sub)).unwrap();
    }
    std::fs::write(here.join("set/meta/info.json"), "{\"features\": {}}").unwrap();
    for episode in 0..2 {
        let t: Vec<f64> = (0..200).map(|k| 0.01 * f64::from(k)).collect();
        let of = |f: &dyn Fn(f64) -> f64| Cells::Numbers(t.iter().map(|t| f(*t)).collect());
        let number = f64::from(episode);
        let columns: Vec<(String, Cells)> = vec![
            ("timestamp".into(), of(&|t| t)),
            ("q1".into(), of(&|t| (3.0 * t).sin())),
            ("q2".into(), of(&|t| (4.0 * t).cos())),
            ("tau1".into(), of(&|t| 9.0 * (3.0 * t).cos())),
            ("tau2".into(), of(&|t| 3.0 * (4.0 * t).cos())),
            ("episode_index".into(), of(&|_| number)),
        ];
        let name = format!("set/data/chunk-000/episode_00000{episode}.parquet");
        std::fs::write(here.join(name), parquet_bytes(&columns).unwrap()).unwrap();
    }
    std::fs::write(here.join("arm.yaml"), LIMITED_ARM).unwrap();
}

#[test]
fn nothing_that_an_input_brings_along_is_written_over() {
    let here = folder("brought-along");
    robots(&here);
    data_set(&here);
    let excite = ["excite", "mesh.urdf", "--starts", "1", "--iterations", "1", "--out"];
    let episode = "set/data/chunk-000/episode_000001.parquet";
    for (words, brought) in [
        (&["convert", "include.xacro", "--to", "urdf", "--out"][..], "arm.urdf"),
        (&["convert", "masses.xacro", "--to", "yaml", "--out"], "masses.yaml"),
        (&["generate", "arm.mjcf", "--out"], "part.xml"),
        (&["derive", "arm.mjcf", "--function", "torque", "--out"], "part.xml"),
        (&["convert", "mesh.urdf", "--to", "yaml", "--out"], "hand.stl"),
        (&excite, "hand.stl"),
        (&["identify", "arm.yaml", "set", "--anyway", "--out"], episode),
        (&["identify", "arm.yaml", "set", "--report"], "set/meta/info.json"),
        (&["accumulate", "arm.yaml", "set", "--anyway", "--out"], episode),
    ] {
        let before = std::fs::read(here.join(brought)).unwrap();
        let (hard, soft) = (here.join("hard"), here.join("soft"));
        [&hard, &soft].iter().for_each(|link| drop(std::fs::remove_file(link)));
        std::fs::hard_link(here.join(brought), &hard).unwrap();
        std::os::unix::fs::symlink(brought, &soft).unwrap();
        for out in [brought, "hard", "soft"] {
            let run = rist(&here, &[words, &[out]].concat());
            let said = format!("{words:?} {out}: {:?} {}", run.code, run.err);
            assert!(run.code == Some(2) && run.err.contains("an input ("), "{said}");
            assert!(run.err.contains("which is not written over"), "{said}");
            assert_eq!(std::fs::read(here.join(brought)).unwrap(), before, "{said}");
        }
    }
    // A file to which only other descriptions refer, not this input, may be overwritten.
    rist(&here, &["convert", "arm.mjcf", "--to", "urdf", "--out", "arm.urdf"]).ended(0);
}

/// If simulated logs would overwrite an input of the command, the command is refused before a log is written.
#[test]
fn a_folder_of_logs_holds_no_input() {
    let here = folder("simulated-over");
    std::fs::write(here.join("truth.yaml"), LIMITED_ARM).unwrap();

    rist(&here, &["excite", "truth.yaml", "--starts", "1", "--iterations", "1", "--out", "motion.yaml"]).ended(0);
    rist(&here, &["simulate", "truth.yaml", "motion.yaml", "--out", "."]).failed(2, &["truth.yaml: an input ("]);
    assert_eq!(std::fs::read_dir(&here).unwrap().count(), 2);
}

#[test]
fn a_pipe_is_called_a_pipe() {
    let here = folder("pipes");
    robots(&here);
    for (file, command) in [
        ("hand.stl", &["excite", "mesh.urdf", "--starts", "1", "--iterations", "1"][..]),
        ("part.xml", &["inspect", "arm.mjcf"]),
        ("masses.yaml", &["inspect", "masses.xacro"]),
    ] {
        std::fs::remove_file(here.join(file)).unwrap();
        let absent = rist(&here, command);
        assert!(!(absent.out + &absent.err).contains("named pipe"), "{file}");
        assert!(Command::new("mkfifo").arg(here.join(file)).status().unwrap().success());
        let run = rist(&here, command);
        let said = run.out + &run.err;
        assert!(said.contains(&format!("{file} is a named pipe, and a file is expected")), "{file}: {said}");
    }
}

/// If the program is ended by SIGTERM or Ctrl-C at any time, no hidden file remains. Hidden files that remain after SIGKILL are
/// removed by the next run.
#[test]
fn a_program_that_is_ended_leaves_nothing_hidden() {
    let here = folder("ended");
    std::fs::write(here.join("arm.yaml"), LIMITED_ARM).unwrap();

    rist(&here, &["excite", "arm.yaml", "--starts", "1", "--iterations", "1", "--out", "motion.yaml"]).ended(0);
    let simulate = ["simulate", "arm.yaml", "motion.yaml", "--validation", "20", "--out", "logs"];
    let hidden = || {
        let names = std::fs::read_dir(here.join("logs")).into_iter().flatten().flatten().map(|entry| entry.file_name());
        names.filter(|name| name.to_string_lossy().starts_with('.')).count()
    };
    for signal in ["TERM", "INT", "KILL"] {
        for k in 0..8 {
            let mut run = Command::new(program());
            let run = run.args(simulate).current_dir(&here).stdout(std::process::Stdio::null());
            let mut child = run.stderr(std::process::Stdio::null()).spawn().unwrap();
            // The signal comes at a different time in each run.
            std::thread::sleep(std::time::Duration::from_millis(60 + 23 * k));
            let kill = format!("kill -{signal} {}", child.id());
            Command::new("sh").args(["-c", &kill]).output().unwrap();
            child.wait().unwrap();
            assert!(signal == "KILL" || hidden() == 0, "{signal}");
        }
    }
    std::fs::write(here.join("logs/.v01.csv.0123456789abcdef.rist-part"), "half").unwrap();
    assert!(hidden() > 0);
    assert_eq!(rist(&here, &simulate).code, Some(0));
    assert_eq!(hidden(), 0);
}
