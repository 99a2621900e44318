//! Compares the accuracy that `rist excite` predicts for its motions with simulated identifications: errors of the base
//! parameters divided by the predicted standard deviations, and the coverage of the intervals. `cargo bench -p tests --bench
//! promise -- 50` (number of draws). `encoders=0.1`: encoders with a tenth of the quantum and noise.
//!
//! Coverage: share of the 95 % intervals that contain the true value.

use rist::Model;
use rist::request::{ExciteRequest, FrictionChoice};
use tests::model_path;
use tests::promise::{FRICTION, Kept, kept};

fn main() {
    let words: Vec<String> = std::env::args().skip(1).filter(|w| !w.starts_with("--")).collect();
    let draws = words.iter().find_map(|w| w.parse().ok()).unwrap_or(50);
    let encoders = words.iter().find_map(|w| w.strip_prefix("encoders=")?.parse().ok()).unwrap_or(1.0);
    let files = ["ur5.urdf", "panda.yaml", "scara.yaml", "race.yaml"];
    let is_wanted = |name: &str| words.iter().all(|w| !files.contains(&w.as_str())) || words.iter().any(|w| w == name);
    println!("{draws} draws, error over promise, encoders {encoders} of what is assumed of them");
    println!("{:<12} {:>6} {:>6} {:>6} {:>9} {:>7}  of", "robot", "rms", "+-", "mean", "held, %", "worst");
    for file in files.into_iter().filter(|file| is_wanted(file)) {
        let model = Model::read(model_path(file)).expect("a description");
        let request = ExciteRequest { friction: Some(FrictionChoice::Terms(FRICTION.to_vec())), ..Default::default() };
        let motion = rist::excite(&model, &request, &|_, _, _| ()).expect("a motion");
        let kept = kept(&model, &motion, draws, encoders).expect("estimates");
        let mean = |of: &dyn Fn(&Kept) -> f64| kept.iter().map(of).sum::<f64>() / kept.len() as f64;
        let (rms, held) = (mean(&|k| k.ratio.powi(2)).sqrt(), 100.0 * mean(&|k| k.held));
        let worst = kept.iter().max_by(|a, b| a.ratio.total_cmp(&b.ratio)).expect("a parameter");
        let (plain, deviation) = (mean(&|k| k.ratio), deviation(&kept, draws));
        println!(
            "{file:<12} {rms:>6.2} {deviation:>6.2} {plain:>6.2} {held:>9.1} {:>7.2}  {}",
            worst.ratio, worst.name
        );
    }
}

/// The standard deviation of the rms normalised error over all parameters. Draws are independent, but the parameters of one draw
/// are not.
fn deviation(kept: &[Kept], draws: u64) -> f64 {
    let of_draw = |d: usize| kept.iter().map(|k| k.errors[d].powi(2)).sum::<f64>() / kept.len() as f64;
    let squares: Vec<f64> = (0..draws as usize).map(of_draw).collect();
    let count = draws as f64;
    let mean = squares.iter().sum::<f64>() / count;
    let variance = squares.iter().map(|s| (s - mean).powi(2)).sum::<f64>() / (count - 1.0);
    (variance / count).sqrt() / (2.0 * mean.sqrt())
}
