//! One page, complete in itself: text, figures with the tables behind them, no network.
//!
//! Tested by `tests/paths/report/page.rs`.

use std::fmt::Write as _;
use std::path::Path;

use super::{ReportError, number, write_file};
use crate::plot::{Figure, Layout, Plot};
use crate::saving::file;

/// A table is cut to about so many rows on the page; its file has all.
const ROWS: usize = 120;
/// Width and height of a drawing without its legend. Half the width of a large screen and all of a small one
/// show its letters at a legible size.
const DRAWN: (i32, i32) = (440, 310);

/// A page in the making: [`Document::write`] writes it with the files of its figures.
#[derive(Clone, Debug, Default)]
pub struct Document {
    title: String,
    parts: Vec<PageItem>,
}

#[derive(Clone, Debug)]
enum PageItem {
    Heading(String),
    Text(String),
    List(Vec<String>),
    Table { caption: String, headings: Vec<String>, rows: Vec<Vec<String>> },
    Figure(Figure),
}

impl Document {
    /// An empty page.
    pub fn new(title: impl Into<String>) -> Self {
        Self { title: title.into(), parts: vec![] }
    }

    /// Adds a heading.
    #[must_use]
    pub fn heading(mut self, text: impl Into<String>) -> Self {
        self.parts.push(PageItem::Heading(text.into()));
        self
    }

    /// Adds a paragraph of plain text.
    #[must_use]
    pub fn text(mut self, text: impl Into<String>) -> Self {
        self.parts.push(PageItem::Text(text.into()));
        self
    }

    /// Adds a list of sentences.
    #[must_use]
    pub fn list(mut self, sentences: impl IntoIterator<Item = impl Into<String>>) -> Self {
        self.parts.push(PageItem::List(sentences.into_iter().map(Into::into).collect()));
        self
    }

    /// Adds a table. A cell that begins with ✓, ◐ or ✗ is coloured as good, in part, or bad.
    #[must_use]
    pub fn table(
        mut self,
        caption: impl Into<String>,
        headings: Vec<String>,
        rows: Vec<Vec<String>>,
    ) -> Self {
        self.parts.push(PageItem::Table { caption: caption.into(), headings, rows });
        self
    }

    /// Adds a figure.
    #[must_use]
    pub fn figure(mut self, figure: Figure) -> Self {
        self.parts.push(PageItem::Figure(figure));
        self
    }

    /// The page.
    ///
    /// # Errors
    /// [`ReportError::Plot`].
    pub fn html(&self) -> Result<String, ReportError> {
        let mut body = self.contents();
        let mut section = 0;
        for part in &self.parts {
            match part {
                PageItem::Heading(text) => {
                    section += 1;
                    body += &format!("<h2 id=\"section-{section}\">{}</h2>\n", escaped(text));
                }
                PageItem::Text(text) => body += &format!("<p>{}</p>\n", escaped(text)),
                PageItem::List(items) => {
                    body += "<ul>\n";
                    items.iter().for_each(|item| body += &format!("<li>{}</li>\n", escaped(item)));
                    body += "</ul>\n";
                }
                PageItem::Table { caption, headings, rows } => body += &table(caption, headings, rows),
                PageItem::Figure(figure) => body += &drawn(figure)?,
            }
        }
        let title = escaped(&self.title);
        let (style, script) = (include_str!("assets/page.css"), include_str!("assets/page.js"));
        Ok(format!(
            "<!doctype html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n\
             <meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n\
             <meta name=\"color-scheme\" content=\"light dark\">\n<link rel=\"icon\" href=\"data:,\">\n\
             <title>{title}</title>\n<style>\n{style}</style>\n</head>\n<body>\n<main>\n<h1>{title}</h1>\n{body}</main>\n\
             <div id=\"tip\" role=\"status\" hidden></div>\n<script>\n{script}</script>\n</body>\n</html>\n"
        ))
    }

    /// The headings as links, where there are some.
    fn contents(&self) -> String {
        let headings = self.parts.iter().filter_map(|part| match part {
            PageItem::Heading(text) => Some(text),
            _ => None,
        });
        let entries: Vec<String> = headings
            .enumerate()
            .map(|(i, text)| format!("<li><a href=\"#section-{}\">{}</a></li>\n", i + 1, escaped(text)))
            .collect();
        match entries.len() {
            0..3 => String::new(),
            _ => format!("<nav aria-label=\"Contents\"><ol>\n{}</ol></nav>\n", entries.concat()),
        }
    }

    /// Writes `index.html` and, for each figure, `<id>.svg`, `<id>.png` and `<id>.csv` into a folder, which
    /// is made if it is not there.
    ///
    /// # Errors
    /// [`ReportError::File`] with the path that could not be written, [`ReportError::Plot`].
    pub fn write(&self, folder: impl AsRef<Path>) -> Result<(), ReportError> {
        let folder = folder.as_ref();
        file::create_folder(folder)?;
        for part in &self.parts {
            if let PageItem::Figure(figure) = part {
                let path = |ending: &str| folder.join(format!("{}.{ending}", figure.id));
                figure.write(path("svg"))?;
                figure.write(path("png"))?;
                write_file(&path("csv"), &figure.csv())?;
            }
        }
        write_file(&folder.join("index.html"), self.html()?.as_bytes())
    }
}

/// A figure: plot, sentence, table.
fn drawn(figure: &Figure) -> Result<String, ReportError> {
    let (id, title) = (escaped(&figure.id), escaped(&figure.title));
    let plot = svg(figure, &Plot::new(figure, Layout::untitled(figure, DRAWN), 1))?;
    let (headings, rows) = figure.table();
    let stride = rows.len().div_ceil(ROWS).max(1);
    let caption = match stride {
        1 => format!("The numbers behind “{}”", figure.title),
        _ => {
            format!("One in {stride} of the numbers behind “{}”; all are in {}.csv", figure.title, figure.id)
        }
    };
    let rows: Vec<_> = rows.into_iter().step_by(stride).collect();
    Ok(format!(
        "<figure id=\"{id}\" aria-labelledby=\"{id}-title\">\n<h3 id=\"{id}-title\">{title}</h3>\n\
         {plot}<figcaption>{}</figcaption>\n\
         <details><summary>Numbers</summary>\n{}<p class=\"files\">Files: {id}.csv, {id}.svg, {id}.png</p></details>\n</figure>\n",
        escaped(&figure.shows),
        table(&caption, &headings, &rows)
    ))
}

/// A drawing that shows the numbers of a point under the pointer.
fn svg(figure: &Figure, plot: &Plot<'_>) -> Result<String, ReportError> {
    let alternative = format!(
        "Plot of {} against {}: {}. The numbers are in the table below.",
        figure.y.label,
        figure.x.label,
        figure.series.iter().map(|series| series.name.as_str()).collect::<Vec<_>>().join(", ")
    );
    // Within a page the name space is implied, and the drawing has a name of its own for readers of screens.
    let svg = plot.svg()?;
    let open = svg.find("<svg").unwrap_or(0);
    let inner = svg[open..].find('>').map_or("", |end| &svg[open + end + 1..]);
    let inner = inner.trim_end().trim_end_matches("</svg>");
    let mut points = String::new();
    for placed in plot.placed() {
        let Some(series) = figure.series.get(placed.series) else { continue };
        let Some((x, y)) = series.points.get(placed.index) else { continue };
        let mut tip =
            format!("{}: {} {}, {} {}", series.name, figure.x.label, number(*x), figure.y.label, number(*y));
        if let Some(note) = series.notes.get(placed.index).filter(|note| !note.is_empty()) {
            tip += &format!("; {note}");
        }
        let tip = escaped(&tip);
        let focus = if series.marked() { " tabindex=\"0\"" } else { "" };
        let _ = writeln!(
            points,
            "<circle class=\"point\" cx=\"{}\" cy=\"{}\" r=\"9\" role=\"img\" aria-label=\"{tip}\" data-tip=\"{tip}\"{focus}></circle>",
            placed.at.0, placed.at.1
        );
    }
    let (width, height) = plot.size();
    Ok(format!(
        "<div class=\"plot\"><svg viewBox=\"0 0 {width} {height}\" role=\"group\" aria-label=\"{}\">\n\
         <g aria-hidden=\"true\">{inner}</g>\n<g>{points}</g></svg></div>\n",
        escaped(&alternative)
    ))
}

fn table(caption: &str, headings: &[String], rows: &[Vec<String>]) -> String {
    let mut text = format!(
        "<p class=\"hint\">Wide tables scroll sideways.</p>\n<div class=\"table\" tabindex=\"0\" role=\"region\" aria-label=\"{0}\"><table>\n<caption><span>{0}</span></caption>\n<thead><tr>",
        escaped(caption)
    );
    for heading in headings {
        text += &format!("<th scope=\"col\">{}</th>", escaped(heading));
    }
    text += "</tr></thead>\n<tbody>\n";
    for row in rows {
        text += "<tr>";
        for (column, cell) in row.iter().enumerate() {
            let tag = if column == 0 { "th scope=\"row\"" } else { "td" };
            let end = if column == 0 { "th" } else { "td" };
            let class = match cell.chars().next() {
                Some('✓') => " class=\"good\"",
                Some('◐') => " class=\"part\"",
                Some('✗') => " class=\"bad\"",
                _ => "",
            };
            text += &format!("<{tag}{class}>{}</{end}>", escaped(cell));
        }
        text += "</tr>\n";
    }
    text + "</tbody>\n</table></div>\n"
}

/// Text as HTML, also within quotes.
fn escaped(text: &str) -> String {
    let mut safe = String::with_capacity(text.len());
    for c in text.chars() {
        match c {
            '&' => safe += "&amp;",
            '<' => safe += "&lt;",
            '>' => safe += "&gt;",
            '"' => safe += "&quot;",
            '\'' => safe += "&#39;",
            _ => safe.push(c),
        }
    }
    safe
}
