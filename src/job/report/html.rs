//! What all report pages share: one style, pictures inside the page, tables. A page has no links to
//! anything outside.

use std::fmt::Write;

use base64::Engine;
use base64::engine::general_purpose::STANDARD;

use crate::io::markup::escaped;

const STYLE: &str = "body{font:15px/1.45 system-ui,sans-serif;color:#1c1c22;background:#fff;\
max-width:72rem;margin:2rem auto;padding:0 1rem}h1{font-size:1.5rem}h2{font-size:1.1rem;\
margin-top:2rem}table{border-collapse:collapse}td,th{padding:.2rem .9rem .2rem 0;text-align:left;\
border-bottom:1px solid #ddd;vertical-align:top}td.n,th.n{text-align:right;\
font-variant-numeric:tabular-nums}td.n,td:first-child{white-space:nowrap}.row{display:flex;flex-wrap:wrap;gap:1rem}figure{margin:0;width:440px;max-width:100%}\
.grid{display:grid;grid-template-columns:repeat(auto-fill,minmax(280px,1fr));gap:1rem}\
.grid figure{width:auto}figcaption{color:#555;font-size:.9rem}img,svg{max-width:100%;height:auto}.good{color:#176b2c}\
.doubtful{color:#955b00}.failed{color:#a11}ul.notes{background:#fff6e0;padding:.6rem 1rem .6rem 2rem}\
i.colour{display:inline-block;width:.8em;height:.8em;margin-right:.5em}";

/// A page; `title` is text, `body` HTML. `lengths`: in whose unit they are.
pub(crate) fn page(title: &str, lengths: &str, body: &str) -> String {
    format!(
        "<!DOCTYPE html>\n<html lang=\"en\"><head><meta charset=\"utf-8\">\
         <meta name=\"viewport\" content=\"width=device-width\"><title>moulage: {}</title>\
         <style>{STYLE}</style></head><body>\n{body}<p>moulage {}. Lengths are in {lengths} unit.</p></body></html>\n",
        escaped(title),
        env!("CARGO_PKG_VERSION")
    )
}

/// What to know, one item for each text.
pub(crate) fn notes(list: &[String]) -> String {
    if list.is_empty() {
        return String::new();
    }
    let items: Vec<String> =
        list.iter().map(|note| format!("<li>{}</li>", escaped(note))).collect();
    format!("<ul class=\"notes\">{}</ul>\n", items.concat())
}

/// A PNG file with what it shows.
pub(crate) fn image(png: &[u8], alt: &str) -> String {
    format!("<img alt=\"{alt}\" src=\"data:image/png;base64,{}\">", STANDARD.encode(png))
}

/// A picture with a caption, both HTML.
pub(crate) fn figure(content: &str, caption: &str) -> String {
    format!("<figure>{content}<figcaption>{caption}</figcaption></figure>\n")
}

/// A PNG file with a caption.
pub(crate) fn picture(png: &[u8], caption: &str) -> String {
    figure(&image(png, caption), caption)
}

/// The head of a column.
#[derive(Clone, Copy)]
pub(crate) enum Column<'a> {
    /// Of words.
    Text(&'a str),
    /// Of numbers.
    Number(&'a str),
}

/// A table; each row has a cell of HTML for each column.
pub(crate) fn table(columns: &[Column], rows: impl IntoIterator<Item = Vec<String>>) -> String {
    let class = |column: &Column| match column {
        Column::Text(_) => "",
        Column::Number(_) => " class=\"n\"",
    };
    let mut html = String::from("<table><tr>");
    for column in columns {
        let (Column::Text(head) | Column::Number(head)) = column;
        let _ = write!(html, "<th{}>{head}</th>", class(column));
    }
    html.push_str("</tr>\n");
    for row in rows {
        html.push_str("<tr>");
        for (cell, column) in row.iter().zip(columns) {
            let _ = write!(html, "<td{}>{cell}</td>", class(column));
        }
        html.push_str("</tr>\n");
    }
    html + "</table>\n"
}

/// A word in the colour of its class: good, doubtful or failed.
pub(crate) fn marked(class: &str, text: &str) -> String {
    format!("<span class=\"{class}\">{text}</span>")
}

/// Three significant digits, three decimals from 1 on.
pub(crate) fn number(value: f64) -> String {
    match value.abs() {
        v if v == 0.0 || v >= 1.0 => format!("{value:.3}"),
        v if v >= 1e-4 => {
            let decimals = (2.0 - libm::log10(v).floor()) as usize;
            format!("{value:.decimals$}")
        }
        _ => format!("{value:.2e}"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_keep_three_digits() {
        let written: Vec<String> = [0.0, 12.3456, 0.080_48, 0.001_234_5, 1.2e-7].map(number).into();
        assert_eq!(written, ["0.000", "12.346", "0.0805", "0.00123", "1.20e-7"]);
    }

    #[test]
    fn a_table_has_a_cell_for_each_column() {
        let html = table(&[Column::Text("a"), Column::Number("b")], [vec!["x".into(), "1".into()]]);
        assert_eq!(
            html.replace('\n', ""),
            "<table><tr><th>a</th><th class=\"n\">b</th></tr><tr><td>x</td><td class=\"n\">1</td></tr></table>"
        );
    }
}
