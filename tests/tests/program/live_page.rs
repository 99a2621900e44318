//! Tests that the script of an HTML page shows and draws the values of the log: samples, minima and maxima of intervals, and
//! gaps.

use serde_json::{Value, json};
use tests::planar_log::write_rubbed;
use tests::program::{folder, node, rist};

/// A program for Node.js that runs the script of a page without a browser, with an empty document.
const WITHOUT_BROWSER: &str = "
    const { html, questions } = JSON.parse(require('fs').readFileSync(0, 'utf8'));
    const script = html.split('<script>')[1].split('</script>')[0];
    globalThis.document = { querySelectorAll: () => [], getElementById: () => null };
    globalThis.window = { addEventListener() {} };
    const { Plots } = new Function(`${script}; return { Plots };`)();
    const lines = Plots.read(JSON.parse(html.split('id=\"time-log\">')[1].split('</script>')[0]));
    const numbers = path => path.split('M').slice(1).map(piece => piece.replace(/[zh].*/, '').split('L').map(p => p.split(' ').map(Number)));
    const answers = {
        told: ({ keys, times }) => times.map(t => keys.map(key => Plots.label(lines.curves[key], Plots.at(lines, t)))),
        steps: ({ keys }) => keys.map(key => lines.curves[key].step),
        drawn: ({ key, window }) => numbers(Plots.path(lines, key, window, (t, v) => [1e6 * t, 1e6 * v])),
        thinned: ({ line, window }) => numbers(Plots.path({ ...line, curves: { a: { low: line.low.map(Number), high: line.high.map(Number) } } }, 'a', window, (t, v) => [1e6 * t, 1e6 * v])),
    };
    console.log(JSON.stringify(questions.map(({ ask, ...of }) => answers[ask](of))));";

/// The answers of a page's script to `questions`; `None` if there is no JavaScript engine.
fn answers(html: &str, questions: &Value) -> Option<Vec<Value>> {
    let said = node(WITHOUT_BROWSER, &json!({"html": html, "questions": questions}))?;
    Some(said.as_array().unwrap().clone())
}

/// A row of the file with measured and predicted torques (`--series`): time, and [measured and predicted torque of joint 1, the
/// same of joint 2].
type Row = (f64, [Option<f64>; 4]);

fn rows(series: &str) -> Vec<Row> {
    let row = |line: &str| {
        let cells: Vec<Option<f64>> = line.split(',').skip(1).map(|x| x.parse().ok()).collect();
        (cells[0].unwrap(), [cells[1], cells[2], cells[3], cells[4]])
    };
    series.lines().skip(1).map(row).collect()
}

/// Identifies a log in the folder `name`. Returns the HTML page, and the rows of measured and predicted torques.
fn page_of_a_log(name: &str) -> (String, Vec<Row>) {
    let here = folder(name);
    let arm = write_rubbed(&here.join("a.csv"), 0.4);
    rist(&here, &["identify", &arm, "a.csv", "--report", "p.html", "--series", "s.csv", "--out", "e.yaml"]).ended(0);
    let text = |file: &str| std::fs::read_to_string(here.join(file)).unwrap();
    (text("p.html"), rows(&text("s.csv")))
}

/// The segments of an SVG path: [time, value] of each corner. The script multiplied both by 10^6.
fn pieces(path: &Value) -> Vec<Vec<[f64; 2]>> {
    let number = |x: &Value| x.as_f64().unwrap() / 1e6;
    let piece = |piece: &Value| piece.as_array().unwrap().iter().map(|p| [number(&p[0]), number(&p[1])]).collect();
    path.as_array().unwrap().iter().map(piece).collect()
}

/// The page shows, at the pointer, the sample of the log at that time. Rows that are not fitted show no residual. If the shown
/// time window is small, every sample is a point of the line.
#[test]
fn a_page_tells_what_the_log_holds() {
    let (html, series) = page_of_a_log("live_page");
    // Each sample begins an interval of time; the last sample only ends the log.
    let (from, series) = (series[0].0, &series[..series.len() - 1]);
    // The time axis of the page starts at zero. The pointer is 1e-5 s after each sample, so that its interval has begun.
    let times: Vec<f64> = series.iter().map(|row| row.0 - from + 1e-5).collect();
    let some = series.len() / 4..series.len() / 2;
    let questions = json!([
        {"ask": "told", "keys": ["m0", "p0", "r0"], "times": times},
        {"ask": "steps", "keys": ["m0", "p0", "r0"]},
        {"ask": "drawn", "key": "m0", "window": [times[some.start], times[some.end]]},
    ]);
    let Some(said) = answers(&html, &questions) else { return };
    let steps: Vec<f64> = said[1].as_array().unwrap().iter().map(|x| x.as_f64().unwrap()).collect();
    let (mut told, mut missing) = (0, 0);
    for ((_, [measured, predicted, ..]), said) in series.iter().zip(said[0].as_array().unwrap()) {
        let said: Vec<&str> = said.as_array().unwrap().iter().map(|x| x.as_str().unwrap()).collect();
        // The tolerance is one step of the page's numbers: half a step because the page rounds its data, and half a digit of the
        // label.
        let near = |k: usize, value: f64| {
            assert!((said[k].parse::<f64>().unwrap() - value).abs() <= 1.01 * steps[k], "{} {value}", said[k]);
        };
        near(0, measured.unwrap());
        match predicted {
            Some(predicted) => {
                near(1, *predicted);
                near(2, measured.unwrap() - predicted);
                told += 1;
            }
            // A row that is not fitted has no residual, so the page shows a dash.
            None => {
                assert_eq!(said[2], "–");
                missing += 1;
            }
        }
    }
    assert!(told > 100, "{told} {missing}");
    let points: Vec<[f64; 2]> = pieces(&said[2]).concat();
    for (t, row) in times.iter().zip(series).take(some.end).skip(some.start) {
        let value = row.1[0].unwrap();
        assert!(points.iter().any(|p| (p[0] - t).abs() < 1e-4 && (p[1] - value).abs() <= steps[0]), "{t} {value}");
    }
    assert!(points.len() <= some.len() + 4, "{}", points.len());
}

/// If an interval of the drawing contains several samples, it is drawn as an outline: first along the minima, then back along the
/// maxima. An outline must not cross a gap of the log or an interval without a value.
#[test]
fn spans_keep_their_ends_and_gaps() {
    let (html, _) = page_of_a_log("live_spans");
    let line = json!({"from": 0, "to": 9, "t": [0, 1, 2, 6, 7, 8], "pieces": [[0, 2.5], [3, 8.5]],
                      "low": [0, -1, -2, -3, "NaN", -5], "high": [1, 2, 3, 4, "NaN", 6]});
    let windows = [[0.0, 9.0], [1.2, 1.4], [3.0, 5.0]];
    let questions = windows.map(|window| json!({"ask": "thinned", "line": line, "window": window}));
    let Some(said) = answers(&html, &questions.to_vec().into()) else { return };
    let whole = pieces(&said[0]);
    assert_eq!(whole[0], [[0., 0.], [1., -1.], [2., -2.], [2.5, -2.], [2.5, 3.], [2., 3.], [1., 2.], [0., 1.]]);
    assert_eq!(whole[1], [[6., -3.], [7., -3.], [7., 4.], [6., 4.]]);
    assert_eq!((whole.len(), whole[2].first()), (3, Some(&[8., -5.])));
    // If the shown time window is between the starts of two intervals, both are drawn; if it is inside a gap, nothing is drawn in
    // it.
    let closer = pieces(&said[1]).concat();
    assert!(closer.contains(&[1., 2.]) && closer.contains(&[2., 3.]), "{closer:?}");
    let inside = pieces(&said[2]).concat();
    assert!(inside.iter().all(|p| p[0] <= 3.0 || p[0] >= 5.0), "{inside:?}");
}
