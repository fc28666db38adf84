//! A result for a continuous integration job: as JUnit XML, and as Markdown for its summary. In JUnit XML every row with a
//! verdict is a test case, and the verdict over all is one.

use quick_junit::{NonSuccessKind, Report, TestCase, TestCaseStatus, TestSuite};

use super::document::{Document, Part};
use super::head::{Format, Head};
use super::table::Table;

const MOST_ROWS: usize = 200;

impl Document {
    pub fn junit(&self) -> String {
        let mut report = Report::new(format!("timegap {}", self.command));
        let mut whole = TestSuite::new(self.title.as_str());
        whole.add_test_case(case("verdict", &self.verdict, self.ok));
        report.add_test_suite(whole);
        for part in &self.parts {
            if let Part::Table(table) = part
                && table.has_cases
                && table.columns.iter().any(Head::is_verdict)
            {
                report.add_test_suite(rows(table));
            }
        }
        report.to_string().expect("memory takes all")
    }
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

/// A verdict. Its words are shown where it failed.
fn case(name: &str, words: &str, ok: bool) -> TestCase {
    if ok {
        return TestCase::new(name, TestCaseStatus::success());
    }
    let mut failed = TestCaseStatus::non_success(NonSuccessKind::Failure);
    failed.set_message(words.lines().next().unwrap_or_default()).set_description(words);
    TestCase::new(name, failed)
}

fn rows(table: &Table) -> TestSuite {
    let verdict = table.columns.iter().position(Head::is_verdict).unwrap_or_default();
    let mut suite = TestSuite::new(table.heading.as_str());
    for (row, cells) in table.rows.iter().enumerate() {
        // A row is named by the words and counts that stand before its first verdict or figure.
        let is_key = |place: &usize| {
            !matches!(table.columns[*place].format, Format::Decimals(_) | Format::Exact)
        };
        let keys = (0..verdict).take_while(is_key).filter(|&place| !cells[place].is_null());
        let name: Vec<_> = keys.map(|place| table.columns[place].text(&cells[place])).collect();
        let name = if name.is_empty() { format!("row {}", row + 1) } else { name.join(", ") };
        let shown = table.columns.iter().zip(cells).filter(|(_, cell)| !cell.is_null());
        let words = shown.map(|(head, cell)| format!("{} = {}", head.title(), head.text(cell)));
        let words: Vec<_> = words.collect();
        suite.add_test_case(case(&name, &words.join("\n"), table.is_good(row)));
    }
    suite
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

#[cfg(test)]
mod tests {
    use serde_json::json;

    use super::super::{Column, flag, word};
    use super::*;

    #[test]
    fn every_row_with_a_verdict_is_a_case_with_its_words() {
        let columns: [Column<serde_json::Value>; 2] =
            [word("law", "law", ""), flag("ok", "verdict", ("ok", "MISSED"), "")];
        let rows =
            [json!({"law": "a & <b>", "ok": true}), json!({"law": "c\u{1}\"é", "ok": false})];
        let document = Document::new("x", "Laws \u{1}> 1", &json!({}))
            .verdict(false, "1 of 2 laws")
            .table(Table::new("Rows", &columns, &rows));
        let text = document.junit();
        let read = Report::deserialize_from_str(&text).unwrap_or_else(|e| panic!("{e}: {text}"));
        assert_eq!((read.tests, read.failures, read.errors), (3, 2, 0), "{text}");
        let [whole, of_rows] = read.test_suites.as_slice() else { panic!("{text}") };
        assert_eq!((whole.name.as_str(), whole.failures), ("Laws > 1", 1));
        let cases = &of_rows.test_cases;
        let names: Vec<_> = cases.iter().map(|case| case.name.as_str()).collect();
        assert_eq!(names, ["a & <b>", "c\"é"]);
        let TestCaseStatus::NonSuccess { message, description, .. } = &cases[1].status else {
            panic!("{text}")
        };
        assert_eq!(message.as_deref(), Some("law = c\"é"));
        assert_eq!(description.as_deref(), Some("law = c\"é\nverdict = MISSED"));
    }
}
