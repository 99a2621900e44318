//! Fuzz target for meshes, read as STL, OBJ and Collada, and for the convex solid that encloses them.
//!
//! Properties: the solid contains every vertex; the distance of the solid from a ball is not larger than the distance of any
//! vertex.
#![no_main]

use std::path::Path;

use clearance::mesh::parse_vertices;
use clearance::separation::{PosedSolid, separation};
use clearance::solid::{Core, Solid};
use libfuzzer_sys::fuzz_target;
use robot::Pose;

fuzz_target!(|data: &[u8]| {
    rist::wings::register(vec![foreign::wing()]);
    for path in ["mesh.stl", "mesh.obj", "mesh.dae"].map(Path::new) {
        if let Ok(vertices) = parse_vertices(data, path) {
            held(&vertices);
        }
    }
});

fn held(vertices: &[[f64; 3]]) {
    let solid = Solid::around(vertices).expect("a mesh that was read has vertices");
    let (centre, ball) = solid.ball();
    let size = vertices.iter().flatten().fold(0.0, |size: f64, x| size.max(x.abs()));
    // The tolerance for rounding errors of sums of three products.
    let rounding = 1e-12 * size;
    for along in [[0.3, -0.4, 0.87], [-0.8, 0.1, 0.2], [1.0, 0.0, 0.0]] {
        let outermost = vertices.iter().map(|p| dot(*p, along)).fold(f64::NEG_INFINITY, f64::max);
        let held = dot(solid.core.support(along), along) + solid.radius * dot(along, along).sqrt();
        assert!(held >= outermost - rounding, "{held} {outermost}");
    }
    assert!(vertices.iter().all(|p| distance(*p, centre) <= ball + rounding), "{centre:?} {ball}");

    let place = [2.0, -1.0, 0.5];
    let point = Solid { core: Core::Point, radius: 0.1 };
    let there = PosedSolid { solid: &point, pose: Pose { position: place, ..Pose::IDENTITY } };
    let found = separation(there, PosedSolid { solid: &solid, pose: Pose::IDENTITY }, place);
    let nearest = vertices.iter().map(|p| distance(*p, place)).fold(f64::INFINITY, f64::min) - 0.1;
    assert!(found.at_least <= nearest + rounding + 1e-12, "{found:?} {nearest}");
    assert!(found.at_least <= found.reached + rounding + 1e-12, "{found:?}");
}

fn dot(a: [f64; 3], b: [f64; 3]) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

fn distance(a: [f64; 3], b: [f64; 3]) -> f64 {
    let between = [0, 1, 2].map(|k| a[k] - b[k]);
    dot(between, between).sqrt()
}
