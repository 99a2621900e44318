//! Renders templates to text. The templates are part of the program, so tests find their errors.

use gate::shown;
use minijinja::syntax::SyntaxConfig;
use minijinja::value::{Serde, Value};
use minijinja::{AutoEscape, Environment, UndefinedBehavior, escape_formatter};
use serde::Serialize;

/// Renders an HTML page from its template and its content. Texts are escaped, unless they are marked as safe.
pub(crate) fn rendered(template: &str, content: impl Serialize) -> String {
    let failed = |e: minijinja::Error| format!("<!doctype html><p>this page could not be made: {e:#}</p>\n");
    environment(AutoEscape::Html).render_str(template, Serde(content)).unwrap_or_else(failed)
}

/// Renders a LaTeX template. In the template, the filter `tex` escapes texts, and the filter `tex_rule` formats regrouping
/// rules.
pub(crate) fn latex(template: &str, content: impl Serialize) -> String {
    let failed = |e: minijinja::Error| format!("this text could not be made: {e:#}\n");
    environment(AutoEscape::None).render_str(template, Serde(content)).unwrap_or_else(failed)
}

/// Renders a Markdown template. Every text is escaped; the filter `code` formats a text as code.
pub(crate) fn markdown(template: &str, content: impl Serialize) -> String {
    let failed = |e: minijinja::Error| format!("this text could not be made: {e:#}\n");
    let mut environment = environment(AutoEscape::None);
    environment.set_formatter(|out, state, value| match value.as_str().filter(|_| !value.is_safe()) {
        Some(text) => escape_formatter(out, state, &Value::from(shown::markdown(text))),
        None => escape_formatter(out, state, value),
    });
    environment.render_str(template, Serde(content)).unwrap_or_else(failed)
}

fn environment(escape: AutoEscape) -> Environment<'static> {
    let mut environment = Environment::new();
    environment.set_undefined_behavior(UndefinedBehavior::Strict);
    // Removes the indentation and the lines of template tags from the output.
    if let Ok(syntax) = SyntaxConfig::builder().trim_blocks(true).lstrip_blocks(true).build() {
        environment.set_syntax(syntax);
    }
    environment.set_auto_escape_callback(move |_| escape.clone());
    environment.set_formatter(|out, state, value| {
        match value.as_str().filter(|text| text.contains(shown::is_hidden)) {
            Some(text) if !value.is_safe() => escape_formatter(out, state, &Value::from(&*shown::lines(text))),
            _ => escape_formatter(out, state, value),
        }
    });
    environment.add_test("none", |value: &Value| value.is_none());
    environment.add_filter("join", |texts: Vec<String>, between: &str| texts.join(between));
    environment.add_filter("length", |value: &Value| value.len());
    environment.add_filter("replace", |text: &str, from: &str, to: &str| text.replace(from, to));
    environment.add_filter("round", |x: f64, digits: i32| (x * 10f64.powi(digits)).round() / 10f64.powi(digits));
    environment.add_filter("code", |text: String| Value::from_safe_string(shown::markdown_code(&text)));
    environment.add_filter("tex", |text: String| tex(&text));
    environment.add_filter("tex_rule", |text: String| tex_rule(&text));
    environment
}

/// Escapes the characters that have a special meaning in LaTeX.
fn tex(text: &str) -> String {
    let escaped = |c: char| match c {
        '_' | '%' | '&' | '#' | '$' | '{' | '}' => format!("\\{c}"),
        '^' => "\\^{}".into(),
        '\\' => "\\textbackslash{}".into(),
        c => c.to_string(),
    };
    text.chars().map(escaped).collect()
}

/// A regrouping rule as a LaTeX formula: thin spaces for products, upright functions, line breaks after plus and minus.
fn tex_rule(rule: &str) -> String {
    if rule.is_empty() {
        return String::new();
    }
    let text = tex(rule).replace("\\^{}", "^").replace('*', "\\,").replace("sin(", "\\sin(").replace("cos(", "\\cos(");
    format!("${}$", text.replace(" + ", " +\\allowbreak ").replace(" - ", " -\\allowbreak "))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rules_are_mathematics() {
        assert_eq!(tex_rule("XXR1 = XX1 - L1^2*M2"), "$XXR1 = XX1 -\\allowbreak L1^2\\,M2$");
        assert_eq!(tex("a_b 50 %"), "a\\_b 50 \\%");
    }

    #[test]
    fn what_is_not_there_is_said() {
        assert!(rendered("{{ nothing }}", ()).contains("could not be made"));
        assert!(latex("{{ nothing }}", ()).contains("could not be made"));
        assert!(markdown("{{ nothing }}", ()).contains("could not be made"));
    }

    #[test]
    fn no_text_is_markup() {
        #[derive(Serialize)]
        struct PageContext {
            x: &'static str,
        }
        let content = || PageContext { x: "<b>|[a](b)`*\u{202e}\u{1b}" };
        assert_eq!(rendered("{{ x }}", content()), "&lt;b&gt;|[a](b)`*\\u{202e}\\u{1b}");
        let escaped = "&lt;b&gt;\\|\\[a\\](b)\\`\\*\\\\u{202e}\\\\u{1b}";
        assert_eq!(markdown("{{ x }}", content()), escaped);
        assert_eq!(markdown("{{ x|code }}", content()), "`<b>\\|[a](b)'*\\u{202e}\\u{1b}`");
    }
}
