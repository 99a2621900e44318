//! The load after a force-torque sensor (on the side away from the robot), and whether it can be used. No model of the robot or
//! its drives is needed. A wrench is a force and a torque. In: a log of wrenches and poses of the sensor. Out: the ten inertial
//! parameters of the load, with a verdict.

use std::fmt;

use crate::wrench_load::{WrenchLoad, wrench_load};
use crate::wrench_verdict::WrenchVerdict;
use crate::wrenches::Wrenches;
use identification::estimate::verdict::{Trust, claim_line};
use serde_json::{Value, json};

use rist::Error;
use rist::fit::load::{Load, LoadScale};

/// The load from a log of a force-torque sensor, with its verdict.
pub struct WrenchEstimate {
    /// The load about the origin of the sensor frame, in the axes of this frame.
    pub load: Load,
    /// Whether the load can be used, with reasons.
    pub verdict: WrenchVerdict,
    found: WrenchLoad,
    rows: usize,
    left_out: usize,
    is_static: bool,
}

/// Identifies the load after a force-torque sensor. `link`: name of the link whose frame is the sensor frame; the name is
/// written to the file of `[load]`.
///
/// Fails if the log is too short to determine a load.
pub fn identify_wrench(log: &Wrenches, link: &str) -> Result<WrenchEstimate, Error> {
    let found = wrench_load(log)?;
    let load = Load {
        link: link.into(),
        is_whole: found.determined.iter().all(|d| *d),
        parameters: found.parameters,
        sigma: found.sigma,
        determined: found.determined,
        scale: LoadScale::Sensor,
        in_file_frame: true,
    };
    let (rows, left_out, is_static) = (log.force.len(), log.left_out, log.t.is_empty());
    let verdict = WrenchVerdict::of(log, &found);
    Ok(WrenchEstimate { load, verdict, found, rows, left_out, is_static })
}

/// Names and units of the offsets of the six signals.
const OFFSETS: [(&str, &str); 6] = [
    ("force x", "N"),
    ("force y", "N"),
    ("force z", "N"),
    ("torque x", "N m"),
    ("torque y", "N m"),
    ("torque z", "N m"),
];

impl WrenchEstimate {
    /// The estimate as JSON.
    pub fn to_json(&self) -> Value {
        let entry = |k: usize| (self.load.parameters[k], self.load.sigma[k]);
        let parameters: Vec<Value> = (robot::Inertial::BODY.into_iter().enumerate())
            .map(|(k, inertial)| {
                let (value, sigma) = entry(k);
                let value = self.load.determined[k].then(|| json!({"value": value, "sigma": sigma}));
                json!({"name": inertial.letters(), "estimate": value})
            })
            .collect();
        let offsets: Vec<Value> = OFFSETS
            .into_iter()
            .zip(self.found.offsets)
            .map(|((name, unit), offset)| json!({"name": name, "unit": unit, "estimate": offset.map(|(x, s)| json!({"value": x, "sigma": s}))}))
            .collect();
        let WrenchVerdict { trust, claims, reasons, next } = &self.verdict;
        let body = self.load.body().filter(|_| *trust != Trust::No);
        let body = body.map(|b| json!({"mass": b.mass, "centre_of_mass": b.centre, "inertia": b.inertia}));
        json!({
            "parameters": parameters,
            "body": body,
            "offsets": offsets,
            "is_reaction": self.found.is_reaction,
            "residuals": {"force": self.found.residuals[0], "torque": self.found.residuals[1]},
            "rows": self.rows,
            "left_out": self.left_out,
            "verdict": {"trust": trust.word(), "reasons": reasons, "next": next, "claims": claims},
        })
    }
}

impl fmt::Display for WrenchEstimate {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let (count, [force, torque]) = (self.found.windows, self.found.residuals);
        match self.is_static {
            true => writeln!(f, "{} postures at rest, since the table has no clock", self.rows)?,
            false => writeln!(f, "{} rows in {count} windows", self.rows)?,
        }
        // Writes the number of omitted rows and the sign convention.
        if self.left_out > 0 {
            writeln!(f, "{} rows are left out: without a number, or with a clock that does not go on", self.left_out)?;
        }
        if self.found.is_reaction {
            writeln!(f, "the sensor gives what the load does to it: the signs are turned")?;
        }
        writeln!(f, "residual: {force:.4} N and {torque:.5} N m rms per sample")?;
        // Offsets are identifiable only if the orientation of the sensor changes in the log.
        for ((name, unit), offset) in OFFSETS.into_iter().zip(self.found.offsets) {
            match offset {
                Some((x, sigma)) => writeln!(f, "offset of {name:<8} {x:>10.4} +- {sigma:.4} {unit}")?,
                None => writeln!(f, "offset of {name:<8} not identifiable: the sensor keeps its attitude")?,
            }
        }
        writeln!(f, "\nload on the sensor, in and about its frame:")?;
        let verdict = &self.verdict;
        self.load.tell(f, verdict.trust != Trust::No)?;
        if self.is_static {
            writeln!(f, "at rest no inertia is identifiable: record a motion, with a clock and positions")?;
        }
        writeln!(f)?;
        // Writes the claims and the verdict.
        let lines = verdict.claims.iter().filter(|claim| !claim.is_contradicted()).map(claim_line);
        lines.into_iter().try_for_each(|line| writeln!(f, "{line}"))?;
        writeln!(f, "trust: {}", verdict.trust.word())?;
        verdict.reasons.iter().try_for_each(|reason| writeln!(f, "  - {reason}"))?;
        verdict.next.iter().try_for_each(|next| writeln!(f, "next: {next}"))
    }
}
