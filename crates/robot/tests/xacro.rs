//! Descriptions with macros: their expansion, refused texts, and a comparison with the Python program xacro.

mod cost;
mod recursion;

use std::path::{Path, PathBuf};
use std::process::Command;

use random::Random;
use robot::Robot;
use robot::format::{ReadOptions, parse_with, read_with, without_macros};

const HEAD: &str = "<robot name=\"r\" xmlns:xacro=\"http://www.ros.org/wiki/xacro\">";
const JOINT: &str = "<joint name=\"j\" type=\"revolute\"><parent link=\"a\"/><child link=\"b\"/><limit lower=\"-1\" upper=\"1\" \
                     velocity=\"1\" effort=\"1\"/></joint>";

fn read(body: &str, arguments: &[(String, String)]) -> Result<Robot, String> {
    let text = format!("{HEAD}\n{body}\n{JOINT}</robot>");
    let options = ReadOptions { arguments, ..ReadOptions::default() };
    parse_with(&text, Path::new("arm.xacro"), options).map_err(|e| e.to_string())
}

/// The mass of link b, kg.
fn mass(robot: &Robot) -> f64 {
    let link = robot.links.iter().find(|link| link.inertial.is_some()).expect("a link weighs");
    link.inertial.unwrap()[9]
}

/// The texts of link a, and of link b with a mass.
fn links(mass: &str) -> String {
    format!(
        "<link name=\"a\"/><link name=\"b\"><inertial><mass value=\"{mass}\"/><inertia ixx=\"1\" iyy=\"1\" izz=\"1\" ixy=\"0\" \
         ixz=\"0\" iyz=\"0\"/></inertial></link>"
    )
}

/// An expanded xacro is a URDF of the same robot without macros. Texts of other formats are not changed.
#[test]
fn a_xacro_is_written_out() {
    let arguments = [("m".to_string(), "3".to_string())];
    let options = ReadOptions { arguments: &arguments, ..ReadOptions::default() };
    let body = format!("<xacro:arg name=\"m\" default=\"7\"/>{}", links("$(arg m)"));
    let text = format!("{HEAD}\n{body}\n{JOINT}</robot>");
    let written = without_macros(&text, Path::new("arm.xacro"), options).unwrap();
    assert!(!written.contains("xacro:") && !written.contains("$("), "{written}");
    let read = |text: &str, path: &str| parse_with(text, Path::new(path), options).unwrap();
    assert_eq!(mass(&read(&written, "arm.urdf")), 3.0);
    assert_eq!(read(&written, "arm.urdf").links.len(), read(&text, "arm.xacro").links.len());
    assert_eq!(without_macros(&written, Path::new("arm.urdf"), options).unwrap(), written);
}

#[test]
fn what_macros_stand_for() {
    for (body, asked, expected) in [
        ("<xacro:property name=\"m\" value=\"2\"/>", "${2*m}", 4.0),
        // A property is evaluated at its first use, so it may contain properties that are defined later.
        ("<xacro:property name=\"x\" value=\"${m + 1}\"/><xacro:property name=\"m\" value=\"4\"/>", "${x}", 5.0),
        ("<xacro:property name=\"m\" value=\"4\"/><xacro:property name=\"m\" default=\"5\"/>", "${m}", 4.0),
        ("<xacro:arg name=\"m\" default=\"7\"/>", "$(arg m)", 7.0),
        ("<xacro:arg name=\"m\" default=\"7\"/>", "${$(arg m) + 1}", 8.0),
        // Names in `$(eval)` are arguments; a property of the same name does not count there.
        ("<xacro:property name=\"m\" value=\"4\"/><xacro:arg name=\"m\" default=\"7\"/>", "$(eval m * 2)", 14.0),
        ("<xacro:arg name=\"e\" default=\"none\"/>", "$(eval 2 if e == 'none' and not false else 3)", 2.0),
        ("<xacro:property name=\"x\" value=\"1 2 3\"/>", "${x.split(' ')[2]}", 3.0),
        // A property without lazy evaluation is evaluated at its definition, and later definitions do not change it.
        (
            "<xacro:property name=\"a\" value=\"1\"/><xacro:property name=\"b\" value=\"${a}\" lazy_eval=\"false\"/>\
             <xacro:property name=\"a\" value=\"2\"/>",
            "${b}",
            1.0,
        ),
    ] {
        assert_eq!(mass(&read(&format!("{body}{}", links(asked)), &[]).unwrap()), expected, "{body}");
    }
}

#[test]
fn macros_take_parameters_blocks_and_conditions() {
    let part = "<xacro:macro name=\"part\" params=\"name m:=3 *inertia extra:=^|1\"><link name=\"${name}\"><xacro:if \
                value=\"${m > 0}\"><inertial><mass value=\"${m*extra}\"/><xacro:insert_block name=\"inertia\"/></inertial></xacro:if>\
                <xacro:unless value=\"${m > 0}\"/></link></xacro:macro>";
    let unit = "<inertia ixx=\"1\" iyy=\"1\" izz=\"1\" ixy=\"0\" ixz=\"0\" iyz=\"0\"/>";
    for (before, call, expected) in [
        ("", "name=\"b\"", 3.0),
        ("", "name=\"b\" m=\"${2**2}\"", 4.0),
        ("<xacro:property name=\"extra\" value=\"2\"/>", "name=\"b\" m=\"5\"", 10.0),
    ] {
        let body = format!("{part}{before}<link name=\"a\"/><xacro:part {call}>{unit}</xacro:part>");
        assert_eq!(mass(&read(&body, &[]).unwrap()), expected, "{call}");
    }
    // This macro calls itself; each call has its own parameter `n`.
    let tower = "<xacro:macro name=\"tower\" params=\"n\"><xacro:if value=\"${n > 0}\"><xacro:property name=\"total\" \
                 value=\"${total + n}\" scope=\"global\"/><xacro:tower n=\"${n - 1}\"/></xacro:if></xacro:macro><xacro:property \
                 name=\"total\" value=\"0\"/><xacro:tower n=\"4\"/>";
    assert_eq!(mass(&read(&format!("{tower}{}", links("${total}")), &[]).unwrap()), 10.0);
}

#[test]
fn files_are_read_below_the_folder_and_below_packages() {
    let here = std::env::temp_dir().join(format!("rist-xacro-{}", std::process::id()));
    let _ = std::fs::remove_dir_all(&here);
    for folder in ["arm/inc", "tools/config"] {
        std::fs::create_dir_all(here.join(folder)).unwrap();
    }
    let put = |name: &str, text: &str| std::fs::write(here.join(name), text).unwrap();
    put(
        "arm/inc/parts.xacro",
        &format!("{HEAD}<xacro:property name=\"own\" value=\"1\"/><xacro:include filename=\"more.xacro\"/></robot>"),
    );
    put("arm/inc/more.xacro", &format!("{HEAD}<xacro:property name=\"more\" value=\"2\"/></robot>"));
    put("tools/config/masses.yaml", "tool: {mass: 4, angle: !degrees 180}\n");
    let body = |file: &str| {
        format!(
            "{HEAD}<xacro:include filename=\"inc/parts.xacro\"/><xacro:property name=\"y\" value=\"${{load_yaml('{file}')}}\"/>{}{JOINT}</robot>",
            links("${own + more + y['tool']['mass'] + (y.tool.angle - pi)}")
        )
    };
    put("arm/arm.xacro", &body("$(find tools)/config/masses.yaml"));
    put("arm/out.xacro", &body("../tools/config/masses.yaml"));
    let packages = [("tools".to_string(), here.join("tools"))];
    let options = ReadOptions { packages: &packages, ..ReadOptions::default() };
    assert_eq!(mass(&read_with(&here.join("arm/arm.xacro"), options).unwrap()), 7.0);
    assert_eq!(mass(&read_with(&here.join("arm/out.xacro"), options).unwrap()), 7.0);
    let message = read_with(&here.join("arm/arm.xacro"), ReadOptions::default()).unwrap_err().to_string();
    for said in ["the package `tools` is not given", "[package=tools=FOLDER]"] {
        assert!(message.contains(said), "{message}");
    }
    let message = read_with(&here.join("arm/out.xacro"), ReadOptions::default()).unwrap_err().to_string();
    assert!(message.contains("outside the folder of the description"), "{message}");
    // A package in a folder above the file is found by its package.xml. A package that only an element for another program
    // names need not exist.
    put("tools/package.xml", "<package/>");
    assert_eq!(mass(&read_with(&here.join("arm/arm.xacro"), ReadOptions::default()).unwrap()), 7.0);
    let plugin = format!("{HEAD}<gazebo><a b=\"$(find none)/c\"/></gazebo>{}{JOINT}</robot>", links("2"));
    put("arm/plugin.xacro", &plugin);
    assert_eq!(mass(&read_with(&here.join("arm/plugin.xacro"), ReadOptions::default()).unwrap()), 2.0);
    put("arm/plugin.xacro", &plugin.replace("gazebo", "sensor"));
    let message = read_with(&here.join("arm/plugin.xacro"), ReadOptions::default()).unwrap_err().to_string();
    assert!(message.contains("no folder of this name with a package.xml"), "{message}");
    std::fs::remove_dir_all(&here).unwrap();
}

/// If a key occurs twice in a YAML file, PyYAML takes the last value without a message. Here the last value is taken too, and a
/// note reports the key.
#[test]
fn the_last_of_two_keys_counts() {
    let here = std::env::temp_dir().join(format!("rist-xacro-keys-{}", std::process::id()));
    std::fs::create_dir_all(&here).unwrap();
    let text = format!("{HEAD}{}{JOINT}</robot>", links("${load_yaml('m.yaml')['m'] + load_yaml('m.yaml').b.m}"));
    std::fs::write(here.join("arm.xacro"), text).unwrap();
    for (yaml, expected, said) in
        [("m: 1\nb: {m: 9}\nm: 2\n", 11.0, true), ("a: &a {m: 5}\nb: {<<: *a, m: 9}\nm: 2\n", 11.0, false)]
    {
        std::fs::write(here.join("m.yaml"), yaml).unwrap();
        let robot = read_with(&here.join("arm.xacro"), ReadOptions::default()).unwrap();
        assert_eq!(mass(&robot), expected, "{yaml}");
        let notes = robot.notes.iter().filter(|note| note.subject.ends_with("m.yaml")).collect::<Vec<_>>();
        assert_eq!(notes.len(), usize::from(said), "{notes:?}");
        assert!(notes.iter().all(|n| n.text.starts_with("the key `m` stands twice (line 3); the last")), "{notes:?}");
    }
    std::fs::remove_dir_all(&here).unwrap();
}

#[test]
fn what_is_refused_has_its_line() {
    let loops = "<xacro:macro name=\"m\" params=\"\"><xacro:m/></xacro:macro><xacro:m/>";
    let doubling: String =
        (0..60).map(|k| format!("<xacro:property name=\"p{}\" value=\"${{p{k}}}${{p{k}}}\"/>", k + 1)).collect();
    let doubling = format!("<xacro:property name=\"p0\" value=\"xxxxxxxx\"/>{doubling}<link name=\"${{p59}}\"/>");
    let wide = "<xacro:macro name=\"m\" params=\"n\"><xacro:if value=\"${n}\"><xacro:m n=\"${n-1}\"/><xacro:m n=\"${n-1}\"/></xacro:if>\
                </xacro:macro><xacro:m n=\"40\"/>";
    for (body, wanted) in [
        ("<link name=\"$(env HOME)\"/>", "arm.xacro:2: $(env) asks the machine"),
        ("<link name=\"$(eval x == 1)\"/>", "the argument `x` has no value: [arg=x=VALUE]"),
        ("<link name=\"$(eval open)\"/>", "the argument `open` has no value"),
        ("<link name=\"$(find x)\"/>", "the package `x` is not given"),
        ("<link name=\"$(find ../x)\"/>", "the package `../x` is not given"),
        ("<link name=\"$(arg x)\"/>", "the argument `x` has no value: [arg=x=VALUE]"),
        ("<link name=\"${x}\"/>", "`x` is not defined"),
        ("<link name=\"${open('f')}\"/>", "the function `open`"),
        ("<link name=\"${x\"/>", "is not closed"),
        ("<xacro:part/>", "there is no macro `part`"),
        ("<xacro:if value=\"perhaps\"/>", "true or false is expected"),
        ("<xacro:insert_block name=\"b\"/>", "there is no block `b`"),
        ("<xacro:include filename=\"/etc/passwd\"/>", "outside the folder"),
        ("<xacro:include filename=\"none.xacro\"/>", "cannot be read"),
        ("<xacro:macro name=\"m\" params=\"a\"/><xacro:m/>", "called without `a`"),
        ("<xacro:macro name=\"m\" params=\"a\"/><xacro:m b=\"1\"/>", "has no parameter `b`; it has a"),
        ("<xacro:property name=\"a\" value=\"${a}\"/><link name=\"${a}\"/>", "stands for itself"),
        (loops, "macros and includes stand in one another"),
        (doubling.as_str(), "bytes"),
        (wide, "are written out: no robot has so many"),
    ] {
        let message = read(body, &[]).unwrap_err();
        assert!(message.contains(wanted), "{body}: {message}");
    }
    let message = read(&links("1"), &[("x".into(), "1".into())]).unwrap_err();
    assert!(message.contains("the description has no argument `x`; it has none"), "{message}");
    // A value can be given for an argument that the file uses but does not declare, as in the Python program xacro.
    assert_eq!(mass(&read(&links("$(arg x)"), &[("x".into(), "2.5".into())]).unwrap()), 2.5);
}

/// Runs the test script in a Python with xacro, and returns its output. `None` if it fails.
fn python(arguments: &[&str]) -> Option<String> {
    let program = std::env::var("RIST_PYTHON").unwrap_or_else(|_| "python3".into());
    let script = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/expand_xacro.py");
    let output = Command::new(program).arg(script).args(arguments).output().ok()?;
    output.status.success().then(|| String::from_utf8_lossy(&output.stdout).into_owned())
}

/// Our expansion and the expansion by the Python program xacro give robots with equal torques.
#[test]
fn what_is_written_out_is_what_python_writes() {
    let Ok(root) = std::env::var("RIST_XACRO") else { return println!("NOT looked at: RIST_XACRO names no folder") };
    let Some(list) = python(&["list", &root]) else { return println!("NOT looked at: no Python with xacro") };
    let rows: Vec<Vec<&str>> = list.lines().map(|line| line.split('\t').collect()).collect();
    let packages: Vec<(String, PathBuf)> =
        rows.iter().filter(|row| row[0] == "package").map(|row| (row[1].to_string(), row[2].into())).collect();
    let options = ReadOptions { packages: &packages, ..ReadOptions::default() };
    let (mut agree, mut wrong, mut costs) = (0, Vec::new(), Vec::<String>::new());
    for file in rows.iter().filter(|row| row[0] == "file").map(|row| row[1]) {
        let Some(text) = python(&["expand", &root, file]) else { continue };
        let Ok(theirs) = parse_with(&text, Path::new("arm.urdf"), options) else { continue };
        match read_with(Path::new(file), options) {
            Ok(ours) if difference(&ours, &theirs) < 1e-12 => {
                agree += 1;
                let (name, worst) = (file.rsplit('/').next().unwrap_or(file), difference(&ours, &theirs));
                costs.extend(cost::row(name, &ours, worst, &|| read_with(Path::new(file), options), Some(&text)));
            }
            Ok(ours) => wrong.push(format!("{file}: {:.1e}", difference(&ours, &theirs))),
            Err(error) => wrong.push(error.to_string()),
        }
    }
    println!("{}\n{agree} descriptions agree", costs.join("\n"));
    assert!(wrong.is_empty() && agree > 0, "{}", wrong.join("\n"));
}

/// Largest difference of a torque at random states, relative to the largest torque. Infinite if the coordinates differ.
fn difference(ours: &Robot, theirs: &Robot) -> f64 {
    let n = theirs.n_coordinates();
    if ours.n_coordinates() != n
        || ours.coordinates.iter().map(|c| &c.name).ne(theirs.coordinates.iter().map(|c| &c.name))
    {
        return f64::INFINITY;
    }
    let mut random = Random::new(4);
    let mut worst = 0.0_f64;
    for _ in 0..5 {
        let [q, dq, ddq] = [0; 3].map(|_| (0..n).map(|_| random.between(-2.0, 2.0)).collect::<Vec<f64>>());
        let (a, b) = (recursion::torque(ours, &q, &dq, &ddq), recursion::torque(theirs, &q, &dq, &ddq));
        let scale = b.iter().fold(1e-9, |s: f64, x| s.max(x.abs()));
        worst = a.iter().zip(&b).fold(worst, |worst, (a, b)| worst.max((a - b).abs() / scale));
    }
    worst
}
