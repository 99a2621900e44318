fn main() {
    for file in std::env::args().skip(1) {
        let path = std::path::Path::new(&file);
        let t = std::time::Instant::now();
        match robot::format::read(path) {
            Err(e) => println!("!! {file}: {}", e.to_string().lines().next().unwrap_or("")),
            Ok(r) => {
                println!("== {file} ({} links, {} pairs)", r.links.len(), robot::mirror_pairs::mirror_pairs(&r).len());
                let d = path.parent().unwrap();
                let meshes = |c: &robot::Collision| match &c.shape {
                    robot::CollisionShape::Mesh { file, scale } => {
                        let name = file.rsplit("://").next().unwrap();
                        let p = d
                            .ancestors()
                            .flat_map(|a| [a.join(name), a.join(name.split_once('/').map_or("", |x| x.1))])
                            .find(|p| p.is_file())?;
                        let b = std::fs::read(&p).ok()?;
                        let v = robot::mesh::vertices(&b, &p).ok()?;
                        Some(v.into_iter().map(|p| [p[0] * scale[0], p[1] * scale[1], p[2] * scale[2]]).collect())
                    }
                    _ => None,
                };
                for f in robot::lint::lint_with(&r, robot::lint::LintContext { meshes: &meshes, mass: None }) {
                    println!("   [{:?}] {f}", f.mistake);
                }
                let ms = t.elapsed().as_millis();
                if ms > 500 {
                    println!("   SLOW {ms} ms");
                }
            }
        }
    }
}
