//! The sums of logs, `.tri`: read, merged with themselves, solved, compared.
//!
//! Its first line holds a digest that no chance meets, so it is made anew for what stands behind it: that line is the
//! reader's own test. Law: what was read is written as the same bytes, but for the text of its head.
#![no_main]

use fleet::Accumulator;
use fleet::replicate::Digest;
use fleet::{Compared, compare};
use libfuzzer_sys::fuzz_target;
use rist::fit::verdict::estimate_verdict;

/// Sums of another log of the robot.
const REFERENCE: &[u8] = include_bytes!("../corpus/sums/reference.tri");

fuzz_target!(|data: &[u8]| {
    // As it is, and with a first line that is right.
    let _ = Accumulator::from_bytes("sums.tri", data);
    let Some(sums) = with_digest(data).and_then(|bytes| Accumulator::from_bytes("sums.tri", &bytes).ok()) else {
        return;
    };
    let written = sums.to_bytes().expect("sums that were read are written");
    let again = Accumulator::from_bytes("again.tri", &written).expect("sums that were written are read");
    assert!(again.to_bytes().expect("sums are written twice") == written);
    let mut merged = sums.clone();
    let _ = merged.merge(&again);
    for sums in [&sums, &merged] {
        if let Ok(estimate) = sums.solve() {
            let _ = (estimate.to_string(), estimate_verdict(&estimate).to_string());
        }
    }
    let reference = Accumulator::from_bytes("reference.tri", REFERENCE).expect("the reference is read");
    if let Ok(comparison) = compare(("reference", &reference), &[("robot", &sums)], Compared::All, 0.05) {
        let _ = comparison.to_string();
    }
});

/// The same with the lengths and the digest of its parts in the first line; the length of the head is the given one.
fn with_digest(data: &[u8]) -> Option<Vec<u8>> {
    let end = data.iter().position(|&b| b == b'\n')?;
    let line = std::str::from_utf8(&data[..end]).ok()?;
    let rest = &data[end + 1..];
    let head = line.split(' ').nth(2)?.parse::<usize>().ok()?.min(rest.len());
    let (head, body) = rest.split_at(head);
    let digest = Digest::EMPTY.bytes(head).bytes(body).0;
    let version = line.split(' ').nth(1)?;
    let line = format!("rist-tri {version} {} {} {digest:016x}\n", head.len(), body.len());
    Some([line.as_bytes(), head, body].concat())
}
