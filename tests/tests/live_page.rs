//! The script of a page tells and draws what the log holds: values, the smallest and the largest of a span, gaps.

use std::io::Write;
use std::process::{Command, Stdio};

use serde_json::{Value, json};
use tests::planar_log::{HEADER, log_of};
use tests::program::{folder, rist};
use tests::random::Random;
use tests::{model, test_robot_path};

/// A page whose script runs without a browser: the document is empty.
const WITHOUT_BROWSER: &str = "
    const { html, questions } = JSON.parse(require('fs').readFileSync(0, 'utf8'));
    const script = html.split('<script>')[1].split('</script>')[0];
    globalThis.document = { querySelectorAll: () => [], getElementById: () => null };
    globalThis.window = { addEventListener() {} };
    const { Plots } = new Function(`${script}; return { Plots };`)();
    const lines = Plots.read(JSON.parse(html.split('id=\"time-log\">')[1].split('</script>')[0]));
    const numbers = path => path.split('M').slice(1).map(piece => piece.replace(/[zh].*/, '').split('L').map(p => p.split(' ').map(Number)));
    const answers = {
        told: ({ keys, times }) => times.map(t => keys.map(key => Plots.told(lines.curves[key], Plots.at(lines, t)))),
        steps: ({ keys }) => keys.map(key => lines.curves[key].step),
        drawn: ({ key, window }) => numbers(Plots.path(lines, key, window, (t, v) => [1e6 * t, 1e6 * v])),
        thinned: ({ line, window }) => numbers(Plots.path({ ...line, curves: { a: { low: line.low.map(Number), high: line.high.map(Number) } } }, 'a', window, (t, v) => [1e6 * t, 1e6 * v])),
    };
    console.log(JSON.stringify(questions.map(({ ask, ...of }) => answers[ask](of))));";

/// What the script of a page answers; none without an engine to run it.
fn answers(html: &str, questions: &Value) -> Option<Vec<Value>> {
    let mut node =
        Command::new("node").args(["-e", WITHOUT_BROWSER]).stdin(Stdio::piped()).stdout(Stdio::piped()).spawn().ok()?;
    let input = json!({"html": html, "questions": questions}).to_string();
    node.stdin.take().unwrap().write_all(input.as_bytes()).unwrap();
    let out = node.wait_with_output().unwrap();
    assert!(out.status.success());
    Some(serde_json::from_slice(&out.stdout).unwrap())
}

/// A row of the series: time, and measured and predicted torque of two joints.
fn rows(series: &str) -> Vec<(f64, [Option<f64>; 4])> {
    let row = |line: &str| {
        let cells: Vec<Option<f64>> = line.split(',').skip(1).map(|x| x.parse().ok()).collect();
        (cells[0].unwrap(), [cells[1], cells[2], cells[3], cells[4]])
    };
    series.lines().skip(1).map(row).collect()
}

#[test]
fn a_page_tells_and_draws_what_the_log_holds() {
    let here = folder("live_page");
    let robot = model("planar2r_vertical.yaml");
    let arm = test_robot_path("planar2r_vertical.yaml").display().to_string();
    let rubbed = |_: usize, dq: f64, tau: f64| tau + 0.4 * dq + 0.3 * dq.signum();
    let log = log_of(&robot, &Random(41).physical_parameters(&robot), &rubbed);
    std::fs::write(here.join("a.csv"), format!("{HEADER}\n{}\n", log.join("\n"))).unwrap();
    let run = rist(&here, &["identify", &arm, "a.csv", "--report", "p.html", "--series", "s.csv", "--out", "e.yaml"]);
    assert_eq!(run.code, Some(0), "{}", run.err);
    let text = |file: &str| std::fs::read_to_string(here.join(file)).unwrap();
    let (html, series) = (text("p.html"), rows(&text("s.csv")));
    let from = series[0].0;
    let times: Vec<f64> = series.iter().map(|row| row.0 - from + 1e-7).collect();
    let window = [times[100], times[300]];
    // Spans of two samples each, a gap, and a span without a value.
    let line = json!({"from": 0, "to": 9, "t": [0, 1, 2, 6, 7, 8], "pieces": [[0, 2.5], [3, 8.5]], "step": 1,
                      "low": [0, -1, -2, -3, "NaN", -5], "high": [1, 2, 3, 4, "NaN", 6]});
    let questions = json!([
        {"ask": "told", "keys": ["m0", "p0", "r0"], "times": times},
        {"ask": "steps", "keys": ["m0", "p0", "r0"]},
        {"ask": "drawn", "key": "m0", "window": window},
        {"ask": "thinned", "line": line, "window": [0, 9]},
        {"ask": "thinned", "line": line, "window": [1.2, 1.4]},
        {"ask": "thinned", "line": line, "window": [3, 5]},
    ]);
    let Some(said) = answers(&html, &questions) else {
        println!("skipped: no node");
        return;
    };
    let steps: Vec<f64> = said[1].as_array().unwrap().iter().map(|x| x.as_f64().unwrap()).collect();
    let (mut told, mut missing) = (0, 0);
    for ((_, [measured, predicted, ..]), said) in series.iter().zip(said[0].as_array().unwrap()) {
        let said: Vec<&str> = said.as_array().unwrap().iter().map(|x| x.as_str().unwrap()).collect();
        // Half a step of the page, and half a digit of what is told, which is at most the step.
        let near = |text: &str, value: f64, step: f64| {
            assert!((text.parse::<f64>().unwrap() - value).abs() <= 1.01 * step, "{text} {value}")
        };
        near(said[0], measured.unwrap(), steps[0]);
        match predicted {
            Some(predicted) => {
                near(said[1], *predicted, steps[1]);
                near(said[2], measured.unwrap() - predicted, steps[2]);
                told += 1;
            }
            // A row that does not count has no residual, and the page tells none.
            None => {
                assert_eq!(said[2], "–");
                missing += 1;
            }
        }
    }
    assert!(told > 500 && missing > 0, "{told} {missing}");

    // Looked at closer, every sample of the span is on the line.
    let points: Vec<(f64, f64)> = said[2]
        .as_array()
        .unwrap()
        .iter()
        .flat_map(|piece| piece.as_array().unwrap())
        .map(|p| (1e-6 * p[0].as_f64().unwrap(), 1e-6 * p[1].as_f64().unwrap()))
        .collect();
    for (t, row) in times.iter().zip(&series).skip(100).take(201) {
        let value = row.1[0].unwrap();
        let is_there = |p: &(f64, f64)| (p.0 - t).abs() < 1e-4 && (p.1 - value).abs() <= steps[0];
        assert!(points.iter().any(is_there), "{t} {value}");
    }
    assert!(points.len() < 210, "{}", points.len());

    // Of spans, the outline: forth along the smallest, back along the largest; no outline reaches over a gap.
    let outline = |k: usize| -> Vec<Vec<[f64; 2]>> {
        let number = |x: &Value| x.as_f64().unwrap() / 1e6;
        let piece = |piece: &Value| piece.as_array().unwrap().iter().map(|p| [number(&p[0]), number(&p[1])]).collect();
        said[k].as_array().unwrap().iter().map(piece).collect()
    };
    let whole = outline(3);
    assert_eq!(whole[0], [[0., 0.], [1., -1.], [2., -2.], [2.5, -2.], [2.5, 3.], [2., 3.], [1., 2.], [0., 1.]]);
    assert_eq!(whole[1], [[6., -3.], [7., -3.], [7., 4.], [6., 4.]]);
    assert_eq!((whole.len(), whole[2].first()), (3, Some(&[8., -5.])));
    // Between the beginnings of two spans both are drawn; inside of a gap nothing is.
    assert!(outline(4).iter().flatten().any(|p| p == &[1., 2.]) && outline(4).iter().flatten().any(|p| p == &[2., 3.]));
    assert!(outline(5).iter().flatten().all(|p| p[0] <= 3.0 || p[0] >= 5.0), "{:?}", outline(5));
}
