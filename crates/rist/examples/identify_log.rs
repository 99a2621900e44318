//! Identifies the inertial parameters and the friction of a robot from a log.
//!
//! `cargo run --package rist --example identify_log -- robot.urdf log.csv`; without arguments the example writes its own log:
//! of a pendulum of 1 kg at 0.5 m without friction.

use std::path::PathBuf;

use rist::{Error, IdentifyRequest, Model, identify};

fn main() -> Result<(), Error> {
    let mut arguments = std::env::args().skip(1).map(PathBuf::from);
    let (description, log) = match (arguments.next(), arguments.next()) {
        (Some(description), Some(log)) => (description, log),
        _ => pendulum().map_err(Error::new)?,
    };
    let model = Model::read(&description)?;
    let (log, columns) = model.open_log(&log, &Default::default())?;
    print!("{columns}{}", log.report());
    let found = identify(&model, &[log], &IdentifyRequest::default())?;
    println!("{}", found.estimate);
    Ok(())
}

/// Writes a description and a log of a pendulum into the folder for temporary files: 20 s at 200 Hz, q = 1.2 sin(1.7 t) rad.
fn pendulum() -> std::io::Result<(PathBuf, PathBuf)> {
    let folder = std::env::temp_dir().join(format!("rist-example-{}", std::process::id()));
    std::fs::create_dir_all(&folder)?;
    let (description, log) = (folder.join("pendulum.yaml"), folder.join("log.csv"));
    std::fs::write(
        &description,
        "convention: khalil-kleinfinger\nname: pendulum\ngravity: [0, -9.81, 0]\n\
         links:\n  - {link: 1, antecedent: base, joint: revolute, theta: q1}\n",
    )?;
    let mut text = "t,q1,dq1,tau1\n".to_string();
    for k in 0..4000 {
        let t = f64::from(k) / 200.0;
        let (a, w) = (1.2, 1.7);
        let (q, dq, ddq) = (a * (w * t).sin(), a * w * (w * t).cos(), -a * w * w * (w * t).sin());
        // Torque of the pendulum, N m: (ZZ + IA) ddq + g MX cos q, with ZZ = 1 kg (0.5 m)^2, IA = 0 and MX = 1 kg 0.5 m.
        let tau = 0.25 * ddq + 9.81 * 0.5 * q.cos();
        text += &format!("{t},{q},{dq},{tau}\n");
    }
    std::fs::write(&log, text)?;
    Ok((description, log))
}
