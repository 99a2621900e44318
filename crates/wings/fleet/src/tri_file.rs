//! Writes and reads the file of an accumulator, `.tri`: a first line, a head in YAML, and the triangles (R of QR decompositions).
//!
//! ```text
//! rist-tri 4 2712 18440 8a41f00c5be7d913      version, bytes of the head, bytes of the triangles, digest of both
//! settings: ..                                the head: robot, columns, options, logs, failed logs
//! <triangles>                                 numbers of 8 bytes, little endian: a round trip changes no bit
//! ```
//! The triangles are written replicate by replicate. A replicate begins with the number of its blocks. Each block and joint has:
//! the number of rows, the number of nonzero columns, their indices, and their entries column by column; columns of zeros are not
//! stored. If the options have springs, the change of the squared torque by the springs follows for each block and joint. Then
//! each coordinate has its smallest and largest position, speed, effort, bandwidth f95 (95 % of the energy of the velocity is
//! below it), and the number of samples at rest. The cut-off frequency follows. Then come the cells of states: their size (0, 1,
//! 2); for each coordinate the number of its columns and their indices; the number of cells; and for each cell its coordinate, 0
//! for speed or 1 for position, its index, and the products of its columns and the torque, column by column down to the diagonal.
//! Last are the number of triangles of faults and these triangles; their columns are the parameters and the hypotheses in the
//! head.

use std::io::{Cursor, ErrorKind, Read};
use std::path::Path;

use gate::budget::Budget;
use gate::source::Source;
use linear_model::yaml;
use logs::Error;
use numerics::triangle::Triangle;
use serde::{Deserialize, Serialize};

use crate::accumulator::{Accumulator, FailedLog, MAX_REPLICATES};
use crate::replicate::{Digest, LogAccount, Replicate};
use crate::settings::Settings;
use crate::tri_words::{NumberWriter, WordReader};

/// The first word of a `.tri` file.
const TRI_MAGIC_WORD: &str = "rist-tri";

/// The version of the format that is written and read.
///
/// Sums of older versions cannot be added to sums of this version. Version 1 computes accelerations by second-order differences,
/// and its digests are from other blocks of samples; version 2 has no cells of states; version 3 has no triangles of faults.
const TRI_FORMAT_VERSION: u32 = 4;

/// Largest size of a `.tri` file, bytes.
const MAX_TRI_BYTES: u64 = 1 << 31;

/// Solving the sums needs the memory of this number of matrices that have all columns.
const SOLUTION_MATRICES: usize = 16;

/// Largest length of the first line, bytes.
const MAX_FIRST_LINE_BYTES: usize = 120;

#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct Head {
    settings: Settings,
    replicates: Vec<ReplicateHead>,
    failed: Vec<FailedLog>,
}

#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct ReplicateHead {
    logs: Vec<LogAccount>,
}

impl Accumulator {
    /// Writes the sums as the content of a `.tri` file.
    ///
    /// Fails if the settings cannot be written.
    pub fn to_bytes(&self) -> Result<Vec<u8>, Error> {
        let replicates = self.replicates().iter().map(|r| ReplicateHead { logs: r.logs.clone() }).collect();
        let head = Head { settings: self.settings().clone(), replicates, failed: self.failed().to_vec() };
        let head = serde_yaml::to_string(&head).map_err(|e| Error::new(format!("the sums cannot be written: {e}")))?;
        let mut body = NumberWriter::default();
        for replicate in self.replicates() {
            body.replicate(&replicate.observation, self.settings().options.transmission.springs.is_some());
            body.cells(&replicate.cells);
            body.faults(&replicate.faults);
        }
        Ok(joined(&head, &body.0))
    }

    /// Reads a `.tri` file. If the first word is wrong, nothing more is read, so a device without an end is refused too.
    ///
    /// Fails if the file cannot be read or is larger than 2 GiB, and like [`Accumulator::from_bytes`].
    pub fn read(path: &Path) -> Result<Accumulator, Error> {
        let file = &path.display().to_string();
        let failed = |e: std::io::Error| match e.kind() {
            ErrorKind::NotFound => Error::at(file, 0, "there is no such file"),
            ErrorKind::FileTooLarge => Error::at(file, 0, "the file is larger than 2 GiB: merge fewer logs into one"),
            _ => Error::at(file, 0, format!("cannot be read: {e}")),
        };
        let mut source = Source::open(path).map_err(failed)?;
        let head = source.head(TRI_MAGIC_WORD.len()).map_err(failed)?;
        let bytes = match head == TRI_MAGIC_WORD.as_bytes() {
            true => Source::of(Cursor::new(head).chain(source)).whole(MAX_TRI_BYTES).map_err(failed)?,
            false => head,
        };
        Accumulator::from_bytes(file, &bytes)
    }

    /// Reads the content of a `.tri` file from memory. `file`: its name for messages.
    ///
    /// Fails if the content is not a `.tri` file, is truncated or damaged, or has another version.
    pub fn from_bytes(file: &str, bytes: &[u8]) -> Result<Accumulator, Error> {
        let at = |message: String| Error::at(file, 0, message);
        let (head, body) = divided(bytes).map_err(at)?;
        let head: Head =
            yaml::read(head).map_err(|e| at(format!("its head is not that of sums of this version: {e}")))?;
        let damaged = || at("its triangles are not those of its head: make it again".into());
        head.settings.columns_alone().map_err(|e| at(e.to_string()))?;
        let (n, p, tested) =
            (head.settings.coordinates.len(), head.settings.columns.len(), head.settings.hypotheses.len());
        let has_springs = head.settings.options.transmission.springs.is_some();
        let mut words = WordReader { left: body, budget: Budget::of(bytes.len()), excess: None };
        // Solving the sums needs this memory later, whatever the triangles contain. So it is taken from the budget now.
        words.budget.draw(SOLUTION_MATRICES.saturating_mul(Triangle::bytes(p, p + 1))).map_err(at)?;
        let mut replicates = Vec::new();
        for ReplicateHead { logs } in head.replicates {
            let observation = words.replicate(n, p, has_springs).filter(|_| !logs.is_empty());
            let observation = observation.ok_or_else(|| words.excess.take().map_or_else(damaged, at))?;
            let cells = words.cells(n, p).ok_or_else(|| words.excess.take().map_or_else(damaged, at))?;
            let faults = words.faults(p.saturating_add(tested), tested > 0);
            let faults = faults.ok_or_else(|| words.excess.take().map_or_else(damaged, at))?;
            replicates.push(Replicate { logs, observation, cells, faults });
        }
        if !words.left.is_empty() || replicates.len() > MAX_REPLICATES {
            return Err(damaged());
        }
        Ok(Accumulator::of(head.settings, replicates, head.failed))
    }
}

/// Joins the first line, the head and the triangles to the content of a file.
fn joined(head: &str, body: &[u8]) -> Vec<u8> {
    let digest = Digest::EMPTY.bytes(head.as_bytes()).bytes(body).0;
    let line = format!("{TRI_MAGIC_WORD} {TRI_FORMAT_VERSION} {} {} {digest:016x}\n", head.len(), body.len());
    [line.as_bytes(), head.as_bytes(), body].concat()
}

/// Splits the content of a file into head and triangles, and checks both against the first line.
fn divided(bytes: &[u8]) -> Result<(&str, &[u8]), String> {
    // The first line: magic word, version, bytes of the head, bytes of the triangles, digest.
    let end = bytes.iter().take(MAX_FIRST_LINE_BYTES).position(|&b| b == b'\n');
    let line = end.and_then(|end| std::str::from_utf8(&bytes[..end]).ok()).unwrap_or_default();
    let words: Vec<&str> = line.split(' ').collect();
    if words.first() != Some(&TRI_MAGIC_WORD) {
        let found = if bytes.is_empty() { "it is empty" } else { "its first line does not say so" };
        return Err(format!("no sums of [:accumulate] (.tri): {found}"));
    }
    match words.get(1).and_then(|word| word.parse::<u32>().ok()) {
        Some(TRI_FORMAT_VERSION) => {}
        Some(version) if version > TRI_FORMAT_VERSION => {
            return Err(format!(
                "version {version} of its format, and this program reads up to {TRI_FORMAT_VERSION}: read it with the \
                 rist that wrote it, or a newer one"
            ));
        }
        Some(version) => {
            return Err(format!(
                "version {version} of its format, whose sums do not add to those of version {TRI_FORMAT_VERSION}: \
                 make it again from its logs"
            ));
        }
        None => return Err(format!("its first line, `{line}`, has no version: make it again")),
    }
    let [head, body] = [2, 3].map(|k| words.get(k).and_then(|word| word.parse::<usize>().ok()));
    let (Some(head), Some(body), Some(digest)) = (head, body, words.get(4)) else {
        return Err(format!("its first line, `{line}`, is not whole: make it again"));
    };
    // The lengths are checked before the digest, so that a truncated file is reported as truncated.
    let rest = &bytes[line.len() + 1..];
    let expected = head.saturating_add(body);
    if rest.len() != expected {
        let (found, is) = (rest.len(), if rest.len() < expected { "cut short" } else { "longer than it was" });
        return Err(format!("{is}: {found} bytes behind its first line, and {expected} are expected: make it again"));
    }
    let (head, body) = rest.split_at(head);
    let found = format!("{:016x}", Digest::EMPTY.bytes(head).bytes(body).0);
    if found != **digest {
        return Err("damaged: its digest is not that of its first line; make it again".into());
    }
    let head = std::str::from_utf8(head).map_err(|e| format!("its head is no text: {e}"))?;
    Ok((head, body))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::replicate::{MAX_BLOCKS_PER_LOG, MAX_FAULT_PARTS_PER_LOG};
    use crate::state_cells::StateCells;
    use crate::test_arm::{Pendulum, account, empty};
    use identification::estimate::options::Options;
    use identification::rows::observation::Observation;
    use linear_model::linear_model::Model;

    fn some() -> Accumulator {
        let arm = Pendulum::new();
        let mut options = Options::default();
        // This cut-off frequency needs all digits of a double.
        options.signal.cutoff = Some(10.0 / 3.0);
        let mut all = empty(&options);
        let linear = Model::new(&arm, &options.friction, &[]);
        let account = account("day 1: morning.csv".into(), 0xff, 100);
        let account = LogAccount { kept: 99, samples: 98, duration: 0.1 + 0.2, ..account };
        let mut observation = Observation::of(&linear, &arm.states(100), MAX_BLOCKS_PER_LOG);
        observation.f95 = vec![0.1];
        let mut cells = StateCells::new(&linear);
        cells.add(&linear, &arm.states(100));
        let wide = linear.p() + all.settings().hypotheses.len();
        let faults =
            (0..MAX_FAULT_PARTS_PER_LOG).map(|k| Triangle::of_numbers(wide, &[0, wide], 5, &[1.0, 0.5, k as f64]));
        let faults = faults.map(Option::unwrap).collect();
        all.add(Replicate { logs: vec![account], observation, cells, faults }).unwrap();
        all.fail("b.csv".into(), "b.csv: cut short\n\tin its middle".into());
        all
    }

    #[test]
    fn a_round_trip_changes_no_bit() {
        let all = some();
        let bytes = all.to_bytes().unwrap();
        let again = Accumulator::from_bytes("a.tri", &bytes).unwrap();
        assert_eq!(again.settings(), all.settings());
        assert_eq!(again.replicates()[0].observation.parts, all.replicates()[0].observation.parts);
        assert!(!all.replicates()[0].cells.products.is_empty());
        assert_eq!(again.replicates()[0].cells, all.replicates()[0].cells);
        assert_eq!(again.replicates()[0].faults, all.replicates()[0].faults);
        assert_eq!((again.logs(), again.failed()), (all.logs(), all.failed()));
        assert_eq!(again.to_bytes().unwrap(), bytes);
    }

    #[test]
    fn what_is_cut_short_or_damaged_is_refused() {
        let bytes = some().to_bytes().unwrap();
        let refused = |bytes: &[u8]| Accumulator::from_bytes("a.tri", bytes).err().map(|e| e.to_string());
        for end in (0..bytes.len()).step_by(7) {
            assert!(refused(&bytes[..end]).is_some_and(|e| e.starts_with("a.tri: ")), "{end}");
        }
        for k in (0..bytes.len()).step_by(11) {
            let mut other = bytes.clone();
            other[k] ^= 0x10;
            assert!(refused(&other).is_some(), "{k}");
        }
        assert!(refused(&bytes[..bytes.len() - 1]).unwrap().contains("cut short"));
        assert!(refused(&[&bytes[..], &b"x"[..]].concat()).unwrap().contains("longer than it was"));
        assert!(refused(b"t,q1\n0,1\n").unwrap().contains("no sums of [:accumulate]"));
        assert!(refused(b"").unwrap().contains("it is empty"));
    }

    #[test]
    fn a_head_is_believed_only_so_far() {
        let nested = joined(&"[".repeat(100_000), &[]);
        assert!(Accumulator::from_bytes("a.tri", &nested).unwrap_err().to_string().contains("its head is not that"));
        let mut words = WordReader { left: &[0; 1000], budget: Budget::of(1000), excess: None };
        assert!(words.triangle(1 << 26).is_none() && words.triangle(usize::MAX - 1).is_none());
    }

    #[test]
    fn another_version_is_named() {
        let mut bytes = some().to_bytes().unwrap();
        let versions = [
            (b'5', "version 5 of its format, and this program reads up to 4"),
            (b'3', "version 3 of its format, whose sums do not add to those of version 4: make it again"),
        ];
        for (version, message) in versions {
            bytes[TRI_MAGIC_WORD.len() + 1] = version;
            let refused = Accumulator::from_bytes("a.tri", &bytes).unwrap_err().to_string();
            assert!(refused.contains(message), "{refused}");
        }
    }

    #[test]
    fn sums_of_forty_joints_fit_their_budget() {
        let (p, joints) = (384, 40);
        let of_joint = |k: usize| {
            let (first, count) = (96 * (k / 10), 11 + 7 * (k % 10));
            let live: Vec<usize> = (first..first + count).chain([p]).collect();
            let numbers: Vec<f64> = (0..live.len() * (live.len() + 1) / 2).map(|i| 1.0 + i as f64).collect();
            Triangle::of_numbers(p, &live, 100, &numbers).unwrap()
        };
        let part: Vec<Triangle> = (0..joints).map(of_joint).collect();
        let mut body = NumberWriter::default();
        (0..MAX_BLOCKS_PER_LOG).for_each(|_| part.iter().for_each(|triangle| body.triangle(triangle)));
        let mut words = WordReader { left: &body.0, budget: Budget::of(body.0.len()), excess: None };
        for k in 0..MAX_BLOCKS_PER_LOG * joints {
            assert_eq!(words.triangle(p).as_ref(), Some(&part[k % joints]), "{:?}", words.excess);
        }
        assert!(words.left.is_empty());
    }
}
