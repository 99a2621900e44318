//! Descriptions with usual mistakes must give the expected findings; correct descriptions must give none.

use std::path::Path;

use robot::format;
use robot::lint::{Finding, Mistake, Severity, lint};

fn findings(path: &Path) -> Vec<Finding> {
    let robot = format::read(path).unwrap_or_else(|e| panic!("{e}"));
    let findings = lint(&robot);
    assert!(findings.iter().all(|f| !f.subjects.is_empty() && !f.text().is_empty()));
    findings
}

#[test]
fn each_mistake_is_found() {
    use Mistake::*;
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("testdata/lint");
    let expected = [
        ("mass_negative.yaml", Some((NegativeMass, ""))),
        ("inertia_without_mass.yaml", Some((InertiaWithoutMass, ""))),
        ("triangle.yaml", Some((Impossible, ""))),
        ("products_swapped.yaml", Some((Impossible, "Ixz and Iyz exchanged"))),
        ("order_of_pinocchio.yaml", Some((Impossible, "Pinocchio's order"))),
        ("wrong_point.yaml", Some((Impossible, "about the centre of mass instead of the origin of the frame"))),
        ("moved_twice.urdf", Some((Impossible, "taken off once too often"))),
        ("grams.yaml", Some((Units, "mass and inertia in g and g m^2"))),
        ("turned_frame.urdf", Some((TurnedInertialFrame, ""))),
        ("sound.urdf", None),
    ];
    for (file, mistake) in expected {
        let found = findings(&folder.join(file));
        match mistake {
            Some((mistake, repair)) => {
                let named = |f: &Finding| match &f.repair {
                    Some(named) => !repair.is_empty() && named.text.contains(repair),
                    None => repair.is_empty(),
                };
                assert!(found.iter().any(|f| f.mistake == mistake && named(f)), "{file}: {found:?}");
            }
            None => assert!(found.iter().all(|f| f.severity() == Severity::Note), "{file}: {found:?}"),
        }
    }
    assert_eq!(std::fs::read_dir(&folder).unwrap().count(), expected.len());
}

#[test]
fn the_models_shipped_are_bodies() {
    let models = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../models");
    for file in std::fs::read_dir(models).unwrap().map(|f| f.unwrap().path()) {
        if file.extension().is_some_and(|e| e == "yaml" || e == "urdf") {
            let found = findings(&file);
            assert!(found.iter().all(|f| f.severity() == Severity::Note), "{}: {found:?}", file.display());
        }
    }
}
