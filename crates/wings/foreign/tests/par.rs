//! Writes robots as .par files and reads them again.
//!
//! A robot that is written and read again must be the same robot.

use std::path::Path;

use foreign::write_par;
use robot::format;

/// Each robot is written as a .par file and read again. The result has the same link poses for the same joint positions, the same
/// gravity and the same parameters. Written again, it gives the same text (comments excepted).
#[test]
fn written_files_read_back() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let models = std::fs::read_dir(root.join("../../../models")).unwrap();
    let files: Vec<_> = models
        .chain(std::fs::read_dir(root.join("../../robot/testdata/par")).unwrap())
        .map(|f| f.unwrap().path())
        .filter(|p| p.extension().is_some_and(|e| e != "md"))
        .collect();
    assert!(files.len() > 15);
    for file in files {
        let robot = format::read(&file).unwrap_or_else(|e| panic!("{e}"));
        let (text, _) = write_par(&robot);
        let back = format::read_par(&text, "back.par").unwrap_or_else(|e| panic!("{}: {e}\n{text}", file.display()));
        let q: Vec<f64> = (0..robot.n_variables()).map(|k| 0.3 + 0.7 * k as f64).collect();
        assert_eq!(back.n_variables(), robot.n_variables(), "{}", file.display());
        // Substitute values of symbols depend only on their names. But the names of gravity symbols may change, so gravity is
        // compared as numbers.
        for (a, b) in robot.link_poses(&q).iter().zip(back.link_poses(&q)) {
            for i in 0..3 {
                assert!((a.position[i] - b.position[i]).abs() < 1e-14, "{}", file.display());
                for j in 0..3 {
                    assert!((a.rotation[i][j] - b.rotation[i][j]).abs() < 1e-14, "{}", file.display());
                }
            }
        }
        assert_eq!(robot.gravity_number(), back.gravity_number());
        for (a, b) in robot.links.iter().zip(&back.links) {
            assert_eq!(a.inertial, b.inertial);
            assert_eq!(a.joint.rotor_inertia, b.joint.rotor_inertia);
            assert_eq!(a.antecedent, b.antecedent);
        }
        let body = |text: &str| text.lines().filter(|l| !l.starts_with("(*")).collect::<Vec<_>>().join("\n");
        let again = format::read_par(&write_par(&back).0, "again.par").unwrap();
        assert_eq!(body(&write_par(&back).0), body(&write_par(&again).0));
    }
}
