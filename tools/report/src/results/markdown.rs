//! A result as Markdown, for the summary of a continuous integration job.

use super::document::{Document, Part};
use super::table::Table;

const MOST_ROWS: usize = 200;

impl Document {
    pub fn markdown(&self) -> String {
        let mark = if self.ok { "✅" } else { "❌" };
        let mut text = format!("## {}\n\n{mark} {}\n", escape(&self.title), escape(&self.verdict));
        if !self.about.is_empty() {
            text += &format!("\n{}\n", escape(&self.about));
        }
        if !self.broken.is_empty() {
            text.push('\n');
        }
        for broken in self.broken.iter().take(MOST_ROWS) {
            text += &format!("- {}\n", escape(&broken.line()));
        }
        for part in &self.parts {
            match part {
                Part::Table(table) if table.is_on_pages() => text += &self::table(table),
                Part::Facts(heading, facts) => {
                    text += &format!("\n### {}\n\n| | |\n| --- | --- |\n", escape(heading));
                    for (name, value) in facts {
                        text += &format!("| {} | {} |\n", escape(name), escape(value));
                    }
                }
                Part::Text(words) => text += &format!("\n{}\n", escape(words)),
                _ => {}
            }
        }
        text
    }
}

fn table(table: &Table) -> String {
    let mut text = format!("\n### {}\n", escape(&table.heading));
    for (name, rows) in table.row_blocks() {
        if !name.is_empty() {
            text += &format!("\n#### {}\n", escape(&name));
        }
        let shown = table.shown(&rows);
        let titles: Vec<_> =
            shown.iter().map(|&place| escape(&table.columns[place].title())).collect();
        let rules: Vec<_> = shown
            .iter()
            .map(|&place| if table.columns[place].is_number() { "---:" } else { "---" })
            .collect();
        text += &format!("\n| {} |\n| {} |\n", titles.join(" | "), rules.join(" | "));
        let best: Vec<_> = shown.iter().map(|&place| table.best(place, &rows)).collect();
        for row in rows.clone().take(MOST_ROWS) {
            let cells = shown.iter().zip(&best).map(|(&place, best)| {
                let (head, value) = (&table.columns[place], &table.rows[row][place]);
                let cell = escape(&head.text(value));
                match (head.judgement(value), best) {
                    (Some(false), _) => format!("❌ {cell}"),
                    (_, Some(best)) if *best == head.text(value) && table.is_good(row) => {
                        format!("**{cell}**")
                    }
                    _ => cell,
                }
            });
            text += &format!("| {} |\n", cells.collect::<Vec<_>>().join(" | "));
        }
        if rows.len() > MOST_ROWS {
            text += &format!("\n{} more rows.\n", rows.len() - MOST_ROWS);
        }
    }
    text
}

/// Text that Markdown does not read.
fn escape(text: &str) -> String {
    let mut escaped = String::new();
    for letter in text.chars() {
        match letter {
            '|' | '*' | '_' | '`' | '<' | '[' | '\\' | '#' => escaped.extend(['\\', letter]),
            '\n' => escaped.push(' '),
            letter => escaped.push(letter),
        }
    }
    escaped
}
