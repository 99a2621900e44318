//! Fuzz target for the sums of logs in `.tri` files: they are read, merged with themselves, solved and compared.
//!
//! The first line has a checksum of the rest of the file. Random bytes never match it, so the target computes the checksum. (The
//! first line is tested by the reader's own tests.) Property: sums that were read are written, read and written again with the
//! same bytes.
#![no_main]

use fleet::Accumulator;
use fleet::replicate::Digest;
use fleet::{Compared, compare};
use libfuzzer_sys::fuzz_target;
use rist::fit::verdict::estimate_verdict;

/// Sums of another log of the same robot, with which the sums are compared.
const REFERENCE: &[u8] = include_bytes!("../corpus/sums/reference.tri");

fuzz_target!(|data: &[u8]| {
    // The input is read as it is. Then it is read again with a correct first line.
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

/// The input with a first line that has the right lengths and checksums of head and body. The length of the head is taken from
/// the input.
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
