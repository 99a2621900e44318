//! Tests of the page of an identification: its structure, its texts, and its safety against names that contain HTML.

use super::*;
use identification::estimate::identified::{Deviations, Identified};
use identification::estimate::validation::TorquePicture;
use linear_model::unit::Unit;

#[test]
fn the_page_stands_alone() {
    let plan = ExperimentPlan { coordinates: vec!["q<1>".into()], ..ExperimentPlan::default() };
    let estimate = Estimate {
        model: "arm & co".into(),
        parameters: vec![
            Identified::new("ZZR1".parse().unwrap(), Unit::INERTIA, 0.3, Deviations::white(0.01)),
            Identified::unidentifiable("FV1".parse().unwrap(), Unit::VISCOUS, 0.0),
        ],
        tenths: vec![0.1, 0.2],
        ..Estimate::default()
    };
    let picture = TorquePicture {
        coordinate: "q<1>".into(),
        t: vec![0.0, 1.0],
        measured: vec![1.0, 2.0],
        predicted: vec![1.1, 1.9],
    };
    let validation = Validation { pictures: vec![picture], ..Validation::default() };
    let page = Page { plan: Some(&plan), estimate: Some(&estimate), validation: Some(&validation), ..Page::default() };
    let html = page.html();
    assert!(!html.contains("could not be made"), "{html}");
    assert!(html.contains("arm &amp; co") && html.contains("Torque of q&lt;1&gt;") && html.contains("ZZR1"));
    assert!(html.contains("not identifiable") && html.contains("0.300"), "{html}");
    // The page loads no file. The only address in it is the name of the SVG namespace.
    assert_eq!(html.matches("http").count(), html.matches("http://www.w3.org/2000/svg").count());
    // The page has one additional SVG, with the clip paths of the charts.
    assert_eq!(html.matches("<svg").count(), page.pictures().len() + 1);
    assert!(!Page::default().html().contains("<h2"), "{}", Page::default().html());
}

/// Makes a page with all sections and with names that contain markup, and passes its HTML to `see`.
fn whole_page(see: impl FnOnce(&str)) {
    let robot = robot::format::read_yaml(crate::test_page::ARM, "arm.yaml").unwrap();
    let mut derivation = modeling::Derivation::new(&robot).unwrap();
    let standard = derivation.regressor();
    let parameters = derivation.base_parameters(&standard).unwrap();
    let subject = Subject { robot: &robot, parameters: &parameters, described: None };
    let (plot_data, estimate, verdict) =
        (crate::test_page::plot_data(), crate::test_page::estimate(), crate::test_page::verdict());
    let page = Page {
        subject: Some(subject),
        estimate: Some(&estimate),
        plot_data: Some(&plot_data),
        verdict: Some(&verdict),
        ..Page::default()
    };
    let html = page.html();
    see(&html);
}

/// The scripts that the page executes, without its data.
fn scripts(html: &str) -> Vec<&str> {
    html.split("<script>").skip(1).map(|rest| rest.split("</script>").next().unwrap()).collect()
}

#[test]
fn a_page_is_alive_within_its_room() {
    whole_page(|html| {
        assert!(!html.contains("could not be made"), "{html}");
        // Data is removed before the search for `NaN`, because encoded letters may contain the text `NaN` by chance.
        let shown = html.split("<script type=\"application/json\"").map(|part| part.split("</script>").last().unwrap());
        assert!(shown.clone().count() > 2 && shown.clone().all(|part| !part.contains("NaN")), "{html}");
        let [script] = scripts(html)[..] else { panic!("one script") };
        assert!(script.len() <= 20_000, "{}", script.len());
        for part in
            ["const Plots=", "const Maps=", "const Drawing=", "id=\"time-log\"", "class=\"legend\"", "class=\"map\""]
        {
            assert!(html.contains(part), "{part}");
        }
        // The page loads no file. The only address in it is the name of the SVG namespace; it has no attribute src and no import.
        assert_eq!(html.matches("http").count(), html.matches("http://www.w3.org/2000/svg").count());
        for word in [" src=", "url(h", "url(d", "url(\"", "@import", "import(", "fetch(", "XMLHttp", "WebSocket"] {
            assert!(!html.contains(word), "{word}");
        }
    });
}

#[test]
fn names_are_no_markup() {
    whole_page(|html| {
        assert!(!html.contains("q</script>") && !html.contains("<b>\u{202e}") && !html.contains('\u{202e}'));
        assert!(html.replace("&#x2f;", "/").contains("q&lt;/script&gt;&lt;b&gt;\\u{202e}"));
        let json =
            html.split("<script type=\"application/json\">").skip(1).map(|s| s.split("</script>").next().unwrap());
        let parsed: Vec<serde_json::Value> = json.map(|text| serde_json::from_str(text).unwrap()).collect();
        assert_eq!(parsed.len(), 2);
    });
}

#[test]
fn grades_are_by_purpose_and_joint() {
    whole_page(|html| {
        let (_, part) = html.split_once("<section id=\"grades\">").unwrap();
        let part = part.split("</section>").next().unwrap();
        for expected in [
            "gravity compensation",
            "1.23\u{202f}%, q2 3.40\u{202f}%",
            "0.4 deg would show",
            "cannot tell",
            "contradicted",
        ] {
            assert!(part.contains(expected), "{expected}: {part}");
        }
        assert!(part.contains("title=\"cannot tell: zero of q"), "{part}");
    });
}

#[test]
fn headings_are_those_of_the_page() {
    let plan = ExperimentPlan::default();
    let (of_logs, of_experiments) = (crate::test_page::estimate(), Estimate::default());
    let validation = Validation::default();
    let other = OtherEstimate { name: "monday.yaml", estimate: &of_logs };
    let kinds = [
        (Page { estimate: Some(&of_logs), against: Some(other), ..Page::default() }, "Two estimates compared"),
        (Page { plan: Some(&plan), ..Page::default() }, "Plan of experiments"),
        (Page { validation: Some(&validation), ..Page::default() }, "Validation"),
        (
            Page { estimate: Some(&of_experiments), plan: Some(&plan), ..Page::default() },
            "Identified dynamics, from experiments",
        ),
        (Page { estimate: Some(&of_logs), validation: Some(&validation), ..Page::default() }, "Identified dynamics"),
    ];
    for (page, kind) in kinds {
        let html = page.html();
        assert!(html.contains(&format!("<h1><span class=\"kind\">{kind}</span>")), "{kind}");
        assert!(html.contains(&format!(": {}</title>", kind.to_lowercase())), "{kind}");
    }
}
