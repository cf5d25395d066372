//! Reports as one HTML file each: styles and pictures are in it, and nothing is fetched or run.
//!
//! Text is escaped wherever it enters, so that a [`Html`] is always well-formed. Pictures drawn in
//! [`INK`], [`GRID`] and [`PAPER`] change with the reader's light or dark scheme.

use std::fmt::Write;

/// The style sheet of every page.
const STYLE: &str = include_str!("style.css");

/// The colour of text and axes in pictures, which the dark scheme turns light.
pub const INK: [u8; 3] = [0x22, 0x22, 0x22];

/// The colour of grid lines in pictures, which the dark scheme turns dark.
pub const GRID: [u8; 3] = [0xe2, 0xe2, 0xe2];

/// The background of pictures, which the dark scheme turns dark.
pub const PAPER: [u8; 3] = [0xff, 0xff, 0xff];

/// What an SVG names its namespace by: HTML knows it without.
const NAMESPACE: &str = r#" xmlns="http://www.w3.org/2000/svg""#;

/// A piece of a page.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Html(String);

impl Html {
    /// The text, as it stands in the file.
    pub fn as_str(&self) -> &str {
        &self.0
    }
}

impl FromIterator<Html> for Html {
    fn from_iter<I: IntoIterator<Item = Html>>(parts: I) -> Self {
        Self(parts.into_iter().map(|part| part.0).collect())
    }
}

/// A part of a page under a heading of its own.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Section {
    /// The heading, as plain text.
    pub heading: String,
    /// What stands below it.
    pub body: Html,
}

impl Section {
    /// A section of several pieces.
    pub fn new(heading: impl Into<String>, body: impl IntoIterator<Item = Html>) -> Self {
        Self { heading: heading.into(), body: body.into_iter().collect() }
    }
}

/// A whole page.
pub fn page(title: &str, sections: &[Section]) -> String {
    let title = escape(title);
    let mut body = format!("<h1>{title}</h1>\n");
    for Section { heading, body: Html(inside) } in sections {
        let heading = escape(heading);
        // Writing to a string cannot fail.
        let _ = write!(body, "<section>\n<h2>{heading}</h2>\n{inside}</section>\n");
    }
    format!(
        "<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n<meta \
         name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n<title>{title}</title>\n\
         <style>\n{STYLE}</style>\n</head>\n<body>\n<main>\n{body}</main>\n</body>\n</html>\n"
    )
}

/// A paragraph of plain text.
pub fn paragraph(text: &str) -> Html {
    Html(format!("<p>{}</p>\n", escape(text)))
}

/// A list of plain texts.
pub fn list<S: AsRef<str>>(items: &[S]) -> Html {
    let items = items.iter().map(|item| format!("<li>{}</li>\n", escape(item.as_ref())));
    Html(format!("<ul>\n{}</ul>\n", items.collect::<String>()))
}

/// Text in which lines and spaces count, such as commands.
pub fn preformatted(text: &str) -> Html {
    Html(format!("<pre>{}</pre>\n", escape(text)))
}

/// A piece that shows itself when its summary is clicked, and in print.
pub fn details(summary: &str, body: Html) -> Html {
    Html(format!("<details>\n<summary>{}</summary>\n{}</details>\n", escape(summary), body.0))
}

/// A table of plain texts; cells that start as numbers do are set to the right.
pub fn table<H: AsRef<str>>(header: &[H], rows: &[Vec<String>]) -> Html {
    let cell = |name: &str, text: &str, numeric: bool| {
        let class = if numeric { " class=\"number\"" } else { "" };
        format!("<{name}{class}>{}</{name}>", escape(text))
    };
    let heads_numbers = |column: usize| rows.first().is_some_and(|row| is_numeric(&row[column]));
    let head = header.iter().enumerate();
    let head: String =
        head.map(|(column, text)| cell("th", text.as_ref(), heads_numbers(column))).collect();
    let cell = |text: &String| cell("td", text, is_numeric(text));
    let row =
        |row: &Vec<String>| format!("<tr>{}</tr>\n", row.iter().map(cell).collect::<String>());
    let body: String = rows.iter().map(row).collect();
    Html(format!(
        "<div class=\"wide\"><table>\n<thead><tr>{head}</tr></thead>\n<tbody>\n{body}</tbody>\n\
         </table></div>\n"
    ))
}

/// A picture with its caption: `svg` is what an SVG file of this project holds.
pub fn figure(svg: &str, caption: &str) -> Html {
    let start = svg.find("<svg").unwrap_or(0);
    let svg = svg[start..].replacen(NAMESPACE, "", 1);
    let caption = escape(caption);
    Html(format!("<figure>\n{svg}\n<figcaption>{caption}</figcaption>\n</figure>\n"))
}

/// `text` with what HTML would take for itself written out.
pub fn escape(text: &str) -> String {
    let mut out = String::with_capacity(text.len());
    for c in text.chars() {
        match c {
            '&' => out.push_str("&amp;"),
            '<' => out.push_str("&lt;"),
            '>' => out.push_str("&gt;"),
            '"' => out.push_str("&quot;"),
            '\'' => out.push_str("&#39;"),
            _ => out.push(c),
        }
    }
    out
}

fn is_numeric(text: &str) -> bool {
    let digits = text.trim_start_matches(['+', '-', '−']);
    digits.starts_with(|c: char| c.is_ascii_digit())
}

#[cfg(test)]
mod tests;
