//! A table on a terminal, never wider than it.
//!
//! A table that is too wide is transposed. If it is still too wide, it loses the columns of the largest weight, and a
//! line names them. At last the cells of its first column are broken behind dots and spaces.
//!
//! A table that is too long keeps its bad rows, then its first and its last ones.

use serde_json::Value;
use std::ops::Range;

use super::head::Format;
use super::table::{Fact, Table};
use crate::table::{Align, TextTable};

/// Width if standard output is not a terminal.
const USUAL_WIDTH: usize = 80;
/// Most rows that become columns.
const MOST_TRANSPOSED: usize = 8;
/// Rows at the end of a table that is shortened.
const LAST_ROWS: usize = 4;
/// Rows of all blocks of a table together.
const MOST_ROWS: usize = 120;
const MOST_BLOCKS: usize = 20;
/// Mark of the best value of a column.
const BEST: &str = "*";

/// Width of the terminal; 80 columns for a pipe.
pub fn width() -> usize {
    let size = console::Term::stdout().size_checked();
    size.map_or(USUAL_WIDTH, |(_, columns)| usize::from(columns).max(40))
}

/// Words in lines of at most `width`, indented; the lines after the first by two more.
///
/// ```
/// assert_eq!(report::results::folded("a verdict in words", 2, 14), "  a verdict in\n    words\n");
/// ```
pub fn folded(words: &str, indent: usize, width: usize) -> String {
    let mut lines = vec![" ".repeat(indent)];
    for word in words.split(' ') {
        let line = lines.last_mut().expect("there is a first line");
        let is_empty = line.trim().is_empty();
        if !is_empty && line.chars().count() + 1 + word.chars().count() > width {
            lines.push(" ".repeat(indent + 2) + word);
        } else {
            *line += &format!("{}{word}", if is_empty { "" } else { " " });
        }
    }
    lines.join("\n") + "\n"
}

/// Facts as lines of name and value in at most `width` columns.
pub(super) fn facts(facts: &[Fact], width: usize) -> String {
    let longest = facts.iter().map(|(name, _)| name.chars().count()).max().unwrap_or(0);
    let begin = longest + 4;
    let lines = facts.iter().flat_map(|(name, value)| {
        let value = folded(value, 0, width.saturating_sub(begin).max(20));
        let lines = value.lines().enumerate().map(|(place, line)| match place {
            0 => format!("  {name:<longest$}  {line}\n"),
            _ => format!("{:begin$}{line}\n", ""),
        });
        lines.collect::<Vec<_>>()
    });
    lines.collect()
}

/// A cell in lines of at most `most` characters, or of one part: broken behind dots and spaces.
fn broken(cell: &str, most: usize) -> String {
    let mut lines = vec![String::new()];
    for part in cell.split_inclusive(['.', ' ']) {
        let line = lines.last_mut().expect("there is a first line");
        let is_too_long = line.chars().count() + part.trim_end().chars().count() > most;
        if is_too_long && !line.is_empty() {
            lines.push(format!("  {part}"));
        } else {
            *line += part;
        }
    }
    lines.iter().map(|line| line.trim_end()).collect::<Vec<_>>().join("\n")
}

/// Characters of the longest line.
fn widest(text: &str) -> usize {
    text.lines().map(|line| line.chars().count()).max().unwrap_or(0)
}

impl Table {
    /// The table as text in at most `width` columns. Long tables are cut.
    pub fn console(&self, width: usize) -> String {
        let blocks = self.row_blocks();
        let shown = blocks.iter().take(MOST_BLOCKS);
        let text: String = shown.map(|(name, rows)| self.block_text(name, rows, width)).collect();
        match blocks.len().saturating_sub(MOST_BLOCKS) {
            0 => text,
            more => text + &format!("and {more} more blocks\n"),
        }
    }

    /// True if a terminal does not show all rows.
    pub(super) fn is_cut(&self) -> bool {
        let blocks = self.row_blocks();
        blocks.len() > MOST_BLOCKS || blocks.iter().any(|(_, rows)| rows.len() > self.most())
    }

    /// Most rows of a block that a terminal shows.
    fn most(&self) -> usize {
        let blocks = self.row_blocks().len().clamp(1, MOST_BLOCKS);
        self.most_rows.min(MOST_ROWS / blocks)
    }

    fn block_text(&self, name: &str, rows: &Range<usize>, width: usize) -> String {
        let heading = match (name, self.block) {
            ("", None) => String::new(),
            ("", Some(_)) => folded(&self.heading, 0, width),
            (name, _) => folded(name, 0, width),
        };
        let shown = self.shown(rows);
        let (long, mut short): (Vec<usize>, Vec<usize>) =
            shown.into_iter().partition(|&place| self.columns[place].is_long());
        if !long.is_empty() {
            return heading + &self.listed(rows, &short, &long, width);
        }
        let upright = self.upright(rows, &short, usize::MAX);
        if widest(&upright) <= width {
            return heading + &upright;
        }
        if rows.len() <= MOST_TRANSPOSED {
            let transposed = self.transposed(rows, &short);
            if widest(&transposed) <= width {
                return heading + &transposed;
            }
        }
        let mut left_out: Vec<usize> = Vec::new();
        let text = loop {
            let upright = self.upright(rows, &short, usize::MAX);
            let excess = widest(&upright).saturating_sub(width);
            if excess == 0 {
                break upright;
            }
            let heaviest = (0..short.len()).max_by_key(|&k| (self.columns[short[k]].weight, k));
            match heaviest.filter(|&k| self.columns[short[k]].weight > 0) {
                Some(place) => left_out.push(short.remove(place)),
                None => {
                    let firsts = self.chosen(rows).into_iter().flatten();
                    let firsts = firsts.map(|row| self.cell(row, short[0], None).chars().count());
                    let most = firsts.max().unwrap_or(0).saturating_sub(excess);
                    let narrowed = self.upright(rows, &short, most);
                    if widest(&narrowed) <= width {
                        break narrowed;
                    }
                    return heading + &self.listed(rows, &short[..1], &short[1..], width);
                }
            }
        };
        if left_out.is_empty() {
            return heading + &text;
        }
        left_out.sort_unstable();
        let names: Vec<_> =
            left_out.iter().map(|&place| self.columns[place].heading.as_ref()).collect();
        let note = format!("(on the page: {})", names.join(", "));
        heading + &text + &folded(&note, 2, width)
    }

    /// The cell, marked when it is the best; `marked` columns leave room for the mark in every cell.
    fn cell(&self, row: usize, place: usize, best: Option<&str>) -> String {
        let text = self.columns[place].text(&self.rows[row][place]);
        match best {
            Some(best) if best == text && self.is_good(row) => text + BEST,
            _ => text,
        }
    }

    /// Rows of the block that are shown; `None` stands for those that are left out.
    fn chosen(&self, rows: &Range<usize>) -> Vec<Option<usize>> {
        let most = self.most();
        if rows.len() <= most {
            return rows.clone().map(Some).collect();
        }
        let is_bad = |row: &usize| !self.is_good(*row);
        let bad: Vec<usize> = rows.clone().filter(is_bad).take(most).collect();
        let room = most - bad.len();
        let last = LAST_ROWS.min(room / 2);
        let others = rows.clone().filter(|row| !is_bad(row));
        let count = others.clone().count();
        let kept =
            others.enumerate().filter(|(place, _)| *place < room - last || *place >= count - last);
        let mut kept: Vec<usize> = bad.into_iter().chain(kept.map(|(_, row)| row)).collect();
        kept.sort_unstable();
        // The note stands in the first gap.
        let gap = kept.iter().zip(rows.clone()).take_while(|(kept, row)| *kept == row).count();
        let (before, behind) = kept.split_at(gap);
        let some = |rows: &[usize]| rows.iter().copied().map(Some).collect::<Vec<_>>();
        [some(before), vec![None], some(behind)].concat()
    }

    /// The upright table; cells of its first column have at most `most` characters in a line, if they can be broken.
    fn upright(&self, rows: &Range<usize>, shown: &[usize], most: usize) -> String {
        let titles: Vec<String> = shown.iter().map(|&place| self.columns[place].title()).collect();
        let align = |place: &usize| match self.columns[*place].is_number() {
            true => Align::Right,
            false => Align::Left,
        };
        let best: Vec<_> = shown.iter().map(|&place| self.best(place, rows)).collect();
        let heads = titles.iter().zip(&best).map(|(title, best)| match best {
            // Over the numbers, not over their marks.
            Some(_) => format!("{title} "),
            None => title.clone(),
        });
        let heads: Vec<String> = heads.collect();
        let mut table =
            TextTable::new(heads.iter().map(String::as_str).zip(shown.iter().map(align)));
        for row in self.chosen(rows) {
            let Some(row) = row else {
                let more = rows.len() - self.most();
                table.row(["...".to_owned(), format!("{more} more")]);
                continue;
            };
            table.row(shown.iter().zip(&best).enumerate().map(|(k, (&place, best))| {
                let text = self.cell(row, place, best.as_deref());
                match best {
                    Some(_) if !text.ends_with(BEST) => text + " ",
                    None if k == 0 => broken(&text, most),
                    _ => text,
                }
            }));
        }
        without_trailing_spaces(&table.text())
    }

    /// Columns as rows, under the first column's cells.
    fn transposed(&self, rows: &Range<usize>, shown: &[usize]) -> String {
        let Some((&first, others)) = shown.split_first() else { return String::new() };
        let names = |row: usize| self.columns[first].text(&self.rows[row][first]);
        let names: Vec<String> = rows.clone().map(|row| names(row) + " ").collect();
        let heads = names.iter().map(|name| (name.as_str(), Align::Right));
        let title = self.columns[first].title();
        let mut table = TextTable::new([(title.as_str(), Align::Left)].into_iter().chain(heads));
        for &place in others {
            let best = self.best(place, rows);
            let cells = rows.clone().map(|row| {
                let text = self.cell(row, place, best.as_deref());
                if text.ends_with(BEST) { text } else { text + " " }
            });
            table.row(std::iter::once(self.columns[place].title()).chain(cells));
        }
        without_trailing_spaces(&table.text())
    }

    /// Each row in lines of its own: short cells in the first one, a long cell below it.
    fn listed(&self, rows: &Range<usize>, short: &[usize], long: &[usize], width: usize) -> String {
        let mut text = String::new();
        for row in self.chosen(rows) {
            let Some(row) = row else {
                text += &format!("  and {} more\n", rows.len() - self.most());
                continue;
            };
            let cell = |place: usize| {
                let title = self.columns[place].title();
                let cell = self.columns[place].text(&self.rows[row][place]);
                if title.is_empty() { cell } else { format!("{title} {cell}") }
            };
            let first: Vec<String> = short.iter().map(|&place| cell(place)).collect();
            text += &folded(&first.join(", "), 2, width);
            for &place in long.iter().filter(|&&place| self.rows[row][place] != Value::Null) {
                let head = &self.columns[place];
                let cell =
                    if head.is_long() { head.text(&self.rows[row][place]) } else { cell(place) };
                match head.format {
                    Format::Command => text += &format!("    {cell}\n"),
                    _ => text += &folded(&cell, 4, width),
                }
            }
        }
        text
    }
}

fn without_trailing_spaces(text: &str) -> String {
    text.lines().map(|line| line.trim_end().to_owned() + "\n").collect()
}

#[cfg(test)]
mod tests {
    use super::super::column::{Column, column, count, flag, number, word};
    use super::*;
    use serde_json::json;

    fn table(rows: usize, columns: usize) -> Table {
        let law = word("law", "law", "");
        let figure = |place: u8| {
            let figure: Column<Value> = number("", "", "m", 1, "").weight(place).more();
            figure.named(format!("figures.{place}"), format!("a figure {place}"))
        };
        let columns = u8::try_from(columns).expect("few");
        let columns: Vec<_> = std::iter::once(law).chain((0..columns).map(figure)).collect();
        let rows: Vec<_> = (0..rows)
            .map(|row| json!({"law": format!("law-{row}"), "figures": vec![row as f64; 20]}))
            .collect();
        Table::new("t", &columns, &rows)
    }

    #[test]
    fn a_wide_table_is_transposed_and_a_long_one_loses_its_heaviest_columns() {
        let upright = table(3, 3).console(80);
        assert!(upright.starts_with("  law    a figure 0, m"), "{upright}");
        assert!(upright.contains("law-2            2.0*"), "{upright}");
        let transposed = table(3, 10).console(80);
        assert!(transposed.starts_with("  law            law-0   law-1   law-2\n"), "{transposed}");
        assert_eq!(transposed.matches('*').count(), 10);
        let chosen = table(20, 10).console(80);
        assert!(
            chosen.contains("a figure 0") && chosen.contains("(on the page: a figure"),
            "{chosen}"
        );
        for text in [upright, transposed, chosen] {
            assert!(widest(&text) <= 80, "{text}");
        }
    }

    #[test]
    fn many_rows_are_shortened_in_the_middle() {
        let text = table(50, 2).most_rows(12).console(80);
        assert!(
            text.contains("38 more") && text.contains("law-49") && !text.contains("law-20"),
            "{text}"
        );
        assert_eq!(text.lines().count(), 14);
        assert!(!table(12, 2).most_rows(12).is_cut() && table(13, 2).most_rows(12).is_cut());
    }

    #[test]
    fn bad_rows_of_a_long_table_are_shown_in_each_of_its_blocks() {
        let columns: [Column<Value>; 3] = [
            word("law", "law", ""),
            count("test", "test", ""),
            flag("ok", "", ("ok", "MISSED"), ""),
        ];
        let row = |place: usize| json!({"law": format!("law {}", place / 100), "test": place, "ok": place % 100 != 57});
        let rows: Vec<_> = (0..1_300).map(row).collect();
        let table = Table::new("Tests", &columns, &rows).blocks("law");
        let text = table.console(80);
        assert_eq!(text.matches("MISSED").count(), 13, "{text}");
        assert!(text.contains("91 more") && text.lines().count() < 160, "{text}");
        let document = super::super::Document::new("x", "X", &()).table(table).console(80);
        assert!(document.ends_with("  (all rows: x.json)\n"), "{document}");
    }

    #[test]
    fn sentences_are_folded_and_commands_are_not() {
        let columns: [Column<Value>; 3] = [
            word("run", "run", ""),
            column("why", "", "", Format::Sentence, ""),
            column("repeat", "", "", Format::Command, ""),
        ];
        let command = format!("timegap run {}", "x".repeat(90));
        let rows = [json!({"run": 7, "why": "because of a ".repeat(9), "repeat": command})];
        let text = Table::new("Failures", &columns, &rows).console(80);
        assert!(text.starts_with("  run 7\n    because of a because"), "{text}");
        assert!(text.contains(&format!("    {command}\n")), "{text}");
    }

    #[test]
    fn long_names_are_broken_where_nothing_else_can_be_left_out() {
        let columns: [Column<Value>; 2] = [word("id", "id", ""), number("x", "x", "m", 1, "")];
        let row = |id: &str| json!({"id": id, "x": 1.5});
        let rows = [row("a.long.name.of.a.figure"), row("b")];
        let text = Table::new("", &columns, &[&rows[..]; 5].concat()).console(24);
        assert!(
            text.starts_with("  id               x, m\n  a.long.name.of.   1.5\n    a.figure\n"),
            "{text}"
        );
        assert!(widest(&text) <= 24, "{text}");
    }

    #[test]
    fn facts_stand_below_each_other_and_long_ones_are_folded() {
        let fact = |name: &str, value: &str| (name.to_owned(), value.to_owned());
        let text = facts(
            &[fact("min gap", "8.25 m"), fact("law", "word word word word word word word word")],
            34,
        );
        let folded = "  law      word word word word\n             word word word word\n";
        assert_eq!(text, format!("  min gap  8.25 m\n{folded}"));
    }

    #[test]
    fn columns_that_cannot_be_narrowed_are_listed() {
        let columns: [Column<Value>; 2] = [word("a", "a", ""), word("b", "b", "")];
        let rows = vec![json!({"a": "x ".repeat(30), "b": "y ".repeat(30)}); 9];
        let text = Table::new("", &columns, &rows).console(60);
        assert!(widest(&text) <= 60, "{text}");
    }
}
