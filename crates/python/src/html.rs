//! HTML tables and texts for notebooks.
//!
//! A notebook calls `_repr_html_` of an object to show it.

/// A table with a title and a head row. The text of every cell is escaped.
pub fn table(title: &str, head: &[&str], rows: impl Iterator<Item = Vec<String>>) -> String {
    let row = |tag: &str, cells: &mut dyn Iterator<Item = String>| {
        let cells: String = cells.map(|c| format!("<{tag}>{}</{tag}>", escaped(&c))).collect();
        format!("<tr>{cells}</tr>")
    };
    let head = row("th", &mut head.iter().map(|c| c.to_string()));
    let rows: String = rows.map(|cells| row("td", &mut cells.into_iter())).collect();
    format!("<table><caption>{}</caption>{head}{rows}</table>", escaped(title))
}

/// Largest page that is shown in a notebook, bytes. It is limited because the file of the notebook stores the page.
const LARGEST_PAGE_BYTES: usize = 2 << 20;

/// An HTML page in an iframe, so that its style and script do not affect the notebook. `None` if the page is too large.
pub fn frame(page: &str) -> Option<String> {
    let page = (page.len() <= LARGEST_PAGE_BYTES).then(|| page.replace('&', "&amp;").replace('"', "&quot;"))?;
    Some(format!(
        "<iframe srcdoc=\"{page}\" sandbox=\"allow-scripts allow-downloads\" title=\"rist\" \
         style=\"width: 100%; height: 640px; border: 1px solid #8884\"></iframe>"
    ))
}

/// Sentences as a list.
pub fn list(texts: &[String]) -> String {
    let items: String = texts.iter().map(|text| format!("<li>{}</li>", escaped(text))).collect();
    format!("<ul>{items}</ul>")
}

/// A text whose line breaks are kept.
pub fn text(text: &str) -> String {
    format!("<pre style=\"white-space: pre-wrap\">{}</pre>", escaped(text))
}

fn escaped(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;")
}
