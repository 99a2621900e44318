//! Converts a URDF to YAML, identifies the inertial parameters from a log, and writes them into the URDF.
//!
//! `cargo run --package rist --example convert_and_write_back -- robot.urdf log.csv > identified.urdf`; without a log it only
//! converts.

use std::path::PathBuf;

use rist::{Error, IdentifyRequest, Model, identify, write_urdf};

fn main() -> Result<(), Error> {
    let mut arguments = std::env::args().skip(1);
    let models = concat!(env!("CARGO_MANIFEST_DIR"), "/../../models");
    let urdf = PathBuf::from(arguments.next().unwrap_or(format!("{models}/ur5.urdf")));
    let model = Model::read(&urdf)?;
    let Some(log) = arguments.next().map(PathBuf::from) else {
        let (yaml, notes) = robot::format::write_yaml(&model.robot);
        print!("{yaml}");
        notes.iter().for_each(|note| eprintln!("{}: {}", note.subject, note.text));
        return Ok(());
    };

    let (log, _) = model.open_log(&log, &Default::default())?;
    let found = identify(&model, &[log], &IdentifyRequest { consistent: true, ..IdentifyRequest::default() })?;
    let Some(bodies) = &found.bodies else { return Ok(()) };
    let text = std::fs::read_to_string(&urdf).map_err(Error::new)?;
    let written = write_urdf(&model, &text, bodies, &found.estimate)?;
    print!("{}", written.text);
    written.notes.iter().for_each(|note| eprintln!("note: {note}"));
    Ok(())
}
