//! Snapshot test of refused requests: the whole message and the exit code.
//!
//! Each request is a likely mistake of a user. The messages of the libraries contain names of request fields; the program prints
//! these as flags.

use std::fmt::Write as _;

use tests::program::{LIMITED_ARM, folder, rist};
use tests::snapshot::assert_snapshot;

/// Requests that are refused, one per line. They use the files that the commands in `MADE` write.
const REFUSED: &str = "\
plan arm.yaml --rate 1e300
plan arm.yaml --duration 0
plan arm.yaml --experiments 0
plan arm.yaml --nodes 2000000
plan arm.yaml --steps many
plan arm.yaml --criterion best
plan arm.yaml --rate 20000 --duration 3000
excite arm.yaml --rate -1
excite arm.yaml --effort-share 2
excite arm.yaml --harmonics 1000
excite arm.yaml --harmonics 3 --motion spline
excite arm.yaml --spans 10
excite arm.yaml --motion spline --spans 2
excite arm.yaml --frequency 0
excite arm.yaml --frequency 1 --period 1
excite arm.yaml --starts 0
excite arm.yaml --friction load
excite arm.yaml --friction auto
excite arm.yaml --friction sticky
excite arm.yaml --period 0.01
excite arm.yaml --period 5 --rate 1e12
excite arm.yaml --limits limits.yaml
simulate arm.yaml plan.yaml --gain q1=-2 --out more
simulate arm.yaml plan.yaml --gain q9=2 --out more
simulate arm.yaml plan.yaml --validation 2000 --out more
identify arm.yaml logs/v01.csv --gain q1=2
identify arm.yaml logs/v01.csv --plan plan.yaml --ripple 6
identify arm.yaml logs/v01.csv --method rist
identify arm.yaml logs --plan plan.yaml --method rist --cutoff 10 --friction viscous
identify arm.yaml logs --plan plan.yaml --method rist-mh --ripple q2=0
identify arm.yaml logs --plan plan.yaml --method rist-mh --elastic q9
identify arm.yaml logs --plan plan.yaml --method rist-mh --gain q1=2
identify arm.yaml logs --plan plan.yaml --method rist --options options.yaml
identify arm.yaml logs --plan plan.yaml --method iv --delay auto
identify arm.yaml logs --plan plan.yaml --method didim --options options.yaml
identify arm.yaml logs --plan plan.yaml --method iv --consistent
identify arm.yaml logs/v01.csv --method essential --consistent
identify arm.yaml logs/v01.csv --delay soon
identify arm.yaml logs/v01.csv --delay 3
identify arm.yaml logs/v01.csv --decimate 0
identify arm.yaml logs/v01.csv --friction auto,viscous
identify arm.yaml logs/v01.csv --friction viscous,viscous
identify arm.yaml logs/v01.csv --friction stribeck
identify arm.yaml logs/v01.csv --weights heavy
identify arm.yaml logs/v01.csv --validate logs/v01.csv
identify arm.yaml logs/v01.csv --write-urdf arm.urdf
identify arm.yaml logs/v01.csv --write-mjcf arm.xml --friction coulomb
identify arm.yaml logs/v01.csv --loaded logs/v02.csv --loaded-link hand
identify arm.yaml currents/v01.csv
identify arm.yaml currents/v01.csv --gain q1=2+-x
identify arm.yaml currents --plan plan.yaml --method iv
identify arm.yaml currents --plan plan.yaml --method rist-mh
identify arm.yaml currents --plan plan.yaml --method rist-mh --out currents/e01.csv
doctor arm.yaml logs/v01.csv --gain q9=2
accumulate arm.yaml logs/v01.csv --friction auto --out a.tri
accumulate arm.yaml logs/v01.csv --delay auto --out a.tri
accumulate arm.yaml logs/v01.csv --weights huber --out a.tri
accumulate arm.yaml currents/v01.csv --out a.tri
accumulate arm.yaml arm.yaml --out a.tri
validate arm.yaml estimate.yaml logs/v02.csv --cutoff 10
generate arm.yaml --language c
generate arm.yaml --functions speed
inspect arm.yaml --value L9=1
inspect arm.yaml --value L1=long
check arm.yaml motion.yaml --limits limits.yaml
";

const MADE: &str = "\
plan arm.yaml --experiments 4 --steps 3 --starts 1 --out plan.yaml
simulate arm.yaml plan.yaml --validation 2 --out logs
simulate arm.yaml plan.yaml --validation 1 --gain q1=2,q2=3 --out currents
identify arm.yaml logs/v01.csv --out estimate.yaml
excite arm.yaml --period 5 --starts 1 --iterations 3 --repetitions 1 --out motion.yaml
";

#[test]
fn refusals_are_as_they_were() {
    let here = folder("refusals");
    let write = |name: &str, text: &str| std::fs::write(here.join(name), text).unwrap();
    write("arm.yaml", LIMITED_ARM);
    write("limits.yaml", "all: {velocity: 9}\n");
    write("options.yaml", "friction: [viscous]\n");
    let words = |line: &str| line.split_whitespace().map(str::to_string).collect::<Vec<_>>();
    for line in MADE.lines() {
        let words = words(line);
        let run = rist(&here, &words.iter().map(String::as_str).collect::<Vec<_>>());
        assert!(matches!(run.code, Some(0 | 1)), "{line}: {}{}", run.out, run.err);
    }
    let mut said = String::new();
    for line in REFUSED.lines() {
        let words = words(line);
        let run = rist(&here, &words.iter().map(String::as_str).collect::<Vec<_>>());
        assert_ne!(run.code, Some(0), "{line}: {}", run.out);
        // Writing to a String cannot fail.
        let _ = write!(said, "$ rist {line}\n{}[exit code {}]\n\n", run.err, run.code.unwrap_or(-1));
    }
    assert_snapshot("refusals/program.txt", &said);
}
