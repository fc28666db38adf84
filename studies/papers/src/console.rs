//! The rows on the console: 80 columns, without what only the page has room for.

use super::row::{Kind, Row, Verdict};
use super::tally::{in_words, tally};
use report::chart::number;
use report::table::{Align, NONE, TextTable};

/// Width of the console, in characters.
const COLUMNS: usize = 80;
/// Longest id that leaves room for the other columns.
const ID_COLUMNS: usize = 32;

/// The rows of a paper, set by set and kind by kind.
pub fn table(name: &str, rows: &[Row]) -> String {
    let mut text = folded(&format!("{name}: {} within", in_words(&tally(rows))), 0);
    for rows in rows.chunk_by(|a, b| a.set == b.set) {
        if !rows[0].set.is_empty() {
            let heading = format!("{}: {} within", rows[0].set, in_words(&tally(rows)));
            text.push_str(&folded(&heading, 2));
        }
        let inferred = inferred(rows);
        for kind in [Kind::Paper, Kind::Reconstruction, Kind::Requirement] {
            let rows = rows.iter().filter(|row| row.kind == kind);
            let mut table = TextTable::new([
                (kind.name(), Align::Left),
                ("ours", Align::Right),
                ("expected", Align::Right),
                ("", Align::Left),
                ("", Align::Left),
                ("", Align::Left),
                ("", Align::Left),
            ]);
            let mut is_empty = true;
            for row in rows {
                table.row(cells(row, &inferred));
                is_empty = false;
            }
            if !is_empty {
                text.push_str(&table.text());
            }
        }
        for (index, inferred) in inferred.iter().enumerate() {
            text.push_str(&folded(&format!("[{}] inferred: {inferred}", index + 1), 2));
        }
    }
    text
}

/// Inferred values behind these rows, in the order of their numbers.
fn inferred(rows: &[Row]) -> Vec<&'static str> {
    let mut values: Vec<_> = Vec::new();
    for value in rows.iter().filter_map(|row| row.inferred) {
        if !values.contains(&value) {
            values.push(value);
        }
    }
    values
}

fn cells(row: &Row, inferred: &[&str]) -> [String; 7] {
    let mark = match row.verdict() {
        Verdict::Within => "ok",
        Verdict::Outside => "OUTSIDE",
        Verdict::Shown => "",
    };
    let number_of = |value| inferred.iter().position(|known| *known == value);
    let inferred = row.inferred.and_then(number_of);
    [
        in_two_lines(&row.id),
        row.ours.map_or_else(|| NONE.into(), |ours| number(ours, 2)),
        row.expectation().replace("at most", "≤").replace("at least", "≥"),
        row.tolerance_in_words(),
        row.unit.to_owned(),
        mark.to_owned(),
        inferred.map_or_else(String::new, |index| format!("[{}]", index + 1)),
    ]
}

/// Words in lines that fit, indented; the lines after the first two more.
fn folded(words: &str, indent: usize) -> String {
    let mut lines = vec![" ".repeat(indent)];
    for word in words.split(' ') {
        let line = lines.last().expect("there is a first line");
        let is_empty = line.trim().is_empty();
        if !is_empty && line.chars().count() + 1 + word.chars().count() > COLUMNS {
            lines.push(" ".repeat(indent + 2) + word);
        } else {
            let space = if is_empty { "" } else { " " };
            let line = lines.last_mut().expect("there is a first line");
            *line += &format!("{space}{word}");
        }
    }
    lines.join("\n") + "\n"
}

/// The id, in two lines at a dot where it is long.
fn in_two_lines(id: &str) -> String {
    if id.chars().count() <= ID_COLUMNS {
        return id.to_owned();
    }
    match id.match_indices('.').map(|(at, _)| at).rfind(|at| *at < ID_COLUMNS) {
        Some(at) => format!("{}\n  {}", &id[..=at], &id[at + 1..]),
        None => id.to_owned(),
    }
}

#[cfg(test)]
mod tests {
    use super::super::row::{Tolerance, paper, requirement, within};
    use super::*;

    const TENTH: Tolerance = within(0.1, "a reason");

    #[test]
    fn a_row_outside_its_tolerance_is_not_hidden() {
        let text = table("cacc", &[Row::near("A.x", "s", paper(4.0), Some(3.0), TENTH)]);
        assert!(text.contains("0 of 1") && text.contains("OUTSIDE"), "{text}");
    }

    #[test]
    fn only_what_the_paper_prints_is_called_the_papers() {
        let text = table("predictive", &[Row::near("a", "s", requirement(4.0), Some(4.0), TENTH)]);
        assert!(!text.contains("paper"), "{text}");
    }

    #[test]
    fn a_set_an_inferred_value_and_a_long_id_fit_in_eighty_columns() {
        let id = "dynamic-programming.above_full_route_generated";
        let row = |id| {
            Row::at_most(id, "m/s²", requirement(-123.0), Some(-122.0), TENTH)
                .in_set("joint weights")
                .depending_on("the desired distance keeps its first value, v t_h + d_b = 34.5 m")
                .with_source("a long sentence of the paper that only the page has room for")
                .with_note("a long note that only the page has room for, and the JSON")
        };
        let text = table("predictive", &[row(id), row("x")]);
        assert!(text.lines().all(|line| line.chars().count() <= COLUMNS), "{text}");
        assert!(text.contains("joint weights: ") && text.contains("[1] inferred"), "{text}");
    }
}
