//! Tables and texts for notebooks.

/// A table with a title and a head; every cell is text.
pub fn table(title: &str, head: &[&str], rows: impl Iterator<Item = Vec<String>>) -> String {
    let row = |tag: &str, cells: &mut dyn Iterator<Item = String>| {
        let cells: String = cells.map(|c| format!("<{tag}>{}</{tag}>", escaped(&c))).collect();
        format!("<tr>{cells}</tr>")
    };
    let head = row("th", &mut head.iter().map(|c| c.to_string()));
    let rows: String = rows.map(|cells| row("td", &mut cells.into_iter())).collect();
    format!("<table><caption>{}</caption>{head}{rows}</table>", escaped(title))
}

/// A text as it stands.
pub fn text(text: &str) -> String {
    format!("<pre>{}</pre>", escaped(text))
}

fn escaped(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;")
}
