//! Tests that a short search finds a proven motion for every arm of `KNOWN_ARMS`. The motion exceeds no limit when it is sampled
//! at a hundred times its rate. For the default settings of the search, see `cargo bench -p tests --bench excite`.

use std::path::Path;

use rist::Model;
use rist::request::ExciteRequest;
use tests::dense_samples::violations;
use tests::known_arms::KNOWN_ARMS;

#[test]
fn a_short_search_finds_a_proven_motion_for_every_known_arm() {
    for arm in &KNOWN_ARMS {
        let model = Model::parse(&arm.urdf(), Path::new(arm.name).with_extension("urdf"), &Default::default()).unwrap();
        let request = ExciteRequest { starts: 1, iterations: 5, ..ExciteRequest::default() };
        let found = rist::excite(&model, &request, &|_, _, _| ()).unwrap();
        assert!(found.proven && found.joints.len() >= 6, "{}: {:?}", arm.name, found.certificate);
        assert!(found.parameters.iter().all(|p| p.deviation.is_some()), "{}: {:?}", arm.name, found.parameters);
        let (beyond, samples) = violations(&found, 100.0);
        assert!(beyond == 0 && samples > 50_000, "{}: {beyond} of {samples}", arm.name);
    }
}
