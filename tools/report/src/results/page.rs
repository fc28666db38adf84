//! A result as a page: verdict, figures at a glance, tables, pictures.

use super::document::{Broken, Document, Part};
use super::table::Table;
use crate::chart::escape;
use crate::html::{Cell, Column, document, section, stacked_table, table, tiles};

const MOST_ROWS: usize = 1_000;

impl Document {
    pub fn page(&self) -> String {
        let parts: String = self.parts.iter().map(part).collect();
        let body = broken(&self.broken) + &parts;
        document(&self.title, &self.about, self.ok, &self.verdict, &body)
    }
}

/// What broke; empty without a finding.
fn broken(all: &[Broken]) -> String {
    if all.is_empty() {
        return String::new();
    }
    let heads = [("what broke", Column::Text), ("repeat by", Column::Text)];
    let rows: Vec<Vec<String>> = (all.iter().take(MOST_ROWS))
        .map(|broken| vec![broken.what.clone(), broken.command.clone()])
        .collect();
    section("What broke", &stacked_table(&heads, &rows))
}

fn part(part: &Part) -> String {
    match part {
        Part::Table(table) if !table.is_on_pages() => String::new(),
        Part::Table(table) => blocks(table),
        Part::Figures(heading, html) if heading.is_empty() => html.clone(),
        Part::Figures(heading, html) => section(heading, html),
        Part::Text(text) => text.lines().map(|line| format!("<p>{}</p>\n", escape(line))).collect(),
        Part::Tiles(all) => tiles(all),
        Part::Facts(heading, facts) => {
            let rows: Vec<Vec<String>> =
                facts.iter().map(|(name, value)| vec![name.clone(), value.clone()]).collect();
            section(heading, &stacked_table(&[("", Column::Text), ("", Column::Text)], &rows))
        }
    }
}

fn blocks(all: &Table) -> String {
    let block = |(name, rows): (String, std::ops::Range<usize>)| {
        let shown = all.shown(&rows);
        let titles: Vec<String> = shown.iter().map(|&place| all.columns[place].title()).collect();
        let kinds = shown.iter().map(|&place| {
            let head = &all.columns[place];
            match (head.is_number(), head.weight > 0) {
                (true, false) => Column::Number,
                (true, true) => Column::MoreNumber,
                (false, false) => Column::Text,
                (false, true) => Column::MoreText,
            }
        });
        let heads: Vec<_> = titles.iter().map(String::as_str).zip(kinds).collect();
        let best: Vec<_> = shown.iter().map(|&place| all.best(place, &rows)).collect();
        let cells: Vec<Vec<Cell>> = (rows.clone().take(MOST_ROWS))
            .map(|row| {
                let cells = shown.iter().zip(&best);
                cells.map(|(&place, best)| cell(all, row, place, best.as_deref())).collect()
            })
            .collect();
        let marked = best.iter().any(Option::is_some);
        let note = if marked { "<p class=\"quiet\">★ best of its column</p>\n" } else { "" };
        let more = match rows.len().saturating_sub(MOST_ROWS) {
            0 => String::new(),
            more => format!("<p class=\"quiet\">{more} more rows are in the JSON.</p>\n"),
        };
        let figures = all.figures.iter().filter(|(of, _)| *of == name);
        let figures: String = figures.map(|(_, html)| html.as_str()).collect();
        let gap = if figures.is_empty() { "" } else { "<div class=\"gap\"></div>\n" };
        let heading = if name.is_empty() { &all.heading } else { &name };
        section(heading, &format!("{}{note}{more}{gap}{figures}", table(&heads, &cells)))
    };
    all.row_blocks().into_iter().map(block).collect()
}

fn cell(table: &Table, row: usize, place: usize, best: Option<&str>) -> Cell {
    let (head, value) = (&table.columns[place], &table.rows[row][place]);
    let text = head.text(value);
    match head.judgement(value) {
        Some(false) => Cell::Bad(text),
        _ if best == Some(text.as_str()) && table.is_good(row) => Cell::Best(text),
        Some(true) => Cell::Good(text),
        None => Cell::Plain(text),
    }
}
