//! What motions of `rist excite` keep of what they promise: errors of the base parameters over the promised deviations, and
//! the intervals that hold the truth. `cargo bench -p tests --bench promise -- 50` (the number of draws).

use rist::Model;
use rist::exciting::ExciteRequest;
use tests::model_path;
use tests::promise::{FRICTION, Kept, kept};

fn main() {
    let words: Vec<String> = std::env::args().skip(1).filter(|w| !w.starts_with("--")).collect();
    let draws = words.iter().find_map(|w| w.parse().ok()).unwrap_or(50);
    let is_wanted = |name: &str| words.iter().all(|w| w.parse::<u64>().is_ok()) || words.iter().any(|w| w == name);
    println!("{draws} draws, error over promise");
    println!("{:<12} {:>6} {:>6} {:>9} {:>7}  of", "robot", "rms", "mean", "held, %", "worst");
    for file in ["ur5.urdf", "panda.yaml", "scara.yaml", "race.yaml"].into_iter().filter(|file| is_wanted(file)) {
        let model = Model::read(model_path(file)).expect("a description");
        let request = ExciteRequest { friction: FRICTION.to_vec(), ..Default::default() };
        let motion = rist::excite(&model, &request, &|_, _, _| ()).expect("a motion");
        let kept = kept(&model, &motion, draws).expect("estimates");
        let mean = |of: &dyn Fn(&Kept) -> f64| kept.iter().map(of).sum::<f64>() / kept.len() as f64;
        let (rms, held) = (mean(&|k| k.ratio.powi(2)).sqrt(), 100.0 * mean(&|k| k.held));
        let worst = kept.iter().max_by(|a, b| a.ratio.total_cmp(&b.ratio)).expect("a parameter");
        println!("{file:<12} {rms:>6.2} {:>6.2} {held:>9.1} {:>7.2}  {}", mean(&|k| k.ratio), worst.ratio, worst.name);
    }
}
