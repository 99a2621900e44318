//! Tests of the HTML pages in a browser: three widths; light, dark and printed; with pointer, clicks and keys. There must be no
//! console error, no network request and no horizontal scroll bar. Without Chromium the tests print a note and are skipped.

use std::path::Path;
use std::process::Command;

use serde_json::Value;
use tests::model_path;
use tests::planar_log::write_rubbed;
use tests::program::{folder, rist};

/// A script at the start of a page, which collects errors and warnings in the list `wrong`.
const WATCH: &str = "<script>
    const wrong = [];
    addEventListener('error', event => wrong.push(`${event.message} ${event.filename}`), true);
    ['error', 'warn'].forEach(name => { console[name] = (...words) => wrong.push(words.join(' ')); });
    // Pointers of a script are not there to be captured.
    Element.prototype.setPointerCapture = () => {};
</script>";

/// A script at the end of a page, which acts like a user and sends the failed checks to the surrounding page.
const USE: &str = "<script>{
    const hold = (what, holds) => { if (!holds) wrong.push(what); };
    const every = (selector, inside = document) => [...inside.querySelectorAll(selector)];
    const send = (element, type, x = 0.5, y = 0.5, more = {}) => {
        const box = element.getBoundingClientRect();
        const at = { clientX: box.left + x * box.width, clientY: box.top + y * box.height };
        element.dispatchEvent(new PointerEvent(type, { bubbles: true, cancelable: true, button: 0, pointerId: 1, ...at, ...more }));
    };
    const plots = () => {
        const [chart, ...others] = every('svg.live');
        if (!chart) return;
        const figure = chart.closest('figure');
        const [button] = every('.legend button', figure);
        const path = figure.querySelector(`[data-curve=${button.dataset.key}]`);
        send(chart, 'pointermove', 0.3);
        hold('the pointer tells the time', / s$/.test(figure.querySelector('.clock').textContent));
        hold('the pointer tells a value', /[0-9]/.test(button.querySelector('output').textContent));
        hold('all charts have the cursor', [chart, ...others].filter(c => c.closest('figure').dataset.time === figure.dataset.time).every(c => c.querySelector('.cursor').getAttribute('d')));
        button.click();
        hold('a click on a name hides its line', getComputedStyle(path).display === 'none');
        button.click();
        hold('another shows it', getComputedStyle(path).display !== 'none');
        const before = path.getAttribute('d');
        send(chart, 'pointerdown', 0.4);
        send(chart, 'pointermove', 0.6);
        send(chart, 'pointerup', 0.6);
        hold('pulling looks closer', chart.classList.contains('zoomed') && path.getAttribute('d') !== before);
        send(chart, 'dblclick');
        hold('a double click shows all', !chart.classList.contains('zoomed') && path.getAttribute('d') === before);
        chart.dispatchEvent(new WheelEvent('wheel', { deltaY: -1, ctrlKey: true, cancelable: true, clientX: 300 }));
        hold('the wheel looks closer', chart.classList.contains('zoomed'));
        chart.dispatchEvent(new KeyboardEvent('keydown', { key: '0', cancelable: true }));
        hold('the key 0 shows all', !chart.classList.contains('zoomed'));
        send(chart, 'pointerleave');
    };
    const robot = () => {
        const figure = document.querySelector('figure.drawing');
        if (!figure) return;
        const drawn = () => figure.querySelector('svg g').innerHTML;
        const slider = figure.querySelector('.player input');
        let before = drawn();
        hold('the robot is drawn', /<path/.test(before));
        if (slider) {
            slider.value = 0.7 * +slider.min + 0.3 * +slider.max;
            slider.dispatchEvent(new Event('input'));
            hold('the robot moves along', drawn() !== before);
            hold('the plots have the time of the robot', every('.clock').some(clock => clock.textContent));
            figure.querySelector('[data-play]').click();
            hold('it plays', figure.querySelector('[data-play]').textContent === 'stop');
            figure.querySelector('[data-play]').click();
        }
        before = drawn();
        const svg = figure.querySelector('svg');
        send(svg, 'pointerdown', 0.3);
        send(svg, 'pointermove', 0.6);
        send(svg, 'pointerup', 0.6);
        hold('the mouse turns the robot', drawn() !== before);
    };
    const map = () => {
        const figure = document.querySelector('figure.map');
        if (!figure) return;
        const svg = figure.querySelector('svg');
        send(svg, 'pointermove', 0.1, 0.9);
        hold('the map tells a pair', / and .*: -?[01][.][0-9]{3}$/.test(figure.querySelector('.label').textContent));
        send(svg, 'click', 0.1, 0.99);
        hold('a row of the map picks its parameter', figure.querySelector('select').selectedIndex === every('option', figure).length - 1);
        const sums = every('.rows tr', figure).map(row => parseFloat(row.children[1].textContent));
        hold('the shares of the joints sum to one', Math.abs(sums.reduce((a, b) => a + b, 0) - 100) < 1 + 0.5 * sums.length);
    };
    addEventListener('load', () => setTimeout(() => {
        [plots, robot, map].forEach(use => { try { use(); } catch (e) { wrong.push(`${e.stack}`); } });
        const wide = every('body *').filter(e => e.getBoundingClientRect().right > innerWidth + 1 && !e.closest('.wide') && !e.closest('svg'));
        hold(`nothing is wider than ${innerWidth}: ${document.documentElement.scrollWidth} ${wide.slice(0, 3).map(e => e.outerHTML.slice(0, 80))}`, document.documentElement.scrollWidth <= innerWidth);
        hold('a joint leads to the next', every('.beside-joints a').every(a => document.querySelector(a.getAttribute('href'))));
        parent.postMessage(JSON.stringify({ wrong, width: innerWidth, dark: matchMedia('(prefers-color-scheme: dark)').matches, live: every('svg.live').length }), '*');
    }, 100));
}</script>";

/// The output of Chromium with the options of every run and the options `more`; `None` if Chromium is missing.
fn chromium(more: &[&str]) -> Option<std::process::Output> {
    let profile = folder("chromium").join("profile");
    let profile = format!("--user-data-dir={}", profile.display());
    // All addresses fail to resolve, so a network request causes an error on the console.
    let fixed = [
        "--headless",
        "--no-sandbox",
        "--disable-gpu",
        "--hide-scrollbars",
        "--no-first-run",
        "--host-resolver-rules=MAP * ~NOTFOUND",
    ];
    Command::new("chromium").args(fixed).arg(profile).args(more).output().ok()
}

/// The failed checks that the script `USE` sends for a page in a frame of this width, in pixels; `None` if Chromium is missing.
fn used(page: &Path, width: usize, dark: bool) -> Option<Value> {
    let html = std::fs::read_to_string(page).unwrap();
    let html = html.replacen("<head>", &format!("<head>{WATCH}"), 1).replacen("</body>", &format!("{USE}</body>"), 1);
    let (inside, around) = (page.with_extension("used.html"), page.with_extension("around.html"));
    std::fs::write(&inside, html).unwrap();
    let frame = format!(
        "<!doctype html><meta name=\"color-scheme\" content=\"light dark\"><pre id=said></pre><iframe src=\"{}\" width={width} height=900></iframe><script>addEventListener('message', e => {{ \
         document.getElementById('said').textContent = e.data; }});</script>",
        inside.file_name().unwrap().to_str().unwrap()
    );
    std::fs::write(&around, frame).unwrap();
    let address = format!("file://{}", around.display());
    let scheme = format!("--blink-settings=preferredColorScheme={}", usize::from(!dark));
    let out = chromium(&["--window-size=1500,1000", "--virtual-time-budget=3000", &scheme, "--dump-dom", &address])?;
    let dom = String::from_utf8(out.stdout).unwrap();
    let said = dom
        .split("id=\"said\">")
        .nth(1)
        .and_then(|rest| rest.split("</pre>").next())
        .unwrap_or_else(|| panic!("{dom}"));
    let said = said.replace("&lt;", "<").replace("&gt;", ">").replace("&amp;", "&");
    Some(serde_json::from_str(&said).unwrap_or_else(|e| panic!("{e}: {said} of {} {width}", page.display())))
}

#[test]
fn pages_work_in_a_browser() {
    let here = folder("browser");
    let arm = write_rubbed(&here.join("a.csv"), 0.4);
    let made = |arguments: &[&str]| rist(&here, arguments).ended(0);
    made(&["identify", &arm, "a.csv", "--report", "estimate.html", "--out", "e.yaml"]);
    let limited = here.join("limited.yaml").display().to_string();
    std::fs::write(&limited, tests::program::LIMITED_ARM).unwrap();
    made(&["replay", &arm, "e.yaml", "a.csv", "--anyway", "--report", "replay.html"]);
    made(&["excite", &limited, "--starts", "1", "--iterations", "4", "--out", "m.yaml", "--report", "motion.html"]);
    made(&["plan", &arm, "--out", "plan.yaml"]);
    made(&["report", "--plan", "plan.yaml", "--out", "plan.html"]);
    let sheet = rist(&here, &["inspect", &model_path("ur5.urdf").display().to_string(), "--format", "html"]);
    std::fs::write(here.join("robot.html"), sheet.out).unwrap();
    let pages = [
        ("estimate.html", true),
        ("replay.html", true),
        ("motion.html", true),
        ("plan.html", false),
        ("robot.html", false),
    ];
    for (page, is_live) in pages {
        for (width, dark) in [(400, false), (900, true), (1400, false)] {
            let Some(said) = used(&here.join(page), width, dark) else {
                println!("skipped: no chromium");
                return;
            };
            assert_eq!(said["wrong"].as_array().map(Vec::len), Some(0), "{page} {width}: {said}");
            assert_eq!((said["width"].as_u64(), said["dark"].as_bool()), (Some(width as u64), Some(dark)), "{page}");
            assert_eq!(said["live"].as_u64() > Some(0), is_live, "{page}");
        }
        let pdf = here.join("printed.pdf");
        let address = format!("file://{}", here.join(page).display());
        chromium(&[&format!("--print-to-pdf={}", pdf.display()), &address]);
        assert!(std::fs::metadata(&pdf).unwrap().len() > 10_000, "{page} is not printed");
        std::fs::remove_file(&pdf).unwrap();
    }
}
