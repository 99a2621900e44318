//! Data for tests of this crate: a page with every section. Its synthetic log has a gap, and rows that the fit does not use.

use claims::{Claim, Figure, Outcome, Remedy, Subject, Topic, Trial};
use identification::estimate::artefact::Estimate;
use identification::estimate::identified::{Deviations, Identified};
use identification::estimate::residuals::JointResidual;
use identification::estimate::verdict::{Trust, UseVerdict, Verdict};
use identification::plot_data::envelope::Envelope;
use identification::plot_data::information::{Information, PARTS_OF_TIME};
use identification::plot_data::{JointPlotData, LogSpan, PlotData};
use linear_model::unit::Unit;

/// A joint name that contains markup, ends a script element, and reverses the writing direction.
pub(crate) const HOSTILE: &str = "q</script><b>\u{202e}";

/// A robot with two revolute joints.
pub(crate) const ARM: &str = "convention: khalil-kleinfinger\nname: arm\nlinks:\n  - {link: 1, antecedent: base, theta: q1}\n  - \
                              {link: 2, antecedent: 1, alpha: pi/2, d: 0.5, theta: q2}\n";

/// Plot data of two joints over four seconds. One of these seconds is a gap.
pub(crate) fn plot_data() -> PlotData {
    let joint = |k: usize| {
        let lines = || Envelope::of_spans(4000);
        let mut joint = JointPlotData {
            coordinate: if k == 0 { HOSTILE.into() } else { "q2".into() },
            unit: "N m".into(),
            measured: lines(),
            predicted: lines(),
            nominal: Some(lines()),
            residual: lines(),
            course: lines(),
            torque_rms: 10.0,
            residual_rms: 0.3,
            ..JointPlotData::default()
        };
        for i in 0..3000 {
            let t = 1e-3 * f64::from(i) + if i < 1500 { 0.0 } else { 1.0 };
            // The residual is a fast sine. The fit does not use one block of the residual.
            let noise = 0.4 * (917.0 * t).sin();
            if i == 1500 {
                [&mut joint.measured, &mut joint.predicted, &mut joint.residual, &mut joint.course]
                    .into_iter()
                    .chain(&mut joint.nominal)
                    .for_each(Envelope::interrupt);
            }
            let torque = 20.0 * (3.0 * t + k as f64).sin();
            joint.measured.push(t, torque + noise);
            joint.predicted.push(t, torque);
            joint.residual.push(t, if (200..400).contains(&i) { f64::NAN } else { noise });
            joint.course.push(t, (3.0 * t).sin());
            joint.nominal.iter_mut().for_each(|line| line.push(t, 0.8 * torque));
        }
        joint
    };
    // Leverages of two joints in two parameters, normalised to a sum of 1 per parameter.
    let shares = (0..2 * 2 * PARTS_OF_TIME).map(|i| 1.0 + (i % 7) as f64).collect::<Vec<_>>();
    let whole = |k: usize| shares[k * 2 * PARTS_OF_TIME..(k + 1) * 2 * PARTS_OF_TIME].iter().sum::<f64>();
    let shares = shares.iter().enumerate().map(|(i, x)| x / whole(i / (2 * PARTS_OF_TIME))).collect();
    PlotData {
        logs: vec![LogSpan { name: "a".into(), from: 0.0, to: 3.999 }],
        joints: (0..2).map(joint).collect(),
        samples: 3000,
        information: Information {
            parameters: ["ZZR1", "FV1"].map(|name| name.parse().unwrap()).into(),
            correlation: vec![-0.62],
            shares,
            duration: 4.0,
            every: 3,
        },
    }
}

/// An estimate from the logs of [`plot_data`].
pub(crate) fn estimate() -> Estimate {
    let joint = |name: &str| JointResidual {
        coordinate: name.into(),
        rms: 0.3,
        unit: Unit::TORQUE,
        relative: 0.015,
        rows: 3000,
        held_out: Some(0.017),
        f95: None,
        memory: None,
    };
    Estimate {
        model: HOSTILE.into(),
        parameters: vec![
            Identified::new("ZZR1".parse().unwrap(), Unit::INERTIA, 0.3, Deviations::white(0.01)),
            Identified::new("FV1".parse().unwrap(), Unit::VISCOUS, 0.2, Deviations::white(0.01)),
        ],
        joints: vec![joint(HOSTILE), joint("q2")],
        options: Some(identification::estimate::options::Options::default()),
        ..Estimate::default()
    }
}

/// A verdict on [`estimate`]: one joint agrees, one is undecided, and one claim is contradicted.
pub(crate) fn verdict() -> Verdict {
    const ZERO: Topic = Topic("zero");
    const SIGN: Topic = Topic("sign");
    // The claims give each kind of cell in the table of grades once.
    let claims = vec![
        Claim::new(
            Subject::of(SIGN, ["q2"]),
            Outcome::Contradicted {
                fault: "torque counts the other way".into(),
                remedy: Remedy::new("identify", "turn it round"),
                trial: Trial::NotTried { why: "no time".into() },
            },
        ),
        Claim::new(
            Subject::of(ZERO, [HOSTILE]),
            Outcome::CannotTell { why: "it moves little".into(), would_tell: "a motion".into() },
        ),
        Claim::new(Subject::of(ZERO, ["q2"]), Outcome::Agrees { smallest: Figure::new(0.4, "deg") }),
    ];
    let gravity = UseVerdict {
        name: "gravity compensation".into(),
        trust: Trust::No,
        error: Some(0.0123),
        worst_joint: Some(("q2".into(), 0.034)),
    };
    Verdict {
        trust: Trust::No,
        found: "something".into(),
        reasons: vec!["it is so".into()],
        next: "mend it".into(),
        uses: vec![gravity],
        claims,
    }
}
