fn main() {
    for path in std::env::args().skip(1) {
        let robot = robot::format::read(path.as_ref()).unwrap_or_else(|e| panic!("{e}"));
        let t = std::time::Instant::now();
        let mut derivation = modeling::Derivation::new(&robot);
        let d = derivation.regressor();
        let t1 = t.elapsed();
        match derivation.base_parameters(&d) {
            Ok(b) => {
                let t2 = t.elapsed();
                println!("{}: {} {:?} {:?} {:?}", robot.name, b.len(), b.rank, t1, t2);
                println!(
                    "  std {:?} base {:?} torque {:?}",
                    d.bound().count(),
                    b.regressor(&d).bound().count(),
                    derivation.torque().bound().count()
                );
                for p in &b.base {
                    println!("  {:10} {}", p.name, p.rule);
                }
                println!(
                    "  no effect {}: {}",
                    b.no_effect.len(),
                    b.no_effect
                        .iter()
                        .map(|&c| b.standard[c].display(&robot).to_string())
                        .collect::<Vec<_>>()
                        .join(" ")
                );
            }
            Err(e) => println!("{}: {e}", robot.name),
        }
    }
}
