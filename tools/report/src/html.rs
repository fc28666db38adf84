//! The page around the pictures.
//!
//! A page is a fixed frame around five elements: section, figure, tiles, table, details. Each of them is one function
//! here that escapes its input. `format!` writes them, not a template engine. A macro crate would check the nesting of
//! tags and add a compiler stage. The test of the finished page does the same for less.

use super::chart::{Chart, escape, script_json};
use std::fmt::Write;

/// Licence of the library that draws the charts.
const LICENCE: &str = include_str!("../assets/uplot/LICENSE");
/// Text of a page without scripts, instead of its charts.
const NO_SCRIPT: &str = "<noscript><style>.chart, .plane { display: none; }</style><p class=\"quiet\">The \
                         charts need JavaScript; verdict and tables are complete without \
                         it.</p></noscript>\n";
/// Room that a chart takes beside its axes, px.
const CHART_FRAME_PX: f64 = 118.0;

/// Style sheet of a page with charts.
pub fn style() -> String {
    format!("{}\n{}", include_str!("../assets/uplot/uPlot.min.css"), include_str!("style.css"))
}

/// The scripts that draw the charts: the library below its licence, and ours.
pub fn scripts() -> String {
    let library = include_str!("../assets/uplot/uPlot.iife.min.js");
    // Its first comment is its address, and a page names no place outside itself.
    let library = library.split_once("*/").map_or(library, |(_, code)| code);
    let shapes = include_str!("../assets/shapes.js");
    let charts = include_str!("../assets/charts.js");
    format!(
        "<script>/*! uPlot 1.6.32\n\n{LICENCE}*/{library}</script>\n<script>\n{shapes}{charts}</script>\n"
    )
}

/// The frame of a page. It loads nothing: what it needs is in it.
fn page(title: &str, body: &str) -> String {
    let mut scripts = if body.contains("<figure ") { scripts() } else { String::new() };
    if body.contains("<figure class=\"card plane\">") {
        scripts += concat!("<script>\n", include_str!("../assets/plane.js"), "</script>\n");
    }
    format!(
        "<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n\
         <meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n\
         <title>{}</title>\n<style>\n{}</style>\n</head>\n<body>\n<main>\n{body}</main>\n{scripts}\
         </body>\n</html>\n",
        escape(title),
        style(),
    )
}

/// A whole page under its heading and verdict.
pub fn document(title: &str, about: &str, good: bool, verdict: &str, body: &str) -> String {
    let class = if good { "good" } else { "bad" };
    let (heading, about, verdict) = (escape(title), escape(about), escape(verdict));
    let no_script = if body.contains("<figure ") { NO_SCRIPT } else { "" };
    let body = format!(
        "<header>\n<h1>{heading}</h1>\n<p class=\"quiet\">{about}</p>\n\
         <p class=\"verdict {class}\">{verdict}</p>\n{no_script}</header>\n{body}\
         <footer>timegap {}</footer>\n",
        env!("CARGO_PKG_VERSION"),
    );
    page(&format!("{title} · timegap"), &body)
}

pub fn section(heading: &str, body: &str) -> String {
    format!("<section>\n<h2>{}</h2>\n{body}</section>\n", escape(heading))
}

/// Pictures beside each other; nothing where there is none.
pub fn grid(drawn: &str) -> String {
    if drawn.is_empty() { String::new() } else { format!("<div class=\"grid\">\n{drawn}</div>\n") }
}

/// A picture with its title, as data that the page's script draws.
pub fn figure(picture: impl Into<Chart>) -> String {
    let chart = picture.into();
    let title = escape(&chart.title);
    let height = chart.height + CHART_FRAME_PX;
    format!(
        "<figure class=\"card chart\">\n<figcaption><h3>{title}</h3></figcaption>\n\
         <div class=\"plot\" role=\"img\" aria-label=\"{title}\" style=\"min-height:{height:.0}px\">\
         </div>\n<script type=\"application/json\">{}</script>\n</figure>\n",
        script_json(&chart),
    )
}

/// A figure that is read at a glance.
#[derive(Clone, Debug, PartialEq)]
pub struct Tile {
    pub label: &'static str,
    pub value: String,
    /// A remark below it.
    pub note: String,
}

/// Figures beside each other.
///
/// ```
/// use report::html::{Tile, tiles};
///
/// let gap = Tile { label: "Smallest gap", value: "8.3 m".into(), note: String::new() };
/// assert!(tiles(&[gap]).contains("<dd>8.3 m</dd>"));
/// ```
pub fn tiles(tiles: &[Tile]) -> String {
    let mut text = String::from("<dl class=\"tiles\">\n");
    for Tile { label, value, note } in tiles {
        let note = if note.is_empty() {
            String::new()
        } else {
            format!(" <span class=\"note\">{}</span>", escape(note))
        };
        writeln!(
            text,
            "<div class=\"tile\"><dt>{}</dt><dd>{}{note}</dd></div>",
            escape(label),
            escape(value)
        )
        .expect("a string takes all");
    }
    text + "</dl>\n"
}

/// Alignment of a column of a table.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Column {
    Text,
    Number,
    /// Numbers that a narrow page leaves out.
    MoreNumber,
    /// Words that a narrow page leaves out.
    MoreText,
}

impl Column {
    const fn class(self) -> &'static str {
        match self {
            Self::Text => "",
            Self::Number => " class=\"n\"",
            Self::MoreNumber => " class=\"n more\"",
            Self::MoreText => " class=\"more\"",
        }
    }
}

#[derive(Clone, Debug, PartialEq)]
pub enum Cell {
    Plain(String),
    /// A check that held.
    Good(String),
    /// A check that did not.
    Bad(String),
    /// The best value of its column.
    Best(String),
}

impl From<String> for Cell {
    fn from(text: String) -> Self {
        Self::Plain(text)
    }
}

pub fn table<C: Clone + Into<Cell>>(head: &[(&str, Column)], rows: &[Vec<C>]) -> String {
    classed_table("", head, rows)
}

/// A table whose first column, on a narrow page, stands above the others of its row.
pub fn stacked_table<C: Clone + Into<Cell>>(head: &[(&str, Column)], rows: &[Vec<C>]) -> String {
    classed_table("stacked", head, rows)
}

fn classed_table<C: Clone + Into<Cell>>(
    class: &str,
    head: &[(&str, Column)],
    rows: &[Vec<C>],
) -> String {
    let mut text = format!("<div class=\"card scroll\"><table class=\"{class}\">\n<tr>");
    for (name, column) in head {
        write!(text, "<th{}>{}</th>", column.class(), escape(name)).expect("a string takes all");
    }
    for row in rows {
        text.push_str("</tr>\n<tr>");
        for ((_, column), cell) in head.iter().zip(row) {
            let inner = match cell.clone().into() {
                Cell::Plain(text) => escape(&text),
                Cell::Good(text) => format!("<b class=\"good\">{}</b>", escape(&text)),
                Cell::Bad(text) => format!("<b class=\"bad\">{}</b>", escape(&text)),
                Cell::Best(text) => format!("<b>★ {}</b>", escape(&text)),
            };
            write!(text, "<td{}>{inner}</td>", column.class()).expect("a string takes all");
        }
    }
    text + "</tr>\n</table></div>\n"
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::chart::{Curve, Plot, Tone};

    /// Relative luminance (WCAG 2.2).
    fn luminance(colour: &str) -> f64 {
        let channel = |at: usize| {
            let value = u8::from_str_radix(&colour[at..at + 2], 16).expect("two hex digits");
            let value = f64::from(value) / 255.0;
            if value <= 0.04045 { value / 12.92 } else { ((value + 0.055) / 1.055).powf(2.4) }
        };
        0.2126 * channel(1) + 0.7152 * channel(3) + 0.0722 * channel(5)
    }

    fn contrast(a: &str, b: &str) -> f64 {
        let (a, b) = (luminance(a), luminance(b));
        (a.max(b) + 0.05) / (a.min(b) + 0.05)
    }

    /// The colours of a theme by name: 0 light, 1 dark.
    fn colours(theme: usize) -> std::collections::BTreeMap<&'static str, &'static str> {
        let block = include_str!("style.css").split(":root").nth(theme + 1).expect("two themes");
        let block = block.split('}').next().expect("a block ends");
        let pairs = block.split(';').filter_map(|pair| pair.trim().split_once(": #"));
        pairs
            .map(|(name, _)| {
                let at = block.find(&format!("{name}: #")).expect("it was just seen");
                (name, &block[at + name.len() + 2..at + name.len() + 9])
            })
            .collect()
    }

    #[test]
    fn text_and_lines_stand_out_in_both_themes() {
        for theme in [0, 1] {
            let colours = colours(theme);
            for ground in ["--page", "--card"] {
                for text in ["--text", "--quiet", "--good", "--bad"] {
                    let contrast = contrast(colours[text], colours[ground]);
                    assert!(contrast >= 4.5, "{text} on {ground}, theme {theme}: {contrast:.1}");
                }
            }
            let lines = ["--t0", "--t1", "--t2", "--t3", "--t4", "--t5", "--t6", "--t7"];
            for line in lines.into_iter().chain(["--muted", "--go", "--clear", "--stop"]) {
                let contrast = contrast(colours[line], colours["--card"]);
                assert!(contrast >= 3.0, "{line}, theme {theme}: {contrast:.1}");
            }
            // The numbers of marks are card-coloured on the alarm's colour.
            assert!(contrast(colours["--alarm"], colours["--card"]) >= 4.5);
        }
    }

    #[test]
    fn a_page_loads_nothing_and_says_what_it_needs() {
        let evil = "</script><img src=y>";
        let curve = Curve::new(evil, Tone::Series(0), vec![(0.0, 1.0), (1.0, 2.0)]);
        let plot = Plot::over_time(evil, 1.0, "m", vec![curve]);
        let body =
            table(&[("x", Column::Text)], &[vec!["<img src=y>".to_owned()]]) + &figure(&plot);
        let text = document("a <title>", "", true, "", &body);
        for sign in ["http:", "https:", "@import", "url(", "<img", "<link", "src=\""] {
            assert!(!text.contains(sign), "{sign}");
        }
        assert!(text.contains("a &lt;title&gt;"));
        for sign in ["<noscript>", "Permission is hereby granted", "Leon Sorokin"] {
            assert!(text.contains(sign), "{sign}");
        }
        // Library, ours, data.
        assert_eq!(text.matches("</script>").count(), 3);
        let bare = document("a", "", true, "", "<p>no chart</p>");
        assert!(!bare.contains("<script"), "no chart, no script");
    }
}
