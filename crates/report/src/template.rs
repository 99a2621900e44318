//! Templates to text. They are compiled in; one that fails is a defect that the tests find.

use minijinja::syntax::SyntaxConfig;
use minijinja::value::Serde;
use minijinja::{Environment, UndefinedBehavior};
use serde::Serialize;

/// A page from its template and its content. Text of the content is escaped, but for what is marked as safe there.
pub fn rendered(template: &str, content: impl Serialize) -> String {
    let mut environment = Environment::new();
    environment.set_undefined_behavior(UndefinedBehavior::Strict);
    // The template's indentation and lines of tags are not the page's.
    if let Ok(syntax) = SyntaxConfig::builder().trim_blocks(true).lstrip_blocks(true).build() {
        environment.set_syntax(syntax);
    }
    environment.set_auto_escape_callback(|_| minijinja::AutoEscape::Html);
    match environment.render_str(template, Serde(content)) {
        Ok(text) => text,
        Err(e) => format!("<!doctype html><p>this page could not be made: {e:#}</p>\n"),
    }
}
