//! One self-contained HTML page with the plan, the parameters and the torques.

use std::fmt::Write;

use crate::estimate::artefact::Estimate;
use crate::estimate::identified::{INTERVAL, Identified, Status};
use crate::estimate::validation::{TorquePicture, Validation};
use crate::experiments::experiment_plan::ExperimentPlan;
use crate::write::svg::{Line, Row, chart, escaped, table};

/// Measured and predicted torque of one joint over time: figure 2(a-c).
pub fn torque_picture(picture: &TorquePicture) -> String {
    let line = |name, y| Line { name, x: picture.t.as_slice(), y };
    let lines = [line("measured", picture.measured.as_slice()), line("predicted", picture.predicted.as_slice())];
    chart(&format!("Torque of {}", picture.coordinate), "time, s", "torque, N m", &lines)
}

/// The table of parameters with their intervals: figure 2(d).
pub fn parameter_picture(estimate: &Estimate) -> String {
    let row = |p: &'_ Identified| -> (String, String, Option<(f64, f64)>, &'static str) {
        let sigma = p.sigma.unwrap_or(0.0);
        let remark = match p.status {
            Status::NotSignificant => "zero is inside",
            Status::Weak => "weak",
            Status::Identified | Status::NotIdentifiable => "",
        };
        (p.id.to_string(), p.unit.to_string(), p.value.map(|v| (v, INTERVAL * sigma)), remark)
    };
    let cells: Vec<_> = estimate.parameters.iter().map(row).collect();
    let rows: Vec<Row> = cells.iter().map(|(n, u, v, r)| Row { name: n, unit: u, value: *v, remark: r }).collect();
    table(&format!("Parameters of {}", estimate.model), &rows)
}

/// The page; each part is left out where its artefact is not given.
pub fn report(plan: Option<&ExperimentPlan>, estimate: Option<&Estimate>, validation: Option<&Validation>) -> String {
    let name = estimate
        .map(|e| e.model.as_str())
        .or(plan.map(|p| p.model.name.as_str()))
        .or(validation.map(|v| v.model.name.as_str()))
        .unwrap_or("robot");
    let mut s = format!(
        "<!doctype html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n\
         <meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n<title>{0}: identification</title>\n\
         <style>\nbody {{ font: 15px/1.5 system-ui, sans-serif; max-width: 760px; margin: 2em auto; padding: 0 1em; color: #222; }}\n\
         table {{ border-collapse: collapse; }}\ntd, th {{ padding: .15em .8em .15em 0; text-align: left; }}\n\
         td.n, th.n {{ text-align: right; font-variant-numeric: tabular-nums; }}\n\
         svg {{ max-width: 100%; height: auto; margin: .6em 0; }}\n.note {{ color: #666; }}\n</style>\n</head>\n<body>\n\
         <h1>{0}</h1>\n",
        escaped(name)
    );
    if let Some(plan) = plan {
        add_plan(&mut s, plan);
    }
    if let Some(estimate) = estimate {
        add_estimate(&mut s, estimate);
    }
    if let Some(validation) = validation {
        add_validation(&mut s, validation);
    }
    s.push_str("</body>\n</html>\n");
    s
}

fn add_plan(s: &mut String, plan: &ExperimentPlan) {
    // A String never fails to grow.
    let _ = writeln!(
        s,
        "<h2>Experiments</h2>\n<p>{} experiments out of {} candidates; rank {} of {}. D-efficiency at least {:.3}; \
         cond<sub>fro</sub> {:.1}, below which no plan falls: {:.1}.</p>",
        plan.experiments.len(),
        plan.candidates,
        plan.rank,
        plan.parameters.len(),
        plan.d_efficiency_at_least,
        plan.cond_fro,
        plan.cond_fro_at_least
    );
    s.push_str("<table>\n<tr><th></th><th>kind</th><th>fast</th><th>slow</th><th>about, rad</th><th class=n>rank</th><th class=n>log det</th></tr>\n");
    for e in &plan.experiments {
        let centre: Vec<String> = e.centre.iter().map(|q| format!("{q:.2}")).collect();
        let gain = e.adds_log_det.map_or(String::new(), |g| format!("+{g:.2}"));
        let _ = writeln!(
            s,
            "<tr><td>{}</td><td>{}</td><td>{}</td><td>{}</td><td>{}</td><td class=n>{}</td><td class=n>{gain}</td></tr>",
            escaped(&e.name),
            escaped(&e.kind),
            escaped(&e.fast),
            escaped(&e.slow.join(", ")),
            centre.join(", "),
            e.rank
        );
    }
    s.push_str("</table>\n");
    let lost: Vec<String> = plan.unidentifiable().iter().map(|id| id.to_string()).collect();
    if !lost.is_empty() {
        let _ = writeln!(s, "<p>Not identifiable with this plan: {}.</p>", escaped(&lost.join(", ")));
    }
}

fn add_estimate(s: &mut String, estimate: &Estimate) {
    let _ = writeln!(s, "<h2>Parameters</h2>\n<p>{}</p>", escaped(&estimate.method));
    s.push_str(&parameter_picture(estimate));
    for remark in &estimate.remarks {
        let _ = writeln!(s, "<p class=note>{}</p>", escaped(remark));
    }
}

fn add_validation(s: &mut String, validation: &Validation) {
    let _ = writeln!(
        s,
        "<h2>Validation</h2>\n<p>{} motions that were not used; low-pass {} Hz; error over all {:.2} %.</p>",
        validation.motions.len(),
        validation.cutoff_hz,
        100.0 * validation.total
    );
    s.push_str("<table>\n<tr><th>joint</th><th class=n>error, %</th><th class=n>without friction, %</th><th class=n>rms</th><th class=n>not white, %</th></tr>\n");
    let percent = |x: Option<f64>, digits: usize| x.map_or(String::new(), |x| format!("{:.digits$}", 100.0 * x));
    for j in &validation.joints {
        let _ = writeln!(
            s,
            "<tr><td>{}</td><td class=n>{}</td><td class=n>{}</td><td class=n>{:.4} {}</td><td class=n>{}</td></tr>",
            escaped(&j.coordinate),
            percent(Some(j.relative), 2),
            percent(j.relative_rigid, 2),
            j.rms,
            j.unit,
            percent(j.not_white, 0)
        );
    }
    s.push_str("</table>\n");
    validation.pictures.iter().for_each(|p| s.push_str(&torque_picture(p)));
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::estimate::identified::Deviations;
    use crate::model::unit::Unit;

    #[test]
    fn the_page_stands_alone() {
        let plan = ExperimentPlan { coordinates: vec!["q<1>".into()], ..ExperimentPlan::default() };
        let estimate = Estimate {
            model: "arm & co".into(),
            parameters: vec![Identified::new("ZZR1".parse().unwrap(), Unit::INERTIA, 0.3, Deviations::white(0.01))],
            ..Estimate::default()
        };
        let picture = TorquePicture {
            coordinate: "q<1>".into(),
            t: vec![0.0, 1.0],
            measured: vec![1.0, 2.0],
            predicted: vec![1.1, 1.9],
        };
        let validation = Validation { pictures: vec![picture], ..Validation::default() };
        let page = report(Some(&plan), Some(&estimate), Some(&validation));
        assert!(page.contains("arm &amp; co") && page.contains("Torque of q&lt;1&gt;") && page.contains("ZZR1"));
        assert_eq!(page.matches("<svg").count(), 2);
        // The page loads nothing: its only address is the name of the SVG language.
        assert_eq!(page.matches("http").count(), page.matches("http://www.w3.org/2000/svg").count());
        assert_eq!(report(None, None, None).matches("<h2>").count(), 0);
    }
}
