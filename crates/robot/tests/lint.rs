//! Descriptions with usual mistakes must give the expected findings; correct descriptions must give none.

use std::path::Path;

use robot::format;
use robot::lint::{Mistake, lint};

fn mistakes(path: &Path) -> Vec<Mistake> {
    let robot = format::read(path).unwrap_or_else(|e| panic!("{e}"));
    let findings = lint(&robot);
    assert!(findings.iter().all(|f| !f.link.is_empty() && !f.text.is_empty()));
    findings.into_iter().map(|f| f.mistake).collect()
}

#[test]
fn each_mistake_is_found() {
    use Mistake::*;
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("testdata/lint");
    let expected = [
        ("mass_negative.yaml", Some(NegativeMass)),
        ("inertia_without_mass.yaml", Some(InertiaWithoutMass)),
        ("triangle.yaml", Some(TriangleInequality)),
        ("products_swapped.yaml", Some(SwappedProducts)),
        ("order_of_pinocchio.yaml", Some(SwappedOrder)),
        ("wrong_point.yaml", Some(WrongPoint)),
        ("moved_twice.urdf", Some(WrongPoint)),
        ("grams.yaml", Some(Units)),
        ("turned_frame.urdf", Some(TurnedInertialFrame)),
        ("sound.urdf", None),
    ];
    for (file, mistake) in expected {
        let found = mistakes(&folder.join(file));
        match mistake {
            Some(mistake) => assert!(found.contains(&mistake), "{file}: {found:?}"),
            None => assert!(found.is_empty(), "{file}: {found:?}"),
        }
    }
    assert_eq!(std::fs::read_dir(&folder).unwrap().count(), expected.len());
}

#[test]
fn the_models_shipped_are_bodies() {
    let models = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../models");
    for file in std::fs::read_dir(models).unwrap().map(|f| f.unwrap().path()) {
        if file.extension().is_some_and(|e| e == "yaml" || e == "urdf") {
            let found = mistakes(&file);
            assert!(found.iter().all(|m| *m == Mistake::TurnedInertialFrame), "{}: {found:?}", file.display());
        }
    }
}
