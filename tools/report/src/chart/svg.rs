//! An SVG element under construction.
//!
//! Written by hand, for a reason: plotting crates draw with fixed colours and font metrics of their
//! own, some by a script. These pictures take every colour from the page's style sheet, so that one
//! file serves light, dark and paper; they hold no script; and their bytes are the same on every
//! machine, which tests rely on.

use std::fmt::Write;

/// Text safe inside HTML and SVG, in attributes too.
pub fn escape(text: &str) -> String {
    let mut safe = String::with_capacity(text.len());
    for character in text.chars() {
        match character {
            '&' => safe.push_str("&amp;"),
            '<' => safe.push_str("&lt;"),
            '>' => safe.push_str("&gt;"),
            '"' => safe.push_str("&quot;"),
            '\'' => safe.push_str("&#39;"),
            _ => safe.push(character),
        }
    }
    safe
}

/// Where a text begins.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Anchor {
    Start,
    Middle,
    End,
}

/// An SVG element. Coordinates are px, with one decimal.
#[derive(Debug)]
pub struct Svg {
    text: String,
}

impl Svg {
    /// An empty picture, described by `label` for who cannot see it.
    pub fn new(width: f64, height: f64, label: &str) -> Self {
        let label = escape(label);
        Self {
            text: format!(
                "<svg viewBox=\"0 0 {width:.0} {height:.0}\" role=\"img\" aria-label=\"{label}\">"
            ),
        }
    }

    /// A straight line.
    pub fn line(&mut self, class: &str, from: (f64, f64), to: (f64, f64)) {
        self.add(format_args!(
            "<path class=\"{class}\" d=\"M{:.1} {:.1}L{:.1} {:.1}\"/>",
            from.0, from.1, to.0, to.1
        ));
    }

    /// A rectangle by its upper left corner and size, with a tooltip if `title` says something.
    pub fn rect(&mut self, class: &str, corner: (f64, f64), size: (f64, f64), title: &str) {
        let (x, y) = corner;
        let (width, height) = (size.0.max(0.0), size.1.max(0.0));
        let head = format!(
            "<rect class=\"{class}\" x=\"{x:.1}\" y=\"{y:.1}\" width=\"{width:.1}\" \
             height=\"{height:.1}\""
        );
        if title.is_empty() {
            self.add(format_args!("{head}/>"));
        } else {
            self.add(format_args!("{head}><title>{}</title></rect>", escape(title)));
        }
    }

    /// A curve through the points of each run.
    pub fn curve(&mut self, class: &str, runs: &[Vec<(f64, f64)>]) {
        let mut path = String::new();
        for run in runs {
            for (index, (x, y)) in run.iter().enumerate() {
                let command = if index == 0 { 'M' } else { 'L' };
                write!(path, "{command}{x:.1} {y:.1}").expect("a string takes all");
            }
            // A lone point is a dot: round caps draw a segment of no length.
            if let [(x, y)] = run.as_slice() {
                write!(path, "L{x:.1} {y:.1}").expect("a string takes all");
            }
        }
        self.add(format_args!("<path class=\"{class}\" d=\"{path}\"/>"));
    }

    /// A text with its baseline at `at`.
    pub fn text(&mut self, class: &str, anchor: Anchor, at: (f64, f64), text: &str) {
        let anchor = match anchor {
            Anchor::Start => "start",
            Anchor::Middle => "middle",
            Anchor::End => "end",
        };
        self.add(format_args!(
            "<text class=\"{class}\" text-anchor=\"{anchor}\" x=\"{:.1}\" y=\"{:.1}\">{}</text>",
            at.0,
            at.1,
            escape(text)
        ));
    }

    /// A ring with a tooltip.
    pub fn ring(&mut self, at: (f64, f64), title: &str) {
        self.add(format_args!(
            "<circle class=\"ring\" cx=\"{:.1}\" cy=\"{:.1}\" r=\"4\"><title>{}</title></circle>",
            at.0,
            at.1,
            escape(title)
        ));
    }

    /// A numbered disc.
    pub fn badge(&mut self, at: (f64, f64), number: usize) {
        self.add(format_args!(
            "<circle class=\"badge\" cx=\"{:.1}\" cy=\"{:.1}\" r=\"8\"/>",
            at.0, at.1
        ));
        self.text("number", Anchor::Middle, (at.0, at.1 + 3.7), &number.to_string());
    }

    /// The whole element.
    pub fn finish(mut self) -> String {
        self.text.push_str("</svg>");
        self.text
    }

    fn add(&mut self, part: std::fmt::Arguments<'_>) {
        self.text.write_fmt(part).expect("a string takes all");
    }
}

/// Width that a text of the pictures' size takes, px, on the safe side.
pub fn text_width(text: &str) -> f64 {
    7.0 * text.chars().count() as f64
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn markup_in_texts_stays_text() {
        let mut svg = Svg::new(10.0, 10.0, "\"a\" <b>");
        svg.text("x", Anchor::Start, (0.0, 0.0), "<script>&'");
        let text = svg.finish();
        assert!(text.contains("&quot;a&quot; &lt;b&gt;"), "{text}");
        assert!(text.contains("&lt;script&gt;&amp;&#39;") && !text.contains("<script"), "{text}");
    }
}
