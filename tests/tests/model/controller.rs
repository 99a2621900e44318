//! Tests of the generated controller: `rist identify` estimates parameters from a log, and `rist generate --functions controller`
//! writes C code with this estimate. The code tracks a simulated motion better than the same PD controller alone.

use std::io::{BufRead as _, BufReader, Write as _};
use std::path::Path;
use std::process::{Child, ChildStdin, ChildStdout, Command, Stdio};

use experiments::motion::reference_motion::Reference;
use experiments::simulate::closed_loop::{Drives, JointPd, Simulation, Steps, Stop};
use experiments::simulate::dynamics::{Dynamics, RegressorDynamics};
use linear_model::friction::law::FrictionLaw;
use tests::joint_log::Machine;
use tests::model_path;
use tests::program::{done, folder, rist, run};

/// Bandwidth of the position loops, rad/s; the damping ratio is 1.
const W: f64 = 10.0;
/// Sample time of the controller, s.
const PERIOD: f64 = 1e-3;
const SECONDS: f64 = 6.0;
/// The controller replaces the sign of a velocity in Coulomb friction by tanh(velocity / width), with this width, rad/s.
const WIDTH: f64 = 0.02;

/// The compiled controller as a running process. It reads a line of numbers and answers with a line of torques.
struct Program {
    child: Child,
    to: ChildStdin,
    from: BufReader<ChildStdout>,
}

impl Program {
    /// Compiles and starts a program that calls the C function `word` with the arguments `call`. `inputs`: names of arguments
    /// that are arrays of n numbers; they are read from each line.
    fn started(here: &Path, robot: &str, n: usize, word: &str, inputs: &[&str], call: &str) -> Program {
        let declared: String = inputs.iter().map(|name| format!("    double {name}[{n}];\n")).collect();
        let read: String = inputs.iter().map(|name| format!("take({name}) && ")).collect();
        let main = format!(
            "#include <stdio.h>\n#include \"{robot}.h\"\n
static int take(double *x) {{ int k; for (k = 0; k < {n}; k++) if (scanf(\"%lf\", &x[k]) != 1) return 0; return 1; }}
int main(void)\n{{\n{declared}    double tau[{n}];\n    int k, is_cut;
    while ({read}1) {{
        is_cut = {robot}_{word}({call}, tau);
        for (k = 0; k < {n}; k++) printf(\"%.17g \", tau[k]);
        printf(\"%d\\n\", is_cut);\n        fflush(stdout);\n    }}\n    return 0;\n}}\n"
        );
        std::fs::write(here.join(format!("{word}.c")), main).unwrap();
        let options =
            format!("-std=c99 -Wall -Wextra -Wconversion -pedantic -Werror -O1 -o {word} {word}.c {robot}.c -lm");
        done(here, "cc", &options);
        let mut child = Command::new(here.join(word)).stdin(Stdio::piped()).stdout(Stdio::piped()).spawn().unwrap();
        let (to, from) = (child.stdin.take().unwrap(), BufReader::new(child.stdout.take().unwrap()));
        Program { child, to, from }
    }

    /// The torques of one line of inputs, and at the end 1 if a torque was limited, otherwise 0.
    fn answer(&mut self, inputs: &[&[f64]]) -> Vec<f64> {
        let line: Vec<String> = inputs.iter().flat_map(|x| x.iter().map(|x| format!("{x:e}"))).collect();
        writeln!(self.to, "{}", line.join(" ")).unwrap();
        let mut said = String::new();
        self.from.read_line(&mut said).unwrap();
        said.split_whitespace().map(|x| x.parse().unwrap()).collect()
    }

    fn end(mut self) {
        drop(self.to);
        assert!(self.child.wait().unwrap().success());
    }
}

fn at(series: &[Vec<f64>], i: usize) -> Vec<f64> {
    series.iter().map(|x| x[i]).collect()
}

/// A smooth motion of sines that starts at rest.
fn motion(n: usize, amplitude: f64) -> Reference {
    let count = (SECONDS / PERIOD) as usize;
    let mut reference = Reference { sample_time: PERIOD, q: vec![], dq: vec![], ddq: vec![], ..Reference::default() };
    for k in 0..n {
        let w = 2.2 + 0.5 * k as f64;
        let of =
            |f: &dyn Fn(f64) -> f64| (0..count).map(|i| amplitude * f(w * i as f64 * PERIOD)).collect::<Vec<f64>>();
        reference.q.push(of(&|x| 1.0 - x.cos()));
        reference.dq.push(of(&|x| w * x.sin()));
        reference.ddq.push(of(&|x| w * w * x.cos()));
    }
    reference
}

fn rms(record: &[Vec<f64>], reference: &[Vec<f64>]) -> f64 {
    let squares = record.iter().zip(reference).flat_map(|(a, b)| a.iter().zip(b).map(|(a, b)| (a - b).powi(2)));
    let (sum, count) = squares.fold((0.0, 0.0), |(sum, count), x| (sum + x, count + 1.0));
    (sum / count).sqrt()
}

/// Simulates a log of the robot with friction, identifies it, and writes the controller with the estimate in C.
fn controller_from_a_log(here: &Path, file: &str, model: &rist::Model, viscous: &[f64], coulomb: &[f64]) {
    let amplitude = vec![0.9; model.robot.n_coordinates()];
    let standard = model.nominal_standard_parameters().unwrap();
    let machine = Machine {
        viscous,
        coulomb,
        noise: 0.02,
        encoder: 1e-5,
        speed: 1e-3,
        ..Machine::exact(&model.robot, &standard, &amplitude)
    };
    machine.log().write_for(model, &here.join("log.csv"));
    let path = model_path(file).display().to_string();
    rist(here, &["identify", &path, "log.csv", "--out", "estimate.yaml"]);
    generate(here, &path, &["--language", "c", "--out", &format!("{}.c", model.robot.name)]);
}

fn generate(here: &Path, path: &str, more: &[&str]) {
    let with = ["generate", path, "--functions", "controller", "--estimate", "estimate.yaml", "--anyway"];
    rist(here, &[&with[..], more].concat()).ended(0);
}

#[test]
fn computed_torque_from_an_estimate_follows_five_times_as_well_as_its_pd() {
    for file in ["planar2r_vertical.yaml", "ur5.yaml", "rx90.yaml", "stanford.yaml", "panda.yaml"] {
        let model = rist::Model::read(model_path(file)).unwrap();
        let (n, here) = (model.robot.n_coordinates(), folder(&format!("controller_{}", model.robot.name)));
        let truth = model.nominal_parameters().unwrap();
        let dynamics = RegressorDynamics::new(model.regressor(), truth);
        // The diagonal of the inertia matrix at the start. Coulomb friction is 20 % of the torque that accelerates the joint by
        // 10 rad/s^2.
        let (mut inertia, mut bias) = (vec![0.0; n * n], vec![0.0; n]);
        dynamics.fill(&vec![0.3; n], &vec![0.0; n], &mut inertia, &mut bias);
        let inertia: Vec<f64> = (0..n).map(|k| inertia[k * n + k]).collect();
        let coulomb: Vec<f64> = inertia.iter().map(|j| 2.0 * j).collect();
        let viscous: Vec<f64> = inertia.clone();
        controller_from_a_log(&here, file, &model, &viscous, &coulomb);

        let reference = motion(n, 0.4);
        let controller = JointPd {
            proportional: inertia.iter().map(|j| j * W * W).collect(),
            derivative: inertia.iter().map(|j| 2.0 * j * W).collect(),
            velocity_pole: 900.0,
        };
        let friction: Vec<FrictionLaw> =
            viscous.iter().zip(&coulomb).map(|(v, s)| FrictionLaw::asymmetric(*v, *s, *v, -s)).collect();
        let limit: Vec<f64> = inertia.iter().zip(&bias).map(|(j, h)| 40.0 * j + 2.0 * h.abs() + 5.0).collect();
        let simulation = Simulation {
            dynamics: &dynamics,
            controller: &controller,
            drives: &Drives { gain: vec![1.0; n], greatest_torque: vec![1e6; n] },
            quantum: &vec![0.0; n],
            friction: &friction,
            steps: Steps::RungeKutta(4),
        };
        let (alone, stop) = simulation.run(&reference, None);
        assert_eq!(stop, Stop::End, "{file}: PD alone");
        let inputs = ["q", "dq", "q_r", "dq_r", "ddq_r", "kp", "kd", "width", "limit"];
        let (x, f) = (format!("{}_x", model.robot.name), format!("{}_f", model.robot.name));
        let call = format!("q, dq, q_r, dq_r, ddq_r, kp, kd, {x}, {f}, width, limit");
        let mut program = Program::started(&here, &model.robot.name, n, "computed_torque", &inputs, &call);
        let (kp, kd, width) = (vec![W * W; n], vec![2.0 * W; n], vec![WIDTH; n]);
        let mut cuts = 0;
        let mut greatest = vec![0.0_f64; n];
        let law = |i: usize, seen: &[f64], velocity: &[f64], tau: &mut [f64]| {
            let [q, dq, ddq] = [&reference.q, &reference.dq, &reference.ddq].map(|x| at(x, i));
            let said = program.answer(&[seen, velocity, &q, &dq, &ddq, &kp, &kd, &width, &limit]);
            tau.copy_from_slice(&said[..n]);
            greatest.iter_mut().zip(&said).for_each(|(most, tau)| *most = most.max(tau.abs()));
            cuts += usize::from(said[n] != 0.0);
        };
        let (record, stop) = simulation.run_under(&reference, Box::new(law));
        program.end();
        assert_eq!(stop, Stop::End, "{file}: computed torque");
        let (pd, computed) = (rms(&alone.q, &reference.q), rms(&record.q, &reference.q));
        println!("{file}: RMS {pd:.2e} rad of the PD alone, {computed:.2e} of computed torque, {cuts} torques cut");
        assert!(computed < 0.2 * pd, "{file}: {computed:e} of computed torque, {pd:e} of the PD alone");
        for (k, (most, limit)) in greatest.iter().zip(&limit).enumerate() {
            assert!(most <= limit, "{file}: {most} at joint {k}, the limit is {limit}");
        }
    }
}

/// Gravity compensation equals the gravity torque. A torque beyond its limit is cut to the limit, and the return value reports
/// this.
#[test]
fn torques_are_cut_at_their_limits() {
    let (file, n) = ("planar2r_vertical.yaml", 2);
    let model = rist::Model::read(model_path(file)).unwrap();
    let here = folder("controller_limits");
    controller_from_a_log(&here, file, &model, &[0.5, 0.2], &[1.0, 0.4]);
    let (x, name) = (format!("{}_x", model.robot.name), &model.robot.name);
    let mut program =
        Program::started(&here, name, n, "gravity_compensation", &["q", "limit"], &format!("q, {x}, limit"));
    let (wide, q) = ([1e6; 2], [0.4, -0.3]);
    let free = program.answer(&[&q, &wide]);
    let truth = model.nominal_parameters().unwrap();
    let (mut a, mut expected) = ([0.0; 4], [0.0; 2]);
    RegressorDynamics::new(model.regressor(), truth).fill(&q, &[0.0; 2], &mut a, &mut expected);
    for (found, expected) in free.iter().zip(expected) {
        // The noise of the log gives an error of about 1 %.
        assert!((found - expected).abs() < 0.02 * expected.abs(), "{found} {expected}");
    }
    assert_eq!(free[2], 0.0);
    let tight = [0.5 * free[0].abs(), 1e6];
    let cut = program.answer(&[&q, &tight]);
    assert_eq!((cut[0], cut[1], cut[2]), (tight[0].copysign(free[0]), free[1], 1.0));
    assert!(program.answer(&[&[f64::NAN, 0.0], &wide])[0].is_nan(), "what is no number stays so");
    program.end();
}

/// The feedforward is the torque of the motion plus friction, with tanh for Coulomb friction. The Rust code, without the standard
/// library, gives the same torques as the C code.
#[test]
fn the_feedforward_in_rust_is_that_in_c() {
    let (file, n) = ("planar2r_vertical.yaml", 2);
    let model = rist::Model::read(model_path(file)).unwrap();
    let here = folder("controller_rust");
    controller_from_a_log(&here, file, &model, &[0.5, 0.2], &[1.0, 0.4]);
    let path = model_path(file).display().to_string();
    generate(&here, &path, &["--out", "arm.rs"]);
    let states: Vec<[f64; 6]> = (0..50)
        .map(|i| std::array::from_fn(|k| ((3 * i + 7 * k) as f64 * 0.37).sin() * [1.0, 0.05, 3.0][k / 2]))
        .collect();
    let main = format!(
        "mod arm;\nfn main() {{\n    for s in {states:?} {{\n        let [a, b, c, d, e, f]: [f64; 6] = s;
        let mut tau = [0.0; 2];
        arm::feedforward(&[a, b], &[c, d], &[e, f], &arm::X, &arm::F, &[{WIDTH}; 2], &[1e6; 2], &mut tau);
        println!(\"{{:e}} {{:e}}\", tau[0], tau[1]);\n    }}\n}}\n"
    );
    std::fs::write(here.join("main.rs"), main).unwrap();
    done(&here, "rustc", "--edition 2024 -A dead_code -D warnings -o main main.rs");
    // The generated file alone must compile without the standard library.
    std::fs::write(here.join("lib.rs"), "#![no_std]\npub mod arm;\n").unwrap();
    done(&here, "rustc", "--edition 2024 --crate-type lib -D warnings lib.rs");

    let said = run(&mut Command::new(here.join("main"))).out;
    let in_rust: Vec<f64> = said.split_whitespace().map(|x| x.parse().unwrap()).collect();
    assert_eq!(in_rust.len(), 100);
    let (x, f, name) = (format!("{}_x", model.robot.name), format!("{}_f", model.robot.name), &model.robot.name);
    let inputs = ["q_r", "dq_r", "ddq_r", "width", "limit"];
    let call = format!("q_r, dq_r, ddq_r, {x}, {f}, width, limit");
    let mut program = Program::started(&here, name, n, "feedforward", &inputs, &call);
    for (s, in_rust) in states.iter().zip(in_rust.chunks(2)) {
        let in_c = program.answer(&[&s[..2], &s[2..4], &s[4..], &[WIDTH; 2], &[1e6; 2]]);
        for (a, b) in in_rust.iter().zip(&in_c) {
            // Torques are tens of N m; tanh of the generated Rust file and of the C library agree within 1e-15.
            assert!((a - b).abs() < 1e-12, "{a} in Rust, {b} in C at {s:?}");
        }
    }
    program.end();
}
