//! Changes files of each kind that the program reads at random, and runs the program on them. Here only some changes are tested;
//! `cargo xtask fuzz` tests many.
use tests::mutation::{hunt, seeds};
use tests::program::{folder, program};
use tests::random::Random;

#[test]
fn a_changed_file_is_read_or_refused() {
    let here = folder("mutations");
    let seeds = seeds(program(), &here);
    assert!(seeds.len() > 30);
    let (count, found) = hunt(program(), &here, &seeds, &mut Random(1), |count| count == 300);
    let told: Vec<String> = found.iter().map(|f| format!("{} {:?}: {}", f.name, f.command, f.outcome)).collect();
    assert!(count == 300 && told.is_empty(), "{told:#?}");
}
