//! `rist identify --method ls`: samples of logs -> parameters.

use identification::estimate::residuals::Residuals;
use identification::model::parameter::FrictionParameter;
use identification::model::parameter::ParameterId;
use std::fmt::Write as _;
use std::path::Path;

use identification::estimate::artefact::Estimate;
use identification::estimate::consistent::{bodies, identify_consistent};
use identification::estimate::drive_gains::estimate_drive_gains;
use identification::estimate::held_out::{cross_validate, validate};
use identification::estimate::identify::Fit;
use identification::estimate::options::Options;
use identification::estimate::selection::{estimate_delay, friction_candidates, select_friction};
use identification::estimators::drive_gains::likelihood::{DriveGains, Gain};
use identification::model::friction::terms::FrictionTerm;
use identification::model::linear_model::Model;
use identification::model::regressor::Regressor;
use identification::rows::observation::Observation;
use identification::signals::records::SourceRecords;
use identification::write::write_back::{JointDynamics, mjcf_joints, write_back};
use logs::{Effort, LogSource};
use modeling::BaseParameters;
use robot::{Coordinate, Inertial, LinkId, Robot, RotorInertia};

use crate::failure::{Failure, print, write_file};
use crate::identify::{Arguments, Delay, Friction};
use crate::identify_load::load;
use crate::model::{body_links, references, standard_map};
use crate::spectrum::{Subject, read_text};

pub fn run(arguments: &Arguments) -> Result<(), Failure> {
    let subject = Subject::read(&arguments.model)?;
    let regressor = subject.regressor.as_ref();
    let mut options = options(arguments, &subject)?;
    let mut text = String::new();
    let mut columns_before = String::new();
    let mut open = |paths: &[std::path::PathBuf], text: &mut String| -> Result<Vec<LogSource>, Failure> {
        let mut logs = Vec::new();
        for path in paths {
            let (log, columns) = LogSource::open(path, regressor.coordinates(), &options.columns)?;
            let columns = columns.to_string();
            let _ = writeln!(text, "{}", path.display());
            if columns != columns_before {
                text.push_str(&columns);
                columns_before = columns;
            }
            let _ = writeln!(text, "{}", log.report());
            logs.push(log);
        }
        Ok(logs)
    };
    check_paths(arguments)?;
    let logs = open(&arguments.logs, &mut text)?;
    let (loaded, others) = (open(&arguments.loaded, &mut text)?, open(&arguments.validate, &mut text)?);

    let gains = drive_gains(arguments, &subject, &logs, &mut options)?;
    if arguments.delay == Some(Delay::Auto) {
        let delay = estimate_delay(regressor, &logs, &options)?;
        let (seconds, with, without) = (delay.seconds, delay.residual, delay.residual_without);
        let _ = writeln!(text, "delay {seconds:.4} s: residual {with:.4}, without it {without:.4}");
        if delay.at_the_end {
            return Err(Failure::verdict(format_args!(
                "{text}the residual still falls there, at the end of the search: no delay explains these logs; look at \
                 units, signs and drive gains, or give the delay"
            )));
        }
        options.signal.delay = seconds;
    }
    let records = SourceRecords::new(regressor, &logs, &options.preparation())?;
    if arguments.friction.as_ref().is_some_and(|words| words.contains(&Friction::Auto)) {
        let couplings = options.transmission.coupled();
        let seen = Observation::of_records(&Model::new(regressor, &[], &couplings), &records, None)?;
        let candidates = friction_candidates(seen.speed.iter().copied().fold(0.0, f64::max));
        let selection = select_friction(regressor, &records, &options, &candidates)?;
        let _ = writeln!(text, "friction, by blocked cross-validation (* chosen):\n{selection}");
        options.friction = selection.candidates[selection.chosen].terms.clone();
    }
    let names = logs.iter().map(LogSource::name).collect();
    let fit = Fit::of_records(regressor, &records, names, &options)?;

    let parameters = &subject.derived.parameters;
    let map = standard_map(&subject.robot, parameters);
    let load = if loaded.is_empty() {
        None
    } else {
        Some(load(arguments.loaded_link.as_deref(), &subject, &fit, &loaded, &options)?)
    };
    let observation = fit.observation.clone();
    let (mut written, mut heavy) = (Vec::new(), Vec::new());
    let writes = arguments.write_urdf.is_some() || arguments.write_mjcf.is_some();
    let mut estimate = if arguments.consistent || writes {
        let known = references(&subject.robot, parameters);
        let fit = identify_consistent(regressor, &map, &known, fit, &options, &Default::default())?;
        let found: Vec<(&str, [f64; 10])> = bodies(&map, &fit.consistent.phi).collect();
        heavy = found.iter().zip(&known).filter_map(|(body, known)| outgrown(body, known.as_ref()?)).collect();
        let dynamics = joint_dynamics(&subject.robot, &fit.estimate);
        if writes && dynamics.is_none() {
            eprintln!("note: no friction is written: viscous and coulomb, or asymmetric, are not both in the model");
        }
        let dynamics = dynamics.unwrap_or_default();
        let armature = armatures(&subject.robot, parameters, &fit.consistent.phi);
        if let Some(out) = &arguments.write_mjcf {
            if dynamics.is_empty() {
                return Err(Failure::new("--write-mjcf needs --friction viscous,coulomb or asymmetric"));
            }
            written.push((out, mjcf_joints(&dynamics, &armature)));
        }
        if let Some(out) = &arguments.write_urdf {
            let ids = body_links(parameters);
            let bodies: Vec<_> = ids.into_iter().zip(found.iter().map(|b| b.1)).collect();
            note_what_a_urdf_cannot_hold(&subject.robot.coordinates, &armature, &fit.estimate);
            written.push((out, urdf(&arguments.model.model, &subject.robot, &bodies, &dynamics)?));
        }
        fit.estimate
    } else {
        fit.estimate
    };
    estimate.fingerprint = subject.reference.fingerprint.clone();
    if let Some((remark, found)) = gains {
        estimate.remarks.push(remark);
        widen(&mut estimate, &found);
    }
    estimate.remarks.extend(rotors(&subject, &records, &observation, &options)?);
    estimate.remarks.extend(heavy);
    let _ = write!(text, "{estimate}");
    text.push_str(&load.unwrap_or_default());
    for (log, validation) in predictions(regressor, &estimate, &others)? {
        let _ = write!(text, "\n{log}, not fitted:\n{validation}");
    }
    print(&text)?;
    for (out, text) in written {
        write_file(out, &text)?;
    }
    match &arguments.out {
        Some(out) => write_file(out, &estimate.to_yaml()?),
        None => Ok(()),
    }
}

/// Refuses outputs over inputs, and a log in two roles.
fn check_paths(arguments: &Arguments) -> Result<(), Failure> {
    let same = |a: &Path, b: &Path| match (a.canonicalize(), b.canonicalize()) {
        (Ok(a), Ok(b)) => a == b,
        _ => false,
    };
    let inputs: Vec<&Path> =
        [&arguments.logs, &arguments.validate, &arguments.loaded].into_iter().flatten().map(AsRef::as_ref).collect();
    for (i, log) in inputs.iter().enumerate() {
        if inputs[..i].iter().any(|other| same(log, other)) {
            return Err(Failure::new(format_args!("{}: given twice; a log counts once, in one role", log.display())));
        }
    }
    let outputs = [&arguments.out, &arguments.write_urdf, &arguments.write_mjcf];
    for out in outputs.into_iter().flatten() {
        if inputs.iter().chain([&arguments.model.model.as_path()]).any(|input| same(out, input)) {
            return Err(Failure::new(format_args!("{}: an input, which is not written over", out.display())));
        }
    }
    Ok(())
}

fn options(arguments: &Arguments, subject: &Subject) -> Result<Options, Failure> {
    let mut options = match &arguments.options {
        Some(path) => Options::read(path)?,
        None => Options::default(),
    };
    options.model = subject.robot.name.clone();
    let signal = &mut options.signal;
    signal.cutoff = arguments.cutoff.or(signal.cutoff);
    signal.order = arguments.order.unwrap_or(signal.order);
    signal.decimate = arguments.decimate.or(signal.decimate);
    if let Some(Delay::Seconds(delay)) = arguments.delay {
        signal.delay = delay;
    }
    options.weights = arguments.weights.unwrap_or(options.weights);
    if let Some(words) = &arguments.friction {
        if words.len() > 1 && words.iter().any(|w| matches!(w, Friction::Auto | Friction::None)) {
            return Err(Failure::new("--friction: auto and none stand alone"));
        }
        let term = |word: &Friction| match word {
            Friction::Term(term) => Some(*term),
            Friction::Auto | Friction::None => None,
        };
        if let Some(i) = (1..words.len()).find(|&i| words[..i].contains(&words[i])) {
            return Err(Failure::new(format_args!("--friction: word {} stands there twice", i + 1)));
        }
        if words.as_slice() != [Friction::Auto] {
            options.friction = words.iter().filter_map(term).collect::<Vec<FrictionTerm>>();
        }
    }
    Ok(options)
}

/// Puts the gains of the command line, else of the file, into the options, and estimates those that are missing; a
/// remark on what was estimated.
fn drive_gains(
    arguments: &Arguments,
    subject: &Subject,
    logs: &[LogSource],
    options: &mut Options,
) -> Result<Option<(String, DriveGains)>, Failure> {
    let currents = logs.iter().any(|log| log.effort_is() == Effort::Current);
    let given = &arguments.gain;
    if !currents {
        return match given.first() {
            Some(gain) => Err(Failure::new(format_args!("--gain {gain}: the logs hold torques, not currents"))),
            None => Ok(None),
        };
    }
    if given.is_empty() && options.transmission.drive_gains.is_some() {
        return Ok(None);
    }
    let coordinates = subject.regressor.coordinates();
    let of_file = subject.drive_gains();
    let mut known: Vec<Gain> = of_file.iter().map(|g| g.map_or(Gain::Free, Gain::Known)).collect();
    for text in given {
        let (gain, deviation) = text.split_once("+-").map_or((text.as_str(), None), |(g, d)| (g, Some(d)));
        let (k, gain) = subject.gain_of(gain)?;
        known[k] = match deviation.map(str::parse::<f64>) {
            None => Gain::Known(gain),
            Some(Ok(deviation)) if deviation > 0.0 && deviation.is_finite() => Gain::Expected(gain, deviation),
            Some(_) => return Err(Failure::new(format_args!("`{text}`: a positive deviation is expected behind +-"))),
        };
    }
    let all: Option<Vec<f64>> = known.iter().map(|g| if let Gain::Known(g) = g { Some(*g) } else { None }).collect();
    if all.is_some() {
        options.transmission.drive_gains = all;
        return Ok(None);
    }
    if known.iter().all(|g| *g == Gain::Free) {
        return Err(Failure::new(format_args!(
            "the logs hold motor currents: give the torque per unit of current of every drive, or of one at least (the \
             others are then estimated): --gain {}=11.5",
            coordinates.first().map_or("q1", String::as_str)
        )));
    }
    let found = estimate_drive_gains(subject.regressor.as_ref(), logs, options, &known)?;
    let open = |k: &usize| {
        !found.gain_determined[*k] || found.gain[*k] <= 0.0 || 2.0 * found.gain_deviation[*k] >= found.gain[*k]
    };
    let open: Vec<String> = (0..coordinates.len()).filter(open).map(|k| coordinates[k].clone()).collect();
    if !open.is_empty() {
        return Err(Failure::verdict(format_args!(
            "the logs do not tell the drive gains of {} (zero is within two sigma): give them, or what is expected of \
             them with its deviation, as --gain {}=11+-2",
            open.join(", "),
            open[0]
        )));
    }
    if found.steps.is_none() {
        return Err(Failure::verdict(
            "the drive gains did not converge: give more of them, or what is expected of them",
        ));
    }
    let mut text = "drive gains, N m/A:".to_string();
    for (((coordinate, gain), sigma), known) in
        coordinates.iter().zip(&found.gain).zip(&found.gain_deviation).zip(&known)
    {
        let _ = match known {
            Gain::Known(_) => write!(text, " {coordinate} {gain:.4} (given)"),
            Gain::Expected(..) | Gain::Free => write!(text, " {coordinate} {gain:.4} +- {sigma:.4}"),
        };
    }
    text.push_str("; everything stands on those that were given");
    options.transmission.drive_gains = Some(found.gain.clone());
    Ok(Some((text, found)))
}

/// Deviations with the uncertainty of the gains in them: parameters follow from the gains.
fn widen(estimate: &mut Estimate, gains: &DriveGains) {
    // Another friction chosen since has other columns: it keeps its own deviations.
    if gains.deviation.len() != estimate.parameters.len() {
        return;
    }
    for (parameter, &deviation) in estimate.parameters.iter_mut().zip(&gains.deviation) {
        *parameter = parameter.clone().widened(deviation);
    }
}

/// A body this many times as heavy as its description, or as light, is worth a sentence.
const OUTGROWN: f64 = 3.0;

/// A sentence on a body whose mass has little to do with that of the description.
fn outgrown((name, body): &(&str, [f64; 10]), known: &[f64; 10]) -> Option<String> {
    let (mass, given) = (body[9], known[9]);
    let ratio = mass / given;
    (given > 0.0 && !(1.0 / OUTGROWN..OUTGROWN).contains(&ratio)).then(|| {
        format!(
            "{name} comes out at {mass:.3} kg, {ratio:.1} times the {given:.3} kg of the description: the masses are not \
             in these data, or inertia that no body has (rotors, gears, drive gains) is put into bodies"
        )
    })
}

/// Where the model has no rotor inertias, a sentence when with them the parts left out are predicted better.
fn rotors(
    subject: &Subject,
    records: &SourceRecords,
    observation: &Observation,
    options: &Options,
) -> Result<Option<String>, Failure> {
    let absent = subject.robot.links.iter().all(|link| link.joint.rotor_inertia == RotorInertia::Absent);
    if !absent || options.friction.contains(&FrictionTerm::Rotor) {
        return Ok(None);
    }
    let (regressor, couplings) = (subject.regressor.as_ref(), options.transmission.coupled());
    let total = |friction: &[FrictionTerm], observation: &Observation| {
        cross_validate(&Model::new(regressor, friction, &couplings), observation, options.weights).total
    };
    let mut friction = options.friction.clone();
    friction.push(FrictionTerm::Rotor);
    let wider = Observation::of_records(&Model::new(regressor, &friction, &couplings), records, None)?;
    let (without, with) = (total(&options.friction, observation), total(&friction, &wider));
    // Where nothing is left to explain, a difference is rounding.
    Ok((with < WORTH * without && without > 1e-3).then(|| {
        format!(
            "the model has no rotor inertias; with them (--rotor-inertia actuated) tenths of the record left out are \
             predicted with {with:.4} instead of {without:.4}"
        )
    }))
}

/// Held-out error with rotor inertias over that without, below which they are worth a sentence.
const WORTH: f64 = 0.97;

/// How well logs that were not fitted are predicted, by name.
pub fn predictions(
    regressor: &dyn Regressor,
    estimate: &Estimate,
    logs: &[LogSource],
) -> Result<Vec<(String, Residuals)>, Failure> {
    let Some(options) = &estimate.options else { return Ok(Vec::new()) };
    let couplings = options.transmission.coupled();
    let model = Model::new(regressor, &options.friction, &couplings);
    let x: Vec<f64> = model.parameters.iter().map(|p| estimate.value(&p.id).unwrap_or(0.0)).collect();
    let predict = |log: &LogSource| {
        let records = SourceRecords::new(regressor, std::slice::from_ref(log), &options.preparation())?;
        Ok((log.name(), validate(&model, &x, &records)?))
    };
    logs.iter().map(predict).collect()
}

/// Viscous and Coulomb friction of every joint, asymmetric friction by the mean of its directions; `None` where the
/// model has neither.
fn joint_dynamics(robot: &Robot, estimate: &Estimate) -> Option<Vec<JointDynamics>> {
    use identification::model::parameter::FrictionParameter::*;
    let friction = |coordinate: &Coordinate| {
        let value = |parameter| estimate.value(&ParameterId::friction(parameter, &coordinate.name));
        let mean = |forward, backward, sign: f64| Some(0.5 * (value(forward)? + sign * value(backward)?));
        // Simulators refuse friction that drives.
        let damping = value(Viscous).or_else(|| mean(ViscousForward, ViscousBackward, 1.0))?.max(0.0);
        let friction = value(Coulomb).or_else(|| mean(CoulombForward, CoulombBackward, -1.0))?.max(0.0);
        Some(JointDynamics { joint: coordinate.name.clone(), damping, friction })
    };
    robot.coordinates.iter().map(friction).collect()
}

/// Rotor inertias by coordinate, kg m^2 (kg); zero where the model has none.
fn armatures(robot: &Robot, parameters: &BaseParameters, phi: &[f64]) -> Vec<f64> {
    let of_link = |link: LinkId| {
        let rotor = parameters.standard.iter().position(|s| s.inertial == Inertial::Ia && s.link == link);
        rotor.map_or(0.0, |c| phi[c])
    };
    let joint = |k: usize| robot.joint_of(robot::value::CoordinateId(k));
    (0..robot.n_coordinates()).map(|k| joint(k).map_or(0.0, of_link)).collect()
}

/// The URDF of the model with the identified bodies and joint friction.
fn urdf(
    model: &Path,
    robot: &Robot,
    bodies: &[(LinkId, [f64; 10])],
    dynamics: &[JointDynamics],
) -> Result<String, Failure> {
    let text = read_text(model)?;
    if !text.trim_start().starts_with('<') {
        return Err(Failure::new(format_args!("{}: --write-urdf needs a model that is a URDF", model.display())));
    }
    let written = write_back(&text, &model.display().to_string(), robot, bodies, dynamics)?;
    for note in &written.notes {
        eprintln!("note: {note}");
    }
    Ok(written.text)
}

/// Says what a URDF has no place for.
fn note_what_a_urdf_cannot_hold(coordinates: &[Coordinate], armature: &[f64], estimate: &Estimate) {
    let rotors = coordinates.iter().zip(armature).filter(|(_, a)| **a > 0.0);
    let rotors: Vec<String> = rotors.map(|(c, a)| format!("{} {a:.4}", c.name)).collect();
    if !rotors.is_empty() {
        eprintln!(
            "note: a URDF has no rotor inertia; what the file lacks, kg m^2 (--write-mjcf writes it as armature): {}",
            rotors.join(", ")
        );
    }
    let is_offset = |id: &ParameterId| matches!(id, ParameterId::Friction(FrictionParameter::Offset, _));
    if estimate.parameters.iter().any(|p| is_offset(&p.id)) {
        eprintln!("note: a URDF has no offset of friction: OFF is not in the file");
    }
}
